//! `trunnion support`

use super::args::Support as Verb;
use super::requests::outputs;
use super::{Console, Failure};
use crate::document::{self, text};
use crate::job::{self, PictureFile, SupportForm, SupportOptions, SupportRequest, is_3mf};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    args.output.as_deref().map(is_3mf).transpose()?;
    let mut outputs = outputs([args.model.model.as_path()]);
    let output = args.output.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let viewed = PictureFile::claim("view", args.view.as_deref(), &mut outputs)?;
    let request = SupportRequest { model: args.model.source()?, options: args.options() };
    let done = job::support(&request, &console.world())?;
    let why_not = done.why_not();
    if let Some(output) = output.filter(|_| !done.graph.red.is_empty()) {
        output.write(&done.file(output.path())?)?;
    } else if args.output.is_some() && why_not.is_none() {
        console.note("nothing overhangs, so no support file was written");
    }
    viewed.map(|viewed| viewed.write(&done.view())).transpose()?;
    if console.json() {
        console.document(&document::supported(&done));
    } else {
        console.summary(&text::supported(&done), args.output.is_some());
    }
    why_not.map_or(Ok(()), |why| Err(Failure::Findings(format!("{why}; no support file was written"))))
}

impl Verb {
    fn options(&self) -> SupportOptions {
        SupportOptions {
            up: self.up.0.into(),
            keep_z: self.keep_z,
            step_mm: self.step,
            space_mm: self.space.map(|space| space.0),
            overhang_deg: self.overhang,
            capacity: self.capacity,
            node_capacity: self.node_capacity,
            method: self.method.clone(),
            structure: self.structure.clone(),
            wall_mm: self.wall,
            gap_mm: self.gap,
            touch_every: self.touch_every,
            form: SupportForm { roof_mm: self.roof, roof_pitch_mm: self.roof_pitch, brace_mm: self.brace },
            seed: self.seed,
        }
    }
}
