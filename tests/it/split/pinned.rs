//! Cuts that somebody has decided: made as they are, whatever they gain, and the search cuts what they leave.

use std::path::Path;

use serde_json::Value;
use trunnion::geom::{Bounds, Vec3};
use trunnion::mesh::{ReadOptions, read_model, threemf};
use trunnion::split::{Against, CutMade, CutOptions, PinnedCut, Plane, Split};

use super::command::{run, written};
use super::{cut, is_sound, solids};
use crate::support::{fails, folder, trunnion};

fn pin(cut: &CutMade) -> PinnedCut {
    PinnedCut { plane: cut.plane, points: cut.points.clone() }
}

fn plane(normal: [f64; 3], offset_mm: f64) -> PinnedCut {
    PinnedCut { plane: Plane { normal: Vec3::from(normal).normalize(), offset_mm }, points: Vec::new() }
}

fn with(pinned: Vec<PinnedCut>, max_cuts: usize) -> CutOptions {
    CutOptions { pinned, max_cuts, ..CutOptions::default() }
}

/// Corners and facets of all parts, with their directions.
fn parts(found: &Split) -> Vec<String> {
    found
        .parts
        .iter()
        .map(|part| format!("{:?} {:?} {:?}", part.up, part.mesh.vertices(), part.mesh.facets()))
        .collect()
}

#[test]
fn what_the_search_finds_is_made_again_to_the_bit_by_its_pins() {
    for solid in solids::all() {
        let model = solid.shape.mesh();
        let found = cut(&model, &CutOptions::default());
        let pins: Vec<PinnedCut> = found.cuts.iter().map(pin).collect();
        for made in &found.cuts {
            assert_eq!(made.points.len(), made.parts.len());
            assert!(made.points.iter().all(|point| made.plane.height(point) > 0.0), "{}", solid.name);
        }
        if pins.is_empty() {
            continue;
        }
        let again = cut(&model, &with(pins.clone(), pins.len()));
        assert_eq!((again.unpinned, again.printable), (None, true), "{}", solid.name);
        assert!(parts(&again) == parts(&found), "{}", solid.name);
        // With the first one alone the search finds the rest.
        let rest = cut(&model, &with(pins[..1].to_vec(), CutOptions::default().max_cuts));
        is_sound(solid.name, &model, &rest);
        assert!(rest.printable && rest.cuts[0].plane == found.cuts[0].plane, "{}", solid.name);
    }
}

#[test]
fn a_pinned_cut_is_made_where_the_search_would_make_none_and_stays_where_it_is() {
    let model = solids::tee().mesh();
    // Halfway out on the arm at +x, for nobody's sake; the rest of that arm and the other one are the search's.
    let found = cut(&model, &with(vec![plane([1.0, 0.0, 0.0], 20.0)], 12));
    is_sound("tee", &model, &found);
    assert!(found.printable && found.cuts[0].plane.offset_mm == 20.0 && found.cuts.len() == 3, "{:?}", found.cuts);
    assert!((found.cuts[0].seam_mm2 - 100.0).abs() < 1e-9);
    // Of two tips beyond a plane the one that is named.
    let model = solids::block(60.0, 10.0, 10.0)
        .at(-30.0, -5.0, 0.0)
        .and(&solids::block(10.0, 10.0, 30.0).at(-30.0, -5.0, 0.0))
        .and(&solids::block(10.0, 10.0, 30.0).at(20.0, -5.0, 0.0))
        .mesh();
    let one = PinnedCut { points: vec![Vec3::new(25.0, 0.0, 25.0)], ..plane([0.0, 0.0, 1.0], 20.0) };
    let both = plane([0.0, 0.0, 1.0], 20.0);
    let taken = |pin: PinnedCut| cut(&model, &with(vec![pin], 1)).cuts[0].parts.len();
    assert_eq!([taken(one), taken(both)], [1, 2]);
}

#[test]
fn what_is_against_a_pinned_cut_is_said_and_no_other_is_made() {
    let model = solids::tee().mesh();
    let against = |pins: Vec<PinnedCut>, no_cut: Vec<Bounds>| {
        let found = cut(&model, &CutOptions { no_cut, ..with(pins, 12) });
        assert!(!found.printable);
        (found.unpinned, found.cuts.len())
    };
    let good = plane([1.0, 0.0, 0.0], 5.0);
    let elsewhere = PinnedCut { points: vec![Vec3::new(-20.0, 0.0, 45.0)], ..good.clone() };
    for (bad, why) in [
        (plane([1.0, 0.0, 0.0], 40.0), Against::Nothing),
        (plane([-1.0, 0.0, 0.0], 30.0), Against::Nothing),
        (elsewhere, Against::Nothing),
        (plane([-1.0, 0.0, 0.0], 29.9), Against::Small),
        (plane([0.0, 0.0, 1.0], 49.5), Against::Small),
        // Upside down, which no axis does; and along the table, where the head would meet it.
        (plane([0.0, 0.0, -1.0], -20.0), Against::Head),
        // Nearly all of it, into the table.
        (plane([-1.0, 0.0, 0.0], -20.0), Against::Head),
    ] {
        assert_eq!(against(vec![bad.clone()], Vec::new()), (Some((0, why)), 0), "{bad:?}");
        // Behind a good one the good one is made.
        let (unpinned, made) = against(vec![good.clone(), bad.clone()], Vec::new());
        assert_eq!((unpinned.map(|(place, _)| place), made), (Some(1), 1), "{bad:?}");
    }
    let kept = Bounds { min: Vec3::new(4.0, -6.0, 39.0), max: Vec3::new(6.0, 6.0, 51.0) };
    assert_eq!(against(vec![good], vec![kept]), (Some((0, Against::Unwanted)), 0));
}

#[test]
fn the_command_takes_what_the_document_gives() {
    let folder = folder();
    let (output, again) = (folder.path().join("parts.3mf"), folder.path().join("again.3mf"));
    for (name, shape) in [("tee", solids::tee()), ("hook", solids::hook())] {
        let model = written(folder.path(), &format!("{name}.stl"), &shape);
        let (code, out, err) = run(&model, &output, &["--json"]);
        assert_eq!(code, Some(0), "{err}");
        let document: Value = serde_json::from_str(&out).unwrap();
        let planes = document["planes"].as_array().unwrap();
        let pins: Vec<String> =
            planes.iter().map(|plane| format!("--cut={}", plane["pin"].as_str().unwrap())).collect();
        let most = pins.len().to_string();
        let words: Vec<&str> = pins.iter().map(String::as_str).chain(["--max-cuts", &most]).collect();
        let (code, _, err) = run(&model, &again, &words);
        assert_eq!(code, Some(0), "{err}");
        assert_eq!(std::fs::read(&output).unwrap(), std::fs::read(&again).unwrap(), "{name}");
    }
    let tee = folder.path().join("tee.stl").display().to_string();
    let none = folder.path().join("none.3mf");
    let (code, out, _) = run(&tee, &none, &["--cut", "1,0,0,5", "--cut", "1,0,0,40", "--json"]);
    let document: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, &document["code"], &document["refused_cut"]), (Some(1), &"split/refused-cut".into(), &1.into()));
    assert!(!none.exists() && document["planes"].as_array().unwrap().len() == 1);
    for (words, wanted) in [
        (&["--cut", "1,0,5"][..], "command/usage: --cut 1,0,5 | four numbers"),
        (&["--cut", "0,0,0,5"], "command/usage: --cut 0,0,0,5 | four numbers"),
        (&["--cut", "1,0,0,5@1,2"], "command/usage: --cut 1,0,0,5@1,2 | four numbers"),
        (&["--cut", "1,0,0,inf"], "command/usage: --cut 1,0,0,inf | four numbers"),
        (&["--cut", "1,0,0,5", "--max-cuts", "0"], "setting/out-of-range: --max-cuts | 1 and 100 | got 0"),
        (&["--cut", "1,0,0,5", "--up", "0,1,0"], "command/usage: --up | --cut"),
    ] {
        let (code, _, err) = run(&tee, &none, words);
        assert!(code == Some(2) && fails(&err, wanted), "{wanted:?} is not {err:?}");
    }
}

/// Runs `prepare` with the built-in slicer; code, stdout, stderr.
fn prepare(folder: &Path, words: &[&str]) -> (Option<i32>, String, String) {
    let how = ["prepare", "-m", "generic-ac", "--slicer", "builtin", "-o", "out.gcode", "--json", "-q"];
    let run = trunnion().current_dir(folder).args(how).args(words).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (run.status.code(), text(&run.stdout), text(&run.stderr))
}

#[test]
fn prepare_prints_what_is_cut_where_somebody_has_decided() {
    let folder = folder();
    let here = folder.path();
    // Nothing of a block needs a cut, and this one has two.
    written(here, "block.stl", &solids::block(20.0, 20.0, 40.0).at(-10.0, -10.0, 0.0));
    let (code, out, err) = prepare(here, &["block.stl", "--cut", "0,0,2,30.5", "--cut", "0,0,1,10"]);
    assert_eq!(code, Some(0), "{err}");
    let done: Value = serde_json::from_str(&out).unwrap();
    let offsets: Vec<f64> =
        done["cut"]["planes"].as_array().unwrap().iter().map(|plane| plane["offset_mm"].as_f64().unwrap()).collect();
    assert_eq!((offsets, &done["verify"]["findings"]), (vec![30.5, 10.0], &Value::Array(Vec::new())));
    // What it says of its cuts makes the same file again.
    let pins = done["cut"]["planes"].as_array().unwrap().iter().map(|plane| plane["pin"].as_str().unwrap());
    let words: Vec<&str> = std::iter::once("block.stl").chain(pins.flat_map(|pin| ["--cut", pin])).collect();
    let program = |folder: &Path| std::fs::read(folder.join("out.gcode")).unwrap();
    let before = program(here);
    assert_eq!(prepare(here, &words).0, Some(0));
    assert!(before == program(here));
    // The parts lie on each other where it was cut.
    let parts = std::fs::read(here.join("out.parts.3mf")).unwrap();
    let parts = read_model(&parts, "out.parts.3mf", &ReadOptions::default()).unwrap().parts;
    let heights: Vec<[f64; 2]> =
        parts.iter().map(|part| [part.mesh.bounds().min.z, part.mesh.bounds().max.z]).collect();
    assert_eq!(heights, [[0.0, 10.0], [10.0, 30.5], [30.5, 40.0]]);
}

#[test]
fn prepare_says_why_a_cut_is_not_made_and_leaves_no_file() {
    let folder = folder();
    let here = folder.path();
    written(here, "block.stl", &solids::block(20.0, 20.0, 40.0));
    let pair = solids::block(20.0, 20.0, 40.0).and(&solids::block(20.0, 20.0, 40.0).at(40.0, 0.0, 0.0));
    written(here, "pair.stl", &pair);
    let [lower, upper] = [0.0, 10.0].map(|z| solids::block(20.0, 20.0, 10.0).at(0.0, 0.0, z).mesh());
    let stack = threemf(&[("lower".to_owned(), &lower), ("upper".to_owned(), &upper)]);
    std::fs::write(here.join("stack.3mf"), stack).unwrap();
    let bars =
        [solids::block(60.0, 10.0, 10.0).at(-30.0, -5.0, 0.0), solids::block(10.0, 60.0, 10.0).at(-5.0, -30.0, 0.0)];
    let [along, across, apart] =
        [bars[0].mesh(), bars[1].mesh(), solids::block(10.0, 10.0, 20.0).at(60.0, 0.0, 0.0).mesh()];
    let named = [("along".to_owned(), &along), ("across".to_owned(), &across), ("apart".to_owned(), &apart)];
    std::fs::write(here.join("crossed.3mf"), threemf(&named)).unwrap();
    let (low, high) = ("--cut=0:0,0,1,10", "--cut=1:0,0,1,41");
    for (words, wanted) in [
        (&["block.stl", "--cut", "0,0,1,10", "--cut", "0,0,1,41"][..], "strategy/no-way: cut 2"),
        // Counted over all parts.
        (&["pair.stl", low, high], "strategy/no-way: part 1 | cut 2"),
        (&["stack.3mf", "--cut", "1:0,0,1,15"], "strategy/no-way: part 1 | --join"),
    ] {
        let (code, _, err) = prepare(here, words);
        assert!(code == Some(1) && fails(&err, wanted), "{wanted:?} is not {err:?}");
    }
    for (words, wanted) in [
        (&["block.stl", "--cut", "1,0,5"][..], "command/usage: --cut 1,0,5 | four numbers"),
        (&["block.stl", "--cut", "0,0,1,10", "--way", "supports"], "command/usage: --cut | --way supports"),
        (&["block.stl", "--cut", "0,0,1,10", "--split", "never"], "command/usage: --cut | --split never"),
        (&["out.parts.3mf", "--cut", "0,0,1,10"], "command/usage: --cut | out.parts.3mf | -o"),
        (&["stack.3mf*2", "--join", "--cut", "0,0,1,10"], "setting/arranged-cut: --cut | --join | trunnion split"),
        // Two become one, so that the third has another number than in its file.
        (&["crossed.3mf", "--cut", "1:0,0,1,5"], "setting/arranged-cut: --cut | --join | trunnion split"),
        (&["pair.stl", "--cut", "0,0,1,10"], "setting/cut-of-which: --cut 0,0,1,10 | 2 parts | 0:0,0,1,10"),
        (
            &["pair.stl", "--cut", "0:0,0,1,10", "--cut", "2:0,0,1,10"],
            "setting/no-such-part: --cut 2 | pair.stl | 0..1",
        ),
        (&["pair.stl", "--cut", "x:0,0,1,10"], "command/usage: --cut x:0,0,1,10 | four numbers"),
    ] {
        let (code, _, err) = prepare(here, words);
        assert!(code == Some(2) && fails(&err, wanted), "{wanted:?} is not {err:?}");
    }
    assert!(!here.join("out.gcode").exists() && !here.join("out.parts.3mf").exists());
}

/// What `prepare` tells of the solids that were cut: which parts of the model, their cuts as words, and where their planes are.
fn told(document: &Value) -> Vec<(Vec<u64>, Vec<String>, Vec<f64>)> {
    assert_eq!(document["verify"]["findings"], Value::Array(Vec::new()));
    let cut = &document["cut"];
    let of_solid = |solid: &Value| {
        let planes = solid["planes"].as_array().unwrap();
        (
            solid["of_parts"].as_array().unwrap().iter().map(|part| part.as_u64().unwrap()).collect(),
            planes.iter().map(|plane| plane["pin"].as_str().unwrap().to_owned()).collect(),
            planes.iter().map(|plane| plane["offset_mm"].as_f64().unwrap()).collect(),
        )
    };
    cut["solids"].as_array().map_or_else(|| vec![of_solid(cut)], |solids| solids.iter().map(of_solid).collect())
}

#[test]
fn cuts_are_of_one_part_of_several_and_of_its_copies() {
    let folder = folder();
    let here = folder.path();
    written(here, "block.stl", &solids::block(20.0, 20.0, 40.0));
    written(here, "tee.stl", &solids::tee());
    written(here, "pair.stl", &solids::tee().and(&solids::tee().at(0.0, 90.0, 0.0)));
    // Too near to each other for a head beside the first.
    written(here, "near.stl", &solids::tee().and(&solids::block(10.0, 10.0, 60.0).at(34.0, -5.0, 0.0)));
    let [lower, upper] = [0.0, 10.0].map(|z| solids::block(20.0, 20.0, 10.0).at(0.0, 0.0, z).mesh());
    let stack = threemf(&[("lower".to_owned(), &lower), ("upper".to_owned(), &upper)]);
    std::fs::write(here.join("stack.3mf"), stack).unwrap();
    // What lies on its back, and is stood up.
    written(here, "lying.stl", &solids::tee().mapped(|p| Vec3::new(p.x, p.z, -p.y)));
    let made = |words: &[&str]| -> Value {
        let (code, out, err) = prepare(here, words);
        assert_eq!(code, Some(0), "{words:?}: {err}");
        serde_json::from_str(&out).unwrap()
    };
    for (models, cuts, wanted) in [
        // Copies are cut alike, whichever is named.
        (&["block.stl*2"][..], &["0,0,1,10"][..], &[(&[0, 1][..], 1)][..]),
        (&["block.stl*2"], &["1:0,0,1,10"], &[(&[0, 1], 1)]),
        // What has no cut of its own stays whole, or is cut as it must be.
        (&["block.stl", "tee.stl"], &["1:1,0,0,20"], &[(&[1], 3)]),
        (&["block.stl", "tee.stl"], &["0:0,0,1,10"], &[(&[0], 1), (&[1], 2)]),
        (&["block.stl*2", "tee.stl"], &["2:1,0,0,20", "0:0,0,1,30", "0:0,0,1,12.5"], &[(&[0, 1], 2), (&[2], 3)]),
        // Two of a kind that are no copies.
        (&["pair.stl"], &["1:1,0,0,20"], &[(&[0], 2), (&[1], 3)]),
        (&["near.stl"], &["0:1,0,0,20"], &[(&[0], 3)]),
        (&["lying.stl", "--up", "0,1,0"], &["1,0,0,20"], &[(&[0], 3)]),
        (&["stack.3mf", "--join"], &["0,0,1,15"], &[(&[0], 1)]),
    ] {
        let given: Vec<String> = cuts.iter().map(|cut| format!("--cut={cut}")).collect();
        let words = |cuts: &[String]| -> Vec<String> {
            models.iter().map(|word| (*word).to_owned()).chain(cuts.iter().cloned()).collect()
        };
        let run = |cuts: &[String]| {
            let words = words(cuts);
            made(&words.iter().map(String::as_str).collect::<Vec<_>>())
        };
        let found = told(&run(&given));
        let counted: Vec<(Vec<u64>, usize)> =
            found.iter().map(|(parts, pins, _)| (parts.clone(), pins.len())).collect();
        let wanted: Vec<(Vec<u64>, usize)> = wanted.iter().map(|(parts, cuts)| (parts.to_vec(), *cuts)).collect();
        assert_eq!(counted, wanted, "{models:?} {cuts:?}");
        // What it says of its cuts begins with what was given, in the file's own coordinates, and makes the same again.
        let pins: Vec<&String> = found.iter().flat_map(|(_, pins, _)| pins).collect();
        for cut in cuts {
            let (_, plane) = cut.split_once(':').unwrap_or(("", cut));
            let numbers = |text: &str| -> Vec<f64> { text.split(',').map(|word| word.parse().unwrap()).collect() };
            let same = |pin: &&&String| {
                let pin = pin.split('@').next().unwrap();
                let pin = numbers(pin.split_once(':').map_or(pin, |(_, plane)| plane));
                pin.iter().zip(numbers(plane)).all(|(a, b)| (a - b).abs() < 1e-9)
            };
            assert!(pins.iter().any(|pin| same(&pin)), "{cut} is none of {pins:?}");
        }
        let again: Vec<String> = pins.iter().map(|pin| format!("--cut={pin}")).collect();
        let again = told(&run(&again));
        for ((parts, _, planes), (parts_again, _, planes_again)) in found.iter().zip(&again) {
            assert_eq!((parts, planes.len()), (parts_again, planes_again.len()), "{models:?} {cuts:?}");
            let near = planes.iter().zip(planes_again).all(|(a, b)| (a - b).abs() < 1e-9);
            assert!(near, "{planes:?} are not {planes_again:?}");
        }
    }
}

#[test]
fn one_part_of_several_is_cut_as_if_it_were_alone() {
    let folder = folder();
    let [output, alone] = ["parts.3mf", "alone.3mf"].map(|name| folder.path().join(name));
    let block = solids::block(20.0, 20.0, 40.0);
    let pair = written(folder.path(), "pair.stl", &block.and(&solids::tee().at(0.0, 90.0, 0.0)));
    // Whichever of the two comes first in the file.
    let tee = (0..2_usize)
        .find(|part| {
            let (code, out, err) = run(&pair, &output, &["--part", &part.to_string(), "--json"]);
            assert_eq!(code, Some(0), "{err}");
            serde_json::from_str::<Value>(&out).unwrap()["planes"].as_array().unwrap().len() == 2
        })
        .unwrap();
    let by_itself = written(folder.path(), "tee.stl", &solids::tee().at(0.0, 90.0, 0.0));
    let (part, other) = (tee.to_string(), 1 - tee);
    for cut in ["1,0,0,20".to_owned(), format!("{tee}:1,0,0,20")] {
        let words = ["--json", "--part", &part, "--cut", &cut];
        let (code, out, err) = run(&pair, &output, &words);
        assert_eq!(code, Some(0), "{err}");
        let planes = |out: &str| serde_json::from_str::<Value>(out).unwrap()["planes"].clone();
        let (code, wanted, err) = run(&by_itself, &alone, &["--json", "--cut", "1,0,0,20"]);
        assert_eq!((code, planes(&wanted)), (Some(0), planes(&out)), "{err}");
    }
    std::fs::remove_file(&output).unwrap();
    for (words, wanted) in [
        (&["--cut", "1,0,0,20"][..], "strategy/not-one-solid: pair.stl | 2 | --part"),
        (&["--part", "2"], "setting/no-such-part: --part 2 | pair.stl | 0..1"),
        (&["--part", &part, "--cut", &format!("{other}:1,0,0,20")], "setting/unwanted-cut: --cut | part"),
        (&["--part", &part, "--convex"], "command/usage: --part | --convex"),
    ] {
        let (code, _, err) = run(&pair, &output, words);
        assert!(code == Some(2) && fails(&err, wanted), "{wanted:?} is not {err:?}");
        assert!(!output.exists());
    }
    let (code, _, err) = run(&by_itself, &output, &["--cut", "1:1,0,0,20"]);
    assert!(code == Some(2) && fails(&err, "setting/no-such-part: --cut 1 | tee.stl | 0..0"), "{err:?}");
}
