//! What becomes of each line of sliced input that is not a move: kept, dropped, or refused.
//!
//! Decided from what the line does (`gcode::meaning`) and where it stands; no command is named here.

use crate::gcode::meaning::{Effect, Hazard};
use crate::gcode::{LineKind, ParsedLine};

/// What to do with a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CommandPolicy {
    /// Passed on.
    Keep,
    /// Left out without a word: it says what is so anyway, or what will no longer be true.
    Drop,
    /// Left out of the slicer's start or end code, which the profile's own replaces; the user is told.
    Replace,
    /// Nobody knows what it would do at a tilt.
    Refuse,
    /// Made clear of everything that stands, filament pulled back: a person is waited for, and the head may be driven away.
    Pause,
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
const FALSE_COMMENTS: [&[u8]; 14] = [
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
    // Of one print: the sum over all is written at the end.
    b" filament used",
    b" total filament",
    b" total layer",
    b"Filament used:",
];

/// Where a picture begins (`true`) or ends in comments: `; thumbnail begin 32x32 1234`, `; thumbnail_QOI end`. It is of the print as it stood
/// in the slicer's window, upright and alone.
pub(super) fn picture(comment: &[u8]) -> Option<bool> {
    let mut words = comment.split(|b| *b == b' ').filter(|word| !word.is_empty());
    let is_picture = words.next().is_some_and(|word| word == b"thumbnail" || word.starts_with(b"thumbnail_"));
    match words.next().filter(|_| is_picture)? {
        b"begin" => Some(true),
        b"end" => Some(false),
        _ => None,
    }
}

/// Whether a comment may be passed on: neither one of our marks, which carry meaning, nor one that would be false.
pub(super) fn keeps_comment(comment: &[u8]) -> bool {
    crate::gcode::marks::mark(comment).is_none() && !FALSE_COMMENTS.iter().any(|c| comment.starts_with(c))
}

/// Macros of Moonraker's time-lapse that slicers write: with parking they drive the head away.
const PICTURES: [&str; 4] = ["TIMELAPSE_TAKE_FRAME", "_TIMELAPSE_NEW_FRAME", "HYPERLAPSE", "TIMELAPSE_RENDER"];

/// Whether a line has a picture taken for a film of the print, or ends the film.
pub(super) fn takes_a_picture(parsed: &ParsedLine) -> bool {
    let name = parsed.text.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    parsed.kind == LineKind::Macro && PICTURES.iter().any(|macro_name| name.eq_ignore_ascii_case(macro_name.as_bytes()))
}

/// What becomes of a line with this effect; `allowed` where the profile names its command in `[dialect] allow`.
pub(super) fn policy(effect: Effect, stage: Stage, allowed: bool) -> CommandPolicy {
    use CommandPolicy::{Drop, Keep, Pause, Refuse, Replace};
    let within = stage == Stage::Within;
    match effect {
        Effect::Hazard(_) | Effect::Factor { .. } if allowed && within => Keep,
        // Waits that are long enough for plastic never come here: `items` has them made beside the part.
        Effect::Nothing | Effect::Motion | Effect::Dwell(_) | Effect::Progress => Drop,
        Effect::Factor { percent: Some(100.0), .. } => Drop,
        Effect::Fan { .. } | Effect::Setting | Effect::Retract(_) => Keep,
        // Whoever cancels an object by its label would have all that stands on it printed on air.
        Effect::Label => Drop,
        Effect::Report | Effect::Drain | Effect::HeatWait | Effect::Heat { .. } => {
            // Heaters of the start are the profile's to set (with the values found here); off at the end.
            if within { Keep } else { Drop }
        }
        Effect::Hazard(Hazard::Person) if within => Pause,
        Effect::Hazard(Hazard::Tool) => Refuse,
        Effect::Home | Effect::HeatersOff => {
            if within {
                Refuse
            } else {
                Drop
            }
        }
        // Motors off and files' ends stand at every end.
        Effect::Hazard(Hazard::MotorsOff | Hazard::End) if !within => Drop,
        Effect::Factor { .. } | Effect::Hazard(_) => {
            if within {
                Refuse
            } else {
                Replace
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_unseen_is_refused_only_where_it_matters() {
        let motors = Effect::Hazard(Hazard::MotorsOff);
        assert_eq!(policy(motors, Stage::Outside, false), CommandPolicy::Drop);
        assert_eq!(policy(motors, Stage::Within, false), CommandPolicy::Refuse);
        assert_eq!(policy(motors, Stage::Within, true), CommandPolicy::Keep);
        assert_eq!(policy(Effect::Hazard(Hazard::Shift), Stage::Outside, false), CommandPolicy::Replace);
        assert_eq!(policy(Effect::Hazard(Hazard::Tool), Stage::Outside, true), CommandPolicy::Refuse);
        assert_eq!(policy(Effect::Hazard(Hazard::Person), Stage::Within, false), CommandPolicy::Pause);
        assert_eq!(policy(Effect::Hazard(Hazard::Person), Stage::Outside, false), CommandPolicy::Replace);
        assert_eq!(policy(Effect::Fan { index: 0, share: 1.0 }, Stage::Within, false), CommandPolicy::Keep);
        let flow = |percent| Effect::Factor { speed: false, percent };
        assert_eq!(policy(flow(Some(100.0)), Stage::Within, false), CommandPolicy::Drop);
        assert_eq!(policy(flow(Some(95.0)), Stage::Within, false), CommandPolicy::Refuse);
        assert_eq!(policy(flow(None), Stage::Outside, false), CommandPolicy::Replace);
    }

    #[test]
    fn comments_that_would_lie_are_dropped() {
        assert!(!keeps_comment(b"TIME:6666") && !keeps_comment(b"TRUNNION slot=3"));
        assert!(keeps_comment(b"TYPE:External perimeter"));
        assert_eq!(picture(b" thumbnail begin 32x32 1234"), Some(true));
        assert_eq!((picture(b" thumbnail_QOI begin 9x9 1"), picture(b" thumbnail end")), (Some(true), Some(false)));
        assert_eq!((picture(b" thumbnails = 9x9"), picture(b" the beginning"), picture(b"")), (None, None, None));
    }
}
