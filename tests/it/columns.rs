//! The exact volume of columns below what overhangs, by clipping: a witness of `support-volume-column` without its raster.
//!
//! Seen along the direction each overhanging facet is cut along the outlines of the facets that face up below it. Over
//! each piece one facet, or the bed, is the highest below: a plane, so the piece's volume is its area times the gap at its
//! centroid. For solids that do not cross themselves.

use trunnion::geom::Vec3;

use crate::solids::Mesh;

/// A corner across the direction.
type Flat = [f64; 2];

/// A facet seen along the direction, counter-clockwise: corners across, and its plane's height over the first one with its
/// slopes.
struct Seen {
    corners: [Flat; 3],
    low: [f64; 3],
    high: [f64; 3],
    height: f64,
    slope: Flat,
}

impl Seen {
    fn of(corners: [Vec3; 3]) -> Option<(Self, bool)> {
        let [a, b, c] = corners;
        let twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        let normal = (b - a).cross(&(c - a));
        if twice.abs() <= 1e-12 * normal.norm() {
            return None;
        }
        let flat = |p: Vec3| [p.x, p.y];
        let corners = if twice > 0.0 { [flat(a), flat(b), flat(c)] } else { [flat(a), flat(c), flat(b)] };
        let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        let slope = [-normal.x / normal.z, -normal.y / normal.z];
        Some((Self { corners, low: low.into(), high: high.into(), height: a.z, slope }, twice > 0.0))
    }

    fn at(&self, [x, y]: Flat) -> f64 {
        let [x0, y0] = self.corners[0];
        self.height + self.slope[0] * (x - x0) + self.slope[1] * (y - y0)
    }

    fn may_lie_below(&self, other: &Self) -> bool {
        let apart = (0..2).any(|k| self.high[k] <= other.low[k] || self.low[k] >= other.high[k]);
        !apart && self.low[2] < other.high[2]
    }
}

/// A convex piece of an overhanging facet, and the highest below it so far: a facet's number.
struct Piece {
    outline: Vec<Flat>,
    below: Option<usize>,
}

/// mm³ between every surface point that overhangs by more than `sine` and what lies below it.
pub(crate) fn exact(mesh: &Mesh, up: &Vec3, sine: f64) -> f64 {
    let aside = if up.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() };
    let e1 = up.cross(&aside).normalize();
    let e2 = up.cross(&e1);
    let points: Vec<Vec3> = mesh.vertices().iter().map(|p| Vec3::new(p.dot(&e1), p.dot(&e2), p.dot(up))).collect();
    let bed = points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let (mut ups, mut downs) = (Vec::new(), Vec::new());
    for facet in mesh.facets() {
        let corners = facet.map(|i| points[i as usize]);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        match Seen::of(corners) {
            Some((seen, true)) => ups.push(seen),
            Some((seen, false)) if -normal.z > sine * normal.norm() => downs.push(seen),
            _ => {}
        }
    }
    // The highest first: what lies below it is then seldom cut again.
    ups.sort_by(|a, b| b.high[2].total_cmp(&a.high[2]));
    downs.iter().map(|down| below(down, &ups, bed)).sum()
}

fn below(down: &Seen, ups: &[Seen], bed: f64) -> f64 {
    let mut pieces = vec![Piece { outline: down.corners.to_vec(), below: None }];
    for (number, up) in ups.iter().enumerate().filter(|(_, up)| up.may_lie_below(down)) {
        let mut cut = Vec::with_capacity(pieces.len() + 2);
        for piece in pieces {
            split(piece, number, up, down, ups, &mut cut);
        }
        pieces = cut;
    }
    let volume = |piece: &Piece| {
        let (area, centroid) = middle(&piece.outline);
        area * (down.at(centroid) - piece.below.map_or(bed, |number| ups[number].at(centroid)))
    };
    pieces.iter().map(volume).sum()
}

/// Cuts what lies over `up` out of `piece`, where `up` is the highest below it so far.
fn split(piece: Piece, number: usize, up: &Seen, down: &Seen, ups: &[Seen], into: &mut Vec<Piece>) {
    let (mut inside, mut beside) = (piece.outline.clone(), Vec::new());
    for k in 0..3 {
        let (from, to) = (up.corners[k], up.corners[(k + 1) % 3]);
        let rest = half(&inside, from, to, -1.0);
        if middle(&rest).0 > 0.0 {
            beside.push(rest);
        }
        inside = half(&inside, from, to, 1.0);
    }
    let (area, centroid) = middle(&inside);
    let (height, over) = (up.at(centroid), down.at(centroid));
    // Nearly no area says nothing of which is the higher one.
    let highest = area > 1e-12 && height < over && piece.below.is_none_or(|known| ups[known].at(centroid) < height);
    if !highest {
        into.push(piece);
        return;
    }
    into.push(Piece { outline: inside, below: Some(number) });
    into.extend(beside.into_iter().map(|outline| Piece { outline, below: piece.below }));
}

/// The part of a convex outline to the left of a line, or to the right of it for a negative `sense`.
fn half(outline: &[Flat], from: Flat, to: Flat, sense: f64) -> Vec<Flat> {
    let side = |p: Flat| sense * ((to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0]));
    let mut kept = Vec::with_capacity(outline.len() + 1);
    for (i, &p) in outline.iter().enumerate() {
        let q = outline[(i + 1) % outline.len()];
        let (at_p, at_q) = (side(p), side(q));
        if at_p >= 0.0 {
            kept.push(p);
        }
        if (at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0) {
            let t = at_p / (at_p - at_q);
            kept.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        }
    }
    kept
}

/// Area and centroid; no area for fewer than three corners.
fn middle(outline: &[Flat]) -> (f64, Flat) {
    let Some(&[x0, y0]) = outline.first() else { return (0.0, [0.0; 2]) };
    let (mut twice, mut sum) = (0.0, [0.0; 2]);
    for pair in outline.windows(2) {
        let [[ax, ay], [bx, by]] = [pair[0], pair[1]].map(|[x, y]| [x - x0, y - y0]);
        let part = ax * by - ay * bx;
        twice += part;
        sum = [sum[0] + part * (ax + bx), sum[1] + part * (ay + by)];
    }
    if twice <= 0.0 {
        return (0.0, [x0, y0]);
    }
    (0.5 * twice, [x0 + sum[0] / (3.0 * twice), y0 + sum[1] / (3.0 * twice)])
}
