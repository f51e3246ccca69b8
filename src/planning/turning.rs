//! Whether every turn of a plan is clear: the first one from an unknown angle, each from setup to setup, the last one back to level.
//!
//! The rewriter turns at the height of the ball that the table and everything printed sweep about the pivot, or at the end of Z
//! where that is lower. Above the ball nothing can meet. Below it the turn is stepped through by what is proved (conservative
//! advancement: B. Mirtich, *Timewarp rigid body simulation*, 2000): with a gap `g`, nothing that moves less than `g` can meet.
//! Which turns there are depends on the sequence, so a sequence is looked at after it was found, and what strikes becomes one more
//! "must not be there before".
//!
//! Machine frame, mm.

use super::candidates::Setups;
use super::collision::Head;
use super::owed::{Owed, Share};
use super::plan::{Print, TimeSlot};
use super::solid::Solid;
use super::swivel::SwivelRoute;
use crate::geom::{Bounds, Machine, Rigid, Vec3};
use crate::motion::{Pose, TableKinematics};
use crate::profile::Profile;

/// What verification proves a turn by is taken as this much nearer to the head than the parts are, mm: it gathers lines into
/// spheres about cubes of 2 mm, half a millimetre apart.
const GATHERED_MM: f64 = 4.3;
/// Room that a turn keeps beyond that, mm: verification asks for 0.1 at every step of half the gap.
const ROOM_MM: f64 = 0.15;
/// Where less than this is left over the room the turn counts as struck, mm: it bounds the number of steps.
const LEAST_STEP_MM: f64 = 0.05;

/// What helps where a turn is not clear.
const REMEDY: &str = "raise [limits] z_mm if the machine has more travel, set [transition] park_mm beside the table, or move the model (--origin)";

/// The same where the head turns.
const HEADS_REMEDY: &str =
    "move the model (--origin, --turn), or correct the stop in [limits] if the machine has more travel";

/// What helps on a machine.
pub(super) fn remedy(profile: &Profile) -> &'static str {
    if profile.kinematics().head.is_some() { HEADS_REMEDY } else { REMEDY }
}

/// A turn that is not clear.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Struck {
    /// The parts of the setup that it leads to; empty for the last turn, back to level.
    pub(super) to: Vec<usize>,
    /// The part that is struck; `None` for the table.
    pub(super) part: Option<usize>,
    /// The pose that it leads to.
    pub(super) pose: Pose,
    /// In words.
    pub(super) text: String,
}

/// The turns of one machine with one model on it.
pub(super) struct Turns<'a> {
    profile: &'a Profile,
    table: &'a TableKinematics,
    head: &'a Head,
    /// Table frame, as all that stands.
    parts: &'a [Solid],
    /// By part, how far it reaches from the table's centre.
    reaches: Vec<f64>,
    /// The part that each holds, its shape and its reach.
    supports: Vec<(usize, &'a Solid, f64)>,
    slab: &'a Solid,
    slab_reach: f64,
    /// The frame's pieces.
    frame: Vec<(String, Solid)>,
}

/// What stands on the table: a part, or what holds one up.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stands {
    Part(usize),
    SupportsOf(usize),
}

impl Stands {
    fn named(self) -> String {
        match self {
            Self::Part(part) => format!("part {part}"),
            Self::SupportsOf(part) => format!("the supports of part {part}"),
        }
    }

    fn part(self) -> Option<usize> {
        match self {
            Self::Part(part) => Some(part),
            Self::SupportsOf(_) => None,
        }
    }
}

/// Where the head is and what stands while it goes from setup to setup.
struct Standing<'p> {
    pose: Option<Pose>,
    /// Where the tip is in X and Y; `None` before the first print.
    tips: Option<Bounds>,
    printed: &'p [usize],
    height: f64,
}

impl<'a> Turns<'a> {
    pub(super) fn of(setups: &'a Setups<'a>) -> Self {
        Self::with_supports(setups.profile, &setups.table, &setups.head, &setups.solids, &[], &setups.slab)
    }

    /// Those of parts, the supports of some of them, by part, and the table's slab.
    pub(super) fn with_supports(
        profile: &'a Profile,
        table: &'a TableKinematics,
        head: &'a Head,
        parts: &'a [Solid],
        supports: &'a [(usize, Solid)],
        slab: &'a Solid,
    ) -> Self {
        let reach = |solid: &Solid| solid.points().iter().map(|p| p.norm()).fold(0.0, f64::max);
        let frame = profile.fixed_bodies().into_iter().map(|b| (b.name, Solid::hull(b.points))).collect();
        let reaches = parts.iter().map(reach).collect();
        let supports = supports.iter().map(|(part, solid)| (*part, solid, reach(solid))).collect();
        Self { profile, table, head, parts, reaches, supports, slab, slab_reach: reach(slab), frame }
    }

    /// What stands while `printed` is there.
    fn standing<'s>(&'s self, printed: &'s [usize]) -> impl Iterator<Item = (Stands, &'a Solid)> + 's {
        let parts = printed.iter().map(|&part| (Stands::Part(part), &self.parts[part]));
        let held = self.supports.iter().filter(|(part, ..)| printed.contains(part));
        parts.chain(held.map(|(part, solid, _)| (Stands::SupportsOf(*part), *solid)))
    }

    /// The first turn of the plan that is not clear.
    pub(super) fn struck(&self, slots: &[TimeSlot]) -> Option<Struck> {
        if let Some(route) = SwivelRoute::of(self.profile) {
            return self.stopped(&route, slots);
        }
        let transition = &self.profile.transition;
        let mut printed: Vec<usize> = Vec::new();
        let (mut pose, mut tips) = (None, None);
        for setup in slots.iter().flat_map(TimeSlot::setups) {
            let to = setup[0].pose(self.table);
            let parts: Vec<usize> = setup.iter().map(|print| print.part).collect();
            let standing = Standing { pose, tips, printed: &printed, height: self.height(&printed) };
            let struck = self.turn(&standing, to).or_else(|| self.across(&standing, &setup, to));
            if let Some((part, text)) = struck {
                return Some(Struck { to: parts, part, pose: to, text });
            }
            tips = Some(match transition.park_mm {
                Some([x, y]) => Bounds::of([Vec3::new(x, y, 0.0)]),
                None => self.over(&setup, to),
            });
            (pose, printed) = (Some(to), [printed, parts].concat());
        }
        let from = pose?;
        let to = Pose { tilt: Pose::LEVEL.tilt, ..from };
        // Nobody parks for the last turn.
        let tips = slots.last().and_then(|slot| slot.setups().pop()).map(|setup| self.over(&setup, from));
        let standing = Standing { pose, tips, printed: &printed, height: self.height(&printed) };
        let (part, text) = self.turn(&standing, to)?;
        Some(Struck { to: Vec::new(), part, pose: to, text })
    }

    /// The first print that a head that turns cannot get to, or away from.
    fn stopped(&self, route: &SwivelRoute<'_>, slots: &[TimeSlot]) -> Option<Struck> {
        let mut printed: Vec<usize> = Vec::new();
        let mut from = None;
        for setup in slots.iter().flat_map(TimeSlot::setups) {
            let to = setup[0].pose(self.table);
            let parts: Vec<usize> = setup.iter().map(|print| print.part).collect();
            for &part in &parts {
                let others: Vec<usize> = printed.iter().chain(&parts).copied().filter(|&other| other != part).collect();
                let standing: Vec<&Solid> = self.standing(&others).map(|(_, solid)| solid).collect();
                if let Some(text) = route.stopped(self.table, &self.parts[part], &standing, from, to) {
                    return Some(Struck { to: parts, part: None, pose: to, text });
                }
                let way = route.way_out(self.table, &self.parts[part], &standing, to);
                if let Some((met, text)) = self.met_on(&way, &printed, to) {
                    return Some(Struck { to: parts, part: met, pose: to, text });
                }
            }
            (from, printed) = (Some(to), [printed, parts].concat());
        }
        let (from, standing) = (from?, self.standing(&printed).map(|(_, solid)| solid).collect::<Vec<_>>());
        let to = Pose { tilt: Pose::LEVEL.tilt, ..from };
        let text = route.ends(&standing, from, to)?;
        Some(Struck { to: Vec::new(), part: None, pose: to, text })
    }

    /// What stands in the way of a piece that does not turn with the tool, which goes along where the rest of the head has been looked at.
    fn met_on(&self, way: &[Vec3], printed: &[usize], at: Pose) -> Option<(Option<usize>, String)> {
        let (motion, head) = (self.table.forward(at), self.head.at(at));
        let staying = head.staying();
        self.standing(printed).find_map(|(stands, solid)| {
            let solid = solid.moved(&motion.rotation, &motion.translation);
            let text = || format!("on the way out along the tool, the head would meet {}", stands.named());
            (!staying.sweeps_clear(way, &solid, 0.0)).then(|| (stands.part(), text()))
        })
    }

    /// The height of the tip while the table turns, as the rewriter chooses it.
    fn height(&self, printed: &[usize]) -> f64 {
        let profile = self.profile;
        (self.ball(printed) + profile.transition.clearance_mm).min(profile.limits.z_mm[1])
    }

    /// The top of the ball that the table and what is printed sweep.
    fn ball(&self, printed: &[usize]) -> f64 {
        self.table.pivot.z + self.radius(printed)
    }

    fn radius(&self, printed: &[usize]) -> f64 {
        let parts = printed.iter().map(|&part| self.reaches[part]);
        let held = self.supports.iter().filter(|(part, ..)| printed.contains(part)).map(|(.., reach)| *reach);
        self.table.offset.norm() + parts.chain(held).fold(self.slab_reach, f64::max)
    }

    /// What is struck while the table turns, if anything is not proved clear.
    fn turn(&self, standing: &Standing<'_>, to: Pose) -> Option<(Option<usize>, String)> {
        let lines = self.profile.process.layer_height_mm + self.profile.process.line_width_mm;
        let above = self.head.lowest(standing.height) - self.ball(standing.printed) - lines > ROOM_MM;
        let pivot = Solid::hull(vec![self.table.pivot]);
        let radius = self.radius(standing.printed) + lines + ROOM_MM;
        let framed = self.frame.iter().all(|(_, piece)| apart(&pivot, piece, radius) >= radius);
        if above && framed {
            return None;
        }
        let (Some(from), Some(tips)) = (standing.pose, standing.tips) else {
            return Some((None, self.first_turn(standing, above)));
        };
        // One axis after the other: rotation, then tilt.
        let between = Pose { rotation: to.rotation, ..from };
        let legs = [(from, between), (between, to)];
        legs.into_iter().filter(|(from, to)| from != to).find_map(|(from, to)| self.leg(from, to, &tips, standing))
    }

    fn first_turn(&self, standing: &Standing<'_>, above: bool) -> String {
        let (top, ball) = (self.profile.limits.z_mm[1], self.ball(standing.printed));
        if above {
            return "the first turn starts from an unknown angle, and the table could hit the machine's frame; \
                    describe the table or the frame ([[fixed.body]]) exactly"
                .to_owned();
        }
        format!(
            "the first turn starts from an unknown angle: the table sweeps up to Z {ball:.1} mm, but the head rises only to Z {:.1} mm \
             ([limits] z_mm ends at {top}, [transition] clearance_mm is {})",
            self.head.lowest(standing.height),
            self.profile.transition.clearance_mm
        )
    }

    /// Steps through the turn of one axis.
    fn leg(&self, from: Pose, to: Pose, tips: &Bounds, standing: &Standing<'_>) -> Option<(Option<usize>, String)> {
        let (tilt, rotation) = (to.tilt - from.tilt, to.rotation - from.rotation);
        let length = self.radius(standing.printed) * (tilt.abs().rad() + rotation.abs().rad());
        let head = head_over(tips, standing.height);
        let mut done = 0.0;
        loop {
            let share = if length > 0.0 { (done / length).min(1.0) } else { 1.0 };
            let pose = Pose { tilt: from.tilt + tilt * share, rotation: from.rotation + rotation * share };
            let (gap, what, piece) = self.gap(pose, &head, standing.printed);
            let step = gap - ROOM_MM;
            if step < LEAST_STEP_MM {
                let part = what.and_then(Stands::part);
                let what = what.map_or("the table".to_owned(), Stands::named);
                let axis = if from.tilt == to.tilt { &self.table.rotation } else { &self.table.tilt };
                let text = format!(
                    "cannot prove that the {piece} clears {what} while {} turns at Z {:.1} mm",
                    char::from(axis.letter),
                    standing.height
                );
                return Some((part, text));
            }
            if share >= 1.0 {
                return None;
            }
            done += step;
        }
    }

    /// The least room of head and frame at a pose, with what stands there (nothing: the table) and the piece.
    fn gap(&self, pose: Pose, head: &Solid, printed: &[usize]) -> (f64, Option<Stands>, String) {
        let motion = self.table.forward(pose);
        let moved = |solid: &Solid| Solid::hull(solid.points().iter().map(|&p| motion.point(p.into()).at).collect());
        let still = Rigid::<Machine, Machine>::shift(Vec3::zeros());
        let mut least = (f64::INFINITY, None, String::new());
        let solids = self.standing(printed).map(|(stands, solid)| (Some(stands), solid, GATHERED_MM));
        for (stands, solid, gathered) in solids.chain([(None, self.slab, 0.0)]) {
            let solid = moved(solid);
            let near = self.head.clearance(&still, head, &solid, 0.0, FAR_MM);
            let frame = self.frame.iter().map(|(name, piece)| (apart(&solid, piece, FAR_MM), name));
            for (mm, piece) in std::iter::once((near.mm, &near.piece)).chain(frame) {
                if mm - gathered < least.0 {
                    least = (mm - gathered, stands, piece.clone());
                }
            }
        }
        least
    }

    /// What stands in the way from the last setup to this one, and from print to print within it, where Z ends below the top of
    /// what stands.
    fn across(&self, standing: &Standing<'_>, setup: &[&Print], at: Pose) -> Option<(Option<usize>, String)> {
        let motion = self.table.forward(at);
        let region = standing.tips.iter().fold(self.over(setup, at), |all, tips| all.union(tips));
        let way = head_over(&region, standing.height);
        let Owed { rest, .. } = Owed::to_others(self.profile, 0.0);
        let share = Share { lift: 0.0, ..rest };
        let owed = Owed { tip: share, rest: share };
        let still = Rigid::<Machine, Machine>::shift(Vec3::zeros());
        self.standing(standing.printed).find_map(|(stands, solid)| {
            let points = solid.points();
            let top = points.iter().map(|&p| motion.point(p.into()).at.z).fold(f64::NEG_INFINITY, f64::max);
            if top + rest.mm < self.head.lowest(standing.height) {
                return None;
            }
            let solid = Solid::hull(points.iter().map(|&p| motion.point(p.into()).at).collect());
            let offence = self.head.offence(&still, &way, &solid, &owed, 0.0)?;
            let text = format!(
                "while travelling at Z {:.1} mm ([limits] z_mm ends at {}), the {} would meet {}",
                standing.height,
                self.profile.limits.z_mm[1],
                offence.piece,
                stands.named()
            );
            Some((stands.part(), text))
        })
    }

    /// Where the tip goes in X and Y while the parts of `setup` are printed.
    fn over(&self, setup: &[&Print], at: Pose) -> Bounds {
        let motion = self.table.forward(at);
        setup
            .iter()
            .map(|print| self.parts[print.part].reached(&motion))
            .fold(Bounds::EMPTY, |all, one| all.union(&one))
    }
}

/// Farther than this no gap is told, mm: the longest step.
const FAR_MM: f64 = 50.0;

/// The tip anywhere over `tips`, at `height`.
fn head_over(tips: &Bounds, height: f64) -> Solid {
    let corner = |x: f64, y: f64| Vec3::new(x, y, height);
    let (min, max) = (tips.min, tips.max);
    Solid::hull(vec![corner(min.x, min.y), corner(max.x, min.y), corner(max.x, max.y), corner(min.x, max.y)])
}

fn apart(a: &Solid, b: &Solid, enough: f64) -> f64 {
    let still = Rigid::<Machine, Machine>::shift(Vec3::zeros());
    a.swept_clearance(&still, [true; 3], &[Vec3::zeros()], b, enough).distance()
}

impl Head {
    /// The head's lowest point with its tip at height `z`.
    fn lowest(&self, z: f64) -> f64 {
        self.lows().map(|(low, follows)| if follows { low + z } else { low }).fold(f64::INFINITY, f64::min)
    }
}
