//! What does not fit on a table at once: a file for each plate, each proved, and all bodies on them.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use trunnion::fixtures::solid_box;
use trunnion::geom::Vec3;
use trunnion::mesh::{ReadOptions, read_model, stl_binary, stl_binary_parts};

use crate::support::{fails, folder, said, trunnion};

fn run(folder: &Path, args: &[&str]) -> Output {
    trunnion().current_dir(folder).args(args).output().unwrap()
}

/// A box of so much with its low corner there, as one of several in a file.
fn boxes(path: &Path, all: &[([f64; 3], [f64; 3])]) {
    let meshes: Vec<_> =
        all.iter().map(|(at, size)| solid_box((*at).into(), Vec3::from(*at) + Vec3::from(*size))).collect();
    fs::write(path, stl_binary_parts(&meshes.iter().collect::<Vec<_>>())).unwrap();
}

/// `prepare --plates out`; each plate verified once more from what is on the disk, and counted: bodies of each model, by the document.
fn prepared(here: &Path, models: &[&str], rest: &[&str]) -> (Value, Vec<(String, u64)>) {
    let flags = ["-m", "open5x-prusa", "--slicer", "builtin", "--plates", "out", "--json"];
    let done = run(here, &[&["prepare"], models, &flags[..], rest].concat());
    assert!(done.status.success(), "{}", said(&done));
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    let mut bodies: Vec<(String, u64)> = Vec::new();
    for (index, plate) in document["plates"].as_array().unwrap().iter().enumerate() {
        let file = |end: &str| format!("out/plate-{}.{end}", index + 1);
        assert_eq!(plate["prepared"]["output"], file("gcode").as_str());
        let verify = run(here, &["verify", &file("gcode"), "--plan", &file("plan.json")]);
        assert!(verify.status.success(), "{}", said(&verify));
        let model =
            read_model(&fs::read(here.join(file("3mf"))).unwrap(), "plate.3mf", &ReadOptions::default()).unwrap();
        let held = plate["holds"].as_array().unwrap();
        let counted: u64 = held.iter().map(|one| one["count"].as_u64().unwrap()).sum();
        assert!(model.parts.len() as u64 >= counted, "{plate}");
        for one in held {
            let (name, count) = (one["model"].as_str().unwrap().to_owned(), one["count"].as_u64().unwrap());
            let times = plate["times"].as_u64().unwrap();
            match bodies.iter_mut().find(|(known, _)| *known == name) {
                Some((_, all)) => *all += count * times,
                None => bodies.push((name, count * times)),
            }
        }
    }
    bodies.sort();
    (document, bodies)
}

#[test]
fn copies_that_do_not_fit_at_once_are_told_by_their_plates_and_made() {
    let folder = folder();
    let here = folder.path();
    fs::write(here.join("cube.stl"), stl_binary(&solid_box(Vec3::zeros(), Vec3::new(20.0, 20.0, 20.0)))).unwrap();
    for verb in ["prepare", "plan"] {
        let whole = run(here, &[verb, "cube.stl*9", "-m", "open5x-prusa", "-o", "whole"]);
        assert!(fails(&said(&whole), "strategy/several-plates: 9 | 3 plates | -m "), "{}", said(&whole));
        assert!(!here.join("whole").exists());
    }
    let (document, bodies) = prepared(here, &["cube.stl*9"], &[]);
    assert_eq!(bodies, [("cube.stl".to_owned(), 9)]);
    // Nine cubes of 20 mm on a disc of 70 mm: four stand in a square of 45 mm, five in no way.
    let times: Vec<u64> = document["plates"].as_array().unwrap().iter().map(|p| p["times"].as_u64().unwrap()).collect();
    assert_eq!(times, [2, 1]);
}

#[test]
fn models_of_several_sizes_share_plates_and_each_is_printed_its_way() {
    let folder = folder();
    let here = folder.path();
    fs::copy(crate::support::root().join("fixtures/hook.stl"), here.join("hook.stl")).unwrap();
    fs::write(here.join("pin.stl"), stl_binary(&solid_box(Vec3::zeros(), Vec3::new(6.0, 6.0, 12.0)))).unwrap();
    let (document, bodies) = prepared(here, &["hook.stl*4", "pin.stl*3"], &[]);
    assert_eq!(bodies, [("hook.stl".to_owned(), 4), ("pin.stl".to_owned(), 3)]);
    let plates = document["plates"].as_array().unwrap();
    assert!(plates[0]["prepared"]["supports"].is_object(), "the hook hangs");
}

#[test]
fn the_loose_solids_of_one_file_go_where_there_is_room_and_stacked_ones_stay_together() {
    let folder = folder();
    let here = folder.path();
    let place = |x: f64| ([x, 0.0, 0.0], [30.0, 30.0, 6.0]);
    let on_top = ([125.0, 5.0, 6.0], [10.0, 10.0, 6.0]);
    boxes(&here.join("tray.stl"), &[place(0.0), place(40.0), place(80.0), place(120.0), on_top]);
    let (document, bodies) = prepared(here, &["tray.stl"], &[]);
    assert_eq!(bodies, [("tray.stl".to_owned(), 4)], "what stands on another is no body of its own");
    let plates = document["plates"].as_array().unwrap();
    let parts: Vec<usize> =
        plates.iter().map(|plate| plate["prepared"]["plan"]["parts"].as_array().unwrap().len()).collect();
    assert!(
        plates.len() > 1
            && parts
                .iter()
                .zip(plates)
                .map(|(parts, plate)| parts * plate["times"].as_u64().unwrap() as usize)
                .sum::<usize>()
                == 5,
        "{parts:?}"
    );
}

/// As many as no plan takes: each plate has fewer.
#[test]
fn more_bodies_than_one_plan_takes_are_shared_out() {
    let folder = folder();
    let here = folder.path();
    let at = |k: usize| ([8.0 * (k % 30) as f64, 8.0 * (k / 30) as f64, 0.0], [2.0, 2.0, 0.4]);
    boxes(&here.join("chips.stl"), &(0..450).map(at).collect::<Vec<_>>());
    let whole = run(here, &["prepare", "chips.stl", "-m", "generic-ac", "--slicer", "builtin", "-o", "whole"]);
    assert!(fails(&said(&whole), "plan/too-many-parts: 450 | --plates DIR"), "{}", said(&whole));
    let (_, bodies) = prepared(here, &["chips.stl"], &[]);
    assert_eq!(bodies, [("chips.stl".to_owned(), 450)]);
}

#[test]
fn what_fits_on_no_plate_is_refused_and_what_an_earlier_run_left_is_set_aside() {
    let folder = folder();
    let here = folder.path();
    boxes(&here.join("long.stl"), &[([0.0; 3], [300.0, 10.0, 10.0])]);
    fs::create_dir(here.join("out")).unwrap();
    fs::write(here.join("out/plate-1.gcode"), "G1 X1\n").unwrap();
    fs::write(here.join("out/plate-2.gcode"), "G1 X1\n").unwrap();
    let args = ["prepare", "long.stl*2", "-m", "open5x-prusa", "--slicer", "builtin", "--plates", "out"];
    let no = run(here, &args);
    assert!(!no.status.success() && said(&no).contains("part 0"), "{}", said(&no));
    for number in [1, 2] {
        assert!(!here.join(format!("out/plate-{number}.gcode")).exists());
        assert!(here.join(format!("out/plate-{number}.gcode.stale")).exists());
    }
    let both = run(here, &[&args[..], &["-o", "x.gcode"]].concat());
    assert_eq!(both.status.code(), Some(2), "{}", said(&both));
}
