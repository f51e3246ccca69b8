//! Where in what the user gave something is wrong, the same for every room: a file, a line of it, and what in that line.
//!
//! The place of a value that no machine can have, and its line:
//!
//! ```
//! use trunnion::location::Location;
//! use trunnion::profile::resolve;
//!
//! let own = "extends = \"generic-ac\"\n[kinematics.tilt]\nmin_deg = -900\n";
//! let refused = resolve("mine.toml", own).err().and_then(|error| error.location());
//! let place = refused.ok_or("nothing is wrong")?;
//! assert_eq!(place, Location::file("mine.toml").line(3_u64).word("-900"));
//! assert_eq!(place.excerpt(own).ok_or("no such line")?, "3 | min_deg = -900\n  |           ^^^^");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::path::Path;

/// Where something is wrong. What is not known is `None`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Location {
    /// The file, as it was given.
    pub file: Option<String>,
    /// Its line, from 1.
    pub line: Option<u64>,
    /// The character of the line, from 1.
    pub column: Option<usize>,
    /// The word of the line that is at fault.
    pub word: Option<String>,
    /// The part, from 0.
    pub part: Option<usize>,
}

impl Location {
    /// A file as a whole.
    pub fn file(name: impl Into<String>) -> Self {
        Self { file: Some(name.into()), ..Self::default() }
    }

    /// A file as a whole.
    pub fn path(path: &Path) -> Self {
        Self::file(path.display().to_string())
    }

    /// `FILE:LINE`, or `FILE` alone.
    pub fn parse(place: &str) -> Self {
        match place.rsplit_once(':').and_then(|(file, line)| Some((file, line.parse::<u64>().ok()?))) {
            Some((file, line)) => Self::file(file).line(line),
            None => Self::file(place),
        }
    }

    /// In that line, from 1.
    #[must_use]
    pub fn line(self, line: impl Into<u64>) -> Self {
        Self { line: Some(line.into()), ..self }
    }

    /// At that character of the line, from 1.
    #[must_use]
    pub fn column(self, column: usize) -> Self {
        Self { column: Some(column), ..self }
    }

    /// At that word of the line.
    #[must_use]
    pub fn word(self, word: impl Into<String>) -> Self {
        Self { word: Some(word.into()), ..self }
    }

    /// In that part, from 0.
    #[must_use]
    pub fn part(self, part: usize) -> Self {
        Self { part: Some(part), ..self }
    }

    /// The line of `text`, the file's, with what is at fault underlined; two lines. `None` where the line is not known, or is not there.
    /// Of a value of many lines the line is its first: then the one behind it that has the word is shown.
    pub fn excerpt(&self, text: &str) -> Option<String> {
        let stated = usize::try_from(self.line?).ok()?;
        let mut lines = text.lines().enumerate().skip(stated.checked_sub(1)?);
        let has_word =
            |(_, line): &(usize, &str)| self.word.as_ref().is_some_and(|word| place_of(word, line).is_some());
        let first = lines.next()?;
        let quotes = QUOTES.into_iter().find(|quotes| first.1.matches(quotes).count() == 1);
        let within = quotes.and_then(|quotes| lines.take_while(|(_, line)| !line.contains(quotes)).find(has_word));
        let (index, line) = within.filter(|_| !has_word(&first)).unwrap_or(first);
        let number = index + 1;
        let characters: Vec<char> = line.chars().collect();
        let (from, count) = self.marked(line)?;
        // Of a long line what is around the mark.
        let first = from.saturating_sub(BEFORE).min(characters.len().saturating_sub(SHOWN));
        let shown: String = characters.iter().skip(first).take(SHOWN).collect();
        let blank = |c: &char| if *c == '\t' { '\t' } else { ' ' };
        let before: String = characters[first..from].iter().map(blank).collect();
        let marks = "^".repeat(count.min(first + SHOWN - from));
        let margin = " ".repeat(number.to_string().len());
        Some(format!("{number} | {shown}\n{margin} | {before}{marks}"))
    }

    /// The first character that is at fault, from 0, and how many are: the word, what begins at the column, or the line without its
    /// blanks.
    fn marked(&self, line: &str) -> Option<(usize, usize)> {
        let at = |byte: usize| line[..byte].chars().count();
        if let Some((word, byte)) = self.word.as_ref().and_then(|word| Some((word, place_of(word, line)?))) {
            return Some((at(byte), word.chars().count()));
        }
        let length = line.chars().count();
        if let Some(column) = self.column.map(|column| column.saturating_sub(1)).filter(|&column| column < length) {
            let rest = line.chars().skip(column);
            return Some((column, rest.take_while(|c| c.is_alphanumeric() || "._-+\"".contains(*c)).count().max(1)));
        }
        let inner = line.trim();
        (!inner.is_empty()).then(|| (at(line.len() - line.trim_start().len()), inner.chars().count()))
    }
}

/// Where `line` has `word`, and not only as a part of a longer one, in bytes.
fn place_of(word: &str, line: &str) -> Option<usize> {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let is_part = |edge: Option<char>, beside: Option<char>| edge.is_some_and(part) && beside.is_some_and(part);
    let stands = |at: usize| {
        let (before, after) = (line[..at].chars().next_back(), line[at + word.len()..].chars().next());
        !is_part(word.chars().next(), before) && !is_part(word.chars().next_back(), after)
    };
    line.match_indices(word).map(|(at, _)| at).find(|&at| !word.is_empty() && stands(at))
}

/// What opens and closes a value of many lines in TOML.
const QUOTES: [&str; 2] = ["\"\"\"", "'''"];
/// Of a long line so many characters are shown, so many of them before the mark.
const SHOWN: usize = 100;
const BEFORE: usize = 40;

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "one\n\tkey = \"värde\" # of it\n\nlast";

    #[test]
    fn the_word_is_marked_behind_tabs_and_letters_of_two_bytes() {
        let location = Location::file("f").line(2_u64);
        assert_eq!(
            location.clone().word("# of").excerpt(TEXT).unwrap(),
            "2 | \tkey = \"värde\" # of it\n  | \t              ^^^^"
        );
        assert_eq!(location.clone().column(2).excerpt(TEXT).unwrap(), "2 | \tkey = \"värde\" # of it\n  | \t^^^");
        assert_eq!(location.clone().excerpt(TEXT).unwrap().lines().nth(1), Some("  | \t^^^^^^^^^^^^^^^^^^^^^"));
        // A word that is not there, and a column behind the end: the line.
        assert_eq!(location.clone().word("gone").column(99).excerpt(TEXT), location.excerpt(TEXT));
    }

    #[test]
    fn a_word_is_looked_for_further_down_within_its_own_value_alone() {
        let text = "start = \"\"\"\nG28\nG29 ; G2\n\"\"\"\nlayer2 = 2\nafter = \"G30\"";
        let at = |line: u64, word: &str| Location::file("f").line(line).word(word).excerpt(text).unwrap();
        assert_eq!(at(1, "G29"), "3 | G29 ; G2\n  | ^^^");
        assert_eq!(at(1, "G2"), "3 | G29 ; G2\n  |       ^^");
        // Behind the value is another.
        assert!(at(1, "G30").starts_with("1 | start"));
        assert!(at(5, "G30").starts_with("5 | layer2"));
        assert_eq!(at(5, "2"), "5 | layer2 = 2\n  |          ^");
    }

    #[test]
    fn lines_that_are_not_there_or_blank_have_no_excerpt() {
        for line in [0, 3, 5, u64::MAX] {
            assert_eq!(Location::file("f").line(line).excerpt(TEXT), None, "{line}");
        }
        assert_eq!(Location::file("f").excerpt(TEXT), None);
        assert_eq!(Location::file("f").line(4_u64).excerpt(TEXT).unwrap(), "4 | last\n  | ^^^^");
    }

    #[test]
    fn of_a_long_line_what_is_around_the_mark_is_shown() {
        let text = format!("{} X {}", "a".repeat(500), "b".repeat(500));
        let excerpt = Location::file("f").line(1_u64).word("X").excerpt(&text).unwrap();
        let lines: Vec<&str> = excerpt.lines().collect();
        assert_eq!(lines[0].find('X'), lines[1].find('^'));
        assert!(lines.iter().all(|line| line.len() <= 4 + SHOWN), "{excerpt}");
        let whole = Location::file("f").line(1_u64).excerpt(&text).unwrap();
        assert!(whole.lines().all(|line| line.len() <= 4 + SHOWN), "{whole}");
    }

    #[test]
    fn a_place_is_a_file_and_a_line_where_it_ends_in_one() {
        assert_eq!(Location::parse("a/b.toml:12"), Location::file("a/b.toml").line(12_u64));
        assert_eq!(Location::parse("C:b.toml"), Location::file("C:b.toml"));
        assert_eq!(Location::parse("profile x"), Location::file("profile x"));
    }
}
