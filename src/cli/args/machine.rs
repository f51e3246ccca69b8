//! Flags of `machine`.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Subcommand};

use super::{MachineArgs, Made};
use crate::publish::Fingerprint;

#[derive(Subcommand)]
pub(in crate::cli) enum Machine {
    /// Create a profile from what the firmware says of itself, with answers for what it does not
    Read(Read),
    /// Move each axis by 5 mm or 10 degrees, ask what you saw, and correct the profile's letters and directions
    Jog(Jog),
}

#[derive(ClapArgs)]
#[command(after_help = "\
Nothing is moved, heated or changed. What the machine said is kept beside the profile, as NAME.answers.txt:
trunnion profile import reads it again. Marlin, RepRapFirmware and grblHAL answer at a port, Klipper through Moonraker.")]
pub(in crate::cli) struct Read {
    #[command(flatten)]
    pub(in crate::cli) place: Place,
    #[command(flatten)]
    pub(in crate::cli) made: Made,
}

#[derive(ClapArgs)]
#[command(after_help = "\
Nothing is heated. Home the machine, level and clear the table, and raise the head before you begin; keep a hand on the power switch.
Each question is answered by its number. Klipper is moved through Moonraker, others at a port.")]
pub(in crate::cli) struct Jog {
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,
    #[command(flatten)]
    pub(in crate::cli) place: Place,
    /// Output profile, which extends the given one [default: its keys on stdout]
    #[arg(short, long)]
    pub(in crate::cli) output: Option<PathBuf>,
}

/// Where the machine is: either --port or --host.
#[derive(ClapArgs)]
pub(in crate::cli) struct Place {
    /// A serial device, or tcp:host:port
    #[arg(long, value_name = "PATH", required_unless_present = "host", conflicts_with = "host")]
    pub(in crate::cli) port: Option<String>,
    /// moonraker:URL or duet:URL
    #[arg(long, value_name = "SERVER")]
    pub(in crate::cli) host: Option<String>,
    /// Baud rate of the port [default: the profile's, else 115200]
    #[arg(long, requires = "port")]
    pub(in crate::cli) baud: Option<u32>,
    /// File with the server's API key, or a Duet's password [default: $TRUNNION_KEY]
    #[arg(long, value_name = "FILE", requires = "host")]
    pub(in crate::cli) key_file: Option<PathBuf>,
    /// Trust only the certificate with this SHA-256 fingerprint (https)
    #[arg(long, value_name = "SHA256", requires = "host")]
    pub(in crate::cli) fingerprint: Option<Fingerprint>,
    /// Time to wait for a server that does not answer
    #[arg(long, default_value_t = 30, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..=3600))]
    pub(in crate::cli) timeout: u64,
}
