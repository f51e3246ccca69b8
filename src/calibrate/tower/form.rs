//! The sheet's numbers as a file: written to be filled in, and read back.

use std::fmt::Write as _;

use serde::Deserialize;
use toml::Spanned;

use super::design::{Tower, TowerDesign};
use super::error::TowerError;
use crate::geom::Angle;
use crate::motion::TableKinematics;
use crate::profile::Profile;

/// Standard deviation of one reading of callipers, mm, where nothing else is said.
pub const TOWER_REPEATS_MM: f64 = 0.05;
/// What `repeats_to_mm` may be.
const REPEATS_MM: [f64; 2] = [0.005, 0.5];
/// Readings of one dimension at most.
const MOST_READINGS: usize = 50;
/// Two readings of one dimension are not further apart, in standard deviations of one.
const APART: f64 = 6.4;

/// One reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalliperReading {
    /// The dimension, from 1.
    pub number: usize,
    /// Its line in the file.
    pub line: usize,
    /// As read, mm.
    pub mm: f64,
}

/// What was measured of a tower.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// The tower.
    pub design: TowerDesign,
    /// Pivot, offset and zeros of the profile that it was printed with, mm and degrees.
    pub printed_with: [[f64; 3]; 3],
    /// Standard deviation of one reading, mm.
    pub repeats_mm: f64,
    /// All, in the file's order.
    pub readings: Vec<CalliperReading>,
    /// Dimensions that cannot be measured, by their numbers.
    pub left_out: Vec<usize>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileSpec {
    tower: Spanned<TowerSpec>,
    #[serde(default)]
    measure: Vec<Spanned<MeasureSpec>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TowerSpec {
    repeats_to_mm: f64,
    tilt_deg: f64,
    rotation_deg: [f64; 2],
    half_mm: f64,
    lift_mm: f64,
    layer_mm: f64,
    pivot_mm: [f64; 3],
    offset_mm: [f64; 3],
    zero_deg: [f64; 2],
}

fn no_readings() -> toml::Value {
    toml::Value::Array(Vec::new())
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeasureSpec {
    number: usize,
    #[serde(default = "no_readings")]
    mm: toml::Value,
    #[serde(default)]
    left_out: bool,
}

/// Pivot, offset and zeros, as a form keeps them.
fn numbers_of(profile: &Profile) -> [[f64; 3]; 3] {
    let k = &profile.kinematics;
    [k.pivot_mm, k.offset_mm, [k.tilt.zero_deg, k.rotation.zero_deg, 0.0]]
}

impl Tower {
    /// The file to be filled in, for a tower that was made with `profile`.
    pub fn form(&self, profile: &Profile, repeats_mm: f64) -> String {
        let (d, [pivot, offset, [tilt, rotation, _]]) = (&self.design, numbers_of(profile));
        let mut out = format!(
            "# Fill in what the callipers show, with a decimal point: mm = [24.05, 24.10]. Read each dimension twice, at both ends of the face or\n\
             # edge; one reading is enough, but then no mistake in it is noticed. The sheet shows each number.\n\
             \n[tower]\n# repeats_to_mm: how well one reading repeats (standard deviation). The other keys describe the tower: leave them as they are.\n\
             repeats_to_mm = {repeats_mm:?}\ntilt_deg = {:?}\nrotation_deg = {:?}\nhalf_mm = {:?}\nlift_mm = {:?}\nlayer_mm = {:?}\n\
             pivot_mm = {pivot:?}\noffset_mm = {offset:?}\nzero_deg = [{tilt:?}, {rotation:?}]\n",
            d.tilt_deg, d.rotation_deg, d.half_mm, d.lift_mm, d.layer_mm
        );
        for one in &self.dimensions {
            let _ = write!(
                out,
                "\n# {}: {}, drawn as {:.2} mm\n[[measure]]\nnumber = {}\nmm = []\n",
                one.number, one.name, one.drawn_mm, one.number
            );
        }
        out
    }
}

struct Reader<'a> {
    file: &'a str,
    text: &'a str,
}

impl Reader<'_> {
    fn line_at(&self, byte: usize) -> usize {
        1 + self.text.as_bytes()[..byte.min(self.text.len())].iter().filter(|&&b| b == b'\n').count()
    }

    fn wrong(&self, byte: usize, why: String) -> TowerError {
        TowerError::Value { file: self.file.to_owned(), line: self.line_at(byte), why }
    }

    fn spec(&self) -> Result<FileSpec, TowerError> {
        toml::from_str(self.text).map_err(|error| {
            let line = error.span().map(|span| self.line_at(span.start));
            let typed = line.and_then(|line| self.text.lines().nth(line - 1)).unwrap_or_default();
            match comma_in(typed) {
                Some(number) => self.wrong(error.span().map_or(0, |span| span.start), use_point(&number)),
                None => {
                    let message = error.message().trim().replace('\n', " ");
                    TowerError::Syntax { file: self.file.to_owned(), line, message }
                }
            }
        })
    }

    /// The readings of one dimension.
    fn readings(&self, spec: &Spanned<MeasureSpec>, repeats_mm: f64) -> Result<Vec<CalliperReading>, TowerError> {
        let one = spec.get_ref();
        let line = self.line_of_mm(&spec.span());
        let wrong = |why: String| TowerError::Value { file: self.file.to_owned(), line, why };
        let typed = self.text.lines().nth(line - 1).unwrap_or_default();
        let values = match &one.mm {
            toml::Value::Array(all) => all.clone(),
            single => vec![single.clone()],
        };
        if values.len() > MOST_READINGS {
            return Err(wrong(format!("{} readings; at most {MOST_READINGS} of a dimension are read", values.len())));
        }
        let mut found: Vec<CalliperReading> = Vec::new();
        for value in &values {
            let mm = match value {
                toml::Value::Float(mm) => *mm,
                toml::Value::Integer(mm) => *mm as f64,
                _ => {
                    let comma = comma_in(typed);
                    return Err(wrong(comma.map_or_else(
                        || "mm must be a list of numbers, for example mm = [24.05, 24.10]".to_owned(),
                        |number| use_point(&number),
                    )));
                }
            };
            if !(mm > 0.0 && mm < 1000.0) {
                return Err(wrong(format!("a reading must be between 0 and 1000 mm, got {mm}")));
            }
            found.push(CalliperReading { number: one.number, line, mm });
        }
        let [low, high] = found.iter().fold([f64::MAX, f64::MIN], |[l, h], r| [l.min(r.mm), h.max(r.mm)]);
        let most = APART * repeats_mm;
        if !found.is_empty() && high - low > most {
            // A decimal comma makes two whole numbers of one.
            let whole = values.iter().all(toml::Value::is_integer);
            if let (true, Some(number)) = (whole, comma_in(typed)) {
                return Err(wrong(use_point(&number)));
            }
            let number = one.number;
            return Err(wrong(format!(
                "the readings of dimension {number} are {low:.2} and {high:.2} mm, at most {most:.2} mm apart is likely; measure it again"
            )));
        }
        Ok(found)
    }

    /// The line of `mm` in a `[[measure]]`.
    fn line_of_mm(&self, span: &std::ops::Range<usize>) -> usize {
        let first = self.line_at(span.start);
        let own = self.text.lines().enumerate().skip(first - 1);
        let mm = own.take(20).find(|(_, line)| line.trim_start().starts_with("mm"));
        mm.map_or(first, |(index, _)| index + 1)
    }
}

/// A number with a decimal comma in a line, such as 24,05 in `mm = 24,05` or `mm = "24,05"`.
fn comma_in(line: &str) -> Option<String> {
    let body = line.split('#').next()?;
    let (before, after) = body.split_once(',')?;
    let digits = |text: &str| text.chars().all(|c| c.is_ascii_digit()) && !text.is_empty();
    let whole: String = before.chars().rev().take_while(char::is_ascii_digit).collect();
    let part: String = after.chars().take_while(char::is_ascii_digit).collect();
    let whole: String = whole.chars().rev().collect();
    let own_point = before[..before.len() - whole.len()].ends_with('.');
    (digits(&whole) && digits(&part) && !own_point).then(|| format!("{whole},{part}"))
}

fn use_point(number: &str) -> String {
    format!("{number} has a decimal comma; write {}", number.replacen(',', ".", 1))
}

impl Readings {
    /// Whether a file is one of a tower, and not of touches.
    pub fn is_tower(text: &str) -> bool {
        text.lines().any(|line| line.trim() == "[tower]")
    }

    /// Reads a form that was filled in.
    ///
    /// # Errors
    ///
    /// [`TowerError::Syntax`], [`TowerError::Value`], [`TowerError::Missing`].
    pub fn parse(file: &str, text: &str) -> Result<Self, TowerError> {
        let reader = Reader { file, text };
        let spec = reader.spec()?;
        let (at, t) = (spec.tower.span().start, spec.tower.get_ref());
        let [low, high] = REPEATS_MM;
        let (design, repeats_mm) = (t.design(), t.repeats_to_mm);
        if !(low..=high).contains(&repeats_mm) {
            let why = format!("repeats_to_mm must be between {low} and {high} mm, got {repeats_mm}");
            return Err(reader.wrong(at, why));
        }
        if let Some(why) = t.problem() {
            return Err(reader.wrong(at, why));
        }
        let (mut readings, mut left_out, mut seen) = (Vec::new(), Vec::new(), Vec::new());
        for one in &spec.measure {
            let number = one.get_ref().number;
            if !(1..=Tower::DIMENSIONS).contains(&number) || seen.contains(&number) {
                let why = format!("number must be 1 to {} and each once, got {number}", Tower::DIMENSIONS);
                return Err(reader.wrong(one.span().start, why));
            }
            seen.push(number);
            match one.get_ref().left_out {
                true => left_out.push(number),
                false => readings.extend(reader.readings(one, repeats_mm)?),
            }
        }
        let has = |number: &usize| left_out.contains(number) || readings.iter().any(|r| r.number == *number);
        let numbers: Vec<usize> = (1..=Tower::DIMENSIONS).filter(|number| !has(number)).collect();
        if !numbers.is_empty() {
            return Err(TowerError::Missing { file: file.to_owned(), numbers });
        }
        let printed_with = [t.pivot_mm, t.offset_mm, [t.zero_deg[0], t.zero_deg[1], 0.0]];
        Ok(Self { design, printed_with, repeats_mm, readings, left_out })
    }

    /// The tower that was measured, where it was printed with the values that the profile has.
    ///
    /// # Errors
    ///
    /// [`TowerError::OtherMachine`].
    pub fn tower(&self, file: &str, profile: &Profile, name: &str) -> Result<Tower, TowerError> {
        let table: TableKinematics = profile.kinematics();
        let keys = ["kinematics.pivot_mm", "kinematics.offset_mm", "zeros (tilt, rotation)"];
        for ((key, printed), now) in keys.into_iter().zip(self.printed_with).zip(numbers_of(profile)) {
            if printed != now {
                let [printed, now] = [printed, now].map(|v| format!("{v:?}"));
                let (file, profile) = (file.to_owned(), name.to_owned());
                return Err(TowerError::OtherMachine { file, profile, key: key.to_owned(), printed, now });
            }
        }
        let angle = table.tilt.angle_of(Angle::from_deg(self.design.tilt_deg)).deg().abs();
        if !(5.0..=80.0).contains(&angle) {
            let why =
                format!("tilt_deg {} is no tilt of a tower on {name}; make the tower again", self.design.tilt_deg);
            return Err(TowerError::Value { file: file.to_owned(), line: 1, why });
        }
        Ok(Tower::of(&table, self.design))
    }
}

impl TowerSpec {
    fn design(&self) -> TowerDesign {
        let Self { tilt_deg, rotation_deg, half_mm, lift_mm, layer_mm, .. } = *self;
        TowerDesign { tilt_deg, rotation_deg, half_mm, lift_mm, layer_mm }
    }

    /// What no tower of ours says of itself.
    fn problem(&self) -> Option<String> {
        let lengths = [("half_mm", self.half_mm), ("lift_mm", self.lift_mm)];
        let lengths = lengths.into_iter().map(|(key, mm)| (key, mm, [5.0, 100.0]));
        let angles = [
            ("tilt_deg", self.tilt_deg),
            ("rotation_deg", self.rotation_deg[0]),
            ("rotation_deg", self.rotation_deg[1]),
        ];
        let angles = angles.into_iter().map(|(key, deg)| (key, deg, [-36000.0, 36000.0]));
        let mut all = lengths.chain(angles).chain([("layer_mm", self.layer_mm, [0.02, 1.5])]);
        let wrong = all.find(|(_, value, [low, high])| !(*low..=*high).contains(value));
        let half = ((self.rotation_deg[0] - self.rotation_deg[1]).abs() - 180.0).abs() > 1e-6;
        let wrong =
            wrong.map(|(key, value, [low, high])| format!("{key} must be between {low} and {high}, got {value}"));
        wrong.or_else(|| {
            half.then(|| "rotation_deg must be two rotations half a turn apart; make the tower again".to_owned())
        })
    }
}
