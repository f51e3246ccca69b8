//! From a grid of labels to areas with straight edges: what is seen at each place of a picture becomes few polygons.
//!
//! Between two places with different labels runs a piece of a border. Borders are followed from one place where three meet to the next,
//! straightened once (Douglas and Peucker 1973), and used by both sides, so that neighbours stay neighbours. Units: places of the
//! grid; `(0, 0)` is the upper left corner of the first.

use std::collections::{BTreeMap, HashMap};

/// No label: paper.
pub(super) const NOTHING: u32 = 0;
/// A border is straightened by at most so much: the middles of the steps of a slanting one are half a place to either side of it.
const STRAIGHTENED: f64 = 1.0;
/// Patches of fewer places are given to a neighbour of the same kin.
const SPECK: usize = 10;

/// A picture of labels, row by row from the top.
#[derive(Clone, Debug)]
pub(super) struct Labels {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) each: Vec<u32>,
}

/// Part of the border between two labels.
#[derive(Clone, Debug)]
pub(super) struct Border {
    /// Straightened; closed ones end where they begin.
    pub(super) points: Vec<[f64; 2]>,
    /// What the caller calls it.
    pub(super) class: u8,
}

/// The areas by label, and the borders between them.
pub(super) struct Regions {
    pub(super) areas: BTreeMap<u32, Vec<Vec<[f64; 2]>>>,
    pub(super) borders: Vec<Border>,
}

impl Regions {
    /// The borders of a class on paper.
    pub(super) fn lines(&self, class: u8, paper: impl Fn([f64; 2]) -> [f64; 2]) -> Vec<Vec<[f64; 2]>> {
        let own = self.borders.iter().filter(|border| border.class == class);
        own.map(|border| border.points.iter().map(|p| paper(*p)).collect()).collect()
    }
}

/// A border on the way: its nodes on the lattice of corners, and the labels to the left and right of it.
struct Chain {
    nodes: Vec<[i32; 2]>,
    sides: [u32; 2],
    class: u8,
}

/// Right, down, left, up.
const STEPS: [[i32; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

impl Labels {
    pub(super) fn new(width: usize, height: usize) -> Self {
        Self { width, height, each: vec![NOTHING; width * height] }
    }

    /// The label at a place; beyond the grid there is nothing.
    fn at(&self, x: i32, y: i32) -> u32 {
        self.index(x, y).map_or(NOTHING, |i| self.each[i])
    }

    fn index(&self, x: i32, y: i32) -> Option<usize> {
        let inside = x >= 0 && y >= 0 && x < self.width as i32 && y < self.height as i32;
        inside.then(|| y as usize * self.width + x as usize)
    }

    /// Small patches take the label of the neighbour with which they have the longest border, among those of the same `kin`.
    pub(super) fn without_specks<K: PartialEq>(&mut self, kin: impl Fn(u32) -> K) {
        let mut seen = vec![false; self.each.len()];
        let (mut patch, mut next): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
        for start in 0..self.each.len() {
            let label = self.each[start];
            if seen[start] || label == NOTHING {
                continue;
            }
            patch.clear();
            next.push(start);
            seen[start] = true;
            let mut beside: BTreeMap<u32, usize> = BTreeMap::new();
            while let Some(i) = next.pop() {
                patch.push(i);
                let (x, y) = ((i % self.width) as i32, (i / self.width) as i32);
                for [dx, dy] in STEPS {
                    let Some(j) = self.index(x + dx, y + dy) else { continue };
                    if self.each[j] != label {
                        *beside.entry(self.each[j]).or_default() += 1;
                    } else if !seen[j] {
                        seen[j] = true;
                        next.push(j);
                    }
                }
            }
            if patch.len() < SPECK {
                let own = kin(label);
                let near = beside.into_iter().filter(|(other, _)| *other != NOTHING && kin(*other) == own);
                if let Some((other, _)) = near.max_by_key(|(_, length)| *length) {
                    patch.iter().for_each(|&i| self.each[i] = other);
                }
            }
        }
    }

    /// The two places beside the piece of the lattice from a node in a direction: left and right of it.
    fn sides(&self, [x, y]: [i32; 2], direction: usize) -> [[i32; 2]; 2] {
        match direction {
            0 => [[x, y - 1], [x, y]],
            1 => [[x, y], [x - 1, y]],
            2 => [[x - 1, y], [x - 1, y - 1]],
            _ => [[x - 1, y - 1], [x, y - 1]],
        }
    }

    /// The labels there, where they differ.
    fn border(&self, node: [i32; 2], direction: usize) -> Option<[u32; 2]> {
        let [left, right] = self.sides(node, direction).map(|[x, y]| self.at(x, y));
        (left != right).then_some([left, right])
    }

    /// Areas and borders; `class` names a piece of border by the places on both sides (indices; `None` beyond the grid).
    pub(super) fn regions(&self, class: impl Fn([Option<usize>; 2]) -> u8) -> Regions {
        let class_of = |node: [i32; 2], direction: usize| {
            let mut places = self.sides(node, direction).map(|[x, y]| self.index(x, y));
            places.sort_unstable();
            class(places)
        };
        let chains = self.chains(&class_of);
        let straight: Vec<Vec<[f64; 2]>> = chains.iter().map(|chain| straightened(&chain.nodes)).collect();
        let mut areas: BTreeMap<u32, Vec<Vec<[f64; 2]>>> = BTreeMap::new();
        let mut of_label: BTreeMap<u32, Vec<(usize, bool)>> = BTreeMap::new();
        for (i, chain) in chains.iter().enumerate() {
            of_label.entry(chain.sides[0]).or_default().push((i, false));
            of_label.entry(chain.sides[1]).or_default().push((i, true));
        }
        for (label, own) in of_label.into_iter().filter(|(label, _)| *label != NOTHING) {
            areas.insert(label, rings(&own, &chains, &straight));
        }
        let borders =
            chains.iter().zip(straight).map(|(chain, points)| Border { points, class: chain.class }).collect();
        Regions { areas, borders }
    }

    /// All borders, each once.
    fn chains(&self, class_of: &impl Fn([i32; 2], usize) -> u8) -> Vec<Chain> {
        let (w, h) = (self.width as i32, self.height as i32);
        let mut used = vec![[false; 2]; ((w + 1) * (h + 1)) as usize];
        // A piece is kept by its left or upper node.
        let slot = |[x, y]: [i32; 2], direction: usize| {
            let [dx, dy] = STEPS[direction];
            let (x, y) = if direction < 2 { (x, y) } else { (x + dx, y + dy) };
            ((y * (w + 1) + x) as usize, direction % 2)
        };
        let ways = |node: [i32; 2]| (0..4).filter(move |d| self.border(node, *d).is_some());
        let is_end = |node: [i32; 2]| {
            let mut two = ways(node);
            match (two.next(), two.next(), two.next()) {
                (Some(a), Some(b), None) => class_of(node, a) != class_of(node, b),
                _ => true,
            }
        };
        let mut chains = Vec::new();
        // First those between ends, then what is left: rings without any.
        for only_from_ends in [true, false] {
            for node in (0..=h).flat_map(|y| (0..=w).map(move |x| [x, y])) {
                for first in ways(node) {
                    let (at, which) = slot(node, first);
                    if used[at][which] || (only_from_ends && !is_end(node)) {
                        continue;
                    }
                    let sides = self.border(node, first).unwrap_or_default();
                    let mut chain = Chain { nodes: vec![node], sides, class: class_of(node, first) };
                    let (mut here, mut direction) = (node, first);
                    loop {
                        let (at, which) = slot(here, direction);
                        used[at][which] = true;
                        let [dx, dy] = STEPS[direction];
                        here = [here[0] + dx, here[1] + dy];
                        chain.nodes.push(here);
                        if here == node || is_end(here) {
                            break;
                        }
                        let back = (direction + 2) % 4;
                        let Some(on) = ways(here).find(|d| *d != back) else { break };
                        direction = on;
                    }
                    chains.push(chain);
                }
            }
        }
        chains
    }
}

/// The rings of a label's borders; each chain with whether it is gone along backwards.
fn rings(own: &[(usize, bool)], chains: &[Chain], straight: &[Vec<[f64; 2]>]) -> Vec<Vec<[f64; 2]>> {
    let ends = |&(i, back): &(usize, bool)| {
        let nodes = &chains[i].nodes;
        let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
        if back { [last, first] } else { [first, last] }
    };
    let mut from: HashMap<[i32; 2], Vec<usize>> = HashMap::new();
    for (k, way) in own.iter().enumerate().rev() {
        from.entry(ends(way)[0]).or_default().push(k);
    }
    let mut used = vec![false; own.len()];
    let mut all = Vec::new();
    for start in 0..own.len() {
        let (mut k, mut ring) = (start, Vec::new());
        while !used[k] {
            used[k] = true;
            let (i, back) = own[k];
            let points = &straight[i];
            // The last corner is the next one's first.
            let count = points.len() - 1;
            let point = |j: usize| if back { points[count - j] } else { points[j] };
            ring.extend((0..count).map(point));
            let end = ends(&own[k])[1];
            // Where a label meets itself across a corner, either way on gives the same area.
            let Some(on) = from.get(&end).and_then(|ways| ways.iter().rev().find(|k| !used[**k])) else { break };
            k = *on;
        }
        if ring.len() > 2 {
            all.push(ring);
        }
    }
    all
}

/// A chain by the middles of its pieces, its ends kept, without corners that hardly turn it.
fn straightened(nodes: &[[i32; 2]]) -> Vec<[f64; 2]> {
    let place = |n: [i32; 2]| n.map(f64::from);
    let (first, last) = (place(nodes[0]), place(nodes[nodes.len() - 1]));
    let middle = |w: &[[i32; 2]]| [0, 1].map(|k| f64::from(w[0][k] + w[1][k]) / 2.0);
    let mut points: Vec<[f64; 2]> = nodes.windows(2).map(middle).collect();
    if first == last && nodes.len() > 4 {
        // A ring: halves of it, else there would be no line to measure from.
        points.push(points[0]);
        let far = |p: &[f64; 2]| (p[0] - points[0][0]).hypot(p[1] - points[0][1]);
        let half = (0..points.len()).max_by(|a, b| far(&points[*a]).total_cmp(&far(&points[*b]))).unwrap_or(0);
        let mut kept = simplified(&points[..=half]);
        kept.pop();
        kept.extend(simplified(&points[half..]));
        return kept;
    }
    points.insert(0, first);
    points.push(last);
    simplified(&points)
}

/// Douglas and Peucker's.
fn simplified(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut keep = vec![false; points.len()];
    let mut open = vec![(0, points.len() - 1)];
    keep[0] = true;
    keep[points.len() - 1] = true;
    while let Some((a, b)) = open.pop() {
        let (p, q) = (points[a], points[b]);
        let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
        let length = dx.hypot(dy);
        let off = |r: &[f64; 2]| {
            let (x, y) = (r[0] - p[0], r[1] - p[1]);
            if length > 0.0 { (x * dy - y * dx).abs() / length } else { x.hypot(y) }
        };
        let far = (a + 1..b).max_by(|i, j| off(&points[*i]).total_cmp(&off(&points[*j])));
        if let Some(far) = far.filter(|far| off(&points[*far]) > STRAIGHTENED) {
            keep[far] = true;
            open.extend([(a, far), (far, b)]);
        }
    }
    points.iter().zip(keep).filter_map(|(p, keep)| keep.then_some(*p)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(text: &[&str]) -> Labels {
        let each = text.iter().flat_map(|row| row.bytes().map(|b| if b == b'.' { 0 } else { u32::from(b) })).collect();
        Labels { width: text[0].len(), height: text.len(), each }
    }

    /// Twice the area within rings; holes are gone around the other way.
    fn area(rings: &[Vec<[f64; 2]>]) -> f64 {
        let of = |ring: &Vec<[f64; 2]>| {
            let next = |i: usize| ring[(i + 1) % ring.len()];
            ring.iter().enumerate().map(|(i, p)| p[0] * next(i)[1] - next(i)[0] * p[1]).sum::<f64>() / 2.0
        };
        rings.iter().map(of).sum::<f64>().abs()
    }

    /// A disc with a hole, cut in two by a line, drawn large: areas to the hundredth.
    #[test]
    fn areas_keep_their_size_and_neighbours_their_border() {
        let n = 400usize;
        let mut picture = Labels::new(n, n);
        let (mut truth, mut lines) = ([0.0; 2], 0);
        for i in 0..n * n {
            let (x, y) = ((i % n) as f64 - 200.0, (i / n) as f64 - 190.0);
            let r = x.hypot(y);
            if (60.0..170.0).contains(&r) {
                let side = usize::from(x > 0.37 * y + 11.0);
                picture.each[i] = 1 + side as u32;
                truth[side] += 1.0;
            }
        }
        let regions =
            picture.regions(|[a, b]| u8::from(a.zip(b).is_some_and(|(a, b)| picture.each[a] * picture.each[b] == 2)));
        for (side, truth) in (1u32..).zip(truth) {
            let drawn = area(&regions.areas[&side]);
            assert!((drawn / truth - 1.0).abs() < 0.01, "{drawn} for {truth}");
        }
        for border in regions.borders.iter().filter(|b| b.class == 1) {
            lines += 1;
            // The straight line between the halves is straight: few corners.
            assert!(border.points.len() <= 4, "{:?}", border.points);
        }
        assert_eq!(lines, 2, "the line is in two pieces");
        let corners: usize = regions.areas.values().flatten().map(Vec::len).sum();
        assert!(corners < 300, "{corners} corners");
    }

    #[test]
    fn patches_that_meet_at_a_corner_and_that_touch_the_edge_are_whole() {
        let picture = labels(&[
            "aaaaaabbbbbb",
            "aaaaaabbbbbb",
            "aaaaaabbbbbb",
            "aaaaaabbbbbb",
            "bbbbbbaaaaaa",
            "bbbbbbaaaaaa",
            "bbbbbbaaaaaa",
            "bbbbbbaaaaaa",
        ]);
        let regions = picture.regions(|_| 0);
        for label in [b'a', b'b'] {
            let rings = &regions.areas[&u32::from(label)];
            assert!(rings.iter().flatten().all(|p| (0.0..=12.0).contains(&p[0]) && (0.0..=8.0).contains(&p[1])));
            assert!((area(rings) - 48.0).abs() < 4.0, "{rings:?}");
        }
        let ring =
            labels(&[".......", ".aaaaa.", ".a...a.", ".a...a.", ".a...a.", ".aaaaa.", "......."]).regions(|_| 0);
        assert_eq!(ring.areas.len(), 1);
        assert_eq!(ring.areas[&97].len(), 2, "a ring and its hole");
    }

    #[test]
    fn specks_go_to_their_kin_alone() {
        let mut rows = vec!["aaaaaaaaaaaa"; 8];
        rows[3] = "aaabbaaaacaa";
        let mut picture = labels(&rows);
        picture.without_specks(|label| label == u32::from(b'c'));
        let count = |label: u8| picture.each.iter().filter(|l| **l == u32::from(label)).count();
        assert_eq!([count(b'a'), count(b'b'), count(b'c')], [95, 0, 1]);
    }
}
