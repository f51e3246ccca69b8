//! Struts against their definition: followed from the flow alone, on scenes of all kinds and for all limits.

use std::collections::BTreeSet;

use trunnion::support::{ARCS, Flow, FlowMethod, Graph, braced, longest_free_mm, plan};

use super::{random, scenes};

/// All arcs in use: from, arc, to.
fn arcs(graph: &Graph, flow: &Flow) -> Vec<(usize, usize, usize)> {
    let of = |from: usize| {
        (0..ARCS).filter(move |&arc| flow.on[from][arc] > 0).map(move |arc| (from, arc, graph.head(from, arc)))
    };
    (0..graph.squares()).flat_map(of).collect()
}

/// Over how many levels a column stands free, followed upward from every square, one after the other.
fn longest_free(graph: &Graph, flow: &Flow) -> usize {
    let all = arcs(graph, flow);
    let used: BTreeSet<usize> = all.iter().flat_map(|(from, _, to)| [*from, *to]).collect();
    let free = |node: usize| {
        let [x, y, z] = graph.grid.cube(node);
        let beside = |other: &usize| {
            let [u, v, w] = graph.grid.cube(*other);
            w == z && *other != node && u.abs_diff(x) <= 1 && v.abs_diff(y) <= 1
        };
        z > 0 && !used.iter().any(beside)
    };
    let mut open: Vec<usize> = used.iter().copied().filter(|node| free(*node)).collect();
    let mut levels = 0;
    while !open.is_empty() {
        levels += 1;
        let above =
            |node: &usize| all.iter().filter(|(_, _, to)| to == node).map(|(from, ..)| *from).collect::<Vec<_>>();
        let next: BTreeSet<usize> = open.iter().flat_map(above).filter(|node| free(*node)).collect();
        open = next.into_iter().collect();
    }
    levels
}

#[test]
fn no_column_stands_free_over_more_than_is_asked_for() {
    let mut graphs: Vec<(String, Graph)> =
        (1..=12).map(|seed| (format!("random {seed}"), random::graph(&random::scene(seed)))).collect();
    graphs.push(("ring".to_owned(), scenes::leaning_ring().graph()));
    graphs.push(("balls".to_owned(), scenes::two_balls().graph()));
    let (mut tied, mut whole) = (0, 0);
    for (name, graph) in &graphs {
        for method in [FlowMethod::Auto, FlowMethod::MinCost] {
            let flow = plan(graph, method, 4, None, 1, &mut |_| {}).flow;
            let step = graph.grid.step_mm;
            assert_eq!(longest_free_mm(graph, &flow), step * longest_free(graph, &flow) as f64, "{name}");
            let most = longest_free(graph, &flow);
            for levels in [2, 3, 5, 8, most.max(2)] {
                let stiff = braced(graph, &flow, levels as f64 * step);
                let (before, after) = (arcs(graph, &flow), arcs(graph, &stiff.flow));
                let what = format!("{name}, {method:?}, {levels} of {most}");
                assert_eq!(after.len(), before.len() + stiff.struts, "{what}");
                assert!(before.iter().all(|one| after.contains(one)), "{what}: what holds stays");
                assert_eq!(
                    stiff.struts == 0,
                    most <= levels || stiff.unbraced > 0 && after.len() == before.len(),
                    "{what}"
                );
                // Each strut arc is the graph's, and goes on below: nothing of it ends in the air.
                let tails: BTreeSet<usize> = after.iter().map(|(from, ..)| *from).collect();
                for (from, arc, to) in &after {
                    assert!(graph.arcs(*from).any(|there| there == *arc), "{what}");
                    assert!(graph.is_ground(*to) || tails.contains(to), "{what}");
                }
                if stiff.unbraced == 0 {
                    whole += 1;
                    assert!(longest_free(graph, &stiff.flow) <= levels, "{what}");
                } else {
                    assert!(longest_free(graph, &stiff.flow) > levels, "{what}");
                }
                tied += stiff.struts;
            }
        }
    }
    assert!(tied > 100 && whole > 80, "{tied} arcs of struts, {whole} whole");
}
