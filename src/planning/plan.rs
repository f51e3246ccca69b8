//! The plan file: decisions only, versioned JSON, with the hashes of what it was made for.

use serde::{Deserialize, Serialize};

use crate::gcode::round_to;
use crate::geom::{Dir, Table, Vec3};
use crate::location::Location;
use crate::motion::{Pose, TableKinematics};
use crate::profile::Profile;

/// A plan as DESIGN section 4 writes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Always [`Plan::FORMAT`].
    pub format: String,
    /// Always [`Plan::VERSION`].
    pub version: u32,
    /// Program and version.
    pub made_by: String,
    /// The model.
    pub model: ModelRef,
    /// The machine.
    pub machine: MachineRef,
    /// Where the model stands on the table.
    pub placement: Placement,
    /// What lines may span, mm, where that is not the machine's own `process.bridge_mm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bridge_mm: Option<f64>,
    /// The parts, by id.
    pub parts: Vec<PartRef>,
    /// The slots, in order.
    pub slots: Vec<TimeSlot>,
    /// All values of a machine that is not a shipped one: a slicer's script runs in a folder of its own, where the profile's file
    /// is not to be found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine_values: Option<Box<Profile>>,
}

/// The model a plan was made for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelRef {
    /// Its path: from the plan's folder, else as given.
    pub file: String,
    /// The hash of its bytes.
    pub sha256: String,
    /// The unit it was read in.
    pub unit: String,
}

/// The machine a plan was made for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachineRef {
    /// The profile's name, or its path from the plan's folder, else as given.
    pub profile: String,
    /// The hash of the resolved profile.
    pub sha256: String,
}

/// `p_table = Rz(turn) p_object + origin`
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// Where the file's origin comes to lie on the table, mm.
    pub origin_mm: [f64; 3],
    /// The turn about the table's normal.
    pub turn_deg: f64,
}

/// A part by number and name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartRef {
    /// Its number in the model.
    pub id: usize,
    /// Its name.
    pub name: String,
}

/// A time slot. Its prints are grouped by pose: the poses follow each other in the order of their first print, and the
/// parts of one pose grow together, layer by layer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeSlot {
    /// Its number, from 0.
    pub id: usize,
    /// What is printed in it.
    pub prints: Vec<Print>,
}

/// One part printed at one pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Print {
    /// The part.
    pub part: usize,
    /// The build direction, table frame.
    pub up: [f64; 3],
    /// The tilt's word, degrees.
    pub tilt_deg: f64,
    /// The rotation's word, degrees; may count more than one turn.
    pub rotation_deg: f64,
    /// What holds it while it is printed; `None`: it needs nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub supports: Option<PrintSupports>,
}

/// Supports that are printed with a part, in its setup and before it in each layer. They are a print of their own; their numbers follow
/// those of all parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrintSupports {
    /// Edge of the cubes of the grid in which they are planned, mm.
    pub step_mm: f64,
    /// Surfaces up to this angle from the vertical hold themselves.
    pub overhang_deg: f64,
    /// Air between a support and what lies on it, mm.
    pub gap_mm: f64,
    /// The roof below what they hold; `None`: they have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub roof: Option<SupportRoof>,
    /// Over so much of its height a column may stand free of others, mm; `None`: over any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brace_mm: Option<f64>,
    /// Whether there are no columns, and all is propped.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub only_props: bool,
    /// What columns do not hold: places that are propped from straight below.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub props: Vec<PropPlace>,
}

/// A place of one layer that is propped from straight below.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PropPlace {
    /// The underside of the layer, mm above the part's lowest point.
    pub under_mm: f64,
    /// The place's box, mm, from the middle of the part's own: the lower and the upper corner.
    pub within_mm: [[f64; 2]; 2],
    /// Whether a sheet goes through its middle.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub middle: bool,
}

/// A roof of lines below what supports hold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SupportRoof {
    /// Its height, mm; what is printed are whole layers.
    pub height_mm: f64,
    /// Distance between its lines, mm.
    pub pitch_mm: f64,
}

/// A plan that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "plan-file/")]
pub enum PlanError {
    /// Not JSON, or not of this shape.
    #[error("{file}{}: not a plan: {message}", if *line == 0 { String::new() } else { format!(":{line}") })]
    Syntax {
        /// The file.
        file: String,
        /// Its line, from 1; 0 where it is about the whole.
        line: usize,
        /// The character of the line, from 1.
        column: usize,
        /// The parser's words.
        message: String,
    },
    /// Another format or a newer version.
    #[error("{file}: the format must be {wanted}, got {found}; make the plan again with this version")]
    Version {
        /// The file.
        file: String,
        /// What it says.
        found: String,
        /// What this version reads.
        wanted: String,
    },
    /// Made for another model or machine.
    #[error("the plan was made for {what} with hash {planned:.12}.., this one has {actual:.12}..; plan again")]
    Stale {
        /// `model x.stl` or `profile y`.
        what: String,
        /// In the plan.
        planned: String,
        /// Now.
        actual: String,
    },
    /// Angles that do not turn the direction upright.
    #[error(
        "slot {slot}, part {part}: tilt {tilt_deg} deg and rotation {rotation_deg} deg do not turn {up:?} upright; plan again"
    )]
    Angles {
        /// The slot.
        slot: usize,
        /// The part.
        part: usize,
        /// As written.
        tilt_deg: f64,
        /// As written.
        rotation_deg: f64,
        /// As written.
        up: [f64; 3],
    },
    /// Its list of parts is not the model's.
    #[error("parts: must list the ids 0 to {last} in order (the model has {parts} parts), got {listed:?}; plan again", last = parts - 1)]
    PartList {
        /// The ids that it lists.
        listed: Vec<usize>,
        /// How many the model has.
        parts: usize,
    },
    /// A part that the model does not have.
    #[error("slot {slot}: part {part} does not exist, the model has parts 0..{last}; plan again", last = parts - 1)]
    NoSuchPart {
        /// The slot.
        slot: usize,
        /// As written.
        part: usize,
        /// How many the model has.
        parts: usize,
    },
    /// A pose that the table cannot take.
    #[error("slot {slot}, part {part}: {letter}{word} is beyond the axis range {low}..{high} deg; plan again")]
    Reach {
        /// The slot.
        slot: usize,
        /// The part.
        part: usize,
        /// The axis.
        letter: char,
        /// As written, degrees.
        word: f64,
        /// The axis's lowest word.
        low: f64,
        /// The highest.
        high: f64,
    },
    /// Supports that cannot be.
    #[error("slot {slot}, part {part}: {problem}; plan again")]
    Supports {
        /// The slot.
        slot: usize,
        /// The part.
        part: usize,
        /// What is wrong with them.
        problem: &'static str,
    },
    /// A part is missing or doubled.
    #[error("part {part} is printed {times} times; every part of the model must be printed once")]
    Count {
        /// The part.
        part: usize,
        /// How often.
        times: usize,
    },
}

/// Where what ends at the character `column` of a line of JSON begins; both from 1.
fn begins(text: &str, line: usize, column: usize) -> usize {
    let line = text.lines().nth(line.wrapping_sub(1)).unwrap_or_default();
    let before: Vec<char> = line.chars().take(column.saturating_sub(1)).collect();
    before.iter().rposition(|c| " \t[{,:".contains(*c)).map_or(1, |place| place + 2)
}

impl PlanError {
    /// Where in what the user gave it is.
    pub fn location(&self) -> Option<Location> {
        match self {
            Self::Syntax { file, line, column, .. } if *line > 0 => {
                Some(Location::file(file).line(*line as u64).column(*column))
            }
            Self::Syntax { file, .. } | Self::Version { file, .. } => Some(Location::file(file)),
            Self::Angles { part, .. }
            | Self::NoSuchPart { part, .. }
            | Self::Reach { part, .. }
            | Self::Supports { part, .. }
            | Self::Count { part, .. } => Some(Location::default().part(*part)),
            Self::Stale { .. } | Self::PartList { .. } => None,
        }
    }
}

/// How well angles must bring a direction upright (chord, radians): the last digit of `up` and of the angles.
const UPRIGHT: f64 = 2e-5;

impl Plan {
    /// What `format` says.
    pub const FORMAT: &'static str = "trunnion-plan";
    /// The version of plans without supports.
    pub const VERSION: u32 = 1;
    /// The version of plans in which a print has supports.
    pub const WITH_SUPPORTS: u32 = 2;
    /// The version of plans whose supports have a roof or a brace.
    pub const WITH_FORM: u32 = 3;
    /// The version of plans whose supports have props; the newest that this code reads.
    pub const WITH_PROPS: u32 = 4;

    /// Reads a plan file's text; `file` is for the messages.
    ///
    /// # Errors
    ///
    /// [`PlanError::Syntax`] and [`PlanError::Version`].
    pub fn parse(file: &str, text: &str) -> Result<Self, PlanError> {
        let syntax = |e: serde_json::Error| {
            let words = e.to_string();
            // Line and column have fields of their own.
            let message = words.rsplit_once(" at line ").map_or(&*words, |(message, _)| message).to_owned();
            PlanError::Syntax {
                file: file.to_owned(),
                line: e.line(),
                column: begins(text, e.line(), e.column()),
                message,
            }
        };
        let value: serde_json::Value = serde_json::from_str(text).map_err(syntax)?;
        let found = value["format"].as_str().map(|format| format!("{format} version {}", value["version"]));
        let found = found.unwrap_or_else(|| "none".to_owned());
        let known = |version: u32| format!("{} version {version}", Self::FORMAT);
        if (Self::VERSION..=Self::WITH_PROPS).all(|version| found != known(version)) {
            let wanted = format!("{} to {}", known(Self::VERSION), Self::WITH_PROPS);
            return Err(PlanError::Version { file: file.to_owned(), found, wanted });
        }
        serde_json::from_str(text).map_err(syntax)
    }

    /// The plan as text, a slot's print a line, so that two plans can be compared by eye.
    pub fn to_text(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }

    /// What was decided, without the machine's values.
    #[must_use]
    pub fn decided(&self) -> Self {
        Self { machine_values: None, ..self.clone() }
    }

    /// The hash of what was decided, whatever the machine's values are written with it: its text's without them.
    pub fn sha256(&self) -> String {
        sha256_hex(self.decided().to_text().as_bytes())
    }

    /// Checks angles against the axes' stops and against directions, and that each of `parts` parts is printed once.
    ///
    /// # Errors
    ///
    /// [`PlanError::PartList`], [`PlanError::NoSuchPart`], [`PlanError::Reach`], [`PlanError::Angles`] and [`PlanError::Count`].
    pub fn check(&self, table: &TableKinematics, parts: usize) -> Result<(), PlanError> {
        if self.parts.len() != parts || self.parts.iter().enumerate().any(|(id, part)| part.id != id) {
            return Err(PlanError::PartList { listed: self.parts.iter().map(|part| part.id).collect(), parts });
        }
        let mut times = vec![0; parts];
        for (slot, print) in self.prints() {
            match times.get_mut(print.part) {
                Some(count) => *count += 1,
                None => return Err(PlanError::NoSuchPart { slot, part: print.part, parts }),
            }
            let pose = print.pose(table);
            for (axis, at, word) in
                [(&table.tilt, pose.tilt, print.tilt_deg), (&table.rotation, pose.rotation, print.rotation_deg)]
            {
                if let (Some((low, high)), false) = (axis.range, axis.admits(at)) {
                    let (letter, part) = (char::from(axis.letter), print.part);
                    let [low, high] = [low, high].map(|stop| round_to(stop.deg(), 4));
                    return Err(PlanError::Reach { slot, part, letter, word, low, high });
                }
            }
            let upright = Dir::<Table>::new(Vec3::from(print.up)).map(|up| table.forward(pose).dir(up));
            if upright.is_none_or(|up| (up.unit() - Vec3::z()).norm() > UPRIGHT) {
                let &Print { part, up, tilt_deg, rotation_deg, .. } = print;
                return Err(PlanError::Angles { slot, part, tilt_deg, rotation_deg, up });
            }
            if let Some(problem) = print.supports.as_ref().and_then(|supports| supports.problem(print.up)) {
                return Err(PlanError::Supports { slot, part: print.part, problem });
            }
        }
        match times.iter().position(|&n| n != 1) {
            Some(part) => Err(PlanError::Count { part, times: times[part] }),
            None => Ok(()),
        }
    }

    /// All prints in order, with their slot's number.
    pub fn prints(&self) -> impl Iterator<Item = (usize, &Print)> {
        self.slots.iter().flat_map(|slot| slot.prints.iter().map(move |print| (slot.id, print)))
    }

    /// The prints of supports, numbered behind those of parts: number, slot, and the print that they hold.
    pub fn supports(&self) -> impl Iterator<Item = (usize, usize, &Print)> {
        let supported = self.prints().filter(|(_, print)| print.supports.is_some());
        supported.enumerate().map(|(k, (slot, print))| (self.prints().count() + k, slot, print))
    }

    /// The number of the supports' print of print `number` ([`Self::prints`]), where that has some.
    pub fn supports_of(&self, number: usize) -> Option<usize> {
        self.held().position(|held| held == number).map(|k| self.prints().count() + k)
    }

    /// The numbers of the prints that have supports, in the order of [`Self::supports`].
    pub fn held(&self) -> impl Iterator<Item = usize> {
        self.prints().enumerate().filter(|(_, (_, print))| print.supports.is_some()).map(|(number, _)| number)
    }

    /// The prints that are made together with that of a part, its own among them; none for a part that is not printed.
    pub fn setup_of(&self, part: usize) -> Vec<&Print> {
        let has = |setup: &Vec<&Print>| setup.iter().any(|print| print.part == part);
        self.slots.iter().flat_map(TimeSlot::setups).find(has).unwrap_or_default()
    }

    /// All prints in the order in which they are made, setup by setup: slot, number of the print ([`Self::prints`]), print.
    pub fn as_made(&self) -> impl Iterator<Item = (usize, usize, &Print)> {
        let mut before = 0;
        self.slots.iter().flat_map(move |slot| {
            let setups = slot.setup_of_each();
            let mut order: Vec<usize> = (0..slot.prints.len()).collect();
            order.sort_by_key(|&index| setups[index]);
            let first = before;
            before += slot.prints.len();
            order.into_iter().map(move |index| (slot.id, first + index, &slot.prints[index]))
        })
    }
}

impl PrintSupports {
    /// Steps of the grid, mm.
    pub const STEPS_MM: [f64; 2] = [1.0, 20.0];
    /// Air below what is held, mm.
    pub const GAPS_MM: [f64; 2] = [0.0, 2.0];
    /// Heights of a roof, mm.
    pub const ROOFS_MM: [f64; 2] = [0.01, 5.0];
    /// Distances between the lines of a roof, mm.
    pub const PITCHES_MM: [f64; 2] = [0.1, 10.0];
    /// Over so much of its height a column may stand free, mm.
    pub const BRACES_MM: [f64; 2] = [2.0, 1000.0];

    /// Places that are propped, at most.
    pub const MOST_PROPS: usize = 10_000;
    /// No part is as large, mm.
    const FARTHEST_MM: f64 = 10_000.0;

    /// What is wrong with them below a print along `up`.
    fn problem(&self, up: [f64; 3]) -> Option<&'static str> {
        let within = |v: f64, [low, high]: [f64; 2]| (low..=high).contains(&v);
        if !within(self.step_mm, Self::STEPS_MM) {
            return Some("the supports' step_mm must be between 1 and 20 mm");
        }
        if !within(self.gap_mm, Self::GAPS_MM) {
            return Some("the supports' gap_mm must be between 0 and 2 mm");
        }
        if !within(self.overhang_deg, [1.0, 89.0]) {
            return Some("the supports' overhang_deg must be between 1 and 89 deg");
        }
        if self.roof.is_some_and(|roof| !within(roof.height_mm, Self::ROOFS_MM)) {
            return Some("the roof's height_mm must be between 0.01 and 5 mm");
        }
        if self.roof.is_some_and(|roof| !within(roof.pitch_mm, Self::PITCHES_MM)) {
            return Some("the roof's pitch_mm must be between 0.1 and 10 mm");
        }
        if self.brace_mm.is_some_and(|brace| !within(brace, Self::BRACES_MM)) {
            return Some("the supports' brace_mm must be between 2 and 1000 mm");
        }
        if self.props.len() > Self::MOST_PROPS {
            return Some("the supports have more than 10000 props");
        }
        let there = |prop: &PropPlace| {
            let [low, high] = prop.within_mm;
            let far = low.iter().chain(&high).chain([&prop.under_mm]).all(|v| v.abs() < Self::FARTHEST_MM);
            far && prop.under_mm > 0.0 && low[0] <= high[0] && low[1] <= high[1]
        };
        if !self.props.iter().all(there) {
            return Some("a prop's box must be above the table and within 10000 mm, its lower corner first");
        }
        // They stand on the table.
        (Vec3::from(up).angle(&Vec3::z()) > UPRIGHT).then_some("supports need a level table, and this pose tilts it")
    }
}

impl TimeSlot {
    /// The prints grouped by pose, in the order in which they are made.
    pub fn setups(&self) -> Vec<Vec<&Print>> {
        let mut groups: Vec<Vec<&Print>> = Vec::new();
        for (print, setup) in self.prints.iter().zip(self.setup_of_each()) {
            groups.resize_with(groups.len().max(setup + 1), Vec::new);
            groups[setup].push(print);
        }
        groups
    }

    /// Of each print the number of its setup within the slot: prints of one pose share one, counted in the order of their first prints.
    pub fn setup_of_each(&self) -> Vec<usize> {
        let mut poses: Vec<&Print> = Vec::new();
        let pose = |print: &Print| (print.tilt_deg, print.rotation_deg, print.up);
        let mut number = |print| {
            let known = poses.iter().position(|known| pose(known) == pose(print));
            known.unwrap_or_else(|| {
                poses.push(print);
                poses.len() - 1
            })
        };
        self.prints.iter().map(&mut number).collect()
    }
}

impl Print {
    /// The print of `part` along `up` at `pose`, rounded as the file writes it.
    pub fn new(part: usize, up: Dir<Table>, pose: Pose, table: &TableKinematics) -> Self {
        Self {
            part,
            up: [up.unit().x, up.unit().y, up.unit().z].map(|v| round_to(v, 7)),
            tilt_deg: round_to(table.tilt.word_of(pose.tilt).deg(), 4),
            rotation_deg: round_to(table.rotation.word_of(pose.rotation).deg(), 4),
            supports: None,
        }
    }

    /// The pose its words mean.
    pub fn pose(&self, table: &TableKinematics) -> Pose {
        use crate::geom::Angle;
        Pose {
            tilt: table.tilt.angle_of(Angle::from_deg(self.tilt_deg)),
            rotation: table.rotation.angle_of(Angle::from_deg(self.rotation_deg)),
        }
    }
}

/// The SHA-256 of `bytes`, as 64 hexadecimal digits.
pub fn sha256_hex(bytes: &[u8]) -> String {
    use sha2::{Digest, Sha256};
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
