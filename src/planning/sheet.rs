//! A plan as one picture: a frame for each pose, the table as it stands there, what is new in colour, the head above.
//!
//! An SVG in millimetres of the machine's frame, seen from the front right and above, parallel projection. Bodies are
//! drawn farthest first by their middle; convex ones (nearly all) as their outline, others facet by facet.

use std::fmt::Write;

use super::candidates::table_solid;
use super::infeasible::Reason;
use super::plan::{Plan, Print};
use super::solid::Solid;
use super::workpiece::Workpiece;
use crate::geom::{Body, Bounds, Vec3, convex_outline};
use crate::mesh::TriangleMesh;
use crate::profile::Profile;

/// Width of a frame, SVG units.
const FRAME: f64 = 300.0;
/// Frames in a row.
const COLUMNS: usize = 3;
/// Room for the words below a frame.
const WORDS: f64 = 34.0;

/// Corners that turn by less than a hundredth of a square millimetre are not drawn: twice that, mm².
const FLAT: f64 = 0.02;

const TABLE: &str = "#c9ced6";
const PRINTED: &str = "#8f99a8";
const NEW: &str = "#e4572e";
const HEAD: &str = "#2f3e4e";
const STRUCK: &str = "#e8b93c";

struct Shape {
    outlines: Vec<Vec<[f64; 2]>>,
    depth: f64,
    fill: &'static str,
    opacity: f64,
}

/// A frame's shapes and the two lines of words below it.
type Frame = (Vec<Shape>, [String; 2]);

/// So much of the head around the tip is drawn, mm.
const HEAD_SHOWN_MM: f64 = 60.0;
/// Most frames of a sheet of reasons.
const MOST_REASONS: usize = 6;

/// The sheet of `reasons` why there is no plan: for each part and each thing in its way the nearest miss, the table at that
/// pose, the part in colour and, where the head would strike, the head there.
pub fn sheet_of_reasons(reasons: &[Reason], workpiece: &Workpiece<'_>, profile: &Profile) -> String {
    let mut frames: Vec<Frame> = Vec::new();
    let mut shown: Vec<(usize, &str)> = Vec::new();
    // The ways with the least against them come first.
    for reason in reasons {
        if frames.len() < MOST_REASONS && !shown.contains(&(reason.part, &reason.blocked_by)) {
            shown.push((reason.part, &reason.blocked_by));
            frames.push(reason_frame(reason, workpiece, profile));
        }
    }
    page(&frames, None)
}

fn reason_frame(reason: &Reason, workpiece: &Workpiece<'_>, profile: &Profile) -> Frame {
    let table = profile.kinematics();
    let motion = table.forward(reason.pose);
    let place = |part: usize| -> TriangleMesh<crate::geom::Machine> { workpiece.parts[part].moved(&motion) };
    let mut shapes = vec![solid_shape(table_solid(profile, &motion).points(), TABLE, 1.0)];
    for part in 0..workpiece.parts.len() {
        let other = reason.blocked_by.parse() == Ok(part);
        let (fill, opacity) = match (part == reason.part, other) {
            (true, _) => (NEW, 1.0),
            (_, true) => (STRUCK, 0.8),
            _ => (PRINTED, 0.35),
        };
        shapes.push(Shape { opacity, ..part_shape(&place(part), fill) });
    }
    if let Some(tip) = reason.tip {
        let tip = motion.rotation * Vec3::from(tip) + motion.translation;
        // Pieces that do not follow every axis are as long as the machine: drawn where they strike, and only near the tip.
        let strikes = |b: &Body| b.follows == [true; 3] || reason.text.contains(&b.name);
        for body in profile.head_bodies().iter().filter(|b| strikes(b)) {
            let follow = |i: usize| if body.follows[i] { tip[i] } else { 0.0 };
            let near = |i: usize, v: f64| v.clamp(tip[i] - HEAD_SHOWN_MM, tip[i] + HEAD_SHOWN_MM);
            let at = |p: &Vec3| Vec3::from_fn(|i, _| near(i, p[i] + follow(i)));
            let points: Vec<Vec3> = body.points.iter().map(at).collect();
            shapes.push(Shape { depth: f64::INFINITY, ..solid_shape(&points, HEAD, 0.55) });
        }
    }
    shapes.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let (tilt, turn) = (table.tilt.word_of(reason.pose.tilt).deg(), table.rotation.word_of(reason.pose.rotation).deg());
    let (a, c) = (table.tilt.letter as char, table.rotation.letter as char);
    (shapes, [format!("part {}: {a}{tilt:.1} {c}{turn:.1}", reason.part), reason.text.clone()])
}

/// The sheet of `plan`.
///
/// `story` says below all frames what became of the model before.
pub fn sheet(plan: &Plan, workpiece: &Workpiece<'_>, profile: &Profile, story: Option<&str>) -> String {
    let mut printed: Vec<usize> = Vec::new();
    let mut frames = Vec::new();
    for slot in &plan.slots {
        for setup in slot.setups() {
            frames.push(frame(slot.id, &setup, &printed, workpiece, profile));
            printed.extend(setup.iter().map(|p| p.part));
        }
    }
    page(&frames, story)
}

fn page(frames: &[Frame], story: Option<&str>) -> String {
    let rows = frames.len().div_ceil(COLUMNS).max(1);
    let below = (FRAME + WORDS) * rows as f64;
    let (width, height) = (FRAME * COLUMNS.min(frames.len()).max(1) as f64, below + story.map_or(0.0, |_| WORDS));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    for (index, (shapes, words)) in frames.iter().enumerate() {
        let (x, y) = ((index % COLUMNS) as f64 * FRAME, (index / COLUMNS) as f64 * (FRAME + WORDS));
        let _ = writeln!(out, "<g transform=\"translate({x} {y})\">");
        draw(&mut out, shapes);
        for (line, text) in words.iter().enumerate() {
            let y = FRAME + 12.0 + 15.0 * line as f64;
            say(&mut out, text, [FRAME / 2.0, y], FRAME);
        }
        out.push_str("</g>\n");
    }
    story.into_iter().for_each(|text| say(&mut out, text, [width / 2.0, below + WORDS / 2.0], width));
    out.push_str("</svg>\n");
    out
}

/// A sentence about the middle `at`; a long one is set smaller rather than cut.
fn say(out: &mut String, text: &str, [x, y]: [f64; 2], wide: f64) {
    let size = (wide * 1.9 / text.chars().count().max(1) as f64).clamp(6.0, 13.0);
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    let _ = writeln!(
        out,
        "<text x=\"{x}\" y=\"{y}\" font-size=\"{size:.1}\" text-anchor=\"middle\" fill=\"#222222\">{text}</text>"
    );
}

fn frame(slot: usize, setup: &[&Print], printed: &[usize], workpiece: &Workpiece<'_>, profile: &Profile) -> Frame {
    let table = profile.kinematics();
    let motion = table.forward(setup[0].pose(&table));
    let place = |part: usize| -> TriangleMesh<crate::geom::Machine> { workpiece.parts[part].moved(&motion) };
    let mut shapes = vec![solid_shape(table_solid(profile, &motion).points(), TABLE, 1.0)];
    shapes.extend(printed.iter().map(|&part| part_shape(&place(part), PRINTED)));
    let mut tip = Vec3::new(0.0, 0.0, f64::NEG_INFINITY);
    for print in setup {
        let mesh = place(print.part);
        let top = mesh.vertices().iter().copied().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap_or_default();
        if top.z > tip.z {
            let bounds = mesh.bounds();
            tip = Vec3::new(bounds.centre().x.clamp(top.x - 1.0, top.x + 1.0), top.y, top.z);
        }
        shapes.push(part_shape(&mesh, NEW));
    }
    for body in profile.head_bodies().iter().filter(|b| b.follows == [true; 3]).take(2) {
        // Only the head's lower end: the rest would hide what is printed.
        let points: Vec<Vec3> = body.points.iter().map(|p| Vec3::new(p.x, p.y, p.z.min(30.0)) + tip).collect();
        shapes.push(Shape { depth: f64::INFINITY, ..solid_shape(&points, HEAD, 0.85) });
    }
    shapes.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let parts: Vec<String> = setup.iter().map(|p| p.part.to_string()).collect();
    let (a, c) = (table.tilt.letter as char, table.rotation.letter as char);
    let first = setup[0];
    (
        shapes,
        [
            format!("slot {slot}: {a}{} {c}{}", first.tilt_deg, first.rotation_deg),
            format!("parts {}", parts.join(", ")),
        ],
    )
}

/// To the paper: x right, y down; and how near it is.
fn project(p: &Vec3) -> ([f64; 2], f64) {
    let (sy, cy) = (-32f64).to_radians().sin_cos();
    let (sp, cp) = 22f64.to_radians().sin_cos();
    let (x, y) = (cy * p.x - sy * p.y, sy * p.x + cy * p.y);
    ([x, -(cp * p.z + sp * y)], -(cp * y) + sp * p.z)
}

fn solid_shape(points: &[Vec3], fill: &'static str, opacity: f64) -> Shape {
    let depth = project(&Bounds::of(points.iter().copied()).centre()).1;
    Shape { outlines: vec![convex_outline(points.iter().map(|p| project(p).0).collect(), FLAT)], depth, fill, opacity }
}

fn part_shape<F>(mesh: &TriangleMesh<F>, fill: &'static str) -> Shape {
    let whole = solid_shape(mesh.vertices(), fill, 1.0);
    if Solid::of(mesh).is_hull() {
        return whole;
    }
    // Only what faces the reader: facets seen from behind turn the other way round and would cancel those before them.
    let facing = |ring: &Vec<[f64; 2]>| {
        let [a, b, c] = [ring[0], ring[1], ring[2]];
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) < 0.0
    };
    let rings = (0..mesh.facets().len()).map(|i| mesh.corners(i).map(|c| project(&c).0).to_vec());
    let facets = rings.filter(facing).collect();
    Shape { outlines: facets, ..whole }
}

/// The shapes, scaled into the frame.
fn draw(out: &mut String, shapes: &[Shape]) {
    let all = shapes.iter().flat_map(|s| s.outlines.iter().flatten());
    let bounds = Bounds::of(all.map(|p| Vec3::new(p[0], p[1], 0.0)));
    let size = bounds.size();
    let scale = (FRAME - 20.0) / size.x.max(size.y).max(1.0);
    let middle = bounds.centre();
    for shape in shapes {
        let mut path = String::new();
        for outline in &shape.outlines {
            for (i, p) in outline.iter().enumerate() {
                let (x, y) = ((p[0] - middle.x) * scale + FRAME / 2.0, (p[1] - middle.y) * scale + FRAME / 2.0);
                let _ = write!(path, "{}{x:.1} {y:.1}", if i == 0 { 'M' } else { 'L' });
            }
            path.push('Z');
        }
        let (fill, opacity) = (shape.fill, shape.opacity);
        let _ = writeln!(
            out,
            "<path d=\"{path}\" fill=\"{fill}\" fill-opacity=\"{opacity}\" stroke=\"#ffffff\" stroke-width=\"0.6\" stroke-linejoin=\"round\"/>"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn higher_is_higher_on_paper_and_nearer_is_nearer() {
        assert!(project(&Vec3::new(0.0, 0.0, 10.0)).0[1] < project(&Vec3::zeros()).0[1]);
        assert!(project(&Vec3::new(0.0, -10.0, 0.0)).1 > project(&Vec3::zeros()).1);
    }
}
