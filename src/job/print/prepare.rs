//! The main job: from a model to a verified program, in memory.

use super::error::PrintError;
use super::error::Rejected;
use super::rewrite::RewriteResult;
use super::rewrite::{Written, read_prints};
use super::slice::slice_by;
use super::slice::{Prints, SlicerName, SlicingOptions};
use super::verify::Verified;
use crate::input::{MachineSource, ModelSource, load_profile};
use crate::slicing::{BuiltIn, Flaw, SliceError, Slicer, SlicerChoice};
use crate::strategy::{
    Arrangement, CutModel, Cutting, HeldModel, PlanOptions, PlanResult, Refused, Supporting, TriedWay, WaysOut,
};
use crate::strategy::{Models, PlannedSomehow, ReadModels, SetUp, Way, arranged, arranged_aloud, planned_somehow};
use crate::toolpath::{Input, LabelledPrint, SlicedError};
use crate::world::World;

/// A model and a machine, and how to bring them together.
#[derive(Clone, Debug)]
pub struct PrepareRequest {
    /// The model.
    pub model: ModelSource,
    /// The machine.
    pub machine: MachineSource,
    /// How the model is set up before.
    pub arrangement: Arrangement,
    /// How to plan.
    pub plan: PlanOptions,
    /// How to slice.
    pub slicing: SlicingOptions,
    /// What may be done with the model beside printing it as it was drawn.
    pub ways: WaysOut,
}

impl PrepareRequest {
    /// As the command does it without flags; a model that must be cut is called by its own name with `.parts.3mf` behind it.
    pub fn new(model: impl Into<ModelSource>, machine: impl Into<MachineSource>) -> Self {
        let (plan, slicing) = (PlanOptions::default(), SlicingOptions::default());
        let model = model.into();
        let cutting = Cutting::Auto { file: format!("{}.parts.3mf", model.source.name()) };
        let ways = WaysOut { cutting, supporting: Supporting::Auto, turning: true, ..WaysOut::NONE };
        let arrangement = Arrangement::default();
        Self { model, machine: machine.into(), arrangement, plan, slicing, ways }
    }
}

/// The program, and how it came about.
#[derive(Clone, Debug)]
pub struct PrepareResult {
    /// The program for the machine, proved.
    pub gcode: Verified<Vec<u8>>,
    /// The plan, with its model and machine.
    pub planned: PlanResult,
    /// What became of a model whose solids were cut.
    pub cut: Option<CutModel>,
    /// What became of one that is printed on supports.
    pub held: Option<HeldModel>,
    /// Who sliced.
    pub slicer: SlicerName,
    /// What of the prints, by name, is not in what was sliced.
    pub flaws: Vec<(String, Flaw)>,
    /// What should be known, that too; told already.
    pub warnings: Vec<String>,
    /// What each step took.
    pub seconds: Seconds,
}

/// What each step took, seconds; together, where it was done more than once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seconds {
    /// Reading model and profile.
    pub read: f64,
    /// The search for orientations.
    pub orient: f64,
    /// The search for a sequence, with finding the slicer.
    pub plan: f64,
    /// The slicer.
    pub slice: f64,
    /// Rewriting.
    pub rewrite: f64,
    /// The replay.
    pub verify: f64,
}

/// Does everything: reads, plans by the cheapest way, has sliced, rewrites and verifies. Where what was sliced is refused, the next way is tried.
///
/// # Errors
///
/// What any of the steps may say; the first that cannot be done ends the job. Where several ways came to nothing, what was said of the first.
pub fn prepare(request: &PrepareRequest, world: &World<'_>) -> Result<PrepareResult, PrintError> {
    let mut seconds = Seconds::default();
    let machine = load_profile(&request.machine, world)?;
    let how = &request.arrangement;
    let read = &timed(&mut seconds.read, world, || ReadModels::read(&request.model, how, world))?;
    let models = Models { read, how, machine: &machine };
    let set = timed(&mut seconds.read, world, || arranged_aloud(&models, world))?;
    // A slicer that is not there is found out before the long search.
    let slicer = request.slicing.slicer(world)?;
    let job = Proving { slicer: slicer.as_ref(), request, world };
    let (PlannedSomehow { plan, cut, held, .. }, proved) = job.by_any_way(&models, set, &mut seconds)?;
    let Proved { rewritten, slicer, flaws } = proved;
    let RewriteResult { gcode, warnings, .. } = rewritten;
    let of_slicer = flaws.iter().map(|(name, flaw)| format!("{name}: {flaw}"));
    let warnings = plan.plan.model.model.warnings.iter().cloned().chain(of_slicer).chain(warnings).collect();
    Ok(PrepareResult { gcode, planned: plan, cut, held, slicer, flaws, warnings, seconds })
}

/// What a slicer did that another may do better; `None` for what is not the slicer's.
fn unfit(error: &PrintError) -> Option<Refused> {
    match error {
        PrintError::Rejected(no) => Some(Refused::Laid(no.to_string())),
        PrintError::Sliced(_) | PrintError::Rewrite(_) => Some(Refused::Wrote(error.to_string())),
        PrintError::Slice(SliceError::Interrupted) => None,
        PrintError::Slice(_) => Some(Refused::Slicer(error.to_string())),
        _ => None,
    }
}

/// Prints that were sliced, rewritten and proved.
struct Proved {
    rewritten: RewriteResult,
    slicer: SlicerName,
    flaws: Vec<(String, Flaw)>,
}

/// Prints that were not, and whose slices those were.
struct Failed {
    slicer: String,
    error: Box<PrintError>,
}

/// How plans are sliced and proved.
#[derive(Clone, Copy)]
struct Proving<'a> {
    slicer: &'a dyn Slicer,
    request: &'a PrepareRequest,
    world: &'a World<'a>,
}

impl Proving<'_> {
    /// By the slicer, or, where nobody named it and what it lays is of no use, by our own.
    fn proved(&self, plan: &PlanResult, seconds: &mut Seconds) -> Result<Proved, Failed> {
        let prints = Prints::of(&plan.plan, self.request.slicing.bed);
        let named = self.request.slicing.slicer != SlicerChoice::Auto || !self.request.slicing.configs.is_empty();
        let mut by = |slicer: &dyn Slicer| {
            self.proved_by(slicer, &prints, plan, seconds)
                .map_err(|error| Failed { slicer: slicer.name().to_owned(), error: Box::new(error) })
        };
        let first = by(self.slicer);
        match first.as_ref().err().and_then(|failed| unfit(&failed.error)) {
            Some(why) if !named && self.slicer.name() != BuiltIn.name() => {
                let name = self.slicer.name();
                self.world.progress.warning(&format!("{name} {why}; using the built-in slicer instead"));
                by(&BuiltIn)
            }
            _ => first,
        }
    }

    fn proved_by(
        &self,
        slicer: &dyn Slicer,
        prints: &Prints,
        plan: &PlanResult,
        seconds: &mut Seconds,
    ) -> Result<Proved, PrintError> {
        let world = self.world;
        let done = timed(&mut seconds.slice, world, || slice_by(slicer, prints, &plan.plan, world))?;
        world.progress.reached(&done);
        let written = timed(&mut seconds.rewrite, world, || rewrite_all(&done.sliced, prints, plan, world))?;
        let (slicer, flaws) = (done.slicer, done.flaws);
        // Given back before the replay, which needs room of its own.
        drop(done.sliced);
        let rewritten = timed(&mut seconds.verify, world, || written.verified(&plan.plan, world))?;
        Ok(Proved { rewritten, slicer, flaws })
    }

    /// The model planned by the cheapest way whose slices hold.
    fn by_any_way(
        &self,
        models: &Models<'_>,
        set: SetUp,
        seconds: &mut Seconds,
    ) -> Result<(PlannedSomehow, Proved), PrintError> {
        let mut ways = self.request.ways.clone();
        let mut somehow = self.planned(models, set, &ways, seconds)?;
        let mut first: Option<PrintError> = None;
        loop {
            self.world.progress.reached(&somehow.plan);
            let failed = match self.proved(&somehow.plan, seconds) {
                Ok(proved) => return Ok((somehow, proved)),
                Err(failed) => failed,
            };
            let lost = somehow.taken().filter(|way| may_be_otherwise(way.way, &failed.error)).cloned();
            let why = unfit(&failed.error);
            let error = match *failed.error {
                PrintError::Rejected(no) => {
                    PrintError::Rejected(Box::new(Rejected { plan: Some(somehow.plan.plan.clone()), ..*no }))
                }
                error => error,
            };
            let loose = loose_parts(&error, somehow.held.as_ref());
            let error = first.unwrap_or(error);
            let (Some(lost), Some(why)) = (lost, why) else { return Err(of_tried(error, ways.lost)) };
            let this = lost.way.word();
            let lost = TriedWay { chosen: false, why_not: Some(why.clone()), ..lost };
            // What is laid badly on supports may be laid well on more of them.
            let anew = |ways: &WaysOut, seconds: &mut Seconds| {
                let set = arranged(models).ok()?;
                self.planned(models, set, ways, seconds).ok()
            };
            let mut next = None;
            while next.is_none() && ways.holdings.firmer(&loose) {
                // The same plan once more would be refused once more.
                next = anew(&ways, seconds).filter(|next| next.plan.plan.sha256 != somehow.plan.plan.sha256);
            }
            let firmer = next.is_some();
            let next = next.or_else(|| {
                ways.lost.push(lost.clone());
                somehow.otherwise(lost).or_else(|| anew(&ways, seconds))
            });
            let Some(next) = next else {
                return Err(of_tried(error, ways.lost));
            };
            let that = next.taken().map_or("", |way| way.way.word());
            let that = if firmer && that == this { "more supports" } else { that };
            self.world.progress.warning(&format!("{this}: {} {why}; {that} instead", failed.slicer));
            (somehow, first) = (next, Some(error));
        }
    }

    fn planned(
        &self,
        models: &Models<'_>,
        set: SetUp,
        ways: &WaysOut,
        seconds: &mut Seconds,
    ) -> Result<PlannedSomehow, PrintError> {
        let mut planning = 0.0;
        let options = &self.request.plan;
        let planned = timed(&mut planning, self.world, || planned_somehow(models, set, options, ways, self.world));
        let orient = planned.as_ref().map_or(0.0, |somehow| somehow.plan.orient_seconds);
        seconds.orient += orient;
        seconds.plan += (planning - orient).max(0.0);
        Ok(planned?)
    }
}

/// Of the parts on supports those that a rejected program has findings of; all of them where it names none.
fn loose_parts(error: &PrintError, held: Option<&HeldModel>) -> Vec<usize> {
    let PrintError::Rejected(no) = error else { return Vec::new() };
    let all: Vec<usize> = held.iter().flat_map(|held| &held.parts).map(|held| held.part).collect();
    let named = |part: &usize| no.report.findings.iter().any(|finding| finding.part == Some(*part));
    let loose: Vec<usize> = all.iter().copied().filter(named).collect();
    if loose.is_empty() { all } else { loose }
}

/// A program that was rejected, with the ways that were tried.
fn of_tried(error: PrintError, tried: Vec<TriedWay>) -> PrintError {
    match error {
        PrintError::Rejected(no) => PrintError::Rejected(Box::new(Rejected { ways: tried, ..*no })),
        error => error,
    }
}

/// Whether another way may help where a slicer failed with this one: at the model as it was drawn only what was laid counts.
fn may_be_otherwise(way: Way, error: &PrintError) -> bool {
    matches!(error, PrintError::Rejected(_)) || way != Way::AsDrawn
}

/// Adds what `act` takes to `seconds`.
fn timed<T>(seconds: &mut f64, world: &World<'_>, act: impl FnOnce() -> T) -> T {
    let start = world.clock.now();
    let done = act();
    *seconds += (world.clock.now() - start).as_secs_f64();
    done
}

/// One print a file.
fn rewrite_all(
    sliced: &[Vec<u8>],
    prints: &Prints,
    plan: &PlanResult,
    world: &World<'_>,
) -> Result<Written, PrintError> {
    let mut segments: Vec<LabelledPrint<'_>> = Vec::new();
    for (bytes, name) in sliced.iter().zip(&prints.names) {
        let found = read_prints(bytes, name, &plan.plan.machine.profile)?;
        segments.push(found.into_iter().next().ok_or_else(|| SlicedError::NoExtrusion { file: name.clone() })?);
    }
    let centre_mm = prints.sliced_centre();
    let inputs: Vec<Input<'_>> = segments
        .iter()
        .enumerate()
        .map(|(print, segment)| Input { print, centre_mm, file: &prints.names[print], sliced: &segment.sliced })
        .collect();
    Written::of(&inputs, sliced.iter().map(Vec::len).sum(), &plan.plan, world)
}
