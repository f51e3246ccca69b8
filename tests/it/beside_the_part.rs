//! What slicers lay beside a part, or mean to: skirts, brims, prime lines, towers, supports. Kept where it does no harm, else refused
//! for what it is.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::own_settings::{cube, files, planned, rewrite};
use crate::support::{every, folder, installed, said, skip, states, trunnion};

/// What anybody has in his PrusaSlicer.
const PRUSA: &str = "\
nozzle_diameter = 0.4
filament_diameter = 1.75
layer_height = 0.2
first_layer_height = 0.2
elefant_foot_compensation = 0
gcode_flavor = marlin
use_relative_e_distances = 1
layer_gcode = G92 E0
gcode_label_objects = 1
temperature = 205
first_layer_temperature = 205
skirts = 0
brim_width = 0
brim_type = no_brim
";

/// Every mesh of `folder` sliced by PrusaSlicer with `more` lines of configuration.
pub(crate) fn prusa(folder: &Path, more: &str) -> Vec<PathBuf> {
    let config = folder.join("mine.ini");
    // PrusaSlicer refuses a key that is given twice.
    let lines = PRUSA.lines().chain(more.lines());
    let keys: BTreeMap<&str, &str> = lines.filter_map(|line| line.split_once(" = ")).collect();
    let text: String = keys.iter().map(|(key, value)| format!("{key} = {value}\n")).collect();
    std::fs::write(&config, text).unwrap();
    let slice = |mesh: &PathBuf| {
        let output = mesh.with_extension("gcode");
        let mut command = Command::new("prusa-slicer");
        command.arg("--load").arg(&config).args(["--dont-arrange", "-g"]).arg(mesh).arg("-o").arg(&output);
        let run = command.output().unwrap();
        assert!(run.status.success() && output.is_file(), "{more}: {}", said(&run));
        output
    };
    files(folder, ".stl").iter().map(slice).collect()
}

fn there() -> bool {
    let there = installed("prusa-slicer");
    if !there {
        skip("prusa-slicer is not installed (apt-get install prusa-slicer): skirts and brims are not tried");
    }
    there
}

#[test]
fn skirt_brim_and_prime_line_of_what_is_printed_first_on_the_table_are_kept_or_told() {
    if !there() {
        return;
    }
    let folder = folder();
    let plan = planned(folder.path(), "cube");
    for (name, more, kept) in [
        ("skirt", "skirts = 2\nskirt_distance = 6\n", true),
        ("brim", "brim_type = outer_only\nbrim_width = 4\n", true),
        ("both", "skirts = 1\nskirt_distance = 3\nbrim_type = outer_only\nbrim_width = 3\n", true),
        ("prime line", "start_gcode = G28\\nG1 Z0.3 F3000\\nG1 X0 Y-3\\nG92 E0\\nG1 X60 E9 F1000\\nG92 E0\n", false),
    ] {
        let sliced = prusa(folder.path(), more);
        // On another bed, where the part does not stand in the middle.
        let run = rewrite(&sliced, &plan, &["--bed", "180x160"]);
        assert!(run.status.success() && states(&said(&run), "moved | slicer"), "{name}: {}", said(&run));
        let run = rewrite(&sliced, &plan, &[]);
        assert!(run.status.success(), "{name}: {}", said(&run));
        let text = std::fs::read_to_string(folder.path().join("out.gcode")).unwrap();
        assert_eq!(text.contains(";TYPE:Skirt"), kept, "{name}");
        assert_eq!(said(&run).contains("a prime line"), !kept, "{name}: {}", said(&run));
        if kept {
            // Held as strictly as any line: not in the air, not in the part, not off the table.
            let lines: Vec<&str> = text.lines().collect();
            let first = lines.iter().position(|l| l.starts_with(";TYPE:Skirt")).unwrap();
            let at = first + lines[first..].iter().position(|l| l.starts_with("G1 X") && l.contains(" E")).unwrap();
            for (change, why) in [("G1 X0 Y0 ", "from the outline of part 0"), ("G1 X150 Y0 ", "leaves the table")] {
                let e = lines[at].rsplit(" E").next().unwrap();
                let mut changed = lines.clone();
                let line = format!("{change}E{e}");
                changed[at] = &line;
                let file = folder.path().join("changed.gcode");
                std::fs::write(&file, changed.join("\n") + "\n").unwrap();
                let run = trunnion().arg("verify").arg(&file).arg("--plan").arg(&plan).output().unwrap();
                assert!(run.status.code() == Some(1) && said(&run).contains(why), "{name}, {change}: {}", said(&run));
            }
        }
    }
}

#[test]
fn what_the_plan_has_no_room_for_is_refused_for_what_it_is() {
    if !there() {
        return;
    }
    let folder = folder();
    let plan = planned(folder.path(), "two-boxes");
    for (more, why) in [
        (
            "skirts = 1\nskirt_distance = 4\n",
            "for print 1 (part 1), which is not printed first on the table; switch it off",
        ),
        ("brim_type = outer_only\nbrim_width = 4\n", "for print 1 (part 1), which is not printed first on the table"),
        (
            "skirts = 1\nskirt_height = 3\nskirt_distance = 4\n",
            "a skirt or brim of more than one layer, or a draft shield",
        ),
        ("skirts = 1\ndraft_shield = enabled\nskirt_distance = 4\n", "or a draft shield"),
        ("raft_layers = 2\n", "supports or a raft, which the plan does not allow for"),
        ("spiral_vase = 1\nperimeters = 1\nfill_density = 0\ntop_solid_layers = 0\n", "sliced as a spiral"),
        ("use_relative_e_distances = 0\nlayer_gcode = \nuse_volumetric_e = 1\n", "volumetric E"),
    ] {
        let sliced = prusa(folder.path(), more);
        let run = rewrite(&sliced, &plan, &[]);
        assert!(run.status.code() == Some(2) && said(&run).contains(why), "{more}: {}", said(&run));
        assert!(!folder.path().join("out.gcode").exists());
    }
}

/// The real program with what people switch on, at three heights.
#[test]
fn realistic_configurations_are_clean_at_every_layer_height() {
    if !there() {
        return;
    }
    let folder = folder();
    let plan = planned(folder.path(), "two-boxes");
    for height in ["0.1", "0.2", "0.3"].into_iter().step_by(every(2)) {
        for (name, more) in [
            ("absolute E", "use_relative_e_distances = 0\nlayer_gcode = \n"),
            ("wipes, ironing, wide first layer", "wipe = 1\nironing = 1\nfirst_layer_extrusion_width = 0.5\n"),
            ("lifts, arachne", "retract_lift = 0.4\nperimeter_generator = arachne\n"),
            ("firmware retraction, no comments", "use_firmware_retraction = 1\ngcode_comments = 0\n"),
        ] {
            let sliced =
                prusa(folder.path(), &format!("layer_height = {height}\nfirst_layer_height = {height}\n{more}"));
            let run = rewrite(&sliced, &plan, &[]);
            assert!(run.status.success(), "{name} at {height}: {}", said(&run));
        }
    }
}

/// RepRapFirmware's own words, as PrusaSlicer writes them for it.
#[test]
fn the_flavour_of_reprapfirmware_is_understood() {
    if !there() {
        return;
    }
    let folder = folder();
    let plan = folder.path().join("plan.json");
    let model = crate::pipeline::fixture("cube");
    let (plan_text, place) = (plan.display().to_string(), folder.path().display().to_string());
    for args in [
        vec!["plan", &model, "-m", "open5x-prusa", "-q", "-o", &plan_text],
        vec!["slice", &plan_text, "--meshes-only", "-q", "-o", &place],
    ] {
        let run = trunnion().args(&args).output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
    }
    let words = "gcode_flavor = reprapfirmware\nstart_gcode = M568 P0 S205 R140\\nM116\\nM98 P\"start.g\"\nmachine_max_jerk_x = 8\n\
                 machine_limits_usage = emit_to_gcode\nfirst_layer_temperature = 210\n";
    let sliced = prusa(folder.path(), words);
    let text = std::fs::read_to_string(&sliced[0]).unwrap();
    assert!(text.contains("\nM566 ") && text.contains("\nM568 "), "PrusaSlicer writes other words: {}", &text[..2000]);
    let run = rewrite(&sliced, &plan, &[]);
    assert!(run.status.success(), "{}", said(&run));
}

#[test]
fn a_pause_for_a_person_is_made_above_the_part() {
    let folder = folder();
    let (plan, text) = cube(folder.path());
    let file = folder.path().join("print-00-paused.gcode");
    for pause in ["M600", "M0 Insert the nut", "M601"] {
        let sixth = text.match_indices("\n;LAYER_CHANGE").nth(5).unwrap().0 + 1;
        std::fs::write(&file, format!("{}{pause}\n{}", &text[..sixth], &text[sixth..])).unwrap();
        let run = rewrite(std::slice::from_ref(&file), &plan, &[]);
        assert!(run.status.success() && said(&run).contains("1 user pause"), "{pause}: {}", said(&run));
        let out = std::fs::read_to_string(folder.path().join("out.gcode")).unwrap();
        let lines: Vec<&str> = out.lines().collect();
        let at = lines.iter().position(|line| *line == pause).unwrap();
        // Pulled back, up, waited, down, pushed: five layers of 0.2 mm stand, and 5 mm of room are the profile's.
        let number = |line: &str, letter: &str| {
            line.split(letter).nth(1).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap()
        };
        assert_eq!(number(lines[at - 2], "E"), -2.0, "{:?}", &lines[at - 3..at + 4]);
        assert!(number(lines[at - 1], "Z") >= 6.0, "{:?}", &lines[at - 3..at + 4]);
        assert!(number(lines[at + 1], "Z") <= 1.2, "{:?}", &lines[at - 3..at + 4]);
        assert_eq!(number(lines[at + 2], "E"), 2.0, "{:?}", &lines[at - 3..at + 4]);
        // Not so high, or with the filament in the nozzle, it is a finding.
        for (line, other) in [(at - 1, "G1 Z5.9 F900"), (at - 2, "G1 E-.5 F2100")] {
            let mut changed = lines.clone();
            changed[line] = other;
            let path = folder.path().join("changed.gcode");
            std::fs::write(&path, changed.join("\n") + "\n").unwrap();
            let run = trunnion().arg("verify").arg(&path).arg("--plan").arg(&plan).output().unwrap();
            let wanted = run.status.code() == Some(1) && states(&said(&run), "waits | person");
            assert!(wanted, "{pause}, {other}: {}", said(&run));
        }
    }
}
