//! What each dimension would be on a machine that differs from its profile, and how that moves with each difference.
//!
//! The state is the machine's [`UNKNOWNS`], then by how much a line is wider than drawn, and by how much all heights above the underside
//! are off (the first layer is pressed to the table as it needs), mm.

use super::super::chain::{Chain, UNKNOWNS, Unknown};
use super::super::solve::{Measured, Row};
use super::design::{Block, BlockCorner, DimensionKind, Tower};
use super::form::CalliperReading;
use crate::geom::{Angle, Vec3};
use crate::motion::TableKinematics;

/// By how much a width over two walls is more than drawn, in the state.
pub(super) const WIDER: usize = UNKNOWNS;
/// By how much all heights are.
pub(super) const HIGHER: usize = UNKNOWNS + 1;
/// How long a state is.
pub(super) const STATE: usize = UNKNOWNS + 2;

/// A point or a direction as it was printed, and how it moves with each number of the state, table frame.
struct Printed {
    at: Vec3,
    slopes: [Vec3; STATE],
}

/// A tower with what was read off it.
pub(super) struct Gauge<'a> {
    nominal: Chain,
    profile: &'a TableKinematics,
    tower: &'a Tower,
    readings: &'a [CalliperReading],
    /// The machine by which the corners are chosen that jaws touch; `None` for the one that is asked.
    touched: Option<Chain>,
}

/// A tilt's zero that says which corners of a block stick out, radians.
const LEANING: f64 = 0.01;

impl<'a> Gauge<'a> {
    pub(super) fn new(profile: &'a TableKinematics, tower: &'a Tower, readings: &'a [CalliperReading]) -> Self {
        Self { nominal: Chain::new(profile.clone(), [0.0; UNKNOWNS]), profile, tower, readings, touched: None }
    }

    /// The same with the corners that stick out where the tilt's zero is off by more or, for -1, by less than nothing: which corner it is
    /// changes there, and a dimension has no slope.
    pub(super) fn leaning(self, sign: f64) -> Self {
        let mut by = [0.0; UNKNOWNS];
        by[Unknown::TiltZero as usize] = sign * LEANING;
        Self { touched: Some(Chain::new(self.profile.clone(), by)), ..self }
    }

    pub(super) fn chain(&self, state: &[f64]) -> Chain {
        let mut by = [0.0; UNKNOWNS];
        by.copy_from_slice(&state[..UNKNOWNS]);
        Chain::new(self.profile.clone(), by)
    }

    /// The block's corner that is outermost `towards` a direction of the table's frame.
    fn outermost(&self, block: &'a Block, towards: &Vec3, chain: &Chain, state: &[f64]) -> Printed {
        let [tilt, rotation] = self.tower.words_deg()[block.step].map(Angle::from_deg);
        let (put, real) = (self.nominal.at(tilt, rotation), chain.at(tilt, rotation));
        let wider = state[WIDER] / 2.0;
        let touched = self.touched.as_ref().map(|chain| chain.at(tilt, rotation));
        let reach = |corner: &BlockCorner| {
            let by = touched.as_ref().unwrap_or(&real);
            by.on_table(&put.point(&(corner.at + corner.outward * wider))).dot(towards)
        };
        let farthest = block.corners.iter().map(|corner| (reach(corner), corner));
        let first = |best: (f64, &'a BlockCorner), one: (f64, &'a BlockCorner)| if one.0 > best.0 { one } else { best };
        let Some((_, corner)) = farthest.reduce(first) else {
            return Printed { at: Vec3::zeros(), slopes: [Vec3::zeros(); STATE] };
        };
        let at = real.on_table(&put.point(&(corner.at + corner.outward * wider)));
        let by_width = real.inward(&put.direction(&corner.outward)) / 2.0;
        let moved = real.point_slopes(&at);
        let mut slopes = [Vec3::zeros(); STATE];
        slopes.iter_mut().zip(&moved).for_each(|(slope, moved)| *slope = -real.inward(moved));
        slopes[WIDER] = by_width;
        Printed { at, slopes }
    }

    /// A dimension in `state`, mm, and its slopes.
    pub(super) fn value(&self, kind: DimensionKind, state: &[f64], chain: &Chain) -> (f64, Vec<f64>) {
        let block = |index: usize| -> &'a Block { &self.tower.blocks[index] };
        match kind {
            DimensionKind::Height(index) => {
                let top = self.outermost(block(index), &Vec3::z(), chain, state);
                let mut slopes: Vec<f64> = top.slopes.iter().map(|slope| slope.z).collect();
                slopes[HIGHER] = 1.0;
                (top.at.z + state[HIGHER], slopes)
            }
            DimensionKind::Across(both, drawn) => {
                let along = self.turned(&drawn, chain);
                let end = |towards: Vec3| {
                    let [one, other] = both.map(|index| self.outermost(block(index), &towards, chain, state));
                    if other.at.dot(&towards) > one.at.dot(&towards) { other } else { one }
                };
                let (far, near) = (end(along.at), end(-along.at));
                let arm = far.at - near.at;
                let slope = |i: usize| (far.slopes[i] - near.slopes[i]).dot(&along.at) + arm.dot(&along.slopes[i]);
                (arm.dot(&along.at), (0..STATE).map(slope).collect())
            }
        }
    }

    /// A direction that turns with the base as it was printed.
    fn turned(&self, drawn: &Vec3, chain: &Chain) -> Printed {
        let [tilt, rotation] = self.tower.words_deg()[0].map(Angle::from_deg);
        let (put, real) = (self.nominal.at(tilt, rotation), chain.at(tilt, rotation));
        let at = real.inward(&put.direction(drawn));
        let moved = real.point_slopes(&at).into_iter().zip(real.point_slopes(&Vec3::zeros()));
        let mut slopes = [Vec3::zeros(); STATE];
        slopes.iter_mut().zip(moved).for_each(|(slope, (tip, foot))| *slope = -real.inward(&(tip - foot)));
        Printed { at, slopes }
    }
}

impl Measured for Gauge<'_> {
    fn length(&self) -> usize {
        STATE
    }

    fn all_rows(&self, state: &[f64], left_out: &[usize]) -> Vec<(usize, Row)> {
        let chain = self.chain(state);
        let values: Vec<(f64, Vec<f64>)> =
            self.tower.dimensions.iter().map(|one| self.value(one.kind, state, &chain)).collect();
        let row = |reading: &CalliperReading| {
            let (value, slopes) = &values[reading.number - 1];
            (reading.number, Row { off: value - reading.mm, slopes: slopes.clone(), weight: 1.0 })
        };
        self.readings.iter().filter(|reading| !left_out.contains(&reading.number)).map(row).collect()
    }
}

/// What each dimension of a tower would be on a machine that differs from `profile` by `by` (mm, radians, in the order of
/// [`super::super::Unknown::ALL`]), with lines `wider_mm` wider than drawn, in the order of [`Tower::dimensions`], mm.
pub fn measured(profile: &TableKinematics, tower: &Tower, by: &[f64; UNKNOWNS], wider_mm: f64) -> Vec<f64> {
    let gauge = Gauge::new(profile, tower, &[]);
    let state = [&by[..], &[wider_mm, 0.0]].concat();
    let chain = gauge.chain(&state);
    tower.dimensions.iter().map(|one| gauge.value(one.kind, &state, &chain).0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::TowerDesign;
    use crate::geom::SplitMix64;
    use crate::profile::resolve;

    /// Every slope of every dimension against central differences, on tables about X and Y that count either way.
    #[test]
    fn slopes_are_those_of_differences() {
        const STEP: f64 = 1e-6;
        let mut numbers = SplitMix64::seeded(41);
        for name in ["generic-ac", "fibr3d", "hendrikjan-5d", "pentos", "linuxcnc-xyzac-trt"] {
            let (profile, _) = resolve("m.toml", &format!("extends = {name:?}")).unwrap();
            let table = profile.kinematics();
            let design = TowerDesign::candidates(&profile, name, None).unwrap()[0];
            let tower = Tower::of(&table, design);
            let gauge = Gauge::new(&table, &tower, &[]);
            for _ in 0..10 {
                let near = |numbers: &mut SplitMix64, reach: f64| (2.0 * numbers.unit() - 1.0) * reach;
                let mut state: Vec<f64> =
                    (0..STATE).map(|i| near(&mut numbers, if (5..12).contains(&i) { 0.03 } else { 1.5 })).collect();
                state[WIDER] = near(&mut numbers, 0.1);
                let at = |state: &[f64], kind| gauge.value(kind, state, &gauge.chain(state));
                for one in &tower.dimensions {
                    let (_, slopes) = at(&state, one.kind);
                    for (i, slope) in slopes.iter().enumerate() {
                        let moved = |way: f64| {
                            let mut state = state.clone();
                            state[i] += way * STEP;
                            at(&state, one.kind).0
                        };
                        let difference = (moved(1.0) - moved(-1.0)) / (2.0 * STEP);
                        assert!((slope - difference).abs() < 1e-5, "{name} {} {i}: {slope} {difference}", one.name);
                    }
                }
            }
        }
    }
}
