//! `trunnion machine read|jog`

use std::cell::RefCell;
use std::io::BufRead;

use super::args::{Jog, Machine as Verb, Place, Read};
use super::profile::imported;
use super::requests::{folder_of, outputs, profile_file};
use super::{Console, Failure};
use crate::calibrate::{JogQuestion, Seen};
use crate::document::{self, text};
use crate::job::{self, ImportProfile, JogRequest, MachineAt, World};
use crate::link::serial::Address;
use crate::profile::Profile;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    match args {
        Verb::Read(args) => read(args, console),
        Verb::Jog(args) => jog(args, console),
    }
}

fn read(args: &Read, console: &Console) -> Result<(), Failure> {
    let (world, given) = (console.world(), &args.made.answers);
    let like = args.made.like.as_deref();
    let mut outputs = outputs(given.answers.as_deref().into_iter().chain(like.and_then(profile_file).as_deref()));
    let stem = || Some(given.output.as_deref()?.file_stem()?.to_string_lossy().into_owned());
    let name = args.made.name.clone().or_else(stem).unwrap_or_else(|| "machine".to_owned());
    let at = at(&args.place, &world)?;
    let said = job::read_machine(&at, &format!("{name}.answers.txt"), &world)?;
    let bytes = said.bytes(&world)?.into_owned();
    let (files, like) = (vec![said], like.map(Into::into));
    let request = ImportProfile { files, name: Some(name), like, answers: given.told() };
    let place = imported(request, given, &mut outputs, console)?;
    Ok(outputs.claim(&place.with_extension("answers.txt"))?.write(&bytes)?)
}

fn at(place: &Place, world: &World<'_>) -> Result<MachineAt, Failure> {
    if let Some(port) = &place.port {
        return Ok(MachineAt::Port { address: Address::parse(port), baud: place.baud });
    }
    Ok(MachineAt::Server {
        address: job::server_address(place.host.as_deref().unwrap_or_default(), world)?,
        key: job::server_key(place.key_file.as_deref(), job::key_from_environment().as_deref(), world)?,
        silence: std::time::Duration::from_secs(place.timeout),
        fingerprint: place.fingerprint,
    })
}

fn jog(args: &Jog, console: &Console) -> Result<(), Failure> {
    let world = console.world();
    let output = args.output.as_deref().map(|path| outputs(profile_file(&args.machine.profile).as_deref()).claim(path));
    let output = output.transpose()?;
    let typed = RefCell::new(std::io::stdin().lock().lines());
    let ask = |question: &JogQuestion, profile: &Profile| -> Option<Seen> {
        console.ask(&text::jog_question(question, profile));
        loop {
            let line = typed.borrow_mut().next()?.ok()?;
            let number = line.trim().parse::<usize>().ok().and_then(|number| number.checked_sub(1));
            if let Some(seen) = number.and_then(|at| question.answers.get(at)) {
                return Some(*seen);
            }
            console.ask(&format!("type a number from 1 to {}", question.answers.len()));
        }
    };
    let request = JogRequest { machine: args.machine.source(), at: at(&args.place, &world)? };
    let done = job::jog(&request, &ask, &world)?;
    if console.json() {
        console.document(&document::jogged(&done));
    } else {
        console.result(&text::jogged(&done));
    }
    if let Some(why) = &done.unfit {
        return Err(Failure::Findings(format!("nothing was written: {why}")));
    }
    match output {
        Some(output) => {
            let folder = folder_of(Some(output.path())).unwrap_or_default();
            output.write(done.profile(Some(&folder), &world).as_bytes())?;
        }
        None if !console.json() => console.result(&done.profile(None, &world)),
        None => {}
    }
    Ok(())
}
