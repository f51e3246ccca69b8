//! Brims, skirts, seams, arcs and waits of the profile, through the whole job: what is laid where, as another reader finds it in the file.

use std::path::Path;
use std::process::Output;

use super::shapes;
use crate::split::solids::{self, Shape};
use crate::support::{folder, installed, note, said, skip, states, trunnion};

/// A profile of `process` lines over `generic-ac`, and a model, prepared with more words.
fn prepared(folder: &Path, process: &str, model: &Shape, slicer: &str, more: &[&str]) -> (Output, String) {
    let (stl, machine, output) = (folder.join("model.stl"), folder.join("machine.toml"), folder.join("out.gcode"));
    std::fs::write(&stl, trunnion::mesh::stl_binary(&model.mesh())).unwrap();
    std::fs::write(&machine, format!("extends = \"generic-ac\"\n[process]\n{process}")).unwrap();
    let _ = std::fs::remove_file(&output);
    let args = ["--slicer", slicer, "--json", "-o"];
    let mut run = trunnion();
    let run = run.arg("prepare").arg(&stl).arg("-m").arg(&machine).args(args).arg(&output).args(more.iter().copied());
    let done = run.output().unwrap();
    (done, std::fs::read_to_string(&output).unwrap_or_default())
}

/// Ends of all lines that the file calls skirt or brim.
fn laid_around(text: &str) -> Vec<[f64; 3]> {
    let (mut at, mut around, mut found) = ([f64::NAN; 3], false, Vec::new());
    for line in text.lines() {
        if let Some(kind) = line.strip_prefix(";TYPE:") {
            around = kind.to_ascii_lowercase().starts_with("skirt");
        }
        let code = line.split(';').next().unwrap();
        let word = |letter: char| code.split_whitespace().find_map(|w| w.strip_prefix(letter)?.parse::<f64>().ok());
        if !code.starts_with("G1") {
            continue;
        }
        for (i, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            at[i] = word(letter).unwrap_or(at[i]);
        }
        if around && word('E').is_some_and(|e| e > 0.0) && (word('X').is_some() || word('Y').is_some()) {
            found.push(at);
        }
    }
    found
}

/// How far the nearest and the farthest of them lie from the square from `low` to `high`.
fn beyond(ends: &[[f64; 3]], low: f64, high: f64) -> [f64; 2] {
    let outside = |v: f64| (low - v).max(v - high).max(0.0);
    let by = ends.iter().map(|p| outside(p[0]).hypot(outside(p[1])));
    let outside = by.clone().filter(|mm| *mm > 0.0);
    [outside.fold(f64::INFINITY, f64::min), by.fold(f64::NEG_INFINITY, f64::max)]
}

fn warnings(done: &Output) -> Vec<String> {
    let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    document["warnings"].as_array().unwrap().iter().map(|w| w.as_str().unwrap().to_owned()).collect()
}

#[test]
fn brim_and_skirt_are_laid_by_each_slicer_that_marks_them_and_verified() {
    let folder = folder();
    let block = solids::block(20.0, 20.0, 3.0).at(-10.0, -10.0, 0.0);
    for slicer in ["builtin", "prusa-slicer", "cura", "slic3r"] {
        let there = match slicer {
            "builtin" => true,
            "cura" => crate::cura_engine::is_there(),
            other => installed(other),
        };
        if !there {
            skip(&format!("{slicer} is not installed: its brim and skirt are not tried"));
            continue;
        }
        for (process, reach) in [("brim_mm = 5.0\n", 5.0), ("skirt_loops = 2\nskirt_distance_mm = 4.0\n", 4.9)] {
            let (done, text) = prepared(folder.path(), process, &block, slicer, &[]);
            assert_eq!(done.status.code(), Some(0), "{slicer} {process}: {}", said(&done));
            let ends = laid_around(&text);
            if slicer == "slic3r" {
                assert!(ends.is_empty() && warnings(&done).iter().any(|w| states(w, "Slic3r | mark")));
                continue;
            }
            let heights: Vec<f64> = ends.iter().map(|p| p[2]).collect();
            let [nearest, farthest] = beyond(&ends, -10.0, 10.0);
            note(&format!(
                "{slicer}, {}: {} lines, {nearest:.2} to {farthest:.2} mm beyond the part",
                process.trim(),
                ends.len()
            ));
            assert!(heights.iter().all(|z| (z - heights[0]).abs() < 1e-9), "one layer");
            // Middles of lines, 0.45 mm wide.
            assert!((farthest - (reach - 0.225)).abs() < 0.5, "{slicer}: {farthest} mm for {reach}");
            assert!(process.starts_with("brim") == (nearest < 0.5), "{slicer}: {nearest}");
        }
    }
}

#[test]
fn a_brim_ends_halfway_to_the_next_part_and_at_the_rim_and_that_is_told() {
    let folder = folder();
    let block = solids::block(20.0, 20.0, 3.0);
    // 6 mm apart, and 0.8 mm: too near for a brim of one line.
    let three = [-33.4, -7.4, 13.4].map(|x| block.at(x, -10.0, 0.0));
    let three = three[0].and(&three[1]).and(&three[2]);
    let process = "brim_mm = 5.0\nskirt_loops = 1\nskirt_distance_mm = 3.0\n";
    let (done, text) = prepared(folder.path(), process, &three, "builtin", &[]);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    let told = warnings(&done).join("\n");
    assert!(states(&told, "2.50 mm | 5 mm") && states(&told, "0.00 mm | 5 mm"), "{told}");
    let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    // The nozzle's end, 0.5 mm, reaches 0.275 mm beyond the edge of the line that it lays; the brims are 1 mm apart.
    assert!(document["verify"]["clearance_mm"].as_f64().unwrap() > 0.1, "{}", document["verify"]["clearance_mm"]);
    let ends = laid_around(&text);
    let [left, middle] = [[-36.5, -33.4], [-10.4, -7.4]]
        .map(|[low, high]| ends.iter().filter(|p| p[0] > low && p[0] < high && p[1].abs() < 13.1).count());
    assert!(left > 0 && middle == 0, "{left} {middle}");
    // A plate whose corners come to 6.07 mm from where the table may carry something: 98 mm less 65 sqrt 2.
    let plate = solids::block(130.0, 130.0, 1.0).at(-65.0, -65.0, 0.0);
    let (done, text) = prepared(folder.path(), "brim_mm = 8.0\nskirt_loops = 1\n", &plate, "builtin", &[]);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    assert!(states(&warnings(&done).join("\n"), "6.08 mm | 8 mm | process.brim_mm | edge"));
    let [_, farthest] = beyond(&laid_around(&text), -65.0, 65.0);
    assert!((5.3..5.86).contains(&farthest), "{farthest}");
}

#[test]
fn only_what_stands_on_the_table_in_the_first_slot_has_a_brim() {
    let folder = folder();
    let machine = folder.path().join("machine.toml");
    std::fs::write(&machine, "extends = \"generic-ac\"\n[process]\nbrim_mm = 4.0\nskirt_loops = 1\n").unwrap();
    let output = folder.path().join("out.gcode");
    let model = crate::support::root().join("fixtures/y-tree.stl");
    let args = ["--slicer", "builtin", "-o"];
    let done = trunnion().arg("prepare").arg(model).arg("-m").arg(&machine).args(args).arg(&output).output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    let text = std::fs::read_to_string(&output).unwrap();
    let ends = laid_around(&text);
    assert!(!ends.is_empty() && ends.iter().all(|p| (p[2] - ends[0][2]).abs() < 1e-9));
}

#[test]
fn what_a_users_own_configuration_says_of_brim_and_skirt_is_done() {
    let folder = folder();
    let block = solids::block(20.0, 20.0, 3.0).at(-10.0, -10.0, 0.0);
    let config = folder.path().join("mine.ini");
    std::fs::write(
        &config,
        "brim_width = 3\nbrim_type = outer_only\nskirts = 1\nskirt_distance = 2\nskirt_height = 1\n",
    )
    .unwrap();
    for slicer in ["builtin", "prusa-slicer"] {
        if slicer != "builtin" && !installed(slicer) {
            skip("prusa-slicer is not installed: a brim of its configuration is not tried");
            continue;
        }
        let more = ["--slicer-config", config.to_str().unwrap()];
        let (done, text) = prepared(folder.path(), "", &block, slicer, &more);
        assert_eq!(done.status.code(), Some(0), "{slicer}: {}", said(&done));
        let [nearest, farthest] = beyond(&laid_around(&text), -10.0, 10.0);
        assert!(nearest < 0.5 && (4.4..6.0).contains(&farthest), "{slicer}: {nearest} {farthest}");
    }
}

#[test]
fn settings_that_are_none_are_refused_with_what_is_allowed() {
    let folder = folder();
    let block = solids::block(10.0, 10.0, 3.0);
    for (process, says) in [
        ("brim_mm = -1.0\n", "brim_mm = -1.0: must be 0..100 mm"),
        ("brim_mm = 101.0\n", "brim_mm = 101.0: must be 0..100 mm"),
        ("skirt_loops = 21\n", "skirt_loops = 21: must be 0..20"),
        ("skirt_distance_mm = 200.0\n", "skirt_distance_mm = 200.0: must be 0..100 mm"),
        ("seam = \"left\"\n", "left"),
        ("wait_beside = 3\n", "wait_beside"),
        ("brim_m = 3.0\n", "brim_mm"),
    ] {
        let (done, text) = prepared(folder.path(), process, &block, "builtin", &[]);
        assert!(done.status.code() == Some(2) && text.is_empty(), "{process}: {}", said(&done));
        assert!(said(&done).contains(says), "{process}: {}", said(&done));
    }
}

/// Seconds of the waits (G4) of a program for Marlin, and where the head stands in each.
fn waits(text: &str) -> Vec<(f64, [f64; 3])> {
    let (mut at, mut found) = ([f64::NAN; 3], Vec::new());
    for line in text.lines() {
        let code = line.split(';').next().unwrap();
        let word = |letter: char| code.split_whitespace().find_map(|w| w.strip_prefix(letter)?.parse::<f64>().ok());
        if code.starts_with("G1 ") {
            for (i, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
                at[i] = word(letter).unwrap_or(at[i]);
            }
        } else if code.starts_with("G4 ") {
            found.push((word('P').unwrap() / 1000.0, at));
        }
    }
    found
}

#[test]
fn the_head_waits_beside_a_pin_until_its_layer_has_taken_its_time() {
    let folder = folder();
    let pin = solids::rod(1.5, 6.0, 24);
    let seconds = |done: &Output| {
        let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        document["verify"]["seconds_print"].as_f64().unwrap()
    };
    let (done, text) = prepared(folder.path(), "wait_beside = false\n", &pin, "builtin", &["--way", "as-drawn"]);
    assert_eq!((done.status.code(), waits(&text).len()), (Some(0), 0), "{}", said(&done));
    let without = seconds(&done);
    for least in [2.0, 5.0, 8.0] {
        let process = format!("wait_beside = true\nmin_layer_s = {least:.1}\n");
        let (done, text) = prepared(folder.path(), &process, &pin, "builtin", &["--way", "as-drawn"]);
        assert_eq!(done.status.code(), Some(0), "{least}: {}", said(&done));
        let waits = waits(&text);
        note(&format!(
            "a layer of a 3 mm pin to take {least} s: {} waits, {:?} s",
            waits.len(),
            waits.first().map(|w| w.0)
        ));
        // 30 layers, between which there are 29 waits; 2 s are had by printing slower.
        assert_eq!(waits.len(), if least > 2.0 { 29 } else { 0 }, "{least}");
        assert!(seconds(&done) > if least > 2.0 { 29.0 * least } else { without - 20.0 }, "{}", seconds(&done));
        for (_, [x, y, z]) in waits {
            assert!(x.hypot(y) > 1.5 + 4.5 && z > 5.0, "beside and above: {x} {y} {z}");
        }
    }
    // Two that are printed together need not wait for each other's plastic.
    let two = pin.and(&pin.at(12.0, 0.0, 0.0));
    let (done, text) = prepared(folder.path(), "wait_beside = true\n", &two, "builtin", &["--way", "as-drawn"]);
    assert_eq!((done.status.code(), waits(&text).len()), (Some(0), 0), "{}", said(&done));
}

#[test]
fn waits_of_a_sliced_file_are_made_beside_the_part_from_half_a_second_on() {
    let folder = folder();
    let block = solids::block(20.0, 20.0, 3.0);
    std::fs::write(folder.path().join("model.stl"), trunnion::mesh::stl_binary(&block.mesh())).unwrap();
    let run = |words: &[&str]| {
        let mut command = trunnion();
        let done = command.current_dir(folder.path()).args(words.iter().copied()).output().unwrap();
        assert!(done.status.success(), "{words:?}: {}", said(&done));
        done
    };
    run(&["plan", "model.stl", "-m", "generic-ac", "-o", "plan.json"]);
    run(&["slice", "plan.json", "--slicer", "builtin", "-o", "slots"]);
    let slot = std::fs::read_dir(folder.path().join("slots")).unwrap().map(|e| e.unwrap().path());
    let slot = slot.into_iter().find(|path| path.extension().is_some_and(|e| e == "gcode")).unwrap();
    // As another slicer might have it: without our checksum.
    let text = std::fs::read_to_string(&slot).unwrap();
    let plain: String = text.lines().filter(|l| !l.contains("crc32")).map(|l| format!("{l}\n")).collect();
    for (milliseconds, made) in [(0, false), (499, false), (500, true), (2500, true)] {
        let nth = plain.match_indices(";LAYER_CHANGE").nth(5).unwrap().0;
        let waiting = format!("{}G4 P{milliseconds}\n{}", &plain[..nth], &plain[nth..]);
        let file = folder.path().join("waiting.gcode");
        std::fs::write(&file, waiting).unwrap();
        let done = run(&["rewrite", "waiting.gcode", "--plan", "plan.json", "-o", "out.gcode"]);
        let waits = waits(&std::fs::read_to_string(folder.path().join("out.gcode")).unwrap());
        assert_eq!(waits.len(), usize::from(made), "{milliseconds} ms");
        assert!(waits.iter().all(|(s, _)| (s * 1000.0 - f64::from(milliseconds)).abs() < 1e-9));
        assert_eq!(states(&said(&done), "beside | part"), made, "{}", said(&done));
    }
}

#[test]
fn a_round_part_as_arcs_is_verified_with_the_same_filament_and_fewer_lines() {
    let folder = folder();
    let shape = shapes::all().into_iter().find(|shape| shape.name == "cylinder").unwrap();
    let model = folder.path().join("cylinder.stl");
    std::fs::write(&model, trunnion::mesh::stl_binary(&shape.mesh)).unwrap();
    let made = |arcs: bool| {
        let (machine, output) = (folder.path().join("machine.toml"), folder.path().join("out.gcode"));
        std::fs::write(&machine, format!("extends = \"generic-ac\"\n[process]\narcs = {arcs}\n")).unwrap();
        let args = ["--slicer", "builtin", "--json", "-o"];
        let done = trunnion().arg("prepare").arg(&model).arg("-m").arg(&machine).args(args).arg(&output).output();
        let done = done.unwrap();
        assert_eq!(done.status.code(), Some(0), "arcs = {arcs}: {}", said(&done));
        let text = std::fs::read_to_string(&output).unwrap();
        let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        let count = |words: &[&str]| text.lines().filter(|l| words.iter().any(|w| l.starts_with(w))).count();
        let figure = |key: &str| document["verify"][key].as_f64().unwrap();
        (count(&["G1 "]), count(&["G2 ", "G3 "]), figure("filament_mm"), figure("seconds_print"))
    };
    let (plain, arcs) = (made(false), made(true));
    note(&format!("a cylinder: {} lines, none of them arcs; {} and {} arcs", plain.0, arcs.0, arcs.1));
    assert!(plain.1 == 0 && arcs.1 > 100 && 2 * (arcs.0 + arcs.1) < plain.0, "{plain:?} {arcs:?}");
    assert!((arcs.2 / plain.2 - 1.0).abs() < 0.001 && (arcs.3 / plain.3 - 1.0).abs() < 0.03, "{plain:?} {arcs:?}");
}

/// Where the first line of each outer wall begins.
fn seams(text: &str) -> Vec<[f64; 2]> {
    let (mut at, mut outer, mut found) = ([f64::NAN; 2], false, Vec::new());
    for line in text.lines() {
        if let Some(kind) = line.strip_prefix(";TYPE:") {
            outer = kind == "External perimeter";
        }
        let word = |letter: char| line.split_whitespace().find_map(|w| w.strip_prefix(letter)?.parse::<f64>().ok());
        if line.starts_with("G1 ") {
            if outer && word('E').is_some_and(|e| e > 0.0) {
                found.push(at);
                outer = false;
            }
            at = [word('X').unwrap_or(at[0]), word('Y').unwrap_or(at[1])];
        }
    }
    found
}

#[test]
fn seams_lie_where_the_profile_wants_them() {
    let folder = folder();
    // An L: its inner corner at (-5, -5), its rear at (-5, 15).
    let [foot, back] = [[30.0, 10.0], [10.0, 30.0]].map(|[x, y]| solids::block(x, y, 2.0).at(-15.0, -15.0, 0.0));
    let ell = foot.and(&back);
    let at = |rule: &str| {
        let (done, text) = prepared(folder.path(), &format!("seam = \"{rule}\"\n"), &ell, "builtin", &[]);
        assert_eq!(done.status.code(), Some(0), "{rule}: {}", said(&done));
        seams(&text)
    };
    let near = |seams: &[[f64; 2]], p: [f64; 2]| seams.iter().all(|s| (s[0] - p[0]).hypot(s[1] - p[1]) < 1.0);
    let (rear, corner, aligned, nearest) = (at("rear"), at("corner"), at("aligned"), at("nearest"));
    assert!(rear.len() == 10 && corner.len() == 10 && aligned.len() == 10, "{rear:?}");
    assert!(near(&rear, [-5.0, 15.0]), "{rear:?}");
    assert!(near(&corner, [-5.0, -5.0]) && near(&aligned, [-5.0, -5.0]), "{corner:?} {aligned:?}");
    assert!(!near(&nearest, nearest[0]), "wherever it comes from: {nearest:?}");
}
