//! The built-in slicer: walls, skins, infill, bridges, brim and skirt; no supports.
//!
//! It is honest and small: what it cannot print it tells ([`Flaw`]), and what lies over air it marks as a bridge or an overhang. Same input, same bytes, whatever the number of threads.

mod adhesion;
mod arcs;
mod bridges;
mod carriers;
mod comb;
mod cut;
mod emit;
mod hatch;
mod ini;
mod join;
mod lost;
mod narrow;
mod near;
mod nearest;
mod onto;
mod order;
mod overhang;
mod plan;
mod region;
mod seam;
mod sheets;
mod skins;
mod strips;
#[cfg(test)]
mod tests;
mod thickness;
mod tour;
mod walls;
mod zigzag;

use std::f64::consts::FRAC_PI_4;

use self::carriers::Printed;
use self::cut::{Cut, cuts};
use self::emit::Writer;
use self::order::Order;
use self::plan::{Path, PlannedLayer, all_walls, planned};
use self::region::{Contour, Region, units};
use self::skins::Stack;
use super::{Flaw, LeftOut, SliceError, SliceJob, SliceSettings, Sliced, Slicer};
use crate::gcode::checksum;
use crate::geom::Slot;
use crate::mesh::TriangleMesh;

pub use self::ini::Configured;
pub use self::sheets::sheets;

/// The cross-section of every line: a stadium, as PrusaSlicer has it.
struct Line {
    width: i32,
    spacing: i32,
    width_mm: f64,
    /// The pitch at which lines side by side fill the layer exactly.
    spacing_mm: f64,
    height_mm: f64,
    area_mm2: f64,
}

impl Line {
    fn new(width_mm: f64, height_mm: f64) -> Self {
        let spacing_mm = width_mm - height_mm * (1.0 - FRAC_PI_4);
        let area_mm2 = (width_mm - height_mm) * height_mm + FRAC_PI_4 * height_mm.powi(2);
        Self { width: units(width_mm), spacing: units(spacing_mm), width_mm, spacing_mm, height_mm, area_mm2 }
    }

    /// The cross-section of a line of another width, mm².
    fn area_of(&self, width_mm: f64) -> f64 {
        self.area_mm2 + (width_mm - self.width_mm) * self.height_mm
    }
}

/// The lines of each layer.
struct Lines {
    /// Of the first one where it lies on the table.
    first: Option<Line>,
    others: Line,
}

impl Lines {
    fn new(s: &SliceSettings, on_table: bool) -> Self {
        let of = |width_mm| Line::new(width_mm, s.layer_height_mm);
        let first = on_table && s.first_layer_width_mm > 0.0 && s.first_layer_width_mm != s.line_width_mm;
        Self { first: first.then(|| of(s.first_layer_width_mm)), others: of(s.line_width_mm) }
    }

    fn at(&self, layer: usize) -> &Line {
        self.first.as_ref().filter(|_| layer == 0).unwrap_or(&self.others)
    }
}

/// The slicer that is always there.
#[derive(Clone, Copy, Debug, Default)]
pub struct BuiltIn;

impl Slicer for BuiltIn {
    fn name(&self) -> &str {
        "built-in slicer"
    }

    fn version(&self) -> &str {
        env!("CARGO_PKG_VERSION")
    }

    fn slice(&self, mesh: &TriangleMesh<Slot>, settings: &SliceSettings, job: &SliceJob) -> Result<Sliced, SliceError> {
        slice(mesh, settings, job)
    }
}

/// G-code of the part: G21, G90, M83, layers, fan; no start or end code and no temperatures.
///
/// Layer `k` (from 0) is the section at `z = (k + 1/2) h`, printed at `z = (k + 1) h`, a little wider where it is too thin to print and something
/// stands on it; the part's height is rounded to whole layers. What was left out or repaired is told as [`Flaw`]s, and in `; warning:` comments at the end;
/// [`super::config_values`] reads the settings behind them.
///
/// # Errors
///
/// Settings out of range, a mesh without facets, off the bed, off z = 0 or lower than half a layer, and a part of
/// which no line could be printed, of which more than 5 % could not, or a whole layer below others.
pub fn slice(mesh: &TriangleMesh<Slot>, settings: &SliceSettings, job: &SliceJob) -> Result<Sliced, SliceError> {
    settings.check()?;
    let count = job.layers(mesh, settings.layer_height_mm)?;
    let lines = Lines::new(settings, job.on_table);
    let planes: Vec<f64> = (0..count).map(|k| (k as f64 + 0.5) * settings.layer_height_mm).collect();
    let mut cuts = cuts(mesh, &planes);
    let mut outlines: Vec<Region> = cuts.iter_mut().map(|cut| std::mem::take(&mut cut.region)).collect();
    let mut same_as = runs(&outlines, lines.first.is_some());
    let mut walls = all_walls(&outlines, &same_as, &lines, settings.walls);
    if let Some(widened) = (Printed { outlines: &outlines, same_as: &same_as, walls: &walls }).widened(&lines) {
        outlines = widened;
        same_as = runs(&outlines, lines.first.is_some());
        walls = all_walls(&outlines, &same_as, &lines, settings.walls);
    }
    let stack = Stack::new(&outlines, &same_as);
    let mut layers = planned(&stack, &walls, &lines, settings);
    let end = lost::without_crumb(&stack, &mut layers, &lines.others);
    if layers.iter().all(|layer| layer.islands.is_empty()) {
        return Err(SliceError::NothingExtruded { slicer: BuiltIn.name().to_owned(), name: job.name.clone() });
    }
    let flaws = flaws(&cuts, lost::left_out(&job.name, &stack, &walls, &layers, end, &lines.others)?);
    let mut writer = Writer::new(settings, &lines);
    writer.raw(&format!("; generated by trunnion {} {}\n", BuiltIn.name(), BuiltIn.version()));
    writer.raw(
        "G21 ; set units to millimeters\nG90 ; use absolute coordinates\nM83 ; use relative distances for extrusion",
    );
    let around = adhesion::rings(&outlines[0], lines.at(0), &job.adhesion);
    write_layers(&layers, around, settings, job, &mut writer);
    for flaw in &flaws {
        writer.raw(&format!("; warning: {flaw}"));
    }
    let (mut text, filament_mm) = writer.finish();
    text.extend(footer(settings, filament_mm).into_bytes());
    text.extend(checksum::closing_line(&text).into_bytes());
    Ok(Sliced { gcode: text, flaws })
}

/// For every layer the lowest one of the run of equal layers it stands in; the first may have lines of its own.
fn runs(outlines: &[Region], first_alone: bool) -> Vec<usize> {
    let mut same_as: Vec<usize> = Vec::with_capacity(outlines.len());
    for at in 0..outlines.len() {
        let same = at > usize::from(first_alone) && outlines[at] == outlines[at - 1];
        same_as.push(if same { same_as[at - 1] } else { at });
    }
    same_as
}

fn write_layers(
    layers: &[PlannedLayer<'_>],
    around: Vec<Contour>,
    s: &SliceSettings,
    job: &SliceJob,
    writer: &mut Writer<'_>,
) {
    let mut order = Order::new(s);
    order.around(around);
    if job.on_table {
        writer.layer_fan(0.0);
    }
    // A layer's order asks where the one before ended, its text for both: one layer is ordered while the one below is written.
    let mut ordered = |index: usize| layers.get(index).map(|layer| order.of(layer, layers.get(index + 1)));
    let mut next = ordered(0);
    for index in 0..layers.len() {
        let paths = next.take().unwrap_or_default();
        let write = || write_layer(index, &paths, s, job, writer);
        (next, ()) = rayon::join(|| ordered(index + 1), write);
    }
}

fn write_layer(index: usize, paths: &[Path], s: &SliceSettings, job: &SliceJob, writer: &mut Writer<'_>) {
    if index == usize::from(job.on_table) {
        writer.layer_fan(s.fan);
    }
    if paths.is_empty() {
        return;
    }
    let label = job.name.replace(['\n', '\r'], " ");
    writer.layer(index, job.on_table && index == 0);
    writer.take_time(paths);
    writer.raw(&format!("; printing object {label} id:0 copy 0"));
    paths.iter().for_each(|path| writer.path(path));
    writer.wait();
    writer.raw(&format!("; stop printing object {label} id:0 copy 0"));
}

fn flaws(cuts: &[Cut], left: Option<LeftOut>) -> Vec<Flaw> {
    let contours: usize = cuts.iter().map(|cut| cut.open).sum();
    let longest_mm = cuts.iter().map(|cut| cut.longest_gap_mm).fold(0.0, f64::max);
    let open = (contours > 0).then_some(Flaw::Open { contours, longest_mm });
    open.into_iter().chain(left.map(Flaw::LeftOut)).collect()
}

/// The settings, under PrusaSlicer's names.
fn footer(s: &SliceSettings, filament_mm: f64) -> String {
    let cm3 = filament_mm * FRAC_PI_4 * s.filament_mm.powi(2) / 1000.0;
    format!(
        "; filament used [mm] = {filament_mm:.2}\n; filament used [cm3] = {cm3:.2}\n\n\
         ; bed_temperature = {}\n; bottom_solid_layers = {}\n; extrusion_width = {}\n; filament_diameter = {}\n\
         ; fill_density = {}%\n; gcode_flavor = marlin\n; layer_height = {}\n; nozzle_diameter = {}\n; perimeters = {}\n; temperature = {}\n\
         ; top_solid_layers = {}\n",
        s.bed_c,
        s.bottom_layers,
        s.line_width_mm,
        s.filament_mm,
        s.infill * 100.0,
        s.layer_height_mm,
        s.nozzle_mm,
        s.walls,
        s.nozzle_c,
        s.top_layers
    )
}
