//! Rule `standing`: what is printed stays standing at every pose that the table takes, by the lines that the file itself has laid.
//!
//! Each body, parts that hang together and what is caught in them, with their supports, is weighed by its lines' filament; it sticks where
//! lines of its first layer lie on the table, and is pressed against it there and below its supports, but those of what is caught. Asked whenever the table stands at a
//! new pose, and once more before it leaves it, with the nozzle pushing anywhere that it has printed. On a level table only the figure is
//! told: what leans there does so in every printer.

use std::f64::consts::PI;

use super::Planned;
use super::acts::{Acts, Go, Kind};
use super::evidence::{Checked, Evidence, Figures};
use super::report::{FindingPlace, Findings, Rule, Standing};
use crate::gcode::marks::Role;
use crate::geom::{Bounds, Machine, Rigid, Table, Vec3};
use crate::planning::balance::{self, FALLS, Foot, Weight};
use crate::trace::TraceMove;

/// How far above the table a line's underside may be that lies on it, mm.
const ON_TABLE_MM: f64 = 0.1;

/// What is known of one body.
#[derive(Clone, Default)]
struct Body {
    weight: Weight,
    foot: Foot,
    /// Whether places were added to its foot since it was settled.
    loose: bool,
    /// Where it was printed at this pose, table frame.
    printed: Option<Bounds>,
}

struct Balance<'a> {
    planned: &'a [Planned],
    /// By part, its body.
    body: Vec<usize>,
    /// Parts whose supports hold nothing of the body that they weigh on.
    captive: &'a [usize],
    bodies: Vec<Body>,
    adhesion: f64,
    filament_mm2: f64,
    pose: Option<Pose>,
    worst: Option<Standing>,
}

/// The table's way back, and which way is down there.
#[derive(Clone, Copy)]
struct Pose {
    back: Rigid<Machine, Table>,
    down: Vec3,
    tilt_deg: f64,
}

/// Asks of every state of the program whether all stands; states where it stands worst.
pub(super) fn check(&Evidence { acts, job, planned, .. }: &Evidence<'_>) -> Checked {
    let mut findings = Findings::default();
    let body = job.workpiece.model.standing_bodies();
    let (kinematics, process) = (job.profile.kinematics(), &job.profile.process);
    let mut balance = Balance {
        planned,
        bodies: vec![Body::default(); body.len()],
        body,
        captive: &job.workpiece.model.captive,
        adhesion: process.adhesion_mpa,
        filament_mm2: PI / 4.0 * process.filament_mm.powi(2),
        pose: None,
        worst: None,
    };
    let mut at = FindingPlace::default();
    for m in acts.trace.moves() {
        if acts.trace.turns(&m) || acts.trace.has_new_pose(&m) {
            balance.ask(at, &mut findings);
            balance.bodies.iter_mut().for_each(|body| body.printed = None);
            balance.pose = acts.trace.state(&m).pose().map(|pose| {
                let down = balance::down(&kinematics, pose);
                Pose { back: kinematics.forward(pose).inverse(), down, tilt_deg: balance::tilt(&down).deg() }
            });
            at.line = m.line;
            balance.ask(at, &mut findings);
        }
        if let Some(place) = balance.lay(acts, &m) {
            at = place;
        }
    }
    balance.ask(at, &mut findings);
    Checked { findings, figures: Figures::Standing(balance.worst) }
}

impl Balance<'_> {
    /// A line of a print; where it is.
    fn lay(&mut self, acts: &Acts<'_>, m: &TraceMove) -> Option<FindingPlace> {
        let (Some(Go::Stroke(stroke)), Some(pose)) = (acts.go(m), self.pose) else { return None };
        let print = self.planned.get(stroke.print? as usize).filter(|_| stroke.kind == Kind::Print)?;
        // A skirt hangs together with nothing.
        if m.role == Role::Adhesion {
            return None;
        }
        let [from, to] = [stroke.from, stroke.to].map(|tip| pose.back.point(tip.into()).at);
        let body = &mut self.bodies[*self.body.get(print.part)?];
        let (width, height) = (f64::from(stroke.width), f64::from(stroke.height));
        let middle = (from + to) / 2.0;
        // The tip is above what it lays.
        body.weight.add(m.e * self.filament_mm2, &(middle - pose.back.rotation * Vec3::z() * (height / 2.0)));
        let within = Bounds::of([from, to]);
        body.printed = Some(body.printed.map_or(within, |all| all.union(&within)));
        let counts = !self.captive.contains(&print.part);
        if counts && pose.tilt_deg == 0.0 && from.z.max(to.z) - height <= ON_TABLE_MM {
            let along = Vec3::new(to.x - from.x, to.y - from.y, 0.0);
            let aside = Vec3::new(-along.y, along.x, 0.0).try_normalize(1e-9).unwrap_or(Vec3::x()) * (width / 2.0);
            for p in [from + aside, from - aside, to + aside, to - aside] {
                body.foot.touches([p.x, p.y]);
            }
            body.loose = true;
            if print.gap_mm.is_none() {
                body.foot.sticks(width * along.norm(), [middle.x, middle.y]);
            }
        }
        Some(FindingPlace { line: stroke.line, slot: Some(print.slot), part: Some(print.part) })
    }

    fn ask(&mut self, at: FindingPlace, findings: &mut Findings) {
        let Some(pose) = self.pose else { return };
        for body in &mut self.bodies {
            if std::mem::take(&mut body.loose) {
                body.foot.settle();
            }
            let tips = body.printed.map_or(Vec::new(), |all| all.corners().to_vec());
            let Some(held) = balance::held(&body.weight, &body.foot, &pose.down, &tips, self.adhesion) else {
                continue;
            };
            let told = Standing {
                factor: held.factor,
                pushed_factor: held.pushed,
                line: at.line,
                tilt_deg: pose.tilt_deg,
                grams: body.weight.grams(),
            };
            if told.pushed_factor.is_finite()
                && self.worst.as_ref().is_none_or(|worst| told.pushed_factor < worst.pushed_factor)
            {
                self.worst = Some(told);
            }
            if held.factor < FALLS && pose.tilt_deg > 0.0 {
                findings.add(Rule::Standing, at, [held.factor, FALLS], || {
                    format!(
                        "at a tilt of {:.1} deg, the {:.1} g on the table are held with a safety factor of only {:.2} (minimum {FALLS})",
                        pose.tilt_deg,
                        body.weight.grams(),
                        held.factor
                    )
                });
            }
        }
    }
}
