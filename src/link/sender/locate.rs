//! A printer without a counter that was not reset: where it is tells how far it has come.

use super::activity::Activity;
use super::{Sender, StopReason};
use crate::link::place::Place;
use crate::link::reply::Status;
use crate::link::state::MachineState;

impl Sender {
    /// Whether the printer is being asked where it is.
    pub(super) fn is_locating(&self) -> bool {
        matches!(self.activity, Activity::Locate { .. })
    }

    /// All that is under way ends first.
    pub(super) fn ask_where(&mut self) {
        if let Activity::Locate { asked, .. } = &mut self.activity {
            *asked = true;
        }
        let mut lines = vec![self.traits().drain.to_owned()];
        lines.extend(self.traits().is_printer().then(|| "M114".to_owned()));
        self.queue(&lines);
    }

    /// Grbl's word: its machine position less its offset, once it stands still.
    pub(super) fn locate(&mut self, status: &Status) {
        let asked = matches!(self.activity, Activity::Locate { asked: true, .. });
        if !asked || !status.state.starts_with("Idle") || self.ledger.in_flight() > 0 {
            return;
        }
        let offset = |i: usize| self.offset.get(i).copied().unwrap_or(0.0);
        let places = status.position.iter().enumerate().map(|(i, at)| at - offset(i));
        let own = self.settings.retreat.axes.each_ref().map(|a| a.letter);
        let words = letters(&self.printer.identity, own, status.position.len()).into_iter().zip(places).collect();
        if let Activity::Locate { said, .. } = &mut self.activity {
            *said = Some(words);
        }
    }

    /// It has said where it is.
    pub(super) fn located(&mut self) {
        let Activity::Locate { places, away, said: Some(said), .. } = &self.activity else { return };
        let away = *away;
        let Some(block) = Place::fitting(places, said) else {
            let word = |(letter, value): &(u8, f64)| format!("{}{value:.2}", char::from(*letter));
            let said = said.iter().map(word).collect::<Vec<_>>().join(" ");
            self.stop(StopReason::Misplaced { said });
            return;
        };
        (self.next_block, self.acked_blocks) = (block, block);
        self.knows_all = true;
        let line = self.program.file_line(block);
        self.note(format!("the printer has kept its position; continuing at line {line}"));
        let lines = if away {
            self.return_lines()
        } else {
            // Some printers let their heaters go cold where nobody speaks.
            let state = MachineState::before(&self.program, block).ok();
            state.map_or(Vec::new(), |state| self.settings.retreat.heat(&state, self.settings.protocol))
        };
        self.queue(&lines);
        self.activity = Activity::Return { owed: false, pause_behind: false };
    }
}

/// The letters in grblHAL's `[AXS:5:XYZAC]`, in the order of its status; `None` in any other line.
pub fn told_axes(line: &str) -> Option<&str> {
    Some(line.strip_prefix("[AXS:")?.trim_end_matches(']').split_once(':')?.1)
}

/// The order of the `count` axes in a status: as the firmware says (`[AXS:5:XYZAC]`). FluidNC does not, and has all axes up to its last in
/// their usual order; of five the last two are the `own` ones of the profile's table.
fn letters(identity: &str, own: [u8; 2], count: usize) -> Vec<u8> {
    let told = |line: &str| Some(told_axes(line)?.as_bytes().to_vec());
    let usual = || match count {
        6.. => b"XYZABCUVW".iter().copied().take(count).collect(),
        _ => [b"XYZ".as_slice(), own.as_slice()].concat(),
    };
    identity.lines().find_map(told).unwrap_or_else(usual)
}

#[cfg(test)]
mod tests {
    use super::letters;

    /// A filament axis among them was taken for the tilt.
    #[test]
    fn places_go_to_their_own_axes() {
        let fluid = "[VER:3.9 FluidNC v3.9.9:]\n[OPT:MPHS]";
        assert_eq!(letters(fluid, *b"BC", 6), b"XYZABC");
        assert_eq!(letters(fluid, *b"AC", 7), b"XYZABCU");
        assert_eq!(letters(fluid, *b"AC", 5), b"XYZAC");
        assert_eq!(letters("[VER:1.1f]\n[AXS:6:XYZACU]", *b"AC", 6), b"XYZACU");
    }
}
