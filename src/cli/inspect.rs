//! `trunnion inspect` and `trunnion explain`

use super::args::{Explain, Inspect};
use super::{Console, Failure};
use crate::document::{self, text};
use crate::job::{self, ModelSource};
use crate::mesh::ProjectPlates;

pub(super) fn run(args: &Inspect, console: &Console) -> Result<(), Failure> {
    let source = args.model.source()?;
    let plates = if source.plates == ProjectPlates::Only { ProjectPlates::All } else { source.plates };
    let loaded = job::load_model(&ModelSource { plates, ..source }, &console.world())?;
    if console.json() {
        console.document(&document::inspected(&loaded.model));
    } else {
        console.result(&text::inspected(&loaded.model));
    }
    Ok(())
}

pub(super) fn explain(args: &Explain, console: &Console) -> Result<(), Failure> {
    let entry = document::explained(&args.code).map_err(|near| Failure::Usage(text::no_such_code(&args.code, near)))?;
    if console.json() {
        console.document(&entry);
    } else {
        console.result(&text::entry(&entry));
    }
    Ok(())
}
