//! Pictures as files.

use std::path::Path;

use crate::input::{BadSetting, InputError};
use crate::view::{Drawing, Format};
use crate::world::{OutputFile, Outputs};

/// A file that a picture may be written to, in the format that its name ends with.
#[derive(Debug)]
pub struct PictureFile {
    file: OutputFile,
    format: Format,
}

impl PictureFile {
    /// The right to write `path`, where a picture is asked for; `name` is the setting's.
    ///
    /// # Errors
    ///
    /// As [`Outputs::claim`], and [`BadSetting::Ending`] for a name that does not end with `.svg`, `.png` or `.pdf`.
    pub fn claim(name: &'static str, path: Option<&Path>, outputs: &mut Outputs) -> Result<Option<Self>, InputError> {
        let Some(path) = path else { return Ok(None) };
        let file = outputs.claim(path)?;
        let format = path.extension().and_then(|ending| Format::of_ending(&ending.to_string_lossy()));
        let allowed = Format::ENDINGS;
        let format = format.ok_or_else(|| BadSetting::Ending { name, path: path.to_owned(), allowed })?;
        Ok(Some(Self { file, format }))
    }

    /// Writes a picture.
    ///
    /// # Errors
    ///
    /// [`FileError::Write`](crate::world::FileError::Write).
    pub fn write(&self, drawing: &Drawing) -> Result<(), InputError> {
        Ok(self.file.write(&drawing.bytes(self.format))?)
    }
}
