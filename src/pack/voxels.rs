//! A solid as cells of a grid: every cell that it may touch, and those within a gap of them.
//!
//! Both err on the safe side: a cell counts as touched when a facet or the inside comes into its open box, and a cell lies within the gap when its
//! nearest point to a touched cell does. Two solids whose cells are apart from each other's grown cells are apart by the gap, exactly.

use crate::geom::{Bounds, Vec3};

/// What a facet may stick into a cell without touching it, cells: rounding of a face that lies in the grid's own plane.
const GRAZE: f64 = 1e-7;
/// Where in a cell its inside is asked for: no mesh has its edges there.
const ASIDE: [f64; 2] = [0.500_313_7, 0.499_708_1];

/// A run of cells along x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Span {
    pub(super) z: i32,
    pub(super) y: i32,
    pub(super) from: i32,
    /// The first cell behind it.
    pub(super) to: i32,
}

/// The cells of a solid whose box has its low corner at the grid's origin.
#[derive(Clone, Debug)]
pub(super) struct Voxels {
    pub(super) size: [i32; 3],
    /// By z, y and x, none touching the next.
    pub(super) spans: Vec<Span>,
}

/// The cells of edge `step` that the closed solid `facets` touches.
pub(super) fn voxels(facets: &[[Vec3; 3]], step: f64) -> Voxels {
    let bounds = Bounds::of(facets.iter().flatten().copied());
    let size: [i32; 3] = bounds.size().map(|length| ((length / step - GRAZE).ceil() as i32).max(1)).into();
    let corner = |p: &Vec3| (p - bounds.min) / step;
    let mut spans = Vec::new();
    let mut crossings: Vec<Vec<(f64, i32)>> = vec![Vec::new(); (size[1] * size[2]) as usize];
    for facet in facets {
        let facet = [0, 1, 2].map(|k| corner(&facet[k]));
        surface(&facet, &size, &mut spans);
        cross(&facet, &size, &mut crossings);
    }
    for (row, crossings) in crossings.iter_mut().enumerate() {
        let (y, z) = (row as i32 % size[1], row as i32 / size[1]);
        inside(crossings, |from, to| spans.push(Span { z, y, from, to: to.min(size[0]) }));
    }
    Voxels { size, spans: joined(spans) }
}

/// The cells along x that a facet comes into, row by row: it is cut at the planes between layers, then between rows.
fn surface(facet: &[Vec3; 3], size: &[i32; 3], spans: &mut Vec<Span>) {
    for (z, layer) in slabs(facet, 2, size[2]) {
        for (y, piece) in slabs(&layer, 1, size[1]) {
            let [low, high] = reach(&piece, 0);
            let (from, to) = ((low + GRAZE).floor().max(0.0) as i32, (high - GRAZE).ceil() as i32);
            if from < to.min(size[0]) {
                spans.push(Span { z, y, from, to: to.min(size[0]) });
            }
        }
    }
}

pub(super) fn reach(points: &[Vec3], axis: usize) -> [f64; 2] {
    points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| [low.min(p[axis]), high.max(p[axis])])
}

/// What of a convex polygon lies in each unit slab along `axis`.
pub(super) fn slabs(polygon: &[Vec3], axis: usize, count: i32) -> impl Iterator<Item = (i32, Vec<Vec3>)> {
    let [low, high] = reach(polygon, axis);
    let (first, last) = ((low + GRAZE).floor().max(0.0) as i32, ((high - GRAZE).ceil() as i32).min(count));
    (first..last).filter_map(move |slab| {
        let above = cut(polygon, axis, f64::from(slab), 1.0);
        let within = cut(&above, axis, f64::from(slab + 1), -1.0);
        (!within.is_empty()).then_some((slab, within))
    })
}

/// What of a convex polygon lies on one side of a plane (Sutherland and Hodgman 1974).
fn cut(polygon: &[Vec3], axis: usize, at: f64, side: f64) -> Vec<Vec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        let (to_a, to_b) = (side * (a[axis] - at), side * (b[axis] - at));
        if to_a >= 0.0 {
            kept.push(*a);
        }
        if (to_a < 0.0) != (to_b < 0.0) {
            let mut on = a + (b - a) * (to_a / (to_a - to_b));
            on[axis] = at;
            kept.push(on);
        }
    }
    kept
}

/// Where the rows' middle lines go through a facet, and whether inward (1) or outward.
fn cross([a, b, c]: &[Vec3; 3], size: &[i32; 3], crossings: &mut [Vec<(f64, i32)>]) {
    let normal = (b - a).cross(&(c - a));
    if normal.x == 0.0 {
        return;
    }
    let [low_y, high_y] = reach(&[*a, *b, *c], 1);
    let [low_z, high_z] = reach(&[*a, *b, *c], 2);
    let first = |low: f64, aside: f64| (low - aside).ceil().max(0.0) as i32;
    for z in first(low_z, ASIDE[1])..size[2] {
        let at_z = f64::from(z) + ASIDE[1];
        if at_z > high_z {
            break;
        }
        for y in first(low_y, ASIDE[0])..size[1] {
            let at_y = f64::from(y) + ASIDE[0];
            if at_y > high_y {
                break;
            }
            let side = |p: &Vec3, q: &Vec3| (q.y - p.y) * (at_z - p.z) - (q.z - p.z) * (at_y - p.y);
            let turn = [side(a, b), side(b, c), side(c, a)];
            if turn.iter().all(|&t| t >= 0.0) || turn.iter().all(|&t| t <= 0.0) {
                let x = a.x - (normal.y * (at_y - a.y) + normal.z * (at_z - a.z)) / normal.x;
                crossings[(z * size[1] + y) as usize].push((x, if normal.x < 0.0 { 1 } else { -1 }));
            }
        }
    }
}

/// The cells whose middles lie inside, from where a row's line goes in and out.
fn inside(crossings: &mut [(f64, i32)], mut found: impl FnMut(i32, i32)) {
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut depth = 0;
    for pair in crossings.windows(2) {
        depth += pair[0].1;
        if depth > 0 {
            let (from, to) = ((pair[0].0 - 0.5).ceil().max(0.0) as i32, (pair[1].0 + 0.5).floor() as i32);
            if from < to {
                found(from, to);
            }
        }
    }
}

fn joined(mut spans: Vec<Span>) -> Vec<Span> {
    spans.sort_unstable();
    let mut all: Vec<Span> = Vec::with_capacity(spans.len() / 4);
    for span in spans {
        match all.last_mut() {
            Some(last) if (last.z, last.y) == (span.z, span.y) && span.from <= last.to => {
                last.to = last.to.max(span.to)
            }
            _ => all.push(span),
        }
    }
    all
}

impl Voxels {
    /// With all cells less than `gap` away, in cells: nearer than that lies some point of them to some point of this.
    pub(super) fn grown(&self, gap: f64) -> Vec<Span> {
        let reach = (gap - GRAZE).max(0.0).floor() as i32 + i32::from(gap > 0.0);
        let away = |d: i32| f64::from((d.abs() - 1).max(0)).powi(2);
        let mut spans = Vec::new();
        for span in &self.spans {
            for dz in -reach..=reach {
                for dy in -reach..=reach {
                    let left = gap * gap - away(dz) - away(dy);
                    if left <= GRAZE && reach > 0 {
                        continue;
                    }
                    let dx = if reach == 0 { 0 } else { (left.sqrt() - GRAZE).floor() as i32 + 1 };
                    let (z, y, from, to) = (span.z + dz, span.y + dy, span.from - dx, span.to + dx);
                    spans.push(Span { z, y, from, to });
                }
            }
        }
        joined(spans)
    }

    /// How many cells.
    #[cfg(test)]
    pub(super) fn count(&self) -> usize {
        self.spans.iter().map(|s| (s.to - s.from) as usize).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;
    use crate::geom::SplitMix64;

    fn facets(size: [f64; 3]) -> Vec<[Vec3; 3]> {
        let mesh = solid_box(Vec3::zeros(), size.into());
        (0..mesh.facets().len()).map(|i| mesh.corners(i)).collect()
    }

    #[test]
    fn a_box_on_the_grid_takes_just_its_cells() {
        assert_eq!(voxels(&facets([3.0, 4.0, 5.0]), 1.0).count(), 60);
        assert_eq!(voxels(&facets([3.0, 4.0, 5.0]), 0.5).count(), 480);
        assert_eq!(voxels(&facets([3.1, 4.0, 5.0]), 1.0).count(), 80);
        // A cell further on each side where the gap is one cell, and its corners too.
        let cells: i32 = voxels(&facets([3.0, 4.0, 5.0]), 1.0).grown(1.0).iter().map(|s| s.to - s.from).sum();
        assert_eq!(cells, 5 * 6 * 7);
        let none: i32 = voxels(&facets([3.0, 4.0, 5.0]), 1.0).grown(0.0).iter().map(|s| s.to - s.from).sum();
        assert_eq!(none, 60);
    }

    /// Any tetrahedron: cells that hold a point of it are taken, and cells far from it are not.
    #[test]
    fn all_that_a_solid_touches_is_taken() {
        let mut numbers = SplitMix64::seeded(5);
        for _ in 0..30 {
            let corners = [(); 4].map(|()| Vec3::new(numbers.unit(), numbers.unit(), numbers.unit()) * 9.0);
            let [a, b, c, d] = corners;
            let out = (b - a).cross(&(c - a)).dot(&(d - a)) < 0.0;
            let facets = if out {
                [[a, b, c], [a, d, b], [a, c, d], [b, d, c]]
            } else {
                [[a, c, b], [a, b, d], [a, d, c], [b, c, d]]
            };
            let low = Bounds::of(corners).min;
            let made = voxels(&facets, 1.0);
            let grown = made.grown(1.5);
            let has = |spans: &[Span], p: &Vec3| {
                let [x, y, z] = [p.x, p.y, p.z].map(|v| v.floor() as i32);
                spans.iter().any(|s| (s.z, s.y) == (z, y) && (s.from..s.to).contains(&x))
            };
            for _ in 0..400 {
                let mut shares = [(); 4].map(|()| -(1.0 - numbers.unit()).ln());
                let sum: f64 = shares.iter().sum();
                shares.iter_mut().for_each(|s| *s /= sum);
                let point: Vec3 = (0..4).map(|k| (corners[k] - low) * shares[k]).sum();
                assert!(has(&made.spans, &point));
                let near = point + numbers.direction() * 1.49;
                assert!(has(&grown, &near), "{near} beside {point}");
            }
            // No more than a cell around the solid is taken.
            let volume = (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0;
            let area: f64 = facets.iter().map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0).sum();
            assert!(made.count() as f64 <= volume + 1.8 * area + 60.0);
        }
    }
}
