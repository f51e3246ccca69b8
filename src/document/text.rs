//! The same results for people: tables and sentences on a terminal.

use std::ffi::OsStr;
use std::fmt::Write;
use std::path::Path;

pub use super::jog_text::{jog_question, jogged, unseen};
pub use super::machine_text::{calibrated, checked, cold, poses};
use super::model::apart;
pub use super::plan_text::{comparison, moved, no_plan, planned, searched, sequence, ways};
pub use super::prepare_text::{done_how, done_what, plate, proved};
use super::priced::{grams, minutes, plain};
pub use super::shape_text::{packed, supported};
pub use super::tower_text::{measured, tower};
use super::verified_text::list;
pub use super::verified_text::{refereed, verified};
use super::{figures, reasons};
use crate::job::{
    BatchResult, Batched, CheckedProfile, Compared, Fate, Listed, LoadedModel, Models, Oriented, OrientedPart,
    PublishResult, SliceResult,
};
use crate::mesh::Model;
use crate::orient::{Priced, Process, Recommendation, Stop, to_angles};
use crate::publish::UploadFigures;
use crate::spelling::counted;

/// A file that any printer takes and no printer moves on: in the place of one that was not rewritten, for that reason.
pub fn unprintable(reason: &str) -> String {
    let reason = reason.replace(['\n', '\r'], " ");
    format!("; trunnion: not printable, nothing was rewritten\n; {reason}\nM117 trunnion: not printable\n")
}

/// A search that may be ended early.
pub fn searching(known: &str) -> String {
    format!("searching for cheaper cuts; press Ctrl-C to stop and use {known}")
}

/// What was read: the file, its parts and its size, so that a wrong unit is seen at once.
pub fn read(loaded: &LoadedModel) -> String {
    let file = Path::new(&loaded.file).file_name().map_or(loaded.file.as_str().into(), OsStr::to_string_lossy);
    let size = loaded.model.bounds.size();
    let parts = counted(loaded.model.parts.len(), "part");
    format!("{file}: {parts}, {:.1} x {:.1} x {:.1} mm", size.x, size.y, size.z)
}

/// By whom prints were sliced.
pub fn sliced(done: &SliceResult) -> String {
    format!("{} sliced by {} {}", counted(done.sliced.len(), "print"), done.slicer.name, done.slicer.version)
}

/// `trunnion inspect`.
pub fn inspected(model: &Model) -> String {
    let mut out = String::new();
    let size = model.bounds.size();
    let _ = writeln!(
        out,
        "{}, {:.2} x {:.2} x {:.2} mm, read in {}",
        counted(model.parts.len(), "part"),
        size.x,
        size.y,
        size.z,
        model.unit.short()
    );
    let _ = writeln!(out, "\npart  facets  volume mm3   area mm2  size mm                 name");
    for p in &model.parts {
        let s = p.mesh.bounds().size();
        let size = format!("{:.2} x {:.2} x {:.2}", s.x, s.y, s.z);
        let (volume, area) = (p.mesh.volume(), p.mesh.area());
        let _ = writeln!(out, "{:4} {:7} {volume:11.1} {area:10.1}  {size:23} {}", p.id, p.mesh.facets().len(), p.name);
    }
    let _ = writeln!(out, "\non the table: {}", list(&model.on_table));
    if !model.others.is_empty() {
        let each = model
            .others
            .iter()
            .map(|other| format!("{} ({})", if other.name.is_empty() { "a volume" } else { &other.name }, other.role));
        let _ = writeln!(out, "not printed: {}", each.collect::<Vec<_>>().join(", "));
    }
    for i in &model.interfaces {
        let _ = writeln!(out, "parts {} and {} share {:.2} mm2", i.a, i.b, i.area_mm2);
    }
    if !model.captive.is_empty() {
        let _ = writeln!(out, "captive, printed in place: {}", list(&model.captive));
    }
    if !model.floating().is_empty() {
        let _ = writeln!(out, "not connected to the table: {}", list(&model.floating()));
    }
    for (part, (other, mm)) in apart(model) {
        let _ = writeln!(out, "part {part} is {mm:.2} mm away from part {other}");
    }
    out
}

/// Minima shown of each objective.
const SHOWN: usize = 8;

/// `trunnion orient`, one part.
pub fn oriented(part: &OrientedPart) -> String {
    let mut out = format!("part {}, {} facets\n", part.id, part.mesh.facets().len());
    for result in &part.results {
        match &result.recommendation {
            Some((made, process)) => recommended(result, made, process, &mut out),
            None => result_text(result, &mut out),
        }
    }
    part.compared.iter().for_each(|rows| table(rows, &mut out));
    out.push('\n');
    out
}

fn result_text(result: &Oriented, out: &mut String) {
    let found = &result.found;
    let proof = match found.lower_bound {
        Some(bound) => format!("proved lower bound {bound:.9e}{}", gap(result, bound)),
        None => result.unproved.as_ref().map_or("not proved".to_owned(), |why| format!("not proved ({why})")),
    };
    let (evaluations, seconds) = (found.evaluations, result.seconds);
    let _ = writeln!(
        out,
        "\n  {} by {}: {proof}, {evaluations} evaluations, {seconds:.2} s",
        result.objective, result.method
    );
    let _ = writeln!(out, "    value             up                              alpha     beta  deg");
    for m in found.minima.iter().take(SHOWN) {
        let (alpha, beta) = to_angles(&m.up);
        let up = format!("({:.5}, {:.5}, {:.5})", m.up.x, m.up.y, m.up.z);
        let (alpha, beta) = (alpha.to_degrees(), beta.to_degrees());
        let _ = writeln!(out, "    {:<17.9e} {up:30} {alpha:8.3} {beta:8.3}  {}", m.value + 0.0, result.kind(m));
    }
    if let Some(value) = result.finer {
        let _ = writeln!(out, "    the best with columns four times finer: {value:.3}");
    }
    if found.minima.len() > SHOWN {
        let _ = writeln!(out, "    and {} more; --json lists them", found.minima.len() - SHOWN);
    }
}

/// What is recommended, why, and what stands against it.
fn recommended(result: &Oriented, made: &Recommendation, process: &Process, out: &mut String) {
    let Process { layer_mm, line_mm, infill, .. } = process;
    let _ = writeln!(
        out,
        "\n  {}: layers of {layer_mm} mm, lines of {line_mm} mm, {:.0} % infill; {} poses priced, {:.2} s",
        result.objective,
        infill * 100.0,
        made.evaluations,
        result.seconds
    );
    reasons(made).iter().for_each(|reason| _ = writeln!(out, "    - {reason}"));
    let head = ["price min", "grams", "minutes", "support mm3", "first mm2", "tips deg", "height mm"];
    let _ = write!(out, "\n    {:15}", "");
    head.iter().for_each(|name| _ = write!(out, " {name:>11}"));
    let _ = writeln!(out, "  stands  up");
    let mut row = |name: &str, p: &Priced| {
        let figures = [p.price_min, grams(p), minutes(p), p.support_mm3, p.footprint_mm2, p.tipping_deg, p.height_mm];
        let _ = write!(out, "    {name:15}");
        figures.iter().for_each(|value| _ = write!(out, " {:>11.1}", value + 0.0));
        let [x, y, z] = plain(&p.up);
        let stands = if p.stands { "yes" } else { "no" };
        let _ = writeln!(out, "  {stands:6}  ({x:.5}, {y:.5}, {z:.5})");
    };
    row("recommended", &made.recommended);
    made.runners.iter().for_each(|runner| row(runner.role.name(), &runner.pose));
    row("as in the file", &made.as_it_lies);
    made.own.iter().for_each(|own| row("yours", own));
    let gap = 100.0 * (1.0 - made.at_least_min / made.recommended.price_min);
    let _ = writeln!(
        out,
        "    lower bound: no pose costs less than {:.1} min (the part without supports, at the least height), {gap:.1} % below the recommended one{}",
        made.at_least_min,
        if result.is_proved() { "" } else { ", which is not proved to be the best" }
    );
}

/// The gap in words.
fn gap(result: &Oriented, bound: f64) -> String {
    let best = result.best().value;
    let gap = if best == bound { 0.0 } else { (best - bound) / best.abs() };
    let end = if result.found.stop == Stop::Budget { ", budget exhausted" } else { "" };
    if gap.is_finite() && bound != 0.0 {
        format!(" (gap {gap:.1e}{end})")
    } else {
        format!(" (gap {:.3e}{end})", best - bound)
    }
}

fn table(rows: &[Compared], out: &mut String) {
    let wide = rows.iter().map(|row| row.name.len()).max().unwrap_or(0);
    let _ = write!(out, "\n  {:wide$}", "");
    rows.first().map(figures).into_iter().flatten().for_each(|(name, ..)| _ = write!(out, " {name:>14}"));
    for row in rows {
        let _ = write!(out, "\n  {:wide$}", row.name);
        figures(row).into_iter().for_each(|(.., value)| _ = write!(out, " {value:>14.4}"));
    }
    out.push('\n');
}

/// What is said of a file that goes to a printer unverified.
pub fn sent_unverified(path: &Path) -> String {
    format!("{} is not verified: the head may hit the part, the table or the frame", path.display())
}

/// Where a file of an earlier run is now.
pub fn set_aside(to: &Path) -> String {
    format!("renamed the file of an earlier run to {}", to.display())
}

/// What is said of a page without the program's lines.
pub const WITHOUT_LINES: &str = "the G-code lines are left out, since they would make the page too large";

/// Why a file without its plan is not published.
pub const ONLY_VERIFIED_IS_PUBLISHED: &str = "only a verified file is published; pass its plan with --plan PLAN.json, or skip all collision checks with --unverified";

/// Why a model alone is not enough to verify by.
pub const MODEL_NEEDS_A_PLAN: &str = "--model needs --plan: the plan says where the model is on the table";

/// What is said of a file that goes to a server unverified.
pub const PUBLISHED_UNVERIFIED: &str = "the file is not verified: the head may hit the part, the table or the frame; \
    the server's firmware was not compared with the file's";

/// A file on the server of a printer.
pub fn published(done: &PublishResult) -> String {
    let PublishResult { to, name, bytes, sha256, delivered, stated, .. } = done;
    let how = if delivered.uploads == 0 { "was there already" } else { "uploaded" };
    let started = if delivered.started { "; its print has started" } else { "" };
    let mut out = format!(
        "{}: {name} {how}, {bytes} bytes, identical to the local file (sha256 {sha256:.12}..){started}\n",
        to.kind
    );
    for (who, figures) in [("stated", stated), ("shown there", &delivered.shown)] {
        let UploadFigures { seconds, filament_mm, layers } = figures;
        let known = [
            seconds.map(|s| format!("about {:.0} min", s / 60.0)),
            filament_mm.map(|mm| format!("{:.2} m of filament", mm / 1000.0)),
            layers.map(|layers| counted(usize::try_from(layers).unwrap_or(usize::MAX), "layer")),
        ];
        let known: Vec<String> = known.into_iter().flatten().collect();
        let all = if known.is_empty() {
            "not scanned yet (the server scans files in the background)".to_owned()
        } else {
            known.join(", ")
        };
        let _ = writeln!(out, "  {who}: {all}");
    }
    out
}

/// Flags of many models, given one.
pub const BATCH_FLAGS: &str =
    "--jobs, --share and --retry are for many models; give a folder, or a .txt list with one model a line";

/// Many models without a place for their results.
pub fn batch_output(models: &Models) -> String {
    let (path, what) = match models {
        Models::Folder(path) => (path, "a folder"),
        Models::List(path) => (path, "a list of models"),
    };
    let path = path.display();
    format!("{path} is {what}; give a file name, or -o DIR for the results of all its models")
}

/// What became of one model of many.
pub fn batched(one: &Batched) -> String {
    let model = one.model.display();
    match &one.fate {
        Fate::Done => format!("{model}: done in {:.1} s", one.seconds),
        Fate::Skipped => format!("{model}: already done"),
        Fate::Failed { why, .. } => format!("{model}: {why}"),
    }
}

/// Many models.
pub fn batch(done: &BatchResult) -> String {
    let BatchResult { done, skipped, failed, seconds } = done;
    format!("{done} done, {skipped} already done, {} failed, {seconds:.1} s", failed.len())
}

/// The end of a batch in which some failed.
pub fn batch_failed(done: &BatchResult) -> String {
    format!(
        "{} failed, listed above; repeat the command with --retry to try them again",
        counted(done.failed.len(), "model")
    )
}

/// What is asked at a terminal about a key of a profile, and what Enter does: it takes the value of `base`, or is no answer.
pub fn question(key: &str, text: &str, base: Option<&str>) -> String {
    let enter = base.map_or("an answer is required".to_owned(), |base| format!("Enter: as in {base}"));
    format!("{text} ({key}); {enter}")
}

/// How many sequences there are.
pub fn listed(done: &Listed) -> String {
    let Listed { count, complete, seconds, .. } = done;
    if *complete {
        format!("all {count} sequences, {seconds:.2} s")
    } else {
        format!("{count} sequences in {seconds:.2} s, and more exist; raise --limit or --budget")
    }
}

/// A machine, whether it has run, and what fits on it.
pub fn machine(checked: &CheckedProfile) -> String {
    let machine = &checked.machine.profile.machine;
    let tested = match &machine.tested_on[..] {
        [] => "no real machine yet".to_owned(),
        machines => machines.join(", "),
    };
    let [wide, high] = checked.largest_level_mm;
    let any = checked.largest_any_mm;
    let tilted = if any < 1.0 { "none at every tilt".to_owned() } else { format!("{any:.0} mm at every tilt") };
    format!("{}; tested on: {tested}; largest object: {wide:.0} x {high:.0} mm level, {tilted}", machine.about)
}

/// `trunnion explain`: an entry of the list of messages.
pub fn entry(entry: &serde_json::Value) -> String {
    let words = |of: &serde_json::Value| of.as_str().unwrap_or_default().to_owned();
    let says = entry["says"].as_array().into_iter().flatten().map(|text| format!("  message: {}\n", words(text)));
    format!("{}: {}\n{}", words(&entry["code"]), words(&entry["meaning"]), says.collect::<String>())
}

/// `trunnion explain` of something else.
pub fn no_such_code(given: &str, near: &str) -> String {
    format!("{given}: unknown code; the nearest is {near}")
}
