//! Cubic infill against the faces of cubes that stand on a corner, and what bridges take, by hand.

use super::*;
use crate::slicing::InfillPattern;

const SPARSE: &str = "Internal infill";

fn cubic() -> SliceSettings {
    SliceSettings {
        infill: 0.15,
        infill_pattern: InfillPattern::Cubic,
        layer_height_mm: 0.25,
        ..SliceSettings::default()
    }
}

/// The three faces' normals lean by the same angle, stand upright on each other, and are 120 degrees apart seen from above.
fn normals() -> [Vec3; 3] {
    [45.0, 165.0, 285.0].map(|deg: f64| {
        let across = (deg + 90.0).to_radians();
        let [level, upright] = [(2.0f64 / 3.0).sqrt(), -(1.0f64 / 3.0).sqrt()];
        Vec3::new(level * across.cos(), level * across.sin(), upright)
    })
}

#[test]
fn cubic_lines_lie_on_the_faces_of_cubes_that_stand_on_a_corner() {
    let normals = normals();
    assert!((0..3).all(|i| normals[i].dot(&normals[(i + 1) % 3]).abs() < 1e-12), "no cube: {normals:?}");
    let settings = cubic();
    let (_, lines) = sliced(&block([100.0, 100.0, 0.0], [160.0, 160.0, 12.0]), &settings);
    let line = Line::new(settings.line_width_mm, settings.layer_height_mm);
    let edge = 3.0 * region::mm(f64::from(line.spacing)) / settings.infill;
    let mut seen = [0; 3];
    for line in lines.iter().filter(|line| line.kind == SPARSE && line.length() > 1.0) {
        let middle = |p: [f64; 3]| Vec3::new(p[0], p[1], p[2] - settings.layer_height_mm / 2.0);
        let [from, to] = [middle(line.from), middle(line.to)];
        let face = (0..3).min_by(|&a, &b| {
            let along = |i: usize| (to - from).dot(&normals[i]).abs();
            along(a).total_cmp(&along(b))
        });
        let normal = normals[face.unwrap()];
        seen[face.unwrap()] += 1;
        for p in [from, to] {
            // Faces are half an edge off the origin; their distance on a level is longer by how they lean.
            let place = p.dot(&normal) / (edge * (2.0f64 / 3.0).sqrt()) - 0.5;
            let off = (place - place.round()).abs() * edge;
            assert!(off < 0.01, "{line:?} lies {off} mm beside the faces");
        }
    }
    assert!(seen.iter().all(|lines| *lines > 100), "{seen:?} lines of the three faces");
}

#[test]
fn cubic_infill_has_the_plastic_of_its_share() {
    let mesh = block([100.0, 100.0, 0.0], [160.0, 160.0, 12.0]);
    let lines = sliced(&mesh, &cubic()).1.into_iter().filter(|line| line.kind == SPARSE).collect::<Vec<_>>();
    // Between two walls of 0.45 mm on each side and four layers of 0.25 mm below and above; lines begin and end in the walls.
    let (inside, volume) = (0.15 * 58.2 * 58.2 * 10.0, volume_mm3(&lines));
    assert!((volume / inside - 1.0).abs() < 0.02, "{volume} mm3, {inside} mm3 by its share");
}

#[test]
fn bridges_take_their_share_of_the_flow_and_nothing_else_does() {
    // A table of 30 mm on two legs 20 mm apart.
    let mesh = together(&[
        block([100.0, 100.0, 0.0], [105.0, 110.0, 6.0]),
        block([125.0, 100.0, 0.0], [130.0, 110.0, 6.0]),
        block([100.0, 100.0, 6.0], [130.0, 110.0, 9.0]),
    ]);
    let by_kind = |bridge_flow: f64| {
        let settings = SliceSettings { bridge_flow, ..SliceSettings::default() };
        let (bridges, others): (Vec<Extrusion>, Vec<Extrusion>) =
            sliced(&mesh, &settings).1.into_iter().partition(|line| line.kind == "Bridge infill");
        [volume_mm3(&bridges), volume_mm3(&others)]
    };
    let [whole, spared] = [by_kind(1.0), by_kind(0.9)];
    assert!(whole[0] > 20.0 && (spared[0] / whole[0] - 0.9).abs() < 0.002, "{spared:?} of {whole:?} mm3");
    assert!((spared[1] - whole[1]).abs() < 1e-3, "{spared:?} of {whole:?} mm3");
}

/// How much of a line hangs in one piece, mm, and how much at either end of it; what lies within a line of `carriers` is carried.
fn hanging(line: &Extrusion, carriers: &[[f64; 2]]) -> [f64; 2] {
    let steps = (line.length() / 0.1).ceil();
    let carried = |i: i32| {
        let t = f64::from(i) / steps;
        let p = [0, 1].map(|c| line.from[c] + t * (line.to[c] - line.from[c]));
        carriers.iter().any(|q| (q[0] - p[0]).hypot(q[1] - p[1]) <= 0.5)
    };
    let carried: Vec<bool> = (0..=steps as i32).map(carried).collect();
    let mm = |points: usize| points as f64 * line.length() / steps;
    let longest = carried.split(|carried| *carried).map(<[bool]>::len).max().unwrap_or(0);
    let ends = [carried.iter().take_while(|c| !**c).count(), carried.iter().rev().take_while(|c| !**c).count()];
    [mm(longest), mm(ends[0].max(ends[1]))]
}

/// A roof with a step, and slopes of 20 and 45 degrees.
#[test]
fn what_lies_on_sparse_rows_runs_from_one_to_the_next() {
    let step = |at: f64| {
        together(&[block([140.0, 140.0, 0.0], [170.0, 170.0, 3.0]), block([at, 140.0, 3.0], [170.0, 170.0, 6.0])])
    };
    let slope = |by: f64| frustum(&ring(150.0, 150.0, 16.0, 60), &ring(150.0, 150.0, 16.0 - by, 60), 0.0, 4.0);
    for infill in [0.08, 0.1, 0.2] {
        let settings = SliceSettings { infill, ..SliceSettings::default() };
        let apart = region::mm(f64::from(Line::new(settings.line_width_mm, settings.layer_height_mm).spacing)) / infill;
        for mesh in [step(153.1), step(155.3), step(157.7), slope(4.0), slope(4.0 / 20.0f64.to_radians().tan())] {
            let (_, lines) = sliced(&mesh, &settings);
            let mut bridges = 0;
            for pair in layer_heights(&lines).windows(2) {
                let above = |l: &&Extrusion| l.kind == "Bridge infill" && (l.to[2] * 1000.0).round() as i64 == pair[1];
                let bridging: Vec<&Extrusion> = lines.iter().filter(above).filter(|l| l.length() > 1.0).collect();
                if bridging.is_empty() {
                    continue;
                }
                // Its ends overlap the layer's own walls, which are laid before.
                let walls = lines.iter().filter(|l| l.kind.contains("erimeter")).cloned().collect::<Vec<_>>();
                let carriers = [samples(&lines, pair[0]), samples(&walls, pair[1])].concat();
                for line in bridging {
                    let [longest, end] = hanging(line, &carriers);
                    assert!(longest < apart, "{infill}: {longest} mm of {line:?} hang, rows are {apart} mm apart");
                    assert!(end < 0.3, "{infill}: {end} mm at an end of {line:?} hang");
                    bridges += 1;
                }
            }
            assert!(bridges > 20, "{infill}: {bridges} lines over sparse rows");
        }
    }
}
