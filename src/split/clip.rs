//! A closed surface cut by a plane: the solids beyond it, closed by caps, and what is left.
//!
//! Vertices within [`ON_PLANE_MM`] of the plane lie in it and stay where they are; every edge that crosses gets one new vertex,
//! which both sides share bit for bit. A facet in the plane belongs to the side on which its material is; one without area, to the
//! side that makes the rim shorter, or the cap would follow it out and back over nothing. Nothing is ever moved,
//! so that the volumes of the two sides add up to the whole, and a cut takes some of the solids beyond without touching the rest.

use std::collections::{HashMap, HashSet};

use super::surface::{Plane, Surface};
use crate::geom::{Sets, Vec3};
use crate::mesh::{CapPatch, EdgeMap, NoCap, THIN_MM, patches};

/// Nearer vertices lie in the plane, mm: above the last digit of an `f32` file, far below a layer.
pub(super) const ON_PLANE_MM: f64 = 1e-4;

/// Which of the solids beyond the plane a cut takes.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Taken {
    All,
    /// Those that have one of these vertices.
    With(Vec<u32>),
}

/// What a cut makes.
#[derive(Clone, Debug)]
pub(super) struct Clipped {
    /// What is left, caps included; nothing where everything lay beyond.
    pub(super) rest: Surface,
    /// The solids that were taken, each closed by its caps.
    pub(super) pieces: Vec<Surface>,
    /// The area of each patch of the caps, mm².
    pub(super) patches_mm2: Vec<f64>,
}

/// Cuts `surface`; the caps get the number `source`. Nothing is taken where nothing lies beyond.
///
/// # Errors
///
/// [`NoCap`] where the surface crosses itself in the plane.
pub(super) fn cut(surface: &Surface, plane: &Plane, taken: &Taken, source: u32) -> Result<Clipped, NoCap> {
    let mut parted = Parted::of(surface, plane);
    let edges = parted.rim();
    let directed: Vec<[u32; 2]> = edges.iter().map(|e| [e.1, e.0]).collect();
    let patches = patches(&parted.vertices, &directed, &-plane.normal)?;
    let side_of: HashMap<u32, u32> = edges.iter().flat_map(|&(a, b, side)| [(a, side), (b, side)]).collect();
    for patch in &patches {
        for pair in patch.of_loops.windows(2) {
            parted.solids.join(side_of[&pair[0]], side_of[&pair[1]]);
        }
    }
    parted.cavities();
    let chosen = parted.chosen(taken);
    Ok(parted.assembled(&patches, &side_of, &chosen, source))
}

/// A surface with every facet on one side of a plane or parted in two.
struct Parted<'a> {
    surface: &'a Surface,
    plane: &'a Plane,
    /// The surface's own, then the new ones.
    vertices: Vec<Vec3>,
    /// By own vertex: 1 beyond, 0 in the plane, -1 before.
    side: Vec<i8>,
    /// Solids beyond, by a vertex of theirs; the facets in the plane follow behind the vertices.
    solids: Sets,
    /// Beyond: corners, the facet they stem from, a member of their solid.
    beyond: Vec<([u32; 3], u32, u32)>,
    /// The other parts of the facets that cross: corners, facet.
    before: Vec<([u32; 3], u32)>,
}

impl<'a> Parted<'a> {
    fn of(surface: &'a Surface, plane: &'a Plane) -> Self {
        let side_of = |v: &Vec3| {
            let height = plane.height(v);
            if height.abs() <= ON_PLANE_MM {
                0
            } else if height > 0.0 {
                1
            } else {
                -1
            }
        };
        let side: Vec<i8> = surface.vertices.iter().map(side_of).collect();
        let mut parted = Self {
            surface,
            plane,
            vertices: surface.vertices.clone(),
            solids: Sets::new(surface.vertices.len() + surface.facets.len()),
            side,
            beyond: Vec::new(),
            before: Vec::new(),
        };
        parted.part();
        parted
    }

    fn part(&mut self) {
        let mut crossings: EdgeMap<u32> = EdgeMap::default();
        let mut slivers = Vec::new();
        for (index, &facet) in self.surface.facets.iter().enumerate() {
            let sides = facet.map(|v| self.side[v as usize]);
            let upper: Vec<u32> = facet.iter().copied().filter(|&v| self.side[v as usize] > 0).collect();
            upper.windows(2).for_each(|pair| _ = self.solids.join(pair[0], pair[1]));
            let index = index as u32;
            if sides == [0; 3] {
                let [ab, bc, ca] = self.lengths(facet);
                let doubled = self.surface.area_vector(index as usize);
                if doubled.norm() < THIN_MM * ab.max(bc).max(ca) {
                    slivers.push(index);
                } else if doubled.dot(&self.plane.normal) < 0.0 {
                    self.beyond.push((facet, index, self.surface.vertices.len() as u32 + index));
                }
            } else if let Some(&top) = upper.first() {
                if sides.contains(&-1) {
                    self.part_facet(index, facet, sides, top, &mut crossings);
                } else {
                    self.beyond.push((facet, index, top));
                }
            }
        }
        if !slivers.is_empty() {
            self.take_slivers(slivers);
        }
        self.join_in_plane();
    }

    /// Those of the facets without area in the plane go beyond that have half of their rim there: that makes the rim no longer.
    fn take_slivers(&mut self, mut slivers: Vec<u32>) {
        let ends = |facet: [u32; 3]| (0..3).map(move |i| [facet[i], facet[(i + 1) % 3]]);
        let mut beyond: HashSet<[u32; 2]> = self.beyond.iter().flat_map(|(facet, ..)| ends(*facet)).collect();
        let mut before = usize::MAX;
        while slivers.len() < before {
            before = slivers.len();
            slivers.retain(|&index| {
                let facet = self.surface.facets[index as usize];
                let lengths = self.lengths(facet);
                let shared = ends(facet).zip(lengths).filter(|([a, b], _)| beyond.contains(&[*b, *a]));
                let stays = shared.map(|(_, mm)| mm).sum::<f64>() < lengths.iter().sum::<f64>() / 2.0 - ON_PLANE_MM;
                if !stays {
                    self.beyond.push((facet, index, self.surface.vertices.len() as u32 + index));
                    beyond.extend(ends(facet));
                }
                stays
            });
        }
    }

    /// Of a facet's sides, each from its corner to the next, mm.
    fn lengths(&self, facet: [u32; 3]) -> [f64; 3] {
        let at = |i: usize| self.vertices[facet[i % 3] as usize];
        [0, 1, 2].map(|i| (at(i + 1) - at(i)).norm())
    }

    /// Parts one facet that crosses.
    fn part_facet(&mut self, index: u32, facet: [u32; 3], sides: [i8; 3], top: u32, crossings: &mut EdgeMap<u32>) {
        let (above, below) = (sides.iter().filter(|s| **s > 0).count(), sides.iter().filter(|s| **s < 0).count());
        // The corner that is alone on its side comes first; with one on each side, the upper.
        let alone = if above == 1 { 1 } else { -1 };
        let first = (0..3).find(|&i| sides[i] == alone).unwrap_or(0);
        let [a, b, c] = [0, 1, 2].map(|i| facet[(first + i) % 3]);
        let [_, sb, sc] = [0, 1, 2].map(|i| sides[(first + i) % 3]);
        let [up, down] = if above == 1 && below == 1 {
            if sb == 0 {
                let q = self.crossing(a, c, crossings);
                [vec![[a, b, q]], vec![[b, c, q]]]
            } else {
                let p = self.crossing(a, b, crossings);
                [vec![[a, p, c]], vec![[p, b, c]]]
            }
        } else {
            assert!(sb != 0 && sc != 0, "a corner by itself on its side has two beyond the plane");
            let (p, q) = (self.crossing(a, b, crossings), self.crossing(a, c, crossings));
            let at = |i: u32| self.vertices[i as usize];
            // The shorter diagonal makes the better triangles.
            let quad = if (at(p) - at(c)).norm_squared() <= (at(b) - at(q)).norm_squared() {
                vec![[p, b, c], [p, c, q]]
            } else {
                vec![[p, b, q], [b, c, q]]
            };
            let corner = vec![[a, p, q]];
            if alone > 0 { [corner, quad] } else { [quad, corner] }
        };
        self.beyond.extend(up.into_iter().map(|t| (t, index, top)));
        self.before.extend(down.into_iter().map(|t| (t, index)));
    }

    /// The vertex where the edge between `a` and `b` meets the plane.
    fn crossing(&mut self, a: u32, b: u32, crossings: &mut EdgeMap<u32>) -> u32 {
        let key = [a.min(b), a.max(b)];
        *crossings.entry(key).or_insert_with(|| {
            let [p, q] = key.map(|i| self.surface.vertices[i as usize]);
            let (hp, hq) = (self.plane.height(&p), self.plane.height(&q));
            self.vertices.push(p + (q - p) * (hp / (hp - hq)));
            self.vertices.len() as u32 - 1
        })
    }

    /// Facets in the plane are of the solid beyond that they bound.
    fn join_in_plane(&mut self) {
        let flat = self.surface.vertices.len() as u32;
        let level = |v: u32| self.side.get(v as usize).is_none_or(|s| *s == 0);
        if !self.beyond.iter().any(|(.., solid)| *solid >= flat) {
            return;
        }
        let mut edges: EdgeMap<u32> = EdgeMap::default();
        for (facet, _, solid) in &self.beyond {
            for i in 0..3 {
                let (a, b) = (facet[i], facet[(i + 1) % 3]);
                if level(a) && level(b) {
                    edges.insert([a, b], *solid);
                }
            }
        }
        for (edge, solid) in &edges {
            if let Some(other) = edges.get(&[edge[1], edge[0]]) {
                self.solids.join(*solid, *other);
            }
        }
    }

    /// Edges in the plane where the surface beyond ends, with a member of the solid.
    fn rim(&self) -> Vec<(u32, u32, u32)> {
        let level = |v: u32| self.side.get(v as usize).is_none_or(|s| *s == 0);
        let mut edges: Vec<(u32, u32, i32, u32)> = Vec::new();
        for (facet, _, solid) in &self.beyond {
            for i in 0..3 {
                let (a, b) = (facet[i], facet[(i + 1) % 3]);
                if level(a) && level(b) {
                    edges.push(if a < b { (a, b, 1, *solid) } else { (b, a, -1, *solid) });
                }
            }
        }
        edges.sort_unstable();
        let mut rim = Vec::new();
        for run in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            let sum: i32 = run.iter().map(|e| e.2).sum();
            let solid = run.iter().find(|e| e.2 == sum.signum()).map_or(0, |e| e.3);
            let edge = if sum > 0 { (run[0].0, run[0].1, solid) } else { (run[0].1, run[0].0, solid) };
            rim.extend(std::iter::repeat_n(edge, sum.unsigned_abs() as usize));
        }
        rim
    }

    /// Shells wholly beyond that face inward belong to the solid around them.
    fn cavities(&mut self) {
        let mut by_solid: HashMap<u32, Vec<usize>> = HashMap::new();
        for index in 0..self.beyond.len() {
            by_solid.entry(self.solids.root(self.beyond[index].2)).or_default().push(index);
        }
        if by_solid.len() < 2 {
            return;
        }
        let mut roots: Vec<u32> = by_solid.keys().copied().collect();
        roots.sort_unstable();
        let shell = |root: &u32| {
            let facets: Vec<[u32; 3]> = by_solid[root].iter().map(|&i| self.beyond[i].0).collect();
            Surface { vertices: self.vertices.clone(), source: Vec::new(), facets }
        };
        let whole = |s: &Surface| s.is_closed();
        let inward: Vec<u32> = roots
            .iter()
            .copied()
            .filter(|r| by_solid[r].iter().all(|&i| self.beyond[i].0 == self.surface.facets[self.beyond[i].1 as usize]))
            .filter(|r| {
                let s = shell(r);
                whole(&s) && s.volume() < 0.0
            })
            .collect();
        for cavity in inward {
            let at = self.vertices[self.beyond[by_solid[&cavity][0]].0[0] as usize];
            let around = roots.iter().copied().filter(|r| *r != cavity);
            let most = around.map(|r| (shell(&r).winding(&at), r)).max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, root)) = most {
                self.solids.join(cavity, root);
            }
        }
    }

    /// The roots of the solids that are taken.
    fn chosen(&mut self, taken: &Taken) -> Vec<u32> {
        let members: Vec<u32> = match taken {
            Taken::All => self.beyond.iter().map(|b| b.2).collect(),
            Taken::With(vertices) => vertices.iter().copied().filter(|&v| self.side[v as usize] > 0).collect(),
        };
        let mut roots: Vec<u32> = members.into_iter().map(|m| self.solids.root(m)).collect();
        roots.sort_unstable();
        roots.dedup();
        roots
    }

    fn assembled(mut self, patches: &[CapPatch], side_of: &HashMap<u32, u32>, chosen: &[u32], source: u32) -> Clipped {
        let beyond: Vec<u32> = (0..self.beyond.len()).map(|i| self.solids.root(self.beyond[i].2)).collect();
        let caps: Vec<u32> = patches.iter().map(|p| self.solids.root(side_of[&p.of_loops[0]])).collect();
        let mut gone = vec![false; self.surface.facets.len()];
        let mut pieces: Vec<Surface> = Vec::new();
        let of = |facets: Vec<([u32; 3], u32)>| {
            let (facets, source) = facets.into_iter().unzip();
            let all = Surface { vertices: self.vertices.clone(), facets, source };
            all.select(0..all.facets.len())
        };
        for root in chosen {
            let mut facets = Vec::new();
            for (_, (corners, from, _)) in beyond.iter().zip(&self.beyond).filter(|(r, _)| *r == root) {
                facets.push((*corners, self.surface.source[*from as usize]));
                gone[*from as usize] = true;
            }
            for (_, patch) in caps.iter().zip(patches).filter(|(r, _)| *r == root) {
                facets.extend(patch.triangles.iter().map(|t| (*t, source)));
            }
            pieces.push(of(facets));
        }
        let whole = (0..gone.len()).filter(|&i| !gone[i]).map(|i| (self.surface.facets[i], self.surface.source[i]));
        let mut rest: Vec<([u32; 3], u32)> = whole.collect();
        let halves = self.before.iter().filter(|(_, from)| gone[*from as usize]);
        rest.extend(halves.map(|(corners, from)| (*corners, self.surface.source[*from as usize])));
        let mut patches_mm2 = Vec::new();
        for (_, patch) in caps.iter().zip(patches).filter(|(root, _)| chosen.contains(root)) {
            rest.extend(patch.triangles.iter().map(|&[a, b, c]| ([a, c, b], source)));
            patches_mm2.push(patch.area_mm2);
        }
        Clipped { rest: of(rest), pieces, patches_mm2 }
    }
}
