//! The machine of Koala's G-code simulator (Koaladeen, 5-axis-3D-print-G-code-simulator): its machine.json, and the collision.json beside it.
//!
//! Sources: that program's own code as published in 2026 (machine.js, machine-config.js, collision.js, scene-objects.js) and the file of the
//! one machine that comes with it; `_version` 1.
//!
//! Frames: the program draws with x to the right, y up, z to the front (`three`), so that machine = (x, -z, y). A piece lies in the frame of
//! its part, all axes at 0, where the nozzle's tip stands on the middle of the plate. Of a path it takes `Ry(-B)` and then `Rz(-C)` for the
//! way to the part (`toPart`): both axes turn right-handed and meet in the middle of the plate's surface. Lengths mm.

mod json;
mod tree;

use toml::{Table, Value};

use self::json::Document;
use self::tree::{Role, Tree};
use super::stated::{File, Stated, StatedAt, span};
use super::{AxisRoles, Fact, ImportError, Imported, Rotary};

/// The lowest and highest C of an axis without stops, as the program has it.
const ENDLESS_DEG: f64 = 99_999.0;
/// Sides of the polygon that is drawn around a round piece beside the nozzle's axis.
const SIDES: usize = 24;
/// Of the plate's own rim nothing is printed on so much, as in the defaults.
const RIM_MM: f64 = 2.0;

/// What the files state.
///
/// # Errors
///
/// [`ImportError`] with the line.
pub(super) fn read(files: &[File]) -> Result<Imported, ImportError> {
    let (mut machine, mut pieces): (Option<Document<'_>>, Option<Document<'_>>) = (None, None);
    for file in files {
        let document = Document::read(file)?;
        let of = if document.has("proxies") && !document.has("limits") { &mut pieces } else { &mut machine };
        if let Some(first) = of {
            let why = format!(
                "{} is the same kind of file; pass one machine.json and at most one collision.json",
                first.name()
            );
            return Err(ImportError::File { file: file.name.clone(), why });
        }
        *of = Some(document);
    }
    let Some(machine) = machine else {
        let why = "collision.json has no axis limits; pass machine.json too".to_owned();
        return Err(ImportError::File { file: files.first().map_or_else(String::new, |f| f.name.clone()), why });
    };
    let version = machine.needed("_version")?;
    if version.value != 1.0 {
        let why = format!("_version must be 1, got {}", version.value);
        return Err(ImportError::At { place: version.place(), why });
    }
    let tree = Tree::of(&machine)?;
    Reader { tree: &tree, machine: &machine, notes: Vec::new() }.read(pieces.as_ref())
}

/// A convex piece, machine frame, at all words 0.
struct Piece<'a> {
    name: String,
    part: &'a str,
    shape: Shape,
    from: StatedAt,
}

enum Shape {
    /// About the nozzle's axis: from, to, radius.
    Round([f64; 2], f64),
    Box([f64; 3], [f64; 3]),
    Hull(Vec<[f64; 3]>),
}

impl Shape {
    /// Lowest and highest corner.
    fn extent(&self) -> [[f64; 3]; 2] {
        match self {
            Self::Round([low, high], r) => [[-r, -r, *low], [*r, *r, *high]],
            Self::Box(min, max) => [*min, *max],
            Self::Hull(points) => {
                let end =
                    |f: fn(f64, f64) -> f64, from: f64| [0, 1, 2].map(|i| points.iter().map(|p| p[i]).fold(from, f));
                [end(f64::min, f64::INFINITY), end(f64::max, f64::NEG_INFINITY)]
            }
        }
    }
}

struct Reader<'a> {
    tree: &'a Tree,
    machine: &'a Document<'a>,
    notes: Vec<String>,
}

impl<'a> Reader<'a> {
    fn read(mut self, pieces: Option<&Document<'_>>) -> Result<Imported, ImportError> {
        let machine = self.machine;
        let mut facts = Vec::new();
        for (axis, key) in [("x", "limits.x_mm"), ("y", "limits.y_mm"), ("z", "limits.z_mm")] {
            if let Some((low, high)) = self.ends(axis)? {
                facts.push(span(key, &low, &high, ""));
            }
        }
        let mut rotary = Vec::new();
        for (axis, letter) in [("b", 'B'), ("c", 'C')] {
            let ends = self.ends(axis)?.filter(|(low, high)| low.value > -ENDLESS_DEG || high.value < ENDLESS_DEG);
            let (min, max) = ends.unzip();
            let from = machine.place(&format!("limits.{axis}"));
            rotary.push(Rotary { letter, min, max, rate: None, acceleration: None, from, motor: String::new() });
        }
        if let Some(nozzle) = machine.number("nozzleDiameter")? {
            facts.push(Fact::number("process.nozzle_mm", &nozzle, ""));
        }
        self.chain(&mut facts);
        let (document, list) = pieces.map_or((machine, "collisionProxies"), |document| (document, "proxies"));
        if pieces.is_some() && machine.count("collisionProxies") > 0 {
            self.notes.push(format!(
                "collision proxies are read from {}; those in {} are ignored",
                document.name(),
                machine.name()
            ));
        }
        let pieces = self.pieces(document, list)?;
        self.plate(&pieces, &mut facts)?;
        self.bodies(&pieces, &mut facts)?;
        let how = "in Koala's simulator B tilts and C turns".to_owned();
        let roles = Some(AxisRoles { tilt: 'B', rotation: 'C', about: Some('Y'), how });
        Ok(Imported {
            firmware: "koala",
            facts,
            most: Vec::new(),
            rotary,
            roles,
            by_command: false,
            notes: self.notes,
            called: None,
        })
    }

    fn ends(&self, axis: &str) -> Result<Option<(Stated, Stated)>, ImportError> {
        let of = |end: &str| self.machine.number(&format!("limits.{axis}.{end}"));
        Ok(of("min")?.zip(of("max")?))
    }

    /// How the program moves all that it draws of the machine, machine frame.
    fn shift(&self) -> Result<[f64; 3], ImportError> {
        let of = |axis: &str| self.machine.number(&format!("machineOffset.{axis}")).map(|s| s.map_or(0.0, |s| s.value));
        Ok([of("x")?, of("y")?, of("z")?])
    }

    /// Where the table's axes lie and which way they turn.
    fn chain(&mut self, facts: &mut Vec<Fact>) {
        let zero = || Value::Array(vec![Value::Float(0.0); 3]);
        let place = self.tree.place.clone();
        if self.shift().is_ok_and(|shift| shift == [0.0; 3]) {
            let how = "Koala's simulator turns paths about the middle of the plate's surface";
            facts.push(Fact::new("kinematics.pivot_mm", zero(), vec![place.clone()], how));
            facts.push(Fact::new("kinematics.offset_mm", zero(), vec![place.clone()], how));
        } else {
            let at = self.machine.place("machineOffset");
            self.notes.push(format!(
                "{at}: machineOffset is not 0, so the position of the tilt axis is unknown (the simulator then turns its picture and its paths \
                 about different points)"
            ));
        }
        match self.tree.right_handed {
            Ok(()) => {
                for key in ["kinematics.tilt.direction", "kinematics.rotation.direction"] {
                    facts.push(Fact::new(
                        key,
                        1_i64,
                        vec![place.clone()],
                        "right-handed, as Koala's simulator turns paths",
                    ));
                }
            }
            Err(ref why) => self.notes.push(why.clone()),
        }
    }

    fn pieces(&self, document: &Document<'_>, list: &str) -> Result<Vec<Piece<'a>>, ImportError> {
        let shift = self.shift()?;
        let mut found = Vec::new();
        for i in 0..document.count(list) {
            let path = format!("{list}.{i}");
            let wrong =
                |of: &str, why: String| Err(ImportError::At { place: document.place(&format!("{path}.{of}")), why });
            let part = document.text(&format!("{path}.part"))?;
            let tree: &'a Tree = self.tree;
            let Some(part) = tree.name_of(&part) else {
                return wrong("part", format!("part {part:?} not found; the parts are {}", self.tree.names()));
            };
            let size = |name: &str| -> Result<f64, ImportError> {
                let stated = document.needed(&format!("{path}.{name}"))?;
                let why = format!("{name} must be above 0, got {}", stated.value);
                if stated.value > 0.0 { Ok(stated.value) } else { Err(ImportError::At { place: stated.place(), why }) }
            };
            let at = |name: &str| document.number(&format!("{path}.{name}")).map(|s| s.map_or(0.0, |s| s.value));
            let centre = turned([at("ox")?, at("oy")?, at("oz")?]);
            let centre = [0, 1, 2].map(|k| centre[k] + shift[k]);
            let kind = document.text(&format!("{path}.type"))?;
            let around = |half: [f64; 3]| {
                let end = |sign: f64| [0, 1, 2].map(|k| tidy(centre[k] + sign * half[k]));
                Shape::Box(end(-1.0), end(1.0))
            };
            let shape = match kind.as_str() {
                "box" => around([size("sx")? / 2.0, size("sz")? / 2.0, size("sy")? / 2.0]),
                // The box that holds it.
                "sphere" => around([size("sx")?; 3]),
                "cylinder" => upright(centre, size("sx")?, size("sy")?),
                "hull" if centre != shift => {
                    return wrong("type", "ox, oy and oz of a hull must be 0 (the simulator draws and checks it in different positions); add them to hullPoints, then set them to 0".to_owned());
                }
                "hull" => Shape::Hull(document.points(&format!("{path}.hullPoints"), |p| {
                    let p = turned(p);
                    [0, 1, 2].map(|k| tidy(p[k] + shift[k]))
                })?),
                other => {
                    return wrong("type", format!("unknown proxy type {other:?}; use box, cylinder, sphere or hull"));
                }
            };
            let label = document.has(&format!("{path}.label")).then(|| document.text(&format!("{path}.label")));
            let name = label
                .transpose()?
                .filter(|name| !name.is_empty())
                .unwrap_or_else(|| format!("{part} {kind} {}", i + 1));
            found.push(Piece { name, part, shape, from: document.place(&path) });
        }
        Ok(found)
    }

    /// The table: the plate, and what turns with it below and around.
    fn plate(&mut self, pieces: &[Piece<'_>], facts: &mut Vec<Fact>) -> Result<(), ImportError> {
        let of = |name: &str| self.machine.number(&format!("buildplate.{name}"));
        let (Some(width), Some(depth)) = (of("w")?, of("d")?) else { return Ok(()) };
        let (mut from, mut lowest) = ([&width.from[..], &depth.from].concat(), 0.0_f64);
        let mut how = String::new();
        if let Some(thick) = of("t")? {
            lowest = -thick.value;
            from.extend(thick.from);
        }
        let (mut half, plate) = ([width.value / 2.0, depth.value / 2.0], [width.value / 2.0, depth.value / 2.0]);
        for piece in pieces.iter().filter(|piece| self.tree.role(piece.part) == Role::Table) {
            let [min, max] = piece.shape.extent();
            lowest = lowest.min(min[2]);
            for i in 0..2 {
                half[i] = half[i].max(-min[i]).max(max[i]);
            }
            if max[2] > 0.0 {
                self.notes.push(format!(
                    "{}: a profile cannot describe {}, which reaches {:.2} mm above the plate and turns with it; collisions with it \
                     are not checked",
                    piece.from, piece.name, max[2]
                ));
            }
            "the plate and the collision proxies that turn with it".clone_into(&mut how);
            from.push(piece.from.clone());
        }
        let size = half.map(|v| Value::Float(tidy(2.0 * v)));
        facts.push(Fact::new("table.radius_mm", 0.0, width.from.clone(), "the plate is a rectangle"));
        facts.push(Fact::new("table.size_mm", Value::Array(size.to_vec()), from.clone(), &how));
        if lowest < 0.0 {
            facts.push(Fact::new("table.thickness_mm", tidy(-lowest), from.clone(), &how));
        }
        let beyond = (half[0] - plate[0]).max(half[1] - plate[1]);
        if beyond > 0.0 {
            let how = "rotating parts extend beyond the plate; nothing is printed on that margin plus 2 mm";
            facts.push(Fact::new("table.keep_out_mm", tidy(beyond + RIM_MM), from, how));
        }
        Ok(())
    }

    /// Head and frame.
    fn bodies(&mut self, pieces: &[Piece<'_>], facts: &mut Vec<Fact>) -> Result<(), ImportError> {
        let (mut head, mut fixed) = (Vec::new(), Vec::new());
        let (mut of_head, mut of_fixed) = (Vec::new(), Vec::new());
        let mut measured = false;
        for piece in pieces {
            match self.tree.role(piece.part) {
                Role::Table => {}
                Role::Cradle => self.notes.push(format!(
                    "{}: a profile cannot describe {}, which tilts with the table and does not turn with it; collisions with it are \
                     not checked",
                    piece.from, piece.name
                )),
                Role::Follows(moves) if moves.is_empty() => {
                    fixed.push(piece.body(""));
                    of_fixed.push(piece.from.clone());
                }
                Role::Follows(moves) => {
                    let low = piece.shape.extent()[0][2];
                    if piece.part == self.tree.tool() && low < 0.0 {
                        let why = format!(
                            "{} reaches {:.2} mm below the nozzle's tip, so nothing could be printed; check oy",
                            piece.name, -low
                        );
                        return Err(ImportError::At { place: piece.from.clone(), why });
                    }
                    measured |= piece.part == self.tree.tool();
                    head.push(piece.body(&moves));
                    of_head.push(piece.from.clone());
                }
            }
        }
        if measured {
            let (nozzle, from) = self.nozzle()?;
            head.splice(0..0, nozzle);
            of_head.splice(0..0, from);
            facts.push(Fact::new(
                "head.body",
                Value::Array(head),
                of_head,
                "the nozzle and the collision proxies that move with the tip",
            ));
        } else {
            self.notes.push(format!(
                "no collision proxy belongs to part {}, which carries the nozzle, so the head's shape is unknown",
                self.tree.tool()
            ));
        }
        if !fixed.is_empty() {
            let how = "collision proxies that do not move with the tip";
            facts.push(Fact::new("fixed.body", Value::Array(fixed), of_fixed, how));
        }
        Ok(())
    }

    /// Cone and shaft.
    fn nozzle(&self) -> Result<(Vec<Value>, Vec<StatedAt>), ImportError> {
        let of = |name: &str| self.machine.needed(&format!("nozzle.{name}"));
        let (tip, base, angle, length) = (of("tip")?, of("base")?, of("angle")?, of("length")?);
        let wrong = |of: &Stated, why: String| Err(ImportError::At { place: of.place(), why });
        if tip.value <= 0.0 || base.value <= tip.value {
            return wrong(
                &base,
                format!(
                    "nozzle.tip is {} mm and nozzle.base {} mm; both must be above 0, and the base wider than the tip",
                    tip.value, base.value
                ),
            );
        }
        if angle.value <= 0.0 || angle.value >= 90.0 {
            return wrong(&angle, format!("nozzle.angle must be above 0 and below 90 deg, got {}", angle.value));
        }
        if length.value < 0.0 {
            return wrong(&length, format!("nozzle.length must be at least 0 mm, got {}", length.value));
        }
        let [tip_r, base_r] = [tip.value / 2.0, base.value / 2.0];
        let top = (base_r - tip_r) / angle.value.to_radians().tan();
        let mut bodies = vec![frustum("nozzle", [0.0, top], [tip_r, base_r])];
        if length.value > 0.0 {
            bodies.push(frustum("nozzle's shaft", [top, top + length.value], [base_r, base_r]));
        }
        Ok((bodies, [&tip, &base, &angle, &length].iter().map(|stated| stated.place()).collect()))
    }
}

impl Piece<'_> {
    fn body(&self, moves: &str) -> Value {
        match &self.shape {
            Shape::Round(z, r) => {
                let mut body = table(&frustum(&self.name, *z, [*r, *r]));
                body.insert("moves".to_owned(), moves.into());
                Value::Table(body)
            }
            Shape::Box(min, max) => {
                let mut body = named(&self.name, moves, "box");
                body.insert("min_mm".to_owned(), list(min));
                body.insert("max_mm".to_owned(), list(max));
                Value::Table(body)
            }
            Shape::Hull(points) => {
                let mut body = named(&self.name, moves, "hull");
                body.insert("points_mm".to_owned(), Value::Array(points.iter().map(|p| list(p)).collect()));
                Value::Table(body)
            }
        }
    }
}

fn table(value: &Value) -> Table {
    value.as_table().cloned().unwrap_or_default()
}

fn named(name: &str, moves: &str, kind: &str) -> Table {
    let line: String = name.chars().filter(|c| !c.is_control()).collect();
    [("name", line), ("moves", moves.to_owned()), ("kind", kind.to_owned())]
        .into_iter()
        .map(|(key, text)| (key.to_owned(), Value::String(text)))
        .collect()
}

fn frustum(name: &str, z: [f64; 2], r: [f64; 2]) -> Value {
    let mut body = named(name, "XYZ", "frustum");
    body.insert("z_mm".to_owned(), list(&z.map(tidy)));
    body.insert("r_mm".to_owned(), list(&r.map(tidy)));
    Value::Table(body)
}

fn list(values: &[f64]) -> Value {
    Value::Array(values.iter().map(|v| Value::Float(*v)).collect())
}

/// The program's frame to the machine's.
fn turned([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, -z, y]
}

/// Without what sums leave behind the sixth place, and without -0.
fn tidy(value: f64) -> f64 {
    (value * 1e6).round() / 1e6 + 0.0
}

/// A cylinder along Z: about the nozzle's axis as it is, beside it a polygon around it.
fn upright([x, y, z]: [f64; 3], radius: f64, height: f64) -> Shape {
    let ends = [tidy(z - height / 2.0), tidy(z + height / 2.0)];
    if (x, y) == (0.0, 0.0) {
        return Shape::Round(ends, radius);
    }
    let around = radius / (std::f64::consts::PI / SIDES as f64).cos();
    let corner = |i: usize| {
        let (s, c) = (std::f64::consts::TAU * i as f64 / SIDES as f64).sin_cos();
        ends.map(|z| [tidy(x + around * c), tidy(y + around * s), z])
    };
    Shape::Hull((0..SIDES).flat_map(corner).collect())
}
