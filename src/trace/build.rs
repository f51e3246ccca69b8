//! Bytes to a [`Trace`]: the one place that reads a final file.

use std::collections::BTreeMap;

use super::clock::{Stretch, each_stretch};
use super::interpreter::{Action, Interpreter, TimedMove};
use super::{Event, MotionClock, State, Trace, TraceSetting, What, Zone, flag, units};
use crate::gcode::marks::{Hint, Mark, Role, Totals, hint, mark};
use crate::gcode::meaning::{Effect, Firmware, Hazard, Heater, correction};
use crate::gcode::{LineKind, ParsedLine, lines};
use crate::geom::Vec3;
use crate::motion::replay::{Move, Position};
use crate::motion::{Pose, SwivelHead};

/// The program in `bytes`, as the machine of `setting` would carry it out.
///
/// Never fails: what has no safe meaning is a [`What::Refused`], and the moves behind it begin where the last one ended.
pub fn read(bytes: &[u8], setting: &TraceSetting) -> Trace {
    let mut reader = TraceReader::new(setting, bytes.len());
    reader.take(bytes);
    reader.finish()
}

/// How many stretches the clock may be behind, about: half a megabyte.
const BEHIND: usize = 4096;

/// A program that is read in pieces, as when its own totals are written behind it.
///
/// A second thread, if there is one, keeps the time of what was read last; the trace is the same on any number of threads.
pub struct TraceReader {
    builder: Builder,
    parsed: ParsedLine,
    clock: MotionClock,
    /// What the clock has not seen yet.
    behind: Vec<Stretch>,
    /// Bytes and lines of the pieces before.
    bytes: usize,
    lines: u32,
}

impl TraceReader {
    /// Nothing read yet of a program that will have about so many bytes.
    pub fn new(setting: &TraceSetting, bytes: usize) -> Self {
        let (builder, clock) = (Builder::new(setting, bytes), MotionClock::new(&setting.accelerations));
        Self { builder, parsed: ParsedLine::default(), clock, behind: Vec::new(), bytes: 0, lines: 0 }
    }

    /// Takes the next piece: whole lines, but for the last of the last piece. An empty one changes nothing.
    pub fn take(&mut self, piece: &[u8]) {
        let mut rest = lines(piece).peekable();
        while rest.peek().is_some() {
            let Self { builder, parsed, clock, behind, .. } = self;
            let (bytes, before) = (self.bytes, self.lines);
            let mut next = Vec::new();
            let mut read = || {
                while next.len() < BEHIND
                    && let Some(line) = rest.next()
                {
                    let start = bytes + (line.bytes.as_ptr() as usize - piece.as_ptr() as usize);
                    builder.line = before + line.number;
                    builder.take(parsed, line.bytes, start, &mut next);
                }
            };
            // A machine's own start code is read often, and is over before another thread wakes up.
            if behind.is_empty() {
                read();
            } else {
                rayon::join(read, || behind.drain(..).for_each(|stretch| clock.pass(&stretch)));
            }
            self.behind = next;
        }
        self.bytes += piece.len();
        self.lines = self.builder.line;
    }

    /// Time and layers of what was read so far, as [`totals`](super::totals()) gives them.
    pub fn totals(&mut self) -> Totals {
        self.catch_up();
        let layers = self.builder.trace.events.iter().filter(|event| matches!(event.what, What::Layer)).count();
        Totals { seconds: self.clock.clone().seconds(), layers }
    }

    /// The trace of all that was read.
    pub fn finish(mut self) -> Trace {
        self.catch_up();
        let mut trace = self.builder.trace;
        trace.lines = self.lines;
        trace.seconds = self.clock.seconds();
        trace
    }

    fn catch_up(&mut self) {
        self.behind.drain(..).for_each(|stretch| self.clock.pass(&stretch));
    }
}

/// What a slicer says of the lines that follow.
#[derive(Clone, Copy, Default)]
struct Said {
    role: Role,
    width_um: u16,
    height_um: u16,
}

struct Builder {
    interpreter: Interpreter,
    firmware: Firmware,
    swivel: Option<SwivelHead>,
    trace: Trace,
    line: u32,
    state: State,
    said: Said,
    /// The same by print: prints take turns layer by layer, and none repeats what it has said.
    said_by: BTreeMap<u32, Said>,
}

impl Builder {
    fn new(setting: &TraceSetting, bytes: usize) -> Self {
        let state = State { tilt: None, rotation: None, print: None, slot: None, zone: Zone::Start, nozzle_c: 0.0 };
        let mut trace = Trace { states: vec![state], ..Trace::default() };
        // A line of a print has some thirty bytes.
        let count = bytes / 28;
        trace.line.reserve(count);
        trace.to.iter_mut().for_each(|axis| axis.reserve(count));
        [&mut trace.e, &mut trace.feed, &mut trace.at_speed_s].into_iter().for_each(|column| column.reserve(count));
        trace.state.reserve(count);
        [&mut trace.width_um, &mut trace.height_um, &mut trace.flags].into_iter().for_each(|c| c.reserve(count));
        trace.role.reserve(count);
        let (said, said_by) = (Said::default(), BTreeMap::new());
        let (swivel, firmware) = (setting.swivel.clone(), setting.reading.firmware);
        Self { interpreter: Interpreter::new(setting), firmware, swivel, trace, line: 0, state, said, said_by }
    }

    /// Takes a line that begins `start` bytes from the program's first; what of it takes time goes to `stretches`.
    fn take(&mut self, parsed: &mut ParsedLine, line: &[u8], start: usize, stretches: &mut Vec<Stretch>) {
        if let Err(error) = parsed.read(line) {
            return self.event(What::Refused(error.to_string()));
        }
        if parsed.kind == LineKind::Empty {
            return self.comment(&line[parsed.comment.clone()]);
        }
        let action = self.interpreter.take(parsed);
        if let Ok(action) = &action {
            each_stretch(action, |stretch| stretches.push(stretch));
        }
        match action {
            Ok(Action::Move(timed)) => self.make(timed),
            // It does nothing by itself, but what it ends is no longer done.
            Ok(Action::Nothing) if correction(self.firmware, parsed).is_some() => {
                self.effect(Effect::Nothing, start + parsed.code.start..start + parsed.code.end);
            }
            Ok(Action::Nothing) => {}
            Ok(Action::Effect(effect)) => self.effect(effect, start + parsed.code.start..start + parsed.code.end),
            Err(error) => self.event(What::Refused(error.to_string())),
        }
    }

    fn event(&mut self, what: What) {
        self.trace.events.push(Event { before: self.trace.line.len() as u32, line: self.line, what });
    }

    fn comment(&mut self, comment: &[u8]) {
        let um = |mm: f64| (mm * 1000.0).round().clamp(1.0, 65535.0) as u16;
        match hint(comment) {
            Some(Hint::Role(role)) => return self.said.role = role,
            Some(Hint::Width(mm)) => return self.said.width_um = um(mm),
            Some(Hint::Height(mm)) => return self.said.height_um = um(mm),
            Some(Hint::Layer) => return self.event(What::Layer),
            None => {}
        }
        let Some(mark) = mark(comment) else { return };
        match &mark {
            Mark::Slot(slot) => {
                self.leave_print(None);
                (self.state.slot, self.state.zone) = (Some(*slot as u32), Zone::Prints);
            }
            Mark::Print { print, .. } => self.leave_print(Some(*print as u32)),
            Mark::End => {
                self.leave_print(None);
                self.state.zone = Zone::End;
            }
            Mark::Broken => return self.event(What::BrokenMark(String::from_utf8_lossy(comment).into_owned())),
            Mark::Expect(_) | Mark::Other => {}
        }
        self.event(What::Mark(mark));
    }

    fn leave_print(&mut self, next: Option<u32>) {
        if let Some(print) = self.state.print {
            self.said_by.insert(print, self.said);
        }
        self.state.print = next;
        self.said = next.and_then(|print| self.said_by.get(&print)).copied().unwrap_or_default();
    }

    fn effect(&mut self, effect: Effect, span: std::ops::Range<usize>) {
        let target = self.interpreter.targets().nozzle_c as f32;
        match effect {
            Effect::Heat { heater: Heater::Nozzle, waits, .. } => {
                self.state.nozzle_c = if waits { target } else { self.state.nozzle_c.min(target) };
            }
            Effect::HeatWait => self.state.nozzle_c = target,
            Effect::HeatersOff | Effect::Hazard(Hazard::Stop | Hazard::End) => self.state.nozzle_c = 0.0,
            _ => {}
        }
        self.event(What::Effect(effect, span));
    }

    fn make(&mut self, timed: TimedMove) {
        let TimedMove { made: m, seconds, length_mm: length, chords, too_fast, .. } = timed;
        let (m, chords) = self.seen(m, chords);
        (self.state.tilt, self.state.rotation) = (m.to.tilt, m.to.rotation);
        if self.trace.states.last() != Some(&self.state) {
            self.trace.states.push(self.state);
        }
        if let Some(fast) = too_fast {
            self.event(What::TooFast(fast));
        }
        let mut flags = u16::from(m.written)
            | if m.rapid { flag::RAPID } else { 0 }
            | if m.inverse_time { flag::INVERSE_TIME } else { 0 }
            | if m.rotary_written { flag::ROTARY } else { 0 }
            | if m.arc.is_some() { flag::ARC } else { 0 };
        (0..3).filter(|&i| m.from.linear[i].is_none()).for_each(|i| flags |= 1 << (flag::FROM_UNKNOWN + i as u16));
        if chords.len() < 2 {
            self.push(&m, &m.to, m.e, seconds, flags);
            return;
        }
        let mut from = m.from.tip().unwrap_or(chords[0]);
        for chord in chords {
            let share = if length > 0.0 { (chord - from).norm() / length } else { 0.0 };
            let to = Position { linear: [Some(chord.x), Some(chord.y), Some(chord.z)], ..m.to };
            self.push(&m, &to, m.e * share, seconds * share, flags);
            flags |= flag::CHORD;
            from = chord;
        }
    }

    /// A move with its chords as the tool sees them: at the pose in which it ends.
    fn seen(&self, m: Move, mut chords: Vec<Vec3>) -> (Move, Vec<Vec3>) {
        let Some(swivel) = &self.swivel else { return (m, chords) };
        let pose = m.to.pose();
        chords.iter_mut().for_each(|chord| *chord = tip(swivel, *chord, pose));
        let place = |at: Position| match at.tip() {
            Some(words) => <[f64; 3]>::from(tip(swivel, words, pose)).map(Some),
            // One coordinate alone is a place of the upright tool.
            None if pose.is_none() => std::array::from_fn(|i| at.linear[i].map(|word| word - swivel.table[i])),
            None => [None; 3],
        };
        let [from, to] = [m.from, m.to].map(|at| Position { linear: place(at), ..at });
        (Move { from, to, ..m }, chords)
    }

    fn push(&mut self, m: &Move, to: &Position, e: f64, seconds: f64, flags: u16) {
        let trace = &mut self.trace;
        trace.line.push(self.line);
        let at = units(to);
        trace.to.iter_mut().zip(at).for_each(|(axis, v)| axis.push(v));
        trace.e.push(e as f32);
        trace.feed.push(m.feed.map_or(f32::NAN, |f| f as f32));
        trace.at_speed_s.push(seconds as f32);
        trace.state.push(trace.states.len() as u32 - 1);
        trace.width_um.push(self.said.width_um);
        trace.height_um.push(self.said.height_um);
        trace.role.push(self.said.role);
        trace.flags.push(flags);
    }
}

/// Where the tip is for the words of X, Y and Z; at an unknown pose as if the tool were upright.
fn tip(swivel: &SwivelHead, words: Vec3, pose: Option<Pose>) -> Vec3 {
    pose.map_or(words - swivel.table, |pose| swivel.tip(words, pose))
}
