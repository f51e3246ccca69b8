//! Orientation: proofs and searches on made-up parts, and on the documents' meshes where `TRUNNION_MESHES` says they are.
//!
//! `cargo bench -p trunnion-benches --bench orient` prints the times; the latest figures are in docs/explanation/measurements.md. Run on one thread
//! (`RAYON_NUM_THREADS=1`) the times are CPU times. Gathering the facets is part of every figure, reading a file is not.
#![expect(clippy::print_stderr, reason = "what was proved belongs beside how long it took")]

use divan::Bencher;
use trunnion::geom::{Object, Vec3};
use trunnion::mesh::{ReadOptions, Repair, TriangleMesh, Unit, read_surface};
use trunnion::orient::{Certified, Facets, Found, ObjectiveSettings, Process, Search, objective, recommend};

fn main() {
    if std::env::var_os("TRUNNION_MESHES").is_none() {
        eprintln!("SKIPPED: the documents' meshes (TRUNNION_MESHES says where they are)");
    }
    divan::main();
}

/// A lump with `2 rings^2` facets about: a sphere of 30 mm with waves.
fn lump(rings: usize) -> TriangleMesh<Object> {
    use std::f64::consts::PI;
    let turns = rings;
    let at = |i: usize, j: usize| {
        let (polar, turn) = (PI * i as f64 / rings as f64, 2.0 * PI * j as f64 / turns as f64);
        let d = Vec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos());
        let wave = (5.0 * d.x + 1.0).sin() * (4.0 * d.y).cos() + 0.5 * (7.0 * d.z + 2.0 * d.x).sin();
        d * (30.0 + 4.0 * wave)
    };
    let mut points = vec![at(0, 0)];
    points.extend((1..rings).flat_map(|i| (0..turns).map(move |j| (i, j))).map(|(i, j)| at(i, j)));
    points.push(at(rings, 0));
    let (last, index) = (points.len() as u32 - 1, |i: usize, j: usize| (1 + (i - 1) * turns + j % turns) as u32);
    let mut facets = Vec::new();
    for j in 0..turns {
        facets.push([0, index(1, j), index(1, j + 1)]);
        facets.push([last, index(rings - 1, j + 1), index(rings - 1, j)]);
        for i in 1..rings - 1 {
            let quad = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            facets.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
        }
    }
    TriangleMesh::new(points, facets)
}

/// The part: `lump <rings>`, or a file of the documents' meshes.
fn part(name: &str) -> Option<TriangleMesh<Object>> {
    if let Some(rings) = name.strip_prefix("lump ") {
        return Some(lump(rings.parse().expect("a number")));
    }
    let file = std::path::Path::new(&std::env::var_os("TRUNNION_MESHES")?).join(name);
    let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
    Some(read_surface(&std::fs::read(file).ok()?, name, &options).expect("reads"))
}

fn proved(mesh: &TriangleMesh<Object>, name: &str) -> Found {
    let f = objective(name, &ObjectiveSettings::default()).expect("known");
    Certified { gap: goal(name), ..Certified::default() }.search(f.as_ref(), &Facets::of(mesh))
}

fn goal(name: &str) -> f64 {
    if matches!(name, "tanh-overhang" | "support-volume-convex") { 1e-3 } else { 1e-6 }
}

const PARTS: [&str; 8] = [
    "lump 91",
    "castro/arm.obj",
    "castro/horse_quad.obj",
    "castro/decimated-max.obj",
    "castro/decimated-knight.off",
    "castro/bunny.off",
    "castro/camel_b.obj",
    "castro/cow.off",
];

fn bench(bencher: Bencher<'_, '_>, part_name: &str, name: &str) {
    let Some(mesh) = part(part_name) else { return bencher.bench(|| ()) };
    let found = proved(&mesh, name);
    let (best, bound) = (found.minima[0].value, found.lower_bound.unwrap_or(f64::NAN));
    eprintln!("  {part_name} {name}: {best} gap {:.1e}, {} evaluations", (best - bound) / best, found.evaluations);
    bencher.bench(|| proved(&mesh, name));
}

#[divan::bench(args = PARTS, sample_count = 3, sample_size = 1)]
fn weighted_normal_z(bencher: Bencher<'_, '_>, part: &str) {
    bench(bencher, part, "weighted-normal-z");
}

#[divan::bench(args = PARTS, sample_count = 3, sample_size = 1)]
fn staircase(bencher: Bencher<'_, '_>, part: &str) {
    bench(bencher, part, "staircase");
}

#[divan::bench(args = PARTS, sample_count = 3, sample_size = 1)]
fn support_area(bencher: Bencher<'_, '_>, part: &str) {
    bench(bencher, part, "support-area");
}

#[divan::bench(args = PARTS, sample_count = 3, sample_size = 1)]
fn height(bencher: Bencher<'_, '_>, part: &str) {
    bench(bencher, part, "height");
}

#[divan::bench(args = PARTS, sample_count = 3, sample_size = 1)]
fn overhang_angle(bencher: Bencher<'_, '_>, part: &str) {
    bench(bencher, part, "overhang-angle");
}

#[divan::bench(args = PARTS, sample_count = 3, sample_size = 1)]
fn normal_z(bencher: Bencher<'_, '_>, part: &str) {
    bench(bencher, part, "normal-z");
}

#[divan::bench(args = PARTS, sample_count = 1, sample_size = 1)]
fn support_volume_convex(bencher: Bencher<'_, '_>, part: &str) {
    bench(bencher, part, "support-volume-convex");
}

#[divan::bench(args = PARTS, sample_count = 1, sample_size = 1)]
fn tanh_overhang(bencher: Bencher<'_, '_>, part: &str) {
    bench(bencher, part, "tanh-overhang");
}

#[divan::bench(args = PARTS, sample_count = 1, sample_size = 1)]
fn contact_area(bencher: Bencher<'_, '_>, part: &str) {
    bench(bencher, part, "contact-area");
}

/// What `orient` does without an objective; meshes 100 mm long.
#[divan::bench(args = PARTS, sample_count = 3, sample_size = 1)]
fn printable(bencher: Bencher<'_, '_>, name: &str) {
    recommended(bencher, name);
}

/// 1.4 million facets.
#[divan::bench(sample_count = 1, sample_size = 1)]
fn printable_large(bencher: Bencher<'_, '_>) {
    recommended(bencher, "lump 838");
}

fn recommended(bencher: Bencher<'_, '_>, name: &str) {
    let Some(mesh) = part(name) else { return bencher.bench(|| ()) };
    let bounds = mesh.bounds();
    let scale = 100.0 / bounds.size().max();
    let points = mesh.vertices().iter().map(|v| (v - bounds.min) * scale).collect();
    let mesh = TriangleMesh::<Object>::new(points, mesh.facets().to_vec());
    let find = || recommend(&Facets::of(&mesh), &Process::default(), None, None);
    let best = find().recommended;
    eprintln!("  {name}: {:.0} mm3 of support, tips beyond {:.1} degrees", best.support_mm3, best.tipping_deg);
    bencher.bench(find);
}

/// A million facets.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn weighted_normal_z_million(bencher: Bencher<'_, '_>) {
    bench(bencher, "lump 708", "weighted-normal-z");
}

/// One direction, columns of 0.5 mm; the arm is blown up to 182 mm, as it would be printed.
#[divan::bench(args = ["lump 91", "castro/arm.obj"])]
fn support_volume_column(bencher: Bencher<'_, '_>, name: &str) {
    let Some(mesh) = part(name) else { return bencher.bench(|| ()) };
    let scale = if name.starts_with("lump") { 1.0 } else { 100.0 };
    let points = mesh.vertices().iter().map(|v| v * scale).collect();
    let facets = Facets::of(&TriangleMesh::<Object>::new(points, mesh.facets().to_vec()));
    let f = objective("support-volume-column", &ObjectiveSettings::default()).expect("known");
    let up = Vec3::new(0.3, -0.4, 0.8).normalize();
    eprintln!("  {name}: {}", f.value(&facets, &up));
    bencher.bench(|| f.value(&facets, &up));
}

/// Connectivity sets of 10,000 facets, and one evaluation with its gradient.
#[divan::bench(sample_count = 1, sample_size = 1)]
fn connectivity_ten_thousand(bencher: Bencher<'_, '_>) {
    let mesh = lump(71);
    bencher.bench(|| {
        let facets = Facets::of(&mesh);
        let f = objective("support-volume", &ObjectiveSettings::default()).expect("known");
        f.gradient(&facets, &Vec3::z())
    });
}

/// Against the column yardstick on 100,000 facets, all that faces down held.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn support_volume_hundred_thousand(bencher: Bencher<'_, '_>) {
    let facets = Facets::of(&lump(224));
    let settings = ObjectiveSettings { overhang: trunnion::geom::Angle::from_deg(0.0), ..ObjectiveSettings::default() };
    let [f, yardstick] = ["support-volume", "support-volume-column"].map(|n| objective(n, &settings).expect("known"));
    for up in [Vec3::z(), Vec3::x(), Vec3::new(0.3, -0.5, 0.8).normalize(), Vec3::new(-0.6, 0.0, -0.8)] {
        let (value, wanted) = (f.value(&facets, &up), yardstick.value(&facets, &up));
        eprintln!("  {} facets: {value} for {wanted}, {:+.2} %", facets.each.len(), (value / wanted - 1.0) * 100.0);
    }
    bencher.bench(|| f.value(&facets, &Vec3::z()));
}
