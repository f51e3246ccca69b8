//! The command line: one short module a verb, progress, terminal text.
//!
//! What is done is `job`'s; here are arguments, text and documents. Results go to stdout (one JSON document with `--json`),
//! everything else to stderr.

mod args;
mod batch;
mod failure;
mod inspect;
mod machine;
mod open;
mod operator;
mod orient;
mod pack;
mod plan;
mod prepare;
mod preview;
mod profile;
mod progress;
mod publish;
mod requests;
mod rewrite;
mod send;
mod simulate;
mod slice;
mod split;
mod support;
mod verify;
mod why;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use crate::world::start_threads;
use args::{Args, Verb};
pub(crate) use failure::Failure;
pub(crate) use progress::Console;

/// The command with all its flags: what completions and manual pages are made of.
pub fn command() -> clap::Command {
    Args::command()
}

/// Runs the command and says how it went.
pub fn run() -> ExitCode {
    let words: Vec<_> = std::env::args_os().collect();
    let json = words.iter().any(|word| word == "--json");
    let words = match args::with_project(words).map_err(Failure::Workbench) {
        Ok(words) => words,
        Err(failure) => {
            Console::new(json, false, false, None).failed(&failure);
            progress::error(&failure);
            return ExitCode::from(failure.exit_code());
        }
    };
    let args = match Args::try_parse_from(words) {
        Ok(args) => args,
        Err(mut error) => {
            // Help and version are no mistake; a closed pipe while printing them is none either.
            if error.use_stderr() {
                rewrite::spoil_unparsed(std::env::args_os().skip(1));
            }
            let lost = args::told(&mut error).err().filter(|e| e.kind() != std::io::ErrorKind::BrokenPipe);
            let lost = lost.map(|source| progress::error(&Failure::Stdout { source }));
            return ExitCode::from(if error.use_stderr() || lost.is_some() { 2 } else { 0 });
        }
    };
    start_threads();
    let console = Console::new(args.json, args.quiet, args.verbose, args.max_memory);
    let many = batch::run(&args, &console);
    let done = many.unwrap_or_else(|| match args.verb {
        Verb::Prepare(verb) => prepare::run(&verb, &console),
        Verb::Inspect(verb) => inspect::run(&verb, &console),
        Verb::Explain(verb) => inspect::explain(&verb, &console),
        Verb::Orient(verb) => orient::run(&verb, &console),
        Verb::Split(verb) => split::run(&verb, &console),
        Verb::Support(verb) => support::run(&verb, &console),
        Verb::Pack(verb) => pack::run(&verb, &console),
        Verb::Plan(verb) => plan::run(&verb, &console),
        Verb::Slice(verb) => slice::run(&verb, &console),
        Verb::Rewrite(verb) => rewrite::run(&verb, &console),
        Verb::Verify(verb) => verify::run(&verb, &console),
        Verb::Preview(verb) => preview::run(&verb, &console),
        Verb::Open(verb) => open::run(&verb, &console),
        Verb::Send(verb) => send::run(&verb, &console),
        Verb::Publish(verb) => publish::run(&verb, &console),
        Verb::Simulate(verb) => simulate::run(&verb, &console),
        Verb::Profile(verb) => profile::run(&verb, &console),
        Verb::Machine(verb) => machine::run(&verb, &console),
    });
    done.as_ref().err().into_iter().for_each(|failure| console.failed(failure));
    // What the verb itself says comes first.
    let failures = [done, console.end()].map(Result::err);
    failures.iter().flatten().for_each(progress::error);
    failures.iter().flatten().next().map_or(ExitCode::SUCCESS, |first| ExitCode::from(first.exit_code()))
}
