//! The tower's shape on one machine, and what is measured of it.

use super::error::TowerError;
use crate::gcode::round_to;
use crate::geom::{Angle, Object, Vec3};
use crate::mesh::TriangleMesh;
use crate::motion::{AxisRange, Pose, TableKinematics};
use crate::profile::Profile;

/// What a tower is made by; all else follows from these and the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TowerDesign {
    /// The tilt's word of the two blocks, degrees.
    pub tilt_deg: f64,
    /// The rotation's words: of the base, and half a turn from there, degrees.
    pub rotation_deg: [f64; 2],
    /// Half of the roof, across, mm.
    pub half_mm: f64,
    /// From the table to where the slopes begin, mm.
    pub lift_mm: f64,
    /// Height of a layer: all heights are whole layers, mm.
    pub layer_mm: f64,
}

/// A corner of a printed block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockCorner {
    /// Where it was drawn, table frame, mm.
    pub at: Vec3,
    /// How it moves where every wall is a millimetre further out, table frame.
    pub outward: Vec3,
}

/// A closed piece that is printed at one pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Its name.
    pub name: &'static str,
    /// In which of the four poses it is printed ([`Tower::words_deg`]).
    pub step: usize,
    /// A face, and how far it is drawn out.
    ring: Vec<Vec3>,
    drawn: Vec3,
    /// Its corners; none of the base, which is not measured.
    pub corners: Vec<BlockCorner>,
}

/// What callipers measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DimensionKind {
    /// The width over two blocks, by their places, along a unit vector of the table's frame that turns with the base as it was printed: the
    /// jaws stand on its roof.
    Across([usize; 2], Vec3),
    /// From the underside of the base to the highest corner of a block.
    Height(usize),
}

/// A numbered dimension.
#[derive(Clone, Debug, PartialEq)]
pub struct Dimension {
    /// From 1.
    pub number: usize,
    /// What is measured.
    pub kind: DimensionKind,
    /// As drawn, mm.
    pub drawn_mm: f64,
    /// A reading further off is a mistake, mm.
    pub most_mm: f64,
    /// Between what, in words.
    pub name: String,
}

/// A calibration tower on one machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Tower {
    /// What it was made by.
    pub design: TowerDesign,
    /// The base first.
    pub blocks: Vec<Block>,
    /// What is measured.
    pub dimensions: Vec<Dimension>,
    /// The tilt axis's direction and the direction in which the first block leans, table frame.
    pub axes: [Vec3; 2],
    /// Height of the roof, mm.
    pub roof_mm: f64,
    level_deg: f64,
}

/// Half of the base, along the tilt axis, mm.
const HALF_ALONG_MM: f64 = 14.0;
/// Half of the roof, across, mm: of a usual tower, and of those for small tables.
const HALVES_MM: [f64; 3] = [20.0, 14.0, 12.0];
/// Length of a slope, mm.
const SLOPE_MM: f64 = 12.0;
/// From the upper edge of a slope to where a block begins and ends, mm.
const BLOCK_MM: [f64; 2] = [1.0, 10.0];
/// How far a block's outermost edge stands out from the base at least: what is displaced stays outermost, mm.
const OUT_MM: f64 = 3.0;
/// How high above the roof its highest edge is at least: lower than all posts, or, where the cosine of the tilt is above [`FLAT`], higher; mm.
const LOW_MM: f64 = 1.2;
const HIGH_MM: f64 = 5.4;
const FLAT: f64 = 0.6;
/// How much higher one block's edge is than the other's: two that are exchanged are noticed, mm.
const APART_MM: f64 = 0.7;
/// Tilts that are tried, degrees: a steep one tells more, a flat one leaves the head more room.
const TILTS_DEG: [f64; 4] = [60.0, 45.0, 30.0, 20.0];
/// Heights at which slopes begin that are tried, mm.
const LIFTS_MM: [f64; 4] = [5.0, 9.0, 14.0, 22.0];
/// No reading of a width, of the width over the blocks and of a height is further off, mm: what is displaced by more was not printed.
const MOST_MM: [f64; 3] = [4.5, 9.0, 3.0];

/// The middle of a range of words that the axis goes through.
fn admits(axis: &AxisRange, word: f64) -> bool {
    axis.admits(axis.angle_of(Angle::from_deg(word)))
}

impl TowerDesign {
    /// All that may be tried on a machine, the one that tells most first: at `tilt_deg` alone where that is given (a word, degrees).
    ///
    /// # Errors
    ///
    /// [`TowerError::NotSquare`], [`TowerError::Range`] and [`TowerError::NoRoom`].
    pub fn candidates(profile: &Profile, name: &str, tilt_deg: Option<f64>) -> Result<Vec<Self>, TowerError> {
        let table = profile.kinematics();
        if table.misaligned.is_some() {
            return Err(TowerError::NotSquare { profile: name.to_owned() });
        }
        let rotation_deg = half_turn(&table.rotation)?;
        let layer_mm = profile.process.layer_height_mm;
        let mut all = Vec::new();
        for tilt_deg in tilts(&table.tilt, tilt_deg)? {
            let angle = table.tilt.angle_of(Angle::from_deg(tilt_deg));
            if let Some(half_mm) = half_of(profile, angle) {
                all.extend(LIFTS_MM.map(|lift_mm| Self { tilt_deg, rotation_deg, half_mm, lift_mm, layer_mm }));
            }
        }
        let need = 2.0 * around(HALVES_MM[2], Angle::from_deg(TILTS_DEG[0]));
        if all.is_empty() { Err(TowerError::NoRoom { profile: name.to_owned(), need }) } else { Ok(all) }
    }
}

fn beyond(axis: &AxisRange, need: &str) -> TowerError {
    let (low, high) = axis.range.map_or((f64::NEG_INFINITY, f64::INFINITY), |(low, high)| (low.deg(), high.deg()));
    TowerError::Range { letter: char::from(axis.letter), low, high, need: need.to_owned() }
}

/// Two words of the rotation, half a turn apart.
fn half_turn(axis: &AxisRange) -> Result<[f64; 2], TowerError> {
    let (low, high) = axis.range.map_or((0.0, 360.0), |(low, high)| (low.deg(), high.deg()));
    let zero = round_to(axis.zero.deg(), 4);
    let first = zero.min(high - 180.0).max(low);
    let pairs = [[zero, zero + 180.0], [zero, zero - 180.0], [first, first + 180.0]];
    let fits = |pair: &[f64; 2]| pair.iter().all(|word| admits(axis, *word));
    pairs.into_iter().find(fits).ok_or_else(|| beyond(axis, "two rotations half a turn apart"))
}

/// The words that are tried: on the side to which the table tilts further.
fn tilts(axis: &AxisRange, wanted: Option<f64>) -> Result<Vec<f64>, TowerError> {
    let word = |deg: f64| round_to(axis.word_of(Angle::from_deg(deg)).deg(), 4);
    let found: Vec<f64> = match wanted {
        Some(wanted) => {
            let angle = axis.angle_of(Angle::from_deg(wanted)).deg().abs();
            let fine = admits(axis, wanted) && (10.0..=75.0).contains(&angle);
            fine.then_some(wanted).into_iter().collect()
        }
        None => TILTS_DEG
            .iter()
            .filter_map(|&deg| [word(deg), word(-deg)].into_iter().find(|word| admits(axis, *word)))
            .collect(),
    };
    if !admits(axis, word(0.0)) || found.is_empty() {
        let need = match wanted {
            Some(wanted) => {
                format!("its level place, and a tilt of 10 to 75 deg to either side of it; --tilt is {wanted}")
            }
            None => "its level place, and a tilt of 20 deg".to_owned(),
        };
        return Err(beyond(axis, &need));
    }
    Ok(found)
}

/// How far the base reaches from its middle, mm.
fn around(half_mm: f64, tilt: Angle) -> f64 {
    HALF_ALONG_MM.hypot(half_mm + SLOPE_MM * tilt.rad().cos())
}

/// The largest roof whose base, at any turn, stays on the table.
fn half_of(profile: &Profile, tilt: Angle) -> Option<f64> {
    let fits = |half: &f64| {
        let r = around(*half, tilt);
        [[r, 0.0], [0.0, r]].iter().all(|[x, y]| profile.beyond_table(*x, *y) <= 0.0)
    };
    HALVES_MM.into_iter().find(fits)
}

/// A frame in which a block is a box: its origin, and three directions, the last of which is built along.
struct Upright {
    origin: Vec3,
    axes: [Vec3; 3],
}

impl Upright {
    /// A box between two corners.
    fn block(&self, name: &'static str, step: usize, low: [f64; 3], high: [f64; 3]) -> Block {
        let [a, u, d] = self.axes;
        let at = |p: [f64; 3]| self.origin + a * p[0] + u * p[1] + d * p[2];
        let sides = [(0, 0), (1, 0), (1, 1), (0, 1)];
        let end = [low, high];
        let ring: Vec<Vec3> = sides.iter().map(|&(i, j)| at([end[i][0], end[j][1], low[2]])).collect();
        let outward = |(i, j): (usize, usize)| a * (2.0 * i as f64 - 1.0) + u * (2.0 * j as f64 - 1.0);
        let corner = |z: f64| move |side: &(usize, usize)| (*side, z);
        let corners = sides.iter().map(corner(low[2])).chain(sides.iter().map(corner(high[2])));
        let corners = corners
            .map(|((i, j), z)| BlockCorner { at: at([end[i][0], end[j][1], z]), outward: outward((i, j)) })
            .collect();
        Block { name, step, ring, drawn: d * (high[2] - low[2]), corners }
    }
}

impl Block {
    /// The middle of the face that it begins with, table frame, mm.
    pub fn foot(&self) -> Vec3 {
        self.ring.iter().sum::<Vec3>() / self.ring.len() as f64
    }

    /// The direction along which it was drawn out, table frame: of a block that is measured, its build direction.
    pub fn up(&self) -> Vec3 {
        self.drawn.normalize()
    }

    /// Its surface, table frame.
    pub fn mesh(&self) -> TriangleMesh<Object> {
        let n = self.ring.len() as u32;
        let vertices = self.ring.iter().copied().chain(self.ring.iter().map(|p| p + self.drawn)).collect();
        let floor = (1..n - 1).map(|i| [0, i + 1, i]);
        let roof = (1..n - 1).map(|i| [n, n + i, n + i + 1]);
        let sides = (0..n).flat_map(|i| {
            let j = (i + 1) % n;
            [[i, j, n + j], [i, n + j, n + i]]
        });
        TriangleMesh::new(vertices, floor.chain(roof).chain(sides).collect())
    }
}

impl Tower {
    /// How many dimensions a tower has.
    pub const DIMENSIONS: usize = 10;

    /// The tower of `design` on a machine.
    pub fn of(table: &TableKinematics, design: TowerDesign) -> Self {
        let level_deg = round_to(table.tilt.word_of(Angle::ZERO).deg(), 4);
        let tilt = table.tilt.angle_of(Angle::from_deg(design.tilt_deg));
        let turned = table.rotation.angle_of(Angle::from_deg(design.rotation_deg[0]));
        let up = table.forward(Pose { tilt, rotation: turned }).rotation.transpose() * Vec3::z();
        let across = Vec3::new(up.x, up.y, 0.0).normalize();
        let along = across.cross(&Vec3::z());
        let (s, c) = (up.z.clamp(-1.0, 1.0).acos().sin(), up.z);
        let layers = |mm: f64| (mm / design.layer_mm - 1e-6).ceil() * design.layer_mm;
        let roof_mm = layers(design.lift_mm + SLOPE_MM * s);
        let shape = Shape { design, along, across, s, c, roof_mm };
        let blocks = shape.blocks();
        let dimensions = shape.dimensions(&blocks);
        Self { design, blocks, dimensions, axes: [along, across], roof_mm, level_deg }
    }

    /// The words of tilt and rotation of each step, degrees: level, level after half a turn, tilted, tilted after half a turn.
    pub fn words_deg(&self) -> [[f64; 2]; 4] {
        let ([first, second], tilt) = (self.design.rotation_deg, self.design.tilt_deg);
        [[self.level_deg, first], [self.level_deg, second], [tilt, first], [tilt, second]]
    }
}

/// What the blocks are cut from.
struct Shape {
    design: TowerDesign,
    along: Vec3,
    across: Vec3,
    /// Sine and cosine of the tilt.
    s: f64,
    c: f64,
    roof_mm: f64,
}

/// Places of the blocks.
const LATER_RIGHT: usize = 3;
const FIRST_LEFT: usize = 1;
const FIRST_MIDDLE: usize = 2;
const LATER_LEFT: usize = 4;
const SLOPES: [usize; 2] = [5, 6];

impl Shape {
    fn at(&self, [a, k, z]: [f64; 3]) -> Vec3 {
        self.along * a + self.across * k + Vec3::z() * z
    }

    /// The frame on the first slope, or, turned by half a turn, on the other: origin at the upper edge, then outward and down the slope.
    fn slope(&self, sign: f64) -> Upright {
        let (a, k) = (self.along * sign, self.across * sign);
        let origin = k * self.design.half_mm + Vec3::z() * self.roof_mm;
        Upright { origin, axes: [a, k * self.c - Vec3::z() * self.s, k * self.s + Vec3::z() * self.c] }
    }

    /// Of the thinner block: its outermost edge stands out from the base, its highest one from the roof, and no height is near that of a post.
    fn thickness(&self) -> f64 {
        let out = (SLOPE_MM * self.c - BLOCK_MM[1] * self.c + OUT_MM) / self.s;
        let lowest = if self.c > FLAT { HIGH_MM } else { LOW_MM };
        out.max((lowest + BLOCK_MM[0] * self.s) / self.c)
    }

    fn blocks(&self) -> Vec<Block> {
        let (half, top, foot) = (self.design.half_mm, self.roof_mm, self.roof_mm - SLOPE_MM * self.s);
        let wide = half + SLOPE_MM * self.c;
        let outline = [[-wide, 0.0], [wide, 0.0], [wide, foot], [half, top], [-half, top], [-wide, foot]];
        let ring = outline.map(|[k, z]| self.at([-HALF_ALONG_MM, k, z])).to_vec();
        let base =
            Block { name: "base", step: 0, ring, drawn: self.along * (2.0 * HALF_ALONG_MM), corners: Vec::new() };
        let roof = Upright { origin: Vec3::z() * top, axes: [self.along, self.across, Vec3::z()] };
        let layer = self.design.layer_mm;
        let high = |mm: f64| (mm / layer).round().max(1.0) * layer;
        let far = half - 3.0;
        let post = |name, step, [a0, a1]: [f64; 2], [k0, k1]: [f64; 2], h: f64| {
            roof.block(name, step, [a0, k0, 0.0], [a1, k1, high(h)])
        };
        let on_slope = |name, step, sign, h: f64| {
            self.slope(sign).block(name, step, [-6.0, BLOCK_MM[0], 0.0], [6.0, BLOCK_MM[1], high(h)])
        };
        let thick = self.thickness();
        vec![
            base,
            post("post-a", 0, [-12.0, -4.0], [far - 6.0, far], 3.0),
            post("post-b", 0, [-3.0, 3.0], [-3.0, 3.0], 2.0),
            post("post-c", 1, [6.0, 12.0], [far - 6.0, far], 3.8),
            post("post-d", 1, [-12.0, -6.0], [-far, 6.0 - far], 4.6),
            on_slope("block-e", 2, 1.0, thick + APART_MM / self.c),
            on_slope("block-f", 3, -1.0, thick),
        ]
    }

    fn dimensions(&self, blocks: &[Block]) -> Vec<Dimension> {
        let wide = |one, other, towards| (DimensionKind::Across([one, other], towards), MOST_MM[0]);
        let kinds = [
            wide(FIRST_LEFT, LATER_RIGHT, self.along),
            wide(LATER_LEFT, FIRST_MIDDLE, self.along),
            wide(LATER_LEFT, FIRST_LEFT, self.across),
            wide(FIRST_MIDDLE, LATER_RIGHT, self.across),
            (DimensionKind::Across(SLOPES, self.across), MOST_MM[1]),
            (DimensionKind::Height(FIRST_LEFT), MOST_MM[2]),
            (DimensionKind::Height(LATER_RIGHT), MOST_MM[2]),
            (DimensionKind::Height(LATER_LEFT), MOST_MM[2]),
            (DimensionKind::Height(SLOPES[0]), MOST_MM[2]),
            (DimensionKind::Height(SLOPES[1]), MOST_MM[2]),
        ];
        let letter = |block: usize| blocks[block].name.rsplit('-').next().unwrap_or_default().to_uppercase();
        let named = |(index, (kind, most_mm)): (usize, (DimensionKind, f64))| {
            let (drawn_mm, name) = match kind {
                DimensionKind::Across([i, j], towards) => {
                    let of = |block: usize| blocks[block].corners.iter().map(move |c| c.at.dot(&towards));
                    let (high, low) =
                        (of(i).chain(of(j)).fold(f64::MIN, f64::max), of(i).chain(of(j)).fold(f64::MAX, f64::min));
                    (high - low, format!("width over {} and {}", letter(i), letter(j)))
                }
                DimensionKind::Height(block) => {
                    let high = blocks[block].corners.iter().map(|c| c.at.z).fold(f64::MIN, f64::max);
                    (high, format!("height of {} above the underside", letter(block)))
                }
            };
            Dimension { number: index + 1, kind, drawn_mm, most_mm, name }
        };
        kinds.into_iter().enumerate().map(named).collect()
    }
}
