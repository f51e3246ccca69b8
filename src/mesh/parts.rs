//! From closed shells to parts: outer shells, the cavities in them, and which way they face.

use super::error::{Fault, Located, Place};
use super::shells::{Surface, closed_runs, closed_shells};
use super::soup::Soup;
use super::winding::winding;
use crate::geom::{Bounds, Vec3};

/// The least volume of a part, as a share of its diagonal cubed: below it a surface is folded flat onto itself, and
/// the volume is but rounding.
const LEAST_VOLUME: f64 = 1e-9;

/// One closed shell.
struct Shell {
    surface: Surface,
    /// File units cubed; negative where the facets face inward.
    volume: f64,
    bounds: Bounds,
}

/// The parts of a welded soup, in the order of their first facets; cavities are with their parts, and all face out of
/// the material. Warnings go to `soup.warnings`.
pub(super) fn parts(soup: &mut Soup, repair: bool) -> Result<Vec<Surface>, Located> {
    let body = |index: usize| soup.names[soup.labels[index] as usize].body;
    let indices: Vec<usize> = (0..soup.facets.len()).collect();
    let bodies: Vec<_> = indices.chunk_by(|&a, &b| body(a) == body(b)).map(|run| run[0]..run[0] + run.len()).collect();
    let mut warnings = Vec::new();
    let (mut found, mut parts) = (0, Vec::new());
    for body in bodies {
        let mut shells = Vec::new();
        for run in closed_runs(&soup.facets[body.clone()]) {
            let run = body.start + run.start..body.start + run.end;
            let surface = Surface {
                facets: soup.facets[run.clone()].to_vec(),
                source: (run.start as u32..run.end as u32).collect(),
            };
            let closed = closed_shells(&soup.vertices, surface, repair, &mut warnings);
            let closed = closed.map_err(|(index, fault)| fault.at(Place::Part(found + index)))?;
            for surface in closed {
                shells.push(measure(&soup.vertices, surface).map_err(|fault| fault.at(Place::Part(found)))?);
                found += 1;
            }
        }
        parts.extend(nest(&soup.vertices, shells, &mut warnings));
    }
    parts.sort_by_key(|part: &Surface| part.source[0]);
    soup.warnings.append(&mut warnings);
    Ok(parts)
}

fn measure(vertices: &[Vec3], surface: Surface) -> Result<Shell, Fault> {
    let corners = surface.facets.iter().flatten().map(|&index| vertices[index as usize]);
    let bounds = Bounds::of(corners);
    let origin = bounds.centre();
    let cone = |facet: &[u32; 3]| {
        let [a, b, c] = facet.map(|index| vertices[index as usize] - origin);
        a.dot(&b.cross(&c)) / 6.0
    };
    let volume = surface.facets.iter().map(cone).sum::<f64>();
    let least = LEAST_VOLUME * bounds.size().norm().powi(3);
    // Of numbers near the smallest that there are both are 0.
    if volume.abs() <= least {
        return Err(Fault::Flat { volume: volume.abs(), least });
    }
    Ok(Shell { surface, volume, bounds })
}

/// Joins cavities to the shells around them: a shell inside an odd number of others is a cavity of the smallest.
fn nest(vertices: &[Vec3], mut shells: Vec<Shell>, warnings: &mut Vec<String>) -> Vec<Surface> {
    let around: Vec<Vec<usize>> = (0..shells.len())
        .map(|inner| (0..shells.len()).filter(|&outer| lies_in(vertices, &shells[inner], &shells[outer])).collect())
        .collect();
    for (shell, around) in shells.iter_mut().zip(&around) {
        let cavity = around.len() % 2 == 1;
        if cavity == (shell.volume > 0.0) {
            let (what, which) = if cavity { ("cavity", "into its material") } else { ("part", "inward") };
            let first = shell.surface.source[0];
            warnings.push(format!("the {what} that begins at facet {first} faces {which}: turned over"));
            shell.surface.turn_over();
        }
    }
    let mut parts: Vec<Option<Surface>> = vec![None; shells.len()];
    let volumes: Vec<f64> = shells.iter().map(|shell| shell.volume.abs()).collect();
    for (index, shell) in shells.into_iter().enumerate() {
        let smallest = around[index].iter().copied().min_by(|&a, &b| volumes[a].total_cmp(&volumes[b]));
        let home = smallest.filter(|_| around[index].len() % 2 == 1).unwrap_or(index);
        let part = parts[home].get_or_insert_with(Surface::default);
        part.facets.extend(shell.surface.facets);
        part.source.extend(shell.surface.source);
    }
    parts.into_iter().flatten().map(in_file_order).collect()
}

fn in_file_order(part: Surface) -> Surface {
    let mut both: Vec<_> = part.source.into_iter().zip(part.facets).collect();
    both.sort_by_key(|&(source, _)| source);
    let (source, facets) = both.into_iter().unzip();
    Surface { facets, source }
}

/// Facets looked at before two shells count as lying upon each other all over.
const PROBES: usize = 32;

/// Whether `inner` lies inside `outer`; shells do not cross, but may touch.
fn lies_in(vertices: &[Vec3], inner: &Shell, outer: &Shell) -> bool {
    if std::ptr::eq(inner, outer) || !within(&inner.bounds, &outer.bounds) {
        return false;
    }
    let facets = &inner.surface.facets;
    let step = facets.len().div_ceil(PROBES).max(1);
    for facet in facets.iter().step_by(step) {
        let centre = facet.iter().map(|&index| vertices[index as usize]).sum::<Vec3>() / 3.0;
        match winding(vertices, &outer.surface.facets, &centre) {
            Some(times) => return times.abs() > 0.5,
            None => continue,
        }
    }
    // A solid that fills a cavity exactly lies in it; two copies of one solid do not lie in each other.
    inner.volume > 0.0 && outer.volume < 0.0
}

fn within(inner: &Bounds, outer: &Bounds) -> bool {
    outer.holds(&inner.min) && outer.holds(&inner.max)
}
