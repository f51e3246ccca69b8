//! What a call reads and writes: only files, none over another, the old one or the new one and never half of either.
#![cfg(unix)]

use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt};
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use crate::bad_input::{cuboid, stl};
use crate::pipeline::fixture;
use crate::support::{Command, PATIENCE, SmallDisk, fails, first_error, folder, said, skip, trunnion};

/// Runs `command`, which must end by itself: what hangs is a failure, not a test without end.
#[track_caller]
fn ended(command: &mut Command) -> Output {
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let end = Instant::now() + PATIENCE;
    while child.try_wait().unwrap().is_none() {
        if Instant::now() > end {
            child.kill().unwrap();
            panic!("{command:?} does not end");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let output = child.wait_with_output().unwrap();
    command.heard(&output);
    output
}

/// What is said from the error on by a call in `folder` that must be refused.
#[track_caller]
fn refused(folder: &Path, args: &[&str]) -> String {
    let run = ended(trunnion().args(args).current_dir(folder));
    assert_eq!(run.status.code(), Some(2), "{args:?}: {}", said(&run));
    let text = String::from_utf8(run.stderr).unwrap();
    assert!(!text.contains("panicked"), "{text}");
    first_error(&text);
    text[text.find("error").unwrap()..].to_owned()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// A folder with a pipe, a socket, a folder and a link to the device that swallows everything.
fn no_files() -> tempfile::TempDir {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    assert!(Command::new("mkfifo").arg(at("a-pipe")).status().unwrap().success());
    drop(UnixListener::bind(at("a-socket")).unwrap());
    std::fs::create_dir(at("a-folder")).unwrap();
    std::os::unix::fs::symlink("/dev/null", at("a-device")).unwrap();
    folder
}

const KINDS: [&str; 4] = ["a-pipe", "a-socket", "a-folder", "a-device"];

/// Every output of every verb, behind inputs that are not there: what is said of the output comes before all work.
const OUTPUTS: [&[&str]; 10] = [
    &["prepare", "gone.stl", "-m", "generic-ac", "-o"],
    &["prepare", "gone.stl", "-m", "generic-ac", "-o", "x.gcode", "--plan-out"],
    &["prepare", "gone.stl", "-m", "generic-ac", "-o", "x.gcode", "--port", "tcp:127.0.0.1:9", "--journal"],
    &["plan", "gone.stl", "-m", "generic-ac", "-o"],
    &["plan", "gone.stl", "-m", "generic-ac", "--sheet"],
    &["orient", "gone.stl", "-o"],
    &["orient", "gone.stl", "--landscape"],
    &["orient", "gone.stl", "--view"],
    &["rewrite", "gone.gcode", "--plan", "gone.json", "-o"],
    &["send", "gone.gcode", "--plan", "gone.json", "--port", "tcp:127.0.0.1:9", "--journal"],
];

#[test]
fn no_verb_writes_onto_what_is_no_file() {
    let folder = no_files();
    let before = names(folder.path());
    for kind in KINDS {
        let wanted = format!("file/no-output: {kind} | {}", kind.replace('-', " "));
        for args in OUTPUTS {
            let text = refused(folder.path(), &[args, &[kind]].concat());
            assert!(fails(&text, &wanted), "{args:?}: {text}");
        }
        let log = refused(folder.path(), &["simulate", "-m", "generic-ac", "--link", "tcp:0", "--log", kind]);
        assert!(fails(&log, &wanted), "{log}");
    }
    for device in ["/dev/null", "/dev/stdout"] {
        let text = refused(folder.path(), &["plan", &fixture("cube"), "-m", "generic-ac", "-o", device]);
        assert!(fails(&text, &format!("file/no-output: {device}")), "{text}");
    }
    assert!(std::fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    assert_eq!(names(folder.path()), before);
}

#[test]
fn no_verb_reads_what_is_no_file() {
    let folder = no_files();
    let plan = folder.path().join("plan.json").display().to_string();
    assert!(trunnion().args(["plan", &fixture("cube"), "-m", "generic-ac", "-o", &plan]).status().unwrap().success());
    for kind in KINDS {
        let wanted = format!("file/not-a-file: {kind} | {}", kind.replace('-', " "));
        let profile = format!("./{kind}");
        let cube = fixture("cube");
        let calls: [&[&str]; 9] = [
            &["inspect", kind],
            &["orient", kind],
            &["plan", kind, "-m", "generic-ac"],
            &["prepare", &cube, "-m", "generic-ac", "-o", "x.gcode", "--slicer-config", kind],
            &["profile", "check", &profile],
            &["slice", kind, "-o", "slots"],
            &["rewrite", kind, "--plan", &plan, "-o", "x.gcode"],
            &["verify", kind, "--plan", &plan],
            &["send", kind, "--dry-run", "--unverified", "-m", "generic-ac"],
        ];
        for args in calls {
            let text = refused(folder.path(), args);
            // A folder of models is planned and oriented once it is said where the results go.
            let usage = matches!(args[0], "orient" | "plan") && kind == "a-folder";
            let wanted = if usage { "command/usage: a-folder".to_owned() } else { wanted.clone() };
            assert!(fails(&text, &wanted), "{args:?}: {text}");
        }
    }
}

#[test]
fn an_output_is_never_an_input_or_another_output_of_the_call() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let bytes = stl(&cuboid([0.0; 3], [10.0; 3]));
    std::fs::write(at("model.stl"), &bytes).unwrap();
    std::fs::hard_link(at("model.stl"), at("hard.stl")).unwrap();
    std::os::unix::fs::symlink("model.stl", at("soft.stl")).unwrap();
    std::os::unix::fs::symlink("not-yet", at("ahead")).unwrap();
    std::fs::write(at("mine.toml"), "extends = \"generic-ac\"\n").unwrap();
    let refused = |args: &[&str]| refused(folder.path(), args);
    for other in ["model.stl", "./model.stl", "hard.stl", "soft.stl"] {
        for args in [
            &["plan", "model.stl", "-m", "generic-ac", "--sheet"][..],
            &["plan", "model.stl", "-m", "generic-ac", "-o"],
            &["prepare", "model.stl", "-m", "generic-ac", "-o"],
            &["prepare", "model.stl", "-m", "generic-ac", "-o", "x", "--plan-out"],
            &["orient", "model.stl", "--view"],
        ] {
            let text = refused(&[args, &[other]].concat());
            assert!(fails(&text, &format!("file/twice: {other} | input")), "{args:?}: {text}");
        }
    }
    let twice: [&[&str]; 5] = [
        &["plan", "model.stl", "-m", "generic-ac", "-o", "x", "--sheet", "./x"],
        &["plan", "model.stl", "-m", "generic-ac", "-o", "ahead", "--sheet", "./not-yet"],
        &["prepare", "model.stl", "-m", "generic-ac", "-o", "x", "--plan-out", "x"],
        &["prepare", "model.stl", "-m", "generic-ac", "-o", "x", "--port", "tcp:127.0.0.1:9", "--journal", "x"],
        &["orient", "model.stl", "-o", "x", "--landscape", "x"],
    ];
    for args in twice {
        assert!(fails(&refused(args), "file/twice: another output"), "{args:?}");
    }
    let profile = refused(&["plan", "model.stl", "-m", "./mine.toml", "-o", "mine.toml"]);
    assert!(fails(&profile, "file/twice: mine.toml | input"), "{profile}");
    let log = ["simulate", "-m", "./mine.toml", "--link", "tcp:0", "--log", "mine.toml"];
    assert!(fails(&refused(&log), "file/twice: mine.toml | input"));

    let made = ["plan", "model.stl", "-m", "generic-ac", "-o", "plan.json"];
    assert!(trunnion().args(made).current_dir(folder.path()).status().unwrap().success());
    std::fs::write(at("sliced.gcode"), "G1 X1\n").unwrap();
    for output in ["sliced.gcode", "plan.json", "model.stl"] {
        let text = refused(&["rewrite", "sliced.gcode", "--plan", "plan.json", "-o", output]);
        assert!(fails(&text, &format!("file/twice: {output} | input")), "{text}");
    }
    for given in ["plan.json", "model.stl"] {
        let text = refused(&["rewrite", "--in-place", "--plan", "plan.json", given]);
        assert!(fails(&text, &format!("file/twice: {given} | input")), "{text}");
    }
    let send = ["send", "sliced.gcode", "--plan", "plan.json", "--port", "tcp:127.0.0.1:9", "--journal"];
    for journal in ["sliced.gcode", "plan.json", "hard.stl"] {
        let text = refused(&[&send[..], &[journal]].concat());
        assert!(fails(&text, &format!("file/twice: {journal} | input")), "{text}");
    }
    std::fs::rename(at("model.stl"), at("project.3mf")).unwrap();
    let slice = ["slice", "plan.json", "--model", "project.3mf", "--meshes-only", "-o", "."];
    assert!(fails(&refused(&slice), "file/twice: project.3mf | input"));
    assert!(std::fs::read(at("hard.stl")).unwrap() == bytes, "the model was written over");
    let left = ["ahead", "hard.stl", "mine.toml", "plan.json", "project.3mf", "sliced.gcode", "soft.stl"];
    let all = names(folder.path());
    assert!(all.iter().all(|name| left.contains(&name.as_str()) || name.starts_with("print-00")), "{all:?}");
}

#[test]
fn a_link_is_written_through_and_mode_bits_stay() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("real")).unwrap();
    std::fs::write(at("real/plan.json"), "old").unwrap();
    std::fs::set_permissions(at("real/plan.json"), std::fs::Permissions::from_mode(0o640)).unwrap();
    std::os::unix::fs::symlink("real/plan.json", at("link")).unwrap();
    std::os::unix::fs::symlink("real/new.json", at("ahead")).unwrap();
    for link in ["link", "ahead"] {
        let run = trunnion().args(["plan", &fixture("cube"), "-m", "generic-ac", "-o"]).arg(at(link)).output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
        assert!(std::fs::symlink_metadata(at(link)).unwrap().is_symlink());
    }
    let plan = std::fs::read(at("real/plan.json")).unwrap();
    assert!(plan.len() > 100 && plan == std::fs::read(at("real/new.json")).unwrap());
    assert_eq!(std::fs::metadata(at("real/plan.json")).unwrap().mode() & 0o7777, 0o640);
    std::fs::write(at("plain"), "").unwrap();
    let usual = std::fs::metadata(at("plain")).unwrap().mode();
    assert_eq!(std::fs::metadata(at("real/new.json")).unwrap().mode(), usual, "as any new file");

    // What a slicer's script is given may be a link: the file behind it must not stay printable.
    std::fs::write(at("real/upright.gcode"), "G1 X1 Y1 E1\n").unwrap();
    std::os::unix::fs::symlink("real/upright.gcode", at("given.gcode")).unwrap();
    let hook = trunnion().args(["rewrite", "--in-place", "--plan"]).arg(at("link")).arg(at("given.gcode")).output();
    assert_eq!(hook.unwrap().status.code(), Some(2));
    let text = std::fs::read_to_string(at("real/upright.gcode")).unwrap();
    assert!(text.starts_with("; trunnion: ") && !text.contains("G1"), "{text}");
    assert!(std::fs::symlink_metadata(at("given.gcode")).unwrap().is_symlink());
    assert_eq!(names(&at("real")), ["new.json", "plan.json", "upright.gcode"]);
}

#[test]
fn what_may_not_be_written_stays_as_it_was() {
    let folder = folder();
    let old = folder.path().join("old.json");
    std::fs::write(&old, "old").unwrap();
    std::fs::set_permissions(&old, std::fs::Permissions::from_mode(0o444)).unwrap();
    let text = refused(folder.path(), &["plan", "gone.stl", "-m", "generic-ac", "-o", "old.json"]);
    assert!(fails(&text, "file/protected: old.json"), "{text}");
    assert_eq!((std::fs::read_to_string(&old).unwrap().as_str(), names(folder.path()).len()), ("old", 1));
    if cfg!(target_os = "linux") {
        let text = refused(folder.path(), &["plan", "gone.stl", "-m", "generic-ac", "-o", "/proc/plan.json"]);
        assert!(fails(&text, "file/write: /proc/plan.json"), "{text}");
    }
}

#[test]
fn a_full_disk_leaves_the_old_file_and_nothing_else() {
    let folder = folder();
    let Some(disk) = SmallDisk::mount(folder.path().join("small"), 65_536) else {
        skip("a full disk under a plan: this user may not mount a small file system");
        return;
    };
    std::fs::write(disk.0.join("plan.json"), "old").unwrap();
    std::fs::write(disk.0.join("upright.gcode"), "G1 X1 Y1 E1\n").unwrap();
    let _ = std::fs::write(disk.0.join("filler"), [1; 70_000]);
    let (cube, plan) = (fixture("cube"), disk.0.join("plan.json").display().to_string());
    let text = refused(folder.path(), &["plan", &cube, "-m", "generic-ac", "-o", &plan]);
    assert!(fails(&text, "file/write: plan.json | disk"), "{text}");
    assert_eq!(std::fs::read_to_string(&plan).unwrap(), "old");
    let upright = disk.0.join("upright.gcode").display().to_string();
    refused(folder.path(), &["rewrite", "--in-place", "--plan", &plan, &upright]);
    assert!(!std::fs::read_to_string(&upright).unwrap().contains("G1"), "still printable");
    assert_eq!(names(&disk.0), ["filler", "plan.json", "upright.gcode"]);
}

#[test]
fn a_result_that_does_not_arrive_is_said_and_a_reader_that_leaves_is_none() {
    let cube = fixture("cube");
    if Path::new("/dev/full").exists() {
        for args in [&["inspect", &cube, "--json"][..], &["profile", "list"], &["--help"], &["--version"]] {
            let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
            let run = trunnion().args(args).stdout(full).output().unwrap();
            assert_eq!(run.status.code(), Some(2), "{args:?}: {}", said(&run));
            assert!(fails(&said(&run), "command/stdout: stdout"), "{}", said(&run));
        }
    } else {
        skip("a result onto a full device: this system has none");
    }
    for args in [&["inspect", &cube, "--json"][..], &["--help"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let run = trunnion().args(args).stdout(writer).output().unwrap();
        assert_eq!((run.status.code(), said(&run).trim()), (Some(0), ""), "{args:?}");
    }
}
