//! Supports in finished files: roof and struts by the judge's figures, and what is taken away from below a part is seen there and nowhere
//! else.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use trunnion::mesh::{stl_binary, stl_binary_parts};

use super::judge::{Layer, Measures, Ruler, Triangle, lines_of, supports};
use super::rivals::FILAMENT_MM;
use crate::split::solids::{Shape, block};
use crate::support::{folder, note, said, trunnion};

const LAYER_MM: f64 = 0.2;

/// A post with a narrow beam, high up.
fn gallows() -> Shape {
    block(10.0, 10.0, 44.0).and(&block(46.0, 10.0, 5.0).at(0.0, 0.0, 39.0))
}

fn run(folder: &Path, args: &[&str]) -> Output {
    trunnion().current_dir(folder).args(args).output().unwrap()
}

fn prepared(folder: &Path, more: &[&str]) -> Output {
    let args = ["prepare", "solid.stl", "-m", "generic-ac", "--slicer", "builtin", "--way", "supports"];
    run(folder, &[&args[..], &["-o", "out.gcode", "--plan-out", "out.json", "--json"], more].concat())
}

/// The file's supports in the solid's own frame: its outer walls have the solid's middle, its first layer stands on the table.
fn in_place(text: &str, shape: &Shape) -> (Vec<Layer>, Vec<Triangle>) {
    let walls = lines_of(text, FILAMENT_MM, &|role| role == "External perimeter");
    let ends = |k: usize| {
        let all = walls.iter().flat_map(|layer| &layer.lines).flat_map(|line| [line.from[k], line.to[k]]);
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    };
    let mesh = shape.mesh();
    let bounds = mesh.bounds();
    let shift = [0, 1].map(|k| (bounds.min[k] + bounds.max[k] - ends(k)[0] - ends(k)[1]) / 2.0);
    let lift = LAYER_MM - walls[0].top_mm;
    let mut layers = supports(text, FILAMENT_MM);
    for layer in &mut layers {
        layer.top_mm += lift;
        for line in &mut layer.lines {
            [&mut line.from, &mut line.to].into_iter().for_each(|end| (0..2).for_each(|k| end[k] += shift[k]));
        }
    }
    let surface = (0..mesh.facets().len()).map(|facet| mesh.corners(facet).map(|v| [v.x, v.y, v.z])).collect();
    (layers, surface)
}

fn measured(folder: &Path, shape: &Shape, more: &[&str]) -> (Measures, Value) {
    let done = prepared(folder, more);
    assert!(done.status.success(), "{more:?}: {}", said(&done));
    let text = fs::read_to_string(folder.join("out.gcode")).unwrap();
    let verify = run(folder, &["verify", "out.gcode", "--plan", "out.json"]);
    assert!(verify.status.success(), "{more:?}: {}", said(&verify));
    let (layers, surface) = in_place(&text, shape);
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    let pitch_mm = document["supports"]["parts"][0]["step_mm"].as_f64().unwrap();
    let ruler = Ruler { pitch_mm, line_mm: 0.45, layer_mm: LAYER_MM, overhang_deg: 45.0 };
    let measures = ruler.measure(&surface, &layers);
    note(&format!("{more:?}: {measures:?}"));
    fs::remove_file(folder.join("out.gcode")).unwrap();
    (measures, document)
}

#[test]
fn roof_and_struts_are_what_the_judge_sees() {
    let folder = folder();
    let (here, shape) = (folder.path(), gallows());
    fs::write(here.join("solid.stl"), stl_binary(&shape.mesh())).unwrap();
    let (plain, document) = measured(here, &shape, &["--brace", "0"]);
    assert_eq!(document["supports"]["parts"][0]["brace_mm"], Value::Null);
    assert_eq!(document["supports"]["parts"][0]["roof"], Value::Null);
    assert!(plain.covered > 0.99 && plain.alone_mm > 25.0, "{plain:?}");
    for brace in [20.0, 12.0, 6.0] {
        let (tied, document) = measured(here, &shape, &["--brace", &brace.to_string()]);
        let part = &document["supports"]["parts"][0];
        assert!(part["longest_free_mm"].as_f64().unwrap() <= brace, "{part}");
        assert_eq!(part["brace_mm"], brace);
        let step = part["step_mm"].as_f64().unwrap();
        // The judge sees a strut begin and end a level later than the grid says.
        assert!(tied.alone_mm <= brace + 2.0 * step, "--brace {brace}: {tied:?}");
        assert!(tied.alone_mm < plain.alone_mm && tied.covered > 0.99, "--brace {brace}: {tied:?}");
    }
    // A level ceiling is no farther from a line than half a pitch, and half a line more where rows end beside its border.
    for (pitch, roof) in [("0.9", "0.2"), ("0.9", "0.6"), ("1.5", "0.4")] {
        let (roofed, document) = measured(here, &shape, &["--roof", roof, "--roof-pitch", pitch]);
        let told = &document["plan"]["slots"][0]["prints"][0]["supports"];
        assert_eq!(told["roof"]["pitch_mm"].as_f64(), pitch.parse().ok(), "{told}");
        let most = pitch.parse::<f64>().unwrap() / 2.0 + 0.5;
        assert!(roofed.widest_mm < most && most < plain.widest_mm, "{pitch}: {roofed:?}, {plain:?}");
        assert!(roofed.covered > 0.99, "{pitch}: {roofed:?}");
    }
}

/// Supports go around a loose part that grows beside theirs, and stand on it; where there are no more than two layers of air between the two it carries by itself.
#[test]
fn supports_stand_on_a_part_of_its_own_below() {
    let folder = folder();
    let here = folder.path();
    // A post of 40 mm with an arm, whose underside is at 39 mm; and a loose post below the arm, 25 to 35 mm from where that begins.
    let (shape, under, [near, far]) = (gallows(), 39.0, [25.0, 35.0]);
    for gap in [0.3, 0.4, 0.75, 1.5, 8.0] {
        let post = block(far - near, 10.0, under - gap).at(near, 0.0, 0.0);
        fs::write(here.join("solid.stl"), stl_binary_parts(&[&shape.mesh(), &post.mesh()])).unwrap();
        let done = prepared(here, &["--snap", "0"]);
        assert!(done.status.success(), "{gap}: {}", said(&done));
        let text = fs::read_to_string(here.join("out.gcode")).unwrap();
        fs::remove_file(here.join("out.gcode")).unwrap();
        let (box_of, post) = (shape.mesh().bounds(), post.mesh().bounds());
        // All outer walls together have the box of both parts.
        let walls = lines_of(&text, FILAMENT_MM, &|role| role == "External perimeter");
        let ends = walls.iter().flat_map(|layer| &layer.lines).flat_map(|line| [line.from, line.to]);
        let [low, high] = ends.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], p| {
            [[0, 1].map(|k| low[k].min(p[k])), [0, 1].map(|k| high[k].max(p[k]))]
        });
        let all = box_of.union(&post);
        let shift = [0, 1].map(|k| (all.min[k] + all.max[k] - low[k] - high[k]) / 2.0);
        let (lift, mut on_it) = (LAYER_MM - walls[0].top_mm, 0.0);
        for layer in supports(&text, FILAMENT_MM) {
            let top = layer.top_mm + lift;
            for line in &layer.lines {
                let middle = [0, 1].map(|k| (line.from[k] + line.to[k]) / 2.0 + shift[k]);
                let inside = (0..2).all(|k| (post.min[k]..post.max[k]).contains(&middle[k]));
                assert!(!inside || top > under - gap + 0.5 * LAYER_MM, "{gap}: within the post at {top}");
                on_it += if inside { line.mm3 } else { 0.0 };
            }
        }
        note(&format!("a post {gap} mm below an arm: {on_it:.2} mm3 of supports on it"));
        assert_eq!(on_it > 0.0, gap > 2.5 * LAYER_MM, "{gap}: {on_it} mm3 stand on the post");
    }
}

#[test]
fn what_no_roof_and_no_strut_can_be_is_said() {
    let folder = folder();
    let here = folder.path();
    fs::write(here.join("solid.stl"), stl_binary(&gallows().mesh())).unwrap();
    let plan = ["plan", "solid.stl", "-m", "generic-ac", "-o", "plan.json"];
    let cases: [(&[&str], &[&str]); 7] = [
        (&["--roof", "0.4"], &["--roof shapes supports", "--supports auto"]),
        (&["--brace", "9"], &["--brace shapes supports", "--supports auto"]),
        (&["--supports", "auto", "--roof", "6"], &["--roof", "0 and 5", "got 6 mm"]),
        (&["--supports", "auto", "--roof", "nan"], &["--roof", "0 and 5", "got NaN mm"]),
        (&["--supports", "auto", "--roof", "1", "--roof-pitch", "20"], &["--roof-pitch", "0.1 and 10", "got 20 mm"]),
        (&["--supports", "auto", "--brace", "4"], &["--brace", "5 and 1000", "got 4 mm"]),
        (&["--supports", "auto", "--brace", "-1"], &["--brace", "5 and 1000", "got -1 mm"]),
    ];
    for (more, wanted) in cases {
        let done = run(here, &[&plan[..], more].concat());
        assert_eq!(done.status.code(), Some(2), "{more:?}: {}", said(&done));
        assert!(wanted.iter().all(|word| said(&done).contains(word)), "{more:?}: {}", said(&done));
        assert!(!here.join("plan.json").exists());
    }
    let done = run(here, &[&plan[..], &["--supports", "auto", "--roof", "0.4"]].concat());
    assert!(done.status.success(), "{}", said(&done));
    let text = fs::read_to_string(here.join("plan.json")).unwrap();
    let cases = [
        ("/roof/height_mm", "0", "between 0.01 and 5"),
        ("/roof/pitch_mm", "99", "between 0.1 and 10"),
        ("/brace_mm", "1", "between 2 and 1000"),
    ];
    for (key, value, says) in cases {
        let mut document: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(document["version"], 3);
        let at = format!("/slots/0/prints/0/supports{key}");
        *document.pointer_mut(&at).unwrap() = serde_json::from_str(value).unwrap();
        fs::write(here.join("bad.json"), document.to_string()).unwrap();
        let done = run(here, &["slice", "bad.json", "-o", "slots"]);
        assert!(said(&done).contains(says) && done.status.code() == Some(2), "{key}: {}", said(&done));
    }
}

/// The number behind `letter` in a line.
fn number(line: &str, letter: char) -> Option<f64> {
    line.split(' ').find_map(|word| word.strip_prefix(letter)?.parse().ok())
}

/// Supports taken away from beyond the beam's free end to so far before it, from nothing to all: what is then laid on air is found there, and all that
/// is found lies there.
#[test]
fn what_lost_its_support_is_found_where_it_was() {
    let folder = folder();
    let (here, shape) = (folder.path(), gallows());
    fs::write(here.join("solid.stl"), stl_binary(&shape.mesh())).unwrap();
    let done = prepared(here, &[]);
    assert!(done.status.success(), "{}", said(&done));
    let text = fs::read_to_string(here.join("out.gcode")).unwrap();
    let walls = lines_of(&text, FILAMENT_MM, &|role| role == "External perimeter");
    let far = walls.iter().flat_map(|layer| &layer.lines).flat_map(|line| [line.from, line.to]);
    let end = far.fold([f64::NEG_INFINITY; 2], |end, at| if at[0] > end[0] { at } else { end });
    let away = |at: [f64; 2]| end[0] - at[0];
    let (mut counts, mut first) = (Vec::new(), None);
    for reach in [-9.0, 0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 20.0, 50.0] {
        let (mut at, mut role, mut places) = ([0.0; 2], "", Vec::new());
        let mut lines: Vec<String> = Vec::new();
        for line in text.lines() {
            role = line.strip_prefix(";TYPE:").unwrap_or(role);
            let mut kept = line.to_owned();
            if line.starts_with("G1 ") || line.starts_with("G0 ") {
                let to = [number(line, 'X').unwrap_or(at[0]), number(line, 'Y').unwrap_or(at[1])];
                if role == "Support material" && away(at).min(away(to)) < reach && to != at {
                    kept = line.split(' ').filter(|word| !word.starts_with('E')).collect::<Vec<_>>().join(" ");
                }
                at = to;
            }
            lines.push(kept);
            places.push(at);
        }
        fs::write(here.join("mutant.gcode"), lines.join("\n")).unwrap();
        let verify = run(here, &["verify", "mutant.gcode", "--plan", "out.json", "--json"]);
        let document: Value = serde_json::from_slice(&verify.stdout).unwrap();
        let of_rule = |finding: &&Value| finding["rule"] == "in-air";
        let findings: Vec<&Value> = document["findings"].as_array().unwrap().iter().filter(of_rule).collect();
        for finding in &findings {
            let line = finding["line"].as_u64().unwrap() as usize;
            // Within the longest free end and a cell of where something was taken.
            let nearest = away(places[line - 2]).min(away(places[line - 1]));
            assert!(nearest < reach + 8.0, "{reach} mm: {finding}");
        }
        counts.push((reach, findings.len()));
        first = first.or((!findings.is_empty()).then_some(reach));
        assert!(first.is_none() || !findings.is_empty(), "{counts:?}");
    }
    note(&format!("supports gone from the beam's end on, mm, and findings: {counts:?}"));
    assert!(counts[0].1 == 0 && first.is_some_and(|reach| reach <= 6.0), "{counts:?}");
}
