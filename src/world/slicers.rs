//! The slicers of this computer, each with a folder for its files that goes with it.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::TempDir;

use super::leftovers::{FOLDER, clear_folders, own};
use super::{FileError, NoSlicer, Slicers};
use crate::geom::Slot;
use crate::mesh::TriangleMesh;
use crate::slicing::{
    ExternalOptions, Flaw, Interrupt, SliceError, SliceJob, SliceSettings, Sliced, Slicer, SlicerChoice, find,
};

/// The slicers that are installed, and the built-in one.
#[derive(Clone, Copy, Debug)]
pub struct Installed {
    /// What stops them; given the folder that is to be cleared then.
    pub interrupt: fn(&Path) -> Interrupt,
}

impl Default for Installed {
    /// Nothing stops them but their time.
    fn default() -> Self {
        Self { interrupt: |_| Interrupt::default() }
    }
}

impl Slicers for Installed {
    fn find(&self, choice: &SlicerChoice, configs: &[PathBuf], timeout: Duration) -> Result<Box<dyn Slicer>, NoSlicer> {
        let (scratch, owned) = scratch("")?;
        let (configs, work_dir) = (configs.to_vec(), scratch.path().to_owned());
        let interrupt = (self.interrupt)(scratch.path());
        let slicer = find(choice, &ExternalOptions { configs, timeout, work_dir, interrupt })?;
        Ok(Box::new(Housed { slicer, _owned: owned, _scratch: scratch }))
    }
}

/// A folder for files of this process, gone when dropped, and what says that it is ours; those of killed processes go first. `called` is part of its
/// name.
///
/// # Errors
///
/// [`FileError::Write`].
pub(crate) fn scratch(called: &str) -> Result<(TempDir, File), FileError> {
    let folder = std::env::temp_dir();
    clear_folders(&folder);
    let made = tempfile::Builder::new().prefix(&format!("{FOLDER}{called}")).tempdir_in(&folder);
    let owned = made.and_then(|made| own(made.path()).map(|owned| (made, owned)));
    owned.map_err(|source| FileError::Write { path: folder, source })
}

/// A slicer with its folder.
struct Housed {
    slicer: Box<dyn Slicer>,
    _owned: File,
    _scratch: TempDir,
}

impl Slicer for Housed {
    fn name(&self) -> &str {
        self.slicer.name()
    }

    fn version(&self) -> &str {
        self.slicer.version()
    }

    fn flaws(&self) -> Vec<Flaw> {
        self.slicer.flaws()
    }

    fn around(&self, settings: &SliceSettings) -> Result<SliceSettings, SliceError> {
        self.slicer.around(settings)
    }

    fn slice(&self, mesh: &TriangleMesh<Slot>, settings: &SliceSettings, job: &SliceJob) -> Result<Sliced, SliceError> {
        self.slicer.slice(mesh, settings, job)
    }
}
