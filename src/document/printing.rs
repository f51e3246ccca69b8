//! Slices, verified programs, and what happens while one is sent.

use serde_json::{Value, json};

use super::model::split;
use super::planned::{planned, ways};
use crate::calibrate::ColdPose;
use crate::job::{
    At, Bed, CheckedProfile, CutSolid, DryRun, HeldPart, ImportedProfile, JogChange, JogResult, MachineError,
    PlateEvent, PrepareResult, RefereeResult, Rehearsal, Rejected, Seconds, Sending, SlicerName, Tilted,
};
use crate::planning::PrintSupports;
use crate::profile::{Fact, Profile, Sight, StatedAt};
use crate::slicing::Flaw;
use crate::verify::{Refereed, Report};

/// `trunnion verify`: the report, with the seconds it took.
pub fn verified(report: &Report, seconds: f64) -> Value {
    let mut document = json!(report);
    document["seconds"] = seconds.into();
    document
}

/// `trunnion verify` without a plan: as [`verified`], with what was not judged.
pub fn refereed(done: &RefereeResult) -> Value {
    let Refereed { report, runs, not_judged } = &done.refereed;
    json!({"report": verified(report, done.seconds), "runs": runs, "not_judged": not_judged})
}

/// `trunnion rewrite`: the proof of the file that was written.
pub fn rewritten(report: &Report, seconds: f64) -> Value {
    json!({"verify": verified(report, seconds)})
}

/// `trunnion rewrite --in-place` of a file that an earlier call has finished.
pub fn left_alone() -> Value {
    json!({"finished": true})
}

/// A program that was not written, with its findings; where several ways came to nothing, those.
pub fn rejected(rejected: &Rejected) -> Value {
    let mut document = rewritten(&rejected.report, rejected.seconds);
    document["code"] = "verify/findings".into();
    if !rejected.ways.is_empty() {
        document["ways"] = ways(&rejected.ways);
    }
    document
}

/// `trunnion prepare`: the file written as `output`, its plan, its proof, and how long each step took.
pub fn prepared(output: &str, done: &PrepareResult, report: &Report) -> Value {
    let Seconds { read, orient, plan, slice, rewrite, verify } = done.seconds;
    json!({
        "output": output,
        "plan": planned(&done.planned),
        "verify": verified(report, verify),
        "cut": done.cut.as_ref().map(|cut| {
            // Copies were cut alike; of several solids each has a document of its own.
            let mut solids: Vec<Value> = cut.solids.iter().map(of_solid).collect();
            let mut document = if solids.len() == 1 { solids.remove(0) } else { json!({"solids": solids}) };
            document["file"] = cut.file.as_str().into();
            document["reason"] = cut.why.to_string().into();
            document["seconds_print"] = report.seconds_print.into();
            document["filament_mm"] = report.filament_mm.into();
            document
        }),
        "supports": done.held.as_ref().map(|held| json!({
            "parts": held.parts.iter().map(of_held).collect::<Vec<_>>(),
            "volume_mm3": held.volume_mm3(), "seconds": held.seconds(), "reason": held.why.to_string(),
        })),
        "ways": ways(&done.planned.ways),
        "slicer": slicer(&done.slicer),
        "left_out": left_out(&done.flaws),
        "warnings": done.warnings,
        "seconds": {
            "read": read, "orient": orient, "plan": plan, "slice": slice, "rewrite": rewrite, "verify": verify,
        },
    })
}

/// `prepare --plates`: a plate that was written, with its model, what is on it, and how often it is to be printed.
pub fn plate(event: &PlateEvent<'_>) -> Option<Value> {
    let PlateEvent::Made { output, model, plate, done } = event else { return None };
    let mut made = prepared(&output.display().to_string(), done, done.gcode.report()?);
    made["dry_run"] = Value::Null;
    let holds = plate.holds.iter().map(|(file, count)| json!({"model": file, "count": count}));
    let holds: Vec<Value> = holds.collect();
    Some(json!({"model": model.display().to_string(), "holds": holds, "times": plate.times, "prepared": made}))
}

/// `prepare --plates`: all plates.
pub fn plates(each: Vec<Value>) -> Value {
    json!({"plates": each})
}

/// `prepare --dry-run`: the poses of the rehearsal, and the outermost places of the tip at each, machine coordinates, mm.
pub fn cold(made: &DryRun) -> Value {
    let pose = |pose: &ColdPose| json!({"name": pose.name, "words_deg": pose.words_deg, "places_mm": pose.places.iter().map(|p| p.as_slice()).collect::<Vec<_>>()});
    json!({"poses": made.poses.iter().map(pose).collect::<Vec<_>>(), "left_out": made.left_out})
}

/// Solids that were cut alike.
fn of_solid(solid: &CutSolid) -> Value {
    let mut document = split(&solid.split);
    document["of_parts"] = solid.parts.as_slice().into();
    for (k, pin) in solid.pins.iter().enumerate() {
        document["planes"][k]["pin"] = pin.words().into();
    }
    document
}

/// The supports of one part.
fn of_held(held: &HeldPart) -> Value {
    let PrintSupports { step_mm, overhang_deg, gap_mm, roof, brace_mm, only_props, ref props } = held.supports;
    json!({
        "part": held.part, "step_mm": step_mm, "gap_mm": gap_mm, "overhang_deg": overhang_deg, "volume_mm3": held.volume_mm3,
        "seconds": held.seconds, "brace_mm": brace_mm, "longest_free_mm": held.longest_free_mm, "props": props.len(), "only_props": only_props,
        "roof": roof.map(|roof| json!({"height_mm": roof.height_mm, "pitch_mm": roof.pitch_mm})),
    })
}

/// `trunnion slice`: the files written, and by whom they were sliced, if they were.
pub fn sliced(written: &[String], by: Option<&SlicerName>, bed: &Bed, flaws: &[(String, Flaw)]) -> Value {
    let warnings: Vec<String> = flaws.iter().map(|(name, flaw)| format!("{name}: {flaw}")).collect();
    json!({
        "files": written, "slicer": by.map(slicer), "bed_mm": bed.size_mm(), "bed_from_mm": bed.min_mm, "left_out": left_out(flaws), "warnings": warnings,
    })
}

/// What was too narrow to print: of which print, how much, and where in its own mesh.
fn left_out(flaws: &[(String, Flaw)]) -> Vec<Value> {
    let one = |(name, flaw): &(String, Flaw)| match flaw {
        Flaw::LeftOut(left) => Some(json!({
            "print": name, "volume_mm3": left.volume_mm3, "share": left.share, "layers": left.layers, "at_mm": left.at_mm,
            "thinnest_mm": left.thinnest_mm,
        })),
        Flaw::Open { .. } | Flaw::Instead { .. } | Flaw::Lessened(_) | Flaw::Unheeded(_) | Flaw::Replaced(_) => None,
    };
    flaws.iter().filter_map(one).collect()
}

fn slicer(by: &SlicerName) -> Value {
    json!({"name": by.name, "version": by.version})
}

/// `trunnion profile check`: where the table of a profile comes, and what follows. `reached_mm` is the lowest and the highest place, from the
/// table's middle straight up the slope, where the head can touch the bare table.
pub fn checked(done: &CheckedProfile) -> Value {
    let at = |at: &Tilted| {
        json!({
            "tilt_deg": at.tilt_deg, "centre_mm": at.centre_mm, "within_axes": at.within, "top_mm": at.top_mm, "room_mm": at.room_mm,
            "reached_mm": at.reached_mm,
        })
    };
    json!({
        "profile": done.machine.name, "sha256": done.machine.sha256, "ok": done.refusals.is_empty(), "refused": done.refusals,
        "table": done.tilts.iter().map(at).collect::<Vec<_>>(), "largest_level_mm": done.largest_level_mm,
        "largest_at_every_tilt_mm": done.largest_any_mm, "sweeps_to_mm": done.sweeps_to_mm,
        "axes_off_deg": done.axes_off_deg, "jogged": jogged_on(&done.machine.profile),
        "head_is_assumed": done.machine.profile.head_is_assumed(),
    })
}

/// `trunnion profile new`: the file that was written, and the keys that nobody answered.
pub fn profile_made(name: &str, file: &std::path::Path, unanswered: &[&str]) -> Value {
    json!({"profile": name, "file": file, "unanswered": unanswered})
}

/// `trunnion profile import`: the file that was written, what the firmware's files state with their lines, and what they do not.
pub fn profile_imported(made: &ImportedProfile, file: &std::path::Path) -> Value {
    let place = |place: &StatedAt| json!({"file": place.file, "line": place.line});
    let fact = |fact: &Fact| {
        let from: Vec<Value> = fact.from.iter().map(place).collect();
        json!({"key": fact.key, "value": fact.value, "from": from})
    };
    json!({
        "profile": made.name, "file": file, "firmware": made.firmware(), "like": made.like.name,
        "stated": made.facts.iter().map(fact).collect::<Vec<_>>(), "unanswered": made.unanswered, "notes": made.notes,
        "refused": made.refusals,
    })
}

/// The day on which the axes were seen to be as the profile has them; null where that was never, or is no longer so.
fn jogged_on(profile: &Profile) -> Option<String> {
    if let Sight::Seen(date) = profile.sight() { Some(date) } else { None }
}

/// `trunnion machine jog`: what the axes do, and where the profile has it otherwise.
pub fn jogged(done: &JogResult) -> Value {
    let change = |change: &JogChange| json!({"key": change.key, "profile": change.was, "machine": change.seen});
    let seen = &done.jogged;
    json!({
        "profile": done.machine.name, "jogged": done.date,
        "tilt": {"letter": seen.tilt, "about": seen.about, "direction": seen.tilt_direction, "level_deg": seen.level_deg},
        "rotation": {"letter": seen.rotation, "direction": seen.rotation_direction},
        "changes": done.changes.iter().map(change).collect::<Vec<_>>(), "ok": done.unfit.is_none(), "refused": done.unfit,
    })
}

/// `trunnion profile list`: one shipped profile.
pub fn shipped(checked: &CheckedProfile) -> Value {
    let machine = &checked.machine.profile.machine;
    json!({
        "name": checked.machine.name, "about": machine.about, "tested_on": machine.tested_on,
        "largest_level_mm": checked.largest_level_mm, "largest_at_every_tilt_mm": checked.largest_any_mm,
    })
}

/// `trunnion profile list`: one of the user's own, with its file.
pub fn own(name: &str, file: &std::path::Path, checked: &Result<CheckedProfile, MachineError>) -> Value {
    let mut row = match checked {
        Ok(checked) => shipped(checked),
        Err(error) => json!({"name": name, "error": error.to_string()}),
    };
    row["file"] = file.to_string_lossy().into();
    row
}

/// `trunnion open`: where the workbench is; the address has its secret behind `#`.
pub fn opened(address: &str) -> Value {
    let port = address.rsplit_once(':').and_then(|(_, rest)| rest.split('/').next()?.parse::<u16>().ok());
    json!({"address": address, "port": port})
}

/// `trunnion send --dry-run`: the rehearsal's last event.
pub fn rehearsed(done: &Rehearsal) -> Value {
    let of = done.last_line;
    json!({
        "event": "done", "line": of, "of": of, "dry_run": true, "seconds": done.seconds,
        "seconds_print": done.seconds_print, "clamped": done.clamped,
        "troubles": done.troubles,
    })
}

/// `trunnion send`: one event, a line of its own; `None` for what is only said to people.
pub fn event(what: &Sending<'_>, at: At) -> Option<Value> {
    let (name, facts) = facts(what)?;
    let mut line = json!({"event": name, "line": at.line, "of": at.of});
    if let (Some(line), Value::Object(facts)) = (line.as_object_mut(), facts) {
        line.extend(facts);
    }
    Some(line)
}

fn facts(what: &Sending<'_>) -> Option<(&'static str, Value)> {
    Some(match what {
        Sending::Start => ("start", json!({})),
        Sending::Resend { number, file_line, why } => {
            ("resend", json!({"number": number, "file_line": file_line, "why": why}))
        }
        Sending::Progress(f) => {
            let facts = json!({
                "share": f.share, "layer": f.layer, "layers": f.layers, "slot": f.slot, "slots": f.slots, "seconds_left": f.seconds_left,
                "nozzle_c": f.nozzle_c.map(|t| t[0]), "nozzle_target_c": f.nozzle_c.map(|t| t[1]),
                "bed_c": f.bed_c.map(|t| t[0]), "bed_target_c": f.bed_c.map(|t| t[1]),
                "waits_for": f.waits_for, "resends": f.resends,
            });
            ("progress", facts)
        }
        Sending::Trouble { file_line, text } => ("trouble", json!({"file_line": file_line, "text": text})),
        Sending::Paused => ("pause", json!({})),
        Sending::Resumed => ("resumed", json!({})),
        Sending::Short { journal } | Sending::Full { journal } => ("full", json!({"journal": journal})),
        Sending::Lost { why, .. } => ("lost", json!({"why": why})),
        Sending::Reset { reason } => ("reset", json!({"reason": reason})),
        Sending::Stopped { reason } => ("stopped", json!({"reason": reason})),
        Sending::Done { resends } => ("done", json!({"resends": resends})),
        _ => return None,
    })
}
