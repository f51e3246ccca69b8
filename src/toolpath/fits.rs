//! Whether a file was sliced for the machine of the profile: nozzle and filament, as its own settings state them.

use super::inputs::{Input, RewriteError};
use crate::gcode::settings::Setting;
use crate::profile::Profile;

/// What a nozzle's bore may be stated otherwise, mm: the last digit.
const SAME_NOZZLE_MM: f64 = 0.01;
/// What a filament's diameter may be stated otherwise, mm: spools are measured, and slicers are told.
const AS_MEASURED_MM: f64 = 0.05;
/// What is not worth a word, mm.
const SAME_FILAMENT_MM: f64 = 0.004;
/// Layers that are so much higher than the profile's are worth one, relative.
const HIGHER_LAYERS: f64 = 0.25;

/// What the user should know of what differs.
///
/// # Errors
///
/// [`RewriteError::OtherMachine`] for another nozzle or another filament.
pub(super) fn check(input: &Input<'_>, profile: &Profile) -> Result<Vec<String>, RewriteError> {
    let (settings, process) = (&input.sliced.settings, &profile.process);
    let differs = |what, key, sliced_mm: f64, profile_mm: f64| RewriteError::OtherMachine {
        file: input.file.to_owned(),
        what,
        key,
        sliced_mm,
        profile_mm,
    };
    let mut notes = Vec::new();
    if let Some(mm) = settings.positive(Setting::Nozzle)
        && (mm - process.nozzle_mm).abs() > SAME_NOZZLE_MM
    {
        return Err(differs("a nozzle", "nozzle_mm", mm, process.nozzle_mm));
    }
    if let Some(mm) = settings.positive(Setting::Filament) {
        let (usual, off) = (process.filament_mm, (mm - process.filament_mm).abs());
        if off > AS_MEASURED_MM {
            return Err(differs("filament", "filament_mm", mm, usual));
        }
        if off > SAME_FILAMENT_MM {
            notes.push(format!(
                "sliced for filament of {mm} mm, but process.filament_mm is {usual}; lines are checked with {mm} mm"
            ));
        }
    }
    if let Some(mm) = settings.positive(Setting::LayerHeight)
        && mm > process.layer_height_mm * (1.0 + HIGHER_LAYERS)
    {
        let usual = process.layer_height_mm;
        notes.push(format!(
            "sliced with layers of {mm} mm, but the plan was made for {usual} mm (process.layer_height_mm); if clearances are tight, plan with {mm} mm"
        ));
    }
    Ok(notes)
}
