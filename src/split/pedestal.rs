//! A part of its own below the model, printed first, where low overhangs are beyond the reach of a head beside the table.

use std::collections::{BTreeMap, BTreeSet};

use super::measure::Measured;
use super::surface::{OWN, Surface};
use crate::geom::{Sets, Vec3};
use crate::overhang::NARROWEST_LINES;

/// The model's footprint drawn down by `height_mm`, closed; its top is the model's own facets, turned over. What of it is too narrow for a line
/// of `line_mm` is left out. `None` for a model that stands on nothing but edges.
pub(super) fn pedestal(model: &Measured, height_mm: f64, line_mm: f64) -> Option<Surface> {
    let feet: Vec<usize> = (0..model.area.len()).filter(|&f| model.on_table[f]).collect();
    let foot = wide(&model.surface.select(feet.iter().copied()), NARROWEST_LINES * line_mm);
    if foot.facets.is_empty() {
        return None;
    }
    let count = foot.vertices.len() as u32;
    let lower = foot.vertices.iter().map(|v| v - Vec3::z() * height_mm);
    let vertices: Vec<Vec3> = foot.vertices.iter().copied().chain(lower).collect();
    let mut facets: Vec<[u32; 3]> = Vec::new();
    let mut edges: BTreeSet<[u32; 2]> = BTreeSet::new();
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

/// The pieces of a level surface, connected along edges, that are as wide as this on average, mm: twice the area by the length around it.
fn wide(foot: &Surface, least_mm: f64) -> Surface {
    let mut sets = Sets::new(foot.facets.len());
    // The sides that no other facet has turned over, and whose they are.
    let mut sides: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for (facet, &[a, b, c]) in foot.facets.iter().enumerate() {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            match sides.remove(&[q, p]) {
                Some(other) => _ = sets.join(other, facet as u32),
                None => _ = sides.insert([p, q], facet as u32),
            }
        }
    }
    // By piece: twice the area, and the length around it.
    let mut sizes = vec![[0.0; 2]; foot.facets.len()];
    for facet in 0..foot.facets.len() {
        sizes[sets.root(facet as u32) as usize][0] += foot.area_vector(facet).norm();
    }
    for ([p, q], facet) in sides {
        let length = (foot.vertices[p as usize] - foot.vertices[q as usize]).norm();
        sizes[sets.root(facet) as usize][1] += length;
    }
    let is_wide = |facet: &usize| {
        let [twice_mm2, around_mm] = sizes[sets.root(*facet as u32) as usize];
        twice_mm2 >= least_mm * around_mm
    };
    foot.select((0..foot.facets.len()).filter(is_wide).collect::<Vec<_>>().into_iter())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of so many mm from (0, y), in two facets, and one beside it.
    #[test]
    fn what_is_too_narrow_for_a_line_has_no_pedestal() {
        let strip = |wide: f64, y: f64| {
            [[0.0, y], [30.0, y], [30.0, y + wide], [0.0, y + wide]].map(|[x, y]| Vec3::new(x, y, 0.0))
        };
        let of = |first: f64, second: f64| Surface {
            vertices: [strip(first, 0.0), strip(second, 20.0)].concat(),
            facets: vec![[0, 2, 1], [0, 3, 2], [4, 6, 5], [4, 7, 6]],
            source: vec![OWN; 4],
        };
        for (first, second, left) in
            [(10.0, 10.0, 4), (10.0, 0.25, 2), (0.25, 10.0, 2), (10.0, 0.0, 2), (0.4, 0.31, 4), (0.2, 0.1, 0)]
        {
            assert_eq!(wide(&of(first, second), 0.3).facets.len(), left, "{first} and {second} mm");
        }
        // A sliver that meets the wide one in a corner is a piece of its own.
        let mut touching = of(10.0, 0.1);
        touching.vertices[4..].iter_mut().for_each(|v| *v += Vec3::new(30.0, -10.0, 0.0));
        touching.facets[2..].iter_mut().flatten().filter(|v| **v == 4).for_each(|v| *v = 2);
        assert_eq!(wide(&touching, 0.3).facets.len(), 2);
    }
}
