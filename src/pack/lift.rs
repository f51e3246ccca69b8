//! In which order the models of a run can be lifted out, each straight up: one must wait while another has something above any of it.
//!
//! Looked at in columns half a gap wide, wider where these were many, each widened to whole columns: what is said to come out does; models whose sides only just pass each
//! other may be said to hold each other though they do not.

use std::collections::HashMap;

use super::solid::{PackSolid, Put, Room};
use super::voxels::{reach, slabs};
use crate::geom::{Bounds, Vec3};

/// How a run is emptied.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lift {
    /// Places in the list of pieces, in the order in which they come out.
    pub order: Vec<usize>,
    /// Pieces that hold each other.
    pub locked: Vec<usize>,
}

/// Columns across the longer side, at most, and below all pieces of a run.
const MOST_COLUMNS: f64 = 2000.0;
const MOST_BELOW: f64 = 2e6;

/// The order for each run.
pub fn lift(solids: &[PackSolid], room: &Room, put: &[Put]) -> Vec<Lift> {
    let runs = put.iter().map(|p| p.run + 1).max().unwrap_or(0);
    (0..runs).map(|run| of_run(solids, room, put, run)).collect()
}

fn of_run(solids: &[PackSolid], room: &Room, put: &[Put], run: usize) -> Lift {
    let own: Vec<usize> = (0..put.len()).filter(|&i| put[i].run == run).collect();
    let below = |&i: &usize| {
        let size = solids[put[i].model].bounds(&put[i].turn).size();
        size.x * size.y
    };
    let fine = (room.gap_mm / 2.0).max(room.space_mm[0].max(room.space_mm[1]) / MOST_COLUMNS);
    let step = fine.max((own.iter().map(below).sum::<f64>() / MOST_BELOW).sqrt());
    let mut columns: HashMap<[i32; 2], Vec<(usize, f64, f64)>> = HashMap::new();
    for (index, &piece) in own.iter().enumerate() {
        for (column, [low, high]) in silhouette(solids, &put[piece], step) {
            columns.entry(column).or_default().push((index, low, high));
        }
    }
    // Whom each one waits for: a row of marks each, as the same two meet in very many columns.
    let mut waits = vec![false; own.len() * own.len()];
    for all in columns.values() {
        for (i, low, _) in all {
            for (j, ..) in all.iter().filter(|(j, _, high)| j != i && high > low) {
                waits[i * own.len() + j] = true;
            }
        }
    }
    let above: Vec<Vec<usize>> = if own.is_empty() {
        Vec::new()
    } else {
        waits.chunks(own.len()).map(|row| (0..own.len()).filter(|&j| row[j]).collect()).collect()
    };
    let mut left: Vec<usize> = (0..own.len()).collect();
    let mut order = Vec::new();
    while let Some(next) = left.iter().position(|&i| above[i].iter().all(|j| !left.contains(j))) {
        order.push(own[left.remove(next)]);
    }
    Lift { order, locked: left.into_iter().map(|i| own[i]).collect() }
}

/// The lowest and highest of a piece over each column that it reaches into, mm.
fn silhouette(solids: &[PackSolid], put: &Put, step: f64) -> Vec<([i32; 2], [f64; 2])> {
    let facets = solids[put.model].turned(&put.turn);
    let moved: Vec<[Vec3; 3]> = facets.iter().map(|corners| corners.map(|p| (p + put.shift) / step)).collect();
    let ends = Bounds::of(moved.iter().flatten().copied());
    // One beyond either end, for what lies just on the border of a column.
    let [from, to] = [(ends.min, -1), (ends.max, 1)].map(|(end, more)| [0, 1].map(|k| end[k].floor() as i32 + more));
    let wide = [0, 1].map(|k| (to[k] - from[k] + 1).max(1) as usize);
    let mut found = vec![[f64::INFINITY, f64::NEG_INFINITY]; wide[0] * wide[1]];
    for corners in &moved {
        for (x, slab) in slabs(corners, 0, i32::MAX) {
            for (y, piece) in slabs(&slab, 1, i32::MAX) {
                let [low, high] = reach(&piece, 2);
                let known = &mut found[(x - from[0]) as usize * wide[1] + (y - from[1]) as usize];
                *known = [known[0].min(low * step), known[1].max(high * step)];
            }
        }
    }
    let reached = found.into_iter().enumerate().filter(|(_, [low, high])| low <= high);
    reached.map(|(at, ends)| ([from[0] + (at / wide[1]) as i32, from[1] + (at % wide[1]) as i32], ends)).collect()
}
