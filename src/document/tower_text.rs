//! A calibration tower for people: what was made, and what its measurements say.

use std::fmt::Write;
use std::path::Path;

use super::jog_text::unseen;
use crate::job::{Calibrated, TowerReading, TowerResult};

/// Steeper towers want axes that are known well, degrees.
const FIRST_TILT_DEG: f64 = 20.0;
/// A block that began further from what it stands on says little, mm.
const ROUGH_MM: f64 = 0.4;

/// What a file of measurements says, of touches or of a tower.
pub fn measured(done: &Calibrated) -> String {
    match done {
        Calibrated::Touches(done) => super::machine_text::calibrated(done),
        Calibrated::Tower(done) => read(done),
    }
}

/// The files, how long it prints, and what it will tell.
pub fn tower(done: &TowerResult, folder: &Path) -> String {
    let [[level, first], [_, second], [tilt, _], _] = done.tower.words_deg();
    let k = &done.machine.profile.kinematics;
    let [a, c] = [k.tilt.letter, k.rotation.letter];
    let minutes = (done.seconds() / 60.0).ceil();
    let mut out = format!(
        "a tower for {}: printed at {a}{level} and {a}{tilt}, each at {c}{first} and {c}{second}; {minutes:.0} minutes, verified\n",
        done.machine.name
    );
    let name = |name: &str| folder.join(name).display().to_string();
    for (file, what) in [
        ("tower.gcode", "print it, with tower.json as its plan"),
        ("sheet.svg", "which dimension is which"),
        ("measured.toml", "fill in what the callipers show"),
    ] {
        let _ = writeln!(out, "{}: {what}", name(file));
    }
    if (tilt - level).abs() > FIRST_TILT_DEG {
        let first = level + FIRST_TILT_DEG.copysign(tilt - level);
        let _ = writeln!(
            out,
            "at this tilt the axes must be known to about 0.5 mm, or the head is pressed into the tower; if they are not, print one with --tilt {first} first"
        );
    }
    if let Some(unseen) = unseen(&done.machine.profile, &done.machine.name) {
        let _ = writeln!(out, "{unseen}");
    }
    let _ = writeln!(out, "expected standard errors, for two readings of each dimension:");
    for (name, error, angle) in &done.errors {
        let unit = if *angle { "deg" } else { "mm" };
        let error = error.map_or_else(|| "not determined".to_owned(), |error| format!("{error:.4} {unit}"));
        let _ = writeln!(out, "  {name:54} {error}");
    }
    let _ = write!(out, "next: trunnion profile calibrate {} -m {}", name("measured.toml"), done.machine.name);
    out
}

fn read(done: &TowerReading) -> String {
    let fit = &done.fit;
    let (count, name) = (done.readings.readings.len(), &done.machine.name);
    let mut out = format!("{}: {count} readings; {} degrees of freedom\n", done.file, fit.freedom);
    let _ = writeln!(out, "\n{:54} differs from {name} by      known to (95 %)", "");
    for e in &fit.estimates {
        let unit = if e.unknown.is_angle() { "deg" } else { "mm" };
        let _ = writeln!(out, "{:54} {:+12.4} {unit:3}      +- {:.4}", e.name, e.differs, e.error);
    }
    for name in &fit.undetermined {
        let _ = writeln!(out, "{name:54} not determined by these measurements");
    }
    out.push_str("the level table stays as high as it is; the axes' directions are taken from the profile\n");
    if let Some([mm, error]) = fit.wider_mm {
        let _ = writeln!(
            out,
            "widths over two walls are {mm:+.3} mm (+- {error:.3}) from what was drawn; this does not count above"
        );
    }
    let _ = writeln!(
        out,
        "\nRMS deviation {:.3} mm of readings that should repeat to {} mm:",
        fit.rms_mm, done.readings.repeats_mm
    );
    for d in &fit.deviations {
        let _ = writeln!(
            out,
            "  dimension {:2}: read {:6.2}, drawn {:6.2}, left {:+.3} mm",
            d.number, d.mm, d.drawn_mm, d.off_mm
        );
    }
    let rough = |&&(_, mm): &&(&str, f64)| mm.abs() > ROUGH_MM;
    if let Some((block, mm)) = fit.began_above.iter().filter(rough).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) {
        let how = if *mm > 0.0 { "began above" } else { "was pressed into" };
        let _ = writeln!(
            out,
            "\n{block} {how} what it stands on by {:.2} mm; print the tower again with the new profile to be sure",
            mm.abs()
        );
    }
    out
}
