//! A convex hull to which points are still added, mm, in whatever frame they are in.
//!
//! Incremental: each point beyond a face takes away the faces that it sees and is joined to their rim (M. Kallay, "The complexity of
//! incremental convex hull algorithms in R^d", Information Processing Letters 19 (1984), 197). Which faces a point sees is told
//! exactly, on a grid of a thousand-millionth of the body's size: with rounded answers what is seen may fall into several patches, as
//! among points that lie within a hair of each other or of a plane, and the faces made then pass through each other.

use super::{Bounds, Vec3};

/// How far beyond a face a point may lie and still count as on it, of the body's size.
pub(super) const SLACK: f64 = 1e-6;
/// Cells of the grid along the body's longest diagonal: so many that three differences multiplied are below 2^93, and two below 2^61.
const CELLS: f64 = (1_u64 << 29) as f64;

/// Beyond this many cells from a rounded plane its side is sure: coordinates of 2^29 are rounded by 2^-22 there.
const SURE: f64 = 1.0;

type Cell = [i64; 3];

#[derive(Clone, Debug)]
struct Face {
    corners: [usize; 3],
    /// The first corner, and twice the area along the outward normal, in cells: exact.
    at: Cell,
    across: Cell,
}

impl Face {
    fn of(cells: &[Cell], corners: [usize; 3]) -> Self {
        let [a, b, c] = corners.map(|i| cells[i]);
        Self { corners, at: a, across: cross(less(b, a), less(c, a)) }
    }

    /// Whether a cell lies beyond the face, exactly.
    fn is_seen_from(&self, cell: Cell) -> bool {
        let from = less(cell, self.at);
        (0..3).map(|k| i128::from(from[k]) * i128::from(self.across[k])).sum::<i128>() > 0
    }

    fn plane(&self) -> Plane {
        let across = Vec3::from(self.across.map(|v| v as f64));
        let normal = across / across.norm();
        Plane { normal, offset: normal.dot(&Vec3::from(self.at.map(|v| v as f64))) }
    }
}

/// A face's plane, in cells: rounded, to a small part of a cell.
#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: Vec3,
    offset: f64,
}

impl Plane {
    fn height(&self, at: &Vec3) -> f64 {
        self.normal.dot(at) - self.offset
    }
}

fn less(a: Cell, b: Cell) -> Cell {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: Cell, b: Cell) -> Cell {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A hull to which points are still added.
#[derive(Clone, Debug)]
pub struct GrowingHull {
    points: Vec<Vec3>,
    cells: Vec<Cell>,
    faces: Vec<Face>,
    /// The faces' planes, by themselves: most faces are asked for nothing else.
    planes: Vec<Plane>,
    origin: Vec3,
    /// A cell's width, mm.
    width: f64,
}

impl GrowingHull {
    /// The hull of nothing, on a grid for points within `bounds`; what lies beyond a face by less than a millionth of their size
    /// counts as on it.
    pub fn within(bounds: &Bounds) -> Self {
        let size = bounds.size().norm();
        let (origin, width) =
            if bounds.is_empty() || size == 0.0 { (Vec3::zeros(), 1.0) } else { (bounds.min, size / CELLS) };
        Self { points: Vec::new(), cells: Vec::new(), faces: Vec::new(), planes: Vec::new(), origin, width }
    }

    /// Its points, mm.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// Its faces as triples of the points' indices, counter-clockwise seen from outside; none where all is flat.
    pub fn faces(&self) -> Vec<[u32; 3]> {
        self.faces.iter().map(|f| f.corners.map(|i| i as u32)).collect()
    }

    /// Whether all points lie in one plane, so that there are no faces.
    pub fn is_flat(&self) -> bool {
        self.faces.is_empty()
    }

    /// Joins more points, all of them within the bounds.
    pub fn add(&mut self, points: &[Vec3]) {
        let mut from = self.points.len();
        self.points.extend_from_slice(points);
        let cell = |p: &Vec3| [0, 1, 2].map(|k| ((p[k] - self.origin[k]) / self.width).round() as i64);
        self.cells.extend(points.iter().map(cell));
        if self.faces.is_empty() {
            let Some(faces) = self.first() else { return };
            self.planes = faces.iter().map(Face::plane).collect();
            self.faces = faces;
            from = 0;
        }
        for index in from..self.points.len() {
            self.join(index);
        }
    }

    /// Forgets the points that are no face's corner; none where all is flat.
    pub fn shed(&mut self) {
        if self.faces.is_empty() {
            return;
        }
        let mut places = vec![usize::MAX; self.points.len()];
        self.faces.iter().flat_map(|f| f.corners).for_each(|i| places[i] = 0);
        let mut kept = Vec::new();
        for (index, place) in places.iter_mut().enumerate().filter(|(_, place)| **place == 0) {
            *place = kept.len();
            kept.push(index);
        }
        self.faces.iter_mut().for_each(|f| f.corners = f.corners.map(|i| places[i]));
        self.points = kept.iter().map(|&i| self.points[i]).collect();
        self.cells = kept.iter().map(|&i| self.cells[i]).collect();
    }

    /// How far, mm, one comes from `point` along the unit vector `along` before one leaves the hull; 0 for a point that lies outside, and
    /// infinity where no face is ever met.
    pub fn way_out(&self, point: &Vec3, along: &Vec3) -> f64 {
        let from = (point - self.origin) / self.width;
        let ways = self.planes.iter().filter_map(|f| {
            let speed = f.normal.dot(along);
            (speed > 1e-12).then(|| -f.height(&from) / speed)
        });
        ways.fold(f64::INFINITY, f64::min).max(0.0) * self.width
    }

    /// A tetrahedron of points far from each other; `None` where all lie in a plane.
    fn first(&self) -> Option<Vec<Face>> {
        let points = &self.points;
        let slack = CELLS * self.width * SLACK;
        let farthest = |measure: &dyn Fn(&Vec3) -> f64| {
            let best = (0..points.len()).max_by(|&i, &j| measure(&points[i]).total_cmp(&measure(&points[j])));
            best.filter(|&i| measure(&points[i]) > slack)
        };
        let a = 0;
        let b = farthest(&|p| (p - points[a]).norm())?;
        let along = (points[b] - points[a]).normalize();
        let c = farthest(&|p| (p - points[a]).cross(&along).norm())?;
        let normal = (points[b] - points[a]).cross(&(points[c] - points[a])).normalize();
        let d = farthest(&|p| (p - points[a]).dot(&normal).abs())?;
        let above = (points[d] - points[a]).dot(&normal) > 0.0;
        let [b, c] = if above { [c, b] } else { [b, c] };
        Some([[a, b, c], [a, d, b], [b, d, c], [c, d, a]].map(|corners| Face::of(&self.cells, corners)).into())
    }

    /// Joins a point that lies beyond a face.
    fn join(&mut self, index: usize) {
        let cell = self.cells[index];
        let at = Vec3::from(cell.map(|v| v as f64));
        if !self.planes.iter().any(|f| f.height(&at) > CELLS * SLACK) {
            return;
        }
        let mut seen = Vec::new();
        for (face, plane) in self.planes.iter().enumerate() {
            let height = plane.height(&at);
            if height > SURE || height > -SURE && self.faces[face].is_seen_from(cell) {
                seen.push(face);
            }
        }
        let mut edges: Vec<(usize, usize)> = seen.iter().flat_map(|&f| edges(self.faces[f].corners)).collect();
        // In a fixed order, so that the same points give the same bytes.
        edges.sort_unstable();
        let rim = edges.iter().filter(|(a, b)| edges.binary_search(&(*b, *a)).is_err());
        let mut places = seen.into_iter();
        for &(a, b) in rim {
            let face = Face::of(&self.cells, [a, b, index]);
            let plane = face.plane();
            // In the place of one that is gone, as long as there is one: nothing else has to move.
            if let Some(place) = places.next() {
                (self.faces[place], self.planes[place]) = (face, plane);
            } else {
                self.faces.push(face);
                self.planes.push(plane);
            }
        }
        for place in places.rev() {
            self.faces.swap_remove(place);
            self.planes.swap_remove(place);
        }
    }
}

fn edges([a, b, c]: [usize; 3]) -> [(usize, usize); 3] {
    [(a, b), (b, c), (c, a)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::convex::support;
    use crate::geom::{Body, Hull, SplitMix64};

    #[test]
    fn points_added_later_give_the_same_body_and_the_way_out_is_by_hand() {
        let mut random = SplitMix64::seeded(5);
        let points: Vec<Vec3> = (0..400).map(|_| random.direction() * random.unit().sqrt()).collect();
        let mut growing = GrowingHull::within(&Bounds::of(points.iter().copied()));
        growing.add(&[]);
        growing.add(&points[..3]);
        assert!(growing.is_flat());
        for chunk in points[3..].chunks(50) {
            growing.add(chunk);
            growing.shed();
        }
        let whole = Hull::of(&points).pruned();
        assert!(growing.points().len().abs_diff(whole.points.len()) < 4);
        for _ in 0..500 {
            let along = random.direction();
            let apart = whole.support(&along).dot(&along) - support(growing.points(), &along).dot(&along);
            assert!(apart.abs() < 1e-5, "{apart}");
        }
        let corners = Body::cuboid("c", Vec3::zeros(), Vec3::repeat(2.0), [true; 3]).points;
        let mut cube = GrowingHull::within(&Bounds::of(corners.iter().copied()));
        cube.add(&corners);
        assert!((cube.way_out(&Vec3::new(0.5, 1.0, 1.0), &Vec3::x()) - 1.5).abs() < 1e-8);
        let slant = Vec3::new(3.0, 4.0, 0.0) / 5.0;
        assert!((cube.way_out(&Vec3::new(0.5, 1.0, 1.0), &slant) - 1.25).abs() < 1e-8);
        assert_eq!(cube.way_out(&Vec3::new(2.5, 1.0, 1.0), &Vec3::x()), 0.0);
    }
}
