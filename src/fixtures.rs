//! Generated models that tests, benches and examples share; the same meshes lie as files under `fixtures/`.
//!
//! Each is a list of named closed parts, mm, on the table (lowest z = 0) and centred on it where that makes sense.
//! Parts that touch do so in coincident planes. The order of the parts is their numbering. Only floors `geom` and
//! `mesh` are known here.

use crate::geom::{Bounds, Object, SplitMix64, Vec3};
use crate::mesh::{TriangleMesh, stl_binary_parts};

/// A named closed part, mm.
pub type NamedMesh = (String, TriangleMesh<Object>);

/// A generated model.
#[derive(Clone, Debug)]
pub struct Fixture {
    /// The file's name under `fixtures/`.
    pub file: &'static str,
    /// The parts in order.
    pub parts: Vec<NamedMesh>,
}

impl Fixture {
    /// The parts in sequence as binary STL: what the committed file holds.
    pub fn stl(&self) -> Vec<u8> {
        stl_binary_parts(&self.parts.iter().map(|(_, mesh)| mesh).collect::<Vec<_>>())
    }
}

/// All fixtures.
pub fn all() -> Vec<Fixture> {
    vec![cube(), two_boxes(), ding(), y_tree(), candelabrum()]
}

/// Objects that fool a planner which looks at a part's six extreme corners only, or not at all.
pub fn tricks() -> Vec<Fixture> {
    vec![bar_beside_post(), between_towers(), under_the_gantry(), caged(), hook()]
}

/// A plate with a post, and a bar of 100 mm that passes the post 7 mm away: near it at mid-length only.
pub fn bar_beside_post() -> Fixture {
    let post = solid_box(Vec3::new(-5.0, -5.0, 8.0), Vec3::new(5.0, 5.0, 48.0));
    let bar = solid_box(Vec3::new(-50.0, 12.0, 8.0), Vec3::new(50.0, 18.0, 12.0));
    Fixture { file: "bar-beside-post.stl", parts: named([("plate", plate()), ("post", post), ("bar", bar)]) }
}

/// A plate with a stub between the two towers of a U whose foot lies 26 mm behind it: the way from tower to tower, at the
/// first layers, leads through the stub, and later the towers leave the head no room to print it.
pub fn between_towers() -> Fixture {
    let stub = solid_box(Vec3::new(-4.0, -4.0, 8.0), Vec3::new(4.0, 4.0, 16.0));
    let grid = [vec![-22.0, -14.0, 14.0, 22.0], vec![-4.0, 4.0, 30.0, 36.0], vec![8.0, 12.0, 60.0]];
    let towers = cells(&grid, |[x, y, z]| (z == 0 && (x != 1 || y == 2)) || (z == 1 && x != 1 && y == 0));
    Fixture { file: "between-towers.stl", parts: named([("plate", plate()), ("stub", stub), ("towers", towers)]) }
}

/// A cube on the floor of a tunnel with a roof of two 45 degree slopes: no order and no tilt lets a head in.
pub fn caged() -> Fixture {
    let house = |width: f64, floor: f64, eaves: f64| {
        [[-width, floor], [width, floor], [width, eaves], [0.0, eaves + width], [-width, eaves]]
    };
    let tunnel = pipe(&house(25.0, 0.0, 20.0), &house(20.0, 5.0, 20.0), [-40.0, 40.0]);
    let cube = solid_box(Vec3::new(-6.0, -6.0, 5.0), Vec3::new(6.0, 6.0, 17.0));
    Fixture { file: "caged.stl", parts: named([("tunnel", tunnel), ("cube", cube)]) }
}

/// A hook whose point hangs down: printed standing it begins in the air, lying on its side it does not.
pub fn hook() -> Fixture {
    let grid = [vec![-20.0, -10.0, 10.0, 20.0], vec![-5.0, 5.0], vec![0.0, 10.0, 30.0, 50.0, 60.0]];
    let hook = cells(&grid, |[x, _, z]| match x {
        0 => true,
        1 => z == 0 || z == 3,
        _ => z == 0 || z >= 2,
    });
    Fixture { file: "hook.stl", parts: named([("hook", hook)]) }
}

/// One solid as it comes out of CAD, a post with an arm of 44 mm that every printer of three axes must support; the pages of `docs/` print it.
pub fn bracket() -> Fixture {
    let grid = [vec![-8.0, 8.0, 52.0], vec![-8.0, 8.0], vec![0.0, 22.0, 30.0]];
    let bracket = cells(&grid, |[x, _, z]| x == 0 || z == 1);
    Fixture { file: "bracket.stl", parts: named([("bracket", bracket)]) }
}

/// A low block 100 mm behind a post: far from the nozzle's block, but below a gantry beam of 40 mm height.
pub fn under_the_gantry() -> Fixture {
    let post = solid_box(Vec3::new(-5.0, -50.0, 8.0), Vec3::new(5.0, -40.0, 68.0));
    let block = solid_box(Vec3::new(4.0, 40.0, 8.0), Vec3::new(14.0, 50.0, 14.0));
    Fixture { file: "under-the-gantry.stl", parts: named([("plate", plate()), ("post", post), ("block", block)]) }
}

fn plate() -> TriangleMesh<Object> {
    solid_box(Vec3::new(-60.0, -60.0, 0.0), Vec3::new(60.0, 60.0, 8.0))
}

/// One 20 mm cube: 8000 mm³, 2400 mm², 12 facets.
pub fn cube() -> Fixture {
    let part = solid_box(Vec3::new(-10.0, -10.0, 0.0), Vec3::new(10.0, 10.0, 20.0));
    Fixture { file: "cube.stl", parts: named([("cube", part)]) }
}

/// An upright box with a horizontal one on its side, which needs the table tilted by 90 degrees
/// (Ramos et al. (2021) sec. 5.4, first study, figure 7).
pub fn two_boxes() -> Fixture {
    let post = solid_box(Vec3::new(-10.0, -10.0, 0.0), Vec3::new(10.0, 10.0, 60.0));
    let beam = solid_box(Vec3::new(10.0, -10.0, 40.0), Vec3::new(40.0, 10.0, 60.0));
    Fixture { file: "two-boxes.stl", parts: named([("post", post), ("beam", beam)]) }
}

/// A post, a horizontal beam and two uprights on it, too near for a head between them, so that they must be printed
/// together (Ramos et al. (2021) sec. 5.4, second study, figure 6, after Ding et al.).
pub fn ding() -> Fixture {
    let post = solid_box(Vec3::new(-15.0, -15.0, 0.0), Vec3::new(15.0, 15.0, 60.0));
    let beam = solid_box(Vec3::new(15.0, -10.0, 35.0), Vec3::new(65.0, 10.0, 55.0));
    let near = solid_box(Vec3::new(27.0, -5.0, 55.0), Vec3::new(37.0, 5.0, 85.0));
    let far = solid_box(Vec3::new(43.0, -5.0, 55.0), Vec3::new(53.0, 5.0, 85.0));
    let parts = named([("post", post), ("beam", beam), ("near upright", near), ("far upright", far)]);
    Fixture { file: "ding.stl", parts }
}

/// A trunk with a roof of two 45 degree faces and a branch 40 mm long out of each.
pub fn y_tree() -> Fixture {
    let depth = [-10.0, 10.0];
    let trunk = prism(&[[-10.0, 0.0], [10.0, 0.0], [10.0, 40.0], [0.0, 50.0], [-10.0, 40.0]], depth);
    let reach = 40.0 * std::f64::consts::FRAC_1_SQRT_2;
    let right = prism(&[[10.0, 40.0], [10.0 + reach, 40.0 + reach], [reach, 50.0 + reach], [0.0, 50.0]], depth);
    let left = prism(&[[-10.0, 40.0], [0.0, 50.0], [-reach, 50.0 + reach], [-10.0 - reach, 40.0 + reach]], depth);
    Fixture { file: "y-tree.stl", parts: named([("trunk", trunk), ("right branch", right), ("left branch", left)]) }
}

/// Half the stem's width, mm: where the arms begin.
const STEM: f64 = 5.0;
/// The arms' thickness, mm.
const THICK: f64 = 4.0;
/// The arms' upper end, mm.
const TOP: f64 = 110.0;
/// Sides of the base, of a smooth arm's slanted piece and of its upright.
const SIDES: [usize; 3] = [186, 420, 478];
/// Where each arm leaves the stem and where its upright stands: `(z, x)` in mm, lowest and outermost first.
const LEVELS: [(f64, f64); 4] = [(26.0, 80.0), (44.0, 60.0), (62.0, 40.0), (80.0, 20.0)];
/// First piece, upright, side of the stem and level of the box arms, numbered as in Ramos et al. (2021) figures 8 and 13.
const BOX_ARMS: [(usize, usize, f64, usize); 4] = [(3, 2, 1.0, 0), (5, 4, 1.0, 2), (7, 6, -1.0, 0), (8, 9, -1.0, 2)];
/// The same of the smooth arms.
const SMOOTH_ARMS: [(usize, usize, f64, usize); 4] =
    [(11, 10, 1.0, 1), (13, 12, 1.0, 3), (15, 14, -1.0, 1), (17, 16, -1.0, 3)];

/// The candelabrum of Ramos et al. (2021) sec. 5.4, figure 8, reconstructed: 18 parts, 15,190 facets.
///
/// Part 0 is the base and 1 the stem. Each arm's first piece leaves the stem 20 degrees above the horizontal, so
/// that its build direction `(±cos 20°, 0, sin 20°)` needs the table tilted by 70 degrees; its second is upright.
pub fn candelabrum() -> Fixture {
    let base =
        tube(&ring([40.0, 40.0], Vec3::zeros(), SIDES[0]), &ring([40.0, 40.0], Vec3::z() * 10.0, SIDES[0]), false);
    let stem = solid_box(Vec3::new(-STEM, -STEM, 10.0), Vec3::new(STEM, STEM, 100.0));
    let mut parts = vec![(0, "base".to_owned(), base), (1, "stem".to_owned(), stem)];
    for (first, upright, side, level) in BOX_ARMS {
        let (slanted, standing) = box_arm(side, LEVELS[level]);
        parts.push((first, format!("box arm {first}"), slanted));
        parts.push((upright, format!("box upright {upright}"), standing));
    }
    for (first, upright, side, level) in SMOOTH_ARMS {
        // One upright has a side more and one lid fanned about its centre: it makes the sum that the paper states.
        let odd = upright == 16;
        let (slanted, standing) = smooth_arm(side, LEVELS[level], SIDES[2] + usize::from(odd), odd);
        parts.push((first, format!("smooth arm {first}"), slanted));
        parts.push((upright, format!("smooth upright {upright}"), standing));
    }
    parts.sort_by_key(|part| part.0);
    Fixture { file: "candelabrum.stl", parts: parts.into_iter().map(|(_, name, mesh)| (name, mesh)).collect() }
}

/// Height of an arm's first piece along the stem, mm: its thickness seen along z.
fn rise() -> f64 {
    THICK / 20.0_f64.to_radians().cos()
}

/// The height at which an arm that leaves the stem at `z` is cut, so that the cut's centre lies at `x`.
fn cut_height(z: f64, x: f64) -> f64 {
    z + rise() / 2.0 + (x - STEM) * 20.0_f64.to_radians().tan()
}

fn box_arm(side: f64, level: (f64, f64)) -> (TriangleMesh<Object>, TriangleMesh<Object>) {
    let (z, x) = level;
    let (cut, half) = (cut_height(z, x), THICK / 2.0);
    let end = THICK / 20.0_f64.to_radians().sin() / 2.0;
    let mut outline = [[STEM, z], [x + end, cut], [x - end, cut], [STEM, z + rise()]];
    outline.iter_mut().for_each(|corner| corner[0] *= side);
    if side < 0.0 {
        outline.reverse();
    }
    let at = |dx: f64, y: f64, z: f64| Vec3::new(side * x + dx, y, z);
    (prism(&outline, [-half, half]), solid_box(at(-half, -half, cut), at(half, half, TOP)))
}

fn smooth_arm(
    side: f64,
    level: (f64, f64),
    sides: usize,
    centred: bool,
) -> (TriangleMesh<Object>, TriangleMesh<Object>) {
    let (z, x) = level;
    let (cut, radius) = (cut_height(z, x), THICK / 2.0);
    let slope = 20.0_f64.to_radians();
    let (start, foot) = (Vec3::new(side * STEM, 0.0, z + rise() / 2.0), Vec3::new(side * x, 0.0, cut));
    let along = Vec3::new(side * slope.cos(), 0.0, slope.sin());
    let up = Vec3::new(-side * slope.sin(), 0.0, slope.cos());
    // The cylinder's rulings, cut by the stem's face and by the horizontal plane; turned like a ring about `along`.
    let ruling = |k: usize| {
        let turn = std::f64::consts::TAU * k as f64 / SIDES[1] as f64;
        start + (along.cross(&up) * turn.sin() + up * turn.cos()) * radius
    };
    let at_stem = |p: Vec3| Vec3::new(start.x, p.y, (p - along * ((p.x - start.x) / along.x)).z);
    let at_cut = |p: Vec3| Vec3::new((p + along * ((cut - p.z) / along.z)).x, p.y, cut);
    let rings = [
        (0..SIDES[1]).map(|k| at_stem(ruling(k))).collect::<Vec<_>>(),
        (0..SIDES[1]).map(|k| at_cut(ruling(k))).collect(),
    ];
    let top = Vec3::new(foot.x, 0.0, TOP);
    let standing = tube(&ring([radius, radius], foot, sides), &ring([radius, radius], top, sides), centred);
    (tube(&rings[0], &rings[1], false), standing)
}

fn named<const N: usize>(parts: [(&str, TriangleMesh<Object>); N]) -> Vec<NamedMesh> {
    parts.into_iter().map(|(name, mesh)| (name.to_owned(), mesh)).collect()
}

/// The same surface with `count` facets without area in it, or fewer, as CAD programs leave them: a facet gets a new corner on one of
/// its sides, at any place or next to an end, which its neighbour does not know of. Corners are rounded as files round them (`f32`);
/// what then falls on another corner is left out.
pub fn slivered(mesh: &TriangleMesh<Object>, seed: u64, count: usize) -> TriangleMesh<Object> {
    let (mut vertices, mut facets) = (mesh.vertices().to_vec(), mesh.facets().to_vec());
    let mut random = SplitMix64::seeded(seed);
    for _ in 0..count {
        let index = random.word() as usize % facets.len();
        let turn = random.word() as usize % 3;
        let [a, b, c] = [0, 1, 2].map(|i| facets[index][(turn + i) % 3]);
        let [p, q] = [a, b].map(|v| vertices[v as usize]);
        let share = if random.word().is_multiple_of(4) { (4e-4 / (q - p).norm()).min(0.5) } else { random.unit() };
        let at = (p + (q - p) * share).map(|x| f64::from(x as f32));
        if vertices.contains(&at) {
            continue;
        }
        let new = vertices.len() as u32;
        vertices.push(at);
        facets[index] = [a, new, c];
        facets.extend([[new, b, c], [a, b, new]]);
    }
    TriangleMesh::new(vertices, facets)
}

/// The box from corner `min` to corner `max`: 12 facets.
pub fn solid_box(min: Vec3, max: Vec3) -> TriangleMesh<Object> {
    let bounds = Bounds { min, max };
    let outline = [[min.x, min.z], [max.x, min.z], [max.x, max.z], [min.x, max.z]];
    prism(&outline, [bounds.min.y, bounds.max.y])
}

/// A convex `(x, z)` outline, counter-clockwise seen against +Y, drawn from one y to a higher one: `4n - 4` facets.
///
/// An outline of fewer than three corners gives facets without area.
pub fn prism(outline: &[[f64; 2]], y: [f64; 2]) -> TriangleMesh<Object> {
    let at = |y: f64| outline.iter().map(|&[x, z]| Vec3::new(x, y, z)).collect::<Vec<_>>();
    // Seen along +Y, the outline turns counter-clockwise when it is taken backward.
    let reversed = |mut ring: Vec<Vec3>| {
        ring.reverse();
        ring
    };
    tube(&reversed(at(y[0])), &reversed(at(y[1])), false)
}

/// The closed surface of the cells that `filled` names on a grid of planes `[x, y, z]`, ascending; corners shared. Cells that meet
/// in an edge or corner only make a surface that is not manifold.
fn cells(planes: &[Vec<f64>; 3], filled: impl Fn([usize; 3]) -> bool) -> TriangleMesh<Object> {
    let count = |axis: usize| planes[axis].len() - 1;
    let full = |cell: [isize; 3]| {
        let inside = (0..3).all(|a| (0..count(a) as isize).contains(&cell[a]));
        inside && filled(cell.map(|c| c as usize))
    };
    let mut vertices: Vec<Vec3> = Vec::new();
    let mut facets = Vec::new();
    for x in 0..count(0) {
        for y in 0..count(1) {
            for z in 0..count(2) {
                let cell = [x as isize, y as isize, z as isize];
                for (axis, side) in (0..3).flat_map(|a| [(a, 0), (a, 1)]).filter(|_| full(cell)) {
                    let mut beyond = cell;
                    beyond[axis] += if side == 0 { -1 } else { 1 };
                    if full(beyond) {
                        continue;
                    }
                    // The face's corners, counter-clockwise seen from outside.
                    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                    let mut ring = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[du, dv]: [usize; 2]| {
                        let mut at = [x, y, z];
                        at[axis] += side;
                        at[u] += du;
                        at[v] += dv;
                        let corner = Vec3::from_fn(|i, _| planes[i][at[i]]);
                        vertices.iter().position(|known| *known == corner).unwrap_or_else(|| {
                            vertices.push(corner);
                            vertices.len() - 1
                        }) as u32
                    });
                    if side == 0 {
                        ring.reverse();
                    }
                    facets.extend([[ring[0], ring[1], ring[2]], [ring[0], ring[2], ring[3]]]);
                }
            }
        }
    }
    TriangleMesh::new(vertices, facets)
}

/// A pipe along y between an outer and an inner `(x, z)` outline of as many corners, both counter-clockwise seen against +Y.
fn pipe(outer: &[[f64; 2]], inner: &[[f64; 2]], y: [f64; 2]) -> TriangleMesh<Object> {
    let n = outer.len() as u32;
    let rings = [(outer, y[0]), (outer, y[1]), (inner, y[0]), (inner, y[1])];
    let vertices = rings.iter().flat_map(|(ring, y)| ring.iter().map(|&[x, z]| Vec3::new(x, *y, z))).collect();
    let mut facets = Vec::new();
    let mut quad = |a: u32, b: u32, c: u32, d: u32| facets.extend([[a, c, b], [a, d, c]]);
    for k in 0..n {
        let next = (k + 1) % n;
        let at = |ring: u32, k: u32| ring * n + k;
        quad(at(0, k), at(0, next), at(1, next), at(1, k));
        quad(at(2, next), at(2, k), at(3, k), at(3, next));
        quad(at(0, next), at(0, k), at(2, k), at(2, next));
        quad(at(1, k), at(1, next), at(3, next), at(3, k));
    }
    TriangleMesh::new(vertices, facets)
}

/// `sides` points around an ellipse with these radii along x and y about `centre`, counter-clockwise seen from +Z.
fn ring(radii: [f64; 2], centre: Vec3, sides: usize) -> Vec<Vec3> {
    let angle = |k: usize| std::f64::consts::TAU * k as f64 / sides as f64;
    (0..sides).map(|k| centre + Vec3::new(radii[0] * angle(k).cos(), radii[1] * angle(k).sin(), 0.0)).collect()
}

/// A wall between two rings of as many points and a lid on each, fanned from its first point; `4n - 4` facets.
///
/// Both rings turn counter-clockwise seen from the second one's side. With `centred` the second lid fans about the
/// ring's centre instead, and there are two facets more.
fn tube(low: &[Vec3], high: &[Vec3], centred: bool) -> TriangleMesh<Object> {
    let n = low.len() as u32;
    let mut vertices = [low, high].concat();
    let mut facets = Vec::with_capacity(4 * low.len());
    for k in 0..n {
        let next = (k + 1) % n;
        facets.extend([[k, next, n + next], [k, n + next, n + k]]);
    }
    facets.extend((1..n.saturating_sub(1)).map(|k| [0, k + 1, k]));
    if centred {
        vertices.push(high.iter().sum::<Vec3>() / f64::from(n));
        facets.extend((0..n).map(|k| [2 * n, n + k, n + (k + 1) % n]));
    } else {
        facets.extend((1..n.saturating_sub(1)).map(|k| [n, n + k, n + k + 1]));
    }
    TriangleMesh::new(vertices, facets)
}

#[cfg(test)]
mod tests {
    use super::{Fixture, all, bracket, candelabrum, cube, ding, tricks, two_boxes, y_tree};
    use crate::geom::Vec3;
    use crate::mesh::{Model, ReadOptions, read_model};

    fn model(fixture: &Fixture) -> Model {
        let model = read_model(&fixture.stl(), fixture.file, &ReadOptions::default()).unwrap();
        assert!(model.warnings.is_empty(), "{:?}", model.warnings);
        assert_eq!(model.parts.len(), fixture.parts.len());
        for (part, (name, made)) in model.parts.iter().zip(&fixture.parts) {
            assert_eq!(part.mesh.facets().len(), made.facets().len(), "{name}");
            assert!((part.mesh.volume() - made.volume()).abs() < 1e-4 * made.volume(), "{name}");
        }
        assert!(model.floating().is_empty());
        assert_eq!(model.on_table, [0]);
        model
    }

    fn pairs(model: &Model) -> Vec<(usize, usize, f64)> {
        model.interfaces.iter().map(|one| (one.a, one.b, one.area_mm2)).collect()
    }

    /// To the nanometre's square, so that a sum's order does not matter.
    fn rounded(model: &Model) -> Vec<(usize, usize, f64)> {
        pairs(model).into_iter().map(|(a, b, area)| (a, b, (area * 1e9).round() / 1e9)).collect()
    }

    #[test]
    fn tricks_are_closed_models() {
        let parts: Vec<usize> = tricks().iter().map(|fixture| model(fixture).parts.len()).collect();
        assert_eq!(parts, [3, 3, 3, 2, 1]);
        let volumes: Vec<f64> = tricks().iter().map(|f| f.parts[f.parts.len() - 1].1.volume()).collect();
        let towers = 4.0 * (2.0 * 8.0 * 40.0 + 28.0 * 6.0) + 2.0 * 48.0 * 64.0;
        for (got, wanted) in volumes.iter().zip([2400.0, towers, 600.0, 1728.0, 14_000.0]) {
            assert!((got - wanted).abs() < 1e-6, "{got} {wanted}");
        }
    }

    #[test]
    fn the_bracket_is_one_closed_solid() {
        let model = model(&bracket());
        let volume = 16.0 * 16.0 * 30.0 + 44.0 * 16.0 * 8.0;
        assert!(model.parts.len() == 1 && (model.parts[0].mesh.volume() - volume).abs() < 1e-6);
    }

    #[test]
    fn committed_files_are_the_generated_bytes() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
        for fixture in all().into_iter().chain(tricks()).chain([bracket()]) {
            let path = folder.join(fixture.file);
            if std::env::var_os("UPDATE_FIXTURES").is_some() {
                std::fs::write(&path, fixture.stl()).unwrap();
            }
            let found = std::fs::read(&path).unwrap();
            assert!(found == fixture.stl(), "{} differs; regenerate with UPDATE_FIXTURES=1", fixture.file);
        }
    }

    #[test]
    fn the_cube_has_its_volume_area_and_box() {
        let model = model(&cube());
        let mesh = &model.parts[0].mesh;
        assert!((mesh.volume() - 8000.0).abs() < 1e-9 && (mesh.area() - 2400.0).abs() < 1e-9);
        assert_eq!(mesh.facets().len(), 12);
        assert_eq!(model.bounds.min, Vec3::new(-10.0, -10.0, 0.0));
        assert_eq!(model.bounds.max, Vec3::new(10.0, 10.0, 20.0));
    }

    #[test]
    fn two_boxes_share_a_square() {
        let model = model(&two_boxes());
        assert_eq!(rounded(&model), [(0, 1, 400.0)]);
        assert_eq!(model.interfaces[0].normal, Vec3::x());
        assert!((model.parts[1].mesh.volume() - 12_000.0).abs() < 1e-9);
    }

    #[test]
    fn ding_stands_on_one_post() {
        let model = model(&ding());
        assert_eq!(rounded(&model), [(0, 1, 400.0), (1, 2, 100.0), (1, 3, 100.0)]);
        let (near, far) = (model.parts[2].mesh.bounds(), model.parts[3].mesh.bounds());
        assert_eq!(far.min.x - near.max.x, 6.0);
    }

    #[test]
    fn the_y_tree_branches_at_right_angles() {
        let model = model(&y_tree());
        let area = 10.0 * 2.0_f64.sqrt() * 20.0;
        let found = pairs(&model);
        assert_eq!(found.iter().map(|one| (one.0, one.1)).collect::<Vec<_>>(), [(0, 1), (0, 2)]);
        assert!(found.iter().all(|one| (one.2 - area).abs() < 1e-4), "{found:?}");
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert!((model.interfaces[0].normal - Vec3::new(half, 0.0, half)).norm() < 1e-6);
        assert!((model.interfaces[1].normal - Vec3::new(-half, 0.0, half)).norm() < 1e-6);
        assert!((model.parts[0].mesh.volume() - 18_000.0).abs() < 1e-6);
        assert!((model.parts[2].mesh.volume() - area * 40.0).abs() < 1e-2);
    }

    #[test]
    fn the_candelabrum_has_the_facets_and_parts_of_the_paper() {
        let model = model(&candelabrum());
        let facets: Vec<usize> = model.parts.iter().map(|part| part.mesh.facets().len()).collect();
        assert_eq!(facets.iter().sum::<usize>(), 15_190);
        assert_eq!(facets[..2], [740, 12]);
        assert!(facets[2..10].iter().all(|&count| count == 12));
        assert_eq!(facets[10..], [1908, 1676, 1908, 1676, 1908, 1676, 1914, 1676]);
        let slant = 20.0_f64.to_radians();
        for (id, side) in [(3, 1.0), (5, 1.0), (7, -1.0), (8, -1.0), (11, 1.0), (13, 1.0), (15, -1.0), (17, -1.0)] {
            assert!(model.parts[id].mesh.bounds().centre().x * side > 5.0, "part {id}");
            let axis = Vec3::new(side * slant.cos(), 0.0, slant.sin());
            let mesh = &model.parts[id].mesh;
            // Only the two end faces do not run along the axis.
            let along = (0..mesh.facets().len()).filter(|&f| mesh.normal(f).unwrap().dot(&axis).abs() < 1e-4).count();
            assert_eq!(along, if id < 10 { 8 } else { 840 }, "part {id}");
        }
    }

    #[test]
    fn the_candelabrum_hangs_together_by_17_interfaces() {
        let model = model(&candelabrum());
        let found = pairs(&model);
        let arms = [(1, 3), (1, 5), (1, 7), (1, 8), (1, 11), (1, 13), (1, 15), (1, 17)];
        let uprights = [(2, 3), (4, 5), (6, 7), (8, 9), (10, 11), (12, 13), (14, 15), (16, 17)];
        let wanted: Vec<_> = [(0, 1)].into_iter().chain(arms).chain(uprights).collect();
        assert_eq!(found.iter().map(|one| (one.0, one.1)).collect::<Vec<_>>(), wanted);
        let circle = |n: f64| 2.0 * n * (std::f64::consts::TAU / n).sin();
        let cos = 20.0_f64.to_radians().cos();
        for (a, b, area) in found {
            let wanted = match (a, b) {
                (0, 1) => 100.0,
                (1, arm) if arm < 10 => 16.0 / cos,
                (1, _) => circle(420.0) / cos,
                (upright, _) if upright < 10 => 16.0,
                (16, _) => circle(479.0),
                _ => circle(478.0),
            };
            assert!((area - wanted).abs() < 1e-3, "{a}-{b}: {area}, wanted {wanted}");
        }
    }
}
