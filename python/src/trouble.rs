//! Why a call was not done, on its way to an exception of Python's (`trunnion/errors.py`).

use pyo3::prelude::*;
use serde_json::Value;
use trunnion::document;
use trunnion::job::{Error, PrintError};
use trunnion::planning::can_be_helped;
use trunnion::strategy::StrategyError;

/// A failure in values that may go from one thread to another.
pub(crate) struct Trouble {
    /// One sentence.
    text: String,
    /// The command's exit code.
    exit: u8,
    /// The document that the command prints for it.
    document: String,
}

impl Trouble {
    /// A failure with a document that says more than its sentence.
    pub(crate) fn with(text: String, exit: u8, document: &Value) -> Self {
        Self { text, exit, document: document.to_string() }
    }

    /// What was given cannot be.
    pub(crate) fn input(text: String) -> Self {
        let document = document::failed("command/usage", &text, 2, None, None);
        Self::with(text, 2, &document)
    }

    /// As an exception; where even that cannot be made, why.
    pub(crate) fn raised(self, py: Python<'_>) -> PyErr {
        let make =
            || py.import("trunnion.errors")?.getattr("from_document")?.call1((self.text, self.exit, self.document));
        make().map_or_else(|error| error, PyErr::from_value)
    }
}

impl<E> From<E> for Trouble
where
    Error: From<E>,
{
    fn from(error: E) -> Self {
        let error = Error::from(error);
        let (text, exit) = (error.to_string(), document::exit_code(&error));
        let document = match &error {
            Error::Strategy(StrategyError::NoPlan(no)) if can_be_helped(&no.infeasible) => document::no_plan(no),
            Error::Strategy(StrategyError::NoWay(no)) => document::no_way(no),
            Error::Print(PrintError::Rejected(no)) => document::rejected(no),
            _ => document::failed(error.code(), &text, exit, error.location().as_ref(), None),
        };
        Self::with(text, exit, &document)
    }
}
