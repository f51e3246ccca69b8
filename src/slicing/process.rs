//! Finding and running the user's slicer: the only part of this room that touches processes and files.
//!
//! A run has a folder of its own inside the work folder, which is removed at the end whatever happened, and a process
//! group of its own, which is stopped as a whole when time is up or somebody interrupts: wrapper scripts start the real
//! slicer as a child. What a program says, and the file it writes, are read within bounds.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::builtin::Configured;
use super::external::{Program, begins_in_nothing, extrudes, last_lines, not_driven, not_taken};
use super::interrupt::Running;
use super::level::below_middles;
use super::said::Said;
use super::{
    Adhesion, BuiltIn, Flaw, Interrupt, Lessened, SliceError, SliceJob, SliceSettings, Sliced, Slicer, SlicerChoice,
    cura,
};
use crate::geom::Slot;
use crate::mesh::TriangleMesh;
use crate::mesh::stl_binary;
use crate::spelling::nearest;

mod launch;
mod places;

use launch::Launch;
use places::{Places, meant};

/// How the user's slicer is run.
#[derive(Clone, Debug)]
pub struct ExternalOptions {
    /// The user's configurations, in rising order of precedence.
    pub configs: Vec<PathBuf>,
    /// How long one slot may take.
    pub timeout: Duration,
    /// Where each run makes, and removes, a folder of its own.
    pub work_dir: PathBuf,
    /// Stops what runs.
    pub interrupt: Interrupt,
}

/// How long a program may take to say what it is; a cold start of a large program takes seconds.
const HELP_TIMEOUT: Duration = Duration::from_secs(20);
/// How often a running slicer is looked at.
const POLL: Duration = Duration::from_millis(5);
/// What a program has said is there this long after its end; a child left behind may hold its streams for ever.
const LAST_WORDS: Duration = Duration::from_millis(200);
/// A program that was killed is gone within this, unless the system itself hangs.
const GONE: Duration = Duration::from_millis(500);
/// The largest sliced file that is read, bytes.
const LARGEST: u64 = 1 << 30;

/// The slicer that the user chose.
///
/// # Errors
///
/// [`SliceError::NotFound`] when it is not installed, [`SliceError::NotDriven`] for OrcaSlicer,
/// [`SliceError::NotASlicer`] for another program, [`SliceError::Silent`] for one that hangs; `Auto` and `BuiltIn`
/// always give one, unless somebody interrupts.
pub fn find(choice: &SlicerChoice, options: &ExternalOptions) -> Result<Box<dyn Slicer>, SliceError> {
    if let Some(refusal) = not_driven(choice) {
        return Err(refusal);
    }
    let limit = HELP_TIMEOUT.min(options.timeout);
    // For all programs together: each that hangs would take its time otherwise.
    let end = end_of(limit);
    let installed = |program| installed(program, options, end);
    let usable = |program| match installed(program) {
        Err(SliceError::Silent { .. }) => Ok(None),
        other => other,
    };
    let missing = |program: Program| SliceError::NotFound {
        slicer: program.name().to_owned(),
        looked_for: program.commands().iter().map(|&c| c.to_owned()).collect(),
    };
    let found = match choice {
        SlicerChoice::Auto => match usable(Program::PRUSA_SLICER)? {
            None => usable(Program::SLIC3R)?,
            found => found,
        },
        SlicerChoice::PrusaSlicer => {
            Some(installed(Program::PRUSA_SLICER)?.ok_or_else(|| missing(Program::PRUSA_SLICER))?)
        }
        SlicerChoice::Slic3r => Some(installed(Program::SLIC3R)?.ok_or_else(|| missing(Program::SLIC3R))?),
        SlicerChoice::Path(path) => Some(identified(path, options, end)?),
        SlicerChoice::Cura => Some(installed(Program::CuraEngine)?.ok_or_else(|| missing(Program::CuraEngine))?),
        SlicerChoice::BuiltIn | SlicerChoice::Orca => None,
    };
    match found {
        Some(external) => Ok(Box::new(external)),
        None if options.configs.is_empty() => Ok(Box::new(BuiltIn)),
        None => {
            let texts: Result<Vec<String>, SliceError> = options.configs.iter().map(|path| read_text(path)).collect();
            Ok(Box::new(Configured::new(&texts?)?))
        }
    }
}

/// The variable of the environment with the key of a server: no slicer gets it, and of our own processes none but one that uploads.
pub const KEY_VARIABLE: &str = "TRUNNION_KEY";

/// The first file on PATH, and where installers put it, that says it is `program`.
fn installed(program: Program, options: &ExternalOptions, end: Instant) -> Result<Option<External>, SliceError> {
    for path in Places::here().of(program) {
        match identified(&path, options, end) {
            Ok(external) if external.program == program => return Ok(Some(external)),
            Err(error @ (SliceError::Interrupted | SliceError::Silent { .. })) => return Err(error),
            _ => {}
        }
    }
    Ok(None)
}

fn identified(path: &Path, options: &ExternalOptions, end: Instant) -> Result<External, SliceError> {
    let path = &meant(path);
    let seconds = HELP_TIMEOUT.min(options.timeout).as_secs_f64();
    let mut launch = Launch::of(path);
    loop {
        let mut run = Run::new(options)?;
        let mut command = launch.command(path, &run.folder);
        command.arg("--help");
        let ended = run.finish(command, path, end, &|| None).map_err(|error| unknown(path).unwrap_or(error))?;
        ended.ok_or_else(|| SliceError::Silent { path: path.to_owned(), seconds })?;
        let help = run.said();
        if let Some((program, version)) = Program::identify(&help) {
            return Ok(External { program, path: path.to_owned(), launch, version, options: options.clone() });
        }
        let Some(other) = launch.other(path, &help) else {
            let text = help.lines().find(|l| !l.trim().is_empty()).unwrap_or_default().trim().to_owned();
            return Err(SliceError::NotASlicer { path: path.to_owned(), text });
        };
        launch = other;
    }
}

/// What to say of a word that is neither a slicer's name nor a program.
fn unknown(path: &Path) -> Option<SliceError> {
    let given = path.to_str().filter(|word| !word.contains(std::path::MAIN_SEPARATOR))?;
    if std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()).any(|folder| folder.join(given).is_file()) {
        return None;
    }
    let known = SlicerChoice::NAMED.map(|choice| choice.to_string());
    let (_, nearest) = nearest(given, known.iter().map(String::as_str))?;
    Some(SliceError::UnknownSlicer { given: given.to_owned(), nearest: nearest.to_owned(), known: known.join(", ") })
}

/// A slicer that is a program of its own.
struct External {
    program: Program,
    path: PathBuf,
    launch: Launch,
    version: String,
    options: ExternalOptions,
}

impl Slicer for External {
    fn name(&self) -> &str {
        self.program.name()
    }

    fn version(&self) -> &str {
        &self.version
    }

    fn around(&self, settings: &SliceSettings) -> Result<SliceSettings, SliceError> {
        if self.program != Program::PRUSA_SLICER {
            return Ok(settings.clone());
        }
        let texts: Result<Vec<String>, _> = self.options.configs.iter().map(|path| read_text(path)).collect();
        Configured::unchecked(&texts?).adhesion(settings)
    }

    fn flaws(&self) -> Vec<Flaw> {
        // A configuration that cannot be read is refused when it is sliced with.
        let texts: Vec<String> = self.options.configs.iter().filter_map(|path| read_text(path).ok()).collect();
        let not_taken = not_taken(&texts, self.program == Program::PRUSA_SLICER);
        if not_taken.is_empty() { Vec::new() } else { vec![Flaw::Replaced(not_taken)] }
    }

    fn slice(&self, mesh: &TriangleMesh<Slot>, settings: &SliceSettings, job: &SliceJob) -> Result<Sliced, SliceError> {
        settings.check()?;
        job.layers(mesh, settings.layer_height_mm)?;
        if self.program == Program::SLIC3R && job.adhesion.is_some() {
            let mut sliced = self.slice(mesh, settings, &SliceJob { adhesion: Adhesion::default(), ..job.clone() })?;
            sliced.flaws.push(Flaw::Lessened(Lessened::Unmarked { slicer: self.name().to_owned() }));
            return Ok(sliced);
        }
        let mut run = Run::new(&self.options)?;
        let output = run.folder.join("sliced.gcode");
        let texts: Result<Vec<String>, _> = self.options.configs.iter().map(|path| read_text(path)).collect();
        let texts = texts?;
        let command = self.command(&run, mesh, (settings, &texts), job, &output)?;
        let timed_out = || SliceError::TimedOut {
            slicer: self.name().to_owned(),
            name: job.name.clone(),
            seconds: self.options.timeout.as_secs_f64(),
        };
        let end = end_of(self.options.timeout);
        let too_big = || self.too_big(&output, job);
        let status = run.finish(command, &self.path, end, &too_big)?.ok_or_else(timed_out)?;
        match self.gcode(&output, status, &run, job) {
            Err(SliceError::Failed { last_lines, .. }) if begins_in_nothing(&last_lines) => {
                self.instead(mesh, (settings, &texts), job)
            }
            Ok(mut gcode) if self.program == Program::CuraEngine => {
                gcode.extend(cura::block(&cura::values(settings, &texts, job)).bytes());
                Ok(Sliced::from(gcode))
            }
            gcode => gcode.map(Sliced::from),
        }
    }
}

/// The profile's settings, and the texts of the user's configurations above them.
type Set<'a> = (&'a SliceSettings, &'a [String]);

impl External {
    /// What this program refuses since it begins in a point or an edge, from the built-in slicer.
    fn instead(&self, mesh: &TriangleMesh<Slot>, set: Set<'_>, job: &SliceJob) -> Result<Sliced, SliceError> {
        let mut sliced = Configured::new(set.1)?.slice(mesh, set.0, job)?;
        sliced.flaws.push(Flaw::Instead { slicer: self.name().to_owned() });
        Ok(sliced)
    }

    fn command(
        &self,
        run: &Run,
        mesh: &TriangleMesh<Slot>,
        set: Set<'_>,
        job: &SliceJob,
        output: &Path,
    ) -> Result<Command, SliceError> {
        let (settings, texts) = set;
        // The program labels the object with the file's name.
        let safe = |c: char| if c.is_alphanumeric() || "_-. ".contains(c) { c } else { '_' };
        let name: String = job.name.chars().map(safe).collect();
        let mesh = run.write(&format!("{name}.stl"), &stl_binary(&below_middles(mesh)))?;
        let Program::Ini(ini) = self.program else { return self.cura(set, job, &mesh, output) };
        let base = run.write("base.ini", ini.base(settings).as_bytes())?;
        let forced = run.write("forced.ini", ini.forced(settings, texts, job).as_bytes())?;
        let own = if self.launch.sees_only_its_folder() {
            run.copies(&self.options.configs)?
        } else {
            self.options.configs.clone()
        };
        let configs: Vec<PathBuf> = [base].into_iter().chain(own).chain([forced]).collect();
        let configs: Vec<&Path> = configs.iter().map(PathBuf::as_path).collect();
        let plain = self.launch.command(&self.path, &run.folder);
        let mut command = match one_processor() {
            // Run on several threads PrusaSlicer 2.5 gave other travels once in about sixty runs of the same file.
            Some((taskset, processor)) if self.program == Program::PRUSA_SLICER => {
                let mut command = Command::new(taskset);
                command.args(["-c", &processor]).arg(plain.get_program()).args(plain.get_args());
                command.envs(plain.get_envs().filter_map(|(name, value)| Some((name, value?))));
                command
            }
            _ => plain,
        };
        command.args(ini.arguments(&configs, &mesh, output));
        Ok(command)
    }

    /// CuraEngine's own way: settings on the command line over a definition of them all.
    fn cura(&self, set: Set<'_>, job: &SliceJob, mesh: &Path, output: &Path) -> Result<Command, SliceError> {
        let (definition, search) = definitions(&self.path)
            .ok_or_else(|| SliceError::NoDefinitions { program: self.path.clone(), file: cura::DEFINITION })?;
        let mut command = self.launch.command(&self.path, mesh.parent().unwrap_or(mesh));
        command.env(CURA_SEARCH, search);
        command.args(cura::arguments(&cura::values(set.0, set.1, job), &definition, mesh, output));
        Ok(command)
    }

    /// Whether its file is larger than any print's.
    fn too_big(&self, output: &Path, job: &SliceJob) -> Option<SliceError> {
        let bytes = fs::metadata(output).map_or(0, |metadata| metadata.len());
        let (slicer, name) = (self.name().to_owned(), job.name.clone());
        (bytes > LARGEST).then_some(SliceError::TooBig { slicer, name, bytes, allowed: LARGEST })
    }

    fn gcode(&self, output: &Path, status: ExitStatus, run: &Run, job: &SliceJob) -> Result<Vec<u8>, SliceError> {
        let (slicer, name) = (self.name().to_owned(), job.name.clone());
        let last_lines = || last_lines(&run.said());
        if !status.success() {
            return Err(SliceError::Failed { slicer, name, status: status.to_string(), last_lines: last_lines() });
        }
        // A pipe or device in its place would be read for ever.
        let Some(gcode) = output.is_file().then(|| read_sliced(output).ok()).flatten() else {
            return Err(SliceError::NoOutput { slicer, name, found: "no file", last_lines: last_lines() });
        };
        if gcode.is_empty() {
            return Err(SliceError::NoOutput { slicer, name, found: "an empty file", last_lines: last_lines() });
        }
        if extrudes(&gcode) { Ok(gcode) } else { Err(SliceError::NothingExtruded { slicer, name }) }
    }
}

/// Where CuraEngine looks for definitions: folders as in PATH.
const CURA_SEARCH: &str = "CURA_ENGINE_SEARCH_PATH";

/// The definition of all of CuraEngine's settings, and where it is to look for what that one is derived from: the user's own search
/// path, else the resources beside the program.
fn definitions(program: &Path) -> Option<(PathBuf, std::ffi::OsString)> {
    let own = std::env::var_os(CURA_SEARCH).unwrap_or_default();
    let folders = std::env::split_paths(&own).filter(|folder| folder.is_dir());
    let beside = program.canonicalize().ok().and_then(|path| path.parent().map(Path::to_owned));
    let resources = cura::RESOURCES.iter().filter_map(|place| Some(beside.as_ref()?.join(place)));
    let kept = resources.flat_map(|place| [place.join("definitions"), place.join("extruders")]);
    let all: Vec<PathBuf> = folders.chain(kept.filter(|folder| folder.is_dir())).collect();
    let definition = all.iter().map(|folder| folder.join(cura::DEFINITION)).find(|path| path.is_file())?;
    Some((definition, std::env::join_paths(all).ok()?))
}

/// When `limit` from now is over; a limit beyond all clocks is a year.
fn end_of(limit: Duration) -> Instant {
    const YEAR: Duration = Duration::from_secs(365 * 24 * 3600);
    let now = Instant::now();
    now.checked_add(limit).unwrap_or_else(|| now + YEAR)
}

/// `taskset` and one of the processors we may use, another one for each of our threads; `None` where there is no such
/// program, and then a slicer runs as it likes.
fn one_processor() -> Option<(PathBuf, String)> {
    let folders = std::env::var_os("PATH")?;
    let taskset = std::env::split_paths(&folders).map(|folder| folder.join("taskset")).find(|path| path.is_file())?;
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let list = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:"))?;
    let processors = processors(list);
    let thread = rayon::current_thread_index().unwrap_or(0);
    Some((taskset, processors.get(thread % processors.len().max(1))?.to_string()))
}

/// The numbers in a list like `0-3,8`.
fn processors(list: &str) -> Vec<usize> {
    let range = |part: &str| {
        let (low, high) = part.split_once('-').unwrap_or((part, part));
        Some(low.trim().parse::<usize>().ok()?..=high.trim().parse().ok()?)
    };
    list.split(',').filter_map(range).flatten().collect()
}

/// A sliced file, of which a child left behind may write more and more.
fn read_sliced(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    fs::File::open(path)?.take(LARGEST).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn read_text(path: &Path) -> Result<String, SliceError> {
    let bytes = fs::read(path).map_err(|source| file_error("read", path, source))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn file_error(action: &'static str, path: &Path, source: std::io::Error) -> SliceError {
    SliceError::File { action, path: path.to_owned(), source }
}

/// One run's own folder; it goes when the run does.
struct Run {
    folder: PathBuf,
    interrupt: Interrupt,
    streams: Vec<Stream>,
    /// Ends behind the folder.
    _running: Running,
}

impl Drop for Run {
    fn drop(&mut self) {
        // Nothing can be done about a folder that stays; the next run takes another name.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

impl Run {
    fn new(options: &ExternalOptions) -> Result<Self, SliceError> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let interrupt = options.interrupt.clone();
        let running = interrupt.begin().ok_or(SliceError::Interrupted)?;
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let folder = options.work_dir.join(format!("slicer-run-{}-{number}", std::process::id()));
        fs::create_dir_all(&folder).map_err(|source| file_error("create the folder", &folder, source))?;
        // Relative paths would mean something else to a program that changes its folder.
        let folder = folder.canonicalize().map_err(|source| file_error("find the folder", &folder, source))?;
        Ok(Self { folder, interrupt, streams: Vec::new(), _running: running })
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<PathBuf, SliceError> {
        let path = self.folder.join(name);
        fs::write(&path, bytes).map_err(|source| file_error("write", &path, source))?;
        Ok(path)
    }

    /// Copies of these files, for a program that sees no other folder.
    fn copies(&self, paths: &[PathBuf]) -> Result<Vec<PathBuf>, SliceError> {
        let copy = |(k, path): (usize, &PathBuf)| {
            let bytes = fs::read(path).map_err(|source| file_error("read", path, source))?;
            // Its ending says what it is.
            let end = path.extension().map(|end| format!(".{}", end.to_string_lossy())).unwrap_or_default();
            self.write(&format!("own-{k}{end}"), &bytes)
        };
        paths.iter().enumerate().map(copy).collect()
    }

    /// Runs `command` to its end; `None` when time is up, and then it and its children have been stopped, as where
    /// somebody interrupts or `trouble` gives a reason.
    fn finish(
        &mut self,
        mut command: Command,
        path: &Path,
        end: Instant,
        trouble: &dyn Fn() -> Option<SliceError>,
    ) -> Result<Option<ExitStatus>, SliceError> {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).env_remove(KEY_VARIABLE);
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(|source| file_error("start", path, source))?;
        let out = child.stdout.take().map(Stream::listen).transpose();
        let err = child.stderr.take().map(Stream::listen).transpose();
        match (out, err) {
            (Ok(out), Ok(err)) => self.streams.extend(out.into_iter().chain(err)),
            // One that nobody listens to waits for ever.
            (Err(source), _) | (_, Err(source)) => {
                stop(&mut child);
                return Err(file_error("listen to", path, source));
            }
        }
        loop {
            let status = child.try_wait().map_err(|source| file_error("wait for", path, source))?;
            let why = if self.interrupt.is_asked() { Some(SliceError::Interrupted) } else { trouble() };
            if status.is_none() && (why.is_some() || Instant::now() >= end) {
                stop(&mut child);
            }
            match (why, status) {
                (Some(why), _) => return Err(why),
                (None, Some(status)) => return Ok(Some(status)),
                (None, None) if Instant::now() >= end => return Ok(None),
                (None, None) => thread::sleep(POLL),
            }
        }
    }

    /// What the program said on stdout, then on stderr.
    fn said(&self) -> String {
        let end = Instant::now() + LAST_WORDS;
        while Instant::now() < end && !self.streams.iter().all(|stream| stream.thread.is_finished()) {
            thread::sleep(POLL);
        }
        self.streams.iter().map(|stream| stream.said().text()).collect::<Vec<_>>().join("\n")
    }
}

/// A stream of a program, listened to by a thread of its own, so that nobody waits for the other.
struct Stream {
    said: Arc<Mutex<Said>>,
    thread: JoinHandle<()>,
}

impl Stream {
    fn listen(mut from: impl Read + Send + 'static) -> std::io::Result<Self> {
        let said = Arc::new(Mutex::new(Said::default()));
        let into = Arc::clone(&said);
        let thread = thread::Builder::new().spawn(move || {
            let mut bytes = [0; 8192];
            while let Ok(count @ 1..) = from.read(&mut bytes) {
                into.lock().unwrap_or_else(PoisonError::into_inner).push(&bytes[..count]);
            }
        })?;
        Ok(Self { said, thread })
    }

    fn said(&self) -> std::sync::MutexGuard<'_, Said> {
        self.said.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Stops the child and, where the system has process groups, everything it started; asked for nothing, waited for briefly.
fn stop(child: &mut Child) {
    #[cfg(target_os = "linux")]
    descendants(child.id()).into_iter().for_each(|process| {
        let _ = rustix::process::kill_process(process, rustix::process::Signal::KILL);
    });
    #[cfg(unix)]
    let _ = rustix::process::kill_process_group(rustix::process::Pid::from_child(child), rustix::process::Signal::KILL);
    let _ = child.kill();
    let end = Instant::now() + GONE;
    while Instant::now() < end && child.try_wait().is_ok_and(|status| status.is_none()) {
        thread::sleep(POLL);
    }
}

/// All that a process has started and that has been started by those, also in groups and sessions of their own.
#[cfg(target_os = "linux")]
fn descendants(process: u32) -> Vec<rustix::process::Pid> {
    let stat = |entry: fs::DirEntry| {
        let own: i32 = entry.file_name().to_str()?.parse().ok()?;
        let text = fs::read_to_string(entry.path().join("stat")).ok()?;
        // The name, in brackets, may hold anything.
        let parent: i32 = text.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()?;
        Some((own, parent))
    };
    let all: Vec<(i32, i32)> = fs::read_dir("/proc").into_iter().flatten().flatten().filter_map(stat).collect();
    let mut found = vec![process as i32];
    let mut next = 0;
    while let Some(&parent) = found.get(next) {
        found.extend(all.iter().filter(|(_, of)| *of == parent).map(|(own, _)| *own));
        next += 1;
    }
    found.into_iter().skip(1).filter_map(rustix::process::Pid::from_raw).collect()
}

#[cfg(test)]
mod tests;
