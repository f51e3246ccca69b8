//! Bytes as a model: STL, OBJ, OFF and 3MF, as they stand and mended; and as the XML within a 3MF, which no change of packed bytes reaches.

use std::borrow::Cow;
use std::io::{Cursor, Write};

use trunnion::mesh::{
    MAX_COORDINATE, ReadOptions, Repair, TriangleMesh, Unit, read_model, read_surface, stl_binary, threemf,
};

use zip::write::{SimpleFileOptions, ZipWriter};

use super::choice;

const NAMES: [&str; 5] = ["any.stl", "any.obj", "any.off", "any.3mf", "any"];
const REPAIRS: [Repair; 4] = [Repair::Off, Repair::Auto, Repair::Off, Repair::Strict];
const UNITS: [Option<Unit>; 3] = [None, Some(Unit::Millimetre), Some(Unit::Inch)];

/// From this first byte on the bytes are the model within a 3MF.
pub(crate) const XML: u8 = 192;

/// The first byte chooses name, unit and whether it is mended.
pub(super) fn mesh(data: &[u8]) {
    let Some((how, bytes)) = choice(data) else { return };
    let bytes = if how < XML { Cow::Borrowed(bytes) } else { Cow::Owned(packed(bytes)) };
    let (how, bytes) = (usize::from(how), &*bytes);
    let name = NAMES[how % NAMES.len()];
    let options = ReadOptions { unit: UNITS[how / 5 % 3], repair: REPAIRS[how / 15 % 4], ..ReadOptions::default() };
    match read_surface(bytes, name, &options) {
        Ok(surface) => whole(&surface),
        Err(error) => assert!(error.to_string().contains(name), "{error}"),
    }
    let model = match read_model(bytes, name, &options) {
        Ok(model) => model,
        Err(error) => return assert!(error.to_string().contains(name), "{error}"),
    };
    assert!(!model.parts.is_empty(), "a model without parts");
    for part in &model.parts {
        whole(&part.mesh);
        assert!(part.mesh.volume() > 0.0, "a part of {} mm3", part.mesh.volume());
    }
    assert!(model.interfaces.iter().all(|face| face.area_mm2.is_finite()), "interfaces");
    // What is written is read again.
    let all: Vec<_> = model.parts.iter().map(|part| (part.name.clone(), &part.mesh)).collect();
    let written = threemf(&all);
    read_surface(&written, "again.3mf", &ReadOptions::default()).expect("what is written is read again");
    let written = stl_binary(&model.parts[0].mesh);
    read_surface(&written, "again.stl", &ReadOptions::default()).expect("what is written is read again");
}

fn whole<F>(mesh: &TriangleMesh<F>) {
    let reach = MAX_COORDINATE * 1000.0;
    assert!(mesh.vertices().iter().flatten().all(|v| v.is_finite() && v.abs() <= reach), "a vertex beyond reach");
    let count = mesh.vertices().len() as u32;
    assert!(mesh.facets().iter().flatten().all(|&corner| corner < count), "a corner that is not there");
}

/// A 3MF whose model is `xml`.
fn packed(xml: &[u8]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    archive.start_file("3D/3dmodel.model", SimpleFileOptions::default()).expect("an entry");
    archive.write_all(xml).expect("room for it");
    archive.finish().expect("an archive").into_inner()
}
