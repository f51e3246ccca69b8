//! Printers without a line counter that have kept their place, and others that have lost it: what a pause or a kill has promised, the
//! resume keeps. At random moments, in virtual time, on every protocol.

use std::sync::Arc;
use std::time::Duration;

use trunnion::link::sim::{Logged, Quirks, Script};
use trunnion::link::{
    Header, JournalSummary, Loopback, Notice, Outcome, Program, Protocol, Record, ReentryError, Sender, SenderSettings,
    StopReason,
};

use super::bench_machine::{blocks, end, joined, program, settings, text};
use super::second_resume::{Journal, found};
use crate::support::{Numbers, note};

const MOVES: u32 = 400;

/// A print whose every place is known from its first layer on.
fn part(protocol: Protocol) -> Arc<Program> {
    let start = if protocol == Protocol::Grbl { "F1800\n" } else { "G28\n" };
    let posed = format!("{start}G1 A0 F600\nG1 C0 F600\nG1 X0 Y0 Z5 F1800\n");
    program(protocol, &text(protocol, MOVES).replacen(start, &posed, 1))
}

fn home(protocol: Protocol) -> SenderSettings {
    let mut settings = settings(protocol);
    if protocol == Protocol::Grbl {
        settings.retreat.home = vec!["$H".to_owned()];
    }
    settings
}

/// The file's own moves among what was executed: ours carry a speed.
fn laid<'a>(lines: impl Iterator<Item = &'a String>) -> Vec<String> {
    lines
        .filter(|l| l.starts_with("G1X") && !l.contains('F'))
        .map(|l| super::bench_machine::without_padding(l))
        .collect()
}

/// What the printer has taken so far, and where its last move before a reset ended.
fn taken(link: &mut Loopback) -> (Vec<String>, Option<[f64; 6]>) {
    let (mut lines, mut last, mut reset) = (Vec::new(), None, None);
    for (_, logged) in link.sim.take_log() {
        match logged {
            Logged::Accepted(block) => lines.push(String::from_utf8_lossy(&block).into_owned()),
            Logged::Pose(axes) => last = Some(axes),
            Logged::Restarted => reset = last,
            Logged::Killed => {}
        }
    }
    (laid(lines.iter()), reset)
}

struct Broken {
    program: Arc<Program>,
    link: Loopback,
    journal: Journal,
}

impl Broken {
    /// Some way into the print.
    fn at(protocol: Protocol, share: f64) -> Self {
        let program = part(protocol);
        let mut link = joined(&program, home(protocol), Quirks::of(protocol), Script::none());
        let mut journal = Journal::new();
        let until = (f64::from(program.len()) * share) as u32;
        while link.sender.progress().acked < until {
            assert!(link.sender.outcome().is_none(), "{:?}", link.sender.outcome());
            journal.step(&mut link);
        }
        // Not only at whole steps.
        let now = link.now() + Duration::from_secs_f64(share * 7.0 % 0.24);
        link.run_to(now);
        journal.note(&link);
        Self { program, link, journal }
    }

    /// A pause that is reached, and the end of its host.
    fn pause(&mut self) {
        self.link.sender.pause();
        while !self.link.events().contains(&Notice::Paused) {
            assert!(self.link.sender.outcome().is_none(), "{:?}", self.link.sender.outcome());
            self.journal.step(&mut self.link);
        }
        self.journal.step(&mut self.link);
    }

    fn standing(&self) -> JournalSummary {
        self.journal.standing()
    }

    /// The next host, while the printer is as it was.
    fn carry_on(&mut self, protocol: Protocol) {
        let standing = self.standing();
        let (program, settings) = (Arc::clone(&self.program), home(protocol));
        // What was on its way is lost; the printer does what it has.
        self.link.sim.unplugged();
        self.link.sender = if protocol == Protocol::Marlin {
            Sender::resuming(program, settings, &standing)
        } else {
            let places = standing.stands_at(&program, &settings, true).unwrap();
            Sender::locating(program, settings, places, standing.paused.is_some())
        };
        let now = self.link.now();
        self.link.sender.reconnected(now);
    }

    /// The next host, after a reset of the printer.
    fn enter(&mut self, protocol: Protocol) -> trunnion::link::Reentry {
        let mut entry = found(&self.program, protocol, &self.standing());
        if protocol == Protocol::Grbl {
            let doubtful = entry.doubtful.clone();
            entry = trunnion::link::Reentry::at(&self.program, &home(protocol), &doubtful, entry.block).unwrap();
        }
        self.link.sender = Sender::reentering(Arc::clone(&self.program), home(protocol), &entry.lines, entry.block);
        entry
    }
}

const ALL: [Protocol; 4] = [Protocol::Grbl, Protocol::Klipper, Protocol::RepRapFirmware, Protocol::Marlin];

#[test]
fn a_pause_whose_host_has_ended_goes_on_where_the_printer_stands() {
    for protocol in ALL {
        let mut numbers = Numbers::seeded(17);
        for _ in 0..10 {
            let at = numbers.between(0.2, 0.85);
            let mut broken = Broken::at(protocol, at);
            broken.pause();
            assert!(broken.standing().paused.is_some_and(|p| p > 20), "{protocol:?} at {at}: {:?}", broken.standing());
            broken.carry_on(protocol);
            assert_eq!(end(&mut broken.link), Outcome::Done, "{protocol:?} at {at}");
            let (done, _) = taken(&mut broken.link);
            assert_eq!(done, laid(blocks(&broken.program).iter()), "{protocol:?} at {at}: every line once");
        }
    }
}

#[test]
fn a_host_that_is_killed_goes_on_where_the_printer_stands() {
    for protocol in ALL {
        let mut numbers = Numbers::seeded(18);
        for _ in 0..10 {
            let at = numbers.between(0.2, 0.85);
            let mut broken = Broken::at(protocol, at);
            broken.carry_on(protocol);
            assert_eq!(end(&mut broken.link), Outcome::Done, "{protocol:?} at {at}: {:?}", broken.link.events().last());
            let (done, _) = taken(&mut broken.link);
            assert_eq!(done, laid(blocks(&broken.program).iter()), "{protocol:?} at {at}: every line once");
        }
    }
}

#[test]
fn a_printer_that_was_moved_or_reset_meanwhile_is_not_taken_at_its_word() {
    for protocol in [Protocol::Grbl, Protocol::Klipper, Protocol::RepRapFirmware] {
        let mut broken = Broken::at(protocol, 0.5);
        broken.pause();
        taken(&mut broken.link);
        let now = broken.link.now();
        broken.link.sim.receive(now, b"G91\nG1 X0.5 F600\nG90\n");
        broken.carry_on(protocol);
        let outcome = end(&mut broken.link);
        assert!(
            matches!(&outcome, Outcome::Stopped(StopReason::Misplaced { said }) if said.starts_with('X')),
            "{protocol:?}: {outcome:?}"
        );
        let (done, _) = taken(&mut broken.link);
        assert!(
            done.iter().all(|l| l.starts_with("G1X.5") || l.starts_with("G1X0.5") || l.starts_with("G1 X0.5")),
            "{protocol:?}: {done:?}"
        );
    }
}

/// What a pause has said holds though the printer is switched off behind it: nothing is missing and nothing is laid twice.
#[test]
fn a_pause_outlives_a_reset_of_the_printer() {
    for protocol in ALL {
        let mut numbers = Numbers::seeded(19);
        for _ in 0..10 {
            let at = numbers.between(0.2, 0.85);
            let mut broken = Broken::at(protocol, at);
            broken.pause();
            broken.link.sim.restart(Duration::from_secs(2));
            let now = broken.link.now() + Duration::from_secs(10);
            broken.link.sim.advance(now);
            let entry = broken.enter(protocol);
            assert!(entry.doubtful.is_empty() && entry.missing_mm + entry.twice_mm < 1e-9, "{entry:?}");
            assert_eq!(end(&mut broken.link), Outcome::Done, "{protocol:?} at {at}");
            let (done, _) = taken(&mut broken.link);
            assert_eq!(done, laid(blocks(&broken.program).iter()), "{protocol:?} at {at}: every line once");
        }
    }
}

/// A reset in mid-print: what was really printed lies in what the host says of it, and what is missing or laid twice in what it owns up to.
#[test]
fn what_a_reset_leaves_in_doubt_is_what_is_in_doubt() {
    let mut widest = 0;
    for protocol in ALL {
        let mut numbers = Numbers::seeded(20);
        for _ in 0..20 {
            let at = numbers.between(0.2, 0.85);
            let mut broken = Broken::at(protocol, at);
            broken.link.sim.restart(Duration::from_secs(2));
            while broken.link.sender.outcome().is_none() {
                broken.journal.step(&mut broken.link);
            }
            let outcome = broken.link.sender.outcome();
            // Klipper says nothing of its own that others could not say.
            let noticed = matches!(
                outcome,
                Some(Outcome::Stopped(
                    StopReason::Reset { .. } | StopReason::Unaccounted { .. } | StopReason::Error { .. }
                ))
            );
            assert!(noticed, "{protocol:?}: {outcome:?}");
            broken.journal.text += &Record::Sent(broken.link.sender.sent_at_most().unwrap()).to_text();
            let now = broken.link.now() + Duration::from_secs(10);
            broken.link.run_to(now);
            let (_, reset) = taken(&mut broken.link);
            // Every move has a Y of its own.
            let moves = ((reset.unwrap()[1] + 100.0) * 1000.0).round();
            let all = blocks(&broken.program);
            let own = |l: &String| l.starts_with("G1X") && !l.contains('F');
            let executed = all.iter().enumerate().filter(|(_, l)| own(l)).nth(moves as usize).unwrap().0 as u32 + 1;
            let entry = broken.enter(protocol);
            let doubtful = entry.doubtful.clone();
            assert!(
                (doubtful.start..=doubtful.end).contains(&executed),
                "{protocol:?} at {at}: {executed} of {doubtful:?}"
            );
            widest = widest.max(doubtful.end - doubtful.start);
            assert_eq!(end(&mut broken.link), Outcome::Done, "{protocol:?} at {at}");
            let (again, _) = taken(&mut broken.link);
            assert_eq!(again, laid(all[entry.block as usize..].iter()), "{protocol:?} at {at}: the rest once each");
        }
    }
    note(&format!("80 resets: the last line printed is always among those in doubt, at most {widest} of them"));
}

#[test]
fn a_killed_host_of_a_machine_that_counts_nothing_asks_for_a_look_at_the_part() {
    let program = part(Protocol::Grbl);
    let standing = JournalSummary::parse(&format!("{}run 1 0\nack 90 90\n", Header::default().to_text())).unwrap();
    let ask = |from| trunnion::link::Reentry::doubt(&program, &home(Protocol::Grbl), &standing, true, from);
    let error = ask(None).unwrap_err();
    assert!(matches!(error, ReentryError::Uncounted { protocol: "grbl", .. }), "{error}");
    assert!(error.to_string().contains("--from LINE"), "{error}");
    let line = program.file_line(120);
    assert_eq!(ask(Some(line)), Ok(120..120));
    assert!(matches!(ask(Some(2)), Err(ReentryError::NotInDoubt { line: 2, .. })));
}
