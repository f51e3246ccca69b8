//! What a way of printing a model costs, as one price in minutes: so that ways which have nothing else in common can be compared.
//!
//! ```text
//! price = minutes of printing and turning  +  a minute a gram
//!       + 2 min a setup beyond the first                       something may go wrong; nobody turns for nothing
//!       + 0.5 min where there are supports, 0.05 min a cm2     breaking them off
//!       + 0.01 min a mm2 of seam                               a cold joint holds about half of what a warm one does
//!       + 0.02 min a mm2 that droops by 1 mm
//!       + steps of slopes, and what is lost by the odds that the print comes loose, as `orient` prices them
//! ```
//!
//! A gram is worth what `orient` takes it to be worth. The other weights are such that makers' choices come out: a bottom fillet stays
//! whole, a bracket's arm of 60 mm is cut. All of them stand in a profile's `[price]`.
//!
//! The pose of the file is a wish: what stands otherwise is taken where it is cheaper by a twentieth ([`Way::wished`]).
//!
//! Minutes, grams, mm². It must not know models, machines or plans.

use std::str::FromStr;

/// One way to print a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// As it was drawn, or as its parts have it.
    AsDrawn,
    /// Standing otherwise than it was drawn.
    Turned,
    /// As it was drawn, on supports.
    Supports,
    /// Standing otherwise, and on supports.
    TurnedSupports,
    /// Cut by planes into parts, each along its own direction.
    Cut,
}

impl Way {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::AsDrawn, Self::Turned, Self::Supports, Self::TurnedSupports, Self::Cut];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::AsDrawn => "as-drawn",
            Self::Turned => "turned",
            Self::Supports => "supports",
            Self::TurnedSupports => "turned-supports",
            Self::Cut => "cut",
        }
    }

    /// Whether the model stands as in its file, in one piece.
    pub fn wished(self) -> bool {
        matches!(self, Self::AsDrawn | Self::Supports)
    }

    /// Whether who asks for this way has `other` meant, too: supports, in whatever pose.
    pub fn covers(self, other: Self) -> bool {
        self == other || (self == Self::Supports && other == Self::TurnedSupports)
    }
}

impl FromStr for Way {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let known = Self::ALL.into_iter().find(|way| way.word() == text);
        known.ok_or("must be auto, as-drawn, turned, supports, turned-supports or cut")
    }
}

/// What a way comes to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// Printing and turning, supports among it.
    pub minutes: f64,
    /// Filament, supports among it.
    pub grams: f64,
    /// Filament of supports.
    pub support_g: f64,
    /// What supports touch, mm².
    pub contact_mm2: f64,
    /// Seams, mm².
    pub seam_mm2: f64,
    /// Poses of the table.
    pub setups: usize,
    /// Parts that are printed.
    pub parts: usize,
    /// What droops, mm².
    pub droop_mm2: f64,
    /// The same times how far, mm³.
    pub droop_mm3: f64,
    /// What the steps on its slopes are worth, minutes.
    pub steps_min: f64,
    /// What is lost by the odds that it comes loose, minutes.
    pub risk_min: f64,
    /// How many times over it is held on the table where it is held least, the nozzle pushing; `None` where nothing tips anything. Not priced:
    /// `risk_min` is.
    pub stands: Option<f64>,
}

/// What each of them is worth, minutes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// A gram.
    pub gram: f64,
    /// A setup beyond the first.
    pub setup: f64,
    /// Supports, however few.
    pub supports: f64,
    /// A mm² that they touch.
    pub contact_mm2: f64,
    /// A mm² of seam.
    pub seam_mm2: f64,
    /// A mm² that droops by 1 mm.
    pub droop_mm3: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Self { gram: 1.0, setup: 2.0, supports: 0.5, contact_mm2: 0.05 / 100.0, seam_mm2: 0.01, droop_mm3: 0.02 }
    }
}

/// The least seam that a cut can have, mm².
const LEAST_SEAM_MM2: f64 = 9.0;

impl Weights {
    /// The price, minutes.
    pub fn price(&self, of: &Terms) -> f64 {
        let supports = if of.support_g > 0.0 { self.supports + self.contact_mm2 * of.contact_mm2 } else { 0.0 };
        let setups = self.setup * of.setups.saturating_sub(1) as f64;
        of.minutes
            + self.gram * of.grams
            + setups
            + supports
            + self.seam_mm2 * of.seam_mm2
            + self.droop_mm3 * of.droop_mm3
            + of.steps_min
            + of.risk_min
    }

    /// What cutting a model costs at least that takes so much in one piece without supports: another setup and the least seam.
    pub fn least_of_a_cut(&self, whole: &Terms) -> f64 {
        self.price(&Terms { setups: 2, seam_mm2: LEAST_SEAM_MM2, ..bare(whole) })
    }

    /// What a model costs at least that stands otherwise, of which all but `layers_min` is the same in every pose.
    pub fn least_of_a_turn(&self, whole: &Terms, layers_min: f64) -> f64 {
        self.price(&Terms { minutes: (whole.minutes - layers_min).max(0.0), ..bare(whole) })
    }

    /// What counts where ways are compared: its price, a twentieth more for what does not stand as it was drawn, in one piece.
    pub fn rank(&self, way: Way, terms: &Terms) -> f64 {
        self.price(terms) * if way.wished() { 1.0 } else { 1.0 / WISH }
    }
}

/// Standing otherwise than the file has it, or being cut, is worth while below this share of the price.
pub const WISH: f64 = 0.95;

/// Without what only some poses have.
fn bare(of: &Terms) -> Terms {
    Terms { support_g: 0.0, contact_mm2: 0.0, droop_mm3: 0.0, steps_min: 0.0, risk_min: 0.0, ..*of }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_price_by_hand() {
        let terms = Terms {
            minutes: 40.0,
            grams: 10.0,
            support_g: 1.0,
            contact_mm2: 400.0,
            seam_mm2: 50.0,
            setups: 3,
            parts: 2,
            droop_mm2: 50.0,
            droop_mm3: 10.0,
            steps_min: 1.5,
            risk_min: 0.25,
            stands: Some(2.0),
        };
        let wanted = 40.0 + 10.0 + 4.0 + (0.5 + 0.2) + 0.5 + 0.2 + 1.75;
        assert!((Weights::default().price(&terms) - wanted).abs() < 1e-12);
        // Nothing of supports costs where there are none.
        let none = Terms { support_g: 0.0, ..terms };
        assert!((Weights::default().price(&none) - wanted + 0.7).abs() < 1e-12);
    }

    #[test]
    fn no_cut_is_cheaper_than_its_bound() {
        let whole =
            Terms { minutes: 30.0, grams: 8.0, support_g: 2.0, contact_mm2: 100.0, setups: 1, ..Terms::default() };
        let bound = Weights::default().least_of_a_cut(&whole);
        assert!((bound - (30.0 + 8.0 + 2.0 + 0.09)).abs() < 1e-12, "{bound}");
        for (setups, seam_mm2) in [(2, 9.0), (2, 400.0), (5, 9.0)] {
            let cut = Terms { minutes: 30.0, grams: 8.0, seam_mm2, setups, parts: setups, ..Terms::default() };
            assert!(Weights::default().price(&cut) >= bound);
        }
    }

    #[test]
    fn no_turn_is_cheaper_than_its_bound() {
        let whole = Terms { minutes: 30.0, grams: 8.0, steps_min: 3.0, risk_min: 1.0, setups: 1, ..Terms::default() };
        let bound = Weights::default().least_of_a_turn(&whole, 6.0);
        assert!((bound - 32.0).abs() < 1e-12, "{bound}");
        // Six minutes are what its layers take: flat on the table it has at least one.
        for layers_min in [0.1, 3.0, 6.0] {
            let turned = Terms { minutes: 24.0 + layers_min, grams: 8.0, setups: 1, ..Terms::default() };
            assert!(Weights::default().price(&turned) >= bound);
        }
    }

    #[test]
    fn the_drawn_pose_wins_within_a_twentieth() {
        let of = |minutes| Terms { minutes, setups: 1, ..Terms::default() };
        let weights = Weights::default();
        assert!(weights.rank(Way::Turned, &of(38.1)) > weights.rank(Way::AsDrawn, &of(40.0)));
        assert!(weights.rank(Way::Turned, &of(37.9)) < weights.rank(Way::AsDrawn, &of(40.0)));
        // In one piece, on supports if it must be.
        assert!(weights.rank(Way::Cut, &of(38.1)) > weights.rank(Way::Supports, &of(40.0)));
        assert!(weights.rank(Way::Cut, &of(37.9)) < weights.rank(Way::Supports, &of(40.0)));
        assert!(weights.rank(Way::Cut, &of(39.9)) < weights.rank(Way::TurnedSupports, &of(40.0)));
    }

    #[test]
    fn words_and_back() {
        assert!(Way::ALL.iter().all(|way| way.word().parse() == Ok(*way)));
        assert!("auto".parse::<Way>().is_err() && Way::Supports.covers(Way::TurnedSupports));
    }
}
