//! A print of which any call fails: what the printer executes is the file from its first line on, nothing twice, and resuming ends it.

use super::calls::{Fault, faults, harmed, unharmed};
use crate::link::{executed, gcode, profile, simulate, wanted};
use crate::support::{folder, installed, note, skip};

const SEND: [&str; 10] =
    ["send", "part.gcode", "--unverified", "-m", "machine.toml", "--port", "tty", "--json", "--wait", "5"];

#[test]
fn no_fault_of_a_print_loses_or_doubles_a_line() {
    if !installed("strace") {
        return skip("no strace to make calls fail with");
    }
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let machine = profile(folder.path());
    let wanted = wanted(&gcode(folder.path(), 30));
    std::fs::create_dir(at("tmp")).unwrap();
    let printer = || {
        for name in ["part.gcode.journal", "part.gcode.journal.stale", "sim.log"] {
            let _ = std::fs::remove_file(at(name));
        }
        simulate(&at("tty"), &machine, &["--speed", "max", "--log", at("sim.log").to_str().unwrap()])
    };
    let printed = || if at("sim.log").exists() { executed(&at("sim.log")) } else { Vec::new() };
    let first = printer();
    let injected = faults(folder.path(), &SEND, 0, 9);
    assert_eq!(printed(), wanted);
    drop(first);
    let (mut refused, mut killed) = (0, 0);
    for one in &injected {
        let _printer = printer();
        let done = harmed(folder.path(), &SEND, one);
        let what = format!("{one:?}: {done:?}");
        let so_far = printed();
        assert!(wanted.starts_with(&so_far), "{what}");
        match (one.fault, done.code) {
            // Also where the call did not come again: how often a printer is asked depends on time.
            (_, Some(0)) => assert_eq!(so_far, wanted, "{what}"),
            (Fault::Error(_), Some(2 | 4)) => {
                assert!(done.says_why(), "{what}");
                refused += 1;
            }
            (Fault::Kill, None) => killed += 1,
            _ => panic!("{what}"),
        }
        // Whoever finds a printer that has not begun begins, whoever finds one that has resumes: both go by the journal.
        let resume = [&SEND[..], &["--resume", "--yes"]].concat();
        let next = unharmed(folder.path(), if so_far.is_empty() { &SEND } else { &resume });
        let ended = next.documents().pop().unwrap_or_default();
        assert!(next.code == Some(0) || ended["code"] == "job/ended" && so_far == wanted, "{what}, next {next:?}");
        assert_eq!(printed(), wanted, "{what}, next {next:?}");
        let mut names: Vec<String> = std::fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        // The journal of a print that had begun and of which the printer has nothing.
        names.retain(|name| name != "part.gcode.journal.stale" || !so_far.is_empty());
        names.sort();
        let known = ["machine.toml", "part.gcode", "part.gcode.journal", "sim.log", "tmp", "trace", "tty"];
        assert_eq!(names, known, "{what}");
        assert_eq!(std::fs::read_dir(at("tmp")).unwrap().count(), 0, "{what}");
    }
    note(&format!("send: {} faults, {refused} refused, {killed} kills", injected.len()));
    assert!(refused > 2 && killed > 2, "{refused} {killed}");
}
