//! One run of the command under `strace`, which can make any of its calls to the system fail, or the last that it lives to make.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::support::{error_in, every};

/// Calls that meet the disk, a port, a server, a thread or another process.
const CALLS: &str = "openat,read,write,writev,lseek,fsync,fdatasync,rename,renameat,renameat2,unlink,unlinkat,mkdir,fchmod,ftruncate,\
                     flock,getdents64,ioctl,ppoll,socket,connect,sendto,recvfrom,clone3,execve,pipe2,wait4";

/// What becomes of one call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    /// It fails like this.
    Error(&'static str),
    /// The process is killed in it.
    Kill,
}

/// A call by its name, which one of this name in its thread, and what becomes of it.
#[derive(Clone, Debug)]
pub(crate) struct Injected {
    pub(crate) call: String,
    pub(crate) number: usize,
    pub(crate) fault: Fault,
}

/// How a run has ended.
#[derive(Debug)]
pub(crate) struct Ended {
    /// `None` where it was killed.
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Ended {
    /// The lines of stdout as JSON, or all of it as one.
    pub(crate) fn documents(&self) -> Vec<Value> {
        let whole = serde_json::from_str(&self.out).map(|one| vec![one]);
        whole.unwrap_or_else(|_| self.out.lines().filter_map(|line| serde_json::from_str(line).ok()).collect())
    }

    /// Whether it says why it has failed: as a document with a code and this very exit code, or where stdout itself is lost on stderr.
    pub(crate) fn says_why(&self) -> bool {
        let last = self.documents().pop().unwrap_or_default();
        let document = last["code"].is_string() && last["exit"] == Value::from(self.code);
        document || self.err.lines().any(|line| error_in(line).is_some())
    }
}

/// The command of `words` in `folder`, with `tmp` there as its temporary folder; the trace is `trace` there.
pub(crate) fn run(folder: &Path, words: &[&str], strace: &[String]) -> Ended {
    let mut run = Command::new("strace");
    run.current_dir(folder).args(["-f", "-qq", "-o"]).arg(folder.join("trace")).args(strace).stdin(Stdio::null());
    run.arg(env!("CARGO_BIN_EXE_trunnion")).args(words).env_remove("TRUNNION_MACHINE").env_remove("TRUNNION_KEY");
    let done = run.env("RAYON_NUM_THREADS", "1").env("TMPDIR", folder.join("tmp")).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Ended { code: done.status.code(), out: text(&done.stdout), err: text(&done.stderr) }
}

/// A run in which nothing fails.
pub(crate) fn unharmed(folder: &Path, words: &[&str]) -> Ended {
    run(folder, words, &["-etrace=none".to_owned()])
}

/// The same with a call that does: in every thread and process the one of this number.
pub(crate) fn harmed(folder: &Path, words: &[&str], Injected { call, number, fault }: &Injected) -> Ended {
    let what = match fault {
        Fault::Error(error) => format!("error={error}"),
        Fault::Kill => "signal=KILL".to_owned(),
    };
    run(folder, words, &[format!("-etrace={call}"), format!("-einject={call}:{what}:when={number}")])
}

/// What can befall a run of `words`: each of its calls but those of the loader, with each fault. In a suite of each name the first, and every `step`th
/// behind it: how often a printer is asked depends on time, and would else decide which calls fail.
pub(crate) fn faults(folder: &Path, words: &[&str], exit: i32, step: usize) -> Vec<Injected> {
    let clean = run(folder, words, &[format!("-etrace={CALLS}"), "-y".to_owned()]);
    assert_eq!(clean.code, Some(exit), "{clean:?}");
    let calls = numbered(&std::fs::read_to_string(folder.join("trace")).unwrap());
    assert!(calls.len() > 20, "{calls:?}");
    let mut all = Vec::new();
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    for (call, number) in calls {
        let place = seen.entry(call.clone()).or_default();
        *place += 1;
        if !(*place - 1).is_multiple_of(every(step)) {
            continue;
        }
        let errors: &[&str] = match call.as_str() {
            "clone3" => &["EAGAIN"],
            "openat" | "pipe2" | "socket" => &["EMFILE"],
            "write" | "writev" | "fsync" | "fdatasync" | "ftruncate" => &["EIO", "ENOSPC"],
            _ => &["EIO"],
        };
        let each = errors.iter().map(|error| Fault::Error(error)).chain([Fault::Kill]);
        all.extend(each.map(|fault| Injected { call: call.clone(), number, fault }));
    }
    all
}

/// The calls of a trace, each with its number among those of its name in its thread; without what the loader and the start of a Rust
/// program do, in which nothing of ours has begun.
fn numbered(trace: &str) -> BTreeSet<(String, usize)> {
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    let (mut all, mut not_ours) = (BTreeSet::new(), BTreeSet::new());
    for line in trace.lines() {
        let Some((thread, rest)) = line.split_once(' ') else { continue };
        let Some((name, rest)) = rest.trim_start().split_once('(') else { continue };
        if !name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_') {
            continue;
        }
        let count = counts.entry((thread, name)).or_default();
        *count += 1;
        let of_the_loader = [".so", "/proc/", "/sys/", "/etc/"].iter().any(|part| rest.contains(part));
        let call = (name.to_owned(), *count);
        // The first of a process is the process itself.
        let ours = !of_the_loader && call != ("execve".to_owned(), 1);
        if ours {
            all.insert(call)
        } else {
            not_ours.insert(call)
        };
    }
    &all - &not_ours
}

#[test]
fn calls_are_counted_by_thread_and_name() {
    let trace = "7 execve(\"/bin/x\", [\"x\"]) = 0\n7 openat(AT_FDCWD</a>, \"/lib/libc.so.6\", 0) = 3\n7 read(3</lib/libc.so.6>, \"\\177ELF(\", 8) = 8\n\
                 7 openat(AT_FDCWD</a>, \"cube.stl\", 0 <unfinished ...>\n8 write(4</a/b>, \"x\", 1) = 1\n7 <... openat resumed>) = 3\n\
                 8 write(4</a/b>, \"y\", 1) = 1\n7 write(2, \"z\", 1) = 1\n7 +++ exited with 0 +++\n";
    let calls: Vec<(String, usize)> = numbered(trace).into_iter().collect();
    assert_eq!(calls, [("openat".to_owned(), 2), ("write".to_owned(), 1), ("write".to_owned(), 2)]);
}
