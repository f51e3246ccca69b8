//! Lines of a terminal that are written over, for one print and for several that share it.
//!
//! Names and texts are strangers' (ports, printers, files): they come here as [`visible`] has them.
//!
//! No line is as long as the terminal is wide: one that the terminal breaks moves all others.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::visible;

/// Behind a line that somebody has typed: back to where it began, so that the status stays in one place.
const TYPED: &str = "\x1b[1A\r\x1b[K";

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
fn above(text: &str, rows: usize, columns: usize) -> String {
    let up = rows + 1;
    let pieces = broken(&visible(text), columns).into_iter();
    pieces.map(|piece| format!("\x1bD\x1b7\x1b[{up}A\r\x1b[L{piece}\x1b8")).collect()
}

/// The lines in front of the cursor that several things share, each its own.
///
/// The terminal echoes a typed line's end at once: until [`Lines::typed`] has moved the cursor back, whatever is written lies one line too low. So
/// all lines are kept, and written again then. Whoever writes holds the lock meanwhile.
#[derive(Debug)]
pub struct Lines {
    of: usize,
    drawn: bool,
    last: Mutex<Vec<String>>,
}

impl Lines {
    /// So many of them; whether they are there.
    pub fn new(of: usize, drawn: bool) -> Arc<Self> {
        Arc::new(Self { of, drawn, last: Mutex::new(vec![String::new(); of]) })
    }

    /// Whether they are there.
    pub fn are_drawn(&self) -> bool {
        self.drawn
    }

    /// Behind a typed line, `wrong` where it means nothing: the cursor goes back, and all lines are written again.
    pub fn typed(&self, wrong: Option<&str>, columns: usize, write: impl FnOnce(&str)) {
        let last = self.held();
        let written = last.iter().enumerate().filter(|(_, line)| !line.is_empty());
        let again: String = written.map(|(row, line)| self.over(row, line, columns)).collect();
        let told = wrong.map_or_else(String::new, |text| above(text, self.of, columns));
        write(&format!("{TYPED}{again}{told}"));
    }

    fn over(&self, row: usize, line: &str, columns: usize) -> String {
        format!("\x1b7\x1b[{}A\r{}\x1b[K\x1b8", self.of - row, fitting(line, columns))
    }

    fn held(&self) -> MutexGuard<'_, Vec<String>> {
        self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One of several things that share a terminal: its name, and which of their lines is its own.
#[derive(Clone, Debug)]
pub struct Row {
    /// What its lines begin with: a number, a blank, a port.
    pub name: String,
    /// From 0.
    pub row: usize,
    /// All of them.
    pub lines: Arc<Lines>,
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
    pub fn over(&self, text: &str, columns: usize, write: impl FnOnce(&str)) {
        let line = format!("{}: {text}", self.label(columns));
        let mut last = self.lines.held();
        write(&self.lines.over(self.row, &line, columns));
        last[self.row] = line;
    }

    /// Inserts `text` above all of the lines.
    pub fn above(&self, text: &str, columns: usize, write: impl FnOnce(&str)) {
        let _last = self.lines.held();
        write(&above(&format!("{}: {text}", self.label(columns)), self.lines.of, columns));
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

    /// What came while the cursor was one line too low is set right by what follows the typed line.
    #[test]
    fn lines_are_written_again_behind_a_typed_one() {
        let lines = Lines::new(2, true);
        let row = |row: usize| Row { name: format!("{} tty", row + 1), row, lines: Arc::clone(&lines) };
        let written = Mutex::new(Vec::new());
        let write = |text: &str| written.lock().unwrap().push(text.to_owned());
        row(1).over("12 %", 40, write);
        row(0).over("stopped", 40, write);
        lines.typed(Some("no"), 40, write);
        let written = written.into_inner().unwrap();
        assert_eq!(written[1], "\x1b7\x1b[2A\r1 tty: stopped\x1b[K\x1b8");
        assert_eq!(written[2], format!("{TYPED}{}{}{}", written[1], written[0], above("no", 2, 40)));
    }

    #[test]
    fn a_long_port_is_known_by_its_end() {
        let row = |name: &str| Row { name: name.to_owned(), row: 0, lines: Lines::new(2, true) };
        assert_eq!(row("1 /dev/ttyUSB0").label(80), "1 /dev/ttyUSB0");
        let long = row("12 /dev/serial/by-id/usb-Prusa_MK3S-if00").label(60);
        assert_eq!((long.as_str(), long.len()), ("12 ..Prusa_MK3S-if00", 20));
    }
}
