//! Meshes as files: the same bytes for the same mesh, on every machine and day.

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use quick_xml::escape::escape;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::TriangleMesh;

/// The mesh as binary STL, mm; 84 + 50 bytes a facet. An empty mesh gives the header alone.
pub fn stl_binary<F>(mesh: &TriangleMesh<F>) -> Vec<u8> {
    stl_binary_parts(&[mesh])
}

/// Several meshes in sequence as one binary STL, mm. Reading it back gives one part for each that is closed.
///
/// Coordinates are rounded to `f32`. Normals are the facets' own, zero where a facet has no area.
pub fn stl_binary_parts<F>(meshes: &[&TriangleMesh<F>]) -> Vec<u8> {
    let facets: usize = meshes.iter().map(|mesh| mesh.facets().len()).sum();
    let mut bytes = Vec::with_capacity(84 + 50 * facets);
    bytes.extend_from_slice(b"trunnion, mm");
    bytes.resize(80, b' ');
    bytes.extend((facets as u32).to_le_bytes());
    for mesh in meshes {
        for index in 0..mesh.facets().len() {
            let normal = mesh.normal(index).unwrap_or_default();
            let [a, b, c] = mesh.corners(index);
            for vector in [normal, a, b, c] {
                // Adding zero turns -0.0 into +0.0, so that equal places give equal bytes.
                vector.iter().for_each(|&value| bytes.extend((value as f32 + 0.0).to_le_bytes()));
            }
            bytes.extend([0, 0]);
        }
    }
    bytes
}

const CONTENT_TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>
"#;
const RELATIONS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
"#;

/// The meshes as 3MF, mm: one named object and one build item each, in order. Coordinates keep every bit.
pub fn threemf<F>(objects: &[(String, &TriangleMesh<F>)]) -> Vec<u8> {
    let model = model(objects);
    zipped(&package(&model))
}

/// The same as a project of PrusaSlicer's, with its `settings` (`; key = value` lines).
pub fn threemf_project<F>(objects: &[(String, &TriangleMesh<F>)], settings: &str) -> Vec<u8> {
    let model = model(objects);
    let mut entries = package(&model).to_vec();
    entries.push(("Metadata/Slic3r_PE.config", settings.as_bytes()));
    zipped(&entries)
}

fn package(model: &str) -> [(&str, &[u8]); 3] {
    [
        ("[Content_Types].xml", CONTENT_TYPES.as_bytes()),
        ("_rels/.rels", RELATIONS.as_bytes()),
        ("3D/3dmodel.model", model.as_bytes()),
    ]
}

fn model<F>(objects: &[(String, &TriangleMesh<F>)]) -> String {
    let mut text = String::from(concat!(
        r#"<?xml version="1.0" encoding="UTF-8"?>"#,
        "\n",
        r#"<model unit="millimeter" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">"#,
        "\n<resources>\n"
    ));
    for (index, (name, mesh)) in objects.iter().enumerate() {
        push_object(&mut text, index + 1, name, mesh);
    }
    text.push_str("</resources>\n<build>\n");
    for id in 1..=objects.len() {
        push(&mut text, format_args!("<item objectid=\"{id}\"/>\n"));
    }
    text.push_str("</build>\n</model>\n");
    text
}

fn push_object<F>(text: &mut String, id: usize, name: &str, mesh: &TriangleMesh<F>) {
    push(text, format_args!("<object id=\"{id}\" type=\"model\" name=\"{}\"><mesh><vertices>\n", escape(name)));
    for at in mesh.vertices() {
        push(text, format_args!("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>\n", at.x + 0.0, at.y + 0.0, at.z + 0.0));
    }
    text.push_str("</vertices><triangles>\n");
    for [a, b, c] in mesh.facets() {
        push(text, format_args!("<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>\n"));
    }
    text.push_str("</triangles></mesh></object>\n");
}

fn push(text: &mut String, what: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = text.write_fmt(what);
}

/// A zip archive of `entries` whose timestamps are all the zip format's first day.
pub(super) fn zipped(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let write = |archive: &mut ZipWriter<Cursor<Vec<u8>>>, name: &str, bytes: &[u8]| {
        archive.start_file(name, options.large_file(bytes.len() as u64 >= u64::from(u32::MAX)))?;
        archive.write_all(bytes)?;
        zip::result::ZipResult::Ok(())
    };
    for (name, bytes) in entries {
        write(&mut archive, name, bytes).expect("an archive in memory takes every entry");
    }
    archive.finish().expect("an archive in memory can be closed").into_inner()
}
