//! Which holes may be filled, and with what: where the missing facets are known, or cannot have been far away.

use std::collections::{HashMap, HashSet};

use super::{Shell, Surface, holes, sheets, shells};
use crate::geom::{Bounds, Vec3};
use crate::mesh::box_tree::BoxTree;
use crate::mesh::error::Places;

/// Of holes with so many corners every way to fill them is looked at: there are 132.
const MOST_CORNERS: usize = 8;
/// A missing facet goes on where a facet beside it ends, up to this angle, radians.
const GOES_ON: f64 = 1e-3;
/// A nearly flat border may leave its mean plane by this share of its diagonal ...
const NEARLY_FLAT: f64 = 0.1;
/// ... where what that may make of the volume is less than this share of it.
const MOST_VOLUME: f64 = 1e-3;
/// Borders of two shells are of one crack where they are nearer than this share of their size.
const NEAR: f64 = 0.1;

/// Facets whose normals have a cosine below this fold back; below the other one they lie upon each other.
const FOLDED: f64 = -0.7;
const FOLDED_FLAT: f64 = -0.9999;
/// Ways to fill a hole have about the same area.
const LITTLE_MORE: f64 = 1.2;

/// What was filled.
#[derive(Debug, Default)]
pub(super) struct Filled {
    pub(super) holes: usize,
    pub(super) facets: usize,
    /// The middle of each hole.
    pub(super) places: Places,
}

/// A border that is to be filled.
struct Border {
    shell: usize,
    corners: Vec<u32>,
}

/// Fills what is sure.
pub(super) fn fill(vertices: &[Vec3], surface: &mut Surface, thin: f64) -> Filled {
    let mut filled = Filled::default();
    let shells: Vec<Shell> = shells(vertices, &surface.facets).into_iter().filter(|one| !one.open.is_empty()).collect();
    let facets_of =
        |shell: &Shell| shell.facets.iter().map(|&index| surface.facets[index as usize]).collect::<Vec<_>>();
    let mut borders = Vec::new();
    let mut volumes = Vec::new();
    for (shell, one) in shells.iter().enumerate() {
        let facets = facets_of(one);
        volumes.push(sheets::closed_volume(vertices, &facets, &one.open).abs());
        // A sheet would be folded flat onto itself.
        if !sheets::is_sheet(vertices, &facets, &one.open, thin) {
            borders.extend(holes::loops(&one.open).into_iter().map(|corners| Border { shell, corners }));
        }
    }
    let boxes = borders.iter().map(|border| {
        let bounds = Bounds::of(border.corners.iter().map(|&index| vertices[index as usize]));
        bounds.inflated(NEAR * bounds.size().norm())
    });
    let boxes: Vec<Bounds> = boxes.collect();
    let tree = BoxTree::of_boxes(boxes.clone());
    let mut lids = Vec::new();
    for (border, bounds) in borders.iter().zip(&boxes) {
        let mut is_alone = true;
        tree.visit(bounds, |other| is_alone &= borders[other].shell == border.shell);
        if !is_alone {
            continue;
        }
        let shell = &shells[border.shell];
        if let Some(lid) = lid(vertices, &border.corners, surface, shell, volumes[border.shell]) {
            filled.holes += 1;
            filled.facets += lid.len();
            let middle = border.corners.iter().map(|&index| vertices[index as usize]).sum::<Vec3>();
            filled.places.add(middle / border.corners.len() as f64);
            lids.push((surface.source[shell.facets[0] as usize], lid));
        }
    }
    for (source, lid) in lids {
        surface.source.extend(lid.iter().map(|_| source));
        surface.facets.extend(lid);
    }
    filled
}

fn lid(vertices: &[Vec3], border: &[u32], surface: &Surface, shell: &Shell, volume: f64) -> Option<Vec<[u32; 3]>> {
    let beside = beside(vertices, surface, shell);
    let flat = holes::lid(vertices, border, holes::FLAT_WITHIN);
    if let Some(flat) = flat.filter(|lid| !lies_upon(vertices, lid, &beside)) {
        return Some(flat);
    }
    let small = (border.len() <= MOST_CORNERS).then(|| Small::of(vertices, border, &beside)).flatten();
    if let Some(sure) = small.as_ref().and_then(Small::goes_on) {
        return Some(sure);
    }
    let flat = holes::lid(vertices, border, NEARLY_FLAT)?;
    let bounds = Bounds::of(border.iter().map(|&index| vertices[index as usize]));
    let area: f64 = flat
        .iter()
        .map(|facet| {
            let [a, b, c] = facet.map(|index| vertices[index as usize]);
            0.5 * (b - a).cross(&(c - a)).norm()
        })
        .sum();
    let off = holes::out_of_flat(vertices, border)?.max(holes::FLAT_WITHIN * bounds.size().norm());
    if off * area > MOST_VOLUME * volume {
        return None;
    }
    match small {
        Some(small) => small.smoothest(),
        None => Some(flat).filter(|lid| !lies_upon(vertices, lid, &beside)),
    }
}

/// The unit normals of a shell's facets by their sides, the other way round; `None` for a facet without area.
type Beside = HashMap<[u32; 2], Option<Vec3>>;

fn beside(vertices: &[Vec3], surface: &Surface, shell: &Shell) -> Beside {
    let open: HashSet<[u32; 2]> = shell.open.iter().copied().collect();
    let mut beside = HashMap::new();
    for &index in &shell.facets {
        let facet = surface.facets[index as usize];
        for side in (0..3).map(|k| [facet[k], facet[(k + 1) % 3]]).filter(|side| open.contains(side)) {
            beside.insert([side[1], side[0]], normal(vertices, &facet));
        }
    }
    beside
}

fn normal(vertices: &[Vec3], facet: &[u32; 3]) -> Option<Vec3> {
    let [a, b, c] = facet.map(|index| vertices[index as usize]);
    (b - a).cross(&(c - a)).try_normalize(0.0)
}

/// Whether a facet of a lid lies upon one beside the hole, so that both enclose nothing.
fn lies_upon(vertices: &[Vec3], lid: &[[u32; 3]], beside: &Beside) -> bool {
    lid.iter().any(|facet| {
        let others = (0..3).filter_map(|k| *beside.get(&[facet[k], facet[(k + 1) % 3]])?);
        normal(vertices, facet).is_some_and(|own| others.into_iter().any(|other| own.dot(&other) < FOLDED_FLAT))
    })
}

/// A hole with few corners, with what is beside it.
struct Small {
    border: Vec<u32>,
    at: Vec<Vec3>,
    /// The unit normal of the facet across each side; `None` for one without area.
    beside: Vec<Option<Vec3>>,
    ways: Vec<Vec<[usize; 3]>>,
}

impl Small {
    fn of(vertices: &[Vec3], border: &[u32], beside: &Beside) -> Option<Self> {
        let n = border.len();
        let across = |i: usize| beside.get(&[border[i], border[(i + 1) % n]]).copied();
        let beside = (0..n).map(across).collect::<Option<Vec<_>>>()?;
        let at = border.iter().map(|&index| vertices[index as usize]).collect();
        Some(Self { border: border.to_vec(), at, beside, ways: ways(0, n - 1) })
    }

    /// The unit normals of a way's facets; `None` where one has no area.
    fn normals(&self, way: &[[usize; 3]]) -> Option<Vec<Vec3>> {
        let normal = |facet: &[usize; 3]| {
            let [a, b, c] = facet.map(|i| self.at[i]);
            let (u, v) = (b - a, c - a);
            let across = u.cross(&v);
            (across.norm() > 1e-6 * u.norm_squared().max(v.norm_squared())).then(|| across.normalize())
        };
        way.iter().map(normal).collect()
    }

    /// The side of the border that `a` to `b` is, where it is one.
    fn side(&self, a: usize, b: usize) -> Option<usize> {
        ((a + 1) % self.at.len() == b).then_some(a)
    }

    /// The only way in which every facet goes on in the plane of one beside the hole, as far as the shape is concerned.
    fn goes_on(&self) -> Option<Vec<[u32; 3]>> {
        let mut found: Option<(f64, &Vec<[usize; 3]>)> = None;
        let size = Bounds::of(self.at.iter().copied()).size().norm();
        for way in &self.ways {
            let Some(normals) = self.normals(way) else { continue };
            if !self.is_held(way, &normals) {
                continue;
            }
            let cone = |facet: &[usize; 3]| {
                let [a, b, c] = facet.map(|i| self.at[i] - self.at[0]);
                a.dot(&b.cross(&c)) / 6.0
            };
            let volume: f64 = way.iter().map(cone).sum();
            match found {
                Some((other, _)) if (volume - other).abs() > 1e-5 * size.powi(3) => return None,
                Some(_) => {}
                None => found = Some((volume, way)),
            }
        }
        found.map(|(_, way)| self.named(way))
    }

    fn is_held(&self, way: &[[usize; 3]], normals: &[Vec3]) -> bool {
        let along = |a: &Vec3, b: &Vec3| a.dot(b) > 0.0 && a.cross(b).norm() <= GOES_ON;
        let mut held: Vec<bool> = way
            .iter()
            .zip(normals)
            .map(|(facet, normal)| {
                let beside = (0..3).filter_map(|k| self.side(facet[k], facet[(k + 1) % 3]));
                beside.filter_map(|side| self.beside[side]).any(|beside| along(&beside, normal))
            })
            .collect();
        // What is beside a held one in its plane is held.
        for _ in 0..way.len() {
            for i in 0..way.len() {
                let next = |j: usize| j != i && way[i].iter().filter(|corner| way[j].contains(corner)).count() == 2;
                held[i] |= (0..way.len()).any(|j| held[j] && next(j) && along(&normals[i], &normals[j]));
            }
        }
        held.iter().all(|&held| held)
    }

    /// Of the ways of the least area, or little more, the one that bends least against what is beside it and in itself; none that folds back.
    fn smoothest(&self) -> Option<Vec<[u32; 3]>> {
        let bend = |way: &[[usize; 3]]| {
            let normals = self.normals(way)?;
            let mut bend = 0.0;
            for (i, facet) in way.iter().enumerate() {
                for k in 0..3 {
                    let (a, b) = (facet[k], facet[(k + 1) % 3]);
                    let length = (self.at[a] - self.at[b]).norm();
                    let other = match self.side(a, b) {
                        Some(side) => self.beside[side],
                        None => {
                            (i + 1..way.len()).find(|&j| way[j].contains(&a) && way[j].contains(&b)).map(|j| normals[j])
                        }
                    };
                    let along = other.map_or(1.0, |other| normals[i].dot(&other));
                    if along < FOLDED {
                        return None;
                    }
                    bend += length * (1.0 - along);
                }
            }
            Some(bend)
        };
        let area = |way: &[[usize; 3]]| {
            let twice = |f: &[usize; 3]| (self.at[f[1]] - self.at[f[0]]).cross(&(self.at[f[2]] - self.at[f[0]])).norm();
            way.iter().map(twice).sum::<f64>()
        };
        let bends: Vec<_> = self.ways.iter().filter_map(|way| Some((bend(way)?, area(way), way))).collect();
        let least = self.ways.iter().map(|way| area(way)).fold(f64::INFINITY, f64::min);
        let bends = bends.into_iter().filter(|one| one.1 <= LITTLE_MORE * least);
        bends.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, _, way)| self.named(way))
    }

    fn named(&self, way: &[[usize; 3]]) -> Vec<[u32; 3]> {
        way.iter().map(|facet| facet.map(|i| self.border[i])).collect()
    }
}

/// Every way to cut the polygon of the corners `from` to `to` into triangles.
fn ways(from: usize, to: usize) -> Vec<Vec<[usize; 3]>> {
    if to < from + 2 {
        return vec![Vec::new()];
    }
    let mut all = Vec::new();
    for tip in from + 1..to {
        for before in ways(from, tip) {
            for behind in ways(tip, to) {
                let mut way = before.clone();
                way.extend(behind);
                way.push([from, tip, to]);
                all.push(way);
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::ways;

    #[test]
    fn a_polygon_is_cut_in_as_many_ways_as_catalan_says() {
        let counts: Vec<usize> = (3..=8).map(|corners| ways(0, corners - 1).len()).collect();
        assert_eq!(counts, [1, 2, 5, 14, 42, 132]);
        assert!(ways(0, 7).iter().all(|way| way.len() == 6));
    }
}
