//! How well the surfaces that two parts share are filled: places all over them, and whether lines of both parts reach there.
//!
//! A place counts as filled where a line of each part is within [`REACH_MM`]. Lines are taken as upright slabs, as wide and as high as they are laid.

use hashbrown::HashMap;

use super::ReplayJob;
use super::evidence::{Checked, Evidence, Figures};
use super::prints::{Level, PrintedPart};
use super::report::{Findings, InterfaceFill};
use crate::geom::{Bounds, Table, Vec3};
use crate::mesh::{INTERFACE_GAP_MM, Interface, TriangleMesh};
use crate::section::to_segment;

/// Places lie about so far from each other, mm.
const SPACING_MM: f64 = 0.4;
/// More places of one interface than this lie farther apart.
const MOST_PLACES: f64 = 20_000.0;
/// What counts as reached, mm: outlines are rounded and compensated by about as much.
const REACH_MM: f64 = 0.15;
/// Facets that share so much of their area are shared all over.
const ALL_OF_IT: f64 = 0.999;
/// Edge of a cell by which places are found, mm; no line is half as wide.
const CELL_MM: f64 = 1.5;
/// Lines are followed in steps of so much, mm.
const STEP_MM: f64 = 1.0;

/// Each interface of the model whose two parts were printed.
pub(super) fn check(evidence: &Evidence<'_>) -> Checked {
    Checked { findings: Findings::default(), figures: Figures::Interfaces(filled(evidence)) }
}

fn filled(&Evidence { printed, job, .. }: &Evidence<'_>) -> Vec<InterfaceFill> {
    let of = |part: usize| printed.iter().flatten().find(|print| print.planned.part == part);
    let each = job.workpiece.model.interfaces.iter().filter_map(|one| {
        let prints = [of(one.a)?, of(one.b)?];
        let places = places(one, [&job.workpiece.parts[one.a], &job.workpiece.parts[one.b]]);
        let reached = prints.map(|print| reached(print, &places, job));
        let all: f64 = places.iter().map(|place| place.area_mm2).sum();
        let both = places.iter().enumerate().filter(|(i, _)| reached[0][*i] && reached[1][*i]);
        let filled: f64 = both.map(|(_, place)| place.area_mm2).sum();
        let share = filled / all;
        let (parts, area_mm2) = ([one.a, one.b], one.area_mm2);
        share.is_finite().then_some(InterfaceFill { parts, area_mm2, filled_mm2: share * area_mm2, share })
    });
    let mut all: Vec<InterfaceFill> = each.collect();
    all.sort_by(|a, b| a.share.total_cmp(&b.share).then(a.parts.cmp(&b.parts)));
    all
}

/// A place on an interface, table frame, with the area that it stands for.
struct Place {
    at: Vec3,
    area_mm2: f64,
}

/// Places on the first part's facets, as far as the second part's are there too.
fn places(one: &Interface, [first, second]: [&TriangleMesh<Table>; 2]) -> Vec<Place> {
    let spacing = SPACING_MM.max((one.area_mm2 / MOST_PLACES).sqrt());
    let others: Vec<([Vec3; 3], Bounds)> =
        one.facets_b.iter().map(|(facet, _)| boxed(second.corners(*facet))).collect();
    let mut all = Vec::new();
    for (facet, shared_mm2) in &one.facets_a {
        let corners = first.corners(*facet);
        let area_mm2 = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm() / 2.0;
        let is_shared = |p: &Vec3| {
            let near = others.iter().filter(|(_, bounds)| bounds.holds(p));
            *shared_mm2 >= ALL_OF_IT * area_mm2 || near.into_iter().any(|(other, _)| is_over(p, other))
        };
        each_place(corners, spacing, |at, share| {
            if is_shared(&at) {
                all.push(Place { at, area_mm2: area_mm2 * share });
            }
        });
    }
    all
}

fn boxed(corners: [Vec3; 3]) -> ([Vec3; 3], Bounds) {
    (corners, Bounds::of(corners).inflated(2.0 * INTERFACE_GAP_MM))
}

/// The middles of a facet's parts that are about so large, each with its share of the facet.
fn each_place([a, b, c]: [Vec3; 3], spacing: f64, mut visit: impl FnMut(Vec3, f64)) {
    let area_mm2 = (b - a).cross(&(c - a)).norm() / 2.0;
    let steps = ((2.0 * area_mm2).sqrt() / spacing).ceil().max(1.0) as usize;
    let (along, aside) = ((b - a) / steps as f64, (c - a) / steps as f64);
    let share = 1.0 / (steps * steps) as f64;
    for i in 0..steps {
        for j in 0..steps - i {
            let corner = a + along * i as f64 + aside * j as f64;
            visit(corner + (along + aside) / 3.0, share);
            if i + j + 1 < steps {
                visit(corner + (along + aside) * (2.0 / 3.0), share);
            }
        }
    }
}

/// Whether a place near a facet's plane is over the facet.
fn is_over(p: &Vec3, [a, b, c]: &[Vec3; 3]) -> bool {
    let normal = (b - a).cross(&(c - a));
    let length = normal.norm();
    let inside = |from: &Vec3, to: &Vec3| (to - from).cross(&(p - from)).dot(&normal) >= -1e-9 * length * length;
    length > 0.0
        && ((p - a).dot(&normal) / length).abs() <= 2.0 * INTERFACE_GAP_MM
        && inside(a, b)
        && inside(b, c)
        && inside(c, a)
}

/// Which places a print's lines reach.
fn reached(print: &PrintedPart<'_>, places: &[Place], job: &ReplayJob<'_>) -> Vec<bool> {
    let upright = job.profile.kinematics().forward(print.planned.pose);
    let points: Vec<Vec3> = places.iter().map(|place| upright.point(place.at.into()).at).collect();
    let mut reach =
        Reach { cells: HashMap::new(), bounds: Bounds::of(points.iter().copied()), found: vec![false; points.len()] };
    for (i, p) in points.iter().enumerate() {
        reach.cells.entry([p.x, p.y, p.z].map(cell)).or_insert_with(Vec::new).push(i as u32);
    }
    for level in &print.levels {
        let [low, high] = [level.z - level.height() - REACH_MM, level.z + REACH_MM];
        if high >= reach.bounds.min.z && low <= reach.bounds.max.z {
            reach.lay(print, level, &points);
        }
    }
    reach.found
}

fn cell(mm: f64) -> i32 {
    (mm / CELL_MM).floor() as i32
}

/// Places by cell, and which of them are reached.
struct Reach {
    cells: HashMap<[i32; 3], Vec<u32>>,
    bounds: Bounds,
    found: Vec<bool>,
}

impl Reach {
    fn lay(&mut self, print: &PrintedPart<'_>, level: &Level, points: &[Vec3]) {
        for &index in &level.beads {
            let m = print.bead(index);
            let Some([from, to]) = m.ends() else { continue };
            let half = print.laid_width(&m, level) / 2.0;
            let Some([from, to]) = self.near(from, to, half + REACH_MM) else { continue };
            let steps = ((to - from).norm() / STEP_MM).ceil().max(1.0) as usize;
            for k in 0..=steps {
                let at = from + (to - from) * (k as f64 / steps as f64);
                self.look(&at, [from, to], half, level, points);
            }
        }
    }

    /// The stretch of a line that comes near any place.
    fn near(&self, from: Vec3, to: Vec3, mm: f64) -> Option<[Vec3; 2]> {
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let (low, high) = (self.bounds.min[axis] - mm, self.bounds.max[axis] + mm);
            let (start, way) = (from[axis], to[axis] - from[axis]);
            if way.abs() < 1e-9 {
                if start < low || start > high {
                    return None;
                }
                continue;
            }
            let ends = [(low - start) / way, (high - start) / way];
            first = first.max(ends[0].min(ends[1]));
            last = last.min(ends[0].max(ends[1]));
        }
        (first <= last).then(|| [first, last].map(|share| from + (to - from) * share))
    }

    /// Notes the places in the cells about `at`, a place on a line, that the line reaches.
    fn look(&mut self, at: &Vec3, line: [Vec3; 2], half: f64, level: &Level, points: &[Vec3]) {
        let [low, high] = [level.z - level.height(), level.z];
        let [column, row] = [at.x, at.y].map(cell);
        let above = line.map(|p| [p.x, p.y]);
        for layer in cell(low - REACH_MM)..=cell(high + REACH_MM) {
            for key in (-1..=1).flat_map(|i| (-1..=1).map(move |j| [column + i, row + j, layer])) {
                for &i in self.cells.get(&key).into_iter().flatten() {
                    let (p, found) = (&points[i as usize], &mut self.found[i as usize]);
                    let upward = (low - p.z).max(p.z - high).max(0.0);
                    if !*found && upward <= REACH_MM {
                        let sideways = (to_segment([p.x, p.y], above) - half).max(0.0);
                        *found = upward * upward + sideways * sideways <= REACH_MM * REACH_MM;
                    }
                }
            }
        }
    }
}
