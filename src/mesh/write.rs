//! Meshes as files: the same bytes for the same mesh, on every machine and day.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, BufWriter, Cursor, Write};

use quick_xml::escape::escape;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::TriangleMesh;
use crate::geom::Vec3;

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

/// The meshes as 3MF, mm: one named object and one build item each, in order. Coordinates keep every bit, but for vertices that are one
/// for programs which read numbers of 32 bits: those are one here, too, and facets that would name one of them twice are left out, so that
/// what is closed is closed for everybody.
pub fn threemf<F>(objects: &[(String, &TriangleMesh<F>)]) -> Vec<u8> {
    package(objects, &[])
}

/// The same as a project of PrusaSlicer's, with its `settings` (`; key = value` lines).
pub fn threemf_project<F>(objects: &[(String, &TriangleMesh<F>)], settings: &str) -> Vec<u8> {
    package(objects, &[("Metadata/Slic3r_PE.config", settings.as_bytes())])
}

fn package<F>(objects: &[(String, &TriangleMesh<F>)], more: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = Archive::new();
    archive.entry("[Content_Types].xml", CONTENT_TYPES.as_bytes());
    archive.entry("_rels/.rels", RELATIONS.as_bytes());
    let most = objects.iter().map(|(_, mesh)| mesh.vertices().len() * VERTEX + mesh.facets().len() * FACET);
    archive.streamed("3D/3dmodel.model", most.sum::<usize>() as u64, |into| model(into, objects));
    more.iter().for_each(|(name, bytes)| archive.entry(name, bytes));
    archive.finish()
}

/// Bytes that a vertex and a facet take at most: numbers are written without exponents, and 1e-308 has 308 zeros.
const VERTEX: usize = 1100;
const FACET: usize = 80;

fn model<F>(into: &mut impl Write, objects: &[(String, &TriangleMesh<F>)]) -> io::Result<()> {
    into.write_all(concat!(
        r#"<?xml version="1.0" encoding="UTF-8"?>"#,
        "\n",
        r#"<model unit="millimeter" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">"#,
        "\n<resources>\n"
    ).as_bytes())?;
    for (index, (name, mesh)) in objects.iter().enumerate() {
        object(into, index + 1, name, mesh)?;
    }
    into.write_all(b"</resources>\n<build>\n")?;
    for id in 1..=objects.len() {
        writeln!(into, "<item objectid=\"{id}\"/>")?;
    }
    into.write_all(b"</build>\n</model>\n")
}

fn object<F>(into: &mut impl Write, id: usize, name: &str, mesh: &TriangleMesh<F>) -> io::Result<()> {
    let name = as_xml_holds(name);
    writeln!(into, "<object id=\"{id}\" type=\"model\" name=\"{}\"><mesh><vertices>", escape(&*name))?;
    let (vertices, facets) = as_others_read(mesh);
    for at in vertices.iter() {
        writeln!(into, "<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", at.x + 0.0, at.y + 0.0, at.z + 0.0)?;
    }
    into.write_all(b"</vertices><triangles>\n")?;
    for [a, b, c] in facets.iter() {
        writeln!(into, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>")?;
    }
    into.write_all(b"</triangles></mesh></object>\n")
}

/// A name of characters that an attribute of XML 1.0 holds and gives back; in the place of others U+FFFD stands. Other formats hold any.
fn as_xml_holds(name: &str) -> Cow<'_, str> {
    let strange = |c: char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}');
    if name.contains(strange) { name.replace(strange, "\u{fffd}").into() } else { name.into() }
}

/// Vertices and facets without vertices that are the same as `f32`. Of such the lowest stands, by x, then y, then z, whatever their order: parts
/// that share a seam keep sharing it.
fn as_others_read<F>(mesh: &TriangleMesh<F>) -> (Cow<'_, [Vec3]>, Cow<'_, [[u32; 3]]>) {
    let key = |at: &Vec3| [at.x, at.y, at.z].map(|v| (v as f32 + 0.0).to_bits());
    let mut places: HashMap<[u32; 3], u32> = HashMap::with_capacity(mesh.vertices().len());
    let (mut vertices, mut new) = (Vec::<Vec3>::new(), Vec::with_capacity(mesh.vertices().len()));
    for at in mesh.vertices() {
        let place = *places.entry(key(at)).or_insert(vertices.len() as u32);
        match vertices.get_mut(place as usize) {
            Some(known) if (at.x, at.y, at.z) < (known.x, known.y, known.z) => *known = *at,
            Some(_) => {}
            None => vertices.push(*at),
        }
        new.push(place);
    }
    if vertices.len() == mesh.vertices().len() {
        return (Cow::Borrowed(mesh.vertices()), Cow::Borrowed(mesh.facets()));
    }
    let facets = mesh.facets().iter().map(|facet| facet.map(|vertex| new[vertex as usize]));
    let whole = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    (Cow::Owned(vertices), Cow::Owned(facets.filter(whole).collect()))
}

/// A zip archive in memory of `entries` whose timestamps are all the zip format's first day.
#[cfg(test)]
pub(super) fn zipped(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = Archive::new();
    entries.iter().for_each(|(name, bytes)| archive.entry(name, bytes));
    archive.finish()
}

/// How hard is packed, of 9: the usual 6 makes a mesh's text a seventh smaller, and takes most of the time of writing it.
const LEVEL: i64 = 2;

/// A zip archive in memory; the timestamps of all that is in it are the zip format's first day.
struct Archive(ZipWriter<Cursor<Vec<u8>>>);

impl Archive {
    fn new() -> Self {
        Self(ZipWriter::new(Cursor::new(Vec::new())))
    }

    fn entry(&mut self, name: &str, bytes: &[u8]) {
        self.streamed(name, bytes.len() as u64, |into| into.write_all(bytes));
    }

    /// An entry of `most` bytes or fewer that is packed while it is written: the text of a large mesh never stands in memory.
    fn streamed(
        &mut self,
        name: &str,
        most: u64,
        write: impl FnOnce(&mut BufWriter<&mut dyn Write>) -> io::Result<()>,
    ) {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(LEVEL))
            .last_modified_time(DateTime::default())
            .unix_permissions(0o644)
            .large_file(most >= u64::from(u32::MAX));
        self.0.start_file(name, options).expect("an archive in memory takes every entry");
        let mut into = BufWriter::with_capacity(1 << 16, &mut self.0 as &mut dyn Write);
        // Handed on, not flushed: a flush would end a block of the packed bytes.
        let written = write(&mut into).and_then(|()| Ok(into.into_inner().map(drop)?));
        written.expect("an archive in memory takes every byte");
    }

    fn finish(self) -> Vec<u8> {
        self.0.finish().expect("an archive in memory can be closed").into_inner()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Object;

    /// A tetrahedron with one corner drawn out to a sliver: two vertices a hair apart, and the two facets between them.
    #[test]
    fn vertices_that_are_one_for_others_are_one_and_it_stays_closed() {
        let corner = Vec3::new(50.0, 0.0, 0.0);
        let hair = corner - Vec3::x() * 1e-7;
        let vertices = vec![Vec3::zeros(), corner, Vec3::new(0.0, 50.0, 0.0), Vec3::new(0.0, 0.0, 50.0), hair];
        let facets = vec![[0, 2, 1], [0, 1, 4], [0, 4, 3], [1, 2, 4], [4, 2, 3], [0, 3, 2]];
        let sliver = TriangleMesh::<Object>::new(vertices, facets);
        let (vertices, facets) = as_others_read(&sliver);
        assert_eq!((vertices.len(), facets.len()), (4, 4));
        assert_eq!(vertices[1], hair, "the lowest by x");
        let mut edges: Vec<[u32; 2]> = facets.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.sort_unstable();
        assert!(edges.iter().all(|[a, b]| edges.binary_search(&[*b, *a]).is_ok()), "{edges:?}");
        // Whatever their order.
        let turned: Vec<Vec3> = sliver.vertices().iter().rev().copied().collect();
        let turned = TriangleMesh::<Object>::new(turned, sliver.facets().iter().map(|f| f.map(|v| 4 - v)).collect());
        assert!(as_others_read(&turned).0.contains(&hair) && !as_others_read(&turned).0.contains(&corner));
        // What has no such vertices keeps every bit.
        let plain = crate::fixtures::solid_box(Vec3::zeros(), Vec3::new(1.0, 2.0, 1.0 / 3.0));
        assert!(matches!(as_others_read(&plain), (Cow::Borrowed(_), Cow::Borrowed(_))));
    }
}
