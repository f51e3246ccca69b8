//! Do head and table keep clear of what stands and is no part of the model, as supports are: while a part is printed, and in the turns of
//! a plan?

use super::collision::Head;
use super::owed::Owed;
use super::plan::TimeSlot;
use super::solid::Solid;
use super::turning::{Turns, remedy};
use super::workpiece::Workpiece;
use crate::geom::Table;
use crate::mesh::TriangleMesh;
use crate::motion::{Pose, TableKinematics};
use crate::profile::Profile;

/// Something that stands on the table, and the head that is to keep clear of it.
pub struct Obstacle {
    solid: Solid,
    head: Head,
    owed: Owed,
    table: TableKinematics,
}

impl Obstacle {
    /// What is owed to it is owed to all that the head does not print on, `margin_mm` at least.
    pub fn new(profile: &Profile, standing: &TriangleMesh<Table>, margin_mm: f64) -> Self {
        let (solid, head) = (Solid::of(standing), Head::of(profile));
        Self { solid, head, owed: Owed::to_others(profile, margin_mm), table: profile.kinematics() }
    }

    /// The piece of the head that comes too near while it prints `part` at `pose`.
    pub fn met_by(&self, part: &TriangleMesh<Table>, pose: Pose) -> Option<String> {
        let motion = self.table.forward(pose);
        self.head
            .at(pose)
            .offence(&motion, &Solid::of(part), &self.solid, &self.owed, 0.0)
            .map(|clearance| clearance.piece)
    }
}

/// What a turn of the table comes upon, or the way across behind it, in a plan some of whose parts stand on supports (by part, table
/// frame), and what helps: `None` where every turn is clear.
///
/// The turns of a plan without supports are looked at while it is made.
pub fn turn_struck(
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    supports: &[(usize, TriangleMesh<Table>)],
    slots: &[TimeSlot],
) -> Option<String> {
    let parts: Vec<Solid> = workpiece.parts.iter().map(Solid::of).collect();
    let supports: Vec<(usize, Solid)> = supports.iter().map(|(part, mesh)| (*part, Solid::of(mesh))).collect();
    let (table, head, slab) = (profile.kinematics(), Head::of(profile), Solid::hull(profile.table_slab()));
    let turns = Turns::with_supports(profile, &table, &head, &parts, &supports, &slab);
    turns.struck(slots).map(|struck| format!("{}; {}", struck.text, remedy(profile)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;
    use crate::geom::{Rigid, Vec3};
    use crate::mesh::Model;
    use crate::planning::Print;

    /// A block, and a smaller one out of its side that is printed lying.
    fn bracket() -> (Model, Vec<TimeSlot>) {
        let base = solid_box(Vec3::new(-10.0, -10.0, 0.0), Vec3::new(10.0, 10.0, 20.0));
        let branch = solid_box(Vec3::new(10.0, -4.0, 8.0), Vec3::new(18.0, 4.0, 16.0));
        let parts = [("base", base), ("branch", branch)].map(|(name, mesh)| (name.to_owned(), mesh));
        let model = Model::from_parts(parts.into());
        let slot = |id: usize, up: [f64; 3], tilt_deg: f64| TimeSlot {
            id,
            prints: vec![Print { part: id, up, tilt_deg, rotation_deg: 0.0, supports: None }],
        };
        (model, vec![slot(0, [0.0, 0.0, 1.0], 0.0), slot(1, [1.0, 0.0, 0.0], 90.0)])
    }

    #[test]
    fn a_turn_below_the_ball_minds_supports_as_high_as_they_are() {
        let (model, slots) = bracket();
        let workpiece = Workpiece::place(&model, &Workpiece::centred(&model));
        let supports = |high: f64| {
            solid_box(Vec3::new(-4.0, -16.0, 0.0), Vec3::new(4.0, -12.0, high)).moved(&Rigid::shift(Vec3::zeros()))
        };
        let lowest_clear = |high: Option<f64>| {
            let held: Vec<(usize, TriangleMesh<Table>)> = high.map(|mm| (0, supports(mm))).into_iter().collect();
            let mut from = None;
            for z in (20..200).step_by(2) {
                let toml =
                    format!("extends = \"generic-ac\"\n[table]\nradius_mm = 25.0\n[limits]\nz_mm = [-50.0, {z}.0]\n");
                let profile = crate::profile::resolve("machine.toml", &toml).unwrap().0;
                let struck = turn_struck(&workpiece, &profile, &held, &slots);
                assert!(from.is_none() || struck.is_none(), "clear at {from:?} and not at {z}: {struck:?}");
                from = from.or(struck.is_none().then_some(z));
            }
            from.expect("clear where the head is high")
        };
        let bare = lowest_clear(None);
        assert_eq!(lowest_clear(Some(1.0)), bare, "lower than all else");
        let heights: Vec<i32> = [40.0, 60.0, 90.0].map(|high| lowest_clear(Some(high))).to_vec();
        assert!(heights.is_sorted() && heights[0] > bare && heights[2] >= heights[0] + 40, "{bare}, {heights:?}");
    }
}
