//! Answers that no printer gives, in any order, and hands that pause, cancel and pull plugs at any time: the sender never panics,
//! never holds more than a window and some questions for the port, and always ends in a state with a name.

use std::sync::Arc;
use std::time::Duration;

use trunnion::link::{Header, JournalSummary, Notice, Program, Protocol, Record, Sender, SenderSettings};

use super::bench_machine::{program, settings, text};
use crate::support::{Numbers, seeds};

/// Something like an answer of some firmware; numbers near those that are under way, and far from them.
fn answer(numbers: &mut Numbers, last: i64) -> String {
    let near = last + numbers.between(-6.0, 3.0) as i64;
    let far = [0, -1, 1, i64::MAX, i64::MIN, 4_000_000_000][numbers.between(0.0, 5.99) as usize];
    let number = if numbers.between(0.0, 1.0) < 0.8 { near } else { far };
    let texts = [
        "ok".to_owned(),
        "ok".to_owned(),
        "ok".to_owned(),
        "ok T:20.0 /0.0 B:20.0 /0.0".to_owned(),
        "ok T:21.30/ 0.00".to_owned(),
        format!("ok N{number} P{} B{}", numbers.between(0.0, 16.0) as u32, numbers.between(0.0, 40.0) as u32),
        format!("Resend: {number}"),
        "Resend: x".to_owned(),
        format!("Error:checksum mismatch, Last Line: {number}\nResend: {}\nok", number.saturating_add(1)),
        format!(
            "Error:Line Number is not Last Line Number+1, Last Line: {number}\nResend: {}\nok",
            number.saturating_add(1)
        ),
        format!("Error:expected line {number} got 7\nResend:{number}\nok"),
        format!("Error:Last Line: {number}"),
        "echo:busy: processing".to_owned(),
        "echo:busy: paused for user".to_owned(),
        "X:1.00 Y:2.00 Z:3.00 A:0.00 C:0.00 E:0.00 Count X:1".to_owned(),
        "Cap:EMERGENCY_PARSER:1".to_owned(),
        "echo:Unknown command: \"G1X1\"".to_owned(),
        "echo: cold extrusion prevented".to_owned(),
        " T:20.0 /200.0 B:20.0 /60.0 W:?".to_owned(),
        "<Idle|MPos:0,0,0|Bf:15,128>".to_owned(),
        "<Run|MPos:0,0,0|Bf:3,20>".to_owned(),
        "[OPT:V,15,128]".to_owned(),
        "\u{fffd}o\0k".to_owned(),
    ];
    texts[numbers.between(0.0, texts.len() as f64 - 0.01) as usize].clone()
}

/// What ends most prints at once, so that it comes seldom.
const RARE: [&str; 9] = [
    "start",
    "Error:Probing Failed",
    "Error:Thermal Runaway",
    "!! gone",
    "error:20",
    "ALARM:1",
    "Grbl 1.1h ['$' for help]",
    "FIRMWARE_NAME:Marlin AXIS_COUNT:5",
    "ok FIRMWARE_NAME:Klipper",
];

/// What an interrupted print may have left in its journal.
fn left_off(numbers: &mut Numbers, of: u32) -> JournalSummary {
    let answered = numbers.between(0.0, f64::from(of)) as u32;
    let paused = numbers.between(0.0, 1.0) < 0.3;
    let pause = if paused { format!("away\npaused {answered}\n") } else { String::new() };
    let records = format!("run 1 0\nack {answered} {answered}\nsent {}\n{pause}", (answered + 4).min(of));
    JournalSummary::parse(&(Header::default().to_text() + &records)).unwrap()
}

/// A print from its beginning, one that is resumed from the printer's counter or from where it stands, or a re-entry.
fn begun(seed: u64, numbers: &mut Numbers, program: &Arc<Program>, few: SenderSettings) -> Sender {
    let left = left_off(numbers, program.len());
    match seed % 4 {
        1 => Sender::resuming(Arc::clone(program), few, &left),
        2 => match left.stands_at(program, &few, true) {
            Some(places) => Sender::locating(Arc::clone(program), few, places, left.paused.is_some()),
            None => Sender::new(Arc::clone(program), few),
        },
        3 => {
            let prologue = ["G90", "G1Z50F600", "G1X0Y0F3000"].map(str::to_owned);
            Sender::reentering(Arc::clone(program), few, &prologue, numbers.between(0.0, 380.0) as u32)
        }
        _ => Sender::new(Arc::clone(program), few),
    }
}

/// Bytes that are nobody's words, some of them cut off in the middle, or a line without an end.
fn noise(numbers: &mut Numbers) -> Vec<u8> {
    let length = if numbers.between(0.0, 1.0) < 0.05 { 5000.0 } else { 40.0 };
    let count = numbers.between(1.0, length) as usize;
    (0..count).map(|_| numbers.between(0.0, 255.99) as u8).collect()
}

#[test]
fn whatever_is_answered_the_sender_ends_in_a_state_with_a_name() {
    let (mut ends, mut renumbered, mut prints) = (std::collections::BTreeMap::new(), 0, 0);
    for protocol in [Protocol::Marlin, Protocol::RepRapFirmware, Protocol::Klipper, Protocol::Grbl] {
        let program = program(protocol, &text(protocol, 400));
        for seed in seeds(1_500, 100_000) {
            prints += 1;
            let mut numbers = Numbers::seeded(seed);
            let reads = Duration::from_millis(seed % 3 * 2);
            let few = SenderSettings { renumber_at: 60, baud: 250_000, reads, ..settings(protocol) };
            let mut sender = begun(seed, &mut numbers, &program, few);
            let mut now = Duration::ZERO;
            // What is resumed begins with the link that is back.
            let mut offline = sender.wake(now).is_none();
            for step in 0..4000 {
                if sender.outcome().is_some() {
                    break;
                }
                sender.poll(now);
                while let Some(notice) = sender.next_event() {
                    renumbered += u32::from(notice == Notice::Journal(Record::Anew));
                }
                assert!(
                    sender.pending().len() < 16_384,
                    "{protocol:?}, seed {seed}, step {step}: {}",
                    sender.pending().len()
                );
                let taken = if numbers.between(0.0, 1.0) < 0.8 { usize::MAX / 2 } else { 5 };
                sender.took(taken);
                now += Duration::from_secs_f64(numbers.between(0.0, 1.0).powi(4) * 8.0);
                // A printer that answers sensibly most of the time gets further.
                let chance = numbers.between(0.0, 1.0);
                if offline {
                    offline = false;
                    sender.reconnected(now);
                } else if chance < 0.55 {
                    sender.receive(now, b"ok\n");
                } else if chance < 0.6 {
                    sender.receive(now, b"ok T:20.0 /0.0 B:20.0 /0.0\n");
                } else if chance < 0.605 {
                    sender.receive(now, &noise(&mut numbers));
                } else if chance < 0.97 {
                    let text = answer(&mut numbers, sender.progress().last);
                    sender.receive(now, (text + "\n").as_bytes());
                } else if chance < 0.972 {
                    let text = RARE[numbers.between(0.0, 8.99) as usize];
                    sender.receive(now, format!("{text}\n").as_bytes());
                } else {
                    match numbers.between(0.0, 4.0) as u32 {
                        0 => sender.pause(),
                        1 | 2 => sender.resume(),
                        3 if numbers.between(0.0, 1.0) < 0.1 => sender.cancel(),
                        _ if numbers.between(0.0, 1.0) < 0.3 => {
                            sender.lost(now);
                            offline = true;
                        }
                        _ => {}
                    }
                }
            }
            if offline {
                sender.reconnected(now);
            }
            // Now it is silent: whoever is not in a pause gives up.
            let until = now + Duration::from_secs(3 * 3600);
            while sender.outcome().is_none() && now < until {
                sender.resume();
                sender.poll(now);
                sender.took(usize::MAX / 2);
                now += Duration::from_secs(5);
            }
            let name = format!("{:?}", sender.outcome());
            assert!(sender.outcome().is_some(), "{protocol:?}, seed {seed}: no end");
            *ends.entry(name.split(['{', '"']).next().unwrap().trim().to_owned()).or_insert(0) += 1;
        }
    }
    assert!(ends.len() >= 8 && renumbered > 10, "the answers lead to few ends: {ends:?}, {renumbered} times from 1");
    crate::support::note(&format!(
        "{prints} prints with random answers: {ends:?}; {renumbered} times counted from 1 again"
    ));
}
