//! What it costs to go from print to print where several are made at one pose.
//!
//! Everything of a pose is printed in the order of its height, so that nothing stands in the head's way. Each change of print pulls the
//! filament back, goes up, across and down: by a hop where the way is free, else above everything that stands. Here the ways lead from the
//! middle of one print to the middle of the next; where lines begin and end is the slicer's affair.

use std::collections::HashMap;

use super::candidates::{Candidate, Setups};
use super::collision::Head;
use super::owed::contact_mm;
use super::sequence::Choice;
use super::solid::Solid;
use crate::geom::{Bounds, Vec3};
use crate::profile::Profile;

/// Travels between prints of one pose go this far above the higher of both ends, mm: over strings and seams.
pub const HOP_MM: f64 = 1.0;

/// What changing the layer costs beside the printing: a pull, a hop and the first travel, s.
pub(super) const LAYER_SECONDS: f64 = 0.6;

/// Halvings after which the height from which a way is free is known to a part in 64.
const HALVINGS: usize = 6;

/// Estimated seconds of the changes between the prints of `group`, all of one pose, while the parts of `standing` stand there: what they
/// take beyond the change of layer that each print's own seconds count.
pub(super) fn seconds(setups: &Setups<'_>, group: &[Choice], standing: &[usize], candidates: &[Vec<Candidate>]) -> f64 {
    let [(part, way), _, ..] = *group else { return 0.0 };
    let pose = candidates[part][way].pose;
    let motion = setups.table.forward(pose);
    let moved = |part: usize| setups.solids[part].moved(&motion.rotation, &motion.translation);
    let solids: Vec<Solid> = standing.iter().map(|&part| moved(part)).collect();
    let prints: Vec<Bounds> = group.iter().map(|&(part, _)| moved(part).bounds).collect();
    between(&prints, &solids, setups.profile, &setups.head.at(pose))
}

/// The same of prints in these boxes beside what stands, machine coordinates at the pose.
fn between(prints: &[Bounds], solids: &[Solid], profile: &Profile, head: &Head) -> f64 {
    let (height, transition, limits) = (profile.process.layer_height_mm, &profile.transition, &profile.limits);
    let mut layers: Vec<(f64, usize)> = Vec::new();
    for (print, bounds) in prints.iter().enumerate() {
        let count = (bounds.size().z / height).ceil() as usize;
        layers.extend((1..=count).map(|k| (bounds.min.z + k as f64 * height, print)));
    }
    layers.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let top = solids.iter().map(|solid| solid.bounds.max.z).fold(f64::NEG_INFINITY, f64::max);
    let clear = top + transition.clearance_mm;
    let mut ways = Ways { prints, solids, head, contact: contact_mm(profile), clear, free_from: HashMap::new() };
    let pulls = 2.0 * transition.retract_mm / transition.retract_mm_per_s;
    let mut sum = 0.0;
    for pair in layers.windows(2).filter(|pair| pair[0].1 != pair[1].1) {
        let [(low, from), (high, to)] = [pair[0], pair[1]];
        let (over, far) = ways.over(from, to, high + HOP_MM);
        let rise = |mm| straight_seconds(mm, transition.z_mm_per_min / 60.0, limits.z_acceleration_mm_per_s2);
        let across = straight_seconds(far, transition.travel_mm_per_min / 60.0, limits.acceleration_mm_per_s2);
        sum += (rise(over - low) + rise(over - high) + across + pulls - LAYER_SECONDS).max(0.0);
    }
    sum
}

/// Seconds of a straight move from rest to rest.
pub(super) fn straight_seconds(length_mm: f64, speed: f64, acceleration: f64) -> f64 {
    if length_mm * acceleration >= speed * speed {
        length_mm / speed + speed / acceleration
    } else {
        2.0 * (length_mm / acceleration).sqrt()
    }
}

/// The ways between prints.
struct Ways<'a> {
    prints: &'a [Bounds],
    /// What stands.
    solids: &'a [Solid],
    head: &'a Head,
    contact: f64,
    /// Above this the tip clears all of it, mm, machine Z.
    clear: f64,
    /// By both prints, the height from which the way is free.
    free_from: HashMap<[usize; 2], f64>,
}

impl Ways<'_> {
    /// At which height, machine Z, the head goes from one print to another if it would at `low`, and how far.
    fn over(&mut self, from: usize, to: usize, low: f64) -> (f64, f64) {
        let across = self.prints[to].centre() - self.prints[from].centre();
        let key = [from.min(to), from.max(to)];
        let known = self.free_from.get(&key).copied();
        let free_from = known.unwrap_or_else(|| self.freed(key));
        self.free_from.insert(key, free_from);
        (if low >= free_from { low } else { self.clear.max(low) }, across.xy().norm())
    }

    fn freed(&self, prints: [usize; 2]) -> f64 {
        let free = |z: f64| {
            let [a, b] = prints.map(|print| self.prints[print].centre()).map(|p| Vec3::new(p.x, p.y, z));
            // With as much room to spare as the rewriter's own travels owe.
            self.solids.iter().all(|solid| self.head.passes(a, b, solid, -self.contact))
        };
        let lowest = prints.map(|print| self.prints[print].min.z);
        let (mut low, mut high) = (lowest[0].min(lowest[1]), self.clear);
        if free(low) {
            return low;
        }
        for _ in 0..HALVINGS {
            let middle = (low + high) / 2.0;
            if free(middle) { high = middle } else { low = middle }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{resolve, shipped};

    fn a_box(x: f64, height: f64) -> Bounds {
        Bounds::of([Vec3::new(x - 5.0, -5.0, 0.0), Vec3::new(x + 5.0, 5.0, height)])
    }

    #[test]
    fn changes_cost_what_the_moves_take_and_a_post_in_the_way_more() {
        let (file, text) = shipped("generic-ac").unwrap();
        let profile = resolve(file, text).unwrap().0;
        let head = Head::of(&profile);
        let seconds = |solids: &[Solid]| between(&[a_box(-30.0, 10.0), a_box(30.0, 10.0)], solids, &profile, &head);
        // 50 layers each, all changed between: by hand at 100 mm/s and 1000 mm/s2 across 60 mm, a hop of 1 mm at 200 mm/s2 up and down
        // (one side a layer more each second time), 4 mm of filament at 35 mm/s.
        let [across, hop, pulls] = [0.6 + 0.1, 2.0 * (1.0f64 / 200.0).sqrt(), 4.0 / 35.0];
        let wanted = 99.0 * (across + 2.0 * hop + pulls - LAYER_SECONDS);
        let free = seconds(&[]);
        assert!((free / wanted - 1.0).abs() < 0.05, "{free} for {wanted}");
        let corners = |x: f64, z: f64| [Vec3::new(x, -3.0, z), Vec3::new(x, 3.0, z)];
        let post = |x: f64, height: f64| {
            Solid::hull(
                [-3.0, 3.0].into_iter().flat_map(|dx| [0.0, height].map(|z| corners(x + dx, z))).flatten().collect(),
            )
        };
        assert_eq!(seconds(&[post(80.0, 6.0)]), free, "beside the way");
        let (low, high) = (seconds(&[post(0.0, 6.0)]), seconds(&[post(0.0, 60.0)]));
        assert!(free < low && low < high && high > free + 99.0 * 2.0 * 45.0 / 15.0, "{free} {low} {high}");
    }
}
