//! What has been laid down, as the file lays it, and the table: rendered into a field at a pose, or as spheres.

use super::acts::Stroke;
use super::field::{Field, Rect};
use super::floor::Floor;
use super::hull::outline;
use crate::geom::{Bounds, Machine, Rigid, Table, Vec3};
use crate::section::to_segment;

/// Edge of the cubes by which beads are gathered into spheres, mm.
const CUBE_MM: f64 = 2.0;
/// Spacing of the points taken of a bead's axis for that, mm.
const ALONG_MM: f64 = 1.0;

/// A bead: what a disc of its width and height fills along its axis (a line's ends are round), within a capsule about that.
#[derive(Clone, Copy)]
pub(super) struct LaidBead {
    /// The middle of its cross-section at both ends.
    pub(super) ends: [Vec3; 2],
    /// Of the circle about its cross-section.
    pub(super) radius: f64,
    /// Half its height, along the build direction.
    half_up: Vec3,
    half_width: f64,
    /// The print that it belongs to.
    pub(super) print: Option<u32>,
}

impl LaidBead {
    /// Where it is at a pose.
    pub(super) fn at(&self, pose: &Rigid<Table, Machine>) -> Self {
        let ends = self.ends.map(|p| pose.point(p.into()).at);
        Self { ends, half_up: pose.rotation * self.half_up, ..*self }
    }

    /// Its point farthest along `d`: of its axis, the disc of its width about that and its height.
    pub(super) fn support(&self, d: &Vec3) -> Vec3 {
        let [a, b] = self.ends;
        let end = if a.dot(d) > b.dot(d) { a } else { b };
        let up = d.dot(&self.half_up);
        let level = d - self.half_up * (up / self.half_up.norm_squared());
        let round = level.try_normalize(1e-12).unwrap_or_else(Vec3::zeros) * self.half_width;
        end + round + if up > 0.0 { self.half_up } else { -self.half_up }
    }
}

/// All beads so far, and the table's slab.
pub(super) struct Material {
    beads: Vec<LaidBead>,
    slab: Vec<Vec3>,
    cubes: Vec<[i32; 3]>,
    gathered: usize,
    thickest: f64,
    /// The farthest of everything from the table's origin, and from its axis.
    pub(super) reach: f64,
    pub(super) reach_sideways: f64,
    /// The highest of everything over the table's surface.
    pub(super) top: f64,
    /// Of each print whether something of it has been laid; and whether something of none has.
    laid: Vec<bool>,
    strays: bool,
}

impl Material {
    pub(super) fn new(slab: Vec<Vec3>) -> Self {
        let reach = slab.iter().map(|p| p.norm()).fold(0.0, f64::max);
        let reach_sideways = slab.iter().map(|p| p.x.hypot(p.y)).fold(0.0, f64::max);
        Self {
            beads: Vec::new(),
            slab,
            cubes: Vec::new(),
            gathered: 0,
            thickest: 0.0,
            reach,
            reach_sideways,
            top: 0.0,
            laid: Vec::new(),
            strays: false,
        }
    }

    /// The table's slab, table frame.
    pub(super) fn slab(&self) -> &[Vec3] {
        &self.slab
    }

    /// Whether something has been laid of one of the prints that `counts` names, or of none.
    pub(super) fn has_any(&self, counts: impl Fn(Option<u32>) -> bool) -> bool {
        let laid = (0..).zip(&self.laid).filter(|(_, laid)| **laid);
        self.strays && counts(None) || laid.map(|(print, _)| print).any(|print| counts(Some(print)))
    }

    /// All beads, in the order in which they were laid, table frame.
    pub(super) fn beads(&self) -> &[LaidBead] {
        &self.beads
    }

    /// Keeps a printed stroke, laid at the pose whose inverse is `back`.
    ///
    /// The bead's cross-section, `width x height` below the tip, lies within a circle about its middle.
    pub(super) fn lay(&mut self, stroke: &Stroke, back: &Rigid<Machine, Table>) {
        let (width, height) = (f64::from(stroke.width), f64::from(stroke.height));
        let down = Vec3::z() * (height / 2.0);
        let ends = [stroke.from, stroke.to].map(|tip| back.point((tip - down).into()).at);
        let radius = (width * width + height * height).sqrt() / 2.0;
        self.thickest = self.thickest.max(radius);
        for end in &ends {
            self.reach = self.reach.max(end.norm() + radius);
            self.reach_sideways = self.reach_sideways.max((end.x * end.x + end.y * end.y).sqrt() + radius);
            self.top = self.top.max(end.z + radius);
        }
        let half_up = back.rotation * down;
        match stroke.print {
            None => self.strays = true,
            Some(print) => {
                let print = print as usize;
                self.laid.resize(self.laid.len().max(print + 1), false);
                self.laid[print] = true;
            }
        }
        self.beads.push(LaidBead { ends, radius, half_up, half_width: width / 2.0, print: stroke.print });
    }

    /// Centres of spheres, table frame, that together hold all beads, and their common radius.
    ///
    /// Every point of an axis is within half of `ALONG_MM` of a point taken, and that within half a cube's diagonal of
    /// the cube's centre.
    pub(super) fn spheres(&mut self) -> (Vec<Vec3>, f64) {
        for bead in &self.beads[self.gathered..] {
            let [a, b] = bead.ends;
            let count = ((b - a).norm() / ALONG_MM).ceil().max(1.0) as usize;
            let point = |i: usize| a + (b - a) * (i as f64 / count as f64);
            self.cubes.extend((0..=count).map(|i| <[i32; 3]>::from(point(i).map(|v| (v / CUBE_MM).floor() as i32))));
        }
        self.gathered = self.beads.len();
        self.cubes.sort_unstable();
        self.cubes.dedup();
        let centre = |c: &[i32; 3]| Vec3::from_fn(|i, _| (f64::from(c[i]) + 0.5) * CUBE_MM);
        let radius = CUBE_MM * 3f64.sqrt() / 2.0 + ALONG_MM / 2.0 + self.thickest;
        (self.cubes.iter().map(centre).collect(), radius)
    }

    /// The field of what has been laid so far and the table, seen at `pose`, with room for tips in `tips`; what stands too low to
    /// come near the head anywhere, as `floor` knows it, is left out.
    pub(super) fn field(&self, pose: &Rigid<Table, Machine>, tips: &Bounds, floor: Option<&Floor>) -> Field {
        let matters = |bead: &LaidBead| {
            let [a, b] = bead.ends;
            floor.is_none_or(|floor| a.z.max(b.z) + bead.radius >= floor.under([a, b], bead.radius))
        };
        let beads: Vec<LaidBead> = self.beads.iter().map(|b| b.at(pose)).filter(matters).collect();
        let slab: Vec<Vec3> = self.slab.iter().map(|&p| pose.point(p.into()).at).collect();
        let mut all = Bounds::of(slab.iter().copied().chain(beads.iter().flat_map(|b| b.ends)));
        if !tips.is_empty() {
            all = all.union(tips);
        }
        let all = all.inflated(self.thickest + 2.0);
        let mut field = Field::new(&Rect { min: [all.min.x, all.min.y], max: [all.max.x, all.max.y] });
        render_slab(&mut field, &slab);
        // The last laid is mostly the highest: what it hides is then passed over quickly.
        beads.iter().rev().for_each(|bead| render(&mut field, bead));
        field.settle();
        field
    }
}

/// Raises the cells that the stroke being printed fills: its tip's height over its width. Whether it is a support's is kept, and whose it is where
/// there are several bodies.
pub(super) fn deposit(field: &mut Field, stroke: &Stroke, holds: bool, body: Option<u32>) {
    let (a, b) = (stroke.from, stroke.to);
    let reach = f64::from(stroke.width) / 2.0 + field.reach();
    let ends = [[a.x, a.y], [b.x, b.y]];
    field.deposit(ends, reach, a.z.max(b.z));
    if holds {
        field.hold(ends, reach, a.z.max(b.z));
    }
    if let Some(body) = body {
        field.lay(ends, reach, a.z.max(b.z), body);
    }
}

/// Raises the cells under a capsule to upper bounds of its top.
///
/// The capsule lies within the endless cylinder about its axis, whose top over the axis' shadow at distance `d` is
/// `z(u) + sqrt(1 + s^2) sqrt(r^2 - d^2)` with the slope `s`, and nowhere stands higher than a sphere at its upper end.
fn render(field: &mut Field, bead: &LaidBead) {
    let ([a, b], r, slack) = (bead.ends, bead.radius, field.reach());
    let ends = [[a.x, a.y], [b.x, b.y]];
    let [dx, dy] = [b.x - a.x, b.y - a.y];
    let length = (dx * dx + dy * dy).sqrt();
    let highest = a.z.max(b.z);
    let along = if length > 1e-6 { [dx / length, dy / length] } else { [0.0; 2] };
    let slope = if length > 1e-6 { (b.z - a.z) / length } else { 0.0 };
    let stretch = (1.0 + slope * slope).sqrt();
    field.render(ends, r + slack, |x, y, top| {
        if top >= highest + r {
            return None;
        }
        let (dx, dy) = (x - a.x, y - a.y);
        let (u, d) = (dx * along[0] + dy * along[1], (dx * along[1] - dy * along[0]).abs());
        let lateral = (d - slack).max(0.0).min(r);
        if length > 1e-6 && (0.0..=length).contains(&u) {
            // Over the axis itself the sphere at the upper end is no higher than this but near that end.
            let side = (r * r - lateral * lateral).sqrt();
            return Some((a.z + slope * u + slope.abs() * slack + stretch * side).min(highest + side));
        }
        let away = (to_segment([x, y], ends) - slack).max(0.0).min(r);
        let sphere = highest + (r * r - away * away).sqrt();
        if length <= 1e-6 {
            return Some(sphere);
        }
        let side = a.z + slope * u + slope.abs() * slack + stretch * (r * r - lateral * lateral).sqrt();
        Some(sphere.min(side))
    });
}

/// Raises the cells under the table: the least of the planes of its faces that look up, within its outline.
fn render_slab(field: &mut Field, slab: &[Vec3]) {
    let slack = field.reach();
    // Over a whole cell a plane is no higher than over its middle and its slope over half a diagonal.
    let planes: Vec<[f64; 3]> = upper_planes(slab, slab.len() / 2)
        .into_iter()
        .map(|[a, b, c]| [a, b, c + (a * a + b * b).sqrt() * slack])
        .collect();
    let edges = outline(slab);
    let top = slab.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    let span = |y: f64| {
        let mut span = [f64::NEG_INFINITY, f64::INFINITY];
        for &[nx, ny, c] in &edges {
            let rest = c + slack - ny * y;
            if nx.abs() < 1e-12 {
                if rest < 0.0 {
                    return None;
                }
            } else if nx > 0.0 {
                span[1] = span[1].min(rest / nx);
            } else {
                span[0] = span[0].max(rest / nx);
            }
        }
        Some(span)
    };
    field.render_rows(span, |x, y| planes.iter().map(|[a, b, c]| a * x + b * y + c).fold(top, f64::min));
}

/// `z <= a x + b y + c` for the slab's faces that look up: its surface, or its underside where it stands on its head, and
/// its rim.
fn upper_planes(slab: &[Vec3], half: usize) -> Vec<[f64; 3]> {
    let normal = (slab[1] - slab[0]).cross(&(slab[2] - slab[0]));
    let rim = (0..half).map(|i| ((slab[(i + 1) % half] - slab[i]).cross(&normal), slab[i]));
    let faces = [(normal, slab[0]), (-normal, slab[half])].into_iter().chain(rim);
    let faces = faces.map(|(normal, on)| (normal.normalize(), on)).filter(|(normal, _)| normal.z > 1e-6);
    faces.map(|(n, on)| [-n.x / n.z, -n.y / n.z, n.dot(&on) / n.z]).collect()
}
