//! How many of the orientations that were tried for a part are left before sequences are looked for.

use std::collections::BTreeSet;

use super::candidates::Setups;
use super::options::Options;
use super::workpiece::Workpiece;
use crate::orient::Direction;
use crate::profile::Profile;

/// For each part of `workpiece`, how many of its `directions` (table frame) are left: those that the axes reach, at which neither the
/// part nor the head meets the table or the machine's frame, and that need no support; those with one setup count once. Parts of
/// `options.supported` are not asked whether they need support.
///
/// As many as there are lists of directions; a part without directions has 0. Source: Ramos et al. (2021), section 6.2 and table 1.
pub fn orientations_kept(
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    directions: &[Vec<Direction>],
    options: &Options<'_>,
) -> Vec<usize> {
    let mut setups = Setups::new(workpiece, profile, options);
    let mut kept = |(part, tried): (usize, &Vec<Direction>)| {
        let candidates = setups.choose(part, tried).candidates;
        candidates.iter().map(|candidate| candidate.setup).collect::<BTreeSet<_>>().len()
    };
    directions.iter().enumerate().map(&mut kept).collect()
}
