//! The simulated printer of a profile, with the quirks and faults that are asked for.

use super::{Error, LoadedProfile, printer};
use crate::link::sim::{NAMES, Quirks, SURVIVABLE, Script, Sim, SimFault};

/// A simulated printer to be.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulateRequest {
    /// What it does otherwise than its firmware does by itself, by name.
    pub quirks: Vec<String>,
    /// Faults: `NAME@LINE`, `NAME:PROBABILITY` or `random:PROBABILITY`.
    pub faults: Vec<String>,
    /// Seed of random faults.
    pub seed: u64,
    /// Bits a second of the wire; 0: no limit.
    pub baud: u32,
    /// Heaters this many times as fast as real ones.
    pub heat: f64,
}

impl Default for SimulateRequest {
    fn default() -> Self {
        Self { quirks: Vec::new(), faults: Vec::new(), seed: 1, baud: 0, heat: 1.0 }
    }
}

/// A word of a request that means nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "simulate/")]
pub enum BadSimulation {
    /// An unknown quirk.
    #[error("quirk {given} is unknown; known are {}", QUIRKS.map(|(name, _)| name).join(", "))]
    Quirk {
        /// As given.
        given: String,
    },
    /// An unknown fault.
    #[error(
        "fault {given}: must be NAME@LINE, NAME:PROBABILITY or random:PROBABILITY; names: {}",
        NAMES.map(|(name, _)| name).join(", ")
    )]
    Fault {
        /// As given.
        given: String,
    },
}

/// A quirk's name, and what it changes.
type NamedQuirk = (&'static str, fn(&mut Quirks));

/// The quirks that can be asked for.
const QUIRKS: [NamedQuirk; 16] = [
    ("advanced-ok", |q| q.advanced_ok = true),
    ("no-ok-after-resend", |q| q.ok_after_resend = false),
    ("refuses-doubles", |q| q.silent_duplicates = false),
    ("no-emergency-parser", |q| q.emergency_parser = false),
    ("no-busy", |q| q.busy = false),
    ("repetier-errors", |q| q.repetier_errors = true),
    ("sprinter-errors", |q| q.sprinter_errors = true),
    ("smoothie-resends", |q| q.smoothie_resends = true),
    ("blank-behind-slash", |q| q.blank_behind_slash = true),
    ("latches-errors", |q| q.latches_errors = true),
    ("three-axes", |q| q.axes = 3),
    ("marlin-1.0", Quirks::marlin_1_0),
    ("marlin-1.1", Quirks::marlin_1_1),
    ("prusa", Quirks::prusa),
    ("rrf-2", Quirks::rrf_2),
    ("fluidnc", Quirks::fluidnc),
];

/// The simulated printer of `machine`, for a [`Bench`](super::Bench).
///
/// # Errors
///
/// [`Error::Simulation`]; [`Error::Protocol`] for a machine that nothing is streamed to.
pub fn simulate(request: &SimulateRequest, machine: &LoadedProfile) -> Result<Sim, Error> {
    let profile = &machine.profile;
    let mut quirks = printer::quirks(profile)?;
    quirks.baud = request.baud;
    for given in &request.quirks {
        let known = QUIRKS.iter().find(|(name, _)| name == given);
        let (_, apply) = known.ok_or_else(|| BadSimulation::Quirk { given: given.clone() })?;
        apply(&mut quirks);
    }
    let mut model = printer::model(profile)?;
    model.heat_factor = request.heat;
    Ok(Sim::new(printer::protocol(profile)?, model, quirks, script(request)?))
}

fn script(request: &SimulateRequest) -> Result<Script, BadSimulation> {
    let mut script = Script::none();
    let mut chosen = Vec::new();
    let mut probability = 0.0_f64;
    for text in &request.faults {
        let wrong = || BadSimulation::Fault { given: text.clone() };
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
        let at: Vec<(u64, SimFault)> = script.scheduled();
        script = Script::random(&chosen, probability, request.seed);
        at.into_iter().for_each(|(line, fault)| script.add(line, fault));
    }
    Ok(script)
}
