//! Arguments that cannot be understood, in words.

use std::io::Write;

use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue, ErrorKind};

use super::Args;
use crate::document::{failed, visible};
use crate::job::{BadSetting, Error, InputError, PrintError, PrinterError, SendError, UploadError};
use crate::publish::BadInput;

/// How Rust's parsers refuse a number, and how a person would.
const REFUSED: [(&str, &str); 4] = [
    ("invalid float literal", "not a number"),
    ("cannot parse float from empty string", "not a number"),
    ("invalid digit found in string", "not a whole number of at least 0"),
    ("cannot parse integer from empty string", "not a whole number of at least 0"),
];

/// A flag that bars a group of others is told with those that were given, not with the whole group.
fn of_those_given(error: &mut clap::Error) {
    let Some(ContextValue::Strings(barred)) = error.get(ContextKind::PriorArg) else { return };
    let words: Vec<String> = std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
    let is_given = |name: &&String| {
        let flag = name.split([' ', '=']).next().unwrap_or_default();
        words.iter().any(|word| word == flag || word.split('=').next() == Some(flag))
    };
    let mut given: Vec<String> = barred.iter().filter(is_given).cloned().collect();
    if given.is_empty() {
        // Then it is what has no flag.
        given = barred.iter().filter(|name| !name.starts_with('-')).cloned().collect();
    }
    let given = match given.len() {
        0 => return,
        1 => ContextValue::String(given.remove(0)),
        _ => ContextValue::Strings(given),
    };
    error.insert(ContextKind::PriorArg, given);
}

/// What is wrong with the arguments, in one line: a list below the first line belongs to it, usage and help do not.
fn sentence(text: &str) -> String {
    let mut lines = text.lines().map(str::trim).take_while(|line| !line.is_empty());
    let first = lines.next().unwrap_or_default();
    let rest: Vec<&str> = lines.collect();
    let whole = if rest.is_empty() { first.to_owned() } else { format!("{first} {}", rest.join(", ")) };
    whole.strip_prefix("error: ").map_or(whole.clone(), str::to_owned)
}

/// What may have been meant, the likeliest; clap puts it last.
fn meant(error: &clap::Error) -> Option<String> {
    let suggested = [ContextKind::SuggestedSubcommand, ContextKind::SuggestedArg, ContextKind::SuggestedValue];
    let found = suggested.iter().find_map(|kind| error.get(*kind))?;
    let word = match found {
        ContextValue::String(word) => word,
        ContextValue::Strings(words) => words.last()?,
        _ => return None,
    };
    Some(format!("the nearest is '{word}'"))
}

/// Where to look: the help of the verb that was asked for, and what stands in for a machine that was not named.
fn help(error: &clap::Error) -> String {
    let is_verb = |word: &String| Args::command().get_subcommands().any(|verb| verb.get_name() == word);
    let words = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    let verb = words.take_while(|word| word != "--").find(is_verb).map(|verb| format!(" {verb}")).unwrap_or_default();
    let lacks = |flag: &str| match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::Strings(names)) if error.kind() == ErrorKind::MissingRequiredArgument => {
            names.iter().any(|name| name.starts_with(flag))
        }
        _ => false,
    };
    match lacks("--machine") {
        true => "trunnion profile list names machines for -m; trunnion profile new NAME describes yours".to_owned(),
        false => format!("trunnion{verb} --help"),
    }
}

/// Prints what is wrong with the arguments, or the help that was asked for.
pub(in crate::cli) fn told(error: &mut clap::Error) -> std::io::Result<()> {
    if !error.use_stderr() {
        return error.print();
    }
    of_those_given(error);
    // Without arguments the help is printed, which is what clap calls an error.
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return error.print();
    }
    let text = error.render().to_string();
    let ours = REFUSED.iter().fold(sentence(&text), |text, (words, ours)| text.replace(words, ours));
    let meant = meant(error).map(|word| format!("; {word}")).unwrap_or_default();
    let (text, help) = (format!("{ours}{meant}"), help(error));
    if std::env::args_os().any(|word| word == "--json") {
        let document = failed("command/usage", &text, 2, None, Some(&help));
        writeln!(std::io::stdout(), "{}", visible(&document.to_string()))?;
    }
    std::io::stderr().write_all(visible(&format!("error: {text}\nhelp: {help}\n")).as_bytes())
}

/// A job's error, with the flag that is its remedy.
pub(in crate::cli) fn in_flags(error: &Error) -> String {
    match error {
        Error::Input(InputError::Setting(BadSetting::SeveralParts { count })) => format!(
            "--landscape and --view show one part, but the model has {count}; choose one with --part N, or pass --whole"
        ),
        Error::Input(InputError::Setting(BadSetting::OutOfRange { name: "models", value, allowed, .. })) => {
            format!(
                "the number of models must be between {} and {}, got {value}; MODEL*3 means three copies",
                allowed[0], allowed[1]
            )
        }
        // Of a plan.
        Error::Input(InputError::Setting(bad @ BadSetting::TooFine { name: "step_mm", .. })) => bad.to_string(),
        Error::Input(InputError::Setting(bad)) => format!("--{bad}"),
        Error::Upload(UploadError::Asked(bad @ (BadInput::Key { .. } | BadInput::Name { .. }))) => bad.to_string(),
        Error::Upload(UploadError::Asked(bad)) => format!("--{bad}"),
        Error::Printer(PrinterError::Simulation(bad)) => format!("--{bad}"),
        Error::Printer(PrinterError::Log { .. }) => format!("--{error}"),
        Error::Print(PrintError::WhichPrint { .. }) => format!("{error}, or give --print N"),
        Error::Send(SendError::Refused { line }) => {
            format!("nothing was moved; pass --yes to continue at line {line} as described above")
        }
        Error::Input(InputError::NoModel { .. }) => format!("{error}; pass its path with --model"),
        other => other.to_string(),
    }
}
