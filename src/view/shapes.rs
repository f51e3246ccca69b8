//! The parts' surfaces for the page: whole micrometres, neighbours by their difference; a large model is thinned.

use std::collections::HashMap;

use super::pack::Column;
use crate::geom::Vec3;
use crate::mesh::TriangleMesh;

/// Facets that a page holds of all parts together: some 600 kB.
const MOST_FACETS: usize = 80_000;

/// Parts, packed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shapes {
    /// Corners and facets of each part, in order.
    pub counts: Vec<[usize; 2]>,
    /// Whether corners were gathered in cells, since there were too many.
    pub thinned: bool,
    pub(super) vertices: Column,
    pub(super) facets: Column,
}

impl Shapes {
    /// The surfaces of `parts`, in any one frame.
    pub fn of<F>(parts: &[TriangleMesh<F>]) -> Self {
        let facets: usize = parts.iter().map(|p| p.facets().len()).sum();
        let mut all: Vec<_> = parts.iter().map(|p| (p.vertices().to_vec(), p.facets().to_vec())).collect();
        // Evenly spread, a square of a cell's edge has two facets.
        let area: f64 = parts.iter().map(TriangleMesh::area).sum();
        let mut cell = (2.0 * area / MOST_FACETS as f64).sqrt().max(1e-6) * 0.8;
        let thinned = facets > MOST_FACETS;
        while all.iter().map(|(_, f)| f.len()).sum::<usize>() > MOST_FACETS {
            all = parts.iter().map(|p| gathered(p.vertices(), p.facets(), cell)).collect();
            cell *= 1.3;
        }
        let mut shapes = Self { counts: Vec::new(), thinned, vertices: Column::default(), facets: Column::default() };
        all.iter().for_each(|(vertices, facets)| shapes.push(vertices, facets));
        shapes
    }

    /// Appends corners and facets to `out`, each behind its length (four bytes, the lowest first), not compressed.
    pub fn append(&self, out: &mut Vec<u8>) {
        for Column(bytes) in [&self.vertices, &self.facets] {
            out.extend((bytes.len() as u32).to_le_bytes());
            out.extend(bytes);
        }
    }

    fn push(&mut self, vertices: &[Vec3], facets: &[[u32; 3]]) {
        self.counts.push([vertices.len(), facets.len()]);
        let mut last = [0i64; 3];
        for vertex in vertices {
            for axis in 0..3 {
                let um = (vertex[axis] * 1000.0).round() as i64;
                self.vertices.signed(um - last[axis]);
                last[axis] = um;
            }
        }
        let mut last = 0;
        for &index in facets.iter().flatten() {
            self.facets.signed(i64::from(index) - last);
            last = i64::from(index);
        }
    }
}

/// The corners of a cell become their mean; facets that lose an edge go.
fn gathered(vertices: &[Vec3], facets: &[[u32; 3]], cell: f64) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut cells: HashMap<[i64; 3], usize> = HashMap::new();
    let mut sums: Vec<(Vec3, f64)> = Vec::new();
    let mut into = Vec::with_capacity(vertices.len());
    for v in vertices {
        let key = [0, 1, 2].map(|i: usize| (v[i] / cell).floor() as i64);
        let at = *cells.entry(key).or_insert(sums.len());
        if at == sums.len() {
            sums.push((Vec3::zeros(), 0.0));
        }
        sums[at] = (sums[at].0 + v, sums[at].1 + 1.0);
        into.push(at as u32);
    }
    let turned = facets.iter().map(|f| f.map(|i| into[i as usize]));
    let kept = turned.filter(|[a, b, c]| a != b && b != c && a != c).collect();
    (sums.iter().map(|(sum, count)| sum / *count).collect(), kept)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Object;

    #[test]
    fn a_large_part_is_thinned_and_keeps_its_shape() {
        // A ball of radius 20 in 180,000 facets.
        let (rings, around) = (300u32, 300u32);
        let at = |i: u32, j: u32| {
            let (s, c) = (std::f64::consts::PI * f64::from(i) / f64::from(rings)).sin_cos();
            let (t, u) = (std::f64::consts::TAU * f64::from(j) / f64::from(around)).sin_cos();
            Vec3::new(s * u, s * t, c) * 20.0
        };
        let vertices = (0..=rings).flat_map(|i| (0..around).map(move |j| at(i, j))).collect();
        let quad = |i: u32, j: u32| {
            let k = (j + 1) % around;
            let [a, b, c, d] = [i * around + j, (i + 1) * around + j, (i + 1) * around + k, i * around + k];
            [[a, b, c], [a, c, d]]
        };
        let facets = (0..rings).flat_map(|i| (0..around).flat_map(move |j| quad(i, j))).collect();
        let ball = TriangleMesh::<Object>::new(vertices, facets);
        let shapes = Shapes::of(std::slice::from_ref(&ball));
        assert!(shapes.thinned && (5_000..=MOST_FACETS).contains(&shapes.counts[0][1]), "{:?}", shapes.counts);
        let (corners, kept) = gathered(ball.vertices(), ball.facets(), 0.5);
        assert!(corners.iter().all(|v| (19.8..20.01).contains(&v.norm())));
        let thin = TriangleMesh::<Object>::new(corners, kept);
        assert!((thin.volume() / ball.volume() - 1.0).abs() < 0.02, "{}", thin.volume() / ball.volume());
    }
}
