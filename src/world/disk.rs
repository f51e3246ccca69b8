//! The disk: whole files of a size that can be held are read. What is written is in `outputs.rs`.

use std::fs::{File, Metadata};
use std::io::Read;
use std::path::{Path, PathBuf};

use super::{FileError, Files};

/// Beyond this nothing is read: it could not be held beside what is made of it.
const LARGEST: u64 = 4 << 30;

/// What `metadata` is of, where it is no file.
pub(super) fn kind_of(metadata: &Metadata) -> Option<&'static str> {
    let kind = metadata.file_type();
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return Some("a pipe");
        }
        if kind.is_socket() {
            return Some("a socket");
        }
        if kind.is_char_device() || kind.is_block_device() {
            return Some("a device");
        }
    }
    match () {
        () if kind.is_dir() => Some("a folder"),
        () if kind.is_file() => None,
        () => Some("not a regular file"),
    }
}

/// This computer's disk.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Files for Disk {
    fn size(&self, path: &Path) -> Result<u64, FileError> {
        let metadata = std::fs::metadata(path).map_err(|source| FileError::Read { path: path.to_owned(), source })?;
        let (path, bytes, most) = (path.to_owned(), metadata.len(), LARGEST);
        match kind_of(&metadata) {
            Some(kind) => Err(FileError::NotAFile { path, kind }),
            None if bytes > most => Err(FileError::TooLarge { path, bytes, most }),
            None => Ok(bytes),
        }
    }

    fn read(&self, path: &Path) -> Result<Vec<u8>, FileError> {
        let size = self.size(path)?;
        let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or(0));
        // One more than there may be: a file that grows meanwhile is cut there and fails as what it is then.
        let read = File::open(path).and_then(|file| file.take(LARGEST + 1).read_to_end(&mut bytes));
        read.map(|_| bytes).map_err(|source| FileError::Read { path: path.to_owned(), source })
    }

    fn exists(&self, path: &Path) -> bool {
        path.exists()
    }

    /// `trunnion/profiles` in `$XDG_CONFIG_HOME`, which counts only where it is absolute, else in `~/.config` (XDG Base Directory
    /// Specification 0.8).
    fn own_profiles(&self) -> Option<PathBuf> {
        let absolute = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
        let home = || absolute("HOME").map(|home| home.join(".config"));
        absolute("XDG_CONFIG_HOME").or_else(home).map(|config| config.join("trunnion/profiles"))
    }

    fn toml_files(&self, folder: &Path) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let mut all: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
        all.sort();
        all
    }

    fn names_in(&self, folder: &Path) -> Vec<String> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut all: Vec<String> =
            entries.filter(|e| e.path().is_file()).filter_map(|e| e.file_name().into_string().ok()).collect();
        all.sort();
        all
    }

    fn seen_from(&self, file: &Path, folder: &Path) -> PathBuf {
        let here = |path: &Path| std::fs::canonicalize(if path.as_os_str().is_empty() { Path::new(".") } else { path });
        // The file itself may be still to come.
        let of_file = file.parent().zip(file.file_name()).map(|(folder, name)| Ok(here(folder)?.join(name)));
        let of_file: Option<std::io::Result<PathBuf>> = of_file;
        let (Some(Ok(there)), Ok(from), Ok(working)) = (of_file, here(folder), here(Path::new(""))) else {
            return file.to_owned();
        };
        if file.is_absolute() || from == working {
            return file.to_owned();
        }
        let shared = there.components().zip(from.components()).take_while(|(a, b)| a == b).count();
        let up = std::iter::repeat_n(Path::new(".."), from.components().count() - shared);
        up.map(Path::as_os_str).chain(there.components().skip(shared).map(|c| c.as_os_str())).collect()
    }
}

/// `path` with `suffix` behind its whole name.
pub fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}
