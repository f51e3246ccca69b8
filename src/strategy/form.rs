//! What supports have beside their columns: a roof below what they hold, and struts where a column would stand free.

use crate::input::BadSetting;

/// The form of supports; lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportForm {
    /// Height of a roof of lines below what is held; 0: none. Printed with a part it has whole layers.
    pub roof_mm: f64,
    /// Distance between the lines of the roof; `None`: two widths of a line.
    pub roof_pitch_mm: Option<f64>,
    /// Over so much of its height a column may stand free of others; 0: over any.
    pub brace_mm: f64,
}

/// Grids that are tried below a part: a coarse one is laid sooner, a fine one reaches more and has columns that join sooner.
pub(super) const STEPS_MM: [f64; 3] = [5.0, 3.5, 2.5];
/// Distances between sheets that are tried where there is nothing but these: lines that go over them on a slant are no longer than a bridge.
pub(super) const PROP_STEPS_MM: [f64; 3] = [9.0, 5.0, 2.5];
/// Distances between the lines of a roof.
const PITCHES_MM: [f64; 2] = [0.1, 10.0];
/// Longer columns than this nobody prints.
const LONGEST_MM: f64 = 1000.0;

impl SupportForm {
    /// Columns alone.
    pub const PLAIN: Self = Self { roof_mm: 0.0, roof_pitch_mm: None, brace_mm: 0.0 };
    /// What is printed with a part: columns that stay put under a nozzle, which costs a hundredth or two.
    pub const PRINTED: Self = Self { brace_mm: 15.0, ..Self::PLAIN };

    /// The first setting that is not the usual one of what is printed: where there are no supports, it is given in vain.
    pub fn shaped_by(&self) -> Option<&'static str> {
        let usual = Self::PRINTED;
        let all = [
            ("roof", self.roof_mm != usual.roof_mm),
            ("roof-pitch", self.roof_pitch_mm.is_some()),
            ("brace", self.brace_mm != usual.brace_mm),
        ];
        all.into_iter().find(|(_, given)| *given).map(|(name, _)| name)
    }

    /// Whether it can be: a roof up to `roof_mm` high, and columns free over two steps of the grid at least.
    ///
    /// # Errors
    ///
    /// [`BadSetting::OutOfRange`].
    pub(crate) fn check(&self, roof_mm: f64, step_mm: f64) -> Result<(), BadSetting> {
        BadSetting::within("roof", self.roof_mm, " mm", [0.0, roof_mm])?;
        if let Some(pitch) = self.roof_pitch_mm {
            BadSetting::within("roof-pitch", pitch, " mm", PITCHES_MM)?;
        }
        if self.brace_mm == 0.0 {
            return Ok(());
        }
        BadSetting::within("brace", self.brace_mm, " mm", [2.0 * step_mm, LONGEST_MM])
    }
}
