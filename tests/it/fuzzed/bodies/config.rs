//! Bytes as a slicer's configuration for the built-in slicer, and as a list of touches.

use std::io::Write;
use std::sync::OnceLock;
use std::time::Duration;

use trunnion::calibrate::Touches;
use trunnion::geom::{Slot, Vec3};
use trunnion::job::{Installed, Slicers};
use trunnion::mesh::TriangleMesh;
use trunnion::slicing::{Adhesion, SliceJob, SliceSettings, SlicerChoice};
use trunnion::toolpath::{InputWords, read_sliced};

use super::choice;

/// A box of 6 x 6 x 1.5 mm on the middle of a bed.
fn cuboid() -> &'static TriangleMesh<Slot> {
    static MESH: OnceLock<TriangleMesh<Slot>> = OnceLock::new();
    MESH.get_or_init(|| {
        let corner = |i: u32| {
            let along = |bit: u32, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
            Vec3::new(along(0, 47.0, 53.0), along(1, 47.0, 53.0), along(2, 0.0, 1.5))
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let facets = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        TriangleMesh::new((0..8).map(corner).collect(), facets)
    })
}

/// An even first byte: a configuration; an odd one: touches.
pub(super) fn config(data: &[u8]) {
    let Some((how, bytes)) = choice(data) else { return };
    if how % 2 == 1 {
        let Ok(text) = std::str::from_utf8(bytes) else { return };
        if let Ok(touches) = Touches::parse("any.toml", text) {
            assert!(touches.touches.len() <= 2000);
        }
        return;
    }
    let mut file = tempfile::NamedTempFile::new().expect("a temporary file");
    file.write_all(bytes).expect("room for it");
    let (configs, timeout) = (vec![file.path().to_owned()], Duration::from_secs(5));
    let slicer = match Installed::default().find(&SlicerChoice::BuiltIn, &configs, timeout) {
        Ok(slicer) => slicer,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let _ = slicer.flaws();
    let job = SliceJob { name: "box".to_owned(), on_table: true, bed_mm: [100.0; 2], adhesion: Adhesion::default() };
    match slicer.slice(cuboid(), &SliceSettings::default(), &job) {
        Ok(sliced) => {
            // Whatever is asked for, what the built-in slicer writes the rewriter takes.
            read_sliced(&sliced.gcode, "box.gcode", InputWords::default()).expect("our own slice is read");
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}
