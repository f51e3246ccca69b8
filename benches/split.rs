//! Cutting solids into parts: first what comes of each, then how long it takes.
//!
//! `RAYON_NUM_THREADS=1 cargo bench -p trunnion-benches --bench split` prints CPU times. The latest figures are in docs/explanation/measurements.md.

#[allow(dead_code)]
#[path = "../tests/it/split/solids.rs"]
mod solids;

use std::fmt::Write as _;
use std::io::Write as _;

use divan::Bencher;
use trunnion::geom::{Angle, Object};
use trunnion::mesh::{Model, TriangleMesh};
use trunnion::planning::{OnePrint, centred};
use trunnion::profile::{resolve, shipped};
use trunnion::split::{CutOptions, Split, split};

const NAMES: [&str; 8] = ["tee", "mushroom", "hook", "bracket", "wye", "tee-pipe", "wye-pipe", "menorah"];

fn main() {
    let mut said = String::new();
    for solid in solids::all() {
        let mesh = solid.shape.mesh();
        let found = cut(&mesh);
        let _ = writeln!(
            said,
            "{}: {} facets, {:.1} mm2 before, {:.2} after {} cuts (known: {}), seams {:.0} mm2, printable: {}",
            solid.name,
            mesh.facets().len(),
            found.before.area_mm2,
            found.after.area_mm2,
            found.cuts.len(),
            solid.cuts,
            found.seam_mm2(),
            found.printable
        );
    }
    let _ = std::io::stdout().write_all(said.as_bytes());
    divan::main();
}

fn cut(mesh: &TriangleMesh<Object>) -> Split {
    let (file, text) = shipped("generic-ac").expect("shipped");
    let profile = resolve(file, text).expect("resolves").0;
    let model = Model::from_parts(vec![("solid".to_owned(), mesh.clone())]);
    let placement = centred(&model, &profile).expect("it stands on the table");
    let overhang = Angle::from_deg(45.0);
    let head = OnePrint::new(&profile, placement, overhang, 0.5);
    split(mesh, &head, &CutOptions::default(), &mut |_| true)
}

#[divan::bench(args = NAMES, sample_count = 3, sample_size = 1)]
fn cuts(bencher: Bencher<'_, '_>, name: &str) {
    let solid = solids::all().into_iter().find(|s| s.name == name).expect("a known name");
    let mesh = solid.shape.mesh();
    bencher.bench_local(|| cut(&mesh));
}
