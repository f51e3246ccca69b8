//! Flags of `machine`.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Subcommand};

use super::MachineArgs;

#[derive(Subcommand)]
pub(in crate::cli) enum Machine {
    /// Move each axis by 5 mm or 10 degrees, ask what you saw, and correct the profile's letters and directions
    Jog(Jog),
}

#[derive(ClapArgs)]
#[command(after_help = "\
Nothing is heated. Home the machine, level and clear the table, and raise the head before you begin; keep a hand on the switch.
Each question is answered by its number.")]
pub(in crate::cli) struct Jog {
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,
    /// A serial device, or tcp:host:port
    #[arg(long, value_name = "PATH")]
    pub(in crate::cli) port: String,
    /// Baud rate [default: the profile's]
    #[arg(long)]
    pub(in crate::cli) baud: Option<u32>,
    /// Output profile, which extends the given one [default: its keys on stdout]
    #[arg(short, long)]
    pub(in crate::cli) output: Option<PathBuf>,
}
