//! The project by hand.

use super::*;

fn project() -> Project {
    let mut project = Project::new(Some("generic-ac".to_owned()));
    project.add("parts/hook.stl");
    project.restamp(&[Some((100, 1)), None]);
    project
}

fn change(project: &mut Project, change: &ProjectChange) -> Result<(), WorkbenchError> {
    let target = project.target(change, &["generic-ac".to_owned(), "generic-bc".to_owned()])?;
    project.change(change, target, &BTreeMap::new());
    Ok(())
}

fn set(project: &mut Project, name: &str, value: &str) {
    change(project, &ProjectChange::Set(name.to_owned(), value.to_owned())).unwrap();
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
    change(&mut project, &ProjectChange::Copies(1, "3".to_owned())).unwrap();
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
    assert!(prepare(&project).contains(" --plate 2 ") && line(&project.choices.inspect(0)).ends_with("--plate 2"));
    assert!(!line(&project.choices.inspect(1)).contains("plate"), "the command takes a plate of its first model alone");
    project.add("-x.stl");
    assert!(project.words(Task::Prepare).unwrap().contains(&"./-x.stl".to_owned()));
}

#[test]
fn what_is_missing_is_named() {
    let missing = |project: &Project, task| project.words(task).unwrap_err().to_string();
    assert_eq!(missing(&Project::new(None), Task::Prepare), "add a model first");
    let mut project = project();
    project.choices.machine = None;
    assert_eq!(missing(&project, Task::Prepare), "choose a machine first");
    set(&mut project, "machine", "generic-bc");
    assert!(missing(&project, Task::Print).contains("prepare"));
    prepared(&mut project, json!({"output": "hook.trunnion.gcode"}));
    assert!(missing(&project, Task::Print).contains("port"));
    assert!(project.words(Task::Rehearse).unwrap().contains(&"--dry-run".to_owned()));
    set(&mut project, "port", "/dev/ttyUSB0");
    let wanted = "trunnion send hook.trunnion.gcode --plan hook.trunnion.plan.json --port /dev/ttyUSB0 --resume";
    assert_eq!(line(&project.words(Task::Resume).unwrap()), wanted);
    assert!(missing(&project, Task::Publish).contains("print server"));
    set(&mut project, "server", "duet:http://duet.local");
    let upload = "trunnion publish hook.trunnion.gcode --plan hook.trunnion.plan.json --to duet:http://duet.local";
    assert_eq!(line(&project.words(Task::Publish).unwrap()), upload);
    set(&mut project, "key_file", "keys/duet.key");
    let wanted = format!("{upload} --key-file keys/duet.key --start");
    assert_eq!(line(&project.words(Task::PublishAndStart).unwrap()), wanted);
    // As `openssl` prints it; nothing else is taken.
    let bytes = ["0A"; 32].join(":");
    set(&mut project, "fingerprint", &format!("sha256 Fingerprint={bytes}"));
    let wanted = format!("{upload} --key-file keys/duet.key --fingerprint {bytes}");
    assert_eq!(line(&project.words(Task::Publish).unwrap()), wanted);
    assert!(project.choices.set("fingerprint", "0A:0B", &[]).is_err());
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
    saved_again.restamp(&[Some((100, 2)), None]);
    assert_eq!(stale(&saved_again), (true, true));
    let mut port = fresh();
    set(&mut port, "port", "tcp:host:1");
    assert_eq!(stale(&port), (false, false));
    // Prices of the other ways stay what they are.
    let mut cut = fresh();
    set(&mut cut, "cuts", "0,0,1,10;1,0,0,5@6,0,2");
    assert_eq!(stale(&cut), (false, true));
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
    project.history = History::default();
    let before = project.clone();
    for (name, value) in [
        ("machine", "/etc/passwd"),
        ("way", "-x"),
        ("port", "-x"),
        ("order", "1,1"),
        ("order", "a"),
        ("order", ""),
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
        let bad = ProjectChange::Set(name.to_owned(), value.to_owned());
        assert_eq!(change(&mut project, &bad).unwrap_err().code(), "workbench/bad-choice", "{name}");
    }
    for bad in
        [ProjectChange::Remove(1), ProjectChange::Copies(1, "2".to_owned()), ProjectChange::Copies(0, "0".to_owned())]
    {
        assert!(change(&mut project, &bad).is_err());
    }
    for bad in [ProjectChange::Undo, ProjectChange::Redo] {
        assert_eq!(change(&mut project, &bad).unwrap_err().code(), "workbench/no-step");
    }
    assert_eq!(project, before);
}

#[test]
fn every_change_is_taken_back_and_made_again() {
    let mut project = project();
    project.history = History::default();
    prepared(&mut project, json!({"output": "x"}));
    let mut states = vec![project.choices.clone()];
    let of = |name: &str, value: &str| ProjectChange::Set(name.to_owned(), value.to_owned());
    for one in [
        of("machine", "generic-bc"),
        of("way", "supports"),
        of("unit", "cm"),
        of("plate", "2"),
        of("up", "0,1,0"),
        of("finish", "fine"),
        of("slicer", "builtin"),
        ProjectChange::Order("1,0".to_owned(), "cut".to_owned()),
        of("port", "tcp:host:1"),
        ProjectChange::Copies(0, "3".to_owned()),
        ProjectChange::Remove(0),
    ] {
        change(&mut project, &one).unwrap();
        assert_ne!(Some(&project.choices), states.last(), "{one:?}");
        states.push(project.choices.clone());
    }
    project.add("b.stl");
    states.push(project.choices.clone());
    let revision = project.revision;
    assert_eq!(project.history.last().unwrap().document(), json!({"what": "add", "name": "b.stl"}));
    for state in states.iter().rev().skip(1) {
        change(&mut project, &ProjectChange::Undo).unwrap();
        assert_eq!(project.choices, *state);
    }
    // What was made of it is current again, as soon as its file is seen to be the same.
    assert!(!project.is_prepared());
    project.restamp(&[Some((100, 1)), None]);
    assert!(project.is_prepared() && project.revision == revision + 12 && project.history.last().is_none());
    for state in states.iter().skip(1) {
        change(&mut project, &ProjectChange::Redo).unwrap();
        assert_eq!(project.choices, *state);
    }
    // A new change ends what could be made again; a choice that is the choice already is none.
    change(&mut project, &ProjectChange::Undo).unwrap();
    set(&mut project, "port", "tcp:host:1");
    assert!(project.history.next().is_some());
    set(&mut project, "port", "");
    assert!(project.history.next().is_none());
    assert_eq!(change(&mut project, &ProjectChange::Redo).unwrap_err().code(), "workbench/no-step");
}

#[test]
fn a_model_that_came_back_under_another_name_has_it_in_every_step() {
    let mut project = project();
    set(&mut project, "way", "supports");
    change(&mut project, &ProjectChange::Remove(0)).unwrap();
    let target = project.target(&ProjectChange::Undo, &[]).unwrap();
    let moved = [(target.models[0].id, "parts/hook-2.stl".to_owned())].into();
    project.change(&ProjectChange::Undo, target, &moved);
    change(&mut project, &ProjectChange::Undo).unwrap();
    assert_eq!((project.choices.models[0].path.as_str(), project.choices.way.as_str()), ("parts/hook-2.stl", "auto"));
}

#[test]
fn an_answer_about_another_reading_of_the_file_is_not_taken() {
    let mut project = project();
    let (id, words) = project.next_to_inspect().unwrap();
    assert!(project.next_to_inspect().is_none());
    set(&mut project, "unit", "cm");
    let (_, again) = project.next_to_inspect().unwrap();
    let read = |project: &Project| project.document()["models"][0]["inspected"].clone();
    project.take_inspected(id, &again, json!("cm"), Vec::new());
    project.take_inspected(id, &words, json!("mm"), Vec::new());
    assert_eq!(read(&project), "cm");
    change(&mut project, &ProjectChange::Undo).unwrap();
    assert_eq!(read(&project), Value::Null);
    // The plate is the first model's: whoever becomes the first is read again.
    project.add("b.stl");
    set(&mut project, "plate", "2");
    let asked: Vec<_> = std::iter::from_fn(|| project.next_to_inspect()).map(|(id, _)| id).collect();
    assert_eq!(asked.len(), 2);
    change(&mut project, &ProjectChange::Remove(0)).unwrap();
    assert_eq!(project.next_to_inspect().map(|(id, _)| id), Some(asked[1]));
}

#[test]
fn an_order_is_of_the_parts_that_there_are() {
    let mut project = project();
    let plan = json!({"model": {"file": "hook.trunnion.parts.3mf"}, "parts": [], "slots": []});
    prepared(&mut project, json!({"output": "x", "plan": plan, "ways": [{"way": "cut", "chosen": true}]}));
    assert_eq!(project.timeline().unwrap().way, "cut");
    change(&mut project, &ProjectChange::Order("1,0+2".to_owned(), "cut".to_owned())).unwrap();
    assert_eq!(project.timeline().unwrap_err().code(), "workbench/not-yet");
    project.take_order("cut", &plan);
    assert!(project.timeline().is_ok() && !project.is_prepared());
    let words = line(&project.words(Task::Prepare).unwrap());
    assert!(words.contains(" --way cut --order 1,0+2 "), "{words}");
    // What may have other parts leaves the order to the plan; what has the same keeps it.
    set(&mut project, "slicer", "builtin");
    assert_eq!(project.choices.order, "1,0+2");
    for (name, value) in
        [("way", "auto"), ("machine", "generic-bc"), ("unit", "cm"), ("up", "0,1,0"), ("finish", "fine")]
    {
        let mut other = project.clone();
        set(&mut other, name, value);
        assert_eq!(other.choices.order, "auto", "{name}");
    }
    let mut more = project.clone();
    more.add("b.stl");
    assert_eq!(more.choices.order, "auto");
    change(&mut project, &ProjectChange::Undo).unwrap();
    change(&mut project, &ProjectChange::Undo).unwrap();
    assert_eq!((project.choices.order.as_str(), project.choices.way.as_str()), ("auto", "auto"));
    assert!(project.timeline().is_ok());
}
