//! Many models by one verb: what counts as one, what its result is called, what is said of it.
//!
//! A result is called by the SHA-256 of all that it comes from, so that a batch that was ended anywhere goes on where it was: the
//! model's bytes and ending, the verb and its words, the files that these name, and this version. Each model is done by a process of
//! its own, as if it had been asked for alone; whatever that needs or does, even its end, touches no other.

mod error;
mod runs;

use std::path::{Path, PathBuf};

use crate::input::{BadSetting, MachineSource};
pub use error::BatchError;
pub use runs::{batch, models_at};

use sha2::{Digest, Sha256};

/// Endings of files that are read as models.
const MODELS: [&str; 4] = ["stl", "obj", "3mf", "off"];

/// The models of a batch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Models {
    /// All in a folder and below it.
    Folder(PathBuf),
    /// One a line of a text file, seen from where we are; empty lines and those that begin with `#` are none.
    List(PathBuf),
}

impl Models {
    /// What `path` stands for where a model is expected; `None` for a model.
    pub(super) fn of(path: &Path, is_folder: bool) -> Option<Self> {
        if is_folder {
            return Some(Self::Folder(path.to_owned()));
        }
        let list = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("txt"));
        list.then(|| Self::List(path.to_owned()))
    }
}

/// Whether a file's name is that of a model.
pub(super) fn is_model(path: &Path) -> bool {
    let end = path.extension().map(|end| end.to_string_lossy().to_ascii_lowercase());
    end.is_some_and(|end| MODELS.contains(&end.as_str()))
}

/// The models that the lines of a list name.
pub(super) fn listed(text: &str) -> Vec<PathBuf> {
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.map(PathBuf::from).collect()
}

/// A share of the models: every `of`-th from `from` on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// From 0.
    pub from: usize,
    /// At least one more.
    pub of: usize,
}

impl Share {
    /// `I/N`.
    ///
    /// # Errors
    ///
    /// [`InputError::Setting`](crate::input::InputError::Setting) for what is no share.
    pub fn parse(text: &str) -> Result<Self, BatchError> {
        let two = text.split_once('/').and_then(|(from, of)| Some((from.parse().ok()?, of.parse().ok()?)));
        match two {
            Some((from, of)) if from < of => Ok(Self { from, of }),
            _ => {
                let wanted = "must be I/N with I from 0 to N-1, for example 0/4".to_owned();
                Err(BadSetting::Words { name: "share", text: text.to_owned(), wanted }.into())
            }
        }
    }

    /// Those of `all` that belong to it.
    pub(super) fn of_all(self, all: Vec<PathBuf>) -> Vec<PathBuf> {
        all.into_iter().skip(self.from).step_by(self.of).collect()
    }
}

/// A hash over pieces that cannot run into each other.
pub(super) struct KeyOf(Sha256);

impl KeyOf {
    /// Of this version.
    pub(super) fn version() -> Self {
        let mut key = Self(Sha256::new());
        key.piece(env!("CARGO_PKG_VERSION").as_bytes());
        key
    }

    pub(super) fn piece(&mut self, bytes: &[u8]) {
        self.0.update((bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
    }

    /// More of what was begun with a piece that says its length.
    pub(super) fn more(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// The first 128 bits, in hexadecimal digits.
    pub(super) fn done(self) -> String {
        self.0.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect()
    }
}

/// A batch.
#[derive(Clone, Debug)]
pub struct BatchRequest {
    /// The models.
    pub models: Models,
    /// The machine that the words name: with whatever its file extends it is part of what a result is called by.
    pub machine: Option<MachineSource>,
    /// Which of them.
    pub share: Option<Share>,
    /// The command's words for one model: the verb and its flags, without model, output and `--json`.
    pub words: Vec<std::ffi::OsString>,
    /// Whether a file for the machine is made, which stands beside its document.
    pub makes_files: bool,
    /// Where documents go.
    pub into: PathBuf,
    /// So many at a time; `None`: one a processor.
    pub jobs: Option<usize>,
    /// Whether what has failed before is done again.
    pub retry: bool,
}

/// What became of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Batched {
    /// The model.
    pub model: PathBuf,
    /// What its result is called; `None` where the model cannot be read.
    pub key: Option<String>,
    /// What became of it.
    pub fate: Fate,
    /// What that took, s.
    pub seconds: f64,
}

/// What became of a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Its document was written.
    Done,
    /// Its document was there.
    Skipped,
    /// There is none.
    Failed {
        /// The code of the case; `None` where the process of the model told none.
        code: Option<String>,
        /// In a sentence.
        why: String,
        /// The process's exit code; `None` where it was ended.
        exit: Option<i32>,
        /// Whether that is from an earlier run.
        before: bool,
    },
}

/// The whole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BatchResult {
    /// Documents written.
    pub done: usize,
    /// Documents that were there.
    pub skipped: usize,
    /// Models without one, in the order of the models, each with its sentence.
    pub failed: Vec<(PathBuf, String)>,
    /// What it took, s.
    pub seconds: f64,
}

/// What a process said that failed.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Said {
    code: Option<String>,
    why: String,
}

/// A failure as it is kept: exit code and the case's code, sentence, model, each a line; then what the process said as its document.
fn kept(exit: i32, said: &Said, model: &Path, document: &[u8]) -> Vec<u8> {
    let why = said.why.replace('\n', " ");
    let code = said.code.as_ref().map_or_else(String::new, |code| format!(" {code}"));
    [format!("{exit}{code}\n{why}\n{}\n", model.display()).as_bytes(), document].concat()
}

/// The failure that was kept.
fn read_kept(text: &str) -> Option<Fate> {
    let mut lines = text.lines();
    let mut words = lines.next()?.split(' ');
    let exit = Some(words.next()?.parse().ok()?);
    let code = words.next().map(str::to_owned);
    Some(Fate::Failed { code, why: lines.next()?.to_owned(), exit, before: true })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_disjoint_and_together_all() {
        let all: Vec<PathBuf> = (0..10).map(|i| PathBuf::from(i.to_string())).collect();
        let share = |text| Share::parse(text).unwrap().of_all(all.clone());
        let mut together: Vec<PathBuf> = ["0/3", "1/3", "2/3"].into_iter().flat_map(share).collect();
        together.sort();
        assert_eq!(together, all);
        assert_eq!(share("9/10"), [PathBuf::from("9")]);
        for bad in ["3/3", "1", "a/b", "-1/3", "0/0"] {
            assert!(Share::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn keys_tell_where_one_piece_ends() {
        let key = |pieces: &[&str]| {
            let mut key = KeyOf::version();
            pieces.iter().for_each(|piece| key.piece(piece.as_bytes()));
            key.done()
        };
        assert_ne!(key(&["ab", "c"]), key(&["a", "bc"]));
        assert_eq!((key(&["ab"]).len(), key(&["ab"]) == key(&["ab"])), (32, true));
    }

    #[test]
    fn lists_have_comments() {
        assert_eq!(listed("# all\n a.stl \n\nb c.stl\n"), [PathBuf::from("a.stl"), PathBuf::from("b c.stl")]);
        assert!(is_model(Path::new("x/a.STL")) && !is_model(Path::new("a.json")) && !is_model(Path::new("stl")));
    }
}
