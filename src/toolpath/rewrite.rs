//! Prints in the plan's order, with the moves between them, as one file for the machine.
//!
//! ```text
//! for each pose: retract - up along the tool - turn, one axis a block - over the next start - down - prime
//!   for each layer, lowest first: the print it belongs to, shifted; between different prints a travel of ours
//! ```

use std::io::Write;

use super::export::{check_box, slot_mesh};
use super::fits;
use super::inputs::{Chunk, Entry, Input, RewriteError, RewriteJob, Rewritten};
use super::joint::{Joint, Pressed};
use super::writer::Writer;
use crate::geom::Vec3;
use crate::motion::TableKinematics;
use crate::planning::{Head, Plan, Print, Printed, joint_gap_mm};

/// One file for the machine from all prints of the plan, written to `sink` bit by bit in the order of its lines.
///
/// Every input is gone through once more; beside them some hundred bytes a layer are held, and the tail that is not
/// written yet.
///
/// # Errors
///
/// [`RewriteError`]. After [`RewriteError::Write`] and [`RewriteError::Sliced`] part of a file is written, which must not
/// be printed; after all others nothing is.
pub fn rewrite(
    inputs: &[Input<'_>],
    job: &RewriteJob<'_>,
    sink: &mut (dyn Write + Send),
) -> Result<Rewritten, RewriteError> {
    let table = job.profile.kinematics();
    let mut notes = Vec::new();
    for input in inputs {
        notes.extend(fits::check(input, job.profile)?);
    }
    let entries = entries(inputs, job, &table)?;
    let setups = setups(&entries, job.plan)?;
    let head = Head::of(job.profile);
    let mut writer = Writer::new(job, &table, &head, entries.len(), sink);
    writer.header(&entries);
    for (group, chunks) in &setups {
        writer.setup(group, chunks)?;
    }
    writer.footer(&entries);
    let (bytes, lowered, mut warnings) = writer.finish()?;
    if let Some(feed) = lowered {
        let most = job.profile.limits.max_feed_mm_per_min;
        warnings.push(format!("feeds up to {feed:.0} mm/min were lowered to the machine's {most:.0} mm/min"));
    }
    warnings.extend(left_out(&entries));
    notes.sort();
    notes.dedup();
    warnings.extend(notes);
    Ok(Rewritten { bytes, warnings })
}

/// What the sliced files have and the file for the machine has not.
fn left_out(entries: &[Entry<'_>]) -> Vec<String> {
    let mut warnings = Vec::new();
    let mut replaced: Vec<&str> = entries.iter().flat_map(|e| &e.input.sliced.replaced).map(String::as_str).collect();
    replaced.sort_unstable();
    replaced.dedup();
    if !replaced.is_empty() {
        warnings.push(format!(
            "omitted from the slicer's own start or end code: {}; the profile's [dialect] start and end replace it",
            replaced.join(", ")
        ));
    }
    if entries.iter().any(|entry| entry.input.sliced.pictures) {
        warnings.push(
            "time-lapse pictures (TIMELAPSE_TAKE_FRAME) are omitted: they may move the head; add the command to [dialect] allow to keep them"
                .to_owned(),
        );
    }
    if entries.iter().any(|entry| entry.input.sliced.labelled) {
        warnings.push(
            "object labels (M486, EXCLUDE_OBJECT) are omitted: cancelling a part would leave what is on it in mid-air"
                .to_owned(),
        );
    }
    warnings
}

/// The inputs in printing order (a slot's setups one after the other), each checked against its mesh.
fn entries<'a>(
    inputs: &'a [Input<'a>],
    job: &'a RewriteJob<'_>,
    table: &TableKinematics,
) -> Result<Vec<Entry<'a>>, RewriteError> {
    let prints: Vec<(usize, &Print)> = job.plan.prints().collect();
    let all = prints.len() + job.plan.supports().count();
    for (index, input) in inputs.iter().enumerate() {
        let problem = if input.print >= all {
            "is not in the plan"
        } else if inputs[..index].iter().any(|other| other.print == input.print) {
            "was given before"
        } else {
            continue;
        };
        return Err(RewriteError::Unexpected { file: input.file.to_owned(), print: input.print, problem });
    }
    let mut entries = Vec::new();
    let mut printed: Vec<Printed> = Vec::new();
    for (slot, index, print) in job.plan.as_made() {
        let Some(input) = inputs.iter().find(|i| i.print == index) else {
            return Err(RewriteError::Missing { print: index, slot, part: print.part });
        };
        if let Some(number) = job.plan.supports_of(index) {
            let missing = || RewriteError::Missing { print: number, slot, part: print.part };
            let input = inputs.iter().find(|i| i.print == number).ok_or_else(missing)?;
            let mesh = slot_mesh(job.workpiece, table, print, input.centre_mm).above_table();
            entries.push(Entry { input, print, slot, mesh, joint: Joint::default(), holds: true });
        }
        let mesh = slot_mesh(job.workpiece, table, print, input.centre_mm);
        check_box(&mesh, input.sliced, job.profile).map_err(|source| RewriteError::Box {
            file: input.file.to_owned(),
            print: index,
            part: print.part,
            source,
        })?;
        let first = job.plan.slots.first().is_some_and(|first| first.id == slot);
        if let (Some(line), false) = (input.sliced.adhesion, mesh.on_table && first) {
            let (file, part) = (input.file.to_owned(), print.part);
            return Err(RewriteError::Adhesion { file, line, print: index, part });
        }
        let up = Vec3::from(print.up);
        let gap = joint_gap_mm(job.workpiece, print.part, up, &printed);
        let mut joint = Joint::over(gap, input.sliced, job.profile);
        if !job.workpiece.model.is_in_place(print.part) {
            joint = joint.settled(gap, input.sliced, job.profile).map_err(|pressed| {
                let (file, part) = (input.file.to_owned(), print.part);
                let Pressed { overlap_mm, room_mm } = pressed;
                RewriteError::Pressed { file, print: index, part, overlap_mm, room_mm }
            })?;
        }
        let lower = if input.sliced.layers.len() == 1 { joint.lower_mm } else { 0.0 };
        printed.push(Printed { part: print.part, up, height_mm: input.sliced.extrusion.max.z - lower });
        entries.push(Entry { input, print, slot, mesh, joint, holds: false });
    }
    Ok(entries)
}

/// A setup's entries and their layers, in printing order.
type Setup<'a> = (&'a [Entry<'a>], Vec<Chunk<'a>>);

fn setups<'a>(entries: &'a [Entry<'a>], plan: &Plan) -> Result<Vec<Setup<'a>>, RewriteError> {
    let mut rest = entries;
    let mut all = Vec::new();
    for setup in plan.slots.iter().flat_map(|slot| slot.setups()) {
        let supports = setup.iter().filter(|print| print.supports.is_some()).count();
        let (group, after) = rest.split_at(setup.len() + supports);
        rest = after;
        all.push((group, chunks(group)?));
    }
    Ok(all)
}

/// All layers of a group, lowest first; one print alone keeps its own order.
fn chunks<'a>(group: &'a [Entry<'a>]) -> Result<Vec<Chunk<'a>>, RewriteError> {
    let mut all = Vec::with_capacity(group.iter().map(|entry| entry.input.sliced.layers.len()).sum());
    for (position, entry) in group.iter().enumerate() {
        let mut highest = f64::NEG_INFINITY;
        for (index, layer) in entry.input.sliced.layers.iter().enumerate() {
            if group.len() > 1 && layer.z < highest {
                let (file, line, z) = (entry.input.file.to_owned(), layer.line, layer.z);
                return Err(RewriteError::LayersDescend { file, line, z });
            }
            highest = layer.z;
            all.push(Chunk { entry, position, layer, index, z: layer.z + entry.mesh.to_machine.z });
        }
    }
    if group.len() > 1 {
        all.sort_by(|a, b| a.z.total_cmp(&b.z));
    }
    Ok(all)
}
