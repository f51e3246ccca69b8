//! What of a profile a price needs.

use super::LoadedProfile;
use crate::orient::{ObjectiveSettings, Process};
use crate::profile::SliceSettings;

/// What a machine's process is for a price, with the overhang that stands by itself everywhere else.
pub(crate) fn process_of(machine: &LoadedProfile) -> Process {
    let print = &machine.profile.process;
    process(print, &ObjectiveSettings { layer_mm: print.layer_height_mm, ..ObjectiveSettings::default() })
}

/// What of a profile's process a price needs.
pub(crate) fn process(print: &SliceSettings, settings: &ObjectiveSettings) -> Process {
    Process {
        layer_mm: settings.layer_mm,
        line_mm: print.line_width_mm,
        walls: print.walls,
        infill: print.infill,
        wall_mm_per_s: f64::midpoint(print.outer_wall_mm_per_s, print.inner_wall_mm_per_s),
        infill_mm_per_s: print.infill_mm_per_s,
        overhang: settings.overhang,
        ..Process::default()
    }
}
