//! How a head that turns leaves a print and comes to one: along the tool, and straight up or down. Where it may is `planning::SwivelRoute`'s.
//!
//! Frame `Machine` (the tool's) for tips, words for moves across the room, mm.

use super::{Entry, Writer, region};
use crate::geom::{Bounds, Vec3};
use crate::motion::Pose;

impl Writer<'_> {
    /// Leaves along the tool, goes straight up, and waits where the head can turn to `pose`: above the prints to come, if there are any.
    pub(super) fn leave(&mut self, pose: Pose, to: Option<&[Entry<'_>]>) {
        let (Some(route), Some(head)) = (&self.route, &self.table.head) else { return };
        let (z_feed, feed) = (self.job.profile.transition.z_mm_per_min, self.job.profile.transition.travel_mm_per_min);
        let standing = self.standing();
        let top = standing.iter().map(|p| p.z).fold(0.0, f64::max);
        let height = route.height(top, self.pose, pose);
        if let (Some(tip), Some(from)) = (self.out.tip(), self.pose) {
            let along = self.top_along(&standing, from) + self.job.profile.transition.clearance_mm;
            self.out.go_z(along.max(tip.z), z_feed);
        }
        self.out.raise(self.out.words().map_or(height, |words| height.max(words.z)), z_feed);
        let above = to.and_then(|group| {
            let there = group.iter().map(region).fold(Bounds::EMPTY, |all, one| all.union(&one)).centre();
            Some(head.words(there, pose)).filter(|words| words.iter().all(|v| v.is_finite()))
        });
        let places = [self.out.words(), above, Some(head.table)].map(|words| words.map(|p| [p.x, p.y]));
        let places: Vec<[f64; 2]> = places.into_iter().flatten().collect();
        let z = self.out.words().map_or(height, |words| words.z.max(height));
        match route.place(&places, z, self.pose, pose) {
            Ok([x, y]) => {
                self.out.go_words(Vec3::new(x, y, z), feed);
            }
            Err(out) => self.out.beyond = self.out.beyond.or(Some(out)),
        }
    }

    /// Goes over to where a print begins, across the room and straight down to where the tool's axis leads in.
    pub(super) fn arrive(&mut self, start: Vec3) {
        let (Some(head), Some(pose)) = (&self.table.head, self.pose) else { return };
        let transition = &self.job.profile.transition;
        let along = self.top_along(&self.standing(), pose).max(start.z) + transition.clearance_mm;
        let entry = Vec3::new(start.x, start.y, along);
        let words = head.words(entry, pose);
        let z = self.out.words().map_or(words.z, |at| at.z.max(words.z));
        self.out.raise(z, transition.z_mm_per_min);
        self.out.go_words(Vec3::new(words.x, words.y, z), transition.travel_mm_per_min);
        self.out.go(entry, 0.0, transition.z_mm_per_min, b"");
    }

    /// How far along the tool any of them reaches at `pose`.
    fn top_along(&self, standing: &[Vec3], pose: Pose) -> f64 {
        let motion = self.table.forward(pose);
        standing.iter().map(|&p| motion.point(p.into()).at.z).fold(f64::NEG_INFINITY, f64::max)
    }
}
