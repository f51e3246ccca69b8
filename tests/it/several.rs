//! Several solids on one table, of which some have no plan as they are: each is cut, or all stand on supports.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use trunnion::geom::{Object, Rigid, Vec3};
use trunnion::mesh::{TriangleMesh, stl_binary, stl_binary_parts};

use crate::split::solids::{Shape, all, block};
use crate::support::{folder as new_folder, installed, note, skip, states, trunnion};

fn run(folder: &Path, args: &[&str]) -> Output {
    trunnion().current_dir(folder).args(args).output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn solid(name: &str) -> Shape {
    all().into_iter().find(|solid| solid.name == name).unwrap().shape
}

/// The solids of the tests as files.
fn files(folder: &Path) {
    for name in ["tee", "hook", "mushroom"] {
        fs::write(folder.join(format!("{name}.stl")), stl_binary(&solid(name).mesh())).unwrap();
    }
    fs::write(folder.join("block.stl"), stl_binary(&block(20.0, 12.0, 30.0).mesh())).unwrap();
}

/// `prepare` of some files; with the document, and the file verified once more from what is on the disk.
fn prepared(folder: &Path, args: &[&str]) -> (Output, Option<Value>) {
    let rest = ["-m", "generic-ac", "-o", "out.gcode", "--plan-out", "out.json", "--json"];
    let done = run(folder, &[&["prepare"], args, &rest[..]].concat());
    if !done.status.success() {
        return (done, None);
    }
    let verify = run(folder, &["verify", "out.gcode", "--plan", "out.json"]);
    assert!(verify.status.success(), "{args:?}: {}", told(&verify));
    fs::remove_file(folder.join("out.gcode")).unwrap();
    let document = serde_json::from_slice(&done.stdout).unwrap();
    (done, Some(document))
}

#[test]
fn each_solid_is_cut_as_it_would_be_alone_and_copies_alike() {
    let folder = new_folder();
    let here = folder.path();
    files(here);
    let slicers = ["builtin", "prusa-slicer"].into_iter().filter(|slicer| {
        let there = *slicer == "builtin" || installed(slicer);
        if !there {
            skip(&format!("{slicer} is not installed"));
        }
        there
    });
    for slicer in slicers {
        let (done, document) = prepared(here, &["tee.stl*2", "block.stl", "--slicer", slicer]);
        let document = document.unwrap_or_else(|| panic!("{slicer}: {}", told(&done)));
        let cut = &document["cut"];
        assert_eq!((&cut["of_parts"], &cut["parts"]), (&serde_json::json!([0, 1]), &serde_json::json!(3)), "{cut}");
        let parts: Vec<&str> =
            document["plan"]["parts"].as_array().unwrap().iter().map(|part| part["name"].as_str().unwrap()).collect();
        assert_eq!(parts.len(), 7, "{parts:?}");
        assert!(parts.contains(&"3-block") || parts[6].starts_with("3-"), "{parts:?}");
        assert!(states(&told(&done), "2 solids | 4 planes | 6 parts"), "{}", told(&done));
        assert!(here.join("out.parts.3mf").is_file());
        note(&format!("{slicer}: {}", document["verify"]["seconds_print"]));
    }
}

#[test]
fn all_stand_on_supports_where_cutting_is_not_wanted() {
    let folder = new_folder();
    let here = folder.path();
    files(here);
    let (done, document) =
        prepared(here, &["tee.stl", "hook.stl", "block.stl", "--slicer", "builtin", "--split", "never"]);
    let document = document.unwrap_or_else(|| panic!("{}", told(&done)));
    let held = document["supports"]["parts"].as_array().unwrap();
    let parts: Vec<u64> = held.iter().map(|held| held["part"].as_u64().unwrap()).collect();
    assert_eq!(parts, [0, 1], "the block wants none");
    let sum: f64 = held.iter().map(|held| held["volume_mm3"].as_f64().unwrap()).sum();
    assert!((document["supports"]["volume_mm3"].as_f64().unwrap() - sum).abs() < 1e-6 * sum);
    assert!(states(&told(&done), "2 parts | supports | mm3"), "{}", told(&done));
}

/// Several shells in one file, as STL has them.
fn table(shapes: &[(Shape, [f64; 2])]) -> Vec<u8> {
    let at = |(shape, [x, y]): &(Shape, [f64; 2])| -> TriangleMesh<Object> {
        let mesh = shape.mesh();
        let low = mesh.bounds().min.z;
        mesh.moved(&Rigid::<Object, Object>::shift(Vec3::new(*x, *y, -low)))
    };
    let meshes: Vec<TriangleMesh<Object>> = shapes.iter().map(at).collect();
    stl_binary_parts(&meshes.iter().collect::<Vec<_>>())
}

/// What a refusal says; nothing is written.
fn refusal(folder: &Path, args: &[&str]) -> String {
    let done =
        run(folder, &[&["prepare"], args, &["-m", "generic-ac", "-o", "none.gcode", "--slicer", "builtin"]].concat());
    assert!(!done.status.success() && !folder.join("none.gcode").exists(), "{args:?}: {}", told(&done));
    told(&done)
}

#[test]
fn what_stands_in_the_way_of_the_others_is_told() {
    let folder = new_folder();
    let here = folder.path();
    // Past a post the tee's supports find a way, and on a block all over the place where they must stand they stand.
    let post = table(&[(solid("tee"), [0.0, 0.0]), (block(6.0, 6.0, 20.0), [17.0, -3.0])]);
    fs::write(here.join("post.stl"), post).unwrap();
    let near = table(&[(solid("tee"), [0.0, 0.0]), (block(22.0, 9.0, 30.0), [7.0, -4.5])]);
    fs::write(here.join("near.stl"), near).unwrap();
    for model in ["post.stl", "near.stl"] {
        let (done, document) = prepared(here, &[model, "--slicer", "builtin", "--way", "supports"]);
        assert!(document.is_some(), "{}", told(&done));
    }

    // Of parts that touch none is cut, and what stands on the table may be held; a tee beside them is either.
    let [foot, top] = [block(10.0, 10.0, 30.0), block(8.0, 8.0, 10.0).at(1.0, 1.0, 30.0)];
    let pair = |x: f64| [foot.at(x, 0.0, 0.0).mesh(), top.at(x, 0.0, 0.0).mesh()];
    let three = [&pair(0.0)[..], &[solid("tee").at(0.0, 60.0, 0.0).mesh()]].concat();
    fs::write(here.join("three.stl"), stl_binary_parts(&three.iter().collect::<Vec<_>>())).unwrap();
    let (done, document) = prepared(here, &["three.stl", "--slicer", "builtin", "--way", "cut"]);
    let document = document.unwrap_or_else(|| panic!("{}", told(&done)));
    assert_eq!(document["cut"]["of_parts"], serde_json::json!([2]), "{}", document["cut"]);
    let (done, document) = prepared(here, &["three.stl", "--slicer", "builtin", "--way", "supports"]);
    let document = document.unwrap_or_else(|| panic!("{}", told(&done)));
    let slots = document["plan"]["slots"].as_array().unwrap().iter();
    let prints = slots.flat_map(|slot| slot["prints"].as_array().unwrap());
    let held: Vec<&serde_json::Value> = prints.filter(|p| p["supports"].is_object()).map(|p| &p["part"]).collect();
    assert_eq!(held, [&serde_json::json!(2)], "{}", document["plan"]["slots"]);

    // More room is given by itself, but not where somebody said how much.
    files(here);
    let said = refusal(here, &["tee.stl*2", "block.stl", "--gap", "10", "--supports", "never"]);
    assert!(states(&said, "(--gap)"), "{said}");
}
