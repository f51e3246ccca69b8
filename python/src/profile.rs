//! Machines by name, file or TOML text.

use pyo3::prelude::*;
use serde_json::json;
use trunnion::job::{Error, Silent, World, load_profile};
use trunnion::profile::SHIPPED;

use crate::given::{Named, machine};
use crate::trouble::Trouble;

/// A machine's name, the hash of its values, its `profile show --json` document, and all values as TOML, which carry it to any
/// other computer.
#[pyfunction]
pub(crate) fn profile(py: Python<'_>, named: Named) -> PyResult<(String, String, String, String)> {
    let read = || -> Result<_, Error> {
        let loaded = load_profile(&machine(named), &World::here(&Silent))?;
        let document = serde_json::to_string_pretty(&json!(loaded.profile)).unwrap_or_default();
        let toml = loaded.annotated()?;
        Ok((loaded.name, loaded.sha256, document, toml))
    };
    py.detach(|| read().map_err(Trouble::from)).map_err(|trouble| trouble.raised(py))
}

/// The names of the profiles that come with the package.
#[pyfunction]
pub(crate) fn shipped() -> Vec<String> {
    SHIPPED.iter().map(|(name, ..)| (*name).to_owned()).collect()
}
