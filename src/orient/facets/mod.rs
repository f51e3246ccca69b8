//! What the objectives know of a part, and what is worked out of that once: normals, sums, trees, who sees whom.

mod lowest;
mod mass;
mod moments;
mod sets;
mod sums;
mod tree;

use std::sync::OnceLock;

use lowest::Lowest;
pub use mass::Mass;
pub(super) use moments::Moments;
pub(super) use sets::Sets;
pub(super) use sums::chunked;
pub(super) use tree::Tree;

use crate::geom::{Bounds, Vec3};
use crate::mesh::TriangleMesh;

/// One facet, for the objectives that cannot sum facets up by their normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Outward, as long as the facet's area, mm².
    pub area: Vec3,
    /// The mean of the three corners, mm.
    pub barycentre: Vec3,
}

/// A part's facets as the objectives need them.
///
/// At most 200 bytes a facet beside the mesh: 48 for the facet, 12 for its corners' numbers, about 44 for its share of
/// the points and their tree, 64 where its normal is its own, and 28 for a moment while normals are sorted. `certified` keeps
/// 4 on each cell of its heap for facets that are not settled there (`staircase`, `support-area`, `support-volume-convex`).
/// Measured by the peak of a run less that of reading the mesh: 20 to 110. What the objectives with supports on the part
/// ask for comes on top: 100 for a tree of the facets, 12 for each facet that it sees.
#[derive(Clone, Debug)]
pub struct Facets {
    /// The facets one by one, in the mesh's order; those without area are left out.
    pub each: Vec<Facet>,
    /// The corner points, mm, in the mesh's frame.
    pub points: Vec<Vec3>,
    /// The numbers of each facet's corners; empty where facets are known by normal and area alone.
    pub(crate) corners: Vec<[u32; 3]>,
    normals: OnceLock<Normals>,
    lowest: OnceLock<Lowest>,
    sums: OnceLock<Moments>,
    tree: OnceLock<Tree>,
    sets: OnceLock<Sets>,
    mass: OnceLock<Mass>,
}

/// The facets of one normal summed up, in the order of the normals.
#[derive(Clone, Debug, Default)]
pub struct Normals {
    /// Outward unit normals, distinct to the bit.
    pub units: Vec<Vec3>,
    /// The area with each normal, mm².
    pub areas: Vec<f64>,
    /// How many facets share each normal.
    pub counts: Vec<f64>,
    /// Area times barycentre, summed over the facets of each normal, mm³.
    pub moments: Vec<Vec3>,
}

/// `|d.n|` from here on is a facet parallel to the layers: no staircase, no support. 1 - cos(0.1 degree).
pub(super) const FLAT: f64 = 1.0 - 1.5e-6;
/// Normals nearer than this (radians) are one: a few ulp of a normal computed from f32 corners.
const SAME_NORMAL: f64 = 1e-9;

impl Facets {
    /// Gathers `mesh`; facets without area are left out, so a mesh of nothing else gives none.
    pub fn of<F>(mesh: &TriangleMesh<F>) -> Self {
        let (vertices, all) = (mesh.vertices(), mesh.facets());
        let (mut each, mut corners) = (Vec::with_capacity(all.len()), Vec::with_capacity(all.len()));
        for facet in all {
            let [a, b, c] = facet.map(|i| vertices[i as usize]);
            let area = (b - a).cross(&(c - a)) * 0.5;
            if area.norm_squared() > 0.0 {
                each.push(Facet { area, barycentre: (a + b + c) / 3.0 });
                corners.push(*facet);
            }
        }
        Self::gathered(each, corners, vertices.to_vec())
    }

    /// Facets known by normal and area alone, all at the origin, with the corner `points`: enough for the objectives
    /// without a height above the bed.
    ///
    /// # Panics
    ///
    /// Panics where `normals` and `areas` are not of one length.
    pub fn with(normals: Vec<Vec3>, areas: Vec<f64>, points: Vec<Vec3>) -> Self {
        assert_eq!(normals.len(), areas.len(), "one area for each normal");
        let facet = |(n, area): (&Vec3, &f64)| Facet { area: n * *area, barycentre: Vec3::zeros() };
        Self::made(normals.iter().zip(&areas).map(facet).collect(), points)
    }

    fn made(each: Vec<Facet>, points: Vec<Vec3>) -> Self {
        let (normals, lowest, sums) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        let (corners, tree, sets, mass) = (Vec::new(), OnceLock::new(), OnceLock::new(), OnceLock::new());
        Self { each, points, corners, normals, lowest, sums, tree, sets, mass }
    }

    /// Facets with the numbers of their corners among `points`.
    pub(super) fn gathered(each: Vec<Facet>, corners: Vec<[u32; 3]>, points: Vec<Vec3>) -> Self {
        Self { corners, ..Self::made(each, points) }
    }

    /// The facets summed up by their normal; worked out when first asked for.
    pub fn normals(&self) -> &Normals {
        self.normals.get_or_init(|| Normals::of(&self.each))
    }

    /// The corner point lowest along `up`, mm; the origin where there are no points.
    ///
    /// Exact: every point is looked at, or lies in a box that is proved higher.
    pub fn lowest(&self, up: &Vec3) -> Vec3 {
        self.lowest.get_or_init(|| Lowest::of(&self.points)).along(up)
    }

    /// The sums over all facets that `weighted-normal-z` is made of.
    pub(super) fn sums(&self) -> &Moments {
        self.sums.get_or_init(|| Moments::of(self))
    }

    /// Volume, surface and centre of mass.
    pub fn mass(&self) -> &Mass {
        self.mass.get_or_init(|| Mass::of(self))
    }

    /// The facets in a tree, for rays.
    pub(super) fn tree(&self) -> &Tree {
        self.tree.get_or_init(|| Tree::of(self))
    }

    /// Which facets see each other.
    pub(super) fn sets(&self) -> &Sets {
        self.sets.get_or_init(|| Sets::of(self))
    }

    /// The radius of a ball about [`middle`](Self::middle) that holds all points, mm.
    pub(crate) fn reach(&self) -> f64 {
        let centre = self.middle();
        self.points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max)
    }

    /// From the lowest to the highest point along `up`; 0 for no points.
    pub(super) fn extent(&self, up: &Vec3) -> f64 {
        (self.lowest(&-up) - self.lowest(up)).dot(up)
    }

    /// The middle of the corner points' box, mm; the origin for no points.
    pub(super) fn middle(&self) -> Vec3 {
        let bounds = Bounds::of(self.points.iter().copied());
        if bounds.is_empty() { Vec3::zeros() } else { bounds.centre() }
    }

    /// The sum of `term` over all facets, in one order whatever the number of threads.
    pub(crate) fn sum<T: std::iter::Sum<T> + Send>(&self, term: impl Fn(&Facet) -> T + Sync) -> T {
        chunked(self.each.len(), |range| self.each[range].iter().map(&term).sum())
    }
}

impl Normals {
    fn of(each: &[Facet]) -> Self {
        let mut all = Self::default();
        let units: Vec<Vec3> = each.iter().map(|f| f.area.normalize()).collect();
        let mut order: Vec<u32> = (0..each.len() as u32).collect();
        let by_normal = |a: &u32, b: &u32| {
            let (m, n) = (&units[*a as usize], &units[*b as usize]);
            m.x.total_cmp(&n.x).then(m.y.total_cmp(&n.y)).then(m.z.total_cmp(&n.z)).then(a.cmp(b))
        };
        order.sort_unstable_by(by_normal);
        let mut last: Option<&Vec3> = None;
        let distinct = order.iter().filter(|&&i| {
            let unit = &units[i as usize];
            let new = last.is_none_or(|known| !same(known, unit));
            last = if new { Some(unit) } else { last };
            new
        });
        all.reserve(distinct.count());
        for i in order {
            let facet = &each[i as usize];
            all.add(units[i as usize], facet.area.norm(), facet.barycentre);
        }
        all
    }

    /// Makes room for so many normals and no more.
    fn reserve(&mut self, count: usize) {
        self.units.reserve_exact(count);
        self.areas.reserve_exact(count);
        self.counts.reserve_exact(count);
        self.moments.reserve_exact(count);
    }

    /// Counts a facet in with its normal; normals come sorted.
    fn add(&mut self, normal: Vec3, area: f64, barycentre: Vec3) {
        let last = self.units.len().wrapping_sub(1);
        if self.units.last().is_some_and(|known| same(known, &normal)) {
            self.areas[last] += area;
            self.counts[last] += 1.0;
            self.moments[last] += barycentre * area;
        } else {
            self.units.push(normal);
            self.areas.push(area);
            self.counts.push(1.0);
            self.moments.push(barycentre * area);
        }
    }

    /// The sum of `term(normal, area, index)` over all normals, in one order whatever the number of threads.
    pub(crate) fn sum<T: std::iter::Sum<T> + Send>(&self, term: impl Fn(&Vec3, f64, usize) -> T + Sync) -> T {
        chunked(self.units.len(), |range| {
            let from = range.start;
            let both = self.units[range.clone()].iter().zip(&self.areas[range]);
            both.enumerate().map(|(i, (n, area))| term(n, *area, from + i)).sum()
        })
    }

    /// The indices of the normals, largest area first.
    pub(super) fn by_area(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.units.len()).collect();
        order.sort_by(|&a, &b| self.areas[b].total_cmp(&self.areas[a]).then(a.cmp(&b)));
        order
    }
}

fn same(a: &Vec3, b: &Vec3) -> bool {
    (a - b).norm_squared() < SAME_NORMAL * SAME_NORMAL
}

/// `vector` without its part along the unit direction `up`.
pub(super) fn tangential(vector: Vec3, up: &Vec3) -> Vec3 {
    vector - up * vector.dot(up)
}
