//! `trunnion slice`

use std::path::{Path, PathBuf};
use std::time::Duration;

use rayon::prelude::*;
use serde_json::json;

use super::args::{Slice as Verb, SliceArgs};
use super::files::Scratch;
use super::{Console, Failure, files, load};
use crate::mesh::{stl_binary, threemf};
use crate::planning::{Plan, Workpiece};
use crate::profile::Profile;
use crate::slicing::{ExternalOptions, SliceJob, Slicer, SlicerChoice, find};
use crate::toolpath::{SlotMesh, print_name, project_layout, slot_mesh};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let loaded = load::plan(&args.plan, &args.plan_ref, console)?;
    let workpiece = loaded.workpiece();
    let bed = load::bed(&args.bed)?;
    let profile = &loaded.machine.profile;
    let prints = Prints::of(&loaded.plan, &workpiece, profile, bed);
    files::create_folder(&args.output)?;
    let mut written: Vec<PathBuf> = Vec::new();
    for (mesh, name) in prints.meshes.iter().zip(&prints.names) {
        written.push(put(&args.output, &format!("{name}.stl"), &stl_binary(&mesh.mesh))?);
    }
    written.push(put(&args.output, "project.3mf", &prints.project(&loaded.plan, &workpiece, profile))?);
    let mut slicer = None;
    if !args.meshes_only {
        let scratch = Scratch::new()?;
        let chosen = choose(&args.slicing, &scratch)?;
        let sliced = prints.slice(chosen.as_ref(), profile, bed, console)?;
        for (gcode, name) in sliced.iter().zip(&prints.names) {
            written.push(put(&args.output, &format!("{name}.gcode"), gcode)?);
        }
        slicer = Some(json!({"name": chosen.name(), "version": chosen.version()}));
    }
    let names: Vec<String> = written.iter().map(|p| p.display().to_string()).collect();
    if console.json() {
        console.document(&json!({"files": names, "slicer": slicer, "bed_mm": bed}));
    } else {
        console.result(&names.join("\n"));
    }
    Ok(())
}

fn put(folder: &Path, name: &str, bytes: &[u8]) -> Result<PathBuf, Failure> {
    let path = folder.join(name);
    files::write(&path, bytes)?;
    Ok(path)
}

/// The slicer that the flags name, found and asked for its version.
pub(super) fn choose(args: &SliceArgs, scratch: &Scratch) -> Result<Box<dyn Slicer>, Failure> {
    let choice: SlicerChoice = args.slicer.parse().unwrap_or(SlicerChoice::Auto);
    if let Some(missing) = args.slicer_config.iter().find(|p| !files::exists(p)) {
        return Err(Failure::Usage(format!("--slicer-config {}: no such file", missing.display())));
    }
    let options = ExternalOptions {
        configs: args.slicer_config.clone(),
        timeout: Duration::from_secs(args.slicer_timeout),
        work_dir: scratch.path().to_owned(),
    };
    Ok(find(&choice, &options)?)
}

/// All prints of a plan as the slicer gets them.
pub(super) struct Prints {
    pub(super) meshes: Vec<SlotMesh>,
    pub(super) names: Vec<String>,
}

impl Prints {
    pub(super) fn of(plan: &Plan, workpiece: &Workpiece<'_>, profile: &Profile, bed: [f64; 2]) -> Self {
        let table = profile.kinematics();
        let centre = [bed[0] / 2.0, bed[1] / 2.0];
        let meshes = plan.prints().map(|(_, print)| slot_mesh(workpiece, &table, print, centre)).collect();
        let name = |(index, (_, print)): (usize, (usize, &crate::planning::Print))| {
            print_name(index, &workpiece.model.parts[print.part].name)
        };
        Self { meshes, names: plan.prints().enumerate().map(name).collect() }
    }

    /// One 3MF with an object a print, apart from each other, to be printed one by one.
    fn project(&self, plan: &Plan, workpiece: &Workpiece<'_>, profile: &Profile) -> Vec<u8> {
        let table = profile.kinematics();
        let sizes: Vec<_> = self.meshes.iter().map(|m| m.mesh.bounds().size()).collect();
        let (centres, _) = project_layout(&sizes);
        let meshes: Vec<SlotMesh> = plan
            .prints()
            .zip(&centres)
            .map(|((_, print), &centre)| slot_mesh(workpiece, &table, print, centre))
            .collect();
        let objects: Vec<_> = self.names.iter().cloned().zip(meshes.iter().map(|m| &m.mesh)).collect();
        threemf(&objects)
    }

    /// Every print sliced, in order.
    pub(super) fn slice(
        &self,
        slicer: &dyn Slicer,
        profile: &Profile,
        bed: [f64; 2],
        console: &Console,
    ) -> Result<Vec<Vec<u8>>, Failure> {
        let progress = console.progress("slicing", self.meshes.len());
        let mut sliced = Vec::with_capacity(self.meshes.len());
        // A few at a time, so that the bar moves; the order of results is that of the prints.
        let step = rayon::current_num_threads().max(1);
        let all: Vec<(&SlotMesh, &String)> = self.meshes.iter().zip(&self.names).collect();
        for batch in all.chunks(step) {
            let done: Result<Vec<Vec<u8>>, _> = batch
                .par_iter()
                .map(|(slot, name)| {
                    let job = SliceJob { name: (*name).clone(), on_table: slot.on_table, bed_mm: bed };
                    slicer.slice(&slot.mesh, &profile.process, &job)
                })
                .collect();
            sliced.extend(done?);
            progress.at(sliced.len());
        }
        Ok(sliced)
    }
}
