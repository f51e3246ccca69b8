//! What a part stands on: the table, earlier parts, supports.

use std::sync::Arc;

use crate::geom::{Slot, Vec3};
use crate::mesh::TriangleMesh;

/// Heights that differ by less than this share of a layer are the same.
const SAME_LAYER: f64 = 0.01;

/// Facets of a part that lie on something, and what of it is there.
#[derive(Clone, Debug, Default)]
pub struct Footing {
    /// The part's own facets.
    pub own: Vec<[Vec3; 3]>,
    /// What lies below them; empty where that is more than they cover (the table).
    pub below: Vec<[Vec3; 3]>,
}

/// What a part stands on.
#[derive(Clone, Debug, Default)]
pub struct Ground {
    /// Facets that lie on something.
    pub footings: Vec<Footing>,
    /// Whether the lowest layer lies on something that goes on beyond the part, as the table does: then all of it is carried, though it
    /// be wider than the part's foot.
    pub table: bool,
    /// Supports that stand below it; for parts that are printed along +Z of their own frame only.
    pub held: SupportLines,
    /// Other solids that grow with it, layer by layer: they hold what lies no more than two layers of air above them, much as supports do. A designer's own
    /// supports are such.
    pub others: Option<Arc<TriangleMesh<Slot>>>,
    /// Where the surface begins or has a flat ridge, along the direction, mm: layers there are looked at whatever the facets' angles.
    pub begins_mm: Vec<f64>,
}

/// Supports as lines.
#[derive(Clone, Debug, Default)]
pub struct SupportLines {
    /// The top of each layer and the middles of its lines, upward, mm.
    pub layers: Vec<(f64, Vec<[[f64; 2]; 2]>)>,
    /// Width of a line, mm.
    pub line_mm: f64,
    /// The air between them and what lies on them, mm; they end in layers of their own.
    pub gap_mm: f64,
    /// So far beside them a layer may reach, mm: lines lie across sheets that are no farther apart than twice that.
    pub beside_mm: f64,
}

impl SupportLines {
    /// What holds a layer that goes from `under` up by `high`: the lines that end in the air below it and come into one of the boxes `within`.
    pub(super) fn under(&self, under: f64, high: f64, within: Option<&[[[f64; 2]; 2]]>) -> Vec<[[f64; 2]; 2]> {
        let air = (self.gap_mm / high - SAME_LAYER).ceil().max(0.0) * high;
        let near = SAME_LAYER * high;
        let below = self.layers.iter().filter(|(top, _)| (under - air - near..=under + near).contains(top));
        let counts = |[a, b]: &&[[f64; 2]; 2]| {
            let comes_into = |[low, high]: &[[f64; 2]; 2]| {
                [0, 1].into_iter().all(|i| a[i].min(b[i]) <= high[i] && a[i].max(b[i]) >= low[i])
            };
            within.is_none_or(|boxes| boxes.iter().any(comes_into))
        };
        below.flat_map(|(_, lines)| lines).filter(counts).copied().collect()
    }
}
