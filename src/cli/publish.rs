//! `trunnion publish`

use super::args::Publish as Verb;
use super::{Console, Failure, send};
use crate::document::{self, text};
use crate::job::{self, PublishRequest, Source, Verified};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let world = console.world();
    let to = &job::server_address(&args.to, &world)?;
    let key = job::server_key(args.key_file.as_deref(), job::key_from_environment().as_deref(), &world)?;
    let plan = args.plan.as_ref().map(|plan| job::load_plan(&args.plan_ref.source(plan), &world)).transpose()?;
    let program = &match &plan {
        Some(plan) => send::proved(&args.gcode, plan, &world)?,
        None if args.unverified => {
            console.warning(text::PUBLISHED_UNVERIFIED);
            Verified::unverified(Source::from(&args.gcode).program(&world)?.into_owned())
        }
        None => return Err(Failure::Usage(text::ONLY_VERIFIED_IS_PUBLISHED.to_owned())),
    };
    let request = PublishRequest {
        path: &args.gcode,
        program,
        machine: plan.as_ref().map(|plan| &plan.machine),
        to,
        key: key.as_ref(),
        name: args.name.as_deref(),
        replace: args.replace,
        start: args.start,
        fingerprint: args.fingerprint,
        silence: std::time::Duration::from_secs(args.timeout),
    };
    let done = job::publish(&request, &world)?;
    match console.json() {
        true => console.document(&document::published(&done)),
        false => console.summary(&text::published(&done), true),
    }
    Ok(())
}
