//! How to plan, as values of plain types, checked and made into what `planning` asks for.

use std::path::PathBuf;
use std::str::FromStr;

use crate::geom::{Angle, Vec3};
use crate::input::{BadSetting, LoadedModel, LoadedProfile};
use crate::mesh::Model;
use crate::orient::{
    Direction, Facets, METHODS, Multistart, Objective, ObjectiveSettings, Search, method, nearest, objective,
};
use crate::overhang::TOLERATE_MM2;
use crate::planning::{
    Goal, Options, Placement, PrintSupports, Priority, Workpiece, centred, centred_and_turned, orientations, plannable,
};
use crate::strategy::error::StrategyError;
use crate::strategy::form::{STEPS_MM, SupportForm};

/// How to plan; the default is what the command does without flags.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanOptions {
    /// What the plan minimises: `bss`, `time`, `setups`, `slots`, an objective of orientations summed over the parts, or a
    /// weighted sum of such.
    pub objective: String,
    /// What the search for orientations minimises; `None`: the plan's objective where it is one of parts, else staircase.
    pub orient_by: Option<String>,
    /// The search for orientations; `None`: a multistart of quick descents.
    pub method: Option<String>,
    /// Most evaluations of that search, for one part and objective; `None`: the method's own.
    pub orient_budget: Option<usize>,
    /// Slopes up to this angle from the vertical are fine; `None`: as lines of the profile's width and layers are
    /// ([`Rule::practised`](crate::overhang::OverhangRule::practised)).
    pub overhang_deg: Option<f64>,
    /// How well it is to come out.
    pub finish: Finish,
    /// What a line may span between two ends on material, in planning and in verification; `None`: the machine's `process.bridge_mm`.
    pub bridge_mm: Option<f64>,
    /// What a connected patch may have that nothing carries, mm².
    pub tolerate_mm2: f64,
    /// Parts that may overhang by so much more, mm²; `None`: whatever they overhang is carried by something else.
    pub allow: Vec<(usize, Option<f64>)>,
    /// Room the head keeps from parts it does not print on.
    pub margin_mm: f64,
    /// Which sequences come first.
    pub priority: Priority,
    /// Whether everything on the table belongs to the first slot.
    pub table_first: bool,
    /// Demanded steps: the parts of each are printed in later slots than those of the steps before. Parts that are in none go anywhere.
    /// Where a solid is cut, these are the parts that it is cut into.
    pub order: Vec<Vec<usize>>,
    /// Seed of the orientation search.
    pub seed: u64,
    /// Where the file's origin comes to lie on the table; `None`: the model centred, elsewhere if the axes do not reach.
    pub place: Option<PlaceRequest>,
    /// Whether to look for what would help where there is no plan.
    pub remedies: bool,
    /// Whether it is said why, where there is no plan: that may take longer than to find that there is none. Parts that touch are tried along more
    /// directions only then, those that the reasons name.
    pub explain: bool,
    /// What supports have beside their columns, where there are any.
    pub form: SupportForm,
    /// Most steps of the sequence search.
    pub budget: u64,
    /// The folder that the plan will be kept in, for the paths of model and profile in it; `None`: as they are given.
    pub kept_in: Option<PathBuf>,
    /// How many distinct plans, 1 to 100; beside several stands printing in three axes.
    pub plans: usize,
}

/// How well a print is to come out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Finish {
    /// What is printed everywhere may droop a little.
    #[default]
    Practised,
    /// Nothing droops.
    Fine,
}

impl FromStr for Finish {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "practised" => Ok(Self::Practised),
            "fine" => Ok(Self::Fine),
            _ => Err("must be practised or fine"),
        }
    }
}

/// Facets up to this angle from the vertical are fine whatever layers say, degrees, where nobody says otherwise.
pub(crate) const CAREFUL_DEG: f64 = 45.0;

/// Whether a part may be printed on supports where there is no plan without.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Supporting {
    /// Never.
    #[default]
    Never,
    /// Where there is no plan without, and no cheaper cut.
    Auto,
}

/// The largest area that can be let pass, mm².
const MOST_MM2: f64 = 1e6;

/// A place on the table; the height is the table's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceRequest {
    /// Where the file's origin lies; `None`: the model in the middle.
    pub origin_mm: Option<[f64; 2]>,
    /// The turn about the table's normal.
    pub turn_deg: f64,
}

impl PlaceRequest {
    /// Where `model` stands then.
    pub(crate) fn placement(&self, model: &Model) -> Placement {
        let Self { origin_mm, turn_deg } = *self;
        match origin_mm {
            Some([x, y]) => Placement { origin_mm: [x, y, -model.bounds.min.z], turn_deg },
            None => centred_and_turned(model, turn_deg),
        }
    }
}

/// What may hang in words: `PART`, or `PART:MM2`.
///
/// # Errors
///
/// [`StrategyError::Setting`].
pub fn allowed(text: &str) -> Result<(usize, Option<f64>), StrategyError> {
    let (part, area) = text.split_once(':').map_or((text, None), |(part, area)| (part, Some(area)));
    let part = part.trim().parse().ok();
    let area = area.map(|area| area.trim().parse::<f64>().ok().filter(|v| v.is_finite()));
    match (part, area) {
        (Some(part), None) => Ok((part, None)),
        (Some(part), Some(Some(area))) => Ok((part, Some(area))),
        _ => {
            let wanted = "must be a part number, or a part number and mm2, for example --allow 0:40".to_owned();
            Err(BadSetting::Words { name: "allow", text: text.to_owned(), wanted }.into())
        }
    }
}

/// Steps of parts, for example `0,2+3,1`: each step behind the one before; a plus joins parts whose order is left to the plan.
///
/// # Errors
///
/// [`StrategyError::Setting`] for what is no number, and for a part that is there twice.
pub fn ordered(text: &str) -> Result<Vec<Vec<usize>>, StrategyError> {
    let step = |step: &str| step.split('+').map(|part| part.trim().parse().ok()).collect::<Option<Vec<usize>>>();
    let steps: Option<Vec<Vec<usize>>> = text.split(',').map(step).collect();
    let once = |steps: &Vec<Vec<usize>>| {
        let mut all = steps.concat();
        all.sort_unstable();
        all.windows(2).all(|pair| pair[0] != pair[1])
    };
    steps.filter(once).ok_or_else(|| {
        let wanted = "must be part numbers, each once, for example --order 0,2+3,1".to_owned();
        BadSetting::Words { name: "order", text: text.to_owned(), wanted }.into()
    })
}

impl PlanOptions {
    /// Whether nothing is said of what directions are to be searched for, or compared.
    pub(crate) fn leaves_directions(&self) -> bool {
        let usual = Self::default();
        self.objective == usual.objective && self.orient_by.is_none() && self.method.is_none() && self.plans == 1
    }
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            objective: "bss".to_owned(),
            orient_by: None,
            method: None,
            orient_budget: None,
            overhang_deg: None,
            finish: Finish::Practised,
            bridge_mm: None,
            tolerate_mm2: TOLERATE_MM2,
            allow: Vec::new(),
            margin_mm: 0.5,
            priority: Priority::Together,
            table_first: true,
            order: Vec::new(),
            seed: 1,
            place: None,
            explain: true,
            remedies: true,
            form: SupportForm::PRINTED,
            budget: 20_000_000,
            kept_in: None,
            plans: 1,
        }
    }
}

/// What the options ask for, checked; `Options` borrow from it.
pub(super) struct PlanAsked {
    pub(super) goal: Goal,
    objective: Box<dyn Objective>,
    search: Box<dyn Search>,
    /// Where the model stands at first.
    pub(super) base: Placement,
}

impl PlanAsked {
    pub(super) fn of(
        options: &PlanOptions,
        machine: &LoadedProfile,
        model: &LoadedModel,
    ) -> Result<Self, StrategyError> {
        BadSetting::within("top", options.plans as f64, "", [1.0, 100.0])?;
        let settings =
            ObjectiveSettings { layer_mm: machine.profile.process.layer_height_mm, ..ObjectiveSettings::default() };
        let bad = |name| move |source| BadSetting::Objective { name, source };
        let goal = Goal::parse(&options.objective, &settings).map_err(bad("objective"))?;
        let of_goal = || objective(&options.objective, &settings).or_else(|_| objective("staircase", &settings));
        let given = options.orient_by.as_ref().map(|text| objective(text, &settings));
        let objective = given.unwrap_or_else(of_goal).map_err(bad("orient-by"))?;
        BadSetting::within("overhang", options.overhang_deg.unwrap_or(CAREFUL_DEG), " deg", [0.0, 90.0])?;
        BadSetting::within("tolerate", options.tolerate_mm2, " mm2", [0.0, MOST_MM2])?;
        let last = model.model.parts.len() - 1;
        for &(given, area) in &options.allow {
            if given > last {
                return Err(BadSetting::NoSuchPart { name: "allow", given, last, model: model.file.clone() }.into());
            }
            BadSetting::within("allow", area.unwrap_or(0.0), " mm2", [0.0, MOST_MM2])?;
        }
        if let Some(&given) = options.order.iter().flatten().find(|&&part| part > last) {
            return Err(BadSetting::NoSuchPart { name: "order", given, last, model: model.file.clone() }.into());
        }
        BadSetting::within("margin", options.margin_mm, " mm", [0.0, 100.0])?;
        options.form.check(PrintSupports::ROOFS_MM[1], STEPS_MM[STEPS_MM.len() - 1])?;
        if options.orient_budget == Some(0) {
            return Err(BadSetting::Zero { name: "orient-budget" }.into());
        }
        let search = search(options, objective.as_ref())?;
        let base = match options.place {
            Some(place) => {
                BadSetting::within("turn", place.turn_deg, " deg", [-360.0, 360.0])?;
                place.placement(&model.model)
            }
            None => centred(&model.model, &machine.profile)?,
        };
        Ok(Self { goal, objective, search, base })
    }

    pub(super) fn options<'a>(&'a self, options: &PlanOptions) -> Options<'a> {
        Options {
            overhang: Angle::from_deg(options.overhang_deg.unwrap_or(CAREFUL_DEG)),
            steepest: options.overhang_deg.map(Angle::from_deg),
            droops: options.finish == Finish::Practised,
            margin_mm: options.margin_mm,
            priority: options.priority,
            table_first: options.table_first,
            order: options.order.clone(),
            budget: options.budget,
            plans: options.plans,
            supported: options.allow.iter().filter(|(_, area)| area.is_none()).map(|(part, _)| *part).collect(),
            allow: options.allow.iter().filter_map(|&(part, area)| Some((part, area?))).collect(),
            tolerate_mm2: options.tolerate_mm2,
            explain: options.explain,
            ..Options::new(&self.goal, self.objective.as_ref(), self.search.as_ref())
        }
    }

    /// The directions to try where the model stands at first.
    pub(super) fn directions(
        &self,
        workpiece: &Workpiece<'_>,
        machine: &LoadedProfile,
        options: &Options<'_>,
        along: &Along<'_>,
    ) -> Result<Vec<Vec<Direction>>, StrategyError> {
        workpiece.check(&machine.profile)?;
        plannable(workpiece)?;
        let up = |facets: &Facets, up: &Vec3| {
            let up = workpiece.placed.rotation * up;
            Direction { up, value: self.objective.value(facets, &up) }
        };
        let only = |mesh, ups: &[Vec3]| {
            let facets = Facets::of(mesh);
            ups.iter().map(|d| up(&facets, d)).collect::<Vec<Direction>>()
        };
        Ok(match *along {
            Along::Any => orientations(workpiece, options),
            Along::These(ups) => workpiece.parts.iter().map(|mesh| only(mesh, ups)).collect(),
            Along::Upright(parts) => {
                let mut all = orientations(workpiece, options);
                parts.iter().for_each(|&part| all[part] = only(&workpiece.parts[part], &[Vec3::z()]));
                all
            }
        })
    }
}

/// The directions that parts may be printed along, the model file's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Along<'a> {
    /// What is found.
    Any,
    /// Every part along one of these.
    These(&'a [Vec3]),
    /// These parts along +Z, all others along what is found.
    Upright(&'a [usize]),
}

fn search(options: &PlanOptions, objective: &dyn Objective) -> Result<Box<dyn Search>, BadSetting> {
    let Some(name) = &options.method else {
        let usual = Multistart { seed: options.seed, ..Multistart::default() };
        return Ok(Box::new(Multistart { budget: options.orient_budget.unwrap_or(usual.budget), ..usual }));
    };
    method(name, objective, options.orient_budget, options.seed).ok_or_else(|| BadSetting::Method {
        name: "method",
        given: name.clone(),
        nearest: nearest(name, &METHODS).to_string(),
    })
}
