//! The room that the head owes what stands, and why: the planner's side of the rule that verification judges a file by.
//!
//! Verification sees lines as they were laid, in cells of [`CELL_MM`], and lets the nozzle alone reach [`contact_mm`] into what it
//! prints on. The planner knows the model only, so it owes besides what the two may differ by: a cell's diagonal, the bulge of a
//! line beyond its width, and the half layer by which a slicer rounds a top up or down.
//!
//! Lengths mm.

use crate::geom::Body;
use crate::profile::Profile;

/// Edge of the cells in which verification keeps what stands, mm.
pub const CELL_MM: f64 = 0.25;

/// Verification takes moves in pieces of this length, each as the box around it, mm.
pub const PIECE_MM: f64 = 0.1;

/// The first layer's tip is at least so many layers above the surface it prints on.
pub const LIFT_LAYERS: f64 = 1.0;

/// Nearer than this counts as touching, mm.
pub(super) const TOUCHING_MM: f64 = 1e-3;

/// How deep the nozzle's flat may reach into a surface it prints on or beside, mm: a layer and half a line width.
///
/// A line laid against a slanting interface has its centre half a width from it and its bottom a layer below the tip;
/// within that reach the soft line itself fills the room, and the nozzle's rim irons it.
pub fn contact_mm(profile: &Profile) -> f64 {
    profile.process.layer_height_mm + profile.process.line_width_mm / 2.0
}

/// Whether a piece of the head carries the tip, and so may touch to the depth `contact_mm`.
pub fn carries_tip(body: &Body, contact_mm: f64) -> bool {
    !body.stays && body.follows == [true; 3] && body.bounds().min.z < contact_mm
}

/// What one piece of the head owes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Share {
    /// The piece counts as raised by so much.
    pub(super) lift: f64,
    /// And as wider by so much on every side.
    pub(super) wider: f64,
    /// So far it keeps away.
    pub(super) mm: f64,
}

/// What the head owes one obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Owed {
    /// The piece that carries the tip.
    pub(super) tip: Share,
    /// All others.
    pub(super) rest: Share,
}

impl Owed {
    /// What is owed to the table, which is flat and where it is said to be, while a part is printed that lies `above_mm` over it.
    /// As with neighbours, no margin can be asked for where the part stands on the table or nearly does.
    ///
    /// On a level table nothing of the nozzle is lower than its tip. On a tilted one the rim of its flat is, and nothing there gives way:
    /// what the tip prints is then at least the half of a layer below it that lies above the plane in which the slicer cuts.
    pub(super) fn to_table(profile: &Profile, margin_mm: f64, above_mm: f64, level: bool) -> Self {
        let asked = if above_mm < margin_mm + contact_mm(profile) { 0.0 } else { margin_mm };
        let tip = if level {
            Share { mm: TOUCHING_MM, ..ironing(profile) }
        } else {
            Share { lift: half_layer(profile) - overlap(profile), wider: 0.0, mm: TOUCHING_MM.max(asked) }
        };
        Self { tip, rest: Share { lift: 0.0, wider: 0.0, mm: diagonal().max(asked) + overlap(profile) } }
    }

    /// What is owed to a part that the printed one touches or nearly does. No margin can be asked for here: the block of a short
    /// nozzle is never far from what the nozzle prints on.
    pub(super) fn to_neighbour(profile: &Profile) -> Self {
        let tip = Share { mm: half_layer(profile), ..ironing(profile) };
        Self { tip, rest: Self::to_others(profile, 0.0).rest }
    }

    /// What is owed to any other part.
    pub(super) fn to_others(profile: &Profile, margin_mm: f64) -> Self {
        let lift = LIFT_LAYERS * profile.process.layer_height_mm - overlap(profile);
        let share = Share { lift, wider: 0.0, mm: margin_mm };
        let unseen = diagonal() + bulge(profile) + half_layer(profile) + overlap(profile);
        let least = |mm: f64| Share { mm: share.mm.max(mm), ..share };
        Self { tip: least(TOUCHING_MM), rest: least(unseen) }
    }
}

/// The nozzle may iron what it prints on.
fn ironing(profile: &Profile) -> Share {
    let lift = contact_mm(profile) + half_layer(profile) - overlap(profile);
    Share { lift, wider: beside(profile), mm: 0.0 }
}

/// Nothing in a cell is farther from anything else in it.
fn diagonal() -> f64 {
    CELL_MM * std::f64::consts::SQRT_2
}

/// Slicers print whole layers: so far a top may lie above or below the model's.
fn half_layer(profile: &Profile) -> f64 {
    profile.process.layer_height_mm / 2.0
}

/// The first layer on an earlier part is laid so much lower than it is sliced.
fn overlap(profile: &Profile) -> f64 {
    profile.joint.overlap_mm
}

/// Verification takes a line as a capsule around its cross-section, which stands out of it sideways.
fn bulge(profile: &Profile) -> f64 {
    let (half_width, half_height) = (profile.process.line_width_mm / 2.0, half_layer(profile));
    half_width.hypot(half_height) - half_width
}

/// The tip keeps half a line from the outline that it prints; against that stands what verification cannot tell apart.
fn beside(profile: &Profile) -> f64 {
    (diagonal() + PIECE_MM / 2.0 + bulge(profile) - profile.process.line_width_mm / 2.0).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_machine_owes_what_is_worked_out_by_hand() {
        let (file, text) = crate::profile::shipped("generic-ac").unwrap();
        let profile = crate::profile::resolve(file, text).unwrap().0;
        // Lines of 0.45 x 0.2 mm: contact 0.2 + 0.225; diagonal 0.3536; bulge |(0.225, 0.1)| - 0.225 = 0.0212.
        let near = Owed::to_neighbour(&profile);
        let close = |got: f64, wanted: f64| assert!((got - wanted).abs() < 1e-4, "{got} for {wanted}");
        close(near.tip.lift, 0.525);
        close(near.tip.wider, 0.1998);
        close(near.tip.mm, 0.1);
        close(near.rest.mm, 0.4748);
        close(Owed::to_others(&profile, 0.5).rest.mm, 0.5);
        // Standing on it, and with its lowest point just below and above 5 mm and the contact.
        for (above, wanted) in [(0.0, 0.3536), (5.42, 0.3536), (5.43, 5.0)] {
            close(Owed::to_table(&profile, 5.0, above, true).rest.mm, wanted);
        }
        close(Owed::to_table(&profile, 0.1, 50.0, true).rest.mm, 0.3536);
        // Tilted: the rim itself, half a layer of 0.2 mm above what is printed.
        let [on, over] = [0.0, 5.43].map(|above| Owed::to_table(&profile, 5.0, above, false).tip);
        assert_eq!((on.lift, on.wider, on.mm, over.mm), (0.1, 0.0, TOUCHING_MM, 5.0));
        assert_eq!(Owed::to_others(&profile, 0.0).tip.mm, TOUCHING_MM);
    }
}
