//! A machine that is made up, and what a person would read off it: other code than the one that is tested.
//!
//! Turns are quaternions, and a tip is lowered until the nearest of many points of its end meets what is below.

use nalgebra::{UnitQuaternion, UnitVector3, Vector3};
use trunnion::calibrate::{Of, Tip, TipShape, Touch, TouchShape, Unknown};
use trunnion::geom::SplitMix64;
use trunnion::motion::{TableKinematics, TiltAbout};

type V = Vector3<f64>;

/// The chain of a profile with true errors, in the order of [`Unknown::ALL`], mm and radians.
pub(super) struct Machine {
    pub(super) nominal: TableKinematics,
    pub(super) by: [f64; 13],
}

fn about(axis: V, angle: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&UnitVector3::new_normalize(axis), angle)
}

impl Machine {
    /// Off by up to 1.5 mm and 1.5 degrees, its axes up to `bend_deg` from square.
    pub(super) fn any(nominal: TableKinematics, numbers: &mut SplitMix64, bend_deg: f64) -> Self {
        let by = Unknown::ALL.map(|unknown| {
            let near = 2.0 * numbers.unit() - 1.0;
            match unknown {
                // No touch of unknown places tells it.
                Unknown::RotationZero => 0.0,
                // Whoever asks for one sets it.
                Unknown::Sag => 0.0,
                _ if unknown.bends() => near * bend_deg.to_radians(),
                _ if unknown.is_angle() => near * 1.5_f64.to_radians(),
                _ => near * 1.5,
            }
        });
        Self { nominal, by }
    }

    fn axes(&self) -> [V; 2] {
        if self.nominal.about == TiltAbout::X { [V::x(), V::y()] } else { [V::y(), V::x()] }
    }

    /// The table's turn, and where its middle is.
    fn stands(&self, words_deg: [f64; 2]) -> (UnitQuaternion<f64>, V) {
        let b = &self.by;
        let [along, across] = self.axes();
        let angle =
            |axis: &trunnion::motion::AxisRange, word: f64| (word - axis.zero.deg()).to_radians() * axis.direction;
        let [tilt, rotation] = self.nominal.misaligned.map_or([along, V::z()], |axes| [axes.tilt, axes.rotation]);
        let tilt = about(tilt + across * b[7] + V::z() * b[8], angle(&self.nominal.tilt, words_deg[0]) + b[5]);
        let turned = about(rotation + V::new(b[9], b[10], 0.0), angle(&self.nominal.rotation, words_deg[1]) + b[6]);
        let pivot = self.nominal.pivot + V::new(b[0], b[1], b[2]);
        let offset = self.nominal.offset + across * b[3] + V::z() * b[4];
        let fallen = about(V::z().cross(&along), b[11]);
        (tilt * fallen * turned, pivot + tilt * offset)
    }

    pub(super) fn place(&self, words_deg: [f64; 2], q: V) -> V {
        let (turn, middle) = self.stands(words_deg);
        middle + turn * q
    }

    /// The point of the table that is at `p`.
    pub(super) fn lies(&self, words_deg: [f64; 2], p: V) -> V {
        let (turn, middle) = self.stands(words_deg);
        turn.inverse() * (p - middle)
    }

    /// Where the tip is when it has come down at `x`, `y` onto a plane through `through`, parallel to the surface.
    fn lowered(&self, words_deg: [f64; 2], [x, y]: [f64; 2], through: V, tip: &Tip) -> V {
        let (turn, middle) = self.stands(words_deg);
        let normal = turn * V::z();
        // What is lower the farther it is from the middle, where the tip comes down on it as if it were plane.
        let down = (normal.dot(&through) - normal.x * x - normal.y * y) / normal.z;
        let met = turn.inverse() * (V::new(x, y, down) - middle);
        let through = through - normal * (self.by[12] * (met.x * met.x + met.y * met.y) / 1e4);
        // At Z 0 first: all points go up together, so what is lacking along the normal is lacking in Z by so much more.
        let tip_at = V::new(x, y, 0.0);
        let points: Vec<V> = match tip.shape {
            TipShape::Flat => (0..2000)
                .map(|i| {
                    let (s, c) = (f64::from(i) * std::f64::consts::TAU / 2000.0).sin_cos();
                    tip_at + V::new(c, s, 0.0) * tip.radius_mm
                })
                .collect(),
            // The lowest point of a ball along the normal.
            TipShape::Ball => vec![tip_at + (V::z() - normal) * tip.radius_mm],
        };
        let nearest = points.iter().map(|p| normal.dot(&(p - through))).fold(f64::INFINITY, f64::min);
        V::new(x, y, (tip.paper_mm - nearest) / normal.z)
    }

    /// The same onto a ball about `centre`.
    fn lowered_on_ball(&self, [x, y]: [f64; 2], centre: V, radius: f64, tip: &Tip) -> V {
        let gap = |z: f64| {
            let tip_at = V::new(x, y, z);
            let nearest = match tip.shape {
                TipShape::Ball => (tip_at + V::z() * tip.radius_mm - centre).norm() - tip.radius_mm,
                TipShape::Flat => (0..720)
                    .flat_map(|i| (0..=50).map(move |r| (i, r)))
                    .map(|(i, r)| {
                        let (s, c) = (f64::from(i) * std::f64::consts::TAU / 720.0).sin_cos();
                        (tip_at + V::new(c, s, 0.0) * (tip.radius_mm * f64::from(r) / 50.0) - centre).norm()
                    })
                    .fold(f64::INFINITY, f64::min),
            };
            nearest - radius - tip.paper_mm
        };
        V::new(x, y, bisect(centre.z + radius * 0.2, centre.z + radius + 20.0, gap))
    }

    /// A touch of the table near `near`, of a mark or a ball at `q` (for a ball, `near` is beside its top).
    pub(super) fn touch(
        &self,
        of: Of,
        words_deg: [f64; 2],
        near: [f64; 2],
        q: V,
        shape: Option<TouchShape>,
        tip: &Tip,
    ) -> Touch {
        let at = self.place(words_deg, q);
        let at = match shape {
            None => self.lowered(words_deg, near, self.place(words_deg, V::zeros()), tip),
            Some(TouchShape::Mark { .. }) => self.lowered(words_deg, [at.x, at.y], at, tip),
            Some(TouchShape::Ball { radius }) => {
                self.lowered_on_ball([at.x + near[0], at.y + near[1]], at, radius, tip)
            }
        };
        Touch { number: 1, line: 1, of, words_deg, at }
    }
}

/// Where a rising function is zero.
fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    assert!(f(low) < 0.0 && f(high) > 0.0, "nothing is met");
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    high
}

/// A normal deviate (G. E. P. Box and M. E. Muller, 1958).
pub(super) fn normal(numbers: &mut SplitMix64) -> f64 {
    let radius = (-2.0 * (1.0 - numbers.unit()).ln()).sqrt();
    radius * (std::f64::consts::TAU * numbers.unit()).cos()
}

/// `touch`, each number wrong by `noise` mm.
pub(super) fn shaken(touch: Touch, noise: f64, numbers: &mut SplitMix64) -> Touch {
    shaken_by(touch, [noise; 3], numbers)
}

/// `touch`, its X, Y and Z wrong by `noise` mm.
pub(super) fn shaken_by(mut touch: Touch, noise: [f64; 3], numbers: &mut SplitMix64) -> Touch {
    (0..3).for_each(|i| touch.at[i] += noise[i] * normal(numbers));
    touch
}
