//! One cube in every format and unit.

use std::fmt::Write as _;

use super::{Mesh, assert_volumes, close, cube, inside_out, model, read};
use crate::geom::Vec3;
use crate::mesh::{Fault, FilePlace, ReadOptions, Repair, Unit, read_model, read_surface, stl_binary, threemf};

fn ascii(mesh: &Mesh, end: &str) -> String {
    let mut text = format!("solid OpenSCAD_Model{end}");
    for index in 0..mesh.facets().len() {
        write!(text, "facet normal 0 0 0{end}outer loop{end}").unwrap();
        for at in mesh.corners(index) {
            write!(text, "vertex {} {} {}{end}", at.x, at.y, at.z).unwrap();
        }
        write!(text, "endloop{end}endfacet{end}").unwrap();
    }
    text + "endsolid OpenSCAD_Model" + end
}

fn obj(mesh: &Mesh) -> String {
    let mut text = String::from("g dice\n");
    mesh.vertices().iter().for_each(|at| writeln!(text, "v {} {} {}", at.x, at.y, at.z).unwrap());
    mesh.facets().iter().for_each(|f| writeln!(text, "f {} {} {}", f[0] + 1, f[1] + 1, f[2] + 1).unwrap());
    text
}

fn off(mesh: &Mesh) -> String {
    let mut text = format!("OFF\n{} {} 0\n", mesh.vertices().len(), mesh.facets().len());
    mesh.vertices().iter().for_each(|at| writeln!(text, "{} {} {}", at.x, at.y, at.z).unwrap());
    mesh.facets().iter().for_each(|f| writeln!(text, "3 {} {} {}", f[0], f[1], f[2]).unwrap());
    text
}

#[test]
fn a_cube_is_the_same_cube_in_every_format() {
    let mesh = cube([-0.5, 2.0, 0.0], 4.0, false);
    let mut solid = stl_binary(&mesh);
    solid[..17].copy_from_slice(b"solid facet world");
    let files = [
        (stl_binary(&mesh), "part-0"),
        (solid, "part-0"),
        (ascii(&mesh, "\n").into_bytes(), "part-0"),
        (ascii(&mesh, "\r\n").to_uppercase().into_bytes(), "part-0"),
        (obj(&mesh).into_bytes(), "dice"),
        (off(&mesh).into_bytes(), "part-0"),
        (threemf(&[("a <b> & \"c\"".to_owned(), &mesh)]), "a <b> & \"c\""),
        (threemf(&[("\u{1}\n\u{85}\u{ffff} ü".to_owned(), &mesh)]), "\u{fffd}\u{fffd}\u{fffd}\u{fffd} ü"),
    ];
    for (index, (bytes, name)) in files.iter().enumerate() {
        let model = read(bytes, "no extension").unwrap();
        assert!(model.warnings.is_empty(), "file {index}: {:?}", model.warnings);
        assert_volumes(&model, &[64.0]);
        let part = &model.parts[0];
        assert!(close(part.mesh.area(), 96.0));
        assert_eq!((part.id, part.name.as_str(), part.mesh.facets().len()), (0, *name, 12), "file {index}");
        assert_eq!(part.mesh.vertices().len(), 8);
        assert_eq!(model.bounds.min, Vec3::new(-0.5, 2.0, 0.0));
        assert_eq!(model.bounds.max, Vec3::new(3.5, 6.0, 4.0));
        assert_eq!((model.unit, model.on_table.as_slice()), (Unit::Millimetre, [0].as_slice()));
    }
}

#[test]
fn facets_keep_the_order_of_the_file() {
    let mesh = cube([0.0; 3], 4.0, true);
    let found = model(&[&mesh]);
    for index in 0..12 {
        assert_eq!(found.parts[0].mesh.corners(index), mesh.corners(index));
    }
}

#[test]
fn writing_is_deterministic_and_keeps_every_bit_of_3mf() {
    let mesh = cube([0.1, 0.2, 0.3], 1.0 + 1e-12, false);
    let bytes = threemf(&[("a".to_owned(), &mesh), ("a".to_owned(), &inside_out(&mesh))]);
    assert_eq!(bytes, threemf(&[("a".to_owned(), &mesh), ("a".to_owned(), &inside_out(&mesh))]));
    let model = read(&bytes, "x.3mf").unwrap();
    assert_eq!(model.parts[0].mesh.corners(7), mesh.corners(7));
    assert_eq!(model.parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>(), ["a", "a-2"]);
    assert!(model.warnings[0].contains(" facet 12 ") && model.warnings[0].ends_with("flipped"), "{:?}", model.warnings);
    assert_eq!(stl_binary(&mesh).len(), 84 + 50 * 12);
    assert_eq!(stl_binary(&mesh)[84..96], [0_f32, 0.0, -1.0].map(f32::to_le_bytes).concat());
}

#[test]
fn units_are_given_stated_or_guessed() {
    let small = stl_binary(&cube([0.0; 3], 0.036, false));
    let model = read(&small, "x.stl").unwrap();
    assert_eq!(model.unit, Unit::Metre);
    assert!((model.parts[0].mesh.volume() - 46_656.0).abs() < 1e-2);
    assert_eq!(model.warnings.len(), 1);
    assert!(
        ["metres", "36.0 mm", "--unit mm"].iter().all(|fact| model.warnings[0].contains(fact)),
        "{:?}",
        model.warnings
    );
    let inch = ReadOptions { unit: Some(Unit::Inch), repair: Repair::Off, ..ReadOptions::default() };
    let model = read_model(&small, "x.stl", &inch).unwrap();
    assert_eq!((model.unit, model.warnings.len()), (Unit::Inch, 0));
    assert!((model.bounds.max.x - 0.9144).abs() < 1e-6);
    let model = read_model(&threemf(&[("a".to_owned(), &cube([0.0; 3], 0.5, false))]), "x", &inch).unwrap();
    let [warning] = &model.warnings[..] else { panic!("{:?}", model.warnings) };
    assert!(warning.contains(" mm;") && warning.contains(" in,"), "{warning}");
    assert_eq!(model.bounds.max.x, 12.7);
    let model = read(&stl_binary(&cube([0.0; 3], 20_000.0, false)), "x.stl").unwrap();
    assert_eq!((model.unit, model.bounds.max.x), (Unit::Micron, 20.0));
}

#[test]
fn files_that_are_no_models_are_refused_with_their_name() {
    let error = read(b"", "a.stl").unwrap_err();
    assert_eq!((error.place, error.fault), (FilePlace::File, Fault::Empty));
    assert_eq!(read(b"hello", "a.txt").unwrap_err().fault, Fault::UnknownFormat);
    assert_eq!(read(&stl_binary(&Mesh::new(vec![], vec![])), "a.stl").unwrap_err().fault, Fault::NoFacets);
    assert_eq!(read(b"OFF\n0 0 0\n", "a").unwrap_err().fault, Fault::NoFacets);
    let error = read(b"solid x\nendsolid x\n", "empty.stl").unwrap_err();
    assert_eq!(error.to_string(), format!("empty.stl: {}", Fault::NoFacets));
    let cut = &stl_binary(&cube([0.0; 3], 1.0, false))[..600];
    let wanted = Fault::Truncated { have: 600, need: 684, facets: 12 };
    assert_eq!(read(cut, "a.stl").unwrap_err().fault, wanted);
}

/// The numbers of a file may not tell its corners apart: then nothing is left, and a model of no parts would be none.
#[test]
fn a_model_of_which_nothing_is_left_is_refused() {
    let point = b"OFF\n3 2 0\n1 1 1\n1 1 1\n1 1 1\n3 0 1 2\n3 0 2 1\n";
    // Two vertices nearer to each other than `--repair` tells apart, and none of its facets is left.
    let sliver = b"OFF\n6 2 0\n0 0 0\n9 0 0\n9 0 1e-7\n50 0 0\n59 0 0\n59 0 1e-7\n3 0 1 2\n3 3 4 5\n";
    for (bytes, repair) in [(&point[..], Repair::Off), (point, Repair::Auto), (sliver, Repair::Auto)] {
        let options = ReadOptions { unit: None, repair, ..ReadOptions::default() };
        let error = read_model(bytes, "x.off", &options).unwrap_err();
        assert_eq!(error.fault, Fault::Collapsed { facets: 2 }, "{error}");
    }
    let error = read_surface(point, "x.off", &ReadOptions::default()).unwrap_err();
    assert_eq!((error.file.as_str(), error.fault), ("x.off", Fault::Collapsed { facets: 2 }));
}

/// So near to nothing that its volume and what is asked of that are both 0.
#[test]
fn a_solid_of_the_smallest_numbers_is_flat() {
    let text = b"OFF\n4 4 0\n0 0 0\n1e-200 0 0\n0 1e-200 0\n0 0 1e-200\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    assert!(matches!(read(text, "x.off").unwrap_err().fault, Fault::Flat { .. }));
}

/// Cells of a tolerance so small that places far from the origin have no number of their own.
#[test]
fn what_is_tiny_and_far_from_the_origin_is_not_mended_and_does_not_overflow() {
    let far = 1e7 - 1e-8;
    let text = format!("OFF\n4 2 0\n1e7 0 0\n{far:?} 0 0\n1e7 1e-9 0\n1e7 0 1e-9\n3 0 1 2\n3 0 2 3\n");
    let options = ReadOptions { unit: None, repair: Repair::Auto, ..ReadOptions::default() };
    assert!(read_model(text.as_bytes(), "x.off", &options).is_err());
}
