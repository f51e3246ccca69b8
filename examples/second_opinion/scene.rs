//! What is printed: lines with their heights and widths, and the poses of the table. Makes the checks of order and poses.
//!
//! Heights are the distances of successive layers, and widths follow from filament and heights.

use super::certificate::{Plan, Print};
use super::machine::{Machine, Pose};
use super::maths::{V, bounds, length, lerp, steps, sub, turned};
use super::opinion::Check;
use super::parts::{Mesh, Shared, shared_faces};
use super::reader::{Motion, NONE};
use std::collections::{BTreeMap, BTreeSet};

/// A printed line, machine coordinates of its own pose, `z` at its top.
pub struct Bead {
    pub motion: usize,
    pub line: usize,
    pub ends: [V; 2],
    pub pose: usize,
    pub print: usize,
    pub extra: bool,
    pub e: f64,
    pub height: f64,
    pub width: f64,
}

impl Bead {
    /// A point of its middle.
    pub fn point(&self, t: f64) -> V {
        sub(lerp(self.ends[0], self.ends[1], t), [0.0, 0.0, self.height / 2.0])
    }

    /// Height of its middle.
    pub fn middle(&self) -> f64 {
        self.point(0.0)[2]
    }

    pub fn way(&self) -> f64 {
        length(sub(self.ends[1], self.ends[0]))
    }

    /// Places along it, at most `step` apart, ends included.
    pub fn places(&self, step: f64) -> impl Iterator<Item = V> + '_ {
        let count = steps(self.way(), step);
        (0..=count).map(move |i| self.point(i as f64 / count as f64))
    }
}

/// Everything that the geometric checks look at.
pub struct Scene<'a> {
    pub machine: &'a Machine,
    pub plan: &'a Plan,
    pub motions: &'a [Motion],
    pub poses: Vec<Pose>,
    /// The number of each motion's pose, at its end.
    pub pose_of: Vec<usize>,
    pub beads: Vec<Bead>,
    /// The parts' facets on the table, by number; none without a model.
    pub parts: Option<Vec<Mesh>>,
    pub shared: Shared,
}

/// Numbers of beads by print and by height, microns.
type Layers = BTreeMap<usize, BTreeMap<i64, Vec<usize>>>;

/// A height in whole microns.
pub fn microns(z: f64) -> i64 {
    (z * 1000.0).round() as i64
}

impl<'a> Scene<'a> {
    pub fn new(machine: &'a Machine, plan: &'a Plan, motions: &'a [Motion], parts: Option<Vec<Mesh>>) -> Self {
        let (mut poses, mut pose_of, mut beads) = (Vec::<Pose>::new(), Vec::new(), Vec::new());
        for (index, motion) in motions.iter().enumerate() {
            let words = motion.words(1.0);
            if poses.last().is_none_or(|pose| pose.words != words) {
                poses.push(machine.pose(words));
            }
            let pose = poses.len() - 1;
            pose_of.push(pose);
            if motion.is_bead() {
                let Motion { line, print, e, .. } = *motion;
                let (ends, extra) = ([motion.tip(0.0), motion.tip(1.0)], motion.extra || plan.print(print).is_none());
                beads.push(Bead { motion: index, line, ends, pose, print, extra, e, height: 0.0, width: 0.0 });
            }
        }
        let shared = parts.as_deref().map(shared_faces).unwrap_or_default();
        let mut scene = Self { machine, plan, motions, poses, pose_of, beads, parts, shared };
        for extra in [false, true] {
            scene.layers(extra).into_values().for_each(|layers| scene.measure(layers));
        }
        scene
    }

    /// Beads of the parts themselves, or else of what is extra.
    pub fn layers(&self, extra: bool) -> Layers {
        let mut layers = Layers::new();
        for (index, bead) in self.beads.iter().enumerate().filter(|(_, bead)| bead.extra == extra) {
            layers.entry(bead.print).or_default().entry(microns(bead.ends[1][2])).or_default().push(index);
        }
        layers
    }

    /// The pose in which a line is printed.
    pub fn pose(&self, bead: &Bead) -> &Pose {
        &self.poses[bead.pose]
    }

    /// A print's part in machine coordinates, as the table stood when a line of it was printed.
    pub fn mesh(&self, bead: &Bead) -> Option<Mesh> {
        let part = self.parts.as_ref()?.get(self.plan.print(bead.print)?.part)?;
        Some(part.iter().map(|facet| facet.map(|p| self.pose(bead).machine(p))).collect())
    }

    /// Heights from the distance of layers, widths from heights and filament.
    fn measure(&mut self, layers: BTreeMap<i64, Vec<usize>>) {
        let zs: Vec<i64> = layers.keys().copied().collect();
        let mut gaps: Vec<i64> = zs.windows(2).map(|pair| pair[1] - pair[0]).collect();
        gaps.sort_unstable();
        let usual = gaps.get(gaps.len() / 2).map_or(self.machine.layer, |gap| *gap as f64 / 1000.0);
        let first = &self.beads[layers[&zs[0]][0]];
        let mesh = if first.extra { None } else { self.mesh(first) };
        let lowest = mesh.map(|mesh| bounds(mesh.into_iter().flatten())[0][2]);
        let mut below = lowest.unwrap_or(zs[0] as f64 / 1000.0 - usual);
        for (z, beads) in layers {
            let z = z as f64 / 1000.0;
            let step = z - below;
            let height = if step > 0.02 && step < 3.0 * usual { step } else { usual };
            below = z;
            for index in beads {
                let bead = &mut self.beads[index];
                (bead.height, bead.width) = (height, bead.e * self.machine.filament_area / bead.way() / height);
            }
        }
    }

    pub fn check_order(&self, marks: &[(usize, String)]) -> Check {
        let mut check = Check::new("order");
        // Prints of one slot and pose may be printed in turns.
        let mut group = vec![0];
        for pair in self.plan.prints.windows(2) {
            let same = pair[0].slot == pair[1].slot && pair[0].words == pair[1].words;
            group.push(group[group.len() - 1] + usize::from(!same));
        }
        let (mut now, mut met) = (0, BTreeSet::new());
        for bead in &self.beads {
            let may_be = self.may_be(bead);
            check.line(bead.line, may_be, || "a line of no part, which the plan does not have");
            let Some(&of) = group.get(bead.print) else { continue };
            check.line(bead.line, of >= now, || format!("print {} goes on behind a later one", bead.print));
            now = now.max(of);
            met.insert(bead.print);
        }
        for print in (0..group.len()).filter(|print| !met.contains(print)) {
            check.fail(format!("print {print} of the plan is not printed"));
        }
        for (line, mark) in marks {
            self.check_mark(&mut check, *line, mark);
        }
        check.figure = format!("{} prints, {} poses in a row", met.len(), self.poses.len());
        check
    }

    /// Whether a line is of a part, or the plan has supports, or it is a skirt, a brim or a prime line on the level table.
    fn may_be(&self, bead: &Bead) -> bool {
        let (pose, supported) = (self.pose(bead), self.plan.prints.iter().any(|print| print.gap.is_some()));
        let level = pose.up()[2] > 1.0 - 1e-9 && pose.table(bead.point(0.0))[2] < 1.0;
        !bead.extra || level || (supported && bead.print != NONE)
    }

    /// A mark's parts and pose are the plan's: `print=0 part=1 ..`, `slot=0 part=0,1 A=90 C=0 ..`.
    fn check_mark(&self, check: &mut Check, line: usize, mark: &str) {
        let value = |key: &str| mark.split(' ').find_map(|word| word.strip_prefix(key)?.strip_prefix('='));
        let parts = value("part").map(|list| list.split(',').filter_map(|n| n.parse().ok()).collect::<Vec<usize>>());
        if let Some(print) = value("print").and_then(|n| self.plan.print(n.parse().ok()?)) {
            let same = parts == Some(vec![print.part]);
            check.line(line, same, || "the mark's part is not the plan's");
        }
        let Some(slot) = value("slot").and_then(|n| n.parse::<usize>().ok()) else { return };
        let word = |axis: usize| value(&self.machine.axes[axis].letter.to_string())?.parse::<f64>().ok();
        let off = |print: &Print, axis: usize| (print.words[axis] - word(axis).unwrap_or(f64::NAN)).abs();
        let fits = |print: &&Print| print.slot == slot && (0..2).all(|axis| off(print, axis) <= 1e-3);
        let planned: Vec<usize> = self.plan.prints.iter().filter(fits).map(|print| print.part).collect();
        let known = parts.is_some_and(|parts| !parts.is_empty() && parts.iter().all(|part| planned.contains(part)));
        check.line(line, known, || format!("the plan has no such pose: {mark}"));
    }

    pub fn check_poses(&self) -> Check {
        let (mut check, mut worst) = (Check::new("poses"), 0.0_f64);
        for bead in &self.beads {
            let Some(print) = self.plan.print(bead.print) else { continue };
            let pose = self.pose(bead);
            let up = turned(pose.turn, print.up);
            let off = up[0].hypot(up[1]).atan2(up[2]).to_degrees();
            worst = worst.max(off);
            let words = (0..2).map(|i| (pose.words[i] - print.words[i]).abs()).fold(off, f64::max);
            check.line(bead.line, words <= 1e-3, || format!("print {} is {words:.4} degrees off its pose", bead.print));
        }
        check.figure = format!("at most {worst:.6} degrees off");
        check
    }
}
