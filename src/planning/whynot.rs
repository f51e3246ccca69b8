//! Why there is no plan: a set of reasons none of which can be left out.
//!
//! Every orientation that was tried comes back with all that stands against it, and what stands against it becomes a
//! **constraint** that can be lifted: "part 7 must be supported", "part 7 must stay clear of part 3", "the tilt of part 7
//! must be within reach". The set of all constraints is infeasible; one after the other is lifted, and stays lifted where the
//! rest is infeasible still (the *deletion filter* for irreducible infeasible subsystems, J. W. Chinneck, *Feasibility and
//! Infeasibility in Optimization*, 2008, section 6.3). What remains is irreducible: lift any one of it and there is a
//! plan. Each answer is the complete search's; where its budget ends before, the constraint stays and the set is not
//! called least.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::fmt::Write;

use super::candidates::{Barrier, Candidate, PrintWay, Setups, Told, in_order};
use super::infeasible::{Infeasible, Reason};
use super::options::{Options, Priority};
use super::part_set::PartSet;
use super::sequence::{End, Problem, enumerate};
use super::site::{Site, set_of};
use super::support::Needs;
use super::workpiece::Workpiece;
use crate::geom::Vec3;
use crate::orient::Direction;
use crate::profile::Profile;
use crate::spelling::part_named;

/// Something that could be lifted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Constraint {
    /// What the machine or the support has against a part at any orientation.
    Own(usize, Barrier),
    /// The head, printing the first, must stay clear of the second.
    Past(usize, usize),
}

impl Constraint {
    fn part(self) -> usize {
        match self {
            Self::Own(part, _) | Self::Past(part, _) => part,
        }
    }
}

/// Steps of one question, and of all of them together: a second or two.
const STEPS: u64 = 200_000;
const ALL_STEPS: u64 = 5_000_000;
/// Most ways of a part that are looked at.
const MOST_WAYS: usize = 64;

/// Everything that stands against everything.
struct Case<'a> {
    ways: Vec<Vec<PrintWay>>,
    candidates: Vec<Vec<Candidate>>,
    blocked: Vec<Vec<PartSet>>,
    site: &'a Site<'a>,
    on_table: PartSet,
    options: &'a Options<'a>,
    /// Steps that are left for all questions.
    steps: Cell<u64>,
}

/// The reasons why `workpiece` cannot be printed where it stands.
pub(super) fn explain(
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    directions: &[Vec<Direction>],
    options: &Options<'_>,
) -> Infeasible {
    let mut setups = Setups::new(workpiece, profile, options);
    let ways: Vec<Vec<PrintWay>> =
        directions.iter().enumerate().map(|(p, tried)| nearest_misses(&setups, p, tried)).collect();
    if let Some(part) = ways.iter().position(Vec::is_empty) {
        let part = part_named(part, &workpiece.model.parts[part].name);
        let summary = format!("{part} has no candidate orientation; try another --method or a larger --orient-budget");
        return Infeasible::NoPlan { summary, reasons: Vec::new(), least: true };
    }
    let mut candidates: Vec<Vec<Candidate>> = Vec::new();
    for of_part in &ways {
        let one = |way: &PrintWay| {
            let setup = setups.setup(way.up, way.pose);
            Candidate { up: way.up, pose: way.pose, setup, value: way.value, needs: way.needs.clone() }
        };
        candidates.push(of_part.iter().map(one).collect());
    }
    in_order(&mut candidates, options);
    let site = Site::of(&setups, options.margin_mm);
    let blocked = site.blocked(&candidates);
    let parts = ways.len();
    let on_table = set_of(parts, workpiece.model.in_place());
    let case = Case { ways, candidates, blocked, site: &site, on_table, options, steps: Cell::new(ALL_STEPS) };
    case.explain(workpiece)
}

/// The ways of a part with all objections, those with the fewest first.
fn nearest_misses(setups: &Setups<'_>, part: usize, tried: &[Direction]) -> Vec<PrintWay> {
    let mut ways = setups.ways(part, tried, Told::All);
    let everyone = set_of(setups.workpiece.parts.len(), 0..setups.workpiece.parts.len());
    let lost = |way: &PrintWay| (way.objections.len(), way.needs.rank(&everyone));
    ways.sort_by(|a, b| {
        let ((count, (rough, area)), (other_count, (other_rough, other_area))) = (lost(a), lost(b));
        count.cmp(&other_count).then(rough.cmp(&other_rough)).then(area.total_cmp(&other_area))
    });
    ways.truncate(MOST_WAYS);
    ways
}

impl Case<'_> {
    fn explain(&self, workpiece: &Workpiece<'_>) -> Infeasible {
        let all = self.constraints();
        let (stuck, mut decided) = self.stuck(&all);
        // What concerns the parts that got stuck is asked last, and so is likelier to stay.
        let mut order: Vec<Constraint> = all.iter().copied().collect();
        order.sort_by_key(|c| (stuck.has(c.part()), *c));
        let mut kept = all;
        self.lift_by_part(&order, &mut kept, &mut decided);
        let left: Vec<Constraint> = order.into_iter().filter(|c| kept.contains(c)).collect();
        for constraint in left {
            self.lift(&[constraint], &mut kept, &mut decided);
        }
        let least = decided;
        let mut reasons = self.reasons(&kept);
        if kept.is_empty() {
            reasons.extend(self.stranded(workpiece));
        }
        let upright = |part: usize| matches!(&self.ways[part][..], [way] if (way.up.unit() - Vec3::z()).norm() < 1e-9);
        let mut summary = summary(workpiece, &kept, &reasons, upright);
        if let (true, Some(reason)) = (kept.is_empty(), reasons.first()) {
            let _ = write!(summary, ": part {}: {}", reason.part, reason.text);
        }
        Infeasible::NoPlan { summary, reasons, least }
    }

    /// The first part that the demanded order leaves with nothing to begin on: neither the table nor a part that it touches.
    fn stranded(&self, workpiece: &Workpiece<'_>) -> Option<Reason> {
        let parts = self.ways.len();
        let mut reached = PartSet::new(parts);
        let begins = |part: usize, reached: &PartSet| {
            let before = self.options.before(part);
            let stands = self.on_table.has(part) || self.site.touching[part].meets(reached);
            stands && before.into_iter().all(|one| reached.has(one))
        };
        while let Some(next) = (0..parts).find(|&part| !reached.has(part) && begins(part, &reached)) {
            reached.insert(next);
        }
        let part = self.options.order.iter().flatten().copied().find(|&part| !reached.has(part))?;
        let way = self.ways[part].first()?;
        let touched: Vec<String> =
            self.site.touching[part].iter().map(|one| part_named(one, &workpiece.model.parts[one].name)).collect();
        let text = format!("nothing that it stands on is printed before it; print {} first", touched.join(" or "));
        let (up, blocked_by) = ((*way.up.unit()).into(), "support".to_owned());
        Some(Reason { part, up, blocked_by, depth_mm: 0.0, text, hangs: None, pose: way.pose, tip: None })
    }

    fn constraints(&self) -> BTreeSet<Constraint> {
        let mut all = BTreeSet::new();
        for (part, ways) in self.ways.iter().enumerate() {
            let own = ways.iter().flat_map(|w| &w.objections).map(|o| Constraint::Own(part, o.against));
            all.extend(own);
            // What can be carried by others only is a question of the order, and can be lifted too.
            all.insert(Constraint::Own(part, Barrier::Support));
            all.extend(self.blocked[part].iter().flat_map(PartSet::iter).map(|q| Constraint::Past(part, q)));
        }
        all
    }

    /// Whole parts first: most have nothing to do with it.
    fn lift_by_part(&self, order: &[Constraint], kept: &mut BTreeSet<Constraint>, decided: &mut bool) {
        let mut parts: Vec<usize> = order.iter().map(|c| c.part()).collect();
        parts.dedup();
        for part in parts {
            let of_part: Vec<Constraint> = order.iter().copied().filter(|c| c.part() == part).collect();
            self.lift(&of_part, kept, decided);
        }
    }

    /// Lifts `these` for good if there is no plan without them either.
    fn lift(&self, these: &[Constraint], kept: &mut BTreeSet<Constraint>, decided: &mut bool) {
        let without: BTreeSet<Constraint> = kept.iter().copied().filter(|c| !these.contains(c)).collect();
        match self.feasible(&without) {
            End::Exhausted => *kept = without,
            End::Stopped => {}
            End::Budget => *decided = false,
        }
    }

    fn stuck(&self, kept: &BTreeSet<Constraint>) -> (PartSet, bool) {
        let (end, farthest) = self.search(kept);
        let parts = self.ways.len();
        (set_of(parts, (0..parts).filter(|&p| !farthest.has(p))), end == End::Exhausted)
    }

    /// [`End::Stopped`] where there is a plan under `kept`.
    fn feasible(&self, kept: &BTreeSet<Constraint>) -> End {
        self.search(kept).0
    }

    fn search(&self, kept: &BTreeSet<Constraint>) -> (End, PartSet) {
        let parts = self.ways.len();
        if self.steps.get() == 0 {
            return (End::Budget, PartSet::new(parts));
        }
        let mut candidates: Vec<Vec<Candidate>> = Vec::new();
        let mut blocked: Vec<Vec<PartSet>> = Vec::new();
        for part in 0..parts {
            let supported = !kept.contains(&Constraint::Own(part, Barrier::Support));
            let free = |k: &usize| {
                let mut against = self.ways[part][*k].objections.iter().map(|o| o.against);
                !against.any(|a| kept.contains(&Constraint::Own(part, a)))
            };
            let ways: Vec<usize> = (0..self.ways[part].len()).filter(free).collect();
            if ways.is_empty() {
                return (End::Exhausted, set_of(parts, (0..parts).filter(|&p| p != part)));
            }
            let candidate = |&k: &usize| {
                let known = &self.candidates[part][k];
                // What is demanded is not lifted: what stands against it is looked for.
                let needs =
                    if supported { Needs::none().behind(self.options.before(part)) } else { known.needs.clone() };
                Candidate { needs, ..known.clone() }
            };
            candidates.push(ways.iter().map(candidate).collect());
            let set = |&k: &usize| {
                let in_force = |q: &usize| kept.contains(&Constraint::Past(part, *q));
                set_of(parts, self.blocked[part][k].iter().filter(in_force))
            };
            blocked.push(ways.iter().map(set).collect());
        }
        let problem = Problem {
            candidates: &candidates,
            blocked: &blocked,
            touching: &self.site.touching,
            on_table: &self.on_table,
            table_first: self.options.table_first(),
            priority: match self.options.priority {
                Priority::OnlySingle => Priority::OnlySingle,
                _ => Priority::Together,
            },
        };
        let outcome = enumerate(&problem, STEPS.min(self.steps.get()), |_| false);
        // Handing the parts over costs steps too, or a hundred thousand trivial questions would be free.
        let cost = outcome.steps + (parts * parts) as u64;
        self.steps.set(self.steps.get().saturating_sub(cost));
        (outcome.end, outcome.farthest)
    }

    /// What each kept constraint says of each orientation of its part.
    fn reasons(&self, kept: &BTreeSet<Constraint>) -> Vec<Reason> {
        let mut reasons = Vec::new();
        let parts: BTreeSet<usize> = kept.iter().map(|c| c.part()).collect();
        for part in parts {
            let ways = self.ways[part].iter().enumerate();
            let mut of_ways: Vec<Vec<Reason>> = ways.map(|(k, way)| self.reason(part, k, way, kept)).collect();
            // The ways with the least against them come first.
            of_ways.sort_by_key(Vec::len);
            reasons.extend(of_ways.into_iter().flatten());
        }
        reasons
    }

    /// Why `part` cannot be printed in its way `k`: every kept constraint that it offends, or the support it waits for.
    fn reason(&self, part: usize, k: usize, way: &PrintWay, kept: &BTreeSet<Constraint>) -> Vec<Reason> {
        let mut reasons = Vec::new();
        let reason = |blocked_by: &str, (text, depth_mm): (String, f64), tip: Option<Vec3>| Reason {
            part,
            up: (*way.up.unit()).into(),
            blocked_by: blocked_by.to_owned(),
            depth_mm,
            text,
            hangs: if blocked_by == "support" { way.hangs.clone() } else { None },
            pose: way.pose,
            tip: tip.map(Into::into),
        };
        let setup = self.candidates[part][k].setup;
        for objection in &way.objections {
            if kept.contains(&Constraint::Own(part, objection.against)) {
                let (blocked_by, tip) = match objection.against {
                    Barrier::Support => ("support", None),
                    Barrier::Reach | Barrier::Limits => ("limits", None),
                    Barrier::Table => ("table", self.site.strikes(part, None, setup)),
                    Barrier::Frame => ("frame", None),
                };
                reasons.push(reason(blocked_by, (objection.text.clone(), objection.depth_mm), tip));
            }
        }
        for other in self.blocked[part][k].iter().filter(|&q| kept.contains(&Constraint::Past(part, q))) {
            let tip = self.site.strikes(part, Some(other), setup);
            reasons.push(reason(&other.to_string(), self.site.intrusion(part, other, setup), tip));
        }
        let carriers = way.needs.carriers();
        if reasons.is_empty() && kept.contains(&Constraint::Own(part, Barrier::Support)) && !carriers.is_empty() {
            let names: Vec<String> = carriers.iter().map(ToString::to_string).collect();
            let text = match &names[..] {
                [one] => format!("it would be in mid-air until part {one} is printed"),
                _ => format!("it would be in mid-air until parts {} are printed", names.join(", ")),
            };
            reasons.push(reason("support", (text, 0.0), None));
        }
        reasons
    }
}

/// One sentence: which parts, and the nearest miss of each.
fn summary(
    workpiece: &Workpiece<'_>,
    kept: &BTreeSet<Constraint>,
    reasons: &[Reason],
    upright: impl Fn(usize) -> bool,
) -> String {
    let parts: BTreeSet<usize> = kept.iter().map(|c| c.part()).collect();
    let named = |part: &usize| part_named(*part, &workpiece.model.parts[*part].name);
    let mut text = match parts.len() {
        0 => "no print order works for all parts".to_owned(),
        1 => {
            // No other direction was asked for.
            let asked =
                if parts.iter().all(|part| upright(*part)) { "as drawn" } else { "in any orientation that was tried" };
            format!("{} cannot be printed {asked}", parts.iter().map(named).collect::<String>())
        }
        _ => format!("no order prints {}", parts.iter().map(named).collect::<Vec<_>>().join(" and ")),
    };
    for part in parts.iter().take(3) {
        // The ways with the least against them come first. A support reason names no way out; what the machine refuses
        // although the part would stand does.
        let of_part = || reasons.iter().filter(|r| r.part == *part);
        let hanging = of_part().filter_map(|r| Some((r, r.hangs.as_ref()?.area_mm2)));
        let least = hanging.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|_| workpiece.parts.len() == 1);
        if let Some((reason, _)) = least {
            // One solid hangs somewhere whatever the machine: where that is least says what to change, or where to cut.
            let [x, y, z] = reason.up.map(|v| if v.abs() < 5e-4 { 0.0 } else { v });
            let with = if upright(*part) { String::new() } else { format!("with ({x:.3}, {y:.3}, {z:.3}) up ") };
            let _ = write!(text, ": {with}{}", reason.text);
            continue;
        }
        if let Some(reason) = of_part().find(|r| r.blocked_by != "support").or_else(|| of_part().next()) {
            let _ = write!(text, "{} part {part}: {}", if text.contains(':') { ";" } else { ":" }, reason.text);
        }
    }
    text
}
