//! `trunnion inspect`

use super::args::Inspect;
use super::{Console, Failure};
use crate::document::{self, text};
use crate::job;

pub(super) fn run(args: &Inspect, console: &Console) -> Result<(), Failure> {
    let loaded = job::load_model(&args.model.source()?, &console.world())?;
    if console.json() {
        console.document(&document::inspected(&loaded.model));
    } else {
        console.result(&text::inspected(&loaded.model));
    }
    Ok(())
}
