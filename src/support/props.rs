//! Props: sheets straight below single places, down to the table or to what the part has there, for what columns of a grid do not reach.
//!
//! Slot frame, mm. A place is a box in one layer. Below it stand upright sheets one line wide: along its longer side at the pitch, and
//! across, to keep those upright and to hold what lies along them, at twice that; all at whole multiples of it, so that those of neighbouring places are the same ones.
//! Where it is said of a place, one goes through its middle, too. In each layer a sheet has what it has room for beside the part, a gap below what it holds, and what
//! stands in the layer below, on the table or on the part, which may lie up to three layers deeper: on a slope each layer has no more than a strip, and
//! what is too short to be laid grows with the next ones. So no more than a line's least length begins over air, and two layers of air are enough for one.

use super::clear::{Cuts, SAME_MM};
use super::lines::{Air, SupportLayer};
use super::spans::{SHORTEST_ON_PART_WIDTHS, SHORTEST_WIDTHS, Spans, joined, shared, where_above};
use crate::section::Segments;

/// A place that is held from straight below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prop {
    /// The underside of its layer, mm.
    pub under_mm: f64,
    /// Its box, seen from above, mm: the lower and the upper corner.
    pub within_mm: [[f64; 2]; 2],
    /// Whether a sheet goes through its middle.
    pub middle: bool,
}

/// Sheets across stand so many times as far apart as the others: they keep these upright, and hold lines that lie along them.
const ACROSS: f64 = 2.0;
/// A sheet goes on so far beyond what it holds, in widths: below a point, too, it is long enough to stick.
const BEYOND_WIDTHS: f64 = 1.6;
/// On the table a sheet has lines beside it, so far from its own, in widths: one alone sticks too little.
const FEET_WIDTHS: f64 = 1.0;

/// A sheet: the axis that it goes along, and where across it stands.
struct Sheet {
    axis: usize,
    at: f64,
    /// What is asked of it: up to which height, and from where to where.
    asked: Vec<(f64, Spans)>,
    /// What it had in the layer below.
    there: Spans,
}

/// Adds the sheets below `props` to the lines of `layers`, which are those of `cuts`; clear of what these have.
pub fn propped(layers: &mut Vec<SupportLayer>, props: &[Prop], cuts: &Cuts, pitch_mm: f64) {
    let (spans, how) = (cuts.spans(), &cuts.how);
    let highest = props.iter().map(|prop| prop.under_mm).fold(f64::NEG_INFINITY, f64::max);
    let within = spans.iter().take_while(|span| span[0] <= highest + how.gap_mm + SAME_MM).count();
    let mut sheets = sheets(props, cuts, pitch_mm);
    for (k, span_mm) in spans[..within].iter().enumerate() {
        let air = Air { keeps: cuts.around(k), under: cuts.under(k), how, roof: Segments::new(Vec::new()) };
        let shortest = how.line_mm * if k == 0 { SHORTEST_WIDTHS } else { SHORTEST_ON_PART_WIDTHS };
        let mut lines = Vec::new();
        for sheet in &mut sheets {
            let asked = sheet.asked.iter().filter(|(top, _)| span_mm[1] <= top + SAME_MM);
            let asked = joined(asked.flat_map(|(_, spans)| spans.clone()).collect());
            let free = sheet.free(&asked, &|p| air.room(p));
            let stands = match k {
                0 => free,
                _ => {
                    let mut below = sheet.free(&asked, &|p| air.carried(p));
                    below.extend(sheet.there.iter().copied());
                    shared(&free, &joined(below))
                }
            };
            // What is too short to be laid is kept: it grows where the part has a slope. On the table nothing grows.
            let is_laid = |span: &&[f64; 2]| span[1] - span[0] >= shortest;
            sheet.there = stands.iter().filter(|span| k > 0 || is_laid(span)).copied().collect();
            lines.extend(stands.iter().filter(is_laid).map(|span| span.map(|t| sheet.point(t))));
            if k == 0 {
                for side in [-FEET_WIDTHS, FEET_WIDTHS].map(|widths| widths * how.line_mm) {
                    let foot = Sheet { axis: sheet.axis, at: sheet.at + side, asked: Vec::new(), there: Vec::new() };
                    let free = foot.free(&sheet.there, &|p| air.room(p)).into_iter().filter(|[a, b]| b - a >= shortest);
                    lines.extend(free.map(|span| span.map(|t| foot.point(t))));
                }
            }
        }
        if let Some(layer) = layers.get_mut(k) {
            layer.lines.extend(lines);
        } else {
            layers.push(SupportLayer { span_mm: *span_mm, lines });
        }
    }
    while layers.last().is_some_and(|layer| layer.lines.is_empty()) {
        layers.pop();
    }
}

/// The sheets below some places.
fn sheets(props: &[Prop], cuts: &Cuts, pitch_mm: f64) -> Vec<Sheet> {
    let (spans, how) = (cuts.spans(), &cuts.how);
    let mut sheets: Vec<Sheet> = Vec::new();
    for prop in props {
        // The layer whose underside it is.
        let layer = spans.partition_point(|span| (span[0] + span[1]) / 2.0 < prop.under_mm);
        if layer >= spans.len() {
            continue;
        }
        let held = cuts.layer(layer);
        let [low, high] = prop.within_mm;
        let longer = usize::from(high[1] - low[1] > high[0] - low[0]);
        let at = |axis: usize, every: f64| {
            let (across, pitch) = (1 - axis, pitch_mm * every);
            let [first, last] = [(low[across] / pitch).ceil() as i64, (high[across] / pitch).floor() as i64];
            (first..=last).map(move |k| (axis, k as f64 * pitch))
        };
        let middle = |axis: usize| (axis, f64::midpoint(low[1 - axis], high[1 - axis]));
        let mut places: Vec<(usize, f64)> = at(longer, 1.0).chain(prop.middle.then(|| middle(longer))).collect();
        if places.is_empty() {
            continue;
        }
        let along = places.len();
        places.extend(at(1 - longer, ACROSS));
        if places.len() == along {
            places.push(middle(1 - longer));
        }
        for (axis, at) in places {
            let beyond = BEYOND_WIDTHS * how.line_mm;
            let sheet = Sheet { axis, at, asked: Vec::new(), there: Vec::new() };
            let whole = vec![[low[axis] - beyond, high[axis] + beyond]];
            let nearest = |p: [f64; 2]| held.iter().map(|s| s.signed_distance(p)).fold(f64::INFINITY, f64::min);
            let asked = sheet.free(&whole, &|p| BEYOND_WIDTHS * how.line_mm - nearest(p));
            let one = (prop.under_mm - how.gap_mm, asked);
            let near = |other: &&mut Sheet| other.axis == axis && (other.at - at).abs() < how.line_mm;
            match sheets.iter_mut().find(near) {
                Some(known) => known.asked.push(one),
                None => sheets.push(Sheet { asked: vec![one], ..sheet }),
            }
        }
    }
    sheets
}

impl Sheet {
    /// The place at `t` mm along it.
    fn point(&self, t: f64) -> [f64; 2] {
        if self.axis == 0 { [t, self.at] } else { [self.at, t] }
    }

    /// Where within some stretches a measure is not below 0.
    fn free(&self, stretches: &Spans, measure: &dyn Fn([f64; 2]) -> f64) -> Spans {
        let of_one = |[a, b]: &[f64; 2]| {
            let from = *a;
            where_above([self.point(*a), self.point(*b)], measure).into_iter().map(move |s| s.map(|t| t + from))
        };
        stretches.iter().flat_map(of_one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{prism, solid_box};
    use crate::geom::{Rigid, Slot, Vec3};
    use crate::mesh::TriangleMesh;
    use crate::overhang::Keels;
    use crate::support::clear::{Around, Clearance};
    use crate::support::laying::Clear;

    /// A plate, and `air_mm` above it a shelf that a post at one end holds.
    fn shelf(air_mm: f64) -> TriangleMesh<Slot> {
        let boxes = [
            ([-10.0, -5.0, 0.0], [10.0, 5.0, 2.0]),
            ([-10.0, -5.0, 2.0], [-7.0, 5.0, 2.0 + air_mm]),
            ([-10.0, -5.0, 2.0 + air_mm], [10.0, 5.0, 4.0 + air_mm]),
        ];
        let (mut vertices, mut facets) = (Vec::new(), Vec::new());
        for (low, high) in boxes {
            let one: TriangleMesh<Slot> = solid_box(low.into(), high.into()).moved(&Rigid::shift(Vec3::zeros()));
            let base = vertices.len() as u32;
            vertices.extend_from_slice(one.vertices());
            facets.extend(one.facets().iter().map(|f: &[u32; 3]| f.map(|v| v + base)));
        }
        TriangleMesh::new(vertices, facets)
    }

    fn propped(
        layers: &mut Vec<SupportLayer>,
        props: &[Prop],
        meshes: &[&TriangleMesh<Slot>],
        spans: Vec<[f64; 2]>,
        pitch_mm: f64,
    ) {
        let around = Around { meshes, carrying: meshes.len(), keels: &Keels::default() };
        super::propped(layers, props, &Cuts::of(&around, spans, HOW), pitch_mm);
    }

    const HOW: Clearance = Clearance { line_mm: 0.45, gap_mm: 0.2, clear: Clear::Layers { beside_mm: 0.225 } };

    fn even(count: usize) -> Vec<[f64; 2]> {
        (0..count).map(|k| [0.2, 0.2].map(|h| h * k as f64)).map(|[a, b]| [a, b + 0.2]).collect()
    }

    #[test]
    fn sheets_stand_on_the_part_and_end_a_gap_below_what_they_hold() {
        for layers in [2, 3, 10, 25] {
            let air_mm = 0.2 * f64::from(layers);
            let mesh = shelf(air_mm);
            let prop = Prop { under_mm: 2.0 + air_mm, within_mm: [[-7.0, -5.0], [10.0, 5.0]], middle: false };
            let mut laid = Vec::new();
            propped(&mut laid, &[prop], &[&mesh], even(60), 2.5);
            let with: Vec<usize> = (0..laid.len()).filter(|&k| !laid[k].lines.is_empty()).collect();
            // From the plate's top to a gap of one layer below the shelf.
            assert_eq!(with, (10..10 + layers as usize - 1).collect::<Vec<_>>(), "{layers}");
            for line in with.iter().flat_map(|&k| &laid[k].lines) {
                // Beside the post there is half a line and half of a line more.
                assert!(line.iter().all(|p| p[0] > -7.0 + 0.44 && p[0] < 10.5 && p[1].abs() < 5.5), "{line:?}");
            }
            let first = &laid[10].lines;
            let along = first.iter().filter(|line| line[0][1] == line[1][1]).count();
            assert_eq!((along, first.len() - along), (5, 4), "at 2.5 mm along x, at 5 mm across");
        }
        // One layer of air is no place for a sheet and its gap.
        let mut none = Vec::new();
        let prop = Prop { under_mm: 2.2, within_mm: [[-7.0, -5.0], [10.0, 5.0]], middle: true };
        propped(&mut none, &[prop], &[&shelf(0.2)], even(60), 2.5);
        assert!(none.is_empty());
    }

    #[test]
    fn sheets_stand_on_slopes_of_the_part() {
        for rises_deg in [0.0_f64, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0] {
            // A floor that rises along x, and a shelf over it.
            let rise = 20.0 * rises_deg.to_radians().tan();
            let under_mm = 0.2 * ((rise + 6.0) / 0.2).round();
            let floor = prism(&[[-10.0, 0.0], [10.0, 0.0], [10.0, 1.0 + rise], [-10.0, 1.0]], [-5.0, 5.0]);
            let shelf = solid_box(Vec3::new(-10.0, -5.0, under_mm), Vec3::new(10.0, 5.0, under_mm + 2.0));
            let [floor, shelf] = [floor, shelf].map(|one| one.moved::<Slot>(&Rigid::shift(Vec3::zeros())));
            let prop = Prop { under_mm, within_mm: [[-10.0, -5.0], [10.0, 5.0]], middle: false };
            let mut laid = Vec::new();
            propped(&mut laid, &[prop], &[&floor, &shelf], even(240), 2.5);
            let along = |layer: &SupportLayer| -> f64 {
                layer.lines.iter().filter(|[a, b]| a[1] == b[1] && a[1] == 0.0).map(|[a, b]| (b[0] - a[0]).abs()).sum()
            };
            let top = laid.last().map_or(0.0, along);
            assert!(top > 20.0, "{rises_deg}: {top} mm of a sheet are a gap below the shelf");
            // No line begins higher above the floor than that rises along it, and than a line sags by.
            let begun = |x: f64| {
                laid.iter()
                    .find(|layer| layer.lines.iter().any(|[a, b]| a[1] == 0.0 && b[1] == 0.0 && a[0] <= x && x <= b[0]))
            };
            for x in [-9.0, -5.0, 0.0, 5.0, 9.0] {
                let floor_mm = 1.0 + (x + 10.0) * rises_deg.to_radians().tan();
                let at = begun(x).map_or(f64::INFINITY, |layer| layer.span_mm[0]);
                assert!(
                    at - floor_mm < 3.0 * 0.2 + 2.0 * 0.45 * rises_deg.to_radians().tan(),
                    "{rises_deg}: at x {x} it begins at {at} mm, over {floor_mm} mm"
                );
            }
        }
    }

    #[test]
    fn a_small_place_between_the_sheets_has_a_cross_of_its_own_with_feet() {
        let lug: TriangleMesh<Slot> =
            solid_box(Vec3::new(1.0, 1.0, 6.0), Vec3::new(2.0, 1.6, 8.0)).moved(&Rigid::shift(Vec3::zeros()));
        let laid = |middle: bool| {
            let prop = Prop { under_mm: 6.0, within_mm: [[1.0, 1.0], [2.0, 1.6]], middle };
            let mut laid = Vec::new();
            propped(&mut laid, &[prop], &[&lug], even(40), 2.5);
            laid
        };
        assert!(laid(false).is_empty());
        let laid = laid(true);
        assert_eq!(laid.len(), 29, "up to a layer below 6 mm");
        assert_eq!((laid[0].lines.len(), laid[1].lines.len()), (6, 2));
        // It reaches 1.6 widths beyond the lug.
        let [[a, y], [b, _]] = laid[20].lines[0];
        assert!((y - 1.3).abs() < 1e-9 && (a - 0.28).abs() < 0.02 && (b - 2.72).abs() < 0.02, "{a} {b} {y}");
    }
}
