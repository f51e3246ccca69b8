//! `trunnion pack`

use std::path::PathBuf;

use super::args::Pack as Verb;
use super::requests::{copies, outputs};
use super::{Console, Failure};
use crate::document;
use crate::job::{
    self, Contents, MachineSource, ModelSource, PackInto, PackOptions, PackRequest, PackResult, Source, interrupts,
};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let request = PackRequest { contents: args.contents()?, into: args.room(), options: args.options() };
    let files: Vec<PathBuf> = args.models.iter().map(|word| copies(word).0.into()).chain(args.boxes.clone()).collect();
    let mut outputs = outputs(files.iter().map(PathBuf::as_path));
    let plate = |folder: &PathBuf, index| folder.join(PackResult::file(index));
    if let Some(folder) = &args.output {
        outputs.folder(folder)?;
    }
    let first = args.output.as_ref().map(|folder| outputs.claim(&plate(folder, 0))).transpose()?;
    let viewed = args.view.as_deref().map(|path| outputs.claim(path)).transpose()?;
    // From here on an interrupt ends the search, and what was found so far is written.
    let asked = interrupts::Interrupts::listen();
    let done = job::pack(&request, &|| asked.count() > 0, &console.world())?;
    for (first, folder) in first.iter().zip(&args.output) {
        first.write(&done.threemf(0))?;
        for index in 1..done.plates.len() {
            outputs.claim(&plate(folder, index))?.write(&done.threemf(index))?;
        }
        // Runs of an earlier call beyond those of this one.
        for index in (done.plates.len()..).take_while(|index| plate(folder, *index).is_file()) {
            console.set_aside(&outputs.claim(&plate(folder, index))?)?;
        }
    }
    if let Some(viewed) = viewed {
        viewed.write(&done.view().png().map_err(|e| Failure::Usage(format!("{}: {e}", viewed.path().display())))?)?;
    }
    if console.json() {
        console.document(&document::packed(&done));
    } else {
        console.result(&done.text());
    }
    if done.interrupted() { Err(Failure::Interrupted) } else { Ok(()) }
}

impl Verb {
    fn contents(&self) -> Result<Contents, Failure> {
        if let Some(boxes) = &self.boxes {
            return Ok(Contents::Boxes(Source::from(boxes)));
        }
        let unit = self.unit.as_deref().map(str::parse).transpose();
        let unit = unit.map_err(|e: crate::mesh::UnknownUnit| Failure::Usage(e.to_string()))?;
        let model = |word: &String| {
            let (name, count) = copies(word);
            (ModelSource { source: Source::from(name), unit, repair: self.repair }, count)
        };
        Ok(Contents::Models(self.models.iter().map(model).collect()))
    }

    fn room(&self) -> PackInto {
        let table = || PackInto::Table(MachineSource::from(self.profile.as_deref().unwrap_or_default()));
        self.space.map_or_else(table, |space| PackInto::Space(space.0))
    }

    fn options(&self) -> PackOptions {
        PackOptions {
            gap_mm: self.gap,
            turn: self.turn.clone(),
            fill: self.fill.clone(),
            method: self.method.clone(),
            seconds: self.time,
            no_interlock: self.no_interlock,
            seed: self.seed,
        }
    }
}
