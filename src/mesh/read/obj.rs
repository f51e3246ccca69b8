//! Wavefront OBJ through `tobj`.

use crate::geom::Vec3;
use crate::mesh::error::{Fault, FilePlace, Located, coordinate};
use crate::mesh::soup::{Label, MAX_FACETS, Soup};

/// The name `tobj` gives to faces before the first group.
const UNNAMED: &str = "unnamed_object";

/// Reads faces and group names; materials, normals and texture are passed over, polygons fan from corner 1.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, Located> {
    let text = String::from_utf8_lossy(bytes);
    let plain = plain(&text)?;
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    let mut rest = plain.as_bytes();
    let loaded = tobj::load_obj_buf(&mut rest, &options, |_| Err(tobj::LoadError::MaterialParseError));
    // `tobj` stops at the line that it cannot read, but does not say which one that was.
    let line = plain[..plain.len() - rest.len()].lines().count() as u64;
    let (models, _) = loaded.map_err(|error| {
        let found = plain.lines().nth(line.saturating_sub(1) as usize).unwrap_or("").chars().take(40).collect();
        Fault::Syntax { found, expected: expected(&error) }.at(FilePlace::Line(line))
    })?;
    let mut soup = Soup::default();
    for model in models {
        append(&mut soup, model).map_err(|fault| fault.at(FilePlace::Facet(soup.facets.len() as u64)))?;
    }
    Ok(soup)
}

fn expected(error: &tobj::LoadError) -> &'static str {
    match error {
        tobj::LoadError::PositionParseError | tobj::LoadError::ScalingByZeroError => "three coordinates",
        _ => "a face of at least 3 vertex numbers",
    }
}

fn append(soup: &mut Soup, model: tobj::Model) -> Result<(), Fault> {
    let first = soup.vertices.len() as u32;
    for at in model.mesh.positions.chunks_exact(3) {
        let at = [coordinate(at[0].into())?, coordinate(at[1].into())?, coordinate(at[2].into())?];
        soup.vertices.push(Vec3::from(at));
    }
    let named = !model.name.is_empty() && model.name != UNNAMED;
    soup.names.push(Label { name: named.then_some(model.name), ..Label::default() });
    for facet in model.mesh.indices.chunks_exact(3) {
        soup.push([first + facet[0], first + facet[1], first + facet[2]]);
    }
    if soup.facets.len() > MAX_FACETS { Err(Fault::TooManyFacets { limit: MAX_FACETS }) } else { Ok(()) }
}

/// The same lines with positions, faces and groups only, and faces without texture and normal numbers.
///
/// `tobj` 4.0.5 overflows on a normal number far below zero (`f 1//-9 ...`) and finds a wrong vertex number only at the
/// end of its group; here the line is still known.
fn plain(text: &str) -> Result<String, Located> {
    let count = text.lines().filter(|line| line.split_whitespace().next() == Some("v")).count();
    let mut plain = String::with_capacity(text.len());
    let mut seen = 0;
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                seen += 1;
                plain.push('v');
                words.take(3).for_each(|word| push_word(&mut plain, word));
            }
            Some("f") => {
                plain.push('f');
                for word in words {
                    let corner =
                        corner(word, seen, count).map_err(|fault| fault.at(FilePlace::Line(index as u64 + 1)))?;
                    push_word(&mut plain, &corner.to_string());
                }
            }
            Some("g" | "o") => plain.push_str(line.trim()),
            _ => {}
        }
        plain.push('\n');
    }
    Ok(plain)
}

fn push_word(text: &mut String, word: &str) {
    text.push(' ');
    text.push_str(word);
}

/// The vertex number of a corner `v/vt/vn`, counted from 1 also where the file counts back from its last vertex.
fn corner(word: &str, seen: i64, count: usize) -> Result<i64, Fault> {
    let number = word.split('/').next().unwrap_or("");
    let syntax = || Fault::Syntax { found: word.chars().take(40).collect(), expected: "a vertex number" };
    let index: i64 = number.parse().map_err(|_| syntax())?;
    let absolute = if index < 0 { index.saturating_add(seen + 1) } else { index };
    if absolute < 1 || absolute > count as i64 {
        return Err(Fault::IndexOutOfRange { index, count, first: 1 });
    }
    Ok(absolute)
}

#[cfg(test)]
mod tests {
    use super::read;
    use crate::mesh::error::{Fault, FilePlace};

    const TWO: &str = "# made by hand\r\nmtllib none.mtl\r\nv 0 0 0 1 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nvn 0 0 1\r\n\
        f 1//1 2//1 3//1 4//1\r\ng lid\r\nusemtl red\r\nf -4/7/-9 -3 -2\r\nl 1 2\r\np 1\r\n";

    #[test]
    fn fans_quads_counts_back_and_keeps_group_names() {
        let soup = read(TWO.as_bytes()).unwrap();
        let at = |facet: [u32; 3]| facet.map(|i| (soup.vertices[i as usize].x, soup.vertices[i as usize].y));
        let (a, b, c, d) = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0));
        assert_eq!(soup.facets.iter().map(|&f| at(f)).collect::<Vec<_>>(), [[a, b, c], [a, c, d], [a, b, c]]);
        assert_eq!(soup.labels, [0, 0, 1]);
        assert_eq!(soup.names[0].name, None);
        assert_eq!(soup.names[1].name.as_deref(), Some("lid"));
    }

    #[test]
    fn counts_back_from_the_vertices_read_so_far() {
        let soup = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 9 9 9\n").unwrap();
        assert_eq!(soup.facets.len(), 1);
        assert!(soup.facets[0].iter().all(|&i| soup.vertices[i as usize].x < 2.0));
    }

    #[test]
    fn names_the_line_of_what_it_cannot_read() {
        let fails = |from: &str, to: &str| read(TWO.replace(from, to).as_bytes()).unwrap_err();
        let error = fails("4//1", "5//1");
        assert_eq!(error.place, FilePlace::Line(8));
        assert_eq!(error.fault, Fault::IndexOutOfRange { index: 5, count: 4, first: 1 });
        assert_eq!(fails("-4/7", "0/7").fault, Fault::IndexOutOfRange { index: 0, count: 4, first: 1 });
        assert_eq!(fails("-4/7", "-5/7").fault, Fault::IndexOutOfRange { index: -5, count: 4, first: 1 });
        let error = fails("v 1 1 0", "v 1 x 0");
        assert_eq!(error.place, FilePlace::Line(5));
        assert_eq!(error.fault, Fault::Syntax { found: "v 1 x 0".to_owned(), expected: "three coordinates" });
        assert!(matches!(fails("v 1 1 0", "v 1 inf 0").fault, Fault::NotFinite { .. }));
        assert_eq!(fails("f 1//1 2//1 3//1 4//1", "f").place, FilePlace::Line(9));
    }
}
