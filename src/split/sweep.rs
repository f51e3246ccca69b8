//! What every plane of one direction would take away and put on, without cutting: one descending sweep.
//!
//! Going down along the direction, vertices come in and edges join them (the join tree of the height): at every offset the sets
//! are the solids beyond the plane. What each of them has beyond is summed up exactly, from the parts of the facets that lie
//! there: the area that needs support as it stands, which cutting takes away, and the area that will need it along the new
//! direction, which stays for good; beginnings and ridges likewise.

use super::clip::ON_PLANE_MM;
use super::measure::{MeasureRules, Measured, PieceNeeds, share_above};
use crate::geom::{Sets, Vec3};
use crate::overhang::Ridge;

/// A solid beyond a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Beyond {
    /// Its highest vertex, which names it.
    pub(super) top: u32,
    /// How far that lies beyond the plane, mm.
    pub(super) height_mm: f64,
    /// What it needs as it stands.
    pub(super) before: PieceNeeds,
    /// What it will need along the plane's normal.
    pub(super) after: PieceNeeds,
}

/// Whatever of a surface needs support along +z, found once for all directions.
pub(super) struct Upright {
    risky: Vec<u32>,
    /// The risky facets by patches, the largest first.
    pub(super) patches: Vec<Vec<u32>>,
    beginnings: Vec<u32>,
    ridges: Vec<Ridge>,
    pub(super) needs: PieceNeeds,
}

impl Upright {
    pub(super) fn of(part: &Measured, rules: &MeasureRules) -> Self {
        let up = Vec3::z();
        let risky =
            (0..part.area.len()).filter(|&f| part.is_risky(f, &up, rules) && !part.on_table[f]).map(|f| f as u32);
        let beginnings = part.beginnings(&part.heights(&up, None), &up, None, rules);
        let ridges = part.ridges(&up, Some(None), rules);
        let risky: Vec<u32> = risky.collect();
        let patches = part.patches(&risky);
        Self { risky, patches, beginnings, ridges, needs: part.needs(&up, None, rules) }
    }

    /// Vertices that begin in the air.
    pub(super) fn beginnings(&self) -> &[u32] {
        &self.beginnings
    }

    /// Runs that hang too far.
    pub(super) fn ridges(&self) -> &[Ridge] {
        &self.ridges
    }
}

/// Numbers by the first of some descending offsets beyond which they lie.
struct Layered {
    /// Of offset `i`: `numbers[first[i]..first[i + 1]]`.
    first: Vec<u32>,
    numbers: Vec<u32>,
}

impl Layered {
    fn of(heights: &[f64], offsets: &[f64]) -> Self {
        let at = |h: &f64| offsets.partition_point(|c| *h <= c + ON_PLANE_MM);
        let places: Vec<u32> = heights.iter().map(|h| at(h) as u32).collect();
        // What lies before the last offset comes behind it, and is never asked for.
        let mut first = vec![0_u32; offsets.len() + 2];
        places.iter().for_each(|&at| first[at as usize + 1] += 1);
        (1..first.len()).for_each(|i| first[i] += first[i - 1]);
        let mut next = first.clone();
        let mut numbers = vec![0; heights.len()];
        for (number, &at) in places.iter().enumerate() {
            numbers[next[at as usize] as usize] = number as u32;
            next[at as usize] += 1;
        }
        Self { first, numbers }
    }

    fn at(&self, offset: usize) -> &[u32] {
        &self.numbers[self.first[offset] as usize..self.first[offset + 1] as usize]
    }
}

/// Facets that need support, on their way through the offsets.
struct SweptFacets {
    order: Layered,
    /// Those that the offset crosses.
    crossing: Vec<u32>,
    /// A vertex of a solid beyond, and the area of its facets that lie wholly beyond, mm².
    whole: Vec<(u32, f64)>,
}

/// One direction's sweep over one surface.
pub(super) struct Sweep<'a> {
    part: &'a Measured,
    upright: &'a Upright,
    pub(super) heights: Vec<f64>,
    risky: Vec<u32>,
    beginnings: Vec<u32>,
    ridges: Vec<Ridge>,
    sets: Sets,
    /// By root: where its sums are, if `stamp` says so.
    slot: Vec<(u32, u32)>,
}

impl<'a> Sweep<'a> {
    pub(super) fn new(part: &'a Measured, upright: &'a Upright, up: &Vec3, rules: &MeasureRules) -> Self {
        let heights: Vec<f64> = part.surface.vertices.iter().map(|v| v.dot(up)).collect();
        let risky = (0..part.area.len()).filter(|&f| part.is_risky(f, up, rules)).map(|f| f as u32).collect();
        let beginnings = part.beginnings(&heights, up, None, rules);
        let ridges = part.ridges(up, None, rules);
        let sets = Sets::new(heights.len());
        let slot = vec![(0, 0); heights.len()];
        Self { part, upright, heights, risky, beginnings, ridges, sets, slot }
    }

    /// Calls `each` with every one of `offsets` (descending) and the solids beyond it.
    pub(super) fn run(&mut self, offsets: &[f64], mut each: impl FnMut(f64, &[Beyond])) {
        self.sets.reset();
        let order = Layered::of(&self.heights, offsets);
        let mut facets = [true, false].map(|standing| self.layered(standing, offsets));
        let mut tops: Vec<u32> = Vec::new();
        let mut found: Vec<Beyond> = Vec::new();
        for (stamp, &c) in offsets.iter().enumerate() {
            found.clear();
            let known = tops.len();
            for &v in order.at(stamp) {
                let mut alone = true;
                for &w in self.part.around(v as usize) {
                    if self.heights[w as usize] > c + ON_PLANE_MM {
                        alone &= (self.heights[w as usize], v) < (self.heights[v as usize], w);
                        self.sets.join(v, w);
                    }
                }
                if alone {
                    tops.push(v);
                }
            }
            let (sets, slot, heights) = (&mut self.sets, &mut self.slot, &self.heights);
            tops[known..]
                .sort_unstable_by(|&a, &b| heights[b as usize].total_cmp(&heights[a as usize]).then(a.cmp(&b)));
            let stamp = stamp as u32 + 1;
            // In order of height, the first of a set is its top; those that were joined to a higher one go.
            tops.retain(|&v| {
                let root = sets.root(v) as usize;
                let new = slot[root].0 != stamp;
                if new {
                    slot[root] = (stamp, found.len() as u32);
                    let (before, after) = (PieceNeeds::default(), PieceNeeds::default());
                    found.push(Beyond { top: v, height_mm: heights[v as usize] - c, before, after });
                }
                new
            });
            for (which, facets) in facets.iter_mut().enumerate() {
                self.sum_facets(c, stamp as usize - 1, which == 0, facets, &mut found);
            }
            self.sum_faults(c, &mut found);
            each(c, &found);
        }
        self.slot.iter_mut().for_each(|slot| *slot = (0, 0));
    }

    /// The solid of `vertex`, which must lie beyond.
    fn solid(&mut self, vertex: u32) -> usize {
        let root = self.sets.root(vertex);
        self.slot[root as usize].1 as usize
    }

    /// The facets that need support, as it stands or along the new direction, by where the sweep meets them.
    fn layered(&self, standing: bool, offsets: &[f64]) -> SweptFacets {
        let facets = if standing { &self.upright.risky } else { &self.risky };
        let highest = |&f: &u32| {
            let corners = self.part.surface.facets[f as usize];
            corners.iter().map(|v| self.heights[*v as usize]).fold(f64::NEG_INFINITY, f64::max)
        };
        let tops: Vec<f64> = facets.iter().map(highest).collect();
        SweptFacets { order: Layered::of(&tops, offsets), crossing: Vec::new(), whole: Vec::new() }
    }

    /// Adds the area of facets beyond `c`. One that lies wholly beyond is summed up once, with those of its solid at that offset, and
    /// goes with a vertex of theirs from then on.
    fn sum_facets(&mut self, c: f64, stamp: usize, standing: bool, swept: &mut SweptFacets, found: &mut [Beyond]) {
        let (part, upright) = (self.part, self.upright);
        let new = swept.order.at(stamp).iter();
        swept.crossing.extend(new.map(|&i| if standing { upright.risky[i as usize] } else { self.risky[i as usize] }));
        let mut solids = std::mem::take(&mut swept.whole);
        solids.iter_mut().for_each(|(vertex, _)| *vertex = self.solid(*vertex) as u32);
        let mut whole = vec![0.0; found.len()];
        solids.iter().for_each(|&(solid, area)| whole[solid as usize] += area);
        let mut crossing = vec![0.0; found.len()];
        swept.crossing.retain(|&facet| {
            let corners = part.surface.facets[facet as usize];
            let heights = corners.map(|v| self.heights[v as usize]);
            let top = (0..3).max_by(|&a, &b| heights[a].total_cmp(&heights[b])).unwrap_or(0);
            let solid = self.solid(corners[top]);
            let share = share_above(heights, c);
            let sums = if share >= 1.0 { &mut whole } else { &mut crossing };
            sums[solid] += part.area[facet as usize] * share;
            share < 1.0
        });
        for (one, (whole, crossing)) in found.iter_mut().zip(whole.iter().zip(&crossing)) {
            let needs = if standing { &mut one.before } else { &mut one.after };
            needs.area_mm2 += whole + crossing;
        }
        swept.whole.extend(found.iter().zip(whole).filter(|(_, area)| *area > 0.0).map(|(one, area)| (one.top, area)));
    }

    fn sum_faults(&mut self, c: f64, found: &mut [Beyond]) {
        let upright = self.upright;
        let above = c + ON_PLANE_MM;
        for &v in &upright.beginnings {
            if self.heights[v as usize] > above {
                let solid = self.solid(v);
                found[solid].before.beginnings += 1;
            }
        }
        for i in 0..self.beginnings.len() {
            let v = self.beginnings[i];
            if self.heights[v as usize] > above {
                let solid = self.solid(v);
                found[solid].after.beginnings += 1;
            }
        }
        for standing in [true, false] {
            let count = if standing { upright.ridges.len() } else { self.ridges.len() };
            for i in 0..count {
                let ridge = if standing { &upright.ridges[i] } else { &self.ridges[i] };
                let (beyond, before, top) = self.parted(ridge, c);
                // Taken away where what stays is short enough; brought along where what goes is too long.
                let counts = if standing { before <= ridge.allowed_mm } else { beyond > ridge.allowed_mm };
                if counts && self.heights[top as usize] > above {
                    let solid = self.solid(top);
                    let needs = if standing { &mut found[solid].before } else { &mut found[solid].after };
                    needs.ridges += 1;
                }
            }
        }
    }

    /// The lengths of a run beyond and before the plane, and its highest vertex.
    fn parted(&self, ridge: &Ridge, c: f64) -> (f64, f64, u32) {
        let (mut beyond, mut before, mut top) = (0.0, 0.0, ridge.edges[0][0]);
        for &ends in &ridge.edges {
            let [a, b] = ends.map(|v| self.heights[v as usize]);
            let length = self.part.length(ends);
            let share = ((a.max(b) - c) / (a - b).abs().max(1e-9)).clamp(0.0, 1.0);
            beyond += share * length;
            before += (1.0 - share) * length;
            let higher = |v: u32, w: u32| if self.heights[w as usize] > self.heights[v as usize] { w } else { v };
            top = higher(higher(top, ends[0]), ends[1]);
        }
        (beyond, before, top)
    }
}

/// By offset (descending): whether all that would be left after taking everything beyond hangs together with the table.
pub(super) fn footing(part: &Measured, up: &Vec3, heights: &[f64], offsets: &[f64]) -> Vec<bool> {
    let mut standing = vec![false; heights.len()];
    for facet in (0..part.area.len()).filter(|&f| part.on_table[f]) {
        part.surface.facets[facet].iter().for_each(|v| standing[*v as usize] = true);
    }
    let mut sets = Sets::new(heights.len());
    let mut bottoms: Vec<u32> = Vec::new();
    // Upside down, the sweep goes up.
    let depths: Vec<f64> = heights.iter().map(|h| -h).collect();
    let turned: Vec<f64> = offsets.iter().rev().map(|c| -c).collect();
    let order = Layered::of(&depths, &turned);
    let mut good = vec![true; offsets.len()];
    for (i, &c) in offsets.iter().enumerate().rev() {
        let below = |v: u32| heights[v as usize] < c - ON_PLANE_MM;
        let new = order.at(offsets.len() - 1 - i);
        for &v in new {
            let mut own = sets.root(v);
            for &w in part.around(v as usize).iter().filter(|w| below(**w)) {
                let other = sets.root(w);
                if own != other {
                    let stands = standing[own as usize] || standing[other as usize];
                    own = sets.join(own, other);
                    standing[own as usize] = stands;
                }
            }
        }
        bottoms.extend(new);
        bottoms.retain(|&v| sets.root(v) == v);
        // The inner wall of something hollow is bound by the rim of a hole, and stands with the outer one.
        let stands = |root: u32| standing[root as usize] || rim_mm2(part, up, c, &[root], &below) <= ON_PLANE_MM;
        good[i] = bottoms.iter().all(|&root| stands(root));
    }
    good
}

/// The area of the caps that would close the solids of `tops` beyond `c`, mm²; faces that lie in the plane count as cap.
pub(super) fn seam_mm2(part: &Measured, up: &Vec3, c: f64, tops: &[u32]) -> f64 {
    let beyond = |v: u32| part.surface.vertices[v as usize].dot(up) > c + ON_PLANE_MM;
    rim_mm2(part, up, c, tops, &beyond).abs()
}

/// The area within the rim of the surface that hangs together with `from` on the one `side` of the plane, mm²; counted as
/// negative where the rim runs around a hole.
fn rim_mm2(part: &Measured, up: &Vec3, c: f64, from: &[u32], side: &dyn Fn(u32) -> bool) -> f64 {
    let mut seen = vec![false; part.surface.vertices.len()];
    let mut stack: Vec<u32> = from.to_vec();
    let mut rim: Vec<u32> = Vec::new();
    while let Some(v) = stack.pop() {
        if std::mem::replace(&mut seen[v as usize], true) {
            continue;
        }
        let mut inside = true;
        for &w in part.around(v as usize) {
            let beside = side(w);
            inside &= beside;
            if beside && !seen[w as usize] {
                stack.push(w);
            }
        }
        if !inside {
            rim.extend(part.facets_at(v as usize));
        }
    }
    rim.sort_unstable();
    rim.dedup();
    let height = |v: u32| part.surface.vertices[v as usize].dot(up) - c;
    let mut sum = 0.0;
    for index in rim {
        let facet = part.surface.facets[index as usize];
        let mut ends = Vec::with_capacity(2);
        for i in 0..3 {
            let (a, b) = (facet[i], facet[(i + 1) % 3]);
            if side(a) != side(b) {
                let [p, q] = [a, b].map(|v| part.surface.vertices[v as usize]);
                let (ha, hb) = (height(a), height(b));
                ends.push(p + (q - p) * (ha / (ha - hb)).clamp(0.0, 1.0));
            }
        }
        if let [p, q] = ends[..] {
            let along = up.cross(&part.normal[index as usize]);
            let sign = if (q - p).dot(&along) > 0.0 { 0.5 } else { -0.5 };
            sum += sign * up.dot(&p.cross(&q));
        }
    }
    sum
}
