//! Flags of `send` and `simulate`.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args as ClapArgs;

use super::{MachineArgs, PRINTING, PlanRef};
use crate::job::{SendOptions, with_suffix};
use crate::publish::Fingerprint;

/// How to stream.
#[derive(ClapArgs)]
pub(in crate::cli) struct StreamArgs {
    /// Resume an interrupted print from its journal
    ///
    /// Continues at the printer's own line counter or position. After a reset, continues at a line that is proved to be on printed
    /// material and reachable without a collision.
    #[arg(help_heading = PRINTING, long)]
    pub(in crate::cli) resume: bool,
    /// With --resume after a reset: the first line to print, found by inspecting the part
    #[arg(help_heading = PRINTING, long, value_name = "LINE", requires = "resume", hide_short_help = true)]
    pub(in crate::cli) from: Option<u32>,
    /// With --resume, home and move without asking, even if the bed has cooled
    #[arg(help_heading = PRINTING, long, hide_short_help = true)]
    pub(in crate::cli) yes: bool,
    /// Journal file [default: OUT.gcode.journal]
    #[arg(help_heading = PRINTING, long, value_name = "FILE", hide_short_help = true)]
    pub(in crate::cli) journal: Option<PathBuf>,
    /// Baud rate [default: the profile's]
    #[arg(help_heading = PRINTING, long, hide_short_help = true)]
    pub(in crate::cli) baud: Option<u32>,
    /// Time to wait for a disconnected device
    #[arg(help_heading = PRINTING, long, default_value_t = 600, value_name = "SECONDS", hide_short_help = true)]
    pub(in crate::cli) wait: u64,
    /// Folder of links to devices by serial number
    #[arg(help_heading = PRINTING, long, default_value = "/dev/serial/by-id", value_name = "DIR", hide = true)]
    pub(in crate::cli) devices: PathBuf,
}

impl StreamArgs {
    pub(in crate::cli) fn options(&self) -> SendOptions {
        let (baud, wait, devices) = (self.baud, Duration::from_secs(self.wait), self.devices.clone());
        SendOptions { baud, wait, devices, holds: self.yes, from: self.from }
    }

    /// Where the journal of the print of `gcode` is kept.
    pub(in crate::cli) fn journal(&self, gcode: &Path) -> PathBuf {
        self.journal.clone().unwrap_or_else(|| with_suffix(gcode, ".journal"))
    }
}

#[derive(ClapArgs)]
#[command(after_help = "\
Rehearse, print, and resume after an interruption:
  trunnion send out.gcode --plan plan.json --dry-run
  trunnion send out.gcode --plan plan.json --port /dev/ttyUSB0
  trunnion send out.gcode --plan plan.json --port /dev/ttyUSB0 --resume

Ctrl-C pauses above the part, twice is an emergency stop.")]
pub(in crate::cli) struct Send {
    /// G-code files to print; give one --port (and one --plan) for each, in the same order
    #[arg(required = true)]
    pub(in crate::cli) gcode: Vec<PathBuf>,
    /// A serial device, or tcp:host:port; one for each file
    #[arg(long, value_name = "PATH", required_unless_present = "dry_run")]
    pub(in crate::cli) port: Vec<String>,
    /// Plan of the G-code file, which is verified against it first; one for each file
    #[arg(long, value_name = "PLAN.json")]
    pub(in crate::cli) plan: Vec<PathBuf>,
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

/// File, port (none for a rehearsal) and plan of one print.
pub(in crate::cli) type OnePrint<'a> = (&'a Path, Option<&'a str>, Option<&'a Path>);

impl Send {
    /// Its prints, or why they do not belong together.
    pub(in crate::cli) fn prints(&self) -> Result<Vec<OnePrint<'_>>, String> {
        let (files, ports, plans) = (self.gcode.len(), self.port.len(), self.plan.len());
        let several = files > 1 || ports > 1 || plans > 1;
        let counted = |n: usize, what: &str| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
        let (given, has) = (counted(files, "file"), if files == 1 { "has" } else { "have" });
        if several && self.dry_run {
            return Err(format!("--dry-run takes one file, got {given} and {}", counted(ports, "--port")));
        }
        if !self.dry_run && ports != files {
            return Err(format!(
                "{given} {has} {}; give one for each file, in the same order",
                counted(ports, "--port")
            ));
        }
        if plans > 0 && plans != files {
            return Err(format!(
                "{given} {has} {}; give one for each file, in the same order",
                counted(plans, "--plan")
            ));
        }
        let one = [("--journal", self.stream.journal.is_some()), ("--from", self.stream.from.is_some())];
        let model = [("--model", self.plan_ref.model.is_some())];
        if let Some((flag, _)) = one.into_iter().chain(model).find(|(_, given)| several && *given) {
            return Err(format!("{flag} applies to one print, got {files}; send that file alone"));
        }
        let each = self.gcode.iter().enumerate();
        let port = |i: usize| self.port.get(i).map(String::as_str).filter(|_| !self.dry_run);
        Ok(each.map(|(i, file)| (file.as_path(), port(i), self.plan.get(i).map(PathBuf::as_path))).collect())
    }
}

#[derive(ClapArgs)]
#[command(after_help = "The key is read from --key-file or TRUNNION_KEY, never from the command line.")]
pub(in crate::cli) struct Publish {
    /// The file to print
    pub(in crate::cli) gcode: PathBuf,
    /// The server: octoprint:URL, moonraker:URL or duet:URL, for example `octoprint:http://printer.local`
    #[arg(long, value_name = "SERVER:URL")]
    pub(in crate::cli) to: String,
    /// A file with the server's key (a Duet's password) and nothing else [default: the environment variable TRUNNION_KEY]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) key_file: Option<PathBuf>,
    /// Plan of the G-code file, which is verified against it first
    #[arg(long, value_name = "PLAN.json")]
    pub(in crate::cli) plan: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) plan_ref: PlanRef,
    /// Publish a file without verifying it
    #[arg(long, conflicts_with = "plan")]
    pub(in crate::cli) unverified: bool,
    /// SHA-256 fingerprint of a self-signed server certificate; no other certificate is accepted
    #[arg(long, value_name = "SHA256")]
    pub(in crate::cli) fingerprint: Option<Fingerprint>,
    /// Name on the server [default: the file's own name]
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) name: Option<String>,
    /// Replace a different file of that name
    #[arg(long)]
    pub(in crate::cli) replace: bool,
    /// Start the print if the server's printer is idle
    #[arg(long)]
    pub(in crate::cli) start: bool,
    /// Time limit for each answer of the server
    #[arg(long, default_value_t = 30, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..=3600))]
    pub(in crate::cli) timeout: u64,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Simulate {
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,
    /// Path of a link to the pseudo-terminal; or tcp:PORT (this computer only), or tcp:host:port
    #[arg(long, value_name = "PATH")]
    pub(in crate::cli) link: String,
    /// Simulated seconds per second, or max: no waiting at all
    #[arg(long, default_value = "1", value_name = "FACTOR")]
    pub(in crate::cli) speed: String,
    /// Speed of the heaters, as a multiple of real ones
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR")]
    pub(in crate::cli) heat: f64,
    /// Inject a fault: NAME@LINE, NAME:PROBABILITY or random:PROBABILITY (0 to 1); may be repeated
    #[arg(long, value_name = "FAULT")]
    pub(in crate::cli) fault: Vec<String>,
    /// Seed of random faults
    #[arg(long, default_value_t = 1)]
    pub(in crate::cli) seed: u64,
    /// Imitate a peculiarity of some printers: advanced-ok, no-ok-after-resend, refuses-doubles, no-emergency-parser, no-busy, repetier-errors, sprinter-errors, smoothie-resends, blank-behind-slash, latches-errors, work-offset, three-axes, marlin-1.0, marlin-1.1, prusa, rrf-2 or fluidnc; may be repeated
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) quirk: Vec<String>,
    /// Baud rate of the simulated wire [default: no limit]
    #[arg(long)]
    pub(in crate::cli) baud: Option<u32>,
    /// Log every accepted line and the pose after every move
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) log: Option<PathBuf>,
}
