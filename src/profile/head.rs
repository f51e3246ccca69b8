//! The head from a few measures that callipers take: nozzle, heater block, carriage, beam. What is not measured stays as it is in the
//! profile that the machine is like.
//!
//! Frame: the nozzle's tip at the origin, X to the right, Y to the back, Z up, mm; as `[[head.body]]`.

use toml::{Table, Value};

use super::{BodyKind, BodySpec, Profile};
use crate::spelling::nearest;

/// What is asked of every head: key and question. Keys of answers alone; a profile has the pieces that they make.
pub const HEAD_QUESTIONS: [(&str, &str); 9] = [
    ("head.nozzle_tip_mm", "diameter of the nozzle's flat tip, mm"),
    ("head.cone_mm", "the nozzle's cone: [length from the tip to where it is widest, diameter there], mm"),
    (
        "head.block_mm",
        "hot end below the carriage (heater block, sock, fan ducts): distances from the nozzle's axis, [left, right, front, back], mm",
    ),
    ("head.block_z_mm", "the same: [lowest, highest] above the tip, mm"),
    (
        "head.carriage_mm",
        "carriage with everything on it: distances from the nozzle's axis, [left, right, front, back], mm",
    ),
    ("head.carriage_z_mm", "the same: [lowest, highest] above the tip, mm"),
    (
        "head.gantry_moves",
        "beam that carries the carriage, by the axes in which it follows the nozzle over the bed: YZ (a beam along X), XZ (a beam along Y) \
         or none",
    ),
    (
        "head.gantry_mm",
        "the same: distances from the nozzle's axis to its [front, rear] faces, mm, positive to the back (XZ: [left, right], positive to the right)",
    ),
    ("head.gantry_z_mm", "the same: [lowest, highest] above the tip, mm"),
];

/// A measure that no head has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HeadFault {
    /// The answer, or its key.
    pub what: String,
    /// What is wrong with it.
    pub why: String,
}

/// A beam goes so far beyond what the tip reaches, on either side.
const BEAM_BEYOND_MM: f64 = 100.0;
/// What a measure may be at most.
const MOST_MM: f64 = 1000.0;
/// Names that differ by more letters were not meant.
const MOST_EDITS: usize = 4;

/// The pieces of a head by what they are.
#[derive(Default)]
struct Roles {
    nozzle: Option<BodySpec>,
    shaft: Option<BodySpec>,
    block: Option<BodySpec>,
    carriage: Option<BodySpec>,
    gantry: Option<BodySpec>,
    others: Vec<BodySpec>,
}

impl Roles {
    /// A cone that begins at the tip; boxes that follow the tip, the lower first; a box that follows it across the beam.
    fn of(bodies: &[BodySpec]) -> Self {
        let mut roles = Self::default();
        let low = |body: &BodySpec| body.min_mm.map_or(f64::INFINITY, |min| min[2]);
        let mut sorted: Vec<&BodySpec> = bodies.iter().collect();
        sorted.sort_by(|a, b| low(a).total_cmp(&low(b)));
        for body in sorted {
            let tip = body.kind == BodyKind::Frustum && body.z_mm.is_some_and(|z| z[0] == 0.0);
            let with_tip = body.moves == "XYZ";
            let slot = match body.kind {
                BodyKind::Frustum if tip && with_tip => &mut roles.nozzle,
                BodyKind::Frustum if body.name == SHAFT => &mut roles.shaft,
                BodyKind::Box if with_tip && roles.block.is_none() => &mut roles.block,
                BodyKind::Box if with_tip => &mut roles.carriage,
                BodyKind::Box if matches!(body.moves.as_str(), "YZ" | "XZ") => &mut roles.gantry,
                _ => {
                    roles.others.push(body.clone());
                    continue;
                }
            };
            match slot {
                Some(_) => roles.others.push(body.clone()),
                None => *slot = Some(body.clone()),
            }
        }
        roles
    }

    fn bodies(self) -> Vec<BodySpec> {
        let all = [self.nozzle, self.shaft, self.block, self.carriage, self.gantry];
        all.into_iter().flatten().chain(self.others).collect()
    }
}

const SHAFT: &str = "nozzle's shaft";

/// The measures among answers.
struct Measures(Table);

fn wrong<T>(key: &str, value: Option<&Value>, why: &str) -> Result<T, HeadFault> {
    let value = value.map_or_else(String::new, |value| format!("={value}"));
    Err(HeadFault { what: format!("{key}{value}"), why: why.to_owned() })
}

impl Measures {
    fn value(&self, key: &str) -> Option<&Value> {
        self.0.get(key.strip_prefix("head.")?)
    }

    /// `count` numbers between `low` and the most there is; `None` where nobody measured.
    fn numbers<const N: usize>(&self, key: &str, low: f64) -> Result<Option<[f64; N]>, HeadFault> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let one = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|v| v as f64));
        let all: Vec<f64> = match value {
            Value::Array(all) => all.iter().filter_map(one).collect(),
            other => one(other).into_iter().collect(),
        };
        let given = value.as_array().map_or(1, Vec::len);
        let wanted = || {
            format!("{} of {low}..{MOST_MM} mm", if N == 1 { "one number".to_owned() } else { format!("{N} numbers") })
        };
        match <[f64; N]>::try_from(all) {
            Ok(all) if given == N && all.iter().all(|v| (low..=MOST_MM).contains(v)) => Ok(Some(all)),
            _ => wrong(key, Some(value), &format!("give {}", wanted())),
        }
    }

    /// Two numbers, the lower first.
    fn span(&self, key: &str, low: f64) -> Result<Option<[f64; 2]>, HeadFault> {
        match self.numbers::<2>(key, low)? {
            Some([from, to]) if from >= to => {
                wrong(key, self.value(key), "the first must be below the second; they may be swapped")
            }
            other => Ok(other),
        }
    }

    fn nozzle(&self, roles: &mut Roles) -> Result<(), HeadFault> {
        let tip = self.numbers::<1>("head.nozzle_tip_mm", 0.0)?;
        let cone = self.numbers::<2>("head.cone_mm", 0.0)?;
        if tip.is_none() && cone.is_none() {
            return Ok(());
        }
        let there = roles.nozzle.as_ref().and_then(|body| body.z_mm.zip(body.r_mm));
        let tip = tip.map(|[d]| d).or(there.map(|(_, r)| 2.0 * r[0]));
        let cone = cone.or(there.map(|(z, r)| [z[1], 2.0 * r[1]]));
        let (Some(tip), Some([length, widest])) = (tip, cone) else {
            return wrong(
                "head.nozzle_tip_mm, head.cone_mm",
                None,
                "the --like profile has no nozzle that begins at the tip; give both",
            );
        };
        if tip <= 0.0 || length <= 0.0 || widest < tip {
            let why = format!(
                "the tip ({tip} mm) and the length ({length} mm) must be above 0, and the widest diameter ({widest} mm) at least the tip"
            );
            return wrong("head.cone_mm", self.value("head.cone_mm"), &why);
        }
        roles.shaft = None;
        roles.nozzle = Some(frustum("nozzle", [0.0, length], [tip / 2.0, widest / 2.0]));
        Ok(())
    }

    /// Block and carriage: a box from four sides and two heights.
    fn around(&self, name: &str, keys: [&str; 2], slot: &mut Option<BodySpec>) -> Result<(), HeadFault> {
        let (sides, heights) = (self.numbers::<4>(keys[0], 0.0)?, self.span(keys[1], 0.0)?);
        if sides.is_none() && heights.is_none() {
            return Ok(());
        }
        let there = slot.as_ref().and_then(|body| body.min_mm.zip(body.max_mm));
        let sides = sides.or(there.map(|(min, max)| [-min[0], max[0], -min[1], max[1]]));
        let heights = heights.or(there.map(|(min, max)| [min[2], max[2]]));
        let (Some([left, right, front, back]), Some([low, high])) = (sides, heights) else {
            let why = format!("the --like profile has no {name}; give both");
            return wrong(&keys.join(", "), None, &why);
        };
        if left + right <= 0.0 || front + back <= 0.0 {
            return wrong(keys[0], self.value(keys[0]), "left plus right, and front plus back, must be above 0");
        }
        *slot = Some(cuboid(name, "XYZ", [-left, -front, low], [right, back, high]));
        Ok(())
    }

    fn gantry(&self, roles: &mut Roles, reach: [[f64; 2]; 2]) -> Result<(), HeadFault> {
        let keys = ["head.gantry_moves", "head.gantry_mm", "head.gantry_z_mm"];
        let (faces, heights) = (self.span(keys[1], -MOST_MM)?, self.span(keys[2], 0.0)?);
        let moves = self.value(keys[0]);
        if moves.is_none() && faces.is_none() && heights.is_none() {
            return Ok(());
        }
        let there = roles.gantry.as_ref();
        let same = |was: &BodySpec| moves.and_then(Value::as_str).is_none_or(|moves| moves == was.moves);
        let box_of = there.filter(|was| same(was)).and_then(|body| body.min_mm.zip(body.max_mm));
        let moves = match moves {
            None => there.map(|body| body.moves.clone()),
            Some(value) => match value.as_str() {
                Some("none") if faces.is_some() || heights.is_some() => {
                    return wrong(keys[0], Some(value), "none cannot have gantry_mm or gantry_z_mm; remove them");
                }
                Some("none") => {
                    roles.gantry = None;
                    return Ok(());
                }
                Some(text @ ("YZ" | "XZ")) => Some(text.to_owned()),
                _ => return wrong(keys[0], Some(value), "must be YZ, XZ or none"),
            },
        };
        let across = usize::from(moves.as_deref() != Some("XZ"));
        let faces = faces.or(box_of.map(|(min, max)| [min[across], max[across]]));
        let heights = heights.or(box_of.map(|(min, max)| [min[2], max[2]]));
        let (Some(moves), Some([front, rear]), Some([low, high])) = (moves, faces, heights) else {
            return wrong(&keys.join(", "), None, "the --like profile has no such beam; give all three");
        };
        // As long as the tip goes, and a bit more, in the machine's own coordinates.
        let [from, to] = reach[1 - across];
        let (mut min, mut max) = ([from - BEAM_BEYOND_MM; 3], [to + BEAM_BEYOND_MM; 3]);
        (min[across], max[across]) = (front, rear);
        (min[2], max[2]) = (low, high);
        roles.gantry = Some(cuboid("gantry", &moves, min, max));
        Ok(())
    }
}

/// The nozzle goes on upward, as wide as it is, where what is above begins higher.
fn fill_up(roles: &mut Roles) {
    let top = roles.nozzle.as_ref().and_then(|body| Some((body.z_mm?[1], body.r_mm?[1])));
    let above = roles.block.as_ref().or(roles.carriage.as_ref()).and_then(|body| body.min_mm);
    if let (Some((top, r)), Some(above)) = (top, above)
        && above[2] > top
    {
        roles.shaft = Some(frustum(SHAFT, [top, above[2]], [r, r]));
    }
}

fn frustum(name: &str, z: [f64; 2], r: [f64; 2]) -> BodySpec {
    BodySpec { z_mm: Some(z), r_mm: Some(r), ..piece(name, "XYZ", BodyKind::Frustum) }
}

fn cuboid(name: &str, moves: &str, min: [f64; 3], max: [f64; 3]) -> BodySpec {
    // Without -0.
    let plain = |v: [f64; 3]| Some(v.map(|v| v + 0.0));
    BodySpec { min_mm: plain(min), max_mm: plain(max), ..piece(name, moves, BodyKind::Box) }
}

fn piece(name: &str, moves: &str, kind: BodyKind) -> BodySpec {
    let (name, moves) = (name.to_owned(), moves.to_owned());
    BodySpec { name, turns: true, moves, kind, z_mm: None, r_mm: None, min_mm: None, max_mm: None, points_mm: None }
}

/// Makes pieces of the measures in `answers`, which then hold the whole head as a profile has it; `like` says what was not measured.
///
/// # Errors
///
/// [`HeadFault`] for a measure that no head has, and for measures beside a `head.body`.
pub fn measured(answers: &mut Table, like: &Profile) -> Result<(), HeadFault> {
    let Some(head) = answers.get_mut("head").and_then(Value::as_table_mut) else { return Ok(()) };
    let own = ["body", "bare_cone", "measured"];
    let names = HEAD_QUESTIONS.map(|(key, _)| key.trim_start_matches("head."));
    let given: Vec<String> = head.keys().filter(|key| !own.contains(&key.as_str())).cloned().collect();
    if given.is_empty() {
        return Ok(());
    }
    for key in &given {
        if !names.contains(&key.as_str()) {
            let near = nearest(key, names.into_iter().chain(own)).filter(|(edits, _)| *edits <= MOST_EDITS);
            let meant = near.map_or_else(String::new, |(_, name)| format!("; the nearest is \"head.{name}\""));
            return wrong(&format!("head.{key}"), None, &format!("unknown key{meant}"));
        }
    }
    if head.contains_key("body") {
        return wrong(
            "head.body",
            None,
            "it describes the whole head and cannot be combined with measures; remove one",
        );
    }
    let measures = Measures(given.iter().filter_map(|key| Some((key.clone(), head.remove(key)?))).collect());
    let reach = [("x_mm", like.limits.x_mm), ("y_mm", like.limits.y_mm)].map(|(key, was)| {
        let told = answers.get("limits").and_then(|limits| limits.get(key)?.as_array());
        let end = |i: usize| {
            let value = told?.get(i)?;
            value.as_float().or_else(|| value.as_integer().map(|v| v as f64))
        };
        [end(0).unwrap_or(was[0]), end(1).unwrap_or(was[1])]
    });
    let mut roles = Roles::of(&like.head.body);
    measures.nozzle(&mut roles)?;
    measures.around("block", ["head.block_mm", "head.block_z_mm"], &mut roles.block)?;
    measures.around("carriage", ["head.carriage_mm", "head.carriage_z_mm"], &mut roles.carriage)?;
    measures.gantry(&mut roles, reach)?;
    fill_up(&mut roles);
    let bodies: Vec<Value> =
        roles.bodies().iter().filter_map(|body| Table::try_from(body).ok()).map(Value::Table).collect();
    if let Some(head) = answers.get_mut("head").and_then(Value::as_table_mut) {
        head.insert("body".to_owned(), Value::Array(bodies));
    }
    Ok(())
}
