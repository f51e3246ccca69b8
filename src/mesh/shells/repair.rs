//! What mending may do, and no more: merge border vertices, drop repeats and what has no area, part sides at corners that lie on them, turn facets
//! over, fill flat holes.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::{Shell, Surface, holes, pairing, shells};
use crate::geom::{Bounds, Vec3};
use crate::mesh::box_tree::BoxTree;

/// Border vertices nearer than this share of the open shells' diagonal are one: it spans the last digits in which
/// exporters disagree, and lies far below a nozzle's width.
const MERGE_WITHIN: f64 = 1e-5;
/// A facet whose height is less than this share of its sides has no area.
const BARE: f64 = 1e-9;
/// A facet may have corners on each of its sides.
const ROUNDS: usize = 4;

/// Mends what it can; whether it sufficed is for the caller to see.
pub(super) fn mend(vertices: &[Vec3], surface: &mut Surface, warnings: &mut Vec<String>) {
    let mut say = |count: usize, text: String| {
        if count > 0 {
            warnings.push(format!("repair: {text}"));
        }
    };
    let (merged, within) = merge_border(vertices, surface);
    say(merged, format!("{merged} border vertices merged with others within {within:.3e} file units"));
    let dropped = drop_repeats(surface) + drop_bare(vertices, surface);
    say(dropped, format!("{dropped} collapsed or repeated facets removed"));
    let parted = part_sides(vertices, surface, within);
    say(parted, format!("{parted} facet edges split at vertices on them"));
    let turned = turn_facets(vertices, surface);
    say(turned, format!("{turned} facets flipped to agree with their neighbours"));
    let (filled, facets) = fill(vertices, surface);
    say(filled, format!("{filled} flat holes filled with {facets} facets"));
}

/// Merges vertices on open edges; returns how many went and the tolerance.
fn merge_border(vertices: &[Vec3], surface: &mut Surface) -> (usize, f64) {
    let shells = shells(vertices, &surface.facets);
    let open = || shells.iter().filter(|shell| !shell.open.is_empty());
    let border: BTreeSet<u32> = open().flat_map(|shell| shell.open.iter().flatten().copied()).collect();
    let corners = open().flat_map(|shell| &shell.facets).flat_map(|&facet| surface.facets[facet as usize]);
    let bounds = Bounds::of(corners.map(|index| vertices[index as usize]));
    if bounds.is_empty() {
        return (0, 0.0);
    }
    let within = bounds.size().norm() * MERGE_WITHIN;
    let to = merge_map(vertices, &border, within);
    for facet in &mut surface.facets {
        *facet = facet.map(|index| to.get(&index).copied().unwrap_or(index));
    }
    (to.len(), within)
}

/// For every vertex that goes, the earlier one that takes its place.
fn merge_map(vertices: &[Vec3], border: &BTreeSet<u32>, within: f64) -> HashMap<u32, u32> {
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut to = HashMap::new();
    for &index in border {
        let at = vertices[index as usize];
        let cell = [0, 1, 2].map(|axis| (at[axis] / within).floor() as i64);
        // What is small and far from the origin lies beyond the last cell.
        let beside = |n: i64| [n % 3, n / 3 % 3, n / 9].map(|step| step - 1);
        let near = (0..27).flat_map(|n| {
            let step = beside(n);
            cells.get(&[0, 1, 2].map(|axis| cell[axis].saturating_add(step[axis])))
        });
        match near.flatten().copied().find(|&other| (vertices[other as usize] - at).norm() <= within) {
            Some(other) => {
                to.insert(index, other);
            }
            None => cells.entry(cell).or_default().push(index),
        }
    }
    to
}

/// Drops facets that name a vertex twice and later copies of a facet of the same sense; returns how many.
fn drop_repeats(surface: &mut Surface) -> usize {
    let given = surface.facets.len();
    let mut seen = HashSet::with_capacity(given);
    surface.retain(|&[a, b, c]| {
        let least = a.min(b).min(c);
        let turned = if least == a {
            [a, b, c]
        } else if least == b {
            [b, c, a]
        } else {
            [c, a, b]
        };
        a != b && b != c && c != a && seen.insert(turned)
    });
    given - surface.facets.len()
}

/// Drops shells that are not closed and whose facets have no area; returns how many facets went. What of a closed shell has no area may be what
/// closes it.
fn drop_bare(vertices: &[Vec3], surface: &mut Surface) -> usize {
    let thin = |&facet: &u32| {
        let [a, b, c] = surface.facets[facet as usize].map(|index| vertices[index as usize]);
        let (u, v) = (b - a, c - a);
        u.cross(&v).norm() <= BARE * (u.norm_squared() + v.norm_squared())
    };
    let bare: HashSet<[u32; 3]> = shells(vertices, &surface.facets)
        .iter()
        .filter(|shell| !shell.open.is_empty() && shell.facets.iter().all(thin))
        .flat_map(|shell| shell.facets.iter().map(|&facet| surface.facets[facet as usize]))
        .collect();
    let given = surface.facets.len();
    surface.retain(|facet| !bare.contains(facet));
    given - surface.facets.len()
}

/// Parts open sides at corners of other open sides that lie on them, as programs leave them that put solids together; returns how many.
fn part_sides(vertices: &[Vec3], surface: &mut Surface, within: f64) -> usize {
    let mut parted = 0;
    for _ in 0..ROUNDS {
        let open: Vec<[u32; 2]> = shells(vertices, &surface.facets).into_iter().flat_map(|shell| shell.open).collect();
        let border: Vec<u32> = open.iter().flatten().copied().collect::<BTreeSet<u32>>().into_iter().collect();
        let points = border.iter().map(|&index| Bounds::of(std::iter::once(vertices[index as usize]))).collect();
        let tree = BoxTree::of_boxes(points);
        let corners_on = |side: [u32; 2]| -> Vec<u32> {
            let [a, b] = side.map(|index| vertices[index as usize]);
            let along = b - a;
            let length = along.norm();
            let mut on: Vec<(f64, u32)> = Vec::new();
            tree.visit(&Bounds::of([a, b]).inflated(within), |place| {
                let at = vertices[border[place] as usize] - a;
                let t = at.dot(&along) / length;
                let beside = (at - along * (t / length)).norm();
                if t > within && t < length - within && beside <= within && !side.contains(&border[place]) {
                    on.push((t, border[place]));
                }
            });
            on.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            on.dedup_by_key(|(_, index)| *index);
            on.into_iter().map(|(_, index)| index).collect()
        };
        let chains: HashMap<[u32; 2], Vec<u32>> =
            open.into_iter().map(|side| (side, corners_on(side))).filter(|(_, on)| !on.is_empty()).collect();
        if chains.is_empty() {
            break;
        }
        let given = std::mem::take(surface);
        for (facet, source) in given.facets.into_iter().zip(given.source) {
            let side = (0..3).find_map(|k| Some((k, chains.get(&[facet[k], facet[(k + 1) % 3]])?)));
            let Some((k, on)) = side.filter(|(k, on)| !on.contains(&facet[(k + 2) % 3])) else {
                surface.facets.push(facet);
                surface.source.push(source);
                continue;
            };
            parted += 1;
            let apex = facet[(k + 2) % 3];
            let stops: Vec<u32> =
                [facet[k]].into_iter().chain(on.iter().copied()).chain([facet[(k + 1) % 3]]).collect();
            for pair in stops.windows(2) {
                surface.facets.push([pair[0], pair[1], apex]);
                surface.source.push(source);
            }
        }
    }
    parted
}

/// Makes each shell agree with its first facet, going from neighbour to neighbour; returns how many were turned over.
///
/// A one-sided surface cannot agree with itself and is left twisted.
fn turn_facets(vertices: &[Vec3], surface: &mut Surface) -> usize {
    let links = pairing::pair_edges(vertices, &surface.facets);
    let mut turned: Vec<Option<bool>> = vec![None; surface.facets.len()];
    for first in 0..surface.facets.len() {
        if turned[first].is_some() {
            continue;
        }
        turned[first] = Some(false);
        let mut queue = vec![(first, false)];
        while let Some((facet, over)) = queue.pop() {
            for link in links[facet].iter().flatten() {
                let next = link.facet as usize;
                if turned[next].is_none() {
                    turned[next] = Some(over != link.twisted);
                    queue.push((next, over != link.twisted));
                }
            }
        }
    }
    let over = |(facet, turned): (&mut [u32; 3], Option<bool>)| {
        let over = turned == Some(true);
        if over {
            facet.swap(1, 2);
        }
        usize::from(over)
    };
    surface.facets.iter_mut().zip(turned).map(over).sum()
}

/// Fills flat simple holes; returns the number of holes and of facets.
fn fill(vertices: &[Vec3], surface: &mut Surface) -> (usize, usize) {
    let (mut filled, mut facets) = (0, 0);
    for shell in shells(vertices, &surface.facets).iter().filter(|shell| !shell.open.is_empty()) {
        for lid in lids(vertices, shell) {
            filled += 1;
            facets += lid.len();
            let source = surface.source[shell.facets[0] as usize];
            surface.source.extend(lid.iter().map(|_| source));
            surface.facets.extend(lid);
        }
    }
    (filled, facets)
}

fn lids(vertices: &[Vec3], shell: &Shell) -> Vec<Vec<[u32; 3]>> {
    holes::loops(&shell.open).iter().filter_map(|border| holes::lid(vertices, border)).collect()
}

#[cfg(test)]
mod tests {
    use super::mend;
    use crate::geom::Vec3;
    use crate::mesh::shells::{Surface, closed_shells};

    fn tetra() -> (Vec<Vec3>, Surface) {
        let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let facets = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        (vertices, Surface { facets, source: vec![0, 1, 2, 3] })
    }

    fn mended(vertices: &[Vec3], surface: Surface) -> (Result<usize, String>, Vec<String>) {
        let mut warnings = Vec::new();
        let shells = closed_shells(vertices, surface, true, &mut warnings);
        (shells.map(|shells| shells.len()).map_err(|(_, fault)| fault.to_string()), warnings)
    }

    #[test]
    fn fills_a_flat_hole() {
        let (vertices, mut surface) = tetra();
        surface.facets.pop();
        surface.source.pop();
        mend(&vertices, &mut surface, &mut Vec::new());
        assert_eq!(surface.facets.len(), 4);
        let mut lid = surface.facets[3];
        let least = lid.iter().position(|&i| i == 1).unwrap();
        lid.rotate_left(least);
        assert_eq!(lid, [1, 2, 3], "facing outward");
    }

    #[test]
    fn merges_border_vertices_within_the_tolerance_only() {
        let (mut vertices, mut surface) = tetra();
        vertices.push(Vec3::new(1.0, 1e-6, 0.0));
        surface.facets[3] = [4, 2, 3];
        let (shells, warnings) = mended(&vertices, surface.clone());
        assert_eq!(shells, Ok(1));
        let [warning] = &warnings[..] else { panic!("{warnings:?}") };
        assert!(
            warning.starts_with("repair: 1 ") && warning.contains("merged") && warning.contains("1.732e-5"),
            "{warning}"
        );
        vertices[4].y = 2.5e-5;
        let (_, warnings) = mended(&vertices, surface.clone());
        assert_eq!(warnings.iter().filter(|text| text.contains("merged")).count(), 0, "in the next cell, but too far");
        vertices[4].y = 1e-2;
        assert!(mended(&vertices, surface).0.is_err());
    }

    #[test]
    fn drops_repeats_and_turns_facets_over() {
        let (vertices, mut surface) = tetra();
        surface.facets.push([2, 3, 1]);
        surface.source.push(4);
        assert_eq!(
            mended(&vertices, surface.clone()),
            (Ok(1), vec!["repair: 1 collapsed or repeated facets removed".to_owned()])
        );
        surface.facets.pop();
        surface.source.pop();
        surface.facets[2].swap(0, 1);
        let wanted = "repair: 1 facets flipped to agree with their neighbours".to_owned();
        assert_eq!(mended(&vertices, surface), (Ok(1), vec![wanted]));
    }

    #[test]
    fn sides_are_parted_at_corners_that_lie_on_them() {
        // A cube whose top is cut into `n` strips, each by its own corners, which its walls and its bottom know nothing of.
        for n in [2_u32, 3, 7, 40] {
            let corner = |k: u32| Vec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)) * 10.0;
            let mut vertices: Vec<Vec3> = (0..8).map(corner).collect();
            let walls = [[0, 2, 3, 1], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
            let mut facets: Vec<[u32; 3]> =
                walls.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
            let inner = |k: u32, y: f64| Vec3::new(10.0 * f64::from(k) / f64::from(n), y, 10.0);
            let mut line = |k: u32| match k {
                0 => [4, 6],
                k if k == n => [5, 7],
                k => {
                    vertices.extend([inner(k, 0.0), inner(k, 10.0)]);
                    [vertices.len() as u32 - 2, vertices.len() as u32 - 1]
                }
            };
            let lines: Vec<[u32; 2]> = (0..=n).map(&mut line).collect();
            facets.extend(lines.windows(2).flat_map(|two| {
                let [[a, d], [b, c]] = [two[0], two[1]];
                [[a, b, c], [a, c, d]]
            }));
            let surface = Surface { source: vec![0; facets.len()], facets };
            let (closed, said) = mended(&vertices, surface);
            assert_eq!(closed, Ok(1), "{n}: {said:?}");
            assert!(said.iter().any(|text| text.starts_with("repair: ") && text.contains(" split ")), "{said:?}");
        }
    }

    #[test]
    fn what_has_no_area_beside_a_solid_goes() {
        let (mut vertices, mut surface) = tetra();
        vertices.push(Vec3::new(0.5, 0.0, 0.0));
        surface.facets.push([0, 4, 1]);
        surface.source.push(4);
        let (closed, said) = mended(&vertices, surface);
        assert_eq!((closed, said), (Ok(1), vec!["repair: 1 collapsed or repeated facets removed".to_owned()]));
    }

    #[test]
    fn a_hole_that_is_not_flat_is_refused() {
        let at = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]];
        let mut vertices: Vec<Vec3> = at.iter().map(|p| Vec3::from(p.map(f64::from))).collect();
        let facets = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        let surface = Surface { source: vec![0; 4], facets };
        assert_eq!(mended(&vertices, surface.clone()).0, Ok(1));
        vertices[2].z = 0.1;
        let error = mended(&vertices, surface).0.unwrap_err();
        assert!(error.starts_with("4 open edges") && !error.contains("--no-repair"), "{error}");
    }
}
