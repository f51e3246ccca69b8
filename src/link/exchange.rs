//! One line and its answer, for whoever asks a printer something and streams nothing: what is streamed is the sender's.
//!
//! A state machine with a passed-in clock: bytes come in, and the answer is there once its `ok` is. Lines go without number and checksum,
//! which every firmware takes. Only an `ok` that comes behind the line is its answer: whoever begins drops what came before.

use super::Time;
use super::reply::{Reply, Wording};
use super::wire::LineAssembler;

/// More lines than any firmware answers; what a flood says beyond them is dropped.
const MOST_LINES: usize = 2000;

/// How a line was answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answered {
    /// By these lines and an `ok`.
    Ok(Vec<String>),
    /// Not carried out, in the firmware's words.
    Refused(String),
    /// Not at all: so it was silent for as long as it is waited for. What it said until then.
    Silent(Vec<String>),
}

/// A line that was sent, and what has come since.
#[derive(Clone, Debug)]
pub struct Exchange {
    wording: Wording,
    lines: LineAssembler,
    said: Vec<String>,
    refused: Option<String>,
    heard: Time,
    ended: bool,
}

impl Exchange {
    /// A line is sent at `now` to a printer of this wording.
    pub fn begin(wording: Wording, now: Time) -> Self {
        let lines = LineAssembler::default();
        Self { wording, lines, said: Vec::new(), refused: None, heard: now, ended: false }
    }

    /// Takes what has arrived.
    pub fn receive(&mut self, now: Time, bytes: &[u8]) {
        self.heard = now;
        self.lines.push(bytes);
        while let Some(line) = self.lines.next_line() {
            if self.ended {
                return;
            }
            let text = shown(line);
            // Grbl's, whomever was asked for: nobody else numbers errors so.
            let numbered = text.strip_prefix("error:").is_some_and(|code| code.parse::<u32>().is_ok());
            let wording = if numbered { Wording::Grbl } else { self.wording };
            match Reply::read(wording, line) {
                Reply::Ok { .. } | Reply::OkIdentity(_) => {
                    // Klipper's and the temperatures stand behind it.
                    let behind = text.trim_start_matches("ok").trim();
                    self.said.extend((!behind.is_empty()).then(|| behind.to_owned()));
                    self.ended = true;
                }
                Reply::Refused(_) | Reply::Alarm(_) | Reply::Fatal(_) | Reply::Resend(_) => {
                    self.refused.get_or_insert(text);
                    self.ended = true;
                }
                // Their `ok` comes all the same.
                Reply::Error(_) | Reply::LineError(_) | Reply::Unknown(_) | Reply::Undone(_) => {
                    self.refused.get_or_insert(text);
                }
                Reply::Busy(_) | Reply::Action(..) => {}
                _ if self.said.len() < MOST_LINES => self.said.push(text),
                _ => {}
            }
        }
    }

    /// The answer, once it is there; [`Answered::Silent`] where nothing has come for `patience`.
    pub fn answer(&self, now: Time, patience: Time) -> Option<Answered> {
        match (&self.refused, self.ended) {
            (Some(words), true) => Some(Answered::Refused(words.clone())),
            (None, true) => Some(Answered::Ok(self.said.clone())),
            (Some(words), false) if now >= self.heard + patience => Some(Answered::Refused(words.clone())),
            (None, false) if now >= self.heard + patience => Some(Answered::Silent(self.said.clone())),
            _ => None,
        }
    }
}

/// A line as it may be shown and read again: no control characters.
fn shown(line: &[u8]) -> String {
    String::from_utf8_lossy(line).chars().filter(|c| !c.is_control()).collect()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    const S: Duration = Duration::from_secs(1);

    fn heard(wording: Wording, bytes: &[u8]) -> Option<Answered> {
        let mut exchange = Exchange::begin(wording, S);
        for piece in bytes.chunks(3) {
            exchange.receive(2 * S, piece);
        }
        exchange.answer(3 * S, 5 * S)
    }

    #[test]
    fn answers_end_with_their_ok_and_refusals_with_theirs() {
        let ok = |lines: &[&str]| Some(Answered::Ok(lines.iter().map(|line| (*line).to_owned()).collect()));
        let refused = |words: &str| Some(Answered::Refused(words.to_owned()));
        let (printer, klipper, grbl) = (Wording::Printer, Wording::Klipper, Wording::Grbl);
        assert_eq!(heard(printer, b"echo:  M203 X1\necho:busy: processing\nok\n"), ok(&["echo:  M203 X1"]));
        assert_eq!(heard(printer, b"ok T:20.1 /0.0 B:20.0 /0.0\n"), ok(&["T:20.1 /0.0 B:20.0 /0.0"]));
        assert_eq!(heard(klipper, b"ok FIRMWARE_NAME:Klipper\n"), ok(&["FIRMWARE_NAME:Klipper"]));
        assert_eq!(heard(grbl, b"[AXS:5:XYZAC]\nok\nok\n"), ok(&["[AXS:5:XYZAC]"]));
        assert_eq!(heard(grbl, b"error:20\n"), refused("error:20"));
        assert_eq!(heard(klipper, b"error:20\n"), refused("error:20"));
        let unknown = "echo:Unknown command: \"M503\"";
        assert_eq!(heard(printer, format!("{unknown}\nok\n").as_bytes()), refused(unknown));
        assert_eq!(heard(printer, b"X:1.00 Y:2.00"), None);
    }

    #[test]
    fn silence_ends_it_and_signs_of_life_do_not() {
        let mut exchange = Exchange::begin(Wording::Printer, S);
        exchange.receive(2 * S, b"echo:busy: processing\n");
        assert_eq!(exchange.answer(6 * S, 5 * S), None);
        assert_eq!(exchange.answer(7 * S, 5 * S), Some(Answered::Silent(Vec::new())));
    }
}
