//! What a model is made of, and what becomes of it when it is cut.

use serde_json::{Value, json};

use crate::job::{ConvexResult, GivenCut, HullOfPiece, SplitResult};
use crate::mesh::{Interface, Model, Neighbours, Part};
use crate::split::{CutMade, CutPart, PatchLeft, Unsupported};

/// Patches smaller than this are rounding, mm²: they count in the sums and are not listed.
const WORTH_LISTING_MM2: f64 = 0.01;

/// `trunnion inspect`: parts, interfaces, what stands on the table.
pub fn inspected(model: &Model) -> Value {
    let part = |p: &Part| {
        let b = p.mesh.bounds();
        json!({
            "id": p.id, "name": p.name, "facets": p.mesh.facets().len(), "closed": true,
            "volume_mm3": p.mesh.volume(), "area_mm2": p.mesh.area(),
            "box_mm": [b.min.as_slice(), b.max.as_slice()],
        })
    };
    let interface = |i: &Interface| json!({"a": i.a, "b": i.b, "area_mm2": i.area_mm2, "normal": i.normal.as_slice()});
    json!({
        "unit": model.unit.short(),
        "parts": model.parts.iter().map(part).collect::<Vec<_>>(),
        "interfaces": model.interfaces.iter().map(interface).collect::<Vec<_>>(),
        "on_table": model.on_table,
        "captive": model.captive,
        "floating": model.floating(),
        "apart": apart(model).iter().map(|(part, (other, mm))| json!({"part": part, "nearest": other, "mm": mm})).collect::<Vec<_>>(),
        "others": model.others.iter().map(|other| json!({"name": other.name, "role": other.role})).collect::<Vec<_>>(),
        "warnings": model.warnings,
    })
}

/// The parts that hang together with nothing that stands, each with the part nearest to it and the distance, mm.
pub(super) fn apart(model: &Model) -> Vec<(usize, (usize, f64))> {
    let floating = model.floating();
    if floating.is_empty() {
        return Vec::new();
    }
    let neighbours = Neighbours::of(&model.parts);
    floating.into_iter().filter_map(|part| Some((part, neighbours.nearest(part)?))).collect()
}

/// `trunnion split --convex`: the pieces with the size of their hulls.
pub fn convex(done: &ConvexResult) -> Value {
    let piece = |piece: &HullOfPiece| {
        let corners = piece.box_mm();
        json!({
            "name": piece.name, "part": piece.part, "facets": piece.facets, "concavity_mm": piece.concavity_mm,
            "volume_mm3": piece.volume_mm3, "flat": piece.is_flat(), "box_mm": corners.each_ref().map(|p| p.as_slice()),
        })
    };
    json!({
        "pieces": done.pieces.iter().map(piece).collect::<Vec<_>>(),
        "concavity_mm": done.concavity_mm, "model_volume_mm3": done.volume_mm3, "seconds": done.seconds,
    })
}

/// `trunnion split`: planes, parts in the order of printing, what needs support before and after.
pub fn split(done: &SplitResult) -> Value {
    let split = &done.split;
    let plane = |cut: &CutMade| {
        json!({
            "normal": cut.plane.normal.as_slice(), "offset_mm": cut.plane.offset_mm, "part": cut.parts.first(),
            "parts": cut.parts, "seam_mm2": cut.seam_mm2, "gain_mm2": cut.gain_mm2, "reason": cut.reason(),
            "pin": GivenCut::of(cut).words(),
        })
    };
    let called = done.model.called(0);
    let order = |(id, part): (usize, &CutPart)| {
        json!({
            "part": id, "name": split.name_of(&called, id), "up": part.up.as_slice(), "cut": part.cut,
            "volume_mm3": part.mesh.volume(), "needs_support": needs(&part.needs),
        })
    };
    let left = |p: &PatchLeft| json!({"part": p.part, "area_mm2": p.area_mm2, "at_mm": p.at.as_slice()});
    let worth_a_word = split.left.iter().filter(|p| p.area_mm2 > WORTH_LISTING_MM2);
    json!({
        "planes": split.cuts.iter().map(plane).collect::<Vec<_>>(),
        "parts": split.parts.len(),
        "order": split.parts.iter().enumerate().map(order).collect::<Vec<_>>(),
        "needs_support_mm2": {"before": split.before.area_mm2, "after": split.after.area_mm2},
        "needs_support": {"before": needs(&split.before), "after": needs(&split.after)},
        "left": worth_a_word.map(left).collect::<Vec<_>>(),
        "seam_mm2": split.seam_mm2(), "setups": split.setups(), "pedestal_mm": done.pedestal_mm, "stood": done.stood,
        "printable": split.printable, "reasons": done.why_not().iter().map(ToString::to_string).collect::<Vec<_>>(),
        "code": done.why_not().map(|why| why.code()), "refused_cut": split.unpinned.map(|(place, _)| place),
        "seconds": done.seconds,
    })
}

fn needs(needs: &Unsupported) -> Value {
    json!({"area_mm2": needs.area_mm2, "beginnings": needs.beginnings, "ridges": needs.ridges})
}
