//! `trunnion profile list|show|check|new|import|calibrate`

use std::fmt::Write;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::args::{Answers as Given, Calibrate, CheckProfile, Import, New, Profile as Verb};
use super::requests::{folder_of, outputs, profile_file};
use super::{Console, Failure};
use crate::calibrate::FitOptions;
use crate::document::{self, text};
use crate::job::{self, Outputs, PictureFile};
use crate::job::{CalibrateRequest, ImportProfile, NewProfile, Source, TowerResult};
use crate::profile::SHIPPED;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    match args {
        Verb::List => list(console),
        Verb::Show(of) => show(&of.profile, console),
        Verb::Check(args) => check(args, console),
        Verb::New(args) => new(args, console),
        Verb::Import(args) => import(args, console),
        Verb::Calibrate(args) => match (&args.poses, &args.tower) {
            (Some(form), _) => poses(args, form, console),
            (None, Some(folder)) => tower(args, folder, console),
            (None, None) => calibrate(args, console),
        },
    }
}

fn check(args: &CheckProfile, console: &Console) -> Result<(), Failure> {
    let name = &args.of.profile;
    let view = PictureFile::claim("view", args.view.as_deref(), &mut outputs(profile_file(name).as_deref()))?;
    let done = job::check_profile(&name.as_str().into(), &console.world())?;
    if console.json() {
        console.document(&document::checked(&done));
    } else {
        console.result(&text::checked(&done));
    }
    view.map(|view| view.write(&done.view())).transpose()?;
    done.refusal().map_or(Ok(()), |why| Err(Failure::Findings(why)))
}

fn new(args: &New, console: &Console) -> Result<(), Failure> {
    let world = console.world();
    let given = &args.answers;
    let mut outputs = outputs(given.answers.as_deref().into_iter().chain(profile_file(&args.like).as_deref()));
    let mut request = NewProfile { name: args.name.clone(), base: args.like.as_str().into(), answers: given.told() };
    if asks(given, console) {
        let shown = |key: &str, question: &str| console.note(&text::question(key, question, Some(&args.like)));
        request.ask(std::io::stdin().lock(), shown, &world)?;
    }
    let made = job::new_profile(&request, &world)?;
    let place = job::keep_profile(&args.name, given.output.as_deref(), &mut outputs, |_| made.text, &world)?;
    told(&place, console, || document::profile_made(&args.name, &place, &made.unanswered));
    Ok(())
}

fn import(args: &Import, console: &Console) -> Result<(), Failure> {
    let given = &args.made.answers;
    let like = args.made.like.as_deref();
    let read = args.files.iter().chain(&given.answers).map(PathBuf::as_path);
    let mut outputs = outputs(read.chain(like.and_then(profile_file).as_deref()));
    let stem = || Some(given.output.as_deref()?.file_stem()?.to_string_lossy().into_owned());
    let files = args.files.iter().map(Source::from).collect();
    let (name, like) = (args.made.name.clone().or_else(stem), like.map(Into::into));
    let request = ImportProfile { files, name, like, answers: given.told() };
    imported(request, given, &mut outputs, console).map(drop)
}

/// The profile that `request` comes to, written; asks what is open where somebody can answer.
pub(super) fn imported(
    mut request: ImportProfile,
    given: &Given,
    outputs: &mut Outputs,
    console: &Console,
) -> Result<PathBuf, Failure> {
    let world = console.world();
    if asks(given, console) {
        let base = |key: &str| (!job::REQUIRED_KEYS.contains(&key)).then_some("the base profile");
        let shown = |key: &str, question: &str| console.note(&text::question(key, question, base(key)));
        request.ask(std::io::stdin().lock(), shown, &world)?;
    }
    let made = job::import_profile(&request, &world)?;
    let text = |folder: &Path| made.text(Some(folder), &world);
    let place = job::keep_profile(&made.name, given.output.as_deref(), outputs, text, &world)?;
    made.notes.iter().chain(&made.refusals).for_each(|text| console.warning(text));
    told(&place, console, || document::profile_imported(&made, &place));
    Ok(place)
}

fn asks(given: &Given, console: &Console) -> bool {
    std::io::stdin().is_terminal() && !given.keep_rest && !console.json()
}

fn told(place: &Path, console: &Console, document: impl FnOnce() -> serde_json::Value) {
    if console.json() {
        console.document(&document());
    } else {
        console.result(&format!("{}\nnext: trunnion profile check, and docs/how-to/machine.md", place.display()));
    }
}

fn calibrate(args: &Calibrate, console: &Console) -> Result<(), Failure> {
    let touches = args.touches.clone().unwrap_or_default();
    let mut outputs = outputs([touches.as_path()].into_iter().chain(profile_file(&args.machine.profile).as_deref()));
    let output = args.output.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let machine = args.machine.profile.as_str().into();
    let options = FitOptions { square: args.assume_square, tolerance_mm: args.tolerance };
    let request = CalibrateRequest { machine, touches: Source::from(&touches), options };
    let done = job::calibrate_by(&request, &console.world())?;
    if console.json() {
        console.document(&document::measured(&done));
    } else {
        console.result(&text::measured(&done));
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

fn tower(args: &Calibrate, folder: &Path, console: &Console) -> Result<(), Failure> {
    let mut outputs = outputs(profile_file(&args.machine.profile).as_deref());
    outputs.folder(folder)?;
    // What was typed into it is never lost.
    let form = job::keep_form(&folder.join("measured.toml"), &mut outputs, &console.world())?;
    let [gcode, plan, model] = ["tower.gcode", "tower.json", TowerResult::MODEL].map(|name| folder.join(name));
    let [gcode, plan, model] = [outputs.claim(&gcode)?, outputs.claim(&plan)?, outputs.claim(&model)?];
    let sheet = PictureFile::claim("tower", Some(&folder.join("sheet.svg")), &mut outputs)?;
    let done = job::tower(&args.tower(), Some(folder), &console.world())?;
    model.write(&done.model)?;
    plan.write(done.plan.plan.to_text().as_bytes())?;
    gcode.write(done.gcode.program())?;
    sheet.map(|sheet| sheet.write(&done.sheet())).transpose()?;
    form.write(done.form.as_bytes())?;
    if console.json() {
        console.document(&document::tower(&done, folder));
    } else {
        console.result(&text::tower(&done, folder));
    }
    Ok(())
}

fn poses(args: &Calibrate, form: &Path, console: &Console) -> Result<(), Failure> {
    let mut outputs = outputs(profile_file(&args.machine.profile).as_deref());
    let form = outputs.claim(form)?;
    let gcode = args.gcode.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let done = job::poses(&args.asked(), &console.world())?;
    if console.json() {
        console.document(&document::poses(&done));
    } else {
        console.result(&text::poses(&done));
    }
    if let Some(gcode) = gcode {
        let visit = done.visit.as_ref().map_err(|why| Failure::Findings(format!("no G-code was written: {why}")))?;
        let left = visit.left_out.join(", ");
        if !left.is_empty() {
            console.warning(&format!("start lines that heat, move or are unknown are omitted from the G-code: {left}"));
        }
        gcode.write(visit.gcode.as_bytes())?;
    }
    Ok(form.write(done.form.as_bytes())?)
}

fn list(console: &Console) -> Result<(), Failure> {
    let mut rows = Vec::new();
    let mut text = String::new();
    for (name, _, _) in SHIPPED {
        let checked = job::check_profile(&name.into(), &console.world())?;
        let _ = writeln!(text, "{name:20} {}", text::machine(&checked));
        rows.push(document::shipped(&checked));
    }
    for (name, file, checked) in &job::own_machines(&console.world()) {
        match checked {
            Ok(own) => {
                let _ = writeln!(text, "{name:20} {}; your own: {}", text::machine(own), file.display());
            }
            Err(error) => console.warning(&error.to_string()),
        }
        rows.push(document::own(name, file, checked));
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
