//! Slices changed at random in one place, rewritten: refused, or a finding, or nothing of what is laid has changed.
//!
//! What is laid is compared as filament in cubes of half a millimetre, so that a line split in two or taken the other way round
//! is the same.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use trunnion::profile::{resolve, shipped};
use trunnion::trace::{TraceSetting, read};

use crate::pipeline::fixture;
use crate::support::{Numbers, folder, installed, note, said, skip, soak, trunnion};

/// How many changes are tried of each file.
const CHANGES: usize = 30;
/// Filament that may lie elsewhere unseen, mm³: 4 mm of line.
const UNSEEN_MM3: f64 = 0.35;
/// The same for the built-in slicer's infill, were there no checksum, and for CuraEngine's: a line begun a line's width off is infill like any other.
const INFILL_MM3: f64 = 1.2;
/// Edge of the cubes, mm.
const CUBE_MM: f64 = 0.5;

fn setting() -> TraceSetting {
    let (file, text) = shipped("generic-ac").unwrap();
    resolve(file, text).unwrap().0.trace_setting()
}

/// Filament by cube, mm³.
fn laid(gcode: &[u8], setting: &TraceSetting) -> BTreeMap<[i32; 3], f64> {
    let trace = read(gcode, setting);
    let mut all = BTreeMap::new();
    for m in trace.moves().filter(|m| m.prints()) {
        let Some([from, to]) = m.ends() else { continue };
        let count = ((to - from).norm() / 0.1).ceil().max(1.0);
        for k in 0..count as usize {
            let p = from + (to - from) * ((k as f64 + 0.5) / count);
            // Layers fall into the middle of their cubes.
            let cube = [p.x, p.y, p.z * 2.5 + 0.1].map(|v| (v / CUBE_MM).round() as i32);
            *all.entry(cube).or_insert(0.0) += m.e * 2.405_28 / count;
        }
    }
    all
}

/// Filament that lies elsewhere, mm³: what is missing or more in cubes, what its neighbours make up for left out.
fn elsewhere(a: &BTreeMap<[i32; 3], f64>, b: &BTreeMap<[i32; 3], f64>) -> f64 {
    let mut difference: BTreeMap<[i32; 3], f64> = a.clone();
    for (cube, v) in b {
        *difference.entry(*cube).or_insert(0.0) -= v;
    }
    let cubes: Vec<[i32; 3]> = difference.keys().copied().collect();
    for cube in cubes {
        for (dx, dy) in [(1, 0), (0, 1), (1, 1), (1, -1)] {
            let beside = [cube[0] + dx, cube[1] + dy, cube[2]];
            let (here, there) = (difference[&cube], difference.get(&beside).copied().unwrap_or(0.0));
            if here * there < 0.0 {
                let moved = here.abs().min(there.abs()).copysign(here);
                *difference.get_mut(&cube).unwrap() -= moved;
                *difference.get_mut(&beside).unwrap() += moved;
            }
        }
    }
    difference.values().map(|v| v.abs()).sum::<f64>() / 2.0
}

/// One change at random; what it was.
fn mutate(lines: &mut Vec<String>, numbers: &mut Numbers) -> String {
    let any = |numbers: &mut Numbers, count: usize| numbers.between(0.0, count as f64) as usize;
    let moves: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].starts_with("G1")).collect();
    let at = moves[any(numbers, moves.len())];
    let old = lines[at].clone();
    match any(numbers, 8) {
        0 => drop(lines.remove(at)),
        1 => lines.insert(at, old.clone()),
        2 => {
            let other = moves[any(numbers, moves.len())];
            lines.swap(at, other);
        }
        3 => {
            let inserted =
                ["M206 Z5", "G92 X0", "G91", "M221 S90", "G1 Z3", "M83", "M82", "T1", "G90 G1 X5", "G1 X1 R2"];
            lines.insert(at, inserted[any(numbers, inserted.len())].to_owned());
        }
        4 => lines.truncate(at),
        _ => {
            let words: Vec<&str> = old.split(' ').collect();
            let which = 1 + any(numbers, words.len() - 1);
            let (letter, value) = words[which].split_at(1);
            let value = value.parse::<f64>().unwrap_or(0.0);
            let by = 10f64.powf(numbers.between(-2.0, 1.5)) * if numbers.between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
            let changed = match letter {
                "E" | "F" => value * (1.0 + by).max(0.001),
                _ => value + by,
            };
            let mut words: Vec<String> = words.iter().map(|w| (*w).to_owned()).collect();
            words[which] = format!("{letter}{changed:.5}");
            lines[at] = words.join(" ");
        }
    }
    format!("line {}: {old:?} -> {:?}", at + 1, lines.get(at))
}

fn rewritten(slice: &Path, plan: &Path, output: &Path) -> Option<Vec<u8>> {
    let _ = std::fs::remove_file(output);
    let run =
        trunnion().arg("rewrite").arg(slice).arg("--plan").arg(plan).args(["-q", "-o"]).arg(output).output().unwrap();
    assert!(matches!(run.status.code(), Some(0..=2)), "{}", said(&run));
    assert_eq!(run.status.success(), output.is_file(), "{}", said(&run));
    run.status.success().then(|| std::fs::read(output).unwrap())
}

/// A slicer, and whether its checksum is left where it states one.
#[derive(Clone, Copy)]
enum Sliced {
    WithChecksum(&'static str),
    Without(&'static str),
}

fn changes_are_seen(model: &str, sliced: Sliced, seed: u64, unseen_mm3: f64) {
    let (Sliced::WithChecksum(slicer) | Sliced::Without(slicer)) = sliced;
    let program = if slicer == "cura" { "CuraEngine" } else { slicer };
    if slicer != "builtin" && !installed(program) {
        return skip(&format!("{program} is not installed: its slices are not changed at random"));
    }
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let plan = path("plan.json");
    let run = trunnion().args(["plan", &fixture(model), "-m", "generic-ac", "-q", "-o"]).arg(&plan).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let slots = path("slots");
    let run = trunnion().arg("slice").arg(&plan).args(["--slicer", slicer, "-q", "-o"]).arg(&slots).output().unwrap();
    if said(&run).contains("fdmprinter.def.json") {
        return skip("CuraEngine's definitions are not there: its slices are not changed at random");
    }
    assert!(run.status.success(), "{}", said(&run));
    let slice: PathBuf = std::fs::read_dir(&slots)
        .unwrap()
        .map(|f| f.unwrap().path())
        .find(|f| f.extension().is_some_and(|e| e == "gcode"))
        .unwrap();
    let mut whole: Vec<String> = std::fs::read_to_string(&slice).unwrap().lines().map(str::to_owned).collect();
    if matches!(sliced, Sliced::Without(_)) {
        whole.retain(|line| !line.starts_with("; crc32 = "));
    }
    let setting = setting();
    let original = laid(&rewritten(&slice, &plan, &path("whole.gcode")).expect("the slice as it is"), &setting);
    let mut numbers = Numbers::seeded(seed + soak().unwrap_or(0));
    let (mut seen, mut without_effect, mut worst) = (0, 0, (0.0, String::new()));
    let changes = if soak().is_some() { 60 * CHANGES } else { CHANGES };
    for _ in 0..changes {
        let mut lines = whole.clone();
        let what = mutate(&mut lines, &mut numbers);
        let changed = path("changed.gcode");
        std::fs::write(&changed, lines.join("\n") + "\n").unwrap();
        match rewritten(&changed, &plan, &path("out.gcode")) {
            None => seen += 1,
            Some(gcode) => {
                let moved = elsewhere(&original, &laid(&gcode, &setting));
                if moved > 0.1 && changes > CHANGES {
                    note(&format!("{moved:.2} mm3: {what}"));
                }
                if moved > worst.0 {
                    worst = (moved, what);
                }
                without_effect += 1;
            }
        }
    }
    note(&format!(
        "{model}, {slicer}: of {changes} random changes {seen} were refused, {without_effect} taken; at most {:.2} mm3 lie elsewhere",
        worst.0
    ));
    assert!(worst.0 <= unseen_mm3, "{model}, {slicer}: {}: {:.3} mm3 lie elsewhere, unseen", worst.1, worst.0);
    assert!(seen > changes / 3, "{model}, {slicer}: only {seen} of {changes} changes were seen");
}

#[test]
fn built_in_slices() {
    changes_are_seen("cube", Sliced::WithChecksum("builtin"), 11, 0.0);
}

#[test]
fn built_in_slices_without_their_checksum() {
    changes_are_seen("cube", Sliced::Without("builtin"), 11, INFILL_MM3);
}

#[test]
fn prusa_slicer_slices() {
    changes_are_seen("cube", Sliced::Without("prusa-slicer"), 12, UNSEEN_MM3);
}

#[test]
fn slic3r_slices() {
    changes_are_seen("cube", Sliced::Without("slic3r"), 13, UNSEEN_MM3);
}

#[test]
fn cura_slices() {
    changes_are_seen("cube", Sliced::Without("cura"), 14, INFILL_MM3);
}
