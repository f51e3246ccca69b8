//! Lines of a terminal that are written over, for one print and for several that share it.
//!
//! Names and texts are strangers' (ports, printers, files): they come here as [`visible`] has them.
//!
//! No line is as long as the terminal is wide: one that the terminal breaks moves all others.

use super::visible;

/// Behind a line that somebody has typed: back to where it began, so that the status stays in one place.
pub const TYPED: &str = "\x1b[1A\r\x1b[K";

/// That a terminal has too few lines for one of each of `of` prints.
pub fn too_low(lines: usize, of: usize) -> String {
    format!("terminal too short ({lines} lines) to show progress for {of} prints; events are still printed")
}

/// As many of `text`'s words, between commas, as a terminal of `columns` takes in one line.
pub fn fitting(text: &str, columns: usize) -> String {
    let most = columns.saturating_sub(1);
    let (mut kept, text) = (String::new(), visible(text));
    for word in text.split(", ") {
        let more = if kept.is_empty() { word.to_owned() } else { format!("{kept}, {word}") };
        if more.chars().count() > most {
            break;
        }
        kept = more;
    }
    if kept.is_empty() { text.chars().take(most).collect() } else { kept }
}

/// `text` in lines of `columns`, broken between words where that can be; all but the first are indented.
fn broken(text: &str, columns: usize) -> Vec<String> {
    let most = columns.saturating_sub(1).max(8);
    let (mut lines, mut line) = (Vec::new(), String::new());
    for word in text.split(' ') {
        let mut word = word.to_owned();
        while line.chars().count() + 1 + word.chars().count() > most {
            if line.trim().is_empty() {
                let cut: String = word.chars().take(most - 2).collect();
                word = word.chars().skip(most - 2).collect();
                line += if line.is_empty() { "" } else { " " };
                line += &cut;
            }
            lines.push(std::mem::replace(&mut line, " ".to_owned()));
        }
        line += if line.is_empty() { "" } else { " " };
        line += &word;
    }
    lines.push(line);
    lines
}

/// Inserts `text` above the last `rows` lines in front of the cursor, which keeps its place behind what is being typed.
pub fn above(text: &str, rows: usize, columns: usize) -> String {
    let up = rows + 1;
    let pieces = broken(&visible(text), columns).into_iter();
    pieces.map(|piece| format!("\x1bD\x1b7\x1b[{up}A\r\x1b[L{piece}\x1b8")).collect()
}

/// One of several things that share a terminal: its name, and which of the `of` lines in front of the cursor is its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// What its lines begin with: a number, a blank, a port.
    pub name: String,
    /// From 0.
    pub row: usize,
    /// All of them.
    pub of: usize,
    /// Whether these lines are there.
    pub drawn: bool,
}

impl Row {
    /// Its name in a third of a line; of a long one its end, in which ports differ.
    fn label(&self, columns: usize) -> String {
        let (length, most) = (self.name.chars().count(), (columns / 3).max(8));
        if length <= most {
            return self.name.clone();
        }
        let (number, port) = self.name.split_once(' ').unwrap_or(("", &self.name));
        let kept = most.saturating_sub(number.len() + 3);
        let skipped = port.chars().count().saturating_sub(kept);
        format!("{number} ..{}", port.chars().skip(skipped).collect::<String>())
    }

    /// Writes `text` over its line.
    pub fn over(&self, text: &str, columns: usize) -> String {
        let up = self.of - self.row;
        let line = fitting(&format!("{}: {text}", self.label(columns)), columns);
        format!("\x1b7\x1b[{up}A\r{line}\x1b[K\x1b8")
    }

    /// Inserts `text` above all of the lines.
    pub fn above(&self, text: &str, columns: usize) -> String {
        above(&format!("{}: {text}", self.label(columns)), self.of, columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_status_is_cut_between_its_words() {
        let text = "42 %, 37 min left, layer 12 of 80";
        assert_eq!(fitting(text, 34), text);
        assert_eq!(
            [fitting(text, 33), fitting(text, 18), fitting(text, 17)],
            ["42 %, 37 min left", "42 %, 37 min left", "42 %"]
        );
        assert_eq!([fitting(text, 4), fitting(text, 1), fitting(text, 0)], ["42 ", "", ""]);
    }

    #[test]
    fn a_sentence_is_broken_between_its_words_and_a_long_word_anywhere() {
        let said = broken("1 tty1: the printer says something of some length", 20);
        assert_eq!(said, ["1 tty1: the printer", "  says something of", "  some length"]);
        let said = broken("see /a/path/without/any/blank/in/it for more", 16);
        assert!(said.iter().all(|line| line.chars().count() < 16), "{said:?}");
        let together = |lines: &[String]| lines.concat().replace(' ', "");
        assert_eq!(together(&said), "see/a/path/without/any/blank/in/itformore");
        assert_eq!(broken("", 20), [""]);
    }

    #[test]
    fn a_long_port_is_known_by_its_end() {
        let row = |name: &str| Row { name: name.to_owned(), row: 0, of: 2, drawn: true };
        assert_eq!(row("1 /dev/ttyUSB0").label(80), "1 /dev/ttyUSB0");
        let long = row("12 /dev/serial/by-id/usb-Prusa_MK3S-if00").label(60);
        assert_eq!((long.as_str(), long.len()), ("12 ..Prusa_MK3S-if00", 20));
    }
}
