//! A G-code file that rehearses a print on the machine itself: cold, slowly, to each of its poses and there to the outermost places of
//! the tip, 20 mm above them, with a stop at each pose.
//!
//! The table is bare and the ways are looked at before they are written, as in [`visit`](super::visit): up to where the table can turn,
//! rotation alone, tilt alone, a stop, then across and down to each place and up again.

use super::clear::ClearWay;
use super::visit::{HOVER_MM, NoVisit, Visit, Writer, turning_height};
use crate::geom::Vec3;
use crate::profile::Profile;

/// One pose of a print.
#[derive(Clone, Debug, PartialEq)]
pub struct ColdPose {
    /// The words of tilt and rotation, degrees.
    pub words_deg: [f64; 2],
    /// What is printed there.
    pub name: String,
    /// The outermost places of the tip, machine coordinates, mm.
    pub places: Vec<Vec3>,
}

const HEAD: &str = "\
; A dry run of a print: cold, slow, no filament, 20 mm above where the tip would go (less where Z ends). The table must be empty.
; Before it starts: table level, both its axes as after homing, a hand on the switch. At each stop look, then go on.
";

/// The file that goes to `poses` in their order. The table stands level, the rotation at its zero, when it begins.
///
/// # Errors
///
/// [`NoVisit`] with the pose that cannot be come to without the head, the table or the frame meeting.
pub fn dry_run(profile: &Profile, poses: &[ColdPose]) -> Result<Visit, NoVisit> {
    let clear = ClearWay::of(profile);
    // A print may be higher than the ball that the bare table sweeps.
    let highest = poses.iter().flat_map(|pose| &pose.places).map(|place| place.z).fold(f64::NEG_INFINITY, f64::max);
    let height = turning_height(profile, &clear)?.max((highest + HOVER_MM).min(profile.limits.z_mm[1]));
    let mut writer = Writer::new(profile, height, HEAD);
    let level = [profile.kinematics.tilt.zero_deg, profile.kinematics.rotation.zero_deg];
    let (mut words, mut at) = (level, None);
    for (index, pose) in poses.iter().enumerate() {
        let stop = |why: String| NoVisit { number: index + 1, why };
        let Some(first) = pose.places.first() else { continue };
        let high = |place: &Vec3| Vec3::new(place.x, place.y, height);
        writer.says(&format!("{} of {}: {}", index + 1, poses.len(), pose.name));
        let waits = at.unwrap_or_else(|| high(first));
        writer.up(at.is_none().then_some(&waits));
        let between = [words[0], pose.words_deg[1]];
        clear.turns_through([words, between, pose.words_deg], &waits).map_err(stop)?;
        writer.turn(between, pose.words_deg);
        writer.pause();
        let mut from = waits;
        for place in &pose.places {
            let (above, hover) = (high(place), place + Vec3::z() * HOVER_MM.min(height - place.z));
            if !clear.passes(pose.words_deg, &from, &above) || !clear.touchable(pose.words_deg, &hover, height) {
                return Err(stop(format!("cannot prove that the path to X{:.1} Y{:.1} is clear", place.x, place.y)));
            }
            writer.over(&above, &hover);
            writer.up(None);
            from = above;
        }
        (words, at) = (pose.words_deg, Some(from));
    }
    if let Some(at) = &at {
        let stop = |why: String| NoVisit { number: poses.len(), why: format!("on the return path, {why}") };
        clear.turns_through([words, [words[0], level[1]], level], at).map_err(stop)?;
    }
    Ok(writer.end(level, at))
}

/// Of places of the tip the lowest and highest along each axis, each once.
pub fn outermost(places: impl Iterator<Item = Vec3>) -> Vec<Vec3> {
    let mut ends: Vec<Option<[Vec3; 2]>> = vec![None; 3];
    for place in places {
        for (axis, ends) in ends.iter_mut().enumerate() {
            let [low, high] = ends.get_or_insert([place; 2]);
            if place[axis] < low[axis] {
                *low = place;
            }
            if place[axis] > high[axis] {
                *high = place;
            }
        }
    }
    let mut all: Vec<Vec3> = Vec::new();
    for place in ends.into_iter().flatten().flatten() {
        if all.iter().all(|one| (one - place).norm() > SAME_MM) {
            all.push(place);
        }
    }
    all
}

/// Places nearer than this are one, mm.
const SAME_MM: f64 = 1.0;
