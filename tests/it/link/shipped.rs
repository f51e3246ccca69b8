//! Every shipped machine from a model to a printed program.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use trunnion::profile::{SHIPPED, resolve};

use super::promised::home;
use super::real::{assert_same, executed, interrupt, listened, output, plain, simulate, terminal, wait_for, wanted};
use crate::pipeline::{fixture, prepare};
use crate::support::{folder, note, root, said, states, trunnion};

/// A part that stands and one that leans on it: the table turns, tilts and goes back.
#[test]
fn each_shipped_machine_prints_a_file_that_verifies() {
    for (name, file, text) in SHIPPED {
        let profile = resolve(file, text).unwrap().0;
        let letters = [profile.kinematics.tilt.letter, profile.kinematics.rotation.letter];
        printed("y-tree", name, &profile.link.protocol, &letters, &[]);
    }
}

/// Four axes: one that tilts to both sides and does not turn, one that turns and does not tilt. No word of the axis that is not there is written.
#[test]
fn machines_of_four_axes_print_a_file_that_verifies() {
    let dir = folder();
    let machine = |name: &str, axes: &str| {
        let file = dir.path().join(format!("{name}.toml"));
        std::fs::write(&file, format!("extends = \"generic-bc\"\n[machine]\nname = \"{name}\"\n{axes}")).unwrap();
        file.display().to_string()
    };
    let tilts = "[kinematics.tilt]\nmin_deg = -90.0\nmax_deg = 90.0\n[kinematics.rotation]\nturns = \"none\"\n";
    printed("y-tree", &machine("tilts", tilts), "marlin", &['B'], &['C']);
    printed("cube", &machine("turns", "[kinematics.tilt]\nturns = \"none\"\n"), "marlin", &['C'], &['B']);
}

/// From a model to what the simulated machine has done, line by line; its axes turn, and those that it does not have are never told to.
fn printed(model: &str, machine: &str, protocol: &str, turns: &[char], never: &[char]) {
    let dir = folder();
    let (out, plan) = (dir.path().join("out.gcode"), dir.path().join("plan.json"));
    prepare(&fixture(model), machine, "builtin", &out, &["--plan-out", plan.to_str().unwrap()]);
    let program = std::fs::read_to_string(&out).unwrap();
    let told = |letter: &char| program.lines().any(|line| line.starts_with(&format!("G1 {letter}")));
    assert!(turns.iter().all(told) && !never.iter().any(told), "{machine}: {turns:?}, never {never:?}");
    if protocol == "none" {
        return;
    }
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let _printer = simulate(&link, Path::new(machine), &["--speed", "max", "--log", log.to_str().unwrap()]);
    if protocol == "grbl" {
        home(&link);
    }
    let done = output(trunnion().arg("send").arg(&out).arg("--plan").arg(&plan).arg("--port").arg(&link));
    assert!(done.status.success(), "{machine}: {}", said(&done));
    // The sender waits for the last move by itself as well.
    let wanted: Vec<String> = wanted(&out).into_iter().filter(|line| line != "M400").collect();
    let executed: Vec<String> = executed(&log).into_iter().filter(|l| l != "$H" && l != "G4P0.01").collect();
    assert_same(&wanted, &executed);
    note(&format!("{machine}: {} lines printed", program.lines().count()));
}

/// A model of two parts, prepared for `name`; the words that tilt its table.
fn prepared(dir: &Path, name: &str) -> (std::path::PathBuf, std::path::PathBuf, Vec<String>) {
    let (out, plan) = (dir.join("out.gcode"), dir.join("plan.json"));
    prepare(&fixture("y-tree"), name, "builtin", &out, &["--plan-out", plan.to_str().unwrap()]);
    let (file, text) = SHIPPED.into_iter().find(|s| s.0 == name).map(|s| (s.1, s.2)).unwrap();
    let tilt = resolve(file, text).unwrap().0.kinematics.tilt.letter;
    let program = std::fs::read_to_string(&out).unwrap();
    let turns =
        program.lines().filter(|l| l.starts_with(&format!("G1 {tilt}")) && !l.starts_with(&format!("G1 {tilt}0 ")));
    (out, plan, turns.map(plain).collect())
}

/// Whether so much was executed behind the first tilt that filament is laid there.
fn is_printing_tilted(lines: &[String], turns: &[String]) -> bool {
    lines.iter().position(|l| turns.contains(l)).is_some_and(|at| lines.len() - at > 40)
}

/// Each with the letter of its filament.
const TILTED: [(&str, char); 6] = [
    ("generic-bc", 'E'),
    ("hendrikjan-5d", 'E'),
    ("penta-trt-bc", 'E'),
    ("grblhal-ac", 'U'),
    ("generic-hh", 'E'),
    ("rep5x-ender-3-v3-se", 'E'),
];

/// A print that is paused while its table is tilted leaves the part upward, goes on where it was, and prints every line once.
#[test]
fn machines_pause_at_a_tilt_and_go_on() {
    std::thread::scope(|all| {
        TILTED
            .map(|(name, filament)| all.spawn(move || paused_at_a_tilt(name, filament)))
            .map(|one| one.join().unwrap())
    });
}

fn paused_at_a_tilt(name: &str, filament: char) {
    let dir = folder();
    let (out, plan, turns) = prepared(dir.path(), name);
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let _printer = simulate(&link, Path::new(name), &["--speed", "600", "--log", log.to_str().unwrap()]);
    if filament == 'U' {
        home(&link);
    }
    let send = |more: &[&str]| {
        let mut send = trunnion();
        send.arg("send").arg(&out).arg("--plan").arg(&plan).arg("--port").arg(&link).args(more);
        send
    };
    let host = send(&[]).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for("the tilt", || is_printing_tilted(&executed(&log), &turns));
    assert!(Command::new("kill").args(["-TERM", &host.id().to_string()]).status().unwrap().success());
    let paused = host.wait_with_output().unwrap();
    assert_eq!(paused.status.code(), Some(4), "{name}: {}", said(&paused));
    let until = executed(&log);
    // Behind the last line of the file come the wait, the pull and the lift; the table stays as it is.
    let lift = lifted(&until).unwrap();
    assert!(
        until.len() - lift < 4 && until[lift - 2].starts_with(&format!("G1{filament}-")),
        "{name}: {:?}",
        &until[lift - 4..]
    );
    let resume = output(&mut send(&["--resume"]));
    assert!(resume.status.success(), "{name}: {}", said(&resume));
    let laid = |l: &&String| l.starts_with("G1") && l.contains('X') && l.contains(filament);
    let wanted: Vec<String> = wanted(&out).into_iter().filter(|l| laid(&l)).collect();
    assert_same(&wanted, &executed(&log).iter().filter(laid).cloned().collect::<Vec<_>>());
}

/// The last move that lays nothing and goes up: along the tool, so with X and Y where it is the head that leans.
fn lifted(lines: &[String]) -> Option<usize> {
    let goes_up =
        |l: &String| (l.starts_with("G1Z") || l.starts_with("G1X")) && l.contains('Z') && !l.contains(['E', 'U']);
    lines.iter().rposition(goes_up)
}

/// Cancelled while its table is tilted, the head leaves the part upward, the heaters go cold, and nothing turns.
#[test]
fn machines_are_cancelled_at_a_tilt() {
    std::thread::scope(|all| {
        TILTED
            .map(|(name, filament)| all.spawn(move || cancelled_at_a_tilt(name, filament)))
            .map(|one| one.join().unwrap())
    });
}

fn cancelled_at_a_tilt(name: &str, filament: char) {
    let dir = folder();
    let (out, plan, turns) = prepared(dir.path(), name);
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let _printer = simulate(&link, Path::new(name), &["--speed", "600", "--log", log.to_str().unwrap()]);
    if filament == 'U' {
        home(&link);
    }
    let (mut keys, screen) = terminal();
    let mut send = trunnion();
    send.arg("send").arg(&out).arg("--plan").arg(&plan).arg("--port").arg(&link);
    let mut host = send.stdin(screen).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let heard = listened(&mut host);
    wait_for("the tilt", || is_printing_tilted(&executed(&log), &turns));
    interrupt(&host);
    wait_for("the pause", || heard.lock().unwrap().contains("paused above"));
    keys.write_all(b"c\n").unwrap();
    let ended = host.wait().unwrap();
    assert!(!ended.success(), "{name}: {}", heard.lock().unwrap());
    // The printer may be behind its host, whose last word is about heat, or, where nothing heats, that all moves have ended.
    let last = if filament == 'E' { "M140S0" } else { "G4P0.01" };
    wait_for("the end of the printer's log", || {
        let lines = executed(&log);
        lifted(&lines).is_some_and(|at| lines[at..].iter().any(|l| l == last))
    });
    let until = executed(&log);
    let turned = until.iter().rposition(|l| turns.contains(l)).unwrap();
    let lift = lifted(&until).unwrap();
    let (before, behind) = (&until[turned + 1..lift], &until[lift + 1..]);
    let pulled = before[before.len() - 2].starts_with(&format!("G1{filament}-"));
    assert!(before.last().is_some_and(|l| l == "G90") && pulled, "{name}: {before:?}");
    let told = |line: &str| behind.iter().any(|l| l == line);
    // A machine that knows no heaters is told nothing of them.
    let heats = filament == 'E';
    assert!(told("M104S0") == heats && told("M140S0") == heats, "{name}: {behind:?}");
    assert!(!behind.iter().any(|l| l.starts_with('G') && l != "G4P0.01"), "{name}: {behind:?}");
}

/// What heats nothing says so, stops before it lays anything, and is told at which temperatures it may go on.
#[test]
fn a_machine_without_heaters_waits_for_somebody_and_says_for_what() {
    let dir = folder();
    let mut prepare = trunnion();
    prepare.args(["prepare", "--slicer", "builtin", "-m", "grblhal-ac"]).arg(root().join("fixtures/two-boxes.stl"));
    let done = output(prepare.arg("-o").arg(dir.path().join("out.gcode")));
    assert!(done.status.success() && states(&said(&done), "M104, M106 | grbl | 210 C | 60 C"), "{}", said(&done));
    let text = std::fs::read_to_string(dir.path().join("out.gcode")).unwrap();
    let lines: Vec<&str> =
        text.lines().filter(|l| !l.is_empty() && (!l.starts_with(';') || l.contains("cycle start"))).collect();
    let stop = lines.iter().position(|l| *l == "M0").unwrap();
    assert!(
        lines[stop - 1].starts_with("; ") && states(lines[stop - 1], "210 C | 60 C | cycle start"),
        "{}",
        lines[stop - 1]
    );
    assert!(!lines[..stop].iter().any(|l| l.starts_with("G1 ")), "{:?}", &lines[..stop]);
    for letter in ["M104", "M109", "M140", "M190", "M106", "M83", " E"] {
        assert!(!lines.iter().any(|l| !l.starts_with(';') && l.contains(letter)), "{letter}");
    }
}

/// A Marlin that is not the fork does not end its following of the tip, and gets nothing.
#[test]
fn a_file_of_the_fork_goes_to_the_fork_alone() {
    let dir = folder();
    let (out, plan, _) = prepared(dir.path(), "hendrikjan-5d");
    let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
    let _printer = simulate(&link, Path::new("generic-ac"), &["--speed", "max", "--log", log.to_str().unwrap()]);
    let sent = output(trunnion().arg("send").arg(&out).arg("--plan").arg(&plan).arg("--port").arg(&link));
    assert!(!sent.status.success() && said(&sent).contains("KINEMATICS:PENTA_AXIS_TRT"), "{}", said(&sent));
    let moved = executed(&log).into_iter().filter(|l| l.starts_with('G')).collect::<Vec<_>>();
    assert_eq!(moved, Vec::<String>::new());
}

/// A profile that cannot home with a part on its table says why, and the page about sending names it.
#[test]
fn a_shipped_profile_homes_with_a_part_on_its_table_or_says_why_not() {
    let page = std::fs::read_to_string(root().join("docs/how-to/send.md")).unwrap();
    for (name, file, text) in SHIPPED {
        let profile = resolve(file, text).unwrap().0;
        let reason = text.lines().any(|l| l.starts_with('#') && l.contains("rehome stays empty: "));
        assert_eq!(profile.link.rehome.is_empty(), reason, "{name}");
        assert!(!reason || page.contains(&format!("`{name}`")), "docs/how-to/send.md does not name {name}");
    }
}
