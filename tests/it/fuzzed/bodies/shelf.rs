//! A world whose files are in hand: no target reads what its bytes happen to name.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use trunnion::job::{FileError, Files, Silent, World};

/// Files that are on no disk.
pub(super) struct Shelf(pub(super) BTreeMap<PathBuf, Vec<u8>>);

impl Shelf {
    pub(super) fn empty() -> Self {
        Self(BTreeMap::new())
    }

    /// This computer with these files in the place of its own.
    pub(super) fn world(&self) -> World<'_> {
        World { files: self, ..World::here(&Silent) }
    }
}

impl Files for Shelf {
    fn size(&self, path: &Path) -> Result<u64, FileError> {
        self.read(path).map(|bytes| bytes.len() as u64)
    }

    fn read(&self, path: &Path) -> Result<Vec<u8>, FileError> {
        let missing = || FileError::Read { path: path.to_owned(), source: std::io::ErrorKind::NotFound.into() };
        self.0.get(path).cloned().ok_or_else(missing)
    }

    fn exists(&self, path: &Path) -> bool {
        self.0.contains_key(path)
    }

    fn names_in(&self, folder: &Path) -> Vec<String> {
        let inside = self.0.keys().filter(|path| path.parent() == Some(folder));
        inside.filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned())).collect()
    }
}
