//! The trace as the geometry rules see it: straight lines of the tip at fixed poses, moves from unknown places, and turns.

use super::prints::PrintedPart;
use crate::geom::{Bounds, Vec3};
use crate::motion::{LinearLimits, Pose, SwivelHead};
use crate::profile::{self, ABSURD_MM, Profile};
use crate::trace::{Trace, TraceMove, Zone};

/// Heights that differ by less are one layer, mm.
const LAYER_MM: f64 = 2e-3;

/// What a line of the tip does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// Goes; retracting counts as going.
    Travel,
    /// Lays filament.
    Print,
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

/// Where the tip goes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Go {
    Stroke(Stroke),
    Blind(Blind),
}

/// The trace, with what is needed to see it so.
pub(super) struct Acts<'a> {
    pub(super) trace: &'a Trace,
    profile: &'a Profile,
    limits: LinearLimits,
    /// The head, where it turns.
    head: Option<SwivelHead>,
    /// Width and height that are taken where nothing is stated, and the most that a statement may claim.
    least: [f64; 2],
    most: [f64; 2],
    /// By print, the tip's height and the layer's, lowest first: where no height is stated.
    heights: Vec<Vec<[f64; 2]>>,
}

impl<'a> Acts<'a> {
    pub(super) fn new(trace: &'a Trace, profile: &'a Profile, printed: &[Option<PrintedPart<'_>>]) -> Self {
        let (p, nozzle) = (&profile.process, profile.process.nozzle_mm);
        Self {
            trace,
            profile,
            limits: profile.linear_limits(),
            head: profile.kinematics().head,
            least: [p.line_width_mm, p.layer_height_mm],
            // A nozzle lays no line wider than about twice its bore or higher than the bore.
            most: [p.line_width_mm.max(2.0 * nozzle), p.layer_height_mm.max(nozzle)],
            heights: printed.iter().map(|p| p.as_ref().map_or_else(Vec::new, PrintedPart::heights)).collect(),
        }
    }

    /// The turn that a move makes, if it makes one.
    pub(super) fn turn(&self, m: &TraceMove) -> Option<Turn> {
        if !self.trace.turns(m) {
            return None;
        }
        let (from, to) = (self.trace.state_before(m), self.trace.state(m));
        let tips = self.box_of(m.from).zip(self.box_of(m.to)).map(|(from, to)| [from, to]);
        let slot = to.slot.map(|s| s as usize);
        Some(Turn { from: from.pose(), to: to.pose(), tips, line: m.line, slot })
    }

    /// Where the tip goes in a move; `None` where it stands, or goes from a height that is not known.
    pub(super) fn go(&self, m: &TraceMove) -> Option<Go> {
        if !m.travels() || self.is_absurd(m) || (self.head.is_some() && self.trace.turns(m)) {
            return None;
        }
        let Some([from, to]) = m.ends() else {
            // Coming from an unknown height, nothing can be said; before the first print nothing need be.
            let within = self.box_of(m.from)?.union(&self.box_of(m.to)?);
            return Some(Go::Blind(Blind { within, line: m.line }));
        };
        let kind = if m.prints() { Kind::Print } else { Kind::Travel };
        let print = self.trace.state(m).print.filter(|p| (*p as usize) < self.heights.len());
        let [width, height] = self.bead(m, print).map(|v| v as f32);
        Some(Go::Stroke(Stroke { from, to, line: m.line, print, kind, width, height }))
    }

    /// The straight line of the tip in move `index`, if it makes one at a fixed pose.
    pub(super) fn stroke(&self, index: usize) -> Option<Stroke> {
        match self.go(&self.trace.at(index))? {
            Go::Stroke(stroke) => Some(stroke),
            Go::Blind(_) => None,
        }
    }

    /// Whether an end lies so far beyond the axes that nothing can be said of it but that, which rule `axis-limit` does; a height
    /// field over it would be of cells too coarse for everything else.
    fn is_absurd(&self, m: &TraceMove) -> bool {
        let far = |i: usize, v: f64| v < self.limits.min[i] - ABSURD_MM || v > self.limits.max[i] + ABSURD_MM;
        if let Some(head) = &self.head {
            let pose = self.trace.state(m).pose().unwrap_or_default();
            let axes = m.ends().into_iter().flatten().map(|tip| head.axes(tip, pose));
            return axes.into_iter().any(|axes| (0..3).any(|i| far(i, axes[i])));
        }
        (0..3).any(|i| [m.from[i], m.to[i]].into_iter().flatten().any(|v| far(i, v)))
    }

    /// Width and height of a line, mm, in doubt the greater.
    fn bead(&self, m: &TraceMove, print: Option<u32>) -> [f64; 2] {
        if m.prints()
            && self.trace.state(m).zone == Zone::Start
            && let Ok(prime) = profile::prime(m, self.trace, self.profile)
        {
            return [prime.width, prime.height];
        }
        let layer = || {
            let heights = self.heights.get(print? as usize)?;
            let at = heights.partition_point(|[z, _]| *z < m.to[2].unwrap_or(0.0) - LAYER_MM);
            heights.get(at).map(|[_, height]| *height)
        };
        let stated = [m.width, m.height.or_else(layer)];
        [0, 1].map(|i| stated[i].map_or(self.least[i], |v| v.clamp(self.least[i], self.most[i])))
    }

    /// Where the tip is, an unknown X or Y anywhere within the limits; `None` where the height is unknown.
    fn box_of(&self, at: [Option<f64>; 3]) -> Option<Bounds> {
        at[2]?;
        let origin = self.head.as_ref().map_or_else(Vec3::zeros, |head| head.table);
        let end = |limit: &Vec3| Vec3::from_fn(|i, _| at[i].unwrap_or(limit[i] - origin[i]));
        Some(Bounds { min: end(&self.limits.min), max: end(&self.limits.max) })
    }
}
