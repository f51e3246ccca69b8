//! Project files: saved, opened by the page and by the command to the same bytes, and what a bad one is refused with.

use std::io::Write;
use std::path::Path;

use serde_json::{Value, json};
use zip::write::SimpleFileOptions;

use super::browser::{STATE, click, eval, key, quiet, shot, until};
use super::{Workbench, open, open_in};
use crate::preview::browser::browse_any;
use crate::support::{folder, said, trunnion};

const FILES: [&str; 3] = ["gcode", "plan.json", "html"];

/// A workbench whose project has two models, one of them twice and below a folder, and a machine of its own.
fn with_a_project() -> Workbench {
    let folder = folder();
    std::fs::create_dir(folder.path().join("parts")).unwrap();
    std::fs::copy(crate::pipeline::fixture("hook"), folder.path().join("hook.stl")).unwrap();
    std::fs::copy(crate::pipeline::fixture("cube"), folder.path().join("parts/cube.stl")).unwrap();
    std::fs::write(folder.path().join("mine.toml"), "extends = \"generic-ac\"\n[process]\nlayer_height_mm = 0.25\n")
        .unwrap();
    let workbench = open_in(folder, &["hook.stl", "parts/cube.stl", "-m", "mine.toml"]);
    workbench.post("/api/copies?index=1&value=2");
    workbench.post("/api/set?name=slicer&value=builtin");
    workbench.post("/api/set?name=way&value=supports");
    workbench.post("/api/set?name=port&value=tcp:host:1");
    workbench
}

/// An archive of these files.
fn zipped(members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, bytes) in members {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn manifest(version: u64, command: &[&str]) -> Vec<u8> {
    json!({"format": "trunnion project", "version": version, "command": command}).to_string().into_bytes()
}

/// `trunnion prepare` of a project in a folder of its own.
fn prepared(project: &Path, words: &[&str]) -> (tempfile::TempDir, Value) {
    let elsewhere = folder();
    let done = trunnion()
        .arg("prepare")
        .arg(project)
        .args(words)
        .arg("--json")
        .current_dir(elsewhere.path())
        .output()
        .unwrap();
    let document = serde_json::from_slice(&done.stdout).unwrap_or_else(|why| panic!("{why}: {}", said(&done)));
    (elsewhere, document)
}

#[test]
fn a_saved_project_makes_the_same_bytes_by_page_and_by_command() {
    let workbench = with_a_project();
    let state = workbench.run("prepare");
    assert_eq!(state["prepared"]["stale"], false, "{}", state["prepared"]["document"]);
    let state = workbench.post("/api/save");
    assert_eq!(state["file"], json!({"name": "hook.trunnion", "saved": true}));
    let project = workbench.folder.path().join("hook.trunnion");
    let (elsewhere, document) = prepared(&project, &[]);
    assert!(document["error"].is_null(), "{document}");
    for end in FILES {
        let name = format!("hook.trunnion.{end}");
        assert!(workbench.file(&name) == std::fs::read(elsewhere.path().join(&name)).unwrap(), "{name}");
    }
    // Its models are there with their bytes, and its plan, which is that of what was prepared.
    for name in ["hook.stl", "parts/cube.stl", "mine.toml"] {
        assert!(workbench.file(name) == std::fs::read(elsewhere.path().join(name)).unwrap(), "{name}");
    }
    // Opened elsewhere it is the same project, but for the printer's port, and its page makes the same bytes.
    let opened = open_in(folder(), &[project.to_str().unwrap()]);
    let state = opened.state();
    let before = workbench.state();
    for key in ["machine", "way", "slicer", "unit", "up", "finish", "plate", "commands"] {
        let commands =
            |state: &Value| if key == "commands" { state[key]["prepare"].clone() } else { state[key].clone() };
        assert_eq!(commands(&state), commands(&before), "{key}");
    }
    assert_eq!(
        (&state["printers"][0]["port"], &state["undo"], &state["file"]["name"]),
        (&"".into(), &Value::Null, &Value::Null)
    );
    assert!(opened.file("hook.trunnion.plan.json") == workbench.file("hook.trunnion.plan.json"));
    opened.run("prepare");
    for end in FILES {
        let name = format!("hook.trunnion.{end}");
        assert!(workbench.file(&name) == opened.file(&name), "{name}");
    }
    // Saved there it is the same file.
    opened.post("/api/save");
    assert!(opened.file("hook.trunnion") == workbench.file("hook.trunnion"));
}

#[test]
fn a_project_replaces_no_file_but_its_own() {
    let workbench = with_a_project();
    std::fs::write(workbench.folder.path().join("hook.trunnion"), "another's").unwrap();
    assert_eq!(workbench.post("/api/save")["file"], json!({"name": "hook-2.trunnion", "saved": true}));
    assert_eq!(workbench.file("hook.trunnion"), b"another's");
    let state = workbench.post("/api/set?name=finish&value=fine");
    assert_eq!(state["file"], json!({"name": "hook-2.trunnion", "saved": false}));
    let first = workbench.file("hook-2.trunnion");
    assert_eq!(workbench.post("/api/undo")["file"]["saved"], true);
    workbench.post("/api/redo");
    assert_eq!(workbench.post("/api/save")["file"], json!({"name": "hook-2.trunnion", "saved": true}));
    assert!(first != workbench.file("hook-2.trunnion"));
    let answer = workbench.ask("GET", "/files/hook-2.trunnion", b"");
    assert!(answer.status == 200 && answer.body == workbench.file("hook-2.trunnion"));
    // Where a model of the same name is another one, the project's has a name of its own.
    let elsewhere = folder();
    std::fs::write(elsewhere.path().join("hook.stl"), "solid other").unwrap();
    let opened = open_in(elsewhere, &[workbench.folder.path().join("hook-2.trunnion").to_str().unwrap()]);
    assert_eq!(opened.state()["models"][0]["path"], "hook-2.stl");
    assert_eq!(opened.file("hook.stl"), b"solid other");
    // Words behind the project are those of prepare.
    let (elsewhere, document) = prepared(&workbench.folder.path().join("hook-2.trunnion"), &["-o", "own.gcode"]);
    assert!(
        document["output"] == "own.gcode" && elsewhere.path().join("hook.trunnion.plan.json").is_file(),
        "{document}"
    );
    // A model that is gone cannot be saved.
    std::fs::remove_file(workbench.folder.path().join("hook.stl")).unwrap();
    let refused = workbench.posted("/api/save");
    assert_eq!((refused.status, refused.json()["code"].as_str()), (409, Some("workbench/project-unread")));
    let empty = open(&[], &[]);
    assert_eq!(empty.posted("/api/save").json()["code"], "workbench/not-yet");
}

#[test]
fn a_bad_project_is_refused_with_a_code_and_leaves_nothing() {
    let hook = std::fs::read(crate::pipeline::fixture("hook")).unwrap();
    let good: &[&str] = &["prepare", "hook.stl", "-m", "generic-ac"];
    let with = |command: &[&str]| zipped(&[("project.json", &manifest(1, command)), ("hook.stl", &hook)]);
    let machine = |text: &str| {
        zipped(&[
            ("project.json", &manifest(1, &["prepare", "hook.stl", "-m", "own.toml"])),
            ("hook.stl", &hook),
            ("own.toml", text.as_bytes()),
        ])
    };
    // So many zeros are packed a thousand times smaller.
    let bomb = vec![0; 90 << 20];
    let mut cut = with(good);
    cut.truncate(cut.len() / 2);
    let mut flipped = with(good);
    let middle = flipped.len() / 2;
    flipped[middle..middle + 400].fill(0x55);
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("no zip", b"solid".to_vec(), "damaged"),
        ("an empty file", Vec::new(), "damaged"),
        ("cut", cut, "damaged"),
        ("flipped", flipped, "damaged"),
        ("no manifest", zipped(&[("hook.stl", &hook)]), "damaged"),
        ("no JSON", zipped(&[("project.json", b"{"), ("hook.stl", &hook)]), "damaged"),
        ("another format", zipped(&[("project.json", b"{\"format\": \"x\", \"version\": 1}")]), "damaged"),
        ("no command", zipped(&[("project.json", b"{\"format\": \"trunnion project\", \"version\": 1}")]), "damaged"),
        ("newer", zipped(&[("project.json", &manifest(2, good)), ("hook.stl", &hook)]), "newer"),
        ("no model", zipped(&[("project.json", &manifest(1, good))]), "missing"),
        ("no machine", with(&["prepare", "hook.stl", "-m", "own.toml"]), "missing"),
        ("a way up", zipped(&[("project.json", &manifest(1, good)), ("../hook.stl", &hook)]), "name"),
        ("a root", zipped(&[("project.json", &manifest(1, good)), ("/tmp/hook.stl", &hook)]), "name"),
        ("a drive", zipped(&[("project.json", &manifest(1, good)), ("X:hook.stl", &hook)]), "name"),
        ("a hidden folder", zipped(&[("project.json", &manifest(1, good)), (".git/hook.stl", &hook)]), "name"),
        ("a profile that leads out", machine("extends = \"/etc/passwd.toml\"\n"), "name"),
        ("a bomb", zipped(&[("project.json", &manifest(1, good)), ("hook.stl", &bomb)]), "too-large"),
        ("a large manifest", zipped(&[("project.json", &bomb[..2 << 20])]), "too-large"),
        ("an output", with(&["prepare", "hook.stl", "-m", "generic-ac", "-o", "x.gcode"]), "word"),
        ("a slicer of its own", with(&["prepare", "hook.stl", "-m", "generic-ac", "--slicer", "/bin/sh"]), "word"),
        ("a port", with(&["prepare", "hook.stl", "-m", "generic-ac", "--port", "x"]), "word"),
        ("another verb", with(&["send", "hook.stl", "-m", "generic-ac"]), "word"),
        ("a model elsewhere", with(&["prepare", "../hook.stl", "-m", "generic-ac"]), "word"),
        ("a model twice", with(&["prepare", "hook.stl", "hook.stl", "-m", "generic-ac"]), "word"),
        ("no such machine", with(&["prepare", "hook.stl", "-m", "none"]), "word"),
        ("a flag without a value", with(&["prepare", "hook.stl", "-m"]), "word"),
    ];
    let workbench = open(&["cube"], &["cube.stl", "-m", "generic-ac"]);
    let here = folder();
    let path = here.path().join("bad.trunnion");
    for (what, bytes, wanted) in cases {
        let wanted = format!("workbench/project-{wanted}");
        std::fs::write(&path, &bytes).unwrap();
        let (elsewhere, document) = prepared(&path, &[]);
        assert_eq!(document["code"], wanted, "{what}: {document}");
        assert_eq!(std::fs::read_dir(elsewhere.path()).unwrap().count(), 0, "{what}");
        let done = trunnion()
            .args(["open", "--no-browser", "--json"])
            .arg(&path)
            .current_dir(elsewhere.path())
            .output()
            .unwrap();
        let document: Value = serde_json::from_slice(&done.stdout).unwrap();
        assert_eq!((done.status.code(), &document["code"]), (Some(2), &json!(wanted)), "{what}");
        assert_eq!(std::fs::read_dir(elsewhere.path()).unwrap().count(), 0, "{what}");
        let dropped = workbench.ask("POST", "/api/models?name=bad.trunnion", &bytes);
        assert_eq!((dropped.status, dropped.json()["code"].clone()), (400, json!(wanted)), "{what}");
    }
    assert_eq!(std::fs::read_dir(workbench.folder.path()).unwrap().count(), 1);
    let state = workbench.state();
    assert_eq!((&state["models"][0]["path"], &state["undo"]), (&"cube.stl".into(), &Value::Null));
    let (_, document) = prepared(&here.path().join("none.trunnion"), &[]);
    assert_eq!(document["code"], "workbench/project-unread");
    let two = trunnion()
        .args(["open", "--no-browser", "--json", "a.trunnion", "b.trunnion"])
        .current_dir(here.path())
        .output()
        .unwrap();
    assert_eq!(serde_json::from_slice::<Value>(&two.stdout).unwrap()["code"], "workbench/second-project");
    let name = workbench.ask("POST", "/api/models?name=..%2fa.trunnion", &with(good));
    assert_eq!(name.json()["code"], "workbench/bad-name");
}

/// A folder of the project's that is a link is followed nowhere.
#[cfg(unix)]
#[test]
fn a_link_in_the_folder_leads_no_project_out_of_it() {
    let (here, outside) = (folder(), folder());
    let hook = std::fs::read(crate::pipeline::fixture("hook")).unwrap();
    std::os::unix::fs::symlink(outside.path(), here.path().join("parts")).unwrap();
    for model in ["parts/hook.stl", "parts/deeper/hook.stl"] {
        let (project, command) = (here.path().join("a.trunnion"), ["prepare", model, "-m", "generic-ac"]);
        std::fs::write(&project, zipped(&[("project.json", &manifest(1, &command)), (model, &hook)])).unwrap();
        let done = trunnion().arg("prepare").arg(&project).arg("--json").current_dir(here.path()).output().unwrap();
        let document: Value = serde_json::from_slice(&done.stdout).unwrap();
        assert_eq!(document["code"], "workbench/project-name");
        assert!(document["error"].as_str().is_some_and(|error| error.contains("a.trunnion")), "{document}");
        assert_eq!(std::fs::read_dir(outside.path()).unwrap().count(), 0, "{model}");
    }
}

/// A line with a mistake is refused before anything is unpacked.
#[test]
fn a_wrong_line_unpacks_nothing() {
    let (here, there) = (folder(), folder());
    let hook = std::fs::read(crate::pipeline::fixture("hook")).unwrap();
    let project = there.path().join("a.trunnion");
    let command = ["prepare", "hook.stl", "-m", "generic-ac"];
    std::fs::write(&project, zipped(&[("project.json", &manifest(1, &command)), ("hook.stl", &hook)])).unwrap();
    for words in [&["--slicr", "builtin"][..], &["-m", "generic-ac"], &["--slicer"]] {
        let done = trunnion().arg("prepare").arg(&project).args(words).current_dir(here.path()).output().unwrap();
        assert_eq!((done.status.code(), std::fs::read_dir(here.path()).unwrap().count()), (Some(2), 0), "{words:?}");
    }
    let mut right = trunnion();
    right.arg("prepare").arg(&project).args(["--slicer", "builtin"]).current_dir(here.path());
    assert!(right.output().unwrap().status.success() && here.path().join("hook.stl").exists());
}

#[test]
fn the_page_saves_and_opens_by_button_and_by_keys() {
    let workbench = open(&["cube", "hook"], &["cube.stl", "-m", "generic-ac"]);
    let other = with_a_project();
    other.post("/api/save");
    let project = other.folder.path().join("hook.trunnion").display().to_string();
    let steps = [
        until(&format!(
            "{STATE} && workbench.page.machines.machines && {STATE}.models.every((model) => model.inspected)"
        )),
        eval("document.getElementById('file-project')"),
        click("#save"),
        // The state may come before the answer that the page tells of.
        until("document.getElementById('toast').textContent.includes('cube.trunnion')"),
        until(&format!("{STATE}.file.saved && document.getElementById('file-project')")),
        eval("document.getElementById('file-project').getAttribute('href')"),
        shot("saved"),
        eval(
            "(() => { const u = document.getElementById('unit'); u.value = 'mm'; u.dispatchEvent(new Event('change', { bubbles: true })); })()",
        ),
        until(&format!("{STATE}.unit === 'mm' && !{STATE}.file.saved")),
        key("Control+s"),
        until(&format!("{STATE}.file.saved")),
        // Another project is dropped: it takes the place of this one, and that can be taken back.
        json!({"files": [project]}),
        until(&format!("{STATE}.models.length === 2 && {STATE}.models.every((model) => model.inspected)")),
        eval("document.getElementById('command').textContent"),
        eval("document.getElementById('machine').value"),
        eval("document.getElementById('undo').getAttribute('aria-label')"),
        key("Control+z"),
        until(&format!("{STATE}.models.length === 1 && {STATE}.models[0].path === 'cube.stl'")),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let results = &answers.results;
    assert_eq!(results[1], Value::Null);
    assert_eq!(results[5], "/files/cube.trunnion");
    assert_eq!(results[14], "mine.toml");
    assert!(results[15].as_str().unwrap().contains("hook.trunnion"), "{}", results[15]);
}
