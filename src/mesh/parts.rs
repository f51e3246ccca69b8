//! From closed shells to parts: outer shells, the cavities in them, and which way they face.

use super::box_tree::BoxTree;
use super::error::{Fault, FilePlace, Located};
use super::shells::{Surface, closed_shells, mended_shells};
use super::soup::{Label, Soup};
use super::winding::winding;
use crate::geom::{Bounds, Vec3};
use crate::spelling::counted;

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
/// the material. Warnings go to `soup.warnings`. Where `mended_to` is given, what is open is mended, and corners are joined that are up to so many
/// file units apart.
pub(super) fn parts(soup: &mut Soup, mended_to: Option<f64>) -> Result<Vec<Surface>, Located> {
    let body = |index: usize| soup.names[soup.labels[index] as usize].body;
    let indices: Vec<usize> = (0..soup.facets.len()).collect();
    let bodies: Vec<_> = indices.chunk_by(|&a, &b| body(a) == body(b)).map(|run| run[0]..run[0] + run.len()).collect();
    let mut warnings = Vec::new();
    let (mut found, mut parts, mut flat) = (0, Vec::new(), Flat::default());
    for body in bodies {
        let first = body.start as u32;
        let facets = &soup.facets[body];
        let closed = match mended_to {
            Some(most) => mended_shells(&mut soup.vertices, facets, first, most, &mut warnings)
                .map_err(|(facet, fault)| fault.at(named(&soup.names[soup.labels[facet as usize] as usize])))?,
            None => closed_shells(&soup.vertices, facets, first)
                .map_err(|(index, fault)| fault.at(FilePlace::Part(found + index)))?,
        };
        let mut shells = Vec::new();
        for surface in closed {
            let (first, facets) = (surface.source[0], surface.facets.len());
            match measure(&soup.vertices, surface) {
                Ok(shell) => shells.push(shell),
                Err(fault) => flat.add(fault.at(FilePlace::Part(found)), first, facets),
            }
            found += 1;
        }
        parts.extend(nest(&soup.vertices, shells, &mut warnings));
    }
    match flat.first {
        Some((fault, _)) if parts.is_empty() => return Err(fault),
        Some((_, first)) => {
            let Flat { surfaces, facets, .. } = flat;
            let (what, verb) = (counted(surfaces, "surface"), if surfaces == 1 { "encloses" } else { "enclose" });
            warnings.push(format!("removed {what} that {verb} no volume ({facets} facets, starting at facet {first})"));
        }
        None => {}
    }
    parts.sort_by_key(|part: &Surface| part.source[0]);
    soup.warnings.append(&mut warnings);
    Ok(parts)
}

/// Where something that is called so is, in the file's words.
fn named(label: &Label) -> FilePlace {
    label.name.clone().map_or(FilePlace::File, FilePlace::Named)
}

/// Surfaces that are folded flat onto themselves: no slicer lays anything there.
#[derive(Default)]
struct Flat {
    /// What is to be said of the first, and where it begins.
    first: Option<(Located, u32)>,
    surfaces: usize,
    facets: usize,
}

impl Flat {
    fn add(&mut self, fault: Located, first: u32, facets: usize) {
        self.first.get_or_insert((fault, first));
        self.surfaces += 1;
        self.facets += facets;
    }
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

/// What is just inside of a shell.
#[derive(Clone, Copy, Default)]
struct Inside {
    /// How often shells wind around it: more outward than inward; 0 where nothing is.
    times: usize,
    /// The shell of the part whose material that is.
    part: Option<usize>,
    /// Whether what lies in it is flipped with it.
    inverted: bool,
}

/// Joins cavities to the shells around them, by what slicers fill: all around which shells wind more often outward than inward.
///
/// What faces outward within material bounds none, and is dropped. An outermost shell that faces inward is flipped with all that lies in it, and so
/// is what faces inward within a cavity. Each is told by its first facet.
fn nest(vertices: &[Vec3], mut shells: Vec<Shell>, warnings: &mut Vec<String>) -> Vec<Surface> {
    let (around, _) = around(vertices, &shells);
    let mut outer_first: Vec<usize> = (0..shells.len()).collect();
    outer_first.sort_by_key(|&shell| (around[shell].count, shell));
    let mut homes: Vec<Option<usize>> = vec![None; shells.len()];
    let mut just_inside = vec![Inside::default(); shells.len()];
    for own in outer_first {
        let outside = around[own].smallest.map_or(Inside::default(), |least| just_inside[least]);
        let shell = &mut shells[own];
        let first = shell.surface.source[0];
        // Where nothing is, whatever comes next is a part.
        let inverted = if outside.times == 0 { shell.volume < 0.0 } else { outside.inverted };
        let outward = (shell.volume > 0.0) != inverted;
        let times = if outward { outside.times + 1 } else { outside.times - 1 };
        if inverted {
            let what = if outward { "part" } else { "cavity" };
            let which = if shell.volume > 0.0 { "into its material" } else { "inward" };
            warnings.push(format!("the {what} that begins at facet {first} faces {which}: flipped"));
            shell.surface.turn_over();
        }
        let part = if outside.times == 0 { Some(own) } else { outside.part };
        just_inside[own] = Inside { times, part: part.filter(|_| times > 0), inverted };
        if outside.times == 0 || times == 0 {
            homes[own] = part;
        } else {
            let facets = counted(shell.surface.facets.len(), "facet");
            warnings.push(format!("the surface that begins at facet {first} lies within material: removed ({facets})"));
        }
    }
    let mut parts: Vec<Option<Surface>> = vec![None; shells.len()];
    for (shell, home) in shells.into_iter().zip(homes) {
        let Some(home) = home else { continue };
        let part = parts[home].get_or_insert_with(Surface::default);
        part.facets.extend(shell.surface.facets);
        part.source.extend(shell.surface.source);
    }
    parts.into_iter().flatten().map(in_file_order).collect()
}

/// The shells that one lies in.
#[derive(Clone, Debug, Default)]
struct Around {
    count: usize,
    /// That with the least volume, the first of several.
    smallest: Option<usize>,
    /// Those of them that are around no other of them: all others are around these.
    next: Vec<u32>,
}

/// What is around each shell, and how often it was asked whether one lies in another.
///
/// Outer shells come first: what is around a shell is around everything that lies in it, and is not asked for again, so that `n`
/// shells in each other need `n` questions.
fn around(vertices: &[Vec3], shells: &[Shell]) -> (Vec<Around>, usize) {
    let boxes = BoxTree::of_boxes(shells.iter().map(|shell| shell.bounds).collect());
    let rank = |&shell: &u32| (shells[shell as usize].bounds.size().norm(), shells[shell as usize].volume.abs());
    let smaller = |a: &u32, b: &u32| {
        let (a, b, order) = (rank(a), rank(b), a.cmp(b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(order)
    };
    let mut order: Vec<u32> = (0..shells.len() as u32).collect();
    order.sort_by(|a, b| smaller(b, a));
    let (mut all, mut asked) = (vec![Around::default(); shells.len()], 0);
    // By shell, the last one that it was found to be around.
    let mut known = vec![u32::MAX; shells.len()];
    let (mut outer, mut queue) = (Vec::new(), Vec::new());
    for own in order {
        let inner = &shells[own as usize];
        outer.clear();
        let corner = Bounds { min: inner.bounds.min, max: inner.bounds.min };
        boxes.visit(&corner, |other| outer.push(other as u32));
        outer.retain(|&other| other != own && within(&inner.bounds, &shells[other as usize].bounds));
        outer.sort_by(smaller);
        let mut found = Around::default();
        for &other in &outer {
            if known[other as usize] == own {
                continue;
            }
            asked += 1;
            if !lies_in(vertices, inner, &shells[other as usize]) {
                continue;
            }
            found.next.push(other);
            queue.push(other);
            while let Some(one) = queue.pop() {
                if std::mem::replace(&mut known[one as usize], own) != own {
                    found.count += 1;
                    queue.extend(&all[one as usize].next);
                }
            }
        }
        let least = |&a: &usize, &b: &usize| shells[a].volume.abs().total_cmp(&shells[b].volume.abs()).then(a.cmp(&b));
        let further = found.next.iter().flat_map(|&one| [Some(one as usize), all[one as usize].smallest]);
        found.smallest = further.flatten().min_by(least);
        all[own as usize] = found;
    }
    (all, asked)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    /// A cube about `centre` with half an edge of `half`, its corners among `vertices`.
    fn cube(vertices: &mut Vec<Vec3>, centre: Vec3, half: f64) -> Shell {
        const QUADS: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let first = vertices.len() as u32;
        let side = |i: usize, axis: usize| if i >> axis & 1 == 0 { -half } else { half };
        vertices.extend((0..8).map(|i| centre + Vec3::new(side(i, 0), side(i, 1), side(i, 2))));
        let facets = QUADS.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        let facets: Vec<[u32; 3]> = facets.map(|facet| facet.map(|index| first + index)).collect();
        let source = (0..facets.len() as u32).collect();
        measure(vertices, Surface { facets, source }).unwrap()
    }

    /// What is around each cube, by arithmetic: a cube lies in another where all of it does.
    fn by_arithmetic(shells: &[Shell]) -> Vec<(usize, Option<usize>)> {
        let holds = |outer: &Shell, inner: &Shell| {
            let (a, b) = (&outer.bounds, &inner.bounds);
            (0..3).all(|i| a.min[i] < b.min[i] && b.max[i] < a.max[i])
        };
        let around = |inner: &Shell| {
            let outer: Vec<usize> = (0..shells.len()).filter(|&o| holds(&shells[o], inner)).collect();
            let smallest = outer.iter().copied().min_by(|&a, &b| shells[a].volume.total_cmp(&shells[b].volume));
            (outer.len(), smallest)
        };
        shells.iter().map(around).collect()
    }

    #[test]
    fn what_is_around_a_shell_is_what_arithmetic_says() {
        let mut numbers = SplitMix64::seeded(11);
        for count in [1, 7, 60, 250] {
            let mut vertices = Vec::new();
            let shells: Vec<Shell> = (0..count)
                .map(|_| {
                    let centre = Vec3::from_fn(|_, _| numbers.unit() * 20.0);
                    cube(&mut vertices, centre, 0.1 + 12.0 * numbers.unit().powi(3))
                })
                .collect();
            let (found, _) = around(&vertices, &shells);
            let found: Vec<_> = found.iter().map(|one| (one.count, one.smallest)).collect();
            assert_eq!(found, by_arithmetic(&shells));
        }
    }

    /// Shells in each other, shuffled; those beside each other lie in none.
    #[test]
    fn as_many_questions_are_asked_as_there_are_shells() {
        for count in [1, 10, 100, 1000] {
            let mut vertices = Vec::new();
            let half = |k: usize| 1.0 + ((k * 617) % count) as f64;
            let nested: Vec<Shell> = (0..count).map(|k| cube(&mut vertices, Vec3::zeros(), half(k))).collect();
            let (found, asked) = around(&vertices, &nested);
            assert_eq!(asked, count - 1);
            (0..count).for_each(|k| assert_eq!(found[k].count as f64, count as f64 - half(k)));
            let beside: Vec<Shell> = (0..count).map(|k| cube(&mut vertices, Vec3::x() * (3 * k) as f64, 1.0)).collect();
            let (found, asked) = around(&vertices, &beside);
            assert!(asked == 0 && found.iter().all(|one| one.count == 0));
        }
    }
}
