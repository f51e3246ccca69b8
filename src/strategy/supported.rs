//! Solids that have no plan as they are: printed upright on the level table, on supports. Of parts that touch each other only
//! those that stand on the table are held, and all others are printed as their plan has them.

use rayon::prelude::*;

use super::below::{Below, stand_alone};
use super::error::StrategyError;
use super::form::{PROP_STEPS_MM, STEPS_MM};
use super::holding::{HeldMesh, Laid, judge, support_solids};
use super::plan::{Along, Finish, PlanOptions, PlanResult, planned_along};
use super::refused::Refused;
use super::solids::groups;
use crate::gcode::round_to;
use crate::geom::{Angle, Vec3};
use crate::input::{CheckedPlan, LoadedModel, LoadedProfile};
use crate::overhang::{HangingBox, Judged, LayerJudge, OverhangRule, Patch, SupportLines};
use crate::planning::balance::{Foot, standing};
use crate::planning::{Plan, Print, PrintSupports, PropPlace, SupportRoof, TimeSlot};
use crate::profile::Profile;
use crate::section::{PlanePoint, Segment, Segments, march};
use crate::spelling::part_named;
use crate::support::Cuts;
use crate::world::World;

/// What became of a model that is printed on supports.
#[derive(Clone, Debug)]
pub struct HeldModel {
    /// The parts that have supports.
    pub parts: Vec<HeldPart>,
    /// Why there is no plan for the model as it is.
    pub why: Refused,
}

/// The supports of one part.
#[derive(Clone, Debug)]
pub struct HeldPart {
    /// The part.
    pub part: usize,
    /// The supports.
    pub supports: PrintSupports,
    /// What they are made of, mm³, at the profile's own layers.
    pub volume_mm3: f64,
    /// What laying them takes, seconds.
    pub seconds: f64,
    /// The longest stretch of a column without another beside it, mm.
    pub longest_free_mm: f64,
    /// What of the part they hold, mm².
    pub contact_mm2: f64,
}

impl HeldModel {
    /// What all supports are made of, mm³, at the profile's own layers.
    pub fn volume_mm3(&self) -> f64 {
        self.parts.iter().map(|held| held.volume_mm3).sum()
    }

    /// What laying them takes, seconds.
    pub fn seconds(&self) -> f64 {
        self.parts.iter().map(|held| held.seconds).sum()
    }

    /// What was done, what it costs and why, in one sentence; `seconds` of printing in all.
    pub fn story(&self, seconds: f64) -> String {
        let which = match self.parts.len() {
            1 => String::new(),
            count => format!("{count} parts "),
        };
        let free = |held: &HeldPart| {
            let free_mm = held.longest_free_mm;
            held.supports
                .brace_mm
                .filter(|most| free_mm > most + SAME_MM)
                .map(|most| format!("; part {} has a column unbraced over {free_mm:.1} mm (--brace {most})", held.part))
        };
        format!(
            "{which}printed on supports ({:.0} mm3, {:.0} of {:.0} min){}; without supports: {}",
            self.volume_mm3(),
            self.seconds() / 60.0,
            seconds / 60.0,
            self.parts.iter().filter_map(free).collect::<String>(),
            self.why
        )
    }
}

/// What supports hold of a part that has some.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Holding {
    /// What hangs, and what droops about it.
    #[default]
    Usual,
    /// Whatever droops, too.
    Firm,
    /// The same, by supports as near to each other as there are.
    Dense,
}

/// What supports hold, by part; as usual where nothing is said of it.
#[derive(Clone, Debug, Default)]
pub struct Holdings(Vec<(usize, Holding)>);

impl Holdings {
    /// All as usual.
    pub const USUAL: Self = Self(Vec::new());

    fn of(&self, part: usize) -> Holding {
        self.0.iter().find(|(of, _)| *of == part).map_or(Holding::Usual, |(_, holding)| *holding)
    }

    /// Holds each of `parts` more firmly; whether that is possible of any.
    pub(crate) fn firmer(&mut self, parts: &[usize]) -> bool {
        let more: Vec<(usize, Holding)> =
            parts.iter().filter_map(|&part| Some((part, self.of(part).firmer()?))).collect();
        self.0.retain(|(of, _)| more.iter().all(|(part, _)| part != of));
        self.0.extend(&more);
        !more.is_empty()
    }
}

impl Holding {
    /// What holds more than this does.
    fn firmer(self) -> Option<Self> {
        match self {
            Self::Usual => Some(Self::Firm),
            Self::Firm => Some(Self::Dense),
            Self::Dense => None,
        }
    }

    /// Of distances between supports, the widest first, those that are tried.
    fn of_steps(self, steps: &[f64]) -> &[f64] {
        let from = if self == Self::Dense { steps.len().saturating_sub(1) } else { 0 };
        &steps[from..]
    }
}

/// Distance between the lines of a roof, in their widths, where nobody says otherwise.
const ROOF_WIDTHS: f64 = 2.0;
/// Air below what is held, layers.
const GAP_LAYERS: f64 = 1.0;
/// From one line of a support to the next and back to speed, s. An estimate: three files of the built-in slicer took 0.28 to 0.45 s a line beyond
/// what length and the part account for, and least times of layers are among that.
const LINE_S: f64 = 0.15;
/// Heights that differ by less are the same, mm.
const SAME_MM: f64 = 1e-6;
/// So many kinds of supports are worked out at once; how many processors there are makes no difference.
const AT_ONCE: usize = 2;
/// So often what columns and props leave is propped.
const ROUNDS: usize = 4;
/// Places no farther apart than this are about each other, mm.
const ABOUT_MM: f64 = 0.5;
/// Boxes of places are multiples of this, mm.
const PLACE_MM: f64 = 0.01;
/// What begins below stands on the table, mm.
const ON_TABLE_MM: f64 = 0.05;
/// Supports and what is beside them are told apart up to this, mm.
const FAR_MM: f64 = 5.0;

/// The plan of `model`, with supports below each part that wants some; or why that does not help. What stands on the table is printed
/// upright, and so is all where no parts touch.
pub(super) fn on_supports(
    model: &LoadedModel,
    machine: &LoadedProfile,
    options: &PlanOptions,
    holdings: &Holdings,
    why: &Refused,
    world: &World<'_>,
) -> Result<(PlanResult, HeldModel), Refused> {
    let parts = &model.model.parts;
    let named = |part: usize| part_named(part, &parts[part].name);
    let touching = groups(&model.model).iter().any(|group| group.len() > 1);
    let all: Vec<usize> = (0..parts.len()).collect();
    let in_place = model.model.in_place();
    let bases = if touching { &in_place } else { &all };
    // What hangs of them is looked at below, with the supports there.
    let theirs = |part: &usize| bases.contains(part);
    let others = options.allow.iter().filter(|(part, _)| !theirs(part)).copied();
    let allow = bases.iter().map(|&part| (part, None)).chain(others).collect();
    let carried = PlanOptions { remedies: false, allow, plans: 1, ..options.clone() };
    let upright = [Vec3::z()];
    let along = if touching { Along::Upright(bases) } else { Along::These(&upright) };
    let words = |error: StrategyError| match error {
        StrategyError::NoPlan(no) if touching => Refused::Touching(no.infeasible),
        error => error.into(),
    };
    let mut plan = planned_along(along, model.clone(), machine.clone(), &carried, world).map_err(words)?;
    if !touching && plan.plan.plan.slots.len() > 1 {
        return Err(Refused::Slots { slots: plan.plan.plan.slots.len() });
    }
    let mut attempts = Vec::new();
    for (_, print) in plan.plan.prints().filter(|(_, print)| theirs(&print.part)) {
        let about = |why: Refused| if parts.len() > 1 { why.of_part(named(print.part)) } else { why };
        attempts.extend(Attempt::best(&plan.plan, print, options, holdings.of(print.part)).map_err(about)?);
    }
    if attempts.is_empty() {
        if touching {
            return Err(Refused::NothingHangs { on_table: true });
        }
        return Ok((plan, HeldModel { parts: Vec::new(), why: why.clone() }));
    }
    mixed(&plan.plan, &attempts)?;
    let held = HeldModel { parts: taken(&attempts, &mut plan), why: why.clone() };
    if touching {
        let made = &plan.plan;
        let standing = support_solids(&made.plan, &made.workpiece(), &made.machine.profile);
        let below: Vec<Below<'_>> = attempts.iter().map(Attempt::below).collect();
        stand_alone(made, &below, &standing, options.margin_mm)?;
    }
    plan.story = Some(held.story(plan.best().seconds));
    Ok((plan, held))
}

/// Supports that hold all there is to hold of a part.
struct Attempt {
    part: usize,
    supports: PrintSupports,
    laid: Laid,
    /// What hangs without them, mm².
    contact_mm2: f64,
    /// Slot to machine.
    to_machine: Vec3,
}

impl Attempt {
    /// That of the least filament; `None` for a part that needs none.
    fn best(
        plan: &CheckedPlan,
        print: &Print,
        options: &PlanOptions,
        holding: Holding,
    ) -> Result<Option<Self>, Refused> {
        let process = &plan.machine.profile.process;
        let mesh = HeldMesh::of(&plan.plan, &plan.workpiece(), &plan.machine.profile.kinematics(), print);
        let (layer_mm, line_mm) = (process.layer_height_mm, process.line_width_mm);
        let overhang = options.overhang_deg.map_or_else(|| OverhangRule::practised(layer_mm, line_mm), Angle::from_deg);
        let (bridge_mm, droops) = (process.bridge_mm, options.finish == Finish::Practised);
        let rule = OverhangRule { overhang, layer_mm, line_mm, bridge_mm, tolerate_mm2: options.tolerate_mm2, droops };
        let gap_mm = GAP_LAYERS * process.layer_height_mm;
        let form = &options.form;
        let pitch_mm = form.roof_pitch_mm.unwrap_or(ROOF_WIDTHS * process.line_width_mm);
        if form.roof_mm > 0.0 && pitch_mm < process.line_width_mm {
            return Err(Refused::Roof { pitch_mm, width_mm: process.line_width_mm });
        }
        let roof = (form.roof_mm > 0.0).then_some(SupportRoof { height_mm: form.roof_mm, pitch_mm });
        let brace_mm = (form.brace_mm > 0.0).then_some(form.brace_mm);
        let overhang_deg = overhang.deg().clamp(1.0, 89.0);
        let of_step = |step_mm: f64| PrintSupports {
            step_mm,
            overhang_deg,
            gap_mm,
            roof,
            brace_mm,
            only_props: false,
            props: Vec::new(),
        };
        let begins_mm = mesh.begins_mm(&rule);
        let judge = judge(&mesh, &rule, &begins_mm);
        let Judged { hangs: bare, places, .. } = judge.judged(&SupportLines::default());
        let allowed = options.allow.iter().find(|(part, _)| *part == print.part).map(|(_, area)| *area);
        let carried = allowed.is_some_and(|area| area.is_none_or(|mm2| area_of(&bare) <= mm2));
        if bare.is_empty() || carried {
            return Ok(None);
        }
        let places = match holding {
            Holding::Usual => places,
            Holding::Firm | Holding::Dense => judge.judged_strictly(&SupportLines::default()).places,
        };
        let bare = Hanging { contact_mm2: area_of(&bare), places };
        // Whoever wants a roof has one below what columns hold.
        let [steps, sheets] = [&STEPS_MM, &PROP_STEPS_MM].map(|all| holding.of_steps(all).to_vec());
        let of_grid = steps.len();
        let sheets = sheets.into_iter().map(|step_mm| PrintSupports { only_props: true, ..of_step(step_mm) });
        let forms = steps.into_iter().map(of_step).chain(sheets.filter(|_| roof.is_none()));
        let tops = mesh.tops(process.layer_height_mm);
        let cuts = mesh.cuts(&mesh.keels(&rule, &tops, &begins_mm), &tops, gap_mm, process);
        let columns = |supports: PrintSupports| {
            let laid = Laid::columns(&mesh, &cuts, &supports, process);
            laid.map(|laid| (supports, laid)).map_err(Refused::from)
        };
        let forms: Vec<Result<(PrintSupports, Laid), Refused>> =
            forms.collect::<Vec<_>>().into_par_iter().map(columns).collect();
        let hanging = HangingPart { mesh: &mesh, cuts: &cuts, bare: &bare, judge: &judge, rule: &rule };
        let of = |(supports, columns): &(PrintSupports, Laid)| Self::of(plan, print, &hanging, supports, columns);
        Self::cheapest(&forms, of_grid, of).map(Some)
    }

    /// That of the least filament of what `of` makes of some kinds of supports and their columns, the first `of_grid` of these in grids; else why the
    /// finest does not do.
    fn cheapest(
        forms: &[Result<(PrintSupports, Laid), Refused>],
        of_grid: usize,
        of: impl Fn(&(PrintSupports, Laid)) -> Result<Self, Refused> + Sync,
    ) -> Result<Self, Refused> {
        // Props only add to columns: what these cost alone is the least, and what costs more than another is not looked at.
        let price = |supports: &PrintSupports, laid: &Laid| (free_beyond_mm(supports, laid), laid.length_mm());
        let is_less = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).is_lt();
        let least = |form: &Result<(PrintSupports, Laid), Refused>| {
            form.as_ref().map_or((0.0, 0.0), |(supports, columns)| price(supports, columns))
        };
        let mut order: Vec<(usize, (f64, f64))> = forms.iter().map(least).enumerate().collect();
        order.sort_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        // Where the cheapest do not do, the finest of either kind say whether any does.
        let (cheap, rest) = order.split_at(AT_ONCE.min(order.len()));
        let is_finest = |form: &usize| [of_grid - 1, forms.len() - 1].contains(form);
        let (finest, others): (Vec<_>, Vec<_>) = rest.iter().partition(|(form, _)| is_finest(form));
        let order: Vec<(usize, (f64, f64))> = cheap.iter().copied().chain(finest).chain(others).collect();
        let mut best: Option<((f64, f64), Self)> = None;
        let mut finest_left = (0..forms.len()).filter(is_finest).count();
        let mut of_finest = (0, Refused::NothingHangs { on_table: false });
        for some in order.chunks(AT_ONCE) {
            let may_be = |least: &(f64, f64)| best.as_ref().is_none_or(|(price, _)| is_less(least, price));
            let some: Vec<usize> = some.iter().filter(|(_, least)| may_be(least)).map(|(form, _)| *form).collect();
            let made = |form: usize| (form, forms[form].as_ref().map_err(Clone::clone).and_then(&of));
            let tried: Vec<(usize, Result<Self, Refused>)> = some.into_par_iter().map(made).collect();
            for (form, attempt) in tried {
                match attempt {
                    Ok(attempt) => {
                        let price = price(&attempt.supports, &attempt.laid);
                        if best.as_ref().is_none_or(|(least, _)| is_less(&price, least)) {
                            best = Some((price, attempt));
                        }
                    }
                    Err(why) if form >= of_finest.0 => of_finest = (form, why),
                    Err(_) => {}
                }
                finest_left -= usize::from(is_finest(&form));
            }
            if best.is_none() && finest_left == 0 {
                break;
            }
        }
        best.map(|(_, attempt)| attempt).ok_or(of_finest.1)
    }

    fn of(
        plan: &CheckedPlan,
        print: &Print,
        hanging: &HangingPart<'_>,
        supports: &PrintSupports,
        columns: &Laid,
    ) -> Result<Self, Refused> {
        let process = &plan.machine.profile.process;
        let &HangingPart { mesh, cuts, bare, judge, rule } = hanging;
        let (mut supports, mut laid) = (supports.clone(), columns.clone());
        // Where something hangs, what droops is held as well: a slicer's lines lie there as they come. What is propped may leave something in
        // other layers, and at first such sheets do as many places share.
        // What hangs in spite of them, as long as they are the same.
        let mut left: Option<Judged> = None;
        for round in 0..ROUNDS {
            let asked = |left: &Judged, counts: &dyn Fn(&HangingBox) -> bool| -> Vec<PropPlace> {
                let all = left.places.iter().filter(|place| counts(place));
                let layers = [mesh.slot.raised_mm, process.layer_height_mm];
                let all = all.map(|place| prop_place(place, layers, round > 0));
                all.filter(|one| !supports.props.contains(one)).collect()
            };
            let held = laid.held(&supports, rule);
            let mut new = asked(&judge.judged_strictly(&held), &|place| bare.is_about(place));
            if new.is_empty() {
                new = asked(left.insert(judge.judged(&held)), &|_| true);
            }
            if new.is_empty() || supports.props.len() + new.len() > PrintSupports::MOST_PROPS {
                break;
            }
            supports.props.extend(new);
            laid = columns.clone();
            laid.prop(cuts, &supports);
            left = None;
        }
        let left = left.unwrap_or_else(|| judge.judged(&laid.held(&supports, rule))).hangs;
        if let Some(patch) = left.first() {
            let bare_mm2 = laid.bare.iter().map(|bare| bare.area_mm2).sum();
            if mesh.is_in_joint(&patch.at) {
                let gap_mm = OverhangRule::OTHERS_LAYERS * process.layer_height_mm;
                return Err(Refused::Captive { area_mm2: area_of(&left), at: patch.at, gap_mm });
            }
            return Err(Refused::StillHangs { area_mm2: area_of(&left), worst: *patch, bare_mm2 });
        }
        let (contact_mm2, to_machine) = (bare.contact_mm2, mesh.slot.to_machine);
        let attempt = Self { part: print.part, supports, laid, contact_mm2, to_machine };
        attempt.fits(plan, print)?;
        Ok(attempt)
    }

    /// Whether they stand on the table, and within the axes.
    fn fits(&self, plan: &CheckedPlan, print: &Print) -> Result<(), Refused> {
        let profile = &plan.machine.profile;
        let bounds = self.laid.bounds();
        if bounds.is_empty() {
            return Ok(());
        }
        let (limits, table) = (profile.linear_limits(), profile.kinematics());
        let axes = bounds.corners().map(|p| table.axes_at(p + self.to_machine, print.pose(&table)));
        if let Some(out) = axes.iter().find_map(|axes| limits.violation(axes)) {
            return Err(Refused::Axes(out.to_string()));
        }
        let half = profile.process.line_width_mm / 2.0;
        let beyond = self.feet(profile, print).map(|[x, y]| profile.beyond_table(x, y) + half);
        let most = beyond.fold(f64::NEG_INFINITY, f64::max);
        if most > 0.0 {
            return Err(Refused::BeyondTable { mm: most });
        }
        Ok(())
    }

    /// Ends of the lines of their lowest layer, table frame.
    fn feet(&self, profile: &Profile, print: &Print) -> impl Iterator<Item = PlanePoint> {
        let motion = profile.kinematics().forward(print.pose(&profile.kinematics())).inverse();
        let ends = self.laid.layers.first().into_iter().flat_map(|layer| layer.lines.iter().flatten());
        ends.map(move |p| {
            let at = motion.point((Vec3::new(p[0], p[1], 0.0) + self.to_machine).into()).at;
            [at.x, at.y]
        })
    }

    /// What they press on the table; nothing where all of them stand on the part.
    fn foot(&self, plan: &CheckedPlan) -> Foot {
        let mut foot = Foot::default();
        let on_table = self.laid.layers.first().is_some_and(|layer| layer.span_mm[0] < ON_TABLE_MM);
        let mut prints = plan.plan.prints().filter(|(_, print)| print.part == self.part && on_table);
        if let Some((_, print)) = prints.next() {
            self.feet(&plan.machine.profile, print).for_each(|at| foot.touches(at));
            foot.settle();
        }
        foot
    }

    fn below(&self) -> Below<'_> {
        let middle = |[low, high]: [f64; 2]| f64::midpoint(low, high);
        let layers = self.laid.layers.iter().map(|layer| (middle(layer.span_mm), &layer.lines[..])).collect();
        Below { part: self.part, layers, to_machine: self.to_machine }
    }

    /// Whether a line of them comes nearer than `room_mm` to what `distance` tells of, seen from above.
    fn comes_near(&self, distance: impl Fn(PlanePoint) -> f64 + Copy, room_mm: f64) -> bool {
        self.lines().any(|line| march(line, |p| distance(p) - room_mm).any(|(_, room)| room < 0.0))
    }

    /// Their lines, machine frame, seen from above.
    fn lines(&self) -> impl Iterator<Item = Segment> {
        let at = |p: &PlanePoint| [p[0] + self.to_machine.x, p[1] + self.to_machine.y];
        self.laid.layers.iter().flat_map(|layer| &layer.lines).map(move |[a, b]| [at(a), at(b)])
    }
}

/// By how much a column stands free over more than it should, mm.
fn free_beyond_mm(supports: &PrintSupports, laid: &Laid) -> f64 {
    supports.brace_mm.map_or(0.0, |most| (laid.longest_free_mm - most).max(0.0))
}

/// A part of which something hangs, as each kind of supports is tried on it.
struct HangingPart<'a> {
    mesh: &'a HeldMesh,
    cuts: &'a Cuts,
    bare: &'a Hanging,
    judge: &'a LayerJudge,
    rule: &'a OverhangRule,
}

/// What of a part hangs without supports.
struct Hanging {
    contact_mm2: f64,
    places: Vec<HangingBox>,
}

impl Hanging {
    /// Whether something hangs about a place.
    fn is_about(&self, place: &HangingBox) -> bool {
        self.places.iter().any(|own| {
            let [low, high] = own.within_mm;
            let within =
                |i: usize| place.within_mm[0][i] <= high[i] + ABOUT_MM && place.within_mm[1][i] >= low[i] - ABOUT_MM;
            (own.under_mm - place.under_mm).abs() < ABOUT_MM && within(0) && within(1)
        })
    }
}

/// The box of a place in whole digits, and no smaller than it is; the part's layers begin at `from_mm`.
fn prop_place(place: &HangingBox, [from_mm, layer_mm]: [f64; 2], middle: bool) -> PropPlace {
    let digits = |v: f64, to: fn(f64) -> f64| to(v / PLACE_MM) * PLACE_MM;
    let [low, high] = place.within_mm;
    let under_mm = from_mm + ((place.under_mm - from_mm) / layer_mm).round() * layer_mm;
    PropPlace {
        middle,
        under_mm: round_to(under_mm, 4),
        within_mm: [low.map(|v| round_to(digits(v, f64::floor), 3)), high.map(|v| round_to(digits(v, f64::ceil), 3))],
    }
}

fn area_of(patches: &[Patch]) -> f64 {
    patches.iter().map(|patch| patch.area_mm2).sum()
}

/// Whether the supports of two parts come nearer to each other than two lines, seen from above.
fn mixed(plan: &CheckedPlan, held: &[Attempt]) -> Result<(), Refused> {
    let name = |part: usize| part_named(part, &plan.model.model.parts[part].name);
    let room_mm = 2.0 * plan.machine.profile.process.line_width_mm;
    for (place, one) in held.iter().enumerate() {
        let there = Segments::new(one.lines().collect());
        let distance = |p: PlanePoint| there.nearest(p, FAR_MM, None).map_or(FAR_MM, |nearest| nearest.distance);
        if let Some(other) = held[place + 1..].iter().find(|other| other.comes_near(distance, room_mm)) {
            return Err(Refused::Meet { part: name(one.part), other: name(other.part) });
        }
    }
    Ok(())
}

/// Puts them into the plan.
fn taken(held: &[Attempt], plan: &mut PlanResult) -> Vec<HeldPart> {
    let of_part =
        |part: usize| held.iter().find(|attempt| attempt.part == part).map(|attempt| attempt.supports.clone());
    let hold = |slots: &mut Vec<TimeSlot>| {
        slots.iter_mut().flat_map(|slot| &mut slot.prints).for_each(|print| print.supports = of_part(print.part));
    };
    hold(&mut plan.plan.plan.slots);
    hold(&mut plan.plans[0].slots);
    let formed = |attempt: &Attempt| attempt.supports.roof.is_some() || attempt.supports.brace_mm.is_some();
    let propped = |attempt: &Attempt| !attempt.supports.props.is_empty();
    plan.plan.plan.version = match () {
        () if held.iter().any(propped) => Plan::WITH_PROPS,
        () if held.iter().any(formed) => Plan::WITH_FORM,
        () => Plan::WITH_SUPPORTS,
    };
    plan.plan.sha256 = plan.plan.plan.sha256();
    let feet: Vec<(usize, Foot)> = held.iter().map(|attempt| (attempt.part, attempt.foot(&plan.plan))).collect();
    plan.standing = standing(&plan.plan.plan, &plan.plan.workpiece(), &plan.plan.machine.profile, &feet);
    let process = &plan.plan.machine.profile.process;
    let section_mm2 = process.line_width_mm * process.layer_height_mm;
    let cost = |attempt: &Attempt| {
        let length_mm = attempt.laid.length_mm();
        HeldPart {
            part: attempt.part,
            supports: attempt.supports.clone(),
            volume_mm3: length_mm * section_mm2,
            seconds: length_mm / process.infill_mm_per_s + LINE_S * attempt.lines().count() as f64,
            longest_free_mm: attempt.laid.longest_free_mm,
            contact_mm2: attempt.contact_mm2,
        }
    };
    let parts: Vec<HeldPart> = held.iter().map(cost).collect();
    plan.plans[0].seconds += parts.iter().map(|held| held.seconds).sum::<f64>();
    parts
}
