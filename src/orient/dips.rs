//! What no descent finds: the narrow dips at facet normals.

use super::sphere::tangents;
use super::{ContactArea, Facets, Found, Minimum, Objective, distinct};
use crate::geom::{Angle, Vec3, turned_by};
use crate::mesh::{TABLE_GAP_MM, TriangleMesh};

/// Both senses of the so many largest normals are tried.
const MOST_NORMALS: usize = 100;
/// Evaluations of each sense: there, and on four sides.
const EACH: usize = 5;
/// How far around a minimum it is looked for something lower, radians (0.02 and 0.1 degrees), and in how many directions.
const AROUND: [f64; 2] = [3.5e-4, 1.75e-3];
const TURNS: usize = 18;
/// Lower is what is so by more than this share.
const LOWER: f64 = 1e-6;
/// A dip is lower than its neighbourhood so far away, radians: beyond the 0.1 degree within which a facet is flat.
const BESIDE: f64 = 0.004;

impl Found {
    /// With the dips of `objective` at the largest facets' normals, evaluations counted; the lower bound stays, since it
    /// holds for every direction.
    #[must_use]
    pub fn with_dips(self, objective: &dyn Objective, facets: &Facets) -> Self {
        self.with_dips_within(objective, facets, 2 * MOST_NORMALS * EACH)
    }

    /// The same with at most so many evaluations.
    #[must_use]
    pub fn with_dips_within(mut self, objective: &dyn Objective, facets: &Facets, most: usize) -> Self {
        let (normals, order) = (&facets.normals().units, facets.normals().by_area());
        let mut minima = std::mem::take(&mut self.minima);
        for &i in order.iter().take(MOST_NORMALS.min(most / (2 * EACH))) {
            for up in [normals[i], -normals[i]] {
                let value = objective.value(facets, &up);
                self.evaluations += EACH;
                if beside(&up).iter().all(|d| objective.value(facets, d) > value) {
                    minima.push(Minimum { up, value, ended: true });
                }
            }
        }
        Self { minima: distinct(minima), ..self }
    }
}

impl Found {
    /// With [`Minimum::ended`] looked at: a minimum beside which something is lower, by more than a tie of the objective or rounding, is none, whatever
    /// its search says of itself. At most `most` evaluations, counted; what they do not reach stays as it is.
    #[must_use]
    pub fn looked_around(mut self, objective: &dyn Objective, facets: &Facets, most: usize) -> Self {
        let rounding = |value: f64| objective.tie(facets).max(LOWER * value.abs()).max(f64::MIN_POSITIVE);
        for minimum in self.minima.iter_mut().take(most / AROUND.len() / TURNS) {
            let [e1, e2] = tangents(&minimum.up);
            let ring = AROUND.iter().flat_map(|angle| (0..TURNS).map(move |k| (angle, k)));
            let mut lower = ring.map(|(angle, k)| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / TURNS as f64).sin_cos();
                objective.value(facets, &(minimum.up + (e1 * c + e2 * s) * angle.tan()).normalize())
            });
            minimum.ended &= !lower.any(|value| value < minimum.value - rounding(minimum.value));
            self.evaluations += AROUND.len() * TURNS;
        }
        self
    }
}

fn beside(up: &Vec3) -> [Vec3; 4] {
    let [e1, e2] = tangents(up);
    [e1, -e1, e2, -e2].map(|t| (up + t * BESIDE).normalize())
}

/// All directions that lay at least `least_mm2` flat on the bed, with the values of `objective`, best first: the opposites of
/// the normals of facets that nothing lies below. Facets within the flatness tolerance of such a direction count, and one
/// direction stands for those within half a degree that are worse. None where no facet can lie on a plane.
pub fn laid(facets: &Facets, least_mm2: f64, objective: &dyn Objective) -> Vec<Minimum> {
    let mut ups: Vec<Vec3> = Vec::new();
    for facet in &facets.each {
        let up = -facet.area.normalize();
        let low = facets.lowest(&up).dot(&up);
        if facet.barycentre.dot(&up) <= low + TABLE_GAP_MM {
            ups.push(up);
        }
    }
    ups.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    ups.dedup_by(|a, b| (*a - *b).norm() < 1e-9);
    let enough = |up: &Vec3| 0.0 - ContactArea.value(facets, up) >= least_mm2;
    let all = ups.into_iter().filter(enough).map(|up| Minimum { up, value: objective.value(facets, &up), ended: true });
    distinct(all.collect())
}

/// The area of what faces down by more than `overhang` from the vertical and does not lie on the bed, mm².
pub fn overhang_area(facets: &Facets, up: &Vec3, overhang: Angle) -> f64 {
    let (bed, from) = (facets.lowest(up).dot(up) + TABLE_GAP_MM, overhang.rad().sin());
    facets.sum(|f| {
        let size = f.area.norm();
        if -f.area.dot(up) > from * size && f.barycentre.dot(up) > bed { size } else { 0.0 }
    })
}

/// `mesh` turned by the least rotation that brings the unit direction `up` to +Z (for -Z: half a turn about X), lowest
/// point at z = 0; x and y of the turned mesh stay as they come. No points stay none.
pub fn turned<F, G>(mesh: &TriangleMesh<F>, up: &Vec3) -> TriangleMesh<G> {
    let turn = turned_by(up);
    let mut vertices: Vec<Vec3> = mesh.vertices().iter().map(|v| turn * v).collect();
    let low = vertices.iter().map(|v| v.z).fold(f64::INFINITY, f64::min);
    vertices.iter_mut().for_each(|v| v.z -= low);
    TriangleMesh::new(vertices, mesh.facets().to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Object, Slot};
    use crate::orient::{NelderMead, Search};

    fn wedge() -> TriangleMesh<Object> {
        let points = [[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 3.0, 1.0], [0.0, 0.0, 3.0]];
        let facets = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        TriangleMesh::new(points.map(Vec3::from).to_vec(), facets)
    }

    #[test]
    fn the_largest_face_of_a_tetrahedron_is_its_best_contact() {
        let facets = Facets::of(&wedge());
        let found = NelderMead::default().search(&ContactArea, &facets).with_dips(&ContactArea, &facets);
        // Faces of 6, 4, 3 and the slope: half of |(-4, 3, 0) x (-4, 0, 2)| = |(6, 8, 12)| / 2.
        let areas: Vec<f64> = found.minima.iter().map(|m| m.value).filter(|v| *v < 0.0).collect();
        let wanted = [-(244f64.sqrt() / 2.0), -6.0, -4.0, -3.0];
        assert_eq!(areas.len(), 4, "{areas:?}");
        assert!(areas.iter().zip(wanted).all(|(a, w)| (a - w).abs() < 1e-9), "{areas:?}");
    }

    #[test]
    fn a_turned_mesh_stands_on_the_bed_upright() {
        for up in [Vec3::x(), Vec3::z(), -Vec3::z(), Vec3::new(1.0, 2.0, -2.0) / 3.0] {
            let (mesh, facets) = (wedge(), Facets::of(&wedge()));
            let turned: TriangleMesh<Slot> = turned(&mesh, &up);

            assert!(turned.bounds().min.z.abs() < 1e-12);
            assert!((turned.bounds().max.z - facets.extent(&up)).abs() < 1e-12, "{up:?}");
            assert!((turned.volume() - mesh.volume()).abs() < 1e-12, "not mirrored");
        }
    }
}
