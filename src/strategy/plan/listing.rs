//! Every feasible sequence of a model: where it stands, or in every way that it can stand.

use super::{Along, PlanAsked, PlanRequest, StrategyError};
use crate::assembly::stands;
use crate::geom::Vec3;
use crate::input::{LoadedProfile, load_profile, spanning};
use crate::planning::{self, Infeasible, TimeSlot, Workpiece};
use crate::strategy::arrange::{Arrangement, Models, PoseChoice, ReadModels, SetUp, arranged_aloud};
use crate::world::{Silent, World};

/// How many sequences were listed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Listed {
    /// How many.
    pub count: usize,
    /// Whether these are all there are.
    pub complete: bool,
    /// What listing took.
    pub seconds: f64,
}

/// Hands every feasible sequence to `each` as it is found, `most` at most.
///
/// With [`PoseChoice::Any`] those of every way in which the model can stand on a face ([`stands`]), each with the direction of the
/// file that is then up, as Ramos et al. (2021) list them; without, the direction is `None`.
///
/// # Errors
///
/// As [`plan`](crate::strategy::plan()), but [`StrategyError::Infeasible`] without remedies where there is none; of several stands what is
/// wrong with the first.
pub fn sequences(
    request: &PlanRequest,
    most: usize,
    world: &World<'_>,
    mut each: impl FnMut(Option<[f64; 3]>, Vec<TimeSlot>),
) -> Result<Listed, StrategyError> {
    let machine = spanning(load_profile(&request.machine, world)?, request.options.bridge_mm)?;
    let start = world.clock.now();
    let how = &request.arrangement;
    let of_each = how.standing == PoseChoice::Any;
    let world = if of_each { &World { progress: &Silent, ..*world } } else { world };
    let read = &ReadModels::read(&request.model, how, world)?;
    let mut listing = Listing { request, read, machine: &machine, most, seen: 0 };
    let complete = if of_each {
        listing.of_each_stand(world, &mut each)?
    } else {
        listing.of_one(how, world, |slots| each(None, slots))?
    };
    Ok(Listed { count: listing.seen.min(most), complete, seconds: (world.clock.now() - start).as_secs_f64() })
}

struct Listing<'a> {
    request: &'a PlanRequest,
    read: &'a ReadModels,
    machine: &'a LoadedProfile,
    most: usize,
    /// Sequences until now, of all stands.
    seen: usize,
}

impl Listing<'_> {
    /// Those of every stand; whether these are all.
    fn of_each_stand(
        &mut self,
        world: &World<'_>,
        each: &mut impl FnMut(Option<[f64; 3]>, Vec<TimeSlot>),
    ) -> Result<bool, StrategyError> {
        let ups = stands(&self.read.first().model);
        let (mut complete, mut no) = (true, None);
        let as_drawn = ups.is_empty().then_some(Vec3::z());
        for up in ups.into_iter().chain(as_drawn) {
            if self.seen > self.most {
                return Ok(false);
            }
            let up = [up.x, up.y, up.z];
            let how = Arrangement { standing: PoseChoice::Up(up), ..self.request.arrangement.clone() };
            match self.of_one(&how, world, |slots| each(Some(up), slots)) {
                Ok(all) => complete &= all,
                Err(why @ StrategyError::Infeasible(Infeasible::TooManyParts { .. })) => {
                    return Err(why);
                }
                Err(why @ (StrategyError::Infeasible(_) | StrategyError::Misplaced(_))) => {
                    no.get_or_insert(why);
                }
                Err(other) => return Err(other),
            }
        }
        match no {
            Some(why) if self.seen == 0 => Err(why),
            _ => Ok(complete),
        }
    }

    /// Those of the model as it is set up by `how`; whether these are all.
    fn of_one(
        &mut self,
        how: &Arrangement,
        world: &World<'_>,
        mut each: impl FnMut(Vec<TimeSlot>),
    ) -> Result<bool, StrategyError> {
        let Self { request, read, machine, most, .. } = *self;
        let SetUp { model, .. } = arranged_aloud(&Models { read, how, machine }, world)?;
        let asked = PlanAsked::of(&request.options, machine, &model)?;
        let options = asked.options(&request.options);
        let workpiece = Workpiece::place(&model.model, &asked.base);
        let mut directions = asked.directions(&workpiece, machine, &options, &Along::Any)?;
        // Those of a plan; a budget that ends its search ends only that.
        let plan = |directions: &[_]| planning::plan(&workpiece, &machine.profile, directions, &options);
        if let Err(no @ Infeasible::NoPlan { .. }) =
            planning::widening(&workpiece, &options, &[], &mut directions, plan)
        {
            return Err(no.into());
        }
        let seen = &mut self.seen;
        Ok(planning::sequences(&workpiece, &machine.profile, &directions, &options, |slots| {
            *seen += 1;
            let wanted = *seen <= most;
            if wanted {
                each(slots);
            }
            wanted
        })?)
    }
}
