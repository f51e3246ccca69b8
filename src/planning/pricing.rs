//! What the ways to print each part cost, rank by rank, and what is said of a sequence whatever its goal.

use serde::Serialize;

use super::candidates::{Candidate, Setups};
use super::changes::{self, LAYER_SECONDS, straight_seconds};
use super::goal::{Goal, GoalTerm};
use super::sequence::{Choice, Sequence};
use super::workpiece::Workpiece;
use crate::geom::{Dir, Table, Vec3};
use crate::mesh::TriangleMesh;
use crate::orient::{Facets, Objective, Staircase};
use crate::profile::Profile;

/// One rank's prices.
#[derive(Clone, Debug)]
pub(super) struct Rank {
    /// For each slot that a part waits, eq. (8).
    pub(super) waiting: f64,
    /// For each slot.
    pub(super) slot: f64,
    /// For each pose change.
    pub(super) setup: f64,
    /// `[part][candidate]`.
    pub(super) price: Vec<Vec<f64>>,
}

/// The price of two ways to print a slot's setups: one pose after the other (the way that is chosen, always), or all poses in
/// each layer, with a turn between them. Only turning is counted; the printing itself is the same.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WithinSlot {
    /// The slot.
    pub slot: usize,
    /// Turns between its poses, pose by pose.
    pub turns: usize,
    /// Estimated seconds of them.
    pub seconds: f64,
    /// Turns layer by layer.
    pub turns_layer_by_layer: usize,
    /// Estimated seconds of those.
    pub seconds_layer_by_layer: f64,
}

/// A plan in figures.
pub(super) struct Worth {
    pub(super) sequence_size: usize,
    pub(super) pose_changes: usize,
    pub(super) seconds: f64,
    pub(super) staircase: f64,
}

/// What prices are worked out from.
pub(super) struct Pricing<'a> {
    pub(super) workpiece: &'a Workpiece<'a>,
    pub(super) profile: &'a Profile,
    /// Decides where the goal itself does not look at orientations.
    pub(super) also: &'a dyn Objective,
}

impl Pricing<'_> {
    /// The ranks of `goal`: itself, then the sequence size, the orientations by `also`, and the pose changes where it
    /// does not look at them.
    pub(super) fn ranks(&self, goal: &Goal, candidates: &[Vec<Candidate>]) -> Vec<Rank> {
        let mut ranks = vec![self.rank(&goal.terms, candidates)];
        let bare = |waiting, setup| Rank {
            waiting,
            slot: 0.0,
            setup,
            price: candidates.iter().map(|c| vec![0.0; c.len()]).collect(),
        };
        if !goal.has(|t| matches!(t, GoalTerm::SequenceSize)) {
            ranks.push(bare(1.0, 0.0));
        }
        if !goal.looks_at_parts() {
            let price = self.by_part(candidates, |_, facets, up| self.also.value(facets, up.unit()));
            ranks.push(Rank { price, ..bare(0.0, 0.0) });
        }
        if !goal.has(|t| matches!(t, GoalTerm::Setups | GoalTerm::Time)) {
            ranks.push(bare(0.0, 1.0));
        }
        ranks
    }

    /// What each slot with several setups would take pose by pose, as it is printed, and layer by layer.
    pub(super) fn within_slots(&self, sequence: &Sequence, candidates: &[Vec<Candidate>]) -> Vec<WithinSlot> {
        let setup = |&(part, k): &Choice| candidates[part][k].setup;
        let mut all = Vec::new();
        for (slot, choices) in sequence.iter().enumerate() {
            let layers_of = |&(part, k): &Choice| {
                let along = self.workpiece.parts[part].vertices().iter().map(|v| v.dot(candidates[part][k].up.unit()));
                let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
                ((high - low) / self.profile.process.layer_height_mm).ceil() as usize
            };
            let groups = choices.chunk_by(|a, b| setup(a) == setup(b));
            let mut layers: Vec<usize> = groups.map(|g| g.iter().map(layers_of).max().unwrap_or(0)).collect();
            if layers.len() < 2 {
                continue;
            }
            // Every layer visits every pose that still has one, and ends where the next layer begins: a turn less than poses.
            layers.sort_unstable();
            let by_layer = layers[..layers.len() - 1].iter().sum::<usize>();
            let (turns, each) = (layers.len() - 1, turn_seconds(self.profile));
            all.push(WithinSlot {
                slot,
                turns,
                seconds: turns as f64 * each,
                turns_layer_by_layer: by_layer,
                seconds_layer_by_layer: by_layer as f64 * each,
            });
        }
        all
    }

    /// What is said of every plan, whatever its goal.
    pub(super) fn worth(&self, setups: &Setups<'_>, sequence: &Sequence, candidates: &[Vec<Candidate>]) -> Worth {
        let mut worth = Worth { sequence_size: 0, pose_changes: 0, seconds: 0.0, staircase: 0.0 };
        let staircase = Staircase { layer_mm: self.profile.process.layer_height_mm };
        let mut table = None;
        let mut standing: Vec<usize> = Vec::new();
        for (t, slot) in sequence.iter().enumerate() {
            for group in slot.chunk_by(|a, b| candidates[a.0][a.1].setup == candidates[b.0][b.1].setup) {
                worth.seconds += changes::seconds(setups, group, &standing, candidates);
                standing.extend(group.iter().map(|&(part, _)| part));
            }
            for &(part, k) in slot {
                let way = &candidates[part][k];
                worth.sequence_size += t;
                worth.pose_changes += usize::from(table != Some(way.setup));
                table = Some(way.setup);
                worth.seconds += self.print_seconds(part, way.up);
                worth.staircase += staircase.value(&Facets::of(&self.workpiece.parts[part]), way.up.unit());
            }
        }
        worth.seconds += worth.pose_changes as f64 * turn_seconds(self.profile);
        worth
    }

    fn rank(&self, terms: &[(f64, GoalTerm)], candidates: &[Vec<Candidate>]) -> Rank {
        let price = candidates.iter().map(|c| vec![0.0; c.len()]).collect();
        let mut rank = Rank { waiting: 0.0, slot: 0.0, setup: 0.0, price };
        for (weight, term) in terms {
            let prices = match term {
                GoalTerm::SequenceSize => {
                    rank.waiting += weight;
                    continue;
                }
                GoalTerm::Setups => {
                    rank.setup += weight;
                    continue;
                }
                GoalTerm::Slots => {
                    rank.slot += weight;
                    continue;
                }
                GoalTerm::Time => {
                    rank.setup += weight * turn_seconds(self.profile);
                    self.by_part(candidates, |part, _, up| self.print_seconds(part, up))
                }
                GoalTerm::Part(f) => self.by_part(candidates, |_, facets, up| f.value(facets, up.unit())),
            };
            for (sums, values) in rank.price.iter_mut().zip(prices) {
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            }
        }
        rank
    }

    /// [`print_seconds`] of a part, and what `[joint]` slows its first layers by where it begins on another.
    pub(super) fn print_seconds(&self, part: usize, up: Dir<Table>) -> f64 {
        let begins = if self.workpiece.model.is_in_place(part) { Begins::OnTable } else { Begins::OnAnother };
        print_seconds(&self.workpiece.parts[part], up, self.profile, begins)
    }

    fn by_part(
        &self,
        candidates: &[Vec<Candidate>],
        price: impl Fn(usize, &Facets, Dir<Table>) -> f64,
    ) -> Vec<Vec<f64>> {
        let of_part = |(part, ways): (usize, &Vec<Candidate>)| {
            let facets = Facets::of(&self.workpiece.parts[part]);
            ways.iter().map(|way| price(part, &facets, way.up)).collect()
        };
        candidates.iter().enumerate().map(of_part).collect()
    }
}

/// Pull, rise, turn both axes by a quarter turn, come back and prime: the price of one pose change, s.
///
/// A quarter turn stands for all angles: which pose follows which is not known before the order is.
fn turn_seconds(profile: &Profile) -> f64 {
    let rate = |axis: f64| if axis > 0.0 { 90.0 / axis } else { 0.0 };
    let (kinematics, transition) = (&profile.kinematics, &profile.transition);
    let turning = rate(kinematics.tilt.max_deg_per_s) + rate(kinematics.rotation.max_deg_per_s);
    let pull = 2.0 * transition.retract_mm / transition.retract_mm_per_s;
    let rise = 2.0 * TURNING_RISE_MM / (transition.z_mm_per_min / 60.0);
    turning + pull + rise
}

/// How far the tip rises for a pose change in [`turn_seconds`], mm.
const TURNING_RISE_MM: f64 = 50.0;
/// Lines are this much longer than volume over cross section says: joints, and ways between them.
const SLOWED: f64 = 1.15;

/// Supports are printed as sparsely as this, whatever the part's infill.
const SUPPORT_DENSITY: f64 = 0.15;

/// An estimate of the seconds that supports of this volume take.
pub(super) fn support_seconds(volume_mm3: f64, profile: &Profile) -> f64 {
    let process = &profile.process;
    volume_mm3 * SUPPORT_DENSITY * SLOWED / (process.line_width_mm * process.layer_height_mm * process.infill_mm_per_s)
}

/// What a print stands on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Begins {
    /// The table.
    OnTable,
    /// An earlier part: `[joint]` says how fast its first layers are laid.
    OnAnother,
}

/// An estimate of the seconds that printing `mesh` along `up` takes: shell and fill at their own speeds and accelerations, and for each
/// layer its least time and a change. Meant for comparing plans; the verified file says the true time. Against the replayed files of the
/// built-in slicer on `generic-ac` whole plans are within 8 % on cube, two-boxes, ding and y-tree (-0.8, +0.4, -7.9, +2.5), and 13 % low on the
/// candelabrum, whose tiny parts are changed between layer by layer (`changes`; 30 % low without).
pub(super) fn print_seconds(mesh: &TriangleMesh<Table>, up: Dir<Table>, profile: &Profile, begins: Begins) -> f64 {
    let process = &profile.process;
    let volume: f64 = mesh.volume();
    let along = |v: &Vec3| v.dot(up.unit());
    let (low, high) = mesh
        .vertices()
        .iter()
        .map(along)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
    let (mut walls, mut skins) = (0.0, 0.0);
    for facet in 0..mesh.facets().len() {
        let Some(normal) = mesh.normal(facet) else { continue };
        let (area, upward) = (mesh.facet_area(facet), normal.dot(up.unit()));
        walls += area * (1.0 - upward * upward).max(0.0).sqrt();
        let layers = if upward > 0.0 { process.top_layers } else { process.bottom_layers };
        skins += area * upward.abs() * f64::from(layers) * process.layer_height_mm;
    }
    let wall = (walls * f64::from(process.walls) * process.line_width_mm).min(volume);
    let skin = skins.min(volume - wall);
    let sparse = (volume - wall - skin).max(0.0) * process.infill;
    let bead = process.line_width_mm * process.layer_height_mm;
    let wall_speed = (process.outer_wall_mm_per_s
        + process.inner_wall_mm_per_s * (f64::from(process.walls) - 1.0).max(0.0))
        / f64::from(process.walls.max(1));
    let layers = ((high - low) / process.layer_height_mm).ceil().max(1.0);
    let [wall_mm, fill_mm] = [wall, skin + sparse].map(|volume| volume / bead / layers);
    // A loop counts as four straight sides, a line of infill as the section's mean chord (pi area / perimeter).
    let around = walls / layers / process.layer_height_mm;
    let chord = std::f64::consts::PI * volume / walls.max(1e-9);
    let drawn = |length: f64, each: f64, speed: f64| length * slowness(each.max(process.line_width_mm), speed, profile);
    let layer = drawn(wall_mm, around / 4.0, wall_speed) + drawn(fill_mm, chord, process.infill_mm_per_s);
    let slowest = (wall_mm + fill_mm) / process.slowest_mm_per_s;
    let least = if process.wait_beside { process.min_layer_s } else { process.min_layer_s.min(slowest) };
    let usual = (layer * SLOWED).max(least);
    let joint = profile.joint.mm_per_s.filter(|_| begins == Begins::OnAnother).map_or(0.0, |speed| {
        let slowed = drawn(wall_mm, around / 4.0, wall_speed.min(speed));
        let slowed = slowed + drawn(fill_mm, chord, process.infill_mm_per_s.min(speed));
        f64::from(profile.joint.layers).min(layers) * ((slowed * SLOWED).max(least) - usual)
    });
    layers * (usual + LAYER_SECONDS) + joint
}

/// Seconds a millimetre of straight lines this long, each begun and ended at rest.
fn slowness(each_mm: f64, speed: f64, profile: &Profile) -> f64 {
    straight_seconds(each_mm, speed, profile.limits.acceleration_mm_per_s2) / each_mm
}
