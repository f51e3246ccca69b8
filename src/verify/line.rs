//! A printed line with the filament that it takes and the filament that its cross-section holds: what the rules of flow look at.

use std::f64::consts::PI;

use super::prints::{Level, PrintedPart};
use crate::gcode::marks::Role;
use crate::section::Segment;
use crate::trace::TraceMove;

/// What the last digits of its ends add to what a line may be off, mm of length.
pub(super) const DIGITS_MM: f64 = 0.004;
/// E is written to so much, mm of filament, half of it either way and a little more.
pub(super) const E_DIGITS_MM: f64 = 0.6e-5;
/// Filament in lines shorter than this says little of their cross-section, mm.
const SHORT_MM: f64 = 0.15;

/// A line long enough to tell.
pub(super) struct Line {
    pub(super) m: TraceMove,
    pub(super) length: f64,
    pub(super) width: f64,
    pub(super) height: f64,
    /// Whether its width and height are.
    pub(super) stated: bool,
    /// Its filament, and what its cross-section holds, mm³.
    pub(super) laid: f64,
    pub(super) held: f64,
}

impl Line {
    fn of(printed: &PrintedPart<'_>, level: &Level, m: TraceMove) -> Option<Self> {
        let length = m.ends().map(|[from, to]| (to - from).norm()).filter(|length| *length >= SHORT_MM)?;
        let stated = m.width.is_some() && m.height.is_some();
        let (width, height) = (printed.width(&m, level), m.height.unwrap_or_else(|| level.height()));
        let laid = m.e * printed.filament_mm2;
        let of = |area_mm2: f64| area_mm2 * length * printed.flow.multiplier;
        let mut held = of(printed.flow.bead.area(width, height));
        // A line narrower than high is drawn by the formula of wider ones, or as the round thread that it is (PrusaSlicer's 3D honeycomb).
        let thread = of(PI / 4.0 * width * width);
        if stated && width < height && (laid - thread).abs() < (laid - held).abs() {
            held = thread;
        }
        Some(Self { m, length, width, height, stated, laid, held })
    }

    /// Whether the slicer calls it a thread over air.
    pub(super) fn is_thread(&self) -> bool {
        matches!(self.m.role, Role::Bridge | Role::Overhang)
    }

    /// Laid over held.
    pub(super) fn ratio(&self) -> f64 {
        self.laid / self.held
    }

    /// Its middle, from above.
    pub(super) fn axis(&self) -> Option<Segment> {
        self.m.ends().map(|[from, to]| [[from.x, from.y], [to.x, to.y]])
    }
}

/// The lines of a layer that have a cross-section of their own: ironing has next to none.
pub(super) fn lines(printed: &PrintedPart<'_>, level: &Level) -> Vec<Line> {
    let beads = level.beads.iter().map(|&index| printed.bead(index)).filter(|m| m.role != Role::Ironing);
    let mut lines = Vec::with_capacity(level.beads.len());
    lines.extend(beads.filter_map(|m| Line::of(printed, level, m)));
    lines
}
