//! `trunnion slice`

use std::path::PathBuf;

use super::args::Slice as Verb;
use super::requests::outputs;
use super::{Console, Failure};
use crate::document;
use crate::job::{self, CheckedPlan, FileError, OutputFile, Prints, ProjectSpot, SliceRequest};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let world = console.world();
    let plan = job::load_plan(&args.plan_ref.source(&args.plan), &world)?;
    let options = args.slicing.options(&args.bed)?;
    let prints = Prints::of(&plan, options.bed);
    let spots = prints.spots()?;
    let script = script(args)?;
    let projects = prints.projects(&plan, &spots, &script);
    let places = Places::claim(args, &plan, &prints.names, &spots, projects.len())?;
    let mut written: Vec<String> = Vec::new();
    let mut put = |output: &OutputFile, bytes: &[u8]| {
        written.push(output.path().display().to_string());
        output.write(bytes)
    };
    for (mesh, place) in prints.stls().zip(&places.meshes) {
        put(place, &mesh)?;
    }
    for (project, place) in projects.zip(&places.projects) {
        put(place, &project)?;
    }
    let (mut slicer, mut flaws) = (None, Vec::new());
    if !args.meshes_only {
        let done = job::slice(&SliceRequest { plan: &plan, prints: &prints, options: &options }, &world)?;
        for (gcode, place) in done.sliced.iter().zip(&places.sliced) {
            put(place, gcode)?;
        }
        slicer = Some(done.slicer);
        flaws = done.flaws;
    }
    if console.json() {
        console.document(&document::sliced(&written, slicer.as_ref(), &options.bed, &flaws));
    } else {
        console.summary(&written.join("\n"), true);
    }
    Ok(())
}

/// The line of the post-processing script, for a window that stands in any folder.
fn script(args: &Verb) -> Result<String, Failure> {
    let whole = |path: &std::path::Path| path.canonicalize().unwrap_or_else(|_| path.to_owned()).display().to_string();
    let own = std::env::current_exe().map_or_else(|_| "trunnion".to_owned(), |path| whole(&path));
    let quoted = |word: String| if word.contains([' ', '(', ')', '&']) { format!("\"{word}\"") } else { word };
    let (own, plan) = (quoted(own), quoted(whole(&args.plan)));
    Ok(format!("{own} rewrite --in-place --bed {} --plan {plan}", args.bed.bed))
}

/// Where everything goes.
struct Places {
    meshes: Vec<OutputFile>,
    projects: Vec<OutputFile>,
    sliced: Vec<OutputFile>,
}

impl Places {
    fn claim(
        args: &Verb,
        loaded: &CheckedPlan,
        names: &[String],
        spots: &[ProjectSpot],
        projects: usize,
    ) -> Result<Self, Failure> {
        let configs = args.slicing.slicer_config.iter().map(PathBuf::as_path);
        let mut outputs = outputs([args.plan.as_path()].into_iter().chain(loaded.inputs()).chain(configs));
        outputs.folder(&args.output)?;
        let mut all = |end: &str| -> Result<Vec<OutputFile>, FileError> {
            names.iter().map(|name| outputs.claim(&args.output.join(format!("{name}.{end}")))).collect()
        };
        let meshes = all("stl")?;
        let sliced = if args.meshes_only { Vec::new() } else { all("gcode")? };
        // PrusaSlicer calls an object that is alone in a project after the project's file.
        let project = |i: usize| {
            let its: Vec<usize> = (0..spots.len()).filter(|&print| spots[print].project == i).collect();
            match its[..] {
                _ if projects == 1 => "project.3mf".to_owned(),
                [alone] => format!("{}.3mf", names[alone]),
                _ => format!("project-{}.3mf", i + 1),
            }
        };
        let projects: Result<Vec<OutputFile>, _> =
            (0..projects).map(|i| outputs.claim(&args.output.join(project(i)))).collect();
        Ok(Self { meshes, sliced, projects: projects? })
    }
}
