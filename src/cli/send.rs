//! `trunnion send`: what is proved is sent, once; what is interrupted can be resumed.

use std::path::Path;
use std::time::Duration;

use super::args::{Send as Verb, StreamArgs};
use super::operator::Terminal;
use super::requests::outputs;
use super::{Console, Failure};
use crate::document;
use crate::job::{
    self, CheckedPlan, OutputFile, Outputs, SendOptions, SendRequest, Source, Verified, VerifyRequest, Wire, World,
    with_suffix,
};
use crate::link::serial::Address;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let mut outputs = outputs([Some(args.gcode.as_path()), args.plan.as_deref()].into_iter().flatten());
    let goes_out = args.port.as_deref().filter(|_| !args.dry_run);
    let journal = goes_out.map(|_| journal(&mut outputs, &args.gcode, &args.stream)).transpose()?;
    let wire = goes_out.zip(journal.as_ref());
    let (world, path, options) = (console.world(), args.gcode.as_path(), &args.stream.options());
    job::can_be_sent(path, &world)?;
    if let Some(plan) = &args.plan {
        let plan = job::load_plan(&args.plan_ref.source(plan), &world)?;
        plan.inputs().try_for_each(|path| outputs.reads(path))?;
        let program = &proved(path, &plan, &world)?;
        if let Some(report) = program.report() {
            console.note(&format!("verified: {} moves, clearance {:.2} mm", report.moves, report.clearance_mm));
        }
        let request = SendRequest { path, program, machine: &plan.machine, plan: Some(&plan), options };
        return go(&request, wire, &args.stream, console);
    }
    let Some(profile) = args.plan_ref.profile.as_deref().filter(|_| args.unverified) else {
        return Err(Failure::Usage(
            "only a file that verifies is sent: give its plan with --plan PLAN.json; or, without any \
             check for collisions, --unverified with -m PROFILE"
                .to_owned(),
        ));
    };
    let program = &Verified::unverified(world.files.read(path)?);
    let machine = &job::load_profile(&profile.into(), &world)?;
    console.warning("the file is not verified: the head may hit the part, the table or the frame");
    go(&SendRequest { path, program, machine, plan: None, options }, wire, &args.stream, console)
}

/// The program, if nothing is found wrong with it.
pub(super) fn proved(path: &Path, plan: &CheckedPlan, world: &World<'_>) -> Result<Verified<Vec<u8>>, Failure> {
    let program = &Source::from(path);
    job::verify(&VerifyRequest { program, plan }, world)?.verified().map_err(|error| match error {
        job::Error::Rejected(no) => Failure::Findings(format!("{}: {no}; nothing was sent", path.display())),
        other => other.into(),
    })
}

fn go(
    request: &SendRequest<'_>,
    wire: Option<(&str, &OutputFile)>,
    args: &StreamArgs,
    console: &Console,
) -> Result<(), Failure> {
    match wire {
        Some(wire) => stream(request, wire, args, console),
        None => rehearse(request, console),
    }
}

impl StreamArgs {
    pub(super) fn options(&self) -> SendOptions {
        let (baud, wait, devices) = (self.baud, Duration::from_secs(self.wait), self.devices.clone());
        SendOptions { baud, wait, devices, from: self.from }
    }
}

/// Sends or resumes a program; everything before the first byte has been checked.
pub(super) fn stream(
    request: &SendRequest<'_>,
    (port, journal): (&str, &OutputFile),
    args: &StreamArgs,
    console: &Console,
) -> Result<(), Failure> {
    let wire = Wire { address: &Address::parse(port), journal };
    let terminal = Terminal::new(console, args.yes);
    let go = if args.resume { job::resume } else { job::send };
    Ok(go(request, &wire, &console.world(), &terminal)?)
}

/// Prints on the simulated printer in virtual time.
fn rehearse(request: &SendRequest<'_>, console: &Console) -> Result<(), Failure> {
    let done = job::rehearse(request, &console.world())?;
    console.note(&format!(
        "rehearsal: {} lines in {:.0} min with heating and accelerations ({:.0} min without); {} targets beyond an axis",
        done.lines,
        done.seconds / 60.0,
        done.seconds_print / 60.0,
        done.clamped
    ));
    if console.json() {
        console.result(&document::rehearsed(&done).to_string());
    }
    if done.clamped > 0 {
        return Err(Failure::Findings(format!("{} targets lie beyond an axis of the profile", done.clamped)));
    }
    if let Some(first) = done.troubles.first() {
        let more = done.troubles.len() - 1;
        let more = if more > 0 { format!(", and {more} more") } else { String::new() };
        return Err(Failure::Findings(format!(
            "the simulated printer did not carry out {first}{more}; the real one would pause there"
        )));
    }
    Ok(())
}

/// Where the journal of the print of `gcode` is kept.
pub(super) fn journal(outputs: &mut Outputs, gcode: &Path, args: &StreamArgs) -> Result<OutputFile, Failure> {
    Ok(match &args.journal {
        Some(given) => outputs.claim(given)?,
        None => outputs.claim(&with_suffix(gcode, ".journal"))?,
    })
}
