//! A second opinion on a finished program for a table that tilts and turns.
//!
//! ```text
//! second_opinion OUT.gcode CERTIFICATE.json [MODEL.stl]
//! ```
//!
//! A certificate claims that this very file, on this machine, makes this model by this plan. This program reads the file with its own
//! reader, its own kinematic chain and its own geometry, and shares no code with the library that wrote it. It takes from the certificate
//! only the machine's values, the plan and the figures that it compares. Exit code: 0 all right, 1 a check failed, 2 input that
//! cannot be read.
//!
//! | check | module | what must hold |
//! |---|---|---|
//! | hashes, claims | `certificate` | bytes and SHA-256 of program and model; the plan is of that model and that machine, and its hash and those of machine and rules are right |
//! | words | `reader` | each line is understood, or is one of the profile's own start or end lines, or is allowed by name |
//! | heat | `reader` | nozzle and bed are set and waited for before filament is pushed; both are off at the end |
//! | filament | `reader` | what is pulled is pushed again before the next line, to 0.3 mm |
//! | limits, turns | `reader` | positions, feeds and turning rates; homing; the table turns alone, with filament pulled back |
//! | parts | `parts` | the model's closed shells are the plan's parts |
//! | order, poses | `scene` | marks and lines come in the plan's order; each print's `up` is upright to 0.001 degrees |
//! | inside | `layers` | no line's middle is more than 0.15 mm outside of its part's section |
//! | layers, amounts, cover | `layers` | no layer is missing; filament for 10 to 112 % of each part, and some in each tenth; first layers and flat joints are covered to 80 % |
//! | walls, place | `layers` | the outline of each layer has a line beside it; by the gaps between them a print is shifted by at most 0.03 mm, a layer by 0.1 mm |
//! | in the air | `air` | each line is on or beside something, or spans at most the plan's bridge |
//! | scrape | `air` | the tip does not dip into what is printed |
//! | collisions | `clearance` | the head's least distance from other prints and the table is as certified |
//! | figures | `main` | filament to 0.5 %, moves to 2 % where there are no arcs, slots |
//!
//! Modules use only those before them in this order: `opinion`, `maths`, `grid`, `certificate`, `bodies`, `machine`, `reader`, `parts`,
//! `scene`, `section`, `layers`, `air`, `clearance`, `main`.
//!
//! Heights are the distances of successive layers, and widths follow from filament and heights: of the file's comments only the marks
//! `;TRUNNION ..` and the kind of line (support, skirt, brim) are read. Parts are the closed shells in the order of the file; where
//! shells are mixed, what shares a corner is one part. A print that is numbered beyond the plan's is of supports.
//!
//! # What is not checked
//!
//! - Models that are not STL: all that needs the parts is then left out, and the nozzle's distance from prints that may share a face too.
//! - Profiles with `rtcp`: the documents do not say in which frame such a file counts. They fail.
//! - The table's first turn, before X and Y are known, and where the table stood before it.
//! - Supports are not compared with their plan, except that it has some, that they are on something and that the head does not touch
//!   them.
//! - Accelerations, jerk, pressure advance, fans, and how fast plastic melts.
//! - Whether a print holds on the table; gaps within a layer, but for first layers, flat joints and the outline.
//! - Distances are sampled: every 0.5 mm of a move, 0.5 degrees of a turn, against points every 0.5 mm of a line. So a clearance is a
//!   little above the true one, or, at a bead's corner, up to 0.05 mm below it.

// All modules are private: what they make public is for each other.
#![allow(unreachable_pub)]

mod air;
mod bodies;
mod certificate;
mod clearance;
mod grid;
mod layers;
mod machine;
mod maths;
mod opinion;
mod parts;
mod reader;
mod scene;
mod section;

use self::certificate::{Plan, at, check_claims, number, optional};
use self::layers::check_prints;
use self::machine::Machine;
use self::opinion::{Check, Opinion};
use self::parts::parts_of;
use self::reader::{Program, read};
use self::scene::Scene;
use serde_json::Value;
use std::collections::BTreeSet;

/// Moves are compared where there are no arcs: in how many chords the certificate counts those is not documented.
fn check_figures(certificate: &Value, plan: &Plan, program: &Program) -> Result<Check, String> {
    let mut check = Check::new("figures");
    let [filament, moves, slots] =
        ["filament_mm", "moves", "slots"].map(|key| number(certificate, &format!("/figures/{key}")));
    let (pushed, certified) = (program.motions.iter().map(|motion| motion.e).sum::<f64>(), filament?);
    check.require((pushed / certified - 1.0).abs() <= 0.005, || {
        format!("{pushed:.1} mm of filament, certified {certified:.1}")
    });
    let (made, certified) = (program.moves, moves?);
    let off = (made as f64 / certified - 1.0).abs();
    check.require(program.arcs || off <= 0.02, || format!("{made} moves, certified {certified}"));
    let (planned, certified) = (plan.prints.iter().map(|print| print.slot).collect::<BTreeSet<_>>().len(), slots?);
    check.require(planned as f64 == certified, || format!("{planned} slots, certified {certified}"));
    check.figure = format!("{pushed:.1} mm of filament, {made} moves");
    Ok(check)
}

/// Checks a finished program against its certificate and, where given, its model.
///
/// # Errors
///
/// A sentence where the certificate cannot be read, or names what is unknown.
pub fn check(program: &[u8], certificate: &Value, model: Option<&[u8]>) -> Result<Opinion, String> {
    let mut checks = check_claims(program, certificate, model)?;
    let values = at(certificate, "/machine/values")?;
    let (machine, plan) = (Machine::read(values)?, Plan::read(at(certificate, "/plan/document")?)?);
    if at(values, "/dialect/rtcp")?.as_bool() != Some(false) {
        let mut kinematics = Check::new("kinematics");
        kinematics.fail("not checked: the profile has rtcp, which is not documented well enough");
        checks.push(kinematics);
        return Ok(Opinion { checks });
    }
    let text = std::str::from_utf8(program).map_err(|_| "the program is not a text".to_owned())?;
    let (program, checks_of_lines) = read(&machine, text);
    let figures = check_figures(certificate, &plan, &program)?;
    let (check_of_parts, parts) = parts_of(&plan, model);
    let scene = Scene::new(&machine, &plan, &program.motions, parts);
    checks.extend(checks_of_lines);
    checks.extend([check_of_parts, scene.check_order(&program.marks), scene.check_poses()]);
    checks.extend(check_prints(&scene));
    checks.extend(scene.check_air());
    checks.extend([scene.check_collisions(optional(certificate, "/figures/clearance_mm")), figures]);
    Ok(Opinion { checks })
}

fn opinion() -> Result<Opinion, String> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let (program, certificate, model) = match files.as_slice() {
        [program, certificate] => (program, certificate, None),
        [program, certificate, model] => (program, certificate, Some(model)),
        _ => return Err("usage: second_opinion OUT.gcode CERTIFICATE.json [MODEL.stl]".to_owned()),
    };
    let read = |file: &String| std::fs::read(file).map_err(|error| format!("{file}: {error}"));
    let document = serde_json::from_slice(&read(certificate)?).map_err(|error| format!("{certificate}: {error}"))?;
    let model = model.map(read).transpose()?;
    check(&read(program)?, &document, model.as_deref())
}

#[allow(clippy::print_stdout, clippy::print_stderr)]
fn main() {
    let opinion = opinion().unwrap_or_else(|error| {
        eprintln!("{error}");
        std::process::exit(2)
    });
    for check in &opinion.checks {
        match (&check.left_out, check.count) {
            (Some(why), 0) => println!("{:<12} left out: {why}", check.name),
            (_, 0) => println!("{:<12} ok      {}", check.name, check.figure),
            (_, count) => println!("{:<12} FAILED  {} ({count})", check.name, check.figure),
        }
        check.failures.iter().for_each(|failure| println!("    {failure}"));
    }
    std::process::exit(i32::from(opinion.checks.iter().any(|check| check.count > 0)));
}
