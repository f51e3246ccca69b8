//! Klipper before GCODE_AXIS: the table's motors turned by `MANUAL_STEPPER` commands. Degrees, degrees/s.

use super::{Controller, Move, ReplayError, Step, is_sane_feed, sane};
use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Effect, Hazard, ManualStepper, StepperAct};
use crate::geom::Angle;

impl Controller {
    /// A `MANUAL_STEPPER` line: a turn, where it names a motor of the table. Its place may be set to where it is, or as long as nobody knows
    /// where that is; what else is done to such a motor leaves the angle unknown. Other motors are none of the machine's axes.
    pub(super) fn stepper(&mut self, line: &ParsedLine) -> Result<Step, ReplayError> {
        let effect = Step::Effect(Effect::Hazard(Hazard::Stepper));
        let (Some(names), Some((tilt, rotation))) = (&self.reading.steppers, &self.reading.rotary) else {
            return Ok(effect);
        };
        let Some(ManualStepper { stepper, act }) = ManualStepper::read(&line.text) else {
            (self.at.tilt, self.at.rotation) = (None, None);
            return Ok(effect);
        };
        let Some(which) = names.iter().position(|name| *name == stepper) else { return Ok(effect) };
        let from = self.at;
        let (axis, slot) = if which == 0 { (tilt, &mut self.at.tilt) } else { (rotation, &mut self.at.rotation) };
        let angle = |word: f64| Ok(Some(axis.angle_of(Angle::from_deg(sane(axis.letter, word)?))));
        match act {
            StepperAct::Other => *slot = None,
            StepperAct::Set(place) => {
                let place = angle(place)?;
                let shifts = slot.zip(place).is_some_and(|(at, place)| (at - place).abs().deg() > 1e-9);
                if shifts {
                    return Err(ReplayError::ShiftedAxes);
                }
                *slot = place;
            }
            StepperAct::Move { to, speed } => {
                *slot = angle(to)?;
                let feed = Some(speed * 60.0).filter(|feed| is_sane_feed(*feed));
                let feed = Some(feed.ok_or(ReplayError::Absurd('F', speed))?);
                let (to, arc) = (self.at, None);
                let (rapid, inverse_time, rotary_written) = (false, false, true);
                return Ok(Step::Move(Move {
                    rapid,
                    from,
                    to,
                    e: 0.0,
                    feed,
                    inverse_time,
                    arc,
                    written: 0,
                    rotary_written,
                }));
            }
        }
        Ok(effect)
    }
}
