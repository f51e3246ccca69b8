//! The protocols, and one table of everything in which they differ as seen from the host.
//!
//! Sender, program, preflight, re-entry and the jobs ask here; none of them has a list of its own. The simulated printers do not:
//! they are the other end, and would be no witness. Sources: the firmwares, as
//! `fixtures/wire/README.md` says.

use super::reply::Wording;
use crate::gcode::meaning::Firmware;

/// Which firmware is at the other end of the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protocol {
    /// Numbers, checksums, `ok`, `Resend`.
    Marlin,
    /// `RepRapFirmware` over USB: numbers and checksums are taken, a bad line is dropped without a word.
    RepRapFirmware,
    /// Klipper's pty: one `ok` a line, numbers ignored.
    Klipper,
    /// Grbl, grblHAL, FluidNC: character counting, real-time bytes.
    Grbl,
}

/// How the host finds out which lines were taken, where answers are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Accounting {
    /// The printer counts: a line with a wrong number is refused with `Last Line: n`. So lines can go out again, and a print whose
    /// link broke can go on.
    Counter,
    /// Nothing counts, but the answer to M105 says that everything before it was answered: what is missing then stops the print.
    Proof,
    /// Every `ok` stands for the oldest line; the status report is the witness, and what does not agree with it stops the print.
    Status,
}

/// The first bytes on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hello {
    /// A numbered M110 with number 0, which sets the counter; its `ok` begins the talk.
    SetCounter,
    /// A line whose answers say who is there.
    Ask(&'static [u8]),
    /// None: the first line is asked at once.
    None,
}

/// Bytes that act when they arrive, whatever stands around them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RealTime {
    pub(crate) status: u8,
    pub(crate) hold: u8,
    pub(crate) reset: u8,
}

/// What a protocol is like.
#[derive(Debug)]
pub(crate) struct Traits {
    /// The word of a profile.
    pub(crate) name: &'static str,
    /// Whose words are understood at the other end.
    pub(crate) firmware: Firmware,
    /// How its answers are worded.
    pub(crate) wording: Wording,
    /// Whether lines carry a number and a checksum.
    pub(crate) numbered: bool,
    /// What settles a doubt.
    pub(crate) accounting: Accounting,
    /// The first bytes.
    pub(crate) hello: Hello,
    /// Lines and bytes without an answer, where the profile says nothing else.
    pub(crate) window: (usize, usize),
    /// Bytes of the receive buffer that stay empty.
    pub(crate) margin: usize,
    /// Whether the profile's `[link] commands` says how many lines it queues.
    pub(crate) queues: bool,
    /// A serial wire, with a speed and a receive buffer of the profile's size; a pseudo-terminal has neither.
    pub(crate) serial: bool,
    /// Seconds of motion that it may have answered before they are carried out, beyond its planner's blocks.
    pub(crate) buffered_s: f64,
    /// Ends half a line so that it is not carried out. RepRapFirmware takes one without a checksum, so that it gets a wrong one. Empty where a blank
    /// line is a line, which costs an answer: then half a line is carried out.
    pub(crate) ends_half_line: &'static [u8],
    /// Bytes that act at once.
    pub(crate) real_time: Option<RealTime>,
    /// Waits until the last move has ended.
    pub(crate) drain: &'static str,
    /// A line that moves nothing and is refused by a printer that is shut down, though it answers all questions as ever.
    pub(crate) refused_when_down: Option<&'static str>,
    /// Ends a wait for heat, where the firmware looks for it before it queues lines.
    pub(crate) end_wait: Option<&'static [u8]>,
    /// The emergency stop as a line without a number.
    pub(crate) emergency: &'static [u8],
    /// The emergency stop for somebody who does not know what was sent before.
    pub(crate) emergency_raw: &'static [u8],
    /// What its identity has in it, one of these where there are any.
    pub(crate) says: &'static [&'static str],
    /// What the identity of another firmware has in it.
    pub(crate) never_says: &'static [&'static str],
    /// What homes it by hand, without which it takes no move.
    pub(crate) unlock: Option<&'static [u8]>,
}

/// A ring of 128 bytes holds 127.
const RING: usize = 1;

/// Prusa's firmware empties a receive buffer that has no byte left, unread ("Full RX Buffer"), and Marlin's RX_BUFFER_MONITOR calls that
/// an overflow: one byte more stays empty.
const RING_NEVER_FULL: usize = 2;

/// BUFSIZE 4 and 128 bytes of receive buffer. The lines of the window fit into the firmware's command queue, so that a question, which
/// comes after a silence, finds the buffer empty.
static MARLIN: Traits = Traits {
    name: "marlin",
    firmware: Firmware::Marlin,
    wording: Wording::Printer,
    numbered: true,
    accounting: Accounting::Counter,
    hello: Hello::SetCounter,
    window: (4, 128 - RING_NEVER_FULL),
    margin: RING_NEVER_FULL,
    queues: true,
    serial: true,
    // It answers what its planner has room for, however long that takes.
    buffered_s: 0.0,
    ends_half_line: b"\n",
    real_time: None,
    drain: "M400",
    refused_when_down: None,
    end_wait: Some(b"\nM108\n"),
    emergency: b"M112\n",
    emergency_raw: b"\nM112\n",
    says: &[],
    never_says: &["RepRapFirmware", "FIRMWARE_NAME:Klipper", "FIRMWARE_NAME:Kalico"],
    unlock: None,
};

static REPRAPFIRMWARE: Traits = Traits {
    name: "rrf",
    firmware: Firmware::RepRapFirmware,
    wording: Wording::Printer,
    numbered: true,
    accounting: Accounting::Proof,
    hello: Hello::None,
    window: (1, 256 - RING),
    margin: RING,
    queues: false,
    serial: true,
    buffered_s: 3.0,
    ends_half_line: b"*300\n",
    real_time: None,
    drain: "M400",
    refused_when_down: None,
    end_wait: None,
    // M112 halts it, and only M999 makes it listen again.
    emergency: b"M112\nM999\n",
    emergency_raw: b"\nM112\n",
    says: &["RepRapFirmware"],
    never_says: &[],
    unlock: None,
};

static KLIPPER: Traits = Traits {
    name: "klipper",
    firmware: Firmware::Klipper,
    wording: Wording::Klipper,
    numbered: false,
    accounting: Accounting::Proof,
    hello: Hello::None,
    window: (8, 4096),
    margin: RING,
    queues: false,
    serial: false,
    // Its host plans about 2 s ahead.
    buffered_s: 3.0,
    ends_half_line: b"",
    real_time: None,
    drain: "M400",
    refused_when_down: Some("M400"),
    end_wait: None,
    emergency: b"M112\n",
    emergency_raw: b"\nM112\n",
    // Kalico is a fork of it, which speaks the same.
    says: &["Klipper", "Kalico"],
    never_says: &[],
    unlock: None,
};

static GRBL: Traits = Traits {
    name: "grbl",
    firmware: Firmware::Grbl,
    wording: Wording::Grbl,
    numbered: false,
    accounting: Accounting::Status,
    hello: Hello::Ask(b"$I\n"),
    window: (usize::MAX, 128 - RING),
    margin: RING,
    queues: false,
    serial: true,
    buffered_s: 3.0,
    ends_half_line: b"",
    real_time: Some(RealTime { status: b'?', hold: b'!', reset: 0x18 }),
    drain: "G4P0.01",
    refused_when_down: None,
    end_wait: None,
    emergency: b"\x18",
    emergency_raw: b"\x18",
    says: &[],
    never_says: &[],
    unlock: Some(b"$H\n"),
};

impl Protocol {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Marlin, Self::RepRapFirmware, Self::Klipper, Self::Grbl];

    /// The protocol of a profile's `[link] protocol`; `None` for `"none"` and unknown words.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|protocol| protocol.name() == name)
    }

    /// Its row of the table.
    pub(crate) fn traits(self) -> &'static Traits {
        match self {
            Self::Marlin => &MARLIN,
            Self::RepRapFirmware => &REPRAPFIRMWARE,
            Self::Klipper => &KLIPPER,
            Self::Grbl => &GRBL,
        }
    }

    /// Whose words are understood at the other end.
    pub fn firmware(self) -> Firmware {
        self.traits().firmware
    }

    /// How its answers are worded.
    pub fn wording(self) -> Wording {
        self.traits().wording
    }

    /// The line that is answered once all motion has ended.
    pub fn drain(self) -> &'static str {
        self.traits().drain
    }

    /// The word of a profile.
    pub fn name(self) -> &'static str {
        self.traits().name
    }

    /// Whether lines carry a number and a checksum.
    pub fn numbered(self) -> bool {
        self.traits().numbered
    }
}

impl Traits {
    /// Whether the printer heats, fans, extrudes and says where it is by words of its own.
    pub(crate) fn is_printer(&self) -> bool {
        self.firmware.is_printer()
    }

    /// Whether `identity` is that of another firmware.
    pub(crate) fn is_other(&self, identity: &str) -> bool {
        !self.says.is_empty() && !self.says.iter().any(|word| identity.contains(word))
            || self.never_says.iter().any(|word| identity.contains(word))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What one column says of another: a row that breaks one of these could not be streamed to.
    #[test]
    fn the_rows_do_not_contradict_themselves() {
        for protocol in Protocol::ALL {
            let m = protocol.traits();
            assert_eq!(Protocol::named(m.name), Some(protocol));
            assert!(m.accounting != Accounting::Counter || (m.numbered && m.hello == Hello::SetCounter), "{m:?}");
            assert_eq!(m.accounting == Accounting::Status, m.real_time.is_some(), "{m:?}");
            // Proofs are M105, which only printers know.
            assert_eq!(m.accounting == Accounting::Status, !m.is_printer(), "{m:?}");
            // A line is numbered against what half of it would do; where it is not, a blank line is answered.
            assert_eq!(m.numbered, !m.ends_half_line.is_empty(), "{m:?}");
            assert!(!m.queues || m.serial, "{m:?}");
            assert!(m.emergency_raw.ends_with(b"M112\n") || m.real_time.is_some_and(|r| m.emergency == [r.reset]));
        }
        assert_eq!(Protocol::named("none"), None);
    }

    #[test]
    fn another_firmware_is_told_by_its_identity() {
        let says = [
            "FIRMWARE_NAME:Marlin 2.1",
            "FIRMWARE_NAME: RepRapFirmware for Duet",
            "FIRMWARE_NAME:Klipper",
            "FIRMWARE_NAME:Kalico FIRMWARE_VERSION:?",
        ];
        for (index, protocol) in [Protocol::Marlin, Protocol::RepRapFirmware, Protocol::Klipper].iter().enumerate() {
            let other: Vec<bool> = says.iter().map(|text| protocol.traits().is_other(text)).collect();
            assert_eq!(other, [0, 1, 2, 2].map(|i| i != index), "{protocol:?}");
        }
        assert!(!Protocol::Grbl.traits().is_other("[VER:1.1h]"));
    }
}
