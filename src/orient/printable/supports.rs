//! The supports that a pose needs, by columns: how much, where they stand, what they touch.

use super::super::Facets;
use super::super::column::Raster;
use crate::geom::{Angle, Vec3};

/// Supports of one pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Supports {
    /// Volume of all columns, mm³.
    pub volume_mm3: f64,
    /// Of them what stands on the part itself, mm³.
    pub on_part_mm3: f64,
    /// What they touch of the part, seen along the direction, mm²: above them, and below those that stand on it.
    pub scar_mm2: f64,
    /// What they take of the bed, mm².
    pub feet_mm2: f64,
    /// The outermost columns that stand on the bed, across the direction.
    pub(super) feet: Vec<[f64; 2]>,
}

impl Supports {
    /// Columns of `width_mm` below what overhangs. What lies within a layer of the bed is the first layer's footprint, and a
    /// gap of less than a layer is none: facets that float32 rounding lifts off the bed cost nothing.
    pub fn of(facets: &Facets, up: &Vec3, overhang: Angle, layer_mm: f64, width_mm: f64) -> Self {
        let raster = Raster::of(facets, up, width_mm);
        let from = overhang.rad().sin();
        let hangs: Vec<bool> = facets.each.iter().map(|f| -f.area.dot(up) > from * f.area.norm()).collect();
        let cell = raster.width * raster.width;
        let (mut found, mut rows) = (Self::default(), Rows::default());
        for gap in raster.gaps().filter(|gap| hangs[gap.above as usize] && gap.to - gap.from > layer_mm) {
            let volume = (gap.to - gap.from) * cell;
            found.volume_mm3 += volume;
            found.scar_mm2 += cell;
            if gap.below.is_some() {
                (found.on_part_mm3, found.scar_mm2) = (found.on_part_mm3 + volume, found.scar_mm2 + cell);
            } else {
                found.feet_mm2 += cell;
                rows.hold(raster.flat(gap.column));
            }
        }
        found.feet = rows.ends();
        found
    }
}

/// The two ends of every row of columns: all that a convex outline needs.
#[derive(Default)]
struct Rows {
    ends: Vec<[[f64; 2]; 2]>,
}

impl Rows {
    /// Columns come row by row, each from left to right.
    fn hold(&mut self, at: [f64; 2]) {
        match self.ends.last_mut() {
            Some([_, last]) if last[1] == at[1] => *last = at,
            _ => self.ends.push([at, at]),
        }
    }

    fn ends(self) -> Vec<[f64; 2]> {
        self.ends.into_iter().flatten().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;
    use crate::geom::Object;
    use crate::mesh::TriangleMesh;

    /// Boxes of 10 mm along y, by their least and largest x and z.
    fn boxes(all: &[[f64; 4]]) -> TriangleMesh<Object> {
        let (mut points, mut facets) = (Vec::new(), Vec::new());
        for &[x0, z0, x1, z1] in all {
            let one = solid_box(Vec3::new(x0, 0.0, z0), Vec3::new(x1, 10.0, z1));
            let first = points.len() as u32;
            points.extend_from_slice(one.vertices());
            facets.extend(one.facets().iter().map(|f| f.map(|i| i + first)));
        }
        TriangleMesh::new(points, facets)
    }

    fn of(mesh: &TriangleMesh<Object>, up: Vec3) -> Supports {
        Supports::of(&Facets::of(mesh), &up, Angle::from_deg(45.0), 0.2, 0.25)
    }

    #[test]
    fn an_arm_and_a_shelf_by_hand() {
        // A C of 30 mm, 10 mm deep: foot, stem, and an arm 20 mm over the foot.
        let c = boxes(&[[0.0, 0.0, 30.0, 5.0], [0.0, 5.0, 5.0, 25.0], [0.0, 25.0, 30.0, 30.0]]);
        let supports = of(&c, Vec3::z());
        let near = |a: f64, b: f64| (a - b).abs() < 1e-6 * b.max(1.0);
        assert!(near(supports.volume_mm3, 25.0 * 10.0 * 20.0), "{supports:?}");
        assert!(near(supports.on_part_mm3, supports.volume_mm3) && near(supports.scar_mm2, 500.0), "{supports:?}");
        assert!(supports.feet.is_empty() && of(&c, Vec3::y()) == Supports::default());
    }

    #[test]
    fn what_is_less_than_a_layer_off_the_bed_costs_nothing() {
        let raised = |z: f64| boxes(&[[0.0, 0.0, 10.0, 5.0], [20.0, z, 30.0, 5.0]]);
        assert_eq!(of(&raised(0.1), Vec3::z()), Supports::default());
        let supports = of(&raised(1.0), Vec3::z());
        assert!((supports.volume_mm3 - 100.0).abs() < 1e-6 && (supports.feet_mm2 - 100.0).abs() < 1e-6);
        assert_eq!(supports.feet.len(), 80, "both ends of 40 rows");
    }
}
