//! What lies on sparse rows goes out to the next one on either side: a line across them that ends between two hangs.

use std::collections::BTreeMap;

use super::hatch::{Lattice, rows};
use super::region::{Contour, Region, enclosed, pairs};

/// What lies so little beside a row lies on it, grid units: rounding moves a border by less than these 10 micrometres.
const ROUNDING: f64 = 100.0;

/// From row to row wherever `over` lies between the two, `reach` grid units beyond their middles; `own` are the sparse rows across these,
/// and those that fill what is solid, on lattices through the origin.
///
/// What lies between two rows covers intervals along them; over each interval, all from the one row to the other. Within `reach` of a
/// row it lies on that row, so what was brought out to rows once stays as it is. Its ends along the rows lie half a pitch beside a row
/// that fills it, and an own sparse row that would run along them, with less than a line and a half between, is within: what is joined along such
/// a border would lie on it. Empty for an empty region, and where rows lie so close that nothing is between them.
pub(super) fn onto_rows(over: &Region, lattice: Lattice, own: [Lattice; 2], reach: f64) -> Region {
    if lattice.pitch <= 2.0 * reach {
        return Region::new();
    }
    let [sparse, full] = own;
    let whole = |x: f64| ((x - ROUNDING.min(full.pitch / 4.0)) / full.pitch).ceil() * full.pitch;
    // Where sparse rows lie closer than that, the next but one is none of it.
    let near = (3.0 * reach).min(sparse.pitch - reach - ROUNDING);
    let past_own = |x: f64| {
        let x = whole(x);
        let last = sparse.row(sparse.before(x + near));
        if last > x { whole(last + reach) } else { x }
    };
    let rings: Vec<Contour> = covered(over, lattice, reach)
        .into_iter()
        .flat_map(|(gap, spans)| {
            let across = [lattice.row(gap) - reach, lattice.row(gap + 1) + reach];
            joined(spans).into_iter().map(move |(from, to)| {
                // Rows through the origin are their own mirror image.
                let (from, to) = (-past_own(-from), past_own(to));
                let corners = [(from, across[0]), (to, across[0]), (to, across[1]), (from, across[1])];
                corners.map(|(x, y)| lattice.place(x, y)).to_vec()
            })
        })
        .collect();
    enclosed(&rings)
}

/// For each gap, by the row before it, the intervals along the rows that `over` covers there: straight across the gap one leaves it
/// through its border, or comes to a row.
fn covered(over: &Region, lattice: Lattice, reach: f64) -> BTreeMap<i64, Vec<(f64, f64)>> {
    let reach = reach + ROUNDING;
    let mut gaps: BTreeMap<i64, Vec<(f64, f64)>> = BTreeMap::new();
    for (a, b) in over.iter().flatten().flat_map(|ring| pairs(ring)) {
        let (a, b) = (lattice.turned(a), lattice.turned(b));
        let (low, high) = if a.1 <= b.1 { (a, b) } else { (b, a) };
        for gap in lattice.before(low.1)..=lattice.before(high.1) {
            let (from, to) = (low.1.max(lattice.row(gap) + reach), high.1.min(lattice.row(gap + 1) - reach));
            if from > to {
                continue;
            }
            let along = |y: f64| low.0 + (high.0 - low.0) * (y - low.1) / (high.1 - low.1);
            let [from, to] = if low.1 < high.1 { [from, to].map(along) } else { [low.0, high.0] };
            gaps.entry(gap).or_default().push((from.min(to), from.max(to)));
        }
    }
    for (by, first) in [(reach, 0), (-reach, 1)] {
        for row in rows(over, lattice.shifted(by)) {
            gaps.entry(row.index - first).or_default().extend(&row.spans);
        }
    }
    gaps
}

/// What the intervals cover together, ascending.
fn joined(mut spans: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut all: Vec<(f64, f64)> = Vec::new();
    for span in spans {
        match all.last_mut() {
            Some(last) if span.0 <= last.1 => last.1 = last.1.max(span.1),
            _ => all.push(span),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::region::{GridPoint, and, area_mm2, minus, units};
    use super::*;
    use crate::geom::SplitMix64;

    /// Rows along X at 2, 6, 10, .. mm.
    fn level() -> Lattice {
        Lattice::common(0.0, 40_000.0)
    }

    /// Own sparse rows that nothing comes near, and full ones that lie anywhere.
    fn far() -> [Lattice; 2] {
        [1e9, 1.0].map(|pitch| Lattice::common(0.0, pitch))
    }

    fn assert_alike(a: &Region, b: &Region) {
        let off = area_mm2(&minus(a, b)) + area_mm2(&minus(b, a));
        assert!(off < 1e-6, "{off} mm2: {a:?}, {b:?}");
    }

    fn box_mm(x: [f64; 2], y: [f64; 2]) -> Region {
        let corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])];
        vec![vec![corners.map(|(x, y)| GridPoint::new(units(x), units(y))).to_vec()]]
    }

    #[test]
    fn what_ends_between_two_rows_goes_out_to_both() {
        // Rows at 2 and 6 mm, and at 10: half a line of 0.45 mm beyond their middles.
        let got = onto_rows(&box_mm([3.0, 5.0], [3.0, 4.0]), level(), far(), 2250.0);
        assert_alike(&got, &box_mm([3.0, 5.0], [1.775, 6.225]));
        let got = onto_rows(&box_mm([3.0, 5.0], [5.0, 7.0]), level(), far(), 2250.0);
        assert_alike(&got, &box_mm([3.0, 5.0], [1.775, 10.225]));
        // A slant covers what lies before it as far as it is there.
        let slant =
            vec![vec![[(0, 30_000), (40_000, 30_000), (0, 70_000)].map(|(x, y)| GridPoint::new(x, y)).to_vec()]];
        let got = onto_rows(&slant, level(), far(), 2250.0);
        let wanted = area_mm2(&box_mm([0.0, 4.0], [1.775, 6.225])) + area_mm2(&box_mm([0.0, 0.765], [6.225, 10.225]));
        assert!((area_mm2(&got) - wanted).abs() < 1e-3, "{got:?}");
    }

    #[test]
    fn what_ends_on_rows_stays_and_close_rows_carry_everything() {
        let on_two = box_mm([3.0, 5.0], [1.8, 6.2]);
        assert_alike(&onto_rows(&on_two, level(), far(), 2250.0), &box_mm([3.0, 5.0], [1.775, 6.225]));
        assert!(onto_rows(&box_mm([3.0, 5.0], [5.8, 6.2]), level(), far(), 2250.0).is_empty());
        assert!(onto_rows(&Region::new(), level(), far(), 2250.0).is_empty());
        assert!(onto_rows(&on_two, Lattice::common(0.0, 4500.0), far(), 2250.0).is_empty());
    }

    #[test]
    fn an_own_row_along_the_border_is_within() {
        // Own rows at -2, 2 and 6 mm.
        let of = |x: [f64; 2]| onto_rows(&box_mm(x, [3.0, 4.0]), level(), [level(), far()[1]], 2250.0);
        assert_alike(&of([2.7, 5.3]), &box_mm([2.7, 5.3], [1.775, 6.225]));
        assert_alike(&of([2.6, 5.4]), &box_mm([1.775, 6.225], [1.775, 6.225]));
        assert_alike(&of([2.1, 5.9]), &box_mm([1.775, 6.225], [1.775, 6.225]));
        assert_alike(&of([-1.9, 1.9]), &box_mm([-2.225, 2.225], [1.775, 6.225]));
        assert_alike(&of([1.9, 6.1]), &box_mm([1.9, 6.1], [1.775, 6.225]));
    }

    #[test]
    fn the_ends_lie_between_two_rows_that_fill_it() {
        let of = |x: [f64; 2]| {
            let over = box_mm(x, [3.0, 4.0]);
            let own = [far()[0], Lattice::common(0.0, 4000.0)];
            let got = onto_rows(&over, level(), own, 2250.0);
            assert_alike(&onto_rows(&got, level(), own, 2250.0), &got);
            got
        };
        assert_alike(&of([2.5, 5.5]), &box_mm([2.4, 5.6], [1.775, 6.225]));
        assert_alike(&of([-2.4, 5.59]), &box_mm([-2.4, 5.6], [1.775, 6.225]));
    }

    /// Held against points: each one of a gap above or below a place of the region, and no other.
    #[test]
    fn random_regions_go_out_as_points_say() {
        let mut random = SplitMix64::seeded(5);
        for _ in 0..60 {
            let mut any = |by: f64| random.unit() * by;
            let lattice = Lattice::common(any(3.0), 20_000.0 + any(40_000.0)).shifted(any(9000.0));
            let corner = |i: i32| (f64::from(i) * std::f64::consts::TAU / 7.0).sin_cos();
            let star = (0..7).map(corner).map(|(y, x)| (20_000.0 + any(60_000.0), x, y));
            let corners = star.map(|(by, x, y)| GridPoint::new((by * x) as i32, (by * y) as i32)).collect();
            let over = enclosed(&[corners]);
            let reach = 2250.0;
            let got = onto_rows(&over, lattice, far(), reach);
            assert!(area_mm2(&minus(&onto_rows(&got, lattice, far(), reach), &got)) < 0.01, "twice is once");
            let (mut inside, mut outside) = (0, 0);
            for _ in 0..300 {
                let (x, gap) = (any(200_000.0) - 100_000.0, any(12.0) as i64 - 6);
                let strip = |from: f64, to: f64, half: f64| -> Region {
                    let ring = [(x - half, from), (x + half, from), (x + half, to), (x - half, to)];
                    vec![vec![ring.map(|(x, y)| lattice.place(x, y)).to_vec()]]
                };
                let [low, high] = [lattice.row(gap), lattice.row(gap + 1)];
                // What a strip of a micrometre, or one of ten, meets of the region.
                let [narrow, wide] = [10.0, 100.0]
                    .map(|half| area_mm2(&and(&over, &strip(low + reach + ROUNDING, high - reach - ROUNDING, half))));
                let there = area_mm2(&and(&got, &strip(low + 2.0 * reach, high - 2.0 * reach, 10.0)));
                let whole = 20.0 * (high - low - 4.0 * reach) / 1e8;
                if narrow > 1e-6 {
                    assert!(there > 0.4 * whole, "{there} of {whole} at {x} in {gap}");
                    inside += 1;
                } else if wide == 0.0 {
                    assert!(there < 0.1 * whole, "{there} of {whole} at {x} in {gap}");
                    outside += 1;
                }
            }
            assert!(inside + outside > 200);
        }
    }
}
