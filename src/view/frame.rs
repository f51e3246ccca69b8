//! One picture of solids: surfaces with what is hidden hidden, see-through bodies above, arrows, names, axes and a scale.

use super::drawing::{Anchor, Colour, Drawing, INK, width_of};
use super::eye::Eye;
use super::solids::{EDGE, JOINT, Solids, Surface, Window};
use crate::geom::{Bounds, Vec3, convex_outline};

/// Places of the grid in a unit of the drawing: the steps of a border are that much finer than a dot.
const FINE: f64 = 2.5;
/// Places along a side where only the eye is chosen.
const COARSE: f64 = 110.0;
/// From the edge to what must be in sight, units.
const MARGIN: f64 = 16.0;
const EDGE_WIDTH: f64 = 0.6;
const JOINT_WIDTH: f64 = 2.4;
/// Where new material meets old, and names.
pub const JOINT_COLOUR: Colour = [0, 114, 178];
/// Where less of a surface is seen, its outline is drawn above what hides it.
const HIDDEN: f64 = 0.2;
const NAME: f64 = 11.0;
const MOST_LETTERS: usize = 20;

/// Where it may be seen from, the usual first: turn and rise, degrees, and what makes another one worse.
const EYES: [([f64; 2], f64); 8] = [
    ([-35.0, 24.0], 0.0),
    ([35.0, 24.0], 0.04),
    ([-35.0, 48.0], 0.06),
    ([35.0, 48.0], 0.08),
    ([-75.0, 24.0], 0.1),
    ([75.0, 24.0], 0.1),
    ([145.0, 30.0], 0.14),
    ([-145.0, 30.0], 0.14),
];
const EYES_BELOW: [([f64; 2], f64); 5] = [
    ([-35.0, -32.0], 0.0),
    ([35.0, -32.0], 0.02),
    ([145.0, -32.0], 0.04),
    ([-145.0, -32.0], 0.04),
    ([-35.0, -65.0], 0.05),
];

/// A convex body that what is behind it shines through.
#[derive(Clone, Debug, PartialEq)]
pub struct Ghost {
    /// Its corners, mm.
    pub points: Vec<Vec3>,
    /// Its colour.
    pub colour: Colour,
}

/// A line in space with words at its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrow {
    /// Its corners, mm.
    pub points: Vec<Vec3>,
    /// Whether it ends in a point.
    pub head: bool,
    /// Written at the end; may be empty.
    pub text: String,
    /// Its colour.
    pub colour: Colour,
}

/// From which side a picture is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// From above the horizon.
    #[default]
    Above,
    /// From below it.
    Below,
}

/// One picture, all in one frame, mm, Z upward.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// What hides what is behind it.
    pub surfaces: Vec<Surface>,
    /// What does not.
    pub ghosts: Vec<Ghost>,
    /// Lines above all.
    pub arrows: Vec<Arrow>,
    /// Places that must be in sight.
    pub scope: Vec<Vec3>,
    /// From where.
    pub side: Side,
    /// Lines of words below it.
    pub caption: Vec<String>,
}

impl Frame {
    /// What is seen of the scope, on paper.
    pub(super) fn extent(&self, eye: &Eye) -> Bounds {
        let arrows = self.arrows.iter().flat_map(|arrow| &arrow.points);
        let flat = |p: &Vec3| {
            let [x, y, _] = eye.seen(p);
            Vec3::new(x, y, 0.0)
        };
        Bounds::of(self.scope.iter().chain(arrows).map(flat))
    }

    /// The eye by which most is seen of what the frame is about, the marked facets of it before all, and of each surface something.
    pub(super) fn eye(&self) -> Eye {
        let eyes: &[_] = if self.side == Side::Below { &EYES_BELOW } else { &EYES };
        let mut best = (Eye::at(eyes[0].0[0], eyes[0].0[1]), f64::NEG_INFINITY);
        for ([turn, rise], worse) in eyes {
            let eye = Eye::at(*turn, *rise);
            let worth = self.worth(&eye) - worse;
            if worth > best.1 + 1e-9 {
                best = (eye, worth);
            }
        }
        best.0
    }

    fn worth(&self, eye: &Eye) -> f64 {
        let extent = self.extent(eye);
        if extent.is_empty() {
            return 0.0;
        }
        let size = extent.size().x.max(extent.size().y).max(1e-6);
        let window = Window { places: [COARSE as usize; 2], scale: COARSE / size, middle: middle(&extent) };
        let all = Solids::of(self.surfaces.iter(), eye, &window);
        let places = 0..all.labels.each.len();
        let (mut visible, mut marked) = (vec![0.0; self.surfaces.len()], 0.0);
        for seen in places.clone().filter_map(|i| all.at(i)) {
            visible[seen.surface] += 1.0;
            marked += f64::from(u8::from(seen.marked));
        }
        let (mut sum, mut least, mut count) = (0.0, 1.0f64, 0.0);
        for (surface, visible) in self.surfaces.iter().zip(&visible).filter(|(surface, _)| surface.wanted) {
            let alone = Solids::of(std::iter::once(surface), eye, &window);
            let own = places.clone().filter(|i| alone.at(*i).is_some()).count() as f64;
            let share = if own > 0.0 { visible / own } else { 1.0 };
            (sum, least, count) = (sum + share, least.min(share), count + 1.0);
        }
        let total: f64 = visible.iter().sum();
        let marks = if total > 0.0 { marked / total } else { 0.0 };
        if count == 0.0 { marks } else { sum / count + least + marks }
    }

    /// Draws it into a square with its upper left corner at `at`; `scale` is in units a millimetre.
    pub(super) fn draw(&self, drawing: &mut Drawing, at: [f64; 2], side: f64, eye: &Eye, scale: f64) {
        let places = (side * FINE) as usize;
        let middle = middle(&self.extent(eye));
        let window = Window { places: [places; 2], scale: scale * FINE, middle };
        let paper = |[x, y]: [f64; 2]| [at[0] + x / FINE, at[1] + y / FINE];
        let seen = |p: &Vec3| {
            let [x, y, _] = eye.seen(p);
            paper(window.place([x, y]))
        };
        let solids = Solids::of(self.surfaces.iter(), eye, &window).tidied();
        // What touches may differ in depth by some places.
        let regions = solids.labels.regions(|places| solids.border(places, &self.surfaces, 4.0 / window.scale));
        for (label, rings) in &regions.areas {
            let rings = rings.iter().map(|ring| ring.iter().map(|p| paper(*p)).collect()).collect();
            drawing.area(rings, solids.seen[*label as usize - 1].colour, 1.0);
        }
        for (class, width, colour) in [(EDGE, EDGE_WIDTH, INK), (JOINT, JOINT_WIDTH, JOINT_COLOUR)] {
            drawing.lines(regions.lines(class, paper), width, colour);
        }
        self.outlines(drawing, &solids, eye, &window, paper);
        for ghost in &self.ghosts {
            let outline = convex_outline(ghost.points.iter().map(seen).collect(), 0.0);
            let mut outline = clipped(outline, at, side);
            if outline.len() > 2 {
                drawing.area(vec![outline.clone()], ghost.colour, 0.3);
                outline.push(outline[0]);
                drawing.line(outline, EDGE_WIDTH, ghost.colour);
            }
        }
        self.arrows.iter().for_each(|arrow| draw_arrow(drawing, arrow, seen));
        self.names(drawing, &solids, at, side);
        axes(drawing, [at[0] + 24.0, at[1] + side - 24.0], eye);
    }

    /// The outlines of what the picture is about and what is hidden nearly whole.
    fn outlines(
        &self,
        drawing: &mut Drawing,
        solids: &Solids,
        eye: &Eye,
        window: &Window,
        paper: impl Fn([f64; 2]) -> [f64; 2],
    ) {
        for (index, surface) in self.surfaces.iter().enumerate().filter(|(_, surface)| surface.wanted) {
            let alone = Solids::of(std::iter::once(surface), eye, window);
            let places = 0..alone.labels.each.len();
            let own = places.clone().filter(|i| alone.at(*i).is_some()).count();
            let visible = places.filter(|i| solids.at(*i).is_some_and(|seen| seen.surface == index)).count();
            if visible as f64 >= HIDDEN * own as f64 {
                continue;
            }
            let regions = alone.labels.regions(|places| alone.border(places, std::slice::from_ref(surface), 0.0));
            drawing.lines(regions.lines(EDGE, &paper), 1.0, surface.colour);
            if let Some(name) = &surface.name {
                let places = (0..alone.labels.each.len()).filter(|i| alone.at(*i).is_some());
                let (x, y) = places.fold((0.0, 0.0f64), |(x, y), i| {
                    (x + (i % alone.labels.width) as f64, y.max((i / alone.labels.width) as f64))
                });
                // Below the outline, where what hides it has no name.
                drawing.label(paper([x / own.max(1) as f64, y + NAME * FINE]), NAME, INK, shortened(name));
            }
        }
    }

    /// The wanted surfaces' names where each is seen, none on another.
    fn names(&self, drawing: &mut Drawing, solids: &Solids, at: [f64; 2], side: f64) {
        let width = solids.labels.width;
        let place = |i: usize| [(i % width) as f64, (i / width) as f64];
        let mut sums = vec![([0.0; 2], 0.0); self.surfaces.len()];
        for (i, seen) in (0..solids.labels.each.len()).filter_map(|i| Some((i, solids.at(i)?))) {
            let ([x, y], sum) = (place(i), &mut sums[seen.surface]);
            *sum = ([sum.0[0] + x, sum.0[1] + y], sum.1 + 1.0);
        }
        let mut nearest: Vec<Option<(f64, usize)>> = vec![None; self.surfaces.len()];
        for (i, seen) in (0..solids.labels.each.len()).filter_map(|i| Some((i, solids.at(i)?))) {
            let ([x, y], ([sx, sy], count)) = (place(i), sums[seen.surface]);
            let far = (x - sx / count).hypot(y - sy / count);
            let best = &mut nearest[seen.surface];
            if best.is_none_or(|(least, _)| far < least) {
                *best = Some((far, i));
            }
        }
        let mut taken: Vec<[f64; 4]> = Vec::new();
        for (index, (surface, found)) in self.surfaces.iter().zip(nearest).enumerate() {
            let (Some(name), Some((_, i))) = (&surface.name, found) else { continue };
            let ([x, y], name) = (place(i), shortened(name));
            let anchor = [at[0] + x / FINE, at[1] + y / FINE];
            let half = width_of(&name, NAME) / 2.0;
            let x = anchor[0].clamp(at[0] + half + 2.0, (at[0] + side - half - 2.0).max(at[0] + half + 2.0));
            let steps =
                (0..40).map(|k| f64::from((k + 1) / 2) * if k % 2 == 0 { 1.0 } else { -1.0 } * 0.5 * (NAME + 1.0));
            let fits = |y: &f64| {
                let within = *y > at[1] + NAME && *y < at[1] + side - 2.0;
                let apart = |b: &[f64; 4]| x + half < b[0] || x - half > b[1] || *y < b[2] || *y - NAME > b[3];
                within && taken.iter().all(apart)
            };
            // A name would hide what is hardly larger than it.
            let aside = if sums[index].1 < 3.0 * half * NAME * FINE * FINE { 2.0 * NAME } else { 0.0 };
            let Some(y) = steps.map(|dy| anchor[1] + 4.0 + aside + dy).find(fits) else { continue };
            taken.push([x - half, x + half, y - NAME, y]);
            if (y - 4.0 - anchor[1]).abs() > NAME * 0.6 {
                drawing.line(vec![anchor, [x, y - 4.0]], 0.7, INK);
            }
            drawing.label([x, y], NAME, INK, name);
        }
    }
}

fn middle(extent: &Bounds) -> [f64; 2] {
    if extent.is_empty() { [0.0; 2] } else { [extent.centre().x, extent.centre().y] }
}

/// Units a millimetre by which the extent fills a square.
pub(super) fn scale_for(extent: &Bounds, side: f64) -> f64 {
    if extent.is_empty() {
        return 1.0;
    }
    (side - 2.0 * MARGIN) / extent.size().x.max(extent.size().y).max(1e-6)
}

fn shortened(name: &str) -> String {
    if name.chars().count() <= MOST_LETTERS {
        return name.to_owned();
    }
    name.chars().take(MOST_LETTERS - 2).chain("..".chars()).collect()
}

fn draw_arrow(drawing: &mut Drawing, arrow: &Arrow, seen: impl Fn(&Vec3) -> [f64; 2]) {
    let points: Vec<[f64; 2]> = arrow.points.iter().map(seen).collect();
    let [.., before, end] = points[..] else { return };
    drawing.line(points.clone(), 1.6, arrow.colour);
    let (dx, dy) = (end[0] - before[0], end[1] - before[1]);
    let long = dx.hypot(dy).max(1e-9);
    let (ux, uy) = (dx / long, dy / long);
    if arrow.head {
        let wing = |side: f64| [end[0] - 7.0 * ux - side * 3.5 * uy, end[1] - 7.0 * uy + side * 3.5 * ux];
        drawing.area(vec![vec![end, wing(1.0), wing(-1.0)]], arrow.colour, 1.0);
    }
    if !arrow.text.is_empty() {
        drawing.label([end[0] + 10.0 * ux, end[1] + 10.0 * uy + 4.0], NAME, arrow.colour, arrow.text.clone());
    }
}

/// The frame's axes at a place of the paper.
fn axes(drawing: &mut Drawing, [x, y]: [f64; 2], eye: &Eye) {
    for (axis, letter, colour) in
        [(Vec3::x(), "X", [190, 40, 40]), (Vec3::y(), "Y", [30, 130, 40]), (Vec3::z(), "Z", [40, 70, 190])]
    {
        let [dx, dy, _] = eye.seen(&axis);
        drawing.line(vec![[x, y], [x + 15.0 * dx, y + 15.0 * dy]], 1.4, colour);
        drawing.label([x + 21.0 * dx, y + 21.0 * dy + 3.0], 9.0, colour, letter);
    }
}

/// A bar of a round length, its right end at a place of the paper.
pub(super) fn scale_bar(drawing: &mut Drawing, [x, y]: [f64; 2], scale: f64) {
    let wanted = 70.0 / scale;
    let power = 10f64.powf(wanted.log10().floor());
    let length = [5.0, 2.0, 1.0].into_iter().map(|k| k * power).find(|l| *l <= wanted).unwrap_or(power);
    let from = x - length * scale;
    drawing.line(vec![[from, y - 3.0], [from, y], [x, y], [x, y - 3.0]], 1.0, INK);
    drawing.text([(from + x) / 2.0, y - 5.0], 9.0, Anchor::Middle, format!("{length} mm"));
}

/// What of a convex outline lies within a square (Sutherland and Hodgman 1974).
fn clipped(mut outline: Vec<[f64; 2]>, at: [f64; 2], side: f64) -> Vec<[f64; 2]> {
    for (axis, sign, limit) in [(0, 1.0, at[0]), (0, -1.0, -at[0] - side), (1, 1.0, at[1]), (1, -1.0, -at[1] - side)] {
        let inside = |p: &[f64; 2]| sign * p[axis] - limit;
        let mut kept = Vec::new();
        for (i, p) in outline.iter().enumerate() {
            let q = outline[(i + 1) % outline.len()];
            let (a, b) = (inside(p), inside(&q));
            if a >= 0.0 {
                kept.push(*p);
            }
            if (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0) {
                let t = a / (a - b);
                kept.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
            }
        }
        outline = kept;
    }
    outline
}
