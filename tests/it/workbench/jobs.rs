//! Jobs of the page: the bytes of the command, stops, crashes, what is out of date, and two pages.

use serde_json::Value;

use super::{by_hand, open};
use crate::support::{trunnion, wait_for};

fn line(state: &Value) -> String {
    state["commands"]["prepare"]["line"].as_str().unwrap().to_owned()
}

#[test]
fn a_dropped_model_becomes_the_same_bytes_as_by_the_command_that_is_shown() {
    let workbench = open(&[], &["-m", "generic-ac"]);
    let hook = std::fs::read(crate::pipeline::fixture("hook")).unwrap();
    let answer = workbench.ask("POST", "/api/models?name=hook.stl", &hook);
    assert_eq!(answer.status, 200, "{}", answer.head);
    let state = workbench.until("the model", |state| state["models"][0]["inspected"].is_object());
    assert_eq!(state["models"][0]["inspected"]["parts"][0]["closed"], true);
    workbench.post("/api/set?name=slicer&value=builtin");
    let state = workbench.run("prepare");
    let (ways, prepared) = (&state["ways"], &state["prepared"]);
    assert_eq!((&ways["stale"], &prepared["stale"]), (&false.into(), &false.into()), "{prepared}");
    let chosen = |state: &Value| {
        let ways = state["prepared"]["document"]["ways"].as_array().unwrap().clone();
        ways.iter().find(|way| way["chosen"] == true).unwrap()["way"].as_str().unwrap().to_owned()
    };
    assert_eq!(chosen(&state), "turned");
    let same = |state: &Value| {
        let elsewhere = by_hand(&line(state), workbench.folder.path());
        for name in ["hook.trunnion.gcode", "hook.trunnion.plan.json"] {
            assert!(
                workbench.file(name) == std::fs::read(elsewhere.path().join(name)).unwrap(),
                "{name} by {}",
                line(state)
            );
        }
    };
    same(&state);
    // Another way is one change, and the file is out of date until it is made anew.
    let state = workbench.post("/api/set?name=way&value=supports");
    assert_eq!((&state["ways"]["stale"], &state["prepared"]["stale"]), (&false.into(), &true.into()));
    assert!(line(&state).contains(" --way supports "), "{}", line(&state));
    let refused = workbench.posted("/api/run?task=rehearse");
    assert_eq!((refused.status, refused.json()["code"].as_str()), (409, Some("workbench/not-yet")));
    let state = workbench.run("prepare");
    assert_eq!((chosen(&state).as_str(), state["ways"]["ways"].as_array().unwrap().len()), ("supports", 4));
    same(&state);
    let state = workbench.run("rehearse");
    assert_eq!(
        (&state["runs"]["rehearse"]["exit"], &state["runs"]["rehearse"]["event"]["event"]),
        (&0.into(), &"done".into())
    );
    // A file that changes behind the page's back is read anew, and nothing of before is current.
    let cube = std::fs::read(crate::pipeline::fixture("cube")).unwrap();
    std::fs::write(workbench.folder.path().join("hook.stl"), cube).unwrap();
    let state = workbench.state();
    assert_eq!((&state["ways"]["stale"], &state["prepared"]["stale"]), (&true.into(), &true.into()));
    workbench.until("the new model", |state| state["models"][0]["inspected"]["parts"][0]["facets"] == 12);
}

#[test]
fn of_two_pages_the_later_hears_that_the_project_has_changed() {
    let workbench = open(&["cube", "hook"], &["cube.stl", "hook.stl", "-m", "generic-ac"]);
    let revision = workbench.state()["revision"].as_u64().unwrap();
    let change = |path: &str, revision: u64| workbench.ask("POST", &format!("/api/{path}&revision={revision}"), b"");
    assert_eq!(change("set?name=way&value=cut", revision).status, 200);
    for path in ["set?name=way&value=turned", "remove?index=0", "copies?index=0&value=2", "run?task=prepare"] {
        let late = change(path, revision);
        assert_eq!((late.status, late.json()["code"].as_str()), (409, Some("workbench/old-revision")), "{path}");
    }
    assert_eq!(workbench.ask("POST", "/api/remove?index=0", b"").status, 409);
    let state = workbench.state();
    assert_eq!(
        (&state["way"], state["models"].as_array().unwrap().len(), state["runs"].as_object().unwrap().len()),
        (&"cut".into(), 2, 0)
    );
    assert_eq!(change("remove?index=0", revision + 1).status, 200);
    assert_eq!(workbench.state()["models"][0]["path"], "hook.stl");
}

#[test]
fn a_job_that_is_stopped_or_crashes_leaves_the_project_as_it_was() {
    let workbench = open(&["candelabrum"], &["candelabrum.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    let runs = |state: &Value| state["runs"]["prepare"]["notes"].as_array().is_some_and(|notes| !notes.is_empty());
    let before = workbench.until("the model", |state| state["models"][0]["inspected"].is_object());
    for crashes in [false, true] {
        workbench.post("/api/run?task=prepare");
        workbench.until("a first word of the job", runs);
        let busy = workbench.posted("/api/run?task=prepare");
        assert_eq!((busy.status, busy.json()["code"].as_str()), (409, Some("workbench/busy")));
        match crashes {
            true => assert!(
                std::process::Command::new("kill")
                    .args(["-KILL", &child(&workbench).to_string()])
                    .status()
                    .unwrap()
                    .success()
            ),
            false => _ = workbench.post("/api/word?task=prepare&word=stop"),
        }
        let after = workbench.until("the end", |state| state["runs"]["prepare"]["running"] == false);
        let code = if crashes { "workbench/crashed" } else { "command/interrupted" };
        assert_eq!(after["runs"]["prepare"]["failed"]["code"], code, "{}", after["runs"]["prepare"]);
        for key in ["models", "machine", "way", "revision", "ways"] {
            assert_eq!(after[key], before[key], "{key}");
        }
        assert!(!workbench.folder.path().join("candelabrum.trunnion.gcode").exists());
        let idle = workbench.posted("/api/word?task=prepare&word=stop");
        assert_eq!(idle.json()["code"], "workbench/not-running");
    }
}

/// The process of the job that runs.
fn child(workbench: &super::Workbench) -> u32 {
    let server = workbench.process.0.id();
    let tasks = std::fs::read_dir(format!("/proc/{server}/task")).unwrap();
    let children = tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("children")).ok());
    children
        .flat_map(|text| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
        .find_map(|id| id.parse().ok())
        .unwrap()
}

#[test]
fn what_cannot_be_read_is_told_with_the_words_of_the_command() {
    let workbench = open(&[], &["gone.stl", "-m", "generic-ac"]);
    let open_mesh = b"OFF\n4 2 0\n0 0 0\n20 0 0\n0 20 0\n20 20 9\n3 0 1 2\n3 1 3 2\n";
    assert_eq!(workbench.ask("POST", "/api/models?name=open.off", open_mesh).status, 200);
    let state = workbench.until("both", |state| (0..2).all(|i| state["models"][i]["inspected"].is_object()));
    for (index, file) in ["gone.stl", "open.off"].into_iter().enumerate() {
        let done = trunnion().args(["inspect", file, "--json"]).current_dir(workbench.folder.path()).output().unwrap();
        let wanted: Value = serde_json::from_slice(&done.stdout).unwrap();
        assert!(wanted["error"].is_string(), "{wanted}");
        assert_eq!(state["models"][index]["inspected"], wanted, "{file}");
        assert_eq!(workbench.model(index).json()["code"], wanted["code"], "{file}");
    }
    workbench.post("/api/remove?index=0");
    let failed = workbench.run("prepare");
    assert_eq!(failed["prepared"]["document"]["code"], failed["models"][0]["inspected"]["code"]);
    assert_eq!(failed["runs"]["prepare"]["failed"]["code"], failed["models"][0]["inspected"]["code"]);
}

#[test]
fn machine_and_model_can_be_drawn() {
    let workbench = open(&["two-boxes"], &["two-boxes.stl", "-m", "generic-ac"]);
    let drawn = workbench.get("/api/machine");
    assert!(
        drawn["machine"]["table"]["points"].as_array().unwrap().len() > 20
            && drawn["steepest_deg"].as_f64().unwrap() > 30.0
    );
    let block = workbench.model(0).body;
    let length = u32::from_le_bytes(block[..4].try_into().unwrap()) as usize;
    let head: Value = serde_json::from_slice(&block[4..4 + length]).unwrap();
    assert_eq!(head["parts"].as_array().unwrap().len(), 2);
    // A page that has not yet seen the newest state gets no model that it would take for another, and hears that it is to ask again.
    for late in ["/api/model?index=0", "/api/model?index=0&revision=0", "/api/model?index=7&revision=0"] {
        assert_eq!(workbench.get(late)["code"], "workbench/old-revision", "{late}");
    }
    let asked = format!("/api/model?index=1&revision={}", workbench.state()["revision"]);
    assert_eq!(workbench.ask("GET", &asked, b"").status, 404);
    wait_for("the machines", || workbench.get("/api/machines")["machines"].is_array());
    let list = trunnion().args(["profile", "list", "--json"]).output().unwrap();
    assert_eq!(workbench.get("/api/machines")["machines"], serde_json::from_slice::<Value>(&list.stdout).unwrap());
    assert_eq!(workbench.post("/api/set?name=machine&value=generic-bc")["machine"], "generic-bc");
    assert_eq!(workbench.posted("/api/set?name=machine&value=%2fetc%2fpasswd").json()["code"], "workbench/bad-choice");
}

#[test]
fn the_button_and_ctrl_c_end_it() {
    for signal in [false, true] {
        let mut workbench = open(&[], &[]);
        match signal {
            true => crate::link::interrupt(&workbench.process.0),
            false => _ = workbench.post("/api/quit"),
        }
        assert_eq!(workbench.process.0.wait().unwrap().code(), Some(0), "by a signal: {signal}");
    }
}
