//! `trunnion slice`

use std::path::PathBuf;

use serde_json::{Value, json};

use super::args::Slice as Verb;
use super::requests::outputs;
use super::{Console, Failure};
use crate::job::{self, CheckedPlan, Output, Prints, SliceRequest};
use crate::mesh::stl_binary;
use crate::slicing::Flaw;

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
        slicer = Some(json!({"name": done.slicer.name, "version": done.slicer.version}));
        flaws = done.flaws;
    }
    if console.json() {
        let warnings: Vec<String> = flaws.iter().map(|(name, flaw)| format!("{name}: {flaw}")).collect();
        console.document(&json!({
            "files": written, "slicer": slicer, "bed_mm": options.bed_mm, "left_out": left_out(&flaws), "warnings": warnings,
        }));
    } else {
        console.result(&written.join("\n"));
    }
    Ok(())
}

/// What was too narrow to print: of which print, how much, and where in its own mesh.
pub(super) fn left_out(flaws: &[(String, Flaw)]) -> Vec<Value> {
    let one = |(name, flaw): &(String, Flaw)| match flaw {
        Flaw::LeftOut(left) => Some(json!({
            "print": name, "volume_mm3": left.volume_mm3, "share": left.share, "layers": left.layers, "at_mm": left.at_mm,
            "thinnest_mm": left.thinnest_mm,
        })),
        Flaw::Open { .. } => None,
    };
    flaws.iter().filter_map(one).collect()
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
