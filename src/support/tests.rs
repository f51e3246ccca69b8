//! The grid against separating axes, what wants support by hand, the order of arcs.

use super::flow::FlowLimits;
use super::preflow::in_order;
use super::residual::{Order, VERTICAL_FIRST};
use super::{ARCS, Demand, Graph, Grid, min_cost};
use crate::geom::{Angle, Slot, SplitMix64, Vec3};
use crate::mesh::TriangleMesh;

/// Whether a triangle and a box touch, by the axes that can separate them (Akenine-Moeller, 2001).
fn touch(triangle: &[Vec3; 3], low: &Vec3, high: &Vec3) -> bool {
    let sides = [triangle[1] - triangle[0], triangle[2] - triangle[1], triangle[0] - triangle[2]];
    let units = [Vec3::x(), Vec3::y(), Vec3::z()];
    let crossed = sides.iter().flat_map(|side| units.map(|unit| unit.cross(side)));
    let axes = units.into_iter().chain([sides[0].cross(&sides[1])]).chain(crossed);
    let corners: Vec<Vec3> =
        (0..8).map(|k| Vec3::from_fn(|i, _| if k >> i & 1 == 1 { high[i] } else { low[i] })).collect();
    axes.filter(|axis| axis.norm() > 1e-12).all(|axis| {
        let span = |points: &[Vec3]| {
            let along = points.iter().map(|p| p.dot(&axis));
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
        };
        let ((a, b), (c, d)) = (span(triangle), span(&corners));
        a <= d && c <= b
    })
}

#[test]
fn touched_cubes_are_those_that_no_axis_separates() {
    let grid = Grid { origin: Vec3::new(-3.0, 1.0, 0.0), step_mm: 1.7, size: [7, 6, 5] };
    let mut numbers = SplitMix64::seeded(3);
    let mut all = 0;
    for round in 0..400 {
        let reach = if round % 2 == 0 { 14.0 } else { 2.0 };
        let middle = Vec3::new(10.0 * numbers.unit() - 2.0, 10.0 * numbers.unit(), 8.0 * numbers.unit());
        let corners = [(); 3].map(|()| middle + Vec3::from_fn(|_, _| reach * (numbers.unit() - 0.5)));
        let mut found = vec![false; grid.len()];
        grid.touching(&corners, |cube| found[cube] = true);
        for (cube, found) in found.into_iter().enumerate() {
            let low = grid.origin + Vec3::from(grid.cube(cube).map(|i| i as f64)) * grid.step_mm;
            let wanted = touch(&corners, &low, &(low + Vec3::repeat(grid.step_mm)));
            assert_eq!(found, wanted, "cube {cube} of round {round}");
            all += usize::from(found);
        }
    }
    assert!(all > 2000, "{all}");
}

#[test]
fn a_facet_in_a_plane_of_the_grid_touches_both_sides() {
    let grid = Grid { origin: Vec3::zeros(), step_mm: 1.0, size: [3, 3, 3] };
    let facet = [Vec3::new(1.2, 1.2, 1.0), Vec3::new(1.8, 1.2, 1.0), Vec3::new(1.2, 1.8, 1.0)];
    let mut found = Vec::new();
    grid.touching(&facet, |cube| found.push(grid.cube(cube)));
    assert_eq!(found, [[1, 1, 0], [1, 1, 1]]);
}

#[test]
fn whole_steps_are_not_one_more() {
    assert_eq!(Grid::over(Vec3::zeros(), [0.3, 2.1, 0.05], 0.1).size, [3, 21, 1]);
    assert_eq!(Grid::over(Vec3::zeros(), [90.0, 90.0, 50.0], 2.15).size, [42, 42, 24]);
}

const DEGREES: f64 = 45.0;

/// A keel along x whose sides stand at 26.6 degrees from the vertical, its edge rising by `rise` over 10 mm.
fn wedge(rise: f64) -> TriangleMesh<Slot> {
    let top = [[0.0, -5.0, 20.0], [10.0, -5.0, 20.0], [10.0, 5.0, 20.0], [0.0, 5.0, 20.0]];
    let edge = [[0.0, 0.0, 10.0], [10.0, 0.0, 10.0 + rise]];
    let facets = vec![[0, 1, 2], [0, 2, 3], [0, 4, 5], [0, 5, 1], [3, 2, 5], [3, 5, 4], [0, 3, 4], [1, 5, 2]];
    let mesh = TriangleMesh::new(top.into_iter().chain(edge).map(Vec3::from).collect(), facets);
    assert!(mesh.volume() > 0.0);
    mesh
}

#[test]
fn a_keel_wants_support_along_its_edge_alone() {
    let demand = Demand::of(&wedge(0.0), Angle::from_deg(DEGREES));
    assert_eq!((demand.facets.len(), demand.points.len()), (0, 0));
    assert_eq!(demand.edges.len(), 1);
    let mut edge = demand.edges[0];
    edge.sort_unstable();
    assert_eq!(edge, [4, 5]);
    // The square below the whole edge is red, and nothing else: 10 of 1 mm, and the two that its ends touch.
    let grid = Grid { origin: Vec3::new(-5.0, -10.5, 0.0), step_mm: 1.0, size: [20, 21, 25] };
    let graph = Graph::of(grid, &[&wedge(0.0)], Angle::from_deg(DEGREES));
    assert!((10..=12).contains(&graph.red.len()), "{}", graph.red.len());
    assert!(graph.red.iter().all(|&red| graph.grid.cube(red as usize)[1] == 10));
}

/// Rising by 8 over 10 the edge is flatter than 45 degrees, by 9.7 just so; steeper it holds itself, and its foot is the lowest point.
#[test]
fn a_steep_edge_wants_support_at_its_foot_alone() {
    let of = |rise| Demand::of(&wedge(rise), Angle::from_deg(DEGREES));
    assert_eq!(of(8.0).edges.len(), 1);
    assert_eq!(of(9.7).edges.len(), 1);
    let top = [[0.0, -1.0, 40.0], [3.0, -1.0, 40.0], [3.0, 1.0, 40.0], [0.0, 1.0, 40.0]];
    let spike = pyramid(&top, [1.5, 0.0, 10.0]);
    let demand = Demand::of(&spike, Angle::from_deg(DEGREES));
    assert_eq!((demand.facets.len(), demand.edges.len()), (0, 0));
    assert_eq!(demand.points, [4]);
    // Turned over, the point is a top, and the base hangs.
    let over = TriangleMesh::new(
        spike.vertices().iter().map(|v| Vec3::new(v.x, -v.y, 50.0 - v.z)).collect(),
        spike.facets().to_vec(),
    );
    let demand = Demand::of(&over, Angle::from_deg(DEGREES));
    assert_eq!((demand.facets.len(), demand.points.len()), (2, 0));
}

fn pyramid(top: &[[f64; 3]; 4], tip: [f64; 3]) -> TriangleMesh<Slot> {
    let vertices = top.iter().chain([&tip]).map(|&p| Vec3::from(p)).collect();
    let mesh = TriangleMesh::new(vertices, vec![[0, 1, 2], [0, 2, 3], [0, 4, 1], [1, 4, 2], [2, 4, 3], [3, 4, 0]]);
    assert!(mesh.volume() > 0.0);
    mesh
}

/// The bottom of a hole is lower than all around it, but stands on material.
#[test]
fn the_bottom_of_a_hole_wants_no_support() {
    let tip = pyramid(&[[4.0, 4.0, 20.0], [6.0, 4.0, 20.0], [6.0, 6.0, 20.0], [4.0, 6.0, 20.0]], [5.0, 5.0, 10.0]);
    let hole = TriangleMesh::new(tip.vertices().to_vec(), tip.facets().iter().map(|&[a, b, c]| [a, c, b]).collect());
    assert!(Demand::of(&hole, Angle::from_deg(DEGREES)).points.is_empty());
}

/// A table of 12 by 12 over a block that leaves a border of two: everything must go aside.
fn crowded() -> Graph {
    let grid = Grid { origin: Vec3::zeros(), step_mm: 1.0, size: [16, 16, 24] };
    let marks: Vec<(bool, bool)> = (0..grid.len())
        .map(|i| {
            let [x, y, z] = grid.cube(i);
            let within = |low: usize, high: usize| (low..high).contains(&x) && (low..high).contains(&y);
            let top = z == 22 && within(2, 14);
            (top || (z < 8 && within(3, 13)), top)
        })
        .collect();
    Graph::of_marks(grid, &marks)
}

/// With arcs in any order the flow is as large; with straight ones first both ways it is near the cheapest, and only then.
#[test]
fn straight_arcs_first_keep_the_cost_down() {
    let graph = crowded();
    let least = min_cost(&graph, FlowLimits::new(4, None), &mut |_| {}).0.tally(&graph, 4, None).cost;
    let cost = |order| {
        let (flow, limits) = in_order(&graph, FlowLimits::new(4, None), order, &mut |_| {});
        assert!(flow.unbalanced(&graph).is_none() && limits.raised_arcs.is_empty());
        flow.tally(&graph, 4, None).cost
    };
    let ruled = cost(VERTICAL_FIRST);
    assert!(ruled as f64 <= 1.1 * least as f64, "{ruled} for {least}");
    let mut numbers = SplitMix64::seeded(5);
    let mut worst = 0;
    for _ in 0..6 {
        let mut sides: [usize; ARCS - 1] = [1, 2, 3, 4];
        (1..4).for_each(|i| sides.swap(i, numbers.below(i + 1)));
        let [a, b, c, d] = sides;
        // Whatever the order of the others, the rule holds the cost.
        let shuffled = cost(Order { push: [0, a, b, c, d], take: [d, c, b, a, 0] });
        assert!(shuffled as f64 <= 1.1 * least as f64, "{shuffled} for {least}");
        worst = worst.max(cost(Order { push: [a, b, c, d, 0], take: [0, a, b, c, d] }));
    }
    assert!(worst as f64 > 1.2 * least as f64, "{worst} for {least}");
}
