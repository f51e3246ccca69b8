//! Orientations of a model's parts, each by itself: by one or several objectives, with bounds where a method proves them.

mod asked;
mod error;
mod surfaces;

use std::ops::RangeInclusive;

use crate::geom::{Object, Slot, Vec3};
use crate::input::{BadSetting, MachineSource, ModelSource};
use crate::mesh::{TriangleMesh, stl_binary_parts, threemf};
use crate::orient::{
    Facets, FirstLayer, Found, Height, Minimum, Objective, ObjectiveSettings, PRINTABLE, Process, Recommendation,
    Staircase, SupportVolumeColumn, overhang_area, to_angles, turned,
};
use crate::pictures::{Painted, standing};
use crate::view::{Dip, Drawing, Landscape};
use crate::world::World;
use asked::OrientAsked;
pub use error::OrientError;
use surfaces::{chosen, meshes};

/// A model, and how to look for orientations of its parts.
#[derive(Clone, Debug)]
pub struct OrientRequest {
    /// The model. An open surface is taken as one part where no objective asks for a volume.
    pub model: ModelSource,
    /// Which parts.
    pub parts: PartChoice,
    /// Whether more than one part is refused, since what is to be made of the result is of one.
    pub only_one: bool,
    /// How.
    pub options: OrientOptions,
}

/// Which of a model's parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PartChoice {
    /// Each by itself.
    Each,
    /// All together as one.
    Whole,
    /// Those of the numbers in the ranges.
    Numbered(Vec<RangeInclusive<usize>>),
}

/// How to look for orientations; the default is what the command does without flags.
#[derive(Clone, Debug, PartialEq)]
pub struct OrientOptions {
    /// Names of objectives, or weighted sums of such.
    pub objectives: Vec<String>,
    /// The search.
    pub method: String,
    /// Most evaluations for one objective; `None`: the method's own.
    pub budget: Option<usize>,
    /// Seed of the methods that draw numbers.
    pub seed: u64,
    /// Surfaces up to this angle from the vertical need no support.
    pub overhang_deg: f64,
    /// Layer height of printable, staircase and alexander; `None`: the machine's, else 0.2 mm.
    pub layer_mm: Option<f64>,
    /// Whose process `printable` is priced by; `None`: the defaults of profiles.
    pub machine: Option<MachineSource>,
    /// A pose that `printable` prices beside its own, and that is compared: any length but 0, the file's frame.
    pub up: Option<[f64; 3]>,
    /// Width of the columns that support volumes are measured by; `None`: half a millimetre, or a 200th of a part longer than 100 mm.
    pub resolution_mm: Option<f64>,
    /// Steepness `k` of the smoothed steps of support-volume, interface-area and support-volume-convex-smooth.
    pub smooth_k: f64,
    /// Weight `w` of the lowest points in the same objectives, 1/mm.
    pub smooth_w: f64,
    /// In the same objectives, surfaces that face up carry supports from this angle from the vertical on.
    pub carrying_deg: f64,
    /// Only directions that lay at least this much flat on the bed.
    pub contact_mm2: Option<f64>,
    /// Whether the part as it lies is compared with each best.
    pub compare: bool,
}

impl Default for OrientOptions {
    fn default() -> Self {
        let usual = ObjectiveSettings::default();
        Self {
            objectives: vec![PRINTABLE.to_owned()],
            method: "certified".to_owned(),
            budget: None,
            seed: 1,
            overhang_deg: 45.0,
            layer_mm: None,
            machine: None,
            up: None,
            resolution_mm: None,
            smooth_k: usual.k,
            smooth_w: usual.w,
            carrying_deg: usual.carrying.deg(),
            contact_mm2: None,
            compare: false,
        }
    }
}

/// One objective's result for one part.
#[derive(Clone, Debug)]
pub struct Oriented {
    /// The objective, as it calls itself.
    pub objective: String,
    /// The search.
    pub method: &'static str,
    /// The minima, best first, at least one; the bound.
    pub found: Found,
    /// Why there is no lower bound, where there is none, or what it leaves out.
    pub unproved: Option<String>,
    /// Of `printable`: its recommendation, and by which process it was priced.
    pub recommendation: Option<(Recommendation, Process)>,
    /// Of a volume by columns: the best direction's by columns four times finer.
    pub finer: Option<f64>,
    /// Values nearer than this are one for a printer.
    pub tie: f64,
    /// What it took.
    pub seconds: f64,
}

/// Minima whose values agree to this, relative, are the same: the gap to which the best is proved.
const SAME_VALUE: f64 = 1e-6;
/// A best value is called global where the lower bound comes as near as this, relative.
const PROVED: f64 = 1e-2;

impl Oriented {
    /// The best minimum.
    pub fn best(&self) -> &Minimum {
        &self.found.minima[0]
    }

    /// Whether no minimum that was found is better by more than a tie.
    pub fn is_best(&self, minimum: &Minimum) -> bool {
        let best = self.best().value;
        minimum.value <= best + (SAME_VALUE * best.abs()).max(self.tie)
    }

    /// Whether a lower bound comes within a hundredth of the best value, or within a tie.
    pub fn is_proved(&self) -> bool {
        let best = self.best().value;
        self.found.lower_bound.is_some_and(|bound| best - bound <= (PROVED * best.abs()).max(self.tie))
    }

    /// `global` for a best minimum of which a lower bound proves it, `stopped` for one whose search ended before it came to rest, else `local`.
    pub fn kind(&self, minimum: &Minimum) -> &'static str {
        match minimum.ended {
            _ if self.is_proved() && self.is_best(minimum) => "global",
            true => "local",
            false => "stopped",
        }
    }
}

/// One orientation in figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// `as it lies`, or the objective whose best it is.
    pub name: String,
    /// The direction that is up, the file's frame.
    pub up: Vec3,
    /// Column volume of the supports, mm³.
    pub support_mm3: f64,
    /// Overhanging area, mm².
    pub overhang_mm2: f64,
    /// Staircase error, mm⁴.
    pub staircase_mm4: f64,
    /// Height, mm.
    pub height_mm: f64,
    /// The footprint of the first layer, mm².
    pub contact_mm2: f64,
    /// How far it may be tipped before its centre of mass leaves the footprint's outline, degrees.
    pub tipping_deg: f64,
}

/// One part's results.
#[derive(Clone, Debug)]
pub struct OrientedPart {
    /// Its number.
    pub id: usize,
    /// Its surface, the file's frame, mm.
    pub mesh: TriangleMesh<Object>,
    /// In the order of the objectives.
    pub results: Vec<Oriented>,
    /// As it lies, the user's own pose, and the best of each result, where that was asked for.
    pub compared: Option<Vec<Compared>>,
}

/// What was found.
pub struct OrientResult {
    /// By part.
    pub parts: Vec<OrientedPart>,
    asked: OrientAsked,
}

impl OrientResult {
    /// The parts with their first objective's best direction up, on z = 0, as STL or 3MF; several lie beside each other along X, 5 mm
    /// apart, each from y = 0 on.
    pub fn upright(&self, as_3mf: bool) -> Vec<u8> {
        let mut meshes: Vec<(String, TriangleMesh<Slot>)> = Vec::new();
        let mut from = 0.0;
        for part in &self.parts {
            let mut mesh: TriangleMesh<Slot> = turned(&part.mesh, &part.results[0].best().up);
            if self.parts.len() > 1 {
                let bounds = mesh.bounds();
                let shift = Vec3::new(from - bounds.min.x, -bounds.min.y, 0.0);
                let points = mesh.vertices().iter().map(|v| v + shift).collect();
                mesh = TriangleMesh::new(points, mesh.facets().to_vec());
                from += bounds.size().x + BESIDE_MM;
            }
            meshes.push((format!("part-{}", part.id), mesh));
        }
        if as_3mf {
            let named: Vec<(String, &TriangleMesh<Slot>)> = meshes.iter().map(|(n, m)| (n.clone(), m)).collect();
            return threemf(&named);
        }
        stl_binary_parts(&meshes.iter().map(|(_, mesh)| mesh).collect::<Vec<_>>())
    }

    /// The first objective over all directions, its minima numbered.
    pub fn landscape(&self, part: &OrientedPart) -> Drawing {
        let (facets, first) = (Facets::of(&part.mesh), &part.results[0]);
        let objectives = self.asked.objectives(&facets);
        let objective = objectives[0].as_ref();
        let dip = |minimum: &Minimum| {
            let (alpha, beta) = to_angles(&minimum.up);
            let (kind, [x, y, z]) = (first.kind(minimum), <[f64; 3]>::from(minimum.up).map(tidy));
            let (alpha, beta, value) = (tidy(alpha.to_degrees()), tidy(beta.to_degrees()), figures(minimum.value));
            let text = format!("{value} ({kind}) with {x} {y} {z} up: alpha {alpha}, beta {beta} deg");
            Dip { up: minimum.up, best: first.is_best(minimum), text }
        };
        let across = ACROSS[usize::from(objective.proof().budget < QUICK)];
        let title = format!("{} of part {} by up direction; darker is lower", first.objective, part.id);
        let minima = first.found.minima.iter().map(dip).collect();
        Landscape { title, value: &|up| objective.value(&facets, up), across, minima }.drawing()
    }

    /// A part as its first objective would have it.
    pub fn view(&self, part: &OrientedPart) -> Drawing {
        let (facets, first) = (Facets::of(&part.mesh), &part.results[0]);
        let (best, up) = (first.best(), first.best().up);
        let overhang = self.asked.settings(&facets).overhang;
        let costs = self.asked.objectives(&facets)[0].by_facet(&facets, &up);
        let painted = costs.as_ref().map_or(Painted::Overhangs(overhang), |costs| Painted::Costs(costs, overhang));
        let ([x, y, z], value) = (<[f64; 3]>::from(up).map(tidy), figures(best.value));
        let hanging = overhang_area(&facets, &up, overhang);
        let said = format!("part {}: {} {value}, with {x} {y} {z} of the model pointing up", part.id, first.objective);
        let hangs = format!("{hanging:.1} mm2 overhang more than {} deg from the vertical", overhang.deg());
        standing(&facets, &up, painted, vec![format!("{said}; {hangs}")]).drawing()
    }
}

/// Values of a landscape across half of all directions, for quick objectives and for slow ones.
const ACROSS: [usize; 2] = [150, 44];
/// An objective that is asked more often than this when it is minimised is quick.
const QUICK: usize = 10_000;

/// Four decimals, without a zero's sign.
fn tidy(v: f64) -> f64 {
    (v * 1e4).round() / 1e4 + 0.0
}

/// Some six figures.
fn figures(value: f64) -> String {
    if value.abs() < 1e5 { tidy(value).to_string() } else { format!("{value:.0}") }
}

/// Between parts that are written beside each other.
const BESIDE_MM: f64 = 5.0;

/// Looks for orientations.
///
/// # Errors
///
/// [`InputError::Setting`](crate::input::InputError::Setting); [`OrientError::NoArea`] for a part without a surface;
/// [`OrientError::NeedsClosed`] and what else keeps the model from being read.
pub fn orient(request: &OrientRequest, world: &World<'_>) -> Result<OrientResult, OrientError> {
    let asked = OrientAsked::of(&request.options, world)?;
    let meshes = chosen(request, meshes(request, &asked, world)?)?;
    if request.only_one && meshes.len() != 1 {
        return Err(BadSetting::SeveralParts { count: meshes.len() }.into());
    }
    let bar = world.progress.begin("orienting", meshes.len() * asked.count());
    let mut parts: Vec<OrientedPart> = Vec::new();
    for (id, mesh) in meshes {
        let facets = Facets::of(&mesh);
        if facets.each.is_empty() {
            return Err(OrientError::NoArea { part: id, facets: mesh.facets().len() });
        }
        let mut results = Vec::new();
        for f in &asked.objectives(&facets) {
            results.push(asked.result(f.as_ref(), &facets, world)?);
            bar.at(parts.len() * asked.count() + results.len());
        }
        let compared = request.options.compare.then(|| compared(&facets, &results, &asked));
        parts.push(OrientedPart { id, mesh, results, compared });
    }
    drop(bar);
    Ok(OrientResult { parts, asked })
}

/// Columns of what is told are so many times finer than those of the search.
const FINER: f64 = 4.0;

fn finer(settings: &ObjectiveSettings) -> SupportVolumeColumn {
    SupportVolumeColumn { overhang: settings.overhang, resolution_mm: settings.resolution_mm / FINER }
}

/// The part as it lies, the user's own pose, and the best of each result.
fn compared(facets: &Facets, results: &[Oriented], asked: &OrientAsked) -> Vec<Compared> {
    let settings = asked.settings(facets);
    // Four times finer than the search: what its columns gain or lose along outlines is then a quarter.
    let column = finer(&settings);
    let row = |(name, up): (String, Vec3)| {
        let footing = FirstLayer::of(facets, facets.mass(), &up, settings.layer_mm);
        Compared {
            name,
            up,
            support_mm3: column.value(facets, &up),
            overhang_mm2: overhang_area(facets, &up, settings.overhang),
            staircase_mm4: Staircase { layer_mm: settings.layer_mm }.value(facets, &up),
            height_mm: Height.value(facets, &up),
            contact_mm2: footing.area_mm2,
            tipping_deg: footing.tipping_deg,
        }
    };
    let best = results.iter().map(|result| (result.objective.clone(), result.best().up));
    let given = [("as in the file".to_owned(), Some(Vec3::z())), ("yours".to_owned(), asked.up)];
    let given = given.into_iter().filter_map(|(name, up)| Some((name, up?)));
    given.chain(best).map(row).collect()
}
