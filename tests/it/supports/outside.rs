//! OR-tools as a witness for the exact costs: another program's flow on the same arcs, written out one by one.

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use trunnion::support::{COSTS, Graph, Limits, min_cost};

use super::{random, scenes};
use crate::support::{folder, python, root, skip};

/// The cost of the cheapest flow of every unit, and how many units there are.
pub(super) fn least_cost(python: &Path, graph: &Graph, limits: (u16, Option<u16>)) -> (u64, u64) {
    let folder = folder();
    let list = folder.path().join("arcs.txt");
    let mut text = std::io::BufWriter::new(std::fs::File::create(&list).unwrap());
    let node = limits.1.map_or(0, i64::from);
    writeln!(text, "{} {} {node}", graph.squares(), limits.0).unwrap();
    graph.red.iter().for_each(|red| writeln!(text, "r {red}").unwrap());
    for node in (0..graph.squares()).filter(|&node| graph.is_node(node)) {
        if graph.is_ground(node) {
            writeln!(text, "g {node}").unwrap();
        }
        for arc in graph.arcs(node) {
            writeln!(text, "a {node} {} {}", graph.head(node, arc), COSTS[arc]).unwrap();
        }
    }
    text.flush().unwrap();
    let script = root().join("benches/compare/support_ortools.py");
    let output = Command::new(python).arg(script).arg(&list).stderr(Stdio::inherit()).output().unwrap();
    assert!(output.status.success());
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    (answer["cost"].as_u64().unwrap(), answer["units"].as_u64().unwrap())
}

#[test]
fn or_tools_has_the_same_costs() {
    let Some(python) = python(&["python3", "/usr/bin/python3"], "ortools") else {
        return skip("no python3 with ortools: costs of supports have no witness but brute force");
    };
    let mut graphs: Vec<(String, Graph)> =
        (1..=30).map(|seed| (format!("random {seed}"), random::graph(&random::scene(seed)))).collect();
    graphs.push(("ring".to_owned(), scenes::leaning_ring().graph()));
    graphs.push(("balls".to_owned(), scenes::two_balls().graph()));
    let mut whole = 0;
    for (name, graph) in &graphs {
        for (arc, node) in [(1, None), (4, None), (2, Some(2))] {
            let (flow, limits) = min_cost(graph, Limits::new(arc, node), &mut |_| {});
            let (cost, units) = least_cost(&python, graph, (arc, node));
            let held = limits.raised_arcs.is_empty() && limits.raised_nodes.is_empty();
            assert_eq!(held, units as usize == graph.red.len(), "{name}, {arc} {node:?}");
            if held {
                whole += 1;
                assert_eq!(flow.tally(graph, arc, node).cost, cost, "{name}, {arc} {node:?}");
            }
        }
    }
    assert!(whole > 40, "{whole}");
}
