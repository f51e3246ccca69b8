//! M. Leitereg, 2020: packing boxes and models, and planning supports as a flow.

mod packing;
mod supports;

use super::item::{Document, Item, Kind};
use super::sources::Run;

pub(crate) fn document(run: &Run) -> Document {
    let lattice = "drawings of lattices by an engineer, without measures: any structure can stand along an arc";
    let mut items = vec![supports::ball(run), supports::price(), supports::crosses()];
    items.push(supports::apart());
    items.push(Item::left(Kind::Figure, "after 2", "Lattice structures (unnumbered)", lattice));
    items.push(packing::runs(run));
    items.push(packing::filling(run));
    items.extend(supports::graphs(run));
    Document {
        key: "leitereg",
        authors: "M. Leitereg",
        title: "Packing and support planning algorithms in 3D printing (master's thesis, Eötvös Loránd University)",
        year: 2020,
        items,
    }
}
