//! Where our own lines are on the wire, no fault may lose one: in a re-entry after a reset, and on the return from a pause. And what
//! the printer knows better than the journal counts.

use std::sync::Arc;
use std::time::Duration;

use trunnion::link::sim::{Quirks, Script, Sim, SimFault};
use trunnion::link::{
    Header, JournalSummary, Loopback, Notice, Outcome, Program, Protocol, Record, Sender, StopReason,
};

use super::bench_machine::{
    assert_once_each, blocks, end, executed, joined, model, program, settings, tail, text, text_at,
};

const MARLIN: Protocol = Protocol::Marlin;
const FIRST: u32 = 60;
/// M115, M105, and then these.
const PROLOGUE: [&str; 9] =
    ["M140 S60", "G28", "G90", "G1Z50.5F900", "G1A30.5C40F600", "M109S200", "G1X1.5Y2.5F6000", "G1Z6.5F900", "G92E0"];

fn entering(program: &Arc<Program>, script: Script) -> Loopback {
    let sim = Sim::new(MARLIN, model(), Quirks::of(MARLIN), script);
    let prologue: Vec<String> = PROLOGUE.iter().map(|line| line.replace(' ', "")).collect();
    Loopback::new(Sender::reentering(Arc::clone(program), settings(MARLIN), &prologue, FIRST), sim)
}

fn wanted(program: &Program) -> Vec<String> {
    let prologue = PROLOGUE.iter().map(|line| line.replace(' ', ""));
    prologue.chain(blocks(program).into_iter().skip(FIRST as usize)).collect()
}

#[test]
fn no_fault_in_a_re_entry_loses_a_line_of_it() {
    let program = program(MARLIN, &text(MARLIN, 80));
    for fault in
        [SimFault::LoseOk, SimFault::MangleOk, SimFault::Drop, SimFault::Corrupt, SimFault::DelayOk, SimFault::HangUp]
    {
        for line in 1..14 {
            let mut link = entering(&program, Script::at(&[(line, fault)]));
            link.record();
            let outcome = link.run(Duration::from_secs(4 * 3600));
            assert_eq!(outcome, Some(Outcome::Done), "{fault:?} at {line}:\n{}", tail(&link, 40));
            assert_eq!(executed(&mut link), wanted(&program), "{fault:?} at {line}");
        }
    }
}

#[test]
fn a_reset_in_a_re_entry_is_a_stop_and_nothing_moves_behind_it() {
    let program = program(MARLIN, &text(MARLIN, 80));
    for line in 4..13 {
        let mut link = entering(&program, Script::at(&[(line, SimFault::Reset)]));
        link.record();
        let outcome = link.run(Duration::from_secs(4 * 3600));
        let stopped = matches!(outcome, Some(Outcome::Stopped(StopReason::Reset { .. })));
        assert!(stopped, "at {line}: {outcome:?}\n{}", tail(&link, 40));
        let done = executed(&mut link);
        let moves = |lines: &[String]| lines.iter().filter(|l| l.starts_with('G')).cloned().collect::<Vec<_>>();
        let before = moves(&wanted(&program)[..line as usize - 2]);
        assert!(before.starts_with(&moves(&done)), "at {line}: {done:?}");
    }
}

/// What the disk has of a print so far: every run, and no acknowledgement.
fn journal(link: &Loopback) -> JournalSummary {
    let records =
        link.events().iter().filter_map(|e| if let Notice::Journal(r) = e { Some(r.to_text()) } else { None });
    JournalSummary::parse(&(Header::default().to_text() + &records.collect::<String>())).unwrap()
}

fn host_again(link: &mut Loopback, program: &Arc<Program>, standing: &JournalSummary) {
    let mut again = Sender::resuming(Arc::clone(program), settings(MARLIN), standing);
    again.reconnected(link.now());
    link.sender = again;
}

#[test]
fn a_host_killed_when_all_is_sent_sends_nothing_twice() {
    let program = program(MARLIN, &(text_at(MARLIN, 40, 600) + "M104 S0\nM140 S0\nG1 X1.25\n"));
    let mut met = 0;
    let mut at = Duration::from_secs(20);
    loop {
        let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::none());
        link.run_to(at);
        if link.sender.outcome().is_some() {
            break;
        }
        let progress = link.sender.progress();
        met += u32::from(progress.sent == progress.of);
        let standing = journal(&link);
        let mut done = executed(&mut link);
        host_again(&mut link, &program, &standing);
        assert_eq!(end(&mut link), Outcome::Done, "{at:?}");
        done.extend(executed(&mut link));
        assert_once_each(&program, &done);
        at += Duration::from_millis(400);
    }
    assert!(met > 3, "killed {met} times behind the last line");
}

/// The plain coordinates of a block.
fn place(block: &str) -> Option<(String, String)> {
    let word = |letter: char| {
        let rest = &block[block.find(letter)? + 1..];
        Some(
            rest[..rest.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(rest.len())]
                .trim()
                .trim_end_matches('0')
                .to_owned(),
        )
    };
    block.starts_with("G1").then(|| Some((word('X')?, word('Y')?))).flatten()
}

#[test]
fn a_host_killed_in_a_pause_comes_back_to_where_the_printer_was() {
    let program = program(MARLIN, &text_at(MARLIN, 120, 600));
    for after in [0, 1, 5, 10, 200] {
        let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::none());
        link.record();
        link.run_to(Duration::from_secs(60));
        link.sender.pause();
        let away = |link: &Loopback| link.events().contains(&Notice::Journal(Record::Away));
        while !away(&link) {
            link.run_to(link.now() + Duration::from_millis(10));
        }
        link.run_to(link.now() + Duration::from_millis(after * 100));
        let standing = journal(&link);
        let all = blocks(&program);
        let before = executed(&mut link).into_iter().filter(|l| all.contains(l)).count();
        host_again(&mut link, &program, &standing);
        assert_eq!(end(&mut link), Outcome::Done, "{after}");
        let behind = executed(&mut link);
        let first = behind
            .iter()
            .position(|l| *l == all[before])
            .unwrap_or_else(|| panic!("{after}: block {before} never came"));
        assert_eq!(behind[first..], all[before..], "{after}");
        let back = behind[..first].iter().rev().find_map(|l| place(l));
        let left = all[..before].iter().rev().find_map(|l| place(l));
        assert!(back.is_some() && back == left, "{after}: back to {back:?}, left at {left:?}\n{}", tail(&link, 60));
    }
}

#[test]
fn an_ok_lost_behind_a_persons_wait_is_not_waited_for_for_ever() {
    let program = program(MARLIN, &("G28\nM0\n".to_owned() + &text(MARLIN, 40)));
    for line in [4, 5] {
        let script = Script::at(&[(line, SimFault::LoseOk)]);
        let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), script);
        link.sim.set_person(Duration::from_secs(7000));
        assert_eq!(end(&mut link), Outcome::Done);
        assert!(link.events().contains(&Notice::UserWait));
        assert_once_each(&program, &executed(&mut link));
    }
}

#[test]
fn the_files_own_question_for_heat_spoils_no_count() {
    for protocol in [MARLIN, Protocol::RepRapFirmware, Protocol::Klipper] {
        let plain = text(protocol, 120);
        let asking: String = plain
            .lines()
            .enumerate()
            .map(|(i, l)| format!("{l}\n{}", if i % 7 == 3 { "M105\n" } else { "" }))
            .collect();
        let (plain, asking) = (program(protocol, &plain), program(protocol, &asking));
        let mut link = joined(&asking, settings(protocol), Quirks::of(protocol), Script::none());
        assert_eq!(end(&mut link), Outcome::Done, "{protocol:?}");
        assert_once_each(&plain, &executed(&mut link));
        assert_eq!(link.sender.progress().resends, 0, "{protocol:?}");
    }
}

fn count(link: &Loopback, wanted: &Notice) -> usize {
    link.events().iter().filter(|event| *event == wanted).count()
}

fn run_until(link: &mut Loopback, wanted: &Notice, times: usize) {
    let bound = link.now() + Duration::from_secs(3600);
    while count(link, wanted) < times {
        assert!(link.now() < bound, "{wanted:?} did not come {times} times");
        link.run_to(link.now() + Duration::from_millis(50));
    }
}

#[test]
fn a_pause_on_the_return_from_a_pause_is_one() {
    let program = program(MARLIN, &text_at(MARLIN, 120, 600));
    let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::none());
    link.run_to(Duration::from_secs(60));
    link.sender.pause();
    run_until(&mut link, &Notice::Paused, 1);
    let sent = link.sender.progress().sent;
    link.sender.resume();
    link.sender.pause();
    run_until(&mut link, &Notice::Paused, 2);
    assert_eq!(link.sender.progress().sent, sent, "no line of the file between");
    link.sender.resume();
    assert_eq!(end(&mut link), Outcome::Done);
}

#[test]
fn a_plug_pulled_in_a_pause_leaves_it_a_pause() {
    let program = program(MARLIN, &text_at(MARLIN, 120, 600));
    let mut link = joined(&program, settings(MARLIN), Quirks::of(MARLIN), Script::none());
    link.run_to(Duration::from_secs(60));
    link.sender.pause();
    run_until(&mut link, &Notice::Paused, 1);
    let resumed = count(&link, &Notice::Resumed);
    link.sender.lost(link.now());
    link.run_to(link.now() + Duration::from_secs(2));
    link.sender.reconnected(link.now());
    link.run_to(link.now() + Duration::from_secs(60));
    assert_eq!(count(&link, &Notice::Resumed), resumed, "it is still a pause");
    link.sender.resume();
    assert_eq!(end(&mut link), Outcome::Done);
    assert_eq!(count(&link, &Notice::Resumed), resumed + 1);
}

#[test]
fn a_line_cut_in_two_without_a_checksum_goes_out_whole() {
    let program = program(Protocol::Klipper, &text_at(Protocol::Klipper, 120, 600));
    let mut link = joined(&program, settings(Protocol::Klipper), Quirks::of(Protocol::Klipper), Script::none());
    for at in 0..10 {
        link.sender.poll(Duration::from_millis(100 * at));
    }
    assert_eq!(link.sender.pending(), b"M115\n");
    link.sender.took(3);
    let rest = b"5\n";
    link.sender.emergency_stop();
    let wanted = [&rest[..], b"M112\n"].concat();
    assert_eq!(String::from_utf8_lossy(link.sender.pending()), String::from_utf8_lossy(&wanted));
}
