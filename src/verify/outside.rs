//! Rule `outside-part`: filament is laid only inside the part being printed, grown by a bead.
//!
//! Exact over whole lines, not only at their ends: the signed distance changes by at most 1 mm per mm, so with `f` at
//! both ends of a piece of length `l` no point of it lies farther out than `(f0 + f1 + l) / 2`. A piece that this does
//! not settle is halved.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::Job;
use super::report::{Findings, Place, Rule};
use super::shell::Shell;
use super::trace::{Act, Kind, Planned, Stroke};
use crate::geom::{Machine, Rigid, Table, Vec3};

/// Strokes that one thread takes at a time.
const CHUNK: usize = 4096;
/// Pieces shorter than this are judged by the farther of their ends, mm.
const SHORTEST_MM: f64 = 0.05;

/// Findings for all printing strokes among `acts`.
pub(super) fn check(acts: &[Act], job: &Job<'_>, planned: &[Planned]) -> Findings {
    let table = job.profile.kinematics();
    let inverse = |p: &Planned| table.forward(p.pose).inverse();
    let frames: Vec<Rigid<Machine, Table>> = planned.iter().map(inverse).collect();
    let used: BTreeMap<usize, ()> = planned.iter().map(|p| (p.part, ())).collect();
    let parts: Vec<usize> = used.into_keys().filter(|&p| p < job.workpiece.parts.len()).collect();
    let shells: BTreeMap<usize, Shell> = parts.par_iter().map(|&p| (p, Shell::new(&job.workpiece.parts[p]))).collect();
    let process = &job.profile.process;
    let room = Room { planned, frames, shells, tolerance: process.line_width_mm / 2.0 + process.layer_height_mm };
    let chunks: Vec<Findings> = acts.par_chunks(CHUNK).map(|chunk| room.check(chunk)).collect();
    chunks.into_iter().fold(Findings::default(), |mut all, one| {
        all.absorb(one);
        all
    })
}

struct Room<'a> {
    planned: &'a [Planned],
    frames: Vec<Rigid<Machine, Table>>,
    shells: BTreeMap<usize, Shell>,
    tolerance: f64,
}

impl Room<'_> {
    fn check(&self, acts: &[Act]) -> Findings {
        let mut findings = Findings::default();
        // The end of one stroke is mostly the start of the next.
        let mut last: Option<(u32, Vec3, f64)> = None;
        for act in acts {
            let Act::Stroke(stroke) = act else { continue };
            let (Kind::Print(_), Some(print)) = (stroke.kind, stroke.print) else { continue };
            let planned = &self.planned[print as usize];
            let Some(shell) = self.shells.get(&planned.part) else { continue };
            let [a, b] = self.ends(stroke, print as usize);
            let at_a = match last {
                Some((p, at, f)) if p == print && at == a => f,
                _ => shell.signed_distance(&a),
            };
            let at_b = shell.signed_distance(&b);
            last = Some((print, b, at_b));
            let farthest = self.farthest(shell, (a, at_a), (b, at_b));
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

    /// The middle of the bead at both ends, table frame.
    fn ends(&self, stroke: &Stroke, print: usize) -> [Vec3; 2] {
        let down = Vec3::z() * (f64::from(stroke.height) / 2.0);
        [stroke.from, stroke.to].map(|tip| self.frames[print].point((tip - down).into()).at)
    }

    /// The distance of the farthest point between `a` and `b`, or any value within the tolerance.
    fn farthest(&self, shell: &Shell, a: (Vec3, f64), b: (Vec3, f64)) -> f64 {
        let ends = a.1.max(b.1);
        let length = (b.0 - a.0).norm();
        if ends > self.tolerance || length < SHORTEST_MM || a.1 + b.1 + length <= 2.0 * self.tolerance {
            return ends;
        }
        let middle = (a.0 + b.0) * 0.5;
        let middle = (middle, shell.signed_distance(&middle));
        self.farthest(shell, a, middle).max(self.farthest(shell, middle, b))
    }
}
