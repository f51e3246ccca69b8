//! `trunnion split`

use serde_json::{Value, json};

use super::args::Split as Verb;
use super::requests::{outputs, profile_file};
use super::{Console, Failure};
use crate::job::{self, SplitOptions, SplitRequest, SplitResult};
use crate::split::{CutMade, CutPart, PatchLeft, Unsupported};

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
        console.document(&document(&done));
    } else if why_not.is_none() {
        console.result(&done.text());
    } else {
        console.note(&done.text());
    }
    why_not.map_or(Ok(()), |why| Err(Failure::Findings(format!("{why}; no file was written"))))
}

impl Verb {
    fn options(&self) -> Result<SplitOptions, Failure> {
        Ok(SplitOptions {
            overhang_deg: self.overhang,
            bridge_mm: self.pass.bridge,
            tolerate_mm2: self.pass.tolerate,
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

fn needs(needs: &Unsupported) -> Value {
    json!({"area_mm2": needs.area_mm2, "beginnings": needs.beginnings, "ridges": needs.ridges})
}

pub(super) fn document(done: &SplitResult) -> Value {
    let split = &done.split;
    let plane = |cut: &CutMade| {
        json!({
            "normal": cut.plane.normal.as_slice(), "offset_mm": cut.plane.offset_mm, "part": cut.parts.first(),
            "parts": cut.parts, "seam_mm2": cut.seam_mm2, "gain_mm2": cut.gain_mm2, "reason": SplitResult::reason(cut),
        })
    };
    let order = |(id, part): (usize, &CutPart)| {
        json!({
            "part": id, "name": split.name(id), "up": part.up.as_slice(), "cut": part.cut,
            "volume_mm3": part.mesh.volume(), "needs_support": needs(&part.needs),
        })
    };
    let left = |p: &PatchLeft| json!({"part": p.part, "area_mm2": p.area_mm2, "at_mm": p.at.as_slice()});
    let worth_a_word = split.left.iter().filter(|p| p.area_mm2 > 0.01);
    json!({
        "planes": split.cuts.iter().map(plane).collect::<Vec<_>>(),
        "parts": split.parts.len(),
        "order": split.parts.iter().enumerate().map(order).collect::<Vec<_>>(),
        "needs_support_mm2": {"before": split.before.area_mm2, "after": split.after.area_mm2},
        "needs_support": {"before": needs(&split.before), "after": needs(&split.after)},
        "left": worth_a_word.map(left).collect::<Vec<_>>(),
        "seam_mm2": split.seam_mm2(), "setups": split.setups(), "pedestal_mm": done.pedestal_mm,
        "printable": split.printable, "reasons": done.why_not().into_iter().collect::<Vec<_>>(),
        "seconds": done.seconds,
    })
}
