//! The questions of a jog test, and what came of it, for people.

use std::fmt::Write;

use crate::calibrate::{JOG_DEG, JOG_MM, JogQuestion, JogSubject, Seen};
use crate::job::JogResult;
use crate::profile::{Profile, Sight};

/// An answer in words.
fn answer(seen: Seen, subject: JogSubject) -> &'static str {
    match (seen, subject) {
        (Seen::Right, _) => "to the right",
        (Seen::Left, _) => "to the left",
        (Seen::Away, _) => "away from you",
        (Seen::Towards, _) => "towards you",
        (Seen::Apart, _) => "up, away from the table",
        (Seen::Closer, _) => "down, towards the table",
        (Seen::NearRose, _) => "its side near you rose",
        (Seen::NearSank, _) => "its side near you sank",
        (Seen::RightRose, _) => "its right side rose",
        (Seen::RightSank, _) => "its right side sank",
        (Seen::Anticlockwise, _) => "it turned anticlockwise, seen from above",
        (Seen::Clockwise, _) => "it turned clockwise, seen from above",
        (Seen::Yes, _) => "yes",
        (Seen::No, _) => "no",
        (Seen::Nothing, _) => "nothing moved",
        (Seen::Unsure, _) => "something else, or I do not know",
    }
}

/// A question with its answers, numbered from 1.
pub fn jog_question(question: &JogQuestion, profile: &Profile) -> String {
    let (axis, step) = (question.axis, question.step);
    let reach = profile.table_reach_mm();
    let mut out = match question.subject {
        JogSubject::Ready => format!(
            "Each axis will move by {JOG_MM} mm or {JOG_DEG} degrees and back. Are all axes homed, the table level and empty, the head high \
             above it, and can you reach the power switch? Stand where you see the table, and stay there until the end."
        ),
        JogSubject::Way => format!(
            "{axis} moved by {step} mm. Where did the nozzle go over the table? (If the table moved, the nozzle went the other way.)"
        ),
        JogSubject::Table => format!("{axis} moved by {step} degrees. What did the table do?"),
        JogSubject::Amount => format!(
            "{axis} moved by {step} degrees again. Was it about that much? (The rim, {reach:.0} mm out, moves by about {:.0} mm.)",
            reach * JOG_DEG.to_radians()
        ),
        JogSubject::Level => {
            let word = question.word.map_or_else(String::new, |word| format!(" ({axis}{word:.2})"));
            format!("{axis} is back where it was{word}. Is the table level now? (Use a spirit level.)")
        }
    };
    for (i, seen) in question.answers.iter().enumerate() {
        let _ = write!(out, "\n  {} {}", i + 1, answer(*seen, question.subject));
    }
    out
}

/// What was seen, and where the profile says something else.
pub fn jogged(done: &JogResult) -> String {
    let seen = &done.jogged;
    let mut out = format!(
        "{} tilts the table about {} ({:+}), {} turns it ({:+})",
        seen.tilt, seen.about, seen.tilt_direction, seen.rotation, seen.rotation_direction
    );
    if let Some(level) = seen.level_deg {
        let _ = write!(out, "; the table is level at {}{level:.2}", seen.tilt);
    }
    if done.changes.is_empty() {
        let _ = write!(out, "\n{}: all as in the profile", done.machine.name);
    }
    for change in &done.changes {
        let _ = write!(
            out,
            "\n{}: {} in {}, but {} on the machine",
            change.key, change.was, done.machine.name, change.seen
        );
    }
    if done.changes.iter().any(|change| change.key.ends_with(".letter")) {
        out.push_str("\ncheck dialect.start, dialect.end and link.rehome, whose lines name these axes");
    }
    out
}

/// What a machine is believed to be and was not looked at: its axes, its head; `None` where somebody has looked.
pub fn unseen(profile: &Profile, name: &str) -> Option<String> {
    let command = if profile.kinematics().is_table() {
        format!("trunnion machine jog -m {name} --port PORT")
    } else {
        "move each axis by hand, cold and high above the table".to_owned()
    };
    let head = profile.head_is_assumed().then(|| {
        format!("the head of {name} is assumed; measure yours (docs/how-to/machine.md), or set [head] measured = true")
    });
    let axes = match profile.sight() {
        Sight::Seen(_) => None,
        Sight::Never => {
            Some(format!("whether the axes move as {name} says is unknown; before the first print: {command}"))
        }
        Sight::Changed(date) => {
            Some(format!("the axes in {name} were changed after they were seen on {date}; repeat: {command}"))
        }
    };
    let both: Vec<String> = axes.into_iter().chain(head).collect();
    (!both.is_empty()).then(|| both.join("; "))
}
