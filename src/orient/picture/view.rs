//! A part on the bed with what overhangs and what holds it.

use super::super::Facets;
use super::super::column::Raster;
use super::Picture;
use super::canvas::Canvas;
use crate::geom::{Angle, Vec3, turned_by};

/// How facets are coloured.
#[derive(Clone, Copy, Debug)]
pub enum Paint<'a> {
    /// What faces down by more than this from the vertical, and is not on the bed, in red.
    Overhangs(Angle),
    /// What each facet costs (seed 002, figure 4.6): blue raises the sum, red lowers it, the more the deeper.
    Costs(&'a [f64], Angle),
}

const SIZE: [usize; 2] = [900, 700];
const PAPER: [u8; 3] = [250, 250, 248];
const BED: [u8; 3] = [222, 222, 226];
const PART: [u8; 3] = [205, 200, 190];
const OVERHANG: [u8; 3] = [225, 70, 60];
const SUPPORT: [u8; 3] = [120, 170, 225];
/// Columns of support across the part.
const STICKS: f64 = 70.0;
/// Seen lower than this above the bed, a facet lies on it.
const ON_BED_MM: f64 = crate::mesh::TABLE_GAP_MM;

/// The part with `up` upright on the bed, seen from the front left and above, its supports as upright columns: from what
/// overhangs by more than the angle down to the part or the bed. An open mesh has no inside: what is drawn below it then is
/// of no worth. An empty one gives the empty page.
pub fn view(facets: &Facets, up: &Vec3, paint: Paint<'_>) -> Picture {
    let turn = turned_by(up);
    let low = facets.lowest(up).dot(up);
    let stand = |p: &Vec3| turn * p - Vec3::z() * low;
    let points: Vec<Vec3> = facets.points.iter().map(stand).collect();
    let bed = bed(&points);
    let mut canvas = Canvas::around(points.iter().chain(&bed).copied(), SIZE, PAPER);
    let [a, b, c, d] = bed.map(|p| p - Vec3::z() * 1e-3);
    canvas.facet([a, b, c], BED);
    canvas.facet([a, c, d], BED);
    let (Paint::Overhangs(angle) | Paint::Costs(_, angle)) = paint;
    let hangs = |i: usize| {
        let facet = &facets.each[i];
        let height = facet.barycentre.dot(up) - low;
        -facet.area.dot(up) > angle.rad().sin() * facet.area.norm() && height > ON_BED_MM
    };
    for (i, corners) in facets.corners.iter().enumerate() {
        let colour = match paint {
            Paint::Overhangs(_) => {
                if hangs(i) {
                    OVERHANG
                } else {
                    PART
                }
            }
            Paint::Costs(costs, _) => cost_colour(costs, i, facets),
        };
        canvas.facet(corners.map(|k| points[k as usize]), colour);
    }
    let width = facets.reach() * 2.0 / STICKS;
    let raster = Raster::of(facets, up, width.max(1e-9));
    for gap in raster.gaps().filter(|gap| hangs(gap.above as usize)) {
        let [from, to] = [gap.from, gap.to].map(|z| stand(&raster.point(gap.column, z)));
        canvas.stick(&from, &to, 0.5 * raster.width, SUPPORT);
    }
    canvas.picture
}

/// The corners of a piece of bed somewhat larger than what stands on it.
fn bed(points: &[Vec3]) -> [Vec3; 4] {
    let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    points.iter().for_each(|p| (low, high) = (low.inf(p), high.sup(p)));
    if points.is_empty() {
        (low, high) = (Vec3::zeros(), Vec3::zeros());
    }
    let edge = 0.08 * (high - low).norm();
    let [x0, y0, x1, y1] = [low.x - edge, low.y - edge, high.x + edge, high.y + edge];
    [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| Vec3::new(x, y, 0.0))
}

/// Blue for a cost above 0, red for one below, white for none; per area, so that small facets are as deep as large ones.
fn cost_colour(costs: &[f64], i: usize, facets: &Facets) -> [u8; 3] {
    let by_area = |i: usize| costs.get(i).copied().unwrap_or(0.0) / facets.each[i].area.norm();
    let most = costs.iter().map(|c| c.abs()).sum::<f64>() / facets.sum(|f| f.area.norm()).max(f64::MIN_POSITIVE);
    let share = (by_area(i) / (4.0 * most).max(f64::MIN_POSITIVE)).clamp(-1.0, 1.0);
    let fade = (235.0 * (1.0 - share.abs())) as u8;
    if share >= 0.0 { [fade, fade, 235] } else { [235, fade, fade] }
}
