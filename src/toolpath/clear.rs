//! Whether a travel at a pose clears what stands there, and how high it must go if not.

use crate::geom::{Bounds, Vec3};
use crate::motion::{Pose, TableKinematics};
use crate::planning::{Head, Solid, Workpiece, contact_mm, table_solid};
use crate::profile::Profile;

/// How deep the middle of the tip may run into what stands, in layers: by so much a slicer rounds a top up or down.
const GRAZE_LAYERS: f64 = 0.5;

/// What stands at one pose before a setup begins: the table and the parts printed before.
pub(super) struct Obstacles<'a> {
    head: &'a Head,
    /// The tip's middle alone.
    tip: Head,
    graze: f64,
    solids: Vec<Solid>,
    contact: f64,
    /// Above this the tip clears everything, mm, machine Z.
    pub(super) over_all: f64,
}

impl<'a> Obstacles<'a> {
    pub(super) fn at(
        pose: Pose,
        printed: &[usize],
        workpiece: &Workpiece<'_>,
        table: &TableKinematics,
        profile: &Profile,
        head: &'a Head,
    ) -> Self {
        let motion = table.forward(pose);
        let moved = |part: &usize| Solid::of(&workpiece.parts[*part]).moved(&motion.rotation, &motion.translation);
        let mut solids: Vec<Solid> = printed.iter().map(moved).collect();
        solids.push(table_solid(profile, &motion));
        let top = solids.iter().map(|s| s.bounds.max.z).fold(f64::NEG_INFINITY, f64::max);
        Self {
            head,
            tip: Head::point(),
            graze: profile.process.layer_height_mm * GRAZE_LAYERS,
            solids,
            contact: contact_mm(profile),
            over_all: top + profile.transition.clearance_mm,
        }
    }

    /// Whether the straight travel is free. As everywhere the nozzle's rim may touch what it prints on, to the depth of
    /// a line; but across a top that stands beside the print it must not plough that deep.
    pub(super) fn free(&self, from: Vec3, to: Vec3) -> bool {
        self.within(&[from, to])
    }

    /// Whether the straight travel is free with as much room to spare: what a travel of our own owes, since it has no
    /// business near any surface, and printed surfaces stand out of the model's by a part of a layer.
    pub(super) fn well_free(&self, from: Vec3, to: Vec3) -> bool {
        self.solids.iter().all(|s| self.head.passes(from, to, s, -self.contact))
    }

    /// Whether every travel inside `region` (machine coordinates of the tip) is free.
    pub(super) fn free_within(&self, region: &Bounds) -> bool {
        let corners = (0..8).map(|i| Vec3::from_fn(|a, _| if i >> a & 1 == 0 { region.min[a] } else { region.max[a] }));
        let corners: Vec<Vec3> = corners.collect();
        self.within(&corners)
    }

    fn within(&self, corners: &[Vec3]) -> bool {
        let clear = |s: &Solid| self.head.sweeps_clear(corners, s, self.contact);
        self.solids.iter().all(|s| clear(s) && self.tip.sweeps_clear(corners, s, self.graze))
    }
}
