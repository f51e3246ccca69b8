//! The beam search over planes, from the whole model down.
//!
//! A state is what is left and the pieces that were taken off it. What a taken piece needs stays for good; what is left may still
//! be cut. So children are let in by what stays for good, up to a limit that rises only while the beam is not full (as Wu et al.
//! do), and ranked by all that is needed: a search by the sum alone sticks where the first cut costs something. Scores come from
//! sweeps; only the best are really cut, measured again, and held against the rules and the machine.

use rayon::prelude::*;

use super::Options;
use super::candidates::{Directions, directions, offsets};
use super::clip::{Taken, cut};
use super::machine::CutMachine;
use super::measure::{MeasureRules, Measured, PieceNeeds};
use super::rules::{Against, CutParts, THICK_MM, kept};
use super::surface::{Plane, Surface};
use super::sweep::{Beyond, Sweep, Upright, footing, seam_mm2};
use crate::geom::{Object, Vec3};
use crate::mesh::TriangleMesh;

/// What may stay for good in one step at first, mm²; five times as much as long as the beam is not full.
const STAYS_MM2: f64 = 0.5;
const STAYS_TIMES: f64 = 5.0;
/// What planning lets pass in a part as rounding, mm², less a tenth.
pub(super) const NOTHING_MM2: f64 = 0.45;
/// Areas nearer than this are one, mm².
const SAME_MM2: f64 = 0.1;
/// In the beam a beginning or a ridge weighs as much as this area, mm².
const FAULT_MM2: f64 = 5.0;
/// Real cuts of one level, for each state that the beam may hold.
const CUTS_PER_STATE: usize = 30;
/// Children of one level, for each state that the beam may hold, among which the diverse best are chosen.
const CHILDREN_PER_STATE: usize = 10;
/// Candidates of one level whose seams are measured.
const SEAMED: usize = 400;
/// Cuts along directions so near and at offsets so near are one.
const SAME_COSINE: f64 = 0.95;
const SAME_OFFSET_MM: f64 = 2.0;
/// Most cuts of the search among plain directions.
const PLAIN_CUTS: usize = 4;
/// How much wider the beam is where nothing was found in the usual one.
const WIDER: [usize; 2] = [3, 2];
/// Levels without a gain after which the search ends.
const IDLE: usize = 3;

/// A cut that was made.
#[derive(Clone)]
pub(super) struct CutStep {
    pub(super) plane: Plane,
    pub(super) pieces: Vec<Surface>,
    /// By piece, along the plane's normal.
    pub(super) needs: Vec<PieceNeeds>,
    pub(super) seam_mm2: f64,
    /// What the cut took from what was left, mm².
    pub(super) gain_mm2: f64,
    pub(super) crumbs_mm3: f64,
    /// Whether the direction is none of a face or of the compass.
    odd: bool,
}

/// What is left after some cuts.
#[derive(Clone)]
pub(super) struct SplitState {
    pub(super) rest: Measured,
    upright: std::sync::Arc<Upright>,
    pub(super) steps: Vec<CutStep>,
    /// mm², in pieces that were taken.
    stays_mm2: f64,
    faults: usize,
}

impl SplitState {
    fn of(rest: Measured, rules: &MeasureRules, steps: Vec<CutStep>) -> Self {
        let upright = std::sync::Arc::new(Upright::of(&rest, rules));
        let needs = steps.iter().flat_map(|step| &step.needs);
        let (stays_mm2, faults) = needs.fold((0.0, 0), |(a, f), n| (a + n.area_mm2, f + n.faults()));
        Self { rest, upright, steps, stays_mm2, faults }
    }

    /// What is left needs this, as it stands.
    pub(super) fn left(&self) -> PieceNeeds {
        self.upright.needs
    }

    pub(super) fn area_mm2(&self) -> f64 {
        self.stays_mm2 + self.left().area_mm2
    }

    pub(super) fn faults(&self) -> usize {
        self.faults + self.left().faults()
    }

    fn knows(&self, up: &Vec3) -> bool {
        self.steps.iter().any(|step| (step.plane.normal - up).norm() < 1e-9) || (up - Vec3::z()).norm() < 1e-9
    }

    /// Distinct directions, +z among them.
    fn setups(&self) -> usize {
        let mut known: Vec<Vec3> = vec![Vec3::z()];
        for step in &self.steps {
            if known.iter().all(|k| (k - step.plane.normal).norm() > 1e-9) {
                known.push(step.plane.normal);
            }
        }
        known.len()
    }

    /// Cuts along a direction of the even spread: what is printed along it has its faces on a slant.
    fn odd(&self) -> usize {
        self.steps.iter().filter(|step| step.odd).count()
    }

    fn seam_mm2(&self) -> f64 {
        self.steps.iter().map(|step| step.seam_mm2).sum()
    }

    /// The order of finished results: what they need, setups, cuts, seams.
    fn key(&self) -> (usize, i64, usize, usize, usize, i64) {
        let (area, seam) = (whole(self.area_mm2()), whole(self.seam_mm2()));
        (self.faults(), area, self.setups(), self.steps.len(), self.odd(), seam)
    }

    /// The order within the beam.
    fn rank(&self) -> (i64, usize, usize, i64) {
        let worth = whole(self.area_mm2() + FAULT_MM2 * self.faults() as f64);
        (worth, self.setups(), self.odd(), whole(self.seam_mm2()))
    }
}

fn whole(area: f64) -> i64 {
    (area / SAME_MM2).round() as i64
}

/// What was against the cuts that were tried, counted.
pub(super) type Refused = std::collections::BTreeMap<Against, usize>;

/// What a search comes to.
pub(super) struct SearchFound {
    pub(super) state: SplitState,
    /// Whether nothing needs support, and the machine has a plan.
    pub(super) printable: bool,
    /// States that needed nothing, but that the machine has no plan for.
    pub(super) unplanned: usize,
    pub(super) refused: Refused,
}

/// A plane that promises something.
struct Candidate {
    state: usize,
    plane: Plane,
    taken: Taken,
    /// What a finished child would need, by the sweep.
    stays_mm2: f64,
    worth: i64,
    setups: usize,
    odd: bool,
    seam_mm2: f64,
    tops: Vec<u32>,
}

/// The search over one model.
pub(super) struct BeamSearch<'a> {
    pub(super) machine: &'a dyn CutMachine,
    pub(super) options: &'a Options,
    pub(super) rules: MeasureRules,
    directions: Directions,
}

impl<'a> BeamSearch<'a> {
    pub(super) fn new(
        model: &TriangleMesh<Object>,
        machine: &'a dyn CutMachine,
        options: &'a Options,
        rules: MeasureRules,
    ) -> Self {
        let directions = directions(model, |up| machine.reaches(up));
        Self { machine, options, rules, directions }
    }

    /// The best way to cut that is found. `finished` says whether a state that needs nothing really is good, and `level` is told
    /// after each level.
    ///
    /// Plain directions come first: what they do with as few cuts has its faces along the layers and smaller seams, though a
    /// slanting cut would take more at once.
    pub(super) fn run(
        &self,
        model: &TriangleMesh<Object>,
        finished: &dyn Fn(&SplitState) -> bool,
        level: &mut dyn FnMut(usize),
    ) -> SearchFound {
        let most = self.options.max_cuts;
        let few = most.min(PLAIN_CUTS);
        let usual = self.options.beam;
        let plain = self.descend(model, (self.directions.plain, few, usual), finished, level);
        let fewer = if plain.printable { plain.state.steps.len().saturating_sub(1) } else { most };
        if fewer == 0 {
            return plain;
        }
        let every = self.directions.all.len();
        let all = self.descend(model, (every, fewer, usual), finished, level);
        let found = if all.printable { all } else { better(plain, all) };
        if found.printable {
            return found;
        }
        let wide = self.descend(model, (every, most, usual * WIDER[0] / WIDER[1]), finished, level);
        better(found, wide)
    }

    /// The search over the first `directions` with at most `most` cuts, of as many states as `width` from level to level.
    fn descend(
        &self,
        model: &TriangleMesh<Object>,
        (directions, most, width): (usize, usize, usize),
        finished: &dyn Fn(&SplitState) -> bool,
        level: &mut dyn FnMut(usize),
    ) -> SearchFound {
        let first = SplitState::of(Measured::of(Surface::of(model), &self.rules), &self.rules, Vec::new());
        let mut best = first.clone();
        let mut beam = vec![first];
        let (mut idle, mut unplanned, mut refused) = (0, 0, Refused::new());
        for cuts in 0..=most {
            let mut done: Vec<&SplitState> = beam.iter().filter(|s| self.is_done(s)).collect();
            done.sort_by_key(|s| s.key());
            for good in done {
                if finished(good) {
                    return SearchFound { state: good.clone(), printable: true, unplanned, refused };
                }
                unplanned += 1;
            }
            // Nothing more to cut where layers let pass what facets do not.
            let mut bridged: Vec<&SplitState> = beam.iter().filter(|s| s.faults() == 0 && !self.is_done(s)).collect();
            bridged.sort_by_key(|s| s.key());
            if let Some(good) = bridged.into_iter().find(|s| self.passes(s) && finished(s)) {
                return SearchFound { state: good.clone(), printable: true, unplanned, refused };
            }
            if let Some(better) = beam.iter().filter(|s| s.key() < best.key()).min_by_key(|s| s.key()) {
                best = better.clone();
                idle = 0;
            } else {
                idle += 1;
            }
            if idle > IDLE || cuts == most {
                break;
            }
            let next = self.children(&beam, (directions, width), &mut refused);
            level(cuts + 1);
            if next.is_empty() {
                break;
            }
            beam = next;
        }
        SearchFound { state: best, printable: false, unplanned, refused }
    }

    pub(super) fn is_done(&self, state: &SplitState) -> bool {
        let pieces = state.steps.iter().flat_map(|step| &step.needs);
        let nothing = pieces.chain([&state.left()]).all(|n| n.area_mm2 <= NOTHING_MM2);
        state.faults() == 0 && (nothing || state.area_mm2() <= self.options.allow_mm2)
    }

    /// Whether every part of a state passes by its facets or by its layers.
    fn passes(&self, state: &SplitState) -> bool {
        let left = &state.rest;
        let pieces = state.steps.iter().enumerate().flat_map(|(k, step)| {
            let cap = Some(k as u32 + 1);
            let hangs = step.pieces.iter().zip(&step.needs).filter(|(_, n)| n.area_mm2 > NOTHING_MM2);
            hangs.map(move |(piece, _)| (Measured::of(piece.clone(), &self.rules), step.plane.normal, cap))
        });
        let passes = |part: &Measured, up: &Vec3, cap| part.passes(up, cap, &self.rules);
        let nothing = state.left().area_mm2 <= NOTHING_MM2;
        (nothing || passes(left, &Vec3::z(), None)) && pieces.into_iter().all(|(part, up, cap)| passes(&part, &up, cap))
    }

    /// The next beam.
    fn children(
        &self,
        beam: &[SplitState],
        (directions, width): (usize, usize),
        refused: &mut Refused,
    ) -> Vec<SplitState> {
        let mut candidates = self.candidates(beam, directions);
        self.measure_seams(beam, &mut candidates);
        let most = CUTS_PER_STATE * width;
        let mut tried = vec![false; candidates.len()];
        let (mut cuts, mut stays) = (0, STAYS_MM2);
        let mut chosen: Vec<(usize, SplitState)> = Vec::new();
        let largest = candidates.iter().map(|c| c.stays_mm2).fold(0.0, f64::max);
        // Whether the beam is full of what is no worse than all that is to come, which is in the order of its promises.
        let settled = |chosen: &[(usize, SplitState)], promises: i64| {
            let kept = Self::diverse(chosen, beam.len(), width);
            kept.len() >= width && kept.iter().all(|&k| chosen[k].1.rank().0 < promises)
        };
        loop {
            let within: Vec<usize> =
                (0..candidates.len()).filter(|&i| !tried[i] && candidates[i].stays_mm2 <= stays).collect();
            for batch in within.chunks(2 * width) {
                let promises = candidates[batch[0]].worth;
                if cuts >= most || chosen.len() >= CHILDREN_PER_STATE * width || settled(&chosen, promises) {
                    break;
                }
                let made: Vec<Result<SplitState, Against>> =
                    batch.par_iter().map(|&i| self.child(&beam[candidates[i].state], &candidates[i])).collect();
                cuts += batch.len();
                for (&i, state) in batch.iter().zip(made) {
                    tried[i] = true;
                    match state {
                        Ok(state) => chosen.push((candidates[i].state, state)),
                        Err(against) => *refused.entry(against).or_insert(0) += 1,
                    }
                }
            }
            let full = Self::diverse(&chosen, beam.len(), width).len() >= width;
            if full || stays >= largest || cuts >= most {
                break;
            }
            stays *= STAYS_TIMES;
        }
        let keep = Self::diverse(&chosen, beam.len(), width);
        let mut chosen: Vec<Option<SplitState>> = chosen.into_iter().map(|(_, state)| Some(state)).collect();
        keep.into_iter().filter_map(|i| chosen[i].take()).collect()
    }

    /// Places in `chosen`, best first, without what is nearly the same, and not too many of one parent.
    fn diverse(chosen: &[(usize, SplitState)], parents: usize, width: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..chosen.len()).collect();
        order.sort_by_key(|&i| chosen[i].1.rank());
        let most = (3 * width).div_ceil(2 * parents);
        let mut kept: Vec<usize> = Vec::new();
        for i in order {
            let (parent, state) = &chosen[i];
            let siblings = kept.iter().filter(|&&k| chosen[k].0 == *parent).count();
            let same = |&k: &usize| {
                let (other_parent, other) = &chosen[k];
                let (a, b) = (&state.steps[state.steps.len() - 1].plane, &other.steps[other.steps.len() - 1].plane);
                let near = a.normal.dot(&b.normal) > SAME_COSINE && (a.offset_mm - b.offset_mm).abs() < SAME_OFFSET_MM;
                let equal = (state.area_mm2() - other.area_mm2()).abs() < 1e-6
                    && (state.rest.surface.volume() - other.rest.surface.volume()).abs() < 1e-3;
                (parent == other_parent && near && whole(state.area_mm2()) == whole(other.area_mm2())) || equal
            };
            if siblings < most && !kept.iter().any(same) {
                kept.push(i);
            }
            if kept.len() == width {
                break;
            }
        }
        kept
    }

    /// All planes of all states that gain something, the most promising first.
    fn candidates(&self, beam: &[SplitState], directions: usize) -> Vec<Candidate> {
        let tasks: Vec<(usize, usize)> = (0..beam.len()).flat_map(|s| (0..directions).map(move |d| (s, d))).collect();
        let found: Vec<Vec<Candidate>> =
            tasks.par_iter().map(|&(state, d)| self.along(&beam[state], state, d)).collect();
        let mut all: Vec<Candidate> = found.into_iter().flatten().collect();
        all.sort_by_key(|c| (c.worth, c.setups, c.odd));
        all
    }

    /// The planes of one direction.
    fn along(&self, state: &SplitState, number: usize, d: usize) -> Vec<Candidate> {
        let up = &self.directions.all[d];
        let mut sweep = Sweep::new(&state.rest, &state.upright, up, &self.rules);
        let offsets = offsets(&state.rest, &state.upright, up, &sweep.heights, THICK_MM);
        let left = state.left();
        let setups = state.setups() + usize::from(!state.knows(up));
        let mut all = Vec::new();
        sweep.run(&offsets, |offset_mm, beyond| {
            for (taken, tops, before, after) in choices(beyond, self.options.strict) {
                let gains = before.area_mm2 > after.area_mm2 + STAYS_MM2 || before.faults() > after.faults();
                if !gains || after.faults() > 0 {
                    continue;
                }
                let area = state.area_mm2() - before.area_mm2 + after.area_mm2;
                let faults = state.faults() + after.faults() - before.faults().min(left.faults());
                all.push(Candidate {
                    state: number,
                    plane: Plane { normal: *up, offset_mm },
                    taken,
                    stays_mm2: after.area_mm2,
                    worth: whole(area + FAULT_MM2 * faults as f64),
                    setups,
                    odd: d >= self.directions.exact,
                    seam_mm2: 0.0,
                    tops,
                });
            }
        });
        let takes_all = |c: &&Candidate| c.taken == Taken::All;
        let whole: Vec<f64> = all.iter().filter(takes_all).map(|c| c.plane.offset_mm).collect();
        let mut footing = footing(&state.rest, up, &sweep.heights, &whole).into_iter();
        all.retain(|c| c.taken != Taken::All || footing.next().unwrap_or(true));
        all
    }

    /// Of equals, those with small seams come first.
    fn measure_seams(&self, beam: &[SplitState], candidates: &mut [Candidate]) {
        let few = candidates.len().min(SEAMED);
        candidates[..few].par_iter_mut().for_each(|c| {
            c.seam_mm2 = seam_mm2(&beam[c.state].rest, &c.plane.normal, c.plane.offset_mm, &c.tops);
        });
        candidates[..few].sort_by(|a, b| {
            let key = |c: &Candidate| (c.worth, c.setups, c.odd, whole(c.seam_mm2));
            key(a).cmp(&key(b))
        });
    }

    /// The state after `candidate`, if rules and machine allow it.
    fn child(&self, state: &SplitState, candidate: &Candidate) -> Result<SplitState, Against> {
        let number = state.steps.len() as u32 + 1;
        let plane = candidate.plane;
        let cut = cut(&state.rest.surface, &plane, &candidate.taken, number).map_err(|_| Against::Crossing)?;
        let CutParts { rest, pieces, seam_mm2, crumbs_mm3 } =
            kept(cut, &plane, number, &self.rules, &self.options.no_cut)?;
        let needs: Vec<PieceNeeds> = pieces.iter().map(|p| p.needs(&plane.normal, Some(number), &self.rules)).collect();
        if needs.iter().any(|n| n.faults() > 0) {
            return Err(Against::Beginning);
        }
        let falls = |p: &Measured| self.rules.faults && p.has_false_bottom(&plane.normal, Some(number));
        if pieces.iter().any(falls) {
            return Err(Against::Thin);
        }
        let all = candidate.taken == Taken::All;
        let standing = (!all).then(|| rest.surface.mesh());
        let prints = |p: &Measured| self.machine.prints(&p.surface.mesh(), &plane.normal, standing.as_ref());
        if !pieces.iter().all(prints) {
            return Err(Against::Head);
        }
        let pieces = pieces.into_iter().map(|p| p.surface).collect();
        let mut steps = state.steps.clone();
        steps.push(CutStep { plane, pieces, needs, seam_mm2, gain_mm2: 0.0, crumbs_mm3, odd: candidate.odd });
        let mut child = SplitState::of(rest, &self.rules, steps);
        let gain_mm2 = state.left().area_mm2 - child.left().area_mm2;
        child.steps.iter_mut().last().into_iter().for_each(|step| step.gain_mm2 = gain_mm2);
        // The cap may have made a new lowest place of what is left.
        if self.rules.faults && child.left().area_mm2 <= NOTHING_MM2 && child.rest.has_false_bottom(&Vec3::z(), None) {
            return Err(Against::Thin);
        }
        let gains = child.area_mm2() < state.area_mm2() - SAME_MM2 || child.faults() < state.faults();
        if gains { Ok(child) } else { Err(Against::Gain) }
    }
}

/// The second where it is better.
fn better(first: SearchFound, second: SearchFound) -> SearchFound {
    let key = |found: &SearchFound| (!found.printable, found.state.key());
    if key(&second) < key(&first) { second } else { first }
}

type Choice = (Taken, Vec<u32>, PieceNeeds, PieceNeeds);

/// Which of the solids beyond a plane may be taken: all, each that gains by itself, and all of these together.
fn choices(beyond: &[Beyond], strict: bool) -> Vec<Choice> {
    let sum = |of: &mut dyn Iterator<Item = &Beyond>, taken: Option<()>| -> Choice {
        let mut tops = Vec::new();
        let (mut before, mut after) = (PieceNeeds::default(), PieceNeeds::default());
        for one in of {
            tops.push(one.top);
            for (sum, n) in [(&mut before, one.before), (&mut after, one.after)] {
                sum.area_mm2 += n.area_mm2;
                sum.beginnings += n.beginnings;
                sum.ridges += n.ridges;
            }
        }
        let taken = taken.map_or_else(|| Taken::With(tops.clone()), |()| Taken::All);
        (taken, tops, before, after)
    };
    let mut all = Vec::new();
    if !beyond.is_empty() && beyond.iter().all(|b| b.height_mm >= THICK_MM) {
        all.push(sum(&mut beyond.iter(), Some(())));
    }
    if strict || beyond.len() < 2 {
        return all;
    }
    let gains = |b: &&Beyond| {
        let area = b.before.area_mm2 > b.after.area_mm2 + STAYS_MM2;
        b.height_mm >= THICK_MM && (area || b.before.faults() > b.after.faults()) && b.after.faults() == 0
    };
    let gaining: Vec<&Beyond> = beyond.iter().filter(gains).collect();
    all.extend(gaining.iter().map(|b| sum(&mut std::iter::once(*b), None)));
    if gaining.len() > 1 && gaining.len() < beyond.len() {
        all.push(sum(&mut gaining.into_iter(), None));
    }
    all
}
