//! Models to be packed, the ways in which each may be turned, and where they end up.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use super::askew::{Askew, about_z as about_z_into, in_every_way};
use super::instance::Turns;
use crate::geom::{Bounds, Mat3, Object, Vec3, convex_outline};
use crate::mesh::TriangleMesh;

/// A model: closed surfaces that move as one, the file's frame, mm.
#[derive(Clone, Debug)]
pub struct PackSolid {
    /// Its facets' corners.
    pub facets: Vec<[Vec3; 3]>,
    /// What it encloses, mm³.
    pub volume_mm3: f64,
    /// What having it in a run is worth.
    pub value: f64,
    /// How many are asked for.
    pub copies: usize,
}

/// The space of each run, and how models may lie in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// The space, mm, from the origin.
    pub space_mm: [f64; 3],
    /// The least distance between two models, mm; above 0.
    pub gap_mm: f64,
    /// How models may be turned.
    pub turns: Turns,
    /// Whether each must come out straight up, one after the other.
    pub liftable: bool,
}

/// A copy of a model in its place: `p = turn p_file + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Put {
    /// The run, from 0.
    pub run: usize,
    /// The model.
    pub model: usize,
    /// Which of its copies, from 0.
    pub copy: usize,
    /// How it is turned.
    pub turn: Mat3,
    /// Where the file's origin comes, mm.
    pub shift: Vec3,
}

impl PackSolid {
    /// Of a model's parts; an overlap of parts counts twice in its volume.
    pub fn of<'a>(parts: impl IntoIterator<Item = &'a TriangleMesh<Object>>, value: f64, copies: usize) -> Self {
        let (mut facets, mut volume_mm3) = (Vec::new(), 0.0);
        for mesh in parts {
            volume_mm3 += mesh.volume();
            facets.extend((0..mesh.facets().len()).map(|i| mesh.corners(i)));
        }
        Self { facets, volume_mm3, value, copies }
    }

    /// Its facets turned.
    pub fn turned(&self, turn: &Mat3) -> Vec<[Vec3; 3]> {
        self.facets.iter().map(|corners| corners.map(|p| turn * p)).collect()
    }

    /// The box around it as turned, mm.
    pub fn bounds(&self, turn: &Mat3) -> Bounds {
        Bounds::of(self.facets.iter().flatten().map(|p| turn * p))
    }

    /// The turns that are tried, the file's own pose first: quarter turns, about Z also those that make its outline's box smallest and
    /// the angles between; in every way the 24 of a cube.
    pub fn turns(&self, allowed: Turns) -> Vec<Mat3> {
        let quarters = |from: f64| (0..4).map(move |k| about_z(from + f64::from(k) * FRAC_PI_2));
        match allowed {
            Turns::None => vec![Mat3::identity()],
            Turns::Z90 => quarters(0.0).collect(),
            Turns::Z => {
                let snug = self.snug_angle();
                let apart = |a: &f64, b: &f64| ((a - b).rem_euclid(FRAC_PI_2) - FRAC_PI_4).abs() < FRAC_PI_4 - 1e-3;
                let mut angles = vec![0.0];
                for angle in [snug, FRAC_PI_4, FRAC_PI_4 / 2.0, 1.5 * FRAC_PI_4] {
                    if angles.iter().all(|known| apart(known, &angle)) {
                        angles.push(angle);
                    }
                }
                angles.into_iter().flat_map(quarters).collect()
            }
            Turns::Any => cube_turns(),
        }
    }

    /// Whether it goes into a space along none of [`PackSolid::turns`], but askew: about Z exactly, in every way where that can be settled.
    pub fn askew(&self, room: &Room) -> Askew {
        let points: Vec<Vec3> = self.facets.iter().flatten().copied().collect();
        let [wide, deep, high] = room.space_mm;
        match room.turns {
            Turns::None | Turns::Z90 => Askew::Never,
            Turns::Z if self.bounds(&Mat3::identity()).size().z > high + OFF_MM => Askew::Never,
            Turns::Z => about_z_into(&points, [wide, deep]).map_or(Askew::Never, |angle| Askew::Fits(about_z(angle))),
            Turns::Any => in_every_way(&points, room.space_mm),
        }
    }

    /// The angle about Z at which the box around its outline is smallest: along one of the convex outline's edges.
    pub fn snug_angle(&self) -> f64 {
        let ring = convex_outline(self.facets.iter().flatten().map(|p| [p.x, p.y]).collect(), 0.0);
        let area = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            let box_of = Bounds::of(ring.iter().map(|[x, y]| Vec3::new(cos * x - sin * y, sin * x + cos * y, 0.0)));
            box_of.size().x * box_of.size().y
        };
        let edges = (0..ring.len()).map(|i| {
            let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
            -(b[1] - a[1]).atan2(b[0] - a[0])
        });
        let best = edges.min_by(|a, b| area(*a).total_cmp(&area(*b))).unwrap_or(0.0);
        // As it was drawn, unless another angle gains something.
        if area(best) < area(0.0) * (1.0 - 1e-6) { best } else { 0.0 }
    }
}

/// Heights that differ by less are one, mm.
const OFF_MM: f64 = 1e-6;

fn about_z(angle: f64) -> Mat3 {
    let quarter = (angle / FRAC_PI_2).round();
    // Quarter turns without a rounding error, so that plane faces stay in their planes.
    let (sin, cos) = if (angle - quarter * FRAC_PI_2).abs() < 1e-12 {
        [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][(quarter as i64).rem_euclid(4) as usize]
    } else {
        angle.sin_cos()
    };
    Mat3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
}

/// The turns that take a cube to itself, the identity first.
pub(super) fn cube_turns() -> Vec<Mat3> {
    let axes = [0, 1, 2].map(|k| Vec3::ith(k, 1.0));
    let mut turns = Vec::new();
    for (i, j) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
        for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let (x, y) = (axes[i] * s, axes[j] * t);
            turns.push(Mat3::from_columns(&[x, y, x.cross(&y)]));
        }
    }
    turns
}

/// A turn as one about a unit axis, degrees from 0 to 180; about +Z for none, and from -180 to 180 about +Z where that is its axis.
pub fn axis_and_angle(turn: &Mat3) -> (Vec3, f64) {
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(*turn);
    // By the quaternion: at half a turn the matrix alone says no axis.
    let turn = nalgebra::UnitQuaternion::from_rotation_matrix(&rotation);
    let (axis, angle) = turn.axis_angle().map_or((Vec3::z(), 0.0), |(axis, angle)| (axis.into_inner(), angle));
    let degrees = (angle.to_degrees() * 1e9).round() / 1e9;
    if axis.z < -1.0 + 1e-12 { (Vec3::z(), -degrees) } else { (axis.map(|v| v + 0.0), degrees) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;

    #[test]
    fn turns_are_turns_and_differ() {
        let plate = PackSolid::of([&solid_box(Vec3::new(1.0, 2.0, 3.0), Vec3::new(5.0, 4.0, 9.0))], 1.0, 1);
        for (allowed, count) in [(Turns::None, 1), (Turns::Z90, 4), (Turns::Z, 16), (Turns::Any, 24)] {
            let turns = plate.turns(allowed);
            assert_eq!((turns.len(), turns[0]), (count, Mat3::identity()));
            for (i, turn) in turns.iter().enumerate() {
                assert!(
                    (turn.determinant() - 1.0).abs() < 1e-12
                        && (turn * turn.transpose() - Mat3::identity()).norm() < 1e-12
                );
                assert!(turns[..i].iter().all(|other| (other - turn).norm() > 0.1));
                let (axis, angle) = axis_and_angle(turn);
                let again = nalgebra::Rotation3::new(axis * angle.to_radians()).into_inner();
                assert!((again - turn).norm() < 1e-9, "{axis} {angle}");
            }
        }
        assert_eq!(plate.volume_mm3.round(), 48.0);
    }

    #[test]
    fn a_plate_that_was_drawn_askew_is_brought_straight() {
        let flat = solid_box(Vec3::zeros(), Vec3::new(40.0, 10.0, 2.0));
        let turn = about_z(0.3);
        let askew = PackSolid {
            facets: PackSolid::of([&flat], 1.0, 1).turned(&turn),
            volume_mm3: 800.0,
            value: 1.0,
            copies: 1,
        };
        let size = askew.bounds(&about_z(askew.snug_angle())).size();
        assert!((size.x * size.y - 400.0).abs() < 1e-6, "{size}");
        assert!(askew.turns(Turns::Z).len() == 20);
    }
}
