//! The lines of a print between its first and last extrusion, one by one, as they are passed on.

use std::ops::Range;

use super::policy::{CommandPolicy, Stage, keeps_comment, policy, takes_a_picture};
use super::source::{SlicedError, SlicedSource};
use super::turn::Turn;
use crate::gcode::meaning::Effect;
use crate::gcode::{LineKind, ParsedLine, PlainMove, first_line};
use crate::geom::Vec3;
use crate::motion::replay::{Arc, Controller, Move, PlainMoved, PlainStep, Step};

/// A move of three axes and filament, positions known.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Step3 {
    /// Before, mm.
    pub(super) from: Vec3,
    /// After, mm.
    pub(super) to: Vec3,
    /// Filament, mm.
    pub(super) e: f64,
    /// Feed, mm/min.
    pub(super) feed: Option<f64>,
    /// An arc in XY.
    pub(super) arc: Option<Arc>,
    /// The span of its comment in the file, with `;`.
    pub(super) comment: Range<usize>,
}

impl Step3 {
    /// Whether filament is laid down: pushed while the tip moves.
    pub(super) fn prints(&self) -> bool {
        self.e > 0.0 && (self.from != self.to || self.arc.is_some())
    }

    /// A move whose comment is at `comment`. From or to an unknown place only its filament counts, at no place; `None`
    /// where there is none: the way to the first known place is ours.
    pub(super) fn of(m: &Move, comment: Range<usize>) -> Option<Self> {
        let feed = m.feed;
        match m.from.tip().zip(m.to.tip()) {
            Some((from, to)) => Some(Self { from, to, e: m.e, feed, arc: m.arc, comment }),
            None if m.e != 0.0 => {
                Some(Self { from: Vec3::zeros(), to: Vec3::zeros(), e: m.e, feed, arc: None, comment })
            }
            None => None,
        }
    }
}

impl From<PlainMoved> for Step3 {
    #[inline]
    fn from(step: PlainMoved) -> Self {
        Self { from: step.from, to: step.to, e: step.e, feed: step.feed, arc: None, comment: 0..0 }
    }
}

/// Shorter waits are no waits for plastic, s: slicers have the program stand for a moment where something is switched.
pub(super) const LEAST_WAIT_S: f64 = 0.5;

/// One line of a layer.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Item {
    /// A move.
    Step(Step3),
    /// G10 (`true`) or G11.
    FirmwareRetract(bool),
    /// Bytes of the file to pass on as they stand.
    Keep(Range<usize>),
    /// The same where a person is waited for: not at the part.
    Pause(Range<usize>),
    /// A wait of so many seconds: not at the part either.
    Wait(f64),
}

impl Item {
    /// Turned, where it is a move.
    fn turned(self, turn: Turn) -> Self {
        let Self::Step(step) = self else { return self };
        let mut arc = step.arc;
        if let Some(arc) = &mut arc {
            arc.to_centre = turn.flat(arc.to_centre);
        }
        Self::Step(Step3 { from: turn.point(step.from), to: turn.point(step.to), arc, ..step })
    }
}

/// A place in a file, and the state that the lines before leave.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// Bytes before it.
    pub(super) at: usize,
    /// Lines before it.
    pub(super) line: u32,
    pub(super) controller: Controller,
}

impl Place {
    /// What the line here does, if it is a plain one; the place is then behind it.
    #[inline]
    pub(super) fn plain(&mut self, bytes: &[u8]) -> Option<PlainStep> {
        let plain = PlainMove::read(bytes.get(self.at..)?)?;
        let step = self.controller.step_plain(&plain)?;
        self.at += plain.length;
        self.line += 1;
        Some(step)
    }
}

/// Goes through the lines of a print.
#[derive(Clone, Debug)]
pub(super) struct Walk<'a> {
    source: SlicedSource<'a>,
    place: Place,
    parsed: ParsedLine,
    /// What every coordinate is turned by.
    turn: Option<Turn>,
}

impl<'a> Walk<'a> {
    pub(super) fn new(source: SlicedSource<'a>, place: Place, turn: Option<Turn>) -> Self {
        Self { source, place, parsed: ParsedLine::default(), turn }
    }

    /// Where the tip is, if all is known.
    pub(super) fn tip(&self) -> Option<Vec3> {
        let tip = self.place.controller.at.tip();
        self.turn.map_or(tip, |turn| tip.map(|p| turn.point(p)))
    }

    /// What the next line does, where it is a plain one before `end`.
    #[inline]
    pub(super) fn plain(&mut self, end: usize) -> Option<PlainStep> {
        let step = if self.place.at < end { self.place.plain(self.source.bytes) } else { None };
        match (self.turn, step) {
            (Some(turn), Some(PlainStep::Move(m))) => {
                Some(PlainStep::Move(PlainMoved { from: turn.point(m.from), to: turn.point(m.to), ..m }))
            }
            (_, step) => step,
        }
    }

    /// What the next line that is passed on says; `None` where the line at `end` bytes comes first.
    ///
    /// # Errors
    ///
    /// What reading the print would have refused; none for one that was read.
    #[inline]
    pub(super) fn next(&mut self, end: usize) -> Result<Option<Item>, SlicedError> {
        let item = self.next_sliced(end)?;
        Ok(match self.turn {
            Some(turn) => item.map(|item| item.turned(turn)),
            None => item,
        })
    }

    /// The same as it was sliced.
    #[inline]
    fn next_sliced(&mut self, end: usize) -> Result<Option<Item>, SlicedError> {
        let end = end.min(self.source.bytes.len());
        while self.place.at < end {
            match self.place.plain(self.source.bytes) {
                Some(PlainStep::Move(step)) => return Ok(Some(Item::Step(step.into()))),
                Some(PlainStep::Feed) => {}
                None => {
                    if let Some(item) = self.line()? {
                        return Ok(Some(item));
                    }
                }
            }
        }
        Ok(None)
    }

    /// Any line; `None` where it is left out.
    fn line(&mut self) -> Result<Option<Item>, SlicedError> {
        let Self { source, place, parsed, turn: _ } = self;
        let start = place.at;
        let (text, length) = first_line(&source.bytes[start..]);
        place.at += length;
        place.line += 1;
        let (file, line) = (source.file, place.line);
        parsed.read(text).map_err(|source| SlicedError::Parse { file: file.to_owned(), line, source })?;
        let whole = start..start + text.len();
        if parsed.kind == LineKind::Empty {
            let comment = &text[parsed.comment.clone()];
            return Ok((!comment.is_empty() && keeps_comment(comment)).then_some(Item::Keep(whole)));
        }
        if takes_a_picture(parsed) && !allows(parsed, source.allow) {
            return Ok(None);
        }
        let step = place.controller.step(parsed);
        let effect = match step.map_err(|source| SlicedError::Replay { file: file.to_owned(), line, source })? {
            Step::Nothing | Step::ExtruderSet(_) => return Ok(None),
            Step::Effect(Effect::Dwell(seconds)) => {
                return Ok((seconds >= LEAST_WAIT_S).then_some(Item::Wait(seconds)));
            }
            Step::Move(m) => return Ok(Step3::of(&m, comment_at(parsed, start, text.len())).map(Item::Step)),
            Step::Effect(Effect::Retract(pull)) => return Ok(Some(Item::FirmwareRetract(pull))),
            Step::Effect(effect) => effect,
        };
        match policies(effect, parsed, source.allow) {
            [CommandPolicy::Refuse, _] | [_, CommandPolicy::Refuse] => Err(refused(source, line, whole)),
            [_, CommandPolicy::Pause] => Ok(Some(Item::Pause(whole))),
            [CommandPolicy::Keep, _] | [_, CommandPolicy::Keep] => Ok(Some(Item::Keep(whole))),
            _ => Ok(None),
        }
    }
}

/// Where the comment of a line stands that begins at `start` and has `length` bytes, with `;`; empty for none.
pub(super) fn comment_at(parsed: &ParsedLine, start: usize, length: usize) -> Range<usize> {
    if parsed.comment.is_empty() { 0..0 } else { start + parsed.comment.start - 1..start + length }
}

/// What becomes of a line outside and within a print; `allow` are the commands that the profile lets pass.
pub(super) fn policies(effect: Effect, parsed: &ParsedLine, allow: &[String]) -> [CommandPolicy; 2] {
    let allowed = allows(parsed, allow);
    [Stage::Outside, Stage::Within].map(|stage| policy(effect, stage, allowed))
}

/// Whether the profile lets the command of a line pass, by its name.
pub(super) fn allows(parsed: &ParsedLine, allow: &[String]) -> bool {
    !allow.is_empty() && {
        let name = command_name(parsed);
        allow.iter().any(|a| a.eq_ignore_ascii_case(&name))
    }
}

/// The command that a line begins with, by its name: `M42`, `SET_PIN`.
pub(super) fn command_name(parsed: &ParsedLine) -> String {
    match parsed.commands.first() {
        Some(command) => command.to_string(),
        None => String::from_utf8_lossy(&parsed.text).split([' ', '=']).next().unwrap_or_default().to_owned(),
    }
}

/// The refusal of a line by its text.
pub(super) fn refused(source: &SlicedSource<'_>, line: u32, span: Range<usize>) -> SlicedError {
    let text = String::from_utf8_lossy(source.bytes.get(span).unwrap_or_default()).trim().chars().take(60).collect();
    SlicedError::Command { file: source.file.to_owned(), line, text }
}
