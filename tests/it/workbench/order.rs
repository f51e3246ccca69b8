//! The order of the prints: cards that are dragged or moved by keys, and spring back with the reason where the command has no plan.

use serde_json::{Value, json};

use super::browser::{SHOWN, STATE, click, eval, key, quiet, shot, until};
use super::looks::Looks;
use super::{by_hand, open};
use crate::preview::browser::browse_any;

/// The parts of the cards.
fn cards(state: &Value) -> Value {
    state["timeline"]["prints"].as_array().unwrap().iter().map(|card| card["parts"].clone()).collect()
}

#[test]
fn another_order_is_planned_or_refused_with_the_words_of_the_command() {
    let workbench = open(&["y-tree"], &["y-tree.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    let early = workbench.posted("/api/order?value=0,2,1");
    assert_eq!((early.status, early.json()["code"].as_str()), (409, Some("workbench/not-yet")));
    let before = workbench.run("prepare");
    assert_eq!(cards(&before), json!([[0], [1], [2]]));
    // What stands on nothing cannot come first: the project is as it was, and what was prepared is current.
    let why = workbench.post("/api/order?value=1,0,2")["refused"].clone();
    assert_eq!(why["code"], "plan/no-plan", "{why}");
    assert!(!why["reasons"].as_array().unwrap().is_empty() && why["error"].is_string(), "{why}");
    let state = workbench.state();
    assert_eq!(
        (&state["revision"], &state["order"], &state["prepared"]["stale"]),
        (&before["revision"], &"auto".into(), &false.into())
    );
    for bad in ["1,1", "x", "0,", ""] {
        let answer = workbench.posted(&format!("/api/order?value={bad}"));
        assert_eq!((answer.status, answer.json()["code"].as_str()), (400, Some("workbench/bad-choice")), "{bad}");
    }
    assert_eq!(workbench.post("/api/order?value=0,7")["refused"]["code"], "setting/no-such-part");
    let state = workbench.post("/api/order?value=0,2,1");
    assert_eq!(
        (&state["order"], &state["way"], cards(&state)),
        (&"0,2,1".into(), &"as-drawn".into(), json!([[0], [2], [1]]))
    );
    assert_eq!(state["prepared"]["stale"], true);
    let state = workbench.run("prepare");
    assert_eq!((&state["prepared"]["stale"], cards(&state)), (&false.into(), json!([[0], [2], [1]])));
    let line = state["commands"]["prepare"]["line"].as_str().unwrap();
    assert!(line.contains(" --order 0,2,1 "), "{line}");
    let elsewhere = by_hand(line, workbench.folder.path());
    for name in ["y-tree.trunnion.gcode", "y-tree.trunnion.plan.json"] {
        assert!(workbench.file(name) == std::fs::read(elsewhere.path().join(name)).unwrap(), "{name}");
    }
    // Undo and redo, and a way that has other parts.
    let state = workbench.post("/api/undo");
    assert_eq!((&state["order"], &state["way"]), (&"auto".into(), &"auto".into()));
    let state = workbench.post("/api/redo");
    assert_eq!((&state["order"], &state["prepared"]["stale"]), (&"0,2,1".into(), &false.into()));
    assert_eq!(workbench.post("/api/set?name=way&value=auto")["order"], "auto");
}

#[test]
fn an_order_of_the_parts_of_a_cut_solid_is_asked_of_its_parts() {
    let workbench = open(&["bracket"], &["bracket.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    workbench.post("/api/set?name=way&value=cut");
    let state = workbench.run("prepare");
    assert_eq!(cards(&state), json!([[0], [1]]));
    // The arm hangs on the post: it cannot come first, of which nothing is left but the reason.
    assert_eq!(workbench.post("/api/order?value=1,0")["refused"]["code"], "plan/no-plan");
    let state = workbench.post("/api/order?value=0,1");
    assert_eq!((&state["refused"], &state["order"], &state["way"]), (&Value::Null, &"0,1".into(), &"cut".into()));
    let state = workbench.run("prepare");
    let document = &state["prepared"]["document"];
    assert_eq!((cards(&state), &document["verify"]["findings"]), (json!([[0], [1]]), &json!([])), "{document}");
}

#[test]
fn cards_are_dragged_and_moved_by_keys_and_spring_back() {
    let workbench = open(&["y-tree"], &["y-tree.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    let mut looks = Looks::new();
    let shown = "[...document.querySelectorAll('.print')].map((card) => card.dataset.card).join()";
    let are = |wanted: &str| {
        until(&format!(
            "{shown} === '{wanted}' && document.getElementById('prints').getAttribute('aria-busy') === 'false'"
        ))
    };
    let steps = [
        // The model is shown as large as the page is then.
        until(SHOWN),
        json!({"size": [1200, 900]}),
        key("2"),
        until("document.getElementById('find')"),
        click("#find"),
        until(&format!("{STATE}.timeline && !{STATE}.busy")),
        are("0,1,2"),
        eval("document.getElementById('print-1').textContent"),
        shot("order"),
        // By pointer: the trunk cannot come last.
        json!({"drag": ["#print-0", "#print-2"]}),
        until("document.querySelector('#order-why .notice.bad') && document.querySelector('.print.sprung')"),
        are("0,1,2"),
        eval("document.querySelector('#order-why').textContent"),
        looks.shot("order-refused"),
        json!({"drag": ["#print-2", "#print-1"]}),
        until(&format!("{STATE}.order === '0,2,1'")),
        are("0,2,1"),
        eval("[document.querySelector('#order-why .notice'), document.getElementById('command').textContent]"),
        // By keys: back again; the focus stays with the card.
        eval("document.getElementById('later-2').focus()"),
        key("Enter"),
        until(&format!("{STATE}.order === '0,1,2'")),
        are("0,1,2"),
        until("document.activeElement.closest('.print')"),
        eval("document.activeElement.closest('.print').dataset.card"),
        key("Control+z"),
        are("0,2,1"),
        key("Control+z"),
        until(&format!("{STATE}.order === 'auto' && {STATE}.way === 'auto'")),
        are("0,1,2"),
        json!({"size": [900, 700]}),
        json!({"scheme": "dark"}),
        eval("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"),
        shot("order-dark-900"),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let results = &answers.results;
    looks.are_kept();
    assert!(results[7].as_str().unwrap().contains("45°"), "{}", results[7]);
    assert!(results[12].as_str().unwrap().contains("plan/no-plan"), "{}", results[12]);
    assert_eq!(results[17][0], Value::Null);
    assert!(results[17][1].as_str().unwrap().contains(" --way as-drawn --order 0,2,1 "), "{}", results[17]);
    assert_eq!(results[23], "2");
    assert_eq!(results[31], json!([900, 700]));
}
