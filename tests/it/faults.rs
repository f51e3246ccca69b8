//! Faults on purpose: each call by which the command reads, writes, syncs, renames or removes a file fails once, or is the last that the
//! process lives to make. `strace` makes them fail, so that nothing in the command knows of it.

mod batch;
pub(crate) mod calls;
#[cfg(unix)]
mod sends;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::pipeline::fixture;
use crate::support::{error_in, every, folder, installed, note, root, skip};

/// Calls that meet the disk.
const CALLS: &str =
    "openat,read,write,fsync,fdatasync,rename,renameat,renameat2,unlink,unlinkat,mkdir,fchmod,ftruncate,flock";

/// One verb in a folder of its own, with temporary files in another.
struct Bench {
    folder: tempfile::TempDir,
    words: Vec<String>,
}

impl Bench {
    fn new(words: &[&str]) -> Self {
        let folder = folder();
        std::fs::create_dir(folder.path().join("tmp")).unwrap();
        std::fs::create_dir(folder.path().join("out")).unwrap();
        std::fs::copy(fixture("cube"), folder.path().join("cube.stl")).unwrap();
        Self { folder, words: words.iter().map(|word| (*word).to_owned()).collect() }
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn left_in(&self, name: &str) -> BTreeMap<String, Vec<u8>> {
        let entries = std::fs::read_dir(self.at(name)).unwrap().map(Result::unwrap);
        let read = |path: &Path| if path.is_file() { std::fs::read(path).unwrap() } else { Vec::new() };
        entries.map(|entry| (entry.file_name().to_string_lossy().into_owned(), read(&entry.path()))).collect()
    }

    /// Runs the verb under `strace` with these words; exit code (`None` where it was killed) and what it said.
    fn run(&self, strace: &[String]) -> (Option<i32>, String) {
        let mut run = Command::new("strace");
        run.current_dir(self.folder.path()).args(["-f", "-qq", "-o"]).arg(self.at("trace")).args(strace);
        run.arg(env!("CARGO_BIN_EXE_trunnion")).args(&self.words);
        run.env("RAYON_NUM_THREADS", "1").env("TMPDIR", self.at("tmp")).env_remove("TRUNNION_KEY");
        let done = run.output().unwrap();
        (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
    }

    /// The calls of the clean run that name something in the folder, or go to what does: each with its number among those of its name.
    fn calls(&self) -> Vec<(String, usize)> {
        let (code, said) = self.run(&[format!("-etrace={CALLS}"), "-y".to_owned()]);
        assert_eq!(code, Some(0), "{said}");
        let text = std::fs::read_to_string(self.at("trace")).unwrap();
        let first = text.split_whitespace().next().unwrap_or_default().to_owned();
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        let mut found = Vec::new();
        let own = self.folder.path().display().to_string();
        // `when` counts for each thread; files are the main thread's.
        for line in text.lines().filter_map(|line| line.strip_prefix(&first)) {
            let Some((name, rest)) = line.trim().split_once('(') else { continue };
            let count = counts.entry(name.to_owned()).or_default();
            *count += 1;
            let rest = rest.replace(&format!("AT_FDCWD<{own}>"), "");
            let ours =
                rest.contains(&own) || ["\"cube.stl", "\"out/", "\"out\""].iter().any(|start| rest.contains(start));
            if ours {
                found.push((name.to_owned(), *count));
            }
        }
        found
    }

    fn clear(&self) {
        for name in ["tmp", "out"] {
            std::fs::remove_dir_all(self.at(name)).unwrap();
            std::fs::create_dir(self.at(name)).unwrap();
        }
    }
}

/// Every call fails in turn, then every call is the last: what is there is whole, what is said is so, and the next run leaves nothing.
fn no_fault_leaves_half(words: &[&str], outputs: &[&str]) {
    if !cfg!(target_os = "linux") || !installed("strace") {
        return skip("no strace to make calls fail with");
    }
    let bench = Bench::new(words);
    let calls = bench.calls();
    let clean = bench.left_in("out");
    assert_eq!(clean.keys().map(String::as_str).collect::<Vec<_>>(), outputs);
    assert!(bench.left_in("tmp").is_empty(), "{:?}", bench.left_in("tmp").keys());
    let (mut refused, mut killed) = (0, 0);
    for (call, number) in calls.iter().step_by(every(4)) {
        for error in ["EIO", "ENOSPC"] {
            bench.clear();
            let (code, said) =
                bench.run(&[format!("-etrace={call}"), format!("-einject={call}:error={error}:when={number}")]);
            let left = bench.left_in("out");
            let what = format!("{call} {number} {error}: {code:?} {said}");
            left.iter()
                .for_each(|(name, bytes)| assert!(clean.get(name) == Some(bytes), "{name} is not whole: {what}"));
            match code {
                Some(0) => assert_eq!(left, clean, "{what}"),
                Some(2 | 3) => assert!(said.lines().any(|line| error_in(line).is_some()), "{what}"),
                _ => panic!("{what}"),
            }
            refused += usize::from(code != Some(0));
        }
        bench.clear();
        let (code, said) =
            bench.run(&[format!("-etrace={call}"), format!("-einject={call}:signal=KILL:when={number}")]);
        let what = format!("killed at {call} {number}: {code:?} {said}");
        assert!(code.is_none_or(|code| code != 0), "{what}");
        for (name, bytes) in bench.left_in("out").iter().filter(|(name, _)| !name.ends_with(".writing")) {
            assert!(clean.get(name) == Some(bytes), "{name} is not whole: {what}");
        }
        killed += 1;
        assert_eq!(bench.run(&["-etrace=none".to_owned()]).0, Some(0), "{what}");
        let (out, tmp) = (bench.left_in("out"), bench.left_in("tmp"));
        // Nothing is in a file that a killed process was about to write, and a plate of an earlier run is put aside.
        let aside = |name: &String| name.strip_suffix(".stale").is_some_and(|of| clean.get(of) == Some(&out[name]));
        let unwritten = |name: &String| name.ends_with(".writing") && out[name].is_empty();
        let nothing = |name: &String| clean.contains_key(name) || unwritten(name) || aside(name);
        assert!(out.keys().all(nothing) && out.len() <= clean.len() + 1, "{what}: {:?}", out.keys());
        assert!(tmp.len() <= 1, "{what}: {:?}", tmp.keys());
    }
    note(&format!(
        "{}: {} calls, {refused} of {} faults refused, {killed} kills",
        words[0],
        calls.len(),
        2 * calls.len()
    ));
    assert!(calls.len() > 8 && refused > 4, "{calls:?}");
}

/// The words that prepare a model, with its plan.
fn prepared(model: &str) -> [&str; 11] {
    ["prepare", model, "-m", "generic-ac", "--slicer", "builtin", "-o", "out/c.gcode", "--plan-out", "out/c.json", "-q"]
}

#[test]
fn no_fault_of_the_disk_leaves_half_of_several_models() {
    no_fault_leaves_half(&prepared("cube.stl*2"), &["c.gcode", "c.json", "c.parts.3mf"]);
}

#[test]
fn no_fault_of_the_disk_leaves_half_a_plate() {
    let words = ["prepare", "cube.stl*2", "-m", "generic-ac", "--slicer", "builtin", "--plates", "out", "-q"];
    no_fault_leaves_half(&words, &["plate-1.3mf", "plate-1.gcode", "plate-1.plan.json"]);
}

#[test]
fn no_fault_of_the_disk_leaves_half_a_prepared_file() {
    no_fault_leaves_half(&prepared("cube.stl"), &["c.gcode", "c.json"]);
    assert!(root().join("fixtures/cube.stl").is_file());
}
