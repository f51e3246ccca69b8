//! The idea of Tweaker-3 (C. Schranz, *Tweaker - Auto Rotation Module for FDM 3D Printing*, 2016), written anew from its published
//! formulas and parameters, as a witness: which pose it would choose.
//!
//! Alignments: the ten normals with the largest area; extended also the most common planes through an edge and any corner, and eighteen
//! fixed directions. Each is judged by the area on the bed, the area (or a volume) that overhangs, and the contour on the bed.

use std::collections::BTreeMap;

use trunnion::geom::Vec3;

use crate::solids::Mesh;
use crate::support::Numbers;

/// How it is run: its default and `-x`, minimising the supports' volume or the surfaces that they touch.
#[derive(Clone, Copy)]
pub(crate) struct Mode {
    pub(crate) extended: bool,
    pub(crate) volume: bool,
}

/// The numbers that an evolutionary search found for it.
struct Parameters {
    tar: [f64; 5],
    relative: f64,
    contour: f64,
    bottom: f64,
    first_layer: f64,
    negligible: f64,
    ascent: f64,
    plafond: f64,
    contour_amount: f64,
    power: f64,
    height: [f64; 3],
}

const SURFACE: Parameters = Parameters {
    tar: [0.023251, 0.179677, -0.016564, 1.059249, 0.011504],
    relative: 11.250932,
    contour: 0.219523,
    bottom: 1.320623,
    first_layer: 0.047549,
    negligible: 0.473731,
    ascent: -0.078098,
    plafond: 0.059937,
    contour_amount: 0.018243,
    power: 2.0,
    height: [2.372824, 0.041375, 1.932546],
};
const VOLUME: Parameters = Parameters {
    tar: [0.02353, 0.1649, 0.9634, 0.5623, 0.003744],
    relative: 6.076,
    contour: 0.2403,
    bottom: 1.03,
    first_layer: 0.08547,
    negligible: 0.4198,
    ascent: -0.4095,
    plafond: 0.2729,
    contour_amount: 0.02088,
    power: 1.572,
    height: [2.889, 0.05288, 1.155],
};

struct Face {
    normal: Vec3,
    area: f64,
    corners: [Vec3; 3],
}

/// The direction that it turns up.
pub(crate) fn choice(mesh: &Mesh, mode: Mode) -> Vec3 {
    let known = if mode.volume { &VOLUME } else { &SURFACE };
    let faces = faces(mesh, known.negligible * if mode.extended { 0.1 } else { 1.0 });
    let mut downs = vec![-Vec3::z()];
    downs.extend(most(faces.iter().map(|f| (f.normal, f.area)), 10).into_iter().map(|(n, _)| n));
    if mode.extended {
        downs.extend(planes(&faces));
        downs.extend(fixed());
        let mut kept: Vec<Vec3> = Vec::new();
        for down in downs {
            let near = |k: &Vec3| (k - down).amax() <= 5.0_f64.to_radians().sin();
            if !kept.iter().any(near) {
                kept.push(down);
            }
        }
        downs = kept;
    }
    let judged = downs.iter().map(|down| (-down, unprintable(&faces, &-down, mode, known)));
    judged.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap().0
}

fn faces(mesh: &Mesh, negligible: f64) -> Vec<Face> {
    let face = |f: &[u32; 3]| {
        let corners = f.map(|i| mesh.vertices()[i as usize]);
        let across = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        (across.norm() > 0.0).then(|| Face { normal: across.normalize(), area: across.norm() / 2.0, corners })
    };
    let all: Vec<Face> = mesh.facets().iter().filter_map(face).collect();
    if all.iter().filter(|f| f.area > negligible).count() > 100 {
        return all.into_iter().filter(|f| f.area > negligible).collect();
    }
    all
}

/// Weights summed by direction (to six digits), the largest first.
fn most(all: impl Iterator<Item = (Vec3, f64)>, count: usize) -> Vec<(Vec3, f64)> {
    let mut sums: BTreeMap<[i64; 3], (Vec3, f64)> = BTreeMap::new();
    for (direction, weight) in all {
        let key = [0, 1, 2].map(|k| (direction[k] * 1e6).round() as i64);
        sums.entry(key).or_insert((direction, 0.0)).1 += weight;
    }
    let mut sums: Vec<(Vec3, f64)> = sums.into_values().collect();
    sums.sort_by(|a, b| b.1.total_cmp(&a.1));
    sums.truncate(count);
    sums
}

/// Planes through two corners of a face and one of any other, as often as they come; both senses.
fn planes(faces: &[Face]) -> Vec<Vec3> {
    let mut numbers = Numbers::seeded(3);
    let count = faces.len();
    let mut all = Vec::new();
    for turn in 0..(20_000.0 / (count + 100) as f64).ceil() as usize {
        let (one, step) = (numbers.between(0.0, 3.0) as usize % 3, 1 + numbers.between(0.0, 2.0) as usize % 2);
        for (k, face) in faces.iter().enumerate() {
            let third = faces[(k * 127 + 8191 + turn) % count].corners[turn % 3];
            let (a, b) = (face.corners[one], face.corners[(one + step) % 3]);
            let across = (third - a).cross(&(b - a));
            if across.norm() > 0.0 {
                all.push((across.normalize(), 1.0));
            }
        }
    }
    let common = most(all.into_iter(), 12);
    common.into_iter().filter(|(_, count)| *count > 2.0).flat_map(|(n, _)| [n, -n]).collect()
}

/// The axes, and what lies midway between two of them.
fn fixed() -> Vec<Vec3> {
    let mut all = Vec::new();
    for i in 0..27_i32 {
        let v = Vec3::new(f64::from(i % 3 - 1), f64::from(i / 3 % 3 - 1), f64::from(i / 9 - 1));
        if (0.5..2.5).contains(&v.norm_squared()) {
            all.push(v.normalize());
        }
    }
    all
}

fn unprintable(faces: &[Face], up: &Vec3, mode: Mode, known: &Parameters) -> f64 {
    let heights: Vec<[f64; 3]> = faces.iter().map(|f| f.corners.map(|c| c.dot(up))).collect();
    let low = heights.iter().flatten().copied().fold(f64::INFINITY, f64::min);
    let first = low + known.first_layer;
    let (mut bottom, mut hangs, mut contour, mut level) = (0.0, 0.0, 0.0, 0.0);
    for (face, z) in faces.iter().zip(&heights) {
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| z[*a].total_cmp(&z[*b]));
        let (highest, middle) = (z[order[2]], z[order[1]]);
        if highest < first {
            bottom += face.area;
        }
        let along = face.normal.dot(up) - known.ascent;
        if along < 0.0 && highest > first {
            let slope = face.area * along.abs().powf(known.power);
            let lift = (face.corners[0] + face.corners[1] + face.corners[2]).dot(up) / 3.0 - low;
            let [a, b, c] = known.height;
            hangs += if mode.volume { (a + b * (c * lift + 1.0).ln()) * slope } else { 2.0 * slope };
            level += if (face.normal + up).norm() < 1e-9 { face.area } else { 0.0 };
        }
        if middle < first {
            contour += (face.corners[order[0]] - face.corners[order[1]]).norm() + known.contour_amount;
        }
    }
    if mode.extended {
        hangs -= known.plafond * level;
    } else {
        contour = 4.0 * f64::sqrt(bottom);
    }
    let [a, b, c, d, e] = known.tar;
    if mode.volume {
        hangs /= 25.0;
    }
    let more = if mode.volume { e * hangs } else { 0.0 };
    a * (hangs + b) + known.relative * (hangs + c) / (d + known.contour * contour + known.bottom * bottom + more)
}
