//! The verb `orient` by its default: document, text, the user's own pose, a machine's process, bad words.

use serde_json::Value;
use trunnion::geom::Object;
use trunnion::mesh::{ReadOptions, Repair, TriangleMesh, Unit, read_model, stl_binary};

use super::recommended;
use super::shapes::{boxes, shapes};
use crate::pipeline::fixture;
use crate::support::{fails, folder, states, trunnion};

fn run(args: &[&str]) -> (i32, String, String) {
    let out = trunnion().arg("orient").args(args).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (out.status.code().unwrap(), text(&out.stdout), text(&out.stderr))
}

fn result(args: &[&str]) -> Value {
    let (code, out, said) = run(&[args, &["--json"]].concat());
    assert_eq!(code, 0, "{said}");
    assert!(!out.contains("-0.0,") && !out.contains("-0.0]"), "{out}");
    let document: Value = serde_json::from_str(&out).unwrap();
    document["parts"][0]["results"][0].clone()
}

#[test]
fn a_plate_lies_flat_and_the_document_says_why() {
    let folder = folder();
    let file = folder.path().join("plate.stl");
    let plate = shapes().into_iter().find(|s| s.name == "plate").unwrap();
    std::fs::write(&file, stl_binary(&plate.mesh)).unwrap();
    let file = file.to_str().unwrap();
    let made = result(&[file, "--up", "0,2,0"]);
    assert_eq!((made["objective"].as_str(), made["method"].as_str()), (Some("printable"), Some("candidates")));
    let best = &made["recommended"];
    assert_eq!(best["up"], serde_json::json!([0.0, 0.0, 1.0]));
    let number = |pose: &Value, key: &str| pose[key].as_f64().unwrap();
    assert!((number(best, "footprint_mm2") - 6000.0).abs() < 1e-6 && best["stands"] == true);
    assert!((number(best, "tipping_deg") - (30.0_f64 / 0.5).atan().to_degrees()).abs() < 1e-6);
    // 1 mm thick is all wall: 6000 mm3 of PLA, no support anywhere.
    assert!((number(best, "grams") - 6000.0 * 1.24e-3).abs() < 1e-6 && number(best, "support_grams") == 0.0);
    let own = &made["own"];
    assert_eq!(own["up"], serde_json::json!([0.0, 1.0, 0.0]));
    assert!(own["stands"] == false && number(own, "height_mm") == 60.0);
    assert!((number(own, "tipping_deg") - (0.5_f64 / 30.0).atan().to_degrees()).abs() < 1e-6);
    assert!(number(own, "price_min") > number(best, "price_min"));
    let parts = ["scar_min", "steps_min", "risk_min"].map(|key| number(own, key)).iter().sum::<f64>();
    let sum = number(own, "minutes") + number(own, "grams") + parts;
    assert!((number(own, "price_min") - sum).abs() < 1e-9, "minutes and a minute a gram: {own}");
    let roles: Vec<&str> =
        made["alternatives"].as_array().unwrap().iter().map(|a| a["role"].as_str().unwrap()).collect();
    assert_eq!(roles, ["least support", "flattest", "lowest", "best surface"]);
    let reasons = made["reasons"].to_string();
    assert!(
        states(&reasons, "6000.0 mm2") && states(&reasons, "no supports") && states(&reasons, "your own pose"),
        "{reasons}"
    );
    assert_eq!(made["minima"][0]["up"], best["up"]);
    assert!(made["lower_bound"].as_f64().unwrap() <= number(best, "price_min"));
    let (_, text, _) = run(&[file, "--up", "0,2,0"]);
    for wanted in
        ["- it stands by itself", "recommended", "best surface", "as in the file", "yours", "lower bound: no pose"]
    {
        assert!(text.contains(wanted), "{wanted}: {text}");
    }
}

#[test]
fn a_machine_and_a_layer_change_the_price() {
    let cube = fixture("cube");
    let minutes =
        |args: &[&str]| result(&[&[cube.as_str()], args].concat())["recommended"]["minutes"].as_f64().unwrap();
    let own = minutes(&[]);
    assert_eq!(own, minutes(&["-m", "generic-ac"]), "the shipped machine has the defaults");
    // Half the layer takes twice the lines and twice the changes of layer.
    assert!((minutes(&["--layer", "0.1"]) / own - 2.0).abs() < 1e-9);
    let folder = folder();
    let profile = folder.path().join("fine.toml");
    std::fs::write(&profile, "extends = \"generic-ac\"\n[process]\nlayer_height_mm = 0.1\n").unwrap();
    assert!((minutes(&["-m", profile.to_str().unwrap()]) / own - 2.0).abs() < 1e-9);
    let few = result(&[&cube, "--budget", "100"]);
    assert!(few["evaluations"].as_u64().unwrap() <= 100, "{few}");
    assert_eq!(few["recommended"]["stands"], true);
}

#[test]
fn bad_words_are_refused_with_a_remedy() {
    let cube = fixture("cube");
    let cases: [(&[&str], &str); 6] = [
        (&[&cube, "--up", "0,0"], "must be three numbers separated by commas"),
        (&[&cube, "--up", "0,0,0"], "no direction; give three numbers that are not all 0"),
        (&[&cube, "--up", "nan,0,1"], "must be three numbers separated by commas"),
        (&[&cube, "--up", "0,0,1", "--objective", "height"], "--objective printable"),
        (&[&cube, "-m", "generic-xyz"], "generic-xyz"),
        (&[&cube, "--objective", "printabel"], "nearest is printable"),
    ];
    for (args, wanted) in cases {
        let (code, out, said) = run(args);
        assert_eq!((code, out.as_str()), (2, ""), "{args:?}");
        assert!(said.contains(wanted), "{args:?}: {said}");
    }
}

#[test]
fn the_least_support_of_a_cube_is_had_on_a_face() {
    let cube = fixture("cube");
    let made = result(&[&cube, "--objective", "support-volume-column"]);
    let up: Vec<f64> = made["minima"][0]["up"].as_array().unwrap().iter().map(|c| c.as_f64().unwrap()).collect();
    assert!(up.iter().any(|c| c.abs() > 1.0 - 1e-9), "{up:?}");
    assert_eq!(made["minima"][0]["kind"], "global");
    // A search that proves nothing calls nothing global.
    let made = result(&[&cube, "--objective", "height", "--method", "bfgs"]);
    assert!(made["minima"].as_array().unwrap().iter().all(|m| m["kind"] == "local"), "{made}");
}

#[test]
fn a_budget_holds_for_all_evaluations() {
    let hook = fixture("hook");
    for method in ["certified", "nelder-mead", "direct", "differential-evolution", "multistart"] {
        for objective in ["height", "support-volume-convex"] {
            let made = result(&[&hook, "--objective", objective, "--method", method, "--budget", "400"]);
            let spent = made["evaluations"].as_u64().unwrap();
            assert!((50..=400).contains(&spent), "{objective} by {method}: {spent}");
        }
    }
}

#[test]
fn several_parts_are_written_beside_each_other() {
    let folder = folder();
    let out = folder.path().join("all.stl");
    let (code, _, said) = run(&[&fixture("y-tree"), "-o", out.to_str().unwrap()]);
    assert_eq!(code, 0, "{said}");
    let bytes = std::fs::read(&out).unwrap();
    let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
    let parts = read_model(&bytes, "all.stl", &options).unwrap().parts;
    let before = read_model(&std::fs::read(fixture("y-tree")).unwrap(), "y-tree.stl", &options).unwrap().parts;
    assert_eq!(parts.len(), before.len());
    let mut sides: Vec<_> = parts.iter().map(|p| p.mesh.bounds()).collect();
    sides.sort_by(|a, b| a.min.x.total_cmp(&b.min.x));
    assert!(sides.iter().all(|b| b.min.z.abs() < 1e-4 && b.min.y.abs() < 1e-4));
    assert!(sides.windows(2).all(|w| (w[1].min.x - w[0].max.x - 5.0).abs() < 1e-3), "{sides:?}");
}

#[test]
fn a_scan_with_a_small_hole_gets_an_answer_with_a_warning() {
    let folder = folder();
    let file = folder.path().join("scan.stl");
    let ball = crate::solids::lump(24, 1.0);
    let whole = recommended(&ball).recommended;
    // Two facets that share an edge: 4 open edges.
    let open = TriangleMesh::<Object>::new(ball.vertices().to_vec(), ball.facets()[..ball.facets().len() - 2].to_vec());
    std::fs::write(&file, stl_binary(&open)).unwrap();
    // It is filled; as it was read, it is closed for the calculation alone.
    for (flags, words) in [(&[][..], "1 hole"), (&["--no-repair"], "open edges | 1 hole")] {
        let (code, out, said) = run(&[&[file.to_str().unwrap(), "--unit", "mm", "--json"], flags].concat());
        assert_eq!(code, 0, "{said}");
        assert!(states(&said, words), "{said}");
        let document: Value = serde_json::from_str(&out).unwrap();
        let best = &document["parts"][0]["results"][0]["recommended"];
        let off = best["price_min"].as_f64().unwrap() / whole.price_min;
        assert!((off - 1.0).abs() < 0.01, "{flags:?}: {best}");
    }
    // Without a quarter of it nothing is guessed.
    let most = ball.facets().len() * 3 / 4;
    let half = TriangleMesh::<Object>::new(ball.vertices().to_vec(), ball.facets()[..most].to_vec());
    std::fs::write(&file, stl_binary(&half)).unwrap();
    let (code, _, said) = run(&[file.to_str().unwrap(), "--unit", "mm"]);
    assert!(code == 2 && fails(&said, "job/needs-closed"), "{said}");
}

#[test]
fn contact_is_the_footprint_of_the_first_layer() {
    let folder = folder();
    let file = folder.path().join("feet.stl");
    // A block on four feet of 0.15 mm: the first layer of 0.2 mm lies on all of it.
    let foot = |x: f64, y: f64| [x, x + 2.0, y, y + 2.0, 0.0, 0.15];
    let feet = [foot(0.0, 0.0), foot(28.0, 0.0), foot(0.0, 18.0), foot(28.0, 18.0)];
    let all = [[[0.0, 30.0, 0.0, 20.0, 0.15, 12.0]].as_slice(), &feet].concat();
    std::fs::write(&file, stl_binary(&boxes(&all))).unwrap();
    let args = [file.to_str().unwrap(), "--whole", "--objective", "height", "--compare", "--json"];
    let (code, out, said) = run(&args);
    assert_eq!(code, 0, "{said}");
    let document: Value = serde_json::from_str(&out).unwrap();
    let lies = &document["parts"][0]["compare"][0];
    assert!((lies["contact_area_mm2"].as_f64().unwrap() - 600.0).abs() < 17.0, "{lies}");
    assert!((lies["tipping_deg"].as_f64().unwrap() - (10.0_f64 / 6.0).atan().to_degrees()).abs() < 0.5, "{lies}");
}
