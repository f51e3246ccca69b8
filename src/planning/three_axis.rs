//! What plain printing in three axes on supports would take: the yardstick for "is it worth it?".
//!
//! The whole model in one pose, all parts along one direction, supports below everything that overhangs, down to the table or to what
//! lies below (the column volume of `orient`). Which pose is the caller's: as it stands, or the one that a person would choose.

use super::pricing::{Begins, print_seconds, support_seconds};
use super::workpiece::Workpiece;
use crate::geom::{Angle, Dir, Table, Vec3};
use crate::mesh::TriangleMesh;
use crate::orient::{Facets, Objective, Staircase, SupportVolumeColumn};
use crate::profile::Profile;

/// Printing the whole in one pose, on supports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreeAxis {
    /// The build direction, unit, table frame of the model as it was placed.
    pub up: Vec3,
    /// Estimated seconds, supports included.
    pub seconds: f64,
    /// Column volume of the supports, to 0.5 mm, mm³.
    pub support_mm3: f64,
    /// Staircase error of the whole surface, mm⁴.
    pub staircase: f64,
}

/// Width of the support columns, mm.
const COLUMN_MM: f64 = 0.5;

/// The yardstick of `workpiece` along `up`, with overhangs up to `overhang` free.
pub fn three_axis(workpiece: &Workpiece<'_>, profile: &Profile, overhang: Angle, up: Dir<Table>) -> ThreeAxis {
    let staircase = Staircase { layer_mm: profile.process.layer_height_mm };
    let columns = SupportVolumeColumn { overhang, resolution_mm: COLUMN_MM };
    let support_mm3 = columns.value(&Facets::of(&whole(workpiece)), up.unit());
    // All at once: no part begins on one that is cold.
    let printing: f64 = workpiece.parts.iter().map(|part| print_seconds(part, up, profile, Begins::OnTable)).sum();
    ThreeAxis {
        up: *up.unit(),
        seconds: printing + support_seconds(support_mm3, profile),
        support_mm3,
        staircase: workpiece.parts.iter().map(|part| staircase.value(&Facets::of(part), up.unit())).sum(),
    }
}

/// All parts as one surface: where two touch, nothing hangs.
pub fn whole(workpiece: &Workpiece<'_>) -> TriangleMesh<Table> {
    TriangleMesh::joined(&workpiece.parts)
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
            let of = |up| three_axis(&workpiece, &profile, Angle::from_deg(45.0), Dir::new(up).unwrap());
            [of(Vec3::z()), of(Vec3::y())]
        };
        // 30 x 20 mm, 40 mm above the table.
        let [boxes, on_its_side] = of(two_boxes());
        assert!((boxes.support_mm3 - 24_000.0).abs() < 24_000.0 * 0.02, "{boxes:?}");
        assert!(on_its_side.support_mm3 < 1.0 && on_its_side.seconds < boxes.seconds, "{on_its_side:?}");
        let [cube, _] = of(cube());
        assert_eq!((cube.support_mm3, cube.staircase), (0.0, 0.0));
    }
}
