//! Why there is no plan, and what would help: as a list for people, or as the document.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::{Value, json};

use super::{Console, Failure};
use crate::job::{NoPlan, Output};
use crate::mesh::Model;
use crate::planning::{Reason, Remedy, can_be_helped};

/// Prints reasons and remedies; what no remedy can help is left to the error's own sentence.
pub(super) fn explain(no: &NoPlan, picture: Option<&Output>, console: &Console) -> Result<(), Failure> {
    if !can_be_helped(&no.infeasible) {
        return Ok(());
    }
    if let Some((picture, sheet)) = picture.zip(no.sheet()) {
        picture.write(sheet.as_bytes())?;
    }
    let (reasons, least) = no.reasons();
    let sought = no.remedies.is_some();
    let remedies = no.remedies.as_deref().unwrap_or_default();
    if console.json() {
        console.document(&document(&no.infeasible.to_string(), reasons, least, remedies));
    } else {
        console.note(text(&no.model.model, reasons, least, sought, remedies).trim_end());
    }
    Ok(())
}

fn document(summary: &str, reasons: &[Reason], least: bool, remedies: &[Remedy]) -> Value {
    let reason = |r: &Reason| json!({"part": r.part, "orientation": r.up, "blocked_by": r.blocked_by, "depth_mm": r.depth_mm, "text": r.text});
    let remedy = |r: &Remedy| json!({"kind": r.kind, "amount": r.amount, "text": r.text});
    json!({
        "feasible": false,
        "summary": summary,
        "reasons": reasons.iter().map(reason).collect::<Vec<_>>(),
        "least": least,
        "remedies": remedies.iter().map(remedy).collect::<Vec<_>>(),
    })
}

/// Per part: how many orientations each thing stands against, with the nearest miss of each.
fn text(model: &Model, reasons: &[Reason], least: bool, sought: bool, remedies: &[Remedy]) -> String {
    let mut out = String::new();
    let mut by_part: BTreeMap<usize, BTreeMap<&str, Vec<&Reason>>> = BTreeMap::new();
    for reason in reasons {
        by_part.entry(reason.part).or_default().entry(&reason.blocked_by).or_default().push(reason);
    }
    if least && !by_part.is_empty() {
        let _ = writeln!(out, "each of these is needed to rule a plan out:");
    }
    for (part, by) in &by_part {
        let _ = writeln!(out, "  part {part} ({})", model.parts[*part].name);
        for (blocked_by, of_this) in by {
            // The ways with the least against them come first.
            let Some(nearest) = of_this.first() else { continue };
            let [x, y, z] = nearest.up.map(|v| if v.abs() < 5e-4 { 0.0 } else { v });
            let what = match blocked_by.parse::<usize>() {
                Ok(other) => format!("part {other}"),
                Err(_) => (*blocked_by).to_owned(),
            };
            let count = of_this.len();
            let _ =
                writeln!(out, "    {what}, {count} orientations; with up ({x:.3}, {y:.3}, {z:.3}): {}", nearest.text);
        }
    }
    match (sought, remedies.is_empty()) {
        (true, false) => {
            let _ = writeln!(out, "checked remedies, each by itself:");
            remedies.iter().for_each(|r| _ = writeln!(out, "  {}", r.text));
        }
        (true, true) => {
            let _ = writeln!(
                out,
                "none of the remedies that were tried helps: tilt, head, nozzle, pedestal, margin, support, base"
            );
        }
        _ => {}
    }
    out
}
