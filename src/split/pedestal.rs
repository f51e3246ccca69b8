//! A part of its own below the model, printed first, where low overhangs are beyond the reach of a head beside the table.

use super::measure::Measured;
use super::surface::{OWN, Surface};
use crate::geom::Vec3;

/// The model's footprint drawn down by `height_mm`, closed; its top is the model's own facets, turned over. `None` for a model
/// that stands on nothing but edges.
pub(super) fn pedestal(model: &Measured, height_mm: f64) -> Option<Surface> {
    let feet: Vec<usize> = (0..model.area.len()).filter(|&f| model.on_table[f]).collect();
    let foot = model.surface.select(feet.iter().copied());
    if foot.facets.is_empty() {
        return None;
    }
    let count = foot.vertices.len() as u32;
    let lower = foot.vertices.iter().map(|v| v - Vec3::z() * height_mm);
    let vertices: Vec<Vec3> = foot.vertices.iter().copied().chain(lower).collect();
    let mut facets: Vec<[u32; 3]> = Vec::new();
    let mut edges: std::collections::BTreeSet<[u32; 2]> = std::collections::BTreeSet::new();
    for &[a, b, c] in &foot.facets {
        facets.extend([[a, c, b], [a + count, b + count, c + count]]);
        for [p, q] in [[a, b], [b, c], [c, a]] {
            // What is left in the end are the edges around the footprint.
            if !edges.remove(&[q, p]) {
                edges.insert([p, q]);
            }
        }
    }
    for [p, q] in edges {
        facets.extend([[p, q, q + count], [p, q + count, p + count]]);
    }
    let source = vec![OWN; facets.len()];
    Some(Surface { vertices, facets, source })
}
