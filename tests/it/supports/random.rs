//! Random scenes: every method against the graph and the flows of `brute`.

use trunnion::geom::{SplitMix64, Vec3};
use trunnion::support::{FlowLimits, FlowMethod, Graph, Grid, PlannedFlow, min_cost, plan};

use super::brute::{Marks, flow};
use crate::support::seeds;

/// Scenes that crowd: a ceiling with holes over a floor with obstacles.
pub(super) fn scene(seed: u64) -> Marks {
    let mut numbers = SplitMix64::seeded(seed);
    let size = [3 + numbers.below(4), 3 + numbers.below(3), 4 + numbers.below(3)];
    let count = size.iter().product();
    let (mut black, mut wants) = (vec![false; count], vec![false; count]);
    let dense = 0.05 + 0.35 * numbers.unit();
    for z in 0..size[2] {
        for i in z * size[0] * size[1]..(z + 1) * size[0] * size[1] {
            black[i] = numbers.unit() < if z + 2 > size[2] { 0.8 } else { dense };
            wants[i] = black[i] && numbers.unit() < 0.8;
        }
    }
    Marks { size, black, wants }
}

pub(super) fn graph(marks: &Marks) -> Graph {
    let grid = Grid { origin: Vec3::zeros(), step_mm: 1.0, size: marks.size };
    let both: Vec<(bool, bool)> = marks.black.iter().copied().zip(marks.wants.iter().copied()).collect();
    Graph::of_marks(grid, &both)
}

const LIMITS: [(u16, Option<u16>); 5] = [(1, None), (2, None), (4, None), (2, Some(2)), (4, Some(1))];

#[test]
fn graphs_and_costs_are_those_of_brute_force() {
    let (mut held_back, mut crowded) = (0, 0);
    for seed in seeds(30, 1000) {
        let marks = scene(seed);
        let (ours, theirs) = (graph(&marks), marks.explicit());
        let count = ours.count();
        assert_eq!((count.nodes, count.arcs), (theirs.nodes.len(), theirs.arcs.len()), "scene {seed}");
        assert_eq!((count.red, count.green), (theirs.red.len(), theirs.green.len()), "scene {seed}");
        assert_eq!(ours.unreachable.len(), theirs.unreachable, "scene {seed}");
        for (arc, node) in LIMITS {
            let (units, cost) = flow(&theirs, i64::from(arc), node.map(i64::from));
            let is_whole = units == theirs.red.len();
            held_back += usize::from(!is_whole);
            crowded += usize::from(is_whole && flow(&theirs, 1000, None).1 < cost);
            for (name, method) in FlowMethod::NAMED {
                let planned = plan(&ours, method, arc, node, 1, &mut |_| {});
                let what = format!("{name} of scene {seed}, {arc} {node:?}");
                agree(&ours, &planned, is_whole.then_some(cost as u64), method, &what);
            }
        }
    }
    // Scenes in which nothing is ever full would prove nothing.
    assert!(held_back > 10 && crowded > 10, "{held_back} held back, {crowded} crowded");
}

/// What holds of every method where the largest flow within the limits is whole (its least cost given) or not.
fn agree(graph: &Graph, planned: &PlannedFlow, least: Option<u64>, method: FlowMethod, what: &str) {
    assert_eq!(planned.flow.unbalanced(graph), None, "{what}");
    assert!(planned.tally.cost >= planned.lower_bound, "{what}");
    assert!(planned.tally.used_arcs() >= planned.fewest_arcs, "{what}");
    assert_eq!(planned.tally.over_capacity == 0, least.is_some(), "{what}: {:?}", planned.tally);
    let Some(least) = least else { return };
    assert!(planned.limits.raised_arcs.is_empty() && planned.limits.raised_nodes.is_empty(), "{what}");
    match method {
        FlowMethod::MinCost => assert_eq!(planned.tally.cost, least, "{what}"),
        FlowMethod::Auto => assert_eq!(planned.lower_bound, least, "{what}"),
        _ => assert!(planned.tally.cost >= least, "{what}"),
    }
}

/// Raised limits are enough for all and no more than that: the flow fills one of what was raised in each case.
#[test]
fn limits_are_raised_only_where_something_is_held_back() {
    let mut raised = 0;
    for seed in seeds(30, 1000) {
        let ours = graph(&scene(seed));
        let (flow, limits) = min_cost(&ours, FlowLimits::new(1, None), &mut |_| {});
        raised += limits.raised_arcs.len();
        let over = flow.tally(&ours, 1, None).over_capacity;
        assert!(
            over <= limits.raised_arcs.len(),
            "scene {seed}: {over} arcs over, {} raised",
            limits.raised_arcs.len()
        );
        for (&(node, arc), &most) in &limits.raised_arcs {
            assert!(most > 1 && flow.on[node as usize][arc as usize] <= most, "scene {seed}");
        }
    }
    assert!(raised > 5, "{raised}");
}
