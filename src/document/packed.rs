//! Packings: runs with their pieces.

use serde_json::{Value, json};

use crate::job::{Coarsened, PackResult, Piece, Plate};
use crate::pack::{Ended, PackGoal};

/// `trunnion pack`. `origin_mm` is where the file's origin comes, or a box's low corner, turned by `turn_deg` about `axis`;
/// `lift_order` and `locked` are places in `items`.
pub fn packed(done: &PackResult) -> Value {
    let item = |piece: &Piece| {
        json!({
            "model": piece.name, "index": piece.model, "copy": piece.copy, "origin_mm": piece.origin_mm.as_slice(),
            "turn_deg": piece.turn_deg, "axis": piece.axis.as_slice(),
            "box_mm": [piece.bounds.min.as_slice(), piece.bounds.max.as_slice()],
        })
    };
    let plate = |(index, plate): (usize, &Plate)| {
        json!({
            "file": PackResult::file(index), "fill": plate.fill,
            "items": plate.pieces.iter().map(item).collect::<Vec<_>>(),
            "lift_order": plate.lift_order, "locked": plate.locked,
        })
    };
    let ended = match done.ended {
        Ended::Proved => "proved",
        Ended::Steps => "steps",
        Ended::Time => "time",
        Ended::Interrupted => "interrupted",
    };
    let left = |(name, count): &(String, usize)| json!({"model": name, "copies": count});
    let mut all = json!({
        "plates": done.plates.iter().enumerate().map(plate).collect::<Vec<_>>(),
        "runs": done.plates.len(), "lower_bound": if done.goal == PackGoal::Runs { done.bound as u64 } else { 1 },
        "goal": match done.goal {
            PackGoal::Runs => "runs",
            PackGoal::Filling => "filling",
            PackGoal::Height => "height",
        },
        "ended": ended, "interrupted": done.interrupted(), "method": done.method,
        "space_mm": done.space_mm, "gap_mm": done.gap_mm, "clearance_mm": done.clearance_mm,
        "left_out": done.left_out.iter().map(left).collect::<Vec<_>>(), "seconds": done.seconds,
        "seconds_reading": done.reading_s, "seconds_testing": done.testing_s,
    });
    if done.goal == PackGoal::Filling {
        all["value"] = json!(done.value);
        all["value_upper_bound"] = json!(done.bound);
    }
    if let Some(Coarsened { facets, packed_facets, raised_mm }) = done.inflated {
        all["inflated"] = json!({"facets": facets, "packed_facets": packed_facets, "raised_mm": raised_mm});
    }
    if done.goal == PackGoal::Height {
        all["height_mm"] = json!(done.space_mm[2]);
        all["height_lower_bound_mm"] = json!(done.bound);
    }
    all
}
