//! A program's blocks once more: what each does to the machine, for whoever asks behind its reading.

use super::Program;
use crate::gcode::ParsedLine;
use crate::motion::replay::ReplayError;
use crate::trace::{Action, Interpreter, TraceSetting};

/// A program's blocks one after the other, through the interpreter that has timed them.
pub(in crate::link) struct Replay<'a> {
    program: &'a Program,
    interpreter: Interpreter,
    line: ParsedLine,
    next: u32,
}

impl<'a> Replay<'a> {
    pub(in crate::link) fn new(program: &'a Program, setting: &TraceSetting) -> Self {
        Self { program, interpreter: Interpreter::new(setting), line: ParsedLine::default(), next: 0 }
    }

    /// The next block: its index, its words, and what it does; `None` behind the last. Behind one that cannot be followed the
    /// position is unspecified.
    pub(in crate::link) fn step(&mut self) -> Option<(u32, &ParsedLine, Result<Action, ReplayError>)> {
        let block = self.next;
        if block >= self.program.len() {
            return None;
        }
        self.next += 1;
        // A block was parsed when its program was read; without its comment and its blanks it says the same.
        let action = match self.line.read(self.program.block(block)) {
            Ok(()) => self.interpreter.take(&self.line),
            Err(_) => Ok(Action::Nothing),
        };
        Some((block, &self.line, action))
    }

    /// The block that comes next.
    pub(in crate::link) fn at(&self) -> u32 {
        self.next
    }

    /// The machine behind the last block.
    pub(in crate::link) fn machine(&self) -> &Interpreter {
        &self.interpreter
    }
}
