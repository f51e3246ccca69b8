//! Meshes that nobody here made: what `split` calls printable is printed, and what it refuses is refused by name.

use trunnion::geom::Object;
use trunnion::mesh::{ReadOptions, TriangleMesh, read_model, stl_binary};

use crate::support::{first_error, folder, installed, note, root, said, skip, trunnion};

/// File, and its longest edge, mm; those that take more than a few seconds (arm, bunny, horse, max) are looked at by hand.
const MESHES: [(&str, f64); 11] = [
    ("puri/cube.stl", 20.0),
    ("puri/frustum.stl", 10.0),
    ("puri/cut cylinder.stl", 24.3),
    ("puri/conic frustum.stl", 24.0),
    ("puri/battery mount.stl", 78.6),
    ("puri/bullet.stl", 29.9),
    ("puri/death star.stl", 60.0),
    ("puri/reuleaux tetrahedron.stl", 60.0),
    ("castro/decimated-knight.off", 60.0),
    ("castro/camel_b.obj", 80.0),
    ("castro/cow.off", 80.0),
];

fn scaled(mesh: &TriangleMesh<Object>, longest: f64) -> TriangleMesh<Object> {
    let bounds = mesh.bounds();
    let scale = longest / bounds.size().max();
    TriangleMesh::new(mesh.vertices().iter().map(|v| (v - bounds.min) * scale).collect(), mesh.facets().to_vec())
}

#[test]
fn what_is_called_printable_is_printed_and_the_rest_refused_by_name() {
    let meshes = root().join("../shared/data/meshes");
    if !meshes.exists() {
        skip("../shared/data is not there");
        return;
    }
    let slicers = ["builtin", "prusa-slicer"].into_iter().filter(|slicer| *slicer == "builtin" || installed(slicer));
    let slicers: Vec<&str> = slicers.collect();
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let mut printed = 0;
    for (file, longest) in MESHES {
        let bytes = std::fs::read(meshes.join(file)).unwrap();
        let name = file.rsplit('/').next().unwrap();
        let model = read_model(&bytes, name, &ReadOptions::default()).unwrap();
        std::fs::write(path("solid.stl"), stl_binary(&scaled(&model.parts[0].mesh, longest))).unwrap();
        let words = ["--unit", "mm", "-m", "generic-ac", "-o"];
        let split = trunnion().arg("split").arg(path("solid.stl")).args(words).arg(path("parts.3mf")).output().unwrap();
        if split.status.success() {
            for slicer in &slicers {
                let mut prepare = trunnion();
                prepare.arg("prepare").arg(path("parts.3mf")).args(["-m", "generic-ac", "--slicer", slicer]);
                prepare.args(["--split", "never", "--supports", "never", "-o"]).arg(path("out.gcode"));
                let done = prepare.output().unwrap();
                assert!(done.status.success(), "{file}, {slicer}: {}", said(&done));
            }
            std::fs::remove_file(path("parts.3mf")).unwrap();
            printed += 1;
        } else {
            let words = said(&split);
            let why = first_error(&words).1;
            assert!(split.status.code() == Some(1) && why.contains("mm2 still need support"), "{file}: {words}");
            assert!(why.contains("--allow") && !path("parts.3mf").exists(), "{file}: {words}");
            note(&format!("{file}: {why}"));
        }
    }
    assert!(printed >= 5, "only {printed} are printed");
}
