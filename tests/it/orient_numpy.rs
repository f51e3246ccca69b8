//! The objectives in plain numpy (`benches/compare/orient_numpy.py`) as a witness: other code, another reader, the same values.

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use trunnion::geom::Vec3;
use trunnion::mesh::{ReadOptions, Repair, Unit, read_surface, stl_binary};
use trunnion::orient::{Facets, ObjectiveSettings, objective};

use crate::orient::meshes;
use crate::orient_sample::anywhere;
use crate::solids::twenty;
use crate::support::{Numbers, folder, python, root, skip};

/// Relative to the largest value of the objective among the directions tried.
const AGREES: f64 = 1e-9;

#[test]
fn numpy_has_the_same_values() {
    let Some(python) = python(&["python3", "/usr/bin/python3"], "numpy") else {
        return skip("no python3 with numpy: objectives have no witness of other code");
    };
    let folder = folder();
    let mut files = Vec::new();
    for (i, (_, mesh)) in twenty().iter().enumerate() {
        let path = folder.path().join(format!("solid-{i}.stl"));
        std::fs::write(&path, stl_binary(mesh)).unwrap();
        files.push(path);
    }
    if let Some(seeds) = meshes() {
        files.extend(["decimated-knight.off", "horse_quad.obj"].map(|name| seeds.join("castro").join(name)));
    }
    let mut numbers = Numbers::seeded(9);
    let ups: Vec<Vec3> = (0..40).map(|_| anywhere(&mut numbers)).collect();
    for file in &files {
        agree(&python, file, &ups);
    }
}

fn agree(python: &Path, file: &Path, ups: &[Vec3]) {
    let script = root().join("benches/compare/orient_numpy.py");
    let mut command = Command::new(python);
    command.arg(script).arg("values").arg(file).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    ups.iter().for_each(|up| writeln!(input, "{:?} {:?} {:?}", up.x, up.y, up.z).unwrap());
    drop(input);
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", file.display());
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
    let name = file.file_name().unwrap().to_str().unwrap();
    let facets = Facets::of(&read_surface(&std::fs::read(file).unwrap(), name, &options).unwrap());
    let all = document.as_object().unwrap();
    assert_eq!(all.len(), 8);
    for (objective_name, values) in all {
        let f = objective(objective_name, &ObjectiveSettings::default()).unwrap();
        let values: Vec<f64> = values.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        let scale = values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        for (up, value) in ups.iter().zip(&values) {
            let ours = f.value(&facets, up);
            assert!((ours - value).abs() <= AGREES * scale, "{objective_name} of {name} at {up:?}: {ours} for {value}");
        }
    }
}
