//! `trunnion plan`

use std::fmt::Write;

use super::args::Plan as Verb;
use super::requests::{folder_of, outputs, profile_file};
use super::{Console, Failure, why};
use crate::document;
use crate::job::{self, Error, OutputFile, PlanRequest, PlanResult};
use crate::planning::Slot;
use crate::spelling::counted;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let profile = profile_file(&args.machine.profile);
    let read = [args.model.model.as_path()].into_iter().chain(profile.as_deref());
    let mut outputs = outputs(read);
    let output = args.output.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let picture = args.sheet.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let mut options = args.plan.options()?;
    options.plans = args.top.unwrap_or(1);
    options.kept_in = folder_of(args.output.as_deref());
    let request = PlanRequest { model: args.model.source()?, machine: args.machine.source(), options };
    if args.all {
        return list(&request, args.limit, console);
    }
    let made = explained(job::plan(&request, &console.world()), picture.as_ref(), console)?;
    search(&made, console);
    if let Some(output) = &output {
        output.write(made.plan.plan.to_text().as_bytes())?;
    }
    if let Some(picture) = &picture {
        picture.write(made.sheet().as_bytes())?;
    }
    if console.json() {
        console.document(&document::planned(&made));
    } else {
        console.result(&text(&made));
        if args.top.is_some() {
            console.result(&comparison(&made));
        }
    }
    Ok(())
}

/// Where there is no plan, says why, and what would help.
pub(super) fn explained<T>(
    done: Result<T, Error>,
    picture: Option<&OutputFile>,
    console: &Console,
) -> Result<T, Failure> {
    if let Err(Error::NoPlan(no)) = &done {
        why::explain(no, picture, console)?;
    }
    Ok(done?)
}

/// How the search went.
pub(super) fn search(made: &PlanResult, console: &Console) {
    if made.moved {
        let placement = &made.plan.plan.placement;
        let [x, y, _] = placement.origin_mm;
        console.note(&format!("moved to {x} {y} mm, turned {} deg: there the axes reach", placement.turn_deg));
    }
    let best = made.best();
    console.detail(&format!(
        "{} directions tried, {} orientations kept, {} steps of the search",
        best.tried, best.candidates, best.steps
    ));
}

/// `--all`: every sequence, as it is found.
fn list(request: &PlanRequest, most: usize, console: &Console) -> Result<(), Failure> {
    let mut listed: Vec<Vec<Slot>> = Vec::new();
    let done = job::sequences(request, most, &console.world(), |slots| {
        if console.json() {
            listed.push(slots);
        } else {
            console.result(&line(&slots));
        }
    })?;
    let (count, complete, seconds) = (done.count, done.complete, done.seconds);
    if console.json() {
        console.document(&document::sequences(&listed, &done));
    } else if complete {
        console.note(&format!("{count} sequences, all there are, {seconds:.2} s"));
    } else {
        console.note(&format!("{count} sequences and more; --limit and --budget say how many, {seconds:.2} s"));
    }
    Ok(())
}

/// A sequence as `0 | 1 | 3,5 @ A70 C90; 7,8 @ A70 C-90`.
fn line(slots: &[Slot]) -> String {
    let setup = |prints: &Vec<&crate::planning::Print>| {
        let parts: Vec<String> = prints.iter().map(|p| p.part.to_string()).collect();
        format!("{} @ {} {}", parts.join(","), prints[0].tilt_deg, prints[0].rotation_deg)
    };
    let slot = |slot: &Slot| slot.setups().iter().map(setup).collect::<Vec<_>>().join("; ");
    slots.iter().map(slot).collect::<Vec<_>>().join(" | ")
}

pub(super) fn text(made: &PlanResult) -> String {
    let k = &made.plan.machine.profile.kinematics;
    let mut out = String::new();
    for slot in &made.plan.plan.slots {
        let _ = writeln!(out, "slot {}", slot.id);
        for setup in slot.setups() {
            let parts: Vec<String> = setup.iter().map(|p| p.part.to_string()).collect();
            let (a, c) = (setup[0].tilt_deg, setup[0].rotation_deg);
            let which = if parts.len() == 1 { "part" } else { "parts" };
            let _ = writeln!(out, "  {}{a} {}{c}: {which} {}", k.tilt.letter, k.rotation.letter, parts.join(", "));
        }
    }
    let best = made.best();
    for w in &best.within_slots {
        let (minutes, by_layer) = (w.seconds / 60.0, w.seconds_layer_by_layer / 60.0);
        let _ = writeln!(
            out,
            "slot {}, pose by pose: {}, {minutes:.1} min; layer by layer it would be {}, {by_layer:.0} min",
            w.slot,
            counted(w.turns, "turn"),
            counted(w.turns_layer_by_layer, "turn")
        );
    }
    let name = if made.objective == "bss" { "building sequence size" } else { &made.objective };
    let proof = if best.value <= best.lower_bound { "the least possible" } else { "not proved least" };
    let _ = writeln!(
        out,
        "{name} {} (at least {}: {proof}), {}, planned clearance {:.2} mm, {:.2} s",
        shown(best.value),
        shown(best.lower_bound),
        counted(best.pose_changes, "pose change"),
        best.clearance_mm,
        made.seconds
    );
    out
}

/// The plans beside each other.
fn comparison(made: &PlanResult) -> String {
    let mut out =
        format!("{:>4} {:>14} {:>6} {:>6} {:>6} {:>9}\n", "plan", made.objective, "slots", "bss", "poses", "time");
    for (i, p) in made.plans.iter().enumerate() {
        let (slots, minutes) = (p.slots.len(), p.seconds / 60.0);
        let value = shown(p.value);
        let (size, poses, staircase) = (p.sequence_size, p.pose_changes, p.staircase);
        let _ = writeln!(
            out,
            "{i:>8} {value:>14} {slots:>6} {size:>6} {poses:>6} {minutes:>5.0} min {:>8} mm3 {staircase:>10.4}",
            0
        );
    }
    if let Some(plain) = &made.three_axis {
        let (minutes, support, staircase) = (plain.seconds / 60.0, plain.support_mm3, plain.staircase);
        let _ = writeln!(
            out,
            "{:>8} {:>14} {:>6} {:>6} {:>6} {minutes:>5.0} min {support:>8.0} mm3 {staircase:>10.4}",
            "3 axes", "-", "-", "-", 0
        );
    }
    out
}

/// Whole numbers as such, others to six digits.
fn shown(value: f64) -> String {
    if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.6}") }
}
