//! Supports of PrusaSlicer and of CuraEngine for a model, at one pitch and width, as files for the judge.
//!
//! Both keep the model where it stands (`--dont-arrange`, `center_object=false`), so that what they lay can be held against the surface
//! itself. Roofs, walls around, brims and first layers of other heights are off, wherever they can be: what is compared is what holds.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::judge::Ruler;
use crate::support::{Command, installed, said, skip};

/// A program's way to support, and how it is asked for.
pub(super) struct Rival {
    pub(super) name: &'static str,
    program: Program,
}

enum Program {
    /// Its style, and whether from the plate only.
    Prusa(&'static str, bool),
    /// Its structure.
    Cura(&'static str),
}

/// Those of the comparison: from the plate only, but for the one that says so.
pub(super) const ALL: [Rival; 5] = [
    Rival { name: "PrusaSlicer grid", program: Program::Prusa("grid", true) },
    Rival { name: "PrusaSlicer snug", program: Program::Prusa("snug", true) },
    Rival { name: "PrusaSlicer grid, on the part too", program: Program::Prusa("grid", false) },
    Rival { name: "Cura normal", program: Program::Cura("normal") },
    Rival { name: "Cura tree", program: Program::Cura("tree") },
];

/// The thickness of everybody's filament, mm.
pub(super) const FILAMENT_MM: f64 = 1.75;

/// What is installed of them; says aloud what is not.
pub(super) fn installed_ones() -> Vec<&'static Rival> {
    let (prusa, cura) = (installed("prusa-slicer"), definitions());
    if !prusa {
        skip("prusa-slicer is not installed: supports are not held against its own");
    }
    if cura.is_none() {
        skip("no CuraEngine with its definitions (CURA_ENGINE_SEARCH_PATH): supports are not held against its own");
    }
    let there = |rival: &&Rival| match rival.program {
        Program::Prusa(..) => prusa,
        Program::Cura(_) => cura.is_some(),
    };
    ALL.iter().filter(there).collect()
}

/// Where CuraEngine's settings are defined, if it is installed.
fn definitions() -> Option<PathBuf> {
    if !installed("CuraEngine") {
        return None;
    }
    let search = std::env::var("CURA_ENGINE_SEARCH_PATH").unwrap_or_default();
    let folders = search.split(':').chain(["/usr/share/cura/resources/definitions"]);
    let mut files = folders.map(|folder| Path::new(folder).join("fdmprinter.def.json"));
    files.find(|file| file.is_file())
}

impl Rival {
    /// What it makes of `model` (STL), and the seconds that it took.
    pub(super) fn sliced(&self, model: &Path, ruler: &Ruler) -> (String, f64) {
        let target = model.with_extension("rival.gcode");
        let mut command = match self.program {
            Program::Prusa(style, plate) => prusa(model, &target, (style, plate), ruler),
            Program::Cura(structure) => cura(model, &target, structure, ruler),
        };
        let start = Instant::now();
        let run = command.output().unwrap();
        let seconds = start.elapsed().as_secs_f64();
        assert!(run.status.success() && target.is_file(), "{}: {}", self.name, said(&run));
        let text = std::fs::read_to_string(&target).unwrap();
        std::fs::remove_file(target).unwrap();
        (text, seconds)
    }
}

fn prusa(model: &Path, target: &Path, (style, plate): (&str, bool), ruler: &Ruler) -> Command {
    let Ruler { pitch_mm, line_mm, layer_mm, overhang_deg } = ruler;
    let mut lines = vec![
        format!("layer_height = {layer_mm}\nfirst_layer_height = {layer_mm}\nnozzle_diameter = {line_mm}"),
        format!("filament_diameter = {FILAMENT_MM}\nsupport_material_contact_distance = {layer_mm}"),
        format!("support_material_spacing = {pitch_mm}\nsupport_material_threshold = {overhang_deg}"),
        format!("support_material_style = {style}\nsupport_material_buildplate_only = {}", u8::from(plate)),
        "support_material = 1\nsupport_material_auto = 1\nsupport_material_with_sheath = 0".to_owned(),
        "support_material_interface_layers = 0\nsupport_material_bottom_interface_layers = 0".to_owned(),
        "skirts = 0\nbrim_type = no_brim\nelefant_foot_compensation = 0\nstart_gcode =\nend_gcode =".to_owned(),
    ];
    let widths = ["", "first_layer_", "perimeter_", "infill_", "support_material_"];
    lines.extend(widths.map(|of| format!("{of}extrusion_width = {line_mm}")));
    let config = model.with_extension("rival.ini");
    std::fs::write(&config, lines.join("\n") + "\n").unwrap();
    let mut command = Command::new("prusa-slicer");
    command
        .args(["--loglevel", "1", "--dont-arrange", "--load"])
        .arg(config)
        .arg(model)
        .arg("-g")
        .arg("-o")
        .arg(target);
    command
}

fn cura(model: &Path, target: &Path, structure: &str, ruler: &Ruler) -> Command {
    let Ruler { pitch_mm, line_mm, layer_mm, overhang_deg } = ruler;
    // What its window works out of these, since the engine alone evaluates no formulas: a tree is a wall with nothing in it.
    let (walls, between_mm) = if structure == "tree" { (1, 0.0) } else { (0, *pitch_mm) };
    let mut settings = vec![
        format!("support_structure={structure}"),
        format!("support_wall_count={walls}"),
        format!("support_angle={overhang_deg}"),
    ];
    settings.extend(["support_enable=true", "support_type=buildplate", "support_brim_enable=false"].map(str::to_owned));
    settings.extend(["interface", "roof", "bottom"].map(|of| format!("support_{of}_enable=false")));
    settings.extend(["layer_height", "layer_height_0"].map(|of| format!("{of}={layer_mm}")));
    settings.extend(["support_z_distance", "support_top_distance"].map(|of| format!("{of}={layer_mm}")));
    settings.extend(["line_width", "support_line_width", "wall_line_width"].map(|of| format!("{of}={line_mm}")));
    let distances = ["support_line_distance", "support_initial_layer_line_distance"];
    settings.extend(distances.map(|of| format!("{of}={between_mm}")));
    let mut command = Command::new("CuraEngine");
    command.args(["slice", "-j"]).arg(definitions().expect("it was found"));
    let place = ["machine_center_is_zero=true", "center_object=false", "remove_empty_first_layers=false"];
    let whole = place.into_iter().chain(["adhesion_type=none"]).chain(settings.iter().map(String::as_str));
    whole.for_each(|setting| _ = command.args(["-s", setting]));
    // What is said before counts for the whole print, what is said behind an extruder for that alone.
    command.arg("-o").arg(target).arg("-e0").args(["-s", &format!("material_diameter={FILAMENT_MM}")]);
    settings.iter().for_each(|setting| _ = command.args(["-s", setting]));
    command.arg("-l").arg(model);
    command
}
