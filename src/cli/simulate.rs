//! `trunnion simulate`: the simulated printer behind a pseudo-terminal or a TCP address.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::args::Simulate as Verb;
use super::requests::{outputs, profile_file};
use super::{Console, Failure};
use crate::job::{self, Bench, SimulateRequest, interrupts};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let machine = job::load_profile(&args.machine.source(), &console.world())?;
    let request = SimulateRequest {
        quirks: args.quirk.clone(),
        faults: args.fault.clone(),
        seed: args.seed,
        baud: args.baud.unwrap_or(0),
        heat: args.heat,
    };
    let sim = job::simulate(&request, &machine)?;
    let mut log = match &args.log {
        Some(path) => Some(outputs(profile_file(&args.machine.profile).as_deref()).claim(path)?.create()?),
        None => None,
    };
    let ended = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&ended);
    interrupts::on_interrupt(move || seen.store(true, Ordering::Relaxed));
    let (world, speed) = (console.world(), speed(&args.speed)?);
    let log = log.as_mut().map(|file| file as &mut dyn std::io::Write);
    Bench::new(sim, speed, log, &world).serve(&args.link, &ended, |place| {
        console.note(&format!("simulated printer at {} ({place})", args.link));
    })?;
    Ok(())
}

fn speed(text: &str) -> Result<Option<f64>, Failure> {
    if text == "max" {
        return Ok(None);
    }
    let parsed = text.parse::<f64>().ok().filter(|v| *v > 0.0 && v.is_finite());
    parsed.map(Some).ok_or_else(|| Failure::Usage(format!("--speed {text}: must be a factor above 0, or max")))
}
