//! Which part carries which, and so what a piece follows.
//!
//! The profile's frame stands on what carries the tilt: there the tip moves along X, Y and Z, whichever parts of the machine do so. A part
//! follows an axis of the bed's unless it rides on that axis itself, and one of the tool's where it does.

use super::json::Document;
use crate::profile::import::ImportError;
use crate::profile::import::stated::StatedAt;

/// Deviation of a direction from an axis that is still that axis.
const ALONG: f64 = 1e-6;

/// What becomes of pieces of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// They tilt and turn with the plate.
    Table,
    /// They tilt with it and do not turn.
    Cradle,
    /// They follow the tip along these axes, none for the frame.
    Follows(String),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Axis {
    None,
    /// 0 to 2.
    Linear(usize),
    Tilt,
    Turn,
}

struct Part {
    name: String,
    parent: Option<usize>,
    axis: Axis,
    /// Along or about the machine's own axis, or against it.
    sense: f64,
    place: StatedAt,
}

pub(super) struct Tree {
    parts: Vec<Part>,
    bed: usize,
    tool: usize,
    /// The axes that move the bed.
    bed_axes: [bool; 3],
    /// Whether both rotary axes turn as the program turns paths; else the sentence that says what contradicts that.
    pub(super) right_handed: Result<(), String>,
    pub(super) place: StatedAt,
}

/// The program's own tree: name, parent, axis.
const OWN: [(&str, Option<usize>, Axis, f64); 6] = [
    ("Frame", None, Axis::None, 1.0),
    ("Z", Some(0), Axis::Linear(2), -1.0),
    ("B", Some(1), Axis::Tilt, 1.0),
    ("C", Some(2), Axis::Turn, 1.0),
    ("Y", Some(0), Axis::Linear(1), 1.0),
    ("X", Some(4), Axis::Linear(0), 1.0),
];

impl Tree {
    /// # Errors
    ///
    /// [`ImportError`] with the line for a tree that is none of a table that tilts about Y and turns below a head that does not.
    pub(super) fn of(machine: &Document<'_>) -> Result<Self, ImportError> {
        let (parts, bed, tool) = if machine.has("kinematics") { Self::stated(machine)? } else { Self::own(machine) };
        let place = machine.place("kinematics");
        let mut tree = Self { parts, bed, tool, bed_axes: [false; 3], right_handed: Ok(()), place };
        tree.check()?;
        tree.right_handed = tree.senses(machine)?;
        Ok(tree)
    }

    fn own(machine: &Document<'_>) -> (Vec<Part>, usize, usize) {
        let part = |(name, parent, axis, sense): (&str, Option<usize>, Axis, f64)| Part {
            name: name.to_owned(),
            parent,
            axis,
            sense,
            place: machine.place("_version"),
        };
        (OWN.map(part).into_iter().collect(), 3, 5)
    }

    fn stated(machine: &Document<'_>) -> Result<(Vec<Part>, usize, usize), ImportError> {
        let list = "kinematics.parts";
        let names = (0..machine.count(list))
            .map(|i| machine.text(&format!("{list}.{i}.name")))
            .collect::<Result<Vec<_>, _>>()?;
        let find = |path: &str| -> Result<usize, ImportError> {
            let name = machine.text(path)?;
            let why = format!("part {name:?} not found; the parts are {}", names.join(", "));
            names.iter().position(|n| *n == name).ok_or_else(|| ImportError::At { place: machine.place(path), why })
        };
        let mut parts: Vec<Part> = Vec::new();
        for (i, name) in names.iter().enumerate() {
            let path = |of: &str| format!("{list}.{i}.{of}");
            let place = machine.place(&format!("{list}.{i}"));
            let wrong = |of: &str, why: String| Err(ImportError::At { place: machine.place(&path(of)), why });
            if names[..i].contains(name) {
                return wrong("name", format!("part {name:?} is given twice"));
            }
            let orphan = machine.at(&path("parent")).is_none_or(serde_json::Value::is_null);
            let parent = if orphan { None } else { Some(find(&path("parent"))?) };
            let kind = machine.text(&path("type"))?;
            let (axis, sense) = if kind == "static" {
                (Axis::None, 1.0)
            } else {
                let word = machine.text(&path("gcode"))?;
                let axis = match (kind.as_str(), word.as_str()) {
                    ("linear", "mx") => Axis::Linear(0),
                    ("linear", "my") => Axis::Linear(1),
                    ("linear", "mz") => Axis::Linear(2),
                    ("rotary", "mb") => Axis::Tilt,
                    ("rotary", "mc") => Axis::Turn,
                    _ => {
                        let why = format!(
                            "type {kind:?} with gcode {word:?} is not supported; use static, linear with mx, my or mz, or rotary with mb or mc"
                        );
                        return wrong("gcode", why);
                    }
                };
                (axis, sense(machine, &path("threeAxis"), &path("invert"), axis)?)
            };
            parts.push(Part { name: name.clone(), parent, axis, sense, place });
        }
        Ok((parts, find("kinematics.bedPart")?, find("kinematics.toolPart")?))
    }

    /// The part and all that carry it, from the part outward; `None` where they carry each other.
    fn carriers(&self, of: usize) -> Option<Vec<usize>> {
        let mut chain = vec![of];
        while let Some(parent) = self.parts[chain[chain.len() - 1]].parent {
            if chain.contains(&parent) {
                return None;
            }
            chain.push(parent);
        }
        Some(chain)
    }

    fn axes(&self, of: usize) -> Vec<Axis> {
        let chain = self.carriers(of).unwrap_or_default();
        chain.into_iter().map(|i| self.parts[i].axis).filter(|axis| *axis != Axis::None).collect()
    }

    fn check(&mut self) -> Result<(), ImportError> {
        let wrong = |place: &StatedAt, why: String| Err(ImportError::At { place: place.clone(), why });
        for i in 0..self.parts.len() {
            if self.carriers(i).is_none() {
                return wrong(
                    &self.parts[i].place,
                    format!(
                        "part {} is its own parent, directly or through other parts; check each parent",
                        self.parts[i].name
                    ),
                );
            }
        }
        let (bed, tool) = (self.axes(self.bed), self.axes(self.tool));
        let linear = |axes: &[Axis], i: usize| axes.contains(&Axis::Linear(i));
        let (place, name) = (&self.parts[self.tool].place, &self.parts[self.tool].name);
        if tool.iter().any(|axis| matches!(axis, Axis::Tilt | Axis::Turn)) {
            return wrong(
                place,
                format!(
                    "part {name}, which carries the nozzle, tilts or turns; only a table that tilts and turns below an upright head is supported"
                ),
            );
        }
        let (place, name) = (&self.parts[self.bed].place, &self.parts[self.bed].name);
        if bed.len() < 2
            || bed[..2] != [Axis::Turn, Axis::Tilt]
            || bed[2..].iter().any(|a| matches!(a, Axis::Tilt | Axis::Turn))
        {
            return wrong(
                place,
                format!(
                    "the bed, part {name}, must be turned by mc directly on a part that mb tilts, with no other rotary part below"
                ),
            );
        }
        for i in 0..3 {
            let axis = ["X", "Y", "Z"][i];
            if linear(&bed, i) == linear(&tool, i) {
                let both = if linear(&bed, i) { "both bed and nozzle move" } else { "neither bed nor nozzle moves" };
                return wrong(place, format!("{both} along {axis}; exactly one of them must"));
            }
            self.bed_axes[i] = linear(&bed, i);
            let wanted = if self.bed_axes[i] { -1.0 } else { 1.0 };
            if let Some(part) = self.parts.iter().find(|part| part.axis == Axis::Linear(i) && part.sense != wanted) {
                let why = format!(
                    "part {}: a larger {axis} value moves the nozzle towards lower {axis} on the plate; check its invert",
                    part.name
                );
                return wrong(&part.place, why);
            }
        }
        Ok(())
    }

    /// Holds the senses of the tree, and of the list that the program turns paths by where there is one, against its published formula.
    fn senses(&self, machine: &Document<'_>) -> Result<Result<(), String>, ImportError> {
        let mut against = Vec::new();
        for part in self.parts.iter().filter(|part| matches!(part.axis, Axis::Tilt | Axis::Turn) && part.sense < 0.0) {
            against.push(format!("{} (part {})", part.place, part.name));
        }
        let list = "kinematics.bedRotAxes";
        for i in 0..machine.count(list) {
            let path = format!("{list}.{i}");
            let axis = match machine.text(&format!("{path}.gcode"))?.as_str() {
                "mb" => Axis::Tilt,
                "mc" => Axis::Turn,
                other => {
                    let why = format!("{other:?} does not turn the bed; use mb or mc");
                    return Err(ImportError::At { place: machine.place(&path), why });
                }
            };
            if sense(machine, &format!("{path}.axis"), &format!("{path}.invert"), axis)? < 0.0 {
                against.push(format!("{} (bedRotAxes)", machine.place(&path)));
            }
        }
        Ok(if against.is_empty() {
            Ok(())
        } else {
            Err(format!(
                "{}: turns against the simulator's own paths (right-handed about +Y and +Z), so the table's direction is unknown; check it on the machine",
                against.join(", ")
            ))
        })
    }

    pub(super) fn name_of(&self, name: &str) -> Option<&str> {
        self.parts.iter().map(|part| part.name.as_str()).find(|n| *n == name)
    }

    pub(super) fn names(&self) -> String {
        self.parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// The part that carries the nozzle.
    pub(super) fn tool(&self) -> &str {
        &self.parts[self.tool].name
    }

    pub(super) fn role(&self, name: &str) -> Role {
        let axes = self.parts.iter().position(|part| part.name == name).map_or_else(Vec::new, |i| self.axes(i));
        if axes.contains(&Axis::Tilt) {
            return if axes.contains(&Axis::Turn) { Role::Table } else { Role::Cradle };
        }
        let follows = |i: &usize| self.bed_axes[*i] != axes.contains(&Axis::Linear(*i));
        Role::Follows([0, 1, 2].iter().filter(|i| follows(i)).map(|i| ["X", "Y", "Z"][*i]).collect())
    }
}

/// Whether what the program writes as a direction in its own frame, and turns round by `invert`, is the machine's own axis (1) or the
/// opposite (-1).
fn sense(machine: &Document<'_>, path: &str, invert: &str, axis: Axis) -> Result<f64, ImportError> {
    let given = machine.triple(path)?;
    let own = super::turned(given);
    let (i, name) = match axis {
        Axis::Linear(i) => (i, ["X", "Y", "Z"][i]),
        Axis::Tilt => (1, "Y"),
        _ => (2, "Z"),
    };
    let beside: f64 = (0..3).filter(|k| *k != i).map(|k| own[k].abs()).sum();
    if beside > ALONG || (own[i].abs() - 1.0).abs() > ALONG {
        let why = format!(
            "{path} must be a unit vector along the machine's {name}, for example {:?}, got {given:?}",
            match i {
                0 => [1, 0, 0],
                1 => [0, 0, -1],
                _ => [0, 1, 0],
            }
        );
        return Err(ImportError::At { place: machine.place(path), why });
    }
    Ok(own[i].signum() * if machine.is_on(invert)? { -1.0 } else { 1.0 })
}
