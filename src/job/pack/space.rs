//! The space of a run, and what is looked for in it.

use std::str::FromStr;

use super::error::{BadPacking, PackError};
use super::{Into, PackOptions, named};
use crate::input::BadSetting;
use crate::pack::PackGoal;
use crate::spelling::numbers;

/// Lengths of a space, mm.
const LENGTHS_MM: [f64; 2] = [0.1, 1e5];
/// The limit of the height where none is given, mm.
pub(super) const HIGHEST_MM: f64 = LENGTHS_MM[1];

/// The space of each run, from the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackSpace {
    /// Along x and y, mm.
    pub base_mm: [f64; 2],
    /// Along z, mm; `None` where only the base is given, for the goal `height`.
    pub height_mm: Option<f64>,
}

impl PackSpace {
    /// Its lengths, mm, with `stacked` as height where it has no limit; that is all pieces on each other, and too much to be of use above 100 m.
    pub(super) fn up_to(&self, stacked: f64) -> [f64; 3] {
        let [wide, deep] = self.base_mm;
        [wide, deep, self.height_mm.unwrap_or(stacked.clamp(LENGTHS_MM[0], HIGHEST_MM))]
    }

    /// Its lengths, mm, without a limit an infinite one.
    pub(super) fn lengths_mm(&self) -> [f64; 3] {
        let [wide, deep] = self.base_mm;
        [wide, deep, self.height_mm.unwrap_or(f64::INFINITY)]
    }
}

impl FromStr for PackSpace {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let three = numbers(text).map(|[x, y, z]: [f64; 3]| Self { base_mm: [x, y], height_mm: Some(z) });
        let two = || numbers(text).map(|base_mm: [f64; 2]| Self { base_mm, height_mm: None });
        three.or_else(two).ok_or(
            "must be lengths in mm separated by commas, for example 200,200,250; with --goal height 200,200 is enough",
        )
    }
}

/// What is looked for, once it goes with the space and the values.
pub(super) fn goal(options: &PackOptions, into: &Into) -> Result<PackGoal, PackError> {
    let goals = [("runs", PackGoal::Runs), ("fill", PackGoal::Filling), ("height", PackGoal::Height)];
    let by_values = if options.fill.is_some() { "fill" } else { "runs" };
    let (goal, name) = named("goal", options.goal.as_deref().unwrap_or(by_values), &goals)?;
    let needs = |why| PackError::from(BadPacking::Goal { goal: name.to_owned(), why });
    if goal != PackGoal::Filling && options.fill.is_some() {
        return Err(needs("values are for the goal fill; leave out --fill, or use --goal fill"));
    }
    match into {
        Into::Table(_) if goal == PackGoal::Height => Err(needs("it needs a base; use --space X,Y instead of -m")),
        Into::Space(space) if goal != PackGoal::Height && space.height_mm.is_none() => {
            Err(needs("it needs the height of the space; use --space X,Y,Z"))
        }
        Into::Space(space) => {
            for length in space.base_mm.into_iter().chain(space.height_mm) {
                BadSetting::within("space", length, " mm", LENGTHS_MM)?;
            }
            Ok(goal)
        }
        Into::Table(_) => Ok(goal),
    }
}
