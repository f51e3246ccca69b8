//! CuraEngine in the loop, where it is installed with the definitions of its settings.

use crate::own_settings::{files, planned, rewrite};
use crate::pipeline::{fixture, prepare};
use crate::support::{fails, folder, installed, said, skip, states, trunnion};

/// Whether it starts and finds what its settings are; says aloud what is missing.
pub(crate) fn is_there() -> bool {
    if !installed("CuraEngine") {
        skip(
            "CuraEngine is not installed (apt-get install cura-engine; its definitions: CURA_ENGINE_SEARCH_PATH, or the package cura)",
        );
        return false;
    }
    let folder = folder();
    let output = folder.path().join("x.gcode");
    let mut command = trunnion();
    command.args(["prepare", &fixture("cube"), "-m", "generic-ac", "--slicer", "cura", "-q", "-o"]);
    let run = command.arg(output).output().unwrap();
    if said(&run).contains("fdmprinter.def.json") {
        skip(
            "CuraEngine's definitions are not there (CURA_ENGINE_SEARCH_PATH=RESOURCES/definitions:RESOURCES/extruders)",
        );
        return false;
    }
    true
}

#[test]
fn its_prints_are_clean_at_every_layer_height() {
    if !is_there() {
        return;
    }
    let folder = folder();
    let (config, output) = (folder.path().join("mine.cfg"), folder.path().join("out.gcode"));
    let config_text = config.display().to_string();
    for height in ["0.1", "0.2", "0.3"] {
        std::fs::write(&config, format!("layer_height = {height}\nwall_line_count = 3\nadhesion_type = skirt\n"))
            .unwrap();
        for model in ["cube", "two-boxes", "y-tree"] {
            let document = prepare(&fixture(model), "generic-ac", "cura", &output, &["--slicer-config", &config_text]);
            assert_eq!(document["verify"]["findings"], serde_json::json!([]), "{model} at {height}");
            assert_eq!(document["slicer"]["name"], "CuraEngine");
            let warned = states(&document["warnings"].to_string(), "--slicer-config | adhesion_type = skirt");
            assert!(warned, "{}", document["warnings"]);
        }
    }
}

/// Layer heights that the machine's profile has, and no configuration: from 5.0 on skins and infill too have lines of all widths.
#[test]
fn a_profile_of_thick_layers_is_clean() {
    if !is_there() {
        return;
    }
    let folder = folder();
    for height in ["0.1", "0.25", "0.3"] {
        let machine = folder.path().join("machine.toml");
        std::fs::write(&machine, format!("extends = \"generic-ac\"\n[process]\nlayer_height_mm = {height}\n")).unwrap();
        let output = folder.path().join("out.gcode");
        let document = prepare(&fixture("y-tree"), machine.to_str().unwrap(), "cura", &output, &[]);
        assert_eq!(document["verify"]["findings"], serde_json::json!([]), "{height}");
    }
}

/// One line of a wall with more or less filament, whose width the file does not say: a line's, or from 5.0 on what it has room for.
#[test]
fn a_wall_with_too_much_or_too_little_filament_is_seen() {
    if !is_there() {
        return;
    }
    let folder = folder();
    let (file, plan) = (folder.path().join("out.gcode"), folder.path().join("plan.json"));
    prepare(&fixture("two-boxes"), "generic-ac", "cura", &file, &["--plan-out", &plan.display().to_string()]);
    let text = std::fs::read_to_string(&file).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    // A line of a wall of some 20 mm, above the first layers: as much filament as one of the profile's width holds.
    let wall = (0..lines.len()).filter(|&at| lines[at] == ";TYPE:WALL-OUTER").nth(10).unwrap();
    let lays = |line: &str| line.starts_with("G1 ") && line.contains(" E") && !line.contains(" E-");
    let at = (wall + 1..).find(|&at| lays(lines[at])).unwrap();
    assert!(!lines[wall + 1..at].iter().any(|line| line.starts_with(";TYPE:")), "line {at}");
    let (head, tail) = lines[at].split_once(" E").unwrap();
    let (e, rest) = tail.split_once(' ').map_or((tail, ""), |(e, rest)| (e, rest));
    let e: f64 = e.parse().unwrap();
    let varied = text.contains(" bead=varied");
    // A round thread as thick as the nozzle is wide takes 1.4 of a line of 0.45 by 0.2 mm, and 1.15 of that passes.
    // From 5.0 on its next line is a width away: 1.4 of a line is 0.2 of a width on that.
    let most = if varied { 1.4 } else { 1.61 };
    // And half of one is less than walls that share their place leave.
    for share in [0.0001, 0.02, 0.1, 0.3, 0.45, 0.55, 0.9, 1.0, 1.1, 1.25, 1.5, 1.7, 1.9, 2.1, 4.0] {
        let mut changed = lines.clone();
        let line = format!("{head} E{:.5} {rest}", e * share);
        changed[at] = line.trim_end();
        std::fs::write(&file, changed.join("\n") + "\n").unwrap();
        let run = trunnion().arg("verify").arg(&file).arg("--plan").arg(&plan).arg("--json").output().unwrap();
        let report: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
        let findings = report["findings"].as_array().unwrap();
        let seen = findings.iter().any(|finding| finding["rule"] == "flow" && finding["line"] == at + 1);
        assert_eq!(seen, !(0.5..most).contains(&share), "{share} (varied: {varied}): {findings:?}");
    }
}

/// As somebody slices who knows nothing of us: its own start code, absolute E, a first layer of its own.
#[test]
fn what_it_gives_to_others_is_clean_or_refused_for_the_true_cause() {
    if !is_there() {
        return;
    }
    let folder = folder();
    let plan = planned(folder.path(), "two-boxes");
    let sliced = |settings: &[&str]| {
        for mesh in files(folder.path(), ".stl") {
            let mut engine = std::process::Command::new("CuraEngine");
            let search = std::env::var("CURA_ENGINE_SEARCH_PATH").unwrap_or_default();
            let folders = search.split(':').chain(["/usr/share/cura/resources/definitions"]);
            let mut definitions = folders.map(|f| std::path::Path::new(f).join("fdmprinter.def.json"));
            engine.args(["slice", "-j"]).arg(definitions.find(|path| path.is_file()).unwrap());
            for setting in
                ["machine_center_is_zero=true", "center_object=false", "adhesion_type=none"].iter().chain(settings)
            {
                engine.args(["-s", setting]);
            }
            engine.arg("-o").arg(mesh.with_extension("gcode")).args(["-e0", "-s", "material_diameter=1.75"]);
            settings.iter().for_each(|setting| _ = engine.args(["-s", setting]));
            let run = engine.arg("-l").arg(&mesh).output().unwrap();
            assert!(run.status.success(), "{}", said(&run));
        }
        files(folder.path(), ".gcode").into_iter().filter(|f| !f.ends_with("out.gcode")).collect::<Vec<_>>()
    };
    let widths = [
        "line_width=0.45",
        "wall_line_width_0=0.45",
        "wall_line_width_x=0.45",
        "skin_line_width=0.45",
        "infill_line_width=0.45",
    ];
    for [layer, first] in [["layer_height=0.28", "layer_height_0=0.28"], ["layer_height=0.2", "layer_height_0=0.3"]] {
        let run = rewrite(&sliced(&[&widths[..], &[layer, first]].concat()), &plan, &[]);
        assert!(run.status.success(), "{layer} {first}: {}", said(&run));
    }
    // Lines of 0.4 mm, which the file does not say.
    let run = rewrite(&sliced(&["layer_height=0.2", "layer_height_0=0.2"]), &plan, &[]);
    assert!(states(&said(&run), "width | process.line_width_mm | 0.45 mm"), "{}", said(&run));
    let run = rewrite(&sliced(&["layer_height=0.2", "layer_height_0=0.2", "magic_spiralize=true"]), &plan, &[]);
    assert!(fails(&said(&run), "sliced/spiral"), "{}", said(&run));
}
