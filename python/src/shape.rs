//! Supports, and models or boxes packed.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trunnion::document;
use trunnion::geom::Vec3;
use trunnion::job::{
    self, Contents, MachineSource, ModelSource, PackInto, PackOptions, PackRequest, PackSpace, PictureFile, Plates,
    SupportForm, SupportOptions, SupportRequest, is_3mf,
};
use trunnion::mesh::ProjectPlates;

use crate::call::{Call, Made, before_writing, claim, read, text};
use crate::given::{Given, Named, machine, numbers, source};
use crate::trouble::Trouble;

#[pyfunction]
pub(crate) fn support(model: Named, told: Bound<'_, PyAny>, given: Bound<'_, PyDict>) -> PyResult<Made> {
    let call = Call::of(told, given)?;
    let given = &call.given;
    let [output, view] = [given.path("output")?, given.path("view")?];
    let request = SupportRequest { model: given.model(model)?, options: support_options(given)? };
    call.run(move |world| {
        output.as_deref().map(is_3mf).transpose()?;
        let mut outputs = read([&request.model], None);
        let file = claim(output.as_deref(), &mut outputs)?;
        let viewed = PictureFile::claim("view", view.as_deref(), &mut outputs)?;
        let done = job::support(&request, world)?;
        before_writing(world);
        let (document, mut made) = (document::supported(&done), Vec::new());
        if !done.graph.red.is_empty() {
            file.map(|file| file.write(&done.file(file.path())?).map_err(Trouble::from)).transpose()?;
            made.extend([("supports", done.stl()), ("model", done.threemf())]);
        }
        viewed.map(|viewed| viewed.write(&done.view())).transpose()?;
        match done.why_not() {
            Some(why) => Err(Trouble::with(why, 1, &document)),
            None => Ok((text(&document), made)),
        }
    })
}

fn support_options(given: &Given<'_>) -> PyResult<SupportOptions> {
    let usual = SupportOptions::default();
    let few = |name: &str| given.of(name, "a whole number from 1 to 1000", |value| value.extract::<u16>().ok());
    Ok(SupportOptions {
        up: given.vector("up")?.map_or(usual.up, Vec3::from),
        keep_z: given.flag("keep_z")?,
        step_mm: given.number("step_mm")?.unwrap_or(usual.step_mm),
        space_mm: given.vector("space_mm")?,
        overhang_deg: given.number("overhang_deg")?.unwrap_or(usual.overhang_deg),
        capacity: few("capacity")?.unwrap_or(usual.capacity),
        node_capacity: few("node_capacity")?,
        method: given.text("method")?.unwrap_or(usual.method),
        structure: given.text("structure")?.unwrap_or(usual.structure),
        wall_mm: given.number("wall_mm")?,
        gap_mm: given.number("gap_mm")?.unwrap_or(usual.gap_mm),
        touch_every: few("touch_every")?.unwrap_or(usual.touch_every),
        form: SupportForm {
            roof_mm: given.number("roof_mm")?.unwrap_or(usual.form.roof_mm),
            roof_pitch_mm: given.number("roof_pitch_mm")?,
            brace_mm: given.number("brace_mm")?.unwrap_or(usual.form.brace_mm),
        },
        seed: given.count("seed")?.map_or(usual.seed, |seed| seed as u64),
    })
}

#[pyfunction]
pub(crate) fn pack(told: Bound<'_, PyAny>, given: Bound<'_, PyDict>) -> PyResult<Made> {
    let call = Call::of(told, given)?;
    let given = &call.given;
    let [output, view] = [given.path("output")?, given.path("view")?];
    let request = PackRequest { contents: contents(given)?, into: into(given)?, options: pack_options(given)? };
    call.run(move |world| {
        let mut outputs = match (&request.contents, &request.into) {
            (Contents::Models(models), PackInto::Table(machine)) => {
                read(models.iter().map(|(model, _)| model), Some(machine))
            }
            (Contents::Models(models), PackInto::Space(_)) => read(models.iter().map(|(model, _)| model), None),
            (Contents::Boxes(boxes), _) => read([&ModelSource::from(boxes.clone())], None),
        };
        let plates = output.as_deref().map(|folder| Plates::claim(folder, &mut outputs)).transpose()?;
        let viewed = PictureFile::claim("view", view.as_deref(), &mut outputs)?;
        // Ctrl-C ends the call, as it does every other.
        let done = job::pack(&request, &|| false, world)?;
        before_writing(world);
        let earlier = plates.map(|plates| plates.write(&done, &mut outputs)).transpose()?.unwrap_or_default();
        let aside = earlier.iter().filter_map(|plate| plate.set_aside().transpose()).collect::<Result<Vec<_>, _>>()?;
        viewed.map(|viewed| viewed.write(&done.view())).transpose()?;
        for aside in aside {
            world.progress.warning(&document::text::set_aside(&aside));
        }
        let made = (0..done.plates.len()).map(|plate| ("plate", done.threemf(plate)));
        Ok((text(&document::packed(&done)), made.collect()))
    })
}

fn contents(given: &Given<'_>) -> PyResult<Contents> {
    if let Some(boxes) = given.named("boxes")? {
        return Ok(Contents::Boxes(source(boxes)));
    }
    let what = "a list of pairs of model and number of copies";
    let models: Option<Vec<(Named, usize)>> = given.of("models", what, |all| all.extract().ok())?;
    let of = |(model, count)| Ok((ModelSource { plates: ProjectPlates::All, ..given.model(model)? }, count));
    Ok(Contents::Models(models.unwrap_or_default().into_iter().map(of).collect::<PyResult<_>>()?))
}

/// A space, or else a machine's table.
fn into(given: &Given<'_>) -> PyResult<PackInto> {
    let lengths = |value: &Bound<'_, PyAny>| match numbers(value)?[..] {
        [x, y] => Some(PackSpace { base_mm: [x, y], height_mm: None }),
        [x, y, z] => Some(PackSpace { base_mm: [x, y], height_mm: Some(z) }),
        _ => None,
    };
    let space = given.of("space_mm", "2 or 3 finite numbers", lengths)?.map(PackInto::Space);
    let table = || Ok(PackInto::Table(given.named("profile")?.map_or_else(|| MachineSource::from(""), machine)));
    space.map_or_else(table, Ok)
}

fn pack_options(given: &Given<'_>) -> PyResult<PackOptions> {
    let usual = PackOptions::default();
    let few = |name: &str| given.of(name, "a whole number of at least 0", |value| value.extract::<u32>().ok());
    Ok(PackOptions {
        gap_mm: given.number("gap_mm")?,
        turn: given.text("turn")?.unwrap_or(usual.turn),
        goal: given.text("goal")?,
        fill: given.text("fill")?,
        method: given.text("method")?.unwrap_or(usual.method),
        near: few("used_distance")?.zip(few("direction_distance")?).map(<[u32; 2]>::from),
        seconds: given.number("time_s")?,
        inflate_mm: given.number("inflate_mm")?,
        no_interlock: given.flag("no_interlock")?,
        seed: given.count("seed")?.map_or(usual.seed, |seed| seed as u64),
    })
}
