//! What is tilted stays standing: a beam on a pin whose foot grows, against statics by hand, from the plan to the finished file; and what a designer
//! has put below a ceiling, a layer of air under it, holds that.

use std::path::Path;

use serde_json::Value;
use trunnion::mesh::stl_binary_parts;

use crate::split::solids::{Shape, block};
use crate::support::{folder, said, trunnion};

const ADHESION_MPA: f64 = 0.02;
const GRAMS_PER_MM3: f64 = 1.24e-3;
const NEWTON: f64 = 9.80665e-3;

fn asked(folder: &Path, verb: &str, parts: &[Shape], more: &[&str]) -> (Option<i32>, Value, String) {
    let (model, out) = (folder.join("parts.stl"), folder.join("out.gcode"));
    let meshes: Vec<_> = parts.iter().map(Shape::mesh).collect();
    std::fs::write(&model, stl_binary_parts(&meshes.iter().collect::<Vec<_>>())).unwrap();
    let _ = std::fs::remove_file(&out);
    let mut command = trunnion();
    command.arg(verb).arg(&model).args(["-m", "generic-ac", "--json", "--no-remedies"]).args(more);
    if verb == "prepare" {
        command.args(["--slicer", "builtin", "-o"]).arg(&out);
    }
    let done = command.output().unwrap();
    assert!(verb != "prepare" || done.status.success() == out.exists(), "{}", said(&done));
    (done.status.code(), serde_json::from_slice(&done.stdout).unwrap_or(Value::Null), said(&done))
}

/// A pin of `side` by `side`, 40 mm high, and a beam of 60 mm on its side, which is printed with the table upright.
fn beam_on_a_pin(side: f64) -> [Shape; 2] {
    [block(side, side, 40.0), block(60.0, side.min(6.0), 6.0).at(side, 0.0, 34.0)]
}

/// How many times over the pin's foot holds both, the table upright.
fn by_hand(side: f64) -> f64 {
    let (pin, beam) = (side * side * 40.0, 60.0 * side.min(6.0) * 6.0);
    let tips = (pin * 20.0 + beam * 37.0) * GRAMS_PER_MM3 * NEWTON;
    ADHESION_MPA * side * side * side / 2.0 / tips
}

#[test]
fn a_beam_on_a_pin_is_refused_where_it_would_fall() {
    let folder = folder();
    let (mut stood, mut fell) = (0, 0);
    for side in [3.0, 4.0, 5.0, 6.0, 8.0, 12.0, 20.0] {
        let wanted = by_hand(side);
        let (code, done, said) = asked(folder.path(), "plan", &beam_on_a_pin(side), &[]);
        if wanted < 1.0 {
            fell += 1;
            assert_eq!(code, Some(1), "{side}: {said}");
            assert!(done["summary"].as_str().unwrap().contains(&format!("{wanted:.2} ")), "{side}: {wanted} {done}");
            continue;
        }
        stood += 1;
        assert_eq!(code, Some(0), "{side}: {said}");
        let standing = &done["standing"];
        assert!((standing["factor"].as_f64().unwrap() / wanted - 1.0).abs() < 1e-6, "{side}: {standing} {wanted}");
        assert_eq!(standing["tilt_deg"], 90.0);
    }
    assert!(stood > 2 && fell > 1, "{stood} stood, {fell} fell");
}

#[test]
fn what_the_plan_lets_stand_stands_in_the_file() {
    let folder = folder();
    for side in [6.0, 8.0, 12.0] {
        let (code, done, said) = asked(folder.path(), "prepare", &beam_on_a_pin(side), &["--way", "as-drawn"]);
        assert_eq!(code, Some(0), "{side}: {said}");
        // With sparse infill it weighs less than the plan has it.
        let factor = done["verify"]["standing"]["factor"].as_f64().unwrap();
        assert!(factor > 0.9 * by_hand(side), "{side}: {factor} {}", by_hand(side));
    }
    // What would fall has no file that way; one that holds better has.
    let (code, _, why) = asked(folder.path(), "prepare", &beam_on_a_pin(4.0), &["--way", "as-drawn"]);
    assert_eq!(code, Some(1), "{why}");
    let machine = folder.path().join("sticky.toml");
    std::fs::write(&machine, "[process]\nadhesion_mpa = 0.3\n").unwrap();
    let parts = beam_on_a_pin(4.0);
    let (model, out) = (folder.path().join("pin.stl"), folder.path().join("pin.gcode"));
    let meshes = parts.map(|shape| shape.mesh());
    std::fs::write(&model, stl_binary_parts(&meshes.iter().collect::<Vec<_>>())).unwrap();
    let done = trunnion()
        .arg("prepare")
        .arg(&model)
        .arg("-m")
        .arg(&machine)
        .args(["--slicer", "builtin", "--way", "as-drawn", "-o"])
        .arg(&out)
        .output()
        .unwrap();
    assert!(done.status.success() && out.exists(), "{}", said(&done));
}

/// A table of 30 mm on two legs, 22 mm apart, too far for a bridge; and, a part of its own, a post below its middle that leaves `gap` mm of air.
fn over_a_post(gap: f64) -> [Shape; 2] {
    let top = block(34.0, 14.0, 3.0).at(0.0, 0.0, 12.0);
    let table = top.and(&block(6.0, 14.0, 12.1)).and(&block(6.0, 14.0, 12.1).at(28.0, 0.0, 0.0));
    [table, block(10.0, 14.0, 12.0 - gap).at(12.0, 0.0, 0.0)]
}

#[test]
fn a_post_that_ends_a_layer_below_a_ceiling_holds_it() {
    let folder = folder();
    let way = |done: &Value| done["ways"][0]["way"].as_str().unwrap_or("none").to_owned();
    for (gap, holds) in [(0.2, true), (0.25, true), (0.3, true), (0.4, true), (0.75, false), (2.0, false)] {
        let (code, done, said) = asked(folder.path(), "prepare", &over_a_post(gap), &[]);
        assert_eq!(code == Some(0) && way(&done) == "as-drawn", holds, "{gap}: {} {said}", way(&done));
        if holds {
            assert_eq!(done["plan"]["parts"].as_array().unwrap().len(), 2, "{gap}");
        }
    }
    // Without it nothing holds.
    let [table, _] = over_a_post(0.2);
    let (_, done, said) = asked(folder.path(), "prepare", &[table], &[]);
    assert_ne!(way(&done), "as-drawn", "{said}");
}

/// What the plan says of a part on supports is what the finished file says, whose lines tell where they stand: by them a post that carries a long
/// bar does not tip, and the way that was priced tells the same.
#[test]
fn on_supports_the_plan_and_the_finished_file_agree_how_firmly_it_stands() {
    let folder = folder();
    for (side, long) in [(6.0, 40.0), (10.0, 60.0), (16.0, 30.0)] {
        let post = block(side, side, 25.0).and(&block(long, side, 5.0).at(0.0, 0.0, 24.0));
        let (code, done, said) = asked(folder.path(), "prepare", &[post], &["--way", "supports"]);
        assert_eq!(code, Some(0), "{side}: {said}");
        let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{side}: {value} {said}"));
        let planned = number(&done["plan"]["standing"]["pushed_factor"]);
        let read = number(&done["verify"]["standing"]["pushed_factor"]);
        // Solid as it is planned, a little lighter as it is sliced; the lines' own width is not the plan's.
        assert!(planned <= read * 1.05 && planned >= read * 0.7, "{side}: planned {planned}, read {read}");
        let taken = done["ways"].as_array().unwrap().iter().find(|way| way["chosen"] == true).unwrap();
        assert_eq!(number(&taken["stands"]), planned, "{taken}");
    }
}
