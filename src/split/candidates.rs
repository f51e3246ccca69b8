//! The planes that are tried: directions once for the model, offsets for each direction and each surface.

use super::measure::Measured;
use super::sweep::Upright;
use crate::geom::{Object, Vec3};
use crate::mesh::TriangleMesh;
use crate::orient::Facets;

/// Directions nearer than this are one, radians (0.57 degrees).
const SAME: f64 = 0.01;
/// Flat normals that are tried, both senses, the largest first.
const NORMALS: usize = 16;
/// Of these the cross products too.
const CROSSED: usize = 8;
/// Tilts at which the walls' own azimuths and the compass are tried, degrees from the vertical.
const TILTS_DEG: [f64; 4] = [45.0, 60.0, 70.0, 90.0];
/// Directions spread evenly over the sphere; those that tilt too far are left out.
const SPREAD: usize = 128;

/// Offsets spread evenly between footprint and top.
const EVEN: usize = 14;
/// Heights of faces parallel to the plane, the largest first.
const FLUSH: usize = 16;
/// Patches that need support whose lower ends are tried, the largest first.
const PATCHES: usize = 8;
/// Shares of a patch's facets that may stay before the plane.
const QUANTILES: [f64; 5] = [0.0, 0.02, 0.1, 0.25, 0.5];
/// Offsets nearer than this are one, mm.
const SAME_MM: f64 = 1e-3;

/// Offsets to either side of a plane that is moved, and heights of vertices beside them.
const FINE: i32 = 16;
const NEAREST: usize = 32;
/// A plane that does not go through a vertex keeps so far from it, mm.
const BESIDE_MM: f64 = 0.05;

/// Unit directions to print along, those that `reaches` says no to left out.
pub(super) struct Directions {
    /// All.
    pub(super) all: Vec<Vec3>,
    /// So many come first that lie along the model's own faces, halfway between them, or at 45 degrees.
    pub(super) plain: usize,
    /// So many that are of faces or of the compass; an even spread follows.
    pub(super) exact: usize,
}

pub(super) fn directions(model: &TriangleMesh<Object>, reaches: impl Fn(&Vec3) -> bool) -> Directions {
    let facets = Facets::of(model);
    let normals = facets.normals();
    let mut order: Vec<usize> = (0..normals.units.len()).collect();
    order.sort_by(|&a, &b| normals.areas[b].total_cmp(&normals.areas[a]).then(a.cmp(&b)));
    let mut flat: Vec<Vec3> = Vec::new();
    for i in order {
        let normal = normals.units[i];
        if flat.len() < NORMALS && flat.iter().all(|k| (k - normal).norm() > SAME && (k + normal).norm() > SAME) {
            flat.push(normal);
        }
    }
    let mut all: Vec<Vec3> = vec![Vec3::z()];
    let push = |all: &mut Vec<Vec3>, up: Vec3| {
        // A hair below the horizontal is the horizontal.
        if up.z > -1e-9 && all.iter().all(|k| (k - up).norm() > SAME) && reaches(&up) {
            all.push(up);
        }
    };
    flat.iter().flat_map(|n| [*n, -n]).for_each(|up| push(&mut all, up));
    // Halfway between two rods both lean by the same angle.
    flat.iter().filter(|n| n.z.abs() > 0.1).for_each(|n| push(&mut all, (n * n.z.signum() + Vec3::z()).normalize()));
    let compass = (0..8).map(|k| std::f64::consts::FRAC_PI_4 * f64::from(k));
    let walls = flat.iter().filter(|n| n.z.abs() < 0.1).flat_map(|n| [n.y.atan2(n.x), (-n.y).atan2(-n.x)]);
    let azimuths: Vec<f64> = compass.chain(walls.take(8)).collect();
    let mut plain = 0;
    for (i, tilt) in TILTS_DEG.into_iter().enumerate() {
        for azimuth in &azimuths {
            let ((s, c), (y, x)) = (tilt.to_radians().sin_cos(), azimuth.sin_cos());
            // Exactly level where it should be: 90 degrees has no exact cosine.
            push(&mut all, Vec3::new(s * x, s * y, if tilt == 90.0 { 0.0 } else { c }));
        }
        if i == 0 {
            plain = all.len();
        }
    }
    for (i, a) in flat.iter().take(CROSSED).enumerate() {
        for b in flat.iter().take(CROSSED).skip(i + 1) {
            let across = a.cross(b);
            if across.norm() > 0.02 {
                [across.normalize(), -across.normalize()].into_iter().for_each(|up| push(&mut all, up));
            }
        }
    }
    let exact = all.len();
    for i in 0..SPREAD {
        let z = 1.0 - 2.0 * (i as f64 + 0.5) / SPREAD as f64;
        let (turn, r) = (i as f64 * 2.399_963_229_728_653, (1.0 - z * z).sqrt());
        push(&mut all, Vec3::new(r * turn.cos(), r * turn.sin(), z));
    }
    Directions { all, plain, exact }
}

/// Offsets along `up` from the top down, none below the footprint unless `up` is +z; `heights` are the vertices'.
pub(super) fn offsets(part: &Measured, upright: &Upright, up: &Vec3, heights: &[f64], least_mm: f64) -> Vec<f64> {
    let [low, top] = reach(part, up, heights);
    let lower_end = |f: u32| range(heights, &mut part.surface.facets[f as usize].into_iter())[0];
    let mut exact: Vec<f64> = flush(part, up, heights);
    for patch in upright.patches.iter().take(PATCHES) {
        let mut ends: Vec<f64> = patch.iter().copied().map(lower_end).collect();
        ends.sort_unstable_by(f64::total_cmp);
        exact.extend(QUANTILES.map(|q| ends[((ends.len() - 1) as f64 * q) as usize]));
    }
    exact.extend(upright.beginnings().iter().map(|v| heights[*v as usize]));
    exact.extend(upright.ridges().iter().map(|r| range(heights, &mut r.edges.iter().flatten().copied())[0]));
    exact.push(low);
    let even = (1..EVEN).map(|i| low + (top - low) * i as f64 / EVEN as f64);
    let fits = |c: &f64| *c >= low - SAME_MM && *c <= top - least_mm;
    let mut all: Vec<f64> = Vec::new();
    for c in exact.into_iter().chain(even).filter(fits) {
        if all.iter().all(|known| (known - c).abs() > SAME_MM) {
            all.push(c);
        }
    }
    all.sort_unstable_by(|a, b| b.total_cmp(a));
    all
}

/// The least and the greatest of the heights of some vertices.
fn range(heights: &[f64], vertices: &mut dyn Iterator<Item = u32>) -> [f64; 2] {
    let heights = vertices.map(|v| heights[v as usize]);
    heights.fold([f64::INFINITY, f64::NEG_INFINITY], |r, h| [r[0].min(h), r[1].max(h)])
}

/// Where planes may lie: from the far end of the footprint, or the table for +z, up to the top.
fn reach(part: &Measured, up: &Vec3, heights: &[f64]) -> [f64; 2] {
    let footprint = (0..part.area.len()).filter(|&f| part.on_table[f]).flat_map(|f| part.surface.facets[f]);
    let [bottom, top] = range(heights, &mut (0..heights.len() as u32));
    let level = (up - Vec3::z()).norm() < SAME;
    [if level { bottom } else { range(heights, &mut footprint.into_iter())[1] }, top]
}

/// How far the offsets of [`offsets`] that are spread evenly lie apart, mm.
pub(super) fn spacing(part: &Measured, up: &Vec3, heights: &[f64]) -> f64 {
    let [low, top] = reach(part, up, heights);
    (top - low).max(0.0) / EVEN as f64
}

/// Offsets along `up` from the top down, no farther than `window` mm from `middle`, and none where [`offsets`] has none: heights of
/// vertices, the nearest, and an even spread that keeps away from them, since a cut beside a vertex leaves slivers.
pub(super) fn around(part: &Measured, up: &Vec3, heights: &[f64], middle: f64, window: f64) -> Vec<f64> {
    let [low, top] = reach(part, up, heights);
    let fits = |c: &f64| (c - middle).abs() <= window && *c >= low - SAME_MM && *c <= top - SAME_MM;
    let mut all: Vec<f64> = heights.iter().copied().filter(fits).collect();
    all.sort_unstable_by(|a, b| (a - middle).abs().total_cmp(&(b - middle).abs()));
    all.dedup_by(|a, b| (*a - *b).abs() < SAME_MM);
    all.truncate(NEAREST);
    let vertices = all.clone();
    let even = (-FINE..=FINE).map(|i| middle + window * f64::from(i) / f64::from(FINE)).filter(fits);
    all.extend(even.filter(|c| vertices.iter().all(|v| (v - c).abs() > BESIDE_MM)));
    all.sort_unstable_by(|a, b| b.total_cmp(a));
    all.dedup_by(|a, b| (*a - *b).abs() < SAME_MM);
    all
}

/// Heights of the faces parallel to the plane, the largest first.
fn flush(part: &Measured, up: &Vec3, heights: &[f64]) -> Vec<f64> {
    let mut faces: Vec<(f64, f64)> = Vec::new();
    for facet in (0..part.area.len()).filter(|&f| part.normal[f].dot(up).abs() > 0.9999) {
        let height = heights[part.surface.facets[facet][0] as usize];
        match faces.iter_mut().find(|(h, _)| (h - height).abs() < SAME_MM) {
            Some((_, area)) => *area += part.area[facet],
            None => faces.push((height, part.area[facet])),
        }
    }
    faces.sort_by(|a, b| b.1.total_cmp(&a.1));
    faces.into_iter().take(FLUSH).map(|(h, _)| h).collect()
}
