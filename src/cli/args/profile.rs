//! Flags of `profile`.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Subcommand};

use super::MachineArgs;
use crate::calibrate::{FitOptions, Tip};
use crate::job::{self, PosesRequest, Source, TowerRequest};

#[derive(Subcommand)]
pub(in crate::cli) enum Profile {
    /// List the shipped profiles, and your own in $XDG_CONFIG_HOME/trunnion/profiles
    List,
    /// Show a profile's values, and where each comes from
    Show(ProfileName),
    /// Check that a profile is consistent, and show what follows from it
    Check(CheckProfile),
    /// Create a profile from answers on a terminal, in flags or in a file
    New(New),
    /// Create a profile from the configuration of a firmware or simulator, with answers for what it lacks
    Import(Import),
    /// Find pivot, offset and zeros from touches at several poses or from a printed tower, or make what is to be measured
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
    /// Name of the new profile
    pub(in crate::cli) name: String,
    /// Profile to start from
    #[arg(long, default_value = "generic-ac", value_name = "PROFILE")]
    pub(in crate::cli) like: String,
    #[command(flatten)]
    pub(in crate::cli) answers: Answers,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Import {
    /// Files of one machine: LinuxCNC's ini, Klipper's printer.cfg, RepRapFirmware's config.g, Marlin's Configuration.h, or machine.json of Koala's simulator
    #[arg(required = true, value_name = "FILE")]
    pub(in crate::cli) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) made: Made,
}

/// What a profile is called and like that is made from what a firmware says.
#[derive(ClapArgs)]
pub(in crate::cli) struct Made {
    /// Name of the new profile [default: as -o, else as the first file, else machine]
    #[arg(long)]
    pub(in crate::cli) name: Option<String>,
    /// Similar profile that gives all other values [default: a shipped one of the same firmware]
    #[arg(long, value_name = "PROFILE")]
    pub(in crate::cli) like: Option<String>,
    #[command(flatten)]
    pub(in crate::cli) answers: Answers,
}

/// What is told of a machine, and where its profile goes.
#[derive(ClapArgs)]
pub(in crate::cli) struct Answers {
    /// An answer: any profile key, for example --set kinematics.tilt.max_deg=60, or a measure of the head (docs/how-to/machine.md); may be repeated
    #[arg(long, value_name = "KEY=VALUE", value_parser = pair)]
    pub(in crate::cli) set: Vec<(String, String)>,
    /// A TOML file of answers
    #[arg(long, value_name = "FILE.toml")]
    pub(in crate::cli) answers: Option<PathBuf>,
    /// Keep the value of the --like profile for every key that is not answered
    #[arg(long)]
    pub(in crate::cli) keep_rest: bool,
    /// Output file [default: NAME.toml in $XDG_CONFIG_HOME/trunnion/profiles]
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

/// Either TOUCHES, --poses or --tower.
#[derive(ClapArgs)]
pub(in crate::cli) struct Calibrate {
    /// Recorded touches (docs/how-to/machine.md), or the measurements of a tower (docs/how-to/tower.md)
    #[arg(required_unless_present_any = ["poses", "tower"])]
    pub(in crate::cli) touches: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,
    /// Output profile, which extends the given one [default: its keys on stdout]
    #[arg(short, long, conflicts_with_all = ["poses", "tower"])]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Largest error of a point on or above the table at which the profile's axis directions are kept; a table that is less level or less flat is refused
    #[arg(long, default_value_t = FitOptions::default().tolerance_mm, value_name = "MM", conflicts_with_all = ["poses", "tower"])]
    pub(in crate::cli) tolerance: f64,
    /// Keep the profile's axis directions; fewer touches are needed
    #[arg(long)]
    pub(in crate::cli) assume_square: bool,
    /// Choose the touches to make, and write a file to fill in
    #[arg(long, value_name = "FILE.toml", conflicts_with = "touches")]
    pub(in crate::cli) poses: Option<PathBuf>,
    /// Make a calibration tower: its program, plan, model, sheet and a file to fill in, in this folder
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["touches", "poses"])]
    pub(in crate::cli) tower: Option<PathBuf>,
    /// With --tower: tilt of its blocks, as the machine counts it; 20 deg where the axes are known to 1 mm only [default: the steepest of 60, 45, 30, 20 deg that passes verification]
    #[arg(long, value_name = "DEG", requires = "tower", allow_negative_numbers = true)]
    pub(in crate::cli) tilt: Option<f64>,
    /// With --poses: G-code that moves slowly to each pose, without heating, and stops there
    #[arg(long, value_name = "FILE.gcode", requires = "poses")]
    pub(in crate::cli) gcode: Option<PathBuf>,
    /// With --poses or --tower: how well one touch or one reading of the callipers repeats (standard deviation)
    #[arg(long, default_value_t = Tip::default().repeats_to_mm, value_name = "MM", conflicts_with = "touches")]
    pub(in crate::cli) repeats_to: f64,
    /// With --poses: standard deviation of X and Y where the tip is aligned with a mark by eye, for example 0.15 [default: --repeats-to]
    #[arg(long, value_name = "MM", requires = "poses")]
    pub(in crate::cli) by_eye: Option<f64>,
    /// With --poses: maximum number of touches
    #[arg(long, default_value_t = 60, value_name = "COUNT", requires = "poses")]
    pub(in crate::cli) most: usize,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct ProfileName {
    /// A shipped profile's name, or a TOML file
    pub(in crate::cli) profile: String,
}

impl Calibrate {
    /// Which tower is to be made.
    pub(in crate::cli) fn tower(&self) -> TowerRequest {
        let machine = self.machine.profile.as_str().into();
        TowerRequest { machine, tilt_deg: self.tilt, repeats_mm: self.repeats_to }
    }

    /// Which touches are to be chosen.
    pub(in crate::cli) fn asked(&self) -> PosesRequest {
        PosesRequest {
            machine: self.machine.profile.as_str().into(),
            repeats_to_mm: self.repeats_to,
            by_eye_mm: self.by_eye,
            most: self.most,
            square: self.assume_square,
        }
    }
}
