//! Shells: facets joined across paired edges, each closed and consistently wound or refused.

mod cracks;
mod holes;
mod lids;
mod pairing;
mod repair;
mod sheets;
mod sides;

use std::ops::Range;

use hashbrown::HashMap;

use super::error::{Fault, Places};
use crate::geom::Vec3;
use pairing::EdgeLink;
pub(super) use pairing::pair_edges;

/// Facets under work, each with the facet of the file that it stems from.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    pub(super) facets: Vec<[u32; 3]>,
    pub(super) source: Vec<u32>,
}

impl Surface {
    /// A stretch of a body whose first facet is the file's facet `first`.
    fn of(facets: &[[u32; 3]], run: Range<usize>, first: u32) -> Self {
        let source = run.clone().map(|index| first + index as u32).collect();
        Self { facets: facets[run].to_vec(), source }
    }

    /// The facets at `indices`, in that order.
    fn select(&self, indices: &[u32]) -> Self {
        let pick = |&index: &u32| (self.facets[index as usize], self.source[index as usize]);
        let (facets, source) = indices.iter().map(pick).unzip();
        Self { facets, source }
    }

    /// Keeps the facets that `keep` says yes to.
    fn retain(&mut self, mut keep: impl FnMut(&[u32; 3]) -> bool) {
        let mut kept = (0..self.facets.len() as u32).collect::<Vec<_>>();
        kept.retain(|&index| keep(&self.facets[index as usize]));
        *self = self.select(&kept);
    }

    /// Turns every facet over.
    pub(super) fn turn_over(&mut self) {
        self.facets.iter_mut().for_each(|facet| facet.swap(1, 2));
    }
}

/// One connected piece of a surface.
struct Shell {
    /// Indices into the surface, ascending.
    facets: Vec<u32>,
    /// Edges with a facet on one side only, in that facet's sense.
    open: Vec<[u32; 2]>,
    /// Edges whose two facets run along them in the same sense.
    twisted: usize,
}

impl Shell {
    fn is_sound(&self) -> bool {
        self.open.is_empty() && self.twisted == 0
    }
}

/// The closed shells of a body, whose facets follow each other from the file's facet `first` on, in the order of their first facets. Nothing is mended.
///
/// # Errors
///
/// The number of the first unsound shell and its fault.
pub(super) fn closed_shells(
    vertices: &[Vec3],
    facets: &[[u32; 3]],
    first: u32,
) -> Result<Vec<Surface>, (usize, Fault)> {
    const REMEDY: &str = "leave out --repair off";
    let mut found = Vec::new();
    for run in closed_runs(facets) {
        let surface = Surface::of(facets, run, first);
        let shells = shells(vertices, &surface.facets);
        if let Some(number) = shells.iter().position(|shell| !shell.is_sound())
            && let Some((_, fault)) = fault(vertices, &surface, &shells[number..=number], REMEDY)
        {
            return Err((found.len() + number, fault));
        }
        found.extend(shells.iter().map(|shell| surface.select(&shell.facets)));
    }
    Ok(found)
}

/// As [`closed_shells`], of what is mended first where it is not closed, with corners joined that are up to `most` file units apart. New
/// vertices are appended to `vertices`.
///
/// # Errors
///
/// The file's facet at which the first of all that could not be mended lies, and the fault.
pub(super) fn mended_shells(
    vertices: &mut Vec<Vec3>,
    facets: &[[u32; 3]],
    first: u32,
    most: f64,
    warnings: &mut Vec<String>,
) -> Result<Vec<Surface>, (u32, Fault)> {
    const REMEDY: &str = "repair it in the program that made it (the automatic repair failed)";
    let (mut sound, mut broken) = sorted(vertices, facets, |index| first + index as u32);
    if repair::has_repeats(facets) {
        // The same facets once more, in whatever order: one copy is the solid where it closes by itself.
        let mut once = Surface::of(facets, 0..facets.len(), first);
        let dropped = repair::drop_repeats(&mut once);
        let (closed, open) = sorted(vertices, &once.facets, |index| once.source[index]);
        if open.facets.is_empty() || !broken.facets.is_empty() {
            (sound, broken) = (closed, open);
            warnings.push(repair::repeats_dropped(dropped));
        }
    }
    if broken.facets.is_empty() {
        return Ok(sound);
    }
    repair::mend(vertices, &mut broken, &sound, most, warnings);
    let shells = shells(vertices, &broken.facets);
    if let Some(fault) = fault(vertices, &broken, &shells, REMEDY) {
        return Err(fault);
    }
    sound.extend(shells.iter().map(|shell| broken.select(&shell.facets)));
    Ok(sound)
}

/// Closed shells, and the facets of all stretches that are not made of such.
fn sorted(vertices: &[Vec3], facets: &[[u32; 3]], source: impl Fn(usize) -> u32) -> (Vec<Surface>, Surface) {
    let (mut sound, mut broken) = (Vec::new(), Surface::default());
    for run in closed_runs(facets) {
        let surface = Surface { facets: facets[run.clone()].to_vec(), source: run.map(&source).collect() };
        let shells = shells(vertices, &surface.facets);
        if shells.iter().all(Shell::is_sound) {
            sound.extend(shells.iter().map(|shell| surface.select(&shell.facets)));
        } else {
            broken.facets.extend(surface.facets);
            broken.source.extend(surface.source);
        }
    }
    (sound, broken)
}

/// What is wrong with shells, with every place; `None` where all are sound.
fn fault(vertices: &[Vec3], surface: &Surface, shells: &[Shell], remedy: &'static str) -> Option<(u32, Fault)> {
    let first = shells.iter().find(|shell| !shell.is_sound()).and_then(|shell| shell.facets.first())?;
    let open: Vec<[u32; 2]> = shells.iter().flat_map(|shell| shell.open.iter().copied()).collect();
    let fault = if open.is_empty() {
        Fault::Winding { edges: shells.iter().map(|shell| shell.twisted).sum(), remedy }
    } else {
        let at = Places::of(holes::borders(&open).iter().map(|border| holes::middle(vertices, border)));
        Fault::Open { edges: open.len(), at, remedy }
    };
    Some((surface.source[*first as usize], fault))
}

/// The connected pieces, in the order of their first facets.
fn shells(vertices: &[Vec3], facets: &[[u32; 3]]) -> Vec<Shell> {
    let links = pairing::pair_edges(vertices, facets);
    let mut shell_of = vec![u32::MAX; facets.len()];
    let mut shells = Vec::new();
    for first in 0..facets.len() as u32 {
        if shell_of[first as usize] == u32::MAX {
            shells.push(flood(first, shells.len() as u32, facets, &links, &mut shell_of));
        }
    }
    shells
}

/// Sides with a facet on one side only.
fn open_edges(vertices: &[Vec3], facets: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let links = pairing::pair_edges(vertices, facets);
    let sides = facets.iter().zip(&links).flat_map(|(facet, links)| {
        (0..3).filter(|&side| links[side].is_none()).map(|side| [facet[side], facet[(side + 1) % 3]])
    });
    sides.collect()
}

fn flood(first: u32, number: u32, facets: &[[u32; 3]], links: &[[Option<EdgeLink>; 3]], shell_of: &mut [u32]) -> Shell {
    let mut shell = Shell { facets: vec![first], open: Vec::new(), twisted: 0 };
    shell_of[first as usize] = number;
    let mut next = 0;
    while let Some(&facet) = shell.facets.get(next) {
        next += 1;
        for link in links[facet as usize].iter().flatten() {
            // Each twisted edge is met from both sides and counted from the lower one.
            shell.twisted += usize::from(link.twisted && facet < link.facet);
            if shell_of[link.facet as usize] == u32::MAX {
                shell_of[link.facet as usize] = number;
                shell.facets.push(link.facet);
            }
        }
    }
    shell.facets.sort_unstable();
    for &facet in &shell.facets {
        let corners = facets[facet as usize];
        let sides = (0..3).filter(|&side| links[facet as usize][side].is_none());
        shell.open.extend(sides.map(|side| [corners[side], corners[(side + 1) % 3]]));
    }
    shell
}

/// The shortest stretches of facets in file order that are closed in themselves; the last may be open.
///
/// Most writers give one solid after the other. Where a stretch closes, no edge of it can belong to what follows, so
/// solids that share edges or whole faces with others are told apart before any angle is looked at.
pub(super) fn closed_runs(facets: &[[u32; 3]]) -> Vec<Range<usize>> {
    /// A tetrahedron: fewer facets enclose nothing.
    const LEAST: usize = 4;
    let mut balance: HashMap<(u32, u32), i32> = HashMap::with_capacity(facets.len());
    let (mut unbalanced, mut start, mut runs) = (0_usize, 0, Vec::new());
    for (index, facet) in facets.iter().enumerate() {
        for side in 0..3 {
            let (a, b) = (facet[side], facet[(side + 1) % 3]);
            let uses = balance.entry((a.min(b), a.max(b))).or_insert(0);
            let before = *uses;
            *uses += if a < b { 1 } else { -1 };
            unbalanced = unbalanced + usize::from(before == 0) - usize::from(*uses == 0);
        }
        if unbalanced == 0 && index + 1 - start >= LEAST {
            runs.push(start..index + 1);
            // Every balance is 0 now, which is as good as absent; clearing the table for each run would cost its size.
            start = index + 1;
        }
    }
    if start < facets.len() {
        runs.push(start..facets.len());
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::{closed_runs, closed_shells};
    use crate::geom::Vec3;
    use crate::mesh::error::{Fault, Places};

    const TETRA: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

    fn corner() -> Vec<Vec3> {
        vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()]
    }

    #[test]
    fn runs_end_where_the_surface_closes() {
        let mut facets = TETRA.to_vec();
        facets.extend(TETRA.map(|f| f.map(|i| i + 1)));
        assert_eq!(closed_runs(&facets), [0..4, 4..8]);
        assert_eq!(closed_runs(&facets[..7]), [0..4, 4..7]);
        facets.swap(3, 4);
        assert_eq!(closed_runs(&facets), vec![0..8], "interleaved solids are left to the angles");
    }

    #[test]
    fn a_missing_facet_leaves_three_open_edges() {
        let (shell, fault) = closed_shells(&corner(), &TETRA[..3], 0).unwrap_err();
        assert_eq!(shell, 0);
        let at = Places::of([Vec3::repeat(1.0 / 3.0)]);
        assert_eq!(fault, Fault::Open { edges: 3, at, remedy: "leave out --repair off" });
    }

    #[test]
    fn a_facet_turned_over_leaves_three_twisted_edges() {
        let mut facets = TETRA;
        facets[1].swap(0, 1);
        let (_, fault) = closed_shells(&corner(), &facets, 0).unwrap_err();
        assert_eq!(fault, Fault::Winding { edges: 3, remedy: "leave out --repair off" });
    }
}
