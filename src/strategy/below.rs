//! Supports below what stands on the table while other parts are printed onto it later, tilted: what lies in their way, and whose way they
//! stand in.

use super::refused::Refused;
use crate::geom::{Machine, Rigid, Table, Vec3};
use crate::input::CheckedPlan;
use crate::mesh::TriangleMesh;
use crate::planning::{Obstacle, Print, turn_struck};
use crate::section::{Section, Sections, Segment, march};
use crate::spelling::part_named;

/// Supports of one part as they are laid.
pub(super) struct Below<'a> {
    /// The part.
    pub(super) part: usize,
    /// By layer: the height of its middle, and its lines; slot frame.
    pub(super) layers: Vec<(f64, &'a [Segment])>,
    /// From there to the machine's frame.
    pub(super) to_machine: Vec3,
}

/// Whether these supports are laid first of all on the empty table, clear of all other parts, and neither a later print's head nor a turn
/// of the table meets them.
/// `standing` is what they are made of, machine frame, by part.
pub(super) fn stand_alone(
    plan: &CheckedPlan,
    held: &[Below<'_>],
    standing: &[(usize, TriangleMesh<Machine>)],
    margin_mm: f64,
) -> Result<(), Refused> {
    let name = |part: usize| part_named(part, &plan.model.model.parts[part].name);
    let setups: Vec<Vec<&Print>> = plan.plan.slots.iter().flat_map(|slot| slot.setups()).collect();
    let Some((first, later)) = setups.split_first() else { return Ok(()) };
    for below in held {
        if !first.iter().any(|print| print.part == below.part) {
            return Err(Refused::Late { part: name(below.part) });
        }
        if let Some(other) = in_the_way(plan, below) {
            return Err(Refused::Within { part: name(below.part), other: name(other) });
        }
    }
    let table = plan.machine.profile.kinematics();
    let workpiece = plan.workpiece();
    let mut all: Vec<(usize, TriangleMesh<Table>)> = Vec::new();
    for (part, solid) in standing {
        let Some(print) = first.iter().find(|print| print.part == *part) else { continue };
        let on_table: TriangleMesh<Table> = solid.moved(&table.forward(print.pose(&table)).inverse());
        let obstacle = Obstacle::new(&plan.machine.profile, &on_table, margin_mm);
        for later in later.iter().flatten() {
            if let Some(piece) = obstacle.met_by(&workpiece.parts[later.part], later.pose(&table)) {
                let (printed, part) = (name(later.part), name(*part));
                return Err(Refused::Head { printed, piece, part });
            }
        }
        all.push((*part, on_table));
    }
    turn_struck(&workpiece, &plan.machine.profile, &all, &plan.plan.slots)
        .map_or(Ok(()), |text| Err(Refused::Turn(text)))
}

/// The part, other than its own, that a line of supports comes upon.
fn in_the_way(plan: &CheckedPlan, below: &Below<'_>) -> Option<usize> {
    let table = plan.machine.profile.kinematics();
    let (workpiece, room_mm) = (plan.workpiece(), plan.machine.profile.process.line_width_mm);
    let (_, print) = plan.prints().find(|(_, print)| print.part == below.part)?;
    let motion = table.forward(print.pose(&table));
    // What grows beside them they were laid around.
    let own = plan.plan.setup_of(below.part);
    let beside = |part: usize| own.iter().any(|one| one.part == part);
    (0..workpiece.parts.len()).filter(|&other| !beside(other)).find(|&other| {
        let there = Rigid::<Machine, Machine>::shift(-below.to_machine);
        let mesh = workpiece.parts[other].moved(&motion).moved(&there);
        let sections = Sections::of(&mesh);
        let [low, high] = sections.range();
        below.layers.iter().filter(|(z, _)| (low..=high).contains(z)).any(|(z, lines)| {
            let section = sections.at(*z);
            !section.is_empty() && lines.iter().any(|line| meets(&section, *line, room_mm))
        })
    })
}

/// Whether a line's middle comes nearer to a section than `room_mm`, which is less than 2 mm.
fn meets(section: &Section, line: Segment, room_mm: f64) -> bool {
    march(line, |p| section.signed_distance(p) - room_mm).any(|(_, room)| room < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;

    #[test]
    fn a_line_meets_what_it_crosses_lies_in_or_passes_too_near() {
        let block = solid_box(Vec3::zeros(), Vec3::new(10.0, 10.0, 5.0));
        let section = Sections::of(&block).at(2.0);
        for (line, wanted) in [
            ([[-5.0, 5.0], [15.0, 5.0]], true),
            ([[4.0, 4.0], [6.0, 6.0]], true),
            ([[-5.0, 10.3], [15.0, 10.3]], true),
            ([[-5.0, 10.6], [15.0, 10.6]], false),
            ([[20.0, 0.0], [20.0, 10.0]], false),
        ] {
            assert_eq!(meets(&section, line, 0.45), wanted, "{line:?}");
        }
    }
}
