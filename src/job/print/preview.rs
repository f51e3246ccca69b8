//! What a program, a plan or the lack of one looks like: the scene of a page, with what verification says of it.

use std::path::Path;

use super::error::PrintError;
use super::error::Rejected;
use crate::gcode::marks::made_by;
use crate::geom::{Machine as MachineFrame, Rigid, Table, Vec3};
use crate::input::{BadSetting, CheckedPlan, PlanSource, Source, load_plan, load_profile};
use crate::mesh::TriangleMesh;
use crate::motion::{Pose, TableKinematics};
use crate::planning::{Plan, Reason, Workpiece};
use crate::profile::Profile;
use crate::strategy::StrategyError;
use crate::strategy::holding::support_solids;
use crate::strategy::{NoPlan, PlaceRequest, PlanRequest, TriedWay, plan};
use crate::trace::{self, Trace};
use crate::verify::{HeadRoom, ReplayJob, Report, rooms, verify_trace};
use crate::view::{DrawnMachine, DrawnProgram, PackedScene, Scene, Shapes};
use crate::world::World;

/// What is to be looked at.
#[derive(Clone, Debug)]
pub enum PreviewRequest {
    /// A finished program, G-code for the machine, and the plan it was made by.
    Program(Source, PlanSource),
    /// A plan alone.
    Plan(PlanSource),
    /// A model, which is planned first: the plan, or why there is none.
    Model(Box<PlanRequest>),
}

/// One pose of a plan, or of what stands against one.
#[derive(Clone, Debug)]
pub struct PoseShown {
    /// The slot; `None` for a reason against a plan.
    pub slot: Option<usize>,
    /// The table's angles.
    pub pose: Pose,
    /// The same as words, degrees.
    pub words_deg: [f64; 2],
    /// From the table's frame to the machine's.
    pub motion: Rigid<Table, MachineFrame>,
    /// Parts that it is about.
    pub fresh: Vec<usize>,
    /// Parts that stand already.
    pub before: Vec<usize>,
    /// The part that is in the way.
    pub struck: Option<usize>,
    /// Where the tip stands, machine frame; `None` where nothing was looked at.
    pub tip: Option<Vec3>,
    /// In words.
    pub text: String,
}

/// What a page shows.
#[derive(Clone, Debug)]
pub struct PreviewResult {
    /// The program, the plan or the model, by its file's name.
    pub file: String,
    /// The machine, by its profile's name.
    pub machine: String,
    /// The filament's letter.
    pub extruder: char,
    /// The parts' names.
    pub parts: Vec<String>,
    /// Names of what is drawn behind the parts: supports of a plan, which a program has as lines.
    pub supports: Vec<String>,
    /// The plan, where there is one.
    pub plan: Option<Plan>,
    /// The poses in order; of the nearest misses where there is no plan.
    pub poses: Vec<PoseShown>,
    /// Why there is no plan.
    pub no_plan: Option<Box<NoPlan>>,
    /// The ways that were tried for the model, where it was planned on the way here.
    pub ways: Vec<TriedWay>,
    /// What verification says of the program.
    pub report: Option<Report>,
    /// What room the head has to what it does not print on, by runs of moves; empty without a program, and for one of very many moves.
    pub rooms: Vec<HeadRoom>,
    /// What is drawn.
    pub scene: Scene,
    /// The same, compressed.
    pub packed: PackedScene,
    /// What verification took.
    pub seconds_verify: f64,
    /// What the scene took.
    pub seconds: f64,
}

/// That `path` is named as a page.
///
/// # Errors
///
/// [`BadSetting::Ending`] for a name that does not end with `.html`.
pub fn is_page(name: &'static str, path: &Path) -> Result<(), BadSetting> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    let fits = ending == "html" || ending == "htm";
    if fits { Ok(()) } else { Err(BadSetting::Ending { name, path: path.to_owned(), allowed: ".html" }) }
}

/// Shows what is asked for; a program is verified, and shown with what was found.
///
/// # Errors
///
/// [`PrintError::NotOurs`], [`PrintError::MadeByAnother`], [`PrintError::NoMoves`], and what keeps files from being read. Neither findings nor the lack of a
/// plan is one.
pub fn preview(request: &PreviewRequest, world: &World<'_>) -> Result<PreviewResult, PrintError> {
    match request {
        PreviewRequest::Program(source, plan) => program(source, &load_plan(plan, world)?, world),
        PreviewRequest::Plan(plan) => Ok(of_plan(&plan.plan.name(), &load_plan(plan, world)?, None)),
        PreviewRequest::Model(request) => match plan(request, world) {
            Ok(made) => Ok(PreviewResult { ways: made.ways, ..of_plan(&made.plan.model.file, &made.plan, None) }),
            Err(StrategyError::NoPlan(no)) => of_no_plan(no, request, world),
            Err(error) => Err(error.into()),
        },
    }
}

fn program(source: &Source, plan: &CheckedPlan, world: &World<'_>) -> Result<PreviewResult, PrintError> {
    let bytes = source.program(world)?;
    let file = source.name().into_owned();
    match made_by(&bytes) {
        None => return Err(PrintError::NotOurs { file }),
        Some(made_by) if made_by != plan.sha256 => {
            return Err(PrintError::MadeByAnother { file, made_by, given: plan.sha256.clone() });
        }
        Some(_) => {}
    }
    let bar = world.progress.begin("verifying", 2);
    let start = world.clock.now();
    let workpiece = plan.workpiece();
    let job = ReplayJob { profile: &plan.machine.profile, plan: &plan.plan, workpiece: &workpiece };
    let trace = trace::read(&bytes, &plan.machine.profile.trace_setting());
    let report = verify_trace(&bytes, &trace, &job);
    let seconds_verify = (world.clock.now() - start).as_secs_f64();
    bar.at(1);
    drop(bar);
    Ok(PreviewResult { seconds_verify, ..show_trace(&file, &bytes, trace, plan, &report, world)? })
}

/// The room of each move is looked for in programs of so many moves: some seconds. Four million of hair-thin lines took three minutes.
pub const MOST_LOOKED_AT: usize = 500_000;

/// Shows a program that was verified already.
///
/// # Errors
///
/// [`PrintError::NoMoves`].
pub fn show(
    file: &str,
    program: &[u8],
    plan: &CheckedPlan,
    report: &Report,
    world: &World<'_>,
) -> Result<PreviewResult, PrintError> {
    let start = world.clock.now();
    let trace = trace::read(program, &plan.machine.profile.trace_setting());
    let shown = show_trace(file, program, trace, plan, report, world)?;
    Ok(PreviewResult { seconds: (world.clock.now() - start).as_secs_f64(), ..shown })
}

/// The same of a program that has been read: `trace` must be its own.
fn show_trace(
    file: &str,
    program: &[u8],
    trace: Trace,
    plan: &CheckedPlan,
    report: &Report,
    world: &World<'_>,
) -> Result<PreviewResult, PrintError> {
    let bar = world.progress.begin("drawing", 3);
    let start = world.clock.now();
    let profile = &plan.machine.profile;
    bar.at(1);
    if trace.is_empty() {
        return Err(PrintError::NoMoves { file: file.to_owned() });
    }
    let workpiece = plan.workpiece();
    let job = ReplayJob { profile, plan: &plan.plan, workpiece: &workpiece };
    let pack = || DrawnProgram::of(&trace, program, &profile.kinematics(), profile.dialect.extruder);
    let looked_at = trace.len() <= MOST_LOOKED_AT;
    let (packed, rooms) = rayon::join(pack, || if looked_at { rooms(&trace, &job) } else { Vec::new() });
    drop(trace);
    bar.at(2);
    let mut shown = of_plan(file, plan, Some(packed));
    (shown.report, shown.rooms) = (Some(report.clone()), rooms);
    shown.seconds = (world.clock.now() - start).as_secs_f64();
    Ok(shown)
}

/// Shows a program that was made and rejected, with what was found; `None` where its plan was not made on the way.
///
/// # Errors
///
/// [`PrintError::NoMoves`].
pub fn show_rejected(file: &str, rejected: &Rejected, world: &World<'_>) -> Result<Option<PreviewResult>, PrintError> {
    let shown = |plan| {
        let shown = show(file, &rejected.program, plan, &rejected.report, world)?;
        Ok(PreviewResult { ways: rejected.ways.clone(), ..shown })
    };
    rejected.plan.as_ref().map(shown).transpose()
}

/// A plan, pose by pose, with the program where there is one.
fn of_plan(file: &str, plan: &CheckedPlan, program: Option<DrawnProgram>) -> PreviewResult {
    let (workpiece, profile) = (plan.workpiece(), &plan.machine.profile);
    let kinematics = profile.kinematics();
    // They stand on the table as it is level.
    let back = kinematics.forward(Pose::LEVEL).inverse();
    let solids = if program.is_none() { support_solids(&plan.plan, &workpiece, profile) } else { Vec::new() };
    let supports: Vec<_> = solids.into_iter().map(|(part, solid)| (part, solid.moved(&back))).collect();
    let mut shown = scene(file, profile, &workpiece, &supports, program);
    shown.poses = poses(&plan.plan, &workpiece, &kinematics);
    for (nth, (part, _)) in supports.iter().enumerate() {
        let shape = shown.parts.len() + nth;
        for pose in &mut shown.poses {
            [&mut pose.fresh, &mut pose.before]
                .into_iter()
                .filter(|all| all.contains(part))
                .for_each(|all| all.push(shape));
        }
    }
    shown.plan = Some(plan.plan.clone());
    shown
}

/// For each part and each thing in its way the nearest miss, the head where it would strike.
fn of_no_plan(no: Box<NoPlan>, request: &PlanRequest, world: &World<'_>) -> Result<PreviewResult, PrintError> {
    let loaded = load_profile(&request.machine, world)?;
    let given = |place: &PlaceRequest| place.placement(&no.model.model);
    let placement = request.options.place.as_ref().map_or_else(|| Workpiece::centred(&no.model.model), given);
    let workpiece = Workpiece::place(&no.model.model, &placement);
    let mut shown = scene(&no.model.file, &loaded.profile, &workpiece, &[], None);
    let kinematics = loaded.profile.kinematics();
    let reasons = no.hindrances().into_iter().map(|h| reason(h.nearest, &workpiece, &kinematics));
    shown.poses = reasons.collect();
    shown.ways.clone_from(&no.ways);
    shown.no_plan = Some(no);
    Ok(shown)
}

/// The parts on their table, with supports of some of them.
fn scene(
    file: &str,
    profile: &Profile,
    workpiece: &Workpiece<'_>,
    supports: &[(usize, TriangleMesh<Table>)],
    program: Option<DrawnProgram>,
) -> PreviewResult {
    let (head, frame) = (profile.head_bodies(), profile.fixed_bodies());
    let machine = DrawnMachine::of(profile.kinematics(), profile.linear_limits(), &profile.table_slab(), &head, &frame);
    let name = |part: usize| workpiece.model.parts[part].name.clone();
    let solids = workpiece.parts.iter().cloned().chain(supports.iter().map(|(_, solid)| solid.clone()));
    let scene = Scene { machine, shapes: Shapes::of(&solids.collect::<Vec<_>>()), program };
    PreviewResult {
        file: Path::new(file).file_name().map_or_else(|| file.into(), |name| name.to_string_lossy().into_owned()),
        machine: profile.machine.name.clone(),
        extruder: profile.dialect.extruder,
        parts: (0..workpiece.parts.len()).map(name).collect(),
        supports: supports.iter().map(|(part, _)| format!("supports of {}", name(*part))).collect(),
        plan: None,
        poses: Vec::new(),
        no_plan: None,
        ways: Vec::new(),
        report: None,
        rooms: Vec::new(),
        packed: scene.packed(),
        scene,
        seconds_verify: 0.0,
        seconds: 0.0,
    }
}

fn words(pose: Pose, kinematics: &TableKinematics) -> [f64; 2] {
    [kinematics.tilt.word_of(pose.tilt).deg(), kinematics.rotation.word_of(pose.rotation).deg()]
}

/// The poses of a plan, the tip above the highest place of what is new.
fn poses(plan: &Plan, workpiece: &Workpiece<'_>, kinematics: &TableKinematics) -> Vec<PoseShown> {
    let mut before: Vec<usize> = Vec::new();
    let mut all = Vec::new();
    for slot in &plan.slots {
        for setup in slot.setups() {
            let pose = setup[0].pose(kinematics);
            let motion = kinematics.forward(pose);
            let fresh: Vec<usize> = setup.iter().map(|print| print.part).collect();
            let corners = fresh.iter().flat_map(|&part| workpiece.parts[part].vertices());
            let highest = corners.map(|v| motion.rotation * v + motion.translation).max_by(|a, b| a.z.total_cmp(&b.z));
            let names: Vec<&str> = fresh.iter().map(|&part| workpiece.model.parts[part].name.as_str()).collect();
            all.push(PoseShown {
                slot: Some(slot.id),
                pose,
                words_deg: [setup[0].tilt_deg, setup[0].rotation_deg],
                motion,
                before: before.clone(),
                struck: None,
                tip: highest,
                text: names.join(", "),
                fresh: fresh.clone(),
            });
            before.extend(fresh);
        }
    }
    all
}

fn reason(reason: &Reason, workpiece: &Workpiece<'_>, kinematics: &TableKinematics) -> PoseShown {
    let motion = kinematics.forward(reason.pose);
    let others = (0..workpiece.parts.len()).filter(|part| *part != reason.part).collect();
    PoseShown {
        slot: None,
        pose: reason.pose,
        words_deg: words(reason.pose, kinematics),
        tip: reason.tip.map(|tip| motion.rotation * Vec3::from(tip) + motion.translation),
        motion,
        fresh: vec![reason.part],
        before: others,
        struck: reason.blocked_by.parse().ok(),
        text: reason.text.clone(),
    }
}
