//! Calibration: what touches say of a machine, and which are to be made.

use std::path::Path;

use serde_json::{Value, json};

use crate::calibrate::{Deviation, Dimension, Estimate, Outlier, TowerDeviation};
use crate::job::{CalibrateResult, Calibrated, PosesResult, TowerReading, TowerResult};

/// `trunnion profile calibrate TOUCHES`. `differs` and `error_95` are mm, or degrees where `unit` says so.
pub fn calibrated(done: &CalibrateResult) -> Value {
    let fit = &done.fit;
    let estimate = |e: &Estimate| {
        let unit = if e.unknown.is_angle() { "deg" } else { "mm" };
        json!({"unknown": e.name, "differs": e.differs, "error_95": e.error, "unit": unit, "in_profile": done.is_written(e.unknown)})
    };
    let deviation = |d: &Deviation| {
        json!({
            "touch": d.number, "line": d.line, "of": done.touches.name(d.of), "tilt_deg": d.words_deg[0],
            "rotation_deg": d.words_deg[1], "off_mm": d.off_mm,
        })
    };
    let outlier = |o: &Outlier| json!({"touch": o.number, "line": o.line, "off_mm": o.off_mm});
    let ((pivot, offset, [tilt, rotation]), along) = (done.keys(), done.along());
    json!({
        "profile": done.machine.name, "touches": fit.deviations.len(), "without_at_mm": done.touches.empty,
        "ok": done.refusal().is_none(), "refused": done.refusal(),
        "pivot_mm": pivot, "offset_mm": offset, "tilt_zero_deg": tilt, "rotation_zero_deg": rotation,
        "tilt_along": along.map(|[tilt, _]| tilt), "rotation_along": along.map(|[_, rotation]| rotation),
        "estimates": fit.estimates.iter().map(estimate).collect::<Vec<_>>(),
        "sag_mm": fit.sag.map(|sag| sag.mm), "sag_error_95": fit.sag.map(|sag| sag.error_mm),
        "bend_mm": fit.bend.as_ref().map(|b| b.mm), "surface_mm": fit.bend.as_ref().map(|b| b.surface_mm),
        "places": fit.places.iter().map(|(name, at)| json!({"name": name, "table_mm": at})).collect::<Vec<_>>(),
        "rms_mm": fit.rms_mm, "degrees_of_freedom": fit.freedom,
        "outliers": fit.outliers.iter().map(outlier).collect::<Vec<_>>(),
        "deviations": fit.deviations.iter().map(deviation).collect::<Vec<_>>(),
    })
}

/// `trunnion profile calibrate --poses`.
pub fn poses(done: &PosesResult) -> Value {
    let of = |of| match of {
        crate::calibrate::Of::Table => "table",
        crate::calibrate::Of::Feature(index) => &*done.choice.marks[index].0,
    };
    let pose = |one: &crate::calibrate::ChainCandidate| {
        json!({
            "of": of(one.of), "tilt_deg": one.words_deg[0], "rotation_deg": one.words_deg[1],
            "near_mm": one.tip.as_slice(),
        })
    };
    let error = |(name, error, angle): &(String, f64, bool)| json!({"unknown": name, "standard_error": error, "unit": if *angle { "deg" } else { "mm" }});
    json!({
        "profile": done.machine.name, "enough": done.choice.enough,
        "poses": done.choice.poses.iter().map(pose).collect::<Vec<_>>(),
        "marks": done.choice.marks.iter().map(|(name, at)| json!({"name": name, "table_mm": at})).collect::<Vec<_>>(),
        "errors": done.choice.errors.iter().map(error).collect::<Vec<_>>(),
        "visit": done.visit.as_ref().map_or_else(
            |why| json!({"error": why}),
            |v| json!({"height_mm": v.height_mm, "left_out": v.left_out}),
        ),
    })
}

/// `trunnion profile calibrate MEASUREMENTS`: of touches or of a tower.
pub fn measured(done: &Calibrated) -> Value {
    match done {
        Calibrated::Touches(done) => calibrated(done),
        Calibrated::Tower(done) => tower_read(done),
    }
}

/// `trunnion profile calibrate --tower FOLDER`. `standard_error` is mm, or degrees where `unit` says so.
pub fn tower(done: &TowerResult, folder: &Path) -> Value {
    let file = |name: &str| folder.join(name).display().to_string();
    let dimension = |one: &Dimension| json!({"number": one.number, "between": one.name, "drawn_mm": one.drawn_mm});
    let error = |(name, error, angle): &(String, Option<f64>, bool)| json!({"unknown": name, "standard_error": error, "unit": if *angle { "deg" } else { "mm" }});
    let [[level, first], [_, second], [tilt, _], _] = done.tower.words_deg();
    json!({
        "profile": done.machine.name, "tilt_deg": tilt, "level_deg": level, "rotation_deg": [first, second],
        "gcode": file("tower.gcode"), "plan": file("tower.json"), "model": file(TowerResult::MODEL),
        "sheet": file("sheet.svg"), "form": file("measured.toml"), "seconds_print": done.seconds(),
        "dimensions": done.tower.dimensions.iter().map(dimension).collect::<Vec<_>>(),
        "errors": done.errors.iter().map(error).collect::<Vec<_>>(),
    })
}

fn tower_read(done: &TowerReading) -> Value {
    let fit = &done.fit;
    let estimate = |e: &Estimate| {
        let unit = if e.unknown.is_angle() { "deg" } else { "mm" };
        json!({"unknown": e.name, "differs": e.differs, "error_95": e.error, "unit": unit})
    };
    let deviation =
        |d: &TowerDeviation| json!({"number": d.number, "read_mm": d.mm, "drawn_mm": d.drawn_mm, "off_mm": d.off_mm});
    let (pivot, offset, [tilt, rotation]) = done.written().keys();
    json!({
        "profile": done.machine.name, "ok": done.unfit.is_none(), "refused": done.unfit,
        "readings": done.readings.readings.len(), "left_out": done.readings.left_out,
        "pivot_mm": pivot, "offset_mm": offset, "tilt_zero_deg": tilt, "rotation_zero_deg": rotation,
        "estimates": fit.estimates.iter().map(estimate).collect::<Vec<_>>(),
        "undetermined": fit.undetermined,
        "wider_mm": fit.wider_mm.map(|[mm, _]| mm), "wider_error_95": fit.wider_mm.map(|[_, error]| error),
        "began_above_mm": fit.began_above.iter().map(|(block, mm)| json!({"block": block, "mm": mm})).collect::<Vec<_>>(),
        "rms_mm": fit.rms_mm, "degrees_of_freedom": fit.freedom,
        "deviations": fit.deviations.iter().map(deviation).collect::<Vec<_>>(),
    })
}
