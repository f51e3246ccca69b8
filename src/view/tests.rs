//! What a frame shows of solids whose look is known.

use super::*;
use crate::fixtures::solid_box;
use crate::geom::Vec3;

const BACK: Colour = [40, 90, 200];
const FRONT: Colour = [200, 60, 40];

fn boxed(min: [f64; 3], max: [f64; 3], colour: Colour) -> Surface {
    let mesh = solid_box(Vec3::from(min), Vec3::from(max));
    Surface { wanted: true, ..Surface::of(&mesh, colour) }
}

fn sheet(surfaces: Vec<Surface>) -> Sheet {
    let scope = surfaces.iter().flat_map(|surface| surface.points.iter().copied()).collect();
    let frame = Frame { surfaces, scope, caption: vec!["said".into()], ..Frame::default() };
    Sheet { title: String::new(), side: 200.0, columns: 1, frames: vec![frame], legend: vec![], story: vec![] }
}

/// Dots whose hue is nearer to a colour, in any of its shades, than to grey.
fn dots(drawing: &Drawing, colour: Colour) -> usize {
    let picture = Picture::of(drawing);
    let like = |p: &&Colour| {
        let long = |c: &Colour| c.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt();
        let dot: f64 = p.iter().zip(&colour).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
        dot / (long(p) * long(&colour)).max(1.0) > 0.985
    };
    picture.pixels.iter().filter(like).count()
}

#[test]
fn what_stands_behind_is_hidden_and_what_is_looked_for_is_seen() {
    let wall = boxed([-30.0, -2.0, 0.0], [30.0, 2.0, 40.0], FRONT);
    let tower = boxed([-5.0, 12.0, 0.0], [5.0, 22.0, 20.0], BACK);
    // From the front the wall hides the tower; the eye goes round it.
    let found = dots(&sheet(vec![wall.clone(), tower.clone()]).drawing(), BACK);
    let alone = dots(&sheet(vec![tower.clone()]).drawing(), BACK);
    assert!(found > 1500, "{found} dots of the tower, {alone} of it alone");
    // Walls all around but for the top: from higher.
    let walls = [
        [-30.0, -30.0, 30.0, -28.0],
        [-30.0, 28.0, 30.0, 30.0],
        [-30.0, -28.0, -28.0, 28.0],
        [28.0, -28.0, 30.0, 28.0],
    ];
    let wall = |[x0, y0, x1, y1]: [f64; 4]| Surface { wanted: false, ..boxed([x0, y0, 0.0], [x1, y1, 45.0], FRONT) };
    let mut court: Vec<Surface> = walls.map(wall).to_vec();
    court.push(boxed([-8.0, -8.0, 0.0], [8.0, 8.0, 40.0], BACK));
    let found = dots(&sheet(court).drawing(), BACK);
    assert!(found > 800, "{found} dots of the tower in its court");
}

/// A ring is no hull: through its hole what lies behind is seen, and its own far side is not.
#[test]
fn a_hole_is_a_hole() {
    let bars = [[-20.0, 0.0, 20.0, 8.0], [-20.0, 32.0, 20.0, 40.0], [-20.0, 8.0, -12.0, 32.0], [12.0, 8.0, 20.0, 32.0]];
    let bar = |[x0, z0, x1, z1]: [f64; 4]| Surface { wanted: false, ..boxed([x0, -3.0, z0], [x1, 3.0, z1], FRONT) };
    let mut all: Vec<Surface> = bars.map(bar).to_vec();
    all.push(Surface { wanted: false, ..boxed([-40.0, 60.0, -60.0], [60.0, 62.0, 40.0], BACK) });
    let drawing = sheet(all).drawing();
    let blue = dots(&drawing, BACK);
    assert!(blue > 4000, "{blue}");
    let svg = String::from_utf8(drawing.bytes(Format::Svg)).unwrap();
    assert!(svg.contains(">said</text>") && svg.matches("<path").count() > 10);
}

#[test]
fn where_new_meets_old_a_line_is_drawn() {
    let old = Surface { joint: Joint::Old, wanted: false, ..boxed([-20.0, -20.0, 0.0], [20.0, 20.0, 10.0], FRONT) };
    let on = |z: f64| Surface { joint: Joint::New, ..boxed([-8.0, -8.0, z], [8.0, 8.0, z + 20.0], BACK) };
    let joints = |drawing: &Drawing| {
        drawing.marks.iter().filter(|m| matches!(m, DrawnMark::Lines { colour, .. } if *colour == JOINT_COLOUR)).count()
    };
    assert!(joints(&sheet(vec![old.clone(), on(10.0)]).drawing()) > 0);
    assert_eq!(joints(&sheet(vec![old, on(16.0)]).drawing()), 0, "it hangs above it");
}

#[test]
fn names_stand_on_what_they_name_and_apart() {
    let part = |x: f64, name: &str| Surface {
        name: Some(name.to_owned()),
        ..boxed([x, 0.0, 0.0], [x + 3.0, 3.0, 30.0], FRONT)
    };
    let all = (0..8).map(|i| part(f64::from(i) * 5.0, &format!("arm number {i}"))).collect();
    let drawing = sheet(all).drawing();
    let words = |m: &DrawnMark| match m {
        DrawnMark::Text { at, text, size, halo: true, .. } if text.starts_with("arm") => {
            Some((*at, width_of(text, *size), *size))
        }
        _ => None,
    };
    let boxes: Vec<_> = drawing.marks.iter().filter_map(words).collect();
    assert!(boxes.len() >= 7, "{} names", boxes.len());
    for (i, (a, wide, high)) in boxes.iter().enumerate() {
        for (b, other, _) in &boxes[..i] {
            assert!((a[0] - b[0]).abs() >= (wide + other) / 2.0 - 1e-6 || (a[1] - b[1]).abs() >= high - 1e-6);
        }
    }
}

#[test]
fn nothing_is_a_sheet_too() {
    let empty = sheet(vec![]).drawing();
    assert!(!empty.bytes(Format::Png).is_empty());
    let none = Sheet { frames: vec![], story: vec!["why".into()], ..sheet(vec![]) };
    assert!(String::from_utf8(none.drawing().bytes(Format::Svg)).unwrap().contains(">why<"));
    let flat = Surface::new(vec![Vec3::zeros(); 3], vec![[0, 1, 2]], FRONT);
    assert!(!sheet(vec![flat]).drawing().bytes(Format::Pdf).is_empty());
}

#[test]
fn the_same_is_drawn_to_the_same_bytes() {
    let all =
        || vec![boxed([-30.0, -2.0, 0.0], [30.0, 2.0, 40.0], FRONT), boxed([-5.0, 12.0, 0.0], [5.0, 22.0, 20.0], BACK)];
    for format in [Format::Svg, Format::Png, Format::Pdf] {
        assert_eq!(sheet(all()).drawing().bytes(format), sheet(all()).drawing().bytes(format));
    }
}
