//! What mending may do, and no more: merge border vertices, drop repeats and what has no area, part sides at corners that lie on them, join corners a
//! little apart, drop what encloses nothing, turn facets over, fill holes.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::cracks::Joined;
use super::lids::Filled;
use super::sides::part_sides;
use super::{Surface, cracks, lids, open_edges, pairing, sheets, shells};
use crate::geom::{Bounds, Vec3};
use crate::mesh::error::Places;
use crate::spelling::counted;

/// Border vertices nearer than this share of the open shells' diagonal are one: it spans the last digits in which
/// exporters disagree, and lies far below a nozzle's width.
const MERGE_WITHIN: f64 = 1e-5;
/// A facet whose height is less than this share of its sides has no area.
const BARE: f64 = 1e-9;

/// Mends what it can; whether it sufficed is for the caller to see. `sound` is what of the same body is closed already; corners up to `most` file
/// units apart may be joined.
pub(super) fn mend(
    vertices: &mut Vec<Vec3>,
    surface: &mut Surface,
    sound: &[Surface],
    most: f64,
    warnings: &mut Vec<String>,
) {
    let mut said = Said::default();
    let (merged, within) = merge_border(vertices, surface);
    said.add(merged, || format!("{merged} border vertices merged with others within {within:.3e} file units"));
    let dropped = drop_repeats(surface) + drop_bare(vertices, surface) + sheets::drop_opposites(surface, sound);
    said.add(dropped, || repeats(dropped));

    // As the corners are; and joined, from before sides were parted: a side is no longer than the crack where it was parted beside one.
    let mut as_they_are = (surface.clone(), said.clone());
    let parted = part_sides(vertices, &mut as_they_are.0, within);
    as_they_are.1.add(parted, || sides_parted(parted));
    let mut tries = vec![as_they_are];
    if !open_edges(vertices, &tries[0].0.facets).is_empty() {
        let mut joined = (std::mem::take(surface), said);
        if let Some(found) = cracks::join(vertices, &mut joined.0, within, most) {
            let Joined { corners, distance, at, parted, .. } = found;
            let near = Places::of([at]);
            joined.1.add(corners, || {
                format!("{corners} corners moved by up to {distance:.2e} file units to join them, most near {near}")
            });
            joined.1.add(parted, || sides_parted(parted));
            tries.insert(if found.left == 0 { 0 } else { 1 }, joined);
        }
    }
    let mut best: Option<(usize, Surface, Said)> = None;
    for (mut tried, mut said) in tries {
        finish(vertices, &mut tried, sound, most, &mut said);
        let left = shells(vertices, &tried.facets).iter().map(|shell| shell.open.len() + shell.twisted).sum();
        if best.as_ref().is_none_or(|best| left < best.0) {
            best = Some((left, tried, said));
        }
        if left == 0 {
            break;
        }
    }
    if let Some((_, mended, said)) = best {
        *surface = mended;
        warnings.extend(said.0.into_iter().map(|text| format!("repair: {text}")));
    }
}

/// What was mended, each thing that was done at all.
#[derive(Clone, Default)]
struct Said(Vec<String>);

impl Said {
    fn add(&mut self, count: usize, text: impl Fn() -> String) {
        self.0.extend((count > 0).then(text));
    }
}

/// What mending does where the corners are as they are to stay.
fn finish(vertices: &[Vec3], surface: &mut Surface, sound: &[Surface], most: f64, said: &mut Said) {
    let hanging = sheets::drop_hanging(vertices, surface, sound);
    said.add(hanging.facets, || {
        format!("{} removed, since they enclose nothing, near {}", counted(hanging.facets, "facet"), hanging.places)
    });
    let turned = turn_facets(vertices, surface);
    said.add(turned, || format!("{} flipped to agree with their neighbours", counted(turned, "facet")));
    let loose = sheets::drop_sheets(vertices, surface, sound, most);
    said.add(loose.facets, || {
        format!("{} removed, since they enclose nothing, near {}", counted(loose.facets, "loose facet"), loose.places)
    });
    let Filled { holes, facets, places } = lids::fill(vertices, surface, most);
    said.add(holes, || format!("{} filled with {}, near {places}", counted(holes, "hole"), counted(facets, "facet")));
}

fn repeats(dropped: usize) -> String {
    format!("{dropped} collapsed or repeated facets removed")
}

/// The warning about facets that were in the file twice.
pub(super) fn repeats_dropped(dropped: usize) -> String {
    format!("repair: {}", repeats(dropped))
}

fn sides_parted(parted: usize) -> String {
    format!("{parted} facet edges split at vertices on them")
}

/// Whether a facet may be there twice in the same sense; it is seldom said of what has none.
pub(super) fn has_repeats(facets: &[[u32; 3]]) -> bool {
    let mix = |word: u64| (word ^ word >> 31).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    let key = |&facet: &[u32; 3]| rotated(facet).iter().fold(0, |key, &corner| mix(key ^ u64::from(corner)));
    let mut keys: Vec<u64> = facets.iter().map(key).collect();
    keys.sort_unstable();
    keys.windows(2).any(|two| two[0] == two[1])
}

/// The same facet from its least corner on.
fn rotated([a, b, c]: [u32; 3]) -> [u32; 3] {
    let least = a.min(b).min(c);
    if least == a {
        [a, b, c]
    } else if least == b {
        [b, c, a]
    } else {
        [c, a, b]
    }
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
pub(super) fn drop_repeats(surface: &mut Surface) -> usize {
    let given = surface.facets.len();
    let mut seen = HashSet::with_capacity(given);
    surface.retain(|&[a, b, c]| a != b && b != c && c != a && seen.insert(rotated([a, b, c])));
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

#[cfg(test)]
mod tests {
    use super::mend;
    use crate::geom::Vec3;
    use crate::mesh::shells::{Surface, mended_shells};

    fn tetra() -> (Vec<Vec3>, Surface) {
        let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let facets = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        (vertices, Surface { facets, source: vec![0, 1, 2, 3] })
    }

    fn mended(vertices: &[Vec3], surface: Surface) -> (Result<usize, String>, Vec<String>) {
        let (mut vertices, mut warnings) = (vertices.to_vec(), Vec::new());
        let shells = mended_shells(&mut vertices, &surface.facets, 0, 1e-3, &mut warnings);
        (shells.map(|shells| shells.len()).map_err(|(_, fault)| fault.to_string()), warnings)
    }

    #[test]
    fn fills_a_flat_hole() {
        let (mut vertices, mut surface) = tetra();
        surface.facets.pop();
        surface.source.pop();
        mend(&mut vertices, &mut surface, &[], 1e-3, &mut Vec::new());
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
        let wanted = "repair: 1 facet flipped to agree with their neighbours".to_owned();
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
        assert!(error.starts_with("4 open edges") && !error.contains("--repair off"), "{error}");
    }
}
