//! Why a slot could not be sliced.

use std::io;
use std::path::PathBuf;

use super::sliced::{KEEPS, LeftOut};
use crate::profile::OutOfRange;
use crate::spelling::counted;

/// Why a slot could not be sliced.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "slice/")]
pub enum SliceError {
    /// A setting lies outside its range.
    #[error("setting {0}")]
    Setting(#[from] OutOfRange),
    /// The mesh has no facets, or a coordinate that is not a number.
    #[error("the mesh of `{name}` has no facets or a coordinate that is not a number; export it again")]
    BadMesh {
        /// The job's name.
        name: String,
    },
    /// The lowest point of the mesh is not at z = 0.
    #[error("the lowest point of `{name}` must be at z = 0 (+-0.001 mm), got {z_mm:.4} mm; move the model to z = 0")]
    NotGrounded {
        /// The job's name.
        name: String,
        /// The lowest z, mm.
        z_mm: f64,
    },
    /// The mesh does not lie wholly on the bed.
    #[error(
        "`{name}` reaches from ({:.3}, {:.3}) to ({:.3}, {:.3}) mm, outside the bed, (0, 0) to ({:.3}, {:.3}) mm; \
         centre it on the bed, or use a larger bed", .min[0], .min[1], .max[0], .max[1], .bed[0], .bed[1]
    )]
    OffBed {
        /// The job's name.
        name: String,
        /// Smallest x and y, mm.
        min: [f64; 2],
        /// Largest x and y, mm.
        max: [f64; 2],
        /// Size of the bed, mm.
        bed: [f64; 2],
    },
    /// The part is lower than half a layer.
    #[error(
        "`{name}` must be at least half a layer high ({half_layer_mm:.4} mm), got {height_mm:.4} mm; \
         choose a smaller layer height or another orientation"
    )]
    TooThin {
        /// The job's name.
        name: String,
        /// The part's height, mm.
        height_mm: f64,
        /// Half the layer height, mm.
        half_layer_mm: f64,
    },
    /// The slicer wrote no extrusion at all.
    #[error(
        "{slicer} printed nothing of `{name}`; check that walls are wider than the line width, the part is on the bed, \
         and gcode_flavor uses E"
    )]
    NothingExtruded {
        /// The slicer's name.
        slicer: String,
        /// The job's name.
        name: String,
    },
    /// Too much of the part is too narrow to print.
    #[error("`{name}`: {left} (at most {} % may be missing); {KEEPS}", .most * 100.0)]
    LeftOut {
        /// The job's name.
        name: String,
        /// What is missing.
        left: LeftOut,
        /// How much of the volume may be, 0 to 1.
        most: f64,
    },
    /// A layer that is too narrow to print between two that are not.
    #[error(
        "`{name}` is narrower than {thinnest_mm:.3} mm at Z {z_mm:.2}, so {} cannot be printed; {KEEPS}",
        counted(*.layers, "layer")
    )]
    LayerLeftOut {
        /// The job's name.
        name: String,
        /// Top of the lowest layer that is missing, mm.
        z_mm: f64,
        /// How many are.
        layers: usize,
        /// What is thinner is not printed, mm.
        thinnest_mm: f64,
    },
    /// The wanted slicer is not installed.
    #[error("{slicer} was found neither on PATH (looked for {}) nor where its installer puts it; install it, give its path, or use --slicer builtin", .looked_for.join(", "))]
    NotFound {
        /// The slicer's name.
        slicer: String,
        /// The program names that were tried.
        looked_for: Vec<String>,
    },
    /// An unknown slicer.
    #[error("{given:?} is not a slicer; the nearest is {nearest} (use {known}, or the path of one)")]
    UnknownSlicer {
        /// The word.
        given: String,
        /// The name nearest to it.
        nearest: String,
        /// All names.
        known: String,
    },
    /// A slicer whose command line is not supported.
    #[error("this version of trunnion cannot drive {slicer}; {remedy}")]
    NotDriven {
        /// The slicer's name.
        slicer: String,
        /// What to do instead.
        remedy: &'static str,
    },
    /// CuraEngine without the definitions of its settings.
    #[error(
        "{} needs {file}, which was not found; install Cura's resources (Debian: the package cura), or name the folders in CURA_ENGINE_SEARCH_PATH", .program.display()
    )]
    NoDefinitions {
        /// The program.
        program: PathBuf,
        /// What it needs.
        file: &'static str,
    },
    /// A program that is not a supported slicer.
    #[error("{} is not PrusaSlicer, Slic3r or CuraEngine: its --help begins with `{text}`; give the path of one of them, or use --slicer builtin", .path.display())]
    NotASlicer {
        /// The program.
        path: PathBuf,
        /// The first line it printed.
        text: String,
    },
    /// The slicer did not end in time and was stopped.
    #[error(
        "{slicer} was stopped after {seconds:.1} s while slicing `{name}`; raise --slicer-timeout, or simplify the mesh"
    )]
    TimedOut {
        /// The slicer's name.
        slicer: String,
        /// The job's name.
        name: String,
        /// The time allowed, s.
        seconds: f64,
    },
    /// A program that does not answer --help.
    #[error("{} did not answer --help within {seconds:.1} s; give another program, or use --slicer builtin", .path.display())]
    Silent {
        /// The program.
        path: PathBuf,
        /// The time allowed, s.
        seconds: f64,
    },
    /// The slicer wrote more than any print needs.
    #[error("{slicer} wrote {bytes} bytes for `{name}` (maximum {allowed}); simplify the mesh, or use thicker layers")]
    TooBig {
        /// The slicer's name.
        slicer: String,
        /// The job's name.
        name: String,
        /// The size of its file when it was given up.
        bytes: u64,
        /// The largest that is read.
        allowed: u64,
    },
    /// An interrupt.
    #[error("interrupted; the slicer was stopped and nothing was written")]
    Interrupted,
    /// The slicer ended with an error.
    #[error("{slicer} failed on `{name}` ({status}): {last_lines}")]
    Failed {
        /// The slicer's name.
        slicer: String,
        /// The job's name.
        name: String,
        /// Its exit status.
        status: String,
        /// The end of what it wrote to stderr.
        last_lines: String,
    },
    /// The slicer said that all was well but wrote no file, or an empty one.
    #[error("{slicer} reported success but wrote {found} for `{name}`: {last_lines}")]
    NoOutput {
        /// The slicer's name.
        slicer: String,
        /// The job's name.
        name: String,
        /// `no file` or `an empty file`.
        found: &'static str,
        /// The end of what it wrote to stderr.
        last_lines: String,
    },
    /// A file or program could not be used.
    #[error("cannot {action} {}: {source}", .path.display())]
    File {
        /// What was tried.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

impl SliceError {
    /// Whether a slicer failed, hung or dropped the part, as opposed to a request that could not be met.
    pub fn is_slicer_failure(&self) -> bool {
        matches!(
            self,
            Self::TimedOut { .. }
                | Self::Silent { .. }
                | Self::TooBig { .. }
                | Self::Failed { .. }
                | Self::NoOutput { .. }
                | Self::NothingExtruded { .. }
                | Self::LeftOut { .. }
                | Self::LayerLeftOut { .. }
        )
    }
}
