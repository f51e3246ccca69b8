//! The first layer of a print on another: as thick as the room that is really there.
//!
//! What carries it was printed in whole layers and ends up to half a layer below or above its model's top
//! (`planning::joint_gap_mm`). The tip stays where it was sliced, so that all further layers are right; the first one's lines
//! take as much more or less filament as their cross-section grows or shrinks, each by its own width where that is stated.

use super::sliced::SlicedPrint;
use crate::gcode::marks::Bead;
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
    grown: Option<Grown>,
    /// Filament that it takes more than was sliced, mm.
    pub(super) added_mm: f64,
}

/// A layer of another height than it was sliced with.
#[derive(Clone, Copy, Debug)]
struct Grown {
    bead: Bead,
    /// Of a line that states none, mm.
    width_mm: f64,
    /// Sliced, and laid, mm.
    heights_mm: [f64; 2],
}

impl Grown {
    /// What a line of this width takes of the filament that was sliced.
    fn share(&self, width_mm: Option<f64>) -> f64 {
        let [sliced, laid] = self.heights_mm.map(|height| self.bead.area(width_mm.unwrap_or(self.width_mm), height));
        if sliced > 0.0 { laid / sliced } else { 1.0 }
    }
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
        let heights_mm = [height, height + gap_mm];
        let grown = Grown { bead: sliced.bead, width_mm: process.line_width_mm, heights_mm };
        let added = |(width, filament): &(Option<f64>, f64)| filament * (grown.share(*width) - 1.0);
        Self { grown: Some(grown), added_mm: sliced.first_layer.iter().map(added).sum() }
    }

    /// What layer `index` takes, as long as no line's width is stated.
    pub(super) fn flow_of(&self, index: usize) -> Flow {
        let first = |grown: Grown| Flow { share: grown.share(None), height_mm: Some(grown.heights_mm[1]) };
        self.grown.filter(|_| index == 0).map(first).unwrap_or_default()
    }

    /// What its lines of this width take.
    pub(super) fn share_of(&self, width_mm: f64) -> f64 {
        self.grown.map_or(1.0, |grown| grown.share(Some(width_mm)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rectangle with round sides: `w h - h^2 (1 - pi / 4)`.
    #[test]
    fn each_line_grows_by_its_own_cross_section() {
        let grown = Grown { bead: Bead::Round, width_mm: 0.45, heights_mm: [0.2, 0.11] };
        let area = |width: f64, height: f64| width * height - height * height * 0.214_601_837;
        for width in [0.3, 0.45, 0.64] {
            let wanted = area(width, 0.11) / area(width, 0.2);
            assert!((grown.share(Some(width)) - wanted).abs() < 1e-9, "{width}");
        }
        assert_eq!(grown.share(None), grown.share(Some(0.45)));
        // By one share for all the wide one took 1.4 % too much.
        assert!((grown.share(None) / grown.share(Some(0.64)) - 1.014).abs() < 1e-3);
    }
}
