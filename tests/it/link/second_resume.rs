//! A re-entry that is interrupted is repeated from its start: it never continues from its middle, and never begins with the
//! file's first line.

#[cfg(unix)]
mod commands;

use std::sync::Arc;
use std::time::Duration;

use trunnion::link::sim::{Quirks, Script, SimFault};
use trunnion::link::{
    Header, JournalSummary, Loopback, MachineState, Notice, Outcome, Program, Protocol, Record, Reentry, Sender,
    StopReason,
};

use super::bench_machine::{blocks, end, executed, joined, program, settings, text};

const MARLIN: Protocol = Protocol::Marlin;
const STEP: Duration = Duration::from_millis(250);

/// A journal as the disk has it: what the sender has said, and how far it is after each step.
pub(super) struct Journal {
    pub(super) text: String,
    seen: usize,
    acked: i64,
}

impl Journal {
    pub(super) fn new() -> Self {
        Self { text: Header::default().to_text(), seen: 0, acked: 0 }
    }

    pub(super) fn step(&mut self, link: &mut Loopback) {
        let to = link.now() + STEP;
        link.run_to(to);
        self.note(link);
    }

    /// What has been said since.
    pub(super) fn note(&mut self, link: &Loopback) {
        for event in &link.events()[self.seen..] {
            if let Notice::Journal(record) = event {
                self.text += &record.to_text();
            }
        }
        self.seen = link.events().len();
        let progress = link.sender.progress();
        if progress.proven != self.acked {
            self.acked = progress.proven;
            self.text += &Record::Ack { number: progress.proven, block: progress.acked }.to_text();
        }
    }

    pub(super) fn standing(&self) -> JournalSummary {
        JournalSummary::parse(&self.text).unwrap()
    }

    /// The next host's sender: the counter where it is enough, else the re-entry from its start.
    fn go_on(&mut self, program: &Arc<Program>, entry: &Reentry) -> Sender {
        let standing = self.standing();
        assert!(standing.began(), "{}", self.text);
        if standing.counts() {
            return Sender::resuming(Arc::clone(program), settings(MARLIN), &standing);
        }
        let found = found(program, MARLIN, &standing);
        assert_eq!(found.block, entry.block, "the same place as before");
        self.text += &(Record::Entering.to_text() + &Record::Anew.to_text());
        Sender::reentering(Arc::clone(program), settings(MARLIN), &entry.lines, entry.block)
    }
}

/// The re-entry of a host that cannot prove its path.
pub(super) fn found(program: &Program, protocol: Protocol, standing: &JournalSummary) -> Reentry {
    let settings = settings(protocol);
    let doubtful = Reentry::doubt(program, &settings, standing, true, None).unwrap();
    let choices = Reentry::choices(program, &doubtful).unwrap();
    Reentry::at(program, &settings, &doubtful, Reentry::unproved(program, &doubtful, &choices)).unwrap()
}

/// A journal that knows that the blocks before this one are answered.
fn answered(block: u32) -> JournalSummary {
    JournalSummary::parse(&format!("{}ack 1 {block}\n", Header::default().to_text())).unwrap()
}

/// A print that a reset has interrupted, its journal, and the re-entry; the printer's log begins there.
fn broken_off() -> (Arc<Program>, Loopback, Journal, Reentry) {
    let at_a_pose = text(MARLIN, 300).replace("G28\n", "G28\nG1 A0 F600\nG1 C0 F600\nG1 X0 Y0 Z5 F6000\n");
    let program = program(MARLIN, &at_a_pose);
    let script = Script::at(&[(200, SimFault::Reset)]);
    let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), script);
    let mut journal = Journal::new();
    while link.sender.outcome().is_none() {
        journal.step(&mut link);
    }
    assert!(matches!(link.sender.outcome(), Some(Outcome::Stopped(StopReason::Reset { .. }))));
    executed(&mut link);
    let entry = found(&program, MARLIN, &journal.standing());
    journal.text += &(Record::Entering.to_text() + &Record::Anew.to_text());
    link.sender = Sender::reentering(Arc::clone(&program), settings(MARLIN), &entry.lines, entry.block);
    journal.acked = 0;
    (program, link, journal, entry)
}

/// The re-entry and everything from its block on, as `executed` has them.
fn wanted(program: &Program, entry: &Reentry) -> Vec<String> {
    let own = entry.lines.iter().filter(|l| l.as_str() != "M400").cloned();
    own.chain(blocks(program).split_off(entry.block as usize)).collect()
}

/// At every quarter of a second of the re-entry, and some way into the print behind it, the host is killed.
#[test]
fn a_host_killed_anywhere_in_the_re_entry_repeats_it_or_has_completed_it() {
    let (program, mut link, mut journal, entry) = broken_off();
    let wanted = wanted(&program, &entry);
    let (mut again, mut on) = (0, 0);
    while link.sender.progress().acked < entry.block + 40 {
        journal.step(&mut link);
        let (mut cut, mut text) = (link.clone(), Journal { text: journal.text.clone(), ..Journal::new() });
        let counts = text.standing().counts();
        cut.sender = text.go_on(&program, &entry);
        let now = cut.now();
        cut.sender.reconnected(now);
        assert_eq!(end(&mut cut), Outcome::Done, "after {now:?}: {:?}", cut.events().last());
        let done = executed(&mut cut);
        let tail = &done[done.len().saturating_sub(wanted.len())..];
        let first = tail.iter().zip(&wanted).position(|(d, w)| d != w);
        assert!(tail == wanted, "after {now:?}: {first:?} {:?}", first.map(|i| (&tail[i], &wanted[i])));
        let before = &done[..done.len() - wanted.len()];
        assert!(before.iter().all(|l| entry.lines.contains(l)), "after {now:?}: {before:?}");
        assert!(!counts || before.is_empty(), "after {now:?}: the re-entry was carried out twice");
        if counts { on += 1 } else { again += 1 }
    }
    assert!(again > 10 && on > 3, "{again} kills during the re-entry, {on} behind it");
}

#[test]
fn the_re_entry_is_complete_once_it_is_proven_and_before_the_next_block_goes_out() {
    let (_, mut link, mut journal, entry) = broken_off();
    while !journal.text.ends_with("back\n") {
        journal.step(&mut link);
        let back = journal.text.rfind("back\n").unwrap_or(journal.text.len());
        if back < journal.text.len() {
            break;
        }
        assert!(link.sender.progress().sent == entry.block, "a block goes out before the re-entry is complete");
    }
    let standing = journal.standing();
    assert!(standing.counts() && !standing.entering && !standing.away, "{standing:?}");
}

/// A reset during the re-entry, and again a few lines behind it: never back to what stood before the first.
#[test]
fn interrupted_re_entries_do_not_step_back_layer_by_layer() {
    let (program, mut link, mut journal, mut entry) = broken_off();
    for behind in [0, 3, 30] {
        while link.sender.progress().acked < entry.block + behind || !journal.standing().runs_began() {
            journal.step(&mut link);
        }
        link.sim.restart(Duration::from_secs(2));
        while link.sender.outcome().is_none() {
            journal.step(&mut link);
        }
        let outcome = link.sender.outcome();
        assert!(matches!(outcome, Some(Outcome::Stopped(StopReason::Reset { .. }))), "{behind}: {outcome:?}");
        let found = found(&program, MARLIN, &journal.standing());
        assert!(found.block >= entry.block, "after {behind} lines: {} before {}", found.block, entry.block);
        entry = found;
        journal.text += &(Record::Entering.to_text() + &Record::Anew.to_text());
        journal.acked = 0;
        link.sender = Sender::reentering(Arc::clone(&program), settings(MARLIN), &entry.lines, entry.block);
    }
    assert_eq!(end(&mut link), Outcome::Done);
    let (done, wanted) = (executed(&mut link), wanted(&program, &entry));
    assert!(done.ends_with(&wanted), "{} done, {} wanted last", done.len(), wanted.len());
}

trait Began {
    /// Whether lines went out since the numbers began anew.
    fn runs_began(&self) -> bool;
}

impl Began for JournalSummary {
    fn runs_began(&self) -> bool {
        self.proven > 2
    }
}

/// Some firmwares answer a move when it is in a buffer that holds seconds of motion, however many lines that is.
#[test]
fn what_seconds_of_motion_ago_was_answered_may_not_have_been_executed() {
    // 0.05 s a line: 24 lines are 1.2 s.
    let layer = |z: u32| {
        let moves: String = (0..200).map(|i| format!("G1 X{} E0.01\n", i % 2)).collect();
        format!(";LAYER_CHANGE\nG1 Z{z}\n{moves}")
    };
    let file = format!("G28\nG90\nM83\nG1 A0 C0 F600\nG1 X0 Y0 Z1 F1200\n{}{}", layer(1), layer(2));
    let program = program(Protocol::Klipper, &file);
    let second = program.boundaries[1].block;
    for behind in [20, 26, 60, 120] {
        let settings = settings(Protocol::Klipper);
        let doubtful = answered(second + behind).doubtful(&program, &settings, true);
        assert_eq!(doubtful, second + behind - 24 - 60..second + behind + 33, "{behind} lines behind the mark");
    }
}

#[test]
fn settings_that_a_file_gives_in_parts_are_all_restored() {
    let kept = |text: &str| {
        let program = program(MARLIN, text);
        let state = MachineState::before(&program, program.len()).unwrap();
        state.kept
    };
    assert_eq!(
        kept("M205 X8 Y8 Z0.4 E1.5\nM205 S0 T0\nM201 X1000\nM201 Y900\nM203 X200 Y200\nM203 Z12\n"),
        ["M205X8Y8Z.4 E1.5", "M205S0T0", "M201X1000", "M201Y900", "M203X200Y200", "M203Z12"]
    );
    // What a later line says again counts from there.
    assert_eq!(kept("M204 P1000 T2000\nM204 P500\nM204 P800 T900\n"), ["M204P800T900"]);
    assert_eq!(kept("M106 S100\nM106 P1 S50\nM106 S200\nM106 P1 S60\n"), ["M106S200", "M106P1S60"]);
    assert_eq!(kept("M106 S100\nM106 P1 S50\nM107\n"), ["M106P1S50", "M107"]);
    let others = ["M141S40", "M155S2", "M207S2", "M208S0", "M593F40", "M595P60"];
    assert_eq!(kept(&(others.join("\n") + "\n")), others);
    assert_eq!(kept("M593 X F40\nM593 Y F35\nM593 X F50\n"), ["M593Y F35", "M593X F50"]);
}

/// Where the re-entry was interrupted behind its last line, the printer may still read F as a rate.
#[test]
fn the_re_entry_begins_in_the_modes_that_it_is_written_in() {
    let text = "G28\nG90\nG1 A0 C0 F600\nG1 X0 Y0 Z5 F1200\nG93\n;LAYER_CHANGE\n".to_owned()
        + &"G1 X1 F60\nG1 X0 F60\n".repeat(90);
    // Marlin has no G93.
    let program = program(Protocol::RepRapFirmware, &text);
    let entry = found(&program, Protocol::RepRapFirmware, &answered(program.len()));
    let at = |line: &str| entry.lines.iter().position(|l| l == line);
    assert!(at("G94").unwrap() < at("G28").unwrap() && at("G90").unwrap() < at("G28").unwrap(), "{:?}", entry.lines);
    assert_eq!(entry.lines.last().map(String::as_str), Some("G93"));
}
