//! The pages of `docs/`: each block of shell is run as it is printed, all blocks of a page in order in one folder, as a reader does who stands in
//! the folder of a clone. Every link leads somewhere, and pages for users are easy to read.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::{folder, installed, root, said, skip};

/// Pages whose blocks need printers, servers, packages of a network or hours, and why; all others are run here.
const ELSEWHERE: [(&str, &str); 3] = [
    ("how-to/publish.md", "run beside servers by publish::recipes"),
    ("how-to/send.md", "needs two printers"),
    ("how-to/workbench.md", "needs a person; workbench::browser does the same in Chromium"),
];

/// All pages, by their path below `docs`.
pub(crate) fn pages() -> Vec<String> {
    let mut found = Vec::new();
    for below in ["", "how-to", "reference", "explanation"] {
        for entry in std::fs::read_dir(root().join("docs").join(below)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|ending| ending == "md") {
                found.push(path.strip_prefix(root().join("docs")).unwrap().to_str().unwrap().to_owned());
            }
        }
    }
    found.sort();
    found
}

fn text(page: &str) -> String {
    std::fs::read_to_string(root().join("docs").join(page)).unwrap()
}

/// The blocks of shell in a page, in order.
fn blocks(page: &str) -> Vec<String> {
    let text = text(page);
    let pieces = text.split("```sh\n").skip(1);
    pieces.map(|piece| piece.split("```").next().unwrap().to_owned()).collect()
}

/// What a block says that it writes.
fn outputs(block: &str) -> BTreeSet<&str> {
    const ENDINGS: [&str; 10] = [".gcode", ".3mf", ".stl", ".svg", ".png", ".pdf", ".html", ".json", ".toml", ".ini"];
    let words: Vec<&str> = block.split(['\n', ' ']).filter(|word| !word.is_empty()).collect();
    let is_flag = |word: &str| {
        ["-o", ">", "--sheet", "--view", "--landscape", "--preview", "--plan-out", "--dry-run", "--poses", "--gcode"]
            .contains(&word)
    };
    let written = words.windows(2).filter(|two| is_flag(two[0])).map(|two| two[1]);
    written.filter(|word| ENDINGS.iter().any(|ending| word.ends_with(ending))).collect()
}

/// A program that a page leaves running, by the file with its number; ended with the page, whatever becomes of it.
struct Background(PathBuf);

impl Drop for Background {
    fn drop(&mut self) {
        if let Ok(number) = std::fs::read_to_string(&self.0) {
            let _ = Command::new("kill").arg(number.trim()).output();
        }
    }
}

/// Runs the blocks of `page`; what each writes must be there, and a program finished.
fn run(page: &str) {
    let own = Path::new(env!("CARGO_BIN_EXE_trunnion")).parent().unwrap();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(own.to_owned()).chain(std::env::split_paths(&path))).unwrap();
    let folder = folder();
    let here = folder.path();
    let _background = Background(here.join("simulated.pid"));
    for part_of_a_clone in ["fixtures", "docs"] {
        std::os::unix::fs::symlink(root().join(part_of_a_clone), here.join(part_of_a_clone)).unwrap();
    }
    let blocks = blocks(page);
    assert!(!blocks.is_empty(), "{page} has no block");
    for block in blocks {
        let mut shell = Command::new("sh");
        shell.args(["-e", "-c", &block]).current_dir(here).env("PATH", &path);
        let run = shell.output().unwrap();
        assert!(run.status.success(), "{page}:\n{block}{}", said(&run));
        for written in outputs(&block) {
            assert!(here.join(written).is_file(), "{page}:\n{block} wrote no {written}");
            let begun = |end: &str| std::fs::read_to_string(here.join(written)).unwrap().contains(end);
            // Every program but what only visits poses, cold.
            if written.ends_with(".gcode") && !["visit.gcode", "dry.gcode"].contains(&written) {
                assert!(begun("\n;TRUNNION end\n"), "{page}:\n{block} wrote {written} in part");
            }
            if page == "how-to/support.md" && written.ends_with(".gcode") {
                assert!(begun(";TYPE:Support material"), "{page}:\n{block} wrote {written} without supports");
            }
            if written.ends_with(".html") {
                assert!(begun("<!DOCTYPE html>") && begun("</html>"), "{page}:\n{block}");
            }
        }
        let folders = block.split_whitespace().collect::<Vec<_>>();
        for made in folders.windows(2).filter(|two| two[0] == "-o" && !two[1].contains('.')) {
            let count = std::fs::read_dir(here.join(made[1])).unwrap().count();
            assert!(count > 0, "{page}:\n{block} wrote nothing to {}", made[1]);
        }
    }
}

#[test]
fn of_the_tutorial() {
    run("tutorial.md");
}

#[test]
fn of_models() {
    run("how-to/models.md");
}

#[test]
fn of_orientation() {
    run("explanation/orientation.md");
}

#[test]
fn of_an_own_machine() {
    run("how-to/machine.md");
}

#[test]
fn of_a_head_that_turns() {
    run("how-to/heads.md");
}

#[test]
fn of_a_tower() {
    run("how-to/tower.md");
}

#[test]
fn of_a_first_machine() {
    run("how-to/first-machine.md");
}

#[test]
fn of_the_preview() {
    run("how-to/preview.md");
}

#[test]
fn of_prusa_slicer() {
    if !installed("prusa-slicer") {
        return skip("prusa-slicer is not installed: docs/how-to/prusa-slicer.md is not run");
    }
    run("how-to/prusa-slicer.md");
}

#[test]
fn of_slic3r() {
    if !installed("slic3r") {
        return skip("slic3r is not installed: docs/how-to/slic3r.md is not run");
    }
    run("how-to/slic3r.md");
}

#[test]
fn of_batches() {
    run("how-to/batches.md");
}

#[test]
fn of_deciding() {
    run("explanation/deciding.md");
}

#[test]
fn of_supports() {
    run("how-to/support.md");
}

#[test]
fn of_packing() {
    run("how-to/packing.md");
}

#[test]
fn of_documents() {
    run("reference/json.md");
}

#[test]
fn of_cura() {
    if !crate::cura_engine::is_there() {
        return;
    }
    run("how-to/cura.md");
}

/// A page with a block of shell is run by a test of its own, or listed with a reason.
#[test]
fn every_page_with_commands_is_run() {
    let here = std::fs::read_to_string(root().join("tests/it/recipes.rs")).unwrap();
    let is_run = |page: &String| here.contains(&format!("run({page:?})"));
    let is_elsewhere = |page: &String| ELSEWHERE.iter().any(|(other, _)| page == other);
    let left: Vec<String> =
        pages().into_iter().filter(|page| !blocks(page).is_empty() && !is_run(page) && !is_elsewhere(page)).collect();
    assert_eq!(left, Vec::<String>::new());
}

/// Every link of README, CONTRIBUTING and the pages leads to a file, and to a heading of it.
#[test]
fn every_link_leads_somewhere() {
    let anchor = |heading: &str| -> String {
        let kept = heading.trim_start_matches('#').trim().to_lowercase();
        kept.chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
            .map(|c| if c == ' ' { '-' } else { c })
            .collect()
    };
    let mut broken = Vec::new();
    let outer = ["README.md", "CONTRIBUTING.md"].map(PathBuf::from);
    for page in outer.into_iter().chain(pages().into_iter().map(|page| Path::new("docs").join(page))) {
        let text = std::fs::read_to_string(root().join(&page)).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if link.starts_with("http") {
                continue;
            }
            let (path, heading) = link.split_once('#').unwrap_or((link, ""));
            let target =
                if path.is_empty() { root().join(&page) } else { root().join(&page).parent().unwrap().join(path) };
            let has = |text: String| text.lines().any(|line| line.starts_with('#') && anchor(line) == heading);
            let found = target.exists() && (heading.is_empty() || std::fs::read_to_string(&target).is_ok_and(has));
            if !found {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert_eq!(broken, Vec::<String>::new());
}
