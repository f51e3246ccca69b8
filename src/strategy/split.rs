//! One solid cut into parts that print without supports, or what stands against it.

use std::fmt::Write;

use super::arrange::{Arrangement, Models, PoseChoice, ReadModels, arranged_aloud};
use super::error::StrategyError;
use super::plan::{CAREFUL_DEG, Finish, PlanOptions};
use super::uncut::Uncut;
use crate::geom::{Angle, Bounds, Object, Rigid, Vec3};
use crate::input::{
    BadSetting, LoadedModel, LoadedProfile, MachineSource, ModelSource, load_aloud, load_profile, spanning,
};
use crate::mesh::threemf;
use crate::overhang::TOLERATE_MM2;
use crate::pictures;
use crate::planning::{FREE_SPAN_MM, OnePrint, centred};
use crate::spelling::{counted, numbers};
use crate::split::{Against, CutBudget, CutMade, CutOptions, PinnedCut, Plane, Split, Splitter};
use crate::view::Drawing;
use crate::world::World;

/// A model and a machine, and how to cut.
#[derive(Clone, Debug)]
pub struct SplitRequest {
    /// The model: one closed solid, or several of which `part` says which.
    pub model: ModelSource,
    /// The part of the model that is cut; `None`: its only one.
    pub part: Option<usize>,
    /// The machine.
    pub machine: MachineSource,
    /// Which way the solid stands before it is cut.
    pub standing: PoseChoice,
    /// How.
    pub options: SplitOptions,
}

/// How to cut; the default is what the command does without flags.
#[derive(Clone, Debug, PartialEq)]
pub struct SplitOptions {
    /// Slopes up to this angle from the vertical are fine; `None`: as lines of the profile's width and layers are.
    pub overhang_deg: Option<f64>,
    /// How well it is to come out.
    pub finish: Finish,
    /// What a line may span between two ends on material; `None`: the machine's `process.bridge_mm`.
    pub bridge_mm: Option<f64>,
    /// What a connected patch may have that nothing carries, mm².
    pub tolerate_mm2: f64,
    /// Room the head keeps from parts it does not print on.
    pub margin_mm: f64,
    /// Most cuts.
    pub max_cuts: usize,
    /// What may still need support in the end; half a square millimetre a part passes as rounding.
    pub allow_mm2: f64,
    /// Whether everything beyond a plane goes.
    pub strict: bool,
    /// Where no seam may come: corners of boxes, the file's frame, mm.
    pub no_cut: Vec<[[f64; 3]; 2]>,
    /// Cuts that are made first, in this order, whatever they gain.
    pub cuts: Vec<GivenCut>,
    /// Height of a part below the model; `None`: none, and some heights where nothing else helps.
    pub pedestal_mm: Option<f64>,
    /// What the cuts may cost; `None`: whatever it takes.
    pub budget: Option<CutBudget>,
    /// So many cuts are tried; then the search ends with the best so far.
    pub tries: u64,
}

impl Default for SplitOptions {
    fn default() -> Self {
        Self {
            overhang_deg: None,
            finish: Finish::Practised,
            bridge_mm: None,
            tolerate_mm2: TOLERATE_MM2,
            margin_mm: 0.5,
            max_cuts: 12,
            allow_mm2: 0.0,
            strict: false,
            no_cut: Vec::new(),
            cuts: Vec::new(),
            pedestal_mm: None,
            budget: None,
            tries: PlanOptions::default().budget,
        }
    }
}

/// A cut that somebody has decided: what lies beyond a plane is printed along its normal. The part's own file's frame, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenCut {
    /// Which part is cut, and its copies with it; `None`: the only one.
    pub part: Option<usize>,
    /// The plane's normal, of any length but none.
    pub normal: [f64; 3],
    /// Distance of the plane from the origin along the normal.
    pub offset_mm: f64,
    /// Of the solids beyond the plane those that one of these points lies in go; all of them where there is no point.
    pub points: Vec<[f64; 3]>,
}

impl GivenCut {
    fn pinned(&self) -> PinnedCut {
        let plane = Plane { normal: self.unit(), offset_mm: self.offset_mm };
        PinnedCut { plane, points: self.points.iter().copied().map(Vec3::from).collect() }
    }

    /// The normal: as it was written, where it is a unit already.
    fn unit(&self) -> Vec3 {
        let normal = Vec3::from(self.normal);
        if (normal.norm() - 1.0).abs() < UNIT { normal } else { normal.normalize() }
    }

    /// The same cut of a part that was moved so.
    pub(super) fn moved(&self, by: &Rigid<Object, Object>) -> Self {
        let normal = by.rotation * self.unit();
        let point = |point: &[f64; 3]| (by.rotation * Vec3::from(*point) + by.translation).into();
        Self {
            part: self.part,
            normal: normal.into(),
            offset_mm: self.offset_mm + normal.dot(&by.translation),
            points: self.points.iter().map(point).collect(),
        }
    }

    /// The one that makes this cut again, of the only part.
    pub fn of(cut: &CutMade) -> Self {
        let plane = &cut.plane;
        let points = cut.points.iter().map(|point| (*point).into()).collect();
        Self { part: None, normal: plane.normal.into(), offset_mm: plane.offset_mm, points }
    }

    /// As [`GivenCut::parsed`] reads it, to the last bit.
    pub fn words(&self) -> String {
        let [x, y, z] = self.normal;
        let point = |[x, y, z]: &[f64; 3]| format!("@{x},{y},{z}");
        let part = self.part.map_or_else(String::new, |part| format!("{part}:"));
        format!("{part}{x},{y},{z},{}{}", self.offset_mm, self.points.iter().map(point).collect::<String>())
    }

    /// The part, normal and distance, and points behind an @ each: `[PART:]X,Y,Z,OFFSET[@X,Y,Z]..`.
    pub fn parsed(text: &str) -> Option<Self> {
        let (part, text) = match text.split_once(':') {
            Some((part, rest)) => (Some(part.parse().ok()?), rest),
            None => (None, text),
        };
        let mut words = text.split('@');
        let [x, y, z, offset_mm] = numbers(words.next()?)?;
        let points = words.map(numbers).collect::<Option<Vec<[f64; 3]>>>()?;
        let normal = [x, y, z];
        (Vec3::from(normal).norm() > LEAST_NORMAL).then_some(Self { part, normal, offset_mm, points })
    }
}

/// What is as long as a unit to within this is one.
const UNIT: f64 = 1e-12;
/// A normal is no shorter than this.
const LEAST_NORMAL: f64 = 1e-6;

/// Pedestals that are tried where the head meets the table, mm.
const PEDESTALS_MM: [f64; 3] = [10.0, 20.0, 40.0];

/// A model in parts.
#[derive(Clone, Debug)]
pub struct SplitResult {
    /// The parts and the cuts; see [`Split::printable`] for whether it worked.
    pub split: Split,
    /// The model, as it stands.
    pub model: LoadedModel,
    /// How it was stood up, where it does not stand as drawn.
    pub stood: Option<String>,
    /// Height of the pedestal, mm; 0 for none.
    pub pedestal_mm: f64,
    /// Surfaces up to this angle from the vertical were taken to need no support.
    pub overhang_deg: f64,
    /// What it took.
    pub seconds: f64,
}

impl SplitResult {
    /// The parts as 3MF, mm, in the order of printing, each named after the solid and the cut that took it.
    pub fn threemf(&self) -> Vec<u8> {
        let named = self.split.named(&self.model.called(0));
        threemf(&named.iter().map(|(name, mesh)| (name.clone(), mesh)).collect::<Vec<_>>())
    }

    /// The solid with what overhangs, and its parts in colours, where they were and apart.
    pub fn view(&self) -> Drawing {
        let story = self.why_not().iter().map(ToString::to_string).collect();
        let (mesh, angle) = (&self.model.model.parts[0].mesh, Angle::from_deg(self.overhang_deg));
        pictures::cut_up(mesh, angle, &self.split, story).drawing()
    }

    /// The cuts, a line each, and what they come to.
    pub fn text(&self) -> String {
        let split = &self.split;
        let mut out = self.stood.as_ref().map_or_else(String::new, |stood| format!("{stood}\n"));
        for (k, cut) in split.cuts.iter().enumerate() {
            let (n, c) = (cut.plane.normal, cut.plane.offset_mm);
            let parts: Vec<String> = cut.parts.iter().map(ToString::to_string).collect();
            let _ = writeln!(
                out,
                "cut {}: {:.4} x {:+.4} y {:+.4} z > {c:.3} mm becomes part {}, seam {:.1} mm2; {}",
                k + 1,
                n.x,
                n.y,
                n.z,
                parts.join(", "),
                cut.seam_mm2,
                cut.reason()
            );
        }
        let (before, after) = (split.before.area_mm2, split.after.area_mm2);
        let _ = writeln!(
            out,
            "{}, {}, seams {:.1} mm2; needs support: {before:.1} mm2 before, {after:.1} after; {:.2} s",
            counted(split.parts.len(), "part"),
            counted(split.setups(), "setup"),
            split.seam_mm2(),
            self.seconds
        );
        out
    }

    /// Why the parts cannot be printed, where that is so.
    pub fn why_not(&self) -> Option<Uncut> {
        let Split { printable, cuts, parts, before, after, left, unplanned, refused, .. } = &self.split;
        if *printable {
            return None;
        }
        if let Some((place, against)) = self.split.unpinned {
            return Some(Uncut::Pinned { number: place + 1, against });
        }
        if let Some(tried) = self.split.stopped {
            return Some(Uncut::Stopped { tried });
        }
        let cuts = cuts.len();
        if *unplanned > 0 && left.iter().map(|p| p.area_mm2).sum::<f64>() < 0.5 * parts.len() as f64 {
            return Some(Uncut::Unplanned { cuts, parts: parts.len() });
        }
        let against = refused.iter().max_by_key(|(against, count)| (*count, *against)).copied();
        Some(Uncut::Left {
            cuts,
            before_mm2: before.area_mm2,
            after: *after,
            worst: left.first().copied(),
            against: against.map(|(against, count)| (against, count, refused.iter().map(|r| r.1).sum())),
        })
    }
}

/// Cuts a solid.
///
/// # Errors
///
/// [`StrategyError::NotOneSolid`], [`StrategyError::Setting`], [`StrategyError::Misplaced`], and what reading model and machine may say. That cutting
/// does not help is a result.
pub fn split(request: &SplitRequest, world: &World<'_>) -> Result<SplitResult, StrategyError> {
    let options = &SplitOptions { cuts: of_part(&request.options.cuts, request.part)?, ..request.options.clone() };
    check(options)?;
    let machine = spanning(load_profile(&request.machine, world)?, options.bridge_mm)?;
    if request.standing == PoseChoice::AsDrawn {
        let model = load_aloud(&request.model, world)?;
        let model = request.part.map_or_else(|| Ok(model.clone()), |part| model.alone(part))?;
        return cut_up(model, &machine, options, world);
    }
    if !options.no_cut.is_empty() || !options.cuts.is_empty() {
        return Err(BadSetting::TurnedBoxes.into());
    }
    let how = Arrangement { standing: request.standing, snap_mm: 0.0, ..Arrangement::default() };
    let read = ReadModels::read(&request.model, &how, world)?;
    let read = &if let Some(part) = request.part { read.alone(part)? } else { read };
    let set = arranged_aloud(&Models { read, how: &how, machine: &machine }, world)?;
    let stood = set.arranged.map(|arranged| arranged.changes.join("; "));
    Ok(SplitResult { stood, ..cut_up(set.model, &machine, options, world)? })
}

/// The cuts as those of the only part, where they are of this one.
fn of_part(cuts: &[GivenCut], part: Option<usize>) -> Result<Vec<GivenCut>, BadSetting> {
    let Some(part) = part else { return Ok(cuts.to_vec()) };
    if cuts.iter().any(|cut| cut.part.is_some_and(|of| of != part)) {
        return Err(BadSetting::UnwantedCut { other: "part" });
    }
    Ok(cuts.iter().map(|cut| GivenCut { part: None, ..cut.clone() }).collect())
}

/// Cuts a model that is loaded already.
pub(super) fn cut_up(
    model: LoadedModel,
    machine: &LoadedProfile,
    options: &SplitOptions,
    world: &World<'_>,
) -> Result<SplitResult, StrategyError> {
    check(options)?;
    let start = world.clock.now();
    let [part] = &model.model.parts[..] else {
        return Err(StrategyError::NotOneSolid { file: model.file, parts: model.model.parts.len() });
    };
    if let Some(given) = options.cuts.iter().filter_map(|cut| cut.part).find(|part| *part > 0) {
        return Err(BadSetting::NoSuchPart { name: "cut", given, last: 0, model: model.file }.into());
    }
    let placement = centred(&model.model, &machine.profile)?;
    let process = &machine.profile.process;
    let overhang_deg = options.overhang_deg.unwrap_or(CAREFUL_DEG);
    let overhang = Angle::from_deg(overhang_deg);
    let wanted = CutOptions {
        overhang,
        steepest: options.overhang_deg.map(Angle::from_deg),
        droops: options.finish == Finish::Practised,
        layer_mm: process.layer_height_mm,
        span_mm: FREE_SPAN_MM.max(2.0 * process.line_width_mm),
        bridge_mm: process.bridge_mm,
        line_mm: process.line_width_mm,
        tolerate_mm2: options.tolerate_mm2,
        max_cuts: options.max_cuts,
        allow_mm2: options.allow_mm2,
        strict: options.strict,
        budget: options.budget,
        tries: options.tries,
        no_cut: options.no_cut.iter().map(|b| Bounds::of(b.map(Vec3::from))).collect(),
        pinned: options.cuts.iter().map(GivenCut::pinned).collect(),
        ..CutOptions::default()
    };
    let mut head = OnePrint::new(&machine.profile, placement, overhang, options.margin_mm);
    (head.steepest, head.droops) = (wanted.steepest, wanted.droops);
    let mut splitter = Splitter::new(&part.mesh, |up| head.reaches(up), wanted);
    let mut attempt = |pedestal_mm: f64| {
        let bar = world.progress.begin("cuts", options.max_cuts);
        let mut head = head.clone();
        head.pedestal_mm = pedestal_mm;
        splitter.split(&head, pedestal_mm, &mut |level| {
            bar.at(level);
            !world.progress.enough()
        })
    };
    let mut pedestal_mm = options.pedestal_mm.unwrap_or(0.0);
    let mut split = attempt(pedestal_mm);
    let head =
        split.refused.iter().map(|(against, _)| against).chain(split.unpinned.iter().map(|(_, against)| against));
    let low = split.unplanned > 0 || head.into_iter().any(|against| *against == Against::Head);
    let seek = !split.printable && split.stopped.is_none() && options.pedestal_mm.is_none() && low;
    if let Some((mm, better)) = seek.then(|| on_a_pedestal(&split, attempt)).flatten() {
        (pedestal_mm, split) = (mm, better);
        world.progress.warning(&format!("the model stands on a pedestal of {mm} mm, which the head needs to reach it"));
    }
    if split.crumbs_mm3 > 0.0 {
        let crumbs = split.crumbs_mm3;
        world.progress.warning(&format!("removed pieces too small to print ({crumbs:.4} mm3 in total)"));
    }
    let seconds = (world.clock.now() - start).as_secs_f64();
    Ok(SplitResult { split, stood: None, pedestal_mm, overhang_deg, seconds, model })
}

/// The lowest pedestal on which nothing needs support, or on which more of the pinned cuts can be made. The tallest gives the head the most room and is asked first: where it leaves
/// something, and no more than is left on none, a lower one would as well; where it leaves more, it does not fit below the frame.
fn on_a_pedestal(on_none: &Split, mut attempt: impl FnMut(f64) -> Split) -> Option<(f64, Split)> {
    let [lower @ .., tallest] = PEDESTALS_MM;
    let made = |split: &Split| split.unpinned.map_or(usize::MAX, |(place, _)| place);
    let helps = |split: &Split| split.printable || made(split) > made(on_none);
    let on_tallest = attempt(tallest);
    if !helps(&on_tallest) && on_tallest.after.area_mm2 <= on_none.after.area_mm2 {
        return None;
    }
    let lower = lower.into_iter().map(|mm| (mm, attempt(mm))).find(|(_, split)| helps(split));
    lower.or_else(|| helps(&on_tallest).then_some((tallest, on_tallest)))
}

fn check(options: &SplitOptions) -> Result<(), BadSetting> {
    BadSetting::within("overhang", options.overhang_deg.unwrap_or(CAREFUL_DEG), " deg", [1.0, 89.0])?;
    BadSetting::within("tolerate", options.tolerate_mm2, " mm2", [0.0, 1e6])?;
    BadSetting::within("margin", options.margin_mm, " mm", [0.0, 100.0])?;
    BadSetting::within("max-cuts", options.max_cuts as f64, "", [options.cuts.len() as f64, 100.0])?;
    BadSetting::within("allow", options.allow_mm2, " mm2", [0.0, 1e6])?;
    BadSetting::within("pedestal", options.pedestal_mm.unwrap_or(0.0), " mm", [0.0, 200.0])
}
