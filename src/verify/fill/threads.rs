//! Walls are as many threads thick as the settings want, up to three: no thread is missing from all of them.

use super::super::prints::PrintedPart;
use super::super::report::Findings;
use super::walls::{SPACING_MM, TELLING_LAYERS, TELLING_MM};
use super::{Told, add};

/// How thick a wall of some threads is at least, in widths of one: they overlap by a tenth, and the last may be half missing.
const THREAD: f64 = 0.85;
const LESS: f64 = 0.1;
/// More threads than this are not told apart.
const MOST_THREADS: u32 = 3;
/// Beyond this it is not followed, mm; where the file states no number of walls, those of a wide nozzle may be one.
const THICK_MM: f64 = 1.2;
const UNSTATED_MM: f64 = 0.7;
/// Lines of which a width is taken, and the part of their length that may be thinner: infill may be as wide as two lines of a wall, and be most of
/// the lines.
const LINES: usize = 1000;
const THINNER: f64 = 0.1;

pub(super) fn check(printed: &PrintedPart<'_>, told: &[Told], findings: &mut Findings) {
    let stated = printed.flow.inside.walls;
    let wanted = stated.unwrap_or(printed.job.profile.process.walls.min(2)).min(MOST_THREADS);
    if wanted < 2 {
        return;
    }
    let tells = |layer: &&Told| layer.walls.depths().len() as f64 * SPACING_MM >= TELLING_MM;
    let layers: Vec<&Told> = told.iter().filter(tells).collect();
    let mut depths: Vec<f32> = layers.iter().flat_map(|layer| layer.walls.depths()).copied().collect();
    if layers.len() < TELLING_LAYERS {
        return;
    }
    let middle = depths.len() / 2;
    let depth = f64::from(*depths.select_nth_unstable_by(middle, f32::total_cmp).1);
    let width = thin_width(printed);
    let threads = THREAD * f64::from(wanted) - LESS;
    let most = (threads * width).min(if stated.is_some() { THICK_MM } else { UNSTATED_MM });
    if depth < most {
        add(printed, layers[0].line, [depth, most], findings, || {
            format!(
                "the walls of part {} are {depth:.2} mm thick in most places of {} layers, but at least {wanted} lines of {width:.2} mm are wanted (minimum \
                 {most:.2} mm; for fewer set [process] walls = {})",
                printed.planned.part,
                layers.len(),
                wanted - 1
            )
        });
    }
}

/// The width that the filament of thin lines gives them, mm: but a tenth of all length is as wide.
fn thin_width(printed: &PrintedPart<'_>) -> f64 {
    let all: usize = printed.levels.iter().map(|level| level.beads.len()).sum();
    let lines = printed.levels.iter().flat_map(|level| level.beads.iter().map(move |&bead| (level, bead)));
    let sized = |(level, bead)| {
        let m = printed.bead(bead);
        (printed.held_width(&m, level), m.ends().map_or(0.0, |[from, to]| (to - from).norm()))
    };
    let mut widths: Vec<(f64, f64)> =
        lines.step_by((all / LINES).max(1)).map(sized).filter(|(width, _)| *width > 0.0).collect();
    widths.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut left = THINNER * widths.iter().map(|(_, length)| length).sum::<f64>();
    let thin = widths.iter().find(|(_, length)| {
        left -= length;
        left < 0.0
    });
    thin.map_or(printed.job.profile.process.line_width_mm, |(width, _)| *width)
}
