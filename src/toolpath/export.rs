//! A print's mesh as the slicer gets it, and the check that what comes back is that mesh, where it was put.

use crate::gcode::round_to;
use crate::geom::{Bounds, Rigid, Slot, Vec3};
use crate::mesh::TriangleMesh;
use crate::motion::TableKinematics;
use crate::planning::{Print, Workpiece};
use crate::profile::Profile;
use crate::section::{Section, Sections, Segment};

use super::sliced::{Layer, SlicedPrint};

/// Step of the grid on which room for a line is looked for, mm.
const ROOM_STEP_MM: f64 = 0.1;

/// A part turned upright, its lowest point at z = 0, centred on the slicer's bed.
pub struct SlotMesh {
    /// The part, slot frame.
    pub mesh: TriangleMesh<Slot>,
    /// What takes slot coordinates to the machine's, mm, whole microns.
    pub to_machine: Vec3,
    /// Whether it stands on the table.
    pub on_table: bool,
    /// How far above the table its lowest point is, where it is printed upright and in place without standing there; mm.
    pub raised_mm: f64,
}

impl SlotMesh {
    /// As its supports know it: z counts from the table, on which they stand.
    #[must_use]
    pub fn above_table(mut self) -> Self {
        if self.raised_mm > 0.0 {
            let up = Vec3::new(0.0, 0.0, self.raised_mm);
            self.mesh = self.mesh.moved(&Rigid::<Slot, Slot>::shift(up));
            self.to_machine -= up;
        }
        self
    }
}

/// The mesh of `print`, its box centred on `centre_mm` of the slicer's bed.
pub fn slot_mesh(workpiece: &Workpiece<'_>, table: &TableKinematics, print: &Print, centre_mm: [f64; 2]) -> SlotMesh {
    let motion = table.forward(print.pose(table));
    let part = &workpiece.parts[print.part];
    let turned: TriangleMesh<Slot> = part.moved(&Rigid::new(motion.rotation, Vec3::zeros()));
    let bounds = turned.bounds();
    let centre = bounds.centre();
    let export = Vec3::new(centre_mm[0] - centre.x, centre_mm[1] - centre.y, -bounds.min.z);
    let to_machine = (motion.translation - export).map(|v| round_to(v, 3));
    let upright = motion.rotation[(2, 2)] > 1.0 - 1e-9;
    let captive = upright && workpiece.model.captive.contains(&print.part);
    SlotMesh {
        mesh: turned.moved(&Rigid::<Slot, Slot>::shift(export)),
        to_machine,
        on_table: upright && workpiece.model.on_table.contains(&print.part),
        raised_mm: if captive { round_to(to_machine.z - motion.translation.z, 3) } else { 0.0 },
    }
}

/// What was sliced is not the mesh that was handed over, or not where it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BoxMismatch {
    /// Extrusion beside the part.
    #[error(
        "extrusion at z {z:.2} mm reaches {beyond_mm:.2} mm beyond the part in {axis} (its middle is {shift_x:+.2}, {shift_y:+.2} mm off); undo every move, turn and scaling of the part in the slicer, and switch off skirt, brim and supports"
    )]
    Beyond {
        /// Height, slot frame.
        z: f64,
        /// `"x"` or `"y"`.
        axis: &'static str,
        /// How far.
        beyond_mm: f64,
        /// Middle of the extrusion less middle of the part.
        shift_x: f64,
        /// The same in y.
        shift_y: f64,
    },
    /// Layers that are narrower than the part.
    #[error(
        "extrusion falls {short_mm:.2} mm short of the part in {axis} on half of its layers (allowed {allowed_mm:.2}); it was scaled or cut in the slicer, or a piece of it was dropped"
    )]
    Short {
        /// `"x"` or `"y"`.
        axis: &'static str,
        /// The median shortfall of one side.
        short_mm: f64,
        /// What thin tips may lose.
        allowed_mm: f64,
    },
    /// Of another size than the part.
    #[error(
        "it is {:.3} x {:.3} x {:.3} times as large as the part in x, y and z; it was scaled or cut in the slicer, or is another part: \
         set its scale back to 100 %, its cuts back, and slice again", .times[0], .times[1], .times[2]
    )]
    Scaled {
        /// In the part's own directions, as it was handed over.
        times: [f64; 3],
    },
    /// The part's mirror image.
    #[error("it is the part's mirror image; it was mirrored in the slicer: mirror it back and slice again")]
    Mirrored,
    /// Of its size, but not its shape.
    #[error(
        "its outlines are not those of the part, wherever it was moved or turned; it is another part, or was tipped over or cut in the slicer"
    )]
    NotFound,
    /// The wrong height.
    #[error(
        "extrusion ends at z {top:.2} mm, the part at {height:.2} mm; it was scaled, sunk, lifted or cut in the slicer (or is thinner than a line further up)"
    )]
    Height {
        /// The highest extrusion.
        top: f64,
        /// The part.
        height: f64,
    },
}

/// Compares what was extruded with the part's own cross-sections, layer by layer.
///
/// A line's centre lies half a width inside the outline, so half a width beyond it is the user's doing and not the
/// slicer's. Sharp tips thinner than a line are not printed by any slicer; hence the median for what is missing, and what is missing
/// beyond it must have room for a line.
///
/// # Errors
///
/// [`BoxMismatch`] where the print does not lie where the part does.
pub fn check_box(slot: &SlotMesh, sliced: &SlicedPrint<'_>, profile: &Profile) -> Result<(), BoxMismatch> {
    let (width, height) = (profile.process.line_width_mm, usual_step(sliced));
    let mut missing: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
    let sections = Sections::of(&slot.mesh);
    for (layer, middle) in middles(sliced) {
        let Some(section) = extent(&sections.segments_at(middle)) else { continue };
        let extruded = &layer.extrusion;
        for (axis, name) in [(0, "x"), (1, "y")] {
            let over = (section.min[axis] - extruded.min[axis]).max(extruded.max[axis] - section.max[axis]);
            if over > width / 2.0 {
                let shift = extruded.centre() - section.centre();
                return Err(BoxMismatch::Beyond {
                    z: layer.z,
                    axis: name,
                    beyond_mm: over,
                    shift_x: shift.x,
                    shift_y: shift.y,
                });
            }
            let short = (extruded.min[axis] - section.min[axis]).max(section.max[axis] - extruded.max[axis]);
            missing[axis].push(short - width / 2.0);
        }
    }
    let tips_only = |axis: usize| tips_only(&sections, sliced, axis, width);
    if missing[0].is_empty() {
        return Err(BoxMismatch::Height { top: sliced.extrusion.max.z, height: slot.mesh.bounds().max.z });
    }
    for (axis, name) in [(0, "x"), (1, "y")] {
        missing[axis].sort_by(f64::total_cmp);
        let short_mm = missing[axis].get(missing[axis].len() / 2).copied().unwrap_or(f64::INFINITY);
        if short_mm > 2.0 * width && !tips_only(axis) {
            return Err(BoxMismatch::Short { axis: name, short_mm, allowed_mm: 2.0 * width });
        }
    }
    check_height(slot, sliced, &sections, width, height)
}

/// Whether on more than half of the layers all that lies farther along an axis than the extrusion, by more than may be missing, is thinner
/// than a line.
fn tips_only(sections: &Sections, sliced: &SlicedPrint<'_>, axis: usize, width: f64) -> bool {
    let (mut wide, mut layers) = (0, 0);
    for (layer, middle) in middles(sliced) {
        let section = sections.at(middle);
        if section.is_empty() {
            continue;
        }
        layers += 1;
        let [low, high] = section.bounds();
        let (from, to) = (layer.extrusion.min[axis] - 2.5 * width, layer.extrusion.max[axis] + 2.5 * width);
        let beyond = [[low[axis], from], [to, high[axis]]];
        wide += usize::from(beyond.into_iter().any(|range| has_room(&section, axis, range, width)));
    }
    2 * wide < layers
}

/// Whether a section has room for a line of this width with its middle between two places along an axis; yes, where that is not ruled out.
fn has_room(section: &Section, axis: usize, [from, to]: [f64; 2], width: f64) -> bool {
    let [low, high] = section.bounds();
    let across = 1 - axis;
    let steps = |from: f64, to: f64| ((to - from) / ROOM_STEP_MM).ceil() as usize;
    let mut search = section.search();
    from < to
        && (0..=steps(from, to)).any(|i| {
            (0..=steps(low[across], high[across])).any(|k| {
                let mut at = [0.0; 2];
                at[axis] = (from + i as f64 * ROOM_STEP_MM).min(to);
                at[across] = low[across] + k as f64 * ROOM_STEP_MM;
                // Nothing lies farther from a place of this grid, and the distance grows no faster than the way.
                search.signed_distance(at) - ROOM_STEP_MM * std::f64::consts::FRAC_1_SQRT_2 <= -width / 2.0
            })
        })
}

/// Each layer with the height of its middle, mm.
fn middles<'a>(sliced: &'a SlicedPrint<'_>) -> impl Iterator<Item = (&'a Layer, f64)> {
    let most = 2.0 * usual_step(sliced);
    let mut below = 0.0;
    sliced.layers.iter().map(move |layer| {
        let thickness = (layer.z - below).clamp(0.01, most);
        below = layer.z;
        (layer, layer.z - thickness / 2.0)
    })
}

/// The median step from layer to layer, mm: the file's own layer height, whatever it was sliced with.
fn usual_step(sliced: &SlicedPrint<'_>) -> f64 {
    let mut steps: Vec<f64> = sliced.layers.windows(2).map(|pair| (pair[1].z - pair[0].z).abs()).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(sliced.layers[0].z).max(0.01)
}

fn check_height(
    slot: &SlotMesh,
    sliced: &SlicedPrint<'_>,
    sections: &Sections,
    width: f64,
    layer: f64,
) -> Result<(), BoxMismatch> {
    let height = slot.mesh.bounds().max.z;
    let top = sliced.extrusion.max.z;
    let printable = |z: f64| thinnest(&sections.segments_at(z)) > 2.0 * width;
    let mut expected = height;
    while expected > 0.0 && !printable(expected - layer / 2.0) {
        expected -= layer;
    }
    let wrong = top > height + layer || top < expected - 2.0 * layer;
    if wrong { Err(BoxMismatch::Height { top, height }) } else { Ok(()) }
}

/// The box of a cross-section; `None` for none.
fn extent(segments: &[Segment]) -> Option<Bounds> {
    let bounds = Bounds::of(segments.iter().flatten().map(|&[x, y]| Vec3::new(x, y, 0.0)));
    (!bounds.is_empty()).then_some(bounds)
}

/// The least width of a cross-section across any of its edges, mm; 0 where there is none. A ridge is thin whichever way it
/// runs, though the box around it may be wide.
fn thinnest(segments: &[Segment]) -> f64 {
    let across = |[a, b]: &Segment| {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = (dx * dx + dy * dy).sqrt();
        let along = |p: &[f64; 2]| (p[0] * dy - p[1] * dx) / length;
        let all = segments.iter().flatten().map(along);
        let [low, high] = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        (length > 1e-9).then_some(high - low)
    };
    segments.iter().filter_map(across).reduce(f64::min).unwrap_or(0.0)
}
