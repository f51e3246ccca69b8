//! CuraEngine in the loop, where it is installed with the definitions of its settings.

use crate::own_settings::{files, planned, rewrite};
use crate::pipeline::{fixture, prepare};
use crate::support::{folder, installed, said, skip, trunnion};

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
            let warned = document["warnings"]
                .to_string()
                .contains("not as in --slicer-config: adhesion_type = skirt; each print");
            assert!(warned, "{}", document["warnings"]);
        }
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
    assert!(
        said(&run).contains("which the file does not state and process.line_width_mm says is 0.45 mm"),
        "{}",
        said(&run)
    );
    let run = rewrite(&sliced(&["layer_height=0.2", "layer_height_0=0.2", "magic_spiralize=true"]), &plan, &[]);
    assert!(said(&run).contains("sliced as a spiral"), "{}", said(&run));
}
