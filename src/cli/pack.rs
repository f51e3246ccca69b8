//! `trunnion pack`

use std::path::PathBuf;

use super::args::{Pack as Verb, copies};
use super::requests::{outputs, repair};
use super::{Console, Failure};
use crate::document::{self, text};
use crate::job::{
    self, Contents, MachineSource, ModelSource, PackInto, PackOptions, PackRequest, PictureFile, Source, interrupts,
};
use crate::mesh::ProjectPlates;

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let files: Vec<PathBuf> = args.models.iter().map(|w| copies(w).0.to_owned()).chain(args.boxes.clone()).collect();
    let mut outputs = outputs(files.iter().map(PathBuf::as_path));
    let plates = args.output.as_deref().map(|folder| job::Plates::claim(folder, &mut outputs)).transpose()?;
    let viewed = PictureFile::claim("view", args.view.as_deref(), &mut outputs)?;
    // From here on an interrupt ends the search, and what was found so far is written.
    let asked = interrupts::Interrupts::listen();
    let done = job::pack(&args.request()?, &|| asked.count() > 0, &console.world())?;
    let stale = plates.map(|plates| plates.write(&done, &mut outputs)).transpose()?.unwrap_or_default();
    stale.iter().try_for_each(|plate| console.set_aside(plate))?;
    viewed.map(|viewed| viewed.write(&done.view())).transpose()?;
    if console.json() {
        console.document(&document::packed(&done));
    } else {
        console.summary(&text::packed(&done), args.output.is_some());
    }
    if done.interrupted() { Err(Failure::Interrupted) } else { Ok(()) }
}

impl Verb {
    fn request(&self) -> Result<PackRequest, Failure> {
        let unit = self.unit.as_deref().map(str::parse).transpose();
        let unit = unit.map_err(|e: crate::mesh::UnknownUnit| Failure::Usage(e.to_string()))?;
        let model = |word: &PathBuf| {
            let (name, count) = copies(word);
            let (source, plates) = (Source::from(name), ProjectPlates::All);
            (ModelSource { source, unit, repair: repair(&self.repair, self.no_repair), plates }, count)
        };
        let models = || Contents::Models(self.models.iter().map(model).collect());
        let table = || PackInto::Table(MachineSource::from(self.profile.as_deref().unwrap_or_default()));
        let options = PackOptions {
            gap_mm: self.gap,
            turn: self.turn.clone(),
            goal: self.goal.clone(),
            fill: self.fill.clone(),
            method: self.method.clone(),
            near: self.used_distance.zip(self.direction_distance).map(<[u32; 2]>::from),
            seconds: self.time,
            inflate_mm: self.inflate,
            no_interlock: self.no_interlock,
            seed: self.seed,
        };
        let contents = self.boxes.as_ref().map_or_else(models, |boxes| Contents::Boxes(Source::from(boxes)));
        Ok(PackRequest { contents, into: self.space.map_or_else(table, PackInto::Space), options })
    }
}
