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
        match action {
            Action::Move(timed) => self.go(timed),
            Action::Effect(Effect::Dwell(seconds)) => {
                self.stop();
                self.now += Duration::try_from_secs_f64(*seconds).unwrap_or_default();
            }
            Action::Effect(Effect::Drain | Effect::Home | Effect::HeatWait | Effect::Heat { waits: true, .. }) => {
                self.stop()
            }
            Action::Nothing | Action::Effect(_) => {}
        }
    }

    /// The time of all that passed, to the last move's end.
    pub fn seconds(mut self) -> f64 {
        self.stop();
        self.now.as_secs_f64()
    }

    fn go(&mut self, timed: &TimedMove) {
        let m = &timed.made;
        let by = difference(&m.from, &m.to, m.e);
        if timed.chords.len() < 2 || timed.length_mm <= 0.0 {
            return self.push(by, timed.seconds, timed.acceleration);
        }
        let mut at = m.from.tip().unwrap_or(timed.chords[0]);
        for chord in &timed.chords {
            let (step, share) = (chord - at, (chord - at).norm() / timed.length_mm);
            let by = [step.x, step.y, step.z, by[3] * share, by[4] * share, by[5] * share];
            self.push(by, timed.seconds * share, timed.acceleration);
            at = *chord;
        }
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

/// What each axis does, mm and degrees; nothing where it is not known.
fn difference(from: &Position, to: &Position, e: f64) -> Axes {
    let linear = |i: usize| from.linear[i].zip(to.linear[i]).map_or(0.0, |(from, to)| to - from);
    let turned = [(from.tilt, to.tilt), (from.rotation, to.rotation)]
        .map(|(from, to)| from.zip(to).map_or(0.0, |(from, to)| (to - from).deg()));
    [linear(0), linear(1), linear(2), turned[0], turned[1], e]
}
