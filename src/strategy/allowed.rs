//! Ways to print a model that may be taken.

use super::arrange::SetUp;
use super::cutting::Cutting;
use super::error::StrategyError;
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
    /// Cuts that are made first, whatever they gain: with any, one solid is cut and printed no other way. Its file's frame.
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

    /// That cuts can be made which somebody has decided, where there are some: of one solid as its file has it, which is to be cut.
    ///
    /// # Errors
    ///
    /// [`BadSetting::UnwantedCut`], [`BadSetting::ArrangedCut`] and [`StrategyError::NotOneSolid`].
    pub(super) fn allow_cuts(&self, set: &SetUp) -> Result<(), StrategyError> {
        let unwanted = |other| Err(BadSetting::UnwantedCut { other }.into());
        let (file, parts) = (&set.model.file, set.model.model.parts.len());
        match (self.only, &self.cutting) {
            _ if self.cuts.is_empty() => Ok(()),
            (Some(way), _) if way != Way::Cut => unwanted("way"),
            (_, Cutting::Never) => unwanted("split"),
            _ if set.arranged.is_some() => Err(BadSetting::ArrangedCut.into()),
            _ if parts != 1 => Err(StrategyError::NotOneSolid { file: file.clone(), parts }),
            _ => Ok(()),
        }
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
