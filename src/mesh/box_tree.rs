//! A tree of boxes: which facets of a mesh may touch a given box.

use super::TriangleMesh;
use crate::geom::Bounds;

/// Facets in one leaf.
const LEAF: usize = 8;

struct Node {
    bounds: Bounds,
    /// Range of `order` below this node.
    facets: (u32, u32),
    /// The second child; the first follows its parent. Zero at a leaf.
    second: u32,
}

/// The boxes of a mesh's facets, halved at the median of their longest axis: says which facets may touch a given box.
pub struct BoxTree {
    boxes: Vec<Bounds>,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

impl BoxTree {
    /// Of all facets of `mesh`; `O(n log n)`.
    pub fn new<F>(mesh: &TriangleMesh<F>) -> Self {
        Self::of_boxes((0..mesh.facets().len()).map(|index| Bounds::of(mesh.corners(index))).collect())
    }

    /// Of any boxes: what it says of facets, it then says of these.
    pub(crate) fn of_boxes(boxes: Vec<Bounds>) -> Self {
        let order = (0..boxes.len() as u32).collect();
        let mut tree = Self { nodes: Vec::with_capacity(boxes.len() / 2 + 1), order, boxes };
        if !tree.boxes.is_empty() {
            tree.split(0, tree.boxes.len());
        }
        tree
    }

    /// The box of facet `index`.
    pub(super) fn bounds_of(&self, index: usize) -> &Bounds {
        &self.boxes[index]
    }

    fn split(&mut self, from: usize, to: usize) {
        let range = &mut self.order[from..to];
        let bounds = range.iter().fold(Bounds::EMPTY, |all, &index| all.union(&self.boxes[index as usize]));
        let here = self.nodes.len();
        self.nodes.push(Node { bounds, facets: (from as u32, to as u32), second: 0 });
        if to - from <= LEAF {
            return;
        }
        let axis = bounds.size().imax();
        let centre = |index: &u32| self.boxes[*index as usize].min[axis] + self.boxes[*index as usize].max[axis];
        let middle = (to - from) / 2;
        range.select_nth_unstable_by(middle, |a, b| centre(a).total_cmp(&centre(b)).then(a.cmp(b)));
        self.split(from, from + middle);
        self.nodes[here].second = self.nodes.len() as u32;
        self.split(from + middle, to);
    }

    /// What is behind `first` and meets `bounds`, ascending: into `found`, in the place of what that holds.
    pub(super) fn later(&self, bounds: &Bounds, first: usize, found: &mut Vec<usize>) {
        found.clear();
        self.visit(bounds, |other| {
            if other > first {
                found.push(other);
            }
        });
        found.sort_unstable();
    }

    /// Calls `visit` for every facet whose box meets `bounds`, in no particular order.
    pub(crate) fn visit(&self, bounds: &Bounds, mut visit: impl FnMut(usize)) {
        let mut stack = if self.nodes.is_empty() { vec![] } else { vec![0] };
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at];
            if !node.bounds.meets(bounds) {
                continue;
            }
            if node.second > 0 {
                stack.extend([at + 1, node.second as usize]);
                continue;
            }
            let leaf = &self.order[node.facets.0 as usize..node.facets.1 as usize];
            leaf.iter().map(|&i| i as usize).filter(|&i| self.boxes[i].meets(bounds)).for_each(&mut visit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::BoxTree;
    use crate::geom::{Bounds, Object, Vec3};
    use crate::mesh::TriangleMesh;

    #[test]
    fn finds_what_a_plain_search_finds() {
        let centre = |i: u32| Vec3::new(f64::from(i * 37 % 101), f64::from(i * 53 % 103), f64::from(i * 71 % 107));
        let corner = |i: u32| centre(i / 3) + Vec3::ith(i as usize % 3, 30.0);
        let vertices: Vec<Vec3> = (0..600).map(corner).collect();
        let mesh = TriangleMesh::<Object>::new(vertices, (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
        let tree = BoxTree::new(&mesh);
        for size in [0.0, 10.0, 60.0] {
            let min = Vec3::new(20.0, 30.0, 40.0);
            let probe = Bounds { min, max: min + Vec3::repeat(size) };
            let mut found = Vec::new();
            tree.visit(&probe, |index| found.push(index));
            found.sort_unstable();
            let wanted: Vec<usize> = (0..200).filter(|&i| Bounds::of(mesh.corners(i)).meets(&probe)).collect();
            assert_eq!(found, wanted);
            assert!(!found.is_empty() && found.len() < 200);
        }
    }
}
