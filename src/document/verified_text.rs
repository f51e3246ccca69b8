//! `trunnion verify`: findings, and what is told beside them.

use std::fmt::Write;

use crate::planning::balance::DOUBTFUL;
use crate::spelling::counted;
use crate::verify::{InterfaceFill, JointRoom, Refereed, Report, Standing, StatedSetting, TableUse};

/// `trunnion verify`.
pub fn verified(report: &Report) -> String {
    let mut out = String::new();
    for f in &report.findings {
        let place = match (f.slot, f.part) {
            (Some(slot), Some(part)) => format!(" (slot {slot}, part {part})"),
            _ => String::new(),
        };
        let _ = writeln!(out, "line {}: {}{place}: {}", f.line, f.rule, f.text);
    }
    for (rule, count) in &report.counts {
        let listed = report.findings.iter().filter(|f| f.rule == *rule).count();
        if listed < *count {
            let _ = writeln!(out, "{rule}: {count} findings, the first {listed} are listed");
        }
    }
    unsteady(report).iter().for_each(|text| _ = writeln!(out, "{text}"));
    joints(report).iter().for_each(|text| _ = writeln!(out, "{text}"));
    [bonds(report), turning(report)].iter().flatten().for_each(|text| _ = writeln!(out, "{text}"));
    report.stated.iter().for_each(|one| _ = writeln!(out, "{}", stated(one)));
    let minutes = report.seconds_print / 60.0;
    let _ = writeln!(
        out,
        "{} in {}, {:.0} mm of filament, about {minutes:.0} min, clearance {:.2} mm (line {}), {}",
        counted(report.moves, "move"),
        counted(report.slots, "slot"),
        report.filament_mm,
        report.clearance_mm,
        report.clearance_line,
        counted(report.count(), "finding")
    );
    out
}

/// `trunnion verify` without a plan.
pub fn refereed(done: &Refereed) -> String {
    let rules: Vec<String> = done.not_judged.iter().map(ToString::to_string).collect();
    format!(
        "{}checked without a plan, as {}, one for each pose in turn; not checked: {}\n",
        verified(&done.report),
        counted(done.runs, "print"),
        rules.join(", ")
    )
}

/// Lines nearer to each other than this may fuse, mm: a quarter of a line.
const FUSING_MM: f64 = 0.1;

/// Parts that never touch, and how near their lines come, in a sentence.
pub(super) fn joints(report: &Report) -> Option<String> {
    let JointRoom { parts: [a, b], gap_mm, line, .. } = report.joints.first()?;
    let fused = match gap_mm {
        gap if *gap <= 0.0 => "; they fuse there",
        gap if *gap < FUSING_MM => "; they may fuse there",
        _ => "",
    };
    let joints = counted(report.joints.len(), "joint");
    Some(format!("{joints}, least gap {gap_mm:.2} mm between the lines of parts {a} and {b} (line {line}){fused}"))
}

/// The surface of two parts that is filled least, in a sentence.
fn bonds(report: &Report) -> Option<String> {
    let InterfaceFill { parts: [a, b], area_mm2, share, .. } = report.interfaces.first()?;
    let which = if report.interfaces.len() > 1 { "least filled interface" } else { "interface" };
    let filled = share * 100.0;
    Some(format!("the {which} (parts {a} and {b}, {area_mm2:.0} mm2) is {filled:.0} % filled from both sides"))
}

/// A setting of which the file states less than the profile has, in a sentence.
fn stated(StatedSetting { setting, file, profile, parts }: &StatedSetting) -> String {
    let which = if parts.len() == 1 { "part" } else { "parts" };
    format!("{which} {}: checked with {setting} = {file}, as the file states (profile: {profile})", list(parts))
}

/// What the table has to do, in a sentence; `None` where it never turns between lines.
fn turning(report: &Report) -> Option<String> {
    let TableUse { turns, waiting_s, longest_s, longest_line, wound_turns, torque_nm, .. } = report.table;
    (turns > 0).then(|| {
        format!(
            "{} of the table, {waiting_s:.0} s with a hot nozzle (longest {longest_s:.0} s, before line {longest_line}); cables are wound \
             {wound_turns:.2} turns; {torque_nm:.3} N m on the tilt axis",
            counted(turns, "turn")
        )
    })
}

/// What stands, but not well, in a sentence.
pub(super) fn unsteady(report: &Report) -> Option<String> {
    let Standing { pushed_factor, line, tilt_deg, grams, .. } = report.standing.as_ref()?;
    let tilt = if *tilt_deg > 0.0 { format!(", with the table tilted by {tilt_deg:.0} deg") } else { String::new() };
    (*pushed_factor < DOUBTFUL).then(|| {
        format!(
            "after line {line} the first layer holds {grams:.1} g with a safety factor of only {pushed_factor:.1} (recommended: {DOUBTFUL}){tilt}; \
             use a larger footprint or a brim (not counted)"
        )
    })
}

pub(super) fn list(parts: &[usize]) -> String {
    parts.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}
