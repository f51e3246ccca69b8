//! Where the model stands on the table, so that every part stays within the machine's axes.
//!
//! A shift `(x, y)` of the model on the table moves every tip position of a part at a pose by the first two columns of the
//! pose's rotation, so that X, Y and Z stops are six half-planes for `(x, y)`: each way to print a part has a convex
//! polygon of places. The places that suit every part are the intersection over the parts of the unions over their ways,
//! kept as a list of convex cells. No cell left is a proof that no place does, for that turn of the model.
//!
//! What parts do to each other does not depend on the place; what the table, the frame and pieces of the head that follow
//! only some axes do does, and is worked out anew for every place that is tried.

use super::candidates::{Barrier, Setups, Told};
use super::infeasible::Infeasible;
use super::options::Options;
use super::plan::Placement;
use super::planner::{Planned, plan};
use super::workpiece::{Misplaced, Workpiece};
use crate::geom::{Angle, Vec3};
use crate::mesh::Model;
use crate::motion::rotation_z;
use crate::orient::Direction;
use crate::profile::Profile;
use crate::spelling::part_named;

/// Turns of the model that are tried, degrees. Where the table turns without end only level parts care.
const TURNS: [f64; 8] = [0.0, 90.0, 45.0, 135.0, 180.0, 270.0, 225.0, 315.0];
/// Places of one turn that are planned at.
const MOST_PLACES: usize = 8;
/// Cells beyond this are dropped, the smallest first; then nothing is proved any more.
const MOST_CELLS: usize = 2000;
/// Places nearer than this to the edge of a cell are moved inward where there is room, mm.
const INWARD_MM: f64 = 1.0;

/// A point of the table.
type Spot = [f64; 2];
/// A convex polygon, counter-clockwise.
type Cell = Vec<Spot>;

/// The centred placement with the least turn that fits on the table's surface.
///
/// # Errors
///
/// [`Misplaced`] of the model as it lies, if no turn helps.
pub fn centred(model: &Model, profile: &Profile) -> Result<Placement, Misplaced> {
    let plain = Workpiece::centred(model);
    let mut first = None;
    for turn_deg in TURNS {
        let placement = turned(&plain, model, turn_deg);
        match Workpiece::place(model, &placement).check(profile) {
            Ok(()) => return Ok(placement),
            Err(misplaced) => _ = first.get_or_insert(misplaced),
        }
    }
    Err(first.unwrap_or(Misplaced::NotOnTable { above_mm: f64::NAN }))
}

/// The model in the middle of the table, turned by so many degrees about it; whether it fits is not asked.
pub fn centred_and_turned(model: &Model, turn_deg: f64) -> Placement {
    turned(&Workpiece::centred(model), model, turn_deg)
}

/// `plain` turned about the middle of the model's footprint.
fn turned(plain: &Placement, model: &Model, turn_deg: f64) -> Placement {
    let centre = model.bounds.centre();
    let there = rotation_z(Angle::from_deg(turn_deg)) * centre;
    let middle = centre + Vec3::from(plain.origin_mm);
    let tidy = |v: f64| if v.abs() < 1e-6 { 0.0 } else { v };
    Placement { origin_mm: [tidy(middle.x - there.x), tidy(middle.y - there.y), plain.origin_mm[2]], turn_deg }
}

/// Plans `model`, first at `base` with its `directions`, then wherever else all parts stay within the axes.
///
/// # Errors
///
/// [`Infeasible`]: [`Infeasible::NoPlace`] where it is proved that the axes reach no place, else the reasons at `base`.
pub fn plan_anywhere(
    model: &Model,
    profile: &Profile,
    base: &Placement,
    directions: &[Vec<Direction>],
    options: &Options<'_>,
) -> Result<(Placement, Vec<Planned>), Infeasible> {
    let here = Workpiece::place(model, base);
    let quiet = Options { explain: false, ..options.clone() };
    match plan(&here, profile, directions, &quiet) {
        Ok(plans) => return Ok((*base, plans)),
        Err(Infeasible::NoPlan { .. }) => {}
        Err(other) => return Err(other),
    }
    let mut reached = false;
    let mut nowhere: Option<String> = None;
    for turn_deg in TURNS {
        let turn = turned(base, model, base.turn_deg + turn_deg);
        let workpiece = Workpiece::place(model, &turn);
        let directions: Vec<Vec<Direction>> = directions.iter().map(|of_part| all_turned(of_part, turn_deg)).collect();
        match places(&workpiece, profile, &directions, options) {
            Err(Nowhere::NotThePlace) => {
                reached = true;
                break;
            }
            Err(Nowhere::Proved(why)) => _ = nowhere.get_or_insert(why),
            Ok(spots) => {
                reached = true;
                for [x, y] in spots {
                    let [x0, y0, z] = turn.origin_mm;
                    let placement = Placement { origin_mm: [rounded(x0 + x), rounded(y0 + y), z], ..turn };
                    let workpiece = Workpiece::place(model, &placement);
                    if workpiece.check(profile).is_ok()
                        && let Ok(plans) = plan(&workpiece, profile, &directions, &quiet)
                    {
                        return Ok((placement, plans));
                    }
                }
            }
        }
    }
    match nowhere.filter(|_| !reached) {
        Some(summary) => Err(Infeasible::NoPlace { summary }),
        None => Err(plan(&here, profile, directions, options).err().unwrap_or(Infeasible::Budget { steps: 0 })),
    }
}

/// Plan files and people read micrometres.
fn rounded(mm: f64) -> f64 {
    // Adding 0 turns the negative one round.
    crate::gcode::round_to(mm, 3) + 0.0
}

fn all_turned(directions: &[Direction], turn_deg: f64) -> Vec<Direction> {
    let turn = rotation_z(Angle::from_deg(turn_deg));
    directions.iter().map(|d| Direction { up: turn * d.up, ..*d }).collect()
}

/// Why a turn of the model has no place.
enum Nowhere {
    /// Some part would not stand, or is out of the tilt's reach, wherever it is; or too many cells were dropped to know.
    NotThePlace,
    /// The axes reach none; in words.
    Proved(String),
}

/// Shifts of `workpiece` at which every part has a way within the axes, the least first; or which part has none.
fn places(
    workpiece: &Workpiece<'_>,
    profile: &Profile,
    directions: &[Vec<Direction>],
    options: &Options<'_>,
) -> Result<Vec<Spot>, Nowhere> {
    let setups = Setups::new(workpiece, profile, options);
    let mut cells = vec![on_table(workpiece, profile)];
    let mut dropped = false;
    for (part, tried) in directions.iter().enumerate() {
        let mut polygons: Vec<Cell> = Vec::new();
        let ways = setups.ways(part, tried, Told::Standing);
        let within = |a: &Barrier| matches!(a, Barrier::Support | Barrier::Reach);
        let standing: Vec<_> = ways.iter().filter(|w| !w.objections.iter().any(|o| within(&o.against))).collect();
        if standing.is_empty() {
            return Err(Nowhere::NotThePlace);
        }
        for way in standing {
            add_cell(&mut polygons, shifts(&setups, part, way.pose));
        }
        let mut next: Vec<Cell> = Vec::new();
        for cell in &cells {
            for polygon in &polygons {
                add_cell(&mut next, common(cell, polygon));
            }
        }
        if next.is_empty() && dropped {
            return Err(Nowhere::NotThePlace);
        }
        if next.is_empty() {
            return Err(Nowhere::Proved(nowhere(workpiece, part, !polygons.is_empty())));
        }
        next.sort_by(|a, b| area(b).total_cmp(&area(a)));
        dropped |= next.len() > MOST_CELLS;
        next.truncate(MOST_CELLS);
        cells = next;
    }
    let mut spots: Vec<Spot> = cells.iter().flat_map(|cell| [inward(cell), middle(cell)]).collect();
    spots.sort_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
    spots.dedup();
    spots.truncate(MOST_PLACES);
    Ok(spots)
}

fn nowhere(workpiece: &Workpiece<'_>, part: usize, alone: bool) -> String {
    let part = part_named(part, &workpiece.model.parts[part].name);
    if alone {
        format!(
            "no place on the table keeps {part} and the parts before it within the axis limits (eight turns of the model tried); use a \
             smaller model or a machine with more travel"
        )
    } else {
        format!(
            "{part} exceeds the X, Y or Z limits wherever the model is placed, in every orientation that the tilt reaches (eight turns of the \
             model tried)"
        )
    }
}

/// Where the shifts keep every foot on the usable table.
fn on_table(workpiece: &Workpiece<'_>, profile: &Profile) -> Cell {
    const SIDES: usize = 64;
    let feet: Vec<Vec3> =
        workpiece.model.on_table.iter().flat_map(|&p| workpiece.parts[p].vertices()).copied().collect();
    let feet: Vec<Vec3> = feet.into_iter().filter(|v| v.z < 1.0).collect();
    let far = 1e4;
    let mut cell = vec![[-far, -far], [far, -far], [far, far], [-far, far]];
    let mut clip = |normal: Spot, reach: f64| {
        let out = feet.iter().map(|v| v.x * normal[0] + v.y * normal[1]).fold(f64::NEG_INFINITY, f64::max);
        cell = clipped(&cell, normal, reach - out);
    };
    match (profile.table.radius_mm == 0.0, profile.table.size_mm) {
        (true, Some([w, d])) => {
            let keep = profile.table.keep_out_mm;
            for (normal, reach) in [([1.0, 0.0], w), ([-1.0, 0.0], w), ([0.0, 1.0], d), ([0.0, -1.0], d)] {
                clip(normal, reach / 2.0 - keep);
            }
        }
        _ => {
            // A polygon inside the disc: a foot inside it is on the table.
            let step = std::f64::consts::TAU / SIDES as f64;
            let reach = (profile.table.radius_mm - profile.table.keep_out_mm) * (step / 2.0).cos();
            for i in 0..SIDES {
                let (s, c) = (step * i as f64).sin_cos();
                clip([c, s], reach);
            }
        }
    }
    cell
}

/// The shifts at which `part` at `pose` stays within the stops.
fn shifts(setups: &Setups<'_>, part: usize, pose: crate::motion::Pose) -> Cell {
    let motion = setups.table.axes(pose);
    let reached = setups.solids[part].reached(&motion);
    let limits = setups.profile.linear_limits();
    let far = 1e4;
    let mut cell = vec![[-far, -far], [far, -far], [far, far], [-far, far]];
    for axis in 0..3 {
        let row = [motion.rotation[(axis, 0)], motion.rotation[(axis, 1)]];
        cell = clipped(&cell, row, limits.max[axis] - reached.max[axis]);
        cell = clipped(&cell, [-row[0], -row[1]], reached.min[axis] - limits.min[axis]);
    }
    cell
}

/// The part of `cell` where `normal . p <= reach` (Sutherland and Hodgman, 1974). A normal of 0 keeps all or nothing.
fn clipped(cell: &[Spot], normal: Spot, reach: f64) -> Cell {
    let beyond = |p: &Spot| p[0] * normal[0] + p[1] * normal[1] - reach;
    let mut kept = Cell::new();
    for (i, p) in cell.iter().enumerate() {
        let q = &cell[(i + 1) % cell.len()];
        let (a, b) = (beyond(p), beyond(q));
        if a <= 0.0 {
            kept.push(*p);
        }
        if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
            let t = a / (a - b);
            kept.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        }
    }
    kept
}

fn common(a: &Cell, b: &Cell) -> Cell {
    let mut cell = a.clone();
    for (i, p) in b.iter().enumerate() {
        let q = b[(i + 1) % b.len()];
        let normal = [q[1] - p[1], p[0] - q[0]];
        cell = clipped(&cell, normal, p[0] * normal[0] + p[1] * normal[1]);
    }
    cell
}

/// Adds `cell` unless it is empty or inside one of `cells`; drops those inside it.
fn add_cell(cells: &mut Vec<Cell>, cell: Cell) {
    let empty = cell.len() < 3 || area(&cell) < 1e-9;
    if empty || cells.iter().any(|known| inside(&cell, known)) {
        return;
    }
    cells.retain(|known| !inside(known, &cell));
    cells.push(cell);
}

fn inside(inner: &Cell, outer: &Cell) -> bool {
    inner.iter().all(|p| {
        (0..outer.len()).all(|i| {
            let (a, b) = (outer[i], outer[(i + 1) % outer.len()]);
            (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) >= -1e-9
        })
    })
}

fn area(cell: &Cell) -> f64 {
    let pairs = (0..cell.len()).map(|i| (cell[i], cell[(i + 1) % cell.len()]));
    pairs.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() / 2.0
}

fn middle(cell: &Cell) -> Spot {
    let n = cell.len() as f64;
    let sum = cell.iter().fold([0.0, 0.0], |s, p| [s[0] + p[0], s[1] + p[1]]);
    [sum[0] / n, sum[1] / n]
}

/// The spot of `cell` nearest to no shift at all, and [`INWARD_MM`] farther in.
fn inward(cell: &Cell) -> Spot {
    let origin = vec![[0.0, 0.0]];
    if inside(&origin, cell) {
        return [0.0, 0.0];
    }
    let on_edge = |i: usize| {
        let (a, b) = (cell[i], cell[(i + 1) % cell.len()]);
        let d = [b[0] - a[0], b[1] - a[1]];
        let t = (-(a[0] * d[0] + a[1] * d[1]) / (d[0] * d[0] + d[1] * d[1]).max(1e-12)).clamp(0.0, 1.0);
        [a[0] + t * d[0], a[1] + t * d[1]]
    };
    let nearest = (0..cell.len()).map(on_edge).min_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
    let (p, m) = (nearest.unwrap_or_default(), middle(cell));
    let (dx, dy) = (m[0] - p[0], m[1] - p[1]);
    let step = (INWARD_MM / dx.hypot(dy).max(1e-12)).min(1.0);
    [p[0] + step * dx, p[1] + step * dy]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, half: f64) -> Cell {
        vec![[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]]
    }

    #[test]
    fn half_planes_cut_squares() {
        let half = clipped(&square(0.0, 0.0, 1.0), [1.0, 0.0], 0.25);
        assert!((area(&half) - 2.5).abs() < 1e-12);
        assert!(clipped(&half, [-1.0, 0.0], -0.3).is_empty());
        assert_eq!(clipped(&half, [0.0, 0.0], -1.0), Cell::new());
        assert_eq!(clipped(&half, [0.0, 0.0], 0.0), half);
        assert!((area(&common(&square(0.0, 0.0, 1.0), &square(1.5, 1.5, 1.0))) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn cells_inside_others_are_dropped() {
        let mut cells = Vec::new();
        for (x, half) in [(0.0, 1.0), (0.2, 0.5), (5.0, 1.0), (0.0, 2.0)] {
            add_cell(&mut cells, square(x, 0.0, half));
        }
        assert_eq!(cells, [square(5.0, 0.0, 1.0), square(0.0, 0.0, 2.0)]);
    }

    #[test]
    fn the_nearest_spot_lies_a_little_inside() {
        let [x, y] = inward(&square(10.0, 0.0, 4.0));
        assert!((x - 7.0).abs() < 1e-9 && y.abs() < 1e-9, "{x} {y}");
        assert_eq!(inward(&square(0.5, 0.0, 4.0)), [0.0, 0.0]);
    }
}
