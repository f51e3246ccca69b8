//! Parts that lie beside each other and never touch, as hinges, bearings and chains do that are printed in place: how near their lines come.
//!
//! Lines of two prints of one setup are held against each other where they lie at one height: from the middle of one to the middle of the
//! other, seen from above, less half of each one's width. Two stretches that do not cross are nearest at an end of one, so the figure is exact.

use super::evidence::{Checked, Evidence, Figures};
use super::prints::{Level, PrintedPart};
use super::report::{Findings, JointRoom};
use crate::geom::Bounds;
use crate::section::{PlanePoint, Segment, to_segment};

/// Parts that are no nearer than this, mm, are simply beside each other.
const NEAR_MM: f64 = 1.0;
/// Layers lie at one height where they share so much of the lower one.
const SHARED: f64 = 0.1;

/// By pair of parts the least room between their lines, for those that come nearer than [`NEAR_MM`]; the narrowest first.
pub(super) fn check(evidence: &Evidence<'_>) -> Checked {
    Checked { findings: Findings::default(), figures: Figures::Joints(rooms(evidence)) }
}

fn rooms(&Evidence { printed, job, .. }: &Evidence<'_>) -> Vec<JointRoom> {
    let touch = |a: usize, b: usize| {
        let two = [a.min(b), a.max(b)];
        job.workpiece.model.interfaces.iter().any(|one| [one.a, one.b] == two)
    };
    let table = job.profile.kinematics();
    let boxed = |print| {
        let PrintedPart { planned, .. }: &PrintedPart<'_> = print;
        job.workpiece.parts[planned.part].moved(&table.forward(planned.pose)).bounds().inflated(NEAR_MM / 2.0)
    };
    let all: Vec<(&PrintedPart<'_>, Bounds)> = printed.iter().flatten().map(|print| (print, boxed(print))).collect();
    let mut found: Vec<JointRoom> = Vec::new();
    for (place, (one, bounds)) in all.iter().enumerate() {
        for (other, other_bounds) in &all[place + 1..] {
            let (a, b) = (one.planned, other.planned);
            let beside = a.part != b.part && a.setup == b.setup && bounds.meets(other_bounds);
            if beside && !touch(a.part, b.part) {
                found.extend(room(one, bounds, other, other_bounds));
            }
        }
    }
    found.sort_by(|a, b| a.gap_mm.total_cmp(&b.gap_mm).then(a.parts.cmp(&b.parts)));
    found
}

/// A line: its middle seen from above, half its width, where it stands in the file.
struct Stretch {
    axis: Segment,
    half: f64,
    line: u32,
    /// Its least and greatest X.
    reach: [f64; 2],
}

/// What of a level lies within reach of a box, by its least X.
fn stretches(print: &PrintedPart<'_>, level: &Level, within: &Bounds) -> Vec<Stretch> {
    let of = |&index: &u32| {
        let m = print.bead(index);
        let [from, to] = m.ends()?;
        let half = print.laid_width(&m, level) / 2.0;
        let axis = [[from.x, from.y], [to.x, to.y]];
        let outside = |k: usize| {
            let (low, high) = (axis[0][k].min(axis[1][k]), axis[0][k].max(axis[1][k]));
            low > within.max[k] + NEAR_MM + half || high < within.min[k] - NEAR_MM - half
        };
        let reach = [from.x.min(to.x), from.x.max(to.x)];
        (!outside(0) && !outside(1)).then_some(Stretch { axis, half, line: m.line, reach })
    };
    let mut all: Vec<Stretch> = level.beads.iter().filter_map(of).collect();
    all.sort_by(|a, b| a.reach[0].total_cmp(&b.reach[0]));
    all
}

/// The least room between two prints of one setup, each with its part's box.
fn room(one: &PrintedPart<'_>, of_one: &Bounds, other: &PrintedPart<'_>, of_other: &Bounds) -> Option<JointRoom> {
    let mut best: Option<JointRoom> = None;
    let mut first = 0;
    for level in &one.levels {
        let span = [level.z - level.height(), level.z];
        let passed = |lower: &&Level| lower.z <= span[0];
        first += other.levels[first..].iter().take_while(passed).count();
        let beside = other.levels[first..].iter().take_while(|upper| upper.z - upper.height() < span[1]);
        let beside = beside.filter(|upper| {
            let shared = span[1].min(upper.z) - span[0].max(upper.z - upper.height());
            shared > SHARED * level.height().min(upper.height())
        });
        let mut own: Option<Vec<Stretch>> = None;
        for upper in beside {
            let own = own.get_or_insert_with(|| stretches(one, level, of_other));
            let theirs = stretches(other, upper, of_one);
            let below_mm = best.as_ref().map_or(NEAR_MM, |best| best.gap_mm);
            if let Some((gap_mm, line)) = nearest(own, &theirs, below_mm) {
                best = Some(JointRoom { parts: [one.planned.part, other.planned.part], gap_mm, line, z_mm: level.z });
            }
        }
    }
    best
}

/// The least room between stretches of two, mm, and the later line of the two; `None` where it is `below_mm` or more. Both are by least X.
fn nearest(own: &[Stretch], theirs: &[Stretch], below_mm: f64) -> Option<(f64, u32)> {
    let longest = theirs.iter().map(|stretch| stretch.reach[1] - stretch.reach[0]).fold(0.0, f64::max);
    let thickest = theirs.iter().map(|stretch| stretch.half).fold(0.0, f64::max);
    let (mut best, mut least) = (None, below_mm);
    for stretch in own {
        let far = least.max(0.0) + stretch.half + thickest;
        let [low, high] = [stretch.reach[0] - far - longest, stretch.reach[1] + far];
        let from = theirs.partition_point(|other| other.reach[0] < low);
        for other in theirs[from..].iter().take_while(|other| other.reach[0] <= high) {
            let gap_mm = apart(stretch.axis, other.axis) - stretch.half - other.half;
            if gap_mm < least {
                (best, least) = (Some((gap_mm, stretch.line.max(other.line))), gap_mm);
            }
        }
    }
    best
}

/// How far two stretches are from each other.
fn apart(a: Segment, b: Segment) -> f64 {
    let side = |[p, q]: Segment, r: PlanePoint| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let parted = |by: Segment, of: Segment| side(by, of[0]) * side(by, of[1]) < 0.0;
    if parted(a, b) && parted(b, a) {
        return 0.0;
    }
    let ends = [(a[0], b), (a[1], b), (b[0], a), (b[1], a)];
    ends.into_iter().map(|(p, of)| to_segment(p, of)).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    /// The window that is searched leaves out nothing: thin and thick lines, short and long ones, against every pair.
    #[test]
    fn the_nearest_two_are_those_of_all_pairs() {
        let mut random = SplitMix64::seeded(11);
        let mut between = move |low: f64, high: f64| low + (high - low) * random.unit();
        let mut near = 0;
        for round in 0..400 {
            let mut some = |count: u32, left: f64| {
                let mut all: Vec<Stretch> = (0..count)
                    .map(|line| {
                        let from = [left + between(0.0, 10.0), between(0.0, 20.0)];
                        let to = [from[0] + between(-8.0, 8.0), from[1] + between(-8.0, 8.0)];
                        let reach = [from[0].min(to[0]), from[0].max(to[0])];
                        Stretch { axis: [from, to], half: between(0.1, 1.5), line, reach }
                    })
                    .collect();
                all.sort_by(|a, b| a.reach[0].total_cmp(&b.reach[0]));
                all
            };
            let (own, theirs) = (some(12, 0.0), some(9, f64::from(round % 30)));
            let pairs = own.iter().flat_map(|a| theirs.iter().map(move |b| apart(a.axis, b.axis) - a.half - b.half));
            let wanted = Some(pairs.fold(f64::INFINITY, f64::min)).filter(|least| *least < NEAR_MM);
            assert_eq!(nearest(&own, &theirs, NEAR_MM).map(|(gap_mm, _)| gap_mm), wanted);
            near += usize::from(wanted.is_some_and(|least| least > -0.5));
        }
        assert!(near > 20, "{near} cases say something");
    }

    #[test]
    fn stretches_are_as_far_apart_as_their_nearest_points() {
        let a: Segment = [[0.0, 0.0], [10.0, 0.0]];
        for (b, wanted) in [
            ([[0.0, 2.0], [10.0, 2.0]], 2.0),
            ([[5.0, -1.0], [5.0, 1.0]], 0.0),
            ([[12.0, 0.0], [20.0, 5.0]], 2.0),
            ([[13.0, 4.0], [13.0, 9.0]], 5.0),
            ([[5.0, 1.0], [5.0, 9.0]], 1.0),
            ([[3.0, 0.5], [3.0, 0.5]], 0.5),
        ] {
            assert!((apart(a, b) - wanted).abs() < 1e-12 && (apart(b, a) - wanted).abs() < 1e-12, "{b:?}");
        }
    }
}
