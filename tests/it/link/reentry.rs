//! After a reset of the printer: `send --resume --plan` proves the re-entry, and what is printed a second time behind it,
//! against everything that may stand on the table by then.

use std::path::{Path, PathBuf};
use std::process::Output;

use super::real::{executed, output, profile, simulate, wanted};
use crate::support::{fails, folder, root, said, trunnion};

/// Two boxes, the second on the side of the first: the file as sent, its plan beside it.
fn prepared(dir: &Path, machine: &Path) -> PathBuf {
    prepared_of(dir, machine, &root().join("fixtures/two-boxes.stl"))
}

/// The same of any model.
pub(super) fn prepared_of(dir: &Path, machine: &Path, model: &Path) -> PathBuf {
    let file = dir.join("out.gcode");
    let mut command = trunnion();
    command.args(["prepare", "-q", "--slicer", "builtin", "--way", "as-drawn", "-m"]).arg(machine).arg(model);
    let done = output(command.arg("-o").arg(&file).arg("--plan-out").arg(dir.join("plan.json")));
    assert!(done.status.success(), "{}", said(&done));
    file
}

fn send(file: &Path, link: &Path, more: &[&str]) -> Output {
    let plan = file.parent().unwrap().join("plan.json");
    output(trunnion().arg("send").arg(file).arg("--plan").arg(plan).arg("--port").arg(link).args(more))
}

/// Prints `file` up to a reset before its line `block` and tries to go on; what was said, and what was executed before and after.
pub(super) fn reset_at(dir: &Path, machine: &Path, file: &Path, block: u32) -> (Output, Vec<String>, Vec<String>) {
    let (link, log) = (dir.join("tty"), dir.join("sim.log"));
    let fault = format!("reset@{block}");
    let printer = ["--speed", "max", "--fault", fault.as_str(), "--log", log.to_str().unwrap()];
    let _printer = simulate(&link, machine, &printer);
    let stopped = send(file, &link, &[]);
    assert!(stopped.status.code() == Some(4) && said(&stopped).contains("was reset"), "{}", said(&stopped));
    let before = executed(&log).len();
    let resumed = send(file, &link, &["--resume", "--yes"]);
    let mut all = executed(&log);
    let after = all.split_off(before);
    (resumed, all, after)
}

/// The file's line number of the `n`th layer of print `print`.
fn layer(file: &Path, print: u32, n: usize) -> u32 {
    let text = std::fs::read_to_string(file).unwrap();
    let start = text.lines().position(|l| l.starts_with(&format!(";TRUNNION print={print} "))).unwrap();
    let layers = text.lines().enumerate().skip(start).filter(|(_, l)| *l == ";LAYER_CHANGE");
    u32::try_from(layers.map(|(i, _)| i).nth(n).unwrap()).unwrap()
}

#[test]
fn a_re_entry_that_is_clear_is_carried_out_at_both_poses() {
    let dir = folder();
    let machine = profile(dir.path());
    let file = prepared(dir.path(), &machine);
    let all = wanted(&file);
    // In the middle of a long layer of the upright print, and of the one on its side.
    for (print, text) in [(0, "G1A0F"), (1, "G1A90F")] {
        let wire = |line: u32| {
            let text = std::fs::read_to_string(&file).unwrap();
            let blocks = text.lines().take(line as usize).filter(|l| !l.is_empty() && !l.starts_with(';')).count();
            u32::try_from(blocks + blocks / 32).unwrap()
        };
        let (resumed, before, after) = reset_at(dir.path(), &machine, &file, wire(layer(&file, print, 2)) + 100);
        assert!(resumed.status.success(), "print {print}: {}", said(&resumed));
        let tail = after.iter().rev().zip(all.iter().rev()).take_while(|(a, w)| a == w).count();
        // The window's lines were sent, and nobody knows of them.
        assert!(tail + before.len() + 5 >= all.len(), "print {print}: lines are missing between the two");
        assert!(before.len() + tail < all.len() + 40, "print {print}: too much is printed again");
        let own = &after[..after.len() - tail];
        assert!(own.iter().any(|l| l == "G28") && own.iter().any(|l| l.starts_with(text)), "print {print}: {own:?}");
    }
}

#[test]
fn a_way_through_what_is_printed_is_refused_and_nothing_moves() {
    let dir = folder();
    let machine = dir.path().join("machine.toml");
    // Homing that ends low over the table, and a top of Z that is below the print.
    let text = "extends = \"generic-ac\"\n[link]\nrehome = \"G28\\nG1 Z320 F900\\nG1 C90 F1800\\nG1 A90 F1200\\nG1 Z1 F900\"\n";
    std::fs::write(&machine, text).unwrap();
    let file = prepared(dir.path(), &machine);
    let (resumed, _, after) = reset_at(dir.path(), &machine, &file, 600);
    assert_eq!(resumed.status.code(), Some(4), "{}", said(&resumed));
    assert!(fails(&said(&resumed), "job/printer: blocked"), "{}", said(&resumed));
    assert!(after.is_empty(), "nothing may move: {after:?}");
}
