//! `trunnion split`

use super::args::Split as Verb;
use super::requests::{outputs, profile_file};
use super::{Console, Failure};
use crate::document;
use crate::job::{self, ConvexRequest, GivenCut, MachineSource, PictureFile, SplitOptions, SplitRequest};
use crate::spelling::numbers;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let word = args.profile.as_deref().filter(|_| !args.convex).unwrap_or_default();
    let profile = profile_file(word);
    let mut outputs = outputs([args.model.model.as_path()].into_iter().chain(profile.as_deref()));
    let output = args.output.as_deref().map(|path| outputs.claim(path)).transpose()?;
    if output.is_none() && !console.json() {
        return Err(Failure::Usage(
            "no file is named for the parts; add -o PARTS.3mf, or --json to print what would be cut".to_owned(),
        ));
    }
    let write = |parts: &dyn Fn() -> Vec<u8>| output.as_ref().map_or(Ok(()), |output| output.write(&parts()));
    let viewed = PictureFile::claim("view", args.view.as_deref(), &mut outputs)?;
    if args.convex {
        let request = ConvexRequest { model: args.model.source()?, concavity_mm: args.concavity };
        let done = job::convex(&request, &console.world())?;
        write(&|| done.threemf())?;
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
        part: args.part,
        machine: MachineSource::from(word),
        standing: args.up.unwrap_or_default(),
        options: args.options()?,
    };
    let done = job::split(&request, &console.world())?;
    let why_not = done.why_not();
    if why_not.is_none() {
        write(&|| done.threemf())?;
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
            cuts: self.cut.iter().map(|text| plane(text)).collect::<Result<_, _>>()?,
            pedestal_mm: self.pedestal,
            budget: None,
            tries: self.budget,
        })
    }
}

/// The plane of `--cut`.
pub(super) fn plane(text: &str) -> Result<GivenCut, Failure> {
    let how = "must be four numbers, a direction and how far along it in mm, for example --cut 1,0,1,25; before them PART: of several parts, behind them @X,Y,Z for each piece to take";
    GivenCut::parsed(text).ok_or_else(|| Failure::Usage(format!("--cut {text}: {how}")))
}

/// The box of `--no-cut`.
fn corners(text: &str) -> Result<[[f64; 3]; 2], Failure> {
    let corners = numbers(text).map(|[a, b, c, d, e, f]| [[a, b, c], [d, e, f]]);
    let how = "must be six numbers in mm, two corners, for example --no-cut -5,-5,0,5,5,20";
    corners.ok_or_else(|| Failure::Usage(format!("--no-cut {text}: {how}")))
}
