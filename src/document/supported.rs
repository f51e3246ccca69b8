//! Supports: the grid, the flow, what it holds and what not.

use serde_json::{Value, json};

use crate::job::SupportResult;
use crate::support::Bare;

/// `trunnion support`. Costs count 1 for a straight arc and 2 for an oblique one; `over_capacity` counts arcs and nodes.
pub fn supported(done: &SupportResult) -> Value {
    let SupportResult { graph, count, planned, built, cover, .. } = done;
    let (tally, step) = (&planned.tally, graph.grid.step_mm);
    let patch = |p: &Bare| json!({"squares": p.squares, "area_mm2": p.area_mm2, "at_mm": p.at.as_slice()});
    json!({
        "grid": graph.grid.size, "step_mm": step, "origin_mm": graph.grid.origin.as_slice(),
        "nodes": count.nodes, "arcs": count.arcs, "red": count.red, "green": count.green,
        "unreachable": graph.unreachable.len(),
        "unreachable_area_mm2": done.bare.iter().fold(0.0, |sum, p| sum + p.area_mm2),
        "unreachable_patches": done.bare.iter().map(patch).collect::<Vec<_>>(),
        "method": done.method, "cost": tally.cost, "lower_bound": planned.lower_bound,
        "used_arcs": tally.used_arcs(), "used_arcs_lower_bound": planned.fewest_arcs,
        "straight_arcs": tally.straight, "oblique_arcs": tally.oblique,
        "length_mm": tally.length_mm(step), "over_capacity": tally.over_capacity, "most_on_an_arc": tally.most,
        "volume_mm3": built.volume_mm3, "covered_share": cover.share(), "overhang_mm2": cover.area_mm2,
        "contact_mm2": built.contact_mm2, "plate_mm2": built.plate_mm2, "longest_free_mm": done.longest_free_mm,
        "struts": done.struts, "unbraced": done.unbraced, "roof_bars": built.bars,
        "seconds_plan": done.seconds_plan, "seconds": done.seconds,
    })
}
