//! `trunnion rewrite`: offline, or as a slicer's post-processing script.
//!
//! As a script the file is the last argument and is changed in place. A slicer may ignore our exit code and keep the file
//! (PrusaSlicer's command line and Slic3r do), so that on failure the file itself is made unprintable.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::args::Rewrite as Verb;
use super::load::LoadedPlan;
use super::verify::{document, prove};
use super::{Console, Failure, files, load};
use crate::planning::{Plan, Workpiece};
use crate::profile::Profile;
use crate::slicing::config_values;
use crate::toolpath::{Input, Job, Segment, project_layout, read_sliced, rewrite, slot_mesh};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let [target] = (if args.in_place { &args.files[..] } else { args.output.as_slice() }) else {
        return Err(Failure::Usage(format!("--in-place takes one file, not {}", args.files.len())));
    };
    if !args.in_place {
        let sources = args.files.iter().map(PathBuf::as_path);
        files::check_output(target, &sources.chain([args.plan.as_path()]).collect::<Vec<_>>())?;
    }
    let done = work(args, console).and_then(|(gcode, document)| {
        files::write(target, &gcode)?;
        Ok(document)
    });
    match done {
        Ok(document) => {
            if console.json() {
                console.document(&document);
            }
            Ok(())
        }
        Err(failure) => {
            if args.in_place {
                files::write(target, unprintable(&failure).as_bytes())?;
            } else if let Some(aside) = files::set_aside(target) {
                console.warning(&format!("the file of an earlier run is now {}", aside.display()));
            }
            Err(failure)
        }
    }
}

/// A file that any printer takes and no printer moves on.
fn unprintable(failure: &Failure) -> String {
    let reason = failure.to_string().replace(['\n', '\r'], " ");
    format!("; trunnion: not printable, nothing was rewritten\n; {reason}\nM117 trunnion: not printable\n")
}

fn work(args: &Verb, console: &Console) -> Result<(Vec<u8>, serde_json::Value), Failure> {
    let loaded = load::plan(&args.plan, &args.plan_ref, console)?;
    let bed = load::bed(&args.bed)?;
    let mut sources = Vec::new();
    for path in &args.files {
        sources.push((path.display().to_string(), files::read(path)?));
    }
    let mut all = Vec::new();
    for (index, (file, bytes)) in sources.iter().enumerate() {
        let segments = read_prints(bytes, file)?;
        all.push((index, segments));
    }
    let workpiece = loaded.workpiece();
    let prints = assign(args, &sources, &all, &loaded)?;
    let inputs: Vec<Input<'_>> = prints
        .iter()
        .map(|p| Input {
            print: p.print,
            centre_mm: p.centre(&loaded.plan, &workpiece, &loaded.machine.profile, bed),
            file: &sources[p.source].0,
            bytes: &sources[p.source].1,
            sliced: &p.segment.sliced,
        })
        .collect();
    finish(&inputs, &loaded.plan, &loaded.sha256, &loaded.machine.profile, &workpiece, console)
}

/// The prints of a sliced file; heat that no line of it sets is taken from the settings at its end.
pub(super) fn read_prints(bytes: &[u8], file: &str) -> Result<Vec<Segment>, Failure> {
    let mut segments = read_sliced(bytes, file)?;
    let settings = config_values(bytes);
    let celsius = |keys: [&str; 2]| {
        let first_tool = |key: &str| settings.get(key)?.split([',', ';']).next()?.trim().parse::<f64>().ok();
        keys.into_iter().filter_map(first_tool).find(|&c| c > 0.0)
    };
    for segment in &mut segments {
        let sliced = &mut segment.sliced;
        sliced.nozzle_c = sliced.nozzle_c.or_else(|| celsius(["first_layer_temperature", "temperature"]));
        sliced.bed_c = sliced.bed_c.or_else(|| celsius(["first_layer_bed_temperature", "bed_temperature"]));
    }
    Ok(segments)
}

/// Rewrites and verifies; the bytes come back only if nothing was found.
pub(super) fn finish(
    inputs: &[Input<'_>],
    plan: &Plan,
    plan_sha256: &str,
    profile: &Profile,
    workpiece: &Workpiece<'_>,
    console: &Console,
) -> Result<(Vec<u8>, serde_json::Value), Failure> {
    let rewritten = rewrite(inputs, &Job { plan, plan_sha256, profile, workpiece })?;
    rewritten.warnings.iter().for_each(|w| console.warning(w));
    let (report, seconds) = prove(&rewritten.gcode, plan, profile, workpiece, console)?;
    Ok((rewritten.gcode, json!({"verify": document(&report, seconds)})))
}

/// A print found in a file.
struct Assigned<'a> {
    print: usize,
    source: usize,
    segment: &'a Segment,
    /// Whether it comes from a project with all prints side by side.
    in_project: bool,
}

impl Assigned<'_> {
    fn centre(&self, plan: &Plan, workpiece: &Workpiece<'_>, profile: &Profile, bed: [f64; 2]) -> [f64; 2] {
        let middle = [bed[0] / 2.0, bed[1] / 2.0];
        if !self.in_project {
            return middle;
        }
        let table = profile.kinematics();
        let sizes: Vec<_> =
            plan.prints().map(|(_, p)| slot_mesh(workpiece, &table, p, middle).mesh.bounds().size()).collect();
        project_layout(&sizes).0.get(self.print).copied().unwrap_or(middle)
    }
}

fn assign<'a>(
    args: &Verb,
    sources: &[(String, Vec<u8>)],
    all: &'a [(usize, Vec<Segment>)],
    loaded: &LoadedPlan,
) -> Result<Vec<Assigned<'a>>, Failure> {
    let only = loaded.plan.prints().count() == 1;
    let mut found = Vec::new();
    for (source, segments) in all {
        let in_project = segments.len() > 1;
        for segment in segments {
            let named = || print_of_file(&args.files[*source]);
            let print = args.print.or(segment.print).or_else(named).or(only.then_some(0)).ok_or_else(|| {
                Failure::Usage(format!(
                    "{}: which print is it? name the file print-NN.., label objects in the slicer, or give --print N",
                    sources[*source].0
                ))
            })?;
            found.push(Assigned { print, source: *source, segment, in_project });
        }
    }
    Ok(found)
}

/// The number in a name like `print-03-arm.gcode`.
fn print_of_file(path: &Path) -> Option<usize> {
    let name = path.file_name()?.to_str()?;
    let digits: String = name.strip_prefix("print-")?.chars().take_while(char::is_ascii_digit).collect();
    digits.parse().ok()
}
