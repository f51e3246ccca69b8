//! Bad input gets one clear sentence with file, place, value and remedy, exit code 2 (or 1, 3), and nothing half-written.

use std::path::Path;

use crate::pipeline::{fixture, prepare};
use crate::support::{fails, first_error, folder, said, states, trunnion, wait_for};

/// Runs `prepare` on `model`, which must fail with exit code `code` and leave no file; what is said from the error on.
#[track_caller]
fn refused(model: &str, code: i32, more: &[&str]) -> String {
    let folder = folder();
    let output = folder.path().join("out.gcode");
    let run = trunnion()
        .args(["prepare", model, "--slicer", "builtin", "-q", "-o"])
        .arg(&output)
        .args(if more.contains(&"-m") { vec![] } else { vec!["-m", "generic-ac"] })
        .args(more)
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(code), "{}", said(&run));
    assert!(std::fs::read_dir(folder.path()).unwrap().next().is_none(), "something was left behind");
    let text = String::from_utf8(run.stderr).unwrap();
    assert!(!first_error(&text).1.ends_with('.') && !text.contains("panicked"), "{text}");
    text[text.find("error[").unwrap_or(0)..].to_owned()
}

fn file(folder: &Path, name: &str, bytes: &[u8]) -> String {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path.display().to_string()
}

/// A binary STL of the facets.
pub(crate) fn stl(facets: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((facets.len() as u32).to_le_bytes());
    for facet in facets {
        bytes.extend([0; 12]);
        facet.iter().flatten().for_each(|v| bytes.extend(v.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// The facets of a box.
pub(crate) fn cuboid(min: [f32; 3], max: [f32; 3]) -> Vec<[[f32; 3]; 3]> {
    let corner = |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 0 { min[a] } else { max[a] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]].map(|t| t.map(corner))).collect()
}

#[test]
fn missing_empty_and_truncated_files() {
    let folder = folder();
    assert!(fails(&refused("no-such.stl", 2, &[]), "input/absent: no-such.stl"));
    assert!(fails(&refused(&file(folder.path(), "empty.stl", b""), 2, &[]), "mesh/empty: empty.stl"));
    let whole = stl(&cuboid([0.0; 3], [10.0; 3]));
    let cut = refused(&file(folder.path(), "cut.stl", &whole[..whole.len() - 7]), 2, &[]);
    assert!(fails(&cut, "mesh/truncated: cut.stl | 677 | 684"), "{cut}");
    let mut hostile = whole.clone();
    hostile[80..84].copy_from_slice(&4_000_000_000u32.to_le_bytes());
    let text = refused(&file(folder.path(), "hostile.stl", &hostile), 2, &[]);
    assert!(fails(&text, "mesh/truncated: hostile.stl | 4000000000"), "{text}");
    let noise = refused(&file(folder.path(), "noise.stl", b"this is not a mesh at all"), 2, &[]);
    assert!(fails(&noise, "mesh/truncated: noise.stl | 25 | 84"), "{noise}");
}

#[test]
fn numbers_that_are_none_and_surfaces_that_do_not_close() {
    let folder = folder();
    let mut facets = cuboid([0.0; 3], [10.0; 3]);
    facets[3][1][2] = f32::NAN;
    assert!(fails(&refused(&file(folder.path(), "nan.stl", &stl(&facets)), 2, &[]), "mesh/not-finite: nan.stl | NaN"));
    let mut open = cuboid([0.0; 3], [10.0; 3]);
    open.remove(5);
    let text = refused(&file(folder.path(), "open.stl", &stl(&open)), 2, &["--no-repair"]);
    assert!(fails(&text, "mesh/open: open.stl | 3 | --repair off"), "{text}");
    let flat =
        [[[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]], [[0.0, 0.0, 0.0], [0.0, 10.0, 0.0], [10.0, 0.0, 0.0]]];
    let flat = refused(&file(folder.path(), "flat.stl", &stl(&flat)), 2, &[]);
    assert!(fails(&flat, "mesh/flat: flat.stl | part 0"), "{flat}");
}

#[test]
fn a_mended_model_is_printed() {
    let folder = folder();
    let mut open = cuboid([0.0; 3], [10.0; 3]);
    open.remove(5);
    let model = file(folder.path(), "open.stl", &stl(&open));
    prepare(&model, "generic-ac", "builtin", &folder.path().join("x.gcode"), &[]);
}

#[test]
fn parts_that_float_stand_over_the_rim_or_are_higher_than_the_machine() {
    let folder = folder();
    let floating = [cuboid([0.0; 3], [10.0; 3]), cuboid([20.0, 0.0, 5.0], [30.0, 10.0, 15.0])].concat();
    let text = refused(&file(folder.path(), "floating.stl", &stl(&floating)), 2, &[]);
    assert!(fails(&text, "plan/floating: part 1"), "{text}");
    let wide = refused(&file(folder.path(), "wide.stl", &stl(&cuboid([0.0; 3], [300.0, 20.0, 10.0]))), 2, &[]);
    assert!(fails(&wide, "strategy/room-elsewhere: part 0 | 52.3 mm | -m fibr3d"), "{wide}");
    let high = refused(&file(folder.path(), "high.stl", &stl(&cuboid([0.0; 3], [20.0, 20.0, 400.0]))), 2, &[]);
    assert!(fails(&high, "table/too-high: 400.0 mm | 320.0 mm"), "{high}");
}

#[test]
fn an_object_without_a_plan_says_why_with_numbers() {
    let text = refused(&fixture("two-boxes"), 1, &["-m", "fibr3d", "--origin=-60,0"]);
    assert!(fails(&text, "plan/no-plan: part 1 | mm"), "{text}");
    let args = ["plan", &fixture("two-boxes"), "-m", "fibr3d", "--origin=-60,0", "--json"];
    let run = trunnion().args(args).output().unwrap();
    assert_eq!(run.status.code(), Some(1));
    let document: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    for key in ["part", "orientation", "blocked_by", "depth_mm"] {
        assert!(!document["reasons"][0][key].is_null(), "{key}");
    }
    let reach = |r: &serde_json::Value| r["text"].as_str().unwrap().contains("range -50..285");
    assert!(document["reasons"].as_array().unwrap().iter().any(reach), "{document}");
}

/// Scripts read stdout: an error is one document there, on one line, with the sentence of stderr and the exit code; what has a document of its own
/// (findings, reasons) has only that.
#[test]
fn an_error_is_a_document_too() {
    let missing = folder().path().join("none.stl").display().to_string();
    let cases: [&[&str]; 5] = [
        &["inspect", &missing],
        &["plan", &fixture("cube"), "-m", "generic-a"],
        &["plan", &fixture("cube"), "-m", "generic-ac", "--overhang", "100"],
        &["plan", &fixture("cube"), "--overhang"],
        &["send", &missing, "--port", "none", "-m", "generic-ac", "--unverified"],
    ];
    for args in cases {
        let run = trunnion().args(args).arg("--json").output().unwrap();
        let document: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap_or_else(|_| panic!("{args:?}"));
        let error = document["error"].as_str().unwrap();
        assert!(first_error(&said(&run)).1 == error && !error.contains('\n'), "{args:?}: {document}");
        assert_eq!((document["exit"].as_i64(), run.status.code()), (Some(2), Some(2)), "{args:?}");
        let silent = trunnion().args(args).output().unwrap();
        assert!(silent.stdout.is_empty(), "{args:?}");
    }
}

#[test]
fn a_file_in_metres_is_read_with_a_warning() {
    let folder = folder();
    let model = file(folder.path(), "metres.stl", &stl(&cuboid([0.0; 3], [0.02, 0.02, 0.03])));
    let run = trunnion().args(["inspect", &model, "--json"]).output().unwrap();
    let document: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(document["unit"], "m");
    assert!(String::from_utf8_lossy(&run.stderr).contains("--unit mm"), "{}", said(&run));
    let run = trunnion().args(["inspect", &model, "--unit", "parsec"]).output().unwrap();
    assert_eq!(run.status.code(), Some(2));
}

#[test]
fn profiles_with_unknown_keys_and_plans_of_other_models() {
    let folder = folder();
    let profile = file(folder.path(), "mine.toml", b"extends = \"generic-ac\"\n[kinematics.tilt]\nmaxdeg = 80\n");
    let text = refused(&fixture("cube"), 2, &["-m", &profile]);
    assert!(fails(&text, "profile/unknown-key: mine.toml:3 | kinematics.tilt.max_deg"), "{text}");
    let unknown = refused(&fixture("cube"), 2, &["-m", "generic-ax"]);
    assert!(fails(&unknown, "profile/no-such-profile: \"generic-ax\" | \"generic-ac\""), "{unknown}");

    let plan = folder.path().join("plan.json").display().to_string();
    let made = trunnion().args(["plan", &fixture("cube"), "-m", "generic-ac", "-o", &plan]).output().unwrap();
    assert!(made.status.success(), "{}", said(&made));
    let other = trunnion()
        .args(["slice", &plan, "--model", &fixture("ding"), "--slicer", "builtin", "-o"])
        .arg(folder.path().join("slots"))
        .output()
        .unwrap();
    assert_eq!(other.status.code(), Some(2));
    assert!(fails(&said(&other), "plan-file/stale: model | cube.stl"), "{}", said(&other));
    let stale =
        trunnion().args(["slice", &plan, "-m", "fibr3d", "-o"]).arg(folder.path().join("slots")).output().unwrap();
    assert!(
        stale.status.code() == Some(2) && fails(&said(&stale), "plan-file/stale: profile generic-ac"),
        "{}",
        said(&stale)
    );
    assert!(!folder.path().join("slots").exists());
}

#[test]
fn what_no_machine_can_be_is_not_called_fine() {
    let folder = folder();
    let profile = file(folder.path(), "mine.toml", b"extends = \"generic-ac\"\n[process]\nnozzle_mm = -3\n");
    let check = trunnion().args(["profile", "check", &profile]).output().unwrap();
    assert_eq!(check.status.code(), Some(2), "{}", said(&check));
    assert!(
        fails(&said(&check), "profile/range: mine.toml:3 | process.nozzle_mm | -3 | 0.1..2 mm"),
        "{}",
        said(&check)
    );
    let gcode = file(folder.path(), "x.gcode", b"G28\n");
    let send = ["send", &gcode, "--unverified", "-m", "generic-ac", "--dry-run", "--baud", "0"];
    let send = trunnion().args(send).output().unwrap();
    assert_eq!(send.status.code(), Some(2), "{}", said(&send));
    assert!(fails(&said(&send), "setting/number: --baud 0 | 300..12000000"), "{}", said(&send));
}

#[test]
fn numbers_are_refused_in_plain_words() {
    for (flag, value, words) in [
        ("--overhang", "abc", "command/usage: 'abc' | '--overhang <DEG>'"),
        ("--budget", "1.5", "command/usage: '1.5' | '--budget <STEPS>'"),
        ("--seed", "", "command/usage: '' | '--seed <SEED>'"),
    ] {
        let text = refused("x.stl", 2, &["-m", "generic-ac", flag, value]);
        assert!(fails(&text, words), "{text}");
    }
}

#[test]
fn a_slicer_that_fails_hangs_or_drops_the_part_is_exit_code_three() {
    let folder = folder();
    let fake = |name: &str, body: &str| {
        use std::os::unix::fs::PermissionsExt;
        let head =
            "#!/bin/sh\ncase \"$1\" in --help|--version|-h) echo 'PrusaSlicer-2.5.0 based on Slic3r'; exit 0;; esac\n";
        let path = file(folder.path(), name, format!("{head}{body}\n").as_bytes());
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        path
    };
    let run = |path: &str, more: &[&str]| {
        let output = folder.path().join("out.gcode");
        let run = trunnion()
            .args(["prepare", &fixture("cube"), "-m", "generic-ac", "--slicer", path, "-q", "-o"])
            .arg(&output)
            .args(more)
            .output()
            .unwrap();
        assert!(!output.exists());
        (run.status.code(), said(&run))
    };
    let (code, text) = run(&fake("fails", "echo 'no layers were detected' >&2; exit 1"), &[]);
    assert_eq!(code, Some(3), "{text}");
    // The slicer's own words.
    assert!(fails(&text, "slice/failed: PrusaSlicer | no layers were detected"), "{text}");
    let (code, text) = run(&fake("hangs", "sleep 60"), &["--slicer-timeout", "1"]);
    assert!(code == Some(3) && fails(&text, "slice/timed-out: PrusaSlicer | 1.0 s"), "{text}");
    let (code, text) = run(&fake("silent", "exit 0"), &[]);
    assert!(code == Some(3) && fails(&text, "slice/no-output: PrusaSlicer"), "{text}");
    // Neither a name nor a program.
    let (_, text) = run("bultin", &[]);
    assert!(fails(&text, "slice/unknown-slicer: \"bultin\" | builtin"), "{text}");
}

/// Whoever names no slicer is not left alone with one that happens to be installed and does not work.
#[cfg(unix)]
#[test]
fn a_slicer_that_nobody_asked_for_and_that_fails_is_replaced() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let head =
        "#!/bin/sh\ncase \"$1\" in --help|--version|-h) echo 'PrusaSlicer-2.5.0 based on Slic3r'; exit 0;; esac\n";
    let path = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap());
    let far = "for word; do [ \"$last\" = --output ] && out=$word; last=$word; done\n\
               printf ';LAYER_CHANGE\\nG90\\nM83\\nG1 Z0.2 F900\\nG1 X5 Y5\\nG1 X9 Y5 E1\\n' > \"$out\"";
    for (body, fact) in [
        ("echo 'no layers were detected' >&2; exit 1", "no layers were detected"),
        ("exit 0", "no file"),
        (far, "110.00 mm"),
    ] {
        let slicer = file(folder.path(), "prusa-slicer", format!("{head}{body}\n").as_bytes());
        std::fs::set_permissions(&slicer, std::fs::Permissions::from_mode(0o755)).unwrap();
        let out = folder.path().join("out.gcode");
        let run = trunnion()
            .args(["prepare", &fixture("cube"), "-m", "generic-ac", "-o"])
            .arg(&out)
            .env("PATH", &path)
            .output()
            .unwrap();
        let text = said(&run);
        assert!(run.status.success() && out.exists(), "{text}");
        assert!(states(&text, &format!("warning: PrusaSlicer | {fact} | built-in")), "{text}");
        std::fs::remove_file(out).unwrap();
    }
}

/// A slicer's files, and the slicer, go with the command, whatever it is doing when it is interrupted.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_ends_the_slicer_and_leaves_nothing() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let script = "#!/bin/sh\nhere=\"$(dirname \"$0\")\"\n\
        if [ \"$1\" = --help ]; then touch \"$here/asked\"; echo 'PrusaSlicer-2.5.0 based on Slic3r'; exit 0; fi\n\
        sleep 600 & echo $! > \"$here/child.new\"; mv \"$here/child.new\" \"$here/child\"; wait\n";
    let slicer = file(folder.path(), "fake", script.as_bytes());
    std::fs::set_permissions(&slicer, std::fs::Permissions::from_mode(0o755)).unwrap();
    std::fs::create_dir(at("temporary")).unwrap();
    let interrupted = |model: &str, mark: &str, signal: &str| {
        let mut command = trunnion();
        command.args(["prepare", &fixture(model), "-m", "generic-ac", "--slicer", &slicer, "-q", "-o"]);
        command.arg(at("out.gcode")).env("TMPDIR", at("temporary")).stderr(std::process::Stdio::piped());
        let mut child = command.spawn().unwrap();
        wait_for(mark, || {
            assert!(child.try_wait().unwrap().is_none(), "ended before {mark} came");
            at(mark).exists()
        });
        assert!(std::process::Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        let run = child.wait_with_output().unwrap();
        assert_eq!(run.status.code(), Some(130), "{}", said(&run));
        assert!(said(&run).contains(": interrupted"), "{}", said(&run));
        assert_eq!(std::fs::read_dir(at("temporary")).unwrap().count(), 0, "{signal}: files are left");
        assert!(!at("out.gcode").exists());
    };
    for signal in ["-INT", "-TERM"] {
        interrupted("cube", "child", signal);
        let child = std::fs::read_to_string(at("child")).unwrap();
        // It has been killed, and dies when it is its turn.
        wait_for(&format!("{signal}: the end of the slicer's child"), || {
            let status = std::fs::read_to_string(format!("/proc/{}/status", child.trim())).unwrap_or_default();
            status.is_empty() || status.contains("State:\tZ")
        });
        // While it is asked what it is, or in the planning behind that.
        std::fs::remove_file(at("asked")).unwrap();
        interrupted("candelabrum", "asked", signal);
        std::fs::remove_file(at("child")).unwrap();
    }
}

#[test]
fn a_file_of_an_earlier_run_does_not_pass_for_the_result_of_a_failed_one() {
    let folder = folder();
    let output = folder.path().join("out.gcode");
    prepare(&fixture("cube"), "generic-ac", "builtin", &output, &[]);
    let run = trunnion().args(["prepare", "gone.stl", "-m", "generic-ac", "-o"]).arg(&output).output().unwrap();
    assert_eq!(run.status.code(), Some(2));
    assert!(!output.exists() && folder.path().join("out.gcode.stale").exists());
}

#[test]
fn an_output_never_takes_the_place_of_a_model_or_a_folder() {
    let folder = folder();
    let bytes = stl(&cuboid([0.0; 3], [10.0; 3]));
    let model = file(folder.path(), "model.stl", &bytes);
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    let run = |verb: &str, output: &Path| {
        let run = trunnion().args([verb, &model, "-m", "generic-ac", "-q", "-o"]).arg(output).output().unwrap();
        assert_eq!(run.status.code(), Some(2), "{verb}: {}", said(&run));
        said(&run)
    };
    for verb in ["prepare", "plan"] {
        assert!(fails(&run(verb, Path::new(&model)), "file/twice: model.stl"));
        assert!(fails(&run(verb, &inner), "file/no-output: inner"));
        assert!(fails(&run(verb, &folder.path().join("none/out")), "file/no-folder: none"));
    }
    assert_eq!(std::fs::read(&model).unwrap(), bytes);
    assert!(inner.is_dir());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "something was left behind");
}

#[test]
fn a_plan_edited_beyond_the_machine_or_the_table_is_refused_with_numbers() {
    let folder = folder();
    let model = file(folder.path(), "model.stl", &stl(&cuboid([0.0; 3], [10.0; 3])));
    let plan = folder.path().join("plan.json");
    let made = trunnion().args(["plan", &model, "-m", "generic-ac", "-o"]).arg(&plan).output().unwrap();
    assert!(made.status.success(), "{}", said(&made));
    let document: serde_json::Value = serde_json::from_slice(&std::fs::read(&plan).unwrap()).unwrap();
    let cases = [
        ("/slots/0/prints/0/tilt_deg", 360.0, "plan-file/reach: A360 | -15..90 deg"),
        ("/slots/0/prints/0/tilt_deg", 5.0, "plan-file/angles: slot 0 | 5"),
        ("/placement/origin_mm/2", 50.0, "table/not-on-table: 50.00 mm"),
        ("/placement/origin_mm/0", 500.0, "table/over-rim: mm"),
    ];
    for (pointer, value, wanted) in cases {
        let mut edited = document.clone();
        *edited.pointer_mut(pointer).unwrap() = value.into();
        std::fs::write(&plan, edited.to_string()).unwrap();
        let run = trunnion().arg("slice").arg(&plan).arg("-o").arg(folder.path().join("slots")).output().unwrap();
        assert_eq!(run.status.code(), Some(2), "{}", said(&run));
        assert!(fails(&said(&run), wanted), "{}", said(&run));
    }
}

/// What strangers name, in files, in sentences and in programs' words, is shown and does not drive the terminal. In JSON it means the same.
#[cfg(unix)]
#[test]
fn no_name_or_word_of_a_stranger_drives_the_terminal() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let evil = "\u{1b}]0;OWNED\u{7}\u{9b}31m\u{202e}";
    let put = |name: &str, text: &str| file(folder.path(), name, text.as_bytes());
    let corner = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    put("named.obj", &format!("o {evil}\n{corner}"));
    put("plan.json", "{\"\\u001b]0;OWNED\\u0007\u{202e}\":1}");
    put("machine.toml", &format!("{evil}\n"));
    put("key.toml", "[machine]\n\"\\u001B]0;OWNED\\u0007\" = 1\n");
    put("list.txt", &format!("{evil}.stl\n"));
    put("touches.toml", "[[touch]]\n\"\\u001B]0;OWNED\\u0007\" = 1\n");
    put("some.gcode", "G1 X1\n");
    put(&format!("{evil}.stl"), "solid");
    let slicer = put("slicer.sh", "#!/bin/sh\nprintf '\\033]0;OWNED\\007 hello\\n'\n");
    std::fs::set_permissions(&slicer, std::fs::Permissions::from_mode(0o755)).unwrap();
    let run = |words: &[&str]| trunnion().current_dir(folder.path()).args(words).output().unwrap();
    let drives = |c: char| c.is_control() && c != '\n' || ('\u{202a}'..='\u{202e}').contains(&c);
    let named = format!("{evil}.stl");
    for words in [
        &["inspect", "named.obj"][..],
        &["inspect", "named.obj", "--json"],
        &["verify", "some.gcode", "--plan", "plan.json"],
        &["profile", "check", "machine.toml"],
        &["profile", "check", "key.toml"],
        &["profile", "calibrate", "touches.toml", "-m", "generic-ac"],
        &["orient", "list.txt", "-o", "results"],
        &["inspect", &named],
        &["inspect", &named, "--json"],
        &["inspect", "named.obj", evil],
        &["inspect", evil, "--json", "--no-such"],
        &["prepare", "named.obj", "-m", evil, "-o", "out.gcode"],
        &["prepare", "named.obj", "-m", "generic-ac", "-o", "out.gcode", "--slicer", "./slicer.sh"],
    ] {
        let run = run(words);
        let all = [run.stdout, run.stderr].concat();
        let text = String::from_utf8(all).unwrap();
        assert!(!text.is_empty() && !text.contains(drives), "{words:?}: {text:?}");
    }
    let inspected = run(&["inspect", "named.obj", "--json"]);
    let document: serde_json::Value = serde_json::from_slice(&inspected.stdout).unwrap();
    assert_eq!(document["parts"][0]["name"], evil);
}

/// A key that is for a server is in the environment of no program that is started: neither of slicers nor of the processes of a batch.
#[cfg(unix)]
#[test]
fn a_servers_key_is_given_to_no_other_program() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let seen = folder.path().join("seen");
    let script = format!("#!/bin/sh\nenv >> {}\necho PrusaSlicer-2.5.0 based on Slic3r\n", seen.display());
    let slicer = file(folder.path(), "slicer.sh", script.as_bytes());
    std::fs::set_permissions(&slicer, std::fs::Permissions::from_mode(0o755)).unwrap();
    std::fs::copy(fixture("cube"), folder.path().join("cube.stl")).unwrap();
    for words in
        [&["prepare", "cube.stl", "-o", "out.gcode"][..], &["prepare", "cube.stl", "cube.stl*2", "-o", "out.gcode"]]
    {
        let mut run = trunnion();
        run.current_dir(folder.path()).args(words).args(["-m", "generic-ac", "--slicer", &slicer, "-q"]);
        let run = run.env("TRUNNION_KEY", "S3CRET").env("KEPT", "AS-IT-IS").output().unwrap();
        assert_eq!(run.status.code(), Some(3), "{}", said(&run));
    }
    let seen = std::fs::read_to_string(seen).unwrap();
    assert!(seen.contains("KEPT=AS-IT-IS") && !seen.contains("S3CRET") && !seen.contains("TRUNNION_KEY"), "{seen}");
}

/// What a profile extends may be any file on the computer: none of its text is shown.
#[test]
fn nothing_of_a_file_that_is_no_profile_is_quoted() {
    let folder = folder();
    file(folder.path(), "secret.txt", b"hunter2:$6$salt$hash\nmore = words\n");
    let machine = file(folder.path(), "m.toml", b"extends = \"./secret.txt\"\n[machine]\nname = \"x\"\n");
    let run = trunnion().args(["profile", "check", &machine]).output().unwrap();
    let text = said(&run);
    assert_eq!(run.status.code(), Some(2), "{text}");
    assert!(text.contains("secret.txt:1: ") && !text.contains("hunter2") && !text.contains("hash"), "{text}");
    let large = format!("[machine]\n{}", (0..90_000).map(|i| format!("key_{i} = {i}\n")).collect::<String>());
    let large = file(folder.path(), "large.toml", large.as_bytes());
    let run = trunnion().args(["profile", "check", &large]).output().unwrap();
    assert!(
        run.status.code() == Some(2) && fails(&said(&run), "profile/syntax: large.toml | 1048576"),
        "{}",
        said(&run)
    );
}

/// The list of parts in a plan is read by people and by other programs: it is the model's.
#[test]
fn a_plan_whose_list_of_parts_is_not_the_models_is_refused() {
    let folder = folder();
    let (output, plan) = (folder.path().join("out.gcode"), folder.path().join("plan.json"));
    prepare(&fixture("two-boxes"), "generic-ac", "builtin", &output, &["--plan-out", &plan.display().to_string()]);
    let whole: serde_json::Value = serde_json::from_slice(&std::fs::read(&plan).unwrap()).unwrap();
    let check = |parts: serde_json::Value| {
        let mut changed = whole.clone();
        changed["parts"] = parts;
        std::fs::write(&plan, changed.to_string()).unwrap();
        let run = trunnion().arg("verify").arg(&output).arg("--plan").arg(&plan).output().unwrap();
        (run.status.code(), said(&run))
    };
    assert_eq!(check(whole["parts"].clone()).0, Some(0));
    let part = |id: usize| serde_json::json!({"id": id, "name": "x"});
    for parts in
        [vec![], vec![part(0)], vec![part(0), part(0)], vec![part(1), part(0)], vec![part(0), part(1), part(2)]]
    {
        let (code, text) = check(parts.into());
        assert!(code == Some(2) && fails(&text, "plan-file/part-list: parts | 2"), "{text}");
    }
}

/// A name that is no text is a name all the same: it is read as it is, and shown as well as can be.
#[cfg(unix)]
#[test]
fn a_models_name_need_not_be_text() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = folder();
    let name = OsStr::from_bytes(b"k\xf6rper.stl");
    std::fs::copy(fixture("cube"), folder.path().join(name)).unwrap();
    for words in [
        &["inspect"][..],
        &["plan", "-m", "generic-ac", "-o", "plan.json"],
        &["prepare", "-m", "generic-ac", "--slicer", "builtin", "-o", "out.gcode"],
        &["pack", "--space", "100,100,100", "-o", "plates"],
    ] {
        let run = trunnion().current_dir(folder.path()).args(words).arg("-q").arg(name).output().unwrap();
        assert!(run.status.success(), "{words:?}: {}", said(&run));
    }
}

/// Two facets back to back enclose nothing: beside a solid they are dropped and that is said; alone they are no solid.
#[test]
fn two_sided_facets_are_dropped_beside_a_solid() {
    let folder = folder();
    let sheet = |facets: &[[[f32; 3]; 3]]| -> Vec<[[f32; 3]; 3]> {
        facets.iter().flat_map(|&[a, b, c]| [[a, b, c], [a, c, b]]).collect()
    };
    let triangle = [[20.0, 0.0, 5.0], [24.0, 0.0, 5.0], [20.0, 4.0, 7.0]];
    let both = [cuboid([0.0; 3], [10.0; 3]), sheet(&[triangle])].concat();
    let model = file(folder.path(), "sheet.stl", &stl(&both));
    let done = trunnion().args(["inspect", &model]).output().unwrap();
    assert!(done.status.success(), "{}", said(&done));
    let text = said(&done);
    assert!(states(&text, "2 facets | facet 12"), "{text}");
    let out = folder.path().join("sheet.gcode");
    let done = trunnion().args(["prepare", &model, "-m", "generic-ac", "--slicer", "builtin", "-o"]).arg(&out).output();
    assert!(done.unwrap().status.success() && out.exists());
    let alone = refused(&file(folder.path(), "alone.stl", &stl(&sheet(&[triangle]))), 2, &[]);
    assert!(fails(&alone, "mesh/flat: alone.stl | part 0"), "{alone}");
}
