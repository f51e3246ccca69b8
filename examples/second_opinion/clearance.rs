//! The head, the frame and the table: their least distance from what is printed, along each move. Makes the check of collisions.
//!
//! Distances are sampled: every 0.5 mm of a move, 0.5 degrees of a turn, against points every 0.5 mm of a line.

use super::bodies::Body;
use super::machine::Pose;
use super::maths::{V, add, bounds, dot, length, lerp, sub, turned};
use super::opinion::Check;
use super::reader::{Motion, NONE};
use super::scene::Scene;
use std::collections::BTreeMap;
use std::ops::Range;

/// How far a sampled clearance may be below the certified one, mm.
const CLEARANCE_SLACK_MM: f64 = 0.15;
/// Clearances from here on are not compared, mm.
const CLEAR_MM: f64 = 20.0;
/// How deep a head may seem to be in another print that it slides over, mm.
const TOUCH_MM: f64 = 0.05;
/// How deep the nozzle may dip into a print that shares a face with the current one, mm.
const GRAZE_MM: f64 = 0.3;

/// A point of a line's middle, table frame, with half of the line's height and width.
type Blob = (V, [f64; 2]);

/// Points in nested balls.
struct Tree {
    /// Inner balls have their halves behind them, at +1 and at `right`.
    balls: Vec<Ball>,
    points: Vec<Blob>,
    up: V,
    /// The most that a bead reaches from its middle.
    reach: f64,
}

struct Ball {
    centre: V,
    radius: f64,
    right: usize,
    points: Range<usize>,
}

impl Tree {
    /// Of points of lines that were printed along `up`.
    fn new(points: Vec<Blob>, up: V) -> Self {
        let reach = points.iter().map(|(_, half)| half[0].hypot(half[1])).fold(0.0, f64::max);
        let all = 0..points.len();
        let mut tree = Self { balls: Vec::new(), points, up, reach };
        tree.grow(all);
        tree
    }

    fn grow(&mut self, Range { start, end }: Range<usize>) {
        let points = &mut self.points[start..end];
        let [low, high] = bounds(points.iter().map(|(p, _)| *p));
        let centre = lerp(low, high, 0.5);
        let radius = points.iter().map(|(p, _)| length(sub(*p, centre))).fold(0.0, f64::max);
        let here = self.balls.len();
        self.balls.push(Ball { centre, radius, right: 0, points: start..end });
        if end - start > 6 {
            let size = sub(high, low);
            let wide = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or(0);
            let half = (end - start) / 2;
            points.select_nth_unstable_by(half, |a, b| a.0[wide].total_cmp(&b.0[wide]));
            self.grow(start..start + half);
            self.balls[here].right = self.balls.len();
            self.grow(start + half..end);
        }
    }

    /// The least distance of a body from the points' beads, or `limit`: by the plane between them that is across the way from one to
    /// the other, or level.
    fn clearance(&self, body: &Body, origin: V, pose: &Pose, limit: f64) -> f64 {
        let bound = |index: usize| {
            let ball = &self.balls[index];
            (body.distance(sub(pose.machine(ball.centre), origin)).0 - ball.radius - self.reach, index)
        };
        let (mut best, mut stack, up) = (limit, vec![bound(0)], turned(pose.turn, self.up));
        let bottom = body.corners.iter().map(|corner| dot(*corner, up)).fold(f64::INFINITY, f64::min);
        while let Some((far, index)) = stack.pop() {
            let ball = &self.balls[index];
            if far >= best {
                continue;
            }
            if ball.right > 0 {
                let (a, b) = (bound(index + 1), bound(ball.right));
                stack.extend(if a.0 < b.0 { [b, a] } else { [a, b] });
                continue;
            }
            for (p, half) in &self.points[ball.points.clone()] {
                let p = sub(pose.machine(*p), origin);
                let (far, way) = body.distance(p);
                let rise = dot(way, up).clamp(-1.0, 1.0);
                let apart = far - half[0] * rise.abs() - half[1] * (1.0 - rise * rise).sqrt();
                best = best.min(apart.max(bottom - dot(p, up) - half[0]));
            }
        }
        best
    }
}

/// What was printed, by print, as trees of growing size.
struct Printed {
    trees: BTreeMap<usize, Vec<Tree>>,
    pending: Vec<Blob>,
    rim: Tree,
}

impl Printed {
    fn close(&mut self, print: usize, up: V) {
        let mut points = std::mem::take(&mut self.pending);
        let trees = self.trees.entry(print).or_default();
        while trees.last().is_some_and(|last| last.points.len() < 2 * points.len()) {
            points.extend(trees.pop().into_iter().flat_map(|tree| tree.points));
        }
        if !points.is_empty() {
            trees.push(Tree::new(points, up));
        }
    }
}

/// A least distance as it is searched: nothing nearer than `best` can be met within `slack` of way.
struct Watch {
    best: f64,
    line: usize,
    slack: f64,
    least: f64,
}

impl Scene<'_> {
    /// Whether the nozzle prints on or beside another print as if it were its own.
    fn shares(&self, a: usize, b: usize) -> bool {
        let (Some(p), Some(q)) = (self.plan.print(a), self.plan.print(b)) else { return true };
        self.parts.is_none() || self.shared.contains_key(&[p.part.min(q.part), p.part.max(q.part)])
    }

    /// Least distance of the head from what it does not print on (`own`: from what it does), or `limit`.
    fn clearance(&self, printed: &Printed, motion: &Motion, pose: &Pose, tip: V, own: bool, limit: f64) -> f64 {
        let (mut best, between) = (limit, motion.print == NONE || motion.turns());
        let stands = !between && self.plan.print(motion.print).is_none_or(|print| print.up[2] > 0.9999);
        let frame = self.machine.fixed.iter().filter(|_| own && motion.turns());
        for body in self.machine.head.iter().filter(|body| !own || body.is_nozzle()).chain(frame) {
            let (origin, nozzle) = (body.origin(tip), body.is_nozzle());
            let (fixed, mut found) = (body.follows == [false; 3], best);
            for (print, trees) in &printed.trees {
                let carries = nozzle && !between && self.shares(motion.print, *print);
                if (fixed || carries == own) && (between || *print != motion.print) {
                    found = trees.iter().fold(found, |found, tree| tree.clearance(body, origin, pose, found));
                }
            }
            if fixed || !(own || nozzle && stands) {
                found = printed.rim.clearance(body, origin, pose, found);
                let corners = body.corners.iter().map(|c| self.machine.table.distance(pose.table(add(*c, origin))));
                found = corners.fold(found, f64::min);
            }
            best = match (fixed, found > 0.0) {
                (false, _) => found,
                (true, true) => best,
                (true, false) => -1.0,
            };
        }
        best
    }

    pub fn check_collisions(&self, certified: Option<f64>) -> Check {
        let mut check = Check::new("collisions");
        let least = certified.filter(|c| *c < CLEAR_MM).map_or(0.0, |c| (c - CLEARANCE_SLACK_MM).max(-TOUCH_MM));
        let rim = self.machine.table.rim().into_iter().map(|p| (p, [0.0; 2])).collect();
        let mut printed = Printed { trees: BTreeMap::new(), pending: Vec::new(), rim: Tree::new(rim, [0.0, 0.0, 1.0]) };
        let mut watches = [
            Watch { best: CLEAR_MM, line: 0, slack: 0.0, least },
            Watch { best: 0.0, line: 0, slack: 0.0, least: -GRAZE_MM },
        ];
        let mut beads = self.beads.iter().peekable();
        let mut before = (NONE, 0);
        for (index, motion) in self.motions.iter().enumerate() {
            let now = (motion.print, self.pose_of[index]);
            if now != before {
                let up = self.plan.print(before.0).map_or(self.poses[before.1].up(), |print| print.up);
                printed.close(before.0, up);
                watches.iter_mut().for_each(|watch| watch.slack = 0.0);
                before = now;
            }
            if !motion.is_known() {
                continue;
            }
            for (own, watch) in [false, true].into_iter().zip(&mut watches) {
                self.follow(&printed, motion, own, watch, &mut check);
            }
            if let Some(bead) = beads.next_if(|bead| bead.motion == index) {
                let (pose, half) = (self.pose(bead), [bead.height / 2.0, bead.width.min(1.5) / 2.0]);
                printed.pending.extend(bead.places(0.5).map(|p| (pose.table(p), half)));
            }
        }
        let [Watch { best, line, .. }, graze] = watches;
        let claim = certified.map_or("nothing".to_owned(), |c| format!("{c:.2} mm"));
        let joints = format!("nozzle {:.2} mm in joints (line {})", -graze.best, graze.line);
        check.figure = format!("clearance {best:.2} mm (line {line}), certified {claim}; {joints}");
        check
    }

    /// Looks along one move, as densely as the last distance allows.
    fn follow(&self, printed: &Printed, motion: &Motion, own: bool, watch: &mut Watch, check: &mut Check) {
        let turned = (0..2).map(|i| (motion.words(1.0)[i] - motion.words(0.0)[i]).abs()).fold(0.0, f64::max);
        let way = motion.way();
        let (whole, step) = (if turned > 0.0 { turned } else { way }, 0.5_f64);
        let mut done = if turned > 0.0 { 0.0 } else { watch.slack };
        let pose = self.machine.pose(motion.words(1.0));
        while done <= whole {
            let t = if whole > 0.0 { done / whole } else { 1.0 };
            let turned_pose = if turned > 0.0 { self.machine.pose(motion.words(t)) } else { pose };
            let found = self.clearance(printed, motion, &turned_pose, motion.tip(t), own, watch.best + 4.0);
            if found < watch.best {
                (watch.best, watch.line) = (found, motion.line);
            }
            if found < watch.least {
                let what = if own { "clearance of the nozzle from what it prints on" } else { "clearance" };
                check.line(motion.line, false, || format!("{what} {found:.2} mm"));
                break;
            }
            let free = if turned > 0.0 { 0.0 } else { (found - watch.best).max(0.0) };
            if done >= whole || done + free > whole {
                watch.slack = done + free - whole;
                return;
            }
            done = (done + free.max(step)).min(whole);
        }
        watch.slack = if turned > 0.0 { 0.0 } else { (done - whole).max(0.0) };
    }
}
