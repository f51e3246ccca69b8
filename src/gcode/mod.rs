//! G-code as text: lines to words and back, on bytes. Text knows no machine.
//!
//! Grammar: what PrusaSlicer, Slic3r, Cura, Orca and hand-written start code really contain: `N` numbers with
//! `*checksum`, `;` and `( )` comments, words without blanks between them (`g1x-3.9y2f7800`), `.25`, `-.5`, `+1`, CR LF,
//! a byte-order mark, latin-1 bytes, Klipper macros, commands that carry free text (`M117`). An exponent is *not* part
//! of a number: in `X1E5` the `E` is a word.
//!
//! This room must not know frames, poses, modal state or units: that is `motion`'s.

pub mod checksum;
mod lines;
pub mod marks;
pub mod meaning;
mod number;
mod parse;
mod plain;
mod readers;
pub mod settings;

pub use lines::{NumberedLine, first_line, lines, text_start};
pub use number::{push_fixed, push_units, round_to, units_of};
pub use parse::{Command, LineKind, ParseError, ParsedLine, Word};
pub use plain::PlainMove;
pub use readers::{LineRules, Misreading};
