//! Rule `in-air`: filament is laid on or against something.
//!
//! A bead spans from its tip's height down by its own. Below it something must reach its underside to within
//! [`SQUEEZE`]; or the line beside it, laid before in the same layer, carries it. What was printed in earlier setups may
//! lie a layer deeper: where a part grows out of a slanting surface, its slices begin in mid-layer.
//! Lines may span a gap whose length depends on what the slicer says they are.

use std::collections::VecDeque;

use super::field::Field;
use super::marks::Role;
use super::material::deposit;
use super::trace::Stroke;

/// The part of a layer by which the support below may fall short of the bead's underside.
const SQUEEZE: f64 = 0.35;
/// Spacing of the places looked at along a line, mm.
const SAMPLE_MM: f64 = 0.3;
/// What a wall or an unnamed line may span, mm, or two line widths if that is more: strings of this length stay up.
const WALL_SPAN_MM: f64 = 2.0;
/// What infill may span: the cells of sparse infill below a skin.
const INFILL_SPAN_MM: f64 = 12.0;
/// What a bridge or an overhang may span.
const BRIDGE_SPAN_MM: f64 = 60.0;
/// The line itself carries nothing until the tip is so many widths ahead: its own tail is no support.
const TAIL_WIDTHS: f64 = 4.0;

/// A stretch of line without support.
#[derive(Clone, Copy)]
pub(super) struct Gap {
    /// Where it begins.
    pub(super) stroke: Stroke,
    /// Its length, mm.
    pub(super) length: f64,
    /// What it may be.
    pub(super) allowed: f64,
}

/// The line being laid.
#[derive(Default)]
pub(super) struct Laying {
    gap: Option<Gap>,
    tail: VecDeque<(Stroke, f64)>,
    travelled: f64,
}

impl Laying {
    /// Lays `stroke`; the gaps that end on it go to `found`.
    pub(super) fn lay(&mut self, stroke: &Stroke, role: Role, field: &mut Field, found: &mut Vec<Gap>) {
        let along = stroke.to - stroke.from;
        let length = along.norm();
        let count = (length / SAMPLE_MM).ceil().max(1.0);
        let (width, height) = (f64::from(stroke.width), f64::from(stroke.height));
        let allowed = match role {
            Role::Wall => WALL_SPAN_MM.max(2.0 * width),
            Role::Infill => INFILL_SPAN_MM,
            Role::Bridge => BRIDGE_SPAN_MM,
        };
        for i in 0..count as usize {
            let p = stroke.from + along * ((i as f64 + 0.5) / count);
            let under = p.z - height * (1.0 + SQUEEZE);
            if field.stands([p.x, p.y], width, under, under - height) {
                self.end_gap(found);
            } else {
                let gap = self.gap.get_or_insert(Gap { stroke: *stroke, length: 0.0, allowed });
                gap.length += length / count;
                gap.allowed = gap.allowed.max(allowed);
            }
        }
        self.travelled += length;
        self.tail.push_back((*stroke, self.travelled));
        while self.tail.front().is_some_and(|(_, end)| self.travelled - end > TAIL_WIDTHS * width) {
            if let Some((old, _)) = self.tail.pop_front() {
                deposit(field, &old);
            }
        }
    }

    /// The line ends here.
    pub(super) fn end(&mut self, field: &mut Field, found: &mut Vec<Gap>) {
        self.end_gap(found);
        self.tail.drain(..).for_each(|(stroke, _)| deposit(field, &stroke));
        self.travelled = 0.0;
    }

    fn end_gap(&mut self, found: &mut Vec<Gap>) {
        found.extend(self.gap.take().filter(|gap| gap.length > gap.allowed));
    }
}
