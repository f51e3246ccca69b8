//! The first layer of a print on another: as thick as the room that is really there.
//!
//! What carries it was printed in whole layers and ends up to half a layer below or above its model's top
//! (`planning::joint_gap_mm`). The tip stays where it was sliced, so that all further layers are right; the first one's lines
//! take as much more or less filament as their cross-section grows or shrinks.

use super::sliced::SlicedPrint;
use crate::profile::SliceSettings;

/// What a layer's lines take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Flow {
    /// Of the filament that was sliced.
    pub(super) share: f64,
    /// The layer's height where it is not the sliced one, mm.
    pub(super) height_mm: Option<f64>,
}

impl Default for Flow {
    fn default() -> Self {
        Self { share: 1.0, height_mm: None }
    }
}

/// A print's own first layer.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Joint {
    first: Flow,
    /// Filament that it takes more than was sliced, mm.
    pub(super) added_mm: f64,
}

/// Gaps below this are the last digits of meshes and files, mm.
const NONE_MM: f64 = 2e-3;
/// The most that the first layer grows or shrinks, in layers: slicers round a top up or down by half of one.
const MOST_LAYERS: f64 = 0.65;

impl Joint {
    /// The joint over a gap of `gap_mm`. A gap beyond [`MOST_LAYERS`] is not bridged here; verification says what is missing.
    pub(super) fn over(gap_mm: f64, sliced: &SlicedPrint<'_>, process: &SliceSettings) -> Self {
        let Some(first) = sliced.layers.first() else { return Self::default() };
        let height = first.z;
        if gap_mm.abs() < NONE_MM || gap_mm.abs() > MOST_LAYERS * height {
            return Self::default();
        }
        let width = process.line_width_mm;
        let share = sliced.bead.area(width, height + gap_mm) / sliced.bead.area(width, height);
        let first = Flow { share, height_mm: Some(height + gap_mm) };
        Self { first, added_mm: sliced.first_layer_mm * (share - 1.0) }
    }

    /// What layer `index` takes.
    pub(super) fn flow_of(&self, index: usize) -> Flow {
        if index == 0 { self.first } else { Flow::default() }
    }
}
