//! Models drawn into the space by simulated annealing on their own surfaces (Leitereg (2020), section 2.6): a random piece moves a random share of
//! the way that is free along a random direction, or turns so; a piece that is not all inside costs its value.
//!
//! Begun with the packing of the boxes and every other piece apart from all, above the space, so that the result is never worse than that. While it is
//! warm pieces may leave; then, as the thesis has it, moves that lead out are not drawn at all, and what is outside is drawn towards the space, the more
//! the colder it is. What lies inside sinks, so that room gathers at the top.

use super::instance::Turns;
use super::obb::{ObbTree, Pose, turned_about};
use super::solid::{PackSolid, Put, Room};
use super::watch::Watch;
use crate::geom::{Bounds, Mat3, SplitMix64, Vec3};

/// Steps of a watch that a move counts as.
const STEPS_A_MOVE: u64 = 100;
/// Moves for each piece.
const MOVES: usize = 4000;
/// A move's share of the space's longest side, at most.
const FARTHEST: f64 = 0.4;

struct Piece {
    model: usize,
    copy: usize,
    pose: Pose,
    bounds: Bounds,
    inside: bool,
}

struct Scene<'a> {
    solids: &'a [PackSolid],
    room: &'a Room,
    trees: Vec<ObbTree>,
    pieces: Vec<Piece>,
}

/// `start`, all of one run, with as many more pieces in it as find a way.
pub(super) fn annealed(solids: &[PackSolid], room: &Room, start: &[Put], seed: u64, watch: &mut Watch<'_>) -> Vec<Put> {
    let mut scene = Scene::of(solids, room, start);
    let mut numbers = SplitMix64::seeded(seed);
    let mut best = scene.value();
    let mut kept = scene.put();
    let all = scene.pieces.len() * MOVES;
    for step in 0..all {
        // A move among many facets takes long: the clock is asked at each.
        if !watch.spend(STEPS_A_MOVE) || !watch.goes_on() || scene.pieces.iter().all(|piece| piece.inside) {
            break;
        }
        let cold = step as f64 / all as f64;
        scene.step(cold, &mut numbers);
        if scene.value() > best {
            (best, kept) = (scene.value(), scene.put());
        }
    }
    kept
}

impl<'a> Scene<'a> {
    fn of(solids: &'a [PackSolid], room: &'a Room, start: &[Put]) -> Self {
        let trees = solids.iter().map(|solid| ObbTree::of(&solid.facets)).collect();
        let mut scene = Self { solids, room, trees, pieces: Vec::new() };
        let [x, y, z] = room.space_mm;
        // Apart from all others: on a grid as wide as the widest, above the space.
        let widest = solids.iter().map(|s| s.bounds(&Mat3::identity()).size().norm()).fold(0.0, f64::max) + room.gap_mm;
        let across = ((x.max(y) / widest) as usize).max(1);
        let mut waiting = 0;
        for (model, solid) in solids.iter().enumerate() {
            for copy in 0..solid.copies {
                let known = start.iter().find(|p| (p.model, p.copy) == (model, copy));
                let own = solid.bounds(&Mat3::identity());
                let cell = [waiting % across, waiting / across % across, waiting / across / across];
                let apart = Vec3::new(0.0, 0.0, z + widest) + Vec3::from(cell.map(|c| c as f64 * widest)) - own.min;
                waiting += usize::from(known.is_none());
                let pose = known
                    .map_or(Pose { turn: Mat3::identity(), shift: apart }, |p| Pose { turn: p.turn, shift: p.shift });
                let piece = scene.piece(model, copy, pose);
                scene.pieces.push(piece);
            }
        }
        scene
    }

    fn piece(&self, model: usize, copy: usize, pose: Pose) -> Piece {
        let own = self.solids[model].bounds(&pose.turn);
        let bounds = Bounds { min: own.min + pose.shift, max: own.max + pose.shift };
        let inside = (0..3).all(|k| bounds.min[k] >= -1e-9 && bounds.max[k] <= self.room.space_mm[k] + 1e-9);
        Piece { model, copy, pose, bounds, inside }
    }

    fn value(&self) -> f64 {
        self.pieces.iter().filter(|p| p.inside).map(|p| self.solids[p.model].value).sum()
    }

    fn put(&self) -> Vec<Put> {
        let inside = self.pieces.iter().filter(|p| p.inside);
        let put = |p: &Piece| Put { run: 0, model: p.model, copy: p.copy, turn: p.pose.turn, shift: p.pose.shift };
        inside.map(put).collect()
    }

    fn step(&mut self, cold: f64, numbers: &mut SplitMix64) {
        let outside: Vec<usize> = (0..self.pieces.len()).filter(|&i| !self.pieces[i].inside).collect();
        // What waits is looked at as often as what lies inside.
        let index =
            if numbers.unit() < 0.5 { outside[numbers.below(outside.len())] } else { numbers.below(self.pieces.len()) };
        let piece = &self.pieces[index];
        let turns = self.room.turns != Turns::None && numbers.unit() < 0.2;
        let moved = if turns { self.turned(index, numbers) } else { self.moved(index, cold, numbers) };
        let Some(pose) = moved else { return };
        let next = self.piece(piece.model, piece.copy, pose);
        // Out of the space only while it is warm: later such a move is not made, which is as if it had been drawn again.
        let leaves = piece.inside && !next.inside;
        if (leaves && numbers.unit() > 0.02 * (1.0 - cold).powi(4)) || !self.keeps_gap(index, &next) {
            return;
        }
        self.pieces[index] = next;
    }

    /// A share of the free way along a direction.
    fn moved(&self, index: usize, cold: f64, numbers: &mut SplitMix64) -> Option<Pose> {
        let piece = &self.pieces[index];
        let middle = Vec3::from(self.room.space_mm) / 2.0;
        let mut along = numbers.direction();
        if !piece.inside && numbers.unit() < 0.5 + 0.4 * cold {
            let aim = Vec3::from([0, 1, 2].map(|k| numbers.unit() * self.room.space_mm[k]));
            along = (aim - piece.bounds.centre()).try_normalize(1e-9)?;
        } else if piece.inside && numbers.unit() < 0.6 {
            along = Vec3::from(
                [0, 1, 2]
                    .map(|k| if k == 2 || middle[k] > piece.bounds.centre()[k] { -1.0 } else { 1.0 } * along[k].abs()),
            );
        }
        let farthest = FARTHEST * self.room.space_mm.iter().fold(0.0, |a: f64, &b| a.max(b));
        let most = if piece.inside {
            self.to_the_wall(&piece.bounds, &along).min(farthest)
        } else {
            f64::MAX.min(4.0 * farthest)
        };
        let free = self.free(index, &along, most);
        // All of it now and then: pieces that touch leave the most room.
        let share = if numbers.unit() < 0.4 { 1.0 } else { numbers.unit() };
        let by = if free < most { (free - self.room.gap_mm * 1.001).max(0.0) * share } else { free * share };
        (by > 1e-6).then(|| Pose { shift: piece.pose.shift + along * by, ..piece.pose })
    }

    fn to_the_wall(&self, bounds: &Bounds, along: &Vec3) -> f64 {
        let way = |k: usize| match along[k] {
            v if v > 1e-12 => (self.room.space_mm[k] - bounds.max[k]) / v,
            v if v < -1e-12 => -bounds.min[k] / v,
            _ => f64::INFINITY,
        };
        (0..3).map(way).fold(f64::INFINITY, f64::min).max(0.0)
    }

    /// How far a piece can be moved before it meets another, those whose boxes it passes nearest first.
    fn free(&self, index: usize, along: &Vec3, most: f64) -> f64 {
        let piece = &self.pieces[index];
        let swept = Bounds {
            min: piece.bounds.min.inf(&(piece.bounds.min + along * most)),
            max: piece.bounds.max.sup(&(piece.bounds.max + along * most)),
        };
        let mut near: Vec<(f64, usize)> = (0..self.pieces.len())
            .filter(|&other| other != index && self.pieces[other].bounds.meets(&swept))
            .map(|other| ((self.pieces[other].bounds.centre() - piece.bounds.centre()).norm(), other))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.iter().fold(most, |best, &(_, other)| {
            let them = &self.pieces[other];
            self.trees[piece.model].free(&piece.pose, &self.trees[them.model], &them.pose, along, best)
        })
    }

    /// A share of the free turn about a vertical or any axis through the piece's middle.
    fn turned(&self, index: usize, numbers: &mut SplitMix64) -> Option<Pose> {
        let piece = &self.pieces[index];
        let (axis, about) = match self.room.turns {
            Turns::Any => (numbers.direction(), piece.bounds.centre()),
            _ => (Vec3::z() * if numbers.unit() < 0.5 { 1.0 } else { -1.0 }, piece.bounds.centre()),
        };
        let wanted = if self.room.turns == Turns::Z90 { std::f64::consts::FRAC_PI_2 } else { numbers.unit() * 0.6 };
        let reach = piece.bounds.inflated(piece.bounds.size().norm());
        let near = (0..self.pieces.len()).filter(|&other| other != index && self.pieces[other].bounds.meets(&reach));
        let free = near.fold(wanted, |best, other| {
            let them = &self.pieces[other];
            let tree = &self.trees[them.model];
            self.trees[piece.model].turnable(&piece.pose, tree, &them.pose, &about, &axis, self.room.gap_mm, best)
        });
        // By quarters or not at all, where only these are allowed.
        let whole = self.room.turns != Turns::Z90 || free >= wanted;
        (whole && free > 1e-6).then(|| turned_about(&piece.pose, &about, &axis, free))
    }

    fn keeps_gap(&self, index: usize, next: &Piece) -> bool {
        let gap = self.room.gap_mm * (1.0 + 1e-6) + 1e-6;
        let around = next.bounds.inflated(gap);
        (0..self.pieces.len()).filter(|&other| other != index && self.pieces[other].bounds.meets(&around)).all(
            |other| {
                let them = &self.pieces[other];
                let tree = &self.trees[them.model];
                self.trees[next.model].distance(&next.pose, tree, &them.pose, gap) >= gap
            },
        )
    }
}
