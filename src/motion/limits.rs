//! The box the tool tip may move in, machine coordinates.

use crate::geom::Vec3;

/// The linear axes' stops, mm, machine coordinates of the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearLimits {
    /// Lowest X, Y, Z.
    pub min: Vec3,
    /// Highest X, Y, Z.
    pub max: Vec3,
}

/// A coordinate beyond its stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfLimits {
    /// `'X'`, `'Y'` or `'Z'`.
    pub axis: char,
    /// The coordinate asked for, mm.
    pub value: f64,
    /// What the axis reaches, mm.
    pub range: (f64, f64),
}

impl std::fmt::Display for OutOfLimits {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (low, high) = self.range;
        write!(f, "{} {:.3} mm is beyond the axis range {low}..{high}", self.axis, self.value)
    }
}

/// Half of the last digit with which a coordinate is written (0.001 mm).
const LIMIT_SLACK_MM: f64 = 5e-4;

impl LinearLimits {
    /// The first coordinate of `tip` that lies beyond the stops.
    pub fn violation(&self, tip: &Vec3) -> Option<OutOfLimits> {
        (0..3).find_map(|i| {
            let outside = tip[i] < self.min[i] - LIMIT_SLACK_MM || tip[i] > self.max[i] + LIMIT_SLACK_MM;
            let axis = ['X', 'Y', 'Z'][i];
            outside.then(|| OutOfLimits { axis, value: tip[i], range: (self.min[i], self.max[i]) })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_the_axis_and_its_reach() {
        let limits = LinearLimits { min: Vec3::new(0.0, 0.0, 0.0), max: Vec3::new(10.0, 20.0, 30.0) };
        assert_eq!(limits.violation(&Vec3::new(10.0004, 0.0, 30.0)), None);
        let out = limits.violation(&Vec3::new(5.0, 20.6, 30.0)).unwrap();
        assert_eq!(out, OutOfLimits { axis: 'Y', value: 20.6, range: (0.0, 20.0) });
        assert!(out.to_string().starts_with("Y 20.600 mm ") && out.to_string().ends_with(" 0..20"), "{out}");
    }
}
