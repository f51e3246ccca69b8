//! A plan's prints as meshes, and sliced.

use std::path::PathBuf;
use std::time::Duration;

use rayon::prelude::*;

use super::{BadSetting, CheckedPlan, Error, World};
use crate::mesh::threemf;
use crate::slicing::{Flaw, SliceJob, Sliced, Slicer, SlicerChoice};
use crate::toolpath::{SlotMesh, print_name, project_layout, slot_mesh};

/// How to slice.
#[derive(Clone, Debug, PartialEq)]
pub struct SlicingOptions {
    /// Who slices.
    pub slicer: SlicerChoice,
    /// The slicer's own configurations, over the profile's `[process]`, in rising order of precedence.
    pub configs: Vec<PathBuf>,
    /// The slicer is given up after this long for one print.
    pub timeout: Duration,
    /// Size of the slicer's bed, on whose centre each print stands.
    pub bed_mm: [f64; 2],
}

impl Default for SlicingOptions {
    fn default() -> Self {
        Self {
            slicer: SlicerChoice::Auto,
            configs: Vec::new(),
            timeout: Duration::from_secs(300),
            bed_mm: [250.0, 250.0],
        }
    }
}

/// Beyond this the `f32` of an STL no longer holds a micron, mm.
pub const LARGEST_BED_MM: f64 = 5000.0;

impl SlicingOptions {
    /// The slicer that is asked for, found and asked for its version.
    pub(super) fn slicer(&self, world: &World<'_>) -> Result<Box<dyn Slicer>, Error> {
        for side in self.bed_mm {
            BadSetting::within("bed", side, " mm", [0.0, LARGEST_BED_MM])?;
        }
        for config in &self.configs {
            world.files.size(config)?;
        }
        world.slicers.find(&self.slicer, &self.configs, self.timeout)
    }
}

/// All prints of a plan as a slicer gets them, in the plan's order.
pub struct Prints {
    /// Each upright, its lowest point at z = 0, on the middle of the bed.
    pub meshes: Vec<SlotMesh>,
    /// A name each, `print-NN-..`, fit for files and labels.
    pub names: Vec<String>,
    bed_mm: [f64; 2],
}

impl Prints {
    /// The prints of `plan` on a bed of this size.
    pub fn of(plan: &CheckedPlan, bed_mm: [f64; 2]) -> Self {
        let (table, workpiece) = (plan.machine.profile.kinematics(), plan.workpiece());
        let centre = middle(bed_mm);
        let meshes = plan.prints().map(|(_, print)| slot_mesh(&workpiece, &table, print, centre)).collect();
        let parts = plan.prints().map(|(_, print)| &workpiece.model.parts[print.part].name).enumerate();
        let names = parts.map(|(index, part)| print_name(index, part)).collect();
        Self { meshes, names, bed_mm }
    }

    /// The middle of the bed.
    pub(super) fn centre(&self) -> [f64; 2] {
        middle(self.bed_mm)
    }

    /// One 3MF with an object a print, apart from each other, to be printed one by one.
    pub fn project(&self, plan: &CheckedPlan) -> Vec<u8> {
        let (table, workpiece) = (plan.machine.profile.kinematics(), plan.workpiece());
        let sizes: Vec<_> = self.meshes.iter().map(|m| m.mesh.bounds().size()).collect();
        let (centres, _) = project_layout(&sizes);
        let placed = plan.prints().zip(&centres);
        let meshes: Vec<SlotMesh> =
            placed.map(|((_, print), &centre)| slot_mesh(&workpiece, &table, print, centre)).collect();
        let objects: Vec<_> = self.names.iter().cloned().zip(meshes.iter().map(|m| &m.mesh)).collect();
        threemf(&objects)
    }
}

fn middle(bed: [f64; 2]) -> [f64; 2] {
    [bed[0] / 2.0, bed[1] / 2.0]
}

/// Prints of a plan, and how to slice them.
#[derive(Clone, Copy)]
pub struct SliceRequest<'a> {
    /// The plan.
    pub plan: &'a CheckedPlan,
    /// Its prints.
    pub prints: &'a Prints,
    /// How.
    pub options: &'a SlicingOptions,
}

/// Sliced prints.
#[derive(Clone, Debug)]
pub struct SliceResult {
    /// G-code of each print, in the order of the request's.
    pub sliced: Vec<Vec<u8>>,
    /// Who sliced.
    pub slicer: SlicerName,
    /// What is not in them, with the print's name; told already.
    pub flaws: Vec<(String, Flaw)>,
}

/// A slicer as it calls itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SlicerName {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
}

/// Slices every print of a plan.
///
/// # Errors
///
/// [`Error::Slice`], [`Error::Setting`], and what keeps a configuration from being read.
pub fn slice(request: &SliceRequest<'_>, world: &World<'_>) -> Result<SliceResult, Error> {
    let slicer = request.options.slicer(world)?;
    slice_by(slicer.as_ref(), request.prints, request.plan, world)
}

/// Slices by a slicer that was found before.
pub(super) fn slice_by(
    slicer: &dyn Slicer,
    prints: &Prints,
    plan: &CheckedPlan,
    world: &World<'_>,
) -> Result<SliceResult, Error> {
    let bar = world.progress.begin("slicing", prints.meshes.len());
    let mut sliced = Vec::with_capacity(prints.meshes.len());
    let mut flaws: Vec<(String, Flaw)> =
        slicer.flaws().into_iter().map(|flaw| (slicer.name().to_owned(), flaw)).collect();
    let all: Vec<(&SlotMesh, &String)> = prints.meshes.iter().zip(&prints.names).collect();
    // A few at a time, so that the bar moves; the order of results is that of the prints.
    for batch in all.chunks(rayon::current_num_threads().max(1)) {
        let one = |(slot, name): &(&SlotMesh, &String)| {
            let job = SliceJob { name: (*name).clone(), on_table: slot.on_table, bed_mm: prints.bed_mm };
            slicer.slice(&slot.mesh, &plan.machine.profile.process, &job)
        };
        let done: Result<Vec<Sliced>, _> = batch.par_iter().map(one).collect();
        for (done, (_, name)) in done?.into_iter().zip(batch) {
            sliced.push(done.gcode);
            flaws.extend(done.flaws.into_iter().map(|flaw| ((*name).clone(), flaw)));
        }
        bar.at(sliced.len());
    }
    let slicer = SlicerName { name: slicer.name().to_owned(), version: slicer.version().to_owned() };
    let told = flaws.iter().filter(|(_, flaw)| flaw.is_worth_a_warning());
    told.for_each(|(name, flaw)| world.progress.warning(&format!("{name}: {flaw}")));
    Ok(SliceResult { sliced, slicer, flaws })
}
