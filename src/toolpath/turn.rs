//! A turn about the vertical, for prints that were turned on the slicer's bed.

use crate::geom::Vec3;

/// A turn about the file's origin, counter-clockwise seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    cos: f64,
    sin: f64,
}

impl Turn {
    pub(super) fn by(radians: f64) -> Self {
        let (sin, cos) = radians.sin_cos();
        Self { cos, sin }
    }

    /// A place or a way in the plane, turned.
    pub(super) fn flat(self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }

    /// A place, turned.
    pub(super) fn point(self, p: Vec3) -> Vec3 {
        let [x, y] = self.flat([p.x, p.y]);
        Vec3::new(x, y, p.z)
    }
}
