//! What the modules share: the command, temporary folders, a seeded source of numbers, and words about what was left out.

use std::ffi::OsStr;
use std::io::{Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command as Process, ExitStatus, Output, Stdio};
use std::time::{Duration, Instant};

use trunnion::geom::SplitMix64;

/// Says aloud that a test did not run, and why: a silent pass would count as a proof.
pub(crate) fn skip(why: &str) {
    // Straight to the stream: what is printed is swallowed where the test passes.
    let _ = writeln!(std::io::stderr(), "SKIPPED: {why}");
}

/// Says something aloud that a passing test would otherwise keep to itself.
pub(crate) fn note(what: &str) {
    let _ = writeln!(std::io::stderr(), "NOTE: {what}");
}

/// Where `scripts/soak.sh` runs the tests: the first of its seeds, new each time. The suite's own seeds begin at 0.
pub(crate) fn soak() -> Option<u64> {
    Some(std::env::var("TRUNNION_SOAK").ok()?.parse().expect("TRUNNION_SOAK is a seed"))
}

/// Seeds of a random sweep: a few, always the same, in the suite; `many` others in a soak. `TRUNNION_SEEDS=FROM..TO` repeats some by hand.
pub(crate) fn seeds(few: u64, many: u64) -> std::ops::Range<u64> {
    if let Ok(asked) = std::env::var("TRUNNION_SEEDS") {
        let (from, to) = asked.split_once("..").expect("TRUNNION_SEEDS=FROM..TO");
        return from.parse().unwrap()..to.parse().unwrap();
    }
    soak().map_or(0..few, |from| from..from + many)
}

/// How much of a list is looked at: every `nth` in the suite, all in a soak.
pub(crate) fn every(nth: usize) -> usize {
    if soak().is_some() { 1 } else { nth }
}

/// Only what hangs takes as long: no test is about this time.
pub(crate) const PATIENCE: Duration = Duration::from_secs(1000);

/// Waits until it is there.
#[track_caller]
pub(crate) fn wait_for(what: &str, mut there: impl FnMut() -> bool) {
    let until = Instant::now() + PATIENCE;
    while !there() {
        assert!(Instant::now() < until, "{what} did not come");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Processor time that a running process has used, s: what a busy machine does not change. `None` where the system does not say.
pub(crate) fn processor_s(process: u32) -> Option<f64> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    // User and system time, in ticks of 10 ms.
    Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
}

/// Whether a process has something to do when it is interrupted, and no longer ends at once.
pub(crate) fn catches_interrupts(process: u32) -> bool {
    let text = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let caught = text.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or("0").trim();
    // Bit 1 is SIGINT.
    u64::from_str_radix(caught, 16).unwrap() & 2 != 0
}

/// The repository's own folder.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The built command, ready for arguments.
pub(crate) fn trunnion() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trunnion"));
    command.process.env_remove("TRUNNION_MACHINE");
    command
}

/// A process as the standard library starts it; what our own command prints with `--json` is held against its schema.
#[derive(Debug)]
pub(crate) struct Command {
    process: Process,
    /// Whether somebody else reads what it prints.
    elsewhere: bool,
}

impl Command {
    pub(crate) fn new(program: impl AsRef<OsStr>) -> Self {
        Self { process: Process::new(program), elsewhere: false }
    }

    pub(crate) fn arg(&mut self, word: impl AsRef<OsStr>) -> &mut Self {
        self.process.arg(word);
        self
    }

    pub(crate) fn args<W: AsRef<OsStr>>(&mut self, words: impl IntoIterator<Item = W>) -> &mut Self {
        self.process.args(words);
        self
    }

    pub(crate) fn env(&mut self, name: impl AsRef<OsStr>, value: impl AsRef<OsStr>) -> &mut Self {
        self.process.env(name, value);
        self
    }

    pub(crate) fn env_remove(&mut self, name: impl AsRef<OsStr>) -> &mut Self {
        self.process.env_remove(name);
        self
    }

    pub(crate) fn current_dir(&mut self, folder: impl AsRef<Path>) -> &mut Self {
        self.process.current_dir(folder);
        self
    }

    pub(crate) fn stdin(&mut self, from: impl Into<Stdio>) -> &mut Self {
        self.process.stdin(from);
        self
    }

    pub(crate) fn stdout(&mut self, to: impl Into<Stdio>) -> &mut Self {
        self.elsewhere = true;
        self.process.stdout(to);
        self
    }

    pub(crate) fn stderr(&mut self, to: impl Into<Stdio>) -> &mut Self {
        self.process.stderr(to);
        self
    }

    pub(crate) fn status(&mut self) -> std::io::Result<ExitStatus> {
        self.process.status()
    }

    /// Whoever collects what the process prints hands it to [`Self::heard`].
    pub(crate) fn spawn(&mut self) -> std::io::Result<Child> {
        self.process.spawn()
    }

    #[track_caller]
    pub(crate) fn output(&mut self) -> std::io::Result<Output> {
        let output = self.process.output()?;
        if !self.elsewhere {
            self.heard(&output);
        }
        Ok(output)
    }

    /// Holds what it printed against its schema.
    #[track_caller]
    pub(crate) fn heard(&self, output: &Output) {
        let words: Vec<String> = self.process.get_args().map(|word| word.to_string_lossy().into_owned()).collect();
        let ours = self.process.get_program() == env!("CARGO_BIN_EXE_trunnion");
        if ours && words.iter().any(|word| word == "--json") {
            crate::schemas::heard(&words, output);
        }
    }
}

/// PrusaSlicer, which from 2.9 on asks on its terminal whether a post-processing script may run: it may.
pub(crate) fn prusa_slicer() -> Process {
    let mut yes = tempfile::tempfile().expect("a temporary file");
    yes.write_all(b"y\n").and_then(|()| yes.rewind()).expect("a word in it");
    let mut command = Process::new("prusa-slicer");
    command.stdin(yes);
    command
}

/// Whether a program starts.
pub(crate) fn installed(program: &str) -> bool {
    Process::new(program).arg("--help").output().is_ok()
}

/// The program of this name that PATH leads to first.
pub(crate) fn on_path(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(name)).find(|path| path.is_file())
}

/// A folder that goes when it is dropped.
pub(crate) fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// The first of `names` that starts as a Python 3 and can import `module`.
pub(crate) fn python(names: &[&str], module: &str) -> Option<PathBuf> {
    let code = format!("import sys, {module}; sys.exit(sys.version_info < (3,))");
    let imports =
        |name: &&&str| Process::new(name).args(["-c", &code]).output().is_ok_and(|output| output.status.success());
    names.iter().find(imports).map(PathBuf::from)
}

/// Both streams of a program, for the message of a failing test.
pub(crate) fn said(output: &Output) -> String {
    format!("{}\n{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Whether the page at `path` is `made`, which the sources say it is. UPDATE_FIXTURES=1 writes it anew.
pub(crate) fn is_kept(path: &str, made: &str) {
    let path = root().join(path);
    if std::env::var_os("UPDATE_FIXTURES").is_some() {
        std::fs::write(&path, made).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap();
    let differs = kept.lines().zip(made.lines()).find(|(kept, made)| kept != made);
    assert!(kept == made, "{}: not of these sources: {differs:?}; UPDATE_FIXTURES=1 writes it", path.display());
}

/// Code and sentence of a line `error: ..` or `error[CODE]: ..`.
pub(crate) fn error_in(line: &str) -> Option<(&str, &str)> {
    let rest = line.strip_prefix("error")?;
    let coded = || rest.strip_prefix('[')?.split_once("]: ");
    rest.strip_prefix(": ").map(|text| ("", text)).or_else(coded)
}

/// The first error of a text, as [`error_in`].
pub(crate) fn first_error(text: &str) -> (&str, &str) {
    text.lines().find_map(error_in).unwrap_or_else(|| panic!("no error line: {text}"))
}

/// Whether `text` has `fact`, and not only as a part of a longer word, number or place: `a.ini:2` is not in `a.ini:25`.
fn has(text: &str, fact: &str) -> bool {
    let part = |c: Option<char>, beyond: Option<char>, edge: Option<char>| {
        let digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
        let word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
        word(c) && word(edge) || c == Some('.') && digit(beyond) && digit(edge)
    };
    text.match_indices(fact).any(|(at, _)| {
        let (mut before, mut after) = (text[..at].chars().rev(), text[at + fact.len()..].chars());
        !part(before.next(), before.next(), fact.chars().next())
            && !part(after.next(), after.next(), fact.chars().last())
    })
}

/// Whether one line of `text` has all of `facts`, which ` | ` parts: names, numbers, places. The words around them are free.
pub(crate) fn states(text: &str, facts: &str) -> bool {
    text.lines().any(|line| facts.split(" | ").all(|fact| has(line, fact)))
}

/// Whether `text` has a failure as the command prints it, given as `CODE` or `CODE: FACT | FACT`: its code in front (none before those of the
/// command itself), and all facts in what follows.
pub(crate) fn fails(text: &str, wanted: &str) -> bool {
    let (code, facts) = wanted.split_once(": ").unwrap_or((wanted, ""));
    let mark = if code.starts_with("command/") { "error: ".to_owned() } else { format!("error[{code}]: ") };
    let mut rest = text;
    while let Some(at) = rest.find(&mark) {
        rest = &rest[at + "error[".len()..];
        if facts.split(" | ").all(|fact| has(rest, fact)) {
            return true;
        }
    }
    false
}

/// A failure of the library as the command would print it, for [`fails`].
pub(crate) fn coded(code: &str, error: &impl std::fmt::Display) -> String {
    format!("error[{code}]: {error}")
}

#[test]
fn a_failure_is_its_code_and_its_facts() {
    let text = "note: x\nerror[mesh/open]: a.stl:12: 3 open edges at 1.5 mm\nhelp: --no-repair";
    for wanted in ["mesh/open", "mesh/open: a.stl:12 | 3 | 1.5 mm", "mesh/open: --no-repair | open"] {
        assert!(fails(text, wanted), "{wanted}");
    }
    for other in [
        "mesh/flat",
        "mesh/ope",
        "mesh/open: a.stl:1",
        "mesh/open: 5",
        "mesh/open: 1",
        "mesh/open: 3 | 4",
        "mesh/open: note",
    ] {
        assert!(!fails(text, other), "{other}");
    }
    assert!(states(text, "a.stl:12 | 3") && !states(text, "a.stl:12 | --no-repair") && !states("ab 2.5", "2"));
}

/// Numbers that are the same on every machine, so that a failure can be repeated from its seed.
pub(crate) struct Numbers(SplitMix64);

impl Numbers {
    /// The numbers of `seed`.
    pub(crate) fn seeded(seed: u64) -> Self {
        Self(SplitMix64::seeded(seed))
    }

    /// Evenly from `low` to `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.unit()
    }

    /// Three of them.
    pub(crate) fn triple(&mut self, reach: f64) -> [f64; 3] {
        [(); 3].map(|()| self.between(-reach, reach))
    }
}

/// A file system of `bytes` that goes with its owner; `None` where this user may not mount one.
pub(crate) struct SmallDisk(pub(crate) PathBuf);

impl SmallDisk {
    pub(crate) fn mount(at: PathBuf, bytes: u32) -> Option<Self> {
        std::fs::create_dir(&at).unwrap();
        let size = format!("size={bytes}");
        let done = Process::new("mount").args(["-t", "tmpfs", "-o", &size, "none"]).arg(&at).output();
        done.is_ok_and(|d| d.status.success()).then_some(Self(at))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Process::new("umount").arg(&self.0).status();
    }
}
