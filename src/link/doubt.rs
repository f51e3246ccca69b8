//! What nobody knows after a printer has forgotten where it was: which of the last blocks were printed.
//!
//! Units: blocks from 0, seconds of motion.

use std::ops::Range;

use super::journal::JournalSummary;
use super::program::Program;
use super::protocol::Accounting;
use super::settings::SenderSettings;

/// A journal's end that had not reached the disk when the host lost its power is shorter than this, s.
const UNWRITTEN_S: f64 = 10.0;

impl JournalSummary {
    /// The blocks of which nobody knows whether they were executed, where the printer has been reset: those before are
    /// executed, those from the end on are not. Empty where a pause was reached.
    ///
    /// An answered block may still have been in the printer's planner, or (not on Marlin) in a buffer that holds motion by its
    /// time, so that the last [`SenderSettings::planner_blocks`] answered ones do not count as executed, nor three seconds before
    /// those. What the host has sent it wrote down before, and exactly where it ended in order; one that lost its power (not
    /// `same_boot`) may have lost the journal's end too.
    pub fn doubtful(&self, program: &Program, settings: &SenderSettings, same_boot: bool) -> Range<u32> {
        if let Some(block) = self.paused {
            let block = block.min(program.len());
            return block..block;
        }
        let answered = self.answered.max(self.next_block(self.proven)).min(program.len());
        let mut start = answered.saturating_sub(settings.planner_blocks);
        let mut left = settings.protocol.traits().buffered_s;
        while left > 0.0 && start > 0 {
            start -= 1;
            left -= program.seconds(start);
        }
        let end = self.unsent(program, settings, same_boot);
        start.max(self.resumed_at).min(end)..end
    }

    /// The first block that was not sent, or a later one.
    pub(super) fn unsent(&self, program: &Program, settings: &SenderSettings, same_boot: bool) -> u32 {
        let mut end = match self.sent {
            // What a host has said in its last words may be all that is lost.
            // A re-entry goes back behind what may stand already.
            Some(sent) if same_boot => sent.max(self.stood),
            // Where a run begins is written before it is sent, and a run ends with the next proof.
            _ => self.reach.saturating_add(settings.prove_every).saturating_add(1),
        };
        let mut left = if same_boot { 0.0 } else { UNWRITTEN_S };
        while left > 0.0 && end < program.len() {
            left -= program.seconds(end);
            end += 1;
        }
        end.min(program.len())
    }

    /// Whether [`JournalSummary::doubtful`] has an end: a protocol without proofs writes down where it is only now and then.
    pub(super) fn has_end(&self, settings: &SenderSettings) -> bool {
        settings.protocol.traits().accounting != Accounting::Status || self.paused.is_some() || self.sent.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::journal::Header;
    use crate::link::protocol::Protocol;
    use crate::link::retreat::Retreat;
    use crate::link::testing::{retreat, rules};

    /// Three lines, then 120 moves of a second each.
    fn program(protocol: Protocol) -> Program {
        let moves: String = (0..120).map(|i| format!("G1 X{}\n", (i + 1) % 2)).collect();
        let text = format!("G28\nG90\nG1 X0 Y0 Z10 F60\n{moves}");
        Program::read(text.as_bytes(), &rules(protocol)).unwrap()
    }

    fn journal(records: &str) -> JournalSummary {
        JournalSummary::parse(&(Header::default().to_text() + records)).unwrap()
    }

    fn doubt(protocol: Protocol, records: &str, same_boot: bool) -> Range<u32> {
        let settings =
            SenderSettings { planner_blocks: 24, prove_every: 32, ..SenderSettings::new(protocol, retreat()) };
        journal(records).doubtful(&program(protocol), &settings, same_boot)
    }

    const LEFT: &str = "run 1 0\nack 60 60\n";

    #[test]
    fn what_was_answered_may_wait_in_the_planner_and_in_seconds_of_motion() {
        let sent = format!("{LEFT}sent 64\n");
        assert_eq!(doubt(Protocol::Marlin, &sent, true), 36..64);
        // Three seconds more, which are three moves.
        for protocol in [Protocol::RepRapFirmware, Protocol::Klipper, Protocol::Grbl] {
            assert_eq!(doubt(protocol, &sent, true), 33..64, "{protocol:?}");
        }
        // A line that is proven is answered, whatever else is written; the beginning of the file is executed by nobody.
        assert_eq!(doubt(Protocol::Marlin, "run 1 0\nack 70 60\nsent 75\n", true), 46..75);
        assert_eq!(doubt(Protocol::Klipper, "run 1 0\nack 20 20\nsent 22\n", true), 0..22);
        assert_eq!(doubt(Protocol::Klipper, "run 1 0\nack 25 25\nsent 26\n", true), 0..26);
        // More answered than the file has, or than was sent by its last word.
        assert_eq!(doubt(Protocol::Marlin, "run 1 0\nack 200 200\n", true), 99..123);
        assert_eq!(doubt(Protocol::Marlin, "run 1 0\nack 60 60\nsent 30\n", true), 30..30);
    }

    #[test]
    fn seconds_of_motion_are_those_of_the_lines_that_they_are_of() {
        // Lines of one, two and four seconds in turn from block 4 on.
        let moves: String = (0..60).map(|i| format!("G1 X{}\n", [1, 2, 4][i % 3])).collect();
        let text = format!("G28\nG90\nG1 X0 Y0 Z10 F60\nG91\n{moves}");
        let program = Program::read(text.as_bytes(), &rules(Protocol::Klipper)).unwrap();
        assert_eq!([4, 5, 6].map(|block| program.seconds(block).round()), [1.0, 2.0, 4.0]);
        let settings = SenderSettings { planner_blocks: 3, ..SenderSettings::new(Protocol::Klipper, retreat()) };
        // Three blocks and three seconds: one of four, or one of two and one of one, or one of one and one of four.
        let start = |answered: u32| {
            journal(&format!("run 1 0\nack {answered} {answered}\nsent 60\n")).doubtful(&program, &settings, true).start
        };
        assert_eq!([start(10), start(9), start(11)], [6, 4, 6]);
        // Ten seconds that a host without power may have sent: 4 + 1 + 2 + 4 from block 42 on.
        let end = journal("run 1 0\nack 9 9\n").unsent(&program, &settings, false);
        assert_eq!(end, 9 + 33 + 4);
    }

    #[test]
    fn what_was_sent_ends_with_the_hosts_last_word_or_the_next_proof() {
        assert_eq!(doubt(Protocol::Marlin, LEFT, true), 36..60 + 32 + 1);
        // Without power the journal's last ten seconds may be lost, and the last word is none.
        assert_eq!(doubt(Protocol::Marlin, &format!("{LEFT}sent 64\n"), false), 36..60 + 33 + 10);
        // A run is written before it is sent.
        assert_eq!(doubt(Protocol::Marlin, &format!("{LEFT}run 70 68\n"), true), 36..68 + 33);
        assert_eq!(doubt(Protocol::Marlin, "run 1 0\nack 110 110\n", true), 86..123);
    }

    #[test]
    fn a_pause_and_a_re_entry_leave_no_more_in_doubt_than_they_must() {
        assert_eq!(doubt(Protocol::Marlin, &format!("{LEFT}away\npaused 61\n"), true), 61..61);
        assert_eq!(doubt(Protocol::Marlin, &format!("{LEFT}away\npaused 9999\n"), false), 123..123);
        // It went on at block 50; what stood behind that before still does.
        let again = format!("{LEFT}sent 64\nentering\nanew\nrun 1 50\nback\nack 3 52\n");
        assert_eq!(doubt(Protocol::Marlin, &again, true), 50..93);
        assert_eq!(doubt(Protocol::Marlin, &format!("{again}sent 55\n"), true), 50..64);
        // One that was interrupted takes nothing back of what was answered before it.
        let entering = format!("{LEFT}sent 64\nentering\nanew\nrun 1 40\nack 9 40\n");
        assert_eq!(doubt(Protocol::Marlin, &entering, true), 36..64);
    }

    #[test]
    fn only_a_protocol_without_proofs_may_have_no_end() {
        let ends = |protocol, records: &str| journal(records).has_end(&SenderSettings::new(protocol, retreat()));
        assert!(ends(Protocol::Marlin, LEFT) && ends(Protocol::Klipper, LEFT) && !ends(Protocol::Grbl, LEFT));
        assert!(
            ends(Protocol::Grbl, &format!("{LEFT}sent 64\n")) && ends(Protocol::Grbl, &format!("{LEFT}paused 60\n"))
        );
    }

    #[test]
    fn a_printer_that_was_not_reset_stands_behind_what_it_has_answered() {
        let blocks = |protocol: Protocol, records: &str| -> Option<Vec<u32>> {
            let settings = SenderSettings::new(protocol, retreat());
            let places = journal(records).stands_at(&program(protocol), &settings, true)?;
            Some(places.iter().map(|place| place.block).collect())
        };
        let sent = format!("{LEFT}sent 64\n");
        assert_eq!(blocks(Protocol::Klipper, &sent), Some((60..=64).collect()));
        assert_eq!(blocks(Protocol::Grbl, LEFT), Some((60..=123).collect()));
        // On the way off the part nobody knows; in a pause it is above the part.
        assert_eq!(blocks(Protocol::Klipper, &format!("{sent}away\n")), None);
        assert_eq!(blocks(Protocol::Klipper, &format!("{LEFT}away\npaused 61\n")), Some(vec![61]));
        let above = |z_max_mm: f64| {
            let settings = SenderSettings::new(Protocol::Klipper, Retreat { z_max_mm, ..retreat() });
            let places =
                journal("run 1 0\npaused 61\n").stands_at(&program(Protocol::Klipper), &settings, true).unwrap();
            places[0].words.iter().find(|(letter, _)| *letter == b'Z').unwrap().1
        };
        assert_eq!([above(300.0), above(25.0), above(5.0)], [30.0, 25.0, 10.0]);
    }
}
