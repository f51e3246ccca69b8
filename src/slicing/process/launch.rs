//! How a program is started: by its own file, as an AppImage, or in a flatpak's sandbox.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;

/// How a program is started, given the file that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Launch {
    /// By the file.
    File,
    /// An AppImage on a computer that cannot mount it: unpacked for each run.
    Unpacked,
    /// A flatpak of this name. Its sandbox has a folder for temporary files of its own, and of our files those that it is shown.
    Flatpak(OsString),
}

impl Launch {
    /// As the place of the file says.
    pub(super) fn of(path: &Path) -> Self {
        match flatpak(path) {
            Some(name) => Self::Flatpak(name.to_owned()),
            None => Self::File,
        }
    }

    /// The one to try next where a program said only `said` of itself.
    pub(super) fn other(&self, path: &Path, said: &str) -> Option<Self> {
        let image = path.extension().is_some_and(|is| is.eq_ignore_ascii_case("appimage"));
        (*self == Self::File && image && said.to_lowercase().contains("fuse")).then_some(Self::Unpacked)
    }

    /// Whether the program sees no files but those of its run's folder.
    pub(super) fn sees_only_its_folder(&self) -> bool {
        matches!(self, Self::Flatpak(_))
    }

    /// The command, without arguments, of a run whose files are all in `folder`.
    pub(super) fn command(&self, path: &Path, folder: &Path) -> Command {
        let Self::Flatpak(name) = self else {
            let mut command = Command::new(path);
            if *self == Self::Unpacked {
                command.env("APPIMAGE_EXTRACT_AND_RUN", "1");
            }
            return command;
        };
        let mut command = Command::new("flatpak");
        // Else what is in the sandbox outlives whoever started it.
        command.args(["run", "--die-with-parent"]).arg(shown(folder)).arg(name);
        command
    }
}

/// The name of the flatpak of which `path` is the exported command: a file of that name in `exports/bin`, and beside `exports` the folder of
/// the application.
fn flatpak(path: &Path) -> Option<&OsStr> {
    let (name, bin) = (path.file_name()?, path.parent()?);
    let installation = bin.parent()?.parent()?;
    (bin.ends_with("exports/bin") && installation.join("app").join(name).is_dir()).then_some(name)
}

/// The option that shows a sandbox this folder; flatpak reads a colon as the beginning of a mode.
fn shown(folder: &Path) -> OsString {
    let mut option = OsString::from("--filesystem=");
    match folder.to_str() {
        Some(text) => option.push(text.replace('\\', "\\\\").replace(':', "\\:")),
        None => option.push(PathBuf::from(folder)),
    }
    option
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flatpak_is_known_by_its_place_and_shown_one_folder() {
        let made = tempfile::tempdir().unwrap();
        let exported = made.path().join("exports/bin/com.prusa3d.PrusaSlicer");
        assert_eq!(Launch::of(&exported), Launch::File, "a folder that is only called so");
        std::fs::create_dir_all(made.path().join("app/com.prusa3d.PrusaSlicer")).unwrap();
        let launch = Launch::of(&exported);
        assert!(launch.sees_only_its_folder());
        let command = launch.command(&exported, Path::new("/tmp/a b:c\\d"));
        let words: Vec<_> = std::iter::once(command.get_program()).chain(command.get_args()).collect();
        let wanted = ["flatpak", "run", "--die-with-parent", r"--filesystem=/tmp/a b\:c\\d", "com.prusa3d.PrusaSlicer"];
        assert_eq!(words, wanted);
    }

    #[test]
    fn an_image_that_cannot_be_mounted_is_unpacked() {
        let image = Path::new("/opt/PrusaSlicer-2.8.1.AppImage");
        let said = "dlopen(): error loading libfuse.so.2\n\nAppImages require FUSE to run.";
        let launch = Launch::of(image);
        assert_eq!(launch.other(image, "PrusaSlicer-2.8.1 based on Slic3r"), None);
        assert_eq!(launch.other(Path::new("/usr/bin/prusa-slicer"), said), None);
        let other = launch.other(image, said).unwrap();
        assert_eq!(other.other(image, said), None, "once");
        let command = other.command(image, Path::new("/tmp/run"));
        assert_eq!(command.get_program(), image);
        assert_eq!(command.get_envs().collect::<Vec<_>>(), [("APPIMAGE_EXTRACT_AND_RUN".as_ref(), Some("1".as_ref()))]);
    }
}
