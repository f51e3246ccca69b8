//! Undo and redo: every change, the bytes of a removed model, two windows, and the buttons and keys of the page.

use serde_json::{Value, json};

use super::browser::{STATE, click, eval, key, quiet, shot, until};
use super::open;
use crate::preview::browser::browse_any;
use crate::support::trunnion;

fn paths(state: &Value) -> Vec<&str> {
    state["models"].as_array().unwrap().iter().map(|model| model["path"].as_str().unwrap()).collect()
}

#[test]
fn a_removed_model_comes_back_with_the_same_bytes() {
    let workbench = open(&["cube"], &["cube.stl", "-m", "generic-ac"]);
    // What the command named is where it begins.
    let none = workbench.posted("/api/undo");
    assert_eq!((none.status, none.json()["code"].as_str()), (409, Some("workbench/no-step")));
    let hook = std::fs::read(crate::pipeline::fixture("hook")).unwrap();
    assert_eq!(workbench.ask("POST", "/api/models?name=hook.stl", &hook).status, 200);
    workbench.post("/api/set?name=slicer&value=builtin");
    let prepared = workbench.run("prepare");
    assert_eq!(prepared["prepared"]["stale"], false);
    let file = workbench.folder.path().join("hook.stl");
    let state = workbench.post("/api/remove?index=1");
    assert_eq!((paths(&state), &state["undo"]), (vec!["cube.stl"], &json!({"what": "remove", "name": "hook.stl"})));
    assert_eq!(state["prepared"]["stale"], true);
    // The file is deleted by somebody, and comes back as it was: what was made of it is current.
    std::fs::remove_file(&file).unwrap();
    let state = workbench.post("/api/undo");
    assert_eq!((paths(&state), &state["prepared"]["stale"]), (vec!["cube.stl", "hook.stl"], &false.into()));
    assert!(std::fs::read(&file).unwrap() == hook);
    assert_eq!(state["redo"], json!({"what": "remove", "name": "hook.stl"}));
    // It is replaced by somebody: that file stays, and the model comes back beside it.
    workbench.post("/api/redo");
    std::fs::write(&file, "solid other").unwrap();
    let state = workbench.post("/api/undo");
    assert_eq!(paths(&state), ["cube.stl", "hook-2.stl"]);
    assert_eq!((workbench.file("hook-2.stl") == hook, workbench.file("hook.stl")), (true, b"solid other".to_vec()));
    // To the beginning: the dropped model goes, too, and comes again.
    workbench.post("/api/undo");
    let state = workbench.post("/api/undo");
    assert_eq!((paths(&state), &state["slicer"], &state["undo"]), (vec!["cube.stl"], &"auto".into(), &Value::Null));
    std::fs::remove_file(workbench.folder.path().join("hook-2.stl")).unwrap();
    assert_eq!(paths(&workbench.post("/api/redo")), ["cube.stl", "hook-2.stl"]);
    assert!(workbench.file("hook-2.stl") == hook);
    assert_eq!(workbench.post("/api/redo")["slicer"], "builtin");
    assert_eq!(paths(&workbench.post("/api/redo")), ["cube.stl"]);
    let none = workbench.posted("/api/redo");
    assert_eq!(none.json()["code"], "workbench/no-step");
}

#[test]
fn of_two_windows_the_later_one_takes_nothing_back_unseen() {
    let workbench = open(&["cube"], &["cube.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=way&value=turned");
    let seen = workbench.state()["revision"].as_u64().unwrap();
    workbench.post("/api/set?name=finish&value=fine");
    for step in ["undo", "redo"] {
        let late = workbench.ask("POST", &format!("/api/{step}?revision={seen}"), b"");
        assert_eq!((late.status, late.json()["code"].as_str()), (409, Some("workbench/old-revision")), "{step}");
    }
    let state = workbench.post("/api/undo");
    assert_eq!((&state["finish"], &state["way"]), (&"auto".into(), &"turned".into()));
    assert!(state["revision"].as_u64().unwrap() > seen + 1);
}

#[test]
fn copies_of_removed_models_go_with_the_workbench() {
    let mut workbench = open(&["cube"], &["cube.stl"]);
    // Only those of one process.
    let kept = |called: &str| {
        let links = std::fs::read_dir(std::env::temp_dir()).unwrap().filter_map(|entry| Some(entry.ok()?.path()));
        let named =
            |path: &std::path::PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(called));
        links.filter(named).count()
    };
    let called = format!("trunnion-removed-{}-", workbench.process.0.id());
    workbench.post("/api/remove?index=0");
    assert_eq!(kept(&called), 1);
    workbench.post("/api/quit");
    assert_eq!((workbench.process.0.wait().unwrap().code(), kept(&called)), (Some(0), 0));
    // Of one that is killed, the next slicer takes them away.
    let mut killed = open(&["cube"], &["cube.stl"]);
    killed.post("/api/remove?index=0");
    let called = format!("trunnion-removed-{}-", killed.process.0.id());
    assert_eq!(kept(&called), 1);
    killed.process.0.kill().unwrap();
    killed.process.0.wait().unwrap();
    let mut next = trunnion();
    next.args(["prepare", "cube.stl", "-m", "generic-ac", "--slicer", "builtin"]).current_dir(killed.folder.path());
    assert!(next.output().unwrap().status.success());
    assert_eq!(kept(&called), 0);
}

#[test]
fn the_page_undoes_and_redoes_by_button_and_by_keys() {
    let workbench = open(&["cube", "hook"], &["cube.stl", "hook.stl", "-m", "generic-ac"]);
    let names = format!("{STATE}.models.map((model) => model.path).join()");
    let are = |wanted: &str| until(&format!("{names} === '{wanted}'"));
    let steps = [
        until(&format!(
            "{STATE} && workbench.page.machines.machines && {STATE}.models.every((model) => model.inspected)"
        )),
        eval("['undo', 'redo'].map((id) => document.getElementById(id).disabled)"),
        click("#models li:last-child .round"),
        are("cube.stl"),
        eval("document.getElementById('undo').getAttribute('aria-label')"),
        shot("undo"),
        click("#undo"),
        are("cube.stl,hook.stl"),
        key("Control+Shift+Z"),
        are("cube.stl"),
        key("Control+z"),
        are("cube.stl,hook.stl"),
        key("Control+y"),
        are("cube.stl"),
        click("#undo"),
        are("cube.stl,hook.stl"),
        // A choice, from the keyboard alone; a field that is typed in has an undo of its own.
        key("2"),
        until("document.getElementById('slicer')"),
        eval(
            "(() => { const s = document.getElementById('slicer'); s.value = 'builtin'; s.dispatchEvent(new Event('change', { bubbles: true })); })()",
        ),
        until(&format!("{STATE}.slicer === 'builtin'")),
        key("4"),
        until("document.getElementById('port')"),
        eval("document.getElementById('port').focus()"),
        json!({"text": "x"}),
        key("Control+z"),
        eval(&format!("{STATE}.slicer")),
        eval("(() => { const p = document.getElementById('port'); p.value = ''; p.blur(); })()"),
        key("Control+z"),
        until(&format!("{STATE}.slicer === 'auto'")),
        // With nothing left the page says so, and asks nobody.
        key("Control+z"),
        until("!document.getElementById('toast').hidden"),
        eval(&format!(
            "[{STATE}.undo, document.getElementById('undo').disabled, document.getElementById('redo').disabled]"
        )),
        json!({"size": [900, 700]}),
        eval("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let results = &answers.results;
    assert_eq!(results[1], json!([true, true]));
    assert!(results[4].as_str().unwrap().ends_with("hook.stl"), "{}", results[4]);
    assert_eq!(results[25], "builtin");
    assert_eq!(results[31], json!([null, true, false]));
    assert_eq!(results[33], json!([900, 700]));
}

/// What a slow server says of a project that has changed since is nobody's picture: the address is a place in the list, and another model may be there.
#[test]
fn a_model_is_never_drawn_as_another_one() {
    let workbench = open(&["cube", "hook"], &["cube.stl", "hook.stl", "-m", "generic-ac"]);
    let drawn = "JSON.stringify(workbench.scene.order.map((m) => m.triangles.reduce((n, t) => n + t.length / 18, 0)))";
    let facets =
        format!("JSON.stringify({STATE}.models.map((m) => m.inspected?.parts?.reduce((n, p) => n + p.facets, 0)))");
    let as_it_is = || until(&format!("{drawn} === {facets} && !workbench.scene.waiting"));
    let steps = [
        until(&format!("{STATE} && workbench.page.machines.machines && {STATE}.models.length === 2")),
        as_it_is(),
        eval(
            "(() => { const real = fetch; window.held = 0; const opened = new Promise((open) => { window.letGo = open; }); \
              window.fetch = (to, ...more) => to.startsWith('/api/model?') ? (window.held++, opened.then(() => real(to, ...more))) : real(to, ...more); \
              const u = document.getElementById('unit'); u.value = 'mm'; u.dispatchEvent(new Event('change', { bubbles: true })); })()",
        ),
        until("window.held === 1"),
        click("#models li:first-child .round"),
        until(&format!("{STATE}.models.length === 1 && {STATE}.models[0].inspected && window.held === 2")),
        eval("window.letGo()"),
        as_it_is(),
        click("#undo"),
        until(&format!("{STATE}.models.length === 2")),
        as_it_is(),
        eval(&facets),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let counted: Vec<usize> = serde_json::from_str(answers.results[11].as_str().unwrap()).unwrap();
    assert!(counted.len() == 2 && counted[0] == 12 && counted[1] != 12, "{counted:?}");
}

/// A choice that changes no picture, made while one is on its way: the model is asked for again, though no later state comes.
#[test]
fn a_choice_beside_it_does_not_lose_a_picture() {
    let workbench = open(&["cube"], &["cube.stl", "-m", "generic-ac"]);
    let wide = "workbench.scene.order[0].high[0] - workbench.scene.order[0].low[0]";
    let choose = "s.dispatchEvent(new Event('change', { bubbles: true }))";
    let steps = [
        until(&format!("{STATE} && workbench.page.machines.machines && workbench.scene.order.length === 1")),
        eval(wide),
        eval(&format!(
            "(() => {{ const real = fetch; window.held = 0; const opened = new Promise((open) => {{ window.letGo = open; }}); \
              window.fetch = (to, ...more) => to.startsWith('/api/model?') ? (window.held++, opened.then(() => real(to, ...more))) : real(to, ...more); \
              const s = document.getElementById('unit'); s.value = 'in'; {choose}; }})()"
        )),
        until("window.held === 1"),
        eval(&format!("(() => {{ const s = document.getElementById('copies-0'); s.value = '2'; {choose}; }})()")),
        until(&format!("{STATE}.models[0].copies === 2")),
        eval("window.letGo()"),
        until(&format!("{wide} > 400")),
        eval(wide),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let [mm, inches] = [1, 8].map(|step| answers.results[step].as_f64().unwrap());
    assert!((inches / mm - 25.4).abs() < 1e-6, "{mm} and {inches}");
}
