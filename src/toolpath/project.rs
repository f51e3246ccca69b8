//! The slicer's bed, and where the prints of a plan stand on it side by side.

/// The slicer's bed, mm: its corner at 0, 0 on most printers, its middle on some.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bed {
    /// Its lowest x and y.
    pub min_mm: [f64; 2],
    /// Its highest.
    pub max_mm: [f64; 2],
}

impl From<[f64; 2]> for Bed {
    /// A bed of this size with its corner at 0, 0.
    fn from(size: [f64; 2]) -> Self {
        Self { min_mm: [0.0; 2], max_mm: size }
    }
}

impl Bed {
    /// Its size in x and y.
    pub fn size_mm(&self) -> [f64; 2] {
        [0, 1].map(|a| self.max_mm[a] - self.min_mm[a])
    }

    /// Its middle.
    pub fn middle_mm(&self) -> [f64; 2] {
        [0, 1].map(|a| (self.max_mm[a] + self.min_mm[a]) / 2.0)
    }
}

/// Where a print stands in the projects of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectSpot {
    /// Which project, from 0.
    pub project: usize,
    /// The middle of its box on the bed, mm.
    pub centre_mm: [f64; 2],
}

/// A print that does not fit on the bed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "print {print} is {:.1} x {:.1} mm, but the slicer's bed is {} x {} mm; pass a larger --bed", .size_mm[0], .size_mm[1],
    .bed_mm[0], .bed_mm[1]
)]
pub struct TooLarge {
    /// In the order of the plan.
    pub print: usize,
    /// Its box.
    pub size_mm: [f64; 2],
    /// The bed.
    pub bed_mm: [f64; 2],
}

/// Room between objects of a project, mm: as much as people's own presets ask for between objects printed one by one (PrusaSlicer's
/// are 20 to 45), where that keeps all prints in one project; else room for lines beside the outline.
const GAPS_MM: [f64; 3] = [50.0, 25.0, 8.0];

/// Where prints of these sizes stand on `bed`: in rows along X, the deepest first, in as many projects as it takes, each in the bed's
/// middle: PrusaSlicer 2.9 leaves out what reaches over its edge by a fraction of a micron.
///
/// # Errors
///
/// [`TooLarge`] for one that does not fit alone.
pub fn layout(sizes: &[[f64; 2]], bed: &Bed) -> Result<Vec<ProjectSpot>, TooLarge> {
    let [wide, deep] = bed.size_mm();
    if let Some(print) = sizes.iter().position(|size| size[0] > wide || size[1] > deep) {
        return Err(TooLarge { print, size_mm: sizes[print], bed_mm: bed.size_mm() });
    }
    let tried = GAPS_MM.map(|gap_mm| rows(sizes, bed, gap_mm));
    let in_one = tried.iter().find(|spots| spots.iter().all(|spot| spot.project == 0));
    let mut spots = in_one.unwrap_or(&tried[GAPS_MM.len() - 1]).clone();
    centre(&mut spots, sizes, bed);
    Ok(spots)
}

/// Moves the prints of each project together into the bed's middle.
fn centre(spots: &mut [ProjectSpot], sizes: &[[f64; 2]], bed: &Bed) {
    let projects = spots.iter().map(|spot| spot.project + 1).max().unwrap_or(0);
    for project in 0..projects {
        let by: [f64; 2] = std::array::from_fn(|a| {
            let here = spots.iter().zip(sizes).filter(|(spot, _)| spot.project == project);
            let ends = here.map(|(spot, size)| [spot.centre_mm[a] - size[a] / 2.0, spot.centre_mm[a] + size[a] / 2.0]);
            let [low, high] =
                ends.fold([f64::INFINITY, f64::NEG_INFINITY], |all, end| [all[0].min(end[0]), all[1].max(end[1])]);
            bed.middle_mm()[a] - f64::midpoint(low, high)
        });
        for spot in spots.iter_mut().filter(|spot| spot.project == project) {
            // Whole microns, so that a slicer gives back what it was given.
            spot.centre_mm = [0, 1].map(|a| crate::gcode::round_to(spot.centre_mm[a] + by[a], 3));
        }
    }
}

fn rows(sizes: &[[f64; 2]], bed: &Bed, gap_mm: f64) -> Vec<ProjectSpot> {
    let [wide, deep] = bed.size_mm();
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by(|&a, &b| sizes[b][1].total_cmp(&sizes[a][1]).then(a.cmp(&b)));
    let mut spots = vec![ProjectSpot { project: 0, centre_mm: bed.middle_mm() }; sizes.len()];
    let mut rows: Vec<Row> = Vec::new();
    for print in order {
        let [x, y] = sizes[print];
        let at = rows.iter().position(|row| row.end + x <= wide && y <= row.depth).unwrap_or_else(|| {
            let last = rows.last().map(|row| (row.project, row.start + row.depth + gap_mm));
            let (project, start) = match last {
                Some((project, start)) if start + y <= deep => (project, start),
                Some((project, _)) => (project + 1, 0.0),
                None => (0, 0.0),
            };
            rows.push(Row { project, start, depth: y, end: 0.0 });
            rows.len() - 1
        });
        let row = &mut rows[at];
        let corner = [bed.min_mm[0] + row.end, bed.min_mm[1] + row.start];
        let centre_mm = [corner[0] + x / 2.0, corner[1] + y / 2.0];
        spots[print] = ProjectSpot { project: row.project, centre_mm };
        row.end += x + gap_mm;
    }
    spots
}

/// Prints beside each other.
struct Row {
    project: usize,
    /// From the bed's edge.
    start: f64,
    depth: f64,
    /// Where the next print begins.
    end: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_much_room_is_left_on_either_side() {
        let sizes = [[30.0, 20.0], [10.0, 15.0], [25.001, 8.0], [12.0, 12.0]];
        for bed in [Bed::from([250.0, 210.0]), Bed { min_mm: [-60.0, -20.0], max_mm: [60.0, 20.0] }] {
            let spots = layout(&sizes, &bed).unwrap();
            for project in 0..=spots.iter().map(|spot| spot.project).max().unwrap() {
                for a in 0..2 {
                    let here = spots.iter().zip(&sizes).filter(|(spot, _)| spot.project == project);
                    let ends =
                        here.map(|(spot, size)| [-1.0, 1.0].map(|side| spot.centre_mm[a] + side * size[a] / 2.0));
                    let (low, high): (Vec<f64>, Vec<f64>) = ends.map(|[low, high]| (low, high)).unzip();
                    let below = low.into_iter().fold(f64::INFINITY, f64::min) - bed.min_mm[a];
                    let above = bed.max_mm[a] - high.into_iter().fold(f64::NEG_INFINITY, f64::max);
                    assert!((below - above).abs() < 2e-3 && below > 0.0, "{project}: {below} {above}");
                }
            }
        }
    }

    #[test]
    fn prints_stand_on_the_bed_apart_from_each_other() {
        let sizes: Vec<[f64; 2]> =
            (0..40).map(|i| [10.0 + f64::from(i * 7 % 30), 12.0 + f64::from(i * 5 % 23)]).collect();
        for bed in [Bed::from([120.0, 100.0]), Bed { min_mm: [-90.0, -50.0], max_mm: [90.0, 50.0] }] {
            let spots = layout(&sizes, &bed).unwrap();
            assert!(spots.iter().any(|spot| spot.project > 0));
            for (i, (a, size)) in spots.iter().zip(&sizes).enumerate() {
                let inside = |k: usize| {
                    let half = size[k] / 2.0 - 1e-3;
                    a.centre_mm[k] - half >= bed.min_mm[k] && a.centre_mm[k] + half <= bed.max_mm[k]
                };
                assert!(inside(0) && inside(1), "{a:?}");
                for (b, other) in spots[..i].iter().zip(&sizes).filter(|(b, _)| b.project == a.project) {
                    let apart = |k: usize| (a.centre_mm[k] - b.centre_mm[k]).abs() - (size[k] + other[k]) / 2.0;
                    assert!(apart(0).max(apart(1)) >= GAPS_MM[2] - 2e-3, "{a:?} {b:?}");
                }
            }
        }
        let wrong = layout(&[[10.0, 10.0], [10.0, 300.0]], &Bed::from([250.0, 210.0])).unwrap_err().to_string();
        assert_eq!(wrong, "print 1 is 10.0 x 300.0 mm, but the slicer's bed is 250 x 210 mm; pass a larger --bed");
    }
}
