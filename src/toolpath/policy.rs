//! What becomes of each line of sliced input that is not a move: kept, dropped, or refused.

use crate::gcode::{Command, LineKind, ParsedLine};

/// What to do with a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    /// Passed on as it stands.
    Keep,
    /// Left out: the profile's start and end code, or the rewriter, does it.
    Drop,
    /// Nobody knows what it would do at a tilt.
    Refuse,
}

/// Where in a print a line stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Before the first extrusion or after the last.
    Outside,
    /// Between extrusions.
    Within,
}

/// Comments that would be false after rewriting.
const FALSE_COMMENTS: [&[u8]; 10] = [
    b" estimated printing time",
    b" estimated first layer printing time",
    b"TIME:",
    b"TIME_ELAPSED:",
    b"LAYER_COUNT:",
    b"MINX:",
    b"MINY:",
    b"MAXX:",
    b" objects_info",
    b" max_layer_z",
];

/// Comments whose keyword must not be parroted since our own marks carry it.
const OWN_MARK: &[u8] = b"TRUNNION";

pub(super) fn fate_of_comment(comment: &[u8]) -> Fate {
    let drop = comment.starts_with(OWN_MARK) || FALSE_COMMENTS.iter().any(|c| comment.starts_with(c));
    if drop { Fate::Drop } else { Fate::Keep }
}

/// M-codes that change no position and mean the same at every pose.
const HARMLESS: [u32; 25] = [
    104, 105, 106, 107, 109, 117, 118, 140, 141, 155, 190, 201, 203, 204, 205, 207, 208, 220, 221, 400, 486, 572, 593,
    595, 900,
];
/// M-codes of start and end code, superseded by the profile's.
const SUPERSEDED: [u32; 13] = [2, 17, 18, 30, 73, 75, 77, 82, 83, 84, 115, 420, 862];

pub(super) fn fate_of_command(command: Command, stage: Stage) -> Fate {
    let outside = stage != Stage::Within;
    match (command.letter, command.number) {
        (b'T', 0) | (b'G', 4 | 17 | 21 | 90 | 91 | 94) => Fate::Drop,
        (b'G', 10) => Fate::Keep,
        (b'G', 29) if outside => Fate::Drop,
        // Heaters of the start are the profile's to set (with the values found here); off at the end.
        (b'M', 104 | 109 | 140 | 190) if outside => Fate::Drop,
        (b'M', number) if HARMLESS.contains(&number) => Fate::Keep,
        (b'M', number) if SUPERSEDED.contains(&number) => {
            if outside || matches!(number, 73 | 82 | 83) {
                Fate::Drop
            } else {
                Fate::Refuse
            }
        }
        _ => Fate::Refuse,
    }
}

/// Macros that label or report and move nothing.
const HARMLESS_MACROS: [&str; 8] = [
    "EXCLUDE_OBJECT_START",
    "EXCLUDE_OBJECT_END",
    "SET_PRINT_STATS_INFO",
    "SET_PRESSURE_ADVANCE",
    "SET_VELOCITY_LIMIT",
    "M117",
    "RESPOND",
    "TIMELAPSE_TAKE_FRAME",
];

pub(super) fn fate_of_text(code: &[u8], line: &ParsedLine, stage: Stage) -> Fate {
    if line.kind == LineKind::Text {
        return line.commands.first().map_or(Fate::Refuse, |c| match c.number {
            555 => Fate::Drop,
            117 | 118 | 486 => Fate::Keep,
            _ => Fate::Refuse,
        });
    }
    let text = String::from_utf8_lossy(code).to_ascii_uppercase();
    let name = text.split([' ', '=']).next().unwrap_or_default();
    // Where objects lay on the slicer's plate is no longer true.
    if name == "EXCLUDE_OBJECT_DEFINE" {
        return Fate::Drop;
    }
    match (HARMLESS_MACROS.contains(&name), stage) {
        (true, _) => Fate::Keep,
        // START_PRINT and END_PRINT are what the profile's own start and end code stand for.
        (false, Stage::Outside) => Fate::Drop,
        (false, Stage::Within) => Fate::Refuse,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_unseen_is_refused_only_where_it_matters() {
        assert_eq!(fate_of_command(Command::m(600), Stage::Within), Fate::Refuse);
        assert_eq!(fate_of_command(Command::m(84), Stage::Outside), Fate::Drop);
        assert_eq!(fate_of_command(Command::m(84), Stage::Within), Fate::Refuse);
        assert_eq!(fate_of_command(Command::m(106), Stage::Within), Fate::Keep);
        assert_eq!(fate_of_command(Command { letter: b'T', number: 1, minor: 0 }, Stage::Within), Fate::Refuse);
    }

    #[test]
    fn comments_that_would_lie_are_dropped() {
        assert_eq!(fate_of_comment(b"TIME:6666"), Fate::Drop);
        assert_eq!(fate_of_comment(b"TRUNNION slot=3"), Fate::Drop);
        assert_eq!(fate_of_comment(b"TYPE:External perimeter"), Fate::Keep);
    }
}
