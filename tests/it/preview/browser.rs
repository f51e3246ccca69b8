//! The page in a real browser: headless Chromium, drawing in software, driven through its debugging pipe by `chromium.py`.
//!
//! Where there is no Chromium or no Python 3 every test says so aloud and is left out.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use super::{Shown, moment, preview};
use crate::mutants::{Victim, mutants};
use crate::support::{Numbers, every, note, python, root, said, skip};

/// What a browser answers.
pub(crate) struct Answers {
    pub(crate) results: Vec<Value>,
    pub(crate) console: Vec<Value>,
    pub(crate) requests: Vec<Value>,
}

/// The names under which Chromium is installed.
const NAMES: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Carries out `steps` on `page`; `None`, aloud, where that cannot be done here.
fn browse(page: &Path, steps: &[Value]) -> Option<Answers> {
    browse_after("ready.then(() => 0)", page, steps)
}

/// The same for a page that is none of ours by itself.
pub(crate) fn browse_any(page: &Path, steps: &[Value]) -> Option<Answers> {
    browse_after("0", page, steps)
}

fn browse_after(first: &str, page: &Path, steps: &[Value]) -> Option<Answers> {
    let program =
        NAMES.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success()));
    let Some((program, python)) = program.zip(python(&["python3", "python"], "subprocess")) else {
        skip("Chromium or Python 3 is not installed: the preview page is not opened");
        return None;
    };
    let mut driver = Command::new(python)
        .arg(root().join("tests/it/preview/chromium.py"))
        // Software draws each pixel: as few as the page is laid out for.
        .args([program, &page.display().to_string(), "820", "560"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let steps: Vec<Value> = std::iter::once(eval(first)).chain(steps.iter().cloned()).collect();
    driver.stdin.take().unwrap().write_all(json!(steps).to_string().as_bytes()).unwrap();
    let run = driver.wait_with_output().unwrap();
    assert!(run.status.success(), "{}: {}", page.display(), said(&run));
    let answer: Value = serde_json::from_slice(&run.stdout).unwrap();
    let list = |key: &str| answer[key].as_array().unwrap().clone();
    Some(Answers { results: list("results").split_off(1), console: list("console"), requests: list("requests") })
}

impl Answers {
    /// Nothing was complained of, and nothing but the file itself was asked for.
    #[track_caller]
    fn quiet(&self) {
        assert_eq!(self.console, Vec::<Value>::new());
        assert_eq!(self.requests.len(), 1, "{:?}", self.requests);
        assert!(self.requests[0].as_str().unwrap().starts_with("file:///"), "{:?}", self.requests);
    }
}

fn eval(code: &str) -> Value {
    json!({"eval": code})
}

/// Waits until the whole picture of what is shown now is there.
fn whole() -> Value {
    eval(
        "new Promise((done) => { state.whole = 0; invalidate(); const look = () => state.whole ? done(state.frameMs) : setTimeout(look, 20); look(); })",
    )
}

/// The picture alone, in so many pixels across, as red, green and blue: what lettering a system has does not matter.
fn picture() -> Value {
    eval(
        "(() => { const s = document.createElement('canvas'); Object.assign(s, { width: 120, height: 80 }); const c = s.getContext('2d'); \
         c.imageSmoothingQuality = 'high'; c.drawImage(byId('canvas'), 0, 0, 120, 80); return [...c.getImageData(0, 0, 120, 80).data].filter((_, i) => i % 4 < 3); })()",
    )
}

fn bytes(value: &Value) -> Vec<u8> {
    value.as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as u8).collect()
}

/// Pixels that are coloured: not grey, as back, table and head are.
fn coloured(pixels: &[u8]) -> usize {
    let spread = |p: &[u8]| p.iter().max().unwrap() - p.iter().min().unwrap();
    pixels.chunks(3).filter(|p| spread(p) > 40).count()
}

/// What is wrong with a picture: it is not as the committed one, or there is none, and it is written to be looked at and committed.
fn unlike_committed(name: &str, pixels: &[u8]) -> Option<String> {
    let path = root().join(format!("tests/it/preview/pictures/{name}.png"));
    let Ok(file) = std::fs::File::open(&path) else {
        let mut encoder = png::Encoder::new(std::fs::File::create(&path).unwrap(), 120, 80);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(pixels).unwrap();
        return Some(format!("{} was not there; look at what was written, and commit it", path.display()));
    };
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let mut wanted = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut wanted).unwrap();
    assert_eq!(wanted.len(), pixels.len());
    let off = wanted.iter().zip(pixels).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / pixels.len() as f64;
    note(&format!("{name}: {off:.2} of 255 away from the committed picture"));
    // Drivers round edges differently.
    (off >= 4.0).then(|| format!("{name}: the picture is {off:.2} of 255 away from the committed one"))
}

/// The stage alone, of one size whatever the lettering.
const STAGE: &str = "(() => { setTheme(false); byId('stage').style.cssText = 'position:fixed;left:0;top:0;width:900px;height:600px;z-index:9'; })()";

#[test]
fn the_page_shows_plays_and_answers_keys() {
    let shown = Shown::of("y-tree");
    let modes = ["part", "slot", "feature", "speed", "flow", "height", "temperature", "clearance"];
    let mut steps = vec![eval("setTheme(false)"), whole(), picture(), eval("byId('summary').textContent")];
    for mode in modes {
        steps.extend([
            eval(&format!("byId('colour').value = '{mode}'; byId('colour').dispatchEvent(new Event('change'))")),
            whole(),
            picture(),
        ]);
        steps.push(eval("byId('legend').textContent"));
    }
    let after_modes = steps.len();
    steps.extend([
        eval("byId('time').value = replay.seconds / 3; byId('time').dispatchEvent(new Event('input')); [state.move, currentLine(), byId('clock').textContent]"),
        json!({"key": "Home"}),
        eval("[state.move, state.share]"),
        json!({"key": " "}),
        eval("new Promise((done) => setTimeout(() => done([state.playing, state.move, byId('play').textContent]), 1500))"),
        json!({"key": " "}),
        json!({"key": "v"}),
        eval("[state.playing, state.table, byId('view-machine').getAttribute('aria-pressed')]"),
        json!({"click": "#view-table"}),
        eval("state.table"),
        json!({"key": "End"}),
        json!({"key": "PageDown"}),
        eval("[replay.layerOf(state.move), replay.layers.length]"),
        json!({"key": "d"}),
        eval("document.documentElement.className"),
        json!({"key": "t"}),
        json!({"key": "l"}),
        json!({"key": "o"}),
        json!({"key": "h"}),
        eval("[state.travels, state.oneLayer, state.parts, state.machine]"),
        json!({"key": "?"}),
        eval("byId('help').open && byId('keys').rows.length"),
        json!({"key": "Escape"}),
    ]);
    let Some(answers) = browse(&shown.page, &steps) else { return };
    answers.quiet();
    let results = &answers.results;
    assert!(coloured(&bytes(&results[2])) > 150, "{} coloured pixels", coloured(&bytes(&results[2])));
    assert!(results[3].as_str().unwrap().contains("Verification has no findings"), "{}", results[3]);
    let mut pictures: Vec<Vec<u8>> = Vec::new();
    for (i, mode) in modes.iter().enumerate() {
        let pixels = bytes(&results[4 + i * 4 + 2]);
        assert!(coloured(&pixels) > 150, "{mode}: {} coloured pixels", coloured(&pixels));
        assert!(!results[4 + i * 4 + 3].as_str().unwrap().contains("not known"), "{mode}: {}", results[4 + i * 4 + 3]);
        pictures.push(pixels);
    }
    // A part, a feature and a speed are coloured differently.
    assert!(pictures[0] != pictures[2] && pictures[2] != pictures[3]);
    let after = &results[after_modes..];
    assert!(after[0][0].as_u64().unwrap() > 100 && after[0][1].as_u64().unwrap() > 100, "{}", after[0]);
    assert_eq!(after[2], json!([0, 0]));
    assert!(after[4][0] == true && after[4][1].as_u64().unwrap() > 0 && after[4][2] == "Pause", "{}", after[4]);
    assert_eq!(after[7], json!([false, false, "true"]));
    assert_eq!(after[9], true);
    assert_eq!(after[12][0].as_u64().unwrap() + 2, after[12][1].as_u64().unwrap(), "{}", after[12]);
    assert_eq!(after[14], "dark");
    assert_eq!(after[19], json!([true, true, true, false]));
    assert!(after[21].as_u64().unwrap() > 30, "{}", after[21]);
}

#[test]
fn head_and_table_stand_where_the_replay_has_them() {
    stand_where_the_replay_has_them("");
}

#[test]
fn a_table_with_leaning_axes_stands_where_the_replay_has_it() {
    stand_where_the_replay_has_them(
        "[kinematics.tilt]\nalong = [0.998, 0.05, -0.04]\n[kinematics.rotation]\nalong = [0.03, -0.05, 0.998]\n",
    );
}

/// On the generic machine with these keys.
fn stand_where_the_replay_has_them(keys: &str) {
    let shown = Shown::on("y-tree", keys);
    let machine = trunnion::profile::resolve("own.toml", &format!("extends = \"generic-ac\"\n{keys}")).unwrap().0;
    let (trace, table) = (shown.trace(), machine.kinematics());
    let mut numbers = Numbers::seeded(3);
    let known: Vec<usize> = (0..trace.len()).filter(|&i| moment(&trace, i, 0.5).is_some()).collect();
    let turning = known.iter().copied().filter(|&i| trace.turns(&trace.at(i)));
    let mut drawn = || numbers.between(0.0, 1.0);
    let random: Vec<usize> = (0..10).map(|_| known[(drawn() * (known.len() as f64 - 0.5)) as usize]).collect();
    let chosen: Vec<(usize, f64)> = random.into_iter().chain(turning).map(|i| (i, drawn())).collect();
    assert!(chosen.len() > 12, "{} moments", chosen.len());
    let steps: Vec<Value> =
        chosen.iter().map(|(i, share)| eval(&format!("trunnion.seek({i}, {share}); trunnion.frame()"))).collect();
    let Some(answers) = browse(&shown.page, &steps) else { return };
    answers.quiet();
    for ((index, share), frame) in chosen.iter().zip(&answers.results) {
        let (tip, pose) = moment(&trace, *index, *share).unwrap();
        let at = |key: &str, i: usize| frame[key][i].as_f64().unwrap();
        assert!((0..3).all(|i| (at("tip", i) - tip[i]).abs() < 1e-3), "move {index}: {frame} for {tip}");
        let motion = table.forward(pose);
        // Columns, as WebGL has them. A rim 150 mm away moves by less than a thousandth of a millimetre.
        let turned = (0..9).all(|i| (at("motion", i / 3 * 4 + i % 3) - motion.rotation[(i % 3, i / 3)]).abs() < 6e-6);
        let shifted = (0..3).all(|i| (at("motion", 12 + i) - motion.translation[i]).abs() < 1e-3);
        assert!(turned && shifted, "move {index}: {frame} for {motion:?}");
        assert_eq!(frame["line"], trace.at(*index).line);
    }
}

#[test]
fn pictures_are_as_they_were_when_they_were_looked_at() {
    let (tree, boxes) = (Shown::of("y-tree"), Shown::of("two-boxes"));
    let steps = [
        eval(STAGE),
        eval("fit()"),
        whole(),
        picture(),
        eval(
            "setView(false); const there = replay.places.findIndex((p) => p.slot !== null && p.tilt > 0.5); seek(replay.layers.find((i) => replay.place[i] === there)); fit()",
        ),
        whole(),
        picture(),
        eval(
            "setView(true); state.mode = 'feature'; recolour(); seek(replay.count >> 1); setTheme(true); toggle('machine'); fit()",
        ),
        whole(),
        picture(),
    ];
    let mut wrong = Vec::new();
    let mut seen: Vec<Vec<u8>> = Vec::new();
    for (name, shown) in [("y-tree", &tree), ("two-boxes", &boxes)] {
        let Some(answers) = browse(&shown.page, &steps) else { return };
        answers.quiet();
        for (view, i) in [("table", 3), ("machine", 6), ("feature-dark", 9)] {
            let pixels = bytes(&answers.results[i]);
            wrong.extend(unlike_committed(&format!("{name}-{view}"), &pixels));
            seen.push(pixels);
        }
    }
    assert_eq!(wrong, Vec::<String>::new());
    // The measure tells pictures apart: the other model from the same side is beyond it.
    let apart =
        |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64;
    assert!(
        (0..3).all(|i| apart(&seen[i], &seen[i + 3]) > 6.0),
        "{:?}",
        [0, 1, 2].map(|i| apart(&seen[i], &seen[i + 3]))
    );
}

#[test]
fn two_clicks_measure_a_distance_and_the_text_keeps_step() {
    let shown = Shown::of("two-boxes");
    let text = std::fs::read_to_string(&shown.program).unwrap();
    let steps = [
        eval("toggle('measuring'); look(-Math.PI / 2, 1.5707); fit(); [beads.box.low, beads.box.high]"),
        // The middles of two opposite upper edges, where they are on the page.
        eval(
            "const edge = (k) => { const b = beads.box, p = onPage(moved(now().fromTable, [[b.low[0], b.high[0]][k], (b.low[1] + b.high[1]) / 2, b.high[2]])), c = byId('canvas').getBoundingClientRect(); return [p[0] + c.left, p[1] + c.top]; }; [edge(0), edge(1)]",
        ),
        eval(
            "measure(...edge(0).map((v, k) => v - [byId('canvas').getBoundingClientRect().left, byId('canvas').getBoundingClientRect().top][k])); state.points.length",
        ),
        eval(
            "measure(...edge(1).map((v, k) => v - [byId('canvas').getBoundingClientRect().left, byId('canvas').getBoundingClientRect().top][k])); [Math.hypot(...plus(state.points[1], state.points[0], -1)), byId('status').textContent]",
        ),
        eval(
            "seekLine(Math.round(replay.facts.lines / 2)); [...document.querySelectorAll('#text div')].map((row) => [Number(row.children[0].textContent), row.children[1].textContent, row.className.includes('now')])",
        ),
        eval("Array.from({ length: replay.facts.lines }, (_, i) => replay.text(i + 1)).join('\\n')"),
    ];
    let Some(answers) = browse(&shown.page, &steps) else { return };
    answers.quiet();
    let results = &answers.results;
    let wide = results[0][1][0].as_f64().unwrap() - results[0][0][0].as_f64().unwrap();
    let measured = results[3][0].as_f64().unwrap();
    assert!(wide > 10.0 && (measured - wide).abs() < 1.5, "{measured} mm for {wide} mm; {results:?}");
    assert_eq!(results[3][1], format!("distance {measured:.2} mm"));
    let rows = results[4].as_array().unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert!(rows.len() > 4 && rows.iter().filter(|row| row[2] == true).count() == 1, "{rows:?}");
    assert!(
        rows.iter().all(|row| lines[row[0].as_u64().unwrap() as usize - 1] == row[1].as_str().unwrap()),
        "{rows:?}"
    );
    assert!(results[5].as_str().unwrap().lines().eq(text.lines()), "the page has another text than the file");
}

/// A file cut short before its first bead, and one of a single move, are pages all the same.
#[test]
fn a_file_that_lays_nothing_opens() {
    let shown = Shown::of("two-boxes");
    let text = std::fs::read_to_string(&shown.program).unwrap();
    let file = shown.folder.path().join("short.gcode");
    let first = text.lines().position(|line| line.starts_with("G1")).unwrap();
    let bead =
        text.lines().position(|line| line.starts_with("G1") && line.contains(" X") && line.contains(" E")).unwrap();
    for (lines, moves) in [(first + 1, 1), (bead, 4)] {
        std::fs::write(&file, text.lines().take(lines).collect::<Vec<_>>().join("\n")).unwrap();
        let document = preview(&file, &shown.plan, &shown.page, 1);
        assert!(document["moves"].as_u64().unwrap() >= moves && document["layers"] == 0, "{document}");
        let keys = ["PageUp", "PageDown", "Home", "End", ".", ",", "c", "t", "l", "v", "n", "p", " ", "k"];
        let mut steps: Vec<Value> = keys.iter().map(|key| json!({"key": key})).collect();
        steps.extend([whole(), eval("byId('problem').hidden && byId('summary').textContent")]);
        let Some(answers) = browse(&shown.page, &steps) else { return };
        answers.quiet();
        assert!(answers.results[keys.len() + 1].as_str().unwrap().contains("0 layers"), "{:?}", answers.results.last());
    }
}

/// For each rule of verification a file that breaks it: the page lists what `verify --json` does, and each entry leads to its line.
#[test]
fn every_finding_leads_to_its_line() {
    let victim = Victim::of("two-boxes");
    let page = victim.folder.path().join("mutant.html");
    let mut rules = std::collections::BTreeSet::new();
    for (wanted, change) in mutants(&victim).into_iter().step_by(every(3)) {
        let file = victim.changed(change);
        let report = crate::mutants::report(&file, &victim.plan);
        let document = preview(&file, &victim.plan, &page, 1);
        assert_eq!(document["verify"]["findings"], report["findings"], "{wanted:?}");
        let read = super::Page::read(std::fs::read_to_string(&page).unwrap());
        assert_eq!(read.facts["verify"]["findings"], report["findings"], "{wanted:?}");
        let steps = [
            eval(
                "[...document.querySelectorAll('#findings button[data-line]')].map((b) => [Number(b.dataset.line), b.dataset.rule, b.textContent])",
            ),
            eval(
                "facts.verify.findings.map((_, i) => { document.querySelectorAll('#findings button')[i].click(); const row = document.querySelector('#text .now'); \
                 return row && [Number(row.children[0].textContent), row.children[1].textContent, replay.line[state.move], replay.line[state.move + 1] ?? 1e9]; })",
            ),
        ];
        let Some(answers) = browse(&page, &steps) else { return };
        answers.quiet();
        let findings = report["findings"].as_array().unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let first_move = read.moves()[0].line as usize;
        let (listed, landed) = (answers.results[0].as_array().unwrap(), answers.results[1].as_array().unwrap());
        assert_eq!((listed.len(), landed.len()), (findings.len(), findings.len()), "{wanted:?}");
        for ((finding, entry), row) in findings.iter().zip(listed).zip(landed) {
            let line = finding["line"].as_u64().unwrap() as usize;
            assert_eq!([&entry[0], &entry[1]], [&finding["line"], &finding["rule"]]);
            assert!(entry[2].as_str().unwrap().ends_with(finding["text"].as_str().unwrap()), "{entry} for {finding}");
            assert_eq!([&row[0], &row[1]], [&json!(line), &json!(lines[line - 1])], "{finding}");
            // The picture stands at the last move up to that line; before the first move at the first.
            let [at, next] = [2, 3].map(|i| row[i].as_u64().unwrap() as usize);
            assert!(
                next > line && (at <= line || at == first_move),
                "{finding}: move of line {at}, the next of {next}"
            );
            rules.insert(finding["rule"].as_str().unwrap().to_owned());
        }
    }
    note(&format!("findings of {} rules were clicked: {rules:?}", rules.len()));
    assert!(rules.len() >= if every(3) == 1 { 19 } else { 7 }, "{rules:?}");
}

/// A page with names that mean harm: they are shown as they are, and nothing of them was carried out.
pub(super) fn stays_unharmed(shown: &Shown, names: &[&str]) {
    let steps = [
        whole(),
        eval(
            "[typeof window.harmed, document.querySelectorAll('img').length, document.scripts.length, document.title]",
        ),
        eval("byId('legend').textContent"),
        // Even what is put on the page later is not carried out.
        eval(
            "document.body.insertAdjacentHTML('beforeend', '<img src=x onerror=\"window.harmed = 9\">'); new Promise((done) => setTimeout(() => done(typeof window.harmed), 300))",
        ),
    ];
    let Some(answers) = browse(&shown.page, &steps) else { return };
    assert_eq!(answers.results[1], json!(["undefined", 0, 2, "<script>.gcode - trunnion preview"]));
    let legend = answers.results[2].as_str().unwrap();
    assert!(names.iter().all(|name| legend.contains(name)), "{legend}");
    assert_eq!(answers.results[3], "undefined");
    // The picture that was asked for at the end was refused by the page's own policy, aloud; nothing else was said.
    assert!(
        answers.console.iter().all(|line| line.as_str().unwrap().contains("Content Security Policy")),
        "{:?}",
        answers.console
    );
}

/// The pages of a plan and of the lack of one: each pose and each reason can be looked at.
pub(super) fn shows_poses(folder: &Path, plan: &Path, none: &Path) {
    for page in [plan, none] {
        let steps = [
            eval(STAGE),
            whole(),
            picture(),
            eval(
                "facts.poses.map((_, i) => { document.querySelectorAll('#poses button')[i].click(); return byId('status').textContent; })",
            ),
            whole(),
            picture(),
            json!({"shot": folder.join("poses.png").display().to_string()}),
        ];
        let Some(answers) = browse(page, &steps) else { return };
        answers.quiet();
        for i in [2, 5] {
            assert!(
                coloured(&bytes(&answers.results[i])) > 100,
                "{}: {}",
                page.display(),
                coloured(&bytes(&answers.results[i]))
            );
        }
        let poses = answers.results[3].as_array().unwrap();
        assert!(!poses.is_empty() && poses.iter().all(|text| !text.as_str().unwrap().is_empty()));
    }
}

/// Supports are drawn in their own colour, and are no part.
pub(super) fn shows_supports(page: &Path) {
    let steps = [eval(STAGE), whole(), picture(), eval("byId('summary').textContent")];
    let Some(answers) = browse(page, &steps) else { return };
    answers.quiet();
    let pixels = bytes(&answers.results[2]);
    let blue = pixels.chunks(3).filter(|p| p[2] > 120 && p[2] > p[0].saturating_add(60)).count();
    assert!(blue > 30, "{blue} places are as blue as supports are");
    assert!(answers.results[3].as_str().unwrap().contains("1 part on"), "{}", answers.results[3]);
}

/// Both pages of one are drawn, and where one camera goes the other goes too.
pub(super) fn shows_both(page: &Path, program: bool) {
    let both =
        "const two = () => [...document.querySelectorAll('iframe')].map((frame) => frame.contentWindow.trunnion);";
    let steps = [
        eval(&format!(
            "{both} new Promise((done) => {{ const look = () => two().every((one) => one) ? Promise.all(two().map((one) => one.ready)).then(() => done(2)) : setTimeout(look, 50); look(); }})"
        )),
        eval("two().map((one) => one.facts.kind)"),
        eval(
            "new Promise((done) => setTimeout(() => { two()[0].camera.yaw = 1.25; two()[0].camera.distance = 333; two()[0].invalidate(); setTimeout(() => done(two().map((one) => [one.camera.yaw, one.camera.distance])), 1500); }, 500))",
        ),
        eval(
            "two().map((one) => { const s = document.createElement('canvas'); Object.assign(s, { width: 120, height: 80 }); const c = s.getContext('2d'); \
             c.drawImage(one.canvas(), 0, 0, 120, 80); return [...c.getImageData(0, 0, 120, 80).data].filter((_, i) => i % 4 < 3); })",
        ),
    ];
    let Some(answers) = browse_any(page, &steps) else { return };
    assert_eq!(answers.console, Vec::<Value>::new());
    assert!(answers.requests.iter().all(|one| {
        let address = one.as_str().unwrap();
        address.starts_with("file:///") || address == "about:srcdoc"
    }));
    let kind = if program { "program" } else { "plan" };
    assert_eq!(answers.results[1], json!([kind, kind]));
    assert_eq!(answers.results[2], json!([[1.25, 333], [1.25, 333]]), "the cameras go together");
    for pixels in answers.results[3].as_array().unwrap() {
        assert!(coloured(&bytes(pixels)) > 60, "{} coloured pixels", coloured(&bytes(pixels)));
    }
}

/// The entry of the least clearance goes to its line and shows how long the way is, and what is drawn there is drawn nowhere else.
pub(super) fn draws_the_least_clearance(shown: &Shown) {
    let red = "(() => { const c = byId('canvas'), g = c.getContext('webgl2'), p = new Uint8Array(c.width * c.height * 4); g.readPixels(0, 0, c.width, c.height, g.RGBA, g.UNSIGNED_BYTE, p); \
               let n = 0; for (let i = 0; i < p.length; i += 4) if (p[i] > 150 && p[i + 1] < 80 && p[i + 2] < 80) n += 1; return n; })()";
    let steps = [
        eval(STAGE),
        eval("state.mode = 'feature'; recolour(); byId('clearance').click(); toggle('machine'); 0"),
        whole(),
        eval(
            "[currentLine(), facts.verify.clearance_line, document.querySelector('#labels .near')?.textContent, facts.verify.clearance_mm.toFixed(2)]",
        ),
        eval(red),
        eval("const kept = facts.verify.clearance_at; facts.verify.clearance_at = null; 0"),
        whole(),
        eval(red),
        eval("facts.verify.clearance_at = kept; seek(0); 0"),
        whole(),
        eval("[document.querySelector('#labels .near') === null, nearest()]"),
    ];
    let Some(answers) = browse(&shown.page, &steps) else { return };
    answers.quiet();
    let at = &answers.results[3];
    assert_eq!(at[0], at[1]);
    assert_eq!(at[2], json!(format!("{} mm", at[3].as_str().unwrap())));
    let [with, without] = [4, 7].map(|i| answers.results[i].as_u64().unwrap());
    assert!(with > without, "{with} red pixels with the line, {without} without");
    assert_eq!(answers.results[10], json!([true, null]));
}
