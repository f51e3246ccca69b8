//! The project by hand.

use super::*;

fn project() -> Project {
    let mut project = Project::new(Some("generic-ac".to_owned()));
    project.add("parts/hook.stl");
    project.models[0].stamp = Some((100, 1));
    project
}

fn set(project: &mut Project, name: &str, value: &str) {
    let machines = ["generic-ac".to_owned(), "generic-bc".to_owned()];
    project.change(&ProjectChange::Set(name.to_owned(), value.to_owned()), &machines).unwrap();
}

fn prepared(project: &mut Project, document: Value) {
    let (whole, basis) = (project.whole(), project.basis());
    project.take(whole, basis, document);
}

#[test]
fn the_command_line_says_what_was_chosen_and_no_more() {
    let mut project = project();
    let prepare = |project: &Project| line(&project.words(Task::Prepare).unwrap());
    let files = "-o hook.trunnion.gcode --plan-out hook.trunnion.plan.json --preview hook.trunnion.html";
    assert_eq!(prepare(&project), format!("trunnion prepare parts/hook.stl -m generic-ac {files}"));
    set(&mut project, "way", "supports");
    set(&mut project, "slicer", "builtin");
    project.add("it's 2.stl");
    project.change(&ProjectChange::Copies(1, "3".to_owned()), &[]).unwrap();
    let wanted = format!(
        "trunnion prepare parts/hook.stl 'it'\\''s 2.stl*3' -m generic-ac --way supports --slicer builtin {files}"
    );
    assert_eq!(prepare(&project), wanted);
    assert_eq!(line(&["".to_owned(), "a;b".to_owned(), "$x".to_owned()]), "trunnion '' 'a;b' '$x'");
    set(&mut project, "up", "-1,0,0.5");
    assert!(prepare(&project).contains(" -m generic-ac --up -1,0,0.5 --way supports "), "{}", prepare(&project));
    set(&mut project, "up", "recommended");
    assert!(prepare(&project).contains(" --up auto "), "{}", prepare(&project));
    set(&mut project, "plate", "2");
    assert!(prepare(&project).contains(" --plate 2 ") && line(&project.inspect(0)).ends_with("--plate 2"));
    assert!(!line(&project.inspect(1)).contains("plate"), "the command takes a plate of its first model alone");
    project.add("-x.stl");
    assert!(project.words(Task::Prepare).unwrap().contains(&"./-x.stl".to_owned()));
}

#[test]
fn what_is_missing_is_named() {
    let missing = |project: &Project, task| project.words(task).unwrap_err().to_string();
    assert_eq!(missing(&Project::new(None), Task::Prepare), "add a model first");
    let mut project = project();
    project.machine = None;
    assert_eq!(missing(&project, Task::Prepare), "choose a machine first");
    set(&mut project, "machine", "generic-bc");
    assert!(missing(&project, Task::Print).contains("prepare"));
    prepared(&mut project, json!({"output": "hook.trunnion.gcode"}));
    assert!(missing(&project, Task::Print).contains("port"));
    assert!(project.words(Task::Rehearse).unwrap().contains(&"--dry-run".to_owned()));
    set(&mut project, "port", "/dev/ttyUSB0");
    let wanted = "trunnion send hook.trunnion.gcode --plan hook.trunnion.plan.json --port /dev/ttyUSB0 --resume";
    assert_eq!(line(&project.words(Task::Resume).unwrap()), wanted);
}

#[test]
fn every_change_makes_what_depends_on_it_out_of_date() {
    let ways = json!([{"way": "turned"}, {"way": "supports"}]);
    let stale = |project: &Project| {
        let document = project.document();
        (document["ways"]["stale"].as_bool().unwrap(), document["prepared"]["stale"].as_bool().unwrap())
    };
    let fresh = || {
        let mut project = project();
        prepared(&mut project, json!({"output": "x", "ways": ways}));
        project
    };
    assert_eq!(stale(&fresh()), (false, false));
    let mut way = fresh();
    set(&mut way, "way", "supports");
    assert_eq!((stale(&way), way.is_prepared()), ((false, true), false));
    set(&mut way, "way", "auto");
    assert_eq!((stale(&way), way.is_prepared()), ((false, false), true));
    for (name, value) in [
        ("machine", "generic-bc"),
        ("unit", "cm"),
        ("plate", "2"),
        ("slicer", "builtin"),
        ("finish", "fine"),
        ("up", "0,1,0"),
    ] {
        let mut project = fresh();
        set(&mut project, name, value);
        assert_eq!(stale(&project), (true, true), "{name}");
    }
    let mut saved_again = fresh();
    saved_again.models[0].stamp = Some((100, 2));
    assert_eq!(stale(&saved_again), (true, true));
    let mut port = fresh();
    set(&mut port, "port", "tcp:host:1");
    assert_eq!(stale(&port), (false, false));
}

#[test]
fn prices_of_all_ways_outlive_a_run_of_one() {
    let mut project = project();
    prepared(&mut project, json!({"output": "x", "ways": [{"way": "turned"}, {"way": "supports"}]}));
    set(&mut project, "way", "supports");
    prepared(&mut project, json!({"output": "x", "ways": [{"way": "supports"}]}));
    assert_eq!(project.document()["ways"]["ways"].as_array().unwrap().len(), 2);
    // Of another machine they are gone.
    set(&mut project, "machine", "generic-bc");
    prepared(&mut project, json!({"output": "x", "ways": [{"way": "supports"}]}));
    assert_eq!(project.document()["ways"]["ways"].as_array().unwrap().len(), 1);
    // A failure has none, and does not hide those that there are.
    prepared(&mut project, json!({"error": "no", "code": "slice/failed"}));
    assert_eq!(project.document()["ways"]["ways"].as_array().unwrap().len(), 1);
    assert!(!project.is_prepared());
}

#[test]
fn a_choice_that_is_none_changes_nothing() {
    let mut project = project();
    let before = project.clone();
    for (name, value) in [
        ("machine", "/etc/passwd"),
        ("way", "-x"),
        ("port", "-x"),
        ("port", "a\nb"),
        ("unit", "parsec"),
        ("plate", "0"),
        ("plate", "-1"),
        ("plate", "all"),
        ("up", "0,0,0"),
        ("up", "0,0"),
        ("up", "a,b,c"),
        ("up", "1,2,inf"),
        ("x", "y"),
    ] {
        let change = ProjectChange::Set(name.to_owned(), value.to_owned());
        assert_eq!(project.change(&change, &[]).unwrap_err().code(), "workbench/bad-choice", "{name}");
    }
    for change in
        [ProjectChange::Remove(1), ProjectChange::Copies(1, "2".to_owned()), ProjectChange::Copies(0, "0".to_owned())]
    {
        assert!(project.change(&change, &[]).is_err());
    }
    assert_eq!(project, before);
}
