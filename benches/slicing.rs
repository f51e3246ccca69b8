//! The built-in slicer alone, from a mesh to sliced G-code: many islands, many facets, long layers.
//!
//! `RAYON_NUM_THREADS=1 cargo bench -p trunnion-benches --bench slicing [MODEL]`. Every figure is the best of five runs of one process, so that ratios of one run
//! can be compared.

use std::f64::consts::TAU;
use std::hint::black_box;
use std::io::Write as _;
use std::time::Instant;

use trunnion::geom::{Slot, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::slicing::{Adhesion, BuiltIn, SliceJob, SliceSettings, Slicer};

const RUNS: usize = 5;
const BED: [f64; 2] = [250.0, 250.0];

/// Vertices and facets that grow.
#[derive(Default)]
struct Solid {
    vertices: Vec<Vec3>,
    facets: Vec<[u32; 3]>,
}

impl Solid {
    /// A round column of `corners` corners from z = 0 to `height`.
    fn column(&mut self, [x, y]: [f64; 2], radius: f64, corners: u32, height: f64) {
        let first = self.vertices.len() as u32;
        for z in [0.0, height] {
            let corner = |i: u32| (f64::from(i) / f64::from(corners) * TAU).sin_cos();
            self.vertices.extend((0..corners).map(corner).map(|(s, c)| Vec3::new(x + radius * c, y + radius * s, z)));
        }
        for i in 0..corners {
            let (a, b) = (first + i, first + (i + 1) % corners);
            self.facets.extend([[a, b, b + corners], [a, b + corners, a + corners]]);
        }
        for i in 1..corners - 1 {
            let top = first + corners;
            self.facets.extend([[first, first + i + 1, first + i], [top, top + i, top + i + 1]]);
        }
    }

    /// A ball that stands on z = 0, of `2 rings (rings - 1)` quarters of `rings`.
    fn ball(&mut self, radius: f64, rings: u32) {
        let around = 2 * rings;
        let middle = Vec3::new(BED[0] / 2.0, BED[1] / 2.0, radius);
        for ring in 0..=rings {
            let (s, c) = (f64::from(ring) / f64::from(rings) * TAU / 2.0).sin_cos();
            for i in 0..around {
                let (y, x) = (f64::from(i) / f64::from(around) * TAU).sin_cos();
                self.vertices.push(middle + radius * Vec3::new(s * x, s * y, -c));
            }
        }
        for ring in 0..rings {
            for i in 0..around {
                let [a, b] = [i, (i + 1) % around].map(|i| ring * around + i);
                self.facets.extend([[a, b, b + around], [a, b + around, a + around]]);
            }
        }
        self.facets.retain(|f| {
            let [a, b, c] = f.map(|i| self.vertices[i as usize]);
            (b - a).cross(&(c - a)).norm() > 1e-12
        });
    }

    fn mesh(self) -> TriangleMesh<Slot> {
        TriangleMesh::new(self.vertices, self.facets)
    }
}

/// A name, a mesh, the share of infill.
fn models() -> Vec<(&'static str, TriangleMesh<Slot>, f64)> {
    let mut pins = Solid::default();
    for i in 0..4900 {
        let at = [i % 70, i / 70].map(|k| 25.0 + 2.8 * f64::from(k));
        pins.column(at, 0.9, 12, 2.0);
    }
    let mut ball = Solid::default();
    ball.ball(40.0, 500);
    let mut block = Solid::default();
    block.column([125.0, 125.0], 60.0, 240, 10.0);
    block.column([125.0, 125.0], 61.0, 240, 10.0);
    vec![
        ("4,900 pins", pins.mesh(), 0.2),
        ("ball of a million facets", ball.mesh(), 0.2),
        ("full disc", block.mesh(), 1.0),
    ]
}

fn main() {
    let only: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with("--")).collect();
    let job = SliceJob { name: "bench".to_owned(), on_table: true, bed_mm: BED, adhesion: Adhesion::default() };
    for (name, mesh, infill) in models() {
        if !only.is_empty() && !only.iter().any(|part| name.contains(part.as_str())) {
            continue;
        }
        let settings = SliceSettings { infill, ..SliceSettings::default() };
        let slice = || BuiltIn.slice(black_box(&mesh), &settings, &job).expect("slices").gcode.len();
        let one = |_| {
            let start = Instant::now();
            let bytes = slice();
            (start.elapsed().as_secs_f64(), bytes)
        };
        let best = (0..RUNS).map(one).min_by(|a, b| a.0.total_cmp(&b.0)).expect("runs");
        let said = format!("{name:26} {:9} facets {:8.3} s {:10} bytes\n", mesh.facets().len(), best.0, best.1);
        let _ = std::io::stdout().write_all(said.as_bytes());
    }
}
