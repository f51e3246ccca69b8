//! Which other part is nearest to a part: one tree over the facets of all parts, asked once for each part.
//!
//! A node knows what lies below it between seven pairs of parallel planes, so that large facets that stand askew are told apart as
//! well as small ones, and from which to which part its facets are, so that a part's own are passed over together.

use std::cell::Cell;

use super::Part;
use crate::geom::Vec3;
use crate::geom::convex::{separation, support};

/// Facets in one leaf.
const LEAF: usize = 4;
/// Directions of the planes besides the axes, times the square root of 3.
const DIAGONALS: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]];

/// What lies between seven pairs of parallel planes, mm: least and greatest along X, Y, Z and the four diagonals.
#[derive(Clone, Copy)]
struct Slabs([[f64; 2]; 7]);

impl Slabs {
    const EMPTY: Self = Self([[f64::INFINITY, f64::NEG_INFINITY]; 7]);

    fn of(corners: &[Vec3; 3]) -> Self {
        let mut all = Self::EMPTY;
        for corner in corners {
            let along = |d: &[f64; 3]| (corner.x * d[0] + corner.y * d[1] + corner.z * d[2]) / 3f64.sqrt();
            let axes = [corner.x, corner.y, corner.z].into_iter();
            for (slab, at) in all.0.iter_mut().zip(axes.chain(DIAGONALS.iter().map(along))) {
                *slab = [slab[0].min(at), slab[1].max(at)];
            }
        }
        all
    }

    fn union(mut self, other: &Self) -> Self {
        self.0.iter_mut().zip(&other.0).for_each(|(own, other)| *own = [own[0].min(other[0]), own[1].max(other[1])]);
        self
    }

    /// Twice the middle between two of its planes.
    fn middle(&self, pair: usize) -> f64 {
        self.0[pair][0] + self.0[pair][1]
    }

    /// No two points of either are nearer than this, mm.
    fn apart(&self, other: &Self) -> f64 {
        let gap = |pair: usize| {
            let ([a, b], [c, d]) = (self.0[pair], other.0[pair]);
            (c - b).max(a - d).max(0.0)
        };
        let boxes = (gap(0).powi(2) + gap(1).powi(2) + gap(2).powi(2)).sqrt();
        (3..7).map(gap).fold(boxes, f64::max)
    }
}

struct Node {
    slabs: Slabs,
    /// The first and the last part that facets below it are of.
    parts: [u32; 2],
    /// Range of `order` below it.
    facets: [u32; 2],
    /// The second child; the first follows its parent. Zero at a leaf.
    second: u32,
}

/// A facet of a part.
#[derive(Clone, Copy)]
struct Owned {
    part: u32,
    facet: u32,
}

/// All parts of a model, to be asked which is nearest to one of them.
pub struct Neighbours<'a> {
    parts: &'a [Part],
    facets: Vec<(Slabs, Owned)>,
    nodes: Vec<Node>,
    looked_at: Cell<u64>,
}

impl<'a> Neighbours<'a> {
    /// Of `parts`, whose ids are their places; `O(n log n)` in their facets.
    pub fn of(parts: &'a [Part]) -> Self {
        let mut facets = Vec::with_capacity(parts.iter().map(|part| part.mesh.facets().len()).sum());
        for (part, mesh) in parts.iter().map(|part| &part.mesh).enumerate() {
            let owned = |facet: usize| Owned { part: part as u32, facet: facet as u32 };
            facets.extend((0..mesh.facets().len()).map(|facet| (Slabs::of(&mesh.corners(facet)), owned(facet))));
        }
        let count = facets.len();
        let mut all = Self { parts, facets, nodes: Vec::with_capacity(count), looked_at: Cell::new(0) };
        if count > 0 {
            all.split(0, count);
        }
        all
    }

    fn split(&mut self, from: usize, to: usize) {
        let range = &mut self.facets[from..to];
        let (mut slabs, mut parts) = (Slabs::EMPTY, [u32::MAX, 0]);
        for (own, owned) in range.iter() {
            slabs = slabs.union(own);
            parts = [parts[0].min(owned.part), parts[1].max(owned.part)];
        }
        let here = self.nodes.len();
        self.nodes.push(Node { slabs, parts, facets: [from as u32, to as u32], second: 0 });
        if to - from <= LEAF {
            return;
        }
        let spread = |pair: usize| {
            let middles = range.iter().map(|(slabs, _)| slabs.middle(pair));
            let [least, most] = middles.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], m| [a.min(m), b.max(m)]);
            most - least
        };
        let pair = (0..7).map(|pair| (pair, spread(pair))).max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        let pair = pair.map_or(0, |(pair, _)| pair);
        let middle = (to - from) / 2;
        range.select_nth_unstable_by(middle, |(a, one), (b, two)| {
            let order = a.middle(pair).total_cmp(&b.middle(pair));
            order.then((one.part, one.facet).cmp(&(two.part, two.facet)))
        });
        self.split(from, from + middle);
        self.nodes[here].second = self.nodes.len() as u32;
        self.split(from + middle, to);
    }

    /// The part nearest to part `of`, and the least distance of their surfaces, mm (0 where they cross or touch); `None` for a part
    /// alone. Of several that are as near, the first that is found: always the same.
    pub fn nearest(&self, of: usize) -> Option<(usize, f64)> {
        let own = &self.parts[of].mesh;
        let mut best: Option<(usize, f64)> = None;
        for facet in 0..own.facets().len() {
            self.nearer(&own.corners(facet), of as u32, &mut best);
        }
        best
    }

    /// The pairs of parts of which a facet each may be no more than `mm` apart, ascending, the lower id first; never one too few. `None` for more
    /// than `most`, as soon as that is known.
    pub fn within(&self, mm: f64, most: usize) -> Option<Vec<(usize, usize)>> {
        let (mut all, mut later, mut stack) = (Vec::new(), Vec::new(), Vec::new());
        for (part, mesh) in self.parts.iter().map(|part| &part.mesh).enumerate() {
            later.clear();
            for facet in 0..mesh.facets().len() {
                let slabs = Slabs::of(&mesh.corners(facet));
                stack.extend((!self.nodes.is_empty()).then_some(0));
                while let Some(at) = stack.pop() {
                    let node: &Node = &self.nodes[at];
                    self.looked_at.set(self.looked_at.get() + 1);
                    if node.parts[1] as usize <= part || node.slabs.apart(&slabs) > mm {
                        continue;
                    }
                    if node.second > 0 {
                        stack.extend([at + 1, node.second as usize]);
                        continue;
                    }
                    let leaf = &self.facets[node.facets[0] as usize..node.facets[1] as usize];
                    let near =
                        leaf.iter().filter(|(theirs, owned)| owned.part as usize > part && theirs.apart(&slabs) <= mm);
                    later.extend(near.map(|(_, owned)| owned.part as usize));
                }
                later.sort_unstable();
                later.dedup();
                if later.len() > most - all.len() {
                    return None;
                }
            }
            all.extend(later.iter().map(|&other| (part, other)));
        }
        Some(all)
    }

    /// Facets that have been looked at, and nodes: what the answers have cost.
    pub fn looked_at(&self) -> u64 {
        self.looked_at.get()
    }

    /// Whether a facet of another part than `of` is nearer to `corners` than what is the best so far.
    fn nearer(&self, corners: &[Vec3; 3], of: u32, best: &mut Option<(usize, f64)>) {
        let slabs = Slabs::of(corners);
        let mut stack = if self.nodes.is_empty() { vec![] } else { vec![(0, self.nodes[0].slabs.apart(&slabs))] };
        while let Some((at, apart)) = stack.pop() {
            let (node, known) = (&self.nodes[at], best.map_or(f64::INFINITY, |(_, mm)| mm));
            if apart >= known || node.parts == [of, of] {
                continue;
            }
            self.looked_at.set(self.looked_at.get() + 1);
            if node.second > 0 {
                let child = |at: usize| (at, self.nodes[at].slabs.apart(&slabs));
                let [first, second] = [child(at + 1), child(node.second as usize)];
                // The nearer one is on top.
                stack.extend(if first.1 <= second.1 { [second, first] } else { [first, second] });
                continue;
            }
            for (theirs, owned) in &self.facets[node.facets[0] as usize..node.facets[1] as usize] {
                let known = best.map_or(f64::INFINITY, |(_, mm)| mm);
                if owned.part == of || theirs.apart(&slabs) >= known {
                    continue;
                }
                self.looked_at.set(self.looked_at.get() + 1);
                let other = self.parts[owned.part as usize].mesh.corners(owned.facet as usize);
                let apart = separation(|along| support(corners, along) - support(&other, &-along), known).distance();
                if apart < known {
                    *best = Some((owned.part as usize, apart));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;
    use crate::geom::SplitMix64;
    use crate::mesh::Model;

    /// Boxes of 2 mm strewn about, some of which touch or cross.
    fn strewn(count: usize, seed: u64) -> Model {
        let mut numbers = SplitMix64::seeded(seed);
        let mut at = || numbers.below(600) as f64 / 10.0;
        let boxes = (0..count).map(|i| {
            let corner = Vec3::new(at(), at(), at());
            (format!("box-{i}"), solid_box(corner, corner + Vec3::repeat(2.0)))
        });
        Model::from_parts(boxes.collect())
    }

    /// The distance of two axis-parallel boxes' surfaces, unless one lies in the other: by arithmetic.
    fn boxes_apart(a: &Part, b: &Part) -> f64 {
        let (a, b) = (a.mesh.bounds(), b.mesh.bounds());
        let gap = |i: usize| (b.min[i] - a.max[i]).max(a.min[i] - b.max[i]).max(0.0);
        (0..3).map(|i| gap(i).powi(2)).sum::<f64>().sqrt()
    }

    #[test]
    fn the_nearest_of_strewn_boxes_is_that_of_arithmetic() {
        for (count, seed) in [(2, 1), (9, 2), (40, 3), (150, 4)] {
            let parts = strewn(count, seed).parts;
            let neighbours = Neighbours::of(&parts);
            for part in &parts {
                let others = parts.iter().filter(|other| other.id != part.id);
                let wanted = others.map(|other| boxes_apart(part, other)).fold(f64::INFINITY, f64::min);
                let (near, mm) = neighbours.nearest(part.id).unwrap();
                assert!((mm - wanted).abs() <= 1e-5 * wanted.max(1.0), "{count}: {mm} for {wanted}");
                assert!((boxes_apart(part, &parts[near]) - wanted).abs() <= 1e-5 * wanted.max(1.0));
            }
        }
        assert_eq!(Neighbours::of(&strewn(1, 1).parts).nearest(0), None);
    }

    /// Shells around each other: of all their boxes, the smaller lie in the larger.
    fn nested(count: usize) -> Vec<Part> {
        let corner = |k: usize| Vec3::repeat(-0.1 * k as f64);
        let shells = (1..=count).map(|k| {
            let legs = [Vec3::x(), Vec3::y(), Vec3::z()].map(|leg| corner(k) + leg * k as f64);
            let vertices = vec![corner(k), legs[0], legs[1], legs[2]];
            (String::new(), crate::mesh::TriangleMesh::new(vertices, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
        });
        Model::from_parts(shells.collect()).parts
    }

    /// Whichever way the pairs are found, the interfaces are the same.
    #[test]
    fn no_pair_that_is_near_is_missed() {
        for (count, seed) in [(40, 7), (300, 8)] {
            let parts = strewn(count, seed).parts;
            for mm in [0.0, 0.5, 5.0] {
                let found = Neighbours::of(&parts).within(mm, usize::MAX).unwrap();
                let near = |a: usize, b: usize| boxes_apart(&parts[a], &parts[b]) <= mm;
                let wanted: Vec<_> = (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b))).collect();
                let wanted: Vec<_> = wanted.into_iter().filter(|&(a, b)| near(a, b)).collect();
                assert!(wanted.iter().all(|pair| found.binary_search(pair).is_ok()), "{count} {mm}");
                // A bound is never more than what a box around a facet is off.
                assert!(found.iter().all(|&(a, b)| boxes_apart(&parts[a], &parts[b]) <= mm + 1e-9));
            }
        }
    }

    /// A wall of cubes, each of which touches up to six others, and a box around it that meets all of their boxes.
    #[test]
    fn interfaces_among_many_pairs_are_those_among_few() {
        let cube = |at: Vec3| solid_box(at, at + Vec3::repeat(1.0));
        let wall = |wide: usize| {
            let cubes =
                (0..wide * wide).map(|k| (format!("c{k}"), cube(Vec3::new((k % wide) as f64, 0.0, (k / wide) as f64))));
            // Slanted walls, all in each other's boxes and none near another.
            Model::from_parts(cubes.chain(nested(80).into_iter().map(|part| (part.name, part.mesh))).collect())
        };
        let model = wall(6);
        let touching = model.interfaces.iter().filter(|one| one.b < 36).count();
        assert_eq!(touching, 2 * 6 * 5);
        assert!(model.interfaces.iter().filter(|one| one.b < 36).all(|one| (one.area_mm2 - 1.0).abs() < 1e-9));
    }

    /// Ten times the parts cost little more than ten times as much, whether they are strewn about or lie in each other.
    #[test]
    fn the_cost_grows_with_the_parts_and_not_with_their_square() {
        let cost = |parts: &[Part]| {
            let neighbours = Neighbours::of(parts);
            parts.iter().for_each(|part| assert!(neighbours.nearest(part.id).is_some()));
            // Of shells in each other none is that near.
            assert!(neighbours.within(0.04, parts.len()).unwrap().len() < parts.len());
            neighbours.looked_at()
        };
        for (few, many) in [(strewn(60, 5).parts, strewn(600, 5).parts), (nested(30), nested(300))] {
            let [few, many] = [cost(&few), cost(&many)];
            assert!(many < 25 * few, "{few} for a tenth of the parts, {many} for all");
        }
    }
}
