//! The bytes to a [`Trace`], with the rules that need no geometry but the pose.

use super::marks::{Mark, Role, read};
use super::rates::{Extent, Rates};
use super::report::{Findings, Place, Rule};
use super::tally::Tally;
use super::trace::{Act, Blind, Kind, Planned, Stroke, Trace, Turn};
use crate::gcode::{LineKind, ParsedLine, lines};
use crate::geom::{Bounds, Vec3};
use crate::motion::replay::{Controller, Move, Position, Step, flatten};
use crate::motion::{AxisRange, LinearLimits, Pose, TableKinematics};
use crate::profile::Profile;

/// How far chords may leave an arc, mm: far below every tolerance that is asked of a place.
const CHORD_MM: f64 = 0.01;
/// How well a pose must be the plan's, degrees: ten times the last digit written.
const POSE_DEG: f64 = 1e-3;
/// How well the pose must bring the build direction upright (chord): the last digit of the plan's `up` and angles.
const UPRIGHT: f64 = 2e-5;

/// What was read.
pub(super) struct Read {
    pub(super) trace: Trace,
    pub(super) tally: Tally,
    pub(super) findings: Findings,
    pub(super) last_line: u32,
}

/// Replays `bytes` on the machine of `profile`.
pub(super) fn replay(bytes: &[u8], profile: &Profile, planned: &[Planned]) -> Read {
    let mut reader = Reader::new(profile, planned);
    let mut parsed = ParsedLine::default();
    for line in lines(bytes) {
        reader.line = line.number;
        if let Err(error) = parsed.read(line.bytes) {
            reader.findings.add(Rule::Syntax, reader.place(), [0.0, 0.0], || error.to_string());
            continue;
        }
        if parsed.kind == LineKind::Empty {
            reader.comment(&line.bytes[parsed.comment.clone()]);
            continue;
        }
        match reader.controller.step(&parsed) {
            Ok(step) => reader.step(&step),
            Err(error) => reader.findings.add(Rule::Syntax, reader.place(), [0.0, 0.0], || error.to_string()),
        }
    }
    reader.tally.finish(planned, reader.line, &mut reader.findings);
    let Reader { trace, tally, findings, line, .. } = reader;
    Read { trace, tally, findings, last_line: line }
}

struct Reader<'a> {
    planned: &'a [Planned],
    table: TableKinematics,
    limits: LinearLimits,
    rates: Rates,
    controller: Controller,
    trace: Trace,
    tally: Tally,
    findings: Findings,
    line: u32,
    print: Option<usize>,
    slot: Option<usize>,
    role: Role,
    width: f64,
    height: f64,
    /// The widest and highest line that a comment may claim.
    most: [f64; 2],
    least: [f64; 2],
    /// What is wrong with the pose for the print, worked out when either changes.
    pose_fault: Option<(f64, String)>,
}

impl<'a> Reader<'a> {
    fn new(profile: &Profile, planned: &'a [Planned]) -> Self {
        let table = profile.kinematics();
        let (p, nozzle) = (&profile.process, profile.process.nozzle_mm);
        let mut reader = Self {
            planned,
            limits: profile.linear_limits(),
            rates: Rates::new(profile, &table),
            controller: Controller::new(profile.reading()),
            table,
            trace: Trace::default(),
            tally: Tally::new(planned.len()),
            findings: Findings::default(),
            line: 0,
            print: None,
            slot: None,
            role: Role::default(),
            width: p.line_width_mm,
            height: p.layer_height_mm,
            // A nozzle lays no line wider than about twice its bore or higher than the bore.
            most: [p.line_width_mm.max(2.0 * nozzle), p.layer_height_mm.max(nozzle)],
            least: [p.line_width_mm, p.layer_height_mm],
            pose_fault: None,
        };
        reader.judge_pose();
        reader
    }

    fn place(&self) -> Place {
        let print = self.print.map(|p| &self.planned[p]);
        Place { line: self.line, slot: print.map(|p| p.slot).or(self.slot), part: print.map(|p| p.part) }
    }

    fn say(&mut self, rule: Rule, numbers: [f64; 2], text: impl FnOnce() -> String) {
        self.findings.add(rule, self.place(), numbers, text);
    }

    fn comment(&mut self, comment: &[u8]) {
        let clamped = |value: f64, low: f64, high: f64| if value.is_finite() { value.clamp(low, high) } else { low };
        match read(comment) {
            None | Some(Mark::Other) => {}
            Some(Mark::Role(role)) => self.role = role,
            Some(Mark::Width(mm)) => self.width = clamped(mm, self.least[0], self.most[0]),
            Some(Mark::Height(mm)) => self.height = clamped(mm, self.least[1], self.most[1]),
            Some(Mark::Slot(slot)) => (self.slot, self.print) = (Some(slot), None),
            Some(Mark::End) => self.print = None,
            Some(Mark::Expect { print, part, filament_mm }) => {
                if self.known(print, part) && !self.tally.expect(print, filament_mm) {
                    self.say(Rule::Sequence, [2.0, 1.0], || format!("print {print} is announced twice"));
                }
            }
            Some(Mark::Print { print, part }) => self.begin(print, part),
            Some(Mark::Broken) => {
                let text = String::from_utf8_lossy(comment).into_owned();
                self.say(Rule::Syntax, [0.0, 0.0], || format!("mark {text:?} cannot be read"));
            }
        }
        self.judge_pose();
    }

    fn begin(&mut self, print: usize, part: usize) {
        self.print = self.known(print, part).then_some(print);
        self.role = Role::default();
        [self.width, self.height] = self.least;
        let Some(slot) = self.print.map(|p| self.planned[p].slot) else { return };
        if self.slot != Some(slot) {
            let marked = self.slot.map_or("no slot".to_owned(), |s| format!("slot {s}"));
            self.say(Rule::Sequence, [slot as f64, self.slot.map_or(-1.0, |s| s as f64)], || {
                format!("print {print} belongs to slot {slot}, and {marked} is marked")
            });
        }
    }

    fn known(&mut self, print: usize, part: usize) -> bool {
        let wanted = self.planned.get(print).map(|p| p.part);
        if wanted != Some(part) {
            self.say(Rule::Sequence, [part as f64, wanted.map_or(-1.0, |p| p as f64)], || match wanted {
                Some(wanted) => format!("print {print} is marked as part {part}; in the plan it is part {wanted}"),
                None => format!("print {print} is not in the plan"),
            });
        }
        wanted.is_some()
    }

    /// Works out whether the pose is that of the print.
    fn judge_pose(&mut self) {
        let Some(plan) = self.print.map(|p| self.planned[p]) else {
            self.pose_fault = Some((0.0, "filament is laid before any print is marked".to_owned()));
            return;
        };
        self.pose_fault = self.controller.at.pose().and_then(|pose| self.fault(pose, &plan));
    }

    fn fault(&self, pose: Pose, plan: &Planned) -> Option<(f64, String)> {
        let tilt = (pose.tilt - plan.pose.tilt).abs().deg();
        let rotation = (pose.rotation - plan.pose.rotation).wrapped().abs().deg();
        let tip = self.table.forward(pose).rotation * plan.up - Vec3::z();
        let off = tilt.max(rotation);
        if off <= POSE_DEG && tip.norm() <= UPRIGHT {
            return None;
        }
        let word = |axis: &AxisRange, angle| format!("{}{:.3}", char::from(axis.letter), axis.word_of(angle).deg());
        let words = |p: Pose| [word(&self.table.tilt, p.tilt), word(&self.table.rotation, p.rotation)].join(" ");
        let lean = 2.0 * (tip.norm() / 2.0).min(1.0).asin();
        let text = format!(
            "part {} is printed at {}, {:.3} deg from upright; the plan says {} (to {POSE_DEG} deg)",
            plan.part,
            words(pose),
            lean.to_degrees(),
            words(plan.pose)
        );
        Some((off.max(lean.to_degrees()), text))
    }

    fn step(&mut self, step: &Step) {
        match step {
            Step::Move(m) => self.make(m),
            Step::FirmwareRetract(pull) => {
                let at = self.place();
                self.tally.firmware(*pull, at, &mut self.findings);
            }
            Step::Dwell(seconds) => self.trace.seconds += seconds.max(0.0),
            Step::Text | Step::Nothing | Step::Home | Step::ExtruderSet(_) | Step::Other(_) => {}
        }
    }

    fn make(&mut self, m: &Move) {
        self.trace.moves += 1;
        self.check_limits(m);
        let path = self.path(m);
        let turned = m.from.tilt != m.to.tilt || m.from.rotation != m.to.rotation;
        self.check_rates(m, &path);
        if turned {
            self.judge_pose();
            if m.e > 0.0 {
                self.say(Rule::TurnWhileExtruding, [m.e, 0.0], || {
                    format!("the table turns while {:.3} mm of filament are pushed", m.e)
                });
            }
        }
        let moves = m.arc.is_some() || m.from.linear != m.to.linear;
        let prints = m.e > 0.0 && moves;
        self.check_known(m, prints);
        if prints {
            self.lay(m.e);
        } else if m.e != 0.0 {
            self.tally.pull(m.e);
        }
        if turned {
            let tips = self.box_of(&m.from).zip(self.box_of(&m.to)).map(|(from, to)| [from, to]);
            self.trace.acts.push(Act::Turn(Turn {
                from: m.from.pose(),
                to: m.to.pose(),
                tips,
                line: self.line,
                slot: self.slot,
            }));
        }
        if moves {
            self.go(m, &path, prints);
        }
    }

    /// Where the tip goes, chord by chord, the start included; empty where not all of it is known.
    fn path(&self, m: &Move) -> Vec<Vec3> {
        let Some((from, to)) = m.from.tip().zip(m.to.tip()) else { return Vec::new() };
        let mut path = vec![from];
        match &m.arc {
            Some(arc) => path.extend(flatten(from, to, arc, CHORD_MM)),
            None => path.push(to),
        }
        path
    }

    fn check_limits(&mut self, m: &Move) {
        for i in 0..3 {
            let (Some(value), low, high) = (m.to.linear[i], self.limits.min[i], self.limits.max[i]) else { continue };
            // The other coordinates are taken from inside, so that only this one is judged.
            let mut probe = (self.limits.min + self.limits.max) * 0.5;
            probe[i] = value;
            if let (true, Some(out)) = (m.written >> i & 1 == 1, self.limits.violation(&probe)) {
                self.say(Rule::AxisLimit, [value, if value < low { low } else { high }], || out.to_string());
            }
        }
        if !m.rotary_written {
            return;
        }
        let axes = [(self.table.tilt.clone(), m.to.tilt), (self.table.rotation.clone(), m.to.rotation)];
        for (axis, angle) in axes {
            let (Some(angle), Some((low, high))) = (angle, axis.range) else { continue };
            if !axis.admits(angle) {
                let (word, low, high) = (axis.word_of(angle).deg(), low.deg(), high.deg());
                self.say(Rule::AxisLimit, [word, if word < low { low } else { high }], || {
                    let letter = char::from(axis.letter);
                    format!("{letter} {word:.3} deg is beyond the axis, which reaches {low:.3}..{high:.3}")
                });
            }
        }
    }

    fn check_rates(&mut self, m: &Move, path: &[Vec3]) {
        let length = match path {
            // What is not known takes no time; it moves all the same.
            [] => known_length(m),
            path => path.windows(2).map(|w| (w[1] - w[0]).norm()).sum(),
        };
        let turns = [(m.from.tilt, m.to.tilt), (m.from.rotation, m.to.rotation)]
            .map(|(from, to)| if from == to { Some(0.0) } else { Some((to? - from?).abs().deg()) });
        let (seconds, fault) = self.rates.check(m, &Extent { length, turns });
        self.trace.seconds += seconds;
        if let Some(fault) = fault {
            self.say(Rule::AxisRate, [fault.measured, fault.allowed], || fault.text);
        }
    }

    fn check_known(&mut self, m: &Move, prints: bool) {
        let sideways = m.written & 0b011 != 0 || m.arc.is_some();
        let unknown = m.from.tip().is_none() || m.to.tip().is_none() || m.to.pose().is_none();
        let text = if prints && unknown {
            "filament is laid while the tip's place or the table's pose is unknown"
        } else if sideways && m.to.linear[2].is_none() {
            "the head moves sideways at an unknown height"
        } else if sideways && unknown && self.tally.started() {
            "the head moves sideways from an unknown place, with something printed on the table"
        } else {
            return;
        };
        self.say(Rule::UnknownPosition, [0.0, 0.0], || text.to_owned());
    }

    fn lay(&mut self, e: f64) {
        let at = self.place();
        self.tally.lay(self.print, e, self.planned, at, &mut self.findings);
        if let Some((off, text)) = self.pose_fault.clone() {
            self.say(Rule::Pose, [off, POSE_DEG], || text);
        }
    }

    fn go(&mut self, m: &Move, path: &[Vec3], prints: bool) {
        if path.is_empty() {
            // Coming from an unknown height, nothing can be said; before the first print nothing need be.
            if let (Some(from), Some(to)) = (self.box_of(&m.from), self.box_of(&m.to)) {
                let within = from.union(&to);
                self.trace.acts.push(Act::Blind(Blind { within, line: self.line }));
            }
            return;
        }
        let kind = if prints { Kind::Print(self.role) } else { Kind::Travel };
        let stroke = |from, to| Stroke {
            from,
            to,
            line: self.line,
            print: self.print.map(|p| p as u32),
            kind,
            width: self.width as f32,
            height: self.height as f32,
        };
        self.trace.acts.extend(path.windows(2).map(|w| Act::Stroke(stroke(w[0], w[1]))));
    }

    /// Where the tip is, an unknown X or Y anywhere within the limits; `None` where the height is unknown.
    fn box_of(&self, at: &Position) -> Option<Bounds> {
        at.linear[2]?;
        let end = |limit: &Vec3| Vec3::from_fn(|i, _| at.linear[i].unwrap_or(limit[i]));
        Some(Bounds { min: end(&self.limits.min), max: end(&self.limits.max) })
    }
}

fn known_length(m: &Move) -> f64 {
    let along = |i: usize| m.from.linear[i].zip(m.to.linear[i]).map_or(0.0, |(from, to)| to - from);
    Vec3::from_fn(|i, _| along(i)).norm()
}
