//! Joints that are printed in place, of the kinds that people draw, from one file to a verified one: parts stay apart by the gap as it was drawn, in the
//! lines of the file as well, what hangs of a captive part stands on the table, or the refusal says which part is caught and what to do.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::filled::moves::{Step, steps};
use crate::split::solids::{Shape, ball, block, rod, turned};
use crate::support::{every, folder as new_folder, said, trunnion};

/// A cube in a closed cell, with the gap on all sides.
fn cell(gap: f64) -> [Shape; 2] {
    let (inner, room) = (8.0, 8.0 + 2.0 * gap);
    let hull = block(16.0, 16.0, 4.0 + room).less(&block(room, room, room).at(4.0 - gap, 4.0 - gap, 2.0));
    [block(inner, inner, inner).at(4.0, 4.0, 2.0 + gap), hull]
}

/// An axle that lies in the bore of a block, and whose ends stand out of it by 5 mm.
fn axle(gap: f64) -> [Shape; 2] {
    let lying = |radius: f64, length: f64| rod(radius, length, 48).at(0.0, 0.0, -length / 2.0).about_y(90.0);
    let hull = block(20.0, 20.0, 12.0).at(-10.0, -10.0, 0.0).less(&lying(4.0 + gap, 60.0).at(0.0, 0.0, 6.0));
    [lying(4.0, 30.0).at(0.0, 0.0, 6.0), hull]
}

/// Two rings that hold each other by a ridge, lying on their side: the inner one stands on nothing.
fn bearing_on_edge(gap: f64) -> [Shape; 2] {
    let ring = |outer: &[[f64; 2]]| turned(outer, 48).at(0.0, 0.0, -4.0).about_y(90.0).at(0.0, 0.0, 13.0);
    let inner = turned(&[[7.0, 0.0], [9.0, 4.0], [7.0, 8.0]], 48).less(&rod(4.0, 30.0, 48).at(0.0, 0.0, -5.0));
    let hole = [[7.0 + gap, -1.0], [7.0 + gap, 0.0], [9.0 + gap, 4.0], [7.0 + gap, 8.0], [7.0 + gap, 9.0]];
    let outer = rod(13.0, 8.0, 96).at(0.0, 0.0, -4.0).about_y(90.0).at(0.0, 0.0, 13.0).less(&ring(&hole));
    [inner.at(0.0, 0.0, -4.0).about_y(90.0).at(0.0, 0.0, 13.0), outer]
}

/// A ball in a socket that goes over its middle; the ball stands on a flat.
fn ball_in_socket(gap: f64) -> [Shape; 2] {
    let whole = ball(6.0, 48);
    let flat = block(20.0, 20.0, 20.0).at(-10.0, -10.0, -25.0);
    let inner = whole.less(&flat).at(0.0, 0.0, 5.0);
    let socket = rod(9.0, 10.0, 64).less(&ball(6.0 + gap, 48).at(0.0, 0.0, 5.0));
    [inner, socket]
}

/// A link of a chain that lies in one that stands, and reaches far beyond it.
fn chain(gap: f64) -> [Shape; 2] {
    let link = || block(24.0, 14.0, 4.0).less(&block(16.0, 6.0, 6.0).at(4.0, 4.0, -1.0));
    let lies = link().at(16.0 - gap, -7.0, 4.0 + gap);
    let stands = block(24.0, 4.0, 14.0).less(&block(16.0, 6.0, 6.0).at(4.0, -1.0, 4.0)).at(0.0, -2.0, 0.0);
    [lies, stands]
}

/// Where what is captive is.
#[derive(Clone, Copy, PartialEq)]
enum Lies {
    /// On the table: it is not captive, since it stands.
    OnTable,
    /// On what is around it.
    InJoint,
    /// On supports that stand on the table, with some of it.
    OnSupports,
}

struct Kind {
    name: &'static str,
    of: fn(f64) -> [Shape; 2],
    /// The first part.
    lies: Lies,
    /// From this gap on the part that floats is too high above the other one.
    refused_from: f64,
}

const KINDS: [Kind; 5] = [
    Kind { name: "cell", of: cell, lies: Lies::InJoint, refused_from: 0.45 },
    Kind { name: "axle", of: axle, lies: Lies::OnSupports, refused_from: f64::INFINITY },
    Kind { name: "bearing", of: bearing_on_edge, lies: Lies::InJoint, refused_from: f64::INFINITY },
    Kind { name: "ball", of: ball_in_socket, lies: Lies::OnTable, refused_from: f64::INFINITY },
    Kind { name: "chain", of: chain, lies: Lies::OnSupports, refused_from: f64::INFINITY },
];

fn written(folder: &Path, name: &str, shapes: &[Shape]) {
    let meshes: Vec<_> = shapes.iter().map(Shape::mesh).collect();
    fs::write(folder.join(name), trunnion::mesh::stl_binary_parts(&meshes.iter().collect::<Vec<_>>())).unwrap();
}

#[test]
fn what_is_caught_is_printed_in_place() {
    let folder = new_folder();
    let here = folder.path();
    // In the suite every third size of each.
    for (place, kind) in KINDS.iter().enumerate() {
        let gaps = [0.1, 0.15, 0.2, 0.3, 0.4, 0.5];
        for gap in gaps.into_iter().skip(place % every(3)).step_by(every(3)) {
            let (name, file) = (format!("{} {gap}", kind.name), format!("{}.stl", kind.name));
            written(here, &file, &(kind.of)(gap));
            let inspected = trunnion().current_dir(here).args(["inspect", &file, "--json"]).output().unwrap();
            let model: Value = serde_json::from_slice(&inspected.stdout).unwrap();
            let captive = if kind.lies == Lies::OnTable { serde_json::json!([]) } else { serde_json::json!([0]) };
            assert_eq!((&model["captive"], &model["floating"]), (&captive, &serde_json::json!([])), "{name}: {model}");
            let args = ["prepare", &file, "-m", "generic-ac", "--slicer", "builtin", "-o", "out.gcode", "--json"];
            let done = trunnion().current_dir(here).args(args).output().unwrap();
            if gap >= kind.refused_from {
                assert!(!done.status.success() && !here.join("out.gcode").exists(), "{name}");
                let refused: Value = serde_json::from_slice(&done.stdout).unwrap();
                let code_of = |way: &str| {
                    let mut ways = refused["ways"].as_array().unwrap().iter();
                    ways.find(|tried| tried["way"] == way).map(|tried| tried["code"].clone())
                };
                assert_eq!(code_of("supports"), Some("way/captive".into()), "{name}: {refused}");
                let remedies: Vec<&Value> = refused["remedies"].as_array().unwrap().iter().collect();
                let gap = remedies.iter().find(|one| one["kind"] == "joint").expect("what to draw otherwise");
                assert!((gap["amount"].as_f64().unwrap() - 2.5 * LAYER_MM).abs() < 1e-9, "{gap}");
                assert!(remedies.iter().all(|one| one["kind"] != "support"), "nobody could take it out: {remedies:?}");
                continue;
            }
            assert!(done.status.success(), "{name}: {}", said(&done));
            // Nothing was moved to meet, and one pose prints both.
            assert!(!here.join("out.parts.3mf").exists(), "{name}");
            let document: Value = serde_json::from_slice(&done.stdout).unwrap();
            assert_eq!(document["plan"]["slots"].as_array().unwrap().len(), 1, "{name}");
            assert_eq!(document["plan"]["captive"], captive, "{name}");
            let joints = document["verify"]["joints"].as_array().unwrap();
            let [joint] = &joints[..] else { panic!("{name}: {joints:?}") };
            assert_eq!(joint["parts"], serde_json::json!([0, 1]), "{name}");
            let told = joint["gap_mm"].as_f64().unwrap();
            let lines: Vec<Line> =
                steps(&fs::read_to_string(here.join("out.gcode")).unwrap()).into_iter().filter_map(Line::of).collect();
            let held = document["plan"]["slots"][0]["prints"][0].get("supports").is_some_and(|one| !one.is_null());
            assert_eq!(held, kind.lies == Lies::OnSupports, "{name}");
            if held {
                all_stand_on_the_table(&lines, name.as_str());
            }
            let measured = least_room(&lines);
            assert!((told - measured).abs() < 0.03, "{name}: {told} mm told, {measured} mm measured");
            // Lines follow a curved wall up to a few hundredths; what is fused has no room at all.
            assert!(measured > gap - 0.06, "{name}: {measured} mm between the lines");
            fs::remove_file(here.join("out.gcode")).unwrap();
        }
    }
}

/// An axle that stands on feet beside its block is no captive part, and nothing can be removed from its bore either.
#[test]
fn nothing_is_left_in_the_bore_of_an_axle_that_stands() {
    let folder = new_folder();
    let here = folder.path();
    let lying = |radius: f64, length: f64| rod(radius, length, 48).at(0.0, 0.0, -length / 2.0).about_y(90.0);
    let foot = |x: f64| block(3.0, 8.0, 6.0).at(x, -4.0, 0.0);
    for (gap, is_printed) in [(0.3, true), (0.8, false)] {
        let hull = block(20.0, 20.0, 12.0).at(-10.0, -10.0, 0.0).less(&lying(4.0 + gap, 60.0).at(0.0, 0.0, 6.0));
        let axle = lying(4.0, 36.0).at(0.0, 0.0, 6.0).and(&foot(-18.0)).and(&foot(15.0));
        written(here, "feet.stl", &[axle, hull]);
        let args = ["prepare", "feet.stl", "-m", "generic-ac", "--slicer", "builtin", "-o", "out.gcode", "--json"];
        let done = trunnion().current_dir(here).args(args).output().unwrap();
        assert_eq!(done.status.success(), is_printed, "{gap}: {}", said(&done));
        if is_printed {
            let lines: Vec<Line> =
                steps(&fs::read_to_string(here.join("out.gcode")).unwrap()).into_iter().filter_map(Line::of).collect();
            // Of the axle, whose middle is that of both parts: below it, in the bore, no supports.
            let all = lines.iter().filter(|line| line.print < 2).flat_map(|line| [line.from, line.to]);
            let (low, high) = all.fold(([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]), |(low, high), p| {
                ([0, 1].map(|i| low[i].min(p[i])), [0, 1].map(|i| high[i].max(p[i])))
            });
            let middle = [0, 1].map(|i| f64::midpoint(low[i], high[i]));
            let in_bore = |line: &&Line| {
                let at = [0, 1].map(|i| f64::midpoint(line.from[i], line.to[i]) - middle[i]);
                line.print >= 2 && at[0].abs() < 9.0 && at[1].abs() < 4.0 && (1.4..2.6).contains(&(line.z - lines[0].z))
            };
            assert_eq!(lines.iter().filter(in_bore).count(), 0);
            fs::remove_file(here.join("out.gcode")).unwrap();
        } else {
            let refused: Value = serde_json::from_slice(&done.stdout).unwrap();
            let supports = refused["ways"].as_array().unwrap().iter().find(|tried| tried["way"] == "supports").unwrap();
            assert_eq!(supports["code"], "way/captive", "{supports}");
            assert!(!here.join("out.gcode").exists());
        }
    }
}

/// Each line of the supports of the first print has another one just below it, down to the table: none of them is caught in the joint.
fn all_stand_on_the_table(lines: &[Line], name: &str) {
    let supports: Vec<&Line> = lines.iter().filter(|line| line.print == 2).collect();
    let lowest = lines.iter().map(|line| line.z).fold(f64::INFINITY, f64::min);
    assert!(supports.iter().any(|line| line.z > 5.0 * LAYER_MM), "{name}: no supports");
    for line in supports.iter().filter(|line| line.z > lowest + LAYER_MM / 2.0) {
        let middle = [0, 1].map(|i| f64::midpoint(line.from[i], line.to[i]));
        let is_below = |under: &&&Line| (1e-3..1.5 * LAYER_MM).contains(&(line.z - under.z));
        let below = supports.iter().filter(is_below).map(|under| distance(middle, under.from, under.to));
        let room = below.fold(f64::INFINITY, f64::min);
        assert!(room < line.width, "{name}: a support at Z {} has {room} mm to what is below", line.z);
    }
}

/// The least room between the lines of two prints at one height, seen from above, mm: places along one against the lines of the other.
fn least_room(lines: &[Line]) -> f64 {
    let parts = lines.iter().filter(|line| line.print < 2);
    let (one, other): (Vec<&Line>, Vec<&Line>) = parts.partition(|line| line.print == 0);
    assert!(!one.is_empty() && !other.is_empty());
    let mut least = f64::INFINITY;
    for line in one {
        for against in other.iter().filter(|against| (against.z - line.z).abs() < LAYER_MM / 2.0) {
            for step in 0..=8 {
                let t = f64::from(step) / 8.0;
                let at = [0, 1].map(|i| line.from[i] + t * (line.to[i] - line.from[i]));
                least = least.min(distance(at, against.from, against.to) - (line.width + against.width) / 2.0);
            }
        }
    }
    least
}

/// Filament of 1.75 mm, mm², and the profile's layers, mm.
const FILAMENT_MM2: f64 = std::f64::consts::PI / 4.0 * 1.75 * 1.75;
const LAYER_MM: f64 = 0.2;

/// A printed line, seen from above, mm.
struct Line {
    from: [f64; 2],
    to: [f64; 2],
    z: f64,
    /// Of a rectangle with round sides.
    width: f64,
    print: usize,
}

impl Line {
    fn of(step: Step) -> Option<Self> {
        let [from, to] = [step.from, step.to].map(|p| [p[0], p[1]]);
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let width = step.e * FILAMENT_MM2 / length / LAYER_MM + LAYER_MM * (1.0 - std::f64::consts::FRAC_PI_4);
        (step.e > 0.0 && length > 0.05).then_some(Self { from, to, z: step.to[2], width, print: step.print })
    }
}

fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length = along[0].hypot(along[1]).max(1e-12);
    let t = ((along[0] * to[0] + along[1] * to[1]) / (length * length)).clamp(0.0, 1.0);
    (to[0] - t * along[0]).hypot(to[1] - t * along[1])
}
