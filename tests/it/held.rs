//! One solid on supports, from its file to a verified one; and every way to break the supports is seen.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use trunnion::fixtures::solid_box;
use trunnion::geom::{Object, Vec3};
use trunnion::mesh::{ReadOptions, TriangleMesh, read_model, stl_binary, stl_binary_parts};

use crate::split::solids::{Shape, all, ball, block, rod};
use crate::support::{every, folder as new_folder, installed, note, root, skip, soak, states, trunnion};

fn run(folder: &Path, args: &[&str]) -> Output {
    trunnion().current_dir(folder).args(args).output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn prepared(folder: &Path, slicer: &str, more: &[&str]) -> Output {
    let args = [
        "prepare",
        "solid.stl",
        "-m",
        "generic-ac",
        "--slicer",
        slicer,
        "-o",
        "out.gcode",
        "--plan-out",
        "out.json",
        "--json",
    ];
    run(folder, &[&args[..], more].concat())
}

fn written(folder: &Path, shape: &Shape) {
    fs::write(folder.join("solid.stl"), stl_binary(&shape.mesh())).unwrap();
}

/// A round head on a cone, two arms held out, on a disc: what no plane cuts well.
fn figurine() -> Shape {
    let arm = rod(4.0, 22.0, 24).about_y(80.0);
    let body = rod(14.0, 40.0, 32).and(&ball(12.0, 32).at(0.0, 0.0, 50.0));
    body.and(&arm.at(8.0, 0.0, 30.0))
        .and(&arm.about_z(180.0).at(-8.0, 0.0, 30.0))
        .and(&block(60.0, 40.0, 4.0).at(-30.0, -20.0, 0.0))
}

/// Shoulders, neck, and a head with a nose that looks a little up.
fn bust() -> Shape {
    let below = block(200.0, 200.0, 100.0).at(-100.0, -100.0, -100.0);
    let shoulders = ball(24.0, 32).scaled(0.6, 1.0, 0.9).at(0.0, 0.0, 4.0).less(&below);
    let head = ball(14.0, 32).scaled(1.0, 0.85, 1.2).at(0.0, 0.0, 52.0);
    let nose = rod(2.5, 8.0, 16).about_y(70.0).at(10.0, 0.0, 50.0);
    shoulders.and(&rod(8.0, 30.0, 32).at(0.0, 0.0, 15.0)).and(&head).and(&nose)
}

#[test]
fn solids_go_to_a_verified_file_on_supports() {
    let folder = new_folder();
    let here = folder.path();
    let mut slicers = vec!["builtin"];
    for (program, name) in [("prusa-slicer", "prusa-slicer"), ("slic3r", "slic3r")] {
        if installed(program) {
            slicers.push(name);
        } else {
            skip(&format!("{program} is not installed"));
        }
    }
    let named = |name: &str| all().into_iter().find(|solid| solid.name == name).unwrap().shape;
    let shapes = [
        ("tee", named("tee")),
        ("mushroom", named("mushroom")),
        ("bracket", named("bracket")),
        ("figurine", figurine()),
        ("bust", bust()),
    ];
    for (index, (name, shape)) in shapes.into_iter().enumerate() {
        written(here, &shape);
        // Slic3r lays lines of the tee's first layer over air twice, and fills the figurine's neck with odd ones; supports or not.
        let odd = ["tee", "figurine"].contains(&name);
        // In the suite each shape with one of them.
        let all = slicers.iter().filter(|slicer| !odd || **slicer != "slic3r");
        for slicer in all.skip(if soak().is_some() { 0 } else { index % 3 }).step_by(every(3)) {
            // The bust's chin droops without them.
            let how: &[&str] = if name == "bust" { &["--finish", "fine"] } else { &[] };
            let done = prepared(here, slicer, &[how, &["--way", "supports"]].concat());
            assert!(done.status.success(), "{name}, {slicer}: {}", told(&done));
            let document: Value = serde_json::from_slice(&done.stdout).unwrap();
            let supports = &document["supports"];
            assert!(supports["volume_mm3"].as_f64().unwrap() > 100.0, "{supports}");
            assert!(states(&told(&done), "on supports | mm3"), "{}", told(&done));
            assert_eq!(document["plan"]["slots"][0]["prints"][0]["supports"]["gap_mm"], 0.2);
            // By what is on the disk alone.
            let verify = run(here, &["verify", "out.gcode", "--plan", "out.json"]);
            assert!(verify.status.success(), "{name}, {slicer}: {}", told(&verify));
            let page = run(here, &["preview", "out.gcode", "--plan", "out.json", "-o", "view.html"]);
            assert!(page.status.success(), "{name}, {slicer}: {}", told(&page));
            note(&format!("{name}, {slicer}: {} mm3 of support", supports["volume_mm3"].as_f64().unwrap().round()));
            fs::remove_file(here.join("out.gcode")).unwrap();
        }
    }
}

/// A block with a chamber, open to one side, whose floor rises by so much and whose ceiling is level and too wide for a bridge.
fn chamber(rises_deg: f64) -> Shape {
    let (long, rise) = (20.0, 20.0 * rises_deg.to_radians().tan());
    let below_floor = block(100.0, 100.0, 100.0).at(-50.0, -50.0, -100.0).about_y(-rises_deg).at(-1.0, 0.0, 4.0);
    let chamber = block(long + 1.0, 20.0, rise + 8.0).at(-1.0, 3.0, 3.0).less(&below_floor);
    block(long + 4.0, 26.0, rise + 14.0).less(&chamber)
}

#[test]
fn what_hangs_over_a_slope_of_the_part_is_held_from_there() {
    let folder = new_folder();
    let here = folder.path();
    for rises_deg in
        [0.0, 25.0, 45.0, 10.0, 20.0, 30.0, 35.0, 40.0, 50.0, 60.0].into_iter().take(if every(2) == 1 { 10 } else { 3 })
    {
        written(here, &chamber(rises_deg));
        let done = prepared(here, "builtin", &["--way", "supports"]);
        assert!(done.status.success(), "{rises_deg}: {}", told(&done));
        let verify = run(here, &["verify", "out.gcode", "--plan", "out.json"]);
        assert!(verify.status.success(), "{rises_deg}: {}", told(&verify));
    }
}

/// A plate on two walls, and below it a keel 30 mm long: its sides lean by so many degrees, its edge is 12 mm up and turned about z.
fn hull(half_deg: f64, turned_deg: f64) -> Shape {
    let half = 10.0 * half_deg.to_radians().tan();
    let wide = (half + 6.0).max(20.0);
    let wall = |x: f64| block(4.0, 30.0, 26.0).at(x, -15.0, 0.0);
    let left = block(60.0, 60.0, 60.0).at(-60.0, -30.0, 0.0).about_y(-half_deg);
    let keel = block(2.0 * half + 20.0, 30.0, 10.5).at(-half - 10.0, -15.0, 0.0).less(&left).less(&left.about_z(180.0));
    let plate = block(2.0 * wide + 8.0, 30.0, 4.0).at(-wide - 4.0, -15.0, 22.0);
    wall(-wide - 4.0).and(&wall(wide)).and(&plate).and(&keel.at(0.0, 0.0, 12.0)).about_z(turned_deg)
}

/// The lowest layers of a keel are narrower than any line: slicers lay nothing there, each a little more or less of it.
#[test]
fn a_sharp_edge_below_is_held_where_slicers_begin_to_lay_it() {
    let folder = new_folder();
    let here = folder.path();
    let all = [(20.0, 33.0), (5.0, 33.0), (40.0, 33.0), (30.0, 0.0), (10.0, 0.0), (50.0, 33.0), (10.0, 33.0)];
    for (place, (half_deg, turned_deg)) in all.into_iter().take(if every(2) == 1 { 7 } else { 2 }).enumerate() {
        written(here, &hull(half_deg, turned_deg));
        for slicer in ["builtin", "prusa-slicer", "slic3r"] {
            if slicer != "builtin" && (place > 0 && every(2) > 1 || !installed(slicer)) {
                continue;
            }
            let done = prepared(here, slicer, &["--way", "supports"]);
            let words = told(&done);
            assert!(done.status.success(), "{slicer}, {half_deg}, {turned_deg}: {words}");
            assert!(!words.contains("refuses"), "{slicer}, {half_deg}, {turned_deg}: the first file does: {words}");
            let verify = run(here, &["verify", "out.gcode", "--plan", "out.json"]);
            assert!(verify.status.success(), "{slicer}, {half_deg}, {turned_deg}: {}", told(&verify));
        }
    }
}

/// Real meshes, scaled to a height, as they stand.
#[test]
fn real_meshes_go_to_a_verified_file_on_supports() {
    let meshes = root().join("../shared/data/meshes");
    if !meshes.exists() {
        skip("../shared/data is not there");
        return;
    }
    let folder = new_folder();
    let here = folder.path();
    for (file, high) in
        // Camel and cow have limbs that run into each other.
        [
            ("castro/bunny.off", 40.0),
            ("castro/horse_quad.obj", 27.5),
            ("castro/decimated-knight.off", 18.4),
            ("castro/camel_b.obj", 60.0),
            ("castro/cow.off", 19.5),
        ]
        .into_iter()
        .step_by(every(3))
    {
        let bytes = fs::read(meshes.join(file)).unwrap();
        let model = read_model(&bytes, file, &ReadOptions::default()).unwrap();
        fs::write(here.join("solid.stl"), stl_binary(&scaled(&model.parts[0].mesh, high))).unwrap();
        let done = prepared(here, "builtin", &["--split", "never"]);
        assert!(done.status.success(), "{file}: {}", told(&done));
        let document: Value = serde_json::from_slice(&done.stdout).unwrap();
        note(&format!("{file}: supports {}", document["supports"]["volume_mm3"]));
        fs::remove_file(here.join("out.gcode")).unwrap();
    }
}

/// The mesh scaled to `high` mm.
fn scaled(mesh: &TriangleMesh<Object>, high: f64) -> TriangleMesh<Object> {
    let bounds = mesh.bounds();
    let scale = high / bounds.size().z;
    let at = |v: &Vec3| (v - bounds.min) * scale;
    TriangleMesh::new(mesh.vertices().iter().map(at).collect(), mesh.facets().to_vec())
}

/// A post with a beam that is held by supports: the finished file, line by line.
struct Held {
    folder: tempfile::TempDir,
    lines: Vec<String>,
    /// The lines that lay supports.
    supports: Vec<usize>,
}

impl Held {
    fn new() -> Self {
        let folder = new_folder();
        let here = folder.path();
        written(here, &block(16.0, 16.0, 30.0).and(&block(60.0, 16.0, 8.0).at(0.0, 0.0, 22.0)));
        let done = prepared(here, "builtin", &["--way", "supports"]);
        assert!(done.status.success(), "{}", told(&done));
        let text = fs::read_to_string(here.join("out.gcode")).unwrap();
        let lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let mut role = "";
        let mut supports = Vec::new();
        for (at, line) in lines.iter().enumerate() {
            role = line.strip_prefix(";TYPE:").unwrap_or(role);
            if role == "Support material" && line.starts_with("G1 ") && line.contains(['X', 'Y']) && line.contains(" E")
            {
                supports.push(at);
            }
        }
        assert!(supports.len() > 500);
        Self { folder, lines, supports }
    }

    /// The rules that the file breaks once `change` was made to the lines.
    fn broken_by(&self, change: impl FnOnce(&mut Vec<String>)) -> Vec<String> {
        let mut lines = self.lines.clone();
        change(&mut lines);
        fs::write(self.folder.path().join("mutant.gcode"), lines.join("\n")).unwrap();
        let run = run(self.folder.path(), &["verify", "mutant.gcode", "--plan", "out.json", "--json"]);
        let document: Value = serde_json::from_slice(&run.stdout).unwrap_or_default();
        let mut rules: Vec<String> = document["findings"]
            .as_array()
            .into_iter()
            .flatten()
            .map(|f| f["rule"].as_str().unwrap().to_owned())
            .collect();
        rules.sort();
        rules.dedup();
        rules
    }
}

/// The number behind `letter` in a line.
fn number(line: &str, letter: char) -> Option<f64> {
    line.split(' ').find_map(|word| word.strip_prefix(letter)?.parse().ok())
}

/// The line with `by` added to what stands behind `letter`.
fn moved(line: &str, letter: char, by: f64) -> String {
    let word = |word: &str| match word.strip_prefix(letter).and_then(|v| v.parse::<f64>().ok()) {
        Some(value) => format!("{letter}{:.3}", value + by),
        None => word.to_owned(),
    };
    line.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

#[test]
fn broken_supports_are_seen() {
    let held = Held::new();
    assert!(held.broken_by(|_| {}).is_empty(), "unchanged");
    // Without what they lay: what they hold hangs.
    let travelled = held.broken_by(|lines| {
        for &at in &held.supports {
            lines[at] = lines[at].split(' ').filter(|word| !word.starts_with('E')).collect::<Vec<_>>().join(" ");
        }
    });
    assert!(travelled.contains(&"in-air".to_owned()) && travelled.contains(&"sequence".to_owned()), "{travelled:?}");
    // Called something else, and something else called a support.
    let renamed = held.broken_by(|lines| {
        lines
            .iter_mut()
            .filter(|line| *line == ";TYPE:Support material")
            .for_each(|line| *line = ";TYPE:Perimeter".to_owned());
    });
    assert!(renamed.contains(&"outside-part".to_owned()), "{renamed:?}");
    // A print of the part marked as supports, and the other way round.
    let swapped = |from: &str, to: &str| {
        held.broken_by(|lines| {
            lines
                .iter_mut()
                .filter(|line| line.starts_with(";TRUNNION print="))
                .for_each(|line| *line = line.replace(from, to));
        })
    };
    for (from, to) in [("print=0", "print=1"), ("print=1", "print=0")] {
        assert!(!swapped(from, to).is_empty(), "{from} as {to}");
    }
    // Half of the filament.
    let starved = held.broken_by(|lines| {
        for &at in &held.supports {
            let e = number(&lines[at], 'E').unwrap();
            lines[at] = moved(&lines[at], 'E', -e / 2.0);
        }
    });
    assert!(starved.contains(&"outside-part".to_owned()) && starved.contains(&"filament".to_owned()), "{starved:?}");
    // Not in the plan.
    let plan = held.folder.path().join("out.json");
    let text = fs::read_to_string(&plan).unwrap();
    let mut document: Value = serde_json::from_str(&text).unwrap();
    assert!((3..=4).contains(&document["version"].as_u64().unwrap()));
    document["slots"][0]["prints"][0].as_object_mut().unwrap().remove("supports");
    fs::write(&plan, document.to_string()).unwrap();
    assert!(!held.broken_by(|_| {}).is_empty(), "supports that no plan wants");
}

/// All supports moved against the post, by nothing up to a line; and lifted or sunk.
#[test]
fn supports_are_told_from_the_part_at_a_tenth_of_a_line() {
    let held = Held::new();
    // From the way down to their first line to their last line, in each layer.
    let mut own: Vec<usize> = Vec::new();
    let mut since: Option<Vec<usize>> = None;
    for (at, line) in held.lines.iter().enumerate() {
        if line.starts_with(";TRUNNION print=") {
            since = line.contains("print=1").then(Vec::new);
        } else if let Some(since) = since.as_mut().filter(|_| line.starts_with("G1 ")) {
            since.push(at);
            if held.supports.binary_search(&at).is_ok() {
                own.append(since);
            }
        }
    }
    let shifted = |letter: char, by: f64| {
        held.broken_by(|lines| own.iter().for_each(|&at| lines[at] = moved(&lines[at], letter, by)))
    };
    // They begin 0.225 mm beside the post, on its +X side: their edge meets it there, and 0.05 mm are let pass.
    let mut first = None;
    for hundredths in [0, 5, 10, 15, 20, 25, 28, 30, 35, 45, 80] {
        let by = -f64::from(hundredths) / 100.0;
        let rules = shifted('X', by);
        if !rules.is_empty() && first.is_none() {
            first = Some(hundredths);
        }
        assert!(first.is_none() || !rules.is_empty(), "{by}");
    }
    note(&format!("supports moved towards the post are seen from -{:.2} mm on", f64::from(first.unwrap()) / 100.0));
    assert!((20..=35).contains(&first.unwrap()), "{first:?}");
    // Upward their first layer leaves the table; downward what lies on them has more air below it. That is laid as a bridge here, whose
    // thread is as high as the nozzle is wide: it reaches down 0.2 mm farther than a line of its layer.
    let mut seen = [None; 2];
    for hundredths in [1, 3, 5, 7, 10, 15, 20, 25, 30, 40] {
        for (way, sign) in [1.0, -1.0].into_iter().enumerate() {
            let broken = !shifted('Z', sign * f64::from(hundredths) / 100.0).is_empty();
            assert!(seen[way].is_none() || broken, "{sign} {hundredths}");
            seen[way] = seen[way].or(broken.then_some(hundredths));
        }
    }
    note(&format!("supports lifted or sunk are seen from so many hundredths of a millimetre on: {seen:?}"));
    assert!(
        seen[0].is_some_and(|mm| (5..=10).contains(&mm)) && seen[1].is_some_and(|mm| (5..=30).contains(&mm)),
        "{seen:?}"
    );
}

#[test]
fn what_supports_cannot_do_is_said() {
    let folder = new_folder();
    let here = folder.path();
    // As wide as the table: its supports would stand beside it.
    written(here, &block(20.0, 20.0, 20.0).at(-10.0, -10.0, 0.0).and(&block(170.0, 20.0, 5.0).at(-85.0, -10.0, 20.0)));
    let narrow = "extends = \"generic-ac\"\n[table]\nradius_mm = 84.0\n";
    fs::write(here.join("machine.toml"), narrow).unwrap();
    let args =
        ["prepare", "solid.stl", "-m", "machine.toml", "--slicer", "builtin", "--split", "never", "-o", "out.gcode"];
    let done = run(here, &args);
    assert_eq!(done.status.code(), Some(1), "{}", told(&done));
    assert!(states(&told(&done), "supports: | mm | table"), "{}", told(&done));
    // Not where nobody wants them.
    written(here, &block(16.0, 16.0, 30.0).and(&block(60.0, 16.0, 8.0).at(0.0, 0.0, 22.0)));
    let done = prepared(here, "builtin", &["--way", "as-drawn"]);
    assert_eq!(done.status.code(), Some(1), "{}", told(&done));
    assert!(!here.join("out.gcode").exists() && !told(&done).contains("on supports"));
    // A plan says so, and its bad values are refused.
    let planned = run(here, &["plan", "solid.stl", "-m", "generic-ac", "--supports", "auto", "-o", "plan.json"]);
    assert!(planned.status.success(), "{}", told(&planned));
    assert!(
        states(&String::from_utf8_lossy(&planned.stdout), "part 0 | on supports")
            || told(&planned).contains("on supports")
    );
    let text = fs::read_to_string(here.join("plan.json")).unwrap();
    for (key, value, says) in [
        ("step_mm", "0.0", "between 1 and 20"),
        ("gap_mm", "-1.0", "between 0 and 2"),
        ("overhang_deg", "90.0", "between 1 and 89"),
    ] {
        let mut document: Value = serde_json::from_str(&text).unwrap();
        document["slots"][0]["prints"][0]["supports"][key] = serde_json::from_str(value).unwrap();
        fs::write(here.join("bad.json"), document.to_string()).unwrap();
        let done = run(here, &["slice", "bad.json", "-o", "slots"]);
        assert!(told(&done).contains(says) && done.status.code() == Some(2), "{key}: {}", told(&done));
    }
    // Sliced by hand: the supports come with the rewriting.
    let sliced = run(here, &["slice", "plan.json", "--slicer", "builtin", "-o", "slots"]);
    assert!(sliced.status.success(), "{}", told(&sliced));
    let rewritten =
        run(here, &["rewrite", "slots/print-00-part-0.gcode", "--plan", "plan.json", "-o", "by-hand.gcode"]);
    assert!(rewritten.status.success(), "{}", told(&rewritten));
    assert!(fs::read_to_string(here.join("by-hand.gcode")).unwrap().contains(";TYPE:Support material"));
}

/// A tee whose bar hangs out on both sides, and boxes.
fn assembly(folder: &Path, boxes: &[([f64; 3], [f64; 3])]) {
    let tee = block(12.0, 12.0, 30.0).at(-6.0, -6.0, 0.0).and(&block(44.0, 12.0, 6.0).at(-22.0, -6.0, 30.0)).mesh();
    let boxes: Vec<TriangleMesh<Object>> = boxes.iter().map(|(a, b)| solid_box((*a).into(), (*b).into())).collect();
    let parts: Vec<&TriangleMesh<Object>> = std::iter::once(&tee).chain(&boxes).collect();
    fs::write(folder.join("solid.stl"), stl_binary_parts(&parts)).unwrap();
}

/// What stands on the table is held, what touches it is printed later, tilted, clear of the supports; without them the plan says why not.
#[test]
fn a_base_is_held_while_what_touches_it_is_printed_tilted() {
    let folder = new_folder();
    let here = folder.path();
    // A post on the bar, and a branch out of the post.
    assembly(here, &[([-5.0, -5.0, 36.0], [5.0, 5.0, 70.0]), ([5.0, -4.0, 55.0], [20.0, 4.0, 63.0])]);
    let none = prepared(here, "builtin", &["--supports", "never"]);
    assert!(!none.status.success() && told(&none).contains("part 0"), "{}", told(&none));
    let mut slicers = vec!["builtin"];
    if installed("prusa-slicer") {
        slicers.push("prusa-slicer");
    } else {
        skip("prusa-slicer is not installed");
    }
    for slicer in slicers {
        let done = prepared(here, slicer, &[]);
        assert!(done.status.success(), "{slicer}: {}", told(&done));
        let document: Value = serde_json::from_slice(&done.stdout).unwrap();
        assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()));
        let slots = document["plan"]["slots"].as_array().unwrap();
        let parts: Vec<&Value> = slots.iter().map(|slot| &slot["prints"][0]["part"]).collect();
        assert_eq!(parts, [0, 1, 2].map(Value::from).iter().collect::<Vec<_>>());
        let held: Vec<bool> = slots.iter().map(|slot| slot["prints"][0]["supports"].is_object()).collect();
        assert_eq!(held, [true, false, false], "{slots:?}");
        assert_eq!(slots[2]["prints"][0]["tilt_deg"], 90.0);
        let volume = document["supports"]["volume_mm3"].as_f64().unwrap();
        note(&format!("{slicer}: {volume:.0} mm3 of support below the base"));
        assert!(volume > 100.0);
        let verify = run(here, &["verify", "out.gcode", "--plan", "out.json"]);
        assert!(verify.status.success(), "{slicer}: {}", told(&verify));
        fs::remove_file(here.join("out.gcode")).unwrap();
    }
}

#[test]
fn supports_of_a_base_keep_out_of_other_parts_and_of_later_heads() {
    let folder = new_folder();
    let here = folder.path();
    for (boxes, why) in [
        // A branch out of the bar's end, right above its underside.
        (
            &[([22.0, -5.0, 30.5], [40.0, 5.0, 35.5])],
            "while part 1 is printed, the nozzle would hit the supports of part 0",
        ),
        // A branch out of the post, below the bar: no head gets there.
        (&[([6.0, -5.0, 10.0], [16.0, 5.0, 20.0])], "or join the parts (--join)"),
    ] {
        assembly(here, boxes);
        let refused = prepared(here, "builtin", &[]);
        assert!(!refused.status.success(), "{}", told(&refused));
        let document: Value = serde_json::from_slice(&refused.stdout).unwrap();
        assert!(document["supports"].as_str().is_some_and(|said| said.contains(why)), "{document}");
        assert!(!here.join("out.gcode").exists());
    }
    // Two millimetres higher the branch is clear of them; and a block beside the post, below one arm, they go around.
    for one in [([22.0, -5.0, 32.0], [40.0, 5.0, 36.0]), ([6.0, -6.0, 0.0], [20.0, 6.0, 20.0])] {
        assembly(here, &[one]);
        let done = prepared(here, "builtin", &[]);
        assert!(done.status.success(), "{}", told(&done));
    }
}
