//! What each number of a profile may be: one table, applied to the resolved values whatever file they came from.
//!
//! The ranges are wide: they keep out what no machine is, not what is unusual. What relates several keys is in `build.rs`.

use std::ops::RangeInclusive;

use toml::Value;

/// A number that no machine can have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key} = {value}: must be {allowed}")]
pub struct OutOfRange {
    /// The key's whole path.
    pub key: String,
    /// As given.
    pub value: String,
    /// What is allowed, with its unit.
    pub allowed: String,
}

/// The table: key path, allowed range; the unit is the one that the key ends with. `body.` is of `[[head.body]]` and
/// `[[fixed.body]]` alike.
const RANGES: [(&str, RangeInclusive<f64>); 100] = [
    ("kinematics.pivot_mm", -1e4..=1e4),
    ("kinematics.offset_mm", -1e4..=1e4),
    ("kinematics.tilt.along", -2.0..=2.0),
    ("kinematics.tilt.from_tip_mm", -1e3..=1e3),
    ("kinematics.tilt.direction", -1.0..=1.0),
    ("kinematics.tilt.zero_deg", -360.0..=360.0),
    ("kinematics.tilt.min_deg", -180.0..=180.0),
    ("kinematics.tilt.max_deg", -180.0..=180.0),
    ("kinematics.tilt.max_deg_per_s", 0.01..=1e4),
    ("kinematics.tilt.holding_nm", 1e-3..=1e4),
    ("kinematics.rotation.along", -2.0..=2.0),
    ("kinematics.rotation.from_tip_mm", -1e3..=1e3),
    ("kinematics.rotation.direction", -1.0..=1.0),
    ("kinematics.rotation.zero_deg", -36e3..=36e3),
    ("kinematics.rotation.min_deg", -1e7..=1e7),
    ("kinematics.rotation.max_deg", -1e7..=1e7),
    ("kinematics.rotation.max_turns", 0.5..=1e4),
    ("kinematics.rotation.max_deg_per_s", 0.01..=1e4),
    ("limits.x_mm", -1e4..=1e4),
    ("limits.y_mm", -1e4..=1e4),
    ("limits.z_mm", -1e4..=1e4),
    ("limits.max_feed_mm_per_min", 1.0..=12e4),
    ("limits.acceleration_mm_per_s2", 1.0..=1e6),
    ("limits.z_acceleration_mm_per_s2", 1.0..=1e6),
    ("limits.e_acceleration_mm_per_s2", 1.0..=1e6),
    ("limits.turn_acceleration_deg_per_s2", 1.0..=1e6),
    ("limits.junction_mm", 0.001..=1.0),
    ("limits.min_extrude_c", 0.0..=400.0),
    ("limits.max_flow_mm3_per_s", 0.1..=500.0),
    ("table.radius_mm", 0.0..=1e4),
    ("table.size_mm", 1.0..=1e4),
    ("table.thickness_mm", 0.0..=1000.0),
    ("table.keep_out_mm", 0.0..=1000.0),
    ("body.z_mm", -1e4..=1e4),
    ("body.r_mm", 0.0..=1e4),
    ("body.min_mm", -1e4..=1e4),
    ("body.max_mm", -1e4..=1e4),
    ("body.points_mm", -1e4..=1e4),
    ("transition.retract_mm", 0.0..=100.0),
    ("transition.retract_mm_per_s", 0.1..=2000.0),
    ("transition.prime_mm", 0.0..=10.0),
    ("transition.clearance_mm", 0.0..=1000.0),
    ("transition.park_mm", -1e4..=1e4),
    ("transition.travel_mm_per_min", 1.0..=12e4),
    ("transition.z_mm_per_min", 1.0..=12e4),
    ("price.gram_min", 0.0..=1e4),
    ("price.setup_min", 0.0..=1e4),
    ("price.supports_min", 0.0..=1e4),
    ("price.contact_min_per_cm2", 0.0..=1e4),
    ("price.seam_min_per_mm2", 0.0..=1e4),
    ("price.droop_min_per_mm3", 0.0..=1e4),
    ("joint.layers", 1.0..=20.0),
    ("joint.overlap_mm", 0.0..=0.1),
    ("joint.mm_per_s", 0.1..=2000.0),
    ("joint.fan", 0.0..=1.0),
    ("joint.nozzle_c", 0.0..=500.0),
    ("process.nozzle_mm", 0.1..=2.0),
    ("process.filament_mm", 1.0..=4.0),
    ("process.layer_height_mm", 0.02..=1.5),
    ("process.line_width_mm", 0.1..=4.0),
    ("process.first_layer_width_mm", 0.0..=4.0),
    ("process.walls", 1.0..=100.0),
    ("process.bottom_layers", 0.0..=1e4),
    ("process.top_layers", 0.0..=1e4),
    ("process.infill", 0.0..=1.0),
    ("process.infill_overlap", 0.0..=0.5),
    ("process.brim_mm", 0.0..=100.0),
    ("process.skirt_loops", 0.0..=20.0),
    ("process.skirt_distance_mm", 0.0..=100.0),
    ("process.anchor_mm", 0.0..=50.0),
    ("process.outer_wall_mm_per_s", 0.1..=2000.0),
    ("process.inner_wall_mm_per_s", 0.1..=2000.0),
    ("process.infill_mm_per_s", 0.1..=2000.0),
    ("process.bridge_mm_per_s", 0.1..=2000.0),
    ("process.overhang_mm_per_s", 0.1..=2000.0),
    ("process.first_layer_mm_per_s", 0.1..=2000.0),
    ("process.travel_mm_per_s", 0.1..=2000.0),
    ("process.min_layer_s", 0.0..=600.0),
    ("process.slowest_mm_per_s", 0.1..=2000.0),
    ("process.solid_below_mm2", 0.0..=1e6),
    ("process.solid_below_mm", 0.0..=100.0),
    ("process.retract_mm", 0.0..=100.0),
    ("process.retract_mm_per_s", 0.1..=2000.0),
    ("process.bridge_mm", 0.0..=200.0),
    ("process.adhesion_mpa", 0.0..=10.0),
    ("process.retract_from_mm", 0.0..=1000.0),
    ("process.nozzle_c", 0.0..=500.0),
    ("process.bed_c", 0.0..=200.0),
    ("process.bridge_flow", 0.5..=1.5),
    ("process.fan", 0.0..=1.0),
    ("process.bridge_fan", 0.0..=1.0),
    ("link.baud", 300.0..=12e6),
    ("link.buffer", 16.0..=1e6),
    ("link.commands", 1.0..=1e4),
    ("link.reads_ms", 0.0..=1000.0),
    ("link.planner", 0.0..=1e4),
    ("link.longest_line", 16.0..=1e6),
    ("link.max_nozzle_c", 0.0..=500.0),
    ("link.max_bed_c", 0.0..=200.0),
    ("link.lift_mm", 0.0..=1000.0),
];

/// Units by the end of a key, the longest ending first.
const UNITS: [(&str, &str); 16] = [
    ("_mm_per_min", " mm/min"),
    ("_min_per_cm2", " min/cm2"),
    ("_min_per_mm2", " min/mm2"),
    ("_min_per_mm3", " min/mm3"),
    ("_min", " min"),
    ("_deg_per_s2", " deg/s2"),
    ("_mm_per_s2", " mm/s2"),
    ("_mm3_per_s", " mm3/s"),
    ("mm_per_s", " mm/s"),
    ("_deg_per_s", " deg/s"),
    ("_mm2", " mm2"),
    ("_ms", " ms"),
    ("_mm", " mm"),
    ("_deg", " deg"),
    ("_c", " deg C"),
    ("_s", " s"),
];

pub(super) fn range(key: &str) -> Option<&'static RangeInclusive<f64>> {
    let inner = key.split_once('.').map_or(key, |(_, inner)| inner);
    RANGES.iter().find(|(of, _)| *of == key || *of == inner).map(|(_, range)| range)
}

/// What `key` may be, as `0.1..2 mm`; `None` for what is no number.
pub(super) fn allowed(key: &str) -> Option<String> {
    if key.ends_with(".direction") {
        return Some("1 or -1".to_owned());
    }
    let unit = UNITS.iter().find(|(end, _)| key.ends_with(end)).map_or("", |(_, unit)| unit);
    range(key).map(|range| format!("{}..{}{unit}", range.start(), range.end()))
}

/// Refuses a number that is given in the place of the one at `key`.
///
/// # Errors
///
/// [`OutOfRange`] with what is allowed.
pub fn check_number(key: &str, number: f64) -> Result<(), OutOfRange> {
    let whole = number.fract() == 0.0 && number.abs() < 1e15;
    check(key, &if whole { Value::Integer(number as i64) } else { Value::Float(number) })
}

/// Refuses the first number in `value`, which stands at `key`, that: must be its range, or none at all.
pub(super) fn check(key: &str, value: &Value) -> Result<(), OutOfRange> {
    let number = match value {
        Value::Integer(number) => *number as f64,
        Value::Float(number) => *number,
        Value::Array(all) => return all.iter().try_for_each(|one| check(key, one)),
        Value::Table(table) => {
            let path = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
            return table.iter().try_for_each(|(name, one)| check(&path(name), one));
        }
        _ => return Ok(()),
    };
    match range(key) {
        Some(range) if !range.contains(&number) => {
            Err(OutOfRange { key: key.to_owned(), value: value.to_string(), allowed: allowed(key).unwrap_or_default() })
        }
        // A number where a text is wanted is told apart when the types are read.
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The node of the schema of a key, and its pieces' where it is a list.
    fn shown<'a>(schema: &'a serde_json::Value, key: &str) -> &'a serde_json::Value {
        let root = match key.split_once('.') {
            Some(("body", _)) => "body",
            _ => "profile",
        };
        let inner = key.strip_prefix("body.").unwrap_or(key);
        let mut node = inner.split('.').fold(&schema["$defs"][root], |node, name| &node["properties"][name]);
        while node["type"] == "array" {
            node = &node["items"];
        }
        node
    }

    #[test]
    fn the_schema_of_profile_show_has_the_same_ranges() {
        let schema: serde_json::Value =
            serde_json::from_str(include_str!("../../docs/schemas/profile-show.json")).unwrap();
        for (key, range) in RANGES.iter().filter(|(key, _)| !key.ends_with(".direction")) {
            let node = shown(&schema, key);
            let ends = ["minimum", "maximum"].map(|end| node[end].as_f64());
            assert_eq!(
                ends,
                [Some(*range.start()), Some(*range.end())],
                "docs/schemas/profile-show.json: {key}: {node}"
            );
        }
    }
}
