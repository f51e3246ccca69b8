//! One solid cut by planes and planned; and several on one table, without a plan: what has one by itself stays as it is, each other solid is
//! cut, copies once.

use super::arrange::SetUp;
use super::error::StrategyError;
use super::plan::{Along, PlanOptions, PlanResult, planned, planned_along};
use super::refused::Refused;
use super::split::{GivenCut, SplitOptions, SplitResult, cut_up};
use super::uncut::Uncut;
use crate::geom::{Object, Rigid, Vec3};
use crate::input::{CheckedPlan, LoadedModel, LoadedProfile, spanning};
use crate::mesh::{Model, TriangleMesh, threemf};
use crate::spelling::part_named;
use crate::split::{CutBudget, CutMade};
use crate::world::World;

/// Solids of one shape that were cut.
#[derive(Clone, Debug)]
pub struct CutSolid {
    /// The parts of the model that were cut so, ascending; the first is the one that `split` tells of.
    pub parts: Vec<usize>,
    /// The cuts as they can be given again.
    pub pins: Vec<GivenCut>,
    /// The parts and the cuts.
    pub split: SplitResult,
}

/// Vertices of copies lie as near to each other, mm: a file's digits.
const COPY_MM: f64 = 1e-4;

/// Parts that touch each other, directly or through others: ids ascending, groups by their first.
pub(super) fn groups(model: &Model) -> Vec<Vec<usize>> {
    let first = model.bodies();
    let of = |group: usize| -> Vec<usize> { (0..first.len()).filter(|&part| first[part] == group).collect() };
    (0..first.len()).map(of).filter(|group| !group.is_empty()).collect()
}

/// Shapes that were planned or cut already: for copies, and for the same solids in other places.
#[derive(Default)]
pub(super) struct Known(Vec<Shape>);

/// A solid, and how it is printed when it stands alone.
struct Shape {
    mesh: TriangleMesh<Object>,
    /// What its user lets pass.
    allow: Option<Option<f64>>,
    /// Of which part somebody has decided the cuts, in a file.
    given: Option<usize>,
    /// The directions of its plan, where it has one whole and may stay so.
    whole: Result<Option<Vec<Vec3>>, Refused>,
    /// The cuts, where that was tried.
    cut: Option<Result<ShapeCut, Refused>>,
}

/// How a shape was cut.
struct ShapeCut {
    /// Its parts' directions.
    ups: Vec<Vec3>,
    split: SplitResult,
    /// The cuts as they can be given again.
    pins: Vec<GivenCut>,
}

/// A group of parts as if it stood alone, with the options that are its own.
struct Alone {
    group: Vec<usize>,
    options: PlanOptions,
}

impl Alone {
    fn all(model: &Model, options: &PlanOptions) -> Vec<Self> {
        let of = |group: Vec<usize>| {
            let own = |(part, area): &(usize, Option<f64>)| Some((group.iter().position(|id| id == part)?, *area));
            let allow = options.allow.iter().filter_map(own).collect();
            Self {
                options: PlanOptions {
                    remedies: false,
                    // Of parts that touch, the reasons say which want other directions.
                    explain: group.len() > 1,
                    place: None,
                    plans: 1,
                    allow,
                    // Of all parts together.
                    order: Vec::new(),
                    ..options.clone()
                },
                group,
            }
        };
        groups(model).into_iter().map(of).collect()
    }
}

impl Known {
    /// Whether each group of parts that touch has a plan by itself.
    pub(super) fn each_has_a_plan(
        &mut self,
        model: &LoadedModel,
        machine: &LoadedProfile,
        options: &PlanOptions,
        world: &World<'_>,
    ) -> bool {
        let has_plan = |alone: &Alone| {
            let parts = model.only(&alone.group);
            let whole = match alone.group.len() {
                1 => {
                    let (index, _) = self.of(&parts, None, machine, &alone.options, world);
                    self.0[index].whole.clone()
                }
                _ => whole(&parts, machine, &alone.options, world),
            };
            matches!(whole, Ok(Some(_)))
        };
        Alone::all(&model.model, options).iter().all(has_plan)
    }

    /// The shape of the one part of `solid`, and by how much that lies beside what is known; `given` is that of [`Shape`].
    fn of(
        &mut self,
        solid: &LoadedModel,
        given: Option<usize>,
        machine: &LoadedProfile,
        options: &PlanOptions,
        world: &World<'_>,
    ) -> (usize, Vec3) {
        let mesh = &solid.model.parts[0].mesh;
        let allow = options.allow.first().map(|(_, area)| *area);
        let same = |shape: &Shape| copied(&shape.mesh, mesh).filter(|_| shape.allow == allow && shape.given == given);
        if let Some(found) = self.0.iter().enumerate().find_map(|(k, shape)| Some((k, same(shape)?))) {
            return found;
        }
        // Where cuts are given it does not stay whole.
        let whole = if given.is_some() { Ok(None) } else { whole(solid, machine, options, world) };
        self.0.push(Shape { mesh: mesh.clone(), allow, given, whole, cut: None });
        (self.0.len() - 1, Vec3::zeros())
    }

    /// Cuts a shape that has no plan whole, where that was not tried yet, as this part of `set`.
    fn cut(
        &mut self,
        index: usize,
        (set, part): (&SetUp, usize),
        machine: &LoadedProfile,
        options: &PlanOptions,
        how: CutsOf<'_>,
        world: &World<'_>,
    ) {
        let shape = &mut self.0[index];
        if matches!(shape.whole, Ok(None)) && shape.cut.is_none() {
            let cut = in_parts(set.model.only(&[part]), machine, options, how.of_part(set, part), world);
            shape.cut = Some(cut.map(|(plan, split, _)| ShapeCut {
                ups: directions(&plan.plan),
                pins: pins(&split, set, part),
                split,
            }));
        }
    }
}

/// The directions along which some parts are printed as they are, where they have a plan by themselves.
fn whole(
    parts: &LoadedModel,
    machine: &LoadedProfile,
    options: &PlanOptions,
    world: &World<'_>,
) -> Result<Option<Vec<Vec3>>, Refused> {
    match planned(parts.clone(), machine.clone(), options, world) {
        Ok(plan) => Ok(Some(directions(&plan.plan))),
        Err(StrategyError::NoPlan(_)) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// The directions of a plan, the model file's frame.
fn directions(plan: &CheckedPlan) -> Vec<Vec3> {
    let placed = plan.workpiece().placed.rotation.transpose();
    plan.prints().map(|(_, print)| placed * Vec3::from(print.up)).collect()
}

/// What a model is made of once its solids are cut.
#[derive(Default)]
pub(super) struct Pieces {
    /// Names and meshes, the model file's frame.
    pub(super) parts: Vec<(String, TriangleMesh<Object>)>,
    /// The directions that the parts are printed along, the same frame.
    pub(super) ups: Vec<Vec3>,
    /// The cuts.
    pub(super) cut: Vec<CutSolid>,
    /// Exceptions of parts that stayed whole.
    pub(super) allow: Vec<(usize, Option<f64>)>,
}

impl Pieces {
    /// The pieces of a model whose groups of parts are planned or cut each as if it stood alone; else why not.
    pub(super) fn of(
        set: &SetUp,
        machine: &LoadedProfile,
        options: &PlanOptions,
        how: CutsOf<'_>,
        known: &mut Known,
        world: &World<'_>,
    ) -> Result<Self, Refused> {
        let model = &set.model;
        let mut pieces = Self::default();
        let mut cut: Vec<(usize, Vec<usize>)> = Vec::new();
        for Alone { group, options } in &Alone::all(&model.model, options) {
            let named = |part: usize| part_named(part, &model.model.parts[part].name);
            let parts = model.only(group);
            let [part] = group[..] else {
                if let Some(&part) = group.iter().find(|&&part| how.is_given(set, part)) {
                    return Err(Refused::Touched { part: named(part) });
                }
                let Some(ups) = whole(&parts, machine, options, world)? else {
                    let [first, last] = [group[0], group[group.len() - 1]].map(named);
                    return Err(Refused::Several { first, last, parts: group.len() });
                };
                pieces.keep(model, group, &ups, options);
                continue;
            };
            let given = how.is_given(set, part).then(|| set.origins[part].source);
            let (index, by) = known.of(&parts, given, machine, options, world);
            known.cut(index, (set, part), machine, options, how, world);
            let Shape { whole, cut: split, .. } = &known.0[index];
            let about = |why: &Refused| why.clone().of_part(named(part));
            if let Some(ups) = whole.as_ref().map_err(about)? {
                pieces.keep(model, group, ups, options);
            }
            if let Some(made) = split {
                let made = made.as_ref().map_err(about)?;
                pieces.take(&model.called(part), &made.split, &by);
                pieces.along(&made.ups);
                match cut.iter_mut().find(|(of, _)| *of == index) {
                    Some((_, parts)) => parts.push(part),
                    None => cut.push((index, vec![part])),
                }
            }
        }
        let of_shape = |(index, parts): (usize, Vec<usize>)| {
            let ShapeCut { split, pins, .. } = known.0[index].cut.as_ref()?.as_ref().ok()?;
            Some(CutSolid { parts, pins: pins.clone(), split: split.clone() })
        };
        pieces.cut = cut.into_iter().filter_map(of_shape).collect();
        if pieces.cut.is_empty() {
            let is_joint = !model.model.captive.is_empty();
            return Err(if is_joint { Refused::Jointed } else { Refused::Beside });
        }
        Ok(pieces)
    }

    /// The pieces as a file (3MF).
    pub(super) fn threemf(&self) -> Vec<u8> {
        threemf(&self.parts.iter().map(|(name, mesh)| (name.clone(), mesh)).collect::<Vec<_>>())
    }

    /// Takes parts as they are.
    fn keep(&mut self, model: &LoadedModel, group: &[usize], ups: &[Vec3], alone: &PlanOptions) {
        let base = self.parts.len();
        self.allow.extend(alone.allow.iter().map(|(part, area)| (base + part, *area)));
        let parts = group.iter().map(|&part| &model.model.parts[part]);
        self.parts.extend(parts.map(|part| (part.name.clone(), part.mesh.clone())));
        self.along(ups);
    }

    /// Takes the parts of a solid of this name, which lies by so much beside the one that was cut. Its pedestal stands where it stood.
    fn take(&mut self, name: &str, split: &SplitResult, by: &Vec3) {
        let moved = Rigid::shift(by + Vec3::z() * split.pedestal_mm);
        let named = split.split.named(name).into_iter();
        self.parts.extend(named.map(|(part, mesh)| (part, mesh.moved(&moved))));
    }

    /// More directions, where they are new.
    fn along(&mut self, ups: &[Vec3]) {
        for up in ups {
            if self.ups.iter().all(|known| (known - up).norm() > 1e-9) {
                self.ups.push(*up);
            }
        }
    }
}

/// How solids are cut.
#[derive(Clone, Copy)]
pub(super) struct CutsOf<'a> {
    /// What the plan calls the parts' file.
    pub(super) file: &'a str,
    /// Cuts that are made first.
    pub(super) cuts: &'a [GivenCut],
    /// What the cuts of one solid may cost.
    pub(super) budget: Option<CutBudget>,
}

impl<'a> CutsOf<'a> {
    /// Whether a cut of this part, or of a copy of it, is given.
    fn is_given(&self, set: &SetUp, part: usize) -> bool {
        self.cuts.iter().any(|cut| is_of(cut, set, part))
    }

    /// How one part is cut, which lies in `set`.
    pub(super) fn of_part(&self, set: &SetUp, part: usize) -> PartCuts<'a> {
        let own = self.cuts.iter().enumerate().filter(|(_, cut)| is_of(cut, set, part));
        let given = own.map(|(place, cut)| (place, cut.moved(&set.origins[part].place))).collect();
        PartCuts { file: self.file, given, budget: self.budget }
    }
}

/// Whether a cut is of this part, or of a copy of it.
fn is_of(cut: &GivenCut, set: &SetUp, part: usize) -> bool {
    let source = |part: usize| set.origins.get(part).map(|origin| origin.source);
    source(cut.part.unwrap_or(0)).is_some_and(|of| source(part) == Some(of))
}

/// The cuts of a part as they can be given again.
pub(super) fn pins(split: &SplitResult, set: &SetUp, part: usize) -> Vec<GivenCut> {
    let several = set.origins.iter().any(|origin| origin.source > 0);
    let back = set.origins.get(part).map(|origin| origin.place.inverse());
    let pin = |cut: &CutMade| {
        let cut = GivenCut { part: several.then_some(part), ..GivenCut::of(cut) };
        back.map_or_else(|| cut.clone(), |back| cut.moved(&back))
    };
    split.split.cuts.iter().map(pin).collect()
}

/// How one solid is cut.
pub(super) struct PartCuts<'a> {
    /// What the plan calls the parts' file.
    file: &'a str,
    /// Cuts that are made first, where the solid lies, and which of all that are given they are.
    given: Vec<(usize, GivenCut)>,
    /// What the cuts may cost.
    budget: Option<CutBudget>,
}

/// One solid in parts: the plan of them, the cuts and the parts' file; else why not.
pub(super) fn in_parts(
    solid: LoadedModel,
    machine: &LoadedProfile,
    options: &PlanOptions,
    PartCuts { file, given, budget }: PartCuts<'_>,
    world: &World<'_>,
) -> Result<(PlanResult, SplitResult, Vec<u8>), Refused> {
    let usual = SplitOptions::default();
    let how = SplitOptions {
        overhang_deg: options.overhang_deg,
        finish: options.finish,
        bridge_mm: options.bridge_mm,
        tolerate_mm2: options.tolerate_mm2,
        margin_mm: options.margin_mm,
        budget,
        tries: options.budget,
        max_cuts: usual.max_cuts.max(given.len()),
        // Of the only part of `solid`.
        cuts: given.iter().map(|(_, cut)| GivenCut { part: None, ..cut.clone() }).collect(),
        ..usual
    };
    let spanned = spanning(machine.clone(), options.bridge_mm).map_err(StrategyError::from)?;
    let split = cut_up(solid, &spanned, &how, world)?;
    if let Some(why) = split.why_not() {
        return Err(Refused::Uncut(match why {
            Uncut::Pinned { number, against } => Uncut::Pinned { number: given[number - 1].0 + 1, against },
            other => other,
        }));
    }
    let bytes = split.threemf();
    let parts = LoadedModel::made(file.to_owned(), &bytes)?;
    // Exceptions are of the model's own parts.
    let plain = PlanOptions { remedies: false, allow: Vec::new(), ..options.clone() };
    // The cuts' own directions have a plan, and are few; a search over all that the parts offer may take a hundred times as long.
    let ups = split.split.ups();
    let plan = match planned_along(Along::These(&ups), parts.clone(), machine.clone(), &plain, world) {
        Err(StrategyError::NoPlan(_)) => planned(parts, machine.clone(), &plain, world),
        found => found,
    };
    Ok((plan?, split, bytes))
}

/// By how much `second` lies beside `first`, where it is a copy, not turned.
pub(super) fn copied(first: &TriangleMesh<Object>, second: &TriangleMesh<Object>) -> Option<Vec3> {
    let by = second.bounds().min - first.bounds().min;
    let near = |(a, b): (&Vec3, &Vec3)| (b - a - by).amax() <= COPY_MM;
    let same = first.facets() == second.facets() && first.vertices().len() == second.vertices().len();
    (same && first.vertices().iter().zip(second.vertices()).all(near)).then_some(by)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;

    fn block(at: [f64; 3]) -> (String, TriangleMesh<Object>) {
        ("block".to_owned(), solid_box(at.into(), Vec3::from(at) + Vec3::repeat(10.0)))
    }

    #[test]
    fn what_touches_is_one_group() {
        let at = [[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [30.0, 0.0, 10.0], [0.0, 0.0, 10.0], [60.0, 0.0, 0.0]];
        let model = Model::from_parts(at.into_iter().map(block).collect());
        assert_eq!(groups(&model), [vec![0, 3], vec![1, 2], vec![4]]);
    }

    #[test]
    fn a_copy_is_known_by_its_shape() {
        let [(_, one), (_, moved)] = [block([0.0; 3]), block([30.0, -2.0, 0.0])];
        assert_eq!(copied(&one, &moved), Some(Vec3::new(30.0, -2.0, 0.0)));
        let higher = solid_box(Vec3::zeros(), Vec3::new(10.0, 10.0, 10.01));
        assert_eq!(copied(&one, &higher), None);
    }
}
