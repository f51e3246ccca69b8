//! Which setting of the firmware holds a print back, where its planner runs dry in the middle of motion.
//!
//! Only a firmware that says so can be believed: `P` of ADVANCED_OK is the room in its planner, and a planner that has nothing but the
//! move that is answered had run dry. What the sender waited for at that moment is what held it back.

use super::Time;
use crate::link::reply::BufferRoom;

/// So often the planner must have run dry before it is told while the print goes on.
const WORTH_A_WORD: u32 = 32;

/// What the sender waits for, while it has lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Held {
    /// Nothing: the wire and what lies behind it.
    #[default]
    Wire,
    /// The firmware's queue of commands.
    Lines,
    /// Its receive buffer.
    Bytes,
}

/// Moves that find the planner dry within this are one stretch.
const STRETCH: Time = Time::from_millis(250);

/// What holds a print back.
#[derive(Clone, Debug, Default)]
pub(super) struct Brake {
    held: Held,
    /// The most room that the planner ever had: all of it.
    planner: usize,
    /// How often it had run dry, by what was waited for: wire, queue, receive buffer.
    dry: [u32; 3],
    told: bool,
    /// All that went out, and what had when the planner last was dry, and when that was.
    bytes: u64,
    last: Option<(Time, u64)>,
    /// Seconds of stretches in which it was dry again and again, and bytes in them.
    stretches: (f64, u64),
}

/// How a wire is used: bytes a second, and what it carries; 0 where it has no speed of its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wire {
    pub(super) baud: u32,
    pub(super) window_bytes: usize,
    pub(super) window_lines: usize,
}

impl Brake {
    /// A line is there and has to wait: for the queue, or for the receive buffer.
    pub(super) fn holds(&mut self, lines: bool) {
        self.held = if lines { Held::Lines } else { Held::Bytes };
    }

    /// A line went out whole.
    pub(super) fn sends(&mut self, bytes: usize) {
        self.held = Held::Wire;
        self.bytes += bytes as u64;
    }

    /// A line is cut where the receive buffer is full.
    pub(super) fn cuts(&mut self) {
        self.held = Held::Bytes;
    }

    /// An `ok` with the planner's room; whether it answers a move that takes time. `true` where it is worth a word now.
    pub(super) fn answered(&mut self, now: Time, room: BufferRoom, moves: bool) -> bool {
        self.planner = self.planner.max(room.planner);
        // Its own move is in there, and nothing else.
        if !moves || self.planner < 2 || room.planner + 1 < self.planner {
            return false;
        }
        if let Some((at, bytes)) = self.last.replace((now, self.bytes)).filter(|(at, _)| now < *at + STRETCH) {
            self.stretches.0 += now.saturating_sub(at).as_secs_f64();
            self.stretches.1 += self.bytes - bytes;
        }
        self.dry[self.held as usize] += 1;
        self.times() >= WORTH_A_WORD && !std::mem::replace(&mut self.told, true)
    }

    /// How often the planner had run dry.
    pub(super) fn times(&self) -> u32 {
        self.dry.iter().sum()
    }

    /// Share of the wire that was used while the planner was dry; `None` without a speed.
    fn share(&self, baud: u32) -> Option<f64> {
        let (seconds, bytes) = self.stretches;
        let share = bytes as f64 * 10.0 / f64::from(baud) / seconds;
        // A pseudo-terminal and native USB are faster than the speed they were opened with.
        (baud > 0 && seconds > 0.0 && share <= 1.02).then_some(share)
    }

    /// In words; `None` where the planner hardly ever ran dry.
    pub(super) fn words(&self, wire: Wire) -> Option<String> {
        if self.times() < WORTH_A_WORD {
            return None;
        }
        let [on_wire, lines, bytes] = self.dry;
        let share = self.share(wire.baud);
        let used = share.map_or(String::new(), |s| format!(" ({:.0} % of {} baud used)", s * 100.0, wire.baud));
        // A window is full as well where the wire is.
        let full = share.is_some_and(|s| s > 0.93);
        let what = if full || on_wire >= lines.max(bytes) {
            format!("the link{used}: a higher baud, native USB or coarser segments help")
        } else if bytes >= lines {
            format!(
                "its receive buffer of {} bytes{used}: a firmware with a larger RX_BUFFER_SIZE ([link] buffer) helps, and an adapter that \
                 answers faster (Linux: setserial PORT low_latency)",
                wire.window_bytes
            )
        } else {
            format!("its queue of {} commands{used}: a firmware with a larger BUFSIZE helps", wire.window_lines)
        };
        Some(format!("the printer's planner buffer ran empty {} times; bottleneck: {what}", self.times()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIRE: Wire = Wire { baud: 250_000, window_bytes: 126, window_lines: 32 };

    fn dry(brake: &mut Brake, times: u32, every_ms: u64, held: fn(&mut Brake)) -> u32 {
        let (dry, begun) = (BufferRoom { planner: 14, commands: 31 }, u64::from(brake.times()));
        let mut at = |i| {
            brake.sends(50);
            held(brake);
            u32::from(brake.answered(Time::from_millis(i), dry, true))
        };
        (begun..begun + u64::from(times)).map(|i| at(i * every_ms)).sum()
    }

    #[test]
    fn what_is_waited_for_while_the_planner_is_dry_is_named_once() {
        let mut brake = Brake::default();
        brake.answered(Time::ZERO, BufferRoom { planner: 15, commands: 31 }, false);
        // 50 bytes in each 4 ms are half of what 250,000 baud carry.
        assert_eq!((dry(&mut brake, 31, 4, Brake::cuts), brake.words(WIRE)), (0, None));
        assert_eq!(dry(&mut brake, 40, 4, Brake::cuts), 1);
        let said = brake.words(WIRE).unwrap();
        assert!(said.contains("71 times") && said.contains("receive buffer of 126 bytes (50 % of 250000"), "{said}");
        dry(&mut brake, 80, 4, |brake| brake.holds(true));
        let said = brake.words(WIRE).unwrap();
        assert!(said.contains("151 times") && said.contains("queue of 32 commands"), "{said}");
    }

    #[test]
    fn a_full_wire_is_what_holds_back_whatever_else_is_full() {
        let mut brake = Brake::default();
        brake.answered(Time::ZERO, BufferRoom { planner: 15, commands: 31 }, false);
        dry(&mut brake, 100, 2, Brake::cuts);
        let said = brake.words(WIRE).unwrap();
        assert!(said.contains("the link (100 % of 250000 baud used)"), "{said}");
        // A pseudo-terminal carries more than it is opened with.
        let said = brake.words(Wire { baud: 115_200, ..WIRE }).unwrap();
        assert!(said.contains("receive buffer of 126 bytes: "), "{said}");
    }

    #[test]
    fn a_planner_with_moves_or_without_a_word_is_never_dry() {
        let mut brake = Brake::default();
        for planner in [15, 13, 0, 7] {
            assert!(!brake.answered(Time::ZERO, BufferRoom { planner, commands: 31 }, planner < 15));
        }
        assert_eq!((brake.times(), brake.words(WIRE)), (0, None));
        // One that never says that it is empty says nothing.
        let mut full = Brake::default();
        assert!(!full.answered(Time::ZERO, BufferRoom { planner: 0, commands: 31 }, true) && full.times() == 0);
    }
}
