//! Supports: first what comes of each scene and method, then how long it takes.
//!
//! `RAYON_NUM_THREADS=1 cargo bench -p trunnion-benches --bench support` prints CPU times. With `TRUNNION_ARCS=FOLDER` the graphs are written there, one arc
//! a line, for `benches/compare/support_ortools.py`. The latest figures are in docs/explanation/measurements.md.

#[allow(dead_code)]
#[path = "../tests/it/supports/scenes.rs"]
mod scenes;

use std::fmt::Write as _;
use std::io::Write as _;
use std::sync::OnceLock;
use std::time::Instant;

use divan::Bencher;
use trunnion::support::{COSTS, FlowLimits, FlowMethod, Graph, PlannedFlow, min_cost, plan};

const NAMES: [&str; 4] = ["ring", "balls", "knot", "rings"];
/// Units on an arc.
const CAPACITY: u16 = 4;

fn graph(name: &str) -> &'static Graph {
    static GRAPHS: OnceLock<Vec<Graph>> = OnceLock::new();
    let made = [scenes::leaning_ring, scenes::two_balls, scenes::knot, scenes::many_rings];
    let graphs = GRAPHS.get_or_init(|| made.iter().map(|scene| scene().graph()).collect());
    &graphs[NAMES.iter().position(|known| *known == name).expect("a known name")]
}

fn main() {
    let mut said = String::new();
    for name in NAMES {
        let graph = graph(name);
        let _ = writeln!(said, "{name}: {:?}, {} unreachable", graph.count(), graph.unreachable.len());
        for (method, kind) in FlowMethod::NAMED {
            let began = Instant::now();
            let planned = planned(graph, kind);
            let tally = &planned.tally;
            let _ = writeln!(
                said,
                "  {method}: cost {} (at least {}), {} arcs (at least {}), length {:.0} steps, {} over capacity, {:.3} s",
                tally.cost,
                planned.lower_bound,
                tally.used_arcs(),
                planned.fewest_arcs,
                tally.length_mm(1.0),
                tally.over_capacity,
                began.elapsed().as_secs_f64()
            );
        }
        let began = Instant::now();
        let one = min_cost(graph, FlowLimits::new(1, None), &mut |_| {}).0.tally(graph, 1, None).cost;
        let _ = writeln!(said, "  min-cost, capacity 1: cost {one}, {:.3} s", began.elapsed().as_secs_f64());
        if let Some(folder) = std::env::var_os("TRUNNION_ARCS") {
            let path = std::path::Path::new(&folder).join(format!("{name}.txt"));
            std::fs::write(path, arcs(graph)).expect("a folder that can be written to");
        }
    }
    let _ = writeln!(said, "most memory: {}", memory());
    let _ = std::io::stdout().write_all(said.as_bytes());
    divan::main();
}

/// The graph, one arc a line.
fn arcs(graph: &Graph) -> String {
    let mut text = format!("{} {CAPACITY} 0\n", graph.squares());
    graph.red.iter().for_each(|red| _ = writeln!(text, "r {red}"));
    for node in (0..graph.squares()).filter(|&node| graph.is_node(node)) {
        if graph.is_ground(node) {
            let _ = writeln!(text, "g {node}");
        }
        for arc in graph.arcs(node) {
            let _ = writeln!(text, "a {node} {} {}", graph.head(node, arc), COSTS[arc]);
        }
    }
    text
}

/// The most that this process has held so far, where the system says.
fn memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.map_or_else(|| "unknown".to_owned(), |kilobytes| kilobytes.trim().to_owned())
}

fn planned(graph: &Graph, method: FlowMethod) -> PlannedFlow {
    plan(graph, method, CAPACITY, None, 1, &mut |_| {})
}

#[divan::bench(args = ["ring", "balls", "knot"], sample_count = 3, sample_size = 1)]
fn squares(bencher: Bencher<'_, '_>, name: &str) {
    let scene = match name {
        "ring" => scenes::leaning_ring(),
        "balls" => scenes::two_balls(),
        _ => scenes::knot(),
    };
    bencher.bench_local(|| scene.graph());
}

#[divan::bench(args = NAMES, sample_count = 3, sample_size = 1)]
fn push_relabel(bencher: Bencher<'_, '_>, name: &str) {
    bencher.bench_local(|| planned(graph(name), FlowMethod::PushRelabel));
}

#[divan::bench(args = NAMES, sample_count = 3, sample_size = 1)]
fn cheapest(bencher: Bencher<'_, '_>, name: &str) {
    bencher.bench_local(|| planned(graph(name), FlowMethod::MinCost));
}

#[divan::bench(args = NAMES, sample_count = 3, sample_size = 1)]
fn shortest_paths(bencher: Bencher<'_, '_>, name: &str) {
    bencher.bench_local(|| planned(graph(name), FlowMethod::ShortestPaths));
}

#[divan::bench(args = ["ring", "balls", "knot"], sample_count = 1, sample_size = 1)]
fn auto(bencher: Bencher<'_, '_>, name: &str) {
    bencher.bench_local(|| planned(graph(name), FlowMethod::Auto));
}
