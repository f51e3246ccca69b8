//! `trunnion pack`: plates, document, pictures, sentences for what cannot be, an end on Ctrl-C.

use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use std::str::FromStr;
use std::time::Duration;

use serde_json::Value;
use trunnion::job::{
    Clock, Contents, Files, ModelSource, PackInto, PackOptions, PackRequest, PackSpace, Silent, Source, World,
};
use trunnion::mesh::{ReadOptions, Repair, TriangleMesh, Unit, read_model, stl_binary, stl_binary_parts};
use trunnion::pack::{Ended, Method};
use trunnion::world::FileError;

use super::mpv;
use super::shapes::{ball, block, boat};
use crate::support::{catches_interrupts, first_error, folder, processor_s, said, skip, trunnion, wait_for};

fn write(folder: &Path, name: &str, meshes: &[TriangleMesh]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, stl_binary_parts(&meshes.iter().collect::<Vec<_>>())).unwrap();
    path
}

fn run(folder: &Path, words: &[&str]) -> Output {
    trunnion().arg("pack").args(words).args(["--unit", "mm"]).current_dir(folder).output().unwrap()
}

#[track_caller]
fn document(folder: &Path, words: &[&str]) -> Value {
    let output = run(folder, &[words, &["--json"]].concat());
    assert!(output.status.success(), "{}", said(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[track_caller]
fn refused(folder: &Path, words: &[&str]) -> String {
    let output = run(folder, words);
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{}", said(&output));
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(!text.contains("panicked"), "{text}");
    first_error(&text).1.to_owned()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// The plates of a folder as they are read back: what is in them, part by part.
fn read(path: &Path) -> Vec<TriangleMesh> {
    let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
    let model = read_model(&std::fs::read(path).unwrap(), "plate.3mf", &options).unwrap();
    model.parts.into_iter().map(|part| part.mesh).collect()
}

#[test]
fn plates_hold_what_the_document_says() {
    let folder = folder();
    let at = folder.path();
    write(at, "boat.stl", &boat());
    write(at, "plate.stl", &[block([0.0; 3], [40.0, 30.0, 4.0])]);
    let words = ["boat.stl*5", "plate.stl*6", "--space", "90,80,60", "--turn", "z90", "--time", "3", "-o", "out"];
    let done = document(at, &words);
    let plates = done["plates"].as_array().unwrap();
    assert_eq!(done["runs"].as_u64().unwrap() as usize, plates.len());
    assert!(done["lower_bound"].as_u64() <= done["runs"].as_u64() && done["seconds"].as_f64().unwrap() > 0.0);
    let mut seen = std::collections::BTreeSet::new();
    for plate in plates {
        let meshes = read(&at.join("out").join(plate["file"].as_str().unwrap()));
        let volume: f64 = meshes.iter().map(TriangleMesh::volume).sum();
        assert!((volume / (90.0 * 80.0 * 60.0) - plate["fill"].as_f64().unwrap()).abs() < 1e-4);
        for mesh in &meshes {
            let b = mesh.bounds();
            assert!((0..3).all(|k| b.min[k] > -1e-4 && b.max[k] < [90.0, 80.0, 60.0][k] + 1e-4), "{b:?}");
        }
        for item in plate["items"].as_array().unwrap() {
            assert!(seen.insert((item["model"].to_string(), item["copy"].as_u64().unwrap())));
            let (low, high) = (numbers(&item["box_mm"][0]), numbers(&item["box_mm"][1]));
            // The plate's low corner is its file's origin: turned about that it stays a corner of the box.
            let origin = numbers(&item["origin_mm"]);
            let corner = |k: usize| (origin[k] - low[k]).abs() < 1e-3 || (origin[k] - high[k]).abs() < 1e-3;
            assert!(item["model"] != "plate.stl" || (0..3).all(corner), "{item}");
            assert!(item["turn_deg"].as_f64().unwrap() % 90.0 == 0.0);
        }
        let order = plate["lift_order"].as_array().unwrap().len() + plate["locked"].as_array().unwrap().len();
        assert_eq!(order, plate["items"].as_array().unwrap().len());
    }
    assert_eq!(seen.len(), 11);
    assert!(done["clearance_mm"].is_null() || done["clearance_mm"].as_f64().unwrap() >= 1.0 - 1e-5);
}

#[test]
fn the_same_call_gives_the_same_bytes_and_fewer_plates_leave_none_behind() {
    let folder = folder();
    let at = folder.path();
    write(at, "plate.stl", &[block([0.0; 3], [40.0, 30.0, 4.0])]);
    let words = |count: &str, out: &str| -> Vec<String> {
        [count, "--space", "50,50,12", "-o", out, "--view", "out.png"].map(str::to_owned).to_vec()
    };
    let call = |count: &str, out: &str| {
        let words = words(count, out);
        document(at, &words.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let (one, two) = (call("plate.stl*7", "a"), call("plate.stl*7", "b"));
    assert_eq!((&one["plates"], one["runs"].as_u64()), (&two["plates"], Some(4)));
    for index in 1..=4 {
        let bytes = |out: &str| std::fs::read(at.join(out).join(format!("plate-{index:02}.3mf"))).unwrap();
        assert!(bytes("a") == bytes("b"), "{index}");
    }
    assert!(std::fs::read(at.join("out.png")).unwrap().starts_with(b"\x89PNG"));
    let output = run(at, &["plate.stl*2", "--space", "50,50,12", "-o", "a"]);
    assert!(output.status.success() && said(&output).contains("plate-02.3mf.stale"), "{}", said(&output));
    assert!(at.join("a/plate-01.3mf").is_file() && !at.join("a/plate-02.3mf").exists());
}

#[test]
fn boxes_are_packed_from_a_text() {
    let folder = folder();
    let at = folder.path();
    let instance = mpv::instance(8, 50, 1);
    let lines: Vec<String> = instance.items.iter().map(|i| i.size.map(|s| s.to_string()).join(" ")).collect();
    std::fs::write(at.join("b.txt"), lines.join("\n")).unwrap();
    let done = document(at, &["--boxes", "b.txt", "--space", "100,100,100", "--time", "1"]);
    assert!(done["runs"].as_u64() >= done["lower_bound"].as_u64() && done["runs"].as_u64().unwrap() <= 11, "{done}");
    let mut placed = 0;
    for plate in done["plates"].as_array().unwrap() {
        let items: Vec<(Vec<f64>, Vec<f64>)> = plate["items"]
            .as_array()
            .unwrap()
            .iter()
            .map(|item| {
                let size = instance.items[item["index"].as_u64().unwrap() as usize].size;
                let (low, high) = (numbers(&item["box_mm"][0]), numbers(&item["box_mm"][1]));
                assert!(
                    (0..3)
                        .all(|k| (high[k] - low[k] - size[k] as f64).abs() < 1e-9 && low[k] >= 0.0 && high[k] <= 100.0)
                );
                assert_eq!(numbers(&item["origin_mm"]), low);
                (low, high)
            })
            .collect();
        for (i, a) in items.iter().enumerate() {
            assert!(items[..i].iter().all(|b| (0..3).any(|k| a.1[k] <= b.0[k] || b.1[k] <= a.0[k])));
        }
        placed += items.len();
    }
    assert_eq!(placed, 50);
    let filled = document(at, &["--boxes", "b.txt", "--space", "100,100,100", "--time", "1", "--fill", "volume"]);
    assert!(filled["runs"] == 1 && filled["value"].as_f64() <= filled["value_upper_bound"].as_f64());
    assert!(filled["plates"][0]["fill"].as_f64().unwrap() > 0.6 && !filled["left_out"].as_array().unwrap().is_empty());
    std::fs::write(at.join("few.txt"), "60 60 60 1 5\n60 60 50 2 3\n").unwrap();
    if !Method::Ip.is_built_in() {
        skip("the integer program is not built in (--features integer-program)");
    }
    let built_in = Method::NAMED.into_iter().filter(|(_, method)| method.is_built_in() && !method.of_shapes());
    if Method::Ip.is_built_in() {
        let near = ["--method", "ip-local-search", "--used-distance", "3", "--direction-distance", "12"];
        let words = [&["--boxes", "few.txt", "--space", "60,60,100", "--fill", "file"][..], &near].concat();
        let few = document(at, &words);
        assert_eq!((few["value"].as_f64(), few["method"].as_str()), (Some(6.0), Some("ip-local-search")));
    }
    for (method, _) in built_in.filter(|(name, _)| *name != "tabu") {
        let few = document(at, &["--boxes", "few.txt", "--space", "60,60,100", "--fill", "file", "--method", method]);
        assert_eq!((few["value"].as_f64(), few["ended"].as_str()), (Some(6.0), Some("proved")), "{method}");
    }
}

/// Two cubes beside each other and one on them; a box that stays upright; values; pictures and plates as with the other goals.
#[test]
fn the_lowest_run_of_a_base() {
    let folder = folder();
    let at = folder.path();
    write(at, "cube.stl", &[block([0.0; 3], [20.0, 20.0, 20.0])]);
    let words = ["cube.stl*3", "--space", "41,20", "--goal", "height", "-o", "out", "--view", "low.svg", "--time", "1"];
    let done = document(at, &words);
    let figure = |done: &Value, name: &str| done[name].as_f64().unwrap();
    assert_eq!((done["goal"].as_str(), done["runs"].as_u64()), (Some("height"), Some(1)));
    assert!((figure(&done, "height_mm") - 41.0).abs() < 1e-3, "{done}");
    assert!(
        figure(&done, "height_lower_bound_mm") <= 41.0 && numbers(&done["space_mm"])[2] == figure(&done, "height_mm")
    );
    assert!((figure(&done["plates"][0], "fill") - 24000.0 / (41.0 * 20.0 * figure(&done, "height_mm"))).abs() < 1e-6);
    assert!(at.join("out/plate-01.3mf").is_file() && at.join("low.svg").is_file());
    for (text, high) in
        [("30 20 10\n", 10.0), ("30 20 10 up\n", 10.0), ("10 30 20 1 1 up\n", 20.0), ("10 30 20 1 1\n", 10.0)]
    {
        std::fs::write(at.join("b.txt"), text).unwrap();
        let done = document(at, &["--boxes", "b.txt", "--space", "30,30", "--goal", "height", "--turn", "any"]);
        assert_eq!((figure(&done, "height_mm"), done["ended"].as_str()), (high, Some("proved")), "{text}");
    }
    let filled = document(at, &["cube.stl*3", "--space", "41,20,30", "--goal", "fill"]);
    assert_eq!((filled["goal"].as_str(), figure(&filled, "value").round()), (Some("filling"), 16000.0));
    std::fs::write(at.join("b.txt"), "10 30 20 1 1 up\n").unwrap();
    let upright = refused(at, &["--boxes", "b.txt", "--space", "30,30,19", "--turn", "any"]);
    assert!(upright.contains("30 x 30 x 19 mm upright") && upright.contains("remove `up`"), "{upright}");
}

/// A ball of 5,000 facets is packed as one of a few hundred: as many fit, and the answer is tested on the ball itself. Where only the ball itself fits, that is said.
#[test]
fn inflated_models_are_packed_by_coarser_meshes() {
    let folder = folder();
    let at = folder.path();
    write(at, "ball.stl", &[ball(20.0, 72, 36)]);
    let words = ["ball.stl*8", "--space", "85,85,85", "--turn", "z90", "--time", "2", "-o", "out"];
    let done = document(at, &[&words[..], &["--inflate", "0.4"]].concat());
    let coarse = &done["inflated"];
    let facets = |name: &str| coarse[name].as_u64().unwrap();
    assert!(facets("facets") == 5040 && facets("packed_facets") * 4 < facets("facets"), "{coarse}");
    assert!(coarse["raised_mm"].as_f64().unwrap() <= 0.4);
    assert_eq!((done["runs"].as_u64(), done["plates"][0]["items"].as_array().unwrap().len()), (Some(1), 8));
    assert_eq!(read(&at.join("out/plate-01.3mf"))[0].facets().len(), 5040);
    let plain = document(at, &words);
    assert!(
        plain["inflated"].is_null() && plain["runs"].as_u64() == Some(1) && plain["lower_bound"] == done["lower_bound"]
    );
    let tight = ["ball.stl", "--space", "40.01,40.01,40.01"];
    assert_eq!(document(at, &tight)["runs"].as_u64(), Some(1));
    assert!(refused(at, &[&tight[..], &["--inflate", "0.4"]].concat()).contains("leave out --inflate"));
    // A base alone is as high as what is packed needs, and what no packing is lower than is told of the balls, which are 40 mm high.
    let high = document(at, &["ball.stl", "--goal", "height", "--space", "90,90", "--inflate", "2", "--gap", "0.01"]);
    let [reached, bound] = ["height_mm", "height_lower_bound_mm"].map(|key| high[key].as_f64().unwrap());
    assert!(bound <= 40.001 && (40.0..44.1).contains(&reached), "{bound} {reached}");
    let words = ["ball.stl*2", "--goal", "height", "--space", "82,46,46", "--inflate", "2", "--time", "1"];
    let why = refused(at, &words);
    assert!(why.contains("40.000"), "{why}");
}

#[test]
fn models_stand_side_by_side_on_a_table() {
    let folder = folder();
    let at = folder.path();
    write(at, "post.stl", &[block([5.0, 5.0, 2.0], [35.0, 25.0, 42.0])]);
    let done = document(at, &["post.stl*9", "-m", "generic-ac", "--gap", "10", "-o", "out"]);
    let items = done["plates"][0]["items"].as_array().unwrap();
    assert_eq!((done["runs"].as_u64(), items.len()), (Some(1), 9));
    for (i, item) in items.iter().enumerate() {
        let (low, high) = (numbers(&item["box_mm"][0]), numbers(&item["box_mm"][1]));
        assert!(low[2].abs() < 1e-9 && low[0] > -150.0 && high[0] < 150.0);
        for other in &items[..i] {
            let (l, h) = (numbers(&other["box_mm"][0]), numbers(&other["box_mm"][1]));
            assert!((0..2).any(|k| low[k] - h[k] > 10.0 - 1e-6 || l[k] - high[k] > 10.0 - 1e-6));
        }
    }
    // As much as the head needs, and never nothing.
    let roomy = document(at, &["post.stl*9", "-m", "generic-ac"]);
    assert!(roomy["gap_mm"].as_f64().unwrap() >= 5.0 && roomy["runs"].as_u64() >= Some(1), "{}", roomy["gap_mm"]);
    assert!(refused(at, &["post.stl", "-m", "generic-ac", "--turn", "any"]).contains("--turn none, z90 or z"));
}

#[test]
fn what_cannot_be_is_refused_in_a_sentence() {
    let folder = folder();
    let at = folder.path();
    let cube = block([0.0; 3], [20.0, 30.0, 40.0]);
    write(at, "cube.stl", std::slice::from_ref(&cube));
    let open: TriangleMesh = TriangleMesh::new(cube.vertices().to_vec(), cube.facets()[1..].to_vec());
    std::fs::write(at.join("open.stl"), stl_binary(&open)).unwrap();
    std::fs::write(at.join("b.txt"), "10 20 30\n10 20\n").unwrap();
    std::fs::write(at.join("many.txt"), "10 10 10 61\n").unwrap();
    std::fs::write(at.join("file"), "in the way").unwrap();
    let space = ["--space", "50,50,50"];
    let cases: [(&[&str], &[&str]); 29] = [
        (
            &["cube.stl", "--space", "25,25,100"],
            &["cube.stl: 20 x 30 x 40 mm does not fit", "25 x 25 x 100", "--turn any"],
        ),
        (&["cube.stl", "--space", "25,35,35", "--turn", "z"], &["at any angle about Z"]),
        (&["open.stl", "--no-repair", space[0], space[1]], &["open.stl", "open edges", "--repair off"]),
        (&["cube.stl*0", space[0], space[1]], &["cube.stl: the count must be between 1 and", "5000"]),
        (&["cube.stl*10000", space[0], space[1]], &["cube.stl: the count must be between 1 and", "5000"]),
        (&["cube.stl*3000", "cube.stl*3000", space[0], space[1]], &["6000 pieces are too many", "5000"]),
        (&["cube.stl", space[0], space[1], "--gap", "0"], &["--gap", "0.01 and 500 mm, got 0 mm"]),
        (&["cube.stl", space[0], space[1], "--gap", "-1"], &["--gap", "0.01 and 500 mm, got -1 mm"]),
        (&["cube.stl", space[0], space[1], "--time", "0"], &["--time", "0.01 and 86400 s, got 0 s"]),
        (&["cube.stl", space[0], space[1], "--turn", "zz"], &["--turn zz", "nearest is z"]),
        (&["cube.stl", space[0], space[1], "--method", "annealing"], &["--method annealing", "anneal"]),
        (&["cube.stl", space[0], space[1], "--method", "anneal"], &["--fill volume"]),
        (&["cube.stl", space[0], space[1], "--fill", "1,2"], &["fill 1,2", "1 numbers"]),
        (&["cube.stl", "--space", "50,50,0"], &["--space", "got 0 mm"]),
        (&["cube.stl", space[0], space[1], "--inflate", "-1"], &["--inflate", "got -1 mm"]),
        (&["cube.stl", "-m", "generic-ac", "--inflate", "1"], &["inflate", "leave out --inflate"]),
        (&["--boxes", "many.txt", space[0], space[1], "--inflate", "1"], &["inflate", "leave out --inflate"]),
        (
            &["cube.stl", space[0], space[1], "--used-distance", "2", "--direction-distance", "9"],
            &["method auto", "--method ip-local-search"],
        ),
        (&["cube.stl", "--space", "50,50"], &["goal runs", "--space X,Y,Z"]),
        (&["cube.stl", "--space", "50,50", "--goal", "fill"], &["goal fill", "--space X,Y,Z"]),
        (&["cube.stl", "-m", "generic-ac", "--goal", "height"], &["goal height", "--space X,Y"]),
        (&["cube.stl", space[0], space[1], "--goal", "hight"], &["--goal hight", "height"]),
        (&["cube.stl", space[0], space[1], "--goal", "runs", "--fill", "volume"], &["goal runs", "--goal fill"]),
        (&["cube.stl", "--space", "25,25", "--goal", "height"], &["20 x 30 x 40 mm does not fit", "25 x 25 mm"]),
        (
            &["cube.stl*2", "--space", "25,35,80.9", "--goal", "height"],
            &["within 80.9 mm", "lower than", "--space X,Y"],
        ),
        (&["cube.stl", space[0], space[1], "--goal", "height", "--method", "tabu"], &["--method auto"]),
        (&["--boxes", "b.txt", space[0], space[1]], &["b.txt, line 2", "10 20", "20 30 15"]),
        (
            &["--boxes", "many.txt", space[0], space[1], "--method", "ip"],
            if Method::Ip.is_built_in() {
                &["61 boxes are too many", "--method auto"]
            } else {
                &["--method auto", "--features"]
            },
        ),
        (&["cube.stl", space[0], space[1], "-o", "file"], &["file"]),
    ];
    for (words, wanted) in cases {
        let text = refused(at, words);
        assert!(wanted.iter().all(|word| text.contains(word)), "{words:?}: {text}");
    }
    assert!(said(&run(at, &["cube.stl"])).contains("--space"));
}

/// A clock on which each look takes a second, and reading a file a minute.
struct Slow(Cell<u64>);

impl Clock for Slow {
    fn now(&self) -> Duration {
        self.0.set(self.0.get() + 1);
        Duration::from_secs(self.0.get())
    }

    fn sleep(&self, _: Duration) {}

    fn boot(&self) -> String {
        String::new()
    }
}

impl Files for Slow {
    fn size(&self, _: &Path) -> Result<u64, FileError> {
        Ok(stl_binary(&block([0.0; 3], [17.0, 13.0, 11.0])).len() as u64)
    }

    fn read(&self, _: &Path) -> Result<Vec<u8>, FileError> {
        self.0.set(self.0.get() + 60);
        Ok(stl_binary(&block([0.0; 3], [17.0, 13.0, 11.0])))
    }

    fn exists(&self, _: &Path) -> bool {
        true
    }
}

/// The time limit is that of the whole job: what is read is not there for the search, and where reading alone takes longer, that is in the result.
#[test]
fn reading_counts_as_time() {
    let run = |seconds: f64| {
        let slow = Slow(Cell::new(0));
        let world = World { files: &slow, clock: &slow, ..World::here(&Silent) };
        let model =
            ModelSource { unit: Some(Unit::Millimetre), ..ModelSource::from(Source::from(Path::new("slow.stl"))) };
        let space = PackSpace::from_str("70,60,50").unwrap();
        let options = PackOptions { seconds: Some(seconds), goal: Some("fill".to_owned()), ..PackOptions::default() };
        let request =
            PackRequest { contents: Contents::Models(vec![(model, 200)]), into: PackInto::Space(space), options };
        trunnion::job::pack(&request, &|| false, &world).unwrap()
    };
    let done = run(100.0);
    assert_eq!(done.ended, Ended::Time);
    assert!(done.reading_s >= 60.0 && done.seconds > 90.0 && done.seconds <= 120.0, "{}", done.seconds);
    let late = run(20.0);
    assert!(late.reading_s > 20.0 && late.seconds < 90.0 && !late.plates[0].pieces.is_empty(), "{}", late.seconds);
    assert_eq!(late.limit_s, Some(20.0));
}

/// Asked to end while it searches, it writes the best so far, says so, and ends as what was interrupted.
#[cfg(unix)]
#[test]
fn an_interrupt_keeps_the_best_so_far() {
    let folder = folder();
    let instance = mpv::instance(7, 100, 1);
    let lines: Vec<String> = instance.items.iter().map(|i| i.size.map(|s| s.to_string()).join(" ")).collect();
    std::fs::write(folder.path().join("b.txt"), lines.join("\n")).unwrap();
    let words = ["pack", "--boxes", "b.txt", "--space", "40,40,40", "--time", "600", "-o", "out", "--json"];
    let mut command = trunnion();
    command.args(words).current_dir(folder.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    // Long after the first packing: what it has used of a processor tells, whatever else the machine does.
    wait_for("its search", || catches_interrupts(child.id()) && processor_s(child.id()).is_none_or(|s| s > 1.5));
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let output = child.wait_with_output().unwrap();
    command.heard(&output);
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    let done: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((done["interrupted"].as_bool(), done["ended"].as_str()), (Some(true), Some("interrupted")));
    assert!(done["runs"].as_u64() > done["lower_bound"].as_u64() && folder.path().join("out/plate-01.3mf").is_file());
}
