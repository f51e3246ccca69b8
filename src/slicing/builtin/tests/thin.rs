//! What is thin: how much plastic it gets, in which beads, and what is said where it gets none.

use super::*;

/// The widths of lines of 1 mm and more, as their filament gives them.
fn widths(lines: &[Extrusion]) -> Vec<f64> {
    let long = lines.iter().filter(|l| l.length() >= 1.0);
    long.map(|l| l.e * FILAMENT_MM2 / l.length() / 0.2 + 0.2 * (1.0 - std::f64::consts::FRAC_PI_4)).collect()
}

#[test]
fn thin_walls_get_their_plastic_in_beads_that_a_nozzle_can_lay() {
    let wall = |thick: f64| block([150.0, 140.0, 0.0], [150.0 + thick, 160.0, 4.0]);
    for hundredths in (30..=300).step_by(5) {
        let thick = f64::from(hundredths) / 100.0;
        let settings = SliceSettings { infill: 1.0, ..SliceSettings::default() };
        let (text, lines) = sliced(&wall(thick), &settings);
        let volume = volume_mm3(&lines) / (thick * 20.0 * 4.0);
        assert!((0.93..=1.05).contains(&volume), "{thick} mm: {volume}\n{}", &text[..600]);
        let least = widths(&lines).into_iter().fold(f64::INFINITY, f64::min);
        assert!(least >= 0.299, "{thick} mm: a bead of {least} mm");
        let along = lines.iter().filter(|l| (l.to[1] - l.from[1]).abs() > 15.0 && l.to[2] < 0.3).count();
        let wanted = if thick <= 0.65 {
            Some(1)
        } else if thick <= 1.1 {
            Some(2)
        } else {
            None
        };
        assert!(wanted.is_none_or(|wanted| wanted == along), "{thick} mm: {along} beads");
    }
}

#[test]
fn a_wedge_is_filled_to_where_it_is_as_thin_as_the_narrowest_bead() {
    for deg in [5.0f64, 10.0, 20.0, 30.0, 45.0] {
        let half = 20.0 * (deg / 2.0).to_radians().tan();
        let (_, lines) = sliced(
            &prism(&[[140.0, 150.0], [160.0, 150.0 - half], [160.0, 150.0 + half]], 0.0, 2.0),
            &SliceSettings::default(),
        );
        let tip = lines.iter().flat_map(|l| [l.from[0], l.to[0]]).fold(f64::INFINITY, f64::min) - 140.0;
        // The narrowest bead is 0.3 mm wide; its walls are 0.27 mm apart there.
        let thin = 0.265 / 2.0 / (deg / 2.0).to_radians().tan();
        assert!((tip - thin).abs() < 0.3, "{deg} degrees: from {tip} mm on, thick enough from {thin} mm on");
    }
}

#[test]
fn what_is_too_thin_for_any_bead_is_told_and_too_much_of_it_refused() {
    let fin = block([160.0, 150.0, 0.0], [170.0, 150.2, 4.0]);
    let of = |base: f64| together(&[block([160.0 - base, 140.0, 0.0], [160.0, 160.0, 4.0]), fin.clone()]);
    let sliced = slice(&of(20.0), &SliceSettings::default(), &job()).unwrap();
    let [Flaw::LeftOut(left)] = &sliced.flaws[..] else { panic!("{:?}", sliced.flaws) };
    // 10 x 0.2 x 4 mm of 20 x 20 x 4 more.
    assert!((left.volume_mm3 - 8.0).abs() < 0.2 && (left.share - 8.0 / 1608.0).abs() < 2e-4, "{left:?}");
    assert!(left.layers == 20 && left.thinnest_mm < 0.27, "{left:?}");
    assert!((left.at_mm[0] - 165.0).abs() < 0.3 && (left.at_mm[1] - 150.1).abs() < 0.01, "{left:?}");
    assert!(String::from_utf8(sliced.gcode).unwrap().contains(&format!("; warning: {}", sliced.flaws[0])));
    let refused = |mesh: &TriangleMesh<Slot>| {
        slice(mesh, &SliceSettings::default(), &job()).map(|sliced| sliced.flaws).unwrap_err()
    };
    let much = refused(&of(1.5));
    let text = much.to_string();
    assert!(much.is_slicer_failure() && text.contains("(6.2") && text.contains("at most 5 % may be missing"), "{text}");
    assert!(text.contains("X 165.") && text.contains("thinner nozzle"), "{text}");
    assert!(refused(&fin).is_slicer_failure());
    // An hourglass: at its neck nothing is printed, and its head would stand on air.
    let square = |half: f64| {
        [
            [150.0 - half, 150.0 - half],
            [150.0 + half, 150.0 - half],
            [150.0 + half, 150.0 + half],
            [150.0 - half, 150.0 + half],
        ]
    };
    let glass =
        together(&[frustum(&square(2.0), &square(0.05), 0.0, 10.0), frustum(&square(0.05), &square(2.0), 10.0, 20.0)]);
    let text = refused(&glass).to_string();
    assert!(text.contains("at Z 9.80, so 4 layers"), "{text}");
    // With a head of 0.53 mm3 it ends below the neck, and that is told.
    let bottom = frustum(&square(2.0), &square(0.05), 0.0, 10.0);
    let crumb = together(&[bottom.clone(), frustum(&square(0.05), &square(0.6), 10.0, 11.0)]);
    let Sliced { gcode, flaws } = slice(&crumb, &SliceSettings::default(), &job()).unwrap();
    let [Flaw::LeftOut(left)] = &flaws[..] else { panic!("{flaws:?}") };
    let highest = extrusions(&gcode).iter().map(|line| line.to[2]).fold(0.0, f64::max);
    assert!((highest - 9.6).abs() < 1e-6 && left.layers == 4, "{highest}, {left:?}");
    // Layers with less than 0.05 mm2 are not counted.
    assert!((0.5..0.54).contains(&left.volume_mm3) && left.at_mm[2] > 10.9, "{left:?}");
    let large = together(&[bottom, frustum(&square(0.05), &square(0.8), 10.0, 11.5)]);
    assert!(refused(&large).to_string().contains("is narrower than"));
}

/// A rib that is thinner at its foot begins where it stands, and not where it is as thick as a bead; what is thin at its top ends before.
#[test]
fn a_rib_is_laid_from_its_foot_on() {
    let rib = |thick: f64| {
        [
            [142.0, 150.0 - thick / 2.0],
            [158.0, 150.0 - thick / 2.0],
            [158.0, 150.0 + thick / 2.0],
            [142.0, 150.0 + thick / 2.0],
        ]
    };
    let plate = block([135.0, 140.0, 0.0], [165.0, 160.0, 2.0]);
    // Layers by their tops, in tenths of a millimetre.
    for (foot, top, from, to) in [(0.18, 0.6, 22, 60), (0.12, 0.4, 22, 60), (0.6, 0.18, 22, 52), (0.05, 0.6, 22, 60)] {
        let mesh = together(&[plate.clone(), frustum(&rib(foot), &rib(top), 2.0, 6.0)]);
        let (_, lines) = sliced(&mesh, &SliceSettings::default());
        let along = lines.iter().filter(|l| l.from[2] > 2.1 && (l.to[0] - l.from[0]).abs() > 14.0);
        let layers: Vec<i64> = along.map(|l| (l.to[2] * 10.0).round() as i64).collect();
        assert_eq!(layers, (from..=to).step_by(2).collect::<Vec<_>>(), "{foot} mm at the foot, {top} mm at the top");
    }
}

#[test]
fn a_narrow_strip_is_filled_along_it() {
    // 1.3 mm between the walls, on a slant.
    let (sin, cos) = 20f64.to_radians().sin_cos();
    let ring = [[0.0, 0.0], [40.0, 0.0], [40.0, 3.0], [0.0, 3.0]]
        .map(|[x, y]| [130.0 + x * cos - y * sin, 140.0 + x * sin + y * cos]);
    let (_, lines) = sliced(&prism(&ring, 0.0, 2.0), &SliceSettings { infill: 1.0, ..SliceSettings::default() });
    let infill: Vec<&Extrusion> = lines.iter().filter(|l| l.kind.contains("olid infill") && l.length() > 1.0).collect();
    assert!(!infill.is_empty());
    for line in infill {
        let across = (line.to[1] - line.from[1]) * cos - (line.to[0] - line.from[0]) * sin;
        assert!(across.abs() < 0.01 * line.length(), "{:?} to {:?}", line.from, line.to);
    }
}

#[test]
fn what_lies_between_the_walls_of_a_box_is_filled_along_them() {
    // 3 mm of wall: two lines from either side, and 1.2 mm between them.
    let outer = [[120.0, 120.0], [180.0, 120.0], [180.0, 160.0], [120.0, 160.0]];
    let inner = [[123.0, 123.0], [177.0, 123.0], [177.0, 157.0], [123.0, 157.0]];
    let walls = together(&[prism(&outer, 0.0, 4.0), inside_out(&prism(&inner, 0.0, 4.0))]);
    let (_, lines) = sliced(&walls, &SliceSettings::default());
    let layers: Vec<f64> = (1..=20).map(|layer| f64::from(layer) * 0.2).collect();
    for z in layers {
        let here: Vec<&Extrusion> = lines.iter().filter(|l| (l.to[2] - z).abs() < 1e-6).collect();
        let infill = here.iter().filter(|l| l.kind.contains("olid infill")).count();
        assert!((8..=40).contains(&infill), "{infill} moves at Z {z}");
    }
    let volume = volume_mm3(&lines) / ((60.0 * 40.0 - 54.0 * 34.0) * 4.0);
    assert!((0.97..=1.01).contains(&volume), "{volume}");
}
