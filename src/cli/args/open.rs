//! Flags of `open`.

use std::path::PathBuf;

use clap::Args as ClapArgs;
use clap::builder::NonEmptyStringValueParser;

use super::{MACHINE, MODEL};

#[derive(ClapArgs, Clone)]
#[command(after_help = "\
The page is served to this computer alone, at 127.0.0.1. Without the secret in its address it shows nothing.
Every button of the page runs one command, which is shown at the foot of the page. Ctrl-C ends the workbench.

From another computer, over SSH:
  ssh -L 8080:127.0.0.1:8080 HOST trunnion open --no-browser --port 8080")]
pub(in crate::cli) struct Open {
    /// STL, OBJ, 3MF or OFF files, or one project, NAME.trunnion; more can be dropped on the page
    #[arg(value_name = "MODEL", help_heading = MODEL)]
    pub(in crate::cli) models: Vec<PathBuf>,
    /// A shipped profile's name, or a TOML file; the page has a list of them
    #[arg(help_heading = MACHINE, short = 'm', long = "machine", value_name = "PROFILE", env = "TRUNNION_MACHINE", hide_env_values = true, value_parser = NonEmptyStringValueParser::new())]
    pub(in crate::cli) profile: Option<String>,
    /// Folder for dropped models and for everything that is made [default: the working folder]
    #[arg(long, value_name = "DIR")]
    pub(in crate::cli) folder: Option<PathBuf>,
    /// Port of the page [0: any free port]
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub(in crate::cli) port: u16,
    /// Print the address, and start no browser
    #[arg(long)]
    pub(in crate::cli) no_browser: bool,
}
