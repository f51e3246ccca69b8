//! `trunnion prepare`: the whole way, with one file at the end or none.

use std::path::{Path, PathBuf};

use super::args::Prepare as Verb;
use super::requests::{folder_of, outputs, profile_file, supporting};
use super::{Console, Failure, plan, preview, send, split, verify};
use crate::document::{self, text};
use crate::job::{
    self, Cutting, Error, OutputFile, Outputs, PictureFile, PlanOptions, PlateEvent, PlateFolder, PrepareRequest,
    PrepareResult, PrintError, SendRequest, StrategyError, WaysOut,
};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    if let Some(folder) = &args.plates {
        return plates(args, folder, console);
    }
    let mut outputs = outputs_of(args);
    let output = outputs.claim(&args.output(&console.world())?)?;
    let plan_out = args.plan_out.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let journal = args.port.as_ref().map(|_| outputs.claim(&args.stream.journal(output.path()))).transpose()?;
    let sheet = PictureFile::claim("sheet", args.sheet.as_deref(), &mut outputs)?;
    args.preview.as_deref().map(|path| job::is_page("preview", path)).transpose()?;
    let page = args.preview.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let dry_run = args.dry_run.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let certificate = args.certificate.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let parts = outputs.claim_unless_taken(&plan::parts_file(output.path()))?;
    let files = SideFiles { plan_out, parts, sheet, page, dry_run };
    let done = work(args, &output, &files, console);
    if done.is_err() {
        console.set_aside(&output)?;
        verify::uncertify(certificate.as_ref(), console)?;
    }
    let done = done?;
    verify::certify(certificate.as_ref(), output.path(), &done.gcode, &done.planned.plan)?;
    if let (Some(page), Some(report)) = (&files.page, done.gcode.report()) {
        let (name, plan) = (output.path().display().to_string(), &done.planned.plan);
        let mut shown = job::show(&name, done.gcode.program(), plan, report, &console.world())?;
        shown.ways.clone_from(&done.planned.ways);
        preview::write(&shown, page, args.open, console)?;
    }
    let (Some(port), Some(journal)) = (&args.port, journal) else { return Ok(()) };
    // A file that is proved stays, whatever becomes of the printer.
    let plan = &done.planned.plan;
    let (path, program, machine, options) = (output.path(), &done.gcode, &plan.machine, &args.stream.options());
    let request = SendRequest { path, program, machine, plan: Some(plan), options };
    send::stream(&request, port, &journal, &args.stream, console)
}

/// The right to write, for a call that reads all that `args` name.
fn outputs_of(args: &Verb) -> Outputs {
    let configs = args.slicing.slicer_config.iter().map(PathBuf::as_path);
    let profile = profile_file(&args.machine.profile);
    let models = args.arrange.files(&args.model.model);
    outputs(models.iter().map(PathBuf::as_path).chain(profile.as_deref()).chain(configs))
}

/// What is asked of the job; `parts_file` is where the model goes as it is printed.
fn request(args: &Verb, parts_file: &Path, may_write_parts: bool) -> Result<PrepareRequest, Failure> {
    let (model, arrangement) = args.arrange.request(&args.model.model, &args.model.read, Some(parts_file))?;
    let may_cut = may_write_parts && args.split != "never";
    let file = parts_file.display().to_string();
    if !may_write_parts && !args.cut.is_empty() {
        return Err(Failure::Usage(format!(
            "--cut: the parts would be written to {file}, which is an input or another output; name another output with -o"
        )));
    }
    Ok(PrepareRequest {
        model,
        machine: args.machine.source(),
        arrangement,
        plan: PlanOptions { kept_in: folder_of(args.plan_out.as_deref()), ..args.plan.options(&args.pass)? },
        slicing: args.slicing.options(&args.bed)?,
        ways: WaysOut {
            cutting: if may_cut { Cutting::Auto { file } } else { Cutting::Never },
            cuts: args.cut.iter().map(|text| split::plane(text)).collect::<Result<_, _>>()?,
            supporting: supporting(&args.supports, &args.plan)?,
            turning: true,
            only: args.only()?,
            ..WaysOut::NONE
        },
    })
}

/// What is written beside the program.
struct SideFiles {
    plan_out: Option<OutputFile>,
    parts: Option<OutputFile>,
    sheet: Option<PictureFile>,
    page: Option<OutputFile>,
    dry_run: Option<OutputFile>,
}

fn work(args: &Verb, output: &OutputFile, files: &SideFiles, console: &Console) -> Result<PrepareResult, Failure> {
    let SideFiles { plan_out, parts, sheet, page, dry_run } = files;
    let parts_file = plan::parts_file(output.path());
    let request = request(args, &parts_file, parts.is_some())?;
    let done = job::prepare(&request, &console.world()).map_err(Error::from);
    if let (Err(Error::Print(PrintError::Rejected(no))), Some(page)) = (&done, page) {
        let shown = job::show_rejected(&output.path().display().to_string(), no, &console.world())?;
        shown.map(|shown| preview::write(&shown, page, args.open, console)).transpose()?;
    }
    let rejected = matches!(done, Err(Error::Print(PrintError::Rejected(_))));
    if rejected && !["auto", "builtin"].contains(&args.slicing.slicer.as_str()) {
        console.note("use --preview VIEW.html to inspect the slicer's output, or try --slicer builtin");
    }
    let done = explained(done, console)?;
    // Nothing is written where it cannot be made.
    let rehearsal = dry_run.as_ref().map(|_| job::dry_run(done.gcode.program(), &done.planned.plan)).transpose()?;
    plan_out.as_ref().map(|plan| plan.write(done.planned.plan.plan.to_text().as_bytes())).transpose()?;
    sheet.as_ref().map(|sheet| sheet.write(&done.planned.sheet())).transpose()?;
    text::done_how(&done).iter().for_each(|line| console.note(line));
    let arranged = done.planned.arranged.as_ref().map(|arranged| &arranged.bytes);
    let bytes = done.cut.as_ref().map(|cut| &cut.bytes).or(arranged);
    bytes.map(|bytes| plan::write_parts(&parts_file, parts.as_ref(), bytes, console)).transpose()?;
    if let (Some(file), Some(made)) = (dry_run, &rehearsal) {
        file.write(made.gcode.as_bytes())?;
        console.note(&format!("{}: {}", file.path().display(), text::cold(made)));
    }
    output.write(done.gcode.program())?;
    let name = output.path().display().to_string();
    text::done_what(&name, &done).iter().for_each(|line| console.note(line));
    if let (Some(report), true) = (done.gcode.report(), console.json()) {
        let mut document = document::prepared(&name, &done, report);
        document["dry_run"] = rehearsal.as_ref().map(document::cold).into();
        console.document(&document);
    }
    Ok(done)
}

/// Says why nothing was made.
fn explained<T>(done: Result<T, Error>, console: &Console) -> Result<T, Failure> {
    match done {
        Err(Error::Strategy(StrategyError::NoPlan(_))) => plan::explained(done, None, console),
        done => verify::explained(done, console),
    }
}

/// `--plates DIR`
fn plates(args: &Verb, folder: &Path, console: &Console) -> Result<(), Failure> {
    let files = PlateFolder::claim(folder, outputs_of(args))?;
    files.earlier()?.iter().try_for_each(|earlier| console.set_aside(earlier))?;
    let mut documents = Vec::new();
    let mut told = |event: PlateEvent<'_>| {
        text::plate(&event).iter().for_each(|line| console.note(line));
        documents.extend(document::plate(&event));
    };
    let request = request(args, &plan::parts_file(folder), true)?;
    let done = job::prepare_plates(&request, files, &mut told, &console.world()).map_err(Error::from);
    explained(done, console)?;
    if console.json() {
        console.document(&document::plates(documents));
    }
    Ok(())
}
