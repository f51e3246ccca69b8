//! The rules that need no geometry but the pose: syntax, commands, limits, speeds, order, heat, retraction, the end.

use std::collections::BTreeSet;

use super::astray::{POSE_DEG, PoseError, pose_error};
use super::commands::{Permitted, fits, name_of};
use super::evidence::{Checked, Evidence, Figures};
use super::heaters::Heaters;
use super::homing::Homing;
use super::report::{FindingPlace, Findings, Rule};
use super::settings::Settings;
use super::tally::Tally;
use super::turn_lines::TurnLines;
use super::{Planned, ReplayJob};
use crate::gcode::ParsedLine;
use crate::gcode::marks::{END_MARK, Expect, Mark};
use crate::gcode::meaning::{Correction, Corrections, Effect, Firmware, Hazard, Heater};
use crate::geom::{Angle, Bounds, Vec3};
use crate::motion::{AxisRange, LinearLimits, Pose, TableKinematics};
use crate::profile::Profile;
use crate::trace::{Event, State, Trace, TraceMove, What, Zone};

/// What the last digits may take of the room above all that stands, mm.
const PAUSE_SLACK_MM: f64 = 0.01;

/// What to do about a setting.
const REMOVE_OR_ALLOW: &str = "remove the line, or add its command to [dialect] allow";
/// Slower than this nothing is printed, pulled or moved, mm/s, but where the profile asks for it.
pub(super) const SLOWEST_MM_PER_S: f64 = 0.5;

/// The share of its highest speed that an axis of the table turns at, at least, and how long any turn may take, s.
pub(super) const SLOWEST_TURN: f64 = 0.01;
const LEAST_TURN_S: f64 = 10.0;

fn slowest(profile: &Profile) -> f64 {
    let (process, transition) = (&profile.process, &profile.transition);
    let joint = profile.joint.mm_per_s.unwrap_or(f64::INFINITY);
    let asked = [process.slowest_mm_per_s, process.retract_mm_per_s, transition.retract_mm_per_s, joint];
    asked.iter().fold(SLOWEST_MM_PER_S, |least, speed| least.min(speed / 2.0))
}

/// Compares the program with the machine and the plan.
pub(super) fn check(evidence: &Evidence<'_>) -> Checked {
    let mut checker = Checker::new(evidence);
    let mut events = evidence.trace.events.iter().peekable();
    for m in evidence.trace.moves() {
        while let Some(event) = events.next_if(|e| e.before as usize <= m.index) {
            checker.event(event);
        }
        checker.make(&m);
    }
    events.for_each(|event| checker.event(event));
    checker.finish()
}

struct Checker<'a> {
    job: &'a ReplayJob<'a>,
    /// Where the last move has ended.
    tip_z: Option<f64>,
    pose: Option<Pose>,
    /// Prints of which something is laid, and of the setup that was last worked at the highest line.
    laid: BTreeSet<usize>,
    laid_top: Option<(usize, f64)>,
    bytes: &'a [u8],
    trace: &'a Trace,
    profile: &'a Profile,
    planned: &'a [Planned],
    table: TableKinematics,
    limits: LinearLimits,
    permitted: Permitted<'a>,
    heaters: Heaters,
    homing: Homing,
    settings: Settings,
    /// What the firmware does to coordinates, with the line that switched it on, and whether that was said.
    corrections: Corrections<u32>,
    told_corrected: bool,
    /// Whether it was said that the firmware does not follow the tip.
    told_unfollowed: bool,
    firmware: Firmware,
    tally: Tally,
    findings: Findings,
    line: u32,
    print: Option<usize>,
    slot: Option<usize>,
    zone: Zone,
    ended: bool,
    turn_lines: TurnLines<'a>,
    /// The slowest that a move may be, mm/s.
    slowest: f64,
    /// Whether the nozzle has been found too cold since it last changed.
    told_cold: bool,
    /// For which pose, setup and number of prints it is known how high all that stands reaches.
    known_standing: Option<((Pose, usize, usize), f64)>,
    /// The state whose pose was judged last, and the prints that have been found to be made at that pose wrongly.
    judged: Option<State>,
    told_astray: BTreeSet<Option<usize>>,
}

impl<'a> Checker<'a> {
    fn new(evidence: &Evidence<'a>) -> Self {
        let &Evidence { bytes, trace, job, planned, .. } = evidence;
        let profile = job.profile;
        let (permitted, firmware, table) = (Permitted::by(&profile.dialect), profile.firmware(), profile.kinematics());
        Self {
            job,
            tip_z: None,
            pose: None,
            laid: BTreeSet::new(),
            laid_top: None,
            bytes,
            trace,
            profile,
            planned,
            limits: profile.linear_limits(),
            heaters: Heaters::of(&permitted, firmware),
            homing: Homing::of(firmware, [table.tilt.letter, table.rotation.letter]),
            settings: Settings::of(profile),
            corrections: Corrections::none(firmware, profile.dialect.rtcp),
            told_corrected: false,
            told_unfollowed: false,
            table,
            permitted,
            firmware,
            tally: Tally::new(planned.len(), profile.transition.prime_mm),
            findings: Findings::default(),
            line: 0,
            print: None,
            slot: None,
            zone: Zone::Start,
            ended: false,
            turn_lines: TurnLines::of(profile),
            slowest: slowest(profile),
            told_cold: false,
            known_standing: None,
            judged: None,
            told_astray: BTreeSet::new(),
        }
    }

    fn place(&self) -> FindingPlace {
        let print = self.print.map(|p| &self.planned[p]);
        FindingPlace { line: self.line, slot: print.map(|p| p.slot).or(self.slot), part: print.map(|p| p.part) }
    }

    fn say(&mut self, rule: Rule, numbers: [f64; 2], text: impl FnOnce() -> String) {
        self.findings.add(rule, self.place(), numbers, text);
    }

    fn event(&mut self, event: &Event) {
        self.line = event.line;
        match &event.what {
            What::Mark(mark) => self.mark(mark),
            What::BrokenMark(text) => self.say(Rule::Syntax, [0.0; 2], || format!("comment {text:?} is malformed")),
            What::Refused(text) => self.say(Rule::Syntax, [0.0; 2], || text.clone()),
            What::TooFast(fast) => self.say(Rule::AxisRate, [fast.measured, fast.allowed], || fast.text.clone()),
            What::Effect(effect, span) => self.effect(*effect, span.clone()),
            What::Layer => {}
        }
    }

    fn mark(&mut self, mark: &Mark) {
        match mark {
            Mark::Slot(slot) => (self.slot, self.print, self.zone) = (Some(*slot), None, Zone::Prints),
            Mark::End => (self.print, self.zone, self.ended) = (None, Zone::End, true),
            Mark::Expect(Expect { print, part, filament_mm, .. }) => {
                if self.known(*print, *part) && !self.tally.expect(*print, *filament_mm) {
                    self.say(Rule::Sequence, [2.0, 1.0], || {
                        format!("print {print} has two \";TRUNNION expect\" comments")
                    });
                }
            }
            Mark::Print { print, part } => self.begin(*print, *part),
            Mark::Other | Mark::Broken => {}
        }
    }

    fn begin(&mut self, print: usize, part: usize) {
        self.print = self.known(print, part).then_some(print);
        let Some(slot) = self.print.map(|p| self.planned[p].slot) else { return };
        if self.slot != Some(slot) {
            let marked = self.slot.map_or("no slot".to_owned(), |s| format!("slot {s}"));
            self.say(Rule::Sequence, [slot as f64, self.slot.map_or(-1.0, |s| s as f64)], || {
                format!("print {print} belongs to slot {slot}, but the \";TRUNNION slot=\" comment has {marked}")
            });
        }
    }

    fn known(&mut self, print: usize, part: usize) -> bool {
        let wanted = self.planned.get(print).map(|p| p.part);
        if wanted != Some(part) {
            self.say(Rule::Sequence, [part as f64, wanted.map_or(-1.0, |p| p as f64)], || match wanted {
                Some(wanted) => {
                    format!("a \";TRUNNION\" comment gives print {print} part {part}; in the plan it is part {wanted}")
                }
                None => format!("print {print} is not in the plan"),
            });
        }
        wanted.is_some()
    }

    /// How high the table reaches and what was printed in other setups than this; worked out once for lines that follow each other.
    fn standing(&mut self, pose: Pose, setup: usize) -> f64 {
        let key = (pose, setup, self.laid.len());
        if let Some((known, top)) = self.known_standing
            && known == key
        {
            return top;
        }
        let motion = self.table.forward(pose);
        let top_of = |points: &[Vec3]| {
            let heights = points.iter().map(|p| (motion.rotation * p + motion.translation).z);
            heights.fold(f64::NEG_INFINITY, f64::max)
        };
        let before = self.laid.iter().filter(|&&p| self.planned[p].setup != setup).map(|&p| self.planned[p].part);
        let parts = before.filter_map(|part| self.job.workpiece.parts.get(part)).map(|part| top_of(part.vertices()));
        // A head that turns comes down to no table that lies still.
        let slab = if self.table.head.is_some() { Vec::new() } else { self.profile.table_slab() };
        let top = parts.fold(top_of(&slab), f64::max);
        self.known_standing = Some((key, top));
        top
    }

    /// Whether the tip is above all that stands, and the filament pulled back as for a turn. Only asked where a person is waited for.
    fn is_clear(&mut self, effect: Effect) -> bool {
        let (Effect::Hazard(Hazard::Person), Some(tip), Some(pose)) = (effect, self.tip_z, self.pose) else {
            return false;
        };
        let Some(setup) = self.print.map(|p| self.planned[p].setup) else { return false };
        let standing = self.standing(pose, setup);
        let top = standing.max(self.laid_top.filter(|(of, _)| *of == setup).map_or(f64::NEG_INFINITY, |(_, z)| z));
        let room = self.profile.transition.clearance_mm - PAUSE_SLACK_MM;
        // Where the axis ends below that room there is less of it, but never none.
        let end = if self.table.head.is_some() { f64::INFINITY } else { self.limits.max.z - PAUSE_SLACK_MM };
        tip >= (top + room).min(end).max(top) && self.tally.is_pulled(self.profile.transition.retract_mm)
    }

    fn effect(&mut self, effect: Effect, span: std::ops::Range<usize>) {
        let text = &self.bytes[span];
        self.turn_lines.note(self.line, text, effect);
        let clear = self.is_clear(effect);
        let mut parsed = ParsedLine::default();
        let read = parsed.read(text).is_ok();
        if read
            && !self.is_beside_turns(text)
            && let Some(objection) = self.permitted.objection(effect, self.zone, &parsed, text, clear)
        {
            self.say(Rule::Command, [0.0; 2], || objection);
        }
        if read {
            self.states(effect, &parsed, text);
        }
        match effect {
            Effect::Retract(pull) => {
                let at = self.place();
                self.tally.firmware(pull, at, &mut self.findings);
            }
            Effect::Heat { heater, target_c: Some(target), .. } => self.target(heater, target),
            _ => {}
        }
        self.told_cold = false;
    }

    /// Whether a line is one of those that the profile has beside turns.
    fn is_beside_turns(&self, text: &[u8]) -> bool {
        self.zone == Zone::Prints && self.turn_lines.has(String::from_utf8_lossy(text).trim())
    }

    /// What a line changes of heat, homing and all that stays in force.
    fn states(&mut self, effect: Effect, line: &ParsedLine, text: &[u8]) {
        self.homing.note(effect, line);
        let own = self.permitted.owns(self.zone, text);
        let wanted = |what| what == Correction::TipFollowing && self.profile.dialect.rtcp;
        let corrects = self.corrections.note(line, &self.line).is_some_and(|(what, on)| on && !wanted(what));
        // What must not stand there is a finding already.
        self.told_corrected |= corrects && !own && !self.permitted.allows(&name_of(line, text));
        if let Some((numbers, why)) = self.heaters.note(effect, self.zone, own) {
            self.say(Rule::Heat, numbers, || why);
        }
        if effect != Effect::Setting {
            return;
        }
        let name = name_of(line, text);
        let permitted = own || self.permitted.allows(&name) || self.is_beside_turns(text);
        if let Some((numbers, why)) = self.settings.note(line, self.line, permitted) {
            self.say(Rule::Setting, numbers, || format!("{why}; {REMOVE_OR_ALLOW}"));
        }
    }

    /// More heat than the machine has.
    fn target(&mut self, heater: Heater, target: f64) {
        let (name, key, most) = match heater {
            Heater::Nozzle | Heater::OtherNozzle(_) => ("nozzle", "max_nozzle_c", self.profile.link.max_nozzle_c),
            Heater::Bed => ("bed", "max_bed_c", self.profile.link.max_bed_c),
            Heater::Chamber => return,
        };
        if target > most {
            self.say(Rule::Heat, [target, most], || {
                format!("{target} C for the {name} is above the maximum of {most} C ([link] {key})")
            });
        }
    }

    /// Judges the lines beside turns, before a move that is one or is none, or at the end.
    fn beside_turn(&mut self, turns: bool) {
        if let Some((line, wrong)) = self.turn_lines.moved(turns)
            && (self.zone == Zone::Prints || line.is_none())
        {
            let here = self.line;
            self.line = line.unwrap_or(here);
            self.say(Rule::Command, [0.0, 1.0], || wrong);
            self.line = here;
        }
    }

    fn make(&mut self, m: &TraceMove) {
        self.line = m.line;
        self.beside_turn(m.wrote_rotary());
        self.check_limits(m);
        self.check_followed(m);
        self.check_homed(m);
        self.check_slow(m);
        let turns = self.trace.turns(m);
        if turns && m.e > 0.0 {
            let turner = self.table.turner();
            self.say(Rule::TurnWhileExtruding, [m.e, 0.0], || {
                format!("{:.3} mm of filament is extruded while the {turner} turns", m.e)
            });
        }
        if turns {
            let (at, pulled) = (self.place(), self.profile.transition.retract_mm);
            self.tally.turn(pulled, at, &mut self.findings);
        }
        let prints = m.prints();
        self.check_known(m, prints);
        if m.e > 0.0 {
            self.check_heat(m);
        }
        (self.tip_z, self.pose) = (m.to[2], self.trace.state(m).pose());
        if prints {
            self.note_laid(m);
            self.lay(m);
        } else if m.e != 0.0 {
            self.tally.pull(m.e);
        }
    }

    /// Remembers what stands.
    fn note_laid(&mut self, m: &TraceMove) {
        let (Some(print), Some(z)) = (self.print, m.to[2]) else { return };
        self.laid.insert(print);
        let setup = self.planned[print].setup;
        let before = self.laid_top.filter(|(of, _)| *of == setup).map_or(z, |(_, top)| top);
        self.laid_top = Some((setup, before.max(z)));
    }

    /// The linear axes of a machine whose head turns: at the end of a move, and all the way of a turn.
    fn check_swivelled(&mut self, m: &TraceMove) {
        let Some(head) = &self.table.head else { return };
        let (from, to) = (self.trace.state_before(m).pose(), self.trace.state(m).pose());
        let end = m.to[0].zip(m.to[1]).zip(m.to[2]).map(|((x, y), z)| Vec3::new(x, y, z));
        let (Some(end), Some(pose)) = (end, to) else {
            // Each known word for itself, as that of the upright tool.
            let middle = (self.limits.min + self.limits.max) * 0.5;
            let words = |i: usize| m.to[i].filter(|_| m.wrote(i)).map(|v| v + head.table[i]);
            let out = (0..3).find_map(|i| {
                let mut probe = middle;
                probe[i] = words(i)?;
                self.limits.violation(&probe)
            });
            if let Some(out) = out {
                let (low, high) = out.range;
                self.say(Rule::AxisLimit, [out.value, if out.value < low { low } else { high }], || out.to_string());
            }
            return;
        };
        let axes = match from.zip(m.ends()).filter(|_| self.trace.turns(m)) {
            None => Bounds::of([head.axes(end, pose)]),
            Some((from, [start, _])) => {
                let words = [head.words(start, from), head.words(end, pose)];
                let one = |words: Vec3| match (from.tilt == pose.tilt, from.rotation == pose.rotation) {
                    (false, false) => head.axes_anywhere(words),
                    _ => head.axes_while_turning(words, from, pose),
                };
                one(words[0]).union(&one(words[1]))
            }
        };
        for corner in [axes.min, axes.max] {
            if let Some(out) = self.limits.violation(&corner) {
                let (low, high) = out.range;
                return self
                    .say(Rule::AxisLimit, [out.value, if out.value < low { low } else { high }], || out.to_string());
            }
        }
    }

    fn check_limits(&mut self, m: &TraceMove) {
        self.check_swivelled(m);
        let turns_head = self.table.head.is_some();
        for i in (0..3).filter(|_| !turns_head) {
            let (Some(value), low, high) = (m.to[i], self.limits.min[i], self.limits.max[i]) else { continue };
            // The other coordinates are taken from inside, so that only this one is judged.
            let mut probe = (self.limits.min + self.limits.max) * 0.5;
            probe[i] = value;
            let judged = m.wrote(i) || m.continues_arc();
            if let (true, Some(out)) = (judged, self.limits.violation(&probe)) {
                self.say(Rule::AxisLimit, [value, if value < low { low } else { high }], || out.to_string());
            }
        }
        if !m.wrote_rotary() {
            return;
        }
        let state = *self.trace.state(m);
        let axes = [(self.table.tilt.clone(), state.tilt), (self.table.rotation.clone(), state.rotation)];
        for (axis, angle) in axes {
            let (Some(angle), Some((low, high))) = (angle, axis.range) else { continue };
            if !axis.admits(angle) {
                let (word, low, high) = (axis.word_of(angle).deg(), low.deg(), high.deg());
                self.say(Rule::AxisLimit, [word, if word < low { low } else { high }], || {
                    let letter = char::from(axis.letter);
                    format!("{letter} {word:.3} deg is beyond the axis range {low:.3}..{high:.3}")
                });
            }
        }
    }

    fn check_known(&mut self, m: &TraceMove, prints: bool) {
        let sideways = m.wrote(0) || m.wrote(1);
        let unknown = m.ends().is_none() || self.trace.state(m).pose().is_none();
        let text = if prints && unknown {
            "filament is extruded while the tip's position or the table's pose is unknown"
        } else if sideways && m.to[2].is_none() {
            "the head moves sideways at an unknown height"
        } else if sideways && unknown && self.tally.started() {
            "the head moves sideways from an unknown position, with something printed on the table"
        } else {
            return;
        };
        self.say(Rule::UnknownPosition, [0.0; 2], || text.to_owned());
    }

    /// Filament is pushed through a nozzle that is known to be hot.
    fn check_heat(&mut self, m: &TraceMove) {
        let (now, least) = (f64::from(self.trace.state(m).nozzle_c), self.profile.limits.min_extrude_c);
        // Machines of RS274/NGC heat outside the program.
        if !self.firmware.is_printer() || now >= least || std::mem::replace(&mut self.told_cold, true) {
            return;
        }
        self.say(Rule::Heat, [now, least], || {
            if now > 0.0 {
                format!("filament is extruded at {now:.0} C (minimum {least:.0} C, [limits] min_extrude_c)")
            } else {
                format!("filament is extruded with the nozzle off, or without waiting for its temperature (minimum {least:.0} C); add M109 with the temperature")
            }
        });
    }

    /// A move of an axis that was not homed.
    fn check_homed(&mut self, m: &TraceMove) {
        let Some(axis) = self.homing.unhomed(m) else { return };
        self.say(Rule::UnknownPosition, [0.0; 2], || {
            format!("{axis} is moved before it is homed; home X, Y and Z with G28 in [dialect] start")
        });
    }

    /// A move that takes nearly for ever: the nozzle stands and melts what is below it.
    fn check_slow(&mut self, m: &TraceMove) {
        if m.wrote_rotary() {
            return self.check_slow_turn(m);
        }
        let length = m.ends().map_or(0.0, |[from, to]| (to - from).norm());
        let way = if length > 0.0 || m.travels() { length } else { m.e.abs() };
        if m.feed == Some(0.0) && way > 0.0 {
            let text = || "F0 sets no speed: the firmware keeps an earlier one, or stops".to_owned();
            return self.say(Rule::AxisRate, [0.0, self.slowest * 60.0], text);
        }
        let (speed, least) = (way / m.seconds, self.slowest);
        if way > 0.0 && m.seconds > 0.0 && speed < least {
            self.say(Rule::AxisRate, [speed * 60.0, least * 60.0], || {
                format!("a move at {:.2} mm/min is too slow (minimum {:.0} mm/min)", speed * 60.0, least * 60.0)
            });
        }
    }

    /// The same of a turn.
    fn check_slow_turn(&mut self, m: &TraceMove) {
        let (from, to) = (self.trace.state_before(m), self.trace.state(m));
        let turned =
            |from: Option<Angle>, to: Option<Angle>| from.zip(to).map_or(0.0, |(from, to)| (to - from).abs().deg());
        let kinematics = &self.profile.kinematics;
        let axes = [
            (turned(from.tilt, to.tilt), kinematics.tilt.max_deg_per_s),
            (turned(from.rotation, to.rotation), kinematics.rotation.max_deg_per_s),
        ];
        // The time that the slowest of both would take at its own least.
        let longest = axes.iter().map(|(turned, rate)| turned / (rate * SLOWEST_TURN)).fold(0.0, f64::max);
        let most = longest.max(LEAST_TURN_S);
        if longest > 0.0 && m.seconds > most {
            self.say(Rule::AxisRate, [m.seconds, most], || {
                let (percent, least) = (100.0 * SLOWEST_TURN, LEAST_TURN_S);
                format!(
                    "the turn takes {:.0} s (maximum {most:.0} s: {percent:.0} % of the axes' top speed, at least {least:.0} s)",
                    m.seconds
                )
            });
        }
    }

    fn lay(&mut self, m: &TraceMove) {
        let at = self.place();
        if let Some((line, (numbers, why))) = self.settings.lay(self.print) {
            let at = FindingPlace { line, ..at };
            self.findings.add(Rule::Setting, at, numbers, || format!("{why}; {REMOVE_OR_ALLOW}"));
        }
        self.check_corrected();
        if self.zone == Zone::Prints
            && let Some((numbers, why)) = self.heaters.lay()
        {
            self.say(Rule::Heat, numbers, || why);
        }
        self.tally.lay(self.print, m.e, self.planned, at, &mut self.findings);
        self.check_pose(*self.trace.state(m));
    }

    /// A print, and any move of a head that leans or turns, while the firmware does not follow the tip whose words these are; once.
    fn check_followed(&mut self, m: &TraceMove) {
        if !self.corrections.must_follow() || self.told_unfollowed {
            return;
        }
        let leans =
            self.trace.state(m).pose().is_some_and(|pose| pose.tilt != Angle::ZERO || pose.rotation != Angle::ZERO);
        let goes = leans && (0..3).any(|i| m.wrote(i));
        if goes || self.trace.turns(m) || (m.prints() && self.zone == Zone::Prints) {
            self.told_unfollowed = true;
            self.say(Rule::Command, [0.0, 2.0], || {
                "the firmware does not follow the tip here (G43.4), but X, Y and Z of this file are the tip's ([dialect] rtcp)".to_owned()
            });
        }
    }

    /// A firmware that moves what is laid by a correction of its own; once.
    fn check_corrected(&mut self) {
        let Some((what, &line)) = self.corrections.first() else { return };
        if self.zone != Zone::Prints || std::mem::replace(&mut self.told_corrected, true) {
            return;
        }
        let (at, off) = (FindingPlace { line, ..self.place() }, what.off(self.firmware));
        self.findings.add(Rule::Command, at, [0.0, 2.0], || {
            format!("this line {}; add {off} after it, before printing starts", what.harm())
        });
    }

    /// The pose of what is laid: of each print once, until the pose is another one.
    fn check_pose(&mut self, state: State) {
        let before = self.judged.replace(state);
        if before == Some(state) {
            return;
        }
        if before.and_then(|state| state.pose()) != state.pose() {
            self.told_astray.clear();
        }
        if let Some((off, text)) = self.pose_fault(&state)
            && self.told_astray.insert(self.print)
        {
            self.say(Rule::Pose, [off, POSE_DEG], || text);
        }
    }

    /// What is wrong with the pose for the print.
    fn pose_fault(&self, state: &State) -> Option<(f64, String)> {
        let Some(plan) = self.print.map(|p| &self.planned[p]) else {
            // A prime line of the start code: see `prime`.
            if self.zone == Zone::Start {
                return None;
            }
            return Some((0.0, "filament is extruded before the first \";TRUNNION print=\" comment".to_owned()));
        };
        let pose = state.pose()?;
        let PoseError { axis_deg, lean_deg } = pose_error(&self.table, plan, pose)?;
        let word = |axis: &AxisRange, angle| format!("{}{:.3}", char::from(axis.letter), axis.word_of(angle).deg());
        let words = |p: Pose| [word(&self.table.tilt, p.tilt), word(&self.table.rotation, p.rotation)].join(" ");
        let text = format!(
            "part {} is printed at {}, {lean_deg:.3} deg from upright, but the plan has {} (tolerance {POSE_DEG} deg); collisions and support are \
             not checked there",
            plan.part,
            words(pose),
            words(plan.pose)
        );
        Some((axis_deg.max(lean_deg), text))
    }

    fn finish(mut self) -> Checked {
        self.line = self.trace.lines.max(1);
        self.beside_turn(false);
        self.print = None;
        self.tally.finish(self.planned, self.line, &mut self.findings);
        if self.zone == Zone::End
            && let Some((numbers, why)) = self.heaters.end()
        {
            self.say(Rule::Heat, numbers, || why);
        }
        if !self.ended {
            self.say(Rule::Complete, [0.0, 1.0], || {
                "the file ends without the comment \";TRUNNION end\", so it was cut short".to_owned()
            });
        } else if let Some(missing) = self.missing_end() {
            let missing = missing.to_owned();
            self.say(Rule::Complete, [0.0, 1.0], || {
                format!("the end code's {missing:?} is missing: heaters or motors may stay on")
            });
        }
        let figures = Figures::Printed { slots: self.tally.slots(self.planned), filament_mm: self.tally.filament };
        Checked { findings: self.findings, figures }
    }

    /// The first line of the profile's end code that does not follow the end's mark, in order.
    fn missing_end(&self) -> Option<&'a str> {
        let at = memchr::memmem::rfind(self.bytes, END_MARK.as_bytes())?;
        let text = String::from_utf8_lossy(&self.bytes[at..]);
        let mut lines = text.lines().map(str::trim);
        self.permitted.end().iter().copied().find(|template| !lines.any(|line| fits(template, line)))
    }
}
