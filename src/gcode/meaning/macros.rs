//! Commands by name: Klipper's own, the slicers' labels among them. Any other name may be anything.

use super::{Effect, Firmware, Hazard, Heater};
use crate::gcode::push_fixed;

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
    ("MANUAL_STEPPER", Effect::Hazard(Hazard::Stepper)),
    ("PAUSE", Effect::Hazard(Hazard::Person)),
    ("PIVOT_COORD", Effect::Hazard(Hazard::Shift)),
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

/// A line `MANUAL_STEPPER STEPPER=name ..` of Klipper's.
#[derive(Clone, Debug, PartialEq)]
pub struct ManualStepper {
    /// The name, as its section of printer.cfg has it.
    pub stepper: String,
    /// What it does.
    pub act: StepperAct,
}

/// What a `MANUAL_STEPPER` line does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepperAct {
    /// Goes to a place, in the stepper's units (degrees), at units a second; all else waits until it is there.
    Move {
        /// MOVE.
        to: f64,
        /// SPEED.
        speed: f64,
    },
    /// Calls the place where it is so (SET_POSITION).
    Set(f64),
    /// Switches its motor on or off, makes it an axis, moves while others move or as far as a switch, or at a speed that only
    /// printer.cfg knows.
    Other,
}

impl ManualStepper {
    /// The line that goes to `to` at `speed`, units a second, before anything else moves.
    pub fn go(stepper: &str, to: f64, speed: f64) -> String {
        let mut line = format!("MANUAL_STEPPER STEPPER={stepper} SPEED=").into_bytes();
        push_fixed(&mut line, (speed * 100.0 + 1e-6).floor() / 100.0, 2);
        line.extend_from_slice(b" MOVE=");
        push_fixed(&mut line, to, 4);
        String::from_utf8(line).unwrap_or_default()
    }

    /// Reads a command by name; `None` for any other.
    pub fn read(text: &[u8]) -> Option<Self> {
        let text = std::str::from_utf8(text).ok()?;
        let mut words = text.split_ascii_whitespace();
        words.next().filter(|name| name.eq_ignore_ascii_case("MANUAL_STEPPER"))?;
        let (mut stepper, mut to, mut speed, mut set, mut other) = (None, None, None, None, false);
        for word in words {
            let (key, value) = word.split_once('=')?;
            let number = || value.parse::<f64>().ok().filter(|number| number.is_finite());
            match key.to_ascii_uppercase().as_str() {
                "STEPPER" => stepper = Some(value.to_owned()),
                "MOVE" => to = Some(number()?),
                "SPEED" => speed = Some(number()?),
                "SET_POSITION" => set = Some(number()?),
                "ACCEL" => {}
                "SYNC" if value == "1" => {}
                _ => other = true,
            }
        }
        let act = match (other, to, speed, set) {
            (false, Some(to), Some(speed), None) if speed > 0.0 => StepperAct::Move { to, speed },
            (false, None, _, Some(place)) => StepperAct::Set(place),
            _ => StepperAct::Other,
        };
        Some(Self { stepper: stepper?, act })
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
    // Klipper compares a target with its limits, which says nothing of one that is no number.
    match value(target).map_or(Ok(0.0), str::parse) {
        Ok(target_c) if f64::is_finite(target_c) => Effect::Heat { heater, target_c: Some(target_c), waits },
        _ => Effect::Hazard(Hazard::Unknown),
    }
}
