//! `trunnion prepare`: how a file came about, what is known of it, and plates.

use super::jog_text::unseen;
use super::plan_text::ways;
use super::verified_text::{joints, unsteady};
use crate::job::{PlateEvent, PlateModel, PrepareResult};
use crate::verify::Report;

/// The ways that were compared, and what became of the model's solids.
pub fn done_how(done: &PrepareResult) -> Vec<String> {
    let seconds = done.gcode.report().map_or(0.0, |report| report.seconds_print);
    let held = done.held.iter().map(|held| held.story(seconds));
    let cut = done.cut.iter().map(|cut| cut.story(seconds));
    ways(&done.planned.ways).lines().map(str::to_owned).chain(held).chain(cut).collect()
}

/// What nobody has seen of the machine, and what is known of the file that was written to `output`; the last line says that it was verified.
pub fn done_what(output: &str, done: &PrepareResult) -> Vec<String> {
    let machine = &done.planned.plan.machine;
    let proof = done.gcode.report().map(|report| proved(output, done, report));
    unseen(&machine.profile, &machine.name).into_iter().chain(proof.into_iter().flatten()).collect()
}

/// `trunnion prepare`: what is known of the file that was written to `output`, beside what the plan knew; the last line says that it was verified.
pub fn proved(output: &str, done: &PrepareResult, report: &Report) -> Vec<String> {
    let unsteady = unsteady(report).filter(|_| done.planned.standing.is_none());
    let lines = done.gcode.program().iter().filter(|b| **b == b'\n').count();
    let verified = format!(
        "{output}: {lines} lines, verified; about {:.0} min, clearance {:.2} mm",
        report.seconds_print / 60.0,
        report.clearance_mm,
    );
    unsteady.into_iter().chain(joints(report)).chain([verified]).collect()
}

/// What happens while plates are made.
pub fn plate(event: &PlateEvent<'_>) -> Vec<String> {
    match event {
        PlateEvent::Begun { number, plate } => {
            let times = if plate.times > 1 { format!(", printed {} times", plate.times) } else { String::new() };
            vec![format!("plate {number}: {}{times}", held(plate))]
        }
        PlateEvent::MoreRoom => {
            vec!["no plan with its objects so near to each other; distributing them again".to_owned()]
        }
        PlateEvent::Made { output, plate, done, .. } => {
            let times = (plate.times > 1).then(|| format!("{}: print it {} times", output.display(), plate.times));
            done_how(done).into_iter().chain(done_what(&output.display().to_string(), done)).chain(times).collect()
        }
    }
}

/// What is on a plate: `3 x cube.stl, 1 x hook.stl`.
fn held(plate: &PlateModel) -> String {
    plate.holds.iter().map(|(file, count)| format!("{count} x {file}")).collect::<Vec<_>>().join(", ")
}
