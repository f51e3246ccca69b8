//! A rehearsal: a print on the simulated printer, without waiting.

use std::sync::Arc;
use std::time::Duration;

use super::error::SendError;
use super::{SendRequest, program};
use crate::job::printer;
use crate::link::sim::{Script, Sim};
use crate::link::{Loopback, Notice, Outcome, Program, Sender, SenderSettings};
use crate::profile::Profile;
use crate::world::World;

/// Nothing prints longer than this.
const LONGEST: Duration = Duration::from_secs(60 * 24 * 3600);

/// What a rehearsal came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Rehearsal {
    /// Lines sent.
    pub lines: u32,
    /// The file's last line that was sent.
    pub last_line: u32,
    /// How long the print would take on the simulated printer: with homing, heating, accelerations and the wire.
    pub seconds: f64,
    /// How long its moves and waits take without all that: the time that `verify` states, from the same calculation.
    pub seconds_print: f64,
    /// Targets beyond an axis of the profile.
    pub clamped: u32,
    /// Lines that the simulated printer did not carry out as they are written: cold extrusion, commands that it does not know.
    pub troubles: Vec<String>,
}

fn trouble(notice: &Notice) -> Option<String> {
    match notice {
        Notice::Trouble { line, text } => Some(format!("line {line}: {text}")),
        _ => None,
    }
}

/// Prints on the simulated printer in virtual time; no port is opened.
///
/// # Errors
///
/// As [`send`](super::send()) before anything is sent, and [`SendError::Printer`] where the print does not come to its end.
pub fn rehearse(request: &SendRequest<'_>, world: &World<'_>) -> Result<Rehearsal, SendError> {
    let program = program(request, world)?;
    let (link, outcome) = through(&program, &request.machine.profile, LONGEST, |_| {})?;
    match outcome {
        Some(Outcome::Done) => Ok(Rehearsal {
            lines: program.len(),
            last_line: program.file_line(program.len()),
            seconds: link.now().as_secs_f64(),
            seconds_print: program.seconds_print(),
            clamped: link.sim.clamped(),
            troubles: link.events().iter().filter_map(trouble).collect(),
        }),
        Some(Outcome::Stopped(why)) => Err(SendError::Printer(format!("rehearsal: {why}"))),
        _ => Err(SendError::Printer("the rehearsal did not finish".to_owned())),
    }
}

/// Prints `program` on the simulated printer to its end, and shows how that stands `every` so often.
pub(super) fn through(
    program: &Arc<Program>,
    profile: &Profile,
    every: Duration,
    mut shown: impl FnMut(&Loopback),
) -> Result<(Loopback, Option<Outcome>), SendError> {
    let protocol = printer::protocol(profile)?;
    let mut sim = Sim::new(protocol, printer::model(profile)?, printer::quirks(profile)?, Script::none()).without_log();
    if let Some(words) = protocol.traits().unlock {
        sim.receive(Duration::ZERO, words);
        sim.advance(Duration::from_secs(60));
        sim.took(usize::MAX);
    }
    let settings = SenderSettings { pauses: false, ..printer::settings(profile)? };
    let mut link = Loopback::new(Sender::new(Arc::clone(program), settings), sim);
    while link.sender.outcome().is_none() && link.now() < LONGEST {
        let next = link.now() + every.min(LONGEST);
        link.run_to(next);
        shown(&link);
    }
    let outcome = link.run(link.now() + LONGEST);
    Ok((link, outcome))
}
