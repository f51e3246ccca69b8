//! OFF: a header, counts, vertices, polygons; comments after `#`.

use std::str::SplitWhitespace;

use crate::geom::Vec3;
use crate::mesh::error::{Fault, FilePlace, Located, coordinate};
use crate::mesh::soup::{MAX_FACETS, Soup};

/// Whether `word` is a header of three-dimensional OFF; what follows the coordinates (normals, colours, texture) is
/// passed over.
pub(super) fn is_header(word: &str) -> bool {
    let kind = word.strip_suffix("OFF").map(|kind| kind.trim_start_matches("ST").trim_start_matches('C'));
    kind.is_some_and(|kind| matches!(kind, "" | "N"))
}

/// Reads vertices and fans each polygon from its first corner.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, Located> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = Lines::new(&text);
    let mut words = lines.next("the header `OFF`")?;
    let header = words.next().unwrap_or("");
    if !is_header(header.trim_start_matches('\u{feff}')) {
        return Err(syntax(header, "the header `OFF`").at(lines.place()));
    }
    if words.clone().next().is_none() {
        words = lines.next("the counts of vertices and faces")?;
    }
    let vertices = number(&mut words).map_err(|fault| fault.at(lines.place()))?;
    let faces = number(&mut words).map_err(|fault| fault.at(lines.place()))?;
    let mut soup = Soup::nameless();
    for _ in 0..vertices {
        let words = lines.next("a vertex")?;
        soup.vertices.push(vertex(words).map_err(|fault| fault.at(lines.place()))?);
    }
    for _ in 0..faces {
        let words = lines.next("a face")?;
        face(words, &mut soup).map_err(|fault| fault.at(lines.place()))?;
    }
    Ok(soup)
}

/// The lines that say something, and the number of the last one handed out.
struct Lines<'a> {
    rest: std::iter::Enumerate<std::str::Lines<'a>>,
    last: u64,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        Self { rest: text.lines().enumerate(), last: 0 }
    }

    fn next(&mut self, expected: &'static str) -> Result<SplitWhitespace<'a>, Located> {
        for (index, line) in self.rest.by_ref() {
            self.last = index as u64 + 1;
            let words = line.split('#').next().unwrap_or("").split_whitespace();
            if words.clone().next().is_some() {
                return Ok(words);
            }
        }
        Err(syntax("end of file", expected).at(self.place()))
    }

    fn place(&self) -> FilePlace {
        FilePlace::Line(self.last)
    }
}

fn syntax(found: &str, expected: &'static str) -> Fault {
    Fault::Syntax { found: found.chars().take(40).collect(), expected }
}

fn number(words: &mut SplitWhitespace<'_>) -> Result<usize, Fault> {
    let word = words.next().unwrap_or("end of line");
    word.parse().map_err(|_| syntax(word, "a count or vertex number"))
}

fn vertex(mut words: SplitWhitespace<'_>) -> Result<Vec3, Fault> {
    let mut at = Vec3::zeros();
    for axis in 0..3 {
        let word = words.next().unwrap_or("end of line");
        at[axis] = coordinate(word.parse().map_err(|_| syntax(word, "a coordinate"))?)?;
    }
    Ok(at)
}

fn face(mut words: SplitWhitespace<'_>, soup: &mut Soup) -> Result<(), Fault> {
    let count = soup.vertices.len();
    let corners = number(&mut words)?;
    let mut polygon = Vec::with_capacity(corners.min(64));
    for _ in 0..corners {
        let index = number(&mut words)?;
        if index >= count {
            return Err(Fault::IndexOutOfRange { index: index as i64, count, first: 0 });
        }
        polygon.push(index as u32);
    }
    if polygon.len() < 3 {
        return Err(syntax(&format!("{corners} corners"), "at least 3 corners a face"));
    }
    soup.push_fan(&polygon);
    if soup.facets.len() > MAX_FACETS { Err(Fault::TooManyFacets { limit: MAX_FACETS }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::{is_header, read};
    use crate::mesh::error::{Fault, FilePlace};

    const SQUARE: &str = "OFF # a square and a triangle\n\n4 2 0\n0 0 0\n1 0 0 255 0 0\n# here\n1 1 0\n0 1 0\n\
        4 0 1 2 3 1.0 0 0\n3 0 1 2\n";

    #[test]
    fn reads_comments_colours_and_quads() {
        let soup = read(SQUARE.as_bytes()).unwrap();
        assert_eq!(soup.facets, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        assert_eq!(soup.vertices[2].y, 1.0);
        let one_line = SQUARE.replace(" # a square and a triangle\n\n", " ");
        assert_eq!(read(one_line.as_bytes()).unwrap().facets, soup.facets);
    }

    #[test]
    fn knows_its_headers() {
        assert!(["OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCNOFF"].into_iter().all(is_header));
        assert!(!["4OFF", "nOFF", "off", "SOFF", "OFFICE"].into_iter().any(is_header));
    }

    #[test]
    fn names_the_line_of_what_it_cannot_read() {
        let error = read(SQUARE.replace("4 0 1 2 3", "4 0 1 2 9").as_bytes()).unwrap_err();
        assert_eq!(error.place, FilePlace::Line(9));
        assert_eq!(error.fault, Fault::IndexOutOfRange { index: 9, count: 4, first: 0 });
        let error = read(SQUARE.replace("3 0 1 2\n", "").as_bytes()).unwrap_err();
        assert_eq!(error.fault, Fault::Syntax { found: "end of file".to_owned(), expected: "a face" });
        // A hostile count reads on into the faces until the text ends, without allocating for it.
        let error = read(SQUARE.replace("4 2 0", "99999999999 2 0").as_bytes()).unwrap_err();
        assert_eq!(error.fault, Fault::Syntax { found: "end of file".to_owned(), expected: "a vertex" });
    }
}
