//! A preview: the page, the document in it, and what the command says of it.

use serde_json::{Value, json};

use super::planned;
use crate::gcode::round_to;
use crate::geom::{Machine, Rigid, Table, Vec3};
use crate::job::{MOST_LOOKED_AT, PoseShown, PreviewResult};
use crate::motion::{AxisRange, SwivelHead};
use crate::planning::Plan;
use crate::trace::Zone;
use crate::verify::SURVEYED_MM;
use crate::view::{self, DrawnBody, DrawnMachine, DrawnPose, DrawnProgram, Hull};

/// The page that shows `of`, complete.
pub fn page(of: &PreviewResult) -> String {
    view::page(&facts(of).to_string(), &of.packed.bytes)
}

/// Both pages side by side in one.
pub fn page_of_two(of: [&PreviewResult; 2]) -> String {
    view::pair(of.map(|one| (one.file.clone(), page(one))))
}

/// `trunnion preview --compare`: what was written to `output`, how large it is, and each of the two.
pub fn compared(output: &str, bytes: usize, of: [&PreviewResult; 2]) -> Value {
    // Of the file there is one size.
    let pages = of.map(|one| {
        let mut document = previewed(output, bytes, one);
        document["file"] = one.file.as_str().into();
        document
    });
    json!({"output": output, "shows": "two", "bytes": bytes, "pages": pages})
}

/// `trunnion preview`: what was written to `output`, how large it is, and what verification found.
pub fn previewed(output: &str, bytes: usize, of: &PreviewResult) -> Value {
    let program = of.scene.program.as_ref();
    let counted = |count: fn(&DrawnProgram) -> usize| program.map_or(0, count);
    json!({
        "output": output,
        "shows": kind(of),
        "bytes": bytes,
        "moves": counted(|p| p.moves),
        "layers": counted(|p| p.layers),
        "lines": counted(|p| p.lines as usize),
        "lines_from_moves": counted(|p| p.rebuilt as usize),
        "text": of.packed.has_text,
        "parts": of.parts.len(),
        "poses": of.poses.len(),
        "thinned": of.scene.shapes.thinned,
        "verify": of.report.as_ref().map(|report| super::verified(report, of.seconds_verify)),
        "why_not": why_not(of),
        "seconds": {"verify": of.seconds_verify, "page": of.seconds},
    })
}

fn why_not(of: &PreviewResult) -> Option<String> {
    of.no_plan.as_ref().map(|no| no.infeasible.to_string())
}

fn kind(of: &PreviewResult) -> &'static str {
    match (&of.scene.program, &of.no_plan) {
        (Some(_), _) => "program",
        (None, None) => "plan",
        (None, Some(_)) => "reasons",
    }
}

/// Everything that the page says and that is no column of numbers.
fn facts(of: &PreviewResult) -> Value {
    let counts = &of.scene.shapes.counts;
    let named = of.parts.iter().map(|name| (name, "solid")).chain(of.supports.iter().map(|name| (name, "support")));
    let part = |((name, role), [vertices, facets]): ((&String, _), &[usize; 2])| json!({"name": name, "role": role, "vertices": vertices, "facets": facets});
    json!({
        "file": of.file,
        "kind": kind(of),
        "made_by": concat!("trunnion ", env!("CARGO_PKG_VERSION")),
        "machine": machine(of),
        "parts": named.zip(counts).map(part).collect::<Vec<_>>(),
        "thinned": of.scene.shapes.thinned,
        "poses": of.poses.iter().map(pose).collect::<Vec<_>>(),
        "why_not": why_not(of),
        "ways": planned::ways(&of.ways),
        "verify": of.report,
        "program": of.scene.program.as_ref().map(|program| self::program(program, of)),
    })
}

fn machine(of: &PreviewResult) -> Value {
    drawn_machine(&of.machine, &of.scene.machine)
}

/// The machine as pages draw it.
pub fn drawn_machine(name: &str, machine: &DrawnMachine) -> Value {
    let kinematics = &machine.kinematics;
    let directions = kinematics.directions();
    let axis = |axis: &AxisRange, along: &Vec3| json!({"letter": char::from(axis.letter).to_string(), "direction": axis.direction, "zero_deg": axis.zero.deg(), "absent": axis.absent, "along": numbers(along)});
    let pieces = |all: &[DrawnBody]| -> Vec<Value> {
        all.iter()
            .map(|p| json!({"name": p.name, "follows": p.follows, "stays": p.stays, "hull": hull(&p.hull)}))
            .collect()
    };
    json!({
        "name": name,
        "tilt": axis(&kinematics.tilt, &directions.tilt),
        "rotation": axis(&kinematics.rotation, &directions.rotation),
        "pivot": numbers(&kinematics.pivot),
        "offset": numbers(&kinematics.offset),
        "swivel": kinematics.head.as_ref().map(swivel),
        "limits": [numbers(&machine.limits.min), numbers(&machine.limits.max)],
        "table": hull(&machine.table),
        "head": pieces(&machine.head),
        "frame": pieces(&machine.frame),
    })
}

/// What turns the head, for drawing: see `motion::SwivelHead`.
fn swivel(head: &SwivelHead) -> Value {
    json!({
        "yaws": head.yaws,
        "tilt_from_tip": numbers(&head.tilt_from_tip),
        "rotation_from_tip": numbers(&head.rotation_from_tip),
        "table": numbers(&head.table),
    })
}

fn numbers(v: &Vec3) -> [f64; 3] {
    (*v).into()
}

/// Corners and faces one behind the other; a ten-thousandth of a millimetre is enough for a picture.
fn hull(hull: &Hull) -> Value {
    let points: Vec<f64> = hull.points.iter().flat_map(|p| numbers(p).map(|v| round_to(v, 4))).collect();
    let faces: Vec<u32> = hull.faces.iter().flatten().copied().collect();
    json!({"points": points, "faces": faces})
}

/// The rotation's rows, then the translation.
fn motion(motion: &Rigid<Table, Machine>) -> Vec<f64> {
    let rows = (0..3).flat_map(|row| (0..3).map(move |column| (row, column)));
    rows.map(|at| motion.rotation[at]).chain(numbers(&motion.translation)).collect()
}

fn pose(of: &PoseShown) -> Value {
    json!({
        "slot": of.slot, "words_deg": of.words_deg, "angles": [of.pose.tilt.rad(), of.pose.rotation.rad()], "motion": motion(&of.motion),
        "fresh": of.fresh, "before": of.before, "struck": of.struck, "tip": of.tip.as_ref().map(numbers), "text": of.text,
    })
}

fn program(program: &DrawnProgram, of: &PreviewResult) -> Value {
    let style = |s: &view::Style| json!([s.print, s.role.name(), s.width_mm, s.height_mm, s.share]);
    json!({
        "moves": program.moves,
        "lines": program.lines,
        "seconds": program.seconds,
        "has_text": of.packed.has_text,
        "extruder": of.extruder.to_string(),
        // Where each run begins and ends and how much room it has; what is between two runs has none told.
        "rooms": of.rooms.iter().map(|room| json!([room.moves.start, room.moves.end, round_to(room.mm, 2)])).collect::<Vec<_>>(),
        "surveyed_mm": SURVEYED_MM,
        "surveyed_moves": MOST_LOOKED_AT,
        "feeds": program.feeds,
        "styles": program.styles.iter().map(style).collect::<Vec<_>>(),
        "places": program.places.iter().map(place).collect::<Vec<_>>(),
        "prints": of.plan.iter().flat_map(prints).collect::<Vec<_>>(),
    })
}

/// Part and slot of each print, those of supports last, as they are numbered.
fn prints(plan: &Plan) -> Vec<Value> {
    let supports = plan.supports().map(|(_, slot, print)| (slot, print));
    plan.prints().chain(supports).map(|(slot, print)| json!([print.part, slot])).collect()
}

fn place(place: &DrawnPose) -> Value {
    let state = &place.state;
    let zone = match state.zone {
        Zone::Start => "start",
        Zone::Prints => "prints",
        Zone::End => "end",
    };
    json!({
        "tilt": state.tilt.map(|a| a.rad()), "rotation": state.rotation.map(|a| a.rad()), "slot": state.slot, "zone": zone,
        "nozzle_c": state.nozzle_c, "motion": place.motion.as_ref().map(motion),
    })
}
