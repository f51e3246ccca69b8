//! Several printers by one process: a thread, a port and a journal each, and nothing in common. What befalls one is none of the others'.

use std::path::{Path, PathBuf};

use super::error::SendError;
use super::operator::Operator;
use super::together::{same_port, side_by_side};
use super::{Checked, SendOptions, SendRequest, Wire, checked, go};
use crate::input::{CheckedPlan, LoadedProfile};
use crate::job::print::Verified;
use crate::world::{Silent, World};

/// One of several prints.
#[derive(Clone, Copy, Debug)]
pub struct SentPrint<'a> {
    /// What.
    pub request: SendRequest<'a>,
    /// To where.
    pub wire: Wire<'a>,
}

/// How one of several prints has ended.
#[derive(Debug)]
pub struct EndedPrint {
    /// Its port.
    pub port: String,
    /// Its file.
    pub file: PathBuf,
    /// Why it failed.
    pub error: Option<SendError>,
}

/// A program in hand, and what it is to be printed by.
#[derive(Debug)]
pub struct Loaded {
    /// The program.
    pub program: Verified<Vec<u8>>,
    /// The plan that it was verified against; without one the profile is needed.
    pub plan: Option<CheckedPlan>,
    /// The profile, where there is no plan.
    pub profile: Option<LoadedProfile>,
}

impl Loaded {
    /// To be sent as `path`; `None` where it has neither plan nor profile.
    pub fn request<'a>(&'a self, path: &'a Path, options: &'a SendOptions) -> Option<SendRequest<'a>> {
        let (program, plan) = (&self.program, self.plan.as_ref());
        let machine = plan.map(|plan| &plan.machine).or(self.profile.as_ref())?;
        Some(SendRequest { path, program, machine, plan, options })
    }
}

/// Sends, or where `resumes` resumes, several prints at the same time; how each has ended, in their order.
///
/// `operator` gives whoever stands by print `index`; it is called on that print's own thread.
///
/// # Errors
///
/// As [`send`](super::send()) and [`resume`](super::resume()) before anything is sent, of the first print that cannot begin, and
/// [`SendError::SamePort`] and [`SendError::NoThread`]: then none begins.
pub fn send_several<'o>(
    prints: &[SentPrint<'_>],
    resumes: bool,
    world: &World<'_>,
    operator: &(dyn Fn(usize) -> Box<dyn Operator + 'o> + Sync),
) -> Result<Vec<EndedPrint>, SendError> {
    distinct(prints)?;
    let all = |print: &SentPrint<'_>| checked(&print.request, &print.wire, resumes, world);
    let checked = prints.iter().map(all).collect::<Result<Vec<Checked>, _>>()?;
    // No port is touched before all is known to be well.
    let open = |checked: Checked| checked.open(world);
    let ready = checked.into_iter().map(open).collect::<Result<Vec<_>, _>>()?;
    let tasks = ready.into_iter().zip(prints).enumerate().map(|(index, ((checked, port), print))| {
        move || {
            let operator = operator(index);
            let ended = go(checked, port, &print.request, &print.wire, &World::here(&Silent), &*operator);
            operator.ended(ended.as_ref().err());
            ended
        }
    });
    let ended = side_by_side(tasks.collect()).map_err(|source| SendError::NoThread { source })?.into_iter().zip(prints);
    let each = |(ended, print): (Result<(), SendError>, &SentPrint<'_>)| EndedPrint {
        port: print.wire.address.to_string(),
        file: print.request.path.to_owned(),
        error: ended.err(),
    };
    Ok(ended.map(each).collect())
}

/// That no two go to one port, under whatever names.
fn distinct(prints: &[SentPrint<'_>]) -> Result<(), SendError> {
    for (index, print) in prints.iter().enumerate() {
        let same = |other: &&SentPrint<'_>| same_port(other.wire.address, print.wire.address);
        if let Some(other) = prints[..index].iter().find(same) {
            let files = [other, print].map(|p| PathBuf::from(p.request.path));
            return Err(SendError::SamePort { port: print.wire.address.to_string(), files });
        }
    }
    Ok(())
}
