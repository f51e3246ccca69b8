//! How many facets a file has at the least, told before any is made.

use super::{Format, ProjectPlates, format_of, stl_binary, threemf};

/// Facets that `bytes` will have at the least, in a file called `name`; none where that cannot be told, or nothing can be read.
///
/// Polygons count as one facet each, and of a 3MF what is placed, which takes parsing it.
pub fn facets_told(bytes: &[u8], name: &str, plates: ProjectPlates) -> usize {
    match format_of(bytes, name) {
        Some(Format::StlBinary) => stl_binary::told(bytes),
        Some(Format::StlAscii) => lines_of(bytes, |word| word.eq_ignore_ascii_case(b"endloop")),
        Some(Format::Obj) => lines_of(bytes, |word| word == b"f"),
        // Its faces are what has more than three numbers: a vertex has three, or six with its colour.
        Some(Format::Off) => lines_of(bytes, |word| word == b"3" || word == b"4"),
        Some(Format::ThreeMf) => threemf::placed(bytes, plates).unwrap_or(0),
        None => 0,
    }
}

/// Lines whose first word is one of these.
fn lines_of(bytes: &[u8], is_one: impl Fn(&[u8]) -> bool) -> usize {
    let first = |line: &[u8]| {
        let line = line.trim_ascii_start();
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        is_one(&line[..end])
    };
    bytes.split(|byte| *byte == b'\n').filter(|line| first(line)).count()
}

#[cfg(test)]
mod tests {
    use super::facets_told;
    use crate::geom::{Bounds, Object, Vec3};
    use crate::mesh::{ProjectPlates, ReadOptions, TriangleMesh, read_surface, stl_binary, threemf};

    #[test]
    fn what_is_told_of_every_format_is_what_is_read() {
        let cube = TriangleMesh::<Object>::cuboid(&Bounds { min: Vec3::zeros(), max: Vec3::repeat(9.5) });
        let ascii = |facet: &[u32; 3]| {
            let corners =
                facet.map(|i| cube.vertices()[i as usize]).map(|v| format!("vertex {} {} {}\n", v.x, v.y, v.z));
            format!("facet normal 0 0 0\nouter loop\n{}EndLoop\nendfacet\n", corners.concat())
        };
        let stl: String = cube.facets().iter().map(ascii).collect();
        let vertices = |sign: &str| -> String {
            cube.vertices().iter().map(|v| format!("{sign}{} {} {}\n", v.x, v.y, v.z)).collect()
        };
        let faces = |start: &str, from: u32| -> String {
            cube.facets().iter().map(|f| format!("{start} {} {} {}\n", f[0] + from, f[1] + from, f[2] + from)).collect()
        };
        let files = [
            ("x.stl", stl_binary(&cube)),
            ("x.stl", format!("solid x\n{stl}endsolid x\n").into_bytes()),
            ("x.obj", (vertices("v ") + &faces("f", 1)).into_bytes()),
            ("x.off", format!("OFF\n{} 12 0\n{}{}", cube.vertices().len(), vertices(""), faces("3", 0)).into_bytes()),
            ("x.3mf", threemf(&[("a".to_owned(), &cube), ("b".to_owned(), &cube)])),
        ];
        for (name, bytes) in files {
            let read = read_surface(&bytes, name, &ReadOptions::default()).unwrap().facets().len();
            assert_eq!(facets_told(&bytes, name, ProjectPlates::Only), read, "{name}");
        }
        for (name, bytes) in [("x.stl", &b"torn"[..]), ("x.3mf", b"PK\x03\x04 and no archive"), ("x", b"what is this")]
        {
            assert_eq!(facets_told(bytes, name, ProjectPlates::Only), 0, "{name}");
        }
    }
}
