//! The same with the two commands: hosts killed, printers reset twice.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use crate::link::real::{Running, executed, gcode, output, profile, send, simulate, wait_for, wanted};
use crate::support::{fails, folder, said, trunnion};

/// A print interrupted by a reset, and its first printer gone.
fn broken_off(dir: &Path) -> (PathBuf, PathBuf, PathBuf) {
    let (machine, file, link) = (profile(dir), gcode(dir, 600), dir.join("tty"));
    let _printer = simulate(&link, &machine, &["--speed", "max", "--fault", "reset@300"]);
    let stopped = output(&mut send(&file, &machine, &link));
    assert!(stopped.status.code() == Some(4) && said(&stopped).contains("was reset"), "{}", said(&stopped));
    (machine, file, link)
}

/// What was executed from the last homing on.
fn from_homing(log: &Path) -> Vec<String> {
    let mut all = executed(log);
    let home = all.iter().rposition(|l| l == "G28").expect("homed");
    all.split_off(home)
}

/// The whole re-entry, then the file from a layer to its end.
#[track_caller]
fn assert_whole_reentry(file: &Path, log: &Path) {
    let (all, done) = (wanted(file), from_homing(log));
    let way: Vec<&str> = ["G28", "G90", "G1Z320F", "M109S200", "G90", "G1C0F", "G1A0F", "G1X", "G1Z"].to_vec();
    for (line, want) in done.iter().zip(&way) {
        assert!(line.starts_with(want), "{want}: {:?}", &done[..20.min(done.len())]);
    }
    let tail = done.iter().rev().zip(all.iter().rev()).take_while(|(d, w)| d == w).count();
    assert!((300..400).contains(&tail) && done.len() - tail < 30, "{tail} of {}", all.len());
}

#[test]
fn a_re_entry_whose_printer_never_answered_is_repeated_and_the_print_is_not_begun_anew() {
    let dir = folder();
    let (machine, file, link) = broken_off(dir.path());
    // A printer that says once that it counts from 0, and then nothing more.
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp:{}", listener.local_addr().unwrap());
    let mute = std::thread::spawn(move || {
        let (mut wire, _) = listener.accept().unwrap();
        for line in BufReader::new(wire.try_clone().unwrap()).lines().map_while(Result::ok) {
            if line.contains("M105") {
                let words = b"Error:Line Number is not Last Line Number+1, Last Line: 0\nResend: 1\nok\n";
                let _ = wire.write_all(words);
            }
        }
        let (wire, _) = listener.accept().unwrap();
        let mut lines = BufReader::new(wire).lines().map_while(Result::ok);
        assert!(lines.any(|l| l.contains("M110")));
        lines
    });
    let mut host = send(&file, &machine, Path::new(&port));
    let host = host.args(["--resume", "--yes"]).stdin(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let host = Running(host);
    let _open = mute.join().unwrap();
    drop(host);
    let log = dir.path().join("2.log");
    let _printer = simulate(&link, &machine, &["--speed", "max", "--log", log.to_str().unwrap()]);
    let done = output(send(&file, &machine, &link).args(["--resume", "--yes"]));
    assert!(done.status.success(), "{}", said(&done));
    assert!(!executed(&log).contains(&"G21".to_owned()), "the print began anew on the part: {}", said(&done));
    assert_whole_reentry(&file, &log);
}

/// The journal of a print in its middle, cut behind its header, as after a loss of power: nothing of the file is printed again.
#[test]
fn a_journal_of_which_only_the_header_is_left_asks_the_printer_first() {
    let dir = folder();
    let (machine, file, link) = (profile(dir.path()), gcode(dir.path(), 1200), dir.path().join("tty"));
    let (log, journal) = (dir.path().join("sim.log"), dir.path().join("part.gcode.journal"));
    let _printer = simulate(&link, &machine, &["--speed", "20", "--log", log.to_str().unwrap()]);
    let mut host = send(&file, &machine, &link);
    let host = Running(host.stdin(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
    wait_for("the print", || executed(&log).len() > 100);
    drop(host);
    let text = std::fs::read_to_string(&journal).unwrap();
    let header = text.find("run ").unwrap();
    std::fs::write(&journal, &text[..header]).unwrap();
    let stopped = output(send(&file, &machine, &link).args(["--resume", "--yes"]));
    let words = said(&stopped);
    assert!(
        stopped.status.code() == Some(4) && fails(&words, "job/printer: journal | trunnion send without --resume"),
        "{words}"
    );
    // Not one line more than what the first host has sent.
    let (all, done) = (wanted(&file), executed(&log));
    let own = |l: &&String| l.as_str() != "M104S0" && l.as_str() != "M140S0";
    let done: Vec<String> = done.iter().filter(own).cloned().collect();
    assert!(all.starts_with(&done), "{:?}", all.iter().zip(&done).find(|(w, d)| w != d));
    // Where it has taken none, the print begins.
    let second = dir.path().join("2.log");
    drop(_printer);
    let _printer = simulate(&link, &machine, &["--speed", "max", "--log", second.to_str().unwrap()]);
    let done = output(send(&file, &machine, &link).args(["--resume", "--yes"]));
    assert!(done.status.success(), "{}", said(&done));
    assert_eq!(executed(&second), all);
}

#[test]
fn a_host_killed_while_the_re_entry_heats_repeats_all_of_it() {
    let dir = folder();
    let (machine, file, link) = broken_off(dir.path());
    let log = dir.path().join("2.log");
    // Heats for about ten seconds.
    let mut printer = trunnion();
    printer.args(["simulate", "-q", "--speed", "20", "-m"]).arg(&machine).arg("--link").arg(&link);
    let _printer = Running(printer.arg("--log").arg(&log).stderr(Stdio::null()).spawn().unwrap());
    wait_for("the link", || link.exists());
    let mut host = send(&file, &machine, &link);
    let host = host.args(["--resume", "--yes"]).stdin(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let host = Running(host);
    let moves = || executed(&log).into_iter().filter(|l| l.starts_with("G1") || l == "G28").collect::<Vec<_>>();
    // The last before it heats, behind which nothing is queued.
    wait_for("the way up", || moves().iter().any(|l| l.starts_with("G1Z320")));
    drop(host);
    let first = moves();
    assert!(first.contains(&"G28".to_owned()) && !first.iter().any(|l| l.starts_with("G1A0")), "{first:?}");
    let asked = output(send(&file, &machine, &link).arg("--resume"));
    assert!(asked.status.code() == Some(4) && fails(&said(&asked), "job/refused: --yes"), "{}", said(&asked));
    assert_eq!(moves(), first, "nothing moves before somebody has agreed");
    let done = output(send(&file, &machine, &link).args(["--resume", "--yes"]));
    assert!(done.status.success(), "{}", said(&done));
    assert_eq!(executed(&log).iter().filter(|l| *l == "G28").count(), 2, "homed again");
    assert_whole_reentry(&file, &log);
}

#[test]
fn a_reset_during_the_re_entry_leads_to_the_same_place_and_one_behind_it_never_back() {
    // Lines of the second printer: two questions, three first words, the re-entry to about the 22nd.
    for fault in ["reset@12", "reset@60"] {
        let dir = folder();
        let (machine, file, link) = broken_off(dir.path());
        let log = dir.path().join("2.log");
        let _printer = simulate(&link, &machine, &["--speed", "max", "--fault", fault, "--log", log.to_str().unwrap()]);
        let resume = || output(send(&file, &machine, &link).args(["--resume", "--yes"]));
        let place =
            |text: String| -> Option<u32> { text.split("continue at line ").nth(1)?.split(',').next()?.parse().ok() };
        let again = resume();
        assert!(again.status.code() == Some(4) && said(&again).contains("was reset"), "{fault}: {}", said(&again));
        let done = resume();
        assert!(done.status.success(), "{fault}: {}", said(&done));
        let (first, second) = (place(said(&again)).unwrap(), place(said(&done)).unwrap());
        assert!(second == first || (fault == "reset@60" && second > first), "{fault}: {second} after {first}");
        assert!(!executed(&log).contains(&"G21".to_owned()), "{fault}: the print began anew on the part");
        assert_whole_reentry(&file, &log);
    }
}
