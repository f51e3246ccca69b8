//! Facets so thin that their normal means nothing, and which real facets lie on both sides of them.
//!
//! Three corners on a line, or two corners in one place: files of CAD programs and the caps of cuts are full of them. Who asks which
//! way the surface bends along an edge must look past them:
//!
//! ```text
//!        d                      d
//!      /   \                  / | \
//!     /  N  \                /  |  \
//!    a ----- b     flip     a N | N b      T = (a, b, c) has no height; its longest side is N's too.
//!     `- T -'     ----->     `- c -'       Both facets made of them have the normal of N.
//!         c
//! ```
//!
//! Flips are of edges only: every vertex stays where it is. A thin facet beside a thin one waits until that one is done; two that
//! share their longest sides are flipped with each other, which makes their common side shorter, so that it ends.
//!
//! Lengths mm.

use crate::geom::Vec3;
use crate::mesh::THIN_MM;

/// A surface's facets as given, and who is about a vertex.
pub(super) struct Given<'a> {
    pub(super) vertices: &'a [Vec3],
    pub(super) facets: &'a [[u32; 3]],
    /// Of vertex `i`: `about[first[i]..first[i + 1]]`.
    pub(super) first: &'a [u32],
    pub(super) about: &'a [u32],
}

impl Given<'_> {
    fn length(&self, [a, b]: [u32; 2]) -> f64 {
        (self.vertices[a as usize] - self.vertices[b as usize]).norm()
    }

    /// The corners from the longest side on; of sides as long as each other, the same one whoever asks.
    fn longest_first(&self, [a, b, c]: [u32; 3]) -> [u32; 3] {
        let key = |turned: &[u32; 3]| {
            (self.length([turned[0], turned[1]]), turned[0].min(turned[1]), turned[0].max(turned[1]))
        };
        let longer = |x: &[u32; 3], y: &[u32; 3]| {
            let ((a, from, to), (b, other_from, other_to)) = (key(x), key(y));
            a.total_cmp(&b).then((from, to).cmp(&(other_from, other_to)))
        };
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().max_by(longer).unwrap_or([a, b, c])
    }

    fn is_thin(&self, facet: u32, area_mm2: f64) -> bool {
        let [a, b, c] = self.facets[facet as usize].map(|v| self.vertices[v as usize]);
        let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
        4.0 * area_mm2 * area_mm2 < THIN_MM * THIN_MM * longest
    }
}

/// A side of two facets: its ends as the first one runs along it, and the facets that the two have the normals of.
pub(super) type Side = ([u32; 2], [u32; 2]);

const OWN: u32 = u32::MAX;
const NONE: u32 = u32::MAX;

/// What lies where thin facets lay.
pub(super) struct Mended<'a> {
    given: Given<'a>,
    /// By facet: its corners now.
    corners: Vec<[u32; 3]>,
    /// By facet: the one that it has the normal of; [`OWN`] for a facet as it was given.
    like: Vec<u32>,
    /// Facets about a vertex that were not about it: the facet, and the place of the vertex's next, or [`NONE`].
    joined: Vec<(u32, u32)>,
    /// By vertex: the place of its last in `joined`, or [`NONE`].
    last_joined: Vec<u32>,
    /// By facet: thin, and left.
    is_thin: Vec<bool>,
    /// Pairs of corners in one place.
    pub(super) one_place: Vec<[u32; 2]>,
}

impl<'a> Mended<'a> {
    /// `None` where no facet is thin; `area_mm2` by facet.
    pub(super) fn of(given: Given<'a>, area_mm2: &[f64]) -> Option<Self> {
        let is_thin: Vec<bool> = (0..).zip(area_mm2).map(|(f, area)| given.is_thin(f, *area)).collect();
        let mut thin: Vec<u32> = (0..).zip(&is_thin).filter(|(_, is_thin)| **is_thin).map(|(f, _)| f).collect();
        if thin.is_empty() {
            return None;
        }
        let sides = thin.iter().map(|f| given.facets[*f as usize]).flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
        let one_place = sides.filter(|ends| given.length(*ends) < THIN_MM).collect();
        let (corners, like) = (given.facets.to_vec(), vec![OWN; given.facets.len()]);
        let last_joined = vec![NONE; given.vertices.len()];
        let mut mended = Self { given, corners, like, joined: Vec::new(), last_joined, is_thin, one_place };
        // Each step but those between two thin facets does away with one, or leads on to it. What is in the way of one is often gone
        // when the others are.
        let mut steps_left = 8 * thin.len();
        while steps_left > 0 {
            let flipped = |facet: &u32| mended.do_away_with(*facet, &mut steps_left);
            if !thin.iter().map(flipped).fold(false, |any, one| any | one) {
                break;
            }
            thin.retain(|facet| mended.is_thin[*facet as usize]);
        }
        Some(mended)
    }

    /// From `facet` over longest sides to one beside a real facet, which goes first; whether anything was flipped.
    fn do_away_with(&mut self, facet: u32, steps_left: &mut usize) -> bool {
        let mut path = vec![facet];
        let mut flipped = false;
        while let Some(&facet) = path.last() {
            if !self.is_thin(facet) {
                path.pop();
                continue;
            }
            let [a, b, _] = self.given.longest_first(self.corners(facet));
            let Some(beyond) = self.across(facet, [a, b]).filter(|_| *steps_left > 0) else { break };
            *steps_left -= 1;
            let waits = self.is_thin(beyond) && self.given.longest_first(self.corners(beyond))[..2] != [b, a];
            if waits {
                path.push(beyond);
            } else if self.flip(facet, beyond) {
                flipped = true;
            } else {
                break;
            }
        }
        flipped
    }

    /// The longest side of the thin `facet` gives way to that between the corners beyond its ends, or, where there is such a side, the
    /// corner at its end that only three facets are about goes; false if there is none.
    fn flip(&mut self, facet: u32, beyond: u32) -> bool {
        let [a, b, c] = self.given.longest_first(self.corners(facet));
        let Some(d) = self.corners(beyond).into_iter().find(|v| ![a, b].contains(v)) else { return false };
        // Of two thin facets the side between them gets shorter, or it would go to and fro.
        let to_and_fro = self.is_thin(beyond) && self.given.length([c, d]) >= self.given.length([a, b]);
        if c == d || to_and_fro {
            return false;
        }
        let across: Vec<u32> = self.with_both([c, d]).collect();
        if let Some(first) = across.first() {
            let at_end = |f: &&u32| self.corners(**f).iter().any(|v| [a, b].contains(v));
            let third = *across.iter().find(at_end).unwrap_or(first);
            return self.merge([facet, beyond, third], [a, b, c, d]);
        }
        let like = self.like(beyond);
        self.becomes(facet, [c, a, d], like);
        self.becomes(beyond, [d, b, c], like);
        self.join(d, facet);
        self.join(c, beyond);
        self.is_thin[facet as usize] = self.is_thin(beyond);
        true
    }

    /// Three facets about one corner, the end `a` or `b` of the side of the first two, become one.
    fn merge(&mut self, three: [u32; 3], [a, b, c, d]: [u32; 4]) -> bool {
        let third = self.corners(three[2]);
        let corners = match [third.contains(&a), third.contains(&b)] {
            [true, false] => [b, c, d],
            [false, true] => [c, a, d],
            _ => return false,
        };
        let gone = if corners.contains(&a) { b } else { a };
        if self.about(gone).any(|f| !three.contains(&f) && self.corners(f).contains(&gone)) {
            return false;
        }
        let real = three.into_iter().find(|f| !self.is_thin(*f));
        let like = self.like(real.unwrap_or(three[0]));
        self.becomes(three[0], corners, like);
        self.join(d, three[0]);
        self.is_thin[three[0] as usize] &= real.is_none();
        for facet in three.into_iter().skip(1) {
            self.becomes(facet, [gone; 3], like);
            self.is_thin[facet as usize] = false;
        }
        true
    }

    fn is_thin(&self, facet: u32) -> bool {
        self.is_thin[facet as usize]
    }

    /// The corners that `facet` has now.
    fn corners(&self, facet: u32) -> [u32; 3] {
        self.corners[facet as usize]
    }

    /// The facet that `facet` has the normal of.
    fn like(&self, facet: u32) -> u32 {
        Some(self.like[facet as usize]).filter(|like| *like != OWN).unwrap_or(facet)
    }

    fn becomes(&mut self, facet: u32, corners: [u32; 3], like: u32) {
        (self.corners[facet as usize], self.like[facet as usize]) = (corners, like);
    }

    /// `facet` is about `vertex` from now on.
    fn join(&mut self, vertex: u32, facet: u32) {
        let place = self.joined.len() as u32;
        self.joined.push((facet, std::mem::replace(&mut self.last_joined[vertex as usize], place)));
    }

    /// Facets that are or were about a vertex, some twice.
    fn about(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        let [from, to] = [vertex, vertex + 1].map(|v| self.given.first[v as usize] as usize);
        let at = |place: u32| self.joined.get(place as usize).copied();
        let joined = std::iter::successors(at(self.last_joined[vertex as usize]), move |(_, next)| at(*next));
        self.given.about[from..to].iter().copied().chain(joined.map(|(facet, _)| facet))
    }

    /// The one facet beyond the side of `facet` from `a` to `b`, where two facets meet in it.
    fn across(&self, facet: u32, [a, b]: [u32; 2]) -> Option<u32> {
        let mut beyond = self.with_both([a, b]).filter(|f| *f != facet);
        let one = beyond.next()?;
        beyond.all(|f| f == one).then_some(one)
    }

    /// Facets that have both corners, some twice.
    fn with_both(&self, ends: [u32; 2]) -> impl Iterator<Item = u32> + '_ {
        // A cap's fan has most of its facets about one corner.
        let given = |v: u32| self.given.first[v as usize + 1] - self.given.first[v as usize];
        let fewer = if given(ends[1]) < given(ends[0]) { ends[1] } else { ends[0] };
        self.about(fewer).filter(move |f| ends.iter().all(|v| self.corners(*f).contains(v)))
    }

    /// Whether `facet` has other corners than the given ones.
    fn is_new(&self, facet: u32) -> bool {
        self.like[facet as usize] != OWN
    }

    /// Whether the sides of `facet` are to be asked of [`Mended::sides`].
    pub(super) fn is_changed(&self, facet: u32) -> bool {
        self.is_new(facet) || self.is_thin(facet)
    }

    /// The sides of changed facets, each once; those of facets that stay thin are left out.
    pub(super) fn sides(&self) -> Vec<Side> {
        let changed = (0..self.corners.len() as u32).filter(|f| self.is_new(*f) && !self.is_thin(*f));
        let mut found = Vec::new();
        for facet in changed {
            let [p, q, r] = self.corners(facet);
            for ends in [[p, q], [q, r], [r, p]] {
                let beyond = self.across(facet, ends).filter(|f| !self.is_thin(*f));
                // Where both are changed, the other one says the same.
                let once = |f: &u32| facet < *f || !self.is_new(*f);
                found.extend(beyond.filter(once).map(|beyond| (ends, [self.like(facet), self.like(beyond)])));
            }
        }
        found
    }
}

#[cfg(test)]
mod tests;
