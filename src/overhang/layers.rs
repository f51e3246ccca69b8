//! The rule layer by layer: what a layer has beyond the one below, how far out it is, and for how many layers in a row.
//!
//! ```text
//! over(i)    = layer(i) less layer(i - 1), less supports and whatever else it lies on
//! beyond(i)  = over(i) farther than `Rule::fine_mm` from those; the rest is fine, without end
//!   of that  less than a layer of air below      droops: no slicer can put anything there
//!            on chords of a bridge               fine up to `FINE_BRIDGE_MM`, droops up to `Rule::bridge_mm`
//!            farther out than lines hang free    hangs
//!            what is left                        droops, and is remembered: see `memory.rs`
//! ```
//!
//! What was found to hang, to droop or to be bridged counts as there from then on.
//!
//! Layers are cut in their middle, as slicers cut them, from the part's lowest point up. Only those are looked at between which a
//! facet looks down by more than the threshold: between all others the surface goes out by no more than the threshold allows.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use std::sync::{Arc, OnceLock};

use super::OverhangRule;
use super::answers::{Answer, Answers, Question};
use super::ground::{Footing, Ground, SupportLines};
use super::keels::Keels;
use super::memory::Memory;
use super::patch::{Frame, Judged, Patch, Piece};
use super::region::{Region, and, bounds, covered, enclosed, or, strips, with_few_points};
use super::step::{Below, Step};
use crate::geom::{Mat3, Slot, Vec3};
use crate::mesh::TriangleMesh;
use crate::section::Sections;

/// Rounding of normals: an overhang of exactly the threshold is none.
const SINE_SLACK: f64 = 1e-6;
/// Heights that differ by less than this share of a layer are one.
const NEAR_LAYERS: f64 = 1e-3;
/// Beyond the ends of the longest bridge nothing counts that is farther than this, mm: a line, and what may hang free of it.
const REACH_MM: f64 = 5.0;
/// What a beginning is worth beside facets, mm²: where there are both, it says no first.
const BEGINNING_MM2: f64 = 100.0;
/// A face whose normal leans up or down by less than this (sine) covers nothing: 0.3 micrometres in a layer of 0.3 mm.
const EDGE_ON: f64 = 1e-3;

/// What `mesh` printed along `up` lays on nothing, the largest first, patches that `rule` tolerates left out. It stands on `ground`;
/// facets that `stands` says yes to are of it, and need not be looked at. With `enough` the search ends as soon as there is
/// a patch that is not tolerated.
///
/// Where steep facets meet in a point or a ridge in the air is [`Relief`](super::Relief)'s to say: see [`Ground::begins_mm`].
pub fn unsupported<F>(
    mesh: &TriangleMesh<F>,
    up: &Vec3,
    ground: &Ground,
    stands: impl Fn(usize) -> bool,
    rule: &OverhangRule,
    enough: bool,
) -> Vec<Patch> {
    judged(mesh, up, ground, stands, rule, enough).hangs
}

/// As [`unsupported`], with what droops.
pub fn judged<F>(
    mesh: &TriangleMesh<F>,
    up: &Vec3,
    ground: &Ground,
    stands: impl Fn(usize) -> bool,
    rule: &OverhangRule,
    enough: bool,
) -> Judged {
    LayerJudge::of(mesh, up, ground, stands, rule).by(rule, &ground.held, enough)
}

/// A part whose layers are judged again and again, on other supports each time: what is the same whatever the supports is found out once.
pub struct LayerJudge {
    stack: Stack,
    /// The layers in which something begins.
    begins: BTreeSet<usize>,
    /// Those to look at.
    runs: Vec<RangeInclusive<usize>>,
}

impl LayerJudge {
    /// As [`judged`] takes them; the supports of `ground` do not count. What slicers leave out where something [begins](Keels) is not there.
    pub fn of<F>(
        mesh: &TriangleMesh<F>,
        up: &Vec3,
        ground: &Ground,
        stands: impl Fn(usize) -> bool,
        rule: &OverhangRule,
    ) -> Self {
        let mut stack = Stack::of(mesh, up, ground, rule);
        let middles: Vec<f64> = (0..stack.answers.len()).map(|i| stack.middle(Some(i))).collect();
        stack.keels = Keels::of(&stack.sections, &middles, &ground.begins_mm, rule);
        let mut begins = stack.beginnings(&ground.begins_mm);
        // Above a keel something begins as well.
        begins.extend(stack.keels.layers().map(|i| i + 1).filter(|i| *i < stack.answers.len()));
        let is_free = stack.rule.fine_mm().is_infinite();
        let runs = if is_free { Vec::new() } else { stack.steep(mesh, up, stands, &begins) };
        Self { stack, begins, runs }
    }

    /// What hangs and droops on such supports.
    pub fn judged(&self, held: &SupportLines) -> Judged {
        self.by(&self.stack.rule, held, false)
    }

    /// The same where nothing may droop.
    pub fn judged_strictly(&self, held: &SupportLines) -> Judged {
        self.by(&OverhangRule { droops: false, ..self.stack.rule }, held, false)
    }

    /// By a rule that differs from the stack's in [`OverhangRule::droops`] at most.
    fn by(&self, rule: &OverhangRule, held: &SupportLines, enough: bool) -> Judged {
        let mut found = Judged::default();
        for run in &self.runs {
            let Judged { hangs, places, droops } = self.stack.patches(run.clone(), &self.begins, rule, held, enough);
            found.hangs.extend(hangs);
            found.places.extend(places);
            found.droops.extend(droops);
            if enough && !found.hangs.is_empty() {
                break;
            }
        }
        found.hangs.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2));
        found.droops.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2));
        found
    }
}

/// The layers of an upright part, cut as they are asked for.
struct Stack {
    rule: OverhangRule,
    /// To the upright frame.
    upright: Mat3,
    sections: Sections,
    low: f64,
    high: f64,
    /// Of what lies on something: the facets upright, and what is below them, whole.
    footings: Vec<(Vec<[Vec3; 3]>, Option<Region>)>,
    table: bool,
    /// Of what grows beside it.
    others: Option<Sections>,
    /// What of it is not there.
    keels: Keels,
    /// By layer what of it is not fine without supports, once that is known.
    beyond: Vec<OnceLock<Region>>,
    /// By layer whether something of it is an island without supports, once that is known.
    has_islands: Vec<OnceLock<bool>>,
    /// By layer what was asked of it last, and answered.
    answers: Vec<Answers>,
}

impl Stack {
    fn of<F>(mesh: &TriangleMesh<F>, up: &Vec3, ground: &Ground, rule: &OverhangRule) -> Self {
        let across = Vec3::ith(if up.z.abs() > 0.999 { 1 } else { up.iamin() }, 1.0).cross(up).normalize();
        let upright = Mat3::from_rows(&[across.transpose(), up.cross(&across).transpose(), up.transpose()]);
        let turned = mesh.vertices().iter().map(|v| upright * v).collect();
        let sections = Sections::of(&TriangleMesh::<Slot>::new(turned, mesh.facets().to_vec()));
        let [low, high] = sections.range();
        let all = |facets: &[[Vec3; 3]]| facets.iter().map(|f| f.map(|p| upright * p)).collect::<Vec<_>>();
        let footing = |one: &Footing| {
            let below = (!one.below.is_empty()).then(|| seen(&all(&one.below), [f64::NEG_INFINITY, f64::INFINITY]));
            (all(&one.own), below)
        };
        let footings = ground.footings.iter().map(footing).collect();
        let others = ground.others.as_ref().map(|mesh| {
            let turned = mesh.vertices().iter().map(|v| upright * v).collect();
            Sections::of(&TriangleMesh::<Slot>::new(turned, mesh.facets().to_vec()))
        });
        let (rule, table) = (*rule, ground.table);
        let (keels, beyond, has_islands, answers) = Default::default();
        let mut stack =
            Self { rule, upright, sections, low, high, footings, table, others, keels, beyond, has_islands, answers };
        let layers = if low.is_finite() && high.is_finite() { stack.number(high) + 1 } else { 0 };
        stack.beyond.resize_with(layers, OnceLock::new);
        stack.has_islands.resize_with(layers, OnceLock::new);
        stack.answers.resize_with(layers, Answers::default);
        stack
    }

    /// The middle of layer `i`, upright; of the layer below the first, infinitely low.
    fn middle(&self, i: Option<usize>) -> f64 {
        i.map_or(f64::NEG_INFINITY, |i| self.low + (i as f64 + 0.5) * self.rule.layer_mm)
    }

    /// The first layer whose middle does not lie below `z`; the last one for what is higher.
    fn number(&self, z: f64) -> usize {
        let number = |z: f64| (z - self.low) / self.rule.layer_mm;
        let last = (number(self.high) - 0.5).ceil() - 1.0;
        (number(z) + 0.5).floor().clamp(0.0, last.max(0.0)) as usize
    }

    /// The layers in which something that begins so high is cut first, and those above them: in the middle of a layer a point is nothing.
    fn beginnings(&self, begins_mm: &[f64]) -> BTreeSet<usize> {
        let near = NEAR_LAYERS * self.rule.layer_mm;
        begins_mm.iter().flat_map(|z| self.number(z - near)..=self.number(z + near + self.rule.layer_mm)).collect()
    }

    /// The layers to look at, in runs of neighbours; the run with the most area at stake first.
    fn steep<F>(
        &self,
        mesh: &TriangleMesh<F>,
        up: &Vec3,
        stands: impl Fn(usize) -> bool,
        begins: &BTreeSet<usize>,
    ) -> Vec<RangeInclusive<usize>> {
        let near = NEAR_LAYERS * self.rule.layer_mm;
        let sine = self.rule.overhang.rad().sin() + SINE_SLACK;
        let mut stake: BTreeMap<usize, f64> = BTreeMap::new();
        for facet in 0..mesh.facets().len() {
            let steep = mesh.normal(facet).is_some_and(|n| n.dot(up) < -sine);
            if !steep || stands(facet) {
                continue;
            }
            let z = mesh.corners(facet).map(|p| p.dot(up));
            let lowest = self.number(z.iter().copied().fold(f64::INFINITY, f64::min) - near);
            let highest = self.number(z.iter().copied().fold(f64::NEG_INFINITY, f64::max) + near);
            let share = mesh.facet_area(facet) / (highest - lowest + 1) as f64;
            (lowest..=highest).for_each(|i| *stake.entry(i).or_default() += share);
        }
        begins.iter().for_each(|i| *stake.entry(*i).or_default() += BEGINNING_MM2);
        let layers: Vec<(usize, f64)> = stake.into_iter().collect();
        let mut runs: Vec<&[(usize, f64)]> = layers.chunk_by(|a, b| b.0 == a.0 + 1).collect();
        let sum = |run: &[(usize, f64)]| run.iter().map(|(_, area)| area).sum::<f64>();
        runs.sort_by(|a, b| sum(b).total_cmp(&sum(a)));
        runs.into_iter().map(|run| run[0].0..=run[run.len() - 1].0).collect()
    }

    fn layer(&self, i: usize) -> Region {
        self.keels.rest(i, enclosed(&self.sections.segments_at(self.middle(Some(i)))))
    }

    /// What grows beside it no more than two layers of air below layer `i`: of a support there would be one layer, with one of air, and in the gap
    /// of a joint nobody could take it out.
    fn nearly_below(&self, i: usize) -> Region {
        let Some(others) = &self.others else { return Region::new() };
        let at = |layers: f64| enclosed(&others.segments_at(self.middle(Some(i)) - layers * self.rule.layer_mm));
        [1.0, 2.0, OverhangRule::OTHERS_LAYERS + NEAR_LAYERS]
            .map(at)
            .into_iter()
            .reduce(|a, b| or(&a, &b))
            .unwrap_or_default()
    }

    /// What is there below layer `i`: what of the layer below is `carried`, and whatever else.
    fn below(&self, i: usize, carried: Region, supports: &Region) -> Region {
        let band = [self.middle(i.checked_sub(1)), self.middle(Some(i))];
        let carried = if supports.is_empty() { carried } else { or(&carried, supports) };
        self.footings.iter().fold(carried, |below, (own, under)| {
            let foot = seen(own, band);
            or(&below, &under.as_ref().map_or_else(|| foot.clone(), |under| and(&foot, under)))
        })
    }

    /// What hangs and what droops in a run of layers on such supports.
    fn patches(
        &self,
        run: RangeInclusive<usize>,
        begins: &BTreeSet<usize>,
        rule: &OverhangRule,
        held: &SupportLines,
        enough: bool,
    ) -> Judged {
        let mut layers = Recent::default();
        let mut memory = Memory::default();
        let mut pieces: Vec<Piece> = Vec::new();
        let frame = Frame { rule, upright: &self.upright, low: self.low };
        for i in run {
            if i == 0 && self.table {
                continue;
            }
            let answer = self.answer(i, begins.contains(&i), rule, held, memory, &mut layers);
            memory = answer.memory;
            let hangs = answer.pieces.iter().any(Piece::hangs);
            pieces.extend(answer.pieces);
            if enough && hangs {
                let found = frame.judged(&pieces);
                if !found.hangs.is_empty() {
                    return found;
                }
            }
        }
        frame.judged(&pieces)
    }

    /// What of layer `i` hangs and droops on such supports, and what is to be remembered of it.
    fn answer(
        &self,
        i: usize,
        begins: bool,
        rule: &OverhangRule,
        held: &SupportLines,
        memory: Memory,
        layers: &mut Recent,
    ) -> Answer {
        let mut bare = None;
        let beyond = self.beyond[i].get_or_init(|| {
            let bare = bare.insert(self.without_supports(i, layers));
            bare.beyond(&layers.at(i, self), rule)
        });
        // Supports only add to what islands lie on: where there is none without them there is none.
        let begins = begins
            && *self.has_islands[i].get_or_init(|| {
                let bare = bare.get_or_insert_with(|| self.without_supports(i, layers));
                Step::has_islands(&layers.at(i, self), bare, &self.near(i, layers), rule)
            });
        if beyond.is_empty() && !begins {
            // Whatever supports there are make no difference.
            return Answer::default();
        }
        let within = (!begins).then(|| self.reached(beyond));
        let lines = held.under(self.low + i as f64 * rule.layer_mm, rule.layer_mm, within.as_deref());
        let fresh = |memory: &Memory| {
            let supports = strips(lines.iter(), held.line_mm);
            let others = self.nearly_below(i);
            // What is left of it on these supports; where nothing is, no more of the layer need be known.
            let left = (!begins && others.is_empty()).then(|| Step::left_by(&supports, beyond, held.beside_mm, rule));
            if left.as_ref().is_some_and(Region::is_empty) {
                return Answer::default();
            }
            let below = if supports.is_empty() && others.is_empty() {
                bare.unwrap_or_else(|| self.without_supports(i, layers))
            } else {
                let last = i.checked_sub(1).map(|i| layers.at(i, self)).unwrap_or_default();
                let held = if others.is_empty() { Region::clone(&last) } else { or(&last, &others) };
                Below::of(with_few_points(&self.below(i, held, &supports)))
            };
            let above = || self.layer(i + 1);
            let step = Step {
                number: i,
                layer: &layers.at(i, self),
                below: &below,
                left: left.as_ref(),
                near: &self.near(i, layers),
                above: &above,
                begins,
                supports: &supports,
                beside_mm: held.beside_mm,
                rule,
            };
            let mut pieces = Vec::new();
            let memory = step.judged(memory, &mut pieces);
            Answer { pieces, memory }
        };
        self.answers[i].of(Question::of(rule, &lines, held, memory), fresh)
    }

    /// What lies one layer of air below layer `i`; the table does below the second one.
    fn near(&self, i: usize, layers: &mut Recent) -> Arc<Region> {
        match i {
            1 if self.table => layers.at(i, self),
            _ => i.checked_sub(2).map(|i| layers.at(i, self)).unwrap_or_default(),
        }
    }

    /// What is below layer `i` where there are no supports.
    fn without_supports(&self, i: usize, layers: &mut Recent) -> Below {
        let last = i.checked_sub(1).map(|i| layers.at(i, self)).unwrap_or_default();
        Below::of(with_few_points(&self.below(i, Region::clone(&last), &Region::new())))
    }

    /// Where something may be that pieces of a layer lie on: boxes.
    fn reached(&self, pieces: &Region) -> Vec<[[f64; 2]; 2]> {
        let room_mm = self.rule.bridge_mm + REACH_MM;
        let around = |piece| {
            let [low, high] = bounds(piece);
            [low.map(|v| v - room_mm), high.map(|v| v + room_mm)]
        };
        pieces.iter().map(around).collect()
    }
}

/// The layers that were cut last.
#[derive(Default)]
struct Recent([Option<(usize, Arc<Region>)>; 3]);

impl Recent {
    fn at(&mut self, i: usize, stack: &Stack) -> Arc<Region> {
        let place = &mut self.0[i % 3];
        match place {
            Some((of, layer)) if *of == i => Arc::clone(layer),
            _ => {
                let layer = Arc::new(stack.layer(i));
                *place = Some((i, Arc::clone(&layer)));
                layer
            }
        }
    }
}

/// What facets between two heights cover, seen from above.
fn seen(facets: &[[Vec3; 3]], [low, high]: [f64; 2]) -> Region {
    let outline = |facet: &[Vec3; 3]| {
        let normal = (facet[1] - facet[0]).cross(&(facet[2] - facet[0]));
        let is_seen = normal.z.abs() > EDGE_ON * normal.norm();
        is_seen.then(|| (clipped(facet, low, high).iter().map(|p| [p.x, p.y]).collect(), normal.z > 0.0))
    };
    covered(facets.iter().filter_map(outline))
}

/// The part of a facet above `low` and not above `high`.
fn clipped(facet: &[Vec3; 3], low: f64, high: f64) -> Vec<Vec3> {
    let mut corners = facet.to_vec();
    for (sign, level) in [(1.0, low), (-1.0, high)] {
        if level.is_infinite() {
            continue;
        }
        let height = |p: &Vec3| sign * (p.z - level);
        let mut kept = Vec::with_capacity(corners.len() + 1);
        for i in 0..corners.len() {
            let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
            let (ha, hb) = (height(&a), height(&b));
            if ha >= 0.0 {
                kept.push(a);
            }
            if (ha >= 0.0) != (hb >= 0.0) {
                kept.push(a + (b - a) * (ha / (ha - hb)));
            }
        }
        corners = kept;
    }
    corners
}

#[cfg(test)]
mod tests;
