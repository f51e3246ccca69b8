//! Supports as they are laid, beside those of PrusaSlicer and Cura: same object, same pitch and width, seven figures of each.

use std::path::Path;
use std::time::Instant;

use trunnion::geom::{Angle, Bounds, Slot, Vec3};
use trunnion::mesh::{TriangleMesh, stl_binary_parts};
use trunnion::overhang::Keels;
use trunnion::slicing::SliceSettings;
use trunnion::slicing::builtin::sheets;
use trunnion::support::{Around, Clear, Clearance, Cuts, FlowMethod, Graph, Grid, Laying, lines, plan};

use super::judge::{Measures, Ruler, Triangle, supports};
use super::{reference, rivals, scenes};
use crate::support::{every, folder, note};

const RULER: Ruler = Ruler { pitch_mm: 2.5, line_mm: 0.4, layer_mm: 0.2, overhang_deg: 45.0 };
/// Steps of the grid around a scene.
const AROUND: f64 = 5.0;
/// As many units as the main job lets a column carry.
const CAPACITY: u16 = 10;
/// Who covers less than we do by more than this does not cover as much.
const AS_MUCH: f64 = 0.005;

pub(super) fn triangles(meshes: &[TriangleMesh<Slot>]) -> Vec<Triangle> {
    let corners = |mesh: &TriangleMesh<Slot>| -> Vec<Triangle> {
        (0..mesh.facets().len()).map(|facet| mesh.corners(facet).map(|v| [v.x, v.y, v.z])).collect()
    };
    meshes.iter().flat_map(corners).collect()
}

/// Our own file of supports below these meshes, from the ground at z = 0, and its seconds.
fn ours(meshes: &[TriangleMesh<Slot>]) -> (String, f64) {
    let start = Instant::now();
    let all: Vec<&TriangleMesh<Slot>> = meshes.iter().collect();
    let bounds = all.iter().fold(Bounds::EMPTY, |all, mesh| all.union(&mesh.bounds()));
    let step = RULER.pitch_mm;
    let around = Vec3::new(AROUND * step, AROUND * step, 0.0);
    let origin = Vec3::new(bounds.min.x, bounds.min.y, 0.0) - around;
    let size = bounds.max + around + Vec3::z() * step - origin;
    let graph = Graph::of(Grid::over(origin, size.into(), step), &all, Angle::from_deg(RULER.overhang_deg));
    let planned = plan(&graph, FlowMethod::Auto, CAPACITY, None, 1, &mut |_| {});
    assert_eq!(planned.tally.over_capacity, 0);
    let count = (bounds.max.z / RULER.layer_mm).round() as usize;
    let spans: Vec<[f64; 2]> = (0..count).map(|k| [k, k + 1].map(|k| k as f64 * RULER.layer_mm)).collect();
    let clearance = Clearance {
        line_mm: RULER.line_mm,
        gap_mm: RULER.layer_mm,
        clear: Clear::Layers { beside_mm: RULER.line_mm / 2.0 },
    };
    let how = Laying { on_part: false, roof: None, touch_every: 1 };
    let around = Around { meshes: &all, carrying: all.len(), keels: &Keels::default() };
    let laid = lines(&graph, &planned.flow, &Cuts::of(&around, spans, clearance), &how);
    let settings =
        SliceSettings { line_width_mm: RULER.line_mm, layer_height_mm: RULER.layer_mm, ..SliceSettings::default() };
    assert_eq!(settings.filament_mm, rivals::FILAMENT_MM);
    let text = String::from_utf8(sheets(&laid, &settings, "supports", None)).unwrap();
    (text, start.elapsed().as_secs_f64())
}

fn told(scene: &str, who: &str, measures: &Measures, seconds: f64) {
    let Measures { volume_mm3, covered, contact_mm2, plate_mm2, bare_squares, alone_mm, .. } = measures;
    let covered = 100.0 * covered;
    note(&format!(
        "{scene}, {who}: {volume_mm3:.0} mm3, {covered:.1} % covered, contact {contact_mm2:.0} mm2, plate {plate_mm2:.0} mm2, \
         {bare_squares} bare squares, alone {alone_mm:.1} mm, {seconds:.2} s"
    ));
}

/// Our figures, and how many others cover as much with more.
fn beaten(name: &str, meshes: &[TriangleMesh<Slot>], folder: &Path) -> (Measures, usize) {
    let surface = triangles(meshes);
    let measured = |text: &str| RULER.measure(&surface, &supports(text, rivals::FILAMENT_MM));
    let (text, seconds) = ours(meshes);
    let own = measured(&text);
    told(name, "trunnion", &own, seconds);
    // Slicers drop what floats onto the plate, unless something of the same file stands there.
    let foot = scenes::block(Vec3::zeros(), Vec3::new(2.0, 2.0, 0.4));
    let model = folder.join(format!("{name}.stl"));
    let all: Vec<&TriangleMesh<Slot>> = meshes.iter().chain([&foot]).collect();
    std::fs::write(&model, stl_binary_parts(&all)).unwrap();
    let mut count = 0;
    for rival in rivals::installed_ones() {
        let (text, seconds) = rival.sliced(&model, &RULER);
        let other = measured(&text);
        told(name, rival.name, &other, seconds);
        assert!(other.volume_mm3 > 100.0, "{}: it makes supports of {other:?}", rival.name);
        if other.covered >= own.covered - AS_MUCH {
            count += 1;
            assert!(own.volume_mm3 < other.volume_mm3, "{name}: {own:?}, {}: {other:?}", rival.name);
        }
    }
    (own, count)
}

#[test]
fn whoever_covers_as_much_takes_more() {
    let folder = folder();
    let cura = rivals::installed_ones().iter().any(|rival| rival.name.starts_with("Cura"));
    let twins = [("ring", scenes::leaning_ring().meshes), ("balls", scenes::two_balls().meshes)];
    // In the suite the first of the twins, which are like the given ones; in a soak all of them.
    let twins = twins.into_iter().step_by(every(2));
    let given = ["A", "C"].into_iter().filter(|_| every(2) == 1);
    let given = given.filter_map(|name| reference::meshes(name).map(|meshes| (name, meshes)));
    for (name, meshes) in twins.chain(given) {
        let (own, others) = beaten(name, &meshes, folder.path());
        assert!(own.covered > 0.999 && own.bare_squares == 0, "{name}: {own:?}");
        // Below a ring the ground is free; below a ball over a ball nobody else goes around the lower one.
        assert!(others >= 1 || !cura || !["ring", "A"].contains(&name), "{name}: nobody covers as much");
    }
}
