//! The lowest of many points along a direction, exactly, without visiting them all.
//!
//! A tree of boxes instead of a convex hull: a hull of nearly coplanar points needs exact predicates to be right, a box
//! bound needs none.

use crate::geom::{Bounds, Vec3};

/// Points in a tree of boxes.
#[derive(Clone, Debug)]
pub(in crate::orient) struct Lowest {
    points: Vec<Vec3>,
    nodes: Vec<HeightBox>,
}

#[derive(Clone, Debug)]
struct HeightBox {
    centre: Vec3,
    half: Vec3,
    /// Its points.
    from: u32,
    to: u32,
    /// Its two children, if any: the first follows it.
    second: Option<std::num::NonZeroU32>,
}

/// A leaf holds at most so many points.
const LEAF: usize = 8;

impl Lowest {
    pub(in crate::orient) fn of(points: &[Vec3]) -> Self {
        let mut tree = Self { points: points.to_vec(), nodes: Vec::new() };
        if !points.is_empty() {
            tree.split(0, points.len());
        }
        tree
    }

    fn split(&mut self, from: usize, to: usize) -> usize {
        let bounds = Bounds::of(self.points[from..to].iter().copied());
        let half = bounds.size() * 0.5;
        let index = self.nodes.len();
        self.nodes.push(HeightBox { centre: bounds.centre(), half, from: from as u32, to: to as u32, second: None });
        if to - from > LEAF {
            let axis = half.imax();
            let middle = (to - from) / 2;
            self.points[from..to].select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
            self.split(from, from + middle);
            let second = self.split(from + middle, to);
            self.nodes[index].second = std::num::NonZeroU32::new(second as u32);
        }
        index
    }

    /// The lowest point along `up`; the origin for none.
    pub(in crate::orient) fn along(&self, up: &Vec3) -> Vec3 {
        let mut best = (f64::INFINITY, Vec3::zeros());
        if !self.nodes.is_empty() {
            self.visit(0, &[*up, up.abs()], &mut best);
        }
        best.1
    }

    fn bound(&self, node: usize, [up, size]: &[Vec3; 2]) -> f64 {
        let node = &self.nodes[node];
        node.centre.dot(up) - node.half.dot(size)
    }

    fn visit(&self, index: usize, up: &[Vec3; 2], best: &mut (f64, Vec3)) {
        let node = &self.nodes[index];
        let Some(second) = node.second else {
            for point in &self.points[node.from as usize..node.to as usize] {
                let along = point.dot(&up[0]);
                if along < best.0 {
                    *best = (along, *point);
                }
            }
            return;
        };
        let (a, b) = (index + 1, second.get() as usize);
        let (low_a, low_b) = (self.bound(a, up), self.bound(b, up));
        let order = if low_a <= low_b { [(low_a, a), (low_b, b)] } else { [(low_b, b), (low_a, a)] };
        for (low, child) in order {
            if low < best.0 {
                self.visit(child, up, best);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::orient::sphere::lattice;

    #[test]
    fn agrees_with_looking_at_every_point() {
        let points: Vec<Vec3> = (0..500)
            .map(|i| lattice(i, 500).component_mul(&Vec3::new(1.0, 2.0, 3.0)) * (1.0 + (i % 7) as f64))
            .collect();
        let tree = Lowest::of(&points);
        for i in 0..300 {
            let up = lattice(i, 300);
            let wanted = points.iter().map(|p| p.dot(&up)).fold(f64::INFINITY, f64::min);
            assert!((tree.along(&up).dot(&up) - wanted).abs() < 1e-12, "{up:?}");
        }
        assert_eq!(Lowest::of(&[]).along(&Vec3::z()), Vec3::zeros());
    }
}
