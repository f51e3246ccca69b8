//! Supports as meshes: closed, of the volume that the flow's length says, below what they hold.

use std::collections::HashMap;

use trunnion::geom::{Angle, Slot};
use trunnion::mesh::{ReadOptions, Repair, TriangleMesh, Unit, read_model, stl_binary};
use trunnion::support::{Bars, Build, Built, Ceiling, FlowMethod, Graph, PlannedFlow, Structure, build, cover, plan};

use super::scenes::{self, Scene};

const WALL_MM: f64 = 0.4;
const GAP_MM: f64 = 0.2;

fn built(graph: &Graph, planned: &PlannedFlow, ceiling: &Ceiling, structure: Structure) -> Built {
    build(graph, &planned.flow, ceiling, &Build { structure, wall_mm: WALL_MM, gap_mm: GAP_MM, roof: None })
}

fn scenes() -> [Scene; 2] {
    [scenes::leaning_ring(), scenes::two_balls()]
}

/// Every edge is run along once in each sense.
fn assert_closed(mesh: &TriangleMesh<Slot>) {
    let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
    for facet in mesh.facets() {
        for k in 0..3 {
            let [a, b] = [facet[k], facet[(k + 1) % 3]];
            *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            *edges.entry([a.max(b), a.min(b)]).or_default() += 1;
        }
    }
    for (edge, count) in &edges {
        let wanted = if edge[0] < edge[1] { 0 } else { 2 };
        assert_eq!(*count, wanted, "edge {edge:?}");
    }
}

#[test]
fn chains_are_closed_and_have_the_volume_of_their_arcs() {
    for scene in scenes() {
        let graph = scene.graph();
        let h = scene.step_mm;
        for (_, method) in FlowMethod::NAMED {
            let planned = plan(&graph, method, 4, None, 1, &mut |_| {});
            // Two sheets of t by the diagonal and four tenths of t at each end, less what they share; a square of 0.98 h.
            let sheet = 2.0 * WALL_MM * (2.0_f64.sqrt() * h + 0.8 * WALL_MM) - WALL_MM.powi(2);
            for (structure, area) in [(Structure::X, sheet), (Structure::Prism, (0.98 * h).powi(2))] {
                let built = built(&graph, &planned, &Ceiling::default(), structure);
                assert_closed(&built.mesh);
                let volume = area * h * planned.tally.used_arcs() as f64;
                // Ends beside others are cut by a hundredth of a step together, tops are as much higher.
                let apart = area * h * 0.011 * (built.chains + graph.red.len()) as f64;
                assert!((built.volume_mm3 - volume).abs() < apart, "{structure:?}: {} for {volume}", built.volume_mm3);
            }
            assert_closed(&built(&graph, &planned, &Ceiling::default(), Structure::Tree).mesh);
        }
    }
}

/// With one unit everywhere each rod is a prism of twelve sides: 3 r² h.
#[test]
fn rods_of_one_unit_have_the_volume_of_prisms() {
    let graph = scenes::leaning_ring().graph();
    let planned = plan(&graph, FlowMethod::MinCost, 1, None, 1, &mut |_| {});
    let built = built(&graph, &planned, &Ceiling::default(), Structure::Tree);
    let volume =
        3.0 * WALL_MM.powi(2) * graph.grid.step_mm * (planned.tally.used_arcs() as f64 + 0.01 * graph.red.len() as f64);
    assert!((built.volume_mm3 / volume - 1.0).abs() < 1e-9, "{} for {volume}", built.volume_mm3);
}

/// The reader of models takes what is written for as many closed solids as there are chains.
#[test]
fn what_is_written_is_read_as_closed_solids() {
    let scene = scenes::leaning_ring();
    let graph = scene.graph();
    let planned = plan(&graph, FlowMethod::ShortestPaths, 4, None, 1, &mut |_| {});
    let ceiling = Ceiling::of(&graph, &scene.meshes.iter().collect::<Vec<_>>());
    for (name, structure) in Structure::NAMED {
        let built = built(&graph, &planned, &ceiling, structure);
        let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
        let model = read_model(&stl_binary(&built.mesh), "supports.stl", &options).unwrap();
        assert_eq!(model.parts.len(), built.chains, "{name}");
        let volume: f64 = model.parts.iter().map(|part| part.mesh.volume()).sum();
        assert!((volume / built.volume_mm3 - 1.0).abs() < 1e-3, "{name}: {volume} for {}", built.volume_mm3);
    }
}

/// Bars of a roof are closed solids of their own, as high as asked for; the reader counts them with the chains.
#[test]
fn a_roof_is_read_as_closed_solids_too() {
    let scene = scenes::leaning_ring();
    let graph = scene.graph();
    let planned = plan(&graph, FlowMethod::Auto, 4, None, 1, &mut |_| {});
    let ceiling = Ceiling::of(&graph, &scene.meshes.iter().collect::<Vec<_>>());
    let how = |roof| Build { structure: Structure::X, wall_mm: WALL_MM, gap_mm: GAP_MM, roof };
    let plain = build(&graph, &planned.flow, &ceiling, &how(None));
    assert_eq!(plain.bars, 0);
    let mut last = usize::MAX;
    for pitch_mm in [0.8, 1.3, 2.0] {
        let roofed = build(&graph, &planned.flow, &ceiling, &how(Some(Bars { high_mm: 0.6, pitch_mm })));
        assert_closed(&roofed.mesh);
        assert!(roofed.bars > 50 && roofed.bars < last, "{} bars, {last} before", roofed.bars);
        last = roofed.bars;
        let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
        let model = read_model(&stl_binary(&roofed.mesh), "supports.stl", &options).unwrap();
        assert_eq!(model.parts.len(), roofed.chains + roofed.bars);
        // A bar is as high everywhere: its volume is that of its upper side.
        let (volume, side) = (roofed.volume_mm3 - plain.volume_mm3, roofed.contact_mm2 - plain.contact_mm2);
        assert!((volume / (0.6 * side) - 1.0).abs() < 1e-3, "{volume} for {side} mm2");
        // Rows a pitch apart, as wide as a wall, over the squares that hold something; where they end beside the part they are shorter.
        let share = WALL_MM / pitch_mm * graph.red.len() as f64 * scene.step_mm.powi(2);
        assert!(side > 0.6 * share && side < 1.05 * share, "{side} of {share}");
    }
}

/// Tops reach the surface but for the gap. The corners of a sheet, 0.25 mm beyond their cell, may be in the part by as much.
#[test]
fn tops_end_below_the_surface() {
    let scene = scenes::leaning_ring();
    let graph = scene.graph();
    let meshes: Vec<_> = scene.meshes.iter().collect();
    let planned = plan(&graph, FlowMethod::MinCost, 4, None, 1, &mut |_| {});
    let built = built(&graph, &planned, &Ceiling::of(&graph, &meshes), Structure::X);
    let bare = self::built(&graph, &planned, &Ceiling::default(), Structure::X);
    assert!(built.volume_mm3 > 1.005 * bare.volume_mm3, "{} for {}", built.volume_mm3, bare.volume_mm3);
    // The ring's tube is round: whatever lies in it is nearer to its middle line than the radius.
    let inside = |p: &trunnion::geom::Vec3| {
        let (middle, lean) = (trunnion::geom::Vec3::new(45.0, 45.0, 31.0), 20.0_f64.to_radians());
        let axis = trunnion::geom::Vec3::new(lean.sin() * 0.4_f64.cos(), lean.sin() * 0.4_f64.sin(), lean.cos());
        let from = p - middle;
        let along = from.dot(&axis);
        5.0 - ((from - axis * along).norm() - 14.0).hypot(along)
    };
    let deepest = built.mesh.vertices().iter().map(inside).fold(f64::NEG_INFINITY, f64::max);
    assert!(deepest < 0.26 && deepest > -0.3, "the nearest corner is {deepest} mm in the ring");
}

#[test]
fn what_is_planned_covers_what_overhangs() {
    for scene in scenes() {
        let graph = scene.graph();
        let meshes: Vec<_> = scene.meshes.iter().collect();
        let planned = plan(&graph, FlowMethod::Auto, 4, None, 1, &mut |_| {});
        let all = cover(&graph, &planned.flow, &meshes, Angle::from_deg(45.0));
        let bare = graph.unreachable.len() as f64 / (graph.unreachable.len() + graph.red.len()) as f64;
        assert!(all.share() > 1.0 - 1.5 * bare - 1e-9, "{all:?}, {bare} of the squares bare");
        assert!(bare > 0.0 || all.share() == 1.0, "{all:?}");
        let none = cover(&graph, &trunnion::support::Flow::none(&graph), &meshes, Angle::from_deg(45.0));
        assert_eq!((none.covered_mm2, none.area_mm2), (0.0, all.area_mm2));
    }
}
