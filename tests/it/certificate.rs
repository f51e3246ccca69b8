//! `--certificate`: what was proved of a program, its hashes made anew by other code, and what keeps one from being written. The page of all rules.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use sha2::{Digest, Sha256};
use trunnion::document::certificate;
use trunnion::job::{PrepareRequest, Silent, Verified, World, load_plan, prepare};
use trunnion::slicing::SlicerChoice;
use trunnion::verify::RULES;

use crate::pipeline::{fixture, prepare as prepared};
use crate::support::{fails, folder, is_kept, said, states, trunnion};

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut all, byte| {
        let _ = write!(all, "{byte:02x}");
        all
    })
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// A cube, its program and its plan, in a folder.
fn cube() -> tempfile::TempDir {
    let folder = folder();
    let model = folder.path().join("cube.stl");
    std::fs::copy(fixture("cube"), &model).unwrap();
    let plan = folder.path().join("plan.json");
    let file = folder.path().join("cube.gcode");
    prepared(
        &model.display().to_string(),
        "generic-ac",
        "builtin",
        &file,
        &["--plan-out", &plan.display().to_string()],
    );
    folder
}

fn verify(folder: &Path, gcode: &str, more: &[&str]) -> Output {
    let words = ["verify", gcode, "--plan", "plan.json", "--certificate", "proved.json"];
    trunnion().args(words).args(more).current_dir(folder).output().unwrap()
}

#[test]
fn a_certificate_names_all_that_went_into_the_proof() {
    let folder = cube();
    let at = |name: &str| folder.path().join(name);
    let run = verify(folder.path(), "cube.gcode", &["--json"]);
    assert!(run.status.success(), "{}", said(&run));
    let (report, proved): (Value, Value) = (serde_json::from_slice(&run.stdout).unwrap(), read(&at("proved.json")));
    let program = std::fs::read(at("cube.gcode")).unwrap();
    assert_eq!(proved["program"]["file"], "cube.gcode");
    assert_eq!(proved["program"]["bytes"], program.len());
    assert_eq!(proved["program"]["sha256"], sha256(&program).as_str());
    assert_eq!(proved["model"]["sha256"], sha256(&std::fs::read(fixture("cube")).unwrap()).as_str());
    // The plan's hash is that of the file that was written, and the program's head names it.
    let plan = std::fs::read(at("plan.json")).unwrap();
    assert_eq!(proved["plan"]["document"], serde_json::from_slice::<Value>(&plan).unwrap());
    assert_eq!(proved["plan"]["sha256"], sha256(&plan).as_str());
    assert!(states(&String::from_utf8_lossy(&program), &format!("plan={}", sha256(&plan))));
    let values = serde_json::to_string(&proved["machine"]["values"]).unwrap();
    assert_eq!(proved["machine"]["sha256"], sha256(values.as_bytes()).as_str());
    assert_eq!(proved["machine"]["sha256"], proved["plan"]["document"]["machine"]["sha256"]);
    let shown = trunnion().args(["profile", "show", "generic-ac", "--json"]).output().unwrap();
    assert_eq!(proved["machine"]["values"], serde_json::from_slice::<Value>(&shown.stdout).unwrap());
    assert_eq!(proved["rules_sha256"], sha256(serde_json::to_string(&proved["rules"]).unwrap().as_bytes()).as_str());
    for (figure, value) in proved["figures"].as_object().unwrap() {
        assert_eq!(value, &report[figure], "{figure}");
    }
}

#[test]
fn both_verbs_write_the_same_certificate() {
    let folder = cube();
    let words = ["prepare", "cube.stl", "-m", "generic-ac", "--slicer", "builtin", "-o", "cube.gcode"];
    let more = ["--plan-out", "plan.json", "--certificate", "first.json"];
    let run = trunnion().args(words).args(more).current_dir(folder.path()).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    assert!(verify(folder.path(), "cube.gcode", &[]).status.success());
    let [first, second] = ["first.json", "proved.json"].map(|name| std::fs::read(folder.path().join(name)).unwrap());
    assert!(first == second, "both verbs say the same");
}

/// A certificate of an earlier program does not stay behind a failure, and none is written in the place of an input.
#[test]
fn what_is_not_proved_has_no_certificate() {
    let folder = cube();
    let at = |name: &str| folder.path().join(name);
    let whole = std::fs::read_to_string(at("cube.gcode")).unwrap();
    std::fs::write(at("hot.gcode"), whole.replacen("M104 S210", "M104 S400", 1)).unwrap();
    for (gcode, code) in [("hot.gcode", 1), ("absent.gcode", 2)] {
        assert!(verify(folder.path(), "cube.gcode", &[]).status.success());
        let run = verify(folder.path(), gcode, &[]);
        assert_eq!(run.status.code(), Some(code), "{}", said(&run));
        assert!(!at("proved.json").exists() && at("proved.json.stale").exists(), "{gcode}");
    }
    let words = ["prepare", &fixture("caged"), "-m", "generic-ac", "-o", "caged.gcode", "--certificate", "proved.json"];
    assert!(verify(folder.path(), "cube.gcode", &[]).status.success());
    let mut run = trunnion();
    let run = run.args(words).args(["--split", "never", "--supports", "never"]).current_dir(folder.path());
    assert_eq!(run.output().unwrap().status.code(), Some(1));
    assert!(!at("proved.json").exists());
    for input in ["cube.gcode", "plan.json", "cube.stl"] {
        let words = ["verify", "cube.gcode", "--plan", "plan.json", "--certificate", input];
        let run = trunnion().args(words).current_dir(folder.path()).output().unwrap();
        assert!(fails(&said(&run), "file/twice"), "{}", said(&run));
    }
    // Nothing is known of a plan that cannot be read: whatever is no certificate stays where it is.
    let words = ["verify", "cube.gcode", "--plan", "hot.gcode", "--certificate", "cube.stl"];
    assert_eq!(trunnion().args(words).current_dir(folder.path()).output().unwrap().status.code(), Some(2));
    assert_eq!(std::fs::read_to_string(at("cube.gcode")).unwrap(), whole);
    assert!(at("cube.stl").exists() && at("plan.json").exists());
}

#[test]
fn a_program_is_certified_only_by_the_plan_that_proved_it() {
    let mut request = PrepareRequest::new(fixture("cube").as_str(), "generic-ac");
    request.slicing.slicer = SlicerChoice::BuiltIn;
    let done = prepare(&request, &World::here(&Silent)).unwrap();
    let own = &done.planned.plan;
    assert!(certificate("cube.gcode", &done.gcode, own).is_some());
    let folder = folder();
    let moved = folder.path().join("moved.json");
    let words = ["plan", &fixture("cube"), "-m", "generic-ac", "--origin", "10,0", "-o"];
    assert!(trunnion().args(words).arg(&moved).output().unwrap().status.success());
    let other = load_plan(&moved.as_path().into(), &World::here(&Silent)).unwrap();
    assert!(certificate("cube.gcode", &done.gcode, &other).is_none());
    let unverified = Verified::unverified(done.gcode.program().clone());
    assert!(certificate("cube.gcode", &unverified, own).is_none());
}

/// `docs/reference/rules.md` is made of the rules as they are checked. UPDATE_FIXTURES=1 writes it anew.
#[test]
fn the_page_of_all_rules_is_what_is_checked() {
    let mut page = String::from(
        "# Rules of verification\n\nWhat `verify` checks, and the limits that are the same for every machine. Stops, rates, temperatures and bridges are in\n\
         the machine's profile. [What \"verified\" means](../explanation/verified.md) tells more of each rule.\n\
         A certificate (`--certificate CERT.json`) lists these rules with the hash of the list.\n\n| rule | what must hold | limits |\n|---|---|---|\n",
    );
    for stated in &RULES {
        let limits: Vec<String> =
            stated.limits.iter().map(|limit| format!("`{}` {}", limit.name, limit.value)).collect();
        let _ = writeln!(page, "| `{}` | {} | {} |", stated.rule, stated.holds, limits.join(", "));
    }
    is_kept("docs/reference/rules.md", &page);
    assert!(RULES.windows(2).all(|two| two[0].rule < two[1].rule));
    let schema = read(&crate::support::root().join("docs/schemas/common.json"));
    let known = schema["$defs"]["rule"]["enum"].as_array().unwrap();
    assert!(known.iter().eq(RULES.iter().map(|stated| serde_json::json!(stated.rule)).collect::<Vec<_>>().iter()));
}
