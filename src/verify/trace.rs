//! The program as the machine would carry it out: straight lines of the tip at fixed poses, and turns.

use super::marks::Role;
use crate::geom::{Bounds, Vec3};
use crate::motion::Pose;

/// What a line of the tip does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// Goes; retracting counts as going.
    Travel,
    /// Lays filament.
    Print(Role),
}

/// A straight line of the tip at a fixed pose, machine coordinates, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stroke {
    pub(super) from: Vec3,
    pub(super) to: Vec3,
    /// In the file.
    pub(super) line: u32,
    /// The print that the last mark named, in the order of `Plan::prints`.
    pub(super) print: Option<u32>,
    pub(super) kind: Kind,
    /// Width and height of the line laid, mm.
    pub(super) width: f32,
    pub(super) height: f32,
}

/// A move of which not every coordinate is known: the tip is somewhere in the box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blind {
    pub(super) within: Bounds,
    pub(super) line: u32,
}

/// A move of the rotary axes, with or without the tip; unknown is `None`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub(super) from: Option<Pose>,
    pub(super) to: Option<Pose>,
    /// The box in which the tip is, unknown coordinates at the axes' limits; `None` where the height is unknown.
    pub(super) tips: Option<[Bounds; 2]>,
    pub(super) line: u32,
    /// The slot that the last mark named.
    pub(super) slot: Option<usize>,
}

/// One thing the machine does.
#[derive(Clone, Copy, Debug)]
pub(super) enum Act {
    Stroke(Stroke),
    Blind(Blind),
    Turn(Turn),
}

/// A print of the plan, with its place in the order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planned {
    pub(super) slot: usize,
    pub(super) part: usize,
    /// The setup, counted over all slots.
    pub(super) setup: usize,
    pub(super) pose: Pose,
    pub(super) up: Vec3,
}

/// The whole program.
#[derive(Default)]
pub(super) struct Trace {
    pub(super) acts: Vec<Act>,
    pub(super) moves: usize,
    pub(super) seconds: f64,
}
