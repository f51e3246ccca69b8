//! What pictures are of: plans, reasons, parts and supports as frames for [`crate::view`], and the files they go to.

mod machine;
mod parts;
mod plan;

use std::path::Path;

use super::{BadSetting, Error, OutputFile, Outputs};
use crate::geom::Vec3;
use crate::planning::Workpiece;
use crate::view::{self, Colour, Drawing, Format, Surface};

pub(super) use parts::{Painted, SUPPORT_WORD, coloured, cut_up, solids, standing};
pub(super) use plan::{Told, plan_sheet, reasons_sheet};

pub(super) const TABLE: Colour = [214, 219, 226];
pub(super) const BEFORE: Colour = [150, 160, 174];
pub(super) const NEW: Colour = [240, 170, 60];
pub(super) const STRUCK: Colour = [204, 121, 167];
pub(super) const HEAD: Colour = [47, 62, 78];
pub(super) const OVERHANG: Colour = [213, 94, 0];
pub(super) const SUPPORT: Colour = [86, 180, 233];
pub(super) const PART: Colour = [218, 212, 200];
/// Told apart by colour-blind people too (Okabe and Ito 2008).
pub(super) const KINDS: [Colour; 6] =
    [[230, 159, 0], [86, 180, 233], [0, 158, 115], [240, 228, 66], [213, 94, 0], [204, 121, 167]];

/// A file that a picture may be written to, in the format that its name ends with.
#[derive(Debug)]
pub struct PictureFile {
    file: OutputFile,
    format: Format,
}

impl PictureFile {
    /// The right to write `path`; `name` is the setting's.
    ///
    /// # Errors
    ///
    /// As [`Outputs::claim`], and [`BadSetting::Ending`] for a name that does not end with `.svg`, `.png` or `.pdf`.
    pub fn claim(name: &'static str, path: &Path, outputs: &mut Outputs) -> Result<Self, Error> {
        let file = outputs.claim(path)?;
        let format = path.extension().and_then(|ending| Format::of_ending(&ending.to_string_lossy()));
        let allowed = Format::ENDINGS;
        let format = format.ok_or_else(|| BadSetting::Ending { name, path: path.to_owned(), allowed })?;
        Ok(Self { file, format })
    }

    /// Writes a picture.
    ///
    /// # Errors
    ///
    /// [`Error::Write`].
    pub fn write(&self, drawing: &Drawing) -> Result<(), Error> {
        self.file.write(&drawing.bytes(self.format))
    }
}

/// The model on its table in small pictures, as comments for the head of its program; each part in a colour of its own.
pub(super) fn thumbnails(workpiece: &Workpiece<'_>) -> String {
    let part = |(i, mesh)| Surface { edges: false, ..Surface::of(mesh, KINDS[i % KINDS.len()]) };
    view::thumbnails(&workpiece.parts.iter().enumerate().map(part).collect::<Vec<_>>())
}

/// The farthest place along Z; `None` of none.
fn highest<'a>(points: impl Iterator<Item = &'a Vec3>) -> Option<Vec3> {
    points.copied().max_by(|a, b| a.z.total_cmp(&b.z))
}
