//! Commands by name: Klipper's own, the slicers' labels among them. Any other name may be anything.

use super::{Effect, Firmware, Hazard, Heater};

/// Name and kind; names in capitals, as Klipper compares them.
const NAMES: &[(&str, Effect)] = &[
    ("ACTIVATE_EXTRUDER", Effect::Hazard(Hazard::Tool)),
    ("BED_MESH_CALIBRATE", Effect::Hazard(Hazard::Moves)),
    ("BED_MESH_CLEAR", Effect::Hazard(Hazard::Shift)),
    ("BED_MESH_PROFILE", Effect::Hazard(Hazard::Shift)),
    ("CANCEL_PRINT", Effect::Hazard(Hazard::Stop)),
    ("CLEAR_PAUSE", Effect::Report),
    ("EXCLUDE_OBJECT_DEFINE", Effect::Progress),
    ("EXCLUDE_OBJECT_END", Effect::Label),
    ("EXCLUDE_OBJECT_START", Effect::Label),
    ("FIRMWARE_RESTART", Effect::Hazard(Hazard::Stop)),
    ("FORCE_MOVE", Effect::Hazard(Hazard::Moves)),
    ("GET_POSITION", Effect::Report),
    ("MANUAL_STEPPER", Effect::Hazard(Hazard::Moves)),
    ("PAUSE", Effect::Hazard(Hazard::Person)),
    ("PROBE", Effect::Hazard(Hazard::Moves)),
    ("RESPOND", Effect::Report),
    ("RESTART", Effect::Hazard(Hazard::Stop)),
    ("RESTORE_GCODE_STATE", Effect::Hazard(Hazard::Shift)),
    ("RESUME", Effect::Hazard(Hazard::Person)),
    ("SAVE_CONFIG", Effect::Hazard(Hazard::Stop)),
    ("SAVE_GCODE_STATE", Effect::Report),
    ("SDCARD_PRINT_FILE", Effect::Hazard(Hazard::File)),
    ("SDCARD_RESET_FILE", Effect::Hazard(Hazard::File)),
    ("SET_DISPLAY_TEXT", Effect::Report),
    ("SET_FAN_SPEED", Effect::Setting),
    ("SET_GCODE_OFFSET", Effect::Hazard(Hazard::Shift)),
    ("SET_GCODE_VARIABLE", Effect::Hazard(Hazard::Unknown)),
    ("SET_INPUT_SHAPER", Effect::Setting),
    ("SET_KINEMATIC_POSITION", Effect::Hazard(Hazard::Shift)),
    ("SET_LED", Effect::Report),
    ("SET_PIN", Effect::Hazard(Hazard::Output)),
    ("SET_PRESSURE_ADVANCE", Effect::Setting),
    ("SET_PRINT_STATS_INFO", Effect::Progress),
    ("SET_RETRACTION", Effect::Setting),
    ("SET_SERVO", Effect::Hazard(Hazard::Moves)),
    ("SET_SKEW", Effect::Hazard(Hazard::Shift)),
    ("SET_STEPPER_ENABLE", Effect::Hazard(Hazard::MotorsOff)),
    ("SET_VELOCITY_LIMIT", Effect::Setting),
    ("STATUS", Effect::Report),
    // With parking switched on it drives the head away.
    ("TIMELAPSE_TAKE_FRAME", Effect::Hazard(Hazard::Moves)),
    ("TURN_OFF_HEATERS", Effect::HeatersOff),
    ("Z_TILT_ADJUST", Effect::Hazard(Hazard::Moves)),
];

/// What the command by name in `text` does.
pub(super) fn effect(firmware: Firmware, text: &[u8]) -> Effect {
    let unknown = Effect::Hazard(Hazard::Unknown);
    if firmware != Firmware::Klipper {
        return unknown;
    }
    let text = String::from_utf8_lossy(text).to_ascii_uppercase();
    let name = text.split_ascii_whitespace().next().unwrap_or_default();
    match name {
        "SET_HEATER_TEMPERATURE" => heat(&text, "HEATER=", "TARGET=", false),
        "TEMPERATURE_WAIT" => heat(&text, "SENSOR=", "MINIMUM=", true),
        _ => NAMES.iter().find(|(known, _)| *known == name).map_or(unknown, |(_, effect)| *effect),
    }
}

fn heat(text: &str, heater: &str, target: &str, waits: bool) -> Effect {
    let value = |key: &str| text.split_ascii_whitespace().find_map(|w| w.strip_prefix(key));
    let heater = match value(heater) {
        Some("EXTRUDER") => Heater::Nozzle,
        Some("HEATER_BED") => Heater::Bed,
        Some("CHAMBER") => Heater::Chamber,
        _ => return Effect::Hazard(Hazard::Unknown),
    };
    let target_c = value(target).map_or(Some(0.0), |v| v.parse().ok());
    Effect::Heat { heater, target_c, waits }
}
