//! How much memory `orient` takes: bytes for each facet, beside what reading the mesh takes.

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use trunnion::mesh::stl_binary;

use crate::solids::lump;
use crate::support::{folder, note, skip, trunnion};

/// Bytes a facet beside the mesh that the objectives without sets may take.
const MOST: f64 = 200.0;

/// Those whose searches keep lists for a while, and those that do not.
const NAMES: [&str; 7] = [
    "printable",
    "weighted-normal-z",
    "height",
    "staircase",
    "overhang-angle",
    "support-volume-convex",
    "support-volume-column",
];

/// The highest resident size of the command so far, bytes, as the system counts it.
fn highest(id: u32) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()? * 1024.0)
}

/// The highest resident size of a run, looked at every millisecond: it only ever grows.
fn peak(args: &[&str]) -> f64 {
    let mut command = trunnion();
    command.args(args).env("RAYON_NUM_THREADS", "1").stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let mut most = 0.0_f64;
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{args:?}");
            return most;
        }
        most = most.max(highest(child.id()).unwrap_or(0.0));
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Bytes for each facet by which a larger lump takes more than a smaller one.
fn slope(files: &[(usize, String)], args: &[&str]) -> f64 {
    let of = |(_, file): &(usize, String)| peak(&[&[args[0], file, "--unit", "mm"], &args[1..]].concat());
    let [small, large] = [&files[0], &files[1]];
    (of(large) - of(small)) / (large.0 - small.0) as f64
}

#[test]
fn a_facet_takes_no_more_than_two_hundred_bytes_beside_the_mesh() {
    if highest(std::process::id()).is_none() {
        return skip("the system does not say how much memory a program took (/proc/PID/status)");
    }
    let folder = folder();
    let file = |rings: usize| {
        let mesh = lump(rings, 1.0);
        let path = folder.path().join(format!("lump-{rings}.stl"));
        std::fs::write(&path, stl_binary(&mesh)).unwrap();
        (mesh.facets().len(), Path::to_str(&path).unwrap().to_owned())
    };
    let files = [file(130), file(230)];
    let reading = slope(&files, &["inspect"]);
    for name in NAMES {
        let whole = slope(&files, &["orient", "--objective", name, "--budget", "300"]);
        note(&format!("{name}: {whole:.0} bytes a facet, {reading:.0} of them to read the mesh"));
        assert!(whole - reading <= MOST, "{name}: {whole} bytes a facet, {reading} of them to read the mesh");
    }
}
