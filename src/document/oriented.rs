//! Orientations of parts.

use serde_json::{Value, json};

use super::priced::{plain, recommendation};
use crate::job::{Compared, OrientResult, Oriented, OrientedPart};
use crate::orient::{Minimum, Stop, to_angles};

/// `trunnion orient`: the model as it was given, and its parts.
pub fn orientations(model: &str, done: &OrientResult) -> Value {
    json!({"model": model, "parts": done.parts.iter().map(oriented).collect::<Vec<_>>()})
}

/// `trunnion orient`, one part: the minima of each objective, what is proved of them, figures beside each other.
pub fn oriented(part: &OrientedPart) -> Value {
    let results: Vec<Value> = part.results.iter().map(found).collect();
    let mut document = json!({"id": part.id, "facets": part.mesh.facets().len(), "results": results});
    if let Some(rows) = &part.compared {
        let row = |row: &Compared| {
            let mut document = json!({"orientation": row.name, "up": plain(&row.up)});
            figures(row).into_iter().for_each(|(_, key, value)| document[key] = value.into());
            document
        };
        document["compare"] = rows.iter().map(row).collect();
    }
    document
}

fn found(result: &Oriented) -> Value {
    // Minus nothing is nothing: `+ 0.0` takes the sign off.
    let minimum = |m: &Minimum| {
        let (alpha, beta) = to_angles(&m.up);
        json!({
            "value": m.value + 0.0, "up": plain(&m.up), "kind": result.kind(m),
            "alpha_deg": alpha.to_degrees() + 0.0, "beta_deg": beta.to_degrees() + 0.0,
        })
    };
    let found = &result.found;
    let stop = if found.stop == Stop::Converged { "converged" } else { "budget" };
    let mut document = json!({
        "objective": result.objective, "method": result.method,
        "minima": found.minima.iter().map(minimum).collect::<Vec<_>>(),
        "lower_bound": found.lower_bound, "stop": stop, "evaluations": found.evaluations, "seconds": result.seconds,
    });
    if let Some(why) = &result.unproved {
        document["unproved"] = why.as_str().into();
    }
    if let Some(value) = result.finer {
        document["best_finer"] = (value + 0.0).into();
    }
    if let Some((made, process)) = &result.recommendation {
        recommendation(made, process, &mut document);
    }
    document
}

/// The figures of one orientation: heading of a table, key, value.
pub fn figures(row: &Compared) -> [(&'static str, &'static str, f64); 6] {
    [
        ("support mm3", "support_volume_mm3", row.support_mm3),
        ("overhang mm2", "overhang_area_mm2", row.overhang_mm2),
        ("staircase mm4", "staircase_mm4", row.staircase_mm4),
        ("height mm", "height_mm", row.height_mm),
        ("contact mm2", "contact_area_mm2", row.contact_mm2),
        ("tipping deg", "tipping_deg", row.tipping_deg),
    ]
}
