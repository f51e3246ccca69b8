//! `trunnion simulate`: the simulated printer behind a pseudo-terminal or a TCP address.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::args::Simulate as Verb;
use super::interrupts::on_interrupt;
use super::requests::{outputs, profile_file};
use super::{Console, Failure};
use crate::job::{self, Bench, printer};
use crate::link::sim::{Fault, NAMES, SURVIVABLE, Script, Sim};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let machine = job::load_profile(&args.machine.source(), &console.world())?;
    let mut quirks = printer::quirks(&machine.profile)?;
    apply_quirks(&mut quirks, args)?;
    let mut model = printer::model(&machine.profile)?;
    model.heat_factor = args.heat;
    let script = script(args)?;
    let sim = Sim::new(printer::protocol(&machine.profile)?, model, quirks, script);
    let mut log = match &args.log {
        Some(path) => Some(outputs(profile_file(&args.machine.profile).as_deref()).claim(path)?.create()?),
        None => None,
    };
    let ended = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&ended);
    on_interrupt(move || seen.store(true, Ordering::Relaxed));
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
