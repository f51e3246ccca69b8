//! A settled state in words and numbers: errors, deviations, how far the axes are from the profile's, and what stands against writing it.

use super::chain::{Chain, UNKNOWNS, Unknown};
use super::found::{Bend, ChainFit, Deviation, Estimate, FitOptions, Outlier, Refusal, Sag};
use super::outliers::{LeftOut, Linear};
use super::poses;
use super::solve::{Problem, Row, units};
use super::touches::TouchShape;
use crate::geom::{Angle, Vec3};
use crate::motion::{Pose, TableKinematics};
use crate::profile::Profile;

/// The same for a sum of squares, as a standard normal deviate.
const SCATTERED: f64 = 4.3;
/// Below this many degrees of freedom the touches' own scatter says little, and `repeats_to_mm` is taken where it is larger.
pub(super) const FEW: usize = 8;

/// What is reported on.
pub(super) struct Report<'a> {
    pub(super) profile: &'a Profile,
    pub(super) problem: &'a Problem<'a>,
    pub(super) options: &'a FitOptions,
    pub(super) lever: f64,
    /// Touches that did not count, by their places.
    pub(super) kept: Vec<usize>,
    /// The same, each with how far it is off.
    pub(super) left_out: LeftOut,
}

impl Report<'_> {
    /// The result of the state with all unknowns, and of the one whose axes are the profile's.
    pub(super) fn of(self, state: &[f64], free: &[usize], square: &[f64], stiff: &[usize]) -> ChainFit {
        let touches = self.problem.touches;
        let chain = self.problem.chain(state);
        let as_it_was = self.problem.chain(square).table();
        let bend = (!self.options.square).then(|| bend(self.profile, &chain, &as_it_was));
        let misaligned = bend.as_ref().is_some_and(|bend| bend.mm > self.options.tolerance_mm);
        let table = if misaligned { chain.table() } else { as_it_was };
        let (mut estimates, rms_mm, freedom, deviations) = self.estimates(state, free);
        if !misaligned {
            let (stiff, ..) = self.estimates(square, stiff);
            estimates.retain(|estimate| estimate.unknown.bends());
            estimates.splice(0..0, stiff);
        }
        let outliers: Vec<Outlier> = self
            .left_out
            .iter()
            .map(|&(index, off_mm)| {
                let touch = &touches.touches[index];
                Outlier { number: touch.number, line: touch.line, off_mm }
            })
            .collect();
        let sag = estimates.iter().find(|e| e.unknown == Unknown::Sag).map(|e| self.at_rim(e));
        let refusals = self.refusals(&outliers, rms_mm, freedom, bend.as_ref(), sag);
        let places = self.places(state);
        ChainFit {
            chain,
            table,
            misaligned,
            estimates,
            deviations,
            outliers,
            places,
            rms_mm,
            freedom,
            bend,
            sag,
            refusals,
        }
    }

    /// The unknowns with their errors, the scatter, the freedom and the deviations of one state.
    fn estimates(&self, state: &[f64], free: &[usize]) -> (Vec<Estimate>, f64, usize, Vec<Deviation>) {
        let Some(linear) = Linear::of(self.problem, state, free, &self.kept, self.lever) else {
            return (Vec::new(), f64::NAN, 0, Vec::new());
        };
        let freedom = linear.freedom();
        let rms = if freedom > 0 { (linear.squares() / freedom as f64).sqrt() } else { 0.0 };
        let noise = self.problem.touches.tip.repeats_to_mm;
        let scatter = if freedom < FEW { rms.max(noise) } else { rms };
        let wide = scatter * student_95(freedom);
        let (unit, names) = (units(self.problem.length, self.lever), Unknown::names(self.problem.nominal));
        let estimate = |(place, &i): (usize, &usize)| {
            let unknown = *Unknown::ALL.get(i)?;
            let error = wide * linear.inverse[(place, place)].max(0.0).sqrt() / unit[i];
            let shown = |value: f64| if unknown.is_angle() { value.to_degrees() } else { value };
            Some(Estimate { unknown, name: names[i].clone(), differs: shown(state[i]), error: shown(error) })
        };
        let estimates = free.iter().enumerate().filter_map(estimate).collect();
        (estimates, rms, freedom, self.deviations(&linear.rows))
    }

    fn deviations(&self, rows: &[(usize, Row)]) -> Vec<Deviation> {
        let mut all: Vec<Deviation> = Vec::new();
        for (index, row) in rows {
            let touch = &self.problem.touches.touches[*index];
            match all.last_mut().filter(|last| last.number == touch.number) {
                Some(last) => last.off_mm = last.off_mm.hypot(row.off_mm()),
                None => all.push(Deviation {
                    number: touch.number,
                    line: touch.line,
                    of: touch.of,
                    words_deg: touch.words_deg,
                    off_mm: row.off_mm(),
                }),
            }
        }
        all
    }

    /// A sag as it is at the table's rim.
    fn at_rim(&self, estimate: &Estimate) -> Sag {
        let share = poses::sag_at_rim(self.profile);
        Sag { mm: estimate.differs * share, error_mm: estimate.error * share }
    }

    fn refusals(
        &self,
        outliers: &[Outlier],
        rms_mm: f64,
        freedom: usize,
        bend: Option<&Bend>,
        sag: Option<Sag>,
    ) -> Vec<Refusal> {
        let mut all = Vec::new();
        let noise_mm = self.problem.touches.tip.repeats_to_mm;
        if !outliers.is_empty() {
            all.push(Refusal::Outliers);
        }
        if freedom > 0 && rms_mm.powi(2) * freedom as f64 > chi_square(freedom) * noise_mm * noise_mm {
            all.push(Refusal::Scattered { rms_mm, noise_mm });
        }
        let allowed_mm = self.options.tolerance_mm;
        if let Some(bend) = bend {
            let mm = bend.surface_mm;
            all.extend((mm > allowed_mm).then_some(Refusal::Sloped { mm, allowed_mm }));
        }
        if let Some(Sag { mm, error_mm }) = sag {
            let sure = mm.abs() > allowed_mm && mm.abs() > error_mm;
            all.extend(sure.then_some(Refusal::Sagging { mm, allowed_mm }));
        }
        all
    }

    fn places(&self, state: &[f64]) -> Vec<(String, [f64; 3])> {
        let mut rest = state[UNKNOWNS..].iter();
        let mut next = || rest.next().copied().unwrap_or_default();
        let mut place = |shape: TouchShape| match shape {
            TouchShape::Mark { height, known } => {
                let [x, y] = known.unwrap_or_else(|| [next(), next()]);
                [x, y, height]
            }
            TouchShape::Ball { .. } => [next(), next(), next()],
        };
        self.problem.touches.features.iter().map(|f| (f.name.clone(), place(f.shape))).collect()
    }
}

/// Half the width of the interval that holds 95 of 100, in standard errors: Student's t, by E. A. Cornish and R. A. Fisher (1938); without
/// freedom it is taken as for one.
pub(super) fn student_95(freedom: usize) -> f64 {
    match freedom {
        0 | 1 => 12.706,
        2 => 4.303,
        3 => 3.182,
        4 => 2.776,
        _ => {
            let (z, n): (f64, f64) = (1.959_964, freedom as f64);
            z + (z.powi(3) + z) / (4.0 * n) + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * n * n)
        }
    }
}

/// The sum of so many squares that is passed once in 100,000 cases (E. B. Wilson and M. M. Hilferty, 1931).
pub(super) fn chi_square(freedom: usize) -> f64 {
    let n = freedom as f64;
    let share = 2.0 / (9.0 * n);
    n * (1.0 - share + SCATTERED * share.sqrt()).powi(3)
}

/// The farthest that a point of the table, or as high above it as it is wide, is from where the machine with the profile's axes has it.
fn bend(profile: &Profile, chain: &Chain, square: &TableKinematics) -> Bend {
    let measured = chain.table();
    let rim: Vec<Vec3> = profile.table_slab().into_iter().filter(|p| p.z == 0.0).collect();
    let height = rim.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let points: Vec<Vec3> = rim.iter().flat_map(|p| [*p, p + Vec3::z() * height]).collect();
    let mut mm = 0.0_f64;
    for words_deg in poses::all_words(profile) {
        let [tilt, rotation] = words_deg.map(Angle::from_deg);
        let at = |table: &TableKinematics| {
            table.forward(Pose { tilt: table.tilt.angle_of(tilt), rotation: table.rotation.angle_of(rotation) })
        };
        let (theirs, ours) = (at(square), at(&measured));
        let off = |q: &Vec3| (theirs.rotation * q + theirs.translation - ours.rotation * q - ours.translation).norm();
        mm = points.iter().map(off).fold(mm, f64::max);
    }
    let surface_mm = height * chain.by()[Unknown::Unlevel as usize].sin().abs();
    Bend { mm, surface_mm }
}
