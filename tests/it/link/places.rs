//! Re-entries after a reset, at random places of three prints, a thin tower among them (six; twenty in a soak): each is offered, carried out, clear and
//! carried by what was really printed, and owns up to what is missing or laid twice.
//!
//! What was really printed is taken from the simulated printer's own log of where its moves ended, not from what the host believes.

use std::path::{Path, PathBuf};

use super::real::{output, profile, wanted};
use super::reentry::{prepared_of, reset_at};
use crate::support::{Numbers, folder, note, root, said, soak, trunnion};

/// A post of 4 x 4 x 9 mm: a layer has hardly more lines than a planner holds.
fn tower(dir: &Path) -> PathBuf {
    let corner = |i: usize| [(i & 1) as f64 * 4.0, (i >> 1 & 1) as f64 * 4.0, (i >> 2 & 1) as f64 * 9.0];
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = "solid tower\n".to_owned();
    for [a, b, c, d] in quads {
        for triangle in [[a, b, c], [a, c, d]] {
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in triangle.map(corner) {
                text += &format!("vertex {x} {y} {z}\n");
            }
            text += "endloop\nendfacet\n";
        }
    }
    let path = dir.join("tower.stl");
    std::fs::write(&path, text + "endsolid tower\n").unwrap();
    path
}

/// The moves of a file: its line from 0, where the tip is behind it, what was extruded up to there, and the length that it lays.
fn moves(lines: &[&str]) -> Vec<(usize, [f64; 3], f64, f64)> {
    let (mut at, mut extruded, mut found) = ([0.0; 3], 0.0, Vec::new());
    for (index, line) in lines.iter().enumerate() {
        let code = line.split(';').next().unwrap();
        if !code.starts_with("G1 ") && !code.starts_with("G0 ") {
            continue;
        }
        let (from, mut pushed) = (at, 0.0);
        for word in code.split_whitespace().skip(1) {
            let value: f64 = word[1..].parse().unwrap();
            match word.as_bytes()[0] {
                letter @ b'X'..=b'Z' => at[usize::from(letter - b'X')] = value,
                b'E' => pushed = value,
                _ => {}
            }
        }
        extruded += pushed;
        let length = (0..3).map(|i| (at[i] - from[i]).powi(2)).sum::<f64>().sqrt();
        found.push((index, at, extruded, if pushed > 0.0 { length } else { 0.0 }));
    }
    found
}

/// The file's line behind which the printer's last whole move ended before its reset.
fn really_printed(log: &Path, lines: &[&str]) -> usize {
    let text = std::fs::read_to_string(log).unwrap();
    let before = text.split("restarted").next().unwrap();
    let pose = before.lines().rev().find_map(|l| l.split_once(" pose ")).unwrap().1;
    let pose: Vec<f64> = pose.split(' ').map(|v| v.parse().unwrap()).collect();
    let fits = |(_, at, e, _): &&(usize, [f64; 3], f64, f64)| {
        (0..3).all(|i| (at[i] - pose[i]).abs() < 2e-3) && (e - pose[5]).abs() < 2e-3
    };
    let all = moves(lines);
    all.iter().rev().find(fits).unwrap_or_else(|| panic!("no move ends at {pose:?}")).0
}

/// The two lengths that the host owns up to, mm: missing, laid twice.
fn owned(said: &str) -> [f64; 2] {
    let (_, text) = said.split_once("continue at line ").unwrap();
    let text = text.split_once("; ").unwrap().1;
    let (missing, twice) = text.split_once(" can be missing, ").unwrap();
    [missing, twice]
        .map(|text| text.strip_prefix("at most ").map_or(0.0, |t| t.split(' ').next().unwrap().parse().unwrap()))
}

#[test]
fn re_entries_at_random_places_are_offered_clear_and_carried() {
    let dir = folder();
    let machine = profile(dir.path());
    let models =
        [(root().join("fixtures/two-boxes.stl"), 7), (root().join("fixtures/y-tree.stl"), 6), (tower(dir.path()), 7)];
    // A place of each in the suite.
    let models = models.map(|(model, count)| (model, if soak().is_some() { count } else { 2 }));
    let mut numbers = Numbers::seeded(17 + soak().unwrap_or(0));
    let (mut missing, mut twice, mut lost) = (Vec::new(), Vec::new(), Vec::new());
    for (model, count) in models {
        let file = prepared_of(dir.path(), &machine, &model);
        let text = std::fs::read_to_string(&file).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let all = wanted(&file);
        for _ in 0..count {
            let block = (all.len() as f64 * numbers.between(0.05, 0.98)) as u32;
            let name = format!("{} at {block} of {}", model.file_stem().unwrap().display(), all.len());
            let (resumed, _, after) = reset_at(dir.path(), &machine, &file, block + block / 32);
            assert!(resumed.status.success(), "{name}: {}", said(&resumed));
            let log = dir.path().join("sim.log");
            let printed = really_printed(&log, &lines);
            let tail = after.iter().rev().zip(all.iter().rev()).take_while(|(a, w)| a == w).count();
            let again = {
                // The file's line of the first block that was printed again.
                let blocks = lines.iter().enumerate().filter(|(_, l)| !l.is_empty() && !l.starts_with(';'));
                blocks.map(|(i, _)| i).nth(all.len() - tail).unwrap()
            };
            let laid = |from: usize, to: usize| -> f64 {
                moves(&lines).iter().filter(|(i, ..)| (from..to).contains(i)).map(|(.., length)| length).sum()
            };
            let found = [laid(printed + 1, again), laid(again, printed + 1)];
            let told = owned(&said(&resumed));
            for i in 0..2 {
                assert!(found[i] <= told[i] + 0.06, "{name}: {found:?} mm, told {told:?}");
            }
            missing.push(found[0]);
            twice.push(found[1]);
            lost.push(moves(&lines).iter().filter(|(i, ..)| (printed + 1..again).contains(i)).count() as f64);
            // What was really printed, the way back, and the rest, before the verifier.
            let own = &after[..after.len() - tail];
            let mut whole: Vec<String> = lines[..=printed].iter().map(|l| (*l).to_owned()).collect();
            whole.push("M84".to_owned());
            let ours = |l: &&String| {
                ["G28", "G90", "G91", "M82", "M83", "G1Z", "G1X", "G1A", "G1C"].iter().any(|w| l.starts_with(w))
                    && !l.contains('E')
            };
            whole.extend(own.iter().filter(ours).cloned());
            let begun = whole.len();
            whole.extend(
                lines[printed.min(again)..again].iter().filter(|l| l.starts_with(';')).map(|l| (*l).to_owned()),
            );
            whole.extend(lines[again..].iter().map(|l| (*l).to_owned()));
            let joined = dir.path().join("joined.gcode");
            std::fs::write(&joined, whole.join("\n") + "\n").unwrap();
            let plan = dir.path().join("plan.json");
            let done = output(trunnion().arg("verify").arg(&joined).arg("--plan").arg(plan).arg("--json"));
            let report: serde_json::Value =
                serde_json::from_slice(&done.stdout).unwrap_or_else(|e| panic!("{e}: {}", said(&done)));
            let bad: Vec<&serde_json::Value> = report["findings"]
                .as_array()
                .unwrap()
                .iter()
                .filter(|f| {
                    let rule = f["rule"].as_str().unwrap();
                    let behind = f["line"].as_u64().unwrap() as usize > begun;
                    rule == "head-collision"
                        || (behind && ["in-air", "turn-collision", "axis-limit", "unknown-position"].contains(&rule))
                })
                .collect();
            assert!(bad.is_empty(), "{name}: {bad:?}");
        }
    }
    // What was sent and not printed, in moves: the planner's 16 and the window's lines, whatever the host does.
    assert!(lost.iter().all(|moves| *moves <= 16.0 + 6.0), "{lost:?}");
    note(&format!(
        "20 re-entries: missing mm {}; moves {}; laid twice mm {}",
        spread(missing),
        spread(lost),
        spread(twice)
    ));
}

/// Least, quartiles and most, and the mean.
fn spread(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize].max(0.0);
    let mean = (values.iter().sum::<f64>() / values.len() as f64).max(0.0);
    format!("{:.0} {:.0} {:.0} {:.0} {:.0}, mean {mean:.0}", at(0.0), at(0.25), at(0.5), at(0.75), at(1.0))
}
