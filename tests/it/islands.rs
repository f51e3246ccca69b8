//! An island left out of one layer is found: pins of several widths on a plate, one layer of one pin taken out of the final file,
//! with the header made to agree.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;
use trunnion::mesh::stl_binary;

use crate::pipeline::prepare;
use crate::split::solids::block;
use crate::support::{folder, installed, note, said, skip, trunnion};

/// Sides of the square pins, mm.
const PINS: [f64; 6] = [0.8, 1.0, 1.2, 1.5, 2.0, 3.0];
/// From this side on a pin that is missing from one layer must be found, mm.
const FOUND_FROM: f64 = 1.0;

/// A plate with the pins in a row along x, 6 mm apart.
fn plate_with(pins: &[f64], path: &Path) {
    let long = 6.0 * pins.len() as f64 + 4.0;
    let plate = block(long, 10.0, 2.0);
    let all = pins.iter().enumerate().fold(plate, |all, (k, side)| {
        let middle = 5.0 + 6.0 * k as f64;
        all.and(&block(*side, *side, 5.0).at(middle - side / 2.0, 5.0 - side / 2.0, 0.0))
    });
    std::fs::write(path, stl_binary(&all.mesh())).unwrap();
}

fn word(line: &str, letter: char) -> Option<f64> {
    line.split(' ').find_map(|w| w.strip_prefix(letter)?.parse().ok())
}

/// One island of one layer: the lines that lay it, and their ends along the row.
struct Island {
    lines: Vec<usize>,
    ends: [f64; 2],
}

impl Island {
    fn wide(&self) -> f64 {
        self.ends[1] - self.ends[0]
    }

    fn middle(&self) -> f64 {
        (self.ends[0] + self.ends[1]) / 2.0
    }
}

/// The islands of the layer whose tip is nearest to `z`, with the travels to them.
fn islands(text: &[&str], z: f64) -> Vec<Island> {
    let (mut at, mut all) = ([0.0; 3], Vec::<([f64; 2], Vec<usize>)>::new());
    let mut laid: Vec<(usize, [f64; 3], bool)> = Vec::new();
    for (i, line) in text.iter().enumerate().filter(|(_, l)| l.starts_with('G')) {
        for (axis, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            at[axis] = word(line, letter).unwrap_or(at[axis]);
        }
        if word(line, 'X').is_some() || word(line, 'Y').is_some() {
            laid.push((i, at, word(line, 'E').is_some_and(|e| e > 0.0)));
        }
    }
    let near = |p: &[f64; 3]| (p[2] - z).abs() < 0.05;
    let along = |axis: usize| {
        let all = laid.iter().filter(|(_, p, lays)| *lays && near(p)).map(|(_, p, _)| p[axis]);
        all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
    };
    let axis = usize::from(along(1) > along(0));
    for (_, p, _) in laid.iter().filter(|(_, p, lays)| *lays && near(p)) {
        match all.iter_mut().find(|([low, high], _)| p[axis] > low - 2.0 && p[axis] < high + 2.0) {
            Some((range, _)) => *range = [range[0].min(p[axis]), range[1].max(p[axis])],
            None => all.push(([p[axis]; 2], Vec::new())),
        }
    }
    for ([low, high], lines) in &mut all {
        let own = laid.iter().filter(|(_, p, _)| near(p) && p[axis] > *low - 0.6 && p[axis] < *high + 0.6);
        lines.extend(own.map(|(i, ..)| *i));
    }
    all.into_iter().map(|(ends, lines)| Island { lines, ends }).collect()
}

/// The file without these lines, the header's filament made to agree.
fn without(text: &[&str], lines: &[usize]) -> String {
    let less: f64 = lines.iter().filter_map(|&i| word(text[i], 'E')).sum();
    let kept = text.iter().enumerate().filter(|(i, _)| !lines.contains(i)).map(|(_, line)| {
        let words = line.split(' ').map(|w| match w.strip_prefix("filament_mm=") {
            Some(mm) if line.starts_with(";TRUNNION expect") => {
                format!("filament_mm={:.5}", mm.parse::<f64>().unwrap() - less)
            }
            _ => w.to_owned(),
        });
        words.collect::<Vec<_>>().join(" ")
    });
    kept.collect::<Vec<_>>().join("\n") + "\n"
}

fn found(file: &Path, plan: &Path) -> Vec<String> {
    let run = trunnion().arg("verify").arg(file).arg("--plan").arg(plan).arg("--json").output().unwrap();
    let report: Value = serde_json::from_slice(&run.stdout).unwrap_or_else(|_| panic!("{}", said(&run)));
    report["findings"].as_array().unwrap().iter().map(|f| f["rule"].as_str().unwrap().to_owned()).collect()
}

fn left_out(slicer: &str, pins: &[f64]) {
    if slicer != "builtin" && !installed(slicer) {
        return skip(&format!("{slicer} is not installed: no island is left out of its files"));
    }
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let (model, whole, plan, changed) = (path("pins.stl"), path("pins.gcode"), path("plan.json"), path("c.gcode"));
    plate_with(pins, &model);
    let more = ["--plan-out", &plan.display().to_string()];
    prepare(&model.display().to_string(), "generic-ac", slicer, &whole, &more);
    let text = std::fs::read_to_string(&whole).unwrap();
    let text: Vec<&str> = text.lines().collect();
    let mut table = String::new();
    for z in [2.6, 3.4, 4.2] {
        let islands = islands(&text, z);
        // The widest is the last of its row, whichever way that runs; what is too thin for a slicer is in none of its layers.
        let last = islands.iter().max_by(|a, b| a.wide().total_cmp(&b.wide())).unwrap().middle();
        for island in &islands {
            let side = &pins[pins.len() - 1 - ((island.middle() - last).abs() / 6.0).round() as usize];
            std::fs::write(&changed, without(&text, &island.lines)).unwrap();
            let rules = found(&changed, &plan);
            let _ = writeln!(table, "  pin of {side} mm, missing at Z {z:.1}: {}", rules.join(", "));
            assert!(!rules.is_empty() || *side < FOUND_FROM, "{slicer}: pin of {side} mm, Z {z}\n{table}");
        }
    }
    note(&format!("islands left out, {slicer}, {} of a row\n{table}", pins.len()));
}

#[test]
fn a_pin_left_out_of_one_layer_of_a_built_in_slice_is_found() {
    left_out("builtin", &PINS);
    left_out("builtin", &[1.2]);
}

#[test]
fn a_pin_left_out_of_one_layer_of_a_prusa_slicer_slice_is_found() {
    left_out("prusa-slicer", &PINS);
    left_out("prusa-slicer", &[1.2]);
}

#[test]
fn a_pin_left_out_of_one_layer_of_a_slic3r_slice_is_found() {
    left_out("slic3r", &PINS);
    left_out("slic3r", &[1.2]);
}
