//! The machine behind the firmware: modal state, planner, limits, homing, heat. It knows no wire.

use std::time::Duration;

use super::Time;
use super::heat::HeatedMass;
use crate::gcode::ParsedLine;
use crate::gcode::meaning::{self, Correction, Effect, Firmware, Hazard, TipAcceleration, correction};
use crate::geom::Angle;
use crate::motion::lookahead::LookAhead;
use crate::motion::replay::{Controller, Move, Position, Reading, Step};
use crate::motion::{Accelerations, Axes, AxisRange, LinearLimits, Pose, SwivelHead, SwivelWords};
use crate::trace::Rates;

/// The machine that is simulated.
#[derive(Clone, Debug)]
pub struct MachineModel {
    /// How lines are read.
    pub reading: Reading,
    /// The table's axes: tilt, rotation.
    pub axes: [AxisRange; 2],
    /// Where the linear axes may go.
    pub limits: LinearLimits,
    /// The head, where it turns.
    pub head: Option<SwivelHead>,
    /// Where homing leaves X, Y and Z, mm.
    pub home_mm: [f64; 3],
    /// The axes' fastest.
    pub rates: Rates,
    /// How fast its speeds change.
    pub accelerations: Accelerations,
    /// Below this the extruder does not move, degrees Celsius; 0 for a machine without heaters.
    pub coldest_extrusion_c: f64,
    /// Heating and cooling this many times as fast as real ones.
    pub heat_factor: f64,
    /// How long a person takes at M0 and M600.
    pub person: Time,
}

/// What a line did.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Took {
    /// Executed, or in the planner.
    Done,
    /// Once more when the planner has room or has run dry.
    Again,
    /// Done at this time.
    At(Time),
    /// Until the heater is there.
    Heat { bed: bool },
    /// Until somebody has come.
    Person(Time),
    /// Not executed.
    Refused(Refusal),
    /// Executed in part: the extruder did not move.
    Cold,
}

/// Why a line was not executed.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Refusal {
    Unknown,
    Beyond(Axes),
    NotHomed,
    NoFeed,
}

/// Axes, heaters and modes.
#[derive(Clone, Debug)]
pub(super) struct SimMachine {
    pub(super) model: MachineModel,
    pub(super) planner: LookAhead,
    controller: Controller,
    pub(super) nozzle: HeatedMass,
    pub(super) bed: HeatedMass,
    pub(super) homed: bool,
    extruded: f64,
    line: ParsedLine,
    acceleration: TipAcceleration,
    until: Option<Time>,
    /// Whether a target beyond the limits is cut to them, as Marlin does, or refused.
    pub(super) clamps: bool,
    pub(super) clamped: u32,
    firmware: Firmware,
    /// Whether it follows the tip (G43.4).
    follows: bool,
}

/// A homing move is this slow at least.
const HOMING: Time = Duration::from_secs(8);

impl SimMachine {
    pub(super) fn new(model: MachineModel, clamps: bool, firmware: Firmware) -> Self {
        let at = [0.0; 6];
        let mut controller = Controller::new(Reading { firmware, ..model.reading.clone() });
        controller.at = Position { linear: [Some(0.0); 3], tilt: Some(Angle::ZERO), rotation: Some(Angle::ZERO) };
        Self {
            planner: LookAhead::new(model.accelerations, at),
            controller,
            nozzle: HeatedMass::new(3.0 * model.heat_factor),
            bed: HeatedMass::new(0.5 * model.heat_factor),
            homed: false,
            extruded: 0.0,
            line: ParsedLine::default(),
            acceleration: TipAcceleration::default(),
            until: None,
            model,
            clamps,
            clamped: 0,
            firmware,
            follows: false,
        }
    }

    /// The words of the axes: machine X, Y, Z, the table's words, E.
    fn words(&self, at: &Position) -> Axes {
        let [x, y, z] = at.linear.map(|v| v.unwrap_or(0.0));
        let word = |axis: &AxisRange, angle: Option<Angle>| angle.map_or(0.0, |a| axis.word_of(a).deg());
        [x, y, z, word(&self.model.axes[0], at.tilt), word(&self.model.axes[1], at.rotation), self.extruded]
    }

    /// Executes one block, or says what it waits for; called again until it is done.
    pub(super) fn execute(&mut self, now: Time, block: &[u8]) -> Took {
        if let Some(until) = self.until {
            if until > now {
                return Took::At(until);
            }
            self.until = None;
            return Took::Done;
        }
        let mut line = std::mem::take(&mut self.line);
        let took = match line.read(block) {
            Ok(()) => self.run(now, &line),
            Err(_) => Took::Refused(Refusal::Unknown),
        };
        self.line = line;
        took
    }

    fn run(&mut self, now: Time, line: &ParsedLine) -> Took {
        if self.planner.is_full() {
            return Took::Again;
        }
        let before = self.controller.clone();
        match self.controller.step(line) {
            Ok(Step::Move(m)) => self.make_move(now, &m, before),
            Ok(Step::Effect(effect)) => {
                self.acceleration.take(self.firmware, line);
                if let Some((Correction::TipFollowing, on)) = correction(self.firmware, line) {
                    self.follows = on;
                }
                self.other(now, effect, line, before)
            }
            Ok(_) => Took::Done,
            Err(_) => {
                self.controller = before;
                Took::Refused(Refusal::Unknown)
            }
        }
    }

    /// Does `act` once the planner is empty; until then the modal state is as `before`.
    fn drained(&mut self, before: Controller, act: impl FnOnce(&mut Self) -> Took) -> Took {
        if self.planner.is_idle() {
            self.planner.expect_pause();
            return act(self);
        }
        self.controller = before;
        Took::Again
    }

    fn wait(&mut self, until: Time) -> Took {
        self.until = Some(until);
        Took::At(until)
    }

    fn make_move(&mut self, now: Time, m: &Move, before: Controller) -> Took {
        if !m.rapid && m.feed.is_none() {
            self.controller = before;
            return Took::Refused(Refusal::NoFeed);
        }
        if !self.homed && (m.written != 0 || m.rotary_written) && self.needs_home() {
            self.controller = before;
            return Took::Refused(Refusal::NotHomed);
        }
        let to = self.words(&m.to);
        let beyond = self.beyond(&to);
        if beyond && !self.clamps {
            self.controller = before;
            return Took::Refused(Refusal::Beyond(to));
        }
        if beyond {
            self.clamped += 1;
            self.cut(m);
        }
        let cold = m.e > 0.0 && self.nozzle.at(now) < self.model.coldest_extrusion_c;
        if !cold {
            self.extruded += m.e;
        }
        let end = self.words(&self.controller.at.clone());
        self.planner.push(now, end, self.model.rates.timed(*m).seconds, self.acceleration.of(m.e));
        if cold { Took::Cold } else { Took::Done }
    }

    /// Marlin moves before homing; the others do not.
    fn needs_home(&self) -> bool {
        !self.clamps
    }

    fn beyond(&self, to: &Axes) -> bool {
        if !self.homed {
            return false;
        }
        let axes = self.axes(crate::geom::Vec3::new(to[0], to[1], to[2]), to);
        let outside = |i: usize| {
            let axis = &self.model.axes[i];
            !axis.admits(axis.angle_of(Angle::from_deg(to[3 + i])))
        };
        self.model.limits.violation(&axes).is_some() || outside(0) || outside(1)
    }

    /// Where the linear axes go for these words: with a head whose tip the firmware follows, elsewhere.
    fn axes(&self, words: crate::geom::Vec3, to: &Axes) -> crate::geom::Vec3 {
        match &self.model.head {
            Some(head) if head.words == SwivelWords::Tip && self.follows => {
                let angle = |i: usize| self.model.axes[i].angle_of(Angle::from_deg(to[3 + i]));
                let pose = Pose { tilt: angle(0), rotation: angle(1) };
                head.axes(head.tip(words, pose), pose)
            }
            _ => words,
        }
    }

    fn cut(&mut self, m: &Move) {
        let mut at = m.to;
        for i in 0..3 {
            at.linear[i] = at.linear[i].map(|v| v.clamp(self.model.limits.min[i], self.model.limits.max[i]));
        }
        let cut = |axis: &AxisRange, angle: Option<Angle>| {
            angle.map(|a| match axis.range {
                Some((low, high)) => axis.angle_of(Angle::from_deg(axis.word_of(a).deg().clamp(low.deg(), high.deg()))),
                None => a,
            })
        };
        at.tilt = cut(&self.model.axes[0], at.tilt);
        at.rotation = cut(&self.model.axes[1], at.rotation);
        self.controller.at = at;
    }

    fn go_home(&mut self, now: Time, line: &ParsedLine) -> Took {
        let tilt = self.model.axes[0].letter;
        let rotation = self.model.axes[1].letter;
        let all = ![b'X', b'Y', b'Z', tilt, rotation].iter().any(|l| line.has(*l));
        let had = self.words_before();
        for (i, letter) in [b'X', b'Y', b'Z'].into_iter().enumerate() {
            let to = if all || line.has(letter) { self.model.home_mm[i] } else { had[i] };
            self.controller.at.linear[i] = Some(to);
        }
        if all || line.has(tilt) {
            self.controller.at.tilt = Some(Angle::ZERO);
        }
        if all || line.has(rotation) {
            self.controller.at.rotation = Some(Angle::ZERO);
        }
        self.homed = true;
        let at = self.words(&self.controller.at.clone());
        self.planner.place(at);
        self.wait(now + HOMING)
    }

    fn words_before(&self) -> Axes {
        self.planner.end()
    }

    /// What `gcode::meaning` says that is no move.
    fn other(&mut self, now: Time, effect: Effect, line: &ParsedLine, before: Controller) -> Took {
        match effect {
            Effect::Home | Effect::Hazard(Hazard::Moves) => self.drained(before, |machine| machine.go_home(now, line)),
            Effect::Dwell(s) => {
                self.drained(before, |machine| machine.wait(now + Duration::from_secs_f64(s.clamp(0.0, 1e5))))
            }
            Effect::Drain => self.drained(before, |_| Took::Done),
            Effect::Heat { heater: heater @ (meaning::Heater::Nozzle | meaning::Heater::Bed), target_c, waits } => {
                let bed = heater == meaning::Heater::Bed;
                let own = if bed { &mut self.bed } else { &mut self.nozzle };
                own.set(now, target_c.unwrap_or(0.0));
                if waits { self.heat(now, bed) } else { Took::Done }
            }
            Effect::HeatersOff => {
                self.nozzle.set(now, 0.0);
                self.bed.set(now, 0.0);
                Took::Done
            }
            Effect::Hazard(Hazard::Person) => {
                let until = now + self.model.person;
                self.drained(before, |machine| {
                    machine.until = Some(until);
                    Took::Person(until)
                })
            }
            Effect::Hazard(Hazard::Unknown | Hazard::Tool) => {
                self.controller = before;
                Took::Refused(Refusal::Unknown)
            }
            Effect::Hazard(_) => {
                // The simulated machine has no offsets or steps to change; its place stays what it was.
                self.controller = before;
                Took::Done
            }
            _ => Took::Done,
        }
    }

    fn heat(&mut self, now: Time, bed: bool) -> Took {
        let heater = if bed { &self.bed } else { &self.nozzle };
        self.planner.expect_pause();
        let there = heater.reached(now);
        if there <= now {
            return Took::Done;
        }
        self.until = Some(there);
        Took::Heat { bed }
    }

    /// Ends a wait for heat or a person.
    pub(super) fn end_wait(&mut self, now: Time) {
        if self.until.is_some() {
            self.until = Some(now);
        }
    }

    /// Everything stops, the heaters too.
    pub(super) fn kill(&mut self, now: Time) {
        self.planner.abort(now);
        self.nozzle.set(now, 0.0);
        self.bed.set(now, 0.0);
        self.until = None;
    }

    /// The firmware begins anew: modes and homing are forgotten, heat and place stay.
    pub(super) fn restart(&mut self, now: Time) {
        self.kill(now);
        let at = self.planner.position(now);
        let mut fresh = Self::new(self.model.clone(), self.clamps, self.firmware);
        fresh.planner.place([0.0; 6]);
        fresh.planner.starved = self.planner.starved;
        fresh.nozzle = self.nozzle.clone();
        fresh.bed = self.bed.clone();
        // The axes stand where they stood, but the firmware believes they are at zero.
        let _ = at;
        *self = fresh;
    }
}

impl SimMachine {
    /// When the command in hand ends by itself.
    pub(super) fn waits_until(&self) -> Option<Time> {
        self.until
    }
}

impl SimMachine {
    pub(super) fn set_heat_factor(&mut self, factor: f64) {
        self.nozzle = HeatedMass::new(3.0 * factor);
        self.bed = HeatedMass::new(0.5 * factor);
    }
}
