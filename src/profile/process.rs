//! How a slot is sliced: the few numbers that every slicer understands.

use serde::{Deserialize, Serialize};
use toml::Value;

use super::ranges::{self, OutOfRange};

/// How sparse infill runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InfillPattern {
    /// One direction a layer, across that of the layer below.
    #[default]
    Lines,
    /// Three directions a layer that wander with the height: walls of cubes that stand on a corner, as stiff along every axis.
    Cubic,
}

/// Where a closed outer wall begins and ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Seam {
    /// At its rearmost point, the greatest Y of the slicer's bed.
    #[default]
    Rear,
    /// Where the nozzle comes from.
    Nearest,
    /// Above the seam of the layer below; where there is none, in a corner.
    Aligned,
    /// In its sharpest corner, one that leads inward before one that leads outward; where all is round, at the rear.
    Corner,
}

/// Process settings of one print; lengths in mm, speeds in mm/s, temperatures in deg C.
///
/// They drive the built-in slicer wholly, and are the base below the user's own configuration for the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SliceSettings {
    /// Nozzle bore.
    pub nozzle_mm: f64,
    /// Filament diameter.
    pub filament_mm: f64,
    /// Layer height; the first layer of a slot has the same.
    pub layer_height_mm: f64,
    /// Width of every extruded line.
    pub line_width_mm: f64,
    /// Width of the lines of a first layer on the table, 0 for that of all others; the built-in slicer's alone.
    pub first_layer_width_mm: f64,
    /// Number of walls.
    pub walls: u32,
    /// Solid layers below each downward skin.
    pub bottom_layers: u32,
    /// Solid layers below each upward skin.
    pub top_layers: u32,
    /// Sparse infill, 0 (hollow) to 1 (solid).
    pub infill: f64,
    /// How sparse infill runs.
    pub infill_pattern: InfillPattern,
    /// How far infill reaches into the walls where its lines turn, in line widths.
    pub infill_overlap: f64,
    /// Whether an island's infill is laid before its walls.
    pub infill_first: bool,
    /// Where outer walls begin and end; the built-in slicer's alone.
    pub seam: Seam,
    /// Whether curved walls are written as arcs (G2, G3) where that is as exact; the built-in slicer's alone.
    pub arcs: bool,
    /// How far a brim reaches around what stands on the table, 0 for none.
    pub brim_mm: f64,
    /// Loops around the first print on the table.
    pub skirt_loops: u32,
    /// From that print, or its brim, to the innermost of them.
    pub skirt_distance_mm: f64,
    /// Speed of the outer wall.
    pub outer_wall_mm_per_s: f64,
    /// Speed of the inner walls.
    pub inner_wall_mm_per_s: f64,
    /// Speed of solid and sparse infill.
    pub infill_mm_per_s: f64,
    /// Speed of lines over air between two ends on material.
    pub bridge_mm_per_s: f64,
    /// Speed of walls that the layer below does not carry.
    pub overhang_mm_per_s: f64,
    /// Speed of the first layer of a part that stands on the table.
    pub first_layer_mm_per_s: f64,
    /// Speed of moves without extrusion.
    pub travel_mm_per_s: f64,
    /// A layer takes at least so long, s: what is printed faster goes onto plastic that is still soft.
    pub min_layer_s: f64,
    /// For that no line is printed slower than this.
    pub slowest_mm_per_s: f64,
    /// Whether the head waits beside the part for what is then still missing.
    pub wait_beside: bool,
    /// Pieces of sparse infill smaller than this are filled, mm².
    pub solid_below_mm2: f64,
    /// And narrower ones.
    pub solid_below_mm: f64,
    /// Filament pulled back before a travel.
    pub retract_mm: f64,
    /// Speed of the pull.
    pub retract_mm_per_s: f64,
    /// Travels shorter than this are made without a pull.
    pub retract_from_mm: f64,
    /// Nozzle temperature.
    pub nozzle_c: f64,
    /// Bed temperature; 0 leaves the bed alone.
    pub bed_c: f64,
    /// How far bridges reach beyond the air, onto what is below.
    pub anchor_mm: f64,
    /// What a line may span over air between two ends on material.
    pub bridge_mm: f64,
    /// What a mm² of the first layer holds on the table, MPa: 0.02 for PLA, 0.3 for PETG, 0.1 for ABS on a clean plate.
    pub adhesion_mpa: f64,
    /// What bridges take of the plastic that their lines hold.
    pub bridge_flow: f64,
    /// Part fan, 0 to 1, from the second layer on.
    pub fan: f64,
    /// And at least so much for bridges and overhangs, where it turns at all.
    pub bridge_fan: f64,
}

impl Default for SliceSettings {
    fn default() -> Self {
        Self {
            nozzle_mm: 0.4,
            filament_mm: 1.75,
            layer_height_mm: 0.2,
            line_width_mm: 0.45,
            first_layer_width_mm: 0.0,
            walls: 2,
            bottom_layers: 4,
            top_layers: 4,
            infill: 0.2,
            infill_pattern: InfillPattern::Lines,
            infill_overlap: 0.25,
            infill_first: false,
            seam: Seam::Rear,
            arcs: false,
            brim_mm: 0.0,
            skirt_loops: 0,
            skirt_distance_mm: 6.0,
            outer_wall_mm_per_s: 30.0,
            inner_wall_mm_per_s: 45.0,
            infill_mm_per_s: 60.0,
            bridge_mm_per_s: 30.0,
            overhang_mm_per_s: 30.0,
            first_layer_mm_per_s: 20.0,
            travel_mm_per_s: 120.0,
            min_layer_s: 5.0,
            slowest_mm_per_s: 10.0,
            wait_beside: false,
            solid_below_mm2: 70.0,
            solid_below_mm: 2.0,
            retract_mm: 1.0,
            retract_mm_per_s: 35.0,
            retract_from_mm: 1.5,
            nozzle_c: 210.0,
            bed_c: 60.0,
            anchor_mm: 2.5,
            bridge_mm: 14.0,
            adhesion_mpa: 0.02,
            bridge_flow: 1.0,
            fan: 1.0,
            bridge_fan: 1.0,
        }
    }
}

impl SliceSettings {
    /// Whether a slicer can print with these.
    ///
    /// # Errors
    ///
    /// The first setting that: must be its range, or does not fit to the nozzle.
    pub fn check(&self) -> Result<(), OutOfRange> {
        let unreadable = |error: toml::ser::Error| OutOfRange {
            key: "process".to_owned(),
            value: error.to_string(),
            allowed: "numbers".to_owned(),
        };
        ranges::check("process", &Value::try_from(self).map_err(unreadable)?)?;
        self.fit()
    }

    /// Whether layers and lines fit to the nozzle.
    pub(super) fn fit(&self) -> Result<(), OutOfRange> {
        let out = |key: &str, value: f64, allowed: String| {
            Err(OutOfRange { key: format!("process.{key}"), value: value.to_string(), allowed })
        };
        let (layer, width, nozzle) = (self.layer_height_mm, self.line_width_mm, self.nozzle_mm);
        if layer > nozzle {
            return out("layer_height_mm", layer, format!("0..{nozzle} mm (at most process.nozzle_mm)"));
        }
        let (least, most) = ((0.5 * nozzle).max(layer), 4.0 * nozzle);
        for (key, width) in [("line_width_mm", width), ("first_layer_width_mm", self.first_layer_width_mm)] {
            let as_all = key == "first_layer_width_mm" && width == 0.0;
            if !as_all && !(least..=most).contains(&width) {
                let why = "from the layer height and half of process.nozzle_mm up to 4 times process.nozzle_mm";
                return out(key, width, format!("{least}..{most} mm ({why})"));
            }
        }
        Ok(())
    }
}
