//! Python's door to trunnion: the native half of the package `trunnion`.
//!
//! Each function takes what a verb of the command takes, asks the same job of the library for it and gives back the verb's own
//! `--json` document as text, so that both say the same to the byte. Types, names and documentation for people are the Python
//! half's (`trunnion/*.py`); nothing is decided here.
//!
//! ```text
//! call --given--> request --run: a thread of its own, the interpreter free--> document, bytes
//!                              | told, asks            ^ cancels: Ctrl-C, or a callback that raises
//!                              v                       |
//!                        Python's callback ------------+
//! ```

mod arrays;
mod attended;
mod call;
mod given;
mod preview;
mod printer;
mod profile;
mod run;
mod shape;
mod trouble;
mod verbs;

use pyo3::prelude::*;

/// The native half of the package `trunnion`; its functions are called by the other half alone.
#[pymodule]
mod _trunnion {
    #[pymodule_export]
    use super::arrays::encode;
    #[pymodule_export]
    use super::preview::preview;
    #[pymodule_export]
    use super::printer::{publish, send};
    #[pymodule_export]
    use super::profile::{profile, shipped};
    #[pymodule_export]
    use super::shape::{pack, support};
    #[pymodule_export]
    use super::verbs::{inspect, orient, plan, prepare, split, verify};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
