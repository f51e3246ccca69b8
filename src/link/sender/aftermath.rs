//! Whether a printer obeys an emergency stop: its own words tell, or its silence.

use std::time::Duration;

use crate::link::Time;
use crate::link::protocol::Protocol;
use crate::link::reply::{Reply, Wording};
use crate::link::wire::LineAssembler;

/// A printer that works or heats says so at least every two seconds.
const SILENT: Time = Duration::from_millis(2500);

/// One that still talks then has not stopped.
const GOES_ON: Time = Duration::from_secs(10);

/// What became of an emergency stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AfterStop {
    /// The printer says that it has stopped, or begins anew.
    Stopped,
    /// It has said nothing since, or its port has gone: it may have stopped, or be in the middle of a long move.
    Silent,
    /// It works on; the last that it said.
    GoesOn(String),
}

/// Listens to a printer that was to stop. Times are since any fixed moment.
#[derive(Clone, Debug)]
pub struct StopWatch {
    wording: Wording,
    lines: LineAssembler,
    sent: Time,
    heard: Time,
    said: String,
    stopped: bool,
    gone: bool,
}

impl StopWatch {
    /// The stop went out at `now`.
    pub fn new(protocol: Protocol, now: Time) -> Self {
        let (lines, said) = (LineAssembler::default(), String::new());
        Self { wording: protocol.traits().wording, lines, sent: now, heard: now, said, stopped: false, gone: false }
    }

    /// Takes bytes from the printer.
    pub fn receive(&mut self, now: Time, bytes: &[u8]) {
        self.lines.push(bytes);
        while let Some(line) = self.lines.next_line() {
            self.heard = now;
            self.said = String::from_utf8_lossy(line).chars().filter(|c| !c.is_control()).take(60).collect();
            let reply = Reply::read(self.wording, line);
            self.stopped |= matches!(reply, Reply::Fatal(_) | Reply::Greeting(_) | Reply::Alarm(_));
        }
    }

    /// The port has gone. So does that of a board that is reset, and that of one whose cable is pulled.
    pub fn gone(&mut self) {
        self.gone = true;
    }

    /// What is known by now; `None` while it may still obey.
    pub fn verdict(&self, now: Time) -> Option<AfterStop> {
        match () {
            () if self.stopped => Some(AfterStop::Stopped),
            () if self.gone || now >= self.heard + SILENT => Some(AfterStop::Silent),
            () if now >= self.sent + GOES_ON => Some(AfterStop::GoesOn(self.said.clone())),
            () => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Time = Duration::from_secs(1);

    fn after(words: &str) -> Option<AfterStop> {
        let mut watch = StopWatch::new(Protocol::Marlin, Time::ZERO);
        for second in 0..20 {
            if let Some(verdict) = watch.verdict(SECOND * second) {
                return Some(verdict);
            }
            watch.receive(SECOND * second, words.as_bytes());
        }
        None
    }

    #[test]
    fn a_printer_that_heats_on_has_not_stopped_and_one_that_says_so_has() {
        let heating = " T:180.00 /210.00 B:60.00 /60.00 @:127 B@:0 W:?";
        assert_eq!(after(&format!("{heating}\n")), Some(AfterStop::GoesOn(heating.to_owned())));
        assert_eq!(after("Error:Printer halted. kill() called!\n"), Some(AfterStop::Stopped));
        assert_eq!(after("start\n"), Some(AfterStop::Stopped));
        assert_eq!(after(""), Some(AfterStop::Silent));
        // Of a cable that is pulled nobody knows what it has brought over.
        let mut watch = StopWatch::new(Protocol::Marlin, Time::ZERO);
        watch.gone();
        assert_eq!(watch.verdict(SECOND), Some(AfterStop::Silent));
        // Half a line is no word.
        assert_eq!(after("o"), Some(AfterStop::Silent));
    }
}
