//! `trunnion plan`

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};

use super::args::{Plan as Verb, PlanArgs, SlotArg};
use super::load::{LoadedModel, LoadedProfile};
use super::{Console, Failure, files, load, why};
use crate::geom::Angle;
use crate::orient::{Direction, METHODS, Multistart, Objective, Search, Settings, method, nearest, objective};
use crate::planning::{
    Goal, Options, PartRef, Placement, Plan, Planned, Priority, Slot, ThreeAxis, WithinSlot, Workpiece, centred,
    orientations, plan, plan_anywhere, plannable, sequences, sheet, three_axis,
};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    if let Some(path) = &args.output {
        files::check_output(path, &[&args.model.model, Path::new(&args.machine.profile)])?;
    }
    let machine = load::machine(&args.machine)?;
    let model = load::model(&args.model, console)?;
    if args.all {
        return list(args, &model, &machine, console);
    }
    let wish = Wanted { plans: args.top.unwrap_or(1), sheet: args.sheet.as_deref() };
    let made = make(&model, &machine, &args.plan, &wish, console)?;
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
        console.result(&made.text(&machine));
        if args.top.is_some() {
            console.result(&made.comparison());
        }
    }
    Ok(())
}

/// A plan with what the search says of it.
pub(super) struct Made {
    pub(super) plan: Plan,
    /// The best first; the plan is of the first.
    pub(super) plans: Vec<Planned>,
    objective: String,
    /// Printing in three axes on supports, where plans are compared.
    plain: Option<ThreeAxis>,
    /// Of `seconds`, what the search for orientations took.
    pub(super) orient_seconds: f64,
    pub(super) seconds: f64,
}

/// What the flags ask for, checked; `Options` borrow from it.
pub(super) struct Asked {
    goal: Goal,
    objective: Box<dyn Objective>,
    search: Box<dyn Search>,
    placement: Option<Placement>,
}

impl Asked {
    pub(super) fn of(args: &PlanArgs, machine: &LoadedProfile, model: &LoadedModel) -> Result<Self, Failure> {
        let settings = Settings { layer_mm: machine.profile.process.layer_height_mm, ..Settings::default() };
        let usage = |flag: &str, e: &dyn std::fmt::Display| Failure::Usage(format!("{flag}: {e}"));
        let goal = Goal::parse(&args.objective, &settings).map_err(|e| usage("--objective", &e))?;
        let by_part = || objective(&args.objective, &settings).ok();
        let objective = match &args.orient_by {
            Some(text) => objective(text, &settings).map_err(|e| usage("--orient-by", &e))?,
            None => match by_part() {
                Some(of_goal) => of_goal,
                None => objective("staircase", &settings).map_err(|e| usage("--orient-by", &e))?,
            },
        };
        if !(0.0..=90.0).contains(&args.overhang) {
            return Err(Failure::Usage(format!("--overhang {} deg is out of 0..90", args.overhang)));
        }
        if !(0.0..=100.0).contains(&args.margin) {
            return Err(Failure::Usage(format!("--margin {} mm is out of 0..100", args.margin)));
        }
        if args.orient_budget == Some(0) {
            return Err(Failure::Usage("--orient-budget 0: allowed is 1 and more".to_owned()));
        }
        let search: Box<dyn Search> = match &args.method {
            None => {
                let usual = Multistart { seed: args.seed, ..Multistart::default() };
                Box::new(Multistart { budget: args.orient_budget.unwrap_or(usual.budget), ..usual })
            }
            Some(name) => method(name, objective.as_ref(), args.orient_budget, args.seed).ok_or_else(|| {
                Failure::Usage(format!("--method {name}: not known; did you mean {}?", nearest(name, &METHODS)))
            })?,
        };
        Ok(Self { goal, objective, search, placement: placement(args, model)? })
    }

    pub(super) fn options<'a>(&'a self, args: &PlanArgs, plans: usize) -> Options<'a> {
        Options {
            overhang: Angle::from_deg(args.overhang),
            margin_mm: args.margin,
            priority: match args.slots {
                SlotArg::Together => Priority::Together,
                SlotArg::Single => Priority::Single,
                SlotArg::OnlySingle => Priority::OnlySingle,
            },
            table_first: !args.table_later,
            budget: args.budget,
            plans,
            ..Options::new(&self.goal, self.objective.as_ref(), self.search.as_ref())
        }
    }
}

/// The placement that `--origin` and `--turn` ask for; the height is the table's.
fn placement(args: &PlanArgs, model: &LoadedModel) -> Result<Option<Placement>, Failure> {
    let Some(text) = &args.origin else { return Ok(None) };
    let bad = || Failure::Usage(format!("--origin {text}: not two numbers of millimetres; write --origin 12.5,-30"));
    let (x, y) = text.split_once(',').ok_or_else(bad)?;
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(bad);
    let turn_deg = args.turn.unwrap_or(0.0);
    if !(-360.0..=360.0).contains(&turn_deg) {
        return Err(Failure::Usage(format!("--turn {turn_deg} deg is out of -360..360")));
    }
    Ok(Some(Placement { origin_mm: [number(x)?, number(y)?, -model.model.bounds.min.z], turn_deg }))
}

/// What is wanted beside the plan.
pub(super) struct Wanted<'a> {
    /// How many distinct plans.
    pub(super) plans: usize,
    /// Where the picture goes, also of an object without a plan.
    pub(super) sheet: Option<&'a Path>,
}

/// Plans, or prints why not and what would help, and fails.
pub(super) fn make(
    model: &LoadedModel,
    machine: &LoadedProfile,
    args: &PlanArgs,
    wish: &Wanted<'_>,
    console: &Console,
) -> Result<Made, Failure> {
    let plans = wish.plans;
    if !(1..=100).contains(&plans) {
        return Err(Failure::Usage(format!("--top {plans} is out of 1..100")));
    }
    let start = Instant::now();
    let asked = Asked::of(args, machine, model)?;
    let options = asked.options(args, plans);
    let (base, directions) = standing(model, machine, &asked, &options)?;
    let orient_seconds = start.elapsed().as_secs_f64();
    let profile = &machine.profile;
    let found = if asked.placement.is_some() {
        let workpiece = Workpiece::place(&model.model, &base);
        plan(&workpiece, profile, &directions, &options).map(|plans| (base, plans))
    } else {
        plan_anywhere(&model.model, profile, &base, &directions, &options)
    };
    let (placement, plans) = match found {
        Ok(found) => found,
        Err(no) => {
            let workpiece = Workpiece::place(&model.model, &base);
            let wanted = (!args.no_remedies, wish.sheet);
            why::explain(&no, (&workpiece, profile), (&directions, &options), wanted, console)?;
            return Err(no.into());
        }
    };
    if placement != base {
        let [x, y, _] = placement.origin_mm;
        console.note(&format!("moved to {x} {y} mm, turned {} deg: there the axes reach", placement.turn_deg));
    }
    let best = &plans[0];
    console.detail(&format!(
        "{} directions tried, {} orientations kept, {} steps of the search",
        best.tried, best.candidates, best.steps
    ));
    let plan = Plan {
        format: Plan::FORMAT.to_owned(),
        version: Plan::VERSION,
        made_by: format!("trunnion {}", env!("CARGO_PKG_VERSION")),
        model: model.reference(),
        machine: machine.reference(),
        placement,
        parts: model.model.parts.iter().map(|p| PartRef { id: p.id, name: p.name.clone() }).collect(),
        slots: best.slots.clone(),
    };
    plan.check(&profile.kinematics(), model.model.parts.len())?;
    let objective = asked.goal.text.clone();
    let plain = (wish.plans > 1).then(|| {
        let workpiece = Workpiece::place(&model.model, &placement);
        three_axis(&workpiece, profile, Angle::from_deg(args.overhang))
    });
    Ok(Made { plan, plans, objective, plain, orient_seconds, seconds: start.elapsed().as_secs_f64() })
}

/// Where the model stands at first, and the directions to try there.
fn standing(
    model: &LoadedModel,
    machine: &LoadedProfile,
    asked: &Asked,
    options: &Options<'_>,
) -> Result<(Placement, Vec<Vec<Direction>>), Failure> {
    let base = match asked.placement {
        Some(given) => given,
        None => centred(&model.model, &machine.profile)?,
    };
    let workpiece = Workpiece::place(&model.model, &base);
    workpiece.check(&machine.profile)?;
    plannable(&workpiece)?;
    Ok((base, orientations(&workpiece, options)))
}

/// `--all`: every sequence, as it is found.
fn list(args: &Verb, model: &LoadedModel, machine: &LoadedProfile, console: &Console) -> Result<(), Failure> {
    let start = Instant::now();
    let asked = Asked::of(&args.plan, machine, model)?;
    let options = asked.options(&args.plan, 1);
    let (base, directions) = standing(model, machine, &asked, &options)?;
    let workpiece = Workpiece::place(&model.model, &base);
    let mut listed: Vec<Vec<Slot>> = Vec::new();
    let mut seen = 0usize;
    let complete = sequences(&workpiece, &machine.profile, &directions, &options, |slots| {
        seen += 1;
        if seen > args.limit {
            return false;
        }
        if console.json() {
            listed.push(slots);
        } else {
            console.result(&line(&slots));
        }
        true
    })?;
    let count = seen.min(args.limit);
    let seconds = start.elapsed().as_secs_f64();
    if console.json() {
        console.document(&json!({"sequences": listed, "count": count, "complete": complete, "seconds": seconds}));
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

impl Made {
    pub(super) fn best(&self) -> &Planned {
        &self.plans[0]
    }

    pub(super) fn document(&self) -> Value {
        let mut document = json!(self.plan);
        let best = self.best();
        let more = json!({
            "objective": self.objective,
            "value": best.value,
            "lower_bound": best.lower_bound,
            "gap": best.value - best.lower_bound,
            "sequence_size": best.sequence_size,
            "pose_changes": best.pose_changes,
            "seconds_print_estimate": best.seconds,
            "staircase": best.staircase,
            "within_slots": best.within_slots.iter().map(within).collect::<Vec<_>>(),
            "clearance_mm": best.clearance_mm,
            "evaluations": best.steps,
            "seconds": self.seconds,
        });
        if let (Some(map), Some(more)) = (document.as_object_mut(), more.as_object()) {
            map.extend(more.clone());
            if self.plans.len() > 1 {
                map.insert("alternatives".to_owned(), self.plans.iter().map(alternative).collect());
            }
            if let Some(plain) = &self.plain {
                let (seconds, support, staircase) = (plain.seconds, plain.support_mm3, plain.staircase);
                let row = json!({"seconds_print_estimate": seconds, "support_mm3": support, "staircase": staircase});
                map.insert("three_axis".to_owned(), row);
            }
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
        let best = self.best();
        for w in &best.within_slots {
            let (minutes, by_layer) = (w.seconds / 60.0, w.seconds_layer_by_layer / 60.0);
            let _ = writeln!(
                out,
                "slot {}, pose by pose: {} turns, {minutes:.1} min; layer by layer it would be {} turns, {by_layer:.0} min",
                w.slot, w.turns, w.turns_layer_by_layer
            );
        }
        let name = if self.objective == "bss" { "building sequence size" } else { &self.objective };
        let proof = if best.value <= best.lower_bound { "the least possible" } else { "not proved least" };
        let _ = writeln!(
            out,
            "{name} {} (at least {}: {proof}), {} pose changes, clearance {:.2} mm, {:.2} s",
            shown(best.value),
            shown(best.lower_bound),
            best.pose_changes,
            best.clearance_mm,
            self.seconds
        );
        out
    }

    /// The plans beside each other.
    fn comparison(&self) -> String {
        let mut out =
            format!("{:>4} {:>14} {:>6} {:>6} {:>6} {:>9}\n", "plan", self.objective, "slots", "bss", "poses", "time");
        for (i, p) in self.plans.iter().enumerate() {
            let (slots, minutes) = (p.slots.len(), p.seconds / 60.0);
            let value = shown(p.value);
            let (size, poses, staircase) = (p.sequence_size, p.pose_changes, p.staircase);
            let _ = writeln!(
                out,
                "{i:>8} {value:>14} {slots:>6} {size:>6} {poses:>6} {minutes:>5.0} min {:>8} mm3 {staircase:>10.4}",
                0
            );
        }
        if let Some(plain) = &self.plain {
            let (minutes, support, staircase) = (plain.seconds / 60.0, plain.support_mm3, plain.staircase);
            let _ = writeln!(
                out,
                "{:>8} {:>14} {:>6} {:>6} {:>6} {minutes:>5.0} min {support:>8.0} mm3 {staircase:>10.4}",
                "3 axes", "-", "-", "-", 0
            );
        }
        out
    }
}

fn within(w: &WithinSlot) -> Value {
    json!({
        "slot": w.slot,
        "chosen": "pose-by-pose",
        "turns": w.turns,
        "seconds": w.seconds,
        "turns_layer_by_layer": w.turns_layer_by_layer,
        "seconds_layer_by_layer": w.seconds_layer_by_layer,
    })
}

fn alternative(planned: &Planned) -> Value {
    json!({
        "slots": planned.slots,
        "value": planned.value,
        "sequence_size": planned.sequence_size,
        "pose_changes": planned.pose_changes,
        "seconds_print_estimate": planned.seconds,
        "staircase": planned.staircase,
        "clearance_mm": planned.clearance_mm,
    })
}

/// Whole numbers as such, others to six digits.
fn shown(value: f64) -> String {
    if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.6}") }
}
