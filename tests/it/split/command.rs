//! The verb: documents, exit codes, bad input, and the way on through `plan` and `prepare`.

use std::path::Path;

use serde_json::Value;
use trunnion::mesh::{ReadOptions, Repair, read_model, stl_binary};

use super::solids::{self, Shape};
use crate::support::{fails, first_error, folder, said, states, trunnion};

pub(super) fn written(folder: &Path, name: &str, shape: &Shape) -> String {
    let path = folder.join(name);
    std::fs::write(&path, stl_binary(&shape.mesh())).unwrap();
    path.display().to_string()
}

/// Runs `split` with `more`; code, stdout, stderr.
pub(super) fn run(model: &str, output: &Path, more: &[&str]) -> (Option<i32>, String, String) {
    let run = trunnion().args(["split", model, "-m", "generic-ac", "-o"]).arg(output).args(more).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (run.status.code(), text(&run.stdout), text(&run.stderr))
}

#[test]
fn the_document_has_what_scripts_read() {
    let folder = folder();
    let output = folder.path().join("parts.3mf");
    let (code, out, err) = run(&written(folder.path(), "tee.stl", &solids::tee()), &output, &["--json"]);
    assert_eq!(code, Some(0), "{err}");
    let document: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(document["parts"], 3);
    assert_eq!(document["planes"].as_array().unwrap().len(), 2);
    for plane in document["planes"].as_array().unwrap() {
        assert!(
            plane["normal"].as_array().unwrap().len() == 3 && plane["offset_mm"].is_f64() && plane["part"].is_u64()
        );
    }
    assert!((document["needs_support_mm2"]["before"].as_f64().unwrap() - 500.0).abs() < 1e-3);
    assert!(document["needs_support_mm2"]["after"].as_f64().unwrap() < 0.5);
    assert!(document["seam_mm2"].as_f64().unwrap() > 0.0 && document["seconds"].is_f64());
    assert_eq!(document["printable"], true);
    let names: Vec<&str> = document["order"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["tee", "tee cut 2", "tee cut 1"]);
    // The same input gives the same bytes, whatever the number of threads.
    let first = std::fs::read(&output).unwrap();
    let again = trunnion()
        .args(["split", &folder.path().join("tee.stl").display().to_string(), "-m", "generic-ac", "-q", "-o"])
        .arg(folder.path().join("again.3mf"))
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .unwrap();
    assert!(again.status.success() && again.stdout.is_empty(), "{}", said(&again));
    assert_eq!(first, std::fs::read(folder.path().join("again.3mf")).unwrap());
}

/// A T on its head needs no cut; the parts come out as they stand.
#[test]
fn a_solid_is_turned_before_it_is_cut() {
    let folder = folder();
    let (output, model) = (folder.path().join("parts.3mf"), written(folder.path(), "tee.stl", &solids::tee()));
    for (up, words) in [("0,0,-1", "(0.0000, 0.0000, -1.0000) up"), ("auto", "up | orient")] {
        let (code, out, err) = run(&model, &output, &["--json", "--up", up]);
        assert_eq!(code, Some(0), "{err}");
        let document: Value = serde_json::from_str(&out).unwrap();
        assert!(states(document["stood"].as_str().unwrap(), words), "{document}");
        let figures = [&document["seam_mm2"], &document["needs_support_mm2"]["before"]];
        assert!(figures.iter().all(|figure| !figure.to_string().starts_with('-')), "{document}");
        assert_eq!(document["planes"].as_array().unwrap().len(), 0, "{document}");
        let plan = trunnion().args(["plan", "-m", "generic-ac", "-q"]).arg(&output).output().unwrap();
        assert!(plan.status.success(), "{up}: {}", said(&plan));
    }
    let (_, out, _) = run(&model, &output, &["--up", "0,0,-1"]);
    assert!(states(&out, "1 part, 1 setup | seams 0.0 mm2 | support: 0.0 mm2"), "{out}");
    assert!(states(&out, "tee.stl | (0.0000, 0.0000, -1.0000)"), "{out}");
    for (more, words) in [
        (&["--up", "0,0,0"][..], "setting/direction: --up 0,0,0"),
        (&["--up", "0,0,1", "--no-cut", "0,0,0,1,1,1"], "command/usage: '--up <X,Y,Z>'"),
    ] {
        let (code, _, err) = run(&model, &folder.path().join("none.3mf"), more);
        assert!(code == Some(2) && fails(&err, words), "{err}");
    }
    assert!(!folder.path().join("none.3mf").exists());
}

#[test]
fn cut_solids_go_through_plan_and_prepare() {
    let folder = folder();
    let shapes = [
        ("tee", solids::tee()),
        ("hook", solids::hook()),
        ("mushroom", solids::mushroom()),
        ("wye", solids::wye()),
        ("tee-pipe", solids::tee_pipe()),
        ("wye-pipe", solids::wye_pipe()),
        ("bracket", solids::bracket()),
        ("menorah", solids::menorah()),
    ];
    for (name, shape) in shapes {
        let parts = folder.path().join(format!("{name}.3mf"));
        let (code, _, err) = run(&written(folder.path(), &format!("{name}.stl"), &shape), &parts, &[]);
        assert_eq!(code, Some(0), "{err}");
        let (parts, gcode) = (parts.display().to_string(), folder.path().join(format!("{name}.gcode")));
        let plan = trunnion().args(["plan", &parts, "-m", "generic-ac"]).output().unwrap();
        assert!(plan.status.success(), "{name}: {}", said(&plan));
        let prepare =
            trunnion().args(["prepare", &parts, "-m", "generic-ac", "--slicer", "builtin", "-o"]).arg(&gcode).output();
        let prepare = prepare.unwrap();
        assert!(prepare.status.success() && gcode.is_file(), "{name}: {}", said(&prepare));
    }
}

#[test]
fn what_cannot_be_cut_is_told_in_a_sentence_and_nothing_is_written() {
    let folder = folder();
    let output = folder.path().join("parts.3mf");
    let tee = written(folder.path(), "tee.stl", &solids::tee());
    let refused = |model: &str, more: &[&str], wanted: i32, words: &str| {
        let (code, _, err) = run(model, &output, more);
        let error = first_error(&err).1;
        assert_eq!(code, Some(wanted), "{err}");
        assert!(fails(&err, words), "{words:?} is not {err:?}");
        assert!(!output.exists() && !error.ends_with('.'), "{error}");
    };
    refused(&tee, &["--max-cuts", "1"], 1, "command/no: after 1 cut | 500.0 mm2 | --allow");
    refused(&tee, &["--max-cuts", "0"], 1, "command/no: 500.0 of 500.0 mm2");
    refused(&tee, &["--max-cuts", "101"], 2, "setting/out-of-range: --max-cuts | 0 and 100 | got 101");
    refused(&tee, &["--allow=-1"], 2, "setting/out-of-range: --allow | 0 and 1000000 | got -1 mm2");
    refused(&tee, &["--pedestal", "900"], 2, "setting/out-of-range: --pedestal | 0 and 200 | got 900 mm");
    refused(&tee, &["--overhang", "90"], 2, "setting/out-of-range: --overhang | 1 and 89 | got 90 deg");
    refused(&tee, &["--no-cut", "1,2,3"], 2, "command/usage: --no-cut 1,2,3 | six numbers");
    refused(&tee, &["--no-cut", "1,2,3,4,5,x"], 2, "command/usage: --no-cut 1,2,3,4,5,x | six numbers");
    let two = folder.path().join("two.stl");
    std::fs::write(&two, trunnion::fixtures::two_boxes().stl()).unwrap();
    refused(&two.display().to_string(), &[], 2, "strategy/not-one-solid: two.stl | 2");
    let wide = written(folder.path(), "wide.stl", &solids::block(300.0, 20.0, 10.0));
    refused(&wide, &[], 2, "table/over-rim: mm");
    refused("no-such.stl", &[], 2, "input/absent: no-such.stl");
    let (code, out, _) = run(&tee, &output, &["--max-cuts", "1", "--json"]);
    let document: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, &document["printable"]), (Some(1), &Value::Bool(false)));
    assert!(states(document["reasons"][0].as_str().unwrap(), "mm2 | support"));
}

#[test]
fn what_needs_nothing_comes_back_whole() {
    let folder = folder();
    let output = folder.path().join("parts.3mf");
    let block = written(folder.path(), "block.stl", &solids::block(20.0, 20.0, 10.0));
    let (code, out, err) = run(&block, &output, &["--json"]);
    let document: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, document["parts"].as_u64()), (Some(0), Some(1)), "{err}");
    let (code, ..) =
        run(&written(folder.path(), "tee.stl", &solids::tee()), &output, &["--max-cuts", "1", "--allow", "260"]);
    assert_eq!(code, Some(0));
}

/// A tee is two boxes: two convex pieces or a few more, whose hulls hold each facet, have the tee's volume but for the joint, and are closed bodies in the
/// file. What is convex is one piece.
#[test]
fn convex_pieces_hold_the_surface() {
    let folder = folder();
    let convex = |name: &str, shape: &Shape, more: &[&str]| -> (Value, Vec<trunnion::mesh::TriangleMesh>) {
        let model = written(folder.path(), name, shape);
        let output = folder.path().join("pieces.3mf");
        let run =
            trunnion().args(["split", &model, "--convex", "--json", "-o"]).arg(&output).args(more).output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
        let bytes = std::fs::read(&output).unwrap();
        let model = read_model(&bytes, "pieces.3mf", &ReadOptions { repair: Repair::Off, ..ReadOptions::default() });
        let parts = model.unwrap().parts.into_iter().map(|part| part.mesh).collect();
        (serde_json::from_slice(&run.stdout).unwrap(), parts)
    };
    let tee = solids::tee();
    let (done, hulls) = convex("tee.stl", &tee, &[]);
    let pieces = done["pieces"].as_array().unwrap();
    let bodies = pieces.iter().filter(|piece| piece["flat"] == false).count();
    assert!(hulls.len() == bodies && bodies > 1, "{done}");
    let facets: u64 = pieces.iter().map(|piece| piece["facets"].as_u64().unwrap()).sum();
    assert_eq!(facets as usize, tee.mesh().facets().len());
    for (piece, hull) in pieces.iter().filter(|piece| piece["flat"] == false).zip(&hulls) {
        assert!((piece["volume_mm3"].as_f64().unwrap() - hull.volume()).abs() < 1e-3, "{piece}");
        assert!(piece["concavity_mm"].as_f64() <= done["concavity_mm"].as_f64());
    }
    for corner in tee.mesh().vertices() {
        let within = |hull: &trunnion::mesh::TriangleMesh| {
            let bounds = hull.bounds().inflated(1e-4);
            (0..3).all(|k| bounds.min[k] <= corner[k] && corner[k] <= bounds.max[k])
        };
        assert!(hulls.iter().any(within), "{corner}");
    }
    // Far from convex is near enough: one hull of everything.
    let (one, whole) = convex("tee.stl", &tee, &["--concavity", "1000"]);
    assert!(whole.len() == 1 && whole[0].volume() > done["model_volume_mm3"].as_f64().unwrap() * 1.2, "{one}");
    let model = folder.path().join("tee.stl").display().to_string();
    for (more, code) in [
        (&["--convex", "--concavity", "-1"][..], "setting/out-of-range"),
        (&["--concavity", "1"], "command/usage"),
        (&["--convex", "--strict"], "command/usage"),
        (&[], "command/usage"),
    ] {
        let run = trunnion()
            .args(["split", &model, "-o", "none.3mf"])
            .args(more)
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(run.status.code(), Some(2), "{more:?}");
        let text = String::from_utf8_lossy(&run.stderr).into_owned();
        assert!(first_error(&text).0 == code || code == "command/usage", "{more:?}: {text}");
        assert!(!folder.path().join("none.3mf").exists());
    }
}
