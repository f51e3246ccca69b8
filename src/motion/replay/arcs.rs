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
    // Marlin makes so many circles first, others pass it over.
    if line.has(b'P') && firmware != Firmware::LinuxCnc {
        return Err(ReplayError::StrayWord('P'));
    }
    let turns = line.value(b'P').unwrap_or(1.0);
    if turns.fract() != 0.0 || !(0.0..=f64::from(MOST_TURNS)).contains(&turns) {
        return Err(ReplayError::ArcTurns(turns));
    }
    let turns = (turns as u32).max(1);
    Ok(Arc { to_centre, clockwise, by_radius, turns })
}

/// The polyline of an arc from `from` to `to`, its start left out, its end included.
///
/// Chords deviate from the arc by at most `tolerance` mm. Z goes evenly along the turn. An arc by radius takes the minor
/// arc for R > 0 and the major one for R < 0. Where start and end coincide, an arc by centre is a full turn.
pub fn flatten(from: Vec3, to: Vec3, arc: &Arc, tolerance: f64) -> Vec<Vec3> {
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
    let step = 2.0 * (1.0 - (tolerance / radius.max(tolerance)).min(1.0)).acos();
    let count = (sweep / step.max(1e-3)).ceil().max(1.0) as usize;
    let sense = if arc.clockwise { -1.0 } else { 1.0 };
    let mut points: Vec<Vec3> = (1..count)
        .map(|i| {
            let part = i as f64 / count as f64;
            let angle = start + sense * sweep * part;
            Vec3::new(cx + radius * angle.cos(), cy + radius * angle.sin(), from.z + (to.z - from.z) * part)
        })
        .collect();
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
