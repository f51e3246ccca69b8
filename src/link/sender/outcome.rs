//! Every way a print ends, in words.

/// Why the sender stopped by itself.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StopReason {
    /// A greeting, and a counter that began anew.
    #[error(
        "the printer was reset during the print ({greeting}), so the position of its axes is unknown; inspect the part, then run trunnion send \
         --resume"
    )]
    Reset {
        /// How it was noticed.
        greeting: String,
    },
    /// The counter is not where it can be.
    #[error(
        "the printer's line counter is at {found}, but lines up to {proven} were accepted and {last} were sent: it was reset, or another program \
         is talking to it; stop that program, inspect the part, then run trunnion send --resume"
    )]
    Counter {
        /// The printer's last line.
        found: i64,
        /// Known to be accepted.
        proven: i64,
        /// Ever sent.
        last: i64,
    },
    /// The journal does not speak of a single line, but the printer has taken some.
    #[error(
        "the journal has no record of a line, but the printer has accepted {found}: part of the print may be on the table; if the table is empty, \
         run trunnion send without --resume"
    )]
    Unrecorded {
        /// The printer's last line.
        found: i64,
    },
    /// One line refused again and again.
    #[error("line {line} of the file was refused {times} times; check the cable and the baud rate")]
    EndlessResend {
        /// Of the file.
        line: u32,
        /// How often.
        times: u32,
    },
    /// No answer.
    #[error(
        "the printer has not answered for {seconds:.0} s ({questions} unanswered requests){}; its heaters may still be on",
        strange(said)
    )]
    Mute {
        /// Since its last word.
        seconds: f64,
        /// Asked in vain.
        questions: u32,
        /// The last that it said and nobody understands.
        said: Option<String>,
    },
    /// It answers, but nothing gets on.
    #[error("the printer responds, but has accepted no line for {seconds:.0} s, at line {line} of the file")]
    NoProgress {
        /// Since the last line was taken.
        seconds: f64,
        /// Of the file.
        line: u32,
    },
    /// Bytes, but no words.
    #[error("only unreadable bytes arrive: the baud rate is wrong, or the device is not a printer")]
    Noise,
    /// `Error:`, `!!`, `ALARM:` that ends everything.
    #[error("the printer has stopped: {text}; remove the cause, then {}", again(text))]
    Fatal {
        /// Its own words.
        text: String,
    },
    /// An error that no rule calls harmless.
    #[error("at line {line} of the file the printer reports: {text}")]
    Error {
        /// Its own words.
        text: String,
        /// Of the file.
        line: u32,
    },
    /// Grbl refused a line.
    #[error("line {line} of the file was refused: error:{code} ({meaning}); the machine is in feed hold")]
    Refused {
        /// Of the file.
        line: u32,
        /// Grbl's number.
        code: u32,
        /// In words.
        meaning: &'static str,
    },
    /// Answers are missing or there is one too many, and the protocol has no counter to ask.
    #[error("{}", unaccounted(*lines, [*first, *last]))]
    Unaccounted {
        /// How many; 0 where all are answered and the printer is not to be trusted all the same.
        lines: i64,
        /// Of the file.
        first: u32,
        /// Of the file.
        last: u32,
    },
    /// Its M114 is not where the file has brought it.
    #[error(
        "after line {line} of the file the printer reports {axis} at {found:.2} {unit} (expected {believed:.2} {unit}); check the firmware's axis \
         limits, and that no other program moves the axis; the head is above the part",
        unit = unit(*axis)
    )]
    Elsewhere {
        /// The axis' letter.
        axis: char,
        /// The printer's word, mm or degrees.
        found: f64,
        /// Ours.
        believed: f64,
        /// Of the file.
        line: u32,
    },
    /// The bed has cooled since the print was broken off.
    #[error(
        "the bed is at {is_c:.0} C instead of {was_c:.0} C, so the part may have come loose; nothing was moved; check that it still holds, \
         then use --resume --yes"
    )]
    Cooled {
        /// What it is.
        is_c: f64,
        /// What it was to be.
        was_c: f64,
    },
    /// It stands where the print cannot have left it.
    #[error("the printer is at {said}, where the print cannot have left it: it was reset, or something else moved it")]
    Misplaced {
        /// Its own words.
        said: String,
    },
    /// Another printer, or another firmware.
    #[error("the printer identifies itself as {found:?}, expected {wanted:?}: wrong port, or wrong profile")]
    OtherPrinter {
        /// Its own words.
        found: String,
        /// What it should be.
        wanted: String,
    },
    /// It cannot begin.
    #[error("the printer is not ready: {state}")]
    NotReady {
        /// What it says, and what to do.
        state: String,
        /// Whether it is locked until it is homed: it has lost its position.
        locked: bool,
    },
}

/// The unit of an axis' positions.
pub(super) fn unit(axis: char) -> &'static str {
    if "XYZ".contains(axis) { "mm" } else { "deg" }
}

/// What is known where `lines` lines that were sent between the file's lines `first` and `last` have no answer.
fn unaccounted(lines: i64, [first, last]: [u32; 2]) -> String {
    let at = if first == last { format!("line {last}") } else { format!("lines {first} to {last}") };
    let lost = match lines {
        ..=0 => format!(
            "the connection was lost after line {last} of the file, or another program sent data to the printer"
        ),
        1 => format!("1 line sent at {at} of the file was not answered, so it is unknown whether it was executed"),
        _ => format!(
            "{lines} lines sent at {at} of the file were not answered, so it is unknown whether they were executed"
        ),
    };
    lost + "; inspect the part, then run trunnion send --resume"
}

fn strange(said: &Option<String>) -> String {
    said.as_ref().map_or(String::new(), |said| format!("; its last answer, {said:?}, is not understood"))
}

/// What makes a printer listen again that has said `text` and stopped.
pub(super) fn again(text: &str) -> &'static str {
    let klipper = text.contains("Klipper") || text.to_ascii_lowercase().contains("shutdown");
    if klipper { "send FIRMWARE_RESTART, then home it again" } else { "reset the printer" }
}

impl StopReason {
    /// Whether a machine that can be held is to be.
    pub(super) fn holds(&self) -> bool {
        !matches!(
            self,
            Self::NotReady { .. } | Self::OtherPrinter { .. } | Self::Misplaced { .. } | Self::Cooled { .. }
        )
    }

    /// Whether anything that is sent now could be heard and obeyed in a known way.
    pub(super) fn answers(&self) -> bool {
        !matches!(
            self,
            Self::Reset { .. }
                | Self::Counter { .. }
                | Self::Unrecorded { .. }
                | Self::Mute { .. }
                | Self::Noise
                | Self::Fatal { .. }
                | Self::OtherPrinter { .. }
                | Self::NotReady { .. }
                | Self::Misplaced { .. }
                | Self::Cooled { .. }
        )
    }
}

/// How a print ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Every line executed.
    Done,
    /// Cancelled: the head is away, heaters by policy.
    Cancelled,
    /// Emergency stop.
    EmergencyStopped,
    /// By the sender, with the reason.
    Stopped(StopReason),
}

#[cfg(test)]
mod tests {
    use super::StopReason;

    #[test]
    fn a_stop_without_answers_names_lines_only_where_some_are_owed() {
        let text = |lines, first, last| StopReason::Unaccounted { lines, first, last }.to_string();
        for (lines, first, last, wanted) in
            [(0, 40, 40, "after line 40"), (1, 40, 40, "1 line sent"), (5, 40, 44, "lines 40 to 44")]
        {
            let text = text(lines, first, last);
            assert!(text.contains(wanted) && text.contains("--resume"), "{text}");
        }
        let turned = StopReason::Elsewhere { axis: 'C', found: 1.0, believed: 2.0, line: 7 }.to_string();
        assert!(turned.contains("1.00 deg") && turned.contains("2.00 deg"), "{turned}");
    }
}
