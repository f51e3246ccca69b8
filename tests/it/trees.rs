//! Trees of slanting rods that can be printed because they were built so: each rod was put only where the head could have printed it,
//! past all that stood before. The planner, which is told nothing of that, must find a plan.
//!
//! A rod is a square bar on a face of an earlier one, upright on that face, with a slanting top. `TRUNNION_RODS=20,50,100,200` says
//! how many, `TRUNNION_SEEDS=FROM..TO` which.

use std::time::Instant;

use trunnion::fixtures::{NamedMesh, solid_box};
use trunnion::geom::{Angle, Object, Rigid, SplitMix64, Vec3};
use trunnion::job::{MachineSource, ModelSource, PlaceRequest, PlanOptions, PlanRequest, Silent, Source, World, plan};
use trunnion::mesh::{TriangleMesh, stl_binary_parts};
use trunnion::planning::{OnePrint, Placement, Solid};
use trunnion::profile::{Profile, resolve};

use crate::support::{Numbers, note, seeds};

/// A large table, and a head that is slim: else few rods have room.
const MACHINE: &str = r#"
extends = "generic-ac"
[table]
radius_mm = 150.0
thickness_mm = 8.0
[limits]
x_mm = [-400.0, 400.0]
y_mm = [-400.0, 400.0]
z_mm = [-400.0, 400.0]
[[head.body]]
name = "nozzle"
moves = "XYZ"
kind = "frustum"
z_mm = [0.0, 40.0]
r_mm = [0.5, 4.0]
[[head.body]]
name = "barrel"
moves = "XYZ"
kind = "frustum"
z_mm = [40.0, 120.0]
r_mm = [8.0, 8.0]
"#;

/// The plate's side and thickness, mm.
const PLATE: [f64; 2] = [150.0, 5.0];
/// Rods keep so far from all but the one they stand on, mm.
const APART_MM: f64 = 2.0;

struct Rod {
    foot: Vec3,
    up: Vec3,
    side: Vec3,
    half: f64,
    length: f64,
    /// Of the top.
    normal: Vec3,
}

impl Rod {
    fn across(&self) -> Vec3 {
        self.up.cross(&self.side)
    }

    fn mesh(&self) -> TriangleMesh<Object> {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let foot = corners.map(|(a, b)| self.foot + (self.side * a + self.across() * b) * self.half);
        let middle = self.foot + self.up * self.length;
        let top = foot.map(|p| p + self.up * ((middle - p).dot(&self.normal) / self.up.dot(&self.normal)));
        let mut facets = vec![[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]];
        for k in 0..4 {
            let next = (k + 1) % 4;
            facets.extend([[k, next, next + 4], [k, next + 4, k + 4]]);
        }
        TriangleMesh::new(foot.into_iter().chain(top).collect(), facets)
    }

    /// A rod on one of its sides or on its top.
    fn child(&self, numbers: &mut Numbers) -> Self {
        let half = self.half * numbers.between(0.55, 0.8);
        let (foot, up, along) = if numbers.between(0.0, 1.0) < 0.5 {
            (self.foot + self.up * self.length, self.normal, self.side)
        } else {
            let turn = [self.side, self.across(), -self.side, -self.across()];
            let up = turn[(numbers.between(0.0, 4.0) as usize).min(3)];
            let low = half + 0.5;
            let high = (self.length - self.half - half - 0.5).max(low);
            (self.foot + up * self.half + self.up * numbers.between(low, high), up, self.up)
        };
        let side = (along - up * along.dot(&up)).normalize();
        let length = (half * 3.0).max(numbers.between(8.0, 24.0));
        Self::standing((foot, up, side), (half, length), numbers)
    }

    fn standing((foot, up, side): (Vec3, Vec3, Vec3), (half, length): (f64, f64), numbers: &mut Numbers) -> Self {
        let lean = numbers.between(-40.0, 40.0).to_radians();
        let towards = if numbers.between(0.0, 1.0) < 0.5 { side } else { up.cross(&side) };
        Self { foot, up, side, half, length, normal: (up * lean.cos() + towards * lean.sin()).normalize() }
    }
}

/// Parts in the order in which they can be printed.
fn tree(profile: &Profile, wanted: usize, seed: u64) -> Vec<TriangleMesh<Object>> {
    let mut numbers = Numbers::seeded(9_000_000 + seed);
    let side = PLATE[0] / 2.0;
    let plate = solid_box(Vec3::new(-side, -side, 0.0), Vec3::new(side, side, PLATE[1]));
    let placement = Placement { origin_mm: [0.0; 3], turn_deg: 0.0 };
    let head = OnePrint::new(profile, placement, Angle::from_deg(45.0), 0.5);
    let mut meshes = vec![plate];
    let mut solids = vec![Solid::of(&meshes[0])];
    let mut rods: Vec<(Rod, usize)> = Vec::new();
    for _ in 0..200 * wanted {
        if meshes.len() > wanted {
            break;
        }
        let parent = (numbers.between(0.0, rods.len() as f64 + 3.0) as usize).min(rods.len() + 2);
        let (rod, on) = match rods.get(parent) {
            Some((rod, part)) => (rod.child(&mut numbers), *part),
            None => {
                let at = [0, 1].map(|_| numbers.between(12.0 - side, side - 12.0));
                let foot = Vec3::new(at[0], at[1], PLATE[1]);
                let size = (numbers.between(4.0, 9.0), numbers.between(15.0, 40.0));
                (Rod::standing((foot, Vec3::z(), Vec3::x()), size, &mut numbers), 0)
            }
        };
        if rod.half < 1.5 || !head.reaches(&rod.up) {
            continue;
        }
        let mesh = rod.mesh();
        let solid = Solid::of(&mesh);
        let still = Rigid::<Object, Object>::shift(Vec3::zeros());
        let near =
            |other: &Solid| solid.swept_clearance(&still, [true; 3], &[Vec3::zeros()], other, APART_MM).distance();
        let free = solids.iter().enumerate().all(|(q, other)| q == on || near(other) >= APART_MM);
        let stands = |q: usize| head.allows(&mesh, &rod.up, Some(&meshes[q]));
        if free && (0..meshes.len()).all(stands) && head.allows(&mesh, &rod.up, Some(&together(&meshes))) {
            solids.push(solid);
            rods.push((rod, meshes.len()));
            meshes.push(mesh);
        }
    }
    meshes
}

fn together(meshes: &[TriangleMesh<Object>]) -> TriangleMesh<Object> {
    let (mut vertices, mut facets) = (Vec::new(), Vec::new());
    for mesh in meshes {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(mesh.vertices());
        facets.extend(mesh.facets().iter().map(|f| f.map(|v| v + first)));
    }
    TriangleMesh::new(vertices, facets)
}

fn planned(profile: &Profile, wanted: usize, seed: u64) {
    let start = Instant::now();
    let mut meshes = tree(profile, wanted, seed);
    let built = start.elapsed().as_secs_f64();
    // In any order but that of building.
    let mut random = SplitMix64::seeded(seed);
    for i in (1..meshes.len()).rev() {
        meshes.swap(i, random.below(i + 1));
    }
    let parts: Vec<NamedMesh> = meshes.into_iter().enumerate().map(|(i, mesh)| (format!("part {i}"), mesh)).collect();
    let stl = stl_binary_parts(&parts.iter().map(|(_, mesh)| mesh).collect::<Vec<_>>());
    if let Some(folder) = std::env::var_os("TRUNNION_KEEP") {
        let file = std::path::Path::new(&folder).join(format!("tree-{wanted}-{seed}.stl"));
        std::fs::write(file, &stl).unwrap();
    }
    let bytes = |name: &str, bytes: Vec<u8>| Source::Bytes { name: name.to_owned(), bytes };
    let machine = MachineSource::Toml(bytes("slim.toml", MACHINE.as_bytes().to_vec()));
    let place = Some(PlaceRequest { origin_mm: Some([0.0; 2]), turn_deg: 0.0 });
    let options = PlanOptions { place, remedies: false, ..PlanOptions::default() };
    let request = PlanRequest { options, ..PlanRequest::new(ModelSource::from(bytes("tree.stl", stl)), machine) };
    let start = Instant::now();
    let done =
        plan(&request, &World::here(&Silent)).unwrap_or_else(|error| panic!("{wanted} rods, seed {seed}: {error}"));
    let best = done.best();
    note(&format!(
        "{} rods (of {wanted}, seed {seed}): built in {built:.1} s, planned in {:.2} s, {} pose changes, value {} (at least {})",
        parts.len() - 1,
        start.elapsed().as_secs_f64(),
        best.pose_changes,
        best.value,
        best.lower_bound
    ));
    assert!(best.lower_bound <= best.value + 1e-9);
}

#[test]
fn trees_that_can_be_printed_have_a_plan() {
    let named = |word: &str| word.parse().unwrap();
    let sizes: Vec<usize> = match std::env::var("TRUNNION_RODS") {
        Ok(asked) => asked.split(',').map(named).collect(),
        Err(_) => vec![20, 50],
    };
    let (profile, _) = resolve("slim.toml", MACHINE).unwrap();
    for wanted in sizes {
        for seed in seeds(2, 40) {
            planned(&profile, wanted, seed);
        }
    }
}
