//! Rule `outside-part`: filament is laid only inside the part being printed, grown by a bead.
//!
//! Exact over whole lines, not only at their ends: the signed distance changes by at most 1 mm per mm, so with `f` at
//! both ends of a piece of length `l` no point of it lies farther out than `(f0 + f1 + l) / 2`. A piece that this does
//! not settle is halved.

use rayon::prelude::*;

use super::Job;
use super::report::{Findings, Place, Rule};
use super::shell::Shell;
use super::trace::{Act, Kind, Planned, Stroke};
use crate::geom::Vec3;

/// Strokes that one thread takes at a time.
const CHUNK: usize = 4096;
/// Pieces shorter than this are judged by the farther of their ends, mm.
const SHORTEST_MM: f64 = 0.05;

/// Findings for all printing strokes among `acts`.
pub(super) fn check(acts: &[Act], job: &Job<'_>, planned: &[Planned]) -> Findings {
    let table = job.profile.kinematics();
    // Seen along its build direction a part is mostly upright, and the boxes of its facets are small.
    let shell = |p: &Planned| {
        let part = job.workpiece.parts.get(p.part)?;
        Some(Shell::new(&part.moved(&table.forward(p.pose))))
    };
    let shells: Vec<Option<Shell>> = planned.par_iter().map(shell).collect();
    let process = &job.profile.process;
    let room = Room { planned, shells, tolerance: process.line_width_mm / 2.0 + process.layer_height_mm };
    let chunks: Vec<Findings> = acts.par_chunks(CHUNK).map(|chunk| room.check(chunk)).collect();
    chunks.into_iter().fold(Findings::default(), |mut all, one| {
        all.absorb(one);
        all
    })
}

struct Room<'a> {
    planned: &'a [Planned],
    /// By print, at its pose in the machine.
    shells: Vec<Option<Shell>>,
    tolerance: f64,
}

impl Room<'_> {
    fn check(&self, acts: &[Act]) -> Findings {
        let mut findings = Findings::default();
        // The end of one stroke is mostly the start of the next.
        let mut last = (Vec3::repeat(f64::NAN), 0.0);
        let mut print_before = None;
        for act in acts {
            let Act::Stroke(stroke) = act else { continue };
            let (Kind::Print(_), Some(print)) = (stroke.kind, stroke.print) else { continue };
            let planned = &self.planned[print as usize];
            let Some(shell) = &self.shells[print as usize] else { continue };
            if stroke.print != print_before {
                (print_before, last) = (stroke.print, (Vec3::repeat(f64::NAN), 0.0));
            }
            let [a, b] = middle_of_bead(stroke);
            let farthest = self.farthest(shell, a, b, &mut last);
            if farthest > self.tolerance {
                let at = Place { line: stroke.line, slot: Some(planned.slot), part: Some(planned.part) };
                findings.add(Rule::OutsidePart, at, [farthest, self.tolerance], || {
                    let (part, most) = (planned.part, self.tolerance);
                    format!("filament is laid {farthest:.3} mm outside part {part}; at most {most:.3} mm")
                });
            }
        }
        findings
    }

    /// The distance of the farthest point between `a` and `b`, or any value within the tolerance.
    fn farthest(&self, shell: &Shell, a: Vec3, b: Vec3, last: &mut (Vec3, f64)) -> f64 {
        let length = (b - a).norm();
        let bound = |ends: [f64; 2]| (ends[0] + ends[1] + length) / 2.0;
        let quick = bound([a, b].map(|p| shell.at_most(&p)));
        if quick <= self.tolerance {
            return quick;
        }
        let ends = [if last.0 == a { last.1 } else { shell.signed_distance(&a) }, shell.signed_distance(&b)];
        *last = (b, ends[1]);
        let (worst, bound) = (ends[0].max(ends[1]), bound(ends));
        if worst > self.tolerance || length < SHORTEST_MM || bound <= self.tolerance {
            return worst;
        }
        let middle = (a + b) * 0.5;
        self.farthest(shell, a, middle, last).max(self.farthest(shell, middle, b, last))
    }
}

/// The middle of the bead at both ends: the tip is its top.
fn middle_of_bead(stroke: &Stroke) -> [Vec3; 2] {
    let down = Vec3::z() * (f64::from(stroke.height) / 2.0);
    [stroke.from - down, stroke.to - down]
}
