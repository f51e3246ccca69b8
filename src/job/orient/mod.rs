//! Orientations of a model's parts, each by itself: by one or several objectives, with bounds where a method proves them.

mod asked;

use std::ops::RangeInclusive;

use super::{BadSetting, Error, ModelSource, World, load_model};
use crate::geom::{Object, Slot, Vec3};
use crate::mesh::{Fault, MeshError, ReadOptions, TriangleMesh, read_surface, stl_binary, threemf};
use crate::orient::{
    ContactArea, Facets, Found, Height, Minimum, Objective, Paint, Picture, Staircase, SupportVolumeColumn, landscape,
    overhang_area, turned, view,
};
use asked::OrientAsked;

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
    /// Layer height of staircase and alexander.
    pub layer_mm: f64,
    /// Width of the columns that support volumes are measured by.
    pub resolution_mm: f64,
    /// Only directions that lay at least this much flat on the bed.
    pub contact_mm2: Option<f64>,
    /// Whether the part as it lies is compared with each best.
    pub compare: bool,
}

impl Default for OrientOptions {
    fn default() -> Self {
        Self {
            objectives: vec!["staircase".to_owned()],
            method: "certified".to_owned(),
            budget: None,
            seed: 1,
            overhang_deg: 45.0,
            layer_mm: 0.2,
            resolution_mm: 0.5,
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
    /// Why there is no lower bound, where there is none.
    pub unproved: Option<String>,
    /// What it took.
    pub seconds: f64,
}

/// Minima whose values agree to this, relative, are the same: the gap to which the best is proved.
const SAME_VALUE: f64 = 1e-6;

impl Oriented {
    /// The best minimum.
    pub fn best(&self) -> &Minimum {
        &self.found.minima[0]
    }

    /// Whether no minimum that was found is better.
    pub fn is_best(&self, minimum: &Minimum) -> bool {
        let best = self.best().value;
        minimum.value <= best + SAME_VALUE * best.abs()
    }

    /// `global` for a best minimum, else `local`.
    pub fn kind(&self, minimum: &Minimum) -> &'static str {
        if self.is_best(minimum) { "global" } else { "local" }
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
    /// What lies flat on the bed, mm².
    pub contact_mm2: f64,
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
    /// As it lies, and the best of each result, where that was asked for.
    pub compared: Option<Vec<Compared>>,
}

/// What was found.
pub struct OrientResult {
    /// By part.
    pub parts: Vec<OrientedPart>,
    asked: OrientAsked,
}

impl OrientResult {
    /// A part with its first objective's best direction up, on z = 0, as STL or 3MF.
    pub fn upright(&self, part: &OrientedPart, as_3mf: bool) -> Vec<u8> {
        let mesh: TriangleMesh<Slot> = turned(&part.mesh, &part.results[0].best().up);
        if as_3mf { threemf(&[(format!("part-{}", part.id), &mesh)]) } else { stl_binary(&mesh) }
    }

    /// The first objective over all directions, its minima ringed.
    pub fn landscape(&self, part: &OrientedPart) -> Picture {
        landscape(self.asked.objectives[0].as_ref(), &Facets::of(&part.mesh), &part.results[0].found.minima)
    }

    /// A part as its first objective would have it.
    pub fn view(&self, part: &OrientedPart) -> Picture {
        let (facets, up) = (Facets::of(&part.mesh), part.results[0].best().up);
        let overhang = self.asked.settings.overhang;
        let costs = self.asked.objectives[0].by_facet(&facets, &up);
        let paint = costs.as_ref().map_or(Paint::Overhangs(overhang), |costs| Paint::Costs(costs, overhang));
        view(&facets, &up, paint)
    }
}

/// Looks for orientations.
///
/// # Errors
///
/// [`Error::Setting`]; [`Error::NoArea`] for a part without a surface; [`Error::NeedsClosed`] and what else keeps the model from
/// being read.
pub fn orient(request: &OrientRequest, world: &World<'_>) -> Result<OrientResult, Error> {
    let asked = OrientAsked::of(&request.options)?;
    let meshes = chosen(request, meshes(request, &asked, world)?)?;
    if request.only_one && meshes.len() != 1 {
        return Err(BadSetting::SeveralParts { count: meshes.len() }.into());
    }
    let bar = world.progress.begin("orienting", meshes.len() * asked.objectives.len());
    let mut parts: Vec<OrientedPart> = Vec::new();
    for (id, mesh) in meshes {
        let facets = Facets::of(&mesh);
        if facets.each.is_empty() {
            return Err(Error::NoArea { part: id, facets: mesh.facets().len() });
        }
        let mut results = Vec::new();
        for f in &asked.objectives {
            results.push(asked.result(f.as_ref(), &facets, world)?);
            bar.at(parts.len() * asked.objectives.len() + results.len());
        }
        let compared = request.options.compare.then(|| compared(&facets, &results, &asked));
        parts.push(OrientedPart { id, mesh, results, compared });
    }
    drop(bar);
    Ok(OrientResult { parts, asked })
}

type Numbered = (usize, TriangleMesh<Object>);

/// The model's closed parts; or its open surface as one, where no volume is asked for.
fn meshes(request: &OrientRequest, asked: &OrientAsked, world: &World<'_>) -> Result<Vec<Numbered>, Error> {
    let error = match load_model(&request.model, world) {
        Ok(loaded) if request.parts == PartChoice::Whole => {
            return Ok(vec![(0, joined(loaded.model.parts.iter().map(|part| &part.mesh)))]);
        }
        Ok(loaded) => return Ok(loaded.model.parts.into_iter().map(|part| (part.id, part.mesh)).collect()),
        Err(Error::Mesh(error)) => error,
        Err(other) => return Err(other),
    };
    let open = matches!(error.fault, Fault::Open { .. } | Fault::Winding { .. });
    if !open || request.options.compare {
        return Err(error.into());
    }
    if let Some(f) = asked.objectives.iter().find(|f| f.needs_closed()) {
        return Err(Error::NeedsClosed { source: Box::new(error), objective: f.name().to_owned() });
    }
    world.progress.warning(&format!("{error}: taken as one surface, since no volume is asked for"));
    surface(&request.model, world).map(|mesh| vec![(0, mesh)])
}

fn surface(model: &ModelSource, world: &World<'_>) -> Result<TriangleMesh<Object>, Error> {
    let bytes = model.source.bytes(world)?;
    let options = ReadOptions { unit: model.unit, repair: false };
    let read: Result<_, MeshError> = read_surface(&bytes, &model.source.name(), &options);
    Ok(read?)
}

/// All parts as one mesh.
fn joined<'a>(parts: impl Iterator<Item = &'a TriangleMesh<Object>>) -> TriangleMesh<Object> {
    let (mut vertices, mut facets) = (Vec::new(), Vec::new());
    for part in parts {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(part.vertices());
        facets.extend(part.facets().iter().map(|facet| facet.map(|i| i + first)));
    }
    TriangleMesh::new(vertices, facets)
}

fn chosen(request: &OrientRequest, mut parts: Vec<Numbered>) -> Result<Vec<Numbered>, BadSetting> {
    let PartChoice::Numbered(wanted) = &request.parts else { return Ok(parts) };
    let last = parts.len() - 1;
    if let Some(range) = wanted.iter().find(|range| *range.end() > last) {
        let model = request.model.source.name().into_owned();
        return Err(BadSetting::NoSuchPart { given: *range.end(), last, model });
    }
    parts.retain(|(id, _)| wanted.iter().any(|range| range.contains(id)));
    Ok(parts)
}

/// The part as it lies, and the best of each result.
fn compared(facets: &Facets, results: &[Oriented], asked: &OrientAsked) -> Vec<Compared> {
    let settings = &asked.settings;
    let column = SupportVolumeColumn { overhang: settings.overhang, resolution_mm: settings.resolution_mm };
    let row = |(name, up): (String, Vec3)| Compared {
        name,
        up,
        support_mm3: column.value(facets, &up),
        overhang_mm2: overhang_area(facets, &up, settings.overhang),
        staircase_mm4: Staircase { layer_mm: settings.layer_mm }.value(facets, &up),
        height_mm: Height.value(facets, &up),
        contact_mm2: 0.0 - ContactArea.value(facets, &up),
    };
    let best = results.iter().map(|result| (result.objective.clone(), result.best().up));
    std::iter::once(("as it lies".to_owned(), Vec3::z())).chain(best).map(row).collect()
}
