//! `trunnion split`

use super::args::Split as Verb;
use super::requests::{outputs, profile_file};
use super::{Console, Failure};
use crate::document;
use crate::job::{self, ConvexRequest, MachineSource, PictureFile, SplitOptions, SplitRequest};
use crate::spelling::numbers;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let word = args.profile.as_deref().filter(|_| !args.convex).unwrap_or_default();
    let profile = profile_file(word);
    let mut outputs = outputs([args.model.model.as_path()].into_iter().chain(profile.as_deref()));
    let output = outputs.claim(&args.output)?;
    let viewed = PictureFile::claim("view", args.view.as_deref(), &mut outputs)?;
    if args.convex {
        let request = ConvexRequest { model: args.model.source()?, concavity_mm: args.concavity };
        let done = job::convex(&request, &console.world())?;
        output.write(&done.threemf())?;
        viewed.map(|viewed| viewed.write(&done.view())).transpose()?;
        if console.json() {
            console.document(&document::convex(&done));
        } else {
            console.summary(&done.text(), true);
        }
        return Ok(());
    }
    let request = SplitRequest {
        model: args.model.source()?,
        machine: MachineSource::from(word),
        standing: args.up.unwrap_or_default(),
        options: args.options()?,
    };
    let done = job::split(&request, &console.world())?;
    let why_not = done.why_not();
    if why_not.is_none() {
        output.write(&done.threemf())?;
    }
    // Also where it did not work: then it shows what is left.
    viewed.map(|viewed| viewed.write(&done.view())).transpose()?;
    if console.json() {
        console.document(&document::split(&done));
    } else if why_not.is_none() {
        console.summary(&done.text(), true);
    } else {
        console.note(&done.text());
    }
    why_not.map_or(Ok(()), |why| Err(Failure::Findings(format!("{why}; no parts were written"))))
}

impl Verb {
    fn options(&self) -> Result<SplitOptions, Failure> {
        Ok(SplitOptions {
            overhang_deg: self.overhang,
            finish: self.pass.finish.unwrap_or_default(),
            bridge_mm: self.pass.bridge,
            tolerate_mm2: self.pass.tolerate,
            margin_mm: self.margin,
            max_cuts: self.max_cuts,
            allow_mm2: self.allow,
            strict: self.strict,
            no_cut: self.no_cut.iter().map(|text| corners(text)).collect::<Result<_, _>>()?,
            pedestal_mm: self.pedestal,
            budget: None,
            tries: self.budget,
        })
    }
}

/// The box of `--no-cut`.
fn corners(text: &str) -> Result<[[f64; 3]; 2], Failure> {
    let corners = numbers(text).map(|[a, b, c, d, e, f]| [[a, b, c], [d, e, f]]);
    let how = "must be six numbers in mm, two corners, for example --no-cut -5,-5,0,5,5,20";
    corners.ok_or_else(|| Failure::Usage(format!("--no-cut {text}: {how}")))
}
