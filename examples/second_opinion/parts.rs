//! The model: facets of an STL, its closed shells, the parts on the table, and the faces that parts share. Makes the check of parts.

use super::certificate::Plan;
use super::maths::{Facet, V, add, bounds, cross, dot, lerp, normal, scale, sub, unit};
use super::opinion::Check;
use std::array::from_fn;
use std::collections::{BTreeMap, HashMap};

pub type Mesh = Vec<Facet>;
/// Polygons in which two parts touch, by the parts' numbers.
pub type Shared = BTreeMap<[usize; 2], Vec<Vec<V>>>;

/// Facets of an STL, binary or ASCII; none where it is not one.
fn stl(bytes: &[u8]) -> Option<Mesh> {
    let count = u32::from_le_bytes(bytes.get(80..84).unwrap_or(&[0; 4]).try_into().ok()?) as usize;
    let mut corners = Vec::<V>::new();
    if count > 0 && bytes.len() == 84 + 50 * count {
        let single = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let corner = |b: &[u8]| [single(b), single(&b[4..]), single(&b[8..])];
        corners.extend(bytes[84..].chunks(50).flat_map(|facet| facet[12..48].chunks(12)).map(corner));
    } else {
        let text = std::str::from_utf8(bytes).ok()?.trim_start();
        let mut words = text.starts_with("solid").then(|| text.split_whitespace())?;
        while words.any(|word| word == "vertex") {
            let mut coordinate = || words.next()?.parse::<f64>().ok();
            corners.push([coordinate()?, coordinate()?, coordinate()?]);
        }
    }
    let whole = !corners.is_empty() && corners.len().is_multiple_of(3);
    whole.then(|| corners.chunks(3).map(|c| [c[0], c[1], c[2]]).collect())
}

/// Six times the volume of a closed mesh is the sum of its facets' determinants.
pub fn volume(mesh: &[Facet]) -> f64 {
    mesh.iter().map(|[a, b, c]| dot(*a, cross(*b, *c)) / 6.0).sum()
}

fn bits(p: V) -> [u64; 3] {
    p.map(|x| (x + 0.0).to_bits())
}

/// Closed shells. In the order of the file where each is closed before the next begins, else what shares corners.
fn shells(facets: &[Facet]) -> Vec<Mesh> {
    let (mut open, mut found, mut now) = (HashMap::new(), Vec::new(), Vec::new());
    for facet in facets {
        now.push(*facet);
        for i in 0..3 {
            let (a, b) = (bits(facet[i]), bits(facet[(i + 1) % 3]));
            let (edge, by) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
            let count = open.entry(edge).or_insert(0);
            *count += by;
            if *count == 0 {
                open.remove(&edge);
            }
        }
        if open.is_empty() {
            found.push(std::mem::take(&mut now));
        }
    }
    if now.is_empty() { found } else { joined(facets) }
}

/// Facets that share corners, in the order of their first one.
fn joined(facets: &[Facet]) -> Vec<Mesh> {
    fn root(of: &mut [usize], mut i: usize) -> usize {
        while of[i] != i {
            of[i] = of[of[i]];
            i = of[i];
        }
        i
    }
    let (mut of, mut corners) = ((0..facets.len()).collect::<Vec<usize>>(), HashMap::new());
    for (index, facet) in facets.iter().enumerate() {
        for p in facet {
            let [a, b] = [root(&mut of, index), *corners.entry(bits(*p)).or_insert(index)];
            let b = root(&mut of, b);
            of[a.max(b)] = a.min(b);
        }
    }
    let mut found = BTreeMap::<usize, Mesh>::new();
    for (index, facet) in facets.iter().enumerate() {
        found.entry(root(&mut of, index)).or_default().push(*facet);
    }
    found.into_values().collect()
}

/// The model's parts on the table, by the plan's numbers: a shell turned inside out is a hollow of the part before it. None where they
/// are not known, or are not the plan's.
pub fn parts_of(plan: &Plan, model: Option<&[u8]>) -> (Check, Option<Vec<Mesh>>) {
    let Some(model) = model else { return (Check::without("parts", "no model was given"), None) };
    let Some(facets) = stl(model) else { return (Check::without("parts", "the model is not an STL"), None) };
    let (sin, cos) = plan.turn.to_radians().sin_cos();
    let place = |p: V| {
        let [x, y, z] = scale(p, plan.unit);
        add([cos * x - sin * y, sin * x + cos * y, z], plan.origin)
    };
    let (mut check, mut parts) = (Check::new("parts"), Vec::<Mesh>::new());
    for shell in shells(&facets) {
        let shell: Mesh = shell.into_iter().map(|facet| facet.map(place)).collect();
        match parts.last_mut() {
            Some(part) if volume(&shell) < 0.0 => part.extend(shell),
            _ => parts.push(shell),
        }
    }
    check.figure = format!("{} closed shells, {} parts in the plan", parts.len(), plan.parts);
    if parts.len() != plan.parts {
        check.fail("shells and parts differ: nothing can be compared with the model");
        return (check, None);
    }
    let printed: Vec<usize> = plan.prints.iter().map(|print| print.part).collect();
    for part in (0..parts.len()).filter(|part| !printed.contains(part)) {
        check.fail(format!("the plan does not print part {part}"));
    }
    for part in printed.iter().filter(|part| **part >= parts.len()) {
        check.fail(format!("the plan prints part {part}, which the model does not have"));
    }
    (check, Some(parts))
}

/// Polygons in which facets of two parts lie on each other.
pub fn shared_faces(parts: &[Mesh]) -> Shared {
    let boxes: Vec<[V; 2]> = parts.iter().map(|part| bounds(part.iter().copied().flatten())).collect();
    let mut shared = BTreeMap::new();
    for (a, b) in (0..parts.len()).flat_map(|a| (a + 1..parts.len()).map(move |b| (a, b))) {
        let low: V = from_fn(|i| boxes[a][0][i].max(boxes[b][0][i]) - 0.02);
        let high: V = from_fn(|i| boxes[a][1][i].min(boxes[b][1][i]) + 0.02);
        let meets = |facet: &&Facet| {
            (0..3).all(|i| facet.iter().any(|p| p[i] >= low[i]) && facet.iter().any(|p| p[i] <= high[i]))
        };
        let near: Vec<&Facet> = parts[b].iter().filter(meets).collect();
        let pairs = parts[a].iter().filter(meets).flat_map(|facet| near.iter().map(move |other| (facet, other)));
        let faces: Vec<Vec<V>> = pairs.filter_map(|(facet, other)| overlap(facet, other)).collect();
        if !faces.is_empty() {
            shared.insert([a, b], faces);
        }
    }
    shared
}

/// The polygon that two facets share whose normals are opposite.
fn overlap(a: &Facet, b: &Facet) -> Option<Vec<V>> {
    let [n, m] = [a, b].map(|facet| unit(normal(*facet)));
    if dot(n, m) > -0.9999 || b.iter().any(|p| dot(sub(*p, a[0]), n).abs() > 0.02) {
        return None;
    }
    let mut ring = b.to_vec();
    for i in 0..3 {
        let inward = cross(n, unit(sub(a[(i + 1) % 3], a[i])));
        let side = |p: V| dot(sub(p, a[i]), inward);
        let mut kept = Vec::new();
        for (k, &p) in ring.iter().enumerate() {
            let q = ring[(k + 1) % ring.len()];
            if side(p) >= 0.0 {
                kept.push(p);
            }
            if (side(p) >= 0.0) != (side(q) >= 0.0) {
                kept.push(lerp(p, q, side(p) / (side(p) - side(q))));
            }
        }
        ring = kept;
    }
    let area: f64 = (2..ring.len()).map(|i| dot(normal([ring[0], ring[i - 1], ring[i]]), m) / 2.0).sum();
    (ring.len() > 2 && area > 1e-3).then_some(ring)
}
