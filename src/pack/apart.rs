//! Whether models lie apart by the gap and within the space, told facet by facet: nothing of the searches is used here.
//!
//! For every two models of a run whose boxes come near: the least distance between any two of their facets (edges against edges, corners against
//! facets, edges through facets), through a tree of boxes of its own; and whether one lies inside the other, by the solid angle that its surface
//! fills as seen from a corner (van Oosterom and Strackee 1983).

use std::collections::HashMap;

use super::solid::{PackSolid, Put, Room};
use crate::geom::{Bounds, Vec3};

/// What distances may fall short by, mm: rounding of coordinates, far below any print.
pub const ROUNDING_MM: f64 = 1e-5;

/// What is wrong with a packing of models, by the places of its pieces in the list.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Clash {
    /// A piece leaves the space.
    #[error("piece {piece} leaves the space by {by_mm:.4} mm")]
    Outside {
        /// The piece.
        piece: usize,
        /// How far, mm.
        by_mm: f64,
    },
    /// Two pieces overlap or are too near.
    #[error("pieces {pieces:?} are {mm:.4} mm apart")]
    Near {
        /// The pieces.
        pieces: [usize; 2],
        /// Their distance, mm; 0 where they overlap.
        mm: f64,
    },
}

/// The least distance between two pieces of a run, mm; `None` where all are more than twice the gap apart.
///
/// # Errors
///
/// The first [`Clash`].
pub fn apart(solids: &[PackSolid], room: &Room, put: &[Put]) -> Result<Option<f64>, Clash> {
    let mut bodies: Vec<Body> = Vec::new();
    let mut known: HashMap<(usize, [u64; 9]), usize> = HashMap::new();
    let mut least = f64::INFINITY;
    let body_of = |p: &Put, bodies: &mut Vec<Body>, known: &mut HashMap<_, _>| {
        let turn: [u64; 9] = std::array::from_fn(|i| p.turn[i].to_bits());
        *known.entry((p.model, turn)).or_insert_with(|| {
            bodies.push(Body::of(solids[p.model].turned(&p.turn)));
            bodies.len() - 1
        })
    };
    let of: Vec<usize> = put.iter().map(|p| body_of(p, &mut bodies, &mut known)).collect();
    for (piece, p) in put.iter().enumerate() {
        let bounds = bodies[of[piece]].moved(&p.shift);
        let beyond = (0..3).map(|k| (-bounds.min[k]).max(bounds.max[k] - room.space_mm[k])).fold(0.0, f64::max);
        if beyond > ROUNDING_MM {
            return Err(Clash::Outside { piece, by_mm: beyond });
        }
        for (other, q) in put[..piece].iter().enumerate().filter(|(_, q)| q.run == p.run) {
            let reach = (2.0 * room.gap_mm).min(least);
            if box_distance(&bounds, &bodies[of[other]].moved(&q.shift)) > reach {
                continue;
            }
            let mm = distance(&bodies[of[piece]], &bodies[of[other]], &(q.shift - p.shift), reach);
            if mm < room.gap_mm - ROUNDING_MM {
                return Err(Clash::Near { pieces: [other, piece], mm });
            }
            least = least.min(mm);
        }
    }
    Ok((least < 2.0 * room.gap_mm).then_some(least))
}

/// A surface with a tree of boxes over its facets.
struct Body {
    facets: Vec<[Vec3; 3]>,
    nodes: Vec<Node>,
}

struct Node {
    bounds: Bounds,
    /// Facets of a leaf; children of an inner node.
    range: (usize, usize),
    leaf: bool,
}

/// Facets of a leaf.
const LEAF: usize = 4;

impl Body {
    fn of(mut facets: Vec<[Vec3; 3]>) -> Self {
        let mut nodes = Vec::new();
        let count = facets.len();
        build(&mut facets, 0, count, &mut nodes);
        Self { facets, nodes }
    }

    fn moved(&self, by: &Vec3) -> Bounds {
        let own = self.nodes[0].bounds;
        Bounds { min: own.min + by, max: own.max + by }
    }

    /// Whether a point lies inside.
    fn holds(&self, p: &Vec3) -> bool {
        let angle: f64 = self.facets.iter().map(|corners| solid_angle(&corners.map(|c| c - p))).sum();
        angle.abs() > std::f64::consts::TAU
    }
}

fn build(facets: &mut [[Vec3; 3]], from: usize, to: usize, nodes: &mut Vec<Node>) -> usize {
    let bounds = Bounds::of(facets[from..to].iter().flatten().copied());
    let here = nodes.len();
    nodes.push(Node { bounds, range: (from, to), leaf: true });
    if to - from > LEAF {
        let axis = bounds.size().imax();
        let middle = (from + to) / 2;
        let key = |f: &[Vec3; 3]| f[0][axis] + f[1][axis] + f[2][axis];
        facets[from..to].select_nth_unstable_by(middle - from, |a, b| key(a).total_cmp(&key(b)));
        let first = build(facets, from, middle, nodes);
        let second = build(facets, middle, to, nodes);
        (nodes[here].leaf, nodes[here].range) = (false, (first, second));
    }
    here
}

/// The angle of a facet as seen from the origin, with its sense.
fn solid_angle([a, b, c]: &[Vec3; 3]) -> f64 {
    let (x, y, z) = (a.norm(), b.norm(), c.norm());
    let over = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
    2.0 * a.dot(&b.cross(c)).atan2(over)
}

/// The distance of two bodies, `b` moved by `by`; 0 where one holds the other, and `reach` where it is no less.
fn distance(a: &Body, b: &Body, by: &Vec3, reach: f64) -> f64 {
    let inner = |one: &Body, other: &Body, from: Vec3| one.holds(&(other.facets[0][0] + from));
    if a.nodes[0].bounds.meets(&b.moved(by)) && (inner(a, b, *by) || inner(b, a, -by)) {
        return 0.0;
    }
    let mut least = reach;
    let mut stack = vec![(0, 0)];
    while let Some((i, j)) = stack.pop() {
        let (one, other) = (&a.nodes[i], &b.nodes[j]);
        let moved = Bounds { min: other.bounds.min + by, max: other.bounds.max + by };
        if box_distance(&one.bounds, &moved) >= least {
            continue;
        }
        match (one.leaf, other.leaf) {
            (true, true) => {
                for f in &a.facets[one.range.0..one.range.1] {
                    for g in &b.facets[other.range.0..other.range.1] {
                        least = least.min(facet_distance(f, &g.map(|p| p + by)));
                    }
                }
            }
            (false, true) => stack.extend([(one.range.0, j), (one.range.1, j)]),
            (true, false) => stack.extend([(i, other.range.0), (i, other.range.1)]),
            (false, false) if one.bounds.size().norm() > other.bounds.size().norm() => {
                stack.extend([(one.range.0, j), (one.range.1, j)]);
            }
            (false, false) => stack.extend([(i, other.range.0), (i, other.range.1)]),
        }
    }
    least
}

fn box_distance(a: &Bounds, b: &Bounds) -> f64 {
    Vec3::from([0, 1, 2].map(|k| (a.min[k] - b.max[k]).max(b.min[k] - a.max[k]).max(0.0))).norm()
}

/// The least distance between two facets; 0 where they meet.
fn facet_distance(f: &[Vec3; 3], g: &[Vec3; 3]) -> f64 {
    let edges = |t: &[Vec3; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let mut least = f64::INFINITY;
    for e in edges(f) {
        for h in edges(g) {
            least = least.min(edge_distance(&e, &h));
        }
    }
    for (one, other) in [(f, g), (g, f)] {
        for corner in one {
            least = least.min(above(corner, other).unwrap_or(f64::INFINITY));
        }
        if edges(one).iter().any(|edge| pierces(edge, other)) {
            return 0.0;
        }
    }
    least
}

/// Between two edges (Ericson, "Real-time collision detection", 2005, section 5.1.9).
fn edge_distance([p, q]: &[Vec3; 2], [r, s]: &[Vec3; 2]) -> f64 {
    let (d, e, between) = (q - p, s - r, p - r);
    let (a, c, f) = (d.dot(&d), e.dot(&e), e.dot(&between));
    let share = |value: f64, of: f64| if of > 0.0 { (value / of).clamp(0.0, 1.0) } else { 0.0 };
    let (b, g) = (d.dot(&e), d.dot(&between));
    let denominator = a * c - b * b;
    let mut along = if denominator > 1e-12 * a * c { share(b * f - g * c, denominator) } else { 0.0 };
    let mut other = if c > 0.0 { (b * along + f) / c } else { 0.0 };
    if !(0.0..=1.0).contains(&other) {
        other = other.clamp(0.0, 1.0);
        along = share(b * other - g, a);
    } else if c == 0.0 {
        along = share(-g, a);
    }
    (p + d * along - r - e * other).norm()
}

/// How far a point is from a facet's plane, where it lies straight above or below the facet.
fn above(p: &Vec3, [a, b, c]: &[Vec3; 3]) -> Option<f64> {
    let normal = (b - a).cross(&(c - a));
    let length = normal.norm();
    let over = |u: &Vec3, v: &Vec3| (v - u).cross(&(p - u)).dot(&normal) >= 0.0;
    (length > 0.0 && over(a, b) && over(b, c) && over(c, a)).then(|| ((p - a).dot(&normal) / length).abs())
}

/// Whether an edge goes through a facet.
fn pierces([p, q]: &[Vec3; 2], [a, b, c]: &[Vec3; 3]) -> bool {
    let normal = (b - a).cross(&(c - a));
    let (from, to) = ((p - a).dot(&normal), (q - a).dot(&normal));
    if (from > 0.0) == (to > 0.0) || from == to {
        return false;
    }
    let on = p + (q - p) * (from / (from - to));
    above(&on, &[*a, *b, *c]).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;
    use crate::geom::{Mat3, SplitMix64};
    use crate::pack::Turns;

    /// Against the nearest of many points on both.
    #[test]
    fn distances_of_facets_are_those_of_their_points() {
        let mut numbers = SplitMix64::seeded(2);
        let mut met = 0;
        for _ in 0..300 {
            let mut facet = |far: f64| [(); 3].map(|()| numbers.direction() * 2.0 + Vec3::x() * far);
            let (f, g) = (facet(0.0), facet(1.5));
            let found = facet_distance(&f, &g);
            assert!((found - facet_distance(&g, &f)).abs() < 1e-9);
            let grid = |t: &[Vec3; 3]| -> Vec<Vec3> {
                let shares =
                    (0..=40).flat_map(|i| (0..=40 - i).map(move |j| (f64::from(i) / 40.0, f64::from(j) / 40.0)));
                shares.map(|(s, t2)| t[0] + (t[1] - t[0]) * s + (t[2] - t[0]) * t2).collect()
            };
            let least =
                grid(&f).iter().flat_map(|p| grid(&g).into_iter().map(move |q| (p - q).norm())).fold(9.0, f64::min);
            assert!(found <= least + 1e-9 && found >= least - 0.13, "{found} beside {least}");
            met += usize::from(found == 0.0);
        }
        assert!(met > 10);
    }

    #[test]
    fn what_is_near_outside_or_inside_is_found() {
        let cube = PackSolid::of([&solid_box(Vec3::zeros(), Vec3::repeat(10.0))], 1.0, 2);
        let small = PackSolid::of([&solid_box(Vec3::zeros(), Vec3::repeat(1.0))], 1.0, 1);
        let room = Room { space_mm: [40.0; 3], gap_mm: 1.0, turns: Turns::None, liftable: false };
        let at =
            |model, x: f64, y: f64| Put { run: 0, model, copy: 0, turn: Mat3::identity(), shift: Vec3::new(x, y, 0.0) };
        let solids = [cube, small];
        let told = |second: Put| apart(&solids, &room, &[at(0, 0.0, 0.0), second]);
        assert_eq!(told(at(0, 20.0, 0.0)), Ok(None));
        assert!(matches!(told(at(0, 11.0, 0.0)), Ok(Some(mm)) if (mm - 1.0).abs() < 1e-9));
        assert!(matches!(told(at(0, 10.8, 10.8)), Ok(Some(mm)) if (mm - 0.8 * 2_f64.sqrt()).abs() < 1e-9));
        let near = told(at(0, 10.9, 0.0));
        assert!(matches!(near, Err(Clash::Near { pieces: [0, 1], mm }) if (mm - 0.9).abs() < 1e-9), "{near:?}");
        assert_eq!(told(at(0, 5.0, 5.0)), Err(Clash::Near { pieces: [0, 1], mm: 0.0 }));
        assert_eq!(told(at(1, 5.0, 5.0)), Err(Clash::Near { pieces: [0, 1], mm: 0.0 }));
        assert!(
            matches!(told(at(0, 30.5, 0.0)), Err(Clash::Outside { piece: 1, by_mm }) if (by_mm - 0.5).abs() < 1e-9)
        );
        let elsewhere = Put { run: 1, ..at(0, 5.0, 0.0) };
        assert_eq!(told(elsewhere), Ok(None));
    }
}
