//! The nearest of many points, some of which are taken away or come later: a grid of cells, looked at in rings.

use super::region::GridPoint;

/// Points to be asked for the nearest.
pub(super) struct Nearest {
    points: Vec<GridPoint>,
    low: GridPoint,
    cell: f64,
    size: [usize; 2],
    cells: Vec<Vec<u32>>,
    count: usize,
}

/// About so many points share a cell.
const TOGETHER: f64 = 2.0;

impl Nearest {
    /// None of the points counts until it is added.
    pub(super) fn of(points: Vec<GridPoint>) -> Self {
        let bounds = |of: fn(&GridPoint) -> i32| {
            let values = points.iter().map(of);
            (values.clone().min().unwrap_or(0), values.max().unwrap_or(0))
        };
        let (x, y) = (bounds(|p| p.x), bounds(|p| p.y));
        let across = [x, y].map(|(low, high)| f64::from(high) - f64::from(low) + 1.0);
        let cells = (points.len() as f64 / TOGETHER).max(1.0);
        // Square cells; along a line of points no more of them than points.
        let cell = (across[0] * across[1] / cells).sqrt().max(across[0].max(across[1]) / cells);
        let size = across.map(|across| (across / cell) as usize + 1);
        Self { points, low: GridPoint::new(x.0, y.0), cell, size, cells: vec![Vec::new(); size[0] * size[1]], count: 0 }
    }

    /// All of the points count.
    pub(super) fn all(points: Vec<GridPoint>) -> Self {
        let mut nearest = Self::of(points);
        (0..nearest.points.len()).for_each(|index| nearest.add(index));
        nearest
    }

    pub(super) fn add(&mut self, index: usize) {
        let cell = self.index(self.cell_of(self.points[index]));
        self.cells[cell].push(index as u32);
        self.count += 1;
    }

    pub(super) fn remove(&mut self, index: usize) {
        let cell = self.index(self.cell_of(self.points[index]));
        if let Some(place) = self.cells[cell].iter().position(|&i| i as usize == index) {
            self.cells[cell].swap_remove(place);
            self.count -= 1;
        }
    }

    /// The nearest point that counts; of several the one with the lowest number.
    pub(super) fn to(&self, at: GridPoint) -> Option<usize> {
        if self.count == 0 {
            return None;
        }
        let middle = self.cell_of(at).map(|v| v as i64);
        let mut best = (i64::MAX, u32::MAX);
        for ring in 0..self.size[0].max(self.size[1]) as i64 {
            self.each_of_ring(middle, ring, |index| {
                let p = self.points[index as usize];
                let squared = (i64::from(p.x) - i64::from(at.x)).pow(2) + (i64::from(p.y) - i64::from(at.y)).pow(2);
                best = best.min((squared, index));
            });
            // What lies farther out is at least so far away, also from a point outside the box.
            if best.0 < i64::MAX && (best.0 as f64).sqrt() < ring as f64 * self.cell {
                break;
            }
        }
        Some(best.1 as usize)
    }

    fn each_of_ring(&self, middle: [i64; 2], ring: i64, mut visit: impl FnMut(u32)) {
        let in_grid = |v: i64, i: usize| (0..self.size[i] as i64).contains(&v);
        for y in middle[1] - ring..=middle[1] + ring {
            if !in_grid(y, 1) {
                continue;
            }
            let edge = (y - middle[1]).abs() == ring;
            let step = if edge || ring == 0 { 1 } else { 2 * ring };
            let mut x = middle[0] - ring;
            while x <= middle[0] + ring {
                if in_grid(x, 0) {
                    self.cells[self.index([x as usize, y as usize])].iter().for_each(|&index| visit(index));
                }
                x += step;
            }
        }
    }

    /// The cell of a point, or of the place of the box nearest to it.
    fn cell_of(&self, p: GridPoint) -> [usize; 2] {
        let of = |v: i32, low: i32, size: usize| {
            (((f64::from(v) - f64::from(low)) / self.cell).max(0.0) as usize).min(size - 1)
        };
        [of(p.x, self.low.x, self.size[0]), of(p.y, self.low.y, self.size[1])]
    }

    fn index(&self, [x, y]: [usize; 2]) -> usize {
        y * self.size[0] + x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    #[test]
    fn the_nearest_is_what_asking_all_of_them_says() {
        let mut random = SplitMix64::seeded(7);
        for (wide, high, count) in [(1e6, 1e6, 300), (1e6, 0.0, 50), (300.0, 1e5, 200), (0.0, 0.0, 3)] {
            let mut any = |by: f64| ((random.unit() - 0.5) * by) as i32;
            let points: Vec<GridPoint> = (0..count).map(|_| GridPoint::new(any(wide), any(high))).collect();
            let asked: Vec<GridPoint> = (0..count).map(|_| GridPoint::new(any(3.0 * wide), any(3.0 * high))).collect();
            let mut nearest = Nearest::all(points.clone());
            let mut left: Vec<usize> = (0..count).collect();
            for at in asked {
                let away = |i: &usize| {
                    let (x, y) = (f64::from(points[*i].x - at.x), f64::from(points[*i].y - at.y));
                    x * x + y * y
                };
                let wanted = left.iter().copied().min_by(|a, b| away(a).total_cmp(&away(b)).then(a.cmp(b)));
                let found = nearest.to(at);
                assert_eq!(found, wanted, "{at:?}");
                left.retain(|i| Some(*i) != found);
                nearest.remove(found.unwrap());
            }
            assert_eq!(nearest.to(GridPoint::new(0, 0)), None);
        }
    }
}
