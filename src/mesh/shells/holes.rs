//! Borders of holes, and lids for those that are flat.

use std::collections::{BTreeMap, HashMap};

use crate::geom::{Bounds, Vec3};

/// A flat border may leave its mean plane by this share of its diagonal; more would be guessing at the lost surface.
pub(super) const FLAT_WITHIN: f64 = 1e-3;

/// Loops of border vertices in the sense of the facets that are to fill them, hence against the border's own edges.
///
/// Where borders meet in a vertex, what comes back to it first is a loop of its own, so that none meets itself.
pub(super) fn loops(open: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &[from, to] in open {
        next.entry(to).or_default().push(from);
    }
    let mut loops = Vec::new();
    let (mut way, mut places): (Vec<u32>, HashMap<u32, usize>) = (Vec::new(), HashMap::new());
    for &[_, start] in open {
        let mut at = start;
        loop {
            if let Some(&place) = places.get(&at) {
                let border = way.split_off(place);
                for vertex in &border {
                    places.remove(vertex);
                }
                if border.len() >= 3 {
                    loops.push(border);
                }
            }
            places.insert(at, way.len());
            way.push(at);
            match next.get_mut(&at).and_then(Vec::pop) {
                Some(to) => at = to,
                None => break,
            }
        }
        way.clear();
        places.clear();
    }
    loops
}

/// The edges of each border, those that hang together by vertices being of one.
pub(super) fn borders(open: &[[u32; 2]]) -> Vec<Vec<[u32; 2]>> {
    let mut at: HashMap<u32, Vec<usize>> = HashMap::new();
    for (index, vertex) in open.iter().enumerate().flat_map(|(index, edge)| edge.map(|vertex| (index, vertex))) {
        at.entry(vertex).or_default().push(index);
    }
    let mut seen = vec![false; open.len()];
    let mut borders = Vec::new();
    for first in 0..open.len() {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let (mut border, mut next) = (vec![first], 0);
        while let Some(&edge) = border.get(next) {
            next += 1;
            // Taken out, so that a vertex of many edges is looked at once.
            for other in open[edge].iter().flat_map(|vertex| at.remove(vertex).unwrap_or_default()) {
                if !std::mem::replace(&mut seen[other], true) {
                    border.push(other);
                }
            }
        }
        border.sort_unstable();
        borders.push(border.into_iter().map(|edge| open[edge]).collect());
    }
    borders
}

/// The middle of a border's edges.
pub(super) fn middle(vertices: &[Vec3], border: &[[u32; 2]]) -> Vec3 {
    let sum: Vec3 = border.iter().flatten().map(|&index| vertices[index as usize]).sum();
    sum / (2 * border.len()).max(1) as f64
}

/// The middle and the unit normal of a loop's mean plane, and how far the loop leaves it.
fn plane(at: &[Vec3]) -> Option<(Vec3, Vec3, f64)> {
    let centre = at.iter().sum::<Vec3>() / at.len() as f64;
    let around = at.iter().zip(at.iter().cycle().skip(1));
    let normal = around.map(|(a, b)| (a - centre).cross(&(b - centre))).sum::<Vec3>().try_normalize(0.0)?;
    let off = at.iter().map(|p| (p - centre).dot(&normal).abs()).fold(0.0, f64::max);
    Some((centre, normal, off))
}

/// How far a loop leaves its mean plane, file units.
pub(super) fn out_of_flat(vertices: &[Vec3], border: &[u32]) -> Option<f64> {
    let at: Vec<Vec3> = border.iter().map(|&index| vertices[index as usize]).collect();
    plane(&at).map(|(_, _, off)| off)
}

/// Facets that fill `border`, in its sense; `None` where it leaves its mean plane by more than `within` of its diagonal, or crosses itself.
pub(super) fn lid(vertices: &[Vec3], border: &[u32], within: f64) -> Option<Vec<[u32; 3]>> {
    let at: Vec<Vec3> = border.iter().map(|&index| vertices[index as usize]).collect();
    let (centre, normal, off) = plane(&at)?;
    if off > within * Bounds::of(at.iter().copied()).size().norm() {
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
    use super::{FLAT_WITHIN, borders, cross, lid, loops};
    use crate::geom::Vec3;

    fn flat(points: &[[f64; 2]]) -> Vec<Vec3> {
        points.iter().map(|p| Vec3::new(p[0], p[1], 5.0)).collect()
    }

    #[test]
    fn fills_a_border_that_is_not_convex() {
        let points = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]];
        let lid = lid(&flat(&points), &[0, 1, 2, 3, 4], FLAT_WITHIN).unwrap();
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
        assert_eq!(lid(&flat(&points), &[0, 1, 2, 3], FLAT_WITHIN), None);
    }

    #[test]
    fn loops_run_against_the_border_and_end_where_they_meet() {
        assert_eq!(loops(&[[0, 1], [1, 2], [2, 0]]), [[1, 0, 2]]);
        let eight = [[0, 1], [1, 2], [2, 0], [0, 3], [3, 4], [4, 0]];
        let mut two = loops(&eight);
        two.iter_mut().for_each(|one| one.sort_unstable());
        two.sort();
        assert_eq!(two, [[0, 1, 2], [0, 3, 4]], "two triangles that meet at vertex 0");
        assert_eq!(borders(&eight).len(), 1);
        assert!(loops(&[[0, 1], [1, 2]]).is_empty(), "an open line is no loop");
    }
}
