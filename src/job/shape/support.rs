//! Supports for a model in one pose: planned, built as meshes, measured.

use std::path::Path;
use std::str::FromStr;

use crate::geom::{Angle, Bounds, Slot, Vec3, turned_by};
use crate::input::load_aloud;
use crate::input::{BadSetting, InputError, ModelSource};
use crate::mesh::{TriangleMesh, stl_binary, threemf};
use crate::overhang::Keels;
use crate::pictures::{self, PART, SUPPORT, SUPPORT_WORD, coloured};
use crate::spelling::{counted, nearest, numbers};
use crate::strategy::SupportForm;
use crate::strategy::grid::{OUTSIDE_MM, fitting, grid_over};
use crate::support::{
    Around, Bare, Bars, Braced, Build, Built, Ceiling, Clear, Clearance, Count, Cover, Cuts, Flow, FlowMethod, Graph,
    Grid, Laying, PlannedFlow, Roof, Structure, bare, braced, build, held, lines, longest_free_mm, plan, sheets,
};
use crate::view::Drawing;
use crate::world::World;

/// A model, and how to support it.
#[derive(Clone, Debug)]
pub struct SupportRequest {
    /// The model: one or several closed parts, all printed in one pose.
    pub model: ModelSource,
    /// How.
    pub options: SupportOptions,
}

/// Three numbers, as `0,0,1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreeNumbers(pub [f64; 3]);

impl FromStr for ThreeNumbers {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        numbers(text).map(Self).ok_or("must be three numbers separated by commas, for example 0,0,1")
    }
}

/// How to plan supports; the default is what the command does without flags.
#[derive(Clone, Debug, PartialEq)]
pub struct SupportOptions {
    /// The direction that is up, the file's frame; of any length.
    pub up: Vec3,
    /// Whether the file's own z = 0 is the ground; else the model's lowest point stands on it.
    pub keep_z: bool,
    /// Edge of a cube of the grid, mm.
    pub step_mm: f64,
    /// The space from the origin on, mm, in which supports may be; `None`: the model's box and some steps around it.
    pub space_mm: Option<[f64; 3]>,
    /// Surfaces up to this angle from the vertical need no support.
    pub overhang_deg: f64,
    /// Units of support that an arc may carry.
    pub capacity: u16,
    /// Units that may pass a node.
    pub node_capacity: Option<u16>,
    /// The method, by name.
    pub method: String,
    /// What stands along an arc, by name.
    pub structure: String,
    /// Thickness of a sheet, mm; `None`: 0.4, but at most half a step, or 0.3 of one where sheets touch at some levels alone.
    pub wall_mm: Option<f64>,
    /// What is left free below the part, mm.
    pub gap_mm: f64,
    /// Crossed sheets touch their neighbours once in so many levels, so that powder gets out between them; 1: everywhere.
    pub touch_every: u16,
    /// Roof and struts.
    pub form: SupportForm,
    /// Seed of the methods that draw numbers.
    pub seed: u64,
}

impl Default for SupportOptions {
    fn default() -> Self {
        Self {
            up: Vec3::z(),
            keep_z: false,
            step_mm: 2.0,
            space_mm: None,
            overhang_deg: 45.0,
            capacity: 4,
            node_capacity: None,
            method: "auto".to_owned(),
            structure: "x".to_owned(),
            wall_mm: None,
            gap_mm: 0.2,
            touch_every: 1,
            form: SupportForm::PLAIN,
            seed: 1,
        }
    }
}

/// A sheet is one line of a usual nozzle thick, mm.
const WALL_MM: f64 = 0.4;
/// Sheets that end short of their neighbours are at most so much of a step thick; thicker ones would be stumps.
const APART_WALL: f64 = 0.3;
/// From the middle of a roof's bar to that of the next, in thicknesses of a wall.
const ROOF_WALLS: f64 = 2.0;
/// Sheets follow the part in steps of about this height, mm, and of no less than this share of the gap.
const LAYER_MM: f64 = 0.1;
const MOST_IN_GAP: f64 = 8.0;
/// Patches that a message names.
const NAMED: usize = 3;

/// Supports of a model.
#[derive(Clone, Debug)]
pub struct SupportResult {
    /// The parts as they stand, +Z up, mm.
    pub parts: Vec<(String, TriangleMesh<Slot>)>,
    /// The squares in which supports were planned.
    pub graph: Graph,
    /// How large the graph is.
    pub count: Count,
    /// The method.
    pub method: &'static str,
    /// The flow.
    pub planned: PlannedFlow,
    /// The supports.
    pub built: Built,
    /// What of the overhanging area they hold.
    pub cover: Cover,
    /// What cannot be held, the largest patch first.
    pub bare: Vec<Bare>,
    /// The longest stretch of a column without another beside it, struts among them, mm.
    pub longest_free_mm: f64,
    /// Pieces that only tie columns together.
    pub struts: usize,
    /// Columns that stand free over more than was asked for all the same.
    pub unbraced: usize,
    /// What planning alone took.
    pub seconds_plan: f64,
    /// What it took in all.
    pub seconds: f64,
}

impl SupportResult {
    /// The supports as binary STL.
    pub fn stl(&self) -> Vec<u8> {
        stl_binary(&self.built.mesh)
    }

    /// The parts as they stand and the supports as 3MF.
    pub fn threemf(&self) -> Vec<u8> {
        let mut objects: Vec<(String, &TriangleMesh<Slot>)> =
            self.parts.iter().map(|(name, mesh)| (name.clone(), mesh)).collect();
        objects.push(("supports".to_owned(), &self.built.mesh));
        threemf(&objects)
    }

    /// What is written to a file of this name.
    ///
    /// # Errors
    ///
    /// [`BadSetting::Ending`] for one that ends neither with `.stl` nor with `.3mf`.
    pub fn file(&self, path: &Path) -> Result<Vec<u8>, BadSetting> {
        if is_3mf(path)? { Ok(self.threemf()) } else { Ok(self.stl()) }
    }

    /// The parts with their supports in blue, from above and from below.
    pub fn view(&self) -> Drawing {
        let parts = self.parts.iter().map(|(name, mesh)| coloured(mesh, PART, Some(name.as_str())));
        let solids = parts.chain([coloured(&self.built.mesh, SUPPORT, None)]).collect();
        let legend = vec![(PART, "parts"), SUPPORT_WORD];
        pictures::solids("Parts on their supports", solids, legend, vec![], true).drawing()
    }

    /// Whether something wants support, and none of it can have any.
    pub fn why_not(&self) -> Option<String> {
        let hopeless = self.graph.red.is_empty() && !self.bare.is_empty();
        hopeless.then(|| format!("{}; choose another direction (--up), or a finer --step", self.unreached()))
    }

    /// What is left bare, in words; empty where nothing is.
    fn unreached(&self) -> String {
        if self.bare.is_empty() {
            return String::new();
        }
        let area: f64 = self.bare.iter().map(|patch| patch.area_mm2).sum();
        let at = |patch: &Bare| format!("({:.1}, {:.1}, {:.1})", patch.at.x, patch.at.y, patch.at.z);
        let places: Vec<String> = self.bare.iter().take(NAMED).map(at).collect();
        let more = if self.bare.len() > NAMED { " and elsewhere" } else { "" };
        format!("{area:.1} mm2 of overhang cannot be supported from the ground, near {}{more} (mm)", places.join(", "))
    }
}

/// Plans and builds supports.
///
/// # Errors
///
/// [`InputError::Setting`] for options that cannot be, for a model that lies outside the space or below the ground, and for a grid that
/// does not fit in memory; what reading the model may say. That something cannot be held is a result.
pub fn support(request: &SupportRequest, world: &World<'_>) -> Result<SupportResult, InputError> {
    let options = &request.options;
    let (method, name) = checked(options)?;
    let structure = named("structure", &options.structure, &Structure::NAMED)?.0;
    let start = world.clock.now();
    let loaded = load_aloud(&request.model, world)?;
    let parts = standing(loaded.model.parts.into_iter().map(|part| (part.name, part.mesh)), options);
    let meshes: Vec<&TriangleMesh<Slot>> = parts.iter().map(|(_, mesh)| mesh).collect();
    let overhang = Angle::from_deg(options.overhang_deg);
    let graph = Graph::of(grid(&meshes, options)?, &meshes, overhang);
    let planning = world.clock.now();
    let bar = world.progress.begin("supports", 100);
    let planned = plan(&graph, method, options.capacity, options.node_capacity, options.seed, &mut |done| bar.at(done));
    drop(bar);
    let seconds_plan = (world.clock.now() - planning).as_secs_f64();
    let brace_mm = options.form.brace_mm;
    let stiff = if brace_mm > 0.0 {
        braced(&graph, &planned.flow, brace_mm)
    } else {
        Braced { flow: planned.flow.clone(), struts: 0, unbraced: 0 }
    };
    let built = built(structure, &graph, &stiff.flow, &meshes, options);
    let cover = held(&built.mesh, &graph, &meshes, overhang, options.gap_mm);
    let done = SupportResult {
        count: graph.count(),
        method: name,
        built,
        cover,
        bare: bare(&graph),
        longest_free_mm: longest_free_mm(&graph, &stiff.flow),
        struts: stiff.struts,
        unbraced: stiff.unbraced,
        seconds_plan,
        seconds: (world.clock.now() - start).as_secs_f64(),
        planned,
        graph,
        parts,
    };
    if !done.bare.is_empty() && done.why_not().is_none() {
        world.progress.warning(&format!("{}; it stays unsupported", done.unreached()));
    }
    if done.unbraced > 0 {
        let (free, most) = (done.longest_free_mm, options.form.brace_mm);
        world.progress.warning(&format!(
            "{} {} unbraced over more than {most} mm (longest {free:.1} mm): no brace path found; try a smaller --step",
            counted(done.unbraced, "column"),
            if done.unbraced == 1 { "is" } else { "are" }
        ));
    }
    let over = done.planned.tally.over_capacity;
    if over > 0 {
        let limit = options.capacity;
        world.progress.warning(&format!(
            "{over} arcs and nodes exceed the column limit ({limit} per arc, --capacity); otherwise some overhang would be unsupported"
        ));
    }
    Ok(done)
}

/// The supports as closed meshes: sheets keep the gap on all sides and lean out beside walls; what else stands there follows its arcs.
fn built(
    structure: Structure,
    graph: &Graph,
    flow: &Flow,
    meshes: &[&TriangleMesh<Slot>],
    options: &SupportOptions,
) -> Built {
    let wall_mm = wall_mm(options);
    let SupportForm { roof_mm, roof_pitch_mm, .. } = options.form;
    let pitch_mm = roof_pitch_mm.unwrap_or(ROOF_WALLS * wall_mm);
    if structure != Structure::X {
        let roof = (roof_mm > 0.0).then_some(Bars { high_mm: roof_mm, pitch_mm });
        let how = Build { structure, wall_mm, gap_mm: options.gap_mm, roof };
        return build(graph, flow, &Ceiling::of(graph, meshes), &how);
    }
    let layer_mm = layer_mm(options.gap_mm);
    let layers = (roof_mm / layer_mm - 1e-6).ceil() as usize;
    let roof = (roof_mm > 0.0).then_some(Roof { layers, pitch_mm });
    let clearance = Clearance { line_mm: wall_mm, gap_mm: options.gap_mm, clear: Clear::Around };
    let (low, top) = (graph.grid.origin.z, meshes.iter().map(|mesh| mesh.bounds().max.z).fold(0.0, f64::max));
    let edge = |k: usize| low + k as f64 * layer_mm;
    let spans: Vec<[f64; 2]> = (0..((top - low) / layer_mm).ceil() as usize).map(|k| [edge(k), edge(k + 1)]).collect();
    let cuts = Cuts::of(&Around { meshes, carrying: meshes.len(), keels: &Keels::default() }, spans, clearance);
    let made = |touch_every| sheets(&lines(graph, flow, &cuts, &Laying { on_part: false, roof, touch_every }), wall_mm);
    let sheets = made(options.touch_every);
    // Where ends draw back from their neighbours upper sides are free that hold nothing.
    let contact_mm2 = if options.touch_every > 1 { made(1).contact_mm2 } else { sheets.contact_mm2 };
    Built {
        volume_mm3: sheets.mesh.volume(),
        mesh: sheets.mesh,
        chains: sheets.count - sheets.bars,
        bars: sheets.bars,
        plate_mm2: sheets.plate_mm2,
        contact_mm2,
    }
}

/// The height in which sheets follow the part, mm: some of them fit into the gap.
fn layer_mm(gap_mm: f64) -> f64 {
    if gap_mm < 0.5 * LAYER_MM { LAYER_MM } else { gap_mm / (gap_mm / LAYER_MM).round().min(MOST_IN_GAP) }
}

fn checked(options: &SupportOptions) -> Result<(FlowMethod, &'static str), BadSetting> {
    BadSetting::within("step", options.step_mm, " mm", [0.05, 100.0])?;
    BadSetting::within("overhang", options.overhang_deg, " deg", [1.0, 89.0])?;
    BadSetting::within("capacity", f64::from(options.capacity), "", [1.0, 1000.0])?;
    BadSetting::within("node-capacity", options.node_capacity.map_or(1.0, f64::from), "", [1.0, 1000.0])?;
    BadSetting::within("wall", wall_mm(options), " mm", [0.01, options.step_mm])?;
    BadSetting::within("touch-every", f64::from(options.touch_every), "", [1.0, 1000.0])?;
    if options.touch_every > 1 {
        if options.structure != "x" {
            let text = options.touch_every.to_string();
            let wanted = "needs --structure x, whose sheets touch their neighbours; other columns stand by themselves";
            return Err(BadSetting::Words { name: "touch-every", text, wanted: wanted.to_owned() });
        }
        BadSetting::within("wall", wall_mm(options), " mm", [0.01, APART_WALL * options.step_mm])?;
    }
    BadSetting::within("gap", options.gap_mm, " mm", [0.0, 5.0])?;
    options.form.check(options.step_mm, options.step_mm)?;
    if options.form.roof_pitch_mm.is_some_and(|pitch| pitch < wall_mm(options)) {
        BadSetting::within(
            "roof-pitch",
            options.form.roof_pitch_mm.unwrap_or_default(),
            " mm",
            [wall_mm(options), 10.0],
        )?;
    }
    for length in options.space_mm.into_iter().flatten() {
        BadSetting::within("space", length, " mm", [options.step_mm, 1e5])?;
    }
    BadSetting::direction("up", options.up.into())?;
    named("method", &options.method, &FlowMethod::NAMED)
}

/// Whether model and supports go into a file of this name, or supports alone.
///
/// # Errors
///
/// [`BadSetting::Ending`] for one that ends neither with `.3mf` nor with `.stl`.
pub fn is_3mf(path: &Path) -> Result<bool, BadSetting> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    match ending.to_str() {
        Some("3mf") => Ok(true),
        Some("stl") => Ok(false),
        _ => Err(BadSetting::Ending { name: "output", path: path.to_owned(), allowed: ".stl or .3mf" }),
    }
}

fn wall_mm(options: &SupportOptions) -> f64 {
    let most = if options.touch_every > 1 { APART_WALL } else { 0.5 };
    options.wall_mm.unwrap_or(WALL_MM.min(most * options.step_mm))
}

fn named<T: Copy>(
    name: &'static str,
    given: &str,
    known: &[(&'static str, T)],
) -> Result<(T, &'static str), BadSetting> {
    let found = known.iter().find(|(known, _)| *known == given).map(|&(known, it)| (it, known));
    let near = || nearest(given, known.iter().map(|(known, _)| *known)).map_or("", |(_, near)| near).to_owned();
    found.ok_or_else(|| BadSetting::Method { name, given: given.to_owned(), nearest: near() })
}

/// The parts turned together so that `up` is up, on the ground or at their own height.
fn standing(
    parts: impl Iterator<Item = (String, TriangleMesh)>,
    options: &SupportOptions,
) -> Vec<(String, TriangleMesh<Slot>)> {
    let turn = turned_by(&options.up.normalize());
    let turned = |mesh: &TriangleMesh| -> Vec<Vec3> { mesh.vertices().iter().map(|v| turn * v).collect() };
    let parts: Vec<(String, Vec<Vec3>, Vec<[u32; 3]>)> =
        parts.map(|(name, mesh)| (name, turned(&mesh), mesh.facets().to_vec())).collect();
    let low = parts.iter().flat_map(|(_, vertices, _)| vertices).map(|v| v.z).fold(f64::INFINITY, f64::min);
    let lift = Vec3::z() * if options.keep_z { 0.0 } else { -low };
    let stand = |(name, vertices, facets): (String, Vec<Vec3>, _)| {
        (name, TriangleMesh::new(vertices.into_iter().map(|v| v + lift).collect(), facets))
    };
    parts.into_iter().map(stand).collect()
}

/// The grid over the space that was asked for, or over the model and some steps around it.
fn grid(meshes: &[&TriangleMesh<Slot>], options: &SupportOptions) -> Result<Grid, BadSetting> {
    let bounds = meshes.iter().fold(Bounds::EMPTY, |all, mesh| all.union(&mesh.bounds()));
    let step = options.step_mm;
    let Some(space) = options.space_mm else { return grid_over(meshes, "step", step) };
    let origin = Vec3::zeros();
    let end = origin + Vec3::from(space);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (low, high) = (bounds.min[axis], bounds.max[axis]);
        if low < origin[axis] - OUTSIDE_MM || high > end[axis] + OUTSIDE_MM {
            return Err(BadSetting::OutsideSpace { axis: name, low, high, space: [origin[axis], end[axis]] });
        }
    }
    fitting(origin, space, "step", step)
}
