//! Plans for people: slots and poses, several plans beside each other, and why there is none.

use std::fmt::Write;

use crate::gcode::round_to;
use crate::job::{Hindrance, NoPlan, PlanResult, TriedWay};
use crate::planning::{PartDroop, Print, TimeSlot};
use crate::spelling::{counted, part_named};
use crate::strategy::{Terms, WISH, Way};

/// `trunnion plan --all`: a sequence as `0 | 1 | 3,5 @ A70 C90; 7,8 @ A70 C-90`, behind how the model stands where that differs.
pub fn sequence(up: Option<[f64; 3]>, slots: &[TimeSlot]) -> String {
    let stands = up.map_or_else(String::new, |[x, y, z]| format!("up {x:.4},{y:.4},{z:.4}: "));
    let setup = |prints: &Vec<&Print>| {
        let parts: Vec<String> = prints.iter().map(part).collect();
        format!("{} @ {} {}", parts.join(","), prints[0].tilt_deg, prints[0].rotation_deg)
    };
    let slot = |slot: &TimeSlot| slot.setups().iter().map(setup).collect::<Vec<_>>().join("; ");
    stands + &slots.iter().map(slot).collect::<Vec<_>>().join(" | ")
}

/// A print by its part.
fn part(print: &&Print) -> String {
    format!("{}{}", print.part, if print.supports.is_some() { " (on supports)" } else { "" })
}

/// `trunnion plan`: slots, poses, and what the plan comes to.
pub fn planned(made: &PlanResult) -> String {
    let k = &made.plan.machine.profile.kinematics;
    let mut out = String::new();
    for slot in &made.plan.plan.slots {
        let _ = writeln!(out, "slot {}", slot.id);
        for setup in slot.setups() {
            let parts: Vec<String> = setup.iter().map(part).collect();
            let (a, c) = (setup[0].tilt_deg, setup[0].rotation_deg);
            let which = if parts.len() == 1 { "part" } else { "parts" };
            let _ = writeln!(out, "  {}{a} {}{c}: {which} {}", k.tilt.letter, k.rotation.letter, parts.join(", "));
        }
    }
    for droop in &made.droops {
        let PartDroop { part, area_mm2, droop_mm, at_mm } = droop;
        let [x, y, z] = at_mm.map(|v| round_to(v, 1) + 0.0);
        let _ = writeln!(
            out,
            "part {part} droops by up to {droop_mm:.1} mm over {area_mm2:.0} mm2, mostly near ({x}, {y}, {z}) mm (--finish fine allows no droop)"
        );
    }
    if let Some(said) = made.unsteady() {
        let _ = writeln!(out, "{said}");
    }
    let best = made.best();
    for w in &best.within_slots {
        let (minutes, by_layer) = (w.seconds / 60.0, w.seconds_layer_by_layer / 60.0);
        let _ = writeln!(
            out,
            "slot {}: printed pose by pose, {} and {minutes:.1} min; layer by layer, {} and {by_layer:.0} min",
            w.slot,
            counted(w.turns, "turn"),
            counted(w.turns_layer_by_layer, "turn")
        );
    }
    let name = if made.objective == "bss" { "building sequence size" } else { &made.objective };
    let proof = if best.value <= best.lower_bound { "proved minimal" } else { "not proved minimal" };
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

/// `trunnion prepare`: the ways that were tried, a line each; nothing where there was only one.
pub fn ways(tried: &[TriedWay]) -> String {
    let mut out = String::new();
    if tried.len() < 2 {
        return out;
    }
    let _ = writeln!(
        out,
        "{:<15} {:>9} {:>7} {:>8} {:>9} {:>9} {:>6} {:>5} {:>6}",
        "way", "price min", "print", "filament", "supports", "seams", "setups", "parts", "stands"
    );
    for TriedWay { way, chosen, terms, price_min, why_not, .. } in tried {
        let price = price_min.map_or("-".to_owned(), |min| format!("{min:.1}"));
        let _ = write!(out, "{:<15} {price:>9}", way.word());
        if let Some(Terms { minutes, grams, support_g, seam_mm2, setups, parts, stands, .. }) = terms {
            let stands = stands.map_or("-".to_owned(), |times| format!("{times:.1}x"));
            let _ = write!(
                out,
                " {minutes:>3.0} min {grams:>6.1} g {support_g:>7.1} g {seam_mm2:>5.0} mm2 {setups:>6} {parts:>5} {stands:>6}"
            );
        }
        let why_not = why_not.as_ref().map_or(String::new(), |why| format!(" not: {why}"));
        let _ = writeln!(out, "{}{why_not}", if *chosen { " taken" } else { "" });
    }
    let taken = tried.iter().find(|way| way.chosen);
    let costs_less = |way: &&TriedWay| {
        way.terms.is_some() && way.why_not.is_none() && taken.is_some_and(|taken| way.price_min < taken.price_min)
    };
    let cheaper: Vec<&str> = tried.iter().filter(costs_less).map(|way| way.way.word()).collect();
    if let (Some(taken), false) = (taken, cheaper.is_empty()) {
        let _ = writeln!(
            out,
            "{} is chosen although {} costs less, because another pose or a cut must save at least {:.0} %; to choose it, pass --way {}",
            taken.way.word(),
            cheaper.join(" or "),
            100.0 * (1.0 - WISH),
            cheaper.join(" or --way ")
        );
    }
    out
}

/// `trunnion plan --top`: the plans beside each other.
pub fn comparison(made: &PlanResult) -> String {
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
    let rows = made.three_axes.map(|both| [("3 axes", both.as_it_stands), ("turned", both.best)]);
    for (name, plain) in rows.into_iter().flatten() {
        let (minutes, support, staircase) = (plain.seconds / 60.0, plain.support_mm3, plain.staircase);
        let _ = writeln!(
            out,
            "{name:>8} {:>14} {:>6} {:>6} {:>6} {minutes:>5.0} min {support:>8.0} mm3 {staircase:>10.4}",
            "-", "-", "-", 0
        );
    }
    if let Some(both) = made.three_axes {
        let [x, y, z] = <[f64; 3]>::from(both.best.up).map(|v| (v * 1000.0).round() / 1000.0 + 0.0);
        let _ = writeln!(
            out,
            "3 axes: without tilting, as drawn, on supports; turned: the same with {x} {y} {z} up, the pose that orient recommends"
        );
    }
    out
}

/// Whole numbers as such, others to six digits.
fn shown(value: f64) -> String {
    if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.6}") }
}

/// Where the model was moved, if the axes do not reach it where it was; `None` where it stays.
pub fn moved(made: &PlanResult) -> Option<String> {
    let placement = &made.plan.plan.placement;
    let [x, y, _] = placement.origin_mm;
    made.moved.then(|| {
        format!("moved the model to X {x} Y {y} mm and turned it {} deg, so that the axes reach it", placement.turn_deg)
    })
}

/// What the search looked at.
pub fn searched(made: &PlanResult) -> String {
    let best = made.best();
    format!("{} directions tried, {} orientations kept, {} search steps", best.tried, best.candidates, best.steps)
}

/// Per part: how many orientations each thing stands against, with the nearest miss of each.
pub fn no_plan(no: &NoPlan) -> String {
    let mut out = String::new();
    let hindrances = no.hindrances();
    if no.reasons().1 && !hindrances.is_empty() {
        let _ = writeln!(out, "no plan, for these reasons together (removing any one of them would allow a plan):");
    }
    let mut last = None;
    for Hindrance { part, orientations, nearest } in hindrances {
        if last.replace(part) != Some(part) {
            let _ = writeln!(out, "  {}", part_named(part, &no.model.model.parts[part].name));
        }
        let [x, y, z] = nearest.up.map(|v| if v.abs() < 5e-4 { 0.0 } else { v });
        let by = &nearest.blocked_by;
        let what = match by.as_str() {
            "support" => "unsupported overhangs".to_owned(),
            "limits" => "the axis limits".to_owned(),
            by if by.parse::<usize>().is_ok() => format!("part {by}"),
            by => format!("the {by}"),
        };
        let (count, text) = (counted(orientations, "orientation"), &nearest.text);
        let _ = writeln!(out, "    blocked by {what}: {count}; nearest miss, with ({x:.3}, {y:.3}, {z:.3}) up: {text}");
    }
    let others = no.ways.iter().filter(|tried| tried.way != Way::AsDrawn);
    others.for_each(|tried| tried.why_not.iter().for_each(|why| _ = writeln!(out, "{}: {why}", tried.way.word())));
    let Some(remedies) = &no.remedies else { return out };
    if remedies.is_empty() {
        out.push_str(
            "none of the remedies tried helps: tolerance, bridges, tilt, height, head, nozzle, pedestal, margin, support, base, join\n",
        );
    } else {
        out.push_str("remedies (any one is enough; all except cuts and joints were checked by planning):\n");
        remedies.iter().for_each(|r| _ = writeln!(out, "  {}", r.text));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_a_cheaper_way_is_not_taken_the_table_says_why() {
        let way = |way, chosen, price_min| {
            let terms = Some(Terms::default());
            TriedWay { way, up: None, chosen, terms, price_min: Some(price_min), why_not: None }
        };
        let told = |cut_min: f64, turned_min: f64| {
            let all = [
                way(Way::Supports, true, 100.0),
                way(Way::Cut, false, cut_min),
                way(Way::TurnedSupports, false, turned_min),
                // Skipped, with a bound.
                TriedWay { terms: None, ..way(Way::Turned, false, 96.0) },
            ];
            ways(&all).lines().skip(5).map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(told(101.0, 120.0), Vec::<String>::new());
        let [line] = &told(99.0, 120.0)[..] else { panic!("one line") };
        assert!(line.contains("cut") && !line.contains("turned") && line.contains("5 %"), "{line}");
        let [line] = &told(99.0, 98.0)[..] else { panic!("one line") };
        assert!(line.contains("cut or turned-supports"), "{line}");
    }
}
