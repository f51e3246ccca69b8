//! Cracks: corners of facets that were one and are a little apart, as programs write them that round each facet by itself.

use std::collections::{BTreeSet, HashMap};

use super::{Surface, open_edges, sides};
use crate::geom::{Bounds, Vec3};

/// How the tolerance rises from one try to the next.
const RISE: f64 = 2.0;
/// Corners are joined only where they are nearer than this share of the shortest side of a facet at either, so that nothing that was drawn is lost.
const SHARE: f64 = 0.25;
/// What was joined has another middle, and may be near to more: so often it is looked once more with the same tolerance.
const AGAIN: usize = 4;
/// Of a cell with more corners that could not be joined nothing is joined: what is drawn so densely is no crack, and each would be compared with all.
const CROWD: usize = 64;

/// What was joined.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joined {
    /// Corners that were moved.
    pub(super) corners: usize,
    /// By how much at most, file units.
    pub(super) distance: f64,
    /// Where that one is.
    pub(super) at: Vec3,
    /// Sides that were parted at corners near them.
    pub(super) parted: usize,
    /// Open sides that are left.
    pub(super) left: usize,
}

/// Joins corners on open sides with a tolerance that rises from `from` to `most`, file units, until the surface is closed; where it never is, the try
/// that leaves the fewest open sides counts. `None`, and nothing is changed, where none leaves fewer than there were, or where volume or area change by more
/// than the distances explain. The corners' means are appended to `vertices`.
pub(super) fn join(vertices: &mut Vec<Vec3>, surface: &mut Surface, from: f64, most: f64) -> Option<Joined> {
    let open = open_edges(vertices, &surface.facets);
    if open.is_empty() || from.is_nan() || from >= most {
        return None;
    }
    let before = Size::of(vertices, &surface.facets);
    let given = vertices.len();
    let mut clusters = Clusters::of(vertices, &surface.facets, &open);
    let (mut left, mut best, mut within) = (open.len(), None, from);
    while within < most && left > 0 {
        within = (within * RISE).min(most);
        let mut any = false;
        for _ in 0..AGAIN {
            let more = clusters.join(within, most);
            any |= more;
            if !more {
                break;
            }
        }
        if !any && within < most {
            continue;
        }
        vertices.truncate(given);
        let Some((mut joined, mut tried)) = clusters.apply(vertices, surface) else { break };
        joined.parted = sides::part_sides(vertices, &mut tried, within);
        let after = Size::of(vertices, &tried.facets);
        let now = open_edges(vertices, &tried.facets).len();
        if now < left && before.agrees(&after, joined.distance + if joined.parted > 0 { within } else { 0.0 }) {
            (left, joined.left) = (now, now);
            best = Some((joined, tried, vertices.split_off(given)));
        }
    }
    vertices.truncate(given);
    let (joined, tried, means) = best?;
    vertices.extend(means);
    *surface = tried;
    Some(joined)
}

/// What a surface measures, open or not.
struct Size {
    /// Of the cones from the middle of its box to its facets, file units cubed.
    volume: f64,
    area: f64,
    /// All sides of all facets.
    sides: f64,
    /// Rounding of the volume.
    noise: f64,
}

impl Size {
    fn of(vertices: &[Vec3], facets: &[[u32; 3]]) -> Self {
        let bounds = Bounds::of(facets.iter().flatten().map(|&index| vertices[index as usize]));
        let origin = bounds.centre();
        let mut size = Self { volume: 0.0, area: 0.0, sides: 0.0, noise: 1e-9 * bounds.size().norm().powi(3) };
        for facet in facets {
            let [a, b, c] = facet.map(|index| vertices[index as usize] - origin);
            size.volume += a.dot(&b.cross(&c)) / 6.0;
            size.area += 0.5 * (b - a).cross(&(c - a)).norm();
            size.sides += (b - a).norm() + (c - b).norm() + (a - c).norm();
        }
        size
    }

    /// Whether corners that were moved by `distance` explain what is different.
    fn agrees(&self, after: &Self, distance: f64) -> bool {
        let shell = (self.area + self.sides * distance) * distance;
        (self.volume - after.volume).abs() <= shell + self.noise
            && (self.area - after.area).abs() <= self.sides.max(after.sides) * distance + self.noise
    }
}

/// Corners on open sides, gathered step by step.
struct Clusters {
    /// The vertices, ascending, and the cluster of each.
    corners: Vec<(u32, u32)>,
    all: Vec<Cluster>,
    /// Pairs that were looked at.
    looked: u64,
}

#[derive(Clone, Copy)]
struct Cluster {
    /// Where the means of what it is made of are, on the mean.
    mean: Vec3,
    count: f64,
    /// The box around its corners.
    bounds: Bounds,
    /// The shortest side of a facet at one of its corners.
    side: f64,
    /// The cluster that it has become part of, or itself.
    home: u32,
}

impl Cluster {
    /// How far a corner of both may be from the mean of both.
    fn joined_reach(&self, other: &Self) -> f64 {
        let mean = (self.mean * self.count + other.mean * other.count) / (self.count + other.count);
        let bounds = self.bounds.union(&other.bounds);
        (mean - bounds.min).abs().sup(&(bounds.max - mean).abs()).norm()
    }
}

impl Clusters {
    fn of(vertices: &[Vec3], facets: &[[u32; 3]], open: &[[u32; 2]]) -> Self {
        let border: BTreeSet<u32> = open.iter().flatten().copied().collect();
        let corners: Vec<(u32, u32)> = border.into_iter().zip(0..).collect();
        let mut sides = vec![f64::INFINITY; corners.len()];
        for facet in facets {
            let at = facet.map(|index| vertices[index as usize]);
            let least = (0..3).map(|k| (at[k] - at[(k + 1) % 3]).norm()).fold(f64::INFINITY, f64::min);
            for index in facet {
                if let Ok(place) = corners.binary_search_by_key(index, |one| one.0) {
                    sides[place] = sides[place].min(least);
                }
            }
        }
        let cluster = |(&(index, home), side): (&(u32, u32), f64)| Cluster {
            mean: vertices[index as usize],
            count: 1.0,
            bounds: Bounds::of([vertices[index as usize]]),
            side,
            home,
        };
        let all = corners.iter().zip(sides).map(cluster).collect();
        Self { corners, all, looked: 0 }
    }

    /// Joins clusters whose means are no more than `within` apart, each with the nearest of those before it; whether there were any.
    fn join(&mut self, within: f64, most: f64) -> bool {
        let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        let mut sums: HashMap<u32, (Vec3, f64)> = HashMap::new();
        for own in 0..self.all.len() as u32 {
            let one = self.all[own as usize];
            if one.home != own {
                continue;
            }
            let cell = [0, 1, 2].map(|axis| (one.mean[axis] / within).floor() as i64);
            let beside = |n: i64| [n % 3, n / 3 % 3, n / 9].map(|step| step - 1);
            let near = (0..27).filter_map(|n| {
                let step = beside(n);
                cells.get(&[0, 1, 2].map(|axis| cell[axis].saturating_add(step[axis])))
            });
            let mut nearest: Option<(f64, u32)> = None;
            for &other in near.filter(|leaders| leaders.len() <= CROWD).flatten() {
                self.looked += 1;
                let to = &self.all[other as usize];
                let apart = (to.mean - one.mean).norm();
                let limit = within.min(SHARE * one.side.min(to.side));
                if apart <= limit && one.joined_reach(to) <= most && nearest.is_none_or(|(best, _)| apart < best) {
                    nearest = Some((apart, other));
                }
            }
            let Some((_, other)) = nearest else {
                let leaders = cells.entry(cell).or_default();
                if leaders.len() <= CROWD {
                    leaders.push(own);
                }
                continue;
            };
            self.all[own as usize].home = other;
            let to = &mut self.all[other as usize];
            to.bounds = to.bounds.union(&one.bounds);
            to.side = to.side.min(one.side);
            let sum = sums.entry(other).or_insert((to.mean * to.count, to.count));
            *sum = (sum.0 + one.mean * one.count, sum.1 + one.count);
        }
        for (cluster, (sum, count)) in &sums {
            let to = &mut self.all[*cluster as usize];
            (to.mean, to.count) = (sum / *count, *count);
        }
        // Homes are one step away: leaders have not been joined themselves at this step, but what joined earlier has their number.
        for (_, home) in &mut self.corners {
            *home = self.all[*home as usize].home;
        }
        !sums.is_empty()
    }

    /// The surface with its corners where their clusters' means are, which are appended to `vertices`; `None` where two corners of a facet would be one.
    fn apply(&self, vertices: &mut Vec<Vec3>, surface: &Surface) -> Option<(Joined, Surface)> {
        let mut joined = Joined { corners: 0, distance: 0.0, at: Vec3::zeros(), parted: 0, left: 0 };
        let mut numbers = vec![u32::MAX; self.all.len()];
        let mut to = HashMap::new();
        for &(index, home) in self.corners.iter().filter(|one| self.all[one.1 as usize].count > 1.0) {
            let (number, mean) = (&mut numbers[home as usize], self.all[home as usize].mean);
            if *number == u32::MAX {
                *number = vertices.len() as u32;
                vertices.push(mean);
            }
            to.insert(index, *number);
            joined.corners += 1;
            let distance = (vertices[index as usize] - mean).norm();
            if distance > joined.distance {
                (joined.distance, joined.at) = (distance, mean);
            }
        }
        let mut tried = surface.clone();
        for facet in &mut tried.facets {
            *facet = facet.map(|index| to.get(&index).copied().unwrap_or(index));
        }
        let is_whole = |&[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        tried.facets.iter().all(is_whole).then_some((joined, tried))
    }
}

#[cfg(test)]
mod tests {
    use super::{Surface, join, open_edges};
    use crate::geom::{SplitMix64, Vec3};
    use crate::mesh::tests::shapes;

    /// A ball of radius 20 of which no facet shares a corner with another, each corner off by up to `off` along each axis.
    fn strewn(off: f64, seed: u64) -> (Vec<Vec3>, Surface, f64) {
        let ball = shapes::ball(12, |_| 0.0);
        let mut random = SplitMix64::seeded(seed);
        let mut vertices = Vec::new();
        for facet in 0..ball.facets().len() {
            vertices.extend(ball.corners(facet).map(|p| p + Vec3::from_fn(|_, _| (2.0 * random.unit() - 1.0) * off)));
        }
        let count = vertices.len() as u32 / 3;
        let facets = (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        (vertices, Surface { facets, source: (0..count).collect() }, ball.volume())
    }

    #[test]
    fn corners_a_little_apart_are_one_again_and_no_further() {
        for (off, closes) in [(1e-4, true), (1e-3, true), (5e-3, true), (0.012, true), (0.1, false), (0.5, false)] {
            let (mut vertices, mut surface, volume) = strewn(off, 3);
            let given = surface.facets.len();
            let joined = join(&mut vertices, &mut surface, 1e-5, 0.04);
            assert_eq!(open_edges(&vertices, &surface.facets).is_empty(), closes, "{off}: {joined:?}");
            if closes {
                let joined = joined.unwrap();
                assert!(
                    joined.distance <= 2.0 * 3_f64.sqrt() * off && joined.distance > 0.5 * off,
                    "{off}: {joined:?}"
                );
                assert_eq!((joined.corners, surface.facets.len()), (3 * given, given));
                let now = super::Size::of(&vertices, &surface.facets).volume;
                assert!((now - volume).abs() < 1e-3 * volume, "{off}: {now} for {volume}");
            }
        }
    }

    #[test]
    fn what_is_finer_than_the_crack_is_left_alone() {
        // The same ball, a thousandth as large: its sides are no longer than the tolerance.
        let (mut vertices, mut surface, _) = strewn(5.0, 3);
        vertices.iter_mut().for_each(|p| *p *= 1e-3);
        let given = surface.facets.clone();
        let joined = join(&mut vertices, &mut surface, 1e-6, 0.04);
        assert!(joined.is_none_or(|joined| joined.distance < 3e-3), "{joined:?}");
        assert!(!open_edges(&vertices, &surface.facets).is_empty());
        assert_eq!(surface.facets.len(), given.len());
    }

    #[test]
    fn the_cost_of_a_crowd_is_bounded() {
        // Ten thousand facets, all smaller than the tolerance.
        let mut random = SplitMix64::seeded(9);
        let vertices: Vec<Vec3> = (0..30_000).map(|_| Vec3::from_fn(|_, _| random.unit() * 0.03)).collect();
        let facets: Vec<[u32; 3]> = (0..10_000).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let mut clusters = super::Clusters::of(&vertices, &facets, &open_edges(&vertices, &facets));
        clusters.join(0.04, 0.04);
        assert!(clusters.looked < 30_000 * 27, "{} pairs", clusters.looked);
    }
}
