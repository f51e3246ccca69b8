//! Whether a link carries a program in the time that the program takes.
//!
//! A line on a serial wire costs ten bits a byte. What a program needs is taken over stretches of one planner's worth of
//! blocks: shorter bursts are hidden by the planner.

use super::program::Program;
use super::protocol::Protocol;
use super::wire::numbered_len;

/// A stretch of a program that a link is too slow for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooSlow {
    /// Lines a second that the densest stretch needs.
    pub needed: f64,
    /// Lines a second that the link carries there.
    pub carried: f64,
    /// Bytes a line there.
    pub bytes: f64,
    /// Mean length of a segment there, mm of tip travel at `speed`; 0 where nothing moves.
    pub segment_mm: f64,
    /// Mean speed there, mm/s.
    pub speed: f64,
    /// The densest stretch's first line in the file.
    pub file_line: u32,
    /// Seconds of the program that are too dense.
    pub seconds: f64,
    /// Seconds of the whole program.
    pub of_seconds: f64,
    /// The link's speed.
    pub baud: u32,
}

impl std::fmt::Display for TooSlow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { needed, carried, bytes, segment_mm, speed, file_line, baud, .. } = self;
        write!(
            f,
            "from line {file_line}, {segment_mm:.2} mm segments at {speed:.0} mm/s need {needed:.0} lines/s, but this link carries \
             {carried:.0} ({baud} baud, {bytes:.0} bytes a line); the printer will slow down and may leave blobs for {:.0} of {:.0} s; \
             use native USB, a higher baud, or coarser segments",
            self.seconds, self.of_seconds
        )
    }
}

/// Blocks that a firmware's planner holds ahead.
const STRETCH: u32 = 16;

/// Whether `program` needs more lines a second than a wire of `baud` carries; `None` where it carries all of them.
pub fn too_slow(program: &Program, protocol: Protocol, baud: u32) -> Option<TooSlow> {
    let per_second = f64::from(baud) / 10.0;
    let wire = |i: u32| {
        let block = program.block(i);
        if protocol.numbered() { numbered_len(i64::from(i) + 1, block) - 1 } else { block.len() + 1 }
    };
    let mut worst: Option<TooSlow> = None;
    let mut dense = 0.0;
    let all: f64 = (0..program.len()).map(|block| program.seconds(block)).sum();
    let mut start = 0;
    while start < program.len() {
        let stretch = start..program.len().min(start + STRETCH);
        let waits = stretch.clone().find(|&i| program.waits(i));
        // Settings in front of the motion starve nobody, and a command that waits empties the planner on purpose.
        if program.seconds(start) == 0.0 || waits.is_some() {
            start = waits.unwrap_or(start) + 1;
            continue;
        }
        start = stretch.end;
        let took: f64 = stretch.clone().map(|i| program.seconds(i)).sum();
        let bytes: usize = stretch.clone().map(wire).sum();
        let lines = stretch.len() as f64;
        // Shorter bursts are hidden by the planner, and a stretch with hardly any motion is settings.
        let moving = stretch.clone().filter(|&i| program.seconds(i) > 0.0).count();
        let full = stretch.len() == STRETCH as usize && moving * 2 >= stretch.len();
        if !full || bytes as f64 / per_second <= took {
            continue;
        }
        dense += took;
        let (needed, bytes_each) = (lines / took, bytes as f64 / lines);
        if worst.is_none_or(|w| needed > w.needed) {
            let speed = speed_of(program, stretch.clone());
            let file_line = program.file_line(stretch.start);
            worst = Some(TooSlow {
                needed,
                carried: per_second / bytes_each,
                bytes: bytes_each,
                segment_mm: speed * took / moving as f64,
                speed,
                file_line,
                seconds: 0.0,
                of_seconds: 0.0,
                baud,
            });
        }
    }
    worst.map(|w| TooSlow { seconds: dense, of_seconds: all, ..w })
}

/// Speed of the last F at or before the stretch's middle, mm/s.
fn speed_of(program: &Program, stretch: std::ops::Range<u32>) -> f64 {
    let feed = |i: u32| {
        let block = program.block(i);
        let at = memchr::memchr(b'F', block)?;
        std::str::from_utf8(&block[at + 1..]).ok()?.parse::<f64>().ok()
    };
    let found = (0..stretch.end).rev().take(10_000).find_map(feed);
    found.unwrap_or(f64::INFINITY).min(program.max_feed()) / 60.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::testing::rules;

    fn program(segment: f64, feed: u32) -> Program {
        behind("", segment, feed)
    }

    fn behind(start: &str, segment: f64, feed: u32) -> Program {
        let mut text = format!("{start}G1 X0 Y0 Z10 F{feed}\n");
        for i in 1..400 {
            text += &format!("G1 X{:.3} Y50.125 Z10.205 A31.125 C-120.245 E0.00415\n", f64::from(i) * segment);
        }
        Program::read(text.as_bytes(), &rules(Protocol::Marlin)).unwrap()
    }

    /// 60 mm/s at 0.1 mm is 600 lines/s.
    #[test]
    fn tenth_millimetre_segments_at_60_mm_s_need_600_lines_a_second() {
        let slow = too_slow(&program(0.1, 3600), Protocol::Marlin, 250_000).unwrap();
        assert!((slow.needed - 600.0).abs() < 1.0 && (slow.segment_mm - 0.1).abs() < 0.005, "{slow:?}");
        assert!((slow.carried - 25_000.0 / slow.bytes).abs() < 1e-6 && slow.carried < 600.0, "{slow:?}");
        assert!(["0.10 mm", "60 mm/s", "600 lines/s"].iter().all(|fact| slow.to_string().contains(fact)), "{slow}");
        // SenderSettings in front of the motion are none of it.
        let set = "G21\nG90\nM83\nG28\nM109 S200\nM106 S255\nM204 P800\n";
        let behind = too_slow(&behind(set, 0.1, 3600), Protocol::Marlin, 250_000).unwrap();
        assert!((behind.needed - 600.0).abs() < 1.0 && (behind.bytes - slow.bytes).abs() < 2.0, "{behind:?}");
        assert_eq!(too_slow(&program(0.1, 3600), Protocol::Marlin, 2_000_000), None);
        assert_eq!(too_slow(&program(1.0, 3600), Protocol::Marlin, 115_200), None);
    }
}
