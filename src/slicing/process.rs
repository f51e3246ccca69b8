//! Finding and running the user's slicer: the only file of this room that touches processes and files.
//!
//! A run has a folder of its own inside the work folder, which is removed at the end whatever happened, and a process
//! group of its own, which is stopped as a whole when time is up: wrapper scripts start the real slicer as a child.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use super::external::{Program, extrudes, last_lines, not_driven};
use super::{BuiltIn, SliceError, SliceJob, SliceSettings, Slicer, SlicerChoice};
use crate::geom::Slot;
use crate::mesh::TriangleMesh;
use crate::mesh::stl_binary;

/// How the user's slicer is run.
#[derive(Clone, Debug)]
pub struct ExternalOptions {
    /// The user's configurations, in rising order of precedence.
    pub configs: Vec<PathBuf>,
    /// How long one slot may take.
    pub timeout: Duration,
    /// Where each run makes, and removes, a folder of its own.
    pub work_dir: PathBuf,
}

/// How long a program may take to say what it is; a cold start of a large program takes seconds.
const HELP_TIMEOUT: Duration = Duration::from_secs(20);
/// How often a running slicer is looked at.
const POLL: Duration = Duration::from_millis(5);

/// The slicer that the user chose.
///
/// # Errors
///
/// [`SliceError::NotFound`] when it is not installed, [`SliceError::NotDriven`] for Cura and OrcaSlicer,
/// [`SliceError::NotASlicer`] for another program; `Auto` and `BuiltIn` always give one.
pub fn find(choice: &SlicerChoice, options: &ExternalOptions) -> Result<Box<dyn Slicer>, SliceError> {
    if let Some(refusal) = not_driven(choice) {
        return Err(refusal);
    }
    let installed = |program| installed(program, options);
    let missing = |program: Program| SliceError::NotFound {
        slicer: program.name().to_owned(),
        looked_for: program.commands().iter().map(|&c| c.to_owned()).collect(),
    };
    let found = match choice {
        SlicerChoice::Auto => installed(Program::PrusaSlicer).or_else(|| installed(Program::Slic3r)),
        SlicerChoice::PrusaSlicer => {
            Some(installed(Program::PrusaSlicer).ok_or_else(|| missing(Program::PrusaSlicer))?)
        }
        SlicerChoice::Slic3r => Some(installed(Program::Slic3r).ok_or_else(|| missing(Program::Slic3r))?),
        SlicerChoice::Path(path) => Some(identified(path, options)?),
        SlicerChoice::BuiltIn | SlicerChoice::Cura | SlicerChoice::Orca => None,
    };
    Ok(found.map_or_else(|| Box::new(BuiltIn) as Box<dyn Slicer>, |external| Box::new(external)))
}

/// The first command of `program` on PATH that says it is that program.
fn installed(program: Program, options: &ExternalOptions) -> Option<External> {
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    let candidates = program.commands().iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    candidates
        .filter(|path| path.is_file())
        .filter_map(|path| identified(&path, options).ok())
        .find(|external| external.program == program)
}

fn identified(path: &Path, options: &ExternalOptions) -> Result<External, SliceError> {
    let run = Run::new(&options.work_dir)?;
    let mut command = Command::new(path);
    command.arg("--help");
    run.finish(command, path, HELP_TIMEOUT)?;
    let help = run.said();
    let Some((program, version)) = Program::identify(&help) else {
        let text = help.lines().find(|l| !l.trim().is_empty()).unwrap_or_default().trim().to_owned();
        return Err(SliceError::NotASlicer { path: path.to_owned(), text });
    };
    Ok(External { program, path: path.to_owned(), version, options: options.clone() })
}

/// A slicer that is a program of its own.
struct External {
    program: Program,
    path: PathBuf,
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

    fn slice(
        &self,
        mesh: &TriangleMesh<Slot>,
        settings: &SliceSettings,
        job: &SliceJob,
    ) -> Result<Vec<u8>, SliceError> {
        super::job::check_settings(settings)?;
        job.layers(mesh, settings.layer_height_mm)?;
        let run = Run::new(&self.options.work_dir)?;
        let output = run.folder.join("sliced.gcode");
        let command = self.command(&run, mesh, settings, job, &output)?;
        let timed_out = || SliceError::TimedOut {
            slicer: self.name().to_owned(),
            name: job.name.clone(),
            seconds: self.options.timeout.as_secs_f64(),
        };
        let status = run.finish(command, &self.path, self.options.timeout)?.ok_or_else(timed_out)?;
        self.gcode(&output, status, &run, job)
    }
}

impl External {
    fn command(
        &self,
        run: &Run,
        mesh: &TriangleMesh<Slot>,
        settings: &SliceSettings,
        job: &SliceJob,
        output: &Path,
    ) -> Result<Command, SliceError> {
        let texts: Result<Vec<String>, _> = self.options.configs.iter().map(|path| read_text(path)).collect();
        let base = run.write("base.ini", self.program.base(settings).as_bytes())?;
        let forced = run.write("forced.ini", self.program.forced(settings, &texts?, job).as_bytes())?;
        // The program labels the object with the file's name.
        let safe = |c: char| if c.is_alphanumeric() || "_-. ".contains(c) { c } else { '_' };
        let name: String = job.name.chars().map(safe).collect();
        let mesh = run.write(&format!("{name}.stl"), &stl_binary(mesh))?;
        let configs = [base].into_iter().chain(self.options.configs.iter().cloned()).chain([forced]);
        let configs: Vec<PathBuf> = configs.collect();
        let configs: Vec<&Path> = configs.iter().map(PathBuf::as_path).collect();
        let mut command = match one_processor() {
            // Run on several threads PrusaSlicer 2.5 gave other travels once in about sixty runs of the same file.
            Some((taskset, processor)) if self.program == Program::PrusaSlicer => {
                let mut command = Command::new(taskset);
                command.args(["-c", &processor]).arg(&self.path);
                command
            }
            _ => Command::new(&self.path),
        };
        command.args(self.program.arguments(&configs, &mesh, output));
        Ok(command)
    }

    fn gcode(&self, output: &Path, status: ExitStatus, run: &Run, job: &SliceJob) -> Result<Vec<u8>, SliceError> {
        let (slicer, name) = (self.name().to_owned(), job.name.clone());
        let last_lines = || last_lines(&run.said());
        if !status.success() {
            return Err(SliceError::Failed { slicer, name, status: status.to_string(), last_lines: last_lines() });
        }
        let Ok(gcode) = fs::read(output) else {
            return Err(SliceError::NoOutput { slicer, name, found: "no file", last_lines: last_lines() });
        };
        if gcode.is_empty() {
            return Err(SliceError::NoOutput { slicer, name, found: "an empty file", last_lines: last_lines() });
        }
        if extrudes(&gcode) { Ok(gcode) } else { Err(SliceError::NothingExtruded { slicer, name }) }
    }
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
}

impl Drop for Run {
    fn drop(&mut self) {
        // Nothing can be done about a folder that stays; the next run takes another name.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

impl Run {
    fn new(work_dir: &Path) -> Result<Self, SliceError> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let folder = work_dir.join(format!("slicer-run-{}-{number}", std::process::id()));
        fs::create_dir_all(&folder).map_err(|source| file_error("create the folder", &folder, source))?;
        // Relative paths would mean something else to a program that changes its folder.
        let folder = folder.canonicalize().map_err(|source| file_error("find the folder", &folder, source))?;
        Ok(Self { folder })
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<PathBuf, SliceError> {
        let path = self.folder.join(name);
        fs::write(&path, bytes).map_err(|source| file_error("write", &path, source))?;
        Ok(path)
    }

    fn create(&self, name: &str) -> Result<File, SliceError> {
        let path = self.folder.join(name);
        File::create(&path).map_err(|source| file_error("create", &path, source))
    }

    /// Runs `command` to its end; `None` when time is up, and then it and its children have been stopped.
    fn finish(&self, mut command: Command, path: &Path, timeout: Duration) -> Result<Option<ExitStatus>, SliceError> {
        // Files, not pipes: a program that writes much cannot block, and a child left behind cannot hold us.
        command.stdin(Stdio::null()).stdout(self.create("stdout")?).stderr(self.create("stderr")?);
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(|source| file_error("start", path, source))?;
        let started = Instant::now();
        loop {
            if let Some(status) = child.try_wait().map_err(|source| file_error("wait for", path, source))? {
                return Ok(Some(status));
            }
            if started.elapsed() >= timeout {
                stop(&mut child);
                return Ok(None);
            }
            thread::sleep(POLL);
        }
    }

    /// What the program wrote to stdout, then to stderr.
    fn said(&self) -> String {
        let text = |name: &str| read_text(&self.folder.join(name)).unwrap_or_default();
        format!("{}\n{}", text("stdout"), text("stderr"))
    }
}

/// Stops the child and, where the system has process groups, everything it started.
fn stop(child: &mut Child) {
    #[cfg(unix)]
    let _ = Command::new("kill").args(["-KILL", "--", &format!("-{}", child.id())]).stderr(Stdio::null()).status();
    let _ = child.kill();
    let _ = child.wait();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slicing::testing::{block, extrusion_box, extrusions, layer_heights};

    #[test]
    fn lists_of_processors_are_read() {
        assert_eq!(processors("\t0-2,7\n"), [0, 1, 2, 7]);
        assert_eq!(processors("5"), [5]);
        assert!(processors("").is_empty());
    }

    fn options(folder: &Path) -> ExternalOptions {
        ExternalOptions { configs: Vec::new(), timeout: Duration::from_secs(120), work_dir: folder.to_owned() }
    }

    fn job() -> SliceJob {
        SliceJob { name: "slot01__box".into(), on_table: false, bed_mm: [300.0, 300.0] }
    }

    fn cube() -> TriangleMesh<Slot> {
        block([140.0, 140.0, 0.0], [160.0, 160.0, 20.0])
    }

    /// The installed program, or `None` and a word about it.
    fn real(choice: &SlicerChoice, options: &ExternalOptions) -> Option<Box<dyn Slicer>> {
        match find(choice, options) {
            Ok(slicer) => Some(slicer),
            Err(SliceError::NotFound { .. }) => {
                println!("SKIPPED: {choice} is not installed");
                None
            }
            Err(error) => panic!("{error}"),
        }
    }

    /// Checks the box, the layers and the neutral first layer of a sliced 20 mm cube.
    fn assert_true_to_the_cube(gcode: &[u8], width: f64, layer_um: i64) {
        let lines = extrusions(gcode);
        let (half, top) = (width / 2.0, (20_000 / layer_um * layer_um) as f64 / 1000.0);
        let got = extrusion_box(&lines);
        let low = layer_um as f64 / 1000.0;
        let wanted = [140.0 + half, 140.0 + half, low, 160.0 - half, 160.0 - half, top];
        assert!(got.iter().zip(wanted).all(|(a, b)| (a - b).abs() <= 0.01), "{got:?}, wanted {wanted:?}");
        let heights = layer_heights(&lines);
        assert_eq!(heights, (1..=20_000 / layer_um).map(|k| k * layer_um).collect::<Vec<_>>());
        let longest_wall = |layer: usize| {
            let on_layer = lines.iter().filter(|l| (l.to[2] * 1000.0).round() as i64 == heights[layer]);
            let outer = on_layer.filter(|l| l.from[1] == l.to[1] && (l.to[1] - got[1]).abs() < 0.001);
            let line = outer.max_by(|a, b| a.length().total_cmp(&b.length())).unwrap();
            (line.e / line.length(), line.feed)
        };
        let (first, second) = (longest_wall(0), longest_wall(1));
        assert!((first.0 / second.0 - 1.0).abs() < 0.001 && first.1 == second.1, "{first:?} {second:?}");
    }

    fn assert_without_start_code(gcode: &[u8]) {
        let text = String::from_utf8_lossy(gcode);
        assert!(!text.lines().any(|l| ["M109", "M190", "M104 S0", "M140 S0"].iter().any(|w| l.starts_with(w))));
        let extrusion = text.lines().position(|l| l.starts_with("G1 X") && l.contains(" E")).unwrap();
        assert!(!text.lines().take(extrusion).any(|l| l.starts_with("M104") || l.starts_with("M140")));
        assert_eq!(crate::slicing::config_values(gcode)["temperature"], "210");
        assert_eq!(crate::slicing::config_values(gcode)["bed_temperature"], "60");
    }

    #[test]
    fn prusaslicer_returns_the_cube_where_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let Some(slicer) = real(&SlicerChoice::PrusaSlicer, &options(folder.path())) else { return };
        let gcode = slicer.slice(&cube(), &SliceSettings::default(), &job()).unwrap();
        assert_true_to_the_cube(&gcode, 0.45, 200);
        assert_without_start_code(&gcode);
        let text = String::from_utf8_lossy(&gcode);
        assert!(text.contains("; printing object slot01__box.stl id:0 copy 0"));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "a run leaves nothing behind");
    }

    #[test]
    fn slic3r_returns_the_cube_where_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let Some(slicer) = real(&SlicerChoice::Slic3r, &options(folder.path())) else { return };
        let gcode = slicer.slice(&cube(), &SliceSettings::default(), &job()).unwrap();
        assert_true_to_the_cube(&gcode, 0.45, 200);
        assert_without_start_code(&gcode);
    }

    #[test]
    fn the_users_configuration_counts_and_cannot_bring_a_first_layer_back() {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("mine.ini");
        let text = "layer_height = 0.25\nextrusion_width = 0.6\nexternal_perimeter_extrusion_width = 0.6\n\
                    first_layer_height = 0.35\nskirts = 3\nstart_gcode = G28\nsupport_material = 1\n";
        fs::write(&config, text).unwrap();
        for choice in [SlicerChoice::PrusaSlicer, SlicerChoice::Slic3r] {
            let options = ExternalOptions { configs: vec![config.clone()], ..options(folder.path()) };
            let Some(slicer) = real(&choice, &options) else { continue };
            let gcode = slicer.slice(&cube(), &SliceSettings::default(), &job()).unwrap();
            assert_true_to_the_cube(&gcode, 0.6, 250);
            assert!(!String::from_utf8_lossy(&gcode).lines().any(|l| l.starts_with("G28")));
        }
    }

    #[test]
    fn on_the_table_only_the_first_layers_speed_differs() {
        let folder = tempfile::tempdir().unwrap();
        let on_table = SliceJob { on_table: true, ..job() };
        for choice in [SlicerChoice::PrusaSlicer, SlicerChoice::Slic3r] {
            let Some(slicer) = real(&choice, &options(folder.path())) else { continue };
            let lines = extrusions(&slicer.slice(&cube(), &SliceSettings::default(), &on_table).unwrap());
            let first: Vec<_> = lines.iter().filter(|l| l.to[2] < 0.3).collect();
            assert!(first.iter().all(|l| l.feed <= 1200.0), "{choice}");
            assert!((extrusion_box(&lines)[0] - 140.225).abs() < 0.01, "{choice}: no brim, no skirt");
        }
    }

    #[test]
    fn auto_always_finds_a_slicer_and_a_stranger_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let slicer = find(&SlicerChoice::Auto, &options(folder.path())).unwrap();
        assert!(!slicer.version().is_empty());
        let stranger = find(&SlicerChoice::Path("/bin/ls".into()), &options(folder.path()));
        assert!(matches!(stranger, Err(SliceError::NotASlicer { .. })));
        let missing = find(&SlicerChoice::Path("/no/such/slicer".into()), &options(folder.path()));
        assert!(matches!(missing, Err(SliceError::File { action: "start", .. })));
    }

    /// A program that calls itself PrusaSlicer and then does `body`; `$out` is the output file.
    #[cfg(unix)]
    fn fake(folder: &Path, body: &str) -> Box<dyn Slicer> {
        use std::os::unix::fs::PermissionsExt;
        let path = folder.join("fake-slicer");
        let script = format!(
            "#!/bin/sh\nif [ \"$1\" = --help ]; then echo 'PrusaSlicer-2.6.1 based on'; exit 0; fi\n\
             while [ \"$1\" != --output ]; do shift; done\nout=\"$2\"\n{body}\n"
        );
        fs::write(&path, script).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        let options = ExternalOptions { timeout: Duration::from_secs(1), ..options(&folder.join("work")) };
        find(&SlicerChoice::Path(path), &options).unwrap()
    }

    #[cfg(unix)]
    fn refused(body: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let slicer = fake(folder.path(), body);
        assert_eq!(slicer.version(), "2.6.1");
        let error = slicer.slice(&cube(), &SliceSettings::default(), &job()).unwrap_err();
        assert!(error.is_slicer_failure(), "{error}");
        assert_eq!(fs::read_dir(folder.path().join("work")).unwrap().count(), 0);
        error.to_string()
    }

    #[cfg(unix)]
    #[test]
    fn a_slicer_that_fails_hangs_or_drops_the_part_is_named() {
        let failed = refused("echo 'half' > \"$out\"; echo 'no layers were detected' >&2; exit 1");
        assert!(failed.contains("exit status: 1") && failed.contains("no layers were detected"), "{failed}");
        assert!(refused("exit 0").contains("wrote no file"));
        assert!(refused(": > \"$out\"").contains("wrote an empty file"));
        assert!(refused("echo 'G1 X1 Y1 F100' > \"$out\"").contains("left `slot01__box` out"));
    }

    #[cfg(unix)]
    #[test]
    fn a_slicer_that_hangs_is_stopped_with_its_children() {
        let started = Instant::now();
        let folder = tempfile::tempdir().unwrap();
        let mark = folder.path().join("alive");
        let text = refused(&format!("(sleep 4; touch {}) & sleep 600", mark.display()));
        assert!(text.contains("stopped after 1.0 s"), "{text}");
        assert!(started.elapsed() < Duration::from_secs(4));
        thread::sleep(Duration::from_secs(5).saturating_sub(started.elapsed()));
        assert!(!mark.exists(), "the child lives on");
    }
}
