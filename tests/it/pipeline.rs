//! The whole job, as a user runs it: every fixture, the built-in slicer and the real ones.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;
use trunnion::fixtures::solid_box;
use trunnion::geom::Vec3;
use trunnion::mesh::stl_binary;

use crate::support::{folder, installed, note, root, said, skip, soak, states, trunnion};

pub(crate) const FIXTURES: [&str; 5] = ["cube", "two-boxes", "ding", "y-tree", "candelabrum"];

pub(crate) fn fixture(name: &str) -> String {
    root().join(format!("fixtures/{name}.stl")).display().to_string()
}

/// `prepare` with `--json`, which must succeed; its document. Where `scripts/test.sh` runs the tests, a fixture on a shipped machine is made once a
/// run for the built-in slicer, and copied from then on: the same words give the same bytes, which [`prepare_twice`] holds them to.
pub(crate) fn prepare(model: &str, machine: &str, slicer: &str, output: &Path, more: &[&str]) -> Value {
    let shipped = trunnion::profile::shipped(machine).is_ok() && Path::new(model).starts_with(root().join("fixtures"));
    match std::env::var("TRUNNION_RUN") {
        Ok(run) if slicer == "builtin" && shipped => made_once(&run, model, machine, output, more),
        _ => made(model, machine, slicer, output, more),
    }
}

/// The file and the plan lie in a folder beside the one that they are copied to, so that the plan's way to its model is the same. What is asked for
/// besides a plan is made anew.
fn made_once(run: &str, model: &str, machine: &str, output: &Path, more: &[&str]) -> Value {
    let plan = match more {
        [] => None,
        ["--plan-out", plan] if Path::new(plan).parent() == output.parent() => Some(Path::new(plan)),
        _ => return made(model, machine, "builtin", output, more),
    };
    if output.parent().and_then(Path::parent) != Some(&std::env::temp_dir()) {
        return made(model, machine, "builtin", output, more);
    }
    let name = Path::new(model).file_stem().unwrap().display();
    let once = std::env::temp_dir().join(format!("trunnion-made-{run}-{name}-{machine}"));
    let file = |name: &str| once.join(name);
    // Whoever comes while another makes it waits here.
    std::fs::create_dir_all(&once).unwrap();
    let lock = std::fs::File::create(file("lock")).unwrap();
    lock.lock().unwrap();
    if !file("document.json").exists() {
        let more = ["--plan-out", &file("plan.json").display().to_string()];
        let document = made(model, machine, "builtin", &file("out.gcode"), &more);
        std::fs::write(file("document.json"), document.to_string()).unwrap();
    }
    drop(lock);
    std::fs::copy(file("out.gcode"), output).unwrap();
    plan.map(|plan| std::fs::copy(file("plan.json"), plan).unwrap());
    let mut document: Value = serde_json::from_slice(&std::fs::read(file("document.json")).unwrap()).unwrap();
    document["output"] = output.display().to_string().into();
    document
}

fn made(model: &str, machine: &str, slicer: &str, output: &Path, more: &[&str]) -> Value {
    let mut command = trunnion();
    command.args(["prepare", model, "-m", machine, "--slicer", slicer, "--json", "-o"]).arg(output).args(more);
    let run = command.output().unwrap();
    assert!(run.status.success(), "{model} on {machine} with {slicer}: {}", said(&run));
    serde_json::from_slice(&run.stdout).unwrap()
}

/// The plan's estimate of the seconds, before anything is sliced, comes so near to what verification counts.
const MOST_OFF: f64 = 0.14;

fn prepare_twice(name: &str) {
    let slicer = "builtin";
    let folder = folder();
    let (first, second) = (folder.path().join("a.gcode"), folder.path().join("b.gcode"));
    let document = prepare(&fixture(name), "generic-ac", slicer, &first, &[]);
    assert_eq!(document["verify"]["findings"], serde_json::json!([]), "{name}");
    assert!(document["verify"]["filament_mm"].as_f64().unwrap() > 100.0);
    // Estimates are for comparing plans, and for a day's planning: what takes turns layer by layer is among them.
    let [estimate, counted] = [&document["plan"]["seconds_print_estimate"], &document["verify"]["seconds_print"]]
        .map(|s| s.as_f64().unwrap());
    note(&format!("{name}: {estimate:.0} s estimated by the plan, {counted:.0} s counted by verification"));
    assert!((estimate / counted - 1.0).abs() < MOST_OFF, "{name}: {estimate} for {counted} s");
    let one_thread = trunnion()
        .env("RAYON_NUM_THREADS", "1")
        .args(["prepare", &fixture(name), "-m", "generic-ac", "--slicer", slicer, "-q", "-o"])
        .arg(&second)
        .output()
        .unwrap();
    assert!(one_thread.status.success(), "{}", said(&one_thread));
    assert_eq!(std::fs::read(&first).unwrap(), std::fs::read(&second).unwrap(), "{name}: other bytes the second time");
}

#[test]
fn every_fixture_is_prepared_and_verified_with_the_built_in_slicer_to_the_same_bytes() {
    FIXTURES.iter().for_each(|name| prepare_twice(name));
}

/// Prepared and verified with a program of its own, whose slices rewrite to the same bytes however often.
fn prepare_with(name: &str, slicer: &str) {
    let folder = folder();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let whole = folder.path().join("whole.gcode");
    let document = prepare(&fixture(name), "generic-ac", slicer, &whole, &["--plan-out", &path("plan.json")]);
    assert_eq!(document["verify"]["findings"], serde_json::json!([]), "{name}");
    let run =
        trunnion().args(["slice", &path("plan.json"), "--slicer", slicer, "-o", &path("slots")]).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let slots = std::fs::read_dir(path("slots")).unwrap().map(|f| f.unwrap().path().display().to_string());
    let slots: Vec<String> = slots.filter(|f| f.ends_with(".gcode")).collect();
    let rewrite = |threads: &str, output: &str| {
        let mut command = trunnion();
        command.env("RAYON_NUM_THREADS", threads).arg("rewrite").args(&slots);
        let run = command.args(["--plan", &path("plan.json"), "-o", &path(output)]).output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
        std::fs::read(path(output)).unwrap()
    };
    let (first, second) = (rewrite("2", "a.gcode"), rewrite("1", "b.gcode"));
    assert!(first == second, "{name}: the same slices rewrote to other bytes");
    // The slicer has now sliced twice. PrusaSlicer 2.5 on a busy machine gives other travels once in a while; that is its
    // own doing and is said aloud, not passed over.
    if std::fs::read(&whole).unwrap() != first {
        note(&format!("{slicer} gave other bytes for the same {name} the second time"));
    }
}

#[test]
fn every_fixture_is_prepared_and_verified_with_prusa_slicer() {
    if !installed("prusa-slicer") {
        return skip("prusa-slicer is not installed (apt-get install prusa-slicer)");
    }
    // The candelabrum's eighteen prints are a soak's.
    let names = FIXTURES.iter().filter(|name| **name != "candelabrum" || soak().is_some());
    names.for_each(|name| prepare_with(name, "prusa-slicer"));
}

/// The same bytes twice from end to end, within three tries: see [`prepare_with`].
#[test]
fn a_fixture_comes_out_the_same_twice_with_prusa_slicer() {
    if !installed("prusa-slicer") {
        return skip("prusa-slicer is not installed (apt-get install prusa-slicer)");
    }
    let folder = folder();
    let file = |i: usize| folder.path().join(format!("{i}.gcode"));
    let bytes = |i: usize| {
        prepare(&fixture("y-tree"), "generic-ac", "prusa-slicer", &file(i), &[]);
        std::fs::read(file(i)).unwrap()
    };
    let first = bytes(0);
    assert!((1..4).any(|i| bytes(i) == first), "never the same bytes");
}

#[test]
fn the_small_fixtures_are_prepared_and_verified_with_slic3r() {
    if !installed("slic3r") {
        return skip("slic3r is not installed (apt-get install slic3r)");
    }
    ["cube", "two-boxes", "y-tree"].iter().for_each(|name| prepare_with(name, "slic3r"));
}

#[test]
fn what_a_slicer_that_nobody_asked_for_lays_wrongly_is_sliced_by_the_built_in_one() {
    if !installed("prusa-slicer") {
        return skip("prusa-slicer is not installed (apt-get install prusa-slicer)");
    }
    // Too small for PrusaSlicer's whole lines.
    let folder = folder();
    let (model, out) = (folder.path().join("tiny.stl"), folder.path().join("tiny.gcode"));
    let tiny = solid_box(Vec3::zeros(), Vec3::repeat(1.0));
    std::fs::write(&model, stl_binary(&tiny)).unwrap();
    let run = |more: &[&str]| {
        trunnion()
            .arg("prepare")
            .arg(&model)
            .args(["--unit", "mm", "-m", "generic-ac", "-o"])
            .arg(&out)
            .args(more)
            .output()
            .unwrap()
    };
    let done = run(&[]);
    assert!(done.status.success() && states(&said(&done), "warning: PrusaSlicer | built-in"), "{}", said(&done));
    let asked = run(&["--slicer", "prusa-slicer"]);
    assert!(!asked.status.success() && states(&said(&asked), "--slicer builtin"), "{}", said(&asked));
}

#[test]
fn other_machines_take_what_fits_them() {
    let folder = folder();
    for (name, machine) in [
        ("cube", "fibr3d"),
        ("y-tree", "fibr3d"),
        ("candelabrum", "fibr3d"),
        ("y-tree", "open5x-prusa"),
        ("two-boxes", "linuxcnc-xyzac-trt"),
    ] {
        prepare(&fixture(name), machine, "builtin", &folder.path().join("x.gcode"), &[]);
    }
}

/// Ramos et al. (2021), section 6.2, L1: base, stem, the eight lower arms at (70, +-90), the eight upper arms upright.
#[test]
fn the_candelabrum_is_planned_in_the_four_slots_of_the_paper() {
    let run = trunnion().args(["plan", &fixture("candelabrum"), "-m", "generic-ac", "--json"]).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let plan: Value = serde_json::from_slice(&run.stdout).unwrap();
    let slots: Vec<BTreeSet<(i64, i64, i64)>> = plan["slots"]
        .as_array()
        .unwrap()
        .iter()
        .map(|slot| {
            let print = |p: &Value| {
                let tenth = |key: &str| (p[key].as_f64().unwrap() * 10.0).round() as i64;
                (p["part"].as_i64().unwrap(), tenth("tilt_deg"), tenth("rotation_deg"))
            };
            slot["prints"].as_array().unwrap().iter().map(print).collect()
        })
        .collect();
    let at = |parts: &[i64], tilt: i64, turn: i64| parts.iter().map(move |&p| (p, tilt, turn)).collect::<Vec<_>>();
    let lower = [at(&[3, 5, 11, 13], 700, 900), at(&[7, 8, 15, 17], 700, -900)].concat();
    let wanted = [at(&[0], 0, 0), at(&[1], 0, 0), lower, at(&[2, 4, 6, 9, 10, 12, 14, 16], 0, 0)];
    assert_eq!(slots, wanted.map(BTreeSet::from_iter));
    // Eq. (8): 0 + 1 + 8 * 2 + 8 * 3, which no sequence can beat.
    assert_eq!((plan["value"].as_f64(), plan["lower_bound"].as_f64()), (Some(41.0), Some(41.0)));
}

#[test]
fn single_parts_first_gives_a_slot_a_part_like_the_papers_l2() {
    let run = trunnion()
        .args(["plan", &fixture("candelabrum"), "-m", "generic-ac", "--slots", "single", "--json"])
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let plan: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(plan["slots"].as_array().unwrap().len(), 18);
}

#[test]
fn arms_at_seventy_degrees_are_printed_at_the_poses_of_the_plan() {
    let folder = folder();
    let (file, plan_file) = (folder.path().join("c.gcode"), folder.path().join("plan.json"));
    prepare(&fixture("candelabrum"), "generic-ac", "builtin", &file, &["--plan-out", &plan_file.display().to_string()]);
    let plan: Value = serde_json::from_slice(&std::fs::read(&plan_file).unwrap()).unwrap();
    let mut planned: Vec<(String, String)> = Vec::new();
    for print in plan["slots"].as_array().unwrap().iter().flat_map(|s| s["prints"].as_array().unwrap()) {
        let word = |key: &str| print[key].as_f64().unwrap().to_string();
        let pose = (word("tilt_deg"), word("rotation_deg"));
        if planned.last() != Some(&pose) {
            planned.push(pose);
        }
    }
    // The words of the file, read without any code of ours: the pose at every first extrusion after a turn.
    let text = std::fs::read_to_string(&file).unwrap();
    let (mut a, mut c, mut printed) = (String::new(), String::new(), Vec::new());
    for line in text.lines().filter(|l| !l.starts_with(';')) {
        for word in line.split(' ') {
            match word.split_at(word.len().min(1)) {
                ("A", value) => a = value.to_owned(),
                ("C", value) => c = value.to_owned(),
                ("E", value) if !value.starts_with('-') && line.contains('X') => {
                    let pose = (a.clone(), c.clone());
                    if printed.last() != Some(&pose) {
                        printed.push(pose);
                    }
                }
                _ => {}
            }
        }
    }
    assert_eq!(printed, planned);
    assert!(printed.contains(&("70".to_owned(), "90".to_owned())), "{printed:?}");
    assert!(printed.contains(&("70".to_owned(), "-90".to_owned())), "{printed:?}");
}

#[test]
fn slices_made_one_by_one_rewrite_to_the_bytes_of_prepare() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name).display().to_string();
    prepare(
        &fixture("ding"),
        "generic-ac",
        "builtin",
        &folder.path().join("whole.gcode"),
        &["--plan-out", &path("plan.json")],
    );
    let slice =
        trunnion().args(["slice", &path("plan.json"), "-o", &path("slots"), "--slicer", "builtin"]).output().unwrap();
    assert!(slice.status.success(), "{}", said(&slice));
    let mut files: Vec<String> = std::fs::read_dir(folder.path().join("slots"))
        .unwrap()
        .map(|f| f.unwrap().path().display().to_string())
        .filter(|f| f.ends_with(".gcode"))
        .collect();
    files.sort();
    files.reverse();
    assert_eq!(files.len(), 4);
    let rewrite = trunnion()
        .arg("rewrite")
        .args(&files)
        .args(["--plan", &path("plan.json"), "-o", &path("parts.gcode")])
        .output()
        .unwrap();
    assert!(rewrite.status.success(), "{}", said(&rewrite));
    assert_eq!(std::fs::read(path("whole.gcode")).unwrap(), std::fs::read(path("parts.gcode")).unwrap());
    let verify =
        trunnion().args(["verify", &path("parts.gcode"), "--plan", &path("plan.json"), "--json"]).output().unwrap();
    assert!(verify.status.success(), "{}", said(&verify));
    let report: Value = serde_json::from_slice(&verify.stdout).unwrap();
    for key in
        ["findings", "clearance_mm", "clearance_line", "moves", "slots", "filament_mm", "seconds_print", "seconds"]
    {
        assert!(!report[key].is_null(), "{key}");
    }
}

#[test]
fn documents_have_the_keys_that_scripts_rely_on() {
    let inspect = trunnion().args(["inspect", &fixture("y-tree"), "--json"]).output().unwrap();
    let document: Value = serde_json::from_slice(&inspect.stdout).unwrap();
    assert_eq!(document["unit"], "mm");
    assert_eq!(document["on_table"], serde_json::json!([0]));
    for key in ["id", "facets", "closed", "volume_mm3", "area_mm2", "box_mm"] {
        assert!(!document["parts"][1][key].is_null(), "{key}");
    }
    let shared = document["interfaces"][0]["area_mm2"].as_f64().unwrap();
    assert!((shared - 20.0 * 200f64.sqrt()).abs() < 1e-3, "{shared}");
    let folder = folder();
    let document = prepare(&fixture("cube"), "generic-ac", "builtin", &folder.path().join("x.gcode"), &[]);
    for key in ["output", "plan", "verify", "slicer", "seconds"] {
        assert!(!document[key].is_null(), "{key}");
    }
    for key in ["read", "orient", "plan", "slice", "rewrite", "verify"] {
        assert!(document["seconds"][key].is_number(), "{key}");
    }
    for key in ["objective", "value", "lower_bound", "clearance_mm", "seconds", "slots", "placement"] {
        assert!(!document["plan"][key].is_null(), "{key}");
    }
}

#[test]
fn a_pipe_gets_results_only_and_a_closed_one_is_no_error() {
    let run = trunnion().args(["inspect", &fixture("cube"), "--json", "-q"]).output().unwrap();
    assert!(run.stderr.is_empty(), "{}", said(&run));
    let help = trunnion().arg("--help").output().unwrap();
    let text = String::from_utf8(help.stdout).unwrap();
    for word in ["prepare", "inspect", "plan", "slice", "rewrite", "verify", "profile", "Exit codes"] {
        assert!(text.contains(word), "{word} is missing from --help");
    }
}

/// The README's picture is made by the command that its caption names. UPDATE_FIXTURES=1 writes it anew.
#[test]
fn the_readmes_picture_is_what_the_command_draws() {
    let folder = folder();
    let sheet = folder.path().join("sheet.svg");
    let run =
        trunnion().args(["plan", &fixture("candelabrum"), "-m", "generic-ac", "--sheet"]).arg(&sheet).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let kept = root().join("fixtures/candelabrum-plan.svg");
    if std::env::var_os("UPDATE_FIXTURES").is_some() {
        std::fs::copy(&sheet, &kept).unwrap();
    }
    let (drawn, kept) = (std::fs::read_to_string(&sheet).unwrap(), std::fs::read_to_string(&kept).unwrap());
    assert_eq!(drawn.matches("slot ").count(), 5);
    assert_eq!(drawn, kept);
}

#[test]
fn a_terminal_sees_a_bar_and_a_pipe_does_not() {
    let folder = folder();
    let output = folder.path().join("x.gcode");
    let words = ["prepare", &fixture("candelabrum"), "-m", "generic-ac", "--slicer", "builtin", "-o"].join(" ");
    let command = format!("{} {words} {}", env!("CARGO_BIN_EXE_trunnion"), output.display());
    let piped = std::process::Command::new("sh").args(["-c", &command]).output().unwrap();
    assert!(piped.status.success() && piped.stdout.is_empty(), "{}", said(&piped));
    let text = String::from_utf8_lossy(&piped.stderr).into_owned();
    assert!(!text.contains("slicing  ") && !text.contains('\u{1b}'), "{text}");
    if !installed("script") {
        return skip("script is not installed (bsdutils)");
    }
    // Slowed down to one thread, so that the second after which a bar may show has passed.
    let shown = std::process::Command::new("script")
        .env("RAYON_NUM_THREADS", "1")
        // Without a name, or called dumb, a terminal gets no bar.
        .env("TERM", "xterm")
        .args(["-qec", &command, "/dev/null"])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&shown.stdout).into_owned();
    assert!(shown.status.success() && text.contains("slicing  ") && text.contains("18/18"), "{text}");
}
