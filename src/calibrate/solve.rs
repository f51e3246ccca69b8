//! What a touch should have shown, by how much it differs, and how that moves with each unknown.
//!
//! The state is the machine's [`UNKNOWNS`], then two numbers (table frame, mm) for each mark whose place is not known and three for
//! each ball. Residuals are mm, and none but the touch's own error is in them.

use nalgebra::{DMatrix, DVector};

use super::chain::{Chain, PosedChain, SAG_AT_MM, UNKNOWNS, Unknown};
use super::touches::{Of, TipShape, Touch, TouchShape, Touches};
use crate::geom::{Angle, Vec3};
use crate::motion::TableKinematics;

/// What no touch can be told from above: a surface steeper than this, as the cosine of its angle to level.
const STEEPEST: f64 = 0.087;

/// Touches with the machine they were made on.
pub(super) struct Problem<'a> {
    pub(super) nominal: &'a TableKinematics,
    pub(super) touches: &'a Touches,
    /// By feature, where its numbers begin in the state.
    bases: Vec<usize>,
    /// How long a state is.
    pub(super) length: usize,
}

/// One number of a touch: by how much it is off, and its slopes, both times what it weighs: all repeat to [`super::touches::Tip::repeats_to_mm`] then.
pub(super) struct Row {
    pub(super) off: f64,
    pub(super) slopes: Vec<f64>,
    /// How much less it counts than a height.
    pub(super) weight: f64,
}

impl Row {
    /// By how much it is off, mm.
    pub(super) fn off_mm(&self) -> f64 {
        self.off / self.weight
    }

    /// Counts less, where it repeats to `sigma` and a height to `repeats`.
    fn weighed(mut self, repeats: f64, sigma: f64) -> Self {
        self.weight = repeats / sigma;
        self.off *= self.weight;
        self.slopes.iter_mut().for_each(|slope| *slope *= self.weight);
        self
    }
}

impl<'a> Problem<'a> {
    pub(super) fn new(nominal: &'a TableKinematics, touches: &'a Touches) -> Self {
        let (mut bases, mut length) = (Vec::new(), UNKNOWNS);
        for feature in &touches.features {
            bases.push(length);
            length += match feature.shape {
                TouchShape::Mark { known: Some(_), .. } => 0,
                TouchShape::Mark { known: None, .. } => 2,
                TouchShape::Ball { .. } => 3,
            };
        }
        Self { nominal, touches, bases, length }
    }

    pub(super) fn chain(&self, state: &[f64]) -> Chain {
        let mut by = [0.0; UNKNOWNS];
        by.copy_from_slice(&state[..UNKNOWNS]);
        Chain::new(self.nominal.clone(), by)
    }

    /// The machine as the profile has it, features where their first touches put them.
    pub(super) fn start(&self) -> Vec<f64> {
        let mut state = vec![0.0; self.length];
        let chain = self.chain(&state);
        for (index, (feature, &base)) in self.touches.features.iter().zip(&self.bases).enumerate() {
            let of: Vec<&Touch> = self.touches.touches.iter().filter(|t| t.of == Of::Feature(index)).collect();
            let lift = |radius: f64| Vec3::z() * radius;
            let at = |touch: &&Touch| {
                let below = if let TouchShape::Ball { radius } = feature.shape { lift(radius) } else { Vec3::zeros() };
                placed(&chain, touch.words_deg).on_table(&(touch.at - below))
            };
            let sum: Vec3 = of.iter().map(at).sum();
            let mean = sum / of.len().max(1) as f64;
            match feature.shape {
                TouchShape::Mark { known: Some(_), .. } => {}
                TouchShape::Mark { .. } => state[base..base + 2].copy_from_slice(&mean.as_slice()[..2]),
                TouchShape::Ball { .. } => state[base..base + 3].copy_from_slice(mean.as_slice()),
            }
        }
        state
    }

    /// What `touch` says in `state`: one number, or three for a mark.
    pub(super) fn rows(&self, touch: &Touch, state: &[f64]) -> Vec<Row> {
        self.rows_in(touch, state, &self.chain(state))
    }

    fn rows_in(&self, touch: &Touch, state: &[f64], chain: &Chain) -> Vec<Row> {
        let placed = placed(chain, touch.words_deg);
        let of = One { problem: self, touch, placed, state };
        match touch.of {
            Of::Table => vec![of.table()],
            Of::Feature(index) => match self.touches.features[index].shape {
                TouchShape::Mark { height, known } => of.mark(index, height, known),
                TouchShape::Ball { radius } => vec![of.ball(index, radius)],
            },
        }
    }

    /// The first touch that no tip from above can make, with the reason; from which side a ball is met is looked at only where the state
    /// has `settled`.
    pub(super) fn impossible(&self, state: &[f64], settled: bool) -> Option<(usize, String)> {
        let chain = self.chain(state);
        self.touches.touches.iter().enumerate().find_map(|(index, touch)| {
            let placed = placed(&chain, touch.words_deg);
            let steep = placed.direction(&Vec3::z()).z < STEEPEST;
            let feature = match touch.of {
                Of::Feature(index) => Some((index, self.touches.features[index].shape)),
                Of::Table => None,
            };
            let why = match feature {
                Some((_, TouchShape::Ball { .. })) if !settled => None,
                Some((index, TouchShape::Ball { radius })) => {
                    let base = self.bases[index];
                    let centre = placed.point(&Vec3::new(state[base], state[base + 1], state[base + 2]));
                    let beside = self.touches.tip.shape == TipShape::Flat && touch.at.z - centre.z < 0.5 * radius;
                    beside.then_some(
                        "a flat tip touched the ball from the side, where the nozzle's own shape matters; touch it from above, or use a ball tip",
                    )
                }
                _ => steep.then_some("the table is more than 85 deg from level there, and a tip from above cannot touch it"),
            };
            why.map(|why: &str| (index, why.to_owned()))
        })
    }
}

fn placed(chain: &Chain, words_deg: [f64; 2]) -> PosedChain<'_> {
    let [tilt, rotation] = words_deg.map(Angle::from_deg);
    chain.at(tilt, rotation)
}

struct One<'a> {
    problem: &'a Problem<'a>,
    touch: &'a Touch,
    placed: PosedChain<'a>,
    state: &'a [f64],
}

/// How far the tip's own point stands from a surface that it touches, along the surface's normal, and how that moves with the normal.
fn standoff(shape: TipShape, radius: f64, normal: &Vec3) -> (f64, Vec3) {
    match shape {
        // The disc's rim comes down first.
        TipShape::Flat => {
            let level = Vec3::new(normal.x, normal.y, 0.0);
            let across = level.norm();
            (radius * across, if across > 0.0 { level * (radius / across) } else { Vec3::zeros() })
        }
        TipShape::Ball => (radius * (1.0 - normal.z), -Vec3::z() * radius),
    }
}

/// How much lower a sagging surface is at a place of the table's frame, for each mm that it is at [`SAG_AT_MM`].
fn sag_share(x: f64, y: f64) -> f64 {
    (x * x + y * y) / (SAG_AT_MM * SAG_AT_MM)
}

impl One<'_> {
    fn row(&self, off: f64, machine: impl Fn(usize) -> f64) -> Row {
        let mut slopes = vec![0.0; self.problem.length];
        slopes.iter_mut().take(UNKNOWNS).enumerate().for_each(|(i, slope)| *slope = machine(i));
        Row { off, slopes, weight: 1.0 }
    }

    /// The rise of the surface for each mm to the side, as the profile has it: what a touch weighs must not move with the state.
    fn slope(&self) -> f64 {
        let chain = Chain::new(self.problem.nominal.clone(), [0.0; UNKNOWNS]);
        let normal = placed(&chain, self.touch.words_deg).direction(&Vec3::z());
        normal.x.hypot(normal.y) / normal.z
    }

    fn sag(&self) -> f64 {
        self.state[Unknown::Sag as usize]
    }

    fn table(&self) -> Row {
        let tip = &self.problem.touches.tip;
        let (normal, normals) = self.placed.normal_slopes();
        let origin = self.placed.point(&Vec3::zeros());
        let origins = self.placed.point_slopes(&Vec3::zeros());
        let arm = self.touch.at - origin;
        let (gap, gaps) = standoff(tip.shape, tip.radius_mm, &normal);
        let (met, sag) = (self.placed.on_table(&self.touch.at), self.sag());
        let moved = self.placed.point_slopes(&met);
        let share = sag_share(met.x, met.y);
        let shares = |i: usize| {
            let away = self.placed.inward(&moved[i]);
            -2.0 * (met.x * away.x + met.y * away.y) / (SAG_AT_MM * SAG_AT_MM)
        };
        let mut row = self.row(normal.dot(&arm) - gap - tip.paper_mm + sag * share, |i| {
            normals[i].dot(&arm) - normal.dot(&origins[i]) - gaps.dot(&normals[i]) + sag * shares(i)
        });
        row.slopes[Unknown::Sag as usize] = share;
        row
    }

    /// The tip stands straight above the mark, as high as its form and the paper keep it over the surface.
    fn mark(&self, index: usize, height: f64, known: Option<[f64; 2]>) -> Vec<Row> {
        let base = self.problem.bases[index];
        let [x, y] = known.unwrap_or_else(|| [self.state[base], self.state[base + 1]]);
        let q = Vec3::new(x, y, height);
        let tip = &self.problem.touches.tip;
        let (normal, normals) = self.placed.normal_slopes();
        let (gap, gaps) = standoff(tip.shape, tip.radius_mm, &normal);
        let (sag, share) = (self.sag(), sag_share(x, y));
        let up = (gap + tip.paper_mm - sag * share) / normal.z;
        let off = self.touch.at - self.placed.point(&q) - Vec3::z() * up;
        let (across, repeats) = (tip.across_mm(), tip.repeats_to_mm);
        // On a slope what is off across is off in height, too.
        let high = if across > repeats { repeats.hypot(across * self.slope()) } else { repeats };
        let sigma = [across, across, high];
        let points = self.placed.point_slopes(&q);
        let rise = |i: usize| (gaps.dot(&normals[i]) - up * normals[i].z) / normal.z;
        let along = [Vec3::x(), Vec3::y()].map(|d| self.placed.direction(&d));
        (0..3)
            .map(|axis| {
                let rising = |i: usize| if axis == 2 { rise(i) } else { 0.0 };
                let mut row = self.row(off[axis], |i| -points[i][axis] - rising(i));
                if known.is_none() {
                    row.slopes[base] = -along[0][axis];
                    row.slopes[base + 1] = -along[1][axis];
                }
                if axis == 2 {
                    row.slopes[Unknown::Sag as usize] = share / normal.z;
                    let by_place = 2.0 * sag / (SAG_AT_MM * SAG_AT_MM * normal.z);
                    if known.is_none() {
                        row.slopes[base] += by_place * x;
                        row.slopes[base + 1] += by_place * y;
                    }
                }
                row.weighed(repeats, sigma[axis])
            })
            .collect()
    }

    fn ball(&self, index: usize, radius: f64) -> Row {
        let base = self.problem.bases[index];
        let q = Vec3::new(self.state[base], self.state[base + 1], self.state[base + 2]);
        let tip = &self.problem.touches.tip;
        let centre = self.placed.point(&q);
        let points = self.placed.point_slopes(&q);
        // From the ball's middle to the nearest point of the tip, or to the middle of the tip's own ball.
        let (away, owed) = match tip.shape {
            TipShape::Ball => (self.touch.at + Vec3::z() * tip.radius_mm - centre, radius + tip.radius_mm),
            TipShape::Flat => {
                let away = self.touch.at - centre;
                let sideways = away.x.hypot(away.y);
                let left = if sideways > tip.radius_mm { 1.0 - tip.radius_mm / sideways } else { 0.0 };
                (Vec3::new(away.x * left, away.y * left, away.z), radius)
            }
        };
        let distance = away.norm();
        let outward = if distance > 0.0 { away / distance } else { Vec3::z() };
        let mut row = self.row(distance - owed - tip.paper_mm, |i| -outward.dot(&points[i]));
        for axis in 0..3 {
            let e = Vec3::ith(axis, 1.0);
            row.slopes[base + axis] = -outward.dot(&self.placed.direction(&e));
        }
        row
    }
}

/// What is off at each touch, mm, of a machine that differs from `nominal` by `by`, features at `places` (table frame; two numbers a
/// mark whose place is not known, three a ball), in the order of the touches; three numbers a mark.
pub fn residuals(nominal: &TableKinematics, touches: &Touches, by: &[f64; UNKNOWNS], places: &[f64]) -> Vec<f64> {
    let problem = Problem::new(nominal, touches);
    let state = [&by[..], places].concat();
    problem.all_rows(&state, &[]).into_iter().map(|(_, row)| row.off_mm()).collect()
}

/// What least squares need of measurements: how long a state is, and what each number is off by in a state.
pub(super) trait Measured {
    /// How many numbers a state has: [`UNKNOWNS`], then those of what was measured.
    fn length(&self) -> usize;

    /// All numbers of `state` but those of the measurements at `left_out`, each with the place of its measurement.
    fn all_rows(&self, state: &[f64], left_out: &[usize]) -> Vec<(usize, Row)>;
}

impl Measured for Problem<'_> {
    fn length(&self) -> usize {
        self.length
    }

    fn all_rows(&self, state: &[f64], left_out: &[usize]) -> Vec<(usize, Row)> {
        let chain = self.chain(state);
        let of = |(index, touch): (usize, &Touch)| -> Vec<(usize, Row)> {
            self.rows_in(touch, state, &chain).into_iter().map(|row| (index, row)).collect()
        };
        let kept = self.touches.touches.iter().enumerate().filter(|(index, _)| !left_out.contains(index));
        kept.flat_map(of).collect()
    }
}

/// A state at rest.
pub(super) struct Solved {
    pub(super) state: Vec<f64>,
    /// Whether it came to rest.
    pub(super) settled: bool,
}

/// Steps at most.
const MOST_STEPS: usize = 200;
/// Where a step moves nothing by more than this, mm at `lever`, the state is at rest.
const AT_REST: f64 = 1e-9;

/// What counts a unit of each unknown, so that all are lengths: 1 for lengths, `lever` mm for angles.
pub(super) fn units(length: usize, lever: f64) -> Vec<f64> {
    (0..length)
        .map(|i| if Unknown::ALL.get(i).is_some_and(|unknown| unknown.is_angle()) { lever } else { 1.0 })
        .collect()
}

/// The state with the least sum of squares, `free` unknowns moving, the touches at `left_out` left out.
pub(super) fn solve<M: Measured>(
    problem: &M,
    from: Vec<f64>,
    free: &[usize],
    left_out: &[usize],
    lever: f64,
) -> Solved {
    let unit = units(problem.length(), lever);
    let squares = |state: &[f64]| problem.all_rows(state, left_out).iter().map(|(_, r)| r.off * r.off).sum::<f64>();
    let (mut state, mut damping) = (from, 1e-3);
    let mut now = squares(&state);
    for _ in 0..MOST_STEPS {
        let rows = problem.all_rows(&state, left_out);
        let j = jacobian(&rows, free, &unit);
        let off = DVector::from_iterator(rows.len(), rows.iter().map(|(_, row)| row.off));
        let (square, down) = (j.transpose() * &j, j.transpose() * off);
        let mut moved = false;
        while damping < 1e12 {
            let mut damped = square.clone();
            (0..free.len()).for_each(|i| damped[(i, i)] += damping * (1e-9 + square[(i, i)]));
            let step = damped.cholesky().map(|c| c.solve(&down)).unwrap_or_else(|| DVector::zeros(free.len()));
            let mut next = state.clone();
            free.iter().zip(step.iter()).for_each(|(&i, s)| next[i] -= s / unit[i]);
            let then = squares(&next);
            let least = step.amax() < AT_REST;
            if then <= now || least {
                let better = then <= now;
                state = if better { next } else { state };
                now = now.min(then);
                damping = (damping * 0.2).max(1e-12);
                moved = true;
                if least {
                    return Solved { state, settled: true };
                }
                break;
            }
            damping *= 5.0;
        }
        if !moved {
            break;
        }
    }
    Solved { state, settled: false }
}

/// The slopes of `rows` by the `free` unknowns in their units.
pub(super) fn jacobian(rows: &[(usize, Row)], free: &[usize], unit: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), free.len(), |r, c| rows[r].1.slopes[free[c]] / unit[free[c]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::{Feature, Tip};
    use crate::geom::SplitMix64;
    use crate::profile::resolve;

    /// Every slope of every kind of touch against differences.
    #[test]
    fn slopes_are_those_of_differences() {
        const STEP: f64 = 1e-5;
        let mut numbers = SplitMix64::seeded(5);
        let mut near = |reach: f64| (2.0 * numbers.unit() - 1.0) * reach;
        let mark = |known| TouchShape::Mark { height: 2.0, known };
        let shapes = [mark(None), mark(Some([30.0, -20.0])), TouchShape::Ball { radius: 6.0 }];
        let features: Vec<Feature> =
            shapes.iter().enumerate().map(|(i, &shape)| Feature { name: i.to_string(), shape }).collect();
        for name in ["generic-ac", "fibr3d"] {
            let nominal = resolve("m.toml", &format!("extends = {name:?}")).unwrap().0.kinematics();
            for shape in [TipShape::Flat, TipShape::Ball] {
                let tip = Tip { shape, radius_mm: 0.7, paper_mm: 0.1, ..Tip::default() };
                let mut touches = Touches { tip, features: features.clone(), touches: Vec::new(), empty: Vec::new() };
                for index in 0..40 {
                    let of = if index % 4 == 3 { Of::Table } else { Of::Feature(index % 4) };
                    let at = Vec3::new(near(80.0), near(80.0), near(80.0));
                    touches.touches.push(Touch { number: 1, line: 1, of, words_deg: [near(70.0), near(360.0)], at });
                }
                let problem = Problem::new(&nominal, &touches);
                let state: Vec<f64> =
                    (0..problem.length).map(|i| near(if (5..12).contains(&i) { 0.05 } else { 5.0 })).collect();
                assert_eq!(state.len(), UNKNOWNS + 5);
                for touch in &touches.touches {
                    let rows = problem.rows(touch, &state);
                    for (i, _) in state.iter().enumerate() {
                        let moved = |way: f64| {
                            let mut state = state.clone();
                            state[i] += way * STEP;
                            problem.rows(touch, &state)
                        };
                        let (up, down) = (moved(1.0), moved(-1.0));
                        for (row, (up, down)) in rows.iter().zip(up.iter().zip(&down)) {
                            let slope = (up.off - down.off) / (2.0 * STEP);
                            assert!(
                                (row.slopes[i] - slope).abs() < 2e-5,
                                "{i} {:?}: {} {slope}",
                                touch.of,
                                row.slopes[i]
                            );
                        }
                    }
                }
            }
        }
    }
}
