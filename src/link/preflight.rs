//! What a machine cannot do is found before the first byte: targets beyond its axes, and more heat than it has.
//!
//! Firmwares differ in what they do with such lines: Marlin cuts the target to the limit without a word and prints a spoilt part,
//! others refuse it in the middle of the print. Ends of moves are checked, not what an arc does between them; a place that is
//! not known (after homing) is not checked. Grbl's family has no heaters here.
//!
//! Units: mm, degrees, degrees Celsius; lines of the file from 1.

use super::program::Program;
use crate::gcode::meaning::{Effect, Heater, effect};
use crate::geom::Angle;
use crate::motion::replay::Move;
use crate::motion::{AxisRange, LinearLimits};
use crate::trace::Action;

/// What the machine can do.
#[derive(Clone, Debug)]
pub struct Abilities {
    /// Where the tip may go.
    pub limits: LinearLimits,
    /// The table's axes: tilt, rotation.
    pub axes: [AxisRange; 2],
    /// The hottest nozzle.
    pub max_nozzle_c: f64,
    /// The hottest bed.
    pub max_bed_c: f64,
}

/// What it cannot.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "printer/")]
pub enum Unfit {
    /// A target outside.
    #[error("line {line}: {axis} {target} is outside the machine's range, {low} to {high} {}", if "XYZ".contains(*axis) { "mm" } else { "deg" })]
    Beyond {
        /// Of the file.
        line: u32,
        /// The axis' letter.
        axis: char,
        /// mm or degrees.
        target: f64,
        /// The lowest.
        low: f64,
        /// The highest.
        high: f64,
    },
    /// Too hot.
    #[error("line {line}: {target} C for the {heater}, but the profile allows at most {allowed} C ([link] {key})")]
    TooHot {
        /// Of the file.
        line: u32,
        /// Which.
        heater: &'static str,
        /// Asked for.
        target: f64,
        /// The most.
        allowed: f64,
        /// Where the profile says so.
        key: &'static str,
    },
}

impl Abilities {
    /// The first line of `program` that asks for more than the machine can do; `None` where there is none.
    ///
    /// Behind a line that the replay cannot follow ([`Program::unknown`]) only heat is checked.
    pub fn lacking(&self, program: &Program) -> Option<Unfit> {
        let mut replay = program.replay();
        let mut followed = true;
        while let Some((block, words, action)) = replay.step() {
            let line = program.file_line(block);
            let found = match action {
                Ok(Action::Effect(effect)) => self.too_hot(effect, line),
                Ok(Action::Move(timed)) if followed => self.beyond(&timed.made, line),
                Ok(_) => None,
                Err(_) => {
                    followed = false;
                    self.too_hot(effect(program.firmware(), words), line)
                }
            };
            if found.is_some() {
                return found;
            }
        }
        None
    }

    fn too_hot(&self, effect: Effect, line: u32) -> Option<Unfit> {
        let Effect::Heat { heater, target_c: Some(target), .. } = effect else { return None };
        let (heater, key, allowed) = match heater {
            Heater::Nozzle | Heater::OtherNozzle(_) => ("nozzle", "max_nozzle_c", self.max_nozzle_c),
            Heater::Bed => ("bed", "max_bed_c", self.max_bed_c),
            Heater::Chamber => return None,
        };
        (target > allowed).then_some(Unfit::TooHot { line, heater, target, allowed, key })
    }

    fn beyond(&self, m: &Move, line: u32) -> Option<Unfit> {
        for (i, axis) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            let (low, high) = (self.limits.min[i], self.limits.max[i]);
            let outside = |v: &f64| !(low - ROUNDING..=high + ROUNDING).contains(v);
            let target = m.to.linear[i].filter(|_| m.to.linear[i] != m.from.linear[i]).filter(outside);
            if let Some(target) = target {
                return Some(Unfit::Beyond { line, axis, target, low, high });
            }
        }
        let turned = [(m.to.tilt, m.from.tilt), (m.to.rotation, m.from.rotation)];
        for (axis, (to, from)) in self.axes.iter().zip(turned) {
            let Some(target) = to.filter(|t| to != from && !axis.admits(*t)) else { continue };
            let (low, high) = axis.range.map_or((0.0, 0.0), |(low, high)| (tidy(low), tidy(high)));
            let target = tidy(axis.word_of(target));
            return Some(Unfit::Beyond { line, axis: char::from(axis.letter), target, low, high });
        }
        None
    }
}

/// Degrees as they were written.
fn tidy(angle: Angle) -> f64 {
    (angle.deg() * 1e6).round() / 1e6
}

/// Files carry three to five decimals.
const ROUNDING: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec3;
    use crate::link::Protocol;
    use crate::link::testing::{axes, rules};

    fn lacking(text: &str) -> Option<Unfit> {
        let limits = LinearLimits { min: Vec3::new(-100.0, -100.0, 0.0), max: Vec3::new(100.0, 100.0, 200.0) };
        let abilities = Abilities { limits, axes: axes(), max_nozzle_c: 260.0, max_bed_c: 140.0 };
        let program = Program::read(text.as_bytes(), &rules(Protocol::Marlin)).unwrap();
        abilities.lacking(&program)
    }

    #[test]
    fn what_lies_beyond_an_axis_is_named_with_its_line() {
        let beyond = |line, axis, target, low, high| Some(Unfit::Beyond { line, axis, target, low, high });
        assert_eq!(lacking("G28\nG1 X100 F600\nG1 X100.5\n"), beyond(3, 'X', 100.5, -100.0, 100.0));
        assert_eq!(lacking("G28\nG91\nG1 Z5 F600\nG90\nG1 Z-.1\n"), beyond(5, 'Z', -0.1, 0.0, 200.0));
        assert_eq!(lacking("G28\nG1 A-20 F600\n"), beyond(2, 'A', -20.0, -15.0, 90.0));
        assert_eq!(lacking("G28\nG1 X-100 Y100 Z200 A90 C7200 F600\n"), None);
    }

    #[test]
    fn more_heat_than_the_machine_has_is_named_with_its_key() {
        let hot = |line, heater, target, allowed, key| Some(Unfit::TooHot { line, heater, target, allowed, key });
        assert_eq!(lacking("M104 S260\nM109 R261\n"), hot(2, "nozzle", 261.0, 260.0, "max_nozzle_c"));
        for bed in ["M140 S141", "M190 S141"] {
            assert_eq!(lacking(bed), hot(1, "bed", 141.0, 140.0, "max_bed_c"));
        }
        assert_eq!(lacking("M104 S260\nM140 S140\nM106 S255\n"), None);
        // Behind a line that the replay cannot follow, too.
        assert_eq!(lacking("G92 X5\nG1 X9999 F60\nM109 S400\n"), hot(3, "nozzle", 400.0, 260.0, "max_nozzle_c"));
    }
}
