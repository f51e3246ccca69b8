//! What a surface needs when it is printed along a direction: area, beginnings, ridges.
//!
//! Area: facets that look down by more than the threshold and neither lie on the table nor are the cap that the piece stands on.
//! Beginning: a lowest place of the surface that stands on neither; one less than a layer below its saddle is a nick that the
//! slicer does not see. Ridge: a run of convex edges below facets that look down, so flat that each layer advances farther along it
//! than a line may hang free: every facet about it may be steep enough, and it is still laid in the air. The top of an arch is
//! such a run too, but ends on material at both ends, and may be as long as a bridge.
//!
//! Areas mm², heights mm along the direction.

use std::collections::{BTreeMap, HashMap};

use super::surface::{OWN, Sets, Surface};
use crate::geom::Vec3;

/// What counts, and from where.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rules {
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
}

/// What a surface needs along one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Needs {
    pub(super) area_mm2: f64,
    pub(super) beginnings: usize,
    pub(super) ridges: usize,
}

impl Needs {
    pub(super) fn faults(&self) -> usize {
        self.beginnings + self.ridges
    }
}

/// A facet this near to the table's surface lies on it, mm.
const ON_TABLE_MM: f64 = 0.05;
/// Rounding of normals: an overhang of exactly the threshold is none.
const SINE_SLACK: f64 = 1e-6;
/// Planning takes heights nearer than this for one, mm.
const SAME_HEIGHT_MM: f64 = 2e-4;
/// A facet looks down from this component on.
const LOOKS_DOWN: f64 = -1e-3;
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
pub(super) struct Ridge {
    pub(super) edges: Vec<[u32; 2]>,
    /// What may hang there, mm.
    pub(super) allowed_mm: f64,
}

/// A surface with what is asked of it again and again.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    pub(super) surface: Surface,
    pub(super) area: Vec<f64>,
    /// Unit normals; zero for a facet without area.
    pub(super) normal: Vec<Vec3>,
    /// By facet: on the table.
    pub(super) on_table: Vec<bool>,
    /// Edges that are ridges along some direction.
    edges: Vec<Edge>,
    /// Of vertex `i`: `neighbours[first[i]..first[i + 1]]`.
    first: Vec<u32>,
    neighbours: Vec<u32>,
    /// By vertex, its facets, in the same way.
    first_facet: Vec<u32>,
    facets_about: Vec<u32>,
}

impl Measured {
    pub(super) fn of(surface: Surface, rules: &Rules) -> Self {
        let count = surface.facets.len();
        let vectors: Vec<Vec3> = (0..count).map(|f| surface.area_vector(f)).collect();
        let area: Vec<f64> = vectors.iter().map(|v| v.norm() * 0.5).collect();
        let normal: Vec<Vec3> = vectors.iter().map(|v| v.try_normalize(0.0).unwrap_or_default()).collect();
        let on_table = (0..count)
            .map(|f| {
                let low = |p: &Vec3| (p.z - rules.table_mm).abs() < ON_TABLE_MM;
                normal[f].z < -0.99 && surface.corners(f).iter().all(low)
            })
            .collect();
        let mut all = Self {
            surface,
            area,
            normal,
            on_table,
            edges: Vec::new(),
            first: Vec::new(),
            neighbours: Vec::new(),
            first_facet: Vec::new(),
            facets_about: Vec::new(),
        };
        all.connect();
        all
    }

    fn connect(&mut self) {
        let vertices = self.surface.vertices.len();
        let mut edges: Vec<(u32, u32, bool, u32)> = Vec::with_capacity(3 * self.surface.facets.len());
        for (index, facet) in self.surface.facets.iter().enumerate() {
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
        let about = self.surface.facets.iter().enumerate().flat_map(|(i, f)| f.map(|v| [v, i as u32]));
        let mut about: Vec<[u32; 2]> = about.collect();
        (self.first, self.neighbours) = grouped(&mut pairs, vertices);
        (self.first_facet, self.facets_about) = grouped(&mut about, vertices);
    }

    /// The edge, if it is convex and bends enough to be a ridge along some direction.
    fn edge(&self, ends: [u32; 2], facets: [u32; 2]) -> Option<Edge> {
        let [p, q] = ends.map(|i| self.surface.vertices[i as usize]);
        let [m, n] = facets.map(|f| self.normal[f as usize]);
        let bends = m.dot(&n) < RIDGE_BEND_DEG.to_radians().cos();
        if !bends || facets.iter().any(|&f| self.thin(f as usize)) {
            return None;
        }
        let apex = self.surface.facets[facets[1] as usize].into_iter().find(|v| !ends.contains(v))?;
        let convex = (self.surface.vertices[apex as usize] - p).dot(&m) < 0.0;
        convex.then_some(Edge { ends, facets, along: (q - p).try_normalize(0.0)? })
    }

    fn thin(&self, facet: usize) -> bool {
        let [a, b, c] = self.surface.corners(facet);
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        2.0 * self.area[facet] < THIN_MM * longest
    }

    /// What it needs along `up`, standing on the table or on the cap of number `cap`.
    pub(super) fn needs(&self, up: &Vec3, cap: Option<u32>, rules: &Rules) -> Needs {
        let heights = self.heights(up, cap);
        let stands = |f: usize| self.stands(f, cap);
        let risky = (0..self.area.len()).filter(|&f| self.is_risky(f, up, rules) && !stands(f));
        Needs {
            area_mm2: risky.map(|f| self.area[f]).sum(),
            beginnings: self.beginnings(&heights, up, cap, rules).len(),
            ridges: self.ridges(up, Some(cap), rules).len(),
        }
    }

    /// Whether `facet` lies on the table, or is of the cap `cap`.
    pub(super) fn stands(&self, facet: usize, cap: Option<u32>) -> bool {
        match cap {
            Some(cap) => self.surface.source[facet] == cap,
            None => self.on_table[facet],
        }
    }

    pub(super) fn is_risky(&self, facet: usize, up: &Vec3, rules: &Rules) -> bool {
        self.normal[facet].dot(up) < -rules.sine - SINE_SLACK
    }

    /// The runs that are too long to hang along `up`; edges of what the part stands on, where that is given, are none.
    pub(super) fn ridges(&self, up: &Vec3, standing: Option<Option<u32>>, rules: &Rules) -> Vec<Ridge> {
        let flat = rules.layer_mm / rules.layer_mm.hypot(rules.span_mm);
        let hangs = |edge: &&Edge| {
            edge.along.dot(up).abs() < flat
                && edge.facets.iter().all(|&f| self.normal[f as usize].dot(up) < RIDGE_DOWN)
                && !standing.is_some_and(|cap| edge.facets.iter().any(|&f| self.stands(f as usize, cap)))
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
        runs.into_values().filter_map(|edges| self.too_long(edges, up, rules)).collect()
    }

    /// The run, if it is longer than what may hang there.
    fn too_long(&self, edges: Vec<[u32; 2]>, up: &Vec3, rules: &Rules) -> Option<Ridge> {
        let length: f64 = edges.iter().map(|e| self.length(*e)).sum();
        if length <= rules.span_mm {
            return None;
        }
        let height = |v: u32| self.surface.vertices[v as usize].dot(up);
        let on_run = |v: u32| edges.iter().flatten().filter(|w| **w == v).count();
        let ends = edges.iter().flatten().copied().filter(|&v| on_run(v) == 1);
        let carried =
            |v: u32| self.around(v as usize).iter().any(|&w| on_run(w) == 0 && height(w) < height(v) - DROP_MM);
        let carried: Vec<bool> = ends.map(carried).collect();
        let both = carried.len() >= 2 && carried.iter().all(|c| *c);
        let allowed_mm = if both { rules.bridge_mm.max(rules.span_mm) } else { rules.span_mm };
        (length > allowed_mm).then_some(Ridge { edges, allowed_mm })
    }

    pub(super) fn length(&self, [a, b]: [u32; 2]) -> f64 {
        (self.surface.vertices[a as usize] - self.surface.vertices[b as usize]).norm()
    }

    /// The vertices' heights along `up`; what stands lies below all else, so that nothing beside it is a lowest place.
    pub(super) fn heights(&self, up: &Vec3, cap: Option<u32>) -> Vec<f64> {
        let mut heights: Vec<f64> = self.surface.vertices.iter().map(|v| v.dot(up)).collect();
        let standing = (0..self.area.len()).filter(|&f| self.stands(f, cap));
        for facet in standing {
            for &v in &self.surface.facets[facet] {
                heights[v as usize] = f64::NEG_INFINITY;
            }
        }
        heights
    }

    fn facets_at(&self, vertex: usize) -> &[u32] {
        &self.facets_about[self.first_facet[vertex] as usize..self.first_facet[vertex + 1] as usize]
    }

    pub(super) fn around(&self, vertex: usize) -> &[u32] {
        &self.neighbours[self.first[vertex] as usize..self.first[vertex + 1] as usize]
    }

    /// Vertices where the surface begins along `up`, nicks left out; `heights` as [`Measured::heights`] gives them.
    pub(super) fn beginnings(&self, heights: &[f64], up: &Vec3, cap: Option<u32>, rules: &Rules) -> Vec<u32> {
        let lower = |a: u32, b: u32| (heights[a as usize], a) < (heights[b as usize], b);
        let lowest = |v: &u32| {
            heights[*v as usize] > f64::NEG_INFINITY
                && self.around(*v as usize).iter().all(|&w| lower(*v, w))
                && self.facets_at(*v as usize).iter().any(|&f| self.normal[f as usize].dot(up) < LOOKS_DOWN)
        };
        let found: Vec<u32> = (0..heights.len() as u32).filter(lowest).collect();
        if found.is_empty() {
            return found;
        }
        let deep = self.deep(heights, &found, rules.layer_mm);
        let stands = |v: u32| self.facets_at(v as usize).iter().any(|&f| self.stands(f as usize, cap));
        deep.into_iter().filter(|&v| !stands(v)).collect()
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
