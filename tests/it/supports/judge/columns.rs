//! The longest stretch of a column that nothing braces, found on a raster of the lines alone.
//!
//! Of each layer the lines fill cells as wide as a line; cells that meet at an edge or a corner are one piece. A piece that is no longer
//! and no wider than two pitches is alone: a bundle of lines that leans on nothing in its layer. Pieces of successive layers that share a
//! cell are one column, whose stretch ends where it meets a larger piece.

use std::collections::HashMap;

use super::{Layer, Ruler};

/// A piece is alone up to so many pitches.
const ALONE: f64 = 2.0;
/// A line is followed by such parts of a cell.
const FINE: f64 = 0.5;

/// Of each cell of a layer the height over which the column there has been alone, mm; 0 where it is not.
type Cells = HashMap<[i64; 2], f64>;

pub(super) fn longest_alone_mm(layers: &[Layer], ruler: &Ruler) -> f64 {
    let (mut below, mut longest, mut under_mm) = (Cells::new(), 0.0_f64, 0.0);
    for layer in layers {
        let height = layer.top_mm - under_mm;
        // Layers in between that have no supports end all columns.
        if height > 1.5 * ruler.layer_mm {
            below.clear();
        }
        let mut here = Cells::new();
        for piece in pieces(layer, ruler.line_mm) {
            let width = |k: usize| {
                let ends =
                    piece.iter().fold([i64::MAX, i64::MIN], |[low, high], cell| [low.min(cell[k]), high.max(cell[k])]);
                (ends[1] - ends[0] + 1) as f64 * ruler.line_mm
            };
            let alone = width(0).max(width(1)) <= ALONE * ruler.pitch_mm;
            let so_far = piece.iter().filter_map(|cell| below.get(cell)).fold(0.0_f64, |a, b| a.max(*b));
            let stretch = if alone { so_far + height.min(ruler.layer_mm) } else { 0.0 };
            longest = longest.max(stretch);
            here.extend(piece.into_iter().map(|cell| (cell, stretch)));
        }
        (below, under_mm) = (here, layer.top_mm);
    }
    longest
}

/// The pieces of a layer, as cells.
fn pieces(layer: &Layer, cell_mm: f64) -> Vec<Vec<[i64; 2]>> {
    let mut left = std::collections::BTreeSet::new();
    for line in &layer.lines {
        let length = (line.to[0] - line.from[0]).hypot(line.to[1] - line.from[1]);
        let count = (length / (FINE * cell_mm)).ceil().max(1.0) as usize;
        left.extend((0..=count).map(|i| {
            let t = i as f64 / count as f64;
            [0, 1].map(|k| ((line.from[k] + t * (line.to[k] - line.from[k])) / cell_mm).floor() as i64)
        }));
    }
    let mut all = Vec::new();
    while let Some(first) = left.pop_first() {
        let (mut piece, mut next) = (vec![first], 0);
        while let Some(&[x, y]) = piece.get(next) {
            next += 1;
            let beside = (x - 1..=x + 1).flat_map(|u| (y - 1..=y + 1).map(move |v| [u, v]));
            piece.extend(beside.filter(|cell| left.remove(cell)));
        }
        all.push(piece);
    }
    all
}
