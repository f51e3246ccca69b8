//! What a process leaves behind that was killed: the next one clears it.
//!
//! A file is locked for as long as its process lives, and is given its first bytes only then; so what is not empty and can be locked is
//! nobody's. What is empty is somebody's who has just made it, unless it has been so for an hour. A lock is the file system's, and holds
//! among containers that share one.

use std::fs::{File, Metadata, OpenOptions, read_dir, remove_dir, remove_dir_all, remove_file};
use std::io::Write;
use std::path::Path;
use std::time::Duration;

/// What is in a folder that is somebody's.
const OWNED: &str = "owned";
/// How files are called that are being written.
pub(super) const WRITING: [&str; 2] = [".trunnion-", ".writing"];
/// How folders are called that slicers work in.
pub(super) const FOLDER: &str = "trunnion-";

/// Makes `folder` this process's, until the file that comes back is dropped.
pub(super) fn own(folder: &Path) -> std::io::Result<File> {
    let mut file = File::create(folder.join(OWNED))?;
    // Where nothing can be locked it stays empty, and is nobody's to clear.
    if file.lock().is_ok() {
        file.write_all(b"locked while its process lives\n")?;
    }
    Ok(file)
}

/// Nobody takes as long between making something and owning it.
const AGE: Duration = Duration::from_secs(3600);

/// Whether nobody has `file` any more.
fn is_left(file: &Path) -> bool {
    let opened = OpenOptions::new().write(true).open(file);
    let left = |m: &Metadata| m.is_file() && (m.len() > 0 || is_old(m));
    opened.is_ok_and(|opened| opened.metadata().is_ok_and(|m| left(&m)) && opened.try_lock().is_ok())
}

fn is_old(metadata: &Metadata) -> bool {
    metadata.modified().is_ok_and(|then| then.elapsed().is_ok_and(|age| age > AGE))
}

fn names(folder: &Path) -> impl Iterator<Item = (std::path::PathBuf, String)> {
    let entries = read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    entries.map(|entry| (entry.path(), entry.file_name().to_string_lossy().into_owned()))
}

/// Removes slicers' folders in `folder` whose process is gone. What cannot be removed stays.
pub(super) fn clear_folders(folder: &Path) {
    for (path, _) in names(folder).filter(|(_, name)| name.starts_with(FOLDER)) {
        if is_left(&path.join(OWNED)) {
            let _ = remove_dir_all(path);
        } else if path.symlink_metadata().is_ok_and(|m| m.is_dir() && is_old(&m)) {
            // Only where nothing is in it.
            let _ = remove_dir(path);
        }
    }
}

/// Removes files beside outputs in `folder` that a process was writing which is gone. What cannot be removed stays.
pub(super) fn clear_writing(folder: &Path) {
    let is_writing = |name: &str| name.starts_with(WRITING[0]) && name.ends_with(WRITING[1]);
    names(folder)
        .filter(|(path, name)| is_writing(name) && is_left(path))
        .for_each(|(path, _)| drop(remove_file(path)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_locked_or_empty_or_of_another_name_stays() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in [".trunnion-a.writing", ".trunnion-b.writing", "trunnion-.writing", ".trunnion-c"] {
            std::fs::write(at(name), "half").unwrap();
        }
        std::fs::write(at(".trunnion-d.writing"), "").unwrap();
        let held = OpenOptions::new().write(true).open(at(".trunnion-b.writing")).unwrap();
        held.lock().unwrap();
        for name in ["trunnion-dead", "trunnion-alive", "trunnion-older", "other"] {
            std::fs::create_dir(at(name)).unwrap();
        }
        ["trunnion-dead", "other"].into_iter().for_each(|name| drop(own(&at(name)).unwrap()));
        let alive = own(&at("trunnion-alive")).unwrap();
        clear_writing(folder.path());
        clear_folders(folder.path());
        let there = |name: &str| at(name).exists();
        assert!(!there(".trunnion-a.writing") && !there("trunnion-dead"));
        for name in [
            ".trunnion-b.writing",
            "trunnion-.writing",
            ".trunnion-c",
            ".trunnion-d.writing",
            "trunnion-alive",
            "trunnion-older",
            "other",
        ] {
            assert!(there(name), "{name} is gone");
        }
        let before = std::time::SystemTime::now() - 2 * AGE;
        for name in [".trunnion-c", ".trunnion-d.writing", "trunnion-older", "other"] {
            File::open(at(name)).unwrap().set_modified(before).unwrap();
        }
        std::fs::create_dir(at("trunnion-used")).unwrap();
        std::fs::write(at("trunnion-used/part.stl"), "solid").unwrap();
        File::open(at("trunnion-used")).unwrap().set_modified(before).unwrap();
        clear_writing(folder.path());
        clear_folders(folder.path());
        assert!(!there(".trunnion-d.writing") && !there("trunnion-older"));
        assert!(there(".trunnion-c") && there("other") && there("trunnion-used/part.stl"));
        drop((held, alive));
        clear_writing(folder.path());
        clear_folders(folder.path());
        assert!(!there(".trunnion-b.writing") && !there("trunnion-alive"));
    }
}
