//! Whether a part, printed along a direction, stands on something everywhere.
//!
//! Two things are asked. Every facet that overhangs beyond the threshold must lie on the table or on an earlier part;
//! and every place where the part *begins* (a lowest point of its surface, a ridge too flat to hang on) must do so too, since steep
//! walls that meet in a point overhang nowhere and still begin in the air.
//!
//! Where facets say no, the rule by layers ([`overhang::unsupported`]) may still say yes: bridges, roofs of holes, small patches.
//! It is asked only where there is no plan without it.
//!
//! Angles from the vertical: a wall is 0, a ceiling 90 (PrusaSlicer counts from the horizontal).

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock};

use super::part_set::PartSet;
use super::workpiece::Workpiece;
use crate::geom::{Angle, Dir, Rigid, Slot, Table, Vec3};
use crate::mesh::TriangleMesh;
use crate::overhang::{self, Cause, Droop, Footing, Ground, OverhangRule, Patch, Relief};

/// What one part needs below it at one direction.
#[derive(Clone, Debug)]
pub(super) struct Needs {
    /// Overhanging area that neither the table nor anything else can carry or that neighbours must carry, mm².
    overhang_mm2: f64,
    /// What each neighbour carries of it: part, mm².
    carried: Vec<(usize, f64)>,
    /// For each beginning that does not stand on the table: the parts it may stand on.
    beginnings: Vec<PartSet>,
    /// What may be missing, mm².
    allowed_mm2: f64,
    /// What the layers lay on nothing though every neighbour stands; empty where facets decide.
    pub(super) left: Vec<Patch>,
    /// What facets alone would miss though every neighbour stands, mm².
    pub(super) facets_mm2: f64,
    /// Whether `left` is all there is.
    pub(super) closely: bool,
    /// Parts of earlier slots, as somebody demands.
    after: Vec<usize>,
}

/// Overhang that is let pass: f32 files do not close to the last square millimetre.
const SLACK_MM2: f64 = 0.5;
/// Facets within this many degrees of the threshold still count as below it.
const ANGLE_SLACK_DEG: f64 = 0.5;
/// A facet this near to the table's surface lies on it, mm.
const ON_TABLE: f64 = 0.05;

impl Needs {
    /// A part that needs a support nothing gives.
    #[cfg(test)]
    pub(super) fn support() -> Self {
        Self { overhang_mm2: 100.0, ..Self::none() }
    }

    /// A part that only `other` carries.
    #[cfg(test)]
    pub(super) fn carried_by(other: usize) -> Self {
        Self { overhang_mm2: 100.0, carried: vec![(other, 100.0)], ..Self::none() }
    }

    /// A part that stands anywhere.
    pub(super) fn none() -> Self {
        let (carried, beginnings, left, after) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { overhang_mm2: 0.0, carried, beginnings, allowed_mm2: 0.0, left, facets_mm2: 0.0, closely: true, after }
    }

    /// The parts it may have to wait for, ascending.
    pub(super) fn carriers(&self) -> Vec<usize> {
        let below = self.beginnings.iter().flat_map(PartSet::iter);
        let mut parts: Vec<usize> = self.carried.iter().map(|(q, _)| *q).chain(below).collect();
        parts.sort_unstable();
        parts.dedup();
        parts
    }

    /// The overhang that nothing in `printed` carries, mm²; 0 within the slack and what is allowed.
    pub(super) fn missing(&self, printed: &PartSet) -> f64 {
        let carried: f64 = self.carried.iter().filter(|(q, _)| printed.has(*q)).map(|(_, area)| area).sum();
        let missing = self.overhang_mm2 - carried;
        if missing > SLACK_MM2.max(self.allowed_mm2) { missing } else { 0.0 }
    }

    /// Whether every beginning stands on the table or on a part of `printed`.
    pub(super) fn begins_on(&self, printed: &PartSet) -> bool {
        self.beginnings.iter().all(|below| below.meets(printed))
    }

    /// The same, behind `parts` too.
    pub(super) fn behind(self, parts: Vec<usize>) -> Self {
        Self { after: parts, ..self }
    }

    /// Both at once, and everything is there that is demanded to come before.
    pub(super) fn met_by(&self, printed: &PartSet) -> bool {
        self.after.iter().all(|&part| printed.has(part)) && self.begins_on(printed) && self.missing(printed) == 0.0
    }

    /// How much is missing while `everyone` stands, for an order: what was looked at closely comes first.
    pub(super) fn rank(&self, everyone: &PartSet) -> (bool, f64) {
        let rough = !self.closely;
        (rough, if rough { self.facets_mm2 } else { self.missing(everyone) })
    }

    /// With what the layers say in the place of what the facets say cannot be carried, and of what begins on no part.
    fn by_layers(mut self, left: Vec<Patch>, closely: bool) -> Self {
        self.beginnings.retain(|below| below.iter().next().is_some());
        if left.iter().any(|patch| patch.cause == Cause::Island) {
            self.beginnings.push(PartSet::new(0));
        }
        let carried: f64 = self.carried.iter().map(|(_, area)| area).sum();
        let loose: f64 = left.iter().map(|patch| patch.area_mm2).sum();
        Self { overhang_mm2: carried + loose, left, closely, ..self }
    }
}

/// What was found out about parts and directions: every remedy asks for it again, and it is the same each time.
#[derive(Clone, Debug, Default)]
pub struct Known(Arc<Answers>);

/// By the numbers of part, direction and rule.
#[derive(Debug, Default)]
struct Answers {
    patches: Mutex<HashMap<Key, Arc<Vec<Patch>>>>,
    neighbours: Mutex<HashMap<Key, Arc<Neighbours>>>,
    needs: Mutex<HashMap<Key, Arc<Needs>>>,
}

type Key = Vec<u64>;

fn or_find<T>(known: &Mutex<HashMap<Key, Arc<T>>>, key: Key, find: impl FnOnce() -> T) -> Arc<T> {
    let found = known.lock().ok().and_then(|map| map.get(&key).cloned());
    found.unwrap_or_else(|| {
        let found = Arc::new(find());
        if let Ok(mut map) = known.lock() {
            map.insert(key, found.clone());
        }
        found
    })
}

impl Known {
    /// The neighbours of `part`.
    pub(super) fn neighbours(&self, workpiece: &Workpiece<'_>, part: usize) -> Arc<Neighbours> {
        or_find(&self.0.neighbours, Neighbours::key(workpiece, part), || Neighbours::of(workpiece, part))
    }
}

/// What is let pass, and how far layers are looked through.
pub(super) struct NeedsAsked<'a> {
    pub(super) rule: OverhangRule,
    /// What may be missing, mm².
    pub(super) allowed_mm2: f64,
    /// Whether the layers decide where facets say no.
    pub(super) by_layers: bool,
    /// Whether one layer that is not tolerated is answer enough.
    pub(super) enough: bool,
    /// Whether all that stands on the table grows together.
    pub(super) together: bool,
    /// Whether all layers are known to lie on something while the neighbours stand.
    pub(super) layered: bool,
    pub(super) known: &'a Known,
}

impl NeedsAsked<'_> {
    /// What tells this question from all others, but for what is let pass.
    fn key(&self, neighbours: &Neighbours, up: Dir<Table>) -> Key {
        let OverhangRule { overhang, layer_mm, line_mm, bridge_mm, tolerate_mm2, droops } = self.rule;
        let up = up.unit();
        let numbers = [overhang.rad(), layer_mm, line_mm, bridge_mm, tolerate_mm2, up.x, up.y, up.z];
        let rule = numbers.map(f64::to_bits).into_iter().chain([self.enough, self.together, droops].map(u64::from));
        neighbours.key.iter().copied().chain(rule).collect()
    }
}

/// Who lies on each facet of a part.
#[derive(Debug)]
pub(super) struct Neighbours {
    /// For each facet: (part, shared area).
    on_facet: Vec<Vec<(usize, f64)>>,
    /// Facets that lie on the table.
    on_table: Vec<bool>,
    relief: Relief,
    /// What lies under the facets of each interface, and the table's.
    footings: Vec<Footing>,
    /// The parts that share no face with it and may lie below some of it where both stand on the table, as one mesh.
    near: Option<Arc<TriangleMesh<Slot>>>,
    /// What tells this part where it stands from all others.
    key: Vec<u64>,
    /// For each vertex the parts on which it stands, once somebody has asked: the same in all directions.
    carriers: Vec<OnceLock<Vec<usize>>>,
}

/// An interface that covers this share of its facets is as large as they are.
const COVERED: f64 = 0.999;

impl Neighbours {
    /// The neighbours of `part`.
    fn of(workpiece: &Workpiece<'_>, part: usize) -> Self {
        let mesh = &workpiece.parts[part];
        let mut on_facet = vec![Vec::new(); mesh.facets().len()];
        let mut footings: Vec<Footing> = Vec::new();
        for interface in &workpiece.model.interfaces {
            let (other, facets, theirs) = if interface.a == part {
                (interface.b, &interface.facets_a, &interface.facets_b)
            } else if interface.b == part {
                (interface.a, &interface.facets_b, &interface.facets_a)
            } else {
                continue;
            };
            for &(facet, area) in facets {
                on_facet[facet].push((other, area));
            }
            let whole: f64 = facets.iter().map(|(f, _)| mesh.facet_area(*f)).sum();
            let covered = interface.area_mm2 > COVERED * whole;
            let below = theirs.iter().filter(|_| !covered).map(|(f, _)| workpiece.parts[other].corners(*f)).collect();
            footings.push(Footing { own: facets.iter().map(|(f, _)| mesh.corners(*f)).collect(), below });
        }
        let on_table: Vec<bool> = (0..mesh.facets().len()).map(|i| lies_on_table(mesh, i)).collect();
        let table = (0..on_table.len()).filter(|&f| on_table[f]).map(|f| mesh.corners(f)).collect();
        footings.push(Footing { own: table, below: Vec::new() });
        let relief = Relief::of(mesh.vertices().to_vec(), mesh.facets().to_vec());
        let key = Self::key(workpiece, part);
        let carriers = vec![OnceLock::new(); mesh.vertices().len()];
        let in_place = on_table.contains(&true) || workpiece.model.captive.contains(&part);
        let others = if in_place { near(workpiece, part) } else { Vec::new() };
        let near = TriangleMesh::joined(others.iter().map(|&other| &workpiece.parts[other]));
        let near = (!others.is_empty()).then(|| Arc::new(near.moved(&Rigid::shift(Vec3::zeros()))));
        Self { on_facet, on_table, relief, footings, near, key, carriers }
    }

    /// What tells a part where it stands, and what it shares with others, from all that a search asks about.
    fn key(workpiece: &Workpiece<'_>, part: usize) -> Key {
        let mesh = &workpiece.parts[part];
        let counts = [part, mesh.facets().len(), mesh.vertices().len()].map(|n| n as u64);
        let first = mesh.vertices().iter().take(3).flat_map(|v| v.iter().map(|x| x.to_bits()));
        let shared = workpiece.model.interfaces.iter().filter(|one| one.a == part || one.b == part);
        let shared = shared.flat_map(|one| [(one.a + one.b - part) as u64, one.area_mm2.to_bits()]);
        let first_of = |other: &TriangleMesh<Table>| other.vertices().first().map_or([0.0; 3], |v| (*v).into());
        let near = near(workpiece, part).into_iter();
        let near = near.flat_map(|other| [other as f64].into_iter().chain(first_of(&workpiece.parts[other])));
        counts.into_iter().chain(first).chain(shared).chain(near.map(f64::to_bits)).collect()
    }

    /// The parts on which a vertex stands.
    fn carriers(&self, mesh: &TriangleMesh<Table>, vertex: usize) -> Vec<usize> {
        self.carriers[vertex].get_or_init(|| carriers(mesh, self, vertex)).clone()
    }

    /// What it lies on when it is printed along `up`; `together`: while all that stands on the table grows beside it.
    fn ground(&self, up: Dir<Table>, begins_mm: Vec<f64>, together: bool) -> Ground {
        let table = is_upright(up) && self.on_table.contains(&true);
        let others = if together && is_upright(up) { self.near.clone() } else { None };
        Ground { footings: self.footings.clone(), table, begins_mm, others, ..Ground::default() }
    }

    /// What droops while all neighbours stand, the largest first.
    pub(super) fn droops(
        &self,
        mesh: &TriangleMesh<Table>,
        up: Dir<Table>,
        rule: &OverhangRule,
        together: bool,
    ) -> Vec<Droop> {
        let lies = |f: usize| self.carries(mesh, f);
        overhang::judged(mesh, up.unit(), &self.ground(up, Vec::new(), together), lies, rule, false).droops
    }

    /// Whether a facet lies on the table or a neighbour, whole.
    fn carries(&self, mesh: &TriangleMesh<Table>, facet: usize) -> bool {
        let shared: f64 = self.on_facet[facet].iter().map(|(_, area)| area).sum();
        self.on_table[facet] || shared > COVERED * mesh.facet_area(facet)
    }
}

fn is_upright(up: Dir<Table>) -> bool {
    up.unit().z > 1.0 - 1e-9
}

/// The parts printed in place that hang together with other bodies than `part`, and whose boxes lie below some of it, seen from above.
fn near(workpiece: &Workpiece<'_>, part: usize) -> Vec<usize> {
    let own = workpiece.parts[part].bounds();
    let lies_below = |other: &usize| {
        let bounds = workpiece.parts[*other].bounds();
        *other != part && (0..2).all(|i| own.min[i] < bounds.max[i] && bounds.min[i] < own.max[i])
    };
    let mut all: Vec<usize> = workpiece.model.in_place().into_iter().filter(lies_below).collect();
    if !all.is_empty() {
        let body = workpiece.model.bodies();
        all.retain(|&other| body[other] != body[part]);
    }
    all
}

fn lies_on_table(mesh: &TriangleMesh<Table>, facet: usize) -> bool {
    mesh.corners(facet).iter().all(|c| c.z.abs() < ON_TABLE) && mesh.normal(facet).is_some_and(|n| n.z < -0.99)
}

/// What `mesh` needs when printed along `up`.
pub(super) fn needs(
    mesh: &TriangleMesh<Table>,
    neighbours: &Neighbours,
    up: Dir<Table>,
    asked: &NeedsAsked<'_>,
    parts: usize,
) -> Needs {
    let mut key = asked.key(neighbours, up);
    key.extend([parts as u64, asked.allowed_mm2.to_bits(), u64::from(asked.by_layers), u64::from(asked.layered)]);
    or_find(&asked.known.0.needs, key, || found(mesh, neighbours, up, asked, parts)).as_ref().clone()
}

fn found(
    mesh: &TriangleMesh<Table>,
    neighbours: &Neighbours,
    up: Dir<Table>,
    asked: &NeedsAsked<'_>,
    parts: usize,
) -> Needs {
    let steepest = (asked.rule.overhang + Angle::from_deg(ANGLE_SLACK_DEG)).rad().sin();
    let mut overhang_mm2 = 0.0;
    let mut carried: Vec<(usize, f64)> = Vec::new();
    for facet in 0..mesh.facets().len() {
        let Some(normal) = mesh.normal(facet) else { continue };
        if -normal.dot(up.unit()) <= steepest || neighbours.on_table[facet] {
            continue;
        }
        overhang_mm2 += mesh.facet_area(facet);
        for &(other, area) in &neighbours.on_facet[facet] {
            match carried.iter_mut().find(|(q, _)| *q == other) {
                Some((_, sum)) => *sum += area,
                None => carried.push((other, area)),
            }
        }
    }
    let (beginnings, begins_mm) = beginnings(mesh, neighbours, up, &asked.rule, parts);
    let facets_mm2 = overhang_mm2 - carried.iter().map(|(_, area)| area).sum::<f64>();
    let needs =
        Needs { overhang_mm2, carried, beginnings, allowed_mm2: asked.allowed_mm2, facets_mm2, ..Needs::none() };
    let mut everyone = PartSet::new(parts);
    (0..parts).for_each(|q| everyone.insert(q));
    if !asked.by_layers || needs.missing(&everyone) == 0.0 && begins_mm.is_empty() {
        return needs;
    }
    // Who looked at the layers has not looked for what begins in mid-air between them.
    let known = asked.layered && begins_mm.is_empty();
    let left = if known { Vec::new() } else { by_layers(mesh, neighbours, up, &begins_mm, asked) };
    needs.by_layers(left, !asked.enough)
}

/// What the layers lay on nothing while all neighbours stand.
fn by_layers(
    mesh: &TriangleMesh<Table>,
    neighbours: &Neighbours,
    up: Dir<Table>,
    begins_mm: &[f64],
    asked: &NeedsAsked<'_>,
) -> Vec<Patch> {
    let key = asked.key(neighbours, up);
    let find = || {
        let ground = neighbours.ground(up, begins_mm.to_vec(), asked.together);
        overhang::unsupported(mesh, up.unit(), &ground, |f| neighbours.carries(mesh, f), &asked.rule, asked.enough)
    };
    or_find(&asked.known.0.patches, key, find).to_vec()
}

/// Where the surface begins along `up`, and the ridges that hang too far, as the parts each may stand on; those on the table are left
/// out. With the heights of those that stand on no part.
fn beginnings(
    mesh: &TriangleMesh<Table>,
    neighbours: &Neighbours,
    up: Dir<Table>,
    rule: &OverhangRule,
    parts: usize,
) -> (Vec<PartSet>, Vec<f64>) {
    let relief = &neighbours.relief;
    let heights = relief.heights(up.unit(), |f| neighbours.on_table[f]);
    let (mut found, mut in_air): (Vec<PartSet>, Vec<f64>) = (Vec::new(), Vec::new());
    let height = |v: u32| mesh.vertices()[v as usize].dot(up.unit());
    let mut add = |vertex: u32, carriers: Vec<usize>| {
        let mut below = PartSet::new(parts);
        if carriers.is_empty() {
            in_air.push(height(vertex));
        }
        carriers.into_iter().for_each(|other| below.insert(other));
        if !found.contains(&below) {
            found.push(below);
        }
    };
    for first in relief.beginnings(&heights, up.unit(), rule.layer_mm) {
        // Each corner of a flat foot begins for itself: they may stand on different parts.
        for vertex in relief.level_with(&heights, first) {
            if relief.looks_down(vertex, up.unit()) {
                add(vertex, neighbours.carriers(mesh, vertex as usize));
            }
        }
    }
    let stands = |f: usize| neighbours.on_table[f] || !neighbours.on_facet[f].is_empty();
    for ridge in relief.ridges(up.unit(), stands, &rule.hang()) {
        ridge.edges.iter().flatten().for_each(|&vertex| add(vertex, Vec::new()));
    }
    (found, in_air)
}

/// The parts on which `vertex` stands, ascending: those that share a facet of the flat face around it.
///
/// A sliver of a fanned cap shares too little area to count as an interface itself, so the facets next to the vertex's
/// own are asked too, as long as the vertex lies in their plane.
fn carriers(mesh: &TriangleMesh<Table>, neighbours: &Neighbours, vertex: usize) -> Vec<usize> {
    let at = mesh.vertices()[vertex];
    let relief = &neighbours.relief;
    let mut corners: Vec<u32> = relief.facets_at(vertex).iter().flat_map(|&f| mesh.facets()[f as usize]).collect();
    corners.sort_unstable();
    corners.dedup();
    let mut parts: Vec<usize> = Vec::new();
    for facet in corners.iter().flat_map(|&corner| relief.facets_at(corner as usize)).map(|&f| f as usize) {
        let more = neighbours.on_facet[facet].iter().map(|&(part, _)| part).filter(|part| !parts.contains(part));
        let more: Vec<usize> = more.collect();
        let in_plane = |n: Vec3| (at - mesh.corners(facet)[0]).dot(&n).abs() < ON_TABLE;
        if !more.is_empty() && mesh.normal(facet).is_some_and(in_plane) {
            parts.extend(more);
        }
    }
    parts.sort_unstable();
    parts.dedup();
    parts
}
