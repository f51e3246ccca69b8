//! A batch at work: a process a model, so many at a time, and a document each the moment it is done.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::Read;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread::Builder;
use std::time::Instant;

use super::error::BatchError;
use crate::input::load_profile;
use crate::job::batch::{
    BatchRequest, BatchResult, Batched, Fate, KeyOf, Models, Said, Share, is_model, kept, listed, read_kept,
};
use crate::slicing::KEY_VARIABLE;
use crate::world::{FileError, Outputs, World, in_words};

/// A document of more bytes is none.
const LARGEST: u64 = 1 << 30;
/// Codes of a model that could not be read, and of one that is not there.
const UNREAD: &str = "file/read";
const ABSENT: &str = "input/absent";
/// Failures of this computer and not of a model's bytes: another day they may be none.
const OF_THE_DAY: [&str; 5] = [UNREAD, ABSENT, "file/write", "file/no-folder", "file/protected"];

/// The models that `path` stands for where one is expected: a folder, or a list, which ends in `.txt`; `None` for a model.
pub fn models_at(path: &Path) -> Option<Models> {
    Models::of(path, path.is_dir())
}

/// Does all models of a batch; `told` hears of each when it is done, `bar` how many are.
///
/// # Errors
///
/// [`FileError::Read`] and [`FileError::Write`] for folder, list and output. What fails of a model is in the result.
pub fn batch(request: &BatchRequest, told: &dyn Fn(&Batched), world: &World<'_>) -> Result<BatchResult, BatchError> {
    let begun = Instant::now();
    let models = models(request)?;
    Outputs::new([]).folder(&request.into)?;
    let machine = request.machine.as_ref().map(|machine| load_profile(machine, world)).transpose()?;
    let mut words = hashed(&request.words)?;
    words.extend(machine.map(|machine| machine.sha256.into_bytes()));
    let worker = Worker { request, words, program: program()?, threads: 0 };
    let jobs = request.jobs.unwrap_or_else(processors).clamp(1, models.len().max(1));
    let worker = &Worker { threads: (processors() / jobs).max(1), ..worker };
    let (next, models) = (&AtomicUsize::new(0), &models);
    let (sender, receiver) = channel();
    let mut result = BatchResult::default();
    std::thread::scope(|scope| {
        let work = |sender: Sender<_>| {
            while let Some((place, model)) = take(next, models) {
                if sender.send((place, worker.one(model))).is_err() {
                    break;
                }
            }
        };
        let begin = |_| {
            let sender = sender.clone();
            Builder::new().spawn_scoped(scope, move || work(sender)).is_ok()
        };
        // Where the system gives no thread, this one does it all and tells of it afterwards.
        match (0..jobs).filter(|job| begin(*job)).count() {
            0 => work(sender),
            _ => drop(sender),
        }
        let bar = world.progress.begin("models", models.len());
        let mut failed = Vec::new();
        for (count, (place, one)) in receiver.iter().enumerate() {
            bar.at(count + 1);
            told(&one);
            match one.fate {
                Fate::Done => result.done += 1,
                Fate::Skipped => result.skipped += 1,
                Fate::Failed { why, .. } => failed.push((place, one.model, why)),
            }
        }
        failed.sort();
        result.failed = failed.into_iter().map(|(_, model, why)| (model, why)).collect();
    });
    result.seconds = begun.elapsed().as_secs_f64();
    Ok(result)
}

fn take<'a>(next: &AtomicUsize, models: &'a [PathBuf]) -> Option<(usize, &'a Path)> {
    let place = next.fetch_add(1, Ordering::Relaxed);
    models.get(place).map(|model| (place, model.as_path()))
}

fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn program() -> Result<PathBuf, BatchError> {
    let failed = |source| FileError::Read { path: PathBuf::from("trunnion"), source };
    Ok(std::env::current_exe().map_err(failed)?)
}

/// The models, in the order of their names or of the list.
fn models(request: &BatchRequest) -> Result<Vec<PathBuf>, BatchError> {
    let all = match &request.models {
        Models::Folder(folder) => {
            let mut found = Vec::new();
            below(folder, &request.into, &mut found)?;
            found
        }
        Models::List(path) => {
            let text = std::fs::read(path).map_err(|source| FileError::Read { path: path.clone(), source })?;
            listed(&String::from_utf8(text).map_err(|_| FileError::NotText { name: path.display().to_string() })?)
        }
    };
    if all.is_empty() {
        let (Models::Folder(path) | Models::List(path)) = &request.models;
        return Err(BatchError::NoModels { path: path.clone() });
    }
    Ok(match request.share {
        Some(share) => share.of_all(all),
        None => Share { from: 0, of: 1 }.of_all(all),
    })
}

/// The models in and below `folder`, by name; links to folders are not followed, nor is `but`.
fn below(folder: &Path, but: &Path, found: &mut Vec<PathBuf>) -> Result<(), BatchError> {
    let failed = |source| FileError::Read { path: folder.to_owned(), source };
    let mut entries = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        entries.push((entry.path(), entry.file_type().map_err(failed)?.is_dir()));
    }
    entries.sort();
    for (path, is_folder) in entries {
        if !is_folder && is_model(&path) {
            found.push(path);
        } else if is_folder && path != but {
            below(&path, but, found)?;
        }
    }
    Ok(())
}

/// The words, and the content of every file that one of them names: a profile that was changed gives other results.
fn hashed(words: &[OsString]) -> Result<Vec<Vec<u8>>, BatchError> {
    let mut pieces = Vec::new();
    for word in words {
        pieces.push(word.as_encoded_bytes().to_vec());
        let value =
            word.to_str().and_then(|word| word.split_once('=')).map_or(word.as_os_str(), |(_, v)| OsStr::new(v));
        if Path::new(value).is_file() {
            let read = std::fs::read(value);
            pieces.push(read.map_err(|source| FileError::Read { path: PathBuf::from(value), source })?);
        }
    }
    Ok(pieces)
}

struct Worker<'a> {
    request: &'a BatchRequest,
    words: Vec<Vec<u8>>,
    program: PathBuf,
    /// A process takes so many threads.
    threads: usize,
}

impl Worker<'_> {
    fn one(&self, model: &Path) -> Batched {
        let begun = Instant::now();
        let (key, fate) = match self.key(model) {
            Ok(key) => {
                let fate = self.fate(model, &key);
                (Some(key), fate)
            }
            Err(source) => (None, failed(Said::unread(&source), Some(2))),
        };
        Batched { model: model.to_owned(), key, fate, seconds: begun.elapsed().as_secs_f64() }
    }

    /// What the model's result is called.
    fn key(&self, model: &Path) -> std::io::Result<String> {
        let mut key = KeyOf::version();
        self.words.iter().for_each(|piece| key.piece(piece));
        key.piece(model.extension().unwrap_or_default().as_encoded_bytes());
        let (mut file, mut buffer) = (File::open(model)?, vec![0; 1 << 20]);
        key.piece(&file.metadata()?.len().to_le_bytes());
        loop {
            match file.read(&mut buffer)? {
                0 => return Ok(key.done()),
                count => key.more(&buffer[..count]),
            }
        }
    }

    fn fate(&self, model: &Path, key: &str) -> Fate {
        // A folder for each first byte: none gets more than some thousand files of a million models.
        let folder = self.request.into.join(&key[..2]);
        let file = |end: &str| folder.join(format!("{key}{end}"));
        if file(".json").is_file() {
            return Fate::Skipped;
        }
        let before = std::fs::read_to_string(file(".failed")).ok().and_then(|text| read_kept(&text));
        if let Some(before) = before.filter(|_| !self.request.retry) {
            return before;
        }
        let ended = std::fs::create_dir_all(&folder).and_then(|()| self.run(model, &file));
        let (status, document, said) = match ended {
            Ok((status, document, said)) => (status, document, Said::of(&said, status, model)),
            Err(source) => return failed(Said::unread(&source), None),
        };
        let (written, fate) = match status.code() {
            Some(0) => (put(&file(".json"), &document), Fate::Done),
            // What the same words would say of the same bytes again.
            Some(exit @ (1 | 2)) if lasts(exit, said.code.as_deref()) => {
                let kept = kept(exit, &said, model, &document);
                (put(&file(".failed"), &kept), failed(said, Some(exit)))
            }
            exit => (Ok(()), failed(said, exit)),
        };
        if fate == Fate::Done {
            let _ = std::fs::remove_file(file(".failed"));
        }
        let not_kept = |error: BatchError| Said { code: Some(error.code().to_owned()), why: error.to_string() };
        written.map_or_else(|error| failed(not_kept(error), None), |()| fate)
    }

    /// The process of one model: how it ended, its document, what it said.
    fn run(&self, model: &Path, file: &dyn Fn(&str) -> PathBuf) -> std::io::Result<(ExitStatus, Vec<u8>, String)> {
        let mut command = Command::new(&self.program);
        command.args(&self.request.words).arg("--json").arg("-q").env_remove(KEY_VARIABLE);
        if self.request.makes_files {
            command.arg("-o").arg(file(".gcode")).arg("--plan-out").arg(file(".plan.json"));
        }
        if std::env::var_os("RAYON_NUM_THREADS").is_none() {
            command.env("RAYON_NUM_THREADS", self.threads.to_string());
        }
        command.arg("--").arg(model).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn()?;
        let heard = heard(&mut child);
        if heard.is_err() {
            // Nobody listens any more: it must not outlive what is told of it.
            let _ = child.kill();
        }
        let (status, (document, said)) = (child.wait()?, heard?);
        Ok((status, document, String::from_utf8_lossy(&said).into_owned()))
    }
}

/// What a process says on stdout and on stderr, both to their ends.
fn heard(child: &mut Child) -> std::io::Result<(Vec<u8>, Vec<u8>)> {
    fn all(from: Option<impl Read>, most: u64) -> std::io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        from.map(|from| from.take(most).read_to_end(&mut bytes)).transpose().map(|_| bytes)
    }
    let (out, err) = (child.stdout.take(), child.stderr.take());
    std::thread::scope(|scope| {
        let said = Builder::new().spawn_scoped(scope, || all(err, 1 << 20))?;
        let document = all(out, LARGEST);
        let said = said.join().unwrap_or_else(|panic| resume_unwind(panic));
        Ok((document?, said?))
    })
}

/// Whether a failure is the model's: it comes again as long as its bytes are the same. Of those of the command itself (words, a stream that
/// is shut) none is.
fn lasts(exit: i32, code: Option<&str>) -> bool {
    code.map_or(exit == 1, |code| !OF_THE_DAY.contains(&code))
}

fn failed(said: Said, exit: Option<i32>) -> Fate {
    Fate::Failed { code: said.code, why: said.why, exit, before: false }
}

impl Said {
    /// The last error that a process told, without the model's name before it, or how it ended.
    fn of(said: &str, status: ExitStatus, model: &Path) -> Self {
        let named = format!("{}: ", model.display());
        let killed =
            || format!("the process of this model ended without a message ({status}); it may have run out of memory");
        match said.lines().rev().find_map(code_and_text) {
            Some((code, text)) => {
                Self { code: code.map(str::to_owned), why: text.strip_prefix(&named).unwrap_or(text).to_owned() }
            }
            None => Self { code: None, why: killed() },
        }
    }

    /// A model, or what is wanted for it, that this computer does not give.
    fn unread(source: &std::io::Error) -> Self {
        let code = if source.kind() == std::io::ErrorKind::NotFound { ABSENT } else { UNREAD };
        Self { code: Some(code.to_owned()), why: in_words(source) }
    }
}

/// What stands behind `error: ` or `error[CODE]: `, and the code.
fn code_and_text(line: &str) -> Option<(Option<&str>, &str)> {
    let rest = line.strip_prefix("error")?;
    let plain = rest.strip_prefix(": ").map(|text| (None, text));
    plain.or_else(|| rest.strip_prefix('[')?.split_once("]: ").map(|(code, text)| (Some(code), text)))
}

fn put(path: &Path, bytes: &[u8]) -> Result<(), BatchError> {
    Ok(Outputs::new([]).claim(path)?.write(bytes)?)
}

#[cfg(test)]
mod tests {
    use super::lasts;

    #[test]
    fn only_what_a_models_bytes_bring_about_is_kept() {
        for (exit, code) in
            [(2, Some("mesh/truncated")), (1, Some("plan/no-plan")), (1, None), (2, Some("file/not-text"))]
        {
            assert!(lasts(exit, code), "{exit} {code:?}");
        }
        for code in [Some("file/read"), Some("file/write"), Some("input/absent"), None] {
            assert!(!lasts(2, code), "{code:?}");
        }
    }
}
