//! Rule `reading`: the profile's firmware takes every line for what it is read as here.
//!
//! Firmwares differ in comments, lengths, repeated words, exponents and more ([`LineRules`]). Where the machine would do something else
//! than the trace says, all other rules judge a file that it does not print. With it, as it needs each line's bytes: nothing moves behind
//! the end mark but the profile's own end code (rule `command`).

use super::ReplayJob;
use super::commands::Permitted;
use super::evidence::{Checked, Evidence};
use super::report::{FindingPlace, Findings, Rule};
use crate::gcode::marks::{Mark, mark};
use crate::gcode::meaning::Firmware;
use crate::gcode::{LineKind, LineRules, Misreading, NumberedLine, ParsedLine, PlainMove, lines, text_start};
use crate::trace::Zone;

/// Holds every line of the file.
pub(super) fn check(&Evidence { bytes, job, .. }: &Evidence<'_>) -> Checked {
    let mut reader = Reader::new(job);
    if text_start(bytes) > 0 {
        reader.byte_order_mark(bytes);
    }
    let mut parsed = ParsedLine::default();
    for line in lines(bytes) {
        // Such moves all firmwares read alike.
        let plain = PlainMove::read(line.bytes).is_some();
        if !(plain && reader.zone == Zone::Prints && line.bytes.len() < SHORT) && parsed.read(line.bytes).is_ok() {
            reader.take(&line, &parsed);
        }
    }
    reader.findings.into()
}

/// No firmware reads fewer bytes of a line.
const SHORT: usize = 79;

struct Reader<'a> {
    firmware: Firmware,
    rules: LineRules,
    permitted: Permitted<'a>,
    zone: Zone,
    /// Whether a line was one of the program, and where LinuxCNC ends it.
    begun: bool,
    percent: Option<u32>,
    findings: Findings,
}

impl<'a> Reader<'a> {
    fn new(job: &ReplayJob<'a>) -> Self {
        let firmware = job.profile.firmware();
        Self {
            firmware,
            rules: LineRules::of(firmware),
            permitted: Permitted::by(&job.profile.dialect),
            zone: Zone::Start,
            begun: false,
            percent: None,
            findings: Findings::default(),
        }
    }

    fn say(&mut self, rule: Rule, line: u32, numbers: [f64; 2], text: impl FnOnce() -> String) {
        self.findings.add(rule, FindingPlace { line, slot: None, part: None }, numbers, text);
    }

    /// Bytes before the first line that firmwares take for a part of its command.
    fn byte_order_mark(&mut self, bytes: &[u8]) {
        let mut parsed = ParsedLine::default();
        let first = lines(bytes).next().filter(|line| parsed.read(line.bytes).is_ok());
        if first.is_some() && parsed.kind != LineKind::Empty {
            let firmware = self.firmware.name();
            self.say(Rule::Reading, 1, [0.0; 2], || {
                format!("{firmware} does not recognize a command after a byte-order mark; remove the mark")
            });
        }
    }

    fn take(&mut self, line: &NumberedLine<'_>, parsed: &ParsedLine) {
        if parsed.kind == LineKind::Empty {
            match mark(&line.bytes[parsed.comment.clone()]) {
                Some(Mark::Slot(_)) => self.zone = Zone::Prints,
                Some(Mark::End) => self.zone = Zone::End,
                _ => {}
            }
        } else {
            self.percent(line.number, parsed.kind == LineKind::Percent);
        }
        let text = &line.bytes[parsed.code.clone()];
        if let Some(wrong) = self.rules.misreading(line.bytes, parsed)
            && !(matches!(wrong, Misreading::Several(_)) && self.permitted.owns(self.zone, text))
        {
            let firmware = self.firmware.name();
            self.say(Rule::Reading, line.number, numbers(&wrong), || format!("{firmware} {wrong}"));
        }
        if self.zone == Zone::End && moves(parsed) && !self.permitted.owns(Zone::End, text) {
            self.say(Rule::Command, line.number, [0.0; 2], || {
                "the head moves after the end of the print; remove the line, or add it to [dialect] end".to_owned()
            });
        }
    }

    /// LinuxCNC ends the program at the second `%`.
    fn percent(&mut self, line: u32, is: bool) {
        if self.firmware != Firmware::LinuxCnc {
            return;
        }
        if let Some(at) = self.percent.take() {
            let firmware = self.firmware.name();
            self.say(Rule::Reading, at, [0.0; 2], || format!("{firmware} ends the program at '%'; remove it"));
        }
        self.percent = (is && self.begun).then_some(line);
        self.begun = true;
    }
}

fn numbers(wrong: &Misreading) -> [f64; 2] {
    match wrong {
        Misreading::Long { bytes, most } => [*bytes as f64, *most as f64],
        _ => [0.0; 2],
    }
}

fn moves(parsed: &ParsedLine) -> bool {
    let axes = parsed.words.iter().any(|w| b"XYZABCUVWE".contains(&w.letter));
    let is_move = parsed.commands.iter().any(|c| c.letter == b'G' && c.number <= 3 && c.minor == 0);
    parsed.kind == LineKind::Words && axes && (is_move || parsed.commands.is_empty())
}
