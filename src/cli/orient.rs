//! `trunnion orient`

use std::ops::RangeInclusive;

use super::args::Orient as Verb;
use super::requests::outputs;
use super::{Console, Failure};
use crate::document::{self, text};
use crate::job::{self, MachineSource, OrientOptions, OrientRequest, PartChoice, PictureFile};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let mut outputs = outputs([args.model.model.as_path()]);
    let oriented = args.output.as_deref().map(|path| outputs.claim(path)).transpose()?;
    let drawn = PictureFile::claim("landscape", args.landscape.as_deref(), &mut outputs)?;
    let viewed = PictureFile::claim("view", args.view.as_deref(), &mut outputs)?;
    let only_one = drawn.is_some() || viewed.is_some();
    let request =
        OrientRequest { model: args.model.source()?, parts: chosen(args)?, only_one, options: args.options()? };
    let done = job::orient(&request, &console.world())?;
    let part = &done.parts[0];
    if let Some(output) = &oriented {
        let as_3mf = output.path().extension().is_some_and(|end| end.eq_ignore_ascii_case("3mf"));
        output.write(&done.upright(as_3mf))?;
    }
    drawn.map(|drawn| drawn.write(&done.landscape(part))).transpose()?;
    viewed.map(|viewed| viewed.write(&done.view(part))).transpose()?;
    if console.json() {
        console.document(&document::orientations(&args.model.model.display().to_string(), &done));
    } else {
        console.result(&done.parts.iter().map(text::oriented).collect::<String>());
    }
    Ok(())
}

impl Verb {
    fn options(&self) -> Result<OrientOptions, Failure> {
        Ok(OrientOptions {
            objectives: self.objective.clone(),
            method: self.method.clone(),
            budget: self.budget,
            seed: self.seed,
            overhang_deg: self.overhang,
            layer_mm: self.layer,
            machine: self.profile.as_deref().map(MachineSource::from),
            up: self.up.map(|up| up.0),
            resolution_mm: self.resolution,
            smooth_k: self.smooth_k,
            smooth_w: self.smooth_w,
            carrying_deg: self.carrying,
            contact_mm2: self.contact_area_min,
            compare: self.compare,
        })
    }
}

/// The parts that `--part` names: numbers and ranges, as `0,3,5-7`.
fn chosen(args: &Verb) -> Result<PartChoice, Failure> {
    let Some(text) = &args.part else { return Ok(if args.whole { PartChoice::Whole } else { PartChoice::Each }) };
    let bad = |why: &str| Failure::Usage(format!("--part {text:?}: {why}"));
    let mut wanted: Vec<RangeInclusive<usize>> = Vec::new();
    for word in text.split(',').map(str::trim).filter(|word| !word.is_empty()) {
        let (first, last) = word.split_once('-').unwrap_or((word, word));
        let number =
            |t: &str| t.trim().parse::<usize>().map_err(|_| bad(&format!("{word:?} is not a part; write 0,3,5-7")));
        wanted.push(number(first)?..=number(last)?);
    }
    if wanted.iter().all(RangeInclusive::is_empty) {
        return Err(bad("names no part; write a number, or leave it out for all parts"));
    }
    Ok(PartChoice::Numbered(wanted))
}
