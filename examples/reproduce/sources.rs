//! Where objects come from: generated here, or read from a folder that the user gives.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use trunnion::fixtures::Fixture;
use trunnion::geom::{Object, Vec3};
use trunnion::mesh::{Model, ReadOptions, Repair, TriangleMesh, Unit, read_surface};
use trunnion::orient::{Facets, Local, Objective, Proof};

/// How the documents are remade.
#[derive(Default)]
pub(crate) struct Run {
    /// Whether what takes long is left out.
    pub(crate) quick: bool,
    /// Where meshes of the documents are.
    pub(crate) meshes: Option<PathBuf>,
}

impl Run {
    /// The surface in the file with this name, anywhere in the folder of meshes; as it is, in its own units.
    ///
    /// # Errors
    ///
    /// Why there is none, in words for the page.
    pub(crate) fn mesh(&self, name: &str) -> Result<TriangleMesh<Object>, String> {
        let folder = self.meshes.as_deref().ok_or_else(|| format!("mesh not given: {name}"))?;
        let path = found(folder, name).ok_or_else(|| format!("mesh not given: {name}"))?;
        let bytes = std::fs::read(&path).map_err(|error| format!("{name}: {error}"))?;
        let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
        read_surface(&bytes, name, &options).map_err(|error| format!("{name}: {error}"))
    }
}

/// The file with this name in a folder or in one of its folders, the first by name.
fn found(folder: &Path, name: &str) -> Option<PathBuf> {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path())).collect();
    entries.sort();
    let own = entries.iter().find(|path| path.is_file() && path.file_name().is_some_and(|own| own == name));
    own.cloned().or_else(|| entries.iter().filter(|path| path.is_dir()).find_map(|inner| found(inner, name)))
}

/// A generated model as a file of it would be read.
pub(crate) fn model(fixture: Fixture) -> Model {
    let bottom = |mesh: &TriangleMesh<Object>| mesh.bounds().min.z;
    let lowest = fixture.parts.iter().map(|(_, mesh)| bottom(mesh)).fold(f64::INFINITY, f64::min);
    debug_assert!(lowest.abs() < 1e-9, "generated models stand on z = 0");
    Model::from_parts(fixture.parts)
}

/// An objective that keeps the directions at which it is asked for a value.
pub(crate) struct Recorded<'a> {
    pub(crate) of: &'a dyn Objective,
    pub(crate) asked: Mutex<Vec<Vec3>>,
}

impl<'a> Recorded<'a> {
    pub(crate) fn new(of: &'a dyn Objective) -> Self {
        Self { of, asked: Mutex::default() }
    }

    pub(crate) fn taken(self) -> Vec<Vec3> {
        self.asked.into_inner().unwrap_or_default()
    }
}

impl Objective for Recorded<'_> {
    fn name(&self) -> &str {
        self.of.name()
    }

    fn value(&self, facets: &Facets, up: &Vec3) -> f64 {
        if let Ok(mut asked) = self.asked.lock() {
            asked.push(*up);
        }
        self.of.value(facets, up)
    }

    fn gradient(&self, facets: &Facets, up: &Vec3) -> Option<Vec3> {
        self.of.gradient(facets, up)
    }

    fn proof(&self) -> Proof {
        self.of.proof()
    }

    fn local<'b>(&'b self, facets: &'b Facets) -> Option<Box<dyn Local<'b> + 'b>> {
        self.of.local(facets)
    }
}

/// A function of the direction alone as an objective.
pub(crate) struct Toy<F>(pub(crate) F);

impl<F: Fn(&Vec3) -> f64 + Sync> Objective for Toy<F> {
    fn name(&self) -> &str {
        "toy"
    }

    fn value(&self, _: &Facets, up: &Vec3) -> f64 {
        (self.0)(up)
    }

    fn gradient(&self, _: &Facets, _: &Vec3) -> Option<Vec3> {
        None
    }
}

/// Degrees between two directions.
pub(crate) fn degrees(a: &Vec3, b: &Vec3) -> f64 {
    a.cross(b).norm().atan2(a.dot(b)).to_degrees()
}
