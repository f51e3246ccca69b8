//! The verbs: arguments to requests, results to documents. Files are claimed before the work and written after it, as the command does.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};
use trunnion::document;
use trunnion::job::{
    self, Arrangement, Cutting, Finish, GivenCut, ModelSource, OrientOptions, OrientRequest, OutputFile, PartChoice,
    PictureFile, PlaceRequest, PlanOptions, PlanRequest, PlanSource, PoseChoice, PrepareRequest, SlicingOptions,
    SplitOptions, SplitRequest, SupportForm, Supporting, VerifyRequest, WaysOut, World,
};
use trunnion::planning::Priority;
use trunnion::strategy::StrategyError;
use trunnion::strategy::Way;
use trunnion::world::FileError;

use crate::call::{Call, Made, before_writing, claim, read, text};
use crate::given::{Given, Named, machine, source};
use crate::trouble::Trouble;

#[pyfunction]
pub(crate) fn inspect(model: Named, told: Bound<'_, PyAny>, given: Bound<'_, PyDict>) -> PyResult<Made> {
    let call = Call::of(told, given)?;
    let model = call.given.model(model)?;
    call.run(move |world| {
        let loaded = job::load_model(&model, world)?;
        Ok((text(&document::inspected(&loaded.model)), Vec::new()))
    })
}

#[pyfunction]
pub(crate) fn orient(model: Named, told: Bound<'_, PyAny>, given: Bound<'_, PyDict>) -> PyResult<Made> {
    let call = Call::of(told, given)?;
    let given = &call.given;
    let usual = OrientOptions::default();
    let options = OrientOptions {
        objectives: given.texts("objective")?.unwrap_or(usual.objectives),
        method: given.text("method")?.unwrap_or(usual.method),
        budget: given.count("budget")?,
        seed: given.count("seed")?.map_or(usual.seed, |seed| seed as u64),
        overhang_deg: given.number("overhang_deg")?.unwrap_or(usual.overhang_deg),
        layer_mm: given.number("layer_mm")?,
        machine: given.named("profile")?.map(machine),
        up: given.vector("up")?,
        resolution_mm: given.number("resolution_mm")?,
        smooth_k: given.number("smooth_k")?.unwrap_or(usual.smooth_k),
        smooth_w: given.number("smooth_w")?.unwrap_or(usual.smooth_w),
        carrying_deg: given.number("carrying_deg")?.unwrap_or(usual.carrying_deg),
        contact_mm2: given.number("contact_area_min_mm2")?,
        compare: given.flag("compare")?,
    };
    let numbers: Option<Vec<usize>> = given.of("parts", "a list of part numbers", |all| all.extract().ok())?;
    let parts = match (numbers, given.flag("whole")?) {
        (Some(numbers), _) => PartChoice::Numbered(numbers.into_iter().map(|part| part..=part).collect()),
        (None, true) => PartChoice::Whole,
        (None, false) => PartChoice::Each,
    };
    let [output, landscape, view] = [given.path("output")?, given.path("landscape")?, given.path("view")?];
    let only_one = landscape.is_some() || view.is_some();
    let request = OrientRequest { model: given.model(model)?, parts, only_one, options };
    call.run(move |world| {
        let mut outputs = read([&request.model], None);
        let file = claim(output.as_deref(), &mut outputs)?;
        let drawn = PictureFile::claim("landscape", landscape.as_deref(), &mut outputs)?;
        let viewed = PictureFile::claim("view", view.as_deref(), &mut outputs)?;
        let done = job::orient(&request, world)?;
        before_writing(world);
        let part = &done.parts[0];
        if let Some(file) = &file {
            let as_3mf = file.path().extension().is_some_and(|end| end.eq_ignore_ascii_case("3mf"));
            file.write(&done.upright(as_3mf))?;
        }
        drawn.map(|drawn| drawn.write(&done.landscape(part))).transpose()?;
        viewed.map(|viewed| viewed.write(&done.view(part))).transpose()?;
        Ok((text(&document::orientations(&request.model.source.name(), &done)), Vec::new()))
    })
}

/// Which way the model stands.
fn standing(given: &Given<'_>) -> PyResult<PoseChoice> {
    if let Some(part) = given.count("base")? {
        return Ok(PoseChoice::On(part));
    }
    if given.any("up")?.is_some_and(|up| up.extract::<String>().is_ok_and(|word| word == "auto")) {
        return Ok(PoseChoice::Recommended);
    }
    Ok(given.vector("up")?.map_or(PoseChoice::AsDrawn, PoseChoice::Up))
}

pub(crate) fn arrangement(given: &Given<'_>, file: Option<&Path>) -> PyResult<Arrangement> {
    let usual = Arrangement::default();
    let beside: Vec<(Named, usize)> = given
        .of("beside", "a list of pairs of model and number of copies", |all| all.extract().ok())?
        .unwrap_or_default();
    let beside = beside.into_iter().map(|(model, count)| Ok((given.model(model)?, count)));
    Ok(Arrangement {
        snap_mm: given.number("snap_mm")?.unwrap_or(usual.snap_mm),
        join: given.flag("join")?,
        standing: standing(given)?,
        copies: given.count("copies")?.unwrap_or(usual.copies),
        beside: beside.collect::<PyResult<_>>()?,
        gap_mm: given.number("gap_mm")?,
        file: file.map(|path| path.display().to_string()),
    })
}

pub(crate) fn plan_options(given: &Given<'_>) -> PyResult<PlanOptions> {
    let usual = PlanOptions::default();
    let (origin_mm, turn_deg) = (given.vector("origin_mm")?, given.number("turn_deg")?);
    let placed = origin_mm.is_some() || turn_deg.is_some();
    let allow: Vec<(usize, Option<f64>)> =
        given.of("allow", "a list of pairs of part and mm2", |all| all.extract().ok())?.unwrap_or_default();
    let order = given.text("order")?.map(|text| job::ordered(&text)).transpose();
    Ok(PlanOptions {
        objective: given.text("objective")?.unwrap_or(usual.objective),
        orient_by: given.text("orient_by")?,
        method: given.text("method")?,
        orient_budget: given.count("orient_budget")?,
        overhang_deg: given.number("overhang_deg")?,
        finish: [Finish::Practised, Finish::Fine][given.word("finish", &["practised", "fine"])?],
        bridge_mm: given.number("bridge_mm")?,
        tolerate_mm2: given.number("tolerate_mm2")?.unwrap_or(usual.tolerate_mm2),
        allow,
        margin_mm: given.number("margin_mm")?.unwrap_or(usual.margin_mm),
        priority: [Priority::Together, Priority::Single, Priority::OnlySingle]
            [given.word("slots", &["together", "single", "only-single"])?],
        table_first: !given.flag("table_later")?,
        order: order.map_err(|error| Trouble::from(job::Error::from(error)).raised(given.py()))?.unwrap_or_default(),
        seed: given.count("seed")?.map_or(usual.seed, |seed| seed as u64),
        place: placed.then(|| PlaceRequest { origin_mm, turn_deg: turn_deg.unwrap_or(0.0) }),
        explain: true,
        remedies: !given.flag("no_remedies")?,
        form: SupportForm {
            roof_mm: given.number("roof_mm")?.unwrap_or(usual.form.roof_mm),
            roof_pitch_mm: given.number("roof_pitch_mm")?,
            brace_mm: given.number("brace_mm")?.unwrap_or(usual.form.brace_mm),
        },
        budget: given.count("budget")?.map_or(usual.budget, |budget| budget as u64),
        kept_in: None,
        plans: given.count("top")?.unwrap_or(usual.plans),
    })
}

fn slicing(given: &Given<'_>) -> PyResult<SlicingOptions> {
    let usual = SlicingOptions::default();
    let bed = given.text("bed")?.map(|text| job::bed(&text)).transpose();
    Ok(SlicingOptions {
        slicer: given.text("slicer")?.and_then(|word| word.parse().ok()).unwrap_or(usual.slicer),
        configs: given.paths("slicer_config")?,
        timeout: given.number("slicer_timeout_s")?.map_or(Ok(usual.timeout), given.seconds("slicer_timeout_s"))?,
        bed: bed.map_err(|error| Trouble::from(error).raised(given.py()))?.unwrap_or(usual.bed),
    })
}

/// The file beside `output` for a model that is not as it was read.
fn parts_file(output: &Path) -> PathBuf {
    output.with_extension("parts.3mf")
}

/// Writes it where there is an output, and gives it back where there is none.
fn keep_parts(
    (path, file): (Option<&Path>, Option<&OutputFile>),
    bytes: &[u8],
    made: &mut Vec<(&'static str, Vec<u8>)>,
) -> Result<(), FileError> {
    made.push(("parts", bytes.to_vec()));
    let Some(path) = path else { return Ok(()) };
    let what = "an input, and would be overwritten";
    file.ok_or_else(|| FileError::Twice { path: path.to_owned(), what })?.write(bytes)
}

fn folder_of(file: Option<&Path>) -> Option<PathBuf> {
    file.and_then(Path::parent).map(Path::to_owned)
}

/// The words of `way`: `auto` is none.
const WAYS: [&str; 6] = ["auto", "as-drawn", "turned", "supports", "turned-supports", "cut"];

fn only(given: &Given<'_>) -> PyResult<Option<Way>> {
    Ok(WAYS[given.word("way", &WAYS)?].parse().ok())
}

/// Cuts that are made first.
fn cuts(given: &Given<'_>) -> PyResult<Vec<GivenCut>> {
    let parsed =
        |all: &Bound<'_, PyAny>| all.extract::<Vec<String>>().ok()?.iter().map(|text| GivenCut::parsed(text)).collect();
    let what = "a list of [PART:]X,Y,Z,OFFSET, each with an @X,Y,Z for each piece to take";
    Ok(given.of("cuts", what, parsed)?.unwrap_or_default())
}

pub(crate) fn supporting(given: &Given<'_>, words: [&str; 2]) -> PyResult<Supporting> {
    let word = words[given.word("supports", &words)?];
    Ok(if word == "never" { Supporting::Never } else { Supporting::Auto })
}

fn models<'a>(first: &'a ModelSource, how: &'a Arrangement) -> impl Iterator<Item = &'a ModelSource> {
    std::iter::once(first).chain(how.beside.iter().map(|(model, _)| model))
}

#[pyfunction]
pub(crate) fn plan(model: Named, profile: Named, told: Bound<'_, PyAny>, given: Bound<'_, PyDict>) -> PyResult<Made> {
    let call = Call::of(told, given)?;
    let given = &call.given;
    let [output, sheet] = [given.path("output")?, given.path("sheet")?];
    let parts_path = output.as_deref().map(parts_file);
    let request = PlanRequest {
        model: given.model(model)?,
        machine: machine(profile),
        arrangement: arrangement(given, parts_path.as_deref())?,
        options: PlanOptions { kept_in: folder_of(output.as_deref()), ..plan_options(given)? },
        supporting: supporting(given, ["never", "auto"])?,
    };
    call.run(move |world| {
        let mut outputs = read(models(&request.model, &request.arrangement), Some(&request.machine));
        let file = claim(output.as_deref(), &mut outputs)?;
        let parts = parts_path.as_deref().map(|path| outputs.claim_unless_taken(path)).transpose()?.flatten();
        let sheet = PictureFile::claim("sheet", sheet.as_deref(), &mut outputs)?;
        let done = job::plan(&request, world);
        before_writing(world);
        if let (Err(StrategyError::NoPlan(no)), Some(sheet)) = (&done, &sheet) {
            no.sheet().map(|drawing| sheet.write(&drawing)).transpose()?;
        }
        let done = done?;
        let (plan, mut made) = (done.plan.plan.to_text(), Vec::new());
        if let Some(arranged) = &done.arranged {
            keep_parts((parts_path.as_deref(), parts.as_ref()), &arranged.bytes, &mut made)?;
        }
        file.map(|file| file.write(plan.as_bytes())).transpose()?;
        sheet.map(|sheet| sheet.write(&done.sheet())).transpose()?;
        made.push(("plan", plan.into_bytes()));
        Ok((text(&document::planned(&done)), made))
    })
}

#[pyfunction]
pub(crate) fn split(model: Named, profile: Named, told: Bound<'_, PyAny>, given: Bound<'_, PyDict>) -> PyResult<Made> {
    let call = Call::of(told, given)?;
    let given = &call.given;
    let usual = SplitOptions::default();
    let no_cut: Vec<[[f64; 3]; 2]> =
        given.of("no_cut", "a list of boxes, each of two corners", |all| all.extract().ok())?.unwrap_or_default();
    let cuts = cuts(given)?;
    let options = SplitOptions {
        overhang_deg: given.number("overhang_deg")?,
        finish: [Finish::Practised, Finish::Fine][given.word("finish", &["practised", "fine"])?],
        bridge_mm: given.number("bridge_mm")?,
        tolerate_mm2: given.number("tolerate_mm2")?.unwrap_or(usual.tolerate_mm2),
        margin_mm: given.number("margin_mm")?.unwrap_or(usual.margin_mm),
        max_cuts: given.count("max_cuts")?.unwrap_or(usual.max_cuts),
        allow_mm2: given.number("allow_mm2")?.unwrap_or(usual.allow_mm2),
        strict: given.flag("strict")?,
        no_cut,
        cuts,
        pedestal_mm: given.number("pedestal_mm")?,
        budget: None,
        tries: given.count("budget")?.map_or(usual.tries, |tries| tries as u64),
    };
    let output = given.path("output")?;
    let request = SplitRequest {
        model: given.model(model)?,
        part: given.count("part")?,
        machine: machine(profile),
        standing: standing(given)?,
        options,
    };
    call.run(move |world| {
        let mut outputs = read([&request.model], Some(&request.machine));
        let file = claim(output.as_deref(), &mut outputs)?;
        let done = job::split(&request, world)?;
        before_writing(world);
        let document = document::split(&done);
        if let Some(why) = done.why_not() {
            return Err(Trouble::with(why.to_string(), 1, &document));
        }
        let parts = done.threemf();
        file.map(|file| file.write(&parts)).transpose()?;
        Ok((text(&document), vec![("parts", parts)]))
    })
}

/// The files of a prepared print.
struct Prepared {
    output: Option<PathBuf>,
    plan_out: Option<PathBuf>,
    sheet: Option<PathBuf>,
    parts: Option<PathBuf>,
    may_cut: bool,
}

#[pyfunction]
pub(crate) fn prepare(
    model: Named,
    profile: Named,
    told: Bound<'_, PyAny>,
    given: Bound<'_, PyDict>,
) -> PyResult<Made> {
    let call = Call::of(told, given)?;
    let given = &call.given;
    let output = given.path("output")?;
    let files = Prepared {
        parts: output.as_deref().map(parts_file),
        plan_out: given.path("plan_out")?,
        sheet: given.path("sheet")?,
        may_cut: given.word("split", &["auto", "never"])? == 0,
        output,
    };
    let arrangement = arrangement(given, files.parts.as_deref())?;
    let usual = PrepareRequest::new(given.model(model)?, machine(profile));
    let request = PrepareRequest {
        arrangement,
        plan: PlanOptions { kept_in: folder_of(files.plan_out.as_deref()), ..plan_options(given)? },
        slicing: slicing(given)?,
        ways: WaysOut {
            cuts: cuts(given)?,
            supporting: supporting(given, ["auto", "never"])?,
            only: only(given)?,
            ..usual.ways
        },
        ..usual
    };
    call.run(move |world| prepared(request, &files, world))
}

fn prepared(mut request: PrepareRequest, files: &Prepared, world: &World<'_>) -> Result<Made, Trouble> {
    let mut outputs = read(models(&request.model, &request.arrangement), Some(&request.machine));
    for config in &request.slicing.configs {
        outputs.reads(config)?;
    }
    let file = claim(files.output.as_deref(), &mut outputs)?;
    let plan_file = claim(files.plan_out.as_deref(), &mut outputs)?;
    let sheet = PictureFile::claim("sheet", files.sheet.as_deref(), &mut outputs)?;
    let parts = files.parts.as_deref().map(|path| outputs.claim_unless_taken(path)).transpose()?.flatten();
    match &files.parts {
        _ if !files.may_cut => request.ways.cutting = Cutting::Never,
        Some(_) if parts.is_none() => request.ways.cutting = Cutting::Never,
        Some(path) => request.ways.cutting = Cutting::Auto { file: path.display().to_string() },
        None => {}
    }
    let done = job::prepare(&request, world);
    before_writing(world);
    if done.is_err() {
        file.as_ref().map(OutputFile::set_aside).transpose()?;
    }
    let done = done?;
    let (plan, mut made) = (done.planned.plan.plan.to_text(), Vec::new());
    plan_file.map(|file| file.write(plan.as_bytes())).transpose()?;
    sheet.map(|sheet| sheet.write(&done.planned.sheet())).transpose()?;
    let bytes = done.cut.as_ref().map(|cut| &cut.bytes).or(done.planned.arranged.as_ref().map(|a| &a.bytes));
    if let Some(bytes) = bytes {
        keep_parts((files.parts.as_deref(), parts.as_ref()), bytes, &mut made)?;
    }
    file.map(|file| file.write(done.gcode.program())).transpose()?;
    let output = files.output.as_ref().map(|path| path.display().to_string());
    let Some(report) = done.gcode.report() else { return Err(Trouble::input("nothing was proved".to_owned())) };
    let mut document = document::prepared(output.as_deref().unwrap_or_default(), &done, report);
    document["output"] = json!(output);
    document["dry_run"] = Value::Null;
    made.push(("plan", plan.into_bytes()));
    made.push(("gcode", done.gcode.program().clone()));
    Ok((text(&document), made))
}

#[pyfunction]
pub(crate) fn verify(program: Named, plan: Named, told: Bound<'_, PyAny>, given: Bound<'_, PyDict>) -> PyResult<Made> {
    let call = Call::of(told, given)?;
    let from = PlanSource {
        plan: source(plan),
        model: call.given.named("model")?.map(source),
        machine: call.given.named("profile")?.map(machine),
    };
    let program = source(program);
    call.run(move |world| {
        let plan = job::load_plan(&from, world)?;
        let done = job::verify(&VerifyRequest { program: &program, plan: &plan }, world)?;
        Ok((text(&document::verified(&done.report, done.seconds)), Vec::new()))
    })
}
