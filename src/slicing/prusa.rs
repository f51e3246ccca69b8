//! PrusaSlicer: its configuration, its command line, its version. Measured with 2.5.0.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;

use super::{InfillPattern, SliceJob, SliceSettings};

/// Keys and values of a configuration; each key once, for both programs refuse a key given twice.
pub(super) type Values = BTreeMap<&'static str, String>;

/// The version in what `--help` prints, for instance `2.5.0`; `None` if this is not PrusaSlicer.
pub(super) fn version(help: &str) -> Option<String> {
    let rest = help.split("PrusaSlicer-").nth(1)?;
    let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
    (end > 0).then(|| rest[..end].to_owned())
}

/// The configuration that lies under the user's own.
pub(super) fn base(s: &SliceSettings) -> Values {
    let mut values = common_base(s);
    values.extend([("gcode_flavor", "marlin".to_owned()), ("thumbnails", String::new())]);
    values
}

/// The settings under the names that PrusaSlicer and Slic3r share.
pub(super) fn common_base(s: &SliceSettings) -> Values {
    let percent = |share: f64| format!("{}%", share * 100.0);
    let pattern = match s.infill_pattern {
        InfillPattern::Lines => "rectilinear",
        InfillPattern::Cubic => "cubic",
    };
    let fan = (s.fan * 100.0).round().to_string();
    [
        ("nozzle_diameter", s.nozzle_mm.to_string()),
        ("filament_diameter", s.filament_mm.to_string()),
        ("layer_height", s.layer_height_mm.to_string()),
        ("extrusion_width", s.line_width_mm.to_string()),
        ("external_perimeter_extrusion_width", s.line_width_mm.to_string()),
        ("perimeter_extrusion_width", s.line_width_mm.to_string()),
        ("infill_extrusion_width", s.line_width_mm.to_string()),
        ("solid_infill_extrusion_width", s.line_width_mm.to_string()),
        ("top_infill_extrusion_width", s.line_width_mm.to_string()),
        ("perimeters", s.walls.to_string()),
        ("bottom_solid_layers", s.bottom_layers.to_string()),
        ("top_solid_layers", s.top_layers.to_string()),
        ("fill_density", percent(s.infill)),
        ("fill_pattern", pattern.to_owned()),
        ("infill_first", u8::from(s.infill_first).to_string()),
        ("bridge_flow_ratio", s.bridge_flow.to_string()),
        ("external_perimeter_speed", s.outer_wall_mm_per_s.to_string()),
        ("perimeter_speed", s.inner_wall_mm_per_s.to_string()),
        ("small_perimeter_speed", s.outer_wall_mm_per_s.to_string()),
        ("infill_speed", s.infill_mm_per_s.to_string()),
        ("solid_infill_speed", s.infill_mm_per_s.to_string()),
        ("top_solid_infill_speed", s.infill_mm_per_s.to_string()),
        ("gap_fill_speed", s.outer_wall_mm_per_s.to_string()),
        ("bridge_speed", s.bridge_mm_per_s.to_string()),
        ("slowdown_below_layer_time", (s.min_layer_s.round() as i64).to_string()),
        ("min_print_speed", s.slowest_mm_per_s.to_string()),
        ("solid_infill_below_area", s.solid_below_mm2.to_string()),
        ("first_layer_speed", s.first_layer_mm_per_s.to_string()),
        ("travel_speed", s.travel_mm_per_s.to_string()),
        ("retract_length", s.retract_mm.to_string()),
        ("retract_speed", s.retract_mm_per_s.to_string()),
        ("retract_before_travel", s.retract_from_mm.to_string()),
        ("retract_lift", "0".to_owned()),
        ("disable_fan_first_layers", "1".to_owned()),
        ("full_fan_speed_layer", "0".to_owned()),
        ("temperature", s.nozzle_c.to_string()),
        ("bed_temperature", s.bed_c.to_string()),
        ("min_fan_speed", fan.clone()),
        ("max_fan_speed", fan.clone()),
        ("bridge_fan_speed", fan),
        ("fan_always_on", u8::from(s.fan > 0.0).to_string()),
        ("cooling", u8::from(s.fan > 0.0).to_string()),
    ]
    .into_iter()
    .collect()
}

/// What the user's configuration must not change; `layer_height` is the one in effect.
pub(super) fn forced(layer_height: &str, job: &SliceJob) -> Values {
    let mut values = common_forced(layer_height, job);
    let more = [
        ("first_layer_speed_over_raft", "100%"),
        ("elefant_foot_compensation", "0"),
        ("brim_type", if job.adhesion.brim_mm > 0.0 { "outer_only" } else { "no_brim" }),
        ("brim_separation", "0"),
        ("draft_shield", "disabled"),
        ("wipe_tower", "0"),
        ("start_filament_gcode", "\"\""),
        ("end_filament_gcode", "\"\""),
        ("between_objects_gcode", ""),
        ("gcode_label_objects", "1"),
        ("binary_gcode", "0"),
        ("thumbnails", ""),
        // The most that PrusaSlicer takes.
        ("max_print_height", "1200"),
        ("autoemit_temperature_commands", "0"),
    ];
    values.extend(more.map(|(key, value)| (key, value.to_owned())));
    values
}

/// The forced keys that PrusaSlicer and Slic3r share.
///
/// The first layer becomes like the others, except for its speed on the table. Start code, supports and skirts belong
/// to the rewriter or stand on a bed that is not there.
pub(super) fn common_forced(layer_height: &str, job: &SliceJob) -> Values {
    let [x, y] = job.bed_mm;
    let mut values: Values = [
        ("first_layer_height", layer_height),
        ("first_layer_extrusion_width", "0"),
        ("first_layer_acceleration", "0"),
        ("raft_layers", "0"),
        ("support_material", "0"),
        ("complete_objects", "0"),
        ("start_gcode", ""),
        // A word that Slic3r looks for: without it, it switches nozzle and bed off at the end of every slot.
        ("end_gcode", "; M104 and M140 stay as they are"),
        ("before_layer_gcode", ""),
        // Relative E is refused by Marlin flavours without this.
        ("layer_gcode", "G92 E0"),
        ("use_relative_e_distances", "1"),
        ("use_firmware_retraction", "0"),
        ("post_process", ""),
        ("z_offset", "0"),
    ]
    .map(|(key, value)| (key, value.to_owned()))
    .into();
    let around = &job.adhesion;
    values.extend([
        ("brim_width", around.brim_mm.to_string()),
        ("skirts", around.skirt_loops.to_string()),
        ("skirt_distance", around.skirt_distance_mm.to_string()),
        ("skirt_height", "1".to_owned()),
        ("min_skirt_length", "0".to_owned()),
    ]);
    values.insert("bed_shape", format!("0x0,{x}x0,{x}x{y},0x{y}"));
    if !job.on_table {
        values.insert("first_layer_speed", "100%".to_owned());
        values.insert("disable_fan_first_layers", "0".to_owned());
    }
    values
}

/// The configuration as the text of an `.ini` file.
pub(super) fn ini(values: &Values) -> String {
    values.iter().map(|(key, value)| format!("{key} = {value}\n")).collect()
}

/// The command line: configurations in rising order of precedence, then the mesh and the output.
pub(super) fn arguments(configs: &[&Path], mesh: &Path, output: &Path) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = vec!["--export-gcode".into(), "--dont-arrange".into()];
    for config in configs {
        arguments.extend(["--load".into(), config.as_os_str().to_owned()]);
    }
    arguments.extend(["--output".into(), output.as_os_str().to_owned(), mesh.as_os_str().to_owned()]);
    arguments
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slicing::Adhesion;

    #[test]
    fn the_version_is_found_in_the_help_text() {
        let help = "[2026] trace\nPrusaSlicer-2.5.0+UNKNOWN based on Slic3r (with GUI support)\n";
        assert_eq!(version(help).as_deref(), Some("2.5.0"));
        assert_eq!(version("PrusaSlicer-2.9.1 based on").as_deref(), Some("2.9.1"));
        assert_eq!(version("Slic3r 1.3.0 is a STL-to-GCODE translator"), None);
    }

    #[test]
    fn a_slot_on_material_has_no_first_layer_of_its_own() {
        let mut job =
            SliceJob { name: "x".into(), on_table: false, bed_mm: [300.0, 200.0], adhesion: Adhesion::default() };
        let values = forced("0.15", &job);
        assert_eq!(values["first_layer_height"], "0.15");
        assert_eq!(values["first_layer_speed"], "100%");
        assert_eq!(values["bed_shape"], "0x0,300x0,300x200,0x200");
        job.on_table = true;
        assert!(!forced("0.15", &job).contains_key("first_layer_speed"));
        assert!(ini(&values).contains("\nskirts = 0\n"));
    }
}
