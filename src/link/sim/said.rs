//! What a simulated printer says of its own settings, in its firmware's words.
//!
//! After Marlin's `settings.cpp`, `M200-M205.cpp` and `M211.cpp` (2.1), RepRapFirmware's object model (`Move.cpp`, 3.6) and grblHAL's settings.

use super::Sim;

/// Ends of an axis that has none, as firmwares are usually told.
const ENDLESS_DEG: f64 = 99_999.0;
/// So fast the extruder goes, mm/s.
const EXTRUDER: f64 = 50.0;
/// Steps a unit, which are no matter here.
const STEPS: f64 = 80.0;

/// An axis as its firmware describes it: mm and mm/s, or degrees and degrees/s.
pub(super) struct SaidAxis {
    pub(super) letter: char,
    pub(super) ends: [f64; 2],
    pub(super) speed: f64,
    pub(super) acceleration: f64,
}

impl Sim {
    /// X, Y, Z, tilt, rotation.
    pub(super) fn said_axes(&self) -> [SaidAxis; 5] {
        let model = &self.machine.model;
        let (low, high) = (model.limits.min, model.limits.max);
        let fastest = model.rates.max_feed / 60.0;
        let ends = [[low.x, high.x], [low.y, high.y], [low.z, high.z]];
        std::array::from_fn(|i| {
            let acceleration = model.accelerations.axes[i];
            match i.checked_sub(3).map(|i| &model.axes[i]) {
                None => SaidAxis { letter: ['X', 'Y', 'Z'][i], ends: ends[i], speed: fastest, acceleration },
                Some(axis) => SaidAxis {
                    letter: char::from(axis.letter),
                    ends: axis.range.map_or([-ENDLESS_DEG, ENDLESS_DEG], |(low, high)| [low.deg(), high.deg()]),
                    speed: axis.max_rate.to_degrees(),
                    acceleration,
                },
            }
        })
    }

    fn list(&self, of: impl Fn(&SaidAxis) -> f64) -> String {
        self.said_axes().iter().map(|axis| format!(" {}{:.2}", axis.letter, of(axis))).collect()
    }

    /// M503.
    pub(super) fn say_settings(&mut self) {
        let e = self.machine.model.accelerations.axes[5];
        let print = self.machine.model.accelerations.axes[0];
        let junction = self.machine.model.accelerations.junction_mm;
        for line in [
            "; Steps per unit:".to_owned(),
            format!("  M92{} E93.00", self.list(|_| STEPS)),
            "; Max feedrates (units/s):".to_owned(),
            format!("  M203{} E{EXTRUDER:.2}", self.list(|axis| axis.speed)),
            "; Max Acceleration (units/s2):".to_owned(),
            format!("  M201{} E{e:.2}", self.list(|axis| axis.acceleration)),
            "; Acceleration (units/s2) (P<print-accel> R<retract-accel> T<travel-accel>):".to_owned(),
            format!("  M204 P{print:.2} R{print:.2} T{print:.2}"),
            "; Advanced (B<min_segment_time_us> S<min_feedrate> T<min_travel_feedrate> J<junc_dev>):".to_owned(),
            format!("  M205 B20000.00 S0.00 T0.00 J{junction:.2}"),
            "; Home offset:".to_owned(),
            "  M206 X0.00 Y0.00 Z0.00".to_owned(),
        ] {
            self.say(&format!("echo:{line}"));
        }
    }

    /// M211.
    pub(super) fn say_ends(&mut self) {
        let (low, high) = (self.list(|axis| axis.ends[0]), self.list(|axis| axis.ends[1]));
        self.say("echo:; Soft endstops:");
        self.say("echo:  M211 S1 ; ON");
        self.say(&format!("echo:  Min: {low}   Max: {high}"));
    }

    /// M409 K"..": a piece of the object model.
    pub(super) fn say_model(&mut self, block: &[u8]) {
        let text = String::from_utf8_lossy(block).into_owned();
        let key = text.split('"').nth(1).unwrap_or_default();
        let index = key.strip_prefix("move.axes[").and_then(|rest| rest.strip_suffix(']')?.parse::<usize>().ok());
        let axes = self.said_axes();
        let result = match (index.and_then(|i| axes.get(i)), key) {
            (Some(SaidAxis { letter, ends: [low, high], speed, acceleration }), _) => format!(
                "{{\"acceleration\":{acceleration:.1},\"homed\":true,\"jerk\":600.0,\"letter\":\"{letter}\",\"max\":{high:.2},\"min\":{low:.2},\
                 \"speed\":{:.1},\"visible\":true}}",
                speed * 60.0
            ),
            (None, "move.kinematics") => "{\"name\":\"cartesian\"}".to_owned(),
            (None, "network") => format!("{{\"name\":\"{}\"}}", self.quirks.name),
            _ => "null".to_owned(),
        };
        self.say(&format!("{{\"key\":\"{key}\",\"flags\":\"v\",\"result\":{result}}}"));
    }

    /// `$$`.
    pub(super) fn say_numbered(&mut self) {
        let axes = self.said_axes();
        let junction = self.machine.model.accelerations.junction_mm;
        let mut lines = vec![format!("$11={junction:.3}"), "$13=0".to_owned()];
        let per_minute = |axis: &SaidAxis| axis.speed * 60.0;
        let travel = |axis: &SaidAxis| axis.ends[1] - axis.ends[0];
        for column in 0..4 {
            let value = |axis: &SaidAxis| [STEPS, per_minute(axis), axis.acceleration, travel(axis)][column];
            let number = 100 + 10 * column;
            lines.extend(axes.iter().enumerate().map(|(i, axis)| format!("${}={:.3}", number + i, value(axis))));
        }
        lines.iter().for_each(|line| self.say(line));
    }
}
