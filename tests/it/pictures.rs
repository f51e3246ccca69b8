//! Sheets, views and landscapes as the command writes them: committed ones, the three formats, and names that say none.

use std::path::Path;

use trunnion::mesh::stl_binary;

use crate::pipeline::fixture;
use crate::split::solids;
use crate::support::{fails, folder, root, said, trunnion};

/// What the README of the fixtures shows, of which model, and how it is made; the code that the command ends with.
const SHEETS: [(&str, &str, &[&str], i32); 6] = [
    ("bar-beside-post", "bar-beside-post", &["generic-ac", "--slots", "only-single"], 0),
    ("between-towers", "between-towers", &["generic-ac", "--slots", "only-single"], 0),
    ("under-the-gantry", "under-the-gantry", &["fibr3d", "--slots", "only-single"], 0),
    ("caged", "caged", &["generic-ac"], 1),
    ("hook", "hook", &["generic-ac", "--no-remedies"], 1),
    ("hook-on-supports", "hook", &["generic-ac", "--supports", "auto"], 0),
];

fn sheet(name: &str, words: &[&str], to: &Path, code: i32) -> Vec<u8> {
    let mut run = trunnion();
    run.args(["plan", &fixture(name), "-q", "-m"]).args(words).arg("--sheet").arg(to);
    let run = run.output().unwrap();
    assert_eq!(run.status.code(), Some(code), "{name}: {}", said(&run));
    std::fs::read(to).unwrap()
}

/// UPDATE_FIXTURES=1 writes them anew; look at them before they are committed.
#[test]
fn sheets_are_as_they_were_when_they_were_looked_at() {
    let folder = folder();
    for (name, model, words, code) in SHEETS {
        let drawn = sheet(model, words, &folder.path().join(format!("{name}.svg")), code);
        let kept = root().join(format!("fixtures/{name}.svg"));
        if std::env::var_os("UPDATE_FIXTURES").is_some() {
            std::fs::write(&kept, &drawn).unwrap();
        }
        assert!(drawn == std::fs::read(&kept).unwrap(), "{name}: another picture than the committed one");
        let text = String::from_utf8(drawn).unwrap();
        assert!(text.len() < 150_000, "{name}: {} bytes", text.len());
        for wanted in [">table</text>", "mm</text>", ">X</text>", ">Z</text>"] {
            assert!(text.contains(wanted), "{name}: no {wanted}");
        }
        assert_eq!(text.contains(">supports</text>"), words.contains(&"--supports"), "{name}");
    }
}

/// The sheet of a calibration tower, which its page shows.
#[test]
fn the_towers_sheet_is_as_it_was_when_it_was_looked_at() {
    let folder = folder();
    let words = ["profile", "calibrate", "-q", "-m", "generic-ac", "--tower", "tower"];
    let run = trunnion().current_dir(folder.path()).args(words).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let (drawn, kept) = (folder.path().join("tower/sheet.svg"), root().join("docs/pictures/tower.svg"));
    if std::env::var_os("UPDATE_FIXTURES").is_some() {
        std::fs::copy(&drawn, &kept).unwrap();
    }
    assert!(std::fs::read(&drawn).unwrap() == std::fs::read(&kept).unwrap(), "another sheet than the committed one");
    let text = std::fs::read_to_string(drawn).unwrap();
    for number in 1..=10 {
        // Once in the drawing, once in the list.
        assert_eq!(text.matches(&format!(">{number}</text>")).count(), 2, "{number}");
    }
}

/// Three solids as they are, cut, and as their parts are printed: the README's pictures.
#[test]
fn solids_are_cut_and_printed_as_when_they_were_looked_at() {
    let folder = folder();
    let here = folder.path();
    let done = |words: &[&str]| {
        let run = trunnion().current_dir(here).args(words).output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
    };
    for (name, shape) in [("tee", solids::tee()), ("hook", solids::hook()), ("mushroom", solids::mushroom())] {
        let model = format!("{name}.stl");
        std::fs::write(here.join(&model), stl_binary(&shape.mesh())).unwrap();
        let [cut, printed] = ["cut", "printed"].map(|what| format!("{name}-{what}.svg"));
        done(&["split", &model, "-m", "generic-ac", "-o", "parts.3mf", "--view", &cut]);
        done(&["plan", "parts.3mf", "-m", "generic-ac", "-o", "plan.json", "--sheet", &printed]);
        for file in [cut, printed] {
            let (drawn, kept) = (here.join(&file), root().join("docs/pictures").join(&file));
            if std::env::var_os("UPDATE_FIXTURES").is_some() {
                std::fs::copy(&drawn, &kept).unwrap();
            }
            let same = std::fs::read(&drawn).unwrap() == std::fs::read(&kept).unwrap();
            assert!(same, "{file}: another picture than the committed one");
        }
        let text = std::fs::read_to_string(here.join(format!("{name}-cut.svg"))).unwrap();
        for wanted in [">as it is, from below</text>", ">cut</text>", ">base</text>", ">cut 1</text>"] {
            assert!(text.contains(wanted), "{name}: no {wanted}");
        }
    }
}

#[test]
fn what_no_cut_helps_is_drawn_all_the_same() {
    let folder = folder();
    let here = folder.path();
    std::fs::write(here.join("tee.stl"), stl_binary(&solids::tee().mesh())).unwrap();
    let words = ["split", "tee.stl", "-m", "generic-ac", "-o", "parts.3mf", "--max-cuts", "0", "--view", "view.svg"];
    let run = trunnion().current_dir(here).args(words).output().unwrap();
    assert_eq!(run.status.code(), Some(1), "{}", said(&run));
    let text = std::fs::read_to_string(here.join("view.svg")).unwrap();
    assert!(text.contains(">as it is, from below</text>") && !text.contains(">cut</text>"), "{text}");
    assert!(text.contains("no cut helps") && !here.join("parts.3mf").exists());
}

#[test]
fn a_picture_is_what_its_name_ends_with() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    for (ending, start) in [("svg", &b"<svg "[..]), ("PNG", b"\x89PNG\r\n\x1a\n"), ("pdf", b"%PDF-1.4\n")] {
        let drawn = sheet("two-boxes", &["generic-ac"], &at(&format!("sheet.{ending}")), 0);
        assert!(drawn.starts_with(start), "{ending}");
        let [view, land] = ["view", "land"].map(|name| at(&format!("{name}.{ending}")));
        let mut run = trunnion();
        run.args(["orient", &fixture("two-boxes"), "--whole", "--objective", "height", "--budget", "300", "--view"]);
        let run = run.arg(&view).arg("--landscape").arg(&land).output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
        assert!([view, land].iter().all(|file| std::fs::read(file).unwrap().starts_with(start)), "{ending}");
    }
    let tree = fixture("y-tree");
    let verbs: [&[&str]; 8] = [
        &["profile", "check", "generic-ac", "--view"],
        &["plan", &tree, "-m", "generic-ac", "--sheet"],
        &["prepare", &tree, "-m", "generic-ac", "-o", "x.gcode", "--sheet"],
        &["orient", &tree, "--view"],
        &["orient", &tree, "--landscape"],
        &["support", &tree, "--view"],
        &["split", &tree, "-m", "generic-ac", "-o", "x.3mf", "--view"],
        &["pack", &tree, "--space", "200,200,200", "--view"],
    ];
    for args in verbs {
        for name in ["picture.gif", "picture", "picture.svgz"] {
            let run = trunnion().args(args).arg(at(name)).current_dir(folder.path()).output().unwrap();
            assert_eq!(run.status.code(), Some(2), "{args:?} {name}: {}", said(&run));
            let text = String::from_utf8_lossy(&run.stderr);
            assert!(fails(&text, &format!("setting/ending: {name} | .svg, .png, .pdf")), "{args:?} {name}: {text}");
            assert!(!at(name).exists() && !at("x.gcode").exists(), "{args:?} {name}");
        }
    }
}

/// What the picture says is what the objective is: the landscape of a height has its ends in the bar.
#[test]
fn a_landscape_has_degrees_a_bar_and_its_minima_in_words() {
    let folder = folder();
    let land = folder.path().join("land.svg");
    let mut run = trunnion();
    run.args(["orient", &fixture("cube"), "--objective", "height", "-q", "--landscape"]).arg(&land);
    assert!(run.output().unwrap().status.success());
    let text = std::fs::read_to_string(&land).unwrap();
    // A cube of 20 mm: at least 20, at most its diagonal of 34.64 mm.
    for wanted in [">20.00<", ">34.6", ">0 +X<", ">270 -Y<", ">30<", ">60<", ">+Z up<", ">-Z up<", "20 (global) with"] {
        assert!(text.contains(wanted), "no {wanted:?}");
    }
    assert_eq!(text.matches("(global)").count(), 6, "the six faces");
}
