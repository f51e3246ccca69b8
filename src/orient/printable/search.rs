//! The recommended pose, what stands against it, and what is proved.

use rayon::prelude::*;

use super::super::Facets;
use super::candidates::{Candidates, candidates};
use super::coarse::coarse;
use super::price::Priced;
use super::process::{MINUTES_PER_GRAM, Process};
use super::resting::flats;
use super::{FINE, columns};
use crate::geom::Vec3;

/// What is told of a part's poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Recommendation {
    /// The pose that is recommended.
    pub recommended: Priced,
    /// What is best in another way.
    pub runners: Vec<Runner>,
    /// The part as it lies in its file.
    pub as_it_lies: Priced,
    /// The user's own pose.
    pub own: Option<Priced>,
    /// All poses that were measured finely, the recommended first, then by price.
    pub poses: Vec<Priced>,
    /// No pose has a lower price, proved, min: the part itself at the least height, without supports, steps and risk.
    pub at_least_min: f64,
    /// How many poses were priced.
    pub evaluations: usize,
}

/// A pose that is best by one figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Runner {
    /// By which.
    pub role: PoseRole,
    /// The pose.
    pub pose: Priced,
}

/// Figures by which a pose may be best.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoseRole {
    /// The least volume of support columns.
    LeastSupport,
    /// The largest footprint.
    Flattest,
    /// The least height.
    Lowest,
    /// The least steps on slopes.
    BestSurface,
}

impl Recommendation {
    /// Keeps the poses with a footprint of at least `least_mm2`, and recommends the best of them; whether there is one.
    pub fn keep_standing_on(&mut self, least_mm2: f64) -> bool {
        self.poses.retain(|p| p.footprint_mm2 >= least_mm2);
        self.runners.retain(|r| r.pose.footprint_mm2 >= least_mm2);
        if self.poses.is_empty() {
            return false;
        }
        self.recommended = best(&self.poses);
        first(&mut self.poses, self.recommended);
        true
    }
}

/// Puts the recommended pose before the others.
fn first(poses: &mut Vec<Priced>, best: Priced) {
    poses.retain(|p| p.up != best.up);
    poses.insert(0, best);
}

impl PoseRole {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::LeastSupport, Self::Flattest, Self::Lowest, Self::BestSurface];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::LeastSupport => "least support",
            Self::Flattest => "flattest",
            Self::Lowest => "lowest",
            Self::BestSurface => "best surface",
        }
    }

    fn figure(self, pose: &Priced) -> f64 {
        match self {
            Self::LeastSupport => pose.support_mm3,
            Self::Flattest => -pose.footprint_mm2,
            Self::Lowest => pose.height_mm,
            Self::BestSurface => pose.stepped_mm2,
        }
    }

    /// Differences up to this are none: a thousandth of the part's volume or 1 mm³ of support, a hundredth of any other figure.
    fn tie(self, best: f64, volume_mm3: f64) -> f64 {
        match self {
            Self::LeastSupport => (1e-3 * volume_mm3).min(1.0),
            _ => 1e-2 * best.abs(),
        }
    }
}

/// Prices nearer than this are one, relative: what columns of a 500th of the part lose and gain along outlines is less.
const TIE: f64 = 2e-3;
/// Of the candidates so many are measured finely.
const MEASURED: usize = 12;
/// With the best by each figure, the part as it lies and the user's own pose at most so many.
const MEASURED_MOST: usize = 2 * MEASURED + 2 * PoseRole::ALL.len() + 2;
/// Poses nearer than this (radians, two degrees) are one; the part's own planes come before what lies beside them.
const SAME_POSE: f64 = 0.035;

/// The pose that a person would choose, its runners-up, and the price of `own`, a unit direction in the mesh's frame.
///
/// At most `budget` poses are priced, where one is given (at least 100; what is measured finely counts once more).
///
/// Deterministic, whatever the number of threads. A part without facets has no pose worth more than another: +Z.
pub fn recommend(facets: &Facets, process: &Process, own: Option<Vec3>, budget: Option<usize>) -> Recommendation {
    let rough = coarse(facets);
    let mut also = vec![Vec3::z()];
    also.extend(own);
    let found = candidates(
        facets,
        rough.as_ref().unwrap_or(facets),
        process,
        &also,
        budget.map_or(usize::MAX, |n| n.saturating_sub(MEASURED_MOST)),
    );
    let fine = |up: &Vec3| process.price(facets, facets.mass(), up, columns(facets, FINE));
    let measured: Vec<Priced> = chosen(&found, facets).par_iter().map(fine).collect();
    let mut poses = distinct(measured, found.exact.iter().map(|p| p.up).collect());
    let leaning = best(&poses);
    let best = leveled(leaning, facets, fine);
    if best.up != leaning.up {
        poses.retain(|p| p.up != leaning.up);
    }
    first(&mut poses, best);
    let runners = PoseRole::ALL.into_iter().map(|role| Runner { role, pose: runner(role, &poses, facets) }).collect();
    let least = found.height.lower_bound.unwrap_or(0.0).max(0.0);
    let part = process.solid(facets.mass().volume_mm3, facets.mass().area_mm2);
    Recommendation {
        recommended: best,
        runners,
        as_it_lies: fine(&Vec3::z()),
        own: own.map(|up| fine(&up)),
        at_least_min: part.minutes + MINUTES_PER_GRAM * part.grams + process.layers(least),
        evaluations: found.evaluations + poses.len(),
        poses,
    }
}

/// The poses to measure finely: the cheapest, and the best by each figure.
fn chosen(found: &Candidates, facets: &Facets) -> Vec<Vec3> {
    let mut order: Vec<&Priced> = found.exact.iter().chain(&found.free).collect();
    order.sort_by(|a, b| a.price_min.total_cmp(&b.price_min));
    let mut ups: Vec<Vec3> = Vec::new();
    let mut take = |up: Vec3| {
        if !ups.contains(&up) {
            ups.push(up);
        }
    };
    order.iter().take(MEASURED).for_each(|p| take(p.up));
    found.exact.iter().take(MEASURED).for_each(|p| take(p.up));
    let all: Vec<Priced> = order.into_iter().copied().collect();
    for role in PoseRole::ALL {
        take(runner(role, &all, facets).up);
        let least = all.iter().min_by(|a, b| role.figure(a).total_cmp(&role.figure(b)));
        least.into_iter().for_each(|p| take(p.up));
    }
    ups
}

/// The best of `poses` by a figure; of those that tie the cheapest.
fn runner(role: PoseRole, poses: &[Priced], facets: &Facets) -> Priced {
    let best = poses.iter().map(|p| role.figure(p)).fold(f64::INFINITY, f64::min);
    let most = best + role.tie(best, facets.mass().volume_mm3);
    let tied = poses.iter().filter(|p| role.figure(p) <= most);
    *tied.min_by(|a, b| a.price_min.total_cmp(&b.price_min)).unwrap_or(&poses[0])
}

/// By price, without what lies beside a better pose; a pose of the part's own planes counts as better than one beside it up to a tie.
fn distinct(mut poses: Vec<Priced>, exact: Vec<Vec3>) -> Vec<Priced> {
    let worth = |p: &Priced| if exact.contains(&p.up) { p.price_min - TIE * p.price_min } else { p.price_min };
    poses.sort_by(|a, b| worth(a).total_cmp(&worth(b)));
    let mut kept: Vec<Priced> = Vec::new();
    for pose in poses {
        if kept.iter().all(|k| (k.up - pose.up).norm() > SAME_POSE) {
            kept.push(pose);
        }
    }
    kept.sort_by(|a, b| a.price_min.total_cmp(&b.price_min));
    kept
}

/// A pose that leans by no more than this from a level one, as a cosine (3 degrees), is meant to be that one ..
const LEVEL_COSINE: f64 = 0.9986;
/// .. where it costs no more than this beside, relative.
const LEVEL: f64 = 0.03;
/// So much more support is none, mm³.
const MORE_MM3: f64 = 1.0;
/// The share of the surface that is a face by which people see what is level.
const FACE: f64 = 0.02;

/// Normals nearer than this, as a cosine (0.08 degrees), are of one face.
const FACE_COSINE: f64 = 0.999_999;
/// So many of the largest faces are asked.
const FACES: usize = 6;

/// A pose that leans by less than this from an axis of the file, as a cosine (0.2 degrees), is that one.
const DRAWN_COSINE: f64 = 0.999_993_9;

fn is_axis(up: &Vec3) -> bool {
    up.iter().filter(|v| **v != 0.0).count() == 1
}

/// `best`, or the level pose beside it: with an axis of the file or a large flat face of the part upright, and no more support. A face that is a
/// little crowned leans what rests on it, and nobody wants its axis to lean with it.
fn leveled(best: Priced, facets: &Facets, fine: impl Fn(&Vec3) -> Priced) -> Priced {
    let area = |up: &Vec3| -> f64 {
        let of = facets.each.iter().map(|facet| (facet.area, facet.area.norm()));
        of.filter(|(area, size)| area.dot(up).abs() >= FACE_COSINE * size).map(|(_, size)| size).sum()
    };
    let whole: f64 = facets.each.iter().map(|facet| facet.area.norm()).sum();
    let axes = (0..3).flat_map(|k| [Vec3::ith(k, 1.0), -Vec3::ith(k, 1.0)]);
    let faces = flats(facets, FACES).into_iter().filter(|up| area(up) >= FACE * whole);
    let near = axes.chain(faces).filter(|up| up.dot(&best.up) >= LEVEL_COSINE);
    let cheap = |p: &Priced| p.price_min <= best.price_min * (1.0 + LEVEL) && (p.stands || !best.stands);
    let level: Vec<Priced> = near.map(|up| fine(&up)).filter(cheap).collect();
    // What leans from an axis of the file by less than a mesh is exact to is drawn upright; columns gain and lose support by that little.
    let drawn = |p: &&Priced| is_axis(&p.up) && p.up.dot(&best.up) >= DRAWN_COSINE;
    if let Some(drawn) = level.iter().find(drawn) {
        return *drawn;
    }
    let level = level.into_iter().filter(|p| p.support_mm3 <= best.support_mm3 + MORE_MM3);
    level.min_by(|a, b| a.price_min.total_cmp(&b.price_min)).unwrap_or(best)
}

/// A pose that stands by itself may cost so much more than one that does not, relative ..
const STANDING: f64 = 0.03;
/// .. or so much, where it needs no more support than that one.
const STANDING_AS_FREE: f64 = 0.07;
/// Support volumes nearer than this are the same, relative.
const SAME_SUPPORT: f64 = 0.01;

/// A pose that tips at less than this, degrees, gives way ..
const UNSTEADY_DEG: f64 = 10.0;
/// .. to one that costs so much more at most, relative, ..
const STEADIER: f64 = 0.03;
/// .. tips no more easily, and lies on so many times as much.
const STEADIER_MM2: f64 = 3.0;

/// The cheapest of those that stand by themselves, unless one that does not is cheaper still. Of those that tie the one that lies on
/// the most, then the lowest, then the one of the best surface, then the one nearest to how the part lies. What tips easily gives way
/// to what costs hardly more and stands much better.
fn best(poses: &[Priced]) -> Priced {
    let cheapest =
        |of: &dyn Fn(&&Priced) -> bool| poses.iter().filter(of).min_by(|a, b| a.price_min.total_cmp(&b.price_min));
    let any = cheapest(&|_| true).unwrap_or(&poses[0]);
    let as_good = |p: &&Priced| {
        let as_free = p.support_mm3 <= any.support_mm3 * (1.0 + SAME_SUPPORT) + MORE_MM3;
        p.stands && p.price_min <= any.price_min * (1.0 + if as_free { STANDING_AS_FREE } else { STANDING })
    };
    let standing = cheapest(&as_good);
    let least = standing.unwrap_or(any).price_min;
    let fits = |p: &&Priced| p.price_min <= least * (1.0 + TIE) && (p.stands || standing.is_none());
    let mut tied: Vec<&Priced> = poses.iter().filter(fits).collect();
    let figures: [fn(&Priced) -> f64; 4] = [|p| -p.footprint_mm2, |p| p.height_mm, |p| p.stepped_mm2, |p| -p.up.z];
    for figure in figures {
        let best = tied.iter().map(|p| figure(p)).fold(f64::INFINITY, f64::min);
        tied.retain(|p| figure(p) <= best + 1e-2 * best.abs());
    }
    let best = *tied[0];
    let steadier = |p: &&Priced| {
        best.tipping_deg < UNSTEADY_DEG
            && p.stands
            && p.price_min <= best.price_min * (1.0 + STEADIER)
            && p.tipping_deg >= best.tipping_deg
            && p.footprint_mm2 >= STEADIER_MM2 * best.footprint_mm2
    };
    cheapest(&steadier).copied().unwrap_or(best)
}
