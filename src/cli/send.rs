//! `trunnion send`: what is proved is sent, once; what is interrupted can be resumed.

use std::path::Path;

use super::args::{OnePrint, Send as Verb, StreamArgs};
use super::operator::Terminal;
use super::requests::outputs;
use super::{Console, Failure, progress};
use crate::document::{self, Row, text};
use crate::job::{
    self, CheckedPlan, Loaded, LoadedProfile, Operator, OutputFile, Outputs, PrintError, SendRequest, SentPrint,
    Source, Verified, VerifyRequest, Wire, World,
};
use crate::link::serial::Address;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let prints = args.prints().map_err(Failure::Usage)?;
    let mut outputs = outputs(prints.iter().flat_map(|(file, _, plan)| [Some(*file), *plan]).flatten());
    let files = prints.iter().filter(|(_, port, _)| port.is_some()).map(|(file, ..)| *file);
    let journals: Vec<OutputFile> =
        files.map(|file| outputs.claim(&args.stream.journal(file))).collect::<Result<_, _>>()?;
    let (options, world) = (args.stream.options(), console.world());
    prints.iter().try_for_each(|(file, ..)| job::can_be_sent(file, &world))?;
    let load = |(file, _, plan): &OnePrint<'_>| load(file, *plan, args, &mut outputs, console);
    let loaded = prints.iter().map(load).collect::<Result<Vec<_>, _>>()?;
    let both = loaded.iter().zip(&prints);
    let requests: Vec<_> = both.filter_map(|(loaded, (path, ..))| loaded.request(path, &options)).collect();
    let ports: Vec<&str> = prints.iter().filter_map(|(_, port, _)| *port).collect();
    match (requests.as_slice(), ports.as_slice(), journals.as_slice()) {
        ([one], [port], [journal]) => stream(one, port, journal, &args.stream, console),
        ([one], [], _) => rehearse(one, console),
        _ => several(&requests, &ports, &journals, &args.stream, console),
    }
}

const UNPROVED: &str = "only a verified file is sent; pass its plan with --plan PLAN.json, or skip all collision checks with --unverified -m PROFILE";

/// A file and what it was made by; verified, if it is to be.
fn load(
    path: &Path,
    plan: Option<&Path>,
    args: &Verb,
    outputs: &mut Outputs,
    console: &Console,
) -> Result<Loaded, Failure> {
    let world = console.world();
    if let Some(plan) = plan {
        let plan = job::load_plan(&args.plan_ref.source(plan), &world)?;
        plan.inputs().try_for_each(|path| outputs.reads(path))?;
        let program = proved(path, &plan, &world)?;
        if let Some(report) = program.report() {
            console.note(&format!("verified: {} moves, clearance {:.2} mm", report.moves, report.clearance_mm));
        }
        warn(&plan.machine, args, console);
        return Ok(Loaded { program, plan: Some(plan), profile: None });
    }
    let Some(profile) = args.plan_ref.profile.as_deref().filter(|_| args.unverified) else {
        let missing =
            if args.unverified { "--unverified has no plan that names the machine; pass -m PROFILE" } else { UNPROVED };
        return Err(Failure::Usage(missing.to_owned()));
    };
    let program = Verified::unverified(Source::from(path).program(&world)?.into_owned());
    let profile = Some(job::load_profile(&profile.into(), &world)?);
    profile.iter().for_each(|machine| warn(machine, args, console));
    console.warning(&text::sent_unverified(path));
    Ok(Loaded { program, plan: None, profile })
}

/// Before a real machine moves: whether anybody has seen its axes do what the profile says.
fn warn(machine: &LoadedProfile, args: &Verb, console: &Console) {
    let unseen = text::unseen(&machine.profile, &machine.name).filter(|_| !args.dry_run);
    unseen.iter().for_each(|text| console.warning(text));
}

/// Sends to several printers at the same time.
fn several(
    requests: &[SendRequest<'_>],
    ports: &[&str],
    journals: &[OutputFile],
    args: &StreamArgs,
    console: &Console,
) -> Result<(), Failure> {
    let addresses: Vec<Address> = ports.iter().map(|port| Address::parse(port)).collect();
    let wires = addresses.iter().zip(journals).map(|(address, journal)| Wire { address, journal });
    let prints: Vec<SentPrint<'_>> =
        requests.iter().zip(wires).map(|(&request, wire)| SentPrint { request, wire }).collect();
    let of = prints.len();
    let lines = console.rows(of);
    let shown = lines.clone();
    let desk = &*job::desk(of, move |wrong| progress::typed(wrong, Some(&*shown).filter(|shown| shown.are_drawn())));
    let row = |(row, port): (usize, &&str)| {
        console.row(Row { name: format!("{} {port}", row + 1), row, lines: lines.clone() })
    };
    let consoles: Vec<Console> = ports.iter().enumerate().map(row).collect();
    let operator =
        |index: usize| -> Box<dyn Operator> { Box::new(Terminal::new(&consoles[index], args.yes).at(desk, index)) };
    let ended = job::send_several(&prints, args.resume, &console.world(), &operator)?;
    if console.json() {
        console.result(&document::ended(&ended).to_string());
    }
    let Some(text) = document::failures(&ended) else { return Ok(()) };
    let first = ended.into_iter().find_map(|print| print.error);
    Err(Failure::Prints { text, code: first.map_or(2, |error| Failure::from(error).exit_code()) })
}

/// The program, if nothing is found wrong with it.
pub(super) fn proved(path: &Path, plan: &CheckedPlan, world: &World<'_>) -> Result<Verified<Vec<u8>>, Failure> {
    let program = &Source::from(path);
    job::verify(&VerifyRequest { program, plan }, world)?.verified().map_err(|error| match error {
        PrintError::Rejected(no) => Failure::Findings(format!("{}: {no}; nothing was sent", path.display())),
        other => other.into(),
    })
}

/// Sends or resumes a program; everything before the first byte has been checked.
pub(super) fn stream(
    request: &SendRequest<'_>,
    port: &str,
    journal: &OutputFile,
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
    console.note(&document::rehearsal(&done));
    if console.json() {
        console.result(&document::rehearsed(&done).to_string());
    }
    document::undone(&done).map_or(Ok(()), |text| Err(Failure::Findings(text)))
}
