//! One 3MF model file, parsed as a stream.

use std::collections::BTreeMap;
use std::io::BufRead;
use std::ops::Range;
use std::rc::Rc;

use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::attributes::attribute;
use super::meter::Meter;
use super::roles::{self, Painted, Role, Volume};
use crate::geom::{Mat3, Vec3};
use crate::mesh::Unit;
use crate::mesh::error::{Fault, FilePlace, Located, coordinate};

/// An affine map; columns act on column vectors, so the file's row-vector matrix is transposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transform {
    linear: Mat3,
    shift: Vec3,
}

impl Transform {
    pub(super) const IDENTITY: Self =
        Self { linear: Mat3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), shift: Vec3::new(0.0, 0.0, 0.0) };

    pub(super) fn point(&self, at: &Vec3) -> Vec3 {
        self.linear * at + self.shift
    }

    /// First `self`, then `next`.
    pub(super) fn then(&self, next: &Self) -> Self {
        Self { linear: next.linear * self.linear, shift: next.point(&self.shift) }
    }

    pub(super) fn mirrors(&self) -> bool {
        self.linear.determinant() < 0.0
    }

    fn parse(text: &str) -> Result<Self, Fault> {
        let values = text.split_whitespace().map(number).collect::<Result<Vec<_>, _>>()?;
        let [a, b, c, d, e, f, g, h, i, x, y, z] = values[..] else {
            return Err(Fault::Syntax {
                found: text.chars().take(40).collect(),
                expected: "a transform of 12 numbers",
            });
        };
        Ok(Self { linear: Mat3::new(a, d, g, b, e, h, c, f, i), shift: Vec3::new(x, y, z) })
    }
}

/// An object that a build item or component places.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    /// The model file it lies in, where that is another one.
    pub(super) path: Option<String>,
    pub(super) id: String,
    pub(super) transform: Transform,
    /// Whether an item is to be printed.
    pub(super) printed: bool,
}

/// A mesh, components, or both empty.
#[derive(Clone, Debug, Default)]
pub(super) struct Object {
    pub(super) name: Option<String>,
    pub(super) mesh: (Vec<Vec3>, Vec<[u32; 3]>),
    pub(super) components: Vec<Reference>,
    pub(super) role: Role,
    pub(super) painted: Painted,
    /// Volumes by their triangles, as Slic3r 1.3 notes them in the mesh itself.
    pub(super) stretches: Vec<(Range<usize>, Volume)>,
}

impl Object {
    /// Vertex numbers can be checked only when all is read: a file may give the triangles first.
    fn check(&self) -> Result<(), Fault> {
        let (vertices, facets) = &self.mesh;
        let count = vertices.len();
        match facets.iter().flatten().find(|&&index| index as usize >= count) {
            Some(&index) => Err(Fault::IndexOutOfRange { index: index.into(), count, first: 0 }),
            None => Ok(()),
        }
    }
}

/// The most objects, items and components of a file: each takes far more room than its tag.
pub(super) const MAX_NAMED: usize = 100_000;

/// What one model file holds.
#[derive(Clone, Debug, Default)]
pub(super) struct ModelFile {
    pub(super) unit: Unit,
    /// Shared with what places them: a mesh is kept once.
    pub(super) objects: BTreeMap<String, Rc<Object>>,
    pub(super) items: Vec<Reference>,
    current: String,
    /// The role that the metadata in hand gives its object, if it is true.
    setting: Option<Role>,
    /// Objects, items and components so far.
    named: usize,
    /// The program that made it, where it says so; and whether the metadata in hand does.
    pub(super) application: Option<String>,
    names_program: bool,
}

/// Parses the model file `path` from its unpacked text.
pub(super) fn parse(text: &mut Meter<impl BufRead>, path: &str) -> Result<ModelFile, Located> {
    let mut reader = Reader::from_reader(text);
    let mut file = ModelFile::default();
    let mut buffer = Vec::new();
    loop {
        let event = reader.read_event_into(&mut buffer);
        let place = |byte| FilePlace::Entry { name: path.to_owned(), byte };
        let done = match event {
            Ok(Event::Start(tag) | Event::Empty(tag)) => file.open(&tag).map(|()| false),
            Ok(Event::Text(text)) => {
                file.set(&text);
                Ok(false)
            }
            Ok(Event::End(tag)) if tag.local_name().as_ref() == "object" => {
                file.object("object").and_then(|object| object.check()).map(|()| false)
            }
            // Once more: text that breaks off leaves an object unchecked.
            Ok(Event::Eof) => file.objects.values().try_for_each(|object| object.check()).map(|()| true),
            Ok(_) => Ok(false),
            Err(error) => Err(Fault::Xml { reason: error.to_string() }),
        };
        if done.map_err(|fault| fault.at(place(reader.buffer_position())))? {
            return Ok(file);
        }
        buffer.clear();
        reader.get_mut().piece();
    }
}

/// The target of the relation to the 3D model in `_rels/.rels`; `None` where there is none.
pub(super) fn model_target(text: &str) -> Option<String> {
    let mut reader = Reader::from_str(text);
    loop {
        match reader.read_event().ok()? {
            Event::Start(tag) | Event::Empty(tag) => {
                let kind = attribute(&tag, "Type").ok()?;
                if kind.is_some_and(|kind| kind.ends_with("/3dmodel")) {
                    return attribute(&tag, "Target").ok()?;
                }
            }
            Event::Eof => return None,
            _ => {}
        }
    }
}

impl ModelFile {
    fn open(&mut self, tag: &BytesStart<'_>) -> Result<(), Fault> {
        if matches!(tag.local_name().as_ref(), "object" | "item" | "component") {
            self.named += 1;
            if self.named > MAX_NAMED {
                return Err(Fault::TooManyObjects { limit: MAX_NAMED });
            }
        }
        match tag.local_name().as_ref() {
            "model" => {
                extensions(tag)?;
                self.unit = unit(attribute(tag, "unit")?.as_deref())?;
            }
            // A shape told in another way than by triangles, which a program may pass over unless it is "required": a part would be lost.
            shape @ ("beamlattice" | "booleanshape" | "displacementmesh" | "levelset") => {
                return Err(Fault::Extension { name: shape.to_owned() });
            }
            "object" => {
                self.current = required(tag, "id")?;
                let name = attribute(tag, "name")?.filter(|name| !name.trim().is_empty());
                let role = roles::of_type(attribute(tag, "type")?.as_deref())?;
                self.objects.insert(self.current.clone(), Rc::new(Object { name, role, ..Object::default() }));
            }
            "metadata" => {
                let name = attribute(tag, "name")?;
                self.names_program = name.as_deref() == Some("Application");
                self.setting = name.and_then(|name| roles::of_setting(&name));
            }
            // Cura before metadata had groups; libSavitar reads both.
            "setting" => {
                self.setting = attribute(tag, "key")?.and_then(|key| roles::of_setting(&format!("cura:{key}")));
            }
            "volume" => {
                if let Some(stretch) = roles::of_volume(tag)? {
                    self.object("volume")?.stretches.push(stretch);
                }
            }
            "item" => self.items.push(reference(tag)?),
            "vertex" => {
                let at = vertex(tag)?;
                self.object("vertex")?.mesh.0.push(at);
            }
            "triangle" => {
                let facet = triangle(tag)?;
                let object = self.object("triangle")?;
                object.mesh.1.push(facet);
                object.painted.add(tag)?;
            }
            "component" => {
                let component = reference(tag)?;
                self.object("component")?.components.push(component);
            }
            _ => {}
        }
        Ok(())
    }

    /// That a project has lost what says what its volumes are for.
    pub(super) fn without_settings(&self, known: bool) -> Option<String> {
        let program = self.application.as_deref().filter(|_| !known)?;
        let keeps = ["BambuStudio", "OrcaSlicer"].iter().any(|name| program.starts_with(name));
        keeps
            .then(|| format!("the project of {program} does not say what its volumes are for; all of them are printed"))
    }

    /// What metadata says of the object around it.
    fn set(&mut self, text: &str) {
        if std::mem::take(&mut self.names_program) {
            self.application = Some(text.chars().take(80).collect());
        }
        let is_true = text.trim().eq_ignore_ascii_case("true");
        if let (Some(role), true, Ok(object)) = (self.setting.take(), is_true, self.object("metadata")) {
            object.role = role;
        }
    }

    /// The object around an element of this name.
    fn object(&mut self, element: &str) -> Result<&mut Object, Fault> {
        self.objects
            .get_mut(&self.current)
            .map(Rc::make_mut)
            .ok_or_else(|| Fault::Syntax { found: element.to_owned(), expected: "an object element first" })
    }
}

/// The 3MF extensions that are read: parts in other files, and what has no shape of its own (colours, groups of triangles).
/// Source: 3MF Consortium, *Production Extension* 1.1, *Materials and Properties Extension* 1.2, *Core Specification* 1.3 appendix.
const EXTENSIONS: [&str; 3] = [
    "http://schemas.microsoft.com/3dmanufacturing/production/2015/06",
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07",
];

/// Refuses a model that cannot be understood without an extension that is not read: it is named by its prefix and its namespace.
fn extensions(model: &BytesStart<'_>) -> Result<(), Fault> {
    let required = attribute(model, "requiredextensions")?.unwrap_or_default();
    for prefix in required.split_whitespace() {
        let declared = format!("xmlns:{prefix}");
        let mut attributes = model.attributes();
        let mut all = attributes.with_checks(false).filter_map(Result::ok);
        let namespace = all.find(|a| a.key.as_ref() == declared).map(|a| a.value.into_owned());
        if !namespace.as_deref().is_some_and(|name| EXTENSIONS.contains(&name)) {
            let about = namespace.map_or_else(String::new, |name| format!(" ({name})"));
            return Err(Fault::Extension { name: format!("{prefix}{about}").chars().take(200).collect() });
        }
    }
    Ok(())
}

fn unit(name: Option<&str>) -> Result<Unit, Fault> {
    match name {
        None | Some("millimeter") => Ok(Unit::Millimetre),
        Some("micron") => Ok(Unit::Micron),
        Some("centimeter") => Ok(Unit::Centimetre),
        Some("inch") => Ok(Unit::Inch),
        Some("foot") => Ok(Unit::Foot),
        Some("meter") => Ok(Unit::Metre),
        Some(other) => Err(Fault::Syntax {
            found: other.chars().take(40).collect(),
            expected: "unit micron, millimeter, centimeter, inch, foot or meter",
        }),
    }
}

fn required(tag: &BytesStart<'_>, name: &'static str) -> Result<String, Fault> {
    let found = || tag.name().as_ref().to_owned();
    attribute(tag, name)?.ok_or_else(|| Fault::Syntax {
        found: found(),
        expected: match name {
            "id" | "objectid" => "an object's id",
            _ => "x, y, z of a vertex or v1, v2, v3 of a triangle",
        },
    })
}

fn reference(tag: &BytesStart<'_>) -> Result<Reference, Fault> {
    let transform = attribute(tag, "transform")?;
    Ok(Reference {
        path: attribute(tag, "path")?,
        id: required(tag, "objectid")?,
        transform: transform.map_or(Ok(Transform::IDENTITY), |text| Transform::parse(&text))?,
        printed: attribute(tag, "printable")?.is_none_or(|word| word != "0" && word != "false"),
    })
}

fn number(text: &str) -> Result<f64, Fault> {
    text.trim()
        .parse()
        .map_err(|_| Fault::Syntax { found: text.chars().take(40).collect(), expected: "a number" })
        .and_then(coordinate)
}

fn vertex(tag: &BytesStart<'_>) -> Result<Vec3, Fault> {
    let value = |name| number(&required(tag, name)?);
    Ok(Vec3::new(value("x")?, value("y")?, value("z")?))
}

fn triangle(tag: &BytesStart<'_>) -> Result<[u32; 3], Fault> {
    let value = |name| {
        let text = required(tag, name)?;
        let found = || text.chars().take(40).collect();
        text.trim().parse().map_err(|_| Fault::Syntax { found: found(), expected: "a vertex number" })
    };
    Ok([value("v1")?, value("v2")?, value("v3")?])
}
