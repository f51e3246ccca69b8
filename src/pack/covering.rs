//! A solid covered by a few boxes (Leitereg (2020), section 2.3), over the cells that it touches: branch and cut over boxes on one side of a plane, and
//! k-means with a middle and a diagonal for each box; the less volume of both. Every point of the solid lies in one of the boxes.

use super::voxels::{Span, voxels};
use super::watch::Watch;
use crate::geom::{SplitMix64, Vec3};

/// Cells along the longest side.
const CELLS: f64 = 28.0;
/// Boxes that are branched on, of those that are made.
const BRANCHES: usize = 14;
/// Beginnings of the clustering, and its rounds.
const BEGINNINGS: usize = 12;
const ROUNDS: usize = 20;
/// Cells that are looked at in the time of a watch's step.
const CELLS_A_STEP: usize = 64;

/// From the low cell to behind the high one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct CellBox {
    low: [i32; 3],
    high: [i32; 3],
}

impl CellBox {
    const NONE: Self = Self { low: [i32::MAX; 3], high: [i32::MIN; 3] };

    fn volume(&self) -> i64 {
        (0..3).map(|k| i64::from(self.high[k].saturating_sub(self.low[k]).max(0))).product()
    }

    fn of<'a>(cells: impl IntoIterator<Item = &'a [i32; 3]>) -> Self {
        let one = |cell: &[i32; 3]| Self { low: *cell, high: cell.map(|c| c + 1) };
        cells.into_iter().fold(Self::NONE, |all, cell| all.with(&one(cell)))
    }

    /// The box around both.
    fn with(&self, other: &Self) -> Self {
        let (a, b) = (self, other);
        Self { low: [0, 1, 2].map(|k| a.low[k].min(b.low[k])), high: [0, 1, 2].map(|k| a.high[k].max(b.high[k])) }
    }

    fn holds(&self, cell: &[i32; 3]) -> bool {
        (0..3).all(|k| self.low[k] <= cell[k] && cell[k] < self.high[k])
    }
}

/// At most `count` boxes (low corner and size, mm, from the low corner of the solid's own box) that cover `facets`; `None` where the watch ended on
/// the way.
pub(super) fn covering(
    facets: &[[Vec3; 3]],
    count: usize,
    seed: u64,
    watch: &mut Watch<'_>,
) -> Option<Vec<(Vec3, Vec3)>> {
    let bounds = crate::geom::Bounds::of(facets.iter().flatten().copied());
    let step = bounds.size().max() / CELLS;
    let made = voxels(facets, step);
    let each = |span: &Span| {
        let (y, z) = (span.y, span.z);
        (span.from..span.to).map(move |x| [x, y, z])
    };
    let cells: Vec<[i32; 3]> = made.spans.iter().flat_map(each).collect();
    let mut best = Cut { least: i64::MAX, boxes: Vec::new() };
    best.branch(count, &cells, 0, &mut Vec::new(), watch)?;
    let clustered = k_means(&cells, count, seed, watch)?;
    let volume = |boxes: &[CellBox]| boxes.iter().map(CellBox::volume).sum::<i64>();
    if volume(&clustered) < best.least {
        best.boxes = clustered;
    }
    // No farther than the solid itself reaches.
    let corner = |cell: [i32; 3]| Vec3::from(cell.map(f64::from)) * step;
    Some(best.boxes.iter().map(|b| (corner(b.low), corner(b.high).inf(&bounds.size()) - corner(b.low))).collect())
}

/// Counts `cells` looked at as steps; `None` where the watch has ended.
fn looked_at(cells: usize, watch: &mut Watch<'_>) -> Option<()> {
    watch.spend(1 + (cells / CELLS_A_STEP) as u64).then_some(())
}

/// Branch and cut: what is known to be the least, and its boxes.
struct Cut {
    least: i64,
    boxes: Vec<CellBox>,
}

impl Cut {
    fn branch(
        &mut self,
        count: usize,
        cells: &[[i32; 3]],
        so_far: i64,
        chosen: &mut Vec<CellBox>,
        watch: &mut Watch<'_>,
    ) -> Option<()> {
        looked_at(cells.len(), watch)?;
        // Whatever covers the rest has at least its volume.
        if so_far + cells.len() as i64 >= self.least {
            return Some(());
        }
        let all = CellBox::of(cells);
        if count <= 1 || cells.is_empty() {
            let rest = if cells.is_empty() { 0 } else { all.volume() };
            if so_far + rest < self.least {
                self.least = so_far + rest;
                self.boxes.clone_from(chosen);
                self.boxes.extend((!cells.is_empty()).then_some(all));
            }
            return Some(());
        }
        for made in boxes_to_try(cells, &all) {
            let left: Vec<[i32; 3]> = cells.iter().filter(|cell| !made.holds(cell)).copied().collect();
            chosen.push(made);
            self.branch(count - 1, &left, so_far + made.volume(), chosen, watch)?;
            chosen.pop();
        }
        Some(())
    }
}

/// The box around what lies on one side of a plane between cells, for every plane and side; first those with which the box and what is
/// left have the least volume.
fn boxes_to_try(cells: &[[i32; 3]], all: &CellBox) -> Vec<CellBox> {
    let mut made: Vec<(i64, CellBox)> = Vec::new();
    for k in 0..3 {
        let mut slabs = vec![CellBox::NONE; (all.high[k] - all.low[k]) as usize];
        for cell in cells {
            let slab = &mut slabs[(cell[k] - all.low[k]) as usize];
            *slab = slab.with(&CellBox::of([cell]));
        }
        // The boxes around all slabs from each on.
        let mut behind = slabs.clone();
        for at in (0..slabs.len().saturating_sub(1)).rev() {
            behind[at] = behind[at].with(&behind[at + 1]);
        }
        let mut before = CellBox::NONE;
        for at in 1..slabs.len() {
            before = before.with(&slabs[at - 1]);
            for (one, other) in [(before, behind[at]), (behind[at], before)] {
                if !made.iter().any(|(_, known)| *known == one) {
                    made.push((one.volume() + other.volume(), one));
                }
            }
        }
    }
    made.push((all.volume(), *all));
    made.sort_by_key(|(volume, b)| (*volume, b.low, b.high));
    made.into_iter().take(BRANCHES).map(|(_, b)| b).collect()
}

/// Clusters by the smallest box about a middle, along its diagonal, that holds a cell; the best of some beginnings.
fn k_means(cells: &[[i32; 3]], count: usize, seed: u64, watch: &mut Watch<'_>) -> Option<Vec<CellBox>> {
    let mut numbers = SplitMix64::seeded(seed);
    let mut best: Option<(i64, Vec<CellBox>)> = None;
    for _ in 0..BEGINNINGS {
        let mut boxes: Vec<CellBox> = (0..count).map(|_| CellBox::of([&cells[numbers.below(cells.len())]])).collect();
        for _ in 0..ROUNDS {
            looked_at(cells.len() * count, watch)?;
            let next = clustered(cells, &boxes);
            if next == boxes {
                break;
            }
            boxes = next;
        }
        let volume = boxes.iter().map(CellBox::volume).sum();
        if best.as_ref().is_none_or(|(least, _)| volume < *least) {
            best = Some((volume, boxes));
        }
    }
    Some(best.map(|(_, boxes)| boxes).unwrap_or_default())
}

/// Each cell to the box that would have to be least large for it; then the boxes around what came to each.
fn clustered(cells: &[[i32; 3]], boxes: &[CellBox]) -> Vec<CellBox> {
    let middle = |b: &CellBox, k: usize| f64::from(b.low[k] + b.high[k]) / 2.0;
    let mut next = vec![CellBox::NONE; boxes.len()];
    for cell in cells {
        let needed = |b: &CellBox| {
            let size = [0, 1, 2].map(|k| f64::from((b.high[k] - b.low[k]).max(1)));
            let share = |k: usize| ((f64::from(cell[k]) + 0.5 - middle(b, k)).abs() + 0.5) / size[k];
            let scale = (0..3).map(share).fold(0.0, f64::max);
            size.iter().product::<f64>() * scale.powi(3)
        };
        let own = (0..boxes.len()).min_by(|&a, &b| needed(&boxes[a]).total_cmp(&needed(&boxes[b]))).unwrap_or(0);
        next[own] = next[own].with(&CellBox::of([cell]));
    }
    next.retain(|b| b.volume() > 0);
    next
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;
    use crate::pack::{Ended, PackSolid};

    fn ell() -> Vec<[Vec3; 3]> {
        let long = solid_box(Vec3::zeros(), Vec3::new(40.0, 10.0, 10.0));
        let high = solid_box(Vec3::zeros(), Vec3::new(10.0, 10.0, 40.0));
        PackSolid::of([&long, &high], 1.0, 1).facets
    }

    fn covered(facets: &[[Vec3; 3]], count: usize) -> Vec<(Vec3, Vec3)> {
        covering(facets, count, 1, &mut Watch::new(u64::MAX, &mut |_| None)).unwrap()
    }

    /// With corners at random, its facets outward.
    fn tetrahedron() -> Vec<[Vec3; 3]> {
        let mut numbers = SplitMix64::seeded(6);
        let [a, b, c, d] = [(); 4].map(|()| numbers.direction() * 20.0);
        if (b - a).cross(&(c - a)).dot(&(d - a)) < 0.0 {
            vec![[a, b, c], [a, d, b], [a, c, d], [b, d, c]]
        } else {
            vec![[a, c, b], [a, b, d], [a, d, c], [b, c, d]]
        }
    }

    /// The clock is asked again and again while one model is covered, and the first no ends it.
    #[test]
    fn an_end_is_heard_on_the_way() {
        let asks = |last: usize| {
            let mut asked = 0;
            let mut ask = |_| {
                asked += 1;
                (asked == last).then_some(Ended::Time)
            };
            let covered = covering(&tetrahedron(), 4, 1, &mut Watch::new(u64::MAX, &mut ask)).is_some();
            (covered, asked)
        };
        let (covered, all) = asks(usize::MAX);
        assert!(covered && all > 2, "{all}");
        for last in [1, 2, all] {
            assert_eq!(asks(last), (false, last));
        }
    }

    #[test]
    fn two_boxes_cover_an_ell_without_waste() {
        let boxes = covered(&ell(), 2);
        let volume: f64 = boxes.iter().map(|(_, size)| size.product()).sum();
        assert!(boxes.len() == 2 && (volume - 7000.0).abs() < 7000.0 * 0.15, "{boxes:?}");
        assert_eq!(covered(&ell(), 1).len(), 1);
    }

    /// 100,000 points of the surface and the inside lie in the boxes.
    #[test]
    fn every_point_is_covered() {
        let mut numbers = SplitMix64::seeded(7);
        let facets = tetrahedron();
        let corners = [facets[0][0], facets[3][0], facets[3][1], facets[3][2]];
        let low = crate::geom::Bounds::of(corners).min;
        for count in 1..=4 {
            let boxes = covered(&facets, count);
            assert!(boxes.len() <= count);
            for _ in 0..100_000 {
                let mut shares = [(); 4].map(|()| -(1.0 - numbers.unit()).ln());
                let sum: f64 = shares.iter().sum();
                shares.iter_mut().for_each(|s| *s /= sum);
                let p: Vec3 = (0..4).map(|k| (corners[k] - low) * shares[k]).sum();
                let inside =
                    |(at, size): &(Vec3, Vec3)| (0..3).all(|k| at[k] - 1e-6 <= p[k] && p[k] <= at[k] + size[k] + 1e-6);
                assert!(boxes.iter().any(inside), "{p}");
            }
        }
    }
}
