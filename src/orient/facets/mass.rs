//! Volume, surface and centre of mass of a part.

use super::Facets;
use crate::geom::Vec3;

/// A solid's volume and centre of mass, and its surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mass {
    /// mm³; what an open mesh leaves of it is as wrong as its holes are large.
    pub volume_mm3: f64,
    /// mm².
    pub area_mm2: f64,
    /// mm, the mesh's frame; the middle of the box where there is no volume.
    pub centre: Vec3,
}

impl Mass {
    /// Volumes of support nearer than this are one for a printer: a thousandth of the part's, at most 1 mm³.
    pub fn support_tie_mm3(&self) -> f64 {
        (1e-3 * self.volume_mm3).min(1.0)
    }

    /// By the tetrahedra between the facets and the middle of the box, so that a part far from the origin loses no digits.
    pub fn of(facets: &Facets) -> Self {
        let middle = facets.middle();
        let (mut six, mut sum, mut area) = (0.0, Vec3::zeros(), 0.0);
        for (facet, corners) in facets.each.iter().zip(&facets.corners) {
            let [a, b, c] = corners.map(|i| facets.points[i as usize] - middle);
            let part = a.dot(&b.cross(&c));
            six += part;
            sum += (a + b + c) * (part / 4.0);
            area += facet.area.norm();
        }
        let inside = six.abs() > 1e-12 * area.powf(1.5);
        let centre = if inside { middle + sum / six } else { middle };
        Self { volume_mm3: (six / 6.0).abs(), area_mm2: area, centre }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Object;
    use crate::mesh::TriangleMesh;

    #[test]
    fn a_tetrahedron_has_its_mass_at_the_mean_of_its_corners() {
        let points = [[7.0, 0.0, 1.0], [11.0, 0.0, 1.0], [7.0, 3.0, 1.0], [7.0, 0.0, 3.0]].map(Vec3::from);
        let facets = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mass = Mass::of(&Facets::of(&TriangleMesh::<Object>::new(points.to_vec(), facets)));
        assert!((mass.volume_mm3 - 4.0).abs() < 1e-12, "{mass:?}");
        assert!((mass.centre - points.iter().sum::<Vec3>() / 4.0).norm() < 1e-12, "{mass:?}");
        assert!((mass.area_mm2 - (6.0 + 4.0 + 3.0 + 61f64.sqrt())).abs() < 1e-12, "{mass:?}");
        assert!((mass.support_tie_mm3() - 0.004).abs() < 1e-15);
    }
}
