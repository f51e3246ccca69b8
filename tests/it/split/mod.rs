//! `split`: one solid becomes parts that print without supports, with no more cuts than are known to do, and every claim is held
//! against something that shares no code with the search: closed forms, an exhaustive search, the layers of the parts.

mod again;
mod brute;
mod command;
mod free_form;
mod layered;
mod layers;
mod pinned;
mod planes;
mod real_meshes;
mod refined;
pub(crate) mod solids;

use trunnion::fixtures::slivered;
use trunnion::geom::{Angle, Object, Vec3};
use trunnion::mesh::{Model, TriangleMesh};
use trunnion::planning::{OnePrint, centred};
use trunnion::profile::{Profile, resolve, shipped};
use trunnion::split::{CutOptions, NoHead, Split, split};

pub(crate) fn machine() -> Profile {
    let (file, text) = shipped("generic-ac").unwrap();
    resolve(file, text).unwrap().0
}

/// The solid cut for the generic machine.
pub(crate) fn cut(model: &TriangleMesh<Object>, options: &CutOptions) -> Split {
    let profile = machine();
    let whole = Model::from_parts(vec![("solid".to_owned(), model.clone())]);
    let placement = centred(&whole, &profile).unwrap();
    let mut head = OnePrint::new(&profile, placement, options.overhang, 0.5);
    head.pedestal_mm = options.pedestal_mm;
    split(model, &head, options, &mut |_| true)
}

/// Facets that look down by more than 45 degrees and do not lie on z = 0, by nobody's code but this.
fn needs_mm2(model: &TriangleMesh<Object>) -> f64 {
    let steep = -(std::f64::consts::FRAC_1_SQRT_2 + 1e-6);
    let hangs = |f: &usize| {
        let table = model.corners(*f).iter().all(|p| p.z.abs() < 0.05);
        !table && model.normal(*f).is_some_and(|n| n.z < steep)
    };
    (0..model.facets().len()).filter(hangs).map(|f| model.facet_area(f)).sum()
}

#[test]
fn the_solids_are_what_their_closed_forms_say() {
    let near = |got: f64, wanted: f64| assert!((got - wanted).abs() < 1e-9 * wanted, "{got} for {wanted}");
    near(solids::tee().mesh().volume(), 10.0 * 10.0 * 40.0 + 60.0 * 10.0 * 10.0);
    near(solids::tee().mesh().area(), 4200.0);
    near(solids::hook().mesh().volume(), 9600.0 + 6400.0 + 3500.0 + 2000.0);
    near(solids::bridge().mesh().volume(), 24000.0 - 12000.0);
    // A regular prism of 64 sides: n r^2 h sin(2 pi / n) / 2.
    let prism = |r: f64, h: f64| 32.0 * r * r * h * (std::f64::consts::TAU / 64.0).sin();
    near(solids::rod(15.0, 80.0, 64).mesh().volume(), prism(15.0, 80.0));
    let (wye, pipe) = (solids::wye().mesh().volume(), solids::wye_pipe().mesh().volume());
    assert!(prism(15.0, 80.0) < wye && wye < prism(15.0, 140.0) && pipe < 0.5 * wye, "{wye} {pipe}");
    for solid in solids::all() {
        let model = solid.shape.mesh();
        let got = needs_mm2(&model);
        let off = if solid.name == "menorah" { 0.005 } else { 0.001 };
        assert!((got - solid.needs_mm2).abs() < off * solid.needs_mm2, "{}: {got} for {}", solid.name, solid.needs_mm2);
        let whole = Model::from_parts(vec![(solid.name.to_owned(), model)]);
        assert_eq!(whole.parts.len(), 1);
    }
}

/// What every result must be, whatever it needed.
#[track_caller]
fn is_sound(name: &str, model: &TriangleMesh<Object>, found: &Split) {
    let volume: f64 = found.parts.iter().map(|part| part.mesh.volume()).sum();
    assert!((volume - model.volume()).abs() < 1e-9 * model.volume(), "{name}: {volume} for {}", model.volume());
    let outer: f64 = found.parts.iter().map(|part| part.mesh.area()).sum::<f64>() - 2.0 * found.seam_mm2();
    assert!((outer - model.area()).abs() < 1e-6 * model.area(), "{name}: {outer} for {}", model.area());
    let before = needs_mm2(model);
    assert!((found.before.area_mm2 - before).abs() < 1e-6 * before, "{name}: {:?} for {before}", found.before);
    let cut: Vec<usize> = found.cuts.iter().flat_map(|c| c.parts.iter().copied()).collect();
    let base = (0..found.parts.len()).filter(|&p| found.parts[p].cut.is_none()).count();
    assert_eq!(cut.len() + base, found.parts.len(), "{name}");
    for cut in &found.cuts {
        for &part in &cut.parts {
            let low =
                found.parts[part].mesh.vertices().iter().map(|v| cut.plane.height(v)).fold(f64::INFINITY, f64::min);
            assert!(low > -1e-3, "{name}: part {part} reaches {low} below its plane");
        }
    }
}

fn needs_no_more_cuts_than_are_known_to_do(solid: &solids::Solid) {
    let model = solid.shape.mesh();
    let found = cut(&model, &CutOptions::default());
    is_sound(solid.name, &model, &found);
    assert!(found.printable, "{}: {:?} left, {:?}", solid.name, found.after, found.refused);
    assert!(found.cuts.len() <= solid.cuts, "{}: {} cuts for {}", solid.name, found.cuts.len(), solid.cuts);
    assert!(found.after.area_mm2 <= solid.left_mm2 && found.after.beginnings + found.after.ridges == 0);
}

/// These take half a minute each.
const LONG: [&str; 2] = ["bracket", "menorah"];

#[test]
fn the_solids_need_no_more_cuts_than_are_known_to_do() {
    solids::all().iter().filter(|s| !LONG.contains(&s.name)).for_each(needs_no_more_cuts_than_are_known_to_do);
}

#[test]
fn a_bracket_needs_a_wider_beam_and_no_more_cuts_than_are_known_to_do() {
    solids::all().iter().filter(|s| s.name == LONG[0]).for_each(needs_no_more_cuts_than_are_known_to_do);
}

#[test]
fn a_menorah_needs_no_more_cuts_than_are_known_to_do() {
    solids::all().iter().filter(|s| s.name == LONG[1]).for_each(needs_no_more_cuts_than_are_known_to_do);
}

#[test]
fn files_with_facets_without_area_are_cut_as_well() {
    for (seed, solid) in (1..).zip(solids::all().iter().filter(|s| !LONG.contains(&s.name))) {
        for count in [1, 40] {
            let model = slivered(&solid.shape.mesh(), seed, count);
            let found = cut(&model, &CutOptions::default());
            is_sound(solid.name, &model, &found);
            assert!(found.printable, "{}: {:?} left, {:?}", solid.name, found.after, found.refused);
            assert!(found.cuts.len() <= solid.cuts, "{}: {} cuts for {}", solid.name, found.cuts.len(), solid.cuts);
        }
    }
}

#[test]
fn strict_cuts_take_everything_beyond() {
    let model = solids::tee().mesh();
    let found = cut(&model, &CutOptions { strict: true, ..CutOptions::default() });
    is_sound("tee", &model, &found);
    assert!(found.printable && found.cuts.len() == 2, "{} cuts", found.cuts.len());
    // Nothing of what is left after a cut lies beyond it.
    for (k, made) in found.cuts.iter().enumerate() {
        let later = found.parts.iter().filter(|part| part.cut.is_none_or(|c| c > k));
        let highest = later.flat_map(|p| p.mesh.vertices()).map(|v| made.plane.height(v)).fold(f64::MIN, f64::max);
        assert!(highest < 1e-3, "cut {k} leaves something {highest} mm beyond");
    }
}

#[test]
fn what_helps_no_plane_is_not_called_printable() {
    let model = solids::bridge().mesh();
    let none = NoHead { most_tilt: std::f64::consts::FRAC_PI_2 };
    // Lying on its side it would do, but it stands: the ceiling is 40 mm wide, and both its ends are held.
    let found = split(&model, &none, &CutOptions { max_cuts: 0, ..CutOptions::default() }, &mut |_| true);
    assert!(
        !found.printable && found.cuts.is_empty() && (found.after.area_mm2 - 400.0).abs() < 1e-6,
        "{:?}",
        found.after
    );
    assert_eq!(found.left.len(), 1);
    assert!((found.left[0].at - Vec3::new(0.0, 0.0, 30.0)).norm() < 1e-6, "{:?}", found.left);
    // A closed cavity's ceiling stays where it is, whatever is cut.
    let steep = CutOptions { overhang: Angle::from_deg(45.0), max_cuts: 2, ..CutOptions::default() };
    let whole = solids::block(20.0, 20.0, 20.0);
    assert!(cut(&whole.mesh(), &steep).printable && cut(&whole.mesh(), &steep).cuts.is_empty());
}

/// By its facets a ball whose underside is flattened a little hangs all around its foot; its layers, as `prepare` looks at them, only droop.
#[test]
fn what_prints_as_it_is_by_its_layers_is_not_cut() {
    let shape = solids::turned(
        &(0..=24)
            .map(|k| f64::from(k) * std::f64::consts::PI / 24.0)
            .map(|t| [20.0 * t.sin(), 19.0 - 20.0 * t.cos()])
            .filter(|[r, z]| *z > 0.0 && *r > 1.0)
            .fold(vec![[6.2, 0.0]], |mut all, point| {
                all.push(point);
                all
            }),
        64,
    );
    let model = shape.mesh();
    assert!(needs_mm2(&model) > 50.0, "{}", needs_mm2(&model));
    let found = cut(&model, &CutOptions::default());
    assert!(found.printable && found.cuts.is_empty() && found.after.area_mm2 == 0.0, "{:?}", found.after);
}

#[test]
fn a_pedestal_is_a_part_of_its_own_below_the_model() {
    let model = solids::hook().mesh();
    let found = cut(&model, &CutOptions { pedestal_mm: 12.5, ..CutOptions::default() });
    assert!(found.printable && found.parts[0].pedestal && found.piece(0) == "pedestal");
    let foot = &found.parts[0].mesh;
    assert!((foot.volume() - 1600.0 * 12.5).abs() < 1e-6, "{}", foot.volume());
    assert!((foot.bounds().min.z + 12.5).abs() < 1e-12 && foot.bounds().max.z.abs() < 1e-12);
}

#[test]
fn no_seam_comes_where_none_is_wanted() {
    let model = solids::hook().mesh();
    let plain = cut(&model, &CutOptions::default());
    let seam = plain.cuts[0].plane;
    // The post, where the plain cut passes: a box about its middle there.
    let z = seam.offset_mm / seam.normal.z;
    let (low, high) = (Vec3::new(-6.0, -6.0, z - 6.0), Vec3::new(6.0, 6.0, z + 6.0));
    let kept = trunnion::geom::Bounds { min: low, max: high };
    let found = cut(&model, &CutOptions { no_cut: vec![kept], ..CutOptions::default() });
    for made in &found.cuts {
        let on_seam = |p: &Vec3| made.plane.height(p).abs() < 1e-3 && kept.holds(p);
        let parts = found.parts.iter().filter(|part| part.cut.is_some());
        assert!(!parts.flat_map(|p| p.mesh.vertices()).any(on_seam), "a seam through the box: {:?}", made.plane);
    }
    assert!(found.cuts.first().is_none_or(|c| c.plane != seam));
}
