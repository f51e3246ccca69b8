//! Rule `outside-part` for supports: what a plan has printed to hold a part is no part of it, and touches none.
//!
//! Only a plan's own prints of supports are taken for such: a line of a part that a slicer calls a support is a line of the part. What they
//! hold, and whether they stand, is rule `in-air`'s to say; here the middle of each of their lines keeps half of its width from every
//! part, at the height of its middle, and takes the filament that its width and height hold. So nothing of a part passes as a support,
//! and no support grows into a part.
//!
//! Where a part is narrower than a line its slicer may lay nothing, and supports reach up through that to what it does lay: it counts no more than
//! what is not there.
//!
//! A line is gone along by steps as long as the distance from the part, which pass over nothing.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::evidence::{Checked, Evidence};
use super::flow::RATE_SLACK;
use super::report::{FindingPlace, Findings, Rule};
use super::{Planned, ReplayJob, prints};
use crate::gcode::marks::{Expect, Role};
use crate::overhang::laid_of;
use crate::section::{PlanePoint, Section, Sections, march};
use crate::trace::TraceMove;

/// How much nearer to a part than half of its width a line may lie, mm: outlines are cut in the middle of layers, and rounded.
const NEARER_MM: f64 = 0.05;
/// What a line may take, beside what its width and height hold.
const FLOW: [f64; 2] = [0.8, 1.25];
/// Shorter lines tell nothing of what they hold, mm.
const SHORT_MM: f64 = 1.0;
/// Heights that differ by less are cut once, mm.
const SAME_MM: f64 = 1.5e-3;

/// Holds all supports of the program.
pub(super) fn check(&Evidence { trace, job, planned, .. }: &Evidence<'_>) -> Checked {
    let mut findings = Findings::default();
    let flows = prints::stated_flows(trace, planned.len());
    let of = |number: usize| -> Vec<TraceMove> {
        let its = |m: &TraceMove| m.prints() && trace.state(m).print == Some(number as u32);
        trace.moves().filter(its).collect()
    };
    for (number, print) in planned.iter().enumerate().filter(|(_, print)| print.gap_mm.is_some()) {
        let held = planned.iter().position(|other| other.part == print.part && other.gap_mm.is_none());
        let supports = Supports::of(job, print, &flows[number], held.map(of).unwrap_or_default());
        for (m, text) in supports.objections(of(number)) {
            let at = FindingPlace { line: m.line, slot: Some(print.slot), part: Some(print.part) };
            findings.add(Rule::OutsidePart, at, [0.0, 0.0], || text);
        }
    }
    findings.into()
}

/// The supports of one part.
struct Supports<'a> {
    part: usize,
    /// The lines of what they hold.
    held: Vec<TraceMove>,
    /// Every part at the pose, machine coordinates.
    parts: Vec<Sections>,
    flow: &'a Expect,
    filament_mm2: f64,
    line_mm: f64,
    layer_mm: f64,
    /// What the hot end melts, mm³/s.
    most_flow: f64,
}

impl<'a> Supports<'a> {
    fn of(job: &ReplayJob<'_>, print: &Planned, flow: &'a Expect, held: Vec<TraceMove>) -> Self {
        let motion = job.profile.kinematics().forward(print.pose);
        let process = &job.profile.process;
        Self {
            part: print.part,
            held,
            parts: job.workpiece.parts.iter().map(|part| Sections::of(&part.moved(&motion))).collect(),
            flow,
            filament_mm2: PI / 4.0 * flow.diameter_mm.unwrap_or(process.filament_mm).powi(2),
            line_mm: process.line_width_mm,
            layer_mm: process.layer_height_mm,
            most_flow: job.profile.limits.max_flow_mm3_per_s,
        }
    }

    /// What stands against its lines, layer by layer.
    fn objections(&self, mut lines: Vec<TraceMove>) -> Vec<(TraceMove, String)> {
        lines.sort_by(|a, b| self.middle(a).total_cmp(&self.middle(b)));
        let layers: Vec<&[TraceMove]> = lines.chunk_by(|a, b| self.middle(b) - self.middle(a) < SAME_MM).collect();
        let layer = |layer: &&[TraceMove]| -> Vec<(TraceMove, String)> {
            let middle = self.middle(&layer[0]);
            let mut sections: Vec<Section> = self.parts.iter().map(|part| part.at(middle)).collect();
            let all = |sections: &[Section]| -> Vec<(TraceMove, String)> {
                layer.iter().filter_map(|m| Some((*m, self.objection(m, sections)?))).collect()
            };
            let objections = all(&sections);
            if objections.is_empty() {
                return objections;
            }
            sections[self.part] = laid_of(&sections[self.part], &self.laid_at(middle), self.line_mm);
            all(&sections)
        };
        layers.par_iter().map(layer).collect::<Vec<_>>().concat()
    }

    /// The lines of what they hold that go through a height.
    fn laid_at(&self, z: f64) -> Vec<[PlanePoint; 2]> {
        let here = |m: &&TraceMove| (self.middle(m) - z).abs() < self.height(m) / 2.0;
        self.held.iter().filter(here).filter_map(|m| Some(m.ends()?.map(|p| [p.x, p.y]))).collect()
    }

    fn width(&self, m: &TraceMove) -> f64 {
        m.width.unwrap_or(self.line_mm)
    }

    fn height(&self, m: &TraceMove) -> f64 {
        m.height.unwrap_or(self.layer_mm)
    }

    /// The height of a line's middle.
    fn middle(&self, m: &TraceMove) -> f64 {
        m.to[2].unwrap_or(f64::NAN) - self.height(m) / 2.0
    }

    fn objection(&self, m: &TraceMove, sections: &[Section]) -> Option<String> {
        let Self { part, .. } = self;
        if m.role != Role::Support {
            return Some(format!("a line among the supports of part {part} is not support"));
        }
        let [from, to] = m.ends()?;
        if (to.z - from.z).abs() > SAME_MM {
            return Some(format!(
                "a support line of part {part} must be level, but its Z changes by {:+.2} mm",
                to.z - from.z
            ));
        }
        let (width, length) = (self.width(m), (to - from).norm());
        let least = width / 2.0 - NEARER_MM;
        let nearest = |p: PlanePoint| {
            let distances = sections.iter().map(|section| section.signed_distance(p));
            distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
        };
        let way = [from, to].map(|p| [p.x, p.y]);
        if let Some((t, room)) = march(way, |p| nearest(p).1 - least).find(|(_, room)| *room < 0.0) {
            let p = from + (to - from) * if length > 0.0 { t / length } else { 0.0 };
            let (other, _) = nearest([p.x, p.y]);
            let distance = room + least;
            return Some(format!(
                "a support of part {part} is {distance:.2} mm from part {other} (minimum {least:.2} mm)"
            ));
        }
        let held = self.flow.bead.area(width, self.height(m)) * length * self.flow.multiplier;
        let laid = m.e * self.filament_mm2;
        let (ratio, rate) = (laid / held, if m.seconds > 0.0 { laid / m.seconds } else { 0.0 });
        if rate > self.most_flow * (1.0 + RATE_SLACK) {
            let most = self.most_flow;
            return Some(format!(
                "a support of part {part} needs {rate:.1} mm3/s of filament, more than the hot end melts (maximum {most:.1}, [limits] max_flow_mm3_per_s)"
            ));
        }
        (length > SHORT_MM && !(FLOW[0]..=FLOW[1]).contains(&ratio)).then(|| {
            let [least, most] = FLOW;
            format!("a support line of part {part} uses {ratio:.2} times the filament that its volume needs (allowed {least} to {most})")
        })
    }
}
