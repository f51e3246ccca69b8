//! Whether a body stands: its weight, tilted with the table, against what holds it there.
//!
//! ```text
//! moment that tips over an edge of the footprint's convex outline   W (z (g.n) - s (g.z))      s, z: from the edge to the centre of mass
//! and what pushes                                                   P times its distance from the edge
//! what holds                                                        adhesion x area x distance of the area's middle from the edge,
//!                                                                   and the weight where it turns back
//! ```
//!
//! `n` is the edge's outward normal, `g` the way down in the table's frame: on a level table `-z`. What the table only presses against
//! (supports, which leave air below the part) widens the outline and sticks to nothing. Beside tipping the whole must not slide or come off:
//! adhesion times area against the weight along the table and away from it.
//!
//! mm, grams, MPa (N/mm²), N mm. Source: statics; adhesion and the nozzle's push are those of PrusaSlicer's `SupportSpotsGenerator`.

use super::plan::{Plan, Print};
use super::workpiece::Workpiece;
use crate::geom::{Angle, Table, Vec3, convex_outline};
use crate::mesh::TriangleMesh;
use crate::motion::{Pose, TableKinematics};
use crate::orient::{Facets, Mass};
use crate::profile::Profile;
use crate::section::Sections;

/// What the nozzle pushes with, N, without any curl of the layer below.
pub const PUSH_N: f64 = 0.1;
/// Below this a body falls over.
pub const FALLS: f64 = 1.0;
/// Below this it is told.
pub const DOUBTFUL: f64 = 3.0;

/// PLA, g/mm³. PETG weighs a fortieth more, by much less than adhesion is uncertain.
const GRAMS_PER_MM3: f64 = 1.24e-3;
/// What a gram weighs, N.
pub const NEWTON: f64 = 9.80665e-3;
/// What is up as far as a table cares: the cosine of its tilt.
const LEVEL: f64 = 1.0 - 1e-9;

/// What weighs: grams, and grams times place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weight {
    grams: f64,
    moment: Vec3,
}

impl Weight {
    /// So much plastic, mm³, with its middle there, table frame.
    pub fn add(&mut self, volume_mm3: f64, middle: &Vec3) {
        let grams = volume_mm3 * GRAMS_PER_MM3;
        self.grams += grams;
        self.moment += middle * grams;
    }

    /// Both together.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        Self { grams: self.grams + other.grams, moment: self.moment + other.moment }
    }

    /// All of it, g.
    pub fn grams(&self) -> f64 {
        self.grams
    }

    /// Where its centre is; the origin of nothing.
    pub fn centre(&self) -> Vec3 {
        if self.grams > 0.0 { self.moment / self.grams } else { Vec3::zeros() }
    }
}

/// What a body stands on, in the plane of the table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Foot {
    /// All corners of what touches the table; of those the convex outline after [`Self::settle`].
    points: Vec<[f64; 2]>,
    area_mm2: f64,
    moment: [f64; 2],
}

impl Foot {
    /// A place that the body is pressed against.
    pub fn touches(&mut self, at: [f64; 2]) {
        self.points.push(at);
    }

    /// An area that sticks there, about its middle.
    pub fn sticks(&mut self, area_mm2: f64, middle: [f64; 2]) {
        self.area_mm2 += area_mm2;
        (0..2).for_each(|i| self.moment[i] += area_mm2 * middle[i]);
    }

    /// Leaves the corners of the convex outline.
    pub fn settle(&mut self) {
        self.points = convex_outline(std::mem::take(&mut self.points), 0.0);
    }

    /// Both together.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let points = self.points.iter().chain(&other.points).copied().collect();
        let moment = [0, 1].map(|i| self.moment[i] + other.moment[i]);
        let mut both = Self { points, area_mm2: self.area_mm2 + other.area_mm2, moment };
        both.settle();
        both
    }

    fn middle(&self) -> [f64; 2] {
        self.moment.map(|sum| if self.area_mm2 > 0.0 { sum / self.area_mm2 } else { 0.0 })
    }
}

/// How many times over a body is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// Against its weight alone; infinite where that only holds it.
    pub factor: f64,
    /// And with the nozzle pushing where it prints.
    pub pushed: f64,
}

/// How many times over a settled `foot` holds `weight`, where `down` is the way down (a unit vector, the table's frame), the nozzle may be at any
/// of `tips`, and a mm² of the foot holds `adhesion` MPa. `None` for what stands on a line or less.
pub fn held(weight: &Weight, foot: &Foot, down: &Vec3, tips: &[Vec3], adhesion: f64) -> Option<Held> {
    let outline = &foot.points;
    if outline.len() < 3 {
        return None;
    }
    let (newton, centre, middle) = (weight.grams() * NEWTON, weight.centre(), foot.middle());
    let sticks = adhesion * foot.area_mm2;
    let off = newton * down.x.hypot(down.y).hypot(down.z.max(0.0));
    let mut least = Held { factor: share(sticks, off), pushed: share(sticks, off) };
    for (i, a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        if length < 1e-9 {
            continue;
        }
        let out = [(b[1] - a[1]) / length, (a[0] - b[0]) / length];
        let beyond = |p: [f64; 2]| (p[0] - a[0]) * out[0] + (p[1] - a[1]) * out[1];
        let sideways = down.x * out[0] + down.y * out[1];
        let tips_over = newton * (centre.z * sideways - beyond([centre.x, centre.y]) * down.z);
        let holds = sticks * (-beyond(middle)).max(0.0) + (-tips_over).max(0.0);
        let arm = tips.iter().map(|tip| beyond([tip.x, tip.y]).hypot(tip.z)).fold(0.0, f64::max);
        let tips_over = tips_over.max(0.0);
        least.factor = least.factor.min(share(holds, tips_over));
        least.pushed = least.pushed.min(share(holds, tips_over + PUSH_N * arm));
    }
    Some(least)
}

fn share(holds: f64, pulls: f64) -> f64 {
    if pulls > 1e-9 { holds / pulls } else { f64::INFINITY }
}

/// The way down in the table's frame at a pose.
pub fn down(table: &TableKinematics, pose: Pose) -> Vec3 {
    -(table.forward(pose).rotation.transpose() * table.upward(pose))
}

/// How far a table with this way down is tilted; 0 for a level one.
pub fn tilt(down: &Vec3) -> Angle {
    Angle::from_rad(if -down.z >= LEVEL { 0.0 } else { (-down.z).clamp(-1.0, 1.0).acos() })
}

/// Where a plan's print stands worst.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstStanding {
    /// The part being printed there.
    pub part: usize,
    /// The slot.
    pub slot: usize,
    /// How far the table is tilted then.
    pub tilt: Angle,
    /// How many times over what stands there is held.
    pub held: Held,
}

impl WorstStanding {
    /// Whether it falls over because the table is tilted.
    pub fn falls(&self) -> bool {
        self.held.factor < FALLS && self.tilt.deg() > 0.0
    }
}

/// The worst of all states of a plan, at the beginning and at the end of each print; parts count as solid, so that sparse infill is on the safe side.
/// What stands on supports of which nothing is said in `feet` (by part, what its supports press on the table) is left to the finished file, whose
/// lines tell where these stand. `None` where nothing tips anything.
pub fn standing(
    plan: &Plan,
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    feet: &[(usize, Foot)],
) -> Option<WorstStanding> {
    let (body, kinematics) = (workpiece.model.standing_bodies(), profile.kinematics());
    let layer_mm = profile.process.layer_height_mm;
    let parts: Vec<(Weight, Foot, Vec<Vec3>)> =
        workpiece.parts.iter().map(|part| (weight(part), foot(part, layer_mm), corners(part))).collect();
    let mut stands: Vec<Option<(Weight, Foot)>> = vec![None; parts.len()];
    let own_feet = |part: usize| feet.iter().find(|(of, _)| *of == part).map(|(_, foot)| foot);
    // What is caught grows with what caught it and weighs on that; its own supports stand beside, and hold nothing of that.
    let is_captive = |print: &Print| workpiece.model.captive.contains(&print.part);
    let is_untold = |print: &Print| print.supports.is_some() && own_feet(print.part).is_none() && !is_captive(print);
    let untold = plan.prints().filter(|(_, print)| is_untold(print));
    let untold: Vec<usize> = untold.map(|(_, print)| body[print.part]).collect();
    let mut worst: Option<WorstStanding> = None;
    for slot in &plan.slots {
        let (caught, free): (Vec<&Print>, Vec<&Print>) = slot.prints.iter().partition(|print| is_captive(print));
        for print in free.into_iter().chain(caught) {
            let (part, of) = (print.part, body[print.part]);
            if untold.contains(&of) {
                continue;
            }
            let down = down(&kinematics, print.pose(&kinematics));
            let tilt = tilt(&down);
            let (weight, foot, tips) = &parts[part];
            let before = stands[of].take().unwrap_or_default();
            let mut after = (before.0.and(weight), before.1.and(foot));
            if let Some(feet) = own_feet(part).filter(|_| !is_captive(print)) {
                after.1 = after.1.and(feet);
            }
            for (weight, foot) in [&before, &after] {
                let Some(held) = held(weight, foot, &down, tips, profile.process.adhesion_mpa) else { continue };
                let one = WorstStanding { part, slot: slot.id, tilt, held };
                if worst.as_ref().is_none_or(|worst| worse(&one, worst)) {
                    worst = Some(one);
                }
            }
            stands[of] = Some(after);
        }
    }
    worst
}

/// What falls by its weight first, then by what pushes.
fn worse(one: &WorstStanding, than: &WorstStanding) -> bool {
    (!one.falls(), one.held.pushed) < (!than.falls(), than.held.pushed)
}

fn weight(part: &TriangleMesh<Table>) -> Weight {
    let mass = Mass::of(&Facets::of(part));
    let mut weight = Weight::default();
    weight.add(mass.volume_mm3.max(0.0), &mass.centre);
    weight
}

/// The first layer of what stands on the table.
fn foot(part: &TriangleMesh<Table>, layer_mm: f64) -> Foot {
    let mut foot = Foot::default();
    let sections = Sections::of(part);
    if sections.range()[0] > layer_mm / 2.0 {
        return foot;
    }
    let first = sections.at(layer_mm / 2.0);
    // By triangles between each side and the first corner.
    let Some(&[origin, _]) = first.segments().first() else { return foot };
    for &[a, b] in first.segments() {
        let [p, q] = [a, b].map(|v| [v[0] - origin[0], v[1] - origin[1]]);
        let area = (p[0] * q[1] - p[1] * q[0]) / 2.0;
        foot.sticks(area, [0, 1].map(|i| origin[i] + (p[i] + q[i]) / 3.0));
        foot.touches(a);
    }
    foot.settle();
    foot
}

fn corners(part: &TriangleMesh<Table>) -> Vec<Vec3> {
    part.bounds().corners().to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(side: f64, at: [f64; 2]) -> Foot {
        let mut foot = Foot::default();
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            foot.touches([at[0] + (x - 0.5) * side, at[1] + (y - 0.5) * side]);
        }
        foot.sticks(side * side, at);
        foot.settle();
        foot
    }

    fn of_grams(grams: f64, centre: [f64; 3]) -> Weight {
        let mut weight = Weight::default();
        weight.add(grams / GRAMS_PER_MM3, &Vec3::from(centre));
        weight
    }

    fn tilted(deg: f64) -> Vec3 {
        let (sin, cos) = deg.to_radians().sin_cos();
        Vec3::new(sin, 0.0, -cos)
    }

    /// A beam on a foot of 8 by 8 mm, tilted by 45 degrees, worked out by hand.
    #[test]
    fn a_beam_on_a_pin_by_hand() {
        let (grams, arm, high, adhesion) = (12.0, 60.0, 20.0, 0.02);
        let (weight, foot) = (of_grams(grams, [arm, 0.0, high]), square(8.0, [0.0, 0.0]));
        let newton = grams * 9.80665e-3;
        let half = 0.5f64.sqrt();
        // Over the edge at x = 4: it lies 56 mm beyond it, 20 mm above.
        let tips = newton * (high * half + (arm - 4.0) * half);
        let holds = adhesion * 64.0 * 4.0;
        let found = held(&weight, &foot, &tilted(45.0), &[Vec3::new(arm, 0.0, high)], adhesion).unwrap();
        assert!((found.factor - holds / tips).abs() < 1e-12, "{found:?} {}", holds / tips);
        assert!(found.factor < FALLS);
        let pushed = holds / (tips + PUSH_N * 56f64.hypot(20.0));
        assert!((found.pushed - pushed).abs() < 1e-12);
        // Leaning back, over its foot, it stands: what is 20 mm high goes 20 mm sideways.
        let back = held(&of_grams(grams, [0.0, 0.0, 2.0]), &foot, &tilted(45.0), &[], adhesion).unwrap();
        let slides = adhesion * 64.0 / (newton * half);
        assert!((back.factor - slides).abs() < 1e-9, "{back:?} {slides}");
    }

    /// A cube stands until its centre is over the edge, whatever it weighs, where nothing sticks.
    #[test]
    fn a_cube_that_sticks_to_nothing_tips_at_its_own_angle() {
        let foot = Foot { area_mm2: 0.0, moment: [0.0; 2], ..square(10.0, [3.0, -2.0]) };
        for (high, angle) in [(5.0, 45.0), (10.0, 26.565_051), (20.0, 14.036_243)] {
            let weight = of_grams(7.0, [3.0, -2.0, high]);
            let tips = |deg: f64| {
                let down = tilted(deg);
                let over = weight.centre().z * down.x + (-5.0) * -down.z;
                over > 0.0
            };
            assert!(!tips(angle - 1e-3) && tips(angle + 1e-3), "{high}");
            // Without adhesion it would slide long before, which is said, too.
            assert_eq!(held(&weight, &foot, &tilted(1.0), &[], 0.02).unwrap().factor, 0.0);
            let level = held(&weight, &foot, &tilted(0.0), &[], 0.02).unwrap();
            assert_eq!(level.factor, f64::INFINITY);
        }
    }

    /// What is over the edge of a level table tips by its weight, and the push by itself counts.
    #[test]
    fn on_a_level_table_only_what_leans_out_and_what_pushes_tips() {
        let foot = square(10.0, [0.0, 0.0]);
        let leans = held(&of_grams(10.0, [9.0, 0.0, 30.0]), &foot, &tilted(0.0), &[], 0.02).unwrap();
        let wanted = 0.02 * 100.0 * 5.0 / (10.0 * 9.80665e-3 * 4.0);
        assert!((leans.factor - wanted).abs() < 1e-12, "{leans:?} {wanted}");
        let pushed = held(&of_grams(0.0, [0.0; 3]), &foot, &tilted(0.0), &[Vec3::new(0.0, 0.0, 100.0)], 0.02).unwrap();
        let wanted = 0.02 * 100.0 * 5.0 / (PUSH_N * 5f64.hypot(100.0));
        assert!((pushed.pushed - wanted).abs() < 1e-12, "{pushed:?} {wanted}");
        // Supports widen what it may lean over, and hold nothing.
        let mut wide = Foot::default();
        [[20.0, -5.0], [20.0, 5.0]].into_iter().for_each(|p| wide.touches(p));
        let wider = held(&of_grams(10.0, [9.0, 0.0, 30.0]), &foot.and(&wide), &tilted(0.0), &[], 0.02).unwrap();
        assert_eq!(wider.factor, f64::INFINITY);
    }

    /// Turned about the table's normal, with everything on it, nothing changes.
    #[test]
    fn turning_everything_changes_nothing() {
        let spun = |p: [f64; 2], turn: f64| {
            let (sin, cos) = turn.sin_cos();
            [p[0] * cos - p[1] * sin, p[0] * sin + p[1] * cos]
        };
        let at = |turn: f64| {
            let mut foot = Foot::default();
            for p in [[0.0, 0.0], [30.0, 0.0], [20.0, 15.0], [2.0, 18.0]] {
                foot.touches(spun(p, turn));
            }
            foot.sticks(210.0, spun([13.0, 8.0], turn));
            foot.settle();
            let [x, y] = spun([25.0, 20.0], turn);
            let [gx, gy] = spun([0.4, 0.3], turn);
            let down = Vec3::new(gx, gy, -(0.75f64).sqrt());
            let [tx, ty] = spun([40.0, 1.0], turn);
            held(&of_grams(40.0, [x, y, 33.0]), &foot, &down, &[Vec3::new(tx, ty, 50.0)], 0.05).unwrap()
        };
        let first = at(0.0);
        assert!(first.factor.is_finite() && first.pushed < first.factor, "{first:?}");
        for i in 1..12 {
            let turned = at(f64::from(i) * 0.5);
            assert!((turned.factor - first.factor).abs() < 1e-9 && (turned.pushed - first.pushed).abs() < 1e-9);
        }
    }
}
