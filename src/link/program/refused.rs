//! Lines that would confuse the printer's counter, or print what looks like its answer: they are refused before the print.

use crate::gcode::meaning::{Effect, Firmware, Hazard, effect};
use crate::gcode::{Command, ParsedLine};
use crate::link::protocol::Protocol;

/// The beginnings of lines that mean something to a host; M118 must not print them.
const HOST_WORDS: [&str; 10] = ["ok", "resend", "rs ", "error", "start", "!!", "wait", "grbl", "alarm", "//"];

/// The command of a line that must not be streamed, and what it would do.
pub(super) fn refused(block: &[u8], parsed: &ParsedLine, protocol: Protocol) -> Option<(String, &'static str)> {
    let firmware = protocol.firmware();
    // They would break the count of answers, or print something else.
    if let Effect::Hazard(hazard @ (Hazard::Counter | Hazard::OutOfBand | Hazard::File | Hazard::Stop)) =
        effect(firmware, parsed)
    {
        let name = parsed.commands.first().map_or_else(|| first_word(block), ToString::to_string);
        return Some((name, hazard.does()));
    }
    if parsed.commands.first() == Some(&Command::m(118)) {
        let text = String::from_utf8_lossy(&block[4..]).to_ascii_lowercase();
        let said = text.trim_start().trim_start_matches("e1").trim_start();
        if HOST_WORDS.iter().any(|word| said.starts_with(word)) {
            return Some(("M118".to_owned(), "would print a line that looks like an answer of the printer"));
        }
    }
    if memchr::memmem::find(block, b"M110").is_some() {
        return Some(("M110".to_owned(), "sets the printer's line counter, which streaming needs"));
    }
    if firmware == Firmware::Grbl { not_grbl(block, parsed) } else { None }
}

fn first_word(block: &[u8]) -> String {
    String::from_utf8_lossy(block).split(' ').next().unwrap_or_default().to_owned()
}

fn not_grbl(block: &[u8], parsed: &ParsedLine) -> Option<(String, &'static str)> {
    let not_g = parsed.commands.first().is_none_or(|c| c.letter != b'G');
    // A G-code that it does not know it answers with an error itself, and the print stops there.
    if not_g && effect(Firmware::Grbl, parsed) == Effect::Hazard(Hazard::Unknown) {
        let name = parsed.commands.first().map_or_else(|| first_word(block), ToString::to_string);
        return Some((name, "is unknown to Grbl (error:20; [dialect] commands = \"rs274\" makes such lines comments)"));
    }
    if parsed.has(b'E') {
        return Some((
            "an E word".to_owned(),
            "is unknown to Grbl (error:20; [dialect] extruder must be a spare axis)",
        ));
    }
    let real_time = block.iter().any(|b| matches!(b, b'?' | b'!' | b'~' | 0x18 | 0x80..));
    real_time.then(|| {
        ("a real-time character".to_owned(), "would be executed as soon as it arrives, wherever it is in the file")
    })
}
