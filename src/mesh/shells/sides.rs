//! Sides of facets that end at corners of others.

use std::collections::{BTreeSet, HashMap};

use super::{Surface, shells};
use crate::geom::{Bounds, Vec3};
use crate::mesh::box_tree::BoxTree;

/// A facet may have corners on each of its sides.
const ROUNDS: usize = 4;

/// Parts open sides at corners of other open sides that lie on them, as programs leave them that put solids together; returns how many.
pub(super) fn part_sides(vertices: &[Vec3], surface: &mut Surface, within: f64) -> usize {
    let mut parted = 0;
    for _ in 0..ROUNDS {
        let open: Vec<[u32; 2]> = shells(vertices, &surface.facets).into_iter().flat_map(|shell| shell.open).collect();
        let border: Vec<u32> = open.iter().flatten().copied().collect::<BTreeSet<u32>>().into_iter().collect();
        let points = border.iter().map(|&index| Bounds::of(std::iter::once(vertices[index as usize]))).collect();
        let tree = BoxTree::of_boxes(points);
        let corners_on = |side: [u32; 2]| -> Vec<u32> {
            let [a, b] = side.map(|index| vertices[index as usize]);
            let along = b - a;
            let length = along.norm();
            let mut on: Vec<(f64, u32)> = Vec::new();
            tree.visit(&Bounds::of([a, b]).inflated(within), |place| {
                let at = vertices[border[place] as usize] - a;
                let t = at.dot(&along) / length;
                let beside = (at - along * (t / length)).norm();
                if t > within && t < length - within && beside <= within && !side.contains(&border[place]) {
                    on.push((t, border[place]));
                }
            });
            on.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            on.dedup_by_key(|(_, index)| *index);
            on.into_iter().map(|(_, index)| index).collect()
        };
        let chains: HashMap<[u32; 2], Vec<u32>> =
            open.into_iter().map(|side| (side, corners_on(side))).filter(|(_, on)| !on.is_empty()).collect();
        if chains.is_empty() {
            break;
        }
        let given = std::mem::take(surface);
        for (facet, source) in given.facets.into_iter().zip(given.source) {
            let side = (0..3).find_map(|k| Some((k, chains.get(&[facet[k], facet[(k + 1) % 3]])?)));
            let Some((k, on)) = side.filter(|(k, on)| !on.contains(&facet[(k + 2) % 3])) else {
                surface.facets.push(facet);
                surface.source.push(source);
                continue;
            };
            parted += 1;
            let apex = facet[(k + 2) % 3];
            let stops: Vec<u32> =
                [facet[k]].into_iter().chain(on.iter().copied()).chain([facet[(k + 1) % 3]]).collect();
            for pair in stops.windows(2) {
                surface.facets.push([pair[0], pair[1], apex]);
                surface.source.push(source);
            }
        }
    }
    parted
}
