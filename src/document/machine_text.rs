//! Machines for people: what a profile describes, what touches say of it, and its rehearsal.

use std::fmt::Write;

use super::jog_text::unseen;
use crate::calibrate::Unknown;
use crate::gcode::round_to;
use crate::job::{CalibrateResult, CheckedProfile, DryRun, PosesResult, Tilted};
use crate::motion::TiltAbout;
use crate::profile::Sight;
use crate::spelling::counted;

/// A table of the tilts, and what they come to.
pub fn checked(machine: &CheckedProfile) -> String {
    let profile = &machine.machine.profile;
    let letter = profile.kinematics.tilt.letter;
    let fine = if machine.refusals.is_empty() { "fine" } else { "not usable as it is" };
    let mut out = format!("{}: {fine}\n\n", machine.machine.name);
    let leans = profile.kinematics().head.is_some();
    let middle = if leans { "tip on the table's middle, axes" } else { "table middle" };
    for at in &machine.tilts {
        let [x, y, z] = at.centre_mm.map(|mm| round_to(mm, 2) + 0.0);
        let side = if at.room_mm < 0.0 { "above" } else { "below" };
        let beyond = if at.within { "" } else { ", beyond the axis limits" };
        let _ = writeln!(
            out,
            "{letter}{:.2}: {middle} at X {x} Y {y} Z {z}{beyond}; highest point of the table at Z {:.1}, {:.1} mm {side} the upper Z limit; reach \
             on the bare table: {}",
            at.tilt_deg,
            at.top_mm,
            at.room_mm.abs(),
            reached(machine, at)
        );
    }
    let [wide, high] = machine.largest_level_mm;
    let _ = writeln!(out, "\nlargest object on the level table: {wide:.1} mm across, {high:.1} mm high");
    let _ = match machine.largest_any_mm {
        mm if mm < 1.0 => {
            writeln!(out, "no object in the middle of the table stays within the axis limits at every tilt")
        }
        mm => {
            writeln!(out, "largest object within the axis limits at every tilt: {mm:.1} mm across and {mm:.1} mm high")
        }
    };
    let top = profile.limits.z_mm[1];
    let room = top - machine.sweeps_to_mm;
    let _ = match profile.kinematics().head {
        Some(_) => writeln!(
            out,
            "leaning as far as it can, the head reaches down to the bare table with Z at {:.1}; its highest position is Z {top}",
            machine.sweeps_to_mm
        ),
        None => writeln!(
            out,
            "while the table turns, the bare table sweeps up to Z {:.1}; the tip's highest position (Z {top}) is {}",
            machine.sweeps_to_mm,
            if room >= 0.0 { format!("{room:.1} mm above that") } else { format!("{:.1} mm below that", -room) }
        ),
    };
    if machine.axes_off_deg != [0.0; 2] {
        let ([tilt, rotation], k) = (machine.axes_off_deg, &profile.kinematics);
        let about = if profile.kinematics().about == TiltAbout::X { 'X' } else { 'Y' };
        // Half a turn takes the surface twice as far out of level as the axis leans.
        let rim = profile.table_reach_mm() * (2.0 * rotation.to_radians()).sin();
        let (turn, [a, c]) = (k.rotation.letter, [k.tilt.zero_deg, k.rotation.zero_deg]);
        let _ = writeln!(
            out,
            "{letter} points {tilt:.2} deg from {about} and {turn} {rotation:.2} deg from Z; level at {letter}{a} {turn}{c}, the table's rim \
             rises and falls by up to {rim:.2} mm as {turn} turns"
        );
    }
    out.push_str(if leans {
        "compare these with the machine: lean the head to each, and touch the table's middle with the nozzle"
    } else {
        "compare these with the machine: tilt the table to each, and touch its middle with the nozzle"
    });
    if let Sight::Seen(date) = profile.sight() {
        let _ = write!(
            out,
            "\nthe axes were seen to move so on {date}: {}",
            profile.machine.jogged_as.clone().unwrap_or_default()
        );
    }
    if let Some(text) = unseen(profile, &machine.machine.name) {
        let _ = write!(out, "\n{text}");
    }
    out
}

fn reached(machine: &CheckedProfile, at: &Tilted) -> String {
    let near = 2.5 * machine.place_mm();
    let side = |mm: f64| if mm < 0.0 { "below" } else { "above" };
    match at.reached_mm {
        None => "none straight up or down from the middle".to_owned(),
        Some([low, high]) if low <= near - machine.half_mm && high >= machine.half_mm - near => "all of it".to_owned(),
        Some([low, high]) => {
            format!("from {:.0} mm {} the middle to {:.0} mm {} it", low.abs(), side(low), high.abs(), side(high))
        }
    }
}

/// The unknowns with their errors, then the touches, the worst first.
pub fn calibrated(result: &CalibrateResult) -> String {
    let fit = &result.fit;
    let mut out = format!("{}: {} used", result.file, counted(fit.deviations.len(), "touch"));
    if !result.touches.empty.is_empty() {
        let _ = write!(out, ", {} without at_mm ignored", result.touches.empty.len());
    }
    let _ = writeln!(out, "; {} degrees of freedom", fit.freedom);
    let _ = writeln!(out, "\n{:54} differs from {} by      known to (95 %)", "", result.machine.name);
    for e in &fit.estimates {
        let unit = if e.unknown.is_angle() { "deg" } else { "mm" };
        let _ = writeln!(out, "{:54} {:+12.4} {unit:3}      +- {:.4}", e.name, e.differs, e.error);
    }
    if !fit.estimates.iter().any(|e| e.unknown == Unknown::RotationZero) {
        let letter = result.machine.profile.kinematics.rotation.letter;
        let _ = writeln!(out, "{:54} as in the profile: no mark has a table_mm", format!("zero of {letter}"));
    }
    if let Some(bend) = &fit.bend {
        let (mm, allowed) = (bend.mm, result.allowed_mm);
        let _ = match fit.misaligned {
            true => writeln!(
                out,
                "\nthe axes differ from {}: without their measured directions (along), points on or over the table would be off by up to \
                 {mm:.3} mm",
                result.machine.name
            ),
            false => writeln!(
                out,
                "\nthe axes agree with {}: the measured directions move points on or over the table by {mm:.3} mm; changes below {allowed} mm \
                 (--tolerance) are not written",
                result.machine.name
            ),
        };
        let _ =
            writeln!(out, "with both rotary axes at zero, the table's rim is {:.3} mm out of level", bend.surface_mm);
    }
    let _ = match fit.sag {
        Some(sag) => {
            let side = if sag.mm < 0.0 { "higher" } else { "lower" };
            let (mm, error) = (sag.mm.abs(), sag.error_mm);
            writeln!(out, "the table's rim is {mm:.3} mm (+- {error:.3}) {side} than its middle")
        }
        None => {
            writeln!(
                out,
                "whether the table sags is unknown: these touches do not determine it; add touches near its middle"
            )
        }
    };
    for (name, [x, y, z]) in &fit.places {
        let _ = writeln!(out, "{name}: on the table at X {x:.3} Y {y:.3} Z {z:.3}");
    }
    let _ = writeln!(out, "\nRMS deviation {:.4} mm; the largest deviations:", fit.rms_mm);
    let mut worst: Vec<_> = fit.deviations.iter().collect();
    worst.sort_by(|a, b| b.off_mm.abs().total_cmp(&a.off_mm.abs()));
    for d in worst.iter().take(5) {
        let [a, c] = d.words_deg;
        let name = result.touches.name(d.of);
        let _ = writeln!(out, "  touch {:3} (line {}), {name} at {a} {c}: {:+.4} mm", d.number, d.line, d.off_mm);
    }
    out
}

/// What there is to do.
pub fn poses(result: &PosesResult) -> String {
    let mut out = format!("{} to make on {}\n", counted(result.choice.poses.len(), "touch"), result.machine.name);
    for (name, [x, y]) in &result.choice.marks {
        let _ = writeln!(
            out,
            "{name}: level the table, turn the rotation to zero, and draw a small cross near X{x} Y{y} (table coordinates)"
        );
    }
    if !result.choice.enough {
        out.push_str(
            "more touches are needed for the accuracy aimed at, but --most or the head's reach does not allow them\n",
        );
    }
    let mm = result.repeats_to_mm;
    let _ = writeln!(out, "expected standard errors, for touches that repeat to {mm} mm (--repeats-to):");
    for (name, error, angle) in &result.choice.errors {
        let _ = writeln!(out, "  {name:54} {error:.4} {}", if *angle { "deg" } else { "mm" });
    }
    out
}

/// What it is, in words.
pub fn cold(run: &DryRun) -> String {
    let places = run.poses.iter().map(|pose| pose.places.len()).sum();
    let left_out = match &run.left_out[..] {
        [] => String::new(),
        lines => format!("; omitted start-code lines: {}", lines.join(", ")),
    };
    let (poses, places) = (counted(run.poses.len(), "pose"), counted(places, "place"));
    format!(
        "dry run: {poses} with a stop at each; the tip goes to 20 mm above {places}, or less where Z ends{left_out}"
    )
}
