//! Sliced files to one verified program.

use std::path::Path;

use super::error::PrintError;
use super::slice::Prints;
use super::verify::Verified;
use super::verify::replayed_as;
use crate::gcode::marks::finished_by;
use crate::input::{CheckedPlan, Source};
use crate::pictures::thumbnails;
use crate::profile::Profile;
use crate::strategy::holding::{CENTRE_MM, LayError, all_supports};
use crate::toolpath::{
    Bed, BoxMismatch, Input, InputWords, LabelledPrint, Moved, ProjectSpot, RewriteError, RewriteJob, SlicedPrint,
    check_box, find_moved, read_sliced, rewrite as rewritten, slot_mesh,
};
use crate::trace::{Trace, TraceReader};
use crate::world::World;

/// Sliced files and the plan they were sliced for.
#[derive(Clone, Debug)]
pub struct RewriteRequest<'a> {
    /// The plan.
    pub plan: &'a CheckedPlan,
    /// Each is one print (by its object label, by its name `print-NN..`, or by `print`), or several one by one.
    pub sliced: Vec<Source>,
    /// Which print of the plan an unlabelled file is.
    pub print: Option<usize>,
    /// The slicer's bed, on whose middle each print stands, or all of them as in the project; what stands elsewhere is found.
    pub bed: Bed,
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
/// [`PrintError::Sliced`] and [`PrintError::Rewrite`] for files that are not understood or do not fit the plan,
/// [`PrintError::WhichPrint`], and [`PrintError::Rejected`] where the result has findings.
pub fn rewrite(request: &RewriteRequest<'_>, world: &World<'_>) -> Result<RewriteResult, PrintError> {
    // What was read is given back before the replay, which needs room of its own.
    let written = write(request, world)?;
    written.verified(request.plan, world)
}

fn write(request: &RewriteRequest<'_>, world: &World<'_>) -> Result<Written, PrintError> {
    let plan = request.plan;
    let mut sources = Vec::new();
    for source in &request.sliced {
        sources.push((source.name(), source.program(world)?));
    }
    let mut segments = Vec::new();
    for (file, bytes) in &sources {
        segments.push(read_prints(bytes, file, &plan.machine.profile)?);
    }
    let assigned = assign(request, &segments)?;
    let mut placed = Vec::new();
    let prints = Prints::of(plan, request.bed);
    let spots = prints.spots().ok();
    for one in &assigned {
        placed.push(one.placed(request, &prints, spots.as_deref(), &sources[one.source].0)?);
    }
    tell_moved(&assigned, &placed, world);
    let inputs: Vec<Input<'_>> = assigned
        .iter()
        .zip(&placed)
        .map(|(p, placed)| Input {
            print: p.print,
            centre_mm: placed.centre(),
            file: &sources[p.source].0,
            sliced: placed.sliced(&p.segment.sliced),
        })
        .collect();
    Written::of(&inputs, sources.iter().map(|(_, bytes)| bytes.len()).sum(), plan, world)
}

/// Whether a file is the finished program of `plan`: rewriting that once more is done already.
///
/// # Errors
///
/// [`PrintError::OtherPlan`] for a program that another plan was finished by, and what keeps a file from being read.
pub fn is_finished(file: &Source, plan: &CheckedPlan, world: &World<'_>) -> Result<bool, PrintError> {
    match finished_by(&file.bytes(world)?) {
        Some(by) if by == plan.sha256 => Ok(true),
        Some(_) => Err(PrintError::OtherPlan { file: file.name().into_owned() }),
        None => Ok(false),
    }
}

/// The prints of a sliced file.
pub(super) fn read_prints<'a>(
    bytes: &'a [u8],
    file: &'a str,
    profile: &'a Profile,
) -> Result<Vec<LabelledPrint<'a>>, PrintError> {
    let words = InputWords { firmware: profile.firmware(), allow: &profile.dialect.allow, supports: false };
    Ok(read_sliced(bytes, file, words)?)
}

/// A program of which nothing is proved yet.
pub(super) struct Written {
    gcode: Vec<u8>,
    /// What these bytes do.
    trace: Trace,
    warnings: Vec<String>,
}

impl Written {
    /// The program of all prints of the plan; `expected` is about how many bytes it will have.
    pub(super) fn of(
        inputs: &[Input<'_>],
        expected: usize,
        plan: &CheckedPlan,
        world: &World<'_>,
    ) -> Result<Self, PrintError> {
        let supports = all_supports(plan, inputs).map_err(|error| match error {
            LayError::Setting(error) => PrintError::from(error),
            LayError::Sliced(error) => error.into(),
        })?;
        let words = InputWords { supports: true, ..InputWords::default() };
        let mut read: Vec<(usize, SlicedPrint<'_>)> = Vec::new();
        for (number, bytes) in &supports {
            read.extend(read_sliced(bytes, "supports", words)?.into_iter().map(|segment| (*number, segment.sliced)));
        }
        let held =
            inputs.iter().map(|i| Input { print: i.print, centre_mm: i.centre_mm, file: i.file, sliced: i.sliced });
        let own =
            read.iter().map(|(print, sliced)| Input { print: *print, centre_mm: CENTRE_MM, file: "supports", sliced });
        let inputs: Vec<Input<'_>> = held.chain(own).collect();
        let workpiece = plan.workpiece();
        let (profile, plan_sha256) = (&plan.machine.profile, &plan.sha256);
        let pictures = if profile.dialect.thumbnails { thumbnails(&workpiece) } else { String::new() };
        let job = RewriteJob { plan: &plan.plan, plan_sha256, profile, workpiece: &workpiece, head: &pictures };
        // An eighth more than was read: a buffer that grows by copies would need room for two of itself.
        let mut gcode = Vec::with_capacity(expected + expected / 8);
        let made = rewritten(&inputs, &job, &mut gcode)?;
        made.warnings.iter().for_each(|w| world.progress.warning(w));
        // Before the replay, which is then of these bytes too; and what was read for them is read once.
        if gcode.last().is_some_and(|last| *last != b'\n') {
            gcode.push(b'\n');
        }
        let mut reader = TraceReader::new(&profile.trace_setting(), gcode.len());
        reader.take(&gcode);
        let all = gcode.len();
        gcode.extend_from_slice(reader.totals().to_string().as_bytes());
        reader.take(&gcode[all..]);
        Ok(Self { gcode, trace: reader.finish(), warnings: made.warnings })
    }

    /// The program, replayed.
    pub(super) fn verified(self, plan: &CheckedPlan, world: &World<'_>) -> Result<RewriteResult, PrintError> {
        let replay = replayed_as(self.gcode, &self.trace, plan, world);
        let verify_seconds = replay.seconds;
        Ok(RewriteResult { gcode: replay.verified()?, warnings: self.warnings, verify_seconds })
    }
}

/// A print found in a file.
struct Assigned<'a> {
    print: usize,
    source: usize,
    segment: &'a LabelledPrint<'a>,
    /// Whether it comes from a project with all prints side by side.
    in_project: bool,
}

/// Where a print stands on the slicer's bed.
enum Placed<'a> {
    /// Where it was put.
    AsPut([f64; 2]),
    /// Where somebody, or the slicer, has put it.
    Moved(Box<Moved<'a>>),
}

impl<'a> Placed<'a> {
    fn centre(&self) -> [f64; 2] {
        match self {
            Self::AsPut(centre) => *centre,
            Self::Moved(moved) => moved.centre_mm,
        }
    }

    fn sliced<'b>(&'b self, as_read: &'b SlicedPrint<'a>) -> &'b SlicedPrint<'a> {
        match self {
            Self::AsPut(_) => as_read,
            Self::Moved(moved) => &moved.sliced,
        }
    }
}

impl<'a> Assigned<'a> {
    /// Where it stands: where `prints` or, in a project, their spots have it, or else where its lines say.
    fn placed(
        &self,
        request: &RewriteRequest<'_>,
        prints: &Prints,
        spots: Option<&[ProjectSpot]>,
        file: &str,
    ) -> Result<Placed<'a>, PrintError> {
        let (plan, bed) = (request.plan, &request.bed);
        let (profile, sliced) = (&plan.machine.profile, &self.segment.sliced);
        let Some((_, print)) = plan.prints().nth(self.print) else { return Ok(Placed::AsPut(bed.middle_mm())) };
        let (table, workpiece) = (profile.kinematics(), plan.workpiece());
        let mesh = |centre| slot_mesh(&workpiece, &table, print, centre);
        let spot = spots.map(|spots| spots[self.print].centre_mm);
        let mut expected: Vec<[f64; 2]> = [bed.middle_mm(), prints.sliced_centre()].into_iter().chain(spot).collect();
        if self.in_project {
            expected.rotate_right(1);
        }
        if let Some(centre) = expected.iter().find(|centre| check_box(&mesh(**centre), sliced, profile).is_ok()) {
            return Ok(Placed::AsPut(*centre));
        }
        let wrong = |source| {
            let (file, print, part) = (file.to_owned(), self.print, print.part);
            PrintError::from(RewriteError::Box { file, print, part, source })
        };
        match find_moved(&mesh([0.0; 2]), sliced, profile)? {
            Ok(moved) => {
                check_box(&mesh(moved.centre_mm), &moved.sliced, profile).map_err(wrong)?;
                Ok(Placed::Moved(Box::new(moved)))
            }
            // It is nowhere: the rewriter says what is wrong with it where it should be.
            Err(BoxMismatch::NotFound) => Ok(Placed::AsPut(expected[0])),
            Err(source) => Err(wrong(source)),
        }
    }
}

/// Says which prints stand elsewhere than they were put.
fn tell_moved(assigned: &[Assigned<'_>], placed: &[Placed<'_>], world: &World<'_>) {
    let one = |(assigned, placed): (&Assigned<'_>, &Placed<'_>)| {
        let Placed::Moved(moved) = placed else { return None };
        // No minus before what is printed as nothing.
        let [x, y] = moved.at_mm.map(|v| if v.abs() < 0.005 { 0.0 } else { v });
        let turn = moved.turn.to_degrees();
        let turned = if turn.abs() < 0.005 { String::new() } else { format!(" turned by {turn:.2} deg") };
        Some(format!("print {} at X {x:.2} Y {y:.2}{turned}", assigned.print))
    };
    let all: Vec<String> = assigned.iter().zip(placed).filter_map(one).collect();
    if !all.is_empty() {
        world.progress.warning(&format!("moved in the slicer, and printed where they are now: {}", all.join(", ")));
    }
}

fn assign<'a>(
    request: &RewriteRequest<'_>,
    all: &'a [Vec<LabelledPrint<'a>>],
) -> Result<Vec<Assigned<'a>>, PrintError> {
    let only = request.plan.prints().count() == 1;
    let mut found = Vec::new();
    for (source, segments) in all.iter().enumerate() {
        let in_project = segments.len() > 1;
        let file = request.sliced[source].name();
        for segment in segments {
            let print = request.print.or(segment.print).or_else(|| print_of_file(&file)).or(only.then_some(0));
            let print = print.ok_or_else(|| PrintError::WhichPrint { file: file.clone().into_owned() })?;
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
