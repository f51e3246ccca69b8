//! Touches as a person writes them down: a TOML file, held to its ranges.
//!
//! ```toml
//! [tip]
//! shape = "flat"              # "flat": a nozzle's end, a disc; "ball": a probe's ball, its lowest point is the tip
//! radius_mm = 0.5
//! paper_mm = 0.1              # what was left between tip and table
//! repeats_to_mm = 0.02        # how well one touch repeats
//! # by_eye_mm = 0.15          # the same of X and Y over a mark, where it is more
//! offset_mm = [0.0, 0.0, 0.0] # from the nozzle's tip to this one, where it is another
//!
//! [[mark]]                    # a place on the table over which the tip was put, then lowered
//! name = "cross"
//! height_mm = 0.0             # over the table's surface
//! # table_mm = [30.0, 0.0]    # where it is known: tells the zero of the rotation
//!
//! [[ball]]
//! name = "steel"
//! diameter_mm = 10.0
//!
//! [[touch]]
//! of = "table"                # or a mark's, or a ball's name
//! tilt_deg = 30.0             # the words that the machine shows
//! rotation_deg = 90.0
//! at_mm = [12.0, -3.5, 4.51]  # X, Y, Z that the machine shows; [] = not yet
//! ```

use serde::Deserialize;
use toml::Spanned;

use crate::geom::Vec3;
use crate::location::Location;
use crate::spelling::nearest;

/// A tip's form at its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TipShape {
    /// A disc, square to Z.
    Flat,
    /// A ball whose lowest point is the tip.
    Ball,
}

/// What touched.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tip {
    /// Its form.
    #[serde(default = "flat")]
    pub shape: TipShape,
    /// Of the disc or the ball, mm.
    #[serde(default = "nozzle")]
    pub radius_mm: f64,
    /// What was left between tip and what it touched, mm.
    #[serde(default)]
    pub paper_mm: f64,
    /// Standard deviation of one touch, mm.
    #[serde(default = "repeats")]
    pub repeats_to_mm: f64,
    /// The same of X and Y over a mark, to which the tip is set by eye, mm; `None` for no more than that.
    #[serde(default)]
    pub by_eye_mm: Option<f64>,
    /// From the nozzle's tip to this one, mm.
    #[serde(default)]
    pub offset_mm: [f64; 3],
}

fn flat() -> TipShape {
    TipShape::Flat
}

fn nozzle() -> f64 {
    0.5
}

fn repeats() -> f64 {
    0.05
}

impl Default for Tip {
    fn default() -> Self {
        let repeats_to_mm = repeats();
        Self { shape: flat(), radius_mm: nozzle(), paper_mm: 0.0, repeats_to_mm, by_eye_mm: None, offset_mm: [0.0; 3] }
    }
}

impl Tip {
    /// Standard deviation of X and Y over a mark, mm.
    pub fn across_mm(&self) -> f64 {
        self.by_eye_mm.unwrap_or(self.repeats_to_mm).max(self.repeats_to_mm)
    }
}

/// What a feature is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TouchShape {
    /// A place on a surface parallel to the table's.
    Mark {
        /// Over the table's surface, mm.
        height: f64,
        /// Where in the table's frame, if that is known, mm.
        known: Option<[f64; 2]>,
    },
    /// A ball that is fixed to the table.
    Ball {
        /// Its radius, mm.
        radius: f64,
    },
}

/// Something on the table besides its surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Its name.
    pub name: String,
    /// What it is.
    pub shape: TouchShape,
}

/// What was touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// The surface.
    Table,
    /// A feature, by its place in [`Touches::features`].
    Feature(usize),
}

/// One touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Touch {
    /// Its place in the file, from 1.
    pub number: usize,
    /// Its line there.
    pub line: usize,
    /// What was touched.
    pub of: Of,
    /// The words of tilt and rotation, degrees.
    pub words_deg: [f64; 2],
    /// The tip that touched, machine coordinates: what the machine showed, and [`Tip::offset_mm`].
    pub at: Vec3,
}

/// A touch that could be made.
#[derive(Clone, Debug, PartialEq)]
pub struct ChainCandidate {
    /// Of what.
    pub of: Of,
    /// The words of tilt and rotation, degrees.
    pub words_deg: [f64; 2],
    /// Where the tip would touch, if the machine were as its profile says.
    pub tip: Vec3,
}

/// All touches of one machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Touches {
    /// What touched.
    pub tip: Tip,
    /// What is on the table.
    pub features: Vec<Feature>,
    /// What was measured.
    pub touches: Vec<Touch>,
    /// Touches that have no `at_mm` yet, by their numbers.
    pub empty: Vec<usize>,
}

/// Why touches cannot be used.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "touches/")]
pub enum TouchError {
    /// Not TOML, or an unknown key or type.
    #[error("{file}{}: {message}", line.map_or_else(String::new, |line| format!(":{line}")))]
    Syntax {
        /// The file.
        file: String,
        /// Its line, where that is known.
        line: Option<usize>,
        /// The parser's words.
        message: String,
    },
    /// A value that cannot be.
    #[error("{file}:{line}: {why}")]
    Value {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// Value, unit, range and remedy.
        why: String,
    },
}

impl TouchError {
    /// Where in what the user gave it is.
    pub fn location(&self) -> Location {
        match self {
            Self::Syntax { file, line: None, .. } => Location::file(file),
            Self::Syntax { file, line: Some(line), .. } | Self::Value { file, line, .. } => {
                Location::file(file).line(*line as u64)
            }
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileSpec {
    #[serde(default)]
    tip: Option<Spanned<Tip>>,
    #[serde(default)]
    mark: Vec<Spanned<MarkSpec>>,
    #[serde(default)]
    ball: Vec<Spanned<BallSpec>>,
    #[serde(default)]
    touch: Vec<Spanned<TouchSpec>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MarkSpec {
    name: String,
    #[serde(default)]
    height_mm: f64,
    #[serde(default)]
    table_mm: Option<[f64; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BallSpec {
    name: String,
    diameter_mm: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TouchSpec {
    of: String,
    tilt_deg: f64,
    rotation_deg: f64,
    at_mm: Vec<f64>,
}

/// Most touches in a file: each takes part in every step of the fit.
const MOST_TOUCHES: usize = 2000;
/// Most marks and balls: each has unknowns of its own.
const MOST_FEATURES: usize = 32;

impl Touches {
    /// Reads what `file` says.
    ///
    /// # Errors
    ///
    /// [`TouchError`] with the line.
    pub fn parse(file: &str, text: &str) -> Result<Self, TouchError> {
        let line_at = |byte: usize| 1 + text.as_bytes()[..byte.min(text.len())].iter().filter(|&&b| b == b'\n').count();
        let spec: FileSpec = toml::from_str(text).map_err(|error| TouchError::Syntax {
            file: file.to_owned(),
            line: error.span().map(|span| line_at(span.start)),
            message: error.message().trim().replace('\n', " "),
        })?;
        let reader = Reader { file, line_at: &line_at };
        let tip = spec.tip.map(|tip| reader.tip(&tip)).transpose()?.unwrap_or_default();
        let features = reader.features(&spec.mark, &spec.ball)?;
        let (mut touches, mut empty) = (Vec::new(), Vec::new());
        for (index, spec) in spec.touch.iter().enumerate() {
            match reader.touch(index + 1, spec, &features, &tip)? {
                Some(touch) => touches.push(touch),
                None => empty.push(index + 1),
            }
        }
        if touches.len() + empty.len() > MOST_TOUCHES {
            let count = touches.len() + empty.len();
            let message = format!("{count} touches; at most {MOST_TOUCHES} are supported");
            return Err(TouchError::Syntax { file: file.to_owned(), line: None, message });
        }
        Ok(Self { tip, features, touches, empty })
    }

    /// What messages call what was touched.
    pub fn name(&self, of: Of) -> &str {
        match of {
            Of::Table => "table",
            Of::Feature(index) => &self.features[index].name,
        }
    }
}

struct Reader<'a> {
    file: &'a str,
    line_at: &'a dyn Fn(usize) -> usize,
}

impl Reader<'_> {
    fn wrong<T>(&self, at: &Spanned<T>, why: String) -> TouchError {
        TouchError::Value { file: self.file.to_owned(), line: (self.line_at)(at.span().start), why }
    }

    fn range<T>(
        &self,
        at: &Spanned<T>,
        name: &str,
        value: f64,
        [low, high]: [f64; 2],
        unit: &str,
    ) -> Result<(), TouchError> {
        // Not a number is in no range.
        if (low..=high).contains(&value) {
            return Ok(());
        }
        Err(self.wrong(at, format!("{name} = {value}: must be {low}..{high} {unit}")))
    }

    fn tip(&self, spec: &Spanned<Tip>) -> Result<Tip, TouchError> {
        let tip = spec.get_ref();
        self.range(spec, "radius_mm", tip.radius_mm, [0.0, 20.0], "mm")?;
        self.range(spec, "paper_mm", tip.paper_mm, [0.0, 5.0], "mm")?;
        self.range(spec, "repeats_to_mm", tip.repeats_to_mm, [0.0005, 1.0], "mm")?;
        self.range(spec, "by_eye_mm", tip.across_mm(), [0.0005, 2.0], "mm")?;
        for value in tip.offset_mm {
            self.range(spec, "offset_mm", value, [-500.0, 500.0], "mm")?;
        }
        Ok(tip.clone())
    }

    fn features(&self, marks: &[Spanned<MarkSpec>], balls: &[Spanned<BallSpec>]) -> Result<Vec<Feature>, TouchError> {
        let mut all: Vec<Feature> = Vec::new();
        let mut named = |feature: Feature, wrong: &dyn Fn(String) -> TouchError| {
            if feature.name == "table" || feature.name.trim().is_empty() || feature.name.contains(char::is_control) {
                return Err(wrong(format!(
                    "name = {:?} is not valid; use at least one visible character, no control characters, and not \"table\"",
                    feature.name
                )));
            }
            if all.iter().any(|other| other.name == feature.name) {
                return Err(wrong(format!(
                    "name = {:?} is used twice; give each mark and ball its own name",
                    feature.name
                )));
            }
            if all.len() == MOST_FEATURES {
                return Err(wrong(format!("more than {MOST_FEATURES} marks and balls; remove some")));
            }
            all.push(feature);
            Ok(())
        };
        for spec in marks {
            let mark = spec.get_ref();
            self.range(spec, "height_mm", mark.height_mm, [-100.0, 500.0], "mm")?;
            for value in mark.table_mm.into_iter().flatten() {
                self.range(spec, "table_mm", value, [-1e4, 1e4], "mm")?;
            }
            let shape = TouchShape::Mark { height: mark.height_mm, known: mark.table_mm };
            named(Feature { name: mark.name.clone(), shape }, &|why| self.wrong(spec, why))?;
        }
        for spec in balls {
            let ball = spec.get_ref();
            self.range(spec, "diameter_mm", ball.diameter_mm, [0.5, 200.0], "mm")?;
            let shape = TouchShape::Ball { radius: ball.diameter_mm / 2.0 };
            named(Feature { name: ball.name.clone(), shape }, &|why| self.wrong(spec, why))?;
        }
        Ok(all)
    }

    /// `None` for one that is still to be measured.
    fn touch(
        &self,
        number: usize,
        spec: &Spanned<TouchSpec>,
        features: &[Feature],
        tip: &Tip,
    ) -> Result<Option<Touch>, TouchError> {
        let touch = spec.get_ref();
        let names = || features.iter().map(|f| f.name.as_str()).chain(["table"]);
        let of = match features.iter().position(|f| f.name == touch.of) {
            Some(index) => Of::Feature(index),
            None if touch.of == "table" => Of::Table,
            None => {
                let near = nearest(&touch.of, names()).map_or("table", |(_, name)| name);
                let known: Vec<&str> = names().collect();
                let why = format!("of = {:?} is not one of {}; the nearest is {near:?}", touch.of, known.join(", "));
                return Err(self.wrong(spec, why));
            }
        };
        self.range(spec, "tilt_deg", touch.tilt_deg, [-360.0, 360.0], "deg")?;
        self.range(spec, "rotation_deg", touch.rotation_deg, [-36e3, 36e3], "deg")?;
        let at = match touch.at_mm[..] {
            [] => return Ok(None),
            [x, y, z] => [x, y, z],
            _ => {
                let why =
                    format!("at_mm has {} numbers; write X, Y and Z, or leave the brackets empty", touch.at_mm.len());
                return Err(self.wrong(spec, why));
            }
        };
        for value in at {
            self.range(spec, "at_mm", value, [-1e4, 1e4], "mm")?;
        }
        let at = Vec3::from(at) + Vec3::from(tip.offset_mm);
        let (line, words_deg) = ((self.line_at)(spec.span().start), [touch.tilt_deg, touch.rotation_deg]);
        Ok(Some(Touch { number, line, of, words_deg, at }))
    }
}
