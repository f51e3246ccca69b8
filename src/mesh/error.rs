//! What is wrong with a model file, and where.

use std::fmt;

use thiserror::Error;

use crate::geom::Vec3;
use crate::location::Location;
use crate::spelling::counted;

/// A model that cannot be used: the file, the place in it, and the fault.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{file}: {place}{fault}")]
pub struct MeshError {
    /// The file's name as the caller gave it.
    pub file: String,
    /// Where in the file.
    pub place: FilePlace,
    /// What is wrong there.
    pub fault: Fault,
}

impl MeshError {
    /// Where in what the user gave it is.
    pub fn location(&self) -> Location {
        let file = Location::file(&self.file);
        match self.place {
            FilePlace::Line(line) => file.line(line),
            FilePlace::Part(part) => file.part(part),
            _ => file,
        }
    }
}

/// Where in a model file a fault lies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FilePlace {
    /// The file as a whole.
    File,
    /// A byte offset from the start of the file, from 0.
    Byte(u64),
    /// A text line, from 1.
    Line(u64),
    /// A facet in file order, from 0.
    Facet(u64),
    /// A byte offset within one entry of an archive.
    Entry {
        /// The entry's path in the archive.
        name: String,
        /// The offset in its unpacked text, from 0.
        byte: u64,
    },
    /// A part, numbered from 0 in the order of the first facets in the file.
    Part(usize),
    /// A solid, object or group by the name that the file has for it.
    Named(String),
}

impl fmt::Display for FilePlace {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Byte(at) => write!(out, "byte {at}: "),
            Self::Line(at) => write!(out, "line {at}: "),
            Self::Facet(at) => write!(out, "facet {at}: "),
            Self::Entry { name, byte } => write!(out, "{name}, byte {byte}: "),
            Self::Part(id) => write!(out, "part {id}: "),
            Self::Named(name) => write!(out, "{name}: "),
        }
    }
}

/// Places of one kind in a model, file units: the first ten, and how many more there are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Places {
    /// Those that are named.
    pub named: Vec<Vec3>,
    /// How many more there are.
    pub more: usize,
}

impl Places {
    /// As many as are named.
    const MOST: usize = 10;

    /// All places, in their order.
    pub(super) fn of(all: impl IntoIterator<Item = Vec3>) -> Self {
        let mut places = Self::default();
        all.into_iter().for_each(|at| places.add(at));
        places
    }

    /// One more place.
    pub(super) fn add(&mut self, at: Vec3) {
        if self.named.len() < Self::MOST {
            self.named.push(at);
        } else {
            self.more += 1;
        }
    }
}

impl fmt::Display for Places {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, at) in self.named.iter().enumerate() {
            let between = if index > 0 { ", " } else { "" };
            // Adding zero keeps "-0.000" out.
            let [x, y, z] = [at.x, at.y, at.z].map(|v| (v * 1e3).round() / 1e3 + 0.0);
            write!(out, "{between}({x:.3}, {y:.3}, {z:.3})")?;
        }
        if self.more > 0 { write!(out, " and {} more places", self.more) } else { Ok(()) }
    }
}

/// The largest magnitude of a coordinate, in file units: ten kilometres in mm, beyond which only garbage lies.
pub const MAX_COORDINATE: f64 = 1e7;

/// What is wrong; every variant carries the facts of its text.
#[derive(Clone, Debug, Error, PartialEq, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "mesh/")]
pub enum Fault {
    /// A file of no bytes.
    #[error("the file is empty (0 bytes); export the model again")]
    Empty,
    /// An unknown file format.
    #[error("not a format trunnion reads (binary or ascii stl, obj, off, 3mf); export the model as one of these")]
    UnknownFormat,
    /// A part as a CAD program keeps it: surfaces, and no facets.
    #[error(
        "{kind} stores surfaces, and a printer needs facets; export STL or 3MF from the CAD program, or run `{command}`"
    )]
    Surfaces {
        /// STEP or IGES.
        kind: &'static str,
        /// What makes facets of it, as a shell takes it.
        command: String,
    },
    /// What a CAD program keeps for itself.
    #[error("this is {kind}, which only its own program reads; export STL, 3MF or STEP from it")]
    Design {
        /// What it is.
        kind: &'static str,
    },
    /// A model that is packed into something else.
    #[error("this is a {kind} archive, not a model; unpack it and use {within}")]
    Compressed {
        /// gzip or zip.
        kind: &'static str,
        /// The model in it, as far as its name is known.
        within: String,
    },
    /// Text in another encoding.
    #[error("the text is encoded in UTF-16, and models are in UTF-8; save it as UTF-8")]
    Utf16,
    /// What a slicer has made already.
    #[error("this is G-code, made from a model; give the model itself")]
    Program,
    /// What a browser shows.
    #[error("this is a web page, not a model; download the model itself")]
    WebPage,
    /// A binary STL that ends before its last facet.
    #[error("the file has {have} bytes, but {facets} facets need {need}, so it is cut short; copy or export it again")]
    Truncated {
        /// Bytes in the file.
        have: u64,
        /// Bytes that the facet count asks for.
        need: u64,
        /// The facet count in the file's header.
        facets: u64,
    },
    /// A well-formed file with nothing in it.
    #[error("no facets (at least 4 are needed for a solid); export the model again with its solids selected")]
    NoFacets,
    /// A mesh of which no facet is left.
    #[error(
        "all {facets} facets repeat others or use one vertex twice, and enclose nothing; export the model again, in a smaller unit"
    )]
    Collapsed {
        /// Facets in the file.
        facets: usize,
    },
    /// More facets than the limit.
    #[error("more than {limit} facets; simplify the model, or remove components that repeat others")]
    TooManyFacets {
        /// The most it takes.
        limit: usize,
    },
    /// A coordinate that is NaN or infinite.
    #[error("coordinate {value} is not a finite number (allowed: -1e7 to 1e7); export the model again")]
    NotFinite {
        /// The value as read.
        value: f64,
    },
    /// A coordinate out of any printer's reach.
    #[error("coordinate {value} is out of range (allowed: -1e7 to 1e7 file units); check the unit of the export")]
    TooLarge {
        /// The value as read, in file units.
        value: f64,
    },
    /// A facet that names a vertex that is not there.
    #[error("vertex {index} does not exist (the file has {count}, numbered from {first}); export the model again")]
    IndexOutOfRange {
        /// The number in the file.
        index: i64,
        /// How many vertices there are.
        count: usize,
        /// The number of the first vertex in this format: 0 or 1.
        first: u8,
    },
    /// Text that does not follow the format.
    #[error("expected {expected}, found `{found}`; export the model again")]
    Syntax {
        /// What stands there.
        found: String,
        /// What the format asks for.
        expected: &'static str,
    },
    /// An archive that cannot be opened or unpacked.
    #[error("the 3mf archive cannot be read: {reason}; save it again in the program that made it")]
    Archive {
        /// The unpacker's words.
        reason: String,
    },
    /// Markup that cannot be parsed.
    #[error("the 3mf model's xml cannot be read: {reason}; save it again in the program that made it")]
    Xml {
        /// The parser's words.
        reason: String,
    },
    /// A 3MF reference to a missing object or in a circle.
    #[error("object {id} {trouble}; save the model again in the program that made it")]
    Object {
        /// The object's id in the file.
        id: String,
        /// What is wrong with it.
        trouble: &'static str,
    },
    /// A project volume with an unknown role.
    #[error("{name} has the unknown role {role:?}; make it a part in the program that made it, or remove it")]
    Role {
        /// Its name.
        name: String,
        /// As the file has it.
        role: String,
    },
    /// What would be mended, where nothing may be.
    #[error(
        "{first}{more}; --repair strict takes sound meshes only: repair it in the program that made it, or use --repair auto",
        more = if *.others > 0 { format!(", and {} more", counted(*.others, "repair")) } else { String::new() }
    )]
    Mended {
        /// The first repair, as the warning of one.
        first: String,
        /// How many more there are.
        others: usize,
    },
    /// A volume that its slicer cuts away.
    #[error("{name} is a negative volume, which is not subtracted here; subtract it in the program that made it")]
    Negative {
        /// Its name.
        name: String,
    },
    /// A project of several plates, none of which was chosen.
    #[error("the project has {known}; choose one (--plate N), or print all of them (prepare --plates DIR)")]
    SeveralPlates {
        /// Its plates, in words.
        known: String,
    },
    /// A plate on which nothing lies.
    #[error("nothing to print lies on plate {given} (--plate); the project has {known}")]
    NoSuchPlate {
        /// As asked for.
        given: u32,
        /// Its plates, in words.
        known: String,
    },
    /// A plate of a file that has none.
    #[error("the file lists no plates, so there is no plate {given}; remove --plate")]
    NoPlates {
        /// As asked for.
        given: u32,
    },
    /// An object that lies below its project's table.
    #[error("{name} lies below the table of its project; raise it or remove it there")]
    Below {
        /// Its name.
        name: String,
    },
    /// Nothing of a project is printed.
    #[error("the project prints nothing: {first}{}", if *others > 0 { format!(" (and {others} more)") } else { String::new() })]
    NothingPrinted {
        /// What is said of the first volume.
        first: String,
        /// How many more there are.
        others: usize,
    },
    /// A 3MF that needs an unsupported extension.
    #[error(
        "the 3mf extension {name} is not supported, and part of the model uses it; export the model as a triangle mesh"
    )]
    Extension {
        /// Its prefix and namespace, or the element that holds the shape.
        name: String,
    },
    /// A 3MF that unpacks to an implausible size.
    #[error(
        "the file unpacks to more than {} MiB (from {packed} bytes), or holds a tag or text of more than 16 MiB; save it again in the program that \
         made it",
        allowed >> 20
    )]
    Unpacked {
        /// The archive's size, bytes.
        packed: u64,
        /// What it may unpack to, bytes.
        allowed: u64,
    },
    /// More objects than the limit.
    #[error("more than {limit} objects, items and components; simplify the model")]
    TooManyObjects {
        /// The most it takes.
        limit: usize,
    },
    /// Parts most of which touch or fill one another.
    #[error(
        "more than {most} pairs of its {parts} parts touch or overlap; unite them in the program that made them, or leave out what repeats"
    )]
    Crowded {
        /// The parts.
        parts: usize,
        /// The most pairs that so many may be.
        most: usize,
    },
    /// More placed objects than the limit.
    #[error("items and components place more than {limit} objects; remove copies, and print them in several runs")]
    TooManyBodies {
        /// The most it takes.
        limit: usize,
    },
    /// A surface with holes.
    #[error("{edges} open edges (a solid has 0), near {at} in file units; {remedy}")]
    Open {
        /// Edges that bound one facet only.
        edges: usize,
        /// The middle of each hole, in file units.
        at: Places,
        /// What the user can do.
        remedy: &'static str,
    },
    /// Neighbouring facets that face opposite ways.
    #[error("{edges} edges between facets that face opposite ways (a solid has 0); {remedy}")]
    Winding {
        /// Edges whose two facets run along them in the same sense.
        edges: usize,
        /// What the user can do.
        remedy: &'static str,
    },
    /// A closed surface around nothing.
    #[error(
        "encloses {volume:.3e} cubic file units (at least {least:.3e} are needed for its size); remove it, it cannot be printed"
    )]
    Flat {
        /// The enclosed volume, cubic file units.
        volume: f64,
        /// The least that counts as a solid.
        least: f64,
    },
}

impl Fault {
    /// The fault at `place`, for a reader that does not know its file's name.
    pub(super) fn at(self, place: FilePlace) -> Located {
        Located { place, fault: self }
    }
}

/// A fault and its place; [`super::read_model`] adds the file's name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Located {
    pub(super) place: FilePlace,
    pub(super) fault: Fault,
}

impl Located {
    /// The error as the user sees it.
    pub(super) fn in_file(self, file: &str) -> MeshError {
        MeshError { file: file.to_owned(), place: self.place, fault: self.fault }
    }
}

/// `value` where it is a coordinate that can be used.
pub(super) fn coordinate(value: f64) -> Result<f64, Fault> {
    match value {
        v if !v.is_finite() => Err(Fault::NotFinite { value }),
        v if v.abs() > MAX_COORDINATE => Err(Fault::TooLarge { value }),
        // Adding zero turns -0.0 into +0.0, which welding by bits relies on.
        v => Ok(v + 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::{Fault, FilePlace, coordinate};

    #[test]
    fn a_coordinate_is_finite_and_within_ten_kilometres() {
        assert_eq!(coordinate(-1e7), Ok(-1e7));
        assert_eq!(coordinate(1.0000001e7), Err(Fault::TooLarge { value: 1.0000001e7 }));
        assert_eq!(coordinate(f64::NEG_INFINITY), Err(Fault::NotFinite { value: f64::NEG_INFINITY }));
        assert!(matches!(coordinate(f64::NAN), Err(Fault::NotFinite { .. })));
        assert_eq!(coordinate(-0.0).map(f64::to_bits), Ok(0.0_f64.to_bits()));
    }

    #[test]
    fn the_text_names_file_place_value_and_remedy() {
        let error = Fault::NotFinite { value: f64::NAN }.at(FilePlace::Facet(7)).in_file("a.stl");
        let text = error.to_string();
        assert!(text.starts_with("a.stl: facet 7: ") && text.contains(" NaN ") && text.contains("; "), "{text}");
        assert!(text.contains("-1e7 to 1e7"), "{text}");
        let error = Fault::Empty.at(FilePlace::File).in_file("a.stl");
        assert_eq!(error.to_string(), format!("a.stl: {}", Fault::Empty));
    }
}
