//! Supports as a flow: the table of costs, figures 3.1 and 1, the tables of graphs and of times, figure 4.1.

use std::time::Instant;

use trunnion::geom::{Angle, Slot, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::overhang::Keels;
use trunnion::support::{
    Around, Build, Ceiling, Clear, Clearance, Cuts, Flow, FlowLimits, Graph, Laying, PathDrawing, Structure,
    SupportLayer, build, lines, min_cost, push_relabel, shared_price, sheets, shortest_paths,
};

use super::super::item::{Item, Row};
use super::super::scene::{AMBER, BLUE, GREY, frame, sheet, solid};
use super::super::sources::Run;

#[allow(dead_code, clippy::duplicate_mod, reason = "the scenes of the tests, of which some are for them alone")]
#[path = "../../../tests/it/supports/scenes.rs"]
mod scenes;

use scenes::Scene;

/// As the thesis proposes it: four units on an arc cost little more than one.
const CAPACITY: u16 = 4;

/// The cost of one unit more on an arc that carries n.
pub(super) fn price() -> Item {
    let printed = [1, 0, 0, 0, 1, 2, 3, 4];
    let row = |(n, cost): (usize, &i32)| {
        Row::absolute(format!("g({n})"), f64::from(*cost), f64::from(shared_price(n as u16)), 0.0, "")
    };
    Item::table("of g", "Cost g(n) of one unit more on an arc that carries n (section 3.4, unnumbered)")
        .rows(printed.iter().enumerate().map(row))
}

/// The supports of a flow, as crosses.
fn crosses_of(graph: &Graph, flow: &Flow, meshes: &[&TriangleMesh<Slot>]) -> TriangleMesh<Slot> {
    let how = Build { structure: Structure::X, wall_mm: 0.4, gap_mm: 0.2, roof: None };
    build(graph, flow, &Ceiling::of(graph, meshes), &how).mesh
}

fn drawn(scene: &Scene, supports: &TriangleMesh<Slot>, words: &str) -> trunnion::view::Frame {
    let mut all: Vec<_> = scene.meshes.iter().map(|mesh| solid(mesh, BLUE, None)).collect();
    let mut columns = solid(supports, AMBER, None);
    columns.edges = false;
    all.push(columns);
    all.iter_mut().for_each(|surface| surface.edges = false);
    frame(all, words)
}

/// Figure 3.1: a ball in the air.
pub(super) fn ball(_: &Run) -> Item {
    let mesh = scenes::ball(Vec3::new(30.0, 30.0, 40.0), 15.0, 40);
    let scene = Scene { meshes: vec![mesh], space: [60.0, 60.0, 60.0], step_mm: 2.0 };
    let graph = scene.graph();
    let meshes: Vec<_> = scene.meshes.iter().collect();
    let limits = || FlowLimits::new(CAPACITY, None);
    let (cheapest, _) = min_cost(&graph, limits(), &mut |_| {});
    let (merged, _) = shortest_paths(&graph, limits(), &PathDrawing::default(), &mut |_| {});
    let [straight, together] = [&cheapest, &merged].map(|flow| flow.tally(&graph, CAPACITY, None));
    let frames = vec![
        drawn(&scene, &crosses_of(&graph, &cheapest, &meshes), "min-cost flow: straight down"),
        drawn(&scene, &crosses_of(&graph, &merged, &meshes), "shortest paths that share arcs"),
    ];
    let share = together.used_arcs() as f64 / straight.used_arcs() as f64;
    let slanting = (straight.oblique as f64 / straight.used_arcs() as f64 * 100.0).round();
    Item::figure("3.1", "Supports where nothing is below: a ball in the air")
        .picture("", sheet("Figure 3.1", 2, frames, Vec::new()))
        .row(
            Row::absolute("slanting arcs of the cheapest flow, %", 0.0, slanting, 0.0, "points")
                .because("the text calls it a simple straight line down"),
        )
        .row(
            Row::same("shared paths need less material", "less", if share < 1.0 { "less" } else { "more" })
                .because(format!("{} arcs instead of {}", together.used_arcs(), straight.used_arcs())),
        )
}

/// The cross that replaces an arc.
pub(super) fn crosses() -> Item {
    // A small roof over the ground, and one whose way down is around a block.
    let roof = scenes::block(Vec3::new(4.1, 4.1, 12.1), Vec3::new(5.9, 5.9, 15.0));
    let lower = scenes::block(Vec3::new(3.2, 3.2, 0.1), Vec3::new(6.8, 6.8, 4.0));
    let scene = |meshes: Vec<TriangleMesh<Slot>>| Scene { meshes, space: [10.0, 10.0, 16.0], step_mm: 2.0 };
    let one = |meshes: Vec<TriangleMesh<Slot>>, words: &str| {
        let scene = scene(meshes);
        let graph = scene.graph();
        let all: Vec<_> = scene.meshes.iter().collect();
        let (flow, _) = min_cost(&graph, FlowLimits::new(CAPACITY, None), &mut |_| {});
        let built = crosses_of(&graph, &flow, &all);
        let tally = flow.tally(&graph, CAPACITY, None);
        let mut supports = solid(&built, AMBER, None);
        supports.edges = true;
        let surfaces = scene.meshes.iter().map(|mesh| solid(mesh, GREY, None)).chain([supports]).collect();
        (frame(surfaces, words), tally, built.volume())
    };
    let (straight, tally, volume) = one(vec![roof.clone()], "straight");
    let (around, slanted, _) = one(vec![roof, lower], "around a block");
    // Two sheets over the diagonals of a square, 2 sqrt(2) h wide together, less their crossing.
    let wanted = 2.0 * 2f64.sqrt() * 2.0 * 0.4 * tally.length_mm(2.0);
    Item::figure("1", "An X of two sheets in place of each arc (section 3.5)")
        .picture("", sheet("Figure 1", 2, vec![straight, around], Vec::new()))
        .row(
            Row::relative("volume of the straight ones, mm³: length x 2√2 h t", wanted, volume, 0.08)
                .because("computed from the formula; ours end below the surface, their sheets cross once and reach into each other's corners"),
        )
        .row(Row::same("slanting arcs around a block", "some", if slanted.oblique > 0 { "some" } else { "none" }))
}

/// Crosses that touch at every third level, so that powder gets out.
pub(super) fn apart() -> Item {
    const STEP_MM: f64 = 2.0;
    const LAYER_MM: f64 = 0.1;
    let roof = scenes::block(Vec3::new(2.1, 2.1, 18.1), Vec3::new(7.9, 7.9, 19.0));
    let scene = Scene { meshes: vec![roof], space: [10.0, 10.0, 20.0], step_mm: STEP_MM };
    let graph = scene.graph();
    let meshes: Vec<_> = scene.meshes.iter().collect();
    let (flow, _) = min_cost(&graph, FlowLimits::new(CAPACITY, None), &mut |_| {});
    let count = (scene.space[2] / LAYER_MM).round() as usize;
    let laid = |touch_every: u16| {
        let spans: Vec<[f64; 2]> = (0..count).map(|k| [k, k + 1].map(|k| k as f64 * LAYER_MM)).collect();
        let clearance = Clearance { line_mm: 0.4, gap_mm: 0.2, clear: Clear::Around };
        let around = Around { meshes: &meshes, carrying: meshes.len(), keels: &Keels::default() };
        lines(&graph, &flow, &Cuts::of(&around, spans, clearance), &Laying { on_part: false, roof: None, touch_every })
    };
    let [together, apart] = [1, 3].map(laid);
    let pieces = |layers: &[SupportLayer], level: usize| {
        let at = (level as f64 * STEP_MM / LAYER_MM).round() as usize;
        layers.get(at).map_or(0, |layer| groups(&layer.lines)) as f64
    };
    let views = [(&together, "everywhere"), (&apart, "at every third level")];
    let frames = views.map(|(layers, words)| drawn(&scene, &sheets(layers, 0.4).mesh, words)).to_vec();
    let columns = graph.red.len() as f64;
    let mut item = Item::figure("2", "Crosses that touch at every third level (section 3.5)")
        .picture("", sheet("Figure 2", 2, frames, Vec::new()))
        .row(Row::absolute("pieces of a cross-section where all touch", 1.0, pieces(&together, 1), 0.0, ""));
    for level in 0..=6 {
        let wanted = if level % 3 == 0 { 1.0 } else { columns };
        let row = Row::absolute(
            format!("pieces of a cross-section at level {level}"),
            wanted,
            pieces(&apart, level),
            0.0,
            "",
        );
        item = item.row(row.because("one where the crosses touch, as many as there are columns where they do not"));
    }
    item
}

/// How many groups of lines there are that touch each other.
fn groups(lines: &[[[f64; 2]; 2]]) -> usize {
    let mut of: Vec<usize> = (0..lines.len()).collect();
    for i in 0..lines.len() {
        for j in 0..i {
            if gap_mm(&lines[i], &lines[j]) < 0.1 {
                let (a, b) = (of[i], of[j]);
                of.iter_mut().filter(|group| **group == a).for_each(|group| *group = b);
            }
        }
    }
    of.sort_unstable();
    of.dedup();
    of.len()
}

/// The distance of two stretches, mm.
fn gap_mm(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]) -> f64 {
    let side = |[p, q]: &[[f64; 2]; 2], r: &[f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    if side(a, &b[0]) * side(a, &b[1]) < 0.0 && side(b, &a[0]) * side(b, &a[1]) < 0.0 {
        return 0.0;
    }
    let to = |[p, q]: &[[f64; 2]; 2], r: &[f64; 2]| {
        let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
        let t = (((r[0] - p[0]) * dx + (r[1] - p[1]) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        (r[0] - p[0] - t * dx).hypot(r[1] - p[1] - t * dy)
    };
    to(a, &b[0]).min(to(a, &b[1])).min(to(b, &a[0])).min(to(b, &a[1]))
}

/// A scene of figure 4.1 with what is printed of it.
struct Input {
    name: &'static str,
    what: &'static str,
    scene: fn() -> Scene,
    nodes: f64,
    arcs: f64,
    /// Seconds: push-relabel, min-cost flow, shortest paths.
    seconds: [f64; 3],
}

fn two_rings() -> Scene {
    let ring = |x: f64| scenes::ring(Vec3::new(x, 45.0, 31.0), [14.0, 5.0], Angle::from_deg(20.0), 0.4, 40);
    Scene { meshes: vec![ring(45.0), ring(105.0)], space: [150.0, 90.0, 50.0], step_mm: 1.78 }
}

fn balls() -> Scene {
    Scene { step_mm: 1.64, ..scenes::two_balls() }
}

fn knot() -> Scene {
    Scene { step_mm: 1.388, ..scenes::knot() }
}

fn many_rings() -> Scene {
    Scene { step_mm: 0.9, ..scenes::many_rings() }
}

const INPUTS: [Input; 5] = [
    Input {
        name: "A",
        what: "a leaning ring",
        scene: scenes::leaning_ring,
        nodes: 8196.0,
        arcs: 35674.0,
        seconds: [0.002, 0.017, 0.092],
    },
    Input {
        name: "B",
        what: "two of A",
        scene: two_rings,
        nodes: 27670.0,
        arcs: 126_566.0,
        seconds: [0.007, 0.089, 0.325],
    },
    Input {
        name: "C",
        what: "a ball over a ball",
        scene: balls,
        nodes: 62708.0,
        arcs: 296_235.0,
        seconds: [0.027, 0.133, 0.948],
    },
    Input {
        name: "D",
        what: "a knotted tube",
        scene: knot,
        nodes: 1_110_380.0,
        arcs: 5_348_590.0,
        seconds: [0.664, 12.1, 20.73],
    },
    Input {
        name: "E",
        what: "400 leaning rings",
        scene: many_rings,
        nodes: 6_424_582.0,
        arcs: 31_381_816.0,
        seconds: [6.75, 186.0, 142.0],
    },
];

/// What the three methods come to: cost and arcs used, and seconds.
fn solved(graph: &Graph) -> [(u64, usize, f64); 3] {
    let limits = || FlowLimits::new(CAPACITY, None);
    let timed = |solve: &dyn Fn() -> Flow| {
        let begun = Instant::now();
        let tally = solve().tally(graph, CAPACITY, None);
        (tally.cost, tally.used_arcs(), begun.elapsed().as_secs_f64())
    };
    [
        timed(&|| push_relabel(graph, limits(), &mut |_| {}).0),
        timed(&|| min_cost(graph, limits(), &mut |_| {}).0),
        timed(&|| {
            shortest_paths(graph, limits(), &PathDrawing { repair: false, ..PathDrawing::default() }, &mut |_| {}).0
        }),
    ]
}

/// The tables of graphs and of times, and figure 4.1.
pub(super) fn graphs(run: &Run) -> Vec<Item> {
    let mut sizes = Item::table("of graphs", "Sizes of the graphs of five inputs (chapter 4, unnumbered)");
    let mut times = Item::table("of times", "Seconds of three methods on five inputs (chapter 4, unnumbered)");
    let mut frames = Vec::new();
    let why = "the input files are not published; ours are like their pictures, and the step of the grid is chosen for a graph of about this size";
    for input in INPUTS.iter().take(if run.quick { 3 } else { 5 }) {
        let scene = (input.scene)();
        let graph = scene.graph();
        let count = graph.count();
        sizes.rows.push(
            Row::relative(format!("{}, {}: nodes", input.name, input.what), input.nodes, count.nodes as f64, 0.08)
                .because(why),
        );
        sizes
            .rows
            .push(Row::relative(format!("{}: arcs", input.name), input.arcs, count.arcs as f64, 0.08).because(why));
        let found = solved(&graph);
        let least = found[1].0;
        for ((method, printed), (cost, arcs, seconds)) in
            ["push-relabel", "min-cost flow", "shortest paths"].iter().zip(input.seconds).zip(found)
        {
            // Seconds are this machine's and change from run to run; without them the files of a quick run are the same each time.
            let took = if run.quick { String::new() } else { format!("{seconds:.3} s, ") };
            let ours = format!("{took}cost {cost}, {arcs} arcs used");
            let why = "another machine; the thesis prints no costs and no material";
            times.rows.push(Row::open(format!("{}: {method}", input.name), format!("{printed} s"), ours, why));
        }
        let above = 100.0 * (found[0].0 as f64 / least as f64 - 1.0);
        times.rows.push(
            Row::absolute(format!("{}: cost of push-relabel above the least", input.name), 0.0, above, 3.0, "%")
                .because("expected, not printed: the rule to take vertical edges first is to keep it near"),
        );
        if matches!(input.name, "A" | "D") || input.name == "E" && !run.quick {
            let supports = if input.name == "E" {
                None
            } else {
                Some(shortest_paths(&graph, FlowLimits::new(CAPACITY, None), &PathDrawing::default(), &mut |_| {}).0)
            };
            let all: Vec<_> = scene.meshes.iter().collect();
            let mesh = supports
                .map_or_else(|| TriangleMesh::new(Vec::new(), Vec::new()), |flow| crosses_of(&graph, &flow, &all));
            frames.push(drawn(&scene, &mesh, &format!("input {}: {}", input.name, input.what)));
        }
    }
    let figure = Item::figure("4.1", "The inputs; those of A and D with supports by shortest paths")
        .stand_in("solids like those of the pictures; the files are not published")
        .picture("", sheet("Figure 4.1", 3, frames, Vec::new()));
    vec![sizes, times, figure]
}
