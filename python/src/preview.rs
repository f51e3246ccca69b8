//! Pages to look at: a program, a plan, the lack of one, or two of them side by side.

use std::path::Path;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};
use trunnion::document;
use trunnion::job::{self, MachineSource, Outputs, PlanRequest, PlanSource, PreviewRequest, Source, is_page};

use crate::call::{Call, Made, before_writing, claim, text};
use crate::given::{Given, Named, machine, source};
use crate::trouble::Trouble;
use crate::verbs::{arrangement, plan_options, supporting};

/// A program, its plan, and its model where that is in hand.
type Finished = (Option<Named>, Named, Option<Named>);

#[pyfunction]
pub(crate) fn preview(told: Bound<'_, PyAny>, given: Bound<'_, PyDict>) -> PyResult<Made> {
    let call = Call::of(told, given)?;
    let output = call.given.path("output")?;
    let requests = requests(&call.given)?;
    call.run(move |world| {
        output.as_deref().map(|path| is_page("output", path)).transpose()?;
        let file = claim(output.as_deref(), &mut Outputs::new(requests.iter().flat_map(files)))?;
        let shown = requests.iter().map(|one| job::preview(one, world)).collect::<Result<Vec<_>, _>>()?;
        let (page, mut document) = match &shown[..] {
            [one, other] => {
                let page = document::page_of_two([one, other]);
                let document = document::compared("", page.len(), [one, other]);
                (page, document)
            }
            [one] => {
                if !one.packed.has_text && one.scene.program.is_some() {
                    world.progress.warning(document::text::WITHOUT_LINES);
                }
                let page = document::page(one);
                let document = document::previewed("", page.len(), one);
                (page, document)
            }
            _ => return Err(Trouble::input("one or two are shown".to_owned())),
        };
        before_writing(world);
        let name = json!(output.as_ref().map(|path| path.display().to_string()));
        for page in document.get_mut("pages").and_then(Value::as_array_mut).into_iter().flatten() {
            page["output"] = name.clone();
        }
        document["output"] = name;
        file.map(|file| file.write(page.as_bytes())).transpose()?;
        Ok((text(&document), vec![("page", page.into_bytes())]))
    })
}

/// What is shown; two to compare.
fn requests(given: &Given<'_>) -> PyResult<Vec<PreviewRequest>> {
    let profile = || Ok::<_, PyErr>(given.named("profile")?.map(machine));
    let finished = |(program, plan, model): Finished| {
        let plan = PlanSource { plan: source(plan), model: model.map(source), machine: profile()? };
        Ok(match program {
            Some(program) => PreviewRequest::Program(source(program), plan),
            None => PreviewRequest::Plan(plan),
        })
    };
    let what = "a list of programs with their plans and models";
    let all: Option<Vec<Finished>> = given.of("finished", what, |all| all.extract().ok())?;
    if let Some(all) = all {
        return all.into_iter().map(finished).collect();
    }
    let Some(model) = given.named("planned")? else { return Ok(Vec::new()) };
    Ok(vec![PreviewRequest::Model(Box::new(PlanRequest {
        model: given.model(model)?,
        machine: profile()?.unwrap_or_else(|| MachineSource::from("")),
        arrangement: arrangement(given, None)?,
        options: plan_options(given)?,
        supporting: supporting(given, ["never", "auto"])?,
    }))])
}

/// The files that are read.
fn files(request: &PreviewRequest) -> Vec<&Path> {
    let all = match request {
        PreviewRequest::Program(program, plan) => [vec![program.path()], of_plan(plan)].concat(),
        PreviewRequest::Plan(plan) => of_plan(plan),
        PreviewRequest::Model(request) => {
            let beside = request.arrangement.beside.iter().map(|(model, _)| model);
            let models = std::iter::once(&request.model).chain(beside);
            models.map(|model| model.source.path()).chain([request.machine.path()]).collect()
        }
    };
    all.into_iter().flatten().collect()
}

fn of_plan(of: &PlanSource) -> Vec<Option<&Path>> {
    let PlanSource { plan, model, machine } = of;
    vec![plan.path(), model.as_ref().and_then(Source::path), machine.as_ref().and_then(MachineSource::path)]
}
