//! Whether a packing of boxes is one, told from the definitions alone: nothing of the searches is used here.
//!
//! Every pair of boxes of a run is held against each other, so that no data structure can hide a fault; whole numbers, no tolerance.

use super::instance::{Instance, Placed};

/// What is wrong with a packing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PackFault {
    /// A box that there is not.
    #[error("box {0} is placed but does not exist")]
    Unknown(usize),
    /// A box in two places.
    #[error("box {0} is placed twice")]
    Twice(usize),
    /// Lengths that turning does not give.
    #[error("box {0} has lengths that no allowed turn gives it")]
    Size(usize),
    /// A box that leaves the space.
    #[error("box {0} is not within the space")]
    Outside(usize),
    /// Two boxes nearer than the gap.
    #[error("boxes {0} and {1} overlap or are nearer than the gap")]
    Near(usize, usize),
    /// A box that is missing.
    #[error("box {0} is in no run")]
    Missing(usize),
}

/// The first fault of `placed`; `all` asks that every box has a place.
///
/// # Errors
///
/// The fault.
pub fn check(instance: &Instance, placed: &[Placed], all: bool) -> Result<(), PackFault> {
    let mut seen = vec![false; instance.items.len()];
    for p in placed {
        let known = seen.get_mut(p.item).ok_or(PackFault::Unknown(p.item))?;
        if std::mem::replace(known, true) {
            return Err(PackFault::Twice(p.item));
        }
        if !instance.turned(&instance.items[p.item]).contains(&p.size) {
            return Err(PackFault::Size(p.item));
        }
        if (0..3).any(|k| p.at[k] < 0 || p.at[k] + p.size[k] > instance.space[k]) {
            return Err(PackFault::Outside(p.item));
        }
    }
    if let Some(missing) = seen.iter().position(|&seen| !seen).filter(|_| all) {
        return Err(PackFault::Missing(missing));
    }
    for (i, a) in placed.iter().enumerate() {
        for b in placed[..i].iter().filter(|b| b.run == a.run) {
            let before = |a: &Placed, b: &Placed, k: usize| a.at[k] + a.size[k] + instance.gap <= b.at[k];
            if !(0..3).any(|k| before(a, b, k) || before(b, a, k)) {
                return Err(PackFault::Near(b.item, a.item));
            }
        }
    }
    Ok(())
}
