//! Whether a travel at a pose clears what stands there, and how high it must go if not.

use super::inputs::RewriteJob;
use crate::geom::{Bounds, Machine, Rigid, Vec3};
use crate::motion::{Pose, TableKinematics};
use crate::planning::{Head, HeadSeen, Solid, contact_mm, table_solid};

/// How deep the middle of the tip may run into what stands, in layers: by so much a slicer rounds a top up or down.
const GRAZE_LAYERS: f64 = 0.5;

/// Parts nearer than so many contact depths count as touching.
const NEAR_CONTACTS: f64 = 2.0;

/// What stands at one pose before a setup begins: the table, the parts printed before, and their supports.
pub(super) struct Obstacles<'a> {
    head: HeadSeen<'a>,
    /// The tip's middle alone.
    tip: Head,
    graze: f64,
    /// What stands: parts, supports, and the table last.
    solids: Vec<Solid>,
    /// Pairs of a part of the setup and the place in `solids` of one that it touches or nearly does.
    near: Vec<(usize, usize)>,
    contact: f64,
    /// Above this the tip clears everything, mm, machine Z.
    pub(super) over_all: f64,
}

impl<'a> Obstacles<'a> {
    /// `printing` are the parts of the setup, `supports` the corners of what supports were laid before, table frame.
    pub(super) fn at(
        pose: Pose,
        printed: &[usize],
        printing: &[usize],
        supports: &[Vec<Vec3>],
        job: &RewriteJob<'_>,
        table: &TableKinematics,
        head: &'a Head,
    ) -> Self {
        let (workpiece, profile, motion) = (job.workpiece, job.profile, table.forward(pose));
        let moved = |part: &usize| Solid::of(&workpiece.parts[*part]).moved(&motion.rotation, &motion.translation);
        let mut solids: Vec<Solid> = printed.iter().map(moved).collect();
        let contact = contact_mm(profile);
        let still = Rigid::<Machine, Machine>::shift(Vec3::zeros());
        let mut near = Vec::new();
        for part in printing {
            let own = moved(part);
            for (place, other) in solids.iter().enumerate() {
                let gap = own.swept_clearance(&still, [true; 3], &[Vec3::zeros()], other, NEAR_CONTACTS * contact);
                if gap.distance() < NEAR_CONTACTS * contact {
                    near.push((*part, place));
                }
            }
        }
        let on_machine = |corners: &Vec<Vec3>| {
            Solid::hull(corners.iter().map(|p| motion.rotation * p + motion.translation).collect())
        };
        solids.extend(supports.iter().map(on_machine));
        // Over a table that lies still no way across leads down to it.
        let counted = solids.len() + usize::from(table.head.is_none());
        solids.push(table_solid(profile, &motion));
        let top = solids[..counted].iter().map(|s| s.bounds.max.z).fold(f64::NEG_INFINITY, f64::max);
        Self {
            head: head.at(pose),
            tip: Head::point(),
            graze: profile.process.layer_height_mm * GRAZE_LAYERS,
            solids,
            near,
            contact,
            over_all: top + profile.transition.clearance_mm,
        }
    }

    /// Whether the straight travel of `part` is free. As everywhere the nozzle's rim may touch what it prints on, to the
    /// depth of a line; but across a top that stands beside the print it must not plough that deep, and past a part that the
    /// print does not touch it keeps as much room.
    pub(super) fn free(&self, part: usize, from: Vec3, to: Vec3) -> bool {
        self.within(part, &[from, to])
    }

    /// Whether the straight travel is free with as much room to spare: what a travel of our own owes, since it has no
    /// business near any surface, and printed surfaces stand out of the model's by a part of a layer.
    pub(super) fn well_free(&self, from: Vec3, to: Vec3) -> bool {
        self.solids.iter().all(|s| self.head.passes(from, to, s, -self.contact))
    }

    /// Whether every travel inside `region` (machine coordinates of the tip) is free.
    pub(super) fn free_within(&self, part: usize, region: &Bounds) -> bool {
        self.within(part, &region.corners())
    }

    fn within(&self, part: usize, corners: &[Vec3]) -> bool {
        let clear = |(place, solid): (usize, &Solid)| {
            let beside = place + 1 == self.solids.len() || self.near.contains(&(part, place));
            let lift = if beside { self.contact } else { -self.contact };
            self.head.sweeps_clear(corners, solid, lift) && self.tip.sweeps_clear(corners, solid, self.graze.min(lift))
        };
        self.solids.iter().enumerate().all(clear)
    }
}
