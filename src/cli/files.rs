//! Files: whole ones in, whole ones out, never half of one.

use std::path::{Path, PathBuf};

use super::Failure;

pub(super) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path).map_err(|source| Failure::Read { path: path.to_owned(), source })
}

pub(super) fn read_text(path: &Path) -> Result<String, Failure> {
    let bytes = read(path)?;
    String::from_utf8(bytes).map_err(|_| Failure::Usage(format!("{}: not a text file", path.display())))
}

/// Writes beside the target and renames, so that a reader sees the old file or the new one.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let failed = |source| Failure::Write { path: path.to_owned(), source };
    let beside = with_suffix(path, ".writing");
    let done = std::fs::write(&beside, bytes).and_then(|()| std::fs::rename(&beside, path));
    if done.is_err() {
        let _ = std::fs::remove_file(&beside);
    }
    done.map_err(failed)
}

/// Takes a printable file of an earlier run out of the way: `x.gcode` becomes `x.gcode.stale`.
pub(super) fn set_aside(path: &Path) -> Option<PathBuf> {
    let aside = with_suffix(path, ".stale");
    std::fs::rename(path, &aside).is_ok().then_some(aside)
}

pub(super) fn create_folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path).map_err(|source| Failure::Write { path: path.to_owned(), source })
}

pub(super) fn exists(path: &Path) -> bool {
    path.exists()
}

/// A folder for the slicer's files, gone when dropped.
pub(super) struct Scratch(PathBuf);

impl Scratch {
    pub(super) fn new() -> Result<Self, Failure> {
        let path = std::env::temp_dir().join(format!("trunnion-{}", std::process::id()));
        create_folder(&path)?;
        Ok(Self(path))
    }

    pub(super) fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}
