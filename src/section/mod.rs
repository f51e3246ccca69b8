//! A part's cross-sections, and how far a point of the plane lies from their outlines.
//!
//! ```text
//! mesh (build direction +z) --Sections::of--> facets by height --at(z)--> Section --signed_distance(p)--> mm, inside negative
//! ```
//!
//! A brick's section, and distances from its outline:
//!
//! ```
//! use trunnion::geom::{Bounds, Vec3};
//! use trunnion::mesh::TriangleMesh;
//! use trunnion::section::Sections;
//!
//! // A brick of 10 x 20 x 30 mm, cut 15 mm above its foot.
//! let brick: TriangleMesh = TriangleMesh::cuboid(&Bounds { min: Vec3::zeros(), max: Vec3::new(10.0, 20.0, 30.0) });
//! let cut = Sections::of(&brick).at(15.0);
//! assert!((cut.area() - 10.0 * 20.0).abs() < 1e-9);
//! assert!((cut.perimeter() - 60.0).abs() < 1e-9);
//!
//! // Points 1 mm to either side of the wall at x = 10; inside is negative. Beyond 2 mm the answer is 2 or -2.
//! assert!((cut.signed_distance([9.0, 10.0]) + 1.0).abs() < 1e-9);
//! assert!((cut.signed_distance([11.0, 10.0]) - 1.0).abs() < 1e-9);
//! assert_eq!(cut.signed_distance([5.0, 10.0]), -2.0);
//! ```
//!
//! Every slicer lays its outer walls half a line inside the outline of the layer's middle, so this is the surface that sliced
//! lines are compared with: exact at any overhang, where the distance in space is not.
//!
//! The side of a point is told by the outline's winding number, so that parts of several overlapping shells are solid where
//! any of them is. Units: mm, in the mesh's own frame.

mod fit;
mod grid;
mod march;
mod outline;
mod overlap;
pub mod polygons;
pub mod simplify;

pub use fit::{Fit, Sample, fit};
pub use grid::{Nearest, PlanePoint, Segment, Segments, to_segment};
pub use march::march;
pub use outline::{OutlineSearch, Section};

use crate::geom::Vec3;
use crate::mesh::TriangleMesh;

/// Height of a bin of facets, mm: about a few layers.
const BIN_MM: f64 = 0.5;
/// Bins at most; a very high part gets higher ones.
const MOST_BINS: f64 = 20_000.0;

/// A mesh, ready to be cut at any height.
pub struct Sections {
    facets: Vec<[Vec3; 3]>,
    /// Lowest and highest z.
    range: [f64; 2],
    bin_mm: f64,
    /// Where each bin's facets begin in `members`.
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Sections {
    /// The mesh's facets by height.
    pub fn of<F>(mesh: &TriangleMesh<F>) -> Self {
        let facets: Vec<[Vec3; 3]> = (0..mesh.facets().len()).map(|i| mesh.corners(i)).collect();
        let heights = facets.iter().flatten().map(|p| p.z);
        let range = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |r, z| [r[0].min(z), r[1].max(z)]);
        let bin_mm = BIN_MM.max((range[1] - range[0]) / MOST_BINS);
        let bins = if facets.is_empty() { 1 } else { ((range[1] - range[0]) / bin_mm) as usize + 1 };
        let mut all = Self { facets, range, bin_mm, starts: vec![0; bins + 1], members: Vec::new() };
        all.file();
        all
    }

    /// Counts, then places, each facet in every bin that it reaches.
    fn file(&mut self) {
        let bins: Vec<[usize; 2]> = self.facets.iter().map(|f| self.bins_of(f)).collect();
        for [first, last] in &bins {
            self.starts[*first..=*last].iter_mut().for_each(|count| *count += 1);
        }
        let mut total = 0;
        for start in &mut self.starts {
            total += std::mem::replace(start, total);
        }
        self.members = vec![0; total as usize];
        let mut next = self.starts.clone();
        for (facet, [first, last]) in bins.iter().enumerate() {
            for place in &mut next[*first..=*last] {
                self.members[*place as usize] = facet as u32;
                *place += 1;
            }
        }
    }

    fn bins_of(&self, facet: &[Vec3; 3]) -> [usize; 2] {
        let z = facet.map(|p| p.z);
        [z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2])].map(|z| self.bin(z))
    }

    fn bin(&self, z: f64) -> usize {
        (((z - self.range[0]) / self.bin_mm).max(0.0) as usize).min(self.starts.len() - 2)
    }

    /// Lowest and highest z of the part; infinite and inside out for one without facets.
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// From where to where level facets reach, by their lower ends: those less than `flat_mm` high that rise by less than `slope` over their
    /// longest side and do not vanish seen from above.
    pub fn level_facets(&self, flat_mm: f64, slope: f64) -> Vec<[f64; 2]> {
        let span = |[a, b, c]: &[Vec3; 3]| {
            let [low, high] = [a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z)];
            let doubled = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
            let side = |p: &Vec3, q: &Vec3| (p.x - q.x).hypot(p.y - q.y);
            let longest = side(a, b).max(side(b, c)).max(side(c, a));
            (high - low < flat_mm && high - low <= slope * longest && doubled != 0.0).then_some([low, high])
        };
        let mut found: Vec<[f64; 2]> = self.facets.iter().filter_map(span).collect();
        found.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        found.dedup();
        found
    }

    /// The cut at height `z`: material to the left of each segment. Empty outside the part.
    ///
    /// A corner at exactly `z` counts as above, so that the outline is closed.
    pub fn at(&self, z: f64) -> Section {
        Section::new(self.segments_at(z))
    }

    /// The same cut as segments alone.
    pub fn segments_at(&self, z: f64) -> Vec<Segment> {
        let mut segments = Vec::new();
        if z >= self.range[0] && z <= self.range[1] {
            let bin = self.bin(z);
            let members = &self.members[self.starts[bin] as usize..self.starts[bin + 1] as usize];
            segments.extend(members.iter().filter_map(|&i| cut(&self.facets[i as usize], z)));
        }
        segments
    }

    /// The same cut, with what the outline moves outward there per mm of height.
    pub fn sloped_segments_at(&self, z: f64) -> Vec<(Segment, f64)> {
        let mut segments = Vec::new();
        if z >= self.range[0] && z <= self.range[1] {
            let bin = self.bin(z);
            let members = &self.members[self.starts[bin] as usize..self.starts[bin + 1] as usize];
            let one = |&i: &u32| {
                let facet = &self.facets[i as usize];
                Some((cut(facet, z)?, outward(facet)))
            };
            segments.extend(members.iter().filter_map(one));
        }
        segments
    }
}

/// What a cut through a facet moves outward per mm of height.
fn outward([a, b, c]: &[Vec3; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a));
    -normal.z / normal.x.hypot(normal.y)
}

/// Where the plane at `z` cuts a facet, from the edge that goes down through it to the one that comes up: with the normal
/// outward, material lies to the left.
fn cut(corners: &[Vec3; 3], z: f64) -> Option<[[f64; 2]; 2]> {
    let above = corners.map(|p| p.z >= z);
    let (mut down, mut up) = (None, None);
    for i in 0..3 {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        if above[i] != above[(i + 1) % 3] {
            // From the lower end, so that two facets of one edge agree to the last bit.
            let (low, high) = if above[i] { (b, a) } else { (a, b) };
            let share = (z - low.z) / (high.z - low.z);
            let point = [low.x + (high.x - low.x) * share, low.y + (high.y - low.y) * share];
            *(if above[i] { &mut down } else { &mut up }) = Some(point);
        }
    }
    let (from, to) = (down?, up?);
    (from != to).then_some([from, to])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Rigid, Table};

    fn sections(min: [f64; 3], max: [f64; 3]) -> Sections {
        let mesh = crate::fixtures::solid_box(Vec3::from(min), Vec3::from(max));
        Sections::of(&mesh.moved::<Table>(&Rigid::shift(Vec3::zeros())))
    }

    #[test]
    fn a_side_through_the_middles_of_cells_is_no_riddle() {
        // Outlines whose lowest corner lies on a side of 45 degrees: the grid begins there, so that the side runs through the middle
        // of cell after cell, up to rounding.
        let mut numbers = crate::geom::SplitMix64::seeded(5);
        for _ in 0..300 {
            let low = [(); 2].map(|()| (numbers.unit() - 0.5) * 60.0);
            let [wide, high] = [(); 2].map(|()| 1.0 + 9.0 * numbers.unit());
            let corners = [
                low,
                [low[0] + wide, low[1] + wide],
                [low[0] + wide, low[1] + wide + high],
                [low[0], low[1] + wide + high],
            ];
            let section = Section::new((0..4).map(|i| [corners[i], corners[(i + 1) % 4]]).collect());
            for _ in 0..100 {
                let p = [low[0] + wide * numbers.unit(), low[1] + (wide + high) * numbers.unit()];
                let away = (p[1] - low[1]) - (p[0] - low[0]);
                assert!(away.abs() < 1e-9 || section.is_inside(p) == (away > 0.0), "{p:?} in {corners:?}");
                assert_eq!(section.signed_distance(p), section.by_brute_force(p), "{p:?} in {corners:?}");
            }
        }
    }

    #[test]
    fn a_box_by_hand() {
        let all = sections([0.0; 3], [10.0, 6.0, 8.0]);
        let section = all.at(3.0);
        for (p, wanted) in [
            ([5.0, 3.0], -2.0),
            ([5.0, 0.5], -0.5),
            ([9.75, 3.0], -0.25),
            ([10.5, 3.0], 0.5),
            ([11.0, 7.0], 2f64.sqrt()),
            ([-30.0, 3.0], 2.0),
            ([10.0, 3.0], 0.0),
        ] {
            // Beyond 2 mm distances are not told apart.
            let got = section.signed_distance(p);
            assert!((got - wanted).abs() < 1e-9, "{p:?}: {got}, wanted {wanted}");
        }
        assert!((section.perimeter() - 32.0).abs() < 1e-9 && (section.area() - 60.0).abs() < 1e-9);
        assert!(all.at(8.5).is_empty() && all.at(-0.1).is_empty());
    }

    #[test]
    fn beside_a_slit_as_thin_as_rounding_is_inside() {
        // The top of a hole, as a plane that just touches it sees it.
        let slit = |half: f64| {
            let outer = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
            let inner = [[5.0 - half, 2.0], [5.0 - half, 8.0], [5.0 + half, 8.0], [5.0 + half, 2.0]];
            let ring = |c: [[f64; 2]; 4]| (0..4).map(move |i| [c[i], c[(i + 1) % 4]]);
            Section::new(ring(outer).chain(ring(inner)).collect())
        };
        for half in [0.0, 1e-12, 1e-9, 1e-7, 1e-3] {
            for x in [4.4, 4.99, 5.01, 5.6] {
                let (got, wanted) = (slit(half).signed_distance([x, 5.0]), half - f64::abs(x - 5.0));
                assert!((got - wanted).abs() < 1e-6, "half {half}: {got} at {x}, wanted {wanted}");
            }
        }
    }

    #[test]
    fn a_curved_part_is_closed_and_as_every_segment_tried_says() {
        let fixture = crate::fixtures::candelabrum();
        let mesh = fixture.parts[11].1.moved::<Table>(&Rigid::shift(Vec3::zeros()));
        let all = Sections::of(&mesh);
        let [low, high] = all.range();
        for k in 1..20 {
            let section = all.at(low + (high - low) * f64::from(k) / 20.0);
            let bounds = section.bounds();
            for i in 0..60u32 {
                let share = |n: u32| f64::from((i * n) % 61) / 60.0;
                let p = [0, 1].map(|a| bounds[0][a] - 1.0 + (bounds[1][a] - bounds[0][a] + 2.0) * share([37, 53][a]));
                let wanted = section.by_brute_force(p);
                let got = section.signed_distance(p);
                assert!((got - wanted).abs() < 1e-9, "{p:?} at {k}: {got}, wanted {wanted}");
            }
        }
    }

    #[test]
    fn curves_are_told_apart_whatever_the_order_of_their_facets() {
        let post = |x: f64, side: f64| {
            crate::fixtures::solid_box(Vec3::new(x, 0.0, 0.0), Vec3::new(x + side, side, 5.0))
                .moved::<Table>(&Rigid::shift(Vec3::zeros()))
        };
        let (mut vertices, mut facets) = (Vec::new(), Vec::new());
        for (x, side) in [(0.0, 3.0), (5.0, 1.0), (10.0, 2.0)] {
            let one = post(x, side);
            let first = vertices.len() as u32;
            vertices.extend_from_slice(one.vertices());
            facets.extend(one.facets().iter().map(|f| f.map(|i| i + first)));
        }
        // Facets of all three in turn.
        facets.sort_by_key(|f| (f[0] % 8, f[1] % 8, f[2] % 8));
        let section = Sections::of(&TriangleMesh::<Table>::new(vertices, facets)).at(2.0);
        let curves = section.curves();
        let of = |x: f64| (x / 5.0).floor() as usize;
        for (a, ca) in section.segments().iter().zip(&curves) {
            for (b, cb) in section.segments().iter().zip(&curves) {
                assert_eq!(ca == cb, of(a[0][0]) == of(b[0][0]), "{a:?} {b:?} {curves:?}");
            }
        }
    }
}
