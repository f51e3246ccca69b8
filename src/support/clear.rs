//! What keeps a line clear of the part: its sections around a layer, and how far the middle of a line stays from each.
//!
//! Slot frame, mm. A slicer knows its layers by their middles, and so do supports that are printed with them ([`Clear::Layers`]). Supports
//! that are a mesh are sliced at heights unknown here, so they keep their gap from the surface itself ([`Clear::Around`]): the part is cut
//! just below and just above each layer's edges, and what it has between two cuts lies within one of them.

use std::sync::OnceLock;

use rayon::prelude::*;

use super::laying::Clear;
use crate::geom::Slot;
use crate::mesh::TriangleMesh;
use crate::overhang::Keels;
use crate::section::{Section, Sections};

/// Heights that differ by less are the same, mm.
pub(super) const SAME_MM: f64 = 1e-6;
/// What the part has so many layers below a line still carries it: over a slope it begins on the layer below, and sags by up to two layers
/// onto what lies deeper.
const CARRYING_LAYERS: usize = 3;
/// So far below and above an edge of layers the part is cut, mm: a level face there is in one of the two.
const HAIR_MM: f64 = 1e-4;
/// What the sides of a mesh may lie beside the lines it is made from, mm: sheets overlap, and their edges are straightened.
pub(super) const BESIDE_LINES_MM: f64 = 0.08;

/// What supports keep clear of.
#[derive(Clone, Copy)]
pub struct Around<'a> {
    /// The part that they hold, and what grows beside it.
    pub meshes: &'a [&'a TriangleMesh<Slot>],
    /// So many of these, the first ones, may carry them; from the gap of a joint nobody could take them out.
    pub carrying: usize,
    /// What of the part nobody lays: they may reach through it.
    pub keels: &'a Keels,
}

/// How supports keep clear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Width of a line, mm.
    pub line_mm: f64,
    /// Air between a support and what it holds, mm, at least.
    pub gap_mm: f64,
    /// From what that air is kept, and what beside.
    pub clear: Clear,
}

/// What supports keep clear of, layer by layer, each cut where it is asked for first: supports of several kinds share it.
pub struct Cuts {
    sections: Vec<Sections>,
    carrying: usize,
    keels: Keels,
    layers: Vec<[f64; 2]>,
    pub(super) how: Clearance,
    /// In the middle of each layer; or just below its upper edge.
    own: Vec<OnceLock<Vec<Section>>>,
    /// Just above the lower edge of each layer, where the gap is kept from the surface.
    lower: Vec<OnceLock<Vec<Section>>>,
}

/// Sections, and how far from them the middle of a line stays, mm.
pub(super) type Keeps<'a> = Vec<(&'a [Section], f64)>;

impl Cuts {
    /// Of what is `around` supports in `layers` (from, to; upward).
    pub fn of(around: &Around<'_>, layers: Vec<[f64; 2]>, how: Clearance) -> Self {
        let sections = around.meshes.iter().map(|mesh| Sections::of(mesh)).collect();
        let [own, lower] = [0, 1].map(|_| std::iter::repeat_with(OnceLock::new).take(layers.len()).collect());
        let (carrying, keels) = (around.carrying.min(around.meshes.len()), around.keels.clone());
        Self { sections, carrying, keels, layers, how, own, lower }
    }

    /// The layers.
    pub(super) fn spans(&self) -> &[[f64; 2]] {
        &self.layers
    }

    fn at(&self, k: usize, z: f64) -> Vec<Section> {
        let cut = |(place, sections): (usize, &Sections)| match place {
            0 => self.keels.without(k, sections.at(z)),
            _ => sections.at(z),
        };
        self.sections.iter().enumerate().map(cut).collect()
    }

    /// What the part has in a layer.
    pub(super) fn layer(&self, k: usize) -> &[Section] {
        let [low, high] = self.layers[k];
        let z = match self.how.clear {
            Clear::Layers { .. } => (low + high) / 2.0,
            Clear::Around => high - HAIR_MM,
        };
        self.own[k].get_or_init(|| self.at(k, z))
    }

    fn lower(&self, k: usize) -> &[Section] {
        self.lower[k].get_or_init(|| self.at(k, self.layers[k][0] + HAIR_MM))
    }

    /// What it has in each of some layers, as far as there are so many.
    pub(super) fn layers(&self, from: usize, count: usize) -> Vec<&[Section]> {
        let end = self.own.len();
        (from.min(end)..(from + count).min(end)).map(|k| self.layer(k)).collect()
    }

    /// What it has in the layers below layer `k` that carry a line there.
    pub(super) fn under(&self, k: usize) -> Vec<&[Section]> {
        (k.saturating_sub(CARRYING_LAYERS)..k).map(|k| &self.layer(k)[..self.carrying]).collect()
    }

    /// The layers that begin less than the gap above the top of layer `k`.
    pub(super) fn over(&self, k: usize) -> usize {
        let top = self.layers[k][1];
        self.layers[k + 1..].iter().take_while(|above| above[0] < top + self.how.gap_mm - SAME_MM).count()
    }

    /// What a line in layer `k` keeps from.
    pub(super) fn around(&self, k: usize) -> Keeps<'_> {
        let half = self.how.line_mm / 2.0;
        let over = k + 1..=k + self.over(k);
        let Clear::Layers { beside_mm } = self.how.clear else { return self.surface_around(k, half + BESIDE_LINES_MM) };
        let own = (self.layer(k), half + beside_mm);
        std::iter::once(own).chain(over.map(|above| (self.layer(above), half))).collect()
    }

    /// The same from the surface: what lies `up` mm above or below a line may be as near as leaves the gap between them.
    fn surface_around(&self, k: usize, half: f64) -> Keeps<'_> {
        let ([low, high], gap) = (self.layers[k], self.how.gap_mm);
        let near = |up: f64| half + (gap * gap - up * up).max(0.0).sqrt();
        let own = [self.layer(k), self.lower(k)].map(|cut| (cut, half + gap));
        let above = (k + 1..=k + self.over(k)).map(|j| (self.layer(j), near(self.layers[j][0] - high)));
        let under = (0..k).rev().take_while(|&j| self.layers[j][1] > low - gap + SAME_MM);
        let under = under.map(|j| (self.lower(j), near(low - self.layers[j][1])));
        own.into_iter().chain(above).chain(under).collect()
    }

    /// Cuts all layers at once.
    pub(super) fn all(&self) {
        (0..self.layers.len()).into_par_iter().for_each(|k| {
            self.layer(k);
        });
    }
}
