//! What a part at a direction would lay on nothing, asked of facets or of layers, and told in the model file's own frame.

use super::candidates::{Setups, Told};
use super::infeasible::Hanging;
use super::options::Options;
use super::part_set::PartSet;
use super::support::{Needs, NeedsAsked, Neighbours, needs};
use super::workpiece::Workpiece;
use crate::geom::{Dir, Table, Vec3};
use crate::orient::Direction;
use crate::overhang::OverhangRule;
use crate::profile::Profile;

/// Less than this droops without a word, mm².
const TOLD_MM2: f64 = 1.0;
/// Directions whose layers are all looked through to say why not.
const LOOKED_AT_CLOSELY: usize = 6;

/// Whether some part stands by its layers only, at any of its `directions`: else facets are enough to plan by. Of one solid alone a
/// longer bridge may be what helps, whatever the directions at which its facets stand and the machine does not reach.
pub fn layers_matter(
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    directions: &[Vec<Direction>],
    options: &Options<'_>,
) -> bool {
    let strict = Options { practised: false, ..options.clone() };
    let setups = Setups::new(workpiece, profile, &strict);
    let stands = |(part, tried): (usize, &Vec<Direction>)| {
        let ways = setups.ways(part, tried, Told::Standing);
        ways.iter().any(|way| way.objections.is_empty())
    };
    options.practised && (directions.len() == 1 || !directions.iter().enumerate().all(stands))
}

/// What of a part is printed, but droops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartDroop {
    /// The part.
    pub part: usize,
    /// How much of it, mm².
    pub area_mm2: f64,
    /// By how much at most, mm.
    pub droop_mm: f64,
    /// About where the most of it is, the model file's frame, mm.
    pub at_mm: [f64; 3],
}

/// What droops of parts that are printed along these directions, by part.
pub fn droops(
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    prints: impl Iterator<Item = (usize, Dir<Table>)>,
    options: &Options<'_>,
) -> Vec<PartDroop> {
    let setups = Setups::new(workpiece, profile, options);
    let rule = options.layers(profile);
    let of_part = |(part, up): (usize, Dir<Table>)| {
        if options.supported.contains(&part) {
            return None;
        }
        let neighbours = options.known.neighbours(workpiece, part);
        let all = neighbours.droops(&workpiece.parts[part], up, &rule, options.together);
        let area_mm2: f64 = all.iter().map(|droop| droop.area_mm2).sum();
        let droop_mm = all.iter().map(|droop| droop.droop_mm).fold(0.0, f64::max);
        let most = all.first().filter(|_| area_mm2 >= TOLD_MM2)?;
        Some(PartDroop { part, area_mm2, droop_mm, at_mm: setups.in_the_file(&most.at) })
    };
    prints.filter_map(of_part).collect()
}

impl Setups<'_> {
    pub(super) fn everyone(&self) -> PartSet {
        let count = self.workpiece.parts.len();
        let mut everyone = PartSet::new(count);
        (0..count).for_each(|q| everyone.insert(q));
        everyone
    }

    /// Looks through all layers at the few directions at which the least would hang: what is told of them is to be the whole of it.
    pub(super) fn look_closer(&self, part: usize, neighbours: &Neighbours, found: &mut [(Dir<Table>, f64, Needs)]) {
        let mut order: Vec<usize> = (0..found.len()).filter(|&i| !found[i].2.closely).collect();
        order.sort_by(|&a, &b| found[a].2.facets_mm2.total_cmp(&found[b].2.facets_mm2));
        for i in order.into_iter().take(LOOKED_AT_CLOSELY) {
            found[i].2 = self.needs(part, neighbours, found[i].0, true, false);
        }
    }

    /// What `part` needs along `up`.
    pub(super) fn needs(
        &self,
        part: usize,
        neighbours: &Neighbours,
        up: Dir<Table>,
        by_layers: bool,
        enough: bool,
    ) -> Needs {
        if self.options.supported.contains(&part) {
            return Needs::none();
        }
        let options = self.options;
        let layers = options.layers(self.profile);
        let rule = if by_layers { layers } else { OverhangRule { overhang: options.overhang, ..layers } };
        let allowed_mm2 = options.allow.iter().filter(|(p, _)| *p == part).map(|(_, area)| *area).fold(0.0, f64::max);
        let (together, layered) = (options.together, options.layered.contains(&part));
        let known = &options.known;
        let asked = NeedsAsked { rule, allowed_mm2, by_layers, enough, together, layered, known };
        needs(&self.workpiece.parts[part], neighbours, up, &asked, self.workpiece.parts.len())
    }

    fn in_the_file(&self, at: &Vec3) -> [f64; 3] {
        let back = self.workpiece.placed.inverse();
        (back.rotation * at + back.translation).into()
    }

    pub(super) fn hangs(&self, needs: &Needs) -> Option<Hanging> {
        let patch = needs.left.first().filter(|_| needs.closely)?;
        let area_mm2 = needs.left.iter().map(|patch| patch.area_mm2).sum();
        Some(Hanging { area_mm2, at_mm: self.in_the_file(&patch.at), cause: patch.cause.to_string() })
    }

    /// What hangs, in words; places in the model file's frame.
    pub(super) fn hanging(&self, needs: &Needs) -> String {
        let missing = needs.missing(&self.everyone());
        if missing == 0.0 {
            return "it would begin in mid-air".to_owned();
        }
        let Some(patch) = needs.left.first() else {
            return format!(
                "{missing:.1} mm2 would overhang beyond {:.0} deg without support",
                self.options.overhang.deg()
            );
        };
        let [x, y, z] = self.in_the_file(&patch.at).map(|v| crate::gcode::round_to(v, 1) + 0.0);
        let (area, cause) = (patch.area_mm2, patch.cause);
        format!("{missing:.1} mm2 would be printed in mid-air, {area:.1} of it near ({x}, {y}, {z}) mm: {cause}")
    }
}
