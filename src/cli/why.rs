//! Why there is no plan, and what would help: as a list for people, or as the document.

use std::fmt::Write;

use super::{Console, Failure};
use crate::document;
use crate::job::{Hindrance, NoPlan, OutputFile};
use crate::planning::can_be_helped;

/// Prints reasons and remedies; what no remedy can help is left to the error's own sentence.
pub(super) fn explain(no: &NoPlan, picture: Option<&OutputFile>, console: &Console) -> Result<(), Failure> {
    if !can_be_helped(&no.infeasible) {
        return Ok(());
    }
    if let Some((picture, sheet)) = picture.zip(no.sheet()) {
        picture.write(sheet.as_bytes())?;
    }
    if console.json() {
        console.document(&document::no_plan(no));
    } else {
        console.note(text(no).trim_end());
    }
    Ok(())
}

/// Per part: how many orientations each thing stands against, with the nearest miss of each.
fn text(no: &NoPlan) -> String {
    let mut out = String::new();
    let hindrances = no.hindrances();
    if no.reasons().1 && !hindrances.is_empty() {
        let _ = writeln!(out, "each of these is needed to rule a plan out:");
    }
    let mut last = None;
    for Hindrance { part, orientations, nearest } in hindrances {
        if last.replace(part) != Some(part) {
            let _ = writeln!(out, "  part {part} ({})", no.model.model.parts[part].name);
        }
        let [x, y, z] = nearest.up.map(|v| if v.abs() < 5e-4 { 0.0 } else { v });
        let by = &nearest.blocked_by;
        let what = by.parse::<usize>().map_or_else(|_| by.clone(), |other| format!("part {other}"));
        let text = &nearest.text;
        let _ = writeln!(out, "    {what}, {orientations} orientations; with up ({x:.3}, {y:.3}, {z:.3}): {text}");
    }
    no.cut.iter().for_each(|why| _ = writeln!(out, "cut by planes: {why}"));
    let Some(remedies) = &no.remedies else { return out };
    if remedies.is_empty() {
        out.push_str(
            "none of the remedies that were tried helps: tolerance, bridges, tilt, height, head, nozzle, pedestal, margin, support, base\n",
        );
    } else {
        out.push_str("remedies, each by itself, all but cuts checked by planning:\n");
        remedies.iter().for_each(|r| _ = writeln!(out, "  {}", r.text));
    }
    out
}
