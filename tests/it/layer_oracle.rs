//! The rule for what hangs against a judge that shares no code with it: columns of cells whose inside is told by the parity of the
//! facets above and below, no polygons, no sections.
//!
//! ```text
//! past(i)  = cells of layer i farther than 0.8 w from layer i - 1, and not over layer i - 2
//! hangs(i) = connected cells of past(i), one of them farther than 2 mm from layer i - 1; less chords with both ends on that
//! ```
//!
//! What collapses because it droops in many layers in a row is PrusaSlicer's to say (`practised.rs`): where as few as three do, nothing is decided here.
//!
//! A grid cannot decide what is near a limit, so each solid is judged twice, with every limit half a cell's diagonal wider and narrower; a solid
//! on which the two differ is set aside, and counted.

use trunnion::geom::{Angle, Object, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::overhang::{Ground, OverhangRule, unsupported};

use crate::split::solids::{self, Shape};
use crate::support::{Numbers, note, seeds};

const CELL_MM: f64 = 0.12;
/// So much wider and narrower are the two judges' limits: a cell's half diagonal.
const MARGIN_MM: f64 = 0.085;

fn rule() -> OverhangRule {
    let (layer_mm, line_mm) = (0.25, 0.45);
    let overhang = OverhangRule::practised(layer_mm, line_mm);
    OverhangRule { overhang, layer_mm, line_mm, bridge_mm: 8.0, tolerate_mm2: 1.0, droops: true }
}

/// What the judge lets pass, mm.
struct Limits {
    fine: f64,
    ledge: f64,
    bridge: f64,
    free: f64,
    patch_mm2: f64,
    /// No larger pieces may go out by more.
    small_mm2: f64,
    small: f64,
    /// Whether three layers in a row that droop are too many.
    collapses: bool,
}

impl Limits {
    fn of(rule: &OverhangRule, more: f64) -> Self {
        Self {
            fine: 0.8 * rule.line_mm + more,
            ledge: 1.5 + more,
            collapses: more < 0.0,
            bridge: rule.bridge_mm + 3.0 * more,
            free: 2.0 + more,
            small_mm2: 10.0 + 30.0 * more,
            small: 3.0 + more,
            // A patch of 1 mm² is some seventy cells, and most of them lie on its rim.
            patch_mm2: rule.tolerate_mm2 * (1.0 + 9.0 * more),
        }
    }
}

/// Cells of a layer, rows of columns.
#[derive(Clone)]
struct Grid {
    size: [usize; 2],
    cells: Vec<bool>,
}

impl Grid {
    fn empty(size: [usize; 2]) -> Self {
        Self { size, cells: vec![false; size[0] * size[1]] }
    }

    fn at(&self, x: isize, y: isize) -> bool {
        let [w, h] = self.size.map(|n| n as isize);
        (0..w).contains(&x) && (0..h).contains(&y) && self.cells[(y * w + x) as usize]
    }

    /// Whether any cell within `mm` of the middle of this one is set.
    fn within(&self, x: isize, y: isize, mm: f64) -> bool {
        let far = (mm / CELL_MM).floor() as isize;
        (-far..=far).any(|dy| {
            (-far..=far).any(|dx| ((dx * dx + dy * dy) as f64).sqrt() * CELL_MM <= mm && self.at(x + dx, y + dy))
        })
    }

    fn places(&self) -> impl Iterator<Item = [isize; 2]> + '_ {
        let w = self.size[0];
        self.cells.iter().enumerate().filter(|(_, set)| **set).map(move |(i, _)| [(i % w) as isize, (i / w) as isize])
    }

    fn set(&mut self, [x, y]: [isize; 2], value: bool) {
        self.cells[y as usize * self.size[0] + x as usize] = value;
    }

    /// Cells that touch each other, sides and corners.
    fn pieces(&self) -> Vec<Vec<[isize; 2]>> {
        let mut left = self.clone();
        let mut all = Vec::new();
        for start in self.places() {
            if !left.at(start[0], start[1]) {
                continue;
            }
            let mut piece = vec![start];
            left.set(start, false);
            let mut next = 0;
            while let Some(&[x, y]) = piece.get(next) {
                next += 1;
                for (dx, dy) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
                    if left.at(x + dx, y + dy) {
                        left.set([x + dx, y + dy], false);
                        piece.push([x + dx, y + dy]);
                    }
                }
            }
            all.push(piece);
        }
        all
    }
}

/// The layers of a solid that stands on z = 0: a cell is inside where an odd number of facets lies above it.
fn layers(mesh: &TriangleMesh<Object>, h: f64) -> Vec<Grid> {
    let bounds = mesh.bounds();
    let low = [bounds.min.x, bounds.min.y].map(|v| v - 3.0 * CELL_MM);
    let size = [0, 1].map(|i| ((bounds.max[i] - low[i]) / CELL_MM) as usize + 4);
    let count = (bounds.max.z / h + 0.5).floor() as usize;
    // An odd shift, so that no column goes through an edge.
    let middle = |i: usize, n: usize| low[i] + (n as f64 + 0.5) * CELL_MM + 1.7e-5 * (1.0 + i as f64);
    let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); size[0] * size[1]];
    for facet in 0..mesh.facets().len() {
        let [a, b, c] = mesh.corners(facet);
        let twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if twice.abs() < 1e-12 {
            continue;
        }
        let span = |i: usize| {
            let v = [a[i], b[i], c[i]];
            let first = (v.iter().copied().fold(f64::MAX, f64::min) - low[i]) / CELL_MM - 1.0;
            let last = (v.iter().copied().fold(f64::MIN, f64::max) - low[i]) / CELL_MM + 1.0;
            first.max(0.0) as usize..(last as usize + 1).min(size[i])
        };
        for y in span(1) {
            for x in span(0) {
                let (px, py) = (middle(0, x), middle(1, y));
                let s = ((c.y - a.y) * (px - a.x) - (c.x - a.x) * (py - a.y)) / twice;
                let t = ((a.y - b.y) * (px - a.x) - (a.x - b.x) * (py - a.y)) / twice;
                if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
                    crossings[y * size[0] + x].push(a.z + s * (b.z - a.z) + t * (c.z - a.z));
                }
            }
        }
    }
    let layer = |i: usize| {
        let z = (i as f64 + 0.5) * h;
        Grid { size, cells: crossings.iter().map(|zs| zs.iter().filter(|v| **v > z).count() % 2 == 1).collect() }
    };
    (0..count).map(layer).collect()
}

/// How far from a cell along a direction the layer goes on over air, mm, and whether it ends on what is carried.
fn ray(layer: &Grid, below: &Grid, from: [isize; 2], [dx, dy]: [f64; 2], most: f64) -> (f64, bool) {
    let mut gone = 0.0;
    while gone <= most {
        let place =
            [from[0] as f64 + dx * gone / CELL_MM, from[1] as f64 + dy * gone / CELL_MM].map(|v| v.round() as isize);
        if below.at(place[0], place[1]) {
            return (gone, true);
        }
        if !layer.at(place[0], place[1]) {
            return (gone, false);
        }
        gone += CELL_MM / 2.0;
    }
    (gone, false)
}

/// Whether the cell lies on a bridge along the direction, or on one side of a hole's roof.
fn bridged(layer: &Grid, below: &Grid, at: [isize; 2], [dx, dy]: [f64; 2], limits: &Limits) -> bool {
    let (ahead, held_ahead) = ray(layer, below, at, [dx, dy], limits.bridge);
    let (behind, held_behind) = ray(layer, below, at, [-dx, -dy], limits.bridge);
    let open = |gone: f64, sign: f64| {
        // Over the opening to the other side of the hole.
        let mut over = gone;
        while over <= limits.bridge {
            let place = [dx, dy].map(|d| sign * d * over / CELL_MM);
            let place = [at[0] as f64 + place[0], at[1] as f64 + place[1]].map(|v| v.round() as isize);
            if layer.at(place[0], place[1]) {
                return if below.at(place[0], place[1]) {
                    None
                } else {
                    let (rest, held) = ray(layer, below, place, [sign * dx, sign * dy], limits.bridge);
                    (held && rest <= limits.free).then_some(over + rest)
                };
            }
            over += CELL_MM / 2.0;
        }
        None
    };
    let side = |anchored: f64, loose: f64, sign: f64| {
        anchored + loose <= limits.free && open(loose, sign).is_some_and(|far| anchored + far <= limits.bridge)
    };
    match (held_ahead, held_behind) {
        (true, true) => ahead + behind <= limits.bridge,
        (true, false) => side(ahead, behind, -1.0),
        (false, true) => side(behind, ahead, 1.0),
        (false, false) => false,
    }
}

/// What hangs of a solid on z = 0: the areas of the patches that are too large, mm².
fn judged(all: &[Grid], limits: &Limits) -> Vec<f64> {
    // By patch: its area, and the cells of the last layer that it was seen in.
    let mut patches: Vec<(f64, usize, Vec<[isize; 2]>)> = Vec::new();
    // Of the last layer: how many in a row are past, and their cells.
    let mut rows: Vec<(usize, Vec<[isize; 2]>)> = Vec::new();
    for (i, layer) in all.iter().enumerate().skip(1) {
        let mut past = Grid::empty(layer.size);
        let below = &all[i - 1];
        for [x, y] in layer.places() {
            let near = i == 1 || all[i - 2].at(x, y);
            if !near && !below.at(x, y) && !below.within(x, y, limits.fine) {
                past.set([x, y], true);
            }
        }
        let mut row: Vec<(usize, Vec<[isize; 2]>)> = Vec::new();
        for piece in past.pieces() {
            let farther = |mm: f64| piece.iter().any(|&[x, y]| !below.within(x, y, mm));
            let close = |cells: &Vec<[isize; 2]>| {
                let far = (2.4 / CELL_MM) as isize;
                piece.iter().any(|p| cells.iter().any(|q| (p[0] - q[0]).abs() <= far && (p[1] - q[1]).abs() <= far))
            };
            let before = rows.iter().filter(|(_, cells)| close(cells)).map(|(count, _)| *count).max().unwrap_or(0);
            row.push((before + 1, piece.clone()));
            if limits.collapses && before >= 2 {
                return vec![f64::INFINITY];
            }
            if !farther(limits.ledge) {
                continue;
            }
            let loose = |k: usize| {
                let (s, c) = (std::f64::consts::PI * k as f64 / 12.0).sin_cos();
                piece.iter().filter(|at| !bridged(layer, below, **at, [c, s], limits)).count()
            };
            let least = (0..12).map(loose).min().unwrap_or(0) as f64 * CELL_MM * CELL_MM;
            let whole = piece.len() as f64 * CELL_MM * CELL_MM;
            let little = least <= limits.small_mm2 && (least < whole / 2.0 || !farther(limits.small));
            if least == 0.0 || little || !farther(limits.free) {
                continue;
            }
            let near = |cells: &Vec<[isize; 2]>| {
                let far = (0.4 / CELL_MM) as isize;
                piece.iter().any(|p| cells.iter().any(|q| (p[0] - q[0]).abs() <= far && (p[1] - q[1]).abs() <= far))
            };
            match patches.iter_mut().find(|(_, last, cells)| i - last <= 1 && near(cells)) {
                Some(patch) => *patch = (patch.0 + least, i, piece.clone()),
                None => patches.push((least, i, piece.clone())),
            }
        }
        rows = row;
    }
    patches.into_iter().map(|p| p.0).filter(|area| *area > limits.patch_mm2).collect()
}

/// A plate with random pieces on it, some taken away; every other solid is tame: low steps, slopes near the threshold, narrow holes.
fn solid(seed: u64) -> Shape {
    let numbers = &mut Numbers::seeded(seed);
    let tame = !seed.is_multiple_of(3);
    let mut all = solids::block(14.0, 12.0, if tame { 7.0 } else { 2.0 }).at(-7.0, -6.0, 0.0);
    for k in 0..if tame { 2 } else { 5 } {
        let kind = (numbers.between(0.0, 4.0) as usize).min(3);
        let size = [(); 3].map(|()| numbers.between(2.0, 9.0));
        let [x, y, _] = numbers.triple(4.0);
        let z = numbers.between(0.5, 6.0);
        let through = |radius: f64, height: f64| {
            let rod = solids::rod(radius, 40.0, 24).at(0.0, 0.0, -20.0).about_y(90.0).about_z(90.0 * (k % 2) as f64);
            rod.at(x, y, height)
        };
        let (piece, hole) = match (kind, tame) {
            (0, false) => {
                (solids::block(size[0], size[1], size[2]).at(x - size[0] / 2.0, y - size[1] / 2.0, z), k == 3)
            }
            (1, false) => {
                (solids::rod(size[0] * 0.3, size[2], 24).about_y(numbers.between(0.0, 90.0)).at(x, y, z), k == 3)
            }
            (2, false) => (solids::ball(size[0] * 0.5, 16).at(x, y, z + 1.0), k == 3),
            (3, false) => (through(size[0] * 0.3, z + 1.0), true),
            // A window through the block, as wide as may be.
            (0, true) => (solids::block(numbers.between(1.0, 10.0), 40.0, 2.0).at(x, -20.0, z.min(4.0)), true),
            // A rod out of the block, leaning, from within.
            (1, true) => (solids::rod(size[0] * 0.3, 9.0, 24).about_y(numbers.between(0.0, 52.0)).at(x, y, 4.0), false),
            // A step out of the side, a little or far.
            (2, true) => (solids::block(4.0, 4.0, 3.0).at(3.0 + numbers.between(0.0, 0.9), y.min(1.5), 4.0), false),
            _ => (through(size[0] * 0.25, z.min(5.0)), true),
        };
        all = if hole { all.less(&piece) } else { all.and(&piece) };
    }
    // What a hole left below the table, or a piece put there.
    all.less(&solids::block(60.0, 60.0, 20.0).at(-30.0, -30.0, -20.0))
}

/// The rule with one of its numbers wrong.
fn mutants(rule: &OverhangRule) -> [OverhangRule; 5] {
    [
        OverhangRule { overhang: Angle::from_deg(85.0), ..*rule },
        OverhangRule { droops: false, ..*rule },
        OverhangRule { bridge_mm: 14.0, ..*rule },
        OverhangRule { bridge_mm: 0.0, ..*rule },
        OverhangRule { tolerate_mm2: 12.0, ..*rule },
    ]
}

#[test]
fn what_hangs_is_what_a_grid_of_columns_says() {
    let (mut hang, mut stand, mut undecided, mut wrong) = (0, 0, 0, Vec::new());
    let mut told = [0; 5];
    for seed in seeds(120, 3000) {
        let mesh = solid(seed).mesh();
        let rule = rule();
        let foot = |f: usize| mesh.corners(f).iter().all(|p: &Vec3| p.z.abs() < 1e-6);
        let ground = Ground { table: true, ..Ground::default() };
        let found = unsupported(&mesh, &Vec3::z(), &ground, foot, &rule, false);
        // Whether to look for one only or for all is no difference.
        let enough = unsupported(&mesh, &Vec3::z(), &ground, foot, &rule, true);
        assert_eq!(found.is_empty(), enough.is_empty(), "seed {seed}");
        let all = layers(&mesh, rule.layer_mm);
        let wide = judged(&all, &Limits::of(&rule, MARGIN_MM));
        let narrow = judged(&all, &Limits::of(&rule, -MARGIN_MM));
        match (wide.is_empty(), narrow.is_empty()) {
            (false, false) => hang += 1,
            (true, true) => stand += 1,
            _ => {
                undecided += 1;
                continue;
            }
        }
        // Rules that let more pass, each in its own way, must be told from the true one.
        for (other, told) in mutants(&rule).iter().zip(&mut told) {
            let stands = unsupported(&mesh, &Vec3::z(), &ground, foot, other, true).is_empty();
            *told += usize::from(stands != wide.is_empty());
        }
        if wide.is_empty() != found.is_empty() {
            wrong.push(format!("seed {seed}: the judge {wide:?}, the rule {found:?}"));
        }
    }
    note(&format!("{hang} solids hang, {stand} stand, {undecided} are too near to a limit for a grid"));
    assert!(told.iter().all(|count| *count > 0), "wrong rules that disagree with the judge: {told:?} times");
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(hang > 25 && stand > 12 && undecided < hang + stand, "{hang} hang, {stand} stand, {undecided} undecided");
}
