//! PrusaSlicer where installers put it: in a flatpak's sandbox, whose folders are not ours, and in an AppImage that cannot be mounted. Both are made
//! here, of the installed PrusaSlicer.

use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::pipeline::fixture;
use crate::support::{Command, fails, folder, on_path, said, skip, trunnion, wait_for};

const NAME: &str = "com.prusa3d.PrusaSlicer";
const RUNTIME: &str = "org.example.Platform";

/// An installation of flatpaks, of which one is called as PrusaSlicer's is and does what `script` says, in a sandbox that sees this
/// computer's programs in `/run/host`; `None` and a word about it where there can be none.
struct Installation {
    folder: tempfile::TempDir,
}

impl Installation {
    fn of(script: &str) -> Option<Self> {
        let made = Self { folder: folder() };
        let arch = std::env::consts::ARCH;
        let (Some(flatpak), Some(busybox)) = (on_path("flatpak"), on_path("busybox")) else {
            skip("flatpak, or busybox, is not installed: no slicer in a sandbox");
            return None;
        };
        let at = |name: &str| made.folder.path().join(name);
        for name in
            ["runtime/usr/bin", "runtime/usr/share", "runtime/usr/lib", "runtime/files", "app/files/bin", "app/export"]
        {
            std::fs::create_dir_all(at(name)).unwrap();
        }
        std::fs::copy(busybox, at("runtime/usr/bin/busybox")).unwrap();
        symlink("busybox", at("runtime/usr/bin/sh")).unwrap();
        symlink("busybox", at("runtime/usr/bin/sleep")).unwrap();
        symlink("/run/host/usr/share/PrusaSlicer", at("runtime/usr/share/PrusaSlicer")).unwrap();
        symlink("/run/host/usr/lib/locale", at("runtime/usr/lib/locale")).unwrap();
        let of = format!("runtime={RUNTIME}/{arch}/1\nsdk={RUNTIME}/{arch}/1\n");
        std::fs::write(at("runtime/metadata"), format!("[Runtime]\nname={RUNTIME}\n{of}")).unwrap();
        // PrusaSlicer's own sees the home folder, and so does this one.
        let app = format!("[Application]\nname={NAME}\n{of}command=start\n\n[Context]\nfilesystems=home;host-os;\n");
        std::fs::write(at("app/metadata"), app).unwrap();
        std::fs::write(at("app/files/bin/start"), format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(at("app/files/bin/start"), std::fs::Permissions::from_mode(0o755)).unwrap();
        std::fs::create_dir(at("home")).unwrap();
        let arch = format!("--arch={arch}");
        let steps: [&[&str]; 6] = [
            &["build-export", "--runtime", &arch, "repository", "runtime", "1"],
            &["build-export", &arch, "repository", "app", "stable"],
            &["build-update-repo", "repository"],
            &["remote-add", "--user", "--no-gpg-verify", "here", "repository"],
            &["install", "--user", "-y", "--noninteractive", "here", RUNTIME],
            &["install", "--user", "-y", "--noninteractive", "here", NAME],
        ];
        for step in steps.into_iter().chain([&["run", "--command=sh", NAME, "-c", "exit 0"] as &[&str]]) {
            let run = made.within(Command::new(&flatpak).args(step)).output().unwrap();
            if !run.status.success() {
                skip(&format!("no flatpak can be made or run here: {} {}", step[0], said(&run).trim()));
                return None;
            }
        }
        Some(made)
    }

    /// `command` with this installation as the user's own, and no others.
    fn within<'a>(&self, command: &'a mut Command) -> &'a mut Command {
        let at = |name: &str| self.folder.path().join(name);
        command.current_dir(self.folder.path()).env("HOME", at("home")).env("FLATPAK_USER_DIR", at("user"));
        command.env("FLATPAK_SYSTEM_DIR", at("none")).env_remove("XDG_DATA_HOME").env_remove("DBUS_SESSION_BUS_ADDRESS")
    }

    /// What the command makes of a cube with no other slicer on PATH.
    fn prepared(&self, words: &[&str], out: &Path) -> Output {
        let bin = self.folder.path().join("bin");
        std::fs::create_dir(&bin).unwrap();
        for name in ["flatpak", "bwrap", "taskset"] {
            if let Some(program) = on_path(name) {
                symlink(program, bin.join(name)).unwrap();
            }
        }
        let mut command = trunnion();
        command
            .args(["prepare", &fixture("cube"), "-m", "generic-ac", "--slicer", "prusa-slicer", "-o"])
            .arg(out)
            .args(words);
        // Below /tmp, of which the sandbox has one of its own; a colon has a meaning for flatpak.
        let temporary = self.folder.path().join("a b:c");
        std::fs::create_dir_all(&temporary).unwrap();
        self.within(&mut command).env("PATH", bin).env("TMPDIR", temporary).output().unwrap()
    }
}

#[test]
fn the_slicer_of_a_flatpak_makes_the_same_bytes() {
    let Some(slicer) = on_path("prusa-slicer") else { return skip("no PrusaSlicer: none in a flatpak either") };
    let Some(libraries) = libraries() else { return skip("this system's libraries are not where Debian has them") };
    let loader = libraries.join("ld-linux-x86-64.so.2");
    let host = |path: &Path| format!("/run/host{}", path.display());
    let script = format!(
        "export LC_ALL=C\nexec {} --library-path {} {} \"$@\"",
        host(&loader),
        host(&libraries),
        host(&slicer.canonicalize().unwrap())
    );
    let Some(made) = Installation::of(&script) else { return };
    let at = |name: &str| made.folder.path().join(name);
    // In a folder that the sandbox is not shown.
    let own = folder();
    let config = own.path().join("mine.ini");
    std::fs::write(&config, "layer_height = 0.25\nfill_density = 30%\n").unwrap();
    let config = config.to_str().unwrap();
    let run = made.prepared(&["--slicer-config", config], &at("sandboxed.gcode"));
    assert!(run.status.success(), "{}", said(&run));
    let mut plain = trunnion();
    plain.args([
        "prepare",
        &fixture("cube"),
        "-m",
        "generic-ac",
        "--slicer",
        "prusa-slicer",
        "--slicer-config",
        config,
        "-o",
    ]);
    let run = plain.arg(at("plain.gcode")).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let [sandboxed, plain] = ["sandboxed.gcode", "plain.gcode"].map(|name| std::fs::read(at(name)).unwrap());
    assert!(sandboxed == plain, "{} and {} bytes", sandboxed.len(), plain.len());
    assert_eq!(std::fs::read_dir(at("a b:c")).unwrap().count(), 0, "nothing is left of the run");
}

/// The libraries of a program for this processor, as Debian has them.
fn libraries() -> Option<PathBuf> {
    let folder = PathBuf::from("/usr/lib/x86_64-linux-gnu");
    folder.join("ld-linux-x86-64.so.2").exists().then_some(folder)
}

#[test]
fn a_slicer_that_hangs_in_its_sandbox_is_stopped_there() {
    let mark = format!("60{}", std::process::id());
    let script = format!(
        "case \"$1\" in --help) echo 'PrusaSlicer-2.5.0 based on Slic3r'; exit 0;; esac\nsleep {mark} & sleep {mark}"
    );
    let Some(made) = Installation::of(&script) else { return };
    let out = made.folder.path().join("out.gcode");
    let run = made.prepared(&["--slicer-timeout", "1"], &out);
    assert!(!run.status.success() && !out.exists());
    assert!(fails(&said(&run), "slice/timed-out: PrusaSlicer"), "{}", said(&run));
    let sleeps = || {
        let processes = std::fs::read_dir("/proc").unwrap().flatten();
        let lines = processes.filter_map(|process| std::fs::read(process.path().join("cmdline")).ok());
        lines.filter(|line| line.split(|&byte| byte == 0).any(|word| word == mark.as_bytes())).count()
    };
    wait_for("the end of what ran in the sandbox", || sleeps() == 0);
}

/// The program in an AppImage says what is missing where there is no FUSE, and unpacks itself where it is told to.
#[test]
fn an_appimage_that_cannot_be_mounted_is_unpacked_for_each_print() {
    let Some(slicer) = on_path("prusa-slicer") else { return skip("no PrusaSlicer: none as an AppImage either") };
    let here = folder();
    let at = |name: &str| here.path().join(name);
    std::fs::create_dir_all(at("Applications")).unwrap();
    std::fs::create_dir(at("bin")).unwrap();
    let script = format!(
        "#!/bin/sh\nif [ -z \"$APPIMAGE_EXTRACT_AND_RUN\" ]; then\n\
         echo 'dlopen(): error loading libfuse.so.2' >&2\necho 'AppImages require FUSE to run.' >&2\nexit 127\nfi\n\
         echo run >> {}\nexec {} \"$@\"\n",
        at("unpacked").display(),
        slicer.display()
    );
    for (name, mode) in [("PrusaSlicer-2.5.0+linux-x64.AppImage", 0o755), ("PrusaSlicer-2.9.9.AppImage", 0o644)] {
        let image = at("Applications").join(name);
        std::fs::write(&image, &script).unwrap();
        std::fs::set_permissions(&image, std::fs::Permissions::from_mode(mode)).unwrap();
    }
    let run = |home: &Path, path: &Path, out: &Path| {
        let mut command = trunnion();
        command.args(["prepare", &fixture("cube"), "-m", "generic-ac", "--slicer", "prusa-slicer", "-o"]).arg(out);
        let nowhere = at("nowhere");
        command
            .env("HOME", home)
            .env("PATH", path)
            .env("FLATPAK_USER_DIR", &nowhere)
            .env("FLATPAK_SYSTEM_DIR", &nowhere);
        command.output().unwrap()
    };
    if let Some(taskset) = on_path("taskset") {
        symlink(taskset, at("bin/taskset")).unwrap();
    }
    let done = run(here.path(), &at("bin"), &at("image.gcode"));
    assert!(done.status.success(), "{}", said(&done));
    // Once for its name, once for the print; the newer one is not executable.
    assert_eq!(std::fs::read_to_string(at("unpacked")).unwrap(), "run\nrun\n");
    symlink(slicer, at("bin/prusa-slicer")).unwrap();
    let done = run(&at("nowhere"), &at("bin"), &at("plain.gcode"));
    assert!(done.status.success(), "{}", said(&done));
    assert!(std::fs::read(at("image.gcode")).unwrap() == std::fs::read(at("plain.gcode")).unwrap());
    std::fs::remove_file(at("bin/prusa-slicer")).unwrap();
    let none = run(&at("nowhere"), &at("bin"), &at("none.gcode"));
    assert!(fails(&said(&none), "slice/not-found: PrusaSlicer | --slicer builtin"), "{}", said(&none));
}
