//! What is to be sliced, by which slicer, and whether that can be done at all.

use std::convert::Infallible;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use super::SliceError;
use crate::geom::Slot;
use crate::mesh::TriangleMesh;

/// What is laid on the table around a part: a brim that holds it there, loops that fill the nozzle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Adhesion {
    /// Width of the brim, mm; 0 for none.
    pub brim_mm: f64,
    /// Number of loops.
    pub skirt_loops: u32,
    /// From the brim, or from the part where it has none, to the innermost loop, mm.
    pub skirt_distance_mm: f64,
}

impl Adhesion {
    /// Whether anything is laid.
    pub fn is_some(&self) -> bool {
        self.brim_mm > 0.0 || self.skirt_loops > 0
    }
}

/// One slot's part as a slicer sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct SliceJob {
    /// The object's label in the G-code. PrusaSlicer appends `.stl`, Slic3r writes no labels.
    pub name: String,
    /// Whether the first layer lies on the table: then, and only then, it is printed at the first layer's speed.
    pub on_table: bool,
    /// Size of the slicer's bed in x and y, mm; its corner is at (0, 0) and the mesh is centred on it.
    pub bed_mm: [f64; 2],
    /// What is laid around it; nothing where it does not lie on the table.
    pub adhesion: Adhesion,
}

/// How far the lowest point may be from z = 0, mm: the last printed digit.
const GROUND_TOLERANCE_MM: f64 = 0.001;

impl SliceJob {
    /// Checks that the mesh can be sliced where it stands, and gives the number of layers, at least 1.
    pub(super) fn layers(&self, mesh: &TriangleMesh<Slot>, layer_mm: f64) -> Result<usize, SliceError> {
        let name = || self.name.clone();
        let bounds = mesh.bounds();
        let finite = mesh.vertices().iter().all(|v| v.iter().all(|x| x.is_finite()));
        if mesh.facets().is_empty() || !finite {
            return Err(SliceError::BadMesh { name: name() });
        }
        if bounds.min.z.abs() > GROUND_TOLERANCE_MM {
            return Err(SliceError::NotGrounded { name: name(), z_mm: bounds.min.z });
        }
        if (0..2).any(|i| bounds.min[i] < 0.0 || bounds.max[i] > self.bed_mm[i]) {
            let [min, max] = [bounds.min, bounds.max].map(|p| [p.x, p.y]);
            return Err(SliceError::OffBed { name: name(), min, max, bed: self.bed_mm });
        }
        // A height of exactly n/2 layers is rounded down: the last layer's middle would be the top face itself, where there is no
        // section to be held against. A thousandth of a layer keeps it from falling on either side by rounding.
        let layers = (bounds.max.z / layer_mm - 1e-3).round();
        if layers < 1.0 {
            let half_layer_mm = layer_mm / 2.0;
            return Err(SliceError::TooThin { name: name(), height_mm: bounds.max.z, half_layer_mm });
        }
        Ok(layers as usize)
    }
}

/// Which slicer the user wants.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SlicerChoice {
    /// An installed PrusaSlicer, else an installed Slic3r, else the built-in slicer.
    Auto,
    /// The built-in slicer.
    BuiltIn,
    /// PrusaSlicer, found on PATH or where its installer puts it.
    PrusaSlicer,
    /// Slic3r, found on PATH or where its installer puts it.
    Slic3r,
    /// CuraEngine, found on PATH or where its installer puts it.
    Cura,
    /// OrcaSlicer; this version cannot drive it.
    Orca,
    /// A program, identified by what it says of itself.
    Path(PathBuf),
}

impl FromStr for SlicerChoice {
    type Err = Infallible;

    /// One of the names of [`fmt::Display`]; everything else is taken for a path.
    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text {
            "auto" => Self::Auto,
            "builtin" => Self::BuiltIn,
            "prusa-slicer" => Self::PrusaSlicer,
            "slic3r" => Self::Slic3r,
            "cura" => Self::Cura,
            "orca" => Self::Orca,
            path => Self::Path(PathBuf::from(path)),
        })
    }
}

impl SlicerChoice {
    /// All that have a name and can be driven.
    pub(super) const NAMED: [Self; 5] = [Self::Auto, Self::BuiltIn, Self::PrusaSlicer, Self::Slic3r, Self::Cura];
}

impl fmt::Display for SlicerChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::BuiltIn => f.write_str("builtin"),
            Self::PrusaSlicer => f.write_str("prusa-slicer"),
            Self::Slic3r => f.write_str("slic3r"),
            Self::Cura => f.write_str("cura"),
            Self::Orca => f.write_str("orca"),
            Self::Path(path) => path.display().fmt(f),
        }
    }
}
