//! What would help where there is no way to print a model as it was asked for: each is tried before it is named. Directions are of the file's frame.

use super::arrange::{Models, SetUp};
use super::error::StrategyError;
use super::plan::{Along, PlanOptions, planned, planned_along};
use super::plates::plates_of;
use super::price::Way;
use super::turning::{Poses, turned};
use super::ways::TriedWay;
use crate::geom::Vec3;
use crate::input::{LoadedModel, LoadedProfile, MachineSource, load_profile};
use crate::mesh::Model;
use crate::planning::{Misplaced, Remedy, centred, support_by_hand};
use crate::profile::SHIPPED;
use crate::spelling::part_named;
use crate::world::{Silent, World};

/// Profiles that are nobody's machine begin so.
const NOBODYS: [&str; 3] = ["generic-", "linuxcnc-", "grblhal-"];
/// Steps of the search for a plan on another machine.
const OTHER_STEPS: u64 = 400_000;

/// The shipped machines that somebody has, but for this one.
fn others<'a>(than: &'a LoadedProfile) -> impl Iterator<Item = &'static str> + 'a {
    let owned = |name: &&str| !NOBODYS.iter().any(|start| name.starts_with(start)) && **name != than.name;
    SHIPPED.iter().map(|(name, ..)| *name).filter(owned)
}

/// That the model fits on several plates, or on the table of another machine, where it does.
pub(super) fn with_room(no: Misplaced, model: &Model, than: &LoadedProfile, world: &World<'_>) -> StrategyError {
    let fits = |name: &&str| {
        let machine = load_profile(&MachineSource::Shipped((*name).to_owned()), world);
        machine.is_ok_and(|machine| centred(model, &machine.profile).is_ok())
    };
    let machine = others(than).find(fits);
    if let (Misplaced::OverRim { extent, .. }, Some((bodies, plates))) = (&no, plates_of(model, than)) {
        return StrategyError::SeveralPlates { bodies, extent: extent.clone(), plates, machine };
    }
    match machine {
        Some(machine) => StrategyError::RoomElsewhere { source: no, machine },
        None => no.into(),
    }
}

/// The first of the other shipped machines on which the model has a plan as it stands.
pub(super) fn other_machine(
    model: &LoadedModel,
    than: &LoadedProfile,
    options: &PlanOptions,
    world: &World<'_>,
) -> Option<Remedy> {
    let silent = World { progress: &Silent, ..*world };
    let budget = options.budget.min(OTHER_STEPS);
    let quiet = PlanOptions { remedies: false, explain: false, plans: 1, place: None, budget, ..options.clone() };
    let has_plan = |name: &&str| {
        let machine = load_profile(&MachineSource::Shipped((*name).to_owned()), &silent);
        machine.is_ok_and(|machine| planned(model.clone(), machine, &quiet, &silent).is_ok())
    };
    let name = others(than).find(has_plan)?;
    Some(Remedy { kind: "machine", amount: 0.0, text: format!("another machine can print it: -m {name}") })
}

/// Leaves out what has just been tried in vain.
pub(super) fn not_what_failed(remedies: &mut Vec<Remedy>, tried: &[TriedWay], model: &Model) {
    let failed = |way: Way| tried.iter().any(|tried| tried.way == way && tried.terms.is_none());
    if failed(Way::Cut) {
        remedies.retain(|remedy| remedy.kind != "split");
    }
    if failed(Way::Supports) {
        let gap_mm = tried.iter().find_map(|tried| tried.why_not.as_ref()?.joint_gap_mm());
        let in_joint = |part: usize| (0..model.parts.len()).any(|other| model.is_joint(part, other));
        for remedy in remedies.iter_mut().filter(|remedy| remedy.kind == "support") {
            let part = remedy.amount as usize;
            let name = &model.parts[part].name;
            *remedy = match gap_mm {
                // Nobody could take a support out of there.
                Some(gap_mm) if in_joint(part) => {
                    let text = format!("leave at most {gap_mm:.1} mm of air below {}", part_named(part, name));
                    Remedy { kind: "joint", amount: gap_mm, text }
                }
                _ => Remedy { text: support_by_hand(part, name), ..remedy.clone() },
            };
        }
    }
}

/// The first pose of `orient` in which there is a plan, where nobody said how the model is to stand.
pub(super) fn turned_over(
    models: &Models<'_>,
    model: &LoadedModel,
    options: &PlanOptions,
    world: &World<'_>,
) -> Option<Remedy> {
    let silent = World { progress: &Silent, ..*world };
    let quiet = PlanOptions { remedies: false, explain: false, plans: 1, ..options.clone() };
    let poses = Poses::of(&model.model.parts[0].mesh, models.machine);
    let up = poses.others.iter().map(|pose| <[f64; 3]>::from(pose.up)).find(|up| {
        let set = turned(models, *up);
        let plan =
            |set: SetUp| planned_along(Along::These(&[Vec3::z()]), set.model, models.machine.clone(), &quiet, &silent);
        set.and_then(plan).is_ok()
    })?;
    let [x, y, z] = up.map(|v| (v * 1e4).round() / 1e4 + 0.0);
    Some(Remedy { kind: "up", amount: 0.0, text: format!("another orientation can be printed: --up {x},{y},{z}") })
}
