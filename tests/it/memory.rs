//! How much memory a large model takes, as the system counts it: the most that the command held at once.

use std::process::Command;

use trunnion::mesh::stl_binary;

use crate::split::solids::ball;
use crate::support::{folder, note, python, said, skip, trunnion};

/// Runs a command and says on its last line the most that it held, KB.
const MEASURED: &str = "import resource, subprocess, sys\n\
                        done = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL)\n\
                        print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)\n\
                        sys.exit(done.returncode)\n";

/// A million facets were 239 MiB, of which the text of a project for PrusaSlicer's window was two thirds; now 164.
#[test]
fn a_quarter_of_a_million_facets_take_some_seventy_megabytes() {
    if !cfg!(target_os = "linux") {
        return skip("memory is counted in other units here");
    }
    let Some(python) = python(&["python3"], "resource") else { return skip("no python3 to count memory with") };
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let mesh = ball(40.0, 500).mesh();
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
