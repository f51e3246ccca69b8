//! The files of a packing: a folder with a 3MF for each run.

use std::path::{Path, PathBuf};

use super::error::PackError;
use super::result::PackResult;
use crate::world::{OutputFile, Outputs};

/// The right to write runs into a folder.
#[derive(Debug)]
pub struct Plates {
    folder: PathBuf,
    first: OutputFile,
}

impl Plates {
    /// Makes the folder if it is not there, and claims the first run's file in it, so that what cannot be written is known before the work.
    ///
    /// # Errors
    ///
    /// What [`Outputs::folder`] and [`Outputs::claim`] say.
    pub fn claim(folder: &Path, outputs: &mut Outputs) -> Result<Self, PackError> {
        outputs.folder(folder)?;
        Ok(Self { first: outputs.claim(&folder.join(PackResult::file(0)))?, folder: folder.to_owned() })
    }

    /// Writes all runs. What comes back are runs of an earlier packing beyond these, to be set aside.
    ///
    /// # Errors
    ///
    /// As [`Outputs::claim`] and [`OutputFile::write`].
    pub fn write(self, done: &PackResult, outputs: &mut Outputs) -> Result<Vec<OutputFile>, PackError> {
        let path = |index| self.folder.join(PackResult::file(index));
        for index in 0..done.plates.len() {
            let bytes = done.threemf(index);
            if index == 0 { self.first.write(&bytes)? } else { outputs.claim(&path(index))?.write(&bytes)? }
        }
        let earlier = (done.plates.len()..).map(path).take_while(|path| path.is_file());
        Ok(earlier.map(|path| outputs.claim(&path)).collect::<Result<_, _>>()?)
    }
}
