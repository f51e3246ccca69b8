//! How much room there is on the table for brims and a skirt, table frame, mm.
//!
//! What the profile or the slicer's configuration asks for (`process.brim_mm`, `process.skirt_loops`) is laid around what stands on the level table in the first time slot: a
//! brim up to halfway to the next part that stands there at any time, less the nozzle's radius, and not beyond the rim; loops around the first print alone, or none.
//! What gets less than was asked for is told.

use crate::input::CheckedPlan;
use crate::planning::{Print, Workpiece};
use crate::section::{Section, Sections};
use crate::slicing::{Adhesion, Flaw, Lessened, SliceSettings};
use crate::toolpath::SlotMesh;

/// Where a part stands on the table.
struct Footprint {
    part: usize,
    section: Section,
}

/// For each print what is laid around it, and why that is less than the profile asks for.
pub(crate) fn of_prints(
    plan: &CheckedPlan,
    process: &SliceSettings,
    meshes: &[SlotMesh],
) -> Vec<(Adhesion, Option<Flaw>)> {
    if process.brim_mm == 0.0 && process.skirt_loops == 0 {
        return vec![(Adhesion::default(), None); meshes.len()];
    }
    let workpiece = plan.workpiece();
    let standing = footprints(&workpiece, process.layer_height_mm);
    let first_slot = plan.prints().next().map(|(slot, _)| slot);
    let one = |(index, ((slot, print), mesh)): (usize, ((usize, &Print), &SlotMesh))| {
        let stands = mesh.on_table && Some(slot) == first_slot;
        let own = standing.iter().find(|f| f.part == print.part).filter(|_| stands);
        let Some(own) = own else { return (Adhesion::default(), None) };
        if print.supports.is_some() {
            return (Adhesion::default(), Some(Flaw::Lessened(Lessened::ForSupports)));
        }
        let profile = &plan.machine.profile;
        let (room_mm, beside) = room(own, &standing, profile.tip_radius_mm(), |x, y| profile.beyond_table(x, y));
        lessened(process, index == 0, room_mm, beside)
    };
    plan.prints().zip(meshes).enumerate().map(one).collect()
}

fn footprints(workpiece: &Workpiece<'_>, layer_mm: f64) -> Vec<Footprint> {
    let one = |&part: &usize| {
        let sections = Sections::of(&workpiece.parts[part]);
        Footprint { part, section: sections.at(sections.range()[0] + layer_mm / 2.0) }
    };
    workpiece.model.on_table.iter().map(one).filter(|f| !f.section.is_empty()).collect()
}

/// How far lines may reach beyond a part, and the part that is nearest, if it is that and not the rim. The nozzle that lays the outermost
/// keeps clear of what is laid around the other part.
fn room(
    own: &Footprint,
    standing: &[Footprint],
    nozzle_mm: f64,
    beyond_table: impl Fn(f64, f64) -> f64,
) -> (f64, Option<usize>) {
    let corners = || own.section.segments().iter().flatten();
    let rim = corners().map(|[x, y]| -beyond_table(*x, *y)).fold(f64::INFINITY, f64::min);
    let others = standing.iter().filter(|other| other.part != own.part);
    let halfway = others.map(|other| (own.section.apart(&other.section) / 2.0 - nozzle_mm, Some(other.part)));
    let (mm, part) = halfway.fold((rim, None), |least, next| if next.0 < least.0 { next } else { least });
    (mm.max(0.0), part)
}

fn lessened(process: &SliceSettings, first: bool, room_mm: f64, beside: Option<usize>) -> (Adhesion, Option<Flaw>) {
    let brim_mm = process.brim_mm.min(room_mm);
    let loops_mm = f64::from(process.skirt_loops) * process.line_width_mm.max(process.first_layer_width_mm);
    let fits = brim_mm + process.skirt_distance_mm + loops_mm <= room_mm;
    let skirt_loops = if first && fits { process.skirt_loops } else { 0 };
    let adhesion = Adhesion { brim_mm, skirt_loops, skirt_distance_mm: process.skirt_distance_mm };
    let lessened = if brim_mm < process.brim_mm {
        Some(Lessened::Brim { wanted_mm: process.brim_mm, brim_mm, beside })
    } else if first && !fits && process.skirt_loops > 0 {
        Some(Lessened::Skirt { wanted_mm: brim_mm + process.skirt_distance_mm + loops_mm, room_mm, beside })
    } else {
        None
    };
    (adhesion, lessened.map(Flaw::Lessened))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;
    use crate::geom::Vec3;

    fn footprint(part: usize, low: [f64; 2], high: [f64; 2]) -> Footprint {
        let mesh = solid_box(Vec3::new(low[0], low[1], 0.0), Vec3::new(high[0], high[1], 5.0));
        Footprint { part, section: Sections::of(&mesh).at(0.1) }
    }

    #[test]
    fn room_ends_halfway_to_the_next_part_or_at_the_rim() {
        let disc = |x: f64, y: f64| x.hypot(y) - 98.0;
        let own = || footprint(0, [-10.0, -10.0], [10.0, 10.0]);
        let alone = room(&own(), &[own()], 0.5, disc);
        assert!((alone.0 - (98.0 - 200.0f64.sqrt())).abs() < 1e-9 && alone.1.is_none(), "{alone:?}");
        // Side against side, corner against corner (3, 4, 5), touching, one within the hollow of the other's box.
        for (other, wanted) in [
            (footprint(3, [18.0, -2.0], [30.0, 2.0]), 4.0),
            (footprint(3, [13.0, 14.0], [30.0, 30.0]), 2.5),
            (footprint(3, [10.0, 0.0], [30.0, 30.0]), 0.0),
            // In one row, so that sides lie on one line; and across, without a corner of either in the other.
            (footprint(3, [16.0, -10.0], [30.0, 10.0]), 3.0),
            (footprint(3, [-2.0, -30.0], [2.0, 30.0]), 0.0),
            (footprint(3, [-5.0, -5.0], [5.0, 5.0]), 0.0),
        ] {
            let (mm, part) = room(&own(), &[own(), other], 0.0, disc);
            assert!((mm - wanted).abs() < 1e-9, "{mm} for {wanted}");
            assert_eq!(part, Some(3));
        }
        let beside = |nozzle| room(&own(), &[own(), footprint(3, [18.0, -2.0], [30.0, 2.0])], nozzle, disc).0;
        assert!((beside(0.5) - 3.5).abs() < 1e-9 && beside(9.0) == 0.0);
        for nozzle in [0.0, 0.5] {
            assert!(room(&own(), &[own()], nozzle, disc).1.is_none(), "the rim is no part");
        }
    }

    #[test]
    fn what_does_not_fit_is_less_and_told() {
        let process =
            SliceSettings { brim_mm: 5.0, skirt_loops: 2, skirt_distance_mm: 3.0, ..SliceSettings::default() };
        let wide = lessened(&process, true, 9.0, None);
        let all = Adhesion { brim_mm: 5.0, skirt_loops: 2, skirt_distance_mm: 3.0 };
        assert_eq!(wide, (all, None));
        let second = lessened(&process, false, 9.0, None);
        assert_eq!(second, (Adhesion { skirt_loops: 0, ..all }, None), "loops go around the first print alone");
        let narrow = lessened(&process, true, 8.8, Some(1));
        assert_eq!((narrow.0.brim_mm, narrow.0.skirt_loops), (5.0, 0));
        let told = narrow.1.map(|flaw| flaw.to_string()).unwrap_or_default();
        assert!(told.contains("8.9") && told.contains("8.8") && told.contains("part 1"), "{told}");
        let short = lessened(&process, true, 1.25, Some(1));
        assert_eq!((short.0.brim_mm, short.0.skirt_loops), (1.25, 0));
        let told = short.1.map(|flaw| flaw.to_string()).unwrap_or_default();
        assert!(told.contains("1.25 mm") && told.contains("of 5 mm") && told.contains("--gap"), "{told}");
    }
}
