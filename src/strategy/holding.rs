//! Supports in the main job: planned for a part that stands on the level table, and laid at the layers that its own slicer made.
//!
//! A plan says of a print that it has supports, and how wide their grid is; what they are is worked out from the part again wherever it is
//! wanted, the same each time. Planning lays them at the profile's own layers and asks `overhang` what is left; writing the file for
//! the machine lays them at those of the sliced part.

use std::sync::Arc;

use super::grid::grid_over;
use crate::geom::{Angle, Bounds, Machine, Mat3, Rigid, Slot, Vec3};
use crate::input::{BadSetting, CheckedPlan};
use crate::mesh::TriangleMesh;
use crate::motion::TableKinematics;
use crate::overhang::{Footing, Ground, Keels, LayerJudge, OverhangRule, Relief, SupportLines};
use crate::planning::{Plan, Print, PrintSupports, PropPlace, Workpiece};
use crate::profile::{Profile, SliceSettings};
use crate::section::Sections;
use crate::slicing::builtin::sheets;
use crate::support::{
    Around, Bare, Bars, Build, Ceiling, Clear, Clearance, Cuts, Flow, FlowMethod, Graph, Laying, Prop, Roof, Structure,
    SupportLayer, bare, braced, build, lines, longest_free_mm, plan, propped,
};
use crate::toolpath::{Input, SlicedError, SlicedPrint, SlotMesh, print_name, slot_mesh};

/// Where the middle of a part with supports is put, mm.
pub(crate) const CENTRE_MM: [f64; 2] = [0.0; 2];
/// Units that a column carries. Lines of filament are stiff enough for ten cells' tops, and each column fewer saves its whole height.
const CAPACITY: u16 = 10;
/// Seed of the search for the least material.
const SEED: u64 = 1;
/// Air beside a support, in widths of a line.
const BESIDE_WIDTHS: f64 = 0.5;
/// What is farther away stands in no support's way, mm: the widest grid ends five steps of 5 mm beside its part.
const NEAR_MM: f64 = 30.0;
/// So far around what makes a joint with a part its gap is, mm.
const JOINT_MM: f64 = 1.0;
/// Facets as near to the table lie on it, mm.
const ON_TABLE_MM: f64 = 0.05;
/// Heights that differ by less are one layer, mm.
const SAME_MM: f64 = 1e-3;

/// Why supports cannot be laid.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LayError {
    /// They want a grid that there cannot be.
    #[error(transparent)]
    Setting(#[from] BadSetting),
    /// What they hold cannot be read.
    #[error(transparent)]
    Sliced(#[from] SlicedError),
}

/// A part as its supports are planned, always on the same place: numbers rounded otherwise would make other columns.
pub(crate) struct HeldMesh {
    /// The part, z from the table.
    pub(crate) slot: SlotMesh,
    /// The parts that grow beside it, near enough to be in its supports' way; slot frame. First those that may carry them.
    others: Vec<TriangleMesh<Slot>>,
    /// So many of these may.
    carrying: usize,
}

impl HeldMesh {
    /// The part of a print of `plan`.
    pub(crate) fn of(plan: &Plan, workpiece: &Workpiece<'_>, table: &TableKinematics, print: &Print) -> Self {
        let slot = slot_mesh(workpiece, table, print, CENTRE_MM).above_table();
        let setup = plan.setup_of(print.part);
        let motion = table.forward(print.pose(table));
        let to_slot = Rigid::<Machine, Slot>::new(Mat3::identity(), -slot.to_machine);
        let near = slot.mesh.bounds().inflated(NEAR_MM);
        let others = setup.iter().map(|one| one.part).filter(|part| *part != print.part);
        let (caught, free): (Vec<usize>, Vec<usize>) =
            others.partition(|part| workpiece.model.is_joint(print.part, *part));
        let placed = |parts: Vec<usize>| -> Vec<TriangleMesh<Slot>> {
            let placed = parts.into_iter().map(|part| workpiece.parts[part].moved(&motion).moved(&to_slot));
            placed.filter(|mesh| mesh.bounds().meets(&near)).collect()
        };
        let mut others = placed(free);
        let carrying = others.len();
        others.extend(placed(caught));
        Self { slot, others, carrying }
    }

    /// Whether a place of the part is where supports could not be removed: it is captive, or what makes a joint with it is there.
    pub(crate) fn is_in_joint(&self, at: &Vec3) -> bool {
        let joints = &self.others[self.carrying..];
        self.slot.raised_mm > 0.0 || joints.iter().any(|mesh| mesh.bounds().inflated(JOINT_MM).holds(at))
    }

    /// The tops of its layers, where each is `layer_mm` high; from the table on.
    pub(crate) fn tops(&self, layer_mm: f64) -> Vec<f64> {
        let bounds = self.slot.mesh.bounds();
        let raised_mm = self.slot.raised_mm;
        let own = even_tops(layer_mm, bounds.max.z - raised_mm);
        from_the_table(&own.into_iter().map(|top| top + raised_mm).collect::<Vec<_>>(), raised_mm, layer_mm)
    }

    /// Whether a facet lies on the table.
    fn lies(&self, facet: usize) -> bool {
        self.slot.mesh.corners(facet).iter().all(|corner| corner.z < ON_TABLE_MM)
    }

    /// Where something of the part begins in the air, mm.
    pub(crate) fn begins_mm(&self, rule: &OverhangRule) -> Vec<f64> {
        let mesh = &self.slot.mesh;
        let relief = Relief::of(mesh.vertices().to_vec(), mesh.facets().to_vec());
        relief.in_the_air(&Vec3::z(), |facet| self.lies(facet), &rule.hang())
    }

    /// What of the part no slicer is sure to lay, in layers that end at these heights, where it begins in the air at those.
    pub(crate) fn keels(&self, rule: &OverhangRule, tops: &[f64], begins_mm: &[f64]) -> Keels {
        let middles: Vec<f64> = spans(tops).iter().map(|[low, high]| f64::midpoint(*low, *high)).collect();
        Keels::of(&Sections::of(&self.slot.mesh), &middles, begins_mm, rule)
    }

    /// What supports keep clear of, in layers that go from one of `tops` to the next.
    pub(crate) fn cuts(&self, keels: &Keels, tops: &[f64], gap_mm: f64, process: &SliceSettings) -> Cuts {
        let line_mm = process.line_width_mm;
        let clear = Clear::Layers { beside_mm: BESIDE_WIDTHS * line_mm };
        let around = Around { meshes: &self.all(), carrying: 1 + self.carrying, keels };
        Cuts::of(&around, spans(tops), Clearance { line_mm, gap_mm, clear })
    }

    /// The part and what grows beside it.
    fn all(&self) -> Vec<&TriangleMesh<Slot>> {
        std::iter::once(&self.slot.mesh).chain(&self.others).collect()
    }
}

/// Supports of one print, as lines.
#[derive(Clone)]
pub(crate) struct Laid {
    /// By layer.
    pub(crate) layers: Vec<SupportLayer>,
    /// What has no way to the table, the largest patch first.
    pub(crate) bare: Vec<Bare>,
    /// The longest stretch of a column without another beside it, mm.
    pub(crate) longest_free_mm: f64,
}

impl Laid {
    /// No supports at all.
    pub(crate) fn none() -> Self {
        Self { layers: Vec::new(), bare: Vec::new(), longest_free_mm: 0.0 }
    }

    /// Lays supports below a part, in the layers of its `cuts`.
    ///
    /// # Errors
    ///
    /// [`BadSetting::TooFine`] for a part too large for the grid.
    pub(crate) fn below(
        held: &HeldMesh,
        cuts: &Cuts,
        supports: &PrintSupports,
        process: &SliceSettings,
    ) -> Result<Self, BadSetting> {
        let mut laid = Self::columns(held, cuts, supports, process)?;
        laid.prop(cuts, supports);
        Ok(laid)
    }

    /// The same without props.
    pub(crate) fn columns(
        held: &HeldMesh,
        cuts: &Cuts,
        supports: &PrintSupports,
        process: &SliceSettings,
    ) -> Result<Self, BadSetting> {
        if supports.only_props {
            return Ok(Self::none());
        }
        let (graph, flow) = columns(held, supports)?;
        let roof = supports.roof.map(|roof| Roof {
            layers: (roof.height_mm / process.layer_height_mm - SAME_MM).ceil().max(1.0) as usize,
            pitch_mm: roof.pitch_mm,
        });
        Ok(Self {
            layers: lines(&graph, &flow, cuts, &Laying { on_part: true, roof, touch_every: 1 }),
            bare: bare(&graph),
            longest_free_mm: longest_free_mm(&graph, &flow),
        })
    }

    /// Adds the props to columns.
    pub(crate) fn prop(&mut self, cuts: &Cuts, supports: &PrintSupports) {
        if !supports.props.is_empty() {
            propped(&mut self.layers, &props(supports), cuts, supports.step_mm);
        }
    }

    /// The length of all lines, mm.
    pub(crate) fn length_mm(&self) -> f64 {
        let lines = self.layers.iter().flat_map(|layer| &layer.lines);
        lines.map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1])).sum()
    }

    /// The box of all lines.
    pub(crate) fn bounds(&self) -> Bounds {
        let ends = |layer: &SupportLayer| -> Vec<Vec3> {
            layer.lines.iter().flatten().map(|p| Vec3::new(p[0], p[1], layer.span_mm[1])).collect()
        };
        Bounds::of(self.layers.iter().flat_map(ends))
    }

    /// As a part's layers lie on them.
    pub(crate) fn held(&self, supports: &PrintSupports, rule: &OverhangRule) -> SupportLines {
        let layers = self.layers.iter().map(|layer| (layer.span_mm[1], layer.lines.clone())).collect();
        // Between the diagonals of a cell no place is farther from one than a third of its edge.
        // A line ends at most as far beyond the last one as it may hang free.
        let beside_mm = (supports.step_mm / 2.0).min(rule.free_mm() - rule.line_mm / 2.0);
        SupportLines { layers, line_mm: rule.line_mm, gap_mm: supports.gap_mm, beside_mm }
    }
}

/// What says of a part that begins in the air at such heights what would be laid on nothing.
pub(crate) fn judge(held: &HeldMesh, rule: &OverhangRule, begins_mm: &[f64]) -> LayerJudge {
    let mesh = &held.slot.mesh;
    let lies = |facet: usize| held.lies(facet);
    let own = (0..mesh.facets().len()).filter(|&f| lies(f)).map(|f| mesh.corners(f)).collect();
    let footings = vec![Footing { own, below: Vec::new() }];
    let begins_mm = begins_mm.to_vec();
    let others = (!held.others.is_empty()).then(|| Arc::new(TriangleMesh::joined(held.others.iter())));
    let table = held.slot.raised_mm == 0.0;
    let ground = Ground { footings, table, begins_mm, others, ..Ground::default() };
    LayerJudge::of(mesh, &Vec3::z(), &ground, lies, rule)
}

/// The rule of a part with supports, where what droops counts; what these are laid to depends on no more of it.
fn rule(supports: &PrintSupports, process: &SliceSettings) -> OverhangRule {
    OverhangRule {
        overhang: Angle::from_deg(supports.overhang_deg),
        layer_mm: process.layer_height_mm,
        line_mm: process.line_width_mm,
        bridge_mm: process.bridge_mm,
        tolerate_mm2: 0.0,
        droops: false,
    }
}

/// From where to where layers go that end at these heights.
fn spans(tops: &[f64]) -> Vec<[f64; 2]> {
    let bottoms = std::iter::once(&0.0).chain(tops);
    bottoms.zip(tops).map(|(low, high)| [*low, *high]).collect()
}

/// The places that are propped.
fn props(supports: &PrintSupports) -> Vec<Prop> {
    let prop = |place: &PropPlace| Prop { under_mm: place.under_mm, within_mm: place.within_mm, middle: place.middle };
    supports.props.iter().map(prop).collect()
}

/// The columns that hold `mesh`, and the struts between them.
fn columns(held: &HeldMesh, supports: &PrintSupports) -> Result<(Graph, Flow), BadSetting> {
    let (meshes, others): ([_; 1], Vec<_>) = ([&held.slot.mesh], held.others.iter().collect());
    let grid = grid_over(&meshes, "step_mm", supports.step_mm)?;
    let graph = Graph::among(grid, &meshes, &others, Angle::from_deg(supports.overhang_deg));
    let planned = plan(&graph, FlowMethod::Auto, CAPACITY, None, SEED, &mut |_| {});
    let flow = match supports.brace_mm {
        Some(most_mm) => braced(&graph, &planned.flow, most_mm).flow,
        None => planned.flow,
    };
    Ok((graph, flow))
}

/// The supports of a plan as solids, sheets as thick as a line, for pictures: the part that each holds, and its surface, machine frame.
pub(crate) fn support_solids(
    plan: &Plan,
    workpiece: &Workpiece<'_>,
    profile: &Profile,
) -> Vec<(usize, TriangleMesh<Machine>)> {
    let solid = |print: &Print| {
        let supports = print.supports.as_ref()?;
        let held = HeldMesh::of(plan, workpiece, &profile.kinematics(), print);
        let columns = if supports.only_props {
            TriangleMesh::new(Vec::new(), Vec::new())
        } else {
            // A plan's grid was made once already; without it the picture lacks them, and nothing else does.
            let (graph, flow) = columns(&held, supports).ok()?;
            let roof = supports.roof.map(|roof| Bars { high_mm: roof.height_mm, pitch_mm: roof.pitch_mm });
            let (wall_mm, gap_mm) = (profile.process.line_width_mm, supports.gap_mm);
            let how = Build { structure: Structure::X, wall_mm, gap_mm, roof };
            build(&graph, &flow, &Ceiling::of(&graph, &[&held.slot.mesh]), &how).mesh
        };
        let all = with_props(columns, &held, supports, &profile.process);
        Some((print.part, all.moved(&Rigid::shift(held.slot.to_machine))))
    };
    plan.prints().filter_map(|(_, print)| solid(print)).collect()
}

/// `columns` with the sheets of props, a box for what of a sheet is the same in layers one above the other.
fn with_props(
    columns: TriangleMesh<Slot>,
    held: &HeldMesh,
    supports: &PrintSupports,
    process: &SliceSettings,
) -> TriangleMesh<Slot> {
    if supports.props.is_empty() {
        return columns;
    }
    let line_mm = process.line_width_mm;
    let mut laid = Laid::none();
    let tops = held.tops(process.layer_height_mm);
    let rule = rule(supports, process);
    let keels = held.keels(&rule, &tops, &held.begins_mm(&rule));
    laid.prop(&held.cuts(&keels, &tops, supports.gap_mm, process), supports);
    let mut boxes: Vec<Bounds> = Vec::new();
    // The lines of the layer below, and their boxes.
    let mut below: Vec<([[f64; 2]; 2], usize)> = Vec::new();
    for layer in &laid.layers {
        let [low, high] = layer.span_mm;
        let goes_on = |line: &[[f64; 2]; 2]| Some(below.iter().find(|(other, _)| other == line)?.1);
        let mut here = Vec::with_capacity(layer.lines.len());
        for line in &layer.lines {
            let place = goes_on(line).unwrap_or_else(|| {
                let [a, b] = line.map(|[x, y]| Vec3::new(x, y, low));
                let half = Vec3::ith(usize::from(a.x != b.x), line_mm / 2.0);
                boxes.push(Bounds { min: a.inf(&b) - half, max: a.sup(&b) + half });
                boxes.len() - 1
            });
            boxes[place].max.z = high;
            here.push((*line, place));
        }
        below = here;
    }
    let (mut vertices, mut facets) = (columns.vertices().to_vec(), columns.facets().to_vec());
    for bounds in &boxes {
        let (base, one) = (vertices.len() as u32, TriangleMesh::<Slot>::cuboid(bounds));
        vertices.extend_from_slice(one.vertices());
        facets.extend(one.facets().iter().map(|f| f.map(|v| v + base)));
    }
    TriangleMesh::new(vertices, facets)
}

/// The tops of layers of `layer_mm` up to `height_mm`.
fn even_tops(layer_mm: f64, height_mm: f64) -> Vec<f64> {
    let count = (height_mm / layer_mm).round().max(1.0) as usize;
    (1..=count).map(|k| k as f64 * layer_mm).collect()
}

/// A layer on the table is no thinner than this, in layers, and thinner than one more.
const THINNEST_FIRST: f64 = 0.7;

/// The layers of a part whose lowest point is `raised_mm` above the table, and below its first one more: down to the lowest point of what begins
/// where it is as wide as a line, and from there whole layers to the first one on the table, which is what is left.
fn from_the_table(tops: &[f64], raised_mm: f64, layer_mm: f64) -> Vec<f64> {
    let first = tops.first().copied().unwrap_or(raised_mm + layer_mm) - raised_mm;
    let count = (first / layer_mm).round().max(1.0);
    let own = (1..count as usize).map(|k| raised_mm + first * k as f64 / count);
    let whole = (raised_mm / layer_mm - THINNEST_FIRST + SAME_MM).floor().max(0.0) as usize;
    let down = (0..=whole).rev().map(|k| raised_mm - k as f64 * layer_mm).filter(|_| raised_mm > 0.0);
    down.chain(own).chain(tops.iter().copied()).collect()
}

/// The supports of `print` as G-code like a slicer's, at the layers of what was `sliced` for it.
fn sliced_supports(
    plan: &CheckedPlan,
    number: usize,
    print: &Print,
    sliced: &SlicedPrint<'_>,
    centre_mm: [f64; 2],
) -> Result<Vec<u8>, LayError> {
    let Some(supports) = &print.supports else { return Ok(Vec::new()) };
    let process = &plan.machine.profile.process;
    let held = HeldMesh::of(&plan.plan, &plan.workpiece(), &plan.machine.profile.kinematics(), print);
    let raised_mm = held.slot.raised_mm;
    let mut tops: Vec<f64> = sliced.layers.iter().map(|layer| layer.z + raised_mm).collect();
    tops.sort_by(f64::total_cmp);
    tops.dedup_by(|a, b| *a - *b < SAME_MM);
    let tops = from_the_table(&tops, raised_mm, process.layer_height_mm);
    let rule = rule(supports, process);
    let mut keels = held.keels(&rule, &tops, &held.begins_mm(&rule));
    if !keels.is_empty() {
        let here = |p: [f64; 2]| [0, 1].map(|i| p[i] - centre_mm[i] + CENTRE_MM[i]);
        for (layer, mut lines) in sliced.layers.iter().zip(sliced.lines_by_layer()?) {
            lines.iter_mut().for_each(|line| *line = line.map(here));
            keels.laid(tops.partition_point(|top| *top < layer.z + raised_mm - SAME_MM), &lines);
        }
    }
    let laid = Laid::below(&held, &held.cuts(&keels, &tops, supports.gap_mm, process), supports, process)?;
    let name = print_name(number, &format!("supports of {}", plan.model.model.parts[print.part].name));
    Ok(sheets(&laid.layers, process, &name, sliced.nozzle_c))
}

/// The supports' prints of a plan: number and G-code, in their own coordinates around [`CENTRE_MM`].
///
/// # Errors
///
/// As [`Laid::below`], and what cannot be read of a sliced file.
pub(crate) fn all_supports(plan: &CheckedPlan, inputs: &[Input<'_>]) -> Result<Vec<(usize, Vec<u8>)>, LayError> {
    let one = |((number, _, print), held): ((usize, usize, &Print), usize)| {
        // What is missing is named where the file is written.
        let input = inputs.iter().find(|input| input.print == held)?;
        Some(sliced_supports(plan, number, print, input.sliced, input.centre_mm).map(|bytes| (number, bytes)))
    };
    plan.plan.supports().zip(plan.plan.held()).filter_map(one).collect()
}
