//! A plan pose by pose, or the reasons against one: what stands, what is new, the head's lower end, the table's axes.

use super::{BEFORE, HEAD, NEW, OVERHANG, STRUCK, SUPPORT, SUPPORT_WORD, TABLE, highest};
use crate::geom::{Angle, Body, Machine, Rigid, Table, Vec3};
use crate::mesh::{TABLE_GAP_MM, TriangleMesh};
use crate::motion::{Pose, TableKinematics};
use crate::planning::{Plan, Print, Reason, Workpiece};
use crate::profile::Profile;
use crate::view::{Arrow, Colour, Frame, Ghost, Hull, JOINT_COLOUR, Joint, Sheet, Side, Surface};

/// So much of the head above the tip is drawn, mm; in frames of reasons so much around it.
const HEAD_MM: f64 = 30.0;
const HEAD_SHOWN_MM: f64 = 60.0;
/// Most frames of a sheet of reasons.
const MOST_REASONS: usize = 6;
const FRAME: f64 = 320.0;
const COLUMNS: usize = 3;
/// Less overhanging area than this is not told, mm².
const TOLD_MM2: f64 = 0.5;
const TILT_ARROW: Colour = [0, 90, 60];
const TURN_ARROW: Colour = [120, 40, 130];
/// A longer turn is drawn as so much of one, degrees.
const LONGEST_ARC_DEG: f64 = 330.0;

/// What is drawn, and of what.
#[derive(Clone, Copy)]
pub(crate) struct Told<'a> {
    pub(crate) workpiece: &'a Workpiece<'a>,
    pub(crate) profile: &'a Profile,
    /// Surfaces up to this angle from the vertical hold themselves.
    pub(crate) overhang: Angle,
}

/// Supports: the part that they hold, and their surface.
pub(crate) type Supports = [(usize, TriangleMesh<Machine>)];

/// A frame for each pose of `plan` with its `supports`; `story` says below all frames what became of the model before.
pub(crate) fn plan_sheet(plan: &Plan, told: Told<'_>, supports: &Supports, story: Vec<String>) -> Sheet {
    let mut before: Vec<usize> = Vec::new();
    let mut frames = Vec::new();
    for slot in &plan.slots {
        for setup in slot.setups() {
            frames.push(told.setup(slot.id, &setup, &before, supports));
            before.extend(setup.iter().map(|p| p.part));
        }
    }
    let mut legend = vec![
        (NEW, "printed in this pose"),
        (BEFORE, "printed before"),
        (OVERHANG, "overhangs more than allowed"),
        (JOINT_COLOUR, "where new meets old"),
        (TABLE, "table"),
        (HEAD, "lower end of the head"),
    ];
    if !supports.is_empty() {
        legend.insert(1, SUPPORT_WORD);
    }
    let title = format!("A plan in {} poses of the table", frames.len());
    Sheet { title, side: FRAME, columns: COLUMNS, frames, legend, story }
}

/// For each part and each thing in its way the nearest miss: the table at that pose, the part in colour and, where the head would strike,
/// the head there.
pub(crate) fn reasons_sheet(reasons: &[Reason], told: Told<'_>) -> Sheet {
    let mut shown: Vec<(usize, &str)> = Vec::new();
    let mut frames = Vec::new();
    // The ways with the least against them come first.
    for reason in reasons {
        if frames.len() < MOST_REASONS && !shown.contains(&(reason.part, &reason.blocked_by)) {
            shown.push((reason.part, &reason.blocked_by));
            frames.push(told.reason(reason));
        }
    }
    let legend = vec![
        (NEW, "cannot be printed this way"),
        (STRUCK, "is in the way"),
        (BEFORE, "other parts"),
        (OVERHANG, "overhangs more than allowed"),
        (TABLE, "table"),
        (HEAD, "head, where it would strike"),
    ];
    Sheet { title: "Why there is no plan".to_owned(), side: FRAME, columns: COLUMNS, frames, legend, story: Vec::new() }
}

impl Told<'_> {
    fn table(&self) -> TableKinematics {
        self.profile.kinematics()
    }

    fn name(&self, part: usize) -> String {
        let name = &self.workpiece.model.parts[part].name;
        if name.is_empty() { part.to_string() } else { name.clone() }
    }

    fn slab(&self, motion: &Rigid<Table, Machine>) -> Surface {
        let corners: Vec<Vec3> = self.profile.table_slab().iter().map(|p| motion.point((*p).into()).at).collect();
        let hull = Hull::of(&corners);
        Surface::new(hull.points, hull.faces, TABLE)
    }

    fn placed(&self, part: usize, motion: &Rigid<Table, Machine>) -> TriangleMesh<Machine> {
        self.workpiece.parts[part].moved(motion)
    }

    fn setup(&self, slot: usize, setup: &[&Print], before: &[usize], supports: &Supports) -> Frame {
        let table = self.table();
        let pose = setup[0].pose(&table);
        let motion = table.forward(pose);
        let new: Vec<usize> = setup.iter().map(|print| print.part).collect();
        let mut frame = Frame { surfaces: vec![self.slab(&motion)], side: Side::Above, ..Frame::default() };
        for &part in before {
            let surface = Surface::of(&self.placed(part, &motion), BEFORE);
            frame.surfaces.push(Surface { joint: Joint::Old, ..surface });
        }
        let stands: Vec<usize> = before.iter().chain(&new).copied().collect();
        let mut overhang = 0.0;
        for &part in &new {
            let mesh = self.placed(part, &motion);
            let hanging = self.hanging(part, &mesh, &stands);
            overhang += hanging.iter().map(|&i| mesh.facet_area(i)).sum::<f64>();
            let marked = hanging.into_iter().map(|i| (i, OVERHANG)).collect();
            let surface = Surface { marked, name: Some(self.name(part)), ..Surface::of(&mesh, NEW) };
            frame.surfaces.push(Surface { wanted: true, joint: Joint::New, ..surface });
        }
        // They stand on the level table, and nothing turns behind them.
        let here = supports.iter().filter(|(part, _)| new.contains(part));
        frame.surfaces.extend(here.map(|(_, mesh)| Surface::of(mesh, SUPPORT)));
        let fresh = frame.surfaces.iter().filter(|surface| surface.wanted);
        if let Some(tip) = highest(fresh.flat_map(|surface| &surface.points)) {
            let bodies = self.profile.head_bodies_at(pose);
            for body in bodies.iter().filter(|body| body.follows == [true; 3]).take(2) {
                // Only the head's lower end: the rest would hide what is printed.
                let points = body.points.iter().map(|p| Vec3::new(p.x, p.y, p.z.min(HEAD_MM)) + tip).collect();
                frame.ghosts.push(Ghost { points, colour: HEAD });
            }
            frame.scope.push(tip + Vec3::z() * HEAD_MM);
        }
        self.finish(&mut frame, pose, &motion);
        let words = [setup[0].tilt_deg, setup[0].rotation_deg];
        frame.caption.push(format!("slot {slot}: {}", self.words(words)));
        frame.caption.push(self.said(setup, &new, before, overhang));
        frame
    }

    /// Scope and arrows.
    fn finish(&self, frame: &mut Frame, pose: Pose, motion: &Rigid<Table, Machine>) {
        let solid =
            frame.surfaces.iter().filter(|one| one.colour != TABLE).flat_map(|surface| surface.points.iter().copied());
        frame.scope.extend(solid.collect::<Vec<_>>());
        frame.arrows = self.arrows(pose, motion);
    }

    fn words(&self, [tilt, rotation]: [f64; 2]) -> String {
        let table = self.table();
        let round = |deg: f64| (deg * 100.0).round() / 100.0 + 0.0;
        let (a, c) = (char::from(table.tilt.letter), char::from(table.rotation.letter));
        format!("{a}{} {c}{}", round(tilt), round(rotation))
    }

    fn said(&self, setup: &[&Print], new: &[usize], before: &[usize], overhang: f64) -> String {
        let numbers = |parts: &[usize]| parts.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let plural = if new.len() == 1 { "part" } else { "parts" };
        let mut said = format!("{plural} {}", numbers(new));
        let interfaces = &self.workpiece.model.interfaces;
        let joins = |one: usize, other: usize| new.contains(&one) && before.contains(&other);
        let met =
            interfaces.iter().filter_map(|i| if joins(i.a, i.b) { Some(i.b) } else { joins(i.b, i.a).then_some(i.a) });
        let mut met: Vec<usize> = met.collect();
        met.sort_unstable();
        met.dedup();
        if !met.is_empty() {
            said += &format!(" on {}", numbers(&met));
        }
        if overhang > TOLD_MM2 {
            said += &format!("; {overhang:.0} mm2 overhang more than {:.0} deg", self.overhang.deg());
        }
        if setup.iter().any(|print| print.supports.is_some()) {
            said += "; on supports";
        }
        said
    }

    /// The facets of a part that face down by more than the angle and lie neither on the table nor on a part that stands.
    fn hanging(&self, part: usize, mesh: &TriangleMesh<Machine>, stands: &[usize]) -> Vec<usize> {
        let own = &self.workpiece.parts[part];
        let mut carried = vec![0.0; mesh.facets().len()];
        for one in &self.workpiece.model.interfaces {
            let sides = [(one.a, one.b, &one.facets_a), (one.b, one.a, &one.facets_b)];
            let fitting = sides.into_iter().filter(|(mine, other, _)| *mine == part && stands.contains(other));
            fitting.flat_map(|(_, _, facets)| facets).for_each(|(i, mm2)| carried[*i] += mm2);
        }
        let from = self.overhang.rad().sin();
        let hangs = |&i: &usize| {
            let area = mesh.area_vector(i);
            let on_table = own.corners(i).iter().all(|p| p.z < TABLE_GAP_MM);
            -area.z > from * area.norm() + 1e-6 * area.norm() && !on_table && carried[i] < 0.5 * mesh.facet_area(i)
        };
        (0..mesh.facets().len()).filter(hangs).collect()
    }

    fn reason(&self, reason: &Reason) -> Frame {
        let table = self.table();
        let motion = table.forward(reason.pose);
        // What hangs is seen from below, where the table would hide it.
        let below = reason.blocked_by == "support";
        let surfaces = if below { vec![] } else { vec![self.slab(&motion)] };
        let side = if below { Side::Below } else { Side::Above };
        let mut frame = Frame { surfaces, side, ..Frame::default() };
        let all: Vec<usize> = (0..self.workpiece.parts.len()).collect();
        for &part in &all {
            let mesh = self.placed(part, &motion);
            let surface = if part == reason.part {
                let marked = self.hanging(part, &mesh, &all).into_iter().map(|i| (i, OVERHANG)).collect();
                Surface { marked, name: Some(self.name(part)), wanted: true, ..Surface::of(&mesh, NEW) }
            } else if reason.blocked_by.parse() == Ok(part) {
                Surface { name: Some(self.name(part)), ..Surface::of(&mesh, STRUCK) }
            } else {
                Surface::of(&mesh, BEFORE)
            };
            frame.surfaces.push(surface);
        }
        if let Some(tip) = reason.tip {
            let tip = motion.point(Vec3::from(tip).into()).at;
            // Pieces that do not follow every axis are as long as the machine: drawn where they strike, and only near the tip.
            let strikes = |b: &Body| b.follows == [true; 3] || reason.text.contains(&b.name);
            for body in self.profile.head_bodies_at(reason.pose).iter().filter(|b| strikes(b)) {
                let follow = |i: usize| if body.follows[i] { tip[i] } else { 0.0 };
                let near = |i: usize, v: f64| v.clamp(tip[i] - HEAD_SHOWN_MM, tip[i] + HEAD_SHOWN_MM);
                let at = |p: &Vec3| Vec3::from_fn(|i, _| near(i, p[i] + follow(i)));
                frame.ghosts.push(Ghost { points: body.points.iter().map(at).collect(), colour: HEAD });
            }
            frame.scope.extend([tip, tip + Vec3::z() * HEAD_MM]);
        }
        self.finish(&mut frame, reason.pose, &motion);
        let word = |axis: &crate::motion::AxisRange, angle: Angle| axis.word_of(angle).deg();
        let words = [word(&table.tilt, reason.pose.tilt), word(&table.rotation, reason.pose.rotation)];
        frame.caption = vec![format!("part {}: {}", reason.part, self.words(words)), reason.text.clone()];
        frame
    }

    /// How far the table is tilted, beside the parts at the end of the tilt axis, and turned, around their feet.
    fn arrows(&self, pose: Pose, motion: &Rigid<Table, Machine>) -> Vec<Arrow> {
        let table = self.table();
        let words = [table.tilt.word_of(pose.tilt).deg(), table.rotation.word_of(pose.rotation).deg()];
        let centre = motion.point(Vec3::zeros().into()).at;
        let corners = self.workpiece.parts.iter().flat_map(TriangleMesh::vertices);
        let reach = corners.fold(10.0f64, |most, p| most.max(p.x.hypot(p.y))) * 1.12;
        let letter = |axis: &crate::motion::AxisRange, deg: f64| format!("{}{:.0}", char::from(axis.letter), deg);
        let mut arrows = Vec::new();
        if pose.tilt.deg().abs() > 0.05 {
            let from = centre + table.directions().tilt * reach;
            let at = |tilt: f64| {
                from + table.forward(Pose { tilt: Angle::from_rad(tilt), ..pose }).rotation * Vec3::z() * 0.6 * reach
            };
            let plain = |points: Vec<Vec3>| Arrow { points, head: false, text: String::new(), colour: TILT_ARROW };
            arrows.push(plain(vec![at(0.0), from, at(pose.tilt.rad())]));
            let (points, text) = (arc(0.0, pose.tilt.rad(), at), letter(&table.tilt, words[0]));
            arrows.push(Arrow { points, head: true, text, colour: TILT_ARROW });
        }
        if pose.rotation.deg().abs() > 0.05 {
            let at = |turn: f64| {
                let there = table.forward(Pose { rotation: Angle::from_rad(turn), ..pose });
                centre + there.rotation * Vec3::x() * reach
            };
            let end = pose.rotation.rad();
            let longest = LONGEST_ARC_DEG.to_radians();
            let (points, text) = (arc(end - end.clamp(-longest, longest), end, at), letter(&table.rotation, words[1]));
            arrows.push(Arrow { points, head: true, text, colour: TURN_ARROW });
        }
        arrows
    }
}

/// Places from one angle to another, every few degrees.
fn arc(from: f64, to: f64, at: impl Fn(f64) -> Vec3) -> Vec<Vec3> {
    let steps = ((to - from).abs() / 0.08).ceil().max(2.0) as usize;
    (0..=steps).map(|i| at(from + (to - from) * i as f64 / steps as f64)).collect()
}
