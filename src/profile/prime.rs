//! Prime lines: filament that the start code lays before the first print, so that the nozzle is full and clean.
//!
//! Such a line lies on the bare, level table, no higher than the nozzle's bore and clear of the rim. What it must keep clear of beside it
//! is printed later: `verify` holds it against that.

use std::f64::consts::{FRAC_PI_4, PI};

use super::schema::Profile;
use crate::geom::Vec3;
use crate::trace::{Trace, TraceMove};

/// A table counts as level up to this tilt, radians.
const LEVEL_RAD: f64 = 1e-6;
/// Below this the tip scrapes along the table, mm.
const LOWEST_MM: f64 = 0.05;
/// What a line's ends may differ in height, mm.
const FLAT_MM: f64 = 1e-3;
/// The widest that a line may come out, in bores of the nozzle: what is pushed beyond that goes anywhere.
const WIDEST: f64 = 4.0;

/// A prime line, table frame, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prime {
    /// In the file, from 1.
    pub line: u32,
    /// Where the tip was.
    pub ends: [Vec3; 2],
    /// As its filament makes it.
    pub width: f64,
    /// Over the table.
    pub height: f64,
}

/// The prime line that a move of the start code lays.
///
/// # Errors
///
/// Why it may not be laid, with what to do.
pub fn prime(m: &TraceMove, trace: &Trace, profile: &Profile) -> Result<Prime, String> {
    let (Some(pose), Some(ends)) = (trace.state(m).pose(), m.ends()) else {
        return Err("a prime line is printed while the tip's position or the table's pose is unknown; first raise Z above all that turns and turn both table axes to 0"
            .to_owned());
    };
    if pose.tilt.rad().abs() > LEVEL_RAD {
        return Err(format!("a prime line is printed at a tilt of {:.3} deg; level the table first", pose.tilt.deg()));
    }
    let back = profile.kinematics().forward(pose).inverse();
    let ends = ends.map(|p| back.point(p.into()).at);
    let (height, bore) = (ends[1].z, profile.process.nozzle_mm);
    if (ends[0].z - height).abs() > FLAT_MM || !(LOWEST_MM..=bore).contains(&height) {
        return Err(format!(
            "a prime line is printed {height:.2} mm above the table; it must be level, at {LOWEST_MM}..{bore} mm (process.nozzle_mm)"
        ));
    }
    let length = (ends[1] - ends[0]).norm();
    let area = m.e * PI / 4.0 * profile.process.filament_mm.powi(2) / length.max(bore);
    let width = (area / height + height * (1.0 - FRAC_PI_4)).max(height);
    if width > WIDEST * bore {
        return Err(format!(
            "a prime line is {width:.2} mm wide at {height:.2} mm height (maximum {:.2} mm); extrude less, or move farther",
            WIDEST * bore
        ));
    }
    let over = ends.iter().map(|p| profile.beyond_table(p.x, p.y)).fold(f64::NEG_INFINITY, f64::max) + width / 2.0;
    if over > 0.0 {
        return Err(format!(
            "a prime line reaches {over:.2} mm beyond the table or into its rim (table.keep_out_mm); move it inward"
        ));
    }
    Ok(Prime { line: m.line, ends, width, height })
}
