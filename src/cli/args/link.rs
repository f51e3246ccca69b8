//! Flags of `send` and `simulate`.

use std::path::PathBuf;

use clap::Args as ClapArgs;

use super::{MachineArgs, PlanRef};

/// How to stream.
#[derive(ClapArgs)]
pub(in crate::cli) struct StreamArgs {
    /// Resume an interrupted print: from the printer's own line counter, or after a reset from the last layer
    #[arg(long)]
    pub(in crate::cli) resume: bool,
    /// With --resume after a reset: the first line of the file that is to be printed, from a look at the part
    #[arg(long, value_name = "LINE", requires = "resume")]
    pub(in crate::cli) from: Option<u32>,
    /// Do not ask before the machine homes and moves for --resume
    #[arg(long)]
    pub(in crate::cli) yes: bool,
    /// Where the journal is kept [default: OUT.gcode.journal]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) journal: Option<PathBuf>,
    /// Bits a second [default: the profile's]
    #[arg(long)]
    pub(in crate::cli) baud: Option<u32>,
    /// Wait this long for a device that has disappeared, before giving up
    #[arg(long, default_value_t = 600, value_name = "SECONDS")]
    pub(in crate::cli) wait: u64,
    /// Where devices stand under their own names
    #[arg(long, default_value = "/dev/serial/by-id", value_name = "DIR", hide = true)]
    pub(in crate::cli) devices: PathBuf,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Send {
    /// The file to print
    pub(in crate::cli) gcode: PathBuf,
    /// A serial device, or tcp:host:port
    #[arg(long, value_name = "PATH", required_unless_present = "dry_run")]
    pub(in crate::cli) port: Option<String>,
    /// The plan it was made by: the file is verified against it first
    #[arg(long, value_name = "PLAN.json")]
    pub(in crate::cli) plan: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) plan_ref: PlanRef,
    /// Send a file without verifying it (give the profile with -m)
    #[arg(long, conflicts_with = "plan")]
    pub(in crate::cli) unverified: bool,
    /// Rehearse on the simulated printer, without waiting and without a port
    #[arg(long)]
    pub(in crate::cli) dry_run: bool,
    #[command(flatten)]
    pub(in crate::cli) stream: StreamArgs,
}

#[derive(ClapArgs)]
#[command(
    after_help = "The key is taken from --key-file or from the environment's TRUNNION_KEY, never from the command line."
)]
pub(in crate::cli) struct Publish {
    /// The file to print
    pub(in crate::cli) gcode: PathBuf,
    /// The server: octoprint:URL, moonraker:URL or duet:URL, for example `octoprint:http://printer.local`
    #[arg(long, value_name = "SERVER:URL")]
    pub(in crate::cli) to: String,
    /// A file with the server's key (a Duet's password) and nothing else [default: TRUNNION_KEY of the environment]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) key_file: Option<PathBuf>,
    /// The plan it was made by: the file is verified against it first
    #[arg(long, value_name = "PLAN.json")]
    pub(in crate::cli) plan: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) plan_ref: PlanRef,
    /// Publish a file without verifying it
    #[arg(long, conflicts_with = "plan")]
    pub(in crate::cli) unverified: bool,
    /// What it is called there [default: the file's own name]
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) name: Option<String>,
    /// Replace another file of this name there
    #[arg(long)]
    pub(in crate::cli) replace: bool,
    /// Print it, if the server says that its printer stands idle
    #[arg(long)]
    pub(in crate::cli) start: bool,
    /// How long the server may say nothing before it is given up
    #[arg(long, default_value_t = 30, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..=3600))]
    pub(in crate::cli) timeout: u64,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Simulate {
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,
    /// Where to make a link to the pseudo-terminal; or tcp:PORT (this machine only), or tcp:host:port
    #[arg(long, value_name = "PATH")]
    pub(in crate::cli) link: String,
    /// Simulated seconds per second, or max: no waiting at all
    #[arg(long, default_value = "1", value_name = "FACTOR")]
    pub(in crate::cli) speed: String,
    /// Heaters this many times as fast as real ones
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR")]
    pub(in crate::cli) heat: f64,
    /// A fault: NAME@LINE, NAME:PROBABILITY or random:PROBABILITY; may be given several times
    #[arg(long, value_name = "FAULT")]
    pub(in crate::cli) fault: Vec<String>,
    /// Seed of random faults
    #[arg(long, default_value_t = 1)]
    pub(in crate::cli) seed: u64,
    /// advanced-ok, no-ok-after-resend, refuses-doubles, no-emergency-parser, no-busy, repetier-errors, sprinter-errors, smoothie-resends, blank-behind-slash, latches-errors or three-axes
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) quirk: Vec<String>,
    /// Bits a second of the simulated wire [default: no limit]
    #[arg(long)]
    pub(in crate::cli) baud: Option<u32>,
    /// Write every accepted line and the pose after every move
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) log: Option<PathBuf>,
}
