//! What hangs or droops, connected from layer to layer, with a cause.

use std::collections::BTreeMap;
use std::fmt;

use super::OverhangRule;
use crate::geom::{Mat3, Sets, Vec3};

/// What a part lays on nothing, connected from layer to layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Summed over its layers, mm².
    pub area_mm2: f64,
    /// Its middle, the mesh's frame.
    pub at: Vec3,
    /// Why.
    pub cause: Cause,
}

/// Why a patch hangs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause {
    /// It touches nothing below.
    Island,
    /// A flat ceiling too wide for a bridge, or held at one side only.
    Ceiling {
        /// Its box across the build direction, the longer side first.
        size_mm: [f64; 2],
        /// What may be spanned.
        bridge_mm: f64,
    },
    /// A slope that goes out too far for too long.
    Slope {
        /// How high it is.
        high_mm: f64,
        /// The threshold, from the vertical.
        most_deg: f64,
    },
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Island => write!(f, "it begins in mid-air"),
            Self::Ceiling { size_mm: [long, wide], bridge_mm } => {
                write!(
                    f,
                    "ceiling {long:.1} x {wide:.1} mm; a bridge may span {bridge_mm} mm between two supported ends"
                )
            }
            Self::Slope { high_mm, most_deg } => {
                write!(f, "slope of more than {most_deg:.0} deg over {high_mm:.1} mm of height")
            }
        }
    }
}

/// What is printed, but not well: connected from layer to layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Droop {
    /// Summed over its layers, mm².
    pub area_mm2: f64,
    /// By how much it droops at most, mm.
    pub droop_mm: f64,
    /// Its middle, the mesh's frame.
    pub at: Vec3,
}

/// What a part lays badly.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judged {
    /// What hangs, the largest first.
    pub hangs: Vec<Patch>,
    /// The same by layer.
    pub places: Vec<HangingBox>,
    /// What droops, the largest first.
    pub droops: Vec<Droop>,
}

/// What hangs in one layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HangingBox {
    /// The layer's underside along the build direction, mm.
    pub under_mm: f64,
    /// Its box across that, mm: the lower and the upper corner. Of a part that is printed along +Z x and y are its own.
    pub within_mm: [[f64; 2]; 2],
}

/// A slope hangs in some of its layers only: pieces no farther apart in height than this are of one patch, mm, ..
const SAME_PATCH_MM: f64 = 2.0;
/// .. where their boxes are no farther apart than this, and as much more as they are apart in height, mm.
const TOGETHER_MM: f64 = 0.5;
/// A patch of at most so many layers is a ceiling.
const CEILING_LAYERS: usize = 2;

/// What hangs or droops in one layer, connected.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) layer: usize,
    pub(super) area_mm2: f64,
    pub(super) middle: [f64; 2],
    pub(super) bounds: [[f64; 2]; 2],
    pub(super) is: State,
}

impl Piece {
    pub(super) fn hangs(&self) -> bool {
        !matches!(self.is, State::Droops(_))
    }
}

/// How a piece is laid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum State {
    /// On nothing, and touching nothing.
    Island,
    /// On nothing.
    Hangs,
    /// It droops by so much, mm.
    Droops(f64),
}

/// Where layers lie in the mesh's frame.
#[derive(Clone, Copy)]
pub(super) struct Frame<'a> {
    pub(super) rule: &'a OverhangRule,
    /// To the upright frame.
    pub(super) upright: &'a Mat3,
    /// The lowest layer's underside, upright.
    pub(super) low: f64,
}

impl Frame<'_> {
    /// What hangs, without what is tolerated, what of it lies in which layer, and what droops.
    pub(super) fn judged(&self, pieces: &[Piece]) -> Judged {
        let (droop, hang): (Vec<&Piece>, Vec<&Piece>) = pieces.iter().partition(|p| !p.hangs());
        let groups = self.together(&hang);
        let mut all: Vec<Patch> = groups.iter().map(|group| self.patch(group)).collect();
        let mut droops: Vec<Droop> = self.together(&droop).iter().map(|group| self.droop(group)).collect();
        let tolerated = |patch: &Patch| patch.area_mm2 <= self.rule.tolerate_mm2 && patch.cause != Cause::Island;
        droops.extend(all.iter().filter(|patch| tolerated(patch)).map(|patch| {
            let Patch { area_mm2, at, .. } = *patch;
            Droop { area_mm2, droop_mm: self.rule.layer_mm, at }
        }));
        let place = |piece: &&Piece| HangingBox {
            under_mm: self.low + piece.layer as f64 * self.rule.layer_mm,
            within_mm: piece.bounds,
        };
        let held = groups.iter().zip(&all).filter(|(_, patch)| !tolerated(patch));
        let places = held.flat_map(|(group, _)| group.iter().map(place)).collect();
        all.retain(|patch| !tolerated(patch));
        Judged { hangs: all, places, droops }
    }

    /// Pieces that hang together from layer to layer.
    fn together<'p>(&self, pieces: &[&'p Piece]) -> Vec<Vec<&'p Piece>> {
        let mut sets = Sets::new(pieces.len());
        for (i, a) in pieces.iter().enumerate() {
            for (j, b) in pieces.iter().enumerate().skip(i + 1) {
                let apart = a.layer.abs_diff(b.layer) as f64 * self.rule.layer_mm;
                // Layers come in order.
                if apart > SAME_PATCH_MM {
                    break;
                }
                if near(&a.bounds, &b.bounds, TOGETHER_MM + apart) {
                    sets.join(i as u32, j as u32);
                }
            }
        }
        let mut groups: BTreeMap<u32, Vec<&Piece>> = BTreeMap::new();
        for (i, piece) in pieces.iter().enumerate() {
            groups.entry(sets.root(i as u32)).or_default().push(piece);
        }
        groups.into_values().collect()
    }

    /// The area of a group and its middle, the mesh's frame: on a layer's underside, where its lines would need something.
    fn middle(&self, group: &[&Piece]) -> (f64, Vec3) {
        let area_mm2: f64 = group.iter().map(|p| p.area_mm2).sum();
        let mean = |of: &dyn Fn(&Piece) -> f64| group.iter().map(|p| of(p) * p.area_mm2).sum::<f64>() / area_mm2;
        let under = |p: &Piece| self.low + p.layer as f64 * self.rule.layer_mm;
        let upright = Vec3::new(mean(&|p| p.middle[0]), mean(&|p| p.middle[1]), mean(&under));
        (area_mm2, self.upright.transpose() * upright)
    }

    fn droop(&self, group: &[&Piece]) -> Droop {
        let (area_mm2, at) = self.middle(group);
        let by = |p: &&Piece| if let State::Droops(mm) = p.is { mm } else { 0.0 };
        Droop { area_mm2, droop_mm: group.iter().map(by).fold(0.0, f64::max), at }
    }

    fn patch(&self, group: &[&Piece]) -> Patch {
        let (area_mm2, at) = self.middle(group);
        let first = group.iter().map(|p| p.layer).min().unwrap_or(0);
        let last = group.iter().map(|p| p.layer).max().unwrap_or(0);
        let high_mm = (last - first + 1) as f64 * self.rule.layer_mm;
        let cause = if group.iter().any(|p| p.layer == first && p.is == State::Island) {
            Cause::Island
        } else if last - first < CEILING_LAYERS {
            let size = [0, 1].map(|i| {
                let ends = group.iter().map(|p| [p.bounds[0][i], p.bounds[1][i]]);
                let [low, high] =
                    ends.fold([f64::INFINITY, f64::NEG_INFINITY], |r, e| [r[0].min(e[0]), r[1].max(e[1])]);
                high - low
            });
            Cause::Ceiling { size_mm: [size[0].max(size[1]), size[0].min(size[1])], bridge_mm: self.rule.bridge_mm }
        } else {
            Cause::Slope { high_mm, most_deg: self.rule.overhang.deg() }
        };
        Patch { area_mm2, at, cause }
    }
}

fn near(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2], mm: f64) -> bool {
    (0..2).all(|i| a[0][i] <= b[1][i] + mm && b[0][i] <= a[1][i] + mm)
}
