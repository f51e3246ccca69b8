//! Whether head, frame and table keep apart while the tip comes down onto the table, stands above it, and while the table turns.
//!
//! Convex distances (`geom::convex`) between the profile's bodies and the table's slab; a turn is stepped through by less than the gap that
//! is kept. Nothing is on the table. Machine coordinates, mm.

use crate::geom::convex::{separation, support};
use crate::geom::{Angle, Body, Vec3};
use crate::motion::{LinearLimits, Pose, TableKinematics};
use crate::profile::Profile;

/// The tip's own piece at a touch is this far above it.
const OVER_TOUCH_MM: f64 = 0.5;
/// That piece's room there.
const TIP_ROOM_MM: f64 = 0.15;
/// The other pieces' room: the machine is not yet known better.
const ROOM_MM: f64 = 3.0;
/// A turn is looked at every so many degrees.
const STEP_DEG: f64 = 1.0;

/// A profile's head, frame and bare table.
pub struct ClearWay {
    table: TableKinematics,
    limits: LinearLimits,
    head: Vec<Body>,
    frame: Vec<Body>,
    slab: Vec<Vec3>,
    reach: f64,
}

impl ClearWay {
    /// Of `profile`.
    pub fn of(profile: &Profile) -> Self {
        let slab = profile.table_slab();
        let reach = slab.iter().map(|p| p.norm()).fold(0.0, f64::max);
        Self {
            table: profile.kinematics(),
            limits: profile.linear_limits(),
            head: profile.head_bodies(),
            frame: profile.fixed_bodies(),
            slab,
            reach,
        }
    }

    /// How far the table reaches from its middle.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// The top of the ball that the table sweeps about the pivot.
    pub fn ball_top(&self) -> f64 {
        self.table.pivot.z + self.table.offset.norm() + self.reach
    }

    fn pose(&self, words_deg: [f64; 2]) -> Pose {
        let [tilt, rotation] = words_deg.map(Angle::from_deg);
        Pose { tilt: self.table.tilt.angle_of(tilt), rotation: self.table.rotation.angle_of(rotation) }
    }

    fn slab_at(&self, pose: Pose) -> Vec<Vec3> {
        let motion = self.table.forward(pose);
        self.slab.iter().map(|p| motion.rotation * p + motion.translation).collect()
    }

    /// Whether the words are within the axes' stops, and the frame is clear of the table there.
    pub fn stands(&self, words_deg: [f64; 2]) -> bool {
        let pose = self.pose(words_deg);
        let slab = self.slab_at(pose);
        let admitted = self.table.tilt.admits(pose.tilt) && self.table.rotation.admits(pose.rotation);
        admitted && self.frame.iter().all(|piece| apart(&piece.points, &slab, &Vec3::zeros(), ROOM_MM))
    }

    /// Whether the tip can come straight down from `top` onto `tip`, with room.
    pub fn touchable(&self, words_deg: [f64; 2], tip: &Vec3, top: f64) -> bool {
        let slab = self.slab_at(self.pose(words_deg));
        let above = tip + Vec3::z() * OVER_TOUCH_MM;
        let within = [*tip, Vec3::new(tip.x, tip.y, top)].iter().all(|p| self.limits.violation(p).is_none());
        within
            && self.head.iter().all(|piece| {
                let room = if piece.bounds().min.z <= 0.0 && piece.follows[2] { TIP_ROOM_MM } else { ROOM_MM };
                let at = moved(piece, &above);
                let sweep = if piece.follows[2] { Vec3::z() * (top - above.z).max(0.0) } else { Vec3::zeros() };
                apart(&at, &slab, &sweep, room)
                    && self.frame.iter().all(|frame| apart(&at, &frame.points, &sweep, ROOM_MM))
            })
    }

    /// Whether the head, its tip going from `from` to `to`, stays clear of the table and the frame.
    pub fn passes(&self, words_deg: [f64; 2], from: &Vec3, to: &Vec3) -> bool {
        let slab = self.slab_at(self.pose(words_deg));
        self.head.iter().all(|piece| {
            let at = moved(piece, from);
            let sweep = piece.origin_at(to) - piece.origin_at(from);
            apart(&at, &slab, &sweep, ROOM_MM)
                && self.frame.iter().all(|frame| apart(&at, &frame.points, &sweep, ROOM_MM))
        })
    }

    /// Whether the head, its tip at the height `z`, is above the level table wherever it is.
    pub fn passes_anywhere(&self, z: f64) -> bool {
        let top = self.slab_at(Pose::LEVEL).iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
        // A rotation axis that leans takes the surface out of level by up to twice that.
        let top = top + self.reach * (2.0 * self.table.directions().rotation.angle(&Vec3::z())).sin();
        let tip = Vec3::new(0.0, 0.0, z);
        self.head.iter().all(|piece| moved(piece, &tip).iter().all(|p| p.z > top + ROOM_MM))
    }

    /// That the table can turn from each of `words_deg` to the next, one axis at a time, while the tip waits at `tip`; else why not.
    pub fn turns_through(&self, words_deg: [[f64; 2]; 3], tip: &Vec3) -> Result<(), String> {
        if words_deg.windows(2).all(|two| self.turns(two[0], two[1], tip)) {
            return Ok(());
        }
        let room = "cannot prove that head and frame clear the table while it turns";
        Err(format!("{room} with the tip at X{:.1} Y{:.1} Z{:.1}", tip.x, tip.y, tip.z))
    }

    /// Whether the table can turn one axis from `from` to `to` while the tip waits at `tip`.
    pub fn turns(&self, from: [f64; 2], to: [f64; 2], tip: &Vec3) -> bool {
        let most = (to[0] - from[0]).abs().max((to[1] - from[1]).abs());
        let steps = (most / STEP_DEG).ceil().max(1.0) as usize;
        // Between two looks no point goes further than half a step, at the far end of the arm.
        let arm = self.table.offset.norm() + self.reach;
        let between = arm * (most / steps as f64 / 2.0).to_radians();
        let head: Vec<Vec<Vec3>> = self.head.iter().map(|piece| moved(piece, tip)).collect();
        (0..=steps).all(|step| {
            let share = step as f64 / steps as f64;
            let words = [from[0] + (to[0] - from[0]) * share, from[1] + (to[1] - from[1]) * share];
            let slab = self.slab_at(self.pose(words));
            let frame = self.frame.iter().map(|piece| &piece.points);
            head.iter().chain(frame).all(|piece| apart(piece, &slab, &Vec3::zeros(), ROOM_MM + between))
        })
    }
}

fn moved(piece: &Body, tip: &Vec3) -> Vec<Vec3> {
    let origin = piece.origin_at(tip);
    piece.points.iter().map(|p| p + origin).collect()
}

/// Whether the hull of `a`, drawn out along `sweep`, keeps more than `room` from the hull of `b`.
fn apart(a: &[Vec3], b: &[Vec3], sweep: &Vec3, room: f64) -> bool {
    let difference = |d: &Vec3| {
        let drawn = if sweep.dot(d) > 0.0 { *sweep } else { Vec3::zeros() };
        support(a, d) + drawn - support(b, &-d)
    };
    separation(difference, room).distance() > room
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::resolve;

    fn clear(text: &str) -> ClearWay {
        ClearWay::of(&resolve("m.toml", text).unwrap().0)
    }

    #[test]
    fn a_level_table_is_touched_anywhere_and_a_steep_one_where_the_block_has_room() {
        // Generic: block of 20 x 20 mm, 10 mm above the tip; the axis 20 mm below the surface, the disc 100 mm.
        let clear = clear("");
        assert!(clear.touchable([0.0, 0.0], &Vec3::new(50.0, -40.0, 0.0), 150.0));
        // At 45 degrees the surface's +Y side stands up: 10 mm beside its middle it is as high as the block.
        let middle = clear.table.forward(Pose::from_deg(45.0, 0.0)).translation;
        assert!(!clear.touchable([45.0, 0.0], &middle, 150.0));
        // Near the upper rim there is no more table beyond the tip.
        let rim = clear.table.forward(Pose::from_deg(45.0, 0.0));
        let rim = rim.rotation * Vec3::new(0.0, 97.0, 0.0) + rim.translation + Vec3::z() * 0.5;
        assert!(clear.touchable([45.0, 0.0], &rim, 150.0), "{rim:?}");
        assert!(!clear.touchable([0.0, 0.0], &Vec3::new(50.0, -40.0, 0.0), 400.0), "beyond the end of Z");
        assert!(!clear.stands([95.0, 0.0]) && clear.stands([90.0, 720.0]));
    }

    #[test]
    fn turns_and_ways_across_are_looked_at_between_their_ends() {
        let clear =
            clear("[[fixed.body]]\nname = \"post\"\nkind = \"box\"\nmin_mm = [-20, -20, 90]\nmax_mm = [20, 20, 200]\n");
        // On edge, at 90 degrees, the rim comes to Z 80, turned by -15 it is below that.
        let far = Vec3::new(120.0, -150.0, 220.0);
        assert!(clear.turns([0.0, 0.0], [90.0, 0.0], &far));
        let post = "[[fixed.body]]\nname = \"post\"\nkind = \"box\"\nmin_mm = [-20, 40, 50]\nmax_mm = [20, 60, 70]\n";
        let clear = super::tests::clear(post);
        assert!(clear.stands([0.0, 0.0]) && clear.stands([90.0, 0.0]));
        assert!(!clear.turns([0.0, 0.0], [90.0, 0.0], &far), "the rim passes through it between the two");
        let low = Vec3::new(-120.0, -150.0, 5.0);
        assert!(!clear.passes([45.0, 0.0], &low, &Vec3::new(120.0, 150.0, 5.0)));
        assert!(clear.passes([45.0, 0.0], &(low + Vec3::z() * 240.0), &Vec3::new(120.0, 150.0, 245.0)));
    }
}
