//! A project file in the place of a model: the words of the command that it stands for.

use std::ffi::OsString;
use std::path::Path;

use clap::Parser;

use super::Args;
use crate::workbench::{ProjectWords, WorkbenchError, is_project, project_words, unpacked_words};

/// Flags behind which a project file is no value.
const ALONE: [&str; 8] = ["--json", "-q", "--quiet", "-v", "--verbose", "--open", "--retry", "--"];

/// The words of `all`, where `trunnion prepare NAME.trunnion` is the command that the page of that project shows. It is unpacked for it, unless the line
/// is wrong.
///
/// # Errors
///
/// Why the project cannot be opened.
pub(in crate::cli) fn with_project(all: Vec<OsString>) -> Result<Vec<OsString>, WorkbenchError> {
    let text = |word: &OsString| word.to_string_lossy().into_owned();
    let helps = all.iter().any(|word| ["-h", "--help"].contains(&&*text(word)));
    let Some(at) = place(&all).filter(|_| !helps) else { return Ok(all) };
    let given = |flag: &str| all.iter().any(|word| names(&text(word), flag));
    let with = |(words, written): ProjectWords| -> Vec<OsString> {
        let written = written.into_iter().filter(|[flag, _]| !given(flag)).flatten();
        let inside = words.into_iter().skip(1).chain(written).map(OsString::from);
        all[..at].iter().cloned().chain(inside).chain(all[at + 1..].iter().cloned()).collect()
    };
    let project = Path::new(&all[at]);
    let named = with(project_words(project)?);
    // What is wrong with the line is said where it is read, and then nothing has been unpacked.
    if Args::try_parse_from(&named).is_err() {
        return Ok(named);
    }
    Ok(with(unpacked_words(project)?))
}

/// Where the project file stands behind `prepare`.
fn place(all: &[OsString]) -> Option<usize> {
    let verb = all.iter().position(|word| word == "prepare")?;
    let global =
        |word: &OsString| word.to_string_lossy().starts_with('-') || word.to_string_lossy().parse::<u64>().is_ok();
    if !all[1..verb.max(1)].iter().all(global) {
        return None;
    }
    let value = |before: &str| before.starts_with('-') && !before.contains('=') && !ALONE.contains(&before);
    (verb + 1..all.len()).find(|&at| is_project(Path::new(&all[at])) && !value(&all[at - 1].to_string_lossy()))
}

/// Whether `word` is this flag, with its value or without.
fn names(word: &str, flag: &str) -> bool {
    match flag {
        "-o" => word.split('=').next() == Some("--output") || (word.starts_with("-o") && !word.starts_with("--")),
        flag => word.split('=').next() == Some(flag),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_project_is_found_where_a_model_would_be() {
        let at = |line: &str| place(&line.split(' ').map(OsString::from).collect::<Vec<_>>());
        assert_eq!(at("trunnion prepare a.trunnion"), Some(2));
        assert_eq!(at("trunnion --json --max-memory 900 prepare -o x.gcode b/a.TRUNNION -q"), Some(7));
        assert_eq!(at("trunnion prepare --json a.trunnion"), Some(3));
        for line in [
            "trunnion open a.trunnion",
            "trunnion prepare a.stl -o a.trunnion",
            "trunnion inspect prepare a.trunnion",
            "trunnion",
            "trunnion prepare",
        ] {
            assert_eq!(at(line), None, "{line}");
        }
        assert!(
            names("-ox", "-o")
                && names("--output=x", "-o")
                && !names("--objective", "-o")
                && names("--preview=x", "--preview")
        );
    }
}
