//! A lower bound of the column volume on a cap of directions: pieces of what hangs, and how far down from each nothing can be
//! in the way.

use std::sync::Arc;

use super::super::Facets;
use super::super::bound::{Cap, Local, Minorant, quadratic};
use super::SupportVolumeColumn;
use super::bare::bare;
use super::below::{Above, Below};
use crate::geom::{Bounds, Mat3, Vec3};

/// What hangs is cut into triangles. A triangle of a bare facet that hangs everywhere on the cap costs its projected area times
/// the mean gap below it. Down from a point, along a direction of the cap, the gap ends on the bed or on a facet that faces up
/// there: at `N / (n.d)` for one whose plane is `N` below the point, which is at least `N` by the largest `n.d` on the cap; and
/// not before the line has come down to the facet's highest point, nor before it has strayed as far as the facet lies aside.
/// The first is linear over the triangle, the others hold for all of it, and the least of linear functions is nowhere below what
/// joins its values at the corners. So the mean of these three is a bound of the mean gap.
///
/// Triangles with nothing but the bed below are known exactly, for any corner `v` that is to be the lowest: their gap is `(q -
/// v).d` at least. Facets that hang on a part of the cap only are left out, and so is what is not [bare](super::bare).
///
/// The sampled value may lie below the exact volume, of which this is the bound, by the error of its columns.
pub(super) struct Free<'a> {
    f: &'a SupportVolumeColumn,
    facets: &'a Facets,
    pieces: Arc<Vec<Piece>>,
    cap: Cap,
    /// Of the pieces with nothing below: `-sum n m'` with the moments about the middle, and `sum A n`.
    form: Mat3,
    area: Vec3,
    /// Of the others, `sum -A n` times the free length.
    held: Vec3,
    middle: Vec3,
    size: f64,
}

/// From this radius on nothing is worked out.
const WIDEST: f64 = 0.2;
/// A piece above a step is cut until no edge is longer than lines stray on the way down, or than this share of the part.
const FINEST: f64 = 1.0 / 128.0;

/// A triangle of what may hang.
#[derive(Clone, Copy)]
struct Piece {
    corners: [Vec3; 3],
    /// Outward, as long as the area.
    area: Vec3,
}

impl Piece {
    /// The longest edge: its place and length.
    fn longest(&self) -> (usize, f64) {
        let [a, b, c] = self.corners;
        let sides = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
        let place = (0..3).fold(0, |k, i| if sides[i] > sides[k] { i } else { k });
        (place, sides[place])
    }

    /// Halved across the longest edge.
    fn halves(&self) -> [Self; 2] {
        let [p, q, r] = [0, 1, 2].map(|i| self.corners[(self.longest().0 + i) % 3]);
        let (middle, area) = ((p + q) * 0.5, self.area * 0.5);
        [[p, middle, r], [middle, q, r]].map(|corners| Self { corners, area })
    }
}

/// The bare facets.
fn pieces(facets: &Facets) -> Vec<Piece> {
    let whole = facets.corners.iter().zip(&facets.each).zip(bare(facets)).filter(|(_, bare)| *bare);
    whole
        .map(|((corners, facet), _)| Piece { corners: corners.map(|i| facets.points[i as usize]), area: facet.area })
        .collect()
}

impl<'a> Free<'a> {
    pub(super) fn of(f: &'a SupportVolumeColumn, facets: &'a Facets) -> Self {
        let size = Bounds::of(facets.points.iter().copied()).size().norm();
        Self::empty(f, facets, Arc::new(pieces(facets)), Cap::WHOLE, size)
    }

    fn empty(f: &'a SupportVolumeColumn, facets: &'a Facets, pieces: Arc<Vec<Piece>>, cap: Cap, size: f64) -> Self {
        let (form, area, held) = (Mat3::zeros(), Vec3::zeros(), Vec3::zeros());
        Self { f, facets, pieces, cap, form, area, held, middle: facets.middle(), size }
    }

    fn narrowed(&self, cap: &Cap) -> Self {
        let mut local = Self::empty(self.f, self.facets, self.pieces.clone(), *cap, self.size);
        if cap.radius > WIDEST || self.facets.corners.is_empty() {
            return local;
        }
        let from = self.f.overhang.rad().sin();
        let mut below = Below::of(self.facets, cap);
        let v = self.facets.lowest(&cap.centre);
        for piece in self.pieces.iter() {
            if -cap.range(&(piece.area / piece.area.norm()))[1] > from + 1e-9 {
                local.count(piece, &mut below, &v);
            }
        }
        local
    }

    fn count(&mut self, piece: &Piece, below: &mut Below, v: &Vec3) {
        let to_bed = piece.corners.map(|q| self.cap.range(&(q - v)));
        let longest = to_bed.iter().map(|[_, most]| *most).fold(0.0, f64::max);
        // The lowest point changes on the cap, and no other point comes lower than it by more than this.
        let until = longest + self.size * self.cap.sine();
        let gaps = to_bed.map(|[least, _]| least.max(0.0));
        match below.gaps(&piece.corners, gaps, until) {
            Above::Bed => {
                let (size, [a, b, c]) = (piece.area.norm(), piece.corners);
                let n = piece.area / size;
                self.form -= n * (((a + b + c) / 3.0 - self.middle) * size).transpose();
                self.area += piece.area;
            }
            Above::Step(_) if piece.longest().1 > (longest * self.cap.sine()).max(FINEST * self.size) => {
                piece.halves().iter().for_each(|half| self.count(half, below, v));
            }
            Above::Plane(gaps) | Above::Step(gaps) => {
                let mean = gaps.iter().sum::<f64>() / 3.0 - 1e-9 * self.size;
                self.held -= piece.area * mean.max(0.0);
            }
        }
    }
}

impl<'a> Local<'a> for Free<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(self.narrowed(cap))
    }

    fn estimate(&self) -> f64 {
        self.minorant(&self.cap.centre).value
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        let v = self.facets.lowest(e) - self.middle;
        let bed = quadratic(&(self.form + self.area * v.transpose()), &self.cap);
        bed.added(1.0, &Minorant::linear(self.held, &self.cap))
    }
}
