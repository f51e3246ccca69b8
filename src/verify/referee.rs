//! A program judged without its plan: files of other programs, and our own where the plan is lost.
//!
//! ```text
//! bytes --trace--> runs of lines at one pose                 (each is taken for one print, of a part of its own)
//!       --marks--> the same program with our comments, a plan, and boxes around the runs for a model
//!       --CHECKS--> findings of the rules that need no model
//! ```
//!
//! Whatever the file says of itself in our own comments is not read: it is taken for a stranger's. Parts that grow beside each other cannot be
//! told apart, so that nothing is a stranger to anything: the nozzle may be as deep in whatever was printed as where it prints onto it, and a run travels
//! through nothing of its own; all other pieces of the head keep clear of everything. Parts of a joint are one part of their run, so what is printed above a
//! gap is in mid-air.

use serde::Serialize;

use super::evidence::{Check, Evidence};
use super::report::{Report, Rule};
use super::{ReplayJob, acts::Acts, balance, by, planned, prints, program, reading, report_of, table, walk};
use crate::gcode::marks::{Role, mark, print_mark, slot_mark};
use crate::gcode::{ParsedLine, lines};
use crate::geom::{Bounds, Object, Vec3};
use crate::mesh::{Interface, Model, Part, TriangleMesh, Unit};
use crate::motion::{Pose, TableKinematics};
use crate::planning::{MachineRef, ModelRef, PartRef, Placement, Plan, Print, PrintSupports, TimeSlot, Workpiece};
use crate::profile::Profile;
use crate::trace::{self, Event, Trace, TraceMove, What};

/// Rules that are asked of a file without a plan.
const JUDGED: [Rule; 14] = [
    Rule::Syntax,
    Rule::Reading,
    Rule::Command,
    Rule::Setting,
    Rule::AxisLimit,
    Rule::AxisRate,
    Rule::TurnWhileExtruding,
    Rule::InAir,
    Rule::HeadCollision,
    Rule::TurnCollision,
    Rule::Heat,
    Rule::Retract,
    Rule::UnknownPosition,
    Rule::Standing,
];

/// What only a plan and its model tell.
const UNJUDGED: [Rule; 9] = [
    Rule::Pose,
    Rule::OutsidePart,
    Rule::Filament,
    Rule::Flow,
    Rule::Fill,
    Rule::LayerHeight,
    Rule::Registration,
    Rule::Complete,
    Rule::Sequence,
];

/// The checks that find breaches of these, beginning with those that take longest.
const CHECKS: [Check; 4] = [walk::check, program::check, balance::check, table::check];

/// Files of more runs are not judged: what each costs is much more than its bytes.
const MOST_RUNS: usize = 500;
/// A run's box is never flatter, mm.
const LEAST_MM: f64 = 0.01;
/// Layers of air that a slicer leaves above its supports, at most.
const SUPPORT_GAP_LAYERS: f64 = 2.0;

/// A file without a plan, judged.
#[derive(Clone, Debug, Serialize)]
pub struct Refereed {
    /// Findings and figures; of the rules that are judged alone.
    pub report: Report,
    /// Runs of printed lines at one pose.
    pub runs: usize,
    /// Rules that only a plan and its model can be asked for.
    pub not_judged: Vec<Rule>,
}

/// Why a file without a plan is not judged.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "verify/")]
pub enum Unjudged {
    /// Nothing is printed at a known place and pose.
    #[error(
        "nothing is extruded at a known position and table pose; the file must home the machine and move both rotary axes ({letters}) before it prints"
    )]
    NothingPrinted {
        /// The machine's rotary letters.
        letters: String,
    },
    /// Too many poses.
    #[error(
        "lines are printed at {runs} poses, one after the other (maximum {MOST_RUNS}), and such files are not judged"
    )]
    ManyPoses {
        /// How many.
        runs: usize,
    },
}

/// Lines of one pose that follow each other.
struct PoseRun {
    pose: Pose,
    /// Places of the tip where filament is laid, machine frame, mm.
    beads: Bounds,
    /// The lines in the file of its first and last printing move, and of the first turn before them.
    lines: [u32; 2],
    turned: Option<u32>,
    /// Where it begins to print supports, or ends; the first is its own first line.
    switches: Vec<Switch>,
}

/// A line from which on supports are printed, or no longer, with what the slicer says of it.
struct Switch {
    line: u32,
    is_support: bool,
    role: Role,
    /// Stated, mm.
    width: Option<f64>,
    height: Option<f64>,
}

impl Switch {
    /// The comments that say of a print's lines what the file said before it: a print begins with nothing said.
    fn said(&self) -> impl Iterator<Item = String> {
        let role = (self.role != Role::Unknown).then(|| format!(";TYPE:{}", self.role.name()));
        let width = self.width.map(|mm| format!(";WIDTH:{mm}"));
        let height = self.height.map(|mm| format!(";HEIGHT:{mm}"));
        role.into_iter().chain(width).chain(height)
    }
}

/// Judges a program by what it does on `profile`'s machine.
///
/// # Errors
///
/// [`Unjudged`] where no rule could say anything.
pub fn referee(bytes: &[u8], profile: &Profile) -> Result<Refereed, Unjudged> {
    let bytes = unmarked(bytes);
    let trace = trace::read(&bytes, &profile.trace_setting());
    let runs = runs(&trace, profile)?;
    let end = end_of(&trace, runs.last().map_or(0, |run| run.lines[1]));
    let table = profile.kinematics();
    let model = boxes(&runs, &table, profile);
    let placement = Placement { origin_mm: [0.0; 3], turn_deg: 0.0 };
    let (workpiece, plan) = (Workpiece::place(&model, &placement), plan_of(&runs, &table, profile, placement));
    let (marked, added) = with_marks(&bytes, &runs, end, &table);
    let mut trace = trace::read(&marked, &profile.trace_setting());
    trace.renumber(|line| line - added.partition_point(|mark| *mark < line) as u32);
    let job = ReplayJob { profile, plan: &plan, workpiece: &workpiece };
    let planned = planned(&job);
    let printed = prints::gather(&trace, &job, &planned);
    let acts = Acts::new(&trace, profile, &printed);
    let evidence =
        Evidence { bytes: &marked, trace: &trace, job: &job, planned: &planned, printed: &printed, acts: &acts };
    let mut checked = by(&CHECKS, &evidence);
    // What a firmware makes of each line is asked of the lines as they are.
    checked.push(reading::check(&Evidence { bytes: &bytes, ..evidence }));
    let mut report = report_of(&trace, checked);
    report.counts.retain(|rule, _| JUDGED.contains(rule));
    report.findings.retain(|finding| JUDGED.contains(&finding.rule));
    // The file names no parts.
    report.findings.iter_mut().for_each(|finding| finding.part = None);
    Ok(Refereed { report, runs: runs.len(), not_judged: UNJUDGED.to_vec() })
}

/// The program with our own comments made empty; its lines keep their numbers.
fn unmarked(bytes: &[u8]) -> Vec<u8> {
    let mut parsed = ParsedLine::default();
    let mut out = Vec::with_capacity(bytes.len());
    for line in lines(bytes) {
        let is_ours = parsed.read(line.bytes).is_ok() && mark(&line.bytes[parsed.comment.clone()]).is_some();
        out.extend_from_slice(if is_ours { &line.bytes[parsed.code.clone()] } else { line.bytes });
        out.push(b'\n');
    }
    out
}

/// The runs of a trace, in order.
fn runs(trace: &Trace, profile: &Profile) -> Result<Vec<PoseRun>, Unjudged> {
    let (mut all, mut turned): (Vec<PoseRun>, Option<u32>) = (Vec::new(), None);
    let mut count = 0;
    for m in trace.moves() {
        if trace.turns(&m) {
            turned.get_or_insert(m.line);
        }
        let (Some(ends), Some(pose), true) = (m.ends(), trace.state(&m).pose(), m.prints()) else { continue };
        match all.last_mut().filter(|run| run.pose == pose) {
            Some(run) => run.take(&m, ends),
            None => {
                count += 1;
                let beads = Bounds::of(ends);
                let mut run = PoseRun { pose, beads, lines: [m.line; 2], turned, switches: Vec::new() };
                run.take(&m, ends);
                if count <= MOST_RUNS {
                    all.push(run);
                } else if let Some(last) = all.last_mut() {
                    *last = run;
                }
            }
        }
        turned = None;
    }
    let table = profile.kinematics();
    let [tilt, rotation] = [table.tilt.letter, table.rotation.letter].map(char::from);
    match count {
        0 => Err(Unjudged::NothingPrinted { letters: format!("{tilt}, {rotation}") }),
        1..=MOST_RUNS => Ok(all),
        runs => Err(Unjudged::ManyPoses { runs }),
    }
}

/// The line at which the end code begins: the first behind the `last` printed one that is no move. Travels before it are the last print's.
fn end_of(trace: &Trace, last: u32) -> u32 {
    let is_code = |event: &&Event| event.line > last && matches!(event.what, What::Effect(..));
    trace.events.iter().find(is_code).map_or(trace.lines + 1, |event| event.line)
}

impl PoseRun {
    fn take(&mut self, m: &TraceMove, ends: [Vec3; 2]) {
        self.beads = self.beads.union(&Bounds::of(ends));
        self.lines[1] = m.line;
        let is_support = m.role == Role::Support;
        if self.switches.last().is_none_or(|before| before.is_support != is_support) {
            let &TraceMove { line, role, width, height, .. } = m;
            self.switches.push(Switch { line, is_support, role, width, height });
        }
    }

    fn has_supports(&self) -> bool {
        self.switches.iter().any(|switch| switch.is_support)
    }

    /// What it fills at most, upright, machine frame, mm.
    fn filled(&self, table: &TableKinematics, profile: &Profile) -> Bounds {
        let half = profile.process.line_width_mm / 2.0;
        let below = table.forward(self.pose).translation;
        let mut filled = self.beads.inflated(half);
        filled.max.z = self.beads.max.z;
        filled.min.z = self.beads.min.z - profile.process.layer_height_mm;
        // A first layer on the level table reaches down to it, however high it is.
        let level = (table.forward(self.pose).rotation * Vec3::z()).z > 1.0 - 1e-9;
        if level && filled.min.z < below.z + profile.process.nozzle_mm {
            filled.min.z = below.z;
        }
        filled.max.z = filled.max.z.max(filled.min.z + LEAST_MM);
        filled
    }
}

/// A box for each run, in the table's frame, as if each touched each other.
fn boxes(runs: &[PoseRun], table: &TableKinematics, profile: &Profile) -> Model {
    let part = |(id, run): (usize, &PoseRun)| {
        let back = table.forward(run.pose).inverse();
        let upright = TriangleMesh::<Object>::cuboid(&run.filled(table, profile));
        let vertices = upright.vertices().iter().map(|v| back.rotation * v + back.translation).collect();
        Part { id, name: String::new(), mesh: TriangleMesh::new(vertices, upright.facets().to_vec()) }
    };
    let parts: Vec<Part> = runs.iter().enumerate().map(part).collect();
    let bounds = parts.iter().fold(Bounds::EMPTY, |all, part| all.union(&part.mesh.bounds()));
    let stands = |part: &&Part| part.mesh.bounds().min.z < profile.process.nozzle_mm;
    let on_table = parts.iter().filter(stands).map(|part| part.id).collect();
    let touch = |a: usize, b: usize| {
        let (facets_a, facets_b) = (Vec::new(), Vec::new());
        Interface { a, b, area_mm2: 1.0, normal: Vec3::zeros(), facets_a, facets_b }
    };
    let interfaces = (0..parts.len()).flat_map(|b| (0..b).map(move |a| touch(a, b))).collect();
    let (captive, warnings, others) = (Vec::new(), Vec::new(), Vec::new());
    Model { parts, interfaces, on_table, captive, unit: Unit::Millimetre, warnings, bounds, others }
}

fn plan_of(runs: &[PoseRun], table: &TableKinematics, profile: &Profile, placement: Placement) -> Plan {
    let supports = || PrintSupports {
        step_mm: 1.0,
        overhang_deg: 45.0,
        gap_mm: SUPPORT_GAP_LAYERS * profile.process.layer_height_mm,
        roof: None,
        brace_mm: None,
        only_props: false,
        props: Vec::new(),
    };
    let slot = |(id, run): (usize, &PoseRun)| {
        let up = table.forward(run.pose).inverse().rotation * Vec3::z();
        let [tilt_deg, rotation_deg] = words(table, run.pose);
        let supports = run.has_supports().then(supports);
        TimeSlot { id, prints: vec![Print { part: id, up: up.into(), tilt_deg, rotation_deg, supports }] }
    };
    let no_name = String::new;
    Plan {
        format: Plan::FORMAT.to_owned(),
        version: Plan::VERSION,
        made_by: no_name(),
        model: ModelRef { file: no_name(), sha256: no_name(), unit: "mm".to_owned() },
        machine: MachineRef { profile: no_name(), sha256: no_name() },
        placement,
        bridge_mm: None,
        parts: (0..runs.len()).map(|id| PartRef { id, name: no_name() }).collect(),
        slots: runs.iter().enumerate().map(slot).collect(),
        machine_values: None,
    }
}

/// The words of a pose, degrees.
fn words(table: &TableKinematics, pose: Pose) -> [f64; 2] {
    [table.tilt.word_of(pose.tilt).deg(), table.rotation.word_of(pose.rotation).deg()]
}

/// The program with the marks of its runs, and the numbers of these lines in it, ascending.
fn with_marks(bytes: &[u8], runs: &[PoseRun], end: u32, table: &TableKinematics) -> (Vec<u8>, Vec<u32>) {
    // By the line that they stand before.
    let mut marks: Vec<(u32, String)> = Vec::new();
    // Supports are prints of their own, behind those of all parts.
    let mut supports = runs.len();
    for (id, run) in runs.iter().enumerate() {
        let [tilt, rotation] = words(table, run.pose);
        let slot = slot_mark(id, &[id], [(table.tilt.letter, tilt), (table.rotation.letter, rotation)]);
        let first = run.lines[0];
        // What turned the table before the first run is the start code's.
        marks.push((run.turned.filter(|_| id > 0).unwrap_or(first), slot));
        for switch in &run.switches {
            let print = if switch.is_support { supports } else { id };
            marks.push((switch.line, print_mark(print, id)));
            marks.extend(switch.said().map(|text| (switch.line, text)));
        }
        supports += usize::from(run.has_supports());
    }
    marks.push((end, ";TRUNNION end".to_owned()));
    let (mut out, mut added, mut next) =
        (Vec::with_capacity(bytes.len() + 100 * marks.len()), Vec::new(), marks.iter().peekable());
    let mut add = |before: u32, out: &mut Vec<u8>| {
        while let Some((_, text)) = next.next_if(|(line, _)| *line <= before) {
            // Lines of the file before it, those that were added before it, and itself.
            added.push(before + added.len() as u32);
            out.extend_from_slice(text.as_bytes());
            out.push(b'\n');
        }
    };
    let mut last = 0;
    for line in lines(bytes) {
        add(line.number, &mut out);
        out.extend_from_slice(line.bytes);
        out.push(b'\n');
        last = line.number;
    }
    add(last + 1, &mut out);
    (out, added)
}

/// Whether every rule is judged or not judged, and none both.
#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::verify::RULES;

    #[test]
    fn each_rule_is_judged_or_said_not_to_be() {
        let all: BTreeSet<Rule> = JUDGED.into_iter().chain(UNJUDGED).collect();
        assert_eq!(all.len(), JUDGED.len() + UNJUDGED.len());
        assert_eq!(all, RULES.iter().map(|one| one.rule).collect());
    }

    #[test]
    fn marks_move_lines_down_and_no_other_line_changes() {
        let bytes = b"G28\n;TRUNNION print=0 part=0\nG1 X1 E1 ;TRUNNION end\nG1 X2 E1\nM84";
        let plain = unmarked(bytes);
        assert_eq!(plain, b"G28\n\nG1 X1 E1\nG1 X2 E1\nM84\n");
    }
}
