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
use crate::job::printer::protocol;
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
/// An axis goes back as soon as its question is answered, and stays where it is while nobody answers.
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
    let mut hand = Hand { means, profile };
    let letters = hand.letters()?;
    let mut jog = Jog::new(&letters);
    while let Some(mut question) = jog.question() {
        if question.step != 0.0 {
            hand.step(question.axis, question.step)?;
        }
        if question.subject == JogSubject::Level {
            question.word = hand.word(question.axis)?;
        }
        let seen = ask(&question, profile).ok_or_else(|| MachineError::Answer {
            what: question.axis.to_string(),
            why: "no answer; the axis stays where it is, and nothing was written".to_owned(),
        })?;
        if question.step != 0.0 {
            hand.step(question.axis, -question.step)?;
        }
        jog.answer(seen, question.word)?;
        if question.subject == JogSubject::Ready {
            hand.begin()?;
        }
    }
    let (jogged, date) = (jog.found()?, world.clock.today().unwrap_or_else(|| "unknown".to_owned()));
    let mut done = JogResult { changes: changes(profile, &jogged), jogged, date, unfit: None, machine };
    done.unfit = done.written().validate().err().map(|error| error.to_string());
    Ok(done)
}

/// Whoever moves the axes.
struct Hand<'a> {
    means: Means<'a>,
    profile: &'a Profile,
}

impl Hand<'_> {
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

    fn word(&mut self, axis: char) -> Result<Option<f64>, MachineError> {
        Ok(self.means.position()?.into_iter().find(|(letter, _)| *letter == axis).map(|(_, at)| at))
    }

    /// Looks whether a step of each axis is safe, and makes the rotary axes axes where that is what the start code does.
    fn begin(&mut self) -> Result<(), MachineError> {
        self.cold()?;
        let at = self.means.position()?;
        let room = self.profile.linear_limits();
        let (tilt, rotation) = (&self.profile.kinematics.tilt, &self.profile.kinematics.rotation);
        let stops = rotation.stops_deg().unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let above = self.above();
        for (axis, low, high, step) in [
            ('X', room.min.x, room.max.x, JOG_MM),
            ('Y', room.min.y, room.max.y, JOG_MM),
            ('Z', above, room.max.z, JOG_MM),
            (tilt.letter, tilt.min_deg, tilt.max_deg, JOG_DEG),
            (rotation.letter, stops[0], stops[1], JOG_DEG),
        ] {
            let Some((_, word)) = at.iter().find(|(letter, _)| *letter == axis) else {
                // Only of what turns it may be untold, as Klipper's motors are.
                if "XYZ".contains(axis) {
                    return Err(JogFault::NoPlace { axis }.into());
                }
                continue;
            };
            if *word < low || word + step > high {
                return Err(JogFault::NoRoom { axis, word: *word, low, high: high - step }.into());
            }
        }
        self.register()
    }

    /// Makes Klipper's motors axes as the start code does. It refuses one that is an axis already.
    fn register(&mut self) -> Result<(), MachineError> {
        let names = |line: &str, word: &str| line.split_ascii_whitespace().any(|own| own.starts_with(word));
        let lines = self.profile.dialect.start.lines().map(str::trim).filter(|line| {
            let known = names(line, "GCODE_AXIS=") || names(line, "SET_POSITION=");
            line.starts_with("MANUAL_STEPPER ") && known && !names(line, "MOVE=")
        });
        let motor =
            |line: &str| line.split_ascii_whitespace().find(|word| word.starts_with("STEPPER=")).map(str::to_owned);
        let free = |motor: String| format!("MANUAL_STEPPER {motor} GCODE_AXIS=");
        let lines: Vec<String> = lines.map(str::to_owned).collect();
        let axes = lines.iter().filter(|line| names(line, "GCODE_AXIS=")).filter_map(|line| motor(line)).map(free);
        // What commands turn counts from where it stands.
        let own = self.profile.steppers().into_iter().flatten();
        let zeros = own.map(|name| format!("MANUAL_STEPPER STEPPER={name} SET_POSITION=0"));
        let zeros: Vec<String> = zeros.collect();
        for line in axes.collect::<Vec<_>>().iter().chain(&lines).chain(&zeros) {
            self.means.run(line)?;
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

    fn cold(&mut self) -> Result<(), MachineError> {
        match self.means.nozzle()?.filter(|heat| heat.iter().any(|c| *c > COLD_C)) {
            Some([now, wanted]) => Err(JogFault::Hot { c: now.max(wanted), allowed: COLD_C }.into()),
            None => Ok(()),
        }
    }

    fn step(&mut self, axis: char, by: f64) -> Result<(), MachineError> {
        let k = &self.profile.kinematics;
        let stepper = self.profile.steppers().and_then(|[tilt, rotation]| match axis {
            axis if axis == k.tilt.letter => Some(tilt),
            axis if axis == k.rotation.letter => Some(rotation),
            _ => None,
        });
        let wait = self.means.protocol().drain();
        if let Some(name) = stepper {
            let to = if by > 0.0 { by } else { 0.0 };
            self.means.run(&format!("MANUAL_STEPPER STEPPER={name} SPEED={} MOVE={to}", SLOWLY / 60.0))?;
        } else {
            let feed = if "XY".contains(axis) { FEED } else { SLOWLY };
            self.means.run("G91")?;
            // Absolute again, whatever becomes of the move.
            let moved = self.means.run(&format!("G1 {axis}{by} F{feed}"));
            self.means.run("G90")?;
            moved?;
        }
        self.means.run(wait)
    }
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
        profile.machine.jogged_as = Some(profile.axes_in_words());
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
