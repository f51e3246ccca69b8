//! `trunnion simulate`: the simulated printer behind a pseudo-terminal or a TCP address.

use std::fs::File;
use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::args::Simulate as Verb;
use super::{Console, Failure, load, printer};
use crate::link::Time;
use crate::link::serial::{Heard, Port, Server};
use crate::link::sim::{Fault, Logged, NAMES, SURVIVABLE, Script, Sim};

/// How long a pulled plug stays out.
const UNPLUGGED: Duration = Duration::from_secs(2);
/// The longest sleep, so that an interrupt is seen.
const NAP: Duration = Duration::from_millis(50);
/// At full speed: without a byte for this long the clock jumps.
const QUIET: Duration = Duration::from_millis(1);
/// At full speed: so often the clock jumps for lines in hand before the port is looked at again.
const JUMPS: u32 = 64;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let machine = load::profile(&args.machine.profile)?;
    let mut quirks = printer::quirks(&machine.profile)?;
    apply_quirks(&mut quirks, args)?;
    let mut model = printer::model(&machine.profile)?;
    model.heat_factor = args.heat;
    let script = script(args)?;
    let sim = Sim::new(printer::protocol(&machine.profile)?, model, quirks, script);
    let log = match &args.log {
        Some(path) => Some(File::create(path).map_err(|source| Failure::Write { path: path.clone(), source })?),
        None => None,
    };
    let ended = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&ended);
    let _ = ctrlc::set_handler(move || seen.store(true, Ordering::Relaxed));
    let mut bench = Bench { sim, log, speed: speed(&args.speed)?, start: Instant::now(), skipped: Duration::ZERO };
    let result = bench.serve(args, console, &ended);
    bench.write_log()?;
    result
}

fn speed(text: &str) -> Result<Option<f64>, Failure> {
    if text == "max" {
        return Ok(None);
    }
    let parsed = text.parse::<f64>().ok().filter(|v| *v > 0.0 && v.is_finite());
    parsed.map(Some).ok_or_else(|| Failure::Usage(format!("--speed {text}: give a factor above 0, or max")))
}

fn apply_quirks(quirks: &mut crate::link::sim::Quirks, args: &Verb) -> Result<(), Failure> {
    quirks.baud = args.baud.unwrap_or(0);
    for quirk in &args.quirk {
        match quirk.as_str() {
            "advanced-ok" => quirks.advanced_ok = true,
            "no-ok-after-resend" => quirks.ok_after_resend = false,
            "refuses-doubles" => quirks.silent_duplicates = false,
            "no-emergency-parser" => quirks.emergency_parser = false,
            "no-busy" => quirks.busy = false,
            "latches-errors" => quirks.latches_errors = true,
            "three-axes" => quirks.axes = 3,
            other => {
                return Err(Failure::Usage(format!(
                    "--quirk {other}: known are advanced-ok, no-ok-after-resend, refuses-doubles, no-emergency-parser, no-busy, \
                     latches-errors, three-axes"
                )));
            }
        }
    }
    Ok(())
}

/// `corrupt@57`, or `corrupt:0.01`, or `random:0.05`.
fn script(args: &Verb) -> Result<Script, Failure> {
    let mut script = Script::none();
    let mut chosen = Vec::new();
    let mut probability = 0.0_f64;
    for text in &args.fault {
        let wrong = || {
            let names: Vec<&str> = NAMES.iter().map(|(name, _)| *name).collect();
            Failure::Usage(format!(
                "--fault {text}: give NAME@LINE, NAME:PROBABILITY or random:PROBABILITY; names: {}",
                names.join(", ")
            ))
        };
        let named = |name: &str| NAMES.iter().find(|(n, _)| *n == name).map(|(_, fault)| *fault);
        if let Some((name, line)) = text.split_once('@') {
            script.add(line.parse().map_err(|_| wrong())?, named(name).ok_or_else(wrong)?);
        } else if let Some((name, p)) = text.split_once(':') {
            let p = p.parse::<f64>().ok().filter(|p| (0.0..=1.0).contains(p)).ok_or_else(wrong)?;
            probability = probability.max(p);
            match name {
                "random" => chosen.extend(SURVIVABLE),
                name => chosen.push(named(name).ok_or_else(wrong)?),
            }
        } else {
            return Err(wrong());
        }
    }
    if !chosen.is_empty() {
        let at: Vec<(u64, Fault)> = script.scheduled();
        script = Script::random(&chosen, probability, args.seed);
        at.into_iter().for_each(|(line, fault)| script.add(line, fault));
    }
    Ok(script)
}

struct Bench {
    sim: Sim,
    log: Option<File>,
    /// Simulated seconds a second; `None` skips every wait.
    speed: Option<f64>,
    start: Instant,
    skipped: Duration,
}

impl Bench {
    fn now(&self) -> Time {
        self.start.elapsed().mul_f64(self.speed.unwrap_or(1.0)) + self.skipped
    }

    fn serve(&mut self, args: &Verb, console: &Console, ended: &AtomicBool) -> Result<(), Failure> {
        loop {
            let server = Server::open(&args.link)?;
            console.note(&format!("simulated printer at {} ({})", args.link, server.place()));
            loop {
                if ended.load(Ordering::Relaxed) {
                    return Ok(());
                }
                let mut port = match server.connect() {
                    Ok(port) => port,
                    Err(e) if e.kind() == std::io::ErrorKind::WouldBlock => {
                        std::thread::sleep(NAP);
                        continue;
                    }
                    Err(e) => return Err(Failure::Usage(format!("{}: {e}", args.link))),
                };
                let unplugged = self.talk(&mut port, ended)?;
                if unplugged {
                    break;
                }
            }
            self.sim.unplugged();
            drop(server);
            std::thread::sleep(UNPLUGGED);
        }
    }

    /// One host; `true` where the plug was pulled, `false` where the host has left.
    fn talk(&mut self, port: &mut Port, ended: &AtomicBool) -> Result<bool, Failure> {
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

    fn write_log(&mut self) -> Result<(), Failure> {
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
        file.write_all(&text).map_err(|e| Failure::Usage(format!("--log: {e}")))
    }
}
