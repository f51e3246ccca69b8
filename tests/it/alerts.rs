//! What hangs against PrusaSlicer's own stability warnings (2.6 and newer print them on the console): shapes that it is silent about must not be
//! cut, tilted, held or refused, and none that it says collapses may be fine.

use std::f64::consts::FRAC_PI_2;
use std::path::Path;
use std::process::Command;

use rayon::prelude::*;
use trunnion::geom::{Object, Vec3};
use trunnion::mesh::{TriangleMesh, stl_binary};
use trunnion::overhang::{BRIDGE_MM, Ground, Judged, OverhangRule, judged};

use crate::split::solids::{block, rod};
use crate::support::{Numbers, folder, note, said, seeds, skip};

const LAYER_MM: f64 = 0.2;
const LINE_MM: f64 = 0.45;
/// Of all shapes so many have the same answer: those at a limit have not.
const AGREE: f64 = 0.94;

/// A solid of boxes that go over into each other: height, x from and to, y from and to; the first on the table.
fn lofted(rings: &[(f64, [f64; 2], [f64; 2])]) -> TriangleMesh<Object> {
    let corners = |&(z, [x0, x1], [y0, y1]): &(f64, [f64; 2], [f64; 2])| {
        [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| Vec3::new(x, y, z))
    };
    let vertices: Vec<Vec3> = rings.iter().flat_map(corners).collect();
    let last = 4 * (rings.len() as u32 - 1);
    let mut facets = vec![[0, 2, 1], [0, 3, 2], [last, last + 1, last + 2], [last, last + 2, last + 3]];
    for ring in (0..last).step_by(4) {
        for side in 0..4 {
            let (a, b) = (ring + side, ring + (side + 1) % 4);
            facets.extend([[a, b, b + 4], [a, b + 4, a + 4]]);
        }
    }
    TriangleMesh::new(vertices, facets)
}

/// A shape of the kinds that one meets: ledges, slopes, fillets and chamfers below, bridges, arches, lying rods.
fn shape(seed: u64) -> (String, TriangleMesh<Object>) {
    let numbers = &mut Numbers::seeded(seed);
    let long = numbers.between(5.0, 60.0);
    let along = [-long / 2.0, long / 2.0];
    match seed % 7 {
        0 => {
            let out = numbers.between(0.3, 4.0);
            let (post, wide) = ([-10.0, 0.0], [-10.0, out]);
            let rings = [(0.0, post, along), (15.0, post, along), (15.0, wide, along), (20.0, wide, along)];
            (format!("ledge {out:.2} x {long:.0}"), lofted(&rings))
        }
        1 => {
            let (deg, high) = (numbers.between(40.0, 75.0), numbers.between(0.4, 12.0));
            let out = high * deg.to_radians().tan();
            let at = |z: f64, x: f64| (z, [-15.0, x], along);
            let rings = [at(0.0, 0.0), at(5.0, 0.0), at(5.0 + high, out), at(10.0 + high, out)];
            (format!("slope {deg:.1} deg, {high:.1} high x {long:.0}"), lofted(&rings))
        }
        2 => {
            let radius = numbers.between(0.5, 14.0);
            let ring = |k: i32| {
                let (s, c) = (f64::from(k) / 32.0 * FRAC_PI_2).sin_cos();
                let half = [22.0, 18.0].map(|half| half - radius * (1.0 - s));
                (radius * (1.0 - c), [-half[0], half[0]], [-half[1], half[1]])
            };
            let mut rings: Vec<_> = (0..=32).map(ring).collect();
            rings.push((radius + 10.0, [-22.0, 22.0], [-18.0, 18.0]));
            (format!("fillet {radius:.1}"), lofted(&rings))
        }
        3 => {
            let (deg, out, foot) =
                (numbers.between(40.0, 72.0), numbers.between(0.3, 3.0), numbers.between(0.0, 1.0) < 0.5);
            let high = out / deg.to_radians().tan();
            let low = if foot { 0.0 } else { 5.0 };
            let at = |z: f64, inset: f64| (z, [-20.0 + inset, 20.0 - inset], [-15.0 + inset, 15.0 - inset]);
            let mut rings = vec![at(0.0, out)];
            rings.extend((low > 0.0).then(|| at(low, out)));
            rings.extend([at(low + high, 0.0), at(low + high + 8.0, 0.0)]);
            (format!("chamfer {deg:.1} deg, {out:.2} out at {low}"), lofted(&rings))
        }
        4 => {
            let wide = numbers.between(4.0, 30.0);
            let whole = block(wide + 12.0, long, 20.0).at(-wide / 2.0 - 6.0, -long / 2.0, 0.0);
            let gap = block(wide, long + 2.0, 16.0).at(-wide / 2.0, -long / 2.0 - 1.0, -1.0);
            (format!("bridge {wide:.1} x {long:.0}"), whole.less(&gap).mesh())
        }
        5 => {
            let radius = numbers.between(1.0, 20.0);
            let whole = block(2.0 * radius + 14.0, long, radius + 16.0).at(-radius - 7.0, -long / 2.0, 0.0);
            let hole = rod(radius, long + 2.0, 96).about_y(90.0).about_z(90.0).at(0.0, -long / 2.0 - 1.0, 10.0);
            let slot = block(2.0 * radius, long + 2.0, 11.0).at(-radius, -long / 2.0 - 1.0, -1.0);
            (format!("arch {:.1} x {long:.0}", 2.0 * radius), whole.less(&hole).less(&slot).mesh())
        }
        _ => {
            let radius = numbers.between(2.0, 16.0);
            let ring = |k: i32| {
                let turn = f64::from(k) / 48.0 * std::f64::consts::PI;
                let half = (radius * turn.sin()).max(0.05);
                (radius * (1.0 - turn.cos()), [-half, half], along)
            };
            (format!("rod {radius:.1} x {long:.0}"), lofted(&(0..=48).map(ring).collect::<Vec<_>>()))
        }
    }
}

fn grade(mesh: &TriangleMesh<Object>) -> Judged {
    let rule = OverhangRule {
        overhang: OverhangRule::practised(LAYER_MM, LINE_MM),
        layer_mm: LAYER_MM,
        line_mm: LINE_MM,
        bridge_mm: BRIDGE_MM,
        tolerate_mm2: 1.0,
        droops: true,
    };
    let foot = |f: usize| mesh.corners(f).iter().all(|p| p.z.abs() < 1e-6);
    judged(mesh, &Vec3::z(), &Ground { table: true, ..Ground::default() }, foot, &rule, false)
}

/// What PrusaSlicer warns of; whether a print comes loose of the bed is another matter.
fn warnings(folder: &Path, name: &str, mesh: &TriangleMesh<Object>) -> Vec<String> {
    let model = folder.join(format!("{name}.stl"));
    std::fs::write(&model, stl_binary(mesh)).unwrap();
    let words = "--layer-height 0.2 --first-layer-height 0.2 --nozzle-diameter 0.4 --extrusion-width 0.45 --external-perimeter-extrusion-width 0.45 \
                 --filament-type PLA --skirts 0 --bed-shape 0x0,250x0,250x210,0x210 --loglevel 0";
    let run = Command::new("prusa-slicer")
        .arg("-g")
        .arg(&model)
        .arg("-o")
        .arg(folder.join(format!("{name}.gcode")))
        .args(words.split_whitespace())
        .output()
        .unwrap();
    assert!(run.status.success(), "{name}: {}", said(&run));
    let said = said(&run);
    // The model's name, and on the next line the causes.
    let mut lines = said.lines().skip_while(|line| !line.contains("print stability issues"));
    let causes = lines.find(|line| line.ends_with(".stl")).and_then(|_| lines.next()).unwrap_or_default();
    let causes = causes.split(", ").filter(|cause| !cause.is_empty() && !cause.contains("adhesion"));
    causes.map(str::to_owned).collect()
}

#[test]
fn what_hangs_is_what_prusa_slicer_warns_of() {
    let version = Command::new("prusa-slicer").arg("--help").output().map(|run| said(&run)).unwrap_or_default();
    let number = version.split("PrusaSlicer-").nth(1).and_then(|rest| {
        let mut parts = rest.split(['.', '+', ' ', '-']).map_while(|part| part.parse::<u32>().ok());
        Some((parts.next()?, parts.next()?))
    });
    if number.is_none_or(|number| number < (2, 6)) {
        return skip("PrusaSlicer 2.6 or newer, which warns of what hangs, is not there");
    }
    let folder = folder();
    let all: Vec<u64> = seeds(200, 1000).collect();
    let told = |&seed: &u64| {
        let (name, mesh) = shape(seed);
        let Judged { hangs, droops, .. } = grade(&mesh);
        let warned = warnings(folder.path(), &seed.to_string(), &mesh);
        let collapses = warned.iter().any(|cause| cause == "Collapsing overhang");
        let fine = hangs.is_empty() && droops.is_empty();
        assert!(!(fine && collapses), "seed {seed}, {name}: fine, and PrusaSlicer says {warned:?}");
        let ours = hangs
            .first()
            .map_or("nothing hangs".to_owned(), |patch| format!("{:.1} mm2 hang: {}", patch.area_mm2, patch.cause));
        (hangs.is_empty() != warned.is_empty())
            .then(|| format!("seed {seed}, {name}: {ours}; PrusaSlicer says {warned:?}"))
    };
    let differ: Vec<String> = all.par_iter().filter_map(told).collect();
    let agree = 1.0 - differ.len() as f64 / all.len() as f64;
    note(&format!("{} of {} shapes as PrusaSlicer has them", all.len() - differ.len(), all.len()));
    assert!(agree >= AGREE, "{:.1} % agree:\n{}", 100.0 * agree, differ.join("\n"));
}
