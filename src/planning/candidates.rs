//! The orientations a part may be printed in: directions, merged by machine setup, and what stands against each.

use std::sync::Arc;

use super::collision::Head;
use super::infeasible::Hanging;
use super::options::Options;
use super::owed::{Owed, TOUCHING_MM};
use super::solid::Solid;
use super::support::Needs;
use super::workpiece::Workpiece;
use crate::gcode::round_to;
use crate::geom::{Angle, Dir, Machine, Rigid, Table, Vec3};
use crate::motion::{AxisRange, Pose, TableKinematics};
use crate::orient::{Direction, Facets, Objective, Search, directions};
use crate::profile::Profile;

/// One way to print one part that nothing but other parts stands against.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The build direction.
    pub up: Dir<Table>,
    /// The pose that brings it upright, rotation in (-180, 180] degrees.
    pub pose: Pose,
    /// Which setup that is, the same number for the same pose.
    pub setup: usize,
    /// The objective there.
    pub value: f64,
    pub(super) needs: Needs,
}

/// What rules an orientation out, whatever the order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Barrier {
    /// It would overhang or begin in the air even if all other parts stood.
    Support,
    /// No axis reaches the pose.
    Reach,
    /// The tip would leave X, Y or Z.
    Limits,
    /// The head would meet the table.
    Table,
    /// The head, the part or the table would meet the machine's frame.
    Frame,
}

/// One thing against one orientation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Objection {
    pub(super) against: Barrier,
    /// In words.
    pub(super) text: String,
    /// How deep the head would reach in, mm; 0 where it is no collision.
    pub(super) depth_mm: f64,
}

/// A direction at one of its poses, with what stands against it.
#[derive(Clone, Debug)]
pub(super) struct PrintWay {
    pub(super) up: Dir<Table>,
    pub(super) pose: Pose,
    pub(super) value: f64,
    pub(super) needs: Needs,
    /// What hangs, where layers were looked at.
    pub(super) hangs: Option<Hanging>,
    /// The first objection, unless all were asked for.
    pub(super) objections: Vec<Objection>,
}

/// Directions that differ by less than this (radians, 0.02 degrees) are one setup: 0.04 mm over 100 mm, a tenth of a line.
const SAME_SETUP: f64 = 3.5e-4;

/// Which objections to a way are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Told {
    /// The first.
    First,
    /// All.
    All,
    /// Whether the part would stand, and an axis reaches the pose.
    Standing,
}

/// The model on the machine, and the poses in use.
pub(super) struct Setups<'a> {
    pub(super) workpiece: &'a Workpiece<'a>,
    pub(super) profile: &'a Profile,
    pub(super) table: TableKinematics,
    pub(super) head: Arc<Head>,
    built: Arc<Head>,
    pub(super) options: &'a Options<'a>,
    /// By part, on the table.
    pub(super) solids: Vec<Solid>,
    pub(super) slab: Solid,
    /// The poses, by setup number.
    pub(super) poses: Vec<(Dir<Table>, Pose)>,
}

/// A part's candidates and what was turned down.
pub(super) struct Sifted {
    pub(super) candidates: Vec<Candidate>,
    /// With at least one objection each.
    pub(super) rejected: Vec<PrintWay>,
    pub(super) tried: usize,
}

/// The directions to try for every part, in parallel.
pub(super) fn all_directions(workpiece: &Workpiece<'_>, f: &dyn Objective, search: &dyn Search) -> Vec<Vec<Direction>> {
    use rayon::prelude::*;
    (0..workpiece.parts.len())
        .into_par_iter()
        .map(|part| {
            let mut also: Vec<Vec3> = vec![Vec3::z()];
            for interface in &workpiece.model.interfaces {
                if interface.a == part || interface.b == part {
                    also.push(workpiece.placed.rotation * interface.normal);
                }
            }
            directions(&Facets::of(&workpiece.parts[part]), &also, f, search)
        })
        .collect()
}

/// Steps of tilt of [`fan`], degrees.
const FAN_DEG: usize = 5;
/// Of a part's own directions so many give a heading to [`fan`].
const FAN_OWN: usize = 4;

/// The cosine of 2 degrees: headings nearer than that are one.
const SAME_HEADING: f64 = 0.9994;

/// Directions of a part that touches another, beside those that were `found` for it: the table tilted by each multiple of 5 degrees towards each
/// of its seams and its best directions, or away from them. Between two minima of an objective lies what neither of them gives: a branch that
/// leans by 45 degrees has the nozzle's rim in its post along its own axis, and is printed well 15 degrees beside it.
pub(super) fn fan(workpiece: &Workpiece<'_>, part: usize, f: &dyn Objective, found: &[Direction]) -> Vec<Direction> {
    let seams = workpiece.model.interfaces.iter().filter(|seam| seam.a == part || seam.b == part);
    let seams: Vec<Vec3> = seams.map(|seam| workpiece.placed.rotation * seam.normal).collect();
    if seams.is_empty() {
        return Vec::new();
    }
    let own = found.iter().take(FAN_OWN).map(|direction| direction.up);
    let mut headings: Vec<[f64; 2]> = Vec::new();
    for along in seams.into_iter().chain(own) {
        let level = along.x.hypot(along.y);
        if level < 1e-6 {
            continue;
        }
        for [x, y] in [[along.x / level, along.y / level], [-along.x / level, -along.y / level]] {
            if headings.iter().all(|known| known[0] * x + known[1] * y < SAME_HEADING) {
                headings.push([x, y]);
            }
        }
    }
    let tilts = (FAN_DEG..=90).step_by(FAN_DEG).map(|deg| (deg as f64).to_radians().sin_cos());
    let facets = Facets::of(&workpiece.parts[part]);
    let all = tilts.flat_map(|(s, c)| headings.iter().map(move |[x, y]| Vec3::new(s * x, s * y, c)));
    all.map(|up| Direction { up, value: f.value(&facets, &up) }).collect()
}

/// A machine's head with its upward reach and without, for whoever asks more than once.
#[derive(Clone, Debug)]
pub(super) struct Heads {
    reaching: Arc<Head>,
    built: Arc<Head>,
}

impl Heads {
    pub(super) fn of(profile: &Profile) -> Self {
        Self { reaching: Arc::new(Head::of(profile)), built: Arc::new(Head::as_built(profile)) }
    }
}

impl<'a> Setups<'a> {
    pub(super) fn new(workpiece: &'a Workpiece<'a>, profile: &'a Profile, options: &'a Options<'a>) -> Self {
        Self::of_heads(&Heads::of(profile), workpiece, profile, options)
    }

    /// The same for heads of `profile` that are there already.
    pub(super) fn of_heads(
        heads: &Heads,
        workpiece: &'a Workpiece<'a>,
        profile: &'a Profile,
        options: &'a Options<'a>,
    ) -> Self {
        use rayon::prelude::*;
        let slab = profile.table_slab().iter().map(|p| p - Vec3::z() * options.pedestal_mm).collect();
        Self {
            workpiece,
            profile,
            table: profile.kinematics(),
            head: heads.reaching.clone(),
            built: heads.built.clone(),
            options,
            solids: workpiece.parts.par_iter().map(Solid::of).collect(),
            slab: Solid::hull(slab),
            poses: Vec::new(),
        }
    }

    /// The candidates of `part` among `tried`.
    pub(super) fn choose(&mut self, part: usize, tried: &[Direction]) -> Sifted {
        let mut sifted = Sifted { candidates: Vec::new(), rejected: Vec::new(), tried: tried.len() };
        for way in self.ways(part, tried, Told::First) {
            if !way.objections.is_empty() {
                sifted.rejected.push(way);
                continue;
            }
            let setup = self.setup(way.up, way.pose);
            let PrintWay { up, pose, value, needs, .. } = way;
            sifted.candidates.push(Candidate { up, pose, setup, value, needs });
        }
        sifted
    }

    /// Every direction of `tried` at each of its poses, with the objections that are to be told.
    pub(super) fn ways(&self, part: usize, tried: &[Direction], told: Told) -> Vec<PrintWay> {
        use rayon::prelude::*;
        let neighbours = self.options.known.neighbours(self.workpiece, part);
        let mut known: Vec<(Dir<Table>, f64)> = Vec::new();
        for direction in tried {
            let Some(up) = Dir::new(direction.up) else { continue };
            let up = self.merged(up);
            if known.iter().all(|(k, _)| (k.unit() - up.unit()).norm() >= SAME_SETUP) {
                known.push((up, direction.value));
            }
        }
        let poses = |up: Dir<Table>| self.table.solutions(up, Pose::LEVEL);
        // Layers cost something, so only what an axis reaches is looked at by them. What stands on the table and is printed on a slant
        // begins in an edge along it, and slicers make nothing of its first wedges (PrusaSlicer lays them twice).
        let reached = |up: Dir<Table>| poses(up).into_iter().any(|pose| self.out_of_reach(up, pose).is_none());
        let straight = |up: Dir<Table>| up.unit().z > 1.0 - 1e-9 || !self.workpiece.model.is_in_place(part);
        let by_layers = |up: Dir<Table>| self.options.practised && straight(up) && reached(up);
        let one =
            |&(up, value): &(Dir<Table>, f64)| (up, value, self.needs(part, &neighbours, up, by_layers(up), true));
        let mut found: Vec<(Dir<Table>, f64, Needs)> =
            if self.options.practised { known.par_iter().map(one).collect() } else { known.iter().map(one).collect() };
        let everyone = self.everyone();
        if told == Told::All && self.options.practised {
            self.look_closer(part, &neighbours, &mut found);
        }
        let way = |(up, value, needs): (Dir<Table>, f64, Needs)| {
            let unsupported = (!needs.met_by(&everyone)).then(|| Objection {
                against: Barrier::Support,
                text: self.hanging(&needs),
                depth_mm: 0.0,
            });
            let posed = |pose: Pose| {
                let mut objections: Vec<Objection> = unsupported.iter().cloned().collect();
                match told {
                    Told::Standing => objections.extend(self.reach_objects(up, pose)),
                    Told::All => self.machine_objects(part, up, pose, true, &mut objections),
                    Told::First if objections.is_empty() => {
                        self.machine_objects(part, up, pose, false, &mut objections);
                    }
                    Told::First => {}
                }
                PrintWay { up, pose, value, needs: needs.clone(), hangs: self.hangs(&needs), objections }
            };
            let poses = poses(up);
            if poses.is_empty() {
                // Axes that are not square bring it upright nowhere; it is told as it would stand on the level table.
                let objections = unsupported.iter().cloned().chain(self.reach_objects(up, Pose::LEVEL)).collect();
                return vec![PrintWay { up, pose: Pose::LEVEL, value, hangs: self.hangs(&needs), needs, objections }];
            }
            poses.into_iter().map(posed).collect::<Vec<PrintWay>>()
        };
        let ways: Vec<Vec<PrintWay>> = found.into_par_iter().map(way).collect();
        ways.into_iter().flatten().collect()
    }

    /// What the machine has against printing `part` at `pose`: an axis' reach, stops, the table or the frame.
    pub(super) fn machine_objects(
        &self,
        part: usize,
        up: Dir<Table>,
        pose: Pose,
        all: bool,
        objections: &mut Vec<Objection>,
    ) {
        let enough = |objections: &Vec<Objection>| !all && !objections.is_empty();
        objections.extend(self.reach_objects(up, pose));
        let checks = [Self::leaves_limits, Self::meets_table, Self::meets_frame];
        for check in checks {
            if enough(objections) {
                return;
            }
            objections.extend(check(self, part, pose));
        }
    }

    fn reach_objects(&self, up: Dir<Table>, pose: Pose) -> Option<Objection> {
        let text = self.out_of_reach(up, pose)?;
        Some(Objection { against: Barrier::Reach, text, depth_mm: 0.0 })
    }

    fn out_of_reach(&self, up: Dir<Table>, pose: Pose) -> Option<String> {
        if self.table.solutions(up, Pose::LEVEL).is_empty() {
            return self.table.upright(up, Pose::LEVEL).err().map(|unreachable| unreachable.to_string());
        }
        if !self.table.tilt.admits(pose.tilt) {
            // The other pose may be within reach; the sentence names the stop that this direction comes nearest to.
            return Some(match self.table.upright(up, Pose::LEVEL) {
                Err(unreachable) => unreachable.to_string(),
                Ok(_) => {
                    let word = self.table.tilt.word_of(pose.tilt).deg();
                    beyond(&self.table.tilt, word)
                }
            });
        }
        let turn = Angle::from_deg(360.0);
        let reachable = [pose.rotation, pose.rotation + turn, pose.rotation - turn];
        (!reachable.into_iter().any(|r| self.table.rotation.admits(r))).then(|| {
            let word = self.table.rotation.word_of(pose.rotation).deg();
            beyond(&self.table.rotation, word)
        })
    }

    fn leaves_limits(&self, part: usize, pose: Pose) -> Option<Objection> {
        let limits = self.profile.linear_limits();
        let reached = self.solids[part].reached(&self.table.axes(pose));
        let out = [reached.min, reached.max].into_iter().find_map(|corner| limits.violation(&corner))?;
        Some(Objection { against: Barrier::Limits, text: out.to_string(), depth_mm: 0.0 })
    }

    fn meets_table(&self, part: usize, pose: Pose) -> Option<Objection> {
        let (motion, head) = (self.table.forward(pose), self.head.at(pose));
        let (solid, owed) = (&self.solids[part], self.owed_to_table(part, &motion));
        let offence = head.offence(&motion, solid, &self.slab, &owed, 0.0)?;
        let depth_mm = head.depth(&motion, solid, &self.slab, &owed);
        let text = if offence.mm > 0.0 {
            format!(
                "the {} would clear the table by only {:.1} mm (required: {:.1} mm)",
                offence.piece, offence.mm, owed.rest.mm
            )
        } else {
            format!("the {} would reach {depth_mm:.1} mm into the table", offence.piece)
        };
        Some(Objection { against: Barrier::Table, text, depth_mm })
    }

    /// What the head that prints `part` owes the table.
    pub(super) fn owed_to_table(&self, part: usize, motion: &Rigid<Table, Machine>) -> Owed {
        let low = self.solids[part].points().iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let level = (motion.rotation * Vec3::z() - Vec3::z()).norm() < SAME_SETUP;
        Owed::to_table(self.profile, self.options.margin_mm, low + self.options.pedestal_mm, level)
    }

    fn meets_frame(&self, part: usize, pose: Pose) -> Option<Objection> {
        let motion = self.table.forward(pose);
        let back = motion.inverse();
        self.profile.fixed_bodies().into_iter().find_map(|body| {
            let frame = Solid::hull(body.points.iter().map(|p| back.rotation * p + back.translation).collect());
            let by = |what: &str, how: &str| {
                let text = format!("{what} would {how} the frame's {}", body.name);
                Some(Objection { against: Barrier::Frame, text, depth_mm: 0.0 })
            };
            // How near the table comes to the frame is the machine's own affair; what is printed keeps the margin, and so does the head.
            let margin = self.options.margin_mm.max(TOUCHING_MM);
            let within =
                if margin > TOUCHING_MM { format!("come within {margin:.2} mm of") } else { "meet".to_owned() };
            let nearer = |moving: &Solid, than: f64| {
                moving.swept_clearance(&motion, [true; 3], &[Vec3::zeros()], &frame, than).distance() < than
            };
            if nearer(&self.slab, TOUCHING_MM) {
                return by("the table", "meet");
            }
            if nearer(&self.solids[part], margin) {
                return by("the part", &within);
            }
            let hull = Solid::hull(self.solids[part].points().to_vec());
            let clearance = self.built.clearance(&motion, &hull, &frame, 0.0, margin);
            if clearance.mm < margin { by(&format!("the {}", clearance.piece), &within) } else { None }
        })
    }

    /// `up`, or the direction of a known setup that is the same.
    fn merged(&self, up: Dir<Table>) -> Dir<Table> {
        let known = self.poses.iter().map(|(known, _)| *known);
        known.into_iter().find(|known| (known.unit() - up.unit()).norm() < SAME_SETUP).unwrap_or(up)
    }

    /// The number of the setup with this direction and pose, a new one if there is none.
    pub(super) fn setup(&mut self, up: Dir<Table>, pose: Pose) -> usize {
        let same = |(known, at): &(Dir<Table>, Pose)| known == &up && at == &pose;
        self.poses.iter().position(same).unwrap_or_else(|| {
            self.poses.push((up, pose));
            self.poses.len() - 1
        })
    }
}

/// The table's slab at a pose, machine coordinates.
pub fn table_solid(profile: &Profile, motion: &Rigid<Table, Machine>) -> Solid {
    Solid::hull(profile.table_slab().iter().map(|p| motion.rotation * p + motion.translation).collect())
}

/// That an axis does not accept `word`, degrees, in a sentence.
fn beyond(axis: &AxisRange, word: f64) -> String {
    let ends = |(low, high): (Angle, Angle)| [low, high].map(|end| round_to(end.deg(), 4));
    let [low, high] = axis.range.map_or([f64::NEG_INFINITY, f64::INFINITY], ends);
    format!("{}{word:.1} is beyond the axis range {low}..{high} deg", char::from(axis.letter))
}

/// Every way of a part waits for those that are demanded to come before.
pub(super) fn in_order(candidates: &mut [Vec<Candidate>], options: &Options<'_>) {
    for (part, ways) in candidates.iter_mut().enumerate() {
        let before = options.before(part);
        ways.iter_mut().for_each(|way| way.needs = way.needs.clone().behind(before.clone()));
    }
}
