//! Wavefront OBJ through `tobj`.

use std::borrow::Cow;

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
    let count = lines(text).filter(|(_, _, line)| line.split_whitespace().next() == Some("v")).count();
    let mut plain = String::with_capacity(text.len());
    let mut seen = 0;
    for (number, taken, line) in lines(text) {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                seen += 1;
                plain.push('v');
                uncommented(words).take(3).for_each(|word| push_word(&mut plain, word));
            }
            Some("f") => {
                plain.push('f');
                for word in uncommented(words) {
                    let corner = corner(word, seen, count).map_err(|fault| fault.at(FilePlace::Line(number)))?;
                    push_word(&mut plain, &corner.to_string());
                }
            }
            Some("g" | "o") => plain.push_str(line.trim()),
            _ => {}
        }
        // As many as in the file, so that a line has its number.
        plain.extend(std::iter::repeat_n('\n', taken));
    }
    Ok(plain)
}

/// The file's lines, each with its number, from 1, and how many lines of the file it takes: a backslash at the end goes on in the next one.
fn lines(text: &str) -> impl Iterator<Item = (u64, usize, Cow<'_, str>)> {
    let mut rest = text.lines();
    let mut number = 1;
    std::iter::from_fn(move || {
        let (first, mut taken) = (number, 1);
        let mut line = Cow::Borrowed(rest.next()?);
        while let Some(begun) = line.trim_end().strip_suffix('\\') {
            let Some(next) = rest.next() else {
                line = Cow::Owned(begun.to_owned());
                break;
            };
            line = Cow::Owned(format!("{begun} {next}"));
            taken += 1;
        }
        number += taken as u64;
        Some((first, taken, line))
    })
}

/// The words before a comment, which may begin within one.
fn uncommented<'a>(words: impl Iterator<Item = &'a str>) -> impl Iterator<Item = &'a str> {
    let mut is_over = false;
    let parts = words.map_while(move |word| {
        let (before, comment) = word.split_once('#').map_or((word, false), |(before, _)| (before, true));
        let is_read = !is_over;
        is_over |= comment;
        is_read.then_some(before)
    });
    parts.filter(|word| !word.is_empty())
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
    fn lines_go_on_behind_a_backslash_and_end_at_a_comment() {
        let plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let wanted = read(plain.as_bytes()).unwrap();
        for other in [
            plain.replace("f 1 2", "f 1 \\\n 2 \\ \n"),
            plain.replace("f 1 2", "f \\\r\n1 2\\\r\n"),
            plain.replace("v 1 0 0", "v 1 \\\n0 0"),
            plain.replace('\n', " # side 4\n"),
            plain.replace('\n', "# side\n"),
            plain.replace('\n', "#\n"),
            plain.replace("f 1 2 3\n", "f 1 2 3 \\"),
        ] {
            let soup = read(other.as_bytes()).unwrap_or_else(|error| panic!("{other}: {error:?}"));
            assert_eq!((&soup.vertices, &soup.facets), (&wanted.vertices, &wanted.facets), "{other}");
        }
        // What is wrong is where it begins, whatever was continued before it.
        let error = read(b"v 0 0 0\nv 1 \\\n0 0\nv 0 1 0\nf 1 2 \\\n 9\n").unwrap_err();
        assert_eq!(error.place, FilePlace::Line(5));
        let error = read(b"v 0 0 0\nv 1 \\\n0 0\nv 0 x 0\nf 1 2 3\n").unwrap_err();
        assert_eq!(error.place, FilePlace::Line(4));
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
