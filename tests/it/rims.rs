//! The nozzle's rim over the table in finished files, read by arithmetic of its own; and that the plan keeps what the proof asks.

use std::fs;
use std::path::Path;

use serde_json::Value;
use trunnion::fixtures::prism;
use trunnion::geom::Object;
use trunnion::mesh::{TriangleMesh, stl_binary_parts};

use crate::pipeline::{FIXTURES, fixture, prepare};
use crate::support::{folder, note, said, trunnion};

/// The least height of the nozzle's flat over the tilted table where filament is laid, mm, and how far that is tilted at most: of the
/// shipped `generic-ac`, whose A turns about the line y = 0, z = -20 with the table's surface 20 mm above it.
pub(crate) fn lowest_rim(file: &Path, radius_mm: f64) -> (f64, f64) {
    let (mut at, mut low, mut tilted) = ([0.0_f64; 5], f64::INFINITY, 0.0_f64);
    for line in fs::read_to_string(file).unwrap().lines().filter(|line| line.starts_with("G1")) {
        let (mut laid, mut moves) = (0.0, false);
        for word in line.split(';').next().unwrap().split_whitespace().skip(1) {
            let (letter, value) = word.split_at(1);
            let value: f64 = value.parse().unwrap();
            match letter {
                "E" => laid = value,
                "F" => {}
                _ => {
                    moves |= letter == "X" || letter == "Y";
                    at["XYZAC".find(letter).unwrap()] = value;
                }
            }
        }
        let [_, y, z, a, _] = at;
        if laid > 0.0 && moves && a != 0.0 {
            // Rx(-a) brings the machine's frame back to that of the table; C turns about the table's own normal and changes no height.
            let (s, c) = a.to_radians().sin_cos();
            let height = |y: f64, z: f64| c * (z + 20.0) - s * y - 20.0;
            low = low.min(height(y - radius_mm, z)).min(height(y + radius_mm, z));
            tilted = tilted.max(a.abs());
        }
    }
    (low, tilted)
}

/// A block whose upper face leans by this angle and comes down to `over_mm` above the table, and a branch that stands at the lower end of
/// that face and grows at right angles to it.
fn branched(over_mm: f64, angle_deg: f64) -> Vec<(String, TriangleMesh<Object>)> {
    let (s, c) = angle_deg.to_radians().sin_cos();
    let low = [10.0, over_mm];
    let at = |along: f64, out: f64| [low[0] - c * along + s * out, low[1] + s * along + c * out];
    let high = at(25.0, 0.0);
    let block = [[-20.0, 0.0], [10.0, 0.0], low, high, [-20.0, high[1]]];
    let branch = [low, at(0.0, 12.0), at(9.0, 12.0), at(9.0, 0.0)];
    vec![("block".to_owned(), prism(&block, [-6.0, 6.0])), ("branch".to_owned(), prism(&branch, [-5.0, 5.0]))]
}

/// What is planned is never refused for the rim, and never comes below the table, at whatever height the branch begins.
#[test]
fn no_branch_is_printed_with_the_rim_below_the_table() {
    let folder = folder();
    let (model, out) = (folder.path().join("branched.stl"), folder.path().join("out.gcode"));
    let (mut made, mut refused, mut told) = (0, 0, Vec::new());
    for angle in [20.0, 30.0, 45.0] {
        for tenths in [1, 2, 3, 4, 6, 10, 30] {
            let over_mm = f64::from(tenths) / 10.0;
            let parts = branched(over_mm, angle);
            fs::write(&model, stl_binary_parts(&parts.iter().map(|(_, mesh)| mesh).collect::<Vec<_>>())).unwrap();
            let _ = fs::remove_file(&out);
            let args = ["-m", "generic-ac", "--slicer", "builtin", "--way", "as-drawn", "--no-remedies", "-o"];
            let done = trunnion().arg("prepare").arg(&model).args(args).arg(&out).output().unwrap();
            if done.status.success() {
                let (low, tilted) = lowest_rim(&out, 0.5);
                told.push(format!("{angle} deg, {over_mm} mm: {low:.3} mm at up to {tilted} deg"));
                assert!(low >= -0.005, "{}", told.join("\n"));
                made += usize::from(tilted > 0.0);
            } else {
                assert_eq!(done.status.code(), Some(1), "{}", said(&done));
                assert!(!said(&done).contains("findings"), "refused by the proof: {}", said(&done));
                refused += 1;
            }
        }
    }
    note(&told.join("\n"));
    // Where the branch's own axis does not do, the table is tilted less.
    assert!(made >= 20 && refused == 0, "{made} tilted, {refused} refused\n{}", told.join("\n"));
}

/// A post and a branch of 8 mm on its side that leans by this angle from the vertical: they touch in the post's wall, which rises beside the
/// branch's first lines at whatever angle the table stands.
fn on_a_wall(angle_deg: f64) -> Vec<TriangleMesh<Object>> {
    let (s, c) = angle_deg.to_radians().sin_cos();
    // A side of the branch, by how far it lies above its axis: where it leaves the wall, and its end.
    let side = |above: f64| {
        let along = |far: f64| [far * s - above * c, 22.0 + far * c + above * s];
        [along((6.0 + above * c) / s), along(40.0)]
    };
    let ([from, to], [back, end]) = (side(-4.0), side(4.0));
    let post = [[-6.0, 0.0], [6.0, 0.0], [6.0, 50.0], [-6.0, 50.0]];
    vec![prism(&post, [-6.0, 6.0]), prism(&[from, to, end, back], [-4.0, 4.0])]
}

/// Along its own axis the canonical branch of 45 degrees has the nozzle's rim in the post: it is printed with the table tilted otherwise.
#[test]
fn a_branch_on_a_wall_is_printed_at_every_lean() {
    let folder = folder();
    let (model, out) = (folder.path().join("branch.stl"), folder.path().join("out.gcode"));
    let mut told = Vec::new();
    for angle in [35.0, 40.0, 45.0, 50.0, 60.0, 75.0, 90.0] {
        fs::write(&model, stl_binary_parts(&on_a_wall(angle).iter().collect::<Vec<_>>())).unwrap();
        let _ = fs::remove_file(&out);
        let args = ["-m", "generic-ac", "--slicer", "builtin", "--way", "as-drawn", "--no-remedies", "-o"];
        let done = trunnion().arg("prepare").arg(&model).args(args).arg(&out).output().unwrap();
        assert!(done.status.success(), "{angle} deg: {}", said(&done));
        let (low, tilted) = lowest_rim(&out, 0.5);
        told.push(format!("{angle} deg: {low:.3} mm at up to {tilted} deg"));
        assert!(low >= -0.005 && tilted > 20.0, "{}", told.join("\n"));
        // What is listed is what is planned.
        let listed = trunnion().arg("plan").arg(&model).args(["-m", "generic-ac", "--all", "--json"]).output().unwrap();
        let listed: Value = serde_json::from_slice(&listed.stdout).unwrap();
        assert!(listed["count"].as_u64().is_some_and(|count| count > 0), "{angle} deg: {listed}");
    }
    note(&told.join("\n"));
}

#[test]
fn no_fixture_is_printed_with_the_rim_below_the_table() {
    let folder = folder();
    let mut told = Vec::new();
    for name in FIXTURES {
        let out = folder.path().join(format!("{name}.gcode"));
        prepare(&fixture(name), "generic-ac", "builtin", &out, &[]);
        let (low, tilted) = lowest_rim(&out, 0.5);
        assert!(low >= -0.005, "{name}: {low} mm");
        told.push((name, low, tilted));
    }
    note(&format!("the least height of the rim over a tilted table, mm, and the greatest tilt: {told:.3?}"));
    assert_eq!(told.iter().filter(|(_, _, tilted)| *tilted > 0.0).count(), 4, "{told:?}");
}

/// A wide flat over a branch that begins near the table: what is planned keeps its rim out of it, and too wide a one has no plan.
#[test]
fn the_wider_the_flat_the_higher_the_least_branch() {
    let folder = folder();
    let (model, out) = (folder.path().join("branched.stl"), folder.path().join("out.gcode"));
    let parts = branched(1.0, 45.0);
    fs::write(&model, stl_binary_parts(&parts.iter().map(|(_, mesh)| mesh).collect::<Vec<_>>())).unwrap();
    let mut done_at = Vec::new();
    for radius in [0.3, 0.5, 0.8, 1.2, 1.6, 2.0, 3.0, 4.0] {
        let machine = folder.path().join("wide.toml");
        let cone = format!(
            "name = \"nozzle\"\nmoves = \"XYZ\"\nkind = \"frustum\"\nz_mm = [0.0, 10.0]\nr_mm = [{radius:?}, 8.0]"
        );
        fs::write(&machine, format!("extends = \"generic-ac\"\n[head]\nbare_cone = true\n[[head.body]]\n{cone}\n"))
            .unwrap();
        let _ = fs::remove_file(&out);
        let args = ["--slicer", "builtin", "--way", "as-drawn", "--no-remedies", "-o"];
        let mut command = trunnion();
        let done = command.arg("prepare").arg(&model).arg("-m").arg(&machine).args(args).arg(&out).output().unwrap();
        if done.status.success() {
            let (low, tilted) = lowest_rim(&out, radius);
            note(&format!("flat of {radius} mm: {low:.3} mm over a table tilted by {tilted} deg"));
            assert!(low >= -0.005 && tilted > 0.0, "flat of {radius} mm: {low} mm");
            done_at.push(radius);
        } else {
            assert_eq!(done.status.code(), Some(1), "{}", said(&done));
            assert!(!said(&done).contains("findings"), "flat of {radius} mm, refused by the proof: {}", said(&done));
        }
    }
    // By hand: the first line lies half its width up the slope, 1.16 mm above the table. Above the flat the nozzle keeps a margin of 0.5 mm:
    // `r sin a` is 0.66 mm at most, which is a flat of 0.93 mm.
    assert_eq!(done_at, [0.3, 0.5, 0.8]);
}
