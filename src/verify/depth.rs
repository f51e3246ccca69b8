//! Travels through the print's own lines. No slicer goes lower than what it has laid in the same place: layers rise. Where the whole print
//! ends below a travel, as nearly always, nothing is asked.
//!
//! The nozzle may touch what it goes over by what the last digits of heights come to, and no more: what gives way to a line that is laid
//! (`contact_mm`) is torn off by a travel. Heights and places are the machine's, mm, at the pose of the print.

use std::collections::{BTreeMap, HashMap};

use super::acts::{Acts, Go, Kind, Stroke};
use super::report::{Finding, Rule};
use crate::geom::Vec3;
use crate::motion::Pose;

/// How deep a travel may be in what its own print has laid, mm.
pub(super) const DEEPEST_MM: f64 = 0.05;
/// Edge of a cell, mm.
const CELL_MM: f64 = 0.25;
/// From a line's middle to where it is still as high, as a share of its width: beyond it is round.
const FLAT: f64 = 0.35;

impl Finding {
    /// Whether it is a travel through what its own print has laid, no deeper than lines give way.
    pub(crate) fn is_shallow_travel(&self) -> bool {
        // The limit tells: no other finding has it.
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
    tops: Option<HashMap<[i32; 2], f64>>,
}

impl Depth {
    /// Takes a stroke at `pose`, the trace's move `index`; how deep it is in its own print where that is too deep.
    pub(super) fn take(
        &mut self,
        acts: &Acts<'_>,
        stroke: &Stroke,
        (index, pose): (usize, Option<Pose>),
    ) -> Option<f64> {
        let print = stroke.print?;
        let fresh = || Own { pose, from: index, highest: f64::NEG_INFINITY, tops: None };
        let own = self.prints.entry(print).or_insert_with(fresh);
        if own.pose != pose {
            *own = fresh();
        }
        match stroke.kind {
            Kind::Print => {
                own.highest = own.highest.max(stroke.from.z.max(stroke.to.z));
                own.tops.iter_mut().for_each(|tops| lay(tops, stroke));
                None
            }
            Kind::Travel if stroke.from.z.min(stroke.to.z) >= own.highest - DEEPEST_MM => None,
            Kind::Travel => {
                let tops = own.tops.get_or_insert_with(|| laid(acts, print, own.from..index));
                Some(deepest(tops, stroke)).filter(|deep| *deep > DEEPEST_MM)
            }
        }
    }
}

/// What `print` has laid in these moves.
fn laid(acts: &Acts<'_>, print: u32, moves: std::ops::Range<usize>) -> HashMap<[i32; 2], f64> {
    let mut tops = HashMap::new();
    for index in moves {
        if let Some(Go::Stroke(stroke)) = acts.go(&acts.trace.at(index))
            && stroke.kind == Kind::Print
            && stroke.print == Some(print)
        {
            lay(&mut tops, &stroke);
        }
    }
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

fn lay(tops: &mut HashMap<[i32; 2], f64>, stroke: &Stroke) {
    let way = stroke.to - stroke.from;
    let length = way.xy().norm();
    let across = if length > 0.0 { Vec3::new(-way.y, way.x, 0.0) / length } else { Vec3::zeros() };
    let aside = across * (f64::from(stroke.width) * FLAT);
    for at in along(stroke.from, stroke.to) {
        for at in [at, at + aside, at - aside] {
            let top = tops.entry(cell(&at)).or_insert(f64::NEG_INFINITY);
            *top = top.max(at.z);
        }
    }
}

/// How much lower than what is laid the tip goes somewhere on its way, mm; below 0 it goes above it.
fn deepest(tops: &HashMap<[i32; 2], f64>, stroke: &Stroke) -> f64 {
    let depth = |at: Vec3| Some(tops.get(&cell(&at))? - at.z);
    along(stroke.from, stroke.to).filter_map(depth).fold(f64::NEG_INFINITY, f64::max)
}
