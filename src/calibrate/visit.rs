//! A G-code file that goes to each chosen pose, cold and slowly, and stops there above the place to be touched.
//!
//! Up to where the table can turn, rotation alone, tilt alone, across, straight down to [`HOVER_MM`] above the touch; then a stop, a
//! person lowers the tip by hand. Every way and every turn is looked at before it is written ([`ClearWay`]). Heat, fans and filament are
//! left out; of the machine's own start lines those stay that only home and set modes.

use std::fmt::Write as _;

use super::clear::ClearWay;
use super::touches::ChainCandidate;
use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Effect, Firmware, ManualStepper};
use crate::geom::Vec3;
use crate::motion::replay::{Controller, Step};
use crate::profile::{FeedReference, Profile};

/// Above the touch, mm: more than any profile is wrong by before it was measured.
pub(super) const HOVER_MM: f64 = 20.0;
/// Never faster, mm/min.
const ACROSS_MM_PER_MIN: f64 = 1500.0;
const DOWN_MM_PER_MIN: f64 = 300.0;
/// Never faster, degrees a minute.
const TURN_DEG_PER_MIN: f64 = 600.0;

/// The file.
#[derive(Clone, Debug, PartialEq)]
pub struct Visit {
    /// Its lines.
    pub gcode: String,
    /// The start lines of the profile that were left out, since they heat or nobody knows what they do.
    pub left_out: Vec<String>,
    /// The height at which the table turns, mm.
    pub height_mm: f64,
}

/// A way that is not clear.
#[derive(Clone, Debug, PartialEq)]
pub struct NoVisit {
    /// The pose's place, from 1.
    pub number: usize,
    /// In words.
    pub why: String,
}

impl std::fmt::Display for NoVisit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "pose {}: {}", self.number, self.why)
    }
}

/// The file that visits `poses` in their order. The table stands level, the rotation at its zero, when it begins.
///
/// # Errors
///
/// [`NoVisit`] with the pose that cannot be come to without the head, the table or the frame meeting.
pub fn visit(profile: &Profile, poses: &[ChainCandidate], names: &[String]) -> Result<Visit, NoVisit> {
    let clear = ClearWay::of(profile);
    let height = turning_height(profile, &clear)?;
    let (tilt, rotation) = (profile.kinematics.tilt.letter, profile.kinematics.rotation.letter);
    let head = format!(
        "; Poses for trunnion profile calibrate: cold, slow, no filament. Nothing may be on the table but marks.\n\
         ; Before it starts: table level, {tilt} and {rotation} as after homing, a hand on the switch.\n\
         ; At each stop lower the tip onto what is named, write down X Y Z, lift it again, and go on.\n"
    );
    let mut writer = Writer::new(profile, height, &head);
    let level = [profile.kinematics.tilt.zero_deg, profile.kinematics.rotation.zero_deg];
    let (mut words, mut at) = (level, None);
    for (index, (pose, name)) in poses.iter().zip(names).enumerate() {
        let stop = |why: String| NoVisit { number: index + 1, why };
        let above = Vec3::new(pose.tip.x, pose.tip.y, height);
        let hover = pose.tip + Vec3::z() * HOVER_MM.min(height - pose.tip.z);
        // The first way comes from a place that nobody knows: it is gone before the table turns.
        let waits = at.unwrap_or(above);
        let between = [words[0], pose.words_deg[1]];
        clear.turns_through([words, between, pose.words_deg], &waits).map_err(stop)?;
        if !clear.passes(pose.words_deg, &waits, &above) || !clear.touchable(pose.words_deg, &pose.tip, height) {
            return Err(stop(format!("cannot prove that the path to X{:.1} Y{:.1} is clear", pose.tip.x, pose.tip.y)));
        }
        let [x, y, z] = [pose.tip.x, pose.tip.y, pose.tip.z].map(|v| (v * 10.0).round() / 10.0 + 0.0);
        writer.says(&format!("{} of {}: touch {name}, near X{x:.1} Y{y:.1} Z{z:.1}", index + 1, poses.len()));
        writer.up(at.is_none().then_some(&Vec3::new(x, y, height)));
        writer.turn(between, pose.words_deg);
        writer.over(&above, &hover);
        writer.pause();
        (words, at) = (pose.words_deg, Some(above));
    }
    if let Some(at) = &at {
        let stop = |why: String| NoVisit { number: poses.len(), why: format!("on the return path, {why}") };
        clear.turns_through([words, [words[0], level[1]], level], at).map_err(stop)?;
    }
    Ok(writer.end(level, at))
}

/// The height of the tip at which the table may turn, mm.
pub(super) fn turning_height(profile: &Profile, clear: &ClearWay) -> Result<f64, NoVisit> {
    let height = (clear.ball_top() + HOVER_MM + profile.transition.clearance_mm).min(profile.limits.z_mm[1]);
    if clear.passes_anywhere(height) {
        return Ok(height);
    }
    let why = format!("cannot prove that the head clears the level table with the tip at Z {height:.1}");
    Err(NoVisit { number: 1, why })
}

/// Writes cold and slow moves.
pub(super) struct Writer<'a> {
    profile: &'a Profile,
    height: f64,
    out: String,
    left_out: Vec<String>,
    words: [Option<f64>; 2],
}

impl<'a> Writer<'a> {
    /// `head` are comments for the person at the machine; the profile's own start lines follow.
    pub(super) fn new(profile: &'a Profile, height: f64, head: &str) -> Self {
        let mut writer = Self { profile, height, out: head.to_owned(), left_out: Vec::new(), words: [None; 2] };
        writer.start();
        writer
    }

    fn start(&mut self) {
        let mut controller = Controller::new(self.profile.reading());
        let mut parsed = ParsedLine::default();
        for line in self.profile.dialect.start.lines().map(str::trim).filter(|line| !line.is_empty()) {
            let filled = line.replace("{nozzle_c}", "0").replace("{bed_c}", "0");
            let cold = parsed.read(filled.as_bytes()).is_ok()
                && controller.step(&parsed).is_ok_and(|step| match step {
                    Step::Effect(effect) => matches!(
                        effect,
                        Effect::Nothing
                            | Effect::Motion
                            | Effect::Home
                            | Effect::Dwell(_)
                            | Effect::Drain
                            | Effect::Setting
                            | Effect::Report
                    ),
                    // A line of its own that primes would do so cold.
                    Step::Move(_) => false,
                    Step::Nothing | Step::ExtruderSet(_) => true,
                });
            if cold {
                self.out.push_str(line);
                self.out.push('\n');
            } else {
                self.left_out.push(line.to_owned());
            }
        }
        self.out.push_str("G21\nG90\n");
    }

    fn z(&mut self, z: f64) {
        let feed = DOWN_MM_PER_MIN.min(self.profile.transition.z_mm_per_min);
        let _ = writeln!(self.out, "G1 Z{z:.3} F{feed}");
    }

    /// A comment.
    pub(super) fn says(&mut self, text: &str) {
        let kept: String = text.chars().filter(|c| c.is_ascii() && !c.is_control()).collect();
        let _ = writeln!(self.out, "; {kept}");
    }

    /// Up to where the table may turn; then to above a place, at the beginning.
    pub(super) fn up(&mut self, first: Option<&Vec3>) {
        let height = self.height;
        self.z(height);
        if let Some(place) = first {
            self.across(place.x, place.y);
        }
    }

    fn across(&mut self, x: f64, y: f64) {
        // No minus before a nought.
        let [x, y] = [x, y].map(|v| (v * 1000.0).round() / 1000.0 + 0.0);
        let feed = ACROSS_MM_PER_MIN.min(self.profile.transition.travel_mm_per_min);
        let _ = writeln!(self.out, "G1 X{x:.3} Y{y:.3} F{feed}");
    }

    /// One axis after the other: rotation, then tilt.
    pub(super) fn turn(&mut self, between: [f64; 2], to: [f64; 2]) {
        let table = self.profile.kinematics();
        let [before_turn, after_turn] = self.profile.transition.around_turn().map(|lines| lines.join("\n"));
        let mut turned = false;
        for (place, axis, word) in [(1, &table.rotation, between[1]), (0, &table.tilt, to[0])] {
            if self.words[place] == Some(word) {
                continue;
            }
            if !std::mem::replace(&mut turned, true) && !before_turn.is_empty() {
                let _ = writeln!(self.out, "{before_turn}");
            }
            if let Some(names) = self.profile.steppers() {
                let speed = (TURN_DEG_PER_MIN / 60.0).min(axis.max_rate.to_degrees());
                let _ = writeln!(self.out, "{}", ManualStepper::go(&names[place], word, speed));
                self.words[place] = Some(word);
                continue;
            }
            let letter = char::from(axis.letter);
            let rate = TURN_DEG_PER_MIN.min(axis.max_rate.to_degrees() * 60.0);
            if self.profile.dialect.feed == FeedReference::InverseTime {
                // From an unknown angle a whole turn is allowed for.
                let way = self.words[place].map_or(360.0, |was| (word - was).abs());
                let _ = writeln!(self.out, "G93 G1 {letter}{word} F{:.4}\nG94", rate / way);
            } else {
                let _ = writeln!(self.out, "G1 {letter}{word} F{rate:.2}");
            }
            self.words[place] = Some(word);
        }
        if turned && !after_turn.is_empty() {
            let _ = writeln!(self.out, "{after_turn}");
        }
    }

    /// Across to `above` and down to `hover`.
    pub(super) fn over(&mut self, above: &Vec3, hover: &Vec3) {
        self.across(above.x, above.y);
        self.z(hover.z);
    }

    /// Waits for a person.
    pub(super) fn pause(&mut self) {
        self.out.push_str(match self.profile.firmware() {
            Firmware::Klipper => "PAUSE\n",
            Firmware::RepRapFirmware => "M226\n",
            _ => "M0\n",
        });
    }

    /// The file, at its end up and level again.
    pub(super) fn end(mut self, level: [f64; 2], at: Option<Vec3>) -> Visit {
        if at.is_some() {
            self.out.push_str("; done: up, and the table level again\n");
            let height = self.height;
            self.z(height);
            self.turn(level, level);
            if self.profile.firmware() == Firmware::LinuxCnc {
                self.out.push_str("M2\n");
            }
        }
        Visit { gcode: self.out, left_out: self.left_out, height_mm: self.height }
    }
}
