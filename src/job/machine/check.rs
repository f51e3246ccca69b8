//! What a profile says of its machine, in numbers that a person can hold against the machine itself.
//!
//! Machine coordinates, mm; tilts as words, degrees. The rotation stands at its zero: a disc is the same at every rotation.

use std::path::PathBuf;

use super::error::MachineError;
use crate::calibrate::ClearWay;
use crate::geom::{Angle, Vec3};
use crate::input::{LoadedProfile, MachineSource, load_profile, own_profiles};
use crate::motion::{Pose, SwivelHead, TableKinematics, TiltAbout};
use crate::pictures::from_the_side;
use crate::planning::{Head, contact_mm, table_solid};
use crate::profile::{BodyKind, Profile};
use crate::view::Drawing;
use crate::world::World;

/// Tilts between the ends that are told, degrees.
const STEP_DEG: f64 = 15.0;
/// Between looks at whether an object of some size is reached, degrees.
const LOOK_DEG: f64 = 2.5;
/// Places along the slope that are tried.
const PLACES: usize = 81;

/// The table at one tilt.
#[derive(Clone, Debug, PartialEq)]
pub struct Tilted {
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
    /// Where on the line through the middle, straight up the slope, the tip can come down onto the bare table: from the middle, upward
    /// positive, lowest and highest place. `None`: nowhere.
    pub reached_mm: Option<[f64; 2]>,
}

/// A profile that makes sense, and what follows from it.
#[derive(Clone, Debug)]
pub struct CheckedProfile {
    /// The machine.
    pub machine: LoadedProfile,
    /// Level first, then both ends, then what lies between.
    pub tilts: Vec<Tilted>,
    /// From the table's middle to the nearer end of its usable surface, mm.
    pub half_mm: f64,
    /// The largest upright cylinder on the level table: diameter and height.
    pub largest_level_mm: [f64; 2],
    /// The largest one, as high as wide, all of which the tip reaches at every tilt; 0 for none.
    pub largest_any_mm: f64,
    /// The highest that the bare table comes while it turns, whatever it turns by.
    pub sweeps_to_mm: f64,
    /// How far the tilt and the rotation axis point from where they are on a machine with square axes, degrees.
    pub axes_off_deg: [f64; 2],
    /// Why it must not be used as it is; empty where it may.
    pub refusals: Vec<String>,
}

/// Reads a profile and looks at what it describes.
///
/// # Errors
///
/// As [`load_profile`].
pub fn check_profile(from: &MachineSource, world: &World<'_>) -> Result<CheckedProfile, MachineError> {
    Ok(checked(load_profile(from, world)?))
}

/// The user's own profiles: name, file, and what each describes or why it cannot be read.
pub fn own_machines(world: &World<'_>) -> Vec<(String, PathBuf, Result<CheckedProfile, MachineError>)> {
    let all = own_profiles(world).into_iter();
    all.map(|(name, file, loaded)| (name, file, loaded.map(checked).map_err(MachineError::from))).collect()
}

fn checked(machine: LoadedProfile) -> CheckedProfile {
    let profile = &machine.profile;
    let clear = ClearWay::of(profile);
    let tilts: Vec<Tilted> = words(profile).into_iter().map(|word| tilted(profile, &clear, word)).collect();
    let half_mm = half(profile);
    let (largest_level_mm, largest_any_mm) = (level(profile, half_mm), any(profile, half_mm));
    let refusals = refusals(profile, &tilts);
    let table = profile.kinematics();
    let sweeps_to_mm = match &table.head {
        Some(head) => head.table.z + profile.head_depth_mm(None),
        None => clear.ball_top(),
    };
    let axes_off_deg = axes_off(&profile.kinematics());
    CheckedProfile { machine, axes_off_deg, tilts, half_mm, largest_level_mm, largest_any_mm, sweeps_to_mm, refusals }
}

/// Level, both ends, and every [`STEP_DEG`] between them.
fn words(profile: &Profile) -> Vec<f64> {
    if profile.kinematics().tilt.absent {
        return vec![0.0];
    }
    let tilt = &profile.kinematics.tilt;
    let first = (tilt.min_deg / STEP_DEG).ceil() as i64;
    let last = (tilt.max_deg / STEP_DEG).floor() as i64;
    let between = (first..=last).map(|i| i as f64 * STEP_DEG);
    let mut all: Vec<f64> = Vec::new();
    for word in [tilt.zero_deg, tilt.min_deg, tilt.max_deg].into_iter().chain(between) {
        if !all.contains(&word) {
            all.push(word);
        }
    }
    all
}

/// How far the axes point from a machine axis and from +Z, degrees.
fn axes_off(table: &TableKinematics) -> [f64; 2] {
    let axes = table.directions();
    let square = TableKinematics { misaligned: None, ..table.clone() }.directions();
    [axes.tilt.angle(&square.tilt), axes.rotation.angle(&square.rotation)].map(f64::to_degrees)
}

fn pose(profile: &Profile, word: f64) -> Pose {
    Pose { tilt: profile.kinematics().tilt.angle_of(Angle::from_deg(word)), ..Pose::LEVEL }
}

fn half(profile: &Profile) -> f64 {
    let table = &profile.table;
    let half = match (table.radius_mm == 0.0, table.size_mm) {
        (true, Some([x, y])) => x.min(y) / 2.0,
        _ => table.radius_mm,
    };
    (half - table.keep_out_mm).max(0.0)
}

/// Of a head that leans, where its axes stand while the tip touches the table.
fn leaning(profile: &Profile, head: &SwivelHead, word: f64) -> Tilted {
    let (table, limits) = (profile.kinematics(), profile.linear_limits());
    let pose = pose(profile, word);
    let (axes, motion) = (table.axes(pose), table.forward(pose));
    let slab = table_solid(profile, &motion);
    let pieces = Head::of(profile);
    let pieces = pieces.at(pose);
    let across = if table.about == TiltAbout::X { Vec3::y() } else { Vec3::x() };
    let reach = half(profile);
    let reached = |place: f64| {
        let [at, tip] = [&axes, &motion].map(|motion| motion.point((across * place).into()).at);
        limits.violation(&at).is_none() && pieces.passes(tip, tip, &slab, contact_mm(profile))
    };
    let places = (0..PLACES).map(|i| reach * (2.0 * i as f64 / (PLACES - 1) as f64 - 1.0));
    let reached: Vec<f64> = places.filter(|&place| reached(place)).collect();
    Tilted {
        tilt_deg: word,
        centre_mm: axes.translation.into(),
        within: limits.violation(&axes.translation).is_none(),
        top_mm: head.table.z,
        room_mm: limits.max.z - head.table.z,
        reached_mm: reached.first().zip(reached.last()).map(|(low, high)| [*low, *high]),
    }
}

fn tilted(profile: &Profile, clear: &ClearWay, word: f64) -> Tilted {
    let table = profile.kinematics();
    if let Some(head) = &table.head {
        return leaning(profile, head, word);
    }
    let motion = table.forward(pose(profile, word));
    let at = |q: &Vec3| motion.rotation * q + motion.translation;
    let top_mm = profile.table_slab().iter().map(|p| at(p).z).fold(f64::NEG_INFINITY, f64::max);
    let (limits, centre) = (profile.linear_limits(), motion.translation);
    let across = if table.about == TiltAbout::X { Vec3::y() } else { Vec3::x() };
    let up = if (motion.rotation * across).z < 0.0 { -across } else { across };
    let normal = motion.rotation * Vec3::z();
    let rotation = profile.kinematics.rotation.zero_deg;
    let reach = half(profile);
    let reached = |place: f64| {
        // The nozzle's rim comes down first.
        let gap = profile.tip_radius_mm() * normal.x.hypot(normal.y) / normal.z;
        let tip = at(&(up * place)) + Vec3::z() * gap;
        normal.z > 0.05 && clear.touchable([word, rotation], &tip, limits.max.z.max(tip.z))
    };
    let places = (0..PLACES).map(|i| reach * (2.0 * i as f64 / (PLACES - 1) as f64 - 1.0));
    let reached: Vec<f64> = places.filter(|&place| reached(place)).collect();
    Tilted {
        tilt_deg: word,
        centre_mm: centre.into(),
        within: limits.violation(&centre).is_none(),
        top_mm,
        room_mm: limits.max.z - top_mm,
        reached_mm: reached.first().zip(reached.last()).map(|(low, high)| [*low, *high]),
    }
}

fn level(profile: &Profile, half_mm: f64) -> [f64; 2] {
    let (limits, centre) = (profile.linear_limits(), profile.kinematics().axes(Pose::LEVEL).translation);
    let sides = (0..2).flat_map(|i| [limits.max[i] - centre[i], centre[i] - limits.min[i]]);
    let radius = sides.fold(half_mm, f64::min).max(0.0);
    [2.0 * radius, (limits.max.z - centre.z - profile.transition.clearance_mm).max(0.0)]
}

/// By halving: what a cylinder reaches, every smaller one does.
fn any(profile: &Profile, half_mm: f64) -> f64 {
    let (table, limits) = (profile.kinematics(), profile.linear_limits());
    let tilt = &profile.kinematics.tilt;
    let steps = ((tilt.max_deg - tilt.min_deg) / LOOK_DEG).ceil() as usize;
    let motions: Vec<_> = (0..=steps)
        .map(|i| tilt.min_deg + (tilt.max_deg - tilt.min_deg) * i as f64 / steps.max(1) as f64)
        .map(|word| table.axes(pose(profile, word)))
        .collect();
    let over = Vec3::z() * profile.transition.clearance_mm;
    let fits = |radius: f64| {
        let ring = (0..48).map(|i| (std::f64::consts::TAU * f64::from(i) / 48.0).sin_cos());
        let points: Vec<Vec3> =
            ring.flat_map(|(s, c)| [0.0, 2.0 * radius].map(|z| Vec3::new(radius * c, radius * s, z))).collect();
        motions.iter().all(|motion| {
            let at = |q: &Vec3| motion.rotation * q + motion.translation;
            points.iter().all(|q| limits.violation(&at(q)).is_none() && limits.violation(&(at(q) + over)).is_none())
        })
    };
    let (mut low, mut high) = (0.0, half_mm);
    if fits(high) {
        return 2.0 * high;
    }
    for _ in 0..40 {
        let middle = (low + high) / 2.0;
        if fits(middle) { low = middle } else { high = middle }
    }
    2.0 * low
}

fn refusals(profile: &Profile, tilts: &[Tilted]) -> Vec<String> {
    let mut all = Vec::new();
    let cone = matches!(&profile.head.body[..], [one] if one.kind == BodyKind::Frustum);
    if cone && !profile.head.bare_cone {
        all.push(
            "the head is one bare cone, so nothing above the nozzle would ever collide; add heater block, fan and carriage as [[head.body]], or \
             set [head] bare_cone = true"
                .to_owned(),
        );
    }
    if tilts[0].reached_mm.is_none() {
        let [x, y, z] = tilts[0].centre_mm.map(plain);
        all.push(format!(
            "the tip reaches none of the tested points on the level table (middle at X {x} Y {y} Z {z}); check [limits], pivot_mm, offset_mm and the \
             bodies of head and frame"
        ));
    }
    all
}

fn plain(value: f64) -> f64 {
    (value * 100.0).round() / 100.0 + 0.0
}

impl CheckedProfile {
    /// Between two places at which the bare table was touched, mm.
    pub fn place_mm(&self) -> f64 {
        self.half_mm / (PLACES - 1) as f64
    }

    /// The machine from the side.
    pub fn view(&self) -> Drawing {
        let tilts: Vec<f64> = self.tilts.iter().map(|at| at.tilt_deg).collect();
        from_the_side(&self.machine.profile, &tilts, self.tilts[0].centre_mm)
    }

    /// Why it must not be used, as one sentence; `None` where it may.
    pub fn refusal(&self) -> Option<String> {
        (!self.refusals.is_empty()).then(|| format!("{}: {}", self.machine.name, self.refusals.join("; ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::{Silent, Source};

    fn check(text: &str) -> Result<CheckedProfile, String> {
        let source = Source::Bytes { name: "m.toml".to_owned(), bytes: text.as_bytes().to_vec() };
        check_profile(&MachineSource::Toml(source), &World::here(&Silent)).map_err(|e| e.to_string())
    }

    /// The generic table: a disc of 100 mm whose surface is 20 mm over its axis at Z -20; X +-150, Y +-200, Z -80..320.
    #[test]
    fn the_generic_machine_as_a_drawing_has_it() {
        let done = check("").unwrap();
        assert_eq!(done.refusals, Vec::<String>::new());
        let at = |word: f64| done.tilts.iter().find(|t| t.tilt_deg == word).unwrap();
        assert_eq!(done.tilts.iter().take(3).map(|t| t.tilt_deg).collect::<Vec<_>>(), [0.0, -15.0, 90.0]);
        assert_eq!(at(0.0).reached_mm, Some([-98.0, 98.0]));
        // At 45 degrees the block, 10 mm beside the tip and 10 mm above it, meets the slope, unless there is less of it than that above.
        let [low, high] = at(45.0).reached_mm.unwrap();
        assert!(low > 70.0 && high > 90.0, "{low} {high}");
        assert_eq!(at(90.0).reached_mm, None);
        assert_eq!(done.largest_level_mm, [196.0, 315.0]);
        // At 90 degrees an object of d mm on the middle goes d mm to -Y from there, and half of d down: Z -20 - d / 2 >= -80.
        assert!((done.largest_any_mm - 120.0).abs() < 0.5, "{}", done.largest_any_mm);
        assert!((done.sweeps_to_mm - 100.4).abs() < 0.2, "{}", done.sweeps_to_mm);
    }

    #[test]
    fn a_bare_cone_must_be_meant() {
        let cone = "[head]\nBARE\nbody = [{ name = \"n\", moves = \"XYZ\", kind = \"frustum\", z_mm = [0, 60], r_mm = [0.5, 8] }]\n";
        let bare = check(&cone.replace("BARE\n", "")).unwrap();
        assert!(bare.refusal().unwrap().contains("bare_cone = true"), "{:?}", bare.refusals);
        assert_eq!(check(&cone.replace("BARE", "bare_cone = true")).unwrap().refusal(), None);
        let typo = check(&cone.replace("BARE", "bare_con = true")).unwrap_err();
        assert!(typo.contains("nearest is \"head.bare_cone\""), "{typo}");
    }

    #[test]
    fn a_table_that_is_never_level_or_never_reached_is_refused() {
        let never = check("[kinematics.tilt]\nmin_deg = 10.0\n").unwrap_err();
        assert!(never.contains("kinematics.tilt.min_deg = 10..90: must be a range that includes level"), "{never}");
        assert!(check("[kinematics.tilt]\nmin_deg = 10.0\nzero_deg = 20.0\n").is_ok());
        let far = check("[kinematics]\npivot_mm = [0.0, 900.0, 0.0]\n").unwrap();
        assert!(
            far.refusal().unwrap().contains("the tip reaches none of the tested points on the level table"),
            "{:?}",
            far.refusals
        );
    }
}
