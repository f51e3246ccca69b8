//! What real firmwares say, word for word (`fixtures/wire`), played against the sender and against the simulated printer.
//!
//! The window is one line here, so that a transcript has one order.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use trunnion::link::sim::{Quirks, Script, Sim};
use trunnion::link::{Notice, Outcome, Program, Protocol, Sender};

use super::bench_machine::{model, program, settings};
use crate::support::root;

enum Act {
    Host(String),
    Arrives(String),
    Printer(String),
    Wait(f64),
}

struct Transcript {
    name: String,
    protocol: Protocol,
    quirks: Quirks,
    program: Arc<Program>,
    acts: Vec<Act>,
    outcome: String,
}

/// A firmware's name, and how it differs.
type NamedQuirk = (&'static str, fn(&mut Quirks));

fn transcripts() -> Vec<Transcript> {
    let folder = root().join("fixtures/wire");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "txt"));
    paths.sort();
    assert!(paths.len() >= 39, "{} transcripts", paths.len());
    paths
        .iter()
        .map(|path| read(path.file_stem().unwrap().to_str().unwrap(), &std::fs::read_to_string(path).unwrap()))
        .collect()
}

fn read(name: &str, text: &str) -> Transcript {
    let (mut protocol, mut blocks, mut acts, mut outcome) =
        (Protocol::Marlin, String::new(), Vec::new(), String::new());
    let mut quirks = Vec::new();
    for line in text.lines().filter(|l| !l.starts_with('#')) {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match word {
            "protocol" => protocol = Protocol::named(rest).unwrap(),
            "quirk" => quirks.push(rest),
            "program" => blocks += &format!("{rest}\n"),
            "->" => acts.push(Act::Host(rest.to_owned())),
            "~>" => acts.push(Act::Arrives(rest.to_owned())),
            "<-" => acts.push(Act::Printer(rest.to_owned())),
            "wait" => acts.push(Act::Wait(rest.parse().unwrap())),
            "outcome" => outcome = rest.to_owned(),
            other => panic!("{name}: {other:?} is no word of a transcript"),
        }
    }
    let has = |name: &str| quirks.contains(&name);
    let mut quirks_of_kind = Quirks {
        advanced_ok: has("advanced-ok"),
        repetier_errors: has("repetier-errors"),
        sprinter_errors: has("sprinter-errors"),
        smoothie_resends: has("smoothie-resends"),
        blank_behind_slash: has("blank-behind-slash"),
        ..Quirks::of(protocol)
    };
    let named: [NamedQuirk; 5] = [
        ("marlin-1.0", Quirks::marlin_1_0),
        ("marlin-1.1", Quirks::marlin_1_1),
        ("prusa", Quirks::prusa),
        ("rrf-2", Quirks::rrf_2),
        ("fluidnc", Quirks::fluidnc),
    ];
    named.iter().filter(|(name, _)| has(name)).for_each(|(_, apply)| apply(&mut quirks_of_kind));
    let quirks = quirks_of_kind;
    Transcript { name: name.to_owned(), protocol, quirks, program: program(protocol, &blocks), acts, outcome }
}

/// `..` in `pattern` stands for any text.
fn fits(pattern: &str, text: &str) -> bool {
    let mut rest = text;
    for (index, piece) in pattern.split("..").enumerate() {
        let Some(at) = rest.find(piece) else { return false };
        if index == 0 && at > 0 {
            return false;
        }
        rest = &rest[at + piece.len()..];
    }
    pattern.ends_with("..") || rest.is_empty()
}

/// A numbered line without its padding and its checksum, which is checked here.
fn plain(line: &str) -> String {
    let Some((body, sum)) = line.split_once('*') else { return line.to_owned() };
    assert_eq!(sum.parse::<u8>().unwrap(), body.bytes().fold(0, |all, byte| all ^ byte), "{line}");
    let digits = body[1..].chars().take_while(char::is_ascii_digit).count();
    format!("N{}{}", body[1..=digits].parse::<u32>().unwrap(), body[digits + 1..].trim_start())
}

/// The next line that the sender puts on the wire; a leading blank line wakes the printer's parser and says nothing.
fn next_line(sender: &mut Sender, now: &mut Duration, patience: f64, heard: &mut Vec<Notice>) -> Option<String> {
    let until = *now + Duration::from_secs_f64(patience);
    loop {
        sender.poll(*now);
        while let Some(notice) = sender.next_event() {
            heard.push(notice);
        }
        while sender.pending().first() == Some(&b'\n') {
            sender.took(1);
        }
        let pending = sender.pending();
        if pending.first() == Some(&b'?') {
            sender.took(1);
            return Some("?".to_owned());
        }
        if let Some(end) = pending.iter().position(|b| *b == b'\n') {
            let line = String::from_utf8_lossy(&pending[..end]).into_owned();
            sender.took(end + 1);
            return Some(line);
        }
        if *now >= until {
            return None;
        }
        *now += Duration::from_millis(50);
    }
}

#[test]
fn the_sender_says_what_the_transcripts_say() {
    for t in transcripts() {
        let mut settings = settings(t.protocol);
        settings.window_lines = 1;
        let mut sender = Sender::new(Arc::clone(&t.program), settings);
        let (mut now, mut heard) = (Duration::ZERO, Vec::new());
        for act in &t.acts {
            match act {
                Act::Host(wanted) => {
                    let line = next_line(&mut sender, &mut now, 1.0, &mut heard);
                    let line = line.as_deref().map(plain);
                    assert_eq!(line, Some(plain(wanted)), "{}: {:?}", t.name, sender.outcome());
                }
                Act::Printer(text) => sender.receive(now, (text.replace("..", "0.0") + "\n").as_bytes()),
                Act::Wait(seconds) => now += Duration::from_secs_f64(*seconds),
                Act::Arrives(_) => {}
            }
        }
        let _ = next_line(&mut sender, &mut now, 2.0, &mut heard);
        match (t.outcome.split_once(' ').unwrap_or((&t.outcome, "")), sender.outcome()) {
            (("done", _), Some(Outcome::Done)) => {}
            // What it was told of the line, and that the head is off the part.
            (("paused", why), None)
                if heard.contains(&Notice::Paused)
                    && heard.iter().any(|n| matches!(n, Notice::Trouble { text, .. } if text.contains(why))) => {}
            (("stopped", why), Some(Outcome::Stopped(stop))) if stop.to_string().contains(why) => {}
            (wanted, found) => panic!("{}: ended with {found:?}, not {wanted:?}", t.name),
        }
    }
}

#[test]
fn the_simulated_printer_says_what_the_transcripts_say() {
    for t in transcripts() {
        let mut sim = Sim::new(t.protocol, model(), t.quirks.clone(), Script::none());
        sim.took(usize::MAX);
        let mut now = Duration::from_secs(1);
        let mut said: Vec<String> = Vec::new();
        for (index, act) in t.acts.iter().enumerate() {
            let heard = match (act, t.acts.get(index + 1)) {
                (Act::Host(_), Some(Act::Arrives(_))) => continue,
                (Act::Host(text) | Act::Arrives(text), _) => text,
                (Act::Printer(pattern), _) => {
                    assert!(!said.is_empty(), "{}: {pattern:?} did not come", t.name);
                    let line = said.remove(0);
                    assert!(fits(pattern, &line), "{}: {line:?} is not {pattern:?}", t.name);
                    continue;
                }
                (Act::Wait(seconds), _) => {
                    assert!(said.is_empty(), "{}: more was said: {said:?}", t.name);
                    now += Duration::from_secs_f64(*seconds);
                    sim.advance(now);
                    said.extend(String::from_utf8_lossy(sim.pending()).lines().map(str::to_owned));
                    sim.took(usize::MAX);
                    continue;
                }
            };
            assert!(said.is_empty(), "{}: more was said: {said:?}", t.name);
            let end = if heard == "?" || heard.is_empty() { "" } else { "\n" };
            sim.receive(now, format!("{heard}{end}").as_bytes());
            now += Duration::from_millis(200);
            sim.advance(now);
            said.extend(String::from_utf8_lossy(sim.pending()).lines().map(str::to_owned));
            sim.took(usize::MAX);
        }
        assert!(said.is_empty() || t.outcome.starts_with("stopped"), "{}: more was said: {said:?}", t.name);
    }
}
