//! The shapes of a layer near one of its islands: with thousands of islands, each held against all of the next layer costs their number squared.

use std::borrow::Cow;

use super::region::{GridPoint, Region, Shape};

/// So few shapes are taken as they are.
const FEW: usize = 4;

/// A region whose shapes are found by where they lie.
pub(super) struct Shapes<'a> {
    region: &'a Region,
    /// The shapes' boxes, `[least, most]`, with their numbers, by their least x.
    boxes: Vec<([GridPoint; 2], usize)>,
    /// The widest box, grid units.
    widest: i64,
}

impl<'a> Shapes<'a> {
    pub(super) fn of(region: &'a Region) -> Self {
        let all = if region.len() > FEW { region.as_slice() } else { &[] };
        let mut boxes: Vec<([GridPoint; 2], usize)> =
            all.iter().zip(0..).filter_map(|(shape, index)| Some((bounds([shape])?, index))).collect();
        boxes.sort_by_key(|([least, _], index)| (least.x, *index));
        let widest = boxes.iter().map(|([least, most], _)| i64::from(most.x) - i64::from(least.x)).max().unwrap_or(0);
        Self { region, boxes, widest }
    }

    /// The shapes that come within `by` grid units of the box around `other`, and perhaps some more; in the region's order.
    pub(super) fn near(&self, other: &Region, by: i32) -> Cow<'a, Region> {
        if self.region.len() <= FEW {
            return Cow::Borrowed(self.region);
        }
        let Some([least, most]) = bounds(other) else { return Cow::Owned(Region::new()) };
        let by = i64::from(by);
        let reaches = |low: i32, high: i32, least: i32, most: i32| {
            i64::from(low) <= i64::from(most) + by && i64::from(high) >= i64::from(least) - by
        };
        let from = self.boxes.partition_point(|([low, _], _)| i64::from(low.x) < i64::from(least.x) - by - self.widest);
        let ahead = self.boxes[from..].iter().take_while(|([low, _], _)| i64::from(low.x) <= i64::from(most.x) + by);
        let mut found: Vec<usize> = ahead
            .filter(|([low, high], _)| {
                reaches(low.x, high.x, least.x, most.x) && reaches(low.y, high.y, least.y, most.y)
            })
            .map(|(_, index)| *index)
            .collect();
        found.sort_unstable();
        Cow::Owned(found.into_iter().map(|index| self.region[index].clone()).collect())
    }
}

/// The box around shapes; `None` for none.
fn bounds<'s>(shapes: impl IntoIterator<Item = &'s Shape>) -> Option<[GridPoint; 2]> {
    let outer = shapes.into_iter().filter_map(|shape| shape.first()).flatten();
    outer.fold(None, |known, p| {
        let [least, most] = known.unwrap_or([*p; 2]);
        Some([GridPoint::new(least.x.min(p.x), least.y.min(p.y)), GridPoint::new(most.x.max(p.x), most.y.max(p.y))])
    })
}

#[cfg(test)]
mod tests {
    use super::super::region::{and, enclosed, grown};
    use super::*;

    #[test]
    fn what_is_near_is_all_that_counts() {
        let mut random = crate::geom::SplitMix64::seeded(11);
        let mut squares = |count: usize, most: f64| {
            let mut any = |by: f64| (random.unit() * by) as i32;
            let rings: Vec<Vec<GridPoint>> = (0..count)
                .map(|_| (any(1e6), any(1e6), 100 + any(most)))
                .map(|(x, y, by)| {
                    [(x, y), (x + by, y), (x + by, y + by), (x, y + by)].map(|(x, y)| GridPoint::new(x, y)).to_vec()
                })
                .collect();
            enclosed(&rings)
        };
        for most in [3e4, 4e5] {
            let layer = squares(80, most);
            let shapes = Shapes::of(&layer);
            for island in squares(60, most) {
                let island = vec![island];
                for by in [0, 5_000] {
                    let wide = grown(&island, by);
                    let near = shapes.near(&island, by);
                    assert_eq!(and(&wide, &near), and(&wide, &layer));
                }
            }
            assert!(shapes.near(&vec![layer[0].clone()], 0).len() <= layer.len());
        }
        let far = squares(40, 3e4);
        assert!(Shapes::of(&far).near(&vec![far[3].clone()], 0).len() < far.len() / 2);
    }
}
