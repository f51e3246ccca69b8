//! B. Ramos, D. Pinho, D. Martins, A. I. F. Vaz and L. N. Vicente, 2021: orientations of parts, and the order in which they are printed.

mod optima;
mod orders;
mod pictures;

use super::item::{Document, Item, Kind};
use super::sources::Run;

const DUCT: &str = "mesh not given: the duct of an earlier paper of the same group, of which only a picture is printed";

pub(crate) fn document(run: &Run) -> Document {
    let mut items = vec![
        pictures::machine(),
        pictures::two_parts(),
        optima::toy(),
        Item::left(Kind::Figure, "4", "A duct, and its staircase error over both angles", DUCT),
        Item::left(Kind::Figure, "5", "Slices of the duct in three orientations", DUCT),
        pictures::ding(),
        orders::two_boxes(),
        pictures::candelabrum(),
    ];
    items.extend(optima::landscapes(run));
    items.push(pictures::connections());
    items.push(optima::table(run));
    items.extend(orders::candelabrum());
    Document {
        key: "ramos",
        authors: "B. Ramos, D. Pinho, D. Martins, A. I. F. Vaz, L. N. Vicente",
        title: "Optimal 3D printing of complex objects in a 5-axis printer",
        year: 2021,
        items,
    }
}
