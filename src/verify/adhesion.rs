//! Rule `outside-part` for skirts and brims: what the slicer lays beside a part so that it sticks is no part of it, and may be laid on
//! the bare table only.
//!
//! Such lines belong to the first layer of a print that stands on the level table, in the plan's first slot; they lie on the table and
//! clear of its rim, and of every part that stands there. What they take is held as any line's. None of this lets a line of a part
//! pass: the part's own rules do not see these lines, and miss what is not there.

use super::evidence::{Checked, Evidence};
use super::prints::PrintedPart;
use super::report::{FindingPlace, Findings, Rule};
use crate::gcode::marks::Role;
use crate::geom::Vec3;
use crate::section::{Section, Sections};
use crate::trace::TraceMove;

/// How far the middle of a brim's line may lie inside its part's outline, mm: bottoms are compensated and rounded.
const INSIDE_MM: f64 = 0.05;
/// How far such a line's height may be off its print's first layer, mm.
const LEVEL_MM: f64 = 0.01;
/// What a line may take, beside what its width and height hold.
const FLOW: [f64; 2] = [0.8, 1.25];
/// Shorter lines tell nothing of what they hold, mm.
const SHORT_MM: f64 = 1.0;
/// Spacing of the places looked at along a line, mm.
const SPACING_MM: f64 = 0.5;

/// Holds all such lines of the program.
pub(super) fn check(&Evidence { trace, printed, .. }: &Evidence<'_>) -> Checked {
    let mut findings = Findings::default();
    let mut standing: Option<Vec<(usize, Section)>> = None;
    for m in trace.moves().filter(|m| m.prints() && m.role == Role::Adhesion) {
        let print = trace.state(&m).print.and_then(|p| printed.get(p as usize)?.as_ref());
        let Some(print) = print else { continue };
        let standing = standing.get_or_insert_with(|| footprints(printed));
        if let Some(why) = objection(print, &m, standing) {
            let at = FindingPlace { line: m.line, slot: Some(print.planned.slot), part: Some(print.planned.part) };
            findings.add(Rule::OutsidePart, at, [0.0, 0.0], || format!("a skirt or brim {why}"));
        }
    }
    findings.into()
}

/// The outline in which each part on the table stands there.
fn footprints(printed: &[Option<PrintedPart<'_>>]) -> Vec<(usize, Section)> {
    let stands = |print: &&PrintedPart<'_>| is_on_table(print);
    let one = |print: &PrintedPart<'_>| {
        let part = print.job.workpiece.parts.get(print.planned.part)?;
        let sections = Sections::of(&part.moved(&print.job.profile.kinematics().forward(print.planned.pose)));
        let height = print.levels.first()?.height();
        Some((print.planned.part, sections.at(sections.range()[0] + height / 2.0)))
    };
    printed.iter().flatten().filter(stands).filter_map(one).collect()
}

/// Whether a print begins on the level table.
fn is_on_table(print: &PrintedPart<'_>) -> bool {
    let level = print.planned.up.angle(&Vec3::z()) < 1e-6;
    level && print.job.workpiece.model.on_table.contains(&print.planned.part)
}

fn objection(print: &PrintedPart<'_>, m: &TraceMove, standing: &[(usize, Section)]) -> Option<String> {
    let part = print.planned.part;
    let first_slot = print.job.plan.slots.first().is_some_and(|slot| slot.id == print.planned.slot);
    if !(first_slot && is_on_table(print)) {
        return Some(format!("is printed for part {part}, which is not printed first on the table; switch it off"));
    }
    let [from, to] = m.ends()?;
    let level = print.levels.first()?;
    if [from, to].iter().any(|p| (p.z - level.z).abs() > LEVEL_MM) {
        let (at, first) = (to.z, level.z);
        return Some(format!(
            "of part {part} is printed at Z {at:.2} mm, but the first layer is at Z {first:.2} mm; limit it to one layer"
        ));
    }
    let (width, length) = (print.width(m, level), (to - from).norm());
    let count = (length / SPACING_MM).ceil().max(1.0) as usize;
    for k in 0..=count {
        let p = from + (to - from) * (k as f64 / count as f64);
        if !lies_on_table(print, p, width / 2.0) {
            return Some(format!(
                "of part {part} leaves the table at X {:.1} Y {:.1}; switch it off, or make it smaller",
                p.x, p.y
            ));
        }
        for (other, section) in standing {
            let least = if *other == part { -INSIDE_MM } else { width / 2.0 };
            let distance = section.signed_distance([p.x, p.y]);
            if distance < least {
                return Some(format!(
                    "of part {part} is {distance:.2} mm from the outline of part {other} (minimum {least:.2} mm); make it smaller"
                ));
            }
        }
    }
    let ratio =
        m.e * print.filament_mm2 / (print.flow.bead.area(width, level.height()) * length * print.flow.multiplier);
    if length > SHORT_MM && !(FLOW[0]..=FLOW[1]).contains(&ratio) {
        let [least, most] = FLOW;
        return Some(format!(
            "of part {part} uses {ratio:.2} times the filament that its width and height need (allowed {least} to {most})"
        ));
    }
    None
}

/// Whether a line's edges lie on the table's surface, clear of its rim.
fn lies_on_table(print: &PrintedPart<'_>, at: Vec3, half: f64) -> bool {
    let profile = print.job.profile;
    let motion = profile.kinematics().forward(print.planned.pose);
    let on_table = motion.rotation.transpose() * (at - motion.translation);
    let room = profile.table.keep_out_mm + half;
    match profile.table.size_mm.filter(|_| profile.table.radius_mm == 0.0) {
        Some([wide, deep]) => on_table.x.abs() <= wide / 2.0 - room && on_table.y.abs() <= deep / 2.0 - room,
        None => on_table.x.hypot(on_table.y) <= profile.table.radius_mm - room,
    }
}
