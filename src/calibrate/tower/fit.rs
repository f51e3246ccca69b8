//! The machine that agrees best with a tower's dimensions: what they determine, how surely, and which of them cannot be.

use nalgebra::DVector;

use super::super::chain::{Chain, UNKNOWNS, Unknown};
use super::super::found::Estimate;
use super::super::information::Information;
use super::super::outliers::Linear;
use super::super::poses;
use super::super::report::{FEW, chi_square, student_95};
use super::super::solve::{Measured, solve, units};
use super::design::{Dimension, Tower};
use super::error::TowerError;
use super::form::{CalliperReading, Readings};
use super::gauge::{Gauge, HIGHER, STATE, WIDER};
use crate::geom::{Angle, Vec3};
use crate::motion::TableKinematics;
use crate::profile::Profile;

/// A figure whose standard error is larger is not determined, mm or degrees.
const UNTOLD: f64 = 0.5;
/// Widths of lines and the height of the first layer are looked for where they are told better than this, mm.
const UNTOLD_MM: f64 = 1.0;
/// A column of slopes is dependent on others where less than this share of it is left without them.
const DEPENDENT: f64 = 1e-6;
/// No base holds on a table that is tilted by more, degrees.
const UNLEVEL_DEG: f64 = 1.5;
/// What a tower is asked: the axes' directions are the profile's.
const ASKED: [Unknown; 7] = [
    Unknown::PivotX,
    Unknown::PivotY,
    Unknown::PivotZ,
    Unknown::OffsetAcross,
    Unknown::OffsetZ,
    Unknown::TiltZero,
    Unknown::RotationZero,
];

/// What is left of a dimension, mm: above 0 it is drawn larger than it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct TowerDeviation {
    /// The dimension, from 1.
    pub number: usize,
    /// The mean of its readings.
    pub mm: f64,
    /// As drawn.
    pub drawn_mm: f64,
    /// The mean of what is left of them.
    pub off_mm: f64,
}

/// What a tower's dimensions come to.
#[derive(Clone, Debug)]
pub struct TowerFit {
    /// The machine.
    pub chain: Chain,
    /// What is written: where nothing is determined it is the profile's; the level table stays as high as it is.
    pub table: TableKinematics,
    /// What was determined, each with the half of its 95 % interval.
    pub estimates: Vec<Estimate>,
    /// What was not, by name.
    pub undetermined: Vec<String>,
    /// By how much a width over two walls is more than drawn, and half of the interval that holds it in 95 of 100 cases, mm.
    pub wider_mm: Option<[f64; 2]>,
    /// Each block that was printed on another: how far above what it stands on it began, mm; below 0 it was pressed into it.
    pub began_above: Vec<(&'static str, f64)>,
    /// What is left of each dimension.
    pub deviations: Vec<TowerDeviation>,
    /// The scatter of one reading, mm.
    pub rms_mm: f64,
    /// Readings more than unknowns.
    pub freedom: usize,
}

/// Readings that were fitted.
struct Fitted<'a> {
    gauge: Gauge<'a>,
    /// What was looked for, and which of it is determined.
    free: Vec<usize>,
    determined: Vec<usize>,
    state: Vec<f64>,
    linear: Linear,
}

impl Fitted<'_> {
    fn rms(&self) -> f64 {
        let freedom = self.linear.freedom();
        if freedom > 0 { (self.linear.squares() / freedom as f64).sqrt() } else { 0.0 }
    }

    /// Whether the readings agree as well as they repeat.
    fn agrees(&self, repeats_mm: f64) -> bool {
        let freedom = self.linear.freedom();
        freedom == 0 || self.linear.squares() <= chi_square(freedom) * repeats_mm * repeats_mm
    }
}

/// What a fit begins with.
struct Job<'a> {
    table: TableKinematics,
    tower: &'a Tower,
    repeats_mm: f64,
    lever: f64,
}

impl Job<'_> {
    /// What the readings at these dimensions determine: the machine's unknowns, then, beside these alone, lines and heights.
    fn determined(&self, readings: &[CalliperReading]) -> Vec<usize> {
        let information = self.information(readings, &asked().collect::<Vec<_>>());
        let told = |i: &usize| match Unknown::ALL.get(*i) {
            Some(unknown) if unknown.is_angle() => information.error(*i).to_degrees() < UNTOLD,
            Some(_) => information.error(*i) < UNTOLD,
            None => false,
        };
        let machine: Vec<usize> = asked().filter(told).collect();
        let beside: Vec<usize> = machine.iter().copied().chain([WIDER, HIGHER]).collect();
        let information = self.information(readings, &beside);
        beside.into_iter().filter(|&i| i < UNKNOWNS || information.error(i) < UNTOLD_MM).collect()
    }

    /// All that can be looked for at once, what is determined first: of figures that only occur together, one stands for all.
    fn independent(&self, readings: &[CalliperReading], determined: &[usize]) -> Vec<usize> {
        let gauge = Gauge::new(&self.table, self.tower, readings);
        let rows = gauge.all_rows(&[0.0; STATE], &[]);
        let mut kept: Vec<(usize, DVector<f64>)> = Vec::new();
        for i in determined.iter().copied().chain(asked().filter(|i| !determined.contains(i))) {
            let column = DVector::from_iterator(rows.len(), rows.iter().map(|(_, row)| row.slopes[i]));
            let left = kept.iter().fold(column.clone(), |left, (_, other)| &left - other * other.dot(&left));
            if left.norm() > DEPENDENT * column.norm() {
                kept.push((i, left.normalize()));
            }
        }
        let mut free: Vec<usize> = kept.into_iter().map(|(i, _)| i).collect();
        free.sort_unstable();
        free
    }

    /// What they tell where `free` is looked for.
    fn information(&self, readings: &[CalliperReading], free: &[usize]) -> Information {
        let gauge = Gauge::new(&self.table, self.tower, readings);
        let mut information = Information::before(units(STATE, self.lever), free, self.repeats_mm);
        gauge.all_rows(&[0.0; STATE], &[]).into_iter().for_each(|(_, row)| information.add(&[row]));
        information
    }

    fn fitted<'b>(&'b self, readings: &'b [CalliperReading]) -> Option<Fitted<'b>> {
        let determined = self.determined(readings);
        if determined.iter().all(|&i| i >= UNKNOWNS) {
            return None;
        }
        let free = self.independent(readings, &determined);
        let jaws = Gauge::new(&self.table, self.tower, readings);
        let squares = |state: &[f64]| jaws.all_rows(state, &[]).iter().map(|(_, row)| row.off * row.off).sum::<f64>();
        let leaning = |sign: f64| {
            let gauge = Gauge::new(&self.table, self.tower, readings).leaning(sign);
            let solved = solve(&gauge, vec![0.0; STATE], &free, &[], self.lever);
            solved.settled.then(|| (squares(&solved.state), gauge, solved.state))
        };
        let both = [1.0, -1.0].into_iter().filter_map(leaning);
        let (_, gauge, state) = both.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let linear = Linear::of(&gauge, &state, &free, &[], self.lever)?;
        Some(Fitted { gauge, free, determined, state, linear })
    }

    /// Which reading makes them disagree, as what to do.
    fn remedy(&self, readings: &[CalliperReading]) -> String {
        let numbers: Vec<usize> = self.tower.dimensions.iter().map(|one| one.number).collect();
        let pairs = numbers.iter().flat_map(|&i| numbers.iter().filter(move |&&j| j > i).map(move |&j| [i, j]));
        let exchanged = pairs.filter_map(|pair| {
            let fitted = self.fitted_rms(&exchanged(readings, pair))?;
            Some((fitted, pair))
        });
        if let Some((_, [i, j])) = exchanged.min_by(|a, b| a.0.total_cmp(&b.0)) {
            return seem_exchanged([i, j]);
        }
        let without = |&number: &usize| {
            let rest: Vec<CalliperReading> = readings.iter().copied().filter(|r| r.number != number).collect();
            Some((self.fitted_rms(&rest)?, number))
        };
        let found: Vec<(f64, usize)> = numbers.iter().filter_map(without).collect();
        let least = found.iter().map(|(rms, _)| *rms).fold(f64::MAX, f64::min);
        let same = found.iter().filter(|(rms, _)| *rms <= 1.2 * least).map(|(_, number)| number.to_string());
        let named: Vec<String> = same.collect();
        match named.len() {
            0 => "measure all again, or raise repeats_to_mm if the readings are that rough".to_owned(),
            1 => format!("measure dimension {} again", named[0]),
            _ => format!("measure dimensions {} again", named.join(", ")),
        }
    }

    /// The scatter of readings that agree; `None` for others.
    fn fitted_rms(&self, readings: &[CalliperReading]) -> Option<f64> {
        let near = readings.iter().all(|r| (r.mm - self.of(r).drawn_mm).abs() <= self.of(r).most_mm);
        let fitted = if near { self.fitted(readings)? } else { return None };
        fitted.agrees(self.repeats_mm).then(|| fitted.rms())
    }

    fn of(&self, reading: &CalliperReading) -> &Dimension {
        &self.tower.dimensions[reading.number - 1]
    }

    /// A reading that no tower has, with what it may have been.
    fn far_off(&self, file: &str, readings: &[CalliperReading]) -> Result<(), TowerError> {
        let off = |r: &&CalliperReading| (r.mm - self.of(r).drawn_mm).abs() > self.of(r).most_mm;
        let Some(&CalliperReading { number, line, mm }) = readings.iter().find(off) else { return Ok(()) };
        let one = &self.tower.dimensions[number - 1];
        let other = readings.iter().find(|r| {
            let fits = |mm: f64, one: &Dimension| (mm - one.drawn_mm).abs() <= one.most_mm;
            r.number != number && off(r) && fits(r.mm, one) && fits(mm, self.of(r))
        });
        let remedy = match other {
            Some(other) => seem_exchanged([number, other.number]),
            None => "measure it again; if it is right, measure the axes' places with a ruler first".to_owned(),
        };
        let (drawn, most) = (one.drawn_mm, one.most_mm);
        Err(TowerError::FarOff { file: file.to_owned(), line, number, mm, drawn, most, remedy })
    }

    fn report(&self, fitted: &Fitted<'_>, readings: &[CalliperReading]) -> TowerFit {
        let (freedom, rms_mm) = (fitted.linear.freedom(), fitted.rms());
        let scatter = if freedom < FEW { rms_mm.max(self.repeats_mm) } else { rms_mm };
        let wide = scatter * student_95(freedom);
        let (unit, names) = (units(STATE, self.lever), Unknown::names(&self.table));
        let error = |place: usize, i: usize| wide * fitted.linear.inverse[(place, place)].max(0.0).sqrt() / unit[i];
        let estimate = |(place, &i): (usize, &usize)| {
            let unknown = *Unknown::ALL.get(i).filter(|_| fitted.determined.contains(&i))?;
            let shown = |value: f64| if unknown.is_angle() { value.to_degrees() } else { value };
            let (differs, error) = (shown(fitted.state[i]), shown(error(place, i)));
            Some(Estimate { unknown, name: names[i].clone(), differs, error })
        };
        let estimates: Vec<Estimate> = fitted.free.iter().enumerate().filter_map(estimate).collect();
        let undetermined =
            ASKED.iter().filter(|u| !fitted.determined.contains(&(**u as usize))).map(|u| names[*u as usize].clone());
        let wider = fitted.free.iter().position(|&i| i == WIDER && fitted.determined.contains(&i));
        let mut known = fitted.state.clone();
        (0..UNKNOWNS).filter(|i| !fitted.determined.contains(i)).for_each(|i| known[i] = 0.0);
        let chain = self.as_high_as_before(&fitted.gauge.chain(&known));
        TowerFit {
            table: chain.table(),
            undetermined: undetermined.collect(),
            wider_mm: wider.map(|place| [fitted.state[WIDER], error(place, WIDER)]),
            began_above: self.began_above(&chain),
            deviations: self.deviations(fitted, readings),
            chain,
            estimates,
            rms_mm,
            freedom,
        }
    }

    /// The machine with the middle of its level table as high as the profile has it.
    fn as_high_as_before(&self, chain: &Chain) -> Chain {
        let words = self.tower.words_deg()[0].map(Angle::from_deg);
        let middle = |chain: &Chain| chain.at(words[0], words[1]).point(&Vec3::zeros()).z;
        let higher = middle(chain) - middle(&Chain::new(self.table.clone(), [0.0; UNKNOWNS]));
        let mut by = *chain.by();
        // What the tilt's zero is off by changes this by its square.
        by[Unknown::OffsetZ as usize] -= higher / by[Unknown::TiltZero as usize].cos();
        Chain::new(self.table.clone(), by)
    }

    fn began_above(&self, chain: &Chain) -> Vec<(&'static str, f64)> {
        let nominal = Chain::new(self.table.clone(), [0.0; UNKNOWNS]);
        let words = self.tower.words_deg();
        let printed = |q: &Vec3, step: usize| {
            let [tilt, rotation] = words[step].map(Angle::from_deg);
            chain.at(tilt, rotation).on_table(&nominal.at(tilt, rotation).point(q))
        };
        let of = |block: &super::design::Block| {
            let foot = block.foot();
            let up = block.up();
            (block.name, (printed(&foot, block.step) - printed(&foot, 0)).dot(&up))
        };
        self.tower.blocks.iter().filter(|block| block.step > 0).map(of).collect()
    }

    fn deviations(&self, fitted: &Fitted<'_>, readings: &[CalliperReading]) -> Vec<TowerDeviation> {
        let of = |one: &Dimension| {
            let own: Vec<f64> = readings.iter().filter(|r| r.number == one.number).map(|r| r.mm).collect();
            let mm = own.iter().sum::<f64>() / own.len() as f64;
            let left = fitted.linear.rows.iter().filter(|(number, _)| *number == one.number).map(|(_, row)| row.off);
            let off_mm = left.sum::<f64>() / own.len() as f64;
            (!own.is_empty()).then_some(TowerDeviation { number: one.number, mm, drawn_mm: one.drawn_mm, off_mm })
        };
        self.tower.dimensions.iter().filter_map(of).collect()
    }
}

fn asked() -> impl Iterator<Item = usize> {
    ASKED.into_iter().map(|unknown| unknown as usize).chain([WIDER, HIGHER])
}

fn seem_exchanged([i, j]: [usize; 2]) -> String {
    format!("dimensions {} and {} seem to be exchanged; measure both again", i.min(j), i.max(j))
}

fn exchanged(readings: &[CalliperReading], [i, j]: [usize; 2]) -> Vec<CalliperReading> {
    let other = |number: usize| match number {
        _ if number == i => j,
        _ if number == j => i,
        same => same,
    };
    readings.iter().map(|r| CalliperReading { number: other(r.number), ..*r }).collect()
}

/// The machine of a tower's readings, beginning with what `profile` says, under the name by which it was given; `file` is for the messages.
///
/// # Errors
///
/// [`TowerError::OtherMachine`], [`TowerError::FarOff`], [`TowerError::Contradiction`], [`TowerError::Unlevel`] and [`TowerError::Untold`].
pub fn fit_tower(profile: &Profile, name: &str, file: &str, measured: &Readings) -> Result<TowerFit, TowerError> {
    let tower = measured.tower(file, profile, name)?;
    let repeats_mm = measured.repeats_mm;
    let job = Job { table: profile.kinematics(), tower: &tower, repeats_mm, lever: poses::lever(profile) };
    job.far_off(file, &measured.readings)?;
    let untold = || TowerError::Untold { file: file.to_owned(), left_out: measured.left_out.clone() };
    let fitted = job.fitted(&measured.readings).ok_or_else(untold)?;
    if !fitted.agrees(repeats_mm) {
        let (rms_mm, remedy) = (fitted.rms(), job.remedy(&measured.readings));
        return Err(TowerError::Contradiction { file: file.to_owned(), rms_mm, repeats_mm, remedy });
    }
    let deg = fitted.state[Unknown::TiltZero as usize].to_degrees();
    if deg.abs() > UNLEVEL_DEG {
        return Err(TowerError::Unlevel { file: file.to_owned(), deg: deg.abs(), most: UNLEVEL_DEG });
    }
    Ok(job.report(&fitted, &measured.readings))
}

/// How well a tower will tell each figure: name, standard error (mm or degrees) and whether it is an angle, where every dimension is read
/// twice; `None` for what it does not determine.
pub fn tower_errors(profile: &Profile, tower: &Tower, repeats_mm: f64) -> Vec<(String, Option<f64>, bool)> {
    let job = Job { table: profile.kinematics(), tower, repeats_mm, lever: poses::lever(profile) };
    let twice = (0..2 * Tower::DIMENSIONS).map(|i| CalliperReading { number: 1 + i / 2, line: 0, mm: 0.0 });
    let readings: Vec<CalliperReading> = twice.collect();
    let (information, free) = (job.information(&readings, &asked().collect::<Vec<_>>()), job.determined(&readings));
    let names = Unknown::names(&job.table);
    let of = |unknown: Unknown| {
        let (i, angle) = (unknown as usize, unknown.is_angle());
        let error = information.error(i);
        let error = if angle { error.to_degrees() } else { error };
        (names[i].clone(), free.contains(&i).then_some(error), angle)
    };
    ASKED.map(of).to_vec()
}
