//! Sliced files to one verified program.

use std::path::Path;

use super::verify::replayed;
use super::{CheckedPlan, Error, Source, Verified, World};
use crate::gcode::marks::finished_by;
use crate::profile::Profile;
use crate::toolpath::{Input, InputWords, Job, Segment, project_layout, read_sliced, rewrite as rewritten, slot_mesh};

/// Sliced files and the plan they were sliced for.
#[derive(Clone, Debug)]
pub struct RewriteRequest<'a> {
    /// The plan.
    pub plan: &'a CheckedPlan,
    /// Each is one print (by its object label, by its name `print-NN..`, or by `print`), or several one by one.
    pub sliced: Vec<Source>,
    /// Which print of the plan an unlabelled file is.
    pub print: Option<usize>,
    /// Size of the slicer's bed, on whose centre each print stands.
    pub bed_mm: [f64; 2],
}

/// The program for the machine.
#[derive(Clone, Debug)]
pub struct RewriteResult {
    /// The program, proved.
    pub gcode: Verified<Vec<u8>>,
    /// What should be known; told already.
    pub warnings: Vec<String>,
    /// What the replay took.
    pub verify_seconds: f64,
}

/// Rewrites sliced files for the machine, and verifies the result.
///
/// # Errors
///
/// [`Error::Sliced`] and [`Error::Rewrite`] for files that are not understood or do not fit the plan,
/// [`Error::WhichPrint`], and [`Error::Rejected`] where the result has findings.
pub fn rewrite(request: &RewriteRequest<'_>, world: &World<'_>) -> Result<RewriteResult, Error> {
    // What was read is given back before the replay, which needs room of its own.
    let written = write(request, world)?;
    written.verified(request.plan, world)
}

fn write(request: &RewriteRequest<'_>, world: &World<'_>) -> Result<Written, Error> {
    let plan = request.plan;
    let mut sources = Vec::new();
    for source in &request.sliced {
        sources.push((source.name(), source.bytes(world)?));
    }
    let mut segments = Vec::new();
    for (file, bytes) in &sources {
        segments.push(read_prints(bytes, file, &plan.machine.profile)?);
    }
    let assigned = assign(request, &segments)?;
    let inputs: Vec<Input<'_>> = assigned
        .iter()
        .map(|p| Input {
            print: p.print,
            centre_mm: p.centre(plan, request.bed_mm),
            file: &sources[p.source].0,
            sliced: &p.segment.sliced,
        })
        .collect();
    Written::of(&inputs, sources.iter().map(|(_, bytes)| bytes.len()).sum(), plan, world)
}

/// Whether a file is the finished program of `plan`: rewriting that once more is done already.
///
/// # Errors
///
/// [`Error::OtherPlan`] for a program that another plan was finished by, and what keeps a file from being read.
pub fn is_finished(file: &Source, plan: &CheckedPlan, world: &World<'_>) -> Result<bool, Error> {
    match finished_by(&file.bytes(world)?) {
        Some(by) if by == plan.sha256 => Ok(true),
        Some(_) => Err(Error::OtherPlan { file: file.name().into_owned() }),
        None => Ok(false),
    }
}

/// The prints of a sliced file.
pub(super) fn read_prints<'a>(bytes: &'a [u8], file: &'a str, profile: &'a Profile) -> Result<Vec<Segment<'a>>, Error> {
    let words = InputWords { firmware: profile.firmware(), allow: &profile.dialect.allow };
    Ok(read_sliced(bytes, file, words)?)
}

/// A program of which nothing is proved yet.
pub(super) struct Written {
    gcode: Vec<u8>,
    warnings: Vec<String>,
}

impl Written {
    /// The program of all prints of the plan; `expected` is about how many bytes it will have.
    pub(super) fn of(
        inputs: &[Input<'_>],
        expected: usize,
        plan: &CheckedPlan,
        world: &World<'_>,
    ) -> Result<Self, Error> {
        let workpiece = plan.workpiece();
        let (profile, plan_sha256) = (&plan.machine.profile, &plan.sha256);
        let job = Job { plan: &plan.plan, plan_sha256, profile, workpiece: &workpiece };
        // An eighth more than was read: a buffer that grows by copies would need room for two of itself.
        let mut gcode = Vec::with_capacity(expected + expected / 8);
        let made = rewritten(inputs, &job, &mut gcode)?;
        made.warnings.iter().for_each(|w| world.progress.warning(w));
        Ok(Self { gcode, warnings: made.warnings })
    }

    /// The program, replayed.
    pub(super) fn verified(self, plan: &CheckedPlan, world: &World<'_>) -> Result<RewriteResult, Error> {
        let replay = replayed(self.gcode, plan, world);
        let verify_seconds = replay.seconds;
        Ok(RewriteResult { gcode: replay.verified()?, warnings: self.warnings, verify_seconds })
    }
}

/// A print found in a file.
struct Assigned<'a> {
    print: usize,
    source: usize,
    segment: &'a Segment<'a>,
    /// Whether it comes from a project with all prints side by side.
    in_project: bool,
}

impl Assigned<'_> {
    fn centre(&self, plan: &CheckedPlan, bed: [f64; 2]) -> [f64; 2] {
        let middle = [bed[0] / 2.0, bed[1] / 2.0];
        if !self.in_project {
            return middle;
        }
        let (table, workpiece) = (plan.machine.profile.kinematics(), plan.workpiece());
        let sizes: Vec<_> =
            plan.prints().map(|(_, p)| slot_mesh(&workpiece, &table, p, middle).mesh.bounds().size()).collect();
        project_layout(&sizes).0.get(self.print).copied().unwrap_or(middle)
    }
}

fn assign<'a>(request: &RewriteRequest<'_>, all: &'a [Vec<Segment<'a>>]) -> Result<Vec<Assigned<'a>>, Error> {
    let only = request.plan.prints().count() == 1;
    let mut found = Vec::new();
    for (source, segments) in all.iter().enumerate() {
        let in_project = segments.len() > 1;
        let file = request.sliced[source].name();
        for segment in segments {
            let print = request.print.or(segment.print).or_else(|| print_of_file(&file)).or(only.then_some(0));
            let print = print.ok_or_else(|| Error::WhichPrint { file: file.clone().into_owned() })?;
            found.push(Assigned { print, source, segment, in_project });
        }
    }
    Ok(found)
}

/// The number in a name like `print-03-arm.gcode`.
fn print_of_file(file: &str) -> Option<usize> {
    let name = Path::new(file).file_name()?.to_str()?;
    let digits: String = name.strip_prefix("print-")?.chars().take_while(char::is_ascii_digit).collect();
    digits.parse().ok()
}
