//! Lids for holes whose border is one flat simple loop.

use std::collections::BTreeMap;

use crate::geom::{Bounds, Vec3};

/// A border may leave its mean plane by this share of its diagonal; more would be guessing at the lost surface.
const FLAT_WITHIN: f64 = 1e-3;

/// Loops of border vertices in the sense of the facets that are to fill them, hence against the border's own edges.
///
/// Vertices where borders meet are ambiguous; a loop that runs through one is left out.
pub(super) fn loops(open: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &[from, to] in open {
        next.entry(to).or_default().push(from);
    }
    let mut loops = Vec::new();
    let mut used = std::collections::BTreeSet::new();
    for &[_, start] in open {
        let mut border = Vec::new();
        let mut at = start;
        while used.insert(at) {
            border.push(at);
            match next.get(&at).map(Vec::as_slice) {
                Some(&[only]) => at = only,
                _ => break,
            }
        }
        if at == start && border.len() >= 3 {
            loops.push(border);
        }
    }
    loops
}

/// Facets that fill `border`, in its sense; `None` where it is not flat or crosses itself.
pub(super) fn lid(vertices: &[Vec3], border: &[u32]) -> Option<Vec<[u32; 3]>> {
    let at: Vec<Vec3> = border.iter().map(|&index| vertices[index as usize]).collect();
    let centre = at.iter().sum::<Vec3>() / at.len() as f64;
    let around = at.iter().zip(at.iter().cycle().skip(1));
    let normal = around.map(|(a, b)| (a - centre).cross(&(b - centre))).sum::<Vec3>().try_normalize(0.0)?;
    let limit = FLAT_WITHIN * Bounds::of(at.iter().copied()).size().norm();
    if at.iter().any(|p| (p - centre).dot(&normal).abs() > limit) {
        return None;
    }
    let u = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
    let v = normal.cross(&u);
    let flat: Vec<[f64; 2]> = at.iter().map(|p| [(p - centre).dot(&u), (p - centre).dot(&v)]).collect();
    let facets = clip_ears(&flat)?;
    Some(facets.into_iter().map(|facet| facet.map(|i| border[i])).collect())
}

/// Twice the signed area of a triangle.
fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Cuts ears off a counter-clockwise polygon until a triangle is left; `None` where no ear is found.
fn clip_ears(at: &[[f64; 2]]) -> Option<Vec<[usize; 3]>> {
    let mut left: Vec<usize> = (0..at.len()).collect();
    let mut facets = Vec::with_capacity(at.len().saturating_sub(2));
    while left.len() > 3 {
        let n = left.len();
        let ear = (0..n).find(|&i| {
            let corner = [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
            let [a, b, c] = corner.map(|index| at[index]);
            let inside = |p: [f64; 2]| cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0;
            cross(a, b, c) > 0.0 && !left.iter().any(|index| !corner.contains(index) && inside(at[*index]))
        })?;
        facets.push([left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]]);
        left.remove(ear);
    }
    facets.push([left[0], left[1], left[2]]);
    Some(facets)
}

#[cfg(test)]
mod tests {
    use super::{cross, lid, loops};
    use crate::geom::Vec3;

    fn flat(points: &[[f64; 2]]) -> Vec<Vec3> {
        points.iter().map(|p| Vec3::new(p[0], p[1], 5.0)).collect()
    }

    #[test]
    fn fills_a_border_that_is_not_convex() {
        let points = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]];
        let lid = lid(&flat(&points), &[0, 1, 2, 3, 4]).unwrap();
        let areas: Vec<f64> = lid
            .iter()
            .map(|f| 0.5 * cross(points[f[0] as usize], points[f[1] as usize], points[f[2] as usize]))
            .collect();
        assert_eq!(areas.len(), 3);
        assert!(areas.iter().all(|&area| area > 0.0));
        assert!((areas.iter().sum::<f64>() - 10.0).abs() < 1e-12, "{areas:?}");
    }

    #[test]
    fn refuses_a_border_that_crosses_itself() {
        let points = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]];
        assert_eq!(lid(&flat(&points), &[0, 1, 2, 3]), None);
    }

    #[test]
    fn loops_run_against_the_border_and_avoid_crossings() {
        assert_eq!(loops(&[[0, 1], [1, 2], [2, 0]]), [[1, 0, 2]]);
        let eight = [[0, 1], [1, 2], [2, 0], [0, 3], [3, 4], [4, 0]];
        assert!(loops(&eight).is_empty(), "two triangles that meet at vertex 0");
    }
}
