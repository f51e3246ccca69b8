//! A print that was turned about Z on the slicer's bed, turned back: everything behind the reader sees it as it was handed over.

use super::items::{Item, Step3};
use super::sliced::SlicedPrint;
use super::source::SlicedError;
use crate::geom::{Bounds, Vec3};
use crate::motion::replay::{PlainMoved, flatten};

/// A turn about the file's origin, counter-clockwise seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    cos: f64,
    sin: f64,
}

impl Turn {
    pub(super) fn by(radians: f64) -> Self {
        let (sin, cos) = radians.sin_cos();
        Self { cos, sin }
    }

    pub(super) fn of([x, y]: [f64; 2], turn: Self) -> [f64; 2] {
        [turn.cos * x - turn.sin * y, turn.sin * x + turn.cos * y]
    }

    fn point(self, p: Vec3) -> Vec3 {
        let [x, y] = Self::of([p.x, p.y], self);
        Vec3::new(x, y, p.z)
    }

    /// A move, turned.
    pub(super) fn plain(self, m: PlainMoved) -> PlainMoved {
        PlainMoved { from: self.point(m.from), to: self.point(m.to), ..m }
    }

    /// Any line of a print, turned.
    pub(super) fn item(self, item: Item) -> Item {
        let Item::Step(step) = item else { return item };
        let mut arc = step.arc;
        if let Some(arc) = &mut arc {
            arc.to_centre = Self::of(arc.to_centre, self);
        }
        Item::Step(Step3 { from: self.point(step.from), to: self.point(step.to), arc, ..step })
    }

    /// A place, turned.
    pub(super) fn tip(self, tip: Option<Vec3>) -> Option<Vec3> {
        tip.map(|p| self.point(p))
    }
}

impl SlicedPrint<'_> {
    /// The same print with all its coordinates turned.
    ///
    /// # Errors
    ///
    /// None for a print that was read.
    pub(super) fn turned(&self, turn: Turn) -> Result<Self, SlicedError> {
        let mut new = Self { turn: Some(turn), ..self.clone() };
        let mut walk = new.walk();
        (new.extrusion, new.reach) = (Bounds::EMPTY, Bounds::EMPTY);
        for layer in &mut new.layers {
            layer.extrusion = Bounds::EMPTY;
            while let Some(item) = walk.next(layer.end)? {
                let Item::Step(step) = item else { continue };
                if !step.prints() {
                    new.reach.add(step.to);
                    continue;
                }
                layer.extrusion.add(step.from);
                layer.extrusion.add(step.to);
                if let Some(arc) = &step.arc {
                    flatten(step.from, step.to, arc, 0.01).into_iter().for_each(|p| layer.extrusion.add(p));
                }
            }
            new.extrusion = new.extrusion.union(&layer.extrusion);
        }
        new.reach = new.reach.union(&new.extrusion);
        Ok(new)
    }
}
