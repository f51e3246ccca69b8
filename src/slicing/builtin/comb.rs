//! Ways inside an island: straight where nothing is between, else along the outer walls' middles, pulled tight.
//!
//! A search over all corners would find the shortest way; along the walls one is found in as many steps as they have corners, and pulling
//! it tight leaves little of the difference. What leaves the island, or comes near its border, is no way.

use super::region::{self, Contour, GridPoint, Region, Shape, UNITS_PER_MM, pairs};
use crate::section::simplify::simplified;

/// How near to the border the tip's middle may go, grid units: 0.08 mm, less than half of the narrowest bead.
const CLEAR: f64 = 0.08 * UNITS_PER_MM;
/// How far the contours that are looked at may lie off the true ones, grid units: 0.02 mm.
const COARSE: f64 = 0.02 * UNITS_PER_MM;
/// Cells across the longer side of the island's box, at most.
const CELLS: usize = 64;
/// Cells are no smaller, grid units: 0.5 mm.
const SMALLEST: f64 = 0.5 * UNITS_PER_MM;
/// The most corners that a way may follow before it is pulled tight: a bound for contours of many thousand points.
const MOST_CORNERS: usize = 2_000;

/// A wall's middle is looked for no farther off, grid units: 10 mm.
const FAR: f64 = 10.0 * UNITS_PER_MM;

/// The middle of an outer wall, and the box around it.
struct Wall {
    ring: Contour,
    least: [f64; 2],
    most: [f64; 2],
}

impl Wall {
    fn new(ring: Contour) -> Self {
        let (mut least, mut most) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in &ring {
            for (i, v) in [f64::from(p.x), f64::from(p.y)].into_iter().enumerate() {
                (least[i], most[i]) = (least[i].min(v), most[i].max(v));
            }
        }
        Self { ring, least, most }
    }

    /// Whether the boxes of the wall and of a leg come within `by` of each other.
    fn is_near(&self, a: GridPoint, b: GridPoint, by: f64) -> bool {
        let (a, b) = ([a.x, a.y].map(f64::from), [b.x, b.y].map(f64::from));
        (0..2).all(|i| a[i].min(b[i]) - by <= self.most[i] && a[i].max(b[i]) + by >= self.least[i])
    }
}

/// An island, prepared for many ways.
pub(super) struct Comb {
    sides: Vec<(GridPoint, GridPoint)>,
    cells: Vec<Vec<u32>>,
    low: GridPoint,
    cell: f64,
    size: [usize; 2],
    walls: Vec<Wall>,
}

impl Comb {
    /// `walls` are the middles of the island's outer walls.
    pub(super) fn new(island: &Shape, walls: &Region) -> Self {
        let rings: Vec<Contour> = island.iter().map(|ring| simplified(ring, COARSE)).collect();
        let sides: Vec<(GridPoint, GridPoint)> = rings.iter().flat_map(|ring| pairs(ring)).collect();
        let points = || rings.iter().flatten();
        let low = GridPoint::new(points().map(|p| p.x).min().unwrap_or(0), points().map(|p| p.y).min().unwrap_or(0));
        let across = points().fold([0.0f64; 2], |[x, y], p| {
            [x.max(f64::from(p.x) - f64::from(low.x)), y.max(f64::from(p.y) - f64::from(low.y))]
        });
        let cell = (across[0].max(across[1]) / CELLS as f64).max(SMALLEST);
        let size = across.map(|v| (v / cell) as usize + 1);
        let walls = walls.iter().flatten().map(|ring| Wall::new(simplified(ring, COARSE))).collect();
        let mut comb = Self { sides, cells: vec![Vec::new(); size[0] * size[1]], low, cell, size, walls };
        for index in 0..comb.sides.len() {
            let mut cells = Vec::new();
            let (a, b) = comb.sides[index];
            comb.each_cell(a, b, 0.0, |cell| cells.push(cell));
            cells.into_iter().for_each(|cell| comb.cells[cell].push(index as u32));
        }
        comb
    }

    /// The corners of a way inside the island, none where the straight one is; `None` where there is no way.
    pub(super) fn way(&self, from: GridPoint, to: GridPoint) -> Option<Vec<GridPoint>> {
        if self.is_clear(from, to) {
            return Some(Vec::new());
        }
        let straight = self.along_walls(from, to).and_then(|corners| self.pulled_tight(&corners));
        // Where a place lies in a piece too narrow for the walls' middles, the straight line may miss them.
        let tight = match straight {
            Some(tight) => tight,
            None => self.pulled_tight(&self.by_nearest_wall(from, to)?)?,
        };
        Some(tight[1..tight.len() - 1].to_vec())
    }

    /// To the nearest place of the walls, along them, and from the place of the same wall that is nearest to `to`.
    fn by_nearest_wall(&self, from: GridPoint, to: GridPoint) -> Option<Vec<GridPoint>> {
        let near = |p: GridPoint| {
            let walls = self.walls.iter().enumerate().filter(|(_, wall)| wall.is_near(p, p, FAR));
            let places = walls.filter_map(|(index, wall)| Some((index, foot(&wall.ring, p)?)));
            places.min_by(|a, b| a.1.share.total_cmp(&b.1.share))
        };
        let ((wall, first), (other, last)) = (near(from)?, near(to)?);
        let ring = &self.walls[wall].ring;
        if wall != other || ring.len() > MOST_CORNERS {
            return None;
        }
        let mut way = vec![from, first.at];
        way.extend(around(ring, &first, &last));
        way.extend([last.at, to]);
        Some(way)
    }

    /// Whether no side comes near the leg.
    fn is_clear(&self, a: GridPoint, b: GridPoint) -> bool {
        let mut clear = true;
        self.each_cell(a, b, CLEAR, |cell| {
            clear = clear
                && self.cells[cell].iter().map(|&side| self.sides[side as usize]).all(|(p, q)| is_far(a, b, p, q));
        });
        clear
    }

    /// From `from` straight towards `to`; where walls are in the way along each of them the shorter way round.
    fn along_walls(&self, from: GridPoint, to: GridPoint) -> Option<Vec<GridPoint>> {
        let mut way = vec![from];
        let mut left: Vec<&Wall> = self.walls.iter().filter(|wall| wall.is_near(from, to, BESIDE)).collect();
        let mut at = from;
        loop {
            let met = left.iter().enumerate().filter_map(|(place, wall)| Some((place, crossed(&wall.ring, at, to)?)));
            let Some((place, [first, last])) = met.min_by(|a, b| a.1[0].share.total_cmp(&b.1[0].share)) else { break };
            let ring = &left.remove(place).ring;
            way.push(first.at);
            way.extend(around(ring, &first, &last));
            way.push(last.at);
            at = last.at;
            if way.len() > MOST_CORNERS {
                return None;
            }
        }
        way.push(to);
        Some(way)
    }

    /// The way without the corners that it can do without; `None` where it is not clear anyhow.
    fn pulled_tight(&self, way: &[GridPoint]) -> Option<Vec<GridPoint>> {
        let mut tight = vec![way[0]];
        let mut at = 0;
        while at + 1 < way.len() {
            at = self.farthest_seen(way, at)?;
            tight.push(way[at]);
        }
        // From the other end corners may be seen that were not.
        let mut place = 1;
        while place + 1 < tight.len() {
            if self.is_clear(tight[place - 1], tight[place + 1]) {
                tight.remove(place);
                place = place.saturating_sub(1).max(1);
            } else {
                place += 1;
            }
        }
        Some(tight)
    }

    /// A late point of the way that is seen from one of its points.
    fn farthest_seen(&self, way: &[GridPoint], at: usize) -> Option<usize> {
        let mut ahead = way.len() - 1 - at;
        while ahead > 1 && !self.is_clear(way[at], way[at + ahead]) {
            ahead /= 2;
        }
        if ahead == 1 && !self.is_clear(way[at], way[at + 1]) {
            return None;
        }
        let mut seen = at + ahead;
        while seen + 1 < way.len() && self.is_clear(way[at], way[seen + 1]) {
            seen += 1;
        }
        Some(seen)
    }

    /// Visits the cells within `reach` of a leg, and a few more.
    fn each_cell(&self, a: GridPoint, b: GridPoint, reach: f64, mut visit: impl FnMut(usize)) {
        let place = |p: GridPoint| [f64::from(p.x) - f64::from(self.low.x), f64::from(p.y) - f64::from(self.low.y)];
        let (a, b) = (place(a), place(b));
        let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        let index = |v: f64, i: usize| ((v / self.cell).max(0.0) as usize).min(self.size[i] - 1);
        for row in index(a[1] - reach, 1)..=index(b[1] + reach, 1) {
            // The part of the leg beside this row of cells; rows at the rim stand for all beyond.
            let low = if row == 0 { f64::NEG_INFINITY } else { row as f64 * self.cell - reach };
            let high = if row + 1 == self.size[1] { f64::INFINITY } else { (row + 1) as f64 * self.cell + reach };
            let at = |y: f64| match b[1] - a[1] {
                rise if rise > 0.0 => a[0] + (b[0] - a[0]) * ((y.clamp(a[1], b[1]) - a[1]) / rise),
                _ => a[0],
            };
            let (mut from, mut to) = (at(low), at(high));
            if b[1] <= a[1] {
                to = b[0];
            }
            if from > to {
                std::mem::swap(&mut from, &mut to);
            }
            for column in index(from - reach, 0)..=index(to + reach, 0) {
                visit(row * self.size[0] + column);
            }
        }
    }
}

/// The place of a ring nearest to a point; its share is the distance.
fn foot(ring: &[GridPoint], p: GridPoint) -> Option<Crossing> {
    let mut along = 0.0;
    let mut best: Option<Crossing> = None;
    for (side, (a, b)) in pairs(ring).enumerate() {
        let ([ex, ey], [x, y]) = (difference(a, b), difference(a, p));
        let length = region::length([ex, ey]);
        let of_side = if length > 0.0 { ((x * ex + y * ey) / length / length).clamp(0.0, 1.0) } else { 0.0 };
        let away = region::length([x - of_side * ex, y - of_side * ey]);
        if best.is_none_or(|known| away < known.share) {
            let at = GridPoint::new(a.x + (of_side * ex).round() as i32, a.y + (of_side * ey).round() as i32);
            best = Some(Crossing { at, side, share: away, along: along + of_side * length });
        }
        along += length;
    }
    best
}

/// Where a leg meets a ring.
#[derive(Clone, Copy)]
struct Crossing {
    at: GridPoint,
    side: usize,
    /// Of the leg.
    share: f64,
    /// Along the ring.
    along: f64,
}

/// The first and the last place at which a leg crosses a ring; `None` where it does not. An end of the leg that lies between the ring and
/// the border next to it counts as lying on the ring.
fn crossed(ring: &[GridPoint], a: GridPoint, b: GridPoint) -> Option<[Crossing; 2]> {
    let [dx, dy] = difference(a, b);
    let mut along = 0.0;
    let mut found: Option<[Crossing; 2]> = None;
    let mut count = 0;
    for (side, (p, q)) in pairs(ring).enumerate() {
        let ([ex, ey], [px, py]) = (difference(p, q), difference(a, p));
        let cross = dx * ey - dy * ex;
        let (share, of_side) = ((px * ey - py * ex) / cross, (px * dy - py * dx) / cross);
        let length = region::length([ex, ey]);
        // What begins on the ring does not cross it there.
        if share > 1e-6 && share < 1.0 - 1e-6 && (0.0..1.0).contains(&of_side) {
            let at = GridPoint::new(p.x + (of_side * ex).round() as i32, p.y + (of_side * ey).round() as i32);
            let here = Crossing { at, side, share, along: along + of_side * length };
            let [first, last] = found.unwrap_or([here; 2]);
            let earlier = if here.share < first.share { here } else { first };
            found = Some([earlier, if here.share > last.share { here } else { last }]);
            count += 1;
        }
        along += length;
    }
    match found {
        Some([only, _]) if count == 1 => {
            let beside = |p: GridPoint, share: f64| {
                foot(ring, p).filter(|at| at.share < BESIDE).map(|at| Crossing { share, ..at })
            };
            let first = beside(a, 0.0).map(|first| [first, only]);
            first.or_else(|| beside(b, 1.0).map(|last| [only, last]))
        }
        _ => found,
    }
}

/// So near to a ring lies what is between it and the border, grid units: 0.3 mm.
const BESIDE: f64 = 0.3 * UNITS_PER_MM;

/// The ring's corners between two places on it, the shorter way round.
fn around(ring: &[GridPoint], from: &Crossing, to: &Crossing) -> Vec<GridPoint> {
    let count = ring.len();
    let whole: f64 = pairs(ring).map(|(p, q)| region::length(difference(p, q))).sum();
    let ahead = (to.along - from.along).rem_euclid(whole);
    if from.side == to.side && ahead.min(whole - ahead) <= (to.along - from.along).abs() {
        return Vec::new();
    }
    if ahead <= whole / 2.0 {
        let steps = (to.side + count - from.side) % count;
        (1..=steps).map(|k| ring[(from.side + k) % count]).collect()
    } else {
        let steps = (from.side + count - to.side) % count;
        (0..steps).map(|k| ring[(from.side + count - k) % count]).collect()
    }
}

/// Whether two legs are farther apart than [`CLEAR`].
fn is_far(a: GridPoint, b: GridPoint, p: GridPoint, q: GridPoint) -> bool {
    let apart = |v: [i32; 2], w: [i32; 2]| {
        f64::from(v[0].min(v[1])) - f64::from(w[0].max(w[1])) > CLEAR
            || f64::from(w[0].min(w[1])) - f64::from(v[0].max(v[1])) > CLEAR
    };
    if apart([a.x, b.x], [p.x, q.x]) || apart([a.y, b.y], [p.y, q.y]) {
        return true;
    }
    let away = |p: GridPoint, a: GridPoint, b: GridPoint| {
        let ([dx, dy], [x, y]) = (difference(a, b), difference(a, p));
        let squared = dx * dx + dy * dy;
        let t = if squared > 0.0 { ((x * dx + y * dy) / squared).clamp(0.0, 1.0) } else { 0.0 };
        region::length([x - t * dx, y - t * dy])
    };
    if away(a, p, q) <= CLEAR || away(b, p, q) <= CLEAR || away(p, a, b) <= CLEAR || away(q, a, b) <= CLEAR {
        return false;
    }
    let side = |p: GridPoint, a: GridPoint, b: GridPoint| {
        let ([dx, dy], [x, y]) = (difference(a, b), difference(a, p));
        dx * y - dy * x > 0.0
    };
    side(a, p, q) == side(b, p, q) || side(p, a, b) == side(q, a, b)
}

fn difference(a: GridPoint, b: GridPoint) -> [f64; 2] {
    [f64::from(b.x) - f64::from(a.x), f64::from(b.y) - f64::from(a.y)]
}

#[cfg(test)]
mod tests {
    use super::super::region::{enclosed, grown, holds};
    use super::*;

    fn ring(points: &[(f64, f64)]) -> Contour {
        let of = |v: f64| (v * UNITS_PER_MM).round() as i32;
        points.iter().map(|&(x, y)| GridPoint::new(of(x), of(y))).collect()
    }

    fn at(x: f64, y: f64) -> GridPoint {
        ring(&[(x, y)])[0]
    }

    fn comb(island: &Region) -> Comb {
        Comb::new(&island[0], &grown(island, -2250))
    }

    fn length_mm(way: &[GridPoint]) -> f64 {
        way.windows(2).map(|leg| region::length(difference(leg[0], leg[1]))).sum::<f64>() / UNITS_PER_MM
    }

    #[test]
    fn the_way_round_a_notch_is_the_shortest() {
        let u = [
            (0.0, 0.0),
            (30.0, 0.0),
            (30.0, 20.0),
            (20.0, 20.0),
            (20.0, 10.0),
            (10.0, 10.0),
            (10.0, 20.0),
            (0.0, 20.0),
        ];
        let island = enclosed(&[ring(&u)]);
        let comb = comb(&island);
        assert_eq!(comb.way(at(5.0, 5.0), at(25.0, 5.0)), Some(Vec::new()));
        let (from, to) = (at(5.0, 19.0), at(25.0, 19.0));
        let way = comb.way(from, to).unwrap();
        assert_eq!(way.len(), 2, "{way:?}");
        let whole: Vec<GridPoint> = [from].into_iter().chain(way).chain([to]).collect();
        // Twice from (5, 19) to the corner of the middles at (10 - 0.225, 10 - 0.225), and 10.45 mm along.
        let wanted = 2.0 * 4.775f64.hypot(9.225) + 10.45;
        assert!((length_mm(&whole) - wanted).abs() < 0.1, "{} {wanted}", length_mm(&whole));
        assert_eq!(comb.way(at(5.0, 5.0), at(15.0, 15.0)), None, "the notch is not the island's");
    }

    #[test]
    fn from_a_piece_too_narrow_for_a_whole_line_there_is_a_way() {
        // Two fins of 0.4 mm on a bar.
        let fins = [
            (0.0, 0.0),
            (20.0, 0.0),
            (20.0, 4.0),
            (15.4, 4.0),
            (15.4, 12.0),
            (15.0, 12.0),
            (15.0, 4.0),
            (5.4, 4.0),
            (5.4, 12.0),
            (5.0, 12.0),
            (5.0, 4.0),
            (0.0, 4.0),
        ];
        let island = enclosed(&[ring(&fins)]);
        let way = comb(&island).way(at(5.2, 11.0), at(15.2, 11.0)).unwrap();
        assert!(way.len() >= 2 && way.iter().all(|&p| holds(&island, p)), "{way:?}");
    }

    #[test]
    fn the_way_round_a_hole_stays_inside() {
        let outer: Vec<(f64, f64)> = vec![(0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (0.0, 40.0)];
        let hole: Vec<(f64, f64)> = (0..60)
            .map(|k| (-f64::from(k) * 0.1047).sin_cos())
            .map(|(s, c)| (20.0 + 8.0 * c, 20.0 + 8.0 * s))
            .collect();
        let island = enclosed(&[ring(&outer), ring(&hole)]);
        let comb = comb(&island);
        let mut random = crate::geom::SplitMix64::seeded(3);
        let mut bent = 0;
        for _ in 0..300 {
            let mut any = || at(0.5 + 39.0 * random.unit(), 0.5 + 39.0 * random.unit());
            let (from, to) = (any(), any());
            if !holds(&grown(&island, -1500), from) || !holds(&grown(&island, -1500), to) {
                continue;
            }
            let way = comb.way(from, to).unwrap();
            bent += usize::from(!way.is_empty());
            let whole: Vec<GridPoint> = [from].into_iter().chain(way).chain([to]).collect();
            for leg in whole.windows(2) {
                for k in 0..=50 {
                    let share = f64::from(k) / 50.0;
                    let [dx, dy] = difference(leg[0], leg[1]);
                    let p = GridPoint::new(leg[0].x + (share * dx) as i32, leg[0].y + (share * dy) as i32);
                    assert!(holds(&island, p), "{leg:?}");
                }
            }
            // Round a circle the tight way is at most a half turn longer than straight.
            assert!(length_mm(&whole) < length_mm(&[from, to]) + 8.3 * 1.15, "{whole:?}");
        }
        assert!(bent > 50, "{bent}");
    }
}
