//! Rule `turn-collision` where it is the head that turns: all its pieces against the table and everything on it.
//!
//! First the height below which no piece comes at any angle of the turn: above everything on the table it is free. Otherwise the turn is
//! stepped through as that of a table is, in the tool's own frame, where table and print go round the head: nothing farther from a point about
//! which the head turns than `r` moves by more than `r` times the angle.

use super::acts::Turn;
use super::hull::Hull;
use super::material::Material;
use super::turning::{Passage, ROOM_MM, Scene, Turning, stepped};
use crate::geom::Bounds;
use crate::motion::{Pose, SwivelHead, TableKinematics};
use crate::planning::contact_mm;
use crate::profile::Profile;

/// A machine whose head turns.
pub(super) struct Swivelling<'a> {
    profile: &'a Profile,
    table: &'a TableKinematics,
    head: &'a SwivelHead,
}

impl<'a> Swivelling<'a> {
    /// `None` where the table turns alone.
    pub(super) fn of(profile: &'a Profile, table: &'a TableKinematics) -> Option<Self> {
        Some(Self { profile, table, head: table.head.as_ref()? })
    }

    /// How high the head's lowest point stays over everything on the table, with Z at `z` over it, at all angles from one tilt to another; at
    /// whatever angle where one is not known.
    fn room_above(&self, z: f64, ends: Option<[Pose; 2]>, material: &Material) -> f64 {
        z - self.profile.head_depth_mm(ends.map(|ends| ends.map(|pose| pose.tilt))) - material.top
    }

    /// The same where the pose is not known.
    pub(super) fn room_anywhere(&self, z: f64, material: &Material) -> f64 {
        self.room_above(z, None, material)
    }

    /// How near `turn` comes, up to `cap` mm; `None` where it starts or ends at an unknown pose or place below everything on the table.
    pub(super) fn passage(&self, turn: &Turn, material: &mut Material, cap: f64) -> Option<Passage> {
        let ends = turn.from.zip(turn.to).map(|(from, to)| [from, to]);
        let words = ends.zip(turn.tips).and_then(|(poses, tips)| {
            let known = tips.iter().all(|tip| (tip.max - tip.min).norm() < 1e-9);
            known.then(|| [0, 1].map(|i| self.head.words(tips[i].min, poses[i])))
        });
        // At an unknown pose a tip is where its words are.
        let z = match words {
            Some([a, b]) => a.z.min(b.z) - self.head.table.z,
            None if turn.from.is_none() => turn.tips?[0].min.z,
            None => return None,
        };
        let above = self.room_above(z, ends, material);
        if above > ROOM_MM {
            return Some(Passage { room: above.min(cap), piece: "head".to_owned() });
        }
        let (Some([from, to]), Some([a, b])) = (ends, words) else { return None };
        let (spheres, radius) = material.spheres();
        let (tilt, rotation) = (to.tilt - from.tilt, to.rotation - from.rotation);
        let levers = self.head.tilt_from_tip.norm() + 2.0 * self.head.rotation_from_tip.norm();
        let farthest = [a, b].map(|words| (words - self.head.table).norm()).into_iter().fold(0.0, f64::max) + levers;
        let length = (farthest + material.reach) * (tilt.abs().rad() + rotation.abs().rad()) + (b - a).norm();
        Some(stepped(length, cap, |share, enough| {
            let pose = Pose { tilt: from.tilt + tilt * share, rotation: from.rotation + rotation * share };
            let tip = self.head.tip(a + (b - a) * share, pose);
            let head = head_at(self.profile, pose);
            let machine = Turning { table: self.table, head: &head, fixed: &[] };
            let scene = Scene { machine: &machine, slab: material.slab(), spheres: &spheres, radius, heads: true };
            let (gap, piece) = scene.gap(pose, &Bounds::of([tip]), enough);
            (gap, piece.to_owned())
        }))
    }
}

/// The head's pieces as the tool sees them at a pose.
pub(super) fn head_at(profile: &Profile, pose: Pose) -> Vec<Hull> {
    let contact = contact_mm(profile);
    profile.head_bodies_at(pose).into_iter().map(|body| Hull::new(body, contact)).collect()
}
