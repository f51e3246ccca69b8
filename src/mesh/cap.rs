//! The cap that closes a cut: loops of edges in a plane, which lies in which, and their triangles.
//!
//! Both sides of the cut get the same triangles over the same vertices, one of them turned over, so that they fit each other bit
//! for bit. Every vertex of a loop stays a corner, those in the middle of a straight stretch too: the facets beside it end there.
//! The triangles are `earcut`'s; what it leaves out is put back, and a cap that does not close its loops is none.

use std::collections::{BTreeMap, HashSet};

use earcut::Earcut;

use super::edges::EdgeMap;
use crate::geom::Vec3;

/// Facets less high than this have no normal that means anything, mm.
pub(crate) const THIN_MM: f64 = 1e-3;

/// A connected piece of a cap.
#[derive(Clone, Debug)]
pub(crate) struct CapPatch {
    /// Corners, counter-clockwise seen from the side that the cap faces.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// mm².
    pub(crate) area_mm2: f64,
    /// One vertex of each loop around it.
    pub(crate) of_loops: Vec<u32>,
}

/// The loops cannot be capped: they touch themselves, or have no area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NoCap;

type Flat = [f64; 2];

struct Loop {
    vertices: Vec<u32>,
    flat: Vec<Flat>,
    /// mm²; negative for the rim of a hole.
    area: f64,
}

/// The patches that close the directed `edges` of a cap facing `facing`: each edge is run along by one triangle, in its sense.
pub(crate) fn patches(vertices: &[Vec3], edges: &[[u32; 2]], facing: &Vec3) -> Result<Vec<CapPatch>, NoCap> {
    let [u, v] = axes(facing);
    let flat = |i: u32| [vertices[i as usize].dot(&u), vertices[i as usize].dot(&v)];
    let loops = loops(edges, &flat)?;
    let (outer, holes): (Vec<&Loop>, Vec<&Loop>) = loops.iter().partition(|l| l.area > 0.0);
    let mut inside: Vec<Vec<&Loop>> = vec![Vec::new(); outer.len()];
    for hole in holes {
        let around = (0..outer.len()).filter(|&i| outer[i].area > -hole.area && hole.lies_in(outer[i]));
        let nearest = around.min_by(|&a, &b| outer[a].area.total_cmp(&outer[b].area)).ok_or(NoCap)?;
        inside[nearest].push(hole);
    }
    outer.iter().zip(&inside).map(|(outer, holes)| patch(outer, holes)).collect()
}

/// Two unit vectors that make a right-handed frame with `facing`.
fn axes(facing: &Vec3) -> [Vec3; 2] {
    let across = Vec3::ith(facing.iamin(), 1.0);
    let u = across.cross(facing).normalize();
    [u, facing.cross(&u)]
}

/// Chains the edges; where several leave a vertex, the one that keeps closest to the left goes on.
fn loops(edges: &[[u32; 2]], flat: &dyn Fn(u32) -> Flat) -> Result<Vec<Loop>, NoCap> {
    let mut leaving: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    edges.iter().for_each(|&[a, b]| leaving.entry(a).or_default().push(b));
    let mut loops = Vec::new();
    while let Some((&first, ends)) = leaving.iter_mut().next() {
        let mut vertices = vec![first];
        let mut here = ends.pop().ok_or(NoCap)?;
        if ends.is_empty() {
            leaving.remove(&first);
        }
        let mut before = first;
        while here != first {
            vertices.push(here);
            let ends = leaving.get_mut(&here).ok_or(NoCap)?;
            let next = ends.swap_remove(leftmost(flat(before), flat(here), ends, flat));
            if ends.is_empty() {
                leaving.remove(&here);
            }
            (before, here) = (here, next);
        }
        let flat: Vec<Flat> = vertices.iter().map(|&v| flat(v)).collect();
        let area = signed_area(&flat);
        if vertices.len() < 3 || area == 0.0 {
            return Err(NoCap);
        }
        loops.push(Loop { vertices, flat, area });
    }
    Ok(loops)
}

/// Which of `ends` is the first clockwise from the way back.
fn leftmost(before: Flat, here: Flat, ends: &[u32], flat: &dyn Fn(u32) -> Flat) -> usize {
    if ends.len() == 1 {
        return 0;
    }
    let angle = |to: Flat| (to[1] - here[1]).atan2(to[0] - here[0]);
    let back = angle(before);
    let clockwise = |end: &u32| {
        let turn = (back - angle(flat(*end))).rem_euclid(std::f64::consts::TAU);
        if turn < 1e-12 { std::f64::consts::TAU } else { turn }
    };
    (0..ends.len()).min_by(|&a, &b| clockwise(&ends[a]).total_cmp(&clockwise(&ends[b]))).unwrap_or(0)
}

fn signed_area(flat: &[Flat]) -> f64 {
    let Some(&o) = flat.first() else { return 0.0 };
    let pairs = flat.windows(2).map(|w| (w[0][0] - o[0]) * (w[1][1] - o[1]) - (w[1][0] - o[0]) * (w[0][1] - o[1]));
    pairs.sum::<f64>() * 0.5
}

impl Loop {
    /// Whether most of its corners lie inside `outer`; corners may touch.
    fn lies_in(&self, outer: &Self) -> bool {
        let known: HashSet<u32> = outer.vertices.iter().copied().collect();
        let free = self.vertices.iter().zip(&self.flat).filter(|(v, _)| !known.contains(v)).map(|(_, p)| *p);
        // Where all corners are shared, the middles of the edges tell.
        let middles = (0..self.flat.len()).map(|i| {
            let (a, b) = (self.flat[i], self.flat[(i + 1) % self.flat.len()]);
            [(a[0] + b[0]) * 0.5, (a[1] + b[1]) * 0.5]
        });
        let mut probes: Vec<Flat> = free.collect();
        if probes.is_empty() {
            probes = middles.collect();
        }
        2 * probes.iter().filter(|p| outer.holds(p)).count() > probes.len()
    }

    /// Crossings of a ray along the first axis.
    fn holds(&self, p: &Flat) -> bool {
        let n = self.flat.len();
        let crosses = |i: &usize| {
            let (a, b) = (self.flat[*i], self.flat[(*i + 1) % n]);
            (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        };
        (0..n).filter(crosses).count() % 2 == 1
    }
}

fn patch(outer: &Loop, holes: &[&Loop]) -> Result<CapPatch, NoCap> {
    let rings = || std::iter::once(outer).chain(holes.iter().copied());
    let flat: Vec<Flat> = rings().flat_map(|l| l.flat.iter().copied()).collect();
    let mut starts: Vec<u32> = Vec::new();
    let mut at = outer.vertices.len() as u32;
    for hole in holes {
        starts.push(at);
        at += hole.vertices.len() as u32;
    }
    let mut corners: Vec<u32> = Vec::new();
    Earcut::new().earcut(flat.iter().copied(), &starts, &mut corners);
    // From here on a vertex is its place among those of the rim, in their order.
    let mut known: Vec<u32> = rings().flat_map(|l| l.vertices.iter().copied()).collect();
    known.sort_unstable();
    known.dedup();
    let place_of = |v: &u32| known.partition_point(|k| k < v) as u32;
    let number: Vec<u32> = rings().flat_map(|l| l.vertices.iter().map(place_of)).collect();
    let mut place = vec![[0.0; 2]; known.len()];
    number.iter().zip(flat).for_each(|(v, at)| place[*v as usize] = at);
    let mut triangles: Vec<[u32; 3]> =
        corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|i| number[i as usize])).collect();
    let area = |t: &[u32; 3]| signed_area(&t.map(|i| place[i as usize]));
    // All turn the same way; one alone says nothing, since its area may be rounding.
    if triangles.iter().map(area).sum::<f64>() < 0.0 {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let ends: Vec<usize> = starts.iter().map(|s| *s as usize).chain([number.len()]).collect();
    Rim::of(&number, &ends, known.len()).put_back(&mut triangles)?;
    flip_slivers(&mut triangles, &place);
    let area_mm2 = outer.area + holes.iter().map(|h| h.area).sum::<f64>();
    let covered: f64 = triangles.iter().map(area).sum();
    if (covered - area_mm2).abs() > 1e-9 * (1.0 + outer.area) {
        return Err(NoCap);
    }
    let triangles = triangles.into_iter().map(|t| t.map(|i| known[i as usize])).collect();
    Ok(CapPatch { triangles, area_mm2, of_loops: rings().map(|l| l.vertices[0]).collect() })
}

/// The edges around a patch, by the vertex that they leave.
struct Rim {
    /// Of vertex `v`: `ends[first[v]..first[v + 1]]`.
    first: Vec<usize>,
    ends: Vec<u32>,
    /// By edge: whether no triangle runs along it.
    missing: Vec<bool>,
}

/// A side of a triangle, and the triangle's number.
type Side = ([u32; 2], usize);

impl Rim {
    /// `rings` are runs of vertices out of `count`, the ends of which stand in `runs`.
    fn of(rings: &[u32], runs: &[usize], count: usize) -> Self {
        let mut first = vec![0; count + 1];
        rings.iter().for_each(|&v| first[v as usize + 1] += 1);
        (0..count).for_each(|v| first[v + 1] += first[v]);
        let (mut next, mut ends) = (first.clone(), vec![0; rings.len()]);
        let mut start = 0;
        for &end in runs {
            for i in start..end {
                let (a, b) = (rings[i] as usize, if i + 1 < end { rings[i + 1] } else { rings[start] });
                ends[next[a]] = b;
                next[a] += 1;
            }
            start = end;
        }
        Self { first, missing: vec![true; ends.len()], ends }
    }

    fn leaving(&self, v: u32) -> std::ops::Range<usize> {
        self.first[v as usize]..self.first[v as usize + 1]
    }

    fn found(&mut self, [a, b]: [u32; 2]) {
        for edge in self.leaving(a) {
            self.missing[edge] &= self.ends[edge] != b;
        }
    }

    /// Puts back the corners in the middle of straight stretches: a side that neither runs along the rim nor has a partner
    /// stands for the stretch of the rim between its ends.
    fn put_back(mut self, triangles: &mut Vec<[u32; 3]>) -> Result<(), NoCap> {
        let mut sides: Vec<Side> =
            triangles.iter().enumerate().flat_map(|(i, t)| sides_of(t).map(|side| (side, i))).collect();
        sides.sort_unstable();
        if sides.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return Err(NoCap);
        }
        sides.iter().for_each(|(side, _)| self.found(*side));
        let paired = |[a, b]: [u32; 2]| sides.binary_search_by_key(&[b, a], |(side, _)| *side).is_ok();
        let lonely = |side: &[u32; 2]| !self.ends[self.leaving(side[0])].contains(&side[1]) && !paired(*side);
        let mut lonely: Vec<Side> = sides.iter().copied().filter(|(side, _)| lonely(side)).collect();
        for a in 0..self.first.len() as u32 - 1 {
            while let Some(b) = self.leaving(a).filter(|&e| self.missing[e]).map(|e| self.ends[e]).min() {
                // The stretch begins somewhere before this edge, at the foot of a side without a partner.
                let stands_for =
                    |(side, _): &Side| self.stretch(side).filter(|way| way.windows(2).any(|step| step == [a, b]));
                let (at, way) =
                    lonely.iter().enumerate().find_map(|(i, s)| stands_for(s).map(|way| (i, way))).ok_or(NoCap)?;
                let (side, index) = lonely.remove(at);
                let apex = triangles[index].into_iter().find(|v| !side.contains(v)).ok_or(NoCap)?;
                for (k, step) in way.windows(2).enumerate() {
                    let place = if k == 0 { index } else { triangles.len() };
                    if k > 0 {
                        triangles.push([0; 3]);
                    }
                    triangles[place] = [step[0], step[1], apex];
                    self.found([step[0], step[1]]);
                    for side in sides_of(&triangles[place]) {
                        lonely.iter_mut().filter(|(other, _)| *other == side).for_each(|(_, of)| *of = place);
                    }
                }
            }
        }
        Ok(())
    }

    /// The way along the rim from one end of `side` to the other over edges that no triangle has yet.
    fn stretch(&self, side: &[u32; 2]) -> Option<Vec<u32>> {
        let mut here = side[0];
        let mut way = Vec::new();
        while here != side[1] {
            let edge = self.leaving(here).find(|&e| self.missing[e])?;
            way.push(here);
            here = self.ends[edge];
            if way.contains(&here) {
                return None;
            }
        }
        way.push(here);
        Some(way)
    }
}

/// Gives a triangle whose one corner lies on the opposite side the far corner of the triangle across that side instead: later cuts
/// would make vertices that coincide of thin ones. A surface's own facets are mended only for who looks at them: see `overhang::slivers`.
fn flip_slivers(triangles: &mut [[u32; 3]], place: &[Flat]) {
    if triangles.iter().all(|t| sliver(t, place).is_none()) {
        return;
    }
    let mut across = sides_of_all(triangles);
    let mut todo: Vec<usize> = (0..triangles.len()).collect();
    let mut left = 8 * triangles.len();
    while let Some(index) = todo.pop().filter(|_| left > 0) {
        left -= 1;
        let Some([v, a, b]) = sliver(&triangles[index], place) else { continue };
        let Some(&other) = across.get(&[b, a]).filter(|&&other| other != index) else { continue };
        let Some(far) = triangles[other].into_iter().find(|c| *c != a && *c != b) else { continue };
        let halves = [[v, a, far], [v, far, b]];
        // Only where both come out the right way round, and no side is there twice.
        let sound = halves.iter().all(|t| signed_area(&t.map(|i| place[i as usize])) > 0.0);
        if !sound || far == v || across.contains_key(&[v, far]) || across.contains_key(&[far, v]) {
            continue;
        }
        for side in [[a, b], [b, a]] {
            across.remove(&side);
        }
        (triangles[index], triangles[other]) = (halves[0], halves[1]);
        for place in [index, other] {
            sides_of(&triangles[place]).iter().for_each(|side| _ = across.insert(*side, place));
            todo.push(place);
        }
    }
}

/// The sides of a triangle, in its sense.
pub(crate) fn sides_of(t: &[u32; 3]) -> [[u32; 2]; 3] {
    [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]
}

fn sides_of_all(triangles: &[[u32; 3]]) -> EdgeMap<usize> {
    let sides = triangles.iter().enumerate().flat_map(|(i, t)| sides_of(t).map(|side| (side, i)));
    sides.collect()
}

/// The corner that lies on the opposite side, and that side's ends.
fn sliver(triangle: &[u32; 3], place: &[Flat]) -> Option<[u32; 3]> {
    let across = |a: u32, b: u32| {
        let (p, q) = (place[a as usize], place[b as usize]);
        [p[0] - q[0], p[1] - q[1]]
    };
    let turns = [0, 1, 2].map(|i| [triangle[i], triangle[(i + 1) % 3], triangle[(i + 2) % 3]]);
    let area = signed_area(&triangle.map(|i| place[i as usize]));
    let squares = turns.map(|t| across(t[1], t[2]).map(|d| d * d).iter().sum::<f64>());
    // Most are plainly none, which squares tell at a tenth of the time.
    let limit = THIN_MM * THIN_MM * squares.into_iter().fold(0.0, f64::max);
    if area > 0.0 && 4.0 * area * area > 1.001 * limit {
        return None;
    }
    let length = |t: &[u32; 3]| {
        let [x, y] = across(t[1], t[2]);
        x.hypot(y)
    };
    let widest = turns.into_iter().max_by(|s, t| length(s).total_cmp(&length(t)))?;
    (2.0 * area < THIN_MM * length(&widest)).then_some(widest)
}
