//! `trunnion plan`

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};

use super::args::{Plan as Verb, PlanArgs, SlotArg};
use super::load::{LoadedModel, LoadedProfile};
use super::{Console, Failure, files, load};
use crate::geom::Angle;
use crate::orient::{Multistart, named};
use crate::planning::{
    Infeasible, Options, PartRef, Plan, Planned, Priority, Workpiece, orientations, plan, plannable, sheet,
};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    if let Some(path) = &args.output {
        files::check_output(path, &[&args.model.model, Path::new(&args.machine.profile)])?;
    }
    let machine = load::machine(&args.machine)?;
    let model = load::model(&args.model, console)?;
    let made = make(&model, &machine, &args.plan, console)?;
    if let Some(path) = &args.output {
        files::write(path, made.plan.to_text().as_bytes())?;
    }
    if let Some(path) = &args.sheet {
        let workpiece = Workpiece::place(&model.model, &made.plan.placement);
        files::write(path, sheet(&made.plan, &workpiece, &machine.profile).as_bytes())?;
    }
    if console.json() {
        console.document(&made.document())
    } else {
        console.result(&made.text(&machine))
    }
    Ok(())
}

/// A plan with what the search says of it.
pub(super) struct Made {
    pub(super) plan: Plan,
    pub(super) planned: Planned,
    /// Of `seconds`, what the search for orientations took.
    pub(super) orient_seconds: f64,
    pub(super) seconds: f64,
}

/// Plans, or prints why not and fails.
pub(super) fn make(
    model: &LoadedModel,
    machine: &LoadedProfile,
    args: &PlanArgs,
    console: &Console,
) -> Result<Made, Failure> {
    let start = Instant::now();
    let options = options(args, machine)?;
    let placement = Workpiece::centred(&model.model);
    let workpiece = Workpiece::place(&model.model, &placement);
    workpiece.check(&machine.profile)?;
    plannable(&workpiece)?;
    let directions = orientations(&workpiece, &options);
    let orient_seconds = start.elapsed().as_secs_f64();
    let planned = plan(&workpiece, &machine.profile, &directions, &options).inspect_err(|no| explain(no, console))?;
    console.detail(&format!(
        "{} directions tried, {} orientations kept, {} steps of the search",
        planned.tried, planned.candidates, planned.steps
    ));
    let plan = Plan {
        format: Plan::FORMAT.to_owned(),
        version: Plan::VERSION,
        made_by: format!("trunnion {}", env!("CARGO_PKG_VERSION")),
        model: model.reference(),
        machine: machine.reference(),
        placement,
        parts: model.model.parts.iter().map(|p| PartRef { id: p.id, name: p.name.clone() }).collect(),
        slots: planned.slots.clone(),
    };
    plan.check(&machine.profile.kinematics(), model.model.parts.len())?;
    Ok(Made { plan, planned, orient_seconds, seconds: start.elapsed().as_secs_f64() })
}

fn options(args: &PlanArgs, machine: &LoadedProfile) -> Result<Options, Failure> {
    let layer = machine.profile.process.layer_height_mm;
    let objective = named(&args.objective, layer).ok_or_else(|| {
        let near = crate::orient::nearest(&args.objective, &crate::orient::OBJECTIVES);
        Failure::Usage(format!("--objective {}: not known; did you mean {near}?", args.objective))
    })?;
    if !(0.0..=90.0).contains(&args.overhang) {
        return Err(Failure::Usage(format!("--overhang {} deg is out of 0..90", args.overhang)));
    }
    if !(0.0..=100.0).contains(&args.margin) {
        return Err(Failure::Usage(format!("--margin {} mm is out of 0..100", args.margin)));
    }
    Ok(Options {
        objective,
        overhang: Angle::from_deg(args.overhang),
        margin_mm: args.margin,
        priority: match args.slots {
            SlotArg::Together => Priority::Together,
            SlotArg::Single => Priority::Single,
            SlotArg::OnlySingle => Priority::OnlySingle,
        },
        table_first: !args.table_later,
        search: Multistart { seed: args.seed, ..Multistart::default() },
        budget: args.budget,
    })
}

/// The reasons of an infeasible object: as the document, or as a list.
fn explain(no: &Infeasible, console: &Console) {
    let Infeasible::NoPlan { summary, reasons } = no else { return };
    if console.json() {
        let rows: Vec<Value> = reasons
            .iter()
            .map(|r| json!({"part": r.part, "orientation": r.up, "blocked_by": r.blocked_by, "depth_mm": r.depth_mm, "text": r.text}))
            .collect();
        console.document(&json!({"feasible": false, "summary": summary, "reasons": rows}));
        return;
    }
    let mut text = String::new();
    const SHOWN: usize = 12;
    for r in reasons.iter().take(SHOWN) {
        let [x, y, z] = r.up;
        let _ = writeln!(text, "  part {} with up ({x:.3}, {y:.3}, {z:.3}): {}", r.part, r.text);
    }
    if reasons.len() > SHOWN {
        let _ = writeln!(text, "  and {} more; --json lists them", reasons.len() - SHOWN);
    }
    console.note(text.trim_end());
}

impl Made {
    pub(super) fn document(&self) -> Value {
        let mut document = json!(self.plan);
        if let Some(map) = document.as_object_mut() {
            map.insert("objective".to_owned(), json!("bss"));
            map.insert("value".to_owned(), json!(self.planned.value));
            map.insert("lower_bound".to_owned(), json!(self.planned.lower_bound));
            map.insert("clearance_mm".to_owned(), json!(self.planned.clearance_mm));
            map.insert("seconds".to_owned(), json!(self.seconds));
        }
        document
    }

    pub(super) fn text(&self, machine: &LoadedProfile) -> String {
        let k = &machine.profile.kinematics;
        let mut out = String::new();
        for slot in &self.plan.slots {
            let _ = writeln!(out, "slot {}", slot.id);
            for setup in slot.setups() {
                let parts: Vec<String> = setup.iter().map(|p| p.part.to_string()).collect();
                let (a, c) = (setup[0].tilt_deg, setup[0].rotation_deg);
                let _ = writeln!(out, "  {}{a} {}{c}: parts {}", k.tilt.letter, k.rotation.letter, parts.join(", "));
            }
        }
        let (value, bound) = (self.planned.value, self.planned.lower_bound);
        let proof = if value <= bound { "the least possible" } else { "not proved least" };
        let _ = writeln!(
            out,
            "building sequence size {value} (at least {bound}: {proof}), clearance {:.2} mm, {:.2} s",
            self.planned.clearance_mm, self.seconds
        );
        out
    }
}
