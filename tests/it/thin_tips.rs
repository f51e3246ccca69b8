//! A tip that is thinner than a line for longer than two lines is no missing piece; one that has room for a line is.

use std::fs;
use std::path::Path;

use trunnion::fixtures::prism;
use trunnion::geom::{Object, Vec3};
use trunnion::mesh::{TriangleMesh, stl_binary};

use crate::support::{folder, said, trunnion};

fn done(folder: &Path, words: &[&str]) {
    let run = trunnion().current_dir(folder).args(words).output().unwrap();
    assert!(run.status.success(), "{words:?}: {}", said(&run));
}

/// A wedge of 9 degrees on its side: the tip is thinner than 0.27 mm for 1.7 mm.
fn wedge(folder: &Path) {
    let half = 40.0 * f64::to_radians(4.5).tan();
    // A prism lies along y: its outline is in x and z.
    let mesh = prism(&[[0.0, half], [40.0, 0.0], [40.0, 2.0 * half]], [-6.0, 6.0]);
    let upright = mesh.vertices().iter().map(|v| Vec3::new(v.x, v.z, v.y + 6.0)).collect();
    let facets = mesh.facets().iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let mesh = TriangleMesh::<Object>::new(upright, facets);
    fs::write(folder.join("wedge.stl"), stl_binary(&mesh)).unwrap();
}

#[test]
fn a_wedge_that_ends_in_a_thin_tip_is_prepared() {
    let folder = folder();
    let here = folder.path();
    wedge(here);
    done(here, &["prepare", "wedge.stl", "-m", "generic-ac", "--slicer", "builtin", "-o", "wedge.gcode"]);
}

#[test]
fn a_wedge_without_the_thick_part_of_its_tip_is_refused() {
    let folder = folder();
    let here = folder.path();
    wedge(here);
    done(here, &["plan", "wedge.stl", "-m", "generic-ac", "-o", "plan.json"]);
    done(here, &["slice", "plan.json", "--slicer", "builtin", "-o", "sliced"]);
    let file = fs::read_dir(here.join("sliced"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .find(|p| p.extension().is_some_and(|e| e == "gcode"));
    let file = file.unwrap();
    let text = fs::read_to_string(&file).unwrap();
    let xs = text.lines().filter(|line| line.starts_with("G1 X")).filter_map(x_of);
    let [low, high] = xs.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)]);
    assert!((30.0..40.0).contains(&(high - low)), "{low}..{high}");
    for (cut, kept) in [(0.5, true), (1.0, true), (4.0, false), (8.0, false)] {
        // The checksum would tell; another slicer's file has none. All that the tip takes of filament stays, close to where it ends.
        let end = low + cut;
        let lines = text.lines().filter(|line| !line.contains("crc32"));
        let cut_off: Vec<String> = lines
            .map(|line| match x_of(line).filter(|x| *x < end) {
                Some(x) => moved(line, end - 0.02 * (end - x)),
                None => line.to_owned(),
            })
            .collect();
        let name = file.file_name().unwrap();
        fs::write(here.join(name), cut_off.join("\n") + "\n").unwrap();
        let mut run = trunnion();
        let run = run
            .current_dir(here)
            .args(["rewrite", "--plan", "plan.json", "-o", "out.gcode"])
            .arg(name)
            .output()
            .unwrap();
        let told = said(&run);
        // Said as what is the most likely to have been done.
        let refused =
            ["mm short of the part in x", "times as large as the part in x"].iter().any(|text| told.contains(text));
        assert_eq!(refused, !kept, "{cut} mm: {told}");
    }
}

/// The line with another X.
fn moved(line: &str, x: f64) -> String {
    let word = |word: &str| if word.starts_with('X') { format!("X{x:.5}") } else { word.to_owned() };
    line.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

fn x_of(line: &str) -> Option<f64> {
    line.split_whitespace().find_map(|word| word.strip_prefix('X')?.parse().ok())
}
