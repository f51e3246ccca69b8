//! `trunnion profile list|show|check|calibrate`

use std::fmt::Write;
use std::path::Path;

use serde_json::json;

use super::args::{Calibrate, CheckProfile, Profile as Verb};
use super::requests::{folder_of, outputs, profile_file};
use super::{Console, Failure};
use crate::calibrate::FitOptions;
use crate::job::{CalibrateRequest, PosesRequest, Source};
use crate::profile::SHIPPED;
use crate::{document, job};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    match args {
        Verb::List => list(console),
        Verb::Show(of) => show(&of.profile, console),
        Verb::Check(args) => check(args, console),
        Verb::Calibrate(args) => match &args.poses {
            Some(form) => poses(args, form, console),
            None => calibrate(args, console),
        },
    }
}

fn check(args: &CheckProfile, console: &Console) -> Result<(), Failure> {
    let name = &args.of.profile;
    let view = args.view.as_deref().map(|path| outputs(profile_file(name).as_deref()).claim(path)).transpose()?;
    let done = job::check_profile(&name.as_str().into(), &console.world())?;
    if console.json() {
        console.document(&document::checked(&done));
    } else {
        console.result(&done.text());
    }
    view.map(|view| view.write(done.svg().as_bytes())).transpose()?;
    done.refusal().map_or(Ok(()), |why| Err(Failure::Findings(why)))
}

fn calibrate(args: &Calibrate, console: &Console) -> Result<(), Failure> {
    let touches = args.touches.clone().unwrap_or_default();
    let mut outputs = outputs([touches.as_path()].into_iter().chain(profile_file(&args.machine.profile).as_deref()));
    let output = args.output.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let machine = args.machine.profile.as_str().into();
    let options = FitOptions { square: args.assume_square, tolerance_mm: args.tolerance };
    let request = CalibrateRequest { machine, touches: Source::from(&touches), options };
    let done = job::calibrate(&request, &console.world())?;
    if console.json() {
        console.document(&document::calibrated(&done));
    } else {
        console.result(&done.text());
    }
    if let Some(why) = done.refusal() {
        return Err(Failure::Findings(format!("nothing was written: {why}")));
    }
    match output {
        Some(output) => {
            let folder = folder_of(Some(output.path())).unwrap_or_default();
            output.write(done.profile(Some(&folder), &console.world()).as_bytes())?;
        }
        None if !console.json() => console.result(&done.profile(None, &console.world())),
        None => {}
    }
    Ok(())
}

fn poses(args: &Calibrate, form: &Path, console: &Console) -> Result<(), Failure> {
    let mut outputs = outputs(profile_file(&args.machine.profile).as_deref());
    let form = outputs.claim(form)?;
    let gcode = args.gcode.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let machine = args.machine.profile.as_str().into();
    let request = PosesRequest { machine, repeats_to_mm: args.repeats_to, most: args.most, square: args.assume_square };
    let done = job::poses(&request, &console.world())?;
    if console.json() {
        console.document(&document::poses(&done));
    } else {
        console.result(&done.text());
    }
    if let Some(gcode) = gcode {
        let visit = done.visit.as_ref().map_err(|why| Failure::Findings(format!("no G-code was written: {why}")))?;
        let left = visit.left_out.join(", ");
        if !left.is_empty() {
            console
                .warning(&format!("start lines that heat, move or are not known are left out of the G-code: {left}"));
        }
        gcode.write(visit.gcode.as_bytes())?;
    }
    Ok(form.write(done.form.as_bytes())?)
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
