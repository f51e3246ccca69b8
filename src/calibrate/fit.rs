//! The machine that agrees best with its touches: what each unknown is and how surely, which touch is off, and how far the machine is
//! from one that a profile can hold.

use super::chain::{UNKNOWNS, Unknown};
use super::found::{ChainFit, FitOptions};
use super::information::{Information, WORST_DEG, WORST_MM};
use super::outliers::{settled, without_outliers};
use super::poses;
use super::report::Report;
use super::solve::{Measured, Problem, units};
use super::touches::{ChainCandidate, Of, TouchShape, Touches};
use crate::profile::Profile;

/// What the touches do not tell.
#[derive(Clone, Debug, PartialEq)]
pub struct Undetermined {
    /// Name, standard error (mm or degrees), and whether it is an angle.
    pub unknowns: Vec<(String, f64, bool)>,
    /// What to touch next, the first helping most.
    pub next: Vec<ChainCandidate>,
    /// A mark that is not in the file, at this place of the table's frame, which `next` needs.
    pub new_mark: Option<[f64; 2]>,
}

/// Why there is no result.
#[derive(Debug)]
pub enum NoFit {
    /// A touch that cannot be: its number, its line, and why.
    Touch(usize, usize, String),
    /// Not enough of them.
    Undetermined(Undetermined),
    /// The steps went on without end.
    Unsettled,
}

/// The machine of `touches`, beginning with what `profile` says.
///
/// # Errors
///
/// [`NoFit`].
pub fn fit(profile: &Profile, touches: &Touches, options: &FitOptions) -> Result<ChainFit, NoFit> {
    let nominal = profile.kinematics();
    let problem = Problem::new(&nominal, touches);
    let lever = poses::lever(profile);
    let start = problem.start();
    let mut free = free(&problem, &start, options.square);
    free.extend(tells_sag(profile, &problem, &free, &start).then_some(Unknown::Sag as usize));
    free.sort_unstable();
    possible(&problem, &start, false)?;
    told(profile, &problem, &free, &start)?;
    let (solved, left_out) = without_outliers(&problem, &start, &free, lever).ok_or(NoFit::Unsettled)?;
    possible(&problem, &solved, true)?;
    told(profile, &problem, &free, &solved)?;
    let stiff: Vec<usize> = free.iter().copied().filter(|&i| i >= UNKNOWNS || !Unknown::ALL[i].bends()).collect();
    let kept: Vec<usize> = left_out.iter().map(|(index, _)| *index).collect();
    let square = || settled(&problem, &start, &stiff, &kept, lever).ok_or(NoFit::Unsettled);
    let square = if options.square { solved.clone() } else { square()? };
    Ok(Report { profile, problem: &problem, options, lever, kept, left_out }.of(&solved, &free, &square, &stiff))
}

fn possible(problem: &Problem<'_>, state: &[f64], settled: bool) -> Result<(), NoFit> {
    problem.impossible(state, settled).map_or(Ok(()), |(index, why)| {
        let touch = &problem.touches.touches[index];
        Err(NoFit::Touch(touch.number, touch.line, why))
    })
}

/// What can be looked for: the rotation's zero only where a mark's place is known.
fn free(problem: &Problem<'_>, start: &[f64], square: bool) -> Vec<usize> {
    let touches = problem.touches;
    let known = |of: Of| matches!(of, Of::Feature(i) if matches!(touches.features[i].shape, TouchShape::Mark { known: Some(at), .. } if at[0].hypot(at[1]) > 1.0));
    let zero = touches.touches.iter().any(|touch| known(touch.of));
    let asked = |i: &usize| match Unknown::ALL.get(*i) {
        Some(Unknown::RotationZero) => zero,
        Some(Unknown::Sag) => false,
        Some(unknown) => !(square && unknown.bends()),
        None => true,
    };
    let rows = problem.all_rows(start, &[]);
    let touched = |i: &usize| *i < UNKNOWNS || rows.iter().any(|(_, row)| row.slopes[*i] != 0.0);
    (0..problem.length).filter(asked).filter(touched).collect()
}

/// Whether the touches tell, beside all else, whether the table sags: places near its middle are among them.
fn tells_sag(profile: &Profile, problem: &Problem<'_>, free: &[usize], state: &[f64]) -> bool {
    let all: Vec<usize> = free.iter().copied().chain([Unknown::Sag as usize]).collect();
    let information = informed(profile, problem, &all, state);
    information.error(Unknown::Sag as usize) * poses::sag_at_rim(profile) <= WORST_MM
}

/// What all touches tell of the `free` unknowns.
fn informed(profile: &Profile, problem: &Problem<'_>, free: &[usize], state: &[f64]) -> Information {
    let touches = problem.touches;
    let unit = units(problem.length, poses::lever(profile));
    let mut information = Information::before(unit, free, touches.tip.repeats_to_mm);
    touches.touches.iter().for_each(|touch| information.add(&problem.rows(touch, state)));
    information
}

/// Whether the touches tell every unknown of the machine.
fn told(profile: &Profile, problem: &Problem<'_>, free: &[usize], state: &[f64]) -> Result<(), NoFit> {
    let information = informed(profile, problem, free, state);
    let machine = || free.iter().copied().filter(|&i| i < UNKNOWNS);
    let worst: Vec<usize> = machine().filter(|&i| information.error(i) > worst(Unknown::ALL[i])).collect();
    if worst.is_empty() {
        return Ok(());
    }
    let names = Unknown::names(problem.nominal);
    let told = |&i: &usize| {
        let (angle, error) = (Unknown::ALL[i].is_angle(), information.error(i));
        (names[i].clone(), if angle { error.to_degrees() } else { error }, angle)
    };
    let unknowns = worst.iter().map(told).collect();
    let (next, new_mark) = poses::next(profile, problem, &information, state, free);
    Err(NoFit::Undetermined(Undetermined { unknowns, next, new_mark }))
}

fn worst(unknown: Unknown) -> f64 {
    if unknown.is_angle() { WORST_DEG.to_radians() } else { WORST_MM }
}
