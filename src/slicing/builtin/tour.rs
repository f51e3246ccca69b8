//! A short way through lines that may each be begun at either end: on to the nearest, then turned round piece by piece as long as that
//! is shorter (2-opt and Or-opt; S. Lin, *Computer solutions of the traveling salesman problem*, 1965; I. Or, 1976).

use super::nearest::Nearest;
use super::region::{GridPoint, distance_mm};

/// A line's two ends, grid units.
pub(super) type Ends = [GridPoint; 2];

/// So far apart two lines of the way may be to be exchanged, lines: all of them in most layers; the time grows with it.
const WINDOW: usize = 64;
/// So many lines are moved to another place together.
const MOVED: usize = 3;
/// A way is shorter from here on, mm: a grid unit of difference is rounding.
const SHORTER_MM: f64 = 0.01;
/// So often the whole way is gone through at most.
const ROUNDS: usize = 12;

/// The order of `lines` on the way from `from`, if that is known, to the nearest of `to`, or to anywhere where that is empty: of each
/// its place in `lines` and the end where it begins.
pub(super) fn tour(from: Option<GridPoint>, lines: &[Ends], to: &[GridPoint]) -> Vec<(usize, usize)> {
    let mut way = Way { from, to, lines, order: greedy(from.unwrap_or_default(), lines) };
    for _ in 0..ROUNDS {
        if !(way.turned_round() | way.moved()) {
            break;
        }
    }
    way.order.into_iter().map(|end| (end / 2, end % 2)).collect()
}

/// Always on to the nearest end.
fn greedy(from: GridPoint, lines: &[Ends]) -> Vec<usize> {
    let mut nearest = Nearest::all(lines.iter().flatten().copied().collect());
    let (mut at, mut order) = (from, Vec::with_capacity(lines.len()));
    while let Some(end) = nearest.to(at) {
        nearest.remove(end);
        nearest.remove(end ^ 1);
        at = lines[end / 2][(end ^ 1) % 2];
        order.push(end);
    }
    order
}

/// A way through all lines: the number of the end where each begins, two to a line.
struct Way<'a> {
    from: Option<GridPoint>,
    to: &'a [GridPoint],
    lines: &'a [Ends],
    order: Vec<usize>,
}

/// What follows on a line of the way.
#[derive(Clone, Copy)]
enum Next {
    Line(GridPoint),
    End,
}

impl Way<'_> {
    fn point(&self, end: usize) -> GridPoint {
        self.lines[end / 2][end % 2]
    }

    /// Where the way is before the line at this place begins.
    fn before(&self, place: usize) -> Option<GridPoint> {
        place.checked_sub(1).map_or(self.from, |p| Some(self.point(self.order[p] ^ 1)))
    }

    /// Where the way goes when the line before this place has ended.
    fn next(&self, place: usize) -> Next {
        self.order.get(place).map_or(Next::End, |&end| Next::Line(self.point(end)))
    }

    /// From a place that may not be known, mm.
    fn leg(&self, from: Option<GridPoint>, to: Next) -> f64 {
        let Some(from) = from else { return 0.0 };
        match to {
            Next::Line(to) => distance_mm(from, to),
            Next::End if self.to.is_empty() => 0.0,
            Next::End => self.to.iter().map(|&to| distance_mm(from, to)).fold(f64::INFINITY, f64::min),
        }
    }

    /// Turns stretches of the way round; whether that has made it shorter.
    fn turned_round(&mut self) -> bool {
        let mut shorter = false;
        for first in 0..self.order.len() {
            for last in first..self.order.len().min(first + WINDOW) {
                let (before, after) = (self.before(first), self.next(last + 1));
                let (begin, end) = (self.point(self.order[first]), self.point(self.order[last] ^ 1));
                let is = self.leg(before, Next::Line(begin)) + self.leg(Some(end), after);
                if self.leg(before, Next::Line(end)) + self.leg(Some(begin), after) < is - SHORTER_MM {
                    turn(&mut self.order[first..=last]);
                    shorter = true;
                }
            }
        }
        shorter
    }

    /// Moves a few lines to another place of the way; whether that has made it shorter.
    fn moved(&mut self) -> bool {
        let mut shorter = false;
        for first in 0..self.order.len() {
            for count in 1..=MOVED.min(self.order.len() - first) {
                shorter |= self.moves(first, count);
            }
        }
        shorter
    }

    fn moves(&mut self, first: usize, count: usize) -> bool {
        let last = first + count - 1;
        let (begin, end) = (self.point(self.order[first]), self.point(self.order[last] ^ 1));
        let between = |before: Option<GridPoint>, [begin, end]: Ends, after: Next| {
            self.leg(before, Next::Line(begin)) + self.leg(Some(end), after) - self.leg(before, after)
        };
        let saved = between(self.before(first), [begin, end], self.next(last + 1));
        if saved <= SHORTER_MM {
            return false;
        }
        // Between the line at `gap - 1` and the one at `gap`.
        let low = first.saturating_sub(WINDOW);
        let high = (last + 1 + WINDOW).min(self.order.len());
        let costs =
            |gap: usize| [[begin, end], [end, begin]].map(|ends| between(self.before(gap), ends, self.next(gap)));
        let gaps = (low..first).chain(last + 2..=high);
        let best = gaps.flat_map(|gap| [0, 1].map(|turned| (costs(gap)[turned], gap, turned)));
        let Some((cost, gap, turned)) = best.min_by(|a, b| a.0.total_cmp(&b.0)) else { return false };
        if cost >= saved - SHORTER_MM {
            return false;
        }
        if turned == 1 {
            turn(&mut self.order[first..=last]);
        }
        if gap < first {
            self.order[gap..=last].rotate_right(count);
        } else {
            self.order[first..gap].rotate_left(count);
        }
        true
    }
}

fn turn(order: &mut [usize]) {
    order.reverse();
    order.iter_mut().for_each(|end| *end ^= 1);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    fn length(from: Option<GridPoint>, lines: &[Ends], to: &[GridPoint], order: &[(usize, usize)]) -> f64 {
        let (mut at, mut sum) = (from, 0.0);
        for &(line, end) in order {
            sum += at.map_or(0.0, |at| distance_mm(at, lines[line][end]));
            at = Some(lines[line][1 - end]);
        }
        sum + at.map_or(0.0, |at| nearest(at, to))
    }

    fn nearest(at: GridPoint, of: &[GridPoint]) -> f64 {
        of.iter().map(|&to| distance_mm(at, to)).min_by(f64::total_cmp).unwrap_or(0.0)
    }

    /// The shortest of all orders, by trying them.
    fn shortest(from: Option<GridPoint>, lines: &[Ends], to: &[GridPoint]) -> f64 {
        fn on(at: Option<GridPoint>, left: &[Ends], to: &[GridPoint]) -> f64 {
            if left.is_empty() {
                return at.map_or(0.0, |at| nearest(at, to));
            }
            let each = (0..2 * left.len()).map(|end| {
                let mut rest = left.to_vec();
                let line = rest.remove(end / 2);
                at.map_or(0.0, |at| distance_mm(at, line[end % 2])) + on(Some(line[1 - end % 2]), &rest, to)
            });
            each.fold(f64::INFINITY, f64::min)
        }
        on(from, lines, to)
    }

    #[test]
    fn every_line_is_there_once_and_the_way_is_short() {
        let mut random = SplitMix64::seeded(12);
        let mut point = |by: f64| GridPoint::new((random.unit() * by) as i32, (random.unit() * by) as i32);
        let (mut best, mut ours, mut by_nearest) = (0.0, 0.0, 0.0);
        for case in 0..60 {
            let lines: Vec<Ends> = (0..1 + case % 6).map(|_| [point(4e5), point(4e5)]).collect();
            let from = (case % 3 > 0).then(|| point(4e5));
            let to: Vec<GridPoint> = (0..case % 4).map(|_| point(4e5)).collect();
            let order = tour(from, &lines, &to);
            let mut once: Vec<usize> = order.iter().map(|(line, _)| *line).collect();
            once.sort_unstable();
            assert_eq!(once, (0..lines.len()).collect::<Vec<_>>());
            let first: Vec<(usize, usize)> =
                greedy(from.unwrap_or_default(), &lines).into_iter().map(|end| (end / 2, end % 2)).collect();
            let [is, was] = [&order, &first].map(|order| length(from, &lines, &to, order));
            let least = shortest(from, &lines, &to);
            assert!(is <= was + 1e-9 && is >= least - 1e-9, "{least} <= {is} <= {was}");
            (best, ours, by_nearest) = (best + least, ours + is, by_nearest + was);
        }
        assert!(ours < 1.03 * best && by_nearest > 1.1 * best, "{best} {ours} {by_nearest}");
        assert!(tour(None, &[], &[]).is_empty());
    }

    #[test]
    fn many_lines_are_put_in_order_within_their_window() {
        let mut random = SplitMix64::seeded(3);
        let mut lines = Vec::new();
        for _ in 0..2000 {
            let p = GridPoint::new((random.unit() * 4e6) as i32, (random.unit() * 4e6) as i32);
            lines.push([p, GridPoint::new(p.x + (random.unit() * 4e4) as i32, p.y)]);
        }
        let order = tour(None, &lines, &[]);
        let first: Vec<(usize, usize)> =
            greedy(GridPoint::default(), &lines).into_iter().map(|end| (end / 2, end % 2)).collect();
        let [is, was] = [&order, &first].map(|order| length(None, &lines, &[], order));
        assert!(is < 0.93 * was, "{is} {was}");
    }
}
