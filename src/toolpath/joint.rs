//! The first layers of a print on another: the first as thick as the room that is really there, and what `[joint]` asks of them.
//!
//! What carries it was printed in whole layers and ends up to half a layer below or above its model's top
//! (`planning::joint_gap_mm`). The tip stays where it was sliced, so that all further layers are right; the first one's lines
//! take as much more or less filament as their cross-section grows or shrinks, each by its own width where that is stated.
//!
//! An overlap lays the first layer so much lower with all this filament, which presses it into what carries it; the room that
//! this leaves above is filled by the second layer's lines, but for those that the slicer gives another height than their layer's.

use super::sliced::SlicedPrint;
use crate::gcode::marks::{Bead, Hint, Role};
use crate::profile::{JointSettings, Profile};

/// What a layer's lines take, and where and how fast they are laid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Flow {
    /// Of the filament that was sliced.
    pub(super) share: f64,
    /// The layer's height where it is not the sliced one, mm.
    pub(super) height_mm: Option<f64>,
    /// The layer lies so much lower than sliced, mm.
    pub(super) lower_mm: f64,
    /// Its lines are laid no faster, mm/min.
    pub(super) most_feed: f64,
}

impl Default for Flow {
    fn default() -> Self {
        Self { share: 1.0, height_mm: None, lower_mm: 0.0, most_feed: f64::INFINITY }
    }
}

/// What the slicer says of the lines that come next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Said {
    pub(super) width_mm: Option<f64>,
    pub(super) height_mm: Option<f64>,
    pub(super) role: Role,
}

/// Heights in comments have so many digits, mm.
const ALIKE_MM: f64 = 2e-3;

impl Said {
    pub(super) fn hear(&mut self, hint: &Hint) {
        match hint {
            Hint::Width(mm) => self.width_mm = Some(*mm),
            Hint::Height(mm) => self.height_mm = Some(*mm),
            Hint::Role(role) => self.role = *role,
            Hint::Layer => {}
        }
    }

    /// Whether such lines are as high as their layer: no threads or infill of a height of their own, nothing that smooths.
    pub(super) fn fills(&self, layer_mm: f64) -> bool {
        self.role != Role::Ironing && self.height_mm.is_none_or(|mm| (mm - layer_mm).abs() < ALIKE_MM)
    }
}

/// A print's own first layers.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Joint {
    first: Option<Grown>,
    second: Option<Grown>,
    /// Filament that they take more than was sliced, mm.
    pub(super) added_mm: f64,
    /// How much lower the first is laid than sliced, mm.
    pub(super) lower_mm: f64,
    /// So many layers have the speed, fan and nozzle of `[joint]`.
    layers: usize,
    /// Their lines are laid no faster, mm/min.
    most_feed: Option<f64>,
}

/// An overlap that would bring the nozzle down onto what it prints on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pressed {
    /// `[joint] overlap_mm`.
    pub(super) overlap_mm: f64,
    /// The room that the first layer has.
    pub(super) room_mm: f64,
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

    /// What `lines`, by width, take more than was sliced, mm.
    fn added(&self, lines: &[(Option<f64>, f64)]) -> f64 {
        lines.iter().map(|(width, filament)| filament * (self.share(*width) - 1.0)).sum()
    }
}

/// Gaps below this are the last digits of meshes and files, mm.
const NONE_MM: f64 = 2e-3;
/// The most that the first layer grows or shrinks, in layers: slicers round a top up or down by half of one.
const MOST_LAYERS: f64 = 0.65;
/// An overlap takes at most so much of the room that the first layer has.
const MOST_PRESSED: f64 = 0.5;

impl Joint {
    /// The joint over a gap of `gap_mm`. A gap beyond [`MOST_LAYERS`] is not bridged here; verification says what is missing.
    pub(super) fn over(gap_mm: f64, sliced: &SlicedPrint<'_>, profile: &Profile) -> Self {
        let Some(first) = sliced.layers.first() else { return Self::default() };
        let height = first.z;
        if gap_mm.abs() < NONE_MM || gap_mm.abs() > MOST_LAYERS * height {
            return Self::default();
        }
        let grown = grown(sliced, profile, [height, height + gap_mm]);
        Self { first: Some(grown), added_mm: grown.added(&sliced.first_layer), ..Self::default() }
    }

    /// The same with what `[joint]` asks of a print that begins on an earlier part.
    ///
    /// # Errors
    ///
    /// [`Pressed`] where the overlap would take more than half of the first layer's room.
    pub(super) fn settled(self, gap_mm: f64, sliced: &SlicedPrint<'_>, profile: &Profile) -> Result<Self, Pressed> {
        let JointSettings { layers, overlap_mm, mm_per_s, .. } = profile.joint;
        let mut joint = Self {
            layers: layers as usize,
            most_feed: mm_per_s.map(|speed| speed * 60.0),
            lower_mm: overlap_mm,
            ..self
        };
        let Some(first) = sliced.layers.first().filter(|_| overlap_mm > 0.0) else { return Ok(joint) };
        let room_mm = first.z + gap_mm;
        if overlap_mm > MOST_PRESSED * room_mm {
            return Err(Pressed { overlap_mm, room_mm });
        }
        if let Some(second) = sliced.layers.get(1) {
            let height = second.z - first.z;
            let grown = grown(sliced, profile, [height, height + overlap_mm]);
            joint.added_mm += grown.added(&sliced.second_layer);
            joint.second = Some(grown);
        }
        Ok(joint)
    }

    /// Whether layer `index` has the speed, fan and nozzle of `[joint]`.
    pub(super) fn reaches(&self, index: usize) -> bool {
        index < self.layers
    }

    /// Where and how fast layer `index` is laid; see [`Self::flow`] for what its lines take.
    pub(super) fn layer(&self, index: usize, said: &Said) -> Flow {
        let lower_mm = if index == 0 { self.lower_mm } else { 0.0 };
        let most_feed = self.most_feed.filter(|_| self.reaches(index)).unwrap_or(f64::INFINITY);
        // What was said of the layer before's widths holds on for the second layer only; the first begins with none.
        let said = if index == 0 { Said::default() } else { *said };
        let (share, height_mm) = self.flow(index, &said);
        Flow { share, height_mm, lower_mm, most_feed }
    }

    /// What lines of which so much is said take, and how high they are where that is not as sliced.
    pub(super) fn flow(&self, index: usize, said: &Said) -> (f64, Option<f64>) {
        let grown = match index {
            0 => self.first,
            1 => self.second.filter(|grown| said.fills(grown.heights_mm[0])),
            _ => None,
        };
        grown.map_or((1.0, None), |grown| (grown.share(said.width_mm), Some(grown.heights_mm[1])))
    }
}

fn grown(sliced: &SlicedPrint<'_>, profile: &Profile, heights_mm: [f64; 2]) -> Grown {
    Grown { bead: sliced.bead, width_mm: profile.process.line_width_mm, heights_mm }
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
