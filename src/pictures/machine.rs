//! A machine from the side, along its tilt axis: the table level and at both ends, head, frame, and where the tip may go.
//!
//! Machine coordinates, mm; across is Y of an A table and X of a B table, up is Z. Bodies are drawn by their outlines.

use super::{HEAD, TABLE};
use crate::geom::{Angle, Body, Vec3, convex_outline};
use crate::motion::{Pose, TiltAbout};
use crate::profile::Profile;
use crate::view::{Anchor, Colour, Drawing};

/// The picture's larger side, and the height of its letters, units.
const SIDE: f64 = 900.0;
const LETTERS: f64 = 13.0;
/// Round the drawing, mm.
const MARGIN: f64 = 30.0;
/// Length of a dash and of the gap behind it, units.
const DASH: [f64; 2] = [6.0, 5.0];
const LEVEL: Colour = [43, 123, 186];
const FRAME: Colour = [150, 150, 150];
const LIMITS: Colour = [120, 120, 120];
const AXIS: Colour = [213, 0, 0];

/// A place seen from the side: across and up, mm.
type Place = [f64; 2];

/// From mm to the paper.
struct Paper {
    drawing: Drawing,
    /// Lowest across and highest up.
    corner: Place,
    scale: f64,
}

impl Paper {
    fn around(points: impl Iterator<Item = Place>, title: String) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in points {
            for i in 0..2 {
                (low[i], high[i]) = (low[i].min(p[i]), high[i].max(p[i]));
            }
        }
        let size = [0, 1].map(|i| high[i] - low[i] + 2.0 * MARGIN);
        let scale = SIDE / size[0].max(size[1]);
        let drawing = Drawing::new(size.map(|mm| mm * scale), title);
        Self { drawing, corner: [low[0] - MARGIN, high[1] + MARGIN], scale }
    }

    fn at(&self, [across, up]: Place) -> [f64; 2] {
        [(across - self.corner[0]) * self.scale, (self.corner[1] - up) * self.scale]
    }

    /// What is around `points`, filled, with a line of the same colour.
    fn body(&mut self, points: Vec<Place>, colour: Colour, opacity: f64) {
        let mut ring: Vec<_> = convex_outline(points, 0.0).into_iter().map(|p| self.at(p)).collect();
        self.drawing.area(vec![ring.clone()], colour, opacity);
        ring.extend(ring.first().copied());
        self.drawing.line(ring, 1.0, colour);
    }

    /// A dashed line from one place to another.
    fn dashes(&mut self, from: Place, to: Place) {
        let [a, b] = [from, to].map(|p| self.at(p));
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let place = |way: f64| [0, 1].map(|i| a[i] + (b[i] - a[i]) * (way / length).min(1.0));
        let count = (length / (DASH[0] + DASH[1])).ceil() as usize;
        let starts = (0..count).map(|i| i as f64 * (DASH[0] + DASH[1]));
        self.drawing.lines(starts.map(|way| vec![place(way), place(way + DASH[0])]).collect(), 1.0, LIMITS);
    }

    fn text(&mut self, at: Place, text: String) {
        let at = self.at(at);
        self.drawing.text(at, LETTERS, Anchor::Start, text);
    }
}

/// The machine of `profile` with its table, or the head that leans instead of it, at up to three `tilts` (words, degrees), the first of which is
/// level with the table's middle at `centre_mm`.
pub(crate) fn from_the_side(profile: &Profile, tilts: &[f64], centre_mm: [f64; 3]) -> Drawing {
    let table = profile.kinematics();
    let side = |p: Vec3| if table.about == TiltAbout::X { [p.y, p.z] } else { [p.x, p.z] };
    let across = if table.about == TiltAbout::X { 'Y' } else { 'X' };
    let limits = profile.linear_limits();
    let [[left, bottom], [right, top]] = [limits.min, limits.max].map(side);
    let corners = [[left, bottom], [right, bottom], [right, top], [left, top]];
    let leans = table.head.as_ref();
    let pose = |word: f64| Pose { tilt: table.tilt.angle_of(Angle::from_deg(word)), ..Pose::LEVEL };
    let slab = |word: f64| -> Vec<Place> {
        // Under a head that leans the table lies still.
        let at =
            |p: &Vec3| leans.map_or_else(|| table.forward(pose(word)).point((*p).into()).at, |head| p + head.table);
        profile.table_slab().iter().map(|p| side(at(p))).collect()
    };
    let tip = Vec3::from(centre_mm);
    let seen = |body: Body, origin: Vec3| body.points.into_iter().map(|p| side(p + origin)).collect::<Vec<_>>();
    let upright = profile.head_bodies().into_iter().map(|body| {
        let origin = body.origin_at(&tip);
        seen(body, origin)
    });
    let head: Vec<_> = upright.collect();
    // Leaning about its tip, as it stands for the ends of its tilt.
    let ends = tilts.iter().take(3).skip(1).filter(|_| leans.is_some());
    let leaning = ends.flat_map(|&word| {
        let turn = leans.map(|head| head.turn(pose(word)));
        let bodies = profile.head_bodies().into_iter().filter(|body| !body.stays);
        let turned =
            bodies.map(move |body| body.points.iter().map(|p| side(turn.map_or(*p, |turn| turn * p) + tip)).collect());
        turned.map(move |points: Vec<Place>| (word, points))
    });
    let leaning: Vec<(f64, Vec<Place>)> = leaning.collect();
    let fixed: Vec<_> = profile.fixed_bodies().into_iter().map(|body| seen(body, Vec3::zeros())).collect();
    let shown = if leans.is_some() { 1 } else { 3 };
    let tables: Vec<_> = tilts.iter().take(shown).map(|&word| (word, slab(word))).collect();
    let moved = tables.iter().chain(&leaning).map(|(_, points)| points);
    let bodies = head.iter().chain(&fixed).chain(moved).flatten();
    let name = &profile.machine.name;
    let mut paper = Paper::around(bodies.chain(&corners).copied(), format!("{name} from the side"));
    (0..4).for_each(|i| paper.dashes(corners[i], corners[(i + 1) % 4]));
    fixed.into_iter().for_each(|points| paper.body(points, FRAME, 0.6));
    let letter = profile.kinematics.tilt.letter;
    for (place, (word, points)) in tables.into_iter().enumerate().rev() {
        let highest = points.iter().copied().fold([0.0, f64::NEG_INFINITY], |a, b| if b[1] > a[1] { b } else { a });
        paper.body(points, if place == 0 { LEVEL } else { TABLE }, 0.7);
        paper.text([highest[0], highest[1] + 4.0], format!("{letter}{word}"));
    }
    let [x, y] = side(tip);
    for word in tilts.iter().take(3) {
        let own = leaning.iter().filter(|(of, _)| of == word).flat_map(|(_, points)| points);
        let far = |p: &&Place| (p[0] - x).hypot(p[1] - y);
        if let Some(outermost) = own.max_by(|a, b| far(a).total_cmp(&far(b))) {
            paper.text([outermost[0], outermost[1] + 4.0], format!("{letter}{word}"));
        }
    }
    leaning.into_iter().for_each(|(_, points)| paper.body(points, TABLE, 0.35));
    head.into_iter().for_each(|points| paper.body(points, HEAD, 0.35));
    let pivot = side(leans.map_or(table.pivot, |head| tip + head.tilt_from_tip));
    let middle = paper.at(pivot);
    paper.drawing.circle(middle, 3.0, 3.0, AXIS);
    let [y, z] = pivot.map(|v| (v * 100.0).round() / 100.0 + 0.0);
    paper.text([pivot[0] + 4.0, pivot[1] - 10.0], format!("tilt axis, {across}{y} Z{z}"));
    let ends = if leans.is_some() { "head at the ends of its tilt" } else { "table at the ends of its tilt" };
    let legend = [(LEVEL, "table, level"), (TABLE, ends), (HEAD, "head"), (FRAME, "frame")];
    for (line, (colour, words)) in legend.into_iter().enumerate() {
        let [x, y] = [8.0, 36.0 + 18.0 * line as f64];
        paper.drawing.rectangle([x, y - 10.0], [x + 11.0, y + 1.0], colour);
        paper.drawing.text([x + 16.0, y], LETTERS, Anchor::Start, words);
    }
    let reach = format!(
        "{name}: {across} to the right, Z up, mm; dashed: where the {} may go, {across} {left}..{right}, Z {bottom}..{top}",
        if leans.is_some() { "upright tip" } else { "tip" }
    );
    paper.drawing.text([8.0, 18.0], LETTERS, Anchor::Start, reach);
    paper.drawing
}
