//! `trunnion open`: the workbench.

use super::args::Open as Verb;
use super::{Console, Failure};
use crate::document;
use crate::job;
use crate::workbench::{self, OpenRequest};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let Verb { models, profile: machine, folder, port, no_browser } = args.clone();
    let request = OpenRequest { models, machine, folder, port, browser: !no_browser };
    let prints = workbench::open(&request, |address, page| {
        let line = if console.json() { document::opened(address).to_string() } else { address.to_owned() };
        console.result(&line);
        if page.is_some_and(|page| !job::open_in_browser(page)) {
            console.warning("cannot start a browser; open the address yourself");
        }
    })
    .map_err(Failure::Workbench)?;
    let goes_on = |process| console.warning(&format!("the print continues; to pause and end it: kill -INT {process}"));
    prints.into_iter().for_each(goes_on);
    Ok(())
}
