//! What is looked at: a program on its machine, as one page that needs nothing else.
//!
//! ```text
//! Trace + bytes --Program::of--> columns     parts --Shapes::of--> facets     bodies --Machine::of--> hulls
//! Scene --packed--> one compressed block --page(document, block)--> HTML
//! ```
//!
//! A drawing of a line in space, as SVG:
//!
//! ```
//! use trunnion::geom::Vec3;
//! use trunnion::view::{Anchor, Drawing, Eye, Format, INK};
//!
//! // Seen from the front, X points to the right on paper and Z up, where the paper's own y points down.
//! let eye = Eye::at(0.0, 0.0);
//! let [right, down, _] = eye.seen(&Vec3::new(30.0, 5.0, 20.0));
//! assert_eq!((right, down), (30.0, -20.0));
//!
//! let mut drawing = Drawing::new([100.0, 50.0], "one line");
//! drawing.line(vec![[10.0, 40.0], [10.0 + right, 40.0 + down]], 1.0, INK);
//! drawing.text([50.0, 48.0], 8.0, Anchor::Middle, "from the front");
//! let svg = String::from_utf8(drawing.bytes(Format::Svg))?;
//! assert!(svg.starts_with("<svg") && svg.contains("from the front"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The page (`page/`, plain JavaScript on WebGL 2) moves nothing by itself: positions are the trace's, in whole micrometres; the
//! motion of each pose is `motion`'s; only while the table turns does it use the chain's own constants. Looked at before it was written:
//! three.js (1.3 MB, and third-party code in this repository), and renderers that come as crates (wgpu, bevy: a web assembly toolchain,
//! hundreds of crates); for lines, hulls and one camera a thousand lines do.
//!
//! Units: mm, seconds, degrees in what people read, radians in matrices. This room must not know rules, plans, JSON or files: names
//! and findings are the document's.

mod drawing;
mod eye;
mod frame;
mod hull;
mod landscape;
mod machine;
mod pack;
mod page;
mod program;
mod regions;
mod shapes;
mod sheet;
mod solids;
#[cfg(test)]
mod tests;
mod text;
mod thumbnail;

pub use crate::geom::Hull;
pub use drawing::{Anchor, Colour, Drawing, DrawnMark, Format, INK, Picture, width_of};
pub use eye::Eye;
pub use frame::{Arrow, Frame, Ghost, JOINT_COLOUR, Side};
pub use landscape::{Dip, Landscape};
pub use machine::{DrawnBody, DrawnMachine};
pub use page::{RENDERER, page, pair};
pub use program::{DrawnPose, DrawnProgram, Style, flag};
pub use shapes::Shapes;
pub use sheet::Sheet;
pub use solids::{Joint, Surface};
pub use thumbnail::thumbnails;

use pack::{Column, deflated};

/// Everything that a page draws.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The machine.
    pub machine: DrawnMachine,
    /// The parts, table frame.
    pub shapes: Shapes,
    /// The program; `None` where a plan alone is shown.
    pub program: Option<DrawnProgram>,
}

/// A scene, compressed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PackedScene {
    /// The block.
    pub bytes: Vec<u8>,
    /// Whether the file's text is in it.
    pub has_text: bool,
}

/// What a page may take: so much, and so much a move, bytes.
pub const PAGE_BYTES: usize = 2_000_000;
/// See [`PAGE_BYTES`].
pub const BYTES_A_MOVE: usize = 6;
/// Of [`PAGE_BYTES`], for the page's own program and the document.
const OWN_BYTES: usize = 200_000;

impl Scene {
    /// The scene as one block; the text of a file is left out where it would make the page larger than [`PAGE_BYTES`] and
    /// [`BYTES_A_MOVE`] for each move.
    pub fn packed(&self) -> PackedScene {
        let shapes = [&self.shapes.vertices, &self.shapes.facets];
        let Some(program) = &self.program else {
            return PackedScene { bytes: deflated(shapes), has_text: false };
        };
        let with = |text: [&Column; 2]| deflated(shapes.into_iter().chain(&program.columns).chain(text));
        let bytes = with([&program.text.runs, &program.text.kept]);
        let most = PAGE_BYTES - OWN_BYTES + BYTES_A_MOVE * program.moves;
        if bytes.len() / 3 * 4 <= most {
            return PackedScene { bytes, has_text: true };
        }
        let none = Column::default();
        PackedScene { bytes: with([&none, &none]), has_text: false }
    }
}
