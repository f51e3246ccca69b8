//! What a way of printing a model costs, as one price in minutes: so that ways which have nothing else in common can be compared.
//!
//! ```text
//! price = minutes of printing and turning  +  a minute a gram
//!       + 2 min a setup beyond the first                       something may go wrong; nobody turns for nothing
//!       + 0.5 min where there are supports, 0.05 min a cm2     breaking them off
//!       + 0.01 min a mm2 of seam                               a cold joint holds about half of what a warm one does
//!       + 0.02 min a mm2 that droops by 1 mm
//! ```
//!
//! A gram is worth what `orient` takes it to be worth. The other weights are such that makers' choices come out: a bottom fillet stays
//! whole, a bracket's arm of 60 mm is cut.
//!
//! Minutes, grams, mm². This room must not know models, machines or plans.

/// One way to print a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// As it was drawn, or as its parts have it.
    AsDrawn,
    /// As it was drawn, on supports.
    Supports,
    /// Cut by planes into parts, each along its own direction.
    Cut,
}

impl Way {
    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::AsDrawn => "as drawn",
            Self::Supports => "supports",
            Self::Cut => "cut",
        }
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
    /// What droops, mm² times mm.
    pub droop_mm3: f64,
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
    }

    /// What cutting a model costs at least that takes so much in one piece without supports: another setup and the least seam.
    pub fn least_of_a_cut(&self, whole: &Terms) -> f64 {
        let bare = Terms { support_g: 0.0, contact_mm2: 0.0, droop_mm3: 0.0, ..*whole };
        self.price(&Terms { setups: 2, seam_mm2: LEAST_SEAM_MM2, ..bare })
    }
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
            droop_mm3: 10.0,
        };
        let wanted = 40.0 + 10.0 + 4.0 + (0.5 + 0.2) + 0.5 + 0.2;
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
}
