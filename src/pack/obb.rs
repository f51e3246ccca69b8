//! Trees of oriented boxes over a surface (Gottschalk, Lin and Manocha, "OBBTree: a hierarchical structure for rapid interference detection", 1996;
//! Leitereg (2020), section 2.6), and what they answer: whether two surfaces meet, how far one can be moved along a direction before it meets the other,
//! and how far it can be turned about an axis.
//!
//! The covariance is that of the surface as a plate of even thickness; its mean is over areas (`1 / sum m`; the thesis prints `1 / n`, which is no mean).
//! Coordinates are those of the file: a surface's place comes with each question.

use nalgebra::SymmetricEigen;

use crate::geom::convex::{separation, support};
use crate::geom::{Mat3, Vec3};

/// Where a surface is: `p = turn p_own + shift`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    pub(super) turn: Mat3,
    pub(super) shift: Vec3,
}

impl Pose {
    fn point(&self, p: &Vec3) -> Vec3 {
        self.turn * p + self.shift
    }

    /// This as seen from `other`.
    fn seen_from(&self, other: &Self) -> Self {
        let back = other.turn.transpose();
        Self { turn: back * self.turn, shift: back * (self.shift - other.shift) }
    }
}

/// A box: its middle, axes (columns) and half lengths.
#[derive(Clone, Debug)]
struct Obb {
    middle: Vec3,
    axes: Mat3,
    half: Vec3,
}

#[derive(Debug)]
struct Node {
    obb: Obb,
    /// Children, or the facet of a leaf.
    below: Below,
}

#[derive(Debug)]
enum Below {
    Facet(usize),
    Nodes(usize, usize),
}

/// A surface with its tree.
#[derive(Debug)]
pub(super) struct ObbTree {
    facets: Vec<[Vec3; 3]>,
    nodes: Vec<Node>,
    /// The farthest of the surface from its file's origin.
    reach: f64,
}

impl ObbTree {
    pub(super) fn of(facets: &[[Vec3; 3]]) -> Self {
        let reach = facets.iter().flatten().map(|p| p.norm()).fold(0.0, f64::max);
        let mut tree = Self { facets: facets.to_vec(), nodes: Vec::with_capacity(2 * facets.len()), reach };
        let mut order: Vec<usize> = (0..facets.len()).collect();
        if !order.is_empty() {
            tree.build(&mut order);
        }
        tree
    }

    fn build(&mut self, order: &mut [usize]) -> usize {
        let here = self.nodes.len();
        let (obb, mean) = around(&self.facets, order);
        let (axes, half) = (obb.axes, obb.half);
        self.nodes.push(Node { obb, below: Below::Facet(order[0]) });
        if order.len() == 1 {
            return here;
        }
        // Cut at the mean along the longest axis; where all lies on one side of it, in halves.
        let mut by_length = [0, 1, 2];
        by_length.sort_by(|&a, &b| half[b].total_cmp(&half[a]));
        let centre = |facet: usize, axis: usize| {
            let [a, b, c] = self.facets[facet];
            (a + b + c).dot(&axes.column(axis)) / 3.0
        };
        let cut = by_length.iter().find_map(|&axis| {
            order.sort_by(|&a, &b| centre(a, axis).total_cmp(&centre(b, axis)).then(a.cmp(&b)));
            let at = order.partition_point(|&facet| centre(facet, axis) < mean.dot(&axes.column(axis)));
            (at > 0 && at < order.len()).then_some(at)
        });
        let (first, second) = order.split_at_mut(cut.unwrap_or(order.len() / 2));
        let first = self.build(first);
        let second = self.build(second);
        self.nodes[here].below = Below::Nodes(first, second);
        here
    }

    /// How far this can be moved along the unit direction `along` before it meets the other; `most` where that is farther.
    pub(super) fn free(&self, own: &Pose, other: &Self, pose: &Pose, along: &Vec3, most: f64) -> f64 {
        let seen = pose.seen_from(own);
        let along = own.turn.transpose() * along;
        let mut best = most;
        let Some(first) = sweep(&self.nodes[0].obb, &other.nodes[0].obb, &seen, &along) else { return best };
        let mut stack = vec![(first, 0, 0)];
        while let Some((near, i, j)) = stack.pop() {
            if near >= best {
                continue;
            }
            let (a, b) = (&self.nodes[i], &other.nodes[j]);
            if let (Below::Facet(f), Below::Facet(g)) = (&a.below, &b.below) {
                let theirs = other.facets[*g].map(|p| seen.point(&p));
                best = best.min(swept(&self.facets[*f], &theirs, &along));
                continue;
            }
            // Nearest pairs are taken first, so that the bound soon cuts off the rest.
            let from = stack.len();
            children(a, b, i, j, &mut |i, j| {
                stack.extend(sweep(&self.nodes[i].obb, &other.nodes[j].obb, &seen, &along).map(|near| (near, i, j)));
            });
            stack[from..].sort_by(|x, y| y.0.total_cmp(&x.0));
        }
        best
    }

    /// How far (radians, at most `most`) this can be turned about the unit axis through `about` (which it turns with) before it comes
    /// within `gap`: in steps, each as far as the least distance allows its farthest point to go (conservative advancement; Mirtich 1996).
    #[expect(clippy::too_many_arguments, reason = "two surfaces, two places, an axis and three limits")]
    pub(super) fn turnable(
        &self,
        own: &Pose,
        other: &Self,
        pose: &Pose,
        about: &Vec3,
        axis: &Vec3,
        gap: f64,
        most: f64,
    ) -> f64 {
        let arm = self.reach + (own.shift - about).norm();
        let mut angle = 0.0;
        for _ in 0..MOST_ADVANCES {
            let turned = turned_about(own, about, axis, angle);
            let room = self.distance(&turned, other, pose, most * arm + gap) - gap;
            if room <= 1e-6 * arm {
                break;
            }
            angle += room / arm;
            if angle >= most {
                return most;
            }
        }
        // What the last step came to was proved free by the step before it.
        angle.min(most)
    }

    /// The least distance of the surfaces; `reach` where it is no less.
    pub(super) fn distance(&self, own: &Pose, other: &Self, pose: &Pose, reach: f64) -> f64 {
        let seen = pose.seen_from(own);
        let mut best = reach;
        let mut stack = vec![(0.0, 0, 0)];
        while let Some((near, i, j)) = stack.pop() {
            if near >= best {
                continue;
            }
            let (a, b) = (&self.nodes[i], &other.nodes[j]);
            if let (Below::Facet(f), Below::Facet(g)) = (&a.below, &b.below) {
                let theirs = other.facets[*g].map(|p| seen.point(&p));
                best = best.min(facets_apart(&self.facets[*f], &theirs));
                continue;
            }
            let from = stack.len();
            children(a, b, i, j, &mut |i, j| {
                let near = at_least(&self.nodes[i].obb, &other.nodes[j].obb, &seen);
                if near < best {
                    stack.push((near, i, j));
                }
            });
            stack[from..].sort_by(|x, y| y.0.total_cmp(&x.0));
        }
        best
    }
}

/// Steps of a turn.
const MOST_ADVANCES: usize = 24;

/// A pose turned about an axis through a point.
pub(super) fn turned_about(pose: &Pose, about: &Vec3, axis: &Vec3, angle: f64) -> Pose {
    let turn = nalgebra::Rotation3::new(axis * angle).into_inner();
    Pose { turn: turn * pose.turn, shift: about + turn * (pose.shift - about) }
}

/// The pairs one level down: of the larger box of the two where both have children.
fn children(a: &Node, b: &Node, i: usize, j: usize, visit: &mut dyn FnMut(usize, usize)) {
    let larger = a.obb.half.norm() >= b.obb.half.norm();
    match (&a.below, &b.below) {
        (Below::Nodes(first, second), Below::Facet(_)) => [*first, *second].into_iter().for_each(|c| visit(c, j)),
        (Below::Nodes(first, second), Below::Nodes(..)) if larger => {
            [*first, *second].into_iter().for_each(|c| visit(c, j));
        }
        (_, Below::Nodes(first, second)) => [*first, *second].into_iter().for_each(|c| visit(i, c)),
        (Below::Facet(_), Below::Facet(_)) => {}
    }
}

/// The box around facets along the axes of their covariance, and the surface's mean.
fn around(facets: &[[Vec3; 3]], order: &[usize]) -> (Obb, Vec3) {
    let (mut area, mut first, mut second) = (0.0, Vec3::zeros(), Mat3::zeros());
    let about = facets[order[0]][0];
    for &facet in order {
        let [a, b, c] = facets[facet].map(|p| p - about);
        let m = (b - a).cross(&(c - a)).norm() / 2.0;
        let sum = a + b + c;
        area += m;
        first += sum * (m / 3.0);
        second += (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose()) * (m / 12.0);
    }
    let mean = if area > 0.0 { first / area } else { Vec3::zeros() };
    let covariance = if area > 0.0 { second / area - mean * mean.transpose() } else { Mat3::identity() };
    let axes = SymmetricEigen::new(covariance).eigenvectors;
    let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    for p in order.iter().flat_map(|&facet| facets[facet]) {
        let own = axes.transpose() * p;
        (low, high) = (low.inf(&own), high.sup(&own));
    }
    let obb = Obb { middle: axes * ((low + high) / 2.0), axes, half: (high - low) / 2.0 };
    (obb, mean + about)
}

/// The fifteen axes that may separate two boxes, with how far their middles are apart along each (`b` from `a`) and how far both reach.
fn each_axis(a: &Obb, b: &Obb, pose: &Pose, mut visit: impl FnMut(Vec3, f64, f64) -> bool) {
    let (axes, between) = (pose.turn * b.axes, pose.point(&b.middle) - a.middle);
    let mut tell = |axis: Vec3| {
        let reach: f64 = (0..3)
            .map(|k| a.half[k] * axis.dot(&a.axes.column(k)).abs() + b.half[k] * axis.dot(&axes.column(k)).abs())
            .sum();
        visit(axis, axis.dot(&between), reach)
    };
    for i in 0..3 {
        if !tell(a.axes.column(i).into_owned()) || !tell(axes.column(i).into_owned()) {
            return;
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            let cross = a.axes.column(i).cross(&axes.column(j));
            let length = cross.norm();
            if length > 1e-6 && !tell(cross / length) {
                return;
            }
        }
    }
}

/// From when on two boxes may meet where `a` moves `along`; `None` where they never do.
fn sweep(a: &Obb, b: &Obb, pose: &Pose, along: &Vec3) -> Option<f64> {
    let (mut from, mut to) = (0.0_f64, f64::INFINITY);
    each_axis(a, b, pose, |axis, between, reach| {
        // What rounding may take of it.
        let (speed, reach) = (axis.dot(along), reach * (1.0 + 1e-9) + 1e-9);
        if speed.abs() < 1e-12 {
            if between.abs() > reach {
                to = -1.0;
            }
        } else {
            let (one, two) = ((between - reach) / speed, (between + reach) / speed);
            (from, to) = (from.max(one.min(two)), to.min(one.max(two)));
        }
        from <= to
    });
    (from <= to).then_some(from)
}

/// What two boxes are at least apart.
fn at_least(a: &Obb, b: &Obb, pose: &Pose) -> f64 {
    let mut least = 0.0_f64;
    each_axis(a, b, pose, |_, between, reach| {
        least = least.max(between.abs() - reach);
        true
    });
    least * (1.0 - 1e-9)
}

/// The distance of two facets, by their difference.
fn facets_apart(f: &[Vec3; 3], g: &[Vec3; 3]) -> f64 {
    separation(|d| support(f, d) - support(g, &-d), f64::INFINITY).distance()
}

/// How far `f` moves along a direction until it touches `g`; infinity for never. Corners against facets, edges against edges.
fn swept(f: &[Vec3; 3], g: &[Vec3; 3], along: &Vec3) -> f64 {
    let mut least = f64::INFINITY;
    f.iter().for_each(|p| least = least.min(struck(p, along, g)));
    g.iter().for_each(|p| least = least.min(struck(p, &-along, f)));
    for i in 0..3 {
        for j in 0..3 {
            least = least.min(crossed([f[i], f[(i + 1) % 3]], [g[j], g[(j + 1) % 3]], along));
        }
    }
    least
}

/// What a share may lie beyond an end and still be on the edge.
const ENDS: f64 = 1e-9;

/// How far a point moves until it lies on a facet (Moeller and Trumbore 1997).
fn struck(p: &Vec3, along: &Vec3, [a, b, c]: &[Vec3; 3]) -> f64 {
    let (e, f) = (b - a, c - a);
    let normal = along.cross(&f);
    let det = e.dot(&normal);
    if det.abs() < 1e-12 * e.norm() * f.norm() {
        return f64::INFINITY;
    }
    let from = p - a;
    let (u, across) = (from.dot(&normal) / det, from.cross(&e));
    let (v, far) = (along.dot(&across) / det, f.dot(&across) / det);
    let on = u >= -ENDS && v >= -ENDS && u + v <= 1.0 + ENDS && far >= 0.0;
    if on { far } else { f64::INFINITY }
}

/// How far the edge `pq` moves until it crosses the edge `rt`: `p + s d + x along = r + u e`.
fn crossed([p, q]: [Vec3; 2], [r, t]: [Vec3; 2], along: &Vec3) -> f64 {
    let (d, e) = (q - p, t - r);
    let det = d.dot(&(-e).cross(along));
    if det.abs() < 1e-12 * d.norm() * e.norm() {
        return f64::INFINITY;
    }
    let between = r - p;
    let s = between.dot(&(-e).cross(along)) / det;
    let u = d.dot(&between.cross(along)) / det;
    let far = d.dot(&(-e).cross(&between)) / det;
    let on = (-ENDS..=1.0 + ENDS).contains(&s) && (-ENDS..=1.0 + ENDS).contains(&u) && far >= 0.0;
    if on { far } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;
    use crate::geom::SplitMix64;
    use crate::pack::PackSolid;

    fn at(x: f64, y: f64, z: f64) -> Pose {
        Pose { turn: Mat3::identity(), shift: Vec3::new(x, y, z) }
    }

    fn tree(size: Vec3) -> ObbTree {
        ObbTree::of(&PackSolid::of([&solid_box(Vec3::zeros(), size)], 1.0, 1).facets)
    }

    #[test]
    fn cubes_are_as_far_apart_as_by_hand() {
        let cube = tree(Vec3::repeat(10.0));
        let origin = at(0.0, 0.0, 0.0);
        let free = |pose: &Pose, along: Vec3| cube.free(&origin, &cube, pose, &along.normalize(), 100.0);
        assert!((free(&at(25.0, 3.0, 4.0), Vec3::x()) - 15.0).abs() < 1e-9);
        assert_eq!(free(&at(25.0, 3.0, 4.0), -Vec3::x()), 100.0);
        assert_eq!(free(&at(25.0, 10.5, 4.0), Vec3::x()), 100.0);
        assert!((free(&at(20.0, 20.0, 4.0), Vec3::new(1.0, 1.0, 0.0)) - 10.0 * 2_f64.sqrt()).abs() < 1e-9);
        assert!((cube.distance(&origin, &cube, &at(13.0, 14.0, 5.0), 50.0) - 5.0).abs() < 1e-6);
        assert_eq!(cube.distance(&origin, &cube, &at(90.0, 0.0, 0.0), 50.0), 50.0);
        // Turned about its own corner, the far corner strikes a wall that stands 12 mm from the axis.
        let wall = at(-2.0, 12.0, 0.0);
        let angle = cube.turnable(&origin, &cube, &wall, &Vec3::zeros(), &Vec3::z(), 0.0, 3.0);
        let meets = (12.0 / 200_f64.sqrt()).asin() - std::f64::consts::FRAC_PI_4;
        assert!(angle <= meets + 1e-6 && angle > 0.8 * meets, "{angle} of {meets}");
    }

    /// Random places and directions: what is said to be free is, in small steps, and at its end the surfaces meet.
    #[test]
    fn what_is_free_is_free_and_no_more() {
        let mut numbers = SplitMix64::seeded(8);
        let (block, bar) = (tree(Vec3::new(9.0, 8.0, 11.0)), tree(Vec3::new(30.0, 3.0, 4.0)));
        let mut hits = 0;
        for _ in 0..150 {
            let mut pose = |far: f64| Pose {
                turn: nalgebra::Rotation3::new(numbers.direction() * 3.0).into_inner(),
                shift: numbers.direction() * far,
            };
            let (own, other) = (pose(0.0), pose(30.0));
            let along = (other.shift - own.shift + numbers.direction() * 8.0).normalize();
            if bar.distance(&own, &block, &other, 1.0) < 0.5 {
                continue;
            }
            let free = bar.free(&own, &block, &other, &along, 60.0);
            let moved = |by: f64| Pose { shift: own.shift + along * by, ..own };
            for step in 0..30 {
                let by = free * f64::from(step) / 30.0;
                assert!(bar.distance(&moved(by), &block, &other, 1.0) > 0.0, "{by} of {free}");
            }
            if free < 60.0 {
                hits += 1;
                assert!(bar.distance(&moved(free), &block, &other, 1.0) < 1e-4);
            }
        }
        assert!(hits > 60, "{hits}");
    }
}
