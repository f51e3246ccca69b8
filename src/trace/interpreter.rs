//! One line after the other: what it does to the machine, and how long that takes.
//!
//! Everybody who follows a file goes through here: [`read`](super::read) for verification, `link` for the times that `send`
//! shows and for the state in which a print goes on. So all of them have the same moves, the same seconds and the same heat.
//!
//! Units: mm, seconds, degrees Celsius.

use super::rates::{Feed, RateExtent, TooFast};
use super::{Rates, TraceSetting};
use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Effect, Firmware, Hazard, Heater, TipAcceleration};
use crate::geom::Vec3;
use crate::motion::replay::{CHORD_MM, Controller, Move, ReplayError, Step, flatten};

/// A machine that is told one line after the other.
#[derive(Clone, Debug)]
pub struct Interpreter {
    controller: Controller,
    firmware: Firmware,
    rates: Rates,
    targets: Targets,
    acceleration: TipAcceleration,
}

/// What the heaters were told last, degrees Celsius; 0 is off, and what they are when switched on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Targets {
    /// The nozzle in use.
    pub nozzle_c: f64,
    /// The table.
    pub bed_c: f64,
}

/// What a line does.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "nearly every line is a move, and none is kept")]
pub enum Action {
    /// Nothing that takes time: blank, comment, mode, the extruder's count.
    Nothing,
    /// A move.
    Move(TimedMove),
    /// Anything else.
    Effect(Effect),
}

/// A move and what it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedMove {
    /// The move.
    pub made: Move,
    /// At constant speed: accelerations are the [`Clock`](super::MotionClock)'s.
    pub seconds: f64,
    /// What X and Y are accelerated by, mm/s², where the program has said so (M204).
    pub acceleration: Option<f64>,
    /// How far the tip goes, as far as is known.
    pub length_mm: f64,
    /// Where an arc's chords end, its start left out; empty for a straight line, and where the arc's ends are not all known.
    pub chords: Vec<Vec3>,
    /// Set where an axis is asked for more than it can.
    pub too_fast: Option<TooFast>,
}

impl Interpreter {
    /// A machine just switched on: position unknown, heaters off.
    pub fn new(setting: &TraceSetting) -> Self {
        let controller = Controller::new(setting.reading.clone());
        let (firmware, rates) = (setting.reading.firmware, setting.rates.clone());
        Self { controller, firmware, rates, targets: Targets::default(), acceleration: TipAcceleration::default() }
    }

    /// Takes one line.
    ///
    /// # Errors
    ///
    /// [`ReplayError`] for what has no safe meaning; the position is then unspecified.
    pub fn take(&mut self, line: &ParsedLine) -> Result<Action, ReplayError> {
        Ok(match self.controller.step(line)? {
            Step::Nothing | Step::ExtruderSet(_) => Action::Nothing,
            Step::Move(made) => {
                let acceleration = self.acceleration.of(made.e);
                Action::Move(TimedMove { acceleration, ..self.rates.timed(made) })
            }
            Step::Effect(effect) => {
                self.targets.take(effect);
                self.acceleration.take(self.firmware, line);
                Action::Effect(effect)
            }
        })
    }

    /// Position and modes.
    pub fn controller(&self) -> &Controller {
        &self.controller
    }

    /// Heat.
    pub fn targets(&self) -> Targets {
        self.targets
    }
}

impl Action {
    /// How long the line holds up the program, as far as the file says: moves and G4.
    pub fn seconds(&self) -> f64 {
        match self {
            Self::Move(timed) => timed.seconds,
            Self::Effect(Effect::Dwell(seconds)) => seconds.max(0.0),
            Self::Nothing | Self::Effect(_) => 0.0,
        }
    }
}

impl Targets {
    fn take(&mut self, effect: Effect) {
        match effect {
            Effect::Heat { heater: Heater::Nozzle, target_c, .. } => self.nozzle_c = target_c.unwrap_or(self.nozzle_c),
            Effect::Heat { heater: Heater::Bed, target_c, .. } => self.bed_c = target_c.unwrap_or(self.bed_c),
            Effect::HeatersOff | Effect::Hazard(Hazard::Stop | Hazard::End) => *self = Self::default(),
            _ => {}
        }
    }
}

impl Rates {
    /// A move with its time.
    pub fn timed(&self, made: Move) -> TimedMove {
        let (length_mm, chords) = extent(&made);
        let turns = [(made.from.tilt, made.to.tilt), (made.from.rotation, made.to.rotation)]
            .map(|(from, to)| if from == to { Some(0.0) } else { Some((to? - from?).abs().deg()) });
        let linear = length_mm > 0.0 || made.from.linear != made.to.linear;
        let extent = RateExtent { length: length_mm, linear, turns, e: made.e };
        let feed =
            Feed { value: made.feed, inverse_time: made.inverse_time, rapid: made.rapid, rotary: made.rotary_written };
        let (seconds, too_fast) = self.check(&feed, &extent);
        TimedMove { made, seconds, acceleration: None, length_mm, chords, too_fast }
    }
}

/// How far the tip goes, and an arc's chords. What is not known takes no time; it moves all the same.
fn extent(m: &Move) -> (f64, Vec<Vec3>) {
    if let (Some(arc), Some(from), Some(to)) = (&m.arc, m.from.tip(), m.to.tip()) {
        let chords = flatten(from, to, arc, CHORD_MM);
        let starts = std::iter::once(&from).chain(&chords);
        let length = starts.zip(&chords).map(|(from, to)| (to - from).norm()).sum();
        return (length, chords);
    }
    let along = |i: usize| m.from.linear[i].zip(m.to.linear[i]).map_or(0.0, |(from, to)| to - from);
    (Vec3::from_fn(|i, _| along(i)).norm(), Vec::new())
}
