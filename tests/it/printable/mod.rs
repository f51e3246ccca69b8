//! `orient`'s default: does it lay parts as a person would, is it cheaper than what others choose, and are its figures true?
//!
//! Witnesses without the library's code: dense rays for supports and footprint, the definition for the tipping angle (`rays.rs`), and the
//! published idea of Tweaker-3 (`tweaker.rs`).

mod command;
mod python;
mod rays;
mod shapes;
mod tweaker;

use trunnion::geom::Vec3;
use trunnion::mesh::{ReadOptions, Repair, TriangleMesh, Unit, read_surface};
use trunnion::orient::{Facets, Mass, Priced, Process, Recommendation, STANDS_DEG, recommend};

use crate::orient::meshes;
use crate::orient_sample::anywhere;
use crate::solids::{Mesh, lump};
use crate::split::solids::{ball, rod};
use crate::support::{Numbers, note};
use rays::look;
use shapes::shapes;
use tweaker::{Mode, choice};

const LAYER_MM: f64 = 0.2;

fn recommended(mesh: &Mesh) -> Recommendation {
    recommend(&Facets::of(mesh), &Process::default(), None, None)
}

/// Turned anyhow, shifted, in single precision: as files have parts.
fn anyhow(mesh: &Mesh, numbers: &mut Numbers) -> (Mesh, nalgebra::UnitQuaternion<f64>) {
    let turn = nalgebra::UnitQuaternion::from_scaled_axis(Vec3::from(numbers.triple(3.0)));
    let shift = Vec3::from(numbers.triple(30.0));
    let points = mesh.vertices().iter().map(|v| (turn * v + shift).map(|c| f64::from(c as f32))).collect();
    (TriangleMesh::new(points, mesh.facets().to_vec()), turn)
}

/// Parts lie flat to this, degrees: single precision of a part of 100 mm turns a face of 10 mm by less.
const FLAT_DEG: f64 = 0.01;

/// A flange whose face is crowned by so much rests on its rim as well, leaning; nobody wants its axis to lean.
#[test]
fn a_crowned_face_does_not_lean_the_axis() {
    let mut numbers = Numbers::seeded(17);
    for crown in [0.0, 0.1, 0.3, 0.5, 1.0] {
        let flange = shapes::turned_body(&[[4.0, 0.0], [30.0, crown], [30.0, 3.0], [12.0, 6.0], [10.0, 40.0]]);
        let (mesh, turn) = anyhow(&flange, &mut numbers);
        let best = recommended(&mesh).recommended;
        let off = (turn * Vec3::z()).angle(&best.up).to_degrees();
        assert!(off < FLAT_DEG, "{crown} mm: {off} degrees off");
    }
}

/// A ball on two feet costs a little less where it lies on one of their sides, and falls over there.
#[test]
fn a_ball_on_two_feet_stands_on_them() {
    let mut numbers = Numbers::seeded(18);
    let foot = |x: f64| rod(4.0, 12.0, 32).at(x, 0.0, -1.0);
    let body = ball(15.0, 32).at(0.0, 0.0, 20.0).and(&foot(6.0)).and(&foot(-6.0));
    let (mesh, turn) = anyhow(&body.mesh(), &mut numbers);
    let best = recommended(&mesh).recommended;
    let off = (turn * Vec3::z()).angle(&best.up).to_degrees();
    assert!(off < FLAT_DEG && best.footprint_mm2 > 90.0, "{off} degrees off: {best:?}");
}

/// A face that single precision leans by hundredths of a degree is drawn flat: the file's axis is recommended, to the bit.
#[test]
fn what_is_drawn_upright_but_for_rounding_stays_upright() {
    for lean_deg in [0.0_f64, 0.003, 0.02, 0.08, 0.15] {
        let rise = 60.0 * lean_deg.to_radians().tan();
        let flange = shapes::turned_body(&[[30.0, 0.0], [30.0, 4.0], [12.0, 6.0], [10.0, 30.0]]);
        let lean = |v: &Vec3| Vec3::new(v.x, v.y, if v.z == 0.0 { rise * (v.x + 30.0) / 60.0 } else { v.z });
        let mesh = TriangleMesh::new(flange.vertices().iter().map(lean).collect(), flange.facets().to_vec());
        let up = recommended(&mesh).recommended.up;
        assert!(up.x == 0.0 && up.y == 0.0 && up.z == 1.0, "{lean_deg} degrees: {up:?}");
    }
}

#[test]
fn solids_lie_as_a_person_would_lay_them_however_they_come() {
    let mut numbers = Numbers::seeded(16);
    for shape in shapes() {
        for tried in 0..3 {
            let (mesh, turn) = anyhow(&shape.mesh, &mut numbers);
            let best = recommended(&mesh).recommended;
            let name = format!("{} ({tried})", shape.name);
            let off = shape.ups.iter().map(|up| (turn * up).angle(&best.up).to_degrees()).fold(f64::INFINITY, f64::min);
            assert!(off < FLAT_DEG, "{name}: {off} degrees off, {:?}", turn.inverse() * best.up);
            assert!(best.stands, "{name}: {best:?}");
            let seen = look(&mesh, &best.up, LAYER_MM);
            assert!(seen.tipping_deg > 4.0, "{name}: {seen:?}");
            let volume = Facets::of(&mesh).mass().volume_mm3;
            assert!(!shape.bare || seen.support_mm3 < 1e-3 * volume, "{name}: {seen:?}");
        }
    }
}

#[test]
fn a_ball_ends_at_once_and_says_that_it_falls_over() {
    let outline: Vec<[f64; 2]> = (0..=24)
        .map(|i| {
            let angle = f64::from(i) / 24.0 * std::f64::consts::PI;
            [15.0 * angle.sin(), 15.0 - 15.0 * angle.cos()]
        })
        .collect();
    let made = recommended(&shapes::turned_body(&outline));
    assert!(made.evaluations < 2000, "{}", made.evaluations);
    let spread = made.poses.iter().map(|p| p.price_min / made.recommended.price_min);
    assert!(spread.clone().all(|s| (0.99..1.2).contains(&s)), "{:?}", spread.collect::<Vec<_>>());
}

/// A figure against its witness: relative to the largest that may be, and what a column more or less along an outline makes.
fn near(ours: f64, seen: f64, share: f64, size: f64, what: &str) {
    assert!((ours - seen).abs() <= share * seen.abs().max(ours.abs()) + share * size, "{what}: {ours}, seen {seen}");
}

#[test]
fn the_prices_figures_are_what_rays_see() {
    let mut numbers = Numbers::seeded(17);
    for shape in shapes() {
        let facets = Facets::of(&shape.mesh);
        let ups = [anywhere(&mut numbers), anywhere(&mut numbers), shape.ups[0]];
        for up in ups {
            let priced = Process::default().price(&facets, facets.mass(), &up, 0.15);
            let seen = look(&shape.mesh, &up, LAYER_MM);
            let Mass { volume_mm3, area_mm2, .. } = *facets.mass();
            // Shells that overlap or touch within one part are no solid for the definition of volume by tetrahedra.
            near(priced.support_mm3, seen.support_mm3, 0.01, volume_mm3, &format!("{} supports at {up:?}", shape.name));
            near(priced.footprint_mm2, seen.footprint_mm2, 0.02, 0.05 * area_mm2, &format!("{} footprint", shape.name));
            let off = priced.tipping_deg - seen.tipping_deg;
            assert!(off.abs() < 0.2, "{} at {up:?}: {priced:?} {seen:?}", shape.name);
        }
    }
}

/// The documents' meshes, 100 mm long.
fn printed() -> Option<Vec<(String, Mesh)>> {
    let folder = meshes()?;
    let mut files: Vec<_> =
        ["castro", "puri"].iter().flat_map(|sub| std::fs::read_dir(folder.join(sub)).unwrap()).collect();
    files.sort_by_key(|entry| entry.as_ref().unwrap().path());
    let read = |entry: std::io::Result<std::fs::DirEntry>| {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
        let mesh: Mesh = read_surface(&std::fs::read(&path).unwrap(), &name, &options).unwrap();
        let bounds = mesh.bounds();
        let scale = 100.0 / bounds.size().max();
        let points = mesh.vertices().iter().map(|v| (v - bounds.min) * scale).collect();
        (name, TriangleMesh::new(points, mesh.facets().to_vec()))
    };
    Some(files.into_iter().map(read).collect())
}

/// Supports nearer than this share of the part's volume are one: what rays and columns differ by, and less than a purge line.
const TIE: f64 = 1e-3;
/// Tipping angles nearer than this are one, degrees.
const SAME_DEG: f64 = 0.1;
/// The geometric mean of the recommended pose's supports over the least known.
const MEAN: f64 = 1.3;

#[test]
fn it_needs_no_more_support_than_tweaker_at_no_smaller_tipping_angle() {
    if let Some(meshes) = printed() {
        let mean = no_worse_than_tweaker(&meshes, true);
        assert!(mean <= MEAN, "{mean}");
    }
}

/// The same on shapes and lumps that are made here; which of its faces a wedge stands on is a matter of its layers, too.
#[test]
fn it_needs_no_more_support_than_tweaker_on_made_shapes() {
    let made = shapes().into_iter().map(|shape| (shape.name.to_owned(), shape.mesh));
    let lumps = [(9, 0.0), (10, 1.0), (12, 3.0)].map(|(rings, kind)| (format!("lump of {rings}"), lump(rings, kind)));
    no_worse_than_tweaker(&made.chain(lumps).collect::<Vec<_>>(), false);
}

/// What stands may have a hundredth more of them than what does not.
fn steadier(best: &rays::Seen, other: &rays::Seen) -> bool {
    best.tipping_deg > STANDS_DEG && other.tipping_deg < STANDS_DEG && best.support_mm3 <= 1.01 * other.support_mm3
}

/// No more support, and where it is asked for no smaller tipping angle; the geometric mean of the supports over the least known.
fn no_worse_than_tweaker(meshes: &[(String, Mesh)], tipping: bool) -> f64 {
    let (mut sum, count) = (0.0, meshes.len() as f64);
    for (name, mesh) in meshes {
        let made = recommended(mesh);
        let best = look(mesh, &made.recommended.up, LAYER_MM);
        let tie = TIE * Facets::of(mesh).mass().volume_mm3;
        let mut least = made.poses.iter().map(|p: &Priced| p.support_mm3).fold(best.support_mm3, f64::min);
        for (extended, volume) in [(false, true), (true, true), (false, false), (true, false)] {
            let other = look(mesh, &choice(mesh, Mode { extended, volume }), LAYER_MM);
            least = least.min(other.support_mm3);
            assert!(
                best.support_mm3 <= other.support_mm3 + tie || steadier(&best, &other),
                "{name}: {best:?}, Tweaker ({extended}, {volume}) {other:?}"
            );
            assert!(
                !tipping || best.tipping_deg >= other.tipping_deg - SAME_DEG,
                "{name}: {best:?}, Tweaker ({extended}, {volume}) {other:?}"
            );
        }
        let ratio = (best.support_mm3 + tie) / (least + tie);
        note(&format!("{name}: supports {ratio:.2} times the least known, {best:?}"));
        sum += ratio.ln();
    }
    let mean = (sum / count).exp();
    note(&format!("geometric mean over {count} meshes: {mean:.3}"));
    mean
}

#[test]
fn the_bound_holds_and_the_answer_is_the_same_on_any_number_of_threads() {
    let mut numbers = Numbers::seeded(18);
    for shape in shapes() {
        let facets = Facets::of(&shape.mesh);
        let bound = recommended(&shape.mesh).at_least_min;
        for _ in 0..200 {
            let up = anywhere(&mut numbers);
            let price = Process::default().price(&facets, facets.mass(), &up, 1.0).price_min;
            assert!(price >= bound, "{} at {up:?}: {price} below {bound}", shape.name);
        }
    }
    let (mesh, _) = anyhow(&shapes()[12].mesh, &mut numbers);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| recommended(&mesh))
    };
    let alone = on(1);
    assert!(alone == on(2) && alone == on(5));
}
