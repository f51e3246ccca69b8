//! A free form by the rule of the literature: facets alone, no head, neither beginnings nor ridges.

use trunnion::geom::{Object, Vec3};
use trunnion::mesh::{ReadOptions, TriangleMesh, read_model};
use trunnion::split::{CutOptions, NoHead, Plane, parted, split};

use crate::solids::lump;
use crate::support::{note, root, skip};

/// The bunny upright, 80 mm high, 2 mm of it cut off below so that it stands.
fn bunny() -> Option<TriangleMesh<Object>> {
    let file = root().join("../shared/data/meshes/castro/bunny.off");
    let bytes = std::fs::read(file).ok()?;
    let model = read_model(&bytes, "bunny.off", &ReadOptions::default()).unwrap();
    let mesh = &model.parts[0].mesh;
    let bounds = mesh.bounds();
    let scale = 80.0 / bounds.size().y;
    let upright = |v: &Vec3| {
        let at = (v - bounds.min) * scale;
        Vec3::new(at.x, -at.z, at.y - 2.0)
    };
    let whole = TriangleMesh::new(mesh.vertices().iter().map(upright).collect(), mesh.facets().to_vec());
    let mut above = parted(&whole, &Plane { normal: Vec3::z(), offset_mm: 0.0 }).unwrap().pieces;
    assert_eq!(above.len(), 1);
    above.pop()
}

#[test]
fn of_the_bunny_only_the_rim_at_the_table_stays_bare() {
    let Some(mesh) = bunny() else {
        skip("../shared/data is not there");
        return;
    };
    let none = NoHead { most_tilt: std::f64::consts::FRAC_PI_2 };
    let options = CutOptions { beam: 3, only_facets: true, ..CutOptions::default() };
    let found = split(&mesh, &none, &options, &mut |_| true);
    let doubled = |i: usize| {
        let [a, b, c] = mesh.corners(i);
        (b - a).cross(&(c - a)).norm()
    };
    let area = (0..mesh.facets().len()).map(doubled).sum::<f64>() / 2.0;
    let share = |mm2: f64| 100.0 * mm2 / area;
    let [before, after] = [found.before, found.after].map(|needs| share(needs.area_mm2));
    // No plane may go through the footprint.
    let above: f64 = found.left.iter().filter(|patch| patch.at.z > 4.0).map(|patch| patch.area_mm2).sum();
    let (cuts, above) = (found.cuts.len(), share(above));
    note(&format!(
        "bunny: {before:.2} % of the surface before, {after:.2} % after {cuts} cuts, {above:.2} % above 4 mm"
    ));
    assert!((before - 9.58).abs() < 0.05, "{before}");
    assert!(after < 3.7 && above < 0.15 && cuts <= 9, "{after} %, {above} % above 4 mm, {cuts} cuts");
}

/// The same count of a free form that is made here: what of its facets is steeper than 45 degrees was summed up in numpy.
#[test]
fn of_a_lump_the_bare_facets_are_those_that_numpy_counts() {
    let lump = lump(20, 1.0);
    let low = lump.bounds().min;
    let mesh = TriangleMesh::new(lump.vertices().iter().map(|v| v - low).collect(), lump.facets().to_vec());
    let none = NoHead { most_tilt: std::f64::consts::FRAC_PI_2 };
    let options = CutOptions { beam: 3, only_facets: true, max_cuts: 4, ..CutOptions::default() };
    let found = split(&mesh, &none, &options, &mut |_| true);
    let (before, after) = (found.before.area_mm2, found.after.area_mm2);
    assert!((before - 483.790).abs() < 0.01, "{before}");
    assert!(after <= before && found.cuts.len() <= 4, "{after} after {} cuts", found.cuts.len());
}
