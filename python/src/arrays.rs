//! Arrays of NumPy's as the bytes of a 3MF, in which coordinates keep every bit: a plan names its model by the hash of such bytes.

use numpy::ndarray::ArrayView2;
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use trunnion::geom::Vec3;
use trunnion::mesh::{TriangleMesh, threemf};

use crate::trouble::Trouble;

/// What is refused, in one sentence.
type Sentence = String;

/// Meshes, each `(name, vertices n x 3 float64 in mm, facets m x 3 int64)`, as 3MF. The arrays are read where they are.
#[pyfunction]
pub(crate) fn encode<'py>(
    py: Python<'py>,
    meshes: Vec<(String, PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, i64>)>,
) -> PyResult<Bound<'py, PyBytes>> {
    let refused = |text| Trouble::input(text).raised(py);
    if meshes.is_empty() {
        return Err(refused("no meshes; give at least one".to_owned()));
    }
    let mut made: Vec<(String, TriangleMesh)> = Vec::new();
    for (name, vertices, facets) in &meshes {
        for (what, shape) in [("vertices", vertices.shape()), ("facets", facets.shape())] {
            shaped(name, what, [shape[0], shape[1]]).map_err(refused)?;
        }
        let mesh = mesh(name, &vertices.as_array(), &facets.as_array()).map_err(refused)?;
        made.push((name.clone(), mesh));
    }
    let bytes = py.detach(|| threemf(&made.iter().map(|(name, mesh)| (name.clone(), mesh)).collect::<Vec<_>>()));
    Ok(PyBytes::new(py, &bytes))
}

fn shaped(name: &str, what: &str, shape: [usize; 2]) -> Result<(), Sentence> {
    match shape {
        [_, columns] if columns != 3 => {
            Err(format!("{name}: {what} must have 3 columns (n x 3), got shape {} x {columns}", shape[0]))
        }
        [0, _] => Err(format!("{name}: {what} are empty; give at least one row")),
        _ => Ok(()),
    }
}

fn mesh(name: &str, vertices: &ArrayView2<'_, f64>, facets: &ArrayView2<'_, i64>) -> Result<TriangleMesh, Sentence> {
    let mut points = Vec::with_capacity(vertices.nrows());
    for (index, row) in vertices.rows().into_iter().enumerate() {
        let point = Vec3::new(row[0], row[1], row[2]);
        if !point.iter().all(|v| v.is_finite()) {
            let [x, y, z] = point.into();
            return Err(format!("{name}: vertex {index} is ({x}, {y}, {z}); coordinates must be finite numbers"));
        }
        points.push(point);
    }
    let mut corners = Vec::with_capacity(facets.nrows());
    for (index, row) in facets.rows().into_iter().enumerate() {
        let mut facet = [0_u32; 3];
        for (corner, &given) in facet.iter_mut().zip(row) {
            let inside = usize::try_from(given).ok().filter(|given| *given < points.len());
            *corner = inside.and_then(|given| u32::try_from(given).ok()).ok_or_else(|| {
                format!("{name}: facet {index} refers to vertex {given}; the vertices are 0..{}", points.len() - 1)
            })?;
        }
        corners.push(facet);
    }
    Ok(TriangleMesh::new(points, corners))
}
