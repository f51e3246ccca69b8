//! Walls are whole: no slit at one place of several layers, and as thick as in most other layers.
//!
//! Places along the outline are looked at one by one: what lies just inside it, and how deep plastic goes on from there. Where sparse infill is
//! beside the walls, that depth is theirs; infill that meets them only adds to it.

use super::super::prints::PrintedPart;
use super::super::report::Findings;
use super::map::{Frame, Mask};
use super::{Layer, Told, add};
use crate::section::PlanePoint;

/// Spacing of the places, mm.
pub(super) const SPACING_MM: f64 = 0.5;
/// Below this share there is no wall at a place, nor does one go on.
const BARE: f64 = 0.4;
/// Where an outer wall is looked for, mm inside the outline.
const OUTER_MM: [f64; 2] = [0.15, 0.3];
/// Slopes, as mm outward per mm of height: what leans farther says nothing of slits, and of the depth of walls.
const SLIT_SLOPE: f64 = 1.0;
const STEEP: f64 = 0.2;
/// A slit shorter than this is a seam, mm.
pub(in crate::verify) const SLIT_MM: f64 = 1.0;
/// On so many layers one after the other it is none.
pub(in crate::verify) const SLIT_LAYERS: usize = 3;
/// Places of one slit lie no farther apart, mm, nor the slits of two layers that are one.
const JOINED_MM: f64 = 0.8;
/// More bare places of a layer than this are not told apart: the rule `registration` has them.
const MOST_BARE: usize = 400;
/// How deep plastic is followed, mm, and in which steps.
const DEEPEST_MM: f64 = 1.3;
const STEP_MM: f64 = 0.1;
/// What lies deeper, mm; where it is fuller than this share there is no sparse infill beside the walls.
const DEEP_MM: [f64; 2] = [1.6, 3.0];
const SPARSE: f64 = 0.5;
/// And at how many places it is asked.
const DEEP_PLACES: u32 = 8;
/// One in so many places may have thinner walls than a layer is taken to have.
const FEW: usize = 33;
/// How much thinner walls are where one is missing, mm.
const THINNER_MM: f64 = 0.25;
/// How much of a layer's outline may be so, mm, and as a part of what is beside sparse infill.
const THIN_WALL_MM: f64 = 6.0;
const THIN_WALL_SHARE: f64 = 0.1;
/// Layers with less outline beside sparse infill say nothing, mm; and prints with fewer such layers.
pub(super) const TELLING_MM: f64 = 10.0;
pub(super) const TELLING_LAYERS: usize = 6;

/// What is seen along one layer's outline.
pub(super) struct Seen {
    slits: Vec<Slit>,
    /// How deep walls go beside sparse infill, mm, shallowest first; one a place.
    depths: Vec<f32>,
    thinnest_at: PlanePoint,
}

/// Places without an outer wall beside each other.
#[derive(Clone, Copy)]
struct Slit {
    middle: PlanePoint,
    length_mm: f64,
}

impl Seen {
    pub(super) fn of(layer: &Layer<'_>) -> Self {
        let (mut bare, mut places) = (Vec::new(), 0);
        let mut depths: Vec<(f32, PlanePoint)> = Vec::new();
        each_place(layer, |p, normal, slope| {
            if slope.abs() > SLIT_SLOPE {
                return;
            }
            places += 1;
            let inside = |mm: f64| [p[0] - normal[0] * mm, p[1] - normal[1] * mm];
            let outer: f64 = OUTER_MM.iter().map(|&mm| layer.plastic.at(inside(mm))).sum::<f64>() / 2.0;
            if outer < BARE && is_wide(&layer.mask, p, normal, 0.7) {
                bare.push(p);
            }
            if slope.abs() <= STEEP && is_wide(&layer.mask, p, normal, 1.6) {
                depths.extend(depth(layer, p, normal).map(|depth| (depth as f32, p)));
            }
        });
        // Where a good part is so, the walls lie elsewhere: compensated, or moved.
        let few = bare.len() <= MOST_BARE && bare.len() * 4 <= places;
        depths.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1[0].total_cmp(&b.1[0])));
        Self {
            slits: if few { slits(bare) } else { Vec::new() },
            thinnest_at: depths.first().map_or([0.0; 2], |(_, p)| *p),
            depths: depths.into_iter().map(|(depth, _)| depth).collect(),
        }
    }

    pub(super) fn depths(&self) -> &[f32] {
        &self.depths
    }

    /// How deep the walls of a layer go but at a few places, mm; `None` where too little is beside sparse infill.
    fn depth(&self) -> Option<f64> {
        let tells = self.depths.len() as f64 * SPACING_MM >= TELLING_MM;
        tells.then(|| f64::from(self.depths[(self.depths.len() / FEW).max(2)]))
    }
}

/// Visits places along the outline with their outward normals and how the outline moves with the height.
fn each_place(layer: &Layer<'_>, mut visit: impl FnMut(PlanePoint, PlanePoint, f64)) {
    let mut owed = SPACING_MM / 2.0;
    for ([a, b], slope) in &layer.outline {
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let length = dx.hypot(dy);
        while owed <= length {
            let share = owed / length;
            visit([a[0] + dx * share, a[1] + dy * share], [dy / length, -dx / length], *slope);
            owed += SPACING_MM;
        }
        owed -= length;
    }
}

/// Whether the part is `across` wide behind a place and begins at it: no corner, no thin wall, no seam of two shells.
fn is_wide(mask: &Mask, p: PlanePoint, normal: PlanePoint, across: f64) -> bool {
    let tangent = [-normal[1], normal[0]];
    let at =
        |inward: f64, along: f64| mask.at(Frame::cell([0, 1].map(|i| p[i] - normal[i] * inward + tangent[i] * along)));
    if at(-0.35, 0.0) != 0 {
        return false;
    }
    let steps = (across / 0.25) as usize;
    (1..=2 * steps).all(|k| at(0.25 * k as f64, 0.0) == super::map::SOLID)
        && [-0.7, 0.7].iter().all(|share| {
            let along = share * across;
            let near = across * 0.35;
            at(across, along) == super::map::SOLID && at(near.max(0.25), along * 0.7) == super::map::SOLID
        })
}

/// How deep plastic goes on from the outline, mm; `None` where what is beyond is not sparse.
fn depth(layer: &Layer<'_>, p: PlanePoint, normal: PlanePoint) -> Option<f64> {
    let tangent = [-normal[1], normal[0]];
    let at = |inward: f64| -> f64 {
        let one = |along: f64| layer.plastic.at([0, 1].map(|i| p[i] - normal[i] * inward + tangent[i] * along));
        (one(-0.3) + one(0.0) + one(0.3)) / 3.0
    };
    // The sum only grows: where all is solid half of it tells.
    let mut deep = 0.0;
    for k in 0..DEEP_PLACES {
        deep += at(DEEP_MM[0] + (DEEP_MM[1] - DEEP_MM[0]) * f64::from(k) / f64::from(DEEP_PLACES - 1));
        if deep > SPARSE * f64::from(DEEP_PLACES) {
            return None;
        }
    }
    let mut mm = 0.3;
    while mm < DEEPEST_MM && at(mm) >= BARE {
        mm += STEP_MM;
    }
    Some(mm)
}

/// Bare places beside each other.
fn slits(mut bare: Vec<PlanePoint>) -> Vec<Slit> {
    bare.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut found = Vec::new();
    while let Some(first) = bare.pop() {
        let (mut group, mut next) = (vec![first], 0);
        while next < group.len() {
            let p = group[next];
            let (near, far): (Vec<PlanePoint>, Vec<PlanePoint>) =
                bare.into_iter().partition(|q| away(p, *q) <= JOINED_MM);
            bare = far;
            group.extend(near);
            next += 1;
        }
        let count = group.len() as f64;
        let middle = [0, 1].map(|i| group.iter().map(|p| p[i]).sum::<f64>() / count);
        found.push(Slit { middle, length_mm: count * SPACING_MM });
    }
    found
}

fn away(a: PlanePoint, b: PlanePoint) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

pub(super) fn check(printed: &PrintedPart<'_>, told: &[Told], findings: &mut Findings) {
    slit(printed, told, findings);
    thickness(printed, told, findings);
}

/// Slits that go on from layer to layer.
fn slit(printed: &PrintedPart<'_>, told: &[Told], findings: &mut Findings) {
    // Where each slit of the layer below began.
    let mut going: Vec<(Slit, usize)> = Vec::new();
    for (index, layer) in told.iter().enumerate() {
        let mut next = Vec::new();
        for slit in layer.walls.slits.iter().filter(|slit| slit.length_mm >= SLIT_MM) {
            let near = |(below, _): &&(Slit, usize)| {
                away(below.middle, slit.middle) <= JOINED_MM + (below.length_mm - slit.length_mm).abs() / 2.0
            };
            let start = going.iter().find(near).map_or(index, |(_, start)| *start);
            if index - start + 1 == SLIT_LAYERS {
                let [x, y] = slit.middle;
                add(printed, layer.line, [slit.length_mm, SLIT_MM], findings, || {
                    format!(
                        "{:.1} mm of the outer wall of part {} is missing at X {x:.2} Y {y:.2} in {SLIT_LAYERS} successive layers up to Z {:.2} (maximum {SLIT_MM} mm)",
                        slit.length_mm, printed.planned.part, layer.z
                    )
                });
            }
            next.push((*slit, start));
        }
        going = next;
    }
}

/// Layers whose walls are thinner than those of most.
fn thickness(printed: &PrintedPart<'_>, told: &[Told], findings: &mut Findings) {
    let mut all: Vec<f64> = told.iter().filter_map(|layer| layer.walls.depth()).collect();
    if all.len() < TELLING_LAYERS {
        return;
    }
    all.sort_by(f64::total_cmp);
    let usual = all[all.len() / 3];
    for layer in told {
        let least = usual - THINNER_MM;
        let thin = layer.walls.depths.partition_point(|depth| f64::from(*depth) < least);
        let (mm, of) = (thin as f64 * SPACING_MM, layer.walls.depths.len() as f64 * SPACING_MM);
        if mm > THIN_WALL_MM.max(THIN_WALL_SHARE * of) {
            let [x, y] = layer.walls.thinnest_at;
            let most = THIN_WALL_MM.max(THIN_WALL_SHARE * of);
            add(printed, layer.line, [mm, most], findings, || {
                format!(
                    "{mm:.0} mm of the outline of part {} at Z {:.2} has thin walls (maximum {most:.0} mm): {:.2} mm at X {x:.1} Y {y:.1}, {usual:.2} mm in most layers",
                    printed.planned.part, layer.z, layer.walls.depths[0]
                )
            });
        }
    }
}
