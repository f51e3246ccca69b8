//! Planning as users meet it: objects that fool simpler planners, places, goals, reasons and remedies, bad input.

use serde_json::Value;

use crate::support::{fails, folder, root, soak, states, trunnion};

fn fixture(name: &str) -> String {
    root().join("fixtures").join(format!("{name}.stl")).display().to_string()
}

/// `plan MODEL ARGS --json`: exit code and document.
fn plan(model: &str, args: &[&str]) -> (i32, Value, String) {
    let run = trunnion().arg("plan").arg(model).args(args).arg("--json").output().unwrap();
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    let document = serde_json::from_slice(&run.stdout).unwrap_or(Value::Null);
    (run.status.code().unwrap_or(-1), document, said)
}

/// The parts of each slot.
fn slots(document: &Value) -> Vec<Vec<u64>> {
    let parts = |slot: &Value| {
        let prints = slot["prints"].as_array().unwrap().iter();
        let mut parts: Vec<u64> = prints.map(|p| p["part"].as_u64().unwrap()).collect();
        parts.sort_unstable();
        parts
    };
    document["slots"].as_array().unwrap().iter().map(parts).collect()
}

#[test]
fn a_long_bar_is_printed_before_the_post_beside_its_middle() {
    let (code, together, _) = plan(&fixture("bar-beside-post"), &["-m", "generic-ac"]);
    assert_eq!((code, slots(&together)), (0, vec![vec![0], vec![1, 2]]));
    let single = ["-m", "generic-ac", "--slots", "only-single"];
    let (code, one_by_one, _) = plan(&fixture("bar-beside-post"), &single);
    assert_eq!((code, slots(&one_by_one)), (0, vec![vec![0], vec![2], vec![1]]));
    let all = plan(&fixture("bar-beside-post"), &[&single[..], &["--all"]].concat()).1;
    assert_eq!(
        (&all["count"], &all["complete"]),
        (&Value::from(1), &Value::from(true)),
        "the post first is no sequence"
    );
}

#[test]
fn a_gantry_that_strikes_far_from_the_nozzle_decides_the_order() {
    let single = ["-m", "fibr3d", "--slots", "only-single", "--all"];
    let all = plan(&fixture("under-the-gantry"), &single).1;
    assert_eq!((&all["count"], &all["complete"]), (&Value::from(1), &Value::from(true)));
    let first: Vec<u64> =
        all["sequences"][0].as_array().unwrap().iter().map(|s| s["prints"][0]["part"].as_u64().unwrap()).collect();
    assert_eq!(first, [0, 2, 1], "the low block before the high post");
    // Without the beam both orders are.
    let folder = folder();
    let machine = folder.path().join("no-gantry.toml");
    let own = std::fs::read_to_string(root().join("firmware-profiles/fibr3d.toml")).unwrap();
    let mut kept: toml::Table = own.parse().unwrap();
    let bodies = kept["head"]["body"].as_array_mut().unwrap();
    bodies.retain(|b| b["moves"].as_str() == Some("XYZ"));
    std::fs::write(&machine, kept.to_string()).unwrap();
    let all = plan(&fixture("under-the-gantry"), &[&["-m", machine.to_str().unwrap()], &single[2..]].concat()).1;
    assert_eq!(all["count"], 2);
}

#[test]
fn a_travel_from_tower_to_tower_goes_over_what_stands_between() {
    let folder = folder();
    let out = folder.path().join("towers.gcode");
    let run = trunnion()
        .args([
            "prepare",
            &fixture("between-towers"),
            "-m",
            "generic-ac",
            "--slicer",
            "builtin",
            "--slots",
            "only-single",
        ])
        .args(["--json", "-o"])
        .arg(&out)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let document: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(slots(&document["plan"]), [[0], [1], [2]], "the stub cannot be printed between the towers");
    assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()));
    // The stub's top lies 16 mm above the table, whose surface is at the machine's zero; the towers' first layers below it.
    let text = std::fs::read_to_string(&out).unwrap();
    let (mut part, mut z, mut x, mut across) = (0, 0.0f64, 0.0f64, Vec::new());
    for line in text.lines() {
        if let Some(mark) = line.strip_prefix(";TRUNNION print=") {
            part = mark.split("part=").nth(1).unwrap().trim().parse().unwrap();
        }
        if !line.starts_with("G1 ") && !line.starts_with("G0 ") {
            continue;
        }
        let word = |letter: char| line.split(' ').find_map(|w| w.strip_prefix(letter)?.parse::<f64>().ok());
        z = word('Z').unwrap_or(z);
        let to = word('X').unwrap_or(x);
        if part == 2 && x * to < 0.0 && (x - to).abs() > 20.0 {
            across.push(z);
        }
        x = to;
    }
    let low = across.iter().filter(|z| **z < 16.0).count();
    assert!(across.len() > 20, "{} ways from tower to tower", across.len());
    let over = across.iter().filter(|z| **z > 16.0).count();
    assert!(over >= 20, "{over} of {} over the stub, {low} below its top", across.len());
}

#[test]
fn nothing_gets_into_a_cage_and_the_reason_is_the_cage() {
    let folder = folder();
    let sheet = folder.path().join("caged.svg");
    let (code, document, said) = plan(&fixture("caged"), &["-m", "generic-ac", "--sheet", sheet.to_str().unwrap()]);
    assert_eq!(code, 1);
    assert_eq!(document["least"], true);
    let reasons = document["reasons"].as_array().unwrap();
    assert!(!reasons.is_empty() && reasons.iter().all(|r| r["part"] == 1 && r["blocked_by"] == "0"), "{reasons:?}");
    assert!(reasons.iter().all(|r| r["depth_mm"].as_f64().unwrap() > 1.0));
    let remedies = document["remedies"].as_array().unwrap();
    assert!(
        remedies.iter().all(|r| r["kind"] == "join") && remedies.len() == 1,
        "as one solid, or not at all: {remedies:?}"
    );
    assert!(fails(&said, "plan/no-plan: part 1 | 39.6 mm | part 0"), "{said}");
    let picture = std::fs::read_to_string(&sheet).unwrap();
    assert!(picture.starts_with("<svg") && states(&picture, "39.6 mm | part 0"));
}

#[test]
fn the_margin_holds_beside_the_upright_table_too() {
    // The beam is printed with the table upright, the head's carriage 18 mm before it.
    let model = fixture("two-boxes");
    let with = |margin: &str| plan(&model, &["-m", "generic-ac", "--no-remedies", "--margin", margin]);
    let (code, document, said) = with("17.9");
    assert_eq!(
        (code, document["clearance_mm"].as_f64().map(|mm| (mm * 100.0).round() / 100.0)),
        (0, Some(18.0)),
        "{said}"
    );
    let tilt = |document: &Value| document["slots"][1]["prints"][0]["tilt_deg"].as_f64();
    assert_eq!(tilt(&document), Some(90.0));
    // With more room asked for it is tilted less, until its own post is in the way.
    let (code, document, said) = with("18.1");
    assert!(code == 0 && tilt(&document).is_some_and(|deg| deg < 90.0), "{said}");
    let (code, document, _) = with("38");
    assert_eq!(code, 1);
    let reasons = document["reasons"].as_array().unwrap();
    let of = |what: &str, words: &str| {
        let mut texts = reasons.iter().filter(|r| r["blocked_by"] == what).filter_map(|r| r["text"].as_str());
        texts.any(|text| text.contains(words))
    };
    assert!(of("table", "(required: 38.0 mm)") && of("0", "would reach"), "{reasons:?}");
}

#[test]
fn a_hook_hangs_in_the_air_unless_it_lies_on_its_side() {
    let (code, document, _) = plan(&fixture("hook"), &["-m", "generic-ac"]);
    assert_eq!(code, 1);
    assert!(document["reasons"].as_array().unwrap().iter().all(|r| r["blocked_by"] == "support"));
    let kinds: Vec<&str> =
        document["remedies"].as_array().unwrap().iter().map(|r| r["kind"].as_str().unwrap()).collect();
    // What is nearest to working first, then a cut, then support.
    assert_eq!(kinds, ["base", "split", "support"]);
    // The remedy by hand: the same hook with y for z.
    let folder = folder();
    let model = folder.path().join("lying.stl");
    let lying = trunnion::fixtures::hook().parts.into_iter().map(|(_, mesh)| {
        let turned = mesh.vertices().iter().map(|v| trunnion::geom::Vec3::new(v.x, -v.z, v.y)).collect();
        trunnion::mesh::TriangleMesh::<trunnion::geom::Object>::new(turned, mesh.facets().to_vec())
    });
    let lying: Vec<_> = lying.collect();
    std::fs::write(&model, trunnion::mesh::stl_binary_parts(&lying.iter().collect::<Vec<_>>())).unwrap();
    assert_eq!(plan(model.to_str().unwrap(), &["-m", "generic-ac"]).0, 0);
}

#[test]
fn remedies_help_and_hardly_less_does_not() {
    remedies_help("two-boxes", 38.0, true);
    // Where a failing plan takes long, and a dozen of them are tried.
    if soak().is_some() {
        // Which of its many parts want other directions depends on the margin: a remedy is one that helps, and with others a smaller one may.
        remedies_help("candelabrum", 14.0, false);
    }
}

fn remedies_help(name: &str, too_much: f64, least: bool) {
    let (model, too_much) = (fixture(name), too_much.to_string());
    let (code, document, _) = plan(&model, &["-m", "generic-ac", "--margin", &too_much]);
    assert_eq!(code, 1);
    let remedies = document["remedies"].as_array().unwrap();
    let amount = |kind: &str| remedies.iter().find(|r| r["kind"] == kind).map(|r| r["amount"].as_f64().unwrap());
    let margin = amount("margin").expect("less room helps");
    let with = |margin: f64| plan(&model, &["-m", "generic-ac", "--no-remedies", "--margin", &format!("{margin}")]).0;
    let hardly_less = least.then_some(1);
    assert_eq!((with(margin), least.then(|| with(margin + 0.1))), (0, hardly_less), "{name}: {margin}");
    // A slimmer head, by hand.
    let share = amount("head-width").expect("a slimmer head helps");
    let folder = folder();
    let narrowed = |share: f64| {
        let defaults = std::fs::read_to_string(root().join("firmware-profiles/defaults.toml")).unwrap();
        let head: toml::Table = defaults.parse().unwrap();
        let mut bodies = head["head"]["body"].clone();
        for body in bodies.as_array_mut().unwrap() {
            for (key, count) in [("r_mm", 2), ("min_mm", 2), ("max_mm", 2)] {
                let Some(values) = body.get_mut(key) else { continue };
                for value in values.as_array_mut().unwrap().iter_mut().take(count) {
                    *value = toml::Value::Float(value.as_float().unwrap() * share);
                }
            }
        }
        let mut machine = toml::Table::new();
        machine.insert("head".to_owned(), toml::Value::Table([("body".to_owned(), bodies)].into_iter().collect()));
        let path = folder.path().join("slim.toml");
        std::fs::write(&path, machine.to_string()).unwrap();
        plan(&model, &["-m", path.to_str().unwrap(), "--no-remedies", "--margin", &too_much]).0
    };
    assert_eq!((narrowed(share), least.then(|| narrowed(share + 0.02))), (0, hardly_less), "{name}: {share}");
}

#[test]
fn a_place_is_found_where_the_axes_do_not_reach_from_the_middle() {
    let (code, document, said) = plan(&fixture("two-boxes"), &["-m", "fibr3d"]);
    assert_eq!(code, 0, "{said}");
    let origin: Vec<f64> =
        document["placement"]["origin_mm"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let (code, refused, _) = plan(&fixture("two-boxes"), &["-m", "fibr3d", "--origin=-60,0", "--no-remedies"]);
    assert_eq!(code, 1, "there Z does not reach");
    assert!(refused["reasons"].as_array().unwrap().iter().any(|r| r["blocked_by"] == "limits"));
    let there = format!("--origin={},{}", origin[0], origin[1]);
    assert_eq!(plan(&fixture("two-boxes"), &["-m", "fibr3d", &there]).0, 0);
    // Turned alone: about the middle of the model, which stays in the middle of the table.
    let (code, document, said) = plan(&fixture("two-boxes"), &["-m", "generic-ac", "--turn=-30"]);
    assert_eq!(code, 0, "{said}");
    let (_, straight, _) = plan(&fixture("two-boxes"), &["-m", "generic-ac"]);
    let [at, plain] = [&document, &straight].map(|d| [0, 1].map(|i| d["placement"]["origin_mm"][i].as_f64().unwrap()));
    let (sin, cos) = (-30f64).to_radians().sin_cos();
    let wanted = [plain[0] * cos - plain[1] * sin, plain[0] * sin + plain[1] * cos];
    assert!((0..2).all(|i| (at[i] - wanted[i]).abs() < 1e-6), "{at:?}, {wanted:?} from {plain:?}");
    assert_eq!(document["placement"]["turn_deg"], -30.0);
    // A machine that reaches nowhere says so, and that it was proved.
    let folder = folder();
    let low = folder.path().join("low.toml");
    std::fs::write(&low, "[limits]\nz_mm = [-5.0, 70.0]\nx_mm = [-10.0, 10.0]\ny_mm = [-10.0, 10.0]\n").unwrap();
    let (code, document, said) = plan(&fixture("two-boxes"), &["-m", low.to_str().unwrap(), "--no-remedies"]);
    assert_eq!((code, &document["code"]), (1, &Value::from("plan/no-place")), "{said}");
}

#[test]
fn goals_are_names_and_sums_with_a_bound() {
    let model = fixture("y-tree");
    for goal in ["bss", "time", "setups", "slots", "staircase", "height", "support-area", "1*bss+0.01*staircase"] {
        let (code, document, said) = plan(&model, &["-m", "generic-ac", "--objective", goal]);
        assert_eq!(code, 0, "{goal}: {said}");
        assert_eq!(document["objective"], goal);
        assert_eq!(document["value"], document["lower_bound"], "{goal}");
    }
    for (goal, wanted) in [
        ("bbs", "nearest is bss"),
        ("staircaze", "nearest is staircase"),
        ("-1*bss", "not a finite number"),
        ("0*bss", "sum to 0"),
        ("x*time", "not a finite number"),
    ] {
        let (code, _, said) = plan(&model, &["-m", "generic-ac", &format!("--objective={goal}")]);
        assert_eq!(code, 2, "{goal}");
        assert!(said.contains(wanted), "{goal}: {said}");
    }
    let (_, document, _) = plan(&model, &["-m", "generic-ac", "--top", "3"]);
    let alternatives = document["alternatives"].as_array().unwrap();
    let values: Vec<f64> = alternatives.iter().map(|a| a["value"].as_f64().unwrap()).collect();
    assert!(values.len() == 3 && values.is_sorted(), "{values:?}");
    // The beam of 30 x 20 mm hangs 40 mm above the table.
    let (_, boxes, _) = plan(&fixture("two-boxes"), &["-m", "generic-ac", "--top", "2"]);
    let support = boxes["three_axis"]["support_mm3"].as_f64().unwrap();
    assert!((support - 24_000.0).abs() < 500.0, "{support}");
    // Laid on its side it needs none.
    let best = &boxes["three_axis"]["best_pose"];
    assert!(best["support_mm3"].as_f64().unwrap() < 1.0 && best["up"][2].as_f64().unwrap().abs() < 1e-6, "{best}");
    assert!(best["seconds_print_estimate"].as_f64() < boxes["three_axis"]["seconds_print_estimate"].as_f64(), "{best}");
    let within = document["within_slots"].as_array().unwrap();
    assert_eq!((within.len(), &within[0]["turns"]), (1, &Value::from(1)), "both branches are in one slot");
    assert!(within[0]["turns_layer_by_layer"].as_u64().unwrap() > 100);
    for (method, code) in [("mmls", 0), ("direct", 0), ("mmlz", 2)] {
        let (got, _, said) = plan(&model, &["-m", "generic-ac", "--method", method, "--orient-budget", "500"]);
        assert_eq!(got, code, "{method}: {said}");
    }
    assert_eq!(plan(&model, &["-m", "generic-ac", "--orient-budget", "0"]).0, 2);
}

#[test]
fn sequences_are_listed_up_to_a_limit() {
    let (_, few, _) = plan(&fixture("candelabrum"), &["-m", "generic-ac", "--all", "--limit", "50"]);
    assert_eq!((few["count"].as_u64(), few["complete"].as_bool()), (Some(50), Some(false)));
    let (_, all, _) = plan(&fixture("ding"), &["-m", "generic-ac", "--all"]);
    let count = all["count"].as_u64().unwrap();
    assert!(all["complete"].as_bool().unwrap() && (1..100).contains(&count), "{count}");
    assert_eq!(all["sequences"].as_array().unwrap().len() as u64, count);
}

/// Boxes as a binary STL.
fn boxes(folder: &std::path::Path, boxes: &[([f64; 3], [f64; 3])]) -> String {
    let solids: Vec<_> = boxes.iter().map(|(a, b)| trunnion::fixtures::solid_box((*a).into(), (*b).into())).collect();
    let path = folder.join("boxes.stl");
    std::fs::write(&path, trunnion::mesh::stl_binary_parts(&solids.iter().collect::<Vec<_>>())).unwrap();
    path.display().to_string()
}

#[test]
fn rings_twins_fixed_tables_and_crowds() {
    let folder = folder();
    // Four boxes in a ring of interfaces: a cycle is no trouble.
    let ring = boxes(
        folder.path(),
        &[
            ([-20.0, -10.0, 0.0], [0.0, 10.0, 10.0]),
            ([0.0, -10.0, 0.0], [20.0, 10.0, 10.0]),
            ([0.0, -10.0, 10.0], [20.0, 10.0, 20.0]),
            ([-20.0, -10.0, 10.0], [0.0, 10.0, 20.0]),
        ],
    );
    let (code, document, said) = plan(&ring, &["-m", "generic-ac"]);
    assert_eq!((code, slots(&document)), (0, vec![vec![0, 1], vec![2, 3]]), "{said}");
    let twins = boxes(folder.path(), &[([0.0; 3], [10.0; 3]), ([0.0; 3], [10.0; 3])]);
    let (code, _, said) = plan(&twins, &["-m", "generic-ac"]);
    assert!(code == 0 && said.contains("12 collapsed or repeated"), "the same mesh twice is one: {code}: {said}");
    let fixed = folder.path().join("fixed.toml");
    std::fs::write(&fixed, "[kinematics.tilt]\nmin_deg = 0.0\nmax_deg = 0.0\n").unwrap();
    let (code, document, said) = plan(&fixture("two-boxes"), &["-m", fixed.to_str().unwrap()]);
    assert_eq!(code, 1, "{said}");
    let kinds = |key: &str| -> Vec<String> {
        document[key].as_array().unwrap().iter().map(|r| r["kind"].as_str().unwrap().to_owned()).collect()
    };
    assert!(kinds("remedies").contains(&"tilt".to_owned()), "{:?}", document["remedies"]);
    let tilt = document["remedies"].as_array().unwrap().iter().find(|r| r["kind"] == "tilt").unwrap();
    assert_eq!(tilt["amount"], 60.0);
    std::fs::write(&fixed, "[kinematics.tilt]\nmin_deg = 0.0\nmax_deg = 60.0\n").unwrap();
    let (code, document, said) = plan(&fixture("two-boxes"), &["-m", fixed.to_str().unwrap()]);
    assert_eq!((code, &document["slots"][1]["prints"][0]["tilt_deg"]), (0, &Value::from(60.0)), "{said}");
    let crowd: Vec<_> = (0..10_000)
        .map(|i| {
            let (x, y) = (f64::from(i % 100) * 1.2, f64::from(i / 100) * 1.2);
            ([x, y, 0.0], [x + 1.0, y + 1.0, 1.0])
        })
        .collect();
    let (code, _, said) = plan(&boxes(folder.path(), &crowd), &["-m", "generic-ac"]);
    assert!(code == 2 && fails(&said, "plan/too-many-parts: 10000"), "{code}: {said}");
}

/// The two studies of Ramos et al. (2021), section 5.4: the base upright and lying.
#[test]
fn all_sequences_of_all_stands_are_listed_with_what_is_up() {
    let any = ["-m", "generic-ac", "--all", "--up", "any"];
    let (code, boxes, said) = plan(&fixture("two-boxes"), &any);
    assert_eq!(code, 0, "{said}");
    let of = |up: [f64; 3]| -> Vec<&Value> {
        let all = boxes["sequences"].as_array().unwrap().iter().zip(boxes["ups"].as_array().unwrap());
        all.filter(|(_, own)| **own == serde_json::json!(up)).map(|(slots, _)| slots).collect()
    };
    let one = |slots: &Value| -> Vec<(u64, f64)> {
        let prints = slots.as_array().unwrap().iter().flat_map(|slot| slot["prints"].as_array().unwrap());
        prints.map(|p| (p["part"].as_u64().unwrap(), p["tilt_deg"].as_f64().unwrap())).collect()
    };
    assert_eq!(of([0.0, 0.0, 1.0]).into_iter().map(one).collect::<Vec<_>>(), [[(0, 0.0), (1, 90.0)]]);
    assert_eq!(of([1.0, 0.0, 0.0]).into_iter().map(one).collect::<Vec<_>>(), [[(0, 0.0), (1, 0.0)]]);
    assert_eq!(boxes["count"].as_u64().map(|count| count as usize), boxes["ups"].as_array().map(Vec::len));
    assert_eq!(boxes["complete"], true);
    // As it is drawn there is one, and no direction is told.
    let (_, drawn, _) = plan(&fixture("two-boxes"), &any[..3]);
    assert_eq!((&drawn["count"], &drawn["ups"]), (&Value::from(1), &Value::Null));
    let (_, few, _) = plan(&fixture("two-boxes"), &[&any[..], &["--limit", "2"]].concat());
    assert_eq!((&few["count"], &few["complete"]), (&Value::from(2), &Value::from(false)));
    // A stand in which a part floats is left out, and the search ends at its limit.
    let folder = folder();
    let apart = self::boxes(folder.path(), &[([0.0; 3], [20.0; 3]), ([60.0, 0.0, 0.0], [80.0, 20.0, 40.0])]);
    let (code, listed, said) = plan(&apart, &any);
    assert!(code == 0 && listed["count"].as_u64() > Some(1), "{said}");
    let (code, one, _) = plan(&apart, &[&any[..], &["--limit", "1"]].concat());
    assert_eq!((code, &one["count"], &one["complete"]), (0, &Value::from(1), &Value::from(false)));
    // What cannot be printed in any stand says why, as it does where it stands.
    let (code, _, said) = plan(&fixture("caged"), &any);
    assert!(code == 1 && fails(&said, "plan/no-plan"), "{said}");
    // A plan needs one pose.
    let (code, _, said) = plan(&fixture("two-boxes"), &["-m", "generic-ac", "--up", "any"]);
    assert!(code == 2 && fails(&said, "setting/words: any | --all"), "{said}");
}
