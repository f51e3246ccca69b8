//! The built-in slicer obeys `--slicer-config` where it has a setting, and names the keys it has nothing for, once.

use std::path::Path;
use std::process::Output;

use super::raster;
use crate::split::solids;
use crate::support::{folder, installed, note, said, skip, states, trunnion};

fn prepared(folder: &Path, ini: &str) -> (Output, String) {
    let (model, config, output) = (folder.join("post.stl"), folder.join("mine.ini"), folder.join("out.gcode"));
    std::fs::write(&model, trunnion::mesh::stl_binary(&solids::block(20.0, 20.0, 6.0).mesh())).unwrap();
    std::fs::write(&config, ini).unwrap();
    let _ = std::fs::remove_file(&output);
    let args = ["-m", "generic-ac", "--slicer", "builtin", "--json", "--slicer-config"];
    let done = trunnion().arg("prepare").arg(&model).args(args).arg(&config).arg("-o").arg(&output).output().unwrap();
    (done, std::fs::read_to_string(&output).unwrap_or_default())
}

#[test]
fn a_configuration_is_obeyed_and_what_it_cannot_have_is_named_once() {
    let folder = folder();
    let ini = "layer_height = 0.3\nperimeters = 3\nextrusion_width = 0.5\nfill_density = 40%\nfill_pattern = gyroid\nraft_layers = 5\nnotes = x\n";
    let (done, text) = prepared(folder.path(), ini);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    let layers = text.lines().filter(|line| line.starts_with(";LAYER_CHANGE")).count();
    assert_eq!(layers, 20, "6 mm in layers of 0.3 mm");
    let widths: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix(";WIDTH:")).collect();
    assert!(widths.contains(&"0.5") && !widths.contains(&"0.45"), "{widths:?}");
    let stderr = String::from_utf8_lossy(&done.stderr).into_owned();
    assert_eq!(stderr.matches("fill_pattern, raft_layers").count(), 1, "{stderr}");
    let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    let warnings = document["warnings"].as_array().unwrap();
    let named = |warning: &&serde_json::Value| {
        states(warning.as_str().unwrap(), "2 | --slicer-config") && !warning.as_str().unwrap().contains("notes")
    };
    assert_eq!(warnings.iter().filter(named).count(), 1, "{warnings:?}");
}

#[test]
fn a_configuration_that_cannot_be_printed_is_refused_with_its_key() {
    let folder = folder();
    for (ini, said_so) in [
        ("layer_height = thick\n", "layer_height = `thick`: must be a number"),
        ("layer_height = 0.9\n", "process.layer_height_mm = 0.9: must be 0..0.4 mm"),
        ("fill_density = 140%\n", "process.infill = 1.4: must be 0..1"),
    ] {
        let (done, text) = prepared(folder.path(), ini);
        assert!(said(&done).contains(said_so) && text.is_empty(), "{ini}: {}", said(&done));
        assert_ne!(done.status.code(), Some(0));
    }
}

/// Of the machine's own file and of a configuration, through every slicer that there is: verified, and stiff in three directions.
#[test]
fn cubic_infill_is_printed_by_every_slicer() {
    let folder = folder();
    let (model, machine) = (folder.path().join("post.stl"), folder.path().join("machine.toml"));
    std::fs::write(&model, trunnion::mesh::stl_binary(&solids::block(40.0, 40.0, 12.0).mesh())).unwrap();
    let process = "[process]\ninfill_pattern = \"cubic\"\nbridge_flow = 0.9\n";
    std::fs::write(&machine, format!("extends = \"generic-ac\"\n{process}")).unwrap();
    for slicer in ["builtin", "prusa-slicer", "slic3r", "cura"] {
        let there = match slicer {
            "builtin" => true,
            "cura" => crate::cura_engine::is_there(),
            other => installed(other),
        };
        if !there {
            skip(&format!("{slicer} is not installed"));
            continue;
        }
        let output = folder.path().join(format!("{slicer}.gcode"));
        let (mut run, args) = (trunnion(), ["--slicer", slicer, "-o"]);
        let done = run.arg("prepare").arg(&model).arg("-m").arg(&machine).args(args).arg(&output).output().unwrap();
        assert_eq!(done.status.code(), Some(0), "{slicer}: {}", said(&done));
        let text = std::fs::read_to_string(&output).unwrap();
        let lines = raster::beads(&text);
        let mut heights: Vec<f64> = lines.iter().map(|line| line.z).collect();
        heights.sort_unstable_by(f64::total_cmp);
        let height = heights[heights.len() / 2];
        let middle = lines.iter().filter(|line| line.z == height && line.length() > 4.0);
        let mut angles: Vec<i64> = middle.map(|line| (line.direction_deg() / 5.0).round() as i64 % 36).collect();
        angles.sort_unstable();
        angles.dedup();
        note(&format!("{slicer}: directions {angles:?} of 5 degrees in the middle layer"));
        // Two of the walls, three of the cubes.
        assert!(angles.len() == 5, "{slicer}: {angles:?}");
    }
    std::fs::write(&machine, "extends = \"generic-ac\"\n[process]\ninfill_pattern = \"gyroid\"\n").unwrap();
    let output = folder.path().join("none.gcode");
    let done = trunnion().arg("prepare").arg(&model).arg("-m").arg(&machine).arg("-o").arg(&output).output().unwrap();
    assert!(said(&done).contains("gyroid") && said(&done).contains("cubic") && !output.exists(), "{}", said(&done));
}
