//! A solid that is cut on pedestals of several heights gives on each what it gives there alone, whatever was tried before.

use trunnion::geom::{Object, Vec3};
use trunnion::mesh::{Model, TriangleMesh};
use trunnion::split::{CutMachine, CutOptions, PinnedCut, Plane, Split, Splitter, split};

use super::solids;

/// A head that prints nothing lower than this above the table, and no piece larger than that, mm3.
struct Above {
    lowest: f64,
    largest: f64,
}

impl CutMachine for Above {
    fn reaches(&self, up: &Vec3) -> bool {
        up.z >= -1e-9
    }

    fn prints(&self, piece: &TriangleMesh<Object>, _: &Vec3, _: Option<&TriangleMesh<Object>>) -> bool {
        piece.bounds().min.z >= self.lowest && piece.volume() <= self.largest
    }

    fn plans(&self, _: &Model, _: &[Vec3], _: &[usize], _: &[usize]) -> bool {
        true
    }
}

type Told = (bool, Vec<(Plane, Vec<usize>)>, usize, [f64; 2], String);

fn told(found: &Split) -> Told {
    let cuts = found.cuts.iter().map(|cut| (cut.plane, cut.parts.clone())).collect();
    let figures = [found.after.area_mm2, found.seam_mm2()];
    (found.printable, cuts, found.parts.len(), figures, format!("{:?} {:?}", found.refused, found.unpinned))
}

#[test]
fn what_one_height_found_is_asked_again_on_the_next() {
    let mut seen = Vec::new();
    for shape in [solids::tee(), solids::hook(), solids::wye(), solids::mushroom()] {
        let mesh = shape.mesh();
        let machine = |[lowest, largest]: [f64; 2]| Above { lowest, largest };
        let searched = CutOptions { max_cuts: 3, ..CutOptions::default() };
        let free = split(&mesh, &machine([0.0, 1e9]), &searched, &mut |_| true);
        let pinned: Vec<PinnedCut> =
            free.cuts.iter().map(|cut| PinnedCut { plane: cut.plane, points: cut.points.clone() }).collect();
        // From nearly nothing to all and back, so that each answer meets one that was more and one that was less.
        let heights = [[45.0, 1e9], [20.0, 9000.0], [0.0, 1e9], [30.0, 4000.0], [45.0, 1e9], [20.0, 9000.0]];
        let pedestals = [40.0, 20.0, 0.0, 30.0, 40.0, 20.0];
        // What needs no cut has nothing to pin.
        let with_pins = (!pinned.is_empty()).then(|| CutOptions { pinned, ..searched.clone() });
        for options in std::iter::once(searched).chain(with_pins) {
            let mut splitter = Splitter::new(&mesh, |up| machine(heights[0]).reaches(up), options.clone());
            for (height, pedestal_mm) in heights.into_iter().zip(pedestals) {
                let got = told(&splitter.split(&machine(height), pedestal_mm, &mut |_| true));
                let alone = CutOptions { pedestal_mm, ..options.clone() };
                let wanted = told(&split(&mesh, &machine(height), &alone, &mut |_| true));
                assert_eq!(got, wanted, "at {height:?} with {} pinned", options.pinned.len());
                seen.push((options.pinned.len(), format!("{wanted:?}")));
            }
        }
    }
    seen.sort();
    seen.dedup();
    for pinned in [false, true] {
        let results = seen.iter().filter(|(pins, _)| (*pins > 0) == pinned).count();
        assert!(results >= 8, "the machines say the same: {results} results with pins: {pinned}");
    }
}
