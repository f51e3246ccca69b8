//! Every shipped machine from a model to a printed program.

use std::path::Path;

use trunnion::profile::{SHIPPED, resolve};

use super::real::{assert_same, executed, output, simulate, wanted};
use crate::support::{folder, note, root, said, trunnion};

/// A part that stands and one that leans on it: the table turns, tilts and goes back.
#[test]
fn each_shipped_machine_prints_a_file_that_verifies() {
    for (name, file, text) in SHIPPED {
        let dir = folder();
        let (out, plan) = (dir.path().join("out.gcode"), dir.path().join("plan.json"));
        let mut prepare = trunnion();
        prepare.args(["prepare", "-q", "--slicer", "builtin", "-m", name]).arg(root().join("fixtures/y-tree.stl"));
        let done = output(prepare.arg("-o").arg(&out).arg("--plan-out").arg(&plan));
        assert!(done.status.success(), "{name}: {}", said(&done));
        let profile = resolve(file, text).unwrap().0;
        let program = std::fs::read_to_string(&out).unwrap();
        for letter in [profile.kinematics.tilt.letter, profile.kinematics.rotation.letter] {
            assert!(program.contains(&format!("\nG1 {letter}")), "{name}: {letter} never turns");
        }
        if profile.link.protocol == "none" {
            continue;
        }
        let (link, log) = (dir.path().join("tty"), dir.path().join("sim.log"));
        let _printer = simulate(&link, Path::new(name), &["--speed", "max", "--log", log.to_str().unwrap()]);
        let done = output(trunnion().arg("send").arg(&out).arg("--plan").arg(&plan).arg("--port").arg(&link));
        assert!(done.status.success(), "{name}: {}", said(&done));
        // The sender waits for the last move by itself as well.
        let wanted: Vec<String> = wanted(&out).into_iter().filter(|line| line != "M400").collect();
        assert_same(&wanted, &executed(&log));
        note(&format!("{name}: {} lines printed", program.lines().count()));
    }
}

/// A profile that cannot home with a part on its table says why, and the page about sending names it.
#[test]
fn a_shipped_profile_homes_with_a_part_on_its_table_or_says_why_not() {
    let page = std::fs::read_to_string(root().join("docs/send.md")).unwrap();
    for (name, file, text) in SHIPPED {
        let profile = resolve(file, text).unwrap().0;
        let reason = text.lines().any(|l| l.starts_with('#') && l.contains("rehome stays empty: "));
        assert_eq!(profile.link.rehome.is_empty(), reason, "{name}");
        assert!(!reason || page.contains(&format!("`{name}`")), "docs/send.md does not name {name}");
    }
}
