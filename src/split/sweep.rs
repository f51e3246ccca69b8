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
        Self { risky: risky.collect(), beginnings, ridges, needs: part.needs(&up, None, rules) }
    }

    /// Facets that need support.
    pub(super) fn risky(&self) -> &[u32] {
        &self.risky
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

/// One direction's sweep over one surface.
pub(super) struct Sweep<'a> {
    part: &'a Measured,
    upright: &'a Upright,
    pub(super) heights: Vec<f64>,
    /// Vertices, highest first.
    pub(super) order: Vec<u32>,
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
        let mut order: Vec<u32> = (0..heights.len() as u32).collect();
        order.sort_unstable_by(|&a, &b| heights[b as usize].total_cmp(&heights[a as usize]).then(a.cmp(&b)));
        let risky = (0..part.area.len()).filter(|&f| part.is_risky(f, up, rules)).map(|f| f as u32).collect();
        let beginnings = part.beginnings(&heights, up, None, rules);
        let ridges = part.ridges(up, None, rules);
        let sets = Sets::new(heights.len());
        let slot = vec![(0, 0); heights.len()];
        Self { part, upright, heights, order, risky, beginnings, ridges, sets, slot }
    }

    /// Calls `each` with every one of `offsets` (descending) and the solids beyond it.
    pub(super) fn run(&mut self, offsets: &[f64], mut each: impl FnMut(f64, &[Beyond])) {
        self.sets.reset();
        let mut next = 0;
        let mut tops: Vec<u32> = Vec::new();
        let mut found: Vec<Beyond> = Vec::new();
        for (stamp, &c) in offsets.iter().enumerate() {
            found.clear();
            while let Some(&v) = self.order.get(next).filter(|v| self.heights[**v as usize] > c + ON_PLANE_MM) {
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
                next += 1;
            }
            let stamp = stamp as u32 + 1;
            // In order of height, the first of a set is its top; those that were joined to a higher one go.
            let (sets, slot, heights) = (&mut self.sets, &mut self.slot, &self.heights);
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
            self.sum(c, &mut found);
            each(c, &found);
        }
        self.slot.iter_mut().for_each(|slot| *slot = (0, 0));
    }

    /// The solid of `vertex`, which must lie beyond.
    fn solid(&mut self, vertex: u32) -> usize {
        let root = self.sets.root(vertex);
        self.slot[root as usize].1 as usize
    }

    fn sum(&mut self, c: f64, found: &mut [Beyond]) {
        let (part, upright) = (self.part, self.upright);
        let above = c + ON_PLANE_MM;
        let highest = |heights: &[f64], corners: &[u32]| {
            corners.iter().copied().max_by(|&a, &b| heights[a as usize].total_cmp(&heights[b as usize])).unwrap_or(0)
        };
        for standing in [true, false] {
            let count = if standing { upright.risky.len() } else { self.risky.len() };
            for i in 0..count {
                let facet = if standing { upright.risky[i] } else { self.risky[i] } as usize;
                let corners = part.surface.facets[facet];
                let top = highest(&self.heights, &corners);
                if self.heights[top as usize] <= above {
                    continue;
                }
                let area = part.area[facet] * share_above(corners.map(|v| self.heights[v as usize]), c);
                let solid = self.solid(top);
                let needs = if standing { &mut found[solid].before } else { &mut found[solid].after };
                needs.area_mm2 += area;
            }
        }
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
pub(super) fn footing(part: &Measured, up: &Vec3, heights: &[f64], order: &[u32], offsets: &[f64]) -> Vec<bool> {
    let mut standing = vec![false; heights.len()];
    for facet in (0..part.area.len()).filter(|&f| part.on_table[f]) {
        part.surface.facets[facet].iter().for_each(|v| standing[*v as usize] = true);
    }
    let mut sets = Sets::new(heights.len());
    let mut bottoms: Vec<u32> = Vec::new();
    let mut rising = order.iter().rev().copied().peekable();
    let mut good = vec![true; offsets.len()];
    for (i, &c) in offsets.iter().enumerate().rev() {
        let below = |v: u32| heights[v as usize] < c - ON_PLANE_MM;
        while let Some(v) = rising.next_if(|v| below(*v)) {
            for &w in part.around(v as usize).iter().filter(|w| below(**w)) {
                let stands = [v, w].into_iter().any(|x| standing[sets.root(x) as usize]);
                let root = sets.join(v, w);
                standing[root as usize] = stands;
            }
            bottoms.push(v);
        }
        bottoms.retain(|&v| sets.root(v) == v);
        for &root in bottoms.iter().filter(|r| !standing[**r as usize]) {
            // The inner wall of something hollow is bound by the rim of a hole, and stands with the outer one.
            good[i] &= rim_mm2(part, up, c, &[root], &below) <= ON_PLANE_MM;
        }
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
    while let Some(v) = stack.pop() {
        if !std::mem::replace(&mut seen[v as usize], true) {
            stack.extend(part.around(v as usize).iter().filter(|w| !seen[**w as usize] && side(**w)));
        }
    }
    let height = |v: u32| part.surface.vertices[v as usize].dot(up) - c;
    let mut sum = 0.0;
    for (index, facet) in part.surface.facets.iter().enumerate() {
        if !facet.iter().any(|v| seen[*v as usize]) || facet.iter().all(|v| side(*v)) {
            continue;
        }
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
            let along = up.cross(&part.normal[index]);
            let sign = if (q - p).dot(&along) > 0.0 { 0.5 } else { -0.5 };
            sum += sign * up.dot(&p.cross(&q));
        }
    }
    sum
}
