//! LinuxCNC: the ini with its HAL files.
//!
//! Sources: LinuxCNC's documentation (INI configuration, HAL basics, 5-axis kinematics). Both an axis and its joints have limits, and both
//! hold: with the identity kinematics, in which poses are sent, the narrower ones count. `xyzac-trt-kins` turns the table right-handed for
//! positive words, about a point d = (x-offset, y-offset, z-offset) from the rotation axis, and the other way with `conventional-directions`.

mod hal;
mod ini;

use self::hal::Hal;
use self::ini::{Entry, Ini};
use super::stated::{
    Fact, File, ImportError, Open, Rotary, Shelf, Stated, StatedAt, least, number, scaled, shown, span,
};
use super::{AxisRoles, Imported, about, by_name, two};

/// Kinematics whose joints are not the axes, one by one; the axes' own limits hold.
const OTHER_JOINTS: [&str; 2] = ["corexykins", "lineardeltakins"];
/// Tables that tilt: kinematics, order of its joints, the offset that counts beside z-offset.
const TABLES: [(&str, &str, usize); 2] = [("xyzac-trt-kins", "XYZAC", 1), ("xyzbc-trt-kins", "XYZBC", 0)];
/// What a number may be counted in, and the factor to mm and degrees.
const LENGTHS: [(&str, f64); 5] = [("mm", 1.0), ("metric", 1.0), ("inch", 25.4), ("in", 25.4), ("imperial", 25.4)];
const ANGLES: [(&str, f64); 6] = [
    ("deg", 1.0),
    ("degree", 1.0),
    ("rad", 180.0 / std::f64::consts::PI),
    ("radian", 180.0 / std::f64::consts::PI),
    ("grad", 0.9),
    ("gon", 0.9),
];

pub(super) fn read(inis: &[&File], hals: &[&File], shelf: &dyn Shelf) -> Result<Imported, ImportError> {
    let [file] = inis else {
        let (file, first) = (inis[1].name.clone(), &inis[0].name);
        return Err(ImportError::File {
            file,
            why: format!("{first} is also an ini file; give the ini file of one machine only"),
        });
    };
    let ini = Ini::read(file, shelf)?;
    let hal = Hal::read(file, hals, &ini, shelf)?;
    Reader::of(&ini)?.machine(&hal)
}

struct Reader<'a> {
    ini: &'a Ini,
    /// The line of KINEMATICS, its first word and the letters of the joints in their order; empty where joints are not axes.
    kinematics: &'a Entry,
    name: String,
    joints: Vec<char>,
    letters: Vec<char>,
    length: f64,
    angle: f64,
}

impl<'a> Reader<'a> {
    fn of(ini: &'a Ini) -> Result<Self, ImportError> {
        let kinematics = ini.wanted("KINS", "KINEMATICS")?;
        let mut words = kinematics.value.split_ascii_whitespace();
        let name = words.next().unwrap_or_default().to_owned();
        let given = words.find_map(|word| Some(word.strip_prefix("coordinates=")?.to_ascii_uppercase()));
        let order = match TABLES.iter().find(|(table, _, _)| *table == name) {
            Some((_, order, _)) => given.unwrap_or_else(|| (*order).to_owned()),
            None if name == "trivkins" => given.unwrap_or_else(|| "XYZABCUVW".to_owned()),
            None if OTHER_JOINTS.contains(&&*name) => String::new(),
            None => {
                let tables = TABLES.map(|(table, _, _)| table).join(", ");
                let why = format!(
                    "kinematics {} is not supported; use trivkins, {}, {tables}",
                    shown(&name),
                    OTHER_JOINTS.join(", ")
                );
                return Err(ImportError::At { place: kinematics.place.clone(), why });
            }
        };
        let letters = ini.wanted("TRAJ", "COORDINATES")?;
        let letters = letters.value.chars().filter(|c| !c.is_whitespace()).map(|c| c.to_ascii_uppercase()).collect();
        let length = unit(ini.wanted("TRAJ", "LINEAR_UNITS")?, &LENGTHS)?;
        let angle = ini.one("TRAJ", "ANGULAR_UNITS")?.map_or(Ok(1.0), |entry| unit(entry, &ANGLES))?;
        Ok(Self { ini, kinematics, name, joints: order.chars().collect(), letters, length, angle })
    }

    fn machine(&self, hal: &Hal) -> Result<Imported, ImportError> {
        let mut notes = hal.unread.clone();
        let rotary: Vec<Rotary> = ['A', 'B', 'C']
            .into_iter()
            .filter(|letter| self.letters.contains(letter))
            .map(|letter| self.rotary(letter))
            .collect::<Result<_, _>>()?;
        let coordinates = self.ini.wanted("TRAJ", "COORDINATES")?;
        two(&rotary, &coordinates.place, &format!("[TRAJ] COORDINATES = {}", shown(&coordinates.value)))?;
        let firmware = vec![self.kinematics.place.clone()];
        let mut facts = vec![Fact::new("dialect.firmware", "linuxcnc", firmware, "an ini of LinuxCNC")];
        for (letter, key) in [('X', "limits.x_mm"), ('Y', "limits.y_mm"), ('Z', "limits.z_mm")] {
            let [low, high] = self.ends(letter)?;
            if let (Some(low), Some(high)) = (low, high) {
                facts.push(span(key, &low, &high, ""));
            }
        }
        let most = self.speeds(&mut facts)?;
        let mut roles = by_name(&rotary);
        if let Some((_, order, beside)) = TABLES.iter().find(|(table, _, _)| *table == self.name) {
            let tilt = if order.contains('A') { 'A' } else { 'B' };
            roles = Some(AxisRoles { tilt, rotation: 'C', about: Some(about(tilt)), how: format!("by {}", self.name) });
            self.table(hal, *beside, &mut facts, &mut notes)?;
            if !self.kinematics.value.contains("identityfirst") {
                notes.push(format!(
                    "{}: {} is active when LinuxCNC starts (no sparm=identityfirst) and would apply the tilt a second time; keep M429 (identity \
                     kinematics) in dialect.start",
                    self.kinematics.place, self.name
                ));
            }
        }
        let remaps = self.ini.every("RS274NGC", "REMAP");
        if !remaps.iter().any(|entry| entry.value.trim_start().starts_with("M429")) {
            notes.push(format!(
                "{}: no REMAP defines M429 (identity kinematics), so LinuxCNC rejects it in dialect.start; add the sample configurations' \
                 remap, or remove M429 if no other kinematics can be active",
                self.kinematics.place
            ));
        }
        if !TABLES.iter().any(|(table, _, _)| *table == self.name) {
            notes.push(format!(
                "{}: {} does not say whether the rotary axes turn a table or a head; it must be a table",
                self.kinematics.place, self.name
            ));
        }
        if !self.letters.iter().any(|letter| "UVW".contains(*letter)) {
            notes.push(format!(
                "{}: [TRAJ] COORDINATES = {} has no axis U, V or W for the extruder; add one, and pass --set \
                 dialect.extruder=LETTER",
                coordinates.place, coordinates.value
            ));
        }
        let called = self.ini.one("EMC", "MACHINE")?.map(|entry| entry.value.clone());
        Ok(Imported { firmware: "linuxcnc", facts, most, rotary, roles, by_command: false, notes, called })
    }

    /// The sections that hold for an axis: its own, and its joints'.
    fn sections(&self, letter: char) -> Vec<String> {
        let joints = self.joints.iter().enumerate().filter(|(_, joint)| **joint == letter);
        std::iter::once(format!("AXIS_{letter}")).chain(joints.map(|(i, _)| format!("JOINT_{i}"))).collect()
    }

    /// What each of `sections` says under `key`, in the profile's unit.
    fn all(&self, sections: &[String], key: &str, factor: f64) -> Result<Vec<Stated>, ImportError> {
        let mut all = Vec::new();
        for section in sections {
            if let Some(entry) = self.ini.one(section, key)? {
                let value = number(&format!("[{section}] {key}"), entry.bare(), &entry.place)?;
                all.push(Stated { value: scaled(value, factor), from: vec![entry.place.clone()] });
            }
        }
        Ok(all)
    }

    /// The narrower of all limits of an axis: lowest and highest.
    fn ends(&self, letter: char) -> Result<[Option<Stated>; 2], ImportError> {
        let factor = if "ABC".contains(letter) { self.angle } else { self.length };
        let sections = self.sections(letter);
        let lows = self.all(&sections, "MIN_LIMIT", factor)?;
        let highs = self.all(&sections, "MAX_LIMIT", factor)?;
        let low = lows.into_iter().reduce(|a, b| if b.value > a.value { b } else { a });
        let high = highs.into_iter().reduce(|a, b| if b.value < a.value { b } else { a });
        Ok([low, high])
    }

    fn slowest(&self, letter: char, key: &str, overall: &str) -> Result<Option<Stated>, ImportError> {
        let factor = if "ABC".contains(letter) { self.angle } else { self.length };
        let own = self.all(&self.sections(letter), key, factor)?;
        let overall = self.all(&["TRAJ".to_owned()], overall, factor)?;
        Ok(least(own.iter().chain(&overall).map(Some)))
    }

    fn rotary(&self, letter: char) -> Result<Rotary, ImportError> {
        let sections = self.sections(letter);
        let section = &sections[0];
        if let Some(wrapped) = self.ini.one(section, "WRAPPED_ROTARY")?
            && !matches!(wrapped.bare(), "0" | "NO" | "FALSE")
        {
            let why = format!(
                "[{section}] WRAPPED_ROTARY is not supported (words of {letter} count within one turn, and their sign gives the direction); remove \
                 the line"
            );
            return Err(ImportError::At { place: wrapped.place.clone(), why });
        }
        let [min, max] = self.ends(letter)?;
        let rate = self.slowest(letter, "MAX_VELOCITY", "MAX_ANGULAR_VELOCITY")?;
        let acceleration = self.slowest(letter, "MAX_ACCELERATION", "MAX_ANGULAR_ACCELERATION")?;
        let first = self.ini.first(section).or_else(|| sections.get(1).and_then(|joint| self.ini.first(joint)));
        let from = first.unwrap_or(self.kinematics.place.clone());
        Ok(Rotary { letter, min, max, rate, acceleration, from, motor: String::new() })
    }

    /// Speeds and how fast they change; gives back what the profile's own travels may be at most.
    fn speeds(&self, facts: &mut Vec<Fact>) -> Result<Vec<Fact>, ImportError> {
        let of = |key, overall| ['X', 'Y', 'Z'].map(|letter| self.slowest(letter, key, overall));
        let [x, y, z] = of("MAX_VELOCITY", "MAX_LINEAR_VELOCITY");
        let (x, y, z) = (x?, y?, z?);
        let mut most = Vec::new();
        let a_minute = |mut stated: Stated| {
            stated.value = scaled(stated.value, 60.0);
            stated
        };
        if let Some(fastest) = least([x.as_ref(), y.as_ref()]).filter(|_| x.is_some() && y.is_some()).map(a_minute) {
            facts.push(Fact::number("limits.max_feed_mm_per_min", &fastest, "the slower of X and Y, in mm/min"));
            most.push(Fact::number("transition.travel_mm_per_min", &fastest, "lowered to the slower of X and Y"));
        }
        most.extend(
            z.map(a_minute).map(|z| Fact::number("transition.z_mm_per_min", &z, "lowered to the maximum speed of Z")),
        );
        let [x, y, z] = of("MAX_ACCELERATION", "MAX_LINEAR_ACCELERATION");
        let (x, y, z) = (x?, y?, z?);
        let both = least([x.as_ref(), y.as_ref()]).filter(|_| x.is_some() && y.is_some());
        facts.extend(both.map(|a| Fact::number("limits.acceleration_mm_per_s2", &a, "the slower of X and Y")));
        facts.extend(z.map(|z| Fact::number("limits.z_acceleration_mm_per_s2", &z, "")));
        Ok(most)
    }

    /// Where the axes of a tilting table lie, and which way they turn.
    fn table(
        &self,
        hal: &Hal,
        beside: usize,
        facts: &mut Vec<Fact>,
        notes: &mut Vec<String>,
    ) -> Result<(), ImportError> {
        let pin = |name: &str| hal.pin(&format!("{}.{name}", self.name));
        let (across, up) = (pin(if beside == 0 { "x-offset" } else { "y-offset" })?, pin("z-offset")?);
        if let Some(tool) = pin("tool-offset")?.filter(|tool| tool.value != 0.0) {
            let why =
                format!("{}.tool-offset is {}, and a profile has no such offset; set it to 0", self.name, tool.value);
            return Err(ImportError::At { place: tool.place(), why });
        }
        let conventional = pin("conventional-directions")?;
        let direction = if conventional.as_ref().is_some_and(|pin| pin.value != 0.0) { -1_i64 } else { 1 };
        let how = match direction {
            1 => format!("{} turns the table right-handed, unless conventional-directions is set", self.name),
            _ => "conventional-directions is set, so words turn the table left-handed".to_owned(),
        };
        let from = conventional.map_or_else(|| vec![self.kinematics.place.clone()], |pin| pin.from);
        for key in ["kinematics.tilt.direction", "kinematics.rotation.direction"] {
            facts.push(Fact::new(key, direction, from.clone(), &how));
        }
        let (Some(across), Some(up)) = (across, up) else {
            notes.push(format!(
                "{}: {}.{}-offset and z-offset are not both set, so the position of the tilt axis is unknown",
                self.kinematics.place,
                self.name,
                ["x", "y"][beside]
            ));
            return Ok(());
        };
        let mut d = [0.0, 0.0, scaled(up.value, self.length)];
        d[beside] = scaled(across.value, self.length);
        let mut pivot = d;
        let mut from: Vec<StatedAt> = [across.from, up.from].concat();
        let offset = Fact::new(
            "kinematics.offset_mm",
            list(d.map(|v| 0.0 - v)),
            from.clone(),
            "from the tilt axis back to the table's middle",
        );
        for (i, name) in ["x-rot-point", "y-rot-point", "z-rot-point"].into_iter().enumerate() {
            if let Some(point) = pin(name)? {
                pivot[i] = scaled(pivot[i] + scaled(point.value, self.length), 1.0);
                from.extend(point.from);
            }
        }
        let how = "the point of rotation and the offsets from it; unset ones are 0";
        facts.extend([Fact::new("kinematics.pivot_mm", list(pivot), from, how), offset]);
        Ok(())
    }
}

fn list(values: [f64; 3]) -> toml::Value {
    toml::Value::Array(values.map(|v| toml::Value::Float(v + 0.0)).to_vec())
}

fn unit(entry: &Entry, known: &[(&str, f64)]) -> Result<f64, ImportError> {
    let word = entry.bare().to_ascii_lowercase();
    known.iter().find(|(name, _)| *name == word).map(|(_, factor)| *factor).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        let why = format!("{} = {} is not a unit; use {}", entry.key, shown(&entry.value), names.join(", "));
        ImportError::At { place: entry.place.clone(), why }
    })
}

/// The file that a line of a file names, and what helps where it is not there.
type Named<'a> = &'a dyn Fn(&File, &str) -> Option<(std::path::PathBuf, String)>;

/// Reads a whole tree of files: each line of each file, where it stands.
fn lines_of(
    file: &File,
    open: &mut Open<'_>,
    named: Named<'_>,
    line: &mut dyn FnMut(StatedAt, &str) -> Result<(), ImportError>,
) -> Result<(), ImportError> {
    let mut joined: Option<(StatedAt, String)> = None;
    for (place, text) in file.lines() {
        let (place, text) = match joined.take() {
            Some((place, before)) => (place, before + text.trim_start()),
            None => (place, text.to_owned()),
        };
        if let Some(begun) = text.strip_suffix('\\') {
            joined = Some((place, begun.to_owned()));
            continue;
        }
        match named(file, text.trim()) {
            Some((path, missing)) => {
                let inner = open.named(path, &place, &missing)?;
                lines_of(&inner, open, named, line)?;
                open.leave();
            }
            None => line(place, text.trim())?,
        }
    }
    joined.map_or(Ok(()), |(place, text)| line(place, text.trim()))
}
