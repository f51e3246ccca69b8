//! The file's own text beside its moves: a line that is nothing but its move is not kept, since it can be written anew.
//!
//! Whether it can, to the letter, is tried here for every line; what differs in anything (comments, marks, commands, spaces,
//! another order of words) is kept as it is.
//!
//! ```text
//! G1 [Xmm] [Ymm] [Zmm] [Emm] [Fmm/min]     X, Y, Z where they change (3 decimals), E where it is not 0 (5), F where it is new (3)
//! runs: so many lines written anew, so many kept, so many anew, ..; kept: lines, each with a newline behind it
//! ```

use super::pack::Column;
use crate::gcode::{lines, push_units};
use crate::trace::Trace;

/// What a move's line is written from.
pub(super) struct Written {
    /// Where it ends, micrometres.
    pub(super) to: [i64; 3],
    /// Where it begins.
    pub(super) from: [i64; 3],
    /// Filament, hundred-thousandths of a millimetre.
    pub(super) e: i64,
    /// Feed where it is another than before, micrometres a minute.
    pub(super) feed: Option<i64>,
}

/// A file's lines but those that can be written anew.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Text {
    /// How many can.
    pub(super) rebuilt: u32,
    pub(super) runs: Column,
    pub(super) kept: Column,
}

impl Text {
    /// The lines of `bytes`; `written` says what the line of a move is written from.
    pub(super) fn of(bytes: &[u8], trace: &Trace, extruder: char, written: impl Fn(usize) -> Written) -> Self {
        let mut text = Self::default();
        let (mut next, mut run, mut anew) = (0, 0u64, true);
        let mut spelt = Vec::new();
        let mut of_move = trace.moves().map(|m| m.line).peekable();
        for line in lines(bytes) {
            let mut count = 0;
            while of_move.next_if(|at| *at == line.number).is_some() {
                count += 1;
            }
            spelt.clear();
            if count == 1 {
                spell(&written(next), extruder, &mut spelt);
            }
            next += count;
            let same = count == 1 && spelt == line.bytes;
            if same != anew {
                text.runs.unsigned(run);
                (run, anew) = (0, same);
            }
            run += 1;
            if same {
                text.rebuilt += 1;
            } else {
                text.kept.0.extend_from_slice(line.bytes);
                text.kept.0.push(b'\n');
            }
        }
        text.runs.unsigned(run);
        text
    }
}

fn spell(of: &Written, extruder: char, out: &mut Vec<u8>) {
    out.extend_from_slice(b"G1");
    let mut word = |letter: u8, units: i64, decimals: u32| {
        out.extend_from_slice(&[b' ', letter]);
        push_units(out, units, decimals);
    };
    for (axis, letter) in [b'X', b'Y', b'Z'].into_iter().enumerate() {
        if of.to[axis] != of.from[axis] {
            word(letter, of.to[axis], 3);
        }
    }
    if of.e != 0 {
        word(extruder as u8, of.e, 5);
    }
    if let Some(feed) = of.feed {
        word(b'F', feed, 3);
    }
}
