//! Parts that touch, hollow parts, broken parts.

use super::{Mesh, assert_volumes, close, cube, fault, inside_out, interleaved, model, read};
use crate::geom::Vec3;
use crate::mesh::{Fault, FilePlace, Model, ReadOptions, Repair, read_model, stl_binary, stl_binary_parts, threemf};

#[test]
fn cubes_that_share_a_face_stay_two_parts() {
    for other in [false, true] {
        let (left, right) = (cube([0.0; 3], 2.0, false), cube([2.0, 0.0, 0.0], 2.0, other));
        let mixed = interleaved(&[&left, &right]);
        for meshes in [vec![&left, &right], vec![&mixed]] {
            let model = model(&meshes);
            assert_volumes(&model, &[8.0, 8.0]);
            assert_eq!(model.parts[1].mesh.bounds().min, Vec3::new(2.0, 0.0, 0.0));
            let [shared] = &model.interfaces[..] else { panic!("{:?}", model.interfaces) };
            assert!((shared.a, shared.b) == (0, 1) && close(shared.area_mm2, 4.0), "{shared:?}");
            assert!((shared.normal - Vec3::x()).norm() < 1e-12);
            for (facets, part) in [(&shared.facets_a, 0), (&shared.facets_b, 1)] {
                assert_eq!(facets.len(), 2);
                assert!(
                    facets
                        .iter()
                        .all(|&(f, area)| close(area, 2.0) && close(model.parts[part].mesh.facet_area(f), 2.0))
                );
                let facing = |f: usize| model.parts[part].mesh.normal(f).unwrap().x.abs();
                assert!(facets.iter().all(|&(f, _)| facing(f) == 1.0));
            }
            assert_eq!(model.on_table, [0, 1]);
        }
    }
}

#[test]
fn cubes_that_share_an_edge_or_a_corner_stay_two_parts_without_an_interface() {
    for at in [[2.0, 2.0, 0.0], [2.0, 2.0, 2.0], [2.0, 0.0, 2.0]] {
        let (one, two) = (cube([0.0; 3], 2.0, false), cube(at, 2.0, false));
        let mixed = interleaved(&[&one, &two]);
        for meshes in [vec![&one, &two], vec![&mixed]] {
            let model = model(&meshes);
            assert_volumes(&model, &[8.0, 8.0]);
            assert_eq!(model.parts[0].mesh.bounds().max, Vec3::repeat(2.0));
            assert!(model.interfaces.is_empty());
            let floats = at[2] > 0.0;
            assert_eq!(model.floating(), if floats { vec![1] } else { vec![] });
        }
    }
}

#[test]
fn a_row_of_cubes_around_an_edge_is_told_apart_by_angle() {
    let four = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0], [2.0, 2.0]].map(|[x, y]| cube([x, y, 0.0], 2.0, x > y));
    let model = model(&[&interleaved(&four.iter().collect::<Vec<_>>())]);
    assert_volumes(&model, &[8.0; 4]);
    let pairs: Vec<_> = model.interfaces.iter().map(|one| (one.a, one.b)).collect();
    assert_eq!(pairs, [(0, 1), (0, 2), (1, 3), (2, 3)]);
    assert!(model.interfaces.iter().all(|one| close(one.area_mm2, 4.0)));
}

/// Each shares planes with each, nearly, and is printed once for every other: nobody means that, and looking at all pairs grows with their square.
#[test]
fn parts_most_of_which_overlap_are_refused() {
    let bytes = |count: usize| {
        let cubes: Vec<Mesh> = (0..count).map(|k| cube([0.01 * k as f64; 3], 20.0, false)).collect();
        stl_binary_parts(&cubes.iter().collect::<Vec<_>>())
    };
    assert_eq!(read(&bytes(120), "x.stl").unwrap().parts.len(), 120);
    let refused = read(&bytes(400), "x.stl").unwrap_err();
    assert_eq!((refused.place, refused.fault), (FilePlace::File, Fault::Crowded { parts: 400, most: 50_000 }));
}

/// Turned about the y axis.
fn turned(mesh: &Mesh, degrees: f64) -> Mesh {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let turn = |v: &Vec3| Vec3::new(cos * v.x - sin * v.z, v.y, sin * v.x + cos * v.z);
    Mesh::new(mesh.vertices().iter().map(turn).collect(), mesh.facets().to_vec())
}

#[test]
fn a_closed_interface_gets_no_direction_out_of_rounding() {
    let inner = cube([3.1; 3], 4.3, false);
    let meshes = [&cube([0.0; 3], 10.0, false), &inside_out(&inner), &inner].map(|mesh| turned(mesh, 17.0));
    let model = model(&meshes.iter().collect::<Vec<_>>());
    assert!((model.interfaces[0].area_mm2 - 6.0 * 4.3 * 4.3).abs() < 1e-3);
    assert_eq!(model.interfaces[0].normal, Vec3::zeros());
}

fn stacked(gap: f64) -> Model {
    model(&[&cube([0.0; 3], 4.0, false), &cube([1.0, 1.0, 4.0 + gap], 2.0, true)])
}

#[test]
fn interfaces_end_at_the_gap() {
    for gap in [0.0, 0.0499, -0.0499] {
        let model = stacked(gap);
        assert!((model.interfaces[0].area_mm2 - 4.0).abs() < 1e-6, "{gap}");
        assert_eq!(model.interfaces[0].normal, Vec3::z());
        assert_eq!((model.on_table.as_slice(), model.floating()), ([0].as_slice(), vec![]));
    }
    for gap in [0.0501, -0.0501] {
        assert!(stacked(gap).interfaces.is_empty(), "{gap}");
        assert_eq!(stacked(gap).floating(), [1]);
    }
}

/// As every slicer fills them: by how often shells wind around a place.
#[test]
fn what_faces_outward_within_material_is_printed_solid() {
    let outer = cube([0.0; 3], 10.0, false);
    let within = |from: f64, size: f64| cube([from; 3], size, false);
    let filled = model(&[&outer, &within(3.0, 4.0)]);
    assert_volumes(&filled, &[1000.0]);
    assert_eq!(filled.parts[0].mesh.facets().len(), 12);
    let [warning] = &filled.warnings[..] else { panic!("{:?}", filled.warnings) };
    assert!(["within material", " facet 12 ", "12 facets"].iter().all(|fact| warning.contains(fact)), "{warning}");
    // A cavity in what is in there leaves material around it once; one more leaves none, and what stands in that is a part.
    let (twice, once) = (within(1.0, 8.0), inside_out(&within(2.0, 6.0)));
    assert_volumes(&model(&[&outer, &twice, &once]), &[1000.0]);
    let hollow = model(&[&inside_out(&within(3.0, 4.0)), &outer, &once, &twice]);
    assert_volumes(&hollow, &[936.0]);
    assert_volumes(&model(&[&inside_out(&within(3.0, 4.0)), &outer, &once, &twice, &within(4.0, 1.0)]), &[936.0, 1.0]);
    // All of it inside out is the same.
    let all = [&outer, &twice, &once].map(inside_out);
    assert_volumes(&model(&all.iter().collect::<Vec<_>>()), &[1000.0]);
}

#[test]
fn interfaces_end_at_the_angle() {
    let shared = |degrees: f64| {
        let top = turned(&cube([-1.0, -1.0, 0.0], 2.0, false), degrees);
        let top = Mesh::new(top.vertices().iter().map(|v| v + Vec3::z() * 4.0).collect(), top.facets().to_vec());
        model(&[&cube([-2.0, -2.0, 0.0], 4.0, false), &top]).interfaces.iter().map(|one| one.area_mm2).sum::<f64>()
    };
    assert!((shared(1.9) - 4.0 * 1.9_f64.to_radians().cos()).abs() < 1e-5);
    assert_eq!(shared(2.1), 0.0);
}

#[test]
fn a_shell_within_a_part_is_its_cavity() {
    let (outer, inner) = (cube([0.0; 3], 10.0, false), cube([3.0; 3], 4.0, false));
    let hollow = model(&[&outer, &inside_out(&inner)]);
    assert_volumes(&hollow, &[936.0]);
    assert!(hollow.warnings.is_empty());
    assert_eq!(hollow.parts[0].mesh.facets().len(), 24);
    let flipped = model(&[&inside_out(&outer), &inner]);
    assert_volumes(&flipped, &[936.0]);
    let [part, cavity] = &flipped.warnings[..] else { panic!("{:?}", flipped.warnings) };
    assert!(["part", " facet 0 ", "flipped"].iter().all(|fact| part.contains(fact)), "{part}");
    assert!(["cavity", " facet 12 ", "flipped"].iter().all(|fact| cavity.contains(fact)), "{cavity}");
    let before = model(&[&inside_out(&inner), &outer]);
    assert_volumes(&before, &[936.0]);
    let nested = model(&[&outer, &inside_out(&inner), &cube([4.0; 3], 2.0, false)]);
    assert_volumes(&nested, &[936.0, 8.0]);
    assert_eq!((nested.captive.as_slice(), nested.floating()), ([1].as_slice(), vec![]));
    let filled = model(&[&outer, &inside_out(&inner), &inner]);
    assert_volumes(&filled, &[936.0, 64.0]);
    assert!(close(filled.interfaces[0].area_mm2, 96.0));
    assert_eq!(filled.interfaces[0].normal, Vec3::zeros(), "closed all round");
    let hole = inside_out(&cube([4.0; 3], 1.0, false));
    let deeper = model(&[&outer, &hole, &inside_out(&cube([2.0; 3], 6.0, false)), &inner]);
    assert_volumes(&deeper, &[784.0, 63.0]);
    assert_eq!(deeper.parts[1].mesh.corners(0), hole.corners(0), "a cavity is its smallest surrounding's");
    let late = model(&[&inside_out(&inner), &cube([20.0, 0.0, 0.0], 2.0, false), &outer]);
    assert_volumes(&late, &[936.0, 8.0]);
    let beside = model(&[&outer, &cube([13.0, 3.0, 3.0], 4.0, false)]);
    assert_volumes(&beside, &[1000.0, 64.0]);
}

#[test]
fn objects_of_a_3mf_stay_parts_wherever_they_lie() {
    let (outer, inner) = (cube([0.0; 3], 10.0, false), cube([3.0; 3], 4.0, false));
    let model = read(&threemf(&[("b".to_owned(), &outer), ("a".to_owned(), &inner)]), "x.3mf").unwrap();
    assert_volumes(&model, &[1000.0, 64.0]);
    assert_eq!(model.parts[1].name, "a");
    let wanted = "parts 0 (b) and 1 (a) overlap, and what both fill would be printed twice; cut one from the other";
    assert_eq!(model.warnings, [wanted]);
}

#[test]
fn parts_that_reach_into_each_other_are_warned_about() {
    let other = |x: f64| model(&[&cube([0.0; 3], 4.0, false), &cube([x, 0.5, 0.0], 4.0, false)]);
    for (x, count) in [(0.5, 1), (3.7, 1), (3.95, 0), (4.0, 0), (-4.0, 0)] {
        assert_eq!(other(x).warnings.len(), count, "{x}: {:?}", other(x).warnings);
    }
    let plate = Mesh::new(
        cube([0.0; 3], 4.0, false).vertices().iter().map(|v| Vec3::new(v.x, v.y, 4.0 + v.z * 0.02)).collect(),
        cube([0.0; 3], 4.0, false).facets().to_vec(),
    );
    let thin = model(&[&turned(&cube([0.0; 3], 4.0, false), 30.0), &turned(&plate, 30.0)]);
    assert!(!thin.warnings.iter().any(|text| text.contains("overlap")), "{:?}", thin.warnings);
    let twice = cube([0.0; 3], 4.0, false);
    assert_eq!(model(&[&twice, &twice]).warnings.len(), 1, "the same cube twice");
}

#[test]
fn an_inside_out_cube_is_turned_over() {
    let model = model(&[&inside_out(&cube([0.0; 3], 4.0, false))]);
    assert_volumes(&model, &[64.0]);
    let [warning] = &model.warnings[..] else { panic!("{:?}", model.warnings) };
    assert!(["part", " facet 0 ", "flipped"].iter().all(|fact| warning.contains(fact)), "{warning}");
}

#[test]
fn a_cube_with_a_facet_missing_is_refused_and_mended() {
    let whole = cube([0.0; 3], 2.0, false);
    let open = Mesh::new(whole.vertices().to_vec(), whole.facets()[1..].to_vec());
    let bytes = stl_binary_parts(&[&cube([5.0, 0.0, 0.0], 2.0, false), &open]);
    let error = read(&bytes, "x.stl").unwrap_err();
    assert_eq!(error.place, FilePlace::Part(1));
    assert!(matches!(error.fault, Fault::Open { edges: 3, .. }), "{error}");
    let text = error.to_string();
    assert!(text.starts_with("x.stl: part 1: ") && text.ends_with("--repair off"), "{text}");
    let mended =
        read_model(&bytes, "x.stl", &ReadOptions { unit: None, repair: Repair::Auto, ..ReadOptions::default() })
            .unwrap();
    assert_volumes(&mended, &[8.0, 8.0]);
    let [warning] = &mended.warnings[..] else { panic!("{:?}", mended.warnings) };
    assert!(["repair: 1 hole", "1 facet", "near"].iter().all(|fact| warning.contains(fact)), "{warning}");
}

#[test]
fn a_cube_with_a_facet_turned_over_is_refused_and_mended() {
    let mut facets = cube([0.0; 3], 2.0, false).facets().to_vec();
    facets[0].swap(0, 1);
    let twisted = Mesh::new(cube([0.0; 3], 2.0, false).vertices().to_vec(), facets);
    assert_eq!(fault(&[&twisted]), Fault::Winding { edges: 3, remedy: "leave out --repair off" });
    let repair = ReadOptions { unit: None, repair: Repair::Auto, ..ReadOptions::default() };
    let mended = read_model(&stl_binary(&twisted), "x.stl", &repair).unwrap();
    assert_volumes(&mended, &[8.0]);
}

#[test]
fn a_sheet_folded_flat_is_refused() {
    let flat = cube([0.0; 3], 2.0, false);
    let flat =
        Mesh::new(flat.vertices().iter().map(|v| Vec3::new(v.x, v.y, v.z * 1e-9)).collect(), flat.facets().to_vec());
    assert!(matches!(fault(&[&flat]), Fault::Flat { .. }));
    let thin =
        Mesh::new(flat.vertices().iter().map(|v| Vec3::new(v.x, v.y, v.z * 1e6)).collect(), flat.facets().to_vec());
    assert_volumes(&model(&[&thin]), &[4.0 * f64::from(2e-3_f32)]);
}

#[test]
fn a_tip_on_the_table_counts_where_nothing_else_holds_it() {
    let vertices = vec![Vec3::zeros(), Vec3::new(4.0, 0.0, 4.0), Vec3::new(0.0, 4.0, 4.0), Vec3::new(-4.0, -4.0, 4.0)];
    let tip = Mesh::new(vertices, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    let alone = model(&[&tip]);
    assert_eq!(alone.on_table, [0]);
    let [warning] = &alone.warnings[..] else { panic!("{:?}", alone.warnings) };
    assert!(warning.starts_with("part 0 ") && warning.contains(" 0 mm2"), "{warning}");
    // All of it lies within the gap, but no face of it lies down.
    let tiny = Mesh::new(tip.vertices().iter().map(|v| v * 0.01).collect(), tip.facets().to_vec());
    assert_eq!(Model::from_parts(vec![("tiny".to_owned(), tiny)]).warnings.len(), 1);
    // Held at its top by a table-high neighbour's underside, the tip carries nothing.
    let (leg, lid) = (cube([10.0, 0.0, 0.0], 4.0, false), cube([-4.0, -4.0, 4.0], 18.0, false));
    let held = model(&[&tip, &leg, &lid]);
    assert_eq!((held.on_table.as_slice(), held.warnings.len()), ([1].as_slice(), 0));
    assert!(held.floating().is_empty());
}

/// Shells of one group of an OBJ all have its name: whoever tries all numbers anew for each takes minutes for some ten thousand.
#[test]
fn parts_of_one_name_are_numbered() {
    let at = |i: usize| cube([5.0 * i as f64, 0.0, 0.0], 2.0, false);
    let named = ["a", "a", "a-2", "a", "b", "a-2"].map(str::to_owned);
    let parts = named.into_iter().enumerate().map(|(i, name)| (name, at(i))).collect();
    let names: Vec<String> = Model::from_parts(parts).parts.into_iter().map(|part| part.name).collect();
    assert_eq!(names, ["a", "a-2", "a-2-2", "a-3", "b", "a-2-3"]);
}

fn moved(mesh: &Mesh, by: Vec3) -> Mesh {
    Mesh::new(mesh.vertices().iter().map(|v| v + by).collect(), mesh.facets().to_vec())
}

/// Of a cube and what is around it, which parts are captive and which float.
fn caught(around: &[Mesh]) -> [Vec<usize>; 2] {
    let inner = cube([3.0, 3.0, 3.0], 4.0, false);
    let all: Vec<&Mesh> = std::iter::once(&inner).chain(around).collect();
    let model = model(&all);
    [model.captive.clone(), model.floating()]
}

#[test]
fn what_no_straight_way_leads_out_of_is_captive() {
    let slab = |low: [f64; 3], high: [f64; 3]| {
        let size = Vec3::from(high) - Vec3::from(low);
        let unit = cube([0.0; 3], 1.0, false);
        let place = |v: &Vec3| Vec3::from(low) + v.component_mul(&size);
        Mesh::new(unit.vertices().iter().map(place).collect(), unit.facets().to_vec())
    };
    // Plates 0.5 mm from the cube, each one part, in contact with their neighbours.
    let floor = slab([0.0, 0.0, 0.0], [10.0, 10.0, 2.5]);
    let roof = slab([0.0, 0.0, 7.5], [10.0, 10.0, 10.0]);
    let left = slab([0.0, 0.0, 2.5], [2.5, 10.0, 7.5]);
    let right = slab([7.5, 0.0, 2.5], [10.0, 10.0, 7.5]);
    let front = slab([2.5, 0.0, 2.5], [7.5, 2.5, 7.5]);
    let back = slab([2.5, 7.5, 2.5], [7.5, 10.0, 7.5]);
    let all = [floor, roof, left, right, front, back];
    let without = |gone: &[usize]| -> Vec<Mesh> {
        all.iter().enumerate().filter(|(i, _)| !gone.contains(i)).map(|(_, mesh)| mesh.clone()).collect()
    };
    assert_eq!(caught(&without(&[])), [vec![0], vec![]]);
    // One way out, and it lies: an axle in its bore, with the far end closed or open.
    assert_eq!(caught(&without(&[5])), [vec![0], vec![]]);
    assert_eq!(caught(&without(&[4, 5])), [vec![0], vec![]]);
    // Upward, or to two sides: it can be put there later, and where it is to be is not known.
    assert_eq!(caught(&without(&[1])), [vec![], vec![0]]);
    assert_eq!(caught(&without(&[3, 5])), [vec![], vec![0]]);
    // A hollow cube and what rattles in it, above a plate: each is caught in the other, and both come off upward.
    let cell: Vec<Mesh> = all.iter().map(|mesh| moved(mesh, Vec3::z() * 0.3)).collect();
    let plate = slab([-20.0, -20.0, -0.2], [30.0, 30.0, 0.0]);
    let [captive, floating] = caught(&cell.iter().cloned().chain([plate]).collect::<Vec<_>>());
    assert_eq!((captive.len(), floating.len()), (0, 7), "{captive:?} {floating:?}");
    // With nothing that stands, nothing is printed in place.
    let foot = slab([50.0, 50.0, 0.0], [60.0, 60.0, 2.0]);
    let [captive, floating] = caught(&cell.into_iter().chain([foot]).collect::<Vec<_>>());
    assert_eq!((captive.len(), floating.len()), (0, 7), "{captive:?} {floating:?}");
}

#[test]
fn where_nothing_may_be_repaired_what_would_be_is_refused() {
    let whole = cube([0.0; 3], 10.0, false);
    let strict = ReadOptions { repair: Repair::Strict, ..ReadOptions::default() };
    let of = |meshes: &[&Mesh]| read_model(&stl_binary_parts(meshes), "x.stl", &strict);
    assert!(of(&[&whole]).unwrap().warnings.is_empty());
    let open = Mesh::new(whole.vertices().to_vec(), whole.facets()[1..].to_vec());
    for (damaged, word) in [(&open, "1 hole"), (&inside_out(&whole), "flipped")] {
        let error = of(&[damaged]).unwrap_err();
        let Fault::Mended { first, others: 0 } = &error.fault else { panic!("{error}") };
        assert!(first.contains(word), "{first}");
    }
    // The doubled cube and the hole of another are two repairs.
    let far = cube([20.0, 0.0, 0.0], 10.0, false);
    let far = Mesh::new(far.vertices().to_vec(), far.facets()[1..].to_vec());
    assert!(matches!(of(&[&whole, &whole, &far]).unwrap_err().fault, Fault::Mended { others: 1, .. }));
}
