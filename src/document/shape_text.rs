//! What is packed and held, for people.

use std::fmt::Write;

use crate::job::{Coarsened, PackResult, SupportResult};
use crate::pack::PackGoal;
use crate::spelling::counted;

/// The result for people.
pub fn packed(done: &PackResult) -> String {
    let mut out = String::new();
    for (index, plate) in done.plates.iter().enumerate() {
        let _ = write!(out, "{}: {}, ", PackResult::file(index), counted(plate.pieces.len(), "piece"));
        let _ = write!(out, "{:.1} % of the space", 100.0 * plate.fill);
        if !plate.locked.is_empty() {
            let _ = write!(out, ", {} of them not shown to lift straight out", plate.locked.len());
        }
        let _ = writeln!(out);
    }
    let pieces: usize = done.plates.iter().map(|plate| plate.pieces.len()).sum();
    let pieces = counted(pieces, "piece");
    let _ = match done.goal {
        PackGoal::Runs => {
            writeln!(out, "{pieces} in {} (lower bound: {})", counted(done.plates.len(), "run"), done.bound)
        }
        PackGoal::Filling => {
            writeln!(out, "{pieces} with a total value of {:.3} (upper bound: {:.3})", done.value, done.bound)
        }
        PackGoal::Height => {
            writeln!(out, "{pieces} in a height of {:.3} mm (lower bound: {:.3} mm)", done.space_mm[2], done.bound)
        }
    };
    if let Some(coarse) = done.inflated {
        let Coarsened { facets, packed_facets, raised_mm } = coarse;
        let _ = writeln!(
            out,
            "packed with {packed_facets} facets instead of {facets}, raised by at most {raised_mm:.3} mm"
        );
    }
    for (name, count) in &done.left_out {
        let _ = writeln!(out, "left out: {count} of {name}");
    }
    let _ = writeln!(out, "{} after {:.2} s by {}", done.end(), done.seconds, done.method);
    if let Some(limit) = done.limit_s.filter(|limit| done.reading_s + done.testing_s > *limit) {
        let (reading, testing) = (done.reading_s, done.testing_s);
        let _ = writeln!(out, "longer than {limit} s: reading took {reading:.2} s and the exact test {testing:.2} s");
    }
    out
}

/// The result for people.
pub fn supported(done: &SupportResult) -> String {
    let SupportResult { count, planned, built, cover, .. } = done;
    let (tally, mut out) = (&planned.tally, String::new());
    if count.red == 0 && done.bare.is_empty() {
        return "nothing overhangs: no support is needed".to_owned();
    }
    let [nx, ny, nz] = done.graph.grid.size;
    let _ = writeln!(
        out,
        "grid {nx} x {ny} x {nz}: {} nodes, {} arcs, {} cells need support, {} can stand on the ground",
        count.nodes, count.arcs, count.red, count.green
    );
    let _ = writeln!(
        out,
        "{}: cost {} (lower bound: {}), {} arcs used (lower bound: {}), total length {:.0} mm, {} arcs and nodes over capacity, planned in {:.2} s",
        done.method,
        tally.cost,
        planned.lower_bound,
        tally.used_arcs(),
        planned.fewest_arcs,
        tally.length_mm(done.graph.grid.step_mm),
        tally.over_capacity,
        done.seconds_plan
    );
    let _ = writeln!(
        out,
        "{:.1} mm3 of support{}, {:.1} % of {:.1} mm2 supported, contact {:.1} mm2, on the ground {:.1} mm2, longest free column {:.1} mm; \
         {:.2} s",
        built.volume_mm3,
        beside_columns(done),
        100.0 * cover.share(),
        cover.area_mm2,
        built.contact_mm2,
        built.plate_mm2,
        done.longest_free_mm,
        done.seconds
    );
    out
}

/// What there is beside columns, in words with a comma before them.
fn beside_columns(done: &SupportResult) -> String {
    let bars = (done.built.bars > 0).then(|| format!(", {}", counted(done.built.bars, "roof bar")));
    let struts = (done.struts > 0).then(|| format!(", {}", counted(done.struts, "strut piece")));
    bars.into_iter().chain(struts).collect()
}
