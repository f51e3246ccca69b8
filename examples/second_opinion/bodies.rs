//! Bodies that must not meet what is printed: convex pieces of the head and the frame, the table's plate; and distances from them.

use super::certificate::{list, numbers, optional_text, text};
use super::maths::{V, add, away, dot, length, scale, steps, sub, unit};
use serde_json::Value;
use std::array::from_fn;
use std::f64::consts::{PI, TAU};

enum Shape {
    Frustum { z: [f64; 2], r: [f64; 2] },
    Box([V; 2]),
    Hull,
}

/// A convex piece of the head or the frame.
pub struct Body {
    pub follows: [bool; 3],
    shape: Shape,
    pub corners: Vec<V>,
}

impl Body {
    fn read(value: &Value) -> Result<Self, String> {
        let (shape, corners) = match text(value, "/kind")? {
            "frustum" => {
                let (z, r) = (numbers(value, "/z_mm")?, numbers(value, "/r_mm")?);
                let corner = |k: usize| {
                    let (sin, cos) = ((k / 2) as f64 * PI / 16.0).sin_cos();
                    [r[k % 2] * cos, r[k % 2] * sin, z[k % 2]]
                };
                (Shape::Frustum { z, r }, (0..64).map(corner).collect())
            }
            "box" => {
                let ends: [V; 2] = [numbers(value, "/min_mm")?, numbers(value, "/max_mm")?];
                (Shape::Box(ends), (0..8).map(|k| [0, 1, 2].map(|i| ends[k >> i & 1][i])).collect())
            }
            "hull" => {
                let points = 0..list(value, "/points_mm")?.len();
                let points = points.map(|i| numbers(value, &format!("/points_mm/{i}"))).collect::<Result<_, _>>()?;
                (Shape::Hull, points)
            }
            kind => return Err(format!("a body is of the unknown kind {kind}")),
        };
        let moves = optional_text(value, "/moves").unwrap_or("");
        Ok(Self { follows: ['X', 'Y', 'Z'].map(|axis| moves.contains(axis)), shape, corners })
    }

    /// Whether it reaches down to the tip: the part of the head that touches what it prints on.
    pub fn is_nozzle(&self) -> bool {
        self.follows == [true; 3] && self.corners.iter().any(|c| c[2] < 1e-6)
    }

    /// Where its own origin is while the tip is at `tip`.
    pub fn origin(&self, tip: V) -> V {
        [0, 1, 2].map(|i| if self.follows[i] { tip[i] } else { 0.0 })
    }

    /// Distance of a point (own frame), negative inside, and the direction from the body to it.
    pub fn distance(&self, p: V) -> (f64, V) {
        match self.shape {
            Shape::Box(ends) => box_distance(ends, p),
            Shape::Frustum { z, r } => frustum_distance(z, r, p),
            Shape::Hull => hull_distance(&self.corners, p),
        }
    }
}

pub fn bodies(values: &Value, path: &str) -> Result<Vec<Body>, String> {
    list(values, path)?.iter().map(Body::read).collect()
}

/// The table's plate, its top at z = 0 of the table frame: a disc, or a rectangle where the radius is 0.
pub struct Table {
    pub radius: f64,
    pub size: [f64; 2],
    pub thickness: f64,
}

impl Table {
    /// How far a point is beyond the edge, 0 above or below the plate.
    fn beyond(&self, p: V) -> f64 {
        if self.radius > 0.0 {
            return (p[0].hypot(p[1]) - self.radius).max(0.0);
        }
        let out = [0, 1].map(|i| (p[i].abs() - self.size[i] / 2.0).max(0.0));
        out[0].hypot(out[1])
    }

    /// Whether a point is above or below the plate.
    pub fn spans(&self, p: V) -> bool {
        self.beyond(p) == 0.0
    }

    /// Distance of a point, 0 inside.
    pub fn distance(&self, p: V) -> f64 {
        self.beyond(p).hypot(p[2].max(-self.thickness - p[2]).max(0.0))
    }

    /// Points of the edge, 2 mm apart, above and below.
    pub fn rim(&self) -> Vec<V> {
        let [a, b] = self.size.map(|size| size / 2.0);
        let count = steps(6.3 * self.radius.max(a + b), 2.0);
        let pair = |i: usize| {
            let (sin, cos) = (i as f64 / count as f64 * TAU).sin_cos();
            let far = if self.radius > 0.0 { self.radius } else { 1.0 / (cos.abs() / a).max(sin.abs() / b) };
            [0.0, -self.thickness].map(|z| [far * cos, far * sin, z])
        };
        (0..count).flat_map(pair).collect()
    }
}

/// Distance of a point from a box, negative inside, and the direction from the box to it.
fn box_distance([low, high]: [V; 2], p: V) -> (f64, V) {
    let away: V = from_fn(|i| p[i] - p[i].max(low[i]).min(high[i]));
    if dot(away, away) > 0.0 {
        return (length(away), unit(away));
    }
    let sides = (0..3).flat_map(|i| [(p[i] - low[i], i, -1.0), (high[i] - p[i], i, 1.0)]);
    let (depth, side, sign) =
        sides.fold((f64::INFINITY, 0, 0.0), |best, side| if side.0 < best.0 { side } else { best });
    (-depth, from_fn(|i| if i == side { sign } else { 0.0 }))
}

/// Like `box_distance`, of a frustum about the z axis. In the plane through the axis and the point it is a trapezium with the corners
/// `(0, z0), (r0, z0), (r1, z1), (0, z1)`.
fn frustum_distance(z: [f64; 2], r: [f64; 2], p: V) -> (f64, V) {
    let across = p[0].hypot(p[1]);
    let out = if across > 1e-12 { [p[0] / across, p[1] / across] } else { [1.0, 0.0] };
    let ring = [[0.0, z[0]], [r[0], z[0]], [r[1], z[1]], [0.0, z[1]]];
    let (mut best, mut inside) = ((f64::INFINITY, [0.0, 1.0]), true);
    for i in 0..3 {
        let side = [ring[i], ring[i + 1]];
        let ([ex, ez], [dx, dz]) = (sub(side[1], side[0]), away(side, [across, p[2]]));
        inside &= ex * (p[2] - side[0][1]) - ez * (across - side[0][0]) >= 0.0;
        let d = dx.hypot(dz);
        if d < best.0 {
            best = (d, if d > 1e-9 { [dx / d, dz / d] } else { [ez, -ex] });
        }
    }
    let sign = if inside { -1.0 } else { 1.0 };
    let [x, z] = scale(best.1, sign);
    (sign * best.0, [x * out[0], x * out[1], z])
}

/// Distance of a point from the convex hull of others, by Gilbert's iteration, stopped within a hundredth of a millimetre; 0 inside.
fn hull_distance(points: &[V], p: V) -> (f64, V) {
    let mut nearest = points.first().copied().unwrap_or_default();
    for _ in 0..200 {
        let away = sub(p, nearest);
        let Some(&far) = points.iter().max_by(|a, b| dot(**a, away).total_cmp(&dot(**b, away))) else { break };
        let along = sub(far, nearest);
        let gain = dot(along, away);
        if gain <= 0.01 * length(away) {
            break;
        }
        nearest = add(nearest, scale(along, (gain / dot(along, along)).clamp(0.0, 1.0)));
    }
    let away = sub(p, nearest);
    (length(away), unit(away))
}
