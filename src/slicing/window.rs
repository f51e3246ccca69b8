//! All settings of a project for PrusaSlicer's window: what a person would otherwise have to click together.

use super::prusa::{Values, base, forced};
use super::{Adhesion, SliceJob, SliceSettings};

/// The window's bed, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowBed {
    /// Its lowest x and y.
    pub min_mm: [f64; 2],
    /// Its highest.
    pub max_mm: [f64; 2],
}

/// What the head must clear between objects, mm: every way from one to the next is replaced, so next to nothing.
const CLEARANCE_MM: f64 = 1.0;

/// The settings as the `; key = value` lines that a project holds, to print objects up to `tallest_mm` one by one, labelled, without
/// anything around them; `script` is run over the file, unless it is empty.
pub fn project_settings(settings: &SliceSettings, bed: WindowBed, tallest_mm: f64, script: &str) -> String {
    let ([x0, y0], [x1, y1]) = (bed.min_mm, bed.max_mm);
    let job =
        SliceJob { name: String::new(), on_table: true, bed_mm: [x1 - x0, y1 - y0], adhesion: Adhesion::default() };
    let mut values: Values = base(settings);
    values.extend(forced(&settings.layer_height_mm.to_string(), &job));
    let own = [
        ("bed_shape", format!("{x0}x{y0},{x1}x{y0},{x1}x{y1},{x0}x{y1}")),
        ("complete_objects", "1".to_owned()),
        ("extruder_clearance_radius", CLEARANCE_MM.to_string()),
        // Objects taller than this are refused by the window, all but the last; one that was scaled shall come as far as we are.
        ("extruder_clearance_height", (2.0 * tallest_mm + 100.0).ceil().to_string()),
        ("first_layer_temperature", settings.nozzle_c.to_string()),
        ("first_layer_bed_temperature", settings.bed_c.to_string()),
        ("first_layer_speed", settings.first_layer_mm_per_s.to_string()),
        ("post_process", quoted(script)),
    ];
    values.extend(own);
    values.iter().map(|(key, value)| format!("; {key} = {value}\n")).collect()
}

/// One text of a list, as PrusaSlicer writes it.
fn quoted(text: &str) -> String {
    if text.is_empty() {
        return String::new();
    }
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_project_holds_what_would_have_to_be_clicked() {
        let bed = WindowBed { min_mm: [-125.0, -105.0], max_mm: [125.0, 105.0] };
        let text =
            project_settings(&SliceSettings::default(), bed, 41.3, "/a/trunnion rewrite --plan \"/my plans/p.json\"");
        for line in [
            "; bed_shape = -125x-105,125x-105,125x105,-125x105",
            "; complete_objects = 1",
            "; gcode_label_objects = 1",
            "; extruder_clearance_height = 183",
            "; skirts = 0",
            "; start_gcode = ",
            "; post_process = \"/a/trunnion rewrite --plan \\\"/my plans/p.json\\\"\"",
        ] {
            assert!(text.lines().any(|l| l == line), "{line} in {text}");
        }
        assert!(project_settings(&SliceSettings::default(), bed, 1.0, "").contains("; post_process = \n"));
    }
}
