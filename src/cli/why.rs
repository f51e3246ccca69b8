//! Why there is no plan, and what would help: as a list for people, or as the document.

use super::{Console, Failure};
use crate::document::{self, text};
use crate::job::{NoPlan, PictureFile};
use crate::planning::{Infeasible, can_be_helped};

/// Prints reasons, the ways that were tried and remedies; what is no answer to the question is left to the error's own sentence.
pub(super) fn explain(no: &NoPlan, picture: Option<&PictureFile>, console: &Console) -> Result<(), Failure> {
    let answered = can_be_helped(&no.infeasible) || matches!(no.infeasible, Infeasible::Falls { .. });
    if !answered {
        return Ok(());
    }
    if let Some((picture, sheet)) = picture.zip(no.sheet()) {
        picture.write(&sheet)?;
    }
    if console.json() {
        console.document(&document::no_plan(no));
    } else {
        console.note(text::no_plan(no).trim_end());
    }
    Ok(())
}
