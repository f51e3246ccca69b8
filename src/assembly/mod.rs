//! Parts as people draw them, made to meet: small gaps are closed, overlaps are cut off.
//!
//! The rest of the house knows parts that share faces exactly. Assemblies from CAD programs seldom do: a lid lies 0.05 mm above its
//! box, a pin has 0.1 mm of room in its hole, an arm ends somewhere inside its trunk. [`fit`] makes of those a model whose parts
//! share their faces, and says what it changed. What touches already stays as it is, to the bit.
//!
//! A lid that was drawn a little above its box is made to meet it:
//!
//! ```
//! use trunnion::assembly::{SNAP_MM, fit};
//! use trunnion::geom::Bounds;
//! use trunnion::mesh::{Model, TriangleMesh};
//!
//! // A box, and a lid that was drawn 0.1 mm above it (mm, the file's own frame): they share no face.
//! let cuboid =
//!     |z: [f64; 2]| TriangleMesh::cuboid(&Bounds { min: [0.0, 0.0, z[0]].into(), max: [10.0, 10.0, z[1]].into() });
//! let drawn =
//!     Model::from_parts(vec![("box".to_owned(), cuboid([0.0, 8.0])), ("lid".to_owned(), cuboid([8.1, 10.0]))]);
//! assert!(drawn.interfaces.is_empty());
//!
//! let fitted = fit(&drawn, SNAP_MM)?.ok_or("nothing was changed")?;
//! let met = Model::from_parts(fitted.parts);
//! // The lid lies on the whole of the box, 10 x 10 mm.
//! assert!((met.interfaces[0].area_mm2 - 100.0).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Lengths mm, frame [`Object`]. It must not know machines, poses or files.
//!
//! - **Gap** (`gaps.rs`): faces that look at each other across more than the interfaces' gap and at most `snap_mm`, where one of the
//!   parts would hang in the air otherwise: parts that each stand by themselves are apart on purpose, as bearings, hinges and chains are that
//!   are printed in place. The part whose
//!   face lies more wholly before the other one is drawn out: a plane face up to the other's plane, a curved one a little
//!   into the other part, which is then cut off like any overlap.
//! - **Overlap** (`solid.rs`): what two parts both fill goes to the earlier one; the later is cut along its surface. Where the later
//!   one would fall to pieces or vanish, the earlier one gives way: a pin through a plate leaves a plate with a hole. Where
//!   neither stays whole, [`fit_or_join`] makes them one solid.
//!
//! [`join`] makes solids of parts that touch or overlap instead; [`as_printed`] does with a project's volumes what its slicer does. Besides
//! ([`upright`], [`up_on`], [`stands`], [`in_rows`]): which way a model stands, and where several stand beside each other.
//!
//! The booleans are `boolmesh`'s, a port of Manifold (Lalish) in Rust; every result's volume is held against the parts'.

mod away;
mod canonical;
mod gaps;
mod solid;
mod standing;
#[cfg(test)]
mod tests;

pub use away::as_printed;
pub use standing::{in_rows, stands, up_on, upright};

use std::collections::BTreeSet;

use crate::geom::{Object, Sets};
use crate::mesh::{BoxTree, Model, Part, TriangleMesh, may_overlap, seen_to_overlap};
use crate::spelling::part_named;

/// Gaps that are closed where nothing else is asked for, mm: CAD clearances for parts that belong together.
pub const SNAP_MM: f64 = 0.2;
/// The widest gap that may be asked for, mm: about two lines; beyond it two parts are simply apart.
pub const MOST_SNAP_MM: f64 = 1.0;

/// So many parts are joined because they cannot be cut apart.
const MOST_JOINED: usize = 16;
/// A face that is drawn out may reach so far below the table, mm: rounding.
const BELOW_MM: f64 = 1e-6;
/// Overlaps thinner than this on the mean touch, mm: what the interfaces' own gap takes in.
const OVERLAP_MM: f64 = crate::mesh::INTERFACE_GAP_MM;

/// A model whose parts meet.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Names and meshes, in the model's order; fewer where some were joined.
    pub parts: Vec<(String, TriangleMesh<Object>)>,
    /// What was done, in order; never empty.
    pub changes: Vec<Change>,
}

/// What was done to a part.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// A face was drawn out.
    Closed {
        /// The part whose face it was.
        part: usize,
        /// The part it now meets.
        other: usize,
        /// How wide the gap was at its widest, mm.
        gap_mm: f64,
    },
    /// What two parts both filled was cut off from one of them.
    Cut {
        /// The part that gave way.
        part: usize,
        /// The part that kept it.
        other: usize,
        /// How much it was, mm³.
        volume_mm3: f64,
    },
    /// Two parts became one solid.
    Joined {
        /// The later part.
        part: usize,
        /// The earlier one.
        other: usize,
    },
}

impl Change {
    /// In a sentence; numbers and names are those of the model before.
    pub fn told(&self, model: &Model) -> String {
        let named = |id: usize| part_named(id, &model.parts[id].name);
        match *self {
            Self::Closed { part, other, gap_mm } => {
                format!(
                    "the gap of {gap_mm:.2} mm between {} and {} was closed (--snap 0 keeps it)",
                    named(part),
                    named(other)
                )
            }
            Self::Cut { part, other, volume_mm3 } => {
                format!("{} overlaps {}: {volume_mm3:.2} mm3 were removed from it", named(part), named(other))
            }
            Self::Joined { part, other } => format!("{} was joined to {}", named(part), named(other)),
        }
    }
}

impl Change {
    /// With the numbers that `ids` gives to those it has.
    fn with_numbers(self, ids: &[usize]) -> Self {
        match self {
            Self::Closed { part, other, gap_mm } => Self::Closed { part: ids[part], other: ids[other], gap_mm },
            Self::Cut { part, other, volume_mm3 } => Self::Cut { part: ids[part], other: ids[other], volume_mm3 },
            Self::Joined { part, other } => Self::Joined { part: ids[part], other: ids[other] },
        }
    }
}

impl FitError {
    /// With the numbers that `ids` gives to those it has.
    fn with_numbers(self, ids: &[usize]) -> Self {
        match self {
            Self::Failed { a, name_a, b, name_b, why } => Self::Failed { a: ids[a], name_a, b: ids[b], name_b, why },
            Self::Pieces { a, name_a, b, name_b, volume_mm3 } => {
                Self::Pieces { a: ids[a], name_a, b: ids[b], name_b, volume_mm3 }
            }
            other => other,
        }
    }
}

/// Parts that cannot be made to meet.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "assembly/")]
pub enum FitError {
    /// Overlapping parts of which neither can be cut.
    #[error(
        "parts {a} ({name_a}) and {b} ({name_b}) overlap by {volume_mm3:.2} mm3, and removing the overlap would leave either part in pieces or \
         empty; cut one from the other in CAD, or join them"
    )]
    Pieces {
        /// The earlier part.
        a: usize,
        /// Its name.
        name_a: String,
        /// The later one.
        b: usize,
        /// Its name.
        name_b: String,
        /// What both fill, mm³.
        volume_mm3: f64,
    },
    /// A negative volume that cannot be subtracted.
    #[error(
        "{who}: {away} cannot be subtracted ({why}); subtract it in the program that made the model",
        who = part_named(*part, name)
    )]
    Away {
        /// The part.
        part: usize,
        /// Its name.
        name: String,
        /// What was to be cut away.
        away: String,
        /// What went wrong.
        why: String,
    },
    /// A model of which subtraction leaves nothing.
    #[error("subtracting {away} leaves nothing of the model")]
    Nothing {
        /// What was cut away.
        away: String,
    },
    /// The boolean failed.
    #[error(
        "parts {a} ({name_a}) and {b} ({name_b}) overlap and cannot be separated ({why}); cut one from the other in CAD"
    )]
    Failed {
        /// The earlier part.
        a: usize,
        /// Its name.
        name_a: String,
        /// The later one.
        b: usize,
        /// Its name.
        name_b: String,
        /// What went wrong.
        why: String,
    },
}

/// The model with its small gaps closed and its overlaps cut off; `None` where there are none.
///
/// `snap_mm` is the widest gap that is closed, which it is beside a part that stands neither on the table nor on one that does; never so
/// that a part would reach below the model's lowest place.
///
/// # Errors
///
/// [`FitError`] with the two parts.
pub fn fit(model: &Model, snap_mm: f64) -> Result<Option<Fitted>, FitError> {
    let mut parts = model.parts.clone();
    let mut trees: Vec<BoxTree> = parts.iter().map(|part| BoxTree::new(&part.mesh)).collect();
    let mut changes = Vec::new();
    let touch = |a: usize, b: usize| model.interfaces.iter().find(|one| (one.a, one.b) == (a, b));
    let pairs = || (0..model.parts.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
    let mut reaching = Vec::new();
    let stands = standing(model);
    for (a, b) in pairs().filter(|&(a, b)| !(stands[a] && stands[b])) {
        let shared = touch(a, b).map_or(0.0, |one| one.area_mm2);
        let Some(gap) = gaps::widest([&parts[a], &parts[b]], [&trees[a], &trees[b]], snap_mm, shared) else { continue };
        let (part, other) = if gap.first_moves { (a, b) } else { (b, a) };
        if gap.closed.bounds().min.z < model.bounds.min.z - BELOW_MM {
            continue;
        }
        parts[part].mesh = gap.closed;
        trees[part] = BoxTree::new(&parts[part].mesh);
        if gap.reaches {
            reaching.push((a, b, part));
        }
        changes.push(Change::Closed { part, other, gap_mm: gap.mm });
    }
    for (a, b) in pairs() {
        let drawn_out = reaching.iter().find(|one| (one.0, one.1) == (a, b)).map(|one| one.2);
        let Some(cut) = cut_apart(&parts, a, b, &trees[b], touch(a, b).is_some(), drawn_out)? else { continue };
        parts[cut.part].mesh = cut.left;
        trees[cut.part] = BoxTree::new(&parts[cut.part].mesh);
        if drawn_out.is_none() {
            let other = a + b - cut.part;
            changes.push(Change::Cut { part: cut.part, other, volume_mm3: cut.volume_mm3 });
        }
    }
    if changes.is_empty() {
        return Ok(None);
    }
    Ok(Some(Fitted { parts: parts.into_iter().map(|part| (part.name, part.mesh)).collect(), changes }))
}

/// As [`fit`]; two parts of which neither can be cut along the other are one solid, as for any slicer.
///
/// # Errors
///
/// [`FitError::Failed`] with the two parts, by their numbers in `model`, and [`FitError::Pieces`] where they are too many: all pairs are looked at
/// after each.
pub fn fit_or_join(model: &Model, snap_mm: f64) -> Result<Option<Fitted>, FitError> {
    // The number in `model` of each part that is left.
    let mut ids: Vec<usize> = (0..model.parts.len()).collect();
    let (mut current, mut joined) = (None, Vec::new());
    loop {
        let now: &Model = current.as_ref().unwrap_or(model);
        let (a, b) = match fit(now, snap_mm) {
            Err(FitError::Pieces { a, b, .. }) if joined.len() < MOST_JOINED => (a, b),
            Err(error) => return Err(error.with_numbers(&ids)),
            Ok(None) if joined.is_empty() => return Ok(None),
            Ok(fitted) => {
                let as_they_are = || now.parts.iter().map(|part| (part.name.clone(), part.mesh.clone())).collect();
                let (parts, changes) = fitted.map_or_else(|| (as_they_are(), Vec::new()), |f| (f.parts, f.changes));
                let changes = joined.into_iter().chain(changes.into_iter().map(|change| change.with_numbers(&ids)));
                return Ok(Some(Fitted { parts, changes: changes.collect() }));
            }
        };
        let failed = |why| {
            let [name_a, name_b] = [a, b].map(|part| now.parts[part].name.clone());
            FitError::Failed { a: ids[a], name_a, b: ids[b], name_b, why }
        };
        let both = solid::joined_with(&now.parts[a].mesh, &now.parts[b].mesh).map_err(failed)?;
        let mut parts: Vec<_> = now.parts.iter().map(|part| (part.name.clone(), part.mesh.clone())).collect();
        parts[a].1 = both;
        parts.remove(b);
        joined.push(Change::Joined { part: ids[b], other: ids[a] });
        ids.remove(b);
        current = Some(Model::from_parts(parts));
    }
}

/// Whether each part stands on the table, is caught in others, or stands on parts that do or are.
fn standing(model: &Model) -> Vec<bool> {
    let bodies = model.bodies();
    let on_table: BTreeSet<usize> = model.in_place().into_iter().map(|part| bodies[part]).collect();
    bodies.iter().map(|body| on_table.contains(body)).collect()
}

/// The model with all parts that touch or overlap joined into solids, each under its first part's name, and what was joined to what;
/// `None` where nothing touches.
///
/// # Errors
///
/// [`FitError::Failed`] with the two parts.
pub fn join(model: &Model) -> Result<Option<Fitted>, FitError> {
    let mut parts = model.parts.clone();
    let mut sets = Sets::new(parts.len());
    let mut changes = Vec::new();
    for b in 0..parts.len() {
        for a in 0..b {
            let touch = model.interfaces.iter().any(|one| (one.a, one.b) == (a, b));
            let (one, two) = (&model.parts[a], &model.parts[b]);
            let (into, from) = (sets.root(a as u32), sets.root(b as u32));
            if into == from || !(touch || reach_into_each_other(one, two)) {
                continue;
            }
            let (into, from) = (into.min(from) as usize, into.max(from) as usize);
            let failed = |why| FitError::Failed {
                a: into,
                name_a: parts[into].name.clone(),
                b: from,
                name_b: parts[from].name.clone(),
                why,
            };
            parts[into].mesh = solid::joined_with(&parts[into].mesh, &parts[from].mesh).map_err(failed)?;
            // The lower number stands for both.
            sets.join(into as u32, from as u32);
            changes.push(Change::Joined { part: b, other: a });
        }
    }
    if changes.is_empty() {
        return Ok(None);
    }
    let kept = (0..parts.len()).filter(|&part| sets.root(part as u32) as usize == part);
    let parts = kept.map(|part| (parts[part].name.clone(), parts[part].mesh.clone())).collect();
    Ok(Some(Fitted { parts, changes }))
}

/// Whether two parts both fill more than the parts of an assembly touch; `tree` is the second one's.
fn overlap(one: &Part, two: &Part, tree: &BoxTree) -> bool {
    may_overlap(one, two, tree, false)
        && solid::common(&one.mesh, &two.mesh).is_ok_and(|common| common.thickness_mm() > OVERLAP_MM)
}

/// Whether two parts have more in common than a face, a side or a corner.
fn reach_into_each_other(one: &Part, two: &Part) -> bool {
    may_overlap(one, two, &BoxTree::new(&two.mesh), false)
        && solid::common(&one.mesh, &two.mesh).is_ok_and(|common| common.thickness_mm() > 0.0)
}

/// A part that gave way.
struct CutOff {
    part: usize,
    left: TriangleMesh<Object>,
    volume_mm3: f64,
}

/// Cuts the overlap of parts `a < b` off from one of them: the one that was drawn out, else the later one where it stays whole.
fn cut_apart(
    parts: &[Part],
    a: usize,
    b: usize,
    tree: &BoxTree,
    touch: bool,
    drawn_out: Option<usize>,
) -> Result<Option<CutOff>, FitError> {
    let (one, two) = (&parts[a], &parts[b]);
    if !may_overlap(one, two, tree, touch) {
        return Ok(None);
    }
    let names = || (one.name.clone(), two.name.clone());
    let failed = |why: String| {
        let (name_a, name_b) = names();
        FitError::Failed { a, name_a, b, name_b, why }
    };
    let common = match solid::common(&one.mesh, &two.mesh) {
        Ok(common) => common,
        // Surfaces that touch themselves are too much for the boolean; where nothing was seen to overlap, nothing is lost.
        Err(_) if drawn_out.is_none() && !seen_to_overlap(one, two) => return Ok(None),
        Err(why) => return Err(failed(why)),
    };
    let least = if drawn_out.is_some() { 0.0 } else { OVERLAP_MM };
    if common.thickness_mm() <= least {
        return Ok(None);
    }
    let first = drawn_out.unwrap_or(b);
    for part in [first, a + b - first] {
        let left = solid::less(&parts[part].mesh, &parts[a + b - part].mesh, &common).map_err(failed)?;
        if let Some(left) = left {
            return Ok(Some(CutOff { part, left, volume_mm3: common.volume_mm3 }));
        }
    }
    let (name_a, name_b) = names();
    Err(FitError::Pieces { a, name_a, b, name_b, volume_mm3: common.volume_mm3 })
}
