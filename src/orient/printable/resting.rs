//! Poses in which a part rests: it is let go and rolls over its lowest points until its centre of mass is held, and the planes of
//! its largest flat faces.

use std::collections::BTreeMap;

use super::super::facets::FLAT;
use super::super::sphere::lattice;
use super::super::{Facets, Mass};
use crate::geom::Vec3;

/// Directions whose lowest points stand for the convex hull, and from which the part is let go.
const DROPS: usize = 600;
/// Rolls after which a part is taken to rest: each lowers the centre of mass, so none comes back.
const MOST_ROLLS: usize = 60;
/// Points nearer to a plane than this share of the part's size lie in it.
const IN_PLANE: f64 = 1e-7;
/// Poses nearer than this (radians) are one.
const SAME: f64 = 5e-4;
/// Cells of a unit of a normal's coordinate, to gather faces.
const CELLS: f64 = 48.0;

/// The poses in which the part comes to rest on its hull, distinct.
pub(super) fn resting(facets: &Facets, mass: &Mass) -> Vec<Vec3> {
    let mut points: Vec<Vec3> = (0..DROPS).map(|i| facets.lowest(&lattice(i, DROPS))).collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    points.dedup();
    let slack = IN_PLANE * facets.reach();
    let mut all: Vec<Vec3> = Vec::new();
    for i in 0..DROPS {
        let rests = settled(&points, &mass.centre, lattice(i, DROPS), slack);
        rests.into_iter().for_each(|up| push(&mut all, up));
    }
    all
}

/// Adds `up` where it is new.
pub(super) fn push(all: &mut Vec<Vec3>, up: Vec3) {
    if all.iter().all(|known| (known - up).norm() > SAME) {
        all.push(up);
    }
}

/// Where a body of `points` comes to rest that is let go with `up` upward.
fn settled(points: &[Vec3], centre: &Vec3, up: Vec3, slack: f64) -> Option<Vec3> {
    let lowest = points.iter().min_by(|a, b| a.dot(&up).total_cmp(&b.dot(&up)))?;
    let to = centre - lowest;
    let mut up = roll(points, lowest, up, to - up * to.dot(&up), slack)?;
    for _ in 0..MOST_ROLLS {
        let bed = points.iter().map(|p| p.dot(&up)).fold(f64::INFINITY, f64::min);
        let held: Vec<&Vec3> = points.iter().filter(|p| p.dot(&up) <= bed + slack).collect();
        let (over, away) = pivot(&held, centre, &up, slack)?;
        // Within the outline, or exactly above its border.
        if away.norm() <= slack {
            return Some(up);
        }
        up = roll(points, &over, up, away, slack)?;
    }
    None
}

/// The point of the held points' outline nearest to below the centre of mass, and the horizontal way from there to it; nothing of
/// a way where the centre is held.
fn pivot(held: &[&Vec3], centre: &Vec3, up: &Vec3, slack: f64) -> Option<(Vec3, Vec3)> {
    let [e1, e2] = super::super::sphere::tangents(up);
    let flat = |p: &Vec3| [p.dot(&e1), p.dot(&e2)];
    let outline = crate::geom::convex_outline(held.iter().map(|p| flat(p)).collect(), 0.0);
    let at = flat(centre);
    let across = |d: [f64; 2]| e1 * d[0] + e2 * d[1];
    let (mut best, mut inside) = ((f64::INFINITY, [0.0; 2]), outline.len() > 2);
    for (i, a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        let (d, w) = ([b[0] - a[0], b[1] - a[1]], [at[0] - a[0], at[1] - a[1]]);
        let square = d[0] * d[0] + d[1] * d[1];
        inside &= d[0] * w[1] - d[1] * w[0] >= -slack * square.sqrt();
        let t = if square > 0.0 { ((d[0] * w[0] + d[1] * w[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
        let away = [w[0] - t * d[0], w[1] - t * d[1]];
        let distance = away[0].hypot(away[1]);
        if distance < best.0 {
            best = (distance, away);
        }
    }
    let away = if inside { [0.0; 2] } else { best.1 };
    let bed = held.first()?.dot(up);
    Some((across([at[0] - away[0], at[1] - away[1]]) + up * bed, across(away)))
}

/// The direction upward once the body has rolled over `pivot` toward `away` until another point touches the bed.
///
/// While it turns by `t` about the pivot, upward is `cos t up - sin t away`: a point `q` from the pivot touches where that is
/// zero along `q`. `None` where no way leads anywhere.
fn roll(points: &[Vec3], pivot: &Vec3, up: Vec3, away: Vec3, slack: f64) -> Option<Vec3> {
    let away = if away.norm() > slack { away.normalize() } else { super::super::sphere::tangents(&up)[0] };
    let turn = |p: &Vec3| {
        let q = p - pivot;
        let (rise, ahead) = (q.dot(&up).max(0.0), q.dot(&away));
        (rise > slack || ahead > slack).then(|| rise.atan2(ahead))
    };
    let turn = points.iter().filter_map(turn).fold(f64::INFINITY, f64::min);
    turn.is_finite().then(|| (up * turn.cos() - away * turn.sin()).normalize())
}

/// The poses that lay the largest flat faces down, and those that turn them up, at most `most` faces: the mean normal of what is
/// parallel to the largest facet among those of nearly one normal.
pub(super) fn flats(facets: &Facets, most: usize) -> Vec<Vec3> {
    let mut cells: BTreeMap<[i32; 3], (f64, f64, Vec3)> = BTreeMap::new();
    for facet in &facets.each {
        let size = facet.area.norm();
        let normal = facet.area / size;
        let cell = [0, 1, 2].map(|k| (normal[k] * CELLS).round() as i32);
        let (sum, largest, best) = cells.entry(cell).or_insert((0.0, 0.0, normal));
        *sum += size;
        if size > *largest {
            (*largest, *best) = (size, normal);
        }
    }
    let mut faces: Vec<(f64, Vec3)> = cells.into_values().map(|(sum, _, normal)| (sum, normal)).collect();
    faces.sort_by(|a, b| b.0.total_cmp(&a.0));
    faces.truncate(most);
    let mut means = vec![Vec3::zeros(); faces.len()];
    for facet in &facets.each {
        let size = facet.area.norm();
        for ((_, normal), mean) in faces.iter().zip(&mut means) {
            if facet.area.dot(normal) >= FLAT * size {
                *mean += facet.area;
            }
        }
    }
    let mut all = Vec::new();
    for mean in means.iter().filter(|mean| mean.norm() > 0.0) {
        push(&mut all, -mean.normalize());
        push(&mut all, mean.normalize());
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;

    #[test]
    fn a_box_rests_on_its_six_faces() {
        let facets = Facets::of(&solid_box(Vec3::new(1.0, 2.0, 3.0), Vec3::new(21.0, 32.0, 63.0)));
        let rests = resting(&facets, &Mass::of(&facets));
        assert_eq!(rests.len(), 6, "{rests:?}");
        assert!(rests.iter().all(|up| up.amax() > 1.0 - 1e-9), "{rests:?}");
        assert_eq!(flats(&facets, 10).len(), 6);
    }

    #[test]
    fn a_leaning_post_does_not_rest_on_its_foot() {
        // 10 mm wide, leaning by 30 over 40 mm: above its foot it falls over; it rests on four sides of its outline.
        let outline = [[0.0, 0.0], [10.0, 0.0], [40.0, 40.0], [30.0, 40.0]];
        let facets = Facets::of(&crate::fixtures::prism(&outline, [0.0, 12.0]));
        let rests = resting(&facets, &Mass::of(&facets));
        assert!(rests.iter().all(|up| (up - Vec3::z()).norm() > 0.1), "{rests:?}");
        assert_eq!(rests.len(), 4, "two ends along y and two slopes: {rests:?}");
        // Let go upright it falls to where it leans, onto its lower slope.
        let points = facets.points.clone();
        let fallen = settled(&points, &facets.mass().centre, Vec3::z(), 1e-6).unwrap();
        assert!((fallen - Vec3::new(-0.8, 0.0, 0.6)).norm() < 1e-9, "{fallen:?}");
    }
}
