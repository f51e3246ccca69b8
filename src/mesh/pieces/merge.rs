//! The cheapest merge first: a heap whose entries are looked at again when they come up.
//!
//! Shape is exact at once; the concavity of two groups together is at least that of either, and is worked out only where an entry comes to
//! the top on that bound. So of all pairs that ever border on each other few are asked for their hull, and the order of merges is the
//! one that full costs give.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::cluster::{Border, Cluster, Ground, shape};
use crate::mesh::TriangleMesh;
use crate::mesh::shells::pair_edges;

/// A point nearer than this to a hull's face is on it, of the mesh's size.
const SLACK: f64 = 1e-6;

/// A merge to come: its cost or what is the least of it, and the groups' numbers. Numbers are never given twice, so an entry of a group
/// that is no more is known by them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    /// The bits of a cost, which is never negative: they are in the order of the numbers.
    cost: u64,
    pair: [u32; 2],
    /// The bits of the concavity; those of infinity, the last of equals, as long as it is not worked out.
    concavity: u64,
}

impl Entry {
    /// The concavity, once it is worked out.
    fn known(&self) -> Option<f64> {
        Some(f64::from_bits(self.concavity)).filter(|concavity| concavity.is_finite())
    }
}

/// What a merge costs.
struct Rates {
    /// The diagonal of the mesh's box, mm.
    diagonal: f64,
    /// What shape counts.
    alpha: f64,
}

impl Rates {
    fn entry(&self, pair: [u32; 2], [a, b]: [&Cluster; 2], length: f64, known: Option<f64>) -> Entry {
        let concavity = known.unwrap_or_else(|| a.concavity.max(b.concavity));
        let cost = concavity / self.diagonal + self.alpha * shape(a, b, length);
        Entry { cost: cost.to_bits(), pair, concavity: known.unwrap_or(f64::INFINITY).to_bits() }
    }
}

/// Groups of facets with the concavity of each, in the order of their first facets.
pub(super) fn groups<F>(mesh: &TriangleMesh<F>, most: f64) -> Vec<(Vec<u32>, f64)> {
    if mesh.facets().is_empty() {
        return Vec::new();
    }
    let diagonal = mesh.bounds().size().norm().max(f64::MIN_POSITIVE);
    let ground = Ground::of(mesh, diagonal * SLACK);
    let rates = Rates { diagonal, alpha: most / (10.0 * diagonal) };
    // Flat to rounding is convex: without that a plane's facets would part where nothing at all is allowed.
    let most = most.max(diagonal * SLACK);
    let links = pair_edges(mesh.vertices(), mesh.facets());
    let across = |f: usize| links[f].map(|link| link.map(|l| l.facet));
    let mut clusters: Vec<Option<Cluster>> =
        (0..links.len()).map(|f| Some(ground.single(f as u32, across(f)))).collect();
    let mut heap = BinaryHeap::new();
    for (number, cluster) in clusters.iter().enumerate() {
        push_all(&rates, &clusters, number as u32, cluster.as_ref(), &mut heap, |other| other > number as u32);
    }
    while let Some(Reverse(entry)) = heap.pop() {
        let [i, j] = entry.pair.map(|i| i as usize);
        let (Some(a), Some(b)) = (&clusters[i], &clusters[j]) else { continue };
        let length = a.borders[&entry.pair[1]].length;
        let Some(concavity) = entry.known() else {
            let found = ground.concavity(a, b, most);
            if found.is_some() {
                heap.push(Reverse(rates.entry(entry.pair, [a, b], length, found)));
            } else {
                close(&mut clusters, entry.pair);
            }
            continue;
        };
        let joined = ground.joined(a, b, length, concavity);
        replace(&mut clusters, entry.pair, joined);
        let number = clusters.len() as u32 - 1;
        push_all(&rates, &clusters, number, clusters[number as usize].as_ref(), &mut heap, |_| true);
    }
    let mut groups: Vec<(Vec<u32>, f64)> =
        clusters.into_iter().flatten().map(|c| (sorted(c.facets), c.concavity)).collect();
    groups.sort_by_key(|(facets, _)| facets[0]);
    groups
}

fn sorted(mut facets: Vec<u32>) -> Vec<u32> {
    facets.sort_unstable();
    facets
}

/// Entries of a group with those of its neighbours that are `wanted`.
fn push_all(
    rates: &Rates,
    clusters: &[Option<Cluster>],
    number: u32,
    cluster: Option<&Cluster>,
    heap: &mut BinaryHeap<Reverse<Entry>>,
    wanted: impl Fn(u32) -> bool,
) {
    let Some(cluster) = cluster else { return };
    for (&other, border) in cluster.borders.iter().filter(|(other, border)| !border.closed && wanted(**other)) {
        if let Some(beside) = &clusters[other as usize] {
            let pair = [number.min(other), number.max(other)];
            let both = if number < other { [cluster, beside] } else { [beside, cluster] };
            heap.push(Reverse(rates.entry(pair, both, border.length, None)));
        }
    }
}

/// The two will never be joined.
fn close(clusters: &mut [Option<Cluster>], [i, j]: [u32; 2]) {
    for (own, other) in [(i, j), (j, i)] {
        if let Some(border) = clusters[own as usize].as_mut().and_then(|c| c.borders.get_mut(&other)) {
            border.closed = true;
        }
    }
}

/// Puts the group that two became in their place, at the end, and tells their neighbours.
fn replace(clusters: &mut Vec<Option<Cluster>>, pair: [u32; 2], mut joined: Cluster) {
    let number = clusters.len() as u32;
    for own in pair {
        let Some(gone) = clusters[own as usize].take() else { continue };
        for (other, border) in gone.borders.into_iter().filter(|(other, _)| !pair.contains(other)) {
            let sum = joined.borders.entry(other).or_insert(Border { length: 0.0, closed: false });
            *sum = Border { length: sum.length + border.length, closed: sum.closed || border.closed };
            if let Some(beside) = &mut clusters[other as usize] {
                beside.borders.remove(&own);
                beside.borders.insert(number, *sum);
            }
        }
    }
    clusters.push(Some(joined));
}
