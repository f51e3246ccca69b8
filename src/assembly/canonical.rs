//! One form of a mesh for all triangulations of its plane faces.
//!
//! `boolmesh` goes through hash maps with a seed of their own in every run, and begins a face's triangles where these begin: the same
//! parts gave other triangles from run to run, over the same corners. Here each plane face is triangulated anew from its border alone,
//! and corners and facets are put in order, so that the same input gives the same bytes.

use std::collections::BTreeMap;

use crate::geom::{Object, Sets, Vec3};
use crate::mesh::{EdgeMap, TriangleMesh, patches, sides_of};

type Mesh = TriangleMesh<Object>;

/// Corners so near to a facet's plane lie in it, mm: far below what a file's numbers tell, far above rounding.
const PLANE_MM: f64 = 1e-7;

/// Areas of one face differ by no more, as a share: rounding.
const SAME_AREA: f64 = 1e-6;
/// A facet of less height has no plane of its own, mm.
const SLIVER_MM: f64 = 1e-6;

/// `mesh` with its plane faces triangulated by their borders, corners in the order of their coordinates and facets in that of their
/// corners. A face whose border cannot be triangulated keeps the facets that it had.
pub(super) fn canonical(mesh: &Mesh) -> Mesh {
    let (vertices, facets) = in_order(mesh.vertices(), mesh.facets());
    let mut anew = Vec::with_capacity(facets.len());
    for face in faces(&vertices, &facets) {
        match triangles(&vertices, &facets, &face) {
            Some(triangles) => anew.extend(triangles),
            None => anew.extend(face.iter().map(|&index| facets[index])),
        }
    }
    let mut used = vec![false; vertices.len()];
    anew.iter().flatten().for_each(|&v| used[v as usize] = true);
    let mut number = vec![0; vertices.len()];
    let mut kept = Vec::new();
    for (index, vertex) in vertices.into_iter().enumerate().filter(|(index, _)| used[*index]) {
        number[index] = kept.len() as u32;
        kept.push(vertex);
    }
    let mut facets: Vec<[u32; 3]> = anew.into_iter().map(|t| lowest_first(t.map(|v| number[v as usize]))).collect();
    facets.sort_unstable();
    Mesh::new(kept, facets)
}

/// Corners by coordinates, facets by corners.
fn in_order(vertices: &[Vec3], facets: &[[u32; 3]]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    let key = |v: &u32| &vertices[*v as usize];
    order.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
    });
    let mut number = vec![0; vertices.len()];
    order.iter().enumerate().for_each(|(place, &v)| number[v as usize] = place as u32);
    let mut facets: Vec<[u32; 3]> = facets.iter().map(|t| lowest_first(t.map(|v| number[v as usize]))).collect();
    facets.sort_unstable();
    (order.iter().map(|v| *key(v)).collect(), facets)
}

fn lowest_first(t: [u32; 3]) -> [u32; 3] {
    let lowest = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
    [0, 1, 2].map(|i| t[(lowest + i) % 3])
}

/// Facets by the plane face that they belong to, each in ascending order.
fn faces(vertices: &[Vec3], facets: &[[u32; 3]]) -> Vec<Vec<usize>> {
    let doubled = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| vertices[v as usize]);
        (b - a).cross(&(c - a))
    };
    let mut across: EdgeMap<Option<usize>> = EdgeMap::default();
    for (index, facet) in facets.iter().enumerate() {
        // A side that is there twice belongs to nobody.
        for side in sides_of(facet) {
            across.entry(side).and_modify(|of| *of = None).or_insert(Some(index));
        }
    }
    let normals: Vec<Vec3> = facets.iter().map(doubled).collect();
    let is_in = |other: usize, of: usize| {
        let origin = vertices[facets[of][0] as usize];
        let normal = normals[of].try_normalize(f64::MIN_POSITIVE);
        let near =
            |v: &u32| normal.is_some_and(|normal| (vertices[*v as usize] - origin).dot(&normal).abs() <= PLANE_MM);
        facets[other].iter().all(near)
    };
    // One as thin as that lies in every plane through its length: it must not make one face of two that meet there.
    let is_sliver = |index: usize| {
        let longest = sides_of(&facets[index]).map(|[a, b]| (vertices[a as usize] - vertices[b as usize]).norm());
        normals[index].norm() <= SLIVER_MM * longest.into_iter().fold(0.0, f64::max)
    };
    let slivers: Vec<bool> = (0..facets.len()).map(is_sliver).collect();
    let beside = |index: usize| {
        let sides = sides_of(&facets[index]).into_iter();
        sides.filter_map(|[a, b]| across.get(&[b, a]).copied().flatten()).collect::<Vec<usize>>()
    };
    let mut sets = Sets::new(facets.len());
    for index in (0..facets.len()).filter(|&index| !slivers[index]) {
        for other in beside(index).into_iter().filter(|&other| other > index && !slivers[other]) {
            // The larger facet tells the plane, the other one has to lie in it, the same way up.
            let larger_first = normals[index].norm() >= normals[other].norm();
            let (of, far) = if larger_first { (index, other) } else { (other, index) };
            if is_in(far, of) && normals[index].dot(&normals[other]) >= 0.0 {
                sets.join(index as u32, other as u32);
            }
        }
    }
    for index in (0..facets.len()).filter(|&index| slivers[index]) {
        let larger = |a: &usize, b: &usize| normals[*a].norm().total_cmp(&normals[*b].norm()).then(b.cmp(a));
        let own = beside(index).into_iter().filter(|&of| !slivers[of] && is_in(index, of)).max_by(larger);
        own.into_iter().for_each(|of| _ = sets.join(index as u32, of as u32));
    }
    let mut faces: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    (0..facets.len()).for_each(|index| faces.entry(sets.root(index as u32)).or_default().push(index));
    faces.into_values().collect()
}

/// The face's triangles from its border alone; `None` where it is one facet, or its border cannot be triangulated.
fn triangles(vertices: &[Vec3], facets: &[[u32; 3]], face: &[usize]) -> Option<Vec<[u32; 3]>> {
    let mut border: Vec<[u32; 2]> = face.iter().flat_map(|&index| sides_of(&facets[index])).collect();
    border.sort_unstable();
    let inner: Vec<[u32; 2]> = border.iter().copied().filter(|&[a, b]| border.binary_search(&[b, a]).is_ok()).collect();
    if inner.is_empty() {
        return None;
    }
    border.retain(|side| inner.binary_search(side).is_err());
    let doubled = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| vertices[v as usize]);
        (b - a).cross(&(c - a))
    };
    let facing = face.iter().map(|&index| doubled(&facets[index])).sum::<Vec3>().try_normalize(f64::MIN_POSITIVE)?;
    let made: Vec<[u32; 3]> =
        patches(vertices, &border, &facing).ok()?.into_iter().flat_map(|patch| patch.triangles).collect();
    // What is no plane face after all, or folded, has another area.
    let before: f64 = face.iter().map(|&index| doubled(&facets[index]).norm()).sum();
    let after: f64 = made.iter().map(|t| doubled(t).norm()).sum();
    ((after - before).abs() <= SAME_AREA * before).then_some(made)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Bounds;

    /// A box whose top is parted in four ways, over the same corners and a corner in the middle of one side.
    fn boxes() -> Vec<Mesh> {
        let cube = Mesh::cuboid(&Bounds { min: Vec3::zeros(), max: Vec3::new(4.0, 2.0, 1.0) });
        let at = |x: f64, y: f64, z: f64| {
            cube.vertices().iter().position(|v| *v == Vec3::new(x, y, z)).expect("a corner of the box") as u32
        };
        let top = [at(0.0, 0.0, 1.0), at(4.0, 0.0, 1.0), at(4.0, 2.0, 1.0), at(0.0, 2.0, 1.0)];
        let front = [at(0.0, 0.0, 0.0), at(4.0, 0.0, 0.0)];
        let is_of = |t: &&[u32; 3], plane: fn(&Vec3) -> bool| t.iter().all(|v| plane(&cube.vertices()[*v as usize]));
        let rest = |t: &&[u32; 3]| !is_of(t, |v| v.z == 1.0) && !is_of(t, |v| v.y == 0.0);
        let rest: Vec<[u32; 3]> = cube.facets().iter().filter(rest).copied().collect();
        let mut vertices = cube.vertices().to_vec();
        let middle = vertices.len() as u32;
        vertices.push(Vec3::new(2.0, 0.0, 1.0));
        // The front has the corner as well, always the same way.
        let front = [[front[0], front[1], middle], [front[0], middle, top[0]], [front[1], top[1], middle]];
        let tops = [
            vec![[top[0], middle, top[3]], [middle, top[2], top[3]], [middle, top[1], top[2]]],
            vec![[top[0], middle, top[2]], [top[0], top[2], top[3]], [middle, top[1], top[2]]],
            vec![[top[0], middle, top[3]], [middle, top[1], top[3]], [top[1], top[2], top[3]]],
        ];
        let turned = |way: usize| {
            let facets: Vec<[u32; 3]> = rest.iter().chain(&front).chain(&tops[way % 3]).copied().collect();
            let mut facets: Vec<[u32; 3]> = facets.iter().map(|t| [0, 1, 2].map(|i| t[(i + way) % 3])).collect();
            facets.rotate_left(way);
            Mesh::new(vertices.clone(), facets)
        };
        (0..6).map(turned).collect()
    }

    #[test]
    fn every_triangulation_of_a_face_gives_the_same_mesh() {
        let all: Vec<Mesh> = boxes().iter().map(canonical).collect();
        assert!((all[0].volume() - 8.0).abs() < 1e-12 && all[0].vertices().len() == 9);
        for other in &all[1..] {
            assert_eq!((other.vertices(), other.facets()), (all[0].vertices(), all[0].facets()));
        }
        // Every side has its partner: the corner in the middle of a side is one of both faces.
        let sides: Vec<[u32; 2]> = all[0].facets().iter().flat_map(sides_of).collect();
        assert!(sides.iter().all(|&[a, b]| sides.iter().filter(|side| **side == [b, a]).count() == 1));
    }

    #[test]
    fn faces_are_told_apart_and_keep_their_number_of_facets() {
        let ring = (0..32).map(|i| f64::from(i) * std::f64::consts::TAU / 32.0).map(|a| [5.0 * a.cos(), 5.0 * a.sin()]);
        let column = crate::fixtures::prism(&ring.collect::<Vec<_>>(), [0.0, 7.0]);
        let after = canonical(&column);
        let (vertices, facets) = in_order(column.vertices(), column.facets());
        assert_eq!(faces(&vertices, &facets).len(), 34);
        assert_eq!(after.facets().len(), column.facets().len());
        assert!((after.volume() - column.volume()).abs() < 1e-9 * column.volume());
    }
}
