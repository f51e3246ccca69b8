//! Words of messages: the known name that somebody may have meant (Levenshtein 1966), for every refusal of an unknown one, numbers of
//! things, and lists of numbers.
//!
//! The known name that is nearest, a number of things, and a list of numbers:
//!
//! ```
//! use trunnion::spelling::{counted, nearest, numbers};
//!
//! // One letter is missing.
//! assert_eq!(nearest("hight", ["height", "width"]), Some((1, "height")));
//! assert_eq!(counted(3, "touch"), "3 touches");
//! assert_eq!(numbers("0, 0, 1"), Some([0.0, 0.0, 1.0]));
//! ```

/// As few letters say by themselves how a name begins.
const BEGINNING: usize = 3;

/// The one of `known` nearest to `wanted` and by how many edits (Levenshtein: letters put in, left out or changed), the first
/// of those as near; `None` for no names. A name's beginning is one edit away from it, however much is left out: prusa for prusa-slicer.
pub fn nearest<'a>(wanted: &str, known: impl IntoIterator<Item = &'a str>) -> Option<(usize, &'a str)> {
    let begins = |name: &str| wanted.chars().count() >= BEGINNING && name.starts_with(wanted);
    let far = |name: &str| if begins(name) && name != wanted { 1 } else { edits(wanted, name) };
    known.into_iter().map(|name| (far(name), name)).min_by_key(|(edits, _)| *edits)
}

/// Numbers with commas between them, as `12.5,-30`; `None` unless there are just `N`, all finite.
pub fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let all: Option<Vec<f64>> =
        text.split(',').map(|word| word.trim().parse().ok().filter(|value: &f64| value.is_finite())).collect();
    all?.try_into().ok()
}

/// "1 part", "2 parts", "2 touches".
pub fn counted(count: usize, noun: &str) -> String {
    let ending = match count {
        1 => "",
        _ if noun.ends_with("ch") => "es",
        _ => "s",
    };
    format!("{count} {noun}{ending}")
}

/// "part 3 (arm)"; "part 3" alone where the file names none, and it is called by its number.
pub fn part_named(part: usize, name: &str) -> String {
    if name == unnamed(part) { format!("part {part}") } else { format!("part {part} ({name})") }
}

/// What a part is called to which its file gives no name.
pub fn unnamed(part: usize) -> String {
    format!("part-{part}")
}

fn edits(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, one) in a.chars().enumerate() {
        let mut corner = std::mem::replace(&mut row[0], i + 1);
        for (j, other) in b.chars().enumerate() {
            let changed = corner + usize::from(one != other);
            corner = row[j + 1];
            row[j + 1] = changed.min(corner + 1).min(row[j] + 1);
        }
    }
    row.last().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn so_many_numbers_or_none() {
        assert_eq!(numbers(" 12.5, -30"), Some([12.5, -30.0]));
        assert_eq!(["1", "1,2,3", "1,", "1,x", "1,inf", ""].map(numbers::<2>), [None; 6]);
    }

    #[test]
    fn parts_have_a_name_of_their_own_or_none() {
        let named = |name| part_named(3, name);
        assert_eq!([named("arm"), named("part-3"), named("part-4")], ["part 3 (arm)", "part 3", "part 3 (part-4)"]);
    }

    #[test]
    fn one_thing_and_several() {
        assert_eq!([0, 1, 2].map(|n| counted(n, "part")), ["0 parts", "1 part", "2 parts"]);
    }

    #[test]
    fn the_fewest_edits_win_and_the_first_of_two() {
        assert_eq!(nearest("staircas", ["height", "staircase"]), Some((1, "staircase")));
        assert_eq!(nearest("kitten", ["sitting", "mitten"]), Some((1, "mitten")));
        assert_eq!(nearest("ab", ["ac", "ad"]), Some((1, "ac")));
        assert_eq!(nearest("höhe", ["hohe", ""]), Some((1, "hohe")), "letters, not bytes");
        assert_eq!((nearest("", ["abc"]), nearest("x", [])), (Some((3, "abc")), None));
    }

    #[test]
    fn a_beginning_is_nearer_than_what_is_short_by_chance() {
        assert_eq!(nearest("prusa", ["cura", "prusa-slicer"]), Some((1, "prusa-slicer")));
        assert_eq!(nearest("cura", ["cura-engine", "cura"]), Some((0, "cura")));
        assert_eq!(nearest("pr", ["cr", "prusa-slicer"]), Some((1, "cr")), "two letters are none");
    }

    #[test]
    fn edits_of_the_textbook() {
        assert_eq!([edits("kitten", "sitting"), edits("", "abc"), edits("abc", ""), edits("a", "a")], [3, 3, 3, 0]);
    }
}
