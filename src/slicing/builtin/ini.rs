//! PrusaSlicer's and Slic3r's configurations for the built-in slicer: what it has a setting for, over the profile's `[process]`.
//!
//! Sources of the keys' meanings: PrusaSlicer 2.5 `--help-fff`, Slic3r 1.3 `--help`. A key that is set to nothing asks for nothing; every other
//! one that the built-in slicer has nothing for is named, once a run.

use std::collections::BTreeMap;

use super::slice;
use crate::geom::Slot;
use crate::mesh::TriangleMesh;
use crate::profile::OutOfRange;
use crate::slicing::config::ini_values;
use crate::slicing::{BuiltIn, Flaw, InfillPattern, Seam, SliceError, SliceJob, SliceSettings, Sliced, Slicer};

/// The built-in slicer with configurations over the profile's settings.
#[derive(Clone, Debug)]
pub struct Configured {
    values: BTreeMap<String, String>,
}

type Number = fn(&mut SliceSettings) -> &mut f64;
type Count = fn(&mut SliceSettings) -> &mut u32;

/// Keys whose value is the setting.
const NUMBERS: [(&str, Number); 18] = [
    ("nozzle_diameter", |s| &mut s.nozzle_mm),
    ("filament_diameter", |s| &mut s.filament_mm),
    ("layer_height", |s| &mut s.layer_height_mm),
    ("perimeter_speed", |s| &mut s.inner_wall_mm_per_s),
    ("infill_speed", |s| &mut s.infill_mm_per_s),
    ("bridge_speed", |s| &mut s.bridge_mm_per_s),
    ("bridge_flow_ratio", |s| &mut s.bridge_flow),
    ("travel_speed", |s| &mut s.travel_mm_per_s),
    ("slowdown_below_layer_time", |s| &mut s.min_layer_s),
    ("min_print_speed", |s| &mut s.slowest_mm_per_s),
    ("solid_infill_below_area", |s| &mut s.solid_below_mm2),
    ("retract_length", |s| &mut s.retract_mm),
    ("retract_speed", |s| &mut s.retract_mm_per_s),
    ("retract_before_travel", |s| &mut s.retract_from_mm),
    ("temperature", |s| &mut s.nozzle_c),
    ("bed_temperature", |s| &mut s.bed_c),
    ("brim_width", |s| &mut s.brim_mm),
    ("skirt_distance", |s| &mut s.skirt_distance_mm),
];
const COUNTS: [(&str, Count); 4] = [
    ("perimeters", |s| &mut s.walls),
    ("bottom_solid_layers", |s| &mut s.bottom_layers),
    ("top_solid_layers", |s| &mut s.top_layers),
    ("skirts", |s| &mut s.skirt_loops),
];
/// Brims that lie around a part; others lie in its holes, or nowhere.
const BRIMS: [&str; 2] = ["outer_only", "outer_and_inner"];
/// Widths; the first that is stated is every line's.
const WIDTHS: [&str; 6] = [
    "extrusion_width",
    "perimeter_extrusion_width",
    "external_perimeter_extrusion_width",
    "infill_extrusion_width",
    "solid_infill_extrusion_width",
    "top_infill_extrusion_width",
];
/// What the built-in slicer does anyway.
const AS_IT_DOES: [(&str, &str); 14] = [
    ("bottom_fill_pattern", "rectilinear"),
    ("brim_type", "no_brim"),
    ("brim_type", "outer_only"),
    ("extrusion_multiplier", "1"),
    ("fill_angle", "45"),
    ("fuzzy_skin", "none"),
    ("gap_fill_enabled", "1"),
    ("infill_every_layers", "1"),
    ("only_retract_when_crossing_perimeters", "1"),
    ("overhangs", "1"),
    ("skirt_height", "1"),
    ("slicing_mode", "regular"),
    ("thin_walls", "1"),
    ("top_fill_pattern", "rectilinear"),
];
/// Beginnings and ends of keys that are about other things than a slice: programs, notes, the machine, several extruders, and what
/// the rewriter does itself (its own start and end code, no support).
const ELSEWHERE: [&str; 42] = [
    "bed_shape",
    "color",
    "compatible_",
    "cooling_tube_",
    "default_",
    "deretract_speed",
    "draft_shield",
    "duplicate_",
    "extra_loading_move",
    "extruder_",
    "extrusion_axis",
    "filament_",
    "first_layer_bed_temperature",
    "first_layer_temperature",
    "gcode_",
    "host_",
    "inherits",
    "machine_",
    "max_print_height",
    "mmu_",
    "notes",
    "octoprint_",
    "output_filename_format",
    "parking_pos_",
    "post_process",
    "print_host",
    "printer_",
    "printhost_",
    "remaining_times",
    "serial_",
    "silent_mode",
    "single_extruder_",
    "standby_",
    "support_material_",
    "template_",
    "threads",
    "thumbnails",
    "use_",
    "variable_layer_height",
    "wipe_tower",
    "wiping_",
    "high_current_",
];
const ELSEWHERE_ENDS: [&str; 4] = ["_gcode", "_settings_id", "_extruder", "_acceleration"];
/// These say how what is not done would be done.
const DETAILS: [(&str, &str); 7] = [
    ("brim_", "brim_width"),
    ("raft_", "raft_layers"),
    ("ironing_", "ironing"),
    ("fuzzy_skin_", "fuzzy_skin"),
    ("dont_support_bridges", "support_material"),
    ("min_skirt_length", "skirts"),
    ("skirt_", "skirts"),
];
/// Keys that are read.
const READ: [&str; 11] = [
    "infill_first",
    "external_perimeter_speed",
    "first_layer_speed",
    "fill_density",
    "infill_overlap",
    "cooling",
    "fan_always_on",
    "max_fan_speed",
    "min_fan_speed",
    "bridge_fan_speed",
    "first_layer_height",
];

impl Configured {
    /// Over each other, the last on top.
    ///
    /// # Errors
    ///
    /// A value that is no number where one must stand; whether it can be printed is asked with the profile's settings.
    pub(in crate::slicing) fn new(texts: &[String]) -> Result<Self, SliceError> {
        let configured = Self::unchecked(texts);
        configured.over(&SliceSettings::default())?;
        Ok(configured)
    }

    /// The same, whatever its values are.
    pub(in crate::slicing) fn unchecked(texts: &[String]) -> Self {
        let mut values = BTreeMap::new();
        texts.iter().for_each(|text| values.extend(ini_values(text)));
        Self { values }
    }

    /// The profile's brim and skirt with these over them, for another slicer that reads all else itself.
    pub(in crate::slicing) fn adhesion(&self, base: &SliceSettings) -> Result<SliceSettings, SliceError> {
        let only = |(key, _): &(&String, &String)| key.starts_with("brim_") || key.starts_with("skirt");
        let values = self.values.iter().filter(only).map(|(key, text)| (key.clone(), text.clone())).collect();
        Self { values }.over(base)
    }

    /// The profile's settings with these over them.
    fn over(&self, base: &SliceSettings) -> Result<SliceSettings, SliceError> {
        let mut s = base.clone();
        for (key, of) in NUMBERS {
            if let Some(text) = self.value(key) {
                *of(&mut s) = number(key, text)?;
            }
        }
        for (key, of) in COUNTS {
            if let Some(text) = self.value(key) {
                *of(&mut s) = text.parse().map_err(|_| wrong(key, text, "whole numbers from 0 on"))?;
            }
        }
        self.widths(&mut s)?;
        if let Some(text) = self.value("external_perimeter_speed") {
            s.outer_wall_mm_per_s = part_of("external_perimeter_speed", text, s.inner_wall_mm_per_s)?;
        }
        if let Some(text) = self.value("first_layer_speed") {
            s.first_layer_mm_per_s = part_of("first_layer_speed", text, s.infill_mm_per_s)?;
        }
        if let Some(text) = self.value("fill_density") {
            let share = part_of("fill_density", text, 1.0)?;
            // Without a sign of percent PrusaSlicer takes what is above 1 for percent.
            s.infill = if share > 1.0 && !text.ends_with('%') { share / 100.0 } else { share };
        }
        if let Some(pattern) = self.value("fill_pattern").and_then(pattern) {
            s.infill_pattern = pattern;
        }
        if let Some(text) = self.value("infill_first") {
            s.infill_first = text != "0";
        }
        if let Some(seam) = self.value("seam_position").and_then(seam) {
            s.seam = seam;
        }
        if self.value("brim_type").is_some_and(|kind| !BRIMS.contains(&kind)) {
            s.brim_mm = 0.0;
        }
        if let Some(text) = self.value("infill_overlap") {
            s.infill_overlap = part_of("infill_overlap", text, s.line_width_mm)? / s.line_width_mm;
        }
        self.fan(&mut s)?;
        Ok(s)
    }

    /// Percent are of the layer's height; 0 leaves the profile's.
    fn widths(&self, s: &mut SliceSettings) -> Result<(), SliceError> {
        for key in WIDTHS {
            let Some(text) = self.value(key) else { continue };
            let width = part_of(key, text, s.layer_height_mm)?;
            if width > 0.0 {
                s.line_width_mm = width;
                break;
            }
        }
        Ok(())
    }

    /// Automatic cooling ends at the full speed; without it the fan turns at its least, if always.
    fn fan(&self, s: &mut SliceSettings) -> Result<(), SliceError> {
        let [cooling, always] = ["cooling", "fan_always_on"].map(|key| self.value(key) != Some("0"));
        for (key, holds) in [("max_fan_speed", cooling), ("min_fan_speed", !cooling && always)] {
            if let (Some(text), true) = (self.value(key), holds) {
                s.fan = number(key, text)? / 100.0;
            }
        }
        if !cooling && !always {
            s.fan = 0.0;
        }
        Ok(())
    }

    /// The value, of several extruders the first one's.
    fn value(&self, key: &str) -> Option<&str> {
        let text = self.values.get(key)?;
        Some(text.split(',').next().unwrap_or_default().trim())
    }

    /// Keys that ask for something the built-in slicer does not do, in their order.
    fn unheeded(&self) -> Vec<String> {
        let read = |key: &str| {
            NUMBERS.iter().any(|(known, _)| *known == key)
                || COUNTS.iter().any(|(known, _)| *known == key)
                || READ.contains(&key)
        };
        let asks = |(key, text): &(&String, &String)| {
            let text = text.trim_matches(['"', ' ']);
            match key.as_str() {
                "fill_pattern" => return pattern(text).is_none(),
                "seam_position" => return seam(text).is_none(),
                _ => {}
            }
            if key.as_str() == "first_layer_height" {
                return self.value("layer_height").is_some_and(|height| height != text && text != "100%");
            }
            if WIDTHS.contains(&key.as_str()) {
                return !is_nothing(text) && WIDTHS.iter().any(|other| self.is_another_width(other, text));
            }
            !read(key)
                && !is_nothing(text)
                && !AS_IT_DOES.contains(&(key.as_str(), text))
                && !ELSEWHERE.iter().any(|begin| key.starts_with(begin))
                && !ELSEWHERE_ENDS.iter().any(|end| key.ends_with(end))
                && !DETAILS
                    .iter()
                    .any(|(begin, of)| key.starts_with(begin) && key != of && self.value(of).is_none_or(is_nothing))
        };
        self.values.iter().filter(asks).map(|(key, _)| key.clone()).collect()
    }

    /// Whether the width that counts is another than this.
    fn is_another_width(&self, key: &str, text: &str) -> bool {
        let first = WIDTHS.iter().find(|key| self.value(key).is_some_and(|text| !is_nothing(text)));
        first == Some(&key) && self.value(key) != Some(text)
    }
}

/// The pattern that a slicer calls so, where it is one of ours.
fn pattern(name: &str) -> Option<InfillPattern> {
    match name {
        "rectilinear" | "alignedrectilinear" | "line" => Some(InfillPattern::Lines),
        "cubic" => Some(InfillPattern::Cubic),
        _ => None,
    }
}

/// The place of seams that a slicer calls so, where it is one of ours.
fn seam(name: &str) -> Option<Seam> {
    match name {
        "rear" => Some(Seam::Rear),
        "nearest" => Some(Seam::Nearest),
        "aligned" => Some(Seam::Aligned),
        _ => None,
    }
}

/// Whether a value asks for nothing.
fn is_nothing(text: &str) -> bool {
    matches!(text, "" | "0" | "0%" | "none" | "nil" | "disabled" | "0x0")
}

fn number(key: &str, text: &str) -> Result<f64, SliceError> {
    text.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| wrong(key, text, "a number"))
}

/// A number, or with a sign of percent that part of `whole`.
fn part_of(key: &str, text: &str, whole: f64) -> Result<f64, SliceError> {
    match text.strip_suffix('%') {
        Some(percent) => Ok(number(key, percent.trim_end())? / 100.0 * whole),
        None => number(key, text),
    }
}

fn wrong(key: &str, value: &str, allowed: &str) -> SliceError {
    OutOfRange { key: key.to_owned(), value: format!("`{value}`"), allowed: format!("{allowed} (--slicer-config)") }
        .into()
}

impl Slicer for Configured {
    fn name(&self) -> &str {
        BuiltIn.name()
    }

    fn version(&self) -> &str {
        BuiltIn.version()
    }

    fn flaws(&self) -> Vec<Flaw> {
        let keys = self.unheeded();
        if keys.is_empty() { Vec::new() } else { vec![Flaw::Unheeded(keys)] }
    }

    fn around(&self, settings: &SliceSettings) -> Result<SliceSettings, SliceError> {
        self.over(settings)
    }

    fn slice(&self, mesh: &TriangleMesh<Slot>, settings: &SliceSettings, job: &SliceJob) -> Result<Sliced, SliceError> {
        slice(mesh, &self.over(settings)?, job)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn configured(text: &str) -> Configured {
        Configured::new(&[text.to_owned()]).unwrap()
    }

    #[test]
    fn values_go_over_the_profile_with_their_units() {
        let text = "layer_height = 0.3\nperimeters = 3\nfill_density = 15%\nextrusion_width = 150%\nexternal_perimeter_speed = 50%\n\
                    perimeter_speed = 60\ntemperature = 215,220\ninfill_overlap = 20%\ncooling = 0\nfan_always_on = 1\nmin_fan_speed = 35\n";
        let got = configured(text).over(&SliceSettings::default()).unwrap();
        let mut wanted = SliceSettings { layer_height_mm: 0.3, walls: 3, infill: 0.15, ..SliceSettings::default() };
        (wanted.line_width_mm, wanted.nozzle_c, wanted.fan) = (got.line_width_mm, 215.0, 0.35);
        (wanted.inner_wall_mm_per_s, wanted.outer_wall_mm_per_s) = (60.0, 30.0);
        wanted.infill_overlap = got.infill_overlap;
        assert!((got.line_width_mm - 0.45).abs() < 1e-12 && (got.infill_overlap - 0.2).abs() < 1e-12, "{got:?}");
        assert_eq!(got, wanted);
        let over = Configured::new(&["perimeters = 3".to_owned(), "perimeters = 5".to_owned()]).unwrap();
        assert_eq!(over.over(&SliceSettings::default()).unwrap().walls, 5, "the last one counts");
        assert!((configured("fill_density = 40").over(&SliceSettings::default()).unwrap().infill - 0.4).abs() < 1e-12);
    }

    #[test]
    fn what_is_asked_for_and_not_done_is_named() {
        let text = "spiral_vase = 1\nbrim_width = 4\nbrim_separation = 0.1\nironing = 0\nironing_speed = 15\nfill_pattern = gyroid\nnotes = x\n\
                    start_gcode = G28\nraft_layers = 0\nraft_expansion = 1.5\nextrusion_width = 0.45\ninfill_extrusion_width = 0.6\n\
                    perimeter_extrusion_width = 0.45\nlayer_height = 0.2\nfirst_layer_height = 0.3\n";
        let wanted = ["brim_separation", "fill_pattern", "first_layer_height", "infill_extrusion_width", "spiral_vase"];
        assert_eq!(configured(text).unheeded(), wanted);
        assert!(configured("layer_height = 0.2\nfill_pattern = rectilinear\n").flaws().is_empty());
    }

    #[test]
    fn brims_and_loops_are_those_around_the_part() {
        let got = |text: &str| {
            let s = configured(text).over(&SliceSettings::default()).unwrap();
            (s.brim_mm, s.skirt_loops, s.skirt_distance_mm)
        };
        assert_eq!(got("brim_width = 4\nskirts = 2\nskirt_distance = 3\n"), (4.0, 2, 3.0));
        assert_eq!(got("brim_width = 4\nbrim_type = outer_and_inner\n").0, 4.0);
        assert_eq!(
            (got("brim_width = 4\nbrim_type = no_brim\n").0, got("brim_width = 4\nbrim_type = inner_only\n").0),
            (0.0, 0.0)
        );
        let all = configured(
            "brim_width = 4\nskirts = 1\nskirt_height = 1\nbrim_type = outer_only\nseam_position = nearest\n",
        );
        assert!(all.unheeded().is_empty(), "{:?}", all.unheeded());
        let other = configured(
            "skirts = 1\nskirt_height = 3\nbrim_type = inner_only\nbrim_width = 2\nseam_position = random\nmin_skirt_length = 4\n",
        );
        assert_eq!(other.unheeded(), ["brim_type", "min_skirt_length", "seam_position", "skirt_height"]);
        let others = Configured::unchecked(&["brim_width = 3\nlayer_height = thick\n".to_owned()]);
        assert_eq!(
            others.adhesion(&SliceSettings::default()).unwrap().brim_mm,
            3.0,
            "the rest is the other slicer's to read"
        );
    }

    #[test]
    fn a_value_that_is_no_number_is_refused_with_its_key() {
        for (text, key) in [
            ("layer_height = thick", "layer_height"),
            ("perimeters = 2.5", "perimeters"),
            ("fill_density = x%", "fill_density"),
        ] {
            let said = Configured::new(&[text.to_owned()]).unwrap_err().to_string();
            assert!(said.contains(key) && said.contains("--slicer-config"), "{said}");
        }
    }
}
