//! The support graph and its flows once more, from their definitions alone: explicit lists, no order of levels, Bellman and Ford.
//!
//! Shares nothing with `src/support`. For small grids only.

/// A small scene: cubes that are black, and of those the ones that want support.
#[derive(Clone, Debug)]
pub(super) struct Marks {
    pub(super) size: [usize; 3],
    pub(super) black: Vec<bool>,
    pub(super) wants: Vec<bool>,
}

/// The graph that follows from it, arcs and all.
#[derive(Debug, Default)]
pub(super) struct Explicit {
    pub(super) nodes: Vec<[usize; 3]>,
    /// Places in `nodes`, upper and lower, and cost.
    pub(super) arcs: Vec<(usize, usize, i64)>,
    pub(super) red: Vec<usize>,
    pub(super) green: Vec<usize>,
    pub(super) unreachable: usize,
}

impl Marks {
    fn is_black(&self, at: [i64; 3]) -> Option<bool> {
        let inside = (0..3).all(|k| at[k] >= 0 && at[k] < self.size[k] as i64);
        inside.then(|| self.black[(at[0] + self.size[0] as i64 * (at[1] + self.size[1] as i64 * at[2])) as usize])
    }

    /// Squares below `at` that a support may go to, with their costs.
    fn below(&self, [x, y, z]: [i64; 3]) -> Vec<([i64; 3], i64)> {
        if self.is_black([x, y, z - 1]) != Some(false) {
            return Vec::new();
        }
        let mut found = vec![([x, y, z - 1], 1)];
        for (u, v) in [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)] {
            if self.is_black([u, v, z - 1]) == Some(false) {
                found.push(([u, v, z - 1], 2));
            }
        }
        found
    }

    fn reaches_ground(&self, at: [i64; 3]) -> bool {
        if at[2] == 0 {
            return self.is_black(at) == Some(false);
        }
        self.below(at).into_iter().any(|(next, _)| self.reaches_ground(next))
    }

    pub(super) fn explicit(&self) -> Explicit {
        let mut graph = Explicit::default();
        let [nx, ny, nz] = self.size.map(|n| n as i64);
        let all = (1..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        let index = |[x, y, z]: [i64; 3]| (x + nx * (y + ny * z)) as usize;
        let mut starts = Vec::new();
        for at in all.filter(|&at| self.wants[index(at)] && self.is_black(at) == Some(true)) {
            if self.is_black([at[0], at[1], at[2] - 1]) == Some(false) {
                if self.reaches_ground(at) {
                    starts.push(at);
                } else {
                    graph.unreachable += 1;
                }
            }
        }
        let place = |graph: &mut Explicit, at: [i64; 3]| {
            let at = at.map(|i| i as usize);
            graph.nodes.iter().position(|one| *one == at).unwrap_or_else(|| {
                graph.nodes.push(at);
                graph.nodes.len() - 1
            })
        };
        for &start in &starts {
            let number = place(&mut graph, start);
            graph.red.push(number);
        }
        let mut next = 0;
        while let Some(&at) = graph.nodes.get(next) {
            for (below, cost) in self.below(at.map(|i| i as i64)) {
                if self.reaches_ground(below) {
                    let head = place(&mut graph, below);
                    graph.arcs.push((next, head, cost));
                }
            }
            if at[2] == 0 {
                graph.green.push(next);
            }
            next += 1;
        }
        graph
    }
}

/// The largest flow from all red nodes and the least cost of one as large, with at most `arc` on an arc and `node` through a node.
pub(super) fn flow(graph: &Explicit, arc: i64, node: Option<i64>) -> (usize, i64) {
    let n = graph.nodes.len();
    let [source, sink] = [2 * n, 2 * n + 1];
    // Upper half, lower half, what is left, cost; each arc is followed by its reverse.
    let mut list: Vec<(usize, usize, i64, i64)> = Vec::new();
    let mut add =
        |from: usize, to: usize, room: i64, cost: i64| list.extend([(from, to, room, cost), (to, from, 0, -cost)]);
    (0..n).for_each(|i| add(i, n + i, node.unwrap_or(1 << 30), 0));
    graph.arcs.iter().for_each(|&(from, to, cost)| add(n + from, to, arc, cost));
    graph.red.iter().for_each(|&red| add(source, red, 1, 0));
    graph.green.iter().for_each(|&green| add(n + green, sink, 1 << 30, 0));
    let (mut units, mut cost) = (0, 0);
    loop {
        let mut best = vec![(i64::MAX / 2, usize::MAX); 2 * n + 2];
        best[source].0 = 0;
        let mut changed = true;
        while changed {
            changed = false;
            for (k, &(from, to, room, price)) in list.iter().enumerate() {
                if room > 0 && best[from].0 < i64::MAX / 2 && best[from].0 + price < best[to].0 {
                    best[to] = (best[from].0 + price, k);
                    changed = true;
                }
            }
        }
        if best[sink].1 == usize::MAX {
            return (units, cost);
        }
        let mut at = sink;
        while at != source {
            let k = best[at].1;
            list[k].2 -= 1;
            list[k ^ 1].2 += 1;
            at = list[k].0;
        }
        units += 1;
        cost += best[sink].0;
    }
}
