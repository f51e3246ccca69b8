//! Objectives by name.

use super::{
    Alexander, ContactArea, Cost, Height, NormalZ, Objective, OverhangAngle, PRINTABLE, Printable, Process, Smoothing,
    Staircase, SupportArea, SupportVolumeColumn, SupportVolumeConvex, Supported, TanhOverhang, WeightedNormalZ,
    WeightedSum,
};
use crate::geom::Angle;
use crate::spelling;

/// The names of [`objective`], those of the documents first; beside them there is [`PRINTABLE`], which has no bound as an objective.
pub const OBJECTIVES: [&str; 14] = [
    "staircase",
    "support-area",
    "height",
    "overhang-angle",
    "normal-z",
    "weighted-normal-z",
    "tanh-overhang",
    "support-volume-convex",
    "support-volume-convex-smooth",
    "support-volume",
    "support-volume-column",
    "interface-area",
    "alexander",
    "contact-area",
];

/// What the named objectives are set to.
#[derive(Clone, Copy, Debug)]
pub struct ObjectiveSettings {
    /// Layer height of `staircase`, mm.
    pub layer_mm: f64,
    /// Overhangs up to this angle from the vertical cost nothing in `overhang-angle` and `support-volume-convex`.
    pub overhang: Angle,
    /// Units of `tanh-overhang` in one mm.
    pub tanh_scale: f64,
    /// Width of the columns of `support-volume-column`, mm.
    pub resolution_mm: f64,
    /// Steepness of the steps of the smoothed objectives.
    pub k: f64,
    /// Weight of the lowest points in the smoothed objectives, 1/mm.
    pub w: f64,
    /// From this angle from the vertical on, surfaces that face up carry support in the smoothed objectives.
    pub carrying: Angle,
    /// Sides of a support's contact in `alexander`, mm.
    pub sides_mm: [f64; 2],
    /// Penalty of supported and touched surfaces in `alexander`, mm.
    pub penalty_mm: f64,
}

impl Default for ObjectiveSettings {
    fn default() -> Self {
        Self {
            layer_mm: 0.2,
            overhang: Angle::from_deg(45.0),
            tanh_scale: 1.0,
            resolution_mm: 0.5,
            k: 20.0,
            w: 40.0,
            carrying: Angle::from_deg(0.0),
            sides_mm: [1.0, 1.0],
            penalty_mm: 10.0,
        }
    }
}

/// An objective that cannot be made from its text.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "objective/")]
pub enum BadObjective {
    /// No objective has this name.
    #[error("unknown objective `{name}`; the nearest is {nearest} (all: {})", [&[PRINTABLE], &OBJECTIVES[..]].concat().join(", "))]
    Unknown {
        /// As given.
        name: String,
        /// The known name nearest to it by edits.
        nearest: &'static str,
    },
    /// A weight that is not a finite number.
    #[error("weight `{weight}` of `{name}` is not a finite number; write sums as 0.7*staircase+0.3*height")]
    Weight {
        /// As given.
        weight: String,
        /// What it weighs.
        name: String,
    },
    /// Weights that say nothing.
    #[error("the weights of `{text}` must not sum to 0; change one of them")]
    NoWeight {
        /// As given.
        text: String,
    },
}

/// The objective of `text`: a name, or a weighted sum `w1*name1+w2*name2` of raw values (nothing is normalised).
///
/// # Errors
///
/// [`BadObjective`] for an unknown name (with the nearest), a weight that is not a finite number, and weights that sum
/// to 0.
pub fn objective(text: &str, settings: &ObjectiveSettings) -> Result<Box<dyn Objective>, BadObjective> {
    let words: Vec<&str> = text.split('+').map(str::trim).collect();
    if let [word] = words[..]
        && !word.contains('*')
    {
        return plain(word, settings);
    }
    let mut terms = Vec::new();
    for word in words {
        let (weight, name) = word.split_once('*').unwrap_or(("1", word));
        let (weight, name) = (weight.trim(), name.trim());
        let bad = || BadObjective::Weight { weight: weight.to_owned(), name: name.to_owned() };
        let number = weight.parse::<f64>().ok().filter(|w| w.is_finite()).ok_or_else(bad)?;
        terms.push((number, plain(name, settings)?));
    }
    if terms.iter().map(|(weight, _)| weight).sum::<f64>() == 0.0 {
        return Err(BadObjective::NoWeight { text: text.to_owned() });
    }
    Ok(Box::new(WeightedSum { text: text.to_owned(), terms }))
}

fn plain(name: &str, settings: &ObjectiveSettings) -> Result<Box<dyn Objective>, BadObjective> {
    let smoothing =
        Smoothing { overhang: settings.overhang, carrying: settings.carrying, k: settings.k, w: settings.w };
    let supported = |cost| Box::new(Supported { cost, smoothing, resolution_mm: settings.resolution_mm });
    Ok(match name {
        "staircase" => Box::new(Staircase { layer_mm: settings.layer_mm }),
        "support-area" => Box::new(SupportArea),
        "height" => Box::new(Height),
        "overhang-angle" => Box::new(OverhangAngle { theta: settings.overhang }),
        "normal-z" => Box::new(NormalZ),
        "weighted-normal-z" => Box::new(WeightedNormalZ),
        "tanh-overhang" => Box::new(TanhOverhang { scale: settings.tanh_scale }),
        "support-volume-convex" => Box::new(SupportVolumeConvex { overhang: settings.overhang }),
        "support-volume-column" => {
            Box::new(SupportVolumeColumn { overhang: settings.overhang, resolution_mm: settings.resolution_mm })
        }
        "support-volume-convex-smooth" => supported(Cost::Convex),
        "support-volume" => supported(Cost::Volume),
        "interface-area" => supported(Cost::Interface),
        "alexander" => Box::new(Alexander {
            layer_mm: settings.layer_mm,
            sides_mm: settings.sides_mm,
            penalty_mm: settings.penalty_mm,
            overhang: settings.overhang,
        }),
        "contact-area" => Box::new(ContactArea),
        PRINTABLE => {
            let process = Process { layer_mm: settings.layer_mm, overhang: settings.overhang, ..Process::default() };
            Box::new(Printable { process })
        }
        _ => {
            return Err(BadObjective::Unknown {
                name: name.to_owned(),
                nearest: nearest(name, &[&[PRINTABLE], &OBJECTIVES[..]].concat()),
            });
        }
    })
}

/// The objective called `name`, overhangs at 45 degrees; `None` for a name that this version does not know.
pub fn named(name: &str, layer_mm: f64) -> Option<Box<dyn Objective>> {
    plain(name, &ObjectiveSettings { layer_mm, ..ObjectiveSettings::default() }).ok()
}

/// The one of `known` nearest to `wanted` by edits (Levenshtein), the earlier of two as near; empty for none.
pub fn nearest(wanted: &str, known: &[&'static str]) -> &'static str {
    spelling::nearest(wanted, known.iter().copied()).map_or("", |(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_makes_its_objective() {
        for name in OBJECTIVES {
            assert_eq!(objective(name, &ObjectiveSettings::default()).unwrap().name(), name);
        }
    }

    #[test]
    fn bad_words_are_named_with_a_remedy() {
        let error = |word: &str| objective(word, &ObjectiveSettings::default()).err().unwrap();
        let unknown = |name: &str, nearest| BadObjective::Unknown { name: name.to_owned(), nearest };
        assert_eq!(error("staircas"), unknown("staircas", "staircase"));
        assert!(error("staircas").to_string().contains(&OBJECTIVES.join(", ")));
        assert_eq!(error("weighted-normal"), unknown("weighted-normal", "weighted-normal-z"));
        let weight = |weight: &str| BadObjective::Weight { weight: weight.to_owned(), name: "height".to_owned() };
        assert_eq!([error("x*height+height"), error("inf*height")], [weight("x"), weight("inf")]);
        let text = "1*height+-1*staircase".to_owned();
        assert_eq!(error(&text), BadObjective::NoWeight { text });
    }
}
