//! Rules `registration` and `outside-part`: each print lies where its part is, and no line of it outside.
//!
//! Slicers lay the middle of an outer wall half a line inside the outline of the layer's middle. So over all of them a shift,
//! a turn and a scale show to hundredths of a millimetre (`section::fit`), and no line's edge may leave the outline by more
//! than a little. Whether a whole line stays inside is settled as exactly as its ends: the distance changes by at most 1 mm a
//! mm, so with `f` at both ends of a piece of length `l` no point of it lies farther out than `(f0 + f1 + l) / 2`.

use std::collections::HashSet;

use rayon::prelude::*;

use super::coverage::{self, CLOSED_MM};
use super::prints::{Level, OtherSection, PrintedPart};
use super::report::{FindingPlace, Findings, Rule};
use crate::gcode::marks::Role;
use crate::section::{Fit, OutlineSearch, Sample, Section, fit};

/// How far a print may be shifted, and its farthest point be turned or scaled, mm.
pub(super) const MOST_MM: f64 = 0.1;
/// How far all walls may stand out together where the slicer does not say by how much it compensates (Cura), mm.
pub(super) const MOST_OFFSET_MM: f64 = 0.25;
/// How far the edge of one line may leave the outline, beyond what all walls do, mm.
pub(super) const MOST_OUT_MM: f64 = 0.2;
/// How far an outer wall may lie too far inside, mm: an elephant's foot is compensated by 0.2 mm and more.
pub(super) const MOST_IN_MM: f64 = 0.4;
/// Walls farther off are no outer walls, mm; where the slicer names none, a line farther off may be the next wall.
const STRAY_MM: [f64; 2] = [0.8, 0.2];
/// The part of the outline that must have an outer wall beside it.
const LEAST_COVERED: f64 = 0.5;
/// Samples of one print that are taken, about.
const SAMPLES: f64 = 2000.0;
/// What the outline tells so much worse than what it tells best is not told: see [`fit`].
const WEAKEST: f64 = 4e-3;
/// A wall that runs along the outline turns from it by no more than this, as a sine: 20 degrees. What goes across the end of a thin tip
/// says nothing of where the part lies.
const ALONG: f64 = 0.34;
/// How far apart places of a wall are held against the outline, mm.
const SPACING_MM: f64 = 3.0;
/// Deeper inside than this no distance need be exact, mm.
const EXACT_MM: f64 = 0.8;
/// So far below and above its middle a layer's outline may be another's, mm.
const NEAR_MM: f64 = 0.005;
/// What three decimals of X and Y round away, mm.
const DECIMALS_MM: f64 = 1e-3;
/// Pieces shorter than this are judged by the farther of their ends, mm.
const SHORTEST_MM: f64 = 0.05;

/// Holds one print against its part.
pub(super) fn check(printed: &PrintedPart<'_>, findings: &mut Findings) {
    let (each_mm, places) = places(printed);
    let middle = centre(printed);
    let layers = printed.levels.par_iter().zip(&places);
    let layers: Vec<Layer> = layers.map(|(level, walls)| Layer::of(printed, level, walls, middle)).collect();
    // In the order of the layers, so that no digit depends on the number of threads.
    let (mut covered, mut outline) = (0.0, 0.0);
    for layer in &layers {
        for count in &layer.beside {
            covered += (0..*count).fold(0.0, |sum, _| sum + each_mm);
        }
        outline += layer.section.perimeter();
    }
    let samples: Vec<Sample> = layers.iter().flat_map(|layer| &layer.samples).copied().collect();
    let found = fit(&samples, WEAKEST);
    let registered = found.as_ref().is_none_or(|fit| registration(printed, fit, &samples, findings));
    let share = covered / outline;
    if outline > 0.0 && share < LEAST_COVERED {
        findings.add(Rule::Registration, place(printed), [share, LEAST_COVERED], || {
            format!(
                "only {:.0} % of the outline of part {} has an outer wall beside it; the part was moved, scaled or cut in the slicer, or is too \
                 thin for whole lines",
                share * 100.0,
                printed.planned.part
            )
        });
    }
    // Where all of it is moved, that is the one thing to say.
    if registered {
        let offset = found.map_or(0.0, |fit| fit.offset).clamp(-MOST_OFFSET_MM, MOST_OFFSET_MM);
        let layers = printed.levels.par_iter().zip(&layers);
        let found: Vec<Findings> = layers.map(|(level, layer)| leaves(printed, level, layer, offset)).collect();
        found.into_iter().for_each(|one| findings.append(one));
    }
}

/// The outline of one layer, and what its walls' places tell of where the part lies.
struct Layer {
    section: Section,
    other: Option<OtherSection>,
    samples: Vec<Sample>,
    /// By wall how many of its places lie beside the outline.
    beside: Vec<u32>,
}

impl Layer {
    /// Of the `places` along its walls, each a move of the trace and how far from its start, mm.
    fn of(printed: &PrintedPart<'_>, level: &Level, walls: &[WallPlaces], middle: [f64; 2]) -> Self {
        let (section, other) = printed.section(level, |i| is_outer(printed, i));
        let mut search = section.search();
        let (mut samples, mut beside) = (Vec::new(), Vec::new());
        for (index, places) in walls {
            beside.push(sample(printed, level, &mut search, (*index, places), middle, &mut samples));
        }
        Self { section, other, samples, beside }
    }
}

/// What of one layer leaves its outline, of a print in its place; its walls lie `offset` mm farther out than half a line.
fn leaves(printed: &PrintedPart<'_>, level: &Level, layer: &Layer, offset: f64) -> Findings {
    let mut findings = Findings::default();
    let mut off = strays(printed, level, &layer.section, offset);
    // A face whose corners lie on both sides of the middle is cut to pieces of both; where it leans a wall goes across it, inside one and
    // outside the other.
    if let Some(other) = layer.other.as_ref().filter(|_| !off.is_empty()) {
        let of = |stray: &Stray| (stray.line, other.leans.then_some(stray.rule));
        let also: HashSet<(u32, Option<Rule>)> =
            strays(printed, level, &other.section, offset).iter().map(of).collect();
        off.retain(|stray| also.contains(&of(stray)));
    }
    if off.iter().any(|stray| stray.rule == Rule::Registration) {
        off.retain(|stray| stray.rule != Rule::Registration || !begins_near(printed, level, stray.line, offset));
    }
    off.iter().for_each(|stray| stray.tell(printed, &mut findings));
    coverage::check(printed, level, &layer.section, offset, &mut findings);
    findings
}

fn is_outer(printed: &PrintedPart<'_>, index: u32) -> bool {
    !printed.has_roles || printed.bead(index).role == Role::OuterWall
}

/// The middle of the part in the plane.
fn centre(printed: &PrintedPart<'_>) -> [f64; 2] {
    let [low, high] = printed.sections.range();
    let [min, max] = printed.sections.at((low + high) / 2.0).bounds();
    let middle = [0, 1].map(|a| (min[a] + max[a]) / 2.0);
    if middle.iter().all(|v| v.is_finite()) { middle } else { [0.0; 2] }
}

/// Which places of a print's walls are looked at: one in each stretch of one length, wherever lines end, so that few long lines count as much as
/// many short ones of the same length. Where in its stretch goes by the golden ratio: steps of one length would meet every layer in one place.
struct Taking {
    /// The length of a stretch, mm.
    each_mm: f64,
    /// How many places were taken.
    count: u32,
    /// From the end of the last wall back to the end of the last stretch that has had its place, mm; ahead of it below 0.
    over_mm: f64,
}

impl Taking {
    fn of(walls_mm: f64) -> Self {
        Self { each_mm: (walls_mm / SAMPLES).max(SHORTEST_MM), count: 0, over_mm: 0.0 }
    }

    /// The places of the next wall, mm from its start.
    fn places(&mut self, length_mm: f64) -> Vec<f64> {
        let mut places = Vec::new();
        loop {
            let at = f64::from(self.count).mul_add(GOLDEN, 0.5).fract() * self.each_mm - self.over_mm;
            if at >= length_mm {
                self.over_mm += length_mm;
                return places;
            }
            places.push(at.max(0.0));
            self.count += 1;
            self.over_mm -= self.each_mm;
        }
    }
}

/// The part of a whole that is as to the rest as the whole is to it.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// A wall, as a move of the trace, with places along it, mm from its start.
type WallPlaces = (u32, Vec<f64>);

/// The length that each place stands for, mm; and by layer the walls that have some, as moves of the trace, with those, mm from their starts.
fn places(printed: &PrintedPart<'_>) -> (f64, Vec<Vec<WallPlaces>>) {
    let of_level = |level: &Level| {
        let walls = level.beads.iter().map(|&index| (index, printed.bead(index)));
        let walls = walls.filter(|(_, m)| !printed.has_roles || m.role == Role::OuterWall);
        walls.filter_map(|(index, m)| m.ends().map(|[from, to]| (index, (to - from).norm()))).collect()
    };
    let lengths: Vec<Vec<(u32, f64)>> = printed.levels.par_iter().map(of_level).collect();
    let mut taking = Taking::of(lengths.iter().flatten().map(|(_, length)| length).sum());
    let mut of_wall = |&(index, length): &(u32, f64)| {
        let places = taking.places(length);
        (!places.is_empty()).then_some((index, places))
    };
    let places = lengths.iter().map(|walls| walls.iter().filter_map(&mut of_wall).collect()).collect();
    (taking.each_mm, places)
}

/// Takes samples at `places` of a wall; how many of these lie beside the outline: in a small part the wall's own corners too.
fn sample(
    printed: &PrintedPart<'_>,
    level: &Level,
    search: &mut OutlineSearch<'_>,
    (index, places): (u32, &[f64]),
    centre: [f64; 2],
    samples: &mut Vec<Sample>,
) -> u32 {
    let m = printed.bead(index);
    let Some([from, to]) = m.ends() else { return 0 };
    let stray = STRAY_MM[usize::from(!printed.has_roles)];
    let mut beside = 0;
    let half = printed.width(&m, level) / 2.0;
    let length = (to - from).norm();
    let [dx, dy] = [to.x - from.x, to.y - from.y];
    for place in places {
        let p = from + (to - from) * (place / length);
        let (distance, normal) = search.nearest([p.x, p.y]);
        let out = distance + half;
        let runs_along = |normal: [f64; 2]| (dx * normal[0] + dy * normal[1]).abs() <= ALONG * length;
        if let (Some(normal), true) = (normal, out.abs() < stray) {
            beside += 1;
            if runs_along(normal) {
                samples.push(Sample { at: [p.x - centre[0], p.y - centre[1]], normal, out });
            }
        }
    }
    beside
}

fn place(printed: &PrintedPart<'_>) -> FindingPlace {
    let line = printed.levels.first().map_or(0, |l| l.line);
    FindingPlace { line, slot: Some(printed.planned.slot), part: Some(printed.planned.part) }
}

/// Whether the fit is that of a print in its place.
fn registration(printed: &PrintedPart<'_>, fit: &Fit, samples: &[Sample], findings: &mut Findings) -> bool {
    let at = place(printed);
    let part = printed.planned.part;
    let worst = [
        (fit.shift_mm(), format!("shifted by X {:+.2} Y {:+.2} mm", fit.shift[0], fit.shift[1])),
        (fit.turn_mm(), format!("turned by {:+.2} deg, {:.2} mm at its rim", fit.turn.to_degrees(), fit.turn_mm())),
        (fit.scale_mm(), format!("scaled by {:.4}, {:.2} mm at its rim", 1.0 + fit.scale, fit.scale_mm())),
    ];
    let mut fine = true;
    for (mm, text) in worst {
        if mm > MOST_MM {
            fine = false;
            findings
                .add(Rule::Registration, at, [mm, MOST_MM], || format!("part {part} is {text} (maximum {MOST_MM} mm)"));
        }
    }
    // Of a square or round part nobody can tell a scale from an offset: so all that is explained counts together.
    let (wanted, most) = match printed.flow.outset_mm {
        Some(outset) => (outset, MOST_MM),
        None => (0.0, MOST_OFFSET_MM),
    };
    let out = samples
        .iter()
        .map(|s| fit.explains(s) - wanted)
        .fold(0.0, |most: f64, v| if v.abs() > most.abs() { v } else { most });
    if fine && out.abs() > most {
        fine = false;
        findings.add(Rule::Registration, at, [out, most], || {
            let side = if out > 0.0 { "outside" } else { "inside" };
            format!("the outer walls of part {part} are up to {:.2} mm too far {side} (maximum {most} mm)", out.abs())
        });
    }
    fine
}

/// A line that is not where the outline has it.
struct Stray {
    line: u32,
    rule: Rule,
    mm: f64,
    most_mm: f64,
}

impl Stray {
    fn tell(&self, printed: &PrintedPart<'_>, findings: &mut Findings) {
        let Self { line, rule, mm, most_mm } = *self;
        let part = printed.planned.part;
        let at = FindingPlace { line, slot: Some(printed.planned.slot), part: Some(part) };
        findings.add(rule, at, [mm, most_mm], || match rule {
            Rule::OutsidePart => {
                format!("a line's edge is {mm:.3} mm outside part {part} (maximum {most_mm:.2} mm)")
            }
            _ => {
                format!("an outer wall is {mm:.3} mm too far inside the outline of part {part} (maximum {most_mm} mm)")
            }
        });
    }
}

/// Lines whose edge leaves the outline, and outer walls that leave it inward.
fn strays(printed: &PrintedPart<'_>, level: &Level, section: &Section, offset: f64) -> Vec<Stray> {
    let mut found = Vec::new();
    // The end of one line is mostly the start of the next.
    let mut last = ([f64::NAN; 2], false);
    let mut search = section.search();
    for &index in &level.beads {
        let m = printed.bead(index);
        let Some([from, to]) = m.ends() else { continue };
        let half = printed.laid_width(&m, level) / 2.0;
        // A line that fills what is narrower than two of them ends on the outline, and its round end beyond.
        let most = MOST_OUT_MM.max(half + CLOSED_MM + DECIMALS_MM) + offset.max(0.0);
        let [a, b] = [from, to].map(|p| [p.x, p.y]);
        if m.role == Role::OuterWall {
            let mm = inside(&mut search, [a, b], half - offset.min(0.0));
            if mm > MOST_IN_MM {
                found.push(Stray { line: m.line, rule: Rule::Registration, mm, most_mm: MOST_IN_MM });
            }
        }
        // What begins inside and does not meet the outline stays inside, all of it.
        let begins_inside = if last.0 == a { last.1 } else { section.is_inside(a) };
        if begins_inside && !section.meets([a, b]) {
            last = (b, true);
            continue;
        }
        let ends = [a, b].map(|p| (p, search.shallow(p, EXACT_MM)));
        last = (b, ends[1].1 < 0.0);
        let farthest = between(&mut search, ends[0], ends[1], most - half) + half;
        if farthest > most {
            found.push(Stray { line: m.line, rule: Rule::OutsidePart, mm: farthest, most_mm: most });
        }
    }
    found
}

/// Whether the wall of a line follows the outline a little below or above the layer's middle: at the bottom of a bore that lies on its side one
/// slicer cuts a slot of a twentieth of a millimetre where another meets none.
fn begins_near(printed: &PrintedPart<'_>, level: &Level, line: u32, offset: f64) -> bool {
    [-NEAR_MM, NEAR_MM].into_iter().any(|by| {
        let section = printed.sections.at(level.middle() + by);
        let mut search = section.search();
        let walls = level.beads.iter().map(|&index| printed.bead(index)).filter(|m| m.line == line);
        let mut ends = walls.filter_map(|m| m.ends().map(|ends| (m, ends)));
        ends.all(|(m, [from, to])| {
            let half = printed.laid_width(&m, level) / 2.0 - offset;
            let mut places = along([[from.x, from.y], [to.x, to.y]]);
            places.all(|p| (search.shallow(p, EXACT_MM) + half).abs() <= MOST_IN_MM)
        })
    })
}

/// How far an outer wall leaves the outline inward, mm: no slicer lays one there.
fn inside(search: &mut OutlineSearch<'_>, [a, b]: [[f64; 2]; 2], half: f64) -> f64 {
    along([a, b]).map(|p| -half - search.shallow(p, EXACT_MM)).fold(0.0, f64::max)
}

/// Places along a wall, its start left out.
fn along([a, b]: [[f64; 2]; 2]) -> impl Iterator<Item = [f64; 2]> {
    let [dx, dy] = [0, 1].map(|i| b[i] - a[i]);
    let count = ((dx * dx + dy * dy).sqrt() / SPACING_MM).ceil().max(1.0) as usize;
    (1..=count).map(move |k| [0, 1].map(|i| a[i] + (b[i] - a[i]) * (k as f64 / count as f64)))
}

/// A point and its signed distance.
type Known = ([f64; 2], f64);

/// The signed distance of the farthest point between `a` and `b`, or any value within `most`.
fn between(search: &mut OutlineSearch<'_>, a: Known, b: Known, most: f64) -> f64 {
    let [dx, dy] = [0, 1].map(|i| b.0[i] - a.0[i]);
    let length = (dx * dx + dy * dy).sqrt();
    let (worst, bound) = (a.1.max(b.1), (a.1 + b.1 + length) / 2.0);
    if worst > most || length < SHORTEST_MM || bound <= most {
        return worst;
    }
    let middle = [0, 1].map(|i| (a.0[i] + b.0[i]) / 2.0);
    let middle = (middle, search.shallow(middle, EXACT_MM));
    between(search, a, middle, most).max(between(search, middle, b, most))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thirty layers of four long lines below a hundred of many short ones: what is taken is in proportion to length, whatever the lines are.
    #[test]
    fn long_lines_count_as_their_length() {
        let long = std::iter::repeat_n([80.0, 12.0], 60).flatten();
        let short = std::iter::repeat_n(0.1, 25_000);
        let walls: Vec<f64> = long.chain(short).collect();
        let total: f64 = walls.iter().sum();
        let mut taking = Taking::of(total);
        let of_long: usize = walls[..120].iter().map(|mm| taking.places(*mm).len()).sum();
        let of_short: usize = walls[120..].iter().map(|mm| taking.places(*mm).len()).sum();
        assert!((of_long + of_short).abs_diff(2000) <= 1, "{of_long} and {of_short}");
        let share = of_long as f64 / (of_long + of_short) as f64;
        assert!((share - 60.0 * 92.0 / total).abs() < 2e-3, "{share}");
    }

    #[test]
    fn places_lie_on_their_wall_all_over_it() {
        let mut taking = Taking::of(40.0 * 1000.0);
        let mut places: Vec<f64> = (0..1000).flat_map(|_| taking.places(40.0)).collect();
        assert!(places.iter().all(|at| (0.0..40.0).contains(at)));
        places.sort_by(f64::total_cmp);
        // Forty is two whole stretches, and yet no part of the outline is left out.
        assert!(
            places.windows(2).all(|pair| pair[1] - pair[0] < 0.2) && places[0] < 0.2 && places[places.len() - 1] > 39.8
        );
    }
}
