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
/// Facets thinner than this have no normal that means anything, mm.
const THIN_MM: f64 = 1e-3;

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
    /// Of vertex `i`: `neighbours[first[i]..first[i + 1]]`.
    first: Vec<u32>,
    neighbours: Vec<u32>,
    /// By vertex, its facets, in the same way.
    first_facet: Vec<u32>,
    facets_about: Vec<u32>,
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
        let (edges, first, neighbours) = Default::default();
        let (first_facet, facets_about) = Default::default();
        let mut all = Self { vertices, facets, area, normal, edges, first, neighbours, first_facet, facets_about };
        all.connect();
        all
    }

    fn corners(&self, facet: usize) -> [Vec3; 3] {
        self.facets[facet].map(|i| self.vertices[i as usize])
    }

    fn connect(&mut self) {
        let vertices = self.vertices.len();
        let mut edges: Vec<(u32, u32, bool, u32)> = Vec::with_capacity(3 * self.facets.len());
        for (index, facet) in self.facets.iter().enumerate() {
            for i in 0..3 {
                let (a, b) = (facet[i], facet[(i + 1) % 3]);
                edges.push((a.min(b), a.max(b), a > b, index as u32));
            }
        }
        edges.sort_unstable();
        let mut pairs: Vec<[u32; 2]> = Vec::with_capacity(edges.len());
        for run in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            pairs.extend([[run[0].0, run[0].1], [run[0].1, run[0].0]]);
            if let [one, two] = run {
                self.edges.extend(self.edge([one.0, one.1], [one.3, two.3]));
            }
        }
        let about = self.facets.iter().enumerate().flat_map(|(i, f)| f.map(|v| [v, i as u32]));
        let mut about: Vec<[u32; 2]> = about.collect();
        (self.first, self.neighbours) = grouped(&mut pairs, vertices);
        (self.first_facet, self.facets_about) = grouped(&mut about, vertices);
    }

    /// The edge, if it is convex and bends enough to be a ridge along some direction.
    fn edge(&self, ends: [u32; 2], facets: [u32; 2]) -> Option<Edge> {
        let [p, q] = ends.map(|i| self.vertices[i as usize]);
        let [m, n] = facets.map(|f| self.normal[f as usize]);
        let bends = m.dot(&n) < RIDGE_BEND_DEG.to_radians().cos();
        if !bends || facets.iter().any(|&f| self.thin(f as usize)) {
            return None;
        }
        let apex = self.facets[facets[1] as usize].into_iter().find(|v| !ends.contains(v))?;
        let convex = (self.vertices[apex as usize] - p).dot(&m) < 0.0;
        convex.then_some(Edge { ends, facets, along: (q - p).try_normalize(0.0)? })
    }

    fn thin(&self, facet: usize) -> bool {
        let [a, b, c] = self.corners(facet);
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        2.0 * self.area[facet] < THIN_MM * longest
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
                let first = *of_vertex.entry(*v).or_insert(i as u32);
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
        let on_run = |v: u32| edges.iter().flatten().filter(|w| **w == v).count();
        let ends = edges.iter().flatten().copied().filter(|&v| on_run(v) == 1);
        let carried =
            |v: u32| self.around(v as usize).iter().any(|&w| on_run(w) == 0 && height(w) < height(v) - DROP_MM);
        let carried: Vec<bool> = ends.map(carried).collect();
        let both = carried.len() >= 2 && carried.iter().all(|c| *c);
        let allowed_mm = if both { hang.bridge_mm.max(hang.span_mm) } else { hang.span_mm };
        (length > allowed_mm).then_some(Ridge { edges, allowed_mm })
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

    /// Those of `found` that lie a layer or more below the saddle to something lower.
    fn deep(&self, heights: &[f64], found: &[u32], layer_mm: f64) -> Vec<u32> {
        let mut order: Vec<u32> = (0..heights.len() as u32).collect();
        let key = |v: u32| (heights[v as usize], v);
        order.sort_unstable_by(|&a, &b| key(a).0.total_cmp(&key(b).0).then(a.cmp(&b)));
        let mut sets = Sets::new(heights.len());
        let mut lowest: Vec<u32> = (0..heights.len() as u32).collect();
        let mut saddle = vec![f64::INFINITY; heights.len()];
        let mut seen = vec![false; heights.len()];
        for v in order {
            seen[v as usize] = true;
            for &w in self.around(v as usize).iter().filter(|w| seen[**w as usize]) {
                let (a, b) = (sets.root(v), sets.root(w));
                if a == b {
                    continue;
                }
                let (p, q) = (lowest[a as usize], lowest[b as usize]);
                let (deeper, other) = if key(p) < key(q) { (p, q) } else { (q, p) };
                saddle[other as usize] = heights[v as usize];
                let root = sets.join(a, b);
                lowest[root as usize] = deeper;
            }
        }
        found.iter().copied().filter(|&v| saddle[v as usize] - heights[v as usize] >= layer_mm).collect()
    }
}

/// `[key, value]` pairs, doubles dropped, as the start of each key's values and the values.
fn grouped(pairs: &mut Vec<[u32; 2]>, keys: usize) -> (Vec<u32>, Vec<u32>) {
    pairs.sort_unstable();
    pairs.dedup();
    let mut first = vec![0; keys + 1];
    pairs.iter().for_each(|p| first[p[0] as usize + 1] += 1);
    for i in 0..keys {
        first[i + 1] += first[i];
    }
    (first, pairs.iter().map(|p| p[1]).collect())
}
