//! One closed solid cut by planes into parts that print without supports, each along its own direction.
//!
//! ```text
//! R_0 = the model;  cut k takes K_k = solids of R_(k-1) beyond a plane (d_k, c_k);  R_k = what is left
//! print order: R_m along +z, then K_m .. K_1, each along its d_k, standing on its cap, which lies wholly on R_k
//! ```
//!
//! A post with an arm, cut in two:
//!
//! ```
//! use trunnion::assembly::join;
//! use trunnion::geom::Bounds;
//! use trunnion::mesh::{Model, TriangleMesh};
//! use trunnion::split::{CutOptions, NoHead, split};
//!
//! let cuboid = |min: [f64; 3], max: [f64; 3]| TriangleMesh::cuboid(&Bounds { min: min.into(), max: max.into() });
//! // A post of 30 mm with an arm of 40 mm at its top, one solid (mm, the file's own frame, +z up).
//! let post = ("post".to_owned(), cuboid([0.0, 0.0, 0.0], [10.0, 10.0, 30.0]));
//! let arm = ("arm".to_owned(), cuboid([10.0, 0.0, 20.0], [50.0, 10.0, 30.0]));
//! let solid = join(&Model::from_parts(vec![post, arm]))?.ok_or("they touch")?.parts.remove(0).1;
//!
//! // A table that tilts to 90 degrees, under a head that is nowhere in the way.
//! let machine = NoHead { most_tilt: 90_f64.to_radians() };
//! let cut = split(&solid, &machine, &CutOptions::default(), &mut |_depth| true);
//! // The arm comes off by one cut and is printed along +x.
//! assert!(cut.printable && cut.cuts.len() == 1);
//! assert!(cut.parts[1].up.x > 0.999);
//! assert!((cut.seam_mm2() - 100.0).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Minimised, one after the other: places that begin in the air and flat downward ridges; the area that needs support; setups;
//! cuts; seams. The search is a beam over planes (`search.rs`) whose scores come from sweeps (`sweep.rs`), after C. Wu, C. Dai,
//! G. Fang, Y.-J. Liu, C. C. L. Wang, *General support-effective decomposition for multi-directional 3-D printing* (2020), with
//! what that lacks: components, beginnings, ridges, caps of any size, and a machine that is asked ([`CutMachine`]).
//!
//! Lengths mm, areas mm², directions unit, all in the model file's frame; +z is up on the table, whose surface is the model's
//! lowest z. This room must not know slicers or toolpaths.

mod candidates;
mod clip;
mod machine;
mod measure;
mod pedestal;
mod promise;
mod refine;
mod rules;
mod search;
mod state;
mod surface;
mod sweep;
#[cfg(test)]
mod tests;

use crate::geom::{Angle, Bounds, Object, Vec3};
use crate::mesh::{Model, TriangleMesh};
use crate::overhang::{BRIDGE_MM, OverhangRule, TOLERATE_MM2};
pub use machine::{CutMachine, NoHead};
use measure::{MeasureRules, Measured, NOTHING_MM2, PieceNeeds};
pub use rules::Against;
use search::{BeamSearch, SearchFound, SearchGround};
use state::SplitState;
pub use surface::Plane;
use surface::Surface;

/// How to cut.
#[derive(Clone, Debug)]
pub struct CutOptions {
    /// Facets up to this angle from the vertical need no support, whatever layers say.
    pub overhang: Angle,
    /// Slopes up to this angle are fine in layers; `None`: as lines of that width and layers are ([`OverhangRule::practised`]).
    pub steepest: Option<Angle>,
    /// Whether layers may droop.
    pub droops: bool,
    /// A layer, mm.
    pub layer_mm: f64,
    /// So far a line may hang free at its end, mm.
    pub span_mm: f64,
    /// So far it may reach between two ends on material, mm.
    pub bridge_mm: f64,
    /// Width of a line, mm.
    pub line_mm: f64,
    /// What a connected patch of a part's layers may have that nothing carries, mm².
    pub tolerate_mm2: f64,
    /// Most cuts.
    pub max_cuts: usize,
    /// What may still need support in the end, mm²; half a square millimetre a part passes as rounding.
    pub allow_mm2: f64,
    /// Whether everything beyond a plane goes, so that the head never has to pass what is left.
    pub strict: bool,
    /// Where no seam may come.
    pub no_cut: Vec<Bounds>,
    /// Cuts that are made first, in this order, whatever they gain; the search cuts what they leave.
    pub pinned: Vec<PinnedCut>,
    /// Height of a part below the model that is printed first, mm; 0 for none.
    pub pedestal_mm: f64,
    /// States that are kept from level to level.
    pub beam: usize,
    /// What the cuts may cost: what costs more is not searched. `None`: whatever it takes.
    pub budget: Option<CutBudget>,
    /// So many cuts are really tried; then the search ends with the best so far.
    pub tries: u64,
    /// Whether only facets count, and neither places that begin in the air nor flat ridges: for figures that are to be compared with
    /// those of methods that do not know these.
    pub only_facets: bool,
}

impl Default for CutOptions {
    fn default() -> Self {
        Self {
            overhang: Angle::from_deg(45.0),
            steepest: None,
            droops: true,
            layer_mm: 0.2,
            span_mm: 2.0,
            bridge_mm: BRIDGE_MM,
            line_mm: 0.45,
            tolerate_mm2: TOLERATE_MM2,
            max_cuts: 12,
            allow_mm2: 0.0,
            strict: false,
            no_cut: Vec::new(),
            pinned: Vec::new(),
            pedestal_mm: 0.0,
            beam: 4,
            budget: None,
            tries: u64::MAX,
            only_facets: false,
        }
    }
}

/// What is so far above its cap is in a piece, mm; pieces are higher than a hundred times this.
const WITHIN_MM: f64 = 0.01;

/// A cut that somebody has decided.
#[derive(Clone, Debug, PartialEq)]
pub struct PinnedCut {
    /// Where.
    pub plane: Plane,
    /// Of the solids beyond the plane those that one of these points lies in go; all of them where there is no point.
    pub points: Vec<Vec3>,
}

/// What cuts may cost where another way to print the model is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutBudget {
    /// What a direction beyond the first costs, minutes.
    pub setup_min: f64,
    /// What a mm² of seam costs, minutes.
    pub seam_min_per_mm2: f64,
    /// All of them together cost less than this, minutes.
    pub most_min: f64,
}

impl CutBudget {
    /// Whether so many distinct directions and such seams are within it.
    pub fn affords(&self, setups: usize, seam_mm2: f64) -> bool {
        self.setup_min * setups.saturating_sub(1) as f64 + self.seam_min_per_mm2 * seam_mm2 < self.most_min
    }
}

/// What something needs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Unsupported {
    /// Facets beyond the overhang that stand on nothing, mm².
    pub area_mm2: f64,
    /// Places that begin in the air.
    pub beginnings: usize,
    /// Downward ridges too flat for lines to hang on.
    pub ridges: usize,
}

impl From<PieceNeeds> for Unsupported {
    fn from(needs: PieceNeeds) -> Self {
        Self { area_mm2: needs.area_mm2 + 0.0, beginnings: needs.beginnings, ridges: needs.ridges }
    }
}

/// A part of the cut model.
#[derive(Clone, Debug)]
pub struct CutPart {
    /// Closed, mm.
    pub mesh: TriangleMesh<Object>,
    /// What it is printed along.
    pub up: Vec3,
    /// The cut that took it, a place in [`Split::cuts`]; `None` for what stays on the table.
    pub cut: Option<usize>,
    /// Whether it is a pedestal and no piece of the model.
    pub pedestal: bool,
    /// What it still needs.
    pub needs: Unsupported,
}

/// A cut.
#[derive(Clone, Debug)]
pub struct CutMade {
    /// Where.
    pub plane: Plane,
    /// The parts it took, places in [`Split::parts`].
    pub parts: Vec<usize>,
    /// A point in each of them, mm: with these the cut can be pinned.
    pub points: Vec<Vec3>,
    /// Its caps, mm².
    pub seam_mm2: f64,
    /// By how much what is left needs less, mm².
    pub gain_mm2: f64,
}

impl CutMade {
    /// Why it was made, in words.
    pub fn reason(&self) -> String {
        format!("the rest needs support for {:.1} mm2 less", self.gain_mm2)
    }
}

/// A place that needs support.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchLeft {
    /// The part.
    pub part: usize,
    /// mm².
    pub area_mm2: f64,
    /// Its middle, mm.
    pub at: Vec3,
}

/// A model in parts.
#[derive(Clone, Debug)]
pub struct Split {
    /// In the order of printing: what stays on the table, then the last cut's first.
    pub parts: Vec<CutPart>,
    /// In the order of cutting.
    pub cuts: Vec<CutMade>,
    /// What the model needs as it is.
    pub before: Unsupported,
    /// What all parts together still need.
    pub after: Unsupported,
    /// Where, the largest first.
    pub left: Vec<PatchLeft>,
    /// Whether nothing is needed beyond what is allowed, and the machine has a plan for the parts.
    pub printable: bool,
    /// Pieces of less than a hundredth of a cubic millimetre that cuts made and that were left out, mm³ together.
    pub crumbs_mm3: f64,
    /// Ways to cut after which nothing needed support, but for which the machine has no plan.
    pub unplanned: usize,
    /// What was against the cuts that were tried but not made, with their number.
    pub refused: Vec<(Against, usize)>,
    /// How many cuts were tried when the search was stopped; `None` where it came to its end.
    pub stopped: Option<u64>,
    /// The first pinned cut that cannot be made, a place among them, and what is against it; those before it are made, and no others.
    pub unpinned: Option<(usize, Against)>,
}

impl Split {
    /// All seams, mm².
    pub fn seam_mm2(&self) -> f64 {
        // An empty sum is -0.
        self.cuts.iter().map(|cut| cut.seam_mm2).sum::<f64>() + 0.0
    }

    /// Distinct directions that are printed along.
    pub fn setups(&self) -> usize {
        let mut known: Vec<Vec3> = Vec::new();
        for part in &self.parts {
            if known.iter().all(|k| (k - part.up).norm() > 1e-9) {
                known.push(part.up);
            }
        }
        known.len()
    }

    /// The parts of a solid of that name, as `mesh` writes them.
    pub fn named(&self, solid: &str) -> Vec<(String, TriangleMesh<Object>)> {
        let name = |id: usize| self.name_of(solid, id);
        self.parts.iter().enumerate().map(|(id, part)| (name(id), part.mesh.clone())).collect()
    }

    /// What part `id` of a solid of that name is called: as that where it is what was left of it, else after the cut that took it.
    pub fn name_of(&self, solid: &str, id: usize) -> String {
        let bare = |p: usize| self.parts[p].cut.is_none() && !self.parts[p].pedestal;
        let first = (0..self.parts.len()).find(|&p| bare(p));
        if first == Some(id) { solid.to_owned() } else { format!("{solid} {}", self.piece(id)) }
    }

    /// What part `id` is called among the others: `base`, or the cut that took it.
    pub fn piece(&self, id: usize) -> String {
        let kind = |p: usize| (self.parts[p].cut, self.parts[p].pedestal);
        let siblings: Vec<usize> = (0..self.parts.len()).filter(|&p| kind(p) == kind(id)).collect();
        if self.parts[id].pedestal {
            return "pedestal".to_owned();
        }
        let stem = self.parts[id].cut.map_or("base".to_owned(), |cut| format!("cut {}", cut + 1));
        match siblings.iter().position(|&p| p == id) {
            Some(place) if place > 0 => format!("{stem}-{}", place + 1),
            _ => stem,
        }
    }

    /// The directions to print along, by part.
    pub fn ups(&self) -> Vec<Vec3> {
        self.parts.iter().map(|part| part.up).collect()
    }
}

/// A solid cut by one plane: what is left, and the solids beyond, all closed; both sides share the seam's vertices bit for bit.
#[derive(Clone, Debug)]
pub struct Parted {
    /// Before the plane; without facets where all lay beyond.
    pub rest: TriangleMesh<Object>,
    /// Beyond.
    pub pieces: Vec<TriangleMesh<Object>>,
    /// The area of each connected patch of the seam, mm².
    pub patches_mm2: Vec<f64>,
}

/// Cuts `model` by `plane` and takes everything beyond; `None` where the surface crosses itself in the plane.
pub fn parted(model: &TriangleMesh<Object>, plane: &Plane) -> Option<Parted> {
    let clip::Clipped { rest, pieces, patches_mm2 } =
        clip::cut(&Surface::of(model), plane, &clip::Taken::All, 1).ok()?;
    let closed = rest.is_closed() && pieces.iter().all(Surface::is_closed);
    let meshes = || pieces.iter().map(Surface::mesh).collect();
    closed.then(|| Parted { rest: rest.mesh(), pieces: meshes(), patches_mm2 })
}

/// Told again and again how many cuts deep a search is; says whether it goes on, or is to end with the best so far.
pub type CutWatch<'a> = dyn FnMut(usize) -> bool + 'a;

/// Cuts `model`, one closed solid, until nothing needs support on `machine`, or as well as `options` and `watch` allow.
///
/// A model that needs nothing comes back whole. See [`Split::printable`] for whether it worked.
pub fn split(
    model: &TriangleMesh<Object>,
    machine: &dyn CutMachine,
    options: &CutOptions,
    watch: &mut CutWatch<'_>,
) -> Split {
    Splitter::new(model, |up| machine.reaches(up), options.clone()).split(machine, options.pedestal_mm, watch)
}

/// A solid that is cut for one machine, standing on pedestals of several heights: what is found out on one of them that does not
/// depend on the height is not found out again on the next.
pub struct Splitter {
    ground: SearchGround,
    /// Heights that were tried, mm.
    tried: Vec<f64>,
}

impl Splitter {
    /// `model` is one closed solid, `reaches` says whether the machine's axes bring a direction upright; the pedestal of `options`
    /// does not count.
    pub fn new(model: &TriangleMesh<Object>, reaches: impl Fn(&Vec3) -> bool, options: CutOptions) -> Self {
        let rules = MeasureRules {
            sine: options.overhang.rad().sin(),
            layer_mm: options.layer_mm,
            span_mm: options.span_mm,
            bridge_mm: options.bridge_mm,
            table_mm: model.bounds().min.z,
            layers: OverhangRule {
                overhang: options
                    .steepest
                    .unwrap_or_else(|| OverhangRule::practised(options.layer_mm, options.line_mm)),
                layer_mm: options.layer_mm,
                line_mm: options.line_mm,
                bridge_mm: options.bridge_mm,
                tolerate_mm2: options.tolerate_mm2,
                droops: options.droops,
            },
            faults: !options.only_facets,
        };
        Self { ground: SearchGround::new(model, reaches, options, rules), tried: Vec::new() }
    }

    /// As [`split`], on a pedestal of this height, mm, or on none: `machine` knows how high the model stands, and differs in nothing
    /// else from call to call.
    pub fn split(&mut self, machine: &dyn CutMachine, pedestal_mm: f64, watch: &mut CutWatch<'_>) -> Split {
        let place = self.tried.iter().position(|mm| mm.to_bits() == pedestal_mm.to_bits());
        let number = place.unwrap_or(self.tried.len());
        if place.is_none() {
            self.tried.push(pedestal_mm);
        }
        let (ground, rules) = (&self.ground, &self.ground.rules);
        let first = ground.first_state();
        let whole = &first.rest;
        let before = whole.needs(&Vec3::z(), None, rules);
        let pedestal =
            Some(pedestal_mm).filter(|mm| *mm > 0.0).and_then(|mm| pedestal::pedestal(whole, mm, rules.layers.line_mm));
        let planned = |state: &SplitState| {
            let (split, layered) = assembled(state, before, pedestal.as_ref(), rules);
            let supported: Vec<usize> =
                (0..split.parts.len()).filter(|&p| split.parts[p].needs.area_mm2 > NOTHING_MM2).collect();
            machine.plans(&Model::from_parts(split.named("solid")), &split.ups(), &supported, &layered)
        };
        let search = BeamSearch { ground, machine, number: number as u64, start: first };
        let SearchFound { state, printable, unplanned, refused, stopped, unpinned } =
            search.on_what_is_pinned(&planned, watch);
        Split {
            printable,
            unplanned,
            refused: refused.into_iter().collect(),
            stopped: stopped.then(|| ground.tried()),
            unpinned,
            ..assembled(&state, before, pedestal.as_ref(), rules).0
        }
    }
}

/// A point of a piece, a hair above the largest facet of its cap.
fn within(piece: &Surface, plane: &Plane) -> Vec3 {
    let is_cap = |f: &usize| piece.corners(*f).iter().all(|p| plane.height(p).abs() < 10.0 * clip::ON_PLANE_MM);
    let area = |f: usize| piece.area_vector(f).norm();
    let largest = (0..piece.facets.len()).filter(is_cap).max_by(|a, b| area(*a).total_cmp(&area(*b)));
    let middle = largest.map_or_else(Vec3::zeros, |f| piece.corners(f).iter().sum::<Vec3>() / 3.0);
    middle + plane.normal * WITHIN_MM
}

/// The parts of a state, and those of which every layer is known to lie on something, with nothing that begins between two.
fn assembled(
    state: &SplitState,
    before: PieceNeeds,
    pedestal: Option<&Surface>,
    rules: &MeasureRules,
) -> (Split, Vec<usize>) {
    let mut parts = Vec::new();
    let mut layered = Vec::new();
    let mut left = Vec::new();
    parts.extend(pedestal.map(|p| CutPart {
        mesh: p.mesh(),
        up: Vec3::z(),
        cut: None,
        pedestal: true,
        needs: Unsupported::default(),
    }));
    let mut add = |surface: &Surface, up: Vec3, cut: Option<usize>, found: PieceNeeds, by_layers: bool| {
        if by_layers && found.faults() == 0 {
            layered.push(parts.len());
        }
        let needs = if by_layers { PieceNeeds::default() } else { found };
        if needs.area_mm2 > 0.0 {
            let measured = Measured::of(surface.clone(), rules);
            let cap = cut.map(|k| state.steps[k].cap);
            let counts = |f: &usize| measured.is_risky(*f, &up, rules) && !measured.stands(*f, cap);
            let risky: Vec<u32> = (0..measured.area.len()).filter(counts).map(|f| f as u32).collect();
            for patch in measured.patches(&risky) {
                let area_mm2: f64 = patch.iter().map(|&f| measured.area[f as usize]).sum();
                let middle = |f: usize| measured.surface.corners(f).iter().sum::<Vec3>() / 3.0;
                let moment: Vec3 = patch.iter().map(|&f| middle(f as usize) * measured.area[f as usize]).sum();
                left.push(PatchLeft { part: parts.len(), area_mm2, at: moment / area_mm2.max(f64::MIN_POSITIVE) });
            }
        }
        parts.push(CutPart { mesh: surface.mesh(), up, cut, pedestal: false, needs: needs.into() });
        parts.len() - 1
    };
    let solids = rules::solids(&state.rest.surface);
    for solid in &solids {
        let (needs, by_layers) = if let [_] = solids[..] {
            (state.left(), !state.left().is_nothing() && state.rest_passes(rules))
        } else {
            let measured = Measured::of(solid.clone(), rules);
            let needs = measured.needs(&Vec3::z(), None, rules);
            (needs, !needs.is_nothing() && measured.passes(rules))
        };
        add(solid, Vec3::z(), None, needs, by_layers);
    }
    let mut cuts: Vec<CutMade> = state
        .steps
        .iter()
        .map(|s| CutMade {
            plane: s.plane,
            parts: Vec::new(),
            points: s.pieces.iter().map(|piece| within(piece, &s.plane)).collect(),
            seam_mm2: s.seam_mm2,
            gain_mm2: s.gain_mm2,
        })
        .collect();
    for (k, step) in state.steps.iter().enumerate().rev() {
        let by_layers = |i: usize| !step.needs[i].is_nothing() && step.passes(i, rules);
        let pieces = step.pieces.iter().enumerate();
        cuts[k].parts =
            pieces.map(|(i, piece)| add(piece, step.plane.normal, Some(k), step.needs[i], by_layers(i))).collect();
    }
    left.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2));
    let after = parts.iter().fold(Unsupported::default(), |sum, p| Unsupported {
        area_mm2: sum.area_mm2 + p.needs.area_mm2,
        beginnings: sum.beginnings + p.needs.beginnings,
        ridges: sum.ridges + p.needs.ridges,
    });
    let crumbs_mm3 = state.steps.iter().map(|s| s.crumbs_mm3).sum();
    let split = Split {
        parts,
        cuts,
        before: before.into(),
        after,
        left,
        printable: false,
        crumbs_mm3,
        unplanned: 0,
        refused: Vec::new(),
        stopped: None,
        unpinned: None,
    };
    (split, layered)
}
