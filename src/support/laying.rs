//! How supports are laid as lines.

use super::roof::Roof;

/// How supports are laid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laying {
    /// Whether what has no way to the ground stands on the part.
    pub on_part: bool,
    /// The roof below what is held; `None`: sheets alone hold it.
    pub roof: Option<Roof>,
    /// Sheets touch those of the neighbours' cells once in so many levels, and below what they hold; 1: everywhere.
    pub touch_every: u16,
}

/// Sheets end at most so much of a step short of their neighbours.
const APART: f64 = 0.25;

impl Laying {
    /// By how much sheets end short of the corners of their cells, mm: `above_mm` over the ground and `below_mm` under what they hold.
    /// Ends move by no more than they rise.
    pub(super) fn apart_mm(&self, above_mm: f64, below_mm: f64, step_mm: f64) -> f64 {
        if self.touch_every <= 1 {
            return 0.0;
        }
        let period_mm = f64::from(self.touch_every) * step_mm;
        let over_mm = above_mm.max(0.0) % period_mm;
        over_mm.min(period_mm - over_mm).min(below_mm.max(0.0)).min(APART * step_mm)
    }
}

/// From what supports keep their gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clear {
    /// The layers of the part, cut in their middles: the gap from those above, `beside_mm` from their own.
    Layers {
        /// Air between a support and the part beside it, mm.
        beside_mm: f64,
    },
    /// The part's surface: the gap on all sides, measured straight.
    Around,
}
