//! Faults on purpose: at a line by its count, or at random lines from a seed.
//!
//! A line's count is its place among all lines that have arrived, from 1, the host's own questions included.

use std::time::Duration;

use super::Time;
use crate::geom::SplitMix64;

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SimFault {
    /// One bit of the line turns over.
    Corrupt,
    /// One byte is lost.
    LoseByte,
    /// The line is lost.
    Drop,
    /// Its newline is lost.
    Join,
    /// It arrives twice.
    Duplicate,
    /// Its second half and its newline are lost, as when a receive buffer runs over.
    Overflow,
    /// It is worked on only after a second.
    Slow,
    /// Its `ok` is lost.
    LoseOk,
    /// Its `ok` comes as `o`.
    MangleOk,
    /// Its `ok` comes in two reads.
    SplitOk,
    /// Its `ok` comes twice.
    DoubleOk,
    /// Its `ok` comes three seconds late.
    DelayOk,
    /// Noise comes before its `ok`.
    Noise,
    /// It is refused without `Resend` and `ok`.
    ErrorOnly,
    /// It is refused once with a number that is wrong.
    GarbledResend,
    /// A resend of the line that is next anyway.
    ResendNext,
    /// A resend of line 1.
    ResendOld,
    /// It, and every line after it, is refused for ever.
    EndlessResend,
    /// An `ok` that belongs to nothing.
    StrayOk,
    /// `start` in the middle of things, from nobody.
    FalseStart,
    /// A fatal error; the printer is dead.
    Fatal,
    /// An error that no host knows.
    StrangeError,
    /// No byte comes back any more.
    Mute,
    /// The firmware begins anew.
    Reset,
    /// The same after some seconds without power.
    PowerLoss,
    /// The USB plug is pulled for two seconds; the printer lives.
    HangUp,
}

/// Names as the command line has them.
pub const NAMES: [(&str, SimFault); 26] = [
    ("corrupt", SimFault::Corrupt),
    ("lose-byte", SimFault::LoseByte),
    ("drop", SimFault::Drop),
    ("join", SimFault::Join),
    ("duplicate", SimFault::Duplicate),
    ("rx-overflow", SimFault::Overflow),
    ("slow", SimFault::Slow),
    ("lose-ok", SimFault::LoseOk),
    ("mangle-ok", SimFault::MangleOk),
    ("split-ok", SimFault::SplitOk),
    ("double-ok", SimFault::DoubleOk),
    ("delay-ok", SimFault::DelayOk),
    ("noise", SimFault::Noise),
    ("error-only", SimFault::ErrorOnly),
    ("garbled-resend", SimFault::GarbledResend),
    ("resend-next", SimFault::ResendNext),
    ("resend-old", SimFault::ResendOld),
    ("endless-resend", SimFault::EndlessResend),
    ("stray-ok", SimFault::StrayOk),
    ("false-start", SimFault::FalseStart),
    ("fatal", SimFault::Fatal),
    ("strange-error", SimFault::StrangeError),
    ("mute", SimFault::Mute),
    ("reset", SimFault::Reset),
    ("power-loss", SimFault::PowerLoss),
    ("hang-up", SimFault::HangUp),
];

/// Faults after which a host that can count continues.
pub const SURVIVABLE: [SimFault; 17] = [
    SimFault::Corrupt,
    SimFault::LoseByte,
    SimFault::Drop,
    SimFault::Join,
    SimFault::Duplicate,
    SimFault::Overflow,
    SimFault::Slow,
    SimFault::LoseOk,
    SimFault::MangleOk,
    SimFault::SplitOk,
    SimFault::DoubleOk,
    SimFault::DelayOk,
    SimFault::Noise,
    SimFault::ErrorOnly,
    SimFault::GarbledResend,
    SimFault::ResendNext,
    SimFault::StrayOk,
];

/// When and which.
#[derive(Clone, Debug)]
pub struct Script {
    at: Vec<(u64, SimFault)>,
    random: Vec<SimFault>,
    probability: f64,
    numbers: SplitMix64,
    lines: u64,
    /// The last random cut.
    cut: u64,
}

/// Random cuts are so many lines apart, more than a window. Two in one window can cancel under XOR, once in 256 pairs: the
/// firmware then executes a line that was never sent, and no host can see it from the answers.
const CUTS_APART: u64 = 8;

impl Script {
    /// No faults.
    pub fn none() -> Self {
        Self::at(&[])
    }

    /// Faults in words: `NAME@LINE`, `NAME:PROBABILITY` or `random:PROBABILITY`; random ones are drawn from `seed`.
    ///
    /// # Errors
    ///
    /// The word that means nothing.
    pub fn read(faults: &[String], seed: u64) -> Result<Self, String> {
        let mut at = Vec::new();
        let mut chosen = Vec::new();
        let mut probability = 0.0_f64;
        for text in faults {
            let wrong = || text.clone();
            let named = |name: &str| NAMES.iter().find(|(n, _)| *n == name).map(|(_, fault)| *fault);
            if let Some((name, line)) = text.split_once('@') {
                at.push((line.parse().map_err(|_| wrong())?, named(name).ok_or_else(wrong)?));
            } else {
                let (name, p) = text.split_once(':').ok_or_else(wrong)?;
                let p = p.parse::<f64>().ok().filter(|p| (0.0..=1.0).contains(p)).ok_or_else(wrong)?;
                probability = probability.max(p);
                match name {
                    "random" => chosen.extend(SURVIVABLE),
                    name => chosen.push(named(name).ok_or_else(wrong)?),
                }
            }
        }
        let mut script = if chosen.is_empty() { Self::none() } else { Self::random(&chosen, probability, seed) };
        at.into_iter().for_each(|(line, fault)| script.add(line, fault));
        Ok(script)
    }

    /// Each fault once, at its line.
    pub fn at(faults: &[(u64, SimFault)]) -> Self {
        Self {
            at: faults.to_vec(),
            random: Vec::new(),
            probability: 0.0,
            numbers: SplitMix64::seeded(1),
            lines: 0,
            cut: 0,
        }
    }

    /// One of `faults` with `probability` at each line; the same lines for the same seed.
    pub fn random(faults: &[SimFault], probability: f64, seed: u64) -> Self {
        Self {
            at: Vec::new(),
            random: faults.to_vec(),
            probability,
            numbers: SplitMix64::seeded(seed),
            lines: 0,
            cut: 0,
        }
    }

    /// Adds one to a script.
    pub fn add(&mut self, line: u64, fault: SimFault) {
        self.at.push((line, fault));
    }

    pub(super) fn draw(&mut self) -> u64 {
        self.numbers.word()
    }

    /// Counts a line and says what befalls it.
    pub(super) fn next(&mut self) -> Option<SimFault> {
        self.lines += 1;
        if let Some(index) = self.at.iter().position(|(line, _)| *line == self.lines) {
            return Some(self.at.swap_remove(index).1);
        }
        if self.random.is_empty() || self.numbers.unit() >= self.probability {
            return None;
        }
        let index = self.draw() as usize % self.random.len();
        match self.random[index] {
            SimFault::Overflow if self.cut > 0 && self.lines - self.cut < CUTS_APART => None,
            fault => {
                self.cut = if fault == SimFault::Overflow { self.lines } else { self.cut };
                Some(fault)
            }
        }
    }

    /// Whether anything can still happen.
    pub(super) fn is_active(&self) -> bool {
        !self.at.is_empty() || !self.random.is_empty()
    }
}

/// What the wire makes of a line, its newline included.
pub(super) fn spoil(fault: Option<SimFault>, line: &mut Vec<u8>, draw: u64) {
    let body = line.len().saturating_sub(1).max(1);
    let place = (draw >> 8) as usize % body;
    match fault {
        Some(SimFault::Corrupt) => line[place] ^= 1 << (draw % 7),
        Some(SimFault::LoseByte) => {
            line.remove(place);
        }
        Some(SimFault::Drop) => line.clear(),
        Some(SimFault::Join) => {
            line.pop();
        }
        Some(SimFault::Duplicate) => line.extend_from_within(..),
        Some(SimFault::Overflow) => line.truncate(line.len() / 2),
        _ => {}
    }
}

/// How late a late `ok` is.
pub(super) const LATE: Time = Duration::from_secs(3);
/// How slow a slow line is.
pub(super) const SLOW: Time = Duration::from_secs(1);
