//! Models side by side on a table, nothing above another: rectangles in rows as a skyline leaves them.

/// Where a rectangle stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Its low corner, mm.
    pub corner: [f64; 2],
    /// Whether it is turned by a quarter about Z.
    pub turned: bool,
}

/// Widths that are tried.
const WIDTHS: usize = 60;

/// Where rectangles (`x`, `y`, mm) stand with `gap_mm` between them, so that `inside` holds for all their corners when the middle of all of
/// them lies at the table's (0, 0); of what is found the layout whose corners lie nearest to it. `None` where none is found, and for no
/// rectangles. `turns`: whether quarter turns about Z are allowed.
pub fn on_table(
    footprints: &[[f64; 2]],
    gap_mm: f64,
    turns: bool,
    inside: &dyn Fn([f64; 2]) -> bool,
) -> Option<Vec<Spot>> {
    let long = footprints.iter().map(|f| if turns { f[0].min(f[1]) } else { f[0] }).fold(0.0, f64::max);
    let all: f64 = footprints.iter().map(|f| f[0].max(f[1]) + gap_mm).sum();
    let keys: [fn(&[f64; 2]) -> f64; 3] = [|f| f[0] * f[1], |f| f[0].max(f[1]), |f| f[1]];
    let mut best: Option<(f64, Vec<Spot>)> = None;
    for step in 0..=WIDTHS {
        // Narrow ones densely, since most layouts are about square.
        let width = long + (all - long).max(0.0) * (step as f64 / WIDTHS as f64).powi(2);
        for key in keys {
            let mut order: Vec<usize> = (0..footprints.len()).collect();
            order.sort_by(|&a, &b| key(&footprints[b]).total_cmp(&key(&footprints[a])).then(a.cmp(&b)));
            let Some(spots) = laid(footprints, &order, width, gap_mm, turns) else { continue };
            let (corners, reach) = about_the_middle(footprints, &spots);
            if best.as_ref().is_none_or(|(least, _)| reach < *least - 1e-9) && corners.iter().all(|&c| inside(c)) {
                best = Some((reach, spots));
            }
        }
    }
    best.map(|(_, spots)| spots)
}

fn size(footprint: &[f64; 2], turned: bool) -> [f64; 2] {
    if turned { [footprint[1], footprint[0]] } else { *footprint }
}

/// All corners with the middle of all at (0, 0), and how far the farthest is from it.
fn about_the_middle(footprints: &[[f64; 2]], spots: &[Spot]) -> (Vec<[f64; 2]>, f64) {
    let mut corners: Vec<[f64; 2]> = Vec::with_capacity(4 * spots.len());
    for (spot, footprint) in spots.iter().zip(footprints) {
        let ([x, y], [w, d]) = (spot.corner, size(footprint, spot.turned));
        corners.extend([[x, y], [x + w, y], [x, y + d], [x + w, y + d]]);
    }
    let middle = [0, 1].map(|k| {
        let of = |pick: fn(f64, f64) -> f64, from: f64| corners.iter().map(|c| c[k]).fold(from, pick);
        (of(f64::min, f64::INFINITY) + of(f64::max, f64::NEG_INFINITY)) / 2.0
    });
    corners.iter_mut().for_each(|c| *c = [c[0] - middle[0], c[1] - middle[1]]);
    let reach = corners.iter().map(|c| c[0].hypot(c[1])).fold(0.0, f64::max);
    (corners, reach)
}

/// Each rectangle as low as it goes on a strip of `width`, then as far left; `None` where one is wider.
fn laid(footprints: &[[f64; 2]], order: &[usize], width: f64, gap_mm: f64, turns: bool) -> Option<Vec<Spot>> {
    let mut spots = vec![Spot { corner: [0.0; 2], turned: false }; footprints.len()];
    // From where on, and how high; a gap is part of what stands to the left of it and below it.
    let mut line: Vec<[f64; 2]> = vec![[0.0, 0.0]];
    for &index in order {
        let mut best: Option<([f64; 3], f64, bool)> = None;
        for turned in [false, true].into_iter().take(1 + usize::from(turns)) {
            let [w, d] = size(&footprints[index], turned);
            for start in line.iter().map(|s| s[0]).filter(|x| x + w <= width + 1e-9) {
                let under = (0..line.len()).filter(|&i| {
                    let end = line.get(i + 1).map_or(f64::INFINITY, |next| next[0]);
                    line[i][0] < start + w + gap_mm - 1e-9 && end > start + 1e-9
                });
                let y = under.map(|i| line[i][1]).fold(0.0, f64::max);
                let key = [y + d, y, start];
                if best.is_none_or(|(known, ..)| key < known) {
                    best = Some((key, start, turned));
                }
            }
        }
        let ([_, y, _], x, turned) = best?;
        spots[index] = Spot { corner: [x, y], turned };
        let [w, d] = size(&footprints[index], turned);
        raise(&mut line, [x, x + w + gap_mm], y + d + gap_mm);
    }
    (!order.is_empty()).then_some(spots)
}

/// The line between two places at a new height.
fn raise(line: &mut Vec<[f64; 2]>, [from, to]: [f64; 2], height: f64) {
    let behind = line.iter().rev().find(|s| s[0] <= to + 1e-9).map_or(0.0, |s| s[1]);
    let next = line.iter().find(|s| (s[0] - to).abs() <= 1e-9).copied();
    line.retain(|s| s[0] < from - 1e-9 || s[0] > to + 1e-9);
    line.extend([[from, height], next.unwrap_or([to, behind])]);
    line.sort_by(|a, b| a[0].total_cmp(&b[0]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    #[test]
    fn random_rectangles_stand_apart_and_inside() {
        let mut numbers = SplitMix64::seeded(4);
        let mut found = 0;
        for round in 0..200 {
            let count = 1 + numbers.below(9);
            let footprints: Vec<[f64; 2]> =
                (0..count).map(|_| [5.0 + 40.0 * numbers.unit(), 5.0 + 40.0 * numbers.unit()]).collect();
            let (gap, turns) = ([0.5, 5.0, 20.0][numbers.below(3)], round % 2 == 0);
            let disc = |[x, y]: [f64; 2]| x.hypot(y) <= 90.0;
            let square = |[x, y]: [f64; 2]| x.abs().max(y.abs()) <= 70.0;
            let inside: &dyn Fn([f64; 2]) -> bool = if round % 3 == 0 { &square } else { &disc };
            let Some(spots) = on_table(&footprints, gap, turns, inside) else { continue };
            found += 1;
            assert!(about_the_middle(&footprints, &spots).0.into_iter().all(inside));
            for (i, a) in spots.iter().enumerate() {
                assert!(turns || !a.turned);
                for (j, b) in spots[..i].iter().enumerate() {
                    let (s, t) = (size(&footprints[i], a.turned), size(&footprints[j], b.turned));
                    let apart = |k: usize| (a.corner[k] - b.corner[k] - t[k]).max(b.corner[k] - a.corner[k] - s[k]);
                    assert!(apart(0).max(apart(1)) >= gap - 1e-6, "{round}: {i} and {j}");
                }
            }
        }
        assert!(found > 120, "{found}");
        assert_eq!(on_table(&[], 1.0, false, &|_| true), None);
        assert_eq!(on_table(&[[10.0, 10.0]], 1.0, true, &|[x, _]| x < 4.0), None);
    }

    /// Two long ones fit side by side only when both lie the same way.
    #[test]
    fn a_turn_makes_room() {
        let narrow = |[x, y]: [f64; 2]| x.abs() <= 15.0 && y.abs() <= 25.0;
        let boards = [[40.0, 10.0], [10.0, 40.0]];
        assert_eq!(on_table(&boards, 2.0, false, &narrow), None);
        let spots = on_table(&boards, 2.0, true, &narrow).unwrap();
        assert!(spots[0].turned && !spots[1].turned);
    }
}
