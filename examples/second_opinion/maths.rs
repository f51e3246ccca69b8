//! Vectors, matrices by their columns, boxes and segments. All lengths are in mm.

use std::array::from_fn;

pub type V = [f64; 3];
pub type Facet = [V; 3];

pub fn add<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    from_fn(|i| a[i] + b[i])
}

pub fn sub<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    from_fn(|i| a[i] - b[i])
}

pub fn scale<const N: usize>(a: [f64; N], s: f64) -> [f64; N] {
    a.map(|x| x * s)
}

pub fn lerp<const N: usize>(a: [f64; N], b: [f64; N], t: f64) -> [f64; N] {
    add(a, scale(sub(b, a), t))
}

pub fn dot<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    (0..N).map(|i| a[i] * b[i]).sum()
}

pub fn length(a: V) -> f64 {
    dot(a, a).sqrt()
}

pub fn unit(a: V) -> V {
    scale(a, 1.0 / length(a).max(1e-300))
}

pub fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A vector across a facet, as long as twice its area.
pub fn normal([a, b, c]: Facet) -> V {
    cross(sub(b, a), sub(c, a))
}

/// A vector turned by a matrix, which is given by its columns.
pub fn turned(columns: [V; 3], p: V) -> V {
    add(add(scale(columns[0], p[0]), scale(columns[1], p[1])), scale(columns[2], p[2]))
}

/// A vector turned back by a matrix.
pub fn turned_back(columns: [V; 3], p: V) -> V {
    columns.map(|column| dot(column, p))
}

/// Number of steps of at most `step` over a way.
pub fn steps(way: f64, step: f64) -> usize {
    (way / step).ceil().clamp(1.0, 1e6) as usize
}

/// Lowest and highest corner of the box around points; infinite without any.
pub fn bounds(points: impl IntoIterator<Item = V>) -> [V; 2] {
    let empty = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    points.into_iter().fold(empty, |[low, high], p| [from_fn(|i| low[i].min(p[i])), from_fn(|i| high[i].max(p[i]))])
}

/// The way to a point from the nearest point of a segment.
pub fn away<const N: usize>([a, b]: [[f64; N]; 2], p: [f64; N]) -> [f64; N] {
    let (along, to) = (sub(b, a), sub(p, a));
    sub(to, scale(along, (dot(to, along) / dot(along, along).max(1e-300)).clamp(0.0, 1.0)))
}

pub fn segment_distance(segment: [[f64; 2]; 2], p: [f64; 2]) -> f64 {
    let [x, y] = away(segment, p);
    x.hypot(y)
}
