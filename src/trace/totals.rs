//! What a program takes as a whole, without keeping its moves.

use super::{Interpreter, MotionClock, TraceSetting};
use crate::gcode::marks::{Hint, Totals, hint};
use crate::gcode::{LineKind, ParsedLine, lines};

/// Time and layers of the program in `bytes`, by the same clock as [`read`](super::read()); what has no safe meaning takes no time.
pub fn totals(bytes: &[u8], setting: &TraceSetting) -> Totals {
    let (mut interpreter, mut parsed) = (Interpreter::new(setting), ParsedLine::default());
    let (mut totals, mut clock) = (Totals::default(), MotionClock::new(&setting.accelerations));
    for line in lines(bytes) {
        if parsed.read(line.bytes).is_err() {
            continue;
        }
        if parsed.kind == LineKind::Empty {
            totals.layers += usize::from(hint(&line.bytes[parsed.comment.clone()]) == Some(Hint::Layer));
            continue;
        }
        if let Ok(action) = interpreter.take(&parsed) {
            clock.take(&action);
        }
    }
    totals.seconds = clock.seconds();
    totals
}
