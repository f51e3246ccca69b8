//! Which axis of a connected machine does what: moved by a little, one at a time, while a person looks.

use std::fmt::Write;
use std::path::Path;

use toml::Value;

use super::error::MachineError;
use super::means::Means;
use super::read::MachineAt;
use crate::calibrate::{ClearWay, JOG_DEG, JOG_MM, Jog, JogFault, JogQuestion, JogSubject, Jogged, Seen};
use crate::gcode::meaning::Firmware;
use crate::input::{LoadedProfile, MachineSource, load_profile};
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
    let machine = load_profile(&request.machine, world)?;
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
    let mut done = JogResult { changes: changes(profile, &jogged), jogged, date, unfit: None, machine };
    done.unfit = done.written().validate().err().map(|error| error.to_string());
    Ok(done)
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
    fn register(&mut self) -> Result<(), MachineError> {
        let value = |line: &str, word: &str| -> Option<String> {
            line.split_ascii_whitespace().find_map(|own| own.strip_prefix(word)).map(str::to_owned)
        };
        let own = self.profile.dialect.start.lines().map(str::trim).filter(|line| {
            let known = value(line, "GCODE_AXIS=").is_some() || value(line, "SET_POSITION=").is_some();
            line.starts_with("MANUAL_STEPPER ") && known && value(line, "MOVE=").is_none()
        });
        let mut lines: Vec<String> = own.map(str::to_owned).collect();
        // What commands turn counts from where it stands.
        let steppers = self.profile.steppers().into_iter().flatten();
        lines.extend(steppers.map(|name| format!("MANUAL_STEPPER STEPPER={name} SET_POSITION=0")));
        let axes = lines.iter().filter(|line| value(line, "GCODE_AXIS=").is_some());
        self.axes = axes
            .filter_map(|line| Some(format!("MANUAL_STEPPER STEPPER={} GCODE_AXIS=", value(line, "STEPPER=")?)))
            .collect();
        self.axes.dedup();
        for line in self.axes.clone().iter().chain(&lines) {
            self.means.run(line)?;
        }
        self.at.extend(self.words_set(&lines, &value));
        Ok(())
    }

    /// The words at which lines have just put Klipper's motors.
    fn words_set(&self, lines: &[String], value: &dyn Fn(&str, &str) -> Option<String>) -> Vec<(char, f64)> {
        let k = &self.profile.kinematics;
        let of = |motor: &str, which: usize, letter: char| {
            let named = self.profile.steppers().is_some_and(|both| both[which] == motor);
            let registered = lines.iter().any(|line| {
                value(line, "STEPPER=").as_deref() == Some(motor)
                    && value(line, "GCODE_AXIS=").as_deref() == Some(letter.to_string().as_str())
            });
            named || registered
        };
        let mut words = Vec::new();
        for line in lines {
            let (Some(motor), Some(at)) = (value(line, "STEPPER="), value(line, "SET_POSITION=")) else { continue };
            let Ok(at) = at.parse::<f64>() else { continue };
            for (which, letter) in [k.tilt.letter, k.rotation.letter].into_iter().enumerate() {
                if of(&motor, which, letter) {
                    words.push((letter, at));
                }
            }
        }
        words
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
        let reach = self.profile.table_slab().into_iter().map(|p| p.x.hypot(p.y)).fold(0.0, f64::max);
        let tilted = k.pivot_mm[2] + k.offset_mm[2] + reach * JOG_DEG.to_radians().sin() + ABOVE_MM;
        let swept = ClearWay::of(self.profile).ball_top() + ABOVE_MM;
        swept.min(self.profile.limits.z_mm[1] - NEAR_MM).max(tilted)
    }

    fn step(&mut self, axis: char, by: f64) -> Result<(), MachineError> {
        if let Some(name) = self.stepper(axis) {
            return self.turn(&name, by);
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
            return self.turn(&name, 0.0);
        }
        let Some(word) = self.word(axis) else { return self.step(axis, -by) };
        self.means.run(&format!("G1 {axis}{word} F{}", feed(axis)))?;
        self.means.run(self.means.protocol().drain())
    }

    /// Klipper's motor of an axis that commands turn; its zero is where it stood.
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

/// The keys that the machine contradicts.
fn changes(profile: &Profile, jogged: &Jogged) -> Vec<JogChange> {
    let (tilt, rotation) = (&profile.kinematics.tilt, &profile.kinematics.rotation);
    let mut all = Vec::new();
    let mut change = |key, was: String, seen: Value, differs: bool| {
        if differs {
            all.push(JogChange { key, was, seen });
        }
    };
    let about = if tilt.about == TiltAxisName::X { 'X' } else { 'Y' };
    let word = |letter: char| Value::String(letter.to_string());
    match profile.steppers() {
        // Letters are but labels there.
        Some([tilts, turns]) => {
            let other = jogged.tilt == rotation.letter;
            change("kinematics.tilt.stepper", tilts.clone(), Value::String(turns.clone()), other);
            change("kinematics.rotation.stepper", turns, Value::String(tilts), other);
        }
        None => {
            change("kinematics.tilt.letter", tilt.letter.to_string(), word(jogged.tilt), tilt.letter != jogged.tilt);
            let (was, seen) = (rotation.letter, jogged.rotation);
            change("kinematics.rotation.letter", was.to_string(), word(seen), was != seen);
        }
    }
    change("kinematics.tilt.about", about.to_string(), word(jogged.about), about != jogged.about);
    for (key, was, seen) in [
        ("kinematics.tilt.direction", tilt.direction, jogged.tilt_direction),
        ("kinematics.rotation.direction", rotation.direction, jogged.rotation_direction),
    ] {
        change(key, was.to_string(), Value::Integer(seen.into()), was != seen);
    }
    if let Some(level) = jogged.level_deg {
        let off = (level - tilt.zero_deg).abs() > LEVEL_DEG;
        change("kinematics.tilt.zero_deg", tilt.zero_deg.to_string(), Value::Float(level), off);
    }
    all
}

impl JogResult {
    /// The profile with what was seen.
    fn written(&self) -> Profile {
        let mut profile = self.machine.profile.clone();
        let (tilt, rotation) = (&mut profile.kinematics.tilt, &mut profile.kinematics.rotation);
        match (&mut tilt.stepper, &mut rotation.stepper) {
            (Some(tilts), Some(turns)) => {
                if self.jogged.tilt == rotation.letter {
                    std::mem::swap(tilts, turns);
                }
            }
            _ => (tilt.letter, rotation.letter) = (self.jogged.tilt, self.jogged.rotation),
        }
        tilt.about = if self.jogged.about == 'X' { TiltAxisName::X } else { TiltAxisName::Y };
        (tilt.direction, rotation.direction) = (self.jogged.tilt_direction, self.jogged.rotation_direction);
        if let Some(change) = self.changes.iter().find(|change| change.key == "kinematics.tilt.zero_deg") {
            tilt.zero_deg = change.seen.as_float().unwrap_or(tilt.zero_deg);
        }
        profile.machine.jogged = Some(self.date.clone());
        profile.machine.jogged_as = Some(profile.axes_in_words(self.jogged.level_deg.is_some()));
        profile
    }

    /// A profile that extends the machine's, kept in the folder `kept_in`; without one, its keys alone.
    pub fn profile(&self, kept_in: Option<&Path>, world: &World<'_>) -> String {
        let written = self.written().machine;
        let mut out =
            format!("# What each axis does was seen on the machine on {} (trunnion machine jog).\n", self.date);
        if kept_in.is_some() {
            let _ = writeln!(out, "extends = {:?}", self.machine.reference(kept_in, world).profile);
        }
        let text = |text: Option<String>| Value::String(text.unwrap_or_default());
        let _ =
            writeln!(out, "\n[machine]\njogged = {}\njogged_as = {}", text(written.jogged), text(written.jogged_as));
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
