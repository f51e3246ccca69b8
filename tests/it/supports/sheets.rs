//! The mesh that `trunnion support` writes, held against its surface by arithmetic of this file: how far it stays from it, how much of it
//! the judge sees held, and that it is closed.

use std::collections::HashMap;
use std::path::Path;

use rayon::prelude::*;
use serde_json::Value;
use trunnion::geom::{Slot, Vec3};
use trunnion::mesh::{ReadOptions, Repair, TriangleMesh, Unit, read_model, stl_binary_parts};

use super::beside::triangles;
use super::judge::{Layer, Line, Ruler, Triangle};
use super::scenes;
use crate::support::{every, folder, note, said, trunnion};

const STEP_MM: f64 = 2.0;
const LAYER_MM: f64 = 0.2;
const RULER: Ruler = Ruler { pitch_mm: STEP_MM, line_mm: 0.4, layer_mm: LAYER_MM, overhang_deg: 45.0 };

/// A prism over a polygon in x and z that is seen whole from its first corner, from `y` to `y`: counter-clockwise with z to the left of x.
fn prism(outline: &[[f64; 2]], y: [f64; 2]) -> TriangleMesh<Slot> {
    let n = outline.len() as u32;
    let vertices = y.iter().flat_map(|&y| outline.iter().map(move |&[x, z]| Vec3::new(x, y, z))).collect();
    let mut facets: Vec<[u32; 3]> = Vec::new();
    for k in 1..n - 1 {
        facets.extend([[0, k, k + 1], [n, n + k + 1, n + k]]);
    }
    for k in 0..n {
        let next = (k + 1) % n;
        facets.extend([[k, n + k, n + next], [k, n + next, next]]);
    }
    let mesh: TriangleMesh<Slot> = TriangleMesh::new(vertices, facets);
    assert!(mesh.volume() > 0.0);
    mesh
}

/// A post from which an arm goes out, whose underside rises by `rise` over 20 mm and ends at no multiple of a step.
fn arm(rise: f64) -> TriangleMesh<Slot> {
    let outline = [[7.3, 15.1], [27.9, 15.1 + rise], [27.9, 40.0], [0.0, 40.0], [0.0, 0.0], [7.3, 0.0]];
    prism(&outline, [-5.3, 6.1])
}

/// The nearest a triangle comes to a place (Ericson, Real-Time Collision Detection, 5.1.5), mm.
fn distance([a, b, c]: &[Vec3; 3], p: &Vec3) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(&ac);
    let inside = |u: &Vec3, v: &Vec3| normal.dot(&(v - u).cross(&(p - u))) >= 0.0;
    if inside(a, b) && inside(b, c) && inside(c, a) {
        return ap.dot(&normal).abs() / normal.norm();
    }
    let to_edge = |u: &Vec3, v: &Vec3| {
        let way = v - u;
        let t = ((p - u).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
        (p - (u + way * t)).norm()
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

fn corners(mesh: &TriangleMesh<Slot>) -> Vec<[Vec3; 3]> {
    (0..mesh.facets().len()).map(|facet| mesh.corners(facet)).collect()
}

/// Places on a triangle, no farther apart than `every_mm`.
fn places([a, b, c]: &[Vec3; 3], every_mm: f64) -> Vec<Vec3> {
    let longest = (b - a).norm().max((c - a).norm()).max((c - b).norm());
    let n = (longest / every_mm).ceil().max(1.0) as usize;
    let at = |i: usize, j: usize| a + (b - a) * (i as f64 / n as f64) + (c - a) * (j as f64 / n as f64);
    (0..=n).flat_map(|i| (0..=n - i).map(move |j| at(i, j))).collect()
}

/// The least distance of places all over the supports from the part, up to 2 mm.
fn nearest_mm(supports: &TriangleMesh<Slot>, parts: &[TriangleMesh<Slot>]) -> f64 {
    const CELL_MM: f64 = 2.0;
    let cell = |v: f64| (v / CELL_MM).floor() as i64;
    let mut by_cell: HashMap<[i64; 3], Vec<[Vec3; 3]>> = HashMap::new();
    for triangle in parts.iter().flat_map(corners) {
        let range = |k: usize| {
            let [low, high] = [f64::min, f64::max].map(|of| triangle.iter().map(|v| v[k]).reduce(of).unwrap());
            cell(low - CELL_MM)..=cell(high + CELL_MM)
        };
        for (x, y, z) in range(0).flat_map(|x| range(1).flat_map(move |y| range(2).map(move |z| (x, y, z)))) {
            by_cell.entry([x, y, z]).or_default().push(triangle);
        }
    }
    let of_place = |p: &Vec3| {
        let near = by_cell.get(&[cell(p.x), cell(p.y), cell(p.z)]).into_iter().flatten();
        near.map(|triangle| distance(triangle, p)).fold(CELL_MM, f64::min)
    };
    let of_facet = |triangle: &[Vec3; 3]| places(triangle, 0.5).iter().map(of_place).fold(CELL_MM, f64::min);
    corners(supports).par_iter().map(of_facet).reduce(|| CELL_MM, f64::min)
}

/// The mesh as a slicer cuts it: its outlines at the middles of layers, as lines that take no filament.
fn cut(supports: &TriangleMesh<Slot>) -> Vec<Layer> {
    let all = corners(supports);
    let top = all.iter().flatten().map(|v| v.z).fold(0.0, f64::max);
    let layer = |k: usize| {
        let z = (k as f64 + 0.5) * LAYER_MM;
        let of = |triangle: &[Vec3; 3]| -> Option<Line> {
            let ends: Vec<[f64; 2]> = (0..3)
                .filter_map(|i| {
                    let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
                    let t = (z - a.z) / (b.z - a.z);
                    ((a.z < z) != (b.z < z)).then(|| [a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t])
                })
                .collect();
            (ends.len() == 2).then(|| Line { from: ends[0], to: ends[1], mm3: 0.0 })
        };
        Layer { top_mm: (k + 1) as f64 * LAYER_MM, lines: all.iter().filter_map(of).collect() }
    };
    (0..(top / LAYER_MM).ceil() as usize).into_par_iter().map(layer).collect()
}

fn assert_closed(mesh: &TriangleMesh<Slot>) {
    let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
    for facet in mesh.facets() {
        for k in 0..3 {
            let [a, b] = [facet[k], facet[(k + 1) % 3]];
            *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    assert!(edges.values().all(|sum| *sum == 0));
}

/// The supports of a scene, and what is said of them.
fn supported(meshes: &[TriangleMesh<Slot>], more: &[&str], folder: &Path) -> (TriangleMesh<Slot>, Value) {
    let (model, out) = (folder.join("scene.stl"), folder.join("supports.stl"));
    std::fs::write(&model, stl_binary_parts(&meshes.iter().collect::<Vec<_>>())).unwrap();
    let words = ["--unit", "mm", "--keep-z", "--json", "-o"];
    let run = trunnion().arg("support").arg(&model).args(words).arg(&out).args(more).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
    let read = read_model(&std::fs::read(&out).unwrap(), "supports.stl", &options).unwrap();
    let (mut vertices, mut facets) = (Vec::new(), Vec::new());
    for part in &read.parts {
        let base = vertices.len() as u32;
        vertices.extend(part.mesh.vertices().iter().map(|v| Vec3::new(v.x, v.y, v.z)));
        facets.extend(part.mesh.facets().iter().map(|facet| facet.map(|v| v + base)));
    }
    (TriangleMesh::new(vertices, facets), serde_json::from_slice(&run.stdout).unwrap())
}

/// On all sides and at every slope; and strips beside walls, into which no column fits, are held.
#[test]
fn sheets_keep_their_gap_from_all_sides_and_hold_what_is_beside_walls() {
    let folder = folder();
    let arms = [0.0, 3.0, 11.0, 19.9].map(|rise| (format!("arm {rise}"), vec![arm(rise)]));
    let balls = ("balls".to_owned(), scenes::two_balls().meshes);
    let round = [("ring".to_owned(), scenes::leaning_ring().meshes), balls];
    let gaps =
        |name: &str| if every(2) == 1 || name == "arm 3" { vec!["0", "0.1", "0.2", "0.35", "1"] } else { vec!["0.2"] };
    for (name, meshes) in arms.into_iter().chain(round.into_iter().step_by(every(2))) {
        let surface: Vec<Triangle> = triangles(&meshes);
        for gap in gaps(&name) {
            let (supports, document) = supported(&meshes, &["--gap", gap], folder.path());
            let gap_mm: f64 = gap.parse().unwrap();
            assert_closed(&supports);
            let (near, measures) = (nearest_mm(&supports, &meshes), RULER.measure(&surface, &cut(&supports)));
            let share = document["covered_share"].as_f64().unwrap();
            note(&format!(
                "{name}, gap {gap}: {near:.3} mm, held {:.4} by the judge, {share:.4} said",
                measures.covered
            ));
            assert!(near >= gap_mm - 1e-3, "{name}, gap {gap}: {near} mm");
            assert!(near <= gap_mm + 0.15, "{name}, gap {gap}: {near} mm");
            if gap_mm <= LAYER_MM {
                assert!(measures.covered > 0.98 && share > 0.98, "{name}, gap {gap}: {measures:?}, said {share}");
            }
        }
    }
}

/// At every third level, on the ground and below what they hold the corners of cells are within sheets; between, powder gets through.
#[test]
fn sheets_touch_at_every_third_level_alone() {
    let folder = folder();
    let model = [arm(0.0)];
    // Columns straight down, none of which join.
    let straight = ["--method", "min-cost", "--capacity", "1"];
    let (plain, said) = supported(&model, &straight, folder.path());
    let (apart, told) = supported(&model, &[&straight[..], &["--touch-every", "3"]].concat(), folder.path());
    assert_closed(&apart);
    for key in ["cost", "covered_share", "contact_mm2"] {
        assert_eq!(told[key], said[key], "{key}");
    }
    // The lowest layer is measured in its middle.
    let plates = [&told, &said].map(|document| document["plate_mm2"].as_f64().unwrap());
    assert!(plates[0] <= plates[1] && plates[0] > 0.95 * plates[1], "{plates:?}");
    assert!(apart.volume() < 0.95 * plain.volume() && apart.volume() > 0.6 * plain.volume());
    let origin: Vec<f64> = told["origin_mm"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let nearest = |mesh: &TriangleMesh<Slot>, z: f64| -> [f64; 2] {
        // Corners between four columns below the arm.
        let corner = |k: usize, low: f64| origin[k] + ((low - origin[k]) / STEP_MM).ceil() * STEP_MM;
        let places = (0..6).flat_map(|i| (0..3).map(move |j| [i, j])).map(|[i, j]| {
            Vec3::new(corner(0, 12.0) + f64::from(i) * STEP_MM, corner(1, -2.5) + f64::from(j) * STEP_MM, z)
        });
        let all = corners(mesh);
        let of_place = |p: Vec3| all.iter().map(|triangle| distance(triangle, &p)).fold(f64::INFINITY, f64::min);
        let found: Vec<f64> = places.map(of_place).collect();
        [f64::min, f64::max].map(|of| found.iter().copied().reduce(of).unwrap())
    };
    // Half a wall is the farthest from the surface within a sheet; ends are a quarter of a step short, and a quarter of a wall longer.
    let free_mm = 0.25 * STEP_MM - 0.25 * 0.4;
    for level in 0..7 {
        let z = f64::from(level) * STEP_MM + 0.05;
        let [least, most] = nearest(&apart, z);
        if level % 3 == 0 {
            assert!(most < 0.25, "level {level}: {most} mm");
        } else {
            assert!(least > free_mm - 0.06, "level {level}: {least} mm");
        }
        assert!(nearest(&plain, z)[1] < 0.25, "level {level}");
    }
    let [_, most] = nearest(&apart, 14.4);
    assert!(most < 0.25, "below what they hold: {most} mm");
    // Ends go out by no more than they rise, and by half a layer more in the one in which they begin to lean out beside a wall.
    let steep = |[a, b, c]: &[Vec3; 3]| {
        let normal = (b - a).cross(&(c - a));
        normal.z < -0.84 * normal.norm() && a.z.max(b.z).max(c.z) > 0.1
    };
    assert!(!corners(&apart).iter().any(steep));
}
