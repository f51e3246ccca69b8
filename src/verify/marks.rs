//! The comments that verification reads: our own marks, and what slicers say of the line that follows.

/// A comment with a meaning.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Mark {
    /// `TRUNNION expect print=2 part=3 filament_mm=123.4`
    Expect { print: usize, part: usize, filament_mm: f64 },
    /// `TRUNNION slot=2 part=3,5 A=70 C=90`
    Slot(usize),
    /// `TRUNNION print=2 part=3`
    Print { print: usize, part: usize },
    /// `TRUNNION end`
    End,
    /// `TYPE:External perimeter`
    Role(Role),
    /// `WIDTH:0.45`
    Width(f64),
    /// `HEIGHT:0.2`
    Height(f64),
    /// One of ours that says nothing to check.
    Other,
    /// One of ours that cannot be read.
    Broken,
}

/// What a line is for, as far as it decides how far it may span.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Role {
    /// Walls and everything unnamed.
    #[default]
    Wall,
    /// Infill and skins, which cross the cells of the infill below.
    Infill,
    /// Bridges and overhangs, which the slicer has chosen to lay across a gap.
    Bridge,
}

/// The meaning of a comment, its `;` left out; `None` for the many that have none here.
pub(super) fn read(comment: &[u8]) -> Option<Mark> {
    if let Some(rest) = comment.strip_prefix(b"TRUNNION") {
        return Some(own(&String::from_utf8_lossy(rest)));
    }
    let text = || std::str::from_utf8(comment).ok();
    match comment.first()? {
        b'T' => text()?.strip_prefix("TYPE:").map(|name| Mark::Role(role(name))),
        b'W' => text()?.strip_prefix("WIDTH:")?.trim().parse().ok().map(Mark::Width),
        b'H' => text()?.strip_prefix("HEIGHT:")?.trim().parse().ok().map(Mark::Height),
        _ => None,
    }
}

fn own(text: &str) -> Mark {
    let value = |key: &str| text.split_ascii_whitespace().find_map(|w| w.strip_prefix(key)?.strip_prefix('='));
    let number = |key: &str| value(key).and_then(|v| v.parse::<usize>().ok());
    let first = text.split_ascii_whitespace().next().unwrap_or_default();
    if first == "end" {
        return Mark::End;
    }
    if first == "expect" {
        let filament = value("filament_mm").and_then(|v| v.parse::<f64>().ok()).filter(|mm| mm.is_finite());
        return match (number("print"), number("part"), filament) {
            (Some(print), Some(part), Some(filament_mm)) => Mark::Expect { print, part, filament_mm },
            _ => Mark::Broken,
        };
    }
    if first.starts_with("slot=") {
        return number("slot").map_or(Mark::Broken, Mark::Slot);
    }
    if first.starts_with("print=") {
        return match (number("print"), number("part")) {
            (Some(print), Some(part)) => Mark::Print { print, part },
            _ => Mark::Broken,
        };
    }
    Mark::Other
}

fn role(name: &str) -> Role {
    let name = name.to_ascii_lowercase();
    let has = |part: &str| name.contains(part);
    if has("bridge") || has("overhang") {
        Role::Bridge
    } else if has("fill") || has("sparse") || has("skin") || has("surface") {
        Role::Infill
    } else {
        Role::Wall
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_our_marks_and_the_slicers() {
        let expect = Mark::Expect { print: 2, part: 3, filament_mm: 1.5 };
        assert_eq!(read(b"TRUNNION expect print=2 part=3 filament_mm=1.5"), Some(expect));
        assert_eq!(read(b"TRUNNION slot=2 part=3,5 A=70 C=90"), Some(Mark::Slot(2)));
        assert_eq!(read(b"TRUNNION print=1 part=4"), Some(Mark::Print { print: 1, part: 4 }));
        assert_eq!(read(b"TRUNNION print=x part=4"), Some(Mark::Broken));
        assert_eq!(read(b"TRUNNION end"), Some(Mark::End));
        assert_eq!(read(b"TYPE:Overhang perimeter"), Some(Mark::Role(Role::Bridge)));
        assert_eq!(read(b"TYPE:WALL-OUTER"), Some(Mark::Role(Role::Wall)));
        assert_eq!(read(b"TYPE:SKIN"), Some(Mark::Role(Role::Infill)));
        assert_eq!(read(b"WIDTH:0.45"), Some(Mark::Width(0.45)));
        assert_eq!(read(b"LAYER:3"), None);
    }
}
