//! A second opinion on a finished program for a table that tilts and turns.
//!
//! ```text
//! second_opinion OUT.gcode CERTIFICATE.json [MODEL.stl]
//! ```
//!
//! A certificate claims that this very file, on this machine, makes this model by this plan. This program reads the file with its own
//! reader, its own kinematic chain and its own geometry, and shares no code with the library that wrote it. It takes from the certificate
//! only the machine's values, the plan and the figures that it compares. Exit code: 0 all right, 1 a check failed, 2 input that
//! cannot be read.
//!
//! | check | what must hold |
//! |---|---|
//! | hashes, claims | bytes and SHA-256 of program and model; the plan is of that model and that machine, and its hash and those of machine and rules are right |
//! | words | each line is understood, or is one of the profile's own start or end lines, or is allowed by name |
//! | heat | nozzle and bed are set and waited for before filament is pushed; both are off at the end |
//! | filament | what is pulled is pushed again before the next line, to 0.3 mm |
//! | limits, turns | positions, feeds and turning rates; homing; the table turns alone, with filament pulled back |
//! | order, poses | marks and lines come in the plan's order; each print's `up` is upright to 0.001 degrees |
//! | parts, inside | the model's closed shells are the plan's parts; no line's middle is more than 0.15 mm outside of its part's section |
//! | layers, amounts, cover | no layer is missing; filament for 10 to 112 % of each part, and some in each tenth; first layers and flat joints are covered to 80 % |
//! | walls, place | the outline of each layer has a line beside it; by the gaps between them a print is shifted by at most 0.03 mm, a layer by 0.1 mm |
//! | in the air | each line is on or beside something, or spans at most the plan's bridge |
//! | scrape, collisions | the tip does not dip into what is printed; the head's least distance from other prints and the table is as certified |
//! | figures | filament to 0.5 %, moves to 2 % where there are no arcs, slots |
//!
//! Heights are the distances of successive layers, and widths follow from filament and heights: of the file's comments only the marks
//! `;TRUNNION ..` and the kind of line (support, skirt, brim) are read. Parts are the closed shells in the order of the file; where
//! shells are mixed, what shares a corner is one part. A print that is numbered beyond the plan's is of supports.
//!
//! # What is not checked
//!
//! - Models that are not STL: all that needs the parts is then left out, and the nozzle's distance from prints that may share a face too.
//! - Profiles with `rtcp`: the documents do not say in which frame such a file counts. They fail.
//! - The table's first turn, before X and Y are known, and where the table stood before it.
//! - Supports are not compared with their plan, except that it has some, that they are on something and that the head does not touch
//!   them.
//! - Accelerations, jerk, pressure advance, fans, and how fast plastic melts.
//! - Whether a print holds on the table; gaps within a layer, but for first layers, flat joints and the outline.
//! - Distances are sampled: every 0.5 mm of a move, 0.5 degrees of a turn, against points every 0.5 mm of a line. So a clearance is a
//!   little above the true one, or, at a bead's corner, up to 0.05 mm below it.

use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet, HashMap};

type V = [f64; 3];
type Facet = [V; 3];

/// The print number of what lies outside of all prints: a prime line of the start code, ways between prints.
const NONE: usize = usize::MAX;
/// How far the middle of a line may be outside of its part's section, mm.
const OUTSIDE_MM: f64 = 0.15;
/// How far a sampled clearance may be below the certified one, mm.
const CLEARANCE_SLACK_MM: f64 = 0.15;
/// Clearances from here on are not compared, mm.
const CLEAR_MM: f64 = 20.0;
/// How deep a head may seem to be in another print that it slides over, mm.
const TOUCH_MM: f64 = 0.05;
/// Sections narrower than this are no faces but edges: one line fills them as it can, mm.
const FLAT_MM: f64 = 1.0;
/// How deep the nozzle may dip into a print that shares a face with the current one, mm.
const GRAZE_MM: f64 = 0.3;

/// Outcome of all checks of one program.
#[derive(Debug)]
pub struct Opinion {
    /// One entry a check, in the order they were made.
    pub checks: Vec<Check>,
}

/// Outcome of one check.
#[derive(Debug)]
pub struct Check {
    /// Short name.
    pub name: &'static str,
    /// What was looked at or measured.
    pub figure: String,
    /// The first few failures.
    pub failures: Vec<String>,
    /// Number of all failures.
    pub count: usize,
    /// Why the check was not made.
    pub left_out: Option<String>,
}

impl Check {
    fn new(name: &'static str) -> Self {
        Self { name, figure: String::new(), failures: Vec::new(), count: 0, left_out: None }
    }

    fn without(name: &'static str, why: &str) -> Self {
        Self { left_out: Some(why.to_owned()), ..Self::new(name) }
    }

    fn fail(&mut self, text: String) {
        self.count += 1;
        if self.failures.len() < 5 {
            self.failures.push(text);
        }
    }

    fn require(&mut self, holds: bool, text: impl FnOnce() -> String) {
        if !holds {
            self.fail(text());
        }
    }
}

fn add(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn scale(a: V, s: f64) -> V {
    [a[0] * s, a[1] * s, a[2] * s]
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: V) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: V) -> V {
    scale(a, 1.0 / length(a).max(1e-300))
}

fn lerp(a: V, b: V, t: f64) -> V {
    add(a, scale(sub(b, a), t))
}

/// Number of steps of at most `step` over a way.
fn steps(way: f64, step: f64) -> usize {
    (way / step).ceil().clamp(1.0, 1e6) as usize
}

fn at<'a>(value: &'a Value, path: &str) -> Result<&'a Value, String> {
    value
        .pointer(path)
        .ok_or_else(|| format!("the certificate has no {}", path.trim_start_matches('/').replace('/', ".")))
}

fn number(value: &Value, path: &str) -> Result<f64, String> {
    let number = at(value, path)?.as_f64().filter(|n| n.is_finite());
    number.ok_or_else(|| format!("{path} is not a number"))
}

fn optional(value: &Value, path: &str) -> Option<f64> {
    value.pointer(path).and_then(Value::as_f64)
}

fn text<'a>(value: &'a Value, path: &str) -> Result<&'a str, String> {
    at(value, path)?.as_str().ok_or_else(|| format!("{path} is not a text"))
}

fn list<'a>(value: &'a Value, path: &str) -> Result<&'a [Value], String> {
    at(value, path)?.as_array().map(Vec::as_slice).ok_or_else(|| format!("{path} is not a list"))
}

fn numbers<const N: usize>(value: &Value, path: &str) -> Result<[f64; N], String> {
    let found: Option<Vec<f64>> = list(value, path)?.iter().map(Value::as_f64).collect();
    found.and_then(|found| found.try_into().ok()).ok_or_else(|| format!("{path} must be {N} numbers"))
}

fn whole(value: &Value, path: &str) -> Result<usize, String> {
    at(value, path)?.as_u64().map(|n| n as usize).ok_or_else(|| format!("{path} is not a whole number"))
}

/// A turning axis of the table.
struct Axis {
    letter: char,
    along: V,
    direction: f64,
    zero: f64,
    stops: [f64; 2],
    rate: f64,
    stepper: Option<String>,
}

impl Axis {
    fn read(values: &Value, path: &str, along: V) -> Result<Self, String> {
        let at_key = |key: &str| format!("{path}/{key}");
        let letter = text(values, &at_key("letter"))?.chars().next().ok_or("an axis has no letter")?;
        let measured = values.pointer(&at_key("along")).is_some();
        let zero = number(values, &at_key("zero_deg"))?;
        // As far as cables wind from zero, where there are no stops.
        let wound = optional(values, &at_key("max_turns")).map_or(f64::INFINITY, |turns| 360.0 * turns);
        Ok(Self {
            letter,
            along: if measured { unit(numbers(values, &at_key("along"))?) } else { along },
            direction: number(values, &at_key("direction"))?,
            zero,
            stops: [
                optional(values, &at_key("min_deg")).unwrap_or(zero - wound),
                optional(values, &at_key("max_deg")).unwrap_or(zero + wound),
            ],
            rate: number(values, &at_key("max_deg_per_s"))?,
            stepper: values.pointer(&at_key("stepper")).and_then(Value::as_str).map(str::to_owned),
        })
    }

    /// Rows of the rotation matrix for a word, by Rodrigues' formula.
    fn turned(&self, word: f64) -> [V; 3] {
        let (sin, cos) = (self.direction * (word - self.zero)).to_radians().sin_cos();
        let column = |e: V| {
            add(
                add(scale(e, cos), scale(cross(self.along, e), sin)),
                scale(self.along, dot(self.along, e) * (1.0 - cos)),
            )
        };
        transposed([column([1.0, 0.0, 0.0]), column([0.0, 1.0, 0.0]), column([0.0, 0.0, 1.0])])
    }
}

fn transposed(m: [V; 3]) -> [V; 3] {
    [[m[0][0], m[1][0], m[2][0]], [m[0][1], m[1][1], m[2][1]], [m[0][2], m[1][2], m[2][2]]]
}

fn times(m: [V; 3], p: V) -> V {
    [dot(m[0], p), dot(m[1], p), dot(m[2], p)]
}

/// The table's pose: `p_machine = turn * p_table + shift`.
#[derive(Clone, Copy)]
struct Pose {
    turn: [V; 3],
    shift: V,
    words: [f64; 2],
}

impl Pose {
    fn machine(&self, p: V) -> V {
        add(times(self.turn, p), self.shift)
    }

    fn table(&self, p: V) -> V {
        times(transposed(self.turn), sub(p, self.shift))
    }
}

enum Shape {
    Frustum { z: [f64; 2], r: [f64; 2] },
    Box { low: V, high: V },
    Hull(Vec<V>),
}

/// A convex piece of the head or the frame.
struct Body {
    follows: [bool; 3],
    shape: Shape,
    corners: Vec<V>,
}

impl Body {
    fn read(value: &Value, moves: &str) -> Result<Self, String> {
        let shape = match text(value, "/kind")? {
            "frustum" => Shape::Frustum { z: numbers(value, "/z_mm")?, r: numbers(value, "/r_mm")? },
            "box" => Shape::Box { low: numbers(value, "/min_mm")?, high: numbers(value, "/max_mm")? },
            "hull" => {
                let count = list(value, "/points_mm")?.len();
                Shape::Hull((0..count).map(|i| numbers(value, &format!("/points_mm/{i}"))).collect::<Result<_, _>>()?)
            }
            kind => return Err(format!("a body is of the unknown kind {kind}")),
        };
        let corners = corners(&shape);
        Ok(Self { follows: ['X', 'Y', 'Z'].map(|axis| moves.contains(axis)), shape, corners })
    }

    /// Whether it reaches down to the tip: the part of the head that touches what it prints on.
    fn is_nozzle(&self) -> bool {
        self.follows == [true; 3] && self.corners.iter().any(|c| c[2] < 1e-6)
    }

    /// Where its own origin is while the tip is at `tip`.
    fn origin(&self, tip: V) -> V {
        [0, 1, 2].map(|i| if self.follows[i] { tip[i] } else { 0.0 })
    }

    /// Distance of a point (own frame), negative inside, and the direction from the body to it.
    fn distance(&self, p: V) -> (f64, V) {
        match &self.shape {
            Shape::Box { low, high } => box_distance(*low, *high, p),
            Shape::Frustum { z, r } => frustum_distance(*z, *r, p),
            Shape::Hull(points) => hull_distance(points, p),
        }
    }
}

fn corners(shape: &Shape) -> Vec<V> {
    match shape {
        Shape::Box { low, high } => {
            (0..8).map(|k| [0, 1, 2].map(|i| if k >> i & 1 == 0 { low[i] } else { high[i] })).collect()
        }
        Shape::Hull(points) => points.clone(),
        Shape::Frustum { z, r } => (0..64)
            .map(|k| {
                let (sin, cos) = (f64::from(k / 2) * std::f64::consts::PI / 16.0).sin_cos();
                [r[k as usize % 2] * cos, r[k as usize % 2] * sin, z[k as usize % 2]]
            })
            .collect(),
    }
}

fn box_distance(low: V, high: V, p: V) -> (f64, V) {
    let nearest = [0, 1, 2].map(|i| p[i].max(low[i]).min(high[i]));
    let away = sub(p, nearest);
    if dot(away, away) > 0.0 {
        return (length(away), unit(away));
    }
    let (mut depth, mut way) = (f64::INFINITY, [0.0; 3]);
    for i in 0..3 {
        for (d, sign) in [(p[i] - low[i], -1.0), (high[i] - p[i], 1.0)] {
            if d < depth {
                (depth, way) = (d, [0.0; 3]);
                way[i] = sign;
            }
        }
    }
    (-depth, way)
}

/// In the plane through the axis and the point: a trapezium with the corners `(0, z0), (r0, z0), (r1, z1), (0, z1)`.
fn frustum_distance(z: [f64; 2], r: [f64; 2], p: V) -> (f64, V) {
    let across = p[0].hypot(p[1]);
    let out = if across > 1e-12 { [p[0] / across, p[1] / across] } else { [1.0, 0.0] };
    let ring = [[0.0, z[0]], [r[0], z[0]], [r[1], z[1]], [0.0, z[1]]];
    let (mut best, mut inside) = ((f64::INFINITY, [0.0, 1.0]), true);
    for i in 0..3 {
        let (a, b) = (ring[i], ring[i + 1]);
        let (ex, ez) = (b[0] - a[0], b[1] - a[1]);
        let t = (((across - a[0]) * ex + (p[2] - a[1]) * ez) / (ex * ex + ez * ez).max(1e-300)).clamp(0.0, 1.0);
        let (dx, dz) = (across - a[0] - t * ex, p[2] - a[1] - t * ez);
        inside &= ex * (p[2] - a[1]) - ez * (across - a[0]) >= 0.0;
        let d = dx.hypot(dz);
        if d < best.0 {
            best = (d, if d > 1e-9 { [dx / d, dz / d] } else { [ez, -ex] });
        }
    }
    let sign = if inside { -1.0 } else { 1.0 };
    (sign * best.0, [sign * best.1[0] * out[0], sign * best.1[0] * out[1], sign * best.1[1]])
}

/// By Gilbert's iteration, stopped within a hundredth of a millimetre; 0 inside.
fn hull_distance(points: &[V], p: V) -> (f64, V) {
    let mut nearest = points.first().copied().unwrap_or_default();
    for _ in 0..200 {
        let away = sub(p, nearest);
        let Some(&far) = points.iter().max_by(|a, b| dot(**a, away).total_cmp(&dot(**b, away))) else { break };
        let gain = dot(sub(far, nearest), away);
        if gain <= 0.01 * length(away) {
            break;
        }
        let way = sub(far, nearest);
        nearest = add(nearest, scale(way, (gain / dot(way, way)).clamp(0.0, 1.0)));
    }
    let away = sub(p, nearest);
    (length(away), unit(away))
}

/// The machine, as the certificate's profile describes it.
struct Machine {
    tilt: Axis,
    rotation: Axis,
    pivot: V,
    offset: V,
    limits: [[f64; 2]; 3],
    max_feed: f64,
    min_extrude: f64,
    table_radius: f64,
    table_size: [f64; 2],
    table_thickness: f64,
    head: Vec<Body>,
    fixed: Vec<Body>,
    firmware: String,
    heats: bool,
    extruder: char,
    g90_switches: bool,
    start: Vec<String>,
    end: Vec<String>,
    allow: Vec<String>,
    retract: f64,
    prime: f64,
    bridge: f64,
    overlap: f64,
    layer: f64,
    filament_area: f64,
}

fn bodies(values: &Value, path: &str) -> Result<Vec<Body>, String> {
    let moves = |body: &Value| body.pointer("/moves").and_then(Value::as_str).unwrap_or("").to_owned();
    list(values, path)?.iter().map(|body| Body::read(body, &moves(body))).collect()
}

fn lines_of(values: &Value, path: &str) -> Vec<String> {
    let code = values.pointer(path).and_then(Value::as_str).unwrap_or("");
    code.lines().map(|line| line.split(';').next().unwrap_or("").trim().to_owned()).filter(|l| !l.is_empty()).collect()
}

impl Machine {
    fn read(values: &Value) -> Result<Self, String> {
        let about = match text(values, "/kinematics/tilt/about")? {
            "X" => [1.0, 0.0, 0.0],
            "Y" => [0.0, 1.0, 0.0],
            other => return Err(format!("the table tilts about the unknown axis {other}")),
        };
        let mut start = lines_of(values, "/dialect/start");
        start.extend(["/transition/before_turn", "/transition/after_turn"].iter().flat_map(|p| lines_of(values, p)));
        let radius = number(values, "/table/radius_mm")?;
        let diameter = number(values, "/process/filament_mm")?;
        Ok(Self {
            tilt: Axis::read(values, "/kinematics/tilt", about)?,
            rotation: Axis::read(values, "/kinematics/rotation", [0.0, 0.0, 1.0])?,
            pivot: numbers(values, "/kinematics/pivot_mm")?,
            offset: numbers(values, "/kinematics/offset_mm")?,
            limits: [
                numbers(values, "/limits/x_mm")?,
                numbers(values, "/limits/y_mm")?,
                numbers(values, "/limits/z_mm")?,
            ],
            max_feed: number(values, "/limits/max_feed_mm_per_min")?,
            min_extrude: number(values, "/limits/min_extrude_c")?,
            table_radius: radius,
            table_size: if radius > 0.0 { [0.0; 2] } else { numbers(values, "/table/size_mm")? },
            table_thickness: number(values, "/table/thickness_mm")?,
            head: bodies(values, "/head/body")?,
            fixed: bodies(values, "/fixed/body")?,
            firmware: text(values, "/dialect/firmware")?.to_owned(),
            heats: text(values, "/dialect/commands")? != "rs274",
            extruder: text(values, "/dialect/extruder")?.chars().next().ok_or("the extruder has no letter")?,
            g90_switches: at(values, "/dialect/g90_switches_extruder")?.as_bool().unwrap_or(true),
            start,
            end: lines_of(values, "/dialect/end"),
            allow: list(values, "/dialect/allow")?.iter().filter_map(Value::as_str).map(str::to_owned).collect(),
            retract: number(values, "/transition/retract_mm")?,
            prime: optional(values, "/transition/prime_mm").unwrap_or(0.0),
            bridge: number(values, "/process/bridge_mm")?,
            overlap: optional(values, "/joint/overlap_mm").unwrap_or(0.0),
            layer: number(values, "/process/layer_height_mm")?,
            filament_area: diameter * diameter * std::f64::consts::FRAC_PI_4,
        })
    }

    fn pose(&self, words: [f64; 2]) -> Pose {
        let tilt = self.tilt.turned(words[0]);
        let columns = transposed(self.rotation.turned(words[1])).map(|column| times(tilt, column));
        Pose { turn: transposed(columns), shift: add(self.pivot, times(tilt, self.offset)), words }
    }

    fn on_table(&self, p: V) -> bool {
        if self.table_radius > 0.0 {
            p[0].hypot(p[1]) <= self.table_radius
        } else {
            p[0].abs() <= self.table_size[0] / 2.0 && p[1].abs() <= self.table_size[1] / 2.0
        }
    }

    /// Distance of a point (table frame) from the table, 0 inside.
    fn table_distance(&self, p: V) -> f64 {
        let across = if self.table_radius > 0.0 {
            (p[0].hypot(p[1]) - self.table_radius).max(0.0)
        } else {
            let out = [0, 1].map(|i| (p[i].abs() - self.table_size[i] / 2.0).max(0.0));
            out[0].hypot(out[1])
        };
        across.hypot(p[2].max(-self.table_thickness - p[2]).max(0.0))
    }

    /// Points of the table's edge, 2 mm apart, above and below.
    fn rim(&self) -> Vec<V> {
        let [a, b] = self.table_size.map(|size| size / 2.0);
        let ring = |t: f64| {
            let (sin, cos) = (t * std::f64::consts::TAU).sin_cos();
            let far =
                if self.table_radius > 0.0 { self.table_radius } else { 1.0 / (cos.abs() / a).max(sin.abs() / b) };
            [far * cos, far * sin]
        };
        let count = steps(6.3 * self.table_radius.max(a + b), 2.0);
        let points = (0..count).map(|i| ring(i as f64 / count as f64));
        points.flat_map(|[x, y]| [[x, y, 0.0], [x, y, -self.table_thickness]]).collect()
    }
}

/// One print of the plan.
struct Print {
    part: usize,
    slot: usize,
    up: V,
    words: [f64; 2],
    /// Air between supports and what lies on them, mm; none where there are no supports.
    gap: Option<f64>,
}

/// The plan: prints in their order, and where the model is.
struct Plan {
    prints: Vec<Print>,
    parts: usize,
    origin: V,
    turn: f64,
    unit: f64,
    bridge: Option<f64>,
}

impl Plan {
    fn read(document: &Value) -> Result<Self, String> {
        let mut prints = Vec::new();
        for slot in list(document, "/slots")? {
            for print in list(slot, "/prints")? {
                prints.push(Print {
                    part: whole(print, "/part")?,
                    slot: whole(slot, "/id")?,
                    up: unit(numbers(print, "/up")?),
                    words: [number(print, "/tilt_deg")?, number(print, "/rotation_deg")?],
                    gap: optional(print, "/supports/gap_mm"),
                });
            }
        }
        let unit = match text(document, "/model/unit")? {
            "um" => 1e-3,
            "mm" => 1.0,
            "cm" => 10.0,
            "in" => 25.4,
            "ft" => 304.8,
            "m" => 1000.0,
            other => return Err(format!("the plan's unit {other} is unknown")),
        };
        Ok(Self {
            prints,
            parts: list(document, "/parts")?.len(),
            origin: numbers(document, "/placement/origin_mm")?,
            turn: number(document, "/placement/turn_deg")?,
            unit,
            bridge: optional(document, "/bridge_mm"),
        })
    }

    /// The plan's print of a number in the file; what is numbered beyond them are supports.
    fn print(&self, number: usize) -> Option<&Print> {
        self.prints.get(number)
    }
}

/// One straight move, or one chord of an arc.
struct Motion {
    line: usize,
    from: [f64; 5],
    to: [f64; 5],
    e: f64,
    print: usize,
    extra: bool,
}

impl Motion {
    fn tip(&self, t: f64) -> V {
        [0, 1, 2].map(|i| self.from[i] + t * (self.to[i] - self.from[i]))
    }

    fn words(&self, t: f64) -> [f64; 2] {
        [3, 4].map(|i| self.from[i] + t * (self.to[i] - self.from[i]))
    }

    fn way(&self) -> f64 {
        length(sub(self.tip(1.0), self.tip(0.0)))
    }

    fn turns(&self) -> bool {
        self.from[3] != self.to[3] || self.from[4] != self.to[4]
    }

    fn is_bead(&self) -> bool {
        self.e > 0.0 && self.way() > 1e-9
    }
}

#[derive(Default)]
struct Heater {
    target: f64,
    waited: bool,
}

/// The program as it is read, line by line.
struct Reader<'a> {
    machine: &'a Machine,
    motions: Vec<Motion>,
    marks: Vec<(usize, String)>,
    words_check: Check,
    heat: Check,
    filament: Check,
    limits: Check,
    turns: Check,
    line: usize,
    at: [f64; 5],
    e_at: f64,
    feed: f64,
    relative: bool,
    relative_e: bool,
    inverse_time: bool,
    homed: [bool; 3],
    nozzle: Heater,
    bed: Heater,
    pulled: f64,
    firmware_pulled: bool,
    push_from: f64,
    print: usize,
    extra: bool,
    printed: bool,
    ended: bool,
    moving_lines: usize,
    arcs: bool,
}

impl<'a> Reader<'a> {
    fn new(machine: &'a Machine) -> Self {
        let homes = matches!(machine.firmware.as_str(), "grbl" | "linuxcnc");
        let zero = [f64::NAN, f64::NAN, f64::NAN, machine.tilt.zero, machine.rotation.zero];
        Self {
            machine,
            motions: Vec::new(),
            marks: Vec::new(),
            words_check: Check::new("words"),
            heat: Check::new("heat"),
            filament: Check::new("filament"),
            limits: Check::new("limits"),
            turns: Check::new("turns"),
            line: 0,
            at: zero,
            e_at: 0.0,
            feed: 0.0,
            relative: false,
            relative_e: false,
            inverse_time: false,
            homed: [homes; 3],
            nozzle: Heater::default(),
            bed: Heater::default(),
            pulled: machine.retract,
            firmware_pulled: false,
            push_from: 0.0,
            print: NONE,
            extra: false,
            printed: false,
            ended: false,
            moving_lines: 0,
            arcs: false,
        }
    }

    fn strange(&mut self, what: &str) {
        let line = self.line;
        self.words_check.fail(format!("line {line}: {what}"));
    }

    fn read(&mut self, program: &str) {
        for (index, raw) in program.lines().enumerate() {
            self.line = index + 1;
            let (code, comment) = raw.split_once(';').map_or((raw, ""), |(code, comment)| (code, comment));
            let code = self.without_parentheses(code);
            self.mark(comment.trim());
            if !code.trim().is_empty() {
                self.command(code.trim());
            }
        }
        self.words_check.figure = format!("{} lines, {} moves", self.line, self.moving_lines);
        let on = self.nozzle.target > 0.0 || self.bed.target > 0.0;
        self.heat.require(!on, || "a heater is on at the end".to_owned());
        let (ended, printed) = (self.ended, self.printed);
        self.words_check.require(ended, || "the end mark is missing".to_owned());
        self.words_check.require(printed, || "nothing is printed".to_owned());
    }

    fn without_parentheses(&mut self, code: &str) -> String {
        if !code.contains(['(', ')']) {
            return code.to_owned();
        }
        if !matches!(self.machine.firmware.as_str(), "grbl" | "linuxcnc") {
            self.strange("this firmware does not read parentheses as a comment");
        }
        let mut depth = 0;
        let keep = |c: &char| {
            depth += i32::from(*c == '(');
            let outside = depth == 0;
            depth -= i32::from(*c == ')');
            outside
        };
        code.chars().filter(keep).collect()
    }

    fn mark(&mut self, comment: &str) {
        if let Some(kind) = comment.strip_prefix("TYPE:") {
            let kind = kind.to_lowercase();
            self.extra = ["support", "skirt", "brim"].iter().any(|word| kind.contains(word));
        }
        let Some(mark) = comment.strip_prefix("TRUNNION ") else { return };
        if let Some(rest) = mark.strip_prefix("print=") {
            let digits = rest.split(' ').next().unwrap_or("");
            self.print = digits.parse().unwrap_or(NONE);
            self.extra = false;
        } else if mark == "end" {
            self.ended = true;
        } else if !mark.starts_with("slot=") {
            return;
        }
        self.marks.push((self.line, mark.to_owned()));
    }

    /// Whether a line is one of the profile's own, numbers in place of `{..}`.
    fn is_own(&self, code: &str) -> bool {
        let fits = |own: &String| match own.split_once('{') {
            None => own == code,
            Some((head, tail)) => {
                let tail = tail.split_once('}').map_or("", |(_, tail)| tail);
                let middle = code.strip_prefix(head).and_then(|rest| rest.strip_suffix(tail));
                middle.is_some_and(|middle| middle.parse::<f64>().is_ok())
            }
        };
        (!self.ended && self.machine.start.iter().any(fits)) || (self.ended && self.machine.end.iter().any(fits))
    }

    fn command(&mut self, code: &str) {
        let name = code.split_whitespace().next().unwrap_or("").to_owned();
        if name == "MANUAL_STEPPER" && code.contains("MOVE=") {
            return self.stepper(code);
        }
        let free_text = ["M117", "M118", "M486", "M73"].contains(&name.as_str());
        let words = if free_text { Some(Vec::new()) } else { words(code) };
        let Some(words) = words else {
            if !self.is_own(code) && !self.machine.allow.contains(&name) {
                self.strange(&format!("{code} is not understood"));
            } else if !self.printed {
                self.homed = [true; 3];
            }
            return;
        };
        let key = if free_text { name } else { words.first().map_or(String::new(), |w| format!("{}{}", w.0, w.1)) };
        let word = |letter: char| words.iter().skip(1).find(|w| w.0 == letter).map(|w| w.1);
        if self.ended && !self.is_own(code) && !["M104", "M140", "M106", "M107", "M73"].contains(&key.as_str()) {
            self.strange(&format!("{code} behind the end mark is not of the profile's end code"));
        }
        match key.as_str() {
            "G0" | "G1" => self.straight(&words),
            "G2" | "G3" => self.arc(&words, key == "G2"),
            "G28" => self.home(&words),
            "G90" | "G91" => {
                self.relative = key == "G91";
                if self.machine.g90_switches {
                    self.relative_e = self.relative;
                }
            }
            "M82" | "M83" => self.relative_e = key == "M83",
            "G92" if words.len() == 2 && words[1].0 == self.machine.extruder => self.e_at = words[1].1,
            "G93" | "G94" if self.machine.firmware == "linuxcnc" => self.inverse_time = key == "G93",
            "G10" | "G11" if words.len() == 1 && self.machine.heats => self.firmware_pulled = key == "G10",
            "M104" | "M109" | "M140" | "M190" => self.heater(&key, word('S').or(word('R'))),
            "M116" => (self.nozzle.waited, self.bed.waited) = (self.nozzle.target > 0.0, self.bed.target > 0.0),
            "M220" | "M221" if word('S') == Some(100.0) => {}
            "M486" if !code.contains(['P', 'C']) => {}
            "G21" | "G4" | "M73" | "M105" | "M106" | "M107" | "M117" | "M118" | "M201" | "M203" | "M204" | "M205"
            | "M207" | "M208" | "M400" | "M572" | "M900" | "T0" => {}
            _ if self.is_own(code) || self.machine.allow.contains(&key) => {}
            _ => self.strange(&format!("{code} is unknown, or may not be here")),
        }
    }

    fn heater(&mut self, key: &str, target: Option<f64>) {
        let heater = if key.ends_with("40") || key.ends_with("90") { &mut self.bed } else { &mut self.nozzle };
        let waits = key == "M109" || key == "M190";
        let Some(target) = target else {
            if waits && self.machine.firmware == "klipper" {
                *heater = Heater::default();
            }
            return;
        };
        heater.waited = target > 0.0 && (waits || heater.waited);
        heater.target = target;
        if self.ended && target > 0.0 {
            let line = self.line;
            self.heat.fail(format!("line {line}: heats to {target} degrees behind the end mark"));
        }
    }

    fn home(&mut self, words: &[(char, f64)]) {
        if self.printed {
            self.strange("homes while something is on the table");
        }
        for (i, axis) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            if words.len() == 1 || words.iter().any(|w| w.0 == axis) {
                (self.homed[i], self.at[i]) = (true, f64::NAN);
            }
        }
    }

    fn stepper(&mut self, code: &str) {
        let value = |key: &str| code.split_whitespace().find_map(|word| word.strip_prefix(key)).map(str::to_owned);
        let plain =
            code.split_whitespace().skip(1).all(|w| ["STEPPER=", "MOVE=", "SPEED="].iter().any(|k| w.starts_with(k)));
        let [to, speed] = ["MOVE=", "SPEED="].map(|key| value(key).and_then(|value| value.parse::<f64>().ok()));
        let name = value("STEPPER=");
        let axis =
            [&self.machine.tilt, &self.machine.rotation].iter().position(|a| a.stepper.is_some() && a.stepper == name);
        let (true, Some(to), Some(speed), Some(axis)) = (plain, to, speed, axis) else {
            return self.strange(&format!("{code} is not understood"));
        };
        let mut target = self.at;
        target[3 + axis] = to;
        let feed = std::mem::replace(&mut self.feed, speed * 60.0);
        self.move_to(target, 0.0);
        self.feed = feed;
        self.moving_lines += 1;
    }

    /// The target of a move's words and the filament that it pushes.
    fn target(&mut self, words: &[(char, f64)]) -> ([f64; 5], f64) {
        let letters = ['X', 'Y', 'Z', self.machine.tilt.letter, self.machine.rotation.letter];
        let (mut to, mut e) = (self.at, 0.0);
        for &(letter, value) in &words[1..] {
            if let Some(i) = letters.iter().position(|l| *l == letter) {
                let by_command = i > 2 && [&self.machine.tilt, &self.machine.rotation][i - 3].stepper.is_some();
                if by_command || (self.relative && to[i].is_nan()) {
                    self.strange(&format!("{letter}{value} cannot be followed"));
                }
                to[i] = if self.relative { to[i] + value } else { value };
            } else if letter == self.machine.extruder {
                e = if self.relative_e { value } else { value - self.e_at };
                self.e_at += e;
            } else if letter == 'F' {
                self.feed = value;
            } else if !['I', 'J'].contains(&letter) || words[0].1 < 2.0 {
                self.strange(&format!("{letter}{value} is not understood"));
            }
        }
        self.moving_lines += usize::from(to != self.at || e != 0.0);
        (to, e)
    }

    fn straight(&mut self, words: &[(char, f64)]) {
        let (to, e) = self.target(words);
        self.move_to(to, e);
    }

    /// An arc in the XY plane as chords that leave it by at most 0.003 mm.
    fn arc(&mut self, words: &[(char, f64)], clockwise: bool) {
        let value = |letter: char| words.iter().find(|w| w.0 == letter).map_or(0.0, |w| w.1);
        let (from, (to, e)) = (self.at, self.target(words));
        let centre = [from[0] + value('I'), from[1] + value('J')];
        let ends = [from, to].map(|p| (p[1] - centre[1]).atan2(p[0] - centre[0]));
        let radii = [from, to].map(|p| (p[0] - centre[0]).hypot(p[1] - centre[1]));
        if !((radii[0] - radii[1]).abs() < 0.02 && radii[0] > 0.003 && from[3..] == to[3..]) {
            return self.strange("an arc whose ends are not equally far from its centre");
        }
        self.arcs = true;
        let sign = if clockwise { -1.0 } else { 1.0 };
        let mut angle = (sign * (ends[1] - ends[0])).rem_euclid(std::f64::consts::TAU);
        if angle < 1e-9 {
            angle = std::f64::consts::TAU;
        }
        let count = steps(angle, 2.0 * (1.0 - 0.003 / radii[0]).acos());
        for i in 1..=count {
            let t = i as f64 / count as f64;
            let (sin, cos) = (ends[0] + sign * angle * t).sin_cos();
            let radius = radii[0] + (radii[1] - radii[0]) * t;
            let chord =
                [centre[0] + radius * cos, centre[1] + radius * sin, from[2] + (to[2] - from[2]) * t, to[3], to[4]];
            self.move_to(if i == count { to } else { chord }, e / count as f64);
        }
    }

    fn move_to(&mut self, to: [f64; 5], e: f64) {
        if to[..3].iter().any(|x| x.abs() > 1e4) || to[3..].iter().any(|x| x.abs() > 1e5) {
            return self.limits.fail(format!("line {}: a move so far that nothing else is looked at", self.line));
        }
        if to[3..] != self.at[3..] {
            self.print = NONE;
        }
        let motion = Motion { line: self.line, from: self.at, to, e, print: self.print, extra: self.extra };
        if self.ended && !self.machine.end.iter().any(|l| l.starts_with("G0") || l.starts_with("G1")) {
            self.strange("moves behind the end mark");
        }
        self.check_limits(&motion);
        self.check_turn(&motion);
        self.check_filament(&motion);
        self.at = to;
        if motion.from != motion.to || e != 0.0 {
            self.motions.push(motion);
        }
    }

    fn check_limits(&mut self, motion: &Motion) {
        let (line, machine) = (motion.line, self.machine);
        let stops =
            [machine.limits[0], machine.limits[1], machine.limits[2], machine.tilt.stops, machine.rotation.stops];
        for i in 0..5 {
            let (value, [low, high]) = (motion.to[i], stops[i]);
            let axis = ['X', 'Y', 'Z', machine.tilt.letter, machine.rotation.letter][i];
            if value < low - 1e-6 || value > high + 1e-6 {
                self.limits.fail(format!("line {line}: {axis}{value} must be between {low} and {high}"));
            }
            if i < 3 && motion.to[i] != motion.from[i] && !motion.to[i].is_nan() && !self.homed[i] {
                self.limits.fail(format!("line {line}: {axis} moves before it was homed"));
            }
        }
        let way = motion.way();
        let feed = if self.inverse_time { self.feed * way } else { self.feed };
        let moves = [0, 1, 2].iter().any(|i| motion.to[*i] != motion.from[*i] && !motion.to[*i].is_nan());
        if moves && (feed > machine.max_feed + 1e-6 || feed <= 0.0) {
            self.limits.fail(format!("line {line}: F{feed} must be above 0 and at most {}", machine.max_feed));
        }
    }

    fn check_turn(&mut self, motion: &Motion) {
        if !motion.turns() {
            return;
        }
        let (line, turned) = (motion.line, [3, 4].map(|i| (motion.to[i] - motion.from[i]).abs()));
        let moves = [0, 1, 2].iter().any(|i| motion.to[*i] != motion.from[*i] && !motion.to[*i].is_nan());
        if moves || (turned[0] > 0.0 && turned[1] > 0.0) {
            self.turns
                .fail(format!("line {line}: an axis of the table moves with others in one line: its rate is unknown"));
        }
        if motion.e != 0.0 {
            self.turns.fail(format!("line {line}: the table turns while filament flows"));
        }
        for (by, axis) in turned.into_iter().zip([&self.machine.tilt, &self.machine.rotation]) {
            let rate = if self.inverse_time { self.feed * by } else { self.feed } / 60.0;
            if by > 0.0 && !(rate > 0.0 && rate <= axis.rate + 1e-6) {
                self.turns.fail(format!("line {line}: {rate} degrees a second, at most {}", axis.rate));
            }
        }
        if self.printed && !self.firmware_pulled && self.pulled < 0.9 * self.machine.retract {
            let pulled = self.pulled;
            self.turns.fail(format!("line {line}: the table turns with only {pulled:.2} mm of filament pulled back"));
        }
        self.push_from = self.machine.prime;
    }

    fn check_filament(&mut self, motion: &Motion) {
        let (line, pulled) = (motion.line, self.pulled);
        if motion.e > 0.0 && self.machine.heats {
            self.check_heat(line);
        }
        self.pulled -= motion.e;
        if !motion.is_bead() {
            if self.pulled < -0.3 - self.push_from {
                self.filament.fail(format!("line {line}: {:.2} mm more pushed than was pulled", -self.pulled));
            }
            return;
        }
        self.printed = true;
        if self.firmware_pulled || !(-0.3 - self.push_from..=0.3).contains(&pulled) {
            self.filament.fail(format!("line {line}: printed with {pulled:.2} mm of filament pulled back"));
        }
        (self.pulled, self.push_from) = (0.0, 0.0);
    }

    fn check_heat(&mut self, line: usize) {
        if !self.nozzle.waited || self.nozzle.target < self.machine.min_extrude {
            let target = self.nozzle.target;
            self.heat
                .fail(format!("line {line}: filament is pushed, the nozzle is set to {target} and was not waited for"));
        }
        let heats_bed = self.machine.start.iter().any(|l| l.starts_with("M140") || l.starts_with("M190"));
        if heats_bed && !(self.bed.waited && self.bed.target > 0.0) {
            let target = self.bed.target;
            self.heat
                .fail(format!("line {line}: filament is pushed, the bed is set to {target} and was not waited for"));
        }
    }
}

/// Letters and numbers of a line; none where it is anything else, or a letter comes twice.
fn words(code: &str) -> Option<Vec<(char, f64)>> {
    let (mut found, mut rest) = (Vec::<(char, f64)>::new(), code);
    while let Some(letter) = rest.chars().next() {
        if !letter.is_ascii_uppercase() || found.iter().skip(1).any(|w| w.0 == letter) {
            return None;
        }
        let tail = &rest[1..];
        let end = tail.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(tail.len());
        found.push((letter, if end == 0 && !found.is_empty() { 0.0 } else { tail[..end].parse().ok()? }));
        rest = tail[end..].trim_start();
    }
    Some(found)
}

/// A printed line, machine coordinates of its own pose, `z` at its top.
struct Bead {
    motion: usize,
    line: usize,
    ends: [V; 2],
    pose: usize,
    print: usize,
    extra: bool,
    e: f64,
    height: f64,
    width: f64,
}

impl Bead {
    fn point(&self, t: f64) -> V {
        sub(lerp(self.ends[0], self.ends[1], t), [0.0, 0.0, self.height / 2.0])
    }

    fn way(&self) -> f64 {
        length(sub(self.ends[1], self.ends[0]))
    }

    /// Places along it, at most `step` apart, ends included.
    fn places(&self, step: f64) -> impl Iterator<Item = V> + '_ {
        let count = steps(self.way(), step);
        (0..=count).map(move |i| self.point(i as f64 / count as f64))
    }
}

/// Everything that the geometric checks look at.
struct Scene<'a> {
    machine: &'a Machine,
    plan: &'a Plan,
    motions: &'a [Motion],
    poses: Vec<Pose>,
    pose_of: Vec<usize>,
    beads: Vec<Bead>,
    /// The parts' facets on the table, by number; none without a model.
    parts: Option<Vec<Vec<Facet>>>,
    /// Area of the faces that two parts share, by numbers.
    shared: BTreeMap<[usize; 2], Vec<Vec<V>>>,
}

fn key(z: f64) -> i64 {
    (z * 1000.0).round() as i64
}

impl<'a> Scene<'a> {
    fn new(machine: &'a Machine, plan: &'a Plan, motions: &'a [Motion], parts: Option<Vec<Vec<Facet>>>) -> Self {
        let (mut poses, mut pose_of, mut beads) = (Vec::<Pose>::new(), Vec::new(), Vec::new());
        for (index, motion) in motions.iter().enumerate() {
            let words = motion.words(1.0);
            if poses.last().is_none_or(|pose| pose.words != words) {
                poses.push(machine.pose(words));
            }
            pose_of.push(poses.len() - 1);
            if motion.is_bead() {
                let ends = [motion.tip(0.0), motion.tip(1.0)];
                let Motion { line, print, extra, e, .. } = *motion;
                let extra = extra || plan.print(print).is_none();
                let pose = poses.len() - 1;
                beads.push(Bead { motion: index, line, ends, pose, print, extra, e, height: 0.0, width: 0.0 });
            }
        }
        let shared = parts.as_deref().map_or_else(BTreeMap::new, shared_faces);
        let mut scene = Self { machine, plan, motions, poses, pose_of, beads, parts, shared };
        scene.measure();
        scene
    }

    /// Beads of the parts themselves, by print and layer.
    fn layers(&self, extra: bool) -> BTreeMap<usize, BTreeMap<i64, Vec<usize>>> {
        let mut layers = BTreeMap::<usize, BTreeMap<i64, Vec<usize>>>::new();
        for (index, bead) in self.beads.iter().enumerate().filter(|(_, bead)| bead.extra == extra) {
            layers.entry(bead.print).or_default().entry(key(bead.ends[1][2])).or_default().push(index);
        }
        layers
    }

    /// A print's part in machine coordinates, as the table stood when its first line was printed.
    fn mesh(&self, print: usize, first: usize) -> Option<Vec<Facet>> {
        let part = self.parts.as_ref()?.get(self.plan.print(print)?.part)?;
        let pose = &self.poses[self.beads[first].pose];
        Some(part.iter().map(|facet| facet.map(|p| pose.machine(p))).collect())
    }

    /// Heights from the distance of layers, widths from heights and filament.
    fn measure(&mut self) {
        for extra in [false, true] {
            for (print, layers) in self.layers(extra) {
                let zs: Vec<i64> = layers.keys().copied().collect();
                let mut gaps: Vec<i64> = zs.windows(2).map(|pair| pair[1] - pair[0]).collect();
                gaps.sort_unstable();
                let usual = gaps.get(gaps.len() / 2).map_or(self.machine.layer, |gap| *gap as f64 / 1000.0);
                let first = layers.values().next().and_then(|beads| beads.first()).copied().unwrap_or(0);
                let base = if extra { None } else { self.mesh(print, first).map(|mesh| lowest(&mesh)) };
                let base = base.unwrap_or(zs[0] as f64 / 1000.0 - usual);
                let mut below = base;
                for (z, beads) in layers {
                    let step = z as f64 / 1000.0 - below;
                    let height = if step > 0.02 && step < 3.0 * usual { step } else { usual };
                    below = z as f64 / 1000.0;
                    for index in beads {
                        let bead = &mut self.beads[index];
                        bead.height = height;
                        bead.width =
                            bead.e * self.machine.filament_area / length(sub(bead.ends[1], bead.ends[0])) / height;
                    }
                }
            }
        }
    }

    fn check_order(&self, marks: &[(usize, String)]) -> Check {
        let mut check = Check::new("order");
        let mut group = vec![0];
        for pair in self.plan.prints.windows(2) {
            let same = pair[0].slot == pair[1].slot && pair[0].words == pair[1].words;
            group.push(group[group.len() - 1] + usize::from(!same));
        }
        let (mut now, mut met) = (0, BTreeSet::new());
        for bead in &self.beads {
            check.require(self.may_be(bead), || {
                format!("line {}: a line of no part, which the plan does not have", bead.line)
            });
            let Some(&of) = group.get(bead.print) else { continue };
            check.require(of >= now, || format!("line {}: print {} goes on behind a later one", bead.line, bead.print));
            now = now.max(of);
            met.insert(bead.print);
        }
        for print in (0..group.len()).filter(|print| !met.contains(print)) {
            check.fail(format!("print {print} of the plan is not printed"));
        }
        let letters = [self.machine.tilt.letter, self.machine.rotation.letter];
        for (line, mark) in marks {
            self.check_mark(&mut check, *line, mark, letters);
        }
        check.figure = format!("{} prints, {} poses in a row", met.len(), self.poses.len());
        check
    }

    /// Whether a line is of a part, or the plan has supports, or it is a skirt, a brim or a prime line on the level table.
    fn may_be(&self, bead: &Bead) -> bool {
        let (pose, supported) = (&self.poses[bead.pose], self.plan.prints.iter().any(|print| print.gap.is_some()));
        let level = pose.turn[2][2] > 1.0 - 1e-9 && pose.table(bead.point(0.0))[2] < 1.0;
        !bead.extra || level || (supported && bead.print != NONE)
    }

    fn check_mark(&self, check: &mut Check, line: usize, mark: &str, letters: [char; 2]) {
        let value = |key: &str| mark.split(' ').find_map(|word| word.strip_prefix(key)?.strip_prefix('='));
        let parts = value("part").map(|list| list.split(',').filter_map(|n| n.parse().ok()).collect::<Vec<usize>>());
        if let Some(print) = value("print").and_then(|n| n.parse().ok()).and_then(|n| self.plan.print(n)) {
            check
                .require(parts == Some(vec![print.part]), || format!("line {line}: the mark's part is not the plan's"));
        }
        let Some(slot) = value("slot").and_then(|n| n.parse::<usize>().ok()) else { return };
        let words =
            letters.map(|letter| value(&letter.to_string()).and_then(|w| w.parse::<f64>().ok()).unwrap_or(f64::NAN));
        let fits = |print: &&Print| print.slot == slot && (0..2).all(|i| (print.words[i] - words[i]).abs() <= 1e-3);
        let planned: Vec<usize> = self.plan.prints.iter().filter(fits).map(|print| print.part).collect();
        let known = parts.is_some_and(|parts| !parts.is_empty() && parts.iter().all(|part| planned.contains(part)));
        check.require(known, || format!("line {line}: the plan has no such pose: {mark}"));
    }

    fn check_poses(&self) -> Check {
        let (mut check, mut worst) = (Check::new("poses"), 0.0_f64);
        for bead in &self.beads {
            let Some(print) = self.plan.print(bead.print) else { continue };
            let pose = &self.poses[bead.pose];
            let up = times(pose.turn, print.up);
            let off = up[0].hypot(up[1]).atan2(up[2]).to_degrees();
            worst = worst.max(off);
            let words = (0..2).map(|i| (pose.words[i] - print.words[i]).abs()).fold(off, f64::max);
            check.require(words <= 1e-3, || {
                format!("line {}: print {} is {words:.4} degrees off its pose", bead.line, bead.print)
            });
        }
        check.figure = format!("at most {worst:.6} degrees off");
        check
    }

    fn check_inside(&self) -> Check {
        let (mut check, mut worst) = (Check::new("inside"), 0.0_f64);
        for (print, layers) in self.layers(false) {
            let first = layers.values().next().map_or(0, |beads| beads[0]);
            let Some(mesh) = self.mesh(print, first) else { continue };
            for beads in layers.values() {
                let section = Section::new(&mesh, self.beads[beads[0]].point(0.0)[2]);
                for bead in beads.iter().map(|index| &self.beads[*index]) {
                    let out = bead.places(0.5).map(|p| section.outside(p)).fold(0.0, f64::max);
                    worst = worst.max(out);
                    check.require(out <= OUTSIDE_MM, || {
                        format!("line {}: {out:.3} mm outside of the part of print {print}", bead.line)
                    });
                }
            }
        }
        check.figure = format!("at most {worst:.3} mm outside");
        check
    }

    /// Layers follow each other without a gap, from the part's lowest point to its highest.
    fn check_layers(&self) -> Check {
        let (mut check, mut count) = (Check::new("layers"), 0);
        for (print, layers) in self.layers(false) {
            let first = layers.values().next().map_or(0, |beads| beads[0]);
            let Some(mesh) = self.mesh(print, first) else { continue };
            let mut gaps: Vec<f64> = layers.values().map(|beads| self.beads[beads[0]].height).collect();
            gaps.sort_by(f64::total_cmp);
            let usual = gaps[gaps.len() / 2];
            let top = mesh.iter().flatten().map(|p| p[2]).fold(f64::NEG_INFINITY, f64::max);
            let mut below = lowest(&mesh);
            count += layers.len();
            let (first, usual_first) = (&self.beads[first], usual - self.machine.overlap / 2.0);
            // A part that begins with an edge has no first layer at its height: slicers leave out what is narrower than a line.
            let is_flat = Section::new(&mesh, below + usual / 4.0).mean_width() > FLAT_MM;
            let on_material = is_flat && self.poses[first.pose].table(first.ends[0])[2] > 1.0;
            let off = (first.ends[0][2] - below - usual_first).abs() - self.machine.overlap / 2.0;
            check.require(!on_material || off <= 0.05, || {
                format!("line {}: the first layer of print {print} is {off:.3} mm off its height", first.line)
            });
            let tops = layers.iter().map(|(z, beads)| (*z as f64 / 1000.0, self.beads[beads[0]].line));
            for (z, line) in tops.chain([(top, 0)]) {
                let section = Section::new(&mesh, (below + z) / 2.0);
                // What is hardly wider than a line may be left out.
                let room = section.area() > 1.0 && section.mean_width() > 0.6;
                let most = if line > 0 { 1.5 } else { 0.7 } * usual;
                if z - below > most && room {
                    check.fail(format!("print {print}: no layer between {below:.3} and {z:.3} (line {line})"));
                }
                if z - below < 0.3 * usual && line > 0 {
                    check.fail(format!("line {line}: only {:.3} mm above what is below", z - below));
                }
                below = z;
            }
        }
        check.figure = format!("{count} layers");
        check
    }

    /// The outline of each layer has a line beside it, and its lines' edges are where the outline is.
    fn check_walls(&self) -> (Check, Check) {
        let (mut walls, mut place) = (Check::new("walls"), Check::new("place"));
        let (mut barest, mut worst, mut worst_layer) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (print, layers) in self.layers(false) {
            let first = layers.values().next().map_or(0, |beads| beads[0]);
            let Some(mesh) = self.mesh(print, first) else { continue };
            let mut whole = Fit::default();
            for beads in layers.values() {
                let near = Near::new(beads.iter().map(|index| &self.beads[*index]).collect());
                let line = near.beads[0].line;
                let (mut fit, mut bare) = (Fit::default(), 0.0);
                for (p, out) in Section::new(&mesh, near.beads[0].point(0.0)[2]).outline() {
                    if near.least(p, |_| 0.0) > 0.55 {
                        bare += 0.5;
                    } else {
                        fit.add(out, near.least(p, |bead| bead.width / 2.0));
                    }
                }
                whole.join(&fit);
                let off = fit.shift();
                (barest, worst_layer) = (barest.max(bare), worst_layer.max(off));
                walls.require(bare <= 2.0, || {
                    format!("line {line}: print {print}: {bare:.1} mm of the layer's outline without a line")
                });
                place.require(off <= 0.1, || {
                    format!("line {line}: print {print}: this layer is shifted by {off:.3} mm")
                });
            }
            let off = whole.shift();
            worst = worst.max(off);
            place.require(off <= 0.03, || format!("print {print} is shifted by {off:.3} mm"));
        }
        walls.figure = format!("at most {barest:.1} mm of a layer's outline without a line");
        place.figure = format!("shifted by at most {worst:.3} mm, a layer by {worst_layer:.3} mm");
        (walls, place)
    }

    /// Volume of filament against volume of parts, as a whole and in ten slices.
    fn check_amounts(&self) -> Check {
        let (mut check, mut range) = (Check::new("amounts"), [f64::INFINITY, 0.0_f64]);
        for (print, layers) in self.layers(false) {
            let first = layers.values().next().map_or(0, |beads| beads[0]);
            let Some(mesh) = self.mesh(print, first) else { continue };
            let low = lowest(&mesh);
            let high = mesh.iter().flatten().map(|p| p[2]).fold(f64::NEG_INFINITY, f64::max);
            let mut slices = [0.0; 10];
            for bead in layers.values().flatten().map(|index| &self.beads[*index]) {
                let slice = ((bead.point(0.0)[2] - low) / (high - low) * 10.0).clamp(0.0, 9.0) as usize;
                slices[slice] += bead.e * self.machine.filament_area;
            }
            let share = slices.iter().sum::<f64>() / volume(&mesh);
            range = [range[0].min(share), range[1].max(share)];
            check.require((0.1..=1.12).contains(&share), || {
                format!("print {print}: filament for {:.0} % of its part", share * 100.0)
            });
            for (i, filled) in slices.iter().enumerate() {
                let room =
                    Section::new(&mesh, low + (high - low) * (i as f64 + 0.5) / 10.0).area() * (high - low) / 10.0;
                check.require(room < 1.0 || *filled > 0.05 * room, || {
                    format!("print {print}: {filled:.1} of {room:.1} mm3 in slice {i} of 10")
                });
            }
        }
        check.figure = format!("{:.0} to {:.0} % of the parts", range[0] * 100.0, range[1] * 100.0);
        check
    }

    /// First layers and flat faces shared with other parts are covered.
    fn check_cover(&self) -> Check {
        let (mut check, mut least, mut count) = (Check::new("cover"), 1.0_f64, 0);
        for (print, layers) in self.layers(false) {
            let first = layers.values().next().map_or(0, |beads| beads[0]);
            let Some(mesh) = self.mesh(print, first) else { continue };
            let mut look = |what: &str, beads: &[usize], points: &[V]| {
                let line = beads.first().map_or(0, |index| self.beads[*index].line);
                let beads: Vec<&Bead> = beads.iter().map(|index| &self.beads[*index]).collect();
                let share = covered(beads, points);
                (least, count) = (least.min(share), count + 1);
                check.require(share >= 0.8, || {
                    format!("line {line}: print {print}: {:.0} % of {what} is covered", share * 100.0)
                });
            };
            if let Some(beads) = layers.values().next() {
                let section = Section::new(&mesh, self.beads[beads[0]].point(0.0)[2]);
                let points = section.raster(0.2);
                if points.len() > 25 && section.mean_width() > FLAT_MM {
                    look("its first layer", beads, &points);
                }
            }
            let part = self.plan.print(print).map_or(0, |print| print.part);
            let pose = &self.poses[self.beads[first].pose];
            for (pair, faces) in self.shared.iter().filter(|(pair, _)| pair.contains(&part)) {
                let mut by_layer = BTreeMap::<i64, Vec<V>>::new();
                for face in faces.iter().map(|face| face.iter().map(|p| pose.machine(*p)).collect::<Vec<V>>()) {
                    let normal = unit(cross(sub(face[1], face[0]), sub(face[2], face[0])));
                    if normal[2].abs() > 0.9999 {
                        by_layer.entry(key(face[0][2])).or_default().extend(raster_of(&face, 0.2));
                    }
                }
                let other = pair[usize::from(pair[0] == part)];
                for (z, points) in by_layer.iter().filter(|(_, points)| points.len() > 25) {
                    let z = *z as f64 / 1000.0;
                    let holds = |beads: &&Vec<usize>| {
                        (self.beads[beads[0]].point(0.0)[2] - z).abs() <= 0.75 * self.beads[beads[0]].height
                    };
                    match layers.values().find(holds) {
                        Some(beads) => look(&format!("the joint with part {other}"), beads, points),
                        None => look(&format!("the joint with part {other}, which has no layer,"), &[], points),
                    }
                }
            }
        }
        check.figure = format!("{count} faces, at least {:.0} %", least * 100.0);
        check
    }
}

fn lowest(mesh: &[Facet]) -> f64 {
    mesh.iter().flatten().map(|p| p[2]).fold(f64::INFINITY, f64::min)
}

fn volume(mesh: &[Facet]) -> f64 {
    mesh.iter().map(|[a, b, c]| dot(*a, cross(*b, *c)) / 6.0).sum()
}

/// A horizontal cut through a mesh, its segments by rows of half a millimetre.
struct Section {
    segments: Vec<[f64; 4]>,
    rows: HashMap<i64, Vec<usize>>,
}

fn row(y: f64) -> i64 {
    (y * 2.0).floor() as i64
}

impl Section {
    fn new(mesh: &[Facet], z: f64) -> Self {
        let mut segments = Vec::new();
        for facet in mesh {
            let above = facet.map(|p| p[2] >= z);
            let Some(lone) = (0..3).find(|i| above[*i] != above[(i + 1) % 3] && above[*i] != above[(i + 2) % 3]) else {
                continue;
            };
            let cut = |other: usize| {
                let (a, b) = (facet[lone], facet[other % 3]);
                let p = lerp(a, b, (z - a[2]) / (b[2] - a[2]));
                [p[0], p[1]]
            };
            let [p, q] = [cut(lone + 1), cut(lone + 2)];
            let (p, q) = if above[lone] { (p, q) } else { (q, p) };
            segments.push([p[0], p[1], q[0], q[1]]);
        }
        let mut rows = HashMap::<i64, Vec<usize>>::new();
        for (index, s) in segments.iter().enumerate() {
            for r in row(s[1].min(s[3]))..=row(s[1].max(s[3])) {
                rows.entry(r).or_default().push(index);
            }
        }
        Self { segments, rows }
    }

    fn area(&self) -> f64 {
        self.segments.iter().map(|s| (s[0] * s[3] - s[2] * s[1]) / 2.0).sum::<f64>().abs()
    }

    /// Twice its area over its outline, mm.
    fn mean_width(&self) -> f64 {
        let outline: f64 = self.segments.iter().map(|s| (s[2] - s[0]).hypot(s[3] - s[1])).sum();
        2.0 * self.area() / outline.max(1e-9)
    }

    fn holds(&self, p: V) -> bool {
        let mut winding = 0;
        for s in self.rows.get(&row(p[1])).into_iter().flatten().map(|index| self.segments[*index]) {
            if (s[1] <= p[1]) != (s[3] <= p[1]) && s[0] + (p[1] - s[1]) / (s[3] - s[1]) * (s[2] - s[0]) > p[0] {
                winding += if s[1] <= p[1] { 1 } else { -1 };
            }
        }
        winding != 0
    }

    /// How far outside a point is, at most 5 mm; 0 inside.
    fn outside(&self, p: V) -> f64 {
        if self.holds(p) {
            return 0.0;
        }
        let mut best = 5.0_f64;
        for reach in 0..=10 {
            if (reach - 1) as f64 * 0.5 > best {
                break;
            }
            for r in [row(p[1]) - reach, row(p[1]) + reach] {
                for s in self.rows.get(&r).into_iter().flatten().map(|index| self.segments[*index]) {
                    best = best.min(segment_distance([s[0], s[1]], [s[2], s[3]], [p[0], p[1]]));
                }
            }
        }
        best
    }

    /// Points of the outline, half a millimetre apart, and the direction across it.
    fn outline(&self) -> Vec<(V, [f64; 2])> {
        let (mut points, mut walked) = (Vec::new(), 0.25);
        for s in &self.segments {
            let (dx, dy) = (s[2] - s[0], s[3] - s[1]);
            let way = dx.hypot(dy);
            while walked < way {
                points.push((lerp([s[0], s[1], 0.0], [s[2], s[3], 0.0], walked / way), [dy / way, -dx / way]));
                walked += 0.5;
            }
            walked -= way;
        }
        points
    }

    /// Points inside, on a grid.
    fn raster(&self, step: f64) -> Vec<V> {
        let ring: Vec<V> = self.segments.iter().map(|s| [s[0], s[1], 0.0]).collect();
        grid(&ring, step).into_iter().filter(|p| self.holds(*p)).collect()
    }
}

fn segment_distance(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let t = (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / (dx * dx + dy * dy).max(1e-300)).clamp(0.0, 1.0);
    (p[0] - a[0] - t * dx).hypot(p[1] - a[1] - t * dy)
}

/// A grid over the box of some points.
fn grid(points: &[V], step: f64) -> Vec<V> {
    let bound = |i: usize, sign: f64| sign * points.iter().map(|p| sign * p[i]).fold(f64::NEG_INFINITY, f64::max);
    if points.is_empty() {
        return Vec::new();
    }
    let [low, high] = [-1.0, 1.0].map(|sign| [bound(0, sign), bound(1, sign)]);
    let [nx, ny] = [0, 1].map(|i| steps(high[i] - low[i], step));
    let place = |i: usize, n: usize, k: usize| low[i] + (high[i] - low[i]) * (k as f64 + 0.5) / n as f64;
    (0..nx * ny).map(|k| [place(0, nx, k % nx), place(1, ny, k / nx), points[0][2]]).collect()
}

/// Points of a convex polygon, on a grid.
fn raster_of(face: &[V], step: f64) -> Vec<V> {
    let side = |a: V, b: V, p: V| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    let holds = |p: &V| {
        let mut sides = (0..face.len()).map(|i| side(face[i], face[(i + 1) % face.len()], *p));
        sides.clone().all(|s| s >= 0.0) || sides.all(|s| s <= 0.0)
    };
    grid(face, step).into_iter().filter(holds).collect()
}

/// Beads of one layer, in cells of a millimetre.
struct Near<'a> {
    beads: Vec<&'a Bead>,
    cells: HashMap<[i64; 2], Vec<usize>>,
}

impl<'a> Near<'a> {
    fn cell(x: f64, y: f64) -> [i64; 2] {
        [x.floor() as i64, y.floor() as i64]
    }

    fn new(beads: Vec<&'a Bead>) -> Self {
        let mut cells = HashMap::<[i64; 2], Vec<usize>>::new();
        for (index, bead) in beads.iter().enumerate() {
            for p in bead.places(0.5) {
                for k in 0..9 {
                    let met =
                        cells.entry(Self::cell(p[0] + f64::from(k % 3 - 1), p[1] + f64::from(k / 3 - 1))).or_default();
                    if met.last() != Some(&index) {
                        met.push(index);
                    }
                }
            }
        }
        Self { beads, cells }
    }

    /// Least distance of a bead's middle from a point, less `reach`; infinite from a millimetre on.
    fn least(&self, p: V, reach: impl Fn(&Bead) -> f64) -> f64 {
        let near = self.cells.get(&Self::cell(p[0], p[1])).into_iter().flatten().map(|index| self.beads[*index]);
        let far = |bead: &Bead| {
            let [a, b] = bead.ends.map(|end| [end[0], end[1]]);
            segment_distance(a, b, [p[0], p[1]]) - reach(bead)
        };
        near.map(far).fold(f64::INFINITY, f64::min)
    }
}

/// The share of points that lie under a bead.
fn covered(beads: Vec<&Bead>, points: &[V]) -> f64 {
    let near = Near::new(beads);
    let under = points.iter().filter(|p| near.least(**p, |bead| bead.width / 2.0 + 0.01) <= 0.0);
    under.count() as f64 / points.len().max(1) as f64
}

/// Least squares of `gap = inset + direction * shift` over an outline.
#[derive(Default)]
struct Fit {
    matrix: [V; 3],
    right: V,
}

impl Fit {
    fn add(&mut self, out: [f64; 2], gap: f64) {
        let row = [1.0, out[0], out[1]];
        self.right = add(self.right, scale(row, gap));
        self.matrix = [0, 1, 2].map(|i| add(self.matrix[i], scale(row, row[i])));
    }

    fn join(&mut self, other: &Self) {
        self.right = add(self.right, other.right);
        self.matrix = [0, 1, 2].map(|i| add(self.matrix[i], other.matrix[i]));
    }

    /// Length of the shift; 0 where too little is known.
    fn shift(&self) -> f64 {
        let ([a, b, c], r) = (self.matrix, self.right);
        let whole = dot(a, cross(b, c));
        if a[0] < 20.0 || whole < 1e-3 * a[0].powi(3) {
            return 0.0;
        }
        // The matrix is symmetric: its rows are its columns.
        (dot(a, cross(r, c)) / whole).hypot(dot(a, cross(b, r)) / whole)
    }
}

/// Polygons in which facets of two parts lie on each other, by the parts' numbers.
fn shared_faces(parts: &[Vec<Facet>]) -> BTreeMap<[usize; 2], Vec<Vec<V>>> {
    let bound = |part: &[Facet], i: usize, sign: f64| {
        part.iter().flatten().map(|p| sign * p[i]).fold(f64::NEG_INFINITY, f64::max)
    };
    let mut shared = BTreeMap::new();
    for (a, b) in (0..parts.len()).flat_map(|a| (a + 1..parts.len()).map(move |b| (a, b))) {
        let low = [0, 1, 2].map(|i| -bound(&parts[a], i, -1.0).min(bound(&parts[b], i, -1.0)) - 0.02);
        let high = [0, 1, 2].map(|i| bound(&parts[a], i, 1.0).min(bound(&parts[b], i, 1.0)) + 0.02);
        let meets = |facet: &&Facet| {
            (0..3).all(|i| facet.iter().any(|p| p[i] >= low[i]) && facet.iter().any(|p| p[i] <= high[i]))
        };
        let near: Vec<&Facet> = parts[b].iter().filter(meets).collect();
        for facet in parts[a].iter().filter(meets) {
            for face in near.iter().filter_map(|other| overlap(facet, other)) {
                shared.entry([a, b]).or_insert_with(Vec::new).push(face);
            }
        }
    }
    shared
}

/// The polygon that two facets share whose normals are opposite.
fn overlap(a: &Facet, b: &Facet) -> Option<Vec<V>> {
    let [n, m] = [a, b].map(|f| unit(cross(sub(f[1], f[0]), sub(f[2], f[0]))));
    if dot(n, m) > -0.9999 || b.iter().any(|p| dot(sub(*p, a[0]), n).abs() > 0.02) {
        return None;
    }
    let mut ring = b.to_vec();
    for i in 0..3 {
        let inward = cross(n, unit(sub(a[(i + 1) % 3], a[i])));
        let side = |p: V| dot(sub(p, a[i]), inward);
        let mut kept = Vec::new();
        for (k, &p) in ring.iter().enumerate() {
            let q = ring[(k + 1) % ring.len()];
            if side(p) >= 0.0 {
                kept.push(p);
            }
            if (side(p) >= 0.0) != (side(q) >= 0.0) {
                kept.push(lerp(p, q, side(p) / (side(p) - side(q))));
            }
        }
        ring = kept;
    }
    let area = |ring: &[V]| {
        (2..ring.len()).map(|i| dot(cross(sub(ring[i - 1], ring[0]), sub(ring[i], ring[0])), m) / 2.0).sum::<f64>()
    };
    (ring.len() > 2 && area(&ring) > 1e-3).then_some(ring)
}

/// Facets of an STL, binary or ASCII; none where it is not one.
fn stl(bytes: &[u8]) -> Option<Vec<Facet>> {
    let single = |at: usize| Some(f64::from(f32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?)));
    let count = u32::from_le_bytes(bytes.get(80..84).unwrap_or(&[0; 4]).try_into().ok()?) as usize;
    if count > 0 && bytes.len() == 84 + 50 * count {
        let corner = |at: usize| Some([single(at)?, single(at + 4)?, single(at + 8)?]);
        let facet = |i: usize| Some([corner(96 + 50 * i)?, corner(108 + 50 * i)?, corner(120 + 50 * i)?]);
        return (0..count).map(facet).collect();
    }
    let text = std::str::from_utf8(bytes).ok()?.trim_start();
    let mut corners = Vec::new();
    let mut words = text.starts_with("solid").then(|| text.split_whitespace())?;
    while let Some(word) = words.next() {
        if word == "vertex" {
            let mut coordinate = || words.next()?.parse::<f64>().ok();
            corners.push([coordinate()?, coordinate()?, coordinate()?]);
        }
    }
    (!corners.is_empty() && corners.len() % 3 == 0).then(|| corners.chunks(3).map(|c| [c[0], c[1], c[2]]).collect())
}

fn bits(p: V) -> [u64; 3] {
    p.map(|x| (x + 0.0).to_bits())
}

/// Closed shells. In the order of the file where each is closed before the next begins, else what shares corners.
fn shells(facets: &[Facet]) -> Vec<Vec<Facet>> {
    let (mut open, mut found, mut now) = (HashMap::new(), Vec::new(), Vec::new());
    for facet in facets {
        now.push(*facet);
        for i in 0..3 {
            let (a, b) = (bits(facet[i]), bits(facet[(i + 1) % 3]));
            let (edge, by) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
            let count = open.entry(edge).or_insert(0);
            *count += by;
            if *count == 0 {
                open.remove(&edge);
            }
        }
        if open.is_empty() {
            found.push(std::mem::take(&mut now));
        }
    }
    if now.is_empty() { found } else { joined(facets) }
}

/// Facets that share corners, in the order of their first one.
fn joined(facets: &[Facet]) -> Vec<Vec<Facet>> {
    fn root(of: &mut [usize], mut i: usize) -> usize {
        while of[i] != i {
            of[i] = of[of[i]];
            i = of[i];
        }
        i
    }
    let (mut of, mut corners) = ((0..facets.len()).collect::<Vec<usize>>(), HashMap::new());
    for (index, facet) in facets.iter().enumerate() {
        for p in facet {
            let [a, b] = [root(&mut of, index), *corners.entry(bits(*p)).or_insert(index)];
            let b = root(&mut of, b);
            of[a.max(b)] = a.min(b);
        }
    }
    let mut found = BTreeMap::<usize, Vec<Facet>>::new();
    for (index, facet) in facets.iter().enumerate() {
        found.entry(root(&mut of, index)).or_default().push(*facet);
    }
    found.into_values().collect()
}

/// The model's parts on the table, by the plan's numbers: a shell turned inside out is a hollow of the part before it.
fn parts_of(plan: &Plan, model: &[u8], check: &mut Check) -> Option<Vec<Vec<Facet>>> {
    let (sin, cos) = plan.turn.to_radians().sin_cos();
    let place = |p: V| {
        let [x, y, z] = scale(p, plan.unit);
        add([cos * x - sin * y, sin * x + cos * y, z], plan.origin)
    };
    let mut parts = Vec::<Vec<Facet>>::new();
    for shell in shells(&stl(model)?) {
        let shell: Vec<Facet> = shell.iter().map(|facet| facet.map(place)).collect();
        match parts.last_mut() {
            Some(part) if volume(&shell) < 0.0 => part.extend(shell),
            _ => parts.push(shell),
        }
    }
    check.figure = format!("{} closed shells, {} parts in the plan", parts.len(), plan.parts);
    if parts.len() != plan.parts {
        check.fail("shells and parts differ: nothing can be compared with the model".to_owned());
        return None;
    }
    for part in 0..parts.len() {
        let printed = plan.prints.iter().any(|print| print.part == part);
        check.require(printed, || format!("the plan does not print part {part}"));
    }
    for part in plan.prints.iter().map(|print| print.part).filter(|part| *part >= parts.len()) {
        check.fail(format!("the plan prints part {part}, which the model does not have"));
    }
    Some(parts)
}

/// A point of a printed line's middle, table frame.
struct Dot {
    p: V,
    bead: usize,
    chain: usize,
    path: f64,
    /// The stretch in the air that it is of; 0 where it is none.
    stretch: usize,
}

/// Everything printed so far, in cells of a millimetre.
struct Cloud {
    cells: HashMap<[i32; 3], Vec<Dot>>,
    /// Whether each stretch hangs between two ends, so that others may lean on it.
    holds: Vec<bool>,
    longest: f64,
}

impl Cloud {
    fn cell(p: V) -> [i32; 3] {
        p.map(|x| x.floor() as i32)
    }

    fn insert(&mut self, dot: Dot) {
        self.cells.entry(Self::cell(dot.p)).or_default().push(dot);
    }

    fn near(&self, p: V) -> impl Iterator<Item = &Dot> {
        let reach = 0.85;
        let [low, high] = [-reach, reach].map(|by| Self::cell(p.map(|x| x + by)));
        let cells = (low[0]..=high[0])
            .flat_map(move |x| (low[1]..=high[1]).flat_map(move |y| (low[2]..=high[2]).map(move |z| [x, y, z])));
        cells.filter_map(|cell| self.cells.get(&cell)).flatten()
    }
}

/// A stretch of a chain of lines with nothing below or beside it.
#[derive(Default)]
struct Stretch {
    closed: bool,
    from_start: bool,
    /// How long it was at the beginning of a closed chain, mm.
    held: f64,
    held_number: usize,
    number: usize,
    long: f64,
    line: usize,
}

impl Scene<'_> {
    fn check_air(&self) -> (Check, Check) {
        let (mut air, mut scrape) = (Check::new("in the air"), Check::new("scrape"));
        let mut cloud = Cloud { cells: HashMap::new(), holds: vec![true], longest: 0.0 };
        let mut deepest = 0.0_f64;
        let (mut chain, mut path, mut last, mut stretch) = (0, 0.0, NONE, Stretch::default());
        let mut beads = self.beads.iter().enumerate().peekable();
        for (index, motion) in self.motions.iter().enumerate() {
            let Some((number, bead)) = beads.next_if(|(_, bead)| bead.motion == index) else {
                let deep = self.dip(&cloud, index);
                deepest = deepest.max(deep);
                scrape.require(deep <= 0.1, || {
                    format!("line {}: the tip is {deep:.2} mm deep in what is printed", motion.line)
                });
                continue;
            };
            if last == NONE || last + 1 != index || self.beads[number - 1].print != bead.print {
                self.end_chain(&mut air, &mut cloud, stretch);
                (chain, stretch) =
                    (chain + 1, Stretch { from_start: true, closed: self.closes(number), ..Stretch::default() });
            }
            last = index;
            let mut dots = Vec::new();
            let (count, pose) = (steps(bead.way(), 0.5), &self.poses[bead.pose]);
            for (i, p) in bead.places(0.5).enumerate() {
                let walked = path + bead.way() * i as f64 / count as f64;
                let mut dot = Dot { p: pose.table(p), bead: number, chain, path: walked, stretch: 0 };
                if self.is_grounded(&cloud, &dot) {
                    let free = usize::from(stretch.from_start);
                    if stretch.from_start && stretch.closed {
                        (stretch.held, stretch.held_number) = (stretch.long, stretch.number);
                    } else {
                        self.end_stretch(&mut air, &mut cloud, &stretch, free);
                    }
                    (stretch.from_start, stretch.long) = (false, 0.0);
                } else {
                    if stretch.long == 0.0 {
                        stretch.number = cloud.holds.len();
                        cloud.holds.push(false);
                    }
                    dot.stretch = stretch.number;
                    stretch.long += if i > 0 { bead.way() / count as f64 } else { 1e-9 };
                    stretch.line = bead.line;
                }
                dots.push(dot);
            }
            path += bead.way();
            dots.into_iter().for_each(|dot| cloud.insert(dot));
        }
        self.end_chain(&mut air, &mut cloud, stretch);
        air.figure = format!("longest stretch {:.1} mm", cloud.longest);
        scrape.figure = format!("at most {deepest:.2} mm deep");
        (air, scrape)
    }

    /// Whether a chain of lines ends where it begins.
    fn closes(&self, number: usize) -> bool {
        let first = &self.beads[number];
        let follows = |(i, bead): &(usize, &Bead)| bead.motion == first.motion + i && bead.print == first.print;
        let last = self.beads[number..].iter().enumerate().take_while(follows).last();
        last.is_some_and(|(i, last)| i > 1 && length(sub(last.ends[1], first.ends[0])) < 0.6)
    }

    /// A closed chain holds on to its own beginning.
    fn end_chain(&self, air: &mut Check, cloud: &mut Cloud, mut stretch: Stretch) {
        let free = match (stretch.closed, stretch.from_start) {
            (true, false) => 0,
            (_, from_start) => 1 + usize::from(from_start),
        };
        stretch.long += stretch.held;
        self.end_stretch(air, cloud, &stretch, free);
        cloud.holds[stretch.held_number] = stretch.held == 0.0 || cloud.holds[stretch.number];
    }

    fn end_stretch(&self, air: &mut Check, cloud: &mut Cloud, stretch: &Stretch, free: usize) {
        let long = stretch.long;
        cloud.longest = cloud.longest.max(long);
        let most = [self.plan.bridge.unwrap_or(self.machine.bridge) + 1.0, 3.0, 1.5][free];
        cloud.holds[stretch.number] |= free == 0 && long <= most;
        air.require(long <= most, || {
            format!("line {}: {long:.1} mm in the air, {free} of its ends free, at most {most}", stretch.line)
        });
    }

    /// Whether something is below or beside a point, or it is on the table.
    fn is_grounded(&self, cloud: &Cloud, dot: &Dot) -> bool {
        let bead = &self.beads[dot.bead];
        let (height, up) = (bead.height, self.poses[bead.pose].turn[2]);
        if self.machine.on_table(dot.p) && (-0.1..=1.1 * height).contains(&dot.p[2]) {
            return true;
        }
        let gap = self.plan.print(bead.print).and_then(|print| print.gap).unwrap_or(0.0);
        cloud.near(dot.p).any(|other| {
            let way = sub(other.p, dot.p);
            let rise = dot_product(way, up);
            let across = length(sub(way, scale(up, rise)));
            let under = &self.beads[other.bead];
            if under.pose != bead.pose && under.print != bead.print {
                return length(way) <= 0.85 && rise < 0.3 * height;
            }
            let beside = rise.abs() <= 0.3 * height
                && cloud.holds[other.stretch]
                && (other.chain != dot.chain || dot.path - other.path > 1.5);
            across <= 0.6 && (beside || (-1.5 * height.max(under.height) - gap..-0.3 * height).contains(&rise))
        })
    }

    /// How deep the tip goes below the top of what is printed, or below the table.
    fn dip(&self, cloud: &Cloud, index: usize) -> f64 {
        let (motion, pose) = (&self.motions[index], &self.poses[self.pose_of[index]]);
        if motion.turns() || motion.tip(0.0).iter().chain(&motion.tip(1.0)).any(|x| x.is_nan()) {
            return 0.0;
        }
        let (count, up, mut deep) = (steps(motion.way(), 0.5), pose.turn[2], 0.0_f64);
        for i in 0..=count {
            let p = pose.table(motion.tip(i as f64 / count as f64));
            if self.machine.on_table(p) && p[2] > -self.machine.table_thickness {
                deep = deep.max(-p[2]);
            }
            for other in cloud.near(p) {
                let (way, bead) = (sub(other.p, p), &self.beads[other.bead]);
                let rise = dot_product(way, up);
                if length(sub(way, scale(up, rise))) < 0.2 && dot_product(self.poses[bead.pose].turn[2], up) > 0.999 {
                    deep = deep.max(rise + bead.height / 2.0);
                }
            }
        }
        deep
    }
}

fn dot_product(a: V, b: V) -> f64 {
    dot(a, b)
}

/// Points in nested balls, table frame.
struct Tree {
    /// Centre, radius, and the points `from..to`; inner nodes have their children behind them, at +1 and at `right`.
    balls: Vec<Ball>,
    points: Vec<(V, [f64; 2])>,
    up: V,
    reach: f64,
}

struct Ball {
    centre: V,
    radius: f64,
    right: usize,
    from: usize,
    to: usize,
}

impl Tree {
    /// Of points with half a height and half a width, built along `up`.
    fn new(points: Vec<(V, [f64; 2])>, up: V) -> Self {
        let reach = points.iter().map(|(_, half)| half[0].hypot(half[1])).fold(0.0, f64::max);
        let count = points.len();
        let mut tree = Self { balls: Vec::new(), points, up, reach };
        tree.grow(0, count);
        tree
    }

    fn grow(&mut self, from: usize, to: usize) {
        let points = &mut self.points[from..to];
        let bound =
            |i: usize, sign: f64| sign * points.iter().map(|(p, _)| sign * p[i]).fold(f64::NEG_INFINITY, f64::max);
        let (low, high) = ([0, 1, 2].map(|i| bound(i, -1.0)), [0, 1, 2].map(|i| bound(i, 1.0)));
        let centre = lerp(low, high, 0.5);
        let radius = points.iter().map(|(p, _)| length(sub(*p, centre))).fold(0.0, f64::max);
        let here = self.balls.len();
        self.balls.push(Ball { centre, radius, right: 0, from, to });
        if to - from <= 6 {
            return;
        }
        let wide = (0..3).max_by(|a, b| (high[*a] - low[*a]).total_cmp(&(high[*b] - low[*b]))).unwrap_or(0);
        let middle = (to - from) / 2;
        points.select_nth_unstable_by(middle, |a, b| a.0[wide].total_cmp(&b.0[wide]));
        self.grow(from, from + middle);
        self.balls[here].right = self.balls.len();
        self.grow(from + middle, to);
    }

    /// The least distance of a body from the points' beads, or `limit`: by the plane between them that is across the way from one to the
    /// other, or level.
    fn clearance(&self, body: &Body, origin: V, pose: &Pose, limit: f64) -> f64 {
        let bound = |index: usize| {
            let ball = &self.balls[index];
            (body.distance(sub(pose.machine(ball.centre), origin)).0 - ball.radius - self.reach, index)
        };
        let (mut best, mut stack, up) = (limit, vec![bound(0)], times(pose.turn, self.up));
        let bottom = body.corners.iter().map(|corner| dot(*corner, up)).fold(f64::INFINITY, f64::min);
        while let Some((far, index)) = stack.pop() {
            let ball = &self.balls[index];
            if far >= best {
                continue;
            }
            if ball.right > 0 {
                let (a, b) = (bound(index + 1), bound(ball.right));
                stack.extend(if a.0 < b.0 { [b, a] } else { [a, b] });
                continue;
            }
            for (p, half) in &self.points[ball.from..ball.to] {
                let p = sub(pose.machine(*p), origin);
                let (far, way) = body.distance(p);
                let rise = dot(way, up).clamp(-1.0, 1.0);
                let apart = far - half[0] * rise.abs() - half[1] * (1.0 - rise * rise).sqrt();
                best = best.min(apart.max(bottom - dot(p, up) - half[0]));
            }
        }
        best
    }
}

/// What was printed, by print, as trees of growing size.
struct Printed {
    trees: BTreeMap<usize, Vec<Tree>>,
    pending: Vec<(V, [f64; 2])>,
    rim: Tree,
}

impl Printed {
    fn close(&mut self, print: usize, up: V) {
        let mut points = std::mem::take(&mut self.pending);
        let trees = self.trees.entry(print).or_default();
        while trees.last().is_some_and(|last| last.points.len() < 2 * points.len()) {
            points.extend(trees.pop().into_iter().flat_map(|tree| tree.points));
        }
        if !points.is_empty() {
            trees.push(Tree::new(points, up));
        }
    }
}

/// A least distance as it is searched: nothing nearer than `best` can be met within `slack` of way.
struct Watch {
    best: f64,
    line: usize,
    slack: f64,
    least: f64,
}

impl Scene<'_> {
    /// Whether the nozzle prints on or beside another print as if it were its own.
    fn shares(&self, a: usize, b: usize) -> bool {
        let (Some(p), Some(q)) = (self.plan.print(a), self.plan.print(b)) else { return true };
        self.parts.is_none() || self.shared.contains_key(&[p.part.min(q.part), p.part.max(q.part)])
    }

    /// Least distance of the head from what it does not print on (`own`: from what it does), or `limit`.
    fn clearance(&self, printed: &Printed, motion: &Motion, pose: &Pose, tip: V, own: bool, limit: f64) -> f64 {
        let (mut best, between) = (limit, motion.print == NONE || motion.turns());
        let stands = !between && self.plan.print(motion.print).is_none_or(|print| print.up[2] > 0.9999);
        let frame = self.machine.fixed.iter().filter(|_| own && motion.turns());
        for body in self.machine.head.iter().filter(|body| !own || body.is_nozzle()).chain(frame) {
            let (origin, nozzle) = (body.origin(tip), body.is_nozzle());
            let (fixed, mut found) = (body.follows == [false; 3], best);
            for (print, trees) in &printed.trees {
                let carries = nozzle && !between && self.shares(motion.print, *print);
                if (fixed || carries == own) && (between || *print != motion.print) {
                    found = trees.iter().fold(found, |found, tree| tree.clearance(body, origin, pose, found));
                }
            }
            if fixed || !(own || nozzle && stands) {
                found = printed.rim.clearance(body, origin, pose, found);
                let corners = body.corners.iter().map(|c| self.machine.table_distance(pose.table(add(*c, origin))));
                found = corners.fold(found, f64::min);
            }
            best = if !fixed {
                found
            } else if found > 0.0 {
                best
            } else {
                -1.0
            };
        }
        best
    }

    fn check_collisions(&self, certified: Option<f64>) -> Check {
        let mut check = Check::new("collisions");
        let least = certified.filter(|c| *c < CLEAR_MM).map_or(0.0, |c| (c - CLEARANCE_SLACK_MM).max(-TOUCH_MM));
        let rim = self.machine.rim().into_iter().map(|p| (p, [0.0; 2])).collect();
        let mut printed = Printed { trees: BTreeMap::new(), pending: Vec::new(), rim: Tree::new(rim, [0.0, 0.0, 1.0]) };
        let mut watches = [
            Watch { best: CLEAR_MM, line: 0, slack: 0.0, least },
            Watch { best: 0.0, line: 0, slack: 0.0, least: -GRAZE_MM },
        ];
        let mut beads = self.beads.iter().peekable();
        let mut before = (NONE, 0);
        for (index, motion) in self.motions.iter().enumerate() {
            let now = (motion.print, self.pose_of[index]);
            if now != before {
                let up = self.plan.print(before.0).map_or(self.poses[before.1].turn[2], |print| print.up);
                printed.close(before.0, up);
                watches.iter_mut().for_each(|watch| watch.slack = 0.0);
                before = now;
            }
            if motion.tip(0.0).iter().chain(&motion.tip(1.0)).any(|x| x.is_nan()) {
                continue;
            }
            for (own, watch) in [false, true].into_iter().zip(&mut watches) {
                self.follow(&printed, motion, own, watch, &mut check);
            }
            if let Some(bead) = beads.next_if(|bead| bead.motion == index) {
                let (pose, half) = (&self.poses[bead.pose], [bead.height / 2.0, bead.width.min(1.5) / 2.0]);
                printed.pending.extend(bead.places(0.5).map(|p| (pose.table(p), half)));
            }
        }
        let [watch, graze] = watches;
        let claim = certified.map_or("nothing".to_owned(), |c| format!("{c:.2} mm"));
        let (best, line, deep) = (watch.best, watch.line, -graze.best);
        check.figure = format!(
            "clearance {best:.2} mm (line {line}), certified {claim}; nozzle {deep:.2} mm in joints (line {})",
            graze.line
        );
        check
    }

    /// Looks along one move, as densely as the last distance allows.
    fn follow(&self, printed: &Printed, motion: &Motion, own: bool, watch: &mut Watch, check: &mut Check) {
        let turned = (0..2).map(|i| (motion.words(1.0)[i] - motion.words(0.0)[i]).abs()).fold(0.0, f64::max);
        let way = motion.way();
        let (whole, step) = (if turned > 0.0 { turned } else { way }, 0.5_f64);
        let mut done = if turned > 0.0 { 0.0 } else { watch.slack };
        let pose = self.machine.pose(motion.words(1.0));
        while done <= whole {
            let t = if whole > 0.0 { done / whole } else { 1.0 };
            let turned_pose = if turned > 0.0 { self.machine.pose(motion.words(t)) } else { pose };
            let found = self.clearance(printed, motion, &turned_pose, motion.tip(t), own, watch.best + 4.0);
            if found < watch.best {
                (watch.best, watch.line) = (found, motion.line);
            }
            if found < watch.least {
                let what = if own { "clearance of the nozzle from what it prints on" } else { "clearance" };
                check.fail(format!("line {}: {what} {found:.2} mm", motion.line));
                break;
            }
            let free = if turned > 0.0 { 0.0 } else { (found - watch.best).max(0.0) };
            if done >= whole || done + free > whole {
                watch.slack = done + free - whole;
                return;
            }
            done = (done + free.max(step)).min(whole);
        }
        watch.slack = if turned > 0.0 { 0.0 } else { (done - whole).max(0.0) };
    }
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The claims that need no reading of the program.
fn check_claims(program: &[u8], certificate: &Value, model: Option<&[u8]>) -> Result<Vec<Check>, String> {
    let (mut hashes, mut claims) = (Check::new("hashes"), Check::new("claims"));
    if text(certificate, "/format")? != "trunnion-certificate" || whole(certificate, "/version")? != 1 {
        return Err("this is not a trunnion-certificate of version 1".to_owned());
    }
    let bytes = whole(certificate, "/program/bytes")?;
    hashes.require(bytes == program.len(), || format!("{} bytes, certified {bytes}", program.len()));
    hashes.require(text(certificate, "/program/sha256")? == sha256(program), || "the program's differs".to_owned());
    let certified = text(certificate, "/model/sha256")?;
    hashes.require(model.is_none_or(|model| sha256(model) == certified), || "the model's differs".to_owned());
    hashes.figure = format!("{bytes} bytes{}", if model.is_some() { ", and the model" } else { "" });
    let planned = text(certificate, "/plan/document/model/sha256")?;
    claims.require(planned == certified, || "the plan is of another model".to_owned());
    let machine = text(certificate, "/plan/document/machine/sha256")?;
    claims.require(text(certificate, "/machine/sha256")? == machine, || "the plan is of another machine".to_owned());
    let [plan, values, rules] = ["/plan/document", "/machine/values", "/rules"].map(|path| at(certificate, path));
    let indented = format!("{:#}\n", plan?);
    claims
        .require(text(certificate, "/plan/sha256")? == sha256(indented.as_bytes()), || "the plan's differs".to_owned());
    for (path, document) in [("/machine/sha256", values?), ("/rules_sha256", rules?)] {
        let hash = sha256(document.to_string().as_bytes());
        claims.require(text(certificate, path)? == hash, || format!("{} differs", path.trim_start_matches('/')));
    }
    claims.figure = format!("{} rules", list(certificate, "/rules")?.len());
    Ok(vec![hashes, claims])
}

/// Moves are compared where there are no arcs: in how many chords the certificate counts those is not documented.
fn check_figures(certificate: &Value, scene: &Scene<'_>, moves: usize, arcs: bool) -> Result<Check, String> {
    let mut check = Check::new("figures");
    let filament = scene.motions.iter().map(|motion| motion.e).sum::<f64>();
    let certified = number(certificate, "/figures/filament_mm")?;
    let off = (filament / certified - 1.0).abs();
    check.require(off <= 0.005, || format!("{filament:.1} mm of filament, certified {certified:.1}"));
    let claimed = number(certificate, "/figures/moves")?;
    check.require(arcs || (moves as f64 / claimed - 1.0).abs() <= 0.02, || {
        format!("{moves} moves, certified {claimed}")
    });
    let slots: BTreeSet<usize> = scene.plan.prints.iter().map(|print| print.slot).collect();
    let claimed = number(certificate, "/figures/slots")?;
    check.require(slots.len() as f64 == claimed, || format!("{} slots, certified {claimed}", slots.len()));
    check.figure = format!("{filament:.1} mm of filament, {moves} moves");
    Ok(check)
}

/// Checks a finished program against its certificate and, where given, its model.
///
/// # Errors
///
/// A sentence where the certificate cannot be read, or names what is unknown.
pub fn check(program: &[u8], certificate: &Value, model: Option<&[u8]>) -> Result<Opinion, String> {
    let mut checks = check_claims(program, certificate, model)?;
    let values = at(certificate, "/machine/values")?;
    let (machine, plan) = (Machine::read(values)?, Plan::read(at(certificate, "/plan/document")?)?);
    if at(values, "/dialect/rtcp")?.as_bool() != Some(false) {
        let mut kinematics = Check::new("kinematics");
        kinematics.fail("not checked: the profile has rtcp, which is not documented well enough".to_owned());
        checks.push(kinematics);
        return Ok(Opinion { checks });
    }
    let program = std::str::from_utf8(program).map_err(|_| "the program is not a text".to_owned())?;
    let mut reader = Reader::new(&machine);
    reader.read(program);
    if !machine.heats {
        reader.heat = Check::without("heat", "the firmware heats nothing");
    }
    let mut parts_check = Check::new("parts");
    let no_stl = "the model is not an STL";
    let parts = match model {
        None => {
            parts_check.left_out = Some("no model was given".to_owned());
            None
        }
        Some(model) => {
            let parts = parts_of(&plan, model, &mut parts_check);
            if parts.is_none() && parts_check.count == 0 {
                parts_check.left_out = Some(no_stl.to_owned());
            }
            parts
        }
    };
    let (moves, arcs) = (reader.moving_lines, reader.arcs);
    let scene = Scene::new(&machine, &plan, &reader.motions, parts);
    let clearance = optional(certificate, "/figures/clearance_mm");
    let figures = check_figures(certificate, &scene, moves, arcs)?;
    let (air, scrape) = scene.check_air();
    let order = scene.check_order(&reader.marks);
    let mut later = vec![order, scene.check_poses()];
    if scene.parts.is_some() {
        later.extend([scene.check_inside(), scene.check_layers(), scene.check_amounts()]);
        let (walls, place) = scene.check_walls();
        later.extend([scene.check_cover(), walls, place]);
    } else {
        let names = ["inside", "layers", "amounts", "cover", "walls", "place"];
        later.extend(names.map(|name| Check::without(name, "there are no parts to compare with")));
    }
    later.extend([air, scrape, scene.check_collisions(clearance), figures]);
    checks.extend([reader.words_check, reader.heat, reader.filament, reader.limits, reader.turns, parts_check]);
    checks.extend(later);
    Ok(Opinion { checks })
}

fn opinion() -> Result<Opinion, String> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let (program, certificate, model) = match files.as_slice() {
        [program, certificate] => (program, certificate, None),
        [program, certificate, model] => (program, certificate, Some(model)),
        _ => return Err("usage: second_opinion OUT.gcode CERTIFICATE.json [MODEL.stl]".to_owned()),
    };
    let read = |file: &String| std::fs::read(file).map_err(|error| format!("{file}: {error}"));
    let document = serde_json::from_slice(&read(certificate)?).map_err(|error| format!("{certificate}: {error}"))?;
    let model = model.map(read).transpose()?;
    check(&read(program)?, &document, model.as_deref())
}

#[allow(clippy::print_stdout, clippy::print_stderr)]
fn main() {
    let opinion = opinion().unwrap_or_else(|error| {
        eprintln!("{error}");
        std::process::exit(2)
    });
    for check in &opinion.checks {
        match (&check.left_out, check.count) {
            (Some(why), 0) => println!("{:<12} left out: {why}", check.name),
            (_, 0) => println!("{:<12} ok      {}", check.name, check.figure),
            (_, count) => println!("{:<12} FAILED  {} ({count})", check.name, check.figure),
        }
        check.failures.iter().for_each(|failure| println!("    {failure}"));
    }
    std::process::exit(i32::from(opinion.checks.iter().any(|check| check.count > 0)));
}
