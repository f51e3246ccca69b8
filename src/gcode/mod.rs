//! G-code as text: lines to words and back, on bytes. Text knows no machine.
//!
//! Grammar: what PrusaSlicer, Slic3r, Cura, Orca and hand-written start code really contain: `N` numbers with
//! `*checksum`, `;` and `( )` comments, words without blanks between them (`g1x-3.9y2f7800`), `.25`, `-.5`, `+1`, CR LF,
//! a byte-order mark, latin-1 bytes, Klipper macros, commands that carry free text (`M117`). An exponent is *not* part
//! of a number: in `X1E5` the `E` is a word.
//!
//! Lines taken apart, and what one of them does:
//!
//! ```
//! use trunnion::gcode::meaning::{Effect, Firmware, Heater, effect};
//! use trunnion::gcode::{Command, ParsedLine, lines};
//!
//! let file = b"M109 S210 ; wait for the nozzle\r\ng1x-3.9y2 f7800\n";
//! let (mut line, mut commands) = (ParsedLine::default(), Vec::new());
//! for numbered in lines(file) {
//!     line.read(numbered.bytes)?;
//!     commands.extend(line.commands.iter().copied());
//! }
//! assert_eq!(commands, [Command::m(109), Command::g(1)]);
//! // The last line's X is in hand: -3.9, in whatever unit the modal state says.
//! assert_eq!(line.value(b'X'), Some(-3.9));
//!
//! // What a line does is a matter of the firmware: Marlin stands here until the nozzle has 210 degrees.
//! line.read(b"M109 S210")?;
//! assert_eq!(
//!     effect(Firmware::Marlin, &line),
//!     Effect::Heat { heater: Heater::Nozzle, target_c: Some(210.0), waits: true }
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
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
