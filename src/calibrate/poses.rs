//! Where to touch: places and poses that the head can reach, chosen one after the other by how much each adds to what is known.
//!
//! Greedy, by the sum of the squared errors of the machine's unknowns, each in terms of what is wanted of it (the A-criterion: A. C.
//! Atkinson and A. N. Donev, *Optimum Experimental Designs*, 1992). Machine coordinates unless a name says table, mm.

use super::chain::{SAG_AT_MM, UNKNOWNS, Unknown};
use super::clear::ClearWay;
use super::information::{Information, WORST_DEG, WORST_MM};
use super::solve::{Problem, units};
use super::touches::{ChainCandidate, Feature, Of, Tip, TipShape, Touch, TouchShape, Touches};
use crate::geom::{Angle, Vec3};
use crate::profile::Profile;

/// Tilts that are looked at, both ends among them.
const TILTS: usize = 7;
/// Rotations that are looked at.
const TURNS: usize = 8;
/// What a tip from above can touch, degrees from level.
const STEEPEST_DEG: f64 = 65.0;
/// From the table's edge to where its rim is touched and to where marks are best drawn, mm: near the edge there is room for the head at
/// a steep tilt, and a long arm.
const RIM_MM: f64 = 3.0;
const MARK_MM: f64 = 6.0;
/// On a small table not nearer to its middle than this share of its reach.
const INSIDE: f64 = 0.6;
/// What is told of touches to come.
const TOLD: usize = 4;

/// Touches that were chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// In the order in which they are best made.
    pub poses: Vec<ChainCandidate>,
    /// The marks that they need: name and place in the table's frame, mm.
    pub marks: Vec<(String, [f64; 2])>,
    /// The standard errors that they will leave: name, mm or degrees, whether it is an angle.
    pub errors: Vec<(String, f64, bool)>,
    /// Whether all are as small as was wanted.
    pub enough: bool,
}

/// The length, mm, at which an angle counts as much as a length: to what stands at the rim as high as that is from the middle.
pub(super) fn lever(profile: &Profile) -> f64 {
    std::f64::consts::SQRT_2 * ClearWay::of(profile).reach().max(10.0)
}

/// How much of a sag at [`super::SAG_AT_MM`] there is at the table's rim.
pub(super) fn sag_at_rim(profile: &Profile) -> f64 {
    (ClearWay::of(profile).reach() / SAG_AT_MM).powi(2)
}

/// How far from the table's middle a place is that lies `from_edge` mm inside its edge, along the table's X and Y.
fn inside(profile: &Profile, from_edge: f64) -> [f64; 2] {
    let half = match (profile.table.radius_mm == 0.0, profile.table.size_mm) {
        (true, Some(size)) => size.map(|edge| edge / 2.0),
        _ => [profile.table.radius_mm; 2],
    };
    half.map(|half| (half - from_edge).max(half * INSIDE))
}

/// The words of all poses that are looked at, within the axes' stops, each rounded to a hundredth of a degree.
pub(super) fn all_words(profile: &Profile) -> Vec<[f64; 2]> {
    let (tilt, rotation) = (&profile.kinematics.tilt, &profile.kinematics.rotation);
    let spread = |low: f64, high: f64, count: usize, ends: usize| {
        (0..count).map(move |i| low + (high - low) * i as f64 / (count - ends).max(1) as f64)
    };
    let turns: Vec<f64> = match rotation.stops_deg() {
        Some([low, high]) if high - low < 360.0 => spread(low, high, TURNS, 1).collect(),
        Some([low, high]) => {
            let first = 0.0_f64.min(high - 360.0).max(low);
            spread(first, first + 360.0, TURNS, 0).collect()
        }
        None => spread(0.0, 360.0, TURNS, 0).collect(),
    };
    let low = tilt.min_deg.max(tilt.zero_deg - STEEPEST_DEG);
    let high = tilt.max_deg.min(tilt.zero_deg + STEEPEST_DEG);
    let tilts: Vec<f64> = spread(low, high, TILTS, 1).chain([tilt.zero_deg]).collect();
    let round = |v: f64| (v * 100.0).round() / 100.0;
    let mut all: Vec<[f64; 2]> = Vec::new();
    for a in tilts.into_iter().filter(|a| (tilt.min_deg..=tilt.max_deg).contains(a)) {
        for c in &turns {
            let words = [round(a), round(*c)];
            if !all.contains(&words) {
                all.push(words);
            }
        }
    }
    all
}

/// Everything that can be touched on one machine.
struct Reachable<'a> {
    clear: ClearWay,
    problem: &'a Problem<'a>,
    state: &'a [f64],
    spots: Vec<[f64; 2]>,
}

impl<'a> Reachable<'a> {
    fn of(profile: &Profile, problem: &'a Problem<'a>, state: &'a [f64]) -> Self {
        let clear = ClearWay::of(profile);
        let half = inside(profile, RIM_MM);
        let spots = (0..16).map(|i| (std::f64::consts::FRAC_PI_8 * f64::from(i)).sin_cos());
        let spots = spots.map(|(s, c)| [half[0] * c, half[1] * s]).chain([[0.0, 0.0]]).collect();
        Self { clear, problem, state, spots }
    }

    /// All candidates that the head can make.
    fn all(&self, words: &[[f64; 2]]) -> Vec<ChainCandidate> {
        let top = self.clear.ball_top();
        let standing = words.iter().filter(|words| self.clear.stands(**words));
        let of_pose = |&words_deg: &[f64; 2]| {
            let tips = self.tips(words_deg);
            tips.into_iter().map(move |(of, tip)| ChainCandidate { of, words_deg, tip })
        };
        let fits = |one: &ChainCandidate| self.clear.touchable(one.words_deg, &one.tip, top.max(one.tip.z + 1.0));
        standing.flat_map(of_pose).filter(fits).collect()
    }

    /// Where the tip touches the table's spots, the marks and the balls in one pose.
    fn tips(&self, words_deg: [f64; 2]) -> Vec<(Of, Vec3)> {
        let chain = self.problem.chain(self.state);
        let [tilt, rotation] = words_deg.map(Angle::from_deg);
        let placed = chain.at(tilt, rotation);
        let tip = &self.problem.touches.tip;
        let normal = placed.direction(&Vec3::z());
        let gap = tip.paper_mm
            + match tip.shape {
                TipShape::Flat => tip.radius_mm * normal.x.hypot(normal.y),
                TipShape::Ball => tip.radius_mm * (1.0 - normal.z),
            };
        let over = |x: f64, y: f64, height: f64| placed.point(&Vec3::new(x, y, height)) + Vec3::z() * (gap / normal.z);
        let mut all: Vec<(Of, Vec3)> = self.spots.iter().map(|&[x, y]| (Of::Table, over(x, y, 0.0))).collect();
        let mut rest = self.state[UNKNOWNS..].iter();
        let mut next = || rest.next().copied().unwrap_or_default();
        for (index, feature) in self.problem.touches.features.iter().enumerate() {
            match feature.shape {
                TouchShape::Mark { height, known } => {
                    let [x, y] = known.unwrap_or_else(|| [next(), next()]);
                    all.push((Of::Feature(index), over(x, y, height)));
                }
                TouchShape::Ball { radius } => {
                    let centre = placed.point(&Vec3::new(next(), next(), next()));
                    all.extend(around(tip, radius).map(|arm| (Of::Feature(index), centre + arm)));
                }
            }
        }
        all
    }
}

/// From a ball's middle to the tip that touches it: at its top, and half way down on four sides.
fn around(tip: &Tip, radius: f64) -> impl Iterator<Item = Vec3> {
    let side = std::f64::consts::FRAC_1_SQRT_2;
    let outward = [(0.0, 0.0), (side, 0.0), (-side, 0.0), (0.0, side), (0.0, -side)];
    let (shape, own, paper) = (tip.shape, tip.radius_mm, tip.paper_mm);
    outward.into_iter().map(move |(x, y)| {
        let out = Vec3::new(x, y, (1.0 - x * x - y * y).sqrt());
        match shape {
            TipShape::Ball => out * (radius + own + paper) - Vec3::z() * own,
            TipShape::Flat => out * (radius + paper) + Vec3::new(x, y, 0.0) / side * own,
        }
    })
}

/// The touch that a candidate would be.
fn made(one: &ChainCandidate) -> Touch {
    Touch { number: 0, line: 0, of: one.of, words_deg: one.words_deg, at: one.tip }
}

/// What an error of each unknown weighs: the machine's by what is wanted of it, places nothing.
fn weights(problem: &Problem<'_>, unit: &[f64], wanted: impl Fn(Unknown) -> f64) -> Vec<f64> {
    let of = |i: usize| Unknown::ALL.get(i).map_or(0.0, |&unknown| (wanted(unknown) * unit[i]).powi(-2));
    (0..problem.length).map(of).collect()
}

/// What to touch next, for the unknowns that are told least: with what is there, else with a mark at the place that comes back.
pub(super) fn next(
    profile: &Profile,
    problem: &Problem<'_>,
    information: &Information,
    state: &[f64],
    free: &[usize],
) -> (Vec<ChainCandidate>, Option<[f64; 2]>) {
    let unit = units(problem.length, lever(profile));
    let weight = weights(problem, &unit, |unknown| if unknown.is_angle() { WORST_DEG.to_radians() } else { WORST_MM });
    let all = Reachable::of(profile, problem, state).all(&all_words(profile));
    let (chosen, grown) = greedy(problem, information.clone(), state, &all, &weight, TOLD, |_| false);
    if grown.weighed(&weight) < 0.3 * information.weighed(&weight) {
        return (chosen, None);
    }
    // Nothing on the table helps: a mark of its own does.
    let place = [inside(profile, MARK_MM)[0].round(), 0.0];
    let mut touches = problem.touches.clone();
    touches.features.push(Feature { name: "new".to_owned(), shape: TouchShape::Mark { height: 0.0, known: None } });
    let with = Problem::new(problem.nominal, &touches);
    let state = [state, &place[..]].concat();
    let unit = units(with.length, lever(profile));
    let free: Vec<usize> = free.iter().copied().chain(problem.length..with.length).collect();
    let mut grown = Information::before(unit.clone(), &free, touches.tip.repeats_to_mm);
    touches.touches.iter().for_each(|touch| grown.add(&with.rows(touch, &state)));
    let weight = weights(&with, &unit, |unknown| if unknown.is_angle() { WORST_DEG.to_radians() } else { WORST_MM });
    let of_mark = Of::Feature(touches.features.len() - 1);
    let mut all = Reachable::of(profile, &with, &state).all(&all_words(profile));
    all.retain(|one| one.of == of_mark);
    // One touch of it alone tells nothing: the first, at level, is given.
    let first = all.iter().min_by(|a, b| a.words_deg[0].abs().total_cmp(&b.words_deg[0].abs())).cloned();
    first.iter().for_each(|one| grown.add(&with.rows(&made(one), &state)));
    let (chosen, _) = greedy(&with, grown, &state, &all, &weight, TOLD - 1, |_| false);
    (first.into_iter().chain(chosen).collect(), Some(place))
}

fn greedy(
    problem: &Problem<'_>,
    mut information: Information,
    state: &[f64],
    all: &[ChainCandidate],
    weight: &[f64],
    most: usize,
    enough: impl Fn(&Information) -> bool,
) -> (Vec<ChainCandidate>, Information) {
    let rows: Vec<_> = all.iter().map(|one| problem.rows(&made(one), state)).collect();
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < most && !enough(&information) {
        let left = (0..all.len()).filter(|i| !chosen.contains(i));
        let gains = left.map(|i| (information.gain(&rows[i], weight), i));
        // The first of equals, so that the choice is the same everywhere.
        let Some((_, best)) = gains.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))) else { break };
        information.add(&rows[best]);
        chosen.push(best);
    }
    (chosen.into_iter().map(|i| all[i].clone()).collect(), information)
}

/// At most `most` touches with `tip` that leave no length a larger standard error than `aim_mm`, and no angle more than that at what stands as high at the table's
/// rim as that is from its middle; axes that
/// are not where the profile has them are looked for unless `square`. The marks are drawn on the table, roughly where the result says.
///
/// Fewer, and `enough` false, where no further touch helps or there would be too many.
pub fn choose(profile: &Profile, tip: &Tip, aim_mm: f64, most: usize, square: bool) -> Choice {
    let nominal = profile.kinematics();
    let lever = lever(profile);
    let [x, y] = inside(profile, MARK_MM);
    let marks = [("mark-x", [x, 0.0]), ("mark-y", [0.0, y])];
    let marks = marks.map(|(name, at)| (name.to_owned(), at.map(|v| v.round()))).to_vec();
    let shape = TouchShape::Mark { height: 0.0, known: None };
    let features = marks.iter().map(|(name, _)| Feature { name: name.clone(), shape }).collect();
    let touches = Touches { tip: tip.clone(), features, touches: Vec::new(), empty: Vec::new() };
    let problem = Problem::new(&nominal, &touches);
    let state: Vec<f64> = [0.0; UNKNOWNS].into_iter().chain(marks.iter().flat_map(|(_, at)| *at)).collect();
    let unknown = |i: usize| Unknown::ALL.get(i).copied();
    let held = |u: Unknown| u == Unknown::RotationZero || (square && u.bends());
    let free: Vec<usize> = (0..problem.length).filter(|&i| !unknown(i).is_some_and(held)).collect();
    let unit = units(problem.length, lever);
    let at_rim = sag_at_rim(profile);
    let wanted = |u: Unknown| match u {
        Unknown::Sag => aim_mm / at_rim,
        _ if u.is_angle() => aim_mm / lever,
        _ => aim_mm,
    };
    let weight = weights(&problem, &unit, wanted);
    let machine: Vec<usize> = free.iter().copied().filter(|&i| i < UNKNOWNS).collect();
    let fine = |information: &Information| machine.iter().all(|&i| information.error(i) <= wanted(Unknown::ALL[i]));
    let all = Reachable::of(profile, &problem, &state).all(&all_words(profile));
    let before = Information::before(unit, &free, tip.repeats_to_mm);
    let (mut poses, grown) = greedy(&problem, before, &state, &all, &weight, most, fine);
    let marks = used(&mut poses, marks);
    in_order(&mut poses, nominal.tilt.zero.deg());
    let letters = [&nominal.tilt, &nominal.rotation].map(|axis| char::from(axis.letter));
    let error = |&i: &usize| {
        let (u, error) = (Unknown::ALL[i], grown.error(i));
        (u.name(nominal.about, letters), if u.is_angle() { error.to_degrees() } else { error }, u.is_angle())
    };
    Choice { poses, marks, errors: machine.iter().map(error).collect(), enough: fine(&grown) }
}

/// Those of `marks` that are touched; the touches name them by their new places.
fn used(poses: &mut [ChainCandidate], marks: Vec<(String, [f64; 2])>) -> Vec<(String, [f64; 2])> {
    let touched = |i: usize, poses: &[ChainCandidate]| poses.iter().any(|one| one.of == Of::Feature(i));
    let kept: Vec<usize> = (0..marks.len()).filter(|&i| touched(i, poses)).collect();
    for one in poses.iter_mut() {
        if let Of::Feature(i) = one.of {
            one.of = Of::Feature(kept.iter().position(|k| *k == i).unwrap_or(i));
        }
    }
    kept.into_iter().map(|i| marks[i].clone()).collect()
}

/// From level outward, tilt by tilt, the rotation going to and fro.
fn in_order(poses: &mut [ChainCandidate], level: f64) {
    let from_level = |one: &ChainCandidate| ((one.words_deg[0] - level).abs(), one.words_deg[0]);
    poses.sort_by(|a, b| {
        let ((a0, a1), (b0, b1)) = (from_level(a), from_level(b));
        a0.total_cmp(&b0).then(a1.total_cmp(&b1)).then(a.words_deg[1].total_cmp(&b.words_deg[1]))
    });
    let mut back = false;
    for group in poses.chunk_by_mut(|a, b| a.words_deg[0] == b.words_deg[0]) {
        if back {
            group.reverse();
        }
        back = !back;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{resolve, shipped};

    /// The rotation's words, ascending.
    fn turns(stops: &str) -> Vec<f64> {
        let (file, text) = shipped("generic-ac").unwrap();
        let own = format!("{text}\n[kinematics.rotation]\n{stops}\n");
        let (profile, _) = resolve(file, &own).unwrap();
        let mut all: Vec<f64> = all_words(&profile).into_iter().map(|words| words[1]).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }

    #[test]
    fn a_turn_is_gone_round_once_within_the_stops() {
        let endless = turns("");
        assert_eq!(endless.len(), TURNS);
        assert_eq!(turns("max_turns = 1.5"), endless);
        assert_eq!(turns("min_deg = -360.0\nmax_deg = 360.0"), endless);
        for (low, high) in [(-180.0, 180.0), (-10.1, 349.9), (100.0, 500.0), (-800.0, -100.0), (-90.0, 90.0)] {
            let found = turns(&format!("min_deg = {low:?}\nmax_deg = {high:?}"));
            assert_eq!(found.len(), TURNS, "{low}..{high}");
            assert!(found[0] >= low && found[TURNS - 1] <= high, "{low}..{high}: {found:?}");
            assert!(found[TURNS - 1] - found[0] < 360.0, "{low}..{high}: {found:?}");
        }
    }
}
