//! Settings of requests that cannot be. Every text begins with the setting's name, so that the command can make a flag of it.

use std::path::PathBuf;

use crate::orient::BadObjective;
use crate::profile::OutOfRange;
use crate::spelling::part_named;

/// A setting of a request that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "setting/")]
pub enum BadSetting {
    /// A number out of its range.
    #[error("{name} must be between {} and {}{unit}, got {value}{unit}", allowed[0], allowed[1])]
    OutOfRange {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Its unit, with a space before it; empty for counts.
        unit: &'static str,
        /// The least and the most.
        allowed: [f64; 2],
    },
    /// A number out of the range that profiles have.
    #[error("{name} {}: must be {}", source.value, source.allowed)]
    Number {
        /// The setting.
        name: &'static str,
        /// The number and its range.
        source: OutOfRange,
    },
    /// Words that do not say what they should.
    #[error("{name} {text}: {wanted}")]
    Words {
        /// The setting.
        name: &'static str,
        /// As it was given.
        text: String,
        /// What was expected, with an example.
        wanted: String,
    },
    /// A count of nothing.
    #[error("{name} must be at least 1, got 0")]
    Zero {
        /// The setting.
        name: &'static str,
    },
    /// A count that is too low to say anything.
    #[error("{name} {value} is too few {what}; give at least {least}")]
    TooFew {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: usize,
        /// The least.
        least: usize,
        /// What is counted.
        what: &'static str,
    },
    /// A part that the model does not have.
    #[error("{name} {given}: {model} has no part {given}; its parts are 0..{last}")]
    NoSuchPart {
        /// The setting.
        name: &'static str,
        /// Its number.
        given: usize,
        /// The last part's.
        last: usize,
        /// The model.
        model: String,
    },
    /// Several parts where the result is of one.
    #[error("part: a picture shows one part, but the model has {count}; choose one with --part, or pass --whole")]
    SeveralParts {
        /// How many.
        count: usize,
    },
    /// A direction without a length.
    #[error("{name} {},{},{} has no direction; give three numbers that are not all 0, for example 0,0,1", given[0], given[1], given[2])]
    Direction {
        /// The setting.
        name: &'static str,
        /// As given.
        given: [f64; 3],
    },
    /// A pose to be priced where nothing is.
    #[error("up: needs --objective printable or --compare; add one of them, or remove --up")]
    OwnPose,
    /// No facet as large as asked for.
    #[error("contact-area-min {least} mm2: no orientation has that much bed contact; the largest is {most:.3} mm2")]
    NoContact {
        /// What was asked for, mm².
        least: f64,
        /// What there is, mm².
        most: f64,
    },
    /// A model of several parts that is to stand as `orient` recommends.
    #[error("up auto: {model} has {parts} parts, but auto needs a single part; use --up X,Y,Z, --base PART or --join")]
    SeveralToStand {
        /// The model.
        model: String,
        /// How many.
        parts: usize,
    },
    /// Boxes of the file's frame for a model that is turned.
    #[error("no-cut and cut use the file's coordinates and cannot be combined with --up; rotate the model first")]
    TurnedBoxes,
    /// Cuts of parts of the files where some of those are joined on the way.
    #[error(
        "cut: some parts are joined before they are printed, and have other numbers then; join them in one model as drawn (--join), or cut them \
         first with trunnion split, then prepare the parts"
    )]
    ArrangedCut,
    /// A cut of a model with several parts that does not say of which.
    #[error("cut {cut}: the model has {parts} parts; put the number of the part first, for example 0:{cut}")]
    CutOfWhich {
        /// Its words.
        cut: String,
        /// How many parts there are.
        parts: usize,
    },
    /// Cuts for a model that is not to be cut.
    #[error("cut: contradicts {other}; remove one of them")]
    UnwantedCut {
        /// The setting.
        other: &'static str,
    },
    /// A part that the model cannot stand on.
    #[error(
        "base {part}: {who} has no flat face with everything else above it; use --up X,Y,Z instead",
        who = part_named(*part, name)
    )]
    NoBase {
        /// The part.
        part: usize,
        /// Its name.
        name: String,
    },
    /// A model that is not all in the space for its supports.
    #[error(
        "space: the model reaches from {low:.3} to {high:.3} mm in {axis}, the space from {:.3} to {:.3}; enlarge the space, move the model, or \
         stand it on the ground (without --keep-z)", space[0], space[1]
    )]
    OutsideSpace {
        /// `x`, `y` or `z`.
        axis: &'static str,
        /// Where the model begins, mm.
        low: f64,
        /// Where it ends, mm.
        high: f64,
        /// Where the space begins and ends, mm.
        space: [f64; 2],
    },
    /// A file type that is not supported.
    #[error("{name} {}: unsupported file type; use {allowed}", path.display())]
    Ending {
        /// The setting.
        name: &'static str,
        /// The file.
        path: PathBuf,
        /// Endings that say something.
        allowed: &'static str,
    },
    /// A grid that does not fit in memory.
    #[error(
        "{name} {step} mm makes {cubes:.3e} cubes, and at most {most:.0e} fit in memory; use {}{name} {fits} or more",
        if *.name == "step_mm" { "" } else { "--" }
    )]
    TooFine {
        /// The setting, or `step_mm` of a plan.
        name: &'static str,
        /// The step, mm.
        step: f64,
        /// Cubes that it makes.
        cubes: f64,
        /// Cubes that fit.
        most: f64,
        /// A step that fits, mm.
        fits: f64,
    },
    /// An invalid objective.
    #[error("{name}: {source}")]
    Objective {
        /// The setting.
        name: &'static str,
        /// What is wrong with it.
        source: BadObjective,
    },
    /// An unknown method.
    #[error("{name} {given} is unknown; the nearest is {nearest}")]
    Method {
        /// The setting.
        name: &'static str,
        /// Its value.
        given: String,
        /// The nearest that is known.
        nearest: String,
    },
}

impl BadSetting {
    /// That a direction has a length.
    pub(crate) fn direction(name: &'static str, given: [f64; 3]) -> Result<(), Self> {
        let long = given.iter().map(|v| v * v).sum::<f64>().is_normal();
        if long { Ok(()) } else { Err(Self::Direction { name, given }) }
    }

    /// That `value` lies in `allowed`.
    pub(crate) fn within(name: &'static str, value: f64, unit: &'static str, allowed: [f64; 2]) -> Result<(), Self> {
        let inside = (allowed[0]..=allowed[1]).contains(&value);
        if inside { Ok(()) } else { Err(Self::OutOfRange { name, value, unit, allowed }) }
    }
}
