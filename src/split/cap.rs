//! The cap that closes a cut: loops of edges in a plane, which lies in which, and their triangles.
//!
//! Both sides of the cut get the same triangles over the same vertices, one of them turned over, so that they fit each other bit
//! for bit. Every vertex of a loop stays a corner, those in the middle of a straight stretch too: the facets beside it end there.
//! The triangles are `earcut`'s; what it leaves out is put back, and a cap that does not close its loops is none.

use std::collections::{BTreeMap, HashMap, HashSet};

use earcut::Earcut;

use crate::geom::Vec3;

/// A connected piece of a cap.
#[derive(Clone, Debug)]
pub(super) struct CapPatch {
    /// Corners, counter-clockwise seen from the side that the cap faces.
    pub(super) triangles: Vec<[u32; 3]>,
    /// mm².
    pub(super) area_mm2: f64,
    /// One vertex of each loop around it.
    pub(super) of_loops: Vec<u32>,
}

/// The loops cannot be capped: they touch themselves, or have no area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NoCap;

type Flat = [f64; 2];

struct Loop {
    vertices: Vec<u32>,
    flat: Vec<Flat>,
    /// mm²; negative for the rim of a hole.
    area: f64,
}

/// The patches that close the directed `edges` of a cap facing `facing`: each edge is run along by one triangle, in its sense.
pub(super) fn patches(vertices: &[Vec3], edges: &[[u32; 2]], facing: &Vec3) -> Result<Vec<CapPatch>, NoCap> {
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
pub(super) fn axes(facing: &Vec3) -> [Vec3; 2] {
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
    let number: Vec<u32> = rings().flat_map(|l| l.vertices.iter().copied()).collect();
    let flat: Vec<Flat> = rings().flat_map(|l| l.flat.iter().copied()).collect();
    let mut starts: Vec<u32> = Vec::new();
    let mut at = outer.vertices.len() as u32;
    for hole in holes {
        starts.push(at);
        at += hole.vertices.len() as u32;
    }
    let mut corners: Vec<u32> = Vec::new();
    Earcut::new().earcut(flat.iter().copied(), &starts, &mut corners);
    let place: HashMap<u32, Flat> = number.iter().copied().zip(flat).collect();
    let mut triangles: Vec<[u32; 3]> =
        corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|i| number[i as usize])).collect();
    // All turn the same way; one alone says nothing, since its area may be rounding.
    if triangles.iter().map(|t| signed_area(&t.map(|i| place[&i]))).sum::<f64>() < 0.0 {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let mut triangles = with_left_out(triangles, rings())?;
    flip_slivers(&mut triangles, &place);
    let area_mm2 = outer.area + holes.iter().map(|h| h.area).sum::<f64>();
    let covered: f64 = triangles.iter().map(|t| signed_area(&t.map(|i| place[&i]))).sum();
    if (covered - area_mm2).abs() > 1e-9 * (1.0 + outer.area) {
        return Err(NoCap);
    }
    Ok(CapPatch { triangles, area_mm2, of_loops: rings().map(|l| l.vertices[0]).collect() })
}

/// Puts back the corners in the middle of straight stretches: a side that neither runs along the rim nor has a partner
/// stands for the stretch of the rim between its ends.
fn with_left_out<'a>(
    mut triangles: Vec<[u32; 3]>,
    rings: impl Iterator<Item = &'a Loop>,
) -> Result<Vec<[u32; 3]>, NoCap> {
    let mut next: HashMap<u32, Vec<u32>> = HashMap::new();
    let mut missing: HashSet<[u32; 2]> = HashSet::new();
    for ring in rings {
        for i in 0..ring.vertices.len() {
            let (a, b) = (ring.vertices[i], ring.vertices[(i + 1) % ring.vertices.len()]);
            next.entry(a).or_default().push(b);
            missing.insert([a, b]);
        }
    }
    let mut sides: HashMap<[u32; 2], usize> = HashMap::new();
    for (index, triangle) in triangles.iter().enumerate() {
        for side in sides_of(triangle) {
            missing.remove(&side);
            if sides.insert(side, index).is_some() {
                return Err(NoCap);
            }
        }
    }
    while let Some(&[a, b]) = missing.iter().min() {
        // The stretch begins somewhere before this edge, at the foot of a side without a partner.
        let stands_for = |side: &[u32; 2]| {
            let lonely =
                !sides.contains_key(&[side[1], side[0]]) && !next.get(&side[0]).is_some_and(|n| n.contains(&side[1]));
            if lonely { stretch(side, &next, &missing).filter(|s| s.windows(2).any(|w| w == [a, b])) } else { None }
        };
        let mut lonely: Vec<&[u32; 2]> = sides.keys().collect();
        lonely.sort_unstable();
        let (side, way) = lonely.into_iter().find_map(|s| stands_for(s).map(|way| (*s, way))).ok_or(NoCap)?;
        let index = sides[&side];
        let old = triangles[index];
        let apex = old.into_iter().find(|v| !side.contains(v)).ok_or(NoCap)?;
        sides_of(&old).iter().for_each(|s| _ = sides.remove(s));
        for (k, step) in way.windows(2).enumerate() {
            let new = [step[0], step[1], apex];
            let place = if k == 0 { index } else { triangles.len() };
            if k == 0 {
                triangles[index] = new
            } else {
                triangles.push(new)
            }
            missing.remove(&[step[0], step[1]]);
            for s in sides_of(&new) {
                sides.insert(s, place);
            }
        }
    }
    Ok(triangles)
}

/// Thinner triangles are turned into others where that can be, mm: later cuts would make vertices that coincide of them.
const SLIVER_MM: f64 = 1e-3;

/// Gives a triangle whose one corner lies on the opposite side the far corner of the triangle across that side instead.
fn flip_slivers(triangles: &mut [[u32; 3]], place: &HashMap<u32, Flat>) {
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
        let sound = halves.iter().all(|t| signed_area(&t.map(|i| place[&i])) > 0.0);
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

fn sides_of(t: &[u32; 3]) -> [[u32; 2]; 3] {
    [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]
}

fn sides_of_all(triangles: &[[u32; 3]]) -> HashMap<[u32; 2], usize> {
    let sides = triangles.iter().enumerate().flat_map(|(i, t)| sides_of(t).map(|side| (side, i)));
    sides.collect()
}

/// The corner that lies on the opposite side, and that side's ends.
fn sliver(triangle: &[u32; 3], place: &HashMap<u32, Flat>) -> Option<[u32; 3]> {
    let length = |a: u32, b: u32| {
        let (p, q) = (place[&a], place[&b]);
        (p[0] - q[0]).hypot(p[1] - q[1])
    };
    let turns = (0..3).map(|i| [triangle[i], triangle[(i + 1) % 3], triangle[(i + 2) % 3]]);
    let widest = turns.max_by(|s, t| length(s[1], s[2]).total_cmp(&length(t[1], t[2])))?;
    let area = signed_area(&triangle.map(|i| place[&i]));
    (2.0 * area < SLIVER_MM * length(widest[1], widest[2])).then_some(widest)
}

/// The way along the rim from one end of `side` to the other over edges that no triangle has yet.
fn stretch(side: &[u32; 2], next: &HashMap<u32, Vec<u32>>, missing: &HashSet<[u32; 2]>) -> Option<Vec<u32>> {
    let mut way = vec![side[0]];
    while *way.last()? != side[1] {
        let here = *way.last()?;
        let onward = next.get(&here)?.iter().copied().find(|&b| missing.contains(&[here, b]))?;
        if way.contains(&onward) {
            return None;
        }
        way.push(onward);
    }
    Some(way)
}
