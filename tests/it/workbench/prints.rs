//! Prints from the page, on the simulated printer.

use serde_json::Value;
use trunnion::publish::Kind;

use super::{Workbench, open_by, open_in};
use crate::link::{profile, simulate};
use crate::publish::{KEY, Server};
use crate::support::{folder, trunnion};

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

/// Two printers of one machine: each prints the file with a journal of its own, and is paused and ended by itself.
#[test]
fn two_printers_print_the_same_file_at_once() {
    let workbench = ready();
    let folder = workbench.folder.path();
    workbench.post("/api/add-printer");
    workbench.post("/api/set?name=printer_name:2&value=the%20left%20one");
    let named = workbench.post("/api/set?name=port:2&value=tty2");
    assert_eq!((&named["printers"][1]["name"], &named["printers"][0]["port"]), (&"the left one".into(), &"tty".into()));
    let _printers =
        ["tty", "tty2"].map(|link| simulate(&folder.join(link), &folder.join("machine.toml"), &["--speed", "40"]));
    let of = |state: &Value, task: &str, key: &str| state["runs"][task][key].clone();
    let begun =
        |state: &Value, task: &str| state["runs"][task]["progress"]["line"].as_u64().is_some_and(|line| line > 0);
    workbench.post("/api/run?task=print:2");
    workbench.until("the second", |state| begun(state, "print:2"));
    workbench.post("/api/word?task=print:2&word=pause");
    workbench.until("its pause", |state| of(state, "print:2", "paused") == true);
    workbench.post("/api/run?task=print");
    let both = workbench.until("the first", |state| begun(state, "print"));
    assert_eq!((of(&both, "print", "paused"), of(&both, "print:2", "paused")), (false.into(), true.into()));
    // Neither comes to its end meanwhile, however long this takes.
    workbench.post("/api/word?task=print&word=pause");
    workbench.until("its pause", |state| of(state, "print", "paused") == true);
    for (journal, task) in [("journal", "print"), ("2.journal", "print:2")] {
        assert!(folder.join(format!("cube.trunnion.gcode.{journal}")).is_file(), "{journal}");
        // While one prints it does nothing else, and the file stays as it is.
        let refused = workbench.posted(&format!("/api/run?task={task}"));
        assert_eq!((refused.status, refused.json()["code"].as_str()), (409, Some("workbench/busy")), "{task}");
    }
    for path in ["/api/run?task=prepare", "/api/remove-printer?index=2"] {
        assert_eq!(workbench.posted(path).json()["code"], "workbench/busy", "{path}");
    }
    // Name and port can be taken back, the printer itself cannot while it prints.
    let undone = [(); 2].map(|()| workbench.posted("/api/undo").status);
    assert_eq!((undone, workbench.posted("/api/undo").json()["code"].as_str()), ([200; 2], Some("workbench/busy")));
    assert_eq!(workbench.post("/api/redo")["printers"][1]["name"], "the left one");
    for task in ["print:2", "print"] {
        workbench.post(&format!("/api/word?task={task}&word=cancel"));
        workbench.until("the end", |state| of(state, task, "running") == false);
    }
    let left = workbench.post("/api/remove-printer?index=2");
    assert_eq!(left["printers"].as_array().unwrap().len(), 1);
    // The next one of that number has done nothing yet.
    let next = workbench.post("/api/add-printer");
    assert_eq!((&next["printers"][1]["name"], &next["runs"]["print:2"]), (&"".into(), &Value::Null));
    assert!(next["runs"]["print"].is_object());
    workbench.post("/api/remove-printer?index=2");
    for (path, code) in [
        ("/api/run?task=print:2", "workbench/bad-choice"),
        ("/api/set?name=port:2&value=x", "workbench/bad-choice"),
        ("/api/set?name=port:1&value=x", "workbench/bad-choice"),
        ("/api/remove-printer?index=1", "workbench/bad-choice"),
        ("/api/word?task=print:2&word=pause", "workbench/not-running"),
    ] {
        assert_eq!(workbench.posted(path).json()["code"], code, "{path}");
    }
}

/// A workbench with a cube on a machine, the key in a file, and that ready.
fn cube_on(machine: &str, key_in_environment: bool) -> Workbench {
    let folder = folder();
    std::fs::copy(crate::pipeline::fixture("cube"), folder.path().join("cube.stl")).unwrap();
    std::fs::write(folder.path().join("printer.key"), format!("{KEY}\n")).unwrap();
    let mut command = trunnion();
    command.env_remove("TRUNNION_KEY");
    if key_in_environment {
        command.env("TRUNNION_KEY", KEY);
    }
    let workbench = open_by(&mut command, folder, &["cube.stl", "-m", machine]);
    workbench.post("/api/set?name=slicer&value=builtin");
    workbench
}

#[test]
fn a_file_goes_to_each_print_server_and_is_started_there() {
    for (kind, machine) in
        [(Kind::OctoPrint, "generic-ac"), (Kind::Moonraker, "fractal-5-pro"), (Kind::Duet, "open5x-voron0")]
    {
        let server = Server::of(kind);
        server.inside().key = Some(KEY.to_owned());
        let workbench = cube_on(machine, false);
        let missing = |workbench: &Workbench| workbench.state()["commands"]["publish"]["why_not"].clone();
        assert!(missing(&workbench).as_str().unwrap().contains("prepare"));
        workbench.run("prepare");
        assert!(missing(&workbench).as_str().unwrap().contains("print server"));
        workbench.post(&format!("/api/set?name=server&value={}", server.to()));
        let locked = workbench.run("publish");
        assert_eq!(locked["runs"]["publish"]["failed"]["code"], "server/no-key", "{}", locked["runs"]["publish"]);
        // A key lies in the project's folder, and nowhere else.
        for path in ["/etc/passwd", "../printer.key", "~/printer.key/..", "-k"] {
            let refused = workbench.posted(&format!("/api/set?name=key_file&value={path}"));
            assert_eq!(refused.json()["code"], "workbench/bad-choice", "{path}");
        }
        workbench.post("/api/set?name=key_file&value=printer.key");
        let done = workbench.run("publish");
        let published = &done["runs"]["publish"]["published"];
        assert_eq!((&published["uploads"], &published["started"]), (&1.into(), &false.into()), "{done}");
        let bytes = std::fs::read(workbench.folder.path().join("cube.trunnion.gcode")).unwrap();
        assert!(server.inside().files.values().any(|file| *file == bytes), "not the same bytes");
        assert_eq!(server.inside().started, 0);
        let begun = workbench.run("publish-and-start");
        let published = &begun["runs"]["publish-and-start"]["published"];
        assert_eq!((&published["uploads"], &published["started"]), (&0.into(), &true.into()), "{begun}");
        assert_eq!(server.inside().started, 1);
        assert!(begun["runs"]["publish"].is_null(), "the last upload is told alone");
        assert!(!begun.to_string().contains(KEY), "the key is on the page");
        let again = workbench.run("prepare");
        assert!(again["runs"]["publish-and-start"].is_null(), "an upload of another file is told");
    }
}

/// The key that the workbench was started with goes to uploads, and to no other job.
#[test]
fn a_key_in_the_environment_is_enough() {
    let server = Server::of(Kind::OctoPrint);
    server.inside().key = Some(KEY.to_owned());
    let workbench = cube_on("generic-ac", true);
    workbench.run("prepare");
    workbench.post(&format!("/api/set?name=server&value={}", server.to()));
    let done = workbench.run("publish-and-start");
    assert_eq!(done["runs"]["publish-and-start"]["published"]["started"], true, "{done}");
}
