//! Ways to print a model that were tried, each with what it comes to.

use std::fmt::{self, Display, Formatter};

use super::price::{Terms, Way, Weights};
use super::refused::Refused;

/// A way that was tried.
#[derive(Clone, Debug)]
pub struct TriedWay {
    /// Which.
    pub way: Way,
    /// The direction of the file that is up, where the model was turned for it.
    pub up: Option<[f64; 3]>,
    /// Whether it was taken.
    pub chosen: bool,
    /// What it comes to; `None` where it does not work, or was not worked out.
    pub terms: Option<Terms>,
    /// Its price, minutes; of a way that was not worked out the least that it can be.
    pub price_min: Option<f64>,
    /// Why it was not taken.
    pub why_not: Option<Refused>,
}

impl TriedWay {
    pub(super) fn refused(way: Way, why_not: Refused) -> Self {
        Self { way, up: None, chosen: false, terms: None, price_min: None, why_not: Some(why_not) }
    }

    /// One that was not worked out, since it cannot cost less than this.
    pub(super) fn dearer(way: Way, least_min: f64) -> Self {
        Self { price_min: Some(least_min), ..Self::refused(way, Refused::Dearer { least_min }) }
    }

    pub(super) fn priced(way: Way, up: Option<[f64; 3]>, terms: Terms, weights: &Weights) -> Self {
        let price_min = Some(weights.price(&terms));
        Self { way, up, chosen: false, terms: Some(terms), price_min, why_not: None }
    }
}

impl TriedWay {
    /// A way that was not taken, in a line; `None` for the one that was, and for what is told of every model that does not print as it was drawn.
    pub fn beside(&self) -> Option<String> {
        if self.way == Way::AsDrawn && self.terms.is_none() {
            return None;
        }
        let price = self.price_min.map(|min| format!("price {min:.0} min"));
        let facts: Vec<String> = price.into_iter().chain(self.why_not.iter().map(ToString::to_string)).collect();
        (!self.chosen).then(|| format!("not {}: {}", self.way.word(), facts.join("; ")))
    }
}

/// No way to print a model is left of those that were asked for.
#[derive(Clone, Debug)]
pub struct NoWay {
    /// The only one that was asked for.
    pub only: Option<Way>,
    /// Whether nobody named it, but demanded an order of prints, which one solid has only where it is cut.
    pub for_order: bool,
    /// Whether it was cut as somebody has decided.
    pub for_cuts: bool,
    /// All that were tried, with why not.
    pub ways: Vec<TriedWay>,
}

impl Display for NoWay {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let asked = self.only.map_or("", Way::word);
        let whys =
            self.ways.iter().filter_map(|tried| Some(format!("{}: {}", tried.way.word(), tried.why_not.as_ref()?)));
        let whys: Vec<String> = whys.collect();
        let whys = if whys.is_empty() { "it does not apply to this model".to_owned() } else { whys.join("; ") };
        if self.for_order {
            return write!(
                f,
                "--order needs parts, and this solid cannot be cut into any: {whys}; without --order the cheapest way that works is taken"
            );
        }
        if self.for_cuts {
            return write!(
                f,
                "the model cannot be printed with these cuts: {whys}; without --cut the cheapest way that works is taken"
            );
        }
        write!(f, "--way {asked} cannot print the model: {whys}; --way auto takes the cheapest way that works")
    }
}
