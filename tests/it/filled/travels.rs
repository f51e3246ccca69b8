//! What a sliced file does between its lines: travels, where they run, retractions, and how bridges are held at their ends. From the
//! moves and the mesh alone.

use std::fmt;

use trunnion::geom::Slot;
use trunnion::mesh::TriangleMesh;
use trunnion::slicing::{Adhesion, BuiltIn, SliceJob, SliceSettings, Slicer};

use super::moves::{Step, steps};
use super::raster::{cut, spans};
use super::shapes::{self, Named};
use super::{prusa_slicer, skip};
use crate::support::{every, folder, note};

/// So much filament may be pulled back and forth ten times, mm: more often, and the gear grinds it.
const GRINDS_MM: f64 = 5.0;
/// A line that is in the air for less is no bridge, mm.
const SHORTEST_SPAN_MM: f64 = 1.0;

/// What was counted over all layers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Travels {
    pub(crate) count: usize,
    pub(crate) length: f64,
    /// Of that the middle of the tip is not over the layer's section, mm.
    pub(crate) outside: f64,
    pub(crate) pulls: usize,
    /// The most of them within 5 mm of filament.
    pub(crate) close: usize,
    /// How far the ends of lines over air lie on the layer below, mm, ascending.
    pub(crate) anchors: Vec<f64>,
}

impl Travels {
    /// The anchor that one of twenty does not reach, mm.
    pub(crate) fn anchor(&self) -> Option<f64> {
        self.anchors.get(self.anchors.len() / 20).copied()
    }
}

impl fmt::Display for Travels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, length, outside, pulls, close, .. } = self;
        let anchor = self.anchor().map_or("-".to_owned(), |mm| format!("{mm:.2}"));
        write!(f, "{count:7} {length:9.0} {outside:9.0} {pulls:6} {close:5} {anchor:>6}")
    }
}

/// Counts what a file does with this mesh, layers `height` thick.
pub(crate) fn travels(mesh: &TriangleMesh<Slot>, gcode: &str, height: f64) -> Travels {
    let mut sum = Travels::default();
    let steps = steps(gcode);
    let first = steps.iter().position(|s| s.e > 0.0 && length(s) > 0.0).unwrap_or(0);
    let (mut laid, mut pulled) = (0.0, Vec::new());
    let (mut z, mut section, mut below) = (f64::NAN, Vec::new(), Vec::new());
    let mut goes = false;
    for step in &steps[first..] {
        if z.is_nan() || (step.to[2] - z).abs() > height / 4.0 {
            z = step.to[2];
            section = cut(mesh, z - height / 2.0);
            below = cut(mesh, z - 1.5 * height);
        }
        let long = length(step);
        if step.e < 0.0 {
            sum.pulls += 1;
            pulled.push(laid);
        } else if step.e > 0.0 && long > 0.0 {
            laid += step.e;
            goes = false;
            if step.bridge {
                sum.anchors.extend(anchors(&below, step));
            }
        } else if long > 0.0 {
            sum.count += usize::from(!goes);
            goes = true;
            sum.length += long;
            sum.outside += long - inside(&section, step).iter().map(|[a, b]| b - a).sum::<f64>();
        }
    }
    let within = |i: usize| pulled[i..].iter().take_while(|at| **at - pulled[i] <= GRINDS_MM).count();
    sum.close = (0..pulled.len()).map(within).max().unwrap_or(0);
    sum.anchors.sort_by(f64::total_cmp);
    sum
}

fn length(step: &Step) -> f64 {
    (step.to[0] - step.from[0]).hypot(step.to[1] - step.from[1])
}

/// Where along a move the section lies below it, mm from its beginning.
fn inside(section: &[[[f64; 2]; 2]], step: &Step) -> Vec<[f64; 2]> {
    let long = length(step);
    let along = [0, 1].map(|i| (step.to[i] - step.from[i]) / long);
    let seen = |p: [f64; 2]| {
        let v = [p[0] - step.from[0], p[1] - step.from[1]];
        [v[0] * along[0] + v[1] * along[1], v[1] * along[0] - v[0] * along[1]]
    };
    let turned: Vec<[[f64; 2]; 2]> = section.iter().map(|segment| segment.map(seen)).collect();
    let mut found = Vec::new();
    spans(&turned, 0.0, |from, to| {
        let (from, to) = (from.max(0.0), to.min(long));
        if to > from {
            found.push([from, to]);
        }
    });
    found
}

/// How far both ends of a line over air lie on what is below; nothing of a line that is not over air between them.
fn anchors(below: &[[[f64; 2]; 2]], step: &Step) -> Vec<f64> {
    let held = inside(below, step);
    let long = length(step);
    let on: f64 = held.iter().map(|[a, b]| b - a).sum();
    let (Some(first), Some(last)) = (held.first(), held.last()) else { return Vec::new() };
    // An end in the air is none of a bridge, but of a ledge.
    let ends = first[0] < 1e-6 && last[1] > long - 1e-6;
    if long - on < SHORTEST_SPAN_MM || !ends {
        return Vec::new();
    }
    vec![first[1] - first[0], last[1] - last[0]]
}

fn counted(slicer: &dyn Slicer, shape: &Named, infill: f64) -> Travels {
    let job =
        SliceJob { name: shape.name.clone(), on_table: false, bed_mm: [200.0, 200.0], adhesion: Adhesion::default() };
    let settings = SliceSettings { infill, ..SliceSettings::default() };
    let gcode = slicer.slice(&shape.mesh, &settings, &job).unwrap_or_else(|e| panic!("{}: {e}", shape.name)).gcode;
    travels(&shape.mesh, &String::from_utf8(gcode).unwrap(), settings.layer_height_mm)
}

fn shapes() -> Vec<Named> {
    shapes::all().into_iter().chain(shapes::bridging()).chain(shapes::pins().into_iter().take(1)).collect()
}

/// Shapes of several islands, between which every way leads over air, and those of which some ways do for another reason.
fn ways_over_air(name: &str) -> bool {
    let islands = ["text", "maze", "holes lying", "bridge", "slant notch", "pins on a plate"];
    // In the tips of fins and of the star there is room for one thin bead, and the way round may be too long; so it is round the pit.
    islands.contains(&name) || ["fins", "star", "gear", "pit"].contains(&name)
}

#[test]
fn ways_stay_inside_and_the_filament_is_seldom_pulled() {
    let mut wrong = Vec::new();
    for infill in [0.2, 1.0] {
        for shape in shapes() {
            let found = counted(&BuiltIn, &shape, infill);
            let anchored = !["bridge", "pit", "slant notch"].contains(&&*shape.name) || found.anchor() >= Some(1.5);
            if found.close > 10 || (found.outside > 0.5 && !ways_over_air(&shape.name)) || !anchored {
                wrong.push(format!("{:20}{found}", shape.name));
            }
        }
    }
    assert!(wrong.is_empty(), "beyond their bounds:\n{}", wrong.join("\n"));
}

/// Travel beside PrusaSlicer's, at most. Aimed for is 1.1 times; where that is missed the reason stands beside the bound.
fn most_travel(name: &str) -> f64 {
    match name {
        // Thin beads in tips and teeth, which PrusaSlicer leaves open, are gone to one by one.
        "gear" => 2.7,
        "star" => 3.1,
        "overlapping bodies" => 1.3,
        // Its lines run along it, and the last one ends at its tip.
        "wedge 20" => 1.35,
        "wedge 30" => 1.2,
        // The seam stays at the rear of every layer; sparse lines begin and end an eighth and three eighths of the way round from it.
        "cylinder" | "sphere" => 1.25,
        // One line beside the walls leads away from the seam, and the nozzle must go back: 18 mm a layer.
        "wall 2" => 14.0,
        _ => 1.1,
    }
}

#[test]
fn the_filament_is_pulled_no_more_often_than_by_an_ordinary_slicer() {
    let folder = folder();
    let Some(prusa) = prusa_slicer(folder.path()) else { return skip("prusa-slicer is not installed") };
    let head = "                      travels       mm  outside  pulls in 5 mm anchor";
    let mut table = vec![head.to_owned()];
    let mut wrong = Vec::new();
    for shape in shapes().into_iter().step_by(every(4)) {
        let [ours, theirs] = [&BuiltIn as &dyn Slicer, &*prusa].map(|slicer| counted(slicer, &shape, 0.2));
        let row = format!("{:20}{ours}\n      PrusaSlicer   {theirs}", shape.name);
        if ours.pulls as f64 > 1.3 * theirs.pulls as f64 || ours.length > most_travel(&shape.name) * theirs.length {
            wrong.push(row.clone());
        }
        table.push(row);
    }
    note(&table.join("\n"));
    assert!(wrong.is_empty(), "beyond their bounds:\n{}", wrong.join("\n"));
}

#[test]
fn what_is_counted_is_what_stands_in_the_file() {
    let shape = shapes::walls(&[2.0]).remove(0);
    // 2 x 20 mm about (100, 100): one line, 3 mm inside, then 6 mm of which 2 lie outside, pulled back for the second.
    let gcode = "M83\nG1 X99.5 Y95 Z0.2 F600\nG1 X99.5 Y100 E0.2\nG1 X99.5 Y103 F9000\nG1 X99.5 Y104 E0.1 F600\nG1 E-1\n\
                 G1 X103 Y104 F9000\nG1 X100.5 Y104 F9000\nG1 E1\nG1 X100.5 Y100 E0.2\n";
    let found = travels(&shape.mesh, gcode, 0.2);
    assert_eq!((found.count, found.pulls, found.close), (2, 1, 1));
    assert!((found.length - 9.0).abs() < 1e-9 && (found.outside - 4.0).abs() < 1e-9, "{found:?}");
    let line = "M83\nG1 X99.5 Y95 Z0.2 F600\nG1 X99.5 Y100 E0.2\n";
    let often = format!("{line}{}", "G1 E-1\nG1 E1\nG1 Y100.1 E0.4\nG1 Y100 E0.4\n".repeat(20));
    // 5 mm of filament hold the seven ends of six stretches of 0.8 mm.
    assert_eq!(travels(&shape.mesh, &often, 0.2).close, 7);
    let deck = shapes::bridging().remove(0);
    let across = "M83\n;TYPE:Bridge infill\nG1 X94 Y100 Z3.2 F600\nG1 X105.5 Y100 E0.5\n";
    let anchors = travels(&deck.mesh, across, 0.2).anchors;
    assert!(anchors.len() == 2 && (anchors[0] - 1.5).abs() < 1e-9 && (anchors[1] - 2.0).abs() < 1e-9, "{anchors:?}");
}
