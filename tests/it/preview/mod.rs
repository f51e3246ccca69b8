//! The page of `trunnion preview`: what is in it, read back by other code; and what a browser shows of it.

pub(crate) mod browser;
pub(crate) mod decoder;

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use trunnion::geom::{Angle, Vec3};
use trunnion::mesh::{Model, ReadOptions, TriangleMesh, read_model, threemf};
use trunnion::motion::Pose;
use trunnion::profile::{Profile, resolve};
use trunnion::trace::{self, Trace};
use trunnion::view::{DrawnMachine, DrawnProgram, Scene, Shapes};

use crate::pipeline::{fixture, prepare};
use crate::support::{Numbers, every, fails, folder, said, states, trunnion};
use decoder::Page;

/// A prepared file with its plan and its page.
pub(crate) struct Shown {
    pub(crate) folder: tempfile::TempDir,
    pub(crate) page: PathBuf,
    program: PathBuf,
    plan: PathBuf,
}

impl Shown {
    fn of(name: &str) -> Self {
        Self::on(name, "")
    }

    /// On the generic machine with the keys of `machine` instead of its own.
    fn on(name: &str, machine: &str) -> Self {
        let folder = folder();
        let path = |name: &str| folder.path().join(name);
        let (program, plan, page) = (path("whole.gcode"), path("plan.json"), path("view.html"));
        let own = path("own.toml");
        std::fs::write(&own, format!("extends = \"generic-ac\"\n{machine}")).unwrap();
        let own = if machine.is_empty() { "generic-ac" } else { own.to_str().unwrap() };
        prepare(&fixture(name), own, "builtin", &program, &["--plan-out", &plan.display().to_string()]);
        let document = preview(&program, &plan, &page, 0);
        assert_eq!(document["bytes"], std::fs::metadata(&page).unwrap().len());
        Self { folder, page, program, plan }
    }

    fn trace(&self) -> Trace {
        trace::read(&std::fs::read(&self.program).unwrap(), &generic().trace_setting())
    }

    fn read(&self) -> Page {
        Page::read(std::fs::read_to_string(&self.page).unwrap())
    }
}

fn generic() -> Profile {
    resolve("mine.toml", "").unwrap().0
}

/// `preview --json`, which must end with `code`; its document.
#[track_caller]
pub(crate) fn preview(program: &Path, plan: &Path, page: &Path, code: i32) -> Value {
    let run = trunnion().arg("preview").arg(program).arg("--plan").arg(plan).arg("-o").arg(page).arg("--json").output();
    let run = run.unwrap();
    assert_eq!(run.status.code(), Some(code), "{}", said(&run));
    serde_json::from_slice(&run.stdout).unwrap()
}

/// Where the table is at a moment of the trace, and the tip: between the ends of the move.
fn moment(trace: &Trace, index: usize, share: f64) -> Option<(Vec3, Pose)> {
    let one = trace.at(index);
    let [from, to] = one.ends()?;
    let (before, after) = (trace.state_before(&one).pose()?, trace.state(&one).pose()?);
    let mix = |a: Angle, b: Angle| Angle::from_rad(a.rad() + (b.rad() - a.rad()) * share);
    let pose = Pose { tilt: mix(before.tilt, after.tilt), rotation: mix(before.rotation, after.rotation) };
    Some((from + (to - from) * share, pose))
}

#[test]
fn what_is_in_a_page_is_what_the_trace_says() {
    for name in ["y-tree", "ding"] {
        let shown = Shown::of(name);
        let (page, trace) = (shown.read(), shown.trace());
        let moves = page.moves();
        assert_eq!(moves.len(), trace.len(), "{name}");
        let places = &page.facts["program"]["places"];
        let (mut clock, mut truth, mut turning) = (0.0, 0.0, 0);
        for (read, one) in moves.iter().zip(trace.moves()) {
            assert_eq!(read.line, u64::from(one.line));
            for axis in 0..3 {
                assert_eq!(one.to[axis].is_none(), read.flags >> axis & 1 == 1, "line {}", one.line);
                assert_eq!(one.from[axis].is_none(), read.flags >> (3 + axis) & 1 == 1, "line {}", one.line);
                let off = one.to[axis].map_or(0.0, |mm| (mm - read.mm[axis]).abs());
                assert!(off <= 5.1e-4, "line {}: {off} mm", one.line);
            }
            assert!((one.e - read.e).abs() < 1e-5, "line {}: {} for {}", one.line, read.e, one.e);
            assert_eq!(one.feed.unwrap_or_default(), read.feed, "line {}", one.line);
            assert_eq!(one.prints(), read.flags & 64 != 0, "line {}", one.line);
            assert_eq!(trace.has_new_pose(&one), read.flags & 128 != 0, "line {}", one.line);
            turning += usize::from(read.flags & 128 != 0);
            let (place, state) = (&places[read.place], trace.state(&one));
            assert_eq!(place["tilt"].as_f64(), state.tilt.map(Angle::rad), "line {}", one.line);
            assert_eq!(place["rotation"].as_f64(), state.rotation.map(Angle::rad), "line {}", one.line);
            assert_eq!(place["slot"].as_u64(), state.slot.map(u64::from), "line {}", one.line);
            if one.prints() {
                let style = &page.facts["program"]["styles"][read.style];
                assert_eq!(style[0].as_u64(), state.print.map(u64::from), "line {}", one.line);
                assert!((style[2].as_f64().unwrap() - one.width.unwrap_or_default()).abs() < 1e-9);
            }
            assert!(
                (read.seconds - one.seconds).abs() < 2e-4 + 1e-3 * one.seconds,
                "line {}: {} s",
                one.line,
                read.seconds
            );
            (clock, truth) = (clock + read.seconds, truth + one.seconds);
            assert!((clock - truth).abs() < 1e-4 * truth + 0.05, "line {}: {clock} s for {truth} s", one.line);
        }
        assert!(turning > 2, "{name} never turns");
        let file = std::fs::read_to_string(&shown.program).unwrap();
        let lines = page.lines(&moves);
        assert!(lines.iter().map(String::as_str).eq(file.lines()), "{name}: other lines than the file's");
        let layers = page.layers();
        assert!(layers.len() > 50 && layers.is_sorted() && layers.iter().all(|&i| moves[i].flags & 64 != 0), "{name}");
        let heights = |pair: &[usize]| (moves[pair[0]].mm[2], moves[pair[1]].mm[2]);
        let same = layers.windows(2).filter(|pair| heights(pair).0 == heights(pair).1).count();
        assert!(same < 10, "{name}: {same} layers at the height of the one before");
    }
}

#[test]
fn parts_and_poses_are_those_of_the_plan() {
    let shown = Shown::of("y-tree");
    let page = shown.read();
    let bytes = std::fs::read(fixture("y-tree")).unwrap();
    let model = read_model(&bytes, "y-tree.stl", &ReadOptions::default()).unwrap();
    let plan: Value = serde_json::from_slice(&std::fs::read(&shown.plan).unwrap()).unwrap();
    let origin = plan["placement"]["origin_mm"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap());
    let origin = Vec3::from_iterator(origin);
    assert_eq!(plan["placement"]["turn_deg"], 0.0);
    for ((points, facets), part) in page.parts().iter().zip(&model.parts) {
        assert!(facets.iter().flatten().zip(part.mesh.facets().iter().flatten()).all(|(a, b)| *a == i64::from(*b)));
        let off = points.iter().zip(part.mesh.vertices()).map(|(a, b)| (Vec3::from(*a) - b - origin).norm());
        assert!(off.fold(0.0, f64::max) < 1e-3);
    }
    let table = generic().kinematics();
    for pose in page.facts["poses"].as_array().unwrap() {
        let number = |key: &str, i: usize| pose[key][i].as_f64().unwrap();
        let truth = table.forward(Pose::from_deg(number("words_deg", 0), number("words_deg", 1)));
        for i in 0..9 {
            assert!((number("motion", i) - truth.rotation[(i / 3, i % 3)]).abs() < 1e-9);
        }
        assert!((0..3).all(|i| (number("motion", 9 + i) - truth.translation[i]).abs() < 1e-9));
    }
}

#[test]
fn a_page_keeps_to_its_budget_and_to_its_bytes() {
    let shown = Shown::of("candelabrum");
    let page = shown.read();
    let moves = page.facts["program"]["moves"].as_u64().unwrap() as usize;
    assert!(page.html.len() < 2_000_000 + 6 * moves, "{} bytes for {moves} moves", page.html.len());
    assert_eq!(page.facts["program"]["has_text"], true);
    let again = shown.folder.path().join("again.html");
    let mut run = trunnion();
    run.env("RAYON_NUM_THREADS", "1").args(["preview", "-q"]).arg(&shown.program).arg("--plan");
    assert!(run.arg(&shown.plan).arg("-o").arg(&again).output().unwrap().status.success());
    assert_eq!(page.html, std::fs::read_to_string(again).unwrap(), "other bytes the second time");
}

/// A program in which no line is like another, of `count` moves, in words that cannot be written anew where `plain` is false.
fn noise(count: usize, plain: bool) -> Vec<u8> {
    let mut numbers = Numbers::seeded(15);
    let mut text = "G90\nM83\nG1 X0 Y0 Z0.2 F1200\n".to_owned();
    for _ in 0..count {
        let [x, y, z] = numbers.triple(1.0).map(|v| v * 60.0);
        let (z, e) = (0.2 + z.abs(), numbers.between(0.01, 0.9));
        // The shortest digits, as our own files have them.
        let short = |v: f64, scale: f64| (v * scale).round() / scale;
        text += &if plain {
            format!("G1 X{} Y{} E{}\n", short(x, 1e3), short(y, 1e3), short(e, 1e5))
        } else {
            format!("G01 X{x:.5} Y{y:.5} Z{z:.5} E{e:.6}\n")
        };
    }
    text.into_bytes()
}

#[test]
fn a_program_of_noise_keeps_to_the_budget_too() {
    let profile = generic();
    for (plain, text) in [(true, true), (false, false)] {
        let bytes = noise(300_000, plain);
        let trace = trace::read(&bytes, &profile.trace_setting());
        let program = DrawnProgram::of(&trace, &bytes, &profile.kinematics(), 'E');
        let machine = DrawnMachine::of(profile.kinematics(), profile.linear_limits(), &profile.table_slab(), &[], &[]);
        let scene = Scene { machine, shapes: Shapes::of::<trunnion::geom::Table>(&[]), program: Some(program) };
        let packed = scene.packed();
        let page = packed.bytes.len() / 3 * 4 + 200_000;
        // Three columns in which every digit is chance have more in them than six bytes hold; those of a file do not.
        let most = 2_000_000 + if plain { 6 } else { 14 } * trace.len();
        assert!(page < most, "{page} bytes for {} moves", trace.len());
        assert_eq!(packed.has_text, text, "{page} bytes");
    }
}

/// Names that would be programs if a page took them for more than names.
const HOSTILE: [&str; 4] = [
    "</script><script>window.harmed = 1</script>",
    "\"'><img src=x onerror=\"window.harmed = 2\">",
    "<!--<script>@@script@@\u{2028}",
    "${window.harmed = 3}&lt;b&gt;\\",
];

/// Two boxes on each other and two beside them, under names that mean harm.
fn hostile(folder: &Path) -> Shown {
    let solid = |model: &Model| -> TriangleMesh { model.parts[0].mesh.clone() };
    let bytes = std::fs::read(fixture("cube")).unwrap();
    let cube = solid(&read_model(&bytes, "cube.stl", &ReadOptions::default()).unwrap());
    let beside = |i: usize| {
        let shift = trunnion::geom::Rigid::shift(Vec3::new(i as f64 * 40.0, 0.0, 0.0));
        cube.moved::<trunnion::geom::Object>(&shift)
    };
    let meshes: Vec<_> = (0..4).map(beside).collect();
    let objects: Vec<_> = HOSTILE.iter().zip(&meshes).map(|(name, mesh)| ((*name).to_owned(), mesh)).collect();
    let model = folder.join("a\"><img src=x onerror=alert(1)>.3mf");
    std::fs::write(&model, threemf(&objects)).unwrap();
    let own = crate::support::folder();
    let path = |name: &str| own.path().join(name);
    let (program, plan, page) = (path("<script>.gcode"), path("plan.json"), path("view.html"));
    let model = model.display().to_string();
    prepare(&model, "generic-ac", "builtin", &program, &["--plan-out", &plan.display().to_string()]);
    preview(&program, &plan, &page, 0);
    Shown { folder: own, page, program, plan }
}

#[test]
fn names_that_mean_harm_stay_names() {
    let models = folder();
    let shown = hostile(models.path());
    let page = shown.read();
    let names = page.facts["parts"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap());
    assert_eq!(names.collect::<Vec<_>>(), HOSTILE);
    let (before, rest) = page.html.split_once("id=\"facts\">").unwrap();
    let document = rest.split("</script>").next().unwrap();
    assert!(!document.contains('<') && !before.contains("harmed"));
    assert_eq!(page.html.matches("</script>").count(), 3, "an element was ended by a name");
    browser::stays_unharmed(&shown, &HOSTILE);
}

#[test]
fn a_plan_alone_and_the_lack_of_one_are_shown() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let (plan, page) = (path("plan.json"), path("plan.html"));
    let made =
        trunnion().args(["plan", &fixture("y-tree"), "-m", "generic-ac", "-q", "-o"]).arg(&plan).output().unwrap();
    assert!(made.status.success(), "{}", said(&made));
    let run = trunnion().args(["preview", "--json", "--plan"]).arg(&plan).arg("-o").arg(&page).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let document: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(
        [&document["shows"], &document["moves"], &document["verify"]],
        [&json!("plan"), &json!(0), &json!(null)]
    );
    let read = Page::read(std::fs::read_to_string(&page).unwrap());
    let planned: Value = serde_json::from_slice(&std::fs::read(&plan).unwrap()).unwrap();
    let printed: Vec<&Value> =
        read.facts["poses"].as_array().unwrap().iter().flat_map(|p| p["fresh"].as_array().unwrap()).collect();
    let wanted =
        planned["slots"].as_array().unwrap().iter().flat_map(|s| s["prints"].as_array().unwrap()).map(|p| &p["part"]);
    assert_eq!(printed, wanted.collect::<Vec<_>>());

    // The same from the model itself; and one for which there is no plan.
    let direct = path("direct.html");
    let run =
        trunnion().args(["preview", &fixture("y-tree"), "-m", "generic-ac", "-q", "-o"]).arg(&direct).output().unwrap();
    assert!(run.status.success() && direct.is_file(), "{}", said(&run));
    let none = path("none.html");
    let run = trunnion()
        .args(["preview", &fixture("caged"), "-m", "generic-ac", "--json", "-o"])
        .arg(&none)
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(1), "{}", said(&run));
    let document: Value = serde_json::from_slice(&run.stdout).expect("one document");
    assert_eq!(document["shows"], "reasons");
    let read = Page::read(std::fs::read_to_string(&none).unwrap());
    let reasons = read.facts["poses"].as_array().unwrap();
    assert!(!reasons.is_empty() && reasons.iter().all(|r| !r["text"].as_str().unwrap().is_empty()));
    assert!(!read.facts["why_not"].as_str().unwrap().is_empty());
    browser::shows_poses(folder.path(), &page, &none);
}

/// What `plan` takes, `preview` of a model takes: there is a page of whatever was asked for. Supports are drawn with what they hold.
#[test]
fn a_model_is_planned_as_it_would_be_by_plan() {
    let folder = folder();
    let page = folder.path().join("view.html");
    let shown = |words: &[&str]| -> Value {
        let mut run = trunnion();
        run.arg("preview").args(words).args(["-m", "generic-ac", "-q", "-o"]).arg(&page);
        let run = run.output().unwrap();
        assert!(run.status.success(), "{words:?}: {}", said(&run));
        Page::read(std::fs::read_to_string(&page).unwrap()).facts
    };
    let poses = |facts: &Value| facts["poses"].as_array().unwrap().len();
    let towers = fixture("between-towers");
    let (together, single) = (shown(&[&towers]), shown(&[&towers, "--slots", "only-single"]));
    assert!(poses(&single) > poses(&together), "{} and {} poses", poses(&single), poses(&together));
    let two = shown(&[&fixture("cube"), &fixture("cube"), "--unit", "mm", "--gap", "40"]);
    assert_eq!(two["parts"].as_array().unwrap().len(), 2);

    let held = shown(&[&fixture("hook"), "--supports", "auto"]);
    let roles: Vec<&Value> = held["parts"].as_array().unwrap().iter().map(|part| &part["role"]).collect();
    assert_eq!(roles, ["solid", "support"]);
    assert_eq!(held["poses"][0]["fresh"], json!([0, 1]));
    assert!(held["parts"][1]["facets"].as_u64().unwrap() > 20, "{}", held["parts"]);
    browser::shows_supports(&page);

    for words in
        [&["--supports", "auto"][..], &["--slots", "single"], &["--up", "1,0,0"], &["--unit", "mm"], &["--bridge", "5"]]
    {
        let run =
            trunnion().args(["preview", "x.gcode", "--plan", "p.json", "-o", "v.html"]).args(words).output().unwrap();
        assert_eq!(run.status.code(), Some(2), "{}", said(&run));
        // With the flag that was given, not with all that could have been.
        assert!(
            fails(&said(&run), "command/usage") && said(&run).contains(&format!("'{} <", words[0])),
            "{words:?}: {}",
            said(&run)
        );
    }
    let words = ["preview", "x.gcode", "other.stl", "--plan", "p.json", "-o", "v.html", "--json"];
    let run = trunnion().args(words).output().unwrap();
    let document: Value = serde_json::from_slice(&run.stdout).unwrap();
    let error = document["error"].as_str().unwrap();
    assert!(
        document["code"] == "command/usage" && states(error, "'--plan <PLAN.json>' | '[MODEL[*COUNT]]...'"),
        "{error}"
    );
    let run = trunnion().args(["rewrite", "a", "--json"]).output().unwrap();
    let document: Value = serde_json::from_slice(&run.stdout).unwrap();
    let error = document["error"].as_str().unwrap();
    assert!(
        document["code"] == "command/usage" && states(error, "--plan <PLAN.json>, --output <OUT.gcode>"),
        "{error}"
    );
}

/// Two plans, and two finished files, in one page.
#[test]
fn two_are_shown_side_by_side() {
    let (one, other) = (Shown::of("two-boxes"), Shown::of("y-tree"));
    let page = one.folder.path().join("both.html");
    let word = |shown: &Shown| format!("{}={}", shown.program.display(), shown.plan.display());
    let plans = [one.plan.display().to_string(), other.plan.display().to_string()];
    for (words, kind) in [([word(&one), word(&other)], "program"), (plans, "plan")] {
        let mut run = trunnion();
        let run = run.args(["preview", "--json", "--compare"]).args(&words).arg("-o").arg(&page).output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
        let document: Value = serde_json::from_slice(&run.stdout).unwrap();
        assert_eq!(document["shows"], "two");
        assert_eq!(document["bytes"], std::fs::metadata(&page).unwrap().len());
        let shows = document["pages"].as_array().unwrap().iter().map(|one| one["shows"].as_str().unwrap());
        assert_eq!(shows.collect::<Vec<_>>(), [kind; 2]);
        browser::shows_both(&page, kind == "program");
    }
    let refused = |words: &[&str], wanted: &str| {
        let run = trunnion().args(["preview", "--compare"]).args(words).args(["-o", "x.html"]).output().unwrap();
        assert_eq!(run.status.code(), Some(2), "{}", said(&run));
        assert!(said(&run).contains(wanted), "{}", said(&run));
    };
    refused(&["a.json"], "--compare");
    refused(&["gone.json", "gone.json"], "file not found");
    refused(&["a.json", "b.json", "--plan", "c.json"], "cannot be used with");
}

/// A file that verification rejects is not written, but it can be looked at.
#[test]
fn what_prepare_rejects_is_shown_and_not_written() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    // The built-in slicer's temperature is beyond what this nozzle may be asked for.
    std::fs::write(at("cool.toml"), "extends = \"generic-ac\"\n[link]\nmax_nozzle_c = 150.0\n").unwrap();
    let mut run = trunnion();
    run.args(["prepare", &fixture("cube"), "--slicer", "builtin", "-m"]).arg(at("cool.toml"));
    let run = run.arg("-o").arg(at("out.gcode")).arg("--preview").arg(at("view.html")).output().unwrap();
    assert_eq!(run.status.code(), Some(1), "{}", said(&run));
    assert!(fails(&said(&run), "command/no: 2 findings | line 78 | 210 C | 150 C | max_nozzle_c"), "{}", said(&run));
    assert!(!at("out.gcode").exists(), "what was rejected is there to be printed");
    let page = Page::read(std::fs::read_to_string(at("view.html")).unwrap());
    let findings = page.facts["verify"]["findings"].as_array().unwrap();
    assert!(!findings.is_empty() && findings.iter().all(|one| one["rule"] == "heat"), "{findings:?}");
    assert!(page.facts["program"]["moves"].as_u64().unwrap() > 1000);
}

/// The line between the two nearest places is as long as the clearance, one end on the table or in what was laid.
#[test]
fn the_least_clearance_has_its_two_places() {
    for name in ["y-tree", "candelabrum"].into_iter().step_by(every(2)) {
        let shown = Shown::of(name);
        let facts = shown.read().facts;
        let verify = &facts["verify"];
        let near = &verify["clearance_at"];
        let place = |key: &str| Vec3::from_fn(|i, _| near[key][i].as_f64().unwrap());
        let (head, other) = (place("head_mm"), place("other_mm"));
        let (length, least) = ((head - other).norm(), verify["clearance_mm"].as_f64().unwrap());
        assert!((length - least).abs() < 0.02, "{name}: {length} mm between them for {least} mm");
        // By other code: what stands there is the table or a corner, edge or face of a part, but for half a line.
        let (bytes, plan) = (std::fs::read(fixture(name)).unwrap(), std::fs::read(&shown.plan).unwrap());
        let model = read_model(&bytes, "x.stl", &ReadOptions::default()).unwrap();
        let plan: Value = serde_json::from_slice(&plan).unwrap();
        let origin = Vec3::from_fn(|i, _| plan["placement"]["origin_mm"][i].as_f64().unwrap());
        let away = |mesh: &TriangleMesh| {
            let facets = 0..mesh.facets().len();
            facets.map(|i| from_triangle(mesh.corners(i).map(|c| c + origin), other)).fold(f64::INFINITY, f64::min)
        };
        let part = model.parts.iter().map(|part| away(&part.mesh)).fold(f64::INFINITY, f64::min);
        assert!(part < 0.5 || other.z.abs() < 1e-3, "{name}: {part} mm from all parts, {} above the table", other.z);
        assert!((0.0..=1.0).contains(&near["share"].as_f64().unwrap()));
        rooms_hold(name, &facts);
        browser::draws_the_least_clearance(&shown);
    }
}

/// The rooms of runs of moves: one after the other, few told as none, and most of a tree's as more than anybody worries about.
fn rooms_hold(name: &str, facts: &Value) {
    let program = &facts["program"];
    let number = |room: &Value, i: usize| room[i].as_f64().unwrap();
    let rooms = program["rooms"].as_array().unwrap();
    let most = program["surveyed_mm"].as_f64().unwrap();
    assert!(rooms.windows(2).all(|two| number(&two[0], 1) <= number(&two[1], 0)), "{name}: runs lie over each other");
    assert!(rooms.iter().all(|room| number(room, 0) < number(room, 1) && (0.0..=most).contains(&number(room, 2))));
    let moves = |of: &dyn Fn(f64) -> bool| -> f64 {
        rooms.iter().filter(|room| of(number(room, 2))).map(|room| number(room, 1) - number(room, 0)).sum()
    };
    let all = moves(&|_| true);
    assert!(all > 0.9 * program["moves"].as_f64().unwrap(), "{name}: {all} moves have their room");
    assert!(moves(&|mm| mm == most) > 0.5 * all && moves(&|mm| mm == 0.0) < 0.01 * all, "{name}: {rooms:?}");
}

/// By sampling: good to a hundredth of the triangle.
fn from_triangle([a, b, c]: [Vec3; 3], p: Vec3) -> f64 {
    let steps = 40;
    let places = (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| (i, j)));
    let at =
        |(i, j): (i32, i32)| a + (b - a) * f64::from(i) / f64::from(steps) + (c - a) * f64::from(j) / f64::from(steps);
    let reach = [a, b, c].iter().map(|corner| (corner - a).norm()).fold(0.0, f64::max);
    if (a - p).norm() > reach + 2.0 {
        f64::INFINITY
    } else {
        places.map(|one| (at(one) - p).norm()).fold(f64::INFINITY, f64::min)
    }
}

#[test]
fn what_cannot_be_shown_is_refused_with_a_reason() {
    let shown = Shown::of("two-boxes");
    let path = |name: &str| shown.folder.path().join(name);
    let refused = |program: &Path, plan: &Path, page: &str, wanted: &str| {
        let page = path(page);
        let run = trunnion().arg("preview").arg(program).arg("--plan").arg(plan).arg("-o").arg(&page).output().unwrap();
        assert_eq!(run.status.code(), Some(2), "{}", said(&run));
        let text = String::from_utf8_lossy(&run.stderr);
        assert!(text.contains(wanted), "{wanted:?} is not in {text}");
        assert!(!page.is_file(), "{} was written", page.display());
    };
    let (program, plan) = (&shown.program, &shown.plan);
    refused(program, plan, "view.png", ": unsupported file type; use .html");
    refused(program, plan, "no/view.html", "does not exist");
    refused(&path("gone.gcode"), plan, "x.html", "file not found");
    refused(plan, plan, "x.html", "no ;TRUNNION comment with a plan at its head");
    let foreign = path("sliced.gcode");
    std::fs::write(&foreign, "G28\nG1 X1 Y1 E1\n").unwrap();
    refused(&foreign, plan, "x.html", "rewrite the slicer's file first");
    let other = path("other.json");
    let made =
        trunnion().args(["plan", &fixture("ding"), "-m", "generic-ac", "-q", "-o"]).arg(&other).output().unwrap();
    assert!(made.status.success(), "{}", said(&made));
    refused(program, &other, "x.html", "pass the plan that made it");
    let still = path("still.gcode");
    let first = std::fs::read_to_string(program).unwrap().lines().take(3).collect::<Vec<_>>().join("\n");
    std::fs::write(&still, first).unwrap();
    refused(&still, plan, "x.html", "has no moves, so there is nothing to see");
    let bare = trunnion().args(["preview", "-o", "x.html"]).output().unwrap();
    assert_eq!(bare.status.code(), Some(2), "{}", said(&bare));
}
