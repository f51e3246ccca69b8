//! The page in headless Chromium, by pointer and by keys.

use serde_json::{Value, json};
use trunnion::publish::Kind;

use super::looks::Looks;
use super::{Workbench, open, open_in};
use crate::preview::browser::{Answers, browse_any};
use crate::publish::Server;
use crate::support::folder;

pub(super) fn eval(code: &str) -> Value {
    json!({"eval": code})
}

pub(super) fn until(code: &str) -> Value {
    json!({"until": code})
}

pub(super) fn click(selector: &str) -> Value {
    json!({"click": selector})
}

pub(super) fn key(key: &str) -> Value {
    json!({"key": key})
}

/// Lists and fields are the browser's own, with their keys: here their value changes, as those do it.
pub(super) fn typed(id: &str, value: &str) -> Value {
    eval(&format!(
        "(() => {{ const it = document.getElementById('{id}'); it.focus(); it.value = '{value}'; \
         for (const what of ['input', 'change']) it.dispatchEvent(new Event(what, {{ bubbles: true }})); }})()"
    ))
}

/// A picture, where somebody wants to look: `TRUNNION_SHOTS` names a folder.
pub(super) fn shot(name: &str) -> Value {
    match std::env::var("TRUNNION_SHOTS") {
        Ok(folder) => json!({"shot": format!("{folder}/{name}.png")}),
        Err(_) => eval("0"),
    }
}

pub(super) const STATE: &str = "workbench.page.state";

/// One model is drawn on its machine, as large as the page is then.
pub(super) const SHOWN: &str = "workbench.scene.order.length === 1 && workbench.scene.machine && !workbench.scene.waiting && workbench.page.machines.machines";

/// Nothing was complained of, and nothing left this computer.
#[track_caller]
pub(super) fn quiet(answers: &Answers, workbench: &Workbench) {
    assert_eq!(answers.console, Vec::<Value>::new());
    let own = [format!("http://127.0.0.1:{}/", workbench.port), "data:".to_owned(), "about:".to_owned()];
    let outside = |url: &&Value| !own.iter().any(|own| url.as_str().unwrap().starts_with(own.as_str()));
    assert_eq!(answers.requests.iter().find(outside), None);
    let secret = workbench.secret();
    assert!(answers.requests.iter().all(|url| !url.as_str().unwrap().contains(secret)), "{:?}", answers.requests);
}

/// Pixels of the scene that are like overhangs: more red than green, more green than blue.
const ORANGE: &str = "(() => { const c = document.createElement('canvas'), s = byId('canvas'); Object.assign(c, { width: 200, height: 160 }); \
     const x = c.getContext('2d'); x.drawImage(s, 0, 0, 200, 160); const d = x.getImageData(0, 0, 200, 160).data; let n = 0; \
     for (let i = 0; i < d.length; i += 4) if (d[i] > d[i + 1] + 40 && d[i + 1] > d[i + 2] + 40) n++; return n; })()";

#[test]
fn a_hook_is_opened_priced_chosen_prepared_and_looked_at() {
    let workbench = open(&["hook", "cube"], &["hook.stl", "-m", "generic-ac"]);
    let file = workbench.folder.path().join("cube.stl").display().to_string();
    let mut looks = Looks::new();
    let steps = [
        until(SHOWN),
        looks.shot("model"),
        eval(&ORANGE.replace("byId", "document.getElementById.bind(document)")),
        eval("document.getElementById('panel').textContent"),
        // Another model, chosen as a file is.
        json!({"files": [file]}),
        until("workbench.scene.order.length === 2"),
        eval(&format!("{STATE}.models.map((model) => model.path)")),
        click("#models li:last-child .round"),
        until("workbench.scene.order.length === 1"),
        eval(&format!("document.getElementById('room-how').click(), {STATE}.models.length")),
        until("document.getElementById('slicer')"),
        eval(
            "(() => { const s = document.getElementById('slicer'); s.value = 'builtin'; s.dispatchEvent(new Event('change', { bubbles: true })); })()",
        ),
        until(&format!("{STATE}.slicer === 'builtin'")),
        click("#find"),
        until(&format!("{STATE}.ways && !{STATE}.busy")),
        looks.shot("how"),
        eval("[...document.querySelectorAll('.way')].map((card) => card.id + ' ' + card.className)"),
        click("#way-supports"),
        until(&format!("{STATE}.way === 'supports'")),
        eval("document.getElementById('command').textContent"),
        click("#room-see"),
        eval(
            "[document.querySelector('.notice.stale') !== null, document.getElementById('file-gcode'), document.getElementById('preview')]",
        ),
        click("#prepare"),
        until(&format!("{STATE}.prepared && !{STATE}.prepared.stale && document.getElementById('preview')")),
        eval(
            "[document.getElementById('panel').textContent, document.getElementById('file-gcode').getAttribute('href'), document.getElementById('preview').getAttribute('sandbox')]",
        ),
        json!({"frame": "trunnion.ready.then(() => trunnion.replay.count)"}),
        // As a print that goes on does, and a finding.
        eval("workbench.showLine(700)"),
        json!({"frame": "new Promise((done) => { const look = () => (trunnion.frame().line === 700 ? done(700) : setTimeout(look, 20)); look(); })"}),
        shot("see"),
        json!({"size": [900, 700]}),
        json!({"scheme": "dark"}),
        click("#room-how"),
        eval("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"),
        looks.shot("how-dark-900"),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    looks.are_kept();
    let results = &answers.results;
    let text = |i: usize| results[i].as_str().unwrap();
    assert!(results[2].as_u64().unwrap() > 12, "{} orange pixels", results[2]);
    assert!(
        text(3).contains("hook.stl") && text(3).contains("40.0 × 10.0 × 60.0 mm") && text(3).contains("closed"),
        "{}",
        text(3)
    );
    assert_eq!(results[6], json!(["hook.stl", "cube.stl"]));
    assert_eq!(results[9], 1);
    let cards = results[16].to_string();
    for card in
        ["way-turned way possible", "way-supports way possible", "way-as-drawn way impossible", "way-cut way dearer"]
    {
        assert!(cards.contains(card), "{card}: {cards}");
    }
    assert!(
        text(19).starts_with("trunnion prepare hook.stl -m generic-ac --way supports --slicer builtin -o "),
        "{}",
        text(19)
    );
    assert_eq!(results[21], json!([true, null, null]));
    let shown = results[24][0].as_str().unwrap();
    assert!(shown.contains("Verified: no findings") && shown.contains("On supports"), "{shown}");
    assert_eq!((&results[24][1], &results[24][2]), (&json!("/files/hook.trunnion.gcode"), &json!("allow-scripts")));
    assert!(results[25].as_u64().unwrap() > 1000, "{} moves in the frame", results[25]);
    assert_eq!(results[27], 700);
    assert_eq!(results[32], json!([900, 700]));
}

#[test]
fn the_keyboard_is_enough_to_prepare_and_rehearse() {
    let workbench = open(&["cube"], &["cube.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    let mut looks = Looks::new();
    let focused = |id: &str| until(&format!("document.activeElement.id === '{id}'"));
    let steps = [
        until(&format!("{STATE} && workbench.page.machines.machines")),
        key("3"),
        focused("room-see"),
        key("Tab"),
        focused("canvas"),
        key("Tab"),
        focused("prepare"),
        eval("getComputedStyle(document.activeElement).outlineStyle"),
        key("Enter"),
        until(&format!("{STATE}.prepared && !{STATE}.busy")),
        eval(&format!("{STATE}.prepared.document.verify.findings.length")),
        key("4"),
        focused("room-print"),
        key("ArrowUp"),
        focused("room-see"),
        key("ArrowDown"),
        focused("room-print"),
        // The rehearsal says how long it took.
        looks.shot("print"),
        eval("document.getElementById('rehearse').focus()"),
        key("Enter"),
        until(&format!("{STATE}.runs.rehearse && !{STATE}.runs.rehearse.running")),
        eval("document.getElementById('panel').textContent"),
        shot("rehearsed"),
        eval("document.getElementById('canvas').getAttribute('aria-label')"),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    looks.are_kept();
    assert_eq!(answers.results[7], "solid");
    assert_eq!(answers.results[10], 0);
    assert!(answers.results[21].as_str().unwrap().contains("Rehearsed: "), "{}", answers.results[21]);
}

#[test]
fn what_goes_wrong_is_told_on_the_page() {
    const MARKUP: &str = "<img src=x onerror=alert(1)>.stl";
    let folder = folder();
    std::fs::copy(crate::pipeline::fixture("cube"), folder.path().join(MARKUP)).unwrap();
    let workbench = open_in(folder, &[MARKUP, "no-such.stl"]);
    let steps = [
        until(&format!(
            "{STATE} && {STATE}.models.every((model) => model.inspected) && workbench.page.machines.machines"
        )),
        eval("document.getElementById('panel').textContent"),
        eval("document.querySelectorAll('#panel img, #foot img').length"),
        click("#room-how"),
        eval(
            "[document.getElementById('find').disabled, document.getElementById('panel').textContent, document.getElementById('command').textContent]",
        ),
        // A second page changes the project; this one is told, and shows what is.
        eval(&format!(
            "fetch('/api/set?name=way&value=cut&revision=' + {STATE}.revision, {{ method: 'POST', headers: {{ Authorization: 'Bearer ' + location.hash.slice(1) }} }}).then((r) => r.status)"
        )),
        until(&format!("{STATE}.way === 'cut'")),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let panel = answers.results[1].as_str().unwrap();
    assert!(panel.contains("no-such.stl") && panel.contains("trunnion explain input/absent"), "{panel}");
    assert!(panel.contains(MARKUP) && answers.results[2] == 0, "{panel}");
    let how = &answers.results[4];
    assert!(
        how[0] == true
            && how[1].as_str().unwrap().contains("Choose a machine first.")
            && how[2] == "Choose a machine first.",
        "{how}"
    );
    assert_eq!(answers.results[5], 200);
}

#[test]
fn a_click_puts_the_model_on_a_face_and_the_command_says_so() {
    let workbench = open(&["cube"], &["cube.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    let steps = [
        until(SHOWN),
        click("#pick"),
        eval("document.getElementById('pick').getAttribute('aria-pressed')"),
        click("#canvas"),
        until(&format!("{STATE}.up !== 'auto' && !workbench.scene.picking && workbench.scene.order[0].turn[10] !== 1")),
        eval(&format!("{STATE}.up")),
        // What was at the side is below: the same direction is now the normal of the top.
        eval("workbench.scene.order[0].high.map((v, k) => Math.round(v - workbench.scene.order[0].low[k]))"),
        click("#pick"),
        key("Escape"),
        eval("workbench.scene.picking !== null"),
        shot("face"),
        click("#room-see"),
        eval("document.getElementById('command').textContent"),
        click("#prepare"),
        until(&format!("{STATE}.prepared && !{STATE}.busy")),
        eval(&format!("{STATE}.prepared.document.verify.findings.length")),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let results = &answers.results;
    assert_eq!(results[2], "true");
    let up = results[5].as_str().unwrap();
    assert!(["1,0,0", "-1,0,0", "0,1,0", "0,-1,0", "0,0,-1"].contains(&up), "{up}");
    assert_eq!((&results[6], &results[9], &results[15]), (&json!([20, 20, 20]), &json!(false), &json!(0)));
    assert!(results[12].as_str().unwrap().contains(&format!(" --up {up} ")), "{}", results[12]);
}

#[test]
fn a_print_is_uploaded_by_the_keyboard_and_started_by_a_click() {
    let server = Server::of(Kind::OctoPrint);
    let workbench = open(&["cube"], &["cube.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    let folder = workbench.folder.path();
    std::fs::write(folder.join("printer.key"), "any\n").unwrap();
    let told = || eval("document.getElementById('panel').textContent");
    let steps = [
        until(&format!("{STATE} && workbench.page.machines.machines")),
        key("3"),
        until("document.getElementById('prepare')"),
        click("#prepare"),
        until(&format!("{STATE}.prepared && !{STATE}.busy")),
        key("4"),
        until("document.getElementById('server')"),
        eval("document.getElementById('publish').disabled"),
        typed("server", &server.to()),
        until(&format!("{STATE}.printers[0].server")),
        typed("key_file", "printer.key"),
        until(&format!("{STATE}.printers[0].key_file && !document.getElementById('publish').disabled")),
        eval("document.getElementById('command').textContent"),
        eval("document.getElementById('publish').focus()"),
        key("Enter"),
        until(&format!("{STATE}.runs.publish && !{STATE}.runs.publish.running")),
        told(),
        click("#publish-and-start"),
        until(&format!("{STATE}.runs['publish-and-start'] && !{STATE}.runs['publish-and-start'].running")),
        told(),
        shot("publish"),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    let text = |i: usize| answers.results[i].as_str().unwrap();
    assert_eq!(answers.results[7], true);
    let wanted = format!(
        "trunnion publish cube.trunnion.gcode --plan cube.trunnion.plan.json --to {} --key-file printer.key",
        server.to()
    );
    assert_eq!(text(12), wanted);
    assert!(text(16).contains("cube.trunnion.gcode is on"), "{}", text(16));
    assert!(text(19).contains("was already on") && text(19).contains("has started"), "{}", text(19));
    assert_eq!(server.inside().started, 1);
}

/// A second printer by pointer and by keys: what it has is its own, and goes when it goes.
#[test]
fn a_printer_is_added_named_and_removed_on_the_page() {
    let workbench = open(&["cube"], &["cube.stl", "-m", "generic-ac"]);
    let mut looks = Looks::new();
    let fields = "[...document.querySelectorAll('#panel input')].map((input) => `${input.dataset.set} ${input.value}`)";
    let count = |printers: usize| until(&format!("{STATE}.printers.length === {printers}"));
    let steps = [
        until(SHOWN),
        key("4"),
        until("document.getElementById('port')"),
        eval("document.querySelectorAll('.printer-card').length"),
        typed("port", "tty"),
        until(&format!("{STATE}.printers[0].port === 'tty'")),
        click("#add-printer"),
        count(2),
        until("document.getElementById('port-2')"),
        typed("printer_name-2", "left"),
        until(&format!("{STATE}.printers[1].name === 'left'")),
        typed("port-2", "tty2"),
        until(&format!("{STATE}.printers[1].port === 'tty2'")),
        eval(fields),
        looks.shot("printers"),
        eval("document.getElementById('printer-1').focus()"),
        key("Enter"),
        eval(fields),
        eval("document.getElementById('remove-printer')"),
        click(".printer-card[data-printer=\"2\"]"),
        click("#remove-printer"),
        count(1),
        eval(fields),
        key("Control+z"),
        count(2),
        eval("document.querySelector('.printer-card[data-printer=\"2\"]').textContent"),
    ];
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    quiet(&answers, &workbench);
    looks.are_kept();
    let results = &answers.results;
    let first = json!(["port tty", "server ", "key_file "]);
    assert_eq!((&results[3], &results[22], &results[18]), (&json!(0), &first, &Value::Null));
    assert_eq!(results[13], json!(["printer_name:2 left", "port:2 tty2", "server:2 ", "key_file:2 "]));
    assert_eq!(results[17], json!(["printer_name ", "port tty", "server ", "key_file "]));
    assert_eq!(results[25], "leftfree");
}
