//! Computers that are folders, each with the files that installers of its system leave.

use super::*;

/// A folder with such files, all empty.
fn computer(files: &[&str]) -> tempfile::TempDir {
    let made = tempfile::tempdir().unwrap();
    for file in files {
        let path = made.path().join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, "").unwrap();
    }
    made
}

/// Where such a computer keeps programs.
fn places(system: System, made: &Path) -> Places {
    let below = |names: &[&str]| names.iter().map(|name| made.join(name)).collect();
    Places {
        system,
        path: below(&["bin", "bin2"]),
        applications: below(&["Applications", "Other"]),
        flatpaks: below(&["own/exports/bin", "all/exports/bin"]),
        images: below(&["images"]),
    }
}

/// What is found of `program`, as paths below the computer's folder.
fn found(system: System, made: &Path, program: Program) -> Vec<String> {
    let files = places(system, made).of(program);
    files.iter().map(|path| path.strip_prefix(made).unwrap().to_str().unwrap().to_owned()).collect()
}

#[test]
fn on_windows_they_are_below_program_files_and_the_console_comes_first() {
    let made = computer(&[
        "bin/prusa-slicer.exe",
        "bin2/prusa-slicer-console.exe",
        "Applications/Prusa3D/PrusaSlicer/prusa-slicer-console.exe",
        "Applications/Prusa3D/PrusaSlicer/prusa-slicer.exe",
        "Other/PrusaSlicer-2.7.0/prusa-slicer-console.exe",
        "Other/prusaslicer-2.10.1/prusa-slicer-console.exe",
        "Applications/Slic3r/Slic3r-console.exe",
        "Applications/Ultimaker Cura 4.13.1/CuraEngine.exe",
        "Applications/UltiMaker Cura 5.10.0/CuraEngine.exe",
        "Applications/UltiMaker Cura 5.9.1/CuraEngine.exe",
        "Applications/UltiMaker Cura 5.11.0/Cura.exe",
    ]);
    let at = |program| found(System::Windows, made.path(), program);
    let prusa = [
        "bin2/prusa-slicer-console.exe",
        "bin/prusa-slicer.exe",
        "Applications/Prusa3D/PrusaSlicer/prusa-slicer-console.exe",
        "Other/prusaslicer-2.10.1/prusa-slicer-console.exe",
        "Other/PrusaSlicer-2.7.0/prusa-slicer-console.exe",
    ];
    assert_eq!(at(Program::PRUSA_SLICER), prusa);
    assert_eq!(at(Program::SLIC3R), ["Applications/Slic3r/Slic3r-console.exe"]);
    let cura = ["5.10.0", "5.9.1", "4.13.1"].map(|version| {
        let called = if version < "5" { "Ultimaker" } else { "UltiMaker" };
        format!("Applications/{called} Cura {version}/CuraEngine.exe")
    });
    assert_eq!(at(Program::CuraEngine), cura);
    let windowed = made.path().join("Applications/Prusa3D/PrusaSlicer/prusa-slicer.exe");
    assert_eq!(meant(&windowed), windowed.with_file_name("prusa-slicer-console.exe"));
    let alone = made.path().join("bin/prusa-slicer.exe");
    assert_eq!(meant(&alone), alone);
}

#[test]
fn on_macos_they_are_inside_applications_which_may_be_given_themselves() {
    let made = computer(&[
        "bin/prusa-slicer",
        "Applications/Original Prusa Drivers/PrusaSlicer.app/Contents/MacOS/PrusaSlicer",
        "Other/PrusaSlicer.app/Contents/MacOS/PrusaSlicer",
        "Other/Slic3r.app/Contents/MacOS/Slic3r",
        "Applications/UltiMaker Cura.app/Contents/MacOS/UltiMaker-Cura",
        "Applications/UltiMaker Cura.app/Contents/Frameworks/CuraEngine",
    ]);
    let at = |program| found(System::MacOs, made.path(), program);
    let prusa = [
        "bin/prusa-slicer",
        "Other/PrusaSlicer.app/Contents/MacOS/PrusaSlicer",
        "Applications/Original Prusa Drivers/PrusaSlicer.app/Contents/MacOS/PrusaSlicer",
    ];
    assert_eq!(at(Program::PRUSA_SLICER), prusa);
    assert_eq!(at(Program::SLIC3R), ["Other/Slic3r.app/Contents/MacOS/Slic3r"]);
    let engine = "Applications/UltiMaker Cura.app/Contents/Frameworks/CuraEngine";
    assert_eq!(at(Program::CuraEngine), [engine]);
    assert_eq!(meant(&made.path().join("Applications/UltiMaker Cura.app")), made.path().join(engine));
    let empty = made.path().join("Applications/Empty.app");
    assert_eq!(meant(&empty), empty);
}

#[test]
fn elsewhere_they_are_flatpaks_and_images_of_which_the_newest_comes_first() {
    let made = computer(&[
        "bin2/PrusaSlicer",
        "bin2/slic3r",
        "own/exports/bin/com.prusa3d.PrusaSlicer",
        "all/exports/bin/com.prusa3d.PrusaSlicer",
        "all/exports/bin/com.ultimaker.cura",
        "images/PrusaSlicer-2.9.0-rc1+linux-x64.AppImage",
        "images/PrusaSlicer-2.9.0+linux-x64-GTK3-202409181416.AppImage",
        "images/PrusaSlicer-2.10.0-alpha1.AppImage",
        "images/prusaslicer-2.8.1.appimage",
        "images/PrusaSlicer-notes.txt",
        "images/Slic3r-1.3.0.AppImage",
        "Applications/PrusaSlicer.app/Contents/MacOS/PrusaSlicer",
    ]);
    let at = |program| found(System::Other, made.path(), program);
    let prusa = [
        "bin2/PrusaSlicer",
        "own/exports/bin/com.prusa3d.PrusaSlicer",
        "all/exports/bin/com.prusa3d.PrusaSlicer",
        "images/PrusaSlicer-2.10.0-alpha1.AppImage",
        "images/PrusaSlicer-2.9.0+linux-x64-GTK3-202409181416.AppImage",
        "images/PrusaSlicer-2.9.0-rc1+linux-x64.AppImage",
        "images/prusaslicer-2.8.1.appimage",
    ];
    assert_eq!(at(Program::PRUSA_SLICER), prusa);
    assert_eq!(at(Program::SLIC3R), ["bin2/slic3r", "images/Slic3r-1.3.0.AppImage"]);
    assert_eq!(at(Program::CuraEngine), Vec::<String>::new());
}
