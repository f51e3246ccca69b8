//! A lower bound of the column volume on a cap of directions: facets' own columns, as far down as nothing can be in the way.

use super::super::Facets;
use super::super::bound::{Cap, Local, Minorant, quadratic};
use super::SupportVolumeColumn;
use crate::geom::{Mat3, Vec3};

/// A column below a facet that hangs everywhere on the cap ends on the bed, or on a facet that faces up somewhere on the
/// cap. Such facets are laid, widest first upward, into a coarse grid across the centre. A line down that falls by `z` strays
/// by `z tan r` at most on the cap, so what a facet's columns can meet lies within the height of the part times `tan r` of
/// its outline: over the highest of that they are free. With nothing there they reach the bed, for any corner `v` at least
/// `(b - v).d` long. Facets that hang on a part of the cap only are left out.
///
/// The sampled value may lie below the exact volume, of which this is the bound, by the error of its columns.
pub(super) struct Free<'a> {
    f: &'a SupportVolumeColumn,
    facets: &'a Facets,
    cap: Cap,
    /// Of the facets with nothing below: `-sum n m'` with the moments about the middle, and `sum A n`.
    form: Mat3,
    area: Vec3,
    /// Of the others, `sum -A n` times the free length.
    held: Vec3,
    middle: Vec3,
}

/// Cells along the longer side of the grid, and at most so many that a stray spans.
const CELLS: f64 = 96.0;
const SPAN: f64 = 3.0;
/// From this radius on nothing is worked out.
const WIDEST: f64 = 0.5;

/// A facet seen along the cap's centre: its box across and along.
struct Seen {
    low: Vec3,
    high: Vec3,
    index: usize,
}

impl<'a> Free<'a> {
    pub(super) fn of(f: &'a SupportVolumeColumn, facets: &'a Facets) -> Self {
        let (form, area, held) = (Mat3::zeros(), Vec3::zeros(), Vec3::zeros());
        Self { f, facets, cap: Cap::WHOLE, form, area, held, middle: facets.middle() }
    }

    /// The facets that may face up somewhere on the cap, and those that hang everywhere on it, each seen along the centre.
    fn seen(&self, cap: &Cap) -> [Vec<Seen>; 2] {
        let [e1, e2] = super::super::sphere::tangents(&cap.centre);
        let flat: Vec<Vec3> =
            self.facets.points.iter().map(|p| Vec3::new(p.dot(&e1), p.dot(&e2), p.dot(&cap.centre))).collect();
        let from = self.f.overhang.rad().sin();
        let (mut ups, mut downs) = (Vec::new(), Vec::new());
        for (index, (facet, corners)) in self.facets.each.iter().zip(&self.facets.corners).enumerate() {
            let most = cap.range(&(facet.area / facet.area.norm()))[1];
            let list = match () {
                () if most >= -1e-9 => &mut ups,
                () if -most > from + 1e-9 => &mut downs,
                () => continue,
            };
            let [a, b, c] = corners.map(|i| flat[i as usize]);
            list.push(Seen { low: a.inf(&b).inf(&c), high: a.sup(&b).sup(&c), index });
        }
        [ups, downs]
    }

    fn narrowed(&self, cap: &Cap) -> Self {
        let mut local = Self { cap: *cap, ..Self::of(self.f, self.facets) };
        if cap.radius > WIDEST || self.facets.corners.is_empty() {
            return local;
        }
        let [mut ups, mut downs] = local.seen(cap);
        ups.sort_by(|a, b| a.low.z.total_cmp(&b.low.z).then(a.index.cmp(&b.index)));
        downs.sort_by(|a, b| a.high.z.total_cmp(&b.high.z).then(a.index.cmp(&b.index)));
        let all = || ups.iter().chain(&downs);
        let low = all().fold(Vec3::repeat(f64::INFINITY), |l, s| l.inf(&s.low));
        let high = all().fold(Vec3::repeat(f64::NEG_INFINITY), |h, s| h.sup(&s.high));
        let stray = (high.z - low.z).max(0.0) * cap.radius.tan() * (1.0 + 1e-9);
        let cell = ((high.x - low.x).max(high.y - low.y) / CELLS).max(stray / SPAN).max(1e-12);
        let mut field = Field::new(cell, &low, &high);
        let mut next = 0;
        let v = self.facets.lowest(&cap.centre);
        for down in &downs {
            while next < ups.len() && ups[next].low.z < down.high.z {
                field.raise(&ups[next]);
                next += 1;
            }
            local.count(down, field.highest(down, stray), &v);
        }
        local
    }

    /// Counts a hanging facet in, over what is highest of that which may be below it.
    fn count(&mut self, down: &Seen, highest: f64, v: &Vec3) {
        let facet = &self.facets.each[down.index];
        if highest == f64::NEG_INFINITY {
            let n = facet.area / facet.area.norm();
            self.form -= n * ((facet.barycentre - self.middle) * facet.area.norm()).transpose();
            self.area += facet.area;
            return;
        }
        // Also where the bed comes first, which lies below all that may be met but is turned with the direction.
        let corners = self.facets.corners[down.index].map(|i| self.facets.points[i as usize]);
        let to_bed = corners.iter().map(|p| self.cap.range(&(p - v))[0]).fold(f64::INFINITY, f64::min);
        self.held -= facet.area * (down.low.z - highest).min(to_bed).max(0.0);
    }
}

/// For each cell the highest facet laid into it so far.
struct Field {
    cell: f64,
    origin: [f64; 2],
    count: [usize; 2],
    highest: Vec<f64>,
}

impl Field {
    fn new(cell: f64, low: &Vec3, high: &Vec3) -> Self {
        let count = [0, 1].map(|k| ((high[k] - low[k]) / cell).floor().max(0.0) as usize + 1);
        Self { cell, origin: [low.x, low.y], count, highest: vec![f64::NEG_INFINITY; count[0] * count[1]] }
    }

    fn cells(&self, seen: &Seen, wider: f64) -> impl Iterator<Item = usize> + use<> {
        let slack = wider + 1e-9 * self.cell;
        let place =
            |v: f64, k: usize| (((v - self.origin[k]) / self.cell).floor().max(0.0) as usize).min(self.count[k] - 1);
        let [x, y] = [0, 1].map(|k| place(seen.low[k] - slack, k)..=place(seen.high[k] + slack, k));
        let columns = self.count[0];
        y.flat_map(move |j| x.clone().map(move |i| j * columns + i))
    }

    fn raise(&mut self, seen: &Seen) {
        for i in self.cells(seen, 0.0) {
            self.highest[i] = self.highest[i].max(seen.high.z);
        }
    }

    fn highest(&self, seen: &Seen, stray: f64) -> f64 {
        self.cells(seen, stray).map(|i| self.highest[i]).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl<'a> Local<'a> for Free<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        Box::new(self.narrowed(cap))
    }

    /// Not known without an evaluation: always worth one.
    fn estimate(&self) -> f64 {
        f64::NEG_INFINITY
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        let v = self.facets.lowest(e) - self.middle;
        let bed = quadratic(&(self.form + self.area * v.transpose()), &self.cap);
        bed.added(1.0, &Minorant::linear(self.held, &self.cap))
    }
}
