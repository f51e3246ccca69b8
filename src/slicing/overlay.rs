//! A slicer's configuration as settings of the built-in slicer: what both know, by the names of PrusaSlicer, Slic3r and OrcaSlicer.

use std::collections::BTreeMap;

use super::config::ini_values;
use super::{SliceError, SliceSettings};

/// Takes a number over; `share` where it may be written in percent.
struct Row {
    keys: &'static [&'static str],
    percent: bool,
    set: fn(&mut SliceSettings, f64),
}

const fn row(keys: &'static [&'static str], set: fn(&mut SliceSettings, f64)) -> Row {
    Row { keys, percent: false, set }
}

const ROWS: [Row; 23] = [
    row(&["layer_height"], |s, v| s.layer_height_mm = v),
    row(&["nozzle_diameter"], |s, v| s.nozzle_mm = v),
    row(&["filament_diameter"], |s, v| s.filament_mm = v),
    row(&["extrusion_width", "line_width"], |s, v| s.line_width_mm = v),
    row(&["perimeters", "wall_loops"], |s, v| s.walls = v as u32),
    row(&["bottom_solid_layers", "bottom_shell_layers"], |s, v| s.bottom_layers = v as u32),
    row(&["top_solid_layers", "top_shell_layers"], |s, v| s.top_layers = v as u32),
    Row { keys: &["fill_density", "sparse_infill_density"], percent: true, set: |s, v| s.infill = v },
    row(&["external_perimeter_speed", "outer_wall_speed"], |s, v| s.outer_wall_mm_per_s = v),
    row(&["perimeter_speed", "inner_wall_speed"], |s, v| s.inner_wall_mm_per_s = v),
    row(&["infill_speed", "sparse_infill_speed"], |s, v| s.infill_mm_per_s = v),
    row(&["bridge_speed"], |s, v| s.bridge_mm_per_s = v),
    row(&["first_layer_speed", "initial_layer_speed"], |s, v| s.first_layer_mm_per_s = v),
    row(&["travel_speed"], |s, v| s.travel_mm_per_s = v),
    row(&["slowdown_below_layer_time", "slow_down_layer_time"], |s, v| s.min_layer_s = v),
    row(&["min_print_speed", "slow_down_min_speed"], |s, v| s.slowest_mm_per_s = v),
    row(&["retract_length", "retraction_length"], |s, v| s.retract_mm = v),
    row(&["retract_speed", "retraction_speed"], |s, v| s.retract_mm_per_s = v),
    row(&["retract_before_travel", "retraction_minimum_travel"], |s, v| s.retract_from_mm = v),
    row(&["temperature", "nozzle_temperature"], |s, v| s.nozzle_c = v),
    row(&["bed_temperature", "hot_plate_temp"], |s, v| s.bed_c = v),
    row(&["max_fan_speed", "fan_max_speed"], |s, v| s.fan = v / 100.0),
    row(&["solid_infill_below_area", "minimum_sparse_infill_area"], |s, v| s.solid_below_mm2 = v),
];

/// `settings` under the configurations `texts`, the last one on top, and the keys that were not taken over, in order.
///
/// # Errors
///
/// [`SliceError::Setting`] for a value that the built-in slicer cannot print with.
pub(super) fn overlaid(settings: &SliceSettings, texts: &[String]) -> Result<(SliceSettings, Vec<String>), SliceError> {
    let mut all = BTreeMap::new();
    texts.iter().for_each(|text| all.extend(ini_values(text)));
    let (mut settings, mut left) = (settings.clone(), Vec::new());
    for (key, value) in &all {
        let row = ROWS.iter().find(|row| row.keys.contains(&key.as_str()));
        match row.and_then(|row| Some((row, number(value, row.percent)?))) {
            Some((row, number)) => (row.set)(&mut settings, number),
            None => left.push(key.clone()),
        }
    }
    settings.check()?;
    Ok((settings, left))
}

/// The first extruder's number; a percentage of something else is none.
fn number(text: &str, percent: bool) -> Option<f64> {
    let first = text.split([',', ';']).next()?.trim();
    match first.strip_suffix('%') {
        Some(share) => percent.then(|| share.trim().parse::<f64>().ok()).flatten().map(|v| v / 100.0),
        None => first.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_configuration_counts_and_what_is_not_known_is_named() {
        let texts = ["layer_height = 0.1\nperimeters = 3\n", "layer_height = 0.25\nfill_density = 40%\nskirts = 2\n"];
        let (got, left) = overlaid(&SliceSettings::default(), &texts.map(str::to_owned)).unwrap();
        assert_eq!((got.layer_height_mm, got.walls, got.infill), (0.25, 3, 0.4));
        assert_eq!(left, ["skirts"]);
        // A percentage of the layer height is no width.
        let (got, left) = overlaid(&SliceSettings::default(), &["extrusion_width = 200%".to_owned()]).unwrap();
        assert_eq!((got.line_width_mm, left.len()), (0.45, 1));
    }

    #[test]
    fn what_cannot_be_printed_is_refused() {
        let wrong = overlaid(&SliceSettings::default(), &["layer_height = 0.5".to_owned()]).unwrap_err().to_string();
        assert!(wrong.contains("process.layer_height_mm = 0.5 is out of 0..0.4 mm"), "{wrong}");
    }
}
