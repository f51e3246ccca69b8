//! What a part stands on: the footprint of its first layer, and how far it may be tipped.

use super::super::sphere::tangents;
use super::super::{Facets, Mass};
use crate::geom::{Vec3, convex_outline};

/// What lies in the first layer.
#[derive(Clone, Debug, PartialEq)]
pub struct FirstLayer {
    /// The area of the part's footprint, mm²: the shadow of what faces down and lies below the first layer's height.
    pub area_mm2: f64,
    /// How far the part may be tipped before its centre of mass leaves the footprint's convex outline, degrees; below zero
    /// where it falls over by itself.
    pub tipping_deg: f64,
    /// The corners of the outline, across the direction.
    pub(super) outline: Vec<[f64; 2]>,
    /// Where the centre of mass is: across the direction, and above the bed.
    pub(super) centre: [f64; 3],
}

impl FirstLayer {
    /// What of the part lies within `layer_mm` above its lowest point along `up`.
    ///
    /// Area counts twice where the surface goes down twice within one layer.
    pub fn of(facets: &Facets, mass: &Mass, up: &Vec3, layer_mm: f64) -> Self {
        let bed = facets.lowest(up).dot(up);
        let [e1, e2] = tangents(up);
        let heights: Vec<f64> = facets.points.iter().map(|p| p.dot(up) - bed).collect();
        let (mut area, mut points) = (0.0, Vec::new());
        for (facet, corners) in facets.each.iter().zip(&facets.corners) {
            let z = corners.map(|i| heights[i as usize]);
            if z.iter().all(|z| *z > layer_mm) {
                continue;
            }
            let along = facet.area.dot(up);
            let below = share_below(&z, layer_mm);
            if along < 0.0 {
                area -= along * below;
            }
            cut(corners.map(|i| facets.points[i as usize]), &z, layer_mm, |p| {
                points.push([p.dot(&e1), p.dot(&e2)]);
            });
        }
        let outline = convex_outline(points, 0.0);
        let centre = [mass.centre.dot(&e1), mass.centre.dot(&e2), mass.centre.dot(up) - bed];
        Self { area_mm2: area, tipping_deg: tipping(&outline, centre), outline, centre }
    }

    /// The angle where the outline also holds `points`, which stand on the bed too, degrees.
    pub(super) fn tipping_with(&self, points: impl Iterator<Item = [f64; 2]>) -> f64 {
        let outline = convex_outline(self.outline.iter().copied().chain(points).collect(), 0.0);
        tipping(&outline, self.centre)
    }
}

/// The angle between the vertical and the way from the outline's nearest side to the centre of mass, degrees; below zero where it is
/// above no point of the outline, by the distance to the nearest.
fn tipping(outline: &[[f64; 2]], [x, y, z]: [f64; 3]) -> f64 {
    // A line or a point holds nothing: what is exactly above it falls to one side or the other.
    let (mut inside, mut held, mut beside) = (outline.len() > 2, f64::INFINITY, f64::INFINITY);
    for (i, a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        let (d, w) = ([b[0] - a[0], b[1] - a[1]], [x - a[0], y - a[1]]);
        let square = d[0] * d[0] + d[1] * d[1];
        let t = if square > 0.0 { ((d[0] * w[0] + d[1] * w[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
        beside = beside.min((w[0] - t * d[0]).hypot(w[1] - t * d[1]));
        if square > 0.0 {
            let left = (d[0] * w[1] - d[1] * w[0]) / square.sqrt();
            (inside, held) = (inside && left >= 0.0, held.min(left));
        }
    }
    let way = if inside { held } else { -beside.min(1e9) };
    way.atan2(z.max(1e-9)).to_degrees()
}

/// The share of a triangle's area that lies below `level`, by the heights of its corners.
pub(in super::super) fn share_below(z: &[f64; 3], level: f64) -> f64 {
    let mut z = *z;
    z.sort_by(f64::total_cmp);
    let [a, b, c] = z;
    if c <= level {
        1.0
    } else if b <= level {
        1.0 - (c - level) * (c - level) / ((c - a) * (c - b))
    } else if a < level {
        (level - a) * (level - a) / ((b - a) * (c - a))
    } else {
        0.0
    }
}

/// Gives the corners of what of a triangle lies not above `level`.
fn cut(corners: [Vec3; 3], z: &[f64; 3], level: f64, mut give: impl FnMut(Vec3)) {
    for i in 0..3 {
        let j = (i + 1) % 3;
        if z[i] <= level {
            give(corners[i]);
        }
        if (z[i] <= level) != (z[j] <= level) {
            give(corners[i] + (corners[j] - corners[i]) * ((level - z[i]) / (z[j] - z[i])));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;

    fn footing(size: [f64; 3], up: Vec3) -> FirstLayer {
        let facets = Facets::of(&solid_box(Vec3::new(100.0, -50.0, 3.0), Vec3::from(size)));
        FirstLayer::of(&facets, &Mass::of(&facets), &up, 0.2)
    }

    #[test]
    fn a_box_on_a_face_and_on_an_edge() {
        let far = Vec3::new(100.0, -50.0, 3.0);
        let facets = Facets::of(&solid_box(far, far + Vec3::new(20.0, 30.0, 60.0)));
        let mass = Mass::of(&facets);
        assert!((mass.volume_mm3 - 36_000.0).abs() < 1e-6 && (mass.area_mm2 - 7200.0).abs() < 1e-9, "{mass:?}");
        assert!((mass.centre - far - Vec3::new(10.0, 15.0, 30.0)).norm() < 1e-9, "{mass:?}");
        let stands = FirstLayer::of(&facets, &mass, &Vec3::z(), 0.2);
        assert!((stands.area_mm2 - 600.0).abs() < 1e-9);
        assert!((stands.tipping_deg - (10.0f64 / 30.0).atan().to_degrees()).abs() < 1e-9, "{stands:?}");
        let edge = Vec3::new(1.0, 1.0, 0.0).normalize();
        let on_edge = FirstLayer::of(&facets, &mass, &edge, 0.2);
        // A strip twice the layer wide, as long as the edge; the centre of mass is 5 / sqrt 2 beside the edge.
        assert!((on_edge.area_mm2 - 0.4 * 60.0).abs() < 1e-9, "{on_edge:?}");
        let wanted = (0.2 - 5.0 / 2f64.sqrt()).atan2(25.0 / 2f64.sqrt()).to_degrees();
        assert!((on_edge.tipping_deg - wanted).abs() < 1e-9, "{on_edge:?} {wanted}");
    }

    #[test]
    fn supports_widen_the_outline() {
        let stands = footing([101.0, -49.0, 63.0], Vec3::z());
        let alone = stands.tipping_deg;
        assert!((alone - (0.5f64 / 30.0).atan().to_degrees()).abs() < 1e-9);
        let [x, y, _] = stands.centre;
        let feet = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[u, v]| [x + u, y + v]);
        assert!((stands.tipping_with(feet.into_iter()) - (9.0f64 / 30.0).atan().to_degrees()).abs() < 1e-9);
    }

    #[test]
    fn a_share_below_a_level() {
        assert_eq!(share_below(&[0.0, 0.0, 1.0], 0.5), 0.75);
        assert_eq!(share_below(&[1.0, 0.0, 1.0], 0.5), 0.25);
        assert_eq!((share_below(&[0.0; 3], 0.5), share_below(&[1.0; 3], 0.5)), (1.0, 0.0));
    }
}
