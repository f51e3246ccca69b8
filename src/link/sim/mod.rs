//! A simulated printer: the same wires as a real one, with motion, heat, and faults on purpose.
//!
//! A state machine with a passed-in clock, like the sender. Its texts are those of the firmwares: transcripts of these
//! (`fixtures/wire/README.md`) are played against it, and Python programs that share no code with it talk to it, so that it is not its own
//! witness.

mod cable;
mod faults;
mod grbl;
mod heat;
mod machine;
mod marlin;
mod named;
mod plain;
mod quirks;
mod said;

use std::collections::VecDeque;
use std::time::Duration;

pub use crate::motion::Axes;
pub use faults::{NAMES, SURVIVABLE, Script, SimFault};
pub use machine::MachineModel;
pub use named::{NamedQuirk, QUIRKS};
pub use quirks::Quirks;

use super::Time;
use super::protocol::Protocol;
use machine::{SimMachine, Took};

/// What it did.
#[derive(Clone, Debug, PartialEq)]
pub enum Logged {
    /// A block was accepted for execution, without number and checksum.
    Accepted(Vec<u8>),
    /// A move ended here.
    Pose(Axes),
    /// It began anew.
    Restarted,
    /// It died.
    Killed,
}

/// The simulated printer.
#[derive(Clone, Debug)]
pub struct Sim {
    protocol: Protocol,
    quirks: Quirks,
    machine: SimMachine,
    script: Script,
    /// Bytes on the cable with the time they arrive.
    cable: VecDeque<(Time, u8)>,
    cable_free: Time,
    half_line: Vec<u8>,
    rx: VecDeque<u8>,
    /// What of a line the main loop has read.
    line_in: Vec<u8>,
    line_at: Time,
    next_loop: Time,
    /// Bytes that found the receive buffer full.
    overflowed: u32,
    queue: VecDeque<Queued>,
    last_number: i64,
    out: Vec<u8>,
    taken: usize,
    /// Replies that are still to come.
    late: VecDeque<(Time, Vec<u8>)>,
    reply_free: Time,
    spoiled_ok: Option<SimFault>,
    slow_until: Time,
    now: Time,
    busy_next: Time,
    report_next: Option<Time>,
    report_every: Time,
    heating: Option<bool>,
    person: bool,
    alarm: bool,
    latched: u32,
    reports: u32,
    dead: bool,
    mute: bool,
    endless: bool,
    garble: bool,
    off_until: Option<Time>,
    hang_up: bool,
    logging: bool,
    log: Vec<(Time, Logged)>,
}

#[derive(Clone, Debug)]
struct Queued {
    block: Vec<u8>,
    number: Option<i64>,
    begun: bool,
}

impl Sim {
    /// A printer just switched on: its greeting is waiting to be read.
    pub fn new(protocol: Protocol, model: MachineModel, quirks: Quirks, script: Script) -> Self {
        let clamps = protocol == Protocol::Marlin;
        let mut sim = Self {
            protocol,
            machine: SimMachine::new(model, clamps, protocol.firmware()),
            quirks,
            script,
            cable: VecDeque::new(),
            cable_free: Time::ZERO,
            half_line: Vec::new(),
            rx: VecDeque::new(),
            line_in: Vec::new(),
            line_at: Time::ZERO,
            next_loop: Time::ZERO,
            overflowed: 0,
            queue: VecDeque::new(),
            last_number: 0,
            out: Vec::new(),
            taken: 0,
            late: VecDeque::new(),
            reply_free: Time::ZERO,
            spoiled_ok: None,
            slow_until: Time::ZERO,
            now: Time::ZERO,
            busy_next: Time::ZERO,
            report_next: None,
            report_every: Time::ZERO,
            heating: None,
            person: false,
            alarm: false,
            latched: 0,
            reports: 0,
            dead: false,
            mute: false,
            endless: false,
            garble: false,
            off_until: None,
            hang_up: false,
            logging: true,
            log: Vec::new(),
        };
        sim.greet();
        sim
    }

    /// Takes bytes from the host.
    pub fn receive(&mut self, now: Time, bytes: &[u8]) {
        self.advance(now);
        if self.off_until.is_some() {
            return;
        }
        if self.quirks.baud > 0 || !self.quirks.latency.is_zero() {
            let each = self.byte_time();
            for &byte in bytes {
                self.cable_free = self.cable_free.max(now + self.quirks.latency) + each;
                self.cable.push_back((self.cable_free, byte));
            }
        } else {
            self.arrive(bytes);
        }
        self.work();
    }

    /// Lets time pass.
    pub fn advance(&mut self, now: Time) {
        while let Some(wake) = self.next_wake().filter(|w| *w <= now) {
            self.now = self.now.max(wake);
            self.step();
        }
        self.now = self.now.max(now);
        self.step();
    }

    fn step(&mut self) {
        let now = self.now;
        if let Some(until) = self.off_until {
            if now < until {
                return;
            }
            self.off_until = None;
            self.greet();
        }
        let mut arrived = Vec::new();
        while self.cable.front().is_some_and(|(at, _)| *at <= now) {
            arrived.extend(self.cable.pop_front().map(|(_, byte)| byte));
        }
        if !arrived.is_empty() {
            self.arrive(&arrived);
        }
        self.work();
        self.deliver();
    }

    /// Motion, commands and reports, as far as they go now.
    fn work(&mut self) {
        let mut ended = Vec::new();
        let logging = self.logging;
        self.machine.planner.advance(self.now, |at, axes| {
            if logging {
                ended.push((at, Logged::Pose(*axes)));
            }
        });
        self.log.extend(ended);
        if self.dead
            && self.protocol == Protocol::RepRapFirmware
            && memchr::memmem::find(self.rx.make_contiguous(), b"M999").is_some()
        {
            self.restart(Duration::from_millis(500));
        }
        if self.dead || self.now < self.slow_until {
            return;
        }
        match self.protocol {
            Protocol::Marlin => self.work_marlin(),
            Protocol::Grbl => self.work_grbl(),
            Protocol::RepRapFirmware | Protocol::Klipper => self.work_plain(),
        }
        self.report();
    }

    /// When something happens by itself.
    pub fn next_wake(&self) -> Option<Time> {
        if let Some(until) = self.off_until {
            return Some(until);
        }
        let waits = self.machine_wait();
        let slow = (self.slow_until > self.now).then_some(self.slow_until);
        let late = self.late.front().map(|(at, _)| *at);
        let cable = self.cable.front().map(|(at, _)| *at);
        let busy = (self.quirks.busy && !self.queue.is_empty() && !self.dead).then_some(self.busy_next);
        let turns = !self.quirks.loop_time.is_zero() && !self.dead && self.has_lines();
        let turn = turns.then_some(self.next_loop);
        let all = [self.machine.planner.wake(), waits, slow, late, cable, busy, self.report_next, turn];
        all.into_iter().flatten().filter(|t| *t > self.now).min()
    }

    /// Whether only the clock is waited for: nothing has arrived that is not yet done.
    pub fn is_idle(&self) -> bool {
        self.queue.is_empty() && self.rx.is_empty() && self.cable.is_empty() && self.machine.planner.is_idle()
    }

    /// Whether lines have arrived that are not yet dealt with.
    pub fn has_lines(&self) -> bool {
        !self.queue.is_empty() || !self.rx.is_empty()
    }

    /// Bytes for the host.
    pub fn pending(&self) -> &[u8] {
        &self.out[self.taken..]
    }

    /// The host has taken `count` of [`Sim::pending`].
    pub fn took(&mut self, count: usize) {
        self.taken = (self.taken + count).min(self.out.len());
        if self.taken == self.out.len() {
            self.out.clear();
            self.taken = 0;
        }
    }

    /// Whether the plug was pulled since the last call.
    pub fn take_hang_up(&mut self) -> bool {
        std::mem::take(&mut self.hang_up)
    }

    /// The host has gone, or the plug: bytes under way are lost.
    pub fn unplugged(&mut self) {
        self.out.clear();
        self.taken = 0;
        self.cable.clear();
        self.late.clear();
        self.half_line.clear();
    }

    /// Power off for `time`; then the greeting comes again.
    pub fn restart(&mut self, time: Time) {
        self.machine.restart(self.now);
        self.queue.clear();
        self.rx.clear();
        self.line_in.clear();
        self.cable.clear();
        self.half_line.clear();
        self.late.clear();
        self.last_number = 0;
        (self.heating, self.person, self.dead, self.mute, self.endless) = (None, false, false, false, false);
        self.spoiled_ok = None;
        self.report_next = None;
        self.alarm = false;
        self.off_until = Some(self.now + time);
        self.note(Logged::Restarted);
    }

    fn die(&mut self) {
        self.machine.kill(self.now);
        self.dead = true;
        self.note(Logged::Killed);
    }

    /// What happened since the last call.
    pub fn take_log(&mut self) -> Vec<(Time, Logged)> {
        std::mem::take(&mut self.log)
    }

    /// Keeps no log.
    pub fn without_log(mut self) -> Self {
        self.logging = false;
        self
    }

    /// Where the axes are: X, Y, Z, tilt, rotation (as words), E.
    pub fn position(&self, now: Time) -> Axes {
        self.machine.planner.position(now)
    }

    /// How often the planner ran dry in the middle of motion.
    pub fn starved(&self) -> u32 {
        self.machine.planner.starved
    }

    /// Bytes that found the receive buffer full, and were lost.
    pub fn overflowed(&self) -> u32 {
        self.overflowed
    }

    /// Targets that were cut to the limits.
    pub fn clamped(&self) -> u32 {
        self.machine.clamped
    }

    /// Nozzle and bed, degrees Celsius.
    pub fn temperatures(&self, now: Time) -> [f64; 2] {
        [self.machine.nozzle.at(now), self.machine.bed.at(now)]
    }

    fn note(&mut self, what: Logged) {
        if self.logging {
            self.log.push((self.now, what));
        }
    }

    fn greet(&mut self) {
        match self.protocol {
            Protocol::Marlin => {
                self.say("start");
                self.say("Marlin bugfix-2.1.x");
                self.say("echo: Last Updated: 2024-09-29 | Author: (none, default config)");
                self.say("echo:Hardcoded Default SenderSettings Loaded");
            }
            Protocol::Grbl => self.greet_grbl(),
            Protocol::RepRapFirmware => self.say("RepRapFirmware for trunnion is up and running."),
            Protocol::Klipper => self.say("// Klipper state: Ready"),
        }
    }

    fn machine_wait(&self) -> Option<Time> {
        self.machine.waits_until()
    }
}

/// SenderSettings while it runs, for tests and the command line.
impl Sim {
    /// Faults from now on; lines count from here.
    pub fn set_script(&mut self, script: Script) {
        self.script = script;
    }

    /// Heaters this many times as fast as real ones.
    pub fn set_heat_factor(&mut self, factor: f64) {
        self.machine.set_heat_factor(factor);
    }

    /// How long a person takes.
    pub fn set_person(&mut self, time: Time) {
        self.machine.model.person = time;
    }
}
