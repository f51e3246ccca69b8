//! Ways to print a model that may be taken.

use super::arrange::SetUp;
use super::cutting::Cutting;
use super::plan::Supporting;
use super::price::Way;
use super::split::GivenCut;
use super::supported::Holdings;
use super::ways::TriedWay;
use crate::input::BadSetting;

/// What may be done with a model beside printing it as it was drawn.
#[derive(Clone, Debug)]
pub struct WaysOut {
    /// Whether its solids may be cut.
    pub cutting: Cutting,
    /// Cuts that are made first, whatever they gain: with any, the model is printed no other way. What has none of them is cut where it must be.
    pub cuts: Vec<GivenCut>,
    /// Whether they may stand on supports.
    pub supporting: Supporting,
    /// Whether it may stand otherwise than it was drawn, where nobody said how.
    pub turning: bool,
    /// The only way that is wanted.
    pub only: Option<Way>,
    /// What supports hold.
    pub holdings: Holdings,
    /// Ways that came to nothing, and are not tried again.
    pub lost: Vec<TriedWay>,
}

impl WaysOut {
    /// As it was drawn, or not at all.
    pub const NONE: Self = Self {
        cutting: Cutting::Never,
        cuts: Vec::new(),
        supporting: Supporting::Never,
        turning: false,
        only: None,
        holdings: Holdings::USUAL,
        lost: Vec::new(),
    };

    /// That cuts can be made which somebody has decided, where there are some: of parts as their files have them, which are to be cut.
    ///
    /// # Errors
    ///
    /// [`BadSetting::UnwantedCut`], [`BadSetting::ArrangedCut`], [`BadSetting::CutOfWhich`] and [`BadSetting::NoSuchPart`].
    pub(super) fn allow_cuts(&self, set: &SetUp) -> Result<(), BadSetting> {
        if self.cuts.is_empty() {
            return Ok(());
        }
        match (self.only, &self.cutting) {
            (Some(way), _) if way != Way::Cut => return Err(BadSetting::UnwantedCut { other: "way" }),
            (_, Cutting::Never) => return Err(BadSetting::UnwantedCut { other: "split" }),
            _ if set.origins.is_empty() => return Err(BadSetting::ArrangedCut),
            _ => {}
        }
        let last = set.model.model.parts.len() - 1;
        // Copies of one are cut alike.
        let several = set.origins.iter().any(|origin| origin.source > 0);
        for cut in &self.cuts {
            match cut.part {
                None if several => return Err(BadSetting::CutOfWhich { cut: cut.words(), parts: last + 1 }),
                Some(given) if given > last => {
                    return Err(BadSetting::NoSuchPart { name: "cut", given, last, model: set.model.file.clone() });
                }
                _ => {}
            }
        }
        Ok(())
    }

    pub(super) fn allow(&self, way: Way) -> bool {
        let held = self.supporting == Supporting::Auto;
        let may = match way {
            Way::AsDrawn => true,
            Way::Turned => self.turning,
            Way::Supports => held,
            Way::TurnedSupports => self.turning && held,
            Way::Cut => self.cutting != Cutting::Never,
        };
        may && self.only.is_none_or(|only| only.covers(way)) && self.lost.iter().all(|lost| lost.way != way)
    }
}
