//! Whether one solid can be printed onto another along a given direction: yes or no, without directions to look for, reasons or
//! remedies. For whoever cuts a model and asks a thousand times.

use super::candidates::{Heads, Setups};
use super::goal::Goal;
use super::options::Options;
use super::planner::plan;
use super::site::Site;
use super::solid::Solid;
use super::workpiece::Workpiece;
use crate::geom::{Angle, Bounds, Dir, Object, Rigid, Table, Vec3};
use crate::mesh::{Model, Part, TriangleMesh, Unit};
use crate::motion::Pose;
use crate::orient::{Direction, Multistart, ObjectiveSettings, Staircase};
use crate::planning::plan::Placement;
use crate::profile::Profile;

/// A machine with a model's place on its table.
#[derive(Clone, Debug)]
pub struct OnePrint<'a> {
    /// The machine.
    pub profile: &'a Profile,
    /// Where the model stands.
    pub placement: Placement,
    /// Surfaces up to this angle from the vertical need no support.
    pub overhang: Angle,
    /// As [`Options::steepest`].
    pub steepest: Option<Angle>,
    /// As [`Options::droops`].
    pub droops: bool,
    /// Room the head keeps from what it does not print on, mm.
    pub margin_mm: f64,
    /// So far the model stands above the table, mm.
    pub pedestal_mm: f64,
    heads: Heads,
}

impl<'a> OnePrint<'a> {
    /// A model placed on the table of `profile`: overhangs up to `overhang` need no support, the head keeps `margin_mm` from what it does
    /// not print on, and the model stands on nothing.
    pub fn new(profile: &'a Profile, placement: Placement, overhang: Angle, margin_mm: f64) -> Self {
        let heads = Heads::of(profile);
        Self { profile, placement, overhang, steepest: None, droops: true, margin_mm, pedestal_mm: 0.0, heads }
    }

    /// Whether an axis brings `up` upright.
    pub fn reaches(&self, up: &Vec3) -> bool {
        let up = Dir::<Table>::new(self.placed().rotation * up);
        up.is_some_and(|up| self.profile.kinematics().upright(up, Pose::LEVEL).is_ok())
    }

    fn placed(&self) -> Rigid<Object, Table> {
        let turn = crate::motion::rotation_z(Angle::from_deg(self.placement.turn_deg));
        Rigid::new(turn, Vec3::from(self.placement.origin_mm))
    }

    /// Whether `piece` can be printed along `up` while all of `standing` is there (nothing, where that is `None`): axes, stops,
    /// the table, the frame, and the room that the head owes what stands. `up` is in the model file's frame.
    pub fn allows(&self, piece: &TriangleMesh<Object>, up: &Vec3, standing: Option<&TriangleMesh<Object>>) -> bool {
        let meshes: Vec<TriangleMesh<Object>> = std::iter::once(piece).chain(standing).cloned().collect();
        let bounds = meshes.iter().fold(Bounds::EMPTY, |all, mesh| all.union(&mesh.bounds()));
        let part = |(id, mesh)| Part { id, name: String::new(), mesh };
        let parts: Vec<Part> = meshes.into_iter().enumerate().map(part).collect();
        // Who touches whom does not matter for one print, so nobody looks for interfaces.
        let (interfaces, warnings, on_table) = (Vec::new(), Vec::new(), Vec::new());
        let (captive, others) = (Vec::new(), Vec::new());
        let model = Model { parts, interfaces, on_table, captive, unit: Unit::Millimetre, warnings, bounds, others };
        let workpiece = Workpiece::place(&model, &self.placement);
        let Some(up) = Dir::<Table>::new(workpiece.placed.rotation * up) else { return false };
        self.with_options(&[], |options| {
            let mut setups = Setups::of_heads(&self.heads, &workpiece, self.profile, options);
            for pose in setups.table.solutions(up, Pose::LEVEL) {
                let mut objections = Vec::new();
                setups.machine_objects(0, up, pose, false, &mut objections);
                if objections.is_empty() {
                    setups.setup(up, pose);
                }
            }
            if setups.poses.is_empty() || standing.is_none() {
                return !setups.poses.is_empty();
            }
            let site = Site::of(&setups, self.margin_mm);
            (0..setups.poses.len()).any(|setup| !site.blocks(0, 1, setup))
        })
    }

    /// Whether the head can lay something at `place`, the lowest of what is printed along `up`, whatever stands: axes, stops, the table
    /// and the frame. Both are in the model file's frame. What a place is refused, whatever has it is refused, too.
    pub fn allows_place(&self, place: &Vec3, up: &Vec3) -> bool {
        let (parts, bounds) = (Vec::new(), Bounds::of(std::iter::once(*place)));
        let (interfaces, warnings, on_table) = (Vec::new(), Vec::new(), Vec::new());
        let (captive, others) = (Vec::new(), Vec::new());
        let model = Model { parts, interfaces, on_table, captive, unit: Unit::Millimetre, warnings, bounds, others };
        let workpiece = Workpiece::place(&model, &self.placement);
        let Some(up) = Dir::<Table>::new(workpiece.placed.rotation * up) else { return false };
        let point = Solid::hull(vec![workpiece.placed.rotation * place + workpiece.placed.translation]);
        self.with_options(&[], |options| {
            let mut setups = Setups::of_heads(&self.heads, &workpiece, self.profile, options);
            setups.solids = vec![point];
            let objects = |pose: Pose| {
                let mut objections = Vec::new();
                setups.machine_objects(0, up, pose, false, &mut objections);
                !objections.is_empty()
            };
            !setups.table.solutions(up, Pose::LEVEL).into_iter().all(objects)
        })
    }

    /// Whether there is a plan for `model` with each part along its one direction of `ups`, the model file's frame. Parts of
    /// `supported` may overhang, those of `layered` are known not to: see [`Options::layered`]. A pedestal is one of its parts, and stands on
    /// the table.
    pub fn plans(&self, model: &Model, ups: &[Vec3], supported: &[usize], layered: &[usize]) -> bool {
        let [x, y, _] = self.placement.origin_mm;
        let placement = Placement { origin_mm: [x, y, -model.bounds.min.z], ..self.placement };
        let workpiece = Workpiece::place(model, &placement);
        let one = |up: &Vec3| vec![Direction { up: workpiece.placed.rotation * up, value: 0.0 }];
        let directions: Vec<Vec<Direction>> = ups.iter().map(one).collect();
        self.with_options(supported, |options| {
            let options = Options { pedestal_mm: 0.0, layered: layered.to_vec(), ..options.clone() };
            plan(&workpiece, self.profile, &directions, &options).is_ok()
        })
    }

    fn with_options<T>(&self, supported: &[usize], work: impl FnOnce(&Options<'_>) -> T) -> T {
        let layer_mm = self.profile.process.layer_height_mm;
        let settings = ObjectiveSettings { layer_mm, ..ObjectiveSettings::default() };
        let (objective, search) = (Staircase { layer_mm }, Multistart::default());
        let goal = Goal::parse("bss", &settings).expect("the usual goal");
        work(&Options {
            overhang: self.overhang,
            steepest: self.steepest,
            droops: self.droops,
            margin_mm: self.margin_mm,
            pedestal_mm: self.pedestal_mm,
            supported: supported.to_vec(),
            explain: false,
            ..Options::new(&goal, &objective, &search)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;
    use crate::geom::SplitMix64;
    use crate::planning::centred;
    use crate::profile::{resolve, shipped};

    /// What is asked of one place must never say no where the piece as a whole is allowed.
    #[test]
    fn what_is_refused_for_its_lowest_place_is_refused_whole() {
        let mut random = SplitMix64::seeded(7);
        let mut between = move |low: f64, high: f64| low + (high - low) * random.unit();
        let (mut refused, mut allowed) = (0, 0);
        for name in ["generic-ac", "open5x-prusa", "penta-trt-bc"] {
            let (file, text) = shipped(name).unwrap();
            let (profile, _) = resolve(file, text).unwrap();
            let model = Model::from_parts(vec![(
                "whole".to_owned(),
                solid_box(Vec3::new(-15.0, -15.0, 0.0), Vec3::new(15.0, 15.0, 60.0)),
            )]);
            let one = OnePrint::new(&profile, centred(&model, &profile).unwrap(), Angle::from_deg(45.0), 0.5);
            for _ in 0..120 {
                let low = Vec3::new(between(-15.0, 5.0), between(-15.0, 5.0), between(0.0, 40.0));
                let size = Vec3::new(between(1.0, 10.0), between(1.0, 10.0), between(1.0, 20.0));
                let piece: TriangleMesh<Object> = solid_box(low, low + size);
                let up = Vec3::new(between(-1.0, 1.0), between(-1.0, 1.0), between(0.0, 1.0)).normalize();
                let lowest = piece.vertices().iter().min_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
                let (place, whole) = (one.allows_place(lowest, &up), one.allows(&piece, &up, None));
                assert!(place || !whole, "{name}: {piece:?} along {up:?}");
                refused += usize::from(!place);
                allowed += usize::from(whole);
            }
        }
        assert!(refused > 20 && allowed > 20, "{refused} refused, {allowed} allowed: the pieces say nothing");
    }
}
