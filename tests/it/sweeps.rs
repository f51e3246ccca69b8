//! Every rule of verification against a change of every size, from nothing to gross, both ways, on files of real slicers: the
//! size at which it is caught is printed and bounded, everything above it is caught too, and the unchanged file is clean.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::pipeline::{fixture, prepare};
use crate::support::{every, folder, installed, note, said, skip, trunnion};

/// A prepared file and its plan.
struct Subject {
    folder: tempfile::TempDir,
    name: String,
    lines: Vec<String>,
    plan: PathBuf,
}

/// One print's lines and where its part lies, machine coordinates.
struct Span {
    lines: std::ops::Range<usize>,
    middle: [f64; 2],
    reach: f64,
}

impl Subject {
    fn of(model: &str, slicer: &str) -> Option<Self> {
        let is_there = match slicer {
            "builtin" => true,
            "cura" => crate::cura_engine::is_there(),
            program => installed(program),
        };
        if !is_there {
            skip(&format!("{slicer} is not installed: {model} is not swept with it"));
            return None;
        }
        let folder = folder();
        let (file, plan) = (folder.path().join("whole.gcode"), folder.path().join("plan.json"));
        prepare(&fixture(model), "generic-ac", slicer, &file, &["--plan-out", &plan.display().to_string()]);
        let lines = std::fs::read_to_string(&file).unwrap().lines().map(str::to_owned).collect();
        Some(Self { folder, name: format!("{model}, {slicer}"), lines, plan })
    }

    /// The rules that the changed file breaks, each once.
    fn broken_by(&self, lines: &[String]) -> Vec<String> {
        let file = self.folder.path().join("changed.gcode");
        std::fs::write(&file, lines.join("\n") + "\n").unwrap();
        rules(&file, &self.plan)
    }

    fn print(&self, print: usize) -> Span {
        let begins = |l: &String| l.starts_with(&format!(";TRUNNION print={print} "));
        let start = self.lines.iter().position(begins).unwrap();
        let end = start + 1 + self.lines[start + 1..].iter().position(|l| l.starts_with(";TRUNNION")).unwrap();
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for line in self.lines[start..end].iter().filter(|l| l.contains('E')) {
            for (axis, letter) in ['X', 'Y'].into_iter().enumerate() {
                if let Some(v) = word(line, letter) {
                    bounds[axis] = [bounds[axis][0].min(v), bounds[axis][1].max(v)];
                }
            }
        }
        let half = bounds.map(|[low, high]| (high - low) / 2.0);
        Span { lines: start..end, middle: bounds.map(|[low, high]| (low + high) / 2.0), reach: half[0].hypot(half[1]) }
    }

    /// The file with `change` made to each move of `span`.
    fn changed(&self, span: std::ops::Range<usize>, change: impl Fn(&str) -> String) -> Vec<String> {
        let mut lines = self.lines.clone();
        lines[span].iter_mut().filter(|l| l.starts_with('G')).for_each(|l| *l = change(l));
        lines
    }
}

fn rules(file: &Path, plan: &Path) -> Vec<String> {
    rules_of(&report(file, plan))
}

fn report(file: &Path, plan: &Path) -> Value {
    let run = trunnion().arg("verify").arg(file).arg("--plan").arg(plan).arg("--json").output().unwrap();
    let report: Value = serde_json::from_slice(&run.stdout).unwrap_or_else(|_| panic!("{}", said(&run)));
    assert_eq!(run.status.code(), Some(i32::from(!rules_of(&report).is_empty())), "{}", said(&run));
    report
}

fn rules_of(report: &Value) -> Vec<String> {
    let mut all: Vec<String> =
        report["findings"].as_array().unwrap().iter().map(|f| f["rule"].as_str().unwrap().to_owned()).collect();
    all.sort();
    all.dedup();
    all
}

fn word(line: &str, letter: char) -> Option<f64> {
    line.split(' ').find_map(|w| w.strip_prefix(letter)?.parse().ok())
}

/// `line` with its word `letter` changed, where it has one.
fn with(line: &str, letter: char, change: impl Fn(f64) -> f64) -> String {
    let one = |w: &str| match w.strip_prefix(letter).and_then(|v| v.parse::<f64>().ok()) {
        Some(value) => format!("{letter}{:.5}", change(value)),
        None => w.to_owned(),
    };
    line.split(' ').map(one).collect::<Vec<_>>().join(" ")
}

/// One change, in sizes from nothing up, and the size from which on it must be caught.
struct Sweep<'a> {
    name: String,
    sizes: &'a [f64],
    caught_from: f64,
    change: Box<dyn Fn(f64) -> Vec<String> + 'a>,
}

impl Sweep<'_> {
    /// Both ways. In the suite only nothing once and the size from which on it must be caught, in the built-in slicer's files the largest, too, and in
    /// others' one way or the other; in a soak all of them.
    fn run(&self, subject: &Subject, table: &mut String) {
        let gross = self.sizes[self.sizes.len() - 1];
        let both = every(2) == 1 || subject.name.ends_with("builtin");
        let one = if self.name.len().is_multiple_of(2) { 1.0 } else { -1.0 };
        for sign in [1.0, -1.0].into_iter().filter(|&sign| both || sign == one) {
            let mut first = None;
            let is_largest = |size: f64| size == gross && subject.name.ends_with("builtin");
            let chosen = |size: f64| size == self.caught_from || is_largest(size) || size == 0.0 && sign > 0.0;
            for size in self.sizes.iter().copied().filter(|&size| every(2) == 1 || chosen(size)) {
                let found = subject.broken_by(&(self.change)(sign * size));
                if size == 0.0 {
                    assert!(found.is_empty(), "{}: {} by 0: {found:?}", subject.name, self.name);
                }
                assert!(
                    !found.is_empty() || size < self.caught_from,
                    "{}: {} by {} is not caught",
                    subject.name,
                    self.name,
                    sign * size
                );
                if !found.is_empty() {
                    first.get_or_insert((size, found));
                }
            }
            let (size, found) = first.unwrap();
            let bound = self.caught_from;
            let _ =
                writeln!(table, "  {:34} {:>8} caught (bound {bound}) by {}", self.name, sign * size, found.join(", "));
        }
    }
}

/// All sweeps on one file; `flow` is the bound for its filament, relative.
fn sweep(model: &str, slicer: &str, flow: f64) {
    let Some(subject) = Subject::of(model, slicer) else { return };
    let subject = &subject;
    let prints = subject.lines.iter().filter(|l| l.starts_with(";TRUNNION expect")).count();
    let mut sweeps: Vec<Sweep<'_>> = Vec::new();
    for print in [0, prints - 1] {
        for letter in ['X', 'Y'] {
            sweeps.push(Sweep {
                name: format!("print {print} shifted in {letter}, mm"),
                sizes: &[0.0, 0.05, 0.1, 0.15, 0.3, 0.6, 1.5],
                caught_from: 0.15,
                change: Box::new(move |by| {
                    subject.changed(subject.print(print).lines, |l| with(l, letter, |v| v + by))
                }),
            });
        }
        sweeps.push(Sweep {
            name: format!("print {print} shifted in Z, mm"),
            sizes: &[0.0, 0.03, 0.05, 0.08, 0.12, 0.2, 0.5, 1.0],
            caught_from: 0.08,
            change: Box::new(move |by| subject.changed(subject.print(print).lines, |l| with(l, 'Z', |v| v + by))),
        });
        sweeps.push(Sweep {
            name: format!("print {print} turned, mm at its rim"),
            sizes: &[0.05, 0.1, 0.15, 0.3, 1.0],
            caught_from: 0.15,
            change: Box::new(move |by| turned(subject, print, by)),
        });
        sweeps.push(Sweep {
            name: format!("print {print} scaled, mm at its rim"),
            sizes: &[0.05, 0.1, 0.15, 0.3, 1.0],
            caught_from: 0.15,
            change: Box::new(move |by| {
                let span = subject.print(print);
                let grown = |v: f64, axis: usize| span.middle[axis] + (v - span.middle[axis]) * (1.0 + by / span.reach);
                subject.changed(span.lines, |l| with(&with(l, 'X', |v| grown(v, 0)), 'Y', |v| grown(v, 1)))
            }),
        });
    }
    sweeps.push(Sweep {
        name: "filament in file and header, share".to_owned(),
        sizes: &[0.01, 0.03, 0.05, 0.1, 0.3, 0.8],
        caught_from: flow,
        change: Box::new(move |by| filament(subject, 1.0 + by)),
    });
    sweeps.push(Sweep {
        name: "tilt of the first tilted print, deg".to_owned(),
        sizes: &[0.0005, 0.01, 0.05, 0.2, 1.0],
        caught_from: 0.05,
        change: Box::new(move |by| {
            let tilts = |l: &String| word(l, 'A').is_some_and(|a| a != 0.0) && l.starts_with("G1 A");
            let turn = subject.lines.iter().position(tilts).unwrap();
            // Towards level, so that no stop is in the way: this is about the pose.
            subject.changed(turn..turn + 1, |l| with(l, 'A', |v| v - by.abs()))
        }),
    });
    sweeps.push(Sweep {
        name: "one layer's Z, mm".to_owned(),
        sizes: &[0.0, 0.03, 0.08, 0.15, 0.5],
        caught_from: 0.08,
        change: Box::new(move |by| {
            let span = subject.print(0).lines;
            let rises: Vec<usize> = span.filter(|&i| subject.lines[i].starts_with("G1 Z")).collect();
            let at = rises[rises.len() / 2];
            subject.changed(at..at + 1, |l| with(l, 'Z', |v| v + by))
        }),
    });
    let mut table = String::new();
    sweeps.iter().for_each(|sweep| sweep.run(subject, &mut table));
    passing(subject, &mut table);
    note(&format!("swept {}\n{table}", subject.name));
}

/// The head's block, 10 mm to either side of the tip, driven beside the first print before the table turns: the clearance told is
/// the room between them, and what touches is caught.
fn passing(subject: &Subject, table: &mut String) {
    let span = subject.print(0);
    let turn = subject.lines.iter().position(|l| l.starts_with(";TRUNNION slot=1")).unwrap();
    let above = subject.lines[..turn].iter().rev().find_map(|l| word(l, 'Z')).unwrap();
    // Where its lines begin and end by height, with half their width; the last rise of the print is its lift.
    let (mut y, mut z, mut width, mut ends) = (0.0, 0.0, 0.45, Vec::new());
    for line in &subject.lines[span.lines.clone()] {
        // To be on the safe side verification takes lines for no narrower than the profile's.
        width = line.strip_prefix(";WIDTH:").map_or(width, |mm| mm.parse::<f64>().unwrap().max(0.45));
        let from = y;
        (y, z) = (word(line, 'Y').unwrap_or(y), word(line, 'Z').unwrap_or(z));
        ends.extend(
            (line.starts_with('G') && line.contains('E') && line.contains(['X', 'Y']))
                .then_some([y.max(from) + width / 2.0, z]),
        );
    }
    let top = ends.iter().fold(f64::MIN, |top, [_, z]| top.max(*z));
    // The block reaches down to 5 mm below the top.
    let face = ends.iter().filter(|[_, z]| *z > top - 5.0).fold(f64::MIN, |face, [y, _]| face.max(*y));
    for gap in [2.0, 0.5, 0.1, 0.05, -0.05, -0.1, -0.5, -2.0] {
        let mut lines = subject.lines.clone();
        let way = [
            format!("G1 X{:.3} Y{:.3} F6000", span.middle[0], face + 40.0),
            format!("G1 Z{:.3} F900", top - 15.0),
            format!("G1 Y{:.3} F6000", face + 10.0 + gap),
            format!("G1 Y{:.3} F6000", face + 40.0),
            format!("G1 Z{above:.3} F900"),
        ];
        lines.splice(turn..turn, way);
        let file = subject.folder.path().join("passing.gcode");
        std::fs::write(&file, lines.join("\n") + "\n").unwrap();
        let report = report(&file, &subject.plan);
        let found = rules_of(&report);
        assert_eq!(found.contains(&"head-collision".to_owned()), gap < 0.0, "{}, {gap}: {found:?}", subject.name);
        let told = report["clearance_mm"].as_f64().unwrap();
        assert!(
            gap < 0.0 || told <= gap + 0.05 && (told >= gap - 0.05 || gap > 0.15),
            "{}, {gap}: {told}",
            subject.name
        );
        let _ =
            writeln!(table, "  {:34} {gap:>8} clearance {told:.3}, {}", "head beside print 0, mm", found.join(", "));
    }
}

fn turned(subject: &Subject, print: usize, by: f64) -> Vec<String> {
    let span = subject.print(print);
    let (sin, cos) = (by / span.reach).sin_cos();
    // The travel to its beginning stands before its mark.
    let before = |letter| subject.lines[..span.lines.start].iter().rev().find_map(|l| word(l, letter)).unwrap();
    let mut at = [before('X'), before('Y')];
    let mut lines = subject.lines.clone();
    for line in lines[span.lines].iter_mut().filter(|l| l.starts_with('G')) {
        let written = [word(line, 'X'), word(line, 'Y')];
        at = [written[0].unwrap_or(at[0]), written[1].unwrap_or(at[1])];
        if written == [None, None] {
            continue;
        }
        // A turned line needs both words.
        let [x, y] = [at[0] - span.middle[0], at[1] - span.middle[1]];
        let to = [span.middle[0] + x * cos - y * sin, span.middle[1] + x * sin + y * cos];
        let rest: Vec<&str> = line.split(' ').filter(|w| !w.starts_with(['X', 'Y'])).collect();
        *line = format!("{} X{:.4} Y{:.4} {}", rest[0], to[0], to[1], rest[1..].join(" "));
    }
    lines
}

fn filament(subject: &Subject, share: f64) -> Vec<String> {
    let mut lines = subject.changed(0..subject.lines.len(), |l| with(l, 'E', |v| v * share));
    // The header is made to agree to the last digit, so that the sum of each print tells nothing.
    let mut more: BTreeMap<String, f64> = BTreeMap::new();
    let mut print = String::new();
    for (old, new) in subject.lines.iter().zip(&lines) {
        if let Some(rest) = old.strip_prefix(";TRUNNION print=") {
            print = rest.split(' ').next().unwrap().to_owned();
        }
        let lays = old.starts_with('G') && (old.contains(" X") || old.contains(" Y"));
        if let (true, Some(was), Some(is)) = (lays, word(old, 'E'), word(new, 'E')) {
            *more.entry(print.clone()).or_default() += is - was;
        }
    }
    for line in lines.iter_mut().filter(|l| l.starts_with(";TRUNNION expect")) {
        let print = line.split(' ').find_map(|w| w.strip_prefix("print=")).unwrap().to_owned();
        let words = line.split(' ').map(|w| match w.strip_prefix("filament_mm=") {
            Some(mm) => format!("filament_mm={:.5}", mm.parse::<f64>().unwrap() + more[&print]),
            None => w.to_owned(),
        });
        *line = words.collect::<Vec<_>>().join(" ");
    }
    lines
}

/// Of each slicer the suite sweeps one file, and of the tilted ones one: the others are the soak's.
fn in_a_soak(sweep: impl FnOnce()) {
    if every(2) == 1 { sweep() } else { note("left to scripts/soak.sh: another file of this slicer is swept") }
}

#[test]
fn built_in_two_boxes() {
    sweep("two-boxes", "builtin", 0.05);
}

#[test]
fn built_in_y_tree_tilted_to_45_degrees() {
    in_a_soak(|| sweep("y-tree", "builtin", 0.05));
}

#[test]
fn prusa_slicer_two_boxes() {
    in_a_soak(|| sweep("two-boxes", "prusa-slicer", 0.05));
}

#[test]
fn prusa_slicer_y_tree_tilted_to_45_degrees() {
    sweep("y-tree", "prusa-slicer", 0.05);
}

#[test]
fn slic3r_two_boxes() {
    sweep("two-boxes", "slic3r", 0.1);
}

#[test]
fn cura_engine_two_boxes() {
    sweep("two-boxes", "cura", 0.1);
}

#[test]
fn cura_engine_y_tree_tilted_to_45_degrees() {
    in_a_soak(|| sweep("y-tree", "cura", 0.1));
}

/// The table of changes that an outside look found clean: each is a finding now, by the rule that is named.
#[test]
fn every_change_that_was_once_clean_is_a_finding() {
    for model in ["y-tree", "two-boxes"].into_iter().step_by(every(2)) {
        let subject = Subject::of(model, "builtin").unwrap();
        let last = subject.lines.iter().filter(|l| l.starts_with(";TRUNNION expect")).count() - 1;
        let first = subject.print(0);
        let middle = (first.lines.start + first.lines.end) / 2;
        let finds = |what: &str, lines: &[String], rule: &str| {
            let found = subject.broken_by(lines);
            assert!(found.iter().any(|r| r == rule), "{model}: {what}: {rule} is not among {found:?}");
        };
        for by in [-0.5, -0.35, -0.2, 0.26] {
            let lines = subject.changed(first.lines.clone(), |l| with(l, 'Z', |v| v + by));
            finds(&format!("first print moved by Z{by}"), &lines, if by == 0.26 { "complete" } else { "layer-height" });
        }
        for (letter, by) in [('X', 0.62), ('Y', 0.6)] {
            let lines = subject.changed(subject.print(last).lines, |l| with(l, letter, |v| v + by));
            finds(&format!("last print moved by {letter}{by}"), &lines, "registration");
        }
        let scaled = |l: &str| ['X', 'Y', 'Z'].iter().fold(l.to_owned(), |l, c| with(&l, *c, |v| v * 1.05));
        finds("scaled by 1.05", &subject.changed(0..subject.lines.len(), scaled), "registration");
        let inserted = |text: &str| {
            let mut lines = subject.lines.clone();
            lines.insert(middle, text.to_owned());
            lines
        };
        for text in [
            "M206 Z5",
            "M428",
            "M290 Z-2",
            "M92 E400",
            "SET_GCODE_OFFSET Z=-2",
            "G10 P0 Z5",
            "T1",
            "M84",
            "M112",
            "M221 S500",
        ] {
            finds(text, &inserted(text), "command");
        }
        finds("M104 S0", &inserted("M104 S0"), "heat");
        let heats = |l: &String| ["M104", "M109", "M140", "M190"].iter().any(|c| l.starts_with(c));
        let cold: Vec<String> = subject.lines.iter().filter(|l| !heats(l)).cloned().collect();
        finds("no heating", &cold, "heat");
        for share in [0.1, 2.0, 5.0, 10.0] {
            finds(&format!("E x{share}"), &filament(&subject, share), "flow");
        }
        let lays = |l: &String| l.starts_with("G1 X") && l.contains(" E");
        let torn = subject.lines[..=subject.lines.iter().rposition(lays).unwrap()].to_vec();
        finds("torn off", &torn, "complete");
        let slot = subject.lines.iter().position(|l| l.starts_with(";TRUNNION slot=1")).unwrap();
        let pull = subject.lines[..slot].iter().rposition(|l| l.starts_with("G1 E-")).unwrap();
        let prime = slot + subject.lines[slot..].iter().position(|l| l.starts_with("G1 E")).unwrap();
        let mut bare = subject.lines.clone();
        bare.remove(prime);
        bare.remove(pull);
        finds("no retraction around a turn", &bare, "retract");
        let end = subject.lines.iter().position(|l| l.starts_with(";TRUNNION end")).unwrap();
        let hasty = subject.changed(first.lines.start..end, |l| {
            if l.contains('Z') || l.starts_with("G1 E") {
                l.to_owned()
            } else {
                with(l, 'F', |v| (v * 5.0).min(12000.0))
            }
        });
        finds("feeds x5", &hasty, "flow");
        // Without the travel to it a wall's first side becomes a diagonal.
        let walls = |i: &usize| subject.lines[*i].starts_with(";TYPE:External perimeter");
        let wall = (middle..end).find(walls).unwrap();
        let travel = subject.lines[..wall].iter().rposition(|l| l.starts_with("G1 X") && !l.contains('E')).unwrap();
        let mut diagonal = subject.lines.clone();
        diagonal.remove(travel);
        finds("a wall's travel deleted", &diagonal, "flow");
    }
}
