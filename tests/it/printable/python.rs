//! Volume, centre of mass, first layer and tipping angle by trimesh (`benches/compare/printable_trimesh.py`): other code, another reader.

use std::io::Write as _;
use std::process::{Command, Stdio};

use trunnion::geom::Vec3;
use trunnion::mesh::{ReadOptions, Repair, Unit, read_surface, stl_binary};
use trunnion::orient::{Facets, FirstLayer, Height, Objective};

use super::LAYER_MM;
use super::shapes::shapes;
use crate::orient::meshes;
use crate::orient_sample::anywhere;
use crate::support::{Numbers, folder, python, root, skip};

/// Relative to the larger of the value and the part's own: both read single precision.
const AGREES: f64 = 1e-6;

#[test]
fn trimesh_has_the_same_first_layers() {
    let Some(python) = python(&["python3", "/usr/bin/python3"], "trimesh") else {
        return skip(
            "no python3 with trimesh: the price's parts have no witness of other code but the tests' own rays",
        );
    };
    let folder = folder();
    let mut files = Vec::new();
    for shape in shapes() {
        let path = folder.path().join(format!("{}.stl", shape.name.replace(' ', "-")));
        std::fs::write(&path, stl_binary(&shape.mesh)).unwrap();
        files.push((path, shape.ups));
    }
    if let Some(seeds) = meshes() {
        files.push((seeds.join("puri/battery mount.stl"), vec![Vec3::z()]));
    }
    let mut numbers = Numbers::seeded(21);
    for (file, mut ups) in files {
        ups.extend((0..4).map(|_| anywhere(&mut numbers)));
        let mut command = Command::new(&python);
        command.arg(root().join("benches/compare/printable_trimesh.py")).arg(&file).arg(LAYER_MM.to_string());
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut input = child.stdin.take().unwrap();
        ups.iter().for_each(|up| writeln!(input, "{:?} {:?} {:?}", up.x, up.y, up.z).unwrap());
        drop(input);
        let output = child.wait_with_output().unwrap();
        let name = file.file_name().unwrap().to_str().unwrap();
        assert!(output.status.success(), "{name}");
        let seen: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
        let facets = Facets::of(&read_surface(&std::fs::read(&file).unwrap(), name, &options).unwrap());
        let mass = facets.mass();
        let near = |ours: f64, theirs: &serde_json::Value, size: f64, what: &str| {
            let theirs = theirs.as_f64().unwrap();
            assert!((ours - theirs).abs() <= AGREES * (theirs.abs() + size), "{name} {what}: {ours} for {theirs}");
        };
        near(mass.volume_mm3, &seen["volume_mm3"], 0.0, "volume");
        near(mass.area_mm2, &seen["area_mm2"], 0.0, "area");
        (0..3).for_each(|k| near(mass.centre[k], &seen["centre_mm"][k], 10.0, "centre"));
        for (up, pose) in ups.iter().zip(seen["poses"].as_array().unwrap()) {
            let footing = FirstLayer::of(&facets, mass, up, LAYER_MM);
            near(footing.area_mm2, &pose["footprint_mm2"], 1.0, &format!("footprint at {up:?}"));
            near(footing.tipping_deg, &pose["tipping_deg"], 90.0, &format!("tipping at {up:?}"));
            near(Height.value(&facets, up), &pose["height_mm"], 1.0, "height");
        }
    }
}
