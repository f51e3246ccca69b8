//! Whole models through `read_model`, with figures worked by hand.

mod formats;
pub(crate) mod shapes;
mod solids;
mod strangers;

use super::{Fault, Model, ReadOptions, TriangleMesh, read_model, stl_binary_parts};
use crate::geom::{Object, Vec3};

type Mesh = TriangleMesh<Object>;

/// Reads with no options.
fn read(bytes: &[u8], name: &str) -> Result<Model, super::MeshError> {
    read_model(bytes, name, &ReadOptions::default())
}

/// The model of these meshes, written one after the other as binary STL.
fn model(meshes: &[&Mesh]) -> Model {
    read(&stl_binary_parts(meshes), "x.stl").unwrap()
}

fn fault(meshes: &[&Mesh]) -> Fault {
    read(&stl_binary_parts(meshes), "x.stl").unwrap_err().fault
}

/// A cube of edge `size` with its lowest corner at `at`; `other` cuts its faces along the other diagonal.
fn cube(at: [f64; 3], size: f64, other: bool) -> Mesh {
    let corner = |i: u32| Vec3::from(at) + Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * size;
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let split = |[a, b, c, d]: [u32; 4]| if other { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] };
    Mesh::new((0..8).map(corner).collect(), faces.into_iter().flat_map(split).collect())
}

/// The mesh turned inside out.
fn inside_out(mesh: &Mesh) -> Mesh {
    Mesh::new(mesh.vertices().to_vec(), mesh.facets().iter().map(|&[a, b, c]| [a, c, b]).collect())
}

/// The facets of all meshes taken in turn, as an exporter that sorts facets by place might write them.
fn interleaved(meshes: &[&Mesh]) -> Mesh {
    let (mut vertices, mut facets) = (Vec::new(), Vec::new());
    for index in 0..meshes[0].facets().len() {
        for mesh in meshes {
            let first = vertices.len() as u32;
            vertices.extend(mesh.corners(index));
            facets.push([first, first + 1, first + 2]);
        }
    }
    Mesh::new(vertices, facets)
}

fn close(found: f64, wanted: f64) -> bool {
    (found - wanted).abs() <= 1e-9 * wanted.abs().max(1.0)
}

fn assert_volumes(model: &Model, wanted: &[f64]) {
    let found: Vec<f64> = model.parts.iter().map(|part| part.mesh.volume()).collect();
    assert!(
        found.len() == wanted.len() && found.iter().zip(wanted).all(|(a, b)| close(*a, *b)),
        "{found:?}, wanted {wanted:?}"
    );
}
