//! What reading an input takes of memory at the least, held against what it may take (`docs/explanation/costs.md`).
//!
//! It is told from sizes, before the work: what is refused here would have taken that much for sure. What the work takes beyond it nobody
//! can tell beforehand.

use super::InputError;
use crate::mesh::{ProjectPlates, facets_told};
use crate::world::World;

/// The program itself.
const ITSELF: u64 = 8_000_000;
/// A facet as it is read, with its corners and what joins it to others.
const FACET: u64 = 95;
/// A move of a program's trace.
const MOVE: u64 = 39;
const MB: u64 = 1_000_000;

/// That `bytes` may be taken for `file`, beside the program itself.
fn afforded(file: &str, bytes: u64, world: &World<'_>) -> Result<(), InputError> {
    let needs = ITSELF.saturating_add(bytes);
    match world.memory {
        Some(most) if needs > most => {
            Err(InputError::Memory { file: file.to_owned(), needs_mb: needs.div_ceil(MB), most_mb: most / MB })
        }
        _ => Ok(()),
    }
}

/// Before a file of so many `bytes` is read.
pub(super) fn of_file(file: &str, bytes: u64, world: &World<'_>) -> Result<(), InputError> {
    afforded(file, bytes, world)
}

/// Before a model is made of `bytes`.
pub(crate) fn of_model(file: &str, bytes: &[u8], plates: ProjectPlates, world: &World<'_>) -> Result<(), InputError> {
    if world.memory.is_none() {
        return Ok(());
    }
    let facets = facets_told(bytes, file, plates) as u64;
    afforded(file, (bytes.len() as u64).saturating_add(facets.saturating_mul(FACET)), world)
}

/// Before a program is followed: each of its lines that begins with G0 to G3 is a move, and each arc many.
pub(super) fn of_program(file: &str, bytes: &[u8], world: &World<'_>) -> Result<(), InputError> {
    if world.memory.is_none() {
        return Ok(());
    }
    let is_move = |line: &&[u8]| matches!(line, [b'G', b'0'..=b'3', b' ', ..]);
    let moves = bytes.split(|byte| *byte == b'\n').filter(is_move).count() as u64;
    afforded(file, bytes.len() as u64 + moves * MOVE, world)
}
