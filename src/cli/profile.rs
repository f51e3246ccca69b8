//! `trunnion profile list|show|check`

use std::fmt::Write;

use serde_json::json;

use super::args::Profile as Verb;
use super::{Console, Failure};
use crate::profile::SHIPPED;
use crate::{document, job};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    match args {
        Verb::List => list(console),
        Verb::Show(of) => show(&of.profile, console),
        Verb::Check(of) => {
            let loaded = job::load_profile(&of.profile.as_str().into(), &console.world())?;
            if console.json() {
                console.document(&document::checked(&loaded));
            } else {
                console.result(&document::text::checked(&loaded));
            }
            Ok(())
        }
    }
}

fn list(console: &Console) -> Result<(), Failure> {
    let mut rows = Vec::new();
    let mut text = String::new();
    for (name, _, _) in SHIPPED {
        let loaded = job::load_profile(&name.into(), &console.world())?;
        let machine = &loaded.profile.machine;
        let tested =
            if machine.tested_on.is_empty() { "no real machine yet".to_owned() } else { machine.tested_on.join(", ") };
        let _ = writeln!(text, "{name:20} {}; tested on: {tested}", machine.about);
        rows.push(document::shipped(&loaded));
    }
    if console.json() {
        console.document(&json!(rows))
    } else {
        console.result(&text)
    }
    Ok(())
}

fn show(name: &str, console: &Console) -> Result<(), Failure> {
    let loaded = job::load_profile(&name.into(), &console.world())?;
    if console.json() {
        console.document(&json!(loaded.profile));
        return Ok(());
    }
    console.result(&loaded.annotated()?);
    Ok(())
}
