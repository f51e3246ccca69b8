//! A print's mesh as the slicer gets it, and the check that what comes back is that mesh, where it was put.

use crate::gcode::round_to;
use crate::geom::{Bounds, Rigid, Slot, Vec3};
use crate::mesh::TriangleMesh;
use crate::motion::TableKinematics;
use crate::planning::{Print, Workpiece};
use crate::profile::Profile;

use super::sliced::SlicedPrint;

/// A part turned upright, its lowest point at z = 0, centred on the slicer's bed.
pub struct SlotMesh {
    /// The part, slot frame.
    pub mesh: TriangleMesh<Slot>,
    /// What takes slot coordinates to the machine's, mm, whole microns.
    pub to_machine: Vec3,
    /// Whether it stands on the table.
    pub on_table: bool,
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
    SlotMesh {
        mesh: turned.moved(&Rigid::<Slot, Slot>::shift(export)),
        to_machine,
        on_table: upright && workpiece.model.on_table.contains(&print.part),
    }
}

/// Room between objects of a project, mm: more than any slicer's clearance between objects printed one by one.
const PROJECT_GAP_MM: f64 = 120.0;

/// Where the prints of a plan stand in the project that holds them all (one object each, printed one by one), and the
/// bed that takes them: rows along X.
pub fn project_layout(sizes: &[Vec3]) -> (Vec<[f64; 2]>, [f64; 2]) {
    let cell = sizes.iter().map(|s| s.x.max(s.y)).fold(0.0, f64::max).ceil() + PROJECT_GAP_MM;
    let columns = (sizes.len() as f64).sqrt().ceil().max(1.0) as usize;
    let rows = sizes.len().div_ceil(columns);
    let centre = |i: usize| [(i % columns) as f64 * cell + cell / 2.0, (i / columns) as f64 * cell + cell / 2.0];
    ((0..sizes.len()).map(centre).collect(), [columns as f64 * cell, rows as f64 * cell])
}

/// What was sliced is not the mesh that was handed over, or not where it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BoxMismatch {
    /// Extrusion beside the part.
    #[error(
        "extrusion at z {z:.2} mm reaches {beyond_mm:.2} mm beyond the part in {axis} (its middle lies {shift_x:+.2}, {shift_y:+.2} mm off); the part was moved, turned or scaled in the slicer, or it prints a skirt, a brim or supports: switch those off and leave the part where it was"
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
    /// The wrong height.
    #[error(
        "extrusion ends at z {top:.2} mm, the part at {height:.2} mm; it was scaled, sunk or cut in the slicer (or is thinner than a line further up)"
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
/// slicer's. Sharp tips thinner than a line are not printed by any slicer; hence the median for what is missing.
pub(super) fn check_box(slot: &SlotMesh, sliced: &SlicedPrint<'_>, profile: &Profile) -> Result<(), BoxMismatch> {
    let (width, height) = (profile.process.line_width_mm, profile.process.layer_height_mm);
    let mut missing: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
    let mut below = 0.0;
    let mut sections = Sections::of(&slot.mesh);
    for layer in &sliced.layers {
        let thickness = (layer.z - below).clamp(0.01, 2.0 * height);
        below = layer.z;
        let Some(section) = sections.extent(layer.z - thickness / 2.0) else { continue };
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
    for (axis, name) in [(0, "x"), (1, "y")] {
        missing[axis].sort_by(f64::total_cmp);
        let short_mm = missing[axis].get(missing[axis].len() / 2).copied().unwrap_or(f64::INFINITY);
        if short_mm > 2.0 * width {
            return Err(BoxMismatch::Short { axis: name, short_mm, allowed_mm: 2.0 * width });
        }
    }
    check_height(slot, sliced, &mut sections, (width, height))
}

fn check_height(
    slot: &SlotMesh,
    sliced: &SlicedPrint<'_>,
    sections: &mut Sections,
    (width, layer): (f64, f64),
) -> Result<(), BoxMismatch> {
    let height = slot.mesh.bounds().max.z;
    let top = sliced.extrusion.max.z;
    let mut printable = |z: f64| sections.extent(z).is_some_and(|s| s.size().x.min(s.size().y) > 2.0 * width);
    let mut expected = height;
    while expected > 0.0 && !printable(expected - layer / 2.0) {
        expected -= layer;
    }
    let wrong = top > height + layer || top < expected - 2.0 * layer;
    if wrong { Err(BoxMismatch::Height { top, height }) } else { Ok(()) }
}

/// The mesh's cross-sections, one after the other: quickest from the lowest up.
struct Sections {
    /// Corners, the facet with the lowest first.
    facets: Vec<[Vec3; 3]>,
    /// Those that begin at or below `z`.
    begun: usize,
    /// Those of them that do not end below it.
    active: Vec<usize>,
    z: f64,
}

impl Sections {
    fn of(mesh: &TriangleMesh<Slot>) -> Self {
        let mut facets: Vec<[Vec3; 3]> = (0..mesh.facets().len()).map(|facet| mesh.corners(facet)).collect();
        facets.sort_by(|a, b| lowest(a).total_cmp(&lowest(b)));
        Self { facets, begun: 0, active: Vec::new(), z: f64::NEG_INFINITY }
    }

    /// The box of the cross-section at `z`; `None` where there is none.
    fn extent(&mut self, z: f64) -> Option<Bounds> {
        if z < self.z {
            self.begun = 0;
            self.active.clear();
        }
        self.z = z;
        while self.facets.get(self.begun).is_some_and(|facet| lowest(facet) <= z) {
            self.active.push(self.begun);
            self.begun += 1;
        }
        let facets = &self.facets;
        self.active.retain(|facet| facets[*facet].iter().any(|corner| corner.z >= z));
        let mut bounds = Bounds::EMPTY;
        for corners in self.active.iter().map(|facet| &facets[*facet]) {
            for i in 0..3 {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                if (a.z > z) != (b.z > z) {
                    bounds.add(a + (b - a) * ((z - a.z) / (b.z - a.z)));
                }
            }
        }
        (!bounds.is_empty()).then_some(bounds)
    }
}

fn lowest(corners: &[Vec3; 3]) -> f64 {
    corners[0].z.min(corners[1].z).min(corners[2].z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_in_any_order_are_those_of_all_facets() {
        let corner = |i: u32| Vec3::new(f64::from(i * 7 % 13), f64::from(i * 5 % 11), f64::from(i * 3 % 17));
        let mesh: TriangleMesh<Slot> =
            TriangleMesh::new((0..40).map(corner).collect(), (0..38).map(|i| [i, i + 1, i + 2]).collect());
        let mut sections = Sections::of(&mesh);
        for z in [0.5, 3.0, 16.0, 16.5, 8.0, 8.0, -1.0, 2.5, 17.0] {
            let all = (0..38).flat_map(|facet| {
                let c = mesh.corners(facet);
                [(c[0], c[1]), (c[1], c[2]), (c[2], c[0])]
            });
            let cut = all.filter(|(a, b)| (a.z > z) != (b.z > z));
            let wanted = Bounds::of(cut.map(|(a, b)| a + (b - a) * ((z - a.z) / (b.z - a.z))));
            assert_eq!(sections.extent(z), (!wanted.is_empty()).then_some(wanted), "{z}");
        }
    }
}
