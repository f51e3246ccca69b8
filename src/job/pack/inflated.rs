//! Models with many facets packed as coarser meshes around them: what keeps away from those keeps away from the models.

use super::{BadPacking, LoadedModel};
use crate::mesh::{TriangleMesh, containing};
use crate::pack::{Ended, PackGoal, PackSolid, Packed, Room, packing_bound};

/// Models as they are packed with `--inflate`.
pub(super) struct Inflated {
    /// Around each of the models, with the model's own volume and value.
    pub(super) solids: Vec<PackSolid>,
    /// What became of the facets.
    pub(super) tally: Coarsened,
}

/// How much coarser the meshes are that were packed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coarsened {
    /// Facets of all models.
    pub facets: usize,
    /// Facets of what was packed for them.
    pub packed_facets: usize,
    /// How far a vertex was raised above the planes of what it replaced, at most, mm.
    pub raised_mm: f64,
}

impl Inflated {
    /// Meshes of as few facets as there are with vertices raised by `most_mm`.
    pub(super) fn of(models: &[(LoadedModel, usize)], solids: &[PackSolid], most_mm: f64) -> Self {
        let mut tally = Coarsened { facets: 0, packed_facets: 0, raised_mm: 0.0 };
        let around = models.iter().zip(solids).map(|((loaded, _), solid)| {
            let parts = loaded.model.parts.iter().map(|part| containing(&part.mesh, 0, most_mm));
            let parts: Vec<_> = parts.collect();
            tally.raised_mm = parts.iter().map(|part| part.raised_mm).fold(tally.raised_mm, f64::max);
            let meshes: Vec<&TriangleMesh<_>> = parts.iter().map(|part| &part.mesh).collect();
            let coarse = PackSolid::of(meshes, solid.value, solid.copies);
            tally.facets += solid.facets.len();
            tally.packed_facets += coarse.facets.len();
            // Bounds are of what is printed.
            PackSolid { volume_mm3: solid.volume_mm3, ..coarse }
        });
        Self { solids: around.collect(), tally }
    }

    /// What was found for these as a packing of the models themselves.
    pub(super) fn of_models(&self, packed: Packed, solids: &[PackSolid], room: &Room, goal: PackGoal) -> Packed {
        let bound = packing_bound(solids, room, goal);
        // A height that nothing lower was possible for with what was packed may be one for the models.
        let proved =
            packed.ended == Ended::Proved && (goal != PackGoal::Height || packed.bound <= bound * (1.0 + 1e-9));
        let ended = if packed.ended == Ended::Proved && !proved { Ended::Steps } else { packed.ended };
        Packed { bound, ended, ..packed }
    }

    /// Why model `name` does not fit, where it does as it is.
    pub(super) fn too_large(name: &str) -> BadPacking {
        BadPacking::Inflate(format!(
            "{name} fits in the space only as it is; leave out --inflate, or use a smaller value"
        ))
    }
}
