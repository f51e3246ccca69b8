//! How much memory a large model takes, as the system counts it: the most that the command held at once.

use std::process::Command;

use trunnion::geom::{Object, Vec3};
use trunnion::mesh::{TriangleMesh, stl_binary};

use crate::support::{folder, note, python, said, skip, trunnion};

/// Runs a command and says on its last line the most that it held, KB.
const MEASURED: &str = "import resource, subprocess, sys\n\
                        done = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL)\n\
                        print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)\n\
                        sys.exit(done.returncode)\n";

/// A ball that stands on the table, of about `4 rings^2` facets.
fn ball(radius: f64, rings: u32) -> TriangleMesh<Object> {
    let sides = 2 * rings;
    let at = |ring: u32, side: u32| {
        let [low, along] =
            [(ring, rings), (2 * side, sides)].map(|(k, of)| std::f64::consts::PI * f64::from(k) / f64::from(of));
        Vec3::new(radius * low.sin() * along.cos(), radius * low.sin() * along.sin(), radius - radius * low.cos())
    };
    let mut vertices = vec![Vec3::zeros()];
    vertices.extend((1..rings).flat_map(|ring| (0..sides).map(move |side| at(ring, side))));
    vertices.push(Vec3::new(0.0, 0.0, 2.0 * radius));
    let top = vertices.len() as u32 - 1;
    let number = |ring: u32, side: u32| 1 + (ring - 1) * sides + side % sides;
    let mut facets = Vec::new();
    for side in 0..sides {
        facets.push([0, number(1, side + 1), number(1, side)]);
        facets.push([top, number(rings - 1, side), number(rings - 1, side + 1)]);
        for ring in 1..rings - 1 {
            let [a, b, c, d] =
                [(ring, side), (ring, side + 1), (ring + 1, side), (ring + 1, side + 1)].map(|(r, s)| number(r, s));
            facets.extend([[a, b, d], [a, d, c]]);
        }
    }
    TriangleMesh::new(vertices, facets)
}

/// A million facets were 245 MB, of which the text of a project for PrusaSlicer's window was two thirds; now some 170.
#[test]
fn a_quarter_of_a_million_facets_are_sliced_in_some_fifty_megabytes() {
    if !cfg!(target_os = "linux") {
        return skip("memory is counted in other units here");
    }
    let Some(python) = python(&["python3"], "resource") else { return skip("no python3 to count memory with") };
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let mesh = ball(40.0, 250);
    let facets = mesh.facets().len();
    std::fs::write(path("ball.stl"), stl_binary(&mesh)).unwrap();
    let plan = ["plan", "ball.stl", "-m", "generic-ac", "--allow", "0", "--overhang", "89", "-q", "-o", "plan.json"];
    let planned = trunnion().current_dir(folder.path()).args(plan).output().unwrap();
    assert!(planned.status.success(), "{}", said(&planned));
    let mut run = Command::new(python);
    run.current_dir(folder.path()).args(["-c", MEASURED, env!("CARGO_BIN_EXE_trunnion")]);
    let run = run.args(["slice", "plan.json", "--slicer", "builtin", "-q", "-o", "slots"]).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let text = String::from_utf8_lossy(&run.stdout);
    let kilobytes: f64 = text.lines().last().unwrap().trim().parse().unwrap();
    note(&format!("slice of {facets} facets holds at most {:.0} MB", kilobytes / 1024.0));
    // For a million that is 220 MB; it was 251 with the whole text of the project in memory.
    assert!(kilobytes * 1024.0 < 40e6 + 180.0 * facets as f64, "{kilobytes} KB for {facets} facets");
}
