//! What a package installs beside the command: completions for bash, zsh and fish, and a manual page for each verb.
//!
//! ```sh
//! cargo run --example packages -- target/packages
//! ```
//!
//! Made of the same flags as the command itself, so that they cannot say anything else.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program that says what it wrote")]

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap_complete::{Shell, generate_to};

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("error: give the folder for completions and manual pages, for example target/packages");
        return ExitCode::from(2);
    };
    match write(&folder) {
        Ok(()) => {
            println!("completions and manual pages are in {}", folder.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {}: {error}", folder.display());
            ExitCode::from(2)
        }
    }
}

/// Writes `completions` and `man` below `folder`.
pub(crate) fn write(folder: &Path) -> std::io::Result<()> {
    let (completions, man) = (folder.join("completions"), folder.join("man"));
    for folder in [&completions, &man] {
        std::fs::create_dir_all(folder)?;
    }
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
        generate_to(shell, &mut trunnion::cli::command(), "trunnion", &completions)?;
    }
    clap_mangen::generate_to(trunnion::cli::command(), &man)
}
