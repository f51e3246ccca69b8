//! Programs to printers: over a wire, or through the server that drives one. What is not verified goes only where that is said in words.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trunnion::document::{self, text as words};
use trunnion::job::{
    self, CheckedPlan, Loaded, LoadedProfile, MachineSource, Outputs, PlanSource, PrintError, PublishRequest,
    SendOptions, Source, Verified, VerifyRequest, Wire, World, with_suffix,
};
use trunnion::link::serial::Address;
use trunnion::publish::{Fingerprint, Key};

use crate::call::{Call, Made, text};
use crate::given::{Given, Named, machine, source};
use crate::trouble::Trouble;

/// Why nothing is done with a program that has no plan.
const ONLY_VERIFIED: &str =
    "only a verified program goes to a printer; give its plan, or skip all collision checks with unverified=True";

/// A program, what it is verified against, and where it goes.
struct Outgoing {
    program: Source,
    /// As messages call it.
    path: PathBuf,
    plan: Option<PlanSource>,
    profile: Option<MachineSource>,
    unverified: bool,
}

impl Outgoing {
    fn of(program: Named, given: &Given<'_>) -> PyResult<Self> {
        let profile = given.named("profile")?.map(machine);
        let model = given.named("model")?.map(source);
        let plan = given.named("plan")?.map(|plan| PlanSource { plan: source(plan), model, machine: profile.clone() });
        let path = PathBuf::from(&program.0);
        Ok(Self { program: source(program), path, plan, profile, unverified: given.flag("unverified")? })
    }

    /// The files that are read.
    fn files(&self) -> impl Iterator<Item = &Path> {
        self.program.path().into_iter().chain(self.plan.as_ref().and_then(|plan| plan.plan.path()))
    }

    fn loaded_plan(&self, world: &World<'_>) -> Result<Option<CheckedPlan>, Trouble> {
        Ok(self.plan.as_ref().map(|plan| job::load_plan(plan, world)).transpose()?)
    }

    /// The program, if nothing is found wrong with it, or if it is said that nobody looks.
    fn verified(&self, plan: Option<&CheckedPlan>, world: &World<'_>) -> Result<Verified<Vec<u8>>, Trouble> {
        if let Some(plan) = plan {
            let done = job::verify(&VerifyRequest { program: &self.program, plan }, world)?.verified();
            return done.map_err(|error| self.rejected(error));
        }
        if !self.unverified {
            return Err(Trouble::input(ONLY_VERIFIED.to_owned()));
        }
        Ok(Verified::unverified(match &self.program {
            Source::Bytes { bytes, .. } => bytes.clone(),
            Source::File(path) => world.files.read(path)?,
        }))
    }

    /// The command's failure, with the findings beside it.
    fn rejected(&self, error: PrintError) -> Trouble {
        let PrintError::Rejected(no) = error else { return error.into() };
        let text = format!("{}: {no}; nothing was sent", self.path.display());
        let mut document = document::failed("command/no", &text, 1, None, None);
        document["verify"] = document::verified(&no.report, no.seconds);
        Trouble::with(text, 1, &document)
    }
}

#[pyfunction]
pub(crate) fn send(program: Named, told: Bound<'_, PyAny>, given: Bound<'_, PyDict>) -> PyResult<Made> {
    let call = Call::of(told, given)?;
    let given = &call.given;
    let outgoing = Outgoing::of(program, given)?;
    let usual = SendOptions::default();
    let few = |name: &str| given.of(name, "a whole number of at least 0", |value| value.extract::<u32>().ok());
    let options = SendOptions {
        baud: few("baud")?,
        wait: given.number("wait_s")?.map_or(Ok(usual.wait), given.seconds("wait_s"))?,
        holds: given.flag("yes")?,
        from: few("from_line")?,
        ..usual
    };
    let port: Option<OsString> = given.of("port", "a port", |value| value.extract().ok())?;
    let (dry_run, resumes) = (given.flag("dry_run")?, given.flag("resume")?);
    let journal = given.path("journal")?.unwrap_or_else(|| with_suffix(&outgoing.path, ".journal"));
    call.print(options.holds, move |world, attendant| {
        let mut outputs = Outputs::new(outgoing.files());
        let wire = port.filter(|_| !dry_run).map(|port| Ok::<_, Trouble>((address(port), outputs.claim(&journal)?)));
        let wire = wire.transpose()?;
        outgoing.program.path().map(|path| job::can_be_sent(path, world)).transpose()?;
        let loaded = loaded(&outgoing, &mut outputs, dry_run, world)?;
        let Some(request) = loaded.request(&outgoing.path, &options) else {
            return Err(Trouble::input("unverified=True has no plan that names the machine; give profile".to_owned()));
        };
        let Some((address, journal)) = &wire else {
            return Ok((document::rehearsed(&job::rehearse(&request, world)?).to_string(), Vec::new()));
        };
        let go = if resumes { job::resume } else { job::send };
        go(&request, &Wire { address, journal }, world, attendant)?;
        Ok((attendant.last().to_string(), Vec::new()))
    })
}

/// As the command reads it, and a device's path that is no text too.
fn address(port: OsString) -> Address {
    port.to_str().map_or_else(|| Address::Device(PathBuf::from(&port)), Address::parse)
}

/// A program and what it was made by; verified, if it is to be.
fn loaded(outgoing: &Outgoing, outputs: &mut Outputs, dry_run: bool, world: &World<'_>) -> Result<Loaded, Trouble> {
    let warn = |machine: &LoadedProfile| {
        // Before a real machine moves: whether anybody has seen its axes do what the profile says.
        let unseen = words::unseen(&machine.profile, &machine.name).filter(|_| !dry_run);
        unseen.iter().for_each(|text| world.progress.warning(text));
    };
    if let Some(plan) = outgoing.loaded_plan(world)? {
        plan.inputs().try_for_each(|path| outputs.reads(path))?;
        let program = outgoing.verified(Some(&plan), world)?;
        warn(&plan.machine);
        return Ok(Loaded { program, plan: Some(plan), profile: None });
    }
    let program = outgoing.verified(None, world)?;
    let profile = outgoing.profile.as_ref().map(|machine| job::load_profile(machine, world)).transpose()?;
    profile.iter().for_each(warn);
    world.progress.warning(&words::sent_unverified(&outgoing.path));
    Ok(Loaded { program, plan: None, profile })
}

#[pyfunction]
pub(crate) fn publish(program: Named, told: Bound<'_, PyAny>, given: Bound<'_, PyDict>) -> PyResult<Made> {
    let call = Call::of(told, given)?;
    let given = &call.given;
    let outgoing = Outgoing::of(program, given)?;
    let to = given.text("to")?.unwrap_or_default();
    let key = given.secret("key")?;
    let (key_file, name) = (given.path("key_file")?, given.text("name")?);
    let print: Option<Result<Fingerprint, String>> = given.text("fingerprint")?.map(|text| text.parse());
    let refused = |why| Trouble::input(format!("fingerprint {why}")).raised(given.py());
    let fingerprint = print.transpose().map_err(refused)?;
    let [replace, start] = [given.flag("replace")?, given.flag("start")?];
    let patience = "a number of seconds between 1 and 3600";
    let within = |value: &Bound<'_, PyAny>| value.extract().ok().filter(|seconds| (1.0..=3600.0).contains(seconds));
    let silence = given.of("timeout_s", patience, within)?.map_or(SILENCE, Duration::from_secs_f64);
    call.run(move |world| {
        let to = &job::server_address(&to, world)?;
        let key = match &key {
            Some(text) if key_file.is_none() => Some(Key::new(text, "key").map_err(job::UploadError::from)?),
            _ => job::server_key(key_file.as_deref(), job::key_from_environment().as_deref(), world)?,
        };
        let plan = outgoing.loaded_plan(world)?;
        let program = &outgoing.verified(plan.as_ref(), world)?;
        if plan.is_none() {
            world.progress.warning(words::PUBLISHED_UNVERIFIED);
        }
        let request = PublishRequest {
            path: &outgoing.path,
            program,
            machine: plan.as_ref().map(|plan| &plan.machine),
            to,
            key: key.as_ref(),
            name: name.as_deref(),
            replace,
            start,
            fingerprint,
            silence,
        };
        Ok((text(&document::published(&job::publish(&request, world)?)), Vec::new()))
    })
}

/// How long a server may say nothing where that is not said.
const SILENCE: Duration = Duration::from_secs(30);
