//! The height at which a part's first layer really begins: slicers print whole layers, so that what carries it ends up to half a
//! layer below or above its model's top.
//!
//! The rewriter makes the first layer so much thicker or thinner, and verification expects it: both ask here. Only faces across
//! the build direction matter; the sides of a print are as true as its lines.

use super::workpiece::Workpiece;
use crate::geom::Vec3;

/// A part as it was printed.
#[derive(Clone, Copy, Debug)]
pub struct Printed {
    /// The part.
    pub part: usize,
    /// Its build direction, table frame.
    pub up: Vec3,
    /// Its last layer's top above its lowest point, along `up`, mm.
    pub height_mm: f64,
}

/// How parallel directions and faces must be, as a cosine: 0.8 degrees, within what a layer bridges on any interface.
const PARALLEL: f64 = 0.9999;
/// How much the tops of several carriers may differ, and how far below its carrier's top a part may begin, mm.
const ALIKE_MM: f64 = 0.02;

/// From the real top of what carries `part` to the part's own lowest point along `up`, mm: positive where there is a gap, negative
/// where the carrier was printed too high, 0 where nothing is known to carry it from below. A carrier that goes on beside the part, above
/// where that begins, says nothing: only its top is known.
///
/// `printed` are the parts before it.
pub fn joint_gap_mm(workpiece: &Workpiece<'_>, part: usize, up: Vec3, printed: &[Printed]) -> f64 {
    if workpiece.model.is_in_place(part) {
        return 0.0;
    }
    let bottom = lowest(workpiece, part, up);
    let gap = |carrier: &Printed| bottom - (lowest(workpiece, carrier.part, up) + carrier.height_mm);
    let ends_there = |carrier: usize| (-lowest(workpiece, carrier, -up) - bottom).abs() < ALIKE_MM;
    let carries =
        |p: &&Printed| p.up.dot(&up) > PARALLEL && ends_there(p.part) && faces_up(workpiece, p.part, part, up);
    let gaps: Vec<f64> = printed.iter().filter(carries).map(gap).collect();
    let (low, high) = gaps.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), g| (l.min(*g), h.max(*g)));
    if gaps.is_empty() || high - low > ALIKE_MM { 0.0 } else { (low + high) / 2.0 }
}

fn lowest(workpiece: &Workpiece<'_>, part: usize, up: Vec3) -> f64 {
    workpiece.parts[part].vertices().iter().map(|v| v.dot(&up)).fold(f64::INFINITY, f64::min)
}

/// Whether the two share a face that looks from `below` along `up`.
fn faces_up(workpiece: &Workpiece<'_>, below: usize, above: usize, up: Vec3) -> bool {
    workpiece.model.interfaces.iter().any(|one| {
        let normal = workpiece.placed.rotation * one.normal;
        (one.a, one.b) == (below, above) && normal.dot(&up) > PARALLEL
            || (one.b, one.a) == (below, above) && normal.dot(&up) < -PARALLEL
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;
    use crate::mesh::Model;

    #[test]
    fn a_box_on_a_box_begins_where_the_lower_one_was_printed_to() {
        let lower = solid_box(Vec3::zeros(), Vec3::new(10.0, 10.0, 10.08));
        let upper = solid_box(Vec3::new(0.0, 0.0, 10.08), Vec3::new(10.0, 10.0, 15.0));
        let beside = solid_box(Vec3::new(10.0, 0.0, 2.0), Vec3::new(15.0, 10.0, 8.0));
        let parts = vec![("a".to_owned(), lower), ("b".to_owned(), upper), ("c".to_owned(), beside)];
        let model = Model::from_parts(parts);
        let workpiece = Workpiece::place(&model, &Workpiece::centred(&model));
        let printed = |height_mm| [Printed { part: 0, up: Vec3::z(), height_mm }];
        let gap = |part, up, height| joint_gap_mm(&workpiece, part, up, &printed(height));
        assert!((gap(1, Vec3::z(), 10.0) - 0.08).abs() < 1e-9 && (gap(1, Vec3::z(), 10.2) + 0.12).abs() < 1e-9);
        assert_eq!(
            (gap(2, Vec3::x(), 10.0), gap(0, Vec3::z(), 10.0)),
            (0.0, 0.0),
            "a side is true; the table is no print"
        );
        assert_eq!(joint_gap_mm(&workpiece, 1, Vec3::z(), &[]), 0.0);
    }

    #[test]
    fn a_step_of_what_goes_on_above_says_nothing() {
        // A stair of 4 and 10.08 mm, a box on each of its steps.
        let outline = [[0.0, 0.0], [20.0, 0.0], [20.0, 4.0], [10.0, 4.0], [10.0, 10.08], [0.0, 10.08]];
        let stair = crate::fixtures::prism(&outline, [0.0, 10.0]);
        let high = solid_box(Vec3::new(0.0, 0.0, 10.08), Vec3::new(10.0, 10.0, 15.0));
        let low = solid_box(Vec3::new(10.0, 0.0, 4.0), Vec3::new(20.0, 10.0, 8.0));
        let parts = [("stair", stair), ("high", high), ("low", low)].map(|(name, mesh)| (name.to_owned(), mesh));
        let model = Model::from_parts(parts.into());
        let workpiece = Workpiece::place(&model, &Workpiece::centred(&model));
        let printed = [Printed { part: 0, up: Vec3::z(), height_mm: 10.0 }];
        let gap = |part| joint_gap_mm(&workpiece, part, Vec3::z(), &printed);
        assert!((gap(1) - 0.08).abs() < 1e-9 && gap(2) == 0.0, "{} and {}", gap(1), gap(2));
    }
}
