//! The recipes of `docs/`, run as they are printed: each block of shell in an empty folder with a model.

use std::path::Path;
use std::process::Command;

use trunnion::mesh::stl_binary;

use crate::pipeline::fixture;
use crate::split::solids::block as block_of;
use crate::support::{folder, installed, root, said, skip};

/// The blocks of shell in a page, in order.
fn blocks(page: &str) -> Vec<String> {
    let text = std::fs::read_to_string(root().join("docs").join(page)).unwrap();
    let pieces = text.split("```sh\n").skip(1);
    pieces.map(|piece| piece.split("```").next().unwrap().to_owned()).collect()
}

/// Runs each block of `page`; the file that it writes must be there, and finished.
fn run(page: &str, least: usize) {
    let blocks = blocks(page);
    assert!(blocks.len() >= least, "{page} has {} blocks", blocks.len());
    let own = Path::new(env!("CARGO_BIN_EXE_trunnion")).parent().unwrap();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(own.to_owned()).chain(std::env::split_paths(&path))).unwrap();
    for block in blocks {
        let folder = folder();
        std::fs::copy(fixture("y-tree"), folder.path().join("tree.stl")).unwrap();
        let hanging = block_of(16.0, 16.0, 30.0).and(&block_of(60.0, 16.0, 8.0).at(0.0, 0.0, 22.0));
        std::fs::write(folder.path().join("hanging.stl"), stl_binary(&hanging.mesh())).unwrap();
        let mut shell = Command::new("sh");
        shell.args(["-e", "-c", &block]).current_dir(folder.path()).env("PATH", &path);
        let run = shell.output().unwrap();
        assert!(run.status.success(), "{page}:\n{block}{}", said(&run));
        for written in
            block.split_whitespace().filter(|word| word.starts_with("supports.") || word.ends_with("supports.3mf"))
        {
            assert!(folder.path().join(written).is_file(), "{page}:\n{block} wrote no {written}");
        }
        if block.contains("hanging.gcode") {
            let text = std::fs::read_to_string(folder.path().join("hanging.gcode")).unwrap();
            assert!(text.contains(";TYPE:Support material") && text.contains("\n;TRUNNION end\n"), "{page}:\n{block}");
        }
        for written in ["mine.toml", "machine.svg", "touches.toml", "visit.gcode", "calibrated.toml", "dry.gcode"] {
            let there = folder.path().join(written).is_file();
            assert!(there || !block.contains(written), "{page}:\n{block} wrote no {written}");
        }
        if block.contains("view.html") {
            let html = std::fs::read_to_string(folder.path().join("view.html")).unwrap();
            assert!(html.starts_with("<!DOCTYPE html>") && html.trim_end().ends_with("</html>"), "{page}:\n{block}");
        }
        if block.contains("-o results") {
            let documents = std::fs::read_dir(folder.path().join("results")).unwrap().count();
            assert!(documents >= 1, "{page}:\n{block} wrote no document");
        }
        if block.contains("-o plates") {
            assert!(folder.path().join("plates/plate-01.3mf").is_file(), "{page}:\n{block} wrote no plate");
        }
        let words: Vec<&str> = block.split_whitespace().collect();
        for written in words.windows(2).filter(|two| two[0] == "-o" && two[1].ends_with(".gcode")) {
            let text = std::fs::read_to_string(folder.path().join(written[1])).unwrap();
            assert!(text.contains("\n;TRUNNION end\n"), "{page}:\n{block} wrote {} in part", written[1]);
        }
    }
}

#[test]
fn of_orientation() {
    run("orientation.md", 1);
}

#[test]
fn of_an_own_machine() {
    run("machine.md", 4);
}

#[test]
fn of_the_preview() {
    run("preview.md", 3);
}

#[test]
fn of_prusa_slicer() {
    if !installed("prusa-slicer") {
        return skip("prusa-slicer is not installed: the recipes of docs/prusa-slicer.md are not run");
    }
    run("prusa-slicer.md", 5);
}

#[test]
fn of_slic3r() {
    if !installed("slic3r") {
        return skip("slic3r is not installed: the recipes of docs/slic3r.md are not run");
    }
    run("slic3r.md", 3);
}

#[test]
fn of_batches() {
    run("batches.md", 1);
}

#[test]
fn of_deciding() {
    run("deciding.md", 1);
}

#[test]
fn of_supports() {
    run("support.md", 6);
}

#[test]
fn of_packing() {
    run("packing.md", 4);
}

#[test]
fn of_cura() {
    if !crate::cura_engine::is_there() {
        return;
    }
    run("cura.md", 2);
}
