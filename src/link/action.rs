//! What a printer asks of its host, in one table: a filament sensor, a crash, or somebody at its display.
//!
//! Sources: Marlin's `host_actions.cpp`, Klipper's and Prusa's `// action:` lines, Repetier's `Com::tRequestPause` and its like, RepRapFirmware's
//! `Platform::SendAlert`.

/// What is asked for, or told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HostAction {
    /// A pause.
    Pause,
    /// A pause, since the host is to go, or the printer will be switched off.
    Leave,
    /// The printer has paused by itself, and says when it goes on.
    Paused,
    /// It has gone on.
    Resumed,
    /// The end of the print.
    Cancel,
    /// The end of a pause.
    Resume,
    /// Something that its display shows.
    Shown,
    /// A word that no rule knows.
    Unknown,
}

/// Words behind `//action:`.
const WORDS: [(&str, HostAction); 14] = [
    ("pause", HostAction::Pause),
    ("out_of_filament", HostAction::Pause),
    ("disconnect", HostAction::Leave),
    ("poweroff", HostAction::Leave),
    ("paused", HostAction::Paused),
    ("resumed", HostAction::Resumed),
    ("cancel", HostAction::Cancel),
    ("resume", HostAction::Resume),
    ("notification", HostAction::Shown),
    ("prompt_begin", HostAction::Shown),
    ("prompt_choice", HostAction::Shown),
    ("prompt_button", HostAction::Shown),
    ("prompt_show", HostAction::Shown),
    ("prompt_end", HostAction::Shown),
];

/// Repetier's lines, and the one with which RepRapFirmware ends a message of M291 that waits for a person.
const REQUESTS: [(&str, HostAction); 5] = [
    ("RequestPause:", HostAction::Pause),
    ("RequestStop:", HostAction::Cancel),
    ("RequestContinue:", HostAction::Resume),
    ("RequestDisconnect:", HostAction::Leave),
    ("Send M292 to continue", HostAction::Paused),
];

impl HostAction {
    /// The action of a printer's line, and what it says of it; `None` where the line asks for nothing.
    pub fn read(line: &str) -> Option<(Self, &str)> {
        if let Some(found) = REQUESTS.iter().find_map(|(word, action)| Some((*action, line.strip_prefix(word)?))) {
            return Some((found.0, line));
        }
        let asked = line.strip_prefix("//")?.trim_start().strip_prefix("action:")?;
        let word = asked.split_ascii_whitespace().next().unwrap_or_default();
        let known = WORDS.iter().find(|(known, _)| *known == word);
        Some((known.map_or(Self::Unknown, |(_, action)| *action), asked))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_however_the_firmware_spaces_them() {
        let read = |line| HostAction::read(line).map(|(action, _)| action);
        assert_eq!(read("//action:pause"), Some(HostAction::Pause));
        assert_eq!(read("// action:paused filament_runout 0"), Some(HostAction::Paused));
        assert_eq!(read("//action:out_of_filament T0"), Some(HostAction::Pause));
        assert_eq!(read("RequestPause:No filament"), Some(HostAction::Pause));
        assert_eq!(read("Send M292 to continue or M292 P1 to cancel"), Some(HostAction::Paused));
        assert_eq!(read("//action:start_the_coffee"), Some(HostAction::Unknown));
        assert_eq!((read("// Klipper state: Ready"), read("echo:pause"), read("ok")), (None, None, None));
        assert_eq!(HostAction::read("//action:notification Heating").map(|a| a.1), Some("notification Heating"));
    }
}
