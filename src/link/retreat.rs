//! Leaving the part and returning to it: lines of our own.
//!
//! Where the table turns, the tool's axis is machine +Z at any tilt; so leaving is a lift in Z, and the table's axes turn only at the height
//! where they cannot touch anything. Where the head turns, X, Y and Z lift together.
//!
//! Units: mm, degrees in the written words, mm/min.

use super::protocol::Protocol;
use super::state::MachineState;
use crate::gcode::meaning::ManualStepper;
use crate::gcode::push_fixed;
use crate::geom::{Angle, Vec3};
use crate::motion::replay::Position;
use crate::motion::{AxisRange, LinearLimits, SwivelHead};

/// What becomes of the heaters when a print is stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heaters {
    /// Both off.
    Off,
    /// The nozzle off, the bed kept so that the part stays on it.
    KeepBed,
    /// As they are.
    Keep,
}

/// How the table is turned, but for its axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Turning {
    /// Lines before it turns.
    pub before: Vec<String>,
    /// Lines behind it.
    pub after: Vec<String>,
    /// Klipper's names of the motors of tilt and rotation, where commands turn them.
    pub steppers: Option<[String; 2]>,
}

/// How the head leaves and comes back, from the profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Retreat {
    /// The table's axes: tilt, rotation.
    pub axes: [AxisRange; 2],
    /// The highest Z.
    pub z_max_mm: f64,
    /// The head, where it turns, and where its axes may go.
    pub head: Option<(SwivelHead, LinearLimits)>,
    /// How far up.
    pub lift_mm: f64,
    /// Filament pulled.
    pub retract_mm: f64,
    /// Speed of the pull, mm/min.
    pub retract_feed: f64,
    /// In X and Y, mm/min.
    pub travel_feed: f64,
    /// In Z, mm/min.
    pub z_feed: f64,
    /// The extruder's letter.
    pub extruder: u8,
    /// After a fault or a cancel.
    pub heaters: Heaters,
    /// How the table is turned.
    pub turning: Turning,
    /// Lines that home the machine without touching a part on its table; empty where there is no such way.
    pub home: Vec<String>,
}

impl Retreat {
    /// The line that waits until the last move has ended.
    pub fn drain(&self, protocol: Protocol) -> &'static str {
        protocol.traits().drain
    }

    /// Heater lines after a fault; none for a machine that knows no heaters.
    pub fn heaters_on_stop(&self, protocol: Protocol) -> &'static [&'static str] {
        match self.heaters {
            _ if !protocol.traits().is_printer() => &[],
            Heaters::Off => &["M104S0", "M140S0"],
            Heaters::KeepBed => &["M104S0"],
            Heaters::Keep => &[],
        }
    }

    /// Heater lines after a cancel.
    pub fn heaters_on_cancel(&self, protocol: Protocol) -> Vec<String> {
        let fan_off: &[&str] = if protocol.traits().is_printer() { &["M107"] } else { &[] };
        self.heaters_on_stop(protocol).iter().chain(fan_off).map(|l| (*l).to_owned()).collect()
    }

    fn pull(&self, sign: &str, protocol: Protocol) -> Vec<String> {
        if !protocol.traits().is_printer() && self.extruder == b'E' {
            return Vec::new();
        }
        let (letter, feed) = (char::from(self.extruder), number(self.retract_feed));
        vec!["G91".to_owned(), format!("G1{letter}{sign}{}F{feed}", number(self.retract_mm)), "G90".to_owned()]
    }

    /// The words of all axes that are known at `state`, as M114 has them.
    pub fn words(&self, state: &MachineState) -> Vec<(u8, f64)> {
        self.words_at(&state.at)
    }

    /// The same of a place.
    pub(super) fn words_at(&self, at: &Position) -> Vec<(u8, f64)> {
        let linear = [b'X', b'Y', b'Z'].into_iter().zip(at.linear);
        let angles = self.axes.iter().zip([at.tilt, at.rotation]).filter(|(axis, _)| !axis.absent);
        let angles = angles.map(|(axis, angle)| (axis.letter, angle.map(|a| axis.word_of(a).deg())));
        linear.chain(angles).filter_map(|(letter, value)| Some((letter, value?))).collect()
    }

    /// From `state` up along the tool's axis; the table stays.
    pub fn leave(&self, state: &MachineState, protocol: Protocol) -> Vec<String> {
        let mut lines = vec![self.drain(protocol).to_owned()];
        if protocol.traits().is_printer() {
            lines.push("M114".to_owned());
        }
        let Some(lifted) = self.lifted(&state.at) else { return lines };
        lines.push("G94".to_owned());
        if !state.inverse_time {
            lines.pop();
        }
        if state.printed {
            if protocol.traits().is_printer() {
                lines.push("M83".to_owned());
            }
            lines.extend(self.pull("-", protocol));
        }
        if lines.last().is_none_or(|l| l != "G90") {
            lines.push("G90".to_owned());
        }
        lines.push(self.go_along(lifted));
        lines.push(self.drain(protocol).to_owned());
        lines
    }

    /// A move along the tool's axis: of Z alone where the head does not turn.
    fn go_along(&self, to: [Option<f64>; 3]) -> String {
        let named = [b'X', b'Y', b'Z'].into_iter().zip(to).skip(if self.head.is_some() { 0 } else { 2 });
        let words = named.filter_map(|(letter, value)| Some(format!("{}{}", char::from(letter), number(value?))));
        format!("G1{}F{}", words.collect::<String>(), number(self.z_feed))
    }

    /// Where X, Y and Z stand in a pause that began at `at`: farther along the tool's axis, as far as the axes go; `None` where nobody knows
    /// where that leads.
    pub(super) fn lifted(&self, at: &Position) -> Option<[Option<f64>; 3]> {
        let [x, y, z] = at.linear;
        let Some((head, limits)) = &self.head else {
            let z = z?;
            return Some([x, y, Some((z + self.lift_mm).min(self.z_max_mm.max(z)))]);
        };
        let (words, pose) = (at.tip()?, at.pose()?);
        let tip = head.tip(words, pose);
        let axes = |lift: f64| head.axes(tip + Vec3::z() * lift, pose);
        let (from, way) = (axes(0.0), axes(1.0) - axes(0.0));
        let room = |i: usize| match way[i] {
            v if v > 1e-9 => (limits.max[i] - from[i]) / v,
            v if v < -1e-9 => (limits.min[i] - from[i]) / v,
            _ => f64::INFINITY,
        };
        let lift = (0..3).map(room).fold(self.lift_mm, f64::min).max(0.0);
        Some(<[f64; 3]>::from(head.words(tip + Vec3::z() * lift, pose)).map(Some))
    }

    /// Waits for the heat that `state` has.
    pub(super) fn heat(&self, state: &MachineState, protocol: Protocol) -> Vec<String> {
        if !protocol.traits().is_printer() {
            return Vec::new();
        }
        let wait = |word: &str, target: f64| (target > 0.0).then(|| format!("{word}S{}", number(target)));
        [wait("M190", state.bed_c), wait("M109", state.nozzle_c)].into_iter().flatten().collect()
    }

    /// From above back to `state`: heat, the table's axes each alone, X and Y, down, filament, modes.
    pub fn come_back(&self, state: &MachineState, protocol: Protocol) -> Vec<String> {
        let mut lines = self.heat(state, protocol);
        lines.push("G90".to_owned());
        lines.extend(self.turn(state));
        if let ([Some(_), Some(_), Some(_)], true) = (state.at.linear, self.head.is_some()) {
            lines.push(self.go_along(state.at.linear));
        } else if let [Some(x), Some(y), Some(z)] = state.at.linear {
            lines.push(format!("G1X{}Y{}F{}", number(x), number(y), number(self.travel_feed)));
            lines.push(format!("G1Z{}F{}", number(z), number(self.z_feed)));
        }
        if state.printed {
            if protocol.traits().is_printer() {
                lines.push("M83".to_owned());
            }
            lines.extend(self.pull("", protocol));
        }
        lines.extend(self.modes(state, protocol));
        lines
    }

    /// The rotation first, then the tilt, as the file itself turns: so the way there is the one that was planned.
    pub(super) fn turn(&self, state: &MachineState) -> Vec<String> {
        let Turning { before, after, steppers } = &self.turning;
        let line = |which: usize, angle: Option<Angle>| {
            let axis = &self.axes[which];
            let (word, rate) = (axis.word_of(angle?).deg(), axis.max_rate.to_degrees());
            Some(match steppers {
                Some(names) => ManualStepper::go(&names[which], word, rate),
                None => format!("G1{}{}F{}", char::from(axis.letter), number(word), number((rate * 60.0).floor())),
            })
        };
        let turns =
            [(1, state.at.rotation), (0, state.at.tilt)].into_iter().filter(|(which, _)| !self.axes[*which].absent);
        let turns: Vec<String> = turns.filter_map(|(which, angle)| line(which, angle)).collect();
        if turns.is_empty() {
            return turns;
        }
        [before, &turns, after].into_iter().flatten().cloned().collect()
    }

    fn modes(&self, state: &MachineState, protocol: Protocol) -> Vec<String> {
        let mut lines = Vec::new();
        if !state.absolute {
            lines.push("G91".to_owned());
        }
        if protocol.traits().is_printer() {
            lines.push(if state.extruder_absolute { "M82" } else { "M83" }.to_owned());
            lines.push(format!("G92E{}", number(state.extruder_count)));
        } else if self.extruder != b'E' {
            // Behind a reset a spare axis counts from anywhere, and the next absolute word would push all of it.
            lines.push(format!("G92{}{}", char::from(self.extruder), number(state.extruder_count)));
        }
        if state.inverse_time {
            lines.push("G93".to_owned());
        } else if let Some(feed) = state.feed {
            lines.push(format!("G1F{}", number(feed)));
        }
        lines
    }
}

/// At most five decimals, no more than it needs.
pub(super) fn number(value: f64) -> String {
    let mut out = Vec::new();
    push_fixed(&mut out, value.clamp(-1e9, 1e9), 5);
    String::from_utf8(out).unwrap_or_default()
}
