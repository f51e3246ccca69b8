//! What the page draws before anything is planned: the machine at rest, and the parts of a model.

use serde_json::{Value, json};

use super::WorkbenchError;
use super::choices::is_file;
use crate::document;
use crate::geom::Object;
use crate::job::{self, LoadedProfile, MachineSource, ModelSource, Source, World};
use crate::mesh::{ProjectPlates, TriangleMesh, Unit};
use crate::overhang::OverhangRule;
use crate::profile::{Base, shipped};
use crate::view::{DrawnMachine, Shapes};

/// The machine, to be drawn, and the steepest slope that needs no support on it, degrees; or why it cannot be read.
pub(super) fn machine(name: &str, world: &World<'_>) -> Value {
    match job::load_profile(&MachineSource::from(name), world) {
        Ok(loaded) => drawn(&loaded),
        Err(error) => refused(&error.into()),
    }
}

/// The text of a machine's profile that is none of the shipped ones, without other files: as it is where it extends none, else all its values.
///
/// # Errors
///
/// [`WorkbenchError::BadMachine`].
pub(super) fn profile(name: &str, world: &World<'_>) -> Result<Option<String>, WorkbenchError> {
    if !is_file(name) && shipped(name).is_ok() {
        return Ok(None);
    }
    let bad = |why: &dyn std::fmt::Display| WorkbenchError::BadMachine { why: why.to_string() };
    let loaded = job::load_profile(&MachineSource::from(name), world).map_err(|error| bad(&error))?;
    let own = world.files.read(std::path::Path::new(name)).ok().and_then(|bytes| String::from_utf8(bytes).ok());
    let alone = own.filter(|text| !matches!(Base::of(name, text), Ok(Base::File(_)) | Err(_)));
    alone.map_or_else(|| toml::to_string(&loaded.profile).map_err(|error| bad(&error)), Ok).map(Some)
}

fn drawn(loaded: &LoadedProfile) -> Value {
    let profile = &loaded.profile;
    let (head, frame) = (profile.head_bodies(), profile.fixed_bodies());
    let machine = DrawnMachine::of(profile.kinematics(), profile.linear_limits(), &profile.table_slab(), &head, &frame);
    let process = &profile.process;
    let steepest = OverhangRule::practised(process.layer_height_mm, process.line_width_mm);
    json!({"machine": document::drawn_machine(&profile.machine.name, &machine), "steepest_deg": steepest.deg()})
}

fn refused(error: &job::Error) -> Value {
    document::failed(error.code(), &error.to_string(), document::exit_code(error), error.location().as_ref(), None)
}

/// The parts of a model in its own coordinates: a JSON document behind its length (four bytes, the lowest first), then corners and facets, each
/// behind its length.
///
/// # Errors
///
/// Why it cannot be read, as a document.
pub(super) fn model(path: &str, unit: &str, plate: &str, world: &World<'_>) -> Result<Vec<u8>, Value> {
    let unit = unit.parse::<Unit>().ok();
    let plates = plate.parse().map_or(ProjectPlates::All, ProjectPlates::Number);
    let source = ModelSource { unit, plates, ..ModelSource::from(Source::from(std::path::Path::new(path))) };
    let loaded = job::load_model(&source, world).map_err(|error| refused(&error.into()))?;
    let solids: Vec<TriangleMesh<Object>> = loaded.model.parts.iter().map(|part| part.mesh.clone()).collect();
    let shapes = Shapes::of(&solids);
    let named = loaded.model.parts.iter().zip(&shapes.counts);
    let parts: Vec<Value> = named
        .map(|(part, [vertices, facets])| json!({"name": part.name, "vertices": vertices, "facets": facets}))
        .collect();
    let head = json!({"parts": parts, "thinned": shapes.thinned}).to_string();
    let mut out = (head.len() as u32).to_le_bytes().to_vec();
    out.extend(head.bytes());
    shapes.append(&mut out);
    Ok(out)
}
