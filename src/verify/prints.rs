//! The beads of each print by layer, with the part's own cross-sections: what the rules of shape look at.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use rayon::prelude::*;

use super::{Planned, ReplayJob};
use crate::gcode::marks::{Expect, Mark, Role};
use crate::planning::{self, joint_gap_mm};
use crate::section::{Section, Sections};
use crate::trace::{Trace, TraceMove, What};

/// Heights that differ by less are one layer, mm: the last printed digit.
const SAME_LAYER_MM: f64 = 1.5e-3;

/// What heights may be off in a mesh of 32 bits and in a file's digits, mm.
const ROUNDING_MM: f64 = 1e-3;
/// Facets less high than this, mm, that rise by less are level: what heights may be off moves a cut through them by half a millimetre and
/// more. CAD programs write turned solids with level faces whose corners differ by micrometres.
const FLAT_MM: f64 = 5e-3;
const FLAT_SLOPE: f64 = 2e-3;
/// What leans by less is level to a rounding, mm.
const LEVEL_MM: f64 = 1e-4;

/// What a spool's filament may measure more or less than the profile says, mm: what is further off is taken for another filament, of
/// which the profile's own flows.
const AS_MEASURED_MM: f64 = 0.05;

/// One layer of one print.
pub(super) struct Level {
    /// The tip's height, machine coordinates, mm.
    pub(super) z: f64,
    /// What the slicer says the layer is high; `None` where it does not.
    pub(super) stated: Option<f64>,
    /// What the file's settings say of such layers, where nothing is said of this one.
    pub(super) nominal: Option<f64>,
    /// How much higher than the layer before; the first one than the part's lowest point.
    pub(super) gap: f64,
    /// How much lower its middle is than that of the layer that was sliced, mm: an overlap lowers the first layer and grows the second.
    pub(super) lowered: f64,
    /// Its first line in the file.
    pub(super) line: u32,
    /// Its beads, as moves of the trace.
    pub(super) beads: Vec<u32>,
}

impl Level {
    /// How high its beads are, mm.
    pub(super) fn height(&self) -> f64 {
        self.stated.unwrap_or(self.gap)
    }

    /// Where the part was cut for it, machine coordinates, mm.
    pub(super) fn middle(&self) -> f64 {
        self.z - self.height() / 2.0 + self.lowered
    }
}

/// Where a level face lies in a layer's middle, what ends there or what begins: the one that most walls do not follow.
pub(super) struct OtherSection {
    pub(super) section: Section,
    /// Whether the face leans, so that a slicer may cut it to pieces of both.
    pub(super) leans: bool,
}

/// One print, as the file lays it.
pub(super) struct PrintedPart<'a> {
    pub(super) trace: &'a Trace,
    pub(super) job: &'a ReplayJob<'a>,
    pub(super) planned: &'a Planned,
    /// The part at its pose, machine coordinates.
    pub(super) sections: Sections,
    /// From where to where its level faces reach, by their lower ends.
    level_faces: Vec<[f64; 2]>,
    /// Lowest first.
    pub(super) levels: Vec<Level>,
    /// How far its lowest point lies above what carries it, mm; 0 where nothing printed does.
    pub(super) joint_mm: f64,
    /// How much lower its first layer is laid than its height says, mm: `[joint] overlap_mm` on an earlier part.
    pub(super) overlap_mm: f64,
    /// What the header says of its flow.
    pub(super) flow: Expect,
    /// Whether the slicer says which lines are outer walls.
    pub(super) has_roles: bool,
    /// Cross-section of the filament, mm².
    pub(super) filament_mm2: f64,
}

impl PrintedPart<'_> {
    pub(super) fn bead(&self, index: u32) -> TraceMove {
        self.trace.at(index as usize)
    }

    /// Width of a line, mm: as stated, else the nearest to its filament of those that the slicer's header states, else as the
    /// profile has it.
    pub(super) fn width(&self, m: &TraceMove, level: &Level) -> f64 {
        if let Some(width) = m.width {
            return width;
        }
        let held = self.held_width(m, level);
        let nearest = self.flow.widths.iter().copied().min_by(|a, b| (a - held).abs().total_cmp(&(b - held).abs()));
        nearest.unwrap_or(self.job.profile.process.line_width_mm)
    }

    /// The width that a line's filament gives it at the layer's height, mm.
    pub(super) fn held_width(&self, m: &TraceMove, level: &Level) -> f64 {
        let (length, height) = (m.ends().map_or(0.0, |[from, to]| (to - from).norm()), level.height());
        if length == 0.0 || height <= 0.0 {
            return 0.0;
        }
        m.e * self.filament_mm2 / length / height + height * (1.0 - PI / 4.0)
    }

    /// The tip's height and the layer's of each level, lowest first.
    pub(super) fn heights(&self) -> Vec<[f64; 2]> {
        self.levels.iter().map(|level| [level.z, level.height()]).collect()
    }

    /// The same, but where nothing is stated no wider than its filament makes it: slicers fill gaps with thin lines, some
    /// without a word.
    pub(super) fn laid_width(&self, m: &TraceMove, level: &Level) -> f64 {
        let width = self.width(m, level);
        if m.width.is_some() { width } else { width.min(self.held_width(m, level).max(0.0)) }
    }

    /// Takes note of what carries it, of the prints before: the first layer begins where that was really printed to.
    fn stand_on(&mut self, before: &[planning::Printed]) {
        self.joint_mm = joint_gap_mm(self.job.workpiece, self.planned.part, self.planned.up, before);
        if !self.job.workpiece.model.is_in_place(self.planned.part) {
            self.overlap_mm = self.job.profile.joint.overlap_mm;
        }
        for (level, share) in self.levels.iter_mut().zip([1.0, 0.5]) {
            level.lowered = share * self.overlap_mm;
        }
        let joint = self.joint_mm + self.overlap_mm;
        if let Some(first) = self.levels.first_mut() {
            first.gap += joint;
        }
    }

    /// What it is for those that stand on it.
    fn as_printed(&self) -> Option<planning::Printed> {
        let height_mm = self.levels.last()?.z - self.sections.range()[0];
        Some(planning::Printed { part: self.planned.part, up: self.planned.up, height_mm })
    }

    /// The part's section that a slicer takes for a layer. Where the layer's middle is the part's top or bottom to a rounding, it is
    /// the one within the part: slicers print such a layer. Where a level face lies in the middle to a rounding, the layer is as much
    /// what ends there as what begins: the one that its walls follow, and the other one.
    pub(super) fn section(&self, level: &Level, is_wall: impl Fn(u32) -> bool) -> (Section, Option<OtherSection>) {
        let (middle, [low, high]) = (level.middle(), self.sections.range());
        let inside = middle.clamp(low + ROUNDING_MM, (high - ROUNDING_MM).max(low + ROUNDING_MM));
        let near = 2.0 * ROUNDING_MM;
        let z = if (middle - inside).abs() <= near { inside } else { middle };
        let face = self.level_faces.partition_point(|[from, _]| *from < z - near - FLAT_MM);
        let faces = self.level_faces[face..].iter().take_while(|[from, _]| *from <= z + near);
        let faces = faces.filter(|[from, to]| *to >= z - near && low + near < *from && *to < high - near);
        let all = |all: Option<[f64; 2]>, face: &[f64; 2]| match all {
            Some([from, to]) => Some([from.min(face[0]), to.max(face[1])]),
            None => Some(*face),
        };
        match faces.fold(None, all) {
            Some([from, to]) => {
                let [below, above] = [from - ROUNDING_MM, to + ROUNDING_MM].map(|z| self.sections.at(z));
                let off = |section: &Section| self.off(section, level, &is_wall);
                let (walls, section) = if off(&below) < off(&above) { (below, above) } else { (above, below) };
                (walls, Some(OtherSection { section, leans: to - from > LEVEL_MM }))
            }
            _ => (self.sections.at(z), None),
        }
    }

    /// How far the middles of a level's walls lie from half a line within an outline, all together, mm.
    fn off(&self, section: &Section, level: &Level, is_wall: impl Fn(u32) -> bool) -> f64 {
        let mut search = section.search();
        let walls = level.beads.iter().filter(|&&i| is_wall(i)).map(|&i| self.bead(i));
        let off = |m: TraceMove| {
            let [from, to] = m.ends()?;
            let middle = (from + to) / 2.0;
            Some((search.signed_distance([middle.x, middle.y]) + self.width(&m, level) / 2.0).abs())
        };
        walls.filter_map(off).sum()
    }
}

/// Every print of which the file lays something, in the order of the plan.
pub(super) fn gather<'a>(
    trace: &'a Trace,
    job: &'a ReplayJob<'a>,
    planned: &'a [Planned],
) -> Vec<Option<PrintedPart<'a>>> {
    let beads = by_print(trace, planned.len());
    let flows = stated_flows(trace, planned.len());
    let each = beads.into_par_iter().zip(flows).zip(planned);
    let one = |((beads, flow), plan): ((Vec<u32>, Expect), &'a Planned)| {
        // Supports have no part of their own: see `holding`.
        if beads.is_empty() || plan.gap_mm.is_some() { None } else { printed(trace, job, plan, &beads, flow) }
    };
    let mut all: Vec<Option<PrintedPart<'_>>> = each.map(one).collect();
    let mut before = Vec::new();
    for print in all.iter_mut().flatten() {
        print.stand_on(&before);
        before.extend(print.as_printed());
    }
    all
}

/// The printing moves of each print whose ends are known; what is laid beside it on the table is none of it.
fn by_print(trace: &Trace, prints: usize) -> Vec<Vec<u32>> {
    let mut all = vec![Vec::new(); prints];
    for m in trace.moves().filter(|m| m.prints() && m.role != Role::Adhesion) {
        let print = trace.state(&m).print.map(|p| p as usize).filter(|p| *p < prints);
        if let (Some(print), Some(_)) = (print, m.ends()) {
            all[print].push(m.index as u32);
        }
    }
    all
}

/// What the header says of each print's flow.
pub(super) fn stated_flows(trace: &Trace, prints: usize) -> Vec<Expect> {
    let mut all = vec![Expect::plain(0, 0, 0.0); prints];
    for event in &trace.events {
        if let What::Mark(Mark::Expect(expect)) = &event.what
            && let Some(slot) = all.get_mut(expect.print)
        {
            *slot = expect.clone();
        }
    }
    all
}

fn printed<'a>(
    trace: &'a Trace,
    job: &'a ReplayJob<'a>,
    planned: &'a Planned,
    beads: &[u32],
    flow: Expect,
) -> Option<PrintedPart<'a>> {
    let part = job.workpiece.parts.get(planned.part)?;
    let sections = Sections::of(&part.moved(&job.profile.kinematics().forward(planned.pose)));
    let has_roles = beads.iter().any(|&i| trace.at(i as usize).role == Role::OuterWall);
    let level_faces = sections.level_facets(FLAT_MM, FLAT_SLOPE);
    let mut levels = levels(trace, beads, sections.range()[0]);
    for (index, level) in levels.iter_mut().enumerate() {
        level.nominal = flow.heights_mm.map(|[first, other]| if index == 0 { first } else { other });
    }
    let usual_mm = job.profile.process.filament_mm;
    let diameter_mm = flow.diameter_mm.filter(|mm| (mm - usual_mm).abs() <= AS_MEASURED_MM).unwrap_or(usual_mm);
    let filament_mm2 = PI / 4.0 * diameter_mm.powi(2);
    Some(PrintedPart {
        trace,
        job,
        planned,
        sections,
        level_faces,
        levels,
        joint_mm: 0.0,
        overlap_mm: 0.0,
        flow,
        has_roles,
        filament_mm2,
    })
}

/// The level beads by height; lines that rise while they are laid belong to none.
fn levels(trace: &Trace, beads: &[u32], bottom: f64) -> Vec<Level> {
    let mut all: Vec<Level> = Vec::new();
    // By height, in the digits that a trace keeps.
    let mut by_height: BTreeMap<i64, usize> = BTreeMap::new();
    let digits = |mm: f64| (mm * 1e4).round() as i64;
    let around = digits(SAME_LAYER_MM) + 1;
    let mut last = None;
    for &index in beads {
        let m = trace.at(index as usize);
        let Some([from, to]) = m.ends() else { continue };
        if (to.z - from.z).abs() > SAME_LAYER_MM {
            continue;
        }
        let same = |level: &Level| (level.z - to.z).abs() <= SAME_LAYER_MM;
        let newest = || {
            let near = by_height.range(digits(to.z) - around..=digits(to.z) + around);
            near.map(|(_, &i)| i).filter(|&i| same(&all[i])).max()
        };
        let place = last.filter(|&i: &usize| same(&all[i])).or_else(newest);
        let place = place.unwrap_or_else(|| {
            all.push(Level {
                z: to.z,
                stated: None,
                nominal: None,
                gap: 0.0,
                lowered: 0.0,
                line: m.line,
                beads: Vec::new(),
            });
            by_height.insert(digits(to.z), all.len() - 1);
            all.len() - 1
        });
        last = Some(place);
        let level = &mut all[place];
        // Threads over air and combined infill are of another height than their layer.
        if !matches!(m.role, Role::Bridge | Role::Overhang | Role::Infill) {
            level.stated = level.stated.or(m.height);
        }
        level.beads.push(index);
    }
    all.sort_by(|a, b| a.z.total_cmp(&b.z));
    let mut below = bottom;
    for level in &mut all {
        level.gap = level.z - below;
        below = level.z;
    }
    all
}
