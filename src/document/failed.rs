//! Why something was not done: the document of it, and the exit code that says which kind it is.

use serde_json::{Value, json};

use crate::job::{Error, MachineError, PrintError, SendError, UploadError};
use crate::location::Location;
use crate::planning::Infeasible;
use crate::slicing::SliceError;
use crate::strategy::StrategyError;
use crate::world::interrupts;

/// Any verb that printed no other document: what stands for the case, one sentence, the exit code, where it is, and what to type next, where
/// the words on the command line are at fault.
pub fn failed(code: &str, text: &str, exit: u8, place: Option<&Location>, help: Option<&str>) -> Value {
    let place = place
        .map(|at| json!({"file": at.file, "line": at.line, "column": at.column, "word": at.word, "part": at.part}));
    json!({"error": text, "exit": exit, "code": code, "place": place, "help": help})
}

/// 1 for an answer that is no, 3 for a slicer, 4 for printer or wire, 130 for an interrupt, 2 for everything that the user gave.
pub fn exit_code(error: &Error) -> u8 {
    match error {
        Error::Print(PrintError::Rejected(_))
        | Error::Strategy(StrategyError::NoWay(_))
        | Error::Send(SendError::Unfit { .. })
        | Error::Machine(MachineError::Calibration(_) | MachineError::NoDryRun { .. } | MachineError::Jog(_)) => 1,
        Error::Upload(UploadError::Server(_))
        | Error::Machine(MachineError::Server(_))
        | Error::Send(SendError::Printer(_) | SendError::Refused { .. }) => 4,
        Error::Printer(error) | Error::Machine(MachineError::Printer(error)) if error.is_of_the_wire() => 4,
        Error::Strategy(StrategyError::Infeasible(why)) => answer_is_no(why),
        Error::Strategy(StrategyError::NoPlan(no)) => answer_is_no(&no.infeasible),
        Error::Print(PrintError::Slice(SliceError::Interrupted)) => interrupts::EXIT_CODE,
        Error::Print(PrintError::Slice(error)) if error.is_slicer_failure() => 3,
        _ => 2,
    }
}

/// 1 where a plan was looked for and there is none, 2 where planning could not begin.
fn answer_is_no(why: &Infeasible) -> u8 {
    match why {
        Infeasible::NoPlan { .. }
        | Infeasible::NoPlace { .. }
        | Infeasible::Falls { .. }
        | Infeasible::Budget { .. } => 1,
        _ => 2,
    }
}
