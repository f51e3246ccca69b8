//! Files: whole ones in, whole ones out, never half of one.

use std::path::{Path, PathBuf};

use super::Failure;

pub(super) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path).map_err(|source| Failure::Read { path: path.to_owned(), source })
}

pub(super) fn size(path: &Path) -> Result<u64, Failure> {
    std::fs::metadata(path).map(|m| m.len()).map_err(|source| Failure::Read { path: path.to_owned(), source })
}

pub(super) fn read_text(path: &Path) -> Result<String, Failure> {
    let bytes = read(path)?;
    String::from_utf8(bytes).map_err(|_| Failure::Usage(format!("{}: not a text file", path.display())))
}

/// Refuses an output that could not be written at the end, or that would take the place of an input.
pub(super) fn check_output(path: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    let name = path.display();
    if path.is_dir() {
        return Err(Failure::Usage(format!("{name} is a folder; give the name of a file for the output")));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(Failure::Usage(format!("{name}: there is no folder {}; make it first", folder.display())));
    }
    let target = path.canonicalize().ok();
    if target.is_some() && inputs.iter().any(|input| input.canonicalize().ok() == target) {
        return Err(Failure::Usage(format!("{name} is also an input; give the output another name")));
    }
    Ok(())
}

/// Writes beside the target and renames, so that a reader sees the old file or the new one.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let failed = |source| Failure::Write { path: path.to_owned(), source };
    // Two runs to one target must not write into each other's file.
    let beside = with_suffix(path, &format!(".writing-{}", std::process::id()));
    let done = std::fs::write(&beside, bytes).and_then(|()| std::fs::rename(&beside, path));
    if done.is_err() {
        let _ = std::fs::remove_file(&beside);
    }
    done.map_err(failed)
}

/// Takes a printable file of an earlier run out of the way: `x.gcode` becomes `x.gcode.stale`.
pub(super) fn set_aside(path: &Path) -> Option<PathBuf> {
    let aside = with_suffix(path, ".stale");
    if !path.is_file() {
        return None;
    }
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
        // A process number may be in use twice where containers share a folder; a folder that is new is ours alone.
        let path = |n: u32| std::env::temp_dir().join(format!("trunnion-{}-{n}", std::process::id()));
        let mut number = 0;
        loop {
            match std::fs::create_dir(path(number)) {
                Ok(()) => return Ok(Self(path(number))),
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => number += 1,
                Err(source) => return Err(Failure::Write { path: path(number), source }),
            }
        }
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

pub(super) fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}
