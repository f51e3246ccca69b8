//! How far a point lies from a part's surface, and on which side.
//!
//! Source: J. A. Bærentzen, H. Aanæs, *Signed distance computation using the angle weighted pseudonormal*, IEEE TVCG 11
//! (2005), 243-253; the nearest point of a triangle after C. Ericson, *Real-Time Collision Detection* (2005), 5.1.5.
//! The pseudonormal is summed over the facets that are nearest at the moment, so that no adjacency is needed and seams
//! of unmatched facets do no harm.

use std::sync::atomic::{AtomicU32, Ordering};

use crate::geom::{Bounds, Vec3};
use crate::mesh::TriangleMesh;

/// Facets in one leaf.
const LEAF: usize = 4;
/// Facets this much farther than the nearest (mm) still count as touched by the same point.
const TIE_MM: f64 = 1e-6;

/// Edge of the cells for which a distance is kept, mm.
const CELL_MM: f64 = 1.0;
/// Cells at most; a greater part keeps none and is asked each time.
const MOST_CELLS: f64 = 2e7;
/// What rounding to 32 bits may take off a distance below 1 m, mm.
const ROUNDING: f64 = 1e-4;

/// A part's surface, ready for distances.
pub(super) struct Shell {
    facets: Vec<Facet>,
    nodes: Vec<Node>,
    kept: Kept,
}

/// The distances of cells' centres, worked out when first asked for; not a number before. Whichever thread comes first
/// writes the same value.
#[derive(Default)]
struct Kept {
    origin: Vec3,
    count: [usize; 3],
    distances: Vec<AtomicU32>,
}

struct Facet {
    corners: [Vec3; 3],
    normal: Vec3,
    angles: [f64; 3],
}

struct Node {
    bounds: Bounds,
    first: u32,
    /// 0 at an inner node.
    count: u32,
    /// The second child; the first follows its parent.
    second: u32,
}

impl Shell {
    /// The surface of a closed mesh; facets without area are left out.
    pub(super) fn new<F>(mesh: &TriangleMesh<F>) -> Self {
        let facet = |i: usize| {
            let corners = mesh.corners(i);
            let angle = |k: usize| {
                let (a, b) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
                a.cross(&b).norm().atan2(a.dot(&b))
            };
            mesh.normal(i).map(|normal| Facet { corners, normal, angles: [0, 1, 2].map(angle) })
        };
        let mut shell = Self {
            facets: (0..mesh.facets().len()).filter_map(facet).collect(),
            nodes: Vec::new(),
            kept: Kept::default(),
        };
        if !shell.facets.is_empty() {
            shell.split(0, shell.facets.len());
            shell.kept = Kept::over(&mesh.bounds());
        }
        shell
    }

    fn split(&mut self, from: usize, to: usize) {
        let facets = &mut self.facets[from..to];
        let bounds = Bounds::of(facets.iter().flat_map(|f| f.corners));
        let here = self.nodes.len();
        let leaf = to - from <= LEAF;
        let count = if leaf { (to - from) as u32 } else { 0 };
        self.nodes.push(Node { bounds, first: from as u32, count, second: 0 });
        if leaf {
            return;
        }
        let axis = bounds.size().imax();
        let centre = |f: &Facet| f.corners.iter().map(|c| c[axis]).sum::<f64>();
        let middle = (to - from) / 2;
        facets.select_nth_unstable_by(middle, |a, b| centre(a).total_cmp(&centre(b)));
        self.split(from, from + middle);
        self.nodes[here].second = self.nodes.len() as u32;
        self.split(from + middle, to);
    }

    /// An upper bound of [`Shell::signed_distance`], mostly without a search: the distance changes by at most 1 mm per mm.
    pub(super) fn at_most(&self, p: &Vec3) -> f64 {
        let Some((index, centre)) = self.kept.cell(p) else { return self.signed_distance(p) };
        let kept = f32::from_bits(self.kept.distances[index].load(Ordering::Relaxed));
        let distance = if kept.is_nan() {
            let distance = (self.signed_distance(&centre) + ROUNDING) as f32;
            self.kept.distances[index].store(distance.to_bits(), Ordering::Relaxed);
            distance
        } else {
            kept
        };
        f64::from(distance) + (p - centre).norm()
    }

    /// The distance of `p` (the mesh's frame) from the surface, mm: negative inside, infinite for a part without facets.
    pub(super) fn signed_distance(&self, p: &Vec3) -> f64 {
        let mut nearest = Nearest { distance: f64::INFINITY, side: 0.0 };
        if !self.nodes.is_empty() {
            self.visit(0, p, &mut nearest);
        }
        if nearest.side < 0.0 { -nearest.distance } else { nearest.distance }
    }

    fn visit(&self, at: usize, p: &Vec3, nearest: &mut Nearest) {
        let node = &self.nodes[at];
        if node.count > 0 {
            let range = node.first as usize..(node.first + node.count) as usize;
            self.facets[range].iter().for_each(|facet| nearest.take(facet, p));
            return;
        }
        let children = [at + 1, node.second as usize];
        let mut away = children.map(|c| (to_box(&self.nodes[c].bounds, p), c));
        if away[1].0 < away[0].0 {
            away.swap(0, 1);
        }
        for (distance, child) in away {
            if distance <= nearest.distance + TIE_MM {
                self.visit(child, p, nearest);
            }
        }
    }
}

impl Kept {
    fn over(bounds: &Bounds) -> Self {
        let count = bounds.size().map(|v| (v / CELL_MM).ceil().max(1.0));
        if count.product() > MOST_CELLS {
            return Self::default();
        }
        let cells = count.product() as usize;
        let distances = (0..cells).map(|_| AtomicU32::new(f32::NAN.to_bits())).collect();
        Self { origin: bounds.min, count: [0, 1, 2].map(|i| count[i] as usize), distances }
    }

    /// The cell of `p` and its centre; `None` outside the box.
    fn cell(&self, p: &Vec3) -> Option<(usize, Vec3)> {
        let at = ((p - self.origin) / CELL_MM).map(f64::floor);
        let inside = (0..3).all(|i| at[i] >= 0.0 && at[i] < self.count[i] as f64);
        let [x, y, z] = [0, 1, 2].map(|i| at[i] as usize);
        let index = (z * self.count[1] + y) * self.count[0] + x;
        inside.then(|| (index, self.origin + (at + Vec3::repeat(0.5)) * CELL_MM))
    }
}

struct Nearest {
    distance: f64,
    /// The point's height over the nearest facets, weighted by how much of the surface there is theirs.
    side: f64,
}

impl Nearest {
    fn take(&mut self, facet: &Facet, p: &Vec3) {
        let (point, weight) = facet.nearest(p);
        let away = p - point;
        let distance = away.norm();
        if distance > self.distance + TIE_MM {
            return;
        }
        if distance < self.distance - TIE_MM {
            self.side = 0.0;
        }
        self.distance = self.distance.min(distance);
        self.side += weight * away.dot(&facet.normal);
    }
}

impl Facet {
    /// The nearest point, and the angle under which the facet lies around it.
    fn nearest(&self, p: &Vec3) -> (Vec3, f64) {
        let [a, b, c] = self.corners;
        let (ab, ac, ap) = (b - a, c - a, p - a);
        let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return (a, self.angles[0]);
        }
        let bp = p - b;
        let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
        if d3 >= 0.0 && d4 <= d3 {
            return (b, self.angles[1]);
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return (a + ab * (d1 / (d1 - d3)), std::f64::consts::PI);
        }
        let cp = p - c;
        let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
        if d6 >= 0.0 && d5 <= d6 {
            return (c, self.angles[2]);
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return (a + ac * (d2 / (d2 - d6)), std::f64::consts::PI);
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 >= d3 && d5 >= d6 {
            let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            return (b + (c - b) * w, std::f64::consts::PI);
        }
        let whole = va + vb + vc;
        (a + ab * (vb / whole) + ac * (vc / whole), std::f64::consts::TAU)
    }
}

fn to_box(bounds: &Bounds, p: &Vec3) -> f64 {
    (bounds.min - p).sup(&(p - bounds.max)).sup(&Vec3::zeros()).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Rigid, Table};

    #[test]
    fn a_box_by_hand_inside_outside_edge_and_corner() {
        let mesh = crate::fixtures::solid_box(Vec3::zeros(), Vec3::new(4.0, 6.0, 8.0))
            .moved::<Table>(&Rigid::shift(Vec3::zeros()));
        let shell = Shell::new(&mesh);
        for (p, wanted) in [
            ([2.0, 3.0, 4.0], -2.0),
            ([2.0, 3.0, 7.5], -0.5),
            ([2.0, 3.0, 9.0], 1.0),
            ([5.0, 7.0, 4.0], 2f64.sqrt()),
            ([-1.0, -1.0, -1.0], 3f64.sqrt()),
            ([0.0, 3.0, 4.0], 0.0),
        ] {
            let got = shell.signed_distance(&Vec3::from(p));
            assert!((got - wanted).abs() < 1e-9, "{p:?}: {got}, wanted {wanted}");
        }
    }

    #[test]
    fn agrees_with_every_facet_tried_on_a_curved_part() {
        let fixture = crate::fixtures::candelabrum();
        let mesh = fixture.parts[11].1.moved::<Table>(&Rigid::shift(Vec3::zeros()));
        let shell = Shell::new(&mesh);
        let bounds = mesh.bounds().inflated(1.0);
        for i in 0..200u32 {
            let share = |k: u32| f64::from((i * k) % 101) / 100.0;
            let p = Vec3::from_fn(|a, _| bounds.min[a] + bounds.size()[a] * share([37, 53, 71][a]));
            let wanted = shell.facets.iter().map(|f| (f.nearest(&p).0 - p).norm()).fold(f64::INFINITY, f64::min);
            let got = shell.signed_distance(&p);
            assert!((got.abs() - wanted).abs() < 1e-9, "{p:?}");
            assert!((got..got + 1.8).contains(&shell.at_most(&p)), "{p:?}");
        }
    }
}
