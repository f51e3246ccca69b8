//! `trunnion prepare`: the whole way, with one file at the end or none.

use std::path::PathBuf;

use super::args::Prepare as Verb;
use super::requests::{folder_of, outputs, profile_file, supporting};
use super::{Console, Failure, plan, preview, send, verify};
use crate::document::{self, text};
use crate::job::{
    self, Cutting, Error, OutputFile, PictureFile, PlanOptions, PrepareRequest, PrepareResult, PrintError, SendRequest,
    StrategyError, WaysOut,
};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let configs = args.slicing.slicer_config.iter().map(PathBuf::as_path);
    let profile = profile_file(&args.machine.profile);
    let models = args.arrange.files(&args.model.model);
    let read = models.iter().map(PathBuf::as_path).chain(profile.as_deref());
    let mut outputs = outputs(read.chain(configs));
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
    let (model, arrangement) = args.arrange.request(&args.model.model, &args.model.read, Some(&parts_file))?;
    let may_cut = parts.is_some() && args.split != "never";
    let file = parts_file.display().to_string();
    let request = PrepareRequest {
        model,
        machine: args.machine.source(),
        arrangement,
        plan: PlanOptions { kept_in: folder_of(args.plan_out.as_deref()), ..args.plan.options(&args.pass)? },
        slicing: args.slicing.options(&args.bed)?,
        ways: WaysOut {
            cutting: if may_cut { Cutting::Auto { file } } else { Cutting::Never },
            supporting: supporting(&args.supports, &args.plan)?,
            turning: true,
            only: args.only()?,
            ..WaysOut::NONE
        },
    };
    let done = job::prepare(&request, &console.world()).map_err(Error::from);
    if let (Err(Error::Print(PrintError::Rejected(no))), Some(page)) = (&done, page) {
        let shown = job::show_rejected(&output.path().display().to_string(), no, &console.world())?;
        shown.map(|shown| preview::write(&shown, page, args.open, console)).transpose()?;
    }
    let rejected = matches!(done, Err(Error::Print(PrintError::Rejected(_))));
    if rejected && !["auto", "builtin"].contains(&args.slicing.slicer.as_str()) {
        console.note("use --preview VIEW.html to inspect the slicer's output, or try --slicer builtin");
    }
    let done = match done {
        Err(Error::Strategy(StrategyError::NoPlan(_))) => plan::explained(done, None, console)?,
        done => verify::explained(done, console)?,
    };
    // Nothing is written where it cannot be made.
    let rehearsal = dry_run.as_ref().map(|_| job::dry_run(done.gcode.program(), &done.planned.plan)).transpose()?;
    plan_out.as_ref().map(|plan| plan.write(done.planned.plan.plan.to_text().as_bytes())).transpose()?;
    sheet.as_ref().map(|sheet| sheet.write(&done.planned.sheet())).transpose()?;
    text::ways(&done.planned.ways).lines().for_each(|line| console.note(line));
    let seconds = done.gcode.report().map_or(0.0, |report| report.seconds_print);
    done.held.iter().for_each(|held| console.note(&held.story(seconds)));
    done.cut.iter().for_each(|cut| console.note(&cut.story(seconds)));
    let arranged = done.planned.arranged.as_ref().map(|arranged| &arranged.bytes);
    let bytes = done.cut.as_ref().map(|cut| &cut.bytes).or(arranged);
    bytes.map(|bytes| plan::write_parts(&parts_file, parts.as_ref(), bytes, console)).transpose()?;
    if let (Some(file), Some(made)) = (dry_run, &rehearsal) {
        file.write(made.gcode.as_bytes())?;
        console.note(&format!("{}: {}", file.path().display(), text::cold(made)));
    }
    output.write(done.gcode.program())?;
    let machine = &done.planned.plan.machine;
    text::unseen(&machine.profile, &machine.name).iter().for_each(|text| console.note(text));
    if let Some(report) = done.gcode.report() {
        text::proved(&output.path().display().to_string(), &done, report).iter().for_each(|text| console.note(text));
        if console.json() {
            let mut document = document::prepared(&output.path().display().to_string(), &done, report);
            document["dry_run"] = rehearsal.as_ref().map(document::cold).into();
            console.document(&document);
        }
    }
    Ok(done)
}
