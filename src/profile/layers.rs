//! Layers of TOML to one profile: merging, origins, unknown keys, ranges.

use std::collections::BTreeMap;

use toml::{Table, Value};

use super::ranges::{self, OutOfRange};
use super::schema::Profile;
use crate::location::Location;
use crate::spelling;

/// The reference of every key.
pub(super) const DEFAULTS: (&str, &str) =
    ("firmware-profiles/defaults.toml", include_str!("../../firmware-profiles/defaults.toml"));

/// A profile that is shipped: name, where it is kept, text.
macro_rules! shipped {
    ($name:literal) => {
        (
            $name,
            concat!("firmware-profiles/", $name, ".toml"),
            include_str!(concat!("../../firmware-profiles/", $name, ".toml")),
        )
    };
}

/// The shipped profiles: name, where it is kept, text.
pub const SHIPPED: [(&str, &str, &str); 16] = [
    shipped!("fibr3d"),
    shipped!("fractal-5-pro"),
    shipped!("generic-ac"),
    shipped!("generic-bc"),
    shipped!("generic-hh"),
    shipped!("generic-ht"),
    shipped!("grblhal-ac"),
    shipped!("hendrikjan-5d"),
    shipped!("linuxcnc-xyzac-trt"),
    shipped!("linuxcnc-xyzbc-trt"),
    shipped!("open5x-prusa"),
    shipped!("open5x-voron0"),
    shipped!("penta-trt-bc"),
    shipped!("pentos"),
    shipped!("rep5x-ender-3-v3-se"),
    shipped!("trident-5-axis"),
];

/// Keys that may be absent, and so are not in the defaults.
const OPTIONAL: [&str; 19] = [
    "machine.jogged",
    "machine.jogged_as",
    "kinematics.tilt.turns",
    "kinematics.rotation.turns",
    "kinematics.tilt.from_tip_mm",
    "kinematics.rotation.from_tip_mm",
    "kinematics.tilt.along",
    "kinematics.rotation.along",
    "kinematics.tilt.stepper",
    "kinematics.rotation.stepper",
    "kinematics.rotation.min_deg",
    "kinematics.rotation.max_deg",
    "kinematics.rotation.max_turns",
    "kinematics.tilt.holding_nm",
    "table.size_mm",
    "transition.park_mm",
    "joint.mm_per_s",
    "joint.fan",
    "joint.nozzle_c",
];

/// Texts that are lines of G-code.
const MANY_LINES: [&str; 5] =
    ["dialect.start", "dialect.end", "link.rehome", "transition.before_turn", "transition.after_turn"];

/// The largest profile: some hundred times the longest that is shipped. What is parsed takes forty times as much.
const MOST_BYTES: usize = 1 << 20;

/// A beginning of fewer letters could be that of any name.
const LEAST_BEGINNING: usize = 3;

/// Keys of a `[[head.body]]` or `[[fixed.body]]`.
const BODY_KEYS: [&str; 9] = ["name", "turns", "moves", "kind", "z_mm", "r_mm", "min_mm", "max_mm", "points_mm"];

/// Where each value came from: key path to `file:line`.
pub type Origin = BTreeMap<String, String>;

/// Why a profile cannot be used.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "profile/")]
pub enum ProfileError {
    /// No shipped profile of that name.
    #[error("{name:?} is not a shipped profile or a TOML file; {}shipped profiles: {}{}", nearest.as_ref().map(|n| format!("nearest: {n:?}; ")).unwrap_or_default(), SHIPPED.map(|s| s.0).join(", "), if own.is_empty() { String::new() } else { format!("; your profiles: {}", own.join(", ")) })]
    NoSuchProfile {
        /// The user's own.
        own: Vec<String>,
        /// As asked for.
        name: String,
        /// The nearest name.
        nearest: Option<String>,
    },
    /// Not TOML.
    #[error("{file}: {message}")]
    Syntax {
        /// The file.
        file: String,
        /// The parser's words.
        message: String,
    },
    /// A key that no version knows.
    #[error("{place}: unknown key {key:?}{}", nearest.as_ref().map_or("; trunnion profile show generic-ac lists the keys in use".to_owned(), |n| format!("; the nearest is {n:?}")))]
    UnknownKey {
        /// `file:line`.
        place: String,
        /// The key's whole path.
        key: String,
        /// The nearest known key.
        nearest: Option<String>,
    },
    /// A value of the wrong type.
    #[error("{place}: {message}")]
    Type {
        /// `file`, or `file:line` where the line is known.
        place: String,
        /// The deserialiser's words.
        message: String,
    },
    /// A line of the machine's own code that cannot be executed.
    #[error("{place}: {key}{}: {why}", if line.is_empty() { String::new() } else { format!(": {line:?}") })]
    Code {
        /// `file:line`.
        place: String,
        /// The key.
        key: String,
        /// The line; empty where it is about all of them.
        line: String,
        /// What is wrong.
        why: String,
    },
    /// A value that no machine can have.
    #[error("{place}: {key} = {value}: must be {allowed}")]
    Range {
        /// `file:line`.
        place: String,
        /// The key.
        key: String,
        /// As given.
        value: String,
        /// What is allowed.
        allowed: String,
    },
}

/// The text and place of the shipped profile `name`.
///
/// # Errors
///
/// [`ProfileError::NoSuchProfile`] with the nearest name.
pub fn shipped(name: &str) -> Result<(&'static str, &'static str), ProfileError> {
    SHIPPED.iter().find(|s| s.0 == name).map(|s| (s.1, s.2)).ok_or_else(|| ProfileError::NoSuchProfile {
        own: Vec::new(),
        name: name.to_owned(),
        nearest: nearest(name, SHIPPED.iter().map(|s| s.0)),
    })
}

/// The key by itself, without the tables that it stands in.
fn last(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

impl ProfileError {
    /// For a `name` that is not there, with the user's `own` beside the shipped ones; any other as it is.
    #[must_use]
    pub fn with_own(self, name: &str, own: Vec<String>) -> Self {
        if !matches!(self, Self::NoSuchProfile { .. }) {
            return self;
        }
        let names = SHIPPED.iter().map(|s| s.0).chain(own.iter().map(String::as_str));
        Self::NoSuchProfile { name: name.to_owned(), nearest: nearest(name, names), own }
    }

    /// Where in what the user gave it is.
    pub fn location(&self) -> Option<Location> {
        let location = match self {
            Self::NoSuchProfile { .. } => return None,
            Self::Syntax { file, .. } => Location::parse(file),
            Self::UnknownKey { place, key, .. } => Location::parse(place).word(last(key)),
            Self::Type { place, message } => {
                match message.rsplit("in `").next().and_then(|rest| rest.strip_suffix('`')) {
                    Some(key) => Location::parse(place).word(last(key)),
                    None => Location::parse(place),
                }
            }
            Self::Code { place, line, .. } => Location::parse(place).word(line),
            Self::Range { place, value, .. } => Location::parse(place).word(value),
        };
        Some(location)
    }
}

/// What a profile's `extends` names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Base {
    /// Nothing: the defaults.
    Defaults,
    /// A shipped profile.
    Shipped(String),
    /// A file, as written: from the folder of the one that names it.
    File(String),
}

impl Base {
    /// What `file`'s `text` extends: a file where the word looks like a path or ends with `.toml`, else a shipped name.
    ///
    /// # Errors
    ///
    /// [`ProfileError::Syntax`], and [`ProfileError::Type`] for what is no name.
    pub fn of(file: &str, text: &str) -> Result<Self, ProfileError> {
        match parse(file, text)?.get("extends") {
            None => Ok(Self::Defaults),
            Some(Value::String(name)) if name.ends_with(".toml") || name.contains(['/', '\\']) => {
                Ok(Self::File(name.clone()))
            }
            Some(Value::String(name)) => Ok(Self::Shipped(name.clone())),
            Some(base) => {
                let place = key_lines(text).get("extends").map_or(file.to_owned(), |line| format!("{file}:{line}"));
                let message = format!(
                    "extends = {base} is not a profile name; use a shipped profile, for example \"generic-ac\", or a file, \"base.toml\""
                );
                Err(ProfileError::Type { place, message })
            }
        }
    }
}

/// The profile of `file`'s `text` over its `extends` (a shipped name) over the defaults, checked.
///
/// # Errors
///
/// [`ProfileError`] for bad TOML, unknown keys (with the nearest name), wrong types and values out of range.
pub fn resolve(file: &str, text: &str) -> Result<(Profile, Origin), ProfileError> {
    resolve_over(&[(file.to_owned(), text.to_owned())])
}

/// The profile of `own` files with their texts, each over the one before, over the shipped profile that the first extends, over
/// the defaults, checked.
///
/// # Errors
///
/// As [`resolve`].
pub fn resolve_over(own: &[(String, String)]) -> Result<(Profile, Origin), ProfileError> {
    let mut layers = vec![(DEFAULTS.0, DEFAULTS.1, parse(DEFAULTS.0, DEFAULTS.1)?)];
    if let Some((file, text)) = own.first()
        && let Base::Shipped(name) = Base::of(file, text)?
    {
        let (base_file, base_text) = shipped(&name)?;
        layers.push((base_file, base_text, parse(base_file, base_text)?));
    }
    for (file, text) in own {
        let mut table = parse(file, text)?;
        table.remove("extends");
        layers.push((file, text, table));
    }
    let known = known_keys(&layers[0].2);
    let mut merged = Table::new();
    let mut origin = Origin::new();
    for (file, text, table) in layers {
        let places = key_lines(text);
        let place = |key: &str| places.get(key).map_or(file.to_owned(), |line| format!("{file}:{line}"));
        check_keys(&table, "", &known, &place)?;
        merge(&mut merged, table, "", &mut |key| {
            origin.insert(key.to_owned(), place(key));
        });
    }
    let merged = Value::Table(merged);
    sane("", &merged, &origin)?;
    ranges::check("", &merged).map_err(|out| out_of_range(out, &origin))?;
    let profile: Profile = merged.try_into().map_err(|error: toml::de::Error| {
        let message = error.to_string().trim().replace('\n', " ");
        // The deserialiser ends with the key.
        let key = message.rsplit("in `").next().and_then(|rest| rest.strip_suffix('`'));
        let line_of = |(file, text): &(String, String)| Some(format!("{file}:{}", key_lines(text).get(key?)?));
        let file = own.last().map_or(DEFAULTS.0, |(file, _)| file);
        let place = own.iter().rev().find_map(line_of).unwrap_or_else(|| file.to_owned());
        ProfileError::Type { place, message }
    })?;
    profile.check(&origin)?;
    Ok((profile, origin))
}

impl Profile {
    /// Whether a profile that was made or changed in code is one that a file could hold.
    ///
    /// # Errors
    ///
    /// [`ProfileError::Range`] with key, value and range.
    pub fn validate(&self) -> Result<(), ProfileError> {
        let place = format!("profile {}", self.machine.name);
        let untold = |error: toml::ser::Error| ProfileError::Type { place: place.clone(), message: error.to_string() };
        let values = Table::try_from(self).map_err(untold)?;
        let mut keys = Vec::new();
        collect_keys(&values, "", &mut keys);
        let origin = keys.into_iter().map(|key| (key, place.clone())).collect();
        let values = Value::Table(values);
        sane("", &values, &origin)?;
        ranges::check("", &values).map_err(|out| out_of_range(out, &origin))?;
        self.check(&origin)
    }
}

fn parse(file: &str, text: &str) -> Result<Table, ProfileError> {
    let refused = |file: String, message: String| Err(ProfileError::Syntax { file, message });
    if text.len() > MOST_BYTES {
        return refused(
            file.to_owned(),
            format!("a profile has at most {MOST_BYTES} bytes, this file has {}", text.len()),
        );
    }
    // The line is named and not shown: what a profile extends may be any file.
    text.parse::<Table>().or_else(|error| {
        let line = error.span().map(|span| text[..span.start].matches('\n').count() + 1);
        let place = line.map_or(file.to_owned(), |line| format!("{file}:{line}"));
        refused(place, error.message().trim().replace('\n', " "))
    })
}

/// The number at its place; the keys of a body have the origin of their list.
pub(super) fn out_of_range(out: OutOfRange, origin: &Origin) -> ProfileError {
    let list = out.key.rsplit_once('.').map_or("", |(list, _)| list);
    let place = origin.get(&out.key).or_else(|| origin.get(list)).cloned().unwrap_or_default();
    ProfileError::Range { place, key: out.key, value: out.value, allowed: out.allowed }
}

/// Refuses texts that would become lines of G-code.
fn sane(key: &str, value: &Value, origin: &Origin) -> Result<(), ProfileError> {
    match value {
        Value::String(text) if !MANY_LINES.contains(&key) && text.contains(char::is_control) => {
            let (value, allowed) = (value.to_string(), "text without control characters".to_owned());
            Err(out_of_range(OutOfRange { key: key.to_owned(), value, allowed }, origin))
        }
        Value::Array(all) => all.iter().try_for_each(|one| sane(key, one, origin)),
        Value::Table(table) => table.iter().try_for_each(|(name, one)| sane(&join(key, name), one, origin)),
        _ => Ok(()),
    }
}

fn known_keys(defaults: &Table) -> Vec<String> {
    let mut known: Vec<String> = OPTIONAL.map(str::to_owned).to_vec();
    collect_keys(defaults, "", &mut known);
    known
}

fn collect_keys(table: &Table, prefix: &str, into: &mut Vec<String>) {
    for (key, value) in table {
        let path = join(prefix, key);
        match value {
            Value::Table(inner) => collect_keys(inner, &path, into),
            _ => into.push(path),
        }
    }
}

/// The tables that keys stand in, outer ones too.
fn sections(known: &[String]) -> impl Iterator<Item = &str> {
    known.iter().flat_map(|key| key.match_indices('.').map(|(at, _)| &key[..at]))
}

fn join(prefix: &str, key: &str) -> String {
    if prefix.is_empty() { key.to_owned() } else { format!("{prefix}.{key}") }
}

/// The key of this very name in another section, where just one has it: whoever left the section out meant that one.
fn elsewhere(key: &str, known: &[String]) -> Option<String> {
    let mut same = known.iter().filter(|path| path.rsplit('.').next() == Some(key));
    same.next().filter(|_| same.next().is_none()).cloned()
}

fn check_keys(
    table: &Table,
    prefix: &str,
    known: &[String],
    place: &impl Fn(&str) -> String,
) -> Result<(), ProfileError> {
    for (key, value) in table {
        let path = join(prefix, key);
        let unknown = |nearest| ProfileError::UnknownKey { place: place(&path), key: path.clone(), nearest };
        match value {
            Value::Table(inner) if known.iter().any(|k| k.starts_with(&format!("{path}."))) => {
                check_keys(inner, &path, known, place)?;
            }
            Value::Array(bodies) if path == "head.body" || path == "fixed.body" => {
                for key in bodies.iter().filter_map(Value::as_table).flat_map(Table::keys) {
                    if !BODY_KEYS.contains(&key.as_str()) {
                        let near = nearest(key, BODY_KEYS).map(|n| format!("{path}.{n}"));
                        let path = format!("{path}.{key}");
                        return Err(ProfileError::UnknownKey { place: place(&path), key: path, nearest: near });
                    }
                }
            }
            Value::Table(_) => return Err(unknown(nearest(&path, sections(known)))),
            _ if known.contains(&path) => {}
            _ => {
                return Err(unknown(
                    elsewhere(key, known).or_else(|| nearest(&path, known.iter().map(String::as_str))),
                ));
            }
        }
    }
    Ok(())
}

fn merge(into: &mut Table, from: Table, prefix: &str, took: &mut impl FnMut(&str)) {
    for (key, value) in from {
        let path = join(prefix, &key);
        match (into.get_mut(&key), value) {
            (Some(Value::Table(inner)), Value::Table(from)) => merge(inner, from, &path, took),
            (None, Value::Table(from)) => {
                let mut inner = Table::new();
                merge(&mut inner, from, &path, took);
                into.insert(key, Value::Table(inner));
            }
            (_, value) => {
                took(&path);
                into.insert(key, value);
            }
        }
    }
}

/// The line of each key, as `section.key`; the last one wins within an array of tables.
fn key_lines(text: &str) -> BTreeMap<String, usize> {
    let mut lines = BTreeMap::new();
    let mut section = String::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.starts_with('[') && line.ends_with(']') {
            section = line.trim_matches(['[', ']']).trim().to_owned();
            lines.entry(section.clone()).or_insert(index + 1);
        } else if let Some((key, _)) = line.split_once('=')
            && key.trim().chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '.')
        {
            lines.insert(join(&section, key.trim()), index + 1);
        }
    }
    lines
}

/// The name that begins with `wanted` or has it as one of its words, else the nearest by edits, where it is near at all.
pub(crate) fn nearest<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let names: Vec<&str> = names.into_iter().collect();
    let wanted_low = wanted.to_lowercase();
    let begins = |name: &&&str| name.to_lowercase().starts_with(&wanted_low);
    let has = |name: &&&str| name.to_lowercase().split('-').any(|word| word.starts_with(&wanted_low));
    let long = wanted.len() >= LEAST_BEGINNING;
    if let Some(name) = names.iter().find(begins).or_else(|| names.iter().find(has)).filter(|_| long) {
        return Some((*name).to_owned());
    }
    let (distance, name) = spelling::nearest(wanted, names)?;
    (distance <= wanted.len().max(name.len()) / 2).then(|| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_profile_resolves() {
        for (name, file, text) in SHIPPED {
            let (profile, origin) = resolve(file, text).unwrap();
            assert_eq!(profile.machine.name, name);
            assert!(origin["machine.name"].starts_with(file));
        }
    }

    #[test]
    fn values_know_their_line() {
        let (profile, origin) =
            resolve("mine.toml", "extends = \"fibr3d\"\n[kinematics.tilt]\nmax_deg = 80.0\n").unwrap();
        assert_eq!((profile.kinematics.tilt.max_deg, profile.kinematics.tilt.min_deg), (80.0, -45.0));
        assert_eq!(origin["kinematics.tilt.max_deg"], "mine.toml:3");
        assert!(origin["kinematics.tilt.min_deg"].starts_with("firmware-profiles/fibr3d.toml:"));
    }

    #[test]
    fn an_unknown_key_names_the_nearest() {
        let text = "[kinematics.tilt]\nmax_degs = 80.0\n";
        // The line, the key and the nearest one.
        let unknown = |text: &str| match resolve("mine.toml", text).unwrap_err() {
            ProfileError::UnknownKey { place, key, nearest } => (place, key, nearest.unwrap_or_default()),
            other => panic!("{other}"),
        };
        let of = |place: &str, key: &str, nearest: &str| (place.to_owned(), key.to_owned(), nearest.to_owned());
        let wanted = of("mine.toml:2", "kinematics.tilt.max_degs", "kinematics.tilt.max_deg");
        assert_eq!(unknown(text), wanted);
        for (wrong, right) in [("procss", "process"), ("kinematics.tlt", "kinematics.tilt")] {
            let (_, key, nearest) = unknown(&format!("[{wrong}]\nlayer_height_mm = 0.3\n"));
            assert_eq!((key.as_str(), nearest.as_str()), (wrong, right));
        }
        for (text, right) in [
            ("layer_height_mm = 0.3", "process.layer_height_mm"),
            ("[limits]\nlayer_height_mm = 0.3", "process.layer_height_mm"),
            ("max_deg = 80.0", ""),
            ("colour_of_the_machine = \"red\"", ""),
            ("[[head.body]]\nnam = \"x\"", "head.body.name"),
        ] {
            assert_eq!(unknown(&format!("{text}\n")).2, right, "{text}");
        }
        let error = shipped("generic-a").unwrap_err();
        assert!(
            matches!(&error, ProfileError::NoSuchProfile { nearest: Some(nearest), .. } if nearest == "generic-ac"),
            "{error}"
        );
    }

    #[test]
    fn what_no_machine_can_have_is_refused_at_its_line() {
        let cases = [
            ("[kinematics]\npivot_mm = [nan, 0.0, 0.0]", "profile/range | m.toml:2 | kinematics.pivot_mm"),
            ("[process]\nlayer_height_mm = inf", "profile/range | m.toml:2 | process.layer_height_mm"),
            ("[table]\nthickness_mm = -3.0", "profile/range | m.toml:2 | table.thickness_mm = -3.0 | 0..1000 mm"),
            ("[transition]\nretract_mm = -2.0", "profile/range | m.toml:2 | transition.retract_mm = -2.0 | 0..100 mm"),
            (
                "[transition]\nretract_mm_per_s = 0.0",
                "profile/range | m.toml:2 | transition.retract_mm_per_s = 0.0 | 0.1..2000 mm/s",
            ),
            ("[transition]\nclearance_mm = -1.0", "profile/range | m.toml:2 | transition.clearance_mm"),
            (
                "[transition]\n\npark_mm = [900.0, 0.0]",
                "profile/range | m.toml:3 | transition.park_mm = [900.0, 0.0] | limits",
            ),
            ("[head]\nbody = []", "profile/range | m.toml:2 | head.body = [] | one body"),
            ("[machine]\nname = \"a\\nG28\"", "profile/range | m.toml:2 | machine.name"),
            (
                "[[head.body]]\nname = \"n\"\nkind = \"box\"\nmin_mm = [0, 0, nan]\nmax_mm = [1, 1, 1]",
                "profile/range | m.toml:1 | head.body",
            ),
            ("[process]\nnozzle_mm = -3", "profile/range | m.toml:2 | process.nozzle_mm = -3 | 0.1..2 mm"),
            ("[process]\ninfill = 7", "profile/range | m.toml:2 | process.infill = 7 | 0..1"),
            ("[process]\nwalls = 0", "profile/range | m.toml:2 | process.walls = 0 | 1..100"),
            ("[process]\nwalls = -1", "profile/range | m.toml:2 | process.walls = -1 | 1..100"),
            ("[process]\nfan = nan", "profile/range | m.toml:2 | process.fan = nan | 0..1"),
            (
                "[process]\ntravel_mm_per_s = 0.0",
                "profile/range | m.toml:2 | process.travel_mm_per_s = 0.0 | 0.1..2000 mm/s",
            ),
            ("[process]\nnozzle_c = 2100.0", "profile/range | m.toml:2 | process.nozzle_c = 2100.0 | 0..500 deg C"),
            (
                "[process]\nlayer_height_mm = 0.6",
                "profile/range | m.toml:2 | process.layer_height_mm = 0.6 | 0..0.4 mm",
            ),
            (
                "[process]\nline_width_mm = 0.15",
                "profile/range | m.toml:2 | process.line_width_mm = 0.15 | 0.2..1.6 mm",
            ),
            ("[link]\nbaud = 0", "profile/range | m.toml:2 | link.baud = 0 | 300..12000000"),
            ("[link]\nlift_mm = -20", "profile/range | m.toml:2 | link.lift_mm = -20 | 0..1000 mm"),
            ("[limits]\nx_mm = [0.0, inf]", "profile/range | m.toml:2 | limits.x_mm = inf | -10000..10000 mm"),
            ("[kinematics.tilt]\ndirection = 0", "profile/range | m.toml:2 | kinematics.tilt.direction = 0 | 1 or -1"),
            (
                "[fixed]\nbody = [{ name = \"n\", kind = \"frustum\", z_mm = [0, 1], r_mm = [-1, 1] }]",
                "profile/range | m.toml:2 | fixed.body.r_mm = -1 | 0..10000 mm",
            ),
            ("extends = 5", "m.toml:1 | extends = 5"),
            ("[kinematics.tilt]\nmax_deg = \"ninety\"", "profile/type | m.toml:2 | \"ninety\""),
            ("[[head.body]]\nname = \"n\"\nkind = \"cone\"", "profile/type | m.toml:3 | `cone`"),
        ];
        for (text, wanted) in cases {
            let error = resolve("m.toml", text).unwrap_err();
            let code: &str = (&error).into();
            let said = format!("{code} | {error}");
            assert!(wanted.split(" | ").all(|fact| said.contains(fact)), "{wanted}: {said}");
        }
    }

    /// Every key of a number, with the line of `defaults.toml` it stands on; optional ones and those of bodies without.
    fn numeric_keys() -> Vec<(String, Option<&'static str>)> {
        fn walk(value: &Value, key: &str, into: &mut Vec<String>) {
            match value {
                Value::Table(table) => table.iter().for_each(|(name, one)| walk(one, &join(key, name), into)),
                Value::Array(all) => all.iter().for_each(|one| walk(one, key, into)),
                Value::Integer(_) | Value::Float(_) => into.push(key.to_owned()),
                _ => {}
            }
        }
        let (file, text) = DEFAULTS;
        let mut found = Vec::new();
        walk(&Value::Table(parse(file, text).unwrap()), "", &mut found);
        // Names are no numbers.
        let named = ["stepper", "turns"];
        let number =
            |key: &&str| !key.starts_with("machine.") && !named.iter().any(|name| key.rsplit('.').next() == Some(name));
        let absent = OPTIONAL.into_iter().filter(number).map(str::to_owned);
        let of_bodies = BODY_KEYS.into_iter().filter(|key| key.ends_with("_mm")).map(|key| format!("fixed.body.{key}"));
        found.extend(absent.chain(of_bodies));
        found.dedup();
        let lines = key_lines(text);
        let line = |key: &String| lines.get(key).and_then(|&line| text.lines().nth(line - 1));
        found.into_iter().map(|key| (key.clone(), line(&key).filter(|_| !key.contains("body")))).collect()
    }

    #[test]
    fn every_number_has_a_range_and_the_reference_shows_it() {
        let keys = numeric_keys();
        assert!(keys.len() > 50, "only {} keys were found", keys.len());
        for (key, line) in keys {
            let allowed = ranges::allowed(&key).unwrap_or_else(|| panic!("{key}: no range; give it one in ranges.rs"));
            let shown = line.and_then(|line| line.rsplit_once("# ")).map(|(_, comment)| comment.trim());
            assert!(
                shown.is_none_or(|shown| shown == allowed),
                "{key}: defaults.toml shows {shown:?}, it is {allowed}"
            );
        }
    }

    #[test]
    fn out_of_range_names_place_value_and_range() {
        let text = "[kinematics.tilt]\ndirection = 2\n";
        let error = resolve("mine.toml", text).unwrap_err();
        let ProfileError::Range { place, key, value, allowed } = error else { panic!("{error}") };
        assert_eq!(
            [place.as_str(), &key, &value, &allowed],
            ["mine.toml:2", "kinematics.tilt.direction", "2", "1 or -1"]
        );
    }
}
