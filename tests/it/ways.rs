//! The way that `prepare` takes: what a maker would do with household things, never much dearer than the cheapest that works, and each way by itself.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::Stdio;

use serde_json::Value;
use trunnion::mesh::stl_binary;

use crate::rims::lowest_rim;
use crate::split::solids::{self, Shape, block, rod, turned};
use crate::support::{Numbers, every, folder, note, said, seeds, states, trunnion};

/// A plate on a neck, as it is drawn: nobody prints it so.
fn knob() -> Shape {
    turned(&[[8.0, 0.0], [8.0, 6.0], [18.0, 6.0], [18.0, 12.0]], 48)
}

/// `prepare` with the built-in slicer: exit code, document, messages.
fn prepared(folder: &Path, name: &str, shape: &Shape, more: &[&str]) -> (Option<i32>, Value, String) {
    let (model, out) = (folder.join(format!("{name}.stl")), folder.join(format!("{name}.gcode")));
    std::fs::write(&model, stl_binary(&shape.mesh())).unwrap();
    let _ = std::fs::remove_file(&out);
    let mut command = trunnion();
    command.arg("prepare").arg(&model).args(["--slicer", "builtin", "--json", "--no-remedies", "-o"]).arg(&out);
    let machine: &[&str] = if more.contains(&"-m") { &[] } else { &["-m", "generic-ac"] };
    let done = command.args(machine).args(more).output().unwrap();
    assert_eq!(done.status.success(), out.exists(), "{name}: {}", said(&done));
    let document = serde_json::from_slice(&done.stdout).unwrap_or(Value::Null);
    (done.status.code(), document, String::from_utf8_lossy(&done.stderr).into_owned())
}

/// The row of a way.
fn row<'a>(document: &'a Value, way: &str) -> Option<&'a Value> {
    document["ways"].as_array()?.iter().find(|row| row["way"] == way)
}

fn chosen(document: &Value) -> &Value {
    document["ways"].as_array().and_then(|ways| ways.iter().find(|row| row["chosen"] == true)).unwrap_or(&Value::Null)
}

fn price(row: &Value) -> f64 {
    row["price_min"].as_f64().unwrap()
}

#[test]
fn a_knob_is_turned_over_and_all_that_it_costs_is_told() {
    let folder = folder();
    let (code, done, said) = prepared(folder.path(), "knob", &knob(), &[]);
    assert_eq!(code, Some(0), "{said}");
    let taken = &done["ways"][0];
    assert_eq!((&taken["way"], &taken["chosen"]), (&Value::from("turned"), &Value::from(true)), "{said}");
    assert!(taken["up"][2].as_f64().unwrap() < -0.999, "{taken}");
    // The plan is that of the model as it stands now, which lies beside the output.
    let parts = std::fs::read(folder.path().join("knob.parts.3mf")).unwrap();
    assert_eq!(done["plan"]["model"]["sha256"], trunnion::planning::sha256_hex(&parts));
    // By hand: minutes, grams at a minute each, steps and risk.
    let number = |key: &str| taken[key].as_f64().unwrap();
    let sum = number("minutes") + number("grams") + number("steps_min") + number("risk_min");
    assert!((price(taken) - sum).abs() < 1e-9, "{taken}");
    assert!(price(row(&done, "supports").unwrap()) > price(taken), "{}", done["ways"]);
    let drawn = row(&done, "as-drawn").unwrap();
    assert!(drawn["price_min"].is_null() && drawn["code"] == "way/no-plan", "{drawn}");
    assert_eq!(done["ways"], done["plan"]["ways"]);
    // For people, with the size of what was read first.
    let first = said.lines().next().unwrap();
    assert_eq!(first, "knob.stl: 1 part, 36.0 x 36.0 x 12.0 mm");
    assert!(said.lines().any(|line| line.starts_with("turned") && line.ends_with("taken")), "{said}");
}

#[test]
fn each_way_by_itself() {
    let folder = folder();
    for (way, wanted) in [("turned", "turned"), ("supports", "supports")] {
        let (code, done, said) = prepared(folder.path(), "one", &knob(), &["--way", way]);
        assert_eq!(code, Some(0), "{way}: {said}");
        assert_eq!(chosen(&done)["way"], wanted, "{said}");
    }
    let (code, done, said) = prepared(folder.path(), "cut", &solids::hook(), &["--way", "cut"]);
    assert_eq!((code, &chosen(&done)["way"]), (Some(0), &Value::from("cut")), "{said}");
    // As drawn it has no plan, with the reasons; what needs no cut and no supports says so.
    let (code, no, _) = prepared(folder.path(), "drawn", &knob(), &["--way", "as-drawn"]);
    assert_eq!((code, &no["feasible"]), (Some(1), &Value::from(false)));
    for (way, code) in [("cut", "way/nothing-to-cut"), ("supports", "way/nothing-hangs")] {
        let (exit, no, _) = prepared(folder.path(), "plain", &block(20.0, 20.0, 10.0), &["--way", way]);
        assert_eq!((exit, no["exit"].as_i64()), (Some(1), Some(1)), "{way}: {no}");
        let row = row(&no, way).unwrap();
        let why = row["why_not"].as_str().unwrap();
        assert!(row["code"] == code && no["error"].as_str().unwrap().contains(why), "{way}: {no}");
    }
    for args in [["--way", "cut", "--split", "never"], ["--way", "supports", "--supports", "never"]] {
        let (code, no, _) = prepared(folder.path(), "both", &knob(), &args);
        assert_eq!(code, Some(2), "{no}");
    }
}

/// With what the profile says of it the same shape is printed otherwise.
#[test]
fn the_profile_says_what_is_worth_what() {
    let folder = folder();
    let profile = |name: &str, price: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, format!("extends = \"generic-ac\"\n[price]\n{price}\n")).unwrap();
        path.display().to_string()
    };
    let way = |machine: &str| {
        let (code, done, said) = prepared(folder.path(), "hook", &solids::hook(), &["-m", machine]);
        assert_eq!(code, Some(0), "{said}");
        chosen(&done)["way"].as_str().unwrap().to_owned()
    };
    let dear = profile("seams.toml", "seam_min_per_mm2 = 10.0\nsetup_min = 1000.0");
    let cheap = profile("supports.toml", "gram_min = 0.0\nsupports_min = 1000.0");
    assert_ne!(way(&dear), "cut");
    assert_eq!(way(&cheap), "cut");
    for bad in ["gram_min = -1.0", "seam_min_per_mm2 = nan", "setup_min = \"two\""] {
        let machine = profile("bad.toml", bad);
        let (code, no, _) = prepared(folder.path(), "hook", &solids::hook(), &["-m", &machine]);
        assert_eq!(code, Some(2), "{bad}: {no}");
        let key = bad.split(' ').next().unwrap();
        assert!(no["error"].as_str().unwrap().contains(&format!("price.{key}")), "{no}");
    }
}

/// Things that people print, in sizes drawn at random.
fn household(seed: u64) -> (String, Shape) {
    let n = &mut Numbers::seeded(seed);
    let mut mm = |low: f64, high: f64| (n.between(low, high) * 10.0).round() / 10.0;
    let kinds =
        ["box", "puck", "mug", "lid", "gear", "bracket", "hook", "bolt", "table", "pipe", "dome", "channel", "tree"];
    let kind = (seed % kinds.len() as u64) as usize;
    let shape = match kind {
        0 => block(mm(20.0, 50.0), mm(15.0, 40.0), mm(8.0, 30.0)).less(&block(12.0, 8.0, 60.0).at(3.0, 3.0, 2.0)),
        1 => {
            let (radius, fillet, high) = (mm(10.0, 22.0), mm(1.0, 4.0), mm(5.0, 15.0));
            let round = |k: i32| {
                let (s, c) = (f64::from(k) / 12.0 * std::f64::consts::FRAC_PI_2).sin_cos();
                [radius - fillet * (1.0 - s), fillet * (1.0 - c)]
            };
            let mut rings: Vec<[f64; 2]> = (0..=12).map(round).collect();
            rings.push([radius, fillet + high]);
            turned(&rings, 64)
        }
        2 => {
            let (radius, high) = (mm(15.0, 25.0), mm(25.0, 45.0));
            let cup = rod(radius, high, 64).less(&rod(radius - 2.5, high, 64).at(0.0, 0.0, 2.5));
            let grip = block(14.0, 6.0, high * 0.6).less(&block(9.0, 8.0, high * 0.6 - 10.0).at(0.0, -1.0, 5.0));
            cup.and(&grip.at(radius - 2.0, -3.0, high * 0.2))
        }
        3 => {
            let (radius, rim) = (mm(15.0, 30.0), mm(4.0, 9.0));
            rod(radius, rim + 2.4, 64).less(&rod(radius - 2.0, rim, 64).at(0.0, 0.0, -0.01))
        }
        4 => {
            let (radius, hub) = (mm(12.0, 22.0), mm(4.0, 8.0));
            let wheel = rod(radius, 6.0, 24).at(0.0, 0.0, hub);
            wheel.and(&rod(radius * 0.4, hub + 1.0, 48)).less(&rod(2.5, 40.0, 32).at(0.0, 0.0, -1.0))
        }
        5 => {
            let (long, high) = (mm(25.0, 60.0), mm(25.0, 50.0));
            let angle = block(long, 20.0, 4.0).and(&block(4.0, 20.0, high));
            angle.less(&rod(2.2, 20.0, 32).at(long * 0.7, 10.0, -1.0))
        }
        6 => {
            let (arm, high) = (mm(15.0, 35.0), mm(30.0, 60.0));
            block(30.0, 20.0, 4.0).and(&block(6.0, 20.0, high)).and(&block(arm, 20.0, 6.0).at(0.0, 0.0, high - 6.0))
        }
        7 => {
            let (radius, long) = (mm(3.0, 6.0), mm(12.0, 30.0));
            rod(radius, long + 1.0, 48).and(&rod(radius * 1.8, 5.0, 6).at(0.0, 0.0, long))
        }
        8 => {
            let (side, high) = (mm(25.0, 45.0), mm(15.0, 35.0));
            let leg = |x: f64, y: f64| block(5.0, 5.0, high + 1.0).at(x, y, 0.0);
            let top = block(side, side, 3.0).at(0.0, 0.0, high);
            let far = side - 5.0;
            top.and(&leg(0.0, 0.0)).and(&leg(far, 0.0)).and(&leg(0.0, far)).and(&leg(far, far))
        }
        9 => {
            let (radius, long) = (mm(6.0, 10.0), mm(20.0, 40.0));
            let outside = rod(radius, 50.0, 48).and(&rod(radius * 0.8, long, 48).about_y(90.0).at(0.0, 0.0, 30.0));
            outside.less(&rod(radius - 2.0, 60.0, 48).at(0.0, 0.0, -1.0))
        }
        10 => {
            let radius = mm(10.0, 22.0);
            solids::ball(radius, 48).less(&block(90.0, 90.0, 45.0).at(-45.0, -45.0, -45.0))
        }
        11 => {
            let (wide, high) = (mm(10.0, 40.0), mm(10.0, 25.0));
            block(wide + 8.0, 30.0, high + 4.0).less(&block(wide, 40.0, high).at(4.0, -5.0, -0.01))
        }
        _ => {
            let high = mm(35.0, 60.0);
            let branch =
                |side: f64, lean: f64, from: f64| rod(4.0, 30.0, 32).about_y(side * lean).at(0.0, 0.0, high * from);
            rod(7.0, high, 48).and(&branch(1.0, mm(30.0, 85.0), 0.3)).and(&branch(-1.0, mm(30.0, 85.0), 0.5))
        }
    };
    (format!("{seed}-{}", kinds[kind]), shape)
}

/// What is chosen is at most a twentieth dearer than the cheapest of the ways by themselves, and none is printed with the rim in the table.
#[test]
fn the_way_that_is_taken_is_never_much_dearer_than_another() {
    let folder = folder();
    let (mut told, mut dear, mut compared) = (Vec::new(), Vec::new(), 0);
    for seed in seeds(13, 65) {
        let (name, shape) = household(seed);
        let (code, done, said) = prepared(folder.path(), &name, &shape, &[]);
        assert_eq!(code, Some(0), "{name}: {said}");
        let taken = chosen(&done).clone();
        let (low, _) = lowest_rim(&folder.path().join(format!("{name}.gcode")), 0.5);
        assert!(low >= -0.005, "{name}: the rim {low} mm over the tilted table");
        let alone = |way: &&'static str| {
            let (code, done, _) = prepared(folder.path(), &name, &shape, &["--way", way]);
            (code == Some(0)).then(|| (*way, price(chosen(&done))))
        };
        // In the suite every other one of the four ways by itself, the other two for the next thing.
        let some = ["as-drawn", "turned", "supports", "cut"].iter().skip(seed as usize % every(2)).step_by(every(2));
        let each: Vec<(&str, f64)> = some.filter_map(alone).collect();
        compared += each.iter().filter(|(way, _)| *way != taken["way"]).count();
        let least = each.iter().map(|(_, price)| *price).fold(f64::INFINITY, f64::min);
        told.push(format!("{name}: {} {:.1} min, by themselves {each:.1?}", taken["way"], price(&taken)));
        // A twentieth, as the drawn pose is a wish.
        if price(&taken) > least / 0.95 + 1e-6 {
            dear.push(told[told.len() - 1].clone());
        }
    }
    note(&told.join("\n"));
    assert!(3 * compared >= told.len(), "{compared} ways besides those that were taken of {}", told.len());
    assert!(dear.is_empty(), "{}", dear.join("\n"));
}

/// Loose solids of one file: a plate that is printed as drawn, a table that is turned over, and a hook, all of them one behind the other
/// and over the rim of the machine's table.
#[test]
fn loose_solids_are_moved_apart_and_each_goes_its_way() {
    let folder = folder();
    let apart = |far: f64| {
        let top = block(24.0, 24.0, 3.0).at(0.0, 0.0, 20.0);
        let legs = [[0.0, 0.0], [19.0, 0.0], [0.0, 19.0], [19.0, 19.0]];
        let stool = legs.iter().fold(top, |all, [x, y]| all.and(&block(5.0, 5.0, 21.0).at(*x, *y, 0.0)));
        let plate = block(30.0, 20.0, 3.0);
        [plate, stool.at(far, 0.0, 0.0)]
    };
    let prepared = |far: f64, more: &[&str]| {
        let meshes = apart(far).map(|shape| shape.mesh());
        let (model, out) = (folder.path().join("two.stl"), folder.path().join("two.gcode"));
        std::fs::write(&model, trunnion::mesh::stl_binary_parts(&meshes.iter().collect::<Vec<_>>())).unwrap();
        let _ = std::fs::remove_file(&out);
        let mut command = trunnion();
        command.arg("prepare").arg(&model).args(["-m", "generic-ac", "--slicer", "builtin", "--json", "--no-remedies"]);
        let done = command.arg("-o").arg(&out).args(more).output().unwrap();
        let document: Value = serde_json::from_slice(&done.stdout).unwrap_or(Value::Null);
        (done.status.code(), document, said(&done))
    };
    // The stool has no plan as it is drawn, alone it is turned over; the plate stays.
    let (code, done, said) = prepared(60.0, &[]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(chosen(&done)["way"], "turned", "{}", done["ways"]);
    assert!(states(&said, "loose solids") && said.contains("(0.0000, 0.0000, -1.0000) up"), "{said}");
    assert!(row(&done, "as-drawn").unwrap()["why_not"].is_string(), "{}", done["ways"]);
    // 300 mm apart they do not lie on a table of 200 mm; moved together they do.
    let (code, done, said) = prepared(300.0, &["--way", "turned"]);
    assert_eq!((code, &chosen(&done)["way"]), (Some(0), &Value::from("turned")), "{said}");
    // As drawn they are moved, too, and then the stool hangs.
    let (code, no, said) = prepared(300.0, &["--way", "as-drawn"]);
    assert_eq!((code, &no["feasible"]), (Some(1), &Value::from(false)), "{said}");
}

/// One solid that lies over the rim as it was drawn, and stands within it on its end.
#[test]
fn what_does_not_fit_as_drawn_is_turned() {
    let folder = folder();
    for way in ["auto", "turned"] {
        let (code, done, said) = prepared(folder.path(), "tall", &block(206.0, 40.0, 40.0), &["--way", way]);
        assert_eq!((code, &chosen(&done)["way"]), (Some(0), &Value::from("turned")), "{way}: {said}");
        let drawn = row(&done, "as-drawn").map(|row| row["code"] == "table/over-rim");
        assert_eq!(drawn, (way == "auto").then_some(true), "{way}: {}", done["ways"]);
    }
    // It may lie on each of eight sides, all of them cheaper and none of them within the rim.
    let bar = rod(20.0, 206.0, 8).about_z(22.5).about_y(90.0).at(0.0, 0.0, 20.0);
    let (code, done, said) = prepared(folder.path(), "bar", &bar, &[]);
    assert_eq!((code, &chosen(&done)["way"]), (Some(0), &Value::from("turned")), "{said}");
    // On a round end it stands on supports alone. On the edge of a disc supports are too narrow: nobody is given what the nozzle pushes over.
    let round = rod(25.0, 50.0, 48)
        .and(&rod(25.0, 50.0, 48).at(156.0, 0.0, 0.0))
        .and(&block(156.0, 50.0, 50.0).at(0.0, -25.0, 0.0));
    let (code, done, said) = prepared(folder.path(), "round", &round, &[]);
    assert_eq!((code, &chosen(&done)["way"]), (Some(0), &Value::from("turned-supports")), "{said}");
    assert!(chosen(&done)["stands"].as_f64().unwrap() >= 1.0, "{}", done["ways"]);
    let disc = rod(103.0, 3.0, 96);
    let (code, no, said) = prepared(folder.path(), "disc", &disc, &[]);
    assert!(code == Some(2) && no["code"] == "strategy/room-elsewhere", "{said}");
    let (code, no, said) = prepared(folder.path(), "tall", &block(206.0, 40.0, 40.0), &["--way", "as-drawn"]);
    assert!(code == Some(2) && no["code"] == "strategy/room-elsewhere", "{said}");
}

/// A lug over a plate, with so little air between them that a slicer's own supports would just fit.
#[test]
fn what_hangs_over_the_part_is_propped_from_two_layers_of_air_on() {
    let folder = folder();
    for (air_mm, wanted) in [(0.6, true), (1.0, true), (2.0, true), (4.0, true), (0.1, false)] {
        let plate = block(40.0, 30.0, 3.0);
        let wall = block(4.0, 30.0, 12.0);
        let shelf = block(24.0, 30.0, 3.0).at(0.0, 0.0, 3.0 + air_mm);
        let shape = plate.and(&wall).and(&shelf);
        let (code, done, said) = prepared(folder.path(), "lug", &shape, &["--way", "supports"]);
        if wanted {
            assert_eq!(code, Some(0), "{air_mm} mm: {said}");
            let held = &done["supports"]["parts"][0];
            assert!(held["props"].as_u64().unwrap() > 0, "{air_mm} mm: {held}");
            // At most as much as fills the air below the shelf.
            let most = 20.0 * 30.0 * air_mm;
            assert!(held["volume_mm3"].as_f64().unwrap() < most, "{air_mm} mm: {held}");
        } else {
            // Less than a layer of air is none.
            assert_eq!(code, Some(1), "{air_mm} mm: {said}");
            assert_eq!(row(&done, "supports").unwrap()["code"], "way/nothing-hangs", "{air_mm} mm");
        }
    }
}

/// A search for cuts that nobody waits for ends with what was known before it began, and a file that is proved as ever.
#[cfg(unix)]
#[test]
fn an_interrupt_takes_what_was_found_so_far() {
    let folder = folder();
    let [machine, model, out] = ["dear.toml", "menorah.stl", "out.gcode"].map(|name| folder.path().join(name));
    // Supports are worth a thousand minutes, so that all cuts are looked for.
    std::fs::write(&machine, "extends = \"generic-ac\"\n[price]\nsupports_min = 1000.0\n").unwrap();
    std::fs::write(&model, stl_binary(&solids::menorah().mesh())).unwrap();
    let mut command = trunnion();
    command
        .arg("prepare")
        .arg(&model)
        .arg("-m")
        .arg(&machine)
        .args(["--slicer", "builtin", "--json", "-v", "-o"])
        .arg(&out);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let asked = lines.find(|line| line.contains("Ctrl-C"));
    assert!(asked.as_ref().is_some_and(|line| line.contains("supports")), "{asked:?}");
    let sent = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let mut text = String::new();
    child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    let said: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{said:?}");
    let done: Value = serde_json::from_str(&text).unwrap();
    assert!(chosen(&done)["way"].as_str().unwrap().ends_with("supports"), "{}", done["ways"]);
    let cut = row(&done, "cut").unwrap();
    assert!(cut["price_min"].is_null() && cut["why_not"].as_str().unwrap().starts_with("stopped after"), "{cut}");
    assert!(done["verify"]["findings"].as_array().unwrap().is_empty() && out.exists());
}

/// The same by a number of tries, which gives the same every time; and none at all is no plan.
#[test]
fn a_budget_ends_the_search_for_cuts() {
    let folder = folder();
    let [code, again] = [(); 2].map(|()| {
        let (code, done, _) = prepared(folder.path(), "knob", &knob(), &["--way", "cut", "--budget", "20"]);
        (code, row(&done, "cut").map(|cut| cut["why_not"].as_str().unwrap().to_owned()))
    });
    assert_eq!((code.0, &code), (Some(1), &again));
    assert!(code.1.as_ref().unwrap().contains("--budget"), "{code:?}");
    let (code, no, _) = prepared(folder.path(), "plain", &block(20.0, 20.0, 10.0), &["--budget", "0"]);
    assert!(code == Some(1) && no["error"].as_str().unwrap().contains("--budget"), "{no}");
}

#[test]
fn a_shipped_machine_that_can_is_named() {
    let folder = folder();
    let planned = |model: &Path, machine: &str| {
        let mut command = trunnion();
        command.arg("plan").arg(model).args(["--json", "-m", machine, "-o"]).arg(folder.path().join("plan.json"));
        let done = command.output().unwrap();
        (done.status.code(), serde_json::from_slice::<Value>(&done.stdout).unwrap())
    };
    let named = |text: &str| text.rsplit_once("-m ").map(|(_, name)| name.trim_end_matches(')').to_owned());
    // Wider than the disc of 70 mm; and parts of which one wants the table tilted by more than 45 degrees.
    let wide = folder.path().join("wide.stl");
    std::fs::write(&wide, stl_binary(&block(100.0, 60.0, 10.0).mesh())).unwrap();
    let (code, no) = planned(&wide, "open5x-prusa");
    let name = named(no["error"].as_str().unwrap()).unwrap_or_else(|| panic!("{no}"));
    assert_eq!((code, planned(&wide, &name).0), (Some(2), Some(0)), "{name}");
    let two = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/two-boxes.stl");
    let (code, no) = planned(&two, "penta-trt-bc");
    let remedies = no["remedies"].as_array().unwrap();
    let machine = remedies.iter().find(|remedy| remedy["kind"] == "machine").unwrap_or_else(|| panic!("{remedies:?}"));
    let name = named(machine["text"].as_str().unwrap()).unwrap();
    assert_eq!((code, planned(&two, &name).0), (Some(1), Some(0)), "{name}");
}
