//! The lines of `[transition] before_turn` and `after_turn`: right before each turn of the table and right behind it, and nowhere else.
//! A brake would hold the table while it turns, or let it go while it is printed on.

use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Effect, Firmware, effect};
use crate::profile::Profile;

/// Goes through a program's moves and the lines between them.
pub(super) struct TurnLines<'a> {
    firmware: Firmware,
    before: Vec<&'a str>,
    after: Vec<&'a str>,
    /// Whether the last move turned the table.
    turned: bool,
    /// The lines since, with their numbers, but for those that only set how moves are read.
    since: Vec<(u32, &'a str)>,
}

impl<'a> TurnLines<'a> {
    pub(super) fn of(profile: &'a Profile) -> Self {
        let [before, after] = profile.transition.around_turn();
        Self { firmware: profile.firmware(), before, after, turned: false, since: Vec::new() }
    }

    /// Whether `line` is one of them: then it may stand among the prints, and where is said by [`Self::moved`].
    pub(super) fn has(&self, line: &str) -> bool {
        self.before.iter().chain(&self.after).any(|own| *own == line)
    }

    /// Takes a line that is no move.
    pub(super) fn note(&mut self, line: u32, text: &'a [u8], effect: Effect) {
        if self.before.is_empty() && self.after.is_empty() || matches!(effect, Effect::Nothing | Effect::Motion) {
            return;
        }
        if let Ok(text) = std::str::from_utf8(text) {
            self.since.push((line, text.trim()));
        }
    }

    /// The next move turns the table or does not, or the program is over; what is wrong with the lines before it, and where if that is not
    /// at the move.
    pub(super) fn moved(&mut self, turns: bool) -> Option<(Option<u32>, String)> {
        let turned = std::mem::replace(&mut self.turned, turns);
        if self.since.is_empty() && turned == turns {
            return None;
        }
        let since = std::mem::take(&mut self.since);
        let mut rest = &since[..];
        if turned && !turns {
            let (lines, others) = rest.split_at(self.after.len().min(rest.len()));
            rest = others;
            if !are(&self.after, lines) {
                return Some((None, missing("after_turn", "after the turn before this", &self.after)));
            }
        }
        if turns && !turned {
            let (others, lines) = rest.split_at(rest.len().saturating_sub(self.before.len()));
            rest = others;
            if !are(&self.before, lines) {
                return Some((None, missing("before_turn", "before this turn", &self.before)));
            }
        }
        let (line, text) = rest.iter().find(|(_, text)| self.has(text) && self.switches(text))?;
        Some((Some(*line), format!("the [transition] command {text:?} is used where the table does not turn")))
    }

    /// Whether a line does what only the profile may ask for; waits may stand anywhere.
    fn switches(&self, text: &str) -> bool {
        let mut parsed = ParsedLine::default();
        parsed.read(text.as_bytes()).is_ok() && matches!(effect(self.firmware, &parsed), Effect::Hazard(_))
    }
}

fn are(own: &[&str], lines: &[(u32, &str)]) -> bool {
    own.len() == lines.len() && own.iter().zip(lines).all(|(own, (_, line))| own == line)
}

fn missing(key: &str, place: &str, own: &[&str]) -> String {
    format!("the commands {place} must be those of [transition] {key} ({})", own.join(", "))
}
