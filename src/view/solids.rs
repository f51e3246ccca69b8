//! Surfaces seen from somewhere, with hidden ones hidden: a depth buffer whose places say which facet is in front.
//!
//! A facet belongs to a smooth patch of its surface (facets that meet at less than [`CREASE_DEG`]); where patches or surfaces meet on
//! paper there is a line, within a patch only the shade changes.

use std::collections::HashMap;

use super::drawing::Colour;
use super::eye::Eye;
use super::regions::{Labels, NOTHING};
use crate::geom::Vec3;
use crate::mesh::TriangleMesh;

/// Facets that meet at a larger angle meet in an edge.
const CREASE_DEG: f64 = 28.0;
/// Shades of a colour.
const SHADES: f64 = 11.0;
/// A facet seen from behind gives way to one seen from before at the same place, mm.
const BEHIND_MM: f64 = 0.02;

/// What a surface is to what is printed now; a line is marked where new material meets old.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joint {
    /// Neither.
    None,
    /// Printed before.
    Old,
    /// Printed now.
    New,
}

/// A surface to be drawn: triangles in the frame of the picture, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Corners.
    pub points: Vec<Vec3>,
    /// Triples of their indices.
    pub facets: Vec<[u32; 3]>,
    /// The colour of facets that have none of their own.
    pub colour: Colour,
    /// Facets with a colour of their own; ascending.
    pub marked: Vec<(usize, Colour)>,
    /// Written on it.
    pub name: Option<String>,
    /// Whether it is what the picture is about: the eye is chosen so that it is seen.
    pub wanted: bool,
    /// What it is to what is printed.
    pub joint: Joint,
    /// Whether its edges are drawn.
    pub edges: bool,
    /// Whether it is there only where its front is seen: a bed that is looked at from below hides nothing.
    pub front_only: bool,
}

impl Surface {
    /// A mesh in one colour.
    pub fn of<F>(mesh: &TriangleMesh<F>, colour: Colour) -> Self {
        Self::new(mesh.vertices().to_vec(), mesh.facets().to_vec(), colour)
    }

    /// Triangles in one colour.
    pub fn new(points: Vec<Vec3>, facets: Vec<[u32; 3]>, colour: Colour) -> Self {
        Self {
            points,
            facets,
            colour,
            marked: Vec::new(),
            name: None,
            wanted: false,
            joint: Joint::None,
            edges: true,
            front_only: false,
        }
    }

    fn corners(&self, facet: usize) -> [Vec3; 3] {
        self.facets[facet].map(|i| self.points[i as usize])
    }

    /// The unit normal; `None` for a facet without area.
    fn normal(&self, facet: usize) -> Option<Vec3> {
        let [a, b, c] = self.corners(facet);
        let normal = (b - a).cross(&(c - a));
        let length = normal.norm();
        (length > 0.0).then(|| normal / length)
    }

    /// The smooth patch of each facet: the least number of its facets.
    fn patches(&self) -> Vec<u32> {
        let mut of: Vec<u32> = (0..self.facets.len() as u32).collect();
        if !self.edges {
            of.fill(0);
            return of;
        }
        let normals: Vec<Option<Vec3>> = (0..self.facets.len()).map(|i| self.normal(i)).collect();
        let mut beside: HashMap<[u32; 2], usize> = HashMap::with_capacity(self.facets.len() * 3 / 2);
        let least = CREASE_DEG.to_radians().cos();
        for (i, facet) in self.facets.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (facet[k], facet[(k + 1) % 3]);
                let Some(j) = beside.insert([a.min(b), a.max(b)], i) else { continue };
                let smooth = match (normals[i], normals[j]) {
                    (Some(n), Some(m)) => n.dot(&m) > least,
                    _ => true,
                };
                if smooth {
                    let (i, j) = (root(&mut of, i as u32), root(&mut of, j as u32));
                    of[i.max(j) as usize] = i.min(j);
                }
            }
        }
        (0..self.facets.len() as u32).map(|i| root(&mut of, i)).collect()
    }
}

fn root(of: &mut [u32], mut i: u32) -> u32 {
    while of[i as usize] != i {
        of[i as usize] = of[of[i as usize] as usize];
        i = of[i as usize];
    }
    i
}

/// What a label stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Seen {
    /// Which of the surfaces.
    pub(super) surface: usize,
    patch: u32,
    /// Shaded.
    pub(super) colour: Colour,
    /// Whether the facet is marked.
    pub(super) marked: bool,
}

/// What stands in front at each place of a grid.
pub(super) struct Solids {
    pub(super) labels: Labels,
    /// By label, from 1 on.
    pub(super) seen: Vec<Seen>,
    depth: Vec<f32>,
}

/// From the eye's plane to a grid: scale and shift.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) places: [usize; 2],
    pub(super) scale: f64,
    pub(super) middle: [f64; 2],
}

impl Window {
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let at = |k: usize, v: f64| (v - self.middle[k]) * self.scale + self.places[k] as f64 / 2.0;
        [at(0, x), at(1, y)]
    }
}

/// A border's class: within a smooth patch, an edge or an outline, where new meets old.
pub(super) const SHADE: u8 = 0;
pub(super) const EDGE: u8 = 1;
pub(super) const JOINT: u8 = 2;

impl Solids {
    /// The surfaces as the eye sees them.
    pub(super) fn of<'a>(surfaces: impl Iterator<Item = &'a Surface>, eye: &Eye, window: &Window) -> Self {
        let [width, height] = window.places;
        let mut solids = Self {
            labels: Labels::new(width, height),
            seen: Vec::new(),
            depth: vec![f32::NEG_INFINITY; width * height],
        };
        for (index, surface) in surfaces.enumerate() {
            solids.add(index, surface, eye, window);
        }
        solids
    }

    fn add(&mut self, index: usize, surface: &Surface, eye: &Eye, window: &Window) {
        let patches = surface.patches();
        let at: Vec<[f64; 3]> = surface.points.iter().map(|p| eye.seen(p)).collect();
        let at: Vec<[f64; 3]> = at
            .into_iter()
            .map(|[x, y, z]| {
                let [x, y] = window.place([x, y]);
                [x, y, z]
            })
            .collect();
        let mut known: HashMap<Seen, u32> = HashMap::new();
        let mut marked = surface.marked.iter().peekable();
        for (i, facet) in surface.facets.iter().enumerate() {
            let own = marked.next_if(|(k, _)| *k == i).map(|(_, colour)| *colour);
            let Some(normal) = surface.normal(i) else { continue };
            let shade = (eye.light(&normal) * SHADES).round() / SHADES;
            let colour = own.unwrap_or(surface.colour).map(|v| (f64::from(v) * shade).round() as u8);
            let seen = Seen { surface: index, patch: patches[i], colour, marked: own.is_some() };
            let label = *known.entry(seen).or_insert_with(|| {
                self.seen.push(seen);
                self.seen.len() as u32
            });
            if surface.front_only && !eye.faces(&normal) {
                continue;
            }
            let back = if eye.faces(&normal) { 0.0 } else { BEHIND_MM };
            self.facet(facet.map(|k| at[k as usize]), back, label);
        }
    }

    fn facet(&mut self, [a, b, c]: [[f64; 3]; 3], back: f64, label: u32) {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 {
            return;
        }
        let span = |k: usize, size: usize| {
            let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
            // A place is seen at its middle.
            ((low - 0.5).ceil().max(0.0), (high - 0.5).floor().min(size as f64 - 1.0))
        };
        let (columns, rows) = (span(0, self.labels.width), span(1, self.labels.height));
        if columns.0 > columns.1 || rows.0 > rows.1 {
            return;
        }
        // Edges belong to both sides: a picture without gaps matters more than a place that two facets claim.
        let within = -1e-9 * (1.0 + area.abs());
        for y in rows.0 as usize..=rows.1 as usize {
            for x in columns.0 as usize..=columns.1 as usize {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let side = |p: [f64; 3], q: [f64; 3]| {
                    ((q[0] - p[0]) * (py - p[1]) - (q[1] - p[1]) * (px - p[0])) * area.signum()
                };
                let (wc, wa, wb) = (side(a, b), side(b, c), side(c, a));
                if wa >= within && wb >= within && wc >= within {
                    let depth = ((wa * a[2] + wb * b[2] + wc * c[2]) / area.abs() - back) as f32;
                    let i = y * self.labels.width + x;
                    if depth > self.depth[i] {
                        self.depth[i] = depth;
                        self.labels.each[i] = label;
                    }
                }
            }
        }
    }

    /// What is seen at a place.
    pub(super) fn at(&self, place: usize) -> Option<&Seen> {
        self.labels.each[place].checked_sub(1).map(|label| &self.seen[label as usize])
    }

    /// The class of the border between two places; `reach` is how far apart in depth what touches may look, mm.
    pub(super) fn border(&self, places: [Option<usize>; 2], surfaces: &[Surface], reach: f64) -> u8 {
        let [Some(a), Some(b)] = places else { return SHADE };
        match (self.at(a), self.at(b)) {
            (Some(p), Some(q)) if p.surface != q.surface => {
                let joints = [surfaces[p.surface].joint, surfaces[q.surface].joint];
                let meet = joints == [Joint::Old, Joint::New] || joints == [Joint::New, Joint::Old];
                let near = f64::from((self.depth[a] - self.depth[b]).abs()) < reach;
                if meet && near { JOINT } else { EDGE }
            }
            (Some(p), Some(q)) => u8::from(p.patch != q.patch) * EDGE,
            _ => EDGE,
        }
    }

    /// Small patches go to their neighbours on the same surface.
    pub(super) fn tidied(mut self) -> Self {
        let seen = std::mem::take(&mut self.seen);
        self.labels
            .without_specks(|label| if label == NOTHING { usize::MAX } else { seen[label as usize - 1].surface });
        self.seen = seen;
        self
    }
}
