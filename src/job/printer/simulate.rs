//! The simulated printer of a profile, with the quirks and faults that are asked for.

use super::error::{BadSimulation, PrinterError};
use crate::input::LoadedProfile;
use crate::job::printer;
use crate::link::sim::{QUIRKS, Script, Sim};

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

/// The simulated printer of `machine`, for a [`Bench`](super::Bench).
///
/// # Errors
///
/// [`PrinterError::Simulation`]; [`PrinterError::Protocol`] for a machine that nothing is streamed to.
pub fn simulate(request: &SimulateRequest, machine: &LoadedProfile) -> Result<Sim, PrinterError> {
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
    Ok(Sim::new(
        printer::protocol(profile)?,
        model,
        quirks,
        Script::read(&request.faults, request.seed).map_err(|given| BadSimulation::Fault { given })?,
    ))
}
