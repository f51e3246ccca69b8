//! Where the table of a profile comes: what a person holds against his machine before he believes the numbers.
//!
//! Machine coordinates, mm; tilts as words, degrees.

use super::schema::Profile;
use crate::geom::Angle;
use crate::motion::Pose;

/// The table at one tilt, its rotation at zero.
#[derive(Clone, Debug, PartialEq)]
pub struct TableAt {
    /// The tilt's word.
    pub tilt_deg: f64,
    /// The middle of the table's surface.
    pub centre_mm: [f64; 3],
    /// Whether the tip may go there.
    pub within: bool,
    /// The highest point of the table.
    pub top_mm: f64,
    /// How far the tip may go above that.
    pub room_mm: f64,
}

impl Profile {
    /// The table level, and at both ends of its tilt.
    pub fn table_at_its_ends(&self) -> Vec<TableAt> {
        let table = self.kinematics();
        let ends = table.tilt.range.map(|(low, high)| [low, high].map(|word| (word, table.tilt.angle_of(word))));
        let level = (table.tilt.word_of(Angle::ZERO), Angle::ZERO);
        let mut all = vec![level];
        all.extend(ends.into_iter().flatten().filter(|(_, angle)| angle.rad() != 0.0));
        let (low, high) = (self.linear_limits().min, self.linear_limits().max);
        let at = |(word, tilt): (Angle, Angle)| {
            let motion = table.forward(Pose { tilt, ..Pose::LEVEL });
            let slab = self.table_slab();
            let heights = slab.iter().map(|p| (motion.rotation * p + motion.translation).z);
            let top_mm = heights.fold(f64::NEG_INFINITY, f64::max);
            let centre = motion.translation;
            let within = (0..3).all(|i| (low[i]..=high[i]).contains(&centre[i]));
            TableAt { tilt_deg: word.deg(), centre_mm: centre.into(), within, top_mm, room_mm: high.z - top_mm }
        };
        all.into_iter().map(at).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::profile::resolve;

    /// The generic table turns about X, 20 mm below its surface: at a quarter turn the middle of its surface comes 20 mm to -Y.
    #[test]
    fn the_tables_middle_comes_where_a_drawing_has_it() {
        let (profile, _) = resolve("mine.toml", "").unwrap();
        let all = profile.table_at_its_ends();
        assert_eq!(all.iter().map(|at| at.tilt_deg.round()).collect::<Vec<_>>(), [0.0, -15.0, 90.0]);
        let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(near(all[0].centre_mm, [0.0; 3]) && near(all[2].centre_mm, [0.0, -20.0, -20.0]), "{all:?}");
        // A disc of 100 mm on edge reaches 80 mm up from the axis at -20.
        assert!((all[2].top_mm - 80.0).abs() < 0.2 && (all[2].room_mm - 240.0).abs() < 0.2, "{all:?}");
        assert!(all.iter().all(|at| at.within));
    }
}
