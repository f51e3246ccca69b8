//! What a person sees while a printer prints: a terminal's lines as they stand, at the start, while it heats, in the middle, in a
//! pause, at the end, and where the printer fails. Numbers that depend on the moment are `#`.

use std::io::{Read, Write};
use std::path::Path;
use std::process::Stdio;
use std::sync::{Arc, Mutex};

use super::real::{Running, gcode, interrupt, profile, send, simulate, terminal, wait_for};
use crate::support::{folder, trunnion};

/// The lines of a terminal: `\r` goes back to the first column, `ESC [ K` clears from there on; no other sequence may come.
#[derive(Default)]
struct Screen {
    lines: Vec<String>,
    now: Vec<char>,
    column: usize,
    /// Every state that the last line had.
    statuses: Vec<String>,
}

impl Screen {
    fn take(&mut self, text: &str) {
        let mut rest = text.chars().peekable();
        while let Some(c) = rest.next() {
            match c {
                '\n' => {
                    let line: String = std::mem::take(&mut self.now).into_iter().collect();
                    self.lines.push(line.trim_end().to_owned());
                    self.column = 0;
                }
                '\r' => {
                    self.statuses.push(self.now.iter().collect::<String>().trim_end().to_owned());
                    self.column = 0;
                }
                '\x1b' => {
                    assert_eq!((rest.next(), rest.next()), (Some('['), Some('K')), "a sequence that is none of ours");
                    self.now.truncate(self.column);
                }
                c => {
                    assert!(!c.is_control(), "{c:?} on the screen");
                    if self.column < self.now.len() {
                        self.now[self.column] = c
                    } else {
                        self.now.push(c)
                    }
                    self.column += 1;
                }
            }
        }
    }

    fn shows(&self, golden: &str) -> bool {
        self.lines.iter().chain(&self.statuses).any(|l| plain(l) == golden)
    }
}

/// Numbers as `#`.
fn plain(line: &str) -> String {
    let mut out = String::new();
    for c in line.chars() {
        match c {
            '0'..='9' if out.ends_with('#') => {}
            '0'..='9' => out.push('#'),
            c => out.push(c),
        }
    }
    out
}

/// A host at a terminal: its process, its keys, its screen.
fn at_a_terminal(gcode: &Path, machine: &Path, link: &Path) -> (Running, std::fs::File, Arc<Mutex<Screen>>) {
    let (keys, slave) = terminal();
    let mut host = send(gcode, machine, link);
    let host = host.stdin(slave.try_clone().unwrap()).stderr(slave).stdout(Stdio::null()).spawn().unwrap();
    let screen = Arc::new(Mutex::new(Screen::default()));
    let (mut reader, shown) = (keys.try_clone().unwrap(), Arc::clone(&screen));
    std::thread::spawn(move || {
        let mut bytes = [0; 4096];
        while let Ok(n) = reader.read(&mut bytes)
            && n > 0
        {
            shown.lock().unwrap().take(&String::from_utf8_lossy(&bytes[..n]));
        }
    });
    (Running(host), keys, screen)
}

#[track_caller]
fn shows(screen: &Mutex<Screen>, golden: &str) {
    wait_for(golden, || {
        let screen = screen.lock().unwrap();
        screen.shows(golden)
    });
}

#[test]
fn what_a_person_sees_from_the_first_line_to_the_last() {
    let dir = folder();
    let (machine, part) = (profile(dir.path()), gcode(dir.path(), 1500));
    // Its bed is heated, too.
    let text = std::fs::read_to_string(&part).unwrap().replacen("M104", "M190 S60\nM104", 1);
    std::fs::write(&part, text).unwrap();
    let link = dir.path().join("tty");
    let mut printer = trunnion();
    printer.args(["simulate", "-q", "--speed", "12", "--heat", "2", "-m"]).arg(&machine).arg("--link").arg(&link);
    let _printer = Running(printer.stderr(Stdio::null()).spawn().unwrap());
    wait_for("the link", || link.exists());
    let (mut host, mut keys, screen) = at_a_terminal(&part, &machine, &link);
    // Start.
    shows(&screen, "warning: the file is not verified: the head may hit the part, the table or the frame");
    shows(&screen, "# %, layer # of #, # min left, waits for the bed's heat, #/# C, bed #/#");
    // Middle.
    shows(&screen, "# %, layer # of #, # min left, #/# C, bed #/#");
    // Pause.
    interrupt(&host.0);
    shows(&screen, "pausing after the moves under way; Ctrl-C again is an emergency stop");
    shows(&screen, "paused above the part: Enter continues, c and Enter cancels, Ctrl-C is an emergency stop");
    keys.write_all(b"\n").unwrap();
    shows(&screen, "the print goes on");
    // End.
    shows(&screen, "the print is complete: # lines, # of them sent again");
    assert!(host.0.wait().unwrap().success());
    let screen = screen.lock().unwrap();
    let statuses = screen.statuses.iter().filter(|l| l.contains(" min left"));
    let longest = statuses.map(|l| l.chars().count()).max().unwrap();
    assert!(longest < 80, "{longest} columns");
    // Nothing of a status stays behind a line that is shorter.
    assert!(screen.lines.iter().all(|l| !l.contains(" min left")), "{:?}", screen.lines);
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
    shows(&screen, "# %, line # of #, # min left, waits for the bed's heat, #/# C, bed #/#");
    interrupt(&host.0);
    shows(&screen, "pausing after the bed's heat, which the printer waits for; Ctrl-C again is an emergency stop");
}

#[test]
fn a_printer_that_fails_is_quoted_in_one_sentence() {
    let dir = folder();
    let (machine, part, link) = (profile(dir.path()), gcode(dir.path(), 600), dir.path().join("tty"));
    let _printer = simulate(&link, &machine, &["--speed", "max", "--fault", "fatal@300"]);
    let (mut host, _keys, screen) = at_a_terminal(&part, &machine, &link);
    shows(
        &screen,
        "error: the printer has stopped: Thermal Runaway, system stopped! Heater_ID: #; remove the cause, then reset the printer",
    );
    assert_eq!(host.0.wait().unwrap().code(), Some(4));
}
