//! The profile's keys as types. What each means, its unit and default: `firmware-profiles/defaults.toml`.

use serde::{Deserialize, Serialize};

use super::process::SliceSettings;

/// A machine with its firmware, resolved from all layers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Name and provenance.
    pub machine: MachineInfo,
    /// The chain and the rotary axes.
    pub kinematics: Kinematics,
    /// The linear axes.
    pub limits: Limits,
    /// The table.
    pub table: TableSpec,
    /// What moves with the tip.
    pub head: Bodies,
    /// What never moves.
    pub fixed: Bodies,
    /// How the firmware spells things.
    pub dialect: Dialect,
    /// How the head leaves and comes back when the table turns.
    pub transition: Transition,
    /// First layers on printed material.
    #[serde(default, skip_serializing_if = "JointSettings::is_plain")]
    pub joint: JointSettings,
    /// What ways to print are compared by.
    #[serde(default, skip_serializing_if = "PriceSettings::is_plain")]
    pub price: PriceSettings,
    /// How slots are sliced.
    pub process: SliceSettings,
    /// The wire.
    pub link: Link,
}

/// `[machine]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachineInfo {
    /// The profile's name.
    pub name: String,
    /// One sentence.
    pub about: String,
    /// Real machines it was printed on.
    pub tested_on: Vec<String>,
    /// The day on which a person saw on the machine what each axis does; absent where nobody did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jogged: Option<String>,
    /// The axes as they were seen; where that is not [`Profile::axes_in_words`] any more, the profile was changed since.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jogged_as: Option<String>,
}

/// `[kinematics]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kinematics {
    /// A point on the tilt axis, machine coordinates.
    pub pivot_mm: [f64; 3],
    /// From there to the table's centre at tilt 0.
    pub offset_mm: [f64; 3],
    /// The tilt axis.
    pub tilt: TiltAxis,
    /// The rotation axis.
    pub rotation: RotationAxis,
}

/// The machine axis the table tilts about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TiltAxisName {
    /// An A table.
    X,
    /// A B table.
    Y,
}

/// What an axis turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AxisTurns {
    /// The table.
    #[default]
    Table,
    /// The head.
    Head,
    /// Nothing: the machine does not have it.
    None,
}

impl AxisTurns {
    fn is_table(&self) -> bool {
        *self == Self::Table
    }
}

/// `[kinematics.tilt]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TiltAxis {
    /// The word's letter.
    pub letter: char,
    /// What it turns.
    #[serde(default, skip_serializing_if = "AxisTurns::is_table")]
    pub turns: AxisTurns,
    /// From the tip to a point on it, tool upright, mm; of an axis that turns the head.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_tip_mm: Option<[f64; 3]>,
    /// The machine axis.
    pub about: TiltAxisName,
    /// Where it points while both angles are zero, where that was measured; absent for exactly `about`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along: Option<[f64; 3]>,
    /// +1 or -1.
    pub direction: i32,
    /// The word at level.
    pub zero_deg: f64,
    /// Lowest word.
    pub min_deg: f64,
    /// Highest word.
    pub max_deg: f64,
    /// Fastest turn.
    pub max_deg_per_s: f64,
    /// What its motor and gear hold still with heaters and table on it, N m; absent where nobody has measured it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holding_nm: Option<f64>,
    /// Klipper's name of its motor, where that is turned by a command; absent where the letter turns it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stepper: Option<String>,
}

/// `[kinematics.rotation]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotationAxis {
    /// The word's letter.
    pub letter: char,
    /// What it turns.
    #[serde(default, skip_serializing_if = "AxisTurns::is_table")]
    pub turns: AxisTurns,
    /// From the tip to a point on it, tool upright, mm; of an axis that turns the head.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_tip_mm: Option<[f64; 3]>,
    /// Where it points while both angles are zero, where that was measured; absent for exactly +Z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along: Option<[f64; 3]>,
    /// +1 or -1.
    pub direction: i32,
    /// The word at the table's zero.
    pub zero_deg: f64,
    /// Lowest word; absent with `max_deg` for an endless axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_deg: Option<f64>,
    /// Highest word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_deg: Option<f64>,
    /// How many turns its cables take either way from `zero_deg`, where it has no stops.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_turns: Option<f64>,
    /// Fastest turn.
    pub max_deg_per_s: f64,
    /// Klipper's name of its motor, where that is turned by a command; absent where the letter turns it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stepper: Option<String>,
}

impl RotationAxis {
    /// Lowest and highest word: its stops, or as far as its cables wind; `None` for an endless axis.
    pub fn stops_deg(&self) -> Option<[f64; 2]> {
        let stops = self.min_deg.zip(self.max_deg).map(|(low, high)| [low, high]);
        stops.or_else(|| self.max_turns.map(|turns| [-360.0, 360.0].map(|turn| self.zero_deg + turn * turns)))
    }
}

/// `[limits]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Lowest and highest X of the tip.
    pub x_mm: [f64; 2],
    /// Lowest and highest Y.
    pub y_mm: [f64; 2],
    /// Lowest and highest Z.
    pub z_mm: [f64; 2],
    /// Fastest F.
    pub max_feed_mm_per_min: f64,
    /// What X and Y are accelerated by, where the file does not say; for the time that a print takes, as the four below.
    pub acceleration_mm_per_s2: f64,
    /// Z.
    pub z_acceleration_mm_per_s2: f64,
    /// The extruder.
    pub e_acceleration_mm_per_s2: f64,
    /// Tilt and rotation.
    pub turn_acceleration_deg_per_s2: f64,
    /// How far from a corner a path would bend that went round it without slowing down further: Marlin's junction deviation.
    pub junction_mm: f64,
    /// Below this nothing may be extruded.
    pub min_extrude_c: f64,
    /// The most that the hot end melts.
    pub max_flow_mm3_per_s: f64,
}

/// `[table]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableSpec {
    /// Radius of a disc; 0 for a rectangle.
    pub radius_mm: f64,
    /// Edge lengths of a rectangle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size_mm: Option<[f64; 2]>,
    /// Thickness below the surface.
    pub thickness_mm: f64,
    /// The rim that stays free.
    pub keep_out_mm: f64,
}

/// `[[head.body]]` and `[[fixed.body]]`
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bodies {
    /// Whether a head of one cone is all that there is.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub bare_cone: bool,
    /// Whether the pieces were measured on the machine; of the head.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub measured: bool,
    /// The convex pieces.
    pub body: Vec<BodySpec>,
}

/// The shape of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BodyKind {
    /// Round about +Z: `z_mm`, `r_mm`.
    Frustum,
    /// `min_mm`, `max_mm`.
    Box,
    /// The hull of `points_mm`.
    Hull,
}

fn with_the_tool() -> bool {
    true
}

/// One convex piece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodySpec {
    /// What messages call it.
    pub name: String,
    /// Whether it turns with the tool, where the head turns.
    #[serde(default = "with_the_tool", skip_serializing_if = "Clone::clone")]
    pub turns: bool,
    /// The axes it follows, for example `"XYZ"`; empty for the frame.
    #[serde(default)]
    pub moves: String,
    /// Its shape.
    pub kind: BodyKind,
    /// Heights of the frustum's ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z_mm: Option<[f64; 2]>,
    /// Radii there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub r_mm: Option<[f64; 2]>,
    /// Lowest corner of the box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_mm: Option<[f64; 3]>,
    /// Highest corner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_mm: Option<[f64; 3]>,
    /// The hull's points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points_mm: Option<Vec<[f64; 3]>>,
}

/// Which commands the firmware takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Commands {
    /// M-codes of a printer pass.
    Marlin,
    /// Only RS274/NGC passes.
    Rs274,
}

/// How F is read when several kinds of axis move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FeedReference {
    /// Linear length where a linear axis moves, else degrees.
    LinearOnly,
    /// Euclidean length over mm and degrees.
    AllAxes,
    /// Linear length where a linear axis moves, else the largest angle.
    LargestAxis,
    /// G93.
    InverseTime,
}

/// How filament is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Extrusion {
    /// M83.
    Relative,
    /// M82.
    Absolute,
}

/// `[dialect]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dialect {
    /// What it is written for.
    pub firmware: String,
    /// Which commands pass.
    pub commands: Commands,
    /// How F is read.
    pub feed: FeedReference,
    /// Whether the firmware follows the tip.
    pub rtcp: bool,
    /// Whether arcs may stay.
    pub arcs: bool,
    /// The extruder's letter.
    pub extruder: char,
    /// How filament is counted.
    pub extrusion: Extrusion,
    /// Whether G90/G91 switch the extruder.
    pub g90_switches_extruder: bool,
    /// Whether pictures of the object stand in the head of a program.
    pub thumbnails: bool,
    /// Commands that may pass although their effect is not followed.
    pub allow: Vec<String>,
    /// Before the first move.
    pub start: String,
    /// After the last.
    pub end: String,
}

/// `[transition]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Transition {
    /// Filament pulled while the table turns.
    pub retract_mm: f64,
    /// Speed of the pull.
    pub retract_mm_per_s: f64,
    /// Filament pushed beyond that where a print goes on behind a turn.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub prime_mm: f64,
    /// Room over everything printed.
    pub clearance_mm: f64,
    /// Where the tip waits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub park_mm: Option<[f64; 2]>,
    /// Speed in X and Y.
    pub travel_mm_per_min: f64,
    /// Speed in Z.
    pub z_mm_per_min: f64,
    /// Lines before the table turns.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub before_turn: String,
    /// Lines behind it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub after_turn: String,
}

/// For keys whose default leaves a profile, and its hash, as it was before there was such a key.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Transition {
    /// The lines before the table turns, and behind it; without blank ones.
    pub fn around_turn(&self) -> [Vec<&str>; 2] {
        [&self.before_turn, &self.after_turn]
            .map(|text| text.lines().map(str::trim).filter(|line| !line.is_empty()).collect())
    }
}

/// `[joint]`: the first layers of a print that begins on an earlier part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointSettings {
    /// How many layers.
    pub layers: u32,
    /// How much lower the first of them is laid, mm.
    pub overlap_mm: f64,
    /// Their lines are laid no faster; absent: as sliced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mm_per_s: Option<f64>,
    /// The fan, 0 to 1; absent: as sliced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fan: Option<f64>,
    /// The nozzle; absent: as sliced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nozzle_c: Option<f64>,
}

impl Default for JointSettings {
    fn default() -> Self {
        Self { layers: 1, overlap_mm: 0.0, mm_per_s: None, fan: None, nozzle_c: None }
    }
}

impl JointSettings {
    /// Whether nothing is asked for.
    pub fn is_plain(&self) -> bool {
        *self == Self::default()
    }
}

/// `[price]`: what is worth how many minutes where ways to print a model are compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PriceSettings {
    /// A gram of filament.
    pub gram_min: f64,
    /// A pose of the table beyond the first.
    pub setup_min: f64,
    /// Breaking supports off, however few.
    pub supports_min: f64,
    /// A square centimetre that they touch.
    pub contact_min_per_cm2: f64,
    /// A square millimetre of seam.
    pub seam_min_per_mm2: f64,
    /// A square millimetre that droops by one millimetre.
    pub droop_min_per_mm3: f64,
}

impl Default for PriceSettings {
    fn default() -> Self {
        Self {
            gram_min: 1.0,
            setup_min: 2.0,
            supports_min: 0.5,
            contact_min_per_cm2: 0.05,
            seam_min_per_mm2: 0.01,
            droop_min_per_mm3: 0.02,
        }
    }
}

impl PriceSettings {
    /// Whether nothing is said of it.
    pub fn is_plain(&self) -> bool {
        *self == Self::default()
    }
}

/// What becomes of the heaters when a print is stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OnStop {
    /// Both off.
    Off,
    /// The nozzle off, the bed kept.
    KeepBed,
    /// As they are.
    Keep,
}

/// How often a printer has to say where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Prove {
    /// Only before the head leaves the part.
    Count,
    /// At the end of each layer, too.
    Layer,
}

/// `[link]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Link {
    /// The wire protocol, `"none"` where the machine reads files only.
    pub protocol: String,
    /// Bits per second.
    pub baud: u32,
    /// Bytes the firmware buffers.
    pub buffer: u32,
    /// Commands the firmware buffers.
    pub commands: u32,
    /// The longest that the firmware leaves what it receives unread while it can queue more commands; 0 where nobody knows.
    pub reads_ms: f64,
    /// Moves that the firmware's planner holds.
    pub planner: u32,
    /// Bytes of the firmware's longest line.
    pub longest_line: u32,
    /// Whether a blank goes between a line's number and its command.
    pub blank_after_number: bool,
    /// How often the printer has to say where it is, beside the count of its lines.
    pub prove: Prove,
    /// What the printer must call itself; empty for any.
    pub identity: String,
    /// The hottest that the nozzle may be asked to become.
    pub max_nozzle_c: f64,
    /// The same for the bed.
    pub max_bed_c: f64,
    /// Heaters after a fault or a cancel.
    pub on_stop: OnStop,
    /// How far the head leaves the part in a pause.
    pub lift_mm: f64,
    /// Lines that home with a part on the table.
    pub rehome: String,
}
