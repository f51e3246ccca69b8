//! Cuts that somebody decides: along a face that was clicked, moved by their figures, red with the reason where they cannot be made.

use serde_json::{Value, json};

use super::browser::{STATE, click, eval, key, quiet, shot, until};
use super::{by_hand, open, open_in};
use crate::preview::browser::browse_any;
use crate::support::folder;

#[test]
fn cuts_are_the_command_s_and_come_back_with_the_project() {
    let workbench = open(&["bracket"], &["bracket.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    let before = workbench.state();
    // Nothing is taken that the machine cannot make.
    for (cuts, code, place) in [
        ("1,0,0,60", "split/refused-cut", 0),
        ("1,0,0,20;0,0,-1,-20", "split/refused-cut", 1),
        ("1,0,0,20;-1,0,0,9", "split/refused-cut", 1),
    ] {
        let why = workbench.post(&format!("/api/cuts?value={cuts}"))["refused"].clone();
        assert_eq!((&why["code"], &why["cut"]), (&code.into(), &place.into()), "{cuts}: {why}");
        assert!(why["error"].as_str().unwrap().contains(&format!("cut {}", place + 1)), "{why}");
    }
    assert_eq!(workbench.state()["revision"], before["revision"]);
    for bad in ["", "1,0,0", "1,0,0,8;", "x,0,0,8", "0,0,0,8"] {
        let answer = workbench.posted(&format!("/api/cuts?value={bad}"));
        assert_eq!((answer.status, answer.json()["code"].as_str()), (400, Some("workbench/bad-choice")), "{bad}");
    }
    // The first is nobody's but its maker's, and the way follows.
    let state = workbench.post("/api/cuts?value=1,0,0,30;1,0,0,8");
    assert_eq!(
        (&state["refused"], &state["cuts"], &state["way"]),
        (&Value::Null, &json!(["1,0,0,30", "1,0,0,8"]), &"cut".into())
    );
    let seams: Vec<f64> =
        state["cut"]["planes"].as_array().unwrap().iter().map(|plane| plane["seam_mm2"].as_f64().unwrap()).collect();
    // The arm is 16 mm wide and 8 mm thick.
    assert!(seams.len() == 2 && seams.iter().all(|mm2| (mm2 - 128.0).abs() < 1e-6), "{seams:?}");
    // The post, two of the arm, and the pedestal that the head needs.
    assert_eq!(state["cut"]["parts"], 4);
    let state = workbench.run("prepare");
    let document = &state["prepared"]["document"];
    assert_eq!(
        (&document["verify"]["findings"], &state["prepared"]["stale"]),
        (&json!([]), &false.into()),
        "{document}"
    );
    let line = state["commands"]["prepare"]["line"].as_str().unwrap();
    let cuts: Vec<&str> = line.split(" --cut ").skip(1).filter_map(|rest| rest.split(' ').next()).collect();
    assert_eq!(cuts, ["1,0,0,30", "1,0,0,8"], "{line}");
    let elsewhere = by_hand(line, workbench.folder.path());
    for name in ["bracket.trunnion.gcode", "bracket.trunnion.plan.json"] {
        assert!(workbench.file(name) == std::fs::read(elsewhere.path().join(name)).unwrap(), "{name}");
    }
    // They wait where another way is chosen, and are there again behind it, and in the project's file.
    let state = workbench.post("/api/set?name=way&value=supports");
    assert!(!state["commands"]["prepare"]["line"].as_str().unwrap().contains("--cut"), "{state}");
    assert_eq!(workbench.post("/api/undo")["prepared"]["stale"], false);
    let name = workbench.post("/api/save")["file"]["name"].as_str().unwrap().to_owned();
    let copy = folder();
    std::fs::write(copy.path().join(&name), workbench.file(&name)).unwrap();
    let again = open_in(copy, &[&name]);
    assert_eq!(again.state()["cuts"], json!(["1,0,0,30", "1,0,0,8"]));
    // Of another model they are none, nor of the same in another unit.
    assert_eq!(workbench.post("/api/set?name=unit&value=cm")["cuts"], json!([]));
    let state = workbench.post("/api/undo");
    assert_eq!((state["cuts"].as_array().unwrap().len(), &state["undo"]["what"]), (2, &"cuts".into()));
    let state = workbench.post("/api/cuts?value=auto");
    assert_eq!((&state["cuts"], &state["way"]), (&json!([]), &"auto".into()));
}

#[test]
fn cuts_are_of_one_model_alone() {
    let workbench = open(&["bracket", "cube"], &["bracket.stl", "cube.stl", "-m", "generic-ac"]);
    let answer = workbench.posted("/api/cuts?value=1,0,0,8");
    assert_eq!((answer.status, answer.json()["code"].as_str()), (409, Some("workbench/not-yet")));
}

#[test]
fn a_face_is_cut_along_and_a_plane_that_cannot_be_turns_red_until_it_is_moved() {
    let workbench = open(&["bracket"], &["bracket.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    // Looks at the side of the post below the arm, in the middle of the picture.
    let look = "(() => { const s = workbench.scene, { clientWidth: w, clientHeight: h } = s.canvas; \
        for (let k = 0; k < 16; k++) { Object.assign(s.camera, { yaw: k * Math.PI / 8, pitch: 0.02 }); \
        const face = s.faceAt(w / 2, h / 2); if (face && face.normal.join() === '1,0,0') { s.invalidate(); return face.offset; } } return null; })()";
    let typed = |value: &str| {
        eval(&format!(
            "(() => {{ const it = document.getElementById('offset-0'); it.focus(); it.value = '{value}'; it.dispatchEvent(new Event('input', {{ bubbles: true }})); it.dispatchEvent(new Event('change', {{ bubbles: true }})); }})()"
        ))
    };
    // What is asked is answered: until then nothing can be typed.
    let settled = |code: &str| {
        until(&format!("({code}) && document.getElementById('cuts').getAttribute('aria-busy') === 'false'"))
    };
    let kinds = "JSON.parse(workbench.scene.planes).map((plane) => `${plane.kind} ${plane.offset}`).join()";
    let steps = [
        until("workbench.scene.order.length === 1 && !workbench.scene.waiting && workbench.page.machines.machines"),
        json!({"size": [1200, 900]}),
        key("2"),
        until("document.getElementById('pick-cut')"),
        eval(look),
        click("#pick-cut"),
        eval("document.getElementById('pick-cut').getAttribute('aria-pressed')"),
        click("#canvas"),
        settled(&format!("{STATE}.cuts.length === 1 && workbench.scene.picking === null")),
        eval(&format!(
            "[{STATE}.cuts.join(), {STATE}.cut.planes[0].seam_mm2, {kinds}, document.getElementById('command').textContent]"
        )),
        shot("cut"),
        // Beyond the arm there is nothing: red, and the project is as it was.
        typed("51.9"),
        settled("document.querySelector('#cut-0.bad') && document.querySelector('#cut-why .notice.bad')"),
        eval(&format!("[{STATE}.cuts.join(), {kinds}, document.getElementById('cut-why').textContent]")),
        shot("cut-refused"),
        typed("20.5"),
        settled(&format!("{STATE}.cuts.join() === '1,0,0,20.5' && !document.querySelector('.cut.bad')")),
        eval(kinds),
        // A slider is held: the plane goes with it before anybody is asked.
        eval(
            "(() => { const it = document.getElementById('slide-0'); it.value = '30'; it.dispatchEvent(new Event('input', { bubbles: true })); })()",
        ),
        eval(&format!("[{kinds}, {STATE}.cuts.join()]")),
        eval("document.getElementById('slide-0').focus()"),
        key("Control+z"),
        settled(&format!("{STATE}.cuts.join() === '1,0,0,8'")),
        // By the keyboard: a plane across the middle, and away with it.
        eval(
            "(() => { const it = document.getElementById('add-cut'); it.focus(); it.value = '1,0,0'; it.dispatchEvent(new Event('change', { bubbles: true })); })()",
        ),
        // What is cut off is not cut again: the outer one comes first.
        settled(&format!("{STATE}.cuts.join(' ') === '1,0,0,22 1,0,0,8'")),
        eval("document.getElementById('uncut-1').focus()"),
        key("Enter"),
        settled(&format!("{STATE}.cuts.join() === '1,0,0,22'")),
        eval("document.getElementById('free-cuts').focus()"),
        key("Enter"),
        settled(&format!("{STATE}.cuts.length === 0 && {STATE}.way === 'auto'")),
        // What the plan finds can be kept.
        eval("document.getElementById('find').focus()"),
        key("Enter"),
        until(&format!("{STATE}.prepared && !{STATE}.busy")),
        click("#way-cut"),
        until(&format!("{STATE}.way === 'cut' && document.getElementById('find')")),
        click("#find"),
        until("document.querySelector('#found-0')"),
        eval(kinds),
        click("#pin-0"),
        settled(&format!("{STATE}.cuts.length === 1 && document.querySelector('#cut-0.chosen')")),
        eval(&format!("{STATE}.cuts[0] === {STATE}.cut.planes[0].pin")),
        json!({"size": [900, 700]}),
        json!({"scheme": "dark"}),
        eval("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"),
        shot("cut-dark-900"),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let results = &answers.results;
    assert_eq!((&results[4], &results[6]), (&json!(8), &"true".into()));
    assert_eq!((&results[9][0], &results[9][2]), (&"1,0,0,8".into(), &"chosen 8".into()));
    assert!((results[9][1].as_f64().unwrap() - 128.0).abs() < 1e-6, "{}", results[9]);
    assert!(results[9][3].as_str().unwrap().contains(" --way cut --cut 1,0,0,8 "), "{}", results[9]);
    assert_eq!((&results[13][0], &results[13][1]), (&"1,0,0,8".into(), &"bad 51.9".into()));
    assert!(results[13][2].as_str().unwrap().contains("split/refused-cut"), "{}", results[13]);
    assert_eq!((&results[17], &results[19]), (&"chosen 20.5".into(), &json!(["chosen 30", "1,0,0,20.5"])));
    assert!(results[38].as_str().unwrap().starts_with("found "), "{}", results[38]);
    assert_eq!((&results[41], &results[44]), (&json!(true), &json!([900, 700])));
}
