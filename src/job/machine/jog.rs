//! Which axis of a connected machine does what: moved by a little, one at a time, while a person looks.

use std::fmt::Write;
use std::path::Path;

use toml::Value;

use super::error::MachineError;
use super::means::Means;
use super::read::MachineAt;
use crate::calibrate::{ClearWay, JOG_DEG, JOG_MM, Jog, JogFault, JogQuestion, JogSubject, Jogged, Seen};
use crate::gcode::meaning::Firmware;
use crate::input::{LoadedProfile, MachineSource, load_table};
use crate::job::printer::{PrinterError, protocol};
use crate::profile::{Profile, TiltAxisName};
use crate::world::World;

/// As fast as X and Y go, mm/min.
const FEED: f64 = 600.0;
/// As fast as Z goes, mm/min, and the table turns, degrees a minute.
const SLOWLY: f64 = 300.0;
/// A nozzle that is warmer may drip, or burn whoever leans over it, degrees Celsius.
const COLD_C: f64 = 50.0;
/// What the head keeps above the rim of a table that tilts by the test's step, mm.
const ABOVE_MM: f64 = 20.0;
/// Where Z ends below all that the table sweeps, the head begins within this of its end, mm.
const NEAR_MM: f64 = 30.0;
/// A zero that is seen with a level is no better than this, degrees: a nearer one of the profile stays.
const LEVEL_DEG: f64 = 0.5;

/// A machine to be tried.
#[derive(Clone, Debug)]
pub struct JogRequest {
    /// Its profile.
    pub machine: MachineSource,
    /// Where it is; a port without a speed has the profile's.
    pub at: MachineAt,
}

/// A key that the machine contradicts.
#[derive(Clone, Debug, PartialEq)]
pub struct JogChange {
    /// Its path.
    pub key: &'static str,
    /// As the profile has it.
    pub was: String,
    /// As it was seen.
    pub seen: Value,
}

/// What was seen.
#[derive(Clone, Debug)]
pub struct JogResult {
    /// The machine as its profile has it.
    pub machine: LoadedProfile,
    /// What its axes do.
    pub jogged: Jogged,
    /// Where the profile has it otherwise.
    pub changes: Vec<JogChange>,
    /// The day, as `2026-11-28`.
    pub date: String,
    /// Why the profile with these keys cannot be; `None` where it can.
    pub unfit: Option<String>,
    /// The profile with them.
    written: Profile,
}

/// Moves each axis of a machine by a little and asks what was seen; `ask` puts a question, and gives `None` where nobody answers.
///
/// An axis goes back as soon as its question is answered, and where the answers end.
///
/// # Errors
///
/// [`MachineError::Jog`] for a test that tells nothing, [`MachineError::Answer`] where the answers end, [`MachineError::Printer`] for a port or a
/// printer that fails, and what a profile may be refused for. Nothing is proved then.
pub fn jog(
    request: &JogRequest,
    ask: &dyn Fn(&JogQuestion, &Profile) -> Option<Seen>,
    world: &World<'_>,
) -> Result<JogResult, MachineError> {
    let machine = load_table(&request.machine, world)?;
    let profile = &machine.profile;
    let wanted = protocol(profile)?;
    let means = Means::open(&request.at, profile.link.baud, world)?;
    if means.protocol() != wanted {
        let (found, wanted) = (means.firmware().name(), profile.firmware().name());
        return Err(JogFault::OtherFirmware { found: found.to_owned(), wanted: wanted.to_owned() }.into());
    }
    let mut hand = Hand { means, profile, at: Vec::new(), axes: Vec::new() };
    let letters = hand.letters()?;
    let mut jog = Jog::new(&letters);
    let tried = hand.all(&mut jog, ask);
    // Klipper's motors are let go, whatever came of it: its own macros move none that is an axis.
    let freed = hand.free();
    tried?;
    freed?;
    let (jogged, date) = (jog.found()?, world.clock.today().unwrap_or_else(|| "unknown".to_owned()));
    let written = written(profile, &jogged, &date);
    let unfit = written.validate().err().map(|error| error.to_string());
    Ok(JogResult { changes: changes(profile, &written), jogged, date, unfit, written, machine })
}

/// Whoever moves the axes.
struct Hand<'a> {
    means: Means<'a>,
    profile: &'a Profile,
    /// Where the axes stood when the test began, by their words; what is not known is not here.
    at: Vec<(char, f64)>,
    /// Lines that make axes of Klipper's motors no axes again.
    axes: Vec<String>,
}

impl Hand<'_> {
    /// All questions to the end.
    fn all(&mut self, jog: &mut Jog, ask: &dyn Fn(&JogQuestion, &Profile) -> Option<Seen>) -> Result<(), MachineError> {
        while let Some(mut question) = jog.question() {
            if question.step != 0.0 {
                question.step *= self.way(question.axis, question.step)?;
                self.step(question.axis, question.step)?;
            }
            if question.subject == JogSubject::Level {
                question.word = self.word(question.axis);
            }
            let seen = ask(&question, self.profile);
            if question.step != 0.0 {
                self.back(question.axis, question.step)?;
            }
            let seen = seen.ok_or_else(|| MachineError::Answer {
                what: if question.axis == ' ' { "ready".to_owned() } else { question.axis.to_string() },
                why: "no answer; nothing was written".to_owned(),
            })?;
            let forwards = if question.step < 0.0 { seen.opposite() } else { seen };
            jog.answer(forwards, question.word)?;
            if question.subject == JogSubject::Ready {
                self.begin()?;
            }
        }
        Ok(())
    }

    /// The rotary axes: what the machine has beside X, Y, Z and its extruder; where it does not tell, those of the profile.
    fn letters(&mut self) -> Result<Vec<char>, MachineError> {
        let mut all = self.all_letters()?;
        all.retain(|letter| !"XYZ".contains(*letter) && *letter != self.profile.dialect.extruder);
        all.sort_unstable();
        if all.len() < 2 {
            let which = if all.is_empty() { "no axis".to_owned() } else { format!("only {}", all[0]) };
            return Err(JogFault::OtherTable { found: format!("the printer has {which} besides X, Y and Z") }.into());
        }
        Ok(all)
    }

    fn all_letters(&mut self) -> Result<Vec<char>, MachineError> {
        let k = &self.profile.kinematics;
        let own = vec![k.tilt.letter, k.rotation.letter];
        if self.means.firmware() == Firmware::Klipper || self.profile.steppers().is_some() {
            return Ok(own);
        }
        if self.means.firmware() == Firmware::Grbl {
            let all = self.means.order();
            return Ok(all.map_or(own, |all| all.chars().collect()));
        }
        Ok(self.means.position()?.into_iter().map(|(letter, _)| letter).collect())
    }

    fn word(&self, axis: char) -> Option<f64> {
        self.at.iter().find(|(letter, _)| *letter == axis).map(|(_, at)| *at)
    }

    /// 1 where a step forwards stays within the axis' ends, else -1 where one backwards does.
    fn way(&self, axis: char, step: f64) -> Result<f64, MachineError> {
        let Some(word) = self.word(axis) else { return Ok(1.0) };
        let room = self.profile.linear_limits();
        let (tilt, rotation) = (&self.profile.kinematics.tilt, &self.profile.kinematics.rotation);
        let ends = match axis {
            'X' => [room.min.x, room.max.x],
            'Y' => [room.min.y, room.max.y],
            'Z' => [self.above().max(room.min.z), room.max.z],
            axis if axis == tilt.letter => [tilt.min_deg, tilt.max_deg],
            axis if axis == rotation.letter => rotation.stops_deg().unwrap_or([f64::NEG_INFINITY, f64::INFINITY]),
            // No profile knows its ends: towards zero there is room.
            _ => return Ok(if word > 0.0 { -1.0 } else { 1.0 }),
        };
        match ends {
            [low, high] if word >= low && word + step <= high => Ok(1.0),
            [low, high] if word <= high && word - step >= low => Ok(-1.0),
            [low, high] => Err(JogFault::NoRoom { axis, word, low, high: high - step }.into()),
        }
    }

    /// Looks where everything stands and whether it is cold, brings the firmware to the units that are meant, and makes axes of Klipper's motors
    /// where that is what the start code does.
    fn begin(&mut self) -> Result<(), MachineError> {
        match self.means.hottest()? {
            Some(c) if c <= COLD_C => {}
            Some(c) => return Err(JogFault::Hot { c, allowed: COLD_C }.into()),
            None => return Err(JogFault::NoTemperature.into()),
        }
        self.millimetres()?;
        self.at = self.means.position()?;
        if let Some(axis) = "XYZ".chars().find(|axis| self.word(*axis).is_none()) {
            // Only of what turns it may be untold, as of Klipper's motors.
            return Err(JogFault::NoPlace { axis }.into());
        }
        self.register()?;
        let k = &self.profile.kinematics;
        for (axis, step) in
            [('X', JOG_MM), ('Y', JOG_MM), ('Z', JOG_MM), (k.tilt.letter, JOG_DEG), (k.rotation.letter, JOG_DEG)]
        {
            self.way(axis, step)?;
        }
        Ok(())
    }

    /// Millimetres, a minute, and axes that the firmware does not move by itself.
    fn millimetres(&mut self) -> Result<(), MachineError> {
        match self.means.firmware() {
            Firmware::Grbl => ["G21", "G94", "G49"].into_iter().try_for_each(|line| self.means.run(line))?,
            Firmware::RepRapFirmware => self.means.run("G21")?,
            Firmware::Klipper => {}
            // One that knows no inches does not know it.
            _ => match self.means.run("G21") {
                Err(MachineError::Printer(PrinterError::Refuses { .. })) => {}
                done => done?,
            },
        }
        let follows = self.profile.dialect.start.lines().any(|line| line.trim() == "G49");
        if follows { self.means.run("G49") } else { Ok(()) }
    }

    /// Makes Klipper's motors axes as the start code does. It refuses one that is an axis already.
    ///
    /// Where the start code says what a motor's word is and moves it nowhere, that is its word now, with the table level; of a motor that it homes
    /// the word is unknown here.
    fn register(&mut self) -> Result<(), MachineError> {
        let start: Vec<MotorLine> = self.profile.dialect.start.lines().filter_map(MotorLine::read).collect();
        let homed = |motor: &str| start.iter().any(|line| line.motor == motor && line.moves);
        let stands = |motor: &str| {
            let own = start.iter().rev().filter(|line| line.motor == motor && !homed(motor));
            own.filter_map(|line| line.position).next()
        };
        let letter = |motor: &str| start.iter().find_map(|line| line.letter.filter(|_| line.motor == motor));
        let k = &self.profile.kinematics;
        let steppers = self.profile.steppers().map(|names| [k.tilt.letter, k.rotation.letter].into_iter().zip(names));
        let axes = start.iter().filter_map(|line| Some((line.letter?, line.motor.clone())));
        let motors: Vec<(char, String)> = steppers.map_or_else(|| axes.collect(), Iterator::collect);
        let mut lines = Vec::new();
        for (axis, motor) in &motors {
            let of = format!("MANUAL_STEPPER STEPPER={motor}");
            self.axes.extend(letter(motor).map(|_| format!("{of} GCODE_AXIS=")));
            let word = stands(motor);
            self.at.extend(word.map(|word| (*axis, word)));
            // What commands turn counts from somewhere in any case.
            let from = word.or(self.profile.steppers().map(|_| 0.0));
            lines.extend(from.map(|word| format!("{of} SET_POSITION={word}")));
        }
        let registers = start.iter().filter(|line| line.letter.is_some()).map(|line| line.text.clone());
        lines.extend(registers);
        for line in self.axes.clone().iter().chain(&lines) {
            self.means.run(line)?;
        }
        Ok(())
    }

    /// Ends what [`Hand::register`] began.
    fn free(&mut self) -> Result<(), MachineError> {
        for line in std::mem::take(&mut self.axes) {
            self.means.run(&line)?;
        }
        Ok(())
    }

    /// The lowest Z to begin at: above all that the table may sweep, since an axis may turn farther than it is told; where Z ends below that,
    /// near its end, and in any case above a table that tilts by the test's step.
    fn above(&self) -> f64 {
        let k = &self.profile.kinematics;
        let tilted =
            k.pivot_mm[2] + k.offset_mm[2] + self.profile.table_reach_mm() * JOG_DEG.to_radians().sin() + ABOVE_MM;
        let swept = ClearWay::of(self.profile).ball_top() + ABOVE_MM;
        swept.min(self.profile.limits.z_mm[1] - NEAR_MM).max(tilted)
    }

    fn step(&mut self, axis: char, by: f64) -> Result<(), MachineError> {
        if let Some(name) = self.stepper(axis) {
            return self.turn(&name, self.word(axis).unwrap_or(0.0) + by);
        }
        self.means.run("G91")?;
        let moved = self.means.run(&format!("G1 {axis}{by} F{}", feed(axis)));
        // Absolute again, whatever becomes of the move.
        let absolute = self.means.run("G90");
        moved?;
        absolute?;
        self.means.run(self.means.protocol().drain())
    }

    /// To where the axis stood: a step that was cut short at an end would go back too far.
    fn back(&mut self, axis: char, by: f64) -> Result<(), MachineError> {
        if let Some(name) = self.stepper(axis) {
            return self.turn(&name, self.word(axis).unwrap_or(0.0));
        }
        let Some(word) = self.word(axis) else { return self.step(axis, -by) };
        self.means.run(&format!("G1 {axis}{word} F{}", feed(axis)))?;
        self.means.run(self.means.protocol().drain())
    }

    /// Klipper's motor of an axis that commands turn; it counts from its word, or from 0 where that is unknown.
    fn stepper(&self, axis: char) -> Option<String> {
        let k = &self.profile.kinematics;
        let [tilt, rotation] = self.profile.steppers()?;
        match axis {
            axis if axis == k.tilt.letter => Some(tilt),
            axis if axis == k.rotation.letter => Some(rotation),
            _ => None,
        }
    }

    fn turn(&mut self, name: &str, to: f64) -> Result<(), MachineError> {
        self.means.run(&format!("MANUAL_STEPPER STEPPER={name} SPEED={} MOVE={to}", SLOWLY / 60.0))
    }
}

/// So fast an axis is moved, mm or degrees a minute.
fn feed(axis: char) -> f64 {
    if "XY".contains(axis) { FEED } else { SLOWLY }
}

/// A line of start code on one of Klipper's motors.
struct MotorLine {
    motor: String,
    /// The letter that it gives.
    letter: Option<char>,
    /// Where it says that the motor stands.
    position: Option<f64>,
    /// Whether it moves the motor.
    moves: bool,
    text: String,
}

impl MotorLine {
    fn read(line: &str) -> Option<Self> {
        let mut words = line.split(['#', ';']).next()?.split_ascii_whitespace();
        words.next().filter(|word| word.eq_ignore_ascii_case("MANUAL_STEPPER"))?;
        let pairs: Vec<(String, &str)> = words
            .filter_map(|word| word.split_once('='))
            .map(|(key, value)| (key.to_ascii_uppercase(), value))
            .collect();
        let get = |name: &str| pairs.iter().find(|(key, _)| key == name).map(|(_, value)| *value);
        Some(Self {
            motor: get("STEPPER")?.to_owned(),
            letter: get("GCODE_AXIS").and_then(|value| value.chars().next()).map(|letter| letter.to_ascii_uppercase()),
            position: get("SET_POSITION").and_then(|value| value.parse().ok()),
            moves: get("MOVE").is_some(),
            text: line.trim().to_owned(),
        })
    }
}

/// The keys in which two profiles of one machine differ, as far as a test of the axes tells them.
fn changes(was: &Profile, seen: &Profile) -> Vec<JogChange> {
    let values = |profile: &Profile| -> [(&'static str, Option<Value>); 8] {
        let (tilt, rotation) = (&profile.kinematics.tilt, &profile.kinematics.rotation);
        let name = |stepper: &Option<String>| stepper.clone().map(Value::String);
        let about = if tilt.about == TiltAxisName::X { "X" } else { "Y" };
        [
            ("kinematics.tilt.letter", Some(Value::String(tilt.letter.to_string()))),
            ("kinematics.tilt.stepper", name(&tilt.stepper)),
            ("kinematics.tilt.about", Some(Value::String(about.to_owned()))),
            ("kinematics.tilt.direction", Some(Value::Integer(tilt.direction.into()))),
            ("kinematics.tilt.zero_deg", Some(Value::Float(tilt.zero_deg))),
            ("kinematics.rotation.letter", Some(Value::String(rotation.letter.to_string()))),
            ("kinematics.rotation.stepper", name(&rotation.stepper)),
            ("kinematics.rotation.direction", Some(Value::Integer(rotation.direction.into()))),
        ]
    };
    let both = values(was).into_iter().zip(values(seen)).filter(|((_, was), (_, seen))| was != seen);
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    both.filter_map(|((key, was), (_, seen))| Some(JogChange { key, was: text(&was?), seen: seen? })).collect()
}

/// The profile with what was seen.
fn written(profile: &Profile, jogged: &Jogged, date: &str) -> Profile {
    let mut profile = profile.clone();
    let (tilt, rotation) = (&mut profile.kinematics.tilt, &mut profile.kinematics.rotation);
    match (&mut tilt.stepper, &mut rotation.stepper) {
        // Letters are but labels there.
        (Some(tilts), Some(turns)) => {
            if jogged.tilt == rotation.letter {
                std::mem::swap(tilts, turns);
            }
        }
        _ => (tilt.letter, rotation.letter) = (jogged.tilt, jogged.rotation),
    }
    tilt.about = if jogged.about == 'X' { TiltAxisName::X } else { TiltAxisName::Y };
    (tilt.direction, rotation.direction) = (jogged.tilt_direction, jogged.rotation_direction);
    tilt.zero_deg = jogged.level_deg.filter(|level| (level - tilt.zero_deg).abs() > LEVEL_DEG).unwrap_or(tilt.zero_deg);
    profile.machine.jogged = Some(date.to_owned());
    profile.machine.jogged_as = Some(profile.axes_in_words(jogged.level_deg.is_some()));
    profile
}

impl JogResult {
    /// A profile that extends the machine's, kept in the folder `kept_in`; without one, its keys alone.
    pub fn profile(&self, kept_in: Option<&Path>, world: &World<'_>) -> String {
        let written = &self.written.machine;
        let mut out =
            format!("# What each axis does was seen on the machine on {} (trunnion machine jog).\n", self.date);
        if kept_in.is_some() {
            let _ = writeln!(out, "extends = {:?}", self.machine.reference(kept_in, world).profile);
        }
        let text = |text: &Option<String>| Value::String(text.clone().unwrap_or_default());
        let _ =
            writeln!(out, "\n[machine]\njogged = {}\njogged_as = {}", text(&written.jogged), text(&written.jogged_as));
        for section in ["kinematics.tilt", "kinematics.rotation"] {
            let of = |change: &&JogChange| change.key.rsplit_once('.').is_some_and(|(of, _)| of == section);
            for (i, change) in self.changes.iter().filter(of).enumerate() {
                if i == 0 {
                    let _ = writeln!(out, "\n[{section}]");
                }
                let name = change.key.rsplit('.').next().unwrap_or_default();
                let _ = writeln!(out, "{name} = {}  # {} before", change.seen, change.was);
            }
        }
        out
    }
}
