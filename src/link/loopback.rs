//! A sender and a simulated printer joined in virtual time: for tests, benches, and `send --dry-run`.

use std::time::Duration;

use super::Time;
use super::sender::{Notice, Outcome, Sender};
use super::sim::Sim;

/// How long a pulled plug stays out.
const UNPLUGGED: Time = Duration::from_secs(2);

/// Both ends and the clock between them.
#[derive(Clone, Debug)]
pub struct Loopback {
    /// The host's side.
    pub sender: Sender,
    /// The printer.
    pub sim: Sim,
    now: Time,
    back_at: Option<Time>,
    events: Vec<Notice>,
    wire: Option<Vec<(Time, Heading, Vec<u8>)>>,
}

/// Which way bytes went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heading {
    /// To the printer.
    Out,
    /// To the host.
    Back,
}

impl Loopback {
    /// Joins the two at time 0.
    pub fn new(sender: Sender, sim: Sim) -> Self {
        Self { sender, sim, now: Time::ZERO, back_at: None, events: Vec::new(), wire: None }
    }

    /// Joins a host that resumes to a printer that has worked until `now`.
    pub fn resumed(sender: Sender, sim: Sim, now: Time) -> Self {
        Self { now, ..Self::new(sender, sim) }
    }

    /// The clock.
    pub fn now(&self) -> Time {
        self.now
    }

    /// Keeps every byte from now on, with its time and way.
    pub fn record(&mut self) {
        self.wire = Some(Vec::new());
    }

    /// What [`Loopback::record`] kept; empty without it.
    pub fn recorded(&self) -> &[(Time, Heading, Vec<u8>)] {
        self.wire.as_deref().unwrap_or_default()
    }

    /// Everything the sender has said so far.
    pub fn events(&self) -> &[Notice] {
        &self.events
    }

    /// Runs until the sender has ended and its last bytes are delivered, or until the clock reaches `bound`, which is
    /// then `None`.
    pub fn run(&mut self, bound: Time) -> Option<Outcome> {
        while self.now < bound {
            let moved = self.turn();
            if self.sender.outcome().is_some() && self.sender.pending().is_empty() {
                return self.sender.outcome().cloned();
            }
            if !moved {
                self.now = self.next().min(bound);
            }
        }
        None
    }

    /// Runs up to `time`, or until the sender has ended.
    pub fn run_to(&mut self, time: Time) {
        while self.now < time && self.sender.outcome().is_none() {
            if !self.turn() {
                self.now = self.next().min(time);
            }
        }
    }

    /// One exchange at the same time; whether a byte went either way.
    fn turn(&mut self) -> bool {
        self.sender.poll(self.now);
        while let Some(event) = self.sender.next_event() {
            self.events.push(event);
        }
        if self.sim.take_hang_up() {
            self.sender.lost(self.now);
            self.sim.unplugged();
            self.back_at = Some(self.now + UNPLUGGED);
        }
        self.sim.advance(self.now);
        if let Some(at) = self.back_at {
            self.sim.took(usize::MAX);
            if self.now < at {
                return false;
            }
            self.back_at = None;
            self.sender.reconnected(self.now);
            return true;
        }
        if let Some(wire) = &mut self.wire {
            let bytes = self.sender.pending();
            wire.extend((!bytes.is_empty()).then(|| (self.now, Heading::Out, bytes.to_vec())));
        }
        let out = self.sender.pending().len();
        self.sim.receive(self.now, self.sender.pending());
        self.sender.took(out);
        if let Some(wire) = &mut self.wire {
            let bytes = self.sim.pending();
            wire.extend((!bytes.is_empty()).then(|| (self.now, Heading::Back, bytes.to_vec())));
        }
        let back = self.sim.pending().len();
        self.sender.receive(self.now, self.sim.pending());
        self.sim.took(back);
        out + back > 0
    }

    fn next(&self) -> Time {
        let wakes = [self.sender.wake(self.now), self.sim.next_wake(), self.back_at];
        wakes.into_iter().flatten().filter(|t| *t > self.now).min().unwrap_or(self.now + Duration::from_secs(1))
    }
}
