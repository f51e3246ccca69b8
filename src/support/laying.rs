//! How supports are laid as lines.

use super::roof::Roof;

/// How supports are laid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laying {
    /// Whether what has no way to the ground stands on the part.
    pub on_part: bool,
    /// The roof below what is held; `None`: sheets alone hold it.
    pub roof: Option<Roof>,
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
