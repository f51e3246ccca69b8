//! Each verb once, and each kind of document that its schema lists.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::OnceLock;

use serde_json::Value;
use trunnion::document::event;
use trunnion::job::{At, Figures, Sending};
use trunnion::mesh::stl_binary;
use trunnion::publish::Kind;

use super::checker::name_of;
use super::{documents, heard, schemas};
use crate::calibrate::command::touched;
use crate::pipeline::fixture;
use crate::split::solids;
use crate::support::{folder, said, trunnion};

/// Files that are no verb's own document.
const SHARED: [&str; 4] = ["common.json", "plan-file.json", "certificate.json", "batch.json"];

/// The calls: exit code and words.
const CALLS: [(i32, &str); 51] = [
    (0, "inspect two-boxes.stl"),
    (0, "explain mesh/open"),
    (0, "orient two-boxes.stl --objective height --compare"),
    (0, "orient cube.stl --up 1,0,0"),
    (0, "orient cube.stl --objective overhang-angle --method nelder-mead"),
    (0, "plan two-boxes.stl -m generic-ac --top 2"),
    (0, "plan two-boxes.stl -m own.toml --up 0,0,1 -o own.json"),
    (0, "plan cube.stl -m generic-ac --all"),
    (0, "plan two-boxes.stl -m generic-ac --all --up any"),
    (1, "plan caged.stl -m generic-ac"),
    (0, "split tee.stl -m generic-ac -o parts.3mf"),
    (0, "split tee.stl --convex -o pieces.3mf"),
    (1, "split tee.stl -m generic-ac -o none.3mf --max-cuts 1"),
    (0, "prepare cube.stl -m generic-ac --slicer builtin -o cube.gcode --plan-out cube.json --dry-run cold.gcode"),
    (0, "prepare tee.stl -m generic-ac --slicer builtin -o tee.gcode --way cut"),
    (0, "prepare ding.stl -m generic-ac --slicer builtin -o ding.gcode"),
    (0, "prepare tee.stl hook.stl -m generic-ac --slicer builtin -o two.gcode"),
    (0, "prepare cube.stl*5 -m open5x-prusa --slicer builtin --plates plates"),
    (0, "prepare tee.stl -m generic-ac --slicer builtin -o held.gcode --plan-out held.json --way supports"),
    (1, "prepare cube.stl -m cool.toml --slicer builtin -o none.gcode"),
    (1, "prepare cube.stl -m generic-ac --slicer builtin -o none.gcode --way cut"),
    (1, "prepare caged.stl -m generic-ac --slicer builtin -o none.gcode --split never --supports never"),
    (0, "slice cube.json --slicer builtin -o slots"),
    (0, "slice cube.json --meshes-only -o slots"),
    (0, "rewrite slots/print-00-part-0.gcode --plan cube.json -o again.gcode"),
    (0, "rewrite --in-place --plan cube.json cube.gcode"),
    (0, "verify cube.gcode --plan cube.json --certificate proved.json"),
    (1, "verify hot.gcode --plan cube.json"),
    (0, "verify again.gcode -m generic-ac"),
    (0, "preview cube.gcode --plan cube.json -o view.html"),
    (1, "preview caged.stl -m generic-ac -o why.html"),
    (0, "preview --compare cube.gcode=cube.json again.gcode=cube.json -o both.html"),
    (0, "send cube.gcode --plan cube.json --dry-run"),
    (2, "simulate -m nobody --link tty"),
    (0, "support hook.stl --unit mm"),
    (0, "pack cube.stl*2 tee.stl --space 100,100,100 --unit mm"),
    (0, "pack --boxes boxes.txt --space 40,40,40 --fill volume"),
    (0, "pack --boxes boxes.txt --space 40,40 --goal height"),
    (0, "pack tee.stl*2 --space 100,100,100 --inflate 0.1 --unit mm"),
    (0, "profile list"),
    (0, "profile show own.toml"),
    (0, "profile show generic-hh"),
    (0, "profile show rep5x-ender-3-v3-se"),
    (0, "profile check generic-ac"),
    (0, "profile new mine --like generic-ac --set machine.about=mine --keep-rest -o mine.toml"),
    (
        0,
        "profile import config.g --name imported --keep-rest --set kinematics.tilt.direction=1 --set kinematics.rotation.direction=1 -o imported.toml",
    ),
    (1, "profile calibrate -m machine.toml touches.toml"),
    (0, "profile calibrate -m generic-ac --poses poses.toml --gcode poses.gcode"),
    (0, "profile calibrate -m generic-ac --tower tower"),
    (0, "profile calibrate -m generic-ac tower/measured.toml"),
    (1, "orient models --objective height --method grid -o results"),
];

/// What is printed by each call, and by those for which a server or a bad day is needed: schema, and document.
pub(super) fn made() -> &'static Vec<(String, Value)> {
    static MADE: OnceLock<Vec<(String, Value)>> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = folder();
        prepared(folder.path());
        let mut all = Vec::new();
        for (code, call) in CALLS {
            let words: Vec<String> = call.split(' ').map(str::to_owned).chain(["--json".to_owned()]).collect();
            let mut run = trunnion();
            let run = run.args(&words).current_dir(folder.path()).env("XDG_CONFIG_HOME", folder.path().join("config"));
            let run = run.output().unwrap();
            assert_eq!(run.status.code(), Some(code), "{call}: {}", said(&run));
            all.extend(documents(&words, &run));
            if call.ends_with("--tower tower") {
                let form = folder.path().join("tower/measured.toml");
                std::fs::write(&form, typed(&std::fs::read_to_string(&form).unwrap())).unwrap();
            }
            if call.starts_with("verify cube") {
                let text = std::fs::read_to_string(folder.path().join("cube.gcode")).unwrap();
                std::fs::write(folder.path().join("hot.gcode"), text.replacen("M104 S210", "M104 S400", 1)).unwrap();
            }
        }
        all.extend(crate::jogged::both_verbs().iter().flat_map(|(words, run)| documents(words, run)));
        all.push(("publish.json".to_owned(), crate::publish::once(Kind::Moonraker)));
        all.push(("plan-file.json".to_owned(), read(&folder.path().join("own.json"))));
        all.push(("plan-file.json".to_owned(), read(&folder.path().join("held.json"))));
        all.push(("certificate.json".to_owned(), read(&folder.path().join("proved.json"))));
        all.extend(events());
        all
    })
}

/// A tower's form, filled in as it was drawn.
fn typed(form: &str) -> String {
    let drawn = form.lines().filter_map(|line| line.split_once("drawn as ")?.1.strip_suffix(" mm"));
    drawn.fold(form.to_owned(), |form, mm| form.replacen("mm = []", &format!("mm = [{mm}]"), 1))
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// The files that the calls read.
fn prepared(folder: &Path) {
    let at = |name: &str| folder.join(name);
    for name in ["cube", "two-boxes", "caged", "ding"] {
        std::fs::copy(fixture(name), at(&format!("{name}.stl"))).unwrap();
    }
    for (name, shape) in [("tee", solids::tee()), ("hook", solids::hook())] {
        std::fs::write(at(&format!("{name}.stl")), stl_binary(&shape.mesh())).unwrap();
    }
    std::fs::write(at("own.toml"), "extends = \"generic-ac\"\n[transition]\npark_mm = [0.0, -100.0]\n").unwrap();
    std::fs::write(at("cool.toml"), "extends = \"generic-ac\"\n[link]\nmax_nozzle_c = 150.0\n").unwrap();
    std::fs::write(at("boxes.txt"), "20 20 20 9\n30 10 10 2\n").unwrap();
    let reprap = "M584 X0 Y1 Z2 A3 C4\nM208 X-99:99 Y-99:99 Z-20:150 A-90:90\nM140 H-1\n";
    std::fs::write(at("config.g"), reprap).unwrap();
    touched(folder);
    std::fs::create_dir_all(at("config/trunnion/profiles")).unwrap();
    std::fs::copy(at("own.toml"), at("config/trunnion/profiles/own.toml")).unwrap();
    std::fs::write(at("config/trunnion/profiles/broken.toml"), "[machine]\nnaem = 1\n").unwrap();
    std::fs::create_dir(at("models")).unwrap();
    std::fs::copy(fixture("cube"), at("models/cube.stl")).unwrap();
    std::fs::write(at("models/page.stl"), "<!DOCTYPE html>").unwrap();
}

/// The events of a print, whatever becomes of it.
fn events() -> Vec<(String, Value)> {
    let begun = Figures {
        share: 0.0,
        layer: 0,
        layers: 9,
        slot: None,
        slots: 0,
        seconds_left: 60.0,
        nozzle_c: None,
        bed_c: None,
        waits_for: Some("heat"),
        resends: 0,
    };
    let figures = Figures { share: 0.5, slot: Some(1), nozzle_c: Some([200.0, 210.0]), waits_for: None, ..begun };
    let wait = std::time::Duration::from_secs(1);
    let all = [
        Sending::Start,
        Sending::Progress(figures),
        Sending::Progress(begun),
        Sending::Resend { number: 7, file_line: Some(5), why: "asked for" },
        Sending::Trouble { file_line: 5, text: "cold extrusion prevented" },
        Sending::Paused,
        Sending::Resumed,
        Sending::Full { journal: "a.journal" },
        Sending::Lost { why: "hung up", wait },
        Sending::Reset { reason: "start" },
        Sending::Stopped { reason: "cancelled" },
        Sending::Done { resends: 0 },
    ];
    let at = At { line: 5, of: 9 };
    let mut all: Vec<Value> = all.iter().map(|what| event(what, at).unwrap()).collect();
    let ended = [("tty1", None), ("tty2", Some("hung up"))].map(|(port, error)| {
        let error = error.map(|words| trunnion::world::FileError::NotText { name: words.to_owned() }.into());
        trunnion::job::EndedPrint { port: port.to_owned(), file: "a.gcode".into(), error }
    });
    all.push(trunnion::document::ended(&ended));
    let opened = ("open.json".to_owned(), trunnion::document::opened("http://127.0.0.1:8080/#0f"));
    all.into_iter().map(|event| ("send.json".to_owned(), event)).chain([opened]).collect()
}

/// The verbs of `command`, as their schemas are called.
fn verbs(command: &clap::Command, before: &str) -> BTreeSet<String> {
    let below = |verb: &clap::Command| match verb.has_subcommands() {
        true => verbs(verb, &format!("{}-", verb.get_name())),
        false => BTreeSet::from([format!("{before}{}.json", verb.get_name())]),
    };
    command.get_subcommands().filter(|verb| verb.get_name() != "help").flat_map(below).collect()
}

#[test]
fn every_verb_has_a_schema_and_every_document_of_a_schema_is_printed() {
    let mut wanted = verbs(&trunnion::cli::command(), "");
    wanted.extend(SHARED.map(str::to_owned));
    assert_eq!(schemas().names().map(str::to_owned).collect::<BTreeSet<_>>(), wanted);
    let mut met: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for (file, document) in made() {
        super::holds(file, document, file);
        met.entry(file).or_default().extend(schemas().kind(file, document));
    }
    let verbs =
        wanted.iter().filter(|file| !["common.json", "plan-file.json", "certificate.json"].contains(&file.as_str()));
    for file in verbs {
        let kinds = schemas().of(file)["oneOf"].as_array().unwrap().iter().map(name_of);
        // An error is the same of every verb; `simulate` prints nothing else.
        for kind in kinds.filter(|kind| kind != "error" || file == "simulate.json") {
            assert!(met.get(file.as_str()).is_some_and(|all| all.contains(&kind)), "no document is {file}'s {kind}");
        }
    }
    assert!(met.contains_key("plan-file.json") && met.contains_key("certificate.json"));
}

#[test]
fn every_verb_says_its_error_alike() {
    for file in verbs(&trunnion::cli::command(), "") {
        let verb = file.trim_end_matches(".json");
        let words = [
            verb.replacen("profile-", "profile ", 1).replacen("machine-", "machine ", 1),
            "--no-such-flag --json".to_owned(),
        ]
        .join(" ");
        let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
        let run = trunnion().args(&words).output().unwrap();
        assert_eq!(run.status.code(), Some(2), "{}", said(&run));
        heard(&words, &run);
        let [(of, document)] = &documents(&words, &run)[..] else { panic!("{words:?}: {}", said(&run)) };
        assert_eq!((of, schemas().kind(of, document).as_deref()), (&file, Some("error")));
    }
}
