//! Supports for what overhangs, planned as a flow from what must be held to the ground (Leitereg (2020), chapter 3).
//!
//! Slot frame: mm, +Z up, the ground at z = 0 of the grid. A support belongs to a part's print and pose; what comes out is the
//! same frame's, to be printed at the print's own layers.
//!
//! ```text
//! closed meshes --Graph::of--> Graph{red, green squares, arcs}   cubes the surface touches are black; what wants support is red
//! Graph --plan--> Planned{flow, tally, bound}                    one unit from each red square to the ground, within limits
//! Flow --braced--> Braced{flow}                                  struts, where columns stand free over a long way
//! Planned --build--> Built{mesh, volume}                         closed solids along the arcs with flow
//! ```
//!
//! Supports below a plate:
//!
//! ```
//! use trunnion::geom::{Angle, Bounds, Slot, Vec3};
//! use trunnion::mesh::TriangleMesh;
//! use trunnion::support::{Build, Ceiling, FlowMethod, Graph, Grid, Structure, build, cover, plan};
//!
//! // A plate of 20 x 10 mm whose underside is 5 mm above the ground (slot frame).
//! let plate: TriangleMesh<Slot> =
//!     TriangleMesh::cuboid(&Bounds { min: Vec3::new(5.0, 5.0, 5.0), max: Vec3::new(25.0, 15.0, 7.0) });
//! let (grid, overhang) = (Grid::over(Vec3::zeros(), [30.0, 20.0, 8.0], 1.0), Angle::from_deg(45.0));
//!
//! let graph = Graph::of(grid, &[&plate], overhang);
//! let planned = plan(&graph, FlowMethod::Auto, 8, None, 1, &mut |_hundredths| ());
//! let held = cover(&graph, &planned.flow, &[&plate], overhang);
//! // The whole underside is supported, 20 x 10 mm.
//! assert_eq!((held.share(), graph.unreachable.len()), (1.0, 0));
//! assert!((held.area_mm2 - 200.0).abs() < 1e-6);
//!
//! let how = Build { structure: Structure::X, wall_mm: 0.45, gap_mm: 0.2, roof: None };
//! let built = build(&graph, &planned.flow, &Ceiling::of(&graph, &[&plate]), &how);
//! // The supports end 0.2 mm below it.
//! assert!((built.mesh.bounds().max.z - 4.8).abs() < 1e-6);
//! ```
//!
//! Four methods ([`FlowMethod`]): [`push_relabel`] is the fastest, [`min_cost`] the cheapest by straight and oblique arcs, proved;
//! [`shortest_paths`] lets columns join, [`least_material`] is the one to use: it takes the least material of all, with no arc above
//! its limit. Nothing that can be held stays bare: where the limits would leave it so they are raised, one arc by one, and the
//! [`Tally`] counts them. What cannot be held whatever the limits is in [`Graph::unreachable`], by patches in [`bare`].
//!
//! A grid of nx by ny by nz cubes takes 2 bytes a cube, a flow 10, a method up to 30 more. Nothing here opens a file or knows a machine.

mod auto;
mod brace;
mod cheapest;
mod clear;
mod demand;
mod flow;
mod graph;
mod grid;
mod inside;
mod laying;
mod lines;
mod measure;
mod min_cost;
mod plan;
mod preflow;
mod props;
mod residual;
mod roof;
mod shortest_paths;
mod spans;
mod structure;
#[cfg(test)]
mod tests;
mod ways;

pub use auto::{Effort, least_material};
pub use brace::{Braced, braced};
pub use clear::{Around, Clearance, Cuts};
pub use demand::Demand;
pub use flow::{Flow, FlowLimits, Tally};
pub use graph::{ARCS, COSTS, Count, Graph};
pub use grid::Grid;
pub use laying::{Clear, Laying};
pub use lines::{SupportLayer, lines};
pub use measure::{Bare, Cover, SAMPLE_MM, bare, cover, held, longest_free_mm};
pub use min_cost::{min_cost, unlimited_cost};
pub use plan::{FlowMethod, PlannedFlow, plan};
pub use preflow::push_relabel;
pub use props::{Prop, propped};
pub use roof::Roof;
pub use shortest_paths::{PathDrawing, shared_price, shortest_paths};
pub use structure::{Bars, Build, Built, Ceiling, Outline, Sheets, Structure, build, sheets};
