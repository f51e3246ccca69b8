//! What of a line is there: stretches along it, mm, found by going along it so closely that nothing is passed over.

use crate::section::march;

/// A line's ends, mm.
pub(super) type Line = [[f64; 2]; 2];

/// Stretches of a line, from where to where, mm; those of a sheet from the middle of its cell.
pub(super) type Spans = Vec<[f64; 2]>;

/// Shorter lines are left out, in widths: they would not stick.
pub(super) const SHORTEST_WIDTHS: f64 = 3.0;
/// The same for what stands on the part, in whose slopes each layer has no more than a strip.
pub(super) const SHORTEST_ON_PART_WIDTHS: f64 = 2.0;

/// Where on the way from `a` to `b` a measure is not below 0, as lengths from `a`; it changes by no more than the way does.
pub(super) fn where_above([a, b]: [[f64; 2]; 2], measure: impl Fn([f64; 2]) -> f64) -> Spans {
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let (mut spans, mut from) = (Spans::new(), None);
    for (t, room) in march([a, b], measure) {
        match (room >= 0.0, from) {
            (true, None) => from = Some(t),
            (false, Some(start)) => {
                spans.push([start, t]);
                from = None;
            }
            _ => {}
        }
    }
    spans.extend(from.filter(|start| *start < length).map(|start| [start, length]));
    spans
}

/// Spans that overlap made one, upward.
pub(super) fn joined(mut spans: Spans) -> Spans {
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut all = Spans::new();
    for [from, to] in spans {
        match all.last_mut() {
            Some(last) if from <= last[1] => last[1] = last[1].max(to),
            _ => all.push([from, to]),
        }
    }
    all
}

/// What two lists of spans share.
pub(super) fn shared(a: &Spans, b: &Spans) -> Spans {
    let both = a.iter().flat_map(|x| b.iter().map(move |y| [x[0].max(y[0]), x[1].min(y[1])]));
    both.filter(|[from, to]| from < to).collect()
}
