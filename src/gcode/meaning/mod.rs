//! What a command does to the machine: one table for every firmware, and everybody who asks reads it here.
//!
//! ```text
//! ParsedLine --effect(firmware, line)--> Effect     table.rs: command -> Class, by firmware; macros.rs: the same for names
//! ```
//!
//! Only the kind of effect and its numbers stand here. Where the tip goes is `motion`'s; what is kept, refused, sent or
//! reported is decided by each reader from the effect, never from the command's number.
//!
//! What is not in the table is [`Hazard::Unknown`], and unknown means refuse.
//!
//! Sources: Marlin 2.1 `gcode.cpp` and marlinfw.org; RepRapFirmware's G-code dictionary; Klipper's `G-Codes.md`; LinuxCNC's and
//! Grbl's lists of supported codes; PrusaSlicer's and Cura's own output. Units: degrees Celsius, seconds, shares.

mod corrections;
mod macros;
mod table;

pub use corrections::{Correction, Corrections, correction};
pub use macros::{ManualStepper, StepperAct};

use super::{Command, LineKind, ParsedLine};
use table::Class;

/// Whose words a file is written in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Firmware {
    /// Marlin and what spells like it: Prusa, Repetier, Sprinter, Smoothieware.
    #[default]
    Marlin,
    /// RepRapFirmware (Duet).
    RepRapFirmware,
    /// Klipper.
    Klipper,
    /// Grbl, grblHAL, FluidNC.
    Grbl,
    /// LinuxCNC and other RS274/NGC controllers.
    LinuxCnc,
}

impl Firmware {
    /// All of them, by the names that profiles use.
    pub const NAMES: [(&'static str, Self); 5] = [
        ("marlin", Self::Marlin),
        ("reprapfirmware", Self::RepRapFirmware),
        ("klipper", Self::Klipper),
        ("grbl", Self::Grbl),
        ("linuxcnc", Self::LinuxCnc),
    ];

    /// The firmware that a profile names.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, firmware)| *firmware)
    }

    /// Its name in profiles.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, firmware)| *firmware == self).map_or("", |(name, _)| name)
    }

    /// Whose firmware calls itself so, as in M115's `FIRMWARE_NAME:Marlin 2.1 SOURCE_CODE_URL:..` or by its bare name; `None` for one not known.
    pub fn introduced(says: &str) -> Option<Self> {
        let name = says.split_once("FIRMWARE_NAME:").map_or(says, |(_, behind)| behind).trim_start();
        // Up to the next `KEY:`: in what follows, other names stand.
        let own: Vec<&str> = name.split_ascii_whitespace().take_while(|word| !word.contains(':')).collect();
        let own = own.join(" ").to_ascii_lowercase();
        let has = |words: &[&str]| words.iter().any(|word| own.contains(word));
        match () {
            () if has(&["klipper", "kalico"]) => Some(Self::Klipper),
            () if has(&["reprapfirmware"]) => Some(Self::RepRapFirmware),
            () if has(&["grbl", "fluidnc"]) => Some(Self::Grbl),
            () if has(&["marlin", "prusa-firmware", "repetier"]) => Some(Self::Marlin),
            () => None,
        }
    }

    /// The firmware of a slicer's G-code flavour: `gcode_flavor = klipper`, `;FLAVOR:Marlin`; `None` for one not known.
    pub fn of_flavor(flavor: &str) -> Option<Self> {
        let flavor = flavor.trim().to_ascii_lowercase();
        match flavor.as_str() {
            "klipper" => Some(Self::Klipper),
            "reprapfirmware" | "rapid" => Some(Self::RepRapFirmware),
            "mach3" | "machinekit" => Some(Self::LinuxCnc),
            "marlin" | "marlin2" | "marlin-legacy" | "prusa" | "repetier" | "reprap" | "sprinter" | "smoothie"
            | "teacup" | "griffin" | "marlin(volumetric)" => Some(Self::Marlin),
            other if other.starts_with("marlin") || other.starts_with("reprap ") => Some(Self::Marlin),
            _ => None,
        }
    }

    /// Whether G90 and G91 switch the extruder's counting too.
    pub fn absolute_switches_extruder(self) -> bool {
        !matches!(self, Self::Klipper | Self::RepRapFirmware)
    }

    /// Whether G93 is known.
    pub fn has_inverse_time(self) -> bool {
        !matches!(self, Self::Marlin | Self::Klipper)
    }

    /// Whether it heats, fans and counts filament by words of its own.
    pub fn is_printer(self) -> bool {
        !matches!(self, Self::Grbl | Self::LinuxCnc)
    }
}

/// A heater.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heater {
    /// The nozzle in use.
    Nozzle,
    /// Another tool's nozzle.
    OtherNozzle(u32),
    /// The table.
    Bed,
    /// The chamber.
    Chamber,
}

/// What a line does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// Nothing: blank, comment, `%`.
    Nothing,
    /// A move or a mode (G0-G3, G17, G21, G90-G94, M82, M83, `G92 E`): `motion`'s to interpret.
    Motion,
    /// G28.
    Home,
    /// Firmware retraction: `true` pulls (G10), `false` pushes (G11).
    Retract(bool),
    /// Stands still for so many seconds.
    Dwell(f64),
    /// Waits until the last move has ended.
    Drain,
    /// Sets a heater; `None` leaves its target as it is.
    Heat {
        /// Which.
        heater: Heater,
        /// Degrees Celsius.
        target_c: Option<f64>,
        /// Whether the program stands until it is there.
        waits: bool,
    },
    /// All heaters off.
    HeatersOff,
    /// Waits for all heaters.
    HeatWait,
    /// A fan's speed, 0 to 1.
    Fan {
        /// Its number; 0 is the part fan.
        index: u32,
        /// Of full speed.
        share: f64,
    },
    /// Something that stays in force and moves nothing: limits, accelerations, pressure advance, input shaping.
    Setting,
    /// Speed (`true`) or flow of everything from here on, percent.
    Factor {
        /// M220 rather than M221.
        speed: bool,
        /// 100 changes nothing; `None` where the command does something else (stores, restores).
        percent: Option<f64>,
    },
    /// Says or asks something.
    Report,
    /// Names the object that is being printed.
    Label,
    /// Tells how far the print has come, or what it will take.
    Progress,
    /// Whatever must not happen unseen.
    Hazard(Hazard),
}

/// What must not happen unseen in a print.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Hazard {
    /// Shifts, scales or turns coordinates: offsets, work systems, babysteps, bed meshes.
    Shift,
    /// Changes steps a millimetre or the kinematics.
    Steps,
    /// Changes what E or degrees count: volumes, inches, Fahrenheit.
    Units,
    /// Another tool.
    Tool,
    /// The motors let go.
    MotorsOff,
    /// Waits for a person, and may drive the head away meanwhile.
    Person,
    /// Stops or resets the machine at once.
    Stop,
    /// Ends the program or switches the power off.
    End,
    /// Reads, writes or starts another file.
    File,
    /// Sets the line counter that streaming needs.
    Counter,
    /// Jumps the queue and is answered out of order.
    OutOfBand,
    /// Moves by itself: probing, parking, cleaning, loading filament.
    Moves,
    /// Moves a motor by itself that is no axis of moves (Klipper's MANUAL_STEPPER), and makes one an axis.
    Stepper,
    /// Changes what guards the machine: end stops, cold extrusion, motor currents, PID.
    Guard,
    /// Switches a pin, spindle or coolant.
    Output,
    /// Leaves out what is printed under a label.
    Skips,
    /// Lets the machine leave its path (G64).
    Blend,
    /// Not in the table.
    Unknown,
}

impl Hazard {
    /// What it does, to follow the command in a sentence.
    pub fn does(self) -> &'static str {
        match self {
            Self::Shift => "shifts all later coordinates",
            Self::Steps => "changes steps per millimetre or the kinematics",
            Self::Units => "changes the units of later numbers",
            Self::Tool => "changes the tool",
            Self::MotorsOff => "switches the motors off, so that the position is lost",
            Self::Person => "waits for a person and may move the head",
            Self::Stop => "stops or resets the machine",
            Self::End => "ends the program",
            Self::File => "reads, writes or starts another file",
            Self::Counter => "sets the printer's line counter, which streaming needs",
            Self::OutOfBand => "jumps the queue and is answered out of order",
            Self::Moves => "moves the machine in a way that is not in the file",
            Self::Stepper => "moves a motor by a command of its own",
            Self::Guard => "changes a safety setting of the machine",
            Self::Output => "switches a pin, spindle or coolant",
            Self::Skips => "leaves out an object, so that what is on it is printed in mid-air",
            Self::Blend => "changes how far the machine may leave its path",
            Self::Unknown => "is unknown to this firmware",
        }
    }
}

/// What `line` does on `firmware`.
///
/// Of several commands on a line the most hazardous one counts; moves and modes among them are still `motion`'s.
pub fn effect(firmware: Firmware, line: &ParsedLine) -> Effect {
    match line.kind {
        LineKind::Empty | LineKind::Percent => return Effect::Nothing,
        LineKind::Macro => return macros::effect(firmware, &line.text),
        LineKind::Words | LineKind::Text => {}
    }
    let mut found = Effect::Motion;
    for &command in &line.commands {
        let one = effect_of(firmware, command, line);
        match (found, one) {
            (Effect::Hazard(_), _) | (_, Effect::Motion | Effect::Nothing) if line.commands.len() > 1 => {}
            (_, one) => found = one,
        }
    }
    found
}

fn effect_of(firmware: Firmware, command: Command, line: &ParsedLine) -> Effect {
    match table::class(firmware, command) {
        Class::Motion => Effect::Motion,
        Class::Home => Effect::Home,
        Class::Offset => offset(firmware, line),
        Class::Count => count(line),
        Class::Unretract => Effect::Retract(false),
        Class::Dwell => {
            let seconds = line.value(b'S').or_else(|| Some(line.value(b'P')? * firmware_p(firmware)));
            Effect::Dwell(seconds.unwrap_or(0.0))
        }
        Class::Drain => Effect::Drain,
        Class::Nozzle { waits } => heat(firmware, line, nozzle(line), waits),
        Class::Bed { waits } => heat(firmware, line, Heater::Bed, waits),
        Class::Chamber { waits } => heat(firmware, line, Heater::Chamber, waits),
        Class::HeatWait => Effect::HeatWait,
        Class::ToolHeat => tool_heat(line).unwrap_or(Effect::Setting),
        Class::Fan => fan(firmware, line),
        Class::FanOff => Effect::Fan { index: line.value(b'P').unwrap_or(0.0) as u32, share: 0.0 },
        Class::Setting => Effect::Setting,
        Class::Speed => Effect::Factor { speed: true, percent: line.value(b'S') },
        Class::Flow => Effect::Factor { speed: false, percent: line.value(b'S') },
        Class::Report => Effect::Report,
        Class::Label => label(line),
        Class::Progress => Effect::Progress,
        Class::Idle => Effect::Nothing,
        // The first tool is the one in use.
        Class::Tool if command.letter == b'T' && command.number == 0 => Effect::Nothing,
        Class::Tool => Effect::Hazard(Hazard::Tool),
        // With a time it only says when idle motors let go.
        Class::Motors if line.value(b'S').is_some_and(|s| s > 0.0) => Effect::Nothing,
        Class::Motors => Effect::Hazard(Hazard::MotorsOff),
        // A diameter of 0 counts millimetres, as ever.
        Class::Volumetric if line.value(b'S').or(line.value(b'D')) == Some(0.0) => Effect::Nothing,
        Class::Volumetric => Effect::Hazard(Hazard::Units),
        Class::Hazard(hazard) => Effect::Hazard(hazard),
    }
}

/// A heater's target. Klipper takes S alone, and 0 where there is none; on the others a line without a target neither sets nor waits.
fn heat(firmware: Firmware, line: &ParsedLine, heater: Heater, waits: bool) -> Effect {
    let target_c = match firmware {
        Firmware::Klipper => Some(line.value(b'S').unwrap_or(0.0)),
        _ => line.value(b'S').or_else(|| line.value(b'R')),
    };
    Effect::Heat { heater, target_c, waits: waits && target_c.is_some() }
}

/// M486: a label, but P cancels the object with that number and C the one in hand. A name (A) takes the rest of the line.
fn label(line: &ParsedLine) -> Effect {
    let text = line.text.get(4..).unwrap_or_default().to_ascii_uppercase();
    let mut words = text.split(u8::is_ascii_whitespace).take_while(|word| word.first() != Some(&b'A'));
    let cancels = |word: &[u8]| matches!(word, [b'P' | b'C', rest @ ..] if rest.iter().all(u8::is_ascii_digit));
    if words.any(cancels) { Effect::Hazard(Hazard::Skips) } else { Effect::Label }
}

/// The line that has a machine stand for so many seconds, to the millisecond.
pub fn dwell_line(firmware: Firmware, seconds: f64) -> String {
    let value = (seconds * 1000.0).round() / 1000.0 / firmware_p(firmware);
    format!("G4 P{}", (value * 1000.0).round() / 1000.0)
}

/// Milliseconds, but seconds in RS274/NGC.
fn firmware_p(firmware: Firmware) -> f64 {
    if firmware.is_printer() { 1e-3 } else { 1.0 }
}

fn nozzle(line: &ParsedLine) -> Heater {
    match line.value(b'T') {
        Some(tool) if tool != 0.0 => Heater::OtherNozzle(tool as u32),
        _ => Heater::Nozzle,
    }
}

/// G10: retraction where it is bare, RepRapFirmware's tool temperature, else an offset.
fn offset(firmware: Firmware, line: &ParsedLine) -> Effect {
    let only = |letters: &[u8]| line.words.iter().all(|w| letters.contains(&w.letter));
    if !firmware.is_printer() {
        return Effect::Hazard(Hazard::Shift);
    }
    if line.words.is_empty() || (only(b"S") && firmware == Firmware::Marlin) {
        return Effect::Retract(true);
    }
    // The standby temperature R is none of the tool's in use.
    if firmware == Firmware::RepRapFirmware && only(b"PSR") && line.has(b'P') {
        return tool_heat(line).unwrap_or(Effect::Heat { heater: Heater::Nozzle, target_c: None, waits: false });
    }
    Effect::Hazard(Hazard::Shift)
}

/// RepRapFirmware's tool `P` at `S` degrees; `None` where nothing is said of its active temperature.
fn tool_heat(line: &ParsedLine) -> Option<Effect> {
    let heater = match line.value(b'P') {
        None | Some(0.0) => Heater::Nozzle,
        Some(tool) => Heater::OtherNozzle(tool as u32),
    };
    line.value(b'S').map(|celsius| Effect::Heat { heater, target_c: Some(celsius), waits: false })
}

/// G92: the extruder's count alone is a mode; on any axis it shifts. `motion` knows the extruder's letter.
fn count(line: &ParsedLine) -> Effect {
    let axes = line.words.iter().any(|w| matches!(w.letter, b'X' | b'Y' | b'Z' | b'A' | b'B' | b'C'));
    if axes || line.words.is_empty() { Effect::Hazard(Hazard::Shift) } else { Effect::Motion }
}

fn fan(firmware: Firmware, line: &ParsedLine) -> Effect {
    let index = line.value(b'P').unwrap_or(0.0) as u32;
    match line.value(b'S') {
        // RepRapFirmware counts to 1 or to 255.
        Some(s) if firmware == Firmware::RepRapFirmware && s <= 1.0 => Effect::Fan { index, share: s },
        Some(s) => Effect::Fan { index, share: s / 255.0 },
        None if firmware == Firmware::RepRapFirmware && !line.words.is_empty() => Effect::Setting,
        None => Effect::Fan { index, share: 1.0 },
    }
}

/// What a program has X and Y accelerate by (M204), mm/s²: printing, travelling; `None` before it says so.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TipAcceleration([Option<f64>; 2]);

impl TipAcceleration {
    /// Takes note of what a line says.
    pub fn take(&mut self, firmware: Firmware, line: &ParsedLine) {
        let said = accelerations(firmware, line).unwrap_or_default();
        self.0.iter_mut().zip(said).for_each(|(now, said)| *now = said.or(*now));
    }

    /// Of a move that takes `e` mm of filament.
    pub fn of(&self, e: f64) -> Option<f64> {
        self.0[usize::from(e <= 0.0)]
    }
}

/// What M204 says of printing and travelling from now on, mm/s²; `None` where the line says nothing of one.
fn accelerations(firmware: Firmware, line: &ParsedLine) -> Option<[Option<f64>; 2]> {
    if !firmware.is_printer() || !line.commands.contains(&Command::m(204)) {
        return None;
    }
    let word = |letter: u8| line.value(letter).or_else(|| line.value(b'S')).filter(|v| *v > 0.0);
    Some([word(b'P'), word(b'T')])
}

/// The letter that tells several of the same command apart: fans, pins, extruders.
pub fn index_letter(command: Command) -> Option<u8> {
    match (command.letter, command.number) {
        (b'M', 42 | 106 | 107) => Some(b'P'),
        (b'M', 572) => Some(b'D'),
        (b'M', 900) => Some(b'T'),
        _ => None,
    }
}

/// Whether the program stands at `line` until something other than its own motion has happened: heat, homing, a person.
pub fn waits(firmware: Firmware, line: &ParsedLine) -> bool {
    match effect(firmware, line) {
        Effect::Home | Effect::Dwell(_) | Effect::Drain | Effect::HeatWait => true,
        Effect::Heat { waits, .. } => waits,
        Effect::Hazard(Hazard::Counter | Hazard::OutOfBand | Hazard::Output | Hazard::Guard) => false,
        // Who knows what a macro or a tool change does.
        Effect::Hazard(_) => true,
        _ => line.kind == LineKind::Macro,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(firmware: Firmware, text: &str) -> Effect {
        let mut line = ParsedLine::default();
        line.read(text.as_bytes()).unwrap();
        effect(firmware, &line)
    }

    fn marlin(text: &str) -> Effect {
        of(Firmware::Marlin, text)
    }

    #[test]
    fn what_must_not_happen_unseen_is_told_apart() {
        use Hazard::*;
        let cases = [
            (
                Shift,
                "M206 Z5|M428|M290 Z-2|G92 X0|G92|M218 X1|M420 S1|G54|G10 P0 Z5|G10 L2 P1 X0|G10 X1|M851 Z1|M425|G43.4|G43",
            ),
            (Steps, "M92 E100|M665 X1|M350 X16|M502|M501"),
            (Units, "G20|M200 D1.75|M149 F"),
            (Tool, "T1|M6 T1|M605 S1"),
            (MotorsOff, "M84|M18|M84 X|M18 E"),
            (Person, "M0|M1|M600|M25|M226|M601"),
            (Stop, "M112|M999|M524"),
            (End, "M2|M81"),
            (File, "M23 x.g|M24|M28 x.g|M32 x.g|M30 x.g|M928 x"),
            (Counter, "M110 N5"),
            (OutOfBand, "M108|M410|M876"),
            (Moves, "G29|G30|G27|G12|G61|M701|M125|M401|G80"),
            (Guard, "M211 S0|M302 S0|M301 P1|M907 E500|M111 S8|M303"),
            (Output, "M3 S100|M42 P3 S1|M8"),
            (Skips, "M486 P0|M486 C|M486P3"),
            (Unknown, "M7777|M116|G5 X1|SET_GCODE_OFFSET Z=-2|START_PRINT|@pause|M98 P\"x\""),
        ];
        for (hazard, texts) in cases {
            for text in texts.split('|') {
                assert_eq!(marlin(text), Effect::Hazard(hazard), "{text}");
            }
        }
    }

    #[test]
    fn m204_says_how_fast_speeds_change() {
        let of = |firmware, text: &str| {
            let mut line = ParsedLine::default();
            line.read(text.as_bytes()).unwrap();
            accelerations(firmware, &line)
        };
        assert_eq!(of(Firmware::Marlin, "M204 S800"), Some([Some(800.0); 2]));
        assert_eq!(of(Firmware::RepRapFirmware, "M204 P800 T1500"), Some([Some(800.0), Some(1500.0)]));
        assert_eq!(of(Firmware::Marlin, "M204 T1500 R9"), Some([None, Some(1500.0)]));
        assert_eq!(of(Firmware::Marlin, "M204 S0"), Some([None; 2]));
        assert_eq!((of(Firmware::Marlin, "M205 S8"), of(Firmware::Grbl, "M204 S8")), (None, None));
    }

    #[test]
    fn what_is_harmless_is_known_with_its_numbers() {
        let heat = |heater, target_c, waits| Effect::Heat { heater, target_c, waits };
        assert_eq!(marlin("M109 S210"), heat(Heater::Nozzle, Some(210.0), true));
        assert_eq!(marlin("M104 R180"), heat(Heater::Nozzle, Some(180.0), false));
        assert_eq!(marlin("M104 S0 T1"), heat(Heater::OtherNozzle(1), Some(0.0), false));
        assert_eq!(marlin("M190 S60"), heat(Heater::Bed, Some(60.0), true));
        // Without a target it does not wait either; Klipper takes the target for 0, and reads no R.
        assert_eq!(
            (marlin("M109"), marlin("M190")),
            (heat(Heater::Nozzle, None, false), heat(Heater::Bed, None, false))
        );
        for text in ["M109", "M109 R210"] {
            assert_eq!(of(Firmware::Klipper, text), heat(Heater::Nozzle, Some(0.0), true), "{text}");
        }
        assert_eq!(marlin("M106"), Effect::Fan { index: 0, share: 1.0 });
        assert_eq!(marlin("M106 P1 S51"), Effect::Fan { index: 1, share: 0.2 });
        assert_eq!(marlin("M107"), Effect::Fan { index: 0, share: 0.0 });
        assert_eq!(marlin("M221 S95"), Effect::Factor { speed: false, percent: Some(95.0) });
        assert_eq!(marlin("M220 B"), Effect::Factor { speed: true, percent: None });
        assert_eq!(marlin("G4 P1500"), Effect::Dwell(1.5));
        assert_eq!(of(Firmware::LinuxCnc, "G4 P1.5"), Effect::Dwell(1.5));
        for (_, firmware) in Firmware::NAMES {
            for seconds in [0.001, 0.5, 2.347, 600.0] {
                assert_eq!(of(firmware, &dwell_line(firmware, seconds)), Effect::Dwell(seconds), "{firmware:?}");
            }
        }
        for text in ["M204 P800 T1500", "M900 K0.04", "M201 X500", "M155 S2"] {
            assert_eq!(marlin(text), Effect::Setting, "{text}");
        }
        for text in ["M84 S60", "T0", "M200 D0", "M17"] {
            assert_eq!(marlin(text), Effect::Nothing, "{text}");
        }
        for text in ["G1 X5", "G90 G1 X5", "M83", "G92 E0", "X5"] {
            assert_eq!(marlin(text), Effect::Motion, "{text}");
        }
        assert_eq!(
            (marlin("M117 hello M112"), marlin("M486 S1"), marlin("; M112")),
            (Effect::Report, Effect::Label, Effect::Nothing)
        );
        assert_eq!(
            (marlin("M486 T3"), marlin("M486 APlate P0 C"), of(Firmware::LinuxCnc, "G64 P2")),
            (Effect::Label, Effect::Label, Effect::Hazard(Hazard::Blend))
        );
    }

    #[test]
    fn the_same_words_mean_other_things_to_other_firmwares() {
        let rrf = |text| of(Firmware::RepRapFirmware, text);
        assert_eq!(
            rrf("G10 P0 S210 R140"),
            Effect::Heat { heater: Heater::Nozzle, target_c: Some(210.0), waits: false }
        );
        assert_eq!(
            rrf("M568 P0 S215 R140"),
            Effect::Heat { heater: Heater::Nozzle, target_c: Some(215.0), waits: false }
        );
        assert_eq!((rrf("M568 P0 A2"), rrf("M116 P0")), (Effect::Setting, Effect::HeatWait));
        assert_eq!(marlin("M568 S1"), Effect::Hazard(Hazard::Unknown));
        assert_eq!(marlin("G10 S210 P0"), Effect::Hazard(Hazard::Shift));
        assert_eq!(
            (marlin("G10"), rrf("G10"), rrf("G11")),
            (Effect::Retract(true), Effect::Retract(true), Effect::Retract(false))
        );
        assert_eq!(of(Firmware::LinuxCnc, "G10 L2 P1 X0"), Effect::Hazard(Hazard::Shift));
        assert_eq!(rrf("M106 P2 H1 T45"), Effect::Setting);
        // Only Marlin's fork knows it, Marlin says that it does not.
        assert_eq!((marlin("G49"), rrf("G49")), (Effect::Motion, Effect::Hazard(Hazard::Unknown)));
        assert_eq!((rrf("G93"), marlin("G93")), (Effect::Motion, Effect::Hazard(Hazard::Unknown)));
        assert_eq!((of(Firmware::LinuxCnc, "G61"), of(Firmware::LinuxCnc, "G80")), (Effect::Motion, Effect::Motion));
        assert_eq!(of(Firmware::Grbl, "M104 S200"), Effect::Hazard(Hazard::Unknown));
        assert_eq!(rrf("M0"), Effect::Hazard(Hazard::Stop));
        let klipper = |text| of(Firmware::Klipper, text);
        assert_eq!(klipper("SET_GCODE_OFFSET Z=-2"), Effect::Hazard(Hazard::Shift));
        assert_eq!(klipper("set_pressure_advance advance=0.04"), Effect::Setting);
        let heat = Effect::Heat { heater: Heater::Nozzle, target_c: Some(215.0), waits: false };
        assert_eq!(klipper("SET_HEATER_TEMPERATURE HEATER=extruder TARGET=215"), heat);
        let unknown = Effect::Hazard(Hazard::Unknown);
        assert_eq!(klipper("SET_HEATER_TEMPERATURE HEATER=extruder TARGET=nan"), unknown);
        assert_eq!(klipper("EXCLUDE_OBJECT_START NAME='a'"), Effect::Label);
        assert_eq!(klipper("TIMELAPSE_TAKE_FRAME"), Effect::Hazard(Hazard::Moves));
        assert_eq!(klipper("MY_MACRO"), Effect::Hazard(Hazard::Unknown));
        assert_eq!(klipper("G29"), Effect::Hazard(Hazard::Moves));
    }

    #[test]
    fn flavours_name_their_firmware() {
        assert_eq!(Firmware::of_flavor("marlin2"), Some(Firmware::Marlin));
        assert_eq!(Firmware::of_flavor("RepRap (RepRap)"), Some(Firmware::Marlin));
        assert_eq!(Firmware::of_flavor("reprapfirmware"), Some(Firmware::RepRapFirmware));
        assert_eq!(Firmware::of_flavor("no-extrusion"), None);
        for (name, firmware) in Firmware::NAMES {
            assert_eq!((Firmware::named(name), firmware.name()), (Some(firmware), name));
        }
    }

    #[test]
    fn the_program_stands_where_heat_homing_or_a_person_is_waited_for() {
        let wait = |text: &str| {
            let mut line = ParsedLine::default();
            line.read(text.as_bytes()).unwrap();
            waits(Firmware::Marlin, &line)
        };
        for text in ["G28", "G29", "M109 S2", "M190 R1", "M400", "M600", "G4 P5", "T1", "START_PRINT", "M116"] {
            assert!(wait(text), "{text}");
        }
        for text in ["G1 X5", "M104 S200", "M106", "M105", "M204 P500", "M42 P1 S1"] {
            assert!(!wait(text), "{text}");
        }
    }
}
