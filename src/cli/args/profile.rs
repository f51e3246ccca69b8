//! Flags of `profile`.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Subcommand};

use super::MachineArgs;
use crate::calibrate::{FitOptions, Tip};
use crate::job::{self, Source};

#[derive(Subcommand)]
pub(in crate::cli) enum Profile {
    /// The shipped profiles, and your own in $XDG_CONFIG_HOME/trunnion/profiles
    List,
    /// A profile with all its values, and where each comes from
    Show(ProfileName),
    /// Whether a profile makes sense, and what follows from it
    Check(CheckProfile),
    /// Describe a machine of your own: asks on a terminal, else takes answers from flags and a file
    New(New),
    /// Describe a machine of your own from the configuration of its firmware or simulator, and answers to what that does not say
    Import(Import),
    /// Find pivot, offset and zeros from touches at several poses, or choose the touches to make
    Calibrate(Calibrate),
}

#[derive(ClapArgs)]
pub(in crate::cli) struct CheckProfile {
    #[command(flatten)]
    pub(in crate::cli) of: ProfileName,
    /// Draw table, head and frame from the side
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(in crate::cli) view: Option<PathBuf>,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct New {
    /// Its name, by which it is found from then on
    pub(in crate::cli) name: String,
    /// The profile that it is like
    #[arg(long, default_value = "generic-ac", value_name = "PROFILE")]
    pub(in crate::cli) like: String,
    #[command(flatten)]
    pub(in crate::cli) answers: Answers,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Import {
    /// LinuxCNC's ini, Klipper's printer.cfg, RepRapFirmware's config.g, Marlin's Configuration.h or the machine.json of Koala's simulator; several are one machine's
    #[arg(required = true, value_name = "FILE")]
    pub(in crate::cli) files: Vec<PathBuf>,
    /// Its name, by which it is found from then on [default: as -o, else as the first file]
    #[arg(long)]
    pub(in crate::cli) name: Option<String>,
    /// The profile that it is like [default: a shipped one of the same firmware]
    #[arg(long, value_name = "PROFILE")]
    pub(in crate::cli) like: Option<String>,
    #[command(flatten)]
    pub(in crate::cli) answers: Answers,
}

/// What is told of a machine, and where its profile goes.
#[derive(ClapArgs)]
pub(in crate::cli) struct Answers {
    /// An answer: any key of a profile, as --set kinematics.tilt.max_deg=60, or a measure of the head (docs/machine.md); may be given again and again
    #[arg(long, value_name = "KEY=VALUE", value_parser = pair)]
    pub(in crate::cli) set: Vec<(String, String)>,
    /// A TOML file of answers
    #[arg(long, value_name = "FILE.toml")]
    pub(in crate::cli) answers: Option<PathBuf>,
    /// Whatever is not answered is as in the other profile
    #[arg(long)]
    pub(in crate::cli) keep_rest: bool,
    /// Where to write it [default: NAME.toml in $XDG_CONFIG_HOME/trunnion/profiles]
    #[arg(short, long)]
    pub(in crate::cli) output: Option<PathBuf>,
}

fn pair(word: &str) -> Result<(String, String), &'static str> {
    let (key, value) = word.split_once('=').ok_or("give KEY=VALUE")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

impl Answers {
    /// The same for a job.
    pub(in crate::cli) fn told(&self) -> job::Answers {
        job::Answers { file: self.answers.as_ref().map(Source::from), set: self.set.clone(), rest: self.keep_rest }
    }
}

/// Either TOUCHES or --poses.
#[derive(ClapArgs)]
pub(in crate::cli) struct Calibrate {
    /// Touches as written down; docs/machine.md says how
    #[arg(required_unless_present = "poses")]
    pub(in crate::cli) touches: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,
    /// Where to write a profile that extends the given one [default: its keys on stdout]
    #[arg(short, long, conflicts_with = "poses")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Axes that are elsewhere by more than this, mm on or over the table, are written; a surface that is out of level by more is refused
    #[arg(long, default_value_t = FitOptions::default().tolerance_mm, value_name = "MM", conflicts_with = "poses")]
    pub(in crate::cli) tolerance: f64,
    /// Take the axes as the profile has them, with fewer touches
    #[arg(long)]
    pub(in crate::cli) assume_square: bool,
    /// Choose the touches to make, and write a file to fill in
    #[arg(long, value_name = "FILE.toml", conflicts_with = "touches")]
    pub(in crate::cli) poses: Option<PathBuf>,
    /// With --poses: G-code that goes to each, cold and slowly, and stops there
    #[arg(long, value_name = "FILE.gcode", requires = "poses")]
    pub(in crate::cli) gcode: Option<PathBuf>,
    /// With --poses: how well one touch repeats (standard deviation)
    #[arg(long, default_value_t = Tip::default().repeats_to_mm, value_name = "MM", requires = "poses")]
    pub(in crate::cli) repeats_to: f64,
    /// With --poses: so many touches at most
    #[arg(long, default_value_t = 60, value_name = "COUNT", requires = "poses")]
    pub(in crate::cli) most: usize,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct ProfileName {
    /// A shipped profile's name, or a TOML file
    pub(in crate::cli) profile: String,
}
