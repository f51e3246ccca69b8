//! What a print is priced by: heights, widths, speeds, and what a gram, a scar and a failed print are worth in minutes.

use crate::geom::Angle;

/// How the part would be printed: lengths mm, speeds mm/s, shares 0 to 1.
///
/// The defaults are those of a machine's profile (`firmware-profiles/defaults.toml`); a profile's own values come from its
/// `[process]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Process {
    /// Layer height.
    pub layer_mm: f64,
    /// Line width.
    pub line_mm: f64,
    /// Number of walls; skins count as thick.
    pub walls: u32,
    /// Share of sparse infill.
    pub infill: f64,
    /// Mean speed of walls.
    pub wall_mm_per_s: f64,
    /// Speed of infill, and of supports.
    pub infill_mm_per_s: f64,
    /// Share of a support column that is filament.
    pub support: f64,
    /// Surfaces up to this angle from the vertical need no support.
    pub overhang: Angle,
}

impl Default for Process {
    fn default() -> Self {
        Self {
            layer_mm: 0.2,
            line_mm: 0.45,
            walls: 2,
            infill: 0.2,
            wall_mm_per_s: 37.5,
            infill_mm_per_s: 60.0,
            support: 0.15,
            overhang: Angle::from_deg(45.0),
        }
    }
}

/// PLA, g/mm³.
const GRAMS_PER_MM3: f64 = 1.24e-3;
/// Lifting, going to the next layer's start and beginning there, s.
const LAYER_S: f64 = 1.0;
/// Filament at 20 a kilogram and a machine at 1.2 an hour: a gram is worth a minute.
pub(super) const MINUTES_PER_GRAM: f64 = 1.0;
/// Breaking supports off and smoothing what they touched, min/mm² of the surface across the direction: a minute for 3 cm².
pub(super) const SCAR_MIN_PER_MM2: f64 = 1.0 / 300.0;
/// What steps of 0.2 mm are worth on a surface that shows them wholly, min/mm²: a minute for 20 cm².
const STEPS_MIN_PER_MM2: f64 = 1.0 / 2000.0;
const STEPS_MM: f64 = 0.2;

/// Grams and minutes of something laid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Laid {
    /// Filament, g.
    pub grams: f64,
    /// Time, min.
    pub minutes: f64,
}

impl Process {
    /// A solid of so much volume and surface, without its changes of layer: walls (and skins, taken as thick) first, the rest
    /// sparse. The same in every pose.
    pub fn solid(&self, volume_mm3: f64, area_mm2: f64) -> Laid {
        let shell = volume_mm3.min(area_mm2 * f64::from(self.walls) * self.line_mm);
        let sparse = (volume_mm3 - shell) * self.infill;
        let line = self.line_mm * self.layer_mm;
        let seconds = shell / (line * self.wall_mm_per_s) + sparse / (line * self.infill_mm_per_s);
        Laid { grams: (shell + sparse) * GRAMS_PER_MM3, minutes: seconds / 60.0 }
    }

    /// Supports whose columns have so much volume.
    pub fn supports(&self, columns_mm3: f64) -> Laid {
        let filament = columns_mm3 * self.support;
        let seconds = filament / (self.line_mm * self.layer_mm * self.infill_mm_per_s);
        Laid { grams: filament * GRAMS_PER_MM3, minutes: seconds / 60.0 }
    }

    /// So much filament, g.
    pub fn grams(&self, filament_mm3: f64) -> f64 {
        filament_mm3 * GRAMS_PER_MM3
    }

    /// The changes of layer over so much height, min.
    pub fn layers(&self, height_mm: f64) -> f64 {
        height_mm / self.layer_mm * LAYER_S / 60.0
    }

    /// The steps on a surface of `sum A |d.n|`, flat facets left out, min.
    pub fn steps(&self, stepped_mm2: f64) -> f64 {
        stepped_mm2 * STEPS_MIN_PER_MM2 * self.layer_mm / STEPS_MM
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_of_20_mm_by_hand() {
        let laid = Process::default().solid(8000.0, 2400.0);
        // Walls 2400 * 0.9 = 2160 mm3 at 0.09 mm2 * 37.5 mm/s, a fifth of 5840 mm3 at 60 mm/s.
        let wanted = (2160.0 / 3.375 + 1168.0 / 5.4) / 60.0;
        assert!((laid.minutes - wanted).abs() < 1e-9, "{laid:?}");
        assert!((laid.grams - 3328.0 * 1.24e-3).abs() < 1e-9, "{laid:?}");
        // Thinner than its walls: solid.
        assert!((Process::default().solid(60.0, 200.0).grams - 60.0 * 1.24e-3).abs() < 1e-12);
    }

    #[test]
    fn supports_layers_and_steps_by_hand() {
        let process = Process::default();
        let laid = process.supports(10_000.0);
        assert!((laid.grams - 1500.0 * 1.24e-3).abs() < 1e-9 && (laid.minutes - 1500.0 / 5.4 / 60.0).abs() < 1e-9);
        assert!((process.layers(60.0) - 5.0).abs() < 1e-9);
        assert!((process.steps(2000.0) - 1.0).abs() < 1e-12);
        assert!((Process { layer_mm: 0.1, ..process }.steps(2000.0) - 0.5).abs() < 1e-12);
    }
}
