//! `trunnion slice`

use std::path::PathBuf;

use super::args::Slice as Verb;
use super::requests::outputs;
use super::{Console, Failure};
use crate::document;
use crate::job::{self, CheckedPlan, Output, Prints, SliceRequest};
use crate::mesh::stl_binary;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let world = console.world();
    let plan = job::load_plan(&args.plan_ref.source(&args.plan), &world)?;
    let options = args.slicing.options(&args.bed)?;
    let prints = Prints::of(&plan, options.bed_mm);
    let places = Places::claim(args, &plan, &prints.names)?;
    let mut written: Vec<String> = Vec::new();
    let mut put = |output: &Output, bytes: &[u8]| {
        written.push(output.path().display().to_string());
        output.write(bytes)
    };
    for (mesh, place) in prints.meshes.iter().zip(&places.meshes) {
        put(place, &stl_binary(&mesh.mesh))?;
    }
    put(&places.project, &prints.project(&plan))?;
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
        console.document(&document::sliced(&written, slicer.as_ref(), options.bed_mm, &flaws));
    } else {
        console.result(&written.join("\n"));
    }
    Ok(())
}

/// Where everything goes.
struct Places {
    meshes: Vec<Output>,
    project: Output,
    sliced: Vec<Output>,
}

impl Places {
    fn claim(args: &Verb, loaded: &CheckedPlan, names: &[String]) -> Result<Self, Failure> {
        let configs = args.slicing.slicer_config.iter().map(PathBuf::as_path);
        let mut outputs = outputs([args.plan.as_path()].into_iter().chain(loaded.inputs()).chain(configs));
        outputs.folder(&args.output)?;
        let mut all = |end: &str| -> Result<Vec<Output>, job::Error> {
            names.iter().map(|name| outputs.claim(&args.output.join(format!("{name}.{end}")))).collect()
        };
        let meshes = all("stl")?;
        let sliced = if args.meshes_only { Vec::new() } else { all("gcode")? };
        Ok(Self { meshes, sliced, project: outputs.claim(&args.output.join("project.3mf"))? })
    }
}
