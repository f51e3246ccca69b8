//! The part of a profile's chain that turns the head: `motion`'s types of it, the head's pieces as the tool sees them, and what goes with it.
//!
//! Lengths mm. What is said of heads in `firmware-profiles/defaults.toml` is held here; the formulas are [`SwivelHead`]'s.

use super::layers::{Origin, ProfileError};
use super::schema::{AxisTurns, BodySpec, Profile};
use crate::geom::{Angle, Body, Vec3};
use crate::motion::{Pose, SwivelHead, SwivelWords, TableKinematics};

/// How far upward what holds up a piece of the head is taken to reach, mm; beyond any machine.
const UPWARD_MM: f64 = 2000.0;

impl Profile {
    /// What turns the head; `None` where all axes turn the table.
    pub(super) fn swivel(&self) -> Option<SwivelHead> {
        let (tilt, rotation) = (&self.kinematics.tilt, &self.kinematics.rotation);
        let [leans, yaws] = [tilt.turns, rotation.turns].map(|turns| turns == AxisTurns::Head);
        let from_tip = |at: Option<[f64; 3]>| at.map_or_else(Vec3::zeros, Vec3::from);
        leans.then(|| SwivelHead {
            about: self.tilt_about(),
            yaws,
            tilt_from_tip: from_tip(tilt.from_tip_mm),
            rotation_from_tip: from_tip(rotation.from_tip_mm),
            table: Vec3::from(self.kinematics.pivot_mm) + Vec3::from(self.kinematics.offset_mm),
            words: if self.dialect.rtcp { SwivelWords::Tip } else { SwivelWords::Axes },
        })
    }

    /// The [pieces of the head](Self::head_bodies) as the tool sees them at `pose`. A piece that does not turn with it follows the tip as the others do, is as long as its axes
    /// let it come along the axes that it does not follow, and reaches upward without end: what holds it up is above it.
    pub fn head_bodies_at(&self, pose: Pose) -> Vec<Body> {
        let bodies = self.head_bodies();
        let Some(swivel) = self.swivel() else { return bodies };
        let seen = |body: Body| if body.stays { self.seen_by_the_tool(&body, &swivel, pose) } else { body };
        bodies.into_iter().map(seen).collect()
    }

    /// How deep any point of a head that turns comes below the height that Z says, at all angles from one tilt to another; at whatever angle
    /// where none are given. 0 for a head that does not turn.
    pub fn head_depth_mm(&self, tilts: Option<[Angle; 2]>) -> f64 {
        let TableKinematics { tilt, head, .. } = self.kinematics();
        let Some(head) = head else { return 0.0 };
        let all = tilt.range.map_or([Angle::ZERO; 2], |(low, high)| [low, high].map(|word| tilt.angle_of(word)));
        let [a, b] = tilts.unwrap_or(all);
        let corners = |stays: bool| {
            let bodies = self.head_bodies().into_iter().filter(move |body| body.stays == stays);
            bodies.flat_map(|body| body.points).collect::<Vec<Vec3>>()
        };
        head.deepest(&corners(false), &corners(true), if a.rad() < b.rad() { (a, b) } else { (b, a) })
    }

    fn seen_by_the_tool(&self, body: &Body, swivel: &SwivelHead, pose: Pose) -> Body {
        let mut points = body.points.clone();
        let limits = self.linear_limits();
        for axis in (0..3).filter(|&axis| !body.follows[axis]) {
            let ends = [limits.min[axis], limits.max[axis]];
            let from_the_tip =
                |p: &Vec3| ends.map(|end| Vec3::from_fn(|i, _| if i == axis { p[i] - end } else { p[i] }));
            points = points.iter().flat_map(from_the_tip).collect();
        }
        if body.follows[2] {
            let raised: Vec<Vec3> = points.iter().map(|p| p + Vec3::z() * UPWARD_MM).collect();
            points.extend(raised);
        }
        points.iter_mut().for_each(|p| *p = swivel.unturned(*p, pose));
        Body { name: body.name.clone(), points, follows: [true; 3], stays: true }
    }

    /// What the axes turn, and what goes with it.
    pub(super) fn check_chain(&self, origin: &Origin) -> Result<(), ProfileError> {
        let (tilt, rotation) = (&self.kinematics.tilt, &self.kinematics.rotation);
        let head = tilt.turns == AxisTurns::Head;
        let said = |turns: AxisTurns| format!("{turns:?}").to_lowercase();
        let given = |at: Option<[f64; 3]>| at.map_or_else(|| "absent".to_owned(), |at| format!("{at:?}"));
        let placed = |turns: AxisTurns, at: Option<[f64; 3]>| at.is_some() == (turns == AxisTurns::Head);
        let allowed = |turns: AxisTurns| match turns {
            AxisTurns::Head => {
                "[x, y, z] from the tip to a point on the axis while the tool is upright, since the axis turns the head"
            }
            _ => "absent: the axis does not turn the head (turns)",
        };
        let turning = |bodies: &[BodySpec]| bodies.iter().find(|body| !body.turns).map(|body| body.name.clone());
        let stays = turning(&self.head.body).or_else(|| turning(&self.fixed.body));
        let square = self.misaligned().is_none();
        let both = head && rotation.turns == AxisTurns::Head;
        let beam = self.head.body.iter().find(|body| head && body.turns && body.moves != "XYZ");
        let rows: [(&str, bool, String, &str); 13] = [
            (
                "kinematics.rotation.turns",
                rotation.turns != AxisTurns::Head || head,
                said(rotation.turns),
                "\"table\" or \"none\" where the tilt axis does not turn the head: a head that only yaws points nowhere else",
            ),
            (
                "kinematics.tilt.turns",
                tilt.turns != AxisTurns::None || rotation.turns != AxisTurns::None,
                said(tilt.turns),
                "\"table\" or \"head\" where there is no rotation axis either",
            ),
            (
                "kinematics.tilt.from_tip_mm",
                placed(tilt.turns, tilt.from_tip_mm),
                given(tilt.from_tip_mm),
                allowed(tilt.turns),
            ),
            (
                "kinematics.rotation.from_tip_mm",
                placed(rotation.turns, rotation.from_tip_mm),
                given(rotation.from_tip_mm),
                allowed(rotation.turns),
            ),
            (
                "dialect.rtcp",
                !self.dialect.rtcp || both,
                self.dialect.rtcp.to_string(),
                "false unless both axes turn the head: trunnion computes the poses of a table itself",
            ),
            (
                "kinematics.tilt.along",
                square || !head,
                "given".to_owned(),
                "absent where the head tilts: its axes are taken as square",
            ),
            (
                "fixed.body",
                !head || self.fixed.body.is_empty(),
                format!("{} pieces", self.fixed.body.len()),
                "empty where the head tilts: pieces of the frame beside it are not followed yet",
            ),
            (
                "head.body",
                !self.head.body.iter().any(|body| head && !body.moves.contains('Z')),
                "a piece without Z in moves".to_owned(),
                "moves with Z where the head tilts: what stays at its height while the head goes up is not followed yet",
            ),
            (
                "head.body",
                head || stays.is_none(),
                format!("turns = false of {:?}", stays.unwrap_or_default()),
                "turns = true: this head does not turn",
            ),
            (
                "transition.park_mm",
                !head || self.transition.park_mm.is_none(),
                "given".to_owned(),
                "absent where the head tilts",
            ),
            (
                "link.rehome",
                !head || self.link.rehome.is_empty(),
                "given".to_owned(),
                "empty where the head tilts: its way back into a print is not worked out",
            ),
            (
                "kinematics.tilt.holding_nm",
                tilt.holding_nm.is_none() || tilt.turns == AxisTurns::Table,
                "given".to_owned(),
                "absent where the tilt axis does not carry the table",
            ),
            (
                "head.body",
                beam.is_none(),
                format!(
                    "moves = {:?} of {:?}",
                    beam.map_or("", |body| &body.moves),
                    beam.map_or("", |body| &body.name)
                ),
                "\"XYZ\" of what turns with the tool; a piece that does not follow all axes keeps its attitude (turns = false)",
            ),
        ];
        let wrong = rows.into_iter().find(|(_, fine, ..)| !fine);
        wrong.map_or(Ok(()), |(key, _, value, allowed)| {
            let place = origin.get(key).cloned().unwrap_or_default();
            Err(ProfileError::Range { place, key: key.to_owned(), value, allowed: allowed.to_owned() })
        })
    }
}
