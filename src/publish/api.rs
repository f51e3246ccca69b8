//! A file, and what can be asked of every kind of server about it.

use std::time::Duration;

use super::UploadFigures;
use super::address::{Key, ServerAddress};
use super::fault::ServerFault;
use super::fingerprint::Fingerprint;
use super::line::Reached;
use crate::gcode::meaning::Firmware;

/// A file on its way.
pub struct Delivery<'a> {
    /// Where it goes.
    pub address: ServerAddress,
    /// What opens the server.
    pub key: Option<Key>,
    /// What it is called there; see [`file_name`](super::file_name).
    pub name: String,
    /// Its bytes.
    pub file: &'a [u8],
    /// Their SHA-256, lower case.
    pub sha256: String,
    /// Their SHA-1, lower case: OctoPrint tells no other.
    pub sha1: String,
    /// Whether a replay has proved it.
    pub verified: bool,
    /// What we say of it.
    pub stated: UploadFigures,
    /// Whether another file of this name is replaced.
    pub replace: bool,
    /// Whether it is printed.
    pub start: bool,
    /// How long the server may say nothing.
    pub silence: Duration,
    /// The only certificate that is taken; `None`: what this computer's authorities vouch for.
    pub fingerprint: Option<Fingerprint>,
    /// Whose words the file is in; `None` where nobody knows.
    pub firmware: Option<Firmware>,
}

impl Delivery<'_> {
    pub(super) fn reached(&self) -> Reached<'_> {
        Reached {
            address: &self.address,
            key: self.key.as_ref(),
            silence: self.silence,
            fingerprint: self.fingerprint,
            bytes: self.file.len() as u64,
            start: self.start,
        }
    }
}

/// What became of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Delivered {
    /// How often it was sent; 0 where it was there already.
    pub uploads: u32,
    /// Whether its print was started.
    pub started: bool,
    /// What the server shows of it by now.
    pub shown: UploadFigures,
}

/// What a server has under the file's name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Kept {
    pub(super) bytes: u64,
    /// Where it tells one.
    pub(super) sha1: Option<String>,
}

/// What its printer does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum State {
    Ready,
    /// The file, where it is told.
    Printing(Option<String>),
    NotReady(String),
}

/// What all servers can.
pub(super) trait Api {
    /// Who is there, and whether the key is right.
    fn enter(&mut self) -> Result<(), ServerFault>;
    /// What the printer behind it calls its firmware, where the server tells.
    fn firmware(&self) -> Option<String> {
        None
    }
    /// Bytes that are free.
    fn free(&self) -> Result<Option<u64>, ServerFault>;
    fn kept(&self) -> Result<Option<Kept>, ServerFault>;
    fn upload(&self, sent: &dyn Fn(usize)) -> Result<(), ServerFault>;
    fn fetch(&self) -> Result<Vec<u8>, ServerFault>;
    fn remove(&self) -> Result<(), ServerFault>;
    fn state(&self) -> Result<State, ServerFault>;
    fn start(&self) -> Result<(), ServerFault>;
    fn shown(&self) -> Result<UploadFigures, ServerFault>;
    fn leave(&self) {}
}
