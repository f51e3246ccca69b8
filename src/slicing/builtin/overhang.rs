//! Which stretches of a path lie on the layer below.

use super::region::{GridPoint, Region, pairs};

/// A ring's points, the first one once more at the end.
fn closed(ring: &[GridPoint]) -> Vec<GridPoint> {
    ring.iter().chain(ring.first()).copied().collect()
}

/// A region prepared for many crossing tests.
pub(super) struct Ground {
    edges: Vec<(GridPoint, GridPoint)>,
}

impl Ground {
    pub(super) fn new(region: &Region) -> Self {
        Self { edges: region.iter().flatten().flat_map(|ring| pairs(ring)).collect() }
    }

    /// The path cut into stretches, in order, each with whether it lies inside.
    pub(super) fn split(&self, path: &[GridPoint]) -> Vec<(bool, Vec<GridPoint>)> {
        let mut stretches: Vec<(bool, Vec<GridPoint>)> = Vec::new();
        for leg in path.windows(2) {
            let stops = self.stops(leg[0], leg[1]);
            for pair in stops.windows(2) {
                let inside = self.holds((pair[0].0 + pair[1].0) / 2.0, leg[0], leg[1]);
                match stretches.last_mut() {
                    Some((last, points)) if *last == inside => points.push(pair[1].1),
                    _ => stretches.push((inside, vec![pair[0].1, pair[1].1])),
                }
            }
        }
        stretches
    }

    /// Whether anything of a closed path lies inside.
    pub(super) fn carries_any_of(&self, ring: &[GridPoint]) -> bool {
        self.split(&closed(ring)).iter().any(|(inside, _)| *inside)
    }

    /// Whether all of a closed path does.
    pub(super) fn carries_all_of(&self, ring: &[GridPoint]) -> bool {
        self.split(&closed(ring)).iter().all(|(inside, _)| *inside)
    }

    /// Where the leg meets the border, with both its ends: the share of its length, and the point.
    fn stops(&self, a: GridPoint, b: GridPoint) -> Vec<(f64, GridPoint)> {
        let [dx, dy] = [b.x - a.x, b.y - a.y].map(f64::from);
        let mut shares: Vec<f64> = self.edges.iter().filter_map(|&(p, q)| meets(a, [dx, dy], p, q)).collect();
        shares.sort_by(f64::total_cmp);
        let at = |t: f64| GridPoint::new(a.x + (t * dx).round() as i32, a.y + (t * dy).round() as i32);
        let mut stops = vec![(0.0, a)];
        stops.extend(shares.into_iter().map(|t| (t, at(t))));
        stops.push((1.0, b));
        stops.dedup_by(|next, last| next.1 == last.1);
        // The end must stay the end, even where the last crossing rounds onto it.
        if let Some(last) = stops.last_mut() {
            *last = (1.0, b);
        }
        stops
    }

    fn holds(&self, share: f64, a: GridPoint, b: GridPoint) -> bool {
        let x = f64::from(a.x) + share * f64::from(b.x - a.x);
        let y = f64::from(a.y) + share * f64::from(b.y - a.y);
        let right_of = |&&(p, q): &&(GridPoint, GridPoint)| {
            let (py, qy) = (f64::from(p.y), f64::from(q.y));
            (py <= y) != (qy <= y) && f64::from(p.x) + (y - py) / (qy - py) * f64::from(q.x - p.x) > x
        };
        self.edges.iter().filter(right_of).count() % 2 == 1
    }
}

fn meets(a: GridPoint, [dx, dy]: [f64; 2], p: GridPoint, q: GridPoint) -> Option<f64> {
    let [ex, ey, px, py] = [q.x - p.x, q.y - p.y, p.x - a.x, p.y - a.y].map(f64::from);
    let cross = dx * ey - dy * ex;
    let (t, u) = ((px * ey - py * ex) / cross, (px * dy - py * dx) / cross);
    (t > 0.0 && t < 1.0 && (0.0..=1.0).contains(&u)).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::super::region::enclosed;
    use super::*;

    #[test]
    fn a_line_through_a_square_is_cut_at_its_border() {
        let square = [(0, 0), (100, 0), (100, 100), (0, 100)].map(|(x, y)| GridPoint::new(x, y)).to_vec();
        let ground = Ground::new(&enclosed(&[square]));
        let got = ground.split(&[GridPoint::new(-50, 50), GridPoint::new(150, 50)]);
        let p = |x| GridPoint::new(x, 50);
        assert_eq!(got, [(false, vec![p(-50), p(0)]), (true, vec![p(0), p(100)]), (false, vec![p(100), p(150)])]);
    }
}
