//! The beam search over planes, from the whole model down.
//!
//! A state is what is left and the pieces that were taken off it. What a taken piece needs stays for good; what is left may still
//! be cut. So children are let in by what stays for good, up to a limit that rises only while the beam is not full (as Wu et al.
//! do), and ranked by all that is needed: a search by the sum alone sticks where the first cut costs something. Scores come from
//! sweeps; only the best are really cut, measured again, and held against the rules and the machine.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use super::candidates::{Directions, directions, offsets};
use super::clip::{ON_PLANE_MM, Taken, cut};
use super::machine::CutMachine;
use super::measure::{MeasureRules, Measured, NOTHING_MM2};
use super::promise::{Known, Promise, STAYS_MM2, choices};
use super::rules::{Against, CutParts, THICK_MM, kept};
use super::state::{CutStep, FAULT_MM2, SAME_MM2, SplitState, StatePromise, whole};
use super::surface::{OWN, Plane, Surface};
use super::sweep::{Sweep, footing, seam_mm2};
use super::{CutOptions, CutWatch, PinnedCut};
use crate::geom::{Object, Vec3};
use crate::mesh::TriangleMesh;

/// What may stay for good in one step rises so much at a time as long as the beam is not full.
const STAYS_TIMES: f64 = 5.0;
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

/// What was against the cuts that were tried, counted.
pub(super) type Refused = std::collections::BTreeMap<Against, usize>;

/// What a search comes to.
pub(super) struct SearchFound {
    pub(super) state: Arc<SplitState>,
    /// Whether nothing needs support, and the machine has a plan.
    pub(super) printable: bool,
    /// States that needed nothing, but that the machine has no plan for.
    pub(super) unplanned: usize,
    pub(super) refused: Refused,
    /// Whether it ended before its end.
    pub(super) stopped: bool,
    /// The first pinned cut that cannot be made, and what is against it.
    pub(super) unpinned: Option<(usize, Against)>,
}

impl SearchFound {
    /// Nothing but the state so far.
    fn only(state: Arc<SplitState>, refused: Refused) -> Self {
        Self { state, printable: false, unplanned: 0, refused, stopped: false, unpinned: None }
    }
}

/// What the searches over one model share: whatever the machine, states and promises are the same.
pub(super) struct SearchGround {
    pub(super) options: CutOptions,
    pub(super) rules: MeasureRules,
    directions: Directions,
    first: Arc<SplitState>,
    /// By pinned cut, what it promises behind those before it, or what is against all that it could take.
    pins: Vec<OnceLock<Result<StatePromise, Against>>>,
    /// The facets of all states that are kept.
    kept: AtomicUsize,
    /// Cuts that were really made.
    tried: AtomicU64,
}

impl SearchGround {
    /// `reaches` says which directions are searched.
    pub(super) fn new(
        model: &TriangleMesh<Object>,
        reaches: impl Fn(&Vec3) -> bool,
        options: CutOptions,
        rules: MeasureRules,
    ) -> Self {
        let directions = directions(model, reaches);
        let whole = Measured::of(Surface::of(model), &rules);
        let first = Arc::new(SplitState::of(whole, &rules, Vec::new(), directions.all.len()));
        let pins = options.pinned.iter().map(|_| OnceLock::new()).collect();
        Self { options, rules, directions, first, pins, kept: AtomicUsize::new(0), tried: AtomicU64::new(0) }
    }

    /// The model as it is.
    pub(super) fn first_state(&self) -> Arc<SplitState> {
        self.first.clone()
    }

    /// Cuts that were really made so far, whatever came of them.
    pub(super) fn tried(&self) -> u64 {
        self.tried.load(Ordering::Relaxed)
    }

    /// Directions of faces or of the compass.
    pub(super) fn exact_directions(&self) -> &[Vec3] {
        &self.directions.all[..self.directions.exact]
    }
}

/// The search for one machine.
pub(super) struct BeamSearch<'a> {
    pub(super) ground: &'a SearchGround,
    pub(super) machine: &'a dyn CutMachine,
    /// Of all machines over the same ground no other has it.
    pub(super) number: u64,
    /// Where it begins: the model as it is, or what the pinned cuts leave.
    pub(super) start: Arc<SplitState>,
}

impl BeamSearch<'_> {
    /// As [`Self::run`], from what the pinned cuts leave; where one of those cannot be made that is all there is to say.
    pub(super) fn on_what_is_pinned(
        mut self,
        finished: &dyn Fn(&SplitState) -> bool,
        watch: &mut CutWatch<'_>,
    ) -> SearchFound {
        for (place, pin) in self.ground.options.pinned.iter().enumerate() {
            match self.pinned(pin, &self.ground.pins[place]) {
                Ok(state) => self.start = state,
                Err(against) => {
                    let unpinned = Some((place, against));
                    return SearchFound { unpinned, ..SearchFound::only(self.start, Refused::new()) };
                }
            }
        }
        self.run(finished, watch)
    }

    /// What is left after a cut that somebody has decided, whether it gains anything or not; `known` is what other machines have
    /// found out.
    fn pinned(
        &self,
        pin: &PinnedCut,
        known: &OnceLock<Result<StatePromise, Against>>,
    ) -> Result<Arc<SplitState>, Against> {
        if !self.machine.reaches(&pin.plane.normal) {
            return Err(Against::Head);
        }
        let promise = known.get_or_init(|| self.promised(pin));
        self.made(&self.start, promise.as_ref().map_err(|against| *against)?, &Ok)
    }

    /// A pinned cut, as the search would propose it.
    fn promised(&self, pin: &PinnedCut) -> Result<StatePromise, Against> {
        let (whole, plane) = (&self.start.rest.surface, &pin.plane);
        let beyond = cut(whole, plane, &Taken::All, OWN + 1).map_err(|_| Against::Crossing)?.pieces;
        let holds = |piece: &Surface, point: &Vec3| piece.winding(point) > 0.5;
        let is_taken = |piece: &&Surface| pin.points.is_empty() || pin.points.iter().any(|p| holds(piece, p));
        let nowhere = |point: &Vec3| !beyond.iter().any(|piece| holds(piece, point));
        let chosen: Vec<&Surface> = beyond.iter().filter(is_taken).collect();
        if chosen.is_empty() || pin.points.iter().any(nowhere) {
            return Err(Against::Nothing);
        }
        let highest = |piece: &&Surface| {
            piece.vertices.iter().max_by(|a, b| plane.height(a).total_cmp(&plane.height(b))).copied()
        };
        let number = |top: Vec3| whole.vertices.iter().position(|v| *v == top).map(|v| v as u32);
        let tops: Vec<u32> = chosen.iter().filter_map(highest).filter_map(number).collect();
        let taken = if chosen.len() == beyond.len() { Taken::All } else { Taken::With(tops.clone()) };
        let odd = self.ground.exact_directions().iter().all(|known| (known - plane.normal).norm() > 1e-9);
        Ok(Promise::new(*plane, taken, tops, 0.0, 0, 0, odd))
    }

    /// The best way to cut that is found, refined. `finished` says whether a state that needs nothing really is good; `watch` is told
    /// again and again how many cuts deep the search is, and says whether it goes on.
    pub(super) fn run(&self, finished: &dyn Fn(&SplitState) -> bool, watch: &mut CutWatch<'_>) -> SearchFound {
        let found = self.searched(finished, watch);
        if found.stopped { found } else { self.refined(found, finished) }
    }

    /// Plain directions come first: what they do with as few cuts has its faces along the layers and smaller seams, though a
    /// slanting cut would take more at once.
    fn searched(&self, finished: &dyn Fn(&SplitState) -> bool, watch: &mut CutWatch<'_>) -> SearchFound {
        let (most, least) = (self.ground.options.max_cuts, self.start.steps.len());
        let few = most.min(least + PLAIN_CUTS);
        let usual = self.ground.options.beam;
        let plain = self.descend(self.ground.directions.plain, few, usual, finished, watch);
        let fewer = if plain.printable { plain.state.steps.len().saturating_sub(1) } else { most };
        if fewer <= least || plain.stopped {
            return plain;
        }
        let every = self.ground.directions.all.len();
        let all = self.descend(every, fewer, usual, finished, watch);
        let found = if all.printable { all } else { better(plain, all) };
        // Where another way is known, what is hard to find is not sought.
        if found.printable || found.stopped || self.ground.options.budget.is_some() {
            return found;
        }
        let wide = self.descend(every, most, usual * WIDER[0] / WIDER[1], finished, watch);
        better(found, wide)
    }

    /// The search over the first `directions` with at most `most` cuts, of as many states as `width` from level to level.
    fn descend(
        &self,
        directions: usize,
        most: usize,
        width: usize,
        finished: &dyn Fn(&SplitState) -> bool,
        watch: &mut CutWatch<'_>,
    ) -> SearchFound {
        let allow = self.ground.options.allow_mm2;
        let mut best = self.start.clone();
        let mut beam = vec![best.clone()];
        let (mut idle, mut unplanned, mut refused) = (0, 0, Refused::new());
        let mut stopped = false;
        for cuts in best.steps.len()..=most {
            let mut done: Vec<&Arc<SplitState>> = beam.iter().filter(|s| s.is_done(allow)).collect();
            done.sort_by_key(|s| s.key());
            for good in done {
                if finished(good) {
                    let found = SearchFound::only(good.clone(), refused);
                    return SearchFound { printable: true, unplanned, stopped, ..found };
                }
                unplanned += 1;
            }
            // Nothing more to cut where layers let pass what facets do not.
            let mut bridged: Vec<&Arc<SplitState>> = beam.iter().filter(|s| !s.is_done(allow)).collect();
            bridged.sort_by_key(|s| s.key());
            if let Some(good) = bridged.into_iter().find(|s| s.passes(&self.ground.rules) && finished(s)) {
                let found = SearchFound::only(good.clone(), refused);
                return SearchFound { printable: true, unplanned, stopped, ..found };
            }
            if let Some(better) = beam.iter().filter(|s| s.key() < best.key()).min_by_key(|s| s.key()) {
                best = better.clone();
                idle = 0;
            } else {
                idle += 1;
            }
            if idle > IDLE || cuts == most || stopped {
                break;
            }
            let next = self.children(&beam, directions, width, &mut refused, &mut || {
                stopped = stopped || !watch(cuts + 1) || self.ground.tried() >= self.ground.options.tries;
                !stopped
            });
            if next.is_empty() {
                break;
            }
            beam = next;
        }
        SearchFound { unplanned, stopped, ..SearchFound::only(best, refused) }
    }

    /// The next beam, or what there is of it when `goes_on` has said no.
    fn children(
        &self,
        beam: &[Arc<SplitState>],
        directions: usize,
        width: usize,
        refused: &mut Refused,
        goes_on: &mut dyn FnMut() -> bool,
    ) -> Vec<Arc<SplitState>> {
        if !goes_on() {
            return Vec::new();
        }
        let mut candidates = self.candidates(beam, directions);
        let dear = candidates.len();
        candidates.retain(|(s, c)| self.affords(c.setups, beam[*s].seam_mm2() + c.seam_mm2.get().unwrap_or(&0.0)));
        if candidates.len() < dear {
            *refused.entry(Against::Budget).or_insert(0) += dear - candidates.len();
        }
        let most = CUTS_PER_STATE * width;
        let mut tried = vec![false; candidates.len()];
        let (mut cuts, mut stays) = (0, STAYS_MM2);
        let mut chosen: Vec<(usize, Arc<SplitState>)> = Vec::new();
        let largest = candidates.iter().map(|c| c.1.stays_mm2).fold(0.0, f64::max);
        // Whether the beam is full of what is no worse than all that is to come, which is in the order of its promises.
        let settled = |chosen: &[(usize, Arc<SplitState>)], promises: i64| {
            let kept = Self::diverse(chosen, beam.len(), width);
            kept.len() >= width && kept.iter().all(|&k| chosen[k].1.rank().0 < promises)
        };
        loop {
            let within: Vec<usize> =
                (0..candidates.len()).filter(|&i| !tried[i] && candidates[i].1.stays_mm2 <= stays).collect();
            for batch in within.chunks(2 * width) {
                let promises = candidates[batch[0]].1.worth;
                if cuts >= most
                    || chosen.len() >= CHILDREN_PER_STATE * width
                    || settled(&chosen, promises)
                    || !goes_on()
                {
                    break;
                }
                let child = |&i: &usize| self.child(&beam[candidates[i].0], candidates[i].1);
                let made: Vec<Result<Arc<SplitState>, Against>> = batch.par_iter().map(child).collect();
                cuts += batch.len();
                self.ground.tried.fetch_add(batch.len() as u64, Ordering::Relaxed);
                for (&i, state) in batch.iter().zip(made) {
                    tried[i] = true;
                    match state {
                        Ok(state) => chosen.push((candidates[i].0, state)),
                        Err(against) => *refused.entry(against).or_insert(0) += 1,
                    }
                }
            }
            let full = Self::diverse(&chosen, beam.len(), width).len() >= width;
            if full || stays >= largest || cuts >= most || !goes_on() {
                break;
            }
            stays *= STAYS_TIMES;
        }
        let keep = Self::diverse(&chosen, beam.len(), width);
        keep.into_iter().map(|i| chosen[i].1.clone()).collect()
    }

    /// Places in `chosen`, best first, without what is nearly the same, and not too many of one parent.
    fn diverse(chosen: &[(usize, Arc<SplitState>)], parents: usize, width: usize) -> Vec<usize> {
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

    /// All planes of all states that gain something, the most promising first, and of equals those with small seams.
    fn candidates<'b>(&self, beam: &'b [Arc<SplitState>], directions: usize) -> Vec<(usize, &'b StatePromise)> {
        let tasks: Vec<(usize, usize)> = (0..beam.len()).flat_map(|s| (0..directions).map(move |d| (s, d))).collect();
        let along = |&(s, d): &(usize, usize)| (s, beam[s].along(d, || self.along(&beam[s], d)));
        let found: Vec<(usize, &[StatePromise])> = tasks.par_iter().map(along).collect();
        let mut all: Vec<(usize, &StatePromise)> =
            found.into_iter().flat_map(|(s, some)| some.iter().map(move |one| (s, one))).collect();
        all.sort_by_key(|(_, c)| (c.worth, c.setups, c.odd));
        let few = all.len().min(SEAMED);
        let seam = |&(s, c): &(usize, &StatePromise)| {
            let (up, offset_mm) = (&c.plane.normal, c.plane.offset_mm);
            *c.seam_mm2.get_or_init(|| seam_mm2(&beam[s].rest, up, offset_mm, &c.tops))
        };
        let seams: Vec<f64> = all[..few].par_iter().map(seam).collect();
        let mut first: Vec<((usize, &StatePromise), f64)> = all[..few].iter().copied().zip(seams).collect();
        first.sort_by_key(|((_, c), seam)| (c.worth, c.setups, c.odd, whole(*seam)));
        first.into_iter().zip(&mut all).for_each(|((one, _), place)| *place = one);
        all
    }

    /// The planes of one direction.
    fn along(&self, state: &SplitState, d: usize) -> Vec<StatePromise> {
        let SearchGround { options, rules, directions, .. } = self.ground;
        let up = &directions.all[d];
        let mut sweep = Sweep::new(&state.rest, &state.upright, up, rules);
        let offsets = offsets(&state.rest, &state.upright, up, &sweep.heights, THICK_MM);
        let left = state.left();
        let setups = state.setups() + usize::from(!state.knows(up));
        let mut all = Vec::new();
        sweep.run(&offsets, |offset_mm, beyond| {
            for (taken, tops, before, after) in choices(beyond, options.strict) {
                let gains = before.area_mm2 > after.area_mm2 + STAYS_MM2 || before.faults() > after.faults();
                if !gains || after.faults() > 0 {
                    continue;
                }
                let area = state.area_mm2() - before.area_mm2 + after.area_mm2;
                let faults = state.faults() + after.faults() - before.faults().min(left.faults());
                let worth = whole(area + FAULT_MM2 * faults as f64);
                let plane = Plane { normal: *up, offset_mm };
                let odd = d >= directions.exact;
                all.push(Promise::new(plane, taken, tops, after.area_mm2, worth, setups, odd));
            }
        });
        let takes_all = |c: &&StatePromise| c.taken == Taken::All;
        let whole: Vec<f64> = all.iter().filter(takes_all).map(|c| c.plane.offset_mm).collect();
        let mut footing = footing(&state.rest, up, &sweep.heights, &whole).into_iter();
        all.retain(|c| c.taken != Taken::All || footing.next().unwrap_or(true));
        all
    }

    fn affords(&self, setups: usize, seam_mm2: f64) -> bool {
        self.ground.options.budget.is_none_or(|budget| budget.affords(setups, seam_mm2))
    }

    /// The state after a cut, if rules and machine allow it and it is worth what it costs.
    pub(super) fn child(&self, state: &SplitState, promise: &StatePromise) -> Result<Arc<SplitState>, Against> {
        self.made(state, promise, &|child| self.gains(state, child))
    }

    /// The state after a cut, if rules, machine and `worth` allow it; what is known of it already is not found out again.
    fn made(
        &self,
        state: &SplitState,
        promise: &StatePromise,
        worth: &dyn Fn(SplitState) -> Result<SplitState, Against>,
    ) -> Result<Arc<SplitState>, Against> {
        let answer = |against: Against| {
            promise.answer(self.number, Some(against));
            against
        };
        let child = match promise.known(self.number) {
            Known::Refused(against) => return Err(against),
            Known::Made(child) => return Ok(child),
            Known::Unasked(child) => {
                let step = &child.steps[child.steps.len() - 1];
                self.asked(&step.pieces, &child.rest.surface, promise).map_err(answer)?;
                child
            }
            Known::Nothing => {
                self.reached(state, promise).map_err(answer)?;
                let parts = self.parts(state, promise).inspect_err(|against| promise.refuse(*against))?;
                self.asked(&parts.pieces, &parts.rest.surface, promise).map_err(answer)?;
                let child = self.after(state, promise, parts).and_then(worth);
                Arc::new(child.map_err(answer)?)
            }
        };
        promise.answer(self.number, None);
        promise.keep(&child, child.facets(), &self.ground.kept);
        Ok(child)
    }

    /// Whether the machine reaches the lowest place of what is taken: a plane that takes a piece which the head cannot print for the table's
    /// sake need not be cut for that.
    fn reached(&self, state: &SplitState, promise: &StatePromise) -> Result<(), Against> {
        let (vertices, plane) = (&state.rest.surface.vertices, &promise.plane);
        let beyond = || vertices.iter().filter(|v| plane.height(v) > ON_PLANE_MM);
        let tops = || promise.tops.iter().map(|&v| &vertices[v as usize]);
        let low = |a: &&Vec3, b: &&Vec3| a.z.total_cmp(&b.z);
        let lowest = if promise.taken == Taken::All { beyond().min_by(low) } else { tops().min_by(low) };
        if lowest.is_none_or(|at| self.machine.prints_at(at, &plane.normal)) { Ok(()) } else { Err(Against::Head) }
    }

    /// Whether the machine prints the pieces beside what is left.
    fn asked(&self, pieces: &[Surface], rest: &Surface, promise: &StatePromise) -> Result<(), Against> {
        let standing = (promise.taken != Taken::All).then(|| rest.mesh());
        let prints = |p: &Surface| self.machine.prints(&p.mesh(), &promise.plane.normal, standing.as_ref());
        if pieces.iter().all(prints) { Ok(()) } else { Err(Against::Head) }
    }

    /// What the cut makes, if the rules allow it.
    fn parts(&self, state: &SplitState, promise: &StatePromise) -> Result<CutParts, Against> {
        let SearchGround { options, rules, .. } = self.ground;
        let (number, plane) = (state.steps.len() as u32 + 1, &promise.plane);
        let cut = cut(&state.rest.surface, plane, &promise.taken, number).map_err(|_| Against::Crossing)?;
        let parts = kept(cut, plane, number, rules, &options.no_cut)?;
        if parts.needs.iter().any(|n| n.faults() > 0) {
            return Err(Against::Beginning);
        }
        if parts.falls {
            return Err(Against::Thin);
        }
        Ok(parts)
    }

    /// The state after a cut that the machine prints.
    fn after(&self, state: &SplitState, promise: &StatePromise, parts: CutParts) -> Result<SplitState, Against> {
        let SearchGround { rules, directions, .. } = self.ground;
        let CutParts { rest, pieces, needs, seam_mm2, crumbs_mm3, .. } = parts;
        let (plane, odd, all) = (promise.plane, promise.odd, promise.taken == Taken::All);
        let tops = promise.tops.iter().map(|&v| state.rest.surface.vertices[v as usize]).collect();
        let mut steps = state.steps.clone();
        let (gain_mm2, cap) = (0.0, state.steps.len() as u32 + 1);
        let passes = vec![OnceLock::new(); pieces.len()];
        steps.push(Arc::new(CutStep {
            plane,
            pieces,
            needs,
            seam_mm2,
            gain_mm2,
            crumbs_mm3,
            odd,
            all,
            tops,
            cap,
            passes,
        }));
        let mut child = SplitState::of(rest, rules, steps, directions.all.len());
        let gain_mm2 = state.left().area_mm2 - child.left().area_mm2;
        child.steps.iter_mut().last().and_then(Arc::get_mut).into_iter().for_each(|step| step.gain_mm2 = gain_mm2);
        // The cap may have made a new lowest place of what is left.
        if rules.faults && child.left().area_mm2 <= NOTHING_MM2 && child.rest.has_false_bottom(&Vec3::z(), None) {
            return Err(Against::Thin);
        }
        Ok(child)
    }

    /// The state after a cut, where that is worth what it costs.
    fn gains(&self, state: &SplitState, child: SplitState) -> Result<SplitState, Against> {
        if !self.affords(child.setups(), child.seam_mm2()) {
            return Err(Against::Budget);
        }
        let gains = child.area_mm2() < state.area_mm2() - SAME_MM2 || child.faults() < state.faults();
        if gains { Ok(child) } else { Err(Against::Gain) }
    }
}

/// The second where it is better.
fn better(first: SearchFound, second: SearchFound) -> SearchFound {
    let key = |found: &SearchFound| (!found.printable, found.state.key());
    let stopped = first.stopped || second.stopped;
    let found = if key(&second) < key(&first) { second } else { first };
    SearchFound { stopped, ..found }
}
