//! Prints from the page, on the simulated printer.

use serde_json::Value;

use super::{Workbench, open_in};
use crate::link::{profile, simulate};
use crate::support::folder;

/// A workbench with a cube that is ready to print, on a machine of its own.
fn ready() -> Workbench {
    let folder = folder();
    profile(folder.path());
    std::fs::copy(crate::pipeline::fixture("cube"), folder.path().join("cube.stl")).unwrap();
    let workbench = open_in(folder, &["cube.stl", "-m", "machine.toml"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    let state = workbench.run("prepare");
    assert!(state["prepared"]["document"]["verify"].is_object(), "{}", state["prepared"]);
    workbench.post("/api/set?name=port&value=tty");
    workbench
}

fn print(state: &Value) -> &Value {
    &state["runs"]["print"]
}

#[test]
fn a_print_is_paused_continued_and_ended_and_outlives_the_page() {
    let workbench = ready();
    let log = workbench.folder.path().join("sim.log");
    let machine = workbench.folder.path().join("machine.toml");
    let _printer =
        simulate(&workbench.folder.path().join("tty"), &machine, &["--speed", "40", "--log", log.to_str().unwrap()]);
    workbench.post("/api/run?task=print");
    let begun = |state: &Value| print(state)["progress"]["line"].as_u64().is_some_and(|line| line > 0);
    // This page closes; the next one hears of the same print.
    workbench.until("the print", begun);
    let quit = workbench.posted("/api/quit");
    assert_eq!((quit.status, quit.json()["code"].as_str()), (409, Some("workbench/printing")));
    for word in ["continue", "cancel"] {
        workbench.post("/api/word?task=print&word=pause");
        let paused = workbench.until("the pause", |state| print(state)["paused"] == true);
        assert_eq!(print(&paused)["running"], true);
        workbench.post(&format!("/api/word?task=print&word={word}"));
        workbench.until(word, |state| print(state)["paused"] == false);
    }
    let ended = workbench.until("the end", |state| print(state)["running"] == false);
    assert_eq!(print(&ended)["event"]["event"], "stopped", "{}", print(&ended));
    assert!(!crate::link::killed(&log));
}

#[test]
fn a_print_comes_to_its_end_and_one_that_is_stopped_at_once_stops_the_printer() {
    let workbench = ready();
    let log = workbench.folder.path().join("sim.log");
    let (link, machine) = (workbench.folder.path().join("tty"), workbench.folder.path().join("machine.toml"));
    {
        let _printer = simulate(&link, &machine, &["--speed", "max", "--log", log.to_str().unwrap()]);
        let done = workbench.run("print");
        assert_eq!(
            (&print(&done)["exit"], &print(&done)["event"]["event"]),
            (&0.into(), &"done".into()),
            "{}",
            print(&done)
        );
    }
    let _printer = simulate(&link, &machine, &["--speed", "5", "--log", log.to_str().unwrap()]);
    workbench.post("/api/run?task=print");
    workbench.until("the print", |state| print(state)["progress"]["line"].as_u64().is_some_and(|line| line > 0));
    workbench.post("/api/word?task=print&word=stop");
    let ended = workbench.until("the end", |state| print(state)["running"] == false);
    assert!(crate::link::killed(&log), "{}", print(&ended));
}
