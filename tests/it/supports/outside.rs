//! OR-tools and LEMON as witnesses for flows and exact costs: other programs' flows on the same arcs, written out one by one.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use trunnion::support::{COSTS, FlowLimits, FlowMethod, Graph, min_cost, plan};

use super::{random, scenes};
use crate::support::{folder, python, root, skip};

/// The graph with its limits, an arc a line, in this folder.
fn written(graph: &Graph, limits: (u16, Option<u16>), folder: &Path) -> PathBuf {
    let list = folder.join("arcs.txt");
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
    list
}

/// The units and the cost of the cheapest flow of as many as can be, by another program.
type Outsider<'a> = &'a dyn Fn(&Path) -> (u64, u64);

fn answer(command: &mut Command) -> (u64, u64) {
    let output = command.stderr(Stdio::inherit()).output().unwrap();
    assert!(output.status.success());
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    (answer["units"].as_u64().unwrap(), answer["cost"].as_u64().unwrap())
}

/// Thirty random scenes and two others, three limits each: as many units reach the ground as the other program says, and where all do,
/// at the same cost.
fn agrees_with(outsider: Outsider<'_>) {
    let folder = folder();
    let mut graphs: Vec<(String, Graph)> =
        (1..=30).map(|seed| (format!("random {seed}"), random::graph(&random::scene(seed)))).collect();
    graphs.push(("ring".to_owned(), scenes::leaning_ring().graph()));
    graphs.push(("balls".to_owned(), scenes::two_balls().graph()));
    let mut whole = 0;
    for (name, graph) in &graphs {
        for (arc, node) in [(1, None), (4, None), (2, Some(2))] {
            let (units, cost) = outsider(&written(graph, (arc, node), folder.path()));
            let all = units as usize == graph.red.len();
            let (flow, limits) = min_cost(graph, FlowLimits::new(arc, node), &mut |_| {});
            let pushed = plan(graph, FlowMethod::PushRelabel, arc, node, 1, &mut |_| {}).limits;
            for (method, limits) in [("min-cost", &limits), ("push-relabel", &pushed)] {
                let held = limits.raised_arcs.is_empty() && limits.raised_nodes.is_empty();
                assert_eq!(held, all, "{method}, {name}, {arc} {node:?}");
            }
            if all {
                whole += 1;
                assert_eq!(flow.tally(graph, arc, node).cost, cost, "{name}, {arc} {node:?}");
            }
        }
    }
    assert!(whole > 40, "{whole}");
}

#[test]
fn or_tools_has_the_same_flows_and_costs() {
    let Some(python) = python(&["python3", "/usr/bin/python3"], "ortools") else {
        return skip("no python3 with ortools: costs of supports have one witness less");
    };
    let script = root().join("benches/compare/support_ortools.py");
    agrees_with(&|arcs| answer(Command::new(&python).arg(&script).arg(arcs)));
}

#[test]
fn lemon_has_the_same_flows_and_costs() {
    let folder = folder();
    let (source, program) = (root().join("benches/compare/support_lemon.cpp"), folder.path().join("lemon"));
    let compiled = Command::new("g++").arg("-O2").arg("-o").arg(&program).arg(source).output();
    if !Path::new("/usr/include/lemon/preflow.h").exists() || compiled.is_err() {
        return skip("no g++ with LEMON (liblemon-dev): flows of supports have one witness less");
    }
    let compiled = compiled.unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    agrees_with(&|arcs| answer(Command::new(&program).arg(arcs)));
}
