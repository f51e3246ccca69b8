//! What a person sees while a printer prints: a terminal's lines as they stand, at the start, while it heats, in the middle, in a
//! pause, at the end, and where the printer fails. Numbers that depend on the moment are `#`.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::process::Stdio;
use std::sync::{Arc, Mutex};

use super::real::{Running, executed, gcode, interrupt, killed, profile, send, simulate, wait_for};
use super::terminal::{Terminal, ended_with, opened, says, shows};
use crate::support::{Command, folder, trunnion};

/// A host at a terminal of 80 columns: its process, its keys, its screen.
fn at_a_terminal(gcode: &Path, machine: &Path, link: &Path) -> (Running, File, Arc<Mutex<Terminal>>) {
    connected(&mut send(gcode, machine, link), 80)
}

fn connected(host: &mut Command, columns: u16) -> (Running, File, Arc<Mutex<Terminal>>) {
    let (keys, program, screen) = opened(columns, 30);
    let host = host.stdin(program.try_clone().unwrap()).stderr(program).stdout(Stdio::null()).spawn().unwrap();
    (Running(host), keys, screen)
}

/// A simulated printer that takes some seconds for a print and for its heat.
fn slow_printer(link: &Path, machine: &Path, more: &[&str]) -> Running {
    let mut printer = trunnion();
    printer.args(["simulate", "-q", "--heat", "2", "-m"]).arg(machine).arg("--link").arg(link).args(more);
    let printer = Running(printer.stderr(Stdio::null()).spawn().unwrap());
    wait_for("the link", || link.exists());
    printer
}

/// A file whose bed is heated, too.
fn heated(dir: &Path, moves: u32) -> std::path::PathBuf {
    let part = gcode(dir, moves);
    let text = std::fs::read_to_string(&part).unwrap().replacen("M104", "M190 S120\nM104", 1);
    std::fs::write(&part, text).unwrap();
    part
}

/// Waits until the printer of this log has been given a line with filament.
fn prints(log: &Path) {
    wait_for("a line of the print", || executed(log).iter().any(|line| line.contains('E')));
}

#[test]
fn what_a_person_sees_from_the_first_line_to_the_last() {
    let dir = folder();
    let (machine, _, link) = (profile(dir.path()), heated(dir.path(), 1500), dir.path().join("tty"));
    let log = dir.path().join("sim.log");
    let _printer = slow_printer(&link, &machine, &["--speed", "12", "--log", log.to_str().unwrap()]);
    let mut host = send(Path::new("part.gcode"), &machine, &link);
    let (mut host, mut keys, screen) = connected(host.current_dir(dir.path()), 80);
    // Start.
    shows(&screen, "# %, waits for bed heating, bed #/#, # min left, layer # of #, #/# C");
    // Middle.
    shows(&screen, "# %, # min left, layer # of #, #/# C, bed #/#");
    // Pause, once it waits for no heat.
    prints(&log);
    interrupt(&host.0);
    shows(&screen, "paused above the part: Enter (continue), c and Enter (cancel), Ctrl-C (emergency stop)");
    // A status comes in between; the typed line is not left behind with it.
    let before = screen.lock().unwrap().statuses;
    wait_for("two statuses", || screen.lock().unwrap().statuses > before + 1);
    keys.write_all(b"\n").unwrap();
    // End.
    says(&screen, "the print is complete: # lines, # resend requests");
    assert!(host.0.wait().unwrap().success());
    let screen = screen.lock().unwrap();
    let golden = [
        "warning: part.gcode is not verified: the head may hit the part, the table or the frame",
        "printer: bench, Marlin bugfix-#.#.x (Nov # #)",
        "pausing after moves in progress; Ctrl-C again is an emergency stop",
        "paused above the part: Enter (continue), c and Enter (cancel), Ctrl-C (emergency stop)",
        "the print continues",
        "the print is complete: # lines, # resend requests",
    ];
    assert_eq!(screen.whole(), golden);
    assert!(screen.wrapped.iter().all(|line| !line.contains(" min left")), "{:?}", screen.wrapped);
}

#[test]
fn a_narrow_terminal_has_the_beginning_of_a_status_in_one_line() {
    let dir = folder();
    let (machine, part, link) = (profile(dir.path()), heated(dir.path(), 900), dir.path().join("tty"));
    let _printer = slow_printer(&link, &machine, &["--speed", "12"]);
    let (mut host, _keys, screen) = connected(&mut send(&part, &machine, &link), 40);
    shows(&screen, "# %, waits for bed heating, bed #/#");
    shows(&screen, "# %, # min left, layer # of #");
    says(&screen, "the print is complete: # lines, # resend requests");
    assert!(host.0.wait().unwrap().success());
    let screen = screen.lock().unwrap();
    let whole = screen.whole();
    assert!(whole.iter().chain(&screen.wrapped).all(|line| !line.contains(" %,")), "{whole:#?}");
}

/// Two printers at one screen: start, middle, a pause of one and a fault of the other, the end of both.
#[test]
fn what_a_person_sees_of_two_printers_from_the_first_line_to_the_last() {
    for columns in [80, 40] {
        let dir = folder();
        let machine = profile(dir.path());
        let parts = ["one", "two"].map(|name| {
            std::fs::create_dir(dir.path().join(name)).unwrap();
            heated(&dir.path().join(name), 900);
            format!("{name}/part.gcode")
        });
        let at = |name: &str| dir.path().join(name);
        let log = at("two.log");
        let slow = ["--speed", "12", "--log", log.to_str().unwrap()];
        let fails = ["--speed", "12", "--fault", "fatal@800"];
        let _printers = [slow_printer(&at("tty1"), &machine, &fails), slow_printer(&at("tty2"), &machine, &slow)];
        let mut host = trunnion();
        host.current_dir(dir.path()).args(["send", "--unverified", "-m"]).arg(&machine);
        host.args(["--port", "tty1", &parts[0], "--port", "tty2", &parts[1]]);
        let (mut host, mut keys, screen) = connected(&mut host, columns);
        // The two lines at the end stay in their place, and both of them say this at one time.
        let both_say = |wide: &str, narrow: &str| {
            let golden = format!("# tty#: {}", if columns == 80 { wide } else { narrow });
            ended_with(&screen, &[golden.clone(), golden]);
        };
        // Start.
        let narrow = "# %, waits for bed heating";
        both_say("# %, waits for bed heating, bed #/#, # min left, layer # of #", narrow);
        // Middle.
        both_say("# %, # min left, layer # of #, #/# C, bed #/#", "# %, # min left, layer # of #");
        // What was typed wrongly is told above, and moves nothing; one is asked to pause while the other goes on.
        keys.write_all(b"p 7\n").unwrap();
        let wrong = "unknown command \"p #\"; use N (continue), Enter (continue all), p N (pause), c N (cancel a paused print), s N \
                     (emergency stop), N from # to #";
        says(&screen, wrong);
        prints(&log);
        keys.write_all(b"p 2\n").unwrap();
        let paused = "# tty#: paused above the part: # (continue), c # (cancel), s # (emergency stop); all prints: Enter (continue), Ctrl-C \
                      twice (emergency stop)";
        says(&screen, paused);
        // The other one fails meanwhile, which is told at once.
        let fault = "the printer has stopped: Thermal Runaway, system stopped! Heater_ID: #; remove the cause, then reset the printer";
        says(&screen, &format!("# tty#: warning: {fault}"));
        keys.write_all(b"2\n").unwrap();
        // End.
        assert_eq!(host.0.wait().unwrap().code(), Some(4));
        let error = format!("error[send/prints]: # of # prints failed; tty#: one/part.gcode: {fault}");
        says(&screen, &error);
        let mut found = screen.lock().unwrap().sentences();
        let last = found.split_off(found.len() - 3);
        assert_eq!(last, ["# tty#: stopped", "# tty#: complete", &error]);
        found.sort();
        let mut golden = [
            "warning: one/part.gcode is not verified: the head may hit the part, the table or the frame",
            "warning: two/part.gcode is not verified: the head may hit the part, the table or the frame",
            "# tty#: printer: bench, Marlin bugfix-#.#.x (Nov # #)",
            "# tty#: printer: bench, Marlin bugfix-#.#.x (Nov # #)",
            wrong,
            "# tty#: pausing after moves in progress; emergency stop: s # (this print), Ctrl-C twice (all prints)",
            paused,
            &format!("# tty#: warning: {fault}"),
            "# tty#: the print continues",
            "# tty#: the print is complete: # lines, # resend requests",
        ];
        golden.sort_unstable();
        assert_eq!(found, golden, "{columns} columns");
        // No line of the screen was broken by the terminal but those of the beginning and the end, which stand alone.
        let alone = |line: &String| {
            line.starts_with("warning: ")
                || line.starts_with("error[")
                || line.starts_with("; tty")
                || !line.contains("tty")
        };
        assert!(screen.lock().unwrap().wrapped.iter().all(alone), "{:?}", screen.lock().unwrap().wrapped);
    }
}

/// Ctrl-C once pauses both, one of which was paused alone before; twice stops both.
#[test]
fn ctrl_c_pauses_all_that_are_not_paused_and_stops_none() {
    let dir = folder();
    let machine = profile(dir.path());
    let parts = ["one", "two"].map(|name| {
        std::fs::create_dir(dir.path().join(name)).unwrap();
        gcode(&dir.path().join(name), 4000)
    });
    let [links, logs] = [["tty1", "tty2"], ["1.log", "2.log"]].map(|names| names.map(|name| dir.path().join(name)));
    let start = |i: usize| simulate(&links[i], &machine, &["--speed", "20", "--log", logs[i].to_str().unwrap()]);
    let _printers = [start(0), start(1)];
    let mut host = trunnion();
    host.args(["send", "--unverified", "-m"]).arg(&machine);
    for i in 0..2 {
        host.arg("--port").arg(&links[i]).arg(&parts[i]);
    }
    let (mut host, mut keys, screen) = connected(&mut host, 200);
    let moves = |i: usize| std::fs::read_to_string(&logs[i]).unwrap_or_default().matches(" line G1X").count();
    wait_for("both prints", || moves(0) > 20 && moves(1) > 20);
    let pauses = || screen.lock().unwrap().sentences().iter().filter(|line| line.contains(": paused above ")).count();
    keys.write_all(b"p 1\n").unwrap();
    wait_for("the first pause", || pauses() == 1);
    interrupt(&host.0);
    wait_for("both pauses", || pauses() == 2);
    assert!(
        logs.iter().all(|log| !killed(log)),
        "a print that was paused was stopped by the Ctrl-C that paused the other"
    );
    interrupt(&host.0);
    wait_for("both emergency stops", || logs.iter().all(|log| killed(log)));
    assert_eq!(host.0.wait().unwrap().code(), Some(4));
}

#[test]
fn a_pause_in_front_of_heat_says_that_it_waits_for_it() {
    let dir = folder();
    let (machine, part, link) = (profile(dir.path()), dir.path().join("hot.gcode"), dir.path().join("tty"));
    std::fs::write(&part, "G28\nM190 S60\nG1 X5 F600\nG1 X9\n").unwrap();
    let mut printer = trunnion();
    printer.args(["simulate", "-q", "--speed", "10", "-m"]).arg(&machine).arg("--link").arg(&link);
    let _printer = Running(printer.stderr(Stdio::null()).spawn().unwrap());
    wait_for("the link", || link.exists());
    let (host, _keys, screen) = at_a_terminal(&part, &machine, &link);
    shows(&screen, "# %, waits for bed heating, bed #/#, # min left, line # of #, #/# C");
    interrupt(&host.0);
    shows(&screen, "pausing after the printer has finished waiting for bed heating; Ctrl-C again is an emergency stop");
}

#[test]
fn a_printer_that_fails_is_quoted_in_one_sentence() {
    let dir = folder();
    let (machine, part, link) = (profile(dir.path()), gcode(dir.path(), 600), dir.path().join("tty"));
    let _printer = simulate(&link, &machine, &["--speed", "max", "--fault", "fatal@300"]);
    let (mut host, _keys, screen) = at_a_terminal(&part, &machine, &link);
    shows(
        &screen,
        "error[job/printer]: the printer has stopped: Thermal Runaway, system stopped! Heater_ID: #; remove the cause, then reset the printer",
    );
    assert_eq!(host.0.wait().unwrap().code(), Some(4));
}
