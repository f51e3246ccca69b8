//! J. Boogers, 2024: part orientation by gradients of a smooth support volume.

mod convex;
mod experiments;
mod nonconvex;
mod poses;
mod shapes;

use super::item::{Document, Item, Kind};
use super::sources::Run;

/// Drawings that explain a process or define symbols.
const DRAWN: [(&str, &str); 13] = [
    ("1.2", "Method of Ezair et al.: the volume below the top surface less that of the model"),
    ("2.1", "Processing pipeline of additive manufacturing"),
    ("2.2", "Slicing of a part into layers"),
    ("2.3", "Staircase effect of a sphere"),
    ("2.4", "Fused deposition modelling"),
    ("2.5", "Stereolithography"),
    ("2.6", "Selective laser sintering"),
    ("3.1", "A square, its facets and the support area below it"),
    ("3.3", "A facet above the bed"),
    ("3.4", "A facet projected to the bed"),
    ("4.1", "Volume below a facet that carries supports"),
    ("4.2", "Three states of a facet"),
    ("4.3", "Connectivity set of a facet"),
];

pub(crate) fn document(run: &Run) -> Document {
    let drawing = "a drawing that explains; it has no values";
    let mut items: Vec<Item> =
        DRAWN.iter().map(|(number, caption)| Item::left(Kind::Figure, number, caption, drawing)).collect();
    let survey = "a survey of processes in words; nothing is computed";
    items.push(Item::left(Kind::Table, "2.1", "Additive manufacturing techniques and their characteristics", survey));
    let cone = "the two sets are drawn on a decimated bunny of the thesis's own, with a threshold in equation 4.3 that the thesis only proposes";
    items.push(Item::left(Kind::Figure, "6.2", "Connectivity sets with a threshold and without", cone));
    items.push(poses::direction());
    items.extend(convex::items(run));
    items.extend(nonconvex::items(run));
    items.extend(experiments::items(run));
    items.extend(poses::items(run));
    Document {
        key: "boogers",
        authors: "J. Boogers",
        title: "Gradient based optimization of part orientation in 3D printing (master's thesis, Delft University of Technology)",
        year: 2024,
        items,
    }
}
