//! A finished file with one thing wrong in it: the rule it breaks must name it. (Each rule alone against a program worked
//! out by hand: `src/verify/tests.rs`.)

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::pipeline::{fixture, prepare};
use crate::support::{folder, said, trunnion};

/// A prepared file, its plan, and a folder to mutate it in.
pub(crate) struct Victim {
    pub(crate) folder: tempfile::TempDir,
    lines: Vec<String>,
    pub(crate) plan: PathBuf,
}

/// A change of a file's lines.
pub(crate) type Change = Box<dyn FnOnce(&mut Vec<String>)>;

impl Victim {
    pub(crate) fn of(name: &str) -> Self {
        let folder = folder();
        let (file, plan) = (folder.path().join("whole.gcode"), folder.path().join("plan.json"));
        prepare(&fixture(name), "generic-ac", "builtin", &file, &["--plan-out", &plan.display().to_string()]);
        let lines = std::fs::read_to_string(&file).unwrap().lines().map(str::to_owned).collect();
        Self { folder, lines, plan }
    }

    /// The line numbers (from 0) of slot 1, between its mark and the end's.
    fn slot_one(&self) -> std::ops::Range<usize> {
        let start = self.find(0, ";TRUNNION slot=1");
        start..self.find(start + 1, ";TRUNNION end")
    }

    fn find(&self, from: usize, start: &str) -> usize {
        from + self.lines[from..].iter().position(|l| l.starts_with(start)).unwrap_or_else(|| panic!("no {start}"))
    }

    /// The first line of `within` that lays filament.
    fn laying(&self, within: std::ops::Range<usize>) -> usize {
        let lays = |l: &String| l.starts_with("G1 X") && l.contains(" E0.");
        within.start + self.lines[within].iter().position(lays).unwrap()
    }

    /// The file with `change` made to its lines.
    #[track_caller]
    pub(crate) fn changed(&self, change: impl FnOnce(&mut Vec<String>)) -> PathBuf {
        let mut lines = self.lines.clone();
        change(&mut lines);
        assert_ne!(lines, self.lines, "nothing was changed");
        let file = self.folder.path().join("mutant.gcode");
        std::fs::write(&file, lines.join("\n")).unwrap();
        file
    }

    /// The rules that the file breaks once `change` was made to its lines.
    #[track_caller]
    fn broken_by(&self, change: impl FnOnce(&mut Vec<String>)) -> Vec<String> {
        rules(&self.changed(change), &self.plan)
    }
}

/// What `verify --json` says of a file with findings.
#[track_caller]
pub(crate) fn report(file: &Path, plan: &Path) -> Value {
    let run = trunnion().arg("verify").arg(file).arg("--plan").arg(plan).arg("--json").output().unwrap();
    assert_eq!(run.status.code(), Some(1), "nothing was found: {}", said(&run));
    serde_json::from_slice(&run.stdout).unwrap()
}

#[track_caller]
fn rules(file: &Path, plan: &Path) -> Vec<String> {
    let report = report(file, plan);
    let findings = report["findings"].as_array().unwrap();
    for finding in findings {
        assert!(finding["line"].as_u64().unwrap() > 0 && !finding["text"].as_str().unwrap().is_empty(), "{finding}");
    }
    findings.iter().map(|f| f["rule"].as_str().unwrap().to_owned()).collect()
}

#[track_caller]
fn names(rules: &[String], wanted: &str) {
    assert!(rules.iter().any(|r| r == wanted), "{wanted} is not among {rules:?}");
}

/// `word` of the line moved by `by`.
fn moved(line: &str, word: char, by: f64) -> String {
    let shift = |w: &str| match w.strip_prefix(word).and_then(|v| v.parse::<f64>().ok()) {
        Some(value) => format!("{word}{:.3}", value + by),
        None => w.to_owned(),
    };
    line.split(' ').map(shift).collect::<Vec<_>>().join(" ")
}

/// Changes of `two-boxes`, each with the rules that must name it.
pub(crate) fn mutants(victim: &Victim) -> Vec<(&'static [&'static str], Change)> {
    let slot = victim.slot_one();
    let laying = victim.laying(slot.clone());
    let start = slot.start;
    let retract = victim.lines[..start].iter().rposition(|l| l.starts_with("G1 E-")).unwrap();
    let turn = |lines: &[String]| lines.iter().position(|l| l.starts_with("G1 A90")).unwrap();
    let instead = |at: usize, line: &'static str| -> Change { Box::new(move |lines| lines[at] = line.to_owned()) };
    vec![
        (
            &["outside-part"],
            Box::new(move |lines| {
                lines[slot].iter_mut().filter(|l| l.starts_with("G1")).for_each(|l| *l = moved(l, 'X', 1.0));
            }),
        ),
        (
            &["pose", "axis-limit"],
            Box::new(move |lines| {
                let at = turn(lines);
                lines[at] = lines[at].replace("A90", "A-90");
            }),
        ),
        (
            &["axis-limit"],
            Box::new(move |lines| {
                let at = turn(lines);
                lines[at] = lines[at].replace("A90", "A90.5");
            }),
        ),
        (&["retract"], Box::new(move |lines| drop(lines.remove(retract)))),
        (&["filament"], Box::new(move |lines| drop(lines.remove(laying)))),
        (&["turn-while-extruding"], Box::new(move |lines| lines.insert(laying, lines[laying].clone() + " C91"))),
        (
            &["axis-rate"],
            Box::new(move |lines| {
                let at = turn(lines);
                lines[at] = "G1 A90 F12000".to_owned();
            }),
        ),
        (&["axis-rate"], Box::new(move |lines| lines[laying] += " F99000")),
        (&["axis-rate"], Box::new(move |lines| lines[laying] += " F0")),
        (&["syntax"], Box::new(move |lines| lines[laying] += " F-600")),
        (&["syntax"], instead(laying, "G1 X--5")),
        (&["syntax"], instead(laying, "G20")),
        (&["command"], instead(laying, "G54")),
        (&["unknown-position"], Box::new(move |lines| lines.insert(laying, "G28".to_owned()))),
        (&["sequence"], Box::new(|lines| lines.retain(|l| !l.starts_with(";TRUNNION expect print=1")))),
        (&["sequence"], Box::new(move |lines| lines.truncate(start))),
        (
            // A whole layer of the first box laid 1 mm too high.
            &["in-air"],
            Box::new(|lines| {
                let at = lines.iter().position(|l| l.starts_with("G1 Z5 ")).unwrap();
                lines[at] = moved(&lines[at], 'Z', 1.0);
            }),
        ),
        (&["heat"], Box::new(move |lines| lines.insert(laying, "M104 S0".to_owned()))),
        (
            // The same by half a layer.
            &["layer-height"],
            Box::new(|lines| {
                let at = lines.iter().position(|l| l.starts_with("G1 Z5 ")).unwrap();
                lines[at] = moved(&lines[at], 'Z', 0.1);
            }),
        ),
        (
            // Without the lift before the table turns, the head stands where the table sweeps.
            &["turn-collision"],
            Box::new(move |lines| {
                let lift = lines[..start].iter().rposition(|l| l.starts_with("G1 Z")).unwrap();
                lines.remove(lift);
            }),
        ),
    ]
}

#[test]
fn every_mutant_of_a_real_file_is_caught_by_its_rule() {
    let victim = Victim::of("two-boxes");
    for (wanted, change) in mutants(&victim) {
        let rules = victim.broken_by(change);
        wanted.iter().for_each(|rule| names(&rules, rule));
    }
}

#[test]
fn a_lowered_travel_is_a_collision() {
    // The posts of the Ding object grow side by side; from one to the other the nozzle hops.
    let victim = Victim::of("ding");
    let rules = victim.broken_by(|lines| {
        let switch = lines.iter().rposition(|l| l.starts_with(";TRUNNION print=")).unwrap();
        let hop = lines[..switch].iter().rposition(|l| l.starts_with("G1 Z")).unwrap();
        lines[hop] = moved(&lines[hop], 'Z', -3.0);
    });
    names(&rules, "head-collision");
}

#[test]
fn a_slot_printed_twice_or_too_early_is_out_of_sequence() {
    let victim = Victim::of("two-boxes");
    let slot = victim.slot_one();
    let twice = victim.broken_by(|lines| {
        let again: Vec<String> = lines[slot.clone()].to_vec();
        lines.splice(slot.end..slot.end, again);
    });
    names(&twice, "filament");
    let first = victim.find(0, ";TRUNNION slot=0");
    let early = victim.broken_by(|lines| lines[first..slot.end].rotate_left(slot.start - first));
    names(&early, "sequence");
}
