//! Solids of one file that lie loose beside each other: moved apart, and each turned as suits it, where they have no way to be printed as
//! they were laid out. What was read is never changed: what comes of it is a model of its own.
//!
//! Solids that overlap, seen from above, stay as they are to each other: they may be a chain or a hinge.

use std::cell::OnceCell;

use super::arrange::{Laid, Origin, SetUp, laid_out, made_of};
use super::error::StrategyError;
use super::plan::{Along, PlanOptions, planned_along};
use super::solids::{copied, groups};
use super::turning::Poses;
use crate::assembly::upright;
use crate::geom::{Bounds, Object, Rigid, Vec3};
use crate::input::{LoadedModel, LoadedProfile};
use crate::mesh::{Model, Part, TriangleMesh};
use crate::section::polygons::{GridPoint, Region, and, or, units, wound};
use crate::spelling::{counted, part_named};
use crate::world::World;

/// Solids that stay together.
pub(super) struct Cluster {
    /// Their places in the model, ascending.
    pub(super) parts: Vec<usize>,
    bounds: Bounds,
    /// What they cover, seen from above, once somebody has asked.
    shadow: OnceCell<Region>,
}

/// Room between loose solids where there is not more, mm; and as many as it is looked for of.
const TIGHT_MM: f64 = 2.0;
const FEW: usize = 40;

/// What stands no higher than this above the lowest of all stands on the table, mm.
const STANDS_MM: f64 = 0.01;

impl Cluster {
    /// Those of a model whose solids all stand on the table; none where one hangs in the air: what is missing below it nobody knows.
    pub(super) fn standing(model: &Model) -> Vec<Self> {
        let all = Self::all(model);
        let stands = |cluster: &Self| cluster.bounds.min.z <= model.bounds.min.z + STANDS_MM;
        if all.iter().all(stands) { all } else { Vec::new() }
    }

    /// Those of a model, by their first part.
    pub(super) fn all(model: &Model) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for parts in groups(model) {
            let vertices = parts.iter().flat_map(|&part| model.parts[part].mesh.vertices());
            let mut new = Self { bounds: Bounds::of(vertices.copied()), parts, shadow: OnceCell::new() };
            while let Some(near) = all.iter().position(|other| other.is_above_or_below(&new, model)) {
                let other = all.swap_remove(near);
                new.bounds = new.bounds.union(&other.bounds);
                new.shadow = or(new.shadow(model), other.shadow(model)).into();
                new.parts.extend(other.parts);
            }
            new.parts.sort_unstable();
            all.push(new);
        }
        all.sort_by_key(|cluster| cluster.parts[0]);
        all
    }

    fn is_above_or_below(&self, other: &Self, model: &Model) -> bool {
        let (a, b) = (&self.bounds, &other.bounds);
        (0..2).all(|i| a.min[i] < b.max[i] && b.min[i] < a.max[i])
            && !and(self.shadow(model), other.shadow(model)).is_empty()
    }

    /// What is below a closed surface is below what of it looks up.
    fn shadow(&self, model: &Model) -> &Region {
        let point = |p: Vec3| GridPoint::new(units(p.x), units(p.y));
        let looks_up = |part: usize| {
            let mesh = &model.parts[part].mesh;
            let facets = 0..mesh.facets().len();
            facets.filter(|&facet| mesh.normal(facet).is_some_and(|n| n.z > 0.0)).map(|facet| mesh.corners(facet))
        };
        self.shadow.get_or_init(|| {
            let facets = self.parts.iter().flat_map(|&part| looks_up(part));
            wound(&facets.map(|corners| corners.map(point).to_vec()).collect::<Vec<_>>())
        })
    }
}

/// The model of `set` with its clusters beside each other, by default as far apart as the head needs it; those with a direction in `ups` stand with
/// it up.
pub(super) fn spread(
    set: &SetUp,
    clusters: &[Cluster],
    ups: &[Option<Vec3>],
    gap_mm: Option<f64>,
    machine: &LoadedProfile,
    file: &str,
) -> Result<SetUp, StrategyError> {
    let model = &set.model.model;
    let parts: Vec<Vec<Part>> =
        clusters.iter().map(|cluster| cluster.parts.iter().map(|&part| model.parts[part].clone()).collect()).collect();
    let turn = |(own, up): (&Vec<Part>, &Option<Vec3>)| {
        up.map_or_else(|| Rigid::<Object, Object>::shift(Vec3::zeros()), |up| upright(own, up))
    };
    let turns: Vec<Rigid<Object, Object>> = parts.iter().zip(ups).map(turn).collect();
    let each: Vec<(&[Part], &Rigid<Object, Object>)> = parts.iter().map(Vec::as_slice).zip(&turns).collect();
    let usual = laid_out(&each, gap_mm, machine);
    // What is printed upright together needs no room for the head, but a search in so little room takes long where there are many.
    let tight = gap_mm.is_none() && !usual.fits && each.len() <= FEW;
    let Laid { moved, places, gap_mm, .. } = if tight { laid_out(&each, Some(TIGHT_MM), machine) } else { usual };
    let mut placed: Vec<Option<_>> = vec![None; model.parts.len()];
    let mut origins = set.origins.clone();
    for (((cluster, own), meshes), by) in clusters.iter().zip(&parts).zip(moved).zip(&places) {
        for ((&place, part), mesh) in cluster.parts.iter().zip(own).zip(meshes) {
            placed[place] = Some((part.name.clone(), mesh));
            let origin = origins.get_mut(place);
            origin.into_iter().for_each(|Origin { place, .. }| *place = place.then(by));
        }
    }
    let mut changes = vec![format!("{} stand {gap_mm:.1} mm apart", counted(clusters.len(), "loose solid"))];
    changes.extend(clusters.iter().zip(ups).filter_map(|(cluster, up)| {
        let (first, up) = (cluster.parts[0], (*up)?);
        let name = &model.parts[first].name;
        Some(format!(
            "{} stands with ({:.4}, {:.4}, {:.4}) up",
            part_named(first, name),
            up.x + 0.0,
            up.y + 0.0,
            up.z + 0.0
        ))
    }));
    let earlier = set.arranged.iter().flat_map(|arranged| arranged.changes.clone());
    let changes = earlier.chain(changes).collect();
    let mut spread = made_of(placed.into_iter().flatten().collect(), &set.model, changes, file)?;
    spread.origins = origins;
    Ok(spread)
}

/// By cluster, the direction that is to be up so that it is printed by itself: where it has no plan as it was drawn, the first pose of
/// `orient` that has one, or else the one that costs the least. `None`: as it was drawn.
pub(super) fn each_by_itself(
    model: &LoadedModel,
    clusters: &[Cluster],
    machine: &LoadedProfile,
    options: &PlanOptions,
    world: &World<'_>,
) -> Vec<Option<Vec3>> {
    let mut known: Vec<(TriangleMesh<Object>, Option<Vec3>)> = Vec::new();
    let mut up = |cluster: &Cluster| {
        let alone = model.only(&cluster.parts);
        let options = PlanOptions {
            remedies: false,
            explain: false,
            plans: 1,
            allow: Vec::new(),
            order: Vec::new(),
            place: None,
            ..options.clone()
        };
        let [part] = &alone.model.parts[..] else { return None };
        let mesh = part.mesh.clone();
        if let Some((_, up)) = known.iter().find(|(other, _)| copied(other, &mesh).is_some()) {
            return *up;
        }
        let up = by_itself(&alone, machine, &options, world);
        known.push((mesh, up));
        up
    };
    clusters.iter().map(&mut up).collect()
}

fn by_itself(alone: &LoadedModel, machine: &LoadedProfile, options: &PlanOptions, world: &World<'_>) -> Option<Vec3> {
    let has_plan = |model: &LoadedModel| {
        planned_along(Along::These(&[Vec3::z()]), model.clone(), machine.clone(), options, world).is_ok()
    };
    if has_plan(alone) {
        return None;
    }
    let poses = Poses::of(&alone.model.parts[0].mesh, machine);
    let set = SetUp::as_read(alone.clone());
    let cluster = Cluster::all(&alone.model);
    let stands = |up: &Vec3| {
        let turned = spread(&set, &cluster, &[Some(*up)], None, machine, &alone.file);
        turned.is_ok_and(|turned| has_plan(&turned.model))
    };
    let ups = || poses.others.iter().map(|pose| pose.up);
    ups().find(stands).or_else(|| Some(poses.cheaper()?.up))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;

    fn block(low: [f64; 3], high: [f64; 3]) -> (String, TriangleMesh<Object>) {
        ("block".to_owned(), solid_box(low.into(), high.into()))
    }

    #[test]
    fn what_hangs_in_the_air_is_not_moved() {
        let model = |low: f64| {
            Model::from_parts(vec![
                block([0.0, 0.0, 0.0], [10.0, 10.0, 2.0]),
                block([30.0, 0.0, low], [40.0, 10.0, low + 2.0]),
            ])
        };
        assert_eq!(Cluster::standing(&model(0.0)).len(), 2);
        assert!(Cluster::standing(&model(5.0)).is_empty());
    }

    #[test]
    fn what_lies_above_or_below_another_stays_with_it() {
        let model = Model::from_parts(vec![
            block([0.0, 0.0, 0.0], [10.0, 10.0, 2.0]),
            block([30.0, 0.0, 0.0], [40.0, 10.0, 2.0]),
            block([5.0, 5.0, 4.0], [15.0, 15.0, 6.0]),
            // Over the second and over the third.
            block([12.0, 2.0, 8.0], [32.0, 8.0, 9.0]),
            block([60.0, 0.0, 0.0], [70.0, 10.0, 2.0]),
        ]);
        let clusters: Vec<Vec<usize>> = Cluster::all(&model).into_iter().map(|cluster| cluster.parts).collect();
        assert_eq!(clusters, [vec![0, 1, 2, 3], vec![4]]);
    }

    #[test]
    fn what_stands_in_the_corner_of_an_l_is_loose() {
        let model = |x: f64| {
            Model::from_parts(vec![
                block([0.0, 0.0, 0.0], [20.0, 4.0, 2.0]),
                block([0.0, 4.0, 0.0], [4.0, 20.0, 2.0]),
                block([x, 10.0, 0.0], [x + 4.0, 14.0, 30.0]),
            ])
        };
        let clusters =
            |x: f64| -> Vec<Vec<usize>> { Cluster::all(&model(x)).into_iter().map(|cluster| cluster.parts).collect() };
        assert_eq!(clusters(10.0), [vec![0, 1], vec![2]]);
        assert_eq!(clusters(3.9), [vec![0, 1, 2]]);
    }
}
