//! What a surface needs when it is printed along a direction: area, beginnings, ridges.
//!
//! Area: facets that look down by more than the threshold and neither lie on the table nor are the cap that the piece stands on.
//! What begins, and what hangs too far, is `overhang`'s to say: planning asks it too.
//!
//! Areas mm², heights mm along the direction.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};
use std::ops::Deref;

use super::surface::{OWN, Surface};
use crate::geom::{Sets, Vec3};
use crate::overhang::{Footing, Ground, Hang, LOOKS_DOWN, OverhangRule, Relief, Ridge, SAME_HEIGHT_MM, unsupported};

/// What counts, and from where.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeasureRules {
    /// Sine of the steepest overhang, from the vertical.
    pub(super) sine: f64,
    /// A layer, mm.
    pub(super) layer_mm: f64,
    /// So far a line may hang free, mm.
    pub(super) span_mm: f64,
    /// So far it may reach between two ends on material, mm.
    pub(super) bridge_mm: f64,
    /// The table's height in the file's frame, mm.
    pub(super) table_mm: f64,
    /// What layers let pass where facets do not.
    pub(super) layers: OverhangRule,
    /// Whether places that begin in the air and flat ridges count.
    pub(super) faults: bool,
}

/// What a surface needs along one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PieceNeeds {
    pub(super) area_mm2: f64,
    pub(super) beginnings: usize,
    pub(super) ridges: usize,
}

impl PieceNeeds {
    pub(super) fn faults(&self) -> usize {
        self.beginnings + self.ridges
    }

    /// Whether it is nothing but rounding.
    pub(super) fn is_nothing(&self) -> bool {
        self.area_mm2 <= NOTHING_MM2 && self.faults() == 0
    }
}

impl MeasureRules {
    pub(super) fn hang(&self) -> Hang {
        Hang { layer_mm: self.layer_mm, span_mm: self.span_mm, bridge_mm: self.bridge_mm }
    }
}

/// What planning lets pass in a part as rounding, mm², less a tenth.
pub(super) const NOTHING_MM2: f64 = 0.45;
/// A facet this near to the table's surface lies on it, mm.
const ON_TABLE_MM: f64 = 0.05;
/// Rounding of normals: an overhang of exactly the threshold is none.
const SINE_SLACK: f64 = 1e-6;

/// A surface with what is asked of it again and again.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    pub(super) surface: Surface,
    relief: Relief,
    /// By facet: on the table.
    pub(super) on_table: Vec<bool>,
}

impl Deref for Measured {
    type Target = Relief;

    fn deref(&self) -> &Relief {
        &self.relief
    }
}

impl Measured {
    pub(super) fn of(surface: Surface, rules: &MeasureRules) -> Self {
        let relief = Relief::of(surface.vertices.clone(), surface.facets.clone());
        let on_table = (0..surface.facets.len())
            .map(|f| {
                let low = |p: &Vec3| (p.z - rules.table_mm).abs() < ON_TABLE_MM;
                relief.normal[f].z < -0.99 && surface.corners(f).iter().all(low)
            })
            .collect();
        Self { surface, relief, on_table }
    }

    /// What it needs along `up`, standing on the table or on the cap of number `cap`.
    pub(super) fn needs(&self, up: &Vec3, cap: Option<u32>, rules: &MeasureRules) -> PieceNeeds {
        let heights = self.heights(up, cap);
        let stands = |f: usize| self.stands(f, cap);
        let risky = (0..self.area.len()).filter(|&f| self.is_risky(f, up, rules) && !stands(f));
        PieceNeeds {
            area_mm2: risky.map(|f| self.area[f]).sum(),
            beginnings: self.beginnings(&heights, up, cap, rules).len(),
            ridges: self.ridges(up, Some(cap), rules).len(),
        }
    }

    /// Whether its layers lay nothing on nothing as it stands on the table, whatever its facets say.
    pub(super) fn passes(&self, rules: &MeasureRules) -> bool {
        layers_pass(&self.surface, &Vec3::z(), true, |f| self.on_table[f], rules)
    }

    /// Whether `facet` lies on the table, or is of the cap `cap`.
    pub(super) fn stands(&self, facet: usize, cap: Option<u32>) -> bool {
        match cap {
            Some(cap) => self.surface.source[facet] == cap,
            None => self.on_table[facet],
        }
    }

    pub(super) fn is_risky(&self, facet: usize, up: &Vec3, rules: &MeasureRules) -> bool {
        self.normal[facet].dot(up) < -rules.sine - SINE_SLACK
    }

    /// The runs that are too long to hang along `up`; edges of what the part stands on, where that is given, are none.
    pub(super) fn ridges(&self, up: &Vec3, standing: Option<Option<u32>>, rules: &MeasureRules) -> Vec<Ridge> {
        if !rules.faults {
            return Vec::new();
        }
        let stands = |f: usize| standing.is_some_and(|cap| self.stands(f, cap));
        self.relief.ridges(up, stands, &rules.hang())
    }

    /// The vertices' heights along `up`; what stands lies below all else, so that nothing beside it is a lowest place.
    pub(super) fn heights(&self, up: &Vec3, cap: Option<u32>) -> Vec<f64> {
        self.relief.heights(up, |f| self.stands(f, cap))
    }

    /// Vertices where the surface begins along `up`, nicks left out; `heights` as [`Measured::heights`] gives them.
    pub(super) fn beginnings(&self, heights: &[f64], up: &Vec3, cap: Option<u32>, rules: &MeasureRules) -> Vec<u32> {
        if !rules.faults {
            return Vec::new();
        }
        let stands = |v: u32| self.facets_at(v as usize).iter().any(|&f| self.stands(f as usize, cap));
        let found = self.relief.beginnings(heights, up, rules.layer_mm);
        found.into_iter().filter(|&v| !stands(v)).collect()
    }

    /// Whether a cut made a place that planning takes for a lowest one along `up` although the surface goes on down from it: where
    /// caps leave slivers below the tolerance that heights are compared with. `cap` is what the part stands on.
    pub(super) fn has_false_bottom(&self, up: &Vec3, cap: Option<u32>) -> bool {
        let height = |v: u32| self.surface.vertices[v as usize].dot(up);
        let facets = |v: u32| self.facets_at(v as usize).iter().map(|f| *f as usize);
        (0..self.surface.vertices.len() as u32).any(|v| {
            facets(v).any(|f| self.surface.source[f] != OWN)
                && facets(v).any(|f| self.normal[f].dot(up) < LOOKS_DOWN)
                && !facets(v).any(|f| self.stands(f, cap))
                && self.around(v as usize).iter().all(|&w| height(w) >= height(v) - SAME_HEIGHT_MM)
        })
    }

    /// Facets that hang together over vertices, the largest patch first.
    pub(super) fn patches(&self, facets: &[u32]) -> Vec<Vec<u32>> {
        let mut of_vertex = HashMap::new();
        let mut sets = Sets::new(facets.len());
        for (i, &facet) in facets.iter().enumerate() {
            for v in self.surface.facets[facet as usize] {
                match of_vertex.entry(v) {
                    Entry::Occupied(first) => _ = sets.join(*first.get(), i as u32),
                    Entry::Vacant(free) => _ = free.insert(i as u32),
                }
            }
        }
        let mut by_root: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (i, &facet) in facets.iter().enumerate() {
            by_root.entry(sets.root(i as u32)).or_default().push(facet);
        }
        let mut all: Vec<Vec<u32>> = by_root.into_values().collect();
        let area = |p: &Vec<u32>| p.iter().map(|f| self.area[*f as usize]).sum::<f64>();
        all.sort_by(|a, b| area(b).total_cmp(&area(a)));
        all
    }
}

/// Whether the layers of a piece along `up` lay nothing on nothing as it stands on the cap of number `cap`, whatever its facets say.
pub(super) fn piece_passes(piece: &Surface, up: &Vec3, cap: u32, rules: &MeasureRules) -> bool {
    layers_pass(piece, up, false, |f| piece.source[f] == cap, rules)
}

/// Bridges, roofs of holes, and what is tolerated pass.
fn layers_pass(part: &Surface, up: &Vec3, table: bool, stands: impl Fn(usize) -> bool, rules: &MeasureRules) -> bool {
    let own = (0..part.facets.len()).filter(|&f| stands(f)).map(|f| part.corners(f)).collect();
    let ground = Ground { footings: vec![Footing { own, below: Vec::new() }], table, ..Ground::default() };
    unsupported(&part.mesh(), up, &ground, stands, &rules.layers, true).is_empty()
}

/// The share of a facet with corners at heights `h` (any order) that lies above `c`.
pub(super) fn share_above(mut h: [f64; 3], c: f64) -> f64 {
    h.sort_unstable_by(f64::total_cmp);
    let [low, middle, high] = h;
    if c <= low {
        1.0
    } else if c >= high {
        0.0
    } else if c <= middle {
        1.0 - (c - low) / (middle - low) * ((c - low) / (high - low))
    } else {
        (high - c) / (high - low) * ((high - c) / (high - middle))
    }
}
