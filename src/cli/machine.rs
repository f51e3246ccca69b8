//! `trunnion machine jog`

use std::cell::RefCell;
use std::io::BufRead;

use super::args::{Jog, Machine as Verb};
use super::requests::{folder_of, outputs, profile_file};
use super::{Console, Failure};
use crate::calibrate::{JogQuestion, Seen};
use crate::document::{self, text};
use crate::job::{self, JogRequest};
use crate::link::serial::Address;
use crate::profile::Profile;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    match args {
        Verb::Jog(args) => jog(args, console),
    }
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
    let address = Address::parse(&args.port);
    let done = job::jog(&JogRequest { machine: args.machine.source(), address, baud: args.baud }, &ask, &world)?;
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
