//! Supports, footprint and tipping angle of a pose by dense rays and by the definition: none of the library's code.

use trunnion::geom::Vec3;

use crate::solids::Mesh;

/// What a pose needs and stands on.
#[derive(Debug)]
pub(crate) struct Seen {
    /// mm³ of columns below what overhangs.
    pub(crate) support_mm3: f64,
    /// mm² in the first layer.
    pub(crate) footprint_mm2: f64,
    /// Degrees; below zero for what falls over.
    pub(crate) tipping_deg: f64,
}

/// Rays along the longer side.
const RAYS: f64 = 420.0;
/// Directions in which the footprint's width is taken.
const SIDES: usize = 1440;

/// Looks at `mesh` with `up` upward: surfaces beyond 45 degrees overhang, the first layer is `layer_mm` high.
pub(crate) fn look(mesh: &Mesh, up: &Vec3, layer_mm: f64) -> Seen {
    let aside = if up.z.abs() < 0.7 { Vec3::z() } else { Vec3::y() };
    let e1 = aside.cross(up).normalize();
    let e2 = up.cross(&e1);
    let points: Vec<Vec3> = mesh.vertices().iter().map(|p| Vec3::new(p.dot(&e1), p.dot(&e2), p.dot(up))).collect();
    let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), p| (l.inf(p), h.sup(p)));
    let step = (high - low).xy().max() / RAYS;
    let wide = (((high.x - low.x) / step).ceil() as usize).max(1);
    let mut rays: Vec<Vec<(f64, bool, bool)>> =
        vec![Vec::new(); wide * (((high.y - low.y) / step).ceil() as usize).max(1)];
    let (mut centre, mut volume) = (Vec3::zeros(), 0.0);
    let mut first: Vec<[f64; 2]> = Vec::new();
    for facet in mesh.facets() {
        let [a, b, c] = facet.map(|i| points[i as usize]);
        let part = (a - low).dot(&(b - low).cross(&(c - low)));
        (volume, centre) = (volume + part, centre + (a + b + c - low * 3.0) * part);
        let normal = (b - a).cross(&(c - a));
        let hangs = -normal.z > normal.norm() * 0.5_f64.sqrt();
        cast(&[a, b, c], low, step, wide, |ray, z| rays[ray].push((z, normal.z < 0.0, hangs)));
        lowest([a, b, c], low.z + layer_mm, &mut first);
    }
    let centre = low + centre / (4.0 * volume);
    let (mut support, mut lying) = (0.0, 0.0);
    for ray in &mut rays {
        ray.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (mut from, mut depth) = (low.z, 0);
        for (z, enters, hangs) in ray.iter().copied() {
            if enters && depth == 0 {
                support += if hangs && z - from > layer_mm { z - from } else { 0.0 };
                lying += if z <= low.z + layer_mm { 1.0 } else { 0.0 };
            }
            depth += if enters { 1 } else { -1 };
            from = if depth == 0 { z } else { from };
        }
    }
    // The first layer's own sides lie between the directions: they are searched where it reaches least.
    let reach = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let reach = first.iter().map(|[x, y]| x * cos + y * sin).fold(f64::NEG_INFINITY, f64::max);
        reach - (centre.x * cos + centre.y * sin)
    };
    let step_of = std::f64::consts::TAU / SIDES as f64;
    let mut nearest = f64::INFINITY;
    for i in 0..SIDES {
        let (mut low, mut high) = ((i as f64 - 1.0) * step_of, (i as f64 + 1.0) * step_of);
        let middle = reach(i as f64 * step_of);
        if middle > reach(low) || middle > reach(high) {
            continue;
        }
        for _ in 0..60 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if reach(a) < reach(b) { high = b } else { low = a }
        }
        nearest = nearest.min(reach((low + high) / 2.0));
    }
    Seen {
        support_mm3: support * step * step,
        footprint_mm2: lying * step * step,
        tipping_deg: nearest.atan2(centre.z - low.z).to_degrees(),
    }
}

/// Tells the rays that a triangle meets, and at what height; rays stand at odd places, so that none runs through an edge of a plain solid.
fn cast([a, b, c]: &[Vec3; 3], low: Vec3, step: f64, wide: usize, mut tell: impl FnMut(usize, f64)) {
    let cross = |p: &Vec3, q: &Vec3, x: f64, y: f64| (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
    let whole = cross(a, b, c.x, c.y);
    if whole == 0.0 {
        return;
    }
    let from = |v: f64, low: f64| (((v - low) / step).floor() - 1.0).max(0.0) as usize;
    let (x0, y0) = (from(a.x.min(b.x).min(c.x), low.x), from(a.y.min(b.y).min(c.y), low.y));
    let (x1, y1) = (a.x.max(b.x).max(c.x), a.y.max(b.y).max(c.y));
    let at = |i: usize, low: f64, odd: f64| low + (i as f64 + odd) * step;
    for j in (y0..).take_while(|j| at(*j, low.y, 0.500_731) <= y1) {
        for i in (x0..wide).take_while(|i| at(*i, low.x, 0.499_317) <= x1) {
            let (x, y) = (at(i, low.x, 0.499_317), at(j, low.y, 0.500_731));
            let [u, v, w] = [cross(b, c, x, y), cross(c, a, x, y), cross(a, b, x, y)].map(|s| s / whole);
            if u >= 0.0 && v >= 0.0 && w >= 0.0 {
                tell(j * wide + i, u * a.z + v * b.z + w * c.z);
            }
        }
    }
}

/// The corners of what of a triangle lies up to `level`.
fn lowest(corners: [Vec3; 3], level: f64, into: &mut Vec<[f64; 2]>) {
    for (p, q) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corners[i], corners[j])) {
        if p.z <= level {
            into.push([p.x, p.y]);
        }
        if (p.z - level) * (q.z - level) < 0.0 {
            let t = (level - p.z) / (q.z - p.z);
            into.push([p.x + (q.x - p.x) * t, p.y + (q.y - p.y) * t]);
        }
    }
}
