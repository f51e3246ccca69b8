//! What slicers do beside plain layers, each of which a user has set somewhere: the file they give is rewritten and found clean.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use crate::bad_input::stl;
use crate::pipeline::{fixture, prepare};
use crate::support::{every, folder, installed, python, said, skip, trunnion};

/// PrusaSlicer's keys over the profile's own.
const CONFIGURATIONS: [(&str, &str); 16] = [
    ("variable widths", "perimeter_generator = arachne"),
    ("outer walls first", "external_perimeters_first = 1"),
    ("ironing", "ironing = 1"),
    ("an elephant's foot compensated", "elefant_foot_compensation = 0.2"),
    ("0.1 mm wider", "xy_size_compensation = 0.1"),
    ("0.1 mm narrower", "xy_size_compensation = -0.1"),
    ("a raft", "raft_layers = 2"),
    ("wipes", "wipe = 1\nretract_before_wipe = 70%"),
    ("layers of 0.3 mm", "layer_height = 0.3\nfirst_layer_height = 0.3"),
    ("layers of 0.1 mm", "layer_height = 0.1\nfirst_layer_height = 0.2"),
    ("thin walls and filled gaps", "thin_walls = 1\ngap_fill_enabled = 1"),
    ("one wall", "perimeters = 1\nfill_density = 40%"),
    ("wide outer walls", "external_perimeter_extrusion_width = 0.6"),
    ("infill every second layer", "infill_every_layers = 2"),
    ("infill of round threads", "fill_pattern = 3dhoneycomb\nfill_density = 20%"),
    ("no tops", "top_solid_layers = 0"),
];

/// What is asked of a print and is not the slicer's to do here, or cannot be taken, with either program: keys, and what is said.
const ANSWERED: [(&str, bool, &str); 9] = [
    ("use_relative_e_distances = 0", true, ""),
    ("use_relative_e_distances = 1", true, ""),
    ("use_firmware_retraction = 1\nretract_lift = 0.4\nwipe = 1", true, ""),
    ("start_gcode = G28\\nG1 Z0.2 F1000\\nG1 X-60 Y-70 F5000\\nG1 X60 E10 F600", true, ""),
    ("skirts = 2\nskirt_distance = 3", true, "ignored settings of --slicer-config: skirts = 2; prints on other prints"),
    (
        "brim_width = 3\nraft_layers = 2",
        true,
        "ignored settings of --slicer-config: brim_width = 3, raft_layers = 2; prints",
    ),
    ("support_material = 1", true, "support_material = 1; prints on other prints or on a turning table"),
    ("use_volumetric_e = 1", false, "sliced with volumetric E (its E counts mm3 and not mm of filament)"),
    ("spiral_vase = 1", false, "sliced as a spiral (spiral vase)"),
];

/// Each is verified clean or refused for its true cause, and what is left out is said.
#[test]
fn what_is_not_taken_of_a_configuration_is_said() {
    for (index, slicer) in ["prusa-slicer", "slic3r"].into_iter().enumerate() {
        if !installed(slicer) {
            skip(&format!("{slicer} is not installed: what it is asked for is not tried"));
            continue;
        }
        let folder = folder();
        let (config, output) = (folder.path().join("user.ini"), folder.path().join("out.gcode"));
        let fuzzy = [("fuzzy_skin = external", false, "sliced with a fuzzy skin")];
        // Slic3r has none.
        let more = if slicer == "prusa-slicer" { &fuzzy[..] } else { &[] };
        // In the suite every second one, of the other slicer the others.
        for (keys, clean, words) in ANSWERED.iter().skip(index.min(every(2) - 1)).step_by(every(2)).chain(more) {
            std::fs::write(&config, format!("{keys}\n")).unwrap();
            let mut command = trunnion();
            command.args(["prepare", &fixture("two-boxes"), "-m", "generic-ac", "--slicer", slicer, "-o"]).arg(&output);
            let run = command.arg("--slicer-config").arg(&config).output().unwrap();
            let text = said(&run);
            // It marks what it lays around a print, which is kept.
            let words =
                if slicer == "prusa-slicer" { words.replace("brim_width = 3, ", "") } else { (*words).to_owned() };
            let words = if slicer == "prusa-slicer" && keys.starts_with("skirts") { String::new() } else { words };
            assert_eq!(run.status.code(), Some(if *clean { 0 } else { 2 }), "{slicer}, {keys}: {text}");
            assert!(text.contains(&words), "{slicer}, {keys}: {text}");
            assert!(
                !words.is_empty() || !text.contains("ignored settings of --slicer-config"),
                "{slicer}, {keys}: {text}"
            );
            assert_eq!(output.exists(), *clean, "{slicer}, {keys}");
            let _ = std::fs::remove_file(&output);
        }
    }
}

/// CuraEngine's keys: what is verified, what is said of it, and what is refused for its true cause.
const OF_CURA: [(&str, bool, &str); 14] = [
    (
        "adhesion_type = brim\nbrim_width = 4",
        true,
        "ignored settings of --slicer-config: adhesion_type = brim, brim_width = 4; prints on other prints",
    ),
    ("adhesion_type = raft", true, "adhesion_type = raft; prints on other prints"),
    (
        "support_enable = true\nsupport_type = everywhere",
        true,
        "support_enable = true; prints on other prints or on a turning table",
    ),
    ("prime_tower_enable = true", true, "prime_tower_enable = true; prints"),
    ("magic_spiralize = true", true, "magic_spiralize = true; prints"),
    ("adaptive_layer_height_enabled = true", true, "adaptive_layer_height_enabled = true; prints"),
    ("layer_height = 0.2\ninfill_sparse_thickness = 0.2", true, ""),
    ("infill_sparse_thickness = 0.4", true, "infill_sparse_thickness = 0.4; prints"),
    ("magic_fuzzy_skin_enabled = true", false, "sliced with a fuzzy skin"),
    ("ironing_enabled = true\ncoasting_enable = true\nwipe_enable = true", true, ""),
    ("layer_height = 0.28\nrelative_extrusion = false", true, "sliced with layers of 0.28 mm"),
    ("xy_offset = 0.1\nwall_0_inset = 0.05\nz_seam_type = random", true, ""),
    ("retraction_hop_enabled = true\nretraction_hop = 0.4\ncool_lift_head = true\ncool_min_layer_time = 15", true, ""),
    (
        "infill_pattern = zigzag\nbridge_settings_enabled = true\nacceleration_enabled = true\njerk_enabled = true",
        true,
        "",
    ),
];

#[test]
fn what_cura_engine_is_asked_for_is_verified_or_said() {
    if !crate::cura_engine::is_there() {
        return;
    }
    let folder = folder();
    let (config, output) = (folder.path().join("user.cfg"), folder.path().join("out.gcode"));
    for (keys, clean, words) in OF_CURA {
        std::fs::write(&config, format!("{keys}\n")).unwrap();
        let mut command = trunnion();
        command.args(["prepare", &fixture("two-boxes"), "-m", "generic-ac", "--slicer", "cura", "-o"]).arg(&output);
        let run = command.arg("--slicer-config").arg(&config).output().unwrap();
        let text = said(&run);
        assert_eq!((run.status.success(), output.exists()), (clean, clean), "{keys}: {text}");
        assert!(text.contains(words), "{keys}: {text}");
        assert_eq!(text.contains("ignored settings of --slicer-config"), words.contains("; prints"), "{keys}: {text}");
        let _ = std::fs::remove_file(&output);
    }
}

fn stays_clean(model: &str, configurations: &[(&str, &str)]) {
    if !installed("prusa-slicer") {
        return skip("prusa-slicer is not installed: its configurations are not tried");
    }
    let folder = folder();
    let (config, output) = (folder.path().join("user.ini"), folder.path().join("out.gcode"));
    for (name, keys) in configurations {
        std::fs::write(&config, keys).unwrap();
        let more = ["--slicer-config", &config.display().to_string()];
        let document = prepare(&fixture(model), "generic-ac", "prusa-slicer", &output, &more);
        assert_eq!(document["verify"]["findings"], serde_json::json!([]), "{model}, {name}");
    }
}

#[test]
fn of_prusa_slicer_on_a_print_turned_by_90_degrees() {
    stays_clean("two-boxes", &CONFIGURATIONS);
}

#[test]
fn of_prusa_slicer_on_prints_tilted_by_45_degrees() {
    stays_clean("y-tree", &CONFIGURATIONS[..6]);
}

/// A plan of `model` and its sliced prints in `folder`.
fn sliced(folder: &Path, model: &str, slicer: &str) {
    let path = |name: &str| folder.join(name).display().to_string();
    for args in [
        vec!["plan", model, "-m", "generic-ac", "-q", "-o", &path("plan.json")],
        vec!["slice", &path("plan.json"), "--slicer", slicer, "-q", "-o", &path("slots")],
    ] {
        let run = trunnion().args(&args).output().unwrap();
        assert!(run.status.success(), "{args:?}: {}", said(&run));
    }
}

/// `rewrite` of all prints, which verifies what it writes; the file.
fn rewritten(folder: &Path, prints: &[&str]) -> String {
    let output = folder.join("out.gcode");
    let prints = prints.iter().map(|name| folder.join("slots").join(name));
    let run = trunnion()
        .arg("rewrite")
        .args(prints)
        .arg("--plan")
        .arg(folder.join("plan.json"))
        .arg("-o")
        .arg(&output)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", said(&run));
    std::fs::read_to_string(output).unwrap()
}

/// Layers of 0.1 to 0.25 mm in one print, as a user draws them in PrusaSlicer's window: kept in the project's own file.
#[test]
fn adaptive_layers_stay_clean() {
    const PROFILE: &str = "import sys, zipfile
old, new = zipfile.ZipFile(sys.argv[1]), zipfile.ZipFile(sys.argv[2], 'w')
for name in old.namelist(): new.writestr(name, old.read(name))
new.writestr('Metadata/Slic3r_PE_layer_heights_profile.txt', 'object_id=1|0;0.2;4;0.2;6;0.1;12;0.1;16;0.25;20;0.25;30;0.15;60;0.15\\n')
new.close()
";
    let (true, Some(python)) = (installed("prusa-slicer"), python(&["python3"], "zipfile")) else {
        return skip("prusa-slicer or python3 is not installed: adaptive layers are not tried");
    };
    let folder = folder();
    sliced(folder.path(), &fixture("two-boxes"), "prusa-slicer");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let slice = path("slots/print-00-part-0.gcode");
    let prusa = |args: &[&str]| {
        // What was sliced before holds the whole configuration.
        let run = Command::new("prusa-slicer").args(["--load", &slice, "--dont-arrange"]).args(args).output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
    };
    prusa(&["--export-3mf", "-o", &path("a.3mf"), &path("slots/print-00-part-0.stl")]);
    let run = Command::new(python).args(["-c", PROFILE, &path("a.3mf"), &path("b.3mf")]).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    prusa(&["-g", "-o", &path("adaptive.gcode"), &path("b.3mf")]);
    std::fs::rename(path("adaptive.gcode"), &slice).unwrap();
    let gcode = rewritten(folder.path(), &["print-00-part-0.gcode", "print-01-part-1.gcode"]);
    let heights = |mm: f64| {
        let stated = gcode.lines().filter_map(|l| l.strip_prefix(";HEIGHT:")?.parse::<f64>().ok());
        stated.filter(|height| (height - mm).abs() < 0.005).count()
    };
    assert!(heights(0.1) > 10 && heights(0.25) > 10 && heights(0.15) > 10, "{}", heights(0.1));
}

/// A cylinder's walls as arcs, as slicers and tools behind them fit them.
#[test]
fn arcs_stay_clean() {
    let folder = folder();
    let model = folder.path().join("round.stl");
    std::fs::write(&model, stl(&cylinder(10.0, 8.0, 96))).unwrap();
    sliced(folder.path(), &model.display().to_string(), "builtin");
    let name = std::fs::read_dir(folder.path().join("slots")).unwrap().map(|f| f.unwrap().file_name());
    let name = name.map(|n| n.into_string().unwrap()).find(|n| n.ends_with(".gcode")).unwrap();
    let slice = folder.path().join("slots").join(&name);
    let (mut text, arcs) = with_arcs(&std::fs::read_to_string(&slice).unwrap());
    // The change is meant.
    text.truncate(text.rfind("; crc32 = ").unwrap());
    assert!(arcs > 60, "{arcs}");
    std::fs::write(&slice, text).unwrap();
    let gcode = rewritten(folder.path(), &[&name]);
    assert_eq!(gcode.lines().filter(|l| l.starts_with("G3 ") || l.starts_with("G2 ")).count(), arcs);
}

fn cylinder(radius: f32, height: f32, sides: u16) -> Vec<[[f32; 3]; 3]> {
    let at = |i: u16, z: f32| {
        let (sin, cos) = (std::f32::consts::TAU * f32::from(i % sides) / f32::from(sides)).sin_cos();
        [radius * cos, radius * sin, z]
    };
    let side = |i: u16| {
        let [a, b, c, d] = [at(i, 0.0), at(i + 1, 0.0), at(i + 1, height), at(i, height)];
        [[a, b, c], [a, c, d], [[0.0, 0.0, 0.0], b, a], [[0.0, 0.0, height], d, c]]
    };
    (0..sides).flat_map(side).collect()
}

/// The slice with each run of ten and more printed lines about the bed's middle as one arc, and how many there are.
fn with_arcs(text: &str) -> (String, usize) {
    const MIDDLE: [f64; 2] = [125.0, 125.0];
    let word = |line: &str, letter: char| line.split(' ').find_map(|w| w.strip_prefix(letter)?.parse::<f64>().ok());
    let (mut out, mut arcs, mut at) = (String::new(), 0, [0.0; 2]);
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        let next = |line: &str, at: [f64; 2]| [word(line, 'X').unwrap_or(at[0]), word(line, 'Y').unwrap_or(at[1])];
        let radius = |p: [f64; 2]| (p[0] - MIDDLE[0]).hypot(p[1] - MIDDLE[1]);
        let prints =
            |line: &str| line.starts_with("G1 ") && line.contains('E') && (line.contains('X') || line.contains('Y'));
        let start = at;
        // The chords of infill too end on a circle, but their middles lie inside it.
        let middle = |line: &str, at: [f64; 2]| [0, 1].map(|i| (at[i] + next(line, at)[i]) / 2.0);
        let round = |line: &str, at: [f64; 2]| {
            let off = |p: [f64; 2]| (radius(p) - radius(start)).abs();
            prints(line) && off(next(line, at)) < 2e-3 && off(middle(line, at)) < 0.01
        };
        if !round(line, at) || radius(at) < 2.0 {
            if line.starts_with('G') {
                at = next(line, at);
            }
            let _ = writeln!(out, "{line}");
            continue;
        }
        let (mut run, mut filament) = (vec![line], word(line, 'E').unwrap());
        at = next(line, at);
        // Half a turn at most: a full circle's ends would coincide.
        while run.len() < 40
            && let Some(line) = lines.next_if(|line| round(line, at))
        {
            (filament, at) = (filament + word(line, 'E').unwrap(), next(line, at));
            run.push(line);
        }
        if run.len() < 10 {
            run.iter().for_each(|line| writeln!(out, "{line}").unwrap());
            continue;
        }
        let (i, j) = (MIDDLE[0] - start[0], MIDDLE[1] - start[1]);
        let left = (start[0] - MIDDLE[0]) * (at[1] - MIDDLE[1]) - (start[1] - MIDDLE[1]) * (at[0] - MIDDLE[0]) > 0.0;
        let feed = run.iter().find_map(|line| word(line, 'F')).map_or_else(String::new, |f| format!(" F{f}"));
        let _ = writeln!(
            out,
            "{} X{:.3} Y{:.3} I{i:.3} J{j:.3} E{filament:.5}{feed}",
            if left { "G3" } else { "G2" },
            at[0],
            at[1]
        );
        arcs += 1;
    }
    (out, arcs)
}
