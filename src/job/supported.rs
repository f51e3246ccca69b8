//! One solid that has no plan as it is, nor in parts: printed upright on the level table, on supports.

use super::holding::{Laid, even_tops, held_mesh};
use super::plan::planned_along;
use super::{Error, LoadedModel, LoadedProfile, PlanOptions, PlanResult, World};
use crate::geom::{Angle, Vec3};
use crate::overhang::Rule;
use crate::planning::{Plan, PrintSupports, Slot};
use crate::spelling::counted;
use crate::toolpath::SlotMesh;

/// What became of a solid that is printed on supports.
#[derive(Clone, Debug)]
pub struct HeldModel {
    /// The supports.
    pub supports: PrintSupports,
    /// What they are made of, mm³, at the profile's own layers.
    pub volume_mm3: f64,
    /// What laying them takes, seconds.
    pub seconds: f64,
    /// Why there is no plan for the model as it is, in one sentence.
    pub why: String,
}

impl HeldModel {
    /// What was done, what it costs and why, in one sentence; `seconds` of printing in all.
    pub fn story(&self, seconds: f64) -> String {
        format!(
            "on supports of {:.0} mm3, {:.0} min of about {:.0} min; as it is: {}",
            self.volume_mm3,
            self.seconds / 60.0,
            seconds / 60.0,
            self.why
        )
    }
}

/// Grids that are tried, mm: a coarse one takes less, a fine one reaches more.
const STEPS_MM: [f64; 3] = [5.0, 3.5, 2.5];
/// Air below what is held, layers.
const GAP_LAYERS: f64 = 1.0;

/// The plan of `model` upright on supports, or why that does not help.
pub(super) fn on_supports(
    model: &LoadedModel,
    machine: &LoadedProfile,
    (options, why): (&PlanOptions, &str),
    world: &World<'_>,
) -> Result<(PlanResult, HeldModel), String> {
    if model.model.parts.len() != 1 {
        let parts = counted(model.model.parts.len(), "part");
        return Err(format!("supports are made for one solid, and this model has {parts}; join them (--join)"));
    }
    let words = |error: Error| error.to_string();
    // What hangs is looked at below, with the supports there.
    let carried = PlanOptions { remedies: false, allow: vec![(0, None)], plans: 1, ..options.clone() };
    let upright = [Vec3::z()];
    let mut plan = planned_along(Some(&upright), model.clone(), machine.clone(), &carried, world).map_err(words)?;
    let mut left = String::new();
    for step_mm in STEPS_MM {
        match Attempt::of(&plan, step_mm, options) {
            Ok(attempt) => {
                let held = attempt.taken(&mut plan, why);
                plan.story = Some(held.story(plan.best().seconds));
                return Ok((plan, held));
            }
            Err(why_not) => left = why_not,
        }
    }
    Err(left)
}

/// Supports that hold all there is to hold.
struct Attempt {
    supports: PrintSupports,
    laid: Laid,
}

impl Attempt {
    fn of(plan: &PlanResult, step_mm: f64, options: &PlanOptions) -> Result<Self, String> {
        let process = &plan.plan.machine.profile.process;
        let gap_mm = GAP_LAYERS * process.layer_height_mm;
        let supports = PrintSupports { step_mm, overhang_deg: options.overhang_deg, gap_mm };
        let (_, print) = plan.plan.prints().next().ok_or("the plan prints nothing")?;
        let mesh = held_mesh(&plan.plan, print);
        let tops = even_tops(process.layer_height_mm, mesh.mesh.bounds().max.z);
        let laid = Laid::below(&mesh, &supports, &tops, process).map_err(|e| e.to_string())?;
        let rule = Rule {
            overhang: Angle::from_deg(options.overhang_deg),
            layer_mm: process.layer_height_mm,
            line_mm: process.line_width_mm,
            bridge_mm: process.bridge_mm,
            tolerate_mm2: options.tolerate_mm2,
        };
        let left = laid.left(&mesh, &supports, &rule);
        if let Some(patch) = left.first() {
            let all: f64 = left.iter().map(|patch| patch.area_mm2).sum();
            let bare: f64 = laid.bare.iter().map(|bare| bare.area_mm2).sum();
            let reach =
                if bare > 0.0 { format!("; {bare:.0} mm2 have no straight way to the table") } else { String::new() };
            return Err(format!(
                "with supports {all:.1} mm2 would still be laid on nothing, {:.1} of it at a height of {:.1} mm: {}{reach}",
                patch.area_mm2, patch.at.z, patch.cause
            ));
        }
        let attempt = Self { supports, laid };
        attempt.fits(plan, &mesh)?;
        Ok(attempt)
    }

    /// Whether they stand on the table, and within the axes.
    fn fits(&self, plan: &PlanResult, mesh: &SlotMesh) -> Result<(), String> {
        let profile = &plan.plan.machine.profile;
        let bounds = self.laid.bounds();
        if bounds.is_empty() {
            return Ok(());
        }
        let limits = profile.linear_limits();
        if let Some(out) = [bounds.min, bounds.max].iter().find_map(|p| limits.violation(&(p + mesh.to_machine))) {
            return Err(format!("its supports leave the axes: {out}"));
        }
        let Some((_, print)) = plan.plan.prints().next() else { return Ok(()) };
        let motion = profile.kinematics().forward(print.pose(&profile.kinematics())).inverse();
        let half = profile.process.line_width_mm / 2.0;
        let feet = self.laid.layers.first().into_iter().flat_map(|layer| layer.lines.iter().flatten());
        let beyond = feet.map(|p| {
            let at = motion.point((Vec3::new(p[0], p[1], 0.0) + mesh.to_machine).into()).at;
            profile.beyond_table(at.x, at.y) + half
        });
        let most = beyond.fold(f64::NEG_INFINITY, f64::max);
        if most > 0.0 {
            return Err(format!("its supports would stand {most:.1} mm beyond the table"));
        }
        Ok(())
    }

    /// Puts them into the plan.
    fn taken(self, plan: &mut PlanResult, why: &str) -> HeldModel {
        let Self { supports, laid } = self;
        let hold = |slots: &mut Vec<Slot>| {
            slots.iter_mut().flat_map(|slot| &mut slot.prints).for_each(|print| print.supports = Some(supports));
        };
        hold(&mut plan.plan.plan.slots);
        hold(&mut plan.plans[0].slots);
        plan.plan.plan.version = Plan::WITH_SUPPORTS;
        plan.plan.sha256 = plan.plan.plan.sha256();
        let process = &plan.plan.machine.profile.process;
        let section_mm2 = process.line_width_mm * process.layer_height_mm;
        let (volume_mm3, seconds) = (laid.length_mm() * section_mm2, laid.length_mm() / process.infill_mm_per_s);
        plan.plans[0].seconds += seconds;
        HeldModel { supports, volume_mm3, seconds, why: why.to_owned() }
    }
}
