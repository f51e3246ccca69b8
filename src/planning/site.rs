//! Parts at their poses: who is in whose way, and how much room is left.

use rayon::prelude::*;

use super::candidates::{Candidate, Setups};
use super::collision::{Clearance, HeadSeen};
use super::owed::{LIFT_LAYERS, Owed, TOUCHING_MM, contact_mm};
use super::part_set::PartSet;
use super::sequence::{Choice, Sequence};
use super::solid::Solid;
use crate::geom::{Machine, Rigid, Table, Vec3};
use crate::mesh::TriangleMesh;

/// Clearances beyond this are not worked out, mm.
pub const CLEARANCE_SOUGHT_MM: f64 = 20.0;

/// Collision questions about one placement.
pub(super) struct Site<'a> {
    setups: &'a Setups<'a>,
    /// What is owed to parts that are near, and to all others.
    neighbour: Owed,
    others: Owed,
    /// Parts that share an interface.
    pub(super) touching: Vec<PartSet>,
    /// Parts that lie so near to each other that the head cannot keep its margin from the one at the other.
    near: Vec<PartSet>,
    /// By setup.
    motions: Vec<Rigid<Table, Machine>>,
    /// The same: the head as the tool sees it.
    heads: Vec<HeadSeen<'a>>,
    /// By setup: parts that the frame would meet.
    at_frame: Vec<PartSet>,
}

impl<'a> Site<'a> {
    pub(super) fn of(setups: &'a Setups<'a>, margin_mm: f64) -> Self {
        let parts = setups.workpiece.parts.len();
        let mut touching = vec![PartSet::new(parts); parts];
        for interface in &setups.workpiece.model.interfaces {
            touching[interface.a].insert(interface.b);
            touching[interface.b].insert(interface.a);
        }
        let neighbour = Owed::to_neighbour(setups.profile);
        let others = Owed::to_others(setups.profile, margin_mm);
        let near = near(&setups.solids, others.rest.mm + contact_mm(setups.profile));
        let motions: Vec<_> = setups.poses.iter().map(|(_, pose)| setups.table.forward(*pose)).collect();
        let heads = setups.poses.iter().map(|(_, pose)| setups.head.at(*pose)).collect();
        let frame = setups.profile.fixed_bodies();
        let at_frame = motions.iter().map(|motion| {
            let back: Rigid<Machine, Table> = motion.inverse();
            let pieces: Vec<Solid> = frame
                .iter()
                .map(|b| Solid::hull(b.points.iter().map(|p| back.rotation * p + back.translation).collect()))
                .collect();
            let meets = |q: &usize| {
                pieces.iter().any(|piece| comes_within(&setups.solids[*q], piece, margin_mm.max(TOUCHING_MM)))
            };
            set_of(parts, (0..parts).filter(meets))
        });
        let at_frame = at_frame.collect();
        Self { setups, neighbour, others, touching, near, motions, heads, at_frame }
    }

    /// What the head that prints `part` owes `other`.
    fn owed(&self, part: usize, other: usize) -> &Owed {
        if self.near[part].has(other) { &self.neighbour } else { &self.others }
    }

    /// `[part][candidate]` -> the parts that must not be there before.
    pub(super) fn blocked(&self, candidates: &[Vec<Candidate>]) -> Vec<Vec<PartSet>> {
        let parts = candidates.len();
        // One task a candidate: parts differ a hundredfold in facets.
        let tasks: Vec<(usize, usize)> =
            candidates.iter().enumerate().flat_map(|(part, c)| c.iter().map(move |c| (part, c.setup))).collect();
        let one = |&(part, setup): &(usize, usize)| {
            set_of(parts, (0..parts).filter(|&q| q != part && self.blocks(part, q, setup)))
        };
        let mut sets = tasks.par_iter().map(one).collect::<Vec<PartSet>>().into_iter();
        candidates.iter().map(|c| sets.by_ref().take(c.len()).collect()).collect()
    }

    /// Whether `other` must not be there before `part` is printed in `setup`.
    pub(super) fn blocks(&self, part: usize, other: usize, setup: usize) -> bool {
        let solids = &self.setups.solids;
        let (motion, owed) = (&self.motions[setup], self.owed(part, other));
        self.at_frame[setup].has(other) || !self.heads[setup].gives_owed(motion, &solids[part], &solids[other], owed)
    }

    /// The piece of the head that comes nearer to `other` than it owes while it prints `part` in `setup`.
    fn offence(&self, part: usize, other: usize, setup: usize) -> Option<Clearance> {
        let solids = &self.setups.solids;
        let owed = self.owed(part, other);
        self.heads[setup].offence(&self.motions[setup], &solids[part], &solids[other], owed, 0.0)
    }

    /// What reaches into `other`, and how deep, mm; for explanations.
    pub(super) fn intrusion(&self, part: usize, other: usize, setup: usize) -> (String, f64) {
        let Some(Clearance { mm, piece }) = self.offence(part, other, setup) else {
            return (format!("part {other} would come too close to the machine's frame"), 0.0);
        };
        let (solids, owed) = (&self.setups.solids, self.owed(part, other));
        if mm > 0.0 && !self.near[part].has(other) {
            return (
                format!("the {piece} would clear part {other} by only {mm:.1} mm (required: {:.1} mm)", owed.rest.mm),
                0.0,
            );
        }
        let depth = self.heads[setup].depth(&self.motions[setup], &solids[part], &solids[other], owed);
        (format!("the {piece} would reach {depth:.1} mm into part {other}"), depth)
    }

    /// A tip position on `part`, table frame, at which the head strikes `other` (the table if `None`), among points spread
    /// over its facets; the one nearest to the middle of all that strike. For pictures only.
    pub(super) fn strikes(&self, part: usize, other: Option<usize>, setup: usize) -> Option<Vec3> {
        let table = self.setups.owed_to_table(part, &self.motions[setup]);
        let (obstacle, owed) = match other {
            Some(other) => (&self.setups.solids[other], self.owed(part, other)),
            None => (&self.setups.slab, &table),
        };
        let strikes = |tip: &Vec3| {
            let swept = Solid::hull(vec![*tip]);
            self.heads[setup].offence(&self.motions[setup], &swept, obstacle, owed, 0.0).is_some()
        };
        let struck: Vec<Vec3> = spread(&self.setups.workpiece.parts[part]).into_iter().filter(strikes).collect();
        let middle = struck.iter().sum::<Vec3>() / struck.len().max(1) as f64;
        struck.into_iter().min_by(|a, b| (a - middle).norm().total_cmp(&(b - middle).norm()))
    }

    /// The least room between the head and what it passes in `sequence`, mm; at most [`CLEARANCE_SOUGHT_MM`].
    pub(super) fn clearance(&self, candidates: &[Vec<Candidate>], sequence: &Sequence) -> f64 {
        let mut least = CLEARANCE_SOUGHT_MM;
        let mut printed: Vec<usize> = Vec::new();
        let setup_of = |&(part, k): &Choice| candidates[part][k].setup;
        for slot in sequence {
            // The parts of one setup grow together and are no obstacles to each other.
            for group in slot.chunk_by(|a, b| setup_of(a) == setup_of(b)) {
                for choice in group {
                    least = self.room(choice.0, setup_of(choice), &printed, least);
                }
                printed.extend(group.iter().map(|&(part, _)| part));
            }
        }
        least
    }

    fn room(&self, part: usize, setup: usize, printed: &[usize], enough: f64) -> f64 {
        let mut least = enough;
        for &other in printed.iter().filter(|&&q| !self.near[part].has(q)) {
            let (solids, lift) = (&self.setups.solids, LIFT_LAYERS * self.setups.profile.process.layer_height_mm);
            let clearance =
                self.heads[setup].clearance(&self.motions[setup], &solids[part], &solids[other], lift, least);
            least = clearance.mm.min(least);
        }
        if !self.setups.workpiece.model.is_in_place(part) {
            let (motion, solid) = (&self.motions[setup], &self.setups.solids[part]);
            least = self.heads[setup].clearance(motion, solid, &self.setups.slab, 0.0, least).mm.min(least);
        }
        least
    }
}

/// The parts of `members`, in a set for `parts`.
pub(super) fn set_of(parts: usize, members: impl IntoIterator<Item = usize>) -> PartSet {
    let mut set = PartSet::new(parts);
    members.into_iter().for_each(|p| set.insert(p));
    set
}

/// Some 1000 points on a mesh, at least one a facet.
fn spread(mesh: &TriangleMesh<Table>) -> Vec<Vec3> {
    let steps = (1000 / mesh.facets().len().max(1)).isqrt().clamp(1, 24);
    let mut points = Vec::new();
    for facet in 0..mesh.facets().len() {
        let [a, b, c] = mesh.corners(facet);
        for i in 0..steps {
            for j in 0..steps - i {
                let at = |k: usize| (k as f64 + 1.0 / 3.0) / steps as f64;
                points.push(a + (b - a) * at(i) + (c - a) * at(j));
            }
        }
    }
    points
}

fn comes_within(a: &Solid, b: &Solid, mm: f64) -> bool {
    let still = Rigid::<Table, Table>::shift(Vec3::zeros());
    a.swept_clearance(&still, [true; 3], &[Vec3::zeros()], b, mm).distance() < mm
}

/// For each part: those within `reach` mm of it.
fn near(solids: &[Solid], reach: f64) -> Vec<PartSet> {
    let still = Rigid::<Table, Table>::shift(Vec3::zeros());
    let point = [Vec3::zeros()];
    let within = |part: usize, q: usize| {
        solids[part].swept_clearance(&still, [true; 3], &point, &solids[q], reach).distance() < reach
    };
    let of_part = |part: usize| set_of(solids.len(), (0..solids.len()).filter(|&q| q != part && within(part, q)));
    (0..solids.len()).into_par_iter().map(of_part).collect()
}
