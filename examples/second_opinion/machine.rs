//! The machine, as the certificate's profile describes it: axes, poses of the table, and what its program may say.

use super::bodies::{Body, Table, bodies};
use super::certificate::{at, list, number, numbers, optional, optional_text, text};
use super::maths::{V, add, cross, dot, scale, sub, turned, turned_back, unit};
use serde_json::Value;
use std::f64::consts::FRAC_PI_4;

/// A turning axis of the table.
pub struct Axis {
    pub letter: char,
    along: V,
    direction: f64,
    pub zero: f64,
    pub stops: [f64; 2],
    /// Degrees a second, at most.
    pub rate: f64,
    /// The stepper that a command of its own turns, where words of a move do not.
    pub stepper: Option<String>,
}

impl Axis {
    fn read(values: &Value, name: &str, along: V) -> Result<Self, String> {
        let path = |key: &str| format!("/kinematics/{name}/{key}");
        let letter = text(values, &path("letter"))?.chars().next().ok_or("an axis has no letter")?;
        let zero = number(values, &path("zero_deg"))?;
        // As far as cables wind from zero, where there are no stops.
        let wound = optional(values, &path("max_turns")).map_or(f64::INFINITY, |turns| 360.0 * turns);
        let [low, high] = ["min_deg", "max_deg"].map(|key| optional(values, &path(key)));
        let measured = values.pointer(&path("along")).is_some();
        Ok(Self {
            letter,
            along: if measured { unit(numbers(values, &path("along"))?) } else { along },
            direction: number(values, &path("direction"))?,
            zero,
            stops: [low.unwrap_or(zero - wound), high.unwrap_or(zero + wound)],
            rate: number(values, &path("max_deg_per_s"))?,
            stepper: optional_text(values, &path("stepper")).map(str::to_owned),
        })
    }

    /// Columns of the rotation matrix for a word, by Rodrigues' formula.
    fn matrix(&self, word: f64) -> [V; 3] {
        let (sin, cos) = (self.direction * (word - self.zero)).to_radians().sin_cos();
        let across = |e: V| add(scale(e, cos), scale(cross(self.along, e), sin));
        let column = |e: V| add(across(e), scale(self.along, dot(self.along, e) * (1.0 - cos)));
        [column([1.0, 0.0, 0.0]), column([0.0, 1.0, 0.0]), column([0.0, 0.0, 1.0])]
    }
}

/// The table's pose: `p_machine = turn * p_table + shift`, the turn by its columns.
#[derive(Clone, Copy)]
pub struct Pose {
    pub turn: [V; 3],
    shift: V,
    pub words: [f64; 2],
}

impl Pose {
    pub fn machine(&self, p: V) -> V {
        add(turned(self.turn, p), self.shift)
    }

    pub fn table(&self, p: V) -> V {
        turned_back(self.turn, sub(p, self.shift))
    }

    /// The machine's +Z, table frame.
    pub fn up(&self) -> V {
        self.turn.map(|column| column[2])
    }
}

/// The values of the profile that the checks need.
pub struct Machine {
    /// Tilt and rotation.
    pub axes: [Axis; 2],
    pivot: V,
    offset: V,
    limits: [[f64; 2]; 3],
    pub max_feed: f64,
    pub min_extrude: f64,
    pub table: Table,
    pub head: Vec<Body>,
    pub fixed: Vec<Body>,
    pub firmware: String,
    pub heats: bool,
    pub extruder: char,
    pub g90_switches: bool,
    /// Lines of the profile's own code, before the end mark and behind it, and commands that it allows.
    pub start: Vec<String>,
    pub end: Vec<String>,
    pub allow: Vec<String>,
    pub retract: f64,
    pub prime: f64,
    pub bridge: f64,
    pub overlap: f64,
    pub layer: f64,
    pub filament_area: f64,
}

/// Lines of code without comments.
fn lines_of(values: &Value, paths: &[&str]) -> Vec<String> {
    let lines = paths.iter().flat_map(|path| optional_text(values, path).unwrap_or("").lines());
    lines.filter_map(|line| line.split(';').next()).map(|l| l.trim().to_owned()).filter(|l| !l.is_empty()).collect()
}

impl Machine {
    pub fn read(values: &Value) -> Result<Self, String> {
        for axis in ["tilt", "rotation"] {
            if let Some(turns) = optional_text(values, &format!("/kinematics/{axis}/turns")) {
                return Err(format!(
                    "kinematics.{axis}.turns is {turns:?}: this reader knows tables that tilt and turn, and no other chain"
                ));
            }
        }
        let about = match text(values, "/kinematics/tilt/about")? {
            "X" => [1.0, 0.0, 0.0],
            "Y" => [0.0, 1.0, 0.0],
            other => return Err(format!("the table tilts about the unknown axis {other}")),
        };
        let radius = number(values, "/table/radius_mm")?;
        let diameter = number(values, "/process/filament_mm")?;
        let range = |path: &str| numbers(values, path);
        Ok(Self {
            axes: [Axis::read(values, "tilt", about)?, Axis::read(values, "rotation", [0.0, 0.0, 1.0])?],
            pivot: numbers(values, "/kinematics/pivot_mm")?,
            offset: numbers(values, "/kinematics/offset_mm")?,
            limits: [range("/limits/x_mm")?, range("/limits/y_mm")?, range("/limits/z_mm")?],
            max_feed: number(values, "/limits/max_feed_mm_per_min")?,
            min_extrude: number(values, "/limits/min_extrude_c")?,
            table: Table {
                radius,
                size: if radius > 0.0 { [0.0; 2] } else { numbers(values, "/table/size_mm")? },
                thickness: number(values, "/table/thickness_mm")?,
            },
            head: bodies(values, "/head/body")?,
            fixed: bodies(values, "/fixed/body")?,
            firmware: text(values, "/dialect/firmware")?.to_owned(),
            heats: text(values, "/dialect/commands")? != "rs274",
            extruder: text(values, "/dialect/extruder")?.chars().next().ok_or("the extruder has no letter")?,
            g90_switches: at(values, "/dialect/g90_switches_extruder")?.as_bool().unwrap_or(true),
            start: lines_of(values, &["/dialect/start", "/transition/before_turn", "/transition/after_turn"]),
            end: lines_of(values, &["/dialect/end"]),
            allow: list(values, "/dialect/allow")?.iter().filter_map(Value::as_str).map(str::to_owned).collect(),
            retract: number(values, "/transition/retract_mm")?,
            prime: optional(values, "/transition/prime_mm").unwrap_or(0.0),
            bridge: number(values, "/process/bridge_mm")?,
            overlap: optional(values, "/joint/overlap_mm").unwrap_or(0.0),
            layer: number(values, "/process/layer_height_mm")?,
            filament_area: diameter * diameter * FRAC_PI_4,
        })
    }

    /// Letters and limits of X, Y, Z, tilt and rotation.
    pub fn ranges(&self) -> [(char, [f64; 2]); 5] {
        let ([x, y, z], [tilt, rotation]) = (self.limits, &self.axes);
        [('X', x), ('Y', y), ('Z', z), (tilt.letter, tilt.stops), (rotation.letter, rotation.stops)]
    }

    /// Whether the firmware is of the RS-274 family: it reads comments in parentheses, and runs without homing by the program.
    pub fn is_rs274(&self) -> bool {
        matches!(self.firmware.as_str(), "grbl" | "linuxcnc")
    }

    pub fn pose(&self, words: [f64; 2]) -> Pose {
        let [tilt, rotation] = [0, 1].map(|i| self.axes[i].matrix(words[i]));
        let turn = rotation.map(|column| turned(tilt, column));
        Pose { turn, shift: add(self.pivot, turned(tilt, self.offset)), words }
    }
}
