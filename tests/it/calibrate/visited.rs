//! The file that visits the poses: cold, within the axes, one axis of the table at a time, and clear by points that are tried one by one.

use nalgebra::Vector3;
use trunnion::calibrate::{Of, choose, visit};
use trunnion::geom::{Angle, Body, SplitMix64};
use trunnion::motion::Pose;
use trunnion::profile::Profile;

use super::{shipped, tip};
use crate::support::{every, states};

/// Any points of a convex body.
fn points_of(body: &Body, numbers: &mut SplitMix64) -> Vec<Vector3<f64>> {
    let between = |numbers: &mut SplitMix64| {
        let weights: Vec<f64> = body.points.iter().map(|_| -(1.0 - numbers.unit()).ln().powi(3)).collect();
        let sum: f64 = weights.iter().sum();
        body.points.iter().zip(&weights).map(|(p, w)| p * (w / sum)).sum()
    };
    body.points.iter().copied().chain((0..150).map(|_| between(numbers))).collect()
}

struct Replay<'a> {
    profile: &'a Profile,
    head: Vec<(Body, Vec<Vector3<f64>>)>,
    tip: Option<Vector3<f64>>,
    words: [f64; 2],
    nearest: f64,
}

impl Replay<'_> {
    /// How far a point is from the disc of the table, roughly: negative inside it.
    fn gap(&self, p: &Vector3<f64>, words: [f64; 2]) -> f64 {
        let table = self.profile.kinematics();
        let [tilt, rotation] = words.map(Angle::from_deg);
        let motion =
            table.forward(Pose { tilt: table.tilt.angle_of(tilt), rotation: table.rotation.angle_of(rotation) });
        let q = motion.rotation.transpose() * (p - motion.translation);
        let aside = q.x.hypot(q.y) - self.profile.table.radius_mm;
        aside.max(q.z).max(-self.profile.table.thickness_mm - q.z)
    }

    fn look(&mut self, tip: &Vector3<f64>, words: [f64; 2]) {
        let mut nearest = self.nearest;
        for (body, points) in &self.head {
            let origin = body.origin_at(tip);
            for p in points {
                nearest = nearest.min(self.gap(&(p + origin), words));
            }
        }
        self.nearest = nearest;
    }

    fn go(&mut self, to_tip: Option<Vector3<f64>>, to_words: [f64; 2]) {
        let (from, words) = (self.tip, self.words);
        if let (Some(from), Some(to)) = (from.or(to_tip), to_tip.or(from)) {
            let turn = (to_words[0] - words[0]).abs().max((to_words[1] - words[1]).abs());
            let steps = ((to - from).norm() / 4.0).max(turn / 2.0).ceil().max(1.0);
            for step in 0..=steps as usize {
                let share = step as f64 / steps;
                let between = |i: usize| words[i] + (to_words[i] - words[i]) * share;
                self.look(&(from + (to - from) * share), [between(0), between(1)]);
            }
        }
        (self.tip, self.words) = (to_tip.or(from), to_words);
    }
}

/// What became of a file, line by line.
pub(crate) struct Visited {
    /// How near the head came to the table, mm, by points.
    pub(crate) nearest: f64,
    /// The words of the table at each stop, degrees.
    pub(crate) stops: Vec<[f64; 2]>,
    /// Where the tip was, with the words.
    pub(crate) tips: Vec<([f64; 2], Vector3<f64>)>,
}

/// Carries out a cold file: nothing heats, nothing is pushed, all is slow, one axis of the table at a time, within the axes.
pub(crate) fn visited(profile: &Profile, gcode: &str) -> Visited {
    let name = &profile.machine.name;
    let mut numbers = SplitMix64::seeded(3);
    let head = profile.head_bodies().into_iter().map(|body| {
        let points = points_of(&body, &mut numbers);
        (body, points)
    });
    let mut replay = Replay { profile, head: head.collect(), tip: None, words: [0.0; 2], nearest: f64::INFINITY };
    let letters = [profile.kinematics.tilt.letter, profile.kinematics.rotation.letter];
    let (mut at, mut stops, mut tips) = ([None; 3], Vec::new(), Vec::new());
    for line in gcode.lines().filter(|line| !line.starts_with(';')) {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        if ["M0", "M226", "PAUSE"].contains(&words[0]) {
            stops.push(replay.words);
        }
        assert!(!["M104", "M109", "M140", "M190", "M106"].contains(&words[0]), "{name}: {line} heats");
        if words[0] != "G1" {
            continue;
        }
        assert!(!words.iter().any(|w| w.starts_with(profile.dialect.extruder)), "{name}: {line} pushes filament");
        let turns: Vec<usize> = (0..2).filter(|&i| words.iter().any(|w| w.starts_with(letters[i]))).collect();
        let mut to = replay.words;
        for word in &words[1..] {
            let value: f64 = word[1..].parse().unwrap();
            match word.chars().next().unwrap() {
                'F' => assert!(value <= 1500.0, "{name}: {line} is fast"),
                axis @ ('X' | 'Y' | 'Z') => at["XYZ".find(axis).unwrap()] = Some(value),
                axis => to[letters.iter().position(|l| *l == axis).unwrap()] = value,
            }
        }
        assert!(turns.len() <= 1 && (turns.is_empty() || words.len() == 3), "{name}: {line} turns with something else");
        let tip = at[0].zip(at[1]).zip(at[2]).map(|((x, y), z)| Vector3::new(x, y, z));
        tip.iter().for_each(|tip| assert_eq!(profile.linear_limits().violation(tip), None, "{name}: {line}"));
        replay.go(tip, to);
        tips.extend(tip.map(|tip| (to, tip)));
    }
    Visited { nearest: replay.nearest, stops, tips }
}

#[test]
fn the_poses_are_visited_cold_clear_and_within_the_axes() {
    for name in ["generic-ac", "fibr3d", "open5x-prusa", "linuxcnc-xyzac-trt"].into_iter().step_by(every(2)) {
        let profile = shipped(name);
        let chosen = choose(&profile, &tip(), 0.02, 40, false);
        let names: Vec<String> = chosen.poses.iter().map(|_| "it".to_owned()).collect();
        let made = visit(&profile, &chosen.poses, &names).unwrap_or_else(|no| panic!("{name}: {no}"));
        let needless = |line: &String| line.starts_with('M') || line == "G64 P0.01";
        assert!(made.left_out.iter().all(needless), "{name}: {:?}", made.left_out);
        let seen = visited(&profile, &made.gcode);
        assert_eq!(seen.stops.len(), chosen.poses.len(), "{name}");
        assert!(seen.nearest > 2.9, "{name}: the head comes to {} mm from the table", seen.nearest);
        assert!(chosen.poses.iter().any(|one| one.of != Of::Table && one.words_deg[0].abs() > 10.0), "{name}");
    }
}

#[test]
fn a_way_that_is_not_clear_is_refused() {
    let mut profile = shipped("generic-ac");
    let chosen = choose(&profile, &tip(), 0.02, 40, false);
    let names: Vec<String> = chosen.poses.iter().map(|_| "it".to_owned()).collect();
    // Z ends below the ball that the table sweeps, and the head hangs over it when the rim comes up.
    profile.limits.z_mm[1] = 30.0;
    let no = visit(&profile, &chosen.poses, &names).unwrap_err();
    assert!(states(&no.to_string(), "pose | clear"), "{no}");
}
