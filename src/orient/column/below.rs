//! What may lie below a triangle, straight down along any direction of a cap: the facets that face up, in a grid across it.

use super::super::Facets;
use super::super::bound::Cap;
use super::super::sphere::tangents;
use crate::geom::Vec3;

/// A facet that faces up somewhere on the cap.
struct Up {
    /// Across and along the cap's centre.
    corners: [Vec3; 3],
    low: Vec3,
    high: Vec3,
    /// Its plane, in the part's frame: `n.q - offset` is how far `q` lies before it.
    normal: Vec3,
    offset: f64,
    /// The largest `n.d` on the cap.
    most: f64,
}

/// What a triangle stands above.
pub(super) enum Above {
    /// The bed, along every direction.
    Bed,
    /// One plane, or nothing nearer than the bed: at its corners, what the mean gap is at least the mean of, mm.
    Plane([f64; 3]),
    /// The same where one thing is nearest at one corner and another elsewhere: smaller triangles would leave more.
    Step([f64; 3]),
}

/// The facets of a part that face up somewhere on a cap.
pub(super) struct Below {
    ups: Vec<Up>,
    axes: [Vec3; 3],
    sine: f64,
    tangent: f64,
    grid: Grid,
    /// For each facet the triangle that last looked at it.
    seen: Vec<u32>,
    asked: u32,
}

/// Cells of a grid with the facets whose boxes meet them.
struct Grid {
    cell: f64,
    origin: [f64; 2],
    count: [usize; 2],
    /// Where each cell's facets begin in the list, and the list.
    from: Vec<u32>,
    facets: Vec<u32>,
}

/// Cells along the longer side at most.
const CELLS: f64 = 96.0;

impl Below {
    pub(super) fn of(facets: &Facets, cap: &Cap) -> Self {
        let [e1, e2] = tangents(&cap.centre);
        let axes = [e1, e2, cap.centre];
        let flat: Vec<Vec3> = facets.points.iter().map(|p| Vec3::from_fn(|k, _| axes[k].dot(p))).collect();
        let mut ups = Vec::new();
        for (facet, corners) in facets.each.iter().zip(&facets.corners) {
            let normal = facet.area / facet.area.norm();
            let most = cap.range(&normal)[1];
            if most >= -1e-9 {
                let offset = normal.dot(&facets.points[corners[0] as usize]);
                let corners @ [a, b, c] = corners.map(|i| flat[i as usize]);
                let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
                ups.push(Up { corners, low, high, normal, offset, most: most.max(1e-9) });
            }
        }
        let (grid, seen) = (Grid::of(&ups), vec![0; ups.len()]);
        Self { ups, axes, sine: cap.sine(), tangent: cap.radius.tan(), grid, seen, asked: 0 }
    }

    /// The least of `gaps` and what facets leave, at the corners of a triangle (in the part's frame); what ends no gap before
    /// `until` is not looked for.
    pub(super) fn gaps(&mut self, corners: &[Vec3; 3], mut gaps: [f64; 3], until: f64) -> Above {
        self.asked += 1;
        let flat = corners.map(|q| Vec3::from_fn(|k, _| self.axes[k].dot(&q)));
        let (low, high) = (flat[0].inf(&flat[1]).inf(&flat[2]), flat[0].sup(&flat[1]).sup(&flat[2]));
        let (mut is_free, mut ring, mut nearest) = (true, 0, [BED; 3]);
        loop {
            let aside = (ring as f64 - 1.0).max(0.0) * self.grid.cell;
            let wanted = if is_free { until } else { gaps.iter().copied().fold(0.0, f64::max) };
            if aside > until * self.sine || aside >= wanted * self.sine && ring > 0 {
                break;
            }
            let Some(cells) = self.grid.ring(&low, &high, ring) else { break };
            for cell in cells {
                for at in self.grid.from[cell]..self.grid.from[cell + 1] {
                    let index = self.grid.facets[at as usize] as usize;
                    if std::mem::replace(&mut self.seen[index], self.asked) == self.asked {
                        continue;
                    }
                    if let Some(left) = self.left(&self.ups[index], corners, &flat, &low, &high, until) {
                        is_free = false;
                        for k in 0..3 {
                            if left.at[k] < gaps[k] {
                                (gaps[k], nearest[k]) = (left.at[k], if left.is_plane { index } else { LEVEL + k });
                            }
                        }
                    }
                }
            }
            if !is_free && gaps.iter().sum::<f64>() <= 0.0 {
                break;
            }
            ring += 1;
        }
        match nearest {
            _ if is_free => Above::Bed,
            [a, b, c] if a == b && b == c && gaps.iter().all(|gap| *gap >= 0.0) => Above::Plane(gaps),
            _ => Above::Step(gaps),
        }
    }

    /// What a facet leaves at the corners; none where it ends no gap before `until`.
    fn left(&self, up: &Up, q: &[Vec3; 3], flat: &[Vec3; 3], low: &Vec3, high: &Vec3, until: f64) -> Option<Left> {
        if up.low.z > high.z {
            return None;
        }
        let tiny = 1e-9 * (high.z.abs() + up.offset.abs());
        let before = q.map(|q| up.normal.dot(&q) - up.offset);
        let nearest = before.iter().copied().fold(f64::INFINITY, f64::min);
        // All behind its plane: a line down from there meets it nowhere.
        if before.iter().all(|b| *b <= tiny) && nearest < -10.0 * tiny {
            return None;
        }
        let aside = aside([low, high], [&up.low, &up.high]);
        let reach = (high.z - up.low.z) * self.tangent;
        if aside > reach {
            return None;
        }
        let apart = if aside < reach { apart(flat, &up.corners).max(aside) } else { aside };
        if apart > reach {
            return None;
        }
        let level = (low.z - up.high.z).max(apart / self.sine).max(0.0);
        let planes = before.map(|b| b / up.most);
        let sloped = planes.iter().sum::<f64>() > 3.0 * level;
        if level.max(nearest / up.most) >= until {
            return None;
        }
        Some(if sloped { Left { at: planes, is_plane: true } } else { Left { at: [level; 3], is_plane: false } })
    }
}

/// What a facet leaves of the gaps at three corners: up to its plane, or up to where it can be met first.
struct Left {
    at: [f64; 3],
    is_plane: bool,
}

/// In the place of a facet's number: the bed, and what is no plane.
const BED: usize = usize::MAX;
const LEVEL: usize = usize::MAX - 4;

/// How far two boxes lie aside of each other, seen along the centre.
fn aside([a0, a1]: [&Vec3; 2], [b0, b1]: [&Vec3; 2]) -> f64 {
    let [x, y] = [0, 1].map(|k| (a0[k] - b1[k]).max(b0[k] - a1[k]).max(0.0));
    (x * x + y * y).sqrt()
}

/// Two triangles lie at least this far apart, seen along the centre: the widest of the gaps across their edges.
fn apart(a: &[Vec3; 3], b: &[Vec3; 3]) -> f64 {
    let across = |t: &[Vec3; 3], other: &[Vec3; 3]| {
        (0..3).fold(0.0, |widest: f64, i| {
            let (p, q, r) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
            let side = |v: &Vec3| (q.x - p.x) * (v.y - p.y) - (q.y - p.y) * (v.x - p.x);
            let inner = side(&r).signum();
            let length = ((q.x - p.x).powi(2) + (q.y - p.y).powi(2)).sqrt();
            // The third corner lies on the other side, or the triangle is seen edge on.
            let nearest = other.iter().map(|v| -inner * side(v)).fold(f64::INFINITY, f64::min);
            if length > 0.0 { widest.max(nearest / length) } else { widest }
        })
    };
    across(a, b).max(across(b, a)) * (1.0 - 1e-9)
}

impl Grid {
    fn of(ups: &[Up]) -> Self {
        let low = ups.iter().fold(Vec3::repeat(f64::INFINITY), |l, up| l.inf(&up.low));
        let high = ups.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |h, up| h.sup(&up.high));
        let longer = (high.x - low.x).max(high.y - low.y).max(0.0);
        let cell = (longer / CELLS.min((ups.len() as f64).sqrt()).max(1.0)).max(1e-12);
        let count = [0, 1].map(|k| ((high[k] - low[k]) / cell).floor().max(0.0) as usize + 1);
        let mut grid = Self { cell, origin: [low.x, low.y], count, from: vec![], facets: vec![] };
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); count[0] * count[1]];
        for (i, up) in ups.iter().enumerate() {
            let [x, y] = grid.cells(&up.low, &up.high);
            for j in y[0]..=y[1] {
                (x[0]..=x[1]).for_each(|k| lists[j as usize * count[0] + k as usize].push(i as u32));
            }
        }
        grid.from.push(0);
        for list in lists {
            grid.facets.extend(list);
            grid.from.push(grid.facets.len() as u32);
        }
        grid
    }

    /// The first and last cell of a box along each side, which may lie outside.
    fn at(&self, low: &Vec3, high: &Vec3) -> [[i64; 2]; 2] {
        [0, 1].map(|k| [low[k], high[k]].map(|v| ((v - self.origin[k]) / self.cell).floor() as i64))
    }

    /// The same within the grid.
    fn cells(&self, low: &Vec3, high: &Vec3) -> [[i64; 2]; 2] {
        let [x, y] = self.at(low, high);
        let inside = |k: usize, v: i64| v.clamp(0, self.count[k] as i64 - 1);
        [x.map(|v| inside(0, v)), y.map(|v| inside(1, v))]
    }

    /// The cells so many cells around a box; those that it meets for 0. None where all lie outside.
    fn ring(&self, low: &Vec3, high: &Vec3, ring: i64) -> Option<Vec<usize>> {
        let [[x0, x1], [y0, y1]] = self.at(low, high);
        let (x0, x1, y0, y1) = (x0 - ring, x1 + ring, y0 - ring, y1 + ring);
        let [columns, rows] = self.count.map(|n| n as i64);
        if ring > 0 && x0 < 0 && y0 < 0 && x1 >= columns && y1 >= rows {
            return None;
        }
        let mut cells = Vec::new();
        for j in y0.max(0)..=y1.min(rows - 1) {
            let is_side = ring == 0 || j == y0 || j == y1;
            if is_side {
                cells.extend((x0.max(0)..=x1.min(columns - 1)).map(|i| (j * columns + i) as usize));
            } else {
                let ends = [x0, x1].into_iter().filter(|i| (0..columns).contains(i));
                cells.extend(ends.map(|i| (j * columns + i) as usize));
            }
        }
        Some(cells)
    }
}
