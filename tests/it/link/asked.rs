//! What a printer asks of its host: every word of the table, with a pause at a tilt, in virtual time.

use std::time::Duration;

use trunnion::link::sim::{Quirks, Script};
use trunnion::link::{Loopback, Notice, Outcome, Protocol};

use super::bench_machine::{blocks, end, executed, joined, program, settings, text_at};

const MARLIN: Protocol = Protocol::Marlin;

/// Some way into a print whose table is tilted and turned.
fn printing(person: bool) -> (Vec<String>, Loopback) {
    printing_on(MARLIN, person)
}

/// The same on another firmware.
fn printing_on(protocol: Protocol, person: bool) -> (Vec<String>, Loopback) {
    let begin = "G28\nG1 A30 F600\nG1 C45 F600\n";
    // RepRapFirmware takes no M0 but as the end of the file.
    let stands = if protocol == MARLIN { "M0" } else { "G4 S7000" };
    let wait = if person { format!("{stands}\nG1 X1 Y-60\n") } else { String::new() };
    let program = program(protocol, &(text_at(protocol, 60, 600).replace("G28\n", begin) + &wait));
    let mut link =
        joined(&program, settings(protocol), Quirks { busy: !person, ..Quirks::of(protocol) }, Script::none());
    link.sim.set_person(Duration::from_secs(7000));
    let until = if person { program.len() - 2 } else { 40 };
    while link.sender.progress().acked < until {
        assert!(link.sender.outcome().is_none(), "{:?}", link.sender.outcome());
        link.run_to(link.now() + Duration::from_millis(100));
    }
    (blocks(&program), link)
}

fn ask(link: &mut Loopback, words: &str) {
    let now = link.now();
    link.sender.receive(now, format!("{words}\n").as_bytes());
}

/// Lines of ours between those of the program.
fn of_the_program(done: Vec<String>, blocks: &[String]) -> Vec<String> {
    let mut wanted = blocks.iter().peekable();
    done.into_iter().filter(|line| wanted.next_if(|block| *block == line).is_some()).collect()
}

fn notes(link: &Loopback) -> String {
    link.events().iter().filter_map(|e| if let Notice::Note(text) = e { Some(text.as_str()) } else { None }).collect()
}

#[test]
fn a_pause_that_the_printer_asks_for_is_one_above_the_part() {
    for words in [
        "//action:pause",
        "// action:pause",
        "//action:out_of_filament T0",
        "RequestPause:No filament",
        "Err: FAN ERROR\n// action:pause",
        "//action:disconnect",
        "//action:poweroff",
    ] {
        let (blocks, mut link) = printing(false);
        let z = link.sim.position(link.now())[2];
        ask(&mut link, words);
        while !link.events().contains(&Notice::Paused) {
            assert!(link.now() < Duration::from_secs(3600), "{words}: no pause");
            link.run_to(link.now() + Duration::from_millis(100));
        }
        assert!(link.sim.position(link.now())[2] > z + 15.0, "{words}: the head is on the part");
        let told = link.events().iter().any(|e| matches!(e, Notice::Trouble { line, .. } if *line > 10));
        assert!(told, "{words}: {:?}", link.events());
        // The filament has been changed.
        ask(&mut link, "//action:resume");
        assert_eq!(end(&mut link), Outcome::Done, "{words}");
        assert_eq!(of_the_program(executed(&mut link), &blocks), blocks, "{words}: every line once");
    }
}

#[test]
fn a_cancel_that_the_printer_asks_for_leaves_the_part_and_cools() {
    for words in ["//action:cancel", "RequestStop:"] {
        let (blocks, mut link) = printing(false);
        let z = link.sim.position(link.now())[2];
        ask(&mut link, words);
        assert_eq!(end(&mut link), Outcome::Cancelled, "{words}");
        assert!(link.sim.position(link.now())[2] > z + 15.0, "{words}");
        let done = executed(&mut link);
        assert!(
            done.len() < blocks.len() && done.ends_with(&["M104S0", "M140S0", "M107"].map(str::to_owned)),
            "{done:?}"
        );
    }
}

/// Nearly two hours without a word, behind one that says why.
#[test]
fn a_printer_that_has_paused_by_itself_is_waited_for() {
    let (blocks, mut link) = printing(true);
    ask(&mut link, "//action:paused filament_runout 0");
    assert_eq!(end(&mut link), Outcome::Done);
    assert!(link.now() > Duration::from_secs(7000) && notes(&link).contains("filament_runout"), "{:?}", link.now());
    assert_eq!(executed(&mut link), blocks);
    // Once it has gone on a silence is one.
    let (_, mut link) = printing(true);
    ask(&mut link, "//action:paused");
    ask(&mut link, "//action:resumed");
    while !notes(&link).contains("line counter") {
        assert!(link.now() < Duration::from_secs(3000), "{:?}", link.events().last());
        link.run_to(link.now() + Duration::from_secs(10));
    }
}

/// A message of M291 that waits for a person: RepRapFirmware says nothing more until it is answered.
#[test]
fn a_message_that_waits_at_a_duet_is_waited_for() {
    let (blocks, mut link) = printing_on(Protocol::RepRapFirmware, true);
    ask(&mut link, "- Filament -\nLoad the other colour\nSend M292 to continue or M292 P1 to cancel");
    assert_eq!(end(&mut link), Outcome::Done);
    assert!(link.now() > Duration::from_secs(7000) && notes(&link).contains("M292"), "{:?}", link.now());
    assert_eq!(executed(&mut link), blocks);
}

#[test]
fn other_words_are_shown_and_nothing_is_done() {
    let (blocks, mut link) = printing(false);
    ask(&mut link, "//action:prompt_begin Remove the spool");
    ask(&mut link, "//action:dance");
    assert_eq!(end(&mut link), Outcome::Done);
    assert!(notes(&link).contains("Remove the spool") && notes(&link).contains("dance"), "{}", notes(&link));
    assert_eq!(executed(&mut link), blocks);
}
