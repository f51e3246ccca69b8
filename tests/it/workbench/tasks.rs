//! What somebody does on the page from an empty folder to a print, once with the pointer and once with keys alone.

use serde_json::{Value, json};

use super::browser::{STATE, click, eval, key, quiet, shot, typed, until};
use super::{Workbench, open_in};
use crate::link::{profile, simulate};
use crate::preview::browser::browse_any;
use crate::support::{folder, said, trunnion};

/// How the page is used.
#[derive(Clone, Copy, PartialEq)]
enum Hand {
    Pointer,
    Keys,
}

impl Hand {
    /// Presses a button, or chooses a card.
    fn press(self, id: &str) -> Vec<Value> {
        match self {
            Self::Pointer => vec![until(&usable(id)), click(&format!("#{id}"))],
            Self::Keys => {
                vec![until(&usable(id)), eval(&format!("document.getElementById('{id}').focus()")), key("Enter")]
            }
        }
    }

    /// Goes to a room, by its number.
    fn go(self, room: usize) -> Vec<Value> {
        const ROOMS: [&str; 4] = ["model", "how", "see", "print"];
        match self {
            Self::Pointer => self.press(&format!("room-{}", ROOMS[room - 1])),
            // Not into a field.
            Self::Keys => vec![eval("document.activeElement.blur()"), key(&room.to_string())],
        }
    }
}

fn usable(id: &str) -> String {
    format!("document.getElementById('{id}') && !document.getElementById('{id}').disabled")
}

/// A field or a list has this value, as soon as it can be used.
fn chosen(id: &str, value: &str) -> Vec<Value> {
    vec![until(&usable(id)), typed(id, value)]
}

/// The model comes onto the page: dropped, or chosen as a file.
fn added(hand: Hand, model: &std::path::Path) -> Vec<Value> {
    if hand == Hand::Keys {
        return vec![json!({"files": [model]})];
    }
    let bytes = std::fs::read(model).unwrap();
    vec![eval(&format!(
        "(() => {{ const all = new DataTransfer(); all.items.add(new File([new Uint8Array({bytes:?})], 'bracket.stl')); \
         document.dispatchEvent(new DragEvent('drop', {{ bubbles: true, cancelable: true, dataTransfer: all }})); }})()"
    ))]
}

/// Looks at a face of the model in the middle of the picture; `from` says from where.
fn looks_at(normal: &str, pitch: f64) -> Value {
    eval(&format!(
        "(() => {{ const s = workbench.scene, {{ clientWidth: w, clientHeight: h }} = s.canvas; \
         for (let k = 0; k < 64; k++) {{ Object.assign(s.camera, {{ yaw: k * Math.PI / 32, pitch: {pitch} }}); \
         const face = s.faceAt(w / 2, h / 2); if (face && face.normal.join() === '{normal}') {{ s.invalidate(); return face.offset; }} }} return null; }})()"
    ))
}

fn tasks(hand: Hand, workbench: &Workbench, model: &std::path::Path) -> Vec<Value> {
    let asked = |code: &str| {
        until(&format!("({code}) && document.getElementById('cuts')?.getAttribute('aria-busy') === 'false'"))
    };
    let pointed =
        |by_pointer: Vec<Value>, by_keys: Vec<Value>| if hand == Hand::Pointer { by_pointer } else { by_keys };
    let port = workbench.folder.path().join("tty").display().to_string();
    let mut steps = vec![until(&format!("{STATE} && workbench.page.machines.machines")), json!({"size": [1200, 900]})];
    // 1. A bracket, on the table of a machine, and on another side.
    steps.extend(added(hand, model));
    // Each change is of the project as it is: the one before has to be there.
    steps.push(until(&format!("{STATE}.models.length === 1 && {STATE}.models[0].inspected")));
    for machine in ["generic-bc", "machine.toml"] {
        steps.extend(chosen("machine", machine));
        steps.push(until(&format!("{STATE}.machine === '{machine}'")));
    }
    steps.push(until("workbench.scene.order.length === 1 && workbench.scene.machine && !workbench.scene.waiting"));
    steps.extend(pointed(
        [hand.press("pick"), vec![looks_at("1,0,0", 0.02), click("#canvas")]].concat(),
        chosen("up", "recommended"),
    ));
    steps.push(until(&format!("{STATE}.up !== 'auto'")));
    steps.extend(pointed(hand.press("undo"), vec![eval("document.activeElement.blur()"), key("Control+z")]));
    steps.push(until(&format!("{STATE}.up === 'auto'")));
    // 2. and 7. Why it cannot be printed as drawn, and what the other ways cost.
    steps.extend(hand.go(2));
    steps.extend(chosen("slicer", "builtin"));
    steps.push(until(&format!("{STATE}.slicer === 'builtin'")));
    steps.extend(hand.press("find"));
    steps.push(until(&format!("{STATE}.prepared && !{STATE}.busy && document.querySelector('#way-as-drawn .why')")));
    steps.push(eval("['why', document.querySelector('#way-as-drawn .why').textContent, document.querySelectorAll('.way .price').length]"));
    // 3. On supports instead.
    steps.extend(hand.press("way-supports"));
    steps.push(until(&format!("{STATE}.way === 'supports'")));
    steps.extend(hand.press("find"));
    steps.push(until(&format!("{STATE}.prepared && !{STATE}.prepared.stale && !{STATE}.busy")));
    steps.push(eval(&format!("['supports', {STATE}.prepared.document.verify.findings.length, {STATE}.prepared.document.ways.find((way) => way.chosen).way]")));
    // 4. A cut along a face of the post; one that the head cannot reach is red.
    steps.extend(hand.press("way-auto"));
    steps.push(until(&format!("{STATE}.way === 'auto'")));
    steps.extend(pointed(
        [hand.press("pick-cut"), vec![looks_at("1,0,0", 0.02), click("#canvas")]].concat(),
        [
            chosen("add-cut", "1,0,0"),
            vec![
                asked(&format!("{STATE}.cuts.length === 1")),
                eval("document.getElementById('slide-0').focus()"),
                key("PageDown"),
            ],
        ]
        .concat(),
    ));
    steps.push(asked(&format!("{STATE}.cuts.join() === '1,0,0,8'")));
    steps.extend(pointed(
        [hand.press("pick-cut"), vec![looks_at("0,0,-1", -0.9), click("#canvas")]].concat(),
        [chosen("add-cut", "0,0,1"), vec![asked("document.getElementById('lean-1')")], chosen("lean-1", "180")]
            .concat(),
    ));
    steps.push(asked("document.querySelector('.cut.bad')"));
    steps.push(eval("['refused', document.getElementById('cut-why').textContent]"));
    steps.push(shot("tasks-refused"));
    steps.extend(hand.press("drop-cut"));
    // 5. It is moved.
    steps.push(asked(&format!("{STATE}.cuts.length > 0 && !document.querySelector('.cut.bad')")));
    if hand == Hand::Keys {
        steps.extend(hand.press("uncut-1"));
        steps.push(asked(&format!("{STATE}.cuts.length === 1")));
    }
    steps.extend(chosen("offset-0", "20"));
    steps.push(asked(&format!("{STATE}.cuts.join().includes('20')")));
    // 6. The arm cannot come before the post.
    steps.extend(hand.press("find"));
    steps.push(until(&format!(
        "{STATE}.prepared && !{STATE}.prepared.stale && !{STATE}.busy && document.getElementById('print-1')"
    )));
    steps.extend(pointed(vec![json!({"drag": ["#print-1", "#print-0"]})], hand.press("earlier-1")));
    steps.push(until("document.querySelector('#order-why .notice.bad')"));
    steps.push(eval("['order', document.querySelector('#order-why').textContent]"));
    // 8. The file as it will be printed.
    steps.extend(hand.go(3));
    steps.push(until("document.getElementById('preview')"));
    steps.push(json!({"frame": "trunnion.ready.then(() => trunnion.replay.count)"}));
    // 9. Printed on the simulated printer, paused and continued.
    steps.extend(hand.go(4));
    steps.extend(chosen("port", &port));
    steps.push(until(&format!("{STATE}.printers[0].port && {}", usable("print"))));
    steps.extend(hand.press("print"));
    steps.push(until(&format!("{STATE}.runs.print.progress?.line > 0")));
    steps.extend(hand.press("word-pause"));
    steps.push(until(&format!("{STATE}.runs.print.paused")));
    steps.extend(hand.press("word-continue"));
    steps.push(until(&format!("!{STATE}.runs.print.paused")));
    // And ended, for it would take its time.
    steps.extend(hand.press("word-pause"));
    steps.push(until(&format!("{STATE}.runs.print.paused")));
    steps.extend(hand.press("word-cancel"));
    steps.push(until(&format!("!{STATE}.runs.print.running")));
    steps.push(eval(&format!("['print', {STATE}.runs.print.event.event]")));
    // 10. Saved.
    steps.extend(pointed(hand.press("save"), vec![eval("document.activeElement.blur()"), key("Control+s")]));
    steps.push(until(&format!("{STATE}.file.name && {STATE}.file.saved")));
    steps.push(eval(&format!("['saved', {STATE}.file.name, {STATE}.commands.prepare.line]")));
    steps
}

#[track_caller]
fn done_by(hand: Hand) {
    let place = folder();
    profile(place.path());
    let workbench = open_in(place, &["-m", "machine.toml"]);
    let log = workbench.folder.path().join("sim.log");
    let machine = workbench.folder.path().join("machine.toml");
    let _printer =
        simulate(&workbench.folder.path().join("tty"), &machine, &["--speed", "40", "--log", log.to_str().unwrap()]);
    let model = crate::pipeline::fixture("bracket");
    let steps = tasks(hand, &workbench, model.as_ref());
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let told = |name: &str| answers.results.iter().find(|result| result[0] == name).unwrap_or_else(|| panic!("{name}"));
    assert!(told("why")[1].as_str().unwrap().contains("mm2") && told("why")[2].as_u64() > Some(1), "{}", told("why"));
    assert_eq!(told("supports"), &json!(["supports", 0, "supports"]));
    assert!(told("refused")[1].as_str().unwrap().contains("split/refused-cut"), "{}", told("refused"));
    assert!(told("order")[1].as_str().unwrap().contains("plan/no-plan"), "{}", told("order"));
    assert_eq!(told("print"), &json!(["print", "stopped"]));
    // The file and the command are one project.
    let (name, line) = (told("saved")[1].as_str().unwrap(), told("saved")[2].as_str().unwrap());
    let made = workbench.file("bracket.trunnion.gcode");
    let again = folder();
    std::fs::write(again.path().join(name), workbench.file(name)).unwrap();
    let run = trunnion().args(["prepare", name]).current_dir(again.path()).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    assert!(std::fs::read(again.path().join("bracket.trunnion.gcode")).unwrap() == made, "{line}");
}

#[test]
fn ten_tasks_are_done_with_the_pointer() {
    done_by(Hand::Pointer);
}

#[test]
fn ten_tasks_are_done_with_keys_alone() {
    done_by(Hand::Keys);
}

#[test]
fn a_finding_is_jumped_to() {
    let folder = folder();
    std::fs::copy(crate::pipeline::fixture("cube"), folder.path().join("cube.stl")).unwrap();
    // Its roof has nothing to lie on.
    std::fs::write(folder.path().join("hollow.toml"), "extends = \"generic-ac\"\n[process]\ninfill = 0.0\n").unwrap();
    let workbench = open_in(folder, &["cube.stl", "-m", "hollow.toml"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    let elsewhere = [
        eval("workbench.showLine(30)"),
        json!({"frame": "new Promise((done) => { const look = () => (trunnion.frame().line === 30 ? done(30) : setTimeout(look, 20)); look(); })"}),
    ];
    let jumped = json!({"frame": "new Promise((done) => { const look = () => (trunnion.frame().line !== 30 ? done(trunnion.frame().line) : setTimeout(look, 20)); look(); })"});
    let mut steps = vec![until(&format!("{STATE} && workbench.page.machines.machines")), key("3")];
    steps.extend(Hand::Pointer.press("prepare"));
    steps.push(until(&format!("{STATE}.prepared && !{STATE}.busy && document.getElementById('preview')")));
    steps.push(json!({"frame": "trunnion.ready.then(() => trunnion.replay.count)"}));
    steps.push(eval("['line', Number(document.querySelector('#findings button').dataset.line)]"));
    steps.extend(elsewhere.clone());
    steps.extend([click("#findings button"), jumped.clone()]);
    steps.extend(elsewhere);
    steps.extend([eval("document.querySelector('#findings button').focus()"), key("Enter"), jumped]);
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let line = answers.results.iter().find(|result| result[0] == "line").unwrap()[1].clone();
    let count = answers.results.len();
    assert!(line.as_u64() > Some(30), "{line}");
    assert_eq!((&answers.results[count - 6], &answers.results[count - 1]), (&line, &line));
}
