//! What a pose costs, in grams and minutes, and its price: one number in minutes.

use super::super::facets::FLAT;
use super::super::{Facets, Mass};
use super::footing::FirstLayer;
use super::process::{Laid, MINUTES_PER_GRAM, Process, SCAR_MIN_PER_MM2};
use super::supports::Supports;
use super::{ROUGH, columns};
use crate::geom::Vec3;

/// A pose in figures. Minutes add up to the price.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Priced {
    /// The build direction, unit, the mesh's frame.
    pub up: Vec3,
    /// The sum: what the print takes, its filament at a minute a gram, and the charges.
    pub price_min: f64,
    /// The part itself, its changes of layer among the minutes.
    pub part: Laid,
    /// The supports.
    pub supports: Laid,
    /// Breaking the supports off and smoothing what they touched.
    pub scar_min: f64,
    /// What the steps of its slopes are worth.
    pub steps_min: f64,
    /// What is lost when the print comes loose, by the odds of that.
    pub risk_min: f64,
    /// Height, mm.
    pub height_mm: f64,
    /// Volume of the support columns, mm³.
    pub support_mm3: f64,
    /// Of them what stands on the part itself, mm³.
    pub on_part_mm3: f64,
    /// What supports touch of the part, seen along the direction, mm².
    pub scar_mm2: f64,
    /// `sum A |d.n|` without what lies flat, mm².
    pub stepped_mm2: f64,
    /// The footprint of the first layer, mm².
    pub footprint_mm2: f64,
    /// How far the part may be tipped before it falls over, degrees; below zero it does so by itself.
    pub tipping_deg: f64,
    /// The same with the supports that stand on the bed.
    pub held_deg: f64,
    /// Whether it stands by itself.
    pub stands: bool,
}

/// A part stands by itself from this angle on, degrees, if its footprint is large enough.
pub const STANDS_DEG: f64 = 4.0;
/// Of the square of the part's size (the cube root of its volume) what is enough of a footprint, and what always is, mm².
const ENOUGH: f64 = 0.05;
const ENOUGH_MM2: f64 = 20.0;
/// The odds that a print fails whose part balances on a point while supports hold it, that fails for them as well, and that hardly
/// anything of it lies on the bed; each falls by a factor e with so many degrees, or so much footprint.
const ODDS_ALONE: f64 = 0.04;
const ODDS_HELD: f64 = 0.06;
const ODDS_LOOSE: f64 = 0.02;
const STEADY_DEG: f64 = 6.0;
/// Feet of supports hold with this share of their area.
const FEET: f64 = 0.3;

impl Process {
    /// The price of `up`, a unit direction, supports by columns of an eightieth of the part's diagonal: what a first look asks.
    pub fn roughly(&self, facets: &Facets, up: &Vec3) -> Priced {
        self.price(facets, facets.mass(), up, columns(facets, ROUGH))
    }

    /// What the steps on a part's slopes are worth along `up`, a unit direction, min; what lies flat has none.
    pub fn steps_along(&self, facets: &Facets, up: &Vec3) -> f64 {
        self.steps(stepped(facets, up))
    }

    /// The price of `up`, supports by columns of `width_mm`.
    pub fn price(&self, facets: &Facets, mass: &Mass, up: &Vec3, width_mm: f64) -> Priced {
        let footing = FirstLayer::of(facets, mass, up, self.layer_mm);
        let columns = Supports::of(facets, up, self.overhang, self.layer_mm, width_mm);
        let held_deg = footing.tipping_with(columns.feet.iter().copied());
        let height_mm = facets.extent(up);
        let mut part = self.solid(mass.volume_mm3, mass.area_mm2);
        part.minutes += self.layers(height_mm);
        let supports = self.supports(columns.volume_mm3);
        let stepped_mm2 = stepped(facets, up);
        let enough = ENOUGH * mass.volume_mm3.powf(2.0 / 3.0);
        let laid = part.minutes + supports.minutes + MINUTES_PER_GRAM * (part.grams + supports.grams);
        let (scar_min, steps_min) = (columns.scar_mm2 * SCAR_MIN_PER_MM2, self.steps(stepped_mm2));
        let holds = footing.area_mm2 + FEET * columns.feet_mm2;
        let risk_min = laid * odds(footing.tipping_deg, held_deg, holds / enough);
        Priced {
            up: *up,
            price_min: laid + scar_min + steps_min + risk_min,
            part,
            supports,
            scar_min,
            steps_min,
            risk_min,
            height_mm,
            support_mm3: columns.volume_mm3,
            on_part_mm3: columns.on_part_mm3,
            scar_mm2: columns.scar_mm2,
            stepped_mm2,
            footprint_mm2: footing.area_mm2,
            tipping_deg: footing.tipping_deg,
            held_deg,
            stands: footing.tipping_deg >= STANDS_DEG && footing.area_mm2 >= enough.min(ENOUGH_MM2),
        }
    }
}

/// The odds that the print comes loose; `hold` is what holds it on the bed, in what is enough.
fn odds(alone_deg: f64, held_deg: f64, hold: f64) -> f64 {
    let unsteady = |deg: f64| (-deg.max(0.0) / STEADY_DEG).exp();
    let loose = if hold.is_finite() { (-hold).exp() } else { 0.0 };
    ODDS_ALONE * unsteady(alone_deg) + ODDS_HELD * unsteady(held_deg) + ODDS_LOOSE * loose
}

/// `sum A |d.n|` without the facets that lie flat, mm².
fn stepped(facets: &Facets, up: &Vec3) -> f64 {
    facets.sum(|facet| {
        let along = facet.area.dot(up).abs();
        if along >= FLAT * facet.area.norm() { 0.0 } else { along }
    })
}
