//! ASCII STL; any case, any line ending, several solids.

use crate::geom::Vec3;
use crate::mesh::error::{Fault, FilePlace, Located, coordinate};
use crate::mesh::soup::{Label, Soup};
use crate::mesh::weld::Welder;

/// Whether text that begins with `solid` goes on like an ASCII STL.
pub(super) fn looks_like(text: &str) -> bool {
    text.split_whitespace()
        .skip(1)
        .any(|word| ["facet", "endsolid"].iter().any(|keyword| word.eq_ignore_ascii_case(keyword)))
}

/// Reads every `vertex` between `outer loop` and `endloop`; normals are ignored.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, Located> {
    let mut reader = Reader { soup: Soup::default(), welder: Welder::new(), corners: None };
    let mut lines = 0;
    for line in bytes.split(|&byte| byte == b'\n') {
        lines += 1;
        reader.line(&String::from_utf8_lossy(line)).map_err(|fault| fault.at(FilePlace::Line(lines)))?;
    }
    if reader.corners.is_some() {
        let fault = Fault::Syntax { found: "end of file".to_owned(), expected: "`vertex` or `endloop`" };
        return Err(fault.at(FilePlace::Line(lines)));
    }
    let mut soup = reader.soup;
    soup.vertices = reader.welder.into_vertices();
    // A file's only solid bears the exporting program's name, not a part's.
    if let [only] = soup.names.as_mut_slice() {
        only.name = None;
    }
    Ok(soup)
}

struct Reader {
    soup: Soup,
    welder: Welder,
    /// The corners of the loop that is open.
    corners: Option<Vec<u32>>,
}

impl Reader {
    fn line(&mut self, line: &str) -> Result<(), Fault> {
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else { return Ok(()) };
        match (keyword.to_ascii_lowercase().as_str(), self.corners.is_some()) {
            ("vertex", true) => self.vertex(words),
            ("endloop", true) => self.close_loop(),
            ("outer", false) => {
                self.corners = Some(Vec::with_capacity(3));
                Ok(())
            }
            ("solid", false) => {
                self.name(words.collect::<Vec<_>>().join(" "));
                Ok(())
            }
            ("facet" | "endfacet" | "endsolid" | "color", false) => Ok(()),
            (_, open) => Err(Fault::Syntax {
                found: line.trim().chars().take(40).collect(),
                expected: if open { "`vertex` or `endloop`" } else { "`facet`, `outer loop` or `endsolid`" },
            }),
        }
    }

    fn name(&mut self, name: String) {
        self.soup.names.push(Label { name: (!name.is_empty()).then_some(name), ..Label::default() });
    }

    fn vertex<'a>(&mut self, mut words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        let mut at = Vec3::zeros();
        for axis in 0..3 {
            let word = words.next().unwrap_or("end of line");
            let value = word.parse::<f64>();
            let value = value.map_err(|_| Fault::Syntax { found: word.to_owned(), expected: "a number" })?;
            // Through f32, so that ASCII and binary copies of one model weld alike.
            at[axis] = coordinate(f64::from(value as f32))?;
        }
        if let Some(corners) = &mut self.corners {
            corners.push(self.welder.number(at));
        }
        Ok(())
    }

    fn close_loop(&mut self) -> Result<(), Fault> {
        let corners = self.corners.take().unwrap_or_default();
        let [a, b, c] = corners[..] else {
            return Err(Fault::Syntax { found: format!("{} corners", corners.len()), expected: "3 corners a facet" });
        };
        if self.soup.names.is_empty() {
            self.name(String::new());
        }
        self.soup.push([a, b, c]);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::read;
    use crate::mesh::error::{Fault, FilePlace};

    const ONE: &str = "SOLID Exporter 1\r\n facet normal 0 0 1\r\n  Outer Loop\r\n   vertex 0 0 0\r\n   \
        Vertex 1e0 -0 0\r\n   vertex 0 2.5 0\r\n  endloop\r\n endfacet\r\nendsolid Exporter 1\r\n";

    #[test]
    fn reads_any_case_and_line_ending() {
        let soup = read(ONE.as_bytes()).unwrap();
        assert_eq!(soup.facets, [[0, 1, 2]]);
        assert_eq!(soup.vertices[2].y, 2.5);
        assert_eq!(soup.vertices[1].y.to_bits(), 0);
        assert_eq!(soup.names[0].name, None, "one solid has no part's name");
    }

    #[test]
    fn several_solids_give_their_names() {
        let two = format!("{ONE}{}", ONE.replace("Exporter 1", "lid"));
        let soup = read(two.as_bytes()).unwrap();
        assert_eq!(soup.labels, [0, 1]);
        assert_eq!(soup.names[0].name.as_deref(), Some("Exporter 1"));
        assert_eq!(soup.names[1].name.as_deref(), Some("lid"));
    }

    #[test]
    fn names_the_line_of_what_it_cannot_read() {
        let error = read(ONE.replace("2.5", "2,5").as_bytes()).unwrap_err();
        assert_eq!(error.place, FilePlace::Line(6));
        assert_eq!(error.fault, Fault::Syntax { found: "2,5".to_owned(), expected: "a number" });
        let error = read(ONE.replace("1e0", "nan").as_bytes()).unwrap_err();
        assert_eq!(error.place, FilePlace::Line(5));
        assert!(matches!(error.fault, Fault::NotFinite { .. }));
        let error = read(ONE.replace("   vertex 0 2.5 0\r\n", "").as_bytes()).unwrap_err();
        assert_eq!(error.place, FilePlace::Line(6));
        let cut = ONE.find("endloop").unwrap();
        assert_eq!(read(&ONE.as_bytes()[..cut]).unwrap_err().place, FilePlace::Line(7));
    }
}
