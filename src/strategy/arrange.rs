//! A model as it is to be printed: turned, set beside others, its parts made to meet. What was read is never changed: the arranged
//! model is one of its own, for whoever asked to write beside the output. Files are read once, whatever poses are tried: no pose is
//! dropped for a file that cannot be read again, and none is of other bytes than the next.

use std::f64::consts::PI;
use std::str::FromStr;

use super::error::StrategyError;
use crate::assembly::{Change, MOST_SNAP_MM, SNAP_MM, fit_or_join, in_rows, join, up_on, upright};
use crate::geom::{Bounds, Mat3, Object, Rigid, Vec3};
use crate::input::{BadSetting, LoadedModel, LoadedProfile, ModelSource, process_of, read_quietly, tell};
use crate::mesh::{Model, Part, ProjectPlates, TriangleMesh, is_overlap, threemf};
use crate::orient::{Facets, recommend};
use crate::pack::{self, Spot};
use crate::planning::{Infeasible, MOST_PARTS};
use crate::spelling::{counted, numbers};
use crate::world::World;

/// Which way a model stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PoseChoice {
    /// As it was drawn.
    #[default]
    AsDrawn,
    /// With this direction of the file's up; any length but zero.
    Up([f64; 3]),
    /// As `orient` recommends; for models of one part.
    Recommended,
    /// On the largest face of this part below which there is nothing.
    On(usize),
    /// In every way that it can stand on a face: for what lists sequences, and refused by all else.
    Any,
}

impl FromStr for PoseChoice {
    type Err = &'static str;

    /// `auto`, `any`, or a direction.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "auto" => Ok(Self::Recommended),
            "any" => Ok(Self::Any),
            _ => numbers(text)
                .map(Self::Up)
                .ok_or("must be auto, any or three numbers separated by commas, for example 0,0,1"),
        }
    }
}

/// How models are set up before they are planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrangement {
    /// The widest gap between parts that is closed, mm; 0 leaves gaps and overlaps as they are.
    pub snap_mm: f64,
    /// Whether parts that touch or overlap become one solid; gaps then stay.
    pub join: bool,
    /// Which way each model stands.
    pub standing: PoseChoice,
    /// Copies of the first model.
    pub copies: usize,
    /// More models for the same table, each with its copies.
    pub beside: Vec<(ModelSource, usize)>,
    /// Room between models, mm; `None` as the head needs it, less where the table is too small for that.
    pub gap_mm: Option<f64>,
    /// What the plan calls the file of the arranged model (3MF); `None` for the model's own name with `.parts.3mf` behind it.
    pub file: Option<String>,
}

impl Default for Arrangement {
    fn default() -> Self {
        let (standing, beside) = (PoseChoice::AsDrawn, Vec::new());
        Self { snap_mm: SNAP_MM, join: false, standing, copies: 1, beside, gap_mm: None, file: None }
    }
}

/// A model that was arranged.
#[derive(Clone, Debug)]
pub struct ArrangedModel {
    /// It, as 3MF, to be written to [`ArrangedModel::file`].
    pub bytes: Vec<u8>,
    /// What the plan calls that.
    pub file: String,
    /// What was done, one sentence each.
    pub changes: Vec<String>,
}

/// Copies of one model, at most, and models in all.
const MOST_MODELS: usize = 1000;
/// Room between models, mm, where it is asked for.
const GAPS_MM: [f64; 2] = [0.5, 500.0];
/// Room between models that is tried where the head's own does not fit on the table, mm.
const NARROWER_MM: [f64; 4] = [40.0, 20.0, 10.0, NEAREST_MM];
/// Room between models, mm, where nobody asks for less.
pub(super) const NEAREST_MM: f64 = 5.0;
/// Room that is tried where they have no plan so near to each other, mm.
pub(super) const WIDER_MM: [f64; 4] = [20.0, 40.0, 60.0, 90.0];

/// Models as they are to be planned.
pub(crate) struct SetUp {
    /// All of them as one.
    pub(crate) model: LoadedModel,
    /// What was done to what was read; `None`: nothing.
    pub(crate) arranged: Option<ArrangedModel>,
    /// By part; empty where the parts are not those of the files.
    pub(crate) origins: Vec<Origin>,
    /// The room between models, mm, where there are several and nobody asked for some.
    gap_mm: Option<f64>,
}

impl SetUp {
    /// A model to which nothing was done.
    pub(crate) fn as_read(model: LoadedModel) -> Self {
        let origins = Origin::as_read(model.model.parts.len());
        Self { model, arranged: None, origins, gap_mm: None }
    }
}

/// Where a part comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Origin {
    /// Of all parts of all files which: copies have the same.
    pub(crate) source: usize,
    /// From there to where it is.
    pub(crate) place: Rigid<Object, Object>,
}

impl Origin {
    /// Those of so many parts that lie where their file has them.
    fn as_read(parts: usize) -> Vec<Self> {
        (0..parts).map(|source| Self { source, place: Rigid::shift(Vec3::zeros()) }).collect()
    }
}

/// Models as their files have them.
pub(crate) struct ReadModels {
    first: LoadedModel,
    /// Which plates of its project the first one is.
    plates: ProjectPlates,
    /// The others for the same table, each with its copies.
    others: Vec<(LoadedModel, usize)>,
}

impl ReadModels {
    /// Reads the first and those that `how` sets beside it; each is told, and no warning.
    ///
    /// # Errors
    ///
    /// [`StrategyError::Setting`] for what is wrong with `how`, before anything is read; what reading says.
    pub(crate) fn read(first: &ModelSource, how: &Arrangement, world: &World<'_>) -> Result<Self, StrategyError> {
        how.check()?;
        let one = |from: &ModelSource| -> Result<LoadedModel, StrategyError> {
            let read = read_quietly(from, world)?;
            world.progress.reached(&read);
            Ok(read)
        };
        let (plates, first) = (first.plates, one(first)?);
        let others = how.beside.iter().map(|(from, copies)| Ok((one(from)?, *copies)));
        Ok(Self { first, plates, others: others.collect::<Result<_, StrategyError>>()? })
    }

    /// One part of the first, and nothing beside it.
    ///
    /// # Errors
    ///
    /// [`BadSetting::NoSuchPart`].
    pub(crate) fn alone(self, part: usize) -> Result<Self, BadSetting> {
        Ok(Self { first: self.first.alone(part)?, others: Vec::new(), ..self })
    }

    /// The first.
    pub(crate) fn first(&self) -> &LoadedModel {
        &self.first
    }
}

/// Models that were read, how they are set up, and for which machine. Of what is beside the first, `how` is as it was when they were read.
#[derive(Clone, Copy)]
pub(crate) struct Models<'a> {
    pub(crate) read: &'a ReadModels,
    pub(crate) how: &'a Arrangement,
    pub(crate) machine: &'a LoadedProfile,
}

impl Models<'_> {
    /// The models with more room between them than in `set`, ever wider, as far as the table goes.
    pub(crate) fn wider(&self, set: &SetUp) -> Vec<SetUp> {
        let again = |mm: f64| {
            let how = Arrangement { gap_mm: Some(mm), ..self.how.clone() };
            arranged(&Models { how: &how, ..*self }).ok()
        };
        let wider = WIDER_MM.into_iter().filter(|mm| set.gap_mm.is_some_and(|gap| *mm > gap));
        // What does not fit on the table is refused by the planner at once.
        wider.filter_map(again).collect()
    }
}

/// As [`arranged`]; the warnings about the models are told.
pub(crate) fn arranged_aloud(models: &Models<'_>, world: &World<'_>) -> Result<SetUp, StrategyError> {
    let set = arranged(models)?;
    tell(&set.model.model.warnings, world);
    Ok(set)
}

/// Arranges the models where there is something to arrange.
///
/// # Errors
///
/// What is wrong with the models in this pose, or with their number; nothing that another time could be otherwise.
pub(crate) fn arranged(models: &Models<'_>) -> Result<SetUp, StrategyError> {
    let Models { read: ReadModels { first: read, plates, others }, how, machine } = *models;
    // Whoever reads the plan's model again knows no plate.
    let of_plate = *plates != ProjectPlates::Only;
    if how.is_plain() && how.snap_mm == 0.0 && !how.join && !of_plate {
        return Ok(SetUp::as_read(read.clone()));
    }
    let mut changes = Vec::new();
    let stood = if how.is_plain() { None } else { Some(stood(read, others, how, machine, &mut changes)?) };
    let gap_mm = stood.as_ref().and_then(|stood| stood.gap_mm.filter(|_| how.gap_mm.is_none()));
    let (stood, stood_origins) = stood.map(|stood| (stood.model, stood.origins)).unzip();
    let model = stood.as_ref().unwrap_or(&read.model);
    if !how.join && how.snap_mm > 0.0 && model.parts.len() > MOST_PARTS {
        // Whatever becomes of them: no plan is made of as many, and what looks for gaps looks at pairs.
        return Err(Infeasible::TooManyParts { parts: model.parts.len() }.into());
    }
    let fitted = match how {
        Arrangement { join: true, .. } => join(model)?,
        Arrangement { snap_mm: 0.0, .. } => None,
        _ => fit_or_join(model, how.snap_mm)?,
    };
    if let ProjectPlates::Number(number) = *plates {
        changes.push(format!("plate {number} of {}", read.file));
    }
    let as_stood = || stood.as_ref().or(of_plate.then_some(model)).map(named);
    let Some(parts) = fitted.as_ref().map_or_else(as_stood, |f| Some(f.parts.clone())) else {
        return Ok(SetUp { gap_mm, ..SetUp::as_read(read.clone()) });
    };
    changes.extend(fitted.iter().flat_map(|f| f.changes.iter().map(|change: &Change| change.told(model))));
    let of_files = stood_origins.unwrap_or_else(|| Origin::as_read(model.parts.len()));
    let origins = match how {
        _ if of_files.len() == parts.len() => of_files,
        // What was joined has other numbers: whoever asked for that knows.
        Arrangement { join: true, .. } if how.is_plain() => Origin::as_read(parts.len()),
        _ => Vec::new(),
    };
    Ok(SetUp { gap_mm, origins, ..made_of(parts, read, changes, &how.file_of(read))? })
}

/// A model of its own out of what was read; nothing is known of where its parts come from.
pub(crate) fn made_of(
    parts: Vec<(String, TriangleMesh<Object>)>,
    read: &LoadedModel,
    changes: Vec<String>,
    file: &str,
) -> Result<SetUp, StrategyError> {
    let bytes = threemf(&parts.iter().map(|(name, mesh)| (name.clone(), mesh)).collect::<Vec<_>>());
    let mut made = LoadedModel::made(file.to_owned(), &bytes)?;
    // The pose and what overlaps are looked at anew.
    let about_file = read.model.warnings_in_any_pose().filter(|text| !is_overlap(text));
    made.model.warnings.splice(0..0, about_file.cloned());
    let arranged = Some(ArrangedModel { bytes, file: file.to_owned(), changes });
    Ok(SetUp { model: made, arranged, origins: Vec::new(), gap_mm: None })
}

impl Arrangement {
    pub(super) fn check(&self) -> Result<(), BadSetting> {
        BadSetting::within("snap", self.snap_mm, " mm", [0.0, MOST_SNAP_MM])?;
        if let Some(mm) = self.gap_mm {
            BadSetting::within("gap", mm, " mm", GAPS_MM)?;
        }
        if let PoseChoice::Up(up) = self.standing {
            BadSetting::direction("up", up)?;
        }
        let all = self.copies + self.beside.iter().map(|(_, copies)| copies).sum::<usize>();
        BadSetting::within("models", all as f64, "", [1.0, MOST_MODELS as f64])
    }

    /// What the plan calls the file of the arranged model.
    pub(crate) fn file_of(&self, read: &LoadedModel) -> String {
        self.file.clone().unwrap_or_else(|| format!("{}.parts.3mf", read.file))
    }

    /// Whether there is one model, as it was drawn.
    pub(crate) fn is_plain(&self) -> bool {
        self.standing == PoseChoice::AsDrawn && self.copies == 1 && self.beside.is_empty()
    }
}

/// All models, turned and beside each other.
struct Stood {
    model: Model,
    /// The room between them, mm, where there are several.
    gap_mm: Option<f64>,
    /// By part.
    origins: Vec<Origin>,
}

/// Turns all models, and sets them beside each other.
fn stood(
    first: &LoadedModel,
    others: &[(LoadedModel, usize)],
    how: &Arrangement,
    machine: &LoadedProfile,
    changes: &mut Vec<String>,
) -> Result<Stood, StrategyError> {
    let all = || std::iter::once((first, how.copies)).chain(others.iter().map(|(model, copies)| (model, *copies)));
    let turns =
        all().map(|(model, _)| turn(model, how.standing, machine)).collect::<Result<Vec<_>, StrategyError>>()?;
    if how.standing != PoseChoice::AsDrawn {
        let chosen = if how.standing == PoseChoice::Recommended { ", as orient recommends" } else { "" };
        changes.extend(all().zip(&turns).map(|((model, _), turn)| {
            let up = turn.rotation.transpose() * Vec3::z();
            format!("{} stands with ({:.4}, {:.4}, {:.4}) up{chosen}", model.file, up.x + 0.0, up.y + 0.0, up.z + 0.0)
        }));
    }
    let each: Vec<(&LoadedModel, &Rigid<Object, Object>)> =
        all().zip(&turns).flat_map(|((model, copies), turn)| std::iter::repeat_n((model, turn), copies)).collect();
    let solids: Vec<(&[Part], &Rigid<Object, Object>)> =
        each.iter().map(|(model, turn)| (&model.model.parts[..], *turn)).collect();
    let Laid { moved, places, gap_mm, .. } = laid_out(&solids, how.gap_mm, machine);
    if each.len() > 1 {
        changes.push(format!("{} stand {gap_mm:.1} mm apart", counted(each.len(), "model")));
    }
    let mut parts = Vec::new();
    let (mut origins, mut first) = (Vec::new(), 0);
    let mut places = places.into_iter();
    for (model, copies) in all() {
        let sources = first..first + model.model.parts.len();
        for place in places.by_ref().take(copies) {
            origins.extend(sources.clone().map(|source| Origin { source, place }));
        }
        first = sources.end;
    }
    for (index, ((model, _), meshes)) in each.iter().zip(moved).enumerate() {
        for (part, mesh) in model.model.parts.iter().zip(meshes) {
            let name = if each.len() > 1 { format!("{}-{}", index + 1, part.name) } else { part.name.clone() };
            parts.push((name, mesh));
        }
    }
    Ok(Stood { model: Model::from_parts(parts), gap_mm: (each.len() > 1).then_some(gap_mm), origins })
}

/// What was set beside each other.
pub(crate) struct Laid {
    /// The meshes of each, in their places.
    pub(crate) moved: Vec<Vec<TriangleMesh<Object>>>,
    /// How each was turned and moved.
    pub(crate) places: Vec<Rigid<Object, Object>>,
    /// The room between them, mm.
    pub(crate) gap_mm: f64,
    /// Whether all of them lie on the table so.
    pub(crate) fits: bool,
}

/// Turns each of these, and sets them beside each other on the table; one by itself stays where it is.
pub(crate) fn laid_out(
    each: &[(&[Part], &Rigid<Object, Object>)],
    gap_mm: Option<f64>,
    machine: &LoadedProfile,
) -> Laid {
    let boxes: Vec<Bounds> = each.iter().map(|(parts, turn)| bounds(parts, turn)).collect();
    let (spots, gap_mm, fits) = on_table(&boxes, gap_mm, machine);
    let place = |((parts, turn), spot): (&(&[Part], &Rigid<Object, Object>), &Spot)| {
        let turn = if spot.turned { turn.then(&quarter()) } else { **turn };
        let own = bounds(parts, &turn);
        let by = Vec3::new(spot.corner[0] - own.min.x, spot.corner[1] - own.min.y, -own.min.z);
        let place = turn.then(&Rigid::shift(if each.len() > 1 { by } else { Vec3::zeros() }));
        (parts.iter().map(|part| part.mesh.moved(&place)).collect(), place)
    };
    let (moved, places) = each.iter().zip(&spots).map(place).unzip();
    Laid { moved, places, gap_mm, fits }
}

/// How the model is turned.
fn turn(
    model: &LoadedModel,
    standing: PoseChoice,
    machine: &LoadedProfile,
) -> Result<Rigid<Object, Object>, StrategyError> {
    let last = model.model.parts.len() - 1;
    let up = match standing {
        PoseChoice::AsDrawn => return Ok(Rigid::shift(Vec3::zeros())),
        PoseChoice::Any => {
            let wanted = "one pose is needed here; use plan --all --up any, or three numbers, for example 0,0,1";
            return Err(BadSetting::Words { name: "up", text: "any".to_owned(), wanted: wanted.to_owned() }.into());
        }
        PoseChoice::Up(up) => Vec3::from(up),
        PoseChoice::Recommended => {
            let [part] = &model.model.parts[..] else {
                return Err(BadSetting::SeveralToStand { model: model.file.clone(), parts: last + 1 }.into());
            };
            recommend(&Facets::of(&part.mesh), &process_of(machine), None, None).recommended.up
        }
        PoseChoice::On(given) if given > last => {
            return Err(BadSetting::NoSuchPart { name: "base", given, last, model: model.file.clone() }.into());
        }
        PoseChoice::On(part) => {
            let name = || model.model.parts[part].name.clone();
            up_on(&model.model, part).ok_or_else(|| BadSetting::NoBase { part, name: name() })?
        }
    };
    Ok(upright(&model.model.parts, up))
}

fn bounds(parts: &[Part], turn: &Rigid<Object, Object>) -> Bounds {
    let vertices = parts.iter().flat_map(|part| part.mesh.vertices());
    Bounds::of(vertices.map(|v| turn.rotation * v))
}

/// A quarter turn about Z.
fn quarter() -> Rigid<Object, Object> {
    Rigid::new(Mat3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), Vec3::zeros())
}

/// Where the models stand, and the room between them: what is asked for, or what the head needs, or the most that fits the table; a
/// model is turned only where there is no room otherwise.
fn on_table(boxes: &[Bounds], asked_mm: Option<f64>, machine: &LoadedProfile) -> (Vec<Spot>, f64, bool) {
    let footprints: Vec<[f64; 2]> = boxes.iter().map(|b| [b.size().x, b.size().y]).collect();
    let highest = boxes.iter().map(|b| b.size().z).fold(0.0, f64::max);
    let tried = match asked_mm {
        Some(mm) => vec![mm],
        None => {
            let own = head_reach_mm(machine, highest).max(NEAREST_MM);
            std::iter::once(own).chain(NARROWER_MM.into_iter().filter(|mm| *mm < own)).collect()
        }
    };
    let last = tried[tried.len() - 1];
    let room = tried.into_iter().find_map(|mm| Some((room_for(&footprints, mm, machine)?, mm)));
    // What does not fit at all is refused where every model is held against its table.
    let rows = || in_rows(&footprints, last).into_iter().map(|corner| Spot { corner, turned: false }).collect();
    room.map_or_else(|| (rows(), last, false), |(spots, mm)| (spots, mm, true))
}

/// Where rectangles stand on the table with so much room between them, turned only where there is no room otherwise; `None` where none is
/// found.
pub(super) fn room_for(footprints: &[[f64; 2]], gap_mm: f64, machine: &LoadedProfile) -> Option<Vec<Spot>> {
    // What covers more than the table fits in no way.
    let table = &machine.profile.table;
    let square = table.size_mm.filter(|_| table.radius_mm == 0.0);
    let table_mm2 = square.map_or_else(|| PI * table.radius_mm * table.radius_mm, |[wide, deep]| wide * deep);
    if footprints.iter().map(|[x, y]| x * y).sum::<f64>() > table_mm2 {
        return None;
    }
    let inside = |[x, y]: [f64; 2]| machine.profile.beyond_table(x, y) <= 0.0;
    [false, true].into_iter().find_map(|turns| pack::on_table(footprints, gap_mm, turns, &inside))
}

/// How far the head reaches sideways from its tip, mm, with what of it is lower than `highest`.
pub(crate) fn head_reach_mm(machine: &LoadedProfile, highest: f64) -> f64 {
    let low = machine.profile.head_bodies().into_iter().filter(|body| body.bounds().min.z < highest);
    low.map(|body| {
        let b = body.bounds();
        b.max.x.max(-b.min.x).max(b.max.y).max(-b.min.y)
    })
    .fold(0.0, f64::max)
}

fn named(model: &Model) -> Vec<(String, TriangleMesh<Object>)> {
    model.parts.iter().map(|part| (part.name.clone(), part.mesh.clone())).collect()
}

impl ArrangedModel {
    /// What was done, in one sentence.
    pub fn story(&self) -> String {
        self.changes.join("; ")
    }
}
