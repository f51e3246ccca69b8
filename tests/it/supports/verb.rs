//! `trunnion support`: files, document, pictures, and sentences for what cannot be.

use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::Value;
use trunnion::geom::{Slot, Vec3};
use trunnion::mesh::{ReadOptions, Repair, TriangleMesh, Unit, read_model, stl_binary, stl_binary_parts};

use super::{reference, scenes};
use crate::support::{first_error, folder, said, states, trunnion};

fn write(folder: &Path, name: &str, meshes: &[TriangleMesh<Slot>]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, stl_binary_parts(&meshes.iter().collect::<Vec<_>>())).unwrap();
    path
}

fn run(model: &Path, more: &[&str]) -> Output {
    trunnion().arg("support").arg(model).args(["--unit", "mm"]).args(more).output().unwrap()
}

#[track_caller]
fn document(model: &Path, more: &[&str]) -> Value {
    let output = run(model, &[more, &["--json"]].concat());
    assert!(output.status.success(), "{}", said(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The error's sentence of a call that fails with code 2.
#[track_caller]
fn refused(model: &Path, more: &[&str]) -> String {
    let output = run(model, more);
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{}", said(&output));
    let text = String::from_utf8(output.stderr).unwrap();
    let error = first_error(&text).1;
    assert!(!error.ends_with('.') && !text.contains("panicked"), "{text}");
    error.to_owned()
}

const RING: [&str; 5] = ["--keep-z", "--space", "90,90,50", "--step", "2.15"];

#[test]
fn the_document_has_its_keys_for_every_method() {
    let folder = folder();
    let model = write(folder.path(), "ring.stl", &scenes::leaning_ring().meshes);
    for method in ["auto", "min-cost", "push-relabel", "shortest-paths"] {
        let done = document(&model, &[&RING[..], &["--method", method]].concat());
        assert_eq!(done["grid"], serde_json::json!([42, 42, 24]));
        assert_eq!(done["method"], method);
        for key in ["nodes", "arcs", "red", "green", "cost", "lower_bound", "used_arcs"] {
            assert!(done[key].as_u64().unwrap() > 0, "{key}");
        }
        for key in ["unreachable", "over_capacity"] {
            assert_eq!(done[key], 0, "{key}");
        }
        for key in ["length_mm", "volume_mm3", "seconds"] {
            assert!(done[key].as_f64().unwrap() > 0.0, "{key}");
        }
        assert_eq!(done["covered_share"], 1.0);
        assert!(done["cost"].as_u64() >= done["lower_bound"].as_u64());
        let one =
            document(&model, &[&RING[..], &["--method", method, "--capacity", "1", "--node-capacity", "1"]].concat());
        assert_eq!(one["over_capacity"], 0);
        assert_eq!(
            one["used_arcs"],
            one["length_mm"]
                .as_f64()
                .map(|_| one["straight_arcs"].as_u64().unwrap() + one["oblique_arcs"].as_u64().unwrap())
                .unwrap()
        );
    }
}

#[test]
fn the_scenes_beside_the_repository_come_out_of_the_verb_too() {
    let Some(folder) = reference::folder() else { return };
    let ball = folder.join("C.stl");
    let space = ["--keep-z", "--space", "100,100,90", "--step", "1.54", "--method", "min-cost"];
    let done = document(&ball, &space);
    assert_eq!((&done["cost"], &done["grid"]), (&Value::from(11960), &serde_json::json!([65, 65, 59])));
    let one = document(&ball, &[&space[..], &["--capacity", "1"]].concat());
    assert_eq!(one["cost"], 12600);
}

#[test]
fn files_are_the_same_each_time_and_hold_what_is_said() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let model = write(folder.path(), "ring.stl", &scenes::leaning_ring().meshes);
    let done = document(&model, &["-o", &at("a.stl"), "--view", &at("a.png")]);
    document(&model, &["-o", &at("b.stl"), "--view", &at("b.png")]);
    for ending in ["stl", "png"] {
        let read = |name| std::fs::read(folder.path().join(format!("{name}.{ending}"))).unwrap();
        assert!(read("a") == read("b"), "{ending}");
    }
    assert!(std::fs::read(at("a.png")).unwrap().starts_with(b"\x89PNG"));
    let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
    let supports = read_model(&std::fs::read(at("a.stl")).unwrap(), "a.stl", &options).unwrap();
    let volume: f64 = supports.parts.iter().map(|part| part.mesh.volume()).sum();
    let said = done["volume_mm3"].as_f64().unwrap();
    assert!((volume / said - 1.0).abs() < 0.02, "{volume} for {said}");
    assert!(supports.bounds.min.z.abs() < 1e-6);
    document(&model, &["-o", &at("both.3mf"), "--structure", "tree"]);
    let both = read_model(&std::fs::read(at("both.3mf")).unwrap(), "both.3mf", &options).unwrap();
    assert!(both.parts.iter().any(|part| part.name == "supports"), "{:?}", both.parts[0].name);
    assert!(both.parts.len() > 10 && both.bounds.min.z.abs() < 1e-6);
}

#[test]
fn a_roof_and_struts_are_told_and_written() {
    let folder = folder();
    let model = write(folder.path(), "ring.stl", &scenes::leaning_ring().meshes);
    let plain = document(&model, &RING);
    assert_eq!([&plain["struts"], &plain["unbraced"], &plain["roof_bars"]], [&Value::from(0); 3]);
    let supports = folder.path().join("supports.stl").display().to_string();
    let stiff = document(&model, &[&RING[..], &["--roof", "0.6", "--brace", "8.6", "-o", &supports]].concat());
    let more = |key: &str| stiff[key].as_f64().unwrap() - plain[key].as_f64().unwrap();
    assert!(stiff["struts"].as_u64() > Some(3) && stiff["roof_bars"].as_u64() > Some(50), "{stiff}");
    assert!(plain["longest_free_mm"].as_f64() > Some(8.6) && stiff["longest_free_mm"].as_f64() <= Some(8.7), "{stiff}");
    assert!(more("volume_mm3") > 0.0 && more("contact_mm2") > 0.0 && more("cost") == 0.0, "{stiff}");
    let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
    let read = read_model(&std::fs::read(&supports).unwrap(), "supports.stl", &options).unwrap();
    assert!(read.parts.len() as u64 > stiff["roof_bars"].as_u64().unwrap());
}

/// Upright, a plate on the ground needs nothing; on its edge a face that leans over does.
#[test]
fn another_direction_is_another_plan() {
    let folder = folder();
    let plate = scenes::block(Vec3::zeros(), Vec3::new(30.0, 20.0, 4.0));
    let model = write(folder.path(), "plate.stl", &[plate]);
    let (target, named) = (folder.path().join("none.stl"), folder.path().join("none.stl").display().to_string());
    let output = run(&model, &["-o", &named]);
    assert!(output.status.success() && !target.exists(), "{}", said(&output));
    assert!(states(&said(&output), "overhangs"), "{}", said(&output));
    assert_eq!(document(&model, &["--up", "0,0,-5"])["red"], 0);
    let leaning = document(&model, &["--up", "1,0,1.5"]);
    assert!(leaning["red"].as_u64().unwrap() > 20, "{leaning}");
}

#[test]
fn what_cannot_be_is_refused_in_a_sentence() {
    let folder = folder();
    let ring = write(folder.path(), "ring.stl", &scenes::leaning_ring().meshes);
    let ball = &scenes::leaning_ring().meshes[0];
    let open = TriangleMesh::<Slot>::new(ball.vertices().to_vec(), ball.facets()[1..].to_vec());
    let open_file = folder.path().join("open.stl");
    std::fs::write(&open_file, stl_binary(&open)).unwrap();
    let name = |ending: &str| folder.path().join(ending).display().to_string();
    let (text, stl) = (name("supports.txt"), name("supports.stl"));
    let cases: [(&Path, &[&str], &[&str]); 22] = [
        (&open_file, &["-o", &stl, "--repair", "off"], &["open.stl", "3 open edges", "--repair off"]),
        (&ring, &["--step", "0"], &["--step", "0.05 and 100", "got 0 mm"]),
        (&ring, &["--step", "-2"], &["--step", "0.05 and 100", "got -2 mm"]),
        (&ring, &["--step", "0.5", "--wall", "0.6"], &["--wall", "0.01 and 0.5", "got 0.6 mm"]),
        (&ring, &["--step", "0.06"], &["--step 0.06 mm makes", "cubes", "--step 0."]),
        (&ring, &["--space", "90,90"], &["--space", "90,90", "three numbers"]),
        (&ring, &["--space", "60,90,50"], &["--space", "in x", "60.000", "enlarge the space"]),
        (&ring, &["--up", "0,0,0"], &["has no direction"]),
        (&ring, &["--up", "a,0,1"], &["--up", "a,0,1", "three numbers"]),
        (&ring, &["--method", "mincost"], &["--method mincost", "min-cost"]),
        (&ring, &["--structure", "trees"], &["--structure trees", "tree"]),
        (&ring, &["--capacity", "0"], &["--capacity", "1 and 1000", "got 0"]),
        (&ring, &["--overhang", "90"], &["--overhang", "1 and 89", "got 90 deg"]),
        (&ring, &["--gap", "-1"], &["--gap", "0 and 5", "got -1 mm"]),
        (&ring, &["--roof", "3"], &["--roof", "0 and 2", "got 3 mm"]),
        (&ring, &["--roof", "1", "--roof-pitch", "0.05"], &["--roof-pitch", "0.1 and 10", "got 0.05 mm"]),
        (&ring, &["--roof", "1", "--roof-pitch", "0.3"], &["--roof-pitch", "0.4 and 10", "got 0.3 mm"]),
        (&ring, &["--brace", "3"], &["--brace", "4 and 1000", "got 3 mm"]),
        (&ring, &["--touch-every", "0"], &["--touch-every", "1 and 1000", "got 0"]),
        (&ring, &["--touch-every", "3", "--structure", "tree"], &["--touch-every 3", "--structure x"]),
        (&ring, &["--touch-every", "3", "--wall", "0.7"], &["--wall", "0.01 and 0.6", "got 0.7 mm"]),
        (&ring, &["-o", &text], &["supports.txt", ".stl or .3mf"]),
    ];
    for (model, more, wanted) in cases {
        let text = refused(model, more);
        assert!(wanted.iter().all(|word| text.contains(word)), "{more:?}: {text}");
    }
    assert!(!Path::new(&stl).exists() && !Path::new(&text).exists());
}

/// A ball in a closed box: nothing leads to the ground from it; the box's own ceiling hangs inside just so.
#[test]
fn a_part_without_a_way_to_the_ground_is_a_no_with_its_place() {
    let folder = folder();
    let wide = |low: f64, high: f64| scenes::block(Vec3::new(0.0, 0.0, low), Vec3::new(60.0, 60.0, high));
    let meshes = [wide(0.0, 2.0), scenes::ball(Vec3::new(30.0, 30.0, 30.0), 8.0, 24)];
    let model = write(folder.path(), "over.stl", &meshes);
    let target = folder.path().join("over-supports.stl");
    let named = target.display().to_string();
    let no = run(&model, &["--space", "60,60,40", "-o", &named, "--json"]);
    assert_eq!(no.status.code(), Some(1), "{}", said(&no));
    let text = String::from_utf8_lossy(&no.stderr).into_owned();
    assert!(states(&text, "ground | mm2 | --up"), "{text}");
    let done: Value = serde_json::from_slice(&no.stdout).unwrap();
    assert!(done["red"] == 0 && done["unreachable"].as_u64().unwrap() > 10 && !target.exists(), "{done}");
    assert!(done["unreachable_patches"][0]["area_mm2"].as_f64().unwrap() > 40.0);
    // With room around the plate the ball's supports go there where they can, and the rest is told.
    let narrow = write(
        folder.path(),
        "narrow.stl",
        &[
            scenes::block(Vec3::new(20.0, 20.0, 0.0), Vec3::new(40.0, 40.0, 2.0)),
            scenes::ball(Vec3::new(30.0, 30.0, 30.0), 8.0, 24),
        ],
    );
    let some = document(&narrow, &["--space", "60,60,40"]);
    assert!(some["red"].as_u64().unwrap() > 10 && some["unreachable"] == 0, "{some}");
}
