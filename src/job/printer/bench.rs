//! The simulated printer in real time, at a pseudo-terminal or a TCP address.

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::error::PrinterError;
use crate::link::Time;
use crate::link::serial::{Heard, Port};
use crate::link::sim::{Logged, Sim};
use crate::world::World;

/// How long a pulled plug stays out.
const UNPLUGGED: Duration = Duration::from_secs(2);
/// The longest sleep, so that an interrupt is seen.
const NAP: Duration = Duration::from_millis(50);
/// At full speed: without a byte for this long the clock jumps.
const QUIET: Duration = Duration::from_millis(1);
/// At full speed: so often the clock jumps for lines in hand before the port is looked at again.
const JUMPS: u32 = 64;

/// A simulated printer at a place where hosts can connect.
pub struct Bench<'a> {
    sim: Sim,
    log: Option<&'a mut dyn Write>,
    speed: Option<f64>,
    world: &'a World<'a>,
    start: Duration,
    skipped: Duration,
}

impl<'a> Bench<'a> {
    /// `sim` at `speed` simulated seconds a second, `None` for no waiting at all; `log` gets every accepted line and the pose
    /// after every move.
    pub fn new(sim: Sim, speed: Option<f64>, log: Option<&'a mut dyn Write>, world: &'a World<'a>) -> Self {
        Self { sim, log, speed, world, start: world.clock.now(), skipped: Duration::ZERO }
    }

    /// Serves one host after the other at `link` until `ended`; `ready` hears where, each time there is a place.
    ///
    /// # Errors
    ///
    /// [`PrinterError::Port`] and [`PrinterError::Link`] where the place cannot be had, [`PrinterError::Log`] where the log takes nothing.
    pub fn serve(mut self, link: &str, ended: &AtomicBool, ready: impl FnMut(&str)) -> Result<(), PrinterError> {
        let result = self.serve_all(link, ended, ready);
        self.write_log()?;
        result
    }

    fn now(&self) -> Time {
        self.world.clock.now().saturating_sub(self.start).mul_f64(self.speed.unwrap_or(1.0)) + self.skipped
    }

    fn serve_all(&mut self, link: &str, ended: &AtomicBool, mut ready: impl FnMut(&str)) -> Result<(), PrinterError> {
        loop {
            let server = self.world.ports.serve(link)?;
            ready(&server.place());
            loop {
                if ended.load(Ordering::Relaxed) {
                    return Ok(());
                }
                let mut port = match server.connect() {
                    Ok(port) => port,
                    Err(e) if e.kind() == std::io::ErrorKind::WouldBlock => {
                        self.world.clock.sleep(NAP);
                        continue;
                    }
                    Err(source) => return Err(PrinterError::Link { link: link.to_owned(), source }),
                };
                let unplugged = self.talk(&mut port, ended)?;
                if unplugged {
                    break;
                }
            }
            self.sim.unplugged();
            drop(server);
            self.world.clock.sleep(UNPLUGGED);
        }
    }

    /// One host; `true` where the plug was pulled, `false` where the host has left.
    fn talk(&mut self, port: &mut Port, ended: &AtomicBool) -> Result<bool, PrinterError> {
        while !ended.load(Ordering::Relaxed) {
            self.sim.advance(self.now());
            self.hurry();
            let now = self.now();
            let full = !self.send(port);
            self.write_log()?;
            if self.sim.take_hang_up() {
                return Ok(true);
            }
            match port.read(self.nap(now), full) {
                Heard::Bytes(bytes) => {
                    let now = self.now();
                    self.sim.receive(now, bytes);
                }
                Heard::Gone(_) => {
                    self.sim.unplugged();
                    return Ok(false);
                }
                Heard::Nothing if full => {}
                Heard::Nothing => self.skip(),
            }
        }
        Ok(false)
    }

    /// At full speed all lines in hand are dealt with, so that one write answers them.
    fn hurry(&mut self) {
        let mut jumps = 0;
        while self.speed.is_none() && self.sim.has_lines() && jumps < JUMPS {
            self.skip();
            self.sim.advance(self.now());
            jumps += 1;
        }
    }

    /// Hands over what is to be said; whether all went.
    fn send(&mut self, port: &mut Port) -> bool {
        let count = port.write(self.sim.pending());
        self.sim.took(count);
        self.sim.pending().is_empty()
    }

    fn nap(&self, now: Time) -> Duration {
        let wake = self.sim.next_wake().map_or(NAP, |wake| wake.saturating_sub(now));
        match self.speed {
            Some(speed) => wake.div_f64(speed).clamp(Duration::from_micros(20), NAP),
            None if self.sim.is_idle() => NAP,
            None => QUIET,
        }
    }

    /// At full speed the clock jumps to what happens next.
    fn skip(&mut self) {
        if self.speed.is_some() || self.sim.is_idle() {
            return;
        }
        if let Some(wake) = self.sim.next_wake() {
            let now = self.now();
            self.skipped += wake.saturating_sub(now);
        }
    }

    fn write_log(&mut self) -> Result<(), PrinterError> {
        let entries = self.sim.take_log();
        let Some(file) = &mut self.log else { return Ok(()) };
        let mut text = Vec::new();
        for (at, logged) in entries {
            let _ = write!(text, "{:.6} ", at.as_secs_f64());
            match logged {
                Logged::Accepted(block) => {
                    text.extend_from_slice(b"line ");
                    text.extend_from_slice(&block);
                }
                Logged::Pose([x, y, z, a, c, e]) => {
                    let _ = write!(text, "pose {x:.4} {y:.4} {z:.4} {a:.4} {c:.4} {e:.5}");
                }
                Logged::Restarted => text.extend_from_slice(b"restarted"),
                Logged::Killed => text.extend_from_slice(b"killed"),
            }
            text.push(b'\n');
        }
        file.write_all(&text).map_err(|source| PrinterError::Log { source })
    }
}
