//! A plan's prints as meshes, and sliced.

use std::path::PathBuf;
use std::time::Duration;

use rayon::prelude::*;

use super::error::PrintError;
use crate::geom::{Rigid, Vec3};
use crate::input::{BadSetting, CheckedPlan};
use crate::mesh::{stl_binary, threemf_project};
use crate::planning::Print;
use crate::slicing::{
    Adhesion, Flaw, SliceJob, Sliced, Slicer, SlicerChoice, WindowBed, below_middles, project_settings,
};
use crate::strategy::adhesion;
use crate::toolpath::{Bed, ProjectSpot, SlotMesh, layout, print_name, slot_mesh};
use crate::world::World;

/// How to slice.
#[derive(Clone, Debug, PartialEq)]
pub struct SlicingOptions {
    /// Who slices.
    pub slicer: SlicerChoice,
    /// The slicer's own configurations, over the profile's `[process]`, in rising order of precedence.
    pub configs: Vec<PathBuf>,
    /// The slicer is given up after this long for one print.
    pub timeout: Duration,
    /// The slicer's bed, on whose middle each print stands.
    pub bed: Bed,
}

impl Default for SlicingOptions {
    fn default() -> Self {
        Self {
            slicer: SlicerChoice::Auto,
            configs: Vec::new(),
            timeout: Duration::from_secs(300),
            bed: Bed::from([250.0, 250.0]),
        }
    }
}

/// Beyond this the `f32` of an STL no longer holds a micron, mm.
pub const LARGEST_BED_MM: f64 = 5000.0;

/// A slicer's bed in words: `250x210`, its corner at 0, 0; or from where to where, `-125..125x-105..105`; mm.
///
/// # Errors
///
/// [`InputError::Setting`](crate::input::InputError::Setting).
pub fn bed(text: &str) -> Result<Bed, PrintError> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.abs() <= LARGEST_BED_MM);
    let side = |t: &str| {
        let (low, high) = t.split_once("..").unwrap_or(("0", t));
        number(low).zip(number(high)).filter(|(low, high)| low < high)
    };
    let parsed = text.split_once(['x', 'X', ',']).and_then(|(x, y)| side(x).zip(side(y)));
    let Some(((x0, x1), (y0, y1))) = parsed else {
        let wanted = format!(
            "must be width x depth in mm up to {LARGEST_BED_MM}, for example 250x210, or ranges such as -125..125x-105..105"
        );
        return Err(BadSetting::Words { name: "bed", text: text.to_owned(), wanted }.into());
    };
    Ok(Bed { min_mm: [x0, y0], max_mm: [x1, y1] })
}

impl SlicingOptions {
    /// The slicer that is asked for, found and asked for its version.
    pub(super) fn slicer(&self, world: &World<'_>) -> Result<Box<dyn Slicer>, PrintError> {
        check_bed(&self.bed)?;
        for config in &self.configs {
            world.files.size(config)?;
        }
        Ok(world.slicers.find(&self.slicer, &self.configs, self.timeout)?)
    }
}

/// All prints of a plan as a slicer gets them, in the plan's order.
pub struct Prints {
    /// Each upright, its lowest point at z = 0, on the middle of the bed.
    pub meshes: Vec<SlotMesh>,
    /// A name each, `print-NN-..`, fit for files and labels.
    pub names: Vec<String>,
    bed: Bed,
}

impl Prints {
    /// The prints of `plan` on a bed of this size.
    pub fn of(plan: &CheckedPlan, bed: Bed) -> Self {
        let (table, workpiece) = (plan.machine.profile.kinematics(), plan.workpiece());
        let centre = bed.middle_mm();
        let meshes = plan.prints().map(|(_, print)| slot_mesh(&workpiece, &table, print, centre)).collect();
        let parts = plan.prints().map(|(_, print)| &workpiece.model.parts[print.part].name).enumerate();
        let names = parts.map(|(index, part)| print_name(index, part)).collect();
        Self { meshes, names, bed }
    }

    /// The meshes as files for another slicer, each made when it is asked for.
    pub fn stls(&self) -> impl Iterator<Item = Vec<u8>> {
        self.meshes.iter().map(|slot| stl_binary(&below_middles(&slot.mesh)))
    }

    /// Where a print stands in what a slicer that we run gives back: its own bed has its corner at 0, 0.
    pub(super) fn sliced_centre(&self) -> [f64; 2] {
        self.bed.size_mm().map(|size| size / 2.0)
    }

    /// Where each stands in the projects.
    ///
    /// # Errors
    ///
    /// [`PrintError::OffBed`] for a print that the bed does not hold, and [`InputError::Setting`](crate::input::InputError::Setting)
    /// for a bed that cannot be.
    pub fn spots(&self) -> Result<Vec<ProjectSpot>, PrintError> {
        check_bed(&self.bed)?;
        Ok(layout(&sizes(&self.meshes), &self.bed)?)
    }

    /// The projects for PrusaSlicer's window that these spots make, each made when it is asked for: an object a print, to be printed
    /// one by one, with all settings. Where there is only one, `script` (the whole line, without the file) is run over what the slicer
    /// makes of it.
    pub fn projects(
        &self,
        plan: &CheckedPlan,
        spots: &[ProjectSpot],
        script: &str,
    ) -> impl ExactSizeIterator<Item = Vec<u8>> {
        let (table, workpiece) = (plan.machine.profile.kinematics(), plan.workpiece());
        let prints: Vec<&Print> = plan.prints().map(|(_, print)| print).collect();
        let tallest = self.meshes.iter().map(|m| m.mesh.bounds().max.z).fold(0.0, f64::max);
        let count = spots.iter().map(|spot| spot.project + 1).max().unwrap_or(0);
        let script = if count == 1 { script } else { "" };
        let on = WindowBed { min_mm: self.bed.min_mm, max_mm: self.bed.max_mm };
        let settings = project_settings(&plan.machine.profile.process, on, tallest, script);
        (0..count).map(move |project| {
            let its: Vec<usize> = (0..prints.len()).filter(|&i| spots[i].project == project).collect();
            let mesh = |&i: &usize| slot_mesh(&workpiece, &table, prints[i], spots[i].centre_mm).mesh;
            let meshes: Vec<_> = its.iter().map(|i| below_middles(&mesh(i))).collect();
            let objects: Vec<_> = its.iter().map(|&i| self.names[i].clone()).zip(&meshes).collect();
            threemf_project(&objects, &settings)
        })
    }
}

/// What each print takes of the bed.
pub(super) fn sizes(meshes: &[SlotMesh]) -> Vec<[f64; 2]> {
    let size = |mesh: &SlotMesh| mesh.mesh.bounds().size();
    meshes.iter().map(size).map(|size| [size.x, size.y]).collect()
}

/// Refuses a bed that is none, or lies where an STL no longer holds a micron.
pub(super) fn check_bed(bed: &Bed) -> Result<(), PrintError> {
    for axis in 0..2 {
        BadSetting::within("bed", bed.size_mm()[axis], " mm", [0.0, LARGEST_BED_MM])?;
        for side in [bed.min_mm[axis], bed.max_mm[axis]] {
            BadSetting::within("bed", side, " mm", [-LARGEST_BED_MM, LARGEST_BED_MM])?;
        }
    }
    Ok(())
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
/// [`PrintError::Slice`], [`InputError::Setting`](crate::input::InputError::Setting), and what keeps a configuration from being
/// read.
pub fn slice(request: &SliceRequest<'_>, world: &World<'_>) -> Result<SliceResult, PrintError> {
    let slicer = request.options.slicer(world)?;
    slice_by(slicer.as_ref(), request.prints, request.plan, world)
}

/// Slices by a slicer that was found before.
pub(super) fn slice_by(
    slicer: &dyn Slicer,
    prints: &Prints,
    plan: &CheckedPlan,
    world: &World<'_>,
) -> Result<SliceResult, PrintError> {
    let bar = world.progress.begin("slicing", prints.meshes.len());
    let mut sliced = Vec::with_capacity(prints.meshes.len());
    let mut flaws: Vec<(String, Flaw)> =
        slicer.flaws().into_iter().map(|flaw| (slicer.name().to_owned(), flaw)).collect();
    let (around, lessened): (Vec<_>, Vec<_>) =
        adhesion::of_prints(plan, &slicer.around(&plan.machine.profile.process)?, &prints.meshes).into_iter().unzip();
    flaws.extend(prints.names.iter().zip(lessened).filter_map(|(name, flaw)| Some((name.clone(), flaw?))));
    let all: Vec<((&SlotMesh, &String), Adhesion)> = prints.meshes.iter().zip(&prints.names).zip(around).collect();
    // A few at a time, so that the bar moves; the order of results is that of the prints.
    for batch in all.chunks(rayon::current_num_threads().max(1)) {
        let one = |&((slot, name), adhesion): &((&SlotMesh, &String), Adhesion)| {
            let bed_mm = prints.bed.size_mm();
            let job = SliceJob { name: name.clone(), on_table: slot.on_table, bed_mm, adhesion };
            let process = &plan.machine.profile.process;
            let [x, y] = prints.bed.min_mm;
            if [x, y] == [0.0; 2] {
                return slicer.slice(&slot.mesh, process, &job);
            }
            slicer.slice(&slot.mesh.moved(&Rigid::shift(Vec3::new(-x, -y, 0.0))), process, &job)
        };
        let done: Result<Vec<Sliced>, _> = batch.par_iter().map(one).collect();
        for (done, ((_, name), _)) in done?.into_iter().zip(batch) {
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
