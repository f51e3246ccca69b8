//! Rule `flow`: each line takes the filament that its width and height hold, no faster than the nozzle melts it.
//!
//! A bead `w` wide and `h` high is a rectangle with round sides, `h (w - h) + pi h^2 / 4` (PrusaSlicer, Slic3r, OrcaSlicer, the
//! built-in slicer; a bridge's thread is the same with `w = h`), or the rectangle `w h` (Cura). Where the file
//! states width and height, a line must take what the others of its role take, to 1 %; where it does not, see [`thin`], and what most lines
//! take is held closely.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::doubled;
use super::line::{DIGITS_MM, E_DIGITS_MM, Line, lines};
use super::prints::{Level, PrintedPart};
use super::report::{FindingPlace, Findings, Rule};
use super::thin;
use crate::gcode::marks::{Bead, Role};
use crate::trace::TraceMove;

/// What the sum over a print may be off where widths are stated, and where they are the profile's, relative.
pub(super) const MOST_OFF: [f64; 2] = [0.04, 0.08];
/// What the lines of one role may be off together, relative: slicers have factors for skins and first layers.
pub(super) const ONE_ROLE: f64 = 0.1;
/// What one line may be off the others of its role where its width is stated, relative: real slicers keep to 0.1 % and the last
/// digits. Arcs are fitted within 5 %, and each slicer draws the threads of its bridges as it likes.
pub(super) const ONE_LINE: f64 = 0.01;
const ONE_ARC: f64 = 0.1;
const ONE_THREAD: f64 = 0.25;
/// Fewer lines of a role than this tell nothing of what is usual for it.
const FEWEST: usize = 5;
/// Where the file states no widths at all: the most is a full line or a bridge's round thread; Cura's from 5.0 on are as wide as two where there is
/// room for less.
const UNSTATED: f64 = 1.15;
const WIDEST_VARIED: f64 = 2.0;
/// A line without a stated width may be as wide as its filament makes it where that is a drop, mm³.
const DROP_MM3: f64 = 0.2;
/// What rounding of F may add to the flow, relative.
pub(super) const RATE_SLACK: f64 = 0.01;
/// Factors that a slicer may be set to.
const MULTIPLIERS: [f64; 2] = [0.8, 1.25];

/// Holds one print's lines against their cross-sections.
pub(super) fn check(printed: &PrintedPart<'_>, findings: &mut Findings) {
    let at = |line| FindingPlace { line, slot: Some(printed.planned.slot), part: Some(printed.planned.part) };
    let part = printed.planned.part;
    let [low, high] = MULTIPLIERS;
    let line = printed.levels.first().map_or(0, |l| l.line);
    if !(low..=high).contains(&printed.flow.multiplier) {
        findings.add(Rule::Flow, at(line), [printed.flow.multiplier, high], || {
            format!(
                "part {part} was sliced with an extrusion multiplier of {}, outside {low} to {high}",
                printed.flow.multiplier
            )
        });
        return;
    }
    let (sums, by_role) = summed(printed);
    let by_level: Vec<[Findings; 2]> =
        printed.levels.par_iter().map(|level| of_level(printed, level, &by_role)).collect();
    let (each, together): (Vec<Findings>, Vec<Findings>) = by_level.into_iter().map(|[each, all]| (each, all)).unzip();
    each.into_iter().chain(together).for_each(|found| findings.append(found));
    for (role, &ratio) in by_role.iter().filter(|(_, ratio)| (*ratio - 1.0).abs() > ONE_ROLE) {
        findings.add(Rule::Flow, at(line), [ratio, 1.0 + ONE_ROLE], || {
            let kind = if *role == Role::Unknown { "unnamed" } else { role.name() };
            format!(
                "{kind} lines of part {part} use {ratio:.3} times the filament that their volume needs (allowed {:.2} to {:.2})",
                1.0 - ONE_ROLE,
                1.0 + ONE_ROLE
            )
        });
    }
    let mut sum = (sums[1].ratio(), MOST_OFF[1]);
    if sum.0 > 1.0 + sum.1 && printed.flow.bead == Bead::Varied {
        sum.0 = of_what_has_room(printed).ratio();
    }
    let kind = thin::kinds(printed).map(|ratio| (ratio, MOST_OFF[0]));
    let unstated = match kind {
        // Cura lays less where lines overlap, and says nowhere how wide they are.
        Some(kind) if !printed.flow.widths.is_empty() || (kind.0 - 1.0).abs() < (sum.0 - 1.0).abs() => kind,
        _ => sum,
    };
    for (ratio, most) in [(sums[0].ratio(), MOST_OFF[0]), unstated] {
        if (ratio - 1.0).abs() > most {
            findings.add(Rule::Flow, at(line), [ratio, 1.0 + most], || {
                format!(
                    "the lines of part {part} use {ratio:.3} times the filament that their width and height need (allowed {:.2} to {:.2}; check \
                     {}the filament's diameter, the extrusion multiplier, and that E counts mm)",
                    1.0 - most,
                    1.0 + most,
                    assumed_width(printed)
                )
            });
        }
    }
}

/// Sums over the lines with and without a stated width, and by role the usual ratio of laid to needed filament of lines with one.
///
/// Layers are read side by side and added up in their order, so that no digit depends on the number of threads.
fn summed(printed: &PrintedPart<'_>) -> ([Sum; 2], BTreeMap<Role, f64>) {
    let of_level = |level: &Level| lines(printed, level).iter().map(Amount::of).collect();
    let by_level: Vec<Vec<Amount>> = printed.levels.par_iter().map(of_level).collect();
    let mut sums = [Sum::default(), Sum::default()];
    let mut by_role: BTreeMap<Role, Vec<f64>> = BTreeMap::new();
    // Threads over air are drawn as thick as each slicer likes.
    for one in by_level.iter().flatten().filter(|one| !one.is_thread) {
        sums[usize::from(!one.stated)].add(one.laid, one.held);
        if one.stated {
            by_role.entry(one.role).or_default().push(one.laid / one.held);
        }
    }
    (sums, by_role.into_iter().map(|(role, ratios)| (role, usual(ratios))).collect())
}

/// What the sums of a print take from one line.
struct Amount {
    role: Role,
    stated: bool,
    is_thread: bool,
    /// See [`Line`], mm³.
    laid: f64,
    held: f64,
}

impl Amount {
    fn of(line: &Line) -> Self {
        Self { role: line.m.role, stated: line.stated, is_thread: line.is_thread(), laid: line.laid, held: line.held }
    }
}

/// Findings of one layer: of each line against its own cross-section, and of what melts and of lines against each other.
fn of_level(printed: &PrintedPart<'_>, level: &Level, by_role: &BTreeMap<Role, f64>) -> [Findings; 2] {
    let [mut each, mut together] = [(); 2].map(|()| Findings::default());
    let lines = lines(printed, level);
    for line in &lines {
        one(printed, line, by_role.get(&line.m.role).copied().unwrap_or(1.0), &mut each);
    }
    level.beads.iter().for_each(|&index| melts(printed, &printed.bead(index), &mut together));
    doubled::check(printed, level, &lines, &mut together);
    thin::check(printed, level, &lines, &mut together);
    [each, together]
}

/// The sum over lines without a stated width where each is as wide as it has room for: one that has room for all of its filament holds that.
fn of_what_has_room(printed: &PrintedPart<'_>) -> Sum {
    let mut sum = Sum::default();
    for level in &printed.levels {
        let lines = lines(printed, level);
        let room = thin::have_room(printed, level, &lines, MOST_OFF[1]);
        for (line, has_room) in lines.iter().zip(room).filter(|(line, _)| !line.stated && !line.is_thread()) {
            sum.add(line.laid, if has_room { line.held.max(line.laid) } else { line.held });
        }
    }
    sum
}

/// Where nobody states a width: the one that is taken, which may be what is wrong.
fn assumed_width(printed: &PrintedPart<'_>) -> String {
    let stated = printed.levels.iter().flat_map(|l| &l.beads).any(|&i| printed.bead(i).width.is_some());
    if stated || !printed.flow.widths.is_empty() {
        return String::new();
    }
    let width = printed.job.profile.process.line_width_mm;
    format!("process.line_width_mm ({width} mm, since the file states no line width), ")
}

/// The median, so that a few wrong lines do not pass for the rule; 1 where there are too few to tell.
fn usual(mut ratios: Vec<f64>) -> f64 {
    if ratios.len() < FEWEST {
        return 1.0;
    }
    let middle = ratios.len() / 2;
    *ratios.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[derive(Clone, Copy, Default)]
struct Sum {
    laid: f64,
    held: f64,
}

impl Sum {
    fn add(&mut self, laid: f64, held: f64) {
        (self.laid, self.held) = (self.laid + laid, self.held + held);
    }

    /// Laid over held; 1 for nothing.
    fn ratio(&self) -> f64 {
        if self.held > 0.0 { self.laid / self.held } else { 1.0 }
    }
}

/// One line against its own cross-section, and where its width is stated against the `usual` ratio of its role.
fn one(printed: &PrintedPart<'_>, line: &Line, usual: f64, findings: &mut Findings) {
    let digits = DIGITS_MM / line.length + E_DIGITS_MM * printed.filament_mm2 / line.held;
    let around = |most: f64| (usual - most - digits, usual + most + digits);
    let (low, high) = match line.stated {
        true if line.is_thread() => around(ONE_THREAD),
        true if line.m.is_arc() => around(ONE_ARC),
        true => around(ONE_LINE),
        false => {
            let [thread, spread] = thin::threads(printed, line);
            let most = match printed.flow.bead {
                _ if !printed.flow.widths.is_empty() => thin::WIDEST.max(spread * (1.0 + ONE_LINE)),
                Bead::Varied => WIDEST_VARIED.max(UNSTATED * thread),
                _ => UNSTATED * thread.max(1.0),
            };
            (0.0, most + digits)
        }
    };
    let ratio = line.ratio();
    // Cura merges short lines of narrow skins into one that is wider.
    let is_drop = !line.stated && ratio > high && line.laid <= DROP_MM3;
    if !(low..=high).contains(&ratio) && !is_drop {
        let at = FindingPlace { line: line.m.line, slot: Some(printed.planned.slot), part: Some(printed.planned.part) };
        findings.add(Rule::Flow, at, [ratio, if ratio < low { low } else { high }], || {
            let Line { length, width, height, .. } = line;
            format!(
                "{length:.2} mm of a line uses {ratio:.3} times the filament that a cross-section of {width:.2} x {height:.2} mm needs (allowed {low:.2} to {high:.2})"
            )
        });
    }
}

/// The hot end's own limit.
fn melts(printed: &PrintedPart<'_>, m: &TraceMove, findings: &mut Findings) {
    let most = printed.job.profile.limits.max_flow_mm3_per_s;
    let rate = m.e * printed.filament_mm2 / m.seconds;
    if m.seconds > 0.0 && rate > most * (1.0 + RATE_SLACK) {
        let at = FindingPlace { line: m.line, slot: Some(printed.planned.slot), part: Some(printed.planned.part) };
        findings.add(Rule::Flow, at, [rate, most], || {
            format!(
                "{rate:.1} mm3/s of filament is more than the hot end melts (maximum {most:.1}, [limits] max_flow_mm3_per_s)"
            )
        });
    }
}
