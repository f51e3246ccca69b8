//! Faces of two parts that look at each other across a small gap, and one of them drawn out to close it.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::geom::{Object, Vec3};
use crate::mesh::{BoxTree, Facing, Part, TriangleMesh, facing_across};

type Mesh = TriangleMesh<Object>;

/// A gap, closed.
pub(super) struct Gap {
    /// Whether the first part's face was drawn out, not the second's.
    pub(super) first_moves: bool,
    /// The part with its face drawn out.
    pub(super) closed: Mesh,
    /// The gap at its widest, mm.
    pub(super) mm: f64,
    /// Whether the face now reaches into the other part and is to be cut along it.
    pub(super) reaches: bool,
}

/// Facets this far from parallel still look at each other, degrees: two roundings of one cylinder with 32 sides and more.
const FACING_DEG: f64 = 12.0;
/// Facets of one face differ by less than this, as a sine.
const ONE_FACE: f64 = 1e-3;
/// A plane gap is equally wide up to this, mm.
const EVEN_MM: f64 = 5e-3;
/// So much farther than the gap a curved face is drawn out, mm: more than a chord of 32 sides is off on a radius of 10 mm.
const INTO_MM: f64 = 0.1;
/// A gap of 0.2 mm in a file of `f32` is a little more or less, mm.
const ROUNDING_MM: f64 = 1e-3;
/// Less than this between two parts is two corners that come near each other, mm².
const LEAST_MM2: f64 = 0.05;

/// Closes what lies between two parts where it is at most `snap_mm` wide and more than the area that they `share` already, mm².
pub(super) fn widest([a, b]: [&Part; 2], trees: [&BoxTree; 2], snap_mm: f64, share: f64) -> Option<Gap> {
    let facing = facing_across([&a.mesh, &b.mesh], trees, snap_mm + ROUNDING_MM, FACING_DEG);
    let area: f64 = facing.iter().map(|one| one.area_mm2).sum();
    if area <= share.max(LEAST_MM2) {
        return None;
    }
    let mm = facing.iter().map(|one| one.gap_mm).fold(0.0, f64::max);
    let sides = [Side::of(&a.mesh, &b.mesh, &facing, 0), Side::of(&b.mesh, &a.mesh, &facing, 1)];
    // The later part where both lie before each other alike.
    let first_moves = sides[0].covered(area) > sides[1].covered(area) + 1e-9;
    let side = &sides[usize::from(!first_moves)];
    let (closed, reaches) = match side.plane_gap() {
        Some(gap_mm) => (side.drawn_out(|_| gap_mm), false),
        None => (side.drawn_out(|facet| side.gaps[&facet] + INTO_MM), true),
    };
    Some(Gap { first_moves, closed, mm, reaches })
}

/// One of two parts that look at each other.
struct Side<'a> {
    mesh: &'a Mesh,
    other: &'a Mesh,
    /// Its facets that look at the other part, each with the widest gap before it, mm.
    gaps: BTreeMap<usize, f64>,
    /// Those, and what lies in one plane with them and hangs together.
    face: BTreeSet<usize>,
    /// The other part's facets there.
    theirs: BTreeSet<usize>,
}

impl<'a> Side<'a> {
    fn of(mesh: &'a Mesh, other: &'a Mesh, facing: &[Facing], side: usize) -> Self {
        let mut gaps: BTreeMap<usize, f64> = BTreeMap::new();
        for one in facing {
            let widest = gaps.entry(one.facets[side]).or_insert(0.0);
            *widest = widest.max(one.gap_mm);
        }
        let theirs = facing.iter().map(|one| one.facets[1 - side]).collect();
        let face = one_face(mesh, gaps.keys().copied());
        Self { mesh, other, gaps, face, theirs }
    }

    /// The share of the face that lies before the other part, of `area` mm² in all.
    fn covered(&self, area: f64) -> f64 {
        area / self.face.iter().map(|&facet| self.mesh.facet_area(facet)).sum::<f64>()
    }

    /// The width of the gap where both its sides are planes, one parallel to the other, mm.
    fn plane_gap(&self) -> Option<f64> {
        let first = *self.gaps.keys().next()?;
        let normal = self.mesh.normal(first)?;
        let flat = |mesh: &Mesh, facets: &BTreeSet<usize>| {
            facets.iter().all(|&facet| mesh.normal(facet).is_some_and(|n| n.cross(&normal).norm() < ONE_FACE))
        };
        if !flat(self.mesh, &self.face) || !flat(self.other, &self.theirs) {
            return None;
        }
        let (low, high) = self.gaps.values().fold((f64::INFINITY, 0.0f64), |(l, h), g| (l.min(*g), h.max(*g)));
        (high - low < EVEN_MM).then_some(high)
    }

    /// The mesh with the corners of its face moved outward, each by the most that `by` says of the facets around it, mm.
    fn drawn_out(&self, by: impl Fn(usize) -> f64) -> Mesh {
        let curved = self.plane_gap().is_none();
        let moving = |facet: &&usize| !curved || self.gaps.contains_key(*facet);
        let mut moves: HashMap<u32, (Vec3, f64)> = HashMap::new();
        for &facet in self.face.iter().filter(moving) {
            let Some(normal) = self.mesh.normal(facet) else { continue };
            for &corner in &self.mesh.facets()[facet] {
                let (along, mm) = moves.entry(corner).or_insert((Vec3::zeros(), 0.0));
                *along += normal * self.mesh.facet_area(facet);
                *mm = mm.max(by(facet));
            }
        }
        let mut vertices = self.mesh.vertices().to_vec();
        for (corner, (along, mm)) in moves {
            if let Some(along) = along.try_normalize(0.0) {
                vertices[corner as usize] += along * mm;
            }
        }
        Mesh::new(vertices, self.mesh.facets().to_vec())
    }
}

/// The facets that lie in one plane with some of `first` and hang together with them by sides, those among them.
fn one_face(mesh: &Mesh, first: impl Iterator<Item = usize>) -> BTreeSet<usize> {
    let mut beside: HashMap<(u32, u32), Vec<usize>> = HashMap::new();
    for (index, facet) in mesh.facets().iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (facet[k], facet[(k + 1) % 3]);
            beside.entry((a.min(b), a.max(b))).or_default().push(index);
        }
    }
    let mut face: BTreeSet<usize> = BTreeSet::new();
    let mut queue: Vec<usize> = first.collect();
    while let Some(facet) = queue.pop() {
        if !face.insert(facet) {
            continue;
        }
        let Some(normal) = mesh.normal(facet) else { continue };
        let corners = mesh.facets()[facet];
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let sides = beside.get(&(a.min(b), a.max(b))).into_iter().flatten();
            queue.extend(sides.copied().filter(|&next| {
                mesh.normal(next).is_none_or(|n| n.dot(&normal) > 0.0 && n.cross(&normal).norm() < ONE_FACE)
            }));
        }
    }
    face
}
