//! The surfaces of the thesis: their files, frames and printed values.

use trunnion::geom::{Object, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::orient::{Facets, from_angles};

use super::super::sources::Run;

/// A surface and what is printed of it.
pub(super) struct Surface {
    pub(super) name: &'static str,
    pub(super) file: &'static str,
    /// Table 4.1.1.
    pub(super) facets: usize,
    /// Table 4.2.1: the angles of the minimum, radians.
    pub(super) x_min: [f64; 2],
    /// The frame in which these angles are right: of each axis, which of the file's and its sign.
    frame: [(usize, f64); 3],
    /// Table 3.1.1: angles in degrees, value as it lies, least value.
    pub(super) angles: [f64; 2],
    pub(super) initial: f64,
    pub(super) least: Option<f64>,
    /// Why the angles of table 4.2.1 differ from ours.
    pub(super) why: &'static str,
}

const AS_FILED: [(usize, f64); 3] = [(0, 1.0), (1, 1.0), (2, 1.0)];
const FIRST: &str = "the thesis takes the lowest point over each facet's first corner only";

#[allow(clippy::approx_constant, reason = "an angle as it is printed")]
pub(super) const SURFACES: [Surface; 7] = [
    Surface {
        name: "Arm",
        file: "arm.obj",
        facets: 16618,
        x_min: [-2.7444, 0.0799],
        frame: AS_FILED,
        angles: [-100.0, 54.0],
        initial: 2141.8,
        least: Some(409.98),
        why: FIRST,
    },
    Surface {
        name: "Horse",
        file: "horse_quad.obj",
        facets: 4796,
        x_min: [-1.4316, 0.2639],
        frame: AS_FILED,
        angles: [-60.0, -30.0],
        initial: 565.53,
        least: None,
        why: FIRST,
    },
    Surface {
        name: "Max",
        file: "decimated-max.obj",
        facets: 10540,
        x_min: [-2.9084, -0.0235],
        frame: [(0, -1.0), (2, 1.0), (1, 1.0)],
        angles: [64.0, -10.0],
        initial: 1051.7,
        least: Some(431.93),
        why: "printed in the frame (-x, z, y), in which it is compared; and the first corners",
    },
    Surface {
        name: "Knight",
        file: "decimated-knight.off",
        facets: 1000,
        x_min: [-1.4726, 0.0074],
        frame: [(0, 1.0), (2, -1.0), (1, 1.0)],
        angles: [-92.0, 30.0],
        initial: 120.44,
        least: Some(43.18),
        why: "printed in the frame (x, -z, y), in which it is compared; and the first corners",
    },
    Surface {
        name: "Bunny",
        file: "bunny.off",
        facets: 6966,
        x_min: [-0.1788, 0.5579],
        frame: AS_FILED,
        angles: [124.0, 46.0],
        initial: 812.80,
        least: Some(346.33),
        why: "the thesis's search stopped on a kink 0.1 % above the minimum",
    },
    Surface {
        name: "Camel",
        file: "camel_b.obj",
        facets: 3576,
        x_min: [2.9598, -1.4669],
        frame: AS_FILED,
        angles: [136.0, -2.0],
        initial: 235.29,
        least: Some(150.19),
        why: "the printed angles lie 4.6 degrees beside the least and are 0.6 % above it; the mesh is open",
    },
    Surface {
        name: "Cow",
        file: "cow.off",
        facets: 5520,
        x_min: [-1.5708, -0.0924],
        frame: AS_FILED,
        angles: [112.0, 42.0],
        initial: 883.05,
        least: Some(266.99),
        why: "",
    },
];

impl Surface {
    /// Its facets in the file's frame.
    pub(super) fn read(&self, run: &Run) -> Result<(TriangleMesh<Object>, Facets), String> {
        let mesh = run.mesh(self.file)?;
        let facets = Facets::of(&mesh);
        Ok((mesh, facets))
    }

    /// The direction of printed angles (radians) in the file's frame.
    pub(super) fn direction(&self, [alpha, beta]: [f64; 2]) -> Vec3 {
        let there = from_angles(alpha, beta);
        let mut own = Vec3::zeros();
        for (axis, (of, sign)) in self.frame.iter().enumerate() {
            own[*of] += sign * there[axis];
        }
        own
    }
}

/// The surface with this name.
pub(super) fn named(name: &str) -> &'static Surface {
    SURFACES.iter().find(|surface| surface.name == name).unwrap_or(&SURFACES[0])
}

impl Surface {
    /// The axis of the printed frame in the file's.
    pub(super) fn direction_axis(&self, axis: usize) -> Vec3 {
        let (of, sign) = self.frame[axis];
        Vec3::ith(of, sign)
    }
}
