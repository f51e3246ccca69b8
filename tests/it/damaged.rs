//! Damaged meshes of every kind, from small to gross, at places that a seed draws: what is read measures what the undamaged solid measures and says what
//! was done, or it is refused with the places. Never a changed shape in silence, and never parts of no volume.

use trunnion::fixtures::{prism, solid_box};
use trunnion::geom::{Object, SplitMix64, Vec3};
use trunnion::mesh::{Fault, FilePlace, Model, ReadOptions, Repair, TriangleMesh, read_model, stl_binary};

use crate::support::seeds;

type Mesh = TriangleMesh<Object>;
type Facet = [Vec3; 3];

fn circle(corners: u32, radius: f64) -> Vec<[f64; 2]> {
    let at = |k: u32| (std::f64::consts::TAU * f64::from(k) / f64::from(corners)).sin_cos();
    (0..corners).map(at).map(|(sin, cos)| [20.0 + radius * cos, 20.0 + radius * sin]).collect()
}

/// A knob: a ball of rings, flat below.
fn knob() -> Mesh {
    let (rings, sides) = (12_u32, 24_u32);
    let at = |ring: u32, side: u32| {
        let down = std::f64::consts::PI * 0.8 * f64::from(ring) / f64::from(rings);
        let turn = std::f64::consts::TAU * f64::from(side) / f64::from(sides);
        Vec3::new(down.sin() * turn.cos(), down.sin() * turn.sin(), down.cos()) * 12.0
    };
    let mut vertices = vec![at(0, 0)];
    vertices.extend((1..=rings).flat_map(|r| (0..sides).map(move |s| (r, s))).map(|(r, s)| at(r, s)));
    vertices.push(Vec3::new(0.0, 0.0, at(rings, 0).z));
    let number = |r: u32, s: u32| 1 + (r - 1) * sides + s % sides;
    let foot = vertices.len() as u32 - 1;
    let mut facets = Vec::new();
    for s in 0..sides {
        facets.extend([[0, number(1, s), number(1, s + 1)], [number(rings, s), foot, number(rings, s + 1)]]);
        for r in 1..rings {
            let [a, b, c, d] = [number(r, s), number(r, s + 1), number(r + 1, s), number(r + 1, s + 1)];
            facets.extend([[a, c, b], [b, c, d]]);
        }
    }
    Mesh::new(vertices, facets)
}

/// A box with a pocket from above.
fn tray() -> Mesh {
    let outer = solid_box(Vec3::zeros(), Vec3::new(30.0, 24.0, 15.0));
    let inner = solid_box(Vec3::new(2.0, 2.0, 2.0), Vec3::new(28.0, 22.0, 15.0));
    let [a, b] = [outer.vertices(), inner.vertices()];
    let top = |mesh: &Mesh, f: usize| mesh.corners(f).iter().all(|p| p.z == 15.0);
    let mut facets: Vec<[u32; 3]> = (0..12).filter(|&f| !top(&outer, f)).map(|f| outer.facets()[f]).collect();
    let turned = (0..12).filter(|&f| !top(&inner, f)).map(|f| inner.facets()[f]);
    facets.extend(turned.map(|[p, q, r]| [p + 8, r + 8, q + 8]));
    // Corners by their sides, around the rim.
    let corner = |all: &[Vec3], right: bool, behind: bool| {
        let middle = Vec3::new(15.0, 12.0, 0.0);
        let is = |p: &Vec3| p.z == 15.0 && (p.x > middle.x) == right && (p.y > middle.y) == behind;
        all.iter().position(is).unwrap() as u32
    };
    let around = [(false, false), (true, false), (true, true), (false, true)];
    for k in 0..4 {
        let ((r, h), (s, i)) = (around[k], around[(k + 1) % 4]);
        let [p, q] = [corner(a, r, h), corner(a, s, i)];
        let [u, v] = [corner(b, r, h) + 8, corner(b, s, i) + 8];
        facets.extend([[p, q, v], [p, v, u]]);
    }
    Mesh::new([a, b].concat(), facets)
}

fn solids() -> Vec<(&'static str, Mesh)> {
    let bracket = [[40.0, 0.0], [40.0, 5.0], [12.0, 5.0], [5.0, 12.0], [5.0, 30.0], [0.0, 30.0], [0.0, 0.0]];
    vec![
        ("bracket", prism(&bracket, [0.0, 20.0])),
        ("disc", prism(&circle(48, 10.0), [0.0, 8.0])),
        ("knob", knob()),
        ("tray", tray()),
    ]
}

#[derive(Clone, Copy, Debug)]
enum Damage {
    /// Every corner of every facet is off by up to so much along each axis.
    Strewn(f64),
    /// One facet is so far from its place.
    Apart(f64),
    Doubled,
    DoubledAll,
    DoubledThird,
    DoubledOver,
    /// So many facets are missing, wherever they are.
    Missing(usize),
    /// A facet and one beside it.
    TwoMissing,
    /// All facets at a corner.
    RingMissing,
    Over,
    OverThird,
    InsideOut,
    /// From an edge to the middle.
    InnerWall,
    Fin,
    Loose,
    Parted,
    Collinear,
    NoArea,
}

use Damage::*;

/// Each kind, and whether all of it must be mended.
const KINDS: [(Damage, bool); 28] = [
    (Strewn(1e-5), true),
    (Strewn(1e-4), true),
    (Strewn(1e-3), true),
    (Strewn(5e-3), true),
    (Strewn(0.02), false),
    (Strewn(0.1), false),
    (Strewn(1.0), false),
    (Apart(1e-3), true),
    (Apart(0.02), true),
    (Apart(0.1), false),
    (Apart(2.0), false),
    (Doubled, true),
    (DoubledAll, true),
    (DoubledThird, true),
    (DoubledOver, true),
    (Missing(1), true),
    (Missing(5), false),
    (TwoMissing, false),
    (RingMissing, false),
    (Over, true),
    (OverThird, true),
    (InsideOut, true),
    (InnerWall, true),
    (Fin, true),
    (Loose, true),
    (Parted, true),
    (Collinear, true),
    (NoArea, true),
];

fn damaged(mesh: &Mesh, damage: Damage, random: &mut SplitMix64) -> Vec<Facet> {
    let mut all: Vec<Facet> = (0..mesh.facets().len()).map(|f| mesh.corners(f)).collect();
    let at = random.below(all.len());
    let facet = all[at];
    let [a, b, c] = facet;
    let mut off = |by: f64| Vec3::from_fn(|_, _| (2.0 * random.unit() - 1.0) * by);
    let shared = |other: &Facet| other.iter().filter(|p| facet.contains(p)).count();
    match damage {
        Strewn(by) => all.iter_mut().flatten().for_each(|p| *p += off(by)),
        Apart(by) => {
            let by = off(1.0).normalize() * by;
            all[at] = facet.map(|p| p + by);
        }
        Doubled => all.push([b, c, a]),
        DoubledAll => all.extend(all.clone()),
        DoubledThird => all.extend(all.clone().into_iter().step_by(3)),
        DoubledOver => all.push([a, c, b]),
        Missing(count) => {
            for _ in 0..count {
                all.swap_remove(random.below(all.len()));
            }
        }
        TwoMissing => {
            let beside = (0..all.len()).find(|&k| shared(&all[k]) == 2).unwrap();
            all.swap_remove(at.max(beside));
            all.swap_remove(at.min(beside));
        }
        RingMissing => all.retain(|other| !other.contains(&a)),
        Over => all[at] = [a, c, b],
        OverThird => all.iter_mut().step_by(3).for_each(|one| one.swap(1, 2)),
        InsideOut => all.iter_mut().for_each(|one| one.swap(1, 2)),
        InnerWall => all.push([a, b, mesh.bounds().centre()]),
        Fin => all.push([a, b, (a + b) * 0.5 + (b - a).cross(&(c - a)).normalize() * 1.5]),
        Loose => {
            let beside = mesh.bounds().max + Vec3::repeat(3.0);
            all.push([beside, beside + Vec3::x() * 3.0, beside + Vec3::y() * 3.0]);
        }
        Parted => {
            let middle = a + (b - a) * (0.2 + 0.6 * random.unit());
            all[at] = [a, middle, c];
            all.push([middle, b, c]);
        }
        Collinear => all.push([a, (a + b) * 0.5, b]),
        NoArea => all.push([a, a, b]),
    }
    if random.unit() < 0.5 {
        for k in (1..all.len()).rev() {
            all.swap(k, random.below(k + 1));
        }
    }
    all
}

fn file(facets: &[Facet]) -> Vec<u8> {
    let count = facets.len() as u32;
    let mesh = Mesh::new(facets.concat(), (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect());
    stl_binary(&mesh)
}

fn measures(model: &Model) -> (f64, f64) {
    let parts = || model.parts.iter().map(|part| &part.mesh);
    (parts().map(Mesh::volume).sum(), parts().map(Mesh::area).sum())
}

/// What was said besides how it stands.
fn said(model: &Model) -> Vec<&String> {
    model.warnings_in_any_pose().collect()
}

#[test]
fn a_damaged_mesh_is_what_it_was_or_is_refused_with_the_places() {
    let mend = ReadOptions { repair: Repair::Auto, ..ReadOptions::default() };
    let (mut mended, mut refused) = ([0; KINDS.len()], [0; KINDS.len()]);
    for seed in seeds(2, 60) {
        for (name, mesh) in solids() {
            let whole = read_model(&stl_binary(&mesh), "whole.stl", &ReadOptions::default()).unwrap();
            assert!(whole.parts.len() == 1 && said(&whole).is_empty(), "{name}: {:?}", whole.warnings);
            let (volume, area) = measures(&whole);
            for (kind, &(damage, always)) in KINDS.iter().enumerate() {
                let mut random = SplitMix64::seeded(seed * 1000 + kind as u64);
                let case = format!("{damage:?} of the {name}, TRUNNION_SEEDS={seed}..{}", seed + 1);
                match read_model(&file(&damaged(&mesh, damage, &mut random)), "x.stl", &mend) {
                    Ok(model) => {
                        let (now, surface) = measures(&model);
                        let said = said(&model);
                        assert_eq!(model.parts.len(), 1, "{case}: {said:?}");
                        assert!((now - volume).abs() <= 3e-3 * volume, "{case}: {now} of {volume} mm3, {said:?}");
                        assert!((surface - area).abs() <= 5e-3 * area, "{case}: {surface} of {area} mm2, {said:?}");
                        assert!(!said.is_empty(), "{case}: in silence");
                        mended[kind] += 1;
                    }
                    Err(error) => {
                        assert!(!always, "{case}: {error}");
                        // A file of one solid without a name has no parts to be named.
                        assert_eq!(error.place, FilePlace::File, "{case}: {error}");
                        let Fault::Open { edges, at, .. } = &error.fault else { panic!("{case}: {error}") };
                        let box_of_it = mesh.bounds().inflated(5.0);
                        assert!(*edges > 0 && (1..=10).contains(&at.named.len()), "{case}: {error}");
                        assert!(at.named.iter().all(|place| box_of_it.holds(place)), "{case}: {error}");
                        assert!(at.more == 0 || at.named.len() == 10, "{case}: {error}");
                        refused[kind] += 1;
                    }
                }
            }
        }
    }
    for (kind, (damage, _)) in KINDS.iter().enumerate() {
        eprintln!("{damage:?}: {} mended, {} refused", mended[kind], refused[kind]);
    }
    // What is grossly wrong is not guessed at.
    let index = |wanted: &str| KINDS.iter().position(|(damage, _)| format!("{damage:?}") == wanted).unwrap();
    assert_eq!(mended[index("Strewn(1.0)")], 0);
    // Of holes some are sure, and others are not.
    assert!(mended[index("TwoMissing")] > 0 && mended[index("Missing(5)")] > 0 && refused[index("RingMissing")] > 0);
}

/// Holes at known places of a tray: what is missing around its corners is told, all of it up to ten.
#[test]
fn all_places_that_are_not_sure_are_listed() {
    let mend = ReadOptions { repair: Repair::Auto, ..ReadOptions::default() };
    let trays = |count: usize| {
        let mesh = tray();
        let one = |k: usize| {
            let moved = move |p: Vec3| p + Vec3::new(50.0 * k as f64, 0.0, 0.0);
            let all = (0..mesh.facets().len()).map(|f| mesh.corners(f)).filter(|f| !f.contains(&Vec3::zeros()));
            all.map(|f| f.map(moved)).collect::<Vec<_>>()
        };
        file(&(0..count).flat_map(one).collect::<Vec<_>>())
    };
    for count in [1, 3, 10, 13] {
        let error = read_model(&trays(count), "x.stl", &mend).unwrap_err();
        let Fault::Open { at, .. } = &error.fault else { panic!("{error}") };
        assert_eq!((at.named.len(), at.more), (count.min(10), count.saturating_sub(10)), "{error}");
        for (k, place) in at.named.iter().enumerate() {
            let corner = Vec3::new(50.0 * k as f64, 0.0, 0.0);
            assert!((place - corner).norm() < 30.0, "{place}: {error}");
        }
        assert_eq!(error.to_string().contains(&format!("and {} more places", count.saturating_sub(10))), count > 10);
    }
}
