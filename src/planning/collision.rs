//! Whether the head can print a part at a pose past an earlier solid.
//!
//! The tip visits the part's volume. The question "is there a tip position for which a piece of the head meets the
//! obstacle" is asked of the whole volume at once, as one convex distance per piece: part (swept) + piece - obstacle.
//!
//! The head is taken to reach **upward without end**. That is nearly true of every machine (something holds the head
//! up), it is on the safe side, and it makes a test of the surfaces sufficient: whatever point of an obstacle lies inside
//! the head for a tip inside the part also does for a tip lower down, and so for one on the part's surface; and no bounded
//! obstacle can swallow the head.

use std::ops::Deref;
use std::sync::{Arc, Mutex, PoisonError};

use super::fans::Fans;
use super::owed::{Owed, carries_tip, contact_mm};
use super::solid::{Solid, Tool};
use crate::geom::convex::Separation;
use crate::geom::{Body, Hull, Machine, Rigid, Vec3};
use crate::motion::Pose;
use crate::profile::Profile;

/// The head's upward reach, mm; beyond any machine.
const UPWARD: f64 = 2000.0;

/// The head, ready for collision queries.
#[derive(Clone, Debug)]
pub struct Head {
    pieces: Vec<Piece>,
    /// The machine, where a piece looks otherwise at each pose.
    posed: Option<Arc<Posed>>,
}

/// A machine, and its head at the poses that were asked for.
#[derive(Debug)]
struct Posed {
    profile: Profile,
    seen: Mutex<Vec<(Pose, Arc<Head>)>>,
}

/// A head at a pose.
pub enum HeadSeen<'a> {
    /// As at every other.
    Same(&'a Head),
    /// Another one.
    Own(Arc<Head>),
}

impl Deref for HeadSeen<'_> {
    type Target = Head;

    fn deref(&self) -> &Head {
        match self {
            Self::Same(head) => head,
            Self::Own(head) => head,
        }
    }
}

impl Posed {
    /// `head` with what does not turn with the tool as it is seen at `pose`.
    fn at(&self, head: &Head, pose: Pose) -> Arc<Head> {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, known)) = seen.iter().find(|(at, _)| *at == pose) {
            return known.clone();
        }
        let bodies = self.profile.head_bodies_at(pose).into_iter();
        let pieces = head.pieces.iter().zip(bodies).map(|(piece, body)| match piece.stays {
            true => Piece {
                fans: Arc::new(Fans::of(&Hull::of(&body.points).pruned().points, 0.0)),
                follows: body.follows,
                ..piece.clone()
            },
            false => piece.clone(),
        });
        let there = Arc::new(Head { pieces: pieces.collect(), posed: None });
        seen.push((pose, there.clone()));
        there
    }
}

#[derive(Clone, Debug)]
struct Piece {
    name: String,
    fans: Arc<Fans>,
    follows: [bool; 3],
    /// Whether it carries the tip.
    tip: bool,
    /// Whether it keeps its attitude while the tool turns.
    stays: bool,
}

/// The head meets something, or how far it stays away.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Clearance {
    /// 0 where it meets.
    pub(super) mm: f64,
    /// The piece of the head that is nearest.
    pub(super) piece: String,
}

impl Head {
    /// The head of `profile`.
    pub fn of(profile: &Profile) -> Self {
        let bodies = profile.head_bodies();
        let posed = || Posed { profile: profile.clone(), seen: Mutex::default() };
        let posed = bodies.iter().any(|body| body.stays).then(|| Arc::new(posed()));
        Self { posed, ..Self::reaching(&bodies, UPWARD, contact_mm(profile)) }
    }

    /// The head as it is seen from the tool at `pose`: another one only where a piece does not turn with the tool.
    pub fn at(&self, pose: Pose) -> HeadSeen<'_> {
        self.posed.as_ref().map_or(HeadSeen::Same(self), |posed| HeadSeen::Own(posed.at(self, pose)))
    }

    /// Of this head what keeps its attitude while the tool turns.
    pub(super) fn staying(&self) -> Self {
        Self { pieces: self.pieces.iter().filter(|piece| piece.stays).cloned().collect(), posed: None }
    }

    /// A head of these bodies; those that begin at the tip carry it.
    pub fn from_bodies(bodies: &[Body]) -> Self {
        Self::reaching(bodies, UPWARD, 1e-3)
    }

    /// The head as it is built, without the upward reach: for the frame, parts of which may well be above it. What it
    /// sweeps must then be convex, or an obstacle inside the sweep would be missed.
    pub(super) fn as_built(profile: &Profile) -> Self {
        Self::reaching(&profile.head_bodies(), 0.0, contact_mm(profile))
    }

    fn reaching(bodies: &[Body], upward: f64, contact: f64) -> Self {
        let pieces = bodies.iter().map(|body| {
            let upward = if body.follows[2] && !body.stays { upward } else { 0.0 };
            Piece {
                name: body.name.clone(),
                fans: Arc::new(Fans::of(&body.points, upward)),
                follows: body.follows,
                tip: carries_tip(body, contact),
                stays: body.stays,
            }
        });
        Self { pieces: pieces.collect(), posed: None }
    }

    /// Nothing but the middle of the tip, and what is above it.
    pub fn point() -> Self {
        Self {
            pieces: vec![Piece {
                name: "tip".to_owned(),
                fans: Arc::new(Fans::of(&[Vec3::zeros()], UPWARD)),
                follows: [true; 3],
                tip: true,
                stays: false,
            }],
            posed: None,
        }
    }

    /// By piece: its lowest point above the tip, and whether it follows the tip in Z.
    pub(super) fn lows(&self) -> impl Iterator<Item = (f64, bool)> {
        self.pieces.iter().map(|piece| (piece.fans.bounds.min.z, piece.follows[2]))
    }

    /// How far the head stays from `obstacle` while its tip visits `swept` raised by `lift` mm, up to `enough` mm; both at
    /// the pose whose motion is `at`.
    pub(super) fn clearance<A, B>(
        &self,
        at: &Rigid<A, B>,
        swept: &Solid,
        obstacle: &Solid,
        lift: f64,
        enough: f64,
    ) -> Clearance {
        let mut least = Clearance { mm: enough, piece: String::new() };
        for piece in &self.pieces {
            let raise = if piece.follows[2] { lift } else { 0.0 };
            let tool = Tool::Fans { fans: &piece.fans, raise, wider: 0.0 };
            match swept.tool_clearance(at, piece.follows, &tool, obstacle, least.mm) {
                Separation::Meeting => return Clearance { mm: 0.0, piece: piece.name.clone() },
                Separation::Apart(mm) if mm < least.mm || least.piece.is_empty() => {
                    least = Clearance { mm, piece: piece.name.clone() }
                }
                Separation::Apart(_) => {}
            }
        }
        least
    }

    /// The piece of the head that comes nearer to `obstacle` than is owed while the tip visits `swept` raised by `lift` mm, and
    /// how near; `None` where all keep away.
    pub(super) fn offence<A, B>(
        &self,
        at: &Rigid<A, B>,
        swept: &Solid,
        obstacle: &Solid,
        owed: &Owed,
        lift: f64,
    ) -> Option<Clearance> {
        self.pieces.iter().find_map(|piece| {
            let share = if piece.tip { owed.tip } else { owed.rest };
            let raise = if piece.follows[2] { share.lift + lift } else { 0.0 };
            let tool = Tool::Fans { fans: &piece.fans, raise, wider: share.wider };
            let apart = swept.tool_clearance(at, piece.follows, &tool, obstacle, share.mm);
            let mm = apart.distance();
            (mm < share.mm).then(|| Clearance { mm, piece: piece.name.clone() })
        })
    }

    /// Whether the head gives `obstacle` all that is owed to it while the tip visits `swept`.
    pub(super) fn gives_owed<A, B>(&self, at: &Rigid<A, B>, swept: &Solid, obstacle: &Solid, owed: &Owed) -> bool {
        self.pieces.iter().all(|piece| {
            let share = if piece.tip { owed.tip } else { owed.rest };
            let raise = if piece.follows[2] { share.lift } else { 0.0 };
            let tool = Tool::Fans { fans: &piece.fans, raise, wider: share.wider };
            swept.tool_clears(at, piece.follows, &tool, obstacle, share.mm)
        })
    }

    /// Whether the head keeps `margin` mm from `obstacle` while its tip visits all of `swept` raised by `lift` mm, both at the
    /// pose whose motion is `at`.
    pub fn clears<A, B>(&self, at: &Rigid<A, B>, swept: &Solid, obstacle: &Solid, lift: f64, margin: f64) -> bool {
        self.clearance(at, swept, obstacle, lift, margin).mm >= margin
    }

    /// Whether the head stays clear of `obstacle` while the tip, raised by `lift` mm, goes straight from `from` to `to`.
    pub fn passes(&self, from: Vec3, to: Vec3, obstacle: &Solid, lift: f64) -> bool {
        self.sweeps_clear(&[from, to], obstacle, lift)
    }

    /// The same for a tip that visits the whole hull of `corners`.
    pub fn sweeps_clear(&self, corners: &[Vec3], obstacle: &Solid, lift: f64) -> bool {
        let still = Rigid::<Machine, Machine>::shift(Vec3::zeros());
        self.clearance(&still, &Solid::hull(corners.to_vec()), obstacle, lift, 1e-3).mm > 0.0
    }

    /// The lift of the tip (mm, to 0.1) that would give `obstacle` what is owed to it; what explanations call the depth.
    pub(super) fn depth<A, B>(&self, at: &Rigid<A, B>, swept: &Solid, obstacle: &Solid, owed: &Owed) -> f64 {
        let meets = |more: f64| self.offence(at, swept, obstacle, owed, more).is_some();
        let (mut low, mut high) = (0.0, 1.0);
        while high < UPWARD && meets(high) {
            low = high;
            high *= 2.0;
        }
        while high - low > 0.1 {
            let middle = (low + high) / 2.0;
            if meets(middle) { low = middle } else { high = middle }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::super::owed::Share;
    use super::*;

    fn still() -> Rigid<Machine, Machine> {
        Rigid::shift(Vec3::zeros())
    }

    fn post(x: f64, height: f64) -> Solid {
        let body = Body::cuboid("", Vec3::new(x, -2.0, 0.0), Vec3::new(x + 4.0, 2.0, height), [true; 3]);
        Solid::hull(body.points)
    }

    fn head() -> Head {
        Head::from_bodies(&[
            Body::frustum("nozzle", [0.0, 10.0], [0.5, 8.0], [true; 3]),
            Body::cuboid("block", Vec3::new(-10.0, -10.0, 10.0), Vec3::new(10.0, 10.0, 60.0), [true; 3]),
        ])
    }

    #[test]
    fn a_long_bar_beside_a_post_is_hit_at_mid_length() {
        // Six extreme vertices all lie 40 mm from the post; only the middle of the bar comes near it.
        let bar =
            Solid::hull(Body::cuboid("", Vec3::new(-50.0, 11.0, 0.0), Vec3::new(50.0, 15.0, 4.0), [true; 3]).points);
        let got = head().clearance(&still(), &bar, &post(0.0, 30.0), 0.2, 5.0);
        assert_eq!((got.mm, got.piece.as_str()), (0.0, "block"));
        let low = head().clearance(&still(), &bar, &post(0.0, 3.0), 0.2, 5.0);
        assert!(low.mm > 0.0, "{low:?}");
    }

    #[test]
    fn depth_is_the_lift_that_frees() {
        let bar =
            Solid::hull(Body::cuboid("", Vec3::new(-50.0, 11.0, 0.0), Vec3::new(50.0, 15.0, 4.0), [true; 3]).points);
        // The block's underside is 10 mm above the tip, the post's top at 30: 20 mm less the lift.
        let share = Share { lift: 0.2, wider: 0.0, mm: 1e-3 };
        let depth = head().depth(&still(), &bar, &post(0.0, 30.0), &Owed { tip: share, rest: share });
        assert!((depth - 19.8).abs() < 0.15, "{depth}");
    }

    #[test]
    fn only_the_piece_with_the_tip_may_touch() {
        // The post's flat top lies 0.3 mm above the tip, below the nozzle and nothing else.
        let spot = Solid::hull(vec![Vec3::new(2.0, 0.0, 29.7)]);
        let owed = |tip: f64, rest: f64| {
            let share = |lift| Share { lift, wider: 0.0, mm: 1e-3 };
            Owed { tip: share(tip), rest: share(rest) }
        };
        let piece = |owed: &Owed, tall: f64| {
            head().offence(&still(), &spot, &post(0.0, tall), owed, 0.0).map(|offence| offence.piece)
        };
        assert_eq!(piece(&owed(0.4, 0.0), 30.0), None);
        assert_eq!(piece(&owed(0.0, 0.4), 30.0), Some("nozzle".to_owned()));
        // A post beside it that ends 0.1 mm inside the block: what the tip may, the block may not.
        let beside = Solid::hull(vec![Vec3::new(-9.0, 0.0, 0.0)]);
        let block = |rest: f64| head().offence(&still(), &beside, &post(0.0, 10.1), &owed(0.4, rest), 0.0);
        assert_eq!(block(0.0).map(|offence| offence.piece), Some("block".to_owned()));
        assert_eq!(block(0.2), None);
    }

    #[test]
    fn a_wider_nozzle_keeps_farther_from_a_wall() {
        // The flat of 0.5 mm passes a post whose near side is 0.7 mm away; as 0.3 mm wider it does not.
        let spot = Solid::hull(vec![Vec3::new(-0.7, 0.0, 0.0)]);
        let low = post(0.0, 0.1);
        let owed = |wider| {
            let share = Share { lift: 0.0, wider, mm: 1e-3 };
            Owed { tip: share, rest: share }
        };
        assert!(head().offence(&still(), &spot, &low, &owed(0.1), 0.0).is_none());
        assert!(head().offence(&still(), &spot, &low, &owed(0.3), 0.0).is_some());
    }

    #[test]
    fn nothing_hides_above_the_head() {
        let tip = Solid::hull(vec![Vec3::zeros()]);
        let shelf = Body::cuboid("", Vec3::new(-3.0, -3.0, 500.0), Vec3::new(3.0, 3.0, 510.0), [true; 3]);
        assert_eq!(head().clearance(&still(), &tip, &Solid::hull(shelf.points), 0.0, 1.0).mm, 0.0);
    }
}
