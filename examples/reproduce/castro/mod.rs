//! C. E. L. de Castro, 2020: rotations with few overhangs.

mod figures;
mod filament;
mod meshes;
mod tables;

use super::item::{Document, Item, Kind};
use super::sources::Run;

const PHOTO: &str = "a photograph, or a drawing of a printer";
const DRAWING: &str = "a drawing that explains a definition; it has no values";
const LION: &str = "mesh not given: the lion, in a slicing program's preview";

/// What has no values.
const DRAWN: [(&str, &str, &str); 19] = [
    ("1.1.1", "A printer with heated filament", PHOTO),
    ("1.1.2", "A solid that needs supports", PHOTO),
    ("2.1.1", "A transformation of a vector", DRAWING),
    ("2.1.2", "Rotating about the x-axis", DRAWING),
    ("2.1.3", "Rotating about the y-axis", DRAWING),
    ("2.2.1", "Coordinates before and after a rotation", DRAWING),
    ("2.3.1", "Parametric surface", DRAWING),
    ("2.3.2", "Parametric cone and its domain", DRAWING),
    ("2.3.3", "Triangulated surfaces", DRAWING),
    ("2.3.4", "A row of the matrix of facets", DRAWING),
    ("2.3.5", "Triangular base prism", DRAWING),
    ("2.3.6", "Matrices of the prism and its normals", DRAWING),
    ("3.1.1", "Two normals, and which of them overhangs", DRAWING),
    ("3.1.2", "A lion with 0 and 30 % infill", LION),
    ("3.1.3", "Angle between a normal and the vertical", DRAWING),
    ("3.2.1", "A normal that approaches the plane", DRAWING),
    ("3.2.2", "A normal and its projection", DRAWING),
    ("3.3.1", "Staircase effect", DRAWING),
    ("3.3.2", "Unsupported, supported and touched faces", DRAWING),
];

pub(crate) fn document(run: &Run) -> Document {
    let mut items: Vec<Item> =
        DRAWN.iter().map(|(number, caption, why)| Item::left(Kind::Figure, number, caption, *why)).collect();
    items.push(figures::centres());
    items.extend(tables::items(run));
    items.extend(filament::items(run));
    items.extend(figures::items(run));
    Document {
        key: "castro",
        authors: "C. E. L. de Castro",
        title: "Optimal rotations for overhang reduction (master's thesis, Universidade Federal de Santa Catarina)",
        year: 2020,
        items,
    }
}
