//! How thick a region is, seen from its border: the largest disc that touches the border there and on the other side.
//!
//! Shrinking balls (Ma, Bae, Choi 2012), but against the border's sides themselves and not against samples of them. Only what lies
//! across counts as the other side: along a curve or out of a blunt corner the next side is nearer, and says nothing of thickness.
//! Millimetres.

use std::collections::HashMap;

pub(super) use super::region::length;
use super::region::{GridPoint, Region, mm};

/// A point or a direction in the plane.
pub(super) type Vec2 = [f64; 2];

/// The other side is met within this angle of the normal, as its cosine: both sides of a wedge of up to 50 degrees are.
const ACROSS: f64 = 0.906;
/// A disc may leave the region by this part of its radius: where a curve is a polygon it does.
const INSIDE: f64 = 0.85;
/// Sides are looked up in cells of this size, and cut into pieces as long.
const CELL_MM: f64 = 0.6;
/// What rounding may do.
const NOTHING: f64 = 1e-9;

/// A place on the border: which ring, and how far along it.
pub(super) type Place = (u32, f64);

/// The disc between two sides.
pub(super) struct Disc {
    pub(super) centre: Vec2,
    pub(super) radius: f64,
    /// Where it touches the other side.
    pub(super) other: Place,
}

struct Piece {
    from: Vec2,
    to: Vec2,
    along: Vec2,
    length: f64,
    /// Into the region.
    normal: Vec2,
    place: Place,
}

/// The border of a region, or what of it lies near given boxes.
pub(super) struct Border {
    pieces: Vec<Piece>,
    cells: HashMap<[i32; 2], Vec<u32>>,
}

/// Boxes, `[least, most]`, found again by the cells that they reach into.
pub(super) struct Boxes {
    all: Vec<[Vec2; 2]>,
    cells: HashMap<[i32; 2], Vec<u32>>,
}

impl Boxes {
    /// The boxes of a region's shapes, `by` larger on each side.
    pub(super) fn around(region: &Region, by: f64) -> Self {
        let all: Vec<[Vec2; 2]> = region.iter().filter_map(|shape| bounds(shape.first()?, by)).collect();
        let mut cells: HashMap<[i32; 2], Vec<u32>> = HashMap::new();
        for ([low, high], index) in all.iter().zip(0..) {
            each_cell(*low, *high, |cell| cells.entry(cell).or_default().push(index));
        }
        Self { all, cells }
    }

    pub(super) fn hold(&self, p: Vec2) -> bool {
        self.meet(p, p)
    }

    /// Whether one of them and the box from `low` to `high` have a point in common.
    fn meet(&self, low: Vec2, high: Vec2) -> bool {
        let meets = |[least, most]: &[Vec2; 2]| (0..2).all(|i| high[i] >= least[i] && low[i] <= most[i]);
        let across = |i: usize| ((high[i] - low[i]) / CELL_MM + 2.0) as usize;
        if across(0).saturating_mul(across(1)) > self.all.len() {
            return self.all.iter().any(meets);
        }
        let mut met = false;
        each_cell(low, high, |cell| {
            let here = self.cells.get(&cell).map_or(&[][..], Vec::as_slice);
            met = met || here.iter().any(|&index| meets(&self.all[index as usize]));
        });
        met
    }

    /// Whether a straight line may pass within `by` of one of them.
    fn may_meet(&self, a: Vec2, b: Vec2, by: f64) -> bool {
        self.meet([0, 1].map(|i| a[i].min(b[i]) - by), [0, 1].map(|i| a[i].max(b[i]) + by))
    }

    /// Whether a ring may come into one of them.
    pub(super) fn may_hold(&self, ring: &[GridPoint]) -> bool {
        bounds(ring, 0.0).is_some_and(|[low, high]| self.meet(low, high))
    }
}

fn bounds(ring: &[GridPoint], by: f64) -> Option<[Vec2; 2]> {
    let of = |p: &GridPoint| -> Vec2 { in_mm(*p) };
    let first = of(ring.first()?);
    let (low, high) = ring.iter().map(of).fold((first, first), |(low, high), p| {
        ([low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])])
    });
    Some([[low[0] - by, low[1] - by], [high[0] + by, high[1] + by]])
}

/// A grid point in millimetres.
pub(super) fn in_mm(p: GridPoint) -> Vec2 {
    [mm(f64::from(p.x)), mm(f64::from(p.y))]
}

pub(super) fn sub(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] - b[0], a[1] - b[1]]
}

/// `a + by * v`.
pub(super) fn plus(a: Vec2, v: Vec2, by: f64) -> Vec2 {
    [a[0] + by * v[0], a[1] + by * v[1]]
}

pub(super) fn dot(a: Vec2, b: Vec2) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

impl Border {
    /// The border of `region` within `reach` of `boxes`.
    pub(super) fn new(region: &Region, boxes: &Boxes, reach: f64) -> Self {
        let mut border = Self { pieces: Vec::new(), cells: HashMap::new() };
        for (ring, number) in region.iter().flatten().zip(0..) {
            let mut along = 0.0;
            for (a, b) in super::region::pairs(ring) {
                let (a, b) = (in_mm(a), in_mm(b));
                border.add(a, b, (number, along), |a, b| boxes.may_meet(a, b, reach));
                along += length(sub(b, a));
            }
        }
        border
    }

    fn add(&mut self, a: Vec2, b: Vec2, (ring, along): Place, wanted: impl Fn(Vec2, Vec2) -> bool) {
        let whole = length(sub(b, a));
        if whole < NOTHING || !wanted(a, b) {
            return;
        }
        let direction = [(b[0] - a[0]) / whole, (b[1] - a[1]) / whole];
        let count = (whole / CELL_MM).ceil().max(1.0);
        let step = whole / count;
        for k in 0..count as usize {
            let (from, to) = (plus(a, direction, step * k as f64), plus(a, direction, step * (k + 1) as f64));
            if wanted(from, to) {
                let index = self.pieces.len() as u32;
                each_cell([0, 1].map(|i| from[i].min(to[i])), [0, 1].map(|i| from[i].max(to[i])), |cell| {
                    self.cells.entry(cell).or_default().push(index);
                });
                let normal = [-direction[1], direction[0]];
                let place = (ring, along + step * k as f64);
                self.pieces.push(Piece { from, to, along: direction, length: step, normal, place });
            }
        }
    }

    /// Visits the pieces near the box about `p`, some of them more than once.
    fn near(&self, p: Vec2, half: f64, mut visit: impl FnMut(&Piece)) {
        each_cell(plus(p, [1.0, 1.0], -half), plus(p, [1.0, 1.0], half), |cell| {
            let here = self.cells.get(&cell).map_or(&[][..], Vec::as_slice);
            here.iter().for_each(|&i| visit(&self.pieces[i as usize]));
        });
    }

    /// The disc of at most `reach` that touches the border at `a`, where `normal` leads into the region, and on the other side.
    ///
    /// `None` where the region is thicker, and where such a disc would not lie inside: close to an end or a corner.
    pub(super) fn disc(&self, a: Vec2, normal: Vec2, reach: f64) -> Option<Disc> {
        let mut best: Option<Disc> = None;
        self.near(plus(a, normal, reach), reach, |piece| {
            let most = best.as_ref().map_or(reach, |disc| disc.radius);
            for (radius, along) in piece.touched(a, normal) {
                let centre = plus(a, normal, radius);
                let foot = plus(piece.from, piece.along, along);
                let chord = sub(foot, a);
                if radius < most && dot(chord, normal) >= ACROSS * length(chord) && radius > NOTHING {
                    best = Some(Disc { centre, radius, other: (piece.place.0, piece.place.1 + along) });
                    break;
                }
            }
        });
        best.filter(|disc| self.foot(disc.centre, INSIDE * disc.radius).is_none())
    }

    /// The nearest place of the border within `reach`.
    pub(super) fn foot(&self, p: Vec2, reach: f64) -> Option<Vec2> {
        let mut best = (reach, None);
        self.near(p, reach, |piece| {
            let along = dot(sub(p, piece.from), piece.along).clamp(0.0, piece.length);
            let foot = plus(piece.from, piece.along, along);
            let distance = length(sub(p, foot));
            if distance < best.0 {
                best = (distance, Some(foot));
            }
        });
        best.1
    }
}

impl Piece {
    /// The radii of the discs through `a` that touch the piece, least first, with how far along it: its inside, then its beginning.
    fn touched(&self, a: Vec2, normal: Vec2) -> impl Iterator<Item = (f64, f64)> {
        let (high, share) = (dot(sub(a, self.from), self.normal), 1.0 - dot(normal, self.normal));
        let side = (high > NOTHING && share > NOTHING).then(|| {
            let radius = high / share;
            let foot = plus(plus(a, normal, radius), self.normal, -radius);
            (radius, dot(sub(foot, self.from), self.along))
        });
        let end = |p: Vec2, along: f64| {
            let to = sub(p, a);
            let ahead = dot(to, normal);
            (ahead > NOTHING).then(|| (dot(to, to) / (2.0 * ahead), along))
        };
        let side = side.filter(|(_, along)| (0.0..=self.length).contains(along));
        side.into_iter().chain(end(self.from, 0.0)).chain(end(self.to, self.length))
    }
}

fn each_cell(low: Vec2, high: Vec2, mut visit: impl FnMut([i32; 2])) {
    let cell = |v: f64| (v / CELL_MM).floor() as i32;
    for x in cell(low[0])..=cell(high[0]) {
        for y in cell(low[1])..=cell(high[1]) {
            visit([x, y]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::region::{enclosed, units};
    use super::*;

    fn border(rings: &[&[Vec2]]) -> (Border, Boxes) {
        let ring = |ring: &&[Vec2]| ring.iter().map(|p| GridPoint::new(units(p[0]), units(p[1]))).collect();
        let region = enclosed(&rings.iter().map(ring).collect::<Vec<_>>());
        let boxes = Boxes::around(&region, 0.1);
        (Border::new(&region, &boxes, 5.0), boxes)
    }

    #[test]
    fn a_strip_is_as_thick_as_it_is_wide_except_at_its_ends() {
        let (border, _) = border(&[&[[0.0, 0.0], [10.0, 0.0], [10.0, 0.7], [0.0, 0.7]]]);
        for x in [0.4, 1.0, 5.0, 9.0] {
            let disc = border.disc([x, 0.0], [0.0, 1.0], 0.5).unwrap();
            assert!((disc.radius - 0.35).abs() < 1e-9 && (disc.centre[0] - x).abs() < 1e-9, "{x}: {}", disc.radius);
        }
        assert!(border.disc([0.2, 0.0], [0.0, 1.0], 0.5).is_none(), "the disc would leave the end");
        assert!(border.disc([0.0, 0.35], [1.0, 0.0], 0.5).is_none(), "an end has nothing across");
        assert!(border.disc([5.0, 0.0], [0.0, 1.0], 0.34).is_none(), "thicker than asked");
    }

    #[test]
    fn in_a_wedge_the_disc_touches_both_sides() {
        // A wedge of 30 degrees with its tip at the origin: at `s` along the lower side the radius is s tan 15.
        let (sin, cos) = 30f64.to_radians().sin_cos();
        let (border, _) = border(&[&[[0.0, 0.0], [10.0, 0.0], [10.0 * cos, 10.0 * sin]]]);
        for s in [1.0, 2.0, 3.0] {
            let disc = border.disc([s, 0.0], [0.0, 1.0], 1.0).unwrap();
            assert!((disc.radius - s * 15f64.to_radians().tan()).abs() < 1e-4, "{s}: {}", disc.radius);
        }
        let (blunt, _) = super::tests::border(&[&[[0.0, 0.0], [10.0, 0.0], [0.0, 10.0]]]);
        assert!(blunt.disc([0.5, 0.0], [0.0, 1.0], 1.0).is_none(), "a right angle is a corner");
    }

    #[test]
    fn the_thickness_of_a_ring_of_many_sides_is_that_between_its_circles() {
        let circle = |radius: f64, sign: f64| -> Vec<Vec2> {
            let at = |k: i32| (sign * f64::from(k) * std::f64::consts::TAU / 120.0).sin_cos();
            (0..120).map(at).map(|(s, c)| [radius * c, radius * s]).collect()
        };
        let (border, boxes) = border(&[&circle(5.0, 1.0), &circle(4.4, -1.0)]);
        assert!(boxes.hold([0.0, 0.0]) && !boxes.hold([5.2, 0.0]));
        for k in 0..50 {
            let (s, c) = (f64::from(k) * 0.1256).sin_cos();
            let foot = border.foot([5.0 * c, 5.0 * s], 0.1).unwrap();
            let disc = border.disc(foot, [-c, -s], 0.5).unwrap();
            assert!((disc.radius - 0.3).abs() < 0.01, "{k}: {}", disc.radius);
        }
    }
}
