//! Grids for supports, as large as memory allows.

use crate::geom::{Bounds, Slot, Vec3};
use crate::input::BadSetting;
use crate::mesh::TriangleMesh;
use crate::support::Grid;

/// What may stand out of the space: the last digit of a float in a file.
pub(crate) const OUTSIDE_MM: f64 = 1e-3;
/// Steps around the model's box where no space is given.
const AROUND: f64 = 5.0;
/// Cubes of a grid, at most: with 50 bytes each they fit in 2 GB.
const MOST_CUBES: f64 = 4e7;

/// The grid over parts and some steps around them, on the ground at z = 0; `name` is what the step is called where it was given.
pub(crate) fn grid_over(meshes: &[&TriangleMesh<Slot>], name: &'static str, step: f64) -> Result<Grid, BadSetting> {
    let bounds = meshes.iter().fold(Bounds::EMPTY, |all, mesh| all.union(&mesh.bounds()));
    let around = Vec3::new(AROUND * step, AROUND * step, 0.0);
    let origin = Vec3::new(bounds.min.x, bounds.min.y, 0.0) - around;
    // A level above the top, so that it lies in none of the grid's planes.
    let size = bounds.max + around + Vec3::z() * step - origin;
    if bounds.min.z < -OUTSIDE_MM {
        let (low, high) = (bounds.min.z, bounds.max.z);
        return Err(BadSetting::OutsideSpace { axis: "z", low, high, space: [0.0, high.max(0.0)] });
    }
    fitting(origin, size.into(), name, step)
}

/// A grid, where it fits in memory.
pub(crate) fn fitting(origin: Vec3, space: [f64; 3], name: &'static str, step: f64) -> Result<Grid, BadSetting> {
    let cubes = Grid::cubes_needed(space, step);
    if cubes > MOST_CUBES {
        // A little more than the root says, for the cubes that stand out of the space.
        let fits = step * (cubes / MOST_CUBES).cbrt() * 1.02;
        return Err(BadSetting::TooFine { name, step, cubes, most: MOST_CUBES, fits: (fits * 100.0).ceil() / 100.0 });
    }
    Ok(Grid::over(origin, space, step))
}
