//! A surface with what is asked of it at every direction: where it begins, and which of its edges hang too far.
//!
//! Beginning: a lowest place of the surface along the build direction. One that lies less than a layer below the saddle to something
//! lower is a nick that no slicer sees. Steep walls that meet in a point overhang nowhere and still begin in the air.
//!
//! Ridge: a run of convex edges below facets that look down, so flat that each layer advances farther along it than a line may hang
//! free: every facet about it may be steep enough, and it is still laid in the air. The top of an arch is such a run too, but ends on
//! material at both ends, and may be as long as a bridge.
//!
//! Areas mm², heights mm along the direction.

use std::collections::{BTreeMap, HashMap};

use crate::geom::{Sets, Vec3};
use crate::overhang::slivers::{Given, Mended, Side};

/// How far lines may hang.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hang {
    /// A layer, mm.
    pub layer_mm: f64,
    /// So far a line may hang free at its end, mm.
    pub span_mm: f64,
    /// So far it may reach between two ends on material, mm.
    pub bridge_mm: f64,
}

/// A facet looks down from this component on.
pub const LOOKS_DOWN: f64 = -1e-3;
/// Heights nearer than this are one, mm: twice the last digit of an f32 file at 1 m.
pub const SAME_HEIGHT_MM: f64 = 2e-4;
/// Both facets about a ridge look down at least so much.
const RIDGE_DOWN: f64 = -0.02;
/// And bend by more than this, degrees.
const RIDGE_BEND_DEG: f64 = 20.0;
/// A run that goes down by more than this from its end hangs on what is there, mm.
const DROP_MM: f64 = 1e-2;

/// A convex edge.
#[derive(Clone, Copy, Debug)]
struct Edge {
    ends: [u32; 2],
    facets: [u32; 2],
    /// Unit vector along it.
    along: Vec3,
}

/// Flat edges end to end, below facets that look down.
#[derive(Clone, Debug)]
pub struct Ridge {
    /// By edge, its two vertices.
    pub edges: Vec<[u32; 2]>,
    /// What may hang there, mm.
    pub allowed_mm: f64,
}

/// A closed surface and who is beside whom in it.
#[derive(Clone, Debug)]
pub struct Relief {
    vertices: Vec<Vec3>,
    facets: Vec<[u32; 3]>,
    /// By facet, mm².
    pub area: Vec<f64>,
    /// By facet, unit and outward; zero for a facet without area.
    pub normal: Vec<Vec3>,
    /// Edges that are ridges along some direction.
    edges: Vec<Edge>,
    /// Of vertices in one place that an edge joins, the one that stands for them; the others stand for themselves.
    stand_in: HashMap<u32, u32>,
    /// Of vertex `i`: `neighbours[first[i]..first[i + 1]]`.
    first: Vec<u32>,
    neighbours: Vec<u32>,
    /// By vertex, its facets, in the same way.
    first_facet: Vec<u32>,
    facets_about: Vec<u32>,
    closed: bool,
}

impl Relief {
    /// Of a surface's vertices and facets, the corners of each counter-clockwise seen from outside.
    pub fn of(vertices: Vec<Vec3>, facets: Vec<[u32; 3]>) -> Self {
        let vector = |f: &[u32; 3]| {
            let [a, b, c] = f.map(|i| vertices[i as usize]);
            (b - a).cross(&(c - a))
        };
        let vectors: Vec<Vec3> = facets.iter().map(vector).collect();
        let area: Vec<f64> = vectors.iter().map(|v| v.norm() * 0.5).collect();
        let normal: Vec<Vec3> = vectors.iter().map(|v| v.try_normalize(0.0).unwrap_or_default()).collect();
        let (edges, stand_in, first, neighbours, first_facet, facets_about) = Default::default();
        let closed = false;
        let mut all = Self {
            vertices,
            facets,
            area,
            normal,
            edges,
            stand_in,
            first,
            neighbours,
            first_facet,
            facets_about,
            closed,
        };
        all.connect();
        all
    }

    /// Whether every edge is run along as often one way as the other.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    fn connect(&mut self) {
        self.group_facets();
        let vertices = self.vertices.len();
        let (mut first, mut neighbours) = (vec![0; vertices + 1], Vec::with_capacity(6 * vertices));
        let mut closed = true;
        let mended = self.mended();
        let is_changed = |f: u32| mended.as_ref().is_some_and(|mended| mended.is_changed(f));
        // Of one vertex: the other ends of its facets' sides, whether the side runs towards the vertex, the facet.
        let mut sides: Vec<(u32, bool, u32)> = Vec::new();
        let mut edges = Vec::new();
        for v in 0..vertices as u32 {
            sides.clear();
            for &f in self.facets_at(v as usize) {
                let facet = self.facets[f as usize];
                for i in 0..3 {
                    let (a, b) = (facet[i], facet[(i + 1) % 3]);
                    if a == v {
                        sides.push((b, false, f));
                    }
                    if b == v {
                        sides.push((a, true, f));
                    }
                }
            }
            sides.sort_unstable();
            for run in sides.chunk_by(|x, y| x.0 == y.0) {
                let other = run[0].0;
                neighbours.push(other);
                closed &= 2 * run.iter().filter(|side| side.1).count() == run.len();
                // The side away from the vertex comes first.
                if let (true, [one, two]) = (v < other, run)
                    && !is_changed(one.2)
                    && !is_changed(two.2)
                {
                    edges.extend(self.edge(([v, other], [one.2, two.2])));
                }
            }
            first[v as usize + 1] = neighbours.len() as u32;
        }
        let (sides, one_place) = mended.map(|m| (m.sides(), m.one_place)).unwrap_or_default();
        edges.extend(sides.into_iter().filter_map(|side| self.edge(side)));
        let mut stand_in = HashMap::new();
        if !one_place.is_empty() {
            let mut sets = Sets::new(vertices);
            for [a, b] in &one_place {
                sets.join(*a, *b);
            }
            stand_in = one_place.into_iter().flatten().map(|v| (v, sets.root(v))).collect();
        }
        (self.stand_in, self.first, self.neighbours, self.closed) = (stand_in, first, neighbours, closed);
        edges.retain(|edge: &Edge| self.place(edge.ends[0]) != self.place(edge.ends[1]));
        self.edges = edges;
    }

    /// What lies where thin facets lay; `None` where there are none.
    fn mended(&self) -> Option<Mended<'_>> {
        let given = Given {
            vertices: &self.vertices,
            facets: &self.facets,
            first: &self.first_facet,
            about: &self.facets_about,
        };
        Mended::of(given, &self.area)
    }

    /// The facets of each vertex, in their order.
    fn group_facets(&mut self) {
        let mut first = vec![0_u32; self.vertices.len() + 1];
        self.facets.iter().flatten().for_each(|&v| first[v as usize + 1] += 1);
        for v in 1..first.len() {
            first[v] += first[v - 1];
        }
        let mut next = first.clone();
        self.facets_about = vec![0; 3 * self.facets.len()];
        for (index, facet) in self.facets.iter().enumerate() {
            for &v in facet {
                self.facets_about[next[v as usize] as usize] = index as u32;
                next[v as usize] += 1;
            }
        }
        self.first_facet = first;
    }

    /// The edge, if it is convex and bends enough to be a ridge along some direction.
    fn edge(&self, (ends, facets): Side) -> Option<Edge> {
        let [p, q] = ends.map(|i| self.vertices[i as usize]);
        let [m, n] = facets.map(|f| self.normal[f as usize]);
        let bends = m.dot(&n) < RIDGE_BEND_DEG.to_radians().cos();
        let convex = bends && m.cross(&n).dot(&(q - p)) > 0.0;
        if convex { Some(Edge { ends, facets, along: (q - p).try_normalize(0.0)? }) } else { None }
    }

    /// The runs that are too long to hang along `up`; edges of facets that `stands` says yes to are none.
    pub fn ridges(&self, up: &Vec3, stands: impl Fn(usize) -> bool, hang: &Hang) -> Vec<Ridge> {
        let flat = hang.layer_mm / hang.layer_mm.hypot(hang.span_mm);
        let hangs = |edge: &&Edge| {
            edge.along.dot(up).abs() < flat
                && edge.facets.iter().all(|&f| self.normal[f as usize].dot(up) < RIDGE_DOWN)
                && !edge.facets.iter().any(|&f| stands(f as usize))
        };
        let mut runs: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
        let flat: Vec<[u32; 2]> = self.edges.iter().filter(hangs).map(|edge| edge.ends).collect();
        let mut of_vertex: HashMap<u32, u32> = HashMap::new();
        let mut sets = Sets::new(flat.len());
        for (i, ends) in flat.iter().enumerate() {
            for v in ends {
                let first = *of_vertex.entry(self.place(*v)).or_insert(i as u32);
                sets.join(first, i as u32);
            }
        }
        for (i, ends) in flat.iter().enumerate() {
            runs.entry(sets.root(i as u32)).or_default().push(*ends);
        }
        runs.into_values().filter_map(|edges| self.too_long(edges, up, hang)).collect()
    }

    /// The run, if it is longer than what may hang there.
    fn too_long(&self, edges: Vec<[u32; 2]>, up: &Vec3, hang: &Hang) -> Option<Ridge> {
        let length: f64 = edges.iter().map(|e| self.length(*e)).sum();
        if length <= hang.span_mm {
            return None;
        }
        let height = |v: u32| self.vertices[v as usize].dot(up);
        let on_run = |v: u32| edges.iter().flatten().filter(|w| self.place(**w) == self.place(v)).count();
        let ends = edges.iter().flatten().copied().filter(|&v| on_run(v) == 1);
        let carried = |v: u32| self.around_place(v).iter().any(|&w| on_run(w) == 0 && height(w) < height(v) - DROP_MM);
        let carried: Vec<bool> = ends.map(carried).collect();
        let both = carried.len() >= 2 && carried.iter().all(|c| *c);
        let allowed_mm = if both { hang.bridge_mm.max(hang.span_mm) } else { hang.span_mm };
        (length > allowed_mm).then_some(Ridge { edges, allowed_mm })
    }

    /// The vertex that stands for all in its place.
    fn place(&self, vertex: u32) -> u32 {
        if self.stand_in.is_empty() { vertex } else { self.stand_in.get(&vertex).copied().unwrap_or(vertex) }
    }

    /// The vertices that an edge joins to one in the place of `vertex`.
    fn around_place(&self, vertex: u32) -> Vec<u32> {
        let (mut here, mut next) = (vec![vertex], 0);
        let mut around = Vec::new();
        while let Some(&v) = here.get(next) {
            next += 1;
            for &w in self.around(v as usize) {
                let there = if self.place(w) == self.place(vertex) { &mut here } else { &mut around };
                if !there.contains(&w) {
                    there.push(w);
                }
            }
        }
        around
    }

    /// The length of the edge between two vertices, mm.
    pub fn length(&self, [a, b]: [u32; 2]) -> f64 {
        (self.vertices[a as usize] - self.vertices[b as usize]).norm()
    }

    /// The facets at a vertex.
    pub fn facets_at(&self, vertex: usize) -> &[u32] {
        &self.facets_about[self.first_facet[vertex] as usize..self.first_facet[vertex + 1] as usize]
    }

    /// The vertices that an edge joins to a vertex.
    pub fn around(&self, vertex: usize) -> &[u32] {
        &self.neighbours[self.first[vertex] as usize..self.first[vertex + 1] as usize]
    }

    /// The vertices' heights along `up`; those of facets that `stands` says yes to lie below all else, so that nothing beside them
    /// is a lowest place.
    pub fn heights(&self, up: &Vec3, stands: impl Fn(usize) -> bool) -> Vec<f64> {
        let mut heights: Vec<f64> = self.vertices.iter().map(|v| v.dot(up)).collect();
        for facet in (0..self.facets.len()).filter(|&f| stands(f)) {
            for &v in &self.facets[facet] {
                heights[v as usize] = f64::NEG_INFINITY;
            }
        }
        heights
    }

    /// Vertices where the surface begins along `up`, one of each flat place, nicks of less than `layer_mm` left out; `heights` as
    /// [`Relief::heights`] gives them.
    pub fn beginnings(&self, heights: &[f64], up: &Vec3, layer_mm: f64) -> Vec<u32> {
        let lower = |a: u32, b: u32| (heights[a as usize], a) < (heights[b as usize], b);
        let lowest = |v: &u32| {
            heights[*v as usize] > f64::NEG_INFINITY
                && self.around(*v as usize).iter().all(|&w| lower(*v, w))
                && self.looks_down(*v, up)
        };
        let found: Vec<u32> = (0..heights.len() as u32).filter(lowest).collect();
        if found.is_empty() { found } else { self.deep(heights, &found, layer_mm) }
    }

    /// Whether a facet at `vertex` looks down along `up`: the middle of a flat top and the bottom of a bowl are lowest too, but have
    /// material below.
    pub fn looks_down(&self, vertex: u32, up: &Vec3) -> bool {
        self.facets_at(vertex as usize).iter().any(|&f| self.normal[f as usize].dot(up) < LOOKS_DOWN)
    }

    /// The heights along `up` where the surface begins in the air, or has a ridge that is too long to hang, mm: layers there are to be
    /// looked at ([`Ground::begins_mm`](super::Ground::begins_mm)).
    pub fn in_the_air(&self, up: &Vec3, stands: impl Fn(usize) -> bool + Copy, hang: &Hang) -> Vec<f64> {
        let height = |v: u32| self.vertices[v as usize].dot(up);
        let begin = self.beginnings(&self.heights(up, stands), up, hang.layer_mm);
        let ridges = self.ridges(up, stands, hang);
        let of_ridges = ridges.iter().flat_map(|ridge| ridge.edges.iter().flatten().copied());
        begin.into_iter().chain(of_ridges).map(height).collect()
    }

    /// The vertices of the flat place about the beginning `from`, itself among them.
    pub fn level_with(&self, heights: &[f64], from: u32) -> Vec<u32> {
        let mut found = vec![from];
        let mut next = 0;
        while let Some(&v) = found.get(next) {
            next += 1;
            for &w in self.around(v as usize) {
                if (heights[w as usize] - heights[from as usize]).abs() < SAME_HEIGHT_MM && !found.contains(&w) {
                    found.push(w);
                }
            }
        }
        found
    }

    /// Those of `found` that lie a layer or more below the saddle to something lower: less than a layer above them, the surface about
    /// them leads to nothing lower.
    fn deep(&self, heights: &[f64], found: &[u32], layer_mm: f64) -> Vec<u32> {
        let key = |v: u32| (heights[v as usize], v);
        let mut seen = vec![u32::MAX; heights.len()];
        let mut reached = Vec::new();
        let mut is_deep = |from: u32| {
            reached.clear();
            reached.push(from);
            seen[from as usize] = from;
            while let Some(v) = reached.pop() {
                for &w in self.around(v as usize) {
                    let new = std::mem::replace(&mut seen[w as usize], from) != from;
                    if new && heights[w as usize] - heights[from as usize] < layer_mm {
                        if key(w) < key(from) {
                            return false;
                        }
                        reached.push(w);
                    }
                }
            }
            true
        };
        found.iter().copied().filter(|&v| is_deep(v)).collect()
    }
}
