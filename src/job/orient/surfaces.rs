//! What orientations are looked for of: a model's parts, all of it as one, or an open surface.

use super::error::OrientError;
use super::{OrientAsked, OrientRequest, PartChoice};
use crate::geom::Object;
use crate::input::{BadSetting, InputError, ModelSource};
use crate::input::{load_unposed, memory};
use crate::mesh::{Fanned, Fault, MeshError, ReadOptions, Repair, TriangleMesh, fanned, read_surface};
use crate::spelling::counted;
use crate::world::World;

pub(super) type Numbered = (usize, TriangleMesh<Object>);

/// Holes are closed by fans where these are at most this share of the surface.
const SMALL_HOLES: f64 = 0.02;

/// The model's closed parts; or its open surface as one, where no volume is asked for or its holes are small.
pub(super) fn meshes(
    request: &OrientRequest,
    asked: &OrientAsked,
    world: &World<'_>,
) -> Result<Vec<Numbered>, OrientError> {
    let error = match load_unposed(&request.model, world) {
        Ok(loaded) if request.parts == PartChoice::Whole => {
            return Ok(vec![(0, TriangleMesh::joined(loaded.model.parts.iter().map(|part| &part.mesh)))]);
        }
        Ok(loaded) => return Ok(loaded.model.parts.into_iter().map(|part| (part.id, part.mesh)).collect()),
        // What it is as it was read: a plane surface that was closed by its own shadow encloses nothing.
        Err(InputError::Mesh(error)) => {
            let as_read = ModelSource { repair: Repair::Off, ..request.model.clone() };
            if let Err(InputError::Mesh(error)) = load_unposed(&as_read, world) { error } else { error }
        }
        Err(other) => return Err(other.into()),
    };
    let open = matches!(error.fault, Fault::Open { .. } | Fault::Winding { .. });
    if !open {
        return Err((*error).into());
    }
    if let Some(objective) = asked.closed_only().or_else(|| request.options.compare.then(|| "a comparison".to_owned()))
    {
        let needed = |source| OrientError::NeedsClosed { source, objective };
        let is_hole = matches!(error.fault, Fault::Open { .. });
        let closed = if is_hole { fanned(&surface(&request.model, world)?) } else { None };
        let share = |closed: &Fanned<Object>| closed.area_mm2 / closed.mesh.area();
        let Some(closed) = closed.filter(|closed| share(closed) <= SMALL_HOLES) else { return Err(needed(error)) };
        world.progress.warning(&format!(
            "{error}: {} closed with triangle fans for this calculation ({:.2} mm2, {:.2} % of the surface); the model is not changed",
            counted(closed.holes, "hole"),
            closed.area_mm2,
            100.0 * share(&closed)
        ));
        return Ok(vec![(0, closed.mesh)]);
    }
    world.progress.warning(&format!("{error}: treated as one surface, since no volume is needed"));
    surface(&request.model, world).map(|mesh| vec![(0, mesh)])
}

fn surface(model: &ModelSource, world: &World<'_>) -> Result<TriangleMesh<Object>, OrientError> {
    let bytes = model.source.bytes(world)?;
    memory::of_model(&model.source.name(), &bytes, model.plates, world)?;
    let options = ReadOptions { unit: model.unit, repair: Repair::Off, plates: model.plates };
    let read: Result<_, MeshError> = read_surface(&bytes, &model.source.name(), &options);
    Ok(read?)
}

/// The parts that were asked for.
pub(super) fn chosen(request: &OrientRequest, mut parts: Vec<Numbered>) -> Result<Vec<Numbered>, BadSetting> {
    let PartChoice::Numbered(wanted) = &request.parts else { return Ok(parts) };
    let last = parts.len() - 1;
    if let Some(range) = wanted.iter().find(|range| *range.end() > last) {
        let model = request.model.source.name().into_owned();
        return Err(BadSetting::NoSuchPart { name: "part", given: *range.end(), last, model });
    }
    parts.retain(|(id, _)| wanted.iter().any(|range| range.contains(id)));
    Ok(parts)
}
