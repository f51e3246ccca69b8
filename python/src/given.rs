//! What Python gives, as plain values: each that is none of its kind is refused by name, with what was given.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBool, PyDict};
use trunnion::job::{MachineSource, ModelSource, Source};
use trunnion::mesh::{Repair, Unit};

use crate::trouble::Trouble;

/// A file's name and, where it is in hand, its content. A path need not be text.
pub(crate) type Named = (OsString, Option<PyBackedBytes>);

/// A file, or what would be in one.
pub(crate) fn source((name, bytes): Named) -> Source {
    match bytes {
        Some(bytes) => Source::Bytes { name: name.to_string_lossy().into_owned(), bytes: bytes.to_vec() },
        None => Source::File(PathBuf::from(name)),
    }
}

/// A machine's profile: a word as on the command line, or TOML in hand that goes by that word.
pub(crate) fn machine((word, toml): Named) -> MachineSource {
    match toml {
        Some(_) => MachineSource::Toml(source((word, toml))),
        None => match word.to_str() {
            Some(word) => MachineSource::from(word),
            // No shipped name is: a path.
            None => MachineSource::Toml(Source::File(PathBuf::from(word))),
        },
    }
}

/// Keyword arguments; one that is not there, or is `None`, is left to the command's own default.
pub(crate) struct Given<'py>(pub(crate) Bound<'py, PyDict>);

impl<'py> Given<'py> {
    pub(crate) fn py(&self) -> Python<'py> {
        self.0.py()
    }

    /// As it is.
    pub(crate) fn any(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        Ok(self.0.get_item(name)?.filter(|value| !value.is_none()))
    }

    /// What `read` makes of it.
    pub(crate) fn of<T>(
        &self,
        name: &str,
        what: &str,
        read: impl Fn(&Bound<'py, PyAny>) -> Option<T>,
    ) -> PyResult<Option<T>> {
        let Some(value) = self.any(name)? else { return Ok(None) };
        let refused = || {
            let shown = value.repr().map_or_else(|_| "it".to_owned(), |text| text.to_string());
            Trouble::input(format!("{name} {shown:.60} is not {what}")).raised(value.py())
        };
        // `True` is a number to Python, and never meant as one.
        let is_flag = value.is_instance_of::<PyBool>() && ![FLAG, REPAIR].contains(&what);
        if is_flag { Err(refused()) } else { read(&value).map(Some).ok_or_else(refused) }
    }

    pub(crate) fn number(&self, name: &str) -> PyResult<Option<f64>> {
        self.of(name, "a finite number", |value| value.extract().ok().filter(|v: &f64| v.is_finite()))
    }

    pub(crate) fn count(&self, name: &str) -> PyResult<Option<usize>> {
        self.of(name, "a whole number of at least 0", |value| value.extract().ok())
    }

    pub(crate) fn flag(&self, name: &str) -> PyResult<bool> {
        Ok(self.of(name, FLAG, |value| value.extract().ok())?.unwrap_or(false))
    }

    pub(crate) fn text(&self, name: &str) -> PyResult<Option<String>> {
        self.of(name, "a string", |value| value.extract().ok())
    }

    /// A string that no message repeats.
    pub(crate) fn secret(&self, name: &str) -> PyResult<Option<String>> {
        let refused = || Trouble::input(format!("{name} is not a string")).raised(self.py());
        self.any(name)?.map(|value| value.extract().map_err(|_| refused())).transpose()
    }

    /// What makes a time of a number of seconds.
    pub(crate) fn seconds<'a>(&'a self, name: &'a str) -> impl FnOnce(f64) -> PyResult<Duration> + 'a {
        move |seconds| {
            let refused = |_| {
                Trouble::input(format!("{name} must be a number of seconds of at least 0, got {seconds}"))
                    .raised(self.py())
            };
            Duration::try_from_secs_f64(seconds).map_err(refused)
        }
    }

    pub(crate) fn texts(&self, name: &str) -> PyResult<Option<Vec<String>>> {
        self.of(name, "a list of strings", |value| value.extract().ok())
    }

    pub(crate) fn path(&self, name: &str) -> PyResult<Option<PathBuf>> {
        self.of(name, "a path", |value| value.extract().ok())
    }

    pub(crate) fn paths(&self, name: &str) -> PyResult<Vec<PathBuf>> {
        Ok(self.of(name, "a list of paths", |value| value.extract().ok())?.unwrap_or_default())
    }

    /// One of `words` by its place in them.
    pub(crate) fn word(&self, name: &str, words: &[&str]) -> PyResult<usize> {
        let what = format!("one of {}", words.join(", "));
        let place = |value: &Bound<'_, PyAny>| {
            let text: String = value.extract().ok()?;
            words.iter().position(|word| *word == text)
        };
        Ok(self.of(name, &what, place)?.unwrap_or(0))
    }

    pub(crate) fn vector<const N: usize>(&self, name: &str) -> PyResult<Option<[f64; N]>> {
        self.of(name, &format!("{N} finite numbers"), |value| numbers(value)?.try_into().ok())
    }

    pub(crate) fn named(&self, name: &str) -> PyResult<Option<Named>> {
        self.of(name, "a name with its content", |value| value.extract().ok())
    }

    /// The model, with how to read it.
    pub(crate) fn model(&self, model: Named) -> PyResult<ModelSource> {
        let unit = self.text("unit")?.map(|text| text.parse::<Unit>()).transpose();
        let unit = unit.map_err(|error| Trouble::input(error.to_string()).raised(self.py()))?;
        let how = |value: &Bound<'_, PyAny>| match value.extract::<bool>() {
            Ok(mends) => Some(if mends { Repair::Auto } else { Repair::Off }),
            Err(_) => Repair::named(&value.extract::<String>().ok()?),
        };
        let repair = self.of("repair", REPAIR, how)?.unwrap_or_default();
        Ok(ModelSource { unit, repair, ..ModelSource::from(source(model)) })
    }
}

/// Finite numbers, whatever holds them.
pub(crate) fn numbers(value: &Bound<'_, PyAny>) -> Option<Vec<f64>> {
    let all: Vec<f64> = value.try_iter().ok()?.map(|v| v.ok()?.extract().ok()).collect::<Option<_>>()?;
    Some(all).filter(|all| all.iter().all(|v| v.is_finite()))
}

const FLAG: &str = "True or False";
const REPAIR: &str = "True, False, 'auto', 'strict' or 'off'";
