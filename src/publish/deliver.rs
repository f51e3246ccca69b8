//! The way of one file: once there, the same there, started where that was asked for.

use std::time::Duration;

use super::address::Kind;
use super::api::{Api, Delivered, Delivery, Kept, State};
use super::duet::Duet;
use super::fault::{PublishError, ServerFault};
use super::line::{Line, plain};
use super::moonraker::Moonraker;
use super::octoprint::OctoPrint;
use super::web::Web;
use crate::gcode::meaning::Firmware;

/// A file that a connection loses is sent so often.
const UPLOADS: u32 = 3;
/// Before it is sent again.
const PAUSE: Duration = Duration::from_secs(2);

/// Brings a file to a server, compares what arrived, and starts it where that is asked for. `sent` is told how many of its bytes
/// have gone.
///
/// # Errors
///
/// [`PublishError`]; nothing of the file is there then unless it says so.
pub fn deliver(job: &Delivery<'_>, web: &dyn Web, sent: &dyn Fn(usize)) -> Result<Delivered, PublishError> {
    let line = Line { to: job.reached(), web };
    let mut api: Box<dyn Api + '_> = match job.address.kind {
        Kind::OctoPrint => Box::new(OctoPrint(line, job)),
        Kind::Moonraker => Box::new(Moonraker(line, job)),
        Kind::Duet => Box::new(Duet(line, job)),
    };
    let mut left = false;
    let entered = api.enter();
    let done = entered.and_then(|()| {
        let way = Way { job, web, api: api.as_ref() };
        let done = way.go(sent, &mut left);
        api.leave();
        done
    });
    done.map_err(|fault| PublishError::new(&job.address, fault, left))
}

struct Way<'a> {
    job: &'a Delivery<'a>,
    web: &'a dyn Web,
    api: &'a dyn Api,
}

impl Way<'_> {
    fn go(&self, sent: &dyn Fn(usize), left: &mut bool) -> Result<Delivered, ServerFault> {
        self.same_firmware()?;
        if self.job.start {
            self.ready(false)?;
        }
        let before = self.api.kept()?;
        let there = before.as_ref().map(|kept| self.same(kept)).transpose()?.unwrap_or(false);
        let uploads = if there { 0 } else { self.upload(before.as_ref(), sent, left)? };
        if self.job.start {
            self.ready(true)?;
            self.start()?;
        }
        // It is there whatever becomes of this question.
        Ok(Delivered { uploads, started: self.job.start, shown: self.api.shown().unwrap_or_default() })
    }

    /// That the printer behind it understands the file, as far as the server tells.
    fn same_firmware(&self) -> Result<(), ServerFault> {
        let Some(firmware) = self.job.firmware else { return Ok(()) };
        let Some(says) = self.api.firmware() else { return Ok(()) };
        let other = Firmware::introduced(&says).filter(|named| *named != firmware);
        other.map_or(Ok(()), |_| Err(ServerFault::OtherFirmware { says: plain(&says), firmware: firmware.name() }))
    }

    /// That a print may begin.
    fn ready(&self, uploaded: bool) -> Result<(), ServerFault> {
        match self.api.state()? {
            State::Ready => Ok(()),
            State::Printing(file) => Err(ServerFault::Printing { file, uploaded }),
            State::NotReady(why) => Err(ServerFault::NotReady { why, uploaded }),
        }
    }

    /// Whether what it has is our file.
    fn same(&self, kept: &Kept) -> Result<bool, ServerFault> {
        if kept.bytes != self.job.file.len() as u64 {
            return Ok(false);
        }
        match &kept.sha1 {
            Some(sha1) => Ok(*sha1 == self.job.sha1),
            None => Ok(self.api.fetch()? == self.job.file),
        }
    }

    /// Sends it until it is there; how often that was.
    fn upload(&self, before: Option<&Kept>, sent: &dyn Fn(usize), left: &mut bool) -> Result<u32, ServerFault> {
        let needs = self.job.file.len() as u64;
        if let (Some(kept), false) = (before, self.job.replace) {
            return Err(ServerFault::Another { name: self.job.name.clone(), bytes: kept.bytes });
        }
        if let Some(free) = self.api.free()?.filter(|free| *free < needs) {
            return Err(ServerFault::Full { free: Some(free), needs });
        }
        let mut tried = 0;
        loop {
            tried += 1;
            let fault = self.api.upload(sent).err();
            // A lost answer may follow a whole file, and a yes may follow a broken one: only what is there counts.
            let now = match (&fault, self.api.kept()) {
                (_, Ok(now)) => now,
                (Some(_), Err(lost)) | (None, Err(lost)) => {
                    *left = fault.is_none() || lost.may_pass();
                    return Err(fault.unwrap_or(lost));
                }
            };
            if now.as_ref().map(|kept| self.same(kept)).transpose()?.unwrap_or(false) {
                return Ok(tried);
            }
            let there = now.as_ref().map_or(0, |kept| kept.bytes);
            // What was there before is not ours to take away.
            if now.is_some() && now.as_ref() != before {
                *left = self.api.remove().is_err();
            }
            let fault = fault.unwrap_or(ServerFault::Differs { sent: needs, there });
            if !fault.may_pass() || tried == UPLOADS || *left {
                return Err(self.fuller(fault));
            }
            self.web.wait(PAUSE);
        }
    }

    /// A disk that has become full meanwhile says so in many ways.
    fn fuller(&self, fault: ServerFault) -> ServerFault {
        let needs = self.job.file.len() as u64;
        match (&fault, self.api.free()) {
            (ServerFault::Full { .. }, Ok(free)) => ServerFault::Full { free, needs },
            (ServerFault::Refused { status: 500.., .. } | ServerFault::Closed, Ok(Some(free))) if free < needs => {
                ServerFault::Full { free: Some(free), needs }
            }
            _ => fault,
        }
    }

    /// Starts it, once: whoever asks twice may print twice.
    fn start(&self) -> Result<(), ServerFault> {
        match self.api.start() {
            Err(fault) if fault.may_pass() => match self.api.state() {
                Ok(State::Printing(Some(file))) if file == self.job.name => Ok(()),
                _ => Err(ServerFault::Unclear),
            },
            done => done,
        }
    }
}
