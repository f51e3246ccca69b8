//! Each print against its part: the layers, one by one, against the part's sections. Makes the checks of inside, layers, amounts, cover,
//! walls and place.

use super::machine::Pose;
use super::maths::{V, bounds, normal, unit};
use super::opinion::Check;
use super::parts::{Mesh, volume};
use super::scene::{Bead, Scene, microns};
use super::section::{Fit, Near, Section, raster_of};
use std::collections::BTreeMap;

/// How far the middle of a line may be outside of its part's section, mm.
const OUTSIDE_MM: f64 = 0.15;
/// Sections narrower than this are no faces but edges: one line fills them as it can, mm.
const FLAT_MM: f64 = 1.0;

/// A print and its part, machine coordinates, as the table stood when the first line was printed.
struct Laid<'a> {
    print: usize,
    pose: &'a Pose,
    mesh: Mesh,
    low: f64,
    high: f64,
    layers: Vec<Layer<'a>>,
}

struct Layer<'a> {
    /// Height of its top.
    top: f64,
    beads: Vec<&'a Bead>,
    /// The part's section at its middle.
    section: Section,
}

/// The checks of all prints.
pub fn check_prints(scene: &Scene<'_>) -> [Check; 6] {
    if scene.parts.is_none() {
        let names = ["inside", "layers", "amounts", "cover", "walls", "place"];
        return names.map(|name| Check::without(name, "there are no parts to compare with"));
    }
    let prints = laid(scene);
    let [walls, place] = check_walls(&prints);
    let [layers, amounts] = [check_layers(&prints, scene), check_amounts(&prints, scene.machine.filament_area)];
    [check_inside(&prints), layers, amounts, check_cover(&prints, scene), walls, place]
}

fn laid<'a>(scene: &'a Scene<'_>) -> Vec<Laid<'a>> {
    let print = |(print, layers): (usize, BTreeMap<i64, Vec<usize>>)| {
        let first = &scene.beads[*layers.values().next()?.first()?];
        let mesh = scene.mesh(first)?;
        let [[_, _, low], [_, _, high]] = bounds(mesh.iter().copied().flatten());
        let layer = |(z, beads): (i64, Vec<usize>)| {
            let beads: Vec<&Bead> = beads.into_iter().map(|index| &scene.beads[index]).collect();
            Layer { top: z as f64 / 1000.0, section: Section::new(&mesh, beads[0].middle()), beads }
        };
        let layers = layers.into_iter().map(layer).collect();
        Some(Laid { print, pose: scene.pose(first), low, high, layers, mesh })
    };
    scene.layers(false).into_iter().filter_map(print).collect()
}

fn check_inside(prints: &[Laid<'_>]) -> Check {
    let (mut check, mut worst) = (Check::new("inside"), 0.0_f64);
    for (print, layer) in prints.iter().flat_map(|laid| laid.layers.iter().map(|layer| (laid.print, layer))) {
        for bead in &layer.beads {
            let out = bead.places(0.5).map(|p| layer.section.outside(p)).fold(0.0, f64::max);
            worst = worst.max(out);
            check.line(bead.line, out <= OUTSIDE_MM, || format!("{out:.3} mm outside of the part of print {print}"));
        }
    }
    check.figure = format!("at most {worst:.3} mm outside");
    check
}

/// Layers follow each other without a gap, from the part's lowest point to its highest.
fn check_layers(prints: &[Laid<'_>], scene: &Scene<'_>) -> Check {
    let mut check = Check::new("layers");
    for Laid { print, pose, mesh, low, high, layers } in prints {
        let mut heights: Vec<f64> = layers.iter().map(|layer| layer.beads[0].height).collect();
        heights.sort_by(f64::total_cmp);
        let usual = heights[heights.len() / 2];
        let (first, half_overlap) = (layers[0].beads[0], scene.machine.overlap / 2.0);
        // A part that begins with an edge has no first layer at its height: slicers leave out what is narrower than a line.
        let is_flat = Section::new(mesh, low + usual / 4.0).mean_width() > FLAT_MM;
        let on_material = is_flat && pose.table(first.ends[0])[2] > 1.0;
        let off = (first.ends[0][2] - low - (usual - half_overlap)).abs() - half_overlap;
        check.line(first.line, !on_material || off <= 0.05, || {
            format!("the first layer of print {print} is {off:.3} mm off its height")
        });
        let mut below = *low;
        for (z, line) in layers.iter().map(|layer| (layer.top, layer.beads[0].line)).chain([(*high, 0)]) {
            let section = Section::new(mesh, (below + z) / 2.0);
            // What is hardly wider than a line may be left out.
            let is_wide = section.area() > 1.0 && section.mean_width() > 0.6;
            let most = if line > 0 { 1.5 } else { 0.7 } * usual;
            check.require(z - below <= most || !is_wide, || {
                format!("print {print}: no layer between {below:.3} and {z:.3} (line {line})")
            });
            check.line(line, z - below >= 0.3 * usual || line == 0, || {
                format!("only {:.3} mm above what is below", z - below)
            });
            below = z;
        }
    }
    check.figure = format!("{} layers", prints.iter().map(|laid| laid.layers.len()).sum::<usize>());
    check
}

/// Volume of filament against volume of parts, as a whole and in ten slices.
fn check_amounts(prints: &[Laid<'_>], filament_area: f64) -> Check {
    let (mut check, mut range) = (Check::new("amounts"), [f64::INFINITY, 0.0_f64]);
    for Laid { print, mesh, low, high, layers, .. } in prints {
        let mut slices = [0.0; 10];
        for bead in layers.iter().flat_map(|layer| &layer.beads) {
            let slice = ((bead.middle() - low) / (high - low) * 10.0).clamp(0.0, 9.0) as usize;
            slices[slice] += bead.e * filament_area;
        }
        let share = slices.iter().sum::<f64>() / volume(mesh);
        range = [range[0].min(share), range[1].max(share)];
        check.require((0.1..=1.12).contains(&share), || {
            format!("print {print}: filament for {:.0} % of its part", share * 100.0)
        });
        for (i, filled) in slices.iter().enumerate() {
            let middle = low + (high - low) * (i as f64 + 0.5) / 10.0;
            let whole = Section::new(mesh, middle).area() * (high - low) / 10.0;
            check.require(whole < 1.0 || *filled > 0.05 * whole, || {
                format!("print {print}: {filled:.1} of {whole:.1} mm3 in slice {i} of 10")
            });
        }
    }
    check.figure = format!("{:.0} to {:.0} % of the parts", range[0] * 100.0, range[1] * 100.0);
    check
}

/// First layers and flat faces shared with other parts are covered.
fn check_cover(prints: &[Laid<'_>], scene: &Scene<'_>) -> Check {
    let (mut check, mut least, mut count) = (Check::new("cover"), 1.0_f64, 0);
    for Laid { print, pose, layers, .. } in prints {
        let mut look = |what: &str, beads: &[&Bead], points: &[V]| {
            let share = Near::new(beads).covered(points);
            (least, count) = (least.min(share), count + 1);
            check.line(beads.first().map_or(0, |bead| bead.line), share >= 0.8, || {
                format!("print {print}: {:.0} % of {what} is covered", share * 100.0)
            });
        };
        let points = layers[0].section.raster(0.2);
        if points.len() > 25 && layers[0].section.mean_width() > FLAT_MM {
            look("its first layer", &layers[0].beads, &points);
        }
        let part = scene.plan.print(*print).map_or(0, |print| print.part);
        for (pair, faces) in scene.shared.iter().filter(|(pair, _)| pair.contains(&part)) {
            let mut by_height = BTreeMap::<i64, Vec<V>>::new();
            for face in faces {
                let face: Vec<V> = face.iter().map(|p| pose.machine(*p)).collect();
                if unit(normal([face[0], face[1], face[2]]))[2].abs() > 0.9999 {
                    by_height.entry(microns(face[0][2])).or_default().extend(raster_of(&face, 0.2));
                }
            }
            let other = pair[usize::from(pair[0] == part)];
            for (z, points) in by_height.iter().filter(|(_, points)| points.len() > 25) {
                let off = |bead: &Bead| (bead.middle() - *z as f64 / 1000.0).abs() - 0.75 * bead.height;
                match layers.iter().find(|layer| off(layer.beads[0]) <= 0.0) {
                    Some(layer) => look(&format!("the joint with part {other}"), &layer.beads, points),
                    None => look(&format!("the joint with part {other}, which has no layer,"), &[], points),
                }
            }
        }
    }
    check.figure = format!("{count} faces, at least {:.0} %", least * 100.0);
    check
}

/// The outline of each layer has a line beside it, and its lines' edges are where the outline is.
fn check_walls(prints: &[Laid<'_>]) -> [Check; 2] {
    let (mut walls, mut place) = (Check::new("walls"), Check::new("place"));
    let (mut barest, mut worst, mut worst_layer) = (0.0_f64, 0.0_f64, 0.0_f64);
    for Laid { print, layers, .. } in prints {
        let mut whole = Fit::default();
        for layer in layers {
            let (near, mut fit, mut bare) = (Near::new(&layer.beads), Fit::default(), 0.0);
            for (p, out) in layer.section.outline() {
                if near.least(p, |_| 0.0) > 0.55 {
                    bare += 0.5;
                } else {
                    fit.add(out, near.least(p, |bead| bead.width / 2.0));
                }
            }
            whole.join(&fit);
            let off = fit.shift();
            (barest, worst_layer) = (barest.max(bare), worst_layer.max(off));
            walls.line(layer.beads[0].line, bare <= 2.0, || {
                format!("print {print}: {bare:.1} mm of the layer's outline without a line")
            });
            place.line(layer.beads[0].line, off <= 0.1, || {
                format!("print {print}: this layer is shifted by {off:.3} mm")
            });
        }
        let off = whole.shift();
        worst = worst.max(off);
        place.require(off <= 0.03, || format!("print {print} is shifted by {off:.3} mm"));
    }
    walls.figure = format!("at most {barest:.1} mm of a layer's outline without a line");
    place.figure = format!("shifted by at most {worst:.3} mm, a layer by {worst_layer:.3} mm");
    [walls, place]
}
