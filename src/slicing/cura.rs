//! CuraEngine: its command line, its settings, its version. Measured with 4.13.0.
//!
//! The engine evaluates no formulas: a width is not taken over from the width that it is derived from in Cura's window, so each is
//! given. What stands behind `-e0` is the extruder's, what stands before is for all; most settings are asked of either, and each
//! goes to both.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;

use super::config::ini_values;
use super::{Adhesion, InfillPattern, SliceJob, SliceSettings};

/// The definition of all settings and their defaults.
pub(super) const DEFINITION: &str = "fdmprinter.def.json";

/// Where distributions and installers keep Cura's resources, seen from the program's own folder.
pub(super) const RESOURCES: [&str; 6] = [
    "../share/cura/resources",
    "../share/cura",
    "../../share/cura/resources",
    "share/cura/resources",
    "resources",
    "../Resources/share/cura/resources",
];

type Values = BTreeMap<String, String>;

/// The version in what `--help` prints, for instance `4.13.0`; `None` if this is not CuraEngine.
pub(super) fn version(help: &str) -> Option<String> {
    let rest = help.split("Cura_SteamEngine version ").nth(1)?;
    let version: String = rest.chars().take_while(|c| c.is_ascii_alphanumeric() || "._-+".contains(*c)).collect();
    (!version.is_empty()).then_some(version)
}

/// The settings, the user's own over ours, and over those what he must not change.
pub(super) fn values(s: &SliceSettings, configs: &[String], job: &SliceJob) -> Values {
    let mut all = base(s);
    configs.iter().for_each(|text| all.extend(ini_values(text)));
    let layer = all.get("layer_height").cloned().unwrap_or_default();
    all.extend(forced(&layer, &all, job));
    all
}

fn base(s: &SliceSettings) -> Values {
    let width = s.line_width_mm;
    // Lines of one direction a layer, as far apart as the share of infill makes them; 0 is none.
    let apart = if s.infill > 0.0 { width / s.infill } else { 0.0 };
    let widths = ["line_width", "wall_line_width", "wall_line_width_0", "wall_line_width_x", "skin_line_width"];
    let more = ["infill_line_width", "skirt_brim_line_width"];
    let speeds = [
        ("speed_wall_0", s.outer_wall_mm_per_s),
        ("speed_wall", s.inner_wall_mm_per_s),
        ("speed_wall_x", s.inner_wall_mm_per_s),
        ("speed_print", s.infill_mm_per_s),
        ("speed_infill", s.infill_mm_per_s),
        ("speed_topbottom", s.infill_mm_per_s),
        ("speed_roofing", s.infill_mm_per_s),
        ("speed_travel", s.travel_mm_per_s),
        ("speed_travel_layer_0", s.travel_mm_per_s),
        ("speed_print_layer_0", s.first_layer_mm_per_s),
        ("speed_layer_0", s.first_layer_mm_per_s),
        ("bridge_wall_speed", s.bridge_mm_per_s),
        ("bridge_skin_speed", s.bridge_mm_per_s),
        ("cool_min_speed", s.slowest_mm_per_s),
    ];
    let numbers = [
        ("machine_nozzle_size", s.nozzle_mm),
        ("material_diameter", s.filament_mm),
        ("layer_height", s.layer_height_mm),
        ("wall_line_count", f64::from(s.walls)),
        ("bottom_layers", f64::from(s.bottom_layers)),
        ("initial_bottom_layers", f64::from(s.bottom_layers)),
        ("top_layers", f64::from(s.top_layers)),
        ("infill_line_distance", apart),
        ("cool_min_layer_time", s.min_layer_s),
        ("cool_fan_speed", s.fan * 100.0),
        ("cool_fan_speed_min", s.fan * 100.0),
        ("cool_fan_speed_max", s.fan * 100.0),
        ("retraction_amount", s.retract_mm),
        ("retraction_retract_speed", s.retract_mm_per_s),
        ("retraction_prime_speed", s.retract_mm_per_s),
        ("retraction_min_travel", s.retract_from_mm),
        ("material_print_temperature", s.nozzle_c),
        ("default_material_print_temperature", s.nozzle_c),
        ("material_bed_temperature", s.bed_c),
        ("minimum_skin_area", 0.0),
    ];
    let pattern = match s.infill_pattern {
        InfillPattern::Lines => "lines",
        InfillPattern::Cubic => "cubic",
    };
    let first = if s.infill_first { "true" } else { "false" };
    let words = [
        ("infill_pattern", pattern),
        ("infill_before_walls", first),
        ("retraction_enable", "true"),
        ("relative_extrusion", "true"),
    ];
    let all = widths.iter().chain(&more).map(|key| (*key, width)).chain(speeds).chain(numbers);
    let text = all.map(|(key, value)| (key.to_owned(), value.to_string()));
    text.chain(words.map(|(key, value)| (key.to_owned(), value.to_owned()))).collect()
}

/// What the user's configuration must not change: the first layer is like the others but for its speed on the table, the part stays
/// where it is, and start code, skirts and supports are the rewriter's.
fn forced(layer: &str, chosen: &Values, job: &SliceJob) -> Values {
    let nozzle = chosen.get("material_print_temperature").cloned().unwrap_or_default();
    let bed = chosen.get("material_bed_temperature").cloned().unwrap_or_default();
    let fan = chosen.get("cool_fan_speed").cloned().unwrap_or_default();
    let side = |mm: f64| (2.0 * mm).to_string();
    let [x, y] = job.bed_mm;
    let mut all: Values = [
        ("machine_center_is_zero", "true"),
        ("center_object", "false"),
        ("remove_empty_first_layers", "false"),
        ("support_enable", "false"),
        ("prime_tower_enable", "false"),
        ("prime_blob_enable", "false"),
        ("layer_height_0", layer),
        ("infill_sparse_thickness", layer),
        ("initial_layer_line_width_factor", "100"),
        ("material_flow_layer_0", "100"),
        ("xy_offset_layer_0", "0"),
        ("material_print_temperature_layer_0", &nozzle),
        ("material_initial_print_temperature", &nozzle),
        ("material_final_print_temperature", &nozzle),
        ("material_bed_temperature_layer_0", &bed),
        ("machine_start_gcode", ""),
        ("machine_end_gcode", ""),
        ("material_print_temp_prepend", "false"),
        ("material_bed_temp_prepend", "false"),
        ("machine_nozzle_temp_enabled", "false"),
        ("machine_gcode_flavor", "RepRap (Marlin/Sprinter)"),
        ("machine_firmware_retract", "false"),
        ("magic_spiralize", "false"),
        ("adaptive_layer_height_enabled", "false"),
        ("layer_start_x", "0"),
        ("machine_height", "2000"),
    ]
    .map(|(key, value)| (key.to_owned(), value.to_owned()))
    .into();
    all.extend([("machine_width".to_owned(), side(x)), ("machine_depth".to_owned(), side(y))]);
    all.extend(around(&job.adhesion, chosen));
    if !job.on_table {
        let speed = chosen.get("speed_print").cloned().unwrap_or_default();
        let like_others = [
            ("speed_print_layer_0", speed.clone()),
            ("speed_layer_0", speed),
            ("speed_slowdown_layers", "0".to_owned()),
            ("cool_fan_speed_0", fan),
            ("cool_fan_full_layer", "0".to_owned()),
        ];
        all.extend(like_others.map(|(key, value)| (key.to_owned(), value)));
    }
    all
}

/// Brim or loops, of which the engine lays one kind; it counts lines where its window knows widths.
fn around(adhesion: &Adhesion, chosen: &Values) -> Values {
    let width = chosen.get("skirt_brim_line_width").and_then(|text| text.parse::<f64>().ok());
    let lines = width.filter(|w| *w > 0.0).map_or(0.0, |width| (adhesion.brim_mm / width).floor());
    let kind = if lines > 0.0 {
        "brim"
    } else if adhesion.skirt_loops > 0 {
        "skirt"
    } else {
        "none"
    };
    let numbers = [
        ("brim_line_count", lines),
        ("brim_width", adhesion.brim_mm),
        ("skirt_line_count", f64::from(adhesion.skirt_loops)),
        ("skirt_gap", adhesion.skirt_distance_mm),
        ("skirt_brim_minimal_length", 0.0),
    ];
    let words = [("adhesion_type", kind), ("brim_outside_only", "true")].map(|(key, value)| (key, value.to_owned()));
    let numbers = numbers.map(|(key, value)| (key, value.to_string()));
    words.into_iter().chain(numbers).map(|(key, value)| (key.to_owned(), value)).collect()
}

/// The command line.
pub(super) fn arguments(values: &Values, definition: &Path, mesh: &Path, output: &Path) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = vec!["slice".into(), "-j".into(), definition.into()];
    let settings = || values.iter().flat_map(|(key, value)| ["-s".into(), OsString::from(format!("{key}={value}"))]);
    arguments.extend(settings());
    arguments.extend(["-o".into(), output.into(), "-e0".into()]);
    arguments.extend(settings());
    arguments.extend(["-l".into(), mesh.into()]);
    arguments
}

/// What Cura's window would write behind the file, and the engine does not: the settings that a reader holds it against.
pub(super) fn block(values: &Values) -> String {
    let names = [
        ("filament_diameter", "material_diameter"),
        ("first_layer_height", "layer_height_0"),
        ("layer_height", "layer_height"),
        ("nozzle_diameter", "machine_nozzle_size"),
        ("xy_size_compensation", "xy_offset"),
        ("temperature", "material_print_temperature"),
        ("bed_temperature", "material_bed_temperature"),
        ("fuzzy_skin", "magic_fuzzy_skin_enabled"),
        ("perimeters", "wall_line_count"),
        ("top_solid_layers", "top_layers"),
        ("bottom_solid_layers", "bottom_layers"),
    ];
    let line = |(name, key): (&str, &str)| Some(format!("; {name} = {}\n", values.get(key)?));
    let number = |key: &str| values.get(key)?.parse::<f64>().ok();
    let share =
        number("infill_line_distance").zip(number("infill_line_width")).map(|(apart, width)| match apart > 0.0 {
            true => (100.0 * width / apart).round().max(1.0),
            false => 0.0,
        });
    let share = share.map(|share| format!("; fill_density = {share}%\n"));
    names.into_iter().filter_map(line).chain(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_is_found_in_the_help_text() {
        let help = "\nCura_SteamEngine version 4.13.0\nCopyright (C) 2021 Ultimaker\n";
        assert_eq!(version(help).as_deref(), Some("4.13.0"));
        assert_eq!(version("PrusaSlicer-2.5.0 based on Slic3r"), None);
    }

    #[test]
    fn the_users_settings_count_but_for_where_the_part_is() {
        let job = SliceJob { name: "x".into(), on_table: false, bed_mm: [250.0, 200.0], adhesion: Adhesion::default() };
        let mine = ["layer_height = 0.28\nwall_line_count = 5\nadhesion_type = brim\n".to_owned()];
        let got = values(&SliceSettings::default(), &mine, &job);
        assert_eq!((got["layer_height"].as_str(), got["layer_height_0"].as_str()), ("0.28", "0.28"));
        assert_eq!((got["wall_line_count"].as_str(), got["adhesion_type"].as_str()), ("5", "none"));
        assert_eq!(got["speed_layer_0"], got["speed_print"]);
        assert_eq!(got["machine_depth"], "400");
        let on_table = values(&SliceSettings::default(), &[], &SliceJob { on_table: true, ..job });
        assert_eq!(on_table["speed_layer_0"], "20");
        assert!(block(&got).contains("; layer_height = 0.28\n"));
        let arguments = arguments(&got, Path::new("d.json"), Path::new("m.stl"), Path::new("o.gcode"));
        let at = |word: &str| arguments.iter().position(|a| a == word).unwrap();
        // A global diameter is overridden by the extruder's default.
        assert!(arguments[at("-e0")..].iter().any(|a| a == "material_diameter=1.75"));
        assert!(at("-e0") < at("-l"));
    }
}
