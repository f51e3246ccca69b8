//! How long a program takes: the one clock of everybody who states a print's time.

use std::time::Duration;

use super::{Action, TimedMove};
use crate::gcode::meaning::Effect;
use crate::motion::lookahead::LookAhead;
use crate::motion::replay::Position;
use crate::motion::{Accelerations, Axes};

/// Time of all moves and waits (G4) of a program whose lines never come late: speeds change as fast as [`Accelerations`] let them, corners
/// are gone round, and a firmware's queue of moves is looked ahead. No heating, no homing, no person.
///
/// Axes that are not known do not move; an arc goes along its chords.
#[derive(Clone, Debug)]
pub struct MotionClock {
    ahead: LookAhead,
    now: Duration,
}

impl MotionClock {
    /// At the beginning of a program.
    pub fn new(accelerations: &Accelerations) -> Self {
        let mut ahead = LookAhead::new(*accelerations, [0.0; 6]);
        ahead.hold(Duration::ZERO);
        Self { ahead, now: Duration::ZERO }
    }

    /// Lets one line of the program pass.
    pub fn take(&mut self, action: &Action) {
        each_stretch(action, |stretch| self.pass(&stretch));
    }

    /// Lets one stretch of the program pass.
    pub(super) fn pass(&mut self, stretch: &Stretch) {
        match *stretch {
            Stretch::Go { by, seconds, acceleration } => self.push(by, seconds, acceleration),
            Stretch::Wait(seconds) => {
                self.stop();
                self.now += Duration::try_from_secs_f64(seconds).unwrap_or_default();
            }
            Stretch::Stop => self.stop(),
        }
    }

    /// The time of all that passed, to the last move's end.
    pub fn seconds(mut self) -> f64 {
        self.stop();
        self.now.as_secs_f64()
    }

    fn push(&mut self, by: Axes, seconds: f64, acceleration: Option<f64>) {
        while self.ahead.is_full() {
            self.ahead.release(self.now);
            self.now = self.ahead.wake().unwrap_or(self.now);
            self.ahead.advance(self.now, |_, _| {});
        }
        let from = self.ahead.end();
        self.ahead.push(self.now, std::array::from_fn(|i| from[i] + by[i]), seconds, acceleration);
    }

    /// Until all that is queued is done; what comes next is looked ahead again before it begins.
    fn stop(&mut self) {
        self.ahead.release(self.now);
        while let Some(end) = self.ahead.wake() {
            self.now = end;
            self.ahead.advance(end, |_, _| {});
        }
        self.ahead.hold(self.now);
    }
}

/// What of a program takes time, without what else is known of it: a [`MotionClock`] may run behind whoever reads.
pub(super) enum Stretch {
    /// A straight line of all axes, mm and degrees.
    Go { by: Axes, seconds: f64, acceleration: Option<f64> },
    /// All moves end, then so many seconds.
    Wait(f64),
    /// All moves end.
    Stop,
}

/// Visits the stretches of one line in order: none for what takes no time, one for each chord of an arc.
pub(super) fn each_stretch(action: &Action, mut visit: impl FnMut(Stretch)) {
    match action {
        Action::Move(timed) => each_straight(timed, |by, seconds| {
            visit(Stretch::Go { by, seconds, acceleration: timed.acceleration });
        }),
        Action::Effect(Effect::Dwell(seconds)) => visit(Stretch::Wait(*seconds)),
        Action::Effect(Effect::Drain | Effect::Home | Effect::HeatWait | Effect::Heat { waits: true, .. }) => {
            visit(Stretch::Stop);
        }
        Action::Nothing | Action::Effect(_) => {}
    }
}

/// Visits the straight lines of a move, with the time of each, s.
fn each_straight(timed: &TimedMove, mut visit: impl FnMut(Axes, f64)) {
    let m = &timed.made;
    let by = difference(&m.from, &m.to, m.e);
    if timed.chords.len() < 2 || timed.length_mm <= 0.0 {
        return visit(by, timed.seconds);
    }
    let mut at = m.from.tip().unwrap_or(timed.chords[0]);
    for chord in &timed.chords {
        let (step, share) = (chord - at, (chord - at).norm() / timed.length_mm);
        visit([step.x, step.y, step.z, by[3] * share, by[4] * share, by[5] * share], timed.seconds * share);
        at = *chord;
    }
}

/// What each axis does, mm and degrees; nothing where it is not known.
fn difference(from: &Position, to: &Position, e: f64) -> Axes {
    let linear = |i: usize| from.linear[i].zip(to.linear[i]).map_or(0.0, |(from, to)| to - from);
    let turned = [(from.tilt, to.tilt), (from.rotation, to.rotation)]
        .map(|(from, to)| from.zip(to).map_or(0.0, |(from, to)| (to - from).deg()));
    [linear(0), linear(1), linear(2), turned[0], turned[1], e]
}
