//! How a wire is used: windows, patience, and how the head leaves the part.

use std::time::Duration;

use super::Time;
use super::protocol::Protocol;
use super::retreat::Retreat;

/// How the wire is used.
#[derive(Clone, Debug)]
pub struct SenderSettings {
    /// The firmware's protocol.
    pub protocol: Protocol,
    /// Whether a blank goes between a line's number and its command, as a few parsers need it.
    pub blank_after_number: bool,
    /// Most lines without an answer.
    pub window_lines: usize,
    /// Bits a second, for what is said of the wire's use; 0 where it has no speed of its own.
    pub baud: u32,
    /// The longest that the firmware leaves its receive buffer unread while its queue has room; zero where nobody knows.
    pub reads: Time,
    /// Most bytes that may lie in the firmware's receive buffer: as many as it holds, less a margin.
    pub window_bytes: usize,
    /// Blocks that the firmware's planner and queue hold: so many answered ones may not be executed.
    pub planner_blocks: u32,
    /// After this many lines a numbered M105 proves the count.
    pub prove_every: u32,
    /// Whether the printer has to say where it is at the end of each layer.
    pub prove_layers: bool,
    /// Without a word for this long, beyond what the motion in hand takes, the printer is asked.
    pub silence: Time,
    /// The same while a command is in hand that may take minutes.
    pub long_silence: Time,
    /// No progress for this long stops the print, even if the printer shows life (a wait for a person does not).
    pub no_progress: Time,
    /// Questions without an answer before the printer counts as mute.
    pub questions: u32,
    /// Refusals of one line before the wire counts as broken.
    pub refusals: u32,
    /// Numbers begin anew here; Marlin counts in 32 bits.
    pub renumber_at: i64,
    /// What the printer must call itself; `None` takes any.
    pub identity: Option<String>,
    /// Whether a line that the printer did not carry out as it is written is a pause.
    pub pauses: bool,
    /// The bed on which the print lies that is to be resumed: one that has cooled since lets go of it. `None` where there is none, or somebody has
    /// seen that the part holds.
    pub bed_was_c: Option<f64>,
    /// How the head leaves the part.
    pub retreat: Retreat,
    /// A number that no other host has: the printer repeats it, which proves that what it says is no answer to another.
    pub nonce: u64,
}

impl SenderSettings {
    /// What suits an ordinary printer of `protocol`.
    pub fn new(protocol: Protocol, retreat: Retreat) -> Self {
        let (window_lines, window_bytes) = protocol.traits().window;
        Self {
            protocol,
            blank_after_number: false,
            baud: 0,
            reads: Time::ZERO,
            window_lines,
            window_bytes,
            planner_blocks: 24,
            prove_every: 32,
            prove_layers: false,
            silence: Duration::from_secs(4),
            long_silence: Duration::from_secs(300),
            no_progress: Duration::from_secs(3600),
            questions: 10,
            refusals: 10,
            renumber_at: 2_000_000_000,
            identity: None,
            pauses: true,
            bed_was_c: None,
            retreat,
            nonce: 0,
        }
    }

    /// Whether the wire cannot fill the receive buffer in the time in which it is emptied at the latest.
    pub(super) fn never_full(&self) -> bool {
        let arrives = f64::from(self.baud) / 10.0 * self.reads.as_secs_f64();
        arrives > 0.0 && arrives <= self.window_bytes as f64
    }

    /// The same where the receive buffer has `bytes` and the firmware queues `lines`, as far as the protocol knows of either.
    #[must_use]
    pub fn with_buffers(mut self, bytes: usize, lines: usize) -> Self {
        let traits = self.protocol.traits();
        if traits.serial {
            self.window_bytes = bytes.saturating_sub(traits.margin);
        }
        if traits.queues {
            self.window_lines = lines.max(1);
        }
        self
    }
}
