//! What is left of a solid after some cuts, the pieces that were taken, and how such results are compared.
//!
//! Lengths mm, areas mm². A state is never changed once it is made, so what was found out about it holds for every search that
//! comes by: of another width, among other directions, on a pedestal.

use std::sync::{Arc, OnceLock};

use super::clip::ON_PLANE_MM;
use super::measure::{MeasureRules, Measured, NOTHING_MM2, PieceNeeds, piece_passes};
use super::promise::Promise;
use super::surface::{Plane, Surface};
use super::sweep::Upright;
use crate::geom::Vec3;

/// Areas nearer than this are one, mm².
pub(super) const SAME_MM2: f64 = 0.1;
/// In the beam a beginning or a ridge weighs as much as this area, mm².
pub(super) const FAULT_MM2: f64 = 5.0;

/// A cut that was made.
#[derive(Clone)]
pub(super) struct CutStep {
    pub(super) plane: Plane,
    pub(super) pieces: Vec<Surface>,
    /// By piece, along the plane's normal.
    pub(super) needs: Vec<PieceNeeds>,
    pub(super) seam_mm2: f64,
    /// What the cut took from what was left, mm².
    pub(super) gain_mm2: f64,
    pub(super) crumbs_mm3: f64,
    /// Whether the direction is none of a face or of the compass.
    pub(super) odd: bool,
    /// Whether everything beyond the plane was taken.
    pub(super) all: bool,
    /// The highest point of each solid that was taken.
    pub(super) tops: Vec<Vec3>,
    /// The number of its caps.
    pub(super) cap: u32,
    /// By piece, once it was asked.
    pub(super) passes: Vec<OnceLock<bool>>,
}

impl CutStep {
    /// Whether a piece passes by its facets or by its layers: found out once for all states that have this cut behind them.
    pub(super) fn passes(&self, piece: usize, rules: &MeasureRules) -> bool {
        let layers = || piece_passes(&self.pieces[piece], &self.plane.normal, self.cap, rules);
        self.needs[piece].is_nothing() || *self.passes[piece].get_or_init(layers)
    }

    /// The middle of the caps.
    pub(super) fn seam_middle(&self) -> Vec3 {
        let flat = |p: &Vec3| self.plane.height(p).abs() < 10.0 * ON_PLANE_MM;
        let (mut sum, mut area) = (Vec3::zeros(), 0.0);
        for piece in &self.pieces {
            for facet in (0..piece.facets.len()).filter(|&f| piece.corners(f).iter().all(flat)) {
                let doubled = piece.area_vector(facet).norm();
                sum += piece.corners(facet).iter().sum::<Vec3>() * (doubled / 3.0);
                area += doubled;
            }
        }
        sum / area.max(f64::MIN_POSITIVE)
    }
}

/// A plane through a state, with the state behind it.
pub(super) type StatePromise = Promise<SplitState>;

/// What is left after some cuts.
pub(super) struct SplitState {
    pub(super) rest: Measured,
    pub(super) upright: Upright,
    pub(super) steps: Vec<Arc<CutStep>>,
    /// mm², in pieces that were taken.
    stays_mm2: f64,
    faults: usize,
    /// By direction, the planes that gain something.
    along: Vec<OnceLock<Vec<StatePromise>>>,
    /// Whether what is left does, by its layers.
    passes: OnceLock<bool>,
}

impl SplitState {
    /// `directions` is how many will be asked about.
    pub(super) fn of(rest: Measured, rules: &MeasureRules, steps: Vec<Arc<CutStep>>, directions: usize) -> Self {
        let upright = Upright::of(&rest, rules);
        let needs = steps.iter().flat_map(|step| &step.needs);
        let (stays_mm2, faults) = needs.fold((0.0, 0), |(a, f), n| (a + n.area_mm2, f + n.faults()));
        let along = std::iter::repeat_with(OnceLock::new).take(directions).collect();
        Self { rest, upright, steps, stays_mm2, faults, along, passes: OnceLock::new() }
    }

    /// The planes of one direction that gain something; `find` looks for them where nobody has.
    pub(super) fn along(&self, direction: usize, find: impl FnOnce() -> Vec<StatePromise>) -> &[StatePromise] {
        self.along[direction].get_or_init(find)
    }

    /// Facets of what is left and of what the last cut took.
    pub(super) fn facets(&self) -> usize {
        let pieces = self.steps.last().map_or(0, |step| step.pieces.iter().map(|p| p.facets.len()).sum());
        self.rest.surface.facets.len() + pieces
    }

    /// What is left needs this, as it stands.
    pub(super) fn left(&self) -> PieceNeeds {
        self.upright.needs
    }

    pub(super) fn area_mm2(&self) -> f64 {
        self.stays_mm2 + self.left().area_mm2
    }

    pub(super) fn faults(&self) -> usize {
        self.faults + self.left().faults()
    }

    pub(super) fn knows(&self, up: &Vec3) -> bool {
        self.steps.iter().any(|step| (step.plane.normal - up).norm() < 1e-9) || (up - Vec3::z()).norm() < 1e-9
    }

    /// Distinct directions, +z among them.
    pub(super) fn setups(&self) -> usize {
        let mut known: Vec<Vec3> = vec![Vec3::z()];
        for step in &self.steps {
            if known.iter().all(|k| (k - step.plane.normal).norm() > 1e-9) {
                known.push(step.plane.normal);
            }
        }
        known.len()
    }

    /// Cuts along a direction of the even spread: what is printed along it has its faces on a slant.
    fn odd(&self) -> usize {
        self.steps.iter().filter(|step| step.odd).count()
    }

    pub(super) fn seam_mm2(&self) -> f64 {
        self.steps.iter().map(|step| step.seam_mm2).sum()
    }

    /// The order of finished results: what they need, setups, cuts, seams.
    pub(super) fn key(&self) -> (usize, i64, usize, usize, usize, i64) {
        let (area, seam) = (whole(self.area_mm2()), whole(self.seam_mm2()));
        (self.faults(), area, self.setups(), self.steps.len(), self.odd(), seam)
    }

    /// The order within the beam.
    pub(super) fn rank(&self) -> (i64, usize, usize, i64) {
        let worth = whole(self.area_mm2() + FAULT_MM2 * self.faults() as f64);
        (worth, self.setups(), self.odd(), whole(self.seam_mm2()))
    }

    /// Whether no part needs support, or no more than is allowed together.
    pub(super) fn is_done(&self, allow_mm2: f64) -> bool {
        let pieces = self.steps.iter().flat_map(|step| &step.needs);
        let nothing = pieces.chain([&self.left()]).all(|n| n.area_mm2 <= NOTHING_MM2);
        self.faults() == 0 && (nothing || self.area_mm2() <= allow_mm2)
    }

    /// Whether every part passes by its facets or by its layers.
    pub(super) fn passes(&self, rules: &MeasureRules) -> bool {
        self.rest_passes(rules)
            && self.steps.iter().all(|step| (0..step.pieces.len()).all(|piece| step.passes(piece, rules)))
    }

    /// Whether what is left does.
    pub(super) fn rest_passes(&self, rules: &MeasureRules) -> bool {
        self.left().is_nothing() || *self.passes.get_or_init(|| self.rest.passes(rules))
    }
}

/// An area in steps below which two are one.
pub(super) fn whole(area: f64) -> i64 {
    (area / SAME_MM2).round() as i64
}
