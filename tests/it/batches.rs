//! Many models: a document each, whatever becomes of the others and of the batch itself.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};

use serde_json::Value;
use trunnion::fixtures::solid_box;
use trunnion::geom::Vec3;
use trunnion::mesh::stl_binary;

use crate::pipeline::fixture;
use crate::split::solids::block;
use crate::support::{Command, Numbers, folder, installed, note, root, said, skip, trunnion, wait_for};

/// A data set, scaled down: so many models, every 33rd of them broken in one of the ways that files are.
const MODELS: usize = 240;

fn is_broken(i: usize) -> bool {
    i % 33 == 20
}

/// The models, in folders by tens; the names of those that are broken.
fn data_set(at: &Path) -> BTreeSet<PathBuf> {
    let mut numbers = Numbers::seeded(18);
    let mut broken = BTreeSet::new();
    for i in 0..MODELS {
        let folder = at.join(format!("{:02}", i / 10));
        std::fs::create_dir_all(&folder).unwrap();
        let side = |numbers: &mut Numbers| numbers.between(5.0, 60.0);
        let size = Vec3::new(side(&mut numbers), side(&mut numbers), side(&mut numbers));
        let whole = stl_binary(&solid_box(Vec3::zeros(), size));
        let path = folder.join(format!("part {i:03}.stl"));
        let bytes = match (is_broken(i), i % 4) {
            (false, _) => whole,
            // Torn off, empty, a page that was downloaded instead, numbers that are none.
            (true, 0) => whole[..whole.len() - 30].to_vec(),
            (true, 1) => Vec::new(),
            (true, 2) => b"<!DOCTYPE html><html>404</html>".to_vec(),
            (true, _) => [&whole[..96], &f32::NAN.to_le_bytes(), &whole[100..]].concat(),
        };
        if is_broken(i) {
            broken.insert(path.clone());
        }
        std::fs::write(path, bytes).unwrap();
    }
    // What is no model is none of them.
    std::fs::write(at.join("README.md"), "about").unwrap();
    broken
}

const ORIENT: [&str; 4] = ["--objective", "height", "--method", "grid"];

fn orient(models: &Path, into: &Path) -> Command {
    let mut command = trunnion();
    command.arg("orient").arg(models).args(ORIENT).args(["--json", "-o"]).arg(into).stdin(Stdio::null());
    command
}

/// The lines of a batch: those of its models, and the last.
fn lines(run: &Output) -> (Vec<Value>, Value) {
    let text = String::from_utf8(run.stdout.clone()).unwrap();
    let mut all: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let last = all.pop().unwrap();
    (all, last)
}

fn count(of: &Value, key: &str) -> usize {
    usize::try_from(of[key].as_u64().unwrap()).unwrap()
}

/// The documents below `into`, by name.
fn documents(into: &Path) -> BTreeMap<String, PathBuf> {
    let mut found = BTreeMap::new();
    for folder in std::fs::read_dir(into).into_iter().flatten().map(|f| f.unwrap().path()) {
        for file in std::fs::read_dir(folder).into_iter().flatten().map(|f| f.unwrap()) {
            let name = file.file_name().into_string().unwrap();
            if name.ends_with(".json") && !name.contains(".plan.") && !name.starts_with('.') {
                found.insert(name, file.path());
            }
        }
    }
    found
}

/// The folders in `/proc` of the processes that `parent` has begun and that have not ended.
fn children(parent: u32) -> Vec<PathBuf> {
    let all = std::fs::read_dir("/proc").into_iter().flatten().map(|entry| entry.unwrap().path());
    all.filter(|path| state_and_parent(path).is_some_and(|[_, of]| of == parent.to_string())).collect()
}

/// Of a process's folder in `/proc`; `None` where it has ended, whoever still has to fetch it.
fn state_and_parent(process: &Path) -> Option<[String; 2]> {
    let stat = std::fs::read_to_string(process.join("stat")).ok()?;
    // Behind the name, which may hold anything.
    let mut fields = stat.rsplit(')').next()?.split_whitespace().map(str::to_owned);
    let found = [fields.next()?, fields.next()?];
    (found[0] != "Z").then_some(found)
}

/// Without what changes from run to run.
fn timeless(mut document: Value) -> Value {
    for part in document["parts"].as_array_mut().into_iter().flatten() {
        part["results"].as_array_mut().into_iter().flatten().for_each(|result| result["seconds"] = Value::Null);
    }
    document
}

#[test]
fn a_batch_that_is_killed_goes_on_where_it_was_and_lists_what_fails() {
    let folder = folder();
    let (models, into) = (folder.path().join("models"), folder.path().join("out"));
    let broken = data_set(&models);
    let whole = MODELS - broken.len();
    let mut first = orient(&models, &into).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_for("the first 90 documents", || {
        assert!(first.try_wait().unwrap().is_none(), "it ended before");
        documents(&into).len() >= 90
    });
    // Stopped first, so that it begins no other while its children are counted.
    assert!(Command::new("kill").args(["-STOP", &first.id().to_string()]).status().unwrap().success());
    let children = children(first.id());
    first.kill().unwrap();
    first.wait().unwrap();
    // Those that were under way end by themselves, and nobody reads them.
    wait_for("the end of its children", || children.iter().all(|child| state_and_parent(child).is_none()));
    let there = documents(&into);
    assert!(there.len() < whole, "it was not killed in the midst");
    for path in there.values() {
        let text = std::fs::read(path).unwrap();
        assert!(serde_json::from_slice::<Value>(&text).is_ok(), "{} is half a document", path.display());
    }
    let second = orient(&models, &into).output().unwrap();
    assert_eq!(second.status.code(), Some(1), "{}", said(&second));
    let (told, last) = lines(&second);
    assert_eq!((told.len(), count(&last, "failed")), (MODELS, broken.len()));
    assert_eq!(count(&last, "done") + count(&last, "skipped"), whole);
    assert_eq!(count(&last, "skipped"), there.len(), "what was done is not done again");
    assert_eq!(documents(&into).len(), whole);
    let failed = told.iter().filter(|line| line["status"] == "failed");
    let failed: BTreeSet<PathBuf> = failed.map(|line| PathBuf::from(line["model"].as_str().unwrap())).collect();
    assert_eq!(failed, broken);
    let listed = String::from_utf8_lossy(&second.stderr).into_owned();
    for path in &broken {
        let line = listed.lines().find(|line| line.contains(path.to_str().unwrap())).unwrap();
        assert!(line.len() > path.to_str().unwrap().len() + 20, "a sentence: {line}");
    }
    as_alone(&told, &into);
    again(&models, &into, &broken);
    shares(&models, &into);
}

/// The documents are those of the same words for one model.
fn as_alone(told: &[Value], into: &Path) {
    // And so are the codes of those that have none.
    for line in told.iter().filter(|line| line["status"] == "failed").step_by(20) {
        let model = line["model"].as_str().unwrap();
        let alone = trunnion().args(["orient", model]).args(ORIENT).arg("--json").output().unwrap();
        let alone: Value = serde_json::from_slice(&alone.stdout).unwrap();
        assert!(line["code"].is_string() && line["code"] == alone["code"], "{model}: {line} {alone}");
    }
    for line in told.iter().filter(|line| line["status"] != "failed").step_by(60) {
        let model = line["model"].as_str().unwrap();
        let alone = trunnion().args(["orient", model]).args(ORIENT).arg("--json").output().unwrap();
        let alone: Value = serde_json::from_slice(&alone.stdout).unwrap();
        let there = std::fs::read(into.join(line["document"].as_str().unwrap())).unwrap();
        assert_eq!(timeless(serde_json::from_slice(&there).unwrap()), timeless(alone), "{model}");
    }
}

/// Once more: nothing is done; with other words or another profile all are.
fn again(models: &Path, into: &Path, broken: &BTreeSet<PathBuf>) {
    let (told, last) = lines(&orient(models, into).output().unwrap());
    assert_eq!((count(&last, "done"), count(&last, "skipped")), (0, MODELS - broken.len()));
    assert!(told.iter().filter(|line| line["status"] == "failed").all(|line| line["before"] == true));
    let (told, _) = lines(&orient(models, into).args(["--retry", "--jobs", "1"]).output().unwrap());
    assert!(told.iter().filter(|line| line["status"] == "failed").all(|line| line["before"] == false));
    let few = ["--share", "0/60"];
    let (_, other) = lines(&orient(models, into).args(few).args(["--overhang", "50"]).output().unwrap());
    assert_eq!(count(&other, "done"), 4);
    let profile = into.parent().unwrap().join("mine.toml");
    for height in ["0.2", "0.25"] {
        let text =
            format!("extends = \"generic-ac\"\n[machine]\nname = \"mine\"\n[process]\nlayer_height_mm = {height}\n");
        std::fs::write(&profile, text).unwrap();
        let run = orient(models, into).args(few).arg("-m").arg(&profile).output().unwrap();
        assert_eq!(count(&lines(&run).1, "done"), 4, "the profile has changed: {}", said(&run));
    }
}

fn shares(models: &Path, into: &Path) {
    let mut seen = BTreeSet::new();
    for share in ["0/3", "1/3", "2/3"] {
        let (told, _) = lines(&orient(models, into).args(["--share", share]).output().unwrap());
        assert!(told.iter().all(|line| seen.insert(line["model"].to_string())), "twice in {share}");
    }
    assert_eq!(seen.len(), MODELS);
}

#[test]
fn a_list_is_prepared_and_what_has_no_plan_is_told_with_its_reasons() {
    let folder = folder();
    let (list, into) = (folder.path().join("models.txt"), folder.path().join("out"));
    let hanging = block(16.0, 16.0, 30.0).and(&block(60.0, 16.0, 8.0).at(0.0, 0.0, 22.0));
    let overhanging = folder.path().join("hanging.stl");
    std::fs::write(&overhanging, stl_binary(&hanging.mesh())).unwrap();
    let text = format!(
        "# two and one\n{}\n{}\n\n{}\n",
        fixture("cube"),
        overhanging.display(),
        folder.path().join("gone.stl").display()
    );
    std::fs::write(&list, text).unwrap();
    let run = |verb: &str, more: &[&str]| {
        let mut command = trunnion();
        command.arg(verb).arg(&list).args(["-m", "generic-ac", "--json", "-o"]).arg(&into).args(more);
        command.output().unwrap()
    };
    let planned = run("plan", &[]);
    let (told, last) = lines(&planned);
    assert_eq!(
        (planned.status.code(), count(&last, "done"), count(&last, "failed")),
        (Some(1), 1, 2),
        "{}",
        said(&planned)
    );
    let of = |name: &str| told.iter().find(|line| line["model"].as_str().unwrap().ends_with(name)).unwrap();
    assert_eq!((&of("hanging.stl")["exit"], &of("gone.stl")["key"]), (&1.into(), &Value::Null));
    assert!(of("gone.stl")["exit"] == 2 && of("gone.stl")["code"] == "input/absent", "{told:?}");
    let code = of("hanging.stl")["code"].as_str().unwrap().to_owned();
    let key = of("hanging.stl")["key"].as_str().unwrap();
    let kept = std::fs::read_to_string(into.join(&key[..2]).join(format!("{key}.failed"))).unwrap();
    assert!(kept.starts_with(&format!("1 {code}\n")) && kept.contains("\"reasons\""), "{kept}");
    // A second run knows them from the first.
    let (again, _) = lines(&run("plan", &[]));
    let again = again.iter().find(|line| line["model"].as_str().unwrap().ends_with("hanging.stl")).unwrap();
    assert!(again["before"] == true && again["code"] == code.as_str(), "{again}");
    let prepared = run("prepare", &["--slicer", "builtin", "--way", "as-drawn"]);
    let (told, last) = lines(&prepared);
    assert_eq!((count(&last, "done"), count(&last, "failed")), (1, 2), "{}", said(&prepared));
    let done = told.iter().find(|line| line["status"] == "done").unwrap();
    let document = into.join(done["document"].as_str().unwrap());
    let (gcode, plan) = (document.with_extension("gcode"), document.with_extension("plan.json"));
    let verified = trunnion().arg("verify").arg(&gcode).arg("--plan").arg(&plan).output().unwrap();
    assert!(verified.status.success(), "{}", said(&verified));
}

#[test]
fn batches_that_cannot_be_are_sentences() {
    let folder = folder();
    let (empty, out) = (folder.path().join("empty"), folder.path().join("out"));
    std::fs::create_dir(&empty).unwrap();
    let fails = |words: &[&str], wanted: &str| {
        let mut command = trunnion();
        let words = words.iter().map(|word| if *word == "OUT" { out.as_os_str() } else { word.as_ref() });
        let run = command.arg("orient").args(words).output().unwrap();
        assert!(run.status.code() == Some(2) && said(&run).contains(wanted), "{:?} {}", run.status, said(&run));
    };
    let (cube, empty) = (fixture("cube"), empty.to_str().unwrap());
    fails(&[empty, "-o", "OUT"], "no models found; a model ends in .stl");
    fails(&[empty], "is a folder; give a file name, or -o DIR for the results of all its models");
    fails(&["no/such/list.txt", "-o", "OUT"], "file not found");
    fails(&[&cube, "--jobs", "2"], "--jobs, --share and --retry are for many models");
    fails(&[empty, "-o", "OUT", "--share", "4/4"], "--share 4/4: must be I/N");
    fails(&[empty, "-o", "OUT", "--jobs", "0"], "invalid value '0'");
    fails(&[empty, "-o", "OUT", "--view", "x.svg"], "--view applies to one model");
    let full = folder.path().join("full");
    std::fs::create_dir(&full).unwrap();
    std::fs::copy(&cube, full.join("cube.stl")).unwrap();
    fails(&[full.to_str().unwrap(), "-o", &cube], "cannot be written");
}

/// The script of `docs/how-to/batches.md`, two tasks of it one after the other, and the eye of shellcheck where it is there.
#[test]
fn the_array_script_of_the_docs_does_every_model_once() {
    let text = std::fs::read_to_string(root().join("docs/how-to/batches.md")).unwrap();
    let script = text.split("```bash\n").nth(1).unwrap().split("```").next().unwrap();
    assert!(script.starts_with("#!/bin/bash\n#SBATCH"), "{script}");
    let folder = folder();
    std::fs::write(folder.path().join("array.sh"), script).unwrap();
    if installed("shellcheck") {
        let run = Command::new("shellcheck").arg(folder.path().join("array.sh")).output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
    } else {
        skip("shellcheck is not installed: the script of docs/how-to/batches.md is run, but not looked at");
    }
    let models = folder.path().join("models");
    std::fs::create_dir(&models).unwrap();
    for name in ["cube", "two-boxes", "y-tree"] {
        std::fs::copy(fixture(name), models.join(format!("{name}.stl"))).unwrap();
    }
    let own = Path::new(env!("CARGO_BIN_EXE_trunnion")).parent().unwrap();
    let path = std::env::join_paths(
        std::iter::once(own.to_owned()).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
    );
    let mut told = Vec::new();
    for task in ["0", "1"] {
        let mut bash = Command::new("bash");
        bash.arg("array.sh").current_dir(folder.path()).env("PATH", path.as_ref().unwrap());
        bash.env("SLURM_ARRAY_TASK_ID", task).env("SLURM_ARRAY_TASK_COUNT", "2").env("SLURM_CPUS_PER_TASK", "2");
        let run = bash.output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
        let log = std::fs::read_to_string(folder.path().join(format!("log/{task}.jsonl"))).unwrap();
        told.extend(log.lines().map(|line| serde_json::from_str::<Value>(line).unwrap()));
    }
    let models: BTreeSet<&str> = told.iter().filter_map(|line| line["model"].as_str()).collect();
    assert_eq!((models.len(), documents(&folder.path().join("out")).len()), (3, 3));
    note(&format!("{} lines of two tasks", told.len()));
}
