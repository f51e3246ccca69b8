//! `alexander`: surface accuracy and what supports do to it (de Castro (2020), section 3.3).

use std::sync::Arc;

use super::super::bound::Shadow;
use super::super::facets::{Tree, chunked, tangential};
use super::super::{Cap, Facets, Local, Minorant, Objective, Proof};
use crate::geom::{Angle, Vec3};
use crate::mesh::TABLE_GAP_MM;

/// `sum A z_t |n.d|`, and `R` times the area of all facets that need support and of the contact on all facets that
/// support touches from above (equation 3.3.7), mm³ for `R` in mm.
///
/// A facet needs support where it overhangs and does not lie on the bed. It is touched from above where the ray up from its
/// barycentre first meets a facet that needs support: with the area `p q / |n.d|` of a `p` by `q` prism cut by its plane,
/// but not more than its own. As in the thesis's equation 3.3.1 flat facets have no staircase (within 0.1 degree). Jumps where
/// a ray passes an edge.
#[derive(Clone, Copy, Debug)]
pub struct Alexander {
    /// Layer height `z_t`, mm.
    pub layer_mm: f64,
    /// Sides `p` and `q` of a support, mm.
    pub sides_mm: [f64; 2],
    /// The penalty `R`, mm: how much deeper a touched surface counts than its stairs.
    pub penalty_mm: f64,
    /// Facets up to this angle from the vertical need no support.
    pub overhang: Angle,
}

impl Alexander {
    fn needs(&self, facets: &Facets, up: &Vec3) -> Vec<bool> {
        let (bed, from) = (facets.lowest(up).dot(up) + TABLE_GAP_MM, self.overhang.rad().sin());
        let needs = |f: &super::super::Facet| -f.area.dot(up) > from * f.area.norm() && f.barycentre.dot(up) > bed;
        facets.each.iter().map(needs).collect()
    }
}

impl Objective for Alexander {
    fn name(&self) -> &str {
        "alexander"
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        let stairs = super::super::Staircase { layer_mm: 1.0 }.value(facets, up) * 2.0;
        let (needs, tree) = (self.needs(facets, up), facets.tree());
        let contact: f64 =
            chunked(facets.each.len(), |range| range.map(|i| self.contact(facets, tree, &needs, i, up)).sum());
        self.layer_mm * stairs + self.penalty_mm * contact
    }

    fn needs_closed(&self) -> bool {
        true
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        let stairs = super::super::Staircase { layer_mm: 1.0 }.gradient(facets, up)? * (2.0 * self.layer_mm);
        let (needs, tree) = (self.needs(facets, up), facets.tree());
        let slope = |i: usize| {
            let area = facets.each[i].area;
            let (along, size) = (area.dot(up), area.norm());
            let own = self.sides_mm[0] * self.sides_mm[1] * size / along.abs();
            let touched = along > 0.0 && self.contact(facets, tree, &needs, i, up) > 0.0;
            if touched && own < size { area * (-own / along) } else { Vec3::zeros() }
        };
        let contact: Vec3 = (0..facets.each.len()).map(slope).sum();
        Some(tangential(stairs + contact * self.penalty_mm, up))
    }

    fn proof(&self) -> Proof {
        Proof::ROUGH
    }

    fn local<'a>(&'a self, facets: &'a Facets) -> Option<Box<dyn Local<'a> + 'a>> {
        let all = Arc::new((0..facets.each.len() as u32).collect());
        let stairs: Box<dyn Local<'a> + 'a> = Box::new(Shadow::of(facets, self.layer_mm, false));
        Some(Box::new(Held { f: self, facets, cap: Cap::WHOLE, stairs, held: 0.0, may: all }))
    }
}

impl Alexander {
    /// What `R` is multiplied with at facet `i`, mm².
    fn contact(&self, facets: &Facets, tree: &Tree, needs: &[bool], i: usize, up: &Vec3) -> f64 {
        let facet = &facets.each[i];
        let (along, size) = (facet.area.dot(up), facet.area.norm());
        if needs[i] {
            return size;
        }
        if along <= 0.0 {
            return 0.0;
        }
        let touched = tree.first(&facet.barycentre, up, i as u32).is_some_and(|above| needs[above as usize]);
        if touched { (self.sides_mm[0] * self.sides_mm[1] * size / along).min(size) } else { 0.0 }
    }
}

/// The stairs' own bound, and the area of what needs support everywhere on the cap; what is touched from above costs
/// nothing at least.
struct Held<'a> {
    f: &'a Alexander,
    facets: &'a Facets,
    cap: Cap,
    stairs: Box<dyn Local<'a> + 'a>,
    held: f64,
    /// Facets that need support on a part of the cap.
    may: Arc<Vec<u32>>,
}

impl<'a> Local<'a> for Held<'a> {
    fn within(&self, cap: &Cap) -> Box<dyn Local<'a> + 'a> {
        let (from, low) = (self.f.overhang.rad().sin(), self.facets.lowest(&cap.centre));
        let (mut held, mut may) = (self.held, Vec::new());
        for &i in self.may.iter() {
            let facet = &self.facets.each[i as usize];
            let size = facet.area.norm();
            let [least, most] = cap.range(&(-facet.area / size));
            if least > from + 1e-9 && cap.range(&(facet.barycentre - low))[0] > TABLE_GAP_MM * (1.0 + 1e-9) {
                held += size;
            } else if most >= from - 1e-9 {
                may.push(i);
            }
        }
        let stairs = self.stairs.within(cap);
        Box::new(Self { f: self.f, facets: self.facets, cap: *cap, stairs, held, may: Arc::new(may) })
    }

    fn estimate(&self) -> f64 {
        self.minorant(&self.cap.centre).value
    }

    fn minorant(&self, e: &Vec3) -> Minorant {
        let held = Minorant { value: self.held * self.f.penalty_mm, ..Minorant::ZERO };
        self.stairs.minorant(e).added(1.0, &held)
    }

    fn hint(&self) -> Option<Vec3> {
        self.stairs.hint()
    }
}
