//! Heads that a machine does not have: narrower, or with a longer nozzle.

use crate::profile::Profile;

/// All pieces of the head narrowed about the tip's axis.
pub(super) fn scaled(profile: &mut Profile, share: f64) {
    for body in &mut profile.head.body {
        if let Some(r) = &mut body.r_mm {
            r.iter_mut().for_each(|r| *r *= share);
        }
        for corner in [&mut body.min_mm, &mut body.max_mm].into_iter().flatten() {
            corner.iter_mut().take(2).for_each(|v| *v *= share);
        }
        for point in body.points_mm.iter_mut().flatten() {
            point.iter_mut().take(2).for_each(|v| *v *= share);
        }
    }
}

/// All pieces of the head raised; the room below is a tip as wide as the lowest piece's lower end.
pub(super) fn raised(profile: &mut Profile, by: f64) {
    let mut tip: Option<(f64, f64)> = None;
    for body in &mut profile.head.body {
        if let (Some(z), Some(r)) = (&mut body.z_mm, body.r_mm) {
            if tip.is_none_or(|(low, _)| z[0] < low) {
                tip = Some((z[0], r[0]));
            }
            z.iter_mut().for_each(|z| *z += by);
        }
        for corner in [&mut body.min_mm, &mut body.max_mm].into_iter().flatten() {
            corner[2] += by;
        }
        for point in body.points_mm.iter_mut().flatten() {
            point[2] += by;
        }
    }
    if let (Some((low, radius)), Some(first)) = (tip, profile.head.body.iter().find(|b| b.z_mm.is_some()).cloned()) {
        let needle = crate::profile::BodySpec {
            name: "longer nozzle".to_owned(),
            z_mm: Some([low, low + by]),
            r_mm: Some([radius, radius]),
            ..first
        };
        profile.head.body.push(needle);
    }
}
