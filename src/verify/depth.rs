//! Travels through the print's own lines. No slicer goes lower than what it has laid in the same place: layers rise. Where the whole print
//! ends below a travel, as nearly always, nothing is asked.
//!
//! The nozzle may touch what it goes over by what the last digits of heights come to, and no more: what gives way to a line that is laid
//! (`contact_mm`) is torn off by a travel. Heights and places are the machine's, mm, at the pose of the print.
//!
//! Cells are made of at most [`MOST_CELLS`], a quarter of a square metre, and a travel is looked at within the print's bounds alone: what a file
//! claims to lay costs no more.

use std::collections::{BTreeMap, HashMap};

use super::acts::{Acts, Kind, Stroke};
use super::report::{Finding, Rule};
use crate::geom::{Bounds, Vec3};
use crate::motion::Pose;

/// How deep a travel may be in what its own print has laid, mm.
pub(super) const DEEPEST_MM: f64 = 0.05;
/// Edge of a cell, mm.
const CELL_MM: f64 = 0.25;
/// Cells at most.
const MOST_CELLS: usize = 4_000_000;
/// From a line's middle to where it is still as high, as a share of its width: beyond it is round.
const FLAT: f64 = 0.35;

impl Finding {
    /// Whether it is a travel through what its own print has laid, no deeper than lines give way.
    pub(crate) fn is_shallow_travel(&self) -> bool {
        // The limit tells: of collisions no other has it, since `contact_mm` is at least 0.07.
        self.rule == Rule::HeadCollision && self.allowed.to_bits() == DEEPEST_MM.to_bits()
    }
}

/// What every print has laid, as far as anybody asks.
#[derive(Default)]
pub(super) struct Depth {
    prints: BTreeMap<u32, Own>,
}

/// What one print has laid at one pose.
struct Own {
    pose: Option<Pose>,
    /// Where that began in the trace.
    from: usize,
    highest: f64,
    /// The height of each cell; made once a travel is lower than the highest.
    tops: Option<Tops>,
}

/// How high what is laid reaches in each cell, and the bounds of it.
struct Tops {
    cells: HashMap<[i32; 2], f64>,
    bounds: Bounds,
}

impl Depth {
    /// Takes a stroke at `pose`, the trace's move `index`; how deep it is in its own print where that is too deep.
    pub(super) fn take(&mut self, acts: &Acts<'_>, stroke: &Stroke, index: usize, pose: Option<Pose>) -> Option<f64> {
        let print = stroke.print?;
        let fresh = || Own { pose, from: index, highest: f64::NEG_INFINITY, tops: None };
        let own = self.prints.entry(print).or_insert_with(fresh);
        if own.pose != pose {
            *own = fresh();
        }
        match stroke.kind {
            Kind::Print => {
                own.highest = own.highest.max(stroke.from.z.max(stroke.to.z));
                own.tops.iter_mut().for_each(|tops| tops.lay(stroke));
                None
            }
            Kind::Travel if stroke.from.z.min(stroke.to.z) >= own.highest - DEEPEST_MM => None,
            Kind::Travel => {
                let tops = own.tops.get_or_insert_with(|| laid(acts, print, own.from..index));
                Some(tops.deepest(stroke)).filter(|deep| *deep > DEEPEST_MM)
            }
        }
    }
}

/// What `print` has laid in these moves.
fn laid(acts: &Acts<'_>, print: u32, moves: std::ops::Range<usize>) -> Tops {
    let mut tops = Tops { cells: HashMap::new(), bounds: Bounds::EMPTY };
    let strokes = moves.filter_map(|index| acts.stroke(index));
    strokes.filter(|stroke| stroke.kind == Kind::Print && stroke.print == Some(print)).for_each(|s| tops.lay(&s));
    tops
}

fn cell(at: &Vec3) -> [i32; 2] {
    [at.x, at.y].map(|v| (v / CELL_MM).floor() as i32)
}

/// Places along a way, half a cell apart.
fn along(from: Vec3, to: Vec3) -> impl Iterator<Item = Vec3> {
    let steps = ((to - from).xy().norm() / (CELL_MM / 2.0)).ceil().max(1.0) as usize;
    (0..=steps).map(move |i| from + (to - from) * (i as f64 / steps as f64))
}

impl Tops {
    fn lay(&mut self, stroke: &Stroke) {
        let way = stroke.to - stroke.from;
        let length = way.xy().norm();
        let across = if length > 0.0 { Vec3::new(-way.y, way.x, 0.0) / length } else { Vec3::zeros() };
        let aside = across * (f64::from(stroke.width) * FLAT);
        for at in along(stroke.from, stroke.to) {
            if self.cells.len() >= MOST_CELLS {
                break;
            }
            for at in [at, at + aside, at - aside] {
                let top = self.cells.entry(cell(&at)).or_insert(f64::NEG_INFINITY);
                *top = top.max(at.z);
            }
        }
        // With what is beside its middle.
        let reach = f64::from(stroke.width) + CELL_MM;
        self.bounds = self.bounds.union(&Bounds::of([stroke.from, stroke.to]).inflated(reach));
    }

    /// How much lower than what is laid the tip goes somewhere on its way, mm; below 0 it goes above it.
    fn deepest(&self, stroke: &Stroke) -> f64 {
        let Some([from, to]) = self.within(stroke) else { return f64::NEG_INFINITY };
        let depth = |at: Vec3| Some(self.cells.get(&cell(&at))? - at.z);
        along(from, to).filter_map(depth).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The part of a way within the bounds, seen from above (Y.-D. Liang and B. A. Barsky, 1984).
    fn within(&self, stroke: &Stroke) -> Option<[Vec3; 2]> {
        let way = stroke.to - stroke.from;
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for i in 0..2 {
            let [low, high] = [self.bounds.min[i], self.bounds.max[i]].map(|end| end - stroke.from[i]);
            if way[i] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (near, far) = (low / way[i], high / way[i]);
            (first, last) = (first.max(near.min(far)), last.min(near.max(far)));
        }
        (first <= last).then(|| [first, last].map(|share| stroke.from + way * share))
    }
}
