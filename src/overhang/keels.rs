//! Keels: what of a part begins over nothing, narrower than a line, and becomes wider in the layers above: the sharp edge below a hull, the tip
//! of a wing. A slicer lays nothing where no line fits, each a little more or less of it, and what it lays first wants to be held.
//!
//! ```text
//! layer 4   |#########|    wider than a line: laid by every slicer
//! layer 3     |####|       keel: laid by some
//! layer 2      |##|        keel
//! layer 1       ||         keel: laid by nobody
//!   (air)
//! ```
//!
//! Thin walls that stay thin are none, and neither is what stands on the table. The part is upright; layers are those of which the middles are
//! given; lengths mm.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::rc::Rc;

use super::OverhangRule;
use super::chords::holds;
use super::region::{Corners, Region, Shape, and, area_mm2, at, bounds, edges, enclosed, grown, minus};
use crate::section::{Section, Sections, Segment};

/// What is thinner than a line by less than this is as wide as one, mm.
const SLACK_MM: f64 = 1e-3;
/// Shorter ones may hang, mm.
const SHORTEST_MM: f64 = 1.0;
/// A keel is as wide as a line no higher above than this, mm: its sides lean by 4 degrees or more. What stays narrower is a thin wall.
const HIGHEST_MM: f64 = 3.0;
/// It is where so much of it lies below what is wide.
const HALF: f64 = 0.5;
/// Less is rounding, mm².
const NOTHING_MM2: f64 = 1e-4;
/// A line that lies so far beside a keel is another's, mm.
const BESIDE_MM: f64 = 0.1;

/// By layer, what of it is a keel.
#[derive(Clone, Debug, Default)]
pub struct Keels(BTreeMap<usize, Region>);

impl Keels {
    /// Those of a part that is cut in the `middles` of its layers, upward, where something begins in the air at the heights `begins_mm`; none by a
    /// rule that lets everything overhang.
    pub fn of(sections: &Sections, middles: &[f64], begins_mm: &[f64], rule: &OverhangRule) -> Self {
        let (half_mm, step_mm) = (rule.line_mm / 2.0 - SLACK_MM, rule.fine_mm());
        if step_mm.is_infinite() {
            return Self::default();
        }
        let mut cuts = Cuts { sections, middles, half_mm, known: HashMap::new() };
        let mut found: BTreeMap<usize, Region> = BTreeMap::new();
        let first = |z: &f64| middles.partition_point(|middle| middle < z);
        // Layers may be cut a hair beside where something begins.
        let mut next: BTreeSet<usize> = begins_mm.iter().map(first).flat_map(|k| [k, k + 1]).collect();
        while let Some(k) = next.pop_first() {
            if k == 0 || k >= middles.len() {
                continue;
            }
            let here = cuts.at(k);
            if here.thin.is_empty() {
                continue;
            }
            let below = cuts.at(k - 1);
            let below = found.get(&(k - 1)).map_or_else(|| below.whole.clone(), |keel| minus(&below.whole, keel));
            let mut keel = minus(&here.thin, &grown(&below, step_mm, Corners::Sharp));
            keel.retain(|one| is_long(one) && cuts.widens(one, k));
            if !keel.is_empty() {
                found.insert(k, keel);
                next.insert(k + 1);
            }
        }
        Self(found)
    }

    /// The layers that have some, lowest first.
    pub(super) fn layers(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.keys().copied()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What a layer has beside them.
    pub(super) fn rest(&self, layer: usize, whole: Region) -> Region {
        self.0.get(&layer).map_or_else(|| whole.clone(), |keel| minus(&whole, keel))
    }

    /// What a cut through a layer has beside them.
    pub fn without(&self, layer: usize, cut: Section) -> Section {
        if !self.0.contains_key(&layer) {
            return cut;
        }
        section(&self.rest(layer, enclosed(cut.segments())))
    }

    /// Those that are left when a slicer has laid such lines in a layer; and none where it has laid some.
    pub fn laid(&mut self, layer: usize, lines: &[Segment]) {
        let Some(keels) = self.0.get_mut(&layer) else { return };
        keels.retain(|one| !is_laid(one, lines));
        if keels.is_empty() {
            self.0.remove(&layer);
        }
    }
}

/// A cut of which what is narrower than a line is left out, unless one of these lines is laid there.
pub fn laid_of(cut: &Section, lines: &[Segment], line_mm: f64) -> Section {
    let whole = enclosed(cut.segments());
    let mut thin = minus(&whole, &opened(&whole, line_mm / 2.0 - SLACK_MM));
    thin.retain(|one| !is_laid(one, lines));
    section(&minus(&whole, &thin))
}

fn section(region: &Region) -> Section {
    let sides = region.iter().flatten().flat_map(|ring| edges(ring));
    Section::new(sides.map(|ends| ends.map(at)).collect())
}

/// What of a region is narrower than this, mm, and longer than a spot.
pub(super) fn too_narrow(region: &Region, mm: f64) -> Region {
    let mut narrow = minus(region, &opened(region, mm / 2.0));
    narrow.retain(is_long);
    narrow
}

/// What is nowhere narrower than twice `half_mm`.
fn opened(region: &Region, half_mm: f64) -> Region {
    grown(&grown(region, -half_mm, Corners::Sharp), half_mm, Corners::Sharp)
}

/// Whether one of these lines is laid on a shape, anywhere.
fn is_laid(one: &Shape, lines: &[Segment]) -> bool {
    let [low, high] = bounds(one);
    let is_near = |[a, b]: &&Segment| {
        (0..2).all(|i| a[i].min(b[i]) <= high[i] + BESIDE_MM && a[i].max(b[i]) >= low[i] - BESIDE_MM)
    };
    let mut lines = lines.iter().filter(is_near).peekable();
    if lines.peek().is_none() {
        return false;
    }
    let near = grown(&vec![one.clone()], BESIDE_MM, Corners::Round);
    let border: Vec<Segment> = near.iter().flatten().flat_map(|ring| edges(ring)).map(|ends| ends.map(at)).collect();
    let is_on = |[a, b]: &Segment| {
        let count = ((b[0] - a[0]).hypot(b[1] - a[1]) / BESIDE_MM).ceil().max(1.0);
        let at = |k: usize| [0, 1].map(|i| a[i] + (b[i] - a[i]) * (k as f64 / count));
        (0..=count as usize).any(|k| holds(&border, at(k)))
    };
    lines.any(is_on)
}

fn is_long(one: &Shape) -> bool {
    let [low, high] = bounds(one);
    (high[0] - low[0]).hypot(high[1] - low[1]) >= SHORTEST_MM && area_mm2(one) > NOTHING_MM2
}

/// A layer, and what of it is narrower than a line.
struct Cut {
    whole: Region,
    wide: Region,
    thin: Region,
}

/// The layers that were looked at.
struct Cuts<'a> {
    sections: &'a Sections,
    middles: &'a [f64],
    /// Half a line.
    half_mm: f64,
    known: HashMap<usize, Rc<Cut>>,
}

impl Cuts<'_> {
    fn at(&mut self, k: usize) -> Rc<Cut> {
        let cut = || {
            let whole = enclosed(&self.sections.segments_at(self.middles[k]));
            let wide = opened(&whole, self.half_mm);
            let thin = minus(&whole, &wide);
            Rc::new(Cut { whole, wide, thin })
        };
        Rc::clone(self.known.entry(k).or_insert_with(cut))
    }

    /// Whether what is thin in layer `k` lies below something wide.
    fn widens(&mut self, one: &Shape, k: usize) -> bool {
        let own = vec![one.clone()];
        let highest = self.middles[k] + HIGHEST_MM;
        let mut above = k + 1..self.middles.partition_point(|middle| *middle <= highest);
        let most_mm2 = HALF * area_mm2(one);
        above.any(|j| and(&own, &self.at(j).wide).iter().map(area_mm2).sum::<f64>() >= most_mm2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::prism;
    use crate::geom::{Angle, Object};
    use crate::mesh::TriangleMesh;

    const LINE_MM: f64 = 0.45;
    /// A plate from 22 mm up that a post holds, and below it what an outline in x and z has, 30 mm long.
    fn below_a_plate(outline: &[[f64; 2]]) -> Sections {
        let parts = [
            prism(outline, [0.0, 30.0]),
            prism(&[[-20.0, 22.0], [20.0, 22.0], [20.0, 26.0], [-20.0, 26.0]], [0.0, 30.0]),
            prism(&[[16.0, 0.0], [20.0, 0.0], [20.0, 22.0], [16.0, 22.0]], [0.0, 30.0]),
        ];
        Sections::of(&TriangleMesh::<Object>::joined(parts.iter()))
    }

    fn keels(sections: &Sections, begins_mm: f64) -> Keels {
        let middles: Vec<f64> = (0..130).map(|k| 0.2 * (f64::from(k) + 0.5)).collect();
        let (overhang, bridge_mm) = (OverhangRule::practised(0.2, LINE_MM), 14.0);
        let rule =
            OverhangRule { overhang, layer_mm: 0.2, line_mm: LINE_MM, bridge_mm, tolerate_mm2: 1.0, droops: true };
        assert!(
            Keels::of(sections, &middles, &[begins_mm], &OverhangRule { overhang: Angle::from_deg(89.0), ..rule })
                .is_empty()
        );
        Keels::of(sections, &middles, &[begins_mm], &rule)
    }

    #[test]
    fn a_sharp_edge_below_is_a_keel_as_far_up_as_it_is_narrower_than_a_line() {
        for half_deg in [5.0_f64, 10.0, 20.0, 30.0, 40.0, 50.0] {
            let slope = half_deg.to_radians().tan();
            let hull = below_a_plate(&[[0.0, 12.0], [10.0 * slope, 22.0], [-10.0 * slope, 22.0]]);
            // The middle of the k-th layer above 12 mm is 2 slope (0.2 k + 0.1) wide.
            let narrow = (0..).take_while(|k| 2.0 * slope * (0.2 * f64::from(*k) + 0.1) < LINE_MM - 2.0 * SLACK_MM);
            let wanted: Vec<usize> = narrow.map(|k| 60 + k as usize).collect();
            let found = keels(&hull, 12.0);
            assert_eq!(found.layers().collect::<Vec<_>>(), wanted, "{half_deg}");
            // The rest of a cut has the post, and no keel; a layer above is whole.
            for k in wanted {
                let cut = hull.at(0.2 * k as f64 + 0.1);
                let [all, rest] = [cut.area(), found.without(k, cut).area()];
                assert!((rest - 120.0).abs() < 0.01 && all > rest + 0.3, "{half_deg}, {k}: {all} {rest}");
            }
            let above = hull.at(16.1);
            let area = above.area();
            assert!((found.without(80, above).area() - area).abs() < 1e-9);
        }
    }

    #[test]
    fn thin_walls_and_what_stands_are_none() {
        let wall = |low: f64| below_a_plate(&[[-0.1, low], [0.1, low], [0.1, 22.0], [-0.1, 22.0]]);
        assert!(keels(&wall(12.0), 12.0).is_empty(), "it stays thin for 10 mm");
        assert_eq!(keels(&wall(20.0), 20.0).layers().collect::<Vec<_>>(), (100..110).collect::<Vec<_>>());
        // On the table: a wedge upside down.
        let wedge = below_a_plate(&[[-0.05, 0.0], [0.05, 0.0], [5.0, 22.0], [-5.0, 22.0]]);
        assert!(keels(&wedge, 0.0).is_empty());
        // Blunt by as much as a line.
        let blunt = below_a_plate(&[[-0.225, 12.0], [0.225, 12.0], [5.0, 22.0], [-5.0, 22.0]]);
        assert!(keels(&blunt, 12.0).is_empty());
    }

    #[test]
    fn what_a_slicer_lays_of_a_keel_is_there() {
        let slope = 10.0_f64.to_radians().tan();
        let hull = below_a_plate(&[[0.0, 12.0], [10.0 * slope, 22.0], [-10.0 * slope, 22.0]]);
        let mut found = keels(&hull, 12.0);
        let before: Vec<usize> = found.layers().collect();
        assert_eq!(before, (60..66).collect::<Vec<_>>());
        // A line of the post, and one along the keel.
        let [post, along] = [[[17.0, 1.0], [17.0, 29.0]], [[0.0, 0.2], [0.0, 29.8]]];
        found.laid(64, &[post]);
        assert_eq!(found.layers().count(), 6);
        found.laid(64, &[post, along]);
        found.laid(65, &[along]);
        assert_eq!(found.layers().collect::<Vec<_>>(), (60..64).collect::<Vec<_>>());
        // The same of one cut: what is wide stays whatever is laid, what is thin only with a line on it.
        let cut = hull.at(12.9);
        let area = |lines: &[Segment]| laid_of(&cut, lines, LINE_MM).area();
        let thin = 30.0 * 2.0 * slope * 0.9;
        assert!((area(&[]) - 120.0).abs() < 0.01 && (area(&[post]) - 120.0).abs() < 0.01);
        assert!((area(&[along]) - 120.0 - thin).abs() < 0.01, "{}", area(&[along]));
        let wide = hull.at(14.1);
        assert!((laid_of(&wide, &[], LINE_MM).area() - wide.area()).abs() < 0.01);
    }
}
