//! Models side by side on a machine's table: one layer, with as much room between them as the head needs.

use super::error::PackError;
use super::limit::Limit;
use super::result::PackResult;
use super::{Asked, BadPacking, no_fit, proved, solids};
use crate::geom::{Mat3, Vec3};
use crate::input::{LoadedModel, LoadedProfile};
use crate::pack::{Ended, Method, PackGoal, PackSolid, Packed, Put, Room, Turns, on_table};
use crate::strategy::head_reach_mm;
use crate::world::World;

/// Packs models on the table, run after run: the largest first, as many as stand beside each other.
pub(super) fn packed(
    models: &[(LoadedModel, usize)],
    machine: &LoadedProfile,
    asked: &Asked<'_>,
    stop: &dyn Fn() -> bool,
    limit: &Limit<'_>,
    world: &World<'_>,
) -> Result<PackResult, PackError> {
    let refused = |why: &str| BadPacking::Method { method: asked.name.to_owned(), why: why.to_owned() };
    if asked.method != Method::Auto {
        return Err(refused("on a table models are placed side by side in one layer; use --method auto").into());
    }
    if asked.goal == PackGoal::Filling {
        return Err(refused(
            "on a table all models are placed in as few runs as possible; --fill needs a space (--space)",
        )
        .into());
    }
    if asked.turns == Turns::Any {
        return Err(refused("on a table models are turned about Z only; use --turn none, z90 or z").into());
    }
    let solids = solids(models, asked)?;
    let poses: Vec<Mat3> = solids.iter().map(|solid| snug(solid, asked.turns)).collect();
    let highest = solids.iter().zip(&poses).map(|(s, pose)| s.bounds(pose).size().z).fold(0.0, f64::max);
    let gap_mm = asked.options.gap_mm.unwrap_or_else(|| head_reach_mm(machine, highest).max(NEAREST_MM));
    let table = Table { solids: &solids, poses: &poses, machine, gap_mm, turns: asked.turns };
    let half = table.half_mm();
    let room = Room { space_mm: [2.0 * half, 2.0 * half, highest + 1.0], gap_mm, turns: asked.turns, liftable: true };
    let all: Vec<(usize, usize)> =
        solids.iter().enumerate().flat_map(|(m, solid)| (0..solid.copies).map(move |copy| (m, copy))).collect();
    if let Some(&(model, _)) = all.iter().find(|piece| table.standing(&[**piece], 0).is_none()) {
        return Err(no_fit(models, &solids, model, &room).into());
    }
    let (put, ended) = asked.watched(stop, limit, world, &mut |_| (), |watch| {
        let put = table.runs(all, &mut || watch.goes_on());
        (put, if watch.goes_on() { Ended::Steps } else { watch.ended() })
    });
    let runs = put.iter().map(|p| p.run + 1).max().unwrap_or(0);
    let bound = table.bound();
    let ended = if runs as f64 <= bound { Ended::Proved } else { ended };
    let packed = Packed { put, runs, bound, ended, boxes: runs as f64 };
    let mut done = proved(models, &solids, &room, packed, asked, limit)?;
    done.about_middle(half);
    Ok(done)
}

/// As drawn, or at the angle about Z at which its outline's box is smallest.
fn snug(solid: &PackSolid, turns: Turns) -> Mat3 {
    let angle = if turns == Turns::Z { solid.snug_angle() } else { 0.0 };
    if angle == 0.0 { Mat3::identity() } else { nalgebra::Rotation3::new(Vec3::z() * angle).into_inner() }
}

/// Between models on a table where the head reaches less far, mm.
const NEAREST_MM: f64 = 5.0;

struct Table<'a> {
    solids: &'a [PackSolid],
    poses: &'a [Mat3],
    machine: &'a LoadedProfile,
    gap_mm: f64,
    turns: Turns,
}

impl Table<'_> {
    fn inside(&self, at: [f64; 2]) -> bool {
        self.machine.profile.beyond_table(at[0], at[1]) <= 0.0
    }

    /// Half of the square around the table, mm.
    fn half_mm(&self) -> f64 {
        let table = &self.machine.profile.table;
        let sides = table.size_mm.filter(|_| table.radius_mm == 0.0);
        sides.map_or(table.radius_mm, |[w, d]| w.max(d) / 2.0)
    }

    /// The pieces on one table; `None` where they do not fit.
    fn standing(&self, pieces: &[(usize, usize)], run: usize) -> Option<Vec<Put>> {
        let bounds: Vec<_> = pieces.iter().map(|(model, _)| self.solids[*model].bounds(&self.poses[*model])).collect();
        let footprints: Vec<[f64; 2]> = bounds.iter().map(|b| [b.size().x, b.size().y]).collect();
        let spots = on_table(&footprints, self.gap_mm, self.turns != Turns::None, &|at| self.inside(at))?;
        let quarter = Mat3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        let turns: Vec<Mat3> = spots
            .iter()
            .zip(pieces)
            .map(|(spot, (model, _))| if spot.turned { quarter * self.poses[*model] } else { self.poses[*model] })
            .collect();
        let turned: Vec<_> =
            turns.iter().zip(pieces).map(|(turn, (model, _))| self.solids[*model].bounds(turn)).collect();
        let far = |k: usize| {
            let ends = spots.iter().zip(&turned).map(|(spot, b)| spot.corner[k] + b.size()[k]);
            ends.fold(0.0, f64::max)
        };
        let least = |k: usize| spots.iter().map(|spot| spot.corner[k]).fold(f64::INFINITY, f64::min);
        let middle = [0, 1].map(|k| (least(k) + far(k)) / 2.0);
        let half = self.half_mm();
        let place = |index: usize| {
            let (b, (model, copy)) = (&turned[index], pieces[index]);
            let to = [0, 1].map(|k| spots[index].corner[k] - middle[k] + half);
            let shift = Vec3::new(to[0] - b.min.x, to[1] - b.min.y, -b.min.z);
            Put { run, model, copy, turn: turns[index], shift }
        };
        Some((0..pieces.len()).map(place).collect())
    }

    /// Run after run: piece by piece by falling footprint, each kept if all still fit.
    fn runs(&self, mut left: Vec<(usize, usize)>, goes_on: &mut dyn FnMut() -> bool) -> Vec<Put> {
        let area = |(model, _): &(usize, usize)| {
            let size = self.solids[*model].bounds(&self.poses[*model]).size();
            size.x * size.y
        };
        left.sort_by(|a, b| area(b).total_cmp(&area(a)).then(a.cmp(b)));
        let mut put = Vec::new();
        for run in 0.. {
            let (mut here, mut standing, mut over) = (Vec::new(), Vec::new(), Vec::new());
            let mut full: Option<usize> = None;
            for piece in left {
                here.push(piece);
                // What had no room has none for its copies; when time is up each further piece gets a run of its own.
                let tried = full != Some(piece.0) && (here.len() == 1 || goes_on());
                match self.standing(&here, run).filter(|_| tried) {
                    Some(all) => standing = all,
                    None => {
                        full = Some(piece.0);
                        here.pop();
                        over.push(piece);
                    }
                }
            }
            put.append(&mut standing);
            if over.is_empty() {
                break;
            }
            left = over;
        }
        put
    }

    /// By area: boxes of outlines grown by half the gap on the table grown so.
    fn bound(&self) -> f64 {
        let (table, half) = (&self.machine.profile.table, self.half_mm());
        let gap = self.gap_mm;
        let round = table.size_mm.is_none() || table.radius_mm > 0.0;
        let side = 2.0 * half + gap;
        let room = if round { std::f64::consts::PI * (half + gap / 2.0_f64.sqrt()).powi(2) } else { side * side };
        let grown = |solid: &PackSolid| {
            let b = solid.bounds(&Mat3::identity()).size();
            let snug = solid.bounds(&snug(solid, Turns::Z)).size();
            // Whatever the angle, an outline's box is no smaller than the outline: half of its snuggest box.
            let least = if self.turns == Turns::Z { snug.x * snug.y / 2.0 } else { (b.x + gap) * (b.y + gap) };
            least * solid.copies as f64
        };
        (self.solids.iter().map(grown).sum::<f64>() / room * (1.0 - 1e-9)).ceil().max(1.0)
    }
}
