//! What of the user's files is shown to the user.

use std::ffi::OsStr;

use crate::location::Location;

/// The line that is at fault, of a text file that the command line names: others (what a profile extends) are not for everybody to see.
/// `None` where the file is not named, is no text any more, or the line is not known.
pub fn shown_line(location: &Location) -> Option<String> {
    let file = location.file.as_ref()?;
    let is_named = |word: std::ffi::OsString| {
        word == OsStr::new(file) || word.to_string_lossy().split_once('=').is_some_and(|(_, value)| value == file)
    };
    let bytes = location.line.filter(|_| std::env::args_os().any(is_named)).and_then(|_| std::fs::read(file).ok())?;
    location.excerpt(std::str::from_utf8(&bytes).ok()?)
}
