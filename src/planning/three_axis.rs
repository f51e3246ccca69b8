//! What plain printing in three axes on supports would take: the yardstick for "is it worth it?".
//!
//! The whole model as it stands on the table, every part along the table's normal, supports below everything that
//! overhangs, down to the table or to what lies below (the column volume of `orient`).

use super::pricing::{print_seconds, support_seconds};
use super::workpiece::Workpiece;
use crate::geom::{Angle, Dir, Table, Vec3};
use crate::mesh::TriangleMesh;
use crate::orient::{Facets, Objective, Staircase, SupportVolumeColumn};
use crate::profile::Profile;

/// Printing the whole upright, on supports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreeAxis {
    /// Estimated seconds, supports included.
    pub seconds: f64,
    /// Column volume of the supports, to 0.5 mm, mm³.
    pub support_mm3: f64,
    /// Staircase error of the whole surface, mm⁴.
    pub staircase: f64,
}

/// Width of the support columns, mm.
const COLUMN_MM: f64 = 0.5;

/// The yardstick of `workpiece` where it stands, with overhangs up to `overhang` free.
pub fn three_axis(workpiece: &Workpiece<'_>, profile: &Profile, overhang: Angle) -> ThreeAxis {
    let up = Dir::<Table>::z();
    let staircase = Staircase { layer_mm: profile.process.layer_height_mm };
    let columns = SupportVolumeColumn { overhang, resolution_mm: COLUMN_MM };
    let support_mm3 = columns.value(&Facets::of(&whole(workpiece)), up.unit());
    let printing: f64 = workpiece.parts.iter().map(|part| print_seconds(part, up, profile)).sum();
    ThreeAxis {
        seconds: printing + support_seconds(support_mm3, profile),
        support_mm3,
        staircase: workpiece.parts.iter().map(|part| staircase.value(&Facets::of(part), up.unit())).sum(),
    }
}

/// All parts as one surface: where two touch, nothing hangs.
fn whole(workpiece: &Workpiece<'_>) -> TriangleMesh<Table> {
    let mut vertices: Vec<Vec3> = Vec::new();
    let mut facets = Vec::new();
    for part in &workpiece.parts {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(part.vertices());
        facets.extend(part.facets().iter().map(|f| f.map(|corner| corner + first)));
    }
    TriangleMesh::new(vertices, facets)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{cube, two_boxes};
    use crate::mesh::Model;
    use crate::profile::{resolve, shipped};

    #[test]
    fn the_beam_beside_the_post_stands_on_a_column_of_its_own_footprint() {
        let (file, text) = shipped("generic-ac").unwrap();
        let profile = resolve(file, text).unwrap().0;
        let of = |fixture: crate::fixtures::Fixture| {
            let model = Model::from_parts(fixture.parts);
            let workpiece = Workpiece::place(&model, &Workpiece::centred(&model));
            three_axis(&workpiece, &profile, Angle::from_deg(45.0))
        };
        // 30 x 20 mm, 40 mm above the table.
        let boxes = of(two_boxes());
        assert!((boxes.support_mm3 - 24_000.0).abs() < 24_000.0 * 0.02, "{boxes:?}");
        let cube = of(cube());
        assert_eq!((cube.support_mm3, cube.staircase), (0.0, 0.0));
    }
}
