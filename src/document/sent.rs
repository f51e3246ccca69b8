//! What a person is told while something is sent, in sentences, and how several prints ended.

use serde_json::{Value, json};

use crate::job::{At, Ended, Figures, Rehearsal, Sending};

/// How a sentence is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// To whom asks for details.
    Detail,
    /// To everybody who did not ask for quiet.
    Note,
    /// To everybody.
    Warning,
    /// In one place that is written over.
    Status,
}

/// What is said of an event; `None` for what is not.
pub fn said(what: &Sending<'_>, at: At) -> Option<(Tone, String)> {
    let (tone, text) = match what {
        Sending::Printer(name) => (Tone::Note, format!("printer: {name}")),
        Sending::Resend { number, why, .. } => (Tone::Detail, format!("wire line {number} is sent again ({why})")),
        Sending::UserWait => (Tone::Note, "the printer is waiting for a person".to_owned()),
        Sending::Note(text) => (Tone::Note, (*text).to_owned()),
        Sending::Progress(figures) => (Tone::Status, status(figures, at)),
        Sending::Pausing { waits_for } => {
            let waits = |what: &str| format!("{what}, which the printer waits for");
            let first = waits_for.map_or("the moves under way".to_owned(), waits);
            (Tone::Note, format!("pausing after {first}; Ctrl-C again is an emergency stop"))
        }
        Sending::Trouble { file_line, text } => {
            let text = format!("line {file_line} was not carried out as it is written; the printer says: {text}");
            (Tone::Warning, text)
        }
        Sending::Resumed => (Tone::Note, "the print goes on".to_owned()),
        Sending::Done { resends } => {
            (Tone::Note, format!("the print is complete: {} lines, {resends} of them sent again", at.of))
        }
        Sending::Short { journal } => {
            (Tone::Warning, format!("{journal}: no room left on the disk for the journal; pausing"))
        }
        Sending::StillShort => (Tone::Warning, "there is still no room on the disk for the journal".to_owned()),
        Sending::Full { journal } => {
            (Tone::Warning, format!("{journal}: cannot be written any more; nothing is sent until it can"))
        }
        Sending::Lost { why, wait } => {
            let wait = wait.as_secs();
            (Tone::Warning, format!("connection lost ({why}); waiting up to {wait} s for the same device"))
        }
        Sending::Aside { journal } => {
            (Tone::Warning, format!("the journal of an interrupted print is now {}", journal.display()))
        }
        Sending::UnprovedReentry => {
            (Tone::Warning, "without --plan there is no proof that the path of the re-entry is clear".to_owned())
        }
        _ => return None,
    };
    Some((tone, text))
}

/// One line of a narrow terminal.
fn status(f: &Figures, at: At) -> String {
    let mut words = vec![format!("{:.0} %", (f.share * 100.0).clamp(0.0, 100.0))];
    if f.layers > 0 {
        words.push(format!("layer {} of {}", f.layer, f.layers));
    } else {
        words.push(format!("line {} of {}", at.line, at.of));
    }
    words.extend(f.slot.map(|slot| format!("slot {slot} of {}", f.slots)));
    words.push(format!("{:.0} min left", f.seconds_left / 60.0));
    words.extend(f.waits_for.map(|what| format!("waits for {what}")));
    words.extend(f.nozzle_c.map(|[now, wanted]| format!("{now:.0}/{wanted:.0} C")));
    words.extend(f.bed_c.map(|[now, wanted]| format!("bed {now:.0}/{wanted:.0}")));
    words.join(", ")
}

/// What a rehearsal came to.
pub fn rehearsal(done: &Rehearsal) -> String {
    format!(
        "rehearsal: {} lines in {:.0} min with heating and accelerations ({:.0} min without); {} targets beyond an axis",
        done.lines,
        done.seconds / 60.0,
        done.seconds_print / 60.0,
        done.clamped
    )
}

/// What a rehearsed printer would not have done; `None` where it did all.
pub fn undone(done: &Rehearsal) -> Option<String> {
    if done.clamped > 0 {
        return Some(format!("{} targets lie beyond an axis of the profile", done.clamped));
    }
    let first = done.troubles.first()?;
    let more = done.troubles.len() - 1;
    let more = if more > 0 { format!(", and {more} more") } else { String::new() };
    Some(format!("the simulated printer did not carry out {first}{more}; the real one would pause there"))
}

/// `trunnion send` to several printers: the last line, with port, file and, where it failed, the reason of each print.
pub fn ended(prints: &[Ended]) -> Value {
    let each = |print: &Ended| {
        let (file, error) = (print.file.to_string_lossy(), print.error.as_ref().map(ToString::to_string));
        json!({"port": print.port, "file": file, "ok": error.is_none(), "error": error})
    };
    json!({"event": "ended", "prints": prints.iter().map(each).collect::<Vec<_>>()})
}

/// Which of several prints have failed, and why; `None` where none has.
pub fn failures(prints: &[Ended]) -> Option<String> {
    let each = |p: &Ended| Some(format!("{}: {}: {}", p.port, p.file.display(), p.error.as_ref()?));
    let failed: Vec<String> = prints.iter().filter_map(each).collect();
    let text = || format!("{} of {} prints failed; {}", failed.len(), prints.len(), failed.join("; "));
    (!failed.is_empty()).then(text)
}

/// One of several things that share a terminal: its name, and which of the `of` lines in front of the cursor is its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// What its lines begin with.
    pub name: String,
    /// From 0.
    pub row: usize,
    /// All of them.
    pub of: usize,
}

/// Columns of a narrow terminal.
const COLUMNS: usize = 78;

impl Row {
    /// Writes `text` over its line.
    pub fn over(&self, text: &str) -> String {
        let (up, text) = (self.of - self.row, format!("{}: {text}", self.name));
        format!("\x1b[{up}A\r{text:<COLUMNS$.COLUMNS$}\x1b[{up}B\r")
    }

    /// Inserts `text` above all of the lines; a line that the terminal breaks would move them, so it is broken here.
    pub fn above(&self, text: &str) -> String {
        let up = self.of + 1;
        let letters: Vec<char> = format!("{}: {text}", self.name).chars().collect();
        let pieces = letters.chunks(COLUMNS).map(|piece| piece.iter().collect::<String>());
        pieces.map(|piece| format!("\n\x1b[{up}A\r\x1b[L{piece}\x1b[{up}B\r")).collect()
    }
}
