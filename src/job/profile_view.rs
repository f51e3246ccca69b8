//! A machine from the side, along its tilt axis, as SVG: the table level and at both ends, head, frame, and where the tip may go.
//!
//! Machine coordinates, mm; across is Y of an A table and X of a B table, up is Z. Bodies are drawn by their outlines.

use std::fmt::Write;

use super::CheckedProfile;
use crate::geom::{Angle, Vec3, convex_outline};
use crate::motion::{Pose, TiltAbout};

/// The picture's larger side, pixels.
const SIDE: f64 = 900.0;
/// Round the drawing, mm.
const MARGIN: f64 = 30.0;

struct Drawing {
    out: String,
    /// Lowest across and highest up.
    corner: [f64; 2],
    scale: f64,
}

impl Drawing {
    fn at(&self, [across, up]: [f64; 2]) -> (f64, f64) {
        ((across - self.corner[0]) * self.scale, (self.corner[1] - up) * self.scale)
    }

    fn outline(&mut self, points: Vec<[f64; 2]>, style: &str, title: &str) {
        let ring = convex_outline(points, 0.0);
        let corners: Vec<String> = ring
            .iter()
            .map(|&p| {
                let (x, y) = self.at(p);
                format!("{x:.1},{y:.1}")
            })
            .collect();
        let _ = writeln!(
            self.out,
            "<polygon points=\"{}\" {style}><title>{}</title></polygon>",
            corners.join(" "),
            escaped(title)
        );
    }

    fn text(&mut self, at: [f64; 2], text: &str) {
        let (x, y) = self.at(at);
        let _ = writeln!(self.out, "<text x=\"{x:.1}\" y=\"{y:.1}\">{}</text>", escaped(text));
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

impl CheckedProfile {
    /// The picture.
    pub fn svg(&self) -> String {
        let profile = &self.machine.profile;
        let table = profile.kinematics();
        let side = |p: Vec3| if table.about == TiltAbout::X { [p.y, p.z] } else { [p.x, p.z] };
        let limits = profile.linear_limits();
        let frame = [limits.min, limits.max].map(side);
        let slab = |word: f64| -> Vec<[f64; 2]> {
            let pose = Pose { tilt: table.tilt.angle_of(Angle::from_deg(word)), ..Pose::LEVEL };
            let motion = table.forward(pose);
            profile.table_slab().iter().map(|p| side(motion.rotation * p + motion.translation)).collect()
        };
        let tip = Vec3::from(self.tilts[0].centre_mm);
        let moved = |body: &crate::geom::Body| -> Vec<[f64; 2]> {
            let origin = body.origin_at(&tip);
            body.points.iter().map(|p| side(p + origin)).collect()
        };
        let head: Vec<_> = profile.head_bodies().iter().map(|body| (body.name.clone(), moved(body))).collect();
        let fixed: Vec<_> = profile
            .fixed_bodies()
            .into_iter()
            .map(|b| (b.name, b.points.into_iter().map(side).collect::<Vec<_>>()))
            .collect();
        let tables: Vec<_> = self.tilts.iter().take(3).map(|at| (at.tilt_deg, slab(at.tilt_deg))).collect();
        let everything =
            tables.iter().flat_map(|(_, p)| p).chain(head.iter().chain(&fixed).flat_map(|(_, p)| p)).chain(&frame);
        let mut drawing = started(everything.copied());
        let [[left, bottom], [right, top]] = frame;
        drawing.outline(
            vec![[left, bottom], [right, bottom], [right, top], [left, top]],
            "fill=\"none\" stroke=\"#888\" stroke-dasharray=\"6 5\"",
            "where the tip may go",
        );
        for (name, points) in fixed {
            drawing.outline(points, "fill=\"#bbb\" stroke=\"#666\"", &name);
        }
        let letter = profile.kinematics.tilt.letter;
        for (place, (word, points)) in tables.into_iter().enumerate().rev() {
            let (fill, name) = if place == 0 { ("#2b7bba", "level") } else { ("#9ecae1", "an end of the tilt") };
            let highest = points.iter().copied().fold([0.0, f64::NEG_INFINITY], |a, b| if b[1] > a[1] { b } else { a });
            let style = format!("fill=\"{fill}\" fill-opacity=\"0.7\" stroke=\"#08519c\"");
            drawing.outline(points, &style, &format!("table, {name}: {letter}{word}"));
            drawing.text([highest[0], highest[1] + 4.0], &format!("{letter}{word}"));
        }
        for (name, points) in head {
            drawing.outline(points, "fill=\"#fd8d3c\" fill-opacity=\"0.45\" stroke=\"#a63603\"", &name);
        }
        let pivot = side(table.pivot);
        let (x, y) = drawing.at(pivot);
        let _ = writeln!(
            drawing.out,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"#d00\"><title>tilt axis</title></circle>"
        );
        let [across, up] = pivot.map(|v| (v * 100.0).round() / 100.0 + 0.0);
        let name = if table.about == TiltAbout::X { 'Y' } else { 'X' };
        drawing.text([pivot[0] + 4.0, pivot[1] - 10.0], &format!("tilt axis, {name}{across} Z{up}"));
        let legend = format!(
            "{}: {name} to the right, Z up; dashed: where the tip may go, {name} {left}..{right}, Z {bottom}..{top}",
            profile.machine.name
        );
        drawing.text([drawing.corner[0] + 8.0, drawing.corner[1] - 14.0], &legend);
        drawing.out.push_str("</svg>\n");
        drawing.out
    }
}

fn started(points: impl Iterator<Item = [f64; 2]>) -> Drawing {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in points {
        for i in 0..2 {
            (low[i], high[i]) = (low[i].min(p[i]), high[i].max(p[i]));
        }
    }
    let size = [high[0] - low[0] + 2.0 * MARGIN, high[1] - low[1] + 2.0 * MARGIN];
    let scale = SIDE / size[0].max(size[1]);
    let [wide, tall] = size.map(|mm| mm * scale);
    let out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{wide:.0}\" height=\"{tall:.0}\" viewBox=\"0 0 {wide:.1} {tall:.1}\" \
         font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    Drawing { out, corner: [low[0] - MARGIN, high[1] + MARGIN], scale }
}
