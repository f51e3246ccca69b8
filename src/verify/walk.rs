//! The program carried out once more with everything it has laid down standing in the way.
//!
//! A move at a fixed pose is taken as the box of the tip's places at its lowest height; where that box is not
//! proved free the move is halved, down to pieces so short that what remains is no artefact of the box.

mod head;

use std::collections::HashSet;

use super::Planned;
use super::ReplayJob;
use super::acts::{Acts, Blind, Go, Kind, Stroke, Turn};
use super::astray::{as_planned, is_astray};
use super::depth::{DEEPEST_MM, Depth};
use super::evidence::{Checked, Evidence, Figures};
use super::field::Field;
use super::floor::Floor;
use super::hull::Hull;
use super::ledges::UnsupportedGap;
use super::material::Material;
use super::near::{Near, TipWay};
use super::report::{CLEARANCE_CAP_MM, FindingPlace, Findings, NearestApproach, Rule};
use super::support::Laying;
use super::swivelling::{Swivelling, head_at};
use super::turning::{ROOM_MM, Turning};
use crate::geom::{Bounds, Machine, Rigid, Table, Vec3};
use crate::motion::{Pose, TableKinematics};
use crate::planning::{PIECE_MM, contact_mm};
use crate::profile::Profile;
use head::Run;

/// The shortest piece of a move by which the nozzle, mm, and the rest of the head are judged.
const FINEST_MM: [f64; 2] = [PIECE_MM, 0.5];

/// What the table's turns may cost, in turns: no plan needs more. Each is held against all that stands; a pose at which the tip moves
/// takes a field of all that stands, which is as dear as so many.
const TURNS: usize = 1000;
const TURNS_A_PRINT: usize = 256;
const TURNS_A_FIELD: usize = 16;

/// So many collisions of the head are found, in a short program one for so many moves; how often it strikes beyond that tells nobody more, and each
/// is dear.
const STRIKES: [usize; 2] = [20, 1000];
const MOVES_A_STRIKE: usize = 20;

/// How deep the nozzle may be in the table, mm: what the last digits of a program's words come to.
const INTO_TABLE_MM: f64 = 0.005;

/// How far the table's upward direction may be from the machine's, as the distance of the unit vectors, on a level table.
pub(super) const LEVEL: f64 = 3.5e-4;

/// What the walk found.
struct Walked {
    findings: Findings,
    clearance: f64,
    clearance_line: u32,
    clearance_at: Option<NearestApproach>,
    /// Places of the head that were compared with the field, and what was looked at for distances.
    steps: u64,
}

/// Walks through the program.
pub(super) fn check(&Evidence { acts, job, planned, .. }: &Evidence<'_>) -> Checked {
    let contact = contact_mm(job.profile);
    let hulls = |bodies: Vec<_>| bodies.into_iter().map(|b| Hull::new(b, contact)).collect();
    let mut walker = Walker {
        acts,
        planned,
        table: job.profile.kinematics(),
        profile: job.profile,
        head: hulls(job.profile.head_bodies()),
        fixed: hulls(job.profile.fixed_bodies()),
        contact,
        bridge_mm: job.profile.process.bridge_mm,
        slab_mm: job.profile.table.thickness_mm,
        beyond_table: Box::new(|x, y| job.profile.beyond_table(x, y) - job.profile.table.keep_out_mm),
        material: Material::new(job.profile.table_slab()),
        strangers: strangers(job, planned),
        bodies: several(job.workpiece.model.bodies()),
        on_table: &job.workpiece.model.on_table,
        as_planned: as_planned(&job.profile.kinematics(), planned),
        setup: None,
        pose: None,
        astray: false,
        turns: 0,
        most_turns: TURNS + TURNS_A_PRINT * planned.len(),
        strikes: 0,
        most_strikes: (acts.trace.len() / MOVES_A_STRIKE).clamp(STRIKES[0], STRIKES[1]),
        laying: Laying::new(job.profile.process.bridge_mm),
        depth: Depth::default(),
        walked: Walked {
            findings: Findings::default(),
            clearance: CLEARANCE_CAP_MM,
            clearance_line: 0,
            clearance_at: None,
            steps: 0,
        },
        print: None,
        runs: Vec::new(),
    };
    for m in acts.trace.moves() {
        if let Some(turn) = acts.turn(&m) {
            walker.turn(&turn);
        } else if acts.trace.has_new_pose(&m) {
            walker.is_at(acts.trace.state(&m).pose());
        }
        match acts.go(&m) {
            Some(Go::Blind(blind)) => walker.blind(&blind, m.index),
            Some(Go::Stroke(stroke)) => walker.stroke(&stroke, m.index),
            None => {}
        }
    }
    walker.rest(acts.trace.lines);
    let Walked { findings, clearance, clearance_line: line, clearance_at: at, steps } = walker.walked;
    Checked { findings, figures: Figures::Clearance { mm: clearance, line, at, steps } }
}

/// For each print, the others that its part shares no face with; supports stand on what grows beside them, and close to it.
pub(super) fn strangers(job: &ReplayJob<'_>, planned: &[Planned]) -> Vec<Vec<bool>> {
    let joined: HashSet<(usize, usize)> = job.workpiece.model.interfaces.iter().map(|one| (one.a, one.b)).collect();
    let apart = |a: usize, b: usize| a != b && !joined.contains(&(a.min(b), a.max(b)));
    let holds =
        |one: &Planned, other: &Planned| one.setup == other.setup && (one.gap_mm.is_some() || other.gap_mm.is_some());
    let is_strange = |one: &Planned, other: &Planned| apart(one.part, other.part) && !holds(one, other);
    planned.iter().map(|one| planned.iter().map(|other| is_strange(one, other)).collect()).collect()
}

/// The bodies of several; none where all are one.
fn several(bodies: Vec<usize>) -> Vec<usize> {
    if bodies.iter().all(|body| *body == bodies[0]) { Vec::new() } else { bodies }
}

/// One pose, and what stands there.
struct Setup {
    field: Field,
    near: Near,
    back: Rigid<Machine, Table>,
    /// Whether the table is level.
    level: bool,
}

struct Walker<'a> {
    acts: &'a Acts<'a>,
    planned: &'a [Planned],
    table: TableKinematics,
    profile: &'a Profile,
    /// As the tool sees it at the pose that is set up.
    head: Vec<Hull>,
    fixed: Vec<Hull>,
    contact: f64,
    bridge_mm: f64,
    slab_mm: f64,
    beyond_table: Box<dyn Fn(f64, f64) -> f64 + 'a>,
    material: Material,
    /// By print, which others it neither stands on nor carries.
    strangers: Vec<Vec<bool>>,
    /// By part, the body that it is of; empty where there is one.
    bodies: Vec<usize>,
    /// Parts that stand on the table.
    on_table: &'a [usize],
    /// By print, the way back from the machine's frame at the plan's pose.
    as_planned: Vec<Rigid<Machine, Table>>,
    setup: Option<Setup>,
    pose: Option<Pose>,
    /// Whether something is printed at this pose that belongs to another one.
    astray: bool,
    /// What the table's turns have cost, and what they may before nobody follows any more.
    turns: usize,
    most_turns: usize,
    /// How often the head has struck.
    strikes: usize,
    most_strikes: usize,
    laying: Laying,
    depth: Depth,
    walked: Walked,
    print: Option<u32>,
    runs: Vec<Run>,
}

impl Walker<'_> {
    fn place(&self, line: u32) -> FindingPlace {
        let print = self.print.map(|p| &self.planned[p as usize]);
        FindingPlace { line, slot: print.map(|p| p.slot), part: print.map(|p| p.part) }
    }

    /// The air that a part has below it on its supports, mm.
    fn gap_below(&self, print: &Planned) -> f64 {
        let its = self.planned.iter().filter(|other| other.part == print.part);
        its.filter_map(|other| other.gap_mm).fold(0.0, f64::max)
    }

    fn stroke(&mut self, stroke: &Stroke, from: usize) {
        if stroke.print != self.print {
            self.end_print();
            self.print = stroke.print;
            let planned = self.print.map(|print| &self.planned[print as usize]);
            let air = planned.map_or(0.0, |print| print.gap_mm.unwrap_or_else(|| self.gap_below(print)));
            self.laying.with_supports(air, planned.is_some_and(|print| print.gap_mm.is_some()));
            let body = planned.and_then(|print| self.bodies.get(print.part));
            self.laying.with_body(body.map(|body| *body as u32));
        }
        self.set_up(from);
        if self.astray {
            return self.lay_as_planned(stroke);
        }
        let Some(mut setup) = self.setup.take() else {
            let within = Bounds::of([stroke.from, stroke.to]);
            self.over_the_ball(&Blind { within, line: stroke.line });
            return;
        };
        self.check_table(&setup, stroke);
        self.passes(&mut setup, from);
        let strikes = self.strikes;
        self.sweep(&mut setup, [stroke.from, stroke.to], stroke.line, FINEST_MM);
        self.check_depth(stroke, from, self.strikes > strikes);
        let mut gaps = Vec::new();
        match stroke.kind {
            Kind::Travel => self.laying.end(&mut setup.field, &mut gaps),
            Kind::Print => {
                self.laying.lay(stroke, &mut setup.field, &mut gaps);
                self.material.lay(stroke, &setup.back);
            }
        }
        self.setup = Some(setup);
        self.tell(gaps);
    }

    /// A line at a wrong pose: see [`astray`](super::astray).
    fn lay_as_planned(&mut self, stroke: &Stroke) {
        if let (Kind::Print, Some(print)) = (stroke.kind, stroke.print) {
            self.material.lay(stroke, &self.as_planned[print as usize]);
        }
    }

    /// The nozzle below the table's surface: there is nothing soft to give way. On a level table it is the tip that is lowest, on a tilted
    /// one the rim of its flat.
    fn check_table(&mut self, setup: &Setup, stroke: &Stroke) {
        let deepest =
            if setup.level { self.tip_in_table(&setup.back, stroke) } else { self.rim_in_table(setup, stroke) };
        if deepest <= INTO_TABLE_MM {
            return;
        }
        if self.note(-deepest, stroke.line) {
            let low = setup.back.point(stroke.to.into()).at;
            let at = |z: f64| [low.x, low.y, z].map(|v| (v * 1e4).round() / 1e4);
            self.walked.clearance_at = Some(NearestApproach { head_mm: at(-deepest), other_mm: at(0.0), share: 1.0 });
        }
        let (at, what) = (self.place(stroke.line), if setup.level { "tip" } else { "rim of the nozzle" });
        self.walked.findings.add(Rule::HeadCollision, at, [deepest, INTO_TABLE_MM], || {
            format!("the {what} is {deepest:.3} mm inside the table (maximum {INTO_TABLE_MM} mm)")
        });
    }

    /// A travel through what its own print has laid; where it `strikes` that has been said.
    fn check_depth(&mut self, stroke: &Stroke, index: usize, strikes: bool) {
        let Some(deep) = self.depth.take(self.acts, stroke, index, self.pose) else { return };
        if strikes || self.strikes >= self.most_strikes {
            return;
        }
        self.strikes += 1;
        self.note(-deep, stroke.line);
        let at = self.place(stroke.line);
        self.walked.findings.add(Rule::HeadCollision, at, [deep, DEEPEST_MM], || {
            format!("the nozzle travels {deep:.3} mm deep through printed material (maximum {DEEPEST_MM} mm)")
        });
    }

    fn tip_in_table(&self, back: &Rigid<Machine, Table>, stroke: &Stroke) -> f64 {
        let points = [stroke.from, (stroke.from + stroke.to) * 0.5, stroke.to];
        let depth = |p: Vec3| {
            let at = back.point(p.into()).at;
            if (self.beyond_table)(at.x, at.y) < 0.0 { -at.z } else { 0.0 }
        };
        let deepest = points.into_iter().map(depth).fold(0.0, f64::max);
        if deepest < self.slab_mm { deepest } else { 0.0 }
    }

    /// How far the piece that carries the tip has to be raised from the table, mm; up to the depth that the field is asked for.
    fn rim_in_table(&self, setup: &Setup, stroke: &Stroke) -> f64 {
        let ends = [stroke.from, stroke.to];
        let lowest = |hull: &Hull| {
            let below = hull.body.points.iter().map(|p| (setup.back.rotation * p).z).fold(0.0, f64::min);
            ends.map(|tip| setup.back.point(tip.into()).at.z + below).into_iter().fold(f64::INFINITY, f64::min)
        };
        let away = setup.back.inverse().rotation * Vec3::z();
        let of_hull = |hull: &Hull| {
            let meets = |mm: f64| setup.near.meets_table(hull, &TipWay::Line(ends.map(|tip| tip + away * mm)));
            if lowest(hull) >= 0.0 || !meets(INTO_TABLE_MM) {
                return 0.0;
            }
            let (mut low, mut high) = (INTO_TABLE_MM, self.contact.max(2.0 * INTO_TABLE_MM));
            while high - low > INTO_TABLE_MM / 2.0 {
                let middle = f64::midpoint(low, high);
                if meets(middle) { low = middle } else { high = middle }
            }
            high
        };
        self.head.iter().filter(|hull| hull.tip).map(of_hull).fold(0.0, f64::max)
    }

    fn blind(&mut self, blind: &Blind, from: usize) {
        self.end_line();
        self.set_up(from);
        match self.setup.take() {
            None if self.astray => {}
            None => self.over_the_ball(blind),
            Some(mut setup) => {
                // The tip may be anywhere in the box, so there is nothing to halve.
                let ends = [blind.within.min, blind.within.max];
                self.sweep(&mut setup, ends, blind.line, [f64::INFINITY; 2]);
                self.setup = Some(setup);
            }
        }
    }

    /// The table stands at another pose, and has not turned there.
    fn is_at(&mut self, pose: Option<Pose>) {
        self.leave();
        self.pose = pose;
        (self.print, self.astray) = (None, false);
    }

    fn turn(&mut self, turn: &Turn) {
        self.is_at(turn.to);
        if !self.follows(1, turn.line) {
            return;
        }
        let cap = self.walked.clearance.max(ROOM_MM);
        let passage = match Swivelling::of(self.profile, &self.table) {
            Some(swivelling) => swivelling.passage(turn, &mut self.material, cap),
            None => {
                let turning = Turning { table: &self.table, head: &self.head, fixed: &self.fixed };
                turning.passage(turn, &mut self.material, cap)
            }
        };
        let at = FindingPlace { line: turn.line, slot: turn.slot, part: None };
        let turner = self.table.turner();
        let Some(passage) = passage else {
            self.walked.findings.add(Rule::TurnCollision, at, [0.0, ROOM_MM], || {
                format!("the {turner} turns from an unknown angle, or with the head at an unknown height, so collisions cannot be ruled out")
            });
            return;
        };
        self.note(passage.room, turn.line);
        if passage.room < ROOM_MM {
            let (piece, room) = (passage.piece, passage.room);
            self.walked.findings.add(Rule::TurnCollision, at, [room, ROOM_MM], || {
                format!("while the {turner} turns, the {piece} comes within {room:.2} mm of the table or the print (minimum {ROOM_MM} mm)")
            });
        }
    }

    /// Whether so many turns more are followed. Where they are too many that is said once, and from there on nothing is held against what
    /// stands.
    fn follows(&mut self, turns: usize, line: u32) -> bool {
        let before = self.turns;
        self.turns += turns;
        let [is, was] = [self.turns, before].map(|turns| turns <= self.most_turns);
        if was && !is {
            let (at, most, turner) = (self.place(line), self.most_turns, self.table.turner());
            self.walked.findings.add(Rule::Sequence, at, [self.turns as f64, most as f64], || {
                let prints = self.planned.len();
                format!("the {turner} turns more than {most} times, far more often than {prints} prints need; collisions and support are not checked from here on")
            });
        }
        is
    }

    /// After the last move: the frame against what was printed since the last turn.
    fn rest(&mut self, line: u32) {
        self.leave();
        let Some(pose) = self.pose else { return };
        let turning = Turning { table: &self.table, head: &self.head, fixed: &self.fixed };
        let passage = turning.standing(pose, &mut self.material);
        if passage.room < ROOM_MM {
            let (at, room) = (self.place(line), passage.room);
            self.walked.findings.add(Rule::TurnCollision, at, [room, ROOM_MM], || {
                format!("the {} is within {room:.2} mm of the print (minimum {ROOM_MM} mm)", passage.piece)
            });
        }
    }

    /// Makes the field for the pose, if it is known, not astray and not made yet: move `from` is the first at it.
    fn set_up(&mut self, from: usize) {
        let (None, Some(pose), false) = (&self.setup, self.pose, self.astray) else { return };
        self.astray = is_astray(self.acts.trace, &self.table, self.planned, from, pose);
        let line = self.acts.trace.at(from).line;
        self.astray = self.astray || !self.follows(TURNS_A_FIELD, line);
        if self.astray {
            return;
        }
        let motion = self.table.forward(pose);
        if self.table.head.is_some() {
            self.head = head_at(self.profile, pose);
        }
        let trace = self.acts.trace;
        let here = (from..trace.len()).map(|i| trace.at(i));
        let here = here.take_while(|m| m.index == from || !trace.has_new_pose(m));
        let ways: Vec<[Vec3; 2]> = here
            .filter_map(|m| match self.acts.go(&m)? {
                Go::Stroke(stroke) => Some([stroke.from, stroke.to]),
                Go::Blind(blind) => Some([blind.within.min, blind.within.max]),
            })
            .collect();
        let tips = Bounds::of(ways.iter().flatten().copied());
        // Where nothing is laid yet there is nothing to leave out.
        let floor = (!self.material.beads().is_empty()).then(|| {
            let mut floor = Floor::new(&tips.inflated(self.reach()));
            ways.iter().for_each(|way| floor.goes(*way));
            floor.settle(&self.head, self.walked.clearance.max(0.0));
            floor
        });
        self.setup = Some(Setup {
            field: self.material.field(&motion, &tips, floor.as_ref()),
            near: Near::new(motion, &self.material, self.head.len()),
            back: motion.inverse(),
            level: (motion.rotation * Vec3::z() - Vec3::z()).norm() < LEVEL,
        });
    }

    /// How far from the tip any piece of the head is felt, mm.
    fn reach(&self) -> f64 {
        let far = |h: &Hull| [h.bounds.min.x, h.bounds.max.x, h.bounds.min.y, h.bounds.max.y].map(f64::abs);
        self.head.iter().flat_map(far).fold(0.0, f64::max) + self.walked.clearance.max(0.0) + 10.0
    }

    /// The setup ends here.
    fn leave(&mut self) {
        self.end_print();
        if let Some(mut setup) = self.setup.take() {
            self.apart(&mut setup);
            self.walked.steps += setup.near.looked_at();
        }
    }

    fn end_print(&mut self) {
        self.end_line();
        let mut gaps = Vec::new();
        self.laying.settle(&mut gaps);
        self.tell(gaps);
    }

    fn end_line(&mut self) {
        let mut gaps = Vec::new();
        match &mut self.setup {
            Some(setup) => self.laying.end(&mut setup.field, &mut gaps),
            None => self.laying = Laying::new(self.bridge_mm),
        }
        self.tell(gaps);
    }

    fn tell(&mut self, gaps: Vec<UnsupportedGap>) {
        for gap in gaps {
            let print = gap.stroke.print.map(|p| &self.planned[p as usize]);
            let at = FindingPlace { line: gap.stroke.line, slot: print.map(|p| p.slot), part: print.map(|p| p.part) };
            self.walked.findings.add(Rule::InAir, at, [gap.length, gap.allowed], || {
                let (held, key) = match gap.held {
                    [true, true] if gap.as_rim > 0.0 => ("along a ledge", ""),
                    [true, true] if gap.allowed < self.bridge_mm => ("with a bend between two ends on material", ""),
                    [true, true] => ("between two ends on material", ", [process] bridge_mm"),
                    [false, false] => ("with neither end on material", ""),
                    _ => ("with one end in the air", ""),
                };
                format!(
                    "{:.2} mm of a line is printed in mid-air {held} (maximum {:.1} mm{key})",
                    gap.length, gap.allowed
                )
            });
        }
    }

    /// Whether that is the least so far; where it is, is not known then.
    fn note(&mut self, room: f64, line: u32) -> bool {
        let least = room < self.walked.clearance;
        if least {
            (self.walked.clearance, self.walked.clearance_line, self.walked.clearance_at) = (room, line, None);
        }
        least
    }

    /// A move at an unknown pose must be above everything at whatever pose.
    fn over_the_ball(&mut self, blind: &Blind) {
        let room = match Swivelling::of(self.profile, &self.table) {
            Some(swivelling) => swivelling.room_anywhere(blind.within.min.z, &self.material),
            None => {
                let turning = Turning { table: &self.table, head: &self.head, fixed: &self.fixed };
                turning.lowest(blind.within.min.z) - turning.ball_top(&self.material)
            }
        };
        if room < 0.0 {
            let at = self.place(blind.line);
            self.walked.findings.add(Rule::HeadCollision, at, [room, 0.0], || {
                format!(
                    "the {}'s angle is unknown, and the head is {:.2} mm too low to clear the table and the print at every angle",
                    self.table.turner(),
                    -room
                )
            });
        }
    }
}
