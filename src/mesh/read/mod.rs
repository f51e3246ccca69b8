//! Model files, recognised by content first and by name second.

mod attributes;
mod meter;
mod obj;
mod off;
mod plates;
mod roles;
mod stl_ascii;
mod stl_binary;
mod strangers;
mod threemf;
mod threemf_package;
mod threemf_xml;
mod told;

pub use plates::ProjectPlates;
pub use told::facets_told;

use super::error::{Fault, FilePlace, Located, MeshError};
use super::soup::Soup;
use super::{DrawnModel, Model, TriangleMesh, Unit, guess_unit};
use crate::geom::{Bounds, Object};

/// How to read a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The unit of the file's coordinates; `None` takes the file's word, or else guesses by size.
    pub unit: Option<Unit>,
    /// What becomes of surfaces that are no sound solids.
    pub repair: Repair,
    /// Which plates of a project.
    pub plates: ProjectPlates,
}

/// What becomes of surfaces that are no sound solids.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Repair {
    /// What is open or inconsistently wound is refused. What slicers pass over without a word (facets without area, solids that face
    /// inward) is passed over, with a warning.
    #[default]
    Off,
    /// What can be mended for sure is mended, with a warning.
    Auto,
    /// Whatever would be mended, flipped or removed is refused.
    Strict,
}

impl Repair {
    /// The way that is called so on the command line: `auto`, `strict` or `off`.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "auto" => Some(Self::Auto),
            "strict" => Some(Self::Strict),
            "off" => Some(Self::Off),
            _ => None,
        }
    }
}

/// Reads a model: its closed parts, what they share, and what stands on the table, in mm.
///
/// `bytes` is the file's content and `name` its name, for the messages and for the extension where the content does
/// not tell the format. Binary STL is known by its length alone, since many writers begin its header with `solid`.
/// Parts keep the order of their first facets in the file.
///
/// # Errors
///
/// A [`MeshError`] with the file's name, the place and the remedy for a file that cannot be parsed, holds no facets,
/// numbers that are not finite or out of range, or a surface that is open, inconsistently wound or flat.
pub fn read_model(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<Model, MeshError> {
    let DrawnModel { model, away, .. } = read_project(bytes, name, options)?;
    match away.first() {
        None => Ok(model),
        Some(away) => Err(Fault::Negative { name: away.name.clone() }.at(FilePlace::File).in_file(name)),
    }
}

/// As [`read_model`], with what is still to be done to the parts of a 3MF project: volumes that are to be cut away, and parts that are one solid
/// where they overlap.
///
/// # Errors
///
/// As [`read_model`].
pub fn read_project(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<DrawnModel, MeshError> {
    read(bytes, name, options.plates)
        .and_then(|soup| Model::from_soup(soup, options))
        .map_err(|located| located.in_file(name))
}

/// Reads a model's surface as it is, in mm: open, non-manifold and inconsistently wound meshes as well, all parts in one.
///
/// For what needs no closed parts, such as sums over normals. Equal vertices are welded and facets that then name one
/// twice dropped; nothing is mended, whatever `options.repair` says.
///
/// # Errors
///
/// A [`MeshError`] as [`read_model`]'s, but for what only closed parts need.
pub fn read_surface(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<TriangleMesh<Object>, MeshError> {
    let mut soup = read(bytes, name, options.plates).map_err(|located| located.in_file(name))?;
    if let Some(away) = soup.names.iter().find(|label| label.away) {
        return Err(Fault::Negative { name: away.away_called() }.at(FilePlace::File).in_file(name));
    }
    let facets = soup.facets.len();
    if soup.weld() == facets {
        return Err(Fault::Collapsed { facets }.at(FilePlace::File).in_file(name));
    }
    let longest = || Bounds::of(soup.vertices.iter().copied()).size().max();
    let unit = options.unit.or(soup.unit).unwrap_or_else(|| guess_unit(longest()).0);
    let vertices = soup.vertices.iter().map(|v| v * unit.millimetres()).collect();
    Ok(TriangleMesh::new(vertices, soup.facets))
}

fn read(bytes: &[u8], name: &str, plates: ProjectPlates) -> Result<Soup, Located> {
    if bytes.is_empty() {
        return Err(Fault::Empty.at(FilePlace::File));
    }
    // A mark of the encoding, which says nothing of a binary file.
    let marked = bytes.strip_prefix(b"\xef\xbb\xbf").filter(|_| !stl_binary::has_exact_length(bytes));
    let bytes = marked.unwrap_or(bytes);
    if let Some(fault) = strangers::known(bytes, name) {
        return Err(fault.at(FilePlace::File));
    }
    let soup = match format_of(bytes, name).ok_or_else(|| strangers::by_name(bytes, name).at(FilePlace::File))? {
        Format::StlBinary => stl_binary::read(bytes)?,
        Format::StlAscii => stl_ascii::read(bytes)?,
        Format::Obj => obj::read(bytes)?,
        Format::Off => off::read(bytes)?,
        Format::ThreeMf => match threemf::read(bytes, plates) {
            Ok(soup) if !soup.facets.is_empty() => soup,
            other => match strangers::in_archive(bytes, name) {
                Some(fault) => return Err(fault.at(FilePlace::File)),
                None => other?,
            },
        },
    };
    if let (ProjectPlates::Number(given), false) = (plates, format_of(bytes, name) == Some(Format::ThreeMf)) {
        return Err(Fault::NoPlates { given }.at(FilePlace::File));
    }
    if soup.facets.is_empty() { Err(Fault::NoFacets.at(FilePlace::File)) } else { Ok(soup) }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    StlBinary,
    StlAscii,
    Obj,
    Off,
    ThreeMf,
}

/// How much of a file is looked at to recognise text.
const HEAD: usize = 4096;

fn format_of(bytes: &[u8], name: &str) -> Option<Format> {
    if stl_binary::has_exact_length(bytes) {
        return Some(Format::StlBinary);
    }
    if bytes.starts_with(b"PK\x03\x04") {
        return Some(Format::ThreeMf);
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD)]);
    let text = head.trim_start();
    let first = text.split_whitespace().next().unwrap_or("");
    if off::is_header(first) {
        return Some(Format::Off);
    }
    if first.eq_ignore_ascii_case("solid") && stl_ascii::looks_like(text) {
        return Some(Format::StlAscii);
    }
    let extension = name.rsplit_once('.').map(|(_, end)| end.to_ascii_lowercase());
    match extension.as_deref() {
        Some("stl") => Some(Format::StlBinary),
        Some("obj") => Some(Format::Obj),
        Some("off") => Some(Format::Off),
        Some("3mf") => Some(Format::ThreeMf),
        _ => text.lines().any(|line| line.starts_with("v ")).then_some(Format::Obj),
    }
}

#[cfg(test)]
mod tests {
    use super::{Format, ReadOptions, Repair, format_of, read_model, read_surface};
    use crate::mesh::{Fault, Unit};

    #[test]
    fn content_goes_before_the_name() {
        let ascii = b"solid x\r\n facet normal 0 0 1\r\n";
        assert_eq!(format_of(ascii, "x.obj"), Some(Format::StlAscii));
        assert_eq!(format_of(b"# nothing\nOFF", "x.off"), Some(Format::Off));
        assert_eq!(format_of(b"OFF 3 1 0", "x.stl"), Some(Format::Off));
        assert_eq!(format_of(b"# blender\nv 1 2 3\n", "x"), Some(Format::Obj));
        assert_eq!(format_of(b"PK\x03\x04", "x.stl"), Some(Format::ThreeMf));
        assert_eq!(format_of(b"hello", "hello.txt"), None);
    }

    #[test]
    fn a_page_in_the_place_of_a_model_is_called_one() {
        for page in ["<!DOCTYPE html><title>Log in</title>", "\n <HTML>", "<!doctype HTML"] {
            for name in ["x.stl", "x.3mf", "x"] {
                let error = read_model(page.as_bytes(), name, &ReadOptions::default()).unwrap_err();
                assert_eq!((error.file.as_str(), error.fault), (name, Fault::WebPage));
            }
        }
    }

    #[test]
    fn the_word_solid_does_not_make_a_binary_file_text() {
        let mut bytes = vec![0; 84 + 50];
        bytes[..12].copy_from_slice(b"solid facet ");
        bytes[80] = 1;
        assert_eq!(format_of(&bytes, "x.stl"), Some(Format::StlBinary));
        bytes[80] = 2;
        assert_eq!(format_of(&bytes, "x.stl"), Some(Format::StlAscii), "of a wrong length, the text decides");
        bytes[..12].copy_from_slice(b"solid model ");
        assert_eq!(format_of(&bytes, "x.stl"), Some(Format::StlBinary), "cut short");
    }

    #[test]
    fn an_open_surface_is_read_as_it_is() {
        let text = b"OFF\n4 2 0\n0 0 0\n2 0 0\n0 2 0\n2 2 0\n3 0 1 2\n3 1 3 2\n";
        let inch = ReadOptions { unit: Some(Unit::Inch), repair: Repair::Off, ..ReadOptions::default() };
        assert!(read_model(text, "square.off", &inch).is_err());
        let mesh = read_surface(text, "square.off", &inch).unwrap();
        assert_eq!((mesh.vertices().len(), mesh.facets().len()), (4, 2));
        assert!((mesh.area() - 4.0 * 25.4 * 25.4).abs() < 1e-9);
        assert!(read_surface(b"", "x.off", &inch).is_err());
    }
}
