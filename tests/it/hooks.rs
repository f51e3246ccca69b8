//! The post-processing script, run by the real slicers: the same file as offline, and nothing printable after a failure.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cura::through_cura;
use crate::pipeline::fixture;
use crate::support::{fails, folder, installed, prusa_slicer, said, skip, states, trunnion};

/// What any user would have in his profile for this: no first-layer extras, no start code, objects one by one.
const CONFIG: &str = "\
nozzle_diameter = 0.4
filament_diameter = 1.75
layer_height = 0.2
first_layer_height = 0.2
extrusion_width = 0.45
perimeter_extrusion_width = 0.45
external_perimeter_extrusion_width = 0.45
infill_extrusion_width = 0.45
solid_infill_extrusion_width = 0.45
top_infill_extrusion_width = 0.45
first_layer_extrusion_width = 0
skirts = 0
brim_width = 0
start_gcode =
end_gcode =
gcode_flavor = marlin
use_relative_e_distances = 1
layer_gcode = G92 E0
temperature = 205
first_layer_temperature = 205
";

const PRUSA_ONLY: &str = "\
gcode_label_objects = 1
complete_objects = 1
extruder_clearance_radius = 40
extruder_clearance_height = 1000
elefant_foot_compensation = 0
";

/// A plan and its slots' meshes in `folder`.
fn planned(folder: &Path, name: &str) -> PathBuf {
    let plan = folder.join("plan.json");
    let run = trunnion().args(["plan", &fixture(name), "-m", "generic-ac", "-o"]).arg(&plan).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let run = trunnion().arg("slice").arg(&plan).args(["--meshes-only", "-o"]).arg(folder).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    plan
}

fn hook(plan: &Path) -> String {
    format!("{} rewrite --in-place --plan {}", env!("CARGO_BIN_EXE_trunnion"), plan.display())
}

/// PrusaSlicer with `scripts` run one after the other over its file.
fn prusa(folder: &Path, output: &Path, scripts: &[&str]) -> std::process::Output {
    let config = folder.join("config.ini");
    std::fs::write(&config, format!("{CONFIG}{PRUSA_ONLY}")).unwrap();
    let mut command = prusa_slicer();
    command.arg("--load").arg(&config).arg("--dont-arrange");
    command.args(["--bed-shape", "0x0,2000x0,2000x2000,0x2000", "--max-print-height", "1000"]);
    command.arg(folder.join("project.3mf")).arg("-g").arg("-o").arg(output);
    for script in scripts {
        command.args(["--post-process", script]);
    }
    command.output().unwrap()
}

/// `rewrite` of the slicer's own file, offline; the date in its first line is not the file's business.
fn offline(plan: &Path, sliced: &Path, output: &Path) -> Vec<u8> {
    let run = trunnion().arg("rewrite").arg(sliced).arg("--plan").arg(plan).arg("-o").arg(output).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    std::fs::read(output).unwrap()
}

/// Without the config block's record of the hook itself.
fn comparable(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    text.lines().filter(|l| !l.starts_with("; post_process =")).collect::<Vec<_>>().join("\n")
}

fn moves(bytes: &[u8]) -> usize {
    String::from_utf8_lossy(bytes)
        .lines()
        .filter(|l| ["G0", "G1", "G2", "G3", "M104", "M109", "M140"].iter().any(|c| l.starts_with(c)))
        .count()
}

#[test]
fn prusa_slicer_runs_the_hook_to_the_file_of_rewrite_offline() {
    if !installed("prusa-slicer") {
        return skip("prusa-slicer is not installed (apt-get install prusa-slicer)");
    }
    let folder = folder();
    for name in ["two-boxes", "ding"] {
        let plan = planned(folder.path(), name);
        let (hooked, sliced) = (folder.path().join("hooked.gcode"), folder.path().join("sliced.gcode"));
        // PrusaSlicer 2.5 gives other travels once in a while: a script before the hook keeps the file of this very run.
        let keep = folder.path().join("keep.sh");
        std::fs::write(&keep, format!("cp \"$1\" '{}'\n", sliced.display())).unwrap();
        let run = prusa(folder.path(), &hooked, &[&format!("sh {}", keep.display()), &hook(&plan)]);
        assert!(run.status.success(), "{name}: {}", said(&run));
        let offline = offline(&plan, &sliced, &folder.path().join("offline.gcode"));
        let hooked = std::fs::read(&hooked).unwrap();
        assert!(String::from_utf8_lossy(&hooked).contains(";TRUNNION slot=1 part=1 A=90 C=90"), "{name}");
        assert!(hooked == offline, "{name}: the hook's file is not that of rewrite offline");
    }
}

#[test]
fn slic3r_runs_the_hook_to_the_file_of_rewrite_offline() {
    if !installed("slic3r") {
        return skip("slic3r is not installed (apt-get install slic3r)");
    }
    let folder = folder();
    let plan = planned(folder.path(), "cube");
    let (hooked, sliced) = (folder.path().join("hooked.gcode"), folder.path().join("sliced.gcode"));
    let slice = |output: &Path, hook: Option<String>| {
        let config = folder.path().join("slic3r.ini");
        let line = hook.map(|h| format!("post_process = {h}\n")).unwrap_or_default();
        std::fs::write(&config, format!("{CONFIG}{line}")).unwrap();
        let run = Command::new("slic3r")
            .args(["--no-gui", "--dont-arrange", "--load"])
            .arg(&config)
            .arg(folder.path().join("print-00-part-0.stl"))
            .arg("-o")
            .arg(output)
            .output()
            .unwrap();
        assert!(run.status.success(), "{}", said(&run));
    };
    slice(&hooked, Some(hook(&plan)));
    slice(&sliced, None);
    let offline = offline(&plan, &sliced, &folder.path().join("offline.gcode"));
    let hooked = std::fs::read(&hooked).unwrap();
    assert!(String::from_utf8_lossy(&hooked).contains(";TRUNNION slot=0 part=0 A=0 C=0"), "the hook did not run");
    assert_eq!(comparable(&hooked), comparable(&offline));
}

/// Slic3r and PrusaSlicer's command line keep the file when the script fails, so the file itself must not print.
#[test]
fn a_failing_hook_leaves_nothing_printable() {
    let folder = folder();
    let plan = planned(folder.path(), "cube");
    let cases: [(&str, &[u8], &str); 4] = [
        ("inches", b"G20\nG1 X1 Y1 Z1\n", "inches"),
        ("binary", b"GCDE\x01\x00\x00\x00", "binary_gcode = 0"),
        ("moved", b"G21\nG90\nM83\nG1 X10 Y10 Z0.2 F1200\nG1 X30 E1\nG1 Y30 E1\n", "in the slicer"),
        ("rotary", b"G21\nM83\nG1 X120 Y120 Z0.2 A1\n", "A word"),
    ];
    for (name, bytes, wanted) in cases {
        let file = folder.path().join(format!("{name}.gcode"));
        std::fs::write(&file, bytes).unwrap();
        let run = trunnion().args(["rewrite", "--in-place", "--plan"]).arg(&plan).arg(&file).output().unwrap();
        assert_eq!(run.status.code(), Some(2), "{name}: {}", said(&run));
        let left = std::fs::read(&file).unwrap();
        assert_eq!(moves(&left), 0, "{name}");
        assert!(String::from_utf8_lossy(&left).contains(wanted), "{name}: {}", String::from_utf8_lossy(&left));
        assert!(said(&run).contains(wanted), "{name}: {}", said(&run));
    }
}

#[test]
fn a_failing_hook_in_the_real_slicers_leaves_nothing_printable() {
    let folder = folder();
    let plan = planned(folder.path(), "cube");
    // A plan whose model is gone: the hook fails after the slicer has done its work.
    let broken = folder.path().join("broken.json");
    std::fs::write(&broken, std::fs::read_to_string(&plan).unwrap().replace("cube.stl", "gone.stl")).unwrap();
    if installed("prusa-slicer") {
        let output = folder.path().join("prusa.gcode");
        let run = prusa(folder.path(), &output, &[&hook(&broken)]);
        assert!(!run.status.success(), "{}", said(&run));
        assert_eq!(moves(&std::fs::read(&output).unwrap_or_default()), 0);
    } else {
        skip("prusa-slicer is not installed (apt-get install prusa-slicer)");
    }
    if installed("slic3r") {
        let output = folder.path().join("slic3r.gcode");
        let config = folder.path().join("slic3r.ini");
        std::fs::write(&config, format!("{CONFIG}post_process = {}\n", hook(&broken))).unwrap();
        Command::new("slic3r")
            .args(["--no-gui", "--dont-arrange", "--load"])
            .arg(&config)
            .arg(folder.path().join("print-00-part-0.stl"))
            .arg("-o")
            .arg(&output)
            .output()
            .unwrap();
        assert_eq!(moves(&std::fs::read(&output).unwrap()), 0);
    } else {
        skip("slic3r is not installed (apt-get install slic3r)");
    }
}

#[test]
fn the_cura_script_gives_the_file_of_rewrite_offline() {
    let folder = folder();
    let plan = planned(folder.path(), "cube");
    let run =
        trunnion().arg("slice").arg(&plan).args(["--slicer", "builtin", "-o"]).arg(folder.path()).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let sliced = folder.path().join("print-00-part-0.gcode");
    // Cura cuts the file at its own marks; give it some. The built-in slicer's checksum is then no longer right.
    let mut text = std::fs::read_to_string(&sliced).unwrap().replace(";LAYER_CHANGE", ";LAYER:0");
    text.truncate(text.rfind("; crc32 = ").unwrap());
    std::fs::write(&sliced, &text).unwrap();
    let binary = Path::new(env!("CARGO_BIN_EXE_trunnion"));
    let Some(saved) = through_cura(binary, &text, &plan, None, &[]) else { return };
    let offline = offline(&plan, &sliced, &folder.path().join("offline.gcode"));
    assert_eq!(without_cura_marks(&saved.gcode), without_cura_marks(&String::from_utf8_lossy(&offline)));
    assert!(saved.gcode.contains(";TRUNNION slot=0"));
    let Some(failed) = through_cura(binary, "G20\nG1 X1 Y1\n", &plan, None, &[]) else { return };
    assert_eq!(moves(failed.gcode.as_bytes()), 0, "{}", failed.gcode);
    assert!(failed.said.contains("MESSAGE"), "{}", failed.said);
}

/// Cura marks the file as post-processed on its way out.
fn without_cura_marks(text: &str) -> String {
    text.lines().filter(|l| !l.starts_with(";POSTPROCESSED") && !l.is_empty()).collect::<Vec<_>>().join("\n")
}

/// A folder as a person keeps it: the model and his own machine here, the plan there, and a slicer's window somewhere else.
fn kept_apart(folder: &Path) -> (PathBuf, PathBuf, PathBuf) {
    for name in ["models", "machines", "plans"] {
        std::fs::create_dir(folder.join(name)).unwrap();
    }
    std::fs::copy(fixture("cube"), folder.join("models/cube.stl")).unwrap();
    let machine = folder.join("machines/mine.toml");
    std::fs::write(&machine, "extends = \"generic-ac\"\n[process]\nlayer_height_mm = 0.25\n").unwrap();
    let plan = |more: &[&str], from: &str| {
        let run = trunnion().current_dir(folder.join(from)).args(more).output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
    };
    plan(&["plan", "../models/cube.stl", "-m", "mine.toml", "-o", "../plans/plan.json"], "machines");
    plan(&["slice", "plan.json", "--slicer", "builtin", "-o", "."], "plans");
    (folder.join("plans/plan.json"), machine, folder.join("plans/print-00-part-0.gcode"))
}

#[test]
fn a_script_finds_its_plans_model_and_machine_from_any_folder() {
    let folder = folder();
    let (plan, machine, sliced) = kept_apart(folder.path());
    let elsewhere = folder.path().join("elsewhere");
    std::fs::create_dir(&elsewhere).unwrap();
    let file = elsewhere.join("x.gcode");
    let run = || {
        std::fs::copy(&sliced, &file).unwrap();
        let hook = ["rewrite", "--in-place", "--plan"];
        trunnion().current_dir(&elsewhere).args(hook).arg(&plan).arg(&file).output().unwrap()
    };
    let done = run();
    assert!(done.status.success(), "{}", said(&done));
    let whole = std::fs::read(&file).unwrap();
    // A machine's file that is gone: the plan keeps its values. All the same program.
    let text = std::fs::read_to_string(&machine).unwrap();
    std::fs::remove_file(&machine).unwrap();
    let done = run();
    assert!(done.status.success(), "{}", said(&done));
    assert_eq!(std::fs::read(&file).unwrap(), whole);
    // One that was changed since is another machine, and nothing printable is left.
    std::fs::write(&machine, text.replace("0.25", "0.2")).unwrap();
    let done = run();
    assert_eq!(done.status.code(), Some(2));
    assert!(said(&done).contains("plan again"), "{}", said(&done));
    assert_eq!(moves(&std::fs::read(&file).unwrap()), 0);
}

#[test]
fn a_mistake_in_the_pasted_line_leaves_nothing_printable() {
    let folder = folder();
    let (plan, _, sliced) = kept_apart(folder.path());
    let (plan, file) = (plan.display().to_string(), folder.path().join("x.gcode"));
    let lines: [&[&str]; 7] = [
        &["rewrite", "--in-place", "--plam", &plan],
        &["rewrite", "--inplace", "--plan", &plan],
        &["rewrite", "--in-plce", "--plan", &plan],
        &["rewrite", "--in-place", "--plan"],
        &["rewrite", "--in-place", "--plan", &plan, "--bed", "x"],
        &["rewrit", "--in-place", "--plan", &plan],
        &["rewrite", "--in-place", "--plan", "nowhere.json"],
    ];
    for words in lines {
        std::fs::copy(&sliced, &file).unwrap();
        let run = trunnion().args(words).arg(&file).output().unwrap();
        assert_eq!(run.status.code(), Some(2), "{words:?}: {}", said(&run));
        assert_eq!(moves(&std::fs::read(&file).unwrap()), 0, "{words:?}");
        assert!(std::fs::read_to_string(&file).unwrap().contains("not printable"), "{words:?}");
    }
    // Mistakes of other verbs, and without the flag, touch nothing; nor does a plan in the last place.
    let bytes = std::fs::read(&sliced).unwrap();
    for words in
        [&["verify", "--in-place"][..], &["rewrite", "--plam", &plan], &["slice", "--in-place", "--plam", &plan]]
    {
        std::fs::copy(&sliced, &file).unwrap();
        assert_eq!(trunnion().args(words).arg(&file).output().unwrap().status.code(), Some(2));
        assert_eq!(std::fs::read(&file).unwrap(), bytes, "{words:?}");
    }
    let kept = std::fs::read(&plan).unwrap();
    assert_eq!(trunnion().args(["rewrite", "--in-place", "--plam", &plan]).output().unwrap().status.code(), Some(2));
    assert_eq!(std::fs::read(&plan).unwrap(), kept);
}

#[test]
fn a_mistake_in_the_line_of_a_real_slicer_leaves_nothing_printable() {
    let folder = folder();
    let plan = planned(folder.path(), "cube");
    let hook = hook(&plan).replace("--plan", "--plam");
    if installed("prusa-slicer") {
        let output = folder.path().join("prusa.gcode");
        prusa(folder.path(), &output, &[&hook]);
        assert_eq!(moves(&std::fs::read(&output).unwrap_or_default()), 0);
    } else {
        skip("prusa-slicer is not installed (apt-get install prusa-slicer)");
    }
    if installed("slic3r") {
        let (output, config) = (folder.path().join("slic3r.gcode"), folder.path().join("slic3r.ini"));
        std::fs::write(&config, format!("{CONFIG}post_process = {hook}\n")).unwrap();
        let mut slicer = Command::new("slic3r");
        slicer.args(["--no-gui", "--dont-arrange", "--load"]).arg(&config);
        slicer.arg(folder.path().join("print-00-part-0.stl")).arg("-o").arg(&output).output().unwrap();
        assert_eq!(moves(&std::fs::read(&output).unwrap()), 0);
    } else {
        skip("slic3r is not installed (apt-get install slic3r)");
    }
}

#[test]
fn what_is_finished_is_left_as_it_is() {
    let folder = folder();
    let (plan, _, sliced) = kept_apart(folder.path());
    let file = folder.path().join("x.gcode");
    std::fs::copy(&sliced, &file).unwrap();
    let run = |plan: &Path| trunnion().args(["rewrite", "--in-place", "--plan"]).arg(plan).arg(&file).output().unwrap();
    assert!(run(&plan).status.success());
    let finished = std::fs::read(&file).unwrap();
    let again = run(&plan);
    assert!(again.status.success() && states(&said(&again), "x.gcode | already rewritten"), "{}", said(&again));
    assert_eq!(std::fs::read(&file).unwrap(), finished);
    // By another plan it is another program; it stays too.
    let other = planned(folder.path(), "cube");
    let again = run(&other);
    assert_eq!(again.status.code(), Some(2));
    assert!(fails(&said(&again), "job/other-plan: x.gcode"), "{}", said(&again));
    assert_eq!(std::fs::read(&file).unwrap(), finished);
    // Torn off it is no finished program, and cannot be one any more.
    std::fs::write(&file, &finished[..finished.len() / 2]).unwrap();
    assert_eq!(run(&plan).status.code(), Some(2));
    assert_eq!(moves(&std::fs::read(&file).unwrap()), 0);
}
