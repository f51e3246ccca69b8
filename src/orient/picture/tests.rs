//! What the pictures show, at places where it is known.

use super::*;
use crate::fixtures::two_boxes;
use crate::geom::{Angle, Vec3};
use crate::orient::{Facets, Height, Minimum, Objective, from_angles};

fn bar() -> Facets {
    Facets::of(&crate::fixtures::solid_box(Vec3::zeros(), Vec3::new(10.0, 10.0, 60.0)))
}

#[test]
fn a_landscape_is_dark_where_the_value_is_low_and_rings_the_minima() {
    let part = bar();
    let low = Minimum { up: Vec3::y(), value: Height.value(&part, &Vec3::y()) };
    let picture = landscape(&Height, &part, &[low]);
    assert_eq!((picture.width, picture.height), (720, 360));
    let at = |alpha: f64, beta: f64| picture.pixels[(90.0 - beta) as usize * 2 * 720 + (alpha + 180.0) as usize * 2];
    let sum = |c: [u8; 3]| c.iter().map(|&c| u32::from(c)).sum::<u32>();
    // Upright it is 60 mm high, on its side 10.
    assert!(sum(at(0.0, 10.0)) > sum(at(-90.0, 30.0)) + 50);
    let red = picture.pixels.iter().filter(|p| **p == [255, 40, 40]).count();
    assert!(red > 20, "{red}");
    let ringed = (0..720 * 360).filter(|&i| picture.pixels[i] == [255, 40, 40]);
    assert!(ringed.clone().all(|i| (i % 720).abs_diff(540) < 8 && (i / 720).abs_diff(180) < 8), "at (90, 0) degrees");
    let _ = from_angles(0.0, 0.0);
}

#[test]
fn a_view_shows_overhang_and_support_where_they_are() {
    let count = |picture: &Picture, test: &dyn Fn([u8; 3]) -> bool| picture.pixels.iter().filter(|p| test(**p)).count();
    let blue = |c: [u8; 3]| c == [120, 170, 225];
    let upright = view(&bar(), &Vec3::z(), Paint::Overhangs(Angle::from_deg(45.0)));
    assert_eq!(count(&upright, &blue), 0, "a bar upright needs none");
    // The beam of the two boxes hangs 40 mm above the bed.
    let beam = Facets::of(&two_boxes().parts[1].1);
    let both = Facets::of(&{
        let (a, b) = (&two_boxes().parts[0].1, &two_boxes().parts[1].1);
        let first = a.vertices().len() as u32;
        let vertices = a.vertices().iter().chain(b.vertices()).copied().collect();
        let facets = a.facets().iter().copied().chain(b.facets().iter().map(|f| f.map(|i| i + first))).collect();
        crate::mesh::TriangleMesh::<crate::geom::Object>::new(vertices, facets)
    });
    assert_eq!(count(&view(&beam, &Vec3::z(), Paint::Overhangs(Angle::from_deg(45.0))), &blue), 0);
    let held = view(&both, &Vec3::z(), Paint::Overhangs(Angle::from_deg(45.0)));
    assert!(count(&held, &blue) > 2000, "{}", count(&held, &blue));
    let costs = vec![1.0; both.each.len()];
    let painted = view(&both, &Vec3::z(), Paint::Costs(&costs, Angle::from_deg(45.0)));
    assert!(count(&painted, &|c| c[2] > c[0].saturating_add(20)) > 5000);
}

#[test]
fn the_file_reads_back_as_the_picture() {
    let picture = view(&bar(), &Vec3::x(), Paint::Overhangs(Angle::from_deg(45.0)));
    let bytes = picture.png().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let mut read = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut read).unwrap();
    assert_eq!((info.width as usize, info.height as usize), (picture.width, picture.height));
    assert_eq!(read, picture.pixels.concat());
    assert!(Picture { width: 0, height: 0, pixels: vec![] }.png().is_err());
}

#[test]
fn an_empty_part_gives_the_empty_page() {
    let nothing = Facets::with(vec![], vec![], vec![]);
    let page = view(&nothing, &Vec3::z(), Paint::Overhangs(Angle::from_deg(45.0)));
    assert!(page.pixels.len() == 900 * 700);
    assert_eq!(landscape(&Height, &nothing, &[]).pixels.len(), 720 * 360);
}
