//! What would help an infeasible object, each remedy checked by planning with it.
//!
//! One thing is changed at a time, as little of it as helps: the machine's reach, the head, the place, the support, the way
//! the model stands. A remedy is only named after a plan was found with it.

use serde::Serialize;

use super::heads;
use super::infeasible::{Infeasible, Reason};
use super::options::Options;
use super::placement::centred;
use super::planner::{orientations, plan};
use super::workpiece::Workpiece;
use crate::geom::{Angle, Object, Rigid, Vec3};
use crate::mesh::{Model, TriangleMesh};
use crate::orient::Direction;
use crate::profile::Profile;
use crate::spelling::part_named;

/// Something that would give a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Remedy {
    /// `tolerate`, `bridge`, `overhang`, `margin`, `table-later`, `tilt`, `height`, `head-width`, `nozzle-length`, `pedestal`, `base`,
    /// `up`, `split`, `support`, `join` or `machine`.
    pub kind: &'static str,
    /// How much of it: mm², mm, deg, a share, a part's number, or how many solids, by kind; 0 for a cut, a turn and a machine.
    pub amount: f64,
    /// In words.
    pub text: String,
}

/// The object, the machine and the wish that has no plan.
pub struct Wish<'a> {
    /// The model where it stands.
    pub workpiece: &'a Workpiece<'a>,
    /// The machine.
    pub profile: &'a Profile,
    /// What was tried.
    pub directions: &'a [Vec<Direction>],
    /// How it was tried.
    pub options: &'a Options<'a>,
    /// Why there is none.
    pub no: &'a Infeasible,
}

/// Kinds of remedies.
const KINDS: usize = 13;
/// More than this in one place verification sees as lines in the air, mm².
const MOST_TOLERATED_MM2: f64 = 4.0;
/// Beyond this nothing spans, mm.
const MOST_BRIDGE_MM: f64 = 60.0;
/// Beyond this a slope is a ceiling, degrees.
const MOST_OVERHANG_DEG: f64 = 80.0;

/// Steps of each check: a remedy must be plain, not proved best.
const STEPS: u64 = 400_000;

/// That support which somebody makes by hand would do below a part.
pub fn support_by_hand(part: usize, name: &str) -> String {
    format!("support {} by hand, and pass --allow {part}", part_named(part, name))
}

impl Wish<'_> {
    /// Every remedy that this version knows and that helps, what is nearest to working first, then a cut, then support; `told` after
    /// each kind that was tried.
    pub fn remedies(&self, mut told: impl FnMut(&str)) -> Vec<Remedy> {
        type Try<'w, 'a> = (&'static str, fn(&'w Wish<'a>) -> Vec<Remedy>, bool);
        // Where all that stands in the way is support, no machine helps.
        let machine = !self.only_support();
        let tries: [Try<'_, '_>; KINDS] = [
            ("more tolerance", Self::more_tolerance, true),
            ("longer bridges", Self::longer_bridges, true),
            ("steeper overhangs", Self::steeper, true),
            ("less room", Self::less_margin, machine),
            ("a later slot", Self::table_later, self.workpiece.parts.len() > 1),
            ("more tilt", Self::more_tilt, machine),
            ("more height", Self::more_height, machine),
            ("a slimmer head", Self::slimmer_head, machine),
            ("a longer nozzle", Self::longer_nozzle, machine),
            ("a pedestal", Self::pedestal, machine),
            ("another base", Self::other_base, true),
            ("a cut", Self::cut, true),
            ("support", Self::support, true),
        ];
        let mut found = Vec::new();
        for (name, try_it, worth) in tries {
            told(name);
            if worth {
                found.extend(try_it(self));
            }
        }
        found
    }

    fn reasons(&self) -> (&[Reason], bool) {
        if let Infeasible::NoPlan { reasons, least, .. } = self.no { (reasons, *least) } else { (&[], false) }
    }

    /// Whether the reasons, which rule a plan out by themselves, are of support alone: a remedy must take one of them away.
    fn only_support(&self) -> bool {
        let (reasons, decided) = self.reasons();
        decided && !reasons.is_empty() && reasons.iter().all(|r| r.blocked_by == "support")
    }

    /// The parts that the reasons name, ascending.
    fn concerned(&self) -> Vec<usize> {
        let parts: std::collections::BTreeSet<usize> = self.reasons().0.iter().map(|r| r.part).collect();
        parts.into_iter().collect()
    }

    fn helps(&self, profile: &Profile, change: impl FnOnce(&mut Options<'_>)) -> bool {
        let mut options =
            Options { explain: false, plans: 1, budget: self.options.budget.min(STEPS), ..self.options.clone() };
        change(&mut options);
        plan(self.workpiece, profile, self.directions, &options).is_ok()
    }

    fn with_profile(&self, change: impl FnOnce(&mut Profile)) -> bool {
        let mut profile = self.profile.clone();
        change(&mut profile);
        self.helps(&profile, |_| {})
    }

    fn more_tilt(&self) -> Vec<Remedy> {
        let tilt = &self.profile.kinematics.tilt;
        let (low, high) = (tilt.min_deg, tilt.max_deg);
        let helps = |reach: f64| {
            self.with_profile(|p| {
                p.kinematics.tilt.min_deg = low.min(-reach);
                p.kinematics.tilt.max_deg = high.max(reach);
            })
        };
        let Some(reach) = least(1.0, 180.0, 1.0, helps) else { return Vec::new() };
        let text =
            format!("a table that tilts {reach:.0} deg either way (yours: {low}..{high}), with the same X, Y and Z");
        vec![Remedy { kind: "tilt", amount: reach, text }]
    }

    fn more_height(&self) -> Vec<Remedy> {
        let [_, top] = self.profile.limits.z_mm;
        let helps = |more: f64| self.with_profile(|p| p.limits.z_mm[1] = top + more);
        let Some(more) = least(1.0, 256.0, 1.0, helps) else { return Vec::new() };
        let amount = top + more;
        let text = format!("a machine with Z up to {amount:.0} mm (yours: {top})");
        vec![Remedy { kind: "height", amount, text }]
    }

    fn slimmer_head(&self) -> Vec<Remedy> {
        // The least change is the widest head: search for the narrowing.
        let helps = |narrowing: f64| self.with_profile(|p| heads::scaled(p, 1.0 - narrowing / 100.0));
        let Some(narrowing) = least(1.0, 95.0, 1.0, helps) else { return Vec::new() };
        let share = 100.0 - narrowing;
        let text = format!("a print head {share:.0} % as wide");
        vec![Remedy { kind: "head-width", amount: share / 100.0, text }]
    }

    fn longer_nozzle(&self) -> Vec<Remedy> {
        let helps = |more: f64| self.with_profile(|p| heads::raised(p, more));
        let Some(more) = least(1.0, 64.0, 0.5, helps) else { return Vec::new() };
        let text = format!("a nozzle {more:.1} mm longer, with the added length no wider than its tip");
        vec![Remedy { kind: "nozzle-length", amount: more, text }]
    }

    fn pedestal(&self) -> Vec<Remedy> {
        let helps = |height: f64| {
            let mut profile = self.profile.clone();
            profile.kinematics.offset_mm[2] += height;
            self.helps(&profile, |o| o.pedestal_mm += height)
        };
        let Some(height) = least(1.0, 128.0, 0.5, helps) else { return Vec::new() };
        let text = format!("raise the model {height:.1} mm on a pedestal with its own footprint");
        vec![Remedy { kind: "pedestal", amount: height, text }]
    }

    fn less_margin(&self) -> Vec<Remedy> {
        let margin = self.options.margin_mm;
        let helps = |less: f64| self.helps(self.profile, |o| o.margin_mm = (margin - less).max(0.0));
        let Some(less) = least(0.1, margin, 0.05, helps) else { return Vec::new() };
        let left = (margin - less).max(0.0);
        vec![Remedy {
            kind: "margin",
            amount: left,
            text: format!("lower --margin to {left:.2} (currently {margin} mm)"),
        }]
    }

    /// A larger patch that nothing carries.
    fn more_tolerance(&self) -> Vec<Remedy> {
        let asked = self.options.tolerate_mm2;
        let helps = |more: f64| self.helps(self.profile, |o| o.tolerate_mm2 = asked + more);
        let Some(more) = least(1.0, MOST_TOLERATED_MM2 - asked, 1.0, helps) else { return Vec::new() };
        let amount = asked + more;
        let text = format!(
            "raise --tolerate to {amount:.0} if that much sagging is acceptable (currently {asked} mm2 a patch)"
        );
        vec![Remedy { kind: "tolerate", amount, text }]
    }

    /// Lines that span more.
    fn longer_bridges(&self) -> Vec<Remedy> {
        let asked = self.profile.process.bridge_mm;
        let helps = |more: f64| self.with_profile(|p| p.process.bridge_mm = asked + more);
        let Some(more) = least(1.0, MOST_BRIDGE_MM - asked, 1.0, helps) else { return Vec::new() };
        let amount = asked + more;
        let text = format!("raise --bridge to {amount:.0} if the material spans that (currently {asked} mm)");
        vec![Remedy { kind: "bridge", amount, text }]
    }

    fn steeper(&self) -> Vec<Remedy> {
        let asked = self.options.layers(self.profile).overhang.deg();
        let helps = |more: f64| {
            let angle = Angle::from_deg(asked + more);
            self.helps(self.profile, |o| (o.overhang, o.steepest) = (angle, Some(angle)))
        };
        let Some(more) = least(1.0, MOST_OVERHANG_DEG - asked, 1.0, helps) else { return Vec::new() };
        let angle = asked + more;
        let text = format!("raise --overhang to {angle:.0} if the material bridges that (currently {asked:.0} deg)");
        vec![Remedy { kind: "overhang", amount: angle, text }]
    }

    /// The one remedy that is not checked by planning: a cut is a search of its own.
    fn cut(&self) -> Vec<Remedy> {
        if self.workpiece.parts.len() > 1 {
            return Vec::new();
        }
        let text = "try cutting it into parts: trunnion split MODEL -m PROFILE -o PARTS.3mf".to_owned();
        vec![Remedy { kind: "split", amount: 0.0, text }]
    }

    /// Support below one part.
    fn support(&self) -> Vec<Remedy> {
        let helps = |part: &usize| self.helps(self.profile, |o| o.supported.push(*part));
        let remedy = |part: usize| {
            let name = &self.workpiece.model.parts[part].name;
            let text = match self.workpiece.parts.len() {
                1 => format!(
                    "pass --supports auto, or add your own supports below {} and pass --allow {part}",
                    part_named(part, name)
                ),
                _ => support_by_hand(part, name),
            };
            Remedy { kind: "support", amount: part as f64, text }
        };
        self.concerned().into_iter().filter(helps).map(remedy).collect()
    }

    fn table_later(&self) -> Vec<Remedy> {
        let helps = self.options.table_first && self.helps(self.profile, |o| o.table_first = false);
        let text = "use --table-later: parts on the table may wait for later slots".to_owned();
        if helps { vec![Remedy { kind: "table-later", amount: 0.0, text }] } else { Vec::new() }
    }

    /// The model laid on another large flat face.
    fn other_base(&self) -> Vec<Remedy> {
        let mut found = Vec::new();
        for (part, normal) in feet(self.workpiece.model) {
            let model = laid_on(self.workpiece.model, &normal);
            if !model.floating().is_empty() || !model.on_table.contains(&part) {
                continue;
            }
            let Ok(placement) = centred(&model, self.profile) else { continue };
            let workpiece = Workpiece::place(&model, &placement);
            let options =
                Options { explain: false, plans: 1, budget: self.options.budget.min(STEPS), ..self.options.clone() };
            let directions = orientations(&workpiece, &options);
            if plan(&workpiece, self.profile, &directions, &options).is_ok() {
                let name = &model.parts[part].name;
                let [x, y, z] = [normal.x, normal.y, normal.z].map(|v| if v.abs() < 5e-4 { 0.0 } else { v });
                let up = [x, y, z].map(|v| format!("{}", (-v * 1e4).round() / 1e4 + 0.0)).join(",");
                let text = format!("stand the model on {}: --up {up}", part_named(part, name));
                found.push(Remedy { kind: "base", amount: part as f64, text });
                break;
            }
        }
        found
    }
}

/// The least `x` in `first..=most` (to `step`) at which `helps`; `None` where not even `most` does. Monotone remedies are
/// assumed: more of one helps at least as much.
fn least(first: f64, most: f64, step: f64, helps: impl Fn(f64) -> bool) -> Option<f64> {
    if most < first || !helps(most) {
        return None;
    }
    let (mut low, mut high) = (0.0, most);
    while high - low > step {
        let middle = ((low + high) / 2.0 / step).round() * step;
        if middle <= low || middle >= high {
            break;
        }
        if helps(middle) { high = middle } else { low = middle }
    }
    Some(high)
}

/// Directions of large flat faces at which the whole model could stand, with the part whose face it is; the largest first.
fn feet(model: &Model) -> Vec<(usize, Vec3)> {
    const MOST: usize = 6;
    let mut faces: Vec<(usize, Vec3, f64)> = Vec::new();
    for part in &model.parts {
        for facet in 0..part.mesh.facets().len() {
            let Some(normal) = part.mesh.normal(facet) else { continue };
            let outmost = part.mesh.corners(facet)[0].dot(&normal);
            let beyond = |v: &Vec3| v.dot(&normal) > outmost + 0.01;
            if normal.z < -0.999 || model.parts.iter().any(|p| p.mesh.vertices().iter().any(beyond)) {
                continue;
            }
            let area = part.mesh.facet_area(facet);
            match faces.iter_mut().find(|(id, n, _)| *id == part.id && (n - normal).norm() < 1e-3) {
                Some((.., sum)) => *sum += area,
                None => faces.push((part.id, normal, area)),
            }
        }
    }
    faces.sort_by(|a, b| b.2.total_cmp(&a.2).then(a.0.cmp(&b.0)));
    faces.truncate(MOST);
    faces.into_iter().map(|(part, normal, _)| (part, normal)).collect()
}

/// The model turned so that `down` points down.
fn laid_on(model: &Model, down: &Vec3) -> Model {
    let turn = nalgebra::Rotation3::rotation_between(down, &-Vec3::z())
        .unwrap_or_else(|| nalgebra::Rotation3::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI));
    let motion: Rigid<Object, Object> = Rigid::new(*turn.matrix(), Vec3::zeros());
    let part = |p: &crate::mesh::Part| -> (String, TriangleMesh<Object>) { (p.name.clone(), p.mesh.moved(&motion)) };
    Model::from_parts(model.parts.iter().map(part).collect())
}

/// Whether remedies are worth looking for: only an object that has reasons can be helped.
pub fn can_be_helped(no: &Infeasible) -> bool {
    matches!(no, Infeasible::NoPlan { .. } | Infeasible::NoPlace { .. })
}
