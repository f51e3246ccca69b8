//! Poses in which a model may stand otherwise than it was drawn: what `orient` measured, by its price.

use super::arrange::{Arrangement, Models, PoseChoice, SetUp, arranged};
use super::error::StrategyError;
use super::price::WISH;
use crate::geom::Object;
use crate::input::{LoadedProfile, process_of};
use crate::mesh::TriangleMesh;
use crate::orient::{Facets, Priced, recommend};

/// Poses nearer to the drawn one than this are that one, by the cosine: two degrees.
const SAME_POSE: f64 = 0.999_39;
/// So many poses are planned.
const PLANNED: usize = 4;

/// Poses of a model, the cheapest first.
pub(super) struct Poses {
    /// As it was drawn.
    pub(super) drawn: Priced,
    /// Those in which it stands by itself.
    pub(super) others: Vec<Priced>,
    /// Those in which it does not, and may do so on supports.
    pub(super) shaky: Vec<Priced>,
}

/// Whether a model may be turned: one solid, with its copies, of which nobody said how it is to stand.
pub(super) fn may_turn(models: &Models<'_>, set: &SetUp) -> bool {
    let Arrangement { standing, copies, beside, .. } = models.how;
    *standing == PoseChoice::AsDrawn && beside.is_empty() && set.model.model.parts.len() == *copies
}

impl Poses {
    /// Those that `orient` finds for a solid.
    pub(super) fn of(solid: &TriangleMesh<Object>, machine: &LoadedProfile) -> Self {
        Self::that_fit(solid, machine, |_| true)
    }

    /// The same among those that `fit` on the table.
    pub(super) fn that_fit(
        solid: &TriangleMesh<Object>,
        machine: &LoadedProfile,
        fit: impl Fn(&Priced) -> bool,
    ) -> Self {
        let found = recommend(&Facets::of(solid), &process_of(machine), None, None);
        let mut all = found.poses;
        all.retain(|pose| pose.up.z < SAME_POSE && fit(pose));
        all.sort_by(|a, b| a.price_min.total_cmp(&b.price_min));
        let (mut others, mut shaky): (Vec<_>, Vec<_>) = all.into_iter().partition(|pose| pose.stands);
        others.truncate(PLANNED);
        shaky.truncate(PLANNED);
        Self { drawn: found.as_it_lies, others, shaky }
    }

    /// The one that costs the least, where that is less than a twentieth below what the drawn one does.
    pub(super) fn cheaper(&self) -> Option<&Priced> {
        self.others.first().filter(|pose| pose.price_min < WISH * self.drawn.price_min)
    }
}

/// The models with this direction of the file up.
///
/// # Errors
///
/// As [`arranged`].
pub(super) fn turned(models: &Models<'_>, up: [f64; 3]) -> Result<SetUp, StrategyError> {
    let how = Arrangement { standing: PoseChoice::Up(up), ..models.how.clone() };
    arranged(&Models { how: &how, ..*models })
}
