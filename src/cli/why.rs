//! Why there is no plan, and what would help: as a list for people, or as the document.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};

use super::{Console, Failure, files};
use crate::orient::Direction;
use crate::planning::{Infeasible, Options, Reason, Remedy, Wish, Workpiece, can_be_helped, sheet_of_reasons};
use crate::profile::Profile;

/// Prints reasons and remedies; what no remedy can help is left to the error's own sentence.
pub(super) fn explain(
    no: &Infeasible,
    (workpiece, profile): (&Workpiece<'_>, &Profile),
    (directions, options): (&[Vec<Direction>], &Options<'_>),
    (seek, picture): (bool, Option<&Path>),
    console: &Console,
) -> Result<(), Failure> {
    if !can_be_helped(no) {
        return Ok(());
    }
    let (reasons, least): (&[Reason], bool) = match no {
        Infeasible::NoPlan { reasons, least, .. } => (reasons, *least),
        _ => (&[], false),
    };
    if let (Some(path), false) = (picture, reasons.is_empty()) {
        files::write(path, sheet_of_reasons(reasons, workpiece, profile).as_bytes())?;
    }
    let mut concerned: Vec<usize> = reasons.iter().map(|r| r.part).collect();
    concerned.sort_unstable();
    concerned.dedup();
    let wish = Wish { workpiece, profile, directions, options, concerned: &concerned };
    let remedies = if seek {
        let progress = console.progress("remedies", 8);
        let mut done = 0;
        wish.remedies(|_| {
            done += 1;
            progress.at(done);
        })
    } else {
        Vec::new()
    };
    if console.json() {
        console.document(&document(&no.to_string(), reasons, least, &remedies));
    } else {
        console.note(text(workpiece, reasons, least, seek, &remedies).trim_end());
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
fn text(workpiece: &Workpiece<'_>, reasons: &[Reason], least: bool, sought: bool, remedies: &[Remedy]) -> String {
    let mut out = String::new();
    let mut by_part: BTreeMap<usize, BTreeMap<&str, Vec<&Reason>>> = BTreeMap::new();
    for reason in reasons {
        by_part.entry(reason.part).or_default().entry(&reason.blocked_by).or_default().push(reason);
    }
    if least && !by_part.is_empty() {
        let _ = writeln!(out, "each of these is needed to rule a plan out:");
    }
    for (part, by) in &by_part {
        let _ = writeln!(out, "  part {part} ({})", workpiece.model.parts[*part].name);
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
