//! Nearly convex pieces and containing meshes: what becomes of some shapes, and whether distances are told sooner by hulls of pieces than by
//! the trees of boxes that packing and planning have.
//!
//! `cargo bench -p trunnion-benches --bench pieces` takes some two minutes. A ratio above 1 says how many times sooner the hulls answer; `short` is by how
//! much their distance is below the surfaces', which is what their use would cost.

#[allow(dead_code)]
#[path = "../tests/it/packing/shapes.rs"]
mod boats;
#[allow(dead_code, unused_imports)]
#[path = "../src/pack/obb.rs"]
mod obb;
#[allow(dead_code)]
#[path = "../src/mesh/tests/shapes.rs"]
mod shapes;

use std::fmt::Write as _;
use std::io::Write as _;
use std::time::Instant;

use divan::Bencher;
use obb::{ObbTree, Pose};
use trunnion::geom::convex::{Separation, separation_by, support};
use trunnion::geom::{Body, Object, Rigid, SplitMix64, Vec3};
use trunnion::mesh::{TriangleMesh, containing, pieces};
use trunnion::planning::Solid;
// What the shared files call by the crate's own name.
#[allow(unused_imports)]
use trunnion::{fixtures, geom, mesh, pack};

type Mesh = TriangleMesh<Object>;

/// Poses of a pair.
const POSES: usize = 30;
/// What is asked for between models, mm.
const GAP_MM: f64 = 1.0;
/// Concavity of the pieces, and what containing meshes may be raised by, of a shape's size.
const SHARE: f64 = 0.01;

fn main() {
    let mut said = String::new();
    let shapes = shapes();
    for (name, mesh) in &shapes {
        let size = mesh.bounds().size().norm();
        let began = Instant::now();
        let found = pieces(mesh, SHARE * size);
        let seconds = began.elapsed().as_secs_f64();
        let hulls: f64 = found.iter().map(|p| p.hull.volume()).sum();
        let facets = mesh.facets().len();
        let _ = writeln!(
            said,
            "{name}, {facets} facets: {} pieces in {seconds:.2} s, hulls {:.2} times its volume",
            found.len(),
            hulls / mesh.volume()
        );
        let began = Instant::now();
        let around = containing(mesh, facets / 16, SHARE * size);
        let _ = writeln!(
            said,
            "{name}, {facets} facets: {} around it in {:.2} s, volume {:.4}, raised {:.3} mm",
            around.mesh.facets().len(),
            began.elapsed().as_secs_f64(),
            around.mesh.volume() / mesh.volume(),
            around.raised_mm
        );
    }
    for (i, j) in [(0, 0), (1, 1), (2, 2), (3, 3), (0, 1), (2, 3)] {
        between_models(&shapes[i], &shapes[j], &mut said);
    }
    for (i, j) in [(1, 1), (2, 2), (3, 3), (0, 1)] {
        past_a_head(&shapes[i], &shapes[j], &mut said);
    }
    let _ = std::io::stdout().write_all(said.as_bytes());
    divan::main();
}

/// A boat of 1,244 facets, a ring of 16,384, a bumpy ball of 3,968, and a channel of boxes.
fn shapes() -> Vec<(&'static str, Mesh)> {
    let bump = |d: &Vec3| 1.5 * (7.0 * d.x).sin() * (6.0 * d.y).cos() + (9.0 * d.z).sin();
    vec![
        ("boat", boats::boat().swap_remove(0)),
        ("ring", shapes::torus(128, 64)),
        ("bumps", shapes::ball(32, bump)),
        ("channel", shapes::channel()),
    ]
}

/// Hulls of pieces, each within a ball.
struct Hulls(Vec<(Vec3, f64, Vec<Vec3>)>);

impl Hulls {
    fn of(mesh: &Mesh) -> Self {
        let around = |points: Vec<Vec3>| {
            let middle = trunnion::geom::Bounds::of(points.iter().copied()).centre();
            let radius = points.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
            (middle, radius, points)
        };
        let found = pieces(mesh, SHARE * mesh.bounds().size().norm());
        Self(found.into_iter().map(|p| around(p.hull.points)).collect())
    }

    /// The least distance of two, the second one moved; `reach` where it is no less.
    fn distance(&self, other: &Self, pose: &Pose, reach: f64) -> f64 {
        let back = pose.turn.transpose();
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (j, (middle, radius, _)) in other.0.iter().enumerate() {
            let at = pose.turn * middle + pose.shift;
            let least = |(i, p): (usize, &(Vec3, f64, Vec<Vec3>))| ((p.0 - at).norm() - p.1 - radius, i, j);
            pairs.extend(self.0.iter().enumerate().map(least).filter(|(least, ..)| *least < reach));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut best, mut axis) = (reach, Vec3::x());
        for (least, i, j) in pairs {
            if least >= best {
                break;
            }
            let (own, theirs) = (&self.0[i].2, &other.0[j].2);
            let reach = |d: &Vec3| support(own, d) - (pose.turn * support(theirs, &(back * -d)) + pose.shift);
            best = best.min(separation_by(reach, best, &mut axis).distance());
        }
        best
    }
}

/// Poses of the second about the first, from touching to a size apart.
fn poses(one: &Mesh, other: &Mesh) -> Vec<Pose> {
    let mut random = SplitMix64::seeded(1);
    let far = (one.bounds().size().norm() + other.bounds().size().norm()) / 2.0;
    let pose = |_| {
        let turn = nalgebra::Rotation3::new(random.direction() * 3.0).into_inner();
        let at = one.bounds().centre() + random.direction() * far * (0.5 + random.unit());
        Pose { turn, shift: at - turn * other.bounds().centre() }
    };
    (0..POSES).map(pose).collect()
}

fn timed<T>(mut ask: impl FnMut() -> T) -> (T, f64) {
    let mut best = f64::INFINITY;
    let mut answer = None;
    for _ in 0..3 {
        let began = Instant::now();
        answer = Some(ask());
        best = best.min(began.elapsed().as_secs_f64());
    }
    (answer.expect("asked"), best)
}

/// The least distance of two models, and whether they keep the gap: by trees of boxes, by hulls, and by hulls of containing meshes.
fn between_models((one_name, one): &(&str, Mesh), (name, other): &(&str, Mesh), said: &mut String) {
    let facets = |mesh: &Mesh| (0..mesh.facets().len()).map(|i| mesh.corners(i)).collect::<Vec<_>>();
    let trees = [one, other].map(|mesh| ObbTree::of(&facets(mesh)));
    let coarse = |mesh: &Mesh| containing(mesh, mesh.facets().len() / 16, SHARE * mesh.bounds().size().norm()).mesh;
    let kinds = [
        ("hulls", [one, other].map(Hulls::of)),
        ("hulls of what contains it", [one, other].map(|m| Hulls::of(&coarse(m)))),
    ];
    let poses = poses(one, other);
    let here = Pose { turn: nalgebra::Matrix3::identity(), shift: Vec3::zeros() };
    for (question, reach) in [("distance", 1e9), ("gap", GAP_MM)] {
        let by_trees = || poses.iter().map(|p| trees[0].distance(&here, &trees[1], p, reach)).collect::<Vec<f64>>();
        let (wanted, slow) = timed(by_trees);
        for (kind, hulls) in &kinds {
            let (got, quick) =
                timed(|| poses.iter().map(|p| hulls[0].distance(&hulls[1], p, reach)).collect::<Vec<f64>>());
            let short: Vec<f64> = wanted.iter().zip(&got).map(|(w, g)| w - g).collect();
            let most = short.iter().copied().fold(0.0, f64::max);
            let mean = short.iter().sum::<f64>() / short.len() as f64;
            assert!(short.iter().all(|s| *s > -1e-4), "a hull farther away than its surface");
            let kept = |all: &[f64]| all.iter().filter(|mm| **mm >= GAP_MM).count();
            let _ = writeln!(
                said,
                "pack, {question}, {one_name} and {name}, {kind}: {:.2} ({:.1} us to {:.1} us), short {mean:.3} mm, at most {most:.2}; clear {} of {}",
                slow / quick,
                slow / POSES as f64 * 1e6,
                quick / POSES as f64 * 1e6,
                kept(&got),
                kept(&wanted)
            );
        }
    }
}

/// What a head's cone, swept over the one, stays from the other: planning's solids of whole meshes, and one for each piece.
fn past_a_head((one_name, one): &(&str, Mesh), (name, other): &(&str, Mesh), said: &mut String) {
    let cone = Body::frustum("cone", [0.0, 12.0], [0.5, 7.0], [true; 3]).points;
    let whole = [one, other].map(Solid::of);
    let split = [one, other].map(|m| Hulls::of(m).0.into_iter().map(|(.., p)| Solid::hull(p)).collect::<Vec<_>>());
    let still: Rigid<Object, Object> = Rigid::shift(Vec3::zeros());
    let mut pairs = Vec::new();
    for pose in poses(one, other).iter().take(POSES / 10) {
        let moved = |solid: &Solid| solid.moved(&pose.turn, &pose.shift);
        pairs.push((moved(&whole[1]), split[1].iter().map(moved).collect::<Vec<_>>()));
    }
    for (question, enough) in [("distance", 1e9), ("gap", GAP_MM)] {
        let by_whole = |(obstacle, _): &(Solid, Vec<Solid>)| {
            whole[0].swept_clearance(&still, [true; 3], &cone, obstacle, enough).distance()
        };
        let by_pieces = |(_, obstacles): &(Solid, Vec<Solid>)| {
            let mut least = enough;
            for (a, b) in split[0].iter().flat_map(|a| obstacles.iter().map(move |b| (a, b))) {
                match a.swept_clearance(&still, [true; 3], &cone, b, least) {
                    Separation::Apart(mm) => least = least.min(mm),
                    Separation::Meeting => return 0.0,
                }
            }
            least
        };
        let (wanted, slow) = timed(|| pairs.iter().map(by_whole).collect::<Vec<f64>>());
        let (got, quick) = timed(|| pairs.iter().map(by_pieces).collect::<Vec<f64>>());
        let most = wanted.iter().zip(&got).map(|(w, g)| w - g).fold(0.0, f64::max);
        let _ = writeln!(
            said,
            "planning, {question}, {one_name} past {name}: {:.2} ({:.0} us to {:.0} us), short by at most {most:.2} mm",
            slow / quick,
            slow / pairs.len() as f64 * 1e6,
            quick / pairs.len() as f64 * 1e6
        );
    }
}

#[divan::bench(args = [0.002, 0.01, 0.03], sample_count = 3)]
fn pieces_of_a_ring_of_16000(bencher: Bencher<'_, '_>, share: f64) {
    let mesh = shapes::torus(128, 64);
    bencher.bench_local(|| pieces(&mesh, share * mesh.bounds().size().norm()));
}

#[divan::bench(args = [4000, 1000], sample_count = 3)]
fn containing_a_ring_of_16000(bencher: Bencher<'_, '_>, facets: usize) {
    let mesh = shapes::torus(128, 64);
    bencher.bench_local(|| containing(&mesh, facets, f64::INFINITY));
}
