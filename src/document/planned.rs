//! Plans, and why there is none.

use serde_json::{Value, json};

use crate::job::{Listed, NoPlan, NoWay, PlanResult, Refused, TriedWay};
use crate::planning::{PartDroop, Planned, Reason, ThreeAxis, TimeSlot};
use crate::strategy::{Terms, Way};

/// `trunnion plan`: the plan file's own keys, with what the search found out about it.
pub fn planned(made: &PlanResult) -> Value {
    let mut document = json!(made.plan.plan);
    let best = made.best();
    let mut more = figures(best);
    more["objective"] = made.objective.as_str().into();
    more["lower_bound"] = best.lower_bound.into();
    more["gap"] = (best.value - best.lower_bound).into();
    more["part_seconds"] = json!(best.part_seconds);
    more["within_slots"] = json!(best.within_slots);
    more["evaluations"] = best.steps.into();
    more["seconds"] = made.seconds.into();
    let droop =
        |d: &PartDroop| json!({"part": d.part, "area_mm2": d.area_mm2, "droop_mm": d.droop_mm, "at_mm": d.at_mm});
    more["ways"] = ways(&made.ways);
    more["captive"] = json!(made.plan.model.model.captive);
    more["droops"] = made.droops.iter().map(droop).collect();
    more["standing"] = made.standing.as_ref().map_or(Value::Null, |one| {
        json!({
            "part": one.part, "slot": one.slot, "tilt_deg": one.tilt.deg(), "factor": finite(one.held.factor),
            "pushed_factor": finite(one.held.pushed),
        })
    });
    if let (Some(map), Some(more)) = (document.as_object_mut(), more.as_object()) {
        map.extend(more.clone());
        if made.plans.len() > 1 {
            map.insert("alternatives".to_owned(), made.plans.iter().map(alternative).collect());
        }
        if let Some(arranged) = &made.arranged {
            map.insert("arranged".to_owned(), json!({"file": arranged.file, "changes": arranged.changes}));
        }
        if let Some(both) = &made.three_axes {
            let row = |one: &ThreeAxis| {
                json!({
                    "up": <[f64; 3]>::from(one.up), "seconds_print_estimate": one.seconds, "support_mm3": one.support_mm3,
                    "staircase": one.staircase,
                })
            };
            let mut three_axis = row(&both.as_it_stands);
            three_axis["best_pose"] = row(&both.best);
            map.insert("three_axis".to_owned(), three_axis);
        }
    }
    document
}

fn words(why: Option<&Refused>) -> Option<String> {
    why.map(ToString::to_string)
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn alternative(planned: &Planned) -> Value {
    let mut document = figures(planned);
    document["slots"] = json!(planned.slots);
    document
}

fn figures(planned: &Planned) -> Value {
    json!({
        "value": planned.value, "sequence_size": planned.sequence_size, "pose_changes": planned.pose_changes,
        "seconds_print_estimate": planned.seconds, "staircase": planned.staircase, "clearance_mm": planned.clearance_mm,
    })
}

/// The ways that were tried for a model, the one that was taken first.
pub(super) fn ways(tried: &[TriedWay]) -> Value {
    let row = |tried: &TriedWay| {
        let terms = tried.terms.as_ref();
        let number = |of: fn(&Terms) -> f64| terms.map(of);
        json!({
            "way": tried.way.word(), "up": tried.up, "chosen": tried.chosen, "minutes": number(|t| t.minutes), "grams": number(|t| t.grams),
            "support_g": number(|t| t.support_g), "contact_mm2": number(|t| t.contact_mm2), "seam_mm2": number(|t| t.seam_mm2),
            "setups": terms.map(|t| t.setups), "parts": terms.map(|t| t.parts), "droop_mm2": number(|t| t.droop_mm2),
            "droop_mm3": number(|t| t.droop_mm3), "stands": terms.and_then(|t| t.stands), "steps_min": number(|t| t.steps_min), "risk_min": number(|t| t.risk_min),
            "price_min": tried.price_min, "why_not": words(tried.why_not.as_ref()),
            "code": tried.why_not.as_ref().map(Refused::code),
        })
    };
    let mut order: Vec<&TriedWay> = tried.iter().collect();
    order.sort_by(|a, b| {
        let price = |one: &TriedWay| one.price_min.unwrap_or(f64::INFINITY);
        b.chosen.cmp(&a.chosen).then(price(a).total_cmp(&price(b)))
    });
    order.into_iter().map(row).collect()
}

/// `trunnion plan --all`: the sequences, and whether they are all; with `--up any` the direction of the file that is up in each.
pub fn sequences(listed: &[Vec<TimeSlot>], ups: &[[f64; 3]], done: &Listed) -> Value {
    let mut document =
        json!({"sequences": listed, "count": done.count, "complete": done.complete, "seconds": done.seconds});
    if !ups.is_empty() {
        document["ups"] = json!(ups);
    }
    document
}

/// No way of those that were asked for: the sentence, and all that were tried.
pub fn no_way(no: &NoWay) -> Value {
    json!({"error": no.to_string(), "exit": 1, "code": "strategy/no-way", "way": no.only.map(Way::word), "ways": ways(&no.ways)})
}

/// No plan: reasons, whether each is needed, checked remedies.
pub fn no_plan(no: &NoPlan) -> Value {
    let (reasons, least) = no.reasons();
    let reason = |r: &Reason| {
        let hangs = r.hangs.as_ref().map(|h| json!({"area_mm2": h.area_mm2, "at_mm": h.at_mm, "cause": h.cause}));
        json!({
            "part": r.part, "orientation": r.up, "blocked_by": r.blocked_by, "depth_mm": r.depth_mm, "text": r.text,
            "hangs": hangs,
        })
    };
    json!({
        "feasible": false,
        "code": <&str>::from(&no.infeasible),
        "summary": no.infeasible.to_string(),
        "reasons": reasons.iter().map(reason).collect::<Vec<_>>(),
        "least": least,
        "cut": words(no.cut.as_ref()),
        "supports": words(no.held.as_ref()),
        "ways": ways(&no.ways),
        "remedies": no.remedies.as_deref().unwrap_or_default(),
    })
}
