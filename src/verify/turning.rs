//! Rule `turn-collision`: the table and everything on it against the head and the frame while the table turns.
//!
//! First the ball that everything sweeps about the pivot, at whatever pose: a head above it is free. Otherwise the turn
//! is stepped through by what is proved: with a gap `g`, nothing that moves less than `g` can meet anything.
//! Material counts as spheres (see [`Material::spheres`]), the head reaches upward without end, and the frame's
//! pieces are taken as they are.

use super::acts::Turn;
use super::hull::Hull;
use super::material::Material;
use crate::geom::convex::{separation, support};
use crate::geom::{Bounds, Vec3};
use crate::motion::{Pose, TableKinematics};

/// The least gap that counts as free, mm: it bounds the number of steps, and no machine is truer.
pub(super) const ROOM_MM: f64 = 0.1;
/// The longest step of the fastest point, mm; what the clearance given may fall short of the true one is half of it.
const STEP_MM: f64 = 1.0;
/// The head's upward reach, mm; beyond any machine.
const UPWARD: f64 = 2000.0;

/// How near a turn comes.
pub(super) struct Passage {
    /// Proved room over the whole turn, mm.
    pub(super) room: f64,
    /// The piece that is nearest.
    pub(super) piece: String,
}

/// The machine, for turns.
pub(super) struct Turning<'a> {
    pub(super) table: &'a TableKinematics,
    pub(super) head: &'a [Hull],
    pub(super) fixed: &'a [Hull],
}

impl Turning<'_> {
    /// The height (machine Z) that nothing passes, at whatever pose.
    pub(super) fn ball_top(&self, material: &Material) -> f64 {
        self.table.pivot.z + self.table.offset.norm() + material.reach
    }

    /// How far anything on the table is from its rotation axis.
    fn reach_about_rotation(&self, material: &Material) -> f64 {
        // Of an axis that leans from the table's own normal, any direction may be the farthest.
        if self.table.misaligned.is_some() { material.reach } else { material.reach_sideways }
    }

    /// How far the frame's pieces stay from the ball; infinite without any.
    fn frame_room(&self, material: &Material) -> f64 {
        let radius = self.table.offset.norm() + material.reach;
        self.fixed.iter().map(|h| h.distance(&self.table.pivot) - radius).fold(f64::INFINITY, f64::min)
    }

    /// The head's lowest point with its tip at height `z`.
    pub(super) fn lowest(&self, z: f64) -> f64 {
        let low = |h: &Hull| h.bounds.min.z + if h.body.follows[2] { z } else { 0.0 };
        self.head.iter().map(low).fold(f64::INFINITY, f64::min)
    }

    /// How near `turn` comes, up to `cap` mm; `None` where it starts or ends at an unknown pose or height below the
    /// ball.
    pub(super) fn passage(&self, turn: &Turn, material: &mut Material, cap: f64) -> Option<Passage> {
        let above = turn.tips.map(|[a, b]| self.lowest(a.min.z.min(b.min.z)) - self.ball_top(material));
        let clear_of_head = above.filter(|&room| room > ROOM_MM);
        let clear_of_frame = self.frame_room(material);
        if let (Some(room), true) = (clear_of_head, clear_of_frame > ROOM_MM) {
            return Some(Passage { room: room.min(clear_of_frame).min(cap), piece: "head".to_owned() });
        }
        let (from, to, [a, b]) = (turn.from?, turn.to?, turn.tips?);
        let (spheres, radius) = material.spheres();
        let scene =
            Scene { machine: self, slab: material.slab(), spheres: &spheres, radius, heads: clear_of_head.is_none() };
        let (tilt, rotation) = (to.tilt - from.tilt, to.rotation - from.rotation);
        let reach = self.table.offset.norm() + material.reach;
        let motion = reach * tilt.abs().rad() + self.reach_about_rotation(material) * rotation.abs().rad();
        let length = motion + (b.centre() - a.centre()).norm();
        Some(stepped(length, clear_of_head.unwrap_or(cap).min(cap), |share, enough| {
            let pose = Pose { tilt: from.tilt + tilt * share, rotation: from.rotation + rotation * share };
            let tips = Bounds { min: mix(a.min, b.min, share), max: mix(a.max, b.max, share) };
            let (gap, piece) = scene.gap(pose, &tips, enough);
            (gap, piece.to_owned())
        }))
    }

    /// The room between the frame's pieces and everything on the table, the table standing still; infinite without any.
    pub(super) fn standing(&self, pose: Pose, material: &mut Material) -> Passage {
        let mut nearest = Passage { room: f64::INFINITY, piece: String::new() };
        if !self.fixed.is_empty() {
            let (spheres, radius) = material.spheres();
            let scene = Scene { machine: self, slab: material.slab(), spheres: &spheres, radius, heads: false };
            let (room, piece) = scene.gap(pose, &Bounds::EMPTY, f64::INFINITY);
            nearest = Passage { room, piece: piece.to_owned() };
        }
        nearest
    }
}

/// Steps through a turn in which nothing moves by more than `length` mm: `gap` says how near things are at a share of it, if that is less than
/// enough, and which piece is. Up to `cap` mm.
pub(super) fn stepped(length: f64, cap: f64, mut gap: impl FnMut(f64, f64) -> (f64, String)) -> Passage {
    let mut nearest = Passage { room: cap, piece: "head".to_owned() };
    let mut done = 0.0;
    loop {
        let share: f64 = if length > 0.0 { (done / length).min(1.0) } else { 1.0 };
        let (gap, piece) = gap(share, nearest.room + STEP_MM);
        let step = (gap / 2.0).min(STEP_MM);
        let room = gap - step / 2.0;
        if room < nearest.room {
            nearest = Passage { room, piece };
        }
        if share >= 1.0 || gap < ROOM_MM {
            return nearest;
        }
        done += step;
    }
}

fn mix(a: Vec3, b: Vec3, share: f64) -> Vec3 {
    a + (b - a) * share
}

/// What can meet during one turn.
pub(super) struct Scene<'a> {
    pub(super) machine: &'a Turning<'a>,
    pub(super) slab: &'a [Vec3],
    pub(super) spheres: &'a [Vec3],
    pub(super) radius: f64,
    /// Whether the head is near enough to matter.
    pub(super) heads: bool,
}

impl Scene<'_> {
    /// A lower bound of the gap at one pose, the tip anywhere in `tips`, up to `enough`; and the nearest piece.
    pub(super) fn gap(&self, pose: Pose, tips: &Bounds, enough: f64) -> (f64, &str) {
        let motion = self.machine.table.forward(pose);
        let slab: Vec<Vec3> = self.slab.iter().map(|&p| motion.point(p.into()).at).collect();
        let mut least = (enough, "");
        let mut note = |gap: f64, piece| {
            if gap < least.0 {
                least = (gap, piece);
            }
            least.0
        };
        let known = (tips.max - tips.min).norm() < 1e-9;
        let heads = self.machine.head.iter().filter(|_| self.heads && known);
        let heads: Vec<(&Hull, Vec3)> = heads.map(|h| (h, h.body.origin_at(&tips.min))).collect();
        for (hull, origin) in &heads {
            note(apart(hull, origin, &slab, UPWARD), &hull.name);
        }
        for hull in self.machine.fixed {
            note(apart(hull, &Vec3::zeros(), &slab, 0.0), &hull.name);
        }
        let lowest = self.machine.lowest(tips.min.z);
        if self.heads && !known {
            // The head is somewhere at this height: everything must stay below it.
            note(slab.iter().map(|p| lowest - p.z).fold(f64::INFINITY, f64::min), "head");
        }
        for centre in self.spheres {
            let centre = motion.point((*centre).into()).at;
            let below = lowest - centre.z - self.radius;
            let mut enough = note(f64::INFINITY, "");
            if self.heads && below < enough {
                for (hull, origin) in &heads {
                    enough = note(hull.distance_below(&(centre - origin)) - self.radius, &hull.name);
                }
                if !known {
                    note(below, "head");
                }
            }
            for hull in self.machine.fixed {
                note(hull.distance(&centre) - self.radius, &hull.name);
            }
        }
        least
    }
}

/// A proved distance between a piece, raised by up to `upward`, and the slab.
fn apart(hull: &Hull, origin: &Vec3, slab: &[Vec3], upward: f64) -> f64 {
    let piece = |d: &Vec3| {
        let lift = if d.z > 0.0 { Vec3::z() * upward } else { Vec3::zeros() };
        support(&hull.body.points, d) + origin + lift
    };
    separation(|d| piece(d) - support(slab, &-d), f64::INFINITY).distance()
}
