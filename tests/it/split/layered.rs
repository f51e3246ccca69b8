//! What the search knows of layers is not asked of the plan again: with and without that knowledge the plan says the same.

use std::sync::Mutex;

use trunnion::geom::{Object, SplitMix64, Vec3};
use trunnion::mesh::{Model, TriangleMesh};
use trunnion::planning::{OnePrint, centred};
use trunnion::split::{CutMachine, CutOptions, PinnedCut, Plane, split};

use super::{machine, solids};
use crate::support::{note, seeds};

/// A machine whose plan is made with what is known, and once more without.
struct Twice<'a> {
    one: OnePrint<'a>,
    /// What the plan said, and of how many parts something was known.
    asked: Mutex<Vec<(bool, usize)>>,
}

impl CutMachine for Twice<'_> {
    fn reaches(&self, up: &Vec3) -> bool {
        self.one.reaches(up)
    }

    fn prints(&self, piece: &TriangleMesh<Object>, up: &Vec3, standing: Option<&TriangleMesh<Object>>) -> bool {
        self.one.allows(piece, up, standing)
    }

    fn plans(&self, model: &Model, ups: &[Vec3], supported: &[usize], layered: &[usize]) -> bool {
        let plans = |layered: &[usize]| self.one.plans(model, ups, supported, layered);
        let (known, afresh) = (plans(layered), plans(&[]));
        assert_eq!(known, afresh, "{layered:?} of {} parts along {ups:?}", model.parts.len());
        self.asked.lock().unwrap().push((known, layered.len()));
        known
    }
}

/// Round solids, whose facets say that they hang where their layers do not, and solids of flat faces, each cut by planes at random.
#[test]
fn the_plan_says_the_same_whatever_is_known_of_layers() {
    let ball = solids::ball(15.0, 32).at(0.0, 0.0, 13.5).less(&solids::block(40.0, 40.0, 40.0).at(0.0, 0.0, -40.0));
    let tube = solids::rod(12.0, 40.0, 48).less(&solids::rod(5.0, 60.0, 48).about_y(90.0).at(-30.0, 0.0, 22.0));
    let shapes = [ball.and(&solids::rod(6.0, 40.0, 32)), tube, solids::wye_pipe(), solids::bracket(), solids::bridge()];
    let profile = machine();
    let mut all = Vec::new();
    for seed in seeds(30, 300) {
        let mut random = SplitMix64::seeded(seed);
        let mesh = shapes[seed as usize % shapes.len()].mesh();
        let whole = Model::from_parts(vec![("solid".to_owned(), mesh.clone())]);
        let options = CutOptions::default();
        let one = OnePrint::new(&profile, centred(&whole, &profile).unwrap(), options.overhang, 0.5);
        let head = Twice { one, asked: Mutex::default() };
        let lean = Vec3::new(random.unit() - 0.5, random.unit() - 0.5, 1.2 * random.unit());
        let normal = if seed % 3 == 0 { Vec3::z() } else { lean.normalize() };
        let reach = |sign: f64| mesh.vertices().iter().map(|v| sign * v.dot(&normal)).fold(f64::MIN, f64::max);
        let (low, high) = (-reach(-1.0), reach(1.0));
        let offset_mm = low + (high - low) * (0.3 + 0.6 * random.unit());
        let pinned = vec![PinnedCut { plane: Plane { normal, offset_mm }, points: Vec::new() }];
        split(&mesh, &head, &CutOptions { pinned, max_cuts: 1, ..options }, &mut |_| true);
        all.extend(head.asked.into_inner().unwrap());
    }
    let count = |test: fn(&(bool, usize)) -> bool| all.iter().filter(|one| test(one)).count();
    let (yes, no, known) = (count(|one| one.0), count(|one| !one.0), count(|one| one.1 > 0));
    note(&format!("{yes} plans, {no} without one, {known} with something known"));
    assert!(yes > 3 && known > 3, "{yes} plans, {no} without one, {known} with something known");
}
