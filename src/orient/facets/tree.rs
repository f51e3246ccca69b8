//! A tree of boxes over a part's facets, for lines of sight.
//!
//! Segments against triangles after T. Moeller and B. Trumbore, *Fast, minimum storage ray/triangle intersection*, Journal
//! of Graphics Tools 2 (1997), 21-28; an edge belongs to both its facets, so that no line slips through between them.

use super::Facets;
use crate::geom::{Bounds, Vec3};

/// Facets in a tree of boxes.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    nodes: Vec<SightBox>,
    /// A corner, two sides and the number of each facet, in the tree's order.
    facets: Vec<(Vec3, Vec3, Vec3, u32)>,
}

#[derive(Clone, Debug)]
struct SightBox {
    low: Vec3,
    high: Vec3,
    from: u32,
    to: u32,
    /// The second child's place; the first follows its parent.
    second: Option<std::num::NonZeroU32>,
}

const LEAF: usize = 4;

impl Tree {
    pub(crate) fn of(facets: &Facets) -> Self {
        let triangle = |(i, f): (usize, &[u32; 3])| {
            let [a, b, c] = f.map(|k| facets.points[k as usize]);
            (a, b - a, c - a, i as u32)
        };
        let mut tree = Self { nodes: Vec::new(), facets: facets.corners.iter().enumerate().map(triangle).collect() };
        if !tree.facets.is_empty() {
            tree.split(0, tree.facets.len());
        }
        tree
    }

    fn split(&mut self, from: usize, to: usize) -> usize {
        let corners = self.facets[from..to].iter().flat_map(|(a, u, v, _)| [*a, a + u, a + v]);
        let bounds = Bounds::of(corners);
        let index = self.nodes.len();
        self.nodes.push(SightBox { low: bounds.min, high: bounds.max, from: from as u32, to: to as u32, second: None });
        if to - from > LEAF {
            let axis = bounds.size().imax();
            let middle = (to - from) / 2;
            let key = |f: &(Vec3, Vec3, Vec3, u32)| 3.0 * f.0[axis] + f.1[axis] + f.2[axis];
            let order = |a: &(Vec3, Vec3, Vec3, u32), b: &(Vec3, Vec3, Vec3, u32)| {
                key(a).total_cmp(&key(b)).then(a.3.cmp(&b.3))
            };
            self.facets[from..to].select_nth_unstable_by(middle, order);
            self.split(from, from + middle);
            let second = self.split(from + middle, to);
            self.nodes[index].second = std::num::NonZeroU32::new(second as u32);
        }
        index
    }

    /// Whether a facet other than `but` lies between `from` and `to`.
    pub(crate) fn blocks(&self, from: &Vec3, to: &Vec3, but: [u32; 2]) -> bool {
        let along = to - from;
        let mut found = false;
        self.visit(from, &along, 1.0, &mut |t, facet| {
            found |= t > 0.0 && t < 1.0 && !but.contains(&facet);
            if found { 0.0 } else { 1.0 }
        });
        found
    }

    /// The facet that a ray from `from` along `along` meets first, other than `but`.
    pub(crate) fn first(&self, from: &Vec3, along: &Vec3, but: u32) -> Option<u32> {
        let mut best = (f64::INFINITY, None);
        self.visit(from, along, f64::INFINITY, &mut |t, facet| {
            if facet != but && t > 0.0 && (t < best.0 || (t == best.0 && Some(facet) < best.1)) {
                best = (t, Some(facet));
            }
            best.0
        });
        best.1
    }

    /// Calls `meet` with the facets whose own boxes meet `bounds`, until it says `false`.
    pub(crate) fn within(&self, bounds: &Bounds, meet: &mut impl FnMut(u32) -> bool) {
        let mut stack = if self.nodes.is_empty() { vec![] } else { vec![0] };
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            if !bounds.meets(&Bounds { min: node.low, max: node.high }) {
                continue;
            }
            if let Some(second) = node.second {
                stack.extend([second.get() as usize, index + 1]);
                continue;
            }
            for (a, u, v, facet) in &self.facets[node.from as usize..node.to as usize] {
                if bounds.meets(&Bounds::of([*a, a + u, a + v])) && !meet(*facet) {
                    return;
                }
            }
        }
    }

    /// Calls `hit` with the places, in lengths of `along`, where the line meets facets before `until`; it says until where
    /// to look further.
    pub(crate) fn visit(&self, from: &Vec3, along: &Vec3, until: f64, hit: &mut impl FnMut(f64, u32) -> f64) {
        if self.nodes.is_empty() {
            return;
        }
        let inverse = along.map(|x| 1.0 / x);
        let (mut until, mut stack, mut depth) = (until, [0u32; 64], 1);
        while depth > 0 {
            depth -= 1;
            let index = stack[depth] as usize;
            let node = &self.nodes[index];
            if !meets(node, from, &inverse, until) {
                continue;
            }
            if let Some(second) = node.second {
                (stack[depth], stack[depth + 1]) = (second.get(), index as u32 + 1);
                depth += 2;
                continue;
            }
            for (a, u, v, facet) in &self.facets[node.from as usize..node.to as usize] {
                if let Some(t) = crossing(a, u, v, from, along) {
                    until = until.min(hit(t, *facet));
                }
            }
        }
    }
}

/// Whether the line runs through the node's box before `until`; touching counts.
fn meets(node: &SightBox, from: &Vec3, inverse: &Vec3, until: f64) -> bool {
    let (mut enter, mut leave) = (0.0f64, until);
    for k in 0..3 {
        let (a, b) = ((node.low[k] - from[k]) * inverse[k], (node.high[k] - from[k]) * inverse[k]);
        // Not a number where the line runs in the box's side: then it does not tell.
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    enter <= leave * (1.0 + 1e-12)
}

fn crossing(a: &Vec3, u: &Vec3, v: &Vec3, from: &Vec3, along: &Vec3) -> Option<f64> {
    let p = along.cross(v);
    let det = u.dot(&p);
    if det == 0.0 {
        return None;
    }
    let s = from - a;
    let x = s.dot(&p) / det;
    if !(0.0..=1.0).contains(&x) {
        return None;
    }
    let q = s.cross(u);
    let y = along.dot(&q) / det;
    (y >= 0.0 && x + y <= 1.0).then(|| v.dot(&q) / det)
}
