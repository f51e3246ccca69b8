//! Where slicers are looked for: on PATH, then where the installers of each system, flatpak and AppImages put them.
//!
//! Nobody says that a program found here is what its name promises: whoever starts it asks it. Folders that are not there hold nothing.

use std::fs;
use std::path::{Path, PathBuf};

use super::Program;

/// Systems that differ in where programs are installed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum System {
    Windows,
    MacOs,
    /// Linux and whatever else has neither of those.
    Other,
}

/// Folders of one computer, each in the order in which they are looked through.
#[derive(Clone, Debug)]
pub(super) struct Places {
    pub system: System,
    /// Those on PATH.
    pub path: Vec<PathBuf>,
    /// Those in which installers put a folder for each application.
    pub applications: Vec<PathBuf>,
    /// Those with the commands that flatpaks export.
    pub flatpaks: Vec<PathBuf>,
    /// Those in which people and their tools keep AppImages.
    pub images: Vec<PathBuf>,
}

impl Places {
    /// Those of this computer, by the variables that its system has for them.
    pub(super) fn here() -> Self {
        let system = match std::env::consts::OS {
            "windows" => System::Windows,
            "macos" => System::MacOs,
            _ => System::Other,
        };
        let folder = |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let home = folder("HOME");
        let below_home = |names: &[&str]| names.iter().filter_map(|name| Some(home.as_ref()?.join(name))).collect();
        let applications = match system {
            System::Windows => {
                let own = folder("LOCALAPPDATA").map(|folder| folder.join("Programs"));
                let shared = ["ProgramFiles", "ProgramW6432", "ProgramFiles(x86)"].into_iter().filter_map(folder);
                shared.chain(own).collect()
            }
            System::MacOs => {
                [PathBuf::from("/Applications")].into_iter().chain(below_home(&["Applications"])).collect()
            }
            System::Other => Vec::new(),
        };
        let (flatpaks, images) = if system == System::Other {
            let data = folder("XDG_DATA_HOME").or_else(|| Some(home.as_ref()?.join(".local/share")));
            let own = folder("FLATPAK_USER_DIR").or_else(|| Some(data?.join("flatpak")));
            let all = folder("FLATPAK_SYSTEM_DIR").unwrap_or_else(|| PathBuf::from("/var/lib/flatpak"));
            let flatpaks = own.into_iter().chain([all]).map(|folder| folder.join("exports/bin")).collect();
            let images: Vec<PathBuf> = below_home(&["Applications", "AppImages", ".local/bin", "bin"]);
            (flatpaks, images.into_iter().chain([PathBuf::from("/opt")]).collect())
        } else {
            (Vec::new(), Vec::new())
        };
        let path = std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()).collect();
        Self { system, path, applications, flatpaks, images }
    }

    /// Files that may be `program`, the likeliest first; of an application that is there in several versions the newest first.
    pub(super) fn of(&self, program: Program) -> Vec<PathBuf> {
        let own = Installers::of(program);
        let on_path = self.names(program).into_iter().flat_map(|name| self.path.iter().map(move |on| on.join(&name)));
        let patterns = match self.system {
            System::Windows => own.windows,
            System::MacOs => own.mac_os,
            System::Other => &[],
        };
        let installed = patterns.iter().flat_map(|pattern| self.applications.iter().flat_map(|f| matching(f, pattern)));
        let exported = own.flatpaks.iter().flat_map(|name| self.flatpaks.iter().map(move |folder| folder.join(name)));
        let images = own.images.iter().flat_map(|pattern| self.images.iter().flat_map(|f| matching(f, pattern)));
        let mut files: Vec<PathBuf> = Vec::new();
        for path in on_path.chain(installed).chain(exported).chain(images).filter(|path| path.is_file()) {
            // A folder may have two names, as with Program Files.
            if !files.contains(&path) {
                files.push(path);
            }
        }
        files
    }

    /// The names of its commands on this system; on Windows the one with a console first, since the other one says nothing.
    fn names(&self, program: Program) -> Vec<String> {
        let names = program.commands().iter().map(|&name| name.to_owned());
        if self.system != System::Windows {
            return names.collect();
        }
        let (console, other): (Vec<_>, Vec<_>) = names.partition(|name| name.ends_with("-console"));
        console.into_iter().chain(other).map(|name| name + ".exe").collect()
    }
}

/// The file to start where a person has given the application's folder, as on macOS, or on Windows the program without a console.
pub(super) fn meant(given: &Path) -> PathBuf {
    if given.extension().is_some_and(|is| is.eq_ignore_ascii_case("app")) && given.is_dir() {
        let programs = [Program::PRUSA_SLICER, Program::SLIC3R, Program::CuraEngine];
        let inside = programs.iter().flat_map(|&program| Installers::of(program).mac_os).filter_map(|pattern| {
            let (_, below) = pattern.split_once(".app/")?;
            Some(given.join(below))
        });
        return inside.into_iter().find(|path| path.is_file()).unwrap_or_else(|| given.to_owned());
    }
    let console = given.file_stem().map(|stem| given.with_file_name(format!("{}-console.exe", stem.to_string_lossy())));
    let windowed = given.extension().is_some_and(|is| is.eq_ignore_ascii_case("exe"));
    console.filter(|path| windowed && path.is_file()).unwrap_or_else(|| given.to_owned())
}

/// What a program is called where it is installed: paths below a folder, of which a part that ends in `*` is the beginning of a name.
struct Installers {
    windows: &'static [&'static str],
    mac_os: &'static [&'static str],
    flatpaks: &'static [&'static str],
    images: &'static [&'static str],
}

impl Installers {
    fn of(program: Program) -> Self {
        match program {
            Program::PRUSA_SLICER => Self {
                windows: &[
                    "Prusa3D/PrusaSlicer/prusa-slicer-console.exe",
                    "PrusaSlicer*/prusa-slicer-console.exe",
                    "Prusa3D/PrusaSlicer*/prusa-slicer-console.exe",
                ],
                mac_os: &[
                    "PrusaSlicer*.app/Contents/MacOS/PrusaSlicer",
                    "Original Prusa Drivers/PrusaSlicer*.app/Contents/MacOS/PrusaSlicer",
                ],
                flatpaks: &["com.prusa3d.PrusaSlicer"],
                images: &["PrusaSlicer*.AppImage"],
            },
            Program::SLIC3R => Self {
                windows: &["Slic3r*/Slic3r-console.exe"],
                mac_os: &["Slic3r*.app/Contents/MacOS/Slic3r"],
                flatpaks: &[],
                images: &["Slic3r*.AppImage"],
            },
            // The flatpak and the AppImage of Cura have its window as their only command.
            Program::CuraEngine => Self {
                windows: &["UltiMaker Cura*/CuraEngine.exe", "UltiMaker-Cura*/CuraEngine.exe"],
                mac_os: &[
                    "UltiMaker Cura*.app/Contents/MacOS/CuraEngine",
                    "UltiMaker Cura*.app/Contents/Frameworks/CuraEngine",
                    "UltiMaker Cura*.app/Contents/Resources/CuraEngine",
                    "UltiMaker-Cura*.app/Contents/Frameworks/CuraEngine",
                ],
                flatpaks: &[],
                images: &[],
            },
        }
    }
}

/// The paths below `folder` that `pattern` names, newest versions first. Letters may be large or small.
fn matching(folder: &Path, pattern: &str) -> Vec<PathBuf> {
    pattern.split('/').fold(vec![folder.to_owned()], |folders, part| {
        let Some((start, end)) = part.split_once('*') else {
            return folders.into_iter().map(|folder| folder.join(part)).collect();
        };
        let matches = |name: &str| {
            let name = name.to_lowercase();
            let (start, end) = (start.to_lowercase(), end.to_lowercase());
            name.len() >= start.len() + end.len() && name.starts_with(&start) && name.ends_with(&end)
        };
        let mut found: Vec<(Version, PathBuf)> = Vec::new();
        for folder in folders {
            let entries = fs::read_dir(&folder).into_iter().flatten().flatten();
            let names = entries.filter_map(|entry| entry.file_name().into_string().ok()).filter(|name| matches(name));
            found.extend(names.map(|name| (Version::of(&name), folder.join(name))));
        }
        found.sort_by(|(a, at_a), (b, at_b)| b.cmp(a).then_with(|| at_a.cmp(at_b)));
        found.into_iter().map(|(_, path)| path).collect()
    })
}

/// The version in a file's name; one that is not finished is below the same one that is.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Version {
    numbers: Vec<u64>,
    finished: bool,
}

impl Version {
    fn of(name: &str) -> Self {
        // The digit of Slic3r is none of its version.
        let name = name.to_lowercase().replace("slic3r", "slicer");
        let from = name.find(|c: char| c.is_ascii_digit()).unwrap_or(name.len());
        let rest = &name[from..];
        let digits = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        let numbers = rest[..digits].split('.').filter_map(|number| number.parse().ok()).collect();
        Self {
            numbers,
            finished: !["alpha", "beta", "rc"].iter().any(|word| rest[digits..].starts_with(&format!("-{word}"))),
        }
    }
}

#[cfg(test)]
mod tests;
