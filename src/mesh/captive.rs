//! Parts that are caught in others: what a joint that is printed in place is made of.
//!
//! A ball in its cage and a link of a chain touch nothing, and no straight way leads out of what is around them; an axle in its bore leaves it along
//! the bore alone, and lies. A lid that was drawn a little too high has more ways, and a peg in its hole goes upward: whoever assembles parts can put
//! these there later, and they are not caught. Straight ways are tried along [`ways`], by rays along each: a part that is blocked only where two edges
//! would meet between all rays counts as free.

use std::cell::OnceCell;

use super::{BoxTree, Part, TriangleMesh, may_overlap};
use crate::geom::{Bounds, Mat3, Object, Vec3};

/// No more parts than these are looked at: specks of a scan are no joints.
const MOST: usize = 200;
/// Nor are they where so many facets are about them, all together: a look costs some 30 sorts of these.
const MOST_FACETS: usize = 400_000;
/// Beyond so much, and twice its own size, nothing blocks a part's way out, mm.
const FAR_MM: f64 = 50.0;
/// Parts whose boxes are farther apart do not catch each other, mm.
const NEAR_MM: f64 = 2.0;
/// Flat faces whose normals are tried as ways, the largest of a part.
const MOST_NORMALS: usize = 8;
/// Directions nearer to each other than this are one, as a cosine.
const SAME_WAY: f64 = 0.999;
/// A line that rises by less than this (sine) lies.
const LYING: f64 = 0.5;
/// What a ray meets nearer than this is where it begins, mm.
const START_MM: f64 = 1e-6;

/// Of the parts that `held` says no to, those that are caught among others of which one is held; ascending.
pub(super) fn captive(parts: &[Part], held: &[bool]) -> Vec<usize> {
    let loose: Vec<usize> = (0..parts.len()).filter(|&id| !held[id]).collect();
    if loose.is_empty() || loose.len() > MOST {
        return Vec::new();
    }
    let bounds: Vec<Bounds> = parts.iter().map(|part| part.mesh.bounds().inflated(NEAR_MM / 2.0)).collect();
    let (bounds, all) = (&bounds, 0..parts.len());
    let around = |id: usize| all.clone().filter(move |&other| other != id && bounds[id].meets(&bounds[other]));
    let (mut around_it, mut facets) = (Vec::with_capacity(loose.len()), 0);
    for id in loose {
        let others = nearby(&parts[id].mesh, around(id).map(|other| &parts[other].mesh));
        facets += others.facets().len();
        if facets > MOST_FACETS {
            return Vec::new();
        }
        around_it.push((id, others));
    }
    // What overlaps is no joint, and whatever begins in material is blocked by it.
    let trees: Vec<OnceCell<BoxTree>> = parts.iter().map(|_| OnceCell::new()).collect();
    let tree = |id: usize| trees[id].get_or_init(|| BoxTree::new(&parts[id].mesh));
    let overlaps = |id: usize| around(id).any(|other| may_overlap(&parts[id], &parts[other], tree(other), false));
    let is_caught = |(id, others): &(usize, TriangleMesh<Object>)| {
        !others.facets().is_empty() && !overlaps(*id) && is_blocked(&parts[*id].mesh, others)
    };
    let mut caught: Vec<usize> = around_it.iter().filter(|one| is_caught(one)).map(|(id, _)| *id).collect();
    let mut kept = Vec::new();
    // What is caught in each other alone comes out together: only what stands holds a group of them.
    while let Some(first) = caught.pop() {
        let mut group = vec![first];
        while let Some(at) = caught.iter().position(|&id| group.iter().any(|&one| bounds[id].meets(&bounds[one]))) {
            group.push(caught.remove(at));
        }
        let whole = TriangleMesh::joined(group.iter().map(|&id| &parts[id].mesh));
        let meets = |other: usize| group.iter().any(|&id| bounds[id].meets(&bounds[other]));
        let holding =
            nearby(&whole, all.clone().filter(|&other| held[other] && meets(other)).map(|id| &parts[id].mesh));
        if !holding.facets().is_empty() && is_blocked(&whole, &holding) {
            kept.extend(group);
        }
    }
    kept.sort_unstable();
    kept
}

/// Whether one of two parts in different bodies is caught in the other: no way leads it out, or one along a line that lies.
pub(super) fn is_joint(one: &TriangleMesh<Object>, other: &TriangleMesh<Object>) -> bool {
    let near = one.bounds().inflated(NEAR_MM).meets(&other.bounds());
    near && other.facets().len().max(one.facets().len()) <= MOST_FACETS && is_blocked(one, other)
}

/// For each of the `captive` parts the one that it is caught in: of those that stand, or are caught in one that does, the one whose box it shares
/// most; in an order in which each comes behind what it is caught in. Boxes that are all apart tell of none.
pub(super) fn catchers(parts: &[Part], captive: &[usize], standing: &[usize]) -> Vec<(usize, usize)> {
    let bounds = |id: usize| parts[id].mesh.bounds().inflated(NEAR_MM / 2.0);
    let shared_mm3 = |a: &Bounds, b: &Bounds| (a.max.inf(&b.max) - a.min.sup(&b.min)).iter().product::<f64>();
    let (mut open, mut around, mut found) = (captive.to_vec(), standing.to_vec(), Vec::new());
    loop {
        let catcher = |id: usize| {
            let own = bounds(id);
            let near = around.iter().map(|&other| (other, bounds(other))).filter(|(_, other)| other.meets(&own));
            let near = near.map(|(other, bounds)| (shared_mm3(&own, &bounds), other));
            near.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))).map(|(_, other)| other)
        };
        let next: Vec<(usize, usize)> = open.iter().filter_map(|&id| Some((id, catcher(id)?))).collect();
        if next.is_empty() {
            return found;
        }
        around.extend(next.iter().map(|(id, _)| *id));
        open.retain(|id| next.iter().all(|(other, _)| other != id));
        found.extend(next);
    }
}

/// The facets of others that are near enough to block `mesh`.
fn nearby<'a>(
    mesh: &TriangleMesh<Object>,
    others: impl Iterator<Item = &'a TriangleMesh<Object>>,
) -> TriangleMesh<Object> {
    let own = mesh.bounds();
    let near = own.inflated(2.0 * own.size().norm() + FAR_MM);
    let mut corners = Vec::new();
    for mesh in others {
        let all = (0..mesh.facets().len()).map(|facet| mesh.corners(facet));
        corners.extend(all.filter(|facet| Bounds::of(*facet).meets(&near)));
    }
    let facets = (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(corners.into_iter().flatten().collect(), facets)
}

/// Whether every way out of `others` is blocked for `mesh`, but for those along one line that lies.
fn is_blocked(mesh: &TriangleMesh<Object>, others: &TriangleMesh<Object>) -> bool {
    let mut line: Option<Vec3> = None;
    ways(mesh).iter().filter(|way| !is_blocked_along(mesh, others, way)).all(|way| {
        let along = line.get_or_insert(*way);
        way.z.abs() < LYING && along.dot(way).abs() > SAME_WAY
    })
}

/// The axes, the diagonals between two and three of them, and the normals of the part's largest faces, both ways; unit vectors.
fn ways(mesh: &TriangleMesh<Object>) -> Vec<Vec3> {
    let steps = || [-1.0, 0.0, 1.0].into_iter();
    let grid = steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| Vec3::new(x, y, z))));
    let mut ways: Vec<Vec3> = grid.filter_map(|way| way.try_normalize(0.5)).collect();
    let mut faces: Vec<(Vec3, f64)> = Vec::new();
    for facet in 0..mesh.facets().len() {
        let Some(normal) = mesh.normal(facet) else { continue };
        let area = mesh.facet_area(facet);
        match faces.iter().position(|(other, _)| other.dot(&normal) > SAME_WAY) {
            Some(known) => faces[known].1 += area,
            // A round part has as many normals as facets, and none that says more than the others.
            None if faces.len() >= MOST => {}
            None => faces.push((normal, area)),
        }
    }
    faces.sort_by(|a, b| b.1.total_cmp(&a.1));
    faces.truncate(MOST_NORMALS);
    // The axis of a prism is across its sides, and these are larger than its ends where it is long.
    let axes = faces.iter().skip(1).filter_map(|(normal, _)| faces[0].0.cross(normal).try_normalize(0.1));
    let more: Vec<Vec3> = faces.iter().map(|(normal, _)| *normal).chain(axes).collect();
    for way in more.into_iter().flat_map(|way| [way, -way]) {
        if ways.iter().all(|known| known.dot(&way) < SAME_WAY) {
            ways.push(way);
        }
    }
    ways
}

/// Whether a ray along `way` leads from the part to one of the others, or one against it from them to the part.
fn is_blocked_along(mesh: &TriangleMesh<Object>, others: &TriangleMesh<Object>, way: &Vec3) -> bool {
    let across = Vec3::ith(way.iamin(), 1.0).cross(way).normalize();
    let upright = Mat3::from_rows(&[across.transpose(), way.cross(&across).transpose(), way.transpose()]);
    let turned = |mesh: &TriangleMesh<Object>| {
        TriangleMesh::<Object>::new(mesh.vertices().iter().map(|v| upright * v).collect(), mesh.facets().to_vec())
    };
    let (mesh, others) = (turned(mesh), turned(others));
    meets(&mesh, &others, 1.0) || meets(&others, &mesh, -1.0)
}

/// Whether a ray from a corner or the middle of one of the facets of `from` meets `to`, going up (`sign` 1) or down (-1).
fn meets(from: &TriangleMesh<Object>, to: &TriangleMesh<Object>, sign: f64) -> bool {
    let (tree, bounds) = (BoxTree::new(to), to.bounds());
    let reach = |start: &Vec3| {
        let end = Vec3::new(start.x, start.y, if sign > 0.0 { bounds.max.z } else { bounds.min.z });
        ((end.z - start.z) * sign > 0.0).then(|| Bounds::of([*start, end]))
    };
    let hits = |start: &Vec3| {
        let Some(way) = reach(start).filter(|way| way.meets(&bounds)) else { return false };
        let mut any = false;
        tree.visit(&way, |facet| any |= height_over(&to.corners(facet), start).is_some_and(|z| sign * z > START_MM));
        any
    };
    let middle = |facet: usize| from.corners(facet).iter().sum::<Vec3>() / 3.0;
    (0..from.facets().len()).any(|facet| hits(&middle(facet))) || from.vertices().iter().any(hits)
}

/// How far above `start` a triangle is, seen from above; `None` beside it.
fn height_over([a, b, c]: &[Vec3; 3], start: &Vec3) -> Option<f64> {
    let side = |p: &Vec3, q: &Vec3| (q.x - p.x) * (start.y - p.y) - (q.y - p.y) * (start.x - p.x);
    let (u, v, w) = (side(b, c), side(c, a), side(a, b));
    let whole = u + v + w;
    let within = (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0);
    within.then(|| (u * a.z + v * b.z + w * c.z) / whole - start.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pin is longer than it is wide: none of its many largest faces is an end.
    #[test]
    fn the_axis_of_a_slanted_prism_is_a_way() {
        let axis = Vec3::new(0.3, -0.2, 0.9).normalize();
        let across = axis.cross(&Vec3::x()).normalize();
        let other = axis.cross(&across);
        for sides in [5_u32, 12, 48] {
            let ring = |height: f64| {
                (0..sides).map(move |k| {
                    let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(sides)).sin_cos();
                    (across * cos + other * sin) * 2.0 + axis * height
                })
            };
            let walls = (0..sides).flat_map(|k| {
                let next = (k + 1) % sides;
                [[k, next, sides + next], [k, sides + next, sides + k]]
            });
            let ends = (1..sides - 1).flat_map(|k| [[0, k + 1, k], [sides, sides + k, sides + k + 1]]);
            let pin = TriangleMesh::<Object>::new(ring(0.0).chain(ring(40.0)).collect(), walls.chain(ends).collect());
            let found = ways(&pin);
            assert!([axis, -axis].iter().all(|way| found.iter().any(|one| one.dot(way) > SAME_WAY)), "{sides} sides");
        }
    }
}
