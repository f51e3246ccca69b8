//! `trunnion split`

use std::fmt::Write;

use super::args::Split as Verb;
use super::requests::{outputs, profile_file};
use super::{Console, Failure};
use crate::document;
use crate::job::{self, SplitOptions, SplitRequest, SplitResult};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let profile = profile_file(&args.machine.profile);
    let mut outputs = outputs([args.model.model.as_path()].into_iter().chain(profile.as_deref()));
    let output = outputs.claim(&args.output)?;
    let request =
        SplitRequest { model: args.model.source()?, machine: args.machine.source(), options: args.options()? };
    let done = job::split(&request, &console.world())?;
    let why_not = done.why_not();
    if why_not.is_none() {
        output.write(&done.threemf())?;
    }
    if console.json() {
        console.document(&document::split(&done));
    } else if why_not.is_none() {
        console.result(&text(&done));
    } else {
        console.note(&text(&done));
    }
    why_not.map_or(Ok(()), |why| Err(Failure::Findings(format!("{why}; no file was written"))))
}

impl Verb {
    fn options(&self) -> Result<SplitOptions, Failure> {
        Ok(SplitOptions {
            overhang_deg: self.overhang,
            margin_mm: self.margin,
            max_cuts: self.max_cuts,
            allow_mm2: self.allow,
            strict: self.strict,
            no_cut: self.no_cut.iter().map(|text| corners(text)).collect::<Result<_, _>>()?,
            pedestal_mm: self.pedestal,
        })
    }
}

/// The box of `--no-cut`.
fn corners(text: &str) -> Result<[[f64; 3]; 2], Failure> {
    let numbers: Vec<f64> =
        text.split(',').filter_map(|t| t.trim().parse().ok()).filter(|v: &f64| v.is_finite()).collect();
    match numbers[..] {
        [a, b, c, d, e, f] if text.split(',').count() == 6 => Ok([[a, b, c], [d, e, f]]),
        _ => Err(Failure::Usage(format!(
            "--no-cut {text}: not six numbers of millimetres; write two corners, as --no-cut -5,-5,0,5,5,20"
        ))),
    }
}

fn text(done: &SplitResult) -> String {
    let split = &done.split;
    let mut out = String::new();
    for (k, cut) in split.cuts.iter().enumerate() {
        let (n, c) = (cut.plane.normal, cut.plane.offset_mm);
        let parts: Vec<String> = cut.parts.iter().map(ToString::to_string).collect();
        let _ = writeln!(
            out,
            "cut {}: {:.4} x {:+.4} y {:+.4} z > {c:.3} mm becomes part {}, seam {:.1} mm2; {}",
            k + 1,
            n.x,
            n.y,
            n.z,
            parts.join(", "),
            cut.seam_mm2,
            cut.reason()
        );
    }
    let (before, after) = (split.before.area_mm2, split.after.area_mm2);
    let _ = writeln!(
        out,
        "{} parts, {} setups, seams {:.1} mm2; needs support: {before:.1} mm2 before, {after:.1} after; {:.2} s",
        split.parts.len(),
        split.setups(),
        split.seam_mm2(),
        done.seconds
    );
    out
}
