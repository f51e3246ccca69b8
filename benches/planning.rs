//! Planning by itself: random trees of 40, 100 and 200 boxes from parts to a plan with its bound, and the question who is
//! in whose way between two parts of 100,000 facets.
//!
//! `cargo bench -p trunnion-benches --bench planning` prints the times, and first what was planned; run on one thread (`RAYON_NUM_THREADS=1`) the
//! times are CPU times. The latest figures are in docs/explanation/measurements.md.

use std::fmt::Write as _;
use std::io::Write as _;

use divan::Bencher;
use trunnion::fixtures::solid_box;
use trunnion::geom::{Angle, Dir, Machine, Object, Rigid, Table, Vec3};
use trunnion::mesh::{Model, TriangleMesh};
use trunnion::motion::Pose;
use trunnion::orient::{Multistart, ObjectiveSettings, Staircase};
use trunnion::planning::{Goal, Head, Options, Planned, Solid, Workpiece, orientations, plan};
use trunnion::profile::{Profile, resolve, shipped};

fn main() {
    let mut said = String::new();
    for parts in [40, 100, 200] {
        let text = match planned(&tree(parts, 1), "bss") {
            Ok(p) => format!(
                "sequence size {} (at least {}), {} slots, {} candidates, {} steps",
                p.value,
                p.lower_bound,
                p.slots.len(),
                p.candidates,
                p.steps
            ),
            Err(no) => no.to_string(),
        };
        let _ = writeln!(said, "tree of {parts}: {text}");
    }
    let _ = std::io::stdout().write_all(said.as_bytes());
    divan::main();
}

/// A machine with room for 200 parts, and a head without a carriage.
fn machine() -> Profile {
    let (file, text) = shipped("generic-ac").expect("shipped");
    let mut profile = resolve(file, text).expect("resolves").0;
    profile.table.radius_mm = 800.0;
    // A gantry would strike a plate of this size at every tilt.
    profile.head.body.retain(|b| b.name == "nozzle" || b.name == "block");
    profile.limits.x_mm = [-1900.0, 1900.0];
    profile.limits.y_mm = [-1900.0, 1900.0];
    profile.limits.z_mm = [-1900.0, 1900.0];
    profile
}

struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }
}

/// Boxes of 10 mm section on a plate: trunks 200 mm apart, arms out of their sides, uprights on arms, arms out of those.
fn tree(parts: usize, seed: u64) -> Model {
    let mut random = Random(seed);
    let mut boxes = vec![[[-560.0, -560.0, 0.0], [560.0, 560.0, 8.0]]];
    let trunks = parts.div_ceil(7);
    let side = (trunks as f64).sqrt().ceil() as usize;
    for k in 0..trunks {
        let at = |i: usize| (i as f64 - (side as f64 - 1.0) / 2.0) * 200.0;
        let (x, y) = (at(k % side), at(k / side));
        boxes.push([[x - 5.0, y - 5.0, 8.0], [x + 5.0, y + 5.0, 108.0]]);
    }
    while boxes.len() < parts {
        let on: [[f64; 3]; 2] = boxes[1 + random.below(boxes.len() as u64 - 1) as usize];
        let length = 35.0 + 5.0 * random.below(5) as f64;
        let (axis, sign) = [(2, 1), (0, 1), (0, -1), (1, 1), (1, -1)][random.below(5) as usize];
        let mut new = [[0.0; 3]; 2];
        for i in 0..3 {
            let steps = ((on[1][i] - on[0][i] - 10.0) / 5.0) as u64 + 1;
            new[0][i] = on[0][i] + 5.0 * random.below(steps) as f64;
            new[1][i] = new[0][i] + 10.0;
        }
        (new[0][axis], new[1][axis]) =
            if sign > 0 { (on[1][axis], on[1][axis] + length) } else { (on[0][axis] - length, on[0][axis]) };
        let near = |other: &[[f64; 3]; 2]| {
            other != &on && (0..3).all(|i| new[0][i] < other[1][i] + 15.0 && other[0][i] < new[1][i] + 15.0)
        };
        if new[0][2] > 30.0 && !boxes.iter().any(near) && printable(&new, axis, sign, &boxes) {
            boxes.push(new);
        }
    }
    let named = boxes.iter().map(|[min, max]| (String::new(), solid_box(Vec3::from(*min), Vec3::from(*max))));
    Model::from_parts(named.collect())
}

/// Whether the head reaches a box of this axis and sense past all that stand before it: so there is a sequence at least.
fn printable(new: &[[f64; 3]; 2], axis: usize, sign: i32, before: &[[[f64; 3]; 2]]) -> bool {
    let profile = machine();
    let (table, head) = (profile.kinematics(), Head::of(&profile));
    let solid = |b: &[[f64; 3]; 2]| Solid::of(&solid_box(Vec3::from(b[0]), Vec3::from(b[1])));
    let up = Vec3::from_fn(|i, _| if i == axis { f64::from(sign) } else { 0.0 });
    let (swept, slab) = (solid(new), Solid::hull(profile.table_slab()));
    let poses = table.solutions(Dir::new(up).expect("an axis"), Pose::LEVEL);
    poses.into_iter().filter(|pose| table.tilt.admits(pose.tilt)).any(|pose| {
        let motion: Rigid<Table, Machine> = table.forward(pose);
        head.clears(&motion, &swept, &slab, 0.425, 1e-3)
            && before.iter().all(|b| {
                let touches = (0..3).all(|i| new[0][i] <= b[1][i] && b[0][i] <= new[1][i]);
                let (lift, margin) = if touches { (0.425, 1e-3) } else { (0.2, 0.5) };
                head.clears(&motion, &swept, &solid(b), lift, margin)
            })
    })
}

fn planned(model: &Model, goal: &str) -> Result<Planned, trunnion::planning::Infeasible> {
    let (goal, objective, search) = (
        Goal::parse(goal, &ObjectiveSettings::default()).expect("a goal"),
        Staircase { layer_mm: 0.2 },
        Multistart::default(),
    );
    let options = Options { explain: false, ..Options::new(&goal, &objective, &search) };
    let workpiece = Workpiece::place(model, &Workpiece::centred(model));
    let directions = orientations(&workpiece, &options);
    plan(&workpiece, &machine(), &directions, &options).map(|mut plans| plans.swap_remove(0))
}

#[divan::bench(args = [40, 100, 200], sample_count = 3)]
fn trees(bencher: Bencher<'_, '_>, parts: usize) {
    let model = tree(parts, 1);
    bencher.bench_local(|| planned(&model, "bss"));
}

#[divan::bench(args = [40, 100], sample_count = 3)]
fn trees_by_time(bencher: Bencher<'_, '_>, parts: usize) {
    let model = tree(parts, 1);
    bencher.bench_local(|| planned(&model, "time"));
}

/// A bowl: a wavy sheet with thickness, closed, `2 * 2 * n * n` facets and a rim.
fn wavy(n: usize, z: f64) -> TriangleMesh<Object> {
    let mut vertices = Vec::new();
    for layer in 0..2 {
        for j in 0..=n {
            for i in 0..=n {
                let (x, y) = (60.0 * i as f64 / n as f64 - 30.0, 60.0 * j as f64 / n as f64 - 30.0);
                let wave = 3.0 * (x * 0.6).sin() * (y * 0.5).cos();
                vertices.push(Vec3::new(x, y, z + wave + 4.0 * f64::from(layer)));
            }
        }
    }
    let at = |layer: usize, i: usize, j: usize| (layer * (n + 1) * (n + 1) + j * (n + 1) + i) as u32;
    let mut facets = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let (a, b, c, d) = (at(1, i, j), at(1, i + 1, j), at(1, i + 1, j + 1), at(1, i, j + 1));
            facets.extend([[a, b, c], [a, c, d]]);
            let (a, b, c, d) = (at(0, i, j), at(0, i + 1, j), at(0, i + 1, j + 1), at(0, i, j + 1));
            facets.extend([[a, c, b], [a, d, c]]);
        }
    }
    for k in 0..n {
        let rims = [(at(0, k, 0), at(0, k + 1, 0), at(1, k + 1, 0), at(1, k, 0)), {
            let (i, j) = (n - k, n);
            (at(0, i, j), at(0, i - 1, j), at(1, i - 1, j), at(1, i, j))
        }];
        let sides = [(at(0, n, k), at(0, n, k + 1), at(1, n, k + 1), at(1, n, k)), {
            let (i, j) = (0, n - k);
            (at(0, i, j), at(0, i, j - 1), at(1, i, j - 1), at(1, i, j))
        }];
        for (a, b, c, d) in rims.into_iter().chain(sides) {
            facets.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriangleMesh::new(vertices, facets)
}

/// Eight orientations of each of two wavy sheets, one above the other at 6 mm, of 100,000 facets each.
#[divan::bench(sample_count = 3)]
fn who_blocks_whom_among_200_000_facets(bencher: Bencher<'_, '_>) {
    let n = 158;
    let sheets = [wavy(n, 8.0), wavy(n, 18.0)];
    let profile = machine();
    let table = profile.kinematics();
    let head = Head::of(&profile);
    bencher.bench_local(|| {
        let solids: Vec<Solid> = sheets.iter().map(Solid::of).collect();
        let mut blocked = 0;
        for k in 0..8 {
            let pose =
                Pose { tilt: Angle::from_deg(f64::from(k) * 12.0), rotation: Angle::from_deg(f64::from(k) * 45.0) };
            let motion: Rigid<Table, Machine> = table.forward(pose);
            for (part, other) in [(0, 1), (1, 0)] {
                blocked += usize::from(!head.clears(&motion, &solids[part], &solids[other], 0.2, 0.5));
            }
        }
        blocked
    });
}
