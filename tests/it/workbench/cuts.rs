//! Cuts that somebody decides: along a face that was clicked, moved by their figures, red with the reason where they cannot be made.

use serde_json::{Value, json};
use trunnion::mesh::stl_binary;

use super::browser::{SHOWN, STATE, click, eval, key, quiet, shot, typed, until};
use super::looks::Looks;
use super::{Workbench, by_hand, open, open_in};
use crate::preview::browser::browse_any;
use crate::split::solids;
use crate::support::folder;

/// These cuts are refused for the one at `place`, whichever part that is of.
#[track_caller]
fn is_refused(workbench: &Workbench, cuts: &str, place: usize) {
    let why = workbench.post(&format!("/api/cuts?value={cuts}"))["refused"].clone();
    assert_eq!((&why["code"], &why["cut"]), (&"split/refused-cut".into(), &place.into()), "{cuts}: {why}");
    assert!(why["error"].as_str().unwrap().contains(&format!("cut {}", place + 1)), "{why}");
}

#[test]
fn cuts_are_the_command_s_and_come_back_with_the_project() {
    let workbench = open(&["bracket"], &["bracket.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    let before = workbench.state();
    // Nothing is taken that the machine cannot make.
    for (cuts, place) in [("1,0,0,60", 0), ("1,0,0,20;0,0,-1,-20", 1), ("1,0,0,20;-1,0,0,9", 1)] {
        is_refused(&workbench, cuts, place);
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
        state["cut"][0]["planes"].as_array().unwrap().iter().map(|plane| plane["seam_mm2"].as_f64().unwrap()).collect();
    // The arm is 16 mm wide and 8 mm thick.
    assert!(seams.len() == 2 && seams.iter().all(|mm2| (mm2 - 128.0).abs() < 1e-6), "{seams:?}");
    // The post, two of the arm, and the pedestal that the head needs.
    assert_eq!(state["cut"][0]["parts"], 4);
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
fn cuts_are_of_a_part_and_stay_with_it() {
    let workbench = open(&["bracket", "cube"], &["bracket.stl", "cube.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    // Nobody knows the numbers of the second model's parts before the first one is read.
    let read = || workbench.until("both", |state| (0..2).all(|i| state["models"][i]["inspected"].is_object()));
    read();
    for (cuts, place) in [("0:1,0,0,60", 0), ("0:1,0,0,8;1:0,0,1,60", 1), ("1:0,0,1,10;0:1,0,0,8;0:1,0,0,60", 2)] {
        is_refused(&workbench, cuts, place);
    }
    for bad in ["1,0,0,8", "2:1,0,0,8", "x:1,0,0,8"] {
        let answer = workbench.posted(&format!("/api/cuts?value={bad}"));
        assert_eq!((answer.status, answer.json()["code"].as_str()), (400, Some("workbench/bad-choice")), "{bad}");
    }
    let state = workbench.post("/api/cuts?value=0:1,0,0,8;1:0,0,1,10");
    assert_eq!((&state["refused"], &state["way"]), (&Value::Null, &"cut".into()));
    let told = |state: &Value| -> Vec<(Value, Vec<String>)> {
        let pin = |plane: &Value| plane["pin"].as_str().unwrap().split('@').next().unwrap().to_owned();
        let pins = |solid: &Value| solid["planes"].as_array().unwrap().iter().map(pin).collect();
        state["cut"].as_array().unwrap().iter().map(|solid| (solid["of_parts"].clone(), pins(solid))).collect()
    };
    let words = |words: &[&str]| -> Vec<String> { words.iter().map(|word| (*word).to_owned()).collect() };
    assert_eq!(told(&state), [(json!([0]), words(&["0:1,0,0,8"])), (json!([1]), words(&["1:0,0,1,10"]))]);
    // Copies have numbers of their own, and are cut alike.
    let state = workbench.post("/api/copies?index=0&value=2");
    assert_eq!(state["cuts"], json!(["0:1,0,0,8", "2:0,0,1,10"]));
    let state = workbench.run("prepare");
    let document = &state["prepared"]["document"];
    assert_eq!(document["verify"]["findings"], json!([]), "{document}");
    assert_eq!(told(&state), [(json!([0, 1]), words(&["0:1,0,0,8"])), (json!([2]), words(&["2:0,0,1,10"]))]);
    let elsewhere = by_hand(state["commands"]["prepare"]["line"].as_str().unwrap(), workbench.folder.path());
    let name = "bracket.trunnion.gcode";
    assert!(workbench.file(name) == std::fs::read(elsewhere.path().join(name)).unwrap());
    // They go with their model, and those of the other one stay.
    assert_eq!(workbench.post("/api/remove?index=0")["cuts"], json!(["0,0,1,10"]));
    assert_eq!(workbench.post("/api/undo")["cuts"], json!(["0:1,0,0,8", "2:0,0,1,10"]));
    read();
    assert_eq!(workbench.post("/api/remove?index=1")["cuts"], json!(["1,0,0,8"]));
}

#[test]
fn a_click_says_which_part_is_cut() {
    let workbench = open(&["bracket", "cube"], &["bracket.stl", "cube.stl", "-m", "generic-ac"]);
    let cuts = |wanted: &str| {
        until(&format!(
            "{STATE}.cuts.join(' ') === '{wanted}' && document.getElementById('cuts')?.getAttribute('aria-busy') === 'false'"
        ))
    };
    let shown = SHOWN.replace("=== 1", "=== 2");
    let row = "[...document.querySelectorAll('.cut')].map((one) => one.textContent.includes('cube.stl'))";
    // From the middle of the last plane's arrow to where it would be 4 mm higher.
    let hauled = "(() => { const s = workbench.scene, { arrow: [a, b], shift } = s.lines.at(-1), box = s.canvas.getBoundingClientRect(), grip = a.map((v, i) => (v + b[i]) / 2); \
         return [grip, [grip[0], grip[1], grip[2] + 4]].map((p) => s.seenAt(p, shift)).map(([u, v]) => [box.left + u, box.top + v]); })()";
    let steps = [
        until(&shown),
        json!({"size": [1200, 900]}),
        key("2"),
        until("document.getElementById('cut-part')"),
        typed("add-cut", "1,0,0"),
        cuts("0:1,0,0,22"),
        typed("cut-part", "1"),
        typed("add-cut", "0,0,1"),
        cuts("0:1,0,0,22 1:0,0,1,10"),
        eval(row),
        // The face of the cube's top, as it is seen from above.
        eval("Object.assign(workbench.scene.camera, { yaw: 0.3, pitch: 0.4 }).yaw"),
        json!({"drag": hauled}),
        cuts("0:1,0,0,22 1:0,0,1,14"),
        typed("cut-part", "0"),
        eval(
            "(() => { const s = workbench.scene; Object.assign(s.camera, { yaw: 0, pitch: 1.5 }); const { low, high, shift } = s.order[1]; \
             const [x, y] = s.seenAt([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, high[2]], shift); return s.faceAt(x, y); })()",
        ),
        // A click on what the plan is to cut aims at it.
        eval(
            "workbench.scene.pick('cut'), workbench.scene.picked({ model: 1, part: 0, normal: [1, 0, 0], offset: 5 })",
        ),
        cuts("0:1,0,0,22 1:0,0,1,14 1:1,0,0,5"),
        eval("document.getElementById('cut-part').value"),
        shot("cuts-of-two"),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let results = &answers.results;
    assert_eq!(results[9], json!([false, true]));
    assert_eq!((&results[14]["model"], &results[14]["normal"]), (&1.into(), &json!([0, 0, 1])));
    assert_eq!(results[17], "1");
}

#[test]
fn a_face_is_cut_along_and_a_plane_that_cannot_be_turns_red_until_it_is_moved() {
    let workbench = open(&["bracket"], &["bracket.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    let mut looks = Looks::new();
    // Looks at the side of the post below the arm, in the middle of the picture.
    let look = "(() => { const s = workbench.scene, { clientWidth: w, clientHeight: h } = s.canvas; \
        for (let k = 0; k < 16; k++) { Object.assign(s.camera, { yaw: k * Math.PI / 8, pitch: 0.02 }); \
        const face = s.faceAt(w / 2, h / 2); if (face && face.normal.join() === '1,0,0') { s.invalidate(); return face.offset; } } return null; })()";
    // What is asked is answered: until then nothing can be typed.
    let settled = |code: &str| {
        until(&format!("({code}) && document.getElementById('cuts').getAttribute('aria-busy') === 'false'"))
    };
    let kinds = "JSON.parse(workbench.scene.planes).map((plane) => `${plane.kind} ${plane.offset}`).join()";
    let steps = [
        until(SHOWN),
        json!({"size": [1200, 900]}),
        key("2"),
        until("document.getElementById('pick-cut')"),
        eval(look),
        click("#pick-cut"),
        eval("document.getElementById('pick-cut').getAttribute('aria-pressed')"),
        click("#canvas"),
        settled(&format!("{STATE}.cuts.length === 1 && workbench.scene.picking === null")),
        eval(&format!(
            "[{STATE}.cuts.join(), {STATE}.cut[0].planes[0].seam_mm2, {kinds}, document.getElementById('command').textContent]"
        )),
        shot("cut"),
        // Beyond the arm there is nothing: red, and the project is as it was.
        typed("offset-0", "51.9"),
        settled("document.querySelector('#cut-0.bad') && document.querySelector('#cut-why .notice.bad')"),
        eval(&format!("[{STATE}.cuts.join(), {kinds}, document.getElementById('cut-why').textContent]")),
        looks.shot("cut-refused"),
        typed("offset-0", "20.5"),
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
        eval(&format!("{STATE}.cuts[0] === {STATE}.cut[0].planes[0].pin")),
        json!({"size": [900, 700]}),
        json!({"scheme": "dark"}),
        eval("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"),
        shot("cut-dark-900"),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    looks.are_kept();
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

#[test]
fn a_plane_is_dragged_by_its_arrow_turned_and_stops_at_faces() {
    let workbench = open(&["bracket"], &["bracket.stl", "-m", "generic-ac"]);
    let settled = |code: &str| {
        until(&format!("({code}) && document.getElementById('cuts')?.getAttribute('aria-busy') === 'false'"))
    };
    let cuts = |wanted: &str| settled(&format!("{STATE}.cuts.join(' ') === '{wanted}'"));
    let kinds = "JSON.parse(workbench.scene.planes).map((plane) => `${plane.kind} ${plane.offset}`).join()";
    // From the middle of the plane's arrow to where it would be at `x`.
    let hauled = |x: f64| {
        format!(
            "(() => {{ const s = workbench.scene, {{ arrow: [a, b] }} = s.lines[0], box = s.canvas.getBoundingClientRect(), grip = a.map((v, i) => (v + b[i]) / 2); \
             return [grip, [grip[0] + {x} - a[0], grip[1], grip[2]]].map((p) => s.seenAt(p, s.lines[0].shift)).map(([u, v]) => [box.left + u, box.top + v]); }})()"
        )
    };
    let steps = [
        until(SHOWN),
        json!({"size": [1200, 900]}),
        key("2"),
        until("document.getElementById('add-cut')"),
        typed("add-cut", "1,0,0"),
        cuts("1,0,0,22"),
        eval("[[1, 0, 0], [0, 0, 1]].map((normal) => workbench.scene.stops(normal, { model: 0, part: 0 }))"),
        eval("[document.getElementById('lean-0').value, document.getElementById('towards-0').value]"),
        // Turned about the middle of what it cuts.
        typed("towards-0", "10"),
        settled(&format!("{STATE}.cuts.join().startsWith('0.98')")),
        eval(&format!("[{STATE}.cuts.join(), {STATE}.cut[0].planes[0].seam_mm2]")),
        shot("cut-turned"),
        eval("document.getElementById('slide-0').focus()"),
        key("Control+z"),
        cuts("1,0,0,22"),
        // Dragged: near the face of the post it lies along it, and elsewhere where it was put.
        eval("Object.assign(workbench.scene.camera, { yaw: -1.2, pitch: 0.4 }).yaw"),
        json!({"drag": hauled(8.5)}),
        cuts("1,0,0,8"),
        shot("cut-dragged"),
        json!({"drag": hauled(30.0)}),
        cuts("1,0,0,30"),
        // A click on it changes nothing.
        eval("workbench.revisionBefore = workbench.page.state.revision"),
        json!({"drag": hauled(30.0)}),
        eval("[workbench.page.state.revision - workbench.revisionBefore, workbench.scene.camera.yaw]"),
        // By keys from face to face: the last one has nothing beyond it.
        eval("document.getElementById('slide-0').focus()"),
        key("PageUp"),
        settled("document.querySelector('#cut-0.bad')"),
        eval(kinds),
        key("PageDown"),
        cuts("1,0,0,8"),
        eval(&format!("[document.activeElement.id, document.activeElement.value, {kinds}]")),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let results = &answers.results;
    assert_eq!(results[6], json!([[-8, 8, 52], [0, 22, 30]]));
    assert_eq!(results[7], json!(["90", "0"]));
    assert_eq!(results[10][0], "0.984808,0.173648,0,21.6658");
    assert!((results[10][1].as_f64().unwrap() - 128.0 / 10f64.to_radians().cos()).abs() < 0.01, "{}", results[10]);
    assert_eq!(results[23], json!([0, -1.2]));
    assert_eq!((&results[27], &results[30]), (&"bad 52".into(), &json!(["slide-0", "8", "chosen 8"])));
}

#[test]
fn a_plane_through_what_another_one_cuts_off_comes_before_that() {
    let folder = folder();
    // A post with an arm, and at its end another one at a right angle to both.
    let post = solids::block(16.0, 16.0, 30.0).at(-8.0, -8.0, 0.0);
    let elbow =
        solids::block(44.0, 16.0, 8.0).at(8.0, -8.0, 22.0).and(&solids::block(16.0, 32.0, 8.0).at(36.0, 8.0, 22.0));
    std::fs::write(folder.path().join("elbow.stl"), stl_binary(&post.and(&elbow).mesh())).unwrap();
    let workbench = open_in(folder, &["elbow.stl", "-m", "generic-ac"]);
    let cuts = |wanted: &str| {
        until(&format!(
            "{STATE}.cuts.join(' ') === '{wanted}' && document.getElementById('cuts')?.getAttribute('aria-busy') === 'false'"
        ))
    };
    let steps = [
        until(SHOWN),
        key("2"),
        until("document.getElementById('add-cut')"),
        typed("add-cut", "1,0,0"),
        cuts("1,0,0,22"),
        typed("offset-0", "8"),
        cuts("1,0,0,8"),
        // As a click on the side of the first arm does.
        eval("workbench.scene.picked({ model: 0, part: 0, normal: [0, 1, 0], offset: 8 })"),
        cuts("0,1,0,8 1,0,0,8"),
        eval("[document.querySelector('.cut.bad'), document.getElementById('cut-why').textContent]"),
        eval("document.getElementById('slide-0').focus()"),
        key("Control+z"),
        cuts("1,0,0,8"),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    assert_eq!(answers.results[9], json!([null, ""]));
}
