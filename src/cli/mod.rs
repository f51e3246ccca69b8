//! The command line: one short module a verb, files, progress, terminal text.
//!
//! Together with `slicing/process.rs` and `main.rs` the only place that touches the world. Results go to stdout (one
//! JSON document with `--json`), everything else to stderr.

mod args;
mod failure;
mod files;
mod inspect;
mod journal_file;
mod load;
mod orient;
mod plan;
mod prepare;
mod printer;
mod profile;
mod progress;
mod rewrite;
mod send;
mod simulate;
mod slice;
mod stream;
mod verify;
mod why;

use std::process::ExitCode;

use clap::Parser;

use args::{Args, Verb};
pub(crate) use failure::Failure;
pub(crate) use progress::Console;

/// Runs the command and says how it went.
pub fn run() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(error) => {
            // Help and version are no mistake; a closed pipe while printing them is none either.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    let console = Console::new(args.json, args.quiet, args.verbose);
    let done = match args.verb {
        Verb::Prepare(verb) => prepare::run(&verb, &console),
        Verb::Inspect(verb) => inspect::run(&verb, &console),
        Verb::Orient(verb) => orient::run(&verb, &console),
        Verb::Plan(verb) => plan::run(&verb, &console),
        Verb::Slice(verb) => slice::run(&verb, &console),
        Verb::Rewrite(verb) => rewrite::run(&verb, &console),
        Verb::Verify(verb) => verify::run(&verb, &console),
        Verb::Send(verb) => send::run(&verb, &console),
        Verb::Simulate(verb) => simulate::run(&verb, &console),
        Verb::Profile(verb) => profile::run(&verb, &console),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            console.error(&failure.to_string());
            ExitCode::from(failure.exit_code())
        }
    }
}
