//! Flags of many models, and the words that are left for one of them.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::{Args as ClapArgs, Parser};

use super::{Args, Verb};

/// Many models at once: MODEL is a folder, or a list of models, one a line, that ends in .txt, and -o a folder for the results.
#[derive(ClapArgs)]
pub(in crate::cli) struct BatchArgs {
    /// Number of models to process in parallel [default: number of processors]
    #[arg(help_heading = "Many models (a folder, or a list)", long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(in crate::cli) jobs: Option<u16>,
    /// Process every N-th model from the I-th on (I starts at 0), to share one folder of results among N machines
    #[arg(help_heading = "Many models (a folder, or a list)", long, value_name = "I/N", hide_short_help = true)]
    pub(in crate::cli) share: Option<String>,
    /// Retry models that failed before
    #[arg(help_heading = "Many models (a folder, or a list)", long, hide_short_help = true)]
    pub(in crate::cli) retry: bool,
}

impl BatchArgs {
    /// Whether one was given.
    pub(in crate::cli) fn any(&self) -> bool {
        self.jobs.is_some() || self.share.is_some() || self.retry
    }
}

/// What a verb was given that can do many.
pub(in crate::cli) struct OfMany<'a> {
    pub(in crate::cli) model: &'a Path,
    pub(in crate::cli) machine: Option<&'a str>,
    pub(in crate::cli) output: Option<&'a Path>,
    pub(in crate::cli) flags: &'a BatchArgs,
}

impl Args {
    /// What a verb was given that can do many.
    pub(in crate::cli) fn of_many(&self) -> Option<OfMany<'_>> {
        let (model, machine, output, flags) = match &self.verb {
            Verb::Orient(v) => (&v.model.model, v.profile.as_deref(), v.output.as_deref(), &v.batch),
            Verb::Plan(v) => (&v.model.model, Some(&*v.machine.profile), v.output.as_deref(), &v.batch),
            Verb::Prepare(v) => (&v.model.model, Some(&*v.machine.profile), v.output.as_deref(), &v.batch),
            _ => return None,
        };
        Some(OfMany { model, machine, output, flags })
    }
}

/// Flags whose value is not for one model.
const WITH_VALUE: [&str; 4] = ["--output", "-o", "--jobs", "--share"];
/// Flags that say how it is told.
const ALONE: [&str; 6] = ["--retry", "--json", "--quiet", "-q", "--verbose", "-v"];
/// Flags that name one file for all, or print.
const OF_ONE: [&str; 9] =
    ["--plan-out", "--sheet", "--dry-run", "--preview", "--open", "--port", "--landscape", "--view", "--all"];

/// The words for one model: `all` of the command without what is for many, and without `model`; or why there are none.
pub(in crate::cli) fn words_of_one(all: impl Iterator<Item = OsString>, model: &Path) -> Result<Vec<OsString>, String> {
    let (mut left, mut all, mut found) = (Vec::new(), all, false);
    while let Some(word) = all.next() {
        let text = word.to_string_lossy().into_owned();
        let name = text.split('=').next().unwrap_or_default();
        if let Some(one) = OF_ONE.iter().find(|one| **one == name) {
            return Err(format!("{one} applies to one model only, not to a folder or a list of models; remove {one}"));
        }
        if WITH_VALUE.contains(&name) {
            if name == text {
                all.next();
            }
        } else if text.starts_with("-o") && !text.starts_with("--") || ALONE.contains(&name) || text == "--" {
        } else if !found && word.as_os_str() == model.as_os_str() {
            found = true;
        } else {
            left.push(word);
        }
    }
    // A value of a flag may be spelt as the folder is: whoever reads the words again would then see another model.
    let again = [OsStr::new("trunnion")].into_iter().chain(left.iter().map(OsString::as_os_str));
    let again = again.chain(["--json", "-q", "-o", "x", "--", "a.stl"].map(OsStr::new));
    match Args::try_parse_from(again).as_ref().ok().and_then(Args::of_many) {
        Some(one) if one.model == Path::new("a.stl") => Ok(left),
        _ => Err("the arguments are ambiguous; give one folder or list only, and write a name that looks like a flag as ./FOLDER".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Result<String, String> {
        let all = line.split(' ').map(OsString::from);
        words_of_one(all, Path::new("models")).map(|left| left.join(OsStr::new(" ")).into_string().unwrap())
    }

    #[test]
    fn what_is_left_is_for_one_model() {
        let one = |line| words(line).unwrap();
        assert_eq!(one("orient models --json -o out --objective height --jobs 2"), "orient --objective height");
        assert_eq!(one("--json plan -m generic-ac -oout models --share=0/2 --retry"), "plan -m generic-ac");
        assert_eq!(one("prepare -m generic-ac --output=out -- models"), "prepare -m generic-ac");
        assert!(words("prepare models -m generic-ac -o out --port tcp:x").unwrap_err().contains("--port"));
        assert!(words("orient models --sheet=x.svg -o out").unwrap_err().contains("--sheet"));
        // A profile that is called as the folder is: one of the two is left, whichever.
        assert_eq!(one("plan -m models models -o out"), "plan -m models");
        assert!(words("plan models other.stl -m generic-ac -o out").unwrap_err().contains("./FOLDER"));
    }
}
