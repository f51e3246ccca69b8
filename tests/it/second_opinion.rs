//! `examples/second_opinion/`, a reader of finished programs that shares no code with the library: it agrees with every file that is certified, and
//! whatever it finds in a damaged one, `verify` finds too.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;
use trunnion::job::{CheckedPlan, Silent, World, load_plan};
use trunnion::verify::{ReplayJob, verify};

use crate::pipeline::{fixture, prepare};
use crate::support::{Numbers, every, folder, installed, note, seeds, skip};

#[allow(dead_code)]
#[path = "../../examples/second_opinion/main.rs"]
mod example;

/// What is not of the program alone: its hash, and figures that a certificate states.
const OF_THE_CERTIFICATE: [&str; 2] = ["hashes", "figures"];

/// A program, its plan and its certificate, in a folder.
struct Certified {
    folder: tempfile::TempDir,
    program: Vec<u8>,
    certificate: Value,
    model: Vec<u8>,
}

impl Certified {
    fn of(model: &str, machine: &str, slicer: &str, more: &[&str]) -> Self {
        let folder = folder();
        let path = |name: &str| folder.path().join(name).display().to_string();
        let (plan, certificate) = (path("plan.json"), path("proved.json"));
        let words = ["--plan-out", &plan, "--certificate", &certificate];
        prepare(model, machine, slicer, Path::new(&path("made.gcode")), &[&words[..], more].concat());
        let read = |name: String| std::fs::read(name).unwrap();
        let (program, model) = (read(path("made.gcode")), read(model.to_owned()));
        let certificate = serde_json::from_slice(&read(certificate)).unwrap();
        Self { folder, program, certificate, model }
    }

    /// What the other reader finds wrong, by check.
    fn opinion(&self, program: &[u8]) -> BTreeMap<&'static str, Vec<String>> {
        let opinion = example::check(program, &self.certificate, Some(&self.model)).unwrap();
        let failed = opinion.checks.into_iter().filter(|check| check.count > 0);
        failed.map(|check| (check.name, check.failures)).collect()
    }

    fn plan(&self) -> CheckedPlan {
        load_plan(&self.folder.path().join("plan.json").as_path().into(), &World::here(&Silent)).unwrap()
    }
}

#[track_caller]
fn agrees(model: &str, machine: &str, slicer: &str, more: &[&str]) {
    let made = Certified::of(model, machine, slicer, more);
    let failed = made.opinion(&made.program);
    assert!(failed.is_empty(), "{model} on {machine} with {slicer}: {failed:?}");
}

#[test]
fn every_fixture_has_a_second_opinion() {
    // The largest is a soak's.
    for name in ["cube", "two-boxes", "y-tree", "ding"].into_iter().take(if every(2) == 1 { 4 } else { 3 }) {
        agrees(&fixture(name), "generic-ac", "builtin", &[]);
    }
}

#[test]
fn every_firmware_has_a_second_opinion() {
    for machine in ["generic-bc", "grblhal-ac", "linuxcnc-xyzac-trt", "linuxcnc-xyzbc-trt", "pentos", "fractal-5-pro"] {
        agrees(&fixture("two-boxes"), machine, "builtin", &[]);
    }
}

#[test]
fn a_part_on_supports_has_a_second_opinion() {
    agrees(&fixture("hook"), "generic-ac", "builtin", &["--way", "supports"]);
}

fn agrees_with(program: &str, slicer: &str) {
    if !installed(program) {
        return skip(&format!("{program} is not installed"));
    }
    for name in ["two-boxes", "y-tree"].into_iter().step_by(every(2)) {
        agrees(&fixture(name), "generic-ac", slicer, &[]);
    }
}

#[test]
fn prusa_slicer_s_files_have_a_second_opinion() {
    agrees_with("prusa-slicer", "prusa-slicer");
}

#[test]
fn slic3r_s_files_have_a_second_opinion() {
    agrees_with("slic3r", "slic3r");
}

#[test]
fn cura_s_files_have_a_second_opinion() {
    agrees_with("CuraEngine", "cura");
}

/// A line's words, without its comment.
fn code(line: &str) -> &str {
    line.split(';').next().unwrap_or_default().trim()
}

/// One thing is changed, as a broken disk, a wrong script or a hand would; what, in a word.
fn damage(lines: &mut Vec<String>, random: &mut Numbers) -> &'static str {
    let mut below = |n: usize| (random.between(0.0, n as f64) as usize).min(n - 1);
    // Half of all lines say nothing: of those with code one is taken.
    let with_code: Vec<usize> = (0..lines.len()).filter(|&i| !code(&lines[i]).is_empty()).collect();
    let at = with_code[below(with_code.len())];
    let words: Vec<String> = code(&lines[at]).split(' ').map(str::to_owned).collect();
    let word = below(words.len());
    let with = |new: String| {
        let mut words = words.clone();
        words[word] = new;
        words.join(" ")
    };
    match below(12) {
        0 => (lines.remove(at), "line removed").1,
        1 => (lines.insert(at, lines[at].clone()), "line doubled").1,
        2 if at + 1 < lines.len() => (lines.swap(at, at + 1), "lines swapped").1,
        3 => {
            let digits: Vec<usize> = lines[at].match_indices(|c: char| c.is_ascii_digit()).map(|(i, _)| i).collect();
            if let Some(&digit) = digits.get(below(digits.len().max(1))) {
                let other = char::from(b'0' + below(10) as u8).to_string();
                lines[at].replace_range(digit..=digit, &other);
            }
            "digit"
        }
        4 => (lines[at] = with(String::new()), "word removed").1,
        5 => {
            let (letter, number) = words[word].split_at(1.min(words[word].len()));
            let turned = number.strip_prefix('-').map_or(format!("-{number}"), str::to_owned);
            (lines[at] = with(format!("{letter}{turned}")), "sign").1
        }
        6 => {
            let letter = ["X", "Y", "Z", "E", "F", "A", "C", "S"][below(8)];
            let rest = words[word].get(1..).unwrap_or_default().to_owned();
            (lines[at] = with(format!("{letter}{rest}")), "letter").1
        }
        7 => {
            let other = lines[with_code[below(with_code.len())]].clone();
            (lines.insert(at, other), "line from elsewhere").1
        }
        8 => {
            let end = (at + 2 + below(200)).min(lines.len());
            (drop(lines.drain(at..end)), "block removed").1
        }
        9 => {
            let end = (at + 2 + below(200)).min(lines.len());
            let block: Vec<String> = lines.drain(at..end).collect();
            let to = below(lines.len());
            (drop(lines.splice(to..to, block)), "block moved").1
        }
        10 => {
            let factor = [0.0, 0.5, 0.9, 1.1, 2.0, 10.0][below(6)];
            let (letter, number) = words[word].split_at(1.min(words[word].len()));
            let scaled = number.parse::<f64>().map(|value| format!("{letter}{:.5}", value * factor));
            (lines[at] = with(scaled.unwrap_or_else(|_| words[word].clone())), "number").1
        }
        _ => (lines.truncate(at), "cut short").1,
    }
}

/// A binary STL, so many times as large.
fn scaled(stl: &[u8], factor: f32) -> Vec<u8> {
    let mut stl = stl.to_vec();
    for facet in stl[84..].chunks_exact_mut(50) {
        for number in facet[12..48].chunks_exact_mut(4) {
            let value = f32::from_le_bytes(number.try_into().unwrap());
            number.copy_from_slice(&(value * factor).to_le_bytes());
        }
    }
    stl
}

/// Whatever another reader finds in a damaged file, `verify` finds too.
fn damaged(slicer: &str, few: u64) {
    let folder = folder();
    let model = folder.path().join("small.stl");
    std::fs::write(&model, scaled(&std::fs::read(fixture("y-tree")).unwrap(), 0.4)).unwrap();
    let made = Certified::of(&model.display().to_string(), "generic-ac", slicer, &["--unit", "mm"]);
    let plan = made.plan();
    let workpiece = plan.workpiece();
    let job = ReplayJob { profile: &plan.machine.profile, plan: &plan.plan, workpiece: &workpiece };
    let whole: Vec<String> = String::from_utf8(made.program.clone()).unwrap().lines().map(str::to_owned).collect();
    let (mut both, mut ours, mut neither) = (0, 0, 0);
    for seed in seeds(few, 500) {
        let (mut lines, mut random) = (whole.clone(), Numbers::seeded(seed));
        let kind = damage(&mut lines, &mut random);
        let program = lines.join("\n") + "\n";
        let mut theirs = made.opinion(program.as_bytes());
        theirs.retain(|name, _| !OF_THE_CERTIFICATE.contains(name));
        let found = !verify(program.as_bytes(), &job).is_clean();
        assert!(found || theirs.is_empty(), "{slicer}, seed {seed}, {kind}: {theirs:?}");
        match (found, theirs.is_empty()) {
            (true, false) => both += 1,
            (true, true) => ours += 1,
            _ => neither += 1,
        }
    }
    note(&format!("{slicer}: {both} found by both, {ours} by verify alone, {neither} by none"));
    assert!(both > ours / 4, "{both}, {ours}, {neither}: the other reader is blind");
}

#[test]
fn whatever_another_reader_finds_in_a_damaged_file_is_a_finding() {
    damaged("builtin", 24);
}

#[test]
fn whatever_another_reader_finds_in_a_damaged_file_of_prusa_slicer_is_a_finding() {
    if !installed("prusa-slicer") {
        return skip("prusa-slicer is not installed");
    }
    damaged("prusa-slicer", 8);
}
