//! G2 and G3: their words, and the polyline that stands for one. mm, radians; the XY plane.

use super::{ReplayError, sane};
use crate::gcode::ParsedLine;
use crate::gcode::meaning::Firmware;
use crate::geom::Vec3;

/// Turns of one arc: each is some hundred chords for everybody who follows it.
pub(super) const MOST_TURNS: u32 = 10;

/// An arc in the XY plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// From the start to the centre, mm.
    pub to_centre: [f64; 2],
    /// G2.
    pub clockwise: bool,
    /// Given by radius (`R`) rather than by centre (`I`, `J`).
    pub by_radius: Option<f64>,
    /// Full turns before the end is taken (`P`), at least 1.
    pub turns: u32,
}

pub(super) fn arc(clockwise: bool, line: &ParsedLine, firmware: Firmware) -> Result<Arc, ReplayError> {
    let word = |letter| line.value(letter).map(|value| sane(letter, value)).transpose();
    let by_radius = word(b'R')?;
    if by_radius.is_none() && !line.has(b'I') && !line.has(b'J') {
        return Err(ReplayError::ArcCentre);
    }
    let to_centre = [word(b'I')?.unwrap_or(0.0), word(b'J')?.unwrap_or(0.0)];
    // Marlin makes so many circles first, others pass it over; a circle that ends where it began is one circle to whoever wrote P1.
    let one_circle = line.value(b'P') == Some(1.0) && by_radius.is_none() && !line.has(b'X') && !line.has(b'Y');
    if line.has(b'P') && firmware != Firmware::LinuxCnc && !one_circle {
        return Err(ReplayError::StrayWord('P'));
    }
    let turns = line.value(b'P').unwrap_or(1.0);
    if turns.fract() != 0.0 || !(0.0..=f64::from(MOST_TURNS)).contains(&turns) {
        return Err(ReplayError::ArcTurns(turns));
    }
    let turns = (turns as u32).max(1);
    Ok(Arc { to_centre, clockwise, by_radius, turns })
}

/// How far chords may leave an arc, mm: far below every tolerance that is asked of a place.
pub const CHORD_MM: f64 = 0.01;

/// Chords that a program's arcs may come to, whatever its size; see [`ChordBudget`].
const FREE_CHORDS: usize = 1 << 18;
/// Chords for each byte of an arc's line besides these: a half circle of 250 mm has 175 in about 45 bytes.
const CHORDS_PER_BYTE: usize = 4;

/// Chords that are left to a program's arcs: as many as its bytes pay for, so that no file costs more than its size tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ChordBudget {
    left: usize,
}

impl Default for ChordBudget {
    fn default() -> Self {
        Self { left: FREE_CHORDS }
    }
}

impl ChordBudget {
    /// Takes the chords of an arc whose line has so many bytes, within `reach_mm` of zero along X and Y.
    ///
    /// # Errors
    ///
    /// [`ReplayError::ArcBeyond`] and [`ReplayError::ManyChords`]; no chord has been made.
    pub(super) fn take(&mut self, turn: &ArcTurn, bytes: usize, reach_mm: f64) -> Result<(), ReplayError> {
        let farthest = turn.farthest();
        if farthest > reach_mm {
            return Err(ReplayError::ArcBeyond { farthest, reach_mm });
        }
        let chords = turn.chords(CHORD_MM);
        match (self.left + CHORDS_PER_BYTE * bytes).checked_sub(chords) {
            Some(left) => self.left = left,
            None => return Err(ReplayError::ManyChords(chords)),
        }
        Ok(())
    }
}

/// An arc between its ends: the way of the tip in the XY plane. mm, radians.
pub(super) struct ArcTurn {
    from: Vec3,
    to: Vec3,
    centre: [f64; 2],
    radius: f64,
    /// The angle at which it begins.
    start: f64,
    /// How far it turns, in its own sense.
    sweep: f64,
    clockwise: bool,
}

impl ArcTurn {
    pub(super) fn of(from: Vec3, to: Vec3, arc: &Arc) -> Self {
        let (cx, cy) = match arc.by_radius {
            None => (from.x + arc.to_centre[0], from.y + arc.to_centre[1]),
            Some(radius) => centre_of(from, to, radius, arc.clockwise),
        };
        let radius = (from.x - cx).hypot(from.y - cy);
        let start = (from.y - cy).atan2(from.x - cx);
        let mut sweep = (to.y - cy).atan2(to.x - cx) - start;
        let turn = std::f64::consts::TAU;
        if arc.clockwise {
            sweep = -sweep;
        }
        sweep = sweep.rem_euclid(turn);
        let closed = (to.x - from.x).hypot(to.y - from.y) < 1e-9;
        if closed && arc.by_radius.is_none() {
            sweep = turn;
        }
        sweep += turn * f64::from(arc.turns - 1);
        Self { from, to, centre: [cx, cy], radius, start, sweep, clockwise: arc.clockwise }
    }

    /// Chords that stay within `tolerance` mm of the arc, at least one.
    fn chords(&self, tolerance: f64) -> usize {
        let step = 2.0 * (1.0 - (tolerance / self.radius.max(tolerance)).min(1.0)).acos();
        (self.sweep / step.max(1e-3)).ceil().max(1.0) as usize
    }

    /// The place after the share `part` of the turn.
    fn at(&self, part: f64) -> Vec3 {
        let sense = if self.clockwise { -1.0 } else { 1.0 };
        let angle = self.start + sense * self.sweep * part;
        let [cx, cy] = self.centre;
        let z = self.from.z + (self.to.z - self.from.z) * part;
        Vec3::new(cx + self.radius * angle.cos(), cy + self.radius * angle.sin(), z)
    }

    /// The greatest X or Y of either sign on the way, mm.
    pub(super) fn farthest(&self) -> f64 {
        let quarter = std::f64::consts::FRAC_PI_2;
        let turned = |k: u32| {
            let ahead = f64::from(k) * quarter - self.start;
            (if self.clockwise { -ahead } else { ahead }).rem_euclid(std::f64::consts::TAU)
        };
        let passed = (0..4).filter(|&k| turned(k) <= self.sweep).map(|k| self.at(turned(k) / self.sweep.max(1e-300)));
        // Where it ends on its circle is not quite where it is told to end.
        let ends = [self.from, self.at(1.0), self.to];
        passed.chain(ends).map(|p| p.x.abs().max(p.y.abs())).fold(0.0, f64::max)
    }
}

/// The polyline of an arc from `from` to `to`, its start left out, its end included.
///
/// Chords deviate from the arc by at most `tolerance` mm. Z goes evenly along the turn. An arc by radius takes the minor
/// arc for R > 0 and the major one for R < 0. Where start and end coincide, an arc by centre is a full turn.
pub fn flatten(from: Vec3, to: Vec3, arc: &Arc, tolerance: f64) -> Vec<Vec3> {
    let turn = ArcTurn::of(from, to, arc);
    let count = turn.chords(tolerance);
    let mut points: Vec<Vec3> = (1..count).map(|i| turn.at(i as f64 / count as f64)).collect();
    points.push(to);
    points
}

fn centre_of(from: Vec3, to: Vec3, radius: f64, clockwise: bool) -> (f64, f64) {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let chord = dx.hypot(dy);
    let height = (radius * radius - chord * chord / 4.0).max(0.0).sqrt();
    // Left of the chord for a minor counter-clockwise arc, right for a clockwise one.
    let side = if clockwise == (radius > 0.0) { -1.0 } else { 1.0 };
    let (mx, my) = (from.x + dx / 2.0, from.y + dy / 2.0);
    if chord == 0.0 {
        return (mx, my);
    }
    (mx - side * dy / chord * height, my + side * dx / chord * height)
}
