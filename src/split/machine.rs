//! What a machine says to cuts: which directions it reaches, which pieces its head can print, whether all parts have a plan.

use crate::geom::{Object, Vec3};
use crate::mesh::{Model, TriangleMesh};
use crate::planning::OnePrint;

/// A machine as the search asks it; directions and meshes in the model file's frame, mm.
pub trait CutMachine: Sync {
    /// Whether `up` can be brought upright.
    fn reaches(&self, up: &Vec3) -> bool;

    /// Whether something can be laid at `place`, the lowest of a piece, along `up`, whatever stands. What is no to a place is no to the piece;
    /// this is only asked since it is the quicker question.
    fn prints_at(&self, _place: &Vec3, _up: &Vec3) -> bool {
        true
    }

    /// Whether `piece` can be printed along `up` while `standing` is there; `None` where nothing of it lies beyond the cut.
    fn prints(&self, piece: &TriangleMesh<Object>, up: &Vec3, standing: Option<&TriangleMesh<Object>>) -> bool;

    /// Whether all parts have a plan, each along its own direction; `supported` may overhang, and of `layered` it is known that no layer does.
    fn plans(&self, model: &Model, ups: &[Vec3], supported: &[usize], layered: &[usize]) -> bool;
}

impl CutMachine for OnePrint<'_> {
    fn reaches(&self, up: &Vec3) -> bool {
        Self::reaches(self, up)
    }

    fn prints_at(&self, place: &Vec3, up: &Vec3) -> bool {
        self.allows_place(place, up)
    }

    fn prints(&self, piece: &TriangleMesh<Object>, up: &Vec3, standing: Option<&TriangleMesh<Object>>) -> bool {
        self.allows(piece, up, standing)
    }

    fn plans(&self, model: &Model, ups: &[Vec3], supported: &[usize], layered: &[usize]) -> bool {
        Self::plans(self, model, ups, supported, layered)
    }
}

/// A head that is nowhere in the way, over a table that tilts up to so far from the level, radians: for figures that are to be
/// compared with those of methods without a machine.
#[derive(Clone, Copy, Debug)]
pub struct NoHead {
    /// Most tilt.
    pub most_tilt: f64,
}

impl CutMachine for NoHead {
    fn reaches(&self, up: &Vec3) -> bool {
        up.z >= self.most_tilt.cos() - 1e-9
    }

    fn prints(&self, _: &TriangleMesh<Object>, _: &Vec3, _: Option<&TriangleMesh<Object>>) -> bool {
        true
    }

    fn plans(&self, _: &Model, _: &[Vec3], _: &[usize], _: &[usize]) -> bool {
        true
    }
}
