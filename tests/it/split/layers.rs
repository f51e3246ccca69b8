//! The layer oracle: each part is sliced along its own direction on a grid, and what a layer has beyond the one below, grown by
//! what the overhang allows and half a line, must be nothing once what is narrower than a line is taken off. It knows neither
//! facets' angles nor lowest places nor ridges, and catches what they are for: corners that begin in the air, ridges, slivers.

use trunnion::geom::{Mat3, Object, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::split::CutOptions;

use super::{cut, solids};

const CELL_MM: f64 = 0.2;
const LAYER_MM: f64 = 0.4;
const LINE_MM: f64 = 0.45;

/// Cells of one layer, by row.
type Grid = Vec<Vec<bool>>;

fn upright(mesh: &TriangleMesh<Object>, up: &Vec3) -> Vec<[Vec3; 3]> {
    let across = Vec3::ith(up.iamin(), 1.0).cross(up).normalize();
    let frame = Mat3::from_rows(&[across.transpose(), up.cross(&across).transpose(), up.transpose()]);
    (0..mesh.facets().len()).map(|f| mesh.corners(f).map(|p| frame * p)).collect()
}

/// The cells whose middles lie inside at height `z`: crossings of each row with the outline, in pairs.
fn sliced(facets: &[[Vec3; 3]], z: f64, origin: [f64; 2], size: [usize; 2]) -> Grid {
    let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); size[1]];
    for facet in facets {
        let mut ends = Vec::with_capacity(2);
        for i in 0..3 {
            let (p, q) = (facet[i], facet[(i + 1) % 3]);
            if (p.z > z) != (q.z > z) {
                ends.push(p + (q - p) * ((z - p.z) / (q.z - p.z)));
            }
        }
        let [p, q] = ends[..] else { continue };
        let row = |y: f64| ((y - origin[1]) / CELL_MM - 0.5).ceil().max(0.0) as usize;
        let rows = row(p.y.min(q.y))..row(p.y.max(q.y)).min(size[1]);
        for (k, crossed) in crossings.iter_mut().enumerate().take(rows.end).skip(rows.start) {
            let y = origin[1] + (k as f64 + 0.5) * CELL_MM;
            if (p.y > y) != (q.y > y) {
                crossed.push(p.x + (q.x - p.x) * (y - p.y) / (q.y - p.y));
            }
        }
    }
    let fill = |mut xs: Vec<f64>| {
        xs.sort_by(f64::total_cmp);
        let mut cells = vec![false; size[0]];
        for pair in xs.chunks_exact(2) {
            let column = |x: f64| ((x - origin[0]) / CELL_MM - 0.5).ceil().max(0.0) as usize;
            (column(pair[0])..column(pair[1]).min(size[0])).for_each(|c| cells[c] = true);
        }
        cells
    };
    crossings.into_iter().map(fill).collect()
}

/// Whether a cell of `grid` within `reach` mm of the cell says `yes`.
fn within(grid: &Grid, [x, y]: [usize; 2], reach: f64, yes: bool) -> bool {
    let cells = (reach / CELL_MM).floor() as isize;
    (-cells..=cells).any(|dy| {
        (-cells..=cells).any(|dx| {
            let near = ((dx * dx + dy * dy) as f64).sqrt() * CELL_MM <= reach;
            let (cx, cy) = (x as isize + dx, y as isize + dy);
            let cell = usize::try_from(cy).ok().and_then(|cy| grid.get(cy)?.get(usize::try_from(cx).ok()?));
            near && cell.copied().unwrap_or(false) == yes
        })
    })
}

/// The most area, mm², that any layer of `mesh` printed along `up` lays on nothing; the lowest layer is carried.
fn unsupported_mm2(mesh: &TriangleMesh<Object>, up: &Vec3) -> f64 {
    let facets = upright(mesh, up);
    let corners = || facets.iter().flatten();
    let low = corners().fold(Vec3::repeat(f64::INFINITY), |l, p| l.inf(p));
    let high = corners().fold(Vec3::repeat(f64::NEG_INFINITY), |h, p| h.sup(p));
    // A margin of cells around, so that nothing is cut off.
    let origin = [low.x - 5.0 * CELL_MM, low.y - 5.0 * CELL_MM];
    let size = [high.x, high.y].map(f64::ceil).into_iter().zip(origin).map(|(h, o)| ((h - o) / CELL_MM) as usize + 6);
    let size: Vec<usize> = size.collect();
    let reach = LAYER_MM * 1.03 + LINE_MM / 2.0 + CELL_MM;
    let mut below: Option<Grid> = None;
    let mut most = 0.0_f64;
    let layers = ((high.z - low.z) / LAYER_MM) as usize;
    for layer in 0..layers {
        let grid = sliced(&facets, low.z + (layer as f64 + 0.5) * LAYER_MM, origin, [size[0], size[1]]);
        if let Some(below) = &below {
            let mut hangs: Grid = vec![vec![false; size[0]]; size[1]];
            for (y, row) in grid.iter().enumerate() {
                for x in (0..row.len()).filter(|&x| row[x]) {
                    hangs[y][x] = !below[y][x] && !within(below, [x, y], reach, true);
                }
            }
            let cells = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y])).filter(|&[x, y]| hangs[y][x]);
            let thick = cells.filter(|&at| !within(&hangs, at, LINE_MM / 2.0, false)).count();
            most = most.max(thick as f64 * CELL_MM * CELL_MM);
        }
        below = Some(grid);
    }
    most
}

#[test]
fn the_oracle_sees_what_hangs() {
    // As it lies, the beam of the tee is laid on nothing but the post; the hook and the mushroom likewise.
    for (name, shape, least) in
        [("tee", solids::tee(), 300.0), ("hook", solids::hook(), 200.0), ("mushroom", solids::mushroom(), 1000.0)]
    {
        let got = unsupported_mm2(&shape.mesh(), &Vec3::z());
        assert!(got > least, "{name}: only {got} mm2 seen");
    }
    // A corner that begins in the air below facets that are all steep: a needle on its tip beside a post.
    let spike = solids::rod(0.01, 0.1, 8).mesh();
    assert_eq!(unsupported_mm2(&spike, &Vec3::z()), 0.0);
    assert_eq!(unsupported_mm2(&solids::block(20.0, 20.0, 10.0).mesh(), &Vec3::z()), 0.0);
}

#[test]
fn no_layer_of_a_cut_part_is_laid_on_nothing() {
    for solid in solids::all().into_iter().filter(|s| !["bracket", "menorah"].contains(&s.name)) {
        let found = cut(&solid.shape.mesh(), &CutOptions::default());
        for (id, part) in found.parts.iter().enumerate() {
            let got = unsupported_mm2(&part.mesh, &part.up);
            assert!(got < 0.5, "{}: {got} mm2 of part {id} ({}) hang", solid.name, found.piece(id));
        }
    }
}
