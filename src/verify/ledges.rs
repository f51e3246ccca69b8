//! Stretches of line without support, and the small ledges that may go out farther than a line stays up by itself.
//!
//! What hangs at one end of a line goes out by `FREE_SPAN_MM`. The planner lets a patch of at most [`SMALL_MM2`] go out by
//! [`SMALL_LEDGE_MM`], so it is let pass here, too: all that hangs at one end in one layer, and is no farther apart than a [`CELL_MM`] or
//! two, is one patch. All of a print is kept until its end: whatever lies in between, a patch does not become two.

use std::collections::BTreeMap;

use super::acts::Stroke;
use crate::geom::{Sets, Vec3};
use crate::overhang::{SMALL_LEDGE_MM, SMALL_MM2};

/// The grid on which patches are put together, mm.
const CELL_MM: f64 = 1.0;
/// What lies no higher above a layer's lowest line, in heights of it, is of that layer.
const SAME_LAYER: f64 = 0.5;

/// A stretch of line without support.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnsupportedGap {
    /// Whether it begins and ends on material.
    pub(super) held: [bool; 2],
    /// Where it begins and ends.
    pub(super) ends: [Vec3; 2],
    /// Where it begins.
    pub(super) stroke: Stroke,
    /// Its length, mm.
    pub(super) length: f64,
    /// How far along the line that is, mm; behind the line's end where it begins on it and ends on its beginning.
    pub(super) along: [f64; 2],
    /// What it may be as the rim of a ledge, mm; 0 where it is none.
    pub(super) as_rim: f64,
    /// What it may be.
    pub(super) allowed: f64,
}

impl UnsupportedGap {
    /// As one that meets no material.
    pub(super) fn alone(self) -> Self {
        Self { held: [false; 2], ..self }
    }

    fn width(&self) -> f64 {
        f64::from(self.stroke.width)
    }

    fn area_mm2(&self) -> f64 {
        self.length * self.width()
    }

    /// The cells about the way between its ends.
    fn cells(&self) -> impl Iterator<Item = [i64; 2]> {
        let [from, to] = self.ends;
        let steps = ((to - from).norm() / (CELL_MM / 2.0)).ceil().max(1.0) as usize;
        (0..=steps).map(move |k| {
            let at = from + (to - from) * (k as f64 / steps as f64);
            [at.x, at.y].map(|v| (v / CELL_MM).floor() as i64)
        })
    }
}

/// What hangs at one end, of one print.
#[derive(Default)]
pub(super) struct Ledges {
    all: Vec<UnsupportedGap>,
}

impl Ledges {
    /// Takes note of a gap; whether that is all there is to say of it now.
    pub(super) fn keep(&mut self, gap: &UnsupportedGap) -> bool {
        let ledge = gap.held[0] != gap.held[1] && gap.length <= SMALL_LEDGE_MM;
        if ledge && gap.length > gap.width() {
            self.all.push(*gap);
        }
        ledge
    }

    /// The print is over: what is longer than allowed and of no small patch goes to `found`.
    pub(super) fn settle(&mut self, found: &mut Vec<UnsupportedGap>) {
        let mut all = std::mem::take(&mut self.all);
        if all.iter().all(|gap| gap.length <= gap.allowed) {
            return;
        }
        all.sort_by(|a, b| a.ends[0].z.total_cmp(&b.ends[0].z));
        let mut rest = &all[..];
        while let Some(lowest) = rest.first() {
            let top = lowest.ends[0].z + SAME_LAYER * f64::from(lowest.stroke.height);
            let (layer, above) = rest.split_at(rest.partition_point(|gap| gap.ends[0].z <= top));
            found.extend(too_far(layer));
            rest = above;
        }
    }
}

/// What of one layer is longer than allowed and of no small patch.
fn too_far(layer: &[UnsupportedGap]) -> impl Iterator<Item = UnsupportedGap> {
    let patches = patches_mm2(layer);
    layer.iter().zip(patches).filter(|(gap, mm2)| gap.length > gap.allowed && *mm2 > SMALL_MM2).map(|(gap, _)| *gap)
}

/// For each gap of a layer the area of the patch that it is of, mm².
fn patches_mm2(layer: &[UnsupportedGap]) -> Vec<f64> {
    let mut owners: BTreeMap<[i64; 2], u32> = BTreeMap::new();
    let mut sets = Sets::new(layer.len());
    for (i, gap) in layer.iter().enumerate() {
        gap.cells().for_each(|cell| {
            let owner = *owners.entry(cell).or_insert(i as u32);
            sets.join(owner, i as u32);
        });
    }
    for ([x, y], owner) in &owners {
        // The other four of the neighbours look back at this one.
        let ahead = [[1, -1], [1, 0], [1, 1], [0, 1]].map(|[dx, dy]| [x + dx, y + dy]);
        ahead.iter().filter_map(|cell| owners.get(cell)).for_each(|other| {
            sets.join(*owner, *other);
        });
    }
    let mut areas = vec![0.0; layer.len()];
    let roots: Vec<usize> = (0..layer.len()).map(|i| sets.root(i as u32) as usize).collect();
    layer.iter().zip(&roots).for_each(|(gap, root)| areas[*root] += gap.area_mm2());
    roots.iter().map(|root| areas[*root]).collect()
}
