//! A part cut into columns along a direction: where each column enters and leaves the material.
//!
//! Corners are rounded to 1/256 of a column across the direction, and a column is cut where its middle lies inside a
//! facet, edges counted once by whole-number arithmetic: a closed mesh is entered as often as it is left.

use super::super::Facets;
use super::super::sphere::tangents;
use crate::geom::Vec3;

/// Parts of a column's width to which corners are rounded.
const STEPS: f64 = 256.0;
/// Columns along the longer side at most: beyond, columns are made wider (memory, and the range of whole numbers).
const MOST_COLUMNS: f64 = 4096.0;

/// A surface point of a column.
#[derive(Clone, Copy, Debug)]
struct Hit {
    z: f64,
    facet: u32,
    up: bool,
    next: u32,
}

const NONE: u32 = u32::MAX;

/// The columns of a part along a direction.
pub(crate) struct Raster {
    hits: Vec<Hit>,
    /// The lowest hit of each column.
    first: Vec<u32>,
    columns: usize,
    /// Width of a column, mm.
    pub(crate) width: f64,
    /// The lowest point along the direction: the bed.
    bed: f64,
    /// `x, y, z` of the first column's corner and of the bed, in the part's frame: the axes.
    axes: [Vec3; 3],
    corner: [f64; 2],
}

/// Empty space in a column below a facet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gap {
    /// The column's number.
    pub(crate) column: usize,
    /// Along the direction, mm.
    pub(crate) from: f64,
    /// Along the direction, mm.
    pub(crate) to: f64,
    /// The facet that it ends below.
    pub(crate) above: u32,
    /// The facet that it begins on; none for the bed.
    pub(crate) below: Option<u32>,
}

impl Raster {
    /// Cuts the part along `up` into columns of `width_mm`, or as wide as makes 4096 of the longer side.
    pub(crate) fn of(facets: &Facets, up: &Vec3, width_mm: f64) -> Self {
        let [e1, e2] = tangents(up);
        let flat: Vec<[f64; 3]> = facets.points.iter().map(|p| [p.dot(&e1), p.dot(&e2), p.dot(up)]).collect();
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in &flat {
            for k in 0..3 {
                (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k]));
            }
        }
        if flat.is_empty() {
            (low, high) = ([0.0; 3], [0.0; 3]);
        }
        let longer = (high[0] - low[0]).max(high[1] - low[1]);
        let width = width_mm.max(longer / MOST_COLUMNS);
        let count = |k: usize| ((high[k] - low[k]) / width).ceil().max(1.0) as usize;
        let (columns, rows) = (count(0), count(1));
        let axes = [e1, e2, *up];
        let (hits, first) = (Vec::with_capacity(4 * columns * rows), vec![NONE; columns * rows]);
        let mut raster = Self { hits, first, columns, width, bed: low[2], axes, corner: [low[0], low[1]] };
        let whole = |v: f64, k: usize| ((v - low[k]) / width * STEPS).round() as i64;
        let corners: Vec<([i64; 2], f64)> = flat.iter().map(|p| ([whole(p[0], 0), whole(p[1], 1)], p[2])).collect();
        for (i, facet) in facets.corners.iter().enumerate() {
            raster.cut(i as u32, facet.map(|c| corners[c as usize]), rows);
        }
        raster
    }

    /// Adds the hits of one facet.
    fn cut(&mut self, facet: u32, corners: [([i64; 2], f64); 3], rows: usize) {
        let [(a, za), (mut b, mut zb), (mut c, mut zc)] = corners;
        let twice =
            |a: [i64; 2], b: [i64; 2], c: [i64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let area = twice(a, b, c);
        if area == 0 {
            return;
        }
        let up = area > 0;
        if !up {
            (b, zb, c, zc) = (c, zc, b, zb);
        }
        let area = area.abs();
        let [x0, y0, x1, y1] =
            [a[0].min(b[0]).min(c[0]), a[1].min(b[1]).min(c[1]), a[0].max(b[0]).max(c[0]), a[1].max(b[1]).max(c[1])];
        let step = STEPS as i64;
        // The first middle, an odd number of half columns, not below the least corner.
        let begin = |v: i64| (v - step / 2 + step - 1).div_euclid(step).max(0);
        let end = |v: i64, count: usize| (v - step / 2).div_euclid(step).min(count as i64 - 1);
        let (i0, i1, j1) = (begin(x0), end(x1, self.columns), end(y1, rows));
        // An edge that runs through a middle belongs to the facet on its left, or below it.
        let edge = |p: [i64; 2], q: [i64; 2]| {
            let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
            let owns = dy < 0 || (dy == 0 && dx > 0);
            (dx, dy, if owns { 0 } else { 1 })
        };
        let (ab, bc, ca) = (edge(a, b), edge(b, c), edge(c, a));
        for j in begin(y0)..=j1 {
            let y = j * step + step / 2;
            for i in i0..=i1 {
                let x = i * step + step / 2;
                let side = |e: (i64, i64, i64), p: [i64; 2]| e.0 * (y - p[1]) - e.1 * (x - p[0]);
                let (wc, wa, wb) = (side(ab, a), side(bc, b), side(ca, c));
                if wc >= ab.2 && wa >= bc.2 && wb >= ca.2 {
                    let z = (wa as f64 * za + wb as f64 * zb + wc as f64 * zc) / area as f64;
                    self.add(j as usize * self.columns + i as usize, z, facet, up);
                }
            }
        }
    }

    /// Puts a hit in its place, lowest first; where two are as high, material is left before it is entered.
    fn add(&mut self, column: usize, z: f64, facet: u32, up: bool) {
        let index = self.hits.len() as u32;
        let mut before = NONE;
        let mut at = self.first[column];
        while at != NONE && (self.hits[at as usize].z, !self.hits[at as usize].up) < (z, !up) {
            before = at;
            at = self.hits[at as usize].next;
        }
        self.hits.push(Hit { z, facet, up, next: at });
        if before == NONE { self.first[column] = index } else { self.hits[before as usize].next = index }
    }

    /// Every gap: below where a column enters the material from outside, down to where it left it, or to the bed.
    pub(crate) fn gaps(&self) -> impl Iterator<Item = Gap> + '_ {
        self.first.iter().enumerate().flat_map(move |(column, &first)| {
            let (mut at, mut depth, mut from, mut below) = (first, 0i32, self.bed, None);
            std::iter::from_fn(move || {
                while at != NONE {
                    let hit = &self.hits[at as usize];
                    at = hit.next;
                    if hit.up {
                        depth -= 1;
                        (from, below) = if depth <= 0 { (hit.z, Some(hit.facet)) } else { (from, below) };
                        depth = depth.max(0);
                        continue;
                    }
                    depth += 1;
                    if depth == 1 {
                        return Some(Gap { column, from, to: hit.z, above: hit.facet, below });
                    }
                }
                None
            })
        })
    }

    #[cfg(test)]
    pub(crate) fn first_len(&self) -> usize {
        self.first.len()
    }

    /// A column's middle across the direction, along its two [`tangents`].
    pub(crate) fn flat(&self, column: usize) -> [f64; 2] {
        let middle = |k: usize, i: usize| self.corner[k] + (i as f64 + 0.5) * self.width;
        [middle(0, column % self.columns), middle(1, column / self.columns)]
    }

    /// The point of a column's middle at a height along the direction, in the part's frame.
    pub(crate) fn point(&self, column: usize, z: f64) -> Vec3 {
        let [x, y] = self.flat(column);
        self.axes[0] * x + self.axes[1] * y + self.axes[2] * z
    }
}
