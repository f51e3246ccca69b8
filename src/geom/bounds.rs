//! Axis-parallel boxes.

use super::Vec3;

/// An axis-parallel box in millimetres; empty until a point is added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The corner with the smallest coordinates.
    pub min: Vec3,
    /// The corner with the largest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// Its eight corners.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| Vec3::from_fn(|a, _| if i >> a & 1 == 0 { self.min[a] } else { self.max[a] }))
    }

    /// The box of no points: every `min` is `+inf`, every `max` is `-inf`.
    pub const EMPTY: Self = Self {
        min: Vec3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        max: Vec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// The smallest box that holds all `points`; [`Bounds::EMPTY`] for none.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |mut all, point| {
            all.add(point);
            all
        })
    }

    /// Grows the box so that it holds `point`.
    pub fn add(&mut self, point: Vec3) {
        *self = self.union(&Self { min: point, max: point });
    }

    /// The smallest box that holds both.
    pub fn union(&self, other: &Self) -> Self {
        // What is no number counts for nothing.
        let lower = |i: usize| if other.min[i] < self.min[i] { other.min[i] } else { self.min[i] };
        let upper = |i: usize| if other.max[i] > self.max[i] { other.max[i] } else { self.max[i] };
        Self { min: Vec3::new(lower(0), lower(1), lower(2)), max: Vec3::new(upper(0), upper(1), upper(2)) }
    }

    /// The box grown by `by` mm on every side.
    pub fn inflated(&self, by: f64) -> Self {
        let by = Vec3::repeat(by);
        Self { min: self.min - by, max: self.max + by }
    }

    /// Whether the boxes share a point; touching counts.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|i| self.min[i] <= other.max[i] && other.min[i] <= self.max[i])
    }

    /// Whether `point` lies inside or on the border.
    pub fn holds(&self, point: &Vec3) -> bool {
        (0..3).all(|i| self.min[i] <= point[i] && point[i] <= self.max[i])
    }

    /// Whether no point was ever added.
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    /// The centre; not a number for an empty box.
    pub fn centre(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// The edge lengths.
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }
}
