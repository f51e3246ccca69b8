//! What is done with bytes that anybody may have written: one function a target, called by the fuzzer (`fuzz/fuzz_targets`) and by the
//! tests (`tests/it/fuzzed`).
//!
//! Each takes any bytes and comes back; what is wrong is a panic, an overflow, a hang, or a promise of the code's own documentation that
//! does not hold. The first bytes choose how the rest is read.

mod config;
mod gcode;
mod journal;
pub(crate) mod mesh;
mod plan;
mod print;
mod profile;
pub(crate) mod program;
mod reply;
pub(crate) mod rewrite;
mod shelf;

use std::sync::OnceLock;

use trunnion::profile::{Profile, SHIPPED, resolve};

/// What a target does with its bytes.
pub(crate) type Body = fn(&[u8]);

/// The targets by name.
pub(crate) const BODIES: [(&str, Body); 9] = [
    ("config", config::config),
    ("gcode", gcode::gcode),
    ("journal", journal::journal),
    ("mesh", mesh::mesh),
    ("plan", plan::plan),
    ("profile", profile::profile),
    ("program", program::program),
    ("reply", reply::reply),
    ("rewrite", rewrite::rewrite),
];

/// Runs the target `name` on `data`.
///
/// # Panics
///
/// Where it has found something, and for a name that there is not.
pub(crate) fn run(name: &str, data: &[u8]) {
    let (_, body) = BODIES.iter().find(|(known, _)| *known == name).expect("a target's name");
    body(data);
}

/// The shipped profiles, in the order of [`SHIPPED`].
fn profiles() -> &'static [Profile] {
    static ALL: OnceLock<Vec<Profile>> = OnceLock::new();
    ALL.get_or_init(|| {
        SHIPPED.iter().map(|(_, file, text)| resolve(file, text).expect("a shipped profile").0).collect()
    })
}

/// The profile that a byte chooses.
fn chosen(byte: u8) -> &'static Profile {
    &profiles()[usize::from(byte) % profiles().len()]
}

/// The first byte and the rest; `None` where there is none.
fn choice(data: &[u8]) -> Option<(u8, &[u8])> {
    data.split_first().map(|(first, rest)| (*first, rest))
}
